"""How the vertices of a painting shine: under water, and where an ink has dried with a gloss."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.pigments import WATER
from paint3d.colour.wet_look import WetLook, damp_share, film_share
from paint3d.core.growable import grown
from paint3d.core.types import AnyArray
from paint3d.surface.ink_store import InkStore

__all__ = ["WetWatch", "gloss_of_inks", "look_when_wet"]


def look_when_wet(store: InkStore, water: tuple[AnyArray, AnyArray] | None) -> WetLook | None:
    """How wet and glossy all vertices are; None where all are as their material.

    Parameters
    ----------
    store : InkStore
    water : (C,) int32 and (C,) float64, or None
        Vertices and how deep the water stands on each, mm.
    """
    gloss = gloss_of_inks(store)
    if water is None and gloss is None:
        return None
    n, pores = store.paint_mesh.n_vertices, store.material.pores_mm
    film, damp = np.zeros(n, np.float32), np.zeros(n, np.float32)
    if water is not None:
        ids, depth = water
        film[ids], damp[ids] = film_share(depth, pores), damp_share(depth, pores)
    return WetLook(film, damp, np.zeros(n, np.float32) if gloss is None else gloss)


_SHARES = film_share, damp_share
_LEVELS = 15  # that are told apart: what dries is shown a few times, not in every picture


def _in_levels(shares: AnyArray) -> NDArray[np.uint8]:
    """Shares (N,) in steps of 1/255, rounded to few."""
    levels = np.rint(_LEVELS * shares).astype(np.uint8)
    result: NDArray[np.uint8] = levels * np.uint8(255 // _LEVELS)
    return result


class WetWatch:
    """How wet and glossy the vertices of a surface look, in steps of 1/255, followed as it changes.

    It costs next to nothing while nothing is wet and no ink dries with a gloss; `smooth` and `damp`
    are then not to be asked for (`is_plain`).

    Parameters
    ----------
    store : InkStore
    water : callable
        Returns what `look_when_wet` takes.
    is_seen : callable
        Whether the layer that is painted on is visible.
    """

    def __init__(
        self,
        store: InkStore,
        water: Callable[[], tuple[AnyArray, AnyArray] | None],
        is_seen: Callable[[], bool] = lambda: True,
    ) -> None:
        self._store, self._water, self._is_seen = store, water, is_seen
        self._film, self._damp, self._gloss = (np.zeros(0, np.uint8) for _ in range(3))
        self._is_wet, self._wet = np.zeros(0, bool), np.zeros(0, np.int32)
        self._followed: tuple[object, bool] = (store.dry_layers, True)

    @property
    def is_plain(self) -> bool:
        """Whether all looks as its material, as far as was followed."""
        return not len(self._wet) and not len(self._gloss)

    def follow(self, inked: AnyArray) -> NDArray[np.int32]:
        """Vertices (N,) that look otherwise than at the last call, by their water alone.

        Parameters
        ----------
        inked : (M,) int32
            Vertices whose ink may have changed: the gloss of theirs is found anew.
        """
        water, store = self._water(), self._store
        if water is None and not len(self._wet) and not any(p.gloss for p in store.pigments):
            return self._wet
        if len(self._film) < store.paint_mesh.n_vertices:
            room, known = store.paint_mesh.capacity, len(self._film)
            self._film, self._damp = (grown(a, known, room) for a in (self._film, self._damp))
            self._film[known:] = self._damp[known:] = 0
            self._is_wet = np.zeros(room, bool)
        otherwise = self._follow_gloss(inked)
        ids, depth = (np.zeros(0, np.int32), np.zeros(0)) if water is None else water
        ids, depth = ids[depth > 0.0], depth[depth > 0.0]
        film, damp = (_in_levels(share(depth, store.material.pores_mm)) for share in _SHARES)
        self._is_wet[ids] = True
        dried = self._wet[~self._is_wet[self._wet]]
        self._is_wet[ids] = False
        self._film[dried] = self._damp[dried] = 0
        is_new = (self._film[ids] != film) | (self._damp[ids] != damp)
        self._film[ids], self._damp[ids] = film, damp
        self._wet = ids
        changed: NDArray[np.int32] = np.concatenate([otherwise, dried, ids[is_new]])
        return changed

    def _follow_gloss(self, inked: AnyArray) -> NDArray[np.int32]:
        """Vertices (N,) whose gloss is another since another layer is painted on, or is seen."""
        store, followed = self._store, (self._store.dry_layers, self._is_seen())
        is_same, self._followed = followed == self._followed, followed
        ids = inked if is_same else np.arange(store.paint_mesh.n_vertices, dtype=np.int32)
        gloss = gloss_of_inks(store, ids)
        if gloss is None:
            return ids[:0]
        self._gloss = np.pad(self._gloss, (0, len(self._film) - len(self._gloss)))
        now = np.rint(255.0 * gloss * followed[1]).astype(np.uint8)
        otherwise = ids[:0] if is_same else ids[self._gloss[ids] != now]
        self._gloss[ids] = now
        return otherwise

    def smooth(self, ids: AnyArray) -> NDArray[np.uint8]:
        """How smooth vertices (N,) are beside their material, in steps of 1/255 (N,)."""
        film = self._film[ids]
        return np.maximum(film, self._gloss[ids]) if len(self._gloss) else film

    def damp(self, ids: AnyArray) -> AnyArray:
        """How much of vertices (N,) is under water, 0 to 1 (N,)."""
        shares: AnyArray = self._damp[ids] / 255.0
        return shares


def gloss_of_inks(store: InkStore, ids: AnyArray | None = None) -> NDArray[np.float32] | None:
    """Gloss (V,), 0 to 1, of the inks on each vertex when they are dry; None where none has any.

    Of some vertices (N,) int32 if they are given.

    An ink's gloss comes up to its own as its coats cover more, 1 - exp(-3 coats); of several the
    shares count.
    """
    own = np.array([pigment.gloss for pigment in store.pigments])
    if not own.any():
        return None
    chosen = np.arange(store.paint_mesh.n_vertices, dtype=np.int32) if ids is None else ids
    amounts = store.ink.amounts[chosen].astype(np.float64)
    rows = store.dry_layers.rows_of(chosen)
    amounts[rows >= 0] += store.dry_layers.amounts[rows[rows >= 0]]
    coats = amounts @ np.array([float(pigment is not WATER) for pigment in store.pigments])
    mean: NDArray[np.float64] = (amounts @ own) / np.maximum(coats, 1e-12)
    result: NDArray[np.float32] = (mean * -np.expm1(-3.0 * coats)).astype(np.float32)
    return result
