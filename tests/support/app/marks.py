"""What a mark on the surface is like, measured against the way of the pen that made it.

A `Mark` is a cloud of small pieces of the surface with what lies on them; a `Way` is the line on
the surface that the pen went, cut into even steps. Along it a mark has stations: pieces belong to
that step of the way which is nearest. All lengths are mm, ink is in full coats x mm2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from paint3d.colour.pigments import WATER
from paint3d.mesh.bvh import ClosestPoints
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.cuts import Cuts, cut_across

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
        """What lies so near to a way."""
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
        """Of all of it."""
        return float(self.at[-1])

    @property
    def in_the_air_mm(self) -> float:
        """Of what leads through the air."""
        return float((~self.on_surface).mean()) * self.length_mm

    def place(self, points: NDArray) -> tuple[NDArray, NDArray]:
        """How far along the way (below 0 and above its length: beyond), and aside to its left."""
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
    """What is on a surface now, in pieces of a quarter of its edges; all layers but rested ones.

    Cover and ink are linear over each face, as colours are drawn.
    """
    vertices = np.asarray(surface.paint_mesh.vertices, float)
    cover = surface.share_painted().astype(float)
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


def off_the_way(found: Stations, percent: float = 100.0, ends_mm: float = 0.0) -> float:
    """How far the middle of a mark lies from the way, mm: a percentile; inf where it is nowhere."""
    inner = (found.at >= ends_mm) & (found.at <= found.at[-1] + found.at[0] - ends_mm)
    middle = np.abs(found.middle[inner])
    middle = middle[np.isfinite(middle)]
    return float(np.percentile(middle, percent)) if len(middle) else float("inf")


def largest_jump(found: Stations) -> float:
    """The largest step aside of a mark's middle from one station to the next, mm."""
    middle = found.middle[np.isfinite(found.middle)]
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
    """How far paint lies from the way, beyond half a footprint, mm; 0 for none."""
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
    """By how much values rise that should fall: over the largest of them; 0 for never."""
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
