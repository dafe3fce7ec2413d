"""Rows of numbers in a text, each read as the float64 that is nearest to its decimals."""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["read_rows"]

_NEWLINE, _RETURN, _SPACE, _TAB = 10, 13, 32, 9
_PLUS, _MINUS, _POINT, _ZERO = 43, 45, 46, 48
_EXPONENT = 101  # in lower case
_MOST_DIGITS = 19  # as many as a whole number of 64 bits surely holds
_LONGEST = 1 << 16  # bytes of a line
_LARGEST = 2.0**62

_TENS = 10.0 ** np.arange(23)  # those that a float64 holds exactly
_FIVES = np.array([5**k for k in range(28)], np.uint64)  # those below 2^63
_EXACT = np.uint64(2**53)  # whole numbers up to here are float64s
_ENOUGH = np.uint64(2**54)  # a quotient with so many bits can be rounded
_NONE, _ONE, _TEN = np.uint64(0), np.uint64(1), np.uint64(10)


@kernel
def _divided(digits, power):
    """The float64 nearest to digits / 10^power, power up to 27: by long division, then rounded."""
    divisor = _FIVES[power]
    quotient = digits // divisor
    rest = digits - quotient * divisor
    exponent = -power
    while quotient < _ENOUGH:
        rest <<= _ONE
        quotient <<= _ONE
        exponent -= 1
        if rest >= divisor:
            rest -= divisor
            quotient |= _ONE
    dropped = _ONE
    while quotient >> dropped >= _EXACT:
        dropped += _ONE
    kept = quotient >> dropped
    below = quotient & ((_ONE << dropped) - _ONE)
    half = _ONE << (dropped - _ONE)
    if below > half or (below == half and (rest > _NONE or kept & _ONE > _NONE)):
        kept += _ONE
    return math.ldexp(np.float64(kept), exponent + np.int64(dropped))


@kernel
def _valued(digits, power):
    """The float64 nearest to digits / 10^power; NaN where that takes more than is done here."""
    if digits == _NONE:
        return 0.0
    if power <= 0:
        if power == 0:
            return np.float64(digits)
        if digits > _EXACT or power < -22:
            return math.nan
        return np.float64(digits) * _TENS[-power]
    if digits <= _EXACT and power <= 22:
        return np.float64(digits) / _TENS[power]  # both are exact, so the quotient is rounded once
    if power < len(_FIVES):
        return _divided(digits, power)
    return math.nan


@kernel
def _read_digits(data, at, digits, count):
    """Digits from `at` on added to those before; and how many count, and where they end."""
    while at < len(data):
        digit = np.int64(data[at]) - _ZERO
        if digit < 0 or digit > 9:
            break
        digits = digits * _TEN + np.uint64(digit)
        count += 1 if digits > _NONE else 0
        at += 1
        if count > _MOST_DIGITS:
            break
    return digits, count, at


@kernel
def _read_number(data, at, exact):
    """A number from `at` on and where it ends: -1 for what is none, or a hard one."""
    n = len(data)
    negative = at < n and data[at] == _MINUS
    if negative or (at < n and data[at] == _PLUS):
        at += 1
    first = at
    digits, count, at = _read_digits(data, at, _NONE, 0)
    any_digits = at > first
    power = 0
    if not exact:
        if at < n and data[at] == _POINT:
            first = at + 1
            digits, count, at = _read_digits(data, first, digits, count)
            power = at - first
            any_digits = any_digits or at > first
        if any_digits and at < n and data[at] | 32 == _EXPONENT:
            at += 1
            fewer = at < n and data[at] == _MINUS
            if fewer or (at < n and data[at] == _PLUS):
                at += 1
            first = at
            size, _, at = _read_digits(data, at, _NONE, 0)
            if at == first or at > first + 3:
                return 0.0, 0, -1
            power += np.int64(size) if fewer else -np.int64(size)
    if not any_digits or count > _MOST_DIGITS:
        return 0.0, 0, -1
    value = _valued(digits, power)
    if not value < _LARGEST:
        return 0.0, 0, -1
    whole = np.int64(digits)
    return (-value, -whole, at) if negative else (value, whole, at)


@kernel
def _skip_blanks(data, at, delimiter):
    while at < len(data):
        c = data[at]
        if c != _SPACE and c != _RETURN and (c != _TAB or delimiter == _TAB):
            break
        at += 1
    return at


@kernel
def _line_end(data, at):
    while at < len(data) and data[at] != _NEWLINE:
        at += 1
    return at


@kernel
def _read_cell(data, at, delimiter, exact, may_lack):
    """As `_read_number`, but an empty cell is NaN where it may be."""
    value, whole, end = _read_number(data, at, exact)
    if end >= 0 or not may_lack or delimiter == 0:
        return value, whole, end
    empty = at == len(data) or data[at] == delimiter or data[at] == _NEWLINE
    return (math.nan, whole, at) if empty else (value, whole, end)


@kernel
def read_rows(data, delimiter, comment, exact, may_lack, values, whole, lines):
    """Read all lines of a text, one row of plain numbers in each that is not blank.

    Parameters
    ----------
    data : (n,) uint8
        Whole lines.
    delimiter : int
        The character between two cells; 0 for white space.
    comment : int
        Lines that begin with this character are passed over; -1 for none.
    exact : (k,) bool
        Columns that hold integers,
    may_lack : (k,) bool
        and in which an empty cell stands for NaN.
    values, whole : (k, room) float64, int64
        The same memory: filled with the numbers of a column, as floats or as integers.
    lines : (room,) int32
        Filled with the line that each row stands in, counted from 0.

    Returns
    -------
    int
        How many rows there are; -1 where one has other cells than numbers, or others than k, or
        numbers that take more than 19 digits or reach 2^62, or a line is longer than 64 KiB.
    """
    n, n_columns = len(data), len(exact)
    at, row, line = 0, 0, 0
    while at < n:
        start = at
        at = _skip_blanks(data, at, delimiter)
        if at < n and data[start] == comment:
            at = _line_end(data, at)
        elif at < n and data[at] != _NEWLINE:
            for k in range(n_columns):
                if k > 0 and delimiter > 0:
                    if at == n or data[at] != delimiter:
                        return -1
                    at = _skip_blanks(data, at + 1, delimiter)
                value, number, at = _read_cell(data, at, delimiter, exact[k], may_lack[k])
                if at < 0:
                    return -1
                if exact[k]:
                    whole[k, row] = number
                else:
                    values[k, row] = value
                ended = at
                at = _skip_blanks(data, at, delimiter)
                if delimiter == 0 and k + 1 < n_columns and at == ended:
                    return -1
            if at < n and data[at] != _NEWLINE:
                return -1
            lines[row] = line
            row += 1
        if at - start > _LONGEST:
            return -1
        at += 1
        line += 1
    return row
