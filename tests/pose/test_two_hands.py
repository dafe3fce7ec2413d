"""Two time-stamped streams to one pose: nothing lost, nothing late, no lag a hand would notice."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from paint3d.core.quaternion import rotate
from paint3d.device.report_timing import ReportClock, stamp
from paint3d.device.sample import StylusReading
from paint3d.errors import DeviceError
from paint3d.pose.brush_pose import object_poses
from paint3d.pose.calibration import (
    DeviceCalibration,
    fit_calibration,
    load_calibration,
    save_calibration,
)
from paint3d.pose.steering import ObjectPose, SteeringOptions
from paint3d.pose.two_hands import SmoothingSettings, TwoHands, lag_s, smooth_pose
from scripts.two_hands_minute import simulate

QUICK = settings(deadline=None, max_examples=25)
MS = 1_000_000
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def reading(t_ms: float, x: float = 0.0, in_range: bool = True) -> StylusReading:
    position = np.array([x, 0.0, 30.0])
    return StylusReading(round(t_ms * MS), position, UPRIGHT, None, 0, in_range)


# -- merging ----------------------------------------------------------------------------------


@QUICK
@given(
    st.lists(st.integers(1, 12), min_size=1, max_size=60),
    st.lists(st.tuples(st.integers(1, 40), st.floats(-1, 1)), max_size=20),
    st.lists(st.integers(1, 90), min_size=1, max_size=8),
)
def test_when_the_queues_are_read_does_not_matter(beats, nudges, pauses) -> None:
    stylus = [reading(t, t * 0.1) for t in np.cumsum(beats)]
    times = np.cumsum([wait for wait, _ in nudges]) if nudges else []
    mouse = [(int(t) * MS, np.full(6, d)) for t, (_, d) in zip(times, nudges, strict=True)]
    end = (sum(beats) + 1000) * MS

    at_once = TwoHands()
    at_once.add_stylus(stylus)
    for t, d in mouse:
        at_once.add_deflection(t, d)
    whole = at_once.take(end)

    piecewise, now, parts = TwoHands(), 0, []
    for pause in [*pauses, end]:
        before, now = now, min(now + pause * MS, end)
        for t, d in mouse:
            if before < t <= now:
                piecewise.add_deflection(t, d)
        piecewise.add_stylus(r for r in stylus if before < r.time_ns <= now)
        parts += piecewise.take(now)
    assert len(whole) == len(stylus)
    assert [s.time_ns for s in parts] == [s.time_ns for s in whole]
    for a, b in zip(whole, parts, strict=True):
        assert np.allclose(a.object_position, b.object_position, atol=1e-9)
        assert np.allclose(a.object_orientation, b.object_orientation, atol=1e-9)


def test_the_object_moves_between_two_reports_of_its_mouse() -> None:
    hands = TwoHands(steering=SteeringOptions(speed_mm_s=100.0))
    hands.add_deflection(0, [1, 0, 0, 0, 0, 0])
    hands.add_stylus(reading(t) for t in range(1, 100))
    x = [sample.object_position[0] for sample in hands.take(100 * MS)]
    assert np.allclose(x, 0.1 * np.arange(1, 100))


def test_what_is_too_young_waits() -> None:
    hands = TwoHands()
    hands.add_stylus([reading(5), reading(15)])
    assert [s.time_ns for s in hands.take(10 * MS)] == [5 * MS]
    assert [s.time_ns for s in hands.take(20 * MS)] == [15 * MS]


def test_a_late_reading_is_counted_and_kept() -> None:
    hands = TwoHands()
    hands.add_stylus([reading(5)])
    hands.take(10 * MS)
    hands.add_stylus([reading(4, 1.0), reading(11)])
    samples = hands.take(20 * MS)
    assert hands.late == 1
    assert np.diff([5 * MS, *(s.time_ns for s in samples)]).min() > 0
    assert samples[0].position[0] == 1.0
    object_poses(samples)  # times grow, as painting asks


def test_a_pen_out_of_range_paints_nothing() -> None:
    hands = TwoHands(smoothing=SmoothingSettings())
    hands.add_stylus([reading(1), reading(2, 90.0, in_range=False), reading(3, 50.0)])
    samples = hands.take(10 * MS)
    assert [s.position[0] for s in samples] == [0.0, 50.0]  # nothing smoothed across the gap


def test_the_object_can_be_put_elsewhere() -> None:
    hands = TwoHands()
    hands.set_object_pose(ObjectPose(np.array([1.0, 2.0, 3.0]), UPRIGHT))
    hands.add_stylus([reading(1)])
    assert hands.take(2 * MS)[0].object_position.tolist() == [1, 2, 3]
    assert hands.object_pose.position.tolist() == [1, 2, 3]


# -- calibration ------------------------------------------------------------------------------


@QUICK
@given(st.integers(0, 10_000), st.booleans())
def test_touched_points_give_the_calibration_back(seed, scaled) -> None:
    rng = np.random.default_rng(seed)
    turn = Rotation.random(rng=rng)
    scale = float(rng.uniform(0.5, 2.0)) if scaled else 1.0
    points = rng.normal(scale=60.0, size=(5, 3))
    world = scale * turn.apply(points) + rng.normal(scale=100.0, size=3)
    found = fit_calibration(points, world, scaled=scaled)
    assert np.allclose(found.to_world(points), world, atol=1e-6)
    assert found.residual_mm < 1e-6
    assert found.scale == pytest.approx(scale)
    assert np.allclose(found.to_device(world), points, atol=1e-6)


def test_a_mirrored_fit_is_never_made() -> None:
    points = np.array([[0, 0, 0], [50, 0, 0], [0, 50, 0], [0, 0, 50.0]])
    found = fit_calibration(points, points * [1, 1, -1])
    assert np.linalg.norm(found.rotation) == pytest.approx(1.0)
    assert found.residual_mm > 5.0
    side = rotate(found.rotation, np.eye(3))
    assert np.linalg.det(side) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("device", "world", "why"),
    [
        (np.eye(3)[:2], np.eye(3)[:2], "at least 3"),
        (np.eye(3), np.eye(3)[:2], "as many"),
        (np.outer(np.arange(4.0), [1, 2, 3]), np.outer(np.arange(4.0), [1, 0, 0]), "one line"),
        (np.eye(3) * np.nan, np.eye(3), "finite"),
    ],
)
def test_points_that_fix_nothing_are_refused(device, world, why) -> None:
    with pytest.raises(DeviceError, match=why):
        fit_calibration(device, world)


def test_a_calibration_is_written_and_read(tmp_path) -> None:
    file = tmp_path / "touch.json"
    wanted = DeviceCalibration([0.6, 0.0, 0.8, 0.0], [1.0, 2.0, 3.0], 1.5, 0.2)
    save_calibration(wanted, file)
    assert load_calibration(file).as_dict() == wanted.as_dict()
    assert list(tmp_path.iterdir()) == [file]
    for damage in ("{", "[]", '{"format": "x"}', json.dumps({"format": "paint3d-calibration"})):
        file.write_text(damage)
        with pytest.raises(DeviceError, match="touch"):
            load_calibration(file)
    with pytest.raises(DeviceError, match="cannot write"):
        save_calibration(wanted, tmp_path / "no" / "touch.json")


# -- smoothing --------------------------------------------------------------------------------


def smooth(settings, times_s, positions):
    state, out = None, []
    for t, p in zip(times_s, positions, strict=True):
        state = smooth_pose(settings, state, round(t * 1e9), p, UPRIGHT, 0.5)
        out.append(state.position)
    return np.array(out)


@pytest.mark.parametrize(("speed", "most_ms"), [(50.0, 6.0), (100.0, 3.0), (300.0, 1.5)])
def test_no_lag_that_a_hand_notices(speed, most_ms) -> None:
    t = np.arange(0.0, 1.0, 0.001)
    way = np.stack([speed * t, 0 * t, 0 * t], axis=1)
    behind = (way - smooth(SmoothingSettings(), t, way))[500:, 0] / speed * 1000.0
    assert behind.max() <= most_ms
    assert behind[-1] == pytest.approx(1000 * lag_s(SmoothingSettings(), speed), abs=0.6)


def test_a_hand_at_rest_shakes_less() -> None:
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 2.0, 0.001)
    shaking = rng.normal(scale=0.02, size=(len(t), 3))
    calm = smooth(SmoothingSettings(), t, shaking)[200:]
    assert calm.std() < 0.35 * shaking.std()


def test_smoothing_does_not_depend_on_the_rate() -> None:
    def ends(rate):
        t = np.arange(0.0, 0.5 + 0.5 / rate, 1.0 / rate)
        return smooth(SmoothingSettings(), t, np.outer(np.sin(3 * t), [40.0, 0, 0]))[-1, 0]

    assert abs(ends(1000) - ends(250)) < 0.3


def test_a_lifted_pen_is_lifted_at_once() -> None:
    state = smooth_pose(SmoothingSettings(), None, 0, np.zeros(3), UPRIGHT, 0.8)
    state = smooth_pose(SmoothingSettings(), state, MS, np.zeros(3), UPRIGHT, 0.0)
    assert state.pressure == 0.0


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('{"rotation": [1e200, 0, 0, 0]}', "rotation has length 1e"),
        ('{"shift": [0, 1e300, 0]}', "shift in y is 1e"),
        ('{"residual_mm": Infinity}', "residual_mm is inf"),
        ("[" * 100_000, "no calibration can be read"),
    ],
)
def test_a_calibration_out_of_all_bounds_is_refused_in_one_line(tmp_path, text, told) -> None:
    path = tmp_path / "a.json"
    save_calibration(DeviceCalibration(), path)
    whole = json.loads(path.read_text("utf-8"))
    path.write_text(json.dumps(whole | json.loads(text)) if text[0] == "{" else text, "utf-8")
    with pytest.raises(DeviceError, match=told) as refusal:
        load_calibration(path)
    assert "\n" not in str(refusal.value)


# -- time stamps ------------------------------------------------------------------------------


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 1000), st.floats(0.999, 1.001))
def test_the_clock_undoes_late_reading(seed, drift) -> None:
    rng = np.random.default_rng(seed)
    n = 2000
    true = 10**9 + np.cumsum(np.full(n, MS * drift))
    late = rng.exponential(0.1 * MS, n)
    late[rng.random(n) < 0.01] += 6 * MS  # the reader was busy
    read = np.maximum.accumulate(true + late).astype(np.int64)
    clock, given_ns = ReportClock(MS), []
    for i in range(n):
        at, clock = stamp(clock, int(read[i]), i & 0xFFFF)
        given_ns.append(at)
    given_ns = np.array(given_ns)
    assert (np.diff(given_ns) > 0).all()
    assert (given_ns <= read + 1000).all()  # some ns apart where many were read at once
    assert clock.lost == 0
    error, raw_error = given_ns[500:] - true[500:], read[500:] - true[500:]
    assert np.std(error) < 0.4 * np.std(raw_error)
    assert np.percentile(np.abs(np.diff(given_ns[500:]) - MS), 99) < 0.3 * MS


def test_lost_reports_are_counted() -> None:
    clock = ReportClock(MS)
    for number in (0, 1, 2, 5, 6):
        _, clock = stamp(clock, 10**9 + number * MS, number)
    assert clock.lost == 2


def test_a_break_locks_the_clock_anew() -> None:
    _, clock = stamp(ReportClock(MS), 10**9, 7)
    at, clock = stamp(clock, 2 * 10**9, 8)
    assert at == 2 * 10**9
    assert clock.lost == 0


# -- a minute ----------------------------------------------------------------------------------


def test_no_sample_is_lost_and_nothing_drifts() -> None:
    found = simulate(6.0, resolution=2.0)  # a swing, a rest, and a second more
    assert found.painted == found.sent == 6000
    assert found.late == 0
    assert found.ring_error_mm < 0.003
    assert found.last_second_error_mm < 0.003
    assert found.turn_error < 1e-9
    assert found.ink_error < 1e-6  # wet ink is kept in single precision
    assert 1.0 < found.strongest_n < 7.9
