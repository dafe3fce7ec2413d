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
_MOST_SHARE_OF_BARE = 0.1  # of a ring: more is a gap, or a handle that hides much


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("on", metavar="OBJECT", help="a mesh file, a painting, or as --on of write")
    PaintingOptions.add_to(parser, "unit", "up", "from_points")
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> None:
    """Write what there is to say to stdout.

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
    """Lines that tell an object's size, and its sides in mm."""
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
        yield (
            f"a sheet, {sheet.usual.chinese}: {panels}{width:g} x {height:g} mm, "
            f"margin {sheet.margin_mm:g} mm, {sheet.usual.material}"
        )
    if is_flat(surface):
        yield from _flat(surface, "top")
    else:
        for side in ("outside", "inside"):
            yield from _around(surface, side)
        yield from _flat(surface, "top")
    yield from _flat(surface, "bottom")


def _around(surface: ClosestPoints, side: str) -> Iterator[str]:
    """What U and V are on a side that goes around a body; nothing where it has none."""
    from paint3d.mesh.placement import ring

    low, high = surface.mesh.bounds[:, 2].tolist()
    rows = []
    for v in _HEIGHTS:
        points = ring(surface, v, side, _AROUND)
        length, bare = _length(points)
        if math.isfinite(length):
            girth = f"{length:8.0f}" if bare <= _MOST_SHARE_OF_BARE else f"{length:8.0f}*"
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


def _length(points: AnyArray) -> tuple[float, float]:
    """Length of a ring (N, 3) where there is any, mm, and the fraction of it that is bare."""
    import numpy as np

    there = np.isfinite(points[:, 0])
    if there.sum() < 3:
        return math.nan, 1.0
    steps = np.linalg.norm(np.roll(points[there], -1, axis=0) - points[there], axis=1)
    return float(steps.sum()), 1.0 - float(there.mean())


def _flat(surface: ClosestPoints, side: str) -> Iterator[str]:
    """What U and V are on a side that is looked at from above or below; nothing without one."""
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
    """What a painting is made of, and where its paint is."""
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
