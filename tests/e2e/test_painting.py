"""The program paints: same input, same bytes; the report adds up; the demo leaves its files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest


def replay(paint3d, recording: Path, out: Path, *options: object, **environment: str) -> bytes:
    done = paint3d("replay", recording, "--on", "plane", "--out", out, *options, **environment)
    assert done.returncode == 0, done.stderr
    return out.read_bytes()


def test_replaying_twice_gives_the_same_bytes(paint3d, recording: Path, tmp_path: Path) -> None:
    first = replay(paint3d, recording, tmp_path / "a.ply")
    second = replay(paint3d, recording, tmp_path / "b.ply")
    assert first == second


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


def test_a_surface_that_is_never_touched_stays_bare(paint3d, save, lines, tmp_path: Path) -> None:
    for line in lines[1:]:
        line["pressure"] = 0.0
    report = tmp_path / "report.json"
    recording = save(tmp_path / "air.jsonl", lines)
    replay(paint3d, recording, tmp_path / "a.ply", "--report", report)
    told = json.loads(report.read_text())
    assert told["vertices_painted"] == 0
    assert told["ink_ledger"]["in_brush"] == told["ink_ledger"]["loaded"]


def test_demo(paint3d, tmp_path: Path) -> None:
    out = tmp_path / "new" / "demo"
    done = paint3d("demo", "--out", out, "--no-view")
    assert done.returncode == 0, done.stderr
    names = {"bowl.ply", "bowl.glb", "bowl.p3d.txt", "bowl.png", "report.json"}
    assert {file.name for file in out.iterdir()} == names
    assert all(file.stat().st_size > 1000 for file in out.iterdir())
    assert all(str(out / name) in done.stdout for name in names)
    assert json.loads((out / "report.json").read_text())["vertices_painted"] > 10_000


@pytest.mark.parametrize("command", ["demo", "replay", "report"])
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
