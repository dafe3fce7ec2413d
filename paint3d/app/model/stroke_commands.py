"""Strokes of a document: their beginning, samples and end, images and masks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from paint3d.app.model.image_painter import ImagePainter
from paint3d.app.model.input.symmetry import Symmetry
from paint3d.app.model.mask import Mask, Stencil
from paint3d.app.model.stroke_log import Stroke, StrokeLog, checked_pairs, parts_of
from paint3d.brush.spec import BrushSpec
from paint3d.colour.pigments import Pigment
from paint3d.core.arrays import AnyArray
from paint3d.device.sample import DeviceSample
from paint3d.errors import InputError
from paint3d.painter.ink_time import LOOKAHEAD
from paint3d.painter.painter import Painter
from paint3d.painter.recorded_tools import LEAST_INK
from paint3d.surface.layer_stack import Layer
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import BrushLoad, UndoHistory

__all__ = ["Loan", "StrokeCommands"]

# ---- Loans ---------------------------------------------------------------------------------------
# A brush or an ink for one stroke: what was in hand comes back with its end.


class Loan:
    """Takes another brush into the hand, or lets the one there hold another ink, until `end`.

    Parameters
    ----------
    painter : Painter
    brush : BrushSpec, optional
        Dipped in the ink, or in that of the brush that waits; that one keeps what it holds.
    ink : str, Pigment or mapping, optional
        Without a brush, as much of it as the brush in hand holds. What this has used up of it when
        it comes back, it has used up of its own.

    Raises
    ------
    Paint3DError
        If the brush or the ink cannot be used; then all is as it was.
    """

    def __init__(
        self,
        painter: Painter,
        brush: BrushSpec | None,
        ink: str | Pigment | Mapping[Any, float] | None,
    ) -> None:
        self._painter, self._is_brush = painter, brush is not None
        self._kept = painter.keep()
        self._load = BrushLoad.of(painter.surface)
        try:
            if brush is not None:
                painter.change_brush(brush)
                if ink is not None:
                    painter.dip(ink)
            elif ink is not None:
                painter.recolour(ink)
        except BaseException:
            self._load.put(painter.surface)
            painter.restore(self._kept)
            raise
        self._began = BrushLoad.of(painter.surface)
        self._hair_load = None if painter.hairs is None else painter.hairs.load.copy()

    def end(self) -> None:
        """Have what was in hand before."""
        painter, surface = self._painter, self._painter.surface
        now, hairs = BrushLoad.of(surface), painter.hairs
        own, of_hairs = self._load, self._kept["of_hairs"]
        if not self._is_brush:
            own = replace(
                own,
                load=own.load * _left(now.load.sum(), self._began.load.sum()),
                reservoirs=_fitting(own.reservoirs, now.reservoirs, self._began.reservoirs),
            )
            if isinstance(of_hairs, Mapping) and hairs is not None:
                assert self._hair_load is not None, "it has had hairs all the time"
                left = _left(hairs.load.sum(axis=1), self._hair_load.sum(axis=1))
                load = of_hairs["load"] * left[:, None]
                of_hairs = {"load": load, "memory": hairs.memory.copy()}
                held = load.sum(axis=0)  # hairs know only the inks that they have held
                own = replace(own, load=np.pad(held, (0, len(own.load) - len(held))))
        before, loaded = painter.in_brush(), painter.loaded
        own.put(surface)
        surface.ink.off_surface[:] = now.off_surface
        back = loaded + painter.in_brush() - before
        painter.restore({**self._kept, "of_hairs": of_hairs, "loaded": back})


def _left(now: AnyArray, began: AnyArray) -> AnyArray:
    """The share that is left, of each."""
    held = np.asarray(began) > 0.0
    share: AnyArray = np.where(held, now / np.where(held, began, 1.0), 1.0)
    return share


def _fitting(own: AnyArray, now: AnyArray, began: AnyArray) -> AnyArray:
    """Reservoirs (N, P) that have lost what those of the stroke have lost."""
    if now.shape[0] != began.shape[0] or own.shape[0] != now.shape[0]:
        return own
    share: AnyArray = own * _left(now.sum(axis=1), began.sum(axis=1))[:, None]
    return share


# --------------------------------------------------------------------------------------------------


class StrokeCommands:
    """Strokes of a `Document`, and what passes with time."""

    surface: PaintedSurface
    painter: Painter
    symmetry: Symmetry
    mask: Mask
    modified: bool
    _log: StrokeLog
    _undo: UndoHistory
    _images: list[ImagePainter]
    _stencil: Stencil | None
    _loan: Loan | None = None
    _dipped: bool
    _refused: bool
    _come_back: Callable[[], None]
    compare_with_saved: Callable[[], None]
    _paintable: Callable[[], Layer]
    _note: Callable[..., Any]

    @property
    def in_stroke(self) -> bool:
        """Whether a stroke is going on."""
        return self._log.current is not None

    @property
    def unpainted(self) -> tuple[list[DeviceSample], bool]:
        """The last samples of the stroke that is going on: those that still wait to be painted.

        Before them the one where the painter's stamp stands, and then True; else the stroke's first
        samples, none of which is painted yet, and False.
        """
        stroke = self._log.current
        if stroke is None:
            return [], False
        return stroke.samples[-LOOKAHEAD - 1 :], len(stroke.samples) > LOOKAHEAD + 1

    @property
    def strokes(self) -> Sequence[Stroke]:
        """What was painted by hand and is there, in order; those of earlier sittings first."""
        return self._log.strokes

    @property
    def current_stroke(self) -> Stroke | None:
        """The stroke that is going on."""
        return self._log.current

    def begin_stroke(
        self,
        time_s: float | None = None,
        brush: BrushSpec | None = None,
        ink: str | Pigment | Mapping[Any, float] | None = None,
        loads: Sequence[tuple[int, float]] = (),
        strengths: Sequence[tuple[int, float]] = (),
    ) -> None:
        """Start a stroke: a step that can be undone.

        Parameters
        ----------
        time_s : float, optional
            When it began, s since 1970; now by default.
        brush, ink : optional
            Of this stroke alone: another brush, dipped in the ink or in the same as the one in
            hand; without a brush, as much of the ink as the brush holds. What is in hand comes back
            with the stroke's end.
        loads : sequence of (int, float)
            How much the brush comes to hold at samples of the stroke, counted from 0: a share, 0 to
            1, of what a dip gives.
        strengths : sequence of (int, float)
            The same for what share of the ink it then is, the rest being water, until the next dip.

        Raises
        ------
        InputError
            If one is going on, the layer is locked or hidden, or loads or strengths are no such
            pairs. In that case samples are passed over until `end_stroke` or `cancel_stroke`: they
            belong to the stroke that was refused.
        """
        self._refuse_in_stroke("a stroke")
        self._come_back()
        self._refused = True
        told = checked_pairs("loads", loads), checked_pairs("strengths", strengths, LEAST_INK)
        layer = self._paintable()
        painter = self.painter
        stroke = self._log.begin(
            painter.brush, painter.dipped, layer.name, self._dipped, time_s, painter.amount
        )
        stroke.loads, stroke.strengths = told
        self._undo.begin(stroke)
        if brush is not None or ink is not None:
            self._borrow(stroke, brush, ink)
        self._refused = self._dipped = False
        self._images = [ImagePainter(painter, image) for image in self.symmetry.images()]
        painter.expect(*told)
        for image in self._images:
            image.expect(*told)

    def _borrow(
        self,
        stroke: Stroke,
        brush: BrushSpec | None,
        ink: str | Pigment | Mapping[Any, float] | None,
    ) -> None:
        """Take a brush or an ink for the stroke that begins; where that fails, none begins."""
        painter = self.painter
        try:
            self._loan = Loan(painter, brush, ink)
        except BaseException:
            self._log.cancel()
            self._note(self._undo.revert())
            raise
        stroke.brush, stroke.ink = painter.brush, parts_of(painter.dipped)
        stroke.dipped = True

    def _give_back(self) -> None:
        """End the loan of a brush or an ink, if there is one."""
        if self._loan is not None:
            self._loan.end()
            self._loan = None

    def feed(self, samples: Sequence[DeviceSample]) -> None:
        """Paint samples of both hands, in the order of time; the last two wait for more.

        Raises
        ------
        InputError
            If no stroke was begun, or the samples cannot follow those before; none of them is
            painted then, and the stroke goes on.
        """
        if self._refused:
            return
        if not self.in_stroke:
            raise InputError("samples came without a stroke; expected begin_stroke first")
        if not samples:
            return
        self._log.check(samples)
        self._log.append(samples)
        alone = self._stencil is None and not self._images  # else who comes first would matter
        for batch in [samples] if alone else [[sample] for sample in samples]:
            self.painter.advance(batch)
            self._wipe_stencil()
            for image in self._images:
                image.advance(batch, self._wipe_stencil)
        self.modified = True

    def lift(self) -> None:
        """Paint what still waits of a stroke that goes on elsewhere: the pen is up meanwhile."""
        if self.in_stroke:
            self.painter.lift()
            self._wipe_stencil()
            for image in self._images:
                image.lift(self._wipe_stencil)

    def end_stroke(self) -> Stroke | None:
        """Paint what still waits, and lift the brush.

        Returns
        -------
        Stroke or None
            None where it was refused, has ended already, or had no sample.
        """
        self._refused = False
        if not self.in_stroke:
            return None
        self.painter.finish()
        self._wipe_stencil()
        self._lift_images()
        self._give_back()
        stroke = self._log.end()
        if stroke is None:
            self._note(self._undo.revert())
            self.compare_with_saved()
        return stroke

    def break_off(self) -> None:
        """End the stroke that is going on now; what its hand still sends is passed over."""
        if self.in_stroke:
            self.end_stroke()
            self._refused = True

    def cancel_stroke(self) -> None:
        """Take the stroke that is going on back, as if it had never begun."""
        self._refused = False
        if not self.in_stroke:
            return
        self.painter.abandon()
        self._images = []
        self._loan = None  # what was in hand comes back with the step
        self._log.cancel()
        self._note(self._undo.revert())
        self.compare_with_saved()

    def set_symmetry(self, symmetry: Symmetry) -> None:
        """Paint every stroke's images as well, from now on.

        Raises
        ------
        InputError
            If a stroke is going on.
        """
        self._refuse_in_stroke("another symmetry")
        self.symmetry = symmetry

    def set_mask(self, mask: Mask) -> None:
        """Take paint only where the mask allows, from now on.

        Raises
        ------
        InputError
            If it names a face that is not there, or a stroke is going on.
        """
        self._refuse_in_stroke("another mask")
        self._stencil = None if mask.is_open else Stencil(self.surface, mask)
        self.mask = mask

    @property
    def stencil(self) -> Stencil | None:
        """The mask as it lies on the surface; None where paint is taken everywhere."""
        return self._stencil

    @property
    def tags(self) -> dict[str, object]:
        """What every stroke from now on says as well; see `set_tags`."""
        return dict(self._log.tags)

    def set_tags(self, **tags: object) -> None:
        """Have every stroke from now on say this as well, as JSON holds it; none: no more."""
        self._log.tags = dict(tags)

    def _wipe_stencil(self) -> None:
        if self._stencil is not None:
            self._stencil.wipe(self._undo.before)

    def _lift_images(self) -> None:
        for image in self._images:
            image.finish(self._wipe_stencil)
        self._images = []

    def _refuse_in_stroke(self, what: str) -> None:
        if self.in_stroke:
            raise InputError(f"{what} was asked for during a stroke; expected its end first")

    def rest(self) -> None:
        """Get ready for the next stroke while nobody paints; nothing that is painted changes."""
        if not self.in_stroke:
            self.surface.grow_ahead()

    def follow_time(self, seconds: float) -> bool:
        """Let wet ink spread and dry, if it keeps up; see `PaintedSurface.follow_time`."""
        keeps_up = self.surface.follow_time(seconds)
        self._seal_what_ran()
        return keeps_up

    def let_time_pass(self, seconds: float) -> bool:
        """Let wet ink spread and dry; whether it keeps up: see `PaintedSurface.follow_flow`."""
        keeps_up = self.surface.follow_flow(seconds)
        self._seal_what_ran()
        return keeps_up

    def _seal_what_ran(self) -> None:
        """What runs by itself is not the stencil's."""
        if self._stencil is not None and self.in_stroke:
            self._undo.seal()

    def dry(self) -> None:
        """Let all wet paint dry at once: a step that can be undone."""
        self._refuse_in_stroke("drying")
        self._come_back()
        self._paintable()
        self._undo.begin("dry")
        self.surface.dry()
        self.modified = True
