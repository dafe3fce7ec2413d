"""Recordings of pads: tables, InkML, angles, scale, ties and pen lifts."""

import math
from pathlib import Path

import numpy as np
import pytest

from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.device.sample import DIP
from paint3d.errors import RecordingError
from paint3d.painter.flat_input import dipped
from paint3d.recording.flat_recording import MM_PER_PIXEL, orientations_from_angles, spread_ties
from paint3d.recording.recording import Recording, load_recording, save_recording

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
    times, n_moved = spread_ties(np.array([0, 10, 10, 10, 40, 50, 50]))
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
    marked = dipped(recording)
    assert marked.buttons.tolist() == [1, 1, 0, DIP, 1, 0]
    assert recording.buttons.tolist() == [1, 1, 0, 0, 1, 0]
    assert dipped(marked) is marked
