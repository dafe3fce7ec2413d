"""Batch: the tables there are, the words that rows become, and what is finished."""

import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from paint3d.cli.batches import cluster as batch_cluster
from paint3d.cli.batches import rows as batch_rows
from paint3d.cli.batches import table as batch_table
from paint3d.cli.batches.record import FinishedRows
from paint3d.cli.batches.rows import Row, fingerprint, placed, run_row
from paint3d.cli.batches.table import read_table
from paint3d.cli.painting import PaintingOptions, load_object
from paint3d.errors import ExportError, InputError, MeshError


def table(tmp_path, text):
    path = tmp_path / "table.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_table(path)


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_cells_may_be_parted_by_others_than_commas(tmp_path, delimiter):
    lines = ["text|object|output|size", "永,和|bowl|a.ply|12.5"]
    rows, refused = table(tmp_path, "\r\n".join(lines).replace("|", delimiter))
    assert refused == []
    assert rows[0].arguments[:3] == ("write", "--on=bowl", "--out=a.ply")
    assert rows[0].arguments[-1] == "永,和"


def test_a_row_is_what_one_would_type(tmp_path):
    rows, refused = table(
        tmp_path,
        "\ufeffText,recording,object,output,brush,ink,size,around,--layout\r\n"
        '"永\n和",,jug.obj, a.glb ,full,墨,12.5,yes,row\r\n'
        " ,,,,,,,,\r\n"
        ",-s.jsonl,bowl,b.ply,,,,no,\r\n"
        "永,,bowl,c.ply,,,,no,\r\n",
    )
    assert refused == []
    shared = ("--quiet", "--")
    assert rows[0] == Row(
        3, "a.glb",
        ("write", "--on=jug.obj", "--out=a.glb", "--brush=full", "--ink=墨", "--size=12.5",
         "--around", "--layout=row", "--processes=1", *shared, "永\n和"),
    )  # fmt: skip
    assert rows[1].arguments == ("replay", "--on=bowl", "--out=b.ply", *shared, "-s.jsonl")
    assert rows[2].arguments == (
        "write", "--on=bowl", "--out=c.ply", "--processes=1", *shared, "永"
    )  # fmt: skip
    rows, _ = table(tmp_path, "text,object,output,processes\n永,bowl,a.ply,2\n")
    assert [word for word in rows[0].arguments if "processes" in word] == ["--processes=2"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "table.csv:1: there is no column object"),
        ("text,object\n", "there is no column output"),
        ("object,output\n", "there is no column text or recording"),
        ("text,object,output,brusch\n", "unknown column 'brusch'; did you mean brush?"),
        ("text,on,output\n", "unknown column 'on'; did you mean object?"),
        ("text,object,output,quiet\n", "unknown column 'quiet'"),
        ("text,object,output,h\n", "unknown column 'h'"),
        ("text,text,object,output\n", "two columns have the same name"),
        ("text,object,output\n\n", "it has no rows"),
        ('text,object,output\n"unclosed', "it is no CSV table"),
        ("text,object,output\n永,bowl,a.ply\n" + "\n" * 30, "it is larger than 60 bytes"),
        (b"text,object,output\ngef\xe4\xdf,bowl,a.ply\n", "byte 22 is not UTF-8"),
    ],
)
def test_tables_that_are_refused(tmp_path, monkeypatch, text, words):
    monkeypatch.setattr(batch_table, "MAX_BYTES", 60)
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
        (
            ("replay", "--on=plane", "--out=a.ply", "--", "none.jsonl"),
            "none.jsonl: there is no such file",
        ),
        (("replay", "--on=plane", "--out=a.ply", "--resolution=fine", "--", "a"), "not a length"),
        (("replay", "--out=a.ply", "--", "a"), "arguments are required: --on"),
        (("replay", "--on=plane", "--out=a.ply", "--", "no\nne"), "no ne: there is no such file"),
        (("fly",), "unexpected ModuleNotFoundError"),
    ],
)
def test_a_row_that_fails_says_why_in_one_line(arguments, words):
    outcome = run_row(Row(7, "a.ply", arguments))
    assert outcome.line == 7
    assert words in outcome.message
    assert "\n" not in outcome.message


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (MemoryError(), "out of memory"),
        (OSError(28, "No space left on device"), "a.ply: No space left on device"),
        (OSError(5, "Input/output error", "b.obj"), "b.obj: Input/output error"),
    ],
)
def test_what_the_machine_lacks_costs_the_row_only(monkeypatch, fault, words):
    def run(options):
        raise fault

    monkeypatch.setattr("paint3d.cli.replay.run", run)
    row = Row(7, "a.ply", ("replay", "--on=plane", "--out=a.ply", "--", "a"))
    assert run_row(row)[:2] == (7, words)


def test_a_row_is_finished_until_it_its_files_or_its_output_change(tmp_path):
    recording, output = tmp_path / "s.jsonl", tmp_path / "a.ply"
    recording.write_text("{}")
    row = Row(2, str(output), ("replay", "--on=bowl", f"--out={output}", "--", str(recording)))
    finished = FinishedRows(tmp_path / "finished")
    finished.add(row, 2.5)  # there is no output: nothing is noted
    assert not (tmp_path / "finished").exists()
    assert not finished.has(row)
    output.write_text("painted")
    finished.add(row, 2.5)
    with open(tmp_path / "finished", "ab") as file:
        file.write(b'[]\n{"row": 3}\n\xff\n{"row": "cut sho')
    assert FinishedRows(tmp_path / "finished").has(row)
    assert FinishedRows(tmp_path / "finished").has(row._replace(line=9))
    changed = row._replace(arguments=(*row.arguments[:1], "--ink=墨", *row.arguments[1:]))
    assert not FinishedRows(tmp_path / "finished").has(changed)
    before = fingerprint(row)
    os.utime(recording, ns=(1, 1))
    assert fingerprint(row) != before
    assert not FinishedRows(tmp_path / "finished").has(row)
    FinishedRows(tmp_path / "finished").add(row, 2.5)  # after a line that is cut short
    assert FinishedRows(tmp_path / "finished").has(row)
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


def test_a_row_depends_on_its_object_on_the_folder_and_on_the_version(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("jug.obj").write_text("v 0 0 0\n")
    row = Row(2, "a.ply", ("write", "--on=jug.obj", "--out=a.ply", "--", "\u6c38"))
    known = [fingerprint(row)]
    Path("jug.obj").write_text("v 0 0 0\nv 1 0 0\n")
    known.append(fingerprint(row))
    monkeypatch.setattr(batch_rows, "find_versions", lambda: {"paint3d": "99"})
    known.append(fingerprint(row))
    shutil.copytree(tmp_path, tmp_path / "b")
    monkeypatch.chdir("b")
    known.append(fingerprint(row))
    assert len(set(known)) == 4


def test_an_object_is_read_once_until_its_file_changes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    corners = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 9 9 0\n"
    Path("jug.obj").write_text(corners + "f 1 2 3\n")
    options = PaintingOptions(on="jug.obj", quiet=True)
    mesh = load_object(options)
    assert load_object(options) is mesh
    assert load_object(replace(options, unit="cm")).area == 100.0 * mesh.area
    assert load_object(options).area == mesh.area
    Path("jug.obj").write_text(corners + "f 1 2 3\nf 2 4 3\n")
    assert load_object(options).area == 2.0 * mesh.area
    Path("jug.obj").write_text(corners.replace("9", "3") + "f 1 2 3\nf 2 4 3\n")
    assert load_object(options).area == pytest.approx(2.0 / 9.0 * mesh.area)
    Path("other").mkdir()
    shutil.copy2("jug.obj", "other")
    changed = os.stat("jug.obj")
    Path("other/jug.obj").write_text(corners + "f 1 2 3\nf 2 4 3\n")
    os.utime("other/jug.obj", ns=(changed.st_atime_ns, changed.st_mtime_ns))
    monkeypatch.chdir("other")
    assert load_object(options).area == 2.0 * mesh.area
    os.remove("jug.obj")
    with pytest.raises(MeshError, match="no such file"):
        load_object(options)


def test_a_scheduler_that_is_not_there(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(batch_cluster, "PATIENCE_S", 0.5)
    with pytest.raises(InputError, match=r"scheduler tcp://127\.0\.0\.1:9 does not answer"):
        next(batch_cluster.run_on_cluster([Row(1, "a", ("replay",))], "tcp://127.0.0.1:9"))


def test_a_row_is_run_elsewhere_with_the_files_of_its_folder(tmp_path):
    (tmp_path / "jug.obj").write_text("")
    options = ("--out=b/a.ply", "--report=/c/r.json", "--ink=my.csv:mud", "--size=2", "--quiet")
    row = Row(2, "b/a.ply", ("replay", "--on=jug.obj", *options, "--", "--out=s.jsonl"))
    there = placed(row, str(tmp_path))
    assert there[:2] == row[:2]
    assert there.arguments == (
        "replay", f"--on={tmp_path}/jug.obj", f"--out={tmp_path}/b/a.ply", "--report=/c/r.json",
        f"--ink={tmp_path}/my.csv:mud", "--size=2", "--quiet", "--", f"{tmp_path}/--out=s.jsonl",
    )  # fmt: skip
    (tmp_path / "own.ttf").write_text("")
    own, known = "--font=own.ttf", "--font=DejaVu Sans"
    write = ("write", "--on=bowl", "--out=a.ply", "--ink=墨", own, known, "--", "--out=永")
    there = placed(Row(2, "a.ply", write), str(tmp_path))
    assert there.arguments == (
        "write", "--on=bowl", f"--out={tmp_path}/a.ply", "--ink=墨", f"--font={tmp_path}/own.ttf",
        known, "--", "--out=永",
    )  # fmt: skip
