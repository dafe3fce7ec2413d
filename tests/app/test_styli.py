"""Styli that push back, chosen by a word: each paints in the window, and is felt as its brush."""

from __future__ import annotations

import struct
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from paint3d.app.model.input.devices import Feeling, NoDevices, start_feeling
from paint3d.app.model.persistence.settings import Settings, load_settings, stored_calibration
from paint3d.app.window.studio import StudioWindow
from paint3d.brush.presets import load_brush
from paint3d.colour.materials import load_material
from paint3d.device.force import haptic_stylus
from paint3d.device.hid_nodes import HidNode
from paint3d.device.hot_plug import PluggedDevices
from paint3d.device.sample import DIP, StylusReading
from paint3d.device.space_mouse import MouseEvent
from paint3d.errors import DeviceError
from paint3d.haptics.settings import DeviceLimits, Feel, HapticSettings
from paint3d.pose.mouse_settings import MouseSettings
from paint3d.pose.steering import apply_action
from tests.support.app.gestures import live, pen_stroke, wait_for
from tests.support.app.windows import blind, close_unasked, faults, opened, settled
from tests.support.cases import long_but
from tests.support.descriptors import pen
from tests.support.force_model import ForceModel
from tests.support.plugged import device
from tests.support.styli import Inverse3StandIn, OpenHapticsStandIn

DEEP = 6.0  # mm
LIFTED = 80.0
BRUSH = load_brush("full")
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
SHEET = ((-105.0, -74.0), (105.0, -74.0), (105.0, 74.0), (-105.0, 74.0))


STAND_INS = [OpenHapticsStandIn, Inverse3StandIn]


@pytest.fixture
def stylus(request, tmp_path, monkeypatch):
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path / "config"))
    stylus = request.param(tmp_path)
    for name, value in stylus.environment.items():
        monkeypatch.setenv(name, value)
    stylus.hold(0.0, 0.0, LIFTED)
    yield stylus
    stylus.close()


@pytest.fixture
def window(program, stylus):
    settings = Settings(stylus=stylus.choice)
    window = StudioWindow(program, settings, feel=start_feeling)
    window.show()
    window.workspace.quiet = True
    assert window.opening.open_path("plane", 1.5, "porcelain", asked=True)
    wait_for(lambda: window.stage.is_lit)
    with blind(window):
        wait_for(lambda: window.both_hands.desk.rate_hz("right") > 0.0)
        yield window
        close_unasked(window)


def done(window) -> None:
    """Wait until what was asked for is painted: a stylus that is held is never still."""
    window.stage.paint_thread.post(lambda document: None).result(300)
    live(0.1)


def paint_a_line(window, stylus, at=(0.0, 0.0)) -> np.ndarray:
    """Go from 15 mm to the left of a place to 15 mm to the right: the vertices that are inked."""
    n = len(window.document.strokes)
    z = window.document.painter.brush.length_mm - DEEP
    stylus.hold(at[0] - 15.0, at[1], LIFTED)
    live(0.1)
    for x in np.linspace(-15.0, 15.0, 40):
        stylus.hold(at[0] + x, at[1], z)
        live(0.01)
    stylus.hold(at[0] + 15.0, at[1], LIFTED)
    wait_for(lambda: len(window.document.strokes) == n + 1)
    done(window)
    surface = window.document.surface
    return surface.paint_mesh.vertices[np.flatnonzero(surface.painted)]


def is_pushed_back(stylus, x: float, y: float, z: float) -> bool:
    """Whether it is told to push upwards when it is pressed down from above."""
    stylus.hold(x, y, LIFTED)  # after a pause of the machine it is felt again when it was lifted
    live(0.2)
    stylus.hold(x, y, z)
    live(0.5)
    return bool(stylus.force()[2] > 0.02)


@pytest.mark.parametrize("stylus", STAND_INS, indirect=True)
def test_it_paints_under_its_place_and_is_felt_as_the_brush_in_the_hand(window, stylus) -> None:
    places = paint_a_line(window, stylus)
    assert abs(np.median(places[:, 1])) < 1.0
    assert np.ptp(places[:, 0]) > 30.0
    assert window.panels.devices.stylus.kind.currentData() == stylus.choice.partition("=")[0]
    wait_for(lambda: is_pushed_back(stylus, 0.0, 40.0, BRUSH.length_mm - DEEP))
    stylus.hold(0.0, 40.0, LIFTED)
    wait_for(lambda: not stylus.force().any())


class Law(NoDevices):
    """Stands in for a servo: tells the force of its settings, 6 mm deep in the tree's surface."""

    last_force = np.zeros(3)
    fault: str | None = None

    def __init__(self, tree, settings) -> None:
        super().__init__()
        self.tree, self.settings = tree, settings
        self.readings: list[StylusReading] = []
        self.clicks = 0

    def take(self) -> list[StylusReading]:
        taken, self.readings = self.readings, []
        return taken

    def click(self) -> None:
        self.clicks += 1

    def publish(self, object_pose=None) -> None:
        assert object_pose is not None

    def is_running(self) -> bool:
        return self.fault is None

    def status(self) -> SimpleNamespace:
        return SimpleNamespace(fault=self.fault)

    def say(self, x: float, z: float, buttons: int = 0) -> None:
        """Be held there, upright, mm; and be heard."""
        place = np.array([x, 0.0, z])
        self.readings.append(StylusReading(time.monotonic_ns(), place, UPRIGHT, None, buttons))
        live(0.1)

    def felt(self) -> float:
        model = ForceModel(self.tree, self.settings, awake=True)
        for _ in range(60):
            step = model.step([0.0, 0.0, self.settings.length - DEEP])
        return float(step.force[2])


def test_the_force_is_that_of_the_brush_that_was_taken_last(program) -> None:
    limits, laws = DeviceLimits(5.0, 0.6), []

    def feel(document, settings):
        brush = Feel.from_dict(settings.feel).settings(document.painter.brush, limits)
        laws.append(Law(document.surface.contact_tree, brush))
        return Feeling(laws[-1], limits=limits)

    window = StudioWindow(program, Settings(), feel=feel)
    window.workspace.quiet = True
    assert window.opening.open_path("plane", 2.0, "porcelain", asked=True)
    for name in ("full", "gongbi", "dakai", "full"):
        window.workspace.post("set_brush", name)
        done(window)
        brush = load_brush(name)
        spring = min(HapticSettings.for_brush(brush, limits).spring, limits.max_stiffness)
        wanted = spring * DEEP
        wait_for(lambda wanted=wanted: abs(laws[-1].felt() - wanted) < 0.01 * wanted)
    form = window.panels.devices.stylus
    form.ahead.setValue(4.0)
    form.click.setValue(0.3)
    wait_for(lambda: (laws[-1].settings.ahead_mm, laws[-1].settings.click_n) == (4.0, 0.3))
    form.limit.setValue(0.5)
    wait_for(lambda: abs(laws[-1].felt() - 0.5) < 1e-6)
    assert window.workspace.settings.feel["limit_n"] == 0.5
    window.workspace.post("wipe")
    done(window)
    empty = window.document.surface.ink.load.sum()
    for buttons in (0, DIP, DIP, 0):  # the stylus' own button, while it is lifted
        laws[-1].say(0.0, LIFTED, buttons)
    wait_for(lambda: window.document.surface.ink.load.sum() > empty)
    assert laws[-1].clicks == 1
    assert not window.document.strokes
    close_unasked(window)


def test_the_surface_is_felt_as_it_is_and_its_grain_as_much_as_is_wanted(program) -> None:
    laws = []

    def feel(document, settings):
        laws.append(Law(document.surface.contact_tree, HapticSettings(35.0, 0.4, 0.2)))
        return Feeling(laws[-1])

    window = StudioWindow(program, Settings(), feel=feel)
    window.workspace.quiet = True
    for name in ("porcelain", "terracotta"):
        assert window.opening.open_path("plane", 2.0, name, asked=True)
        material, brush = load_material(name), window.document.painter.brush
        mu = brush.friction * material.friction
        wait_for(lambda mu=mu: abs(laws[-1].settings.friction - mu) < 1e-12)
        assert laws[-1].settings.grain == material.grain
        assert laws[-1].settings.texture == 1.0  # at first
    window.panels.devices.stylus.texture.setValue(0.5)
    wait_for(lambda: laws[-1].settings.texture == 0.5)
    assert window.workspace.settings.feel["texture"] == 0.5
    close_unasked(window)


@pytest.fixture
def felt(program, tmp_path, monkeypatch):
    """A window, and the styli that it began to feel with."""
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path / "config"))
    laws = []

    def feel(document, settings):
        laws.append(Law(document.surface.contact_tree, HapticSettings(35.0, 0.4, 0.2)))
        return Feeling(laws[-1])

    window = StudioWindow(program, Settings(), feel=feel)
    window.workspace.quiet = True
    assert window.opening.open_path("plane", 2.0, "porcelain", asked=True)
    wait_for(lambda: window.stage.is_lit)
    yield window, laws
    close_unasked(window)


@pytest.mark.parametrize("how", ["it fails", "another is chosen", "it is calibrated", "it is gone"])
def test_a_stroke_ends_with_the_stylus_that_paints_it(felt, how) -> None:
    window, laws = felt
    deep = window.document.painter.brush.length_mm - DEEP
    for x, z in ((0.0, LIFTED), (0.0, deep), (5.0, deep), (10.0, deep)):
        laws[-1].say(x, z)
    assert window.both_hands.in_stroke
    if how == "it fails":
        laws[-1].fault = "its cable is off"
    elif how == "another is chosen":
        window.both_hands.choose_stylus("auto")
    elif how == "it is calibrated":
        window.both_hands.calibrate(210.0, 148.0)
    else:
        assert window.opening.open_path("plane", 2.0, "porcelain", asked=True)
    wait_for(lambda: not window.both_hands.in_stroke)
    if how == "it fails":
        assert "Force feedback stopped: its cable is off" in window.status.message_label.text()
    if how == "it is gone":
        laws[-1].say(0.0, LIFTED)
        done(window)
        assert not window.document.strokes
    else:
        wait_for(lambda: len(window.document.strokes) == 1)


def test_the_button_that_touched_the_last_corner_dips_nothing(felt) -> None:
    window, laws = felt
    window.workspace.post("wipe")
    done(window)
    empty = window.document.surface.ink.load.sum()
    window.both_hands.calibrate(210.0, 148.0)
    law, n = laws[-1], len(laws)
    wait_for(
        lambda: law.settings.user_limit == 0.0, 30.0
    )  # the object pushes no hand off the sheet
    for x, y in SHEET:
        for buttons in (0, DIP):
            place = np.array([x, y, 0.0])
            law.readings.append(StylusReading(time.monotonic_ns(), place, UPRIGHT, None, buttons))
            live(0.1)
    assert len(laws) == n + 1
    for buttons in (DIP, DIP, 0):  # it is let go after the stylus was begun with anew
        laws[-1].say(0.0, LIFTED, buttons)
    done(window)
    assert window.document.surface.ink.load.sum() == empty
    assert laws[-1].clicks == 0
    wait_for(lambda: laws[-1].settings.user_limit == Feel().limit_n)
    window.both_hands.calibrate(210.0, 148.0)
    wait_for(lambda: laws[-1].settings.user_limit == 0.0)
    window.both_hands.calibrate(0.0, 0.0)  # Cancel
    wait_for(lambda: laws[-1].settings.user_limit == Feel().limit_n)


def test_what_the_mouse_locked_stays_locked_with_another_stylus_and_object(felt) -> None:
    window, laws = felt
    hands = window.both_hands.desk.hands
    hands.steering = apply_action(hands.steering, "toggle_turning")
    window.both_hands.choose_stylus("auto")
    assert window.opening.open_path("plane", 2.0, "porcelain", asked=True)
    assert window.both_hands.desk.hands is hands
    assert not hands.steering.turning
    assert laws[-1] is window.both_hands.feeling.feedback


@pytest.mark.parametrize("stylus", long_but([Inverse3StandIn], STAND_INS), indirect=True)
def test_it_is_calibrated_in_the_panel_and_paints_where_it_was_touched(window, stylus) -> None:
    """The sheet lies 20 mm to the right of where the device has its middle, and 5 mm lower."""
    form = window.panels.devices.stylus
    form.calibrate.click()
    for x, y in SHEET:
        said = form.message_label.text()
        assert "corner" in said
        for buttons in (0, 1, 0):
            stylus.hold(x + 20.0, y, -5.0, buttons)
            told = stylus.n_said()
            wait_for(lambda told=told: stylus.n_said() > told + 1)  # and that with the buttons
            live(0.1)  # for longer than a touch is held
        wait_for(lambda said=said: form.message_label.text() != said)
    assert "0.0" in form.message_label.text()
    assert not window.document.strokes  # touching paints nothing
    feeling = window.both_hands.feeling
    middle = stored_calibration(feeling.key).to_world(np.zeros(3))
    assert np.allclose(feeling.calibration.to_world(np.zeros(3)), middle)
    assert np.allclose(middle, [-20.0, 0.0, 5.0], atol=0.01)
    stylus.hold(20.0, 0.0, LIFTED)
    wait_for(lambda: window.both_hands.desk.rate_hz("right") > 0.0)


@pytest.mark.parametrize("stylus", long_but([OpenHapticsStandIn], STAND_INS), indirect=True)
def test_what_is_missing_is_said(window) -> None:
    form, kept = window.panels.devices.stylus, window.workspace.settings.stylus
    form.kind.activated.emit(form.kind.currentIndex())  # again, as it was: at the same place
    assert window.workspace.settings.stylus == kept
    assert "=" in kept
    assert window.both_hands.feeling.name in window.status.message_label.text()
    form.kind.setCurrentIndex(form.kind.findData("hid"))
    form.kind.activated.emit(form.kind.currentIndex())
    assert "f055:4a50" in window.status.message_label.text()
    assert window.workspace.settings.stylus == "hid"
    assert window.both_hands.feeling is None
    form.calibrate.click()
    assert "No stylus" in form.message_label.text()


class Caps(NoDevices):
    """Notes how caps are to be read."""

    read = None

    def set_deflection(self, deflection) -> None:
        self.read = deflection


def test_the_panel_sets_the_mouse_and_what_it_says_is_kept(program, tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path))
    caps = Caps()
    window = StudioWindow(program, Settings(), plugged=caps)
    form, hands = window.panels.devices.mouse, window.both_hands.desk.hands

    def pick(box, value) -> None:
        box.setCurrentIndex(box.findData(value))
        box.activated.emit(box.currentIndex())

    form.speed.setValue(300.0)
    form.turn.setValue(45.0)
    form.dead_zone.setValue(20.0)
    form.curve.setValue(2.0)
    form.turning.setChecked(False)
    form.dominant.setChecked(True)
    pick(form.mode, "camera")
    pick(form.zoom, "z")
    pick(form.axes[0], "-y")
    form.button.setValue(3)
    pick(form.action, "toggle_camera")
    steering = hands.steering
    assert (steering.speed_mm_s, steering.mode, steering.zoom_axis) == (300.0, "camera", "z")
    assert steering.turn_rad_s == pytest.approx(np.radians(45.0))
    assert (steering.turning, steering.moving, steering.dominant_axis) == (False, True, True)
    assert steering.order == (1, 0, 2, 3, 4, 5)  # the motion that had y has x now
    assert steering.inverted == (True, False, False, False, False, False)
    assert (caps.read.dead_zone, caps.read.curve) == (0.2, 2.0)
    kept = load_settings()[0]
    assert MouseSettings.from_dict(kept.mouse).steering() == steering
    assert kept.buttons[2] == "toggle_camera"
    again = StudioWindow(program, kept, plugged=Caps())
    assert again.panels.devices.mouse.axes[0].currentData() == "-y"
    assert again.both_hands.desk.hands.steering == steering
    close_unasked(window)
    close_unasked(again)


class Buttons(NoDevices):
    """A 6-DOF mouse whose buttons are pressed one by one."""

    def __init__(self) -> None:
        super().__init__()
        self.events: list[MouseEvent] = []

    def take_mouse(self) -> list[MouseEvent]:
        events, self.events = self.events, []
        return events

    def press(self, button: int) -> None:
        for held in (1 << button, 0):
            self.events.append(MouseEvent(time.monotonic_ns(), np.zeros(6), held))


def test_the_form_follows_what_the_mouses_buttons_lock(program, tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path))
    mouse = Buttons()
    actions = ["toggle_turning", "toggle_moving", "toggle_dominant_axis", "toggle_camera"]
    settings = Settings(buttons=dict(enumerate(actions)))
    window = StudioWindow(program, settings, plugged=mouse)
    window.show()
    assert window.opening.open_path("plane", 4.0, "porcelain", asked=True)
    form, hands = window.panels.devices.mouse, window.both_hands.desk.hands

    def shown() -> tuple[bool, bool, bool, str]:
        checks = form.turning, form.moving, form.dominant
        return *(check.isChecked() for check in checks), form.mode.currentData()

    assert shown() == (True, True, False, "object")
    for button, wanted in enumerate(
        [
            (False, True, False, "object"), (False, False, False, "object"),
            (False, False, True, "object"), (False, False, True, "camera"),
        ]
    ):  # fmt: skip
        mouse.press(button)
        wait_for(lambda wanted=wanted: shown() == wanted)
    form.speed.setValue(250.0)  # another choice leaves the locks
    assert not hands.steering.turning
    assert hands.steering.mode == "camera"
    form.turning.setChecked(True)  # and the box takes off what the button locked
    assert hands.steering.turning
    assert shown() == (True, False, True, "camera")
    close_unasked(window)


HID_STUDIO = """
import json, sys
sys.path.insert(0, ROOT)

def main():
    import numpy as np
    from paint3d.app.model.input.devices import plug_in_mice, start_feeling
    from paint3d.app.model.persistence.settings import Settings, load_settings
    from paint3d.app.window.start import make_program
    from paint3d.app.window.studio import StudioWindow
    from tests.support.app.gestures import wait_for
    from tests.support.app.windows import close_unasked, draw_little

    draw_little()
    settings = Settings(stylus="hid")
    window = StudioWindow(make_program(), settings, plugged=plug_in_mice(), feel=start_feeling)
    window.show()
    assert window.opening.open_path("plane", 1.5, "porcelain", asked=True)
    wait_for(lambda: len(window.document.strokes) == 1)
    window.stage.paint_thread.post(lambda document: None).result(300)
    surface = window.document.surface
    places = surface.paint_mesh.vertices[np.flatnonzero(surface.painted)]
    print(json.dumps({"y": float(np.median(places[:, 1])), "wide": float(np.ptp(places[:, 0])),
                      "views": [view.kind for view in window.both_hands.desk.views()]}))
    close_unasked(window)

if __name__ == "__main__":
    main()
"""


def test_the_hid_stylus_paints_in_the_window_under_the_real_hidapi(
    plugged, screen, tmp_path
) -> None:
    assert screen
    upright, z = [1.0, 0.0, 0.0, 0.0], BRUSH.length_mm - DEEP
    places = [(-15.0, 20.0, LIFTED)] * 40
    places += [(x, 20.0, z) for x in np.linspace(-15.0, 15.0, 100)]
    places += [(15.0, 20.0, LIFTED)] * 40
    script = [
        [0.008, "send", haptic_stylus.encode_pose(place, upright, 0, k).hex()]
        for k, place in enumerate(places)
    ]
    ids = haptic_stylus.VENDOR_ID, haptic_stylus.PRODUCT_ID
    program = tmp_path / "hid_studio.py"
    program.write_text(HID_STUDIO.replace("ROOT", repr(str(Path(__file__).parents[2]))))
    code = f"import runpy, sys; sys.argv = [{str(program)!r}]; runpy.run_path({str(program)!r}, "
    said = plugged(
        [device(*ids, "haptic stylus", haptic_stylus.DESCRIPTOR, script)],
        code + "run_name='__main__')",
    ).said
    assert abs(said["y"] - 20.0) < 1.0
    assert said["wide"] > 30.0
    assert said["views"] == ["stylus"]


# -- the pad of a pen --------------------------------------------------------------------------


LEFT = QtCore.Qt.MouseButton.LeftButton
NODE = HidNode("/dev/hidraw5", "hidraw", 0x056A, 0x0357, "pad", "7", 0x0D, 2, "pen")
CORNERS = ((10.0, 10.0), (190.0, 10.0), (190.0, 90.0), (10.0, 90.0))
"""Of a sheet of 180 x 80 mm on a pad of 200 x 100, by the pad's own millimetres, y up."""
TIP, BARREL, NEAR = 1, 2, 32


class PadLink:
    """A pad whose pen stays where it was put, and says so every 5 ms."""

    name, descriptor = "pad", pen()

    def __init__(self) -> None:
        self.place, self.flags, self.is_closed = (100.0, 50.0), NEAR, False
        self._said = self.place, 0, 0  # from when on, and when last, ns

    def put(self, place: tuple[float, float], flags: int) -> None:
        """Put the pen elsewhere, and wait until the pad has said so for a while."""
        self.place, self.flags = place, flags
        wait_for(lambda: self._said[0] == place and self._said[2] - self._said[1] > 150e6)

    def read(self, timeout_ms: int) -> list[tuple[int, bytes]]:
        time.sleep(0.005)
        place, now_ns = self.place, time.monotonic_ns()
        self._said = place, self._said[1] if self._said[0] == place else now_ns, now_ns
        x, y = place
        said = struct.pack(
            "<BBHHHHbbH", 7, self.flags, round(100 * x), round(100 * (100.0 - y)), 0,
            4000 * (self.flags & TIP), 0, 0, 0,
        )  # fmt: skip
        return [(now_ns, said)]

    def write(self, report: bytes) -> None:
        raise AssertionError(report)

    def close(self) -> None:
        self.is_closed = True


@pytest.fixture
def link(monkeypatch, tmp_path) -> PadLink:
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path / "config"))
    return PadLink()


@pytest.fixture
def pad_window(program, link):
    with faults() as found, opened(program, "plane", 4.0, "porcelain") as pad_window:
        pad_window.both_hands.calibrating.find_pens = lambda: PluggedDevices(
            lambda: [NODE], lambda _: link, 0.0
        )
        pad_window.panels.docks["devices"].raise_()
        live(0.05)
        form = pad_window.panels.devices.stylus
        form.width_box.setValue(180.0)
        form.depth_box.setValue(80.0)
        yield pad_window
    assert found == []


def press(button) -> None:
    QtTest.QTest.mouseClick(button, LEFT)


def touch(pad_window, link, corner, by: str) -> None:
    """Touch a corner with the tip, and say so by the pen's button or in the panel."""
    form, said = (
        pad_window.panels.devices.stylus,
        pad_window.panels.devices.stylus.message_label.text(),
    )
    link.put(corner, NEAR | TIP)
    if by == "the pen's button":
        link.flags |= BARREL
    else:
        press(form.touches)
    wait_for(lambda: form.message_label.text() != said)
    link.flags = NEAR
    live(0.03)


@pytest.mark.parametrize("by", ["the pen's button", "the panel"])
def test_four_touches_give_the_frame_and_each_error(pad_window, link, by) -> None:
    form = pad_window.panels.devices.stylus
    assert not form.touches.isEnabled()
    press(form.calibrate)
    assert form.touches.isEnabled()
    strokes = len(pad_window.document.strokes)
    pen_stroke(pad_window.canvas, (0.45, 0.5), (0.55, 0.5), [0.1, *[0.5] * 8, 0.0])
    for k, (x, y) in enumerate(CORNERS):
        touch(pad_window, link, (x + (0.8 if k == 2 else 0.0), y), by)
    settled(pad_window)
    assert len(pad_window.document.strokes) == strokes  # what the window system says of the pen too
    told = form.message_label.text()
    total, each = told.split(" mm")[0].split()[-1], told.split("(")[1].rstrip(")").split(", ")
    errors = np.array([float(error) for error in each])
    assert len(errors) == 4
    assert float(total) == pytest.approx(np.sqrt((errors**2).mean()), abs=0.01)
    assert 0.1 < float(total) < 0.5
    kept = stored_calibration("pen-056a-0357-7")
    assert np.allclose(kept.to_world(np.array([100.0, 50.0, 0.0])), 0.0, atol=0.5)
    assert link.is_closed
    assert not form.touches.isEnabled()
    pen_stroke(pad_window.canvas, (0.45, 0.5), (0.55, 0.5), [0.1, *[0.5] * 8, 0.0])
    settled(pad_window)
    assert len(pad_window.document.strokes) == strokes + 1  # it paints again


def test_a_wrong_order_is_told_and_asked_for_anew_until_it_is_cancelled(pad_window, link) -> None:
    form = pad_window.panels.devices.stylus
    press(form.calibrate)
    for k in (0, 2, 1, 3):
        touch(pad_window, link, CORNERS[k], "the panel")
    assert "expected" in form.message_label.text()
    assert "near left" in form.message_label.text()
    press(form.calibrate)  # Cancel
    assert form.message_label.text() == ""
    assert stored_calibration("pen-056a-0357-7") is None
    assert link.is_closed
    assert pad_window.canvas.tool is None


def test_what_else_takes_the_next_touch_ends_it_and_is_ended_by_it(pad_window, link) -> None:
    calibrating, drag = pad_window.both_hands.calibrating, pad_window.editing.drag
    press(pad_window.panels.devices.stylus.calibrate)
    drag.begin()
    assert not calibrating.is_on
    assert link.is_closed
    assert drag.is_on
    press(pad_window.panels.devices.stylus.calibrate)
    assert calibrating.is_on
    assert not drag.is_on
    calibrating.stop()
    assert pad_window.canvas.tool is None


def test_without_a_pad_it_is_said_why(pad_window) -> None:
    def find() -> PluggedDevices:
        plugged = PluggedDevices(list, None, 0.0)
        plugged.failures = {NODE.path: DeviceError(f"{NODE.path}: may not be opened")}
        return plugged

    form, calibrating = pad_window.panels.devices.stylus, pad_window.both_hands.calibrating
    for found, told in ((find, "/dev/hidraw5: may not be opened"), (lambda: None, "No stylus")):
        calibrating.find_pens = found
        press(form.calibrate)
        assert told in form.message_label.text()
        assert not form.touches.isEnabled()
        assert not calibrating.is_on
