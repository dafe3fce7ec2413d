"""What operating systems do each in their own way, and what is done where one cannot do it.

All that the program needs of a system beyond Python's common ground is here, but for the priority
of a servo (`haptics.realtime`) and the right to open a device (`device.hid_link`). Tried on Linux
alone; what stands in elsewhere is tried there, with Linux's own hidden.
"""

from __future__ import annotations

import _thread
import importlib
import os
import signal
import stat
import tempfile
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, BinaryIO, TextIO, cast

__all__ = [
    "APPENDING",
    "ENDING",
    "blocking_interrupts",
    "copy_permissions",
    "discard_output",
    "end_with_parent",
    "flush_file",
    "flush_folder",
    "from_parent",
    "give_back_memory",
    "handed_to_child",
    "hold_new",
    "ignore_interrupts",
    "interrupt",
    "is_locked",
    "is_private",
    "leave_interrupts_to_others",
    "limit_process",
    "lock",
    "make_memory_file",
    "nobodys",
    "open_no_more",
    "reserve_space",
    "this_machine",
    "usable_cores",
    "user_number",
]

APPENDING = os.O_WRONLY | os.O_APPEND | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
"""Flags of `os.open` to append bytes as they are, in no process but this one."""
ENDING = tuple(
    getattr(signal, name) for name in ("SIGTERM", "SIGINT", "SIGHUP") if hasattr(signal, name)
)
"""Signals that ask a process to end."""
_LOOKS_S = 0.3  # that a look whether a file is locked may take where no core is free
_LOOK_AGAIN_S = 0.002
_ACCESS_LIST = "system.posix_acl_access"
_STARTED = Path("/proc/sys/kernel/random/boot_id")  # on Linux


def _module(name: str) -> ModuleType | None:
    """A module of Python's that not every system has."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def give_back_memory() -> None:
    """Hand back to the system what was freed in this process; nothing, where that is not known.

    glibc keeps what lies below anything that is still in use, for each of many threads.
    """
    import ctypes

    with suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)


# -- users and processors -----------------------------------------------------------------------


def user_number() -> int:
    """The number of the user who runs this process; 0 where users have none."""
    return os.geteuid() if hasattr(os, "geteuid") else 0


def is_private(folder: Path) -> bool:
    """Whether it is a folder (no link to one) that this user owns and nobody else can enter.

    Where users have no numbers, temporary folders are a user's own already.
    """
    found = os.lstat(folder)
    if not stat.S_ISDIR(found.st_mode):
        return False
    if not hasattr(os, "geteuid"):
        return True
    return found.st_uid == os.geteuid() and not found.st_mode & 0o077


def usable_cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@cache
def this_machine() -> str:
    """Eight hexadecimal digits that hardly another machine has, or this one when it starts anew."""
    name = os.uname().nodename if hasattr(os, "uname") else os.environ.get("COMPUTERNAME", "")
    started = b""
    with suppress(OSError):
        started = _STARTED.read_bytes()
    return f"{zlib.crc32(os.fsencode(name) + started):08x}"


# -- processes ----------------------------------------------------------------------------------


@contextmanager
def blocking_interrupts() -> Iterator[None]:
    """Keep what asks to end from this thread, and for good from processes that are started here.

    Those call `ignore_interrupts` when they are ready to. Another thread may take it, which the
    main thread hears of all the same: `ending.holding_interrupts` sees to that. Elsewhere than on
    POSIX systems nothing is kept from anybody.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # once more would let interrupts through
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


def discard_output(stream: TextIO) -> None:
    """Let what is written to a stream go nowhere: whoever read it, or its terminal, is gone."""
    with suppress(OSError):  # some streams are no files
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def leave_interrupts_to_others() -> None:
    """Let what asks to end go to this process's other threads, not to this one."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)


def interrupt() -> None:
    """Interrupt this process's main thread, in what it waits for too where that can be done."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(cast("int", threading.main_thread().ident), signal.SIGINT)
    else:
        _thread.interrupt_main()


def ignore_interrupts() -> None:
    """Ignore interrupts in this process: whoever started it is to end it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)


def end_with_parent(end: Callable[[int], object] = os._exit) -> None:
    """Have this process, started by `multiprocessing`, end when its parent does, however it does.

    Not even a parent that is killed leaves it behind: the system closes what they share.

    Parameters
    ----------
    end : callable
        How it ends, with a status; `core.ending.end_now` where it may be writing files.
    """
    from multiprocessing import parent_process  # not wanted by those who only ask for cores

    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_wait_for_end, args=(parent.sentinel, end), daemon=True).start()


def _wait_for_end(sentinel: int, end: Callable[[int], object]) -> None:
    from multiprocessing.connection import wait

    wait([sentinel])
    end(1)


def limit_process(memory: int, seconds: int) -> None:
    """Limit this process, bytes of address space and s of computing, where the system can.

    It leaves no picture of its memory behind. Elsewhere whoever started it ends it in time.
    """
    resource = _module("resource")
    if resource is None:
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))


def open_no_more() -> None:
    """Let this process, and all its threads, open no further file, where the system can."""
    resource = _module("resource")
    if resource is not None:
        _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (0, hard))


def handed_to_child(descriptor: int) -> tuple[int, dict[str, Any]]:
    """What a child is told of an open file, for `from_parent`, and what `Popen` is to be given."""
    msvcrt = _module("msvcrt")
    if msvcrt is None:
        return descriptor, {"pass_fds": (descriptor,)}
    handle = msvcrt.get_osfhandle(descriptor)
    os.set_handle_inheritable(handle, True)  # type: ignore[attr-defined]  # Windows only
    return handle, {"close_fds": False}


def from_parent(number: int) -> int:
    """The descriptor of a file that the parent handed over."""
    msvcrt = _module("msvcrt")
    return number if msvcrt is None else msvcrt.open_osfhandle(number, os.O_RDWR)


# -- files --------------------------------------------------------------------------------------


def make_memory_file() -> int:
    """Return the descriptor of a file that has no name and is gone when the last one closes it."""
    if hasattr(os, "memfd_create"):
        return os.memfd_create("paint3d")
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())


def lock(file: BinaryIO, patience_s: float = _LOOKS_S) -> None:
    """Lock a file for as long as this process lives and keeps it open.

    Whoever only looks whether it is locked (`is_locked`) has it for a moment, which is waited for.

    Raises
    ------
    OSError
        If another process has it, and still has it after so long.
    """
    fcntl, msvcrt = _module("fcntl"), _module("msvcrt")
    until = time.monotonic() + patience_s
    while True:
        try:
            if fcntl is not None:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            elif msvcrt is not None:
                msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
            return
        except (BlockingIOError, PermissionError):  # as each tells it
            if time.monotonic() >= until:
                raise
        time.sleep(_LOOK_AGAIN_S)


def hold_new(path: Path, mode: int = 0o666) -> int | None:
    """Make a file that is locked for as long as a descriptor is open, which is returned.

    Its permissions are `mode` less what the user's mask takes away. Where the system has no locks
    the file is only made, and there is no descriptor.

    Raises
    ------
    OSError
        If it cannot be made; FileExistsError where it is there, or was taken away by `nobodys`.
    """
    fcntl = _module("fcntl")
    flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_CLOEXEC", 0)
    descriptor = os.open(path, flags, mode)
    if fcntl is None:
        os.close(descriptor)
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        is_taken = not os.path.lexists(path)  # not by links: some file systems count none
    except OSError as cause:  # others are told by file systems without locks
        is_taken = isinstance(cause, BlockingIOError)
    if is_taken:
        os.close(descriptor)
        raise FileExistsError(f"{path}: taken away")
    return descriptor


@contextmanager
def nobodys(path: Path) -> Iterator[bool]:
    """Whether nobody holds a file that `hold_new` made; whoever just makes it finds it taken.

    False where that cannot be known.
    """
    fcntl = _module("fcntl")
    if fcntl is None:
        yield False
        return
    with open(path, "rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            yield False
        else:
            yield True


def is_locked(path: Path) -> bool:
    """Whether a living process has locked a file; False where that cannot be known."""
    fcntl, msvcrt = _module("fcntl"), _module("msvcrt")
    try:
        with open(path, "rb") as file:
            if fcntl is not None:
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            elif msvcrt is not None:
                msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
                msvcrt.locking(file.fileno(), msvcrt.LK_UNLCK, 1)
    except BlockingIOError:
        return True
    except PermissionError:
        return msvcrt is not None
    except OSError:
        return False
    return False


def copy_permissions(source: Path, target: Path) -> None:
    """Give a file the permissions, the group and the owner of another one, as far as allowed.

    Where the group or the access list cannot be kept, the group may do no more than everybody:
    nobody gains access to the file.

    Raises
    ------
    OSError
        If the permissions cannot be set.
    """
    found = os.stat(source)
    mode = found.st_mode & 0o777
    kept = True
    if hasattr(os, "chown"):
        with suppress(OSError):
            os.chown(target, -1, found.st_gid)
        with suppress(OSError):  # allowed to the superuser alone
            os.chown(target, found.st_uid, -1)
        kept = os.stat(target).st_gid == found.st_gid
    access_list = _access_list(source)
    if access_list is not None:
        try:
            os.setxattr(target, _ACCESS_LIST, access_list)
        except OSError:
            kept = False
    os.chmod(target, mode if kept else (mode & ~0o070) | (mode & (mode << 3) & 0o070))


def _access_list(path: Path) -> bytes | None:
    """The access list (POSIX ACL) of a file, as Linux stores it; None where it has none."""
    if not hasattr(os, "getxattr"):
        return None
    try:
        return os.getxattr(path, _ACCESS_LIST)
    except OSError:
        return None


def flush_file(descriptor: int) -> None:
    """Bring what was written to the disk."""
    (os.fdatasync if hasattr(os, "fdatasync") else os.fsync)(descriptor)


def reserve_space(file: BinaryIO, n_bytes: int) -> None:
    """Make sure that a file has room on the disk for so many bytes; nothing, where none can.

    Raises
    ------
    OSError
        If the disk is too full, or the file may not become so large.
    """
    if n_bytes > 0 and hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file.fileno(), 0, n_bytes)


def flush_folder(folder: Path) -> None:
    """Bring a folder's names to the disk; systems that cannot do so are left in peace."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
