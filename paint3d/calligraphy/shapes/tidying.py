"""Tidying a skeleton: corners are no branches, folds are one stroke, near junctions are one."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable

import numpy as np

from paint3d.calligraphy.shapes.skeleton import Branch, Junction, Skeleton, length_of
from paint3d.core.arrays import AnyArray

__all__ = ["tidy"]

_STICKS_OUT = 0.75  # of a junction's radius: a branch that reaches less far is a corner
_HIGH = 0.6  # widths of its foot: a branch that is no higher is one too
_WINDING = 0.8  # of a branch's length counts as its reach at the least
_FOLDED = math.radians(65.0)  # between the legs of a sharp fold, and from each to its tip
_FOLD_REACH = 1.2
_ONE_JUNCTION = 1.4  # radii: junctions nearer than this are one, as where two strokes cross


def tidy(skeleton: Skeleton) -> None:
    """Leave out what is no branch of a skeleton, and make one of what is one."""
    tidying = _Tidying(skeleton)
    tidying.prune()
    tidying.fold()
    tidying.merge()
    skeleton.branches = list(tidying.came)


class _Tidying:
    """A skeleton whose branches are known by the junctions at their ends.

    Attributes
    ----------
    junctions : dict of int to Junction
        The skeleton's own.
    came : dict of Branch to int
        The branches in order, and as the how manieth each came.
    here : dict of int to dict of (Branch, int)
        The branches at each junction with the side of each that is there, in order (the values say
        nothing).
    """

    def __init__(self, skeleton: Skeleton) -> None:
        self.junctions = skeleton.junctions
        self.came: dict[Branch, int] = {}
        self.here: dict[int, dict[tuple[Branch, int], None]] = {}
        self._newest = 0
        for branch in skeleton.branches:
            self._add(branch)

    def degree(self, number: int) -> int:
        """How many ends of branches are at a junction."""
        return len(self.here.get(number, ()))

    def _add(self, branch: Branch) -> None:
        self._newest += 1
        self.came[branch] = self._newest
        for side in (0, 1):
            self.here.setdefault(branch.ends[side], {})[branch, side] = None

    def _remove(self, branch: Branch) -> None:
        del self.came[branch]
        for side in (0, 1):
            del self.here[branch.ends[side]][branch, side]

    def _at(self, number: int) -> list[Branch]:
        """The branches at a junction, each once."""
        return list(dict.fromkeys(branch for branch, _ in self.here[number]))

    def prune(self) -> None:
        """Leave out branches that hardly stick out of their junction, the least first."""
        out = _Least()
        out.set((branch, self._sticks_out(branch), came) for branch, came in self.came.items())
        while (least := out.pop(_STICKS_OUT)) is not None:
            tip, base = sorted(least.ends, key=self.degree)
            self._remove(least)
            self.junctions[base].cells += least.cells + self.junctions.pop(tip).cells
            changed = self._at(base)
            joined = self._pass_through(base)
            if joined is not None:
                for gone in changed:
                    out.forget(gone)
                changed = [joined]
            out.set((branch, self._sticks_out(branch), self.came[branch]) for branch in changed)

    def _sticks_out(self, branch: Branch) -> float:
        """How far a branch with a free end reaches out of its junction, in radii of that."""
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
        for spur in list(self.came):
            tip, base = sorted(spur.ends, key=self.degree)
            if spur not in self.came or self.degree(tip) != 1 or self.degree(base) != 3:
                continue
            here = [(b, side) for b, side in self.here[base] if b is not spur]
            if len(here) != 2 or here[0][0] is here[1][0]:
                continue
            out = spur.away_from(0 if spur.ends[0] == base else 1)
            if not _is_fold(out, self.junctions[base], [b.away_from(s) for b, s in here]):
                continue
            way = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(out, axis=0), axis=1))]
            into = out[way <= max(way[-1] - self.junctions[base].radius, 0.0)]
            self._remove(spur)
            self.junctions[base].cells += spur.cells + self.junctions.pop(tip).cells
            (leg, side), _ = here
            leg.extend(side, into)
            self._pass_through(base)

    def merge(self) -> None:
        """Make one junction of those that lie within each other's reach, the nearest first."""
        apart = _Least()
        apart.set((branch, self._apart(branch), came) for branch, came in self.came.items())
        while (between := apart.pop(_ONE_JUNCTION)) is not None:
            one, two = between.ends
            self._remove(between)
            self.junctions[one].cells += between.cells
            if one != two:
                self._take_in(one, two)
            changed = self._at(one)
            apart.set((branch, self._apart(branch), self.came[branch]) for branch in changed)

    def _take_in(self, one: int, two: int) -> None:
        """Make the second junction a part of the first."""
        kept, gone = self.junctions[one], self.junctions.pop(two)
        kept.members = kept.members + gone.members
        kept.cells += gone.cells
        kept.point = np.mean([point for point, _ in kept.members], axis=0)
        kept.radius = max(kept.radius, gone.radius)
        ends = [*self.here[one], *self.here.pop(two)]
        for branch, _ in ends:
            a, b = branch.ends
            branch.ends = (one if a == two else a, one if b == two else b)
        ends.sort(key=lambda end: (self.came[end[0]], end[1]))
        self.here[one] = dict.fromkeys(ends)

    def _apart(self, branch: Branch) -> float:
        """How long a branch between two junctions is, in radii of the larger."""
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
        """Give branches other figures: with each, as the how manieth it came."""
        for branch, figure, came in figures:
            self._figures[branch] = figure
            heapq.heappush(self._heap, (figure, came, branch))

    def forget(self, branch: Branch) -> None:
        """Leave a branch out."""
        self._figures.pop(branch, None)

    def pop(self, below: float) -> Branch | None:
        """The branch with the least figure, which is left out; none where that is not below one."""
        while self._heap and self._heap[0][0] < below:
            figure, _, branch = heapq.heappop(self._heap)
            if self._figures.get(branch) == figure:
                self.forget(branch)
                return branch
        return None


def _is_fold(out: AnyArray, base: Junction, legs: list[AnyArray]) -> bool:
    """Whether a spur is no longer than two legs of a stroke would run together there."""
    ways = []
    for line in (out, *legs):
        far = np.linalg.norm(line - line[0], axis=1) >= 2.0 * base.radius
        ways.append(line[int(np.argmax(far)) if far.any() else -1] - line[0])
    back = [math.acos(_cosine(-ways[0], way)) for way in ways[1:]]
    half = 0.5 * math.acos(_cosine(ways[1], ways[2]))
    if max(back) > _FOLDED or half > 0.5 * _FOLDED or half <= 0.0:
        return False
    thick = base.radius * 0.5 / math.cos(half) + 0.5 * base.radius
    return length_of(out) <= _FOLD_REACH * thick * (1.0 + 1.0 / math.sin(half))


def _cosine(one: AnyArray, two: AnyArray) -> float:
    size = float(np.linalg.norm(one) * np.linalg.norm(two))
    return min(1.0, max(-1.0, float(one @ two) / size)) if size > 0.0 else 1.0
