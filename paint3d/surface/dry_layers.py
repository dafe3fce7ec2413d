"""What has dried on a surface: a row for each vertex that something dried on, and no other.

A row holds the reflectance that the vertex shows, 31 bands of 16 bits, which is the whole of what
later paint can see of all the layers below it, the amounts that dried, for the accounts, and the
share of the vertex that they cover: 66 bytes and 4 a pigment. Besides, the surface has 4 bytes a
vertex once anything has dried.

Where what lies below may change later (`surface.layer_stack`), a row also holds what the vertex
would show over three grey grounds: 186 bytes more, and enough to tell what it shows over any.

For undo, rows are kept as they were before paint dried on them (`mark`), and can be exchanged with
what they were at another time (`exchange`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.kernels.glazing import GROUNDS, Ground
from paint3d.colour.spectra import N_BANDS
from paint3d.core.arrays import AnyArray, grown

__all__ = ["DryLayers", "DryRows"]

_FIRST_ROWS = 1024


class DryRows(NamedTuple):
    """Rows as they are at another time (K: rows, P: pigments)."""

    count: int  # type: ignore[assignment]  # how many rows there are then; no tuple counts here
    rows: AnyArray  # (K,) int32 rows that differ
    vertex_ids: AnyArray  # (K,) int32
    spectra: AnyArray  # (K, 31) uint16
    amounts: AnyArray  # (K, P) float32
    share: AnyArray  # (K,) float32
    over: tuple[AnyArray, ...]  # (K, 31) uint16 each, or (K, 0)


class DryLayers:
    """Dried layers of a surface, flattened vertex by vertex.

    Parameters
    ----------
    n_pigments : int
    filters : bool
        Whether rows also say what they show over `kernels.layering.GROUNDS`.

    Attributes
    ----------
    count : int
        Vertices that something has dried on, D.
    changes : int
        How often rows came, went or changed.
    """

    def __init__(self, n_pigments: int = 0, filters: bool = False) -> None:
        self.count = self.changes = 0
        bands = N_BANDS if filters else 0
        self._slots = np.empty(0, np.int32)
        self._ids = np.empty(0, np.int32)
        self._spectra = np.empty((0, N_BANDS), np.uint16)
        self._amounts = np.zeros((0, n_pigments), np.float32)
        self._share = np.zeros(0, np.float32)
        self._over = tuple(np.empty((0, bands), np.uint16) for _ in GROUNDS)
        self._marked: int | None = None
        self._before: list[DryRows] = []

    @property
    def vertex_ids(self) -> NDArray[np.int32]:
        """(D,) int32, in the order in which they first dried."""
        return self._ids[: self.count]

    @property
    def amounts(self) -> NDArray[np.float32]:
        """(D, P) float32 of every pigment, coats times the share covered, all layers together."""
        return self._amounts[: self.count]

    @property
    def share(self) -> NDArray[np.float32]:
        """(D,) float32: greatest share of the vertex's area that any of the layers covers."""
        return self._share[: self.count]

    @property
    def spectra(self) -> NDArray[np.uint16]:
        """(D, 31) uint16 reflectance shown, in steps of 1/65535."""
        return self._spectra[: self.count]

    @property
    def over(self) -> tuple[AnyArray, ...]:
        """(D, 31) uint16 each: reflectance shown over each of the grey grounds."""
        return tuple(array[: self.count] for array in self._over)

    @property
    def has_filters(self) -> bool:
        """Whether rows say what they show over other grounds."""
        return self._over[0].shape[1] > 0

    def add_filters(self, over: tuple[AnyArray, ...]) -> None:
        """From now on rows say what they show over grey grounds; `over` is that of those here."""
        room = len(self._ids)
        self._over = tuple(grown(array, self.count, room) for array in over)

    def rows_of(self, vertex_ids: AnyArray) -> NDArray[np.int32]:
        """(N,) int32 rows of vertices (N,), -1 for those that nothing has dried on."""
        if not self.count:
            return np.full(len(vertex_ids), -1, np.int32)
        return self._slots[vertex_ids]

    def grey_grounds(self, ground: Ground) -> list[Ground]:
        """These layers on each of the grey grounds, for drying on them."""
        greys = [np.full(N_BANDS, grey, np.float32) for grey in GROUNDS]
        return [
            ground._replace(
                slots=self._slots, spectra=over, material=grey, linear_rgb=ground.linear_rgb[:0]
            )
            for over, grey in zip(self._over, greys, strict=True)
        ]

    def pack(self) -> None:
        """Give back the room that vertices without rows take; `fit` takes it again."""
        self._slots = self._slots[:0]

    def has_row(self, vertex_ids: AnyArray) -> NDArray[np.bool_]:
        """(N,) bool: whether something has dried on the vertices (N,)."""
        if not self.count:
            return np.zeros(len(vertex_ids), bool)
        return self._slots[vertex_ids] >= 0

    def ground_under(self, ground: Ground) -> Ground:
        """The ground with these layers on it."""
        return ground._replace(slots=self._slots, spectra=self._spectra)

    def fit(self, capacity: int, n_pigments: int) -> None:
        """Know vertices up to `capacity`, if anything has dried, and so many pigments."""
        if self.count and not len(self._slots):
            self._slots = np.full(capacity, -1, np.int32)
            self._slots[self.vertex_ids] = np.arange(self.count, dtype=np.int32)
        elif self.count:
            self._slots = _padded(self._slots, capacity)
        missing = n_pigments - self._amounts.shape[1]
        if missing > 0:
            self._amounts = np.pad(self._amounts, ((0, 0), (0, missing)))

    def reserve_rows(self, vertex_ids: AnyArray, capacity: int) -> NDArray[np.int32]:
        """(N,) int32 rows of `spectra` for some distinct vertices; `settle` makes them theirs."""
        if len(self._slots) < capacity:
            self._slots = _padded(self._slots, capacity)
        rows = self._slots[vertex_ids]
        fresh = rows < 0
        if self._marked is not None:
            self._keep_before(rows[~fresh])
        rows[fresh] = self.count + np.arange(np.count_nonzero(fresh), dtype=np.int32)
        self._reserve(self.count + int(np.count_nonzero(fresh)))
        return rows

    def settle(
        self, vertex_ids: AnyArray, rows: AnyArray, amounts: AnyArray, share: AnyArray
    ) -> None:
        """From now on these rows are the vertices' grounds.

        Amounts (N, P) have dried there and cover shares (N,) of the vertices.
        """
        self.changes += 1
        self._slots[vertex_ids] = rows
        self._ids[rows] = vertex_ids
        self._amounts[rows] += amounts
        self._share[rows] = np.maximum(self._share[rows], share)
        self.count = max(self.count, int(rows.max()) + 1)

    # -- for undo ---------------------------------------------------------------------------

    def mark(self) -> None:
        """From now on, rows are kept as they are now before anything dries on them."""
        self._marked = self.count
        self._before = []

    def since_mark(self) -> DryRows:
        """The rows as they were at the mark."""
        marked = self._marked or 0
        kept = [*self._before, self._rows(np.empty(0, np.int32), marked)]
        rows = np.concatenate([k.rows for k in kept])
        rows, first = np.unique(rows, return_index=True)  # the first time is the one before
        ids, spectra, amounts, share = (
            np.concatenate([_wide(array, self) for array in column])[first]
            for column in zip(*(k[2:6] for k in kept), strict=True)
        )
        over = [np.concatenate([k.over[i] for k in kept])[first] for i in range(len(GROUNDS))]
        return DryRows(marked, rows, ids, spectra, amounts, share, tuple(over))

    def exchange(self, then: DryRows, capacity: int) -> DryRows:
        """Make the rows what they were then; return what they were until now."""
        shared = then.rows[then.rows < self.count]
        leaving = np.arange(then.count, self.count, dtype=np.int32)
        now = self._rows(np.concatenate([shared, leaving]), self.count)
        self._slots[self._ids[leaving]] = -1
        self._amounts[leaving] = 0.0
        self._share[leaving] = 0.0
        if then.count:
            self._slots = _padded(self._slots, capacity)
            self._reserve(then.count)
        self._ids[then.rows] = then.vertex_ids
        self._spectra[then.rows] = then.spectra
        self._amounts[then.rows] = _wide(then.amounts, self)
        self._share[then.rows] = then.share
        for array, old in zip(self._over, then.over, strict=True):
            array[then.rows] = old
        self._slots[then.vertex_ids] = then.rows
        self.changes += 1
        self.count = then.count
        return now

    def _keep_before(self, rows: AnyArray) -> None:
        old = rows[rows < self._marked]
        if len(old):
            self._before.append(self._rows(old, self._marked or 0))

    def _rows(self, rows: AnyArray, count: int) -> DryRows:
        over = tuple(array[rows] for array in self._over)
        own = self._ids[rows], self._spectra[rows], self._amounts[rows], self._share[rows]
        return DryRows(count, rows, *own, over)

    def _reserve(self, wanted: int) -> None:
        if wanted > len(self._ids):
            room = max(_FIRST_ROWS, wanted + wanted // 2)
            self._ids = grown(self._ids, self.count, room)
            self._spectra = grown(self._spectra, self.count, room)
            self._amounts = grown(self._amounts, self.count, room)
            self._share = grown(self._share, self.count, room)
            self._over = tuple(grown(array, self.count, room) for array in self._over)

    def restore(
        self,
        capacity: int,
        vertex_ids: AnyArray,
        spectra: AnyArray,
        amounts: AnyArray,
        share: AnyArray,
        over: tuple[AnyArray, ...] | None = None,
    ) -> None:
        """Take over layers that were kept elsewhere; see the attributes of the same names."""
        self._slots = np.full(capacity if len(vertex_ids) else 0, -1, np.int32)
        self._slots[vertex_ids] = np.arange(len(vertex_ids), dtype=np.int32)
        self._ids = np.array(vertex_ids, np.int32)
        self._spectra = np.array(spectra, np.uint16)
        self._amounts = np.array(amounts, np.float32)
        self._share = np.array(share, np.float32)
        self.count = len(vertex_ids)
        self.changes += 1
        if over is None:
            over = tuple(np.empty((len(vertex_ids), 0)) for _ in GROUNDS)
        self._over = tuple(np.array(array, np.uint16) for array in over)


def _padded(slots: AnyArray, capacity: int) -> AnyArray:
    """Slots for so many vertices; -1 for those that nothing has dried on."""
    if len(slots) >= capacity:
        return slots
    return np.pad(slots, (0, capacity - len(slots)), constant_values=-1)


def _wide(array: AnyArray, layers: DryLayers) -> AnyArray:
    """Amounts (K, p) with a column for every pigment that is known by now; other arrays as is."""
    if array.dtype != np.float32 or array.ndim == 1:
        return array
    return np.pad(array, ((0, 0), (0, layers._amounts.shape[1] - array.shape[1])))
