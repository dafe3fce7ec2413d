"""Two hands to one pose, and what is between two samples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from paint3d.brush.fitting import press_errors, read_presses
from paint3d.brush.presets import load_brush
from paint3d.core.quaternion import multiply_quaternions, rotate
from paint3d.errors import RecordingError
from paint3d.pose.brush_pose import BrushPath, brush_poses, joined_samples, object_poses, velocities
from paint3d.recording.recording import Recording
from tests.support.resampling import densify, evaluate, resample


def unit(rng, n):
    q = rng.normal(size=(n, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def both_hands(n=20, seed=0):
    rng = np.random.default_rng(seed)
    return Recording(
        np.arange(n) * 10_000_000,
        rng.normal(size=(n, 3)),
        unit(rng, n),
        rng.random(n),
        None,
        rng.normal(size=(n, 3)),
        unit(rng, n),
    )


def moved(recording, q, p):
    """The same two hands in another world."""
    return Recording(
        recording.time_ns,
        rotate(q, recording.position) + p,
        multiply_quaternions(q, recording.orientation),
        recording.pressure,
        recording.buttons,
        rotate(q, recording.object_position) + p,
        multiply_quaternions(q, recording.object_orientation),
    )


def test_a_resting_object_leaves_the_brush_where_it_is():
    rng = np.random.default_rng(1)
    recording = Recording(np.arange(5), rng.normal(size=(5, 3)), unit(rng, 5))
    path = brush_poses(recording)
    assert path.position == pytest.approx(recording.position)
    assert path.orientation == pytest.approx(recording.orientation)
    assert path.pressure is None


def test_moving_both_hands_together_changes_nothing():
    recording = both_hands()
    q = unit(np.random.default_rng(2), 1)[0]
    one, two = brush_poses(recording), brush_poses(moved(recording, q, np.array([5.0, -3.0, 8.0])))
    assert two.position == pytest.approx(one.position, abs=1e-12)
    assert np.abs(np.sum(one.orientation * two.orientation, axis=1)) == pytest.approx(1.0)


def test_turning_the_object_is_turning_the_brush_the_other_way():
    turn = np.array([[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]])  # a quarter turn about z
    recording = Recording(np.array([0]), np.array([[1.0, 0.0, 0.0]]), turn, object_orientation=turn)
    path = brush_poses(recording)
    assert path.position[0] == pytest.approx([0.0, -1.0, 0.0], abs=1e-12)
    assert path.orientation[0] == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-12)


def test_live_samples_give_the_same_poses_as_the_recording():
    recording = both_hands()
    live, whole = object_poses(list(recording.samples())), brush_poses(recording)
    for name in ("time_s", "position", "orientation", "pressure", "buttons"):
        assert np.array_equal(getattr(live, name), getattr(whole, name))


def test_pads_and_broken_streams_are_refused():
    pad = Recording(
        np.array([0]), np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), header={"space": "pad"}
    )
    with pytest.raises(RecordingError, match="lay it on a surface first"):
        brush_poses(pad)
    with pytest.raises(RecordingError, match="no samples"):
        object_poses([])
    samples = list(both_hands(3).samples())
    with pytest.raises(RecordingError, match="sample 1: time_ns"):
        object_poses([samples[1], samples[0]])


def hand_motion():
    t = np.arange(0.0, 2.0, 1e-3)
    place = np.stack(
        [
            38 * np.sin(2.8 * t) + 0.5 * np.sin(19.0 * t),
            20 * np.cos(3.1 * t),
            2 * np.sin(5.0 * t),
        ],
        axis=1,
    )
    half = 0.6 * np.sin(2.0 * t)
    turn = np.stack([np.cos(half), 0 * t, 0 * t, np.sin(half)], axis=1)
    return t, place, turn


def test_a_stroke_read_at_60_hz_is_the_one_read_at_1000_hz():
    t, place, turn = hand_motion()
    v = np.gradient(place, t, axis=0)
    assert 100 < np.linalg.norm(v, axis=1).max() < 130  # as fast as kaishu gets
    keep = np.round(np.arange(0.0, 1.999, 1 / 60) * 1000).astype(int)
    time_ns = np.round(t * 1e9).astype(np.int64)
    half = np.full(len(keep), 0.5)
    slow = Recording(time_ns[keep], place[keep], turn[keep], half)
    fast = resample(slow, 1000.0)
    found = np.searchsorted(time_ns, fast.time_ns)
    assert np.array_equal(time_ns[found], fast.time_ns)
    error = np.linalg.norm(fast.position - place[found], axis=1)
    assert error.max() < 0.005  # mm; straight lines are off by 0.03
    angle = 2 * np.arccos(np.clip(np.abs(np.sum(fast.orientation * turn[found], axis=1)), 0, 1))
    assert angle.max() < 1e-3
    chord = slow.position[:-1] + 0.5 * np.diff(slow.position, axis=0)
    middle = place[(keep[:-1] + keep[1:]) // 2]
    assert np.linalg.norm(chord - middle, axis=1).max() > 2 * error.max()


def line(times, xs, pressure=None):
    n = len(times)
    position = np.zeros((n, 3))
    position[:, 0] = xs
    return BrushPath(
        np.array(times, dtype=float),
        position,
        np.tile([1.0, 0, 0, 0], (n, 1)),
        None if pressure is None else np.array(pressure, dtype=float),
        np.zeros(n, dtype=np.int32),
    )


def inside(path, n=21):
    """x at `n` places in every interval, (N - 1, n)."""
    dense = densify(path)
    i = np.repeat(np.arange(len(path) - 1), n)
    fraction = np.tile(np.linspace(0, 1, n), len(path) - 1)
    return evaluate(dense, i, fraction)[0][:, 0].reshape(-1, n)


def test_a_parabola_is_kept_to_the_ends_at_uneven_times():
    times = np.array([0.0, 0.01, 0.03, 0.04, 0.07])
    path = line(times, 100 * times + 500 * times**2)
    x = inside(path)
    t = times[:-1, None] + np.diff(times)[:, None] * np.linspace(0, 1, 21)
    assert x == pytest.approx(100 * t + 500 * t**2, abs=1e-12)


def test_no_interval_overshoots_at_a_stop():
    x = inside(line([0.0, 0.01, 0.02, 0.03, 0.04], [0, 0, 0, 5, 5]))
    assert x.min() >= 0.0
    assert x.max() <= 5.0
    assert np.diff(x, axis=1).min() >= 0.0


def test_long_gaps_are_straight():
    path = line([0.0, 0.01, 0.02, 0.52, 0.53], [0, 1, 3, 40, 41])
    assert inside(path)[2] == pytest.approx(np.linspace(3, 40, 21))


def test_a_lifted_pen_is_not_joined_and_bends_nothing():
    pressure = [0.5, 0.5, 0.0, 0.0, 0.5, 0.5]
    times = [0.0, 0.01, 0.02, 0.03, 0.04, 0.05]
    path = line(times, [0, 1, 2, 90, 91, 92], pressure)
    joined = joined_samples(path)
    assert joined.tolist() == [False, True, True, False, True, True]
    assert velocities(path, joined)[:, 0] == pytest.approx(100.0)


def test_tangents_need_no_more_than_two_samples_around():
    rng = np.random.default_rng(3)
    path = line(np.cumsum(rng.uniform(0.005, 0.02, 30)), rng.normal(size=30).cumsum())
    whole = velocities(path, joined_samples(path))
    for cut in range(6, 30):
        part = line(path.time_s[:cut], path.position[:cut, 0])
        early = velocities(part, joined_samples(part))
        assert np.array_equal(early[: cut - 1], whole[: cut - 1])


def test_resampling_keeps_the_ends_and_refuses_silly_rates():
    recording = both_hands()
    again = resample(recording, 333.0)
    assert again.time_ns[[0, -1]].tolist() == recording.time_ns[[0, -1]].tolist()
    assert again.position[-1] == pytest.approx(recording.position[-1], abs=1e-12)
    with pytest.raises(ValueError, match="rate_hz is 0"):
        resample(recording, 0.0)
    with pytest.raises(RecordingError, match="expected at most"):
        resample(recording, 1e9)


# -- the calibrated brush ----------------------------------------------------------------------


TABLE = Path(__file__).parents[2] / ".." / "shared" / "calibration" / "real_brush.csv"


@pytest.mark.skipif(not TABLE.exists(), reason="the measured presses are not here")
def test_calibrated_brush_is_as_near_as_the_model_says():
    width, heel, length = press_errors(load_brush("calibrated"), read_presses(TABLE))
    assert width < 0.72  # readings of one depth scatter by 1.06
    assert heel < 0.86
    assert length < 2.5
