"""What has dried on a surface: a row for each vertex that something dried on, and no other.

A row holds the reflectance that the vertex shows, 31 bands of 16 bits, which is the whole of what
later paint can see of all the layers below it, and the amounts that dried, for the accounts: 62
bytes and 4 a pigment. Besides, the surface has 4 bytes a vertex once anything has dried.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.glazing import Ground
from paint3d.colour.spectra import N_BANDS

__all__ = ["DryLayers"]

_FIRST_ROWS = 1024


class DryLayers:
    """Dried layers of a surface, flattened vertex by vertex.

    Attributes
    ----------
    count : int
        Vertices that something has dried on, D.
    """

    def __init__(self, n_pigments: int = 0) -> None:
        self.count = 0
        self._slots = np.empty(0, np.int32)
        self._ids = np.empty(0, np.int32)
        self._spectra = np.empty((0, N_BANDS), np.uint16)
        self._amounts = np.zeros((0, n_pigments), np.float32)

    @property
    def vertex_ids(self) -> NDArray:
        """(D,) int32, in the order in which they first dried."""
        return self._ids[: self.count]

    @property
    def amounts(self) -> NDArray:
        """(D, P) float32 of every pigment, coats times the share covered, all layers together."""
        return self._amounts[: self.count]

    @property
    def spectra(self) -> NDArray:
        """(D, 31) uint16 reflectance shown, in steps of 1/65535."""
        return self._spectra[: self.count]

    def has_row(self, vertex_ids: NDArray) -> NDArray:
        """(N,) bool: whether something has dried on the vertices (N,)."""
        if not self.count:
            return np.zeros(len(vertex_ids), bool)
        return self._slots[vertex_ids] >= 0

    def ground_under(self, ground: Ground) -> Ground:
        """The ground with these layers on it."""
        return ground._replace(slots=self._slots, spectra=self._spectra)

    def fit(self, capacity: int, n_pigments: int) -> None:
        """Know vertices up to `capacity`, if anything has dried, and so many pigments."""
        if self.count and len(self._slots) < capacity:
            slots = np.full(capacity, -1, np.int32)
            slots[: len(self._slots)] = self._slots
            self._slots = slots
        missing = n_pigments - self._amounts.shape[1]
        if missing > 0:
            self._amounts = np.pad(self._amounts, ((0, 0), (0, missing)))

    def reserve_rows(self, vertex_ids: NDArray, capacity: int) -> NDArray:
        """(N,) int32 rows of `spectra` for some distinct vertices; `settle` makes them theirs."""
        if not len(self._slots):
            self._slots = np.full(capacity, -1, np.int32)
        rows = self._slots[vertex_ids]
        fresh = rows < 0
        rows[fresh] = self.count + np.arange(np.count_nonzero(fresh), dtype=np.int32)
        wanted = self.count + np.count_nonzero(fresh)
        if wanted > len(self._ids):
            room = max(_FIRST_ROWS, wanted + wanted // 2)
            self._ids = _grown(self._ids, self.count, room)
            self._spectra = _grown(self._spectra, self.count, room)
            self._amounts = _grown(self._amounts, self.count, room)
        return rows

    def settle(self, vertex_ids: NDArray, rows: NDArray, amounts: NDArray) -> None:
        """From now on these rows are the vertices' grounds; amounts (N, P) have dried there."""
        self._slots[vertex_ids] = rows
        self._ids[rows] = vertex_ids
        self._amounts[rows] += amounts
        self.count = max(self.count, int(rows.max()) + 1)

    def restore(
        self, capacity: int, vertex_ids: NDArray, spectra: NDArray, amounts: NDArray
    ) -> None:
        """Take over layers that were kept elsewhere; see the attributes of the same names."""
        self._slots = np.full(capacity if len(vertex_ids) else 0, -1, np.int32)
        self._slots[vertex_ids] = np.arange(len(vertex_ids), dtype=np.int32)
        self._ids = np.array(vertex_ids, np.int32)
        self._spectra = np.array(spectra, np.uint16)
        self._amounts = np.array(amounts, np.float32)
        self.count = len(vertex_ids)


def _grown(array: NDArray, used: int, room: int) -> NDArray:
    grown = np.zeros((room, *array.shape[1:]), array.dtype)
    grown[:used] = array[:used]
    return grown
