"""A progress bar for a terminal; in a file or a pipe, a few lines about what takes long."""

from __future__ import annotations

import sys
import threading
import time
from contextlib import suppress
from types import TracebackType
from typing import Self, TextIO

from paint3d.core.machine import block_termination_signals, discard_output

__all__ = ["ProgressBar", "say_if_compiling"]

_WIDTH = 30
_INTERVAL_S = 0.1
_TICK_S = 0.5
_FIRST_LINE_S = 5.0  # in a pipe; each next one after twice the time
_CLEAR = "\r\x1b[K"  # the line
_RUNNER = "###"  # goes to and fro while no progress is known


class ProgressBar:
    """Call it with the fraction done; it draws at most ten times a second and erases itself.

    Used with `with`, it moves on by itself twice a second: with the time left, or, before the first
    call, to and fro. To a stream that is no terminal it writes a line after 5 s, and one each time
    twice as much has passed.

    Parameters
    ----------
    label : str
        Shown before the bar.
    enabled : bool
        False never draws, as for ``--quiet``.
    stream : text file, optional
        To draw on; by default stderr.
    """

    def __init__(self, label: str, *, enabled: bool = True, stream: TextIO | None = None) -> None:
        self._stream = sys.stderr if stream is None else stream
        self._label = label
        self._is_terminal = self._stream.isatty()
        self._enabled = enabled
        self._active = enabled and self._is_terminal
        self._started = time.monotonic()
        self._drawn = -_INTERVAL_S
        self._done: float | None = None
        self._done_at = 0.0  # s after the start: when `_done` changed last
        self._ticks = 0
        self._drawing = threading.Lock()
        self._over = threading.Event()
        self._ticker: threading.Thread | None = None

    def __call__(self, fraction: float) -> None:
        """Show that this fraction, 0 to 1, is done."""
        done = min(max(fraction, 0.0), 1.0)
        if done != self._done:
            self._done, self._done_at = done, time.monotonic() - self._started
        if self._active and time.monotonic() - self._started - self._drawn >= _INTERVAL_S:
            self._draw()

    def note(self, line: str) -> None:
        """Write a line above the bar; to a stream that is no terminal it is just written."""
        with self._drawing:
            self._write(f"{_CLEAR if self._active else ''}{line}\n")
        self._drawn = -_INTERVAL_S

    def _draw(self) -> None:
        self._drawn = time.monotonic() - self._started
        text = self._progress_text()
        if self._done:
            bar = ("#" * round(self._done * _WIDTH)).ljust(_WIDTH, ".")
        else:
            room = _WIDTH - len(_RUNNER)
            at = room - abs(room - self._ticks % (2 * room))
            bar = ("." * at + _RUNNER).ljust(_WIDTH, ".")
        with self._drawing:
            if not self._over.is_set():
                self._write(f"{_CLEAR}{self._label} [{bar}]{text}")

    def _progress_text(self) -> str:
        """Return the fraction done and the time left, or the time taken.

        The time left runs down until the next call; once it is over, it is unknown.
        """
        elapsed, done = time.monotonic() - self._started, self._done
        if not done:
            return f" {elapsed:4.0f} s"
        left = self._done_at / done - elapsed
        if done <= 0.02 or left < 0.0:
            return f" {done:4.0%} {elapsed:4.0f} s"
        return f" {done:4.0%} {left:4.0f} s left"

    def _write(self, text: str) -> None:
        try:
            self._stream.write(text)
            self._stream.flush()
        except OSError:
            if not self._is_terminal:
                raise
            self._active = False  # the terminal is gone; the work goes on
            discard_output(self._stream)

    def _tick(self) -> None:
        block_termination_signals()  # the main thread is to get them
        if not self._is_terminal:
            self._write_lines()
            return
        while not self._over.wait(_TICK_S):
            if time.monotonic() - self._started - self._drawn >= _TICK_S:
                self._ticks += 1
                self._draw()

    def _write_lines(self) -> None:
        after = _FIRST_LINE_S
        with suppress(OSError):  # the pipe has no reader any more
            while not self._over.wait(max(0.0, self._started + after - time.monotonic())):
                self.note(f"{self._label}{self._progress_text()}")
                after *= 2.0

    def __enter__(self) -> Self:
        if self._enabled:
            self._ticker = threading.Thread(target=self._tick, name="progress", daemon=True)
            self._ticker.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._over.set()
        if self._ticker is not None:
            self._ticker.join()
        if self._active:
            with self._drawing:
                self._write(_CLEAR)


# ---- The first run -------------------------------------------------------------------------------
# A note that the loops are being compiled, so that a first run does not look stuck.


_SECONDS = 100


def say_if_compiling(*, quiet: bool) -> None:
    """Write one line to stderr when the loops are yet to be compiled."""
    from paint3d.brush_engine.stroke_loop import paint_samples  # of those needed, compiled last
    from paint3d.core.kernel import is_compiled

    if not quiet and not is_compiled(paint_samples):
        sys.stderr.write(f"compiling the brush (once, about {_SECONDS} s) ...\n")
        sys.stderr.flush()
