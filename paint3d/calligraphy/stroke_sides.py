"""Outlines of strokes on a plane by the construction of Guo 2015, section 3.2.

A stroke is the b zone of its first footprint, the band between the effective points of all
footprints, and the f zone of the last. That holds while a footprint is pushed along; where the
brush turns on the spot, goes back, or is pressed deeper than it moves, a footprint stands out of
the band. The stroke is therefore taken apart there: that footprint ends one piece by its f zone
and begins the next by its b zone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import (
    Footprint,
    back_zone,
    effective_points,
    front_zone,
    make_footprint,
)
from paint3d.brush.spec import BrushSpec
from paint3d.brush_engine.drag import bent_by_twist, drag_length, twist_step
from paint3d.brush_engine.outline import gather_outline
from paint3d.core.arrays import AnyArray
from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.device.recorded import Recording
from paint3d.errors import InputError
from paint3d.pose.brush_pose import brush_poses

if TYPE_CHECKING:
    from shapely import Polygon

__all__ = ["stroke_outlines", "stroke_polygon"]

_STEP = 0.02  # of a footprint's size: how far a footprint moves before the next one counts
_FINEST_MM = 0.02
_LEFT_OUT = 0.0015  # fraction of the stroke's area that may stand out of the bands, all together
_UPRIGHT = math.cos(math.radians(1.0))
_CRACK = 0.02  # of the widest footprint: cracks between bands are closed up to twice this
_SIMPLER = 0.004  # mm that an outline may be moved to save points


def stroke_outlines(recording: Recording, brush: BrushSpec) -> list[list[AnyArray]]:
    """The outlines of a recording's strokes on the plane z = 0.

    Parameters
    ----------
    recording : Recording
        With pressure, the holder upright, the azimuth commanded.
    brush : BrushSpec

    Returns
    -------
    list of lists of (N, 2) float64
        For every stroke its rings, mm: the outline, counter-clockwise, then holes, clockwise.

    Raises
    ------
    InputError
        If the recording has no pressure, leans, or lets the surface turn the tuft.
    """
    path = brush_poses(recording)
    if path.pressure is None or recording.header["azimuth"] != "commanded":
        raise InputError("outlines of strokes need a recording with pressure and commanded azimuth")
    frames = matrices_from_quaternions(path.orientation)
    down = path.pressure > 0.0
    if down.any() and frames[down, 2, 2].min() < _UPRIGHT:
        raise InputError("outlines of strokes need an upright holder on the plane z = 0")
    tuft = build_tuft(brush)
    azimuth = np.arctan2(frames[:, 1, 0], frames[:, 0, 0])
    outlines = []
    edges = np.flatnonzero(np.diff(np.r_[False, down, False].astype(np.int8)))
    for first, last in edges.reshape(-1, 2).tolist():  # runs of samples that are down
        feet, prints = [], []
        twist = 0.0
        for k in range(first, last):
            descent = path.pressure[k] * tuft.full_press
            if k > first:
                turned = math.remainder(azimuth[k] - azimuth[k - 1], 2.0 * math.pi)
                distance = math.dist(path.position[k, :2], path.position[k - 1, :2])
                slack = drag_length(descent, tuft.length, tuft.drag_fraction)
                twist = twist_step(twist, turned, distance, slack)
            pressed = make_footprint(tuft, descent, 0.5 * math.pi, azimuth[k])
            footprint = _twist_footprint(pressed.rounded(), twist)
            if not footprint.is_empty:
                feet.append(path.position[k, :2])
                prints.append(footprint)
        if prints:
            outlines.append(_rings(stroke_polygon(np.array(feet), prints)))
    return outlines


def _twist_footprint(footprint: Footprint, twist: float) -> Footprint:
    """A footprint under an upright holder as it lies with a twist (rad)."""
    bent = bent_by_twist(twist)
    if bent >= 1.0 or footprint.is_empty:
        return footprint
    reach, half_width = footprint.reach.copy(), footprint.half_width.copy()
    gather_outline(bent, 0.0, reach, half_width, len(reach))
    return Footprint(reach, half_width, footprint.azimuth)


def stroke_polygon(feet: AnyArray, prints: list[Footprint]) -> Polygon:
    """The shape of one stroke: footprints about their feet (N, 2), mm, in order."""
    from shapely import Polygon, unary_union

    feet, prints = _thin_out(feet, prints)
    whole = [Polygon(f.polygon() + foot).buffer(0.0) for f, foot in zip(prints, feet, strict=True)]
    if len(prints) == 1:
        return whole[0]
    headings = _headings(feet, prints)
    pieces = list(_bands(feet, prints, headings))
    pieces.append(_make_valid(back_zone(prints[0], headings[0]) + feet[0]))
    pieces.append(_make_valid(front_zone(prints[-1], headings[-1]) + feet[-1]))
    shape = unary_union(pieces)
    out = np.array([w.difference(shape).area for w in whole])
    while out.sum() > 0.0 and out.max() > _LEFT_OUT * shape.area / math.sqrt(len(prints)):
        k = int(np.argmax(out))
        ends = (back_zone(prints[k], headings[k]), front_zone(prints[k], headings[k]))
        shape = unary_union([shape, *(_make_valid(zone + feet[k]) for zone in ends)])
        near = np.flatnonzero(out > 0.0)
        out[near] = [whole[i].difference(shape).area for i in near]
        out[k] = 0.0
    crack = _CRACK * max(f.width for f in prints)
    return shape.buffer(crack).buffer(-crack)


def _thin_out(feet: AnyArray, prints: list[Footprint]) -> tuple[AnyArray, list[Footprint]]:
    """Leave out footprints that hardly differ from the last one that stays."""
    retained = [0]
    outlines = [_extreme_points(f) + foot for f, foot in zip(prints, feet, strict=True)]
    for k in range(1, len(prints)):
        moved = np.abs(outlines[k] - outlines[retained[-1]]).max()
        if moved > max(_STEP * prints[k].width, _FINEST_MM) or k == len(prints) - 1:
            retained.append(k)
    return feet[retained], [prints[k] for k in retained]


def _extreme_points(footprint: Footprint) -> AnyArray:
    """Tip, heel and both sides (4, 2) of a footprint."""
    polygon = footprint.polygon()
    widest = int(np.argmax(footprint.half_width))
    n = len(footprint.reach)
    return polygon[[0, widest, n - 1, (len(polygon) - widest) % len(polygon)]]


def _footprint_middle(footprint: Footprint) -> AnyArray:
    """Half-way between tip and heel (2,)."""
    half_way = 0.5 * float(footprint.reach[0] + footprint.reach[-1])
    turn = footprint.azimuth
    return np.array([half_way * math.cos(turn), half_way * math.sin(turn)])


def _headings(feet: AnyArray, prints: list[Footprint]) -> AnyArray:
    """Directions of motion (N, 2) of the footprints' middles."""
    middles = feet + np.array([_footprint_middle(f) for f in prints])
    steps = np.diff(middles, axis=0)
    lengths = np.linalg.norm(steps, axis=1, keepdims=True)
    steps = np.where(lengths > 1e-9, steps / np.maximum(lengths, 1e-9), [1.0, 0.0])
    both = np.vstack([steps[:1], steps[1:] + steps[:-1], steps[-1:]])
    size = np.linalg.norm(both, axis=1, keepdims=True)
    return np.where(size > 1e-6, both / np.maximum(size, 1e-9), np.vstack([steps, steps[-1:]]))


def _bands(feet: AnyArray, prints: list[Footprint], headings: AnyArray) -> Iterable[Polygon]:
    """Area between the effective points of neighbouring footprints."""
    points = [
        [foot + p for p in effective_points(f, heading)]
        for foot, f, heading in zip(feet, prints, headings, strict=True)
    ]
    for (a, b), (c, d) in pairwise(points):
        yield _make_valid(np.array([a, b, d, c]))


def _make_valid(ring: AnyArray) -> Polygon:
    """A polygon; the convex hull of a ring that crosses itself."""
    from shapely import MultiPoint, Polygon

    if len(ring) > 2:
        polygon = Polygon(ring)
        if polygon.is_valid:
            return polygon
    hull = MultiPoint(ring).convex_hull
    return hull if hull.geom_type == "Polygon" else Polygon()


def _rings(shape: Polygon) -> list[AnyArray]:
    """The rings of a shape, its parts one after the other."""
    from shapely.geometry.polygon import orient

    rings = []
    for part in getattr(shape, "geoms", [shape]):
        if part.geom_type == "Polygon" and not part.is_empty:
            simple = orient(part.simplify(_SIMPLER))
            rings.append(np.asarray(simple.exterior.coords)[:-1])
            rings.extend(np.asarray(hole.coords)[:-1] for hole in simple.interiors)
    return rings
