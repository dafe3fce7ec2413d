"""Recordings of pads: tables, InkML, angles, scale, ties and pen lifts."""

from __future__ import annotations

import io
import math
import random
import struct
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.device.sample import DIP
from paint3d.errors import RecordingError
from paint3d.painter.flat_input import add_dips
from paint3d.recording import number_table, recording
from paint3d.recording.flat_recording import (
    MM_PER_PIXEL,
    angles_from_orientations,
    orientations_from_angles,
    spread_equal_times,
)
from paint3d.recording.number_table import NumberTable
from paint3d.recording.recording import Recording, TextLines, load_recording, save_recording

SHARED = Path(__file__).parents[2] / "../shared/recordings"
needs_shared = pytest.mark.skipif(not SHARED.exists(), reason="recordings are not at hand")


def test_the_tip_trails_away_from_the_lean():
    axes = matrices_from_quaternions(orientations_from_angles(np.array([0.4]), np.array([0.9])))[0]
    lean = np.array([math.cos(0.4), math.sin(0.4)])
    assert axes[:2, 2] == pytest.approx(math.cos(0.9) * lean)
    assert axes[2, 2] == pytest.approx(math.sin(0.9))
    assert axes[:2, 0] / np.linalg.norm(axes[:2, 0]) == pytest.approx(-lean)
    assert np.linalg.det(axes) == pytest.approx(1.0)


def test_ties_are_spread_up_to_the_next_stamp():
    times, n_moved = spread_equal_times(np.array([0, 10, 10, 10, 40, 50, 50]))
    assert times.tolist() == [0, 10, 20, 30, 40, 50, 55]
    assert n_moved == 3


def table(tmp_path, text, name="a.csv"):
    path = tmp_path / name
    path.write_text(text)
    return path


def test_strokes_of_a_table_are_joined_by_lifted_samples(tmp_path):
    path = table(
        tmp_path,
        "stroke,time_s,x,y,pressure,altitude_deg,azimuth_deg\n"
        "0,0,0,0,.2,60,0\n0,0.01,10,10,.4,60,0\n1,0.5,20,0,.6,60,0\n1,0.51,30,0,.8,60,0\n",
    )
    recording = load_recording(path, scale=0.5)
    assert recording.is_pad
    assert recording.pressure.tolist() == [0.2, 0.4, 0.0, 0.0, 0.6, 0.8]
    assert recording.time_ns.tolist() == [0, 10**7, 11 * 10**6, 499 * 10**6, 5 * 10**8, 51 * 10**7]
    assert recording.position[:, :2].tolist() == [
        [0, 0], [5, -5], [5, -5], [10, 0], [10, 0], [15, 0]
    ]  # fmt: skip


def test_a_table_of_poses_is_in_mm_whatever_its_columns_are_called(tmp_path):
    text = "time_s,{0}x,{0}y,{0}z,qw,qx,qy,qz,pressure\n0,1,2,70,1,0,0,0,.2\n.5,3,4,70,1,0,0,0,.4\n"
    for prefix in ("", "pos_"):
        recording = load_recording(table(tmp_path, text.format(prefix)))
        assert recording.position.tolist() == [[1, 2, 70], [3, 4, 70]]
        assert repr(recording) == "<Recording: poses, 2 samples in 0.5 s>"


def test_without_an_azimuth_the_surface_drags_the_tip(tmp_path):
    bare = load_recording(table(tmp_path, "time_s,x,y\n0,1,2\n"))
    assert bare.header["azimuth"] == "dragged"
    tip = matrices_from_quaternions(bare.orientation)[0, :, 0]
    assert tip == pytest.approx([-np.sqrt(0.5), np.sqrt(0.5), 0.0])
    known = load_recording(table(tmp_path, "time_s,x,y,azimuth\n0,1,2,0\n"))
    assert known.header["azimuth"] == "commanded"


def test_y_upwards_keeps_y_and_azimuth(tmp_path):
    text = "time_s,x,y,altitude,azimuth\n0,1,2,0.5,0.3\n"
    down = load_recording(table(tmp_path, text))
    up = load_recording(table(tmp_path, text), y_down=False)
    assert down.position[0, 1] == -up.position[0, 1] == -2 * MM_PER_PIXEL
    lean_down, lean_up = (matrices_from_quaternions(r.orientation)[0, :, 2] for r in (down, up))
    assert lean_down == pytest.approx(lean_up * [1, -1, 1])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time_s,x,y,pressure\n0,0,0,1.2\n", "a.csv:2: pressure is 1.2; expected 0 to 1"),
        ("time_s,x,y,force\n0,0,0,9\n", "a.csv:2: force is 9; expected 0 to 7.9"),
        ("time_s,x,y\n0,0,0\n1,nan,0\n", "a.csv:3: x is 'nan'; expected a finite number"),
        ("time_s,x,y\n0,0,0\n-1,0,0\n", "a.csv:3: time_s is -1; expected at least 0"),
        ("time_s,x,y\n0,0\n", "a.csv:2: there are 2 columns; expected 3"),
        ("time_s,x\n0,0\n", "there is no column for y"),
        ("x,y\n0,0\n", "a.csv:1: columns are x, y; expected"),
        ("time_s,x,y\n", "there are no samples"),
        ("# {bad\ntime_s,x,y\n0,0,0\n", "a.csv:1: the header is not JSON"),
    ],
)
def test_faults_in_tables_are_named(tmp_path, text, words):
    with pytest.raises(RecordingError) as caught:
        load_recording(table(tmp_path, text))
    assert words in str(caught.value)


def test_stamps_in_ms_that_go_on_in_seconds_are_put_right(tmp_path):
    rows = [f"{k},{1000 * 2 * k + 0.005 * i},{i},0" for k in range(2) for i in range(4)]
    path = table(tmp_path, "idx,timestamp,x,y\n" + "\n".join(rows) + "\n")
    recording = load_recording(path)
    pressed = recording.time_ns[recording.pressure > 0] / 1e9
    assert pressed == pytest.approx([0, 0.005, 0.01, 0.015, 2, 2.005, 2.01, 2.015])
    assert "in s within them" in recording.header["notes"][0]


@needs_shared
def test_the_tablet_recording_reads_with_its_ties_and_angles():
    recording = load_recording(SHARED / "wacom_ink.csv")
    assert np.count_nonzero(recording.pressure == 0.0) == 6  # three lifts between four strokes
    assert len(recording) == 880 + 6
    assert recording.duration_s == pytest.approx(6.5, abs=0.1)
    assert "29 samples shared a time stamp" in recording.header["notes"][1]
    lean = matrices_from_quaternions(recording.orientation)[:, 2, 2]
    assert lean.min() > math.sin(0.58)
    assert lean.max() < math.sin(0.70)


@needs_shared
def test_the_thirty_second_painting_reads_the_right_way_up():
    recording = load_recording(SHARED / "painting30sec.dat")
    assert len(recording) == 2937
    assert recording.duration_s == pytest.approx(29.999)
    assert recording.position[0, :2] == pytest.approx(
        [205.244514 * MM_PER_PIXEL, -210.034483 * MM_PER_PIXEL]
    )
    assert recording.pressure.max() == pytest.approx(0.545988)


INKML = """<ink xmlns="http://www.w3.org/2003/InkML"><traceFormat>
<channel name="X" units="mm"/><channel name="Y" units="mm"/><channel name="F" max="1023"/>
<channel name="OA" units="deg"/><channel name="OE" units="deg"/><channel name="T" units="ms"/>
</traceFormat>{}</ink>"""


def test_inkml_of_others_with_differences_and_device_pressure(tmp_path):
    traces = "<trace>10 20 0 45 60 0, '1 '2 1023 45 60 5, '1 '2 0 45 60 7</trace>"
    recording = load_recording(table(tmp_path, INKML.format(traces), "a.inkml"))
    assert recording.position[:, :2].tolist() == [[10, -20], [11, -22], [12, -24]]
    assert recording.pressure.tolist() == [0.0, 1.0, 0.0]
    assert recording.time_ns.tolist() == [0, 5_000_000, 7_000_000]


def test_inkml_second_differences_and_bare_traces(tmp_path):
    text = '<ink><trace>0 0, "1 "1, 1 1, 0 0</trace></ink>'
    recording = load_recording(table(tmp_path, text, "a.inkml"), scale=1.0, y_down=False)
    assert recording.position[:, 0].tolist() == [0, 1, 3, 5]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<ink><trace>0 0, 1</trace></ink>", "trace 1: point 2 has 1 values; expected 2"),
        ("<ink><trace>'1 0</trace></ink>", "the first point is a difference"),
        ("<ink><trace>a b</trace></ink>", "expected decimal numbers"),
        ("<ink><trace>1e999 0</trace></ink>", "expected a finite number"),
        (f"<ink><trace>#{'F' * 300} 0</trace></ink>", "expected a finite number"),
        ("<ink></ink>", "there are no traces"),
        ("<svg/>", "the root element is <svg>; expected <ink>"),
        ("<ink><trace>0 0</trace>", "not well-formed XML"),
        ('<!DOCTYPE ink [<!ENTITY a "b">]><ink>&a;</ink>', "there is a document type"),
        ("<ink>" + "<a>" * 100 + "</a>" * 100 + "</ink>", "nested over 64 deep"),
        (INKML.format("<trace>0 0 2000 0 0 0</trace>"), "pressure is 1.95503; expected 0 to 1"),
        (INKML.format("<trace>0 0 0 0 0 5, 0 0 0 0 0 4</trace>"), "T is 4; expected at least 5"),
    ],
)
def test_faults_in_inkml_are_named(tmp_path, text, words):
    with pytest.raises(RecordingError) as caught:
        load_recording(table(tmp_path, text, "a.inkml"))
    assert words in str(caught.value)


OFFICE = """<inkml:ink xmlns:inkml="http://www.w3.org/2003/InkML"><inkml:definitions>
<inkml:context xml:id="ctx0"><inkml:inkSource xml:id="is0"><inkml:traceFormat>
<inkml:channel name="X" {xy}/><inkml:channel name="Y" {xy}/>
<inkml:channel name="F" type="integer" max="1000" units="dev"/>
<inkml:channel name="T" type="integer" units="dev"/></inkml:traceFormat>
<inkml:channelProperties>
<inkml:channelProperty channel="X" name="resolution" {resolution}/>
<inkml:channelProperty channel="Y" name="resolution" {resolution}/>
<inkml:channelProperty channel="F" name="resolution" value="0" units="1/dev"/>
<inkml:channelProperty channel="T" name="resolution" value="1" units="1/dev"/>
</inkml:channelProperties></inkml:inkSource></inkml:context>
</inkml:definitions><inkml:trace contextRef="#ctx0">{points}</inkml:trace></inkml:ink>"""


@pytest.mark.parametrize(
    ("xy", "resolution", "count"),
    [
        ('type="integer" units="cm"', 'value="1000" units="1/cm"', 0.01),
        ('type="integer" units="in"', 'value="500" units="1/in"', 25.4 / 500),
        ('type="integer" units="mm"', 'value="100" units="1/mm"', 0.01),
        ('type="integer" units="himetric"', 'value="1" units="1/himetric"', 0.01),
        ('units="himetric"', 'value="0" units="1/himetric"', 0.01),
        ('type="integer" units="cm"', 'value="1000" units="1/in"', 0.0254),  # as resolved
        ('units="cm"', 'value="1000"', 0.01),  # a unit of the resolution is missing
        ('units="dev"', 'value="2540" units="1/in"', 0.01),
        ("", 'value="40" units="1/mm"', 0.025),
        ('units="dev"', 'value="7" units="1/dev"', 2.0),  # nobody knows: the scale asked for
        ('type="decimal" units="mm"', 'value="100" units="1/mm"', 1.0),
    ],
)
def test_counts_of_office_programs_are_lengths_by_their_resolution(tmp_path, xy, resolution, count):
    text = OFFICE.format(xy=xy, resolution=resolution, points="1000 2000 500 0, 1100 2000 1000 8")
    recording = load_recording(table(tmp_path, text, "a.inkml"), scale=2.0)
    wanted = np.array([[1000.0, -2000.0], [1100.0, -2000.0]]) * count
    assert recording.position[:, :2] == pytest.approx(wanted)
    assert recording.pressure.tolist() == [0.5, 1.0]
    assert recording.time_ns.tolist() == [0, 8_000_000]


def test_fractions_of_a_unit_are_no_counts(tmp_path):
    """The resolution is then what the device can tell apart."""
    told = {"xy": 'units="mm"', "resolution": 'value="100" units="1/mm"'}
    text = OFFICE.format(**told, points="10.25 20 500 0, 11 20 500 8")
    recording = load_recording(table(tmp_path, text, "a.inkml"))
    assert recording.position[0, 0] == 10.25


@pytest.mark.parametrize("value", ["many", "-1", "nan", ""])
def test_a_resolution_that_is_no_number_is_named(tmp_path, value):
    told = {"xy": 'units="cm"', "resolution": f'value="{value}" units="1/cm"'}
    with pytest.raises(RecordingError, match=r"a\.inkml:1: the resolution of X is"):
        load_recording(table(tmp_path, OFFICE.format(**told, points="1 2 3 4"), "a.inkml"))


def test_angles_and_times_have_resolutions_too(tmp_path):
    text = """<ink><inkSource><traceFormat><channel name="X" units="mm"/>
    <channel name="Y" units="mm"/><channel name="OE" type="integer" units="deg"/>
    <channel name="T" type="integer" units="s"/></traceFormat><channelProperties>
    <channelProperty channel="OE" name="resolution" value="10" units="1/deg"/>
    <channelProperty channel="T" name="resolution" value="1000" units="1/s"/>
    </channelProperties></inkSource><trace>1 2 600 5, 2 2 600 12</trace></ink>"""
    recording = load_recording(table(tmp_path, text, "a.inkml"))
    axes = matrices_from_quaternions(recording.orientation)[:, :, 2]
    assert axes[:, 2] == pytest.approx(math.sin(math.radians(60)))
    assert np.diff(recording.time_ns).tolist() == [7_000_000]


def test_every_trace_has_the_format_of_its_context(tmp_path):
    def source(key, unit, count, more=""):
        channels = "".join(f'<channel name="{c}" type="integer" units="{unit}"/>' for c in "XY")
        properties = "".join(
            f'<channelProperty channel="{c}" name="resolution" value="{count}" units="1/{unit}"/>'
            for c in "XY"
        )
        return (
            f'<inkSource xml:id="{key}"><traceFormat>{channels}{more}</traceFormat>'
            f"<channelProperties>{properties}</channelProperties></inkSource>"
        )

    pressed = '<channel name="F" type="integer" max="1000"/>'
    text = f"""<ink><definitions>{source("fine", "mm", 100, pressed)}
    <context xml:id="a">{source("coarse", "cm", 10)}</context>
    <context xml:id="b" inkSourceRef="#fine"/><context xml:id="c" contextRef="#b"/></definitions>
    <trace contextRef="#a">1 2, 3 4</trace><traceGroup contextRef="#c"><trace>500 600 250</trace>
    <trace contextRef="#b">700 800 1000</trace></traceGroup><trace>900 0 750</trace></ink>"""
    recording = load_recording(table(tmp_path, text, "a.inkml"))
    down = recording.pressure > 0
    assert recording.pressure[down].tolist() == [0.5, 0.5, 0.25, 1.0, 0.75]
    assert recording.position[down, :2] == pytest.approx(
        np.array([[1, -2], [3, -4], [5, -6], [7, -8], [9, 0]])
    )


@pytest.mark.parametrize("force", ["", '<channel name="F"/>'])
def test_a_pen_that_is_up_paints_nothing(tmp_path, force):
    f = " .5" if force else ""
    text = f"""<ink><traceFormat><channel name="X" units="mm"/><channel name="Y" units="mm"/>{force}
    </traceFormat><trace type="penDown">0 0{f}, 1 1{f}</trace>
    <trace type="penUp">1 1{f}, 9 9{f}, 20 20{f}</trace><trace>20 20{f}, 21 21{f}</trace></ink>"""
    recording = load_recording(table(tmp_path, text, "a.inkml"))
    down = recording.pressure > 0
    assert recording.position[down, 0].tolist() == [0, 1, 20, 21]
    assert 9.0 in recording.position[~down, 0]  # the way through the air is kept
    starts = np.flatnonzero(np.diff(np.concatenate([[False], down]).astype(int)) == 1)
    assert len(starts) == 2
    save_recording(recording, tmp_path / "b.inkml")
    again = load_recording(tmp_path / "b.inkml")
    assert again.position[again.pressure > 0, 0].tolist() == [0, 1, 20, 21]


MM = '<channel name="X" units="mm"/><channel name="Y" units="mm"/>'


def strokes_of(recording):
    """The x of the samples of each stroke, as the pen touches."""
    down = recording.pressure > 0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], down, [False]]).astype(int)))
    return [recording.position[a:b, 0].tolist() for a, b in edges.reshape(-1, 2)]


@pytest.mark.parametrize(
    ("traces", "wanted"),
    [
        ((("begin", ""), ("end", "")), [[0, 1]]),
        ((("begin", ""), ("middle", ""), ("end", "")), [[0, 1, 2]]),
        ((("", ""), ("", "#t0")), [[0, 1]]),  # named alone
        ((("begin", ""), ("", ""), ("end", "#t0")), [[0, 2], [1]]),  # with another between
        ((("begin", ""), ("end", ""), ("begin", ""), ("end", "")), [[0, 1], [2, 3]]),
        ((("", ""), ("", "")), [[0], [1]]),
        ((("", ""), ("end", "#nothing")), [[0], [1]]),  # of what is not there
    ],
)
def test_a_trace_that_continues_another_is_the_same_stroke(tmp_path, traces, wanted):
    text = (
        "".join(
            f'<trace xml:id="t{k}" continuation="{said}" priorRef="{prior}">{k} 0</trace>'
            for k, (said, prior) in enumerate(traces)
        )
        .replace('continuation=""', "")
        .replace('priorRef=""', "")
    )
    text = f"<ink><traceFormat>{MM}</traceFormat>{text}</ink>"
    assert strokes_of(load_recording(table(tmp_path, text, "a.inkml"))) == wanted


@pytest.mark.parametrize(
    ("tilts", "lean"),
    [((0, 0), (0, 0)), ((30, 0), (1, 0)), ((0, 30), (0, -1)), ((-30, 0), (-1, 0))],
)
def test_tilts_lean_the_pen_to_their_own_sides(tmp_path, tilts, lean):
    """As in Pointer Events: to the right, and down the sheet."""
    channels = "".join(f'<channel name="{name}" units="deg"/>' for name in ("OTx", "OTy"))
    text = f"<ink><traceFormat>{MM}{channels}</traceFormat><trace>0 0 {tilts[0]} {tilts[1]}</trace>"
    recording = load_recording(table(tmp_path, text + "</ink>", "a.inkml"))
    handle = matrices_from_quaternions(recording.orientation)[0, :, 2]
    wanted = np.array([*lean, 0.0]) * math.sin(math.radians(30))
    wanted[2] = math.sqrt(1.0 - wanted @ wanted)
    assert handle == pytest.approx(wanted, abs=1e-9)
    assert recording.header["azimuth"] == "commanded"


@pytest.mark.parametrize(
    ("angles", "altitude", "azimuth"),
    [
        ([(0, 0), (0, 0)], 90, "dragged"),
        ([(135, 0), (120, 0)], 90, "dragged"),
        ([(135, 0), (135, 60)], 60, "commanded"),
    ],
)
def test_a_pen_that_lies_flat_all_along_tells_no_angles(tmp_path, angles, altitude, azimuth):
    """Office programs write angles of 0 for pens, fingers and mice that have none."""
    channels = "".join(f'<channel name="{name}" units="deg"/>' for name in ("OA", "OE"))
    points = ", ".join(f"{k} 0 {a} {e}" for k, (a, e) in enumerate(angles))
    text = f"<ink><traceFormat>{MM}{channels}</traceFormat><trace>{points}</trace></ink>"
    recording = load_recording(table(tmp_path, text, "a.inkml"))
    _, found, _ = angles_from_orientations(recording.orientation)
    assert np.degrees(found[-1]) == pytest.approx(altitude)
    assert recording.header["azimuth"] == azimuth


def test_tilts_and_directions_say_the_same(tmp_path):
    rng = np.random.default_rng(5)
    for azimuth, altitude in rng.uniform((-180, 10), (180, 85), (20, 2)):
        a, e = np.radians([azimuth, altitude])
        tilts = np.degrees(np.arctan2([np.cos(a), np.sin(a)], np.tan(e)))
        both = []
        for names, values in ((("OA", "OE"), (azimuth, altitude)), (("OTx", "OTy"), tilts)):
            channels = "".join(f'<channel name="{name}" units="deg"/>' for name in names)
            text = f"<ink><traceFormat>{MM}{channels}</traceFormat><trace>0 0 {values[0]:.9f} "
            text += f"{values[1]:.9f}</trace></ink>"
            both.append(load_recording(table(tmp_path, text, "a.inkml")).orientation[0])
        assert abs(both[0] @ both[1]) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(
    ("channels", "traces", "wanted_ms"),
    [
        ("", ['timeOffset="0"', 'timeOffset="500"'], [0, 10, 500, 510]),
        ("", ['timeOffset="70" duration="40"', 'timeOffset="500" duration="6"'], [0, 40, 430, 436]),
        ("", ['timeOffset="0" duration="900"', 'timeOffset="8"'], [0, 4, 8, 18]),  # has no room
        ('<channel name="T"/>', ['timeOffset="5"', 'timeOffset="500"'], [0, 7, 495, 502]),
        ('<channel name="T"/>', ["", ""], [0, 7, 107, 114]),  # each counts from its start
        ("", ['timeOffset="500"', 'timeOffset="0"'], [0, 10, 120, 130]),  # not in that order
    ],
)
def test_traces_start_at_their_offsets(tmp_path, channels, traces, wanted_ms):
    first, last = (" 0", " 7") if channels else ("", "")
    text = "".join(f"<trace {said}>0 0{first}, 1 1{last}</trace>" for said in traces)
    text = f"<ink><traceFormat>{MM}{channels}</traceFormat>{text}</ink>"
    recording = load_recording(table(tmp_path, text, "a.inkml"))
    down = recording.pressure > 0
    times = recording.time_ns[down] - recording.time_ns[0]
    assert times.tolist() == [1_000_000 * ms for ms in wanted_ms]


def test_offsets_count_from_the_times_of_their_contexts(tmp_path):
    text = f"""<ink><definitions><timestamp xml:id="a" time="1000"/>
    <timestamp xml:id="b" timestampRef="#a" timeOffset="2000"/>
    <context xml:id="one" timestampRef="#a"/><context xml:id="two" timestampRef="#b"/></definitions>
    <traceFormat>{MM}</traceFormat><trace contextRef="#one" timeOffset="100">0 0</trace>
    <trace contextRef="#two" timeOffset="50">1 1</trace></ink>"""
    recording = load_recording(table(tmp_path, text, "a.inkml"))
    times = recording.time_ns[recording.pressure > 0]
    assert np.diff(times).tolist() == [1_950_000_000]


def test_a_source_says_its_rate(tmp_path):
    text = f"""<ink><inkSource><sampleRate value="200"/><traceFormat>{MM}</traceFormat></inkSource>
    <trace>0 0, 1 1, 2 2</trace></ink>"""
    recording = load_recording(table(tmp_path, text, "a.inkml"))
    assert recording.time_ns.tolist() == [0, 5_000_000, 10_000_000]


def test_values_that_go_on_and_words_of_other_kinds(tmp_path):
    """The Recommendation's own example: differences, states of a button, and what goes on."""
    text = """<ink><traceFormat><channel name="X" units="mm"/><channel name="Y" units="mm"/>
    <intermittentChannels><channel name="B1" type="boolean" default="F"/>
    <channel name="Z" units="mm" default="4"/></intermittentChannels></traceFormat>
    <trace>1125 18432,'23'43,"7"-8,3-5,7 -3,6 2,6 8,3 6 T,2 4*#1F,3 6,3-6 F F,* *</trace></ink>"""
    recording = load_recording(table(tmp_path, text, "a.inkml"))
    x = [1125, 1148, 1178, 1211, 1251, 1297, 1349, 1404, 1461, 1521, 1584, 1650]
    y = [18432, 18475, 18510, 18540, 18567, 18596, 18633, 18676, 18723, 18776, 18823, 18864]
    assert recording.position[:, 0].tolist() == x
    assert (-recording.position[:, 1]).tolist() == y
    assert recording.position[:, 2].tolist() == [4] * 8 + [31, 31, 0, 0]


@pytest.mark.parametrize("text", ["? 0, 1 1", "* 0"])
def test_a_place_that_is_unknown_is_named(tmp_path, text):
    text = f"<ink><traceFormat>{MM}</traceFormat><trace>{text}</trace></ink>"
    with pytest.raises(RecordingError, match="point 1: X or Y is unknown"):
        load_recording(table(tmp_path, text, "a.inkml"))


def test_what_is_defined_is_no_stroke(tmp_path):
    text = f"""<ink><definitions><trace xml:id="a">5 5</trace></definitions><traceFormat>{MM}
    </traceFormat><trace>1 1, 2 2</trace></ink>"""
    assert strokes_of(load_recording(table(tmp_path, text, "a.inkml"))) == [[1, 2]]


MOVED = '<mapping xml:id="m" type="affine"><matrix>2 0 10, 0 -3 5</matrix></mapping>'
TURNED = (
    '<mapping type="affine"><bind source="Y" target="X"/><bind source="X" target="Y"/>'
    "<matrix>1 0 0, 0 1 0</matrix></mapping>"
)
CANVAS = (
    '<canvas><traceFormat><channel name="X" units="cm"/><channel name="Y" units="cm" '
    'orientation="-ve"/></traceFormat></canvas>'
)


def mapped(tmp_path, context, more=""):
    file = tmp_path / "a.inkml"
    file.write_text(
        f'<ink><definitions>{more}<context xml:id="c">{context}</context></definitions>'
        '<trace contextRef="#c">1 2, 3 4</trace></ink>',
        "utf-8",
    )
    return load_recording(file, scale=1.0).position[:, :2].round(6).tolist()


@pytest.mark.parametrize(
    ("context", "more", "wanted"),
    [
        (f"<canvasTransform>{MOVED}</canvasTransform>", "", [[12, 1], [16, 7]]),
        (f"<canvasTransform>{TURNED}</canvasTransform>", "", [[2, -1], [4, -3]]),
        (f"<canvasTransform>{MOVED}</canvasTransform>{CANVAS}", "", [[120, -10], [160, -70]]),
        (
            '<canvasTransform><mapping mappingRef="#m"/></canvasTransform>',
            MOVED,
            [[12, 1], [16, 7]],
        ),
        ('<canvasTransform><mapping type="identity"/></canvasTransform>', "", [[1, -2], [3, -4]]),
        ("<canvasTransform/>", "", [[1, -2], [3, -4]]),
    ],
)
def test_points_lie_where_their_canvas_has_them(tmp_path, caplog, context, more, wanted):
    found = mapped(tmp_path, context, more)
    assert found[: len(wanted)] == wanted
    assert not caplog.messages


@pytest.mark.parametrize(
    "mapping",
    [
        '<mapping type="mathml"/>',
        '<mapping type="lookup"><table>1 2, 3 4</table></mapping>',
        '<mapping type="affine"/>',
        '<mapping type="affine"><matrix>1 0 0, 0 1</matrix></mapping>',
        '<mapping type="affine"><matrix>1 0 x, 0 1 0</matrix></mapping>',
        '<mapping type="affine"><matrix>1 0 0 0, 0 1 0 0</matrix></mapping>',
    ],
)
def test_a_mapping_that_is_not_affine_is_told(tmp_path, caplog, mapping):
    found = mapped(tmp_path, f"<canvasTransform>{mapping}</canvasTransform>")
    assert found[:2] == [[1, -2], [3, -4]]
    assert caplog.messages == ["a.inkml: left out: a mapping to a canvas that is not affine"]


def test_a_sheet_may_grow_to_the_left(tmp_path):
    text = """<ink><traceFormat><channel name="X" units="mm" orientation="-ve"/>
    <channel name="Y" units="mm" orientation="-ve"/></traceFormat><trace>3 4</trace></ink>"""
    recording = load_recording(table(tmp_path, text, "a.inkml"))
    assert recording.position[0, :2].tolist() == [-3, 4]


@needs_shared
def test_inkml_keeps_a_tablet_recording(tmp_path):
    recording = load_recording(SHARED / "wacom_ink.csv")
    save_recording(recording, tmp_path / "a.inkml")
    again = load_recording(tmp_path / "a.inkml")
    assert np.array_equal(again.time_ns, recording.time_ns)
    assert np.array_equal(again.position, recording.position)
    assert np.array_equal(again.pressure, recording.pressure)
    assert again.orientation == pytest.approx(recording.orientation, abs=1e-12)
    assert again.header == recording.header


def test_a_pad_that_knows_no_ink_is_dipped_before_every_stroke():
    pressure = np.array([0.4, 0.5, 0.0, 0.0, 0.3, 0.0])
    n = len(pressure)
    recording = Recording(
        np.arange(n) * 10_000_000,
        np.column_stack([np.arange(n), np.zeros(n), np.zeros(n)]),
        np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)),
        pressure,
        np.array([1, 1, 0, 0, 1, 0], np.int32),
    )
    marked = add_dips(recording)
    assert marked.buttons.tolist() == [1, 1, 0, DIP, 1, 0]
    assert recording.buttons.tolist() == [1, 1, 0, 0, 1, 0]
    assert add_dips(marked) is marked


# -- tables of numbers -------------------------------------------------------------------------


def read(lines: list[str], delimiter: str | None = ",") -> NumberTable:
    table = NumberTable(["time_ns", "x", "z"], "a.csv", {"time_ns"}, {"z"})

    def split(line: str) -> list[str] | None:
        row = line.strip()
        return [cell.strip().strip('"') for cell in row.split(delimiter)] if row else None

    text = TextLines(io.BytesIO("\n".join(["the names", *lines]).encode()), "a.csv")
    next(text)
    table.read(text, delimiter, split)
    return table


@pytest.fixture
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "_BLOCK", 40)
    monkeypatch.setattr(number_table, "_FEWEST", 2)
    monkeypatch.setattr(number_table, "_MOST", 7)


@pytest.mark.usefixtures("small_blocks")
def test_every_way_to_write_a_number_gives_what_python_reads() -> None:
    rng = random.Random(5)
    ways = ["{}", " {}", "{} ", '"{}"', "\t{}", "+{}"]
    floats = ["0.1", "1e-3", "7", "1_0.5", ".5", "5.", "123456789.123456789", "2.5E2", "1e18"]
    ints = ["0", "9007199254740993", "12", "1_000", "4611686018427387903"]
    rows = [(rng.choice(ints), rng.choice(floats), rng.choice([*floats, ""])) for _ in range(200)]
    table = read([",".join(rng.choice(ways).format(c) if c else c for c in row) for row in rows])
    assert len(table) == 200
    _, times = table.column("time_ns")
    assert times.dtype == np.int64
    assert times.tolist() == [int(row[0]) for row in rows]
    assert table.column("none", "x")[1].tolist() == [float(row[1]) for row in rows]
    z = table.column("z")[1]
    np.testing.assert_array_equal(z, [float(row[2] or "nan") for row in rows])
    assert [table.line(k) for k in (0, 3, 199)] == [2, 5, 201]
    table.drop("x", "none")
    assert table.column("x") is None


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("1,nan,2", "x is 'nan'; expected a finite number"),
        ("1,inf,2", "x is 'inf'; expected a finite number"),
        ("1,1e19,2", "x is '1e19'; expected a finite number"),
        ("1.0,1,2", "time_ns is '1.0'; expected an integer"),
        ("1e3,1,2", "time_ns is '1e3'; expected an integer"),
        ("99999999999999999999,1,2", "expected an integer"),
        ("4611686018427387904,1,2", "expected an integer"),
        ("1,,2", "x is ''; expected a finite number"),
        ("1,0x10,2", "x is '0x10'; expected a finite number"),
        ("1,1", "there are 2 columns; expected 3"),
        ("1,1,1,1", "there are 4 columns; expected 3"),
        ("1,1,1 # so", "z is '1 # so'; expected a finite number"),
    ],
)
def test_the_line_that_is_wrong_is_named(row: str, words: str) -> None:
    lines = [f"{k},1,2" for k in range(7)]
    with pytest.raises(RecordingError) as caught:
        read([*lines, row, *lines])
    assert str(caught.value).startswith("a.csv:9: ")
    assert words in str(caught.value)


def some_numbers(n: int) -> list[str]:
    """Decimals of all kinds, and some half-way between two floats, or a trifle beside that."""
    rng = random.Random(11)
    found = []
    while len(found) < n:
        value = abs(struct.unpack("<d", rng.randbytes(8))[0])
        if not 1e-9 < value < 1e15:
            value = 10.0 ** rng.uniform(-8.0, 15.0)
        found += [repr(value), f"{value:.{rng.randrange(12)}f}", f"{value:.{rng.randrange(17)}e}"]
        whole = rng.randrange(2**53, 2**54) | 1  # an odd one lies between two
        for trifle in (-1, 0, 1):
            found.append(f"{whole * 10 + trifle}e-1")
            found.append(f"{whole * 5**3 * 10 ** (19 - len(str(whole * 125))) + trifle}e-22")
    return found


def test_the_nearest_float_of_every_decimal_is_read() -> None:
    texts = some_numbers(3_000)
    table = read([f"{k},{text},1" for k, text in enumerate(texts)])
    assert table.column("x")[1].tolist() == [float(text) for text in texts]


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_empty_cells_and_lines_are_known_in_plain_blocks(end: str) -> None:
    """They are read by blocks: a large recording has them in every row."""
    rows = ["1,2,3", "", "2,-.5e1,", " ", "3, 4 ,", '"4","5",6']
    table = NumberTable(["time_ns", "x", "z"], "a.csv", {"time_ns"}, {"z"})
    text = TextLines(io.BytesIO(end.join(rows).encode()), "a.csv")
    table.read(text, ",", lambda line: pytest.fail("row by row"))
    assert table.column("time_ns")[1].tolist() == [1, 2, 3, 4]
    np.testing.assert_array_equal(table.column("z")[1], [3.0, np.nan, np.nan, 6.0])
    assert [table.line(k) for k in range(4)] == [1, 3, 5, 6]


def test_a_row_of_no_numbers_takes_no_room_for_its_columns() -> None:
    names = [f"c{k}" for k in range(9_000)]
    table = NumberTable(names, "a.csv")
    text = TextLines(io.BytesIO(b"\n" * 50_000 + b"1"), "a.csv")
    tracemalloc.start()
    try:
        with pytest.raises(RecordingError, match=r"a\.csv:50001: there are 1 columns"):
            table.read(text, ",", lambda line: line.split(",") if line.strip() else None)
        assert tracemalloc.get_traced_memory()[1] < 100e6
    finally:
        tracemalloc.stop()


def test_a_large_pad_takes_little_more_than_its_numbers(tmp_path: Path) -> None:
    n = 150_000
    rows = [f"{k // 5000},{k},{k % 97}.25,{k % 89}.5,0.25" for k in range(n)]
    file = tmp_path / "pad.csv"
    file.write_text("stroke,time_ms,x_mm,y_mm,pressure\n" + "\n".join(rows))
    del rows
    tracemalloc.start()
    try:
        recording = load_recording(file)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(recording) == n + 2 * 29
    assert peak < 120 * n, peak / n
    for name in ("orientation", "object_position", "object_orientation"):
        assert getattr(recording, name).strides[0] == 0, name
    with pytest.raises(ValueError, match="read-only"):
        recording.orientation[0] = 1.0


# -- units of a table that does not tell them ----------------------------------------------------


@pytest.mark.parametrize(
    ("columns", "row", "place", "told"),
    [
        ("time,x,y,pressure", "10,20,0.5", (10 * 25.4 / 96, -20 * 25.4 / 96), "1/96 inch"),
        ("time,x,y,force", "10,20,0.5", (10, 20), "a force in newtons"),
        ("time,x,y,z,pressure", "10,20,30,0.5", (10, 20), "there is z"),
        ("time,x_mm,y_mm,force", "10,20,0.5", (10, 20), ""),
        ("time,x_m,y_m,z_m,force", "0.01,0.02,0,0.5", (10, 20), "not by z"),
        ("time,x_cm,y_cm", "1,2", (10, 20), ""),
        ("time,x,y,z,qw,qx,qy,qz", "10,20,30,1,0,0,0", (10, 20), "x, y, z are taken for mm"),
        ("time,x_mm,y_mm,z_mm,qw,qx,qy,qz", "10,20,30,1,0,0,0", (10, 20), ""),
    ],
)
def test_a_robots_table_is_mm_and_a_screens_is_pixels(
    tmp_path: Path, columns: str, row: str, place: tuple[float, float], told: str
) -> None:
    recording = load_recording(table(tmp_path, f"{columns}\n0,{row}\n1,{row}\n"))
    assert recording.position[0, :2] == pytest.approx(place)
    notes = " ".join(recording.header.get("notes", ()))
    assert told in notes if told else not notes
    deep = columns in ("time,x,y,z,pressure", "time,x_m,y_m,z_m,force")
    assert ("not by z" in notes) == deep


def test_a_callers_unit_is_taken_at_its_word(tmp_path: Path) -> None:
    path = table(tmp_path, "time,x,y,force\n0,1,2,1\n1,1,2,1\n")
    recording = load_recording(path, scale=10.0, y_down=True)
    assert recording.position[0, :2] == pytest.approx((10.0, -20.0))
    assert "notes" not in recording.header
