"""Laws of the continuous tuft: its footprint is a smooth function of how it is pressed."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import make_footprint, stroke_width
from paint3d.brush.presets import brush_names, load_brush
from paint3d.brush.spec import BrushSpec
from paint3d.brush_engine.tuft import STATIONS, greatest_descent, round_diameter, trace_spine
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.outlines import UPRIGHT, lift_off, outline_of, sizes_of
from tests.support.surface_cases import flat, sheet

FULL = load_brush("full")


@st.composite
def drawn(draw) -> BrushSpec:
    """A brush anywhere in the ranges, as long as the papers' one."""
    return dataclasses.replace(
        FULL,
        spread_by_pressure=draw(st.floats(1.3, 1.8)),
        root_diameter_mm=draw(st.floats(3.0, 14.7)),
        taper=draw(st.floats(0.4, 1.2)),
        stiffness_exponent=draw(st.sampled_from((2.5, 3.5, 4.5))),
        full_press_mm=draw(st.floats(10.5, 21.0)),
        point_mm=draw(st.floats(0.3, 5.0)),
    )


presets = st.sampled_from(brush_names()).map(load_brush)
brushes = st.one_of(presets, drawn())


@settings(deadline=None, max_examples=25)
@given(spec=brushes, tilt=st.floats(math.radians(45.0), UPRIGHT), start=st.floats(0.0, 1.0))
def test_it_grows_without_steps(spec, tilt, start):
    """Law 1, scaled to a tuft of 35 mm: nowhere does the growth of the area change by a step."""
    tuft, scale = build_tuft(spec), spec.length_mm / 35.0
    deepest = min(0.6 * tuft.full_press, greatest_descent(tuft, tilt)) / scale
    first = 0.05 + start * max(0.0, deepest - 2.05)
    descents = np.arange(first, min(first + 2.0, deepest), 0.01)
    areas = sizes_of(tuft, descents * scale, tilt)[:, 0] / scale**2
    assert np.abs(np.diff(areas, n=2)).max() <= 0.004


@pytest.mark.parametrize("name", brush_names())
def test_it_grows_without_steps_to_the_end_of_its_table(name):
    """Law 1, lying low, where less than the full press is the deepest."""
    tuft = build_tuft(load_brush(name))
    scale, deepest = tuft.length / 35.0, greatest_descent(tuft, 1.0)
    descents = deepest + scale * np.arange(-0.6, 0.0, 0.005)
    areas = sizes_of(tuft, descents, 1.0)[:, 0] / scale**2
    assert np.abs(np.diff(areas, n=2)).max() <= 0.001


@pytest.mark.parametrize("name", brush_names())
@pytest.mark.parametrize("tilt", [1.0, UPRIGHT])
def test_the_lightest_touch_leaves_a_mark_that_grows(name, tilt):
    tuft = build_tuft(load_brush(name))
    sizes = sizes_of(tuft, np.geomspace(2e-3, 0.2, 60) * tuft.length / 35.0, tilt)
    assert (sizes[0] > 0.0).all()
    assert (np.diff(sizes, axis=0) > 0.0).all()


@settings(deadline=None, max_examples=25)
@given(spec=brushes, share=st.floats(0.02, 0.95))
def test_it_grows_with_the_press(spec, share):
    """Law 2."""
    tuft = build_tuft(spec)
    descent = share * tuft.full_press
    steps = np.array([0.0, 0.01, 0.02, 0.03]) * tuft.full_press
    assert (np.diff(sizes_of(tuft, descent + steps), axis=0) > 0.0).all()


@settings(deadline=None, max_examples=25)
@given(spec=presets, share=st.floats(0.03, 0.95))  # lower a blunt point is flattened as fast
def test_it_grows_with_the_spread(spec, share):
    """Law 2; a brush as slim as no preset would be flatter and shorter by more than it is wider."""
    tuft = build_tuft(spec)
    descent = share * tuft.full_press
    areas = [np.trapezoid(*outline_of(tuft, descent, pe=pe)) for pe in (0.0, 0.2, 0.5, 1.0)]
    assert (np.diff(areas) > 0.0).all()


@pytest.mark.parametrize("name", brush_names())
def test_its_width_has_one_slope(name):
    """Law 3: between half and twice the mean from a tenth of the full press to six tenths."""
    tuft = build_tuft(load_brush(name))
    widths = sizes_of(tuft, np.linspace(0.1, 0.6, 400) * tuft.full_press)[:, 1]
    slopes = np.diff(widths)
    assert slopes.min() > 0.5 * slopes.mean()
    assert slopes.max() < 2.0 * slopes.mean()


@settings(deadline=None, max_examples=25)
@given(spec=drawn(), share=st.floats(0.01, 1.0), factor=st.floats(0.3, 3.0))
def test_twice_the_brush_twice_the_press_twice_the_outline(spec, share, factor):
    """Law 4."""
    lengths = ("length_mm", "root_diameter_mm", "tip_segment_mm", "point_mm", "full_press_mm")
    scaled = dataclasses.replace(spec, **{name: factor * getattr(spec, name) for name in lengths})
    small, large = build_tuft(spec), build_tuft(scaled)
    one = outline_of(small, share * small.full_press, 1.3)
    other = outline_of(large, share * large.full_press, 1.3)
    assert np.allclose(np.array(one) * factor, other, atol=1e-9 * spec.length_mm * factor)


@pytest.mark.parametrize("name", brush_names())
def test_a_lift_off_narrows_without_beads(name):
    """Law 6: one flank, ever narrower, to a point as fine as the tuft's."""
    spec = load_brush(name)
    is_pointed = spec.point_mm >= spec.tip_segment_mm
    scale = max(1.0, spec.length_mm / 52.0)
    places, half = lift_off(build_tuft(spec), length_mm=20.0 * scale)
    if not is_pointed:  # a blunt tip ends round
        there = places < places[half > 0.0].max() - 0.5 * scale
        places, half = places[there], half[there]
    flank = half < 0.95 * half.max()  # beyond its shoulder
    assert np.diff(half[flank & (half > 0.05)]).max() <= 1e-6
    slope = -np.gradient(gaussian_filter1d(half, 5.0 * scale, mode="nearest"), places)[:-20]
    flank, thick = flank[:-20], half[:-20]
    beads, _ = find_peaks(slope[flank & (thick > 0.05)], prominence=0.03)
    assert len(beads) == 0
    steep = slope[thick > 0.1]
    bend = np.abs(np.gradient(steep, places[1] - places[0])) / (1.0 + steep**2) ** 1.5
    assert bend.max() < 1.0
    last = places[half > 0.0].max()
    if is_pointed:
        assert half[np.searchsorted(places, last - 0.1)] < 0.075


# -- the footprint -----------------------------------------------------------------------------


preset_tufts = st.sampled_from(brush_names()).map(lambda name: build_tuft(load_brush(name)))
tilts = st.floats(math.pi / 6, math.pi / 2)
azimuths = st.floats(0.0, 2 * math.pi)


@settings(deadline=None, max_examples=60)
@given(tuft=preset_tufts, tilt=tilts, n=st.integers(5, 300))
def test_length_width_and_area_grow_strictly_with_pressure(tuft, tilt, n):
    deepest = min(tuft.full_press, greatest_descent(tuft, tilt))
    descents = np.linspace(0.0, deepest, n)
    prints = [make_footprint(tuft, descent, tilt) for descent in descents]
    sizes = np.array([(p.length, p.width, p.area) for p in prints])
    touching = np.array([not p.is_empty for p in prints])
    assert touching[-1]
    assert (np.diff(touching.astype(int)) >= 0).all()
    assert (np.diff(sizes[touching], axis=0) > 0.0).all()


@settings(deadline=None, max_examples=40)
@given(tuft=preset_tufts, tilt=tilts, share=st.floats(0.1, 1.0), azimuth=azimuths, heading=azimuths)
def test_turning_brush_and_motion_together_changes_no_width(tuft, tilt, share, azimuth, heading):
    descent = share * min(tuft.full_press, greatest_descent(tuft, tilt))
    still = make_footprint(tuft, descent, tilt)
    turned = make_footprint(tuft, descent, tilt, azimuth)
    before = stroke_width(still, (math.cos(heading), math.sin(heading)))
    after = stroke_width(turned, (math.cos(heading + azimuth), math.sin(heading + azimuth)))
    assert math.isclose(before, after, rel_tol=1e-9, abs_tol=1e-9)


@settings(deadline=None, max_examples=40)
@given(tuft=preset_tufts, tilt=tilts, share=st.floats(0.4, 1.0), pe=st.floats(0.0, 1.0))
def test_flat_sections_are_as_wide_as_the_spread(tuft, tilt, share, pe):
    # Where the spine lies flat (z = 0) the paper cuts a section along its major axis, C_j1 (Eq. 2).
    descent = share * greatest_descent(tuft, tilt)
    spine = np.empty((3, STATIONS))
    trace_spine(tuft, descent, tilt, spine)
    lying = tuft.arcs[spine[1] < 1e-6 * tuft.length].max()
    assert lying > 0.0
    footprint = make_footprint(tuft, descent, tilt, pe=pe)
    arcs = footprint.reach[0] - footprint.reach
    flat = (arcs > 0.02 * lying) & (arcs < 0.7 * lying)
    assert flat.any()
    widths = [(1 + tuft.spread * pe) * round_diameter(tuft, arc) for arc in arcs[flat]]
    assert np.allclose(2 * footprint.half_width[flat], widths, rtol=5e-3)


@settings(deadline=None, max_examples=40)
@given(tuft=preset_tufts, tilt=tilts, share=st.floats(0.05, 1.0))
def test_outline_falls_from_the_tip_and_closes(tuft, tilt, share):
    footprint = make_footprint(tuft, share * greatest_descent(tuft, tilt), tilt)
    if footprint.is_empty:
        return
    assert (np.diff(footprint.reach) < 0.0).all()
    assert footprint.half_width[0] == footprint.half_width[-1] == 0.0
    assert (footprint.half_width[1:-1] > 0.0).all()
    assert footprint.reach[0] <= tuft.length


@settings(deadline=None, max_examples=40)
@given(tuft=preset_tufts, tilt=tilts, share=st.floats(0.05, 1.0))
def test_the_meniscus_rounds_the_tip_and_nothing_else(tuft, tilt, share):
    """As long, as wide, nowhere narrower, and at the tip a circle and no wedge."""
    plain = make_footprint(tuft, share * greatest_descent(tuft, tilt), tilt)
    if plain.is_empty:
        return
    painted = plain.rounded()
    assert (painted.length, painted.width) == (plain.length, plain.width)
    at = np.linspace(plain.reach[-1], plain.reach[0], 300)
    was, now = (np.interp(at, p.reach[::-1], p.half_width[::-1]) for p in (plain, painted))
    assert (now >= was - 0.01 * plain.width).all()
    assert plain.area < painted.area < 1.25 * plain.area  # most of it where the tip is slender
    radius = 0.2 * plain.width
    near = np.interp(plain.reach[0] - 0.3 * radius, painted.reach[::-1], painted.half_width[::-1])
    assert near > 0.6 * radius  # of the circle .71


# -- edges -------------------------------------------------------------------------------------


def unevenness(aside: float, pressure: float, step_mm: float, hairs: int | None) -> float:
    """How much the ink of a row of vertices varies along a stroke, over its mean: the worst row.

    Rows that the outline hardly reaches do not count. The tuft lies `aside` (rad) of where it would
    trail; edges lie along the rows.
    """
    n = 1 + round(40.0 / step_mm)
    x, half = np.linspace(-20.0, 20.0, n), 0.5 * (math.pi + aside)
    position = np.stack([x, 0.0 * x, np.full(n, 30.0)], axis=1)
    turned = np.tile([math.cos(half), 0.0, 0.0, math.sin(half)], (n, 1))
    surface = PaintedSurface(sheet(flat, (30.0, 30.0), 4.0), 0.25, "porcelain")
    recording = Recording(np.arange(n) * 8_000_000, position, turned, np.full(n, pressure))
    Painter(surface, "slender", hairs=hairs).replay(recording)
    vertices, ink = np.asarray(surface.mesh.vertices, float), surface.amounts.sum(axis=1)
    far = abs(vertices[:, 0]) < 2.5  # from where the stroke begins and ends
    rows, row = np.unique(np.round(vertices[far, 1], 3), return_inverse=True)
    worst = 0.0
    for i in range(len(rows)):
        here, there = ink[far][row == i], vertices[far, 0][row == i]
        if here.mean() > 0.2 and surface.coverage[far][row == i].mean() > 0.15:
            trend = np.polyval(np.polyfit(there, here, 1), there)  # it runs out of ink
            worst = max(worst, float((here - trend).std() / here.mean()))
    assert worst > 0.0
    return worst


@pytest.mark.parametrize("hairs", [None, 300])
@settings(deadline=None, max_examples=25)
@given(
    aside=st.floats(0.6, 2.0),
    left=st.booleans(),
    pressure=st.floats(0.15, 0.55),
    step_mm=st.sampled_from([0.17, 1.0 / 3.0, 0.7]),
)
def test_a_tuft_that_goes_sideways_draws_edges_without_teeth(hairs, aside, left, pressure, step_mm):
    assert unevenness(-aside if left else aside, pressure, step_mm, hairs) < (
        0.2 if hairs is None else 0.6
    )  # single hairs show
