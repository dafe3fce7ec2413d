import functools
import math

import numpy as np
import pytest

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import load_brush
from paint3d.calligraphy import lag_compensation, path_fit
from paint3d.calligraphy.footprint_table import FootprintTable, tabulate_footprints
from paint3d.calligraphy.planning import PlanSettings, plan_stroke
from paint3d.errors import InputError
from tests.support.planned_strokes import EM, band, boundary, overlap, signed_distance
from tests.support.tractrix import drag_track

DRAGGED = PlanSettings(azimuth="dragged")


@functools.cache
def footprints():
    return tabulate_footprints(build_tuft(load_brush("xiaobaiyun")), 0.2 * EM)


def hook():
    """A stroke that turns back at an angle of 50 degrees, as (outline, median)."""
    down = np.array([[10.0, 16.0], [10.0, 6.0]])
    back = down[1] + 4.0 * np.array([[-math.sin(0.87), math.cos(0.87)]])
    outline = [[10.7, 16.0], [10.7, 5.2], [9.6, 5.4], back[0].tolist(), [9.3, 8.3], [9.3, 16.0]]
    return np.array(outline), np.concatenate([down, back])


@functools.cache
def course(start):
    return plan_stroke(*band(0.4, 12.0, 1.4, 0.6), EM, footprints(), DRAGGED, start=start)


@pytest.mark.parametrize("start", [None, 0.4, 2.0, -1.5])
def test_law_turns_the_tuft_as_planned(start):
    planned = course(start)
    inner = slice(1, -1)
    slack = footprints().slack_at(planned.level[inner])
    first = planned.azimuth[1] if start is None else start
    bend = slack[0] * np.array([math.cos(first), math.sin(first)])
    contact = drag_track(planned.handle[inner], slack, bend) - planned.handle[inner]
    off = np.arctan2(contact[:, 1], contact[:, 0]) - planned.azimuth[inner]
    assert np.degrees(np.abs(np.arctan2(np.sin(off), np.cos(off)))).max() < 2.0


@pytest.mark.parametrize("start", [None, 0.4, 2.0, -1.5])
def test_outline_is_filled_wherever_the_tuft_pointed_before(start):
    outline, _ = band(0.4, 12.0, 1.4, 0.6)
    assert overlap(course(start), footprints(), outline) > 0.95


def test_tuft_trails_in_the_middle():
    planned = course(None)
    middle = slice(len(planned.level) // 3, 2 * len(planned.level) // 3)
    ahead = np.gradient(planned.centre, axis=0)[middle]
    angle = planned.azimuth[middle] - np.arctan2(ahead[:, 1], ahead[:, 0])
    assert np.cos(angle).max() < -0.95


def test_footprints_stay_in_the_outline():
    outline, _ = band(0.4, 12.0, 1.4, 0.6)
    planned = course(2.0)
    big = np.flatnonzero(planned.level > 1.0)
    allowed = DRAGGED.margin * EM + EM / 512
    for i in big[::7]:
        assert signed_distance(outline, boundary(planned, footprints(), i)).min() > -allowed


def test_brush_rises_towards_its_tip_where_the_stroke_turns_back():
    outline, median = hook()
    planned = plan_stroke(outline, median, EM, footprints(), DRAGGED)
    assert (planned.level[1:-1] >= 0.0).all()
    assert overlap(planned, footprints(), outline) > 0.85
    corner = np.linalg.norm(planned.centre - [10.0, 6.0], axis=1) < 1.2
    assert planned.level[corner].min() < 0.5 * planned.level.max()
    turned = np.abs(np.diff(planned.azimuth))
    assert planned.level[1:][turned > 0.5].max(initial=0.0) < 0.5 * planned.level.max()
    assert np.abs(np.diff(planned.level[1:-1])).max() < 1.5  # and gently


def test_a_tuft_too_blunt_to_turn_under_way_turns_over_on_its_tip():
    # Its lightest footprint has slack enough that landing and turning back take some way.
    blunt = FootprintTable(**{name: values[6:] for name, values in vars(footprints()).items()})
    outline, median = hook()
    planned = plan_stroke(outline, median, EM, blunt, DRAGGED)
    corner = np.linalg.norm(planned.centre - [10.0, 6.0], axis=1) < 1.2
    assert planned.level[corner].min() < 0.01 * planned.level.max()
    turned = np.abs(np.diff(planned.azimuth))
    assert planned.level[1:][turned > 0.3].max() < 0.01 * planned.level.max()
    way = np.cumsum(np.linalg.norm(np.diff(planned.handle[1:-1], axis=0), axis=1))
    landing = planned.level[2:-1][way < 5.0 * blunt.slack[0]]
    assert len(landing) > 10
    assert landing.max() < 0.05 * planned.level.max()


def off_what_fits(monkeypatch, shape) -> list[float]:
    """By how many levels each course of a stroke misses what fits where it lies, in the mean."""
    leads, missed = [], []
    laws = vars(lag_compensation)
    monkeypatch.setattr(path_fit, "pull", lambda lead: leads.append(lead) or laws["pull"](lead))
    plan_stroke(*shape, EM, footprints(), DRAGGED)
    for lead in leads:
        light = laws["_light_poses"](lead.wanted, float(lead.footprints.slack[0]))
        course = laws["pull"](lead)
        off = course.level - laws["_fitting"](course, light, lead)
        missed.append(float(np.sqrt((off**2).mean())))
    return missed


def test_levels_come_to_fit_in_few_rounds_and_do_not_swing(monkeypatch):
    """A round that followed by less would still be short, one by more overshoots at a turn."""
    assert max(off_what_fits(monkeypatch, band(0.4, 12.0, 1.4, 0.6))) < 0.02
    assert np.mean(off_what_fits(monkeypatch, hook())) < 0.45


def test_only_trailing_can_be_asked_of_a_dragged_tuft():
    assert PlanSettings(azimuth="dragged", technique="zhongfeng").azimuth == "dragged"
    with pytest.raises(InputError, match="'pianfeng' with a dragged tuft"):
        PlanSettings(azimuth="dragged", technique="pianfeng")
    with pytest.raises(InputError, match="azimuth is 'pushed'"):
        PlanSettings(azimuth="pushed")
