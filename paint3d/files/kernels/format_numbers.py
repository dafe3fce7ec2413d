"""Rows of numbers as text: the shortest decimals that read back as the same float32."""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["FLOAT_WIDTH", "INTEGER_WIDTH", "format_rows"]

FLOAT_WIDTH = 24
"""Characters that a float32 below 1e15 takes at most."""
INTEGER_WIDTH = 20

_ZERO, _MINUS, _POINT, _EXPONENT = 48, 45, 46, 101
_FEWEST, _MOST = 6, 9  # significant digits; nine tell every float32 from its neighbours
_SMALLEST = 1e-4  # numbers below get an exponent
_POWERS = 10.0 ** np.arange(55)  # to what the smallest float32, 1.4e-45, takes


@kernel
def _write_integer(value, out, at):
    """Write a whole number of at least 0; return where it ends."""
    end = at + 1
    rest = value // 10
    while rest > 0:
        end += 1
        rest //= 10
    for place in range(end - 1, at - 1, -1):
        out[place] = _ZERO + value % 10
        value //= 10
    return end


@kernel
def _write_decimal(size, out, at):
    """Write a float32 of at least 1e-4 as digits with a point; return where it ends."""
    before = math.floor(math.log10(size)) + 1
    whole, decimals = np.int64(0), 0
    for digits in range(_FEWEST, _MOST + 1):
        decimals = max(digits - before, 0)
        whole = np.int64(np.rint(size * _POWERS[decimals]))
        if np.float32(np.float64(whole) / _POWERS[decimals]) == np.float32(size):
            break
    while decimals > 0 and whole % 10 == 0:
        whole //= 10
        decimals -= 1
    shift = np.int64(_POWERS[decimals])
    at = _write_integer(whole // shift, out, at)
    if decimals > 0:
        fraction = whole % shift
        out[at] = _POINT
        for place in range(at + decimals, at, -1):
            out[place] = _ZERO + fraction % 10
            fraction //= 10
        at += decimals + 1
    return at


@kernel
def _write_tiny(size, out, at):
    """Write a float32 between 0 and 1e-4 with an exponent; return where it ends."""
    power = -math.floor(math.log10(size))
    digits, last = np.int64(0), 0
    for more in range(_FEWEST - 1, _MOST):
        last = power + more
        digits = np.int64(np.rint(size * _POWERS[last]))
        if np.float32(np.float64(digits) / _POWERS[last]) == np.float32(size):
            break
    while digits % 10 == 0:
        digits //= 10
        last -= 1
    at = _write_integer(digits, out, at)
    out[at], out[at + 1] = _EXPONENT, _MINUS
    return _write_integer(np.int64(last), out, at + 2)


@kernel
def _write_float(value, out, at):
    size = abs(np.float64(value))
    if value < 0.0:
        out[at] = _MINUS
        at += 1
    if size == 0.0:
        out[at] = _ZERO
        return at + 1
    if size < _SMALLEST:
        return _write_tiny(size, out, at)
    return _write_decimal(size, out, at)


@kernel
def format_rows(floats, integers, columns, text, text_starts, out):
    """Write rows: a piece of text, a number, a piece of text, ..., a last piece of text.

    Parameters
    ----------
    floats : (n, A) float32
        Finite, below 1e15 in size.
    integers : (n, B) int32
        At least 0.
    columns : (k,) int32
        The number after each piece of text: a column of `floats`, or of `integers` where it is
        -1 - column.
    text : (t,) uint8
        The k + 1 pieces, one after the other.
    text_starts : (k + 2,) int32
        Where each begins, and where the last ends.
    out : (room,) uint8
        At least n times the text, `FLOAT_WIDTH` a float and `INTEGER_WIDTH` an integer.

    Returns
    -------
    int
        How many bytes were written.
    """
    at = 0
    for row in range(max(len(floats), len(integers))):
        for k in range(len(columns) + 1):
            for place in range(text_starts[k], text_starts[k + 1]):
                out[at] = text[place]
                at += 1
            if k < len(columns):
                column = columns[k]
                if column >= 0:
                    at = _write_float(floats[row, column], out, at)
                else:
                    at = _write_integer(np.int64(integers[row, -1 - column]), out, at)
    return at
