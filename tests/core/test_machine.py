"""What only some systems have stands in one place, and without it the program works too."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import paint3d

PACKAGE = Path(paint3d.__file__).parent
# As on a system that is not POSIX: Python's modules and names that such a one lacks.
MODULES = {"fcntl", "grp", "pty", "pwd", "resource", "syslog", "termios", "tty"}
NAMES = {
    "os": {
        "O_CLOEXEC", "O_NONBLOCK", "O_NOFOLLOW", "fdatasync", "fork", "forkpty", "getegid",
        "geteuid", "getgid", "getpgid", "getuid", "killpg",
        "memfd_create", "mkfifo", "posix_fallocate", "sched_getaffinity", "sched_param",
        "sched_setaffinity", "sched_setscheduler", "sched_yield", "setsid", "uname", "wait4",
    },
    "signal": {
        "ITIMER_REAL", "SIGALRM", "SIGCHLD", "SIGHUP", "SIGKILL", "SIGPIPE", "SIGUSR1", "SIGUSR2",
        "SIGXCPU", "SIGXFSZ", "alarm", "pthread_sigmask", "setitimer", "sigwait",
    },
    "mmap": {"PROT_READ", "PROT_WRITE", "MAP_SHARED", "MAP_PRIVATE"},
}  # fmt: skip
ANY = re.compile(rf"\b({'|'.join([*MODULES, *(n for names in NAMES.values() for n in names)])})\b")
# What may stand elsewhere: the priority of a servo, and the right to open a device; and what runs
# only where a system ends processes by signals.
ALLOWED = {
    "haptics/realtime.py": {"os.sched_setscheduler", "os.sched_param", "os.uname"},
    "device/force/virtual_stylus.py": {"os.sched_setscheduler", "os.sched_param"},
    "device/permission.py": {"os.O_NONBLOCK"},
    "files/sandbox/isolation.py": {"signal.SIGXCPU", "signal.SIGKILL"},
}

HIDE = f"""
import os, signal, sys
for name in {sorted(MODULES)!r}:
    sys.modules[name] = None
import mmap, multiprocessing, numba, subprocess, tempfile  # who ask by themselves
for module, names in { ({k: sorted(v) for k, v in NAMES.items()})!r}.items():
    for name in names:
        if hasattr(sys.modules[module], name):
            delattr(sys.modules[module], name)
"""


def run(code: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = {"PYTHONPATH": os.pathsep.join(sys.path), "QT_QPA_PLATFORM": "offscreen"}
    return subprocess.run(
        [sys.executable, "-W", "ignore", "-c", HIDE + code],
        capture_output=True, text=True, check=False, cwd=cwd, env={**os.environ, **environment},
    )  # fmt: skip


def test_no_other_file_asks_for_what_some_systems_lack() -> None:
    found = []
    for file in sorted(PACKAGE.rglob("*.py")):
        where = file.relative_to(PACKAGE).as_posix()
        text = file.read_text("utf-8")
        if where == "core/machine.py" or not ANY.search(text):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Import):
                used = {alias.name for alias in node.names} & MODULES
            elif isinstance(node, ast.ImportFrom):
                used = {node.module} & MODULES
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                name = node.value.id
                used = {f"{name}.{node.attr}"} if node.attr in NAMES.get(name, ()) else set()
            else:
                continue
            found += [f"{where}:{node.lineno}: {one}" for one in used - ALLOWED.get(where, set())]
    assert found == []


def test_everything_is_imported_where_they_are_missing(tmp_path: Path) -> None:
    names = [
        ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts)
        for file in sorted(PACKAGE.rglob("*.py"))
        if file.stem not in ("__init__", "__main__", "warm")
    ]
    code = f"""
import importlib
for name in {names!r}:
    try:
        importlib.import_module(name)
    except ImportError as cause:
        assert cause.name and not cause.name.startswith("paint3d"), (name, cause)
        assert cause.name.split(".")[0] in ("xatlas", "websockets", "distributed"), (name, cause)
print(len(sys.modules))
"""
    pytest.importorskip("PySide6")
    done = run(code, tmp_path)
    assert done.returncode == 0, done.stderr[-2000:]


def test_a_stranger_s_file_is_read_and_a_sitting_is_kept_without_them(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 90 0 0\nv 0 90 0\nf 1 2 3\n")
    code = """
from pathlib import Path
import paint3d
from paint3d.app.model.document import Document
from paint3d.app.model.persistence.sitting import Sitting, recoverable

if __name__ == "__main__":
    assert paint3d.load_mesh("a.obj").n_faces == 1
    document = Document.new("a.obj", 5.0)
    sitting = Sitting(document, Path("sittings"))
    document.modified = True
    sitting.save_base(document)
    sitting.close(keep=True)
    (found,) = recoverable(Path("sittings"))
    assert found.recover().document.surface.source.n_faces == 1
    paint3d.export(document.surface, "a.glb")
    print(os.path.getsize("a.glb"))
"""
    done = run(code, tmp_path)
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(done.stdout) > 100
