"""The skeleton of a shape: branches along its strokes, and the junctions where they meet."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["Branch", "Junction", "Skeleton", "length_of"]


@dataclass(eq=False)
class Junction:
    """Where branches meet or end.

    Attributes
    ----------
    point : (2,) float64
    radius : float
        Distance to the edge.
    cells : list of int
        Triangles that belong to none of its branches alone.
    members : list of ((2,) float64, float)
        Points and radii of the junctions that it was made of.
    """

    point: NDArray[np.float64]
    radius: float
    cells: list[int]
    members: list[tuple[NDArray[np.float64], float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.members = self.members or [(self.point, self.radius)]

    def move_to(self, point: NDArray[np.float64], radius: float) -> None:
        """Put it elsewhere."""
        self.point, self.radius, self.members = point, radius, [(point, radius)]


@dataclass(eq=False)
class Branch:
    """A part of the skeleton between two junctions or ends.

    Attributes
    ----------
    ends : (int, int)
        Numbers of the junctions at its first and at its last point.
    line : (N, 2) float64
    cells : list of int
        Triangles along it.
    gates : ((2, 2) float64, (2, 2) float64)
        The edges by which it leaves the triangles of its two ends.
    """

    ends: tuple[int, int]
    line: NDArray[np.float64]
    cells: list[int]
    gates: tuple[NDArray[np.float64], NDArray[np.float64]]

    @cached_property
    def length(self) -> float:
        """Of its line."""
        return length_of(self.line)

    def extend(self, side: int, line: AnyArray) -> None:
        """Go on along a line from its first (0) or last point (1), which is the line's first."""
        ends = (line[:0:-1], self.line) if side == 0 else (self.line, line[1:])
        self.line = np.concatenate(ends)
        self.__dict__.pop("length", None)

    def away_from(self, side: int) -> NDArray[np.float64]:
        """Its line from its first (0) or its last point (1) on."""
        return self.line[::-1] if side else self.line


def length_of(line: AnyArray) -> float:
    """The length of a line (N, 2)."""
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


@dataclass(eq=False)
class Skeleton:
    """Junctions by number, branches, and the junctions where no stroke goes on; all may change."""

    junctions: dict[int, Junction]
    branches: list[Branch]
    cuts: set[int] = field(default_factory=set)

    def add(self, point: NDArray[np.float64], radius: float) -> int:
        """Add a junction where a stroke is cut; its number."""
        number = 1 + max(self.junctions)
        self.junctions[number] = Junction(point, radius, [])
        self.cuts.add(number)
        return number

    def is_ring(self, branch: Branch) -> bool:
        """Whether a branch closes on itself, and no stroke is cut there."""
        one, two = branch.ends
        return one == two and one not in self.cuts and self.degrees()[one] == 2

    def is_shared(self, number: int, degrees: Counter[int]) -> bool:
        """Whether strokes meet at a junction."""
        return degrees[number] > 2 or number in self.cuts

    def degrees(self) -> Counter[int]:
        """How many ends of branches are at each junction."""
        return Counter(number for branch in self.branches for number in branch.ends)
