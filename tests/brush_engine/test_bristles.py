"""Single hairs: where they stand, how they bend, that they lie on the surface and keep length."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.bench.kernels.standing_bristles import bend_often
from paint3d.brush.bending import build_tuft
from paint3d.brush.bristles import MEASURED, build_bristles, hair_places
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import DEEPEST_PRESS, BristleSpec
from paint3d.brush_engine.bristles import bend as bt
from paint3d.errors import BrushError
from tests.support.examples import ALL, examples

FEW = settings(deadline=None, max_examples=examples(25))
BRUSHES = ["full", "gongbi"]  # measured hairs of each take seconds to be made ready
if ALL:
    BRUSHES += ["slender", "dakai", "dabaiyun", "langhao", "yanghao"]
PATCHES = {
    "plane": bt.FLAT,
    "ball of 30 mm": np.array([0.0, 0.05, -0.03, -1 / 60, 0.0, -1 / 60]),
    "bowl of 40 mm": np.array([0.1, -0.04, 0.02, 1 / 80, 0.0, 1 / 80]),
    "saddle": np.array([0.0, 0.0, 0.0, -0.015, 0.008, 0.012]),
}


built = cache(build_bristles)


def hairs_of(brush="full", n=300, descent=8.0, tilt=90.0, patch=bt.FLAT, turn=0.0, **options):
    """Points (SAMPLES, n, 3) of the hairs and their rest lengths (n,)."""
    spec = load_brush(brush)
    tuft, bristles = build_tuft(spec), built(spec, BristleSpec(n_hairs=n, **options))
    turned = bt.make_turned(len(bristles.lengths))
    bt.turn_hairs(bristles, math.cos(turn), math.sin(turn), turned)
    bend, block = np.zeros(1, bt.BEND), bt.make_block()
    pe = min(1.0, max(0.0, descent / spec.full_press_mm))
    cause = bt.Cause(descent, math.radians(tilt), pe, patch, 0.0, 0.0, 0.0, 0.0, 0.0)
    out = bt.make_points(len(turned))
    bend_often(1, bristles, tuft, cause, turned, bend, block, out)
    points = out.reshape(-1, bt.SAMPLES, 3, bt.BLOCK).transpose(1, 0, 3, 2)
    points = points.reshape(bt.SAMPLES, -1, 3)[:, :n].astype(np.float64)
    rests = bristles.rests.transpose(0, 2, 1).reshape(-1, bt.SAMPLES - 1)[:n].sum(axis=1)
    return points, rests


def lengths_of(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=2).sum(axis=0)


def height_of(patch, x, y):
    return (
        patch[0]
        + patch[1] * x
        + patch[2] * y
        + patch[3] * x * x
        + patch[4] * x * y
        + (patch[5] * y * y)
    )


@pytest.mark.parametrize("n", [100, 1000, 10_000])
def test_hairs_are_spread_evenly_over_the_ferrule(n):
    x, y = hair_places(n).astype(float)
    square, turn = np.sort(x * x + y * y), np.sort(np.mod(np.arctan2(y, x), 2 * np.pi))
    even = (np.arange(n) + 0.5) / n
    assert np.abs(square - even).max() < 1e-5  # as many in every ring of the same area
    assert np.abs(turn / (2 * np.pi) - even).max() < 0.02
    cells = np.histogram2d(x, y, 8, [[-1, 1], [-1, 1]])[0][2:6, 2:6]  # all within the disc
    assert np.abs(cells / cells.mean() - 1.0).max() < (0.6 if n == 100 else 0.15)


def test_a_single_hair_stands_in_the_middle():
    assert hair_places(1).tolist() == [[0.0], [0.0]]


@given(
    brush=st.sampled_from(BRUSHES),
    press=st.floats(0.0, 0.61),
    tilt=st.floats(30.0, 90.0),
    patch=st.sampled_from(sorted(PATCHES)),
    turn=st.floats(0.0, 6.3),
    table=st.sampled_from(["energy", "measured"]),
)
@FEW
def test_hairs_keep_their_length_and_none_is_under_the_surface(
    brush, press, tilt, patch, turn, table
):
    length = load_brush(brush).length_mm
    scaled = PATCHES[patch] * np.array([1, 1, 1, 35 / length, 35 / length, 35 / length])
    descent = press * length * math.sin(math.radians(tilt))
    points, rests = hairs_of(brush, 200, descent, tilt, scaled, turn, table=table)
    assert np.abs(lengths_of(points) / rests - 1.0).max() < 0.01
    ground = height_of(scaled, points[..., 0], points[..., 1])
    assert (points[..., 2] - ground).min() > -1e-3
    assert np.isfinite(points).all()


@pytest.mark.long  # its kernel is compiled for it alone; a point left out would lie underneath
@given(press=st.floats(0.0, 0.61), tilt=st.floats(30.0, 90.0), upper=st.floats(-3.0, 3.0))
@FEW
def test_points_too_near_the_root_to_come_to_the_plane_never_do(press, tilt, upper):
    spec, slope = load_brush("full"), math.radians(tilt)
    bristles, tuft = built(spec, BristleSpec(n_hairs=400)), build_tuft(spec)
    turned, bend, block = bt.make_turned(2), np.zeros(1, bt.BEND), bt.make_block()
    bt.turn_hairs(bristles, 1.0, 0.0, turned)
    descent = press * spec.length_mm * math.sin(slope)
    pe = min(1.0, descent / spec.full_press_mm)
    cause = bt.Cause(descent, slope, pe, bt.FLAT, 0.5, 0.5, 0.5, upper, upper)
    points, asked = bt.make_points(2), bt.make_points(2)
    bend_often(1, bristles, tuft, cause, turned, bend, block, points)
    assert bend["reach"][0] < bt.SAMPLES or press > 0.3
    bt.bend_hairs(bristles.rests, turned, bend[0], block, points)  # by the same code as below
    bend["reach"][0] = bt.SAMPLES  # ask every point
    bt.bend_hairs(bristles.rests, turned, bend[0], block, asked)
    assert (points == asked).all()


def test_pressed_flat_the_hairs_lie_evenly_side_by_side():
    bristles = build_bristles(load_brush("full"), BristleSpec(n_hairs=bt.BLOCK))
    b = np.linspace(-1.0, 1.0, bt.BLOCK, dtype=np.float32)
    places = np.stack([np.zeros_like(b), b])[:, None]
    places.setflags(write=False)  # as they are built
    bristles = bristles._replace(places=places)
    turned = bt.make_turned(1)
    bt.turn_hairs(bristles, 1.0, 0.0, turned)
    rows = turned.reshape(9, bt.BLOCK).astype(np.float64)
    even = rows[1] + rows[6]  # where they are, and how far they move
    np.testing.assert_array_equal(rows[1], b)
    b = b.astype(np.float64)
    np.testing.assert_allclose(
        even, 2.0 / np.pi * (np.arcsin(b) + b * np.sqrt(1.0 - b * b)), atol=1e-6
    )


def test_hairs_start_from_their_places_in_the_ferrule():
    spec = load_brush("full")
    points, _ = hairs_of(n=500, descent=6.0, tilt=60.0)
    places = hair_places(500) * 0.5 * spec.root_diameter_mm
    sine, cosine = math.sin(math.radians(60.0)), math.cos(math.radians(60.0))
    height = spec.length_mm * sine - 6.0
    np.testing.assert_allclose(points[-1, :, 0], places[0] * sine, atol=1e-3)
    np.testing.assert_allclose(points[-1, :, 1], places[1], atol=1e-3)
    np.testing.assert_allclose(points[-1, :, 2], height + places[0] * cosine, atol=1e-3)


@pytest.mark.parametrize("table", ["energy", "measured"])
def test_shapes_change_without_jumps(table):
    """As the handle leaves the upright and as it comes down, tips move little by little."""
    for tilts, descents in ((np.linspace(90.0, 87.0, 31), [8.0]), ([90.0, 45.0], [8.0, 8.02])):
        tips = [
            hairs_of(n=50, descent=d, tilt=t, table=table)[0][0] for t in tilts for d in descents
        ]
        moved = np.linalg.norm(np.diff(np.array(tips).reshape(-1, 50, 3), axis=0), axis=2)
        if len(descents) == 1:
            assert moved.max() < 0.15  # mm, of 0.06 mm that the tilt itself moves a tip
        else:
            assert moved[0].max() < 0.15
            assert moved[2].max() < 0.15


def test_the_energy_table_holds_the_solid_tufts_shapes():
    spec = load_brush("zhongkai")
    bristles, tuft = build_bristles(spec, BristleSpec(n_hairs=1)), build_tuft(spec)
    along, up, _ = spec.length_mm * tuft.spine[-1, 64]  # upright
    x, z = bristles.shapes[-1, 64, :8], bristles.shapes[-1, 64, 8:16]
    assert x[0] * spec.length_mm == pytest.approx(along[0], rel=1e-5)
    assert z[0] == 0.0
    assert x[-1] == pytest.approx(0.0, abs=1e-6)
    assert z[-1] * spec.length_mm == pytest.approx(up[-1], rel=1e-5)


def test_the_measured_table_goes_through_what_was_measured():
    spec = load_brush("full")
    bristles = build_bristles(spec, BristleSpec(n_hairs=1, table="measured"))
    columns = np.sqrt(np.linspace(0.0, 1.0, bristles.shapes.shape[1]) ** 2)
    heights = 1.0 - DEEPEST_PRESS * columns**2
    upright = np.array([row[1:] for row in MEASURED if row[0] == 0.0])
    for height, offset, *_, fan in upright[:4]:
        at = int(np.argmin(np.abs(heights - height)))
        near = np.interp(heights[at], *upright[::-1, :2].T)
        tip = bristles.shapes[-1, at, 0]
        assert near == pytest.approx(offset, abs=0.02)
        assert tip == pytest.approx(near, abs=0.08)  # cut, or laid on, to the hair's own length
        assert bristles.fans[-1, at, 0] == pytest.approx(math.radians(0.5 * fan), abs=0.02)
    beyond, at_45 = bristles.shapes[0, 60], bristles.shapes[6, 60]  # 30 and 45 degrees
    straight = math.sqrt(3.0) - 1.0  # both stand as their handle does
    assert np.abs(beyond - at_45).max() < straight


def test_more_hairs_are_the_same_tuft():
    few, many = (hairs_of(n=n, descent=9.0)[0] for n in (500, 5000))
    for points in (few, many):
        assert (points[0, :, 2] < 0.2).mean() > 0.5
    for axis in (0, 1):
        assert np.ptp(few[:3, :, axis]) == pytest.approx(np.ptp(many[:3, :, axis]), rel=0.05)


def test_an_unpressed_tuft_is_straight():
    points, rests = hairs_of(n=100, descent=-2.0)
    ends = np.linalg.norm(points[-1] - points[0], axis=1)
    assert (ends / rests > 0.97).all()  # the tuft tapers: its hairs lie along its side
    assert points[0, :, 2].min() > 1.9


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"n_hairs": 0}, "n_hairs is 0; expected 1 to 10000"),
        ({"n_hairs": 10_001}, "n_hairs is 10001"),
        ({"n_hairs": 2.5}, "whole number"),
        ({"table": "guessed"}, "table is 'guessed'; expected energy, measured or rows"),
        ({"film": -0.1}, "film is -0.1"),
        ({"parting": 2.0}, "parting is 2"),
    ],
)
def test_bad_hairs_are_named(options, said):
    with pytest.raises(BrushError, match=said):
        BristleSpec(**options)
