"""Sets of vertices as sorted arrays of their numbers."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray

__all__ = ["union"]

_FEW = 64  # one in so many: marking all vertices then costs more than sorting these


def union(sets: Iterable[AnyArray], capacity: int) -> NDArray[np.int32]:
    """The distinct numbers (N,) int32, rising, of some arrays of them, all below `capacity`."""
    ids = np.concatenate([np.empty(0, np.int32), *sets]).astype(np.int32, copy=False)
    if len(ids) * _FEW < capacity:
        return np.unique(ids)
    seen = np.zeros(capacity, bool)
    seen[ids] = True
    return np.flatnonzero(seen).astype(np.int32)
