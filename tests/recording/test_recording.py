"""Recordings: what is accepted, what is refused and in which words, and the JSON Lines form."""

from __future__ import annotations

import functools
import gzip
import json
from concurrent.futures import CancelledError
from pathlib import Path

import numpy as np
import pytest

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import load_brush
from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.errors import ExportError, RecordingError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.pose.brush_pose import brush_poses
from paint3d.recording.recording import Recording, load_recording, save_recording

HEADER = {"format": "paint3d-recording", "version": 1, "units": {"position": "mm"}}
SAMPLE = {
    "time_ns": 0,
    "position": [1.0, 2.0, 3.0],
    "orientation": [1.0, 0.0, 0.0, 0.0],
    "pressure": 0.5,
}


def write(path, *entries):
    path.write_text("".join((e if isinstance(e, str) else json.dumps(e)) + "\n" for e in entries))
    return path


def sample(**changes):
    return {**SAMPLE, **changes}


def small(n=3, **changes):
    fields = {
        "time_ns": np.arange(n) * 1_000_000,
        "position": np.arange(3.0 * n).reshape(n, 3),
        "orientation": np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)),
        "pressure": np.linspace(0.0, 1.0, n),
    }
    return Recording(**{**fields, **changes})


def test_reads_both_hands_and_holds_the_objects_pose(tmp_path):
    turned = {"position": [0, 0, 9], "orientation": [0, 1, 0, 0]}
    path = write(
        tmp_path / "a.jsonl",
        {**HEADER, "ink": "pine soot"},
        sample(),
        {"time_ns": 5, "right_hand": sample(force=7.9, pressure=None), "left": turned},
        sample(time_ns=9, buttons=3),
    )
    recording = load_recording(path)
    assert recording.time_ns.tolist() == [0, 5, 9]
    assert recording.pressure.tolist() == [0.5, 1.0, 0.5]
    assert recording.object_position.tolist() == [[0, 0, 0], [0, 0, 9], [0, 0, 9]]
    assert recording.object_orientation.tolist() == [[1, 0, 0, 0], [0, 1, 0, 0], [0, 1, 0, 0]]
    assert recording.buttons.tolist() == [0, 0, 3]
    assert recording.header["ink"] == "pine soot"
    assert recording.header["space"] == "world"


def test_metres_become_millimetres(tmp_path):
    path = write(tmp_path / "a.jsonl", {**HEADER, "units": {"position": "m"}}, sample())
    recording = load_recording(path)
    assert recording.position.tolist() == [[1000.0, 2000.0, 3000.0]]
    assert recording.header["units"]["position"] == "mm"


@pytest.mark.parametrize(
    ("entries", "line", "words"),
    [
        ([HEADER, sample(pressure=1.7)], 2, "pressure is 1.7; expected 0 to 1"),
        ([HEADER, sample(pressure=-0.1)], 2, "pressure is -0.1"),
        ([HEADER, sample(pressure=None, force=8.0)], 2, "force is 8.0; expected 0 to 7.9 N"),
        ([HEADER, sample(pressure="1")], 2, "pressure is '1'"),
        ([HEADER, sample(pressure=True)], 2, "pressure is True"),
        ([HEADER, sample(time_ns=5), sample(time_ns=4)], 3, "time_ns is 4; expected more than 5"),
        ([HEADER, sample(time_ns=5), sample(time_ns=5)], 3, "time_ns is 5; expected more than 5"),
        ([HEADER, sample(time_ns=0.5)], 2, "time_ns is 0.5; expected an integer"),
        ([HEADER, sample(position=[1, float("nan"), 2])], 2, "a number is NaN"),
        ([HEADER, sample(position=[1, float("inf"), 2])], 2, "a number is Infinity"),
        ([HEADER, '{"time_ns":0,"position":[1e999,0,0]}'], 2, "position holds inf"),
        ([HEADER, sample(position=[1, 2])], 2, "position is [1, 2]; expected 3 numbers"),
        ([HEADER, sample(orientation=[1, 1, 0, 0])], 2, "orientation has length 1.41421"),
        ([HEADER, {"time_ns": 0, "position": [0, 0, 0]}], 2, "orientation is missing"),
        ([HEADER, {**SAMPLE, "presure": 1}], 2, "a key is 'presure'; expected 'pressure'"),
        ([HEADER, sample(), sample(time_ns=1, pressure=None)], 3, "expected it in all samples"),
        ([HEADER, "not json"], 2, "the line is not JSON"),
        ([HEADER, "[" * 5000], 2, "the line is not JSON"),
        ([HEADER, "[1]"], 2, "the line is a JSON list; expected an object"),
        ([HEADER], 2, "there are no samples"),
        ([{**HEADER, "version": 2}, sample()], 1, "version is 2; expected 1"),
        ([{**HEADER, "format": "x"}, sample()], 1, "format is 'x'; expected 'paint3d-recording'"),
        ([SAMPLE], 1, "the header has no 'format'"),
        ([{**HEADER, "units": {"position": "ell"}}, sample()], 1, "units: position is 'ell'"),
        ([{**HEADER, "space": "moon"}, sample()], 1, "space is 'moon'; expected world or pad"),
        ([HEADER, sample(buttons=-1)], 2, "buttons is -1"),
    ],
)
def test_faults_are_named_with_file_and_line(tmp_path, entries, line, words):
    path = write(tmp_path / "bad.jsonl", *entries)
    with pytest.raises(RecordingError) as caught:
        load_recording(path)
    assert str(caught.value).startswith(f"bad.jsonl:{line}: ")
    assert words in str(caught.value)


def test_empty_and_missing_files_are_refused(tmp_path):
    (tmp_path / "empty.jsonl").write_bytes(b"")
    with pytest.raises(RecordingError, match=r"empty\.jsonl:1: the file is empty"):
        load_recording(tmp_path / "empty.jsonl")
    with pytest.raises(RecordingError, match="cannot be read"):
        load_recording(tmp_path / "nowhere.jsonl")
    (tmp_path / "noise.bin").write_bytes(b"\x00\x01\x02")
    with pytest.raises(RecordingError, match="expected JSON Lines, InkML, CSV"):
        load_recording(tmp_path / "noise.bin")


def test_bytes_that_are_not_utf8_are_refused(tmp_path):
    path = write(tmp_path / "a.jsonl", HEADER, sample())
    path.write_bytes(path.read_bytes() + b'{"time_ns": "\xff"}\n')
    with pytest.raises(RecordingError, match=r"a\.jsonl:3: byte 13 is not UTF-8"):
        load_recording(path)


def test_gzip_is_told_by_its_contents(tmp_path):
    plain = write(tmp_path / "a.jsonl", HEADER, sample())
    packed = tmp_path / "b.jsonl"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    assert load_recording(packed).position.tolist() == load_recording(plain).position.tolist()


def test_truncated_gzip_is_refused(tmp_path):
    plain = write(tmp_path / "a.jsonl", HEADER, sample())
    packed = gzip.compress(plain.read_bytes())
    (tmp_path / "c.jsonl.gz").write_bytes(packed[:-9])
    with pytest.raises(RecordingError, match="damaged or cut short"):
        load_recording(tmp_path / "c.jsonl.gz")


def test_a_line_that_never_ends_is_refused_without_reading_it_all(tmp_path):
    path = tmp_path / "bomb.jsonl.gz"
    path.write_bytes(gzip.compress(b'{"a":"' + b"x" * 50_000_000))
    with pytest.raises(RecordingError, match=r"bomb\.jsonl\.gz:1: the line is longer than 65536"):
        load_recording(path)


def test_saving_is_deterministic_and_leaves_nothing_behind(tmp_path):
    for name in ("one.jsonl.gz", "two.jsonl.gz"):
        save_recording(small(), tmp_path / name)
    assert (tmp_path / "one.jsonl.gz").read_bytes() == (tmp_path / "two.jsonl.gz").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["one.jsonl.gz", "two.jsonl.gz"]


def test_a_failed_save_keeps_the_old_file(tmp_path):
    target = tmp_path / "a.inkml"
    target.write_text("old")
    with pytest.raises(RecordingError, match="InkML holds 'pad' recordings only"):
        save_recording(small(), target)
    assert target.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.inkml"]


def test_unknown_suffixes_and_folders_are_refused(tmp_path):
    with pytest.raises(ExportError, match=r"suffix is '\.mp3'"):
        save_recording(small(), tmp_path / "a.mp3")
    with pytest.raises(ExportError, match="cannot write here"):
        save_recording(small(), tmp_path / "none" / "a.jsonl")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"time_ns": np.array([0, 2, 2])}, "sample 2: time_ns is 2; expected more than 2"),
        ({"time_ns": np.zeros(0, dtype=np.int64)}, "no samples"),
        ({"time_ns": np.array([0.0, 1.0, 2.0])}, "expected (N,) integers"),
        ({"position": np.zeros((2, 3))}, "position has shape (2, 3)"),
        ({"orientation": np.full((3, 4), 0.6)}, "sample 0: orientation has length 1.2"),
        ({"pressure": np.array([0.0, 0.5, 1.01])}, "sample 2: pressure is 1.01"),
        ({"pressure": np.array([0.0, np.nan, 1.0])}, "expected a finite number"),
        ({"buttons": np.array([0, -1, 0])}, "sample 1: buttons is -1"),
        ({"header": {"azimuth": "free"}}, "azimuth is 'free'"),
    ],
)
def test_the_dataclass_checks_itself(changes, words):
    with pytest.raises(RecordingError) as caught:
        small(**changes)
    assert words in str(caught.value)


def test_quaternions_a_little_off_are_normalised():
    recording = small(orientation=np.tile([1.0005, 0.0, 0.0, 0.0], (3, 1)))
    assert np.linalg.norm(recording.orientation, axis=1) == pytest.approx(1.0, abs=1e-15)


def test_arrays_are_private_and_read_only():
    position = np.zeros((3, 3))
    recording = small(position=position)
    position[0] = 9.0
    assert recording.position[0].tolist() == [0.0, 0.0, 0.0]
    with pytest.raises(ValueError, match="read-only"):
        recording.position[0] = 1.0


def test_a_recording_plays_back_as_a_device():
    samples = list(small().samples())
    assert [s.time_ns for s in samples] == [0, 1_000_000, 2_000_000]
    assert samples[2].pressure == 1.0
    assert samples[1].position.tolist() == [3.0, 4.0, 5.0]


@pytest.mark.parametrize("suffix", [".csv", ".csv.gz", ".jsonl"])
def test_the_share_that_is_read_is_told_and_can_stop_it(tmp_path, suffix):
    n = 40_000
    times, zeros = np.arange(n) * 1_000_000, np.zeros((n, 3))
    recording = Recording(times, zeros, np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)))
    file = tmp_path / f"long{suffix}"
    save_recording(recording, file)
    shares = []
    load_recording(file, progress=shares.append)
    assert len(shares) >= 2
    assert shares == sorted(shares)
    assert 0.0 < shares[0] < shares[-1] <= 1.0

    def stop(share):
        raise CancelledError

    with pytest.raises(CancelledError):
        load_recording(file, progress=stop)


# -- the demo's recording ----------------------------------------------------------------------


FILE = Path(__file__).parents[2] / "paint3d/calligraphy/data/demo.jsonl.gz"


@functools.cache
def recording():
    return load_recording(FILE)


@functools.cache
def path():
    return brush_poses(recording())


def strokes():
    down = path().pressure > 0.0
    return np.count_nonzero(down[1:] & ~down[:-1]), down


def test_header_says_what_and_whose():
    header = recording().header
    assert [c["text"] for c in header["characters"]] == list("漫步人生")
    assert "Arphic Public License" in header["licence"]
    assert (FILE.parent / "LICENCE.md").read_text(encoding="utf-8").count("Arphic") >= 3
    assert (header["brush"], header["object"], header["space"]) == ("xiaobaiyun", "bowl", "world")


def test_it_takes_a_hand_s_time_and_little_room():
    assert 40.0 <= recording().duration_s <= 80.0
    assert FILE.stat().st_size < 1_500_000
    assert np.all(np.diff(recording().time_ns) == 4_000_000)


def test_every_stroke_is_written():
    n, down = strokes()
    assert n == 14 + 7 + 2 + 5
    assert not down[0]
    assert not down[-1]


def test_brush_is_dipped_once_a_character_and_only_lifted():
    dipped = recording().buttons == 2
    assert np.count_nonzero(np.diff(np.r_[0, dipped.astype(int)]) == 1) == 4
    assert (path().pressure[dipped] == 0.0).all()


def test_root_stands_over_the_bowl_as_the_pressure_says():
    """Root height is LE - D_s, and the upright holder follows the normal, on the outside."""
    tuft = build_tuft(load_brush(recording().header["brush"]))
    _, down = strokes()
    at = np.flatnonzero(down)[::20]
    up = matrices_from_quaternions(path().orientation[at])[:, :, 2]
    height = tuft.length - path().pressure[at] * tuft.full_press
    feet = path().position[at] - height[:, None] * up
    found = ClosestPoints(load_mesh("bowl")).find(feet)
    assert np.linalg.norm(found.points - feet, axis=1).max() < 0.05  # mm
    assert np.einsum("ij,ij->i", found.normals, up).min() > 0.999
    radius = np.linalg.norm(found.points[:, :2], axis=1)
    outward = np.einsum("ij,ij->i", found.normals[:, :2], found.points[:, :2]) / radius
    assert outward.min() > 0.5


def test_characters_stand_upright_in_a_column():
    frames = [c["frame"] for c in recording().header["characters"]]
    heights = [frame["origin"][2] for frame in frames]
    assert (np.diff(heights) < -5.0).all()
    for frame in frames:
        assert frame["y_axis"][2] > 0.6
        assert abs(frame["x_axis"][2]) < 0.02


def test_left_hand_turns_the_bowl_while_the_right_writes():
    turn = np.sum(recording().object_orientation[0] * recording().object_orientation, axis=1)
    degrees = np.degrees(2.0 * np.arccos(np.clip(np.abs(turn), 0.0, 1.0)))
    assert np.ptp(degrees) > 8.0
    _, down = strokes()
    step = np.abs(np.diff(degrees))
    assert step.max() * 250.0 < 60.0  # degrees a second
    assert np.median(step[down[1:]]) > 0.0


def test_hand_keeps_its_limits_on_the_bowl():
    speed = np.diff(path().position, axis=0) * 250.0
    _, down = strokes()
    near = down[1:] & down[:-1]
    assert np.linalg.norm(speed[near], axis=1).max() < 120.0
    acceleration = np.diff(speed, axis=0)[near[1:] & near[:-1]] * 250.0
    assert np.linalg.norm(acceleration, axis=1).max() < 1000.0
