"""`paint3d materials`, and materials of one's own files wherever one is named."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from paint3d.cli import main, options
from paint3d.cli.batches.rows import Row, fingerprint, placed
from paint3d.colour.materials import load_materials, material_names
from paint3d.files.project.session import load_session

MINE = 'base = "xuan"\ncolour = "#e8d9b0"\nabsorbency = 0.5\n'


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "old paper.toml"
    path.write_text(MINE, encoding="utf-8")
    return path


def recorded(folder: Path) -> Path:
    pose = '"orientation":[1,0,0,0]'
    lines = ['{"format":"paint3d-recording","version":1}']
    for k in range(6):
        pressure = 0.3 if 0 < k < 5 else 0.0
        place = f'"position":[{4 * k - 10},0,30]'
        lines.append(f'{{"time_ns":{k * 10**7},{place},{pose},"pressure":{pressure}}}')
    path = folder / "a.jsonl"
    path.write_text("\n".join(lines))
    return path


def test_the_list_tells_every_number_of_all(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["materials"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split("  ")[0] for line in lines[1:]] == material_names()
    for line, material in zip(lines[1:], load_materials().values(), strict=True):
        assert material.chinese in line
        assert material.note in line
        assert f"{material.friction:g}" in line.split()
    assert main.main(["materials", "--quiet"]) == 0
    assert capsys.readouterr().out == ""


def test_what_is_shown_is_a_file(mine: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["materials", "show", "sized xuan"]) == 0
    Path("two.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    assert main.main(["materials", "show", "two.toml"]) == 0
    assert "friction = 0.85" in capsys.readouterr().out
    assert main.main(["materials", "show", "sized xuam"]) == 2
    assert "did you mean 'sized xuan'?" in capsys.readouterr().err
    assert main.main(["materials", "show", "none.toml"]) == 2
    assert "none.toml: there is no such file; expected a material" in capsys.readouterr().err


def test_a_recording_is_painted_on_ones_own_paper(mine: Path) -> None:
    strokes = recorded(mine.parent)
    told = ["replay", str(strokes), "--on", "plane", "--resolution", "3", "--quiet"]
    assert main.main([*told, "--material", mine.name, "--out", "a.p3d"]) == 0
    mine.unlink()  # what was painted holds all of it
    material = load_session("a.p3d").surface.material
    assert (material.name, material.absorbency) == ("old paper", 0.5)
    assert main.main([*told, "--material", mine.name, "--out", "b.p3d"]) == 2


@pytest.mark.parametrize(
    "words",
    [
        ("replay", "a.jsonl", "--on", "plane", "--out", "a.p3d"),
        ("write", "一", "--on", "plane", "--out", "a.p3d"),
        ("demo", "--out", "demo", "--no-view"),
        ("picture", "bowl", "--out", "a.png"),
        ("paint", "bowl"),
    ],
)
def test_a_bad_file_is_told_before_any_work(
    words: tuple[str, ...], mine: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recorded(mine.parent)
    before = sorted(os.listdir())
    mine.write_text("friktion = 3\n")
    assert main.main([*words, "--material", mine.name]) == 2
    assert f"{mine.name}: there is no 'friktion': did you mean 'friction'?" in (
        capsys.readouterr().err
    )
    assert sorted(os.listdir()) == before


def test_the_file_of_a_material_is_not_written_over(
    mine: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    strokes = recorded(mine.parent)
    report = mine.with_name("mine.json")
    report.write_text(json.dumps({"base": "silk"}))
    told = ["replay", str(strokes), "--on", "plane", "--out", "a.p3d", "--report", "mine.json"]
    assert main.main([*told, "--material", "mine.json"]) == 2
    assert "mine.json" in capsys.readouterr().err
    assert json.loads(report.read_text()) == {"base": "silk"}


def test_a_batch_counts_files_of_materials_and_brushes_from_its_folder(mine: Path) -> None:
    words = (
        "write",
        "--on=plane",
        f"--material={mine.name}",
        "--brush=b.toml",
        "--out=a.p3d",
        "一",
    )
    row = Row(1, "a.p3d", words)
    found = placed(row, "/tables").arguments
    assert f"--material=/tables/{mine.name}" in found
    assert "--brush=/tables/b.toml" in found
    named = row._replace(arguments=("write", "--on=plane", "--material=silk", "--out=a.p3d", "一"))
    assert "--material=silk" in placed(named, "/tables").arguments
    before = fingerprint(row, str(mine.parent))
    mine.write_text(MINE + "grain = 0.2\n")
    assert fingerprint(row, str(mine.parent)) != before


def test_all_are_in_the_help() -> None:
    assert list(options.MATERIALS) == material_names()
