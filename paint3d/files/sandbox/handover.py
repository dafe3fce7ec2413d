"""Arrays from a child process to its parent: a JSON line, then the numbers, in one memory file.

The parent trusts nothing that it gets: the line's length, the arrays' types and the sum of their
sizes are checked against the file before any of it is used.
"""

from __future__ import annotations

import json
import mmap
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError

__all__ = ["receive", "send"]

MAX_LINE = 1 << 20
TYPES = {"vertices": "<f4", "faces": "<i4", "normals": "<f4", "colours": "|u1", "pixels": "|u1"}
TYPES |= {"positions": "<f8", "directions": "<f8", "rows": "<i8"}  # of records
NUMBERS_A_ROW = 3
_ALIGNED = 8  # where numbers begin: kernels take no others


def send(descriptor: int, arrays: Mapping[str, AnyArray], facts: Mapping[str, Any]) -> None:
    """Write arrays of the types in `TYPES`, (N, 3) each, and what JSON can hold besides."""
    rows = {name: len(array) for name, array in arrays.items()}
    line = json.dumps({"rows": rows, "facts": facts}).encode("ascii")
    line += b" " * (-(4 + len(line)) % _ALIGNED)
    with open(descriptor, "wb", closefd=False) as file:
        file.write(len(line).to_bytes(4, "little") + line)
        for name, array in arrays.items():
            file.write(np.ascontiguousarray(array, TYPES[name]).data)


def receive(descriptor: int) -> tuple[dict[str, AnyArray], dict[str, Any]]:
    """Return what `send` wrote; the arrays are views of the file and cannot be written.

    Raises
    ------
    MeshError
        If it is not whole.
    """
    size = os.fstat(descriptor).st_size
    try:
        if size < 4:
            raise ValueError
        data = mmap.mmap(descriptor, 0, access=mmap.ACCESS_READ)
        length = int.from_bytes(data[:4], "little")
        if length > min(MAX_LINE, size - 4):
            raise ValueError
        told = json.loads(data[4 : 4 + length])
        rows, facts, at = told["rows"], told["facts"], 4 + length
        if at + sum(_row_bytes(name) * int(n) for name, n in rows.items()) != size:
            raise ValueError
        arrays = {}
        for name, n in rows.items():
            dtype = np.dtype(TYPES[name])
            arrays[name] = np.frombuffer(data, dtype, NUMBERS_A_ROW * n, at).reshape(n, -1)
            at += arrays[name].nbytes
        return arrays, dict(facts)
    except (ValueError, KeyError, TypeError, AttributeError, OSError):
        raise MeshError("reading it ended early") from None


def _row_bytes(name: str) -> int:
    return NUMBERS_A_ROW * np.dtype(TYPES[name]).itemsize
