"""Seals on a document: a step that can be undone, and that journals and scores repeat."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from paint3d.app.model.brush_commands import Ink
from paint3d.app.model.mask import Stencil
from paint3d.calligraphy.seal.impression import Impression, Pressing, find_impression
from paint3d.colour.ink_text import table_of
from paint3d.colour.pigments import load_pigment
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import InputError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import frame_at
from paint3d.painter.painter import Painter
from paint3d.surface.layer_stack import Layer
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import UndoHistory

__all__ = ["PASTE", "SEAL_STEP", "SealCommands"]

PASTE = "cinnabar"
SEAL_STEP = "seal"

_LOG = logging.getLogger("paint3d.seal")
_MOST_POINTS = 200_000
_PALE = 0.6  # of the stone: where less touches, a note says so
_MOST_COATS, _MOST_PAD_MM, _MOST_WEAR, _MOST_SEED = 10.0, 100.0, 3.0, 1_000_000


class SealCommands:
    """Seals of a `Document`."""

    surface: PaintedSurface
    painter: Painter
    modified: bool
    _undo: UndoHistory
    _stencil: Stencil | None
    _closest: ClosestPoints | None = None
    _come_back: Callable[[], None]
    _paintable: Callable[[], Layer]
    _refuse_in_stroke: Callable[[str], None]

    def press_seal(
        self,
        rings: Sequence[ArrayLike],
        at: ArrayLike,
        up: ArrayLike = (0.0, 0.0, 1.0),
        ink: Ink = PASTE,
        coats: float = 1.3,
        pad_mm: float = 3.0,
        wear: float = 1.0,
        seed: int = 1,
    ) -> float:
        """Press a seal onto the layer that is painted on: a step that can be undone.

        What is wet under the paste dries first; the paste lies on it and does not run.

        Parameters
        ----------
        rings : sequence of (N, 2) array_like
            What of the stone takes paste, mm from its middle, y upwards, by the even-odd rule.
        at : (3,) array_like
            Where the middle of the stone goes: the surface's closest point to it, mm.
        up : (3,) array_like
            What is up on the stone; not along the surface's normal.
        ink : ink or mixture
            The paste.
        coats, pad_mm, wear, seed
            See `Pressing`.

        Returns
        -------
        float
            How much of the stone's ink met the surface, 0 to 1.

        Raises
        ------
        InputError
            If a stroke is going on, the layer is locked or hidden, the rings are none, or the
            surface falls away from the stone.
        MeshError
            If the surface ends within the stone.
        """
        self._refuse_in_stroke("a seal")
        cut, pressing = _checked_rings(rings), _checked_pressing(coats, pad_mm, wear, seed)
        self._come_back()
        self._paintable()
        left = self._find_impression(
            cut, as_array(at, "at", (3,)), as_array(up, "up", (3,)), pressing
        )
        self._lay_paste(left, ink)
        if left.touched < _PALE:
            _LOG.warning(
                "the seal touches %.0f %% of what it is to print: the surface falls away from it",
                100.0 * left.touched,
            )
        return left.touched

    def _find_impression(
        self, rings: Sequence[AnyArray], at: AnyArray, up: AnyArray, pressing: Pressing
    ) -> Impression:
        surface = self.surface
        if self._closest is None or self._closest.mesh is not surface.source:
            self._closest = ClosestPoints(surface.source)
        frame = frame_at(self._closest, at, up)
        return find_impression(surface, self._closest, frame, rings, pressing)

    def _lay_paste(self, left: Impression, ink: Ink) -> None:
        """Lay paste on what is painted, where no mask covers it."""
        surface = self.surface
        ids, coats, share = left.vertex_ids, left.coats, left.share
        if self._stencil is not None:
            free = ~self._stencil.covers(ids)
            ids, coats, share = ids[free], coats[free], share[free]
        parts = _parts(surface, ink)
        self._undo.begin(SEAL_STEP)
        before = surface.wet_ink() + surface.dry_ink()
        surface.settle(ids)
        surface.ink.amounts[ids] = coats[:, None] * parts
        surface.ink.coverage[ids] = share
        surface.settle(ids)
        self.painter.loaded += surface.wet_ink() + surface.dry_ink() - before
        self.modified = True


def _parts(surface: PaintedSurface, ink: Ink) -> AnyArray:
    """(P,) float32 parts of the surface's pigments, of sum 1."""
    stirred: Mapping[Any, float] = ink if isinstance(ink, Mapping) else {ink: 1.0}
    if not stirred:
        raise InputError("a paste of nothing; expected an ink")
    columns, weights = [], []
    for one, weight in stirred.items():
        if isinstance(one, str) and table_of(one) is not None:
            raise InputError(f"paste of {one!r}; expected a name of the palette, or a Pigment")
        pigment = load_pigment(one) if isinstance(one, str) else one
        columns.append(surface.column_of(pigment))
        weights.append(as_number(weight, f"part of {pigment.name}", 1e-9))
    parts = np.zeros(len(surface.pigments), np.float32)
    np.add.at(parts, columns, np.array(weights, np.float32) / np.float32(sum(weights)))
    return parts


def _checked_rings(rings: Sequence[ArrayLike]) -> list[AnyArray]:
    cut = [as_array(ring, "a ring of the seal", (None, 2)) for ring in rings]
    n_points = sum(map(len, cut))
    if not cut or min(map(len, cut)) < 3 or n_points > _MOST_POINTS:
        raise InputError(
            f"a seal of {len(cut)} rings with {n_points:,} points; expected rings of three at "
            f"least, and {_MOST_POINTS:,} points at most"
        )
    return cut


def _checked_pressing(coats: float, pad_mm: float, wear: float, seed: int) -> Pressing:
    return Pressing(
        as_number(coats, "coats", 0.01, _MOST_COATS),
        as_number(pad_mm, "pad (mm)", 0.01, _MOST_PAD_MM),
        as_number(wear, "wear", 0.0, _MOST_WEAR),
        int(as_number(seed, "seed", 0, _MOST_SEED)),
    )
