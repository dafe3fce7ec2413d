"""Steps for strokes that have none, by painting them once more underneath what is there.

Files from before kept strokes and no steps, and a file has no room for the steps of very many. The
strokes are painted again on layers of their own; that these make way for the painting as it is
belongs to the last one's step. So undo leads from the painting to what was painted again, stroke by
stroke to the bare object, and redo back to the painting to the bit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from paint3d.app.model.stroke_log import Stroke, StrokeLog, weights_of
from paint3d.colour.pigments import Pigment
from paint3d.core.arrays import AnyArray
from paint3d.device.recorded import Recording
from paint3d.errors import InputError
from paint3d.painter.painter import Ink, Painter
from paint3d.surface.ink_store import union
from paint3d.surface.layer_stack import Layer
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import UndoHistory

__all__ = ["RecallCommands"]

_Dip = tuple[Ink, float | None]
_CHUNK = 1000  # samples between two calls of `progress`


class RecallCommands:
    """Strokes of a `Document` that no step takes back.

    Attributes
    ----------
    progress : callable or None
        Called with the share that is done while strokes are painted again; what it raises stops
        that, and everything is as it was.
    """

    surface: PaintedSurface
    painter: Painter
    progress: Callable[[float], None] | None = None
    _dipped: bool
    _log: StrokeLog
    _recordings: Sequence[Recording]
    _undo: UndoHistory
    _saved_at: int | None
    _gather: Callable[[], None]
    _note: Callable[[AnyArray], None]
    _refuse_in_stroke: Callable[[str], None]

    if TYPE_CHECKING:  # what the document's other commands bring along

        @property
        def layers(self) -> tuple[Layer, ...]: ...  # noqa: D102

        @property
        def strokes(self) -> Sequence[Stroke]: ...  # noqa: D102

    @property
    def oldest_stroke(self) -> int:
        """How many strokes no step takes back; `recall_strokes` gives them steps."""
        return self._log.n_before

    @property
    def earliest_stroke(self) -> int:
        """To how few strokes the painting can be brought back, by steps or by painting again.

        What a recording painted is no stroke: strokes over it cannot be painted again by
        themselves.
        """
        return self.oldest_stroke if self._recordings else 0

    def recall_strokes(self) -> AnyArray:
        """Paint the strokes that no step takes back once more, so that all can be taken back.

        The painting stays as it is, to the bit. Layers are those of the strokes' names in the order
        in which they come; what was dried, moved, mirrored, masked, or let run meanwhile is not
        repeated.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed meanwhile.

        Raises
        ------
        InputError
            If a stroke is going on, or there is a recording under the strokes.
        """
        self._refuse_in_stroke("going back")
        count = self.oldest_stroke
        if not count:
            return np.empty(0, np.int32)
        if self.earliest_stroke:
            raise InputError(
                f"the first {count} strokes lie over a recording, which no stroke repeats; "
                f"expected a stroke from {count} on"
            )
        self._gather()
        painter = self.painter
        brush, since_dip = painter.brush, self._dipped
        amount, dips = painter.amount, _dips_of(painter)
        n_done = len(self._undo.done)
        touched = [self._undo.undo() for _ in range(n_done)]
        touched.append(self.surface.use_layers().painted_ids())
        strokes = self.strokes[:count]
        try:
            self._undo.prepend(lambda: self._make_bare(strokes[0]), lambda: self._repeat(strokes))
            self._log.hold(len(self.strokes))
            if self._saved_at == 0:  # before all steps that there were
                self._saved_at = self._undo.next_undo
        finally:
            touched += [self._undo.redo() for _ in range(n_done)]
            held = painter.brush, _said(_dips_of(painter)), painter.amount
            if held != (brush, _said(dips), amount):
                painter.change_brush(brush)
                for ink, reach in dips:  # the belly, and then the tip
                    painter.dip(ink, reach, amount if reach is None else None)
            self._dipped = since_dip
            found = union(touched, self.surface.paint_mesh.capacity)
            self.surface.touch(found)
            self._note(found)
        return found

    def _make_bare(self, first: Stroke) -> None:
        """Begin as a new painting would: a brush that was dipped for the first stroke."""
        painter, surface = self.painter, self.surface
        surface.use_layers().describe(0, name=first.layer)
        painter.change_brush(first.brush)
        painter.rinse()
        surface.ink.off_surface[:] = 0.0
        painter.loaded = 0.0
        painter.dip(self._ink_of(first), amount=first.amount)

    def _repeat(self, strokes: Sequence[Stroke]) -> None:
        """Paint strokes on the layers of their names, each a step."""
        painter = self.painter
        total, before = sum(len(stroke.samples) for stroke in strokes), 0
        for stroke in strokes:
            self._undo.begin(stroke)
            self._make_ready(stroke)
            samples = stroke.samples
            try:
                for at in range(0, len(samples), _CHUNK):
                    painter.advance(samples[at : at + _CHUNK])
                    if self.progress is not None:
                        self.progress((before + at) / total)
            except BaseException:
                painter.abandon()
                raise
            painter.finish()
            before += len(samples)

    def _make_ready(self, stroke: Stroke) -> None:
        """Take the layer, the brush and the ink of a stroke."""
        stack, painter = self.surface.use_layers(), self.painter
        names = [layer.name for layer in stack.layers]
        if stroke.layer not in names:
            self._undo.change(stack.state, lambda: stack.add(stroke.layer, len(names)))
        elif names.index(stroke.layer) != stack.active:
            self._undo.change(stack.state, lambda: stack.activate(names.index(stroke.layer)))
        if stroke.brush != painter.brush:
            painter.change_brush(stroke.brush)
            painter.dip(self._ink_of(stroke), amount=stroke.amount)
        elif stroke.dipped:
            painter.dip(self._ink_of(stroke), amount=stroke.amount)

    def _ink_of(self, stroke: Stroke) -> dict[str | Pigment, float]:
        known = {pigment.name: pigment for pigment in self.surface.pigments}
        return {known.get(name, name): part for name, part in stroke.ink.items()}


def _dips_of(painter: Painter) -> Sequence[_Dip]:
    """What the brush came to its ink by: the belly's dip, and then the tip's."""
    return painter.dips or ((painter.dipped, None),)


def _said(dips: Sequence[_Dip]) -> list[tuple[dict[str, float], float | None]]:
    """Dips by the names of their inks, to be compared."""
    return [(weights_of(ink), reach) for ink, reach in dips]
