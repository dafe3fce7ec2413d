"""Arrays: validation at the public boundary, alignment to cache lines, products of vectors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from paint3d.errors import InputError, Message, Paint3DError

__all__ = [
    "AnyArray",
    "as_array",
    "as_number",
    "cross",
    "dots_of",
    "grown",
    "length_of",
    "lengths_of",
    "zeros_on_lines",
]

AnyArray = NDArray[Any]
"""An array whose elements may be of several types, or of one that only the docstring says."""

_LINE = 64  # bytes of a cache line


def as_array(
    values: ArrayLike,
    name: str,
    shape: tuple[int | None, ...],
    dtype: DTypeLike = np.float64,
    error: type[Paint3DError] = InputError,
) -> AnyArray:
    """Return `values` as a C-contiguous finite array of the expected shape.

    Parameters
    ----------
    values : array_like
    name : str
        Name of the array in messages.
    shape : tuple
        Expected shape; None stands for any length.
    dtype : dtype
        Element type; floats must be finite.
    error : type
        The exception to raise.

    Raises
    ------
    InputError
        (or `error`) if the shape differs, the values are not numbers, or one is not finite.
    """
    try:
        array = np.ascontiguousarray(values, dtype=dtype)
    except (TypeError, ValueError, OverflowError) as cause:
        raise error("{name} is not an array of numbers: {cause}", name=name, cause=cause) from None
    fits = array.ndim == len(shape) and all(
        want is None or want == got for want, got in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("any" if n is None else str(n) for n in shape)
        raise error(
            "{name} has shape {shape}; expected ({wanted})",
            name=name, shape=array.shape, wanted=wanted,
        )  # fmt: skip
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        where = np.argwhere(~np.isfinite(array))[0].tolist()
        raise error(
            "{name} is {number}; expected a finite number",
            name=f"{name}{where}", number=array[tuple(where)],
        )  # fmt: skip
    return array


def as_number(
    value: object,
    name: str,
    low: float = -math.inf,
    high: float = math.inf,
    error: type[Paint3DError] = InputError,
) -> float:
    """Return `value` as a finite float within [low, high].

    Raises
    ------
    InputError
        (or `error`) if it is not a number, not finite, or outside the range.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise error("{name} is {value!r}; expected a number", name=name, value=value)
    try:
        number = float(value)
    except OverflowError:
        raise error(
            "{name} is a whole number of over 300 digits; expected a finite one", name=name
        ) from None
    if not math.isfinite(number):
        raise error("{name} is {number}; expected a finite number", name=name, number=number)
    if not low <= number <= high:
        if math.isinf(high):
            expected = Message("at least {low:g}", low=low)
        elif math.isinf(low):
            expected = Message("at most {high:g}", high=high)
        else:
            expected = Message("{low:g} to {high:g}", low=low, high=high)
        raise error(
            "{name} is {number:g}; expected {expected}",
            name=name, number=number, expected=expected,
        )  # fmt: skip
    return number


def zeros_on_lines(shape: int | tuple[int, ...], dtype: DTypeLike) -> AnyArray:
    """Return zeros that begin on a cache line, so that no vector of a loop straddles two."""
    kind = np.dtype(dtype)
    size = int(np.prod(shape)) * kind.itemsize
    memory = np.zeros(size + _LINE, np.uint8)
    start = -memory.ctypes.data % _LINE
    return memory[start : start + size].view(kind).reshape(shape)


def cross(u: AnyArray, v: AnyArray) -> AnyArray:
    """Cross products of vectors (..., 3), float64; for few of them faster than NumPy's own."""
    x = u[..., 1] * v[..., 2] - u[..., 2] * v[..., 1]
    y = u[..., 2] * v[..., 0] - u[..., 0] * v[..., 2]
    z = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    out = np.empty((*np.shape(x), 3))
    out[..., 0], out[..., 1], out[..., 2] = x, y, z
    return out


def lengths_of(vectors: AnyArray) -> AnyArray:
    """Lengths (...) of vectors (..., K) of few components; to the bit NumPy's norms."""
    result: AnyArray = np.sqrt(dots_of(vectors, vectors))
    return result


def dots_of(u: AnyArray, v: AnyArray) -> AnyArray:
    """Scalar products (...) of vectors (..., K) of few components; to the bit NumPy's sums.

    A sum along an axis of three takes NumPy six times as long as three products of columns.
    """
    total = u[..., 0] * v[..., 0]
    for k in range(1, u.shape[-1]):
        total = total + u[..., k] * v[..., k]
    return total


def length_of(vector: AnyArray) -> float:
    """The length of one vector (K,); to the bit NumPy's norm, in less than half its time."""
    return math.sqrt(vector.dot(vector))


def grown(array: AnyArray, used: int, room: int) -> AnyArray:
    """Copy the first `used` rows of an array to a new one of `room` rows; the rest are 0."""
    result = np.zeros((room, *array.shape[1:]), array.dtype)
    result[:used] = array[:used]
    return result
