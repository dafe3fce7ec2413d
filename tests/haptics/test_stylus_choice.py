"""Which stylus is found, by what is there and what was chosen."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from paint3d.device import hid_nodes
from paint3d.device.force.inverse3 import Inverse3Port
from paint3d.errors import DeviceError, InputError
from paint3d.haptics import stylus_choice
from paint3d.haptics.stylus_choice import check_stylus, find_stylus


def missing(name: str) -> SimpleNamespace:
    raise DeviceError(f"hidapi's module {name!r} cannot be loaded")


def test_without_hidapi_the_others_are_looked_for(monkeypatch) -> None:
    monkeypatch.setattr(hid_nodes, "backend_module", missing)
    monkeypatch.setattr(Inverse3Port, "is_served", lambda self: True)
    monkeypatch.setattr(Inverse3Port, "read_name", lambda self: "0A 1")
    found = find_stylus("auto")
    assert (found.kind, found.key) == ("inverse3", "inverse3-0a-1")
    monkeypatch.setattr(Inverse3Port, "is_served", lambda self: False)
    assert find_stylus("auto") is None
    with pytest.raises(DeviceError, match="cannot be loaded"):
        find_stylus("hid")


def test_one_that_is_there_and_does_not_answer_is_passed_over(monkeypatch, caplog) -> None:
    def asleep(self) -> str:
        raise DeviceError("it sleeps")

    monkeypatch.setattr(hid_nodes, "backend_module", lambda _: SimpleNamespace(enumerate=list))
    monkeypatch.setattr(Inverse3Port, "is_served", lambda self: True)
    monkeypatch.setattr(Inverse3Port, "read_name", asleep)
    assert find_stylus("auto") is None
    assert "it sleeps" in caplog.text
    assert find_stylus("none") is None


def test_a_name_of_openhaptics_is_no_file_and_a_file_is_no_name(monkeypatch) -> None:
    opened = []
    monkeypatch.setattr(
        stylus_choice.OpenHapticsPort,
        "read_limits",
        lambda self: opened.append((self.name, self.library)) or (2.0, None),
    )
    for choice in ("openhaptics=Left Arm", "openhaptics=/opt/libHD.so", "openhaptics"):
        found = find_stylus(choice)
        assert (found.limits.max_force, found.limits.max_stiffness) == (2.0, 0.4)
    assert opened == [("Left Arm", "libHD.so"), ("", "/opt/libHD.so"), ("", "libHD.so")]
    assert find_stylus("openhaptics=Left Arm").key == "openhaptics-left-arm"


@pytest.mark.parametrize("choice", ["", "pen", "hid=/dev/hidraw3", "inverse3=", "auto=1", 5, None])
def test_what_cannot_be_chosen_is_named(choice) -> None:
    with pytest.raises(InputError, match="expected auto, hid, openhaptics"):
        check_stylus(choice)
