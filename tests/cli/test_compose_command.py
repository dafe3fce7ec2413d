"""Several things on one object: `compose`, `--on painting.p3d`, and `batch --group`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from paint3d.app.model.document import Document
from paint3d.cli.batches.rows import fingerprint, placed
from paint3d.cli.batches.table import read_table
from paint3d.cli.batches.workers import run_here
from paint3d.cli.main import main
from paint3d.device.recorded import MODEL
from paint3d.errors import InputError
from paint3d.files.project.session import load_session

TABLE = """text,seal,at,size,ink,layer
一,,"0.25,0.5",20,cinnabar,
,和,"0.75,0.5",12,,seal
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_text(TABLE, "utf-8")
    return tmp_path


def compose(*words: object, out: str = "a.p3d") -> int:
    return main(["compose", *map(str, words), "--on", "plane", "--resolution", "0.5", "--out", out])


def test_a_table_composes_a_painting_piece_by_piece(capsys) -> None:
    assert compose("t.csv", "--report", "r.json") == 0
    assert "a.p3d: 2 pieces" in capsys.readouterr().out
    document = Document.open("a.p3d")
    assert [layer.name for layer in document.layers] == ["1", "seal"]
    assert len(document.strokes) == 1
    painted = document.surface.painted
    left = document.surface.mesh.vertices[:, 0] < 0.0
    assert (painted & left).any()
    assert (painted & ~left).any()
    document.undo()  # the seal
    assert not document.surface.painted[: len(left)][~left].any()
    told = json.loads(Path("r.json").read_text("utf-8"))["pieces"]
    assert [piece["over_paint"] for piece in told] == [0.0, 0.0]


def test_pieces_may_be_given_without_a_table_and_overlaps_are_told(capsys) -> None:
    piece = json.dumps({"text": "一", "at": "0.5,0.5", "size": 20}, ensure_ascii=False)
    assert compose("--piece", piece, "--piece", piece, "--quiet") == 0
    assert capsys.readouterr().err == ""
    assert compose("--piece", piece, "--piece", piece) == 0
    assert "piece 2: 100 % of it lies over what was painted before" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("text,colour\n一,red\n", "t.csv:1: unknown column 'colour'"),
        ("text,sise\n一,2\n", "unknown column 'sise'; did you mean size?"),
        ("text,seal\n一,和\n", "t.csv:2: it has text and seal; expected one of text, svg"),
        ("text,size\n,3\n", "t.csv:2: it has none of them; expected one of text"),
        ("text,size\n一,0\n", "t.csv:2: argument --size: '0' is not a length"),
        ("text,coats\n一,2\n", "t.csv:2: coats is no option of write"),
        ("svg\nnone.svg\n", "t.csv:2: none.svg: there is no such file"),
        ("text,ink\n一,mud\n", "t.csv:2: unknown ink 'mud'"),
        ("text\n", "there is nothing to paint"),
    ],
)
def test_a_piece_that_cannot_be_used_is_named(capsys, table: str, words: str) -> None:
    Path("t.csv").write_text(table, "utf-8")
    assert compose("t.csv") == 2
    assert words in capsys.readouterr().err
    assert not Path("a.p3d").exists()


def test_writing_goes_on_with_a_painting(capsys) -> None:
    made = ("--on", "plane", "--resolution", "0.5")
    assert (
        main(["write", "一", *made, "--at", "0.25,0.5", "--out", "a.p3d", "--recording", "a.jsonl"])
        == 0
    )
    on = ("--on", "a.p3d", "--at", "0.75,0.5", "--layer", "more", "--ink", "cinnabar")
    assert main(["write", "一", *on, "--out", "b.p3d"]) == 0
    capsys.readouterr()
    first, both = load_session("a.p3d").surface, load_session("b.p3d").surface
    assert both.painted.sum() > 1.8 * first.painted.sum()
    assert [layer.name for layer in both.use_layers().layers] == ["1", "more"]
    assert main(["replay", "a.jsonl", "--on", "b.p3d", "--out", "c.p3d"]) == 0
    assert "100 % of it lies over what was painted before" in capsys.readouterr().err
    document = Document.open("c.p3d")
    for n_strokes in (2, 1, 0):
        assert len(document.strokes) == n_strokes
        if n_strokes:
            document.undo()
    assert document.surface.painted.sum() == first.painted.sum()
    assert main(["write", "一", "--on", "a.p3d", "--resolution", "1", "--out", "d.p3d"]) == 2
    assert "--resolution is given, and a.p3d is a painting" in capsys.readouterr().err


def test_going_on_paints_as_painting_anew_does() -> None:
    """The first stroke on a painting without paint is that on the bare object, to the bit."""
    made = ("--on", "plane", "--resolution", "0.5", "--recording", "a.jsonl")
    assert main(["write", "一", *made, "--out", "a.p3d"]) == 0
    Document.new("plane", 0.5).save("bare.p3d")
    assert main(["replay", "a.jsonl", "--on", "bare.p3d", "--out", "b.p3d"]) == 0
    one, other = (load_session(name).surface for name in ("a.p3d", "b.p3d"))
    np.testing.assert_array_equal(one.srgb, other.srgb)
    np.testing.assert_array_equal(one.coverage, other.coverage)


def test_a_recording_of_another_model_is_painted_and_said_to_be_one(capsys) -> None:
    """Strokes name the version that painted them; where none is named none is said."""
    on = ("--on", "plane", "--resolution", "0.6")
    assert main(["write", "一", *on, "--recording", "a.jsonl", "--out", "a.p3d"]) == 0
    head, *lines = Path("a.jsonl").read_text("utf-8").splitlines()
    named = json.loads(head)
    assert named["model"] == MODEL
    for model in (None, MODEL, MODEL + 1):
        own = {k: v for k, v in named.items() if k != "model"} | ({"model": model} if model else {})
        Path("b.jsonl").write_text("\n".join([json.dumps(own), *lines]) + "\n", "utf-8")
        capsys.readouterr()
        assert main(["replay", "b.jsonl", *on, "--out", f"{model}.p3d"]) == 0
        assert (f"version {model}" in capsys.readouterr().err) == (model == MODEL + 1)


def test_strokes_of_another_object_are_not_taken_for_a_robot_s(capsys) -> None:
    """Where a large character lay on the bowl, the handle points into a plane."""
    made = ("--on", "bowl", "--resolution", "1", "--size", "40", "--recording", "a.jsonl")
    assert main(["write", "福", *made, "--out", "a.p3d"]) == 0
    on = ("--on", "plane", "--resolution", "1", "--quiet", "--out", "b.p3d")
    capsys.readouterr()
    assert main(["replay", "a.jsonl", *on]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert "it was recorded on bowl" in said
    assert "expected --at U,V" in said
    assert "tool_q" not in said
    assert main(["replay", "a.jsonl", *on, "--at", "0.5,0.5"]) == 0


def test_a_recording_is_laid_on_another_object(capsys) -> None:
    made = ("--on", "bowl", "--resolution", "0.6", "--recording", "a.jsonl")
    assert main(["write", "一", *made, "--out", "a.p3d"]) == 0
    on = ("--on", "plane", "--resolution", "0.6", "--quiet")
    capsys.readouterr()
    assert main(["replay", "a.jsonl", *on, "--out", "b.p3d"]) == 2
    assert "it was recorded on bowl: --at U,V lays it on plane" in capsys.readouterr().err
    assert main(["replay", "a.jsonl", *on, "--at", "0.5,0.5", "--out", "b.p3d"]) == 0
    bowl, plane = (load_session(name).surface for name in ("a.p3d", "b.p3d"))
    areas = [float(one.vertex_areas[one.painted].sum()) for one in (bowl, plane)]
    assert areas[1] == pytest.approx(areas[0], rel=0.1)
    middle = plane.mesh.vertices[plane.painted].mean(axis=0)
    assert np.abs(middle).max() < 5.0


def test_rows_of_one_group_are_one_painting(folder: Path) -> None:
    header = "output,object,text,svg,seal,size,resolution\n"
    Path("g.csv").write_text(
        header + "a.p3d,plane,一,,,20,0.5\na.p3d,,,a.svg,,9,\nb.p3d,plane,,,和,,\n", "utf-8"
    )
    rows, refused = read_table(Path("g.csv"), "output")
    assert refused == []
    assert [(row.line, row.output) for row in rows] == [(2, "a.p3d"), (4, "b.p3d")]
    words = rows[0].arguments
    assert words[:4] == ("compose", "--on=plane", "--out=a.p3d", "--resolution=0.5")
    assert json.loads(words[4].removeprefix("--piece=")) == {"text": "一", "size": "20"}
    there = placed(rows[0], "/tables").arguments
    assert "--on=plane" in there
    assert json.loads(there[5].removeprefix("--piece="))["svg"] == "/tables/a.svg"
    before = fingerprint(rows[0])
    Path("a.svg").write_text("<svg/>")
    assert fingerprint(rows[0]) != before
    Path("g.csv").write_text(header + "a.p3d,plane,一,,,,\na.p3d,bowl,二,,,,\n", "utf-8")
    _, refused = read_table(Path("g.csv"), "output")
    assert "line 3 says 'bowl' as object" in refused[0].message
    Path("g.csv").write_text("mug,output,object,text\n", "utf-8")
    with pytest.raises(InputError, match="unknown column 'mug'"):
        read_table(Path("g.csv"), "output")


def test_a_group_is_painted_by_batch(capsys) -> None:
    Path("g.csv").write_text(
        "mug,output,object,text,at,size,resolution\n"
        'one,a.ply,plane,一,"0.3,0.5",20,1\none,,,一,"0.7,0.5",20,\n',
        "utf-8",
    )
    words = ["batch", "g.csv", "--group", "mug", "--processes", "1"]
    assert main([*words, "--report", "r.json"]) == 0
    assert "g.csv: 1 painted" in capsys.readouterr().out
    told = json.loads(Path("r.json").read_text("utf-8"))["rows"]
    assert [(row["line"], row["output"], row["failure"]) for row in told] == [(2, "a.ply", None)]
    assert main(words) == 0
    assert "0 painted" in capsys.readouterr().out


KILLED_ONCE = """
import os, pathlib, signal
mark = pathlib.Path("mark")
if not mark.exists():
    mark.write_text("")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_row_whose_process_was_killed_is_tried_again(monkeypatch) -> None:
    """By the operating system for want of memory, for one: a second try mostly has it."""
    Path("killer.py").write_text(KILLED_ONCE)
    Path("t.csv").write_text("text,object,output,size,resolution\n一,plane,a.ply,20,1\n", "utf-8")
    rows, _ = read_table(Path("t.csv"))
    monkeypatch.setattr("paint3d.cli.batches.workers._serve", _killed_once)
    (outcome,) = run_here(rows, 1, retries=1)
    assert outcome.message == ""
    Path("mark").unlink()
    Path("a.ply").unlink()
    (outcome,) = run_here(rows, 1, retries=0)
    assert outcome.message == "its process died (SIGKILL)"


def _killed_once(connection, quiet) -> None:
    from paint3d.cli.batches.workers import _run_all

    exec(Path("killer.py").read_text())
    _run_all(connection)
