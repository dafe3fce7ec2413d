"""Free arc: the part of a level line round a body where nothing obstructs the brush.

Round a vase that is all of it. A handle or a spout leaves an arc beside it: there the brush has no
room, or the surface turns away.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError, MeshError, Message
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.placement import SurfaceLine, turns_of

__all__ = ["FreeArc", "Ring", "in_the_way_error"]

Fault = TypeVar("Fault", bound=InputError)

_PER_EM, _FEWEST, _MOST = 8.0, 120, 240  # stations round a body
_TURN = 0.55  # round the axis that a line which does not close goes at least
_CLEAR = 0.7  # of the brush's length: what is nearer to its upper end is in the way
_EVEN = 0.1  # of a turn: arcs that differ by less are as long as each other
_FRONT = 0.5


@dataclass(frozen=True)
class FreeArc:
    """An interval for the middles of squares, mm to the right of where the line begins.

    Attributes
    ----------
    start, end : float
    obstacle : (float, float)
        What is in the way, as `place` counts.
    """

    start: float
    end: float
    obstacle: tuple[float, float]

    @property
    def length(self) -> float:
        """From the first middle to the last, mm."""
        return self.end - self.start

    def centred_on(self, middle: float) -> FreeArc:
        """The part of it that is centred on `middle`; of no length where that is not on it."""
        half = max(min(middle - self.start, self.end - middle), 0.0)
        return FreeArc(middle - half, middle + half, self.obstacle)

    def middle_for(self, width: float, near: float | None = None) -> float:
        """The middle of something so wide (mm), as close to `near` as it fits."""
        if near is None or width >= self.length:
            return 0.5 * (self.start + self.end)
        return min(max(near, self.start + 0.5 * width), self.end - 0.5 * width)


class Ring:
    """A level line round a body, or round as much of it as it comes.

    Parameters
    ----------
    surface : ClosestPoints
    right, left : SurfaceLine
        From one point; either may go astray on a handle.
    up : (3,) array_like
    em_mm : float
        Of what is to stand on it.

    Raises
    ------
    MeshError
        If it neither comes back to its start nor goes half round the body, or goes over and under
        it, as across a plate.
    """

    def __init__(
        self,
        surface: ClosestPoints,
        right: SurfaceLine,
        left: SurfaceLine,
        up: ArrayLike,
        em_mm: float,
    ) -> None:
        self.surface, self.em_mm = surface, em_mm
        self._up = np.asarray(up, np.float64)
        self._right, self._left = right, left
        self.closed = right.closed or left.closed
        self.length = (right if right.closed else left).length
        self._start = 0.0
        if not self.closed:
            self._start, self.length = -left.length, left.length + right.length
        if self._up[2] <= 0.0 or not (self.closed or self.goes_round):
            raise MeshError(
                "{object}: the level line of the place does not go around it; expected a body that "
                "can be written around",
                object=surface.mesh.name,
                hint="where it lies on its side, --up says which axis of the file points up",
            )

    def at(self, distance: float) -> NDArray[np.float64]:
        """The point (3,) at a distance (mm) to the right of its start; a closed ring repeats.

        Of one that is not closed the end, where it does not reach so far.
        """
        if self.closed:
            line, sign = (self._right, 1.0) if self._right.closed else (self._left, -1.0)
            return line.at(sign * distance % self.length)
        line = self._right if distance >= 0.0 else self._left
        return line.at(min(abs(distance), line.length))

    @cached_property
    def stations(self) -> NDArray[np.float64]:
        """Distances (N,) along it, mm, evenly from its start or its left end."""
        n = int(min(max(_PER_EM * self.length / self.em_mm, _FEWEST), _MOST))
        return self._start + self.length * np.arange(n) / (n if self.closed else n - 1)

    @cached_property
    def points(self) -> NDArray[np.float64]:
        """Its points (N, 3) there."""
        return np.array([self.at(one) for one in self.stations])

    @cached_property
    def turns(self) -> NDArray[np.float64]:
        """Their U (N,), counted on past 1."""
        return np.unwrap(turns_of(self.surface.mesh, self.points), period=1.0)

    @property
    def n_turns(self) -> float:
        """The turns it makes round the axis of the body."""
        step = float(np.ptp(self.turns[:2])) if self.closed else 0.0
        return float(np.ptp(self.turns)) + step

    @property
    def goes_round(self) -> bool:
        """True if it goes at least half round the axis of the body."""
        return self.n_turns >= _TURN

    def find_arc(
        self,
        room_mm: float,
        heights: Sequence[float],
        is_free: Callable[[AnyArray], bool],
        *,
        placed: bool = False,
        centred: bool = False,
    ) -> FreeArc | None:
        """The free arc for a layout; None where nothing obstructs it.

        Parameters
        ----------
        room_mm : float
            Height above the surface that is free along it.
        heights : sequence of float
            Of what stands there, mm above the line.
        is_free : callable
            Whether it can be laid at a point (3,) of the line; asked beside what is in the way.
        placed : bool
            The one at, or nearest to, where the line begins; else the longest.
        centred : bool
            Only as much of that as has where the line begins in its middle.

        Raises
        ------
        MeshError
            If it can stand nowhere.
        """
        crowded = np.any([self.crowded(room_mm, one) for one in heights], axis=0)
        if self.closed and not crowded.any():
            return None
        arcs = self._arcs(crowded, is_free)
        if not arcs:
            raise MeshError(
                "{object}: a part of it is in the way all round there; expected another place or a "
                "smaller size",
                object=self.surface.mesh.name,
            )
        if not (placed or centred):
            return arcs[0]
        nearest = min(arcs, key=lambda arc: max(arc.start, -arc.end, 0.0))
        return nearest.centred_on(0.0) if centred else nearest

    def crowded(self, room_mm: float, height: float = 0.0) -> NDArray[np.bool_]:
        """Stations (N,) at which the object obstructs a brush.

        So many mm above the line, and half an em above and below that.
        """
        is_crowded = np.zeros(len(self.stations), bool)
        normals = self.surface.find(self.points).normals
        slope = self._up - (normals @ self._up)[:, None] * normals
        slope /= np.maximum(np.linalg.norm(slope, axis=1), 1e-9)[:, None]
        for off in (-0.5 * self.em_mm, 0.0, 0.5 * self.em_mm):
            foot = self.surface.find(self.points + (height + off) * slope)
            tip = foot.points + room_mm * foot.normals
            away = np.linalg.norm(self.surface.find(tip).points - tip, axis=1)
            is_crowded |= away < _CLEAR * room_mm
        return is_crowded

    def _arcs(
        self, crowded: NDArray[np.bool_], is_free: Callable[[AnyArray], bool]
    ) -> list[FreeArc]:
        """The free arcs, the longest first."""
        n, step = len(crowded), self.length / len(crowded)
        reach = math.ceil(0.75 * self.em_mm / step)
        away = np.full(n, n)
        for k in np.flatnonzero(crowded):
            off = np.abs(np.arange(n) - k)
            away = np.minimum(away, np.minimum(off, n - off) if self.closed else off)
        if not self.closed:  # it went astray at its ends
            away = np.minimum(away, np.minimum(np.arange(n), np.arange(n)[::-1]))
        free = away > 0
        for sign in (1, -1):  # outwards from each, until there is one that is free
            for k in np.flatnonzero(away == 0):
                for j in range(1, reach + 1):
                    at = (k + sign * j) % n
                    if away[at] != j or is_free(self.points[at]):
                        break
                    free[at] = False
        return self._runs(free)

    def _runs(self, free: NDArray[np.bool_]) -> list[FreeArc]:
        n = len(free)
        if not free.any():
            return []
        first = int(np.flatnonzero(~free)[0]) if self.closed else 0
        order = (first + np.arange(n)) % n if self.closed else np.arange(n)
        turned = np.concatenate([[False], free[order], [False]])
        edges = np.flatnonzero(np.diff(turned.astype(int)))
        step = float(self.stations[1] - self.stations[0])
        starts, ends = (self._start + step * (first + edges.reshape(-1, 2).T - [[0], [1]])).tolist()
        home = ends[-1] - self.length, starts[0] + self.length
        before = [home[0] if self.closed else self._start, *ends[:-1]]
        after = [*starts[1:], home[1] if self.closed else self._start + self.length]
        longest = max(end - start for start, end in zip(starts, ends, strict=True))

        def rank(arc: FreeArc) -> tuple[bool, float]:
            off = abs((self.turn_at(0.5 * (arc.start + arc.end)) - _FRONT + 0.5) % 1.0 - 0.5)
            return arc.length < longest - _EVEN * self.length, off

        arcs = []
        low, high = self.surface.mesh.bounds[:, 2]
        height = float((self.points[:, 2].mean() - low) / (high - low))  # V of all obstacles
        for start, end, last, following in zip(starts, ends, before, after, strict=True):
            turn = self.length * round(0.5 * (start + end) / self.length) if self.closed else 0.0
            beside = (last + start, end + following)  # twice the middles of what is in the way
            nearer = beside[abs(end - turn) < abs(start - turn)]
            arcs.append(FreeArc(start - turn, end - turn, (self.turn_at(0.5 * nearer), height)))
        return sorted(arcs, key=rank)

    def turn_at(self, distance: float) -> float:
        """The U of a position on it."""
        return float(turns_of(self.surface.mesh, self.at(distance)[None])[0])


def in_the_way_error(fault: Fault, obstacle: tuple[float, float]) -> Fault:
    """Add the obstacle to a fault."""
    fields = {k: v for k, v in fault.message.fields.items() if k == "smaller"}
    u, v = obstacle
    return type(fault)(
        Message(
            "a part of the object (at {u:.2f},{v:.2f}) is in the way: {cause}",
            u=u,
            v=v,
            cause=fault.message,
            **fields,
        ),
        hint=fault.hint,
    )
