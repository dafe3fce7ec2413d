"""Progress of long work: a callback that is given the fraction done, and may stop the work."""

from __future__ import annotations

from collections.abc import Callable
from typing import overload

__all__ = ["Progress", "part_of"]

Progress = Callable[[float], None]
"""Called with the fraction done, 0 to 1, now and then; what it raises stops the work."""


@overload
def part_of(progress: Progress, low: float, high: float) -> Progress: ...
@overload
def part_of(progress: Progress | None, low: float, high: float) -> Progress | None: ...
def part_of(progress: Progress | None, low: float, high: float) -> Progress | None:
    """Return a callback for a part of the work, from one fraction of the whole to another.

    Examples
    --------
    >>> fractions = []
    >>> part_of(fractions.append, 0.5, 1.0)(0.5)
    >>> fractions
    [0.75]
    """
    if progress is None:
        return None
    return lambda fraction: progress(low + fraction * (high - low))
