"""Serialization of states of arrays, numbers and texts.

JSON holds arrays as lists (`listed`, `record_words`). An archive holds arrays apart from the rest
(`split_state`, `join_state`), and many arrays of different lengths as one column: one entry an
array would be too many (`starts_of`, `spans_of`; `pack_arrays` and `unpack_arrays` store equal ones
once, since steps of a history share what they left unchanged).
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import fields
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from paint3d.core.arrays import AnyArray
from paint3d.errors import SessionError

__all__ = [
    "Ragged",
    "join_state",
    "known_fields",
    "listed",
    "pack_arrays",
    "record_words",
    "spans_of",
    "split_state",
    "starts_of",
    "unpack_arrays",
]

# ---- As JSON -------------------------------------------------------------------------------------


def listed(values: Mapping[str, object]) -> dict[str, Any]:
    """Return values with arrays as lists; floats read back exactly."""
    return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in values.items()}


def record_words(record: Any) -> dict[str, Any]:
    """Return the fields that a dataclass is made of, with arrays as lists."""
    return listed(
        {field.name: getattr(record, field.name) for field in fields(record) if field.init}
    )


def known_fields(kind: type[Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return those values that are fields of a dataclass: what a later version wrote is dropped."""
    names = {field.name for field in fields(kind)}
    return {name: value for name, value in values.items() if name in names}


# ---- Arrays apart from the rest ------------------------------------------------------------------


def split_state(
    state: Mapping[str, object], prefix: str
) -> tuple[dict[str, Any], dict[str, AnyArray]]:
    """Return texts and numbers by themselves, and arrays by their path through the mappings."""
    words, arrays = dict[str, Any](), dict[str, AnyArray]()
    for name, value in state.items():
        if isinstance(value, np.ndarray):
            arrays[f"{prefix}{name}"] = value
        elif isinstance(value, Mapping):
            words[name], own = split_state(value, f"{prefix}{name}/")
            arrays |= own
        else:
            words[name] = value
    return words, dict(sorted(arrays.items()))


def join_state(
    words: Mapping[str, object], arrays: Mapping[str, AnyArray], prefix: str
) -> dict[str, Any]:
    """Join what `split_state` took apart: arrays of a prefix, and of mappings one level down."""
    state: dict[str, object] = {}
    for name, value in words.items():
        path = f"{prefix}{name}/"
        inner = {k.removeprefix(path): v for k, v in arrays.items() if k.startswith(path)}
        state[name] = {**value, **inner} if inner and isinstance(value, Mapping) else value
    own = {k.removeprefix(prefix): v for k, v in arrays.items() if k.startswith(prefix)}
    return state | {name: array for name, array in own.items() if "/" not in name}


# ---- Many arrays in a column ---------------------------------------------------------------------


def starts_of(lengths: Sequence[int]) -> AnyArray:
    """Compute where each of K arrays starts in their column, and the end: (K + 1,) int64."""
    return np.concatenate([[0], np.cumsum(lengths, dtype=np.int64)]).astype(np.int64)


def spans_of(starts: AnyArray, n_rows: int, least: int = 0) -> list[slice] | None:
    """Compute the slice of each array in a column of `n_rows`; None if untrusted starts are wrong.

    Parameters
    ----------
    starts : (K + 1,) int64
    n_rows : int
    least : int
        Rows that each has at least.
    """
    whole = starts.dtype == np.int64 and starts.ndim == 1 and len(starts) > 0
    if not whole or starts[0] != 0 or starts[-1] != n_rows or (np.diff(starts) < least).any():
        return None
    return [slice(int(a), int(b)) for a, b in pairwise(starts)]


Ragged = dict[str, AnyArray]
"""NAME: the column; NAME_starts (U + 1,) int64: where its U distinct arrays start; NAME_of (K,)
int32: the distinct array that each of the K arrays is."""


def pack_arrays(
    name: str, arrays: Sequence[AnyArray], dtype: DTypeLike, shape: tuple[int, ...] = ()
) -> Ragged:
    """Join K arrays of one type, each (n, *shape), to a column."""
    index_of: dict[bytes, int] = {}
    distinct: list[AnyArray] = []
    of = np.empty(len(arrays), np.int32)
    for k, array in enumerate(arrays):
        array = np.ascontiguousarray(array, dtype).reshape(-1, *shape)
        digest = hashlib.blake2b(array.view(np.uint8).data, digest_size=16).digest()
        of[k] = index_of.setdefault(digest, len(distinct))
        if of[k] == len(distinct):
            distinct.append(array)
    starts = starts_of([len(array) for array in distinct])
    column = np.concatenate([np.empty((0, *shape), dtype), *distinct])
    return {name: column, f"{name}_starts": starts, f"{name}_of": of}


def unpack_arrays(
    state: Mapping[str, object],
    name: str,
    count: int,
    dtype: DTypeLike,
    shape: tuple[Any, ...] = (),
) -> list[AnyArray]:
    """Return the K arrays of an untrusted column, as views of it.

    Raises
    ------
    SessionError
        If the column is not of this type, or not divided into `count` arrays.
    """
    column, starts, of = (np.asarray(state[name + end]) for end in ("", "_starts", "_of"))
    if column.dtype != dtype or column.shape[1:] != shape or column.ndim != 1 + len(shape):
        raise SessionError(
            "{name} is {column_dtype} {column_shape}",
            name=name,
            column_dtype=column.dtype,
            column_shape=column.shape,
        )
    spans = spans_of(starts, len(column))
    if spans is None:
        raise SessionError(
            "{name} has {n} rows, which its starts do not divide", name=name, n=len(column)
        )
    if column.dtype.kind == "f" and not np.isfinite(column).all():
        raise SessionError("{name} holds what is not a finite number", name=name)
    if of.dtype != np.int32 or of.shape != (count,):
        raise SessionError(
            "{name} is given {of_shape} times; expected {count}",
            name=name,
            of_shape=of.shape,
            count=count,
        )
    if count and not 0 <= of.min() <= of.max() < len(spans):
        raise SessionError(
            "{name} is given from {least} to {most}",
            name=name,
            least=of.min(),
            most=of.max(),
        )
    distinct = [column[span] for span in spans]
    return [distinct[k] for k in of]
