"""How the vertices of a painting shine: under water, and where ink has dried."""

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
    damp_share,
    film_share,
    shine_of_inks,
)
from paint3d.core.arrays import AnyArray, grown
from paint3d.mesh.refined_mesh import PaintMesh

__all__ = ["PLAIN_SHINE", "WetWatch", "look_when_wet"]

PLAIN_SHINE = 128
"""Of what shines as its material; 255 shines as a film of water, 1 is as matt as ink can dry."""


class _Painted(Protocol):
    """What has ink and water on it: `PaintedSurface`."""

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
    """How wet, glossy and matt all vertices are; None where all are as a material so rough."""
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
        look.film[ids], look.damp[ids] = film_share(depth, pores), damp_share(depth, pores)
    return look


_STEPS = 127  # of shine, either way
_SHARES = film_share, damp_share
_LEVELS = 15  # that are told apart: what dries is shown a few times, not in every picture


def _in_levels(shares: AnyArray) -> NDArray[np.uint8]:
    """Shares (N,) in steps of 1/255, rounded to few."""
    levels = np.rint(_LEVELS * shares).astype(np.uint8)
    result: NDArray[np.uint8] = levels * np.uint8(255 // _LEVELS)
    return result


class WetWatch:
    """How wet, glossy and matt the vertices of a surface look, followed as it changes.

    It costs next to nothing while nothing is wet and inks dry as their material is; `shine` and
    `damp` are then not to be asked for (`is_plain`).

    Parameters
    ----------
    surface : PaintedSurface
    """

    def __init__(self, surface: _Painted) -> None:
        self._surface = surface
        self._film, self._damp = np.zeros(0, np.uint8), np.zeros(0, np.uint8)
        self._dried = np.zeros(0, np.int8)  # shine when all is dry, in `_STEPS`
        self._shine = np.zeros(0, np.uint8)
        self._is_wet, self._wet = np.zeros(0, bool), np.zeros(0, np.int32)
        self._layers: Hashable = self  # none yet: at first all is looked at

    @property
    def is_plain(self) -> bool:
        """Whether all looks as its material, as far as was followed."""
        return not len(self._wet) and not len(self._dried)

    def follow(self, inked: AnyArray) -> NDArray[np.int32]:
        """Vertices (N,) that look otherwise than at the last call, by how they shine alone.

        Parameters
        ----------
        inked : (M,) int32
            Vertices whose ink may have changed: how theirs dries is found anew.
        """
        surface = self._surface
        water = surface.seen_water
        is_otherwise = _is_otherwise_dry(surface, surface.material.seen_roughness)
        if water is None and not len(self._wet) and not is_otherwise:
            return self._wet
        if len(self._film) < surface.paint_mesh.n_vertices:
            room, known = surface.paint_mesh.capacity, len(self._film)
            self._film, self._damp = (grown(a, known, room) for a in (self._film, self._damp))
            self._film[known:] = self._damp[known:] = 0
            self._is_wet, self._shine = np.zeros(room, bool), grown(self._shine, known, room)
            self._shine[known:] = PLAIN_SHINE
        otherwise = self._follow_dried(inked) if is_otherwise else self._wet[:0]
        ids, depth = (np.zeros(0, np.int32), np.zeros(0)) if water is None else water
        ids, depth = ids[depth > 0.0], depth[depth > 0.0]
        film, damp = (_in_levels(share(depth, surface.material.pores_mm)) for share in _SHARES)
        self._is_wet[ids] = True
        dried = self._wet[~self._is_wet[self._wet]]
        self._is_wet[ids] = False
        self._film[dried] = self._damp[dried] = 0
        is_new = (self._film[ids] != film) | (self._damp[ids] != damp)
        self._film[ids], self._damp[ids] = film, damp
        self._wet = ids
        changed: NDArray[np.int32] = np.concatenate([otherwise, dried, ids[is_new]])
        self._mix(changed)
        return changed

    def _follow_dried(self, inked: AnyArray) -> NDArray[np.int32]:
        """Vertices (N,) that will dry otherwise since other layers are seen."""
        surface, layers = self._surface, self._surface.seen_layers
        is_same, self._layers = layers == self._layers, layers
        ids = inked if is_same else np.flatnonzero(surface.painted)
        shine = shine_of_inks(surface.material.seen_roughness, *_dried(surface, ids))
        steps, otherwise = np.rint(_STEPS * shine).astype(np.int8), inked[:0]
        if not len(self._dried) and not steps.any():
            return otherwise
        if len(self._dried) < len(self._film):
            self._dried = np.pad(self._dried, (0, len(self._film) - len(self._dried)))
        if is_same:
            self._dried[ids] = steps
            self._mix(ids)
        else:
            before, self._dried = self._dried, np.zeros_like(self._dried)
            self._dried[ids] = steps
            otherwise = np.flatnonzero(self._dried != before)
        result: NDArray[np.int32] = otherwise.astype(np.int32)
        return result

    def _mix(self, ids: AnyArray) -> None:
        """Find anew how vertices (N,) shine, by their film and what dried below it."""
        film = self._film[ids] / np.float32(255.0)
        dried = self._dried[ids].astype(np.float32) if len(self._dried) else np.float32(0.0)
        self._shine[ids] = np.rint(PLAIN_SHINE + dried + film * (np.float32(_STEPS) - dried))

    def shine(self, ids: AnyArray) -> NDArray[np.uint8]:
        """How vertices (N,) shine beside their material (N,): see `PLAIN_SHINE`."""
        return self._shine[ids]

    def damp(self, ids: AnyArray) -> AnyArray | None:
        """How much of vertices (N,) is under water, 0 to 1 (N,); None while nothing is."""
        return self._damp[ids] / 255.0 if len(self._wet) else None


def _is_otherwise_dry(surface: _Painted, roughness: float) -> bool:
    """Whether inks that dry on it may be rougher or glossier than a material so rough."""
    return roughness < MATT_ROUGHNESS or any(pigment.gloss for pigment in surface.pigments)


def _dried(surface: _Painted, ids: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Gloss and hidden share (N,) of vertices (N,), 0 to 1, when their inks are dry.

    The more coats the more is hidden, 1 - exp(-3 coats); of several inks' gloss the shares count.
    """
    pigments, coats = surface.pigments, surface.coats_at(ids)
    total = coats @ np.array([float(pigment is not WATER) for pigment in pigments])
    own = coats @ np.array([pigment.gloss for pigment in pigments]) / np.maximum(total, 1e-12)
    hidden = -np.expm1(-3.0 * total)
    return own * hidden, hidden
