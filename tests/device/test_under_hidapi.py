"""Every device path under the real hidapi, with no hardware."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest

from paint3d.device.device_log import read_device_log
from paint3d.device.force import haptic_stylus
from paint3d.painter.painter import Painter
from paint3d.painter.recorded_tools import eraser_runs
from paint3d.recording.recording import load_recording
from paint3d.surface.painted_surface import PaintedSurface
from scripts.solids import make_plane
from tests.support.descriptors import SPACENAVIGATOR, combined_mouse, pen
from tests.support.plugged import device

MOVE = ["<B3h", 1, 300, 0, -50]
POSE = ["<BiiihhhhBBH", 1, "i", 0, 30000, 16384, 0, 0, 0, 0, 0, "i16"]


def ramp(n: int, hz: float, report: list) -> list:
    return [0.0, "ramp", {"n": n, "hz": hz, "report": json.dumps(report)}]


def mouse(script: list, **more) -> dict:
    return device(0x046D, 0xC626, "Navigator", SPACENAVIGATOR, script, **more)


def stylus(script: list, **more) -> dict:
    ids = (haptic_stylus.VENDOR_ID, haptic_stylus.PRODUCT_ID)
    return device(*ids, "haptic stylus", haptic_stylus.DESCRIPTOR, script, **more)


OPEN_MOUSE = """
import json, time
from paint3d.device.hid_link import DeviceGoneError, open_node
from paint3d.device.hid_nodes import list_nodes
from paint3d.device.six_dof import MouseReading, find_mouse_layout
from paint3d.device.descriptor import parse_descriptor
(node,) = list_nodes()
link = open_node(node)
layout = find_mouse_layout(parse_descriptor(link.descriptor))
link.write(layout.encode_light(True))
reading, n, gone, end = MouseReading(), 0, "", time.monotonic() + 120
while time.monotonic() < end and n < WANTED:
    try:
        for t, report in link.read(500):
            reading = layout.decode(report, reading)
            n += 1
    except DeviceGoneError as cause:
        gone = str(cause)
        break
try:
    link.write(layout.encode_light(False))
except DeviceGoneError as cause:
    gone += " / " + str(cause)
link.close()
print(json.dumps({"node": [node.path, node.backend, node.name, node.kind],
                  "n": n, "axes": reading.axes, "gone": gone}))
"""


@pytest.mark.parametrize(
    ("more", "node"),
    [
        ({}, ["/dev/hidraw0", "hidraw", "SpaceNavigator", "mouse"]),
        ({"backend": "usb"}, ["1-2:1.0", "hid", "SpaceNavigator", "mouse"]),
    ],
    ids=["hidraw", "libusb"],
)
def test_enumerate_open_descriptor_input_output(plugged, more, node) -> None:
    turn = [0.0, "send", struct.pack("<B3h", 2, 7, -8, 9).hex()]
    outcome = plugged(
        [mouse([ramp(25, 250.0, MOVE), turn], **more)], OPEN_MOUSE.replace("WANTED", "26")
    )
    assert outcome.said == {
        "node": node,
        "n": 26,  # with libusb, hidapi keeps no more than 30 for a program that is busy
        "axes": [300, 0, -50, 7, -8, 9],
        "gone": "",
    }
    assert outcome.written == [[b"\x04\x01", b"\x04\x00"]]


@pytest.mark.parametrize("backend", ["hidraw", "usb"])
def test_unplugged_while_reading(plugged, backend) -> None:
    script = [ramp(25, 250.0, MOVE), [0.1, "unplug", None]]
    outcome = plugged([mouse(script, backend=backend)], OPEN_MOUSE.replace("WANTED", "10000"))
    assert outcome.said["n"] == 25
    assert "SpaceNavigator has gone" in outcome.said["gone"]
    assert outcome.said["gone"].count("has gone") == 2  # reading and writing both say so


def test_the_queue_is_drained(plugged) -> None:
    code = """
import json, time
from paint3d.device.hid_link import open_node
from paint3d.device.hid_nodes import list_nodes
link = open_node(list_nodes()[0])
link.write(b"\\x04\\x01")
reads, end = [], time.monotonic() + 120
while sum(map(len, reads)) < 60 and time.monotonic() < end:
    time.sleep(0.3)  # a busy program, in which tens of reports come
    reads.append(link.read(0))
late = [report for read in reads for _, report in read]
print(json.dumps([len(late), late[-1].hex(), max(map(len, reads)), len(link.read(0))]))
"""
    outcome = plugged([mouse([ramp(60, 200.0, ["<B3h", 1, "i16", 0, 0])])], code)
    n, newest, at_once, left = outcome.said
    assert (n, newest, left) == (60, struct.pack("<B3h", 1, 59, 0, 0).hex(), 0)
    assert at_once > 5


BOTH = """
import json, time
from paint3d.device.hot_plug import PluggedDevices
from paint3d.pose.two_hands import TwoHands
from paint3d.pose.steering import SteeringOptions
devices = PluggedDevices(interval_s=0.0)
hands = TwoHands(steering=SteeringOptions(speed_mm_s=100.0), time_ns=time.monotonic_ns())
for stylus in devices.styli():
    stylus.loop.write(b"\\x02" + bytes(8))
samples, end = [], time.monotonic() + LIMIT
while not (ENDS) and time.monotonic() < end:
    time.sleep(0.02)
    for event in devices.take_mouse():
        hands.add_deflection(event.time_ns, event.deflection)
    hands.add_stylus(devices.take_stylus())
    samples += hands.take(time.monotonic_ns() - 1_000_000)
status = [[d.loop.status.n_reports, d.loop.status.n_refused, d.loop.status.gone]
          for d in devices.mice() + devices.styli()]
lost = [s.lost for s in devices.styli()]
x = [round(s.position[0] * 1000) for s in samples]
gaps = [b.time_ns - a.time_ns for a, b in zip(samples, samples[1:])]
print(json.dumps({"status": status, "x": x, "lost": lost, "late": hands.late,
                  "object": samples[-1].object_position.tolist() if samples else None,
                  "least_gap": min(gaps, default=None),
                  "failures": {path: str(why) for path, why in devices.failures.items()}}))
devices.stop()
"""


def both_until(ends: str, limit_s: float = 120.0) -> str:
    """The program, which ends when something holds, or when it has waited so long for it."""
    return BOTH.replace("LIMIT", str(limit_s)).replace("ENDS", ends)


def test_both_hands_at_once(plugged) -> None:
    outcome = plugged(
        [mouse([ramp(125, 125.0, MOVE)]), stylus([ramp(1000, 1000.0, POSE)])],
        both_until("len(samples) == 1000 and devices.mice()[0].loop.status.n_reports == 125"),
    )
    said = outcome.said
    assert said["status"] == [[125, 0, None], [1000, 0, None]]
    assert said["x"] == list(range(1000))  # no sample lost, none twice, all in order
    assert said["lost"] == [0]
    assert said["least_gap"] > 0
    assert 50.0 < said["object"][0] < 130.0  # a second and 0.15 s at some 3/4 of 100 mm/s
    assert outcome.written[0] == [b"\x04\x01", b"\x04\x00"]
    assert outcome.written[1][-1] == haptic_stylus.encode_force([0, 0, 0])


def test_unplugged_in_the_middle_of_a_stroke_and_plugged_in_again(plugged) -> None:
    script = [ramp(300, 1000.0, POSE), [0.35, "unplug", None], [1.35, "plug", None]]
    code = (
        both_until("len(samples) == 300 and seen == {0, 1} and devices.styli()")
        .replace("interval_s=0.0", "interval_s=0.1")
        .replace("samples +=", "seen.add(len(devices.styli())); samples +=")
        .replace("samples, end", "seen = set(); samples, end")
        .replace('"late":', '"seen": sorted(seen), "late":')
    )
    said = plugged([stylus(script)], code).said
    assert said["x"] == list(range(300))  # what was drawn before stays
    assert said["seen"] == [0, 1]
    assert len(said["status"]) == 1  # and the device is there again


def test_a_device_that_sends_garbage(plugged) -> None:
    good = struct.pack("<BiiihhhhBBH", 1, 0, 0, 30000, 16384, 0, 0, 0, 0, 0, 1).hex()
    bad = ["ff" * 25, "01", "01" + "00" * 24, "0200", good[:-2]]
    script = [[0.0, "send", report] for report in [good, *bad]]
    said = plugged(
        [stylus(script)], both_until("samples and devices.styli()[0].loop.status.n_refused == 5")
    ).said
    assert said["status"] == [[1, 5, None]]
    assert len(said["x"]) == 1


def test_a_device_that_stalls(plugged) -> None:
    script = [ramp(20, 125.0, MOVE)]  # and then nothing, far from rest
    beat = stylus([ramp(900, 1000.0, POSE)])
    code = both_until("len(samples) == 900").replace(
        '"late":', '"moved": [s.object_position[0] for s in samples[-400:]], "late":'
    )
    said = plugged([mouse(script), beat], code).said
    assert len(said["x"]) == 900
    assert max(said["moved"]) - min(said["moved"]) < 1e-9  # silence means zero
    assert said["moved"][0] > 5.0


def test_a_descriptor_that_is_garbage(plugged) -> None:
    broken = SPACENAVIGATOR[:40]  # enumerates as a mouse, cannot be decoded
    said = plugged(
        [device(0x046D, 0xC626, "broken", broken, [])],
        both_until("False", 0.2),
    ).said
    assert said["status"] == []
    assert "never end" in said["failures"].get("/dev/hidraw0", "never ends: not listed")


def test_the_node_that_sends_is_taken(plugged) -> None:
    receiver = device(
        0x256F,
        0xC652,
        "Receiver",
        combined_mouse(),
        [ramp(50, 100.0, ["<B6h", 1, 0, 200, 0, 0, 0, 0])],
    )
    cable = mouse([ramp(50, 100.0, ["<B3h", 1, 0, 0, 0])])
    said = plugged(
        [receiver, cable, stylus([ramp(700, 1000.0, POSE)])], both_until("len(samples) == 700")
    ).said
    assert said["object"][1] < -5.0  # the receiver's mouse pulled the object near
    assert said["object"][0] == 0.0


PENS = """
import json, time
from paint3d.device.hot_plug import PluggedDevices
devices = PluggedDevices(interval_s=0.0)
end, readings = time.monotonic() + 120, []
while time.monotonic() < end and not readings:
    time.sleep(0.05)
    readings += devices.take_stylus()
print(json.dumps([[r.position.tolist(), r.pressure, r.buttons] for r in readings]))
"""


def test_a_generic_pen(plugged) -> None:
    report = struct.pack("<BBHHHHbbH", 7, 1 | 32, 5000, 2500, 0, 8191, 0, 0, 0).hex()
    script = [[0.0, "send", report]]
    said = plugged([device(0x1234, 0x5678, "tablet", pen(), script, starts="open")], PENS).said
    assert said == [[[50.0, 75.0, 0.0], 1.0, 0]]


NO_PERMISSION = """
import json, os, sys
sys.dont_write_bytecode = True
from paint3d.device import hid_link, hid_nodes
hid_nodes.list_nodes()  # everything is loaded before the rights go
if os.getuid() == 0:
    os.setuid(65534)
(node,) = hid_nodes.list_nodes()
try:
    hid_link.open_node(node)
except Exception as failure:
    print(json.dumps([type(failure).__name__, str(failure), node.kind]))
"""


@pytest.mark.parametrize(
    ("more", "rule"),
    [
        ({}, 'KERNEL=="hidraw*", KERNELS=="*:046D:C626.*", TAG+="uaccess"'),
        (
            {"backend": "usb"},
            'SUBSYSTEM=="usb", ATTR{idVendor}=="046d", ATTR{idProduct}=="c626", TAG+="uaccess"',
        ),
    ],
    ids=["hidraw", "libusb"],
)
def test_what_may_not_be_opened_names_node_and_rule(plugged, more, rule) -> None:
    said = plugged([mouse([], mode=0o000, **more)], NO_PERMISSION).said
    assert said[0] == "PermissionNeededError"
    assert rule in said[1]
    assert ("/dev/hidraw0" if not more else "1-2:1.0") in said[1]
    assert "70-paint3d.rules" in said[1]
    assert said[2] == "mouse"


# -- force ------------------------------------------------------------------------------------

FEEL = """
import json, os, signal, sys, time
from paint3d.brush.presets import load_brush
from paint3d.device.force.force_port import HidForcePort
from paint3d.device.hid_nodes import list_nodes
from paint3d.haptics.servo import ForceFeedback
from paint3d.haptics.settings import HapticSettings
from scripts.solids import make_plane
from paint3d.surface.painted_surface import PaintedSurface

def main():
    tree = PaintedSurface(make_plane(), resolution=None).contact_tree
    settings = HapticSettings.for_brush(load_brush("full"), rise_s=0.1)
    (node,) = list_nodes()
    with ForceFeedback(HidForcePort(node), tree, settings) as feedback:
        end, readings = time.monotonic() + 100, []
        while time.monotonic() < end and feedback.is_running() and len(readings) != WANTED:
            feedback.publish()
            readings += feedback.take()
            if KILLED and len(readings) > 600:
                os.kill(feedback.process_id, signal.SIGKILL)
                while feedback.is_running():
                    time.sleep(0.001)
                break
            time.sleep(0.01)
        readings += feedback.take()
        status = feedback.status()
    print(json.dumps({"n": len(readings), "state": status.state, "fault": status.fault,
                      "refused": status.refused, "softening": float(status.softening)}))

if __name__ == "__main__":
    main()
"""
LIFTED = ["<BiiihhhhBBH", 1, 0, 0, 60000, 16384, 0, 0, 0, 0, 0, "i16"]
PRESSED = ["<BiiihhhhBBH", 1, 0, 0, 29000, 16384, 0, 0, 0, 0, 0, "i16"]


def forces(written: list[bytes]) -> np.ndarray:
    return np.array([haptic_stylus.decode_force(report)[0] for report in written])


def feel(plugged, tmp_path, script: list, wanted: int | None = None, kill: bool = False):
    """Run the servo on a virtual HID stylus until it ends, or until so many readings have come.

    It must lie in a file, as its process is spawned.
    """
    program = tmp_path / "feel.py"
    program.write_text(FEEL.replace("WANTED", str(wanted)).replace("KILLED", str(kill)))
    code = f"import runpy, sys; sys.argv = [{str(program)!r}]; runpy.run_path({str(program)!r}, "
    code += "run_name='__main__')"
    return plugged([stylus(script)], code)


def test_the_hid_stylus_pushes_back(plugged, tmp_path) -> None:
    script = [ramp(50, 1000.0, LIFTED), ramp(700, 1000.0, PRESSED)]
    outcome = feel(plugged, tmp_path, script, 750)
    felt = forces(outcome.written[0])
    assert (outcome.said["n"], outcome.said["refused"]) == (750, 0)
    assert outcome.said["state"] == "running"
    assert 0.1 < felt[:, 2].max() <= 2.7086  # softer where the machine is late too often
    assert np.abs(felt[:, :2]).max() == 0.0
    assert not felt[-1].any()


def test_the_hid_stylus_is_unplugged_while_it_pushes(plugged, tmp_path) -> None:
    script = [ramp(50, 1000.0, LIFTED), ramp(300, 1000.0, PRESSED), [0.0, "unplug", None]]
    outcome = feel(plugged, tmp_path, script)
    assert outcome.said["state"] == "failed"
    assert "has gone" in outcome.said["fault"]
    assert outcome.said["n"] == 350  # what was drawn before stays
    assert forces(outcome.written[0])[:, 2].max() > 0.0


def test_a_servo_that_is_killed_is_spoken_for(plugged, tmp_path) -> None:
    script = [ramp(50, 1000.0, LIFTED), ramp(1500, 1000.0, PRESSED)]
    outcome = feel(plugged, tmp_path, script, kill=True)
    felt = forces(outcome.written[0])
    assert outcome.said["state"] == "failed"
    assert felt[:, 2].max() > 0.1
    assert not felt[-1].any()  # the program told the device to rest


STUDIO = """
import json, time
from paint3d.app.model.input.devices import DeviceHub, StrokeCutter
from paint3d.app.model.input.devices import plug_in_mice
from paint3d.device.hid_link import open_node
from paint3d.device.hid_nodes import list_nodes
pens = list_nodes(("pen",))
other = open_node(pens[0])  # it may be opened, and the pen is pressed
end = time.monotonic() + 120
while not other.read(100) and time.monotonic() < end:
    pass
hub, samples = DeviceHub(plug_in_mice()), []
for _ in range(20):
    time.sleep(0.02)
    samples += hub.take().samples
views = [view.kind for view in hub.views()]
hub.stop()
print(json.dumps({"pens": len(pens), "views": views, "cut": len(StrokeCutter().cut(samples))}))
"""


def test_a_pen_whose_node_may_be_opened_is_no_second_brush_of_the_studio(plugged) -> None:
    report = struct.pack("<BBHHHHbbH", 7, 1 | 32, 5000, 2500, 0, 8191, 0, 0, 0).hex()
    script = [[0.05, "send", report] for _ in range(20)]
    devices = [device(0x1234, 0x5678, "tablet", pen(), script, starts="open"), mouse([])]
    assert plugged(devices, STUDIO).said == {"pens": 1, "views": ["mouse"], "cut": 0}


# -- the command ------------------------------------------------------------------------------


def both(mouse_script=(), stylus_script=(), **more) -> list[dict]:
    return [mouse(list(mouse_script), **more), stylus(list(stylus_script), starts="open")]


def test_list_says_what_is_plugged_in_and_what_to_do(plugged) -> None:
    outcome = plugged(both(), ["devices", "list"])
    assert outcome.code == 0
    assert outcome.stdout.splitlines() == [
        "SpaceNavigator, 6-DOF mouse, 046d:c626, /dev/hidraw0 by hidraw: ready",
        "virtual haptic stylus, haptic stylus, f055:4a50, /dev/hidraw1 by hidraw: ready",
    ]


def test_list_with_nothing_plugged_in(plugged) -> None:
    plain = device(1, 2, "keyboard", b"\x05\x01\x09\x06\xa1\x01\xc0", [])
    outcome = plugged(
        [plain],
        """
from paint3d.cli.main import main
codes = [main(["devices", "list"]), main(["devices", "check", "--seconds", "1"])]
print(codes)
""",
    )
    assert outcome.said == [0, 2]
    assert outcome.stdout.count("is plugged in") == 1
    assert outcome.stderr.startswith("paint3d: error: no 6-DOF mouse")
    assert outcome.stderr.count("\n") == 1


WATCH = """
import signal, sys
from paint3d.cli.main import main
write, lines = sys.stdout.write, []

def seen(line):
    lines.append(line)
    if "silent" in line and any("+30.00 mm" in one for one in lines):
        signal.raise_signal(signal.SIGINT)
    return write(line)

sys.stdout.write = seen
code = main(["devices", "watch", "--seconds", "120"])
write(f"{code}\\n")
"""


def test_watch_shows_live_values(plugged) -> None:
    outcome = plugged(both([ramp(40, 100.0, MOVE)], [ramp(400, 1000.0, POSE)]), WATCH)
    assert outcome.said == 0
    assert "SpaceNavigator  +300    +0   -50    +0    +0    +0 buttons 0" in outcome.stdout
    assert "+30.00 mm, +1.000 +0.000" in outcome.stdout
    assert outcome.stdout.splitlines()[-2].endswith("haptic stylus silent")


def test_check_measures_rate_and_latency(plugged) -> None:
    outcome = plugged(
        both([ramp(100, 100.0, MOVE)], [ramp(1000, 1000.0, POSE)]),
        ["devices", "check", "--seconds", "120"],
        interrupt=True,
    )
    assert outcome.code == 0
    assert "SpaceNavigator: 100 reports" in outcome.stdout
    assert "haptic stylus: 1000 reports" in outcome.stdout
    assert "read late by" in outcome.stdout
    assert "sending a force takes" in outcome.stdout


def test_record_writes_a_recording_and_a_log(plugged, tmp_path) -> None:
    file, raw = tmp_path / "hands.jsonl", tmp_path / "hands.log.jsonl.gz"
    outcome = plugged(
        both([ramp(60, 100.0, MOVE)], [ramp(600, 1000.0, POSE)]),
        ["devices", "record", str(file), "--raw", str(raw)],
        interrupt=True,
    )
    assert outcome.code == 0, outcome.stderr
    recording = load_recording(file)
    assert len(recording) == 600
    assert np.allclose(recording.position[:, 0], np.arange(600) * 0.001)
    assert recording.object_position[-1, 0] > 10.0
    assert recording.header["devices"] == ["SpaceNavigator", "virtual haptic stylus"]
    links = {link.node.kind: link for link in read_device_log(raw)}
    assert len(links["stylus"].entries) == 600
    assert len(links["mouse"].entries) == 60


def test_a_pen_that_is_turned_over_is_recorded_so_and_erases(plugged, tmp_path) -> None:
    """Along a line, and with the other end across its middle."""
    ways = (((1000, 8000), (4000, 8000), 1 | 32), ((2500, 9500), (2500, 6500), 8 | 16 | 32))
    script, at = [], 0.0
    for start, end, down in ways:
        for k, (x, y) in enumerate(np.linspace(start, end, 30).astype(int).tolist()):
            flags, force = (down, 5000) if 0 < k < 29 else (down & 16 | 32, 0)
            report = struct.pack("<BBHHHHbbH", 7, flags, x, y, 0, force, 0, 0, 0)
            script.append([at, "send", report.hex()])
            at = 0.01
    file = tmp_path / "pen.jsonl"
    devices = [device(0x1234, 0x5678, "tablet", pen(), script, starts="open")]
    outcome = plugged(devices, ["devices", "record", str(file)], interrupt=True)
    assert outcome.code == 0, outcome.stderr
    recording = load_recording(file)
    runs = eraser_runs(recording.buttons)
    assert [(end - first, erases) for first, end, erases in runs] == [(30, False), (30, True)]
    on_surface = []
    for part in (recording.part(0, 30), recording):
        painter = Painter(PaintedSurface(make_plane(), resolution=1.0))
        painter.replay(part)
        ledger = painter.ledger()
        assert sum(ledger.values()) - ledger["loaded"] == pytest.approx(ledger["loaded"])
        on_surface.append(ledger["wet"] + ledger["dry"])
    assert 0.0 < on_surface[1] < 0.9 * on_surface[0]


def test_record_leaves_nothing_where_nothing_came(plugged, tmp_path) -> None:
    file = tmp_path / "hands.jsonl"
    other = tmp_path / "hands.txt"
    outcome = plugged(
        both(),
        f"""
from paint3d.cli.main import main
codes = [main(["devices", "record", {str(file)!r}, "--seconds", "0.3"]),
         main(["devices", "record", {str(other)!r}])]
print(codes)
""",
    )
    assert outcome.said == [2, 2]
    assert "the stylus sent nothing" in outcome.stderr
    assert "unknown kind of file" in outcome.stderr
    assert list(tmp_path.glob("hands*")) == []
