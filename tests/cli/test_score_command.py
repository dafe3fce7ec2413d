"""``paint3d score``: strokes of a whole painting listed and edited, as the guide says."""

from __future__ import annotations

import json
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest

from paint3d.cli.main import main
from paint3d.files.project.session import load_session
from paint3d.recording.score import load_score

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "bamboo.score.jsonl"


@pytest.fixture
def score(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copy(EXAMPLE, tmp_path))


def guides() -> tuple[list[str], str]:
    part = (ROOT / "docs" / "recordings.md").read_text("utf-8").split("### Edited afterwards")[1]
    commands = part.split("```sh\n")[1].split("```")[0].splitlines()
    return commands, part.split("```python\n")[1].split("```")[0]


def test_the_guides_commands_do_what_it_says(score, capsys) -> None:
    commands, _ = guides()
    for command in commands:
        program, *words = shlex.split(command)
        assert program == "paint3d"
        assert main(words) == 0
    told = capsys.readouterr().out.splitlines()
    assert told[0].split() == ["stroke", "brush", "ink", "mm", "s"]
    assert told[4].split()[0] == "4"
    assert told[4].endswith("undone")
    first = load_score(score).strokes()
    redder = load_score("redder.score.jsonl")
    assert len(load_score("thinner.score.jsonl").strokes()) == len(first) - 1
    inks = [
        e.get("ink") for e in redder.events if isinstance(e, dict) and e["do"] == "begin_stroke"
    ]
    assert inks == [None] * 4 + ["cinnabar"] * 2 + [None]
    way = redder.strokes()[2].position.mean(axis=0) - first[2].position.mean(axis=0)
    np.testing.assert_allclose(way, [-5.0, 2.0, 0.0], atol=1.0)
    times = load_score("other.score.jsonl").strokes()[5].time_ns
    assert times[-1] - times[0] == 2_000_000_000
    names = [pigment.name for pigment in load_session("redder.p3d").surface.pigments]
    assert "cinnabar" in names


def test_the_guides_program_runs(score) -> None:
    import paint3d

    exec(guides()[1], {"paint3d": paint3d})
    assert len(load_score("redder.score.jsonl").strokes()) == 7


def test_a_brush_and_an_ink_of_ones_own_go_into_the_score(score, tmp_path, capsys) -> None:
    assert main(["brushes", "show", "full"]) == 0
    Path("mine.toml").write_text(capsys.readouterr().out.replace('"full"', '"mine"'))
    waves = [f"{kind}_{400 + 10 * k}" for kind in "KS" for k in range(31)]
    spectra = ["4"] * 31 + ["1"] * 31
    Path("own.csv").write_text("\n".join([",".join(["name", *waves]), ",".join(["own", *spectra])]))
    words = [
        "score",
        str(score),
        "--brush",
        "2:mine.toml",
        "--ink",
        "3:own.csv:own",
        "--out",
        "a.jsonl",
        "--quiet",
    ]
    assert main(words) == 0
    edited = load_score("a.jsonl")
    begun = [e for e in edited.events if isinstance(e, dict) and e["do"] == "begin_stroke"]
    assert begun[1]["brush"]["length_mm"] > 0
    assert begun[2]["ink"] == "own"
    assert edited.header["pigments"]["own"]["K"] == [4.0] * 31
    assert main(["replay", "a.jsonl", "--on", "plane", "--resolution", "3", "--out", "a.p3d"]) == 0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--delete 9 --out x.jsonl", "--delete stroke 9; expected 1 to 7"),
        ("--delete x --out x.jsonl", "'x' numbers no strokes; expected one (3)"),
        ("--delete 3:1 --out x.jsonl", "expected N (see"),
        ("--move 3:5 --out x.jsonl", "'5'; expected DX,DY in mm"),
        ("--move 3:900,0 --out x.jsonl", "stroke 3: its middle would come to the edge"),
        ("--ink 3 --out x.jsonl", "expected N:MIXTURE"),
        ("--ink 3:sut --out x.jsonl", "--ink of stroke 3: unknown ink 'sut'"),
        ("--brush 3:borad --out x.jsonl", "--brush of stroke 3: unknown brush 'borad'"),
        ("--time 3:0 --out x.jsonl", "expected a factor (1.5) or seconds (2s)"),
        ("--time 3:2ss --out x.jsonl", "'2s' is no number"),
        ("--shift 3:-9 --out x.jsonl", "stroke 3 cannot begin 9.00 s earlier: the pause before"),
        ("--delete 3", "no --out is given"),
        ("--list --out x.jsonl", "--out is given without an edit"),
        ("", "nothing is asked for; expected --list or an edit"),
        ("--delete 3 --out x.csv", "x.csv: unknown kind of file"),
        ("--delete 3 --out bamboo.score.jsonl", "--force"),
    ],
)
def test_what_cannot_be_is_told_in_a_line(score, capsys, words, told) -> None:
    assert main(["score", score.name, *words.split()]) == 2
    said = capsys.readouterr()
    assert told in said.err
    assert said.err.count("\n") == 1
    assert not Path("x.jsonl").exists()


def test_a_recording_of_version_1_is_no_score(score, capsys) -> None:
    Path("one.jsonl").write_text('{"format": "paint3d-recording", "version": 1}\n')
    assert main(["score", "one.jsonl", "--list"]) == 2
    assert "no recording of version 2" in capsys.readouterr().err


def test_strokes_of_a_file_are_moved_on_the_object_that_is_named(score, capsys) -> None:
    text = score.read_text("utf-8").replace('"object": "plane"', '"object": "mine.obj"')
    score.write_text(text, "utf-8")
    words = ["score", score.name, "--move", "3:1,1", "--out", "a.jsonl", "--quiet"]
    assert main(words) == 2
    assert "expected --on MESH" in capsys.readouterr().err
    assert main([*words, "--on", "plane"]) == 0


def test_a_length_is_that_of_the_way_on_which_the_brush_is_pressed(tmp_path, capsys) -> None:
    """10 mm through the air, 30 pressed, and 5 through the air again."""
    x, pressure = (0, 10, 20, 40, 45), (0.0, 0.0, 0.4, 0.0, 0.0)
    at_s = (0.0, 0.25, 0.5, 1.0, 1.25)
    header = {"format": "paint3d-recording", "version": 2, "object": "plane"}
    samples = [
        {"time_ns": round(t * 1e9), "position": [place, 0, 35], "orientation": [1, 0, 0, 0],
         "pressure": press}
        for t, place, press in zip(at_s, x, pressure, strict=True)
    ]  # fmt: skip
    lines = [header, {"do": "begin_stroke"}, *samples, {"do": "end_stroke"}]
    file = tmp_path / "a.score.jsonl"
    file.write_text("\n".join(map(json.dumps, lines)))
    assert main(["score", str(file), "--list"]) == 0
    row = capsys.readouterr().out.splitlines()[1].split()
    assert row == ["1", "full", "pine", "soot", "30.0", "1.25"]
