"""Measurements of a mark on the surface, against the path of the pen that made it.

A `Mark` is a cloud of small pieces of the surface with what lies on them; a `Way` is the line on
the surface that the pen went, cut into even steps. Along it a mark has stations: pieces belong to
that step of the way which is nearest. All lengths are mm, ink is in full coats x mm2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from paint3d.colour.pigments import WATER
from paint3d.core.arrays import cross
from paint3d.mesh.base_surface import make_base_surface
from paint3d.mesh.bvh import ClosestPoints
from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "Mark",
    "Stations",
    "Way",
    "begins_and_goes_on",
    "beyond",
    "ink_per_mm",
    "inked_share",
    "largest_jump",
    "largest_rise",
    "off_the_way",
    "stations",
    "stray",
    "strongest_spot",
    "take_mark",
]

INKED = 0.25  # share of a piece that is covered: less is the fringe of a neighbour
CUTS = 4  # a face is measured in so many steps along each edge
STEP_MM = 0.25
LONGEST_CUT_MM = 10.0
REACH_MM = 3.5  # of a footprint that leans by 50 degrees, with its soft edge
IN_THE_AIR_MM = 0.5  # a step of a way that lies farther off the surface leads through the air


class Mark(NamedTuple):
    """Pieces of the surface with paint on them.

    Attributes
    ----------
    points : (M, 3) float64
        Where, mm.
    areas : (M,) float64
        mm2.
    cover : (M,) float64
        Share that is covered, 0 to 1.
    ink : (M,) float64
        Full coats times that share.
    """

    points: NDArray
    areas: NDArray
    cover: NDArray
    ink: NDArray

    def where(self, chosen: NDArray[np.bool_]) -> Mark:
        """Only some of it."""
        return Mark(*(part[chosen] for part in self))

    def within(self, way: Way, distance_mm: float) -> Mark:
        """Keep the points within a distance of a path."""
        return self.where(way.tree.query(self.points)[0] <= distance_mm)


class Way:
    """The way of a pen on the surface, in even steps.

    Parameters
    ----------
    points : (N, 3) array_like
        mm; what is not finite is left out.
    normals : (N, 3) or (3,) array_like
        Of the surface there.
    step_mm : float
    surface : ClosestPoints, optional
        Where the pen's ray leaps to what lies behind, the way leads through the air: those steps
        are left out, for nothing can be painted there. And the middle of a mark is looked for
        along it. By default all steps lie on the surface, and it is flat.
    leap_mm : float
        Between points farther apart the way leads through the air, too: past an edge that hides
        what lies between, however near to the surface.

    Attributes
    ----------
    points, tangents, sides : (K, 3) float64
        Where each step lies, where it leads, and the unit vector to its left on the surface.
    at : (K,) float64
        How far it went until there, mm.
    on_surface : (K,) bool
        Whether each step lies on the surface.
    surface : ClosestPoints or None
        As given.
    """

    def __init__(
        self,
        points: ArrayLike,
        normals: ArrayLike = (0.0, 0.0, 1.0),
        step_mm: float = STEP_MM,
        surface: ClosestPoints | None = None,
        leap_mm: float = np.inf,
    ) -> None:
        given = np.asarray(points, float)
        up = np.broadcast_to(np.asarray(normals, float), given.shape)
        kept = np.isfinite(given).all(axis=1)
        given, up = given[kept], up[kept]
        moved = np.concatenate([[True], np.linalg.norm(np.diff(given, axis=0), axis=1) > 1e-9])
        given, up = given[moved], up[moved]
        assert len(given) > 1, "a way of one point"
        behind = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(given, axis=0), axis=1))])
        self.at = np.linspace(0.0, behind[-1], max(2, round(behind[-1] / step_mm) + 1))
        self.points = np.stack([np.interp(self.at, behind, c) for c in given.T], axis=1)
        up = np.stack([np.interp(self.at, behind, c) for c in up.T], axis=1)
        self.tangents = _unit(np.gradient(self.points, self.at, axis=0))
        self.sides = _unit(np.cross(up, self.tangents))
        self.tree = cKDTree(self.points)
        self.on_surface = np.ones(len(self.at), bool)
        self.surface = surface
        if surface is not None:
            off = np.linalg.norm(surface.find(self.points).points - self.points, axis=1)
            self.on_surface = off <= IN_THE_AIR_MM
        for k in np.flatnonzero(np.diff(behind) > leap_mm):
            self.on_surface[(self.at > behind[k]) & (self.at < behind[k + 1])] = False

    @property
    def length_mm(self) -> float:
        """Length of the path."""
        return float(self.at[-1])

    @property
    def in_the_air_mm(self) -> float:
        """Length of the parts that lead through the air."""
        return float((~self.on_surface).mean()) * self.length_mm

    def place(self, points: NDArray) -> tuple[NDArray, NDArray]:
        """Compute positions along the path (also beyond its ends) and distances to its left."""
        _, k = self.tree.query(points)
        off = points - self.points[k]
        along = np.einsum("ij,ij->i", off, self.tangents[k])
        half = 0.5 * self.length_mm / (len(self.at) - 1)
        inner = np.clip(along, -half, half)
        along = np.where((k == 0) & (along < 0.0), along, inner)
        last = (k == len(self.at) - 1) & (np.einsum("ij,ij->i", off, self.tangents[k]) > 0.0)
        along = np.where(last, np.einsum("ij,ij->i", off, self.tangents[k]), along)
        return self.at[k] + along, np.einsum("ij,ij->i", off, self.sides[k])


class Stations(NamedTuple):
    """A mark across the way, at even places along it.

    Attributes
    ----------
    at : (S,) float64
        Middle of each, mm along the way.
    width : (S,) float64
        Covered area over the station's length, mm.
    middle : (S,) float64
        Middle between its two sides, mm to the left; nan where there is nothing, or where the way
        leads through the air. On a surface the sides are looked for along cuts across the way.
    ink : (S,) float64
        Ink over the station's length, coats x mm.
    """

    at: NDArray
    width: NDArray
    middle: NDArray
    ink: NDArray


def take_mark(surface: PaintedSurface, cuts: int = CUTS) -> Mark:
    """Collect what is on a surface now, in pieces of a quarter of its edges; all visible layers.

    Cover and ink are linear over each face, as colours are drawn.
    """
    vertices = np.asarray(surface.paint_mesh.vertices, float)
    cover = surface.painted_coverage().astype(float)
    lasting = np.array([p is not WATER for p in surface.pigments], float)
    ink = surface.amounts.astype(float) @ lasting
    dry = surface.dry_layers
    np.add.at(ink, dry.vertex_ids, dry.amounts.sum(axis=1, dtype=float))
    faces = surface.paint_mesh.leaf_faces()
    faces = faces[(cover[faces] > 0.0).any(axis=1)]
    return cut_faces(vertices, faces, cover, ink, cuts)


def cut_faces(vertices: NDArray, faces: NDArray, cover: NDArray, ink: NDArray, cuts: int) -> Mark:
    """Triangles in `cuts`^2 alike pieces each, with what lies on their middles."""
    thirds = []
    for i in range(cuts):
        for j in range(cuts - i):
            thirds.append(((i + 1 / 3) / cuts, (j + 1 / 3) / cuts))
            if j < cuts - i - 1:
                thirds.append(((i + 2 / 3) / cuts, (j + 2 / 3) / cuts))
    u, v = np.array(thirds).T
    weights = np.stack([1.0 - u - v, u, v], axis=1)
    corners = vertices[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(across, axis=1) / len(weights)
    points = np.einsum("pk,fkc->fpc", weights, corners).reshape(-1, 3)
    mark = Mark(
        points,
        np.repeat(areas, len(weights)),
        (cover[faces] @ weights.T).ravel(),
        (ink[faces] @ weights.T).ravel(),
    )
    return mark.where(mark.cover > 0.0)


def stations(mark: Mark, way: Way, step_mm: float = 1.0, reach_mm: float = np.inf) -> Stations:
    """Measure a mark across the way, every so often; what is farther off than `reach_mm` not."""
    n = max(1, round(way.length_mm / step_mm))
    edges = np.linspace(0.0, way.length_mm, n + 1)
    along, aside = way.place(mark.points)
    inside = (along >= 0.0) & (along <= way.length_mm) & (np.abs(aside) <= reach_mm)
    along, aside = along[inside], aside[inside]
    covered = (mark.areas * mark.cover)[inside]
    k = np.minimum(np.searchsorted(edges, along, side="right") - 1, n - 1)
    length = edges[1] - edges[0]
    ink = np.bincount(k, (mark.areas * mark.ink)[inside], n) / length
    of_step = np.minimum(np.searchsorted(edges, way.at, side="right") - 1, n - 1)
    if way.surface is None:
        dark = mark.cover[inside] > INKED
        middle = _middles(k[dark], aside[dark], n)
    else:
        cuts = inked_cuts(mark, way, min(reach_mm, LONGEST_CUT_MM))
        middle = _middles(of_step[cuts.step], cuts.aside, n)
    in_the_air = np.bincount(of_step, ~way.on_surface, n) > 0.5 * np.bincount(of_step, minlength=n)
    middle[in_the_air] = np.nan
    return Stations(
        0.5 * (edges[1:] + edges[:-1]), np.bincount(k, covered, n) / length, middle, ink
    )


def inked_cuts(mark: Mark, way: Way, reach_mm: float) -> Cuts:
    """The places on cuts across a way on a surface, to both sides, that are inked.

    A cut may lead to where the pen was at another time: what lies farther from its own step than
    a footprint reaches, but not from every other, was painted then.
    """
    ups = np.cross(way.tangents, way.sides)
    cuts = cut_across(way.surface, way.points, ups, way.on_surface, reach_mm)
    if not len(mark.points) or not len(cuts.step):
        return cuts.where(np.zeros(len(cuts.step), bool))
    apart = np.sqrt(2.0 * mark.areas)  # about as far are pieces from each other
    tree = cKDTree(mark.points, compact_nodes=False, balanced_tree=False)  # made in half the time
    away, piece = tree.query(cuts.points, distance_upper_bound=1.001 * float(apart.max()))
    piece = np.minimum(piece, len(apart) - 1)  # where none is so near, `away` is infinite
    cuts = cuts.where((away <= apart[piece]) & (mark.cover[piece] > INKED))
    own = np.abs(cuts.aside) <= REACH_MM
    return cuts.where(own | (way.tree.query(cuts.points)[0] > REACH_MM))


def _middles(station: NDArray, aside: NDArray, n: int) -> NDArray:
    """Middle between the sides of what is inked at each of n stations; nan for nothing."""
    left, right = np.full(n, -np.inf), np.full(n, np.inf)
    np.maximum.at(left, station, aside)
    np.minimum.at(right, station, aside)
    with np.errstate(invalid="ignore"):
        middle = 0.5 * (left + right)
    middle[~np.isfinite(left)] = np.nan
    return middle


def off_the_way(parts: Stations, percent: float = 100.0, ends_mm: float = 0.0) -> float:
    """Measure how far the middle of a mark lies from the path, mm: a percentile; inf if missing."""
    inner = (parts.at >= ends_mm) & (parts.at <= parts.at[-1] + parts.at[0] - ends_mm)
    middle = np.abs(parts.middle[inner])
    middle = middle[np.isfinite(middle)]
    return float(np.percentile(middle, percent)) if len(middle) else float("inf")


def largest_jump(parts: Stations) -> float:
    """The largest step aside of a mark's middle from one station to the next, mm."""
    middle = parts.middle[np.isfinite(parts.middle)]
    return float(np.abs(np.diff(middle)).max()) if len(middle) > 1 else 0.0


def ink_per_mm(mark: Mark, way: Way) -> float:
    """Ink over the way's length, coats x mm."""
    return float((mark.areas * mark.ink).sum()) / way.length_mm


def inked_share(mark: Mark, way: Way, half_footprint_mm: float) -> float:
    """Share of a pen's way beside which there is paint, no farther than half a footprint."""
    dark = mark.points[mark.cover > INKED]
    if not len(dark):
        return 0.0
    there = way.points[way.on_surface]
    return float((cKDTree(dark).query(there)[0] <= half_footprint_mm).mean())


def stray(mark: Mark, way: Way, half_footprint_mm: float) -> float:
    """Measure how far paint lies from the path, beyond half a footprint, mm; 0 for none."""
    dark = mark.points[mark.cover > INKED]
    if not len(dark):
        return 0.0
    return max(0.0, float(way.tree.query(dark)[0].max()) - half_footprint_mm)


def beyond(mark: Mark, way: Way) -> float:
    """How far paint reaches over the pen's last point, mm; 0 for not at all."""
    along, _ = way.place(mark.points[mark.cover > INKED])
    return max(0.0, float(along.max()) - way.length_mm) if len(along) else 0.0


def begins_and_goes_on(
    found: Stations, tuft_mm: float, first_mm: float = 5.0
) -> tuple[float, float]:
    """Mean width of a mark's first millimetres, and of as many a tuft's length further on."""
    late = (found.at >= tuft_mm) & (found.at < tuft_mm + first_mm)
    assert late.any(), "the stroke is shorter than a tuft"
    return float(found.width[found.at < first_mm].mean()), float(found.width[late].mean())


def largest_rise(values: NDArray) -> float:
    """Measure the largest rise of values that should fall, over the greatest one; 0 for none."""
    lowest = np.minimum.accumulate(values)
    return float((values - lowest).max() / values.max())


def strongest_spot(mark: Mark, way: Way, ends_mm: float) -> float:
    """The darkest place near a mark's ends, over the darkest one between them.

    99th percentiles of ink on the places that are wholly covered: a stroke is darker in its middle
    than at its sides all along.
    """
    along, _ = way.place(mark.points)
    full = mark.cover > 0.95
    inner = (along > ends_mm) & (along < way.length_mm - ends_mm)
    assert (full & inner).any(), "nothing is covered"
    ends = mark.ink[full & ~inner]
    between = np.percentile(mark.ink[full & inner], 99.0)
    return float(np.percentile(ends, 99.0) / between) if len(ends) else 0.0


def _unit(vectors: NDArray) -> NDArray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


# -- cuts across a way along the surface ----------------------------------------------------------
# What lies beside a way over an edge may be nearest in space to quite another step of it: before a
# fold of a right angle that is crossed aslant, to steps behind it; where a way comes back beside
# itself, half of the mark to each. A cut leaves a step at right angles and goes straight on, over
# edges as if the faces were unfolded there.

SAMPLE_MM = 0.125
CRACK_MM = 0.1  # an open edge so near to another face is none
MOST_FACES = 4000  # that one cut goes over


class Cuts(NamedTuple):
    """N places on the surface, along cuts.

    Attributes
    ----------
    points : (N, 3) float64
        mm.
    step : (N,) int64
        The step of the way that the cut begins at.
    aside : (N,) float64
        How far from the step, mm, as the crow flies: a brush bridges grooves. Cuts to the left of
        the way count up, to the right down.
    """

    points: NDArray
    step: NDArray
    aside: NDArray

    def where(self, chosen: NDArray[np.bool_]) -> Cuts:
        """Only some of them."""
        return Cuts(*(part[chosen] for part in self))


class _Faces:
    """The faces of a mesh, and what joins them."""

    def __init__(self, surface: ClosestPoints) -> None:
        base = make_base_surface(surface.mesh)
        corners = base.points.astype(np.float64)[base.faces]  # (F, 3, 3)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.corners = corners
        self.normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        edges = np.roll(corners, -1, axis=1) - corners
        self.along = edges / np.linalg.norm(edges, axis=2, keepdims=True)
        self.outward = np.cross(self.along, self.normals[:, None])
        self.low, self.high = corners.min(axis=1), corners.max(axis=1)
        self.radial = base.radial
        self.number = np.full(len(surface.mesh.faces), -1, np.int64)
        self.number[base.source_faces] = np.arange(len(base.faces))

    def beyond(self, face: NDArray, edge: NDArray) -> tuple[NDArray, NDArray]:
        """The faces and their edges on the other side of edges; of several that which goes on
        straightest; -1 at the end of the surface.
        """
        own = 3 * face + edge
        found, flattest = np.full(len(own), -1), np.full(len(own), -2.0)
        outward = self.outward.reshape(-1, 3)
        ring = self.radial[own].astype(np.int64)
        while (ring != own).any():
            straight = -np.einsum("ij,ij->i", outward[own], outward[ring])
            better = (ring != own) & (straight > flattest)
            found[better], flattest[better] = ring[better], straight[better]
            ring = np.where(ring != own, self.radial[ring], own)
        return np.where(found < 0, -1, found // 3), found % 3

    def over_crack(
        self, face: int, edge: int, place: NDArray, direction: NDArray
    ) -> tuple[int, NDArray]:
        """The face that an open edge lies on, and whither straight on leads there; -1 for none."""
        line, outward = self.along[face, edge], self.outward[face, edge]
        sideways = float(direction @ line)
        onward = math.sqrt(max(0.0, 1.0 - sideways**2))
        near = (self.low <= place + CRACK_MM).all(axis=1) & (self.high >= place - CRACK_MM).all(
            axis=1
        )
        best, found = -2.0, (-1, direction)
        for other in np.flatnonzero(near):
            normal = self.normals[other]
            if other == face or abs(float((place - self.corners[other, 0]) @ normal)) > CRACK_MM:
                continue
            across = np.cross(normal, line)
            length = float(np.linalg.norm(across))
            if length < 0.1:
                continue
            for inward in (across / length, -across / length):
                ahead = place + 2.0 * CRACK_MM * inward - self.corners[other]
                if (np.einsum("ij,ij->i", ahead, self.outward[other]) > CRACK_MM).any():
                    continue
                if float(inward @ outward) > best:
                    best = float(inward @ outward)
                    way = sideways * (line - (line @ normal) * normal) + onward * inward
                    found = int(other), way / np.linalg.norm(way)
        return found

    def walk(
        self, face: NDArray, start: NDArray, direction: NDArray, length_mm: float
    ) -> list[tuple[NDArray, NDArray]]:
        """Straight on over faces, all walks (W,) at a time: of each the places where it comes to
        edges (N, 3), and how far these are (N,).
        """
        walk, place, far = np.arange(len(face)), start.copy(), np.zeros(len(face))
        edge, row = np.full(len(face), -1), np.arange(len(face))
        passed = [(walk, place, far)]
        while len(walk) and len(passed) < MOST_FACES:
            outward, row = self.outward[face], row[: len(walk)]
            ahead = np.einsum("wkj,wj->wk", outward, direction)
            away = np.einsum("wkj,wkj->wk", self.corners[face] - place[:, None], outward)
            leads_out = (ahead > 1e-12) & (np.arange(3) != edge[:, None])
            steps = np.full(ahead.shape, math.inf)
            steps[leads_out] = np.maximum(away[leads_out], 0.0) / ahead[leads_out]
            out = steps.argmin(axis=1)
            to_edge = steps[row, out]
            step = np.minimum(to_edge, length_mm - far)
            place, far = place + step[:, None] * direction, far + step
            passed.append((walk, place, far))
            on = np.isfinite(to_edge) & (far < length_mm)
            walk, place, far, face, out = walk[on], place[on], far[on], face[on], out[on]
            face, edge, direction = self._onward(face, out, place, direction[on])
            on = face >= 0
            walk, place, far = walk[on], place[on], far[on]
            face, edge, direction = face[on], edge[on], direction[on]
        walks, places, fars = (np.concatenate(part) for part in zip(*passed, strict=True))
        order = np.argsort(walks, kind="stable")
        ends = np.cumsum(np.bincount(walks, minlength=len(start)))[:-1]
        return [*zip(np.split(places[order], ends), np.split(fars[order], ends), strict=True)]

    def _onward(
        self, face: NDArray, out: NDArray, place: NDArray, direction: NDArray
    ) -> tuple[NDArray, NDArray, NDArray]:
        """Faces behind edges, by which of their edges they are entered, and whither; or -1."""
        other, edge = self.beyond(face, out)
        line = self.along[face, out]
        sideways = np.einsum("wj,wj->w", direction, line)
        onward = np.sqrt(np.maximum(0.0, 1.0 - sideways**2))
        whither = sideways[:, None] * line - onward[:, None] * self.outward[other, edge]
        for k in np.flatnonzero(other < 0):
            other[k], whither[k] = self.over_crack(face[k], out[k], place[k], direction[k])
            edge[k] = -1
        return other, edge, whither


def cut_across(
    surface: ClosestPoints,
    points: NDArray,
    ups: NDArray,
    chosen: NDArray[np.bool_],
    reach_mm: float,
) -> Cuts:
    """Cut across a way at its steps.

    Parameters
    ----------
    surface : ClosestPoints
    points, ups : (K, 3)
        The steps of the way, and the side of the surface that is looked at.
    chosen : (K,) bool
        The steps that are cut at.
    reach_mm : float
        To each side.

    Returns
    -------
    Cuts
        Places every eighth of a millimetre.
    """
    faces = _faces_of(surface)
    on = surface.find(points)
    there = faces.number[on.faces]
    begun: list[tuple[int, float, NDArray]] = []
    for k in np.flatnonzero(chosen):
        normal = faces.normals[there[k]]
        ahead = _ahead(points, k, normal)
        if ahead is not None:
            left = cross(normal if normal @ ups[k] >= 0.0 else -normal, ahead)
            begun += [(k, 1.0, left), (k, -1.0, -left)]
    if not begun:
        return Cuts(np.empty((0, 3)), np.empty(0, np.int64), np.empty(0))
    step = np.array([k for k, _, _ in begun])
    walks = faces.walk(there[step], on.points[step], np.array([d for *_, d in begun]), reach_mm)
    found, steps, sides = [], [], []
    for (k, side, _), (places, far) in zip(begun, walks, strict=True):
        at = np.arange(0.0 if side > 0.0 else SAMPLE_MM, far[-1] + 1e-9, SAMPLE_MM)
        found.append(np.stack([np.interp(at, far, column) for column in places.T], axis=1))
        steps.append(np.full(len(at), k))
        sides.append(np.full(len(at), side))
    points, step = np.concatenate(found), np.concatenate(steps)
    away = np.linalg.norm(points - on.points[step], axis=1)
    return Cuts(points, step, np.concatenate(sides) * away)


def _ahead(points: NDArray, k: int, normal: NDArray) -> NDArray | None:
    """Whither the way leads on the face at a step: of the steps before and behind that which lies
    in the face, since the other may lead over an edge.
    """
    best, least = None, math.inf
    for a, b in ((k - 1, k), (k, k + 1)):
        if a < 0 or b >= len(points):
            continue
        way = points[b] - points[a]
        length = float(np.linalg.norm(way))
        if length == 0.0:
            continue
        off = abs(float(way @ normal)) / length
        across = way - (way @ normal) * normal
        if off < least and np.linalg.norm(across) > 1e-6 * length:
            best, least = across / np.linalg.norm(across), off
    return best


_known: list[tuple[ClosestPoints, _Faces]] = []


def _faces_of(surface: ClosestPoints) -> _Faces:
    """The faces of a surface; those of the last are kept."""
    if not _known or _known[0][0] is not surface:
        _known[:] = [(surface, _Faces(surface))]
    return _known[0][1]
