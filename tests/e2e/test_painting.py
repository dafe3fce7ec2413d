"""The program paints: same input, same bytes; the report adds up; the demo leaves its files."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from paint3d.cli import demo
from paint3d.cli.main import main


def replay(paint3d, recording: Path, out: Path, *options: object, **environment: str) -> bytes:
    done = paint3d("replay", recording, "--on", "plane", "--out", out, *options, **environment)
    assert done.returncode == 0, done.stderr
    return out.read_bytes()


def test_replaying_twice_gives_the_same_bytes(paint3d, recording: Path, tmp_path: Path) -> None:
    first = replay(paint3d, recording, tmp_path / "a.ply")
    second = replay(paint3d, recording, tmp_path / "b.ply")
    assert first == second


@pytest.mark.long  # tests/laws asks it of the engine
def test_the_number_of_threads_does_not_matter(paint3d, recording: Path, tmp_path: Path) -> None:
    one = replay(paint3d, recording, tmp_path / "a.ply", NUMBA_NUM_THREADS="1")
    two = replay(paint3d, recording, tmp_path / "b.ply", NUMBA_NUM_THREADS="2")
    assert one == two


def test_pressure_reaches_the_painting(paint3d, save, lines, tmp_path: Path) -> None:
    heavy = save(tmp_path / "heavy.jsonl", lines)
    light_lines = [dict(line) for line in lines]
    for line in light_lines[1:]:
        line["pressure"] *= 0.4
    light = save(tmp_path / "light.jsonl", light_lines)
    painted = []
    for recording in (light, heavy):
        report = tmp_path / f"{recording.stem}.json"
        replay(paint3d, recording, tmp_path / "out.ply", "--report", report)
        painted.append(json.loads(report.read_text())["vertices_painted"])
    assert 0 < painted[0] < 0.8 * painted[1]


def test_the_report_adds_up(paint3d, recording: Path, tmp_path: Path) -> None:
    report = tmp_path / "report.json"
    replay(paint3d, recording, tmp_path / "a.ply", "--report", report, "--quiet")
    told = json.loads(report.read_text())
    assert told["samples"] == 40
    assert told["footprints"] > 0
    assert 0 < told["vertices_painted"] <= told["vertices_visited"]
    ink = told["ink_ledger"]
    kept = ink["in_brush"] + ink["wet"] + ink["dry"] + ink["off_surface"]
    assert kept == pytest.approx(ink["loaded"], rel=1e-5)
    assert ink["wet"] > 0
    assert told["versions"]["paint3d"]
    assert all(seconds >= 0 for seconds in told["seconds"].values())


def test_quiet_says_nothing(paint3d, recording: Path, tmp_path: Path) -> None:
    out = tmp_path / "a.ply"
    done = paint3d("replay", recording, "--on", "plane", "--out", out, "--quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    done = paint3d("replay", recording, "--on", "plane", "--out", out)
    assert done.stdout.startswith(f"{out}: 40 samples, ")
    assert done.stderr == ""


def test_with_a_pressure_the_position_says_only_where(paint3d, save, lines, tmp_path: Path) -> None:
    """The root is 30 mm up; xiaokai is 22 mm long."""
    near = [lines[0], *({**line, "position": [*line["position"][:2], 15]} for line in lines[1:])]
    replay(paint3d, save(tmp_path / "near.jsonl", near), tmp_path / "a.ply", "--brush", "xiaokai")
    replay(paint3d, save(tmp_path / "far.jsonl", lines), tmp_path / "b.ply", "--brush", "xiaokai")
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"pressure": 0.0}, "its pressure is 0 throughout"),
        ({"pressure": None}, "comes as near as 60.0 mm, and full is 35 mm long"),
        ({"orientation": [0, 1, 0, 0]}, "60.0 mm off at the least, or behind it"),
        ({"position": [900, 0, 30]}, "where it presses, the tuft's root is beside the surface"),
    ],
)
def test_a_replay_that_paints_nothing_says_so(
    paint3d, save, lines, tmp_path: Path, change: dict, reason: str
) -> None:
    for line in lines[1:]:
        line["position"] = [*line["position"][:2], 60]
        line.update(change)
        if line["pressure"] is None:
            del line["pressure"]
    recording = save(tmp_path / "air.jsonl", lines)
    done = paint3d("replay", recording, "--on", "plane", "--out", tmp_path / "a.ply")
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith(f"paint3d: error: {recording}: the brush never touches plane: ")
    assert done.stderr.count("\n") == 1
    assert reason in done.stderr
    assert not (tmp_path / "a.ply").exists()


@pytest.mark.long
def test_demo(paint3d, tmp_path: Path) -> None:
    out = tmp_path / "new" / "demo"
    done = paint3d("demo", "--out", out, "--no-view")
    assert done.returncode == 0, done.stderr
    check_demo(out, done.stdout, 10_000)


@pytest.mark.usefixtures("small_pictures")
def test_a_coarse_demo(tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same in this process, with fewer vertices, lights and pixels."""
    monkeypatch.setattr(demo, "_RESOLUTION_MM", 0.6)
    out = tmp_path / "new" / "demo"
    assert main(["demo", "--out", str(out), "--no-view"]) == 0
    check_demo(out, capsys.readouterr().out, 500)


def check_demo(out: Path, told: str, n_painted: int) -> None:
    """Everything that it leaves is there, and told."""
    names = {"bowl.ply", "bowl.glb", "bowl.p3d.txt", "bowl.png", "bowl.p3d", "report.json"}
    assert {file.name for file in out.iterdir()} == names
    assert all(file.stat().st_size > 1000 for file in out.iterdir())
    assert all(str(out / name) in told for name in names)
    assert json.loads((out / "report.json").read_text())["vertices_painted"] > n_painted


@pytest.mark.parametrize("command", ["demo", "replay", "export", "inks", "report"])
def test_every_command_has_help(paint3d, command: str) -> None:
    done = paint3d(command, "--help")
    assert done.returncode == 0
    assert done.stdout.startswith(f"usage: paint3d {command}")
    listed = paint3d("--help").stdout
    assert f"    {command}" in listed


def test_the_version_is_told(paint3d) -> None:
    done = paint3d("--version")
    assert done.returncode == 0
    assert done.stdout.startswith("paint3d ")


def write_pad(file: Path) -> Path:
    """A pad's recording of one stroke, 30 mm wide, far from the pad's origin."""
    rows = [f"{0.01 * i},{500 + i},{300 + 0.2 * i},{0.3 if 0 < i < 30 else 0}" for i in range(31)]
    file.write_text("\n".join(["time_s,x_mm,y_mm,pressure", *rows]) + "\n")
    return file


@pytest.mark.parametrize(("width", "place"), [(30.0, 0.5), (12.0, 0.3)])
def test_a_pads_recording_is_laid_where_and_as_wide_as_asked(
    paint3d, tmp_path: Path, width: float, place: float
) -> None:
    pad = write_pad(tmp_path / "pad.csv")
    out = tmp_path / "out.p3d.txt"
    replay(paint3d, pad, out, "--at", f"{place},0.5", "--size", width, "--brush", "gongbi")
    records = read_records(out)
    bare = np.median(records[:, 6:], axis=0)
    x = records[np.abs(records[:, 6:] - bare).max(axis=1) > 40, 0]
    assert (x.max() + x.min()) / 2 == pytest.approx(200 * (place - 0.5), abs=3)
    assert x.max() - x.min() == pytest.approx(width, abs=6)


def read_records(file: Path) -> np.ndarray:
    """The nine numbers of each vertex: position, normal, RGB."""
    words = re.findall(r"^\{(.*)\}", file.read_text(), flags=re.MULTILINE)
    return np.array([[float(word) for word in line.split(",")] for line in words])


def test_a_place_is_for_pads_only(paint3d, recording: Path, tmp_path: Path) -> None:
    out = tmp_path / "a.ply"
    done = paint3d("replay", recording, "--on", "plane", "--out", out, "--at", "0.5,0.5")
    assert done.returncode == 2
    assert "has its own place in the world" in done.stderr
    assert not out.exists()


def test_a_point_cloud_is_painted_and_said_to_be_one(
    paint3d, recording: Path, tmp_path: Path
) -> None:
    rows = [f"v {3 * i - 45} {3 * j - 45} 0" for i in range(31) for j in range(31)]
    cloud = tmp_path / "cloud.obj"
    cloud.write_text("\n".join(rows))
    out = tmp_path / "a.ply"
    done = paint3d("replay", recording, "--on", cloud, "--out", out)
    assert done.returncode == 0, done.stderr
    assert out.exists()
    # beside how far it is, where that takes long
    assert [line for line in done.stderr.splitlines() if line.startswith("paint3d: ")] == [
        f"paint3d: note: {cloud}: it is a point cloud: built 1,800 triangles through 961 points"
    ]


def test_a_session_is_left_and_exported(paint3d, recording: Path, tmp_path: Path) -> None:
    options = ("--ink", "cinnabar", "--resolution", "0.7")
    direct = replay(paint3d, recording, tmp_path / "direct.ply", *options)
    replay(paint3d, recording, tmp_path / "a.p3d", *options)
    done = paint3d("export", tmp_path / "a.p3d", tmp_path / "later.ply")
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "later.ply").read_bytes() == direct
    done = paint3d("export", tmp_path / "a.p3d", tmp_path / "b.p3d")
    assert (tmp_path / "b.p3d").read_bytes() == (tmp_path / "a.p3d").read_bytes()
    done = paint3d("export", tmp_path / "a.p3d", tmp_path / "c.p3d.txt", "--unlit")
    assert done.returncode == 2
    assert "paint3d: error: " in done.stderr


def test_inks_are_listed_with_their_sources(paint3d) -> None:
    done = paint3d("inks")
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    assert lines[0].split()[-1] == "source"
    assert sum(line.startswith("pine soot") for line in lines) == 1
    assert "\x1b" not in done.stdout


def test_an_object_is_stood_up_on_request(paint3d, recording: Path, tmp_path: Path) -> None:
    from paint3d.files.export import export
    from paint3d.files.load import load_mesh
    from paint3d.mesh.upright import turn_mesh, turn_up

    lying, out = tmp_path / "lying.ply", tmp_path / "a.ply"
    export(turn_mesh(load_mesh("plane"), turn_up("-x").T), lying)
    for up in ("-x", "auto"):
        done = paint3d("replay", recording, "--on", lying, "--out", out, f"--up={up}")
        assert done.returncode == 0, done.stderr
        assert np.ptp(load_mesh(out).vertices, axis=0).argmin() == 2
    done = paint3d("replay", recording, "--on", lying, "--out", out)
    assert done.returncode == 2
    assert "the brush never touches lying" in done.stderr
    done = paint3d("replay", recording, "--on", lying, "--out", out, "--up=w")
    assert done.returncode == 2
    assert "--up" in done.stderr


def test_notes_that_a_stranger_wrote_into_a_header_break_nothing(
    paint3d, save, lines, tmp_path: Path
) -> None:
    for k, notes in enumerate((5, "text", [1, None, "told"])):
        header, *samples = (dict(line) for line in lines)
        file = save(tmp_path / f"{k}.jsonl", [{**header, "notes": notes}, *samples])
        done = paint3d("replay", file, "--on", "plane", "--out", tmp_path / f"{k}.ply")
        assert done.returncode == 0
        assert "Traceback" not in done.stderr
        assert ("told" in done.stderr) == (k == 2)
