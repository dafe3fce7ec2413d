"""What devices sent is kept as sent, and plays back as devices."""

from __future__ import annotations

import gzip
import json
import os
import struct
import time

import numpy as np
import pytest

from paint3d.device.catalogue import find_mouse_quirks
from paint3d.device.device_log import DeviceLog, PlaybackLink, read_device_log
from paint3d.device.device_loop import DeviceLoop
from paint3d.device.force import haptic_stylus
from paint3d.device.hid_link import DeviceGoneError
from paint3d.device.hid_nodes import HidNode, kind_of
from paint3d.device.hot_plug import PluggedDevices, compare_nodes
from paint3d.device.report_timing import lateness_ms, measure_report_rate
from paint3d.device.space_mouse import DeflectionSettings, SpaceMouse
from paint3d.errors import DeviceError
from tests.support.descriptors import SPACENAVIGATOR, buttons, collection, field, pen

MS = 1_000_000
MOUSE = HidNode("/dev/hidraw0", "hidraw", 0x046D, 0xC626, "SpaceNavigator", "", 1, 8, "mouse")
STYLUS = HidNode("/dev/hidraw1", "hidraw", 0xF055, 0x4A50, "stylus", "", 0xFF00, 1, "stylus")


def poses(n: int) -> list[tuple[int, bytes]]:
    return [
        (i * MS, haptic_stylus.encode_pose([i * 0.1, 0, 30], [1, 0, 0, 0], 0, i)) for i in range(n)
    ]


def nudges(n: int) -> list[tuple[int, bytes]]:
    return [(i * 8 * MS, struct.pack("<B3h", 1, 200, 0, 0)) for i in range(n)]


def write_log(file, n: int = 40) -> None:
    log = DeviceLog(file)
    both = [(t, MOUSE, SPACENAVIGATOR, r) for t, r in nudges(n // 8)]
    both += [(t, STYLUS, haptic_stylus.DESCRIPTOR, r) for t, r in poses(n)]
    for t, node, descriptor, report in sorted(both, key=lambda entry: entry[0]):
        log.append(node, descriptor, t, report)
    assert not file.exists()
    log.close()


@pytest.mark.parametrize("name", ["hands.jsonl", "hands.jsonl.gz"])
def test_a_log_comes_back_as_devices(tmp_path, name) -> None:
    file = tmp_path / name
    write_log(file)
    links = {link.node.kind: link for link in read_device_log(file)}
    assert links["stylus"].entries == poses(40)
    assert links["mouse"].entries == nudges(5)
    assert links["mouse"].descriptor == SPACENAVIGATOR
    assert list(tmp_path.iterdir()) == [file]


def test_a_log_goes_where_a_link_leads(tmp_path) -> None:
    real, link = tmp_path / "real.jsonl", tmp_path / "link.jsonl"
    link.symlink_to(real)
    write_log(link)
    assert link.is_symlink()
    assert len(list(read_device_log(real))) == 2


def test_a_log_keeps_the_permissions_of_the_one_that_it_replaces(tmp_path) -> None:
    file = tmp_path / "hands.jsonl"
    file.write_text("old")
    file.chmod(0o600)
    DeviceLog(file).close()
    assert file.read_text() != "old"
    assert file.stat().st_mode & 0o777 == 0o600


def test_a_log_plays_in_the_program_as_it_happened(tmp_path) -> None:
    file = tmp_path / "hands.jsonl.gz"
    write_log(file, 120)
    links = {link.node.path: link for link in read_device_log(file)}
    kept = []
    devices = PluggedDevices(
        find=lambda: [link.node for link in links.values()],
        open_link=lambda node: links[node.path],
        interval_s=0.0,
        log=lambda *entry: kept.append(entry),
    )
    started = time.monotonic()
    readings, events = [], []
    while len(readings) < 120 and time.monotonic() - started < 120.0:
        time.sleep(0.01)
        readings += devices.take_stylus()
        events += devices.take_mouse()
    devices.stop()
    assert [round(r.position[0], 3) for r in readings] == [round(i * 0.1, 3) for i in range(120)]
    assert len([e for e in events if e.deflection.any()]) == 15
    assert np.allclose(np.diff([r.time_ns for r in readings]), MS, atol=1)
    assert len(kept) == 135
    assert links["log:0"].sent == [b"\x04\x01"]  # at its end it was gone
    assert time.monotonic() - started > 0.1


DAMAGE = {
    "empty": b"",
    "no JSON": b"hello\n",
    "other format": b'{"format": "x", "version": 1}\n',
    "other version": b'{"format": "paint3d-device-log", "version": 2}\n',
    "no devices": b'{"format": "paint3d-device-log", "version": 1}\n',
    "unnamed device": b'{"format": "paint3d-device-log", "version": 1}\n[1, 0, "00"]\n',
    "cut gzip": gzip.compress(b'{"format": "paint3d-device-log", "version": 1}\n' * 50)[:30],
    "long line": b'{"format": "' + b"x" * 70000 + b'"}\n',
}


@pytest.mark.parametrize("name", DAMAGE)
def test_damaged_logs_are_refused(tmp_path, name) -> None:
    file = tmp_path / "bad.jsonl"
    file.write_bytes(DAMAGE[name])
    with pytest.raises(DeviceError, match=r"bad\.jsonl"):
        read_device_log(file)


def test_times_that_run_back_are_refused(tmp_path) -> None:
    file = tmp_path / "bad.jsonl"
    write_log(file)
    lines = file.read_text().splitlines()
    lines.append(json.dumps([0, 0, "00"]))
    file.write_text("\n".join(lines))
    with pytest.raises(DeviceError, match=f"bad.jsonl:{len(lines)}: time 0"):
        read_device_log(file)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_a_log_replaces_no_pipe(tmp_path) -> None:
    os.mkfifo(tmp_path / "a.jsonl")
    with pytest.raises(DeviceError, match="it is a pipe or a device; expected a file name"):
        DeviceLog(tmp_path / "a.jsonl")
    assert (tmp_path / "a.jsonl").is_fifo()


def test_a_log_that_cannot_be_written_says_so(tmp_path) -> None:
    with pytest.raises(DeviceError, match="cannot be written"):
        DeviceLog(tmp_path / "no" / "log.jsonl")
    log = DeviceLog(tmp_path / "log.jsonl")
    log.discard()
    assert list(tmp_path.iterdir()) == []


# -- loops ------------------------------------------------------------------------------------


class FakeLink:
    """A device whose reports are given out one by one."""

    name = "fake"

    def __init__(self, descriptor: bytes, batches: list) -> None:
        self.descriptor = descriptor
        self.batches = batches
        self.sent: list[bytes] = []
        self.closed = False

    def read(self, timeout_ms: int) -> list[tuple[int, bytes]]:
        if not self.batches:
            raise DeviceGoneError("fake has gone")
        return self.batches.pop(0)

    def write(self, report: bytes) -> None:
        if not self.batches:
            raise DeviceGoneError("fake has gone")
        self.sent.append(report)

    def close(self) -> None:
        self.closed = True


def wait_until_gone(loop: DeviceLoop) -> None:
    until = time.monotonic() + 300.0
    while loop.status.gone is None:
        assert time.monotonic() < until, "it is still there"
        time.sleep(0.005)
    loop.stop()


def test_a_mouse_that_goes_leaves_at_rest() -> None:
    link = FakeLink(SPACENAVIGATOR, [nudges(2), [], [(9, b"\x99")]])
    mouse = SpaceMouse(link, find_mouse_quirks(0x046D, 0xC626))
    wait_until_gone(mouse.loop)
    events = mouse.take()
    assert [bool(e.deflection.any()) for e in events] == [True, True, False]
    assert (mouse.loop.status.n_reports, mouse.loop.status.n_refused) == (2, 1)
    assert "0x99" in mouse.loop.status.last_refusal or "153" in mouse.loop.status.last_refusal
    assert link.closed


def test_rest_is_learned_from_the_last_reports() -> None:
    resting = [[(i, struct.pack("<B3h", 1, 9, -4, 0))] for i in range(5)]
    mouse = SpaceMouse(FakeLink(SPACENAVIGATOR, resting), find_mouse_quirks(0x046D, 0xC626))
    wait_until_gone(mouse.loop)
    mouse.calibrate_rest()
    assert mouse.settings.rest[:2] == (9.0, -4.0)


def test_another_dead_zone_leaves_where_the_cap_rests() -> None:
    resting = [[(i, struct.pack("<B3h", 1, 9, -4, 0))] for i in range(5)]
    link = FakeLink(SPACENAVIGATOR, [*resting, *([[]] * 100_000)])
    devices = PluggedDevices(lambda: [MOUSE], lambda _: link, 0.0)
    (mouse,) = devices.mice()
    until = time.monotonic() + 300.0
    while mouse.loop.status.n_reports < 5 and time.monotonic() < until:
        time.sleep(0.005)
    mouse.calibrate_rest()
    devices.set_deflection(DeflectionSettings(dead_zone=0.2, curve=3.0))
    assert mouse.settings == DeflectionSettings(0.2, (9.0, -4.0, 0.0, 0.0, 0.0, 0.0), 3.0)
    devices.stop()


def test_events_that_nobody_takes_are_counted() -> None:
    link = FakeLink(b"", [[(i, b"x") for i in range(60_000)], [(i, b"x") for i in range(60_000)]])
    loop = DeviceLoop(link, lambda t, r: [t])
    wait_until_gone(loop)
    assert loop.status.n_dropped == 20_000
    assert len(loop.take()) == 100_000


def test_what_came_and_went() -> None:
    other = HidNode("/dev/hidraw1", "hidraw", 1, 2, "pen", "", 13, 2, "pen")
    changes = compare_nodes([MOUSE, STYLUS], [MOUSE, other])
    assert changes.added == (other,)
    assert changes.removed == (STYLUS,)


def test_what_a_descriptor_is_good_for() -> None:
    plain = collection(1, 2, field(1, [0x30, 0x31], 8, -127, 127, flags=6) + buttons(3, 8))
    found = [kind_of(d) for d in (SPACENAVIGATOR, haptic_stylus.DESCRIPTOR, pen(), plain, b"\x01")]
    assert found == ["mouse", "stylus", "pen", "other", "other"]


# -- rates ------------------------------------------------------------------------------------


def test_the_rate_of_a_device() -> None:
    times = np.concatenate([np.arange(100) * 8 * MS, 10**10 + np.arange(100) * 8 * MS])
    rate = measure_report_rate(times)
    assert rate.rate_hz == pytest.approx(125.0)
    assert (rate.n, rate.pauses) == (200, 1)
    assert measure_report_rate([5]).rate_hz == 0.0


def test_lateness_is_that_of_the_reader() -> None:
    rng = np.random.default_rng(1)
    number = np.arange(65_000, 67_000)
    late = rng.exponential(0.2, len(number))
    found = lateness_ms((number * MS + late * MS).astype(np.int64), number & 0xFFFF)
    assert np.abs(found - late).max() < 0.05


def test_playback_ends_as_a_device_does() -> None:
    now = [0]
    link = PlaybackLink(STYLUS, b"", poses(3), now_ns=lambda: now[0])
    assert len(link.read(0)) == 1
    now[0] = 2 * MS
    assert [t for t, _ in link.read(0)] == [MS, 2 * MS]
    with pytest.raises(DeviceGoneError, match="over"):
        link.read(0)
