"""What a command reads from, it writes over only with --force, under whatever name it is given."""

from __future__ import annotations

import csv
import json
import os
from pathlib import Path

import pytest

from paint3d.app.model.study_plan import make_plan, save_plan
from paint3d.cli import main
from paint3d.cli.batch_table import read_table
from paint3d.files.load import load_mesh
from paint3d.files.session import Session, save_session
from paint3d.surface.painted_surface import PaintedSurface

SQUARE = "v -30 -30 0\nv 30 -30 0\nv 30 30 0\nv -30 30 0\nf 1 2 3 4\n"
HEADER = {"format": "paint3d-recording", "version": 1, "brush": "full", "ink": "pine soot"}


@pytest.fixture
def square(tmp_path: Path) -> Path:
    file = tmp_path / "square.obj"
    file.write_text(SQUARE)
    return file


@pytest.fixture
def strokes(tmp_path: Path) -> Path:
    file = tmp_path / "strokes.jsonl"
    lines = [HEADER]
    for i in range(20):
        lines.append(
            {
                "time_ns": i * 10_000_000,
                "position": [2.0 * i - 20.0, 0.0, 30.0],
                "orientation": [1.0, 0.0, 0.0, 0.0],
                "pressure": 0.2 if 0 < i < 19 else 0.0,
            }
        )
    file.write_text("".join(json.dumps(line) + "\n" for line in lines))
    return file


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Run a command that is to be refused for what it would replace; return the one line."""
    assert main.main([str(word) for word in arguments]) == 2
    said = capsys.readouterr().err
    assert said.startswith("paint3d: error: ")
    assert said.count("\n") == 1
    return said


def other_names(file: Path) -> list[Path]:
    """Other paths to the same file: round about, by a symbolic link, by a hard link."""
    soft, hard = file.with_name("soft" + file.suffix), file.with_name("hard" + file.suffix)
    soft.symlink_to(file)
    os.link(file, hard)
    return [file, file.parent / ".." / file.parent.name / file.name, soft, hard]


def test_a_replay_does_not_replace_its_object(square, strokes, capsys) -> None:
    for out in other_names(square):
        said = refused(capsys, "replay", strokes, "--on", square, "--out", out)
        assert f"{out} would be replaced, and {square} is read from it" in said
        assert "--force" in said
    assert square.read_text() == SQUARE
    said = refused(capsys, "replay", strokes, "--on", square.parent / "soft.obj", "--out", square)
    assert f"{square} would be replaced" in said


def test_with_force_it_does_and_a_link_stays_one(square, strokes, tmp_path, capsys) -> None:
    link = tmp_path / "link.obj"
    link.symlink_to(square)
    told = ["replay", strokes, "--on", square, "--out", link, "--force", "--quiet"]
    assert main.main([str(word) for word in told]) == 0
    assert link.is_symlink()
    assert square.read_text() != SQUARE
    assert load_mesh(square).colours.min() < 100  # painted


def test_writing_does_not_replace_its_object(square, capsys) -> None:
    assert "would be replaced" in refused(capsys, "write", "一", "--on", square, "--out", square)


def test_results_do_not_replace_a_table_of_inks(tmp_path, capsys) -> None:
    table = tmp_path / "inks.csv"
    table.write_text("name\n")
    told = ("write", "一", "--on", "plane", "--out", tmp_path / "o.ply", "--recording", table)
    assert f"{table} is read from it" in refused(capsys, *told, "--ink", f"{table}:mine")
    assert table.read_text() == "name\n"


def test_two_results_are_two_files(strokes, tmp_path, capsys) -> None:
    out, report = tmp_path / "o.ply", tmp_path / "report.json"
    report.symlink_to(out)
    told = ("replay", strokes, "--on", "plane", "--out", out, "--report", report, "--force")
    assert f"{report} is {out}; expected a file for each" in refused(capsys, *told)


def test_an_export_does_not_replace_its_session(square, tmp_path, capsys) -> None:
    saved = tmp_path / "saved.p3d"
    save_session(Session(PaintedSurface(load_mesh(square), resolution=2.0)), saved)
    before = saved.read_bytes()
    for out in other_names(saved):
        assert "would be replaced" in refused(capsys, "export", saved, out)
    assert saved.read_bytes() == before
    assert main.main(["export", str(saved), str(saved), "--force", "--quiet"]) == 0


def test_a_study_does_not_replace_its_plan(tmp_path, capsys) -> None:
    save_plan(make_plan(2, ("I", "II"), "目", "bowl", 30.0, 1, 0), tmp_path)
    said = refused(capsys, "study", "table", tmp_path, "--report", tmp_path / "study.json")
    assert "would be replaced" in said


def test_a_device_recording_does_not_replace_its_calibration(tmp_path, capsys) -> None:
    known = tmp_path / "known.json"
    known.write_text("{}")
    told = ("devices", "record", tmp_path / "r.jsonl", "--raw", known, "--calibration", known)
    assert "would be replaced" in refused(capsys, *told)


def test_a_table_of_paintings_can_ask_for_it(square, strokes, tmp_path, capsys) -> None:
    table = tmp_path / "table.csv"
    with open(table, "w", encoding="utf-8", newline="") as file:
        row = csv.writer(file)
        row.writerow(("recording", "object", "output", "force"))
        row.writerow((strokes, square, square, "no"))
    assert "1 of 1 rows failed" in refused_rows(capsys, table)
    table.write_text(table.read_text().replace(",no", ",yes"))
    rows, others = read_table(table)
    assert (len(rows), others) == (1, [])
    assert "--force" in rows[0].arguments


def refused_rows(capsys: pytest.CaptureFixture[str], table: Path) -> str:
    assert main.main(["batch", str(table), "--processes", "1", "--quiet"]) == 2
    said = capsys.readouterr().err
    assert "would be replaced" in said
    return said
