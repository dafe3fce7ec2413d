"""Termination by signals, as from ``kill`` or a closed terminal, without half a file left behind.

Files that are being written have temporary names, which are listed here until they are renamed. A
command that gets a signal ends as when it is interrupted; one that is in a kernel, where Python
handles no signals, is ended after a grace period by a watching thread.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Self

from paint3d.core.machine import (
    ENDING,
    block_termination_signals,
    forbid_opening,
)

__all__ = [
    "TerminationHandler",
    "TerminationRequested",
    "begin_file",
    "end_now",
    "forget_file",
    "holding_interrupts",
    "remove_unfinished",
    "signals_handled_by",
]

_GRACE_S = 3.0
_STOP = b"\0"  # no signal has that number

_making = threading.RLock()
_unfinished: dict[Path, int] = {}  # with the process: a forked one inherits its parent's


class TerminationRequested(KeyboardInterrupt):
    """This process got a termination signal."""


def begin_file(make: Callable[[], Path]) -> Path:
    """Make a file and list it as unfinished, until `forget_file`."""
    with _making:
        path = make()
        _unfinished[path] = os.getpid()
    return path


def forget_file(path: Path) -> None:
    """Take a file off the list: it has its own name, or is gone."""
    _unfinished.pop(path, None)


def remove_unfinished() -> None:
    """Remove the files that this process is writing."""
    for path, process in list(_unfinished.items()):
        if process == os.getpid():
            with suppress(OSError):
                path.unlink()
            forget_file(path)


def end_now(status: int) -> None:
    """End this process at once, whatever its threads do; unfinished files are removed."""
    with _making:  # no further file is begun
        forbid_opening()  # or a thread that is about to write would make a removed file again
        remove_unfinished()
        os._exit(status)


@contextmanager
def signals_handled_by(
    handler: Callable[[int], object], *, patiently: bool = True
) -> Iterator[None]:
    """Install a handler of the termination signals within the block (main thread only).

    Signals that are ignored, as in a shell's background jobs, stay so. In other threads nothing is
    installed. If not `patiently`, `TerminationHandler` sees the signals, too, and ends the process
    after its grace period.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    all_before = {number: signal.getsignal(number) for number in ENDING}
    before = {n: old for n, old in all_before.items() if old not in (None, signal.SIG_IGN)}
    wakeup_fd = signal.set_wakeup_fd(-1) if patiently else None
    try:
        for number in before:
            signal.signal(number, lambda number, _: handler(number))
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old)
        if wakeup_fd is not None:
            signal.set_wakeup_fd(wakeup_fd)


@contextmanager
def holding_interrupts() -> Iterator[None]:
    """Defer termination signals until the end of the block (main thread only).

    They are deferred whichever thread receives them, those of libraries included; the grace period
    of `TerminationHandler` runs meanwhile. Processes that are started in the block are kept from
    them by `machine.blocking_interrupts`.
    """
    received: list[int] = []
    try:
        with signals_handled_by(received.append, patiently=False):
            yield
    finally:
        for number in received[:1]:  # the first one decides the exit status
            signal.raise_signal(number)


class TerminationHandler:
    """Raises `TerminationRequested` in the main thread at a termination signal, within a block.

    Parameters
    ----------
    grace_s : float
        Time after which the process is ended all the same; 0: at once, and nothing is raised.

    Attributes
    ----------
    status : int
        Exit status for the signal, as shells have it; 0: there was none.
    """

    def __init__(self, grace_s: float = _GRACE_S) -> None:
        self.status = 0
        self._grace_s = grace_s
        self._handled: list[int] = []
        self._thread: threading.Thread | None = None
        self._over = threading.Event()

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():  # others may set no handlers
            self._handled = [n for n in ENDING if signal.getsignal(n) is signal.SIG_DFL]
        if self._handled and hasattr(signal, "pthread_kill"):  # elsewhere no pipe is a wakeup fd
            self._read, self._write = os.pipe()
            os.set_blocking(self._write, False)
            self._before = signal.set_wakeup_fd(self._write, warn_on_full_buffer=False)
            self._thread = threading.Thread(target=self._watch, name="paint3d-end", daemon=True)
            self._thread.start()
        for number in self._handled:
            signal.signal(number, self._handle)
        _active.append(self)
        return self

    def __exit__(self, *error: object) -> None:
        if self in _active:
            _active.remove(self)
        for number in self._handled:
            signal.signal(number, signal.SIG_DFL)
        if self._thread is not None:
            signal.set_wakeup_fd(self._before)
            self._over.set()
            os.write(self._write, _STOP)
            self._thread.join()
            os.close(self._read)
            os.close(self._write)

    def detach(self) -> None:
        """Handle nothing in a forked process, which would write to its parent's wakeup pipe."""
        if self._thread is not None:
            signal.set_wakeup_fd(-1)
        for number in self._handled:
            signal.signal(number, signal.SIG_DFL)
        self._handled, self._thread = [], None

    def _handle(self, number: int, frame: FrameType | None) -> None:
        is_first, self.status = not self.status, 128 + number
        if is_first and self._grace_s > 0.0:
            raise TerminationRequested

    def _watch(self) -> None:
        """Wait for signals: the wakeup pipe gets them even while the main thread is in a kernel."""
        block_termination_signals()  # one received here would be raised there, even a deferred one
        while True:
            for number in os.read(self._read, 64):
                if number == _STOP[0]:
                    return
                if number not in self._handled:
                    if self._before >= 0:  # to the wakeup fd before, such as that of asyncio
                        with suppress(OSError):
                            os.write(self._before, bytes([number]))
                    continue
                if self._over.wait(self._grace_s):
                    return
                end_now(128 + number)


_active: list[TerminationHandler] = []


def _detach_all() -> None:
    for handler in _active:
        handler.detach()
    _active.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_detach_all)
