"""The line and the region of each stroke, from the branches that it is made of."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.centre_line import smooth_along
from paint3d.calligraphy.glyphs import GlyphStroke
from paint3d.calligraphy.page.page import polygons_of
from paint3d.calligraphy.shapes.continuation import Chain
from paint3d.calligraphy.shapes.skeleton import Junction, Skeleton
from paint3d.calligraphy.shapes.triangles import Triangles
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import arc_lengths, interpolate, line_length, resample

if TYPE_CHECKING:
    from shapely import LineString, Polygon

__all__ = [
    "Ink",
    "InkStroke",
    "complete_regions",
    "has_length",
    "line_of",
    "pieces_of",
    "with_stubs",
]

# radii of a junction, and fraction of a branch, that a line goes straight over
_LEFT_OUT, _LEFT_OUT_FRACTION = 0.9, 0.35
_CALM = 0.35  # half widths that lines are smoothed over
_STEP = 0.25  # half widths between the points of a line
_LEAST_CALM = 0.02
_SWELL = 1.03  # how much wider than the line's half width a junction is swept
_OVERLAP = 0.06  # half widths that regions reach beyond their triangles
_NONE = 1e-9  # of the ink: areas that are not there
_NO_WAY = 0.25  # half widths: shorter lines lead nowhere


@dataclass(frozen=True, eq=False)
class Ink:
    """A connected shape with its triangles and its skeleton."""

    triangles: Triangles
    skeleton: Skeleton

    @property
    def shape(self) -> Polygon:
        """The polygon."""
        return self.triangles.shape

    def half_widths(self, points: AnyArray) -> NDArray[np.float64]:
        """Distances of points (N, 2) to the edge."""
        return self.triangles.to_edge(points)


@dataclass(frozen=True, eq=False)
class InkStroke:
    """A stroke: its line (N, 2) and its region."""

    line: NDArray[np.float64]
    region: Polygon


def line_of(chain: Chain, ink: Ink) -> NDArray[np.float64]:
    """The line of a stroke; through junctions it goes straight."""
    parts, n = [], len(chain.links)
    for k, (index, forward) in enumerate(chain.links):
        branch = ink.skeleton.branches[index]
        line = branch.away_from(0 if forward else 1)
        ends = branch.ends if forward else branch.ends[::-1]
        radii = [ink.skeleton.junctions[number].radius for number in ends]
        most = _LEFT_OUT_FRACTION * branch.length
        cut = [min(_LEFT_OUT * radius, most) for radius in radii]
        along = arc_lengths(line)
        low = cut[0] if k > 0 or (chain.closed and n > 1) else 0.0
        high = along[-1] - (cut[1] if k + 1 < n or (chain.closed and n > 1) else 0.0)
        inner = line[(along > low) & (along < high)]
        first, last = interpolate((low, high), along, line)
        parts.append(np.concatenate([[first], inner, [last]]))
    joined = np.concatenate(parts)
    return np.concatenate([joined, joined[:1]]) if chain.closed and n > 1 else joined


def has_length(chain: Chain, ink: Ink) -> bool:
    """Return whether a stroke has a length: junctions that fall together leave some without."""
    line = line_of(chain, ink)
    return bool(line_length(line) > _NO_WAY * ink.half_widths(line).max())


def pieces_of(chains: Iterable[Chain], ink: Ink) -> list[InkStroke]:
    """The strokes of an ink: their smoothed lines, and what is their own."""
    degrees = ink.skeleton.degrees()
    return [_piece_of(chain, ink, degrees) for chain in chains]


def _piece_of(chain: Chain, ink: Ink, degrees: Counter[int]) -> InkStroke:
    """A stroke, whose own are the triangles along it and at junctions."""
    import shapely

    line = line_of(chain, ink)
    half = max(
        float(np.median(ink.half_widths(resample(line, 0.02 * line_length(line) + 1e-12, 8)))),
        1e-9,
    )
    cells: list[int] = []
    sweeps = []
    for index, _ in chain.links:
        branch = ink.skeleton.branches[index]
        cells += branch.cells
        for side, number in enumerate(branch.ends):
            junction = ink.skeleton.junctions[number]
            if not ink.skeleton.is_shared(number, degrees):
                cells += junction.cells
            else:
                sweeps.append(_swept_area(branch.away_from(side), junction, line, ink))
    region = ink.triangles.region(sorted(set(cells))) if cells else shapely.Polygon()
    grown = region.buffer(_OVERLAP * half, join_style="mitre")
    region = shapely.union_all([grown, *sweeps]).intersection(ink.shape)
    return InkStroke(_smooth_in_region(line, half, region), region)


def _swept_area(branch: AnyArray, junction: Junction, line: AnyArray, ink: Ink) -> Polygon:
    """Area that a stroke of the branch's width sweeps along its line near a junction."""
    import shapely

    along = arc_lengths(branch)
    clear = min(1.2 * junction.radius, 0.5 * along[-1])
    outside = interpolate([clear], along, branch)
    half = float(min(ink.half_widths(outside)[0], junction.radius))
    near = shapely.union_all([shapely.Point(p).buffer(1.2 * r) for p, r in junction.members])
    path = shapely.LineString(line).intersection(near)
    return path.buffer(max(_SWELL * half, 1e-12))


def _smooth_in_region(line: AnyArray, half: float, region: Polygon) -> NDArray[np.float64]:
    """Smooth a line as far as it stays in its region."""
    import shapely

    step = min(_STEP * half, line_length(line) / 8.0)
    even = resample(line, max(step, 1e-12), 4)
    shapely.prepare(region)
    calm = _CALM
    while calm > _LEAST_CALM:
        points = smooth_along(even, calm * half / step)
        if region.covers(shapely.LineString(points)):
            return points
        calm *= 0.5
    return even if region.covers(shapely.LineString(even)) else line


def complete_regions(pieces: Sequence[InkStroke], ink: Ink) -> list[InkStroke]:
    """Make every region one polygon, and what no stroke has to the one it touches most."""
    import shapely

    regions = [_polygon_along(piece.region, piece.line) for piece in pieces]
    tiny = _NONE * ink.shape.area
    for _ in range(3):
        rest = ink.shape.difference(shapely.union_all(regions))
        lost = [part for part in shapely.get_parts(rest) if part.area > tiny]
        if not lost:
            break
        for part in lost:
            reach = 1e-3 * float(np.sqrt(part.area)) + 1e-9 * ink.shape.length
            rim = part.buffer(reach, join_style="mitre")
            touch = [float(rim.intersection(region).area) for region in regions]
            k = int(np.argmax(touch))
            joined = shapely.union_all([regions[k], rim.intersection(ink.shape)])
            regions[k] = _polygon_along(joined, pieces[k].line)
    return [
        InkStroke(_longest_within(piece.line, region), region)
        for piece, region in zip(pieces, regions, strict=True)
    ]


def _polygon_along(region: Polygon, line: AnyArray) -> Polygon:
    """The polygon of a region that has most of a line in it."""
    import shapely

    parts = [part for part in shapely.get_parts(region) if part.geom_type == "Polygon"]
    path = shapely.LineString(line)
    inside = [(float(part.intersection(path).length), float(part.area)) for part in parts]
    return parts[inside.index(max(inside))]


def _longest_within(line: AnyArray, region: Polygon) -> NDArray[np.float64]:
    """The longest piece of a line that lies in a region."""
    import shapely

    path = shapely.LineString(line)
    if region.covers(path):
        return line
    inside = shapely.line_merge(region.intersection(path))
    parts = [part for part in shapely.get_parts(inside) if part.geom_type == "LineString"]
    longest = max(parts, key=lambda part: part.length, default=path)
    longest_line = np.array(longest.coords)
    along = (longest_line[-1] - longest_line[0]) @ (line[-1] - line[0])
    return longest_line if along >= 0.0 else longest_line[::-1]


# ---- Bare ends -----------------------------------------------------------------------------------
# Stubs of a bold stroke's region that its line does not reach: short strokes of their own.
#
# What sticks out of a junction by less than its radius is taken for a corner, and belongs to the
# stroke that goes by: the left arm of an f's bar, the head of an n's stem. In thin script that is
# right; in bold script it is as wide as a stroke, and nothing that follows the line can fill it.


_STATIONS = 48  # along a line, where the widest disc is asked for
_LEAST_RADIUS = 0.42  # of the half width there: a smaller rest is a corner (a square's: .17)
_LEAST_AREA = 0.25  # of the square of the width there
_STUB_OVERLAP = 0.8  # half widths that a stub reaches back into its stroke
_FROM_EDGE = 0.5  # half widths: a stub's line from the ends of its region
_TOLERANCE = 0.02
_INSET, _SHORTEST = 0.05, 0.3  # half widths: a line from its region's edge, and its length


def with_stubs(strokes: Sequence[GlyphStroke], bold: float) -> list[GlyphStroke]:
    """Strokes, each that is bold followed by what of its region its line does not reach.

    Parameters
    ----------
    strokes : sequence of GlyphStroke
    bold : float
        Width from which on a stroke is, in the strokes' unit.
    """
    with_stubs_added: list[GlyphStroke] = []
    for stroke in strokes:
        with_stubs_added.append(stroke)
        with_stubs_added.extend(_find_stubs(stroke, bold))
    return with_stubs_added


def _find_stubs(stroke: GlyphStroke, bold: float) -> list[GlyphStroke]:
    """Short strokes outwards from a line that would leave parts of its region bare."""
    import shapely

    line = shapely.LineString(stroke.median)
    region = shapely.Polygon(stroke.outline, stroke.holes)
    if line.length == 0.0 or not region.is_valid:
        return []
    stations = [line.interpolate(t, normalized=True) for t in np.linspace(0.0, 1.0, _STATIONS)]
    radii = shapely.distance(region.boundary, stations)
    half = float(np.median(radii))
    if 2.0 * half < bold:
        return []
    discs = shapely.buffer(stations, radii + _TOLERANCE * half)
    swept = shapely.union_all([shapely.union(a, b).convex_hull for a, b in pairwise(discs)])
    stubs = []
    for part in polygons_of(region.difference(swept)):
        near = line.project(part.centroid, normalized=True) * (_STATIONS - 1)
        there = max(half, float(radii[round(near)]))
        radius = float(shapely.length(shapely.maximum_inscribed_circle(part)))
        if radius > _LEAST_RADIUS * there and part.area > _LEAST_AREA * (2.0 * there) ** 2:
            stubs.append(_make_stub(part, region, line, half))
    return [stub for stub in stubs if stub is not None]


def _make_stub(part: Polygon, region: Polygon, line: LineString, half: float) -> GlyphStroke | None:
    """A stroke from the far end of a bare part into the stroke that it sticks out of."""
    import shapely

    middle = np.array(part.centroid.coords[0])
    root = np.array(line.interpolate(line.project(part.centroid)).coords[0])
    length = float(np.hypot(*(root - middle)))
    direction = (root - middle) / length if length > 0.0 else np.array([1.0, 0.0])
    own = part.buffer(_STUB_OVERLAP * half).intersection(region)
    own = max(polygons_of(own), key=lambda one: one.area)
    along = (np.asarray(own.exterior.coords) - middle) @ direction
    start, end = along.min() + _FROM_EDGE * half, along.max() - _FROM_EDGE * half
    straight = shapely.LineString([middle + start * direction, middle + max(end, 0.0) * direction])
    within = shapely.get_parts(straight.intersection(own.buffer(-_INSET * half)))
    longest = max(within, key=lambda one: one.length, default=None)
    if longest is None or not longest.length > _SHORTEST * half:
        return None
    ends = np.asarray(longest.coords)
    return GlyphStroke.filling(own, np.linspace(ends[0], ends[-1], 9))
