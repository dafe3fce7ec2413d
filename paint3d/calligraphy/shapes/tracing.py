"""Walking through the triangles of a shape: its skeleton as it is, then tidied."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.shapes.skeleton import Branch, Junction, Skeleton
from paint3d.calligraphy.shapes.tidying import tidy
from paint3d.calligraphy.shapes.triangles import Triangles

__all__ = ["skeleton_of"]


def skeleton_of(triangles: Triangles) -> Skeleton:
    """The tidied skeleton of a shape."""
    skeleton = _traced(triangles)
    tidy(skeleton)
    return skeleton


def _traced(triangles: Triangles) -> Skeleton:
    """Walk from every triangle that has not two neighbours along those that have."""
    degrees = triangles.degrees()
    numbers = np.flatnonzero(degrees != 2)
    points = [_node(triangles, int(t), int(degrees[t])) for t in numbers]
    radii = triangles.to_edge(np.array(points).reshape(-1, 2))
    junctions = {
        int(t): Junction(point, float(r), [int(t)])
        for t, point, r in zip(numbers, points, radii, strict=True)
    }
    seen = degrees != 2
    branches: list[Branch] = []
    for start in numbers:
        for k in range(3):
            branch = _walked(triangles, int(start), k, seen)
            if branch is not None:
                first, last = (junctions[number].point[None] for number in branch.ends)
                line = np.concatenate([first, branch.line, last])
                branches.append(replace(branch, line=line))
    for start in np.flatnonzero(~seen):  # what is left are rings
        if not seen[start]:
            branches.append(_ring(triangles, int(start), seen))
            point = branches[-1].line[0]
            radius = float(triangles.to_edge(point[None])[0])
            junctions[int(start)] = Junction(point, radius, [])
    return Skeleton(junctions, branches)


def _node(triangles: Triangles, t: int, degree: int) -> NDArray[np.float64]:
    """Where the skeleton ends or branches in a triangle."""
    if degree != 1:
        return triangles.middle(t)
    inner = int(np.argmax(triangles.neighbours[t] >= 0))
    result: NDArray[np.float64] = triangles.points[triangles.corners[t, (inner + 2) % 3]]
    return result


def _walked(triangles: Triangles, start: int, k: int, seen: NDArray[np.bool_]) -> Branch | None:
    """The branch through edge k of a triangle, or None where it is known or there is none."""
    first = triangles.beyond[start][k]
    if first < 0 or (seen[first] and triangles.beyond[first].count(-1) == 1):
        return None
    cells, ways = _corridor(triangles, start, k, seen)
    before, onward = cells[-1], ways[-1]
    here = triangles.beyond[before][onward]
    if len(cells) == 1 and start > here:  # neighbours are walked once
        return None
    gates = triangles.edge(start, k), triangles.edge(before, onward)
    return Branch((start, here), triangles.middles_of_edges[cells, ways], cells[1:], gates)


def _ring(triangles: Triangles, start: int, seen: NDArray[np.bool_]) -> Branch:
    """A branch that closes on itself, from the start's number to itself."""
    seen[start] = True
    first = int(np.argmax(triangles.neighbours[start] >= 0))
    cells, ways = _corridor(triangles, start, first, seen)
    line = triangles.middles_of_edges[cells, ways]
    top = int(np.argmax(line[:, 1]))
    gate = triangles.edge(start, first)
    turned = np.concatenate([line[top:], line[: top + 1]])
    return Branch((start, start), turned, cells, (gate, gate))


def _corridor(
    triangles: Triangles, start: int, k: int, seen: NDArray[np.bool_]
) -> tuple[list[int], list[int]]:
    """Triangles from one on, through its edge k, as long as they have two neighbours and are new.

    With each stands the edge by which the way leaves it. What is walked through is marked as seen.
    """
    cells, ways = [start], [k]
    while True:
        here = triangles.beyond[cells[-1]][ways[-1]]
        around = triangles.beyond[here]
        if seen[here] or around.count(-1) != 1:
            return cells, ways
        seen[here] = True
        ways.append(next(e for e in range(3) if around[e] not in (-1, cells[-1])))
        cells.append(here)
