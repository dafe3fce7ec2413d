"""A progress bar for a terminal; silent when stderr is a file or a pipe."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Self, TextIO

__all__ = ["ProgressBar"]

_WIDTH = 30
_INTERVAL_S = 0.1


class ProgressBar:
    """Call it with the fraction done; it draws at most ten times a second and erases itself.

    Parameters
    ----------
    label : str
        Shown before the bar.
    enabled : bool
        False never draws, as for ``--quiet``.
    stream : text file, optional
        Where to draw: stderr unless told. Nothing is drawn unless it is a terminal.
    """

    def __init__(self, label: str, *, enabled: bool = True, stream: TextIO | None = None) -> None:
        self._stream = sys.stderr if stream is None else stream
        self._label = label
        self._active = enabled and self._stream.isatty()
        self._started = time.monotonic()
        self._drawn = -_INTERVAL_S

    def __call__(self, fraction: float) -> None:
        """Show that this fraction, 0 to 1, is done."""
        elapsed = time.monotonic() - self._started
        if not self._active or elapsed - self._drawn < _INTERVAL_S:
            return
        self._drawn = elapsed
        done = min(max(fraction, 0.0), 1.0)
        bar = ("#" * round(done * _WIDTH)).ljust(_WIDTH, ".")
        left = f" {elapsed * (1 - done) / done:4.0f} s left" if done > 0.02 else ""
        self._stream.write(f"\r\x1b[K{self._label} [{bar}] {done:4.0%}{left}")
        self._stream.flush()

    def note(self, line: str) -> None:
        """Write a line above the bar; to a stream that is no terminal it is just written."""
        clear = "\r\x1b[K" if self._active else ""
        self._stream.write(f"{clear}{line}\n")
        self._stream.flush()
        self._drawn = -_INTERVAL_S

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._active:
            self._stream.write("\r\x1b[K")
            self._stream.flush()
