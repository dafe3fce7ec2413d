"""Functions of the operating system that differ between systems, with fallbacks.

All that the program needs of a system beyond Python's portable functions is here, except for the
priority of a servo (`haptics.realtime`) and permission to open a device (`device.hid_link`). Tested
on Linux only; the fallbacks are tested there, with Linux's own functions hidden.
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
    "block_termination_signals",
    "blocking_interrupts",
    "copy_permissions",
    "create_locked",
    "discard_output",
    "end_with_parent",
    "flush_file",
    "flush_folder",
    "forbid_opening",
    "give_back_memory",
    "ignore_interrupts",
    "inherit_file",
    "interrupt",
    "is_locked",
    "is_private",
    "limit_process",
    "lock",
    "make_memory_file",
    "open_inherited",
    "reserve_space",
    "this_machine",
    "try_locking",
    "usable_cores",
    "user_id",
]

APPENDING = os.O_WRONLY | os.O_APPEND | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
"""Flags of `os.open` to append bytes as they are, in no process but this one."""
ENDING = tuple(
    getattr(signal, name) for name in ("SIGTERM", "SIGINT", "SIGHUP") if hasattr(signal, name)
)
"""Signals that ask a process to end."""
_LOCK_TIMEOUT_S = 0.3  # `is_locked` may hold a lock for so long where no core is free
_LOCK_RETRY_S = 0.002
_ACCESS_LIST = "system.posix_acl_access"
_STARTED = Path("/proc/sys/kernel/random/boot_id")  # on Linux


def _module(name: str) -> ModuleType | None:
    """Import a module of Python's that not every system has; None if this one has not."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def give_back_memory() -> None:
    """Return freed memory to the system (glibc only, which keeps it for each of many threads)."""
    import ctypes

    with suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)


# -- users and processors -----------------------------------------------------------------------


def user_id() -> int:
    """Return the number of the user who runs this process; 0 where users have none."""
    return os.geteuid() if hasattr(os, "geteuid") else 0


def is_private(folder: Path) -> bool:
    """Return whether it is a folder (no link to one) that this user alone owns and can enter.

    Where users have no numbers, temporary folders are a user's own already.
    """
    status = os.lstat(folder)
    if not stat.S_ISDIR(status.st_mode):
        return False
    if not hasattr(os, "geteuid"):
        return True
    return status.st_uid == os.geteuid() and not status.st_mode & 0o077


def usable_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@cache
def this_machine() -> str:
    """Return eight hexadecimal digits that identify this machine since its last start."""
    name = os.uname().nodename if hasattr(os, "uname") else os.environ.get("COMPUTERNAME", "")
    started = b""
    with suppress(OSError):
        started = _STARTED.read_bytes()
    return f"{zlib.crc32(os.fsencode(name) + started):08x}"


# -- processes ----------------------------------------------------------------------------------


@contextmanager
def blocking_interrupts() -> Iterator[None]:
    """Block termination signals in this thread, and in processes that it starts in the block.

    Those processes call `ignore_interrupts` when they are ready. Other threads still receive the
    signals, which `ending.holding_interrupts` defers. Without effect on systems other than POSIX.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # starting it later would unblock the signals
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


def discard_output(stream: TextIO) -> None:
    """Redirect a stream to the null device: its reader, or its terminal, is gone."""
    with suppress(OSError):  # some streams are no files
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def block_termination_signals() -> None:
    """Block termination signals in the calling thread; other threads receive them."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)


def interrupt() -> None:
    """Interrupt this process's main thread, in a system call too where the system can."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(cast("int", threading.main_thread().ident), signal.SIGINT)
    else:
        _thread.interrupt_main()


def ignore_interrupts() -> None:
    """Ignore interrupts in this process, which its parent will end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)


def end_with_parent(end: Callable[[int], object] = os._exit) -> None:
    """End this process, started by `multiprocessing`, when its parent ends, even if that is killed.

    Parameters
    ----------
    end : callable
        Ends the process with a status; `core.ending.end_now` if it may be writing files.
    """
    from multiprocessing import parent_process  # imported late: most callers only ask for cores

    parent = parent_process()
    if parent is None:
        return

    def wait_for_end() -> None:
        from multiprocessing.connection import wait

        wait([parent.sentinel])  # the system closes it, however the parent ends
        end(1)

    threading.Thread(target=wait_for_end, daemon=True).start()


def limit_process(memory: int, seconds: int) -> None:
    """Limit this process's address space, bytes, and CPU time, s, where the system can.

    It writes no core dump. Elsewhere its parent must end it in time.
    """
    resource = _module("resource")
    if resource is None:
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))


def forbid_opening() -> None:
    """Forbid this process, with all threads, to open further files, where the system can."""
    resource = _module("resource")
    if resource is not None:
        _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (0, hard))


def inherit_file(descriptor: int) -> tuple[int, dict[str, Any]]:
    """Make an open file inheritable by a child process.

    Returns
    -------
    (int, dict)
        Its number for `open_inherited` in the child, and the arguments of `Popen`.
    """
    msvcrt = _module("msvcrt")
    if msvcrt is None:
        return descriptor, {"pass_fds": (descriptor,)}
    handle = msvcrt.get_osfhandle(descriptor)
    os.set_handle_inheritable(handle, True)  # type: ignore[attr-defined]  # Windows only
    return handle, {"close_fds": False}


def open_inherited(number: int) -> int:
    """Return the descriptor of a file inherited from the parent (`inherit_file`)."""
    msvcrt = _module("msvcrt")
    return number if msvcrt is None else msvcrt.open_osfhandle(number, os.O_RDWR)


# -- files --------------------------------------------------------------------------------------


def make_memory_file() -> int:
    """Return the descriptor of a file without a name, which goes with its last descriptor."""
    if hasattr(os, "memfd_create"):
        return os.memfd_create("paint3d")
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())


def lock(file: BinaryIO, timeout_s: float = _LOCK_TIMEOUT_S) -> None:
    """Lock a file for as long as this process lives and keeps it open.

    `is_locked` of another process holds the lock for a moment, which is waited for.

    Raises
    ------
    OSError
        If another process still has the lock after the timeout.
    """
    fcntl, msvcrt = _module("fcntl"), _module("msvcrt")
    until = time.monotonic() + timeout_s
    while True:
        try:
            if fcntl is not None:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            elif msvcrt is not None:
                msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
            return
        except (BlockingIOError, PermissionError):  # from flock, and from msvcrt
            if time.monotonic() >= until:
                raise
        time.sleep(_LOCK_RETRY_S)


def create_locked(path: Path, mode: int = 0o666) -> int | None:
    """Make a file that is locked as long as the returned descriptor is open.

    Its permissions are `mode` without the user's mask. Where the system has no locks the file is
    only made, and None is returned.

    Raises
    ------
    OSError
        If it cannot be made; FileExistsError if it exists, or another process has locked it by
        `try_locking` or removed it meanwhile.
    """
    fcntl = _module("fcntl")
    flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_CLOEXEC", 0)
    descriptor = os.open(path, flags, mode)
    if fcntl is None:
        os.close(descriptor)
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        is_taken = not os.path.lexists(path)  # not by st_nlink: some file systems count no links
    except OSError as cause:  # file systems without locks raise other errors
        is_taken = isinstance(cause, BlockingIOError)
    if is_taken:
        os.close(descriptor)
        raise FileExistsError(f"{path}: locked or removed by another process")
    return descriptor


@contextmanager
def try_locking(path: Path) -> Iterator[bool]:
    """Try to lock a file of `create_locked` within the block; yield whether nobody else has it.

    Yields False where the system has no locks.
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
    """Return whether a living process has locked a file; False if the system has no locks."""
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
    """Copy permissions, group and owner from one file to another, as far as allowed.

    If the group or the access list cannot be copied, the group gets the rights of others: nobody
    gains access to the file.

    Raises
    ------
    OSError
        If the permissions cannot be set.
    """
    status = os.stat(source)
    mode = status.st_mode & 0o777
    is_complete = True
    if hasattr(os, "chown"):
        with suppress(OSError):
            os.chown(target, -1, status.st_gid)
        with suppress(OSError):  # allowed to the superuser alone
            os.chown(target, status.st_uid, -1)
        is_complete = os.stat(target).st_gid == status.st_gid
    access_list = _access_list(source)
    if access_list is not None:
        try:
            os.setxattr(target, _ACCESS_LIST, access_list)
        except OSError:
            is_complete = False
    os.chmod(target, mode if is_complete else (mode & ~0o070) | (mode & (mode << 3) & 0o070))


def _access_list(path: Path) -> bytes | None:
    """Read the access list (POSIX ACL) of a file, as Linux stores it; None if it has none."""
    if not hasattr(os, "getxattr"):
        return None
    try:
        return os.getxattr(path, _ACCESS_LIST)
    except OSError:
        return None


def flush_file(descriptor: int) -> None:
    """Flush a file's data to the disk."""
    (os.fdatasync if hasattr(os, "fdatasync") else os.fsync)(descriptor)


def reserve_space(file: BinaryIO, n_bytes: int) -> None:
    """Allocate disk space for a file of so many bytes; a no-op where the system cannot.

    Raises
    ------
    OSError
        If the disk is too full, or the file may not become so large.
    """
    if n_bytes > 0 and hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file.fileno(), 0, n_bytes)


def flush_folder(folder: Path) -> None:
    """Flush a folder's entries to the disk; a no-op where the system cannot."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
