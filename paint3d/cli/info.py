"""Say how large an object is, what it is made of, and where --at U,V is on it, in mm."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from paint3d.cli.options import add_quiet_option
from paint3d.cli.painting import PaintingOptions, load_object, open_document

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from paint3d.core.arrays import AnyArray
    from paint3d.mesh.bvh import ClosestPoints
    from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["EXAMPLES", "add_arguments", "info_lines", "run"]

EXAMPLES = """
paint3d info mug.stl
paint3d info vase
paint3d info poem.p3d
"""

_HEIGHTS = (0.95, 0.75, 0.5, 0.25, 0.05)
_AROUND = 180
_LEVELS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
_BINS, _GAP = 50, 3  # parts of a full turn, and how many may lie between two of one handle
_PROBED_MM = 20.0  # the usual size of a character
_MOST_BARE = 0.1  # of a ring: more is a gap, or a handle that hides much


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("on", metavar="OBJECT", help="a mesh file, a painting, or as --on of write")
    PaintingOptions.add_to(parser, "unit", "up", "from_points")
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> None:
    """Print the object's size and sides.

    Raises
    ------
    Paint3DError
        If the object cannot be read.
    """
    from paint3d.files.project.session import is_session_path
    from paint3d.mesh.bvh import ClosestPoints

    wanted = PaintingOptions.of(options)
    if is_session_path(wanted.on):
        document = open_document(wanted, options)
        lines = [*info_lines(document.surface.closest_points), *_painted(document.surface)]
    else:
        wanted.check_object()
        lines = list(info_lines(ClosestPoints(load_object(wanted))))
    sys.stdout.write("\n".join(lines) + "\n")


def info_lines(surface: ClosestPoints) -> Iterator[str]:
    """Yield lines on an object's size, and its sides in mm."""
    from paint3d.mesh.placement import is_flat
    from paint3d.mesh.sheet_mesh import sheet_of

    mesh = surface.mesh
    low, high = mesh.bounds
    wide, deep, tall = (high - low).tolist()
    yield (
        f"{mesh.name}: {wide:.1f} wide (x), {deep:.1f} deep (y), {tall:.1f} high (z) mm; "
        f"{len(mesh.faces):,} triangles"
    )
    sheet = sheet_of(mesh)
    if sheet is not None:
        panels = f"{sheet.usual.panels} panels of " if sheet.usual.panels > 1 else ""
        width, height = sheet.size
        sides = f"{width:g} x {height:g} mm"
        if sheet.usual.shape == "sector":
            sides = f"{width:g} mm across, its leaf {height:g} mm broad"
        yield (
            f"a sheet, {sheet.usual.chinese}: {panels}{sides}, "
            f"margin {sheet.margin_mm:g} mm, {sheet.usual.material}"
        )
    if is_flat(surface):
        yield from _flat(surface, "top")
    else:
        yield from _around(surface, "outside")
        yield from _in_the_way(surface)
        yield from _around(surface, "inside")
        yield from _flat(surface, "top")
    yield from _flat(surface, "bottom")


def _around(surface: ClosestPoints, side: str) -> Iterator[str]:
    """Yield lines on U and V of a side that goes around a body; none without it."""
    from paint3d.mesh.placement import ring

    low, high = surface.mesh.bounds[:, 2].tolist()
    rows = []
    for v in _HEIGHTS:
        points = ring(surface, v, side, _AROUND)
        length, bare = _ring_length(points)
        if math.isfinite(length):
            girth = f"{length:8.0f}" if bare <= _MOST_BARE else f"{length:8.0f}*"
            rows.append((v, low + v * (high - low), girth, 0.1 * length))
    if not rows:
        return
    where = "outside, as seen from its front" if side == "outside" else "inside, as seen from above"
    to = "right" if side == "outside" else "left"
    yield ""
    yield f"--side {side} ({where}): U goes around to the {to}: 0.25 left, 0.5 front (-y),"
    yield f"  0.75 right (+x), 0 and 1 back; V up from z = {low:.1f} (0) to {high:.1f} mm (1)"
    yield "     V    z mm   girth mm   0.1 of U mm"
    for v, z, girth, tenth in rows:
        yield f"  {v:4g}  {z:6.1f}   {girth:<9s}  {tenth:8.1f}"
    yield f"  0.1 of V is {0.1 * (high - low):.1f} mm of height"
    if any("*" in row[2] for row in rows):
        yield "  * not all around: there are gaps, or something stands before it"


def _in_the_way(surface: ClosestPoints) -> Iterator[str]:
    """Yield a line for each part of an object that leaves no room for the usual brush."""
    import numpy as np

    from paint3d.brush.presets import brush_for
    from paint3d.calligraphy.free_arc import Ring
    from paint3d.calligraphy.layout import Layout, WritingArea, start_around, walking_step
    from paint3d.errors import InputError
    from paint3d.mesh.placement import turns_of, walk

    crowded = np.zeros((len(_LEVELS), _BINS), bool)
    for k, v in enumerate(_LEVELS):
        try:
            start = start_around(WritingArea(surface), Layout(around=True), _PROBED_MM, v)
            up, step = np.array([0.0, 0.0, 1.0]), walking_step(_PROBED_MM)
            right, left = (walk(surface, start, up, (way, 0.0), None, step) for way in (1.0, -1.0))
            ring = Ring(surface, right, left, up, _PROBED_MM)
        except InputError:
            continue
        near = ring.points[ring.crowded(brush_for(_PROBED_MM).length_mm)]
        crowded[k, (turns_of(surface.mesh, near) * _BINS).astype(int) % _BINS] = True
    for first, n in _runs_round(np.asarray(crowded.any(axis=0))):
        levels = np.flatnonzero(crowded[:, (first + np.arange(n)) % _BINS].any(axis=1))
        lowest, highest = (_LEVELS[j] for j in (levels[0], levels[-1]))
        yield (
            f"  in the way of a brush: {first / _BINS:.2f} to {(first + n) / _BINS % 1.0:.2f} of U "
            f"(a handle?), at V from {lowest:g} to {highest:g}"
        )


def _runs_round(crowded: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return starts and lengths of a ring's runs, over small gaps; none if all round."""
    import numpy as np

    n = len(crowded)
    wide = crowded.copy()
    for k in range(1, _GAP + 1):
        wide |= np.roll(crowded, k)
    if wide.all() or not wide.any():
        return []
    start = int(np.flatnonzero(~wide)[0])
    turned = np.concatenate([[False], np.roll(wide, -start), [False]])
    edges = np.flatnonzero(np.diff(turned.astype(int))).reshape(-1, 2)
    return [((start + a) % n, b - a - _GAP) for a, b in edges.tolist()]


def _ring_length(points: AnyArray) -> tuple[float, float]:
    """Return the length of a ring (N, 3), mm, NaN without one, and its missing fraction."""
    import numpy as np

    known = np.isfinite(points[:, 0])
    if known.sum() < 3:
        return math.nan, 1.0
    steps = np.linalg.norm(np.roll(points[known], -1, axis=0) - points[known], axis=1)
    return float(steps.sum()), 1.0 - float(known.mean())


def _flat(surface: ClosestPoints, side: str) -> Iterator[str]:
    """Yield lines on U and V of a side seen from above or below; none without it."""
    from paint3d.errors import MeshError
    from paint3d.mesh.bvh import ClosestPoints
    from paint3d.mesh.placement import place
    from paint3d.mesh.sheet_mesh import paper_bounds, sheet_of, writing_areas

    mesh = surface.mesh
    (left, front, _), (right, back, _) = paper_bounds(mesh).tolist()
    if sheet_of(mesh) is not None:
        surface = ClosestPoints(writing_areas(mesh, False)[0].mesh)
    try:
        height = place(surface, (0.5, 0.5), side).origin[2]
    except MeshError:
        return
    yield ""
    yield (
        f"--side {side} (z = {height:.1f} mm in its middle): U along x from {left:.1f} (0) to "
        f"{right:.1f} mm (1), V along y from {front:.1f} to {back:.1f} mm"
    )
    yield f"  0.1 of U is {0.1 * (right - left):.1f} mm, 0.1 of V is {0.1 * (back - front):.1f} mm"


def _painted(surface: PaintedSurface) -> Iterator[str]:
    """Yield lines on a painting's material, and its paint's bounds."""
    import numpy as np

    yield ""
    spacing = surface.resolution
    yield f"material {surface.material.name}" + (
        "" if spacing is None else f", vertices {spacing:g} mm apart where paint is"
    )
    painted = surface.painted
    if painted.any():
        points = surface.paint_mesh.vertices[: len(painted)][painted]
        low, high = np.round(points.min(axis=0), 1), np.round(points.max(axis=0), 1)
        yield f"paint from {low.tolist()} to {high.tolist()} mm (x, y, z)"
