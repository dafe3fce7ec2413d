"""`paint3d devices` with styli that are reached by a library or a service."""

from __future__ import annotations

import io
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest

from paint3d.cli.main import main
from paint3d.device import hid_nodes
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
