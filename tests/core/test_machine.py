"""What only some systems have stands in one place, and without it the program works too."""

from __future__ import annotations

import ast
import ctypes
import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import paint3d
from paint3d.core.machine import give_back_memory, is_locked, lock

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
        "SIGXCPU", "SIGXFSZ", "alarm", "pthread_kill", "pthread_sigmask", "setitimer", "sigwait",
    },
    "mmap": {"PROT_READ", "PROT_WRITE", "MAP_SHARED", "MAP_PRIVATE"},
}  # fmt: skip
ANY = re.compile(rf"\b({'|'.join([*MODULES, *(n for names in NAMES.values() for n in names)])})\b")
# What may stand elsewhere: the priority of a servo, and the right to open a device; and what runs
# only where a system ends processes by signals.
ALLOWED = {
    "haptics/realtime.py": {"os.sched_setscheduler", "os.sched_param", "os.uname"},
    "bench/virtual_stylus.py": {"os.sched_setscheduler", "os.sched_param"},
    "device/hid_link.py": {"os.O_NONBLOCK"},
    "files/sandbox.py": {"signal.SIGXCPU", "signal.SIGKILL"},
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
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, recoverable

if __name__ == "__main__":
    assert paint3d.load_mesh("a.obj").n_faces == 1
    document = Document.new("a.obj", 5.0)
    sitting = RecoveryFolder(document, Path("sittings"))
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


def test_memory_that_was_freed_below_what_is_used_is_given_back() -> None:
    c = ctypes.CDLL(None)
    if not hasattr(c, "malloc_trim"):
        pytest.skip("another library of C than glibc")
    c.malloc.restype, c.free.argtypes = ctypes.c_void_p, [ctypes.c_void_p]
    c.memset.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_size_t]
    blocks = [c.malloc(60_000) for _ in range(2000)]  # 120 MB
    for block in blocks:
        c.memset(block, 1, 60_000)
    for block in blocks[:-1]:
        c.free(block)
    kept = _resident_mb()
    give_back_memory()
    given_back = kept - _resident_mb()
    c.free(blocks[-1])
    assert given_back > 80.0


def _resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text("ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def test_a_look_whether_a_file_is_locked_keeps_nobody_from_locking_it(tmp_path: Path) -> None:
    """A look takes the lock for a moment: a sitting that began just then could not be kept."""
    fcntl = pytest.importorskip("fcntl")
    file = tmp_path / "lock"
    file.write_bytes(b"")
    with open(file, "rb") as look, open(file, "ab") as own, open(file, "ab") as other:
        fcntl.flock(look, fcntl.LOCK_SH)
        with pytest.raises(BlockingIOError):
            lock(own, 0.0)
        over = threading.Timer(0.05, fcntl.flock, (look, fcntl.LOCK_UN))
        over.start()
        lock(own, 60.0)
        over.join()
        assert is_locked(file)
        with pytest.raises(BlockingIOError):  # whoever works with it is not waited for
            lock(other)


def test_many_begin_while_others_look(tmp_path: Path) -> None:
    over = threading.Event()

    def look() -> None:
        while not over.is_set():
            for file in tmp_path.iterdir():
                is_locked(file)

    looking = [threading.Thread(target=look) for _ in range(2)]
    for one in looking:
        one.start()
    try:
        for k in range(100):
            with open(tmp_path / f"{k % 5}", "ab") as file:
                lock(file, 60.0)
    finally:
        over.set()
        for one in looking:
            one.join()
