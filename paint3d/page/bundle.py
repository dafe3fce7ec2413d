"""Files of the page's data: numbers and texts by name, and arrays, packed.

A file, gzipped, is ``P3DPAGE1``, the length of the head (uint32, and four bytes of 0), the head,
and the arrays. The head is JSON: ``{"words": {..}, "arrays": {name: {"kind": "f4", "shape": [..],
"at": .., "lags": [..]}}}``, with places in bytes from the file's start, multiples of 16.

Of an array all first bytes of its numbers come first, then all second ones, and so on. What a table
says changes little from place to place: where that is shorter, each number (as an unsigned one) is
replaced by its difference to the one `lag` places before, once for each of its `lags`. Bent shapes
take half the room so. Arrays that are alike stand there once. `web/src/core/bundle.ts` reads it.
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
_TRIED = 1 << 16  # numbers
_KINDS = {"f4", "f8", "i1", "u1", "b1", "i2", "u2", "i4", "u4", "i8", "u8"}


def write_bundle(path: Path, words: Mapping[str, Any], arrays: Mapping[str, AnyArray]) -> None:
    """Write a file of words and arrays.

    Parameters
    ----------
    path : Path
    words : mapping
        What JSON can say.
    arrays : mapping
        Of numbers.

    Raises
    ------
    ExportError
        If it cannot be written.
    """
    places: dict[str, Any] = {}
    known: dict[tuple[Any, ...], dict[str, Any]] = {}
    rows, size = [], 0
    for name, array in arrays.items():
        row = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
        kind = row.dtype.str[1:]
        assert kind in _KINDS, f"{name} is {row.dtype}"
        alike = (kind, row.shape, row.tobytes())
        if alike not in known:
            lags = _shortest_lags(row)
            data = _coded(row, lags)
            rows.append(data + bytes(-len(data) % _ALIGNED))
            known[alike] = {"kind": kind, "shape": list(row.shape), "at": size, "lags": lags}
            size += len(rows[-1])
        places[name] = known[alike]
    head, start = _head(words, places), 0
    while start != len(head):  # places count from the file's start, and make the head longer
        start = len(head)
        moved = {name: {**place, "at": start + place["at"]} for name, place in places.items()}
        head = _head(words, moved)
    with (
        write_atomically(path) as temporary,
        open(temporary, "wb") as raw,
        # without a name and a time, so that the same data are the same file
        gzip.GzipFile(filename="", fileobj=raw, mode="wb", compresslevel=9, mtime=0) as file,
    ):
        file.write(head)
        file.writelines(rows)


def _shortest_lags(row: AnyArray) -> list[int]:
    """The lags by which the beginning of an array is the shortest."""
    steps = {math.prod(row.shape[axis:]) for axis in range(1, row.ndim + 1)}
    start = row.reshape(-1)[:_TRIED]
    ways: list[list[int]] = [[]]
    if row.dtype.itemsize < 8:  # JavaScript has no fast numbers of 64 bits
        ways += [[lag] * n for lag in sorted(steps) for n in (1, 2) if 0 < lag < row.size]
    return min(ways, key=lambda lags: len(zlib.compress(_coded(start, lags), 1)))


def _coded(row: AnyArray, lags: list[int]) -> bytes:
    """The bytes of differences over lags, all first ones first."""
    width = row.dtype.itemsize
    numbers = row.reshape(-1).view(f"u{width}")
    for lag in lags:
        differences = numbers.copy()
        differences[lag:] -= numbers[:-lag]
        numbers = differences
    return numbers.view(np.uint8).reshape(-1, width).T.tobytes()


def _head(words: Mapping[str, Any], places: Mapping[str, Any]) -> bytes:
    text = json.dumps({"words": words, "arrays": places}, separators=(",", ":")).encode()
    length = len(text).to_bytes(4, "little") + bytes(4)
    whole = _MAGIC + length + text
    return whole + b" " * (-len(whole) % _ALIGNED)
