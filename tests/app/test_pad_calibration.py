"""The pad of a pen is calibrated in the panel: corners touched, the error seen, the frame used."""

from __future__ import annotations

import struct
import time

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from paint3d.app.model.persistence.settings import kept_calibration
from paint3d.device.hid_nodes import HidNode
from paint3d.device.hot_plug import PluggedDevices
from tests.support.app.gestures import live, pen_stroke, wait_for
from tests.support.app.windows import faults, opened, settled
from tests.support.descriptors import pen

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

    def read(self, timeout_ms: int) -> list[tuple[int, bytes]]:
        time.sleep(0.005)
        x, y = self.place
        said = struct.pack(
            "<BBHHHHbbH", 7, self.flags, round(100 * x), round(100 * (100.0 - y)), 0,
            4000 * (self.flags & TIP), 0, 0, 0,
        )  # fmt: skip
        return [(time.monotonic_ns(), said)]

    def write(self, report: bytes) -> None:
        raise AssertionError(report)

    def close(self) -> None:
        self.is_closed = True


@pytest.fixture
def link(monkeypatch, tmp_path) -> PadLink:
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path / "config"))
    return PadLink()


@pytest.fixture
def window(program, link):
    with faults() as found, opened(program, "plane", 4.0, "porcelain") as window:
        window.both_hands.calibrating.find_pens = lambda: PluggedDevices(
            lambda: [NODE], lambda _: link, 0.0
        )
        window.panels.docks["devices"].raise_()
        live(0.05)
        form = window.panels.devices.stylus
        form.width_box.setValue(180.0)
        form.depth_box.setValue(80.0)
        yield window
    assert found == []


def press(button) -> None:
    QtTest.QTest.mouseClick(button, LEFT)


def touch(window, link, corner, by: str) -> None:
    """Touch a corner with the tip, and say so by the pen's button or in the panel."""
    form, said = window.panels.devices.stylus, window.panels.devices.stylus.told.text()
    link.place, link.flags = corner, NEAR | TIP
    live(0.15)
    if by == "the pen's button":
        link.flags |= BARREL
    else:
        press(form.touches)
    wait_for(lambda: form.told.text() != said)
    link.flags = NEAR
    live(0.03)


@pytest.mark.parametrize("by", ["the pen's button", "the panel"])
def test_four_touches_give_the_frame_and_each_error(window, link, by) -> None:
    form = window.panels.devices.stylus
    assert not form.touches.isEnabled()
    press(form.calibrate)
    assert form.touches.isEnabled()
    strokes = len(window.document.strokes)
    pen_stroke(window.canvas, (0.45, 0.5), (0.55, 0.5), [0.1, *[0.5] * 8, 0.0])
    for k, (x, y) in enumerate(CORNERS):
        touch(window, link, (x + (0.8 if k == 2 else 0.0), y), by)
    settled(window)
    assert len(window.document.strokes) == strokes  # what the window system says of the pen too
    told = form.told.text()
    total, each = told.split(" mm")[0].split()[-1], told.split("(")[1].rstrip(")").split(", ")
    errors = np.array([float(error) for error in each])
    assert len(errors) == 4
    assert float(total) == pytest.approx(np.sqrt((errors**2).mean()), abs=0.01)
    assert 0.1 < float(total) < 0.5
    kept = kept_calibration("pen-056a-0357-7")
    assert np.allclose(kept.to_world(np.array([100.0, 50.0, 0.0])), 0.0, atol=0.5)
    assert link.is_closed
    assert not form.touches.isEnabled()
    pen_stroke(window.canvas, (0.45, 0.5), (0.55, 0.5), [0.1, *[0.5] * 8, 0.0])
    settled(window)
    assert len(window.document.strokes) == strokes + 1  # it paints again


def test_a_wrong_order_is_told_and_asked_for_anew_until_it_is_cancelled(window, link) -> None:
    form = window.panels.devices.stylus
    press(form.calibrate)
    for k in (0, 2, 1, 3):
        touch(window, link, CORNERS[k], "the panel")
    assert "expected" in form.told.text()
    assert "near left" in form.told.text()
    press(form.calibrate)  # Cancel
    assert form.told.text() == ""
    assert kept_calibration("pen-056a-0357-7") is None
    assert link.is_closed
    assert window.canvas.tool is None


def test_what_else_takes_the_next_touch_ends_it_and_is_ended_by_it(window, link) -> None:
    calibrating, drag = window.both_hands.calibrating, window.editing.drag
    press(window.panels.devices.stylus.calibrate)
    drag.begin()
    assert not calibrating.is_on
    assert link.is_closed
    assert drag.is_waiting
    press(window.panels.devices.stylus.calibrate)
    assert calibrating.is_on
    assert not drag.is_waiting
    calibrating.stop()
    assert window.canvas.tool is None


def test_without_a_pad_it_is_said_why(window) -> None:
    def find() -> PluggedDevices:
        plugged = PluggedDevices(list, None, 0.0)
        plugged.failures = {NODE.path: f"{NODE.path}: may not be opened"}
        return plugged

    form, calibrating = window.panels.devices.stylus, window.both_hands.calibrating
    for found, told in ((find, "/dev/hidraw5: may not be opened"), (lambda: None, "No stylus")):
        calibrating.find_pens = found
        press(form.calibrate)
        assert told in form.told.text()
        assert not form.touches.isEnabled()
        assert not calibrating.is_on
