"""Sheets as meshes: flat in z = 0, their middle at the origin, y upwards, coarse.

Paint refines them where it falls. A mounted sheet has silk around it and, as a scroll, wooden rods:
further triangles of one mesh, with colours. The paper's vertices come first; their colour is that
of the material (`with_paper`), as the mesh does not know it.
"""

from __future__ import annotations

import dataclasses
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import cross_2d, unit_vectors
from paint3d.errors import InputError
from paint3d.mesh.sheets import Sheet, is_sheet, parse_sheet
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "Fan",
    "WritingArea",
    "drawn",
    "fan_of",
    "make_sheet",
    "paper_bounds",
    "sheet_of",
    "with_paper",
    "writing_areas",
]

_EDGE_MM, _CURVED_EDGE_MM = 20.0, 8.0
_BETWEEN_MM = 120.0  # panels of a couplet
_BELOW_MM = 0.02  # the silk below the paper: seen as one, not welded
_HALF_OPENING = math.radians(70.0)  # of a folding fan

# a scroll's silk: sides, the strips next to the paper, what is above and below them, as parts of
# the paper's width; above and below are 6 to 4
_SIDE, _STRIP, _ABOVE, _UNDER = 0.09, 0.12, 0.6, 0.4
_BOARD = 0.12  # of the shorter side, all round
_ROD_MM, _ROLLER_MM, _KNOB_MM, _KNOB_OUT_MM = 6.0, 11.0, 14.0, 22.0
_AROUND = 24
_SILK, _STRIP_SILK = (203, 194, 170), (222, 216, 199)
_WOOD, _KNOB = (92, 62, 42), (60, 38, 26)
_PAPER = (255, 255, 255)  # until the material is known

_Part = tuple[AnyArray, AnyArray, tuple[int, int, int]]
"""Points (N, 3), triangles (M, 3) and the colour of a part."""


def make_sheet(sheet: Sheet) -> TriangleMesh:
    """A sheet as a mesh of its name."""
    middles = _middles(sheet)
    parts: list[_Part] = []
    for x in middles:
        points, faces = _paper(sheet, 0.0)
        parts.append((_shift_across(points, x), faces, _PAPER))
    if sheet.mounted:
        for x in middles:
            parts += [(_shift_across(p, x), f, colour) for p, f, colour in _mount(sheet)]
    starts = np.cumsum([0, *(len(points) for points, _, _ in parts)])
    points = np.concatenate([points for points, _, _ in parts])
    faces = np.concatenate([f + n for (_, f, _), n in zip(parts, starts, strict=False)])
    colours = None
    if sheet.mounted:
        colours = np.concatenate([np.tile(np.array(c, np.uint8), (len(p), 1)) for p, _, c in parts])
    return TriangleMesh(points, faces, colours, sheet.name)


@lru_cache(maxsize=8)
def sheet_of(mesh: TriangleMesh) -> Sheet | None:
    """The sheet that a mesh is, or None: others may bear such a name."""
    if not is_sheet(mesh.name):
        return None
    try:
        made = make_sheet(parse_sheet(mesh.name))
    except InputError:
        return None
    same = np.array_equal(mesh.faces, made.faces) and np.array_equal(mesh.vertices, made.vertices)
    return parse_sheet(mesh.name) if same else None


def with_paper(mesh: TriangleMesh, srgb: AnyArray) -> TriangleMesh:
    """A mounted sheet whose paper has the colour (3,) of its material; any other mesh itself."""
    sheet = sheet_of(mesh) if mesh.colours is not None else None
    if sheet is None or mesh.colours is None:
        return mesh
    n = len(_middles(sheet)) * len(_paper(sheet, 0.0)[0])
    colours = mesh.colours.copy()
    colours[:n] = srgb
    return dataclasses.replace(mesh, colours=colours)


class WritingArea(NamedTuple):
    """Part of a sheet on which text may stand."""

    mesh: TriangleMesh
    """It bears the object's name, so that messages say it."""
    apex: NDArray[np.float64] | None = None
    """(3,) mm: columns run to there, as on a folding fan to where its ribs meet."""


@lru_cache(maxsize=8)
def writing_areas(mesh: TriangleMesh, within_margins: bool = True) -> tuple[WritingArea, ...]:
    """A sheet's panels, within their margins or whole, from the right; any other mesh itself."""
    sheet = sheet_of(mesh)
    if sheet is None:
        return (WritingArea(mesh),)
    points, faces = _paper(sheet, sheet.margin_mm if within_margins else 0.0)
    apex = np.array([0.0, fan_of(sheet).apex, 0.0]) if sheet.usual.shape == "sector" else None
    return tuple(
        WritingArea(TriangleMesh(_shift_across(points, x), faces, None, mesh.name), apex)
        for x in reversed(_middles(sheet))
    )


def paper_bounds(mesh: TriangleMesh) -> NDArray[np.float64]:
    """Corners (2, 3) of the box around all panels of a sheet, or around any other mesh, mm."""
    boxes = np.array([area.mesh.bounds for area in writing_areas(mesh, False)])
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _middles(sheet: Sheet) -> list[float]:
    """The x of the middle of each panel, from the left."""
    step, n = sheet.width_mm + _BETWEEN_MM, sheet.usual.panels
    return [step * (k - 0.5 * (n - 1)) for k in range(n)]


def _shift_across(points: AnyArray, x: float) -> AnyArray:
    moved: AnyArray = points + np.array([x, 0.0, 0.0])
    return moved


class Fan(NamedTuple):
    """A folding fan's leaf: its radii, the y of its apex, mm, and half of its opening, radians."""

    outer: float
    inner: float
    apex: float
    half_opening: float


def fan_of(sheet: Sheet) -> Fan:
    """The leaf of a folding fan, whose box is in the middle."""
    outer = 0.5 * sheet.width_mm / math.sin(_HALF_OPENING)
    inner = outer - sheet.height_mm
    return Fan(outer, inner, -0.5 * (outer + inner * math.cos(_HALF_OPENING)), _HALF_OPENING)


def _paper(sheet: Sheet, margin: float) -> tuple[AnyArray, AnyArray]:
    """Points (N, 3) and triangles (M, 3) of one panel, less a margin."""
    width, height = sheet.width_mm - 2.0 * margin, sheet.height_mm - 2.0 * margin
    if sheet.usual.shape == "rectangle":
        return _grid(-0.5 * width, 0.5 * width, -0.5 * height, 0.5 * height)
    if sheet.usual.shape == "disc":
        return _disc(0.5 * width)
    outer, inner, apex, _ = fan_of(sheet)
    side = margin / (0.5 * (outer + inner))  # the margin at the ends, as an angle
    inner, outer, half = inner + margin, outer - margin, _HALF_OPENING - side
    points, faces = _grid(-half, half, inner, outer, outer, _CURVED_EDGE_MM)
    turn, radius = points[:, 0], points[:, 1]
    xy = [radius * np.sin(turn), radius * np.cos(turn) + apex, np.zeros(len(turn))]
    return np.stack(xy, axis=1), faces


def _grid(
    left: float, right: float, low: float, high: float, per_x: float = 1.0, edge: float = _EDGE_MM
) -> tuple[AnyArray, AnyArray]:
    """A rectangle in squares of about an edge, halved; x counts `per_x` mm."""
    n_x = max(1, round((right - left) * per_x / edge))
    n_y = max(1, round((high - low) / edge))
    y, x = np.meshgrid(
        np.linspace(low, high, n_y + 1), np.linspace(left, right, n_x + 1), indexing="ij"
    )
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    corner = (np.arange(n_y)[:, None] * (n_x + 1) + np.arange(n_x)).ravel()
    a, b, c, d = corner, corner + 1, corner + n_x + 2, corner + n_x + 1
    even = ((np.arange(n_y)[:, None] + np.arange(n_x)) % 2 == 0).ravel()[:, None]
    first = np.where(even, np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(even, np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    return points, np.stack([first, second], axis=1).reshape(-1, 3)


def _disc(radius: float) -> tuple[AnyArray, AnyArray]:
    """A disc in rings; ring k has 6 k points."""
    n = max(2, round(radius / _CURVED_EDGE_MM))
    points, faces = [np.zeros((1, 3))], []
    for ring in range(1, n + 1):
        turn = 2.0 * np.pi * np.arange(6 * ring) / (6 * ring)
        at = radius * ring / n
        flat = np.zeros(len(turn))
        points.append(np.stack([at * np.cos(turn), at * np.sin(turn), flat], axis=1))
        here, below = 1 + 3 * ring * (ring - 1), 1 + 3 * (ring - 1) * (ring - 2)
        for side in range(6):
            for k in range(ring):
                out = here + side * ring + k
                following = here + (side * ring + k + 1) % (6 * ring)
                if ring == 1:
                    faces.append((0, out, following))
                    continue
                of = 6 * (ring - 1)
                low = below + (side * (ring - 1) + k) % of
                faces.append((low, out, following))
                if k < ring - 1:
                    faces.append((low, following, below + (side * (ring - 1) + k + 1) % of))
    return np.concatenate(points), np.array(faces)


# ---- Mounts --------------------------------------------------------------------------------------


def _mount(sheet: Sheet) -> list[_Part]:
    """Return the parts of the mount around one panel: a border, or silk, strips and rods."""
    if sheet.usual.mount == "board":
        return [(*_border(sheet), _SILK)]
    silk, strips, rods = _scroll(sheet)
    parts: list[_Part] = [(*_lower(_grid(*box), 2.0), _SILK) for box in silk]
    parts += [(*_lower(_grid(*box), 1.0), _STRIP_SILK) for box in strips]
    parts += [(*_rod(*rod), colour) for rod, colour in rods]
    return parts


_Box = tuple[float, float, float, float]
"""Left, right, lower and upper side, mm; of a rod left, right, y and radius."""


def _scroll(sheet: Sheet) -> tuple[list[_Box], list[_Box], list[tuple[_Box, tuple[int, int, int]]]]:
    """The silk of a scroll, the strips next to the paper, and its rods with their colours."""
    w, h = 0.5 * sheet.width_mm, 0.5 * sheet.height_mm
    side, strip = 2.0 * w * _SIDE, 2.0 * w * _STRIP
    above, under = h + strip + 2.0 * w * _ABOVE, -h - strip - 2.0 * w * _UNDER
    silk = [
        (-w - side, w + side, h + strip, above),
        (-w - side, w + side, under, -h - strip),
        (-w - side, -w, -h - strip, h + strip),
        (w, w + side, -h - strip, h + strip),
    ]
    strips = [(-w, w, h, h + strip), (-w, w, -h - strip, -h)]
    rods = [
        ((-w - side, w + side, above, _ROD_MM), _WOOD),
        ((-w - side, w + side, under, _ROLLER_MM), _WOOD),
        ((-w - side - _KNOB_OUT_MM, -w - side + 1.0, under, _KNOB_MM), _KNOB),
        ((w + side - 1.0, w + side + _KNOB_OUT_MM, under, _KNOB_MM), _KNOB),
    ]
    return silk, strips, rods


def drawn(sheet: Sheet) -> list[tuple[AnyArray, tuple[int, int, int] | None]]:
    """A sheet as seen from above: polygons (N, 2), mm, and their colours; None for the paper."""
    parts: list[tuple[AnyArray, tuple[int, int, int] | None]] = []
    for x in _middles(sheet):
        boxes: list[tuple[_Box, tuple[int, int, int]]] = []
        if sheet.mounted and sheet.usual.mount == "scroll":
            silk, strips, rods = _scroll(sheet)
            boxes += [(box, _SILK) for box in silk] + [(box, _STRIP_SILK) for box in strips]
            boxes += [((a, b, y - r, y + r), colour) for (a, b, y, r), colour in rods]
        elif sheet.mounted:
            points, _ = _border(sheet)
            (left, low), (right, high) = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
            boxes.append(((left, right, low, high), _SILK))
        for (left, right, low, high), colour in boxes:
            corners = np.array([(left, low), (right, low), (right, high), (left, high)])
            parts.append((corners + np.array([x, 0.0]), colour))
        upper, lower = _rims(sheet)
        parts.append((np.concatenate([upper, lower[::-1]]) + np.array([x, 0.0]), None))
    return parts


def _lower(part: tuple[AnyArray, AnyArray], steps: float) -> tuple[AnyArray, AnyArray]:
    points, faces = part
    return points - [0.0, 0.0, steps * _BELOW_MM], faces


def _border(sheet: Sheet) -> tuple[AnyArray, AnyArray]:
    """A border all round: straight up and down from the paper's rim to the mount's."""
    upper, lower = _rims(sheet)
    wide = _BOARD * min(sheet.width_mm, sheet.height_mm)
    if sheet.usual.shape != "rectangle":
        wide *= 1.5
    low, high = lower[:, 1].min() - wide, upper[:, 1].max() + wide
    left, right = upper[0, 0] - wide, upper[-1, 0] + wide
    points: list[AnyArray] = []
    faces: list[AnyArray] = []
    n = 0
    for rim, to in ((upper, high), (lower, low)):
        beyond = np.stack([rim[:, 0], np.full(len(rim), to)], axis=1)
        near, far = n + np.arange(len(rim)), n + len(rim) + np.arange(len(rim))
        a, b, c, d = near[:-1], near[1:], far[1:], far[:-1]
        quads = _halve_quads(a, b, c, d)
        points += [rim, beyond]
        faces.append(quads if to == high else quads[:, ::-1])
        n += 2 * len(rim)
    for k, x in ((0, left), (-1, right)):  # beside the rim's ends, to the mount's sides
        top, bottom = upper[k, 1], lower[k, 1]
        inner = np.array([low, bottom, top, high])
        near = np.stack([np.full(4, upper[k, 0]), inner], axis=1)
        far = np.stack([np.full(4, x), inner], axis=1)
        a, b = n + np.arange(3), n + 1 + np.arange(3)
        quads = _halve_quads(a, b, b + 4, a + 4)
        points += [near, far]
        faces.append(quads if k == 0 else quads[:, ::-1])
        n += 8
    flat = np.concatenate(points)
    every = np.concatenate(faces)
    corners = flat[every]
    across = corners[:, 1:] - corners[:, :1]
    every = every[np.abs(cross_2d(across[:, 0], across[:, 1])) > 1e-9]
    points3 = np.concatenate([flat, np.full((len(flat), 1), -_BELOW_MM)], axis=1)
    return points3, every


def _halve_quads(a: AnyArray, b: AnyArray, c: AnyArray, d: AnyArray) -> AnyArray:
    """Two triangles (2 N, 3) of each quadrilateral of N corners a, b, c and d."""
    return np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)


def _rims(sheet: Sheet) -> tuple[AnyArray, AnyArray]:
    """The upper and the lower rim (N, 2) of the paper, both from left to right."""
    w, h = 0.5 * sheet.width_mm, 0.5 * sheet.height_mm
    if sheet.usual.shape == "rectangle":
        ends = np.array([[-w, h], [w, h]])
        return ends, ends * [1.0, -1.0]
    if sheet.usual.shape == "disc":
        n = 3 * max(2, round(w / _CURVED_EDGE_MM))
        turn = np.pi * (1.0 - np.arange(n + 1) / n)
        upper = w * unit_vectors(turn)
        return upper, upper * [1.0, -1.0]
    outer, inner, apex, _ = fan_of(sheet)
    n = max(1, round(2.0 * _HALF_OPENING * outer / _CURVED_EDGE_MM))
    turn = np.linspace(-_HALF_OPENING, _HALF_OPENING, n + 1)
    ray = np.stack([np.sin(turn), np.cos(turn)], axis=1)
    low, high = ([0.0, apex] + radius * ray for radius in (inner, outer))
    return high, np.concatenate([high[:1], low, high[-1:]])


def _rod(left: float, right: float, y: float, radius: float) -> tuple[AnyArray, AnyArray]:
    """A closed cylinder along x, behind the sheet by half of its radius."""
    turn = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
    n_x = max(1, round((right - left) / _EDGE_MM))
    xs = np.linspace(left, right, n_x + 1)
    ring = np.stack([y + radius * np.cos(turn), radius * np.sin(turn) - 0.5 * radius], axis=1)
    points = np.concatenate([np.insert(ring, 0, x, axis=1) for x in xs])
    ends = np.array([[left, y, -0.5 * radius], [right, y, -0.5 * radius]])
    k = np.arange(_AROUND)
    on = (k + 1) % _AROUND
    faces = []
    for j in range(n_x):
        a, b, c, d = (_AROUND * j + part for part in (k, on, _AROUND + on, _AROUND + k))
        faces.append(_halve_quads(a, b, c, d))
    n, last = len(points), n_x * _AROUND
    faces.append(np.stack([np.full(_AROUND, n), on, k], axis=1))
    faces.append(np.stack([np.full(_AROUND, n + 1), last + k, last + on], axis=1))
    return np.concatenate([points, ends]), np.concatenate(faces)
