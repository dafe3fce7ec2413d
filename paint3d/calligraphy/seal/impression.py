"""Print of a seal on a surface: paste where the stone met it, firmer here than there.

A pad below (or behind) the stone gives way, so that it lies on the surface as a sheet does and
presses less where that falls away from it. Paste is uneven: thicker along the edges of what is cut,
patchy within, worn off where the stone's rim has been knocked. All of it follows from the position
on the stone and a number, so the same seal is the same everywhere and at every resolution; and all
of it is made of sums, products and roots, so it is to the bit what `web/src/seal/print.ts` leaves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, dots_of, lengths_of
from paint3d.errors import InputError, MeshError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SurfaceChart, SurfaceFrame, lattice, make_chart, unroll
from paint3d.surface.kernels.diffusion import activate_cells
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.pores import even_exp

if TYPE_CHECKING:
    from shapely import Geometry

__all__ = ["Impression", "Pressing", "find_impression", "lay_paste"]

_NODES = 32.0  # of the chart along the longer side
_MARGIN_MM = 0.3  # around the stone
_SAME_SIDE = 0.3  # cosine between a vertex's normal and the chart's: less is another sheet
_OFF_MM = 0.6  # that a vertex may lie off the chart
_SOFT_MM = 0.035  # half the width of an edge of paste, however fine the surface
_RIDGE_MM, _RIDGE = 0.16, 0.3  # paste is pushed to the edge of what is cut: how far, how much more
_PATCHY, _CELL_MM = 0.22, 1.3  # how much thickness varies, and over what
_GRAINY, _GRAIN_MM = 0.16, 0.22
_BARE = 1.35  # deviations of both together above which the ground shows through
_ROUGH_MM, _RAGGED_MM = 0.7, 0.035  # the worn edge: over what, by how much
_CHIP_MM, _CHIP_FROM = 2.6, 0.45  # where the rim is knocked off: over what, from which noise on
_FIRM = 0.35  # of the full press: from there on all of it touches
_EDGE = 0.5  # of a vertex's spacing: half the width of an edge
_LEAST_TOUCHED = 0.02  # of the stone
_ACROSS = 80.0  # vertices along the longer side, at least
_FINEST_MM = 0.05  # however small the stone


@dataclass(frozen=True)
class Pressing:
    """Options of pressing a seal.

    Attributes
    ----------
    coats : float
        Thickness of the paste where it is even.
    pad_mm : float
        How far the pad gives way: what falls farther away from the stone is not touched.
    wear : float
        How worn the stone is: 0 as it was cut, 1 as most are.
    seed : int
        Which of many impressions: another has other bare spots and other chips.
    """

    coats: float = 1.3
    pad_mm: float = 3.0
    wear: float = 1.0
    seed: int = 1


@dataclass(frozen=True, eq=False)
class Impression:
    """Paste on vertices.

    Attributes
    ----------
    vertex_ids : (N,) int32
    coats : (N,) float32
        Thickness times `coverage`.
    coverage : (N,) float32
        Fraction of each vertex's area that is covered.
    touched : float
        Fraction of the stone's ink that met the surface, 0 to 1.
    """

    vertex_ids: NDArray[np.int32]
    coats: NDArray[np.float32]
    coverage: NDArray[np.float32]
    touched: float


def find_impression(
    surface: PaintedSurface,
    closest: ClosestPoints,
    frame: SurfaceFrame,
    rings: Sequence[AnyArray],
    pressing: Pressing,
) -> Impression:
    """Amounts of paste that a seal leaves; the surface is refined there, nothing is painted.

    Parameters
    ----------
    surface : PaintedSurface
    closest : ClosestPoints
        Of its source.
    frame : SurfaceFrame
        Where the middle of the stone goes, and what is up on it.
    rings : sequence of (N, 2)
        What of the stone takes paste, by the even-odd rule; mm from its middle.
    pressing : Pressing

    Raises
    ------
    MeshError
        If the surface ends within the stone.
    InputError
        If hardly anything of the stone meets the surface, or nothing is cut into it.
    """
    half = np.max([np.abs(ring).max(axis=0) for ring in rings], axis=0) + _MARGIN_MM
    try:
        chart = make_chart(closest, frame, half[0], half[1], 2.0 * half.max() / _NODES)
    except MeshError as cause:
        raise MeshError(
            "a seal of {first:.0f} x {second:.0f} mm has no room there ({cause}); expected a "
            "smaller seal or another place",
            first=2.0 * half[0],
            second=2.0 * half[1],
            cause=cause,
        ) from None
    stone = _Stone(rings)
    would_touch = _measure_touched(chart, stone, pressing)
    if would_touch < _LEAST_TOUCHED:
        raise InputError(
            "the seal would touch {percent:.0f} % of what it is to print: the surface falls away "
            "from it; expected a smaller seal, a softer pad or a flatter place",
            percent=100.0 * would_touch,
        )
    _refine(surface, chart, max(_FINEST_MM, 2.0 * float(half.max()) / _ACROSS))
    ids, xy = _vertices_under(surface, chart)
    if not len(ids):
        raise InputError("the seal meets no vertex of the surface; expected another place")
    inside = stone.signed_distance(xy)
    wide = np.sqrt(surface.vertex_areas[ids])
    inside = inside - pressing.wear * _wear_at(xy, half, pressing.seed)
    soft = np.maximum(_EDGE * wide, _SOFT_MM)
    coverage = np.clip(0.5 + 0.5 * inside / soft, 0.0, 1.0)
    wanted = coverage.sum()
    firm = _firmness(chart, xy, pressing.pad_mm)
    bare = _patches(xy, pressing.seed)
    thick = 1.0 + _RIDGE * _decay(np.maximum(inside, 0.0) / _RIDGE_MM) + bare[0]
    coverage *= np.clip(firm / _FIRM, 0.0, 1.0) * np.clip(1.0 - pressing.wear * bare[1], 0.0, 1.0)
    thick *= 0.55 + 0.45 * firm
    touched = float(coverage.sum() / max(wanted, 1e-9))
    inked = coverage > 1e-3
    covered = coverage[inked]
    coats = pressing.coats * np.maximum(thick[inked], 0.1) * covered
    return Impression(ids[inked], coats.astype(np.float32), covered.astype(np.float32), touched)


def lay_paste(surface: PaintedSurface, impression: Impression, parts: AnyArray) -> float:
    """Lay what a seal leaves on the layer that is painted on.

    What is wet below it dries first; the paste lies on it and does not run.

    Parameters
    ----------
    surface : PaintedSurface
    impression : Impression
    parts : (P,) array
        Fractions of the surface's pigments in the paste, of sum 1.

    Returns
    -------
    float
        Ink that came onto the surface, coats x mm2.
    """
    before = surface.wet_ink() + surface.dry_ink()
    surface.settle(impression.vertex_ids)
    surface.ink.amounts[impression.vertex_ids] = impression.coats[:, None] * parts
    surface.ink.coverage[impression.vertex_ids] = impression.coverage
    surface.settle(impression.vertex_ids)
    return surface.wet_ink() + surface.dry_ink() - before


def _measure_touched(chart: SurfaceChart, stone: _Stone, pressing: Pressing) -> float:
    """The fraction of the stone's ink that would meet the surface, before that is refined."""
    reach = chart.reach
    points = lattice(*(np.linspace(-r, r, int(_ACROSS) + 1) for r in reach))
    soft = max(_EDGE * (2.0 * reach.max() / _ACROSS), _SOFT_MM)
    coverage = np.clip(0.5 + 0.5 * stone.signed_distance(points) / soft, 0.0, 1.0)
    firm = np.clip(_firmness(chart, points, pressing.pad_mm) / _FIRM, 0.0, 1.0)
    return float((coverage * firm).sum() / max(coverage.sum(), 1e-9))


# -- on the surface -----------------------------------------------------------------------------


def _refine(surface: PaintedSurface, chart: SurfaceChart, spacing: float) -> None:
    """Refine the surface wherever the chart goes, finer than elsewhere for a small seal.

    Edges become no longer than `spacing`, mm, or the surface's resolution where that is finer.
    Paint keeps its vertices, and so do the cells around it: between them new ones would be bare.
    """
    from scipy.spatial import cKDTree

    mesh = surface.paint_mesh
    fields = mesh.arrays
    size = fields.cell_size
    reach = chart.reach
    counts = np.ceil(2.0 * reach / (0.5 * size)).astype(int) + 2
    grid = lattice(*(np.linspace(-r, r, n) for r, n in zip(reach, counts, strict=True)))
    middles = fields.origin + (fields.cell_place + 0.5) * size
    near = cKDTree(chart.points(grid)).query(middles, distance_upper_bound=1.2 * size)[0]
    cells = np.flatnonzero(np.isfinite(near)).astype(np.int64)
    wanted = min(spacing, fields.resolution) if mesh.refines else fields.resolution
    cells_at = fields.cell_place.astype(np.float64)
    inked = np.unique(fields.sheet_cell[fields.vertex_sheet[np.flatnonzero(surface.painted)]])
    apart = cKDTree(cells_at[inked]).query(cells_at[cells], p=np.inf, distance_upper_bound=1.5)[0]
    bare = cells[np.isinf(apart)]
    if wanted < fields.resolution:
        fields.done[bare] = 0
    for those, edge in ((cells[np.isfinite(apart)], fields.resolution), (bare, wanted)):
        done = 0
        while done < len(those):
            done = activate_cells(mesh.arrays._replace(resolution=edge), those, done)
            if done < len(those):
                surface.make_room()
    surface.know_vertices()


def _vertices_under(surface: PaintedSurface, chart: SurfaceChart) -> tuple[AnyArray, AnyArray]:
    """Vertices (N,) on the chart's own sheet of surface, and where on it they are (N, 2)."""
    vertices = surface.paint_mesh.vertices.astype(np.float64)
    radius = math.hypot(*chart.reach) + 1.0
    ids = np.flatnonzero(lengths_of(vertices - chart.frame.origin) <= radius)
    xy = unroll(chart, vertices[ids])
    known = np.isfinite(xy).all(axis=1)
    ids, xy = ids[known], xy[known]
    if not len(ids):
        return ids.astype(np.int32), xy
    normals = surface.paint_mesh.normals[ids].astype(np.float64)
    alike = dots_of(normals, chart.normals(xy)) > _SAME_SIDE
    near = lengths_of(vertices[ids] - chart.points(xy)) < _OFF_MM
    under = alike & near
    return ids[under].astype(np.int32), xy[under]


def _firmness(chart: SurfaceChart, xy: AnyArray, pad_mm: float) -> AnyArray:
    """Pressure of the stone, 0 to 1: less where the surface falls away from its plane."""
    frame = chart.frame
    fallen = np.abs(dots_of(chart.points(xy) - frame.origin, frame.normal))
    result: AnyArray = np.clip(1.0 - fallen / pad_mm, 0.0, 1.0)
    return result


# -- on the stone -------------------------------------------------------------------------------


class _Stone:
    """The part of a stone that takes paste.

    Parameters
    ----------
    rings : sequence of (N, 2)
        By the even-odd rule.

    Raises
    ------
    InputError
        If they go around no area.
    """

    def __init__(self, rings: Sequence[AnyArray]) -> None:
        import shapely

        shape: Geometry = shapely.Polygon()
        for ring in rings:
            shape = shape.symmetric_difference(shapely.Polygon(ring).buffer(0.0))
        if shape.is_empty:
            raise InputError("the seal prints nothing: its rings go around no area")
        shapely.prepare(shape)
        self._shape = shape
        lines = [shapely.get_coordinates(line) for line in shapely.get_parts(shape.boundary)]
        edges = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
        (ax, ay), (bx, by) = edges.transpose(1, 2, 0)
        later = (ax > bx) | ((ax == bx) & (ay > by))  # the lesser end first, whatever the way
        edges[later] = edges[later, ::-1]
        self._edges = edges
        self._tree = shapely.STRtree(shapely.linestrings(edges))

    def signed_distance(self, xy: AnyArray) -> AnyArray:
        """Signed distance of points (N, 2) to the edge, mm; negative outside."""
        import shapely

        points = shapely.points(xy)
        edges = self._edges[self._tree.nearest(points)]
        edge, off = edges[:, 1] - edges[:, 0], xy - edges[:, 0]
        along = np.clip(dots_of(off, edge) / dots_of(edge, edge), 0.0, 1.0)
        away = lengths_of(off - along[:, None] * edge)
        result: AnyArray = np.where(shapely.contains(self._shape, points), away, -away)
        return result


def _decay(x: AnyArray) -> AnyArray:
    """e to the power of -x."""
    return even_exp(-np.minimum(x, 700.0))


def _wear_at(xy: AnyArray, half: AnyArray, seed: int) -> AnyArray:
    """Wear (mm) of what was cut: little everywhere, more along the rim."""
    ragged = _RAGGED_MM * (_noise(xy, _ROUGH_MM, seed) + 0.7 * _noise(xy, 0.3, seed + 1))
    from_rim = (half - _MARGIN_MM - np.abs(xy)).min(axis=1)
    knocked = np.maximum(_noise(xy, _CHIP_MM, seed + 2) - _CHIP_FROM, 0.0)
    corner = _decay(np.abs(half - _MARGIN_MM - np.abs(xy)).max(axis=1) / 1.2)
    depth = knocked * 1.6 * _decay(np.maximum(from_rim, 0.0) / 0.5)
    result: AnyArray = ragged + depth + 0.18 * corner * (1.0 + _noise(xy, _ROUGH_MM, seed + 3))
    return result


def _patches(xy: AnyArray, seed: int) -> tuple[AnyArray, AnyArray]:
    """Variation of thickness (N,), and bareness (N,), 0 to 1 and more."""
    slow, quick = _noise(xy, _CELL_MM, seed + 4), _noise(xy, _GRAIN_MM, seed + 5)
    bare = np.maximum(0.9 * slow + 1.1 * quick - _BARE * 0.62, 0.0) * 2.4
    return _PATCHY * slow + _GRAINY * quick, bare


def _noise(xy: AnyArray, cell_mm: float, seed: int) -> AnyArray:
    """Smooth noise (N,) from -1 to 1: values on a lattice, between them cubics without slope."""
    at = xy / cell_mm
    corner = np.floor(at)
    fraction = at - corner
    fraction = fraction * fraction * (3.0 - 2.0 * fraction)
    cell = corner.astype(np.int64)
    values = [_hash_lattice(cell[:, 0] + i, cell[:, 1] + j, seed) for i in (0, 1) for j in (0, 1)]
    low = values[0] + fraction[:, 1] * (values[1] - values[0])
    high = values[2] + fraction[:, 1] * (values[3] - values[2])
    result: AnyArray = low + fraction[:, 0] * (high - low)
    return result


def _hash_lattice(i: AnyArray, j: AnyArray, seed: int) -> AnyArray:
    """A number from -1 to 1 for each point of a lattice (splitmix64's finaliser)."""
    x = (i.astype(np.uint64) << np.uint64(32)) ^ (j.astype(np.uint64) & np.uint64(0xFFFFFFFF))
    x += np.uint64((0x9E3779B97F4A7C15 * (seed + 1)) % 2**64)
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        x = (x ^ (x >> np.uint64(shift))) * np.uint64(factor)
    x ^= x >> np.uint64(31)
    result: AnyArray = (x >> np.uint64(11)).astype(np.float64) * 2.0**-52 - 1.0
    return result
