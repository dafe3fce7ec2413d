"""Packed files of the page's data: JSON words by name, and arrays.

A file, gzipped, is ``P3DPAGE1``, the length of the head (uint32, and four bytes of 0), the head,
and the arrays. The head is JSON: ``{"words": {..}, "arrays": {name: {"kind": "f4", "shape": [..],
"at": .., "lags": [..]}}}``, with offsets in bytes from the file's start, multiples of 16.

Of an array the first bytes of all numbers come first, then all second ones, and so on. Tables are
smooth: where that packs smaller, each number (as an unsigned one) is replaced by its difference to
the one `lag` elements before, once for each of its `lags`. That halves the tables of bent shapes.
Equal arrays are stored once. `web/src/core/bundle.ts` reads it.
"""

from __future__ import annotations

import gzip
import json
import math
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.core.atomic import write_atomically

__all__ = ["write_bundle"]

_MAGIC = b"P3DPAGE1"
_ALIGNED = 16
_TRIED = 1 << 16  # numbers that lags are chosen by
_KINDS = {"f4", "f8", "i1", "u1", "b1", "i2", "u2", "i4", "u4", "i8", "u8"}


def write_bundle(path: Path, words: Mapping[str, Any], arrays: Mapping[str, AnyArray]) -> None:
    """Write a file of words and arrays.

    Parameters
    ----------
    path : Path
    words : mapping
        Serializable as JSON.
    arrays : mapping
        Of numbers, by name.

    Raises
    ------
    ExportError
        If it cannot be written.
    """
    entries: dict[str, Any] = {}
    stored: dict[tuple[Any, ...], dict[str, Any]] = {}
    blocks, size = [], 0
    for name, array in arrays.items():
        row = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
        kind = row.dtype.str[1:]
        assert kind in _KINDS, f"{name} is {row.dtype}"
        key = (kind, row.shape, row.tobytes())
        if key not in stored:
            lags = _best_lags(row)
            data = _encode(row, lags)
            blocks.append(data + bytes(-len(data) % _ALIGNED))
            stored[key] = {"kind": kind, "shape": list(row.shape), "at": size, "lags": lags}
            size += len(blocks[-1])
        entries[name] = stored[key]
    head, start = _head(words, entries), 0
    while start != len(head):  # offsets count from the file's start, and make the head longer
        start = len(head)
        moved = {name: {**entry, "at": start + entry["at"]} for name, entry in entries.items()}
        head = _head(words, moved)
    with (
        write_atomically(path) as temporary,
        open(temporary, "wb") as raw,
        # without a name and a time, so that equal data give equal files
        gzip.GzipFile(filename="", fileobj=raw, mode="wb", compresslevel=9, mtime=0) as file,
    ):
        file.write(head)
        file.writelines(blocks)


def _best_lags(row: AnyArray) -> list[int]:
    """Choose the lags with which the beginning of an array packs smallest."""
    steps = {math.prod(row.shape[axis:]) for axis in range(1, row.ndim + 1)}
    start = row.reshape(-1)[:_TRIED]
    candidates: list[list[int]] = [[]]
    if row.dtype.itemsize < 8:  # JavaScript has no fast numbers of 64 bits
        candidates += [[lag] * n for lag in sorted(steps) for n in (1, 2) if 0 < lag < row.size]
    return min(candidates, key=lambda lags: len(zlib.compress(_encode(start, lags), 1)))


def _encode(row: AnyArray, lags: list[int]) -> bytes:
    """Encode an array as differences over lags, the first bytes of all numbers first."""
    width = row.dtype.itemsize
    numbers = row.reshape(-1).view(f"u{width}")
    for lag in lags:
        differences = numbers.copy()
        differences[lag:] -= numbers[:-lag]
        numbers = differences
    return numbers.view(np.uint8).reshape(-1, width).T.tobytes()


def _head(words: Mapping[str, Any], entries: Mapping[str, Any]) -> bytes:
    """Make the head of a file, padded to a multiple of 16 bytes."""
    text = json.dumps({"words": words, "arrays": entries}, separators=(",", ":")).encode()
    length = len(text).to_bytes(4, "little") + bytes(4)
    whole = _MAGIC + length + text
    return whole + b" " * (-len(whole) % _ALIGNED)
