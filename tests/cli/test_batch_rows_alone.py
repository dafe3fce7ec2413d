"""Rows that are painted one by one, as the jobs of a farm's array do."""

from __future__ import annotations

import logging
import os
from pathlib import Path

import pytest

from paint3d.cli import main
from paint3d.cli.batches.rows import Outcome

TABLE = "text,object,output\n永,bowl,a.ply\n\n永,bowl,b.ply\n永,bowl,c.ply\n"


@pytest.fixture
def table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A table in a folder with a name that shells and makefiles take amiss."""
    folder = tmp_path / "it's $HOME & more"
    folder.mkdir()
    monkeypatch.chdir(folder)
    Path("t.csv").write_text(TABLE, encoding="utf-8")
    return Path("t.csv")


def test_a_row_is_painted_alone_and_counts_as_finished(table, tmp_path, monkeypatch, capsys):
    done = []

    folder, started_in = Path.cwd(), [tmp_path]

    def run(options) -> None:
        assert Path.cwd() == started_in[0]
        done.append(os.path.abspath(options.out))
        options.out.write_text("painted")

    monkeypatch.setattr("paint3d.cli.write.run", run)
    (tmp_path / "b.ply").write_text("another, in the working folder")
    monkeypatch.chdir(tmp_path)
    command = ["batch", str(folder / table), "--folder", str(folder), "--rows"]
    assert main.main([*command, "4"]) == 0
    assert done == [str(folder / "b.ply")]
    assert Path.cwd() == tmp_path
    assert (tmp_path / "b.ply").read_text().startswith("another")
    assert main.main([*command, "4"]) == 0
    assert done == [str(folder / "b.ply")]
    assert main.main([*command, "4", "--again"]) == 0
    assert done == [str(folder / "b.ply")] * 2
    capsys.readouterr()
    nowhere = [str(folder / table), "--folder", str(folder / "none")]
    assert main.main(["batch", *nowhere]) == 2
    assert "none: there is no such folder" in capsys.readouterr().err
    assert main.main([*command, "3"]) == 2
    assert "there is no row in line 3" in capsys.readouterr().err
    monkeypatch.chdir(folder)
    started_in[0] = folder
    assert main.main(["batch", str(table)]) == 0
    assert "2 painted" in capsys.readouterr().out, "the others"


def test_a_row_that_fails_ends_its_job_with_an_error(table, monkeypatch, capsys) -> None:
    monkeypatch.setattr(
        "paint3d.cli.batches.rows.run_row", lambda row: Outcome(row.line, "no ink", 0.0, "")
    )
    assert main.main(["batch", str(table), "--rows", "5"]) == 2
    told = capsys.readouterr().err.splitlines()
    assert told == ["t.csv:5: no ink", "paint3d: error: t.csv: 1 of 1 rows failed, in line 5"]


def test_notes_name_their_row_and_what_a_font_lacks_is_told_first(
    table, tmp_path, monkeypatch, capsys, system_fonts
) -> None:
    def run(options) -> None:
        logging.getLogger("paint3d.calligraphy").warning("blots: %s", options.text)
        options.out.write_text("painted")

    monkeypatch.setattr("paint3d.cli.write.run", run)
    system_fonts.add("Test Serif", "Len永")
    rows = (
        "永,bowl,50%.ply,,\nLena,bowl,b.ply,Test Serif,\nLen,bowl,c.ply,Test Serif,\n"
        "永,bowl,d.ply,,large\n"
    )
    table.write_text("text,object,output,font,size\n" + rows, encoding="utf-8")
    assert main.main(["batch", str(table), "--rows", "2-5"]) == 2
    told = capsys.readouterr()
    first, *notes = [line for line in told.err.splitlines() if "t.csv:3" in line or "note" in line]
    assert first.startswith("t.csv:3: Test Serif has no glyph for 'a' (U+0061)")
    assert notes == [
        "paint3d: note: line 2, 50%.ply: blots: 永", "paint3d: note: line 4, c.ply: blots: Len"
    ]  # fmt: skip
    assert "t.csv:5: argument --size: 'large' is not a length" in told.err
    assert "2 painted" in told.out
    assert "0 finished before, 2 failed" in told.out
    assert "2 of 4 rows failed" in told.err
