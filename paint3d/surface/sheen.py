"""Gloss of a painting's vertices: under water, and where ink has dried."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.materials import Material
from paint3d.colour.pigments import WATER, Pigment
from paint3d.colour.wet_look import (
    MATT_ROUGHNESS,
    WetLook,
    damp_fraction,
    film_fraction,
    shine_of_inks,
)
from paint3d.core.arrays import AnyArray, grown
from paint3d.mesh.refined_mesh import PaintMesh

__all__ = ["PLAIN_SHINE", "WetWatch", "look_when_wet"]

PLAIN_SHINE = 128
"""Shine of bare material; 255 is that of a film of water, 1 of the most matt dried ink."""


class _Painted(Protocol):
    """Interface of a surface with ink and water on it, `PaintedSurface`."""

    pigments: list[Pigment]
    paint_mesh: PaintMesh
    material: Material

    @property
    def painted(self) -> NDArray[np.bool_]: ...

    @property
    def seen_layers(self) -> Hashable: ...

    @property
    def seen_water(self) -> tuple[AnyArray, AnyArray] | None: ...

    def coats_at(self, vertex_ids: AnyArray) -> NDArray[np.float64]: ...


def look_when_wet(surface: _Painted, roughness: float) -> WetLook | None:
    """Return the wet look of all vertices; None where all look like a material so rough."""
    water, pores = surface.seen_water, surface.material.pores_mm
    ids = np.zeros(0, np.int64)
    if _is_otherwise_dry(surface, roughness):
        ids = np.flatnonzero(surface.painted)
    if water is None and not len(ids):
        return None
    n = surface.paint_mesh.n_vertices
    look = WetLook(*(np.zeros(n, np.float32) for _ in WetLook._fields))
    look.gloss[ids], look.hidden[ids] = _dried(surface, ids)
    if water is not None:
        ids, depth = water
        look.film[ids], look.damp[ids] = film_fraction(depth, pores), damp_fraction(depth, pores)
    return look


_STEPS = 127  # of shine, either way
_FRACTIONS = film_fraction, damp_fraction
_LEVELS = 15  # distinct levels: drying changes the picture a few times, not in every frame


def _quantised(fractions: AnyArray) -> NDArray[np.uint8]:
    """Return fractions (N,) in steps of 1/255, rounded to `_LEVELS` levels."""
    levels = np.rint(_LEVELS * fractions).astype(np.uint8)
    result: NDArray[np.uint8] = levels * np.uint8(255 // _LEVELS)
    return result


class WetWatch:
    """Tracker of the wet look of a surface's vertices, updated as the surface changes.

    It costs next to nothing while nothing is wet and inks dry to the gloss of the material; `shine`
    and `damp` must not be called then (`is_plain`).

    Parameters
    ----------
    surface : PaintedSurface
    """

    def __init__(self, surface: _Painted) -> None:
        self._surface = surface
        self._film, self._damp = np.zeros(0, np.uint8), np.zeros(0, np.uint8)
        self._dried = np.zeros(0, np.int8)  # shine once dry, less the material's, in `_STEPS`
        self._shine = np.zeros(0, np.uint8)
        self._is_wet, self._wet = np.zeros(0, bool), np.zeros(0, np.int32)
        self._layers: Hashable = self  # equal to no layers, so the first call looks at everything

    @property
    def is_plain(self) -> bool:
        """Whether everything looked like its material at the last `follow`."""
        return not len(self._wet) and not len(self._dried)

    def follow(self, inked: AnyArray) -> NDArray[np.int32]:
        """Update, and return the vertices (N,) whose shine differs from that at the last call.

        Parameters
        ----------
        inked : (M,) int32
            Vertices whose ink may have changed: their dry gloss is computed anew.
        """
        surface = self._surface
        water = surface.seen_water
        is_otherwise = _is_otherwise_dry(surface, surface.material.seen_roughness)
        if water is None and not len(self._wet) and not is_otherwise:
            return self._wet
        if len(self._film) < surface.paint_mesh.n_vertices:
            capacity, known = surface.paint_mesh.capacity, len(self._film)
            self._film, self._damp = (grown(a, known, capacity) for a in (self._film, self._damp))
            self._film[known:] = self._damp[known:] = 0
            self._is_wet, self._shine = (
                np.zeros(capacity, bool),
                grown(self._shine, known, capacity),
            )
            self._shine[known:] = PLAIN_SHINE
        changed_dry = self._follow_dried(inked) if is_otherwise else self._wet[:0]
        ids, depth = (np.zeros(0, np.int32), np.zeros(0)) if water is None else water
        ids, depth = ids[depth > 0.0], depth[depth > 0.0]
        pores_mm = surface.material.pores_mm
        film, damp = (_quantised(fraction(depth, pores_mm)) for fraction in _FRACTIONS)
        self._is_wet[ids] = True
        dried = self._wet[~self._is_wet[self._wet]]
        self._is_wet[ids] = False
        self._film[dried] = self._damp[dried] = 0
        is_new = (self._film[ids] != film) | (self._damp[ids] != damp)
        self._film[ids], self._damp[ids] = film, damp
        self._wet = ids
        changed: NDArray[np.int32] = np.concatenate([changed_dry, dried, ids[is_new]])
        self._mix(changed)
        return changed

    def _follow_dried(self, inked: AnyArray) -> NDArray[np.int32]:
        """Update the dry shine; return vertices (N,) where it changed with the visible layers."""
        surface, layers = self._surface, self._surface.seen_layers
        is_same, self._layers = layers == self._layers, layers
        ids = inked if is_same else np.flatnonzero(surface.painted)
        shine = shine_of_inks(surface.material.seen_roughness, *_dried(surface, ids))
        steps, changed = np.rint(_STEPS * shine).astype(np.int8), inked[:0]
        if not len(self._dried) and not steps.any():
            return changed
        if len(self._dried) < len(self._film):
            self._dried = np.pad(self._dried, (0, len(self._film) - len(self._dried)))
        if is_same:
            self._dried[ids] = steps
            self._mix(ids)
        else:
            before, self._dried = self._dried, np.zeros_like(self._dried)
            self._dried[ids] = steps
            changed = np.flatnonzero(self._dried != before)
        result: NDArray[np.int32] = changed.astype(np.int32)
        return result

    def _mix(self, ids: AnyArray) -> None:
        """Recompute the shine of vertices (N,) from their film and the dry shine below it."""
        film = self._film[ids] / np.float32(255.0)
        dried = self._dried[ids].astype(np.float32) if len(self._dried) else np.float32(0.0)
        self._shine[ids] = np.rint(PLAIN_SHINE + dried + film * (np.float32(_STEPS) - dried))

    def shine(self, ids: AnyArray) -> NDArray[np.uint8]:
        """Return the shine (N,) of vertices relative to their material; see `PLAIN_SHINE`."""
        return self._shine[ids]

    def damp(self, ids: AnyArray) -> AnyArray | None:
        """Return the fraction (N,) of vertices under water, 0 to 1; None while nothing is wet."""
        return self._damp[ids] / 255.0 if len(self._wet) else None


def _is_otherwise_dry(surface: _Painted, roughness: float) -> bool:
    """Return whether dried ink may be rougher or glossier than a material so rough."""
    return roughness < MATT_ROUGHNESS or any(pigment.gloss for pigment in surface.pigments)


def _dried(surface: _Painted, ids: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Return gloss (N,) and hidden fraction (N,) of vertices, 0 to 1, once their inks are dry.

    Coats hide the material by the fraction 1 - exp(-3 coats); gloss is the inks' weighted mean.
    """
    pigments, coats = surface.pigments, surface.coats_at(ids)
    total = coats @ np.array([float(pigment is not WATER) for pigment in pigments])
    own = coats @ np.array([pigment.gloss for pigment in pigments]) / np.maximum(total, 1e-12)
    hidden = -np.expm1(-3.0 * total)
    return own * hidden, hidden
