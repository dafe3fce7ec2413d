"""`paint3d devices` with styli that are reached by a library or a service."""

from __future__ import annotations

import io
import os
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from paint3d.cli import devices
from paint3d.cli.main import main
from paint3d.device import hid_nodes
from paint3d.device.force.haptic_stylus import PoseNumbers
from paint3d.device.force.port_reader import PortReader
from paint3d.errors import DeviceError
from paint3d.haptics.settings import TOUCH
from paint3d.haptics.stylus_choice import DetectedStylus
from paint3d.pose.calibration import DeviceCalibration, load_calibration
from paint3d.recording.recording import load_recording
from tests.support.styli import Inverse3StandIn, OpenHapticsStandIn

SHEET = ((-105.0, -74.0), (105.0, -74.0), (105.0, 74.0), (-105.0, 74.0))


def nothing_plugged(_: str) -> SimpleNamespace:
    """Stands in for hidapi on a machine without devices, whatever is plugged into this one."""
    return SimpleNamespace(enumerate=list)


@pytest.fixture(params=[OpenHapticsStandIn, Inverse3StandIn])
def stylus(request, tmp_path, monkeypatch):
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path / "config"))
    monkeypatch.setattr(hid_nodes, "backend_module", nothing_plugged)
    stylus = request.param(tmp_path)
    for name, value in stylus.environment.items():
        monkeypatch.setenv(name, value)
    yield stylus
    stylus.close()


class Hand(io.StringIO):
    """Reads what is asked for, and touches corners of a sheet whose middle lies at (20, 0, -5)."""

    def __init__(self, stylus, places) -> None:
        super().__init__()
        self.stylus, self.places, self.over = stylus, places, threading.Event()
        self.thread = threading.Thread(target=self.touch, daemon=True)

    def touch(self) -> None:
        while not self.over.is_set():
            asked = self.getvalue().count("touch ") - 1
            if asked < 0:
                self.over.wait(0.01)
                continue
            x, y = self.places[min(asked, len(self.places) - 1)]
            for buttons in (0, 1, 0):
                self.stylus.hold(x + 20.0, y, -5.0, buttons)
                self.over.wait(0.25)


def calibrate(stylus, places, monkeypatch) -> tuple[int, list[str]]:
    """Run the command with a hand at it: its exit status and messages."""
    stylus.hold(0.0, 0.0, 50.0)
    hand = Hand(stylus, places)
    hand.thread.start()
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stderr", hand)
        patch.setattr(sys, "stdin", io.StringIO())
        code = main(["devices", "calibrate", "--stylus", stylus.choice])
    hand.over.set()
    hand.thread.join()
    return code, hand.getvalue().splitlines()


def test_it_is_listed_calibrated_and_recorded_where_it_was_touched(
    stylus, tmp_path, capsys, monkeypatch
) -> None:
    choice = ["--stylus", stylus.choice]
    assert main(["devices", "list", *choice]) == 0
    assert f"{stylus.limits[0]:g} N: ready" in capsys.readouterr().out
    stylus.hold(20.0, 10.0, 30.0)
    file = tmp_path / "hand.jsonl"
    assert main(["devices", "record", str(file), "--seconds", "0.3", *choice]) == 0
    assert np.allclose(load_recording(file).position, [20.0, 10.0, 30.0], atol=0.05)  # z is up
    capsys.readouterr()
    code, said = calibrate(stylus, [SHEET[k] for k in (0, 2, 1, 3)], monkeypatch)
    assert code == 2
    assert said[0].startswith("touch 1 of 4: the near left corner (-105, -74, 0) mm")
    assert "lie 256.9 mm apart, their points 210.0; expected within" in said[-1]
    code, said = calibrate(stylus, [SHEET[0], *SHEET], monkeypatch)  # the first one twice
    assert code == 0
    assert said[2].startswith("point 2 was touched 0.00 mm from point 1; expected at least 10")
    out = capsys.readouterr().out
    assert "config/calibrations/" in out
    assert float(out.split(": ")[1].split(" mm")[0]) < 0.05
    stylus.hold(20.0, 10.0, 30.0)
    assert main(["devices", "record", str(file), "--seconds", "0.3", *choice, "--force"]) == 0
    recording = load_recording(file)
    assert np.allclose(recording.position, [0.0, 10.0, 35.0], atol=0.05)
    assert main(["devices", "check", "--seconds", "0.5", *choice]) == 0
    assert " Hz, interval" in capsys.readouterr().out
    log = ["--raw", str(tmp_path / "raw.jsonl"), "--force"]
    assert main(["devices", "record", str(file), "--seconds", "0.1", *choice, *log]) == 2
    assert "--raw keeps HID reports" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("choice", "needs"),
    [
        ("hid", "f055:4a50"),
        ("openhaptics", "install 3D Systems' OpenHaptics"),
        ("openhaptics=/nowhere/libHD.so", "/nowhere/libHD.so"),
        ("inverse3=ws://127.0.0.1:9", "comes with Haply's software"),
        ("pen", "expected auto, hid, openhaptics, inverse3, none"),
    ],
)
def test_what_is_missing_is_named_in_one_line(choice, needs, monkeypatch, capsys) -> None:
    monkeypatch.setattr(hid_nodes, "backend_module", nothing_plugged)
    for deed in ("list", "watch", "check", "calibrate"):
        assert main(["devices", deed, "--stylus", choice]) == 2
        said = capsys.readouterr().err
        assert needs in said
        assert said.count("\n") == 1


# -- a stylus that goes ------------------------------------------------------------------------


UPRIGHT = (1.0, 0.0, 0.0, 0.0)


class Going:
    """A port that says some poses, 2 ms apart, and ends so."""

    def __init__(self, end: Exception | None, n: int = 40) -> None:
        self.end, self.n = end, n

    def run(self, loop) -> None:
        for k in range(self.n):
            now = time.monotonic_ns()
            loop.step(PoseNumbers(now, (0.1 * k, 0.0, 30.0), UPRIGHT, 0, 0), now)
            time.sleep(0.002)
        if self.end is not None:
            raise self.end
        while not loop.stopped():
            time.sleep(0.002)


@pytest.fixture
def going(tmp_path, monkeypatch):
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path / "config"))
    monkeypatch.setattr(hid_nodes, "backend_module", lambda _: SimpleNamespace(enumerate=list))
    port, frame = Going(DeviceError("its cable is off")), DeviceCalibration()
    found = DetectedStylus("inverse3", "Haply", "inverse3", port, TOUCH, frame)
    monkeypatch.setattr(devices, "find_stylus", lambda _: found)
    return tmp_path


def test_what_was_recorded_before_it_went_is_kept_and_why_is_said(going, capsys) -> None:
    file = going / "hand.jsonl"
    assert main(["devices", "record", str(file), "--seconds", "0.4"]) == 0
    assert capsys.readouterr().err == "its cable is off\n"
    assert np.ptp(load_recording(file).position[:, 0]) > 3.0
    assert main(["devices", "watch", "--seconds", "0.4"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "its cable is off"
    assert main(["devices", "check", "--seconds", "0.4"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "its cable is off"
    assert main(["devices", "calibrate"]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == "paint3d: error: its cable is off"


def test_settings_that_were_set_aside_are_told(going, capsys) -> None:
    (going / "config").mkdir()
    (going / "config" / "settings.json").write_text("{")
    assert main(["devices", "watch", "--seconds", "0.1"]) == 0
    assert "it was kept as settings.bad-" in capsys.readouterr().err


def test_without_a_standard_input_only_the_button_touches(going, capsys, monkeypatch) -> None:
    monkeypatch.setattr(sys, "stdin", None)  # as Python has it where the shell closed it: <&-
    assert main(["devices", "calibrate"]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == "paint3d: error: its cable is off"


def test_a_port_that_breaks_is_told_and_not_waited_for() -> None:
    fault = ZeroDivisionError("nobody thought of it")
    with pytest.raises(DeviceError, match=r"Haply failed: ZeroDivisionError\('nobody"):
        PortReader(Going(fault, 0), "Haply", 5.0)
    reader = PortReader(Going(fault), "Haply", 60.0)
    until = time.monotonic() + 300.0
    while reader.gone is None and time.monotonic() < until:
        time.sleep(0.005)
    assert "nobody thought of it" in reader.gone
    assert len(reader.take()) == 40
    assert reader.take() == []


def test_one_that_says_nothing_is_not_waited_for_for_ever() -> None:
    with pytest.raises(DeviceError, match=r"Haply sent nothing within 0\.1 s; expected it to be"):
        PortReader(Going(None, 0), "Haply", 0.1)


class Held:
    """A port that is held where it is asked for next, at half the size, and never presses."""

    def __init__(self, points, asked) -> None:
        self.points, self.asked = 0.5 * np.array(points), asked

    def run(self, loop) -> None:
        while not loop.stopped():
            now, n = time.monotonic_ns(), self.asked() - 1
            place = self.points[min(max(n, 0), len(self.points) - 1)]
            loop.step(PoseNumbers(now, tuple(place.tolist()), UPRIGHT, 0, 0), now)
            time.sleep(0.002)


def test_points_of_ones_own_are_touched_by_enter_scaled_into_a_file(
    going, monkeypatch, capsys
) -> None:
    points = [(-90.0, 0.0, 5.0), (90.0, 0.0, 5.0), (0.0, 60.0, 40.0)]
    reads, writes = os.pipe()

    class Hand(io.StringIO):
        def write(self, text: str) -> int:
            n = super().write(text)
            if text.startswith("touch "):
                threading.Timer(0.3, os.write, (writes, b"\n")).start()
            return n

    hand = Hand()
    port = Held(points, lambda: hand.getvalue().count("touch "))
    found = DetectedStylus("inverse3", "Haply", "inverse3", port, TOUCH, DeviceCalibration())
    monkeypatch.setattr(devices, "find_stylus", lambda _: found)
    monkeypatch.setattr(sys, "stderr", hand)
    monkeypatch.setattr(sys, "stdin", os.fdopen(reads))
    asked = [f"--point={x:g},{y:g},{z:g}" for x, y, z in points]
    file = going / "own.json"
    assert main(["devices", "calibrate", *asked, "--scaled", "--out", str(file)]) == 0
    os.close(writes)
    assert "touch 1 of 3: the point 1 (-90, 0, 5) mm" in hand.getvalue()
    own = load_calibration(file)
    assert own.scale == pytest.approx(2.0)
    assert np.allclose(own.to_world(0.5 * np.array(points)), points)
    assert np.allclose(own.to_device(np.array(points)), 0.5 * np.array(points))
    assert not (going / "config" / "calibrations").exists()
