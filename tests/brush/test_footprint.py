"""The footprint: check values, the papers' equations at the joints, techniques, the sphere."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from paint3d.brush.bending import build_tuft
from paint3d.brush.effective_footprint import (
    back_zone,
    effective_points,
    front_zone,
    stroke_width,
    technique,
)
from paint3d.brush.footprint import Footprint, make_footprint
from paint3d.brush.presets import brush_names, load_brush
from paint3d.brush_engine.tuft import SCRATCH_SIZE, bend_angles, enclose_tuft
from paint3d.errors import BrushError


def press(name, force, tilt=math.pi / 2, azimuth=0.0):
    tuft = build_tuft(load_brush(name))
    return make_footprint(tuft, force / tuft.spring, tilt, azimuth)


@pytest.mark.parametrize(
    ("name", "force", "length", "width", "area"),
    [
        ("full", 1.0, 3.68, 2.84, 7.9),
        ("full", 3.0, 7.68, 7.43, 38.6),
        ("full", 5.0, 11.6, 12.4, 96.0),
        ("full", 7.9, 17.7, 20.5, 251.0),
        ("slender", 3.0, 7.14, 2.51, 10.3),
        ("slender", 7.9, 19.3, 12.9, 133.0),
    ],
)
def test_check_values_of_the_model(name, force, length, width, area):
    footprint = press(name, force)
    assert footprint.length == pytest.approx(length, rel=0.01)
    assert footprint.width == pytest.approx(width, rel=0.01)
    assert footprint.area == pytest.approx(area, rel=0.01)


@pytest.mark.parametrize(("angle", "width"), [(180, 4.4), (135, 7.8), (90, 9.6)])
def test_stroke_widths_of_the_techniques(angle, width):
    footprint = press("slender", 4.0)
    direction = (math.cos(math.radians(angle)), math.sin(math.radians(angle)))
    assert stroke_width(footprint, direction) == pytest.approx(width, rel=0.015)


@pytest.mark.parametrize(
    ("angle", "name"), [(180, "zhongfeng"), (135, "cefeng"), (90, "pianfeng"), (10, "tip first")]
)
def test_techniques_are_named_by_bend_and_motion(angle, name):
    footprint = press("full", 4.0, azimuth=0.7)
    heading = 0.7 + math.radians(angle)
    assert technique(footprint, (math.cos(heading), math.sin(heading))) == name


def literal_outline(tuft, descent, tilt, pe):
    """Guo 2017, Eqs. 2, 3 and 6 to 9 at the joints, for alpha = 0, in the papers' own terms."""
    lengths = np.asarray(tuft.segment_lengths)
    m = len(lengths)
    beta = np.empty(m + 1)
    bend_angles(tuft, descent, tilt, beta)
    points = []
    for j in range(1, m):
        x_p = sum(lengths[t - 1] * math.cos(beta[t - 1]) for t in range(j + 1, m + 1))
        z_p = sum(lengths[t - 1] * math.sin(beta[t - 1]) for t in range(1, j + 1))
        middle = (beta[j - 1] + beta[j]) / 2
        c = tuft.diameters[-1] * (lengths[:j].sum() / tuft.length) ** tuft.taper
        c1 = c * (1 + tuft.spread * pe)
        c2 = c**2 / c1
        root = c2**2 - 4 * z_p**2 / math.cos(middle) ** 2
        if root < 0:
            break
        points.append((x_p - z_p * math.tan(middle), c1 / (2 * c2) * math.sqrt(root)))
    return np.array(points).reshape(-1, 2)


@pytest.mark.parametrize("name", brush_names())
@pytest.mark.parametrize("tilt", [0.6, 1.2, math.pi / 2])
@pytest.mark.parametrize("share", [0.3, 0.7])
def test_kernel_equals_the_equations_at_the_joints(name, tilt, share):
    tuft = build_tuft(load_brush(name))
    descent = share * tuft.greatest_fraction * tuft.length * math.sin(tilt)
    footprint = make_footprint(tuft, descent, tilt, pe=share)
    expected = literal_outline(tuft, descent, tilt, share)
    assert len(expected) >= 2
    # All but the last joint, which may lie on the steps that are traced anew towards M_d.
    for reach, half_width in expected[:-1]:
        nearest = np.argmin(np.abs(footprint.reach - reach))
        assert footprint.reach[nearest] == pytest.approx(reach, abs=1e-9)
        assert footprint.half_width[nearest] == pytest.approx(half_width, abs=1e-9)
    between = np.interp(expected[-1, 0], footprint.reach[::-1], footprint.half_width[::-1])
    assert between == pytest.approx(expected[-1, 1], abs=0.01 * footprint.width)


def test_azimuth_turns_the_polygon():
    still, turned = press("full", 4.0), press("full", 4.0, azimuth=2.1)
    c, s = math.cos(2.1), math.sin(2.1)
    assert np.allclose(turned.polygon(), still.polygon() @ np.array([[c, s], [-s, c]]), atol=1e-12)


def test_polygon_is_closed_symmetric_and_holds_the_area():
    footprint = press("full", 5.0)
    polygon = footprint.polygon()
    x, y = polygon.T
    shoelace = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    assert shoelace == pytest.approx(footprint.area, rel=1e-12)
    assert len(polygon) == 2 * len(footprint.reach) - 2
    assert y[0] == 0.0
    assert y.max() == pytest.approx(-y.min())


def test_zones_share_the_effective_points_and_make_up_the_outline():
    footprint = press("full", 4.0, azimuth=0.4)
    direction = (-1.0, 0.6)
    a, b = effective_points(footprint, direction)
    front, back = front_zone(footprint, direction), back_zone(footprint, direction)
    assert np.array_equal(front[0], a)
    assert np.array_equal(front[-1], b)
    assert np.array_equal(back[0], b)
    assert np.array_equal(back[-1], a)
    assert len(front) + len(back) == len(footprint.polygon()) + 2
    assert (front @ direction).max() == (footprint.polygon() @ direction).max()
    assert (back @ direction).min() == (footprint.polygon() @ direction).min()


def test_no_pressure_leaves_no_footprint():
    footprint = press("full", 0.0)
    assert footprint.is_empty
    assert footprint.area == footprint.length == footprint.width == 0.0
    assert footprint.polygon().shape == (0, 2)
    with pytest.raises(BrushError, match="empty"):
        effective_points(footprint, (1, 0))


@pytest.mark.parametrize(
    ("descent", "tilt", "pe", "message"),
    [
        (-1.0, 1.2, 0.5, "descent"),
        (30.0, 1.2, 0.5, "descent is 30; expected 0 to 20"),
        (math.nan, 1.2, 0.5, "descent"),
        (5.0, 0.3, 0.5, "tilt"),
        (5.0, 1.8, 0.5, "tilt"),
        (5.0, 1.2, 1.5, "pe"),
    ],
)
def test_numbers_out_of_range_are_refused(descent, tilt, pe, message):
    tuft = build_tuft(load_brush("full"))
    with pytest.raises(BrushError, match=message):
        make_footprint(tuft, descent, tilt, pe=pe)


@pytest.mark.parametrize(
    ("reach", "half_width"),
    [([0.0, 1.0], [0.0, 0.0]), ([1.0, 0.0], [0.0, 1.0]), ([2.0, 1.0, 0.0], [0.0, -1.0, 0.0])],
)
def test_outlines_that_are_none_are_refused(reach, half_width):
    with pytest.raises(BrushError):
        Footprint(np.array(reach), np.array(half_width), 0.0)


def test_direction_without_length_is_refused():
    with pytest.raises(BrushError, match="direction"):
        stroke_width(press("full", 3.0), (0.0, 0.0))


def surface_points(tuft, descent, tilt, pe, n_ring=8):
    """The bent tuft's tip and rings about its joints (K, 3), in the bend plane's frame."""
    m = len(tuft.segment_lengths)
    beta = np.empty(m + 1)
    bend_angles(tuft, descent, tilt, beta)
    runs, rises = tuft.segment_lengths * np.cos(beta[:m]), tuft.segment_lengths * np.sin(beta[:m])
    points = [(runs.sum(), 0.0, 0.0)]
    for j in range(1, m + 1):
        x, z = runs[j:].sum(), rises[:j].sum()
        middle = (beta[j - 1] + beta[j]) / 2
        c = tuft.diameters[-1] * (tuft.segment_lengths[:j].sum() / tuft.length) ** tuft.taper
        spread = 1 + tuft.spread * pe if j < m else 1.0
        for angle in 2 * np.pi * np.arange(n_ring) / n_ring:
            low = c / spread / 2 * math.cos(angle)
            side = c * spread / 2 * math.sin(angle)
            points.append((x + low * math.sin(middle), z + low * math.cos(middle), side))
    return np.array(points)


def smallest_ball(points):
    """Exact smallest enclosing ball: minimise the radius under one condition per point."""
    start = np.append(points.mean(axis=0), np.ptp(points, axis=0).max() ** 2)
    found = minimize(
        lambda v: v[3],
        start,
        jac=lambda v: np.array([0.0, 0.0, 0.0, 1.0]),
        constraints={
            "type": "ineq",
            "fun": lambda v: v[3] - ((points - v[:3]) ** 2).sum(axis=1),
            "jac": lambda v: np.hstack([2 * (points - v[:3]), np.ones((len(points), 1))]),
        },
        method="SLSQP",
        options={"ftol": 1e-10, "maxiter": 300},
    )
    return found.x[:3], math.sqrt(((points - found.x[:3]) ** 2).sum(axis=1).max())


@pytest.mark.parametrize("name", brush_names())
@pytest.mark.parametrize(("share", "tilt"), [(0.0, 1.5), (0.4, 0.7), (0.8, 1.3), (0.8, 1.57)])
def test_sphere_holds_the_tuft_and_is_nearly_the_smallest(name, share, tilt):
    tuft = build_tuft(load_brush(name))
    descent = share * tuft.greatest_fraction * tuft.length * math.sin(tilt)
    pe = share
    along, up, radius = enclose_tuft(tuft, descent, tilt, pe, np.empty(SCRATCH_SIZE))
    points = surface_points(tuft, descent, tilt, pe)
    distances = np.linalg.norm(points - (along, up, 0.0), axis=1)
    assert distances.max() <= radius * (1 + 1e-9)
    centre, exact = smallest_ball(points)
    assert centre[2] == pytest.approx(0.0, abs=0.05)
    assert exact * (1 - 1e-6) <= radius <= exact * 1.015
