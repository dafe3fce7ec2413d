"""A 6-DOF mouse's settings: every control changes the object's way, and all are kept."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.app.model.persistence.settings import Settings, load_settings, save_settings
from paint3d.cli.main import main
from paint3d.device.catalogue import find_mouse_quirks
from paint3d.device.sample import StylusReading
from paint3d.device.space_mouse import deflection
from paint3d.errors import DeviceError
from paint3d.haptics.settings import Feel
from paint3d.pose.mouse_settings import MouseSettings, parse_axes
from paint3d.pose.touching import Touches, sheet_corners
from paint3d.pose.two_hands import TwoHands

MS = 1_000_000
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
    assert MouseSettings.from_words(before.as_words()) == before


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
    mouse = MouseSettings.from_words(settings.mouse)
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
    assert MouseSettings.from_words(settings.mouse) == MouseSettings()
    assert Feel.from_words(settings.feel) == Feel()
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
    assert touches.hear(held)
    with pytest.raises(DeviceError, match=r"point 2 was touched 0\.00 mm from point 1; expected"):
        touches.hear([heard(9.0, touches.points[0], 1)])
    assert len(touches.touched) == 1
    for k, place in enumerate(touches.points[1:]):
        assert touches.hear([heard(100.0 * (k + 1) + b, place, b) for b in (0, 1)])
    assert touches.is_done
    assert touches.fit().errors_mm.max() < 1e-9


def test_a_stylus_that_moves_while_it_touches_is_asked_again() -> None:
    touches = Touches(sheet_corners())
    moves = [heard(k, touches.points[0] + [0.2 * k, 0.0, 0.0], int(k == 59)) for k in range(60)]
    with pytest.raises(DeviceError, match=r"moved by 5\.9 mm while point 1 was touched"):
        touches.hear(moves)
    assert touches.hear([heard(150.0 + k, touches.points[0], k) for k in (0, 1)])


def test_points_on_a_line_are_not_asked_for() -> None:
    with pytest.raises(DeviceError, match=r"points to touch lie within 0\.00 mm of one line"):
        Touches([(0, 0, 0), (50, 0, 0), (100, 0, 0)])
