"""Brushes of one's own as files."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import pytest

from paint3d.brush.presets import brush_names, brush_note, brush_text, load_brush
from paint3d.brush.spec import BristleSpec
from paint3d.core.parameter_file import is_parameter_file
from paint3d.errors import BrushError


def written(folder: Path, text: str, name: str = "mine.toml") -> str:
    (folder / name).write_text(text, encoding="utf-8")
    return str(folder / name)


@pytest.mark.parametrize("name", brush_names())
def test_what_is_shown_is_read_back(name: str, tmp_path: Path) -> None:
    brush = load_brush(name)
    read = load_brush(written(tmp_path, brush_text(brush, brush_note(name))))
    assert read.name == "mine"
    assert dataclasses.replace(read, name=name) == brush


def test_a_file_may_start_from_a_preset(tmp_path: Path) -> None:
    toml = written(tmp_path, 'base = "feibai"\nhardness = 0.4\n[bristles]\nn_hairs = 50\n')
    same = {"base": "feibai", "name": "mine", "hardness": 0.4, "bristles": {"n_hairs": 50}}
    json_file = written(tmp_path, json.dumps(same), "other.JSON")
    read = load_brush(toml)
    assert read == load_brush(json_file)
    assert (read.hardness, read.bristles) == (0.4, BristleSpec(n_hairs=50))
    assert read.inputs == load_brush("feibai").inputs
    assert load_brush(written(tmp_path, 'base = "feibai"\nbristles = false\n')).bristles is None


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("hardness = 0.4", "says no hair, n_segments"),
        ('base = "ful"', "base is 'ful'; expected one of full"),
        ('base = "full"\nhardnes = 0.4', "there is no 'hardnes': did you mean 'hardness'"),
        ('base = "full"\nhardness = 0.9', "hardness is 0.9; expected 0.3 to 0.7"),
        ('base = "full"\nhardness = "hard"', "hardness is 'hard'; expected a number"),
        ('base = "full"\nhair = []', "hair is []; expected one of goat"),
        ('base = "full"\nname = "dakai"', "a brush that comes with the program"),
        ('base = "full"\nname = "a @3"', "without ' @'"),
        ('base = "full"\nname = "a.toml"', "no file's name"),
        ('base = "full"\nbristles = 300', "bristles is 300; expected parameters"),
        ('base = "full"\n[bristles]\nhair = 1', "bristles: there is no 'hair'"),
        ('base = "full"\n[bristles]\nn_hairs = 0', "bristles: n_hairs is 0; expected 1 to 10000"),
        ('base = "full"\n[inputs.wetness]\nspeed = 3', "wetness by speed is 3; expected points"),
        ("base = \n\nx = 1", "cannot be read as TOML: Invalid value (at line 1, column 8)"),
        ("#" * (1 << 20) + "\n", "is over 1 MiB"),
    ],
)
def test_a_bad_file_says_where_and_what(text: str, told: str, tmp_path: Path) -> None:
    file = written(tmp_path, text)
    with pytest.raises(BrushError) as refused:
        load_brush(file)
    assert str(refused.value).startswith(f"{file}: ")
    assert told in str(refused.value)


def test_other_things_than_tables_are_refused(tmp_path: Path) -> None:
    for text in ("[1]", "3", "[" * 100_000):
        with pytest.raises(BrushError, match=r"mine\.json: "):
            load_brush(written(tmp_path, text, "mine.json"))
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    for name, told in (("bytes.toml", "TOML"), ("none.toml", "no such file"), (".", "brush")):
        with pytest.raises((BrushError, ValueError), match=told):
            load_brush(str(tmp_path / name))


def test_names_out_of_files_open_no_files(tmp_path: Path) -> None:
    file = written(tmp_path, 'base = "full"')
    assert is_parameter_file(file)
    with pytest.raises(BrushError, match="which a file may not name"):
        load_brush(file, own_files=False)
    assert load_brush("full", own_files=False) is load_brush("full")
