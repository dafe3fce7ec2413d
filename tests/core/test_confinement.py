"""What a confined process can do no more, by each of two means; and one that cannot be confined."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from paint3d.core.confinement import LANDLOCK, PRIVILEGES, SECCOMP
from paint3d.errors import MeshError
from paint3d.files.load import load_mesh
from paint3d.files.sandbox import read_apart

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Linux confines")

TRIES = """
import os, signal, socket, subprocess, sys, threading

def told(act):
    try:
        act()
    except OSError as cause:
        return type(cause).__name__
    return ""

def try_all(folder):
    os.chdir(folder)
    mine = os.path.join(folder, "mine")
    return {
        "make": told(lambda: open("new", "w")),
        "write": told(lambda: open(mine, "r+")),
        "append": told(lambda: open(mine, "a")),
        "empty": told(lambda: os.truncate(mine, 0)),
        "remove": told(lambda: os.unlink(mine)),
        "rename": told(lambda: os.rename(mine, "other")),
        "folder": told(lambda: os.mkdir("folder")),
        "link": told(lambda: os.link(mine, "linked")),
        "symlink": told(lambda: os.symlink(mine, "linked")),
        "pipe": told(lambda: os.mkfifo("pipe")),
        "run": told(lambda: os.execv("/bin/true", ["true"])),
        "start": told(lambda: subprocess.run(["/bin/true"], check=True)),
        "fork": told(fork),
        "mode": told(lambda: os.chmod(mine, 0o777)),
        "time": told(lambda: os.utime(mine, (0, 0))),
        "tcp": told(lambda: socket.create_connection(("127.0.0.1", 9), 5)),
        "udp": told(lambda: socket.socket(socket.AF_INET, socket.SOCK_DGRAM)),
        "pair": told(lambda: socket.socketpair()),
        "signal": told(lambda: os.kill(os.getppid(), 0)),
        "memory": told(lambda: open("/proc/self/mem", "r+b")),
        # what stays
        "read": told(lambda: open(mine).read()),
        "list": told(lambda: os.listdir(folder)),
        "thread": told(thread),
        "unnamed": told(lambda: os.write(os.memfd_create("x"), b"x")),
    }

def fork():
    child = os.fork()
    if not child:
        os._exit(0)
    os.waitpid(child, 0)

def thread():
    one = threading.Thread(target=lambda: None)
    one.start()
    one.join()
"""
STAYS = ("read", "list", "thread", "unnamed")
FILES = (
    "make",
    "write",
    "append",
    "empty",
    "remove",
    "rename",
    "folder",
    "link",
    "symlink",
    "pipe",
)
BY_LANDLOCK = (*FILES, "pipe", "run", "start", "tcp", "memory")
BY_SECCOMP = (*BY_LANDLOCK, "fork", "mode", "time", "udp", "pair", "signal")


def python(code: str) -> str:
    return python_says(code)[0]


def python_says(code: str) -> tuple[str, str]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code],
        capture_output=True, text=True, check=False, env=environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout, done.stderr


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "mine").write_text("mine")
    return tmp_path


@pytest.mark.parametrize(
    ("without", "means", "refused"),
    [
        ("filter_calls = lambda refused: False", LANDLOCK, BY_LANDLOCK),
        ("_give_up_files = lambda libc: False", SECCOMP, BY_SECCOMP),
    ],
)
def test_each_means_holds_alone(folder: Path, without: str, means: str, refused: tuple[str, ...]):
    code = f"{TRIES}\nimport json\nfrom paint3d.core import confinement\n"
    code += f"confinement.{without}\nholds = confinement.confine_process()\n"
    code += f"print(json.dumps([holds, try_all({os.fspath(folder)!r})]))"
    holds, found = json.loads(python(code))
    if means not in holds:
        pytest.skip(f"this system has no {means}")
    assert holds == [PRIVILEGES, means]
    assert {name: bool(found[name]) for name in (*refused, *STAYS)} == {
        **dict.fromkeys(refused, True),
        **dict.fromkeys(STAYS, False),
    }
    assert (folder / "mine").read_text() == "mine"
    assert os.listdir(folder) == ["mine"]


def test_a_reader_of_strangers_files_is_confined(folder: Path, monkeypatch: pytest.MonkeyPatch):
    (folder / "a_reader_that_tries.py").write_text(
        TRIES + "def read(path, wanted):\n    return {}, try_all(str(path.parent))\n"
    )
    monkeypatch.syspath_prepend(folder)
    _, found = read_apart(folder / "mine", "a_reader_that_tries:read", [])
    if not found["udp"]:
        pytest.skip("this system confines nothing")
    assert {name for name in found if found[name]} >= set(BY_SECCOMP)
    assert not any(found[name] for name in STAYS)


NOWHERE = """
import ctypes, platform
from paint3d.core.confinement import Refused, confine_process, filter_calls
prctl, seccomp = {"x86_64": (157, 317), "aarch64": (167, 277)}[platform.machine()]
ctypes.CDLL(None).prctl(38, 1, 0, 0, 0)
assert filter_calls(Refused(() if MAY else (prctl,), (seccomp, 444)))
assert confine_process() == (("privileges",) if MAY else ())
import hashlib, logging, paint3d
from paint3d.files.photographs import load_photograph
mesh = paint3d.load_mesh(FILE)
paint3d.load_mesh(FILE)  # the second says it no more, nor a picture
load_photograph(PICTURE)
print(hashlib.sha256(mesh.vertices.tobytes() + mesh.faces.tobytes()).hexdigest())
"""


@pytest.mark.parametrize("may", [True, False])
def test_a_system_that_confines_nothing_reads_the_same(tmp_path: Path, may: bool):
    if python("from paint3d.core.confinement import *; print(SECCOMP in confine_process())") != (
        "True\n"
    ):
        pytest.skip("this system cannot take the means away")
    file = tmp_path / "a.off"
    file.write_text("OFF\n3 1 0\n0 0 0\n9 0 0\n0 9 0\n3 0 1 2\n")
    mesh = load_mesh(file)
    picture = tmp_path / "a.png"
    Image.fromarray(np.full((64, 64, 3), 90, np.uint8)).save(picture)
    code = f"MAY, FILE, PICTURE = {may}, {os.fspath(file)!r}, {os.fspath(picture)!r}\n{NOWHERE}"
    wanted = hashlib.sha256(mesh.vertices.tobytes() + mesh.faces.tobytes()).hexdigest()
    out, told = python_says(code)
    assert out.strip() == wanted
    assert told.count("neither Landlock nor seccomp") == 1
    assert f"{file}: its reader was held" in told


def test_errors_and_pictures_come_out_of_a_confined_process(tmp_path: Path):
    (tmp_path / "a.obj").write_text("v 0 0\n")
    with pytest.raises(MeshError, match="expected three numbers"):
        load_mesh(tmp_path / "a.obj")
    Image.fromarray(np.full((4, 4, 3), (200, 30, 30), np.uint8)).save(tmp_path / "a.png")
    (tmp_path / "a.mtl").write_text("newmtl a\nmap_Kd a.png\n")
    text = "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 9 0 0\nv 0 9 0\nvt 0 0\nf 1/1 2/1 3/1\n"
    (tmp_path / "b.obj").write_text(text)
    colours = load_mesh(tmp_path / "b.obj", texture=True).colours
    assert colours is not None
    np.testing.assert_array_equal(colours, [(200, 30, 30)] * 3)
