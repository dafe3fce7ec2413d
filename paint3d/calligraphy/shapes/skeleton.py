"""The skeleton of a shape: branches along its strokes, and the junctions where they meet."""

from __future__ import annotations

import heapq
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.shapes.triangles import Triangles
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import arc_lengths, line_length

__all__ = ["Branch", "Junction", "Skeleton", "skeleton_of", "tidy"]


@dataclass(eq=False)
class Junction:
    """Point where branches meet or end.

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
        return line_length(self.line)

    def extend(self, side: int, line: AnyArray) -> None:
        """Go on along a line from its first (0) or last point (1), which is the line's first."""
        ends = (line[:0:-1], self.line) if side == 0 else (self.line, line[1:])
        self.line = np.concatenate(ends)
        self.__dict__.pop("length", None)

    def away_from(self, side: int) -> NDArray[np.float64]:
        """Its line from its first (0) or its last point (1) on."""
        return self.line[::-1] if side else self.line


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
        """Return whether a branch closes on itself, and no stroke is cut there."""
        one, two = branch.ends
        return one == two and one not in self.cuts and self.degrees()[one] == 2

    def is_shared(self, number: int, degrees: Counter[int]) -> bool:
        """Return whether strokes meet at a junction."""
        return degrees[number] > 2 or number in self.cuts

    def degrees(self) -> Counter[int]:
        """Number of ends of branches at each junction."""
        return Counter(number for branch in self.branches for number in branch.ends)


# ---- Tidying -------------------------------------------------------------------------------------
# Tidying a skeleton: corners are no branches, folds are one stroke, near junctions are one.


_STICKS_OUT = 0.75  # of a junction's radius: a branch that reaches less far is a corner
_HIGH = 0.6  # widths of its foot: a branch that is no higher is one too
_WINDING = 0.8  # of a branch's length counts as its reach at the least
_FOLDED = math.radians(65.0)  # between the legs of a sharp fold, and from each to its tip
_FOLD_REACH = 1.2
_ONE_JUNCTION = 1.4  # radii: junctions nearer than this are one, as where two strokes cross


def tidy(skeleton: Skeleton) -> None:
    """Prune, fold and merge a raw skeleton."""
    tidying = _Tidying(skeleton)
    tidying.prune()
    tidying.fold()
    tidying.merge()
    skeleton.branches = list(tidying.order)


class _Tidying:
    """A skeleton whose branches are known by the junctions at their ends.

    Attributes
    ----------
    junctions : dict of int to Junction
        The skeleton's own.
    order : dict of Branch to int
        The branches in order, with the order in which each was added.
    here : dict of int to dict of (Branch, int)
        The branches at each junction with the side of each that is there, in order (the values say
        nothing).
    """

    def __init__(self, skeleton: Skeleton) -> None:
        self.junctions = skeleton.junctions
        self.order: dict[Branch, int] = {}
        self.here: dict[int, dict[tuple[Branch, int], None]] = {}
        self._newest = 0
        for branch in skeleton.branches:
            self._add(branch)

    def degree(self, number: int) -> int:
        """Number of ends of branches at a junction."""
        return len(self.here.get(number, ()))

    def _add(self, branch: Branch) -> None:
        self._newest += 1
        self.order[branch] = self._newest
        for side in (0, 1):
            self.here.setdefault(branch.ends[side], {})[branch, side] = None

    def _remove(self, branch: Branch) -> None:
        del self.order[branch]
        for side in (0, 1):
            del self.here[branch.ends[side]][branch, side]

    def _branches_at(self, number: int) -> list[Branch]:
        """The branches at a junction, each once."""
        return list(dict.fromkeys(branch for branch, _ in self.here[number]))

    def prune(self) -> None:
        """Leave out branches that hardly stick out of their junction, the least first."""
        out = _Least()
        out.set((branch, self._sticks_out(branch), order) for branch, order in self.order.items())
        while (least := out.pop(_STICKS_OUT)) is not None:
            tip, base = sorted(least.ends, key=self.degree)
            self._remove(least)
            self.junctions[base].cells += least.cells + self.junctions.pop(tip).cells
            changed = self._branches_at(base)
            joined = self._pass_through(base)
            if joined is not None:
                for gone in changed:
                    out.forget(gone)
                changed = [joined]
            out.set((branch, self._sticks_out(branch), self.order[branch]) for branch in changed)

    def _sticks_out(self, branch: Branch) -> float:
        """Reach of a branch with a free end out of its junction, in radii of that."""
        one, two = branch.ends
        tip, base = (one, two) if self.degree(one) == 1 else (two, one)
        if self.degree(tip) != 1 or self.degree(base) < 3:
            return math.inf
        end, start = self.junctions[tip], self.junctions[base]
        reach = max(math.dist(end.point, start.point), _WINDING * branch.length)
        out = (reach + end.radius - start.radius) / max(start.radius, 1e-12)
        foot = branch.gates[0 if branch.ends[0] == base else 1]
        high = math.dist(end.point, 0.5 * (foot[0] + foot[1])) + end.radius
        return min(out, _STICKS_OUT * high / max(_HIGH * math.dist(*foot), 1e-12))

    def _pass_through(self, number: int) -> Branch | None:
        """Make one branch of the two at a junction where there are no more; that branch."""
        here = list(self.here[number])
        if len(here) != 2 or here[0][0] is here[1][0]:
            return None
        (a, side_a), (b, side_b) = here
        cells = a.cells + self.junctions.pop(number).cells + b.cells
        line = np.concatenate([a.away_from(side_a)[::-1], b.away_from(side_b)[1:]])
        self._remove(a)
        self._remove(b)
        gates = a.gates[1 - side_a], b.gates[1 - side_b]
        joined = Branch((a.ends[1 - side_a], b.ends[1 - side_b]), line, cells, gates)
        self._add(joined)
        return joined

    def fold(self) -> None:
        """Lead lines into the tips of sharp folds, where two legs of a stroke run together."""
        for spur in list(self.order):
            tip, base = sorted(spur.ends, key=self.degree)
            if spur not in self.order or self.degree(tip) != 1 or self.degree(base) != 3:
                continue
            here = [(b, side) for b, side in self.here[base] if b is not spur]
            if len(here) != 2 or here[0][0] is here[1][0]:
                continue
            out = spur.away_from(0 if spur.ends[0] == base else 1)
            if not _is_fold(out, self.junctions[base], [b.away_from(s) for b, s in here]):
                continue
            along = arc_lengths(out)
            into = out[along <= max(along[-1] - self.junctions[base].radius, 0.0)]
            self._remove(spur)
            self.junctions[base].cells += spur.cells + self.junctions.pop(tip).cells
            (leg, side), _ = here
            leg.extend(side, into)
            self._pass_through(base)

    def merge(self) -> None:
        """Make one junction of those that lie within each other's reach, the nearest first."""
        apart = _Least()
        apart.set(
            (branch, self._distance_in_radii(branch), order) for branch, order in self.order.items()
        )
        while (between := apart.pop(_ONE_JUNCTION)) is not None:
            one, two = between.ends
            self._remove(between)
            self.junctions[one].cells += between.cells
            if one != two:
                self._merge_into(one, two)
            changed = self._branches_at(one)
            apart.set(
                (branch, self._distance_in_radii(branch), self.order[branch]) for branch in changed
            )

    def _merge_into(self, one: int, two: int) -> None:
        """Make the second junction a part of the first."""
        target, gone = self.junctions[one], self.junctions.pop(two)
        target.members = target.members + gone.members
        target.cells += gone.cells
        target.point = np.mean([point for point, _ in target.members], axis=0)
        target.radius = max(target.radius, gone.radius)
        ends = [*self.here[one], *self.here.pop(two)]
        for branch, _ in ends:
            a, b = branch.ends
            branch.ends = (one if a == two else a, one if b == two else b)
        ends.sort(key=lambda end: (self.order[end[0]], end[1]))
        self.here[one] = dict.fromkeys(ends)

    def _distance_in_radii(self, branch: Branch) -> float:
        """Length of a branch between two junctions, in radii of the larger."""
        one, two = branch.ends
        if min(self.degree(one), self.degree(two)) < 3:
            return math.inf
        radius = max(self.junctions[one].radius, self.junctions[two].radius)
        return branch.length / max(radius, 1e-12) * (2.0 if one == two else 1.0)


class _Least:
    """Figures of branches, of which the least is taken; of equal ones that which came first."""

    def __init__(self) -> None:
        self._figures: dict[Branch, float] = {}
        self._heap: list[tuple[float, int, Branch]] = []

    def set(self, figures: Iterable[tuple[Branch, float, int]]) -> None:
        """Set the figures of branches, with the order in which each was added."""
        for branch, figure, order in figures:
            self._figures[branch] = figure
            heapq.heappush(self._heap, (figure, order, branch))

    def forget(self, branch: Branch) -> None:
        """Remove a branch."""
        self._figures.pop(branch, None)

    def pop(self, below: float) -> Branch | None:
        """Remove and return the branch with the least figure; None where that is not below one."""
        while self._heap and self._heap[0][0] < below:
            figure, _, branch = heapq.heappop(self._heap)
            if self._figures.get(branch) == figure:
                self.forget(branch)
                return branch
        return None


def _is_fold(out: AnyArray, base: Junction, legs: list[AnyArray]) -> bool:
    """Return whether a spur is no longer than two legs of a stroke would run together there."""
    directions = []
    for line in (out, *legs):
        far = np.linalg.norm(line - line[0], axis=1) >= 2.0 * base.radius
        directions.append(line[int(np.argmax(far)) if far.any() else -1] - line[0])
    back = [math.acos(_cosine(-directions[0], direction)) for direction in directions[1:]]
    half = 0.5 * math.acos(_cosine(directions[1], directions[2]))
    if max(back) > _FOLDED or half > 0.5 * _FOLDED or half <= 0.0:
        return False
    thick = base.radius * 0.5 / math.cos(half) + 0.5 * base.radius
    return line_length(out) <= _FOLD_REACH * thick * (1.0 + 1.0 / math.sin(half))


def _cosine(one: AnyArray, two: AnyArray) -> float:
    size = float(np.linalg.norm(one) * np.linalg.norm(two))
    return min(1.0, max(-1.0, float(one @ two) / size)) if size > 0.0 else 1.0


# ---- Tracing -------------------------------------------------------------------------------------
# Walking through the triangles of a shape: its skeleton as it is, then tidied.


def skeleton_of(triangles: Triangles) -> Skeleton:
    """The tidied skeleton of a shape."""
    skeleton = _trace(triangles)
    tidy(skeleton)
    return skeleton


def _trace(triangles: Triangles) -> Skeleton:
    """Walk from every triangle that has not two neighbours along those that have."""
    degrees = triangles.degrees()
    numbers = np.flatnonzero(degrees != 2)
    points = [_skeleton_end(triangles, int(t), int(degrees[t])) for t in numbers]
    radii = triangles.to_edge(np.array(points).reshape(-1, 2))
    junctions = {
        int(t): Junction(point, float(r), [int(t)])
        for t, point, r in zip(numbers, points, radii, strict=True)
    }
    seen = degrees != 2
    branches: list[Branch] = []
    for start in numbers:
        for k in range(3):
            branch = _walk_branch(triangles, int(start), k, seen)
            if branch is not None:
                first, last = (junctions[number].point[None] for number in branch.ends)
                line = np.concatenate([first, branch.line, last])
                branches.append(replace(branch, line=line))
    for start in np.flatnonzero(~seen):  # what is left are rings
        if not seen[start]:
            branches.append(_walk_ring(triangles, int(start), seen))
            point = branches[-1].line[0]
            radius = float(triangles.to_edge(point[None])[0])
            junctions[int(start)] = Junction(point, radius, [])
    return Skeleton(junctions, branches)


def _skeleton_end(triangles: Triangles, t: int, degree: int) -> NDArray[np.float64]:
    """Point where the skeleton ends or branches in a triangle."""
    if degree != 1:
        return triangles.middle(t)
    inner = int(np.argmax(triangles.neighbours[t] >= 0))
    result: NDArray[np.float64] = triangles.points[triangles.corners[t, (inner + 2) % 3]]
    return result


def _walk_branch(
    triangles: Triangles, start: int, k: int, seen: NDArray[np.bool_]
) -> Branch | None:
    """The branch through edge k of a triangle, or None where it is known or there is none."""
    first = triangles.beyond[start][k]
    if first < 0 or (seen[first] and triangles.beyond[first].count(-1) == 1):
        return None
    cells, edges = _walk_corridor(triangles, start, k, seen)
    before, onward = cells[-1], edges[-1]
    here = triangles.beyond[before][onward]
    if len(cells) == 1 and start > here:  # neighbours are walked once
        return None
    gates = triangles.edge(start, k), triangles.edge(before, onward)
    return Branch((start, here), triangles.middles_of_edges[cells, edges], cells[1:], gates)


def _walk_ring(triangles: Triangles, start: int, seen: NDArray[np.bool_]) -> Branch:
    """A branch that closes on itself, from the start's number to itself."""
    seen[start] = True
    first = int(np.argmax(triangles.neighbours[start] >= 0))
    cells, edges = _walk_corridor(triangles, start, first, seen)
    line = triangles.middles_of_edges[cells, edges]
    top = int(np.argmax(line[:, 1]))
    gate = triangles.edge(start, first)
    turned = np.concatenate([line[top:], line[: top + 1]])
    return Branch((start, start), turned, cells, (gate, gate))


def _walk_corridor(
    triangles: Triangles, start: int, k: int, seen: NDArray[np.bool_]
) -> tuple[list[int], list[int]]:
    """Triangles from one on, through its edge k, as long as they have two neighbours and are new.

    With each stands the edge by which the path leaves it. What is walked through is marked as seen.
    """
    cells, edges = [start], [k]
    while True:
        here = triangles.beyond[cells[-1]][edges[-1]]
        around = triangles.beyond[here]
        if seen[here] or around.count(-1) != 1:
            return cells, edges
        seen[here] = True
        edges.append(next(e for e in range(3) if around[e] not in (-1, cells[-1])))
        cells.append(here)
