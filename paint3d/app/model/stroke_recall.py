"""Recall of strokes that no undo step takes back: they are painted again, each as a step.

Older files hold strokes and no steps, and a file has no capacity for the steps of very many. The
strokes are painted again on layers of their own; that these make way for the painting as it is
belongs to the last one's step. So undo leads from the painting to what was painted again, stroke by
stroke to the bare object, and redo back to the painting to the bit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from paint3d.app.model.stroke_log import ERASES, Stroke, ink_of, weights_of
from paint3d.painter.painter import Ink, Painter
from paint3d.surface.eraser import Eraser
from paint3d.surface.undo import UndoHistory

__all__ = ["StrokeRecall", "dips_of", "named_dips"]

_Dip = tuple[Ink, float | None]
_CHUNK = 1000  # samples between two calls of `progress`


class StrokeRecall:
    """Painting of a log's strokes once more, each as a step of undo.

    Parameters
    ----------
    painter : Painter
    undo : UndoHistory
        Gets a step for each.
    progress : callable or None
        Called with the fraction that is done; what it raises stops it.
    """

    def __init__(
        self, painter: Painter, undo: UndoHistory, progress: Callable[[float], None] | None
    ) -> None:
        self._painter, self._undo, self._progress = painter, undo, progress

    def make_bare(self, first: Stroke) -> None:
        """Begin as a new painting would: a brush that was dipped for the first stroke."""
        painter, surface = self._painter, self._painter.surface
        surface.use_layers().set_properties(0, name=first.layer)
        painter.change_brush(first.brush)
        painter.rinse()
        surface.ink.off_surface[:] = 0.0
        painter.loaded = 0.0
        painter.dip(ink_of(first, self._painter.surface), amount=first.amount)

    def repeat(self, strokes: Sequence[Stroke]) -> None:
        """Paint strokes on the layers of their names, each a step."""
        stack, painter = self._painter.surface.use_layers(), self._painter
        total, before = sum(len(stroke.samples) for stroke in strokes), 0
        for stroke in strokes:
            self._undo.begin(stroke)
            names = [layer.name for layer in stack.layers]
            if stroke.layer not in names:
                self._undo.change(stack.state, partial(stack.add, stroke.layer, len(names)))
            elif names.index(stroke.layer) != stack.active:
                self._undo.change(stack.state, partial(stack.activate, names.index(stroke.layer)))
            if stroke.brush != painter.brush:
                painter.change_brush(stroke.brush)
                painter.dip(ink_of(stroke, painter.surface), amount=stroke.amount)
            elif stroke.dipped_since_stroke:
                painter.dip(ink_of(stroke, painter.surface), amount=stroke.amount)
            samples = stroke.samples
            eraser = Eraser(painter.surface) if stroke.tags.get(ERASES) else None
            try:
                for at in range(0, len(samples), _CHUNK):
                    painter.advance(samples[at : at + _CHUNK])
                    if eraser is not None:
                        painter.loaded -= eraser.wipe()
                    if self._progress is not None:
                        self._progress((before + at) / total)
            except BaseException:
                painter.abandon()
                raise
            painter.finish()
            if eraser is not None:
                painter.loaded -= eraser.wipe()
            before += len(samples)


def dips_of(painter: Painter) -> Sequence[_Dip]:
    """Return the dips that the brush has its ink from: the belly's, and then the tip's."""
    return painter.dips or ((painter.dipped, None),)


def named_dips(dips: Sequence[_Dip]) -> list[tuple[dict[str, float], float | None]]:
    """Return dips by the names of their inks, to be compared."""
    return [(weights_of(ink), reach) for ink, reach in dips]
