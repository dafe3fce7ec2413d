"""Batch: the tables there are, the words that rows become, and what is finished."""

import os
from argparse import Namespace
from pathlib import Path

import pytest

from paint3d.cli import batch_workers
from paint3d.cli.batch_order import longest_first
from paint3d.cli.batch_record import FinishedRows
from paint3d.cli.batch_rows import Row, fingerprint, run_row
from paint3d.cli.batch_table import read_table
from paint3d.cli.objects import load_object
from paint3d.errors import ExportError, InputError, MeshError


def table(tmp_path, text):
    path = tmp_path / "table.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_table(path)


def test_a_row_is_what_one_would_type(tmp_path):
    rows, refused = table(
        tmp_path,
        "\ufeffText,recording,object,output,brush,ink,size,around,--layout\r\n"
        '"永\n和",,jug.obj,a.glb,full,墨,12.5,yes,row\r\n'
        "\r\n"
        ",-s.jsonl,bowl,b.ply,,,,no,\r\n",
    )
    assert refused == []
    shared = ("--quiet", "--")
    assert rows[0] == Row(
        3, "a.glb",
        ("write", "--on=jug.obj", "--out=a.glb", "--brush=full", "--ink=墨", "--size=12.5",
         "--around", "--layout=row", "--processes=1", *shared, "永\n和"),
    )  # fmt: skip
    assert rows[1].arguments == ("replay", "--on=bowl", "--out=b.ply", *shared, "-s.jsonl")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "table.csv:1: there is no column object"),
        ("text,object\n", "there is no column output"),
        ("object,output\n", "there is no column text or recording"),
        ("text,object,output,brusch\n", "unknown column 'brusch': did you mean 'brush'?"),
        ("text,object,output,quiet\n", "unknown column 'quiet'"),
        ("text,text,object,output\n", "two columns have the same name"),
        ("text,object,output\n\n", "it has no rows"),
        ('text,object,output\n"unclosed', "it is no CSV table"),
        (b"text,object,output\ngef\xe4\xdf,bowl,a.ply\n", "byte 22 is not UTF-8"),
    ],
)
def test_tables_that_are_refused(tmp_path, text, words):
    with pytest.raises(InputError) as caught:
        table(tmp_path, text)
    assert words in str(caught.value)
    with pytest.raises(InputError, match="No such file"):
        read_table(tmp_path / "none.csv")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("text,object,output\n永,bowl\n", "it has 2 cells; expected 3"),
        ("text,object,output\n,bowl,a.ply\n", "neither a text nor a recording"),
        ("text,object,output\na,,a.ply\n", "it has no object"),
        ("recording,text,object,output\na,b,bowl,a.ply\n", "both a text and a recording"),
        ("recording,around,object,output\na,yes,bowl,a.ply\n", "around is no option of replay"),
        (
            "text,around,object,output\na,maybe,bowl,a.ply\n",
            "is 'maybe'; expected yes or no",
        ),
        ("text,object,output\na,bowl,x.ply\nb,bowl,x.ply\n", "x.ply is the output of line 2 too"),
    ],
)
def test_rows_that_are_refused(tmp_path, text, words):
    _, refused = table(tmp_path, text)
    assert len(refused) == 1
    assert words in refused[0].message


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("replay", "--on=plane", "--out=a.ply", "--", "none.jsonl"), "none.jsonl: cannot be read"),
        (("replay", "--on=plane", "--out=a.ply", "--resolution=fine", "--", "a"), "not a length"),
        (("replay", "--out=a.ply", "--", "a"), "arguments are required: --on"),
        (("fly",), "unexpected KeyError: 'fly'"),
    ],
)
def test_a_row_that_fails_says_why_in_one_line(arguments, words):
    outcome = run_row(Row(7, "a.ply", arguments))
    assert outcome.line == 7
    assert words in outcome.message
    assert "\n" not in outcome.message


def test_a_row_is_finished_until_it_its_files_or_its_output_change(tmp_path):
    recording, output = tmp_path / "s.jsonl", tmp_path / "a.ply"
    recording.write_text("{}")
    row = Row(2, str(output), ("replay", "--on=bowl", f"--out={output}", "--", str(recording)))
    finished = FinishedRows(tmp_path / "finished")
    finished.add(row, 2.5)  # there is no output: nothing is noted
    assert not (tmp_path / "finished").exists()
    output.write_text("painted")
    finished.add(row, 2.5)
    with open(tmp_path / "finished", "a", encoding="utf-8") as file:
        file.write('[]\n{"row": 3}\n\xff\n{"row": "cut sho')
    assert FinishedRows(tmp_path / "finished").has(row)
    assert FinishedRows(tmp_path / "finished").seconds(row) == 2.5
    assert FinishedRows(tmp_path / "finished").has(row._replace(line=9))
    changed = row._replace(arguments=(*row.arguments[:1], "--ink=墨", *row.arguments[1:]))
    assert not FinishedRows(tmp_path / "finished").has(changed)
    before = fingerprint(row)
    os.utime(recording, ns=(1, 1))
    assert fingerprint(row) != before
    assert not FinishedRows(tmp_path / "finished").has(row)
    finished.add(row, 2.5)
    output.write_text("touched by another")
    assert not FinishedRows(tmp_path / "finished").has(row)
    with pytest.raises(ExportError, match="cannot read it"):
        FinishedRows(tmp_path)


def test_a_finished_row_stays_so_when_other_files_come_into_the_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_text("text,object,output\n\u6c38,bowl,a.ply\n", encoding="utf-8")
    (row,), _ = read_table(Path("t.csv"))
    Path("a.ply").write_bytes(b"ply")
    FinishedRows(Path("t.csv.finished")).add(row, 1.0)
    Path("b.ply").write_bytes(b"ply")
    assert FinishedRows(Path("t.csv.finished")).has(row)


def test_long_rows_are_started_first(tmp_path):
    text = "text,object,output,recording\n"
    text += "一,bowl,a.ply,\n鬱,bowl,b.ply,\n一二三,bowl,c.ply,\n一,bowl,d.ply,\n"
    for name, size in (("short", 1000), ("long", 40_000_000)):
        (tmp_path / f"{name}.jsonl").touch()
        os.truncate(tmp_path / f"{name}.jsonl", size)
        text += f",bowl,{name}.ply,{tmp_path / name}.jsonl\n"
    rows, _ = table(tmp_path, text)
    record = tmp_path / "finished"
    names = [row.output[0] for row in longest_first(rows, FinishedRows(record))]
    assert names == ["l", "b", "c", "a", "d", "s"]
    record.write_text(
        '{"row": "", "size": 1, "changed_ns": 1, "output": "d.ply", "seconds": 99}\n'
        '{"row": "", "size": 1, "changed_ns": 1, "output": "c.ply"}\n'
    )
    names = [row.output[0] for row in longest_first(rows, FinishedRows(record))]
    assert names == ["d", "l", "b", "c", "a", "s"]


def test_an_object_is_read_once_until_its_file_changes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    corners = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 9 9 0\n"
    Path("jug.obj").write_text(corners + "f 1 2 3\n")
    options = Namespace(on="jug.obj", unit=None, from_points=None, texture=False)
    mesh = load_object(options)
    assert load_object(options) is mesh
    assert load_object(Namespace(**{**vars(options), "unit": "cm"})).area == 100.0 * mesh.area
    assert load_object(options).area == mesh.area
    Path("jug.obj").write_text(corners + "f 1 2 3\nf 2 4 3\n")
    assert load_object(options).area == 2.0 * mesh.area
    Path("other").mkdir()
    monkeypatch.chdir("other")
    with pytest.raises(MeshError, match="no such file"):
        load_object(options)


def test_a_scheduler_that_is_not_there(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(batch_workers, "PATIENCE_S", 0.5)
    with pytest.raises(InputError, match=r"scheduler tcp://127\.0\.0\.1:9 does not answer"):
        next(batch_workers.run_on_cluster([Row(1, "a", ("replay",))], "tcp://127.0.0.1:9"))
