"""The dragged tuft against the tractrix in closed form."""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import make_footprint
from paint3d.brush.presets import load_brush
from paint3d.brush_engine.drag import (
    drag_along,
    drag_length,
    drag_step,
    hold_along,
    lie_held,
    release,
    trail_step,
)
from paint3d.brush_engine.footprint import make_stamp
from paint3d.brush_engine.placement import place_stamp
from paint3d.brush_engine.scratch import Scratch, make_scratch
from paint3d.calligraphy.centre_line import centre_line, outline_field
from paint3d.calligraphy.footprint_table import FootprintTable, tabulate_footprints
from paint3d.calligraphy.path_fit import PathFitter, PlanSettings
from paint3d.calligraphy.planning import plan_stroke
from paint3d.errors import BrushError
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.planned_strokes import band, overlap
from tests.support.resampling import resample
from tests.support.surface_cases import flat, poses, sheet
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


vectors = st.tuples(*[st.floats(-9, 9).map(lambda x: round(x, 9))] * 3)


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


# -- a tip that the paper holds ----------------------------------------------------------------


LAW = settings(deadline=None, max_examples=30)
lengths, places, shares = st.floats(0.5, 12.0), st.floats(-15.0, 15.0), st.floats(0.0, 1.0)
UPRIGHT = 35.0  # mm, the height of the root of "full"


def polar(distance: float, angle: float) -> tuple[float, float]:
    """A place so far away in a direction."""
    return distance * math.cos(angle), distance * math.sin(angle)


@LAW
@given(
    at=st.tuples(places, places),
    aside=st.floats(-math.pi, math.pi),
    short=st.floats(0.0, 1.0),
    length=lengths,
    way=st.floats(0.0, 5.0),
    pressed=st.floats(-3.0, 3.0),
    bent=shares,
)
def test_a_tip_lies_within_the_footprint(at, aside, short, length, way, pressed, bent):
    turned, left = trail_step(*at, aside, short * length, length, way, pressed, bent)
    assert -math.pi <= turned <= math.pi
    assert 0.0 <= left <= length


@LAW
@given(
    share=st.floats(0.01, 1.0),
    angle=st.floats(-3.0, 3.0),
    aside=st.floats(-1.0, 1.0),
    length=lengths,
    pressed=st.floats(0.01, 3.0),
    slow=st.floats(0.0, 1.0),
)
def test_a_press_holds_a_tip_that_is_not_pulled(share, angle, aside, length, pressed, slow):
    at = polar(share * length, angle)
    turned, left = trail_step(*at, aside, 0.0, length, 3.0 * slow * pressed, pressed, 1.0)
    assert polar(length - left, turned) == pytest.approx(at, abs=1e-9)


@LAW
@given(aside=st.floats(-3.0, 3.0), length=lengths, pressed=st.floats(0.01, 3.0))
def test_a_press_holds_a_tip_right_under_its_heel(aside, length, pressed):
    """It sprang to the whole length's end, while one a hair's breadth beside it was held."""
    for off in (0.0, 1e-7):
        turned, left = trail_step(off, 0.0, aside, 0.0, length, 0.0, pressed, 1.0)
        assert left == pytest.approx(length - off, abs=1e-12)
        assert turned == pytest.approx(0.0 if off else aside, abs=1e-12)


@LAW
@given(
    at=st.tuples(places, places),
    length=lengths,
    way=st.floats(0.0, 5.0),
    lifted=st.floats(0.0, 2.0),
)
def test_where_nothing_is_pressed_nothing_is_held(at, length, way, lifted):
    assert trail_step(*at, 0.0, 0.0, length, way, -lifted, 1.0) == (0.0, 0.0)


@LAW
@given(
    at=st.tuples(places, places),
    aside=st.floats(-3.0, 3.0),
    short=shares,
    length=lengths,
    way=st.floats(0.0, 5.0),
    pressed=st.floats(0.0, 3.0),
)
def test_the_edge_of_a_heap_is_not_held(at, aside, short, length, way, pressed):
    turned, left = trail_step(*at, aside, short * length, length, way, pressed, 0.0)
    assert turned == pytest.approx(aside * math.exp(-2.0 * way / length), abs=1e-12)
    assert left == max(0.0, short * length - way)


@LAW
@given(
    angle=st.floats(-3.0, 3.0),
    slack=st.floats(0.3, 0.9),
    length=lengths,
    lifted=st.floats(0.0, 0.5),
)
def test_a_slack_tip_stays_until_it_is_pulled_taut(angle, slack, length, lifted):
    """It swung aside and back over the mark as soon as nothing was pressed any more."""
    way = 0.01 * length
    at = polar((1.0 - slack) * length + way, angle)
    turned, left = trail_step(*at, 0.0, slack * length, length, way, -lifted, 1.0)
    assert polar(length - left, turned) == pytest.approx(at)


@LAW
@given(
    aside=st.floats(-3.0, 3.0),
    slack=st.floats(0.05, 0.9),
    length=lengths,
    share=st.floats(0.01, 0.3),
)
def test_a_slack_tip_that_its_heel_comes_back_to_springs_into_its_bend(aside, slack, length, share):
    """Held, it was left behind in each corner that a brush goes into and comes back from."""
    way = share * (1.0 - slack) * length
    at = polar((1.0 - slack) * length - way, aside)
    turned, left = trail_step(*at, aside, slack * length, length, way, -0.1, 1.0)
    assert turned == pytest.approx(aside * math.exp(-2.0 * way / length), abs=1e-9)
    assert left == max(0.0, slack * length - way)


@LAW
@given(aside=st.floats(-3.0, 3.0), short=st.floats(0.0, 1.0), length=lengths)
def test_a_sliding_tip_comes_back_into_its_bend(aside, short, length):
    turned, left = trail_step(3.0, 4.0, aside, short * length, length, 3.0 * length, 0.0, 1.0)
    assert turned == pytest.approx(aside * math.exp(-6.0))
    assert left == 0.0


@LAW
@given(bend=st.floats(-2.0, 2.0), deep=st.floats(0.5, 6.0), parts=st.integers(2, 5))
def test_how_often_a_tip_is_asked_for_does_not_matter(bend, deep, parts):
    def led(n):
        """Where the tip lies behind a heel that goes on a bow while the footprint grows."""
        tip, heel = np.array([-1.0, 0.0]), np.zeros(2)
        aside, short, step = 0.0, 0.0, 8.0 / n
        for k in range(n):
            turned, grown = bend * (k + 0.5) / n, 1.0 + deep * (k + 1) / n
            back = -np.array([math.cos(turned), math.sin(turned)])
            beside = np.array([-back[1], back[0]])
            heel = heel - step * back
            at = (tip - heel) @ back, (tip - heel) @ beside
            aside, short = trail_step(*at, aside, short, grown, step, deep / n, 1.0)
            lies = math.cos(aside) * back + math.sin(aside) * beside
            tip = heel + (grown - short) * lies
        return tip

    assert np.abs(led(100) - led(100 * parts)).max() < 0.04


@given(aside=st.floats(-3.1, 3.1), short=st.floats(0.0, 1.0), length=lengths, bent=shares)
def test_a_tip_under_its_heel_or_in_a_heap_tells_nothing(aside, short, length, bent):
    assert lie_held(aside, length, length, bent) == (1.0, 0.0, 0.0)
    assert lie_held(aside, short * length, length, 0.0) == (1.0, 0.0, 0.0)
    near = 0.5 * short * length
    laid = lie_held(aside, near, length, 1.0)
    assert laid == pytest.approx((math.cos(aside), math.sin(aside), near))


class Drawn(NamedTuple):
    """Tips and heels (N, 2) of footprints, mm, and how far the tuft lay in its bend."""

    tips: NDArray
    heels: NDArray
    bent: NDArray


@cache
def brush_on_paper() -> tuple[Painter, Scratch]:
    """A dragged brush over a sheet of what `TUFT` is rated on."""
    surface = PaintedSurface(sheet(flat, (60.0, 40.0), 4.0), 2.0, "xuan")
    return Painter(surface, "full", azimuth="dragged"), make_scratch(surface.paint_mesh, 0)


def drawn(way: NDArray, pressure: NDArray) -> Drawn:
    """The footprints of an upright dragged brush along points (N, 2), mm."""
    painter, scratch = brush_on_paper()
    surface, stamp, scratch.warm[0] = painter.surface, make_stamp(), 0.0
    rows = []
    for (x, y), press in zip(way, pressure, strict=True):
        pose = np.array([x, y, UPRIGHT, 1.0, 0.0, 0.0, 0.0, press, 0.0])
        place_stamp(
            pose, True, stamp, stamp, painter.tuft, surface.contact_tree, surface.paint_mesh.arrays,
            scratch,
        )  # fmt: skip
        v = stamp.values[0]
        ends = [v["origin"][:2] + v[end] * v["bend"][:2] for end in ("tip", "heel")]
        rows.append((*ends, v["bent"]))
    tips, heels, bent = zip(*rows, strict=True)
    return Drawn(np.array(tips), np.array(heels), np.array(bent))


STEP = 0.1  # mm
TUFT = build_tuft(load_brush("full"))


def pressed_again(turn: float, deep: float, over: float) -> tuple[NDArray, NDArray]:
    """A way (N, 2) that goes straight, then turns (rad) over so many mm, and the pressures."""
    share = np.clip(np.arange(-12.0, over, STEP) / over, 0.0, 1.0)
    steps = STEP * np.column_stack([np.cos(turn * share), np.sin(turn * share)])
    return np.cumsum(steps, axis=0), 0.05 + (deep - 0.05) * share**2 * (3.0 - 2.0 * share)


@settings(deadline=None, max_examples=25)
@given(turn=st.floats(-1.2, 1.2), deep=st.floats(0.3, 0.5), over=st.floats(8.0, 16.0))
def test_a_brush_pressed_again_does_not_push_its_tip_back_or_aside(turn, deep, over):
    """It grew back over what it had drawn, and swept aside: docs/model.md, section 2."""
    way, press = pressed_again(turn, deep, over)
    found = drawn(way, press)
    held = 3.0 * np.diff(press) * TUFT.full_press > STEP
    moved, towards = np.diff(found.tips, axis=0)[held], (found.heels - found.tips)[1:][held]
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    ahead = (moved * towards).sum(axis=1)
    assert held.sum() > 40
    assert ahead.min() > -1e-3 * STEP
    assert np.linalg.norm(moved - ahead[:, None] * towards, axis=1).sum() < 0.05


@pytest.mark.parametrize(("rate", "most"), [(60.0, 0.02), (125.0, 0.01), (1000.0, 0.002)])
def test_a_press_draws_the_same_however_often_the_hand_is_read(rate, most):
    """The share of what is painted that differs from what a hand read 500 times a second paints."""
    usual, other = painted_again(500.0), painted_again(rate)
    assert (usual ^ other).sum() <= max(1, most * (usual | other).sum())


@cache
def painted_again(rate: float) -> NDArray[np.bool_]:
    """What is covered (V,) by a brush that goes 60 mm/s, turns and is pressed again."""
    way, press = pressed_again(1.2, 0.4, 12.0)
    points = np.column_stack([way - way.mean(axis=0), np.zeros(len(way))])
    read = poses(points, (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), press, rate=60.0 / STEP)
    surface = PaintedSurface(sheet(flat, (25.0, 15.0), 0.4), None, "porcelain")
    Painter(surface, "full", azimuth="dragged").replay(resample(read, rate))
    return surface.coverage > 0.5


@settings(deadline=None, max_examples=25)
@given(deep=st.floats(0.1, 0.6), lift=st.floats(4.0, 14.0))
def test_on_a_straight_way_a_brush_lies_and_lifts_as_far_as_it_reaches(deep, lift):
    x = np.arange(-20.0, 14.0, STEP)
    press = deep * np.clip((14.0 - x) / lift, 0.0, 1.0)
    found = drawn(np.column_stack([x, 0.0 * x]), press)
    for k in np.flatnonzero((x > 10.0) & (press > 0.0))[::8]:
        free = make_footprint(TUFT, press[k] * TUFT.full_press, 0.5 * math.pi, pe=press[k])
        assert found.tips[k] == pytest.approx([x[k] - free.reach[0], 0.0], abs=1e-3)


@settings(deadline=None, max_examples=25)
@given(deep=st.floats(0.4, 0.6), over=st.floats(0.5, 2.0))
def test_a_brush_pressed_before_it_lies_in_its_bend_grows_as_from_the_spot(deep, over):
    x = np.arange(0.0, 14.0, STEP)
    way = np.column_stack([x, 0.0 * x])
    first, other = (drawn(way, deep * np.clip(x / mm, 0.01, 1.0)) for mm in (0.1, over))
    assert other.tips[:, 0].min() == pytest.approx(first.tips[:, 0].min(), abs=0.1)


@settings(deadline=None, max_examples=25)
@given(deep=st.floats(0.1, 0.8))
def test_a_press_on_the_spot_lies_around_its_root(deep):
    found = drawn(np.zeros((200, 2)), np.linspace(0.001, deep, 200))
    assert found.bent[-1] < 0.02
    middle = 0.5 * (found.tips[-1] + found.heels[-1])
    assert np.hypot(*middle) < 0.02 * np.hypot(*(found.tips[-1] - found.heels[-1]))


@settings(deadline=None, max_examples=25)
@given(turn=st.floats(-1.2, 1.2), deep=st.floats(0.2, 0.5), over=st.floats(8.0, 16.0))
def test_the_planner_knows_where_the_tips_lie(turn, deep, over):
    way, press = pressed_again(turn, deep, over)
    descent = press * TUFT.full_press
    free = [
        make_footprint(TUFT, d, 0.5 * math.pi, pe=p) for d, p in zip(descent, press, strict=True)
    ]
    heel, tip = (np.array([f.reach[k] for f in free]) for k in (-1, 0))
    slack = np.array([drag_length(d, TUFT.length, TUFT.drag_fraction) for d in descent])
    pulled, held = np.empty_like(way), np.empty_like(way)
    drag_along(way, slack, -slack[0], 0.0, pulled)
    azimuth = np.arctan2(*(pulled - way).T[::-1])
    hold_along(way, azimuth, descent, heel, tip - heel, held)
    lies, length = azimuth + held[:, 0], tip - heel - held[:, 1]
    tips = way + heel[:, None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    tips += length[:, None] * np.stack([np.cos(lies), np.sin(lies)], axis=1)
    landed = slice(40, None)
    assert np.abs(tips - drawn(way, press).tips)[landed].max() < 0.1


@cache
def footprints() -> FootprintTable:
    """Of the brush, to 20 mm."""
    return tabulate_footprints(TUFT, 20.0)


@pytest.mark.long
@settings(deadline=None, max_examples=25)
@given(bend=st.floats(0.5, 1.4), side=st.sampled_from((-1.0, 1.0)))
def test_planned_footprints_lie_as_the_laws_lay_them(bend, side):
    """Where the paper holds their tips aside and short, too."""
    table, dragged = footprints(), PlanSettings(azimuth="dragged")
    planned = plan_stroke(*band(0.0, 40.0, 9.0, side * bend), 100.0, table, dragged)
    handle, descent = planned.handle[1:-1], planned.descent[1:-1]
    found = drawn(handle - handle.mean(axis=0), descent / TUFT.full_press)
    lies = (found.tips - found.heels)[descent > 1.0]
    inner = np.flatnonzero(planned.descent > 1.0)
    turned = np.arctan2(lies[:, 1], lies[:, 0]) - planned.azimuth[inner]
    length = planned.share[inner] * table.length_at(planned.level[inner])
    assert planned.share[inner].min() < 0.99  # some are held
    assert np.abs(np.sin(turned)).max() < 0.005
    assert np.linalg.norm(lies, axis=1) == pytest.approx(length, abs=0.02)


@cache
def led_dragged(bend: float) -> tuple[float, float]:
    """What a dragged brush covers of a bent band as it is led first, and in the end (IoU)."""
    outline, median = band(0.0, 40.0, 12.0, bend)
    dragged, em = PlanSettings(azimuth="dragged"), 100.0
    field = outline_field(outline, em / 512)
    plan = PathFitter(field, footprints(), dragged, em, None)
    first = plan.follow(centre_line(median, field, dragged.sample_step * em))
    paths = first.path, plan.refine_dragged(first).path
    first_share, last = (overlap(path, footprints(), outline, 0.1) for path in paths)
    return first_share, last


@pytest.mark.parametrize("bend", [1.1, -1.4])
def test_the_handle_makes_up_for_tips_that_are_held_aside(bend):
    """Of bands bent by 1.1 and 1.4 rad .940 and .931 were covered without that."""
    first, _ = led_dragged(bend)
    assert first > 0.94


@pytest.mark.parametrize("bend", [1.1, -1.4])
def test_a_dragged_brush_is_led_on_while_that_betters_its_course(bend):
    first, last = led_dragged(bend)
    assert last > first + 0.004
