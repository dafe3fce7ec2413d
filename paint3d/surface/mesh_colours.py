"""The colours that a mesh came with, on the vertices it is refined to: a ground to paint on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.kernels.glazing import Ground, add_between
from paint3d.colour.spectra import decode_srgb
from paint3d.core.growable import grown
from paint3d.core.types import AnyArray

__all__ = ["MeshColours"]


class MeshColours:
    """sRGB of every vertex of a refined mesh before anything was painted.

    A vertex that halves an edge has the mean of its ends' codes, as a viewer that interpolates
    codes shows it, so that refinement does not show and export can take it back.

    Parameters
    ----------
    srgb : (B, 3) uint8
        Colours of the base vertices.
    """

    def __init__(self, srgb: NDArray[np.uint8]) -> None:
        self._known = len(srgb)
        self._encoded = (srgb / 255.0).astype(np.float32)
        self._linear = decode_srgb(srgb).astype(np.float32)

    def fit(self, capacity: int) -> None:
        """Make room for so many vertices."""
        if len(self._encoded) < capacity:
            self._encoded = grown(self._encoded, self._known, capacity)
            self._linear = grown(self._linear, self._known, capacity)

    def know(self, parents: AnyArray, n_vertices: int, srgb: AnyArray) -> None:
        """Give colours to vertices that have appeared, also as codes in `srgb` (cap, 3)."""
        first, last = self._known, n_vertices
        if first == last:
            return
        add_between(parents, first, last, self._encoded)
        fresh = self._encoded[first:last]
        self._linear[first:last] = decode_srgb(fresh.astype(np.float64))
        srgb[first:last] = np.rint(fresh * 255.0)
        self._known = last

    def ground_of(self, ground: Ground) -> Ground:
        """The ground with these colours in the place of the material."""
        return ground._replace(linear_rgb=self._linear)
