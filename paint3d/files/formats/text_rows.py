"""Tables of numbers as text, millions of rows a second, read back as the same numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["UNIT_NAMES", "text_rows"]

UNIT_NAMES = {"mm": "millimetres", "cm": "centimetres", "m": "metres", "in": "inches"}
"""What is written in words where the format itself has no unit."""

CHUNK = 1 << 16  # rows formatted at a time: keeps the text in memory small
PLACE = re.compile(r"\{([fi])(\d+)\}")


def text_rows(
    row: str,
    floats: NDArray[np.float32] | None = None,
    integers: NDArray[np.int32] | None = None,
) -> Iterator[bytes]:
    r"""Yield the text of a table, part by part.

    Parameters
    ----------
    row : str
        ASCII text of a row, with ``{f0}`` for the first column of `floats`, ``{i0}`` for the
        first of `integers`, and so on: ``"v {f0} {f1} {f2}\n"``.
    floats : (n, A) float32, optional
        Finite. Written with as few digits as read back to the same float32; -0 becomes 0.
    integers : (n, B) int32, optional
        At least 0.
    """
    from paint3d.files.kernels.format_numbers import FLOAT_WIDTH, INTEGER_WIDTH, format_rows

    pieces = PLACE.split(row)
    texts = [piece.encode("ascii") for piece in pieces[0::3]]
    kinds = list(zip(pieces[1::3], map(int, pieces[2::3]), strict=True))
    columns = np.array([k if kind == "f" else -1 - k for kind, k in kinds], np.int32)
    starts = np.cumsum([0, *map(len, texts)]).astype(np.int32)
    text = np.array(list(b"".join(texts)), np.uint8)
    numbers: AnyArray = np.empty((0, 1)) if floats is None else floats
    wholes: AnyArray = np.empty((0, 1)) if integers is None else integers
    n = len(wholes if floats is None else numbers)
    width = len(text) + sum(FLOAT_WIDTH if kind == "f" else INTEGER_WIDTH for kind, _ in kinds)
    out = np.empty(min(n, CHUNK) * width, np.uint8)
    for start in range(0, n, CHUNK):
        # copies: one type of array, so one compilation of the kernel
        some_floats = np.array(numbers[start : start + CHUNK], np.float32, order="C")
        some_integers = np.array(wholes[start : start + CHUNK], np.int32, order="C")
        size = format_rows(some_floats, some_integers, columns, text, starts, out)
        yield out[:size].tobytes()
