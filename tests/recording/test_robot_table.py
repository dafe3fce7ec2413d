"""Tables of robots: their columns, units, frames and forces, and what is said of each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.device.recorded import MAX_FORCE_N, Recording
from paint3d.errors import InputError, RecordingError
from paint3d.painter.pose_check import fit_to_tuft
from paint3d.recording.flat_recording import notes_of
from paint3d.recording.recording import load_recording

WAY = [f"0.0{k},0,0.04,0,0,0,1" for k in range(1, 6)]
NAMED = "x_m,y_m,z_m,qx,qy,qz,qw"


def read(folder: Path, columns: str, rows: list[str], header: str = "") -> Recording:
    """The recording of a table whose first column is the time, a row every 0.1 s."""
    file = folder / "robot.csv"
    lines = [f"time,{columns}", *(f"{0.1 * k:.1f},{row}" for k, row in enumerate(rows))]
    file.write_text("\n".join([header, *lines] if header else lines) + "\n")
    return load_recording(file)


def said(recording: Recording) -> str:
    return "\n".join(notes_of(recording.header))


def with_forces(*forces: object) -> list[str]:
    return [f"{WAY[k % len(WAY)]},{force}" for k, force in enumerate(forces)]


# -- columns and forces --------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["force", "force_n", "fz", "fz_n", "Force_Z"])
def test_a_force_has_several_names(tmp_path: Path, name: str) -> None:
    recording = read(tmp_path, f"{NAMED},{name}", with_forces(0, 1, 2, 1, 0))
    assert recording.pressure * MAX_FORCE_N == pytest.approx([0, 1, 2, 1, 0])
    assert not said(recording)


def test_columns_that_are_not_read_are_told_and_logged(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rows = [f"{row},1,7,8" for row in WAY]
    recording = read(tmp_path, f"{NAMED},fz,fx,joint_1", rows)
    assert said(recording) == "columns not read: fx, joint_1"
    assert "robot.csv: columns not read: fx, joint_1" in caplog.text


def test_a_force_that_is_negative_throughout_is_turned(tmp_path: Path) -> None:
    recording = read(tmp_path, f"{NAMED},fz", with_forces(0.02, -1, -2, -1, 0))
    assert recording.pressure * MAX_FORCE_N == pytest.approx([0, 1, 2, 1, 0])
    assert "fz is negative throughout: its sign is turned" in said(recording)


def test_a_force_of_both_signs_is_refused_with_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"robot\.csv:4: fz is -1; .*take the offset off"):
        read(tmp_path, f"{NAMED},fz", with_forces(1, 2, -1, 0, 0))


def test_noise_in_the_air_makes_no_stroke_and_is_told(tmp_path: Path) -> None:
    forces = (1, 2, 1, -0.05, 0.1, -0.1, 0.15, 0.1, -0.02, 0.5, 0.1, 0)
    recording = read(tmp_path, f"{NAMED},fz", with_forces(*forces))
    kept = [1, 2, 1, 0, 0, 0, 0, 0, 0, 0.5, 0.1, 0]
    assert recording.pressure * MAX_FORCE_N == pytest.approx(kept)
    assert "fz lies between -0.1 and 0 N in 3 samples: they count as 0" in said(recording)
    assert "2 touches of less than 0.2 s and at most 0.2 N are left out" in said(recording)


def test_a_light_stroke_and_a_light_log_are_no_noise(tmp_path: Path) -> None:
    long = (2, 0, 0.1, 0.1, 0.1, 0.1, 0)
    recording = read(tmp_path, f"{NAMED},fz", with_forces(*long))
    assert recording.pressure * MAX_FORCE_N == pytest.approx(long)
    light = (0, 0.05, 0, 0.05, 0)
    recording = read(tmp_path, f"{NAMED},fz", with_forces(*light))
    assert recording.pressure * MAX_FORCE_N == pytest.approx(light)
    with pytest.raises(RecordingError, match=r"fz is -0\.04"):  # of a tenth of a newton
        read(tmp_path, f"{NAMED},fz", with_forces(0, 0.1, -0.04, 0.1, 0))


def test_contacts_without_a_force_name_the_column_that_is_not_read(tmp_path: Path) -> None:
    columns = f"{NAMED},forse,contact_x_m,contact_y_m,contact_z_m"
    with pytest.raises(RecordingError, match=r"not read: forse\); .* force, force_n, fz"):
        read(tmp_path, columns, [f"{row},1,0,0,0" for row in WAY])


# -- units ---------------------------------------------------------------------------------------


def test_a_path_that_spans_nothing_asks_for_its_unit(tmp_path: Path) -> None:
    recording = read(tmp_path, "x,y,z,qx,qy,qz,qw", WAY)
    assert "x, y, z are taken for mm" in said(recording)
    assert "x, y, z span 0.04 mm in all; expected metres? name the columns x_m" in said(recording)
    assert not said(read(tmp_path, NAMED, WAY))


def test_a_tip_that_spans_nothing_asks_for_its_unit_however_the_handle_sways(
    tmp_path: Path,
) -> None:
    turns = [(np.sin(0.05 * k), np.cos(0.05 * k)) for k in range(5)]
    rows = [f"0,0,{0.001 * k:g},{x:.9f},0,0,{w:.9f}" for k, (x, w) in enumerate(turns)]
    recording = read(tmp_path, "tip_x,tip_y,tip_z,qx,qy,qz,qw", rows)
    assert "expected metres? name the columns tip_x_m" in said(recording)


def test_strokes_that_span_nothing_ask_for_their_unit(tmp_path: Path) -> None:
    far = ["30,0,0,0,0,0,1", *WAY]
    rows = [f"{row},{force}" for row, force in zip(far, (0, 1, 1, 0, 1, 1), strict=True)]
    assert "no stroke spans more than 0.01 mm" in said(
        read(tmp_path, "x_mm,y_mm,z_mm,qx,qy,qz,qw,force", rows)
    )


@pytest.mark.parametrize(("unit", "scale"), [("_mm", 1.0), ("_cm", 10.0), ("_m", 1000.0)])
def test_contacts_and_objects_have_the_units_of_places(
    tmp_path: Path, unit: str, scale: float
) -> None:
    names = ",".join(f"{of}_{axis}{unit}" for of in ("contact", "object") for axis in "xyz")
    rows = [f"{row},1,{k},2,3,4,5,6" for k, row in enumerate(WAY)]
    recording = read(tmp_path, f"{NAMED},force,{names}", rows)
    assert recording.contact[2] == pytest.approx(np.array([2, 2, 3]) * scale)
    assert recording.object_position[0] == pytest.approx(np.array([4, 5, 6]) * scale)
    assert recording.object_orientation[0].tolist() == [1, 0, 0, 0]


def test_a_headers_units_are_those_of_columns_without_one(tmp_path: Path) -> None:
    header = '# {"units": {"position": "m", "time": "ms"}}'
    recording = read(tmp_path, "x,y,z,qx,qy,qz,qw", WAY, header)
    assert recording.position[0] == pytest.approx([10, 0, 40])
    assert recording.time_ns.tolist() == [0, 100_000, 200_000, 300_000, 400_000]
    assert recording.header["units"] == {"position": "mm", "time": "ns", "force": "N"}
    assert not said(recording)
    pad = read(tmp_path, "x,y,pressure", ["0.01,0.02,.5", "0.03,0.04,.5"], header)
    assert pad.position[0, :2] == pytest.approx([10, 20])


@pytest.mark.parametrize(
    ("units", "words"),
    [
        ('{"position": "ell"}', "units: position is 'ell'; expected mm or cm or m or in"),
        ('{"force": "kg"}', "units: force is 'kg'; expected N"),
        ('{"torque": "N"}', "units has torque; expected position, time, force"),
        ('{"position": "mm"}', "units: position is mm, and a column is x_m"),
    ],
)
def test_units_that_are_not_heeded_are_refused(tmp_path: Path, units: str, words: str) -> None:
    with pytest.raises(RecordingError) as caught:
        read(tmp_path, NAMED, WAY, f'# {{"units": {units}}}')
    assert words in str(caught.value)


# -- frames --------------------------------------------------------------------------------------


def test_a_tools_z_points_at_the_work(tmp_path: Path) -> None:
    half = 2**-0.5  # a quarter turn about y: the tool's z lies along x
    rows = [f"0.0{k},0,0,0,{half},0,{half}" for k in range(1, 4)]
    recording = read(tmp_path, "x_m,y_m,z_m,tool_qx,tool_qy,tool_qz,tool_qw", rows)
    axes = matrices_from_quaternions(recording.orientation)[0]
    assert axes[:, 2] == pytest.approx([-1, 0, 0])
    assert axes[:, 0] == pytest.approx([0, 0, -1])
    assert np.linalg.det(axes) == pytest.approx(1.0)


@pytest.mark.parametrize(
    "columns", ["x_m,y_m,z_m,qx,qy,qz,q", f"{NAMED[:-2]}qw,object_x,object_qx"]
)
def test_half_an_orientation_is_refused(tmp_path: Path, columns: str) -> None:
    rows = [row + ",0,1" if "object" in columns else row for row in WAY]
    with pytest.raises(RecordingError, match=r"robot\.csv: there is no column"):
        read(tmp_path, columns, rows)


def test_a_tip_without_an_orientation_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"robot\.csv: a tip is told without an orientation"):
        read(tmp_path, "tip_x,tip_y,tip_z,fz", ["1,2,3,1"])


@pytest.mark.parametrize("with_force", [True, False])
def test_a_tip_is_the_place_that_is_meant(tmp_path: Path, with_force: bool) -> None:
    force = ",fz" if with_force else ""
    rows = with_forces(0, 1, 2, 1, 0) if with_force else WAY
    columns = f"tip_x_m,tip_y_m,tip_z_m,qx,qy,qz,qw{force}"
    recording = read(tmp_path, columns, rows)
    assert recording.header["tuft_mm"] == 35.0
    assert recording.position[0] == pytest.approx([10, 0, 40 + 35])
    if with_force:
        assert recording.contact[0] == pytest.approx([10, 0, 40])
    else:
        assert recording.contact is None


@pytest.mark.parametrize("length", [True, "35", float("nan"), -1.0, 1e9])
def test_a_tufts_length_that_is_none_is_refused(length) -> None:
    recording = Recording(
        [0], [[0.0, 0.0, 35.0]], [[1.0, 0.0, 0.0, 0.0]], header={"tuft_mm": length}
    )
    with pytest.raises(InputError, match="tuft_mm is"):
        fit_to_tuft(recording, 52.0)
