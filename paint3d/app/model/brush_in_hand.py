"""The brush in hand: in other sizes, as it will be, and another one for a stroke."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from paint3d.app.model.persistence.brush_words import brush_from_words
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import AnyArray, as_number
from paint3d.errors import BrushError, Paint3DError
from paint3d.painter.painter import Ink, Painter
from paint3d.surface.undo import BrushLoad

__all__ = [
    "BRUSH_COMMANDS",
    "ToolOverride",
    "brush_after",
    "resized",
    "scaled",
    "size_limits",
    "stepped",
]

# ---- Sizes ---------------------------------------------------------------------------------------


_STEP = 2.0 ** (1.0 / 4.0)  # of one press of [ or ]
_LENGTHS = (5.0, 200.0)  # mm, of `BrushSpec`
_MOST_TRANSFER = 1.0


def size_limits(brush: BrushSpec) -> tuple[float, float]:
    """The least and the greatest length (mm) that a brush can be scaled to."""
    finest = brush.length_mm * (brush.transfer_per_mm / _MOST_TRANSFER) ** 0.5
    least = max(_LENGTHS[0], finest, brush.length_mm * (1.0 / brush.load) ** (1.0 / 3.0))
    return least, _LENGTHS[1]


def scaled(brush: BrushSpec, factor: float) -> BrushSpec:
    """A brush of the same shape and hair, so many times as large.

    Lengths grow with the factor, the ink that it holds with its cube, and what it leaves on an
    area stays the same: so the fraction given per mm falls with the square.

    Raises
    ------
    BrushError
        If the brush would be shorter than 5 mm or longer than 200 mm, or cannot hold ink.
    """
    factor = as_number(factor, "brush size (factor)", 1e-3, 1e3, BrushError)
    return resized(brush, factor * brush.length_mm)


def resized(brush: BrushSpec, length_mm: float) -> BrushSpec:
    """A brush of the same shape and hair, its tuft so long; see `scaled`.

    Raises
    ------
    BrushError
        See `scaled`.
    """
    length = as_number(length_mm, "brush length (mm)", *size_limits(brush), BrushError)
    length = round(length, 3)
    factor = length / brush.length_mm
    plain = brush.name.split(" @")[0]
    return dataclasses.replace(
        brush,
        name=f"{plain} @{length:g} mm",
        length_mm=length,
        root_diameter_mm=factor * brush.root_diameter_mm,
        tip_segment_mm=factor * brush.tip_segment_mm,
        point_mm=factor * brush.point_mm,
        full_press_mm=factor * brush.full_press_mm,
        load=factor**3 * brush.load,
        transfer_per_mm=brush.transfer_per_mm / factor**2,
    )


def stepped(brush: BrushSpec, steps: int) -> BrushSpec:
    """A brush some presses of ] (or, below 0, of [) larger, as far as it goes."""
    least, most = size_limits(brush)
    return resized(brush, min(max(brush.length_mm * _STEP**steps, least), most))


# ---- The brush that was asked for ----------------------------------------------------------------
# The hand asks for another brush and paints on at once, while the painting may be seconds behind;
# what it does then it does with the brush it asked for, not with the one that still paints.


def _choose_brush(_: BrushSpec, brush: str | BrushSpec | Mapping[str, Any]) -> BrushSpec:
    if isinstance(brush, Mapping):
        return brush_from_words(brush)
    return load_brush(brush, own_files=False) if isinstance(brush, str) else brush


BRUSH_COMMANDS: dict[str, Callable[..., BrushSpec]] = {
    "set_brush": _choose_brush,
    "scale_brush": scaled,
    "resize_brush": resized,
    "step_brush": stepped,
}
"""Commands of a document that take another brush, and which."""


def brush_after(brush: BrushSpec, command: str, arguments: Sequence[object]) -> BrushSpec:
    """The brush in hand after one of `BRUSH_COMMANDS`; where that will be refused, as before."""
    try:
        return BRUSH_COMMANDS[command](brush, *arguments)
    except (Paint3DError, TypeError):
        return brush


# ---- Another brush or ink for one stroke ---------------------------------------------------------


class ToolOverride:
    """Swaps in another brush, or another ink for the one in hand, until `end` restores it.

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
        ink: Ink | None,
    ) -> None:
        self._painter, self._is_brush = painter, brush is not None
        self._state = painter.keep()
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
            painter.restore(self._state)
            raise
        self._began = BrushLoad.of(painter.surface)
        self._hair_load = None if painter.hairs is None else painter.hairs.load.copy()

    def end(self) -> None:
        """Restore what was in hand before."""
        painter, surface = self._painter, self._painter.surface
        now, hairs = BrushLoad.of(surface), painter.hairs
        own, of_hairs = self._load, self._state["of_hairs"]
        if not self._is_brush:
            own = replace(
                own,
                load=own.load * _fraction_left(now.load.sum(), self._began.load.sum()),
                reservoirs=_scale_reservoirs(
                    own.reservoirs, now.reservoirs, self._began.reservoirs
                ),
            )
            if isinstance(of_hairs, Mapping) and hairs is not None:
                assert self._hair_load is not None, "it has had hairs all the time"
                left = _fraction_left(hairs.load.sum(axis=1), self._hair_load.sum(axis=1))
                load = of_hairs["load"] * left[:, None]
                of_hairs = {"load": load, "memory": hairs.memory.copy()}
                left_load = load.sum(axis=0)  # hairs know only the inks that they have held
                own = replace(own, load=np.pad(left_load, (0, len(own.load) - len(left_load))))
        before, loaded = painter.in_brush(), painter.loaded
        own.put(surface)
        surface.ink.off_surface[:] = now.off_surface
        back = loaded + painter.in_brush() - before
        painter.restore({**self._state, "of_hairs": of_hairs, "loaded": back})


def _fraction_left(now: AnyArray, began: AnyArray) -> AnyArray:
    """The fraction that is left of each."""
    had_ink = np.asarray(began) > 0.0
    fraction: AnyArray = np.where(had_ink, now / np.where(had_ink, began, 1.0), 1.0)
    return fraction


def _scale_reservoirs(own: AnyArray, now: AnyArray, began: AnyArray) -> AnyArray:
    """Reservoirs (N, P) that have lost what those of the stroke have lost."""
    if now.shape[0] != began.shape[0] or own.shape[0] != now.shape[0]:
        return own
    fraction: AnyArray = own * _fraction_left(now.sum(axis=1), began.sum(axis=1))[:, None]
    return fraction
