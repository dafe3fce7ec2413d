"""Files of the page's data: numbers and texts by name, and arrays, packed.

A file, gzipped, is ``P3DPAGE1``, the length of the head (uint32, and four bytes of 0), the head, and
the arrays. The head is JSON: ``{"words": {..}, "arrays": {name: {"kind": "f4", "shape": [..], "at":
..}}}``, with places in bytes from the file's start, multiples of 16. All is little-endian, as
WebAssembly is. `web/src/core/bundle.ts` reads it.
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.core.atomic import write_atomically

__all__ = ["write_bundle"]

_MAGIC = b"P3DPAGE1"
_ALIGNED = 16
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
    rows, size = [], 0
    for name, array in arrays.items():
        row = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
        kind = row.dtype.str[1:]
        assert kind in _KINDS, f"{name} is {row.dtype}"
        places[name] = {"kind": kind, "shape": list(row.shape), "at": size}
        rows.append(row.tobytes() + bytes(-row.nbytes % _ALIGNED))
        size += len(rows[-1])
    head = _head(words, places)
    start = 0
    while start != len(head):  # places count from the file's start, and make the head longer
        start = len(head)
        moved = {name: {**place, "at": start + place["at"]} for name, place in places.items()}
        head = _head(words, moved)
    with write_atomically(path) as temporary, open(temporary, "wb") as raw:
        # without a name and a time, so that the same data are the same file
        with gzip.GzipFile(filename="", fileobj=raw, mode="wb", compresslevel=9, mtime=0) as file:
            file.write(head)
            file.writelines(rows)


def _head(words: Mapping[str, Any], places: Mapping[str, Any]) -> bytes:
    text = json.dumps({"words": words, "arrays": places}, separators=(",", ":")).encode()
    length = len(text).to_bytes(4, "little") + bytes(4)
    whole = _MAGIC + length + text
    return whole + b" " * (-len(whole) % _ALIGNED)
