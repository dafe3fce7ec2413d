"""Corners where one stroke ends and the next begins, although the ink goes on.

At the upper left of 口 two strokes begin, at its lower left and lower right one ends at the other:
no straightness shows that, only the custom of writing. A stroke may turn at its upper right, and
where no ring is closed also at its lower left (山) and with a hook at its lower right (月).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.shapes.continuation import row_products, turns_between
from paint3d.calligraphy.shapes.skeleton import Branch, Skeleton
from paint3d.calligraphy.shapes.triangles import Triangles
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import resample

__all__ = ["cut_at_corners", "cut_branch"]

_SHARP = 50.0  # degrees
_NEAR, _FAR = 0.8, 3.0  # half widths beside a corner between which its legs are taken
_LEAST = 2.2  # half widths from a corner to the branch's end
_STEP = 0.25  # half widths between the points looked at
_BEGINNING = (-105.0, -10.0)  # where a corner opens to, degrees: two strokes begin there
_ENDING = (15.0, 160.0)  # and there one ends at another, if a ring closes
_TRIES = 8  # corners of one branch
_AT_ONCE = 1 << 20  # distances


def cut_at_corners(
    skeleton: Skeleton,
    triangles: Triangles,
    half_widths: Callable[[AnyArray], NDArray[np.float64]],
) -> None:
    """Cut the branches of a skeleton at the corners where a stroke ends."""
    waiting = list(skeleton.branches)
    tries = _TRIES * len(waiting)
    while waiting and tries > 0:
        tries -= 1
        branch = waiting.pop()
        corner = _find_corner(branch, skeleton, half_widths)
        if corner is not None:
            waiting += cut_branch(skeleton, triangles, branch, *corner)


def cut_branch(
    skeleton: Skeleton, triangles: Triangles, branch: Branch, point: AnyArray, radius: float
) -> list[Branch]:
    """Cut a branch where its line is nearest to a point; a ring becomes one open branch."""
    line = branch.line
    at = int(np.argmin(np.linalg.norm(line - point, axis=1)))
    at = min(max(at, 1), len(line) - 2)
    if skeleton.is_ring(branch):
        number = branch.ends[0]
        skeleton.cuts.add(number)
        skeleton.junctions[number].move_to(line[at], radius)
        branch.line = np.concatenate([line[at:-1], line[: at + 1]])
        return [branch]
    number = skeleton.add(line[at], radius)
    middles = triangles.points[triangles.corners[np.array(branch.cells, np.int64)]].mean(axis=1)
    first = _nearest_point(middles, line) < at
    gate = np.array([line[at], line[at]])
    cells = np.array(branch.cells, np.int64)
    one = Branch(
        (branch.ends[0], number), line[: at + 1], cells[first].tolist(), (branch.gates[0], gate)
    )
    two = Branch(
        (number, branch.ends[1]), line[at:], cells[~first].tolist(), (gate, branch.gates[1])
    )
    skeleton.branches[skeleton.branches.index(branch)] = one
    skeleton.branches.append(two)
    return [one, two]


def _nearest_point(positions: AnyArray, points: AnyArray) -> NDArray[np.int64]:
    """Index of the nearest of points (M, 2) to each of others (N, 2), a block at a time."""
    size = max(1, _AT_ONCE // len(points))
    nearest = np.empty(len(positions), np.int64)
    for start in range(0, len(positions), size):
        block = positions[start : start + size]
        dx, dy = (block[:, None, k] - points[None, :, k] for k in (0, 1))
        nearest[start : start + size] = np.argmin(np.sqrt(dx * dx + dy * dy), axis=1)
    return nearest


def _find_corner(
    branch: Branch,
    skeleton: Skeleton,
    half_widths: Callable[[AnyArray], NDArray[np.float64]],
) -> tuple[NDArray[np.float64], float] | None:
    """The sharpest corner of a branch where a stroke ends, and its half width; or None."""
    coarse = resample(branch.line, branch.length / 16.0, 16)
    half = float(np.median(half_widths(coarse)))
    if not half > 0.0 or branch.length < 4.0 * half:
        return None
    points = resample(branch.line, _STEP * half)
    step = branch.length / (len(points) - 1)
    near, far = max(1, round(_NEAR * half / step)), max(2, round(_FAR * half / step))
    ring = skeleton.is_ring(branch)
    margin = 0 if ring else max(near + 1, round(_LEAST * half / step))
    indices = np.arange(margin, len(points) - margin)
    back, on = (_legs(points, indices, sign * np.array([near, far]), ring) for sign in (-1, 1))
    turns = turns_between(-back, on)
    for k in np.argsort(-turns, kind="stable"):
        if turns[k] <= _SHARP:
            return None
        around = turns[max(0, k - far) : k + far + 1]
        if turns[k] >= around.max() and _ends_a_stroke(back[k] + on[k], branch, skeleton):
            return points[indices[k]], half
    return None


def _legs(points: AnyArray, indices: AnyArray, reach: AnyArray, ring: bool) -> NDArray[np.float64]:
    """Unit vectors (N, 2) from corners along one of their legs, between two numbers of points."""
    at = indices[:, None] + reach
    at = at % (len(points) - 1) if ring else np.clip(at, 0, len(points) - 1)
    legs = points[at[:, 1]] - points[at[:, 0]]
    legs = np.where(_sizes(legs) > 0.0, legs, points[at[:, 1]] - points[indices])
    sizes = _sizes(legs)
    result: NDArray[np.float64] = legs / np.where(sizes > 0.0, sizes, 1.0)
    return result


def _sizes(vectors: AnyArray) -> NDArray[np.float64]:
    return np.sqrt(row_products(vectors, vectors))[:, None]


def _ends_a_stroke(opening: AnyArray, branch: Branch, skeleton: Skeleton) -> bool:
    """Return whether a stroke ends at a branch's corner, by the sum of its legs' unit vectors."""
    angle = math.degrees(math.atan2(opening[1], opening[0]))
    if _BEGINNING[0] <= angle <= _BEGINNING[1]:
        return True
    return _ENDING[0] <= angle <= _ENDING[1] and _closes_a_ring(branch, skeleton)


def _closes_a_ring(branch: Branch, skeleton: Skeleton) -> bool:
    """Return whether both ends of a branch are joined by others too."""
    start, goal = branch.ends
    beyond: dict[int, list[int]] = {}
    for other in skeleton.branches:
        if other is not branch:
            one, two = other.ends
            beyond.setdefault(one, []).append(two)
            beyond.setdefault(two, []).append(one)
    reached, waiting = {start}, [start]
    while waiting:
        here = waiting.pop()
        if here == goal:
            return True
        new = [number for number in beyond.get(here, ()) if number not in reached]
        reached.update(new)
        waiting += new
    return start == goal
