"""Presses seals onto a surface: a step that can be undone."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from paint3d.app.model.commands import COMMANDS
from paint3d.app.model.mask import Stencil
from paint3d.calligraphy.seal.impression import Pressing, find_impression, lay_paste
from paint3d.colour.ink_text import table_of
from paint3d.colour.pigments import load_pigment
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import InputError
from paint3d.mesh.chart import frame_at
from paint3d.painter.painter import Ink, Painter
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import UndoHistory

__all__ = ["PASTE", "SealPress"]

PASTE = "cinnabar"

_LOG = logging.getLogger("paint3d.seal")
_MOST_POINTS = 200_000
_PALE = 0.6  # of the stone: where less touches, a note says so
_MOST_COATS, _MOST_PAD_MM, _MOST_WEAR, _MOST_SEED = 10.0, 100.0, 3.0, 1_000_000
_Seal = tuple[list[AnyArray], Pressing]


class SealPress:
    """Presses seals with paste; see `Document.press_seal`.

    Parameters
    ----------
    painter : Painter
    undo : UndoHistory
        Which gets a step for each.
    """

    def __init__(self, painter: Painter, undo: UndoHistory) -> None:
        self._painter, self._undo = painter, undo

    def check(
        self, rings: Sequence[ArrayLike], coats: float, pad_mm: float, wear: float, seed: int
    ) -> _Seal:
        """A seal and how it is pressed.

        Raises
        ------
        InputError
            If the rings are none, or a number is out of its range.
        """
        cut = [as_array(ring, "a ring of the seal", (None, 2)) for ring in rings]
        n_points = sum(map(len, cut))
        if not cut or min(map(len, cut)) < 3 or n_points > _MOST_POINTS:
            raise InputError(
                "a seal of {n} rings with {n_points:,} points; expected rings of three at least, "
                "and {most:,} points at most",
                n=len(cut),
                n_points=n_points,
                most=_MOST_POINTS,
            )
        return cut, Pressing(
            as_number(coats, "coats", 0.01, _MOST_COATS),
            as_number(pad_mm, "pad (mm)", 0.01, _MOST_PAD_MM),
            as_number(wear, "wear", 0.0, _MOST_WEAR),
            int(as_number(seed, "seed", 0, _MOST_SEED)),
        )

    def press(
        self, seal: _Seal, at: ArrayLike, up: ArrayLike, ink: Ink, stencil: Stencil | None
    ) -> float:
        """Lay paste where the stone touches and no stencil covers; the fraction that touched.

        Raises
        ------
        InputError, MeshError
            See `Document.press_seal`.
        """
        surface = self._painter.surface
        at, up = as_array(at, "at", (3,)), as_array(up, "up", (3,))
        closest = surface.closest_points
        impression = find_impression(surface, closest, frame_at(closest, at, up), *seal)
        if stencil is not None:
            free = ~stencil.covers(impression.vertex_ids)
            impression = replace(
                impression,
                vertex_ids=impression.vertex_ids[free],
                coats=impression.coats[free],
                coverage=impression.coverage[free],
            )
        parts = _paste_parts(surface, ink)
        self._undo.begin(COMMANDS["press_seal"].undo_label)
        self._painter.loaded += lay_paste(surface, impression, parts)
        if impression.touched < _PALE:
            _LOG.warning(
                "the seal touches %.0f %% of what it is to print: the surface falls away from it",
                100.0 * impression.touched,
            )
        return impression.touched


def _paste_parts(surface: PaintedSurface, ink: Ink) -> AnyArray:
    """(P,) float32 parts of the surface's pigments, of sum 1."""
    stirred: Mapping[Any, float] = ink if isinstance(ink, Mapping) else {ink: 1.0}
    if not stirred:
        raise InputError("the paste is empty; expected an ink")
    columns, weights = [], []
    for one, weight in stirred.items():
        if isinstance(one, str) and table_of(one) is not None:
            raise InputError(
                "the paste has {one!r}; expected a name of the palette, or a Pigment",
                one=one,
            )
        pigment = load_pigment(one) if isinstance(one, str) else one
        columns.append(surface.column_of(pigment))
        weights.append(as_number(weight, f"part of {pigment.name}", 1e-9))
    parts = np.zeros(len(surface.pigments), np.float32)
    np.add.at(parts, columns, np.array(weights, np.float32) / np.float32(sum(weights)))
    return parts
