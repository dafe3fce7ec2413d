"""Reading a stranger's file in a process of its own, which may crash alone.

A reader may be wrong about a file nobody has seen before: it may loop, ask for all memory, or
take the process down with it. Started afresh (a fork of a process with threads is not safe), the
child costs about 0.2 s and loads NumPy and one reader.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

from paint3d.errors import MeshError
from paint3d.files.handover import make_memory_file, receive
from paint3d.files.reading import Reading, Wanted
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["MAX_MEMORY", "MAX_SECONDS", "read_apart"]

MAX_MEMORY = 2 << 30
MAX_SECONDS = 20
START = "import sys, json; sys.path[:] = json.loads(sys.argv.pop()); \
from paint3d.files.child import main; main()"


def read_apart(path: Path, wanted: Wanted, seconds: float = MAX_SECONDS) -> Reading:
    """Read a mesh file in a child process with 2 GiB of memory and 20 s.

    Raises
    ------
    MeshError
        As the reader says, or that it crashed, took too long or needed too much memory.
    """
    descriptor = make_memory_file()
    try:
        _run(path, wanted, descriptor, seconds)
        return _received(path, descriptor)
    finally:
        os.close(descriptor)


def _run(path: Path, wanted: Wanted, descriptor: int, seconds: float) -> None:
    request = {
        "path": os.fsencode(path).hex(),
        "wanted": list(wanted),
        "descriptor": descriptor,
        "memory": MAX_MEMORY,
        "seconds": int(seconds) + 1,
    }
    command = [sys.executable, "-I", "-W", "ignore", "-c", START]
    command += [json.dumps(request), json.dumps([os.path.abspath(entry) for entry in sys.path])]
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,  # nothing comes, but its end tells at once that the child ended
            stderr=subprocess.DEVNULL,
            pass_fds=(descriptor,),
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},  # its threads reserve memory
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise MeshError(
            f"{path}: reading it took longer than {seconds:g} s; expected a simpler file"
        ) from None
    if done.returncode < 0:
        number = -done.returncode
        if number in (signal.SIGXCPU, signal.SIGKILL):
            raise MeshError(f"{path}: reading it took too long or too much memory")
        raise MeshError(f"{path}: reading it crashed ({signal.Signals(number).name})")


def _received(path: Path, descriptor: int) -> Reading:
    try:
        arrays, facts = receive(descriptor)
    except MeshError as cause:
        raise MeshError(
            f"{path}: {cause}: it takes more than {MAX_MEMORY >> 30} GiB, or its reader failed"
        ) from None
    if "error" in facts:
        raise MeshError(str(facts["error"]))
    mesh = TriangleMesh(
        arrays["vertices"],
        arrays["faces"],
        arrays.get("colours"),
        str(facts["name"]),
        arrays.get("normals"),
    )
    return Reading(mesh, tuple(map(str, facts["notes"])))
