"""Many arrays of different lengths as one column, each different one kept once.

A file has no room for an entry an array; and what a step left as it was is in many steps the same.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from paint3d.core.types import AnyArray
from paint3d.errors import SessionError

__all__ = ["Ragged", "pack_arrays", "unpack_arrays"]

Ragged = dict[str, AnyArray]
"""By name: the column, NAME_starts (U + 1,) int64 of the U different arrays in it, and NAME_of
(K,) int32, which of them each of the K arrays is."""


def pack_arrays(
    name: str, arrays: Sequence[AnyArray], dtype: DTypeLike, shape: tuple[int, ...] = ()
) -> Ragged:
    """Join K arrays of some type, each (n, *shape), to a column."""
    places: dict[bytes, int] = {}
    different: list[AnyArray] = []
    of = np.empty(len(arrays), np.int32)
    for k, array in enumerate(arrays):
        array = np.ascontiguousarray(array, dtype).reshape(-1, *shape)
        key = hashlib.blake2b(array.view(np.uint8).data, digest_size=16).digest()
        of[k] = places.setdefault(key, len(different))
        if of[k] == len(different):
            different.append(array)
    starts = np.concatenate([[0], np.cumsum([len(array) for array in different], dtype=np.int64)])
    column = np.concatenate([np.empty((0, *shape), dtype), *different])
    return {name: column, f"{name}_starts": starts.astype(np.int64), f"{name}_of": of}


def unpack_arrays(
    state: Mapping[str, object],
    name: str,
    count: int,
    dtype: DTypeLike,
    shape: tuple[Any, ...] = (),
) -> list[AnyArray]:
    """The K arrays of a column, as views of it; they may come from a stranger.

    Raises
    ------
    SessionError
        If the column is not of this type, or not shared out to `count` arrays.
    """
    column, starts, of = (np.asarray(state[name + end]) for end in ("", "_starts", "_of"))
    if column.dtype != dtype or column.shape[1:] != shape or column.ndim != 1 + len(shape):
        raise SessionError(f"{name} is {column.dtype} {column.shape}")
    whole = starts.dtype == np.int64 and starts.ndim == 1 and len(starts) > 0
    if not whole or starts[0] != 0 or starts[-1] != len(column) or (np.diff(starts) < 0).any():
        raise SessionError(f"{name} has {len(column)} rows that are not shared out")
    if column.dtype.kind == "f" and not np.isfinite(column).all():
        raise SessionError(f"{name} holds what is no number")
    if of.dtype != np.int32 or of.shape != (count,):
        raise SessionError(f"{name} is given {of.shape} times; expected {count}")
    if count and not 0 <= of.min() <= of.max() < len(starts) - 1:
        raise SessionError(f"{name} is given from {of.min()} to {of.max()}")
    different = [column[a:b] for a, b in pairwise(starts)]
    return [different[k] for k in of]
