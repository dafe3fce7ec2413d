"""Motions of a hand on objects, the ways between them, and how they vary."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import load_brush
from paint3d.calligraphy.hand_motion import join_motions, move_between, to_hand_motion
from paint3d.calligraphy.timing import Motion, Tempo
from paint3d.core.quaternion import rotate
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import frame_at, make_chart

EM = 20.0


@functools.cache
def sphere():
    return ClosestPoints(load_mesh("sphere"))


@functools.cache
def tuft():
    return build_tuft(load_brush("xiaobaiyun"))


def motion(n=200):
    """A curl over the em square, that comes down and goes up again."""
    t = np.linspace(0.0, 1.0, n)
    handle = EM * np.column_stack([0.2 + 0.6 * t, 0.5 + 0.3 * np.sin(5 * t)])
    height = 20.0 - 22.0 * np.sin(np.pi * t)
    zero = np.zeros(n, np.int32)
    none = zero.astype(np.int64)
    return Motion(t, handle, 3.0 * t, height, zero, none, none)


def laid(point):
    frame = frame_at(sphere(), point, (0.0, 0.0, 1.0))
    chart = make_chart(sphere(), frame, 11.0, 11.0)
    return to_hand_motion(motion(), chart, EM, tuft()), chart


def test_the_holder_stands_on_the_wall_over_its_foot():
    hand, chart = laid((0, -75, 0))
    plan = motion()
    up = rotate(hand.orientation, np.array([0.0, 0.0, 1.0]))
    feet = hand.position - (tuft().length + plan.height)[:, None] * up
    assert np.linalg.norm(feet, axis=1) == pytest.approx(75.0, abs=0.05)
    assert np.einsum("ij,ij->i", up, feet) / 75.0 == pytest.approx(1.0, abs=1e-3)
    assert feet == pytest.approx(chart.points(plan.handle - 0.5 * EM), abs=1e-9)
    assert hand.pressure == pytest.approx(np.maximum(0.0, -plan.height) / tuft().full_press)


def test_the_bend_keeps_its_azimuth():
    hand, chart = laid((0, -75, 0))
    plan = motion()
    bend = rotate(hand.orientation, np.array([1.0, 0.0, 0.0]))
    frames = chart.tangents(plan.handle - 0.5 * EM)
    x, y = (np.einsum("ij,ij->i", bend, frames[:, :, k]) for k in (0, 1))
    assert np.unwrap(np.arctan2(y, x)) == pytest.approx(plan.azimuth, abs=1e-9)


@pytest.mark.parametrize("goal", [(75, 0, 0), (0, 75, 0), (10, -74, 5)])
def test_ways_keep_clear_of_the_object_and_within_limits(goal):
    (one, _), (two, _) = laid((0, -75, 0)), laid(goal)
    tempo = Tempo()
    way = move_between(one, two, sphere(), tuft(), tempo)
    up = rotate(way.orientation, np.array([0.0, 0.0, 1.0]))
    for share in (0.0, 0.5, 1.0):
        along = way.position - share * tuft().length * up
        assert np.linalg.norm(along, axis=1).min() > 75.0 + 5.0
    whole = join_motions([one, way, two]).position[len(one.position) - 1 :][: len(way.position) + 2]
    speed = np.linalg.norm(np.diff(whole, axis=0), axis=1) * tempo.rate_hz
    assert speed.max() <= tempo.most_speed
    assert speed[[0, -1]].max() < 0.05 * tempo.most_speed
    jerk = np.linalg.norm(np.diff(whole, 3, axis=0), axis=1) * tempo.rate_hz**3
    assert jerk.max() <= 1.05 * tempo.most_jerk
    assert (way.pressure == 0.0).all()
