"""`paint3d brushes`, and `--brush FILE`."""

from __future__ import annotations

import dataclasses
import json
import re
import textwrap
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from paint3d.app.model.persistence.own_brushes import keep_brush
from paint3d.brush.fitting import press_errors, read_presses
from paint3d.brush.presets import brush_names, load_brush
from paint3d.cli.main import main
from paint3d.errors import BrushError
from paint3d.view import brush_shape

SHEET = "v 0 0 0\nv 90 0 0\nv 90 90 0\nv 0 90 0\nf 1 2 3 4\n"


def recorded(folder: Path, **header: str) -> str:
    """A short stroke over a sheet, sheet.obj beside it."""
    (folder / "sheet.obj").write_text(SHEET)
    lines = [json.dumps({"format": "paint3d-recording", "version": 1, **header})]
    for k in range(20):
        pose = {"position": [30 + 1.5 * k, 45, 30], "orientation": [1, 0, 0, 0]}
        lines.append(json.dumps({"time_ns": k * 10**7, **pose, "pressure": 0.4}))
    (folder / "a.jsonl").write_text("\n".join(lines))
    return str(folder / "a.jsonl")


def test_the_brushes_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["brushes"]) == 0
    head, *lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(brush_names())
    assert head.split()[:5] == ["name", "hair", "H", "l1", "n"]
    assert lines[0].split()[:5] == ["full", "mixed", "0.7", "1", "9"]
    assert "flying white" in "".join(lines)


def test_a_picture_of_each_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One is looked at in its size; the others are drawn, too, with a sixteenth of its pixels."""
    folder, draw = tmp_path / "pictures", brush_shape.draw_brush
    monkeypatch.setattr(
        brush_shape,
        "draw_brush",
        lambda b, ink: draw(b, ink, *([] if b.name == "full" else [60])),
    )
    assert main(["brushes", "--pictures", str(folder), "--quiet"]) == 0
    assert sorted(file.stem for file in folder.iterdir()) == sorted(brush_names())
    pixels = np.asarray(Image.open(folder / "full.png"))
    footprints, stroke = pixels[:, :240], pixels[:, 240:]
    assert footprints.min() < 60
    assert footprints.max() > 240
    assert 0.1 < (stroke.mean(axis=2) < 100).mean() < 0.5


def test_what_is_shown_paints(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A preset's own file paints what the preset paints; another one something else."""
    recording, sheet = recorded(tmp_path), str(tmp_path / "sheet.obj")
    assert main(["brushes", "show", "slender"]) == 0
    mine, wide = tmp_path / "mine.toml", tmp_path / "wide.toml"
    mine.write_text(capsys.readouterr().out)
    wide.write_text('base = "slender"\nroot_diameter_mm = 14.0\n')
    painted = {}
    for brush in ("slender", str(mine), str(wide)):
        out = tmp_path / f"{Path(brush).stem}.ply"
        arguments = ["--on", sheet, "--brush", brush, "--resolution", "1", "--out", str(out)]
        assert main(["replay", recording, *arguments, "--quiet"]) == 0
        painted[Path(brush).stem] = out.read_bytes()
    assert painted["slender"] == painted["mine"] != painted["wide"]


def test_a_recording_opens_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text('base = "full"')
    arguments = ["--on", str(tmp_path / "sheet.obj"), "--out", str(tmp_path / "a.ply"), "--quiet"]
    for named, told in ((str(mine), "which a file may not name"), ("mine", "unknown brush 'mine'")):
        recording = recorded(tmp_path, brush=named)
        assert main(["replay", recording, *arguments]) == 2
        refused = capsys.readouterr().err
        assert told in refused
        assert refused.rstrip().endswith("or --brush")
    assert main(["replay", recording, *arguments, "--brush", str(mine)]) == 0


def test_a_brush_file_is_not_written_over(tmp_path: Path) -> None:
    recording = recorded(tmp_path)
    (tmp_path / "mine.ply.toml").write_text('base = "full"')
    (tmp_path / "mine.ply").symlink_to("mine.ply.toml")
    arguments = ["--on", str(tmp_path / "sheet.obj"), "--brush", str(tmp_path / "mine.ply.toml")]
    assert main(["replay", recording, *arguments, "--out", str(tmp_path / "mine.ply")]) == 2
    assert (tmp_path / "mine.ply.toml").read_text() == 'base = "full"'


def test_unknown_brushes_are_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["brushes", "show", "fulll"]) == 2
    assert "did you mean 'full'?" in capsys.readouterr().err
    assert main(["brushes", "show", "none.toml"]) == 2
    assert "none.toml: there is no such file" in capsys.readouterr().err


DOCUMENT = Path(__file__).parents[2] / "docs" / "brushes.md"


def tables_of_the_page() -> list[str]:
    """Presses and bent hairs as docs/brushes.md shows them."""
    blocks = re.findall(r"(?:^    .*\n)+", DOCUMENT.read_text(encoding="utf-8"), re.MULTILINE)
    tables = [
        textwrap.dedent(block) for block in blocks if re.match(r"    (depth_mm|angle),", block)
    ]
    assert len(tables) == 2
    return tables


def commands_of_the_page() -> list[list[str]]:
    text = DOCUMENT.read_text(encoding="utf-8")
    found = re.findall(r"^    paint3d (brushes fit [^#\n]*)", text, re.MULTILINE)
    assert len(found) == 2
    return [command.split() for command in found]


@pytest.mark.parametrize("which", [0, 1])
def test_the_commands_of_the_page_fit_brushes(
    which: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    command = commands_of_the_page()[which]
    Path(command[2]).write_text(tables_of_the_page()[which], encoding="utf-8")
    assert main(command) == 0
    told = capsys.readouterr().out
    brush = load_brush("mine.toml")
    assert brush.name == "mine"
    if which:
        assert "3 bent hairs" in told
        assert brush.bristles.n_hairs == 400
        assert brush.bristles.table[1][:2] == (0.0, 0.8)
    else:
        assert brush.length_mm == 30.0
        presses = read_presses("presses.csv")
        off, before = (
            np.square(press_errors(one, presses)).sum() for one in (brush, load_brush("calibrated"))
        )
        assert off < 0.7 * before
        assert "width" in told


@pytest.mark.parametrize(
    ("out", "told"),
    [("mine.txt", "expected the name of a brush file"), ("full.toml", "a brush that comes with"),
     ("none/mine.toml", "none")],
)  # fmt: skip
def test_a_brush_is_not_fitted_into_another_file(
    out: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "t.csv").write_text(tables_of_the_page()[1], encoding="utf-8")
    table = str(tmp_path / "t.csv")
    assert main(["brushes", "fit", table, "--base", "full", "--out", str(tmp_path / out)]) == 2
    message = capsys.readouterr().err
    assert told in message
    assert message.count("\n") == 1


def test_brushes_that_the_studio_keeps_are_listed_with_their_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path))
    path = keep_brush(dataclasses.replace(load_brush("full"), name="wolf 1", hardness=0.4))
    (tmp_path / "brushes" / "z.toml").write_text("hardness = 0.4", encoding="utf-8")
    assert main(["brushes"]) == 0
    told = capsys.readouterr()
    (line,) = (line for line in told.out.splitlines() if line.startswith("wolf 1"))
    assert f"--brush {path}" in line
    assert " 0.4 " in line
    assert "z.toml: hair, n_segments" in told.err
    assert load_brush(str(path)).hardness == 0.4


def test_names_in_chinese_keep_the_columns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path))
    keep_brush(dataclasses.replace(load_brush("full"), name="大笔"))
    assert main(["brushes"]) == 0
    head, *lines = capsys.readouterr().out.splitlines()
    (line,) = (line for line in lines if line.startswith("大笔"))
    assert line.index("mixed") == head.index("hair") - 2  # each of the two is two columns wide


def test_the_brush_that_a_fit_begins_with_is_not_written_over(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "t.csv").write_text(tables_of_the_page()[1], encoding="utf-8")
    mine = tmp_path / "mine.toml"
    mine.write_text('base = "full"', encoding="utf-8")
    command = ["brushes", "fit", str(tmp_path / "t.csv"), "--base", str(mine), "--out", str(mine)]
    assert main(command) == 2
    assert "would be replaced" in capsys.readouterr().err
    assert mine.read_text(encoding="utf-8") == 'base = "full"'
    assert main([*command, "--force"]) == 0
    assert load_brush(str(mine)).bristles is not None


def test_a_name_longer_than_a_file_can_have_is_a_fault_of_the_brush() -> None:
    with pytest.raises(BrushError, match="File name too long"):
        load_brush(f"{'a' * 300}.toml")
