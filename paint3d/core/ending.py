"""Ending when asked to, as by ``kill`` or a closed terminal, without leaving half a file behind.

Files that are being written have temporary names, which are known here until they have their own.
A command that is asked to end does so as when it is interrupted; one that computes, and hears
nothing, is ended after a while by a thread beside it.
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
    leave_interrupts_to_others,
    open_no_more,
)

__all__ = [
    "AskedToEnd",
    "Ends",
    "begin_file",
    "end_now",
    "forget_file",
    "holding_interrupts",
    "remove_unfinished",
    "signals_handled_by",
]

_PATIENCE_S = 3.0
_STOP = b"\0"  # no signal has that number

_making = threading.RLock()
_unfinished: dict[Path, int] = {}  # and by which process: a forked one knows its parent's, too


class AskedToEnd(KeyboardInterrupt):
    """Somebody has asked this process to end, which is an interrupt of another kind."""


def begin_file(make: Callable[[], Path]) -> Path:
    """Make a file that is unfinished until `forget_file` is told so."""
    with _making:
        path = make()
        _unfinished[path] = os.getpid()
    return path


def forget_file(path: Path) -> None:
    """Know that a file has got its own name, or is gone."""
    _unfinished.pop(path, None)


def remove_unfinished() -> None:
    """Remove what this process is writing."""
    for path, process in list(_unfinished.items()):
        if process == os.getpid():
            with suppress(OSError):
                path.unlink()
            forget_file(path)


def end_now(status: int) -> None:
    """End this process, whatever its threads are at; what it was writing is removed."""
    with _making:  # nothing more is begun
        open_no_more()  # or a thread that is about to write makes anew what was removed
        remove_unfinished()
        os._exit(status)


@contextmanager
def signals_handled_by(hear: Callable[[int], object], *, patiently: bool = True) -> Iterator[None]:
    """Have somebody else told, in the main thread, by which signal this process is asked to end.

    What is ignored, as by what a shell runs behind, stays so. In another thread nothing is heard.
    Not `patiently`, `Ends` knows of it, too, and ends the process after its time.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    all_before = {number: signal.getsignal(number) for number in ENDING}
    before = {n: heard for n, heard in all_before.items() if heard not in (None, signal.SIG_IGN)}
    woken = signal.set_wakeup_fd(-1) if patiently else None
    try:
        for number in before:
            signal.signal(number, lambda number, _: hear(number))
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if woken is not None:
            signal.set_wakeup_fd(woken)


@contextmanager
def holding_interrupts() -> Iterator[None]:
    """Hold back what asks to end, in the main thread, until this is over.

    Whatever thread takes it, those of libraries too; `Ends` has no more patience than else. Who
    starts processes meanwhile keeps it from them, too, by `machine.blocking_interrupts`.
    """
    held: list[int] = []
    try:
        with signals_handled_by(held.append, patiently=False):
            yield
    finally:
        for number in held[:1]:  # the first one tells how this process ends
            signal.raise_signal(number)


class Ends:
    """Hears meanwhile that the process is asked to end, and raises `AskedToEnd` in its main thread.

    Parameters
    ----------
    patience_s : float
        After so long it ends all the same; 0: at once, and nothing is raised.

    Attributes
    ----------
    status : int
        What a process ends with that was asked to, as shells have it; 0: it was not asked.
    """

    def __init__(self, patience_s: float = _PATIENCE_S) -> None:
        self.status = 0
        self._patience_s = patience_s
        self._heard: list[int] = []
        self._thread: threading.Thread | None = None
        self._over = threading.Event()

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():  # which alone may ask for it
            self._heard = [n for n in ENDING if signal.getsignal(n) is signal.SIG_DFL]
        if self._heard and hasattr(signal, "pthread_kill"):  # elsewhere pipes tell of no signals
            self._read, self._write = os.pipe()
            os.set_blocking(self._write, False)
            self._before = signal.set_wakeup_fd(self._write, warn_on_full_buffer=False)
            self._thread = threading.Thread(target=self._watch, name="paint3d-end", daemon=True)
            self._thread.start()
        for number in self._heard:
            signal.signal(number, self._hear)
        _hearing.append(self)
        return self

    def __exit__(self, *error: object) -> None:
        if self in _hearing:
            _hearing.remove(self)
        for number in self._heard:
            signal.signal(number, signal.SIG_DFL)
        if self._thread is not None:
            signal.set_wakeup_fd(self._before)
            self._over.set()
            os.write(self._write, _STOP)
            self._thread.join()
            os.close(self._read)
            os.close(self._write)

    def leave_to_parent(self) -> None:
        """Hear nothing in a process that was forked, whose signals its parent would be told of."""
        if self._thread is not None:
            signal.set_wakeup_fd(-1)
        for number in self._heard:
            signal.signal(number, signal.SIG_DFL)
        self._heard, self._thread = [], None

    def _hear(self, number: int, frame: FrameType | None) -> None:
        is_first, self.status = not self.status, 128 + number
        if is_first and self._patience_s > 0.0:
            raise AskedToEnd

    def _pass_on(self, number: int) -> None:
        """Tell of a signal whoever was told before, such as asyncio's loop around this program."""
        if self._before >= 0:
            with suppress(OSError):
                os.write(self._before, bytes([number]))

    def _watch(self) -> None:
        """Wait for signals: they are told here even where the main thread is in a kernel."""
        leave_interrupts_to_others()  # one taken here is raised there, even what is held back
        while True:
            for number in os.read(self._read, 64):
                if number == _STOP[0]:
                    return
                if number not in self._heard:
                    self._pass_on(number)
                    continue
                if self._over.wait(self._patience_s):
                    return
                end_now(128 + number)


_hearing: list[Ends] = []


def _leave_to_parent() -> None:
    for ends in _hearing:
        ends.leave_to_parent()
    _hearing.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)
