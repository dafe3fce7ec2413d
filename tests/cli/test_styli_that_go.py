"""`paint3d devices` with a stylus that goes, with settings and a standard input that are none."""

from __future__ import annotations

import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

from paint3d.cli.hands import opened
from paint3d.cli.main import main
from paint3d.device import hid_nodes
from paint3d.device.force.haptic_stylus import PoseNumbers
from paint3d.device.force.port_reader import PortReader
from paint3d.errors import DeviceError
from paint3d.haptics.settings import TOUCH
from paint3d.haptics.stylus_choice import FoundStylus
from paint3d.pose.calibration import DeviceCalibration
from paint3d.recording.recording import load_recording

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
    found = FoundStylus("inverse3", "Haply", "inverse3", port, TOUCH, frame)
    monkeypatch.setattr(opened, "find_stylus", lambda _: found)
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
    reader._thread.join(60.0)
    assert "nobody thought of it" in reader.gone
    assert len(reader.take()) == 40
    assert reader.take() == []


def test_one_that_says_nothing_is_not_waited_for_for_ever() -> None:
    with pytest.raises(DeviceError, match=r"Haply said nothing within 0\.1 s; expected it to be"):
        PortReader(Going(None, 0), "Haply", 0.1)
