"""Recordings of whole paintings: what a line may say is what the schema says."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from paint3d.cli.main import main
from paint3d.colour.pigments import Pigment
from paint3d.errors import ExportError, RecordingError
from paint3d.files.project.session import load_session
from paint3d.recording.recording import load_recording
from paint3d.recording.score import (
    Score,
    check_command,
    check_header,
    check_sample,
    is_score,
    load_score,
    save_score,
    schema,
    write_score,
)

DOCS = Path(__file__).parents[2] / "docs" / "recordings.md"
EXAMPLE = Path(__file__).parents[2] / "examples" / "bamboo.score.jsonl"
HEADER = {"format": "paint3d-recording", "version": 2}
SAMPLE = {"time_ns": 5, "position": [0, 0, 35], "orientation": [1, 0, 0, 0], "pressure": 0.5}
GOOD = [
    HEADER,
    {**HEADER, "material": "xuan", "resolution_mm": None, "ink": {"water": 1.0}, "mine": [1]},
    SAMPLE,
    {**SAMPLE, "contact": None, "object": {"position": [0, 0, 0], "orientation": [1, 0, 0, 0]}},
    {"do": "begin_stroke", "time_s": 3.5},
    {"do": "dip"},
    {"do": "dip", "ink": {"pine soot": 0.2, "water": 0.8}, "reach": 0.5, "refused": True},
    {"do": "set_brush", "brush": {"name": "mine", "length_mm": 35.0}, "hairs": 100},
    {"do": "set_mask", "regions": [{"at": [0, 1, 2.5], "up_to": "piece"}], "inverted": True},
    {"do": "set_symmetry", "planes": [{"point": [0, 0, 0], "normal": [0, 1, 0]}]},
    {"do": "set_tags", "tags": {"any": [1, None]}},
]
BAD = [
    {**HEADER, "version": 3},
    {**HEADER, "version": True},
    {**HEADER, "ink": {}},
    {**HEADER, "space": "pad"},
    {**HEADER, "pigments": {"mine": {"K": [1.0], "S": [1.0]}}},
    {**SAMPLE, "pressure": 1.5},
    {**SAMPLE, "time_ns": 0.5},
    {**SAMPLE, "position": [0, 0]},
    {"do": "dipp"},
    {"do": "dip", "reach": -0.1},
    {"do": "dip", "reach": "half"},
    {"do": "dip", "ink": ""},
    {"do": "dip", "ink": {"water": 0}},
    {"do": "wipe", "shares": 0.5},
    {"do": "set_brush"},
    {"do": "select_layer", "place": -1},
    {"do": "select_layer", "place": True},
    {"do": "set_symmetry", "radial": {"count": 1}},
    {"do": "set_mask", "angle": {"direction": [0, 0, 1]}},
    {"do": "follow_time", "seconds": 0.05, "times": 0},
]


def is_taken(line: dict) -> bool:
    check = check_command if "do" in line else check_header if "format" in line else check_sample
    try:
        check(line)
    except RecordingError:
        return False
    return True


def test_the_schema_is_one() -> None:
    Draft202012Validator.check_schema(schema())


@pytest.mark.parametrize("line", GOOD + BAD, ids=json.dumps)
def test_a_line_is_taken_where_the_schema_takes_it(line) -> None:
    """By somebody else's reading of the schema, too."""
    expected = line in GOOD and not any(line is bad for bad in BAD)
    assert Draft202012Validator(schema()).is_valid(line) == expected
    assert is_taken(line) == expected


def test_a_header_may_say_of_a_pigment_all_that_there_is_to_say() -> None:
    """Or a painting with an ink of one's own could not be written down."""
    known = {field.name for field in dataclasses.fields(Pigment)} - {"name"}
    assert set(schema()["$defs"]["pigment"]["properties"]) == known


def test_the_guides_example_is_a_score_and_its_table_has_every_command(tmp_path) -> None:
    part = DOCS.read_text("utf-8").split("## Version 2")[1]
    (tmp_path / "a.jsonl").write_text(part.split("```json\n")[1].split("```")[0], "utf-8")
    score = load_score(tmp_path / "a.jsonl")
    assert score.n_samples == 2
    told = set(re.findall(r"`(\w+)`", part))
    assert {line["do"] for line in score.events if isinstance(line, dict)} <= told
    assert {rule["properties"]["do"]["const"] for rule in schema()["$defs"].values()
            if "do" in rule.get("required", ())} <= told  # fmt: skip


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ([SAMPLE], r"a.jsonl:2: a sample lies outside of a stroke"),
        ([{"do": "begin_stroke"}, SAMPLE, SAMPLE], r"a.jsonl:4: time_ns is 5; expected more"),
        ([{"do": "begin_stroke"}, SAMPLE, {"do": "dip"}, SAMPLE], r"a.jsonl:5: time_ns is 5"),
        ([{"do": "begin_stroke"}] * 2, r"a.jsonl:3: begin_stroke comes during a stroke"),
        ([{"do": "begin_stroke"}, {**SAMPLE, "orientation": [1, 1, 0, 0]}], "has length 1.41"),
        ([{"do": "wype"}], "did you mean 'wipe'"),
    ],
)
def test_a_wrong_line_is_named(tmp_path, lines, told) -> None:
    file = tmp_path / "a.jsonl"
    file.write_text("\n".join(json.dumps(line) for line in (HEADER, *lines)))
    assert is_score(file)
    with pytest.raises(RecordingError, match=told):
        load_score(file)
    with pytest.raises(RecordingError, match="whole painting"):
        load_recording(file)


@pytest.mark.parametrize("suffix", [".jsonl", ".score.jsonl.gz"])
def test_what_was_written_is_read_back(tmp_path, suffix) -> None:
    score = load_score(EXAMPLE)
    save_score(score, tmp_path / f"a{suffix}")
    again = load_score(tmp_path / f"a{suffix}")
    assert list(write_score(again)) == list(write_score(score))
    with pytest.raises(ExportError, match="suffix"):
        save_score(score, tmp_path / "a.csv")
    assert not is_score(tmp_path / "none")


def test_the_command_line_paints_it(tmp_path, capsys) -> None:
    out = tmp_path / "a.p3d"
    words = ["replay", str(EXAMPLE), "--on", "plane", "--out", str(out), "--resolution", "2"]
    assert main(words) == 0
    session = load_session(out)
    assert session.surface.painted.any()
    assert session.surface.material.name == "xuan"
    first = out.read_bytes()
    assert main([*words, "--force"]) == 0
    assert out.read_bytes() == first
    assert isinstance(session.score, Score)


@pytest.mark.parametrize(
    ("option", "value"),
    [("brush", "full"), ("ink", "cinnabar"), ("tip", "cinnabar"), ("pickup", ".05"),
     ("hairs", "0"), ("at", ".5,.5"), ("size", "20"), ("spread", "1")],
)  # fmt: skip
def test_the_command_line_refuses_what_a_score_says_itself(tmp_path, capsys, option, value) -> None:
    words = ["replay", str(EXAMPLE), "--on", "plane", "--out", str(tmp_path / "a.p3d")]
    assert main([*words, f"--{option}", value]) == 2
    assert f"expected no --{option}" in capsys.readouterr().err
