"""Bodies of strokes: how far dry ones go, stubs that lines do not reach, and their sides."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from scipy.ndimage import gaussian_filter
from shapely import Polygon, box, unary_union

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import make_footprint
from paint3d.brush.presets import load_brush
from paint3d.calligraphy.glyphs import GlyphStroke
from paint3d.calligraphy.photo.ink_mask import bodies_in, find_ink
from paint3d.calligraphy.shapes.regions import with_stubs
from paint3d.calligraphy.stroke_sides import stroke_outlines, stroke_polygon
from paint3d.colour.materials import load_material
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface

WIDTH = 20.0
NONE = np.zeros((120, 300), bool)


def lanes(*bare: tuple[int, int, int]) -> np.ndarray:
    """A level stroke of six hairs, each two pixels, two apart; some bare for a way."""
    ink = NONE.copy()
    for hair in range(6):
        ink[40 + 4 * hair : 42 + 4 * hair, 40:260] = True
    for hair, first, last in bare:
        ink[40 + 4 * hair : 42 + 4 * hair, first:last] = False
    return ink


def test_a_hair_that_took_hold_again_went_over_what_is_bare() -> None:
    """At the rim, where no ink lies beyond; up to two widths."""
    ink = lanes((0, 120, 155), (1, 120, 155))
    body = bodies_in(ink, ink, WIDTH)
    assert body[48:62, 60:240].all()
    assert body[40:48, 121:154].mean() > 0.9
    assert not bodies_in(*[lanes((0, 80, 135), (1, 80, 135))] * 2, WIDTH)[40:44, 95:120].any()


def test_a_hair_that_never_comes_back_adds_nothing() -> None:
    ink = lanes((0, 120, 300), (1, 120, 300))
    body = bodies_in(ink, ink, WIDTH)
    assert not body[:44, 140:].any()
    assert body[48:62, 140:240].all()


def test_a_wet_stroke_ends_where_its_ink_does() -> None:
    """Two that meet: what lies in their corner, and between close ones, is paper."""
    ink = NONE.copy()
    ink[40:60, 40:260] = True
    ink[60:110, 100:120] = True
    ink[66:110, 126:146] = True  # beside the other, a quarter of a width away
    body = bodies_in(ink, ink, WIDTH)
    assert (body & ~ink).sum() < 0.005 * ink.sum()


@pytest.mark.parametrize(("streaks", "fills"), [(True, True), (False, False)])
def test_a_long_hole_is_a_streak_only_among_streaks(streaks: bool, fills: bool) -> None:
    ink = NONE.copy()
    ink[34:66, 40:260] = True
    ink[43:57, 110:190] = False  # narrower than a stroke, longer than a streak
    if streaks:
        for first in (70, 190):  # at both ends of it alone
            ink[36:64:4, first : first + 40] = False
    assert bodies_in(ink, ink, WIDTH)[50, 150] == fills


def test_wide_gaps_are_closed_where_streaks_are_many() -> None:
    ink = NONE.copy()
    for first in (40, 56, 72):
        ink[first : first + 4, 40:260] = True
    assert bodies_in(ink, ink, WIDTH)[44:72, 60:240].all()
    ink[44:100] = False
    ink[56:76, 40:260] = True  # a solid one, as far away
    assert not bodies_in(ink, ink, WIDTH)[50, 60:240].any()


@pytest.mark.parametrize(("side", "fills"), [(10, True), (14, False)])
def test_small_holes_belong_to_a_wet_stroke(side: int, fills: bool) -> None:
    ink = NONE.copy()
    ink[30:70, 40:260] = True
    ink[45 : 45 + side, 140 : 140 + side] = False
    assert bodies_in(ink, ink, WIDTH)[50, 145] == fills


def test_faint_ink_counts_among_streaks_alone() -> None:
    ink = lanes((0, 120, 300), (1, 120, 300))
    faint = ink.copy()
    faint[40:42, 120:260] = True
    assert not bodies_in(ink, ink, WIDTH)[40, 150:240].any()
    assert bodies_in(ink, faint, WIDTH)[40, 150:240].all()
    solid = NONE.copy()
    solid[44:64, 40:260] = True
    faint = solid.copy()
    faint[36:44, 40:260] = True
    assert not bodies_in(solid, faint, WIDTH)[38].any()


def test_what_a_lens_spreads_is_seen_as_narrow_as_it_is() -> None:
    """A gap of a pixel between two strokes stays open, and a hair beside one is ink."""
    fine = np.zeros((1, 2000))  # ten to a pixel
    for first, last in ((600, 720), (730, 850), (890, 905)):
        fine[0, first:last] = 0.95
    taken = gaussian_filter(fine, (0.0, 10.0)).reshape(200, 10).mean(axis=1)
    lit = np.zeros((200, 200), np.float32)
    lit[40:160] = -np.log10(1.0 - taken)
    inked = find_ink(lit).mask[60:140].mean(axis=0)
    assert inked[72] == 0.0
    assert inked[[70, 74, 89]].tolist() == [1.0, 1.0, 1.0]


# -- stubs that lines do not reach -------------------------------------------------------------


STEM = np.array([[50.0, 190.0], [50.0, 10.0]])


def stroke(shape, line):
    return GlyphStroke(np.array(shape.exterior.coords)[:-1], line)


def test_an_arm_beside_a_bold_stem_is_a_stroke_of_its_own() -> None:
    shape = box(30, 0, 70, 200).union(box(0, 110, 31, 140))
    given = stroke(shape, STEM)
    found = with_stubs([given], 30.0)
    assert len(found) == 2
    assert found[0] is given
    arm = shapely.Polygon(found[1].outline)
    assert arm.contains(box(1, 111, 29, 139))
    assert shape.buffer(1e-6).contains(arm)
    line = shapely.LineString(found[1].median)
    assert arm.contains(line)
    assert line.coords[0][0] < line.coords[-1][0]  # from its far end into the stem


def test_thin_strokes_and_plain_ends_have_none() -> None:
    arm = box(30, 0, 70, 200).union(box(0, 110, 31, 140))
    assert len(with_stubs([stroke(arm, STEM)], 50.0)) == 1
    plain = stroke(box(30, 0, 70, 200), STEM)
    assert with_stubs([plain], 30.0) == [plain]


def test_what_is_bare_beside_a_line_but_narrow_is_none() -> None:
    """A line that runs off the middle leaves a band along the edge, a fifth of the stroke wide."""
    assert len(with_stubs([stroke(box(30, 0, 78, 200), STEM)], 30.0)) == 1


# -- sides -------------------------------------------------------------------------------------


BRUSH = "zhongbaiyun"


@functools.cache
def tuft():
    return build_tuft(load_brush(BRUSH))


def recording(xy, bend, pressure, **header):
    n = len(xy)
    height = tuft().length - np.asarray(pressure) * tuft().full_press
    half = 0.5 * np.asarray(bend)
    turn = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1)
    position = np.column_stack([xy, height])
    return Recording(np.arange(n) * 4_000_000, position, turn, pressure, header=header)


def curved(n=240):
    """A stroke that bends, swells and turns the tuft."""
    t = np.linspace(0.0, 1.0, n)
    xy = 30.0 * np.column_stack([t - 0.5, 0.6 * np.sin(2.5 * t)])
    pressure = 0.45 * np.sin(np.pi * t) ** 0.7
    return xy, math.pi + 1.2 * t, np.where((t == 0) | (t == 1), 0.0, pressure)


def turning(n=120):
    """A press that turns on the spot."""
    t = np.linspace(0.0, 1.0, n)
    pressure = 0.4 * np.minimum(1.0, 8.0 * np.minimum(t, 1.0 - t))
    return np.zeros((n, 2)), 2.0 * t, pressure


def returning(n=240):
    """There and back, pressed deeper on the way back."""
    t = np.linspace(0.0, 1.0, n)
    xy = np.column_stack([20.0 * np.sin(np.pi * t), 0 * t])
    return xy, np.full(n, math.pi), np.minimum(0.2 + 0.3 * t, 6.0 * np.minimum(t, 1.0 - t))


def area(rings):
    """Area inside, holes running the other way round."""
    total = 0.0
    for ring in rings:
        x, y = ring.T
        total += 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    return total


@functools.cache
def painted_area(kind):
    glaze = replace(load_material("porcelain"), name="as rated", friction=1.0)
    surface = PaintedSurface(load_mesh("plane"), 0.2, glaze)
    Painter(surface, brush=BRUSH).replay(recording(*kind()))
    mesh = surface.mesh
    corners = np.asarray(mesh.vertices, float)[mesh.faces]
    size = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    cover = np.asarray(surface.coverage, float)[mesh.faces]
    return float((size * np.clip(cover, 0.0, 1.0).mean(axis=1)).sum())


@pytest.mark.parametrize("kind", [curved, turning, returning])
def test_area_is_that_of_the_painted_stroke(kind):
    (rings,) = stroke_outlines(recording(*kind()), load_brush(BRUSH))
    assert area(rings) == pytest.approx(painted_area(kind), rel=0.01)


@pytest.mark.parametrize("kind", [curved, turning, returning])
def test_every_footprint_lies_within(kind):
    xy, azimuth, pressure = kind()
    prints = [
        make_footprint(tuft(), p * tuft().full_press, 0.5 * math.pi, a)
        for p, a in zip(pressure, azimuth, strict=True)
        if p > 0.0
    ]
    feet = xy[np.asarray(pressure) > 0.0]
    kept = [not f.is_empty for f in prints]
    feet, prints = feet[kept], [f for f in prints if not f.is_empty]
    shape = stroke_polygon(feet, prints)
    union = unary_union(
        [Polygon(f.polygon() + foot).buffer(0) for f, foot in zip(prints, feet, strict=True)]
    )
    assert union.difference(shape).area < 0.004 * union.area


def test_strokes_are_told_apart():
    xy, azimuth, pressure = curved()
    both = recording(
        np.concatenate([xy, xy + 40.0]), np.r_[azimuth, azimuth], np.r_[pressure, pressure]
    )
    outlines = stroke_outlines(both, load_brush(BRUSH))
    assert len(outlines) == 2
    assert area(outlines[0]) == pytest.approx(area(outlines[1]), rel=1e-6)


def test_a_recording_that_cannot_be_outlined_is_refused():
    xy, azimuth, pressure = curved(20)
    with pytest.raises(InputError, match="commanded azimuth"):
        stroke_outlines(recording(xy, azimuth, pressure, azimuth="dragged"), load_brush(BRUSH))
    leaning = Recording(
        np.arange(2), np.zeros((2, 3)), np.tile([0.92388, 0.38268, 0, 0], (2, 1)), np.full(2, 0.3)
    )
    with pytest.raises(InputError, match="upright"):
        stroke_outlines(leaning, load_brush(BRUSH))
