"""Curves by which the hand drives a brush: what they take, and what they do to either tuft."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from paint3d.brush.presets import load_brush
from paint3d.brush.spec import INPUTS, SETTINGS, build_curves
from paint3d.brush_engine.stroke_loop import curve_at
from paint3d.errors import BrushError
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.surface_cases import flat, poses, sheet

UP = (0.0, 0.0, 1.0)
FULL = load_brush("full")


def driven(**inputs):
    return dataclasses.replace(FULL, inputs=inputs)


def stroke(press=0.5, rate=125.0, bow=0.0, n=16):
    share = np.linspace(0.0, 1.0, n)
    points = np.column_stack([40.0 * share - 20.0, bow * np.sin(np.pi * share), np.zeros(n)])
    return poses(points, UP, (-1.0, 0.0, 0.0), press * np.sin(np.pi * share), "full", rate=rate)


def paint(brush, recording: Recording, hairs=0, wipe=0.0, material="porcelain") -> Painter:
    surface = PaintedSurface(sheet(flat, (40.0, 20.0), 5.0), 0.6, material)
    painter = Painter(surface, brush, hairs=hairs)
    painter.wipe(wipe)
    painter.replay(recording)
    return painter


def area(painter):
    return float(painter.surface.coverage @ painter.surface.vertex_areas)


def test_a_curve_goes_straight_from_point_to_point_and_holds_beyond():
    points = np.array([[1.0, 2.0], [2.0, 4.0], [4.0, 0.0]])
    xs = (0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0)
    assert [curve_at(points, 3, x) for x in xs] == [2.0, 2.0, 3.0, 4.0, 2.0, 0.0, 0.0]
    assert curve_at(points, 1, 5.0) == 2.0


@pytest.mark.parametrize("hairs", [0, 200])
def test_pressure_drives_spread_and_stiffness(hairs):
    plain = area(paint(FULL, stroke(), hairs))
    assert area(paint(driven(spread={"pressure": [[0, 0.5]]}), stroke(), hairs)) < 0.9 * plain
    assert area(paint(driven(stiffness={"pressure": [[0, 2.0]]}), stroke(), hairs)) < 0.8 * plain
    same = paint(driven(spread={"pressure": [[0.9, 1.0], [1.0, 3.0]]}), stroke(), hairs)
    assert area(same) == plain  # never pressed so far


@pytest.mark.parametrize("hairs", [0, 200])
def test_speed_drives_load(hairs):
    brush = driven(load={"speed": [[50, 1.0], [200, 0.25]]})
    given = [
        paint(b, stroke(rate=rate), hairs).ledger()["wet"]
        for rate in (40.0, 400.0)  # 107 mm/s and 1067 mm/s
        for b in (FULL, brush)
    ]
    assert 0.5 * given[0] < given[1] < 0.95 * given[0]
    assert given[3] == pytest.approx(0.25 * given[2], rel=0.05)


def test_speed_drives_wetness_and_a_fast_brush_breaks_up():
    brush = driven(wetness={"speed": [[150, 1.0], [600, 0.2]]})
    for hairs, material in ((300, "porcelain"), (0, "xuan")):  # a solid tuft skips on the grain
        slow, fast = (
            area(paint(brush, stroke(rate=rate), hairs, 0.6, material)) for rate in (40.0, 400.0)
        )
        assert fast < 0.85 * slow


def test_ink_left_tilt_and_curvature_drive_as_well():
    for brush, recording in (
        (driven(spread={"ink_left": [[0.3, 0.3], [0.9, 1.0]]}), stroke()),
        (driven(spread={"tilt": [[30, 0.3], [95, 0.4]]}), stroke()),
        (driven(spread={"curvature": [[0.0, 1.0], [0.01, 0.3]]}), stroke(bow=8.0)),
    ):
        wiped = 0.7 if "ink_left" in str(brush.inputs) else 0.0
        assert area(paint(brush, recording, wipe=wiped)) < 0.93 * area(
            paint(FULL, recording, wipe=wiped)
        )
    straight = driven(spread={"curvature": [[0.0, 1.0], [0.01, 0.3]]})
    assert area(paint(straight, stroke())) == area(paint(FULL, stroke()))


def test_driven_brushes_keep_their_ink_and_repeat():
    brush = driven(
        wetness={"speed": [[0, 1.0], [300, 0.3]]}, load={"pressure": [[0, 0.5], [1, 2.0]]}
    )
    a, b = (paint(brush, stroke(bow=5.0), 200, 0.5) for _ in range(2))
    assert a.surface.amounts.tobytes() == b.surface.amounts.tobytes()
    ledger = a.ledger()
    there = sum(ledger[k] for k in ("in_brush", "wet", "dry", "off_surface"))
    assert there == pytest.approx(ledger["loaded"], rel=1e-6)


def test_a_preset_keeps_its_curves_and_hairs():
    brush = load_brush("feibai")
    assert brush.bristles.n_hairs == 1000
    curves = build_curves(brush.inputs)
    assert curves.any[0] == 4
    row, column = SETTINGS.index("wetness"), INPUTS.index("speed")
    assert curves.counts[row, column] == 4
    assert curves.points[row, column, 3].tolist() == [500.0, 0.25]
    assert hash(brush) == hash(load_brush("feibai"))


@pytest.mark.parametrize(
    ("inputs", "said"),
    [
        ({"colour": {"speed": [[0, 1]]}}, "drive 'colour'; expected stiffness, spread"),
        ({"load": {"mood": [[0, 1]]}}, "'mood'; expected one of pressure, tilt, speed"),
        ({"load": {"speed": []}}, "has 0 points; expected 1 to 8"),
        ({"load": {"speed": [[0, 1], [0, 2]]}}, "expected them to rise"),
        ({"load": {"speed": [[0, 0.0]]}}, "a factor is 0; expected 0.05 to 20"),
        ({"load": {"speed": [[float("nan"), 1]]}}, "an input is nan"),
        ({"load": {"speed": [3]}}, r"expected points \[input, factor\]"),
        ({"load": 3}, "expected names with curves"),
    ],
)
def test_bad_curves_are_named(inputs, said):
    with pytest.raises(BrushError, match=said):
        dataclasses.replace(FULL, inputs=inputs)
