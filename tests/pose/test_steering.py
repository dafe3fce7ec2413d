"""The left hand: rest is rest, and a deflection moves the object in time, not in reports."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.app.model.persistence.settings import Settings, load_settings, save_settings
from paint3d.cli.main import main
from paint3d.core.quaternion import rotate
from paint3d.device.catalogue import find_mouse_quirks
from paint3d.device.sample import StylusReading
from paint3d.device.space_mouse import (
    SILENCE_NS,
    DeflectionSettings,
    calibrate_rest,
    deflection,
)
from paint3d.errors import DeviceError, UnknownNameError
from paint3d.haptics.settings import Feel
from paint3d.pose.mouse_settings import (
    ACTIONS,
    DEFAULT_ACTIONS,
    MouseSettings,
    checked_actions,
    find_actions,
    parse_axes,
)
from paint3d.pose.steering import (
    ObjectPose,
    SteeringOptions,
    SteeringState,
    advance,
    apply_action,
    report,
)
from paint3d.pose.touching import Touches, sheet_corners
from paint3d.pose.two_hands import TwoHands

QUICK = settings(deadline=None, max_examples=40)
QUIRKS = find_mouse_quirks(0x046D, 0xC626)
MS = 1_000_000
DEFLECTION = st.tuples(*[st.floats(-1, 1)] * 6).map(np.array)
MODES = st.sampled_from(["object", "camera"])


def run(options: SteeringOptions, rates, milliseconds: int, period: int) -> ObjectPose:
    """The object after a device said the same every `period` ms, and then fell silent."""
    state = SteeringState(0)
    for t in range(0, milliseconds, period):
        state = report(options, state, t * MS, rates)
    return advance(options, state, milliseconds * MS).pose


def apart(a: ObjectPose, b: ObjectPose) -> float:
    return max(
        np.abs(a.position - b.position).max(), 1.0 - abs(float(a.orientation @ b.orientation))
    )


# -- rest -------------------------------------------------------------------------------------


@QUICK
@given(st.tuples(*[st.integers(-600, 600)] * 6), st.floats(0, 0.5), st.floats(1, 4))
def test_deflection_is_odd_bounded_and_grows(axes, dead_zone, curve) -> None:
    reading = DeflectionSettings(dead_zone=dead_zone, curve=curve)
    found = deflection(axes, QUIRKS, reading)
    assert np.abs(found).max() <= 1.0
    assert np.allclose(deflection([-a for a in axes], QUIRKS, reading), -found)
    further = deflection([a * 2 for a in axes], QUIRKS, reading)
    assert (np.abs(further) >= np.abs(found) - 1e-12).all()


def test_the_dead_zone_has_no_edge() -> None:
    reading = DeflectionSettings(dead_zone=0.1, curve=1.0)
    inside, outside = (deflection([c, 0, 0, 0, 0, 0], QUIRKS, reading)[0] for c in (35, 36))
    assert inside == 0.0
    assert 0.0 < outside < 0.01
    assert deflection([350, 0, 0, 0, 0, 0], QUIRKS, reading)[0] == 1.0


def test_axes_become_right_handed_with_z_up() -> None:
    reading = DeflectionSettings(dead_zone=0.0, curve=1.0)
    found = deflection([350, 350, 350, 350, 350, 350], QUIRKS, reading)
    assert found.tolist() == [1, -1, -1, 1, -1, -1]


def test_rest_is_learned_and_a_moving_cap_is_not() -> None:
    reading = calibrate_rest([[12, -3, 0, 0, 5, 0]] * 5, QUIRKS, DeflectionSettings())
    assert not deflection([12, -3, 0, 0, 5, 0], QUIRKS, reading).any()
    assert calibrate_rest(np.zeros((0, 6)), QUIRKS, reading).rest == (0.0,) * 6
    with pytest.raises(DeviceError, match="nobody to touch"):
        calibrate_rest([[0] * 6, [0, 0, 200, 0, 0, 0]], QUIRKS, DeflectionSettings())
    with pytest.raises(DeviceError, match="leaning on it"):
        calibrate_rest([[90, 0, 0, 0, 0, 0]] * 4, QUIRKS, DeflectionSettings())


@pytest.mark.parametrize(
    "wrong", [{"dead_zone": 0.95}, {"dead_zone": float("nan")}, {"curve": 0.5}, {"rest": (1, 2)}]
)
def test_settings_out_of_range_are_refused(wrong) -> None:
    with pytest.raises(DeviceError, match=next(iter(wrong))):
        DeflectionSettings(**wrong)


# -- motion -----------------------------------------------------------------------------------


@QUICK
@given(DEFLECTION, MODES, st.sampled_from([1, 4, 8, 16, 40]))
def test_motion_does_not_depend_on_the_report_rate(rates, mode, period) -> None:
    options = SteeringOptions(mode=mode, pivot=(10.0, -5.0, 30.0))
    assert apart(run(options, rates, 400, period), run(options, rates, 400, 100)) < 1e-9


def test_full_deflection_moves_at_the_stated_speed() -> None:
    options = SteeringOptions(speed_mm_s=120.0, turn_rad_s=0.5)
    moved = run(options, np.array([1.0, 0, 0, 0, 0, 0]), 1000, 8)
    assert np.allclose(moved.position, [120.0, 0, 0])
    turned = run(options, np.array([0, 0, 0, 0, 0, 1.0]), 1000, 8)
    assert np.allclose(turned.orientation, [np.cos(0.25), 0, 0, np.sin(0.25)])


@QUICK
@given(DEFLECTION, MODES, st.integers(SILENCE_NS, 10 * SILENCE_NS))
def test_a_silent_device_stops_the_object(rates, mode, much_later) -> None:
    options = SteeringOptions(mode=mode)
    state = report(options, SteeringState(0), 0, rates)
    stopped = advance(options, state, SILENCE_NS)
    later = advance(options, state, much_later).pose
    assert np.array_equal(later.position, stopped.pose.position)
    assert np.array_equal(later.orientation, stopped.pose.orientation)


@QUICK
@given(DEFLECTION, MODES, st.integers(1, 400), st.integers(1, 400))
def test_half_and_half_is_whole(rates, mode, a, b) -> None:
    options = SteeringOptions(mode=mode, pivot=(3.0, 1.0, 2.0))
    state = report(options, SteeringState(0), 0, rates)
    halves = advance(options, advance(options, state, a * MS // 4), (a + b) * MS // 4)
    assert apart(halves.pose, advance(options, state, (a + b) * MS // 4).pose) < 1e-9


def test_the_object_turns_about_its_pivot() -> None:
    pivot = np.array([0.0, 20.0, 40.0])
    options = SteeringOptions(pivot=tuple(pivot))
    turned = run(options, np.array([0, 0, 0, 0.7, -0.3, 0.4]), 900, 8)
    assert np.allclose(turned.position + rotate(turned.orientation, pivot), pivot)


def test_the_camera_moves_the_other_way_about_the_viewer() -> None:
    options = SteeringOptions(mode="camera", turn_rad_s=1.0)
    start = SteeringState(0, ObjectPose(np.array([0.0, 100.0, 0.0])))
    state = report(options, start, 0, np.array([0, 0, 0, 0, 0, 1.0]))
    seen = advance(options, state, 100 * MS).pose  # turned left by 0.1: it goes to the right
    assert np.allclose(seen.position, [100 * np.sin(0.1), 100 * np.cos(0.1), 0.0])
    nearer = report(options, start, 0, np.array([0, 1.0, 0, 0, 0, 0]))
    assert advance(options, nearer, 100 * MS).pose.position[1] == pytest.approx(85.0)


def test_axis_options() -> None:
    rates = np.array([0.5, 0.8, 0.1, 0.2, 0.3, 0.4])

    def moved(**wanted) -> ObjectPose:
        return run(SteeringOptions(speed_mm_s=100.0, **wanted), rates, 100, 10)

    assert np.allclose(moved(turning=False).position, [5, 8, 1])
    assert np.allclose(moved(turning=False).orientation, [1, 0, 0, 0])
    assert not moved(moving=False).position.any()
    assert np.allclose(moved(dominant_axis=True).position, [0, 8, 0])
    assert np.allclose(moved(zoom_axis="z", turning=False).position, [5, 1, 8])
    inverted = (True, False, True, False, False, False)
    assert np.allclose(moved(inverted=inverted, turning=False).position, [-5, 8, -1])
    view = (np.cos(np.pi / 4), 0.0, 0.0, np.sin(np.pi / 4))  # the user sits a quarter turn on
    assert np.allclose(moved(world_from_view=view, turning=False).position, [-8, 5, 1])


def test_two_seconds_of_steering_keep_a_rotation() -> None:
    state = SteeringState(0)
    for t in range(2000):
        state = report(SteeringOptions(), state, t * MS, np.sin(np.arange(6) + t * 0.01))
    assert np.linalg.norm(state.pose.orientation) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    "wrong",
    [
        {"mode": "fly"},
        {"zoom_axis": "x"},
        {"speed_mm_s": -1.0},
        {"turn_rad_s": float("inf")},
        {"inverted": (True,)},
        {"world_from_view": (2.0, 0.0, 0.0, 0.0)},
        {"pivot": (0.0, float("nan"), 0.0)},
    ],
)
def test_options_out_of_range_are_refused(wrong) -> None:
    with pytest.raises(DeviceError, match=next(iter(wrong))):
        SteeringOptions(**wrong)


# -- buttons ----------------------------------------------------------------------------------


def test_a_button_acts_once_when_it_goes_down() -> None:
    assert find_actions(0b00, 0b11) == ["recentre", "dip"]
    assert find_actions(0b01, 0b11) == ["dip"]
    assert find_actions(0b11, 0b01) == []
    assert set(DEFAULT_ACTIONS.values()) <= set(ACTIONS)


def test_actions_change_the_options_they_name() -> None:
    options = SteeringOptions()
    for action, field in (
        ("toggle_turning", "turning"),
        ("toggle_moving", "moving"),
        ("toggle_dominant_axis", "dominant_axis"),
        ("toggle_camera", "mode"),
    ):
        changed = apply_action(options, action)
        differing = [
            f.name
            for f in dataclasses.fields(options)
            if getattr(changed, f.name) != getattr(options, f.name)
        ]
        assert differing == [field]
        assert apply_action(changed, action) == options
    assert apply_action(options, "undo") == options


def test_own_actions_are_checked() -> None:
    assert checked_actions({30: "undo"}) == {30: "undo"}
    with pytest.raises(DeviceError, match="button 31"):
        checked_actions({31: "undo"})
    with pytest.raises(UnknownNameError, match="recentre"):
        checked_actions({0: "recenter"})


# -- settings ----------------------------------------------------------------------------------


# x, y, z, rx, ry, rz as a cap sends them: a hand that pushes, lifts and turns, each by its share
REPORTS = [
    (30 * k % 350, -(20 * k) % 300, 10 * k, -(15 * k) % 200, 25 * k % 320, 8 * k)
    for k in range(1, 30)
]


def way(mouse: MouseSettings) -> np.ndarray:
    """Where the object is after the recorded reports: position and orientation."""
    quirks, hands = find_mouse_quirks(0x046D, 0xC626), TwoHands(steering=mouse.steering())
    for k, axes in enumerate(REPORTS):
        hands.add_deflection(10 * MS * k, deflection(axes, quirks, mouse.deflection()))
    hands.take(10 * MS * len(REPORTS))
    pose = hands.object_pose
    return np.concatenate([pose.position, pose.orientation])


@pytest.mark.parametrize(
    "changed",
    [
        {"mode": "camera"},
        {"speed_mm_s": 90.0},
        {"turn_deg_s": 40.0},
        {"dead_zone": 0.2},
        {"curve": 1.0},
        {"axes": ("-x", "y", "z", "rx", "ry", "rz")},
        {"axes": ("x", "z", "y", "rx", "ry", "rz")},
        {"axes": ("x", "y", "z", "ry", "rx", "rz")},
        {"axes": ("rx", "y", "z", "x", "ry", "rz")},
        {"moving": False},
        {"turning": False},
        {"dominant_axis": True},
        {"zoom_axis": "z"},
    ],
)
def test_every_control_changes_the_way(changed) -> None:
    assert np.abs(way(MouseSettings(**changed)) - way(MouseSettings())).max() > 1e-3


def test_as_it_was_is_as_it_was() -> None:
    before = MouseSettings()
    assert before.steering() == TwoHands().steering
    assert MouseSettings.from_dict(before.as_dict()) == before


def test_swapped_axes_are_swapped_and_turned_round() -> None:
    quirks = find_mouse_quirks(0x046D, 0xC626)
    told = deflection((300, 0, 0, 0, 0, 0), quirks, MouseSettings().deflection())
    for axes, wanted in (("x,y,z,rx,ry,rz", 0), ("y,x,z,rx,ry,rz", 1), ("y,-x,z,rx,ry,rz", 1)):
        hands = TwoHands(steering=MouseSettings(axes=parse_axes(axes)).steering())
        hands.add_deflection(0, told)
        hands.take(100 * MS)
        moved = hands.object_pose.position
        assert np.argmax(np.abs(moved)) == wanted
        assert (moved[wanted] < 0.0) == ("-" in axes)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"mode": "car"}, "mode is 'car'; expected object or camera"),
        ({"speed_mm_s": -1.0}, "speed_mm_s"),
        ({"dead_zone": 1.0}, "dead_zone"),
        ({"axes": ("x", "x", "z", "rx", "ry", "rz")}, "once each"),
        ({"moving": "yes"}, "true or false"),
    ],
)
def test_what_is_out_of_range_is_named(words, message) -> None:
    with pytest.raises(DeviceError, match=message):
        MouseSettings(**words)


def test_the_command_keeps_what_was_set(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path))
    save_settings(Settings(language="zh"))
    asked = ["devices", "set", "--mouse-mode", "camera", "--mouse-speed", "200"]
    asked += ["--mouse-turn", "90", "--mouse-dead-zone", "0.1", "--mouse-curve", "2"]
    asked += ["--mouse-axes=x,-z,y,rx,ry,rz", "--mouse-zoom", "z", "--mouse-one-axis", "on"]
    asked += ["--mouse-button", "2=undo", "--mouse-button", "1=", "--stylus", "inverse3"]
    asked += ["--stylus-anticipation", "4", "--stylus-click", "0.3"]
    asked += ["--stylus-texture", "0.5"]
    assert main([*asked, "--stylus-limit", "2.5"]) == 0
    settings, problem = load_settings()
    assert problem is None
    assert settings.language == "zh"
    mouse = MouseSettings.from_dict(settings.mouse)
    assert mouse.axes == ("x", "-z", "y", "rx", "ry", "rz")
    assert (mouse.mode, mouse.speed_mm_s, mouse.turn_deg_s) == ("camera", 200.0, 90.0)
    assert (mouse.dead_zone, mouse.curve, mouse.zoom_axis) == (0.1, 2.0, "z")
    assert (mouse.dominant_axis, mouse.moving) == (True, True)
    assert (settings.buttons[1], 0 in settings.buttons) == ("undo", False)
    assert settings.stylus == "inverse3"
    assert settings.feel == {"limit_n": 2.5, "anticipation_mm": 4.0, "click_n": 0.3, "texture": 0.5}
    assert "mouse axes: x,-z,y,rx,ry,rz" in capsys.readouterr().out
    for wrong in (["--mouse-axes=x,y"], ["--mouse-button", "2=fly"], ["--mouse-dead-zone", "2"]):
        assert main(["devices", "set", *wrong]) == 2
        said = capsys.readouterr().err
        assert said.startswith("paint3d: error: ")
        assert said.count("\n") == 1
    assert main(["devices", "set", "--defaults"]) == 0
    settings = load_settings()[0]
    assert MouseSettings.from_dict(settings.mouse) == MouseSettings()
    assert Feel.from_dict(settings.feel) == Feel()
    assert (settings.stylus, settings.buttons) == ("auto", Settings().buttons)
    assert settings.language == "zh"


# -- touching ---------------------------------------------------------------------------------


def touched(points, places) -> Touches:
    touches = Touches(points)
    touches.touched = [np.asarray(place, float) for place in places]
    return touches


def test_touches_give_the_frame_and_each_its_error() -> None:
    points = sheet_corners(210.0, 148.0)
    turned = points[:, [1, 0, 2]] * [1.0, -1.0, 1.0] + [5.0, -3.0, 40.0]  # by a quarter, about z
    turned[2] += [0.0, 0.4, 0.0]
    fitted = touched(points, turned).fit()
    assert fitted.calibration.residual_mm == pytest.approx(np.sqrt((fitted.errors_mm**2).mean()))
    assert 0.05 < fitted.errors_mm.max() < 0.4
    middle = fitted.calibration.to_world(turned.mean(axis=0))
    assert np.abs(middle).max() < 1e-6
    assert np.allclose(fitted.calibration.to_device(middle), turned.mean(axis=0))


@pytest.mark.parametrize(
    ("places", "message"),
    [
        ([(0, 0, 0), (0.5, 0, 0), (100, 80, 0), (0, 80, 0)], "1 and 2 lie 0.50 mm apart"),
        ([(0, 0, 0), (70, 1, 0), (140, 0, 0), (210, 1, 0)], "within 0.4. mm of one line"),
        (
            [(0, 0, 0), (210, 148, 0), (210, 0, 0), (0, 148, 0)],
            "256.9 mm apart, their points 210",
        ),
        (
            [(0, 0, 0), (150, 0, 0), (150, 100, 0), (0, 100, 0)],
            "180.3 mm apart, their",
        ),
        ([(0, 0, 0), (210, 0, 0), (210, 148, 0)], "3 of 4 points"),
    ],
)
def test_touches_that_give_no_frame_are_refused_with_numbers(places, message) -> None:
    with pytest.raises(DeviceError, match=message):
        touched(sheet_corners(), places).fit()


def heard(time_ms: float, place, buttons: int) -> StylusReading:
    at, upright = np.array(place, float), np.array([1.0, 0.0, 0.0, 0.0])
    return StylusReading(int(time_ms * MS), at, upright, None, buttons)


def test_a_button_that_bounces_touches_one_point() -> None:
    touches = Touches(sheet_corners())
    held = [heard(k, touches.points[0], b) for k, b in enumerate((0, 0, 1, 0))]
    assert touches.add(held)
    with pytest.raises(DeviceError, match=r"point 2 was touched 0\.00 mm from point 1; expected"):
        touches.add([heard(9.0, touches.points[0], 1)])
    assert len(touches.touched) == 1
    for k, place in enumerate(touches.points[1:]):
        assert touches.add([heard(100.0 * (k + 1) + b, place, b) for b in (0, 1)])
    assert touches.is_done
    assert touches.fit().errors_mm.max() < 1e-9


def test_a_stylus_that_moves_while_it_touches_is_asked_again() -> None:
    touches = Touches(sheet_corners())
    moves = [heard(k, touches.points[0] + [0.2 * k, 0.0, 0.0], int(k == 59)) for k in range(60)]
    with pytest.raises(DeviceError, match=r"moved by 5\.9 mm while point 1 was touched"):
        touches.add(moves)
    assert touches.add([heard(150.0 + k, touches.points[0], k) for k in (0, 1)])


def test_points_on_a_line_are_not_asked_for() -> None:
    with pytest.raises(DeviceError, match=r"points to touch lie within 0\.00 mm of one line"):
        Touches([(0, 0, 0), (50, 0, 0), (100, 0, 0)])
