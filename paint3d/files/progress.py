"""How far long work is, told by whoever does it to whoever waits; and how that one stops it."""

from __future__ import annotations

from collections.abc import Callable
from typing import overload

__all__ = ["Progress", "part_of"]

Progress = Callable[[float], None]
"""Called with the share done, 0 to 1, now and then; what it raises stops the work."""


@overload
def part_of(progress: Progress, low: float, high: float) -> Progress: ...
@overload
def part_of(progress: Progress | None, low: float, high: float) -> Progress | None: ...
def part_of(progress: Progress | None, low: float, high: float) -> Progress | None:
    """What a part of the work is given that takes it from one share of the whole to another.

    Examples
    --------
    >>> shares = []
    >>> part_of(shares.append, 0.5, 1.0)(0.5)
    >>> shares
    [0.75]
    """
    if progress is None:
        return None
    return lambda share: progress(low + share * (high - low))
