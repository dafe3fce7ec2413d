"""The dragged tuft against the tractrix in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.brush_engine.tuft import drag_length, drag_step, release
from paint3d.errors import BrushError
from tests.support.tractrix import drag_track, handle_track

slacks = st.floats(0.5, 12.0)


def straight(length, n=400):
    return np.stack([np.linspace(0.0, length, n), np.zeros(n)], axis=1)


@settings(deadline=None, max_examples=30)
@given(slack=slacks, turn=st.floats(0.2, math.pi / 2), travel=st.floats(0.2, 3.0))
def test_lag_after_a_corner_decays(slack, turn, travel):
    # Up to a right angle; beyond it the contact first sticks, as on reversal.
    start = (-slack * math.cos(turn), slack * math.sin(turn))
    handle = straight(travel * slack)
    contact = drag_track(handle, slack, start)
    r = contact[-1] - handle[-1]
    delta = math.atan2(r[1], -r[0])
    expected = 2 * math.atan(math.tan(turn / 2) * math.exp(-travel))
    assert delta == pytest.approx(expected, abs=1e-7)


def test_ten_degrees_are_left_of_a_right_angle_after_two_and_a_half_slacks():
    handle = straight(2.44 * 5.0)
    r = (drag_track(handle, 5.0, (0.0, 5.0)) - handle)[-1]
    assert math.degrees(math.atan2(r[1], -r[0])) == pytest.approx(10.0, abs=0.3)


@settings(deadline=None, max_examples=25)
@given(slack=slacks, ratio=st.floats(1.3, 6.0))
def test_on_a_circle_the_contact_runs_inside_and_lags(slack, ratio):
    radius = ratio * slack
    angles = np.linspace(0.0, 8 * math.pi, 3000)
    handle = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    contact = drag_track(handle, slack, (0.0, -slack))
    inner = math.hypot(*contact[-1])
    assert inner == pytest.approx(math.sqrt(radius**2 - slack**2), rel=0.01)
    cosine = contact[-1] @ handle[-1] / (inner * radius)
    assert math.acos(min(cosine, 1.0)) == pytest.approx(math.asin(slack / radius), rel=0.01)


@settings(deadline=None, max_examples=25)
@given(slack=slacks)
def test_on_reversal_the_contact_sticks_for_two_slacks(slack):
    handle = np.concatenate([straight(3 * slack), straight(3 * slack)[::-1][1:]])
    contact = drag_track(handle, slack, (-slack, 0.0))
    back = contact[400:]
    travelled = 3 * slack - handle[400:, 0]
    assert np.allclose(back[travelled < 2 * slack - 1e-9], contact[399])
    assert back[-1, 0] == pytest.approx(contact[399, 0] - slack, rel=1e-6)


def test_contact_misses_a_right_corner():
    down = np.stack([np.full(600, 20.0), np.linspace(0.0, -40.0, 600)], axis=1)
    handle = np.concatenate([straight(20.0, 600), down[1:]])
    contact = drag_track(handle, 4.0, (-4.0, 0.0))
    missed = np.hypot(*(contact - (20.0, 0.0)).T).min()
    assert missed == pytest.approx(0.665 * 4.0, rel=0.02)


@settings(deadline=None, max_examples=25)
@given(slack=st.floats(1.0, 6.0), bow=st.floats(-8.0, 8.0))
def test_the_inverse_brings_the_contact_onto_the_wanted_track(slack, bow):
    x = np.linspace(0.0, 60.0, 1200)
    wanted = np.stack([x, bow * np.sin(2 * math.pi * x / 60.0)], axis=1)
    handle = handle_track(wanted, slack)
    contact = drag_track(handle, slack, wanted[0] - handle[0])
    assert np.hypot(*(contact - wanted).T).max() < 0.02 * slack


@settings(deadline=None, max_examples=25)
@given(slack=slacks, parts=st.integers(2, 7))
def test_the_law_does_not_depend_on_the_sampling(slack, parts):
    angles = np.linspace(0.0, 3.0, 7)
    coarse = 3 * slack * np.stack([angles, np.sin(angles)], axis=1)
    places = np.linspace(0, 6, 6 * parts + 1)
    fine = np.stack([np.interp(places, np.arange(7), axis) for axis in coarse.T], axis=1)
    start = (0.0, -slack)
    ends = drag_track(coarse, slack, start), drag_track(fine, slack, start)[::parts]
    assert np.abs(ends[0] - ends[1]).max() < 0.03 * slack


vectors = st.tuples(*[st.floats(-9, 9)] * 3)


@settings(deadline=None, max_examples=60)
@given(r=vectors, d=vectors, slack=slacks)
def test_a_step_sticks_or_follows(r, d, slack):
    r = np.array(r) * min(1.0, slack / max(np.linalg.norm(r), 1e-12))
    out, moved = np.array(drag_step(*r, *d, slack)), np.subtract(r, d)
    if np.linalg.norm(moved) < slack * (1.0 - 1e-12):
        assert np.allclose(out, moved, rtol=0.0, atol=1e-12)
    else:
        assert np.linalg.norm(out) == pytest.approx(slack)
        assert np.dot(out, d) <= 1e-9  # it trails
        assert abs(np.linalg.det([out, r, d])) < 1e-9 * (1.0 + np.linalg.norm(d)) * slack**2


@settings(deadline=None, max_examples=60)
@given(r=vectors, d=vectors, slack=slacks, part=st.floats(0.0, 1.0))
def test_a_straight_step_may_be_cut_anywhere(r, d, slack, part):
    d = np.array(d)
    half = drag_step(*r, *(part * d), slack)
    cut = drag_step(*half, *((1.0 - part) * d), slack)
    assert np.allclose(cut, drag_step(*r, *d, slack), rtol=0.0, atol=1e-7)


def test_a_slack_of_nothing_holds_nothing():
    assert np.array_equal(drag_step(1.0, 2.0, 3.0, 0.1, 0.0, 0.0, 0.0), np.zeros(3))
    assert drag_step(1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 5.0) == (1.0, 2.0, 0.0)


def test_lifting_keeps_the_direction():
    assert release(3.0, -4.0, 1.0, 0.5) == (1.5, -2.0, 0.5)


@pytest.mark.parametrize(
    ("fraction", "factor", "power"), [(0.0, 0.61, 0.78), (1 / 3, 0.92, 0.84), (0.5, 1.19, 0.81)]
)
def test_slack_follows_the_measured_powers_and_scales(fraction, factor, power):
    assert drag_length(8.0, 30.0, fraction) == pytest.approx(factor * 8.0**power)
    assert drag_length(16.0, 60.0, fraction) == pytest.approx(2 * factor * 8.0**power)


def test_slack_grows_with_the_fraction():
    values = [drag_length(8.0, 30.0, c) for c in np.linspace(0.0, 0.5, 11)]
    assert (np.diff(values) > 0.0).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: drag_track(np.empty((0, 2)), 1.0), "no samples"),
        (lambda: drag_track([[0, 0], [1, 0]], 0.0), "slack"),
        (lambda: drag_track([[0, 0], [1, 0]], [1.0, -1.0]), r"slack\[1\]"),
        (lambda: drag_track([[0, 0]], 1.0, (2.0, 0.0)), "start"),
        (lambda: handle_track([[0, 0]], 1.0), "1 samples"),
        (lambda: handle_track([[0, 0], [0, 0]], 1.0), "stands still"),
        (lambda: handle_track([[0, 0], [1, 0], [0, 0]], 1.0), "straight back"),
    ],
)
def test_bad_tracks_are_refused(call, message):
    with pytest.raises(BrushError, match=message):
        call()
