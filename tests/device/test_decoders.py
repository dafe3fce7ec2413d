"""Decoders are pure: descriptors against another parser, reports against the numbers put in."""

from __future__ import annotations

import math
import struct
import warnings

import hid_parser
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from paint3d.core.quaternion import rotate
from paint3d.device.catalogue import find_mouse_quirks, is_listed_mouse, is_never_six_dof
from paint3d.device.descriptor import Kind, extract, parse_descriptor
from paint3d.device.digitizer import find_digitizer_layout, orientation_from_tilt
from paint3d.device.force import haptic_stylus
from paint3d.device.force.inverse3 import decode_state
from paint3d.device.sample import BARREL, DIP, ERASER
from paint3d.device.six_dof import MouseReading, find_mouse_layout, is_multi_axis
from paint3d.errors import DeviceError
from paint3d.recording.flat_recording import orientations_from_angles
from tests.support.decoding import TARGETS, decode_any
from tests.support.descriptors import (
    AXES,
    SPACENAVIGATOR,
    buttons,
    collection,
    combined_mouse,
    field,
    item,
    pen,
    report_id,
    split_mouse,
)

QUICK = settings(deadline=None, max_examples=60)
AXIS = st.integers(-500, 500)
MICE = {"captured": SPACENAVIGATOR, "split": split_mouse(), "combined": combined_mouse()}


# -- descriptors ------------------------------------------------------------------------------


@st.composite
def layouts(draw):
    """A descriptor of a few numbered reports, and its fields as they were declared."""
    body, declared = b"", []
    for number in draw(st.lists(st.integers(1, 255), min_size=1, max_size=3, unique=True)):
        body += report_id(number)
        bit = 0
        for _ in range(draw(st.integers(1, 4))):
            size = draw(st.integers(1, 16))
            signed = size > 1 and draw(st.booleans())
            low = -(1 << (size - 1)) if signed else 0
            high = (1 << (size - 1)) - 1 if signed else (1 << size) - 1
            usages = draw(st.lists(st.sampled_from(AXES), min_size=1, max_size=3, unique=True))
            body += field(1, usages, size, low, high)
            for usage in usages:
                declared.append((number, bit, size, usage, low, high))
                bit += size
        spare = -bit % 8
        if spare:
            body += field(1, [], spare, 0, 1, flags=3, count=1)
    return collection(1, 8, body), declared


@QUICK
@given(layouts(), st.binary(min_size=64, max_size=64))
def test_fields_lie_where_they_were_declared(layout, noise) -> None:
    data, declared = layout
    parsed = parse_descriptor(data)
    found = [(f.report_id, f.bit, f.size, f.usage, f.low, f.high) for f in parsed.fields]
    assert found == declared
    for f in parsed.fields:
        bits = "".join(f"{byte:08b}"[::-1] for byte in noise)[f.bit : f.bit + f.size]
        value = int(bits[::-1], 2)
        assert extract(f, noise) == value - (1 << f.size) * (f.signed and bits[-1] == "1")


@pytest.mark.parametrize("name", MICE)
def test_another_parser_finds_the_same_axes(name) -> None:
    data = MICE[name]
    layout = find_mouse_layout(parse_descriptor(data))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theirs = hid_parser.ReportDescriptor(list(data))
    report = {
        number: bytes([number, *range(11, 11 + theirs.get_input_report_size(number).byte)])
        for number in theirs.input_report_ids
    }
    reading = MouseReading()
    expected = {}
    for raw in report.values():
        reading = layout.decode(raw, reading)
        for usage, value in theirs.parse_input_report(list(raw)).items():
            if isinstance(usage, hid_parser.Usage) and usage.page == 1:
                expected[usage.usage] = int(value)
    assert reading.axes == tuple(expected[usage] for usage in AXES)
    light = theirs.get_output_report_size(4).byte
    assert len(layout.encode_light(True)) == 1 + light


def test_the_stylus_descriptor_says_what_its_reports_are() -> None:
    parsed = parse_descriptor(haptic_stylus.DESCRIPTOR)
    assert parsed.size(Kind.INPUT, 1) == len(haptic_stylus.encode_pose([0, 0, 0], [1, 0, 0, 0])) - 1
    assert parsed.size(Kind.OUTPUT, 2) == len(haptic_stylus.encode_force([0, 0, 0])) - 1


BAD_DESCRIPTORS = {
    "empty": b"",
    "too long": b"\x05\x01" * 2049,
    "cut short": SPACENAVIGATOR[:-3] + b"\x27\x00",
    "never ends": SPACENAVIGATOR[:-1],
    "ends twice": SPACENAVIGATOR + b"\xc0",
    "report id 0": collection(1, 8, report_id(0) + field(1, AXES, 8, 0, 255)),
    "huge report": collection(1, 8, field(1, [0x30], 32, 0, 1, count=60000)),
    "pop without push": b"\xb4",
    "pushes for ever": b"\xa4" * 40,
    "nested for ever": b"\xa1\x00" * 40 + b"\xc0" * 40,
    "usages backwards": item(0x04, 9) + item(0x18, 8) + item(0x28, 3),
}


@pytest.mark.parametrize("name", BAD_DESCRIPTORS)
def test_bad_descriptors_are_refused(name) -> None:
    with pytest.raises(DeviceError, match="descriptor"):
        parse_descriptor(BAD_DESCRIPTORS[name])


def test_settings_are_pushed_and_popped() -> None:
    inner = b"\xa4" + field(9, [1], 1, 0, 1, count=1) + b"\xb4"
    data = collection(1, 8, field(1, [0x30], 7, 0, 127) + inner + item(0x08, 0x31) + b"\x81\x02")
    sizes = [(f.page, f.usage, f.bit, f.size) for f in parse_descriptor(data).fields]
    assert sizes == [(1, 0x30, 0, 7), (9, 1, 7, 1), (1, 0x31, 8, 7)]


# -- 6-DOF mice -------------------------------------------------------------------------------


@QUICK
@given(st.tuples(*[AXIS] * 6), st.integers(0, (1 << 15) - 1), st.sampled_from(sorted(MICE)))
@example((350, -350, 0, 1, -1, 7), 1, "captured")
def test_a_mouse_says_what_was_sent(axes, held, name) -> None:
    layout = find_mouse_layout(parse_descriptor(MICE[name]))
    held &= (1 << len(layout.buttons)) - 1
    reading = MouseReading()
    for report in mouse_reports(name, axes, held):
        reading = layout.decode(report.ljust(13, b"\0"), reading)
    assert reading.axes == axes
    assert reading.buttons == held


def mouse_reports(name: str, axes: tuple[int, ...], held: int) -> list[bytes]:
    pressed = struct.pack("<BI", 3, held)
    if name == "combined":
        return [struct.pack("<B6h", 1, *axes), pressed]
    return [struct.pack("<B3h", 1, *axes[:3]), struct.pack("<B3h", 2, *axes[3:]), pressed]


def test_reports_leave_alone_what_they_do_not_speak_of() -> None:
    layout = find_mouse_layout(parse_descriptor(SPACENAVIGATOR))
    before = MouseReading((1, 2, 3, 4, 5, 6), 0b10, 80)
    after = layout.decode(struct.pack("<B3h", 2, 7, 8, 9), before)
    assert after == MouseReading((1, 2, 3, 7, 8, 9), 0b10, 80)
    assert layout.decode(b"\x17\x37\x00", before).battery == 0x37


@pytest.mark.parametrize("report", [b"", b"\x01", b"\x01\x00\x00\x00\x00\x00", b"\x63\x01\x02"])
def test_reports_that_cannot_be_are_refused(report) -> None:
    layout = find_mouse_layout(parse_descriptor(SPACENAVIGATOR))
    with pytest.raises(DeviceError, match="report"):
        layout.decode(report, MouseReading())


def test_light_goes_on_and_off() -> None:
    layout = find_mouse_layout(parse_descriptor(SPACENAVIGATOR))
    assert layout.encode_light(True) == b"\x04\x01"
    assert layout.encode_light(False) == b"\x04\x00"


def test_an_ordinary_mouse_is_no_six_dof_mouse() -> None:
    plain = collection(1, 2, field(1, [0x30, 0x31], 8, -127, 127, flags=6) + buttons(3, 8))
    assert not is_multi_axis(parse_descriptor(plain))
    with pytest.raises(DeviceError, match="no axis z rx ry rz"):
        find_mouse_layout(parse_descriptor(plain))
    gamepad = collection(1, 5, field(1, AXES, 8, 0, 255))
    with pytest.raises(DeviceError, match="no axis"):
        find_mouse_layout(parse_descriptor(gamepad))


def test_buttons_listed_by_number_are_held() -> None:
    array = field(9, [], 8, 1, 8, flags=0, count=3)
    array = array[:-2] + item(0x18, 1) + item(0x28, 8) + array[-2:]
    layout = find_mouse_layout(
        parse_descriptor(collection(1, 8, field(1, AXES, 8, -127, 127) + array))
    )
    assert layout.decode(bytes([0] * 6 + [2, 5, 0]), MouseReading()).buttons == 0b10010


def test_the_catalogue_names_and_skips() -> None:
    assert find_mouse_quirks(0x046D, 0xC621).name == "SpaceBall 5000"
    assert find_mouse_quirks(0x256F, 0xC652).receiver
    assert find_mouse_quirks(0x256F, 0xC633).buttons == 31
    assert find_mouse_quirks(0x1234, 0x5678).name is None
    assert is_listed_mouse(0x256F, 0xC63A)
    assert not is_listed_mouse(0x046D, 0xC63A)
    assert is_never_six_dof(0x256F, 0xC650)
    assert not is_never_six_dof(0x256F, 0xC635)


# -- pens -------------------------------------------------------------------------------------


def pen_report(flags=0, x=0, y=0, hover=0, force=0, tilt_x=0, tilt_y=0, twist=0) -> bytes:
    return struct.pack("<BBHHHHbbH", 7, flags, x, y, hover, force, tilt_x, tilt_y, twist)


TIP, SIDE, SECOND, RUBBER, TURNED, NEAR = 1, 2, 4, 8, 16, 32


@pytest.mark.parametrize("page", [0x0D, 0xFF0D])
def test_a_pen_says_where_it_is_how_hard_and_how_it_leans(page) -> None:
    layout = find_digitizer_layout(parse_descriptor(pen(page)))
    said = layout.decode(pen_report(TIP | NEAR | SIDE, 5000, 2500, 0, 4095, 30, 0, 0))
    assert np.allclose(said.position, [50.0, 75.0, 0.0])
    assert said.pressure == pytest.approx(4095 / 8191)
    assert said.buttons == BARREL
    up = rotate(said.orientation, np.array([0.0, 0.0, 1.0]))
    assert math.degrees(math.atan2(up[0], up[2])) == pytest.approx(30.0)
    towards = layout.decode(pen_report(TIP | NEAR, tilt_y=20))
    assert rotate(towards.orientation, np.array([0.0, 0.0, 1.0]))[1] < -0.3


def test_a_pen_that_hovers_presses_nothing() -> None:
    layout = find_digitizer_layout(parse_descriptor(pen()))
    said = layout.decode(pen_report(NEAR | SECOND, hover=300, force=900))
    assert (said.pressure, said.buttons, said.in_range) == (0.0, DIP, True)
    assert said.position[2] == pytest.approx(3.0)
    gone = layout.decode(pen_report(TIP, force=900))
    assert (gone.pressure, gone.in_range) == (0.0, False)


def test_the_other_end_rubs_out() -> None:
    layout = find_digitizer_layout(parse_descriptor(pen()))
    said = layout.decode(pen_report(RUBBER | TURNED | NEAR, force=8191))
    assert (said.buttons, said.pressure) == (ERASER, 1.0)


def test_values_outside_their_range_are_no_values() -> None:
    layout = find_digitizer_layout(parse_descriptor(pen()))
    said = layout.decode(pen_report(TIP | NEAR, force=60000, tilt_x=100, x=65535))
    assert said.pressure == 0.5  # it touches, how hard is not known
    assert rotate(said.orientation, np.array([0.0, 0.0, 1.0]))[2] == pytest.approx(1.0)
    assert said.position[0] == pytest.approx(200.0)


def test_reports_of_the_pad_are_passed_over() -> None:
    both = pen() + collection(0x0D, 5, report_id(9) + field(1, [0x30], 8, 0, 255))
    layout = find_digitizer_layout(parse_descriptor(both))
    assert layout.decode(b"\x09\x20") is None


def test_what_has_no_pen_is_no_digitizer() -> None:
    with pytest.raises(DeviceError, match="no pen"):
        find_digitizer_layout(parse_descriptor(SPACENAVIGATOR))


@QUICK
@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(-3.0, 3.0))
def test_tilts_agree_with_altitude_and_azimuth(tilt_x, tilt_y, twist) -> None:
    way = np.array([math.tan(tilt_x), math.tan(tilt_y)])
    if np.hypot(*way) < 1e-6:
        return
    altitude = np.array([math.atan2(1.0, np.hypot(*way))])
    azimuth = np.array([math.atan2(way[1], way[0])])
    expected = orientations_from_angles(azimuth, altitude, twist)[0]
    assert abs(expected @ orientation_from_tilt(tilt_x, tilt_y, twist)) == pytest.approx(1.0)


# -- the haptic stylus, the Inverse3 ----------------------------------------------------------


@QUICK
@given(
    st.tuples(*[st.floats(-500, 500)] * 3),
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(x * x for x in q) > 0.01),
    st.integers(0, 255),
    st.integers(0, 65535),
)
def test_poses_come_back(position, quaternion, held, sequence) -> None:
    unit = np.array(quaternion) / np.linalg.norm(quaternion)
    said, number = haptic_stylus.decode_pose(
        haptic_stylus.encode_pose(position, unit, held, sequence) + b"\0" * 5, 77
    )
    assert np.abs(said.position - position).max() <= 0.0005 + 1e-9
    assert np.abs(said.orientation - unit).max() < 2e-4
    assert np.linalg.norm(said.orientation) == pytest.approx(1.0)
    assert (said.buttons, number, said.time_ns, said.pressure) == (held, sequence, 77, None)


@QUICK
@given(st.tuples(*[st.floats(-4.5, 4.5)] * 3), st.integers(0, 65535))
def test_forces_come_back_and_never_grow(force, sequence) -> None:
    back, number = haptic_stylus.decode_force(haptic_stylus.encode_force(force, sequence))
    assert number == sequence
    assert all(
        abs(b) <= abs(f) + 1e-9 and abs(b - f) < 0.0011 for b, f in zip(back, force, strict=True)
    )


@pytest.mark.parametrize(
    "force", [(8.0, 0, 0), (5.0, 5.0, 5.0), (math.nan, 0, 0), (0, math.inf, 0)]
)
def test_unsafe_forces_are_never_sent(force) -> None:
    with pytest.raises(DeviceError, match="force"):
        haptic_stylus.encode_force(force)


@pytest.mark.parametrize(
    "report",
    [
        b"",
        b"\x01" * 24,
        b"\x02" + b"\0" * 24,
        haptic_stylus.encode_pose([0, 0, 0], [0.5, 0, 0, 0]),
        haptic_stylus.encode_pose([0, 0, 2100], [1, 0, 0, 0]),
    ],
)
def test_broken_poses_are_refused(report) -> None:
    with pytest.raises(DeviceError, match="stylus"):
        haptic_stylus.decode_pose(report)


def test_the_inverse3_speaks_metres() -> None:
    state = decode_state(
        b'{"inverse3": [{"device_id": "04F5", "state": {"cursor_position": '
        b'{"x": 0.01, "y": -0.02, "z": 0.15}}}], "wireless_verse_grip": [{"state": '
        b'{"orientation": {"w": 0, "x": 0, "y": 0, "z": 1}, "buttons": {"a": true, "b": false}}}]}'
    )
    assert np.allclose(state.reading.position, [10.0, -20.0, 150.0])
    assert np.allclose(state.reading.orientation, [0, 0, 0, 1])
    assert (state.device_id, state.reading.buttons, state.has_grip) == ("04F5", BARREL, True)


@pytest.mark.parametrize(
    ("message", "why"),
    [
        ("[", "not JSON"),
        ("[" * 100_000, "not JSON"),
        ("[]", "lists no Inverse3"),
        ('{"inverse3": []}', "lists no Inverse3"),
        ('{"inverse3": [{"state": {}}]}', "device_id"),
        ('{"inverse3": [{"device_id": "a", "state": 3}]}', "cursor_position"),
        (
            '{"inverse3": [{"device_id": "a", "state": {"cursor_position": {"x": NaN, "y": 0,'
            ' "z": 0}}}]}',
            "finite",
        ),
        (
            '{"inverse3": [{"device_id": "a", "state": {"cursor_position": {"x": 7, "y": 0,'
            ' "z": 0}}}]}',
            "within 2",
        ),
    ],
)
def test_what_the_inverse3_cannot_say_is_refused(message, why) -> None:
    with pytest.raises(DeviceError, match=why):
        decode_state(message)


# -- garbage ----------------------------------------------------------------------------------


@settings(deadline=None, max_examples=150)
@given(st.binary(max_size=300))
def test_no_bytes_break_a_decoder(data) -> None:
    assert decode_any(data).keys() == TARGETS.keys()


@settings(deadline=None, max_examples=150)
@given(
    st.sampled_from(
        [SPACENAVIGATOR, pen(), pen(0xFF0D), combined_mouse(), haptic_stylus.DESCRIPTOR]
    ),
    st.lists(st.tuples(st.integers(0, 216), st.integers(0, 255)), max_size=6),
    st.binary(max_size=64),
)
def test_no_damaged_descriptor_breaks_a_decoder(whole, damage, reports) -> None:
    data = bytearray(whole)
    for at, byte in damage:
        data[at % len(data)] = byte
    decode_any(len(data).to_bytes(2, "little") + bytes(data) + reports)
    decode_any(bytes(data))
