"""How `paint3d write` refuses what it cannot write."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from paint3d.cli import main

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
            "9 characters does not fit on plane at an em of 66 mm",
        ),
        ("一", {"size": 300, "brush": "full"}, "no place for an em of 300 mm"),
        ("一", {"size": 300}, "size of the characters (mm) is 300"),
        ("一", {"size": "wide"}, "'wide' is not a length"),
        ("一", {"glyphs": "nowhere"}, "nowhere: no such folder"),
        ("一", {"glyphs": "."}, "holds no glyphs"),
        ("一", {"at": "0.5,0.99"}, "the surface ends"),
        ("一", {"around": None}, "does not come back"),
        ("一", {"out": "a.xyz"}, "unknown kind of file"),
        ("一", {"technique": "pianfeng", "azimuth": "dragged"}, "dragged tuft"),
        ("一", {"brush": "broom"}, "unknown brush 'broom'"),
        ("一", {"ink": "mud"}, "unknown"),
        ("一", {"processes": 0}, "is not a count"),
        ("一", {"on": "bowl", "out": "a.svg"}, "bowl is not the plane"),
    ],
)
def test_bad_input_is_one_line(
    glyphs, tmp_path: Path, monkeypatch, capsys, text, options, words
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
