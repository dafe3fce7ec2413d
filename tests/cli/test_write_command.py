"""How `paint3d write` refuses what it cannot write."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from paint3d.app.model.document import Document
from paint3d.cli import main, options, replay, write
from paint3d.cli.batches.rows import command_parser
from paint3d.colour.materials import load_material, material_names
from paint3d.files.load import load_mesh
from paint3d.recording.recording import load_recording
from tests.support.fonts import REFERENCE

BAR = "M 150 420 L 220 350 L 800 350 L 880 420 L 800 470 L 220 470 Z"


@pytest.fixture(scope="module")
def glyphs(tmp_path_factory) -> Path:
    """A folder laid out like hanzi-writer-data, with one shape for all its characters."""
    folder = tmp_path_factory.mktemp("glyphs")
    data = {"strokes": [BAR], "medians": [[[180, 415], [850, 415]]]}
    for text in "一丨十":
        (folder / f"{text}.json").write_text(json.dumps(data), encoding="utf-8")
    return folder


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        ("一龘丨鸞", {}, "no glyph for '龘' (U+9F98), '鸞' (U+9E1E)"),
        ("", {}, "the text is empty"),
        (
            "一丨十一丨十一丨十",
            {"size": 66},
            "9 characters does not fit on plane at a size of 66 mm",
        ),
        ("一", {"size": 300, "brush": "full"}, "no place for an em of 300 mm"),
        ("一", {"size": "wide"}, "'wide' is not a length"),
        ("一", {"glyphs": "nowhere"}, "nowhere: no such folder"),
        ("一", {"glyphs": "."}, "holds no glyphs"),
        ("一", {"at": "0.5,0.99"}, "the surface ends"),
        ("一", {"around": None}, "does not go around it"),
        ("一", {"around": None, "rotate": 20}, "a text around an object lies level"),
        ("一", {"out": "a.xyz"}, "unknown kind of file"),
        ("一", {"technique": "pianfeng", "azimuth": "dragged"}, "dragged tuft"),
        ("一", {"brush": "broom"}, "unknown brush 'broom'"),
        ("一", {"ink": "mud"}, "unknown"),
        ("一", {"processes": 0}, "is not a count"),
        ("一", {"on": "bowl", "out": "a.svg"}, "bowl is not the plane"),
    ],
)
def test_bad_input_is_one_line(
    glyphs, system_fonts, tmp_path: Path, monkeypatch, capsys, text, options, words
) -> None:
    monkeypatch.chdir(tmp_path)
    chosen = {"on": "plane", "out": "a.ply", "size": 20, "glyphs": glyphs, **options}
    parts = [part for k, v in chosen.items() for part in (f"--{k}", v) if part is not None]
    assert main.main(["write", text, *map(str, parts)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    told = err.splitlines()
    assert told[-1].startswith("paint3d: error: ")
    assert words in told[-1]
    assert all(line.startswith("planned ") for line in told[:-1])
    assert list(tmp_path.iterdir()) == []


WISHES = [
    ({"material": "nosuch"}, "unknown material 'nosuch'"),
    ({"resolution": 1e300}, "1e+300 is too coarse; expected at most 1e+06 mm"),
    ({"brush": "broom"}, "unknown brush 'broom'"),
    ({"ink": "mud"}, "unknown ink 'mud'"),
    ({"hairs": 20_000}, "hairs; expected 0 to 10000"),
]
WISHES_IN_WRITING = [
    ({"glyphs": "nowhere"}, "nowhere: no such folder"),
    ({"text": "一龘"}, "no glyph for '龘' (U+9F98)"),
    ({"technique": "pianfeng", "azimuth": "dragged"}, "dragged tuft"),
    ({"azimuth": "dragged", "out": "a.svg"}, "need a commanded one"),
    ({"seal": "一丨十一丨"}, "5 characters; expected 1 to 4"),
    ({"seal": "龘"}, "no glyph for '龘' (U+9F98)"),
    ({"sign": "一龘"}, "no glyph for '龘' (U+9F98)"),
    ({"sign": "　 "}, "--sign has no characters"),
    ({"seal": "一", "out": "a.svg"}, "--sign and --seal are painted after the text"),
    ({"sign": "一", "film": "a.mp4"}, "--sign and --seal are painted after the text"),
]


@pytest.mark.parametrize(
    ("command", "wish", "words"),
    [
        *(("write", *wish) for wish in WISHES + WISHES_IN_WRITING),
        *(("replay", *wish) for wish in WISHES),
    ],
)
def test_what_is_wished_is_checked_before_any_work(
    command: str,
    glyphs: Path,
    system_fonts,
    tmp_path: Path,
    monkeypatch,
    capsys,
    wish: dict,
    words: str,
) -> None:
    def load(_: object) -> None:
        pytest.fail("something was loaded")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(write, "load_object", load)
    monkeypatch.setattr(write, "new_document", load)
    monkeypatch.setattr(replay, "load_object", load)
    monkeypatch.setattr("paint3d.recording.recording.load_recording", load)
    chosen = {"text": __file__} if command == "replay" else {"text": "一", "glyphs": glyphs}
    chosen |= {"on": "plane", "out": "a.ply", **wish}
    text = chosen.pop("text")
    assert main.main([command, text, *(f"--{k}={v}" for k, v in chosen.items())]) == 2
    assert words in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_every_material_is_listed() -> None:
    assert list(options.MATERIALS) == material_names()


def test_a_character_that_no_source_has_is_painted_in_a_font(
    system_fonts, tmp_path: Path, monkeypatch, capsys
) -> None:
    """What is recorded of it is painted again where no font has it."""
    system_fonts.add("Test Kai", REFERENCE + "步")
    monkeypatch.chdir(tmp_path)
    rest = ["--on", "plane", "--resolution", "1"]
    asked = ["write", "漫步", "--size", "40", "--out", "a.ply", "--recording", "a.jsonl"]
    assert main.main([*asked, *rest, "--processes", "1"]) == 0
    (note,) = [line for line in capsys.readouterr().err.splitlines() if "Test Kai" in line]
    assert "步" in note
    assert "漫" not in note
    header = load_recording("a.jsonl").header
    assert header["glyphs"] == "kanjivg; 步 from Test Kai"
    assert "Font: Test Kai" in header["licence"]
    system_fonts.remove_all()
    assert main.main(["replay", "a.jsonl", "--out", "b.ply", *rest]) == 0
    assert Path("a.ply").read_bytes() == Path("b.ply").read_bytes()
    assert main.main([*asked, *rest, "--force"]) == 2


def test_what_a_painter_can_do_about_a_character_is_said(
    system_fonts, tmp_path: Path, monkeypatch, capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    for text in ("漫步", "囍"):
        assert main.main(["write", text, "--on", "plane", "--out", "a.ply"]) == 2
        told = capsys.readouterr().err
        assert f"no glyph for {text[-1]!r}" in told
        assert "--font FONT" in told
        assert "fonts-noto-cjk" in told
        assert "npm" not in told


@pytest.mark.parametrize("command", ["write", "seal", "study", "copy"])
def test_no_help_sends_a_painter_to_npm(command: str, capsys) -> None:
    with pytest.raises(SystemExit):
        main.main([command, "--help"])
    assert "npm" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ([], "got nothing to write; expected one of TEXT, --svg FILE and --strokes FILE"),
        (["一", "--svg", "a.svg"], "got a text and --svg"),
        (["一", "--ids", "a"], "--ids is given without a drawing"),
        (["--font", "a.ttf", "--svg", "a.svg"], "--font is given without a text"),
        (["一", "--direction", "rtl"], "--direction is given without a font"),
        (["一", "--save-strokes", "a.strokes.json"], "without a font or a drawing"),
        (["一", "--font", "a.ttf"], "a.ttf: no such file"),
        (["--svg", "a.svg"], "a.svg: there is no such file"),
        (["--strokes", "a.json"], "a.json: there is no such file"),
        (["一", "--font", "a", "--features", "lig=x"], "expected a feature such as liga=0"),
        (["一", "--font", "a", "--font-axes", "wght"], "expected an axis such as wght=700"),
    ],
)
def test_what_is_written_is_one_thing(tmp_path: Path, monkeypatch, capsys, given, words) -> None:
    monkeypatch.chdir(tmp_path)
    assert main.main(["write", *given, "--on", "plane", "--out", "a.ply"]) == 2
    assert words in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_kept_strokes_of_a_drawing_paint_it_again(tmp_path: Path, monkeypatch) -> None:
    pytest.importorskip("svgelements")
    monkeypatch.chdir(tmp_path)
    svg = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0H40" stroke="red"/></svg>'
    Path("a.svg").write_text(svg, encoding="utf-8")
    rest = ["--on", "plane", "--size", "20", "--quiet"]
    kept = ["--save-strokes", "a.strokes.json", "--recording", "a.jsonl"]
    assert main.main(["write", "--svg", "a.svg", "--out", "a.ply", *kept, *rest]) == 0
    again = ["--strokes", "a.strokes.json", "--recording", "b.jsonl"]
    assert main.main(["write", "--out", "b.ply", *again, *rest]) == 0
    one, two = (load_recording(name).position for name in ("a.jsonl", "b.jsonl"))
    for end in (np.min, np.max, np.mean):
        np.testing.assert_allclose(end(one, axis=0), end(two, axis=0), atol=0.01)


@pytest.mark.parametrize(("size", "told"), [("10", True), ("40", False)])
def test_text_too_small_for_its_vertices_is_told(tmp_path, monkeypatch, capsys, size, told) -> None:
    monkeypatch.chdir(tmp_path)
    assert main.main(["write", "一", "--on", "plane", "--size", size, "--resolution", "0.8",
                      "--out", "a.p3d", "--processes", "1"]) == 0  # fmt: skip
    said = "vertices 0.8 mm apart are too coarse for characters of 10 mm" in capsys.readouterr().err
    assert said == told


def asked_of(*words: str) -> argparse.Namespace:
    return command_parser("write").parse_args(["--out=a.p3d", "--quiet", *words])


@pytest.mark.parametrize(
    ("side", "axis"),
    [("front", (0, -1)), ("right", (1, 0)), ("back", (0, 1)), ("left", (-1, 0))],
)
def test_a_text_is_written_on_the_face_that_is_asked_for(side: str, axis) -> None:
    asked = asked_of("一", "--on=vase", "--size=20", f"--side={side}", "--processes=1")
    make, source = write.planner(asked)
    vase = SimpleNamespace(source=load_mesh("vase"), material=load_material("porcelain"))
    written = write.plan(asked, vase, make, write.settings_of(asked), source, "always", {})
    middle = written.placed[0].square.chart.frame.origin[:2]
    np.testing.assert_allclose(middle / np.linalg.norm(middle), axis, atol=0.05)


def test_a_text_fills_a_sheet_on_its_front_alone(capsys) -> None:
    sizes = {}
    for side in (None, "top", "front", "back", "bottom"):
        asked = asked_of("永", "--on=square", *([f"--side={side}"] if side else []))
        asked.quiet = False
        write.settle_size(asked, asked.on)
        sizes[side] = asked.size
        told = capsys.readouterr().err
        filled = f"1 character of {asked.size:.0f} mm in 1 column fills the sheet\n"
        assert told == ("" if asked.size == 20.0 else filled)
    assert sizes["top"] == sizes["front"] == sizes[None] > 200.0
    assert sizes["back"] == sizes["bottom"] == 20.0


def test_a_signature_and_a_seal_stand_beside_the_text(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["--on", "sheet:60x60:margin=5", "--resolution", "1", "--sign", "二", "--seal", "一"]
    assert main.main(["write", "一", *words, "--out", "a.p3d", "--processes", "1"]) == 0
    assert "1 mm apart are too coarse for characters of 6 mm" in capsys.readouterr().err
    document = Document.open("a.p3d")
    assert len(document.strokes) == 2

    def painted() -> set[tuple[float, ...]]:
        surface = document.surface
        found = surface.paint_mesh.vertices[: len(surface.painted)][surface.painted]
        return {tuple(point) for point in found.round(3).tolist()}

    whole = painted()
    document.undo()
    signed = painted()
    document.undo()
    text = painted()
    seal = np.array(sorted(whole - signed))
    signature = np.array(sorted(signed - text))
    assert signature[:, 0].max() < min(text)[0]
    assert seal[:, 0].max() < min(text)[0]
    assert seal[:, 1].max() < signature[:, 1].min()
    assert len(document.strokes) == 1
