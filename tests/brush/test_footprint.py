"""The footprint: check values, the papers' equations at the joints, techniques, the sphere."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from paint3d.brush.bending import bending_table, build_tuft
from paint3d.brush.footprint import (
    Footprint,
    back_zone,
    effective_points,
    front_zone,
    make_footprint,
    stroke_width,
    technique,
)
from paint3d.brush.presets import brush_names, load_brush
from paint3d.brush_engine.tuft import RING_STATIONS, STATIONS, enclose_tuft, trace_spine
from paint3d.errors import BrushError


def press(name, force, tilt=math.pi / 2, azimuth=0.0):
    tuft = build_tuft(load_brush(name))
    return make_footprint(tuft, force / tuft.spring, tilt, azimuth)


@pytest.mark.parametrize(
    ("name", "force", "length", "width", "area"),
    [
        ("full", 1.0, 3.35, 2.51, 5.5),
        ("full", 3.0, 7.92, 7.21, 37.2),
        ("full", 5.0, 11.9, 12.4, 96.6),
        ("full", 7.9, 17.9, 21.6, 252.0),
        ("slender", 3.0, 7.71, 2.89, 12.6),
        ("slender", 7.9, 20.4, 13.3, 148.0),
    ],
)
def test_check_values_of_the_model(name, force, length, width, area):
    footprint = press(name, force)
    assert footprint.length == pytest.approx(length, rel=0.01)
    assert footprint.width == pytest.approx(width, rel=0.01)
    assert footprint.area == pytest.approx(area, rel=0.01)


@pytest.mark.parametrize(("angle", "width"), [(180, 4.35), (135, 8.04), (90, 10.15)])
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
    """Guo 2017, Eqs. 2, 3 and 6 to 9 at the stations, for alpha = 0, in the papers' own terms."""
    spine = np.empty((3, STATIONS))
    trace_spine(tuft, descent, tilt, spine)
    points = []
    for x_p, z_p, beta, c in zip(*spine[:, 1:], tuft.diameters[1:], strict=True):
        c1 = c * (1 + tuft.spread * pe)
        c2 = c**2 / c1
        root = c2**2 - 4 * z_p**2 / math.cos(beta) ** 2
        if root < 0:
            break
        points.append((x_p - z_p * math.tan(beta), c1 / (2 * c2) * math.sqrt(root)))
    return np.array(points).reshape(-1, 2)


@pytest.mark.parametrize("name", brush_names())
@pytest.mark.parametrize(("row", "column"), [(2, 70), (12, 100), (24, 60), (24, 110)])
def test_kernel_equals_the_equations_at_the_stations(name, row, column):
    tuft, table = build_tuft(load_brush(name)), bending_table(load_brush(name).stiffness_exponent)
    tilt, share = float(table.tilts[row]), float(table.fractions[column])
    descent = share * tuft.length * math.sin(tilt)
    footprint = make_footprint(tuft, descent, tilt, pe=share)
    reach, half_width = literal_outline(tuft, descent, tilt, share).T
    assert len(reach) >= 10
    ours = np.interp(reach, footprint.reach[::-1], footprint.half_width[::-1])
    # all but the last station: towards M_d the half width falls like a root
    assert np.allclose(ours[:-1], half_width[:-1], atol=0.01 * footprint.width)


@pytest.mark.parametrize(
    ("tilt", "descent", "heel", "tip", "width", "area"),
    [
        (90, 0.5, -0.039, 0.872, 0.607, 0.361),
        (90, 2.0, 0.345, 3.436, 2.281, 4.586),
        (90, 8.0, 3.206, 12.359, 8.729, 52.08),
        (75, 0.5, 8.882, 9.738, 0.538, 0.308),
        (75, 2.0, 8.737, 11.642, 2.066, 3.970),
        (75, 8.0, 9.396, 18.137, 8.265, 47.44),
        (60, 0.5, 17.003, 17.985, 0.565, 0.378),
        (60, 2.0, 16.139, 19.346, 2.134, 4.605),
        (60, 8.0, 14.491, 24.008, 8.534, 54.06),
    ],
)
def test_values_of_another_solver_and_tracer(tilt, descent, heel, tip, width, area):
    """From a program of its own, with other numbers of arcs, columns and iterations."""
    footprint = make_footprint(build_tuft(load_brush("full")), descent, math.radians(tilt))
    assert footprint.reach[-1] == pytest.approx(heel, abs=0.02)
    assert footprint.reach[0] == pytest.approx(tip, abs=0.02)
    assert footprint.width == pytest.approx(width, abs=0.02)
    assert footprint.area == pytest.approx(area, rel=0.01)


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
    """The bent tuft's tip and rings about its stations (K, 3), in the bend plane's frame."""
    spine = np.empty((3, STATIONS))
    trace_spine(tuft, descent, tilt, spine)
    points = [(spine[0, 0], spine[1, 0], 0.0)]
    for j in range(15, STATIONS):
        x, z, middle = spine[:, j]
        c = tuft.diameters[j]
        spread = 1 + tuft.spread * pe if j <= RING_STATIONS[-2] else 1.0
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
    along, up, radius = enclose_tuft(tuft, descent, tilt, pe)
    points = surface_points(tuft, descent, tilt, pe)
    distances = np.linalg.norm(points - (along, up, 0.0), axis=1)
    assert distances.max() <= radius * (1 + 1e-9)
    centre, exact = smallest_ball(points)
    assert centre[2] == pytest.approx(0.0, abs=0.05)
    assert exact <= radius <= exact * 1.02
