"""The program in processes that are forked from one which has imported what it needs, and painted.

Starting Python, importing and loading kernels is most of what a short command costs.
"""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import tempfile
from multiprocessing.context import ForkServerContext
from pathlib import Path

from paint3d.files.reading import READERS

__all__ = ["COMMANDS", "LIMIT_S", "forkserver", "run_forked"]

COMMANDS = {"replay", "export", "inks", "report"}  # commands that start no processes themselves
_PRELOADED = [__name__, "paint3d.cli.main", "paint3d.files.export", "tests.support.warm"]
_PRELOADED += ["tests.support.forked_reading"]
_PRELOADED += [f"paint3d.files.formats.{name.partition(':')[0]}" for name in set(READERS.values())]
_PRELOADED += ["PIL.ImageCms", "scipy.sparse.csgraph", "scipy.spatial", "shapely", "lxml.etree"]
_PRELOADED += ["trimesh", "collada"]  # what is not there is passed over
LIMIT_S = 600.0


def forkserver() -> ForkServerContext:
    """Return the context of the fork server, which is started once."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(_PRELOADED)
    return context


def _be_the_command(arguments: list[str], folder: str, cwd: Path | None) -> None:
    """The program in a process that was forked when its modules were there already."""
    from paint3d.cli.main import main

    for number, name in ((1, "out"), (2, "err")):
        file = os.open(f"{folder}/{name}", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, number)
        os.close(file)
    if cwd is not None:
        os.chdir(cwd)
    sys.argv = ["paint3d", *arguments]
    sys.exit(main(arguments))


def run_forked(arguments: list[str], cwd: Path | None) -> subprocess.CompletedProcess[str]:
    """Run one of `COMMANDS` with its arguments, as `subprocess.run` does."""
    with tempfile.TemporaryDirectory() as folder:
        process = forkserver().Process(target=_be_the_command, args=(arguments, folder, cwd))
        process.start()
        process.join(LIMIT_S)
        if process.is_alive():
            process.kill()
            raise subprocess.TimeoutExpired(["paint3d", *arguments], LIMIT_S)
        out, err = ((Path(folder) / name).read_text("utf-8") for name in ("out", "err"))
    return subprocess.CompletedProcess(arguments, process.exitcode, out, err)
