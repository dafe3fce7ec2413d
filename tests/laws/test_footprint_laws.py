"""Laws of the footprint: growth with pressure, rotation, sections that keep their area."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import make_footprint, stroke_width
from paint3d.brush.presets import brush_names, load_brush
from paint3d.brush_engine.tuft import STATIONS, greatest_descent, round_diameter, trace_spine

brushes = st.sampled_from(brush_names()).map(lambda name: build_tuft(load_brush(name)))
tilts = st.floats(math.pi / 6, math.pi / 2)
azimuths = st.floats(0.0, 2 * math.pi)


@settings(deadline=None, max_examples=60)
@given(tuft=brushes, tilt=tilts, n=st.integers(5, 300))
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
@given(tuft=brushes, tilt=tilts, share=st.floats(0.1, 1.0), azimuth=azimuths, heading=azimuths)
def test_turning_brush_and_motion_together_changes_no_width(tuft, tilt, share, azimuth, heading):
    descent = share * min(tuft.full_press, greatest_descent(tuft, tilt))
    still = make_footprint(tuft, descent, tilt)
    turned = make_footprint(tuft, descent, tilt, azimuth)
    before = stroke_width(still, (math.cos(heading), math.sin(heading)))
    after = stroke_width(turned, (math.cos(heading + azimuth), math.sin(heading + azimuth)))
    assert math.isclose(before, after, rel_tol=1e-9, abs_tol=1e-9)


@settings(deadline=None, max_examples=40)
@given(tuft=brushes, tilt=tilts, share=st.floats(0.4, 1.0), pe=st.floats(0.0, 1.0))
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
@given(tuft=brushes, tilt=tilts, share=st.floats(0.05, 1.0))
def test_outline_falls_from_the_tip_and_closes(tuft, tilt, share):
    footprint = make_footprint(tuft, share * greatest_descent(tuft, tilt), tilt)
    if footprint.is_empty:
        return
    assert (np.diff(footprint.reach) < 0.0).all()
    assert footprint.half_width[0] == footprint.half_width[-1] == 0.0
    assert (footprint.half_width[1:-1] > 0.0).all()
    assert footprint.reach[0] <= tuft.length
