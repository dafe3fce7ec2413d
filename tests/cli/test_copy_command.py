"""`paint3d copy`: from a photograph to a painting, and how it refuses what cannot be copied."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from paint3d.brush.presets import choose_brush, load_brush
from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.page.strokes_file import load_strokes
from paint3d.cli.batches.rows import command_parser
from paint3d.cli.main import main
from paint3d.cli.write import settings_of
from paint3d.errors import InputError
from paint3d.recording.recording import load_recording
from tests.support.photographs import Camera, hairs_below_a_stroke, photograph, sheet_of

pytest.importorskip("skimage")
pytestmark = pytest.mark.usefixtures("sheets_found_once")


@pytest.fixture(scope="module")
def photo(tmp_path_factory) -> Path:
    """A photographed sheet with one character, dry in places."""
    file = tmp_path_factory.mktemp("photo") / "ten.png"
    sheet = sheet_of([open_glyphs(None).load("十")], 3, dry=0.9, longest=500)
    Image.fromarray(photograph(sheet, 3, Camera(size=700)).pixels).save(file)
    return file


def copy(*arguments: object) -> int:
    return main(["copy", *map(str, arguments)])


def test_a_photograph_becomes_a_painting(photo: Path, tmp_path: Path, capsys) -> None:
    names = ("a.ply", "a.jsonl", "a.json", "a.strokes.json", "beside.png")
    out, way, report, strokes, beside = (tmp_path / name for name in names)
    done = copy(
        photo, "--text", "十", "--on", "plane", "--size", 20, "--resolution", 0.3, "--out", out,
        "--recording", way, "--report", report, "--save-strokes", strokes, "--beside", beside,
        "--processes", 1,
    )  # fmt: skip
    told = capsys.readouterr()
    assert done == 0, told.err
    assert "IoU" in told.out
    assert "dryness" in told.out
    page = load_strokes(strokes)
    assert [len(piece.glyph.strokes) for piece in page.pieces] == [2]
    assert all(stroke.dryness for stroke in page.pieces[0].glyph.strokes)
    assert page.photograph.file.resolve() == photo.resolve()
    assert load_recording(way).header["loads"]
    assert json.loads(report.read_text())["source"] == "ten.png"
    picture = np.asarray(Image.open(beside))
    half = picture.shape[1] // 2
    assert picture[:, :half].min() < 110
    assert picture[:, half + 12 :].min() < 60


@pytest.mark.long
def test_a_full_brush_paints_without_flying_white(photo: Path, tmp_path: Path) -> None:
    way = tmp_path / "a.jsonl"
    out = tmp_path / "a.ply"
    assert not copy(
        photo, "--dryness", "none", "--on", "plane", "--size", 20, "--resolution", 1, "--out", out,
        "--recording", way, "--quiet", "--processes", 1,
    )  # fmt: skip
    assert "loads" not in load_recording(way).header


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--corners", "0,0", "300,300", "500,0", "500,500"], "one after another around"),
        pytest.param(["--corners", "0,0", "9000,0", "9000,700", "0,700"], "expected places in it",
                     marks=pytest.mark.long),
        pytest.param(["--corners", "0,0", "wide", "500,0", "500,500"], "'wide' is not a place",
                     marks=pytest.mark.long),
        (["--text", "十十十十十十"], "the text has 6 characters"),
        pytest.param(["--text", "十", "--size", "9", "--resolution", "2"],
                     "the vertices lie 2 mm apart", marks=pytest.mark.long),
        (["--text", "十", "--brush", "gongbi", "--size", "300"], "larger brush"),
        (["--beside", "a.xyz"], "unknown kind of file"),
        (["--save-strokes", "a.json"], "unknown kind of file"),
    ],
)  # fmt: skip
def test_what_cannot_be_copied_is_said_in_one_line(
    photo: Path, tmp_path: Path, capsys, monkeypatch, options: list[str], words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert copy(photo, "--on", "plane", "--out", "a.ply", "--quiet", *options) == 2
    told = capsys.readouterr().err
    assert words in told
    assert len(told.splitlines()) == 1 or "usage" in told
    assert not list(tmp_path.iterdir())


def test_what_is_large_is_copied_and_written_with_the_largest_brush(
    photo: Path, tmp_path: Path, monkeypatch
) -> None:
    brushes = []

    def check(page, brush, size, resolution) -> None:
        brushes.append(brush)
        raise InputError("seen")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("paint3d.calligraphy.photo.copying.check_widths", check)
    asked = "--text", "十", "--on", "plane", "--size", 400, "--out", "a.ply"
    assert copy(photo, *asked) == 2
    words = ["一", "--on=plane", "--size=400", "--out=a.ply"]
    written = settings_of(command_parser("write").parse_args(words)).brush
    assert brushes == [written]
    assert written == load_brush(choose_brush(350.0))


def test_ink_that_is_in_no_stroke_is_told(tmp_path: Path, capsys) -> None:
    assert not copy(
        hairs_below_a_stroke(tmp_path), "--whole", "--on", "plane", "--size", 120,
        "--resolution", 1, "--out", tmp_path / "a.ply", "--rehearsals", 0, "--processes", 1,
    )  # fmt: skip
    assert "some of the ink is in no stroke: character 1 (" in capsys.readouterr().err


def test_a_photograph_is_never_written_over(photo: Path, capsys) -> None:
    assert copy(photo, "--on", "plane", "--out", photo) == 2
    assert "ten.png" in capsys.readouterr().err
    assert Image.open(photo).size == (525, 700) or Image.open(photo).size == (700, 525)


def test_a_file_that_is_missing_is_named(tmp_path: Path, capsys) -> None:
    assert copy(tmp_path / "none.jpg", "--on", "plane", "--out", tmp_path / "a.ply") == 2
    assert "none.jpg: there is no such file" in capsys.readouterr().err


def test_strokes_that_were_kept_are_painted_on_trial_too(tmp_path: Path) -> None:
    """Which corrects how dry they are; with `--rehearsals 0` nothing does."""
    ring = [[0, 440], [900, 440], [900, 580], [0, 580]]
    stroke = {"order": 1, "line": [[0, 510], [900, 510]], "rings": [ring], "dryness": [0.1, 0.7]}
    piece = {"text": "a", "at": [0, 0], "box": [0, 0, 1000, 1000], "strokes": [stroke]}
    page = {"format": "paint3d strokes 1", "source": "s", "licence": "l", "pieces": [piece]}
    strokes, loads = tmp_path / "a.strokes.json", []
    strokes.write_text(json.dumps(page))
    for trials in (["--rehearsals", "0"], []):
        way = tmp_path / f"{len(trials)}.jsonl"
        asked = ["--strokes", strokes, "--on", "plane", "--material", "xuan", "--resolution", 0.5]
        asked += ["--out", tmp_path / "a.ply", "--recording", way, "--quiet", "--force"]
        assert not main(["write", *map(str, asked), "--processes", "1", *trials])
        loads.append(load_recording(way).header["loads"])
    assert loads[0] != loads[1]


def test_trials_are_of_strokes_alone(tmp_path: Path, capsys) -> None:
    out = str(tmp_path / "a.ply")
    assert main(["write", "永", "--on", "plane", "--out", out, "--rehearsals", "2"]) == 2
    assert "--rehearsals is given without strokes" in capsys.readouterr().err
