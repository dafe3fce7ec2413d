"""What operating systems do each in their own way, and what is done where one cannot do it."""

from __future__ import annotations

import os
import signal
import stat
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = [
    "end_with_parent",
    "holding_interrupts",
    "ignore_interrupts",
    "is_private",
    "usable_cores",
    "user_number",
]


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


@contextmanager
def holding_interrupts() -> Iterator[None]:
    """Hold interrupts back meanwhile, here and for good in processes that are started here.

    Those call `ignore_interrupts` when they are ready to. Elsewhere than on POSIX systems nothing
    is held back.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # once more would let interrupts through
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


def ignore_interrupts() -> None:
    """Ignore interrupts in this process: whoever started it is to end it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def end_with_parent() -> None:
    """Have this process, started by `multiprocessing`, end when its parent does, however it does.

    Not even a parent that is killed leaves it behind: the system closes what they share.
    """
    from multiprocessing import parent_process  # not wanted by those who only ask for cores

    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_wait_for_end, args=(parent.sentinel,), daemon=True).start()


def _wait_for_end(sentinel: int) -> None:
    from multiprocessing.connection import wait

    wait([sentinel])
    os._exit(1)
