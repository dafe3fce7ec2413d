"""Sparse storage of dried paint: one row for each vertex that something has dried on.

A row holds the reflectance that the vertex shows (31 bands of 16 bits), which is all that later
paint can see of the layers below it, the amounts that dried, for the ink balance, and the covered
fraction of the vertex: 66 bytes plus 4 per pigment. A surface also needs 4 bytes per vertex for
the row index once anything has dried.

Where what lies below may change later (`surface.layer_stack`), a row also holds what the vertex
would show over three grey grounds: 186 bytes more, enough to compute what it shows over any ground.

For undo, `mark` starts saving rows before paint dries on them, and `exchange` swaps rows with their
state at another time.
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
    """The rows of `DryLayers` that differ at another time (K: rows, P: pigments)."""

    count: int  # type: ignore[assignment]  # number of rows at that time; hides tuple.count
    rows: AnyArray  # (K,) int32 rows that differ
    vertex_ids: AnyArray  # (K,) int32
    spectra: AnyArray  # (K, 31) uint16
    amounts: AnyArray  # (K, P) float32
    coverage: AnyArray  # (K,) float32
    over: tuple[AnyArray, ...]  # (K, 31) uint16 each, or (K, 0)


class DryLayers:
    """Dried paint of a surface, all coats flattened into one row per vertex.

    Parameters
    ----------
    n_pigments : int
    filters : bool
        Whether rows also hold what they show over `colour.kernels.glazing.GROUNDS`.

    Attributes
    ----------
    count : int
        Number of vertices with dried paint, D.
    changes : int
        Revision number, raised whenever rows are added, removed or changed.
    """

    def __init__(self, n_pigments: int = 0, filters: bool = False) -> None:
        self.count = self.changes = 0
        bands = N_BANDS if filters else 0
        self._slots = np.empty(0, np.int32)
        self._ids = np.empty(0, np.int32)
        self._spectra = np.empty((0, N_BANDS), np.uint16)
        self._amounts = np.zeros((0, n_pigments), np.float32)
        self._coverage = np.zeros(0, np.float32)
        self._over = tuple(np.empty((0, bands), np.uint16) for _ in GROUNDS)
        self._marked: int | None = None
        self._before: list[DryRows] = []

    @property
    def vertex_ids(self) -> NDArray[np.int32]:
        """(D,) int32, in the order in which they first dried."""
        return self._ids[: self.count]

    @property
    def amounts(self) -> NDArray[np.float32]:
        """(D, P) float32 amount of each pigment, coats times the covered fraction, all coats."""
        return self._amounts[: self.count]

    @property
    def coverage(self) -> NDArray[np.float32]:
        """(D,) float32: greatest fraction of the vertex's area that any coat covers."""
        return self._coverage[: self.count]

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
        """Whether rows hold what they show over other grounds."""
        return self._over[0].shape[1] > 0

    def add_filters(self, over: tuple[AnyArray, ...]) -> None:
        """Store what rows show over grey grounds; `over`, (D, 31) each, is that of today's rows."""
        capacity = len(self._ids)
        self._over = tuple(grown(array, self.count, capacity) for array in over)

    def rows_of(self, vertex_ids: AnyArray) -> NDArray[np.int32]:
        """(N,) int32 rows of vertices (N,), -1 where nothing has dried."""
        if not self.count:
            return np.full(len(vertex_ids), -1, np.int32)
        return self._slots[vertex_ids]

    def grey_grounds(self, ground: Ground) -> list[Ground]:
        """Return this dried paint over each of the grey grounds, for paint to dry on."""
        greys = [np.full(N_BANDS, grey, np.float32) for grey in GROUNDS]
        return [
            ground._replace(
                slots=self._slots, spectra=over, material=grey, linear_rgb=ground.linear_rgb[:0]
            )
            for over, grey in zip(self._over, greys, strict=True)
        ]

    def pack(self) -> None:
        """Free the vertex-to-row index; `fit` rebuilds it."""
        self._slots = self._slots[:0]

    def has_row(self, vertex_ids: AnyArray) -> NDArray[np.bool_]:
        """(N,) bool: whether something has dried on the vertices (N,)."""
        if not self.count:
            return np.zeros(len(vertex_ids), bool)
        return self._slots[vertex_ids] >= 0

    def ground_under(self, ground: Ground) -> Ground:
        """Return the ground with this dried paint on it."""
        return ground._replace(slots=self._slots, spectra=self._spectra)

    def fit(self, capacity: int, n_pigments: int) -> None:
        """Resize to `n_pigments` and, if anything has dried, to vertices up to `capacity`."""
        if self.count and not len(self._slots):
            self._slots = np.full(capacity, -1, np.int32)
            self._slots[self.vertex_ids] = np.arange(self.count, dtype=np.int32)
        elif self.count:
            self._slots = _padded(self._slots, capacity)
        missing = n_pigments - self._amounts.shape[1]
        if missing > 0:
            self._amounts = np.pad(self._amounts, ((0, 0), (0, missing)))

    def reserve_rows(self, vertex_ids: AnyArray, capacity: int) -> NDArray[np.int32]:
        """Return rows (N,) int32 of `spectra` for distinct vertices; `settle` assigns them."""
        if len(self._slots) < capacity:
            self._slots = _padded(self._slots, capacity)
        rows = self._slots[vertex_ids]
        fresh = rows < 0
        if self._marked is not None:
            old = rows[~fresh & (rows < self._marked)]
            if len(old):
                self._before.append(self._copy_rows(old, self._marked))
        rows[fresh] = self.count + np.arange(np.count_nonzero(fresh), dtype=np.int32)
        self._reserve(self.count + int(np.count_nonzero(fresh)))
        return rows

    def settle(
        self, vertex_ids: AnyArray, rows: AnyArray, amounts: AnyArray, coverage: AnyArray
    ) -> None:
        """Assign rows (N,) from `reserve_rows` to vertices on which paint has dried.

        Adds the amounts (N, P) that dried, which cover fractions `coverage` (N,) of the vertices.
        """
        self.changes += 1
        self._slots[vertex_ids] = rows
        self._ids[rows] = vertex_ids
        self._amounts[rows] += amounts
        self._coverage[rows] = np.maximum(self._coverage[rows], coverage)
        self.count = max(self.count, int(rows.max()) + 1)

    # -- for undo ---------------------------------------------------------------------------

    def mark(self) -> None:
        """Save every row from now on before paint dries on it."""
        self._marked = self.count
        self._before = []

    def since_mark(self) -> DryRows:
        """Return the changed rows as they were at the mark."""
        marked = self._marked or 0
        saved = [*self._before, self._copy_rows(np.empty(0, np.int32), marked)]
        rows = np.concatenate([s.rows for s in saved])
        rows, first = np.unique(rows, return_index=True)  # a row's first copy is the oldest
        ids, spectra, amounts, coverage = (
            np.concatenate([_wide(array, self) for array in column])[first]
            for column in zip(*(s[2:6] for s in saved), strict=True)
        )
        over = [np.concatenate([s.over[i] for s in saved])[first] for i in range(len(GROUNDS))]
        return DryRows(marked, rows, ids, spectra, amounts, coverage, tuple(over))

    def exchange(self, then: DryRows, capacity: int) -> DryRows:
        """Set the rows to another state; return the state that they had."""
        shared = then.rows[then.rows < self.count]
        leaving = np.arange(then.count, self.count, dtype=np.int32)
        now = self._copy_rows(np.concatenate([shared, leaving]), self.count)
        self._slots[self._ids[leaving]] = -1
        self._amounts[leaving] = 0.0
        self._coverage[leaving] = 0.0
        if then.count:
            self._slots = _padded(self._slots, capacity)
            self._reserve(then.count)
        self._ids[then.rows] = then.vertex_ids
        self._spectra[then.rows] = then.spectra
        self._amounts[then.rows] = _wide(then.amounts, self)
        self._coverage[then.rows] = then.coverage
        for array, old in zip(self._over, then.over, strict=True):
            array[then.rows] = old
        self._slots[then.vertex_ids] = then.rows
        self.changes += 1
        self.count = then.count
        return now

    def _copy_rows(self, rows: AnyArray, count: int) -> DryRows:
        over = tuple(array[rows] for array in self._over)
        own = self._ids[rows], self._spectra[rows], self._amounts[rows], self._coverage[rows]
        return DryRows(count, rows, *own, over)

    def _reserve(self, wanted: int) -> None:
        if wanted > len(self._ids):
            capacity = max(_FIRST_ROWS, wanted + wanted // 2)
            self._ids = grown(self._ids, self.count, capacity)
            self._spectra = grown(self._spectra, self.count, capacity)
            self._amounts = grown(self._amounts, self.count, capacity)
            self._coverage = grown(self._coverage, self.count, capacity)
            self._over = tuple(grown(array, self.count, capacity) for array in self._over)

    def restore(
        self,
        capacity: int,
        vertex_ids: AnyArray,
        spectra: AnyArray,
        amounts: AnyArray,
        coverage: AnyArray,
        over: tuple[AnyArray, ...] | None = None,
    ) -> None:
        """Replace all rows by saved ones; the arrays are those of the properties' names."""
        self._slots = np.full(capacity if len(vertex_ids) else 0, -1, np.int32)
        self._slots[vertex_ids] = np.arange(len(vertex_ids), dtype=np.int32)
        self._ids = np.array(vertex_ids, np.int32)
        self._spectra = np.array(spectra, np.uint16)
        self._amounts = np.array(amounts, np.float32)
        self._coverage = np.array(coverage, np.float32)
        self.count = len(vertex_ids)
        self.changes += 1
        if over is None:
            over = tuple(np.empty((len(vertex_ids), 0)) for _ in GROUNDS)
        self._over = tuple(np.array(array, np.uint16) for array in over)


def _padded(slots: AnyArray, capacity: int) -> AnyArray:
    """Return slots for at least `capacity` vertices; -1 where nothing has dried."""
    if len(slots) >= capacity:
        return slots
    return np.pad(slots, (0, capacity - len(slots)), constant_values=-1)


def _wide(array: AnyArray, layers: DryLayers) -> AnyArray:
    """Return amounts (K, p) with a column for every pigment known now; other arrays as they are."""
    if array.dtype != np.float32 or array.ndim == 1:
        return array
    return np.pad(array, ((0, 0), (0, layers._amounts.shape[1] - array.shape[1])))
