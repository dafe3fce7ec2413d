"""Pictures of a brush that is being changed, drawn beside the window: always of the newest."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple

from PySide6 import QtCore

from paint3d.app.model.brush_commands import Ink
from paint3d.app.window.previews import sorted_parts
from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import AnyArray
from paint3d.view.brush_shape import draw_footprints, draw_stroke

__all__ = ["PRESSES", "BrushDrawing", "Drawn"]

_LOOK_MS = 30
PRESSES = (0.25, 0.6, 1.0)
"""Pressures whose footprints are shown."""


class Drawn(NamedTuple):
    """Pictures (H, W, 3) uint8 of a brush, or what is wrong with it."""

    brush: BrushSpec
    footprints: AnyArray | None
    stroke: AnyArray | None
    error: BaseException | None


class BrushDrawing(QtCore.QObject):
    """One thread that draws; what was asked for while it was busy is drawn when it has time.

    Parameters
    ----------
    side, columns : int
        Pixels: of the footprints' picture along a side, of the stroke's from left to right.

    Signals
    -------
    drawn : Drawn
    """

    drawn = QtCore.Signal(object)

    def __init__(self, parent: QtCore.QObject, side: int, columns: int) -> None:
        super().__init__(parent)
        self._size = side, columns
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="paint3d-brush")
        self._next: tuple[BrushSpec, Ink] | None = None
        self._coming: Future[Drawn] | None = None
        self._timer = QtCore.QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._look)

    @property
    def is_busy(self) -> bool:
        """Whether something is still to be drawn."""
        return self._next is not None or self._coming is not None

    def ask(self, brush: BrushSpec, ink: Ink) -> None:
        """Draw this brush instead of any that waits."""
        self._next = brush, ink
        self._look()
        self._timer.start()

    def close_down(self) -> None:
        """Draw nothing more."""
        self._timer.stop()
        self._next = None
        self._worker.shutdown(wait=False, cancel_futures=True)

    def _look(self) -> None:
        if self._coming is not None:
            if not self._coming.done():
                return
            drawn, self._coming = self._coming.result(), None
            self.drawn.emit(drawn)
        if self._next is not None:
            (brush, ink), self._next = self._next, None
            self._coming = self._worker.submit(_draw, brush, ink, *self._size)
        else:
            self._timer.stop()


def _draw(brush: BrushSpec, ink: Ink, side: int, columns: int) -> Drawn:
    try:
        parts: Any = dict(sorted_parts(ink))
        footprints = draw_footprints(brush, side, PRESSES)
        return Drawn(brush, footprints, draw_stroke(brush, parts, columns=columns), None)
    except Exception as error:  # told in the window: what went wrong in a thread nobody sees
        return Drawn(brush, None, None, error)
