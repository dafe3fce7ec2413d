"""Job files for other engines: what is in them, and that each job paints its row."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from paint3d.cli import main
from paint3d.cli.batches import rows as batch_rows
from paint3d.cli.batches.emit import job_file
from paint3d.cli.batches.rows import Outcome
from paint3d.errors import InputError

TABLE = "text,object,output\n永,bowl,a.ply\n\n永,bowl,b.ply\n永,bowl,c.ply\n"


@pytest.fixture
def table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A table in a folder with a name that shells and makefiles take amiss."""
    folder = tmp_path / "it's $HOME & more"
    folder.mkdir()
    monkeypatch.chdir(folder)
    Path("t.csv").write_text(TABLE, encoding="utf-8")
    return Path("t.csv")


def emit(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    assert main.main(["batch", *map(str, arguments)]) == 0
    return capsys.readouterr().out


@pytest.fixture
def told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Lets jobs tell in a file what they were started with, instead of painting."""
    package, file = tmp_path / "stand in" / "paint3d", tmp_path / "told"
    package.mkdir(parents=True)
    code = f"import sys; open({str(file)!r}, 'a').write('|'.join(sys.argv[1:]) + '\\n')"
    (package / "__init__.py").touch()
    (package / "__main__.py").write_text(code)
    monkeypatch.setenv("PYTHONPATH", str(package.parent))
    return file


def asked(row: int) -> str:
    here = os.getcwd()
    return f"batch|{here}/t.csv|--folder|{here}|--quiet|--row|{row}"


def test_a_makefile_makes_every_row(table, told, tmp_path, capsys) -> None:
    if shutil.which("make") is None:
        pytest.skip("make is not installed")
    (tmp_path / "jobs.mk").write_text(emit(capsys, table, "--emit", "make"))
    subprocess.run(["make", "-s", "-f", tmp_path / "jobs.mk"], check=True, cwd=tmp_path)
    assert told.read_text().splitlines() == [asked(2), asked(4), asked(5)]
    subprocess.run(["make", "-s", "-f", tmp_path / "jobs.mk", "row-4"], check=True, cwd=tmp_path)
    assert told.read_text().splitlines()[3:] == [asked(4)]


def test_a_job_array_has_a_task_for_every_row(table, told, tmp_path, capsys) -> None:
    script = emit(capsys, table, "--emit", "slurm")
    assert "#SBATCH --array=2,4-5\n" in script
    assert "{" not in script
    (tmp_path / "job.sh").write_text(script)
    environment = {**os.environ, "SLURM_ARRAY_TASK_ID": "4"}
    subprocess.run(["sh", tmp_path / "job.sh"], check=True, cwd=tmp_path, env=environment)
    assert told.read_text().splitlines() == [asked(4)]


def test_an_open_job_description_has_a_task_for_every_row(table, told, capsys) -> None:
    template = json.loads(emit(capsys, table, "--emit", "openjd"))
    assert template["specificationVersion"] == "jobtemplate-2023-09"
    (step,) = template["steps"]
    (parameter,) = step["parameterSpace"]["taskParameterDefinitions"]
    assert parameter == {"name": "Row", "type": "INT", "range": "2,4-5"}
    action = step["script"]["actions"]["onRun"]
    words = [word.replace("{{Task.Param.Row}}", "5") for word in action["args"]]
    subprocess.run([action["command"], *words], check=True)
    assert action["command"] == sys.executable
    assert told.read_text().splitlines() == [asked(5)]


def test_a_step_has_no_more_tasks_than_are_allowed() -> None:
    template = json.loads(job_file("openjd", Path("t.csv"), ".", range(2, 3000)))
    ranges = [
        step["parameterSpace"]["taskParameterDefinitions"][0]["range"] for step in template["steps"]
    ]
    assert ranges == ["2-1025", "1026-2049", "2050-2999"]
    assert len({step["name"] for step in template["steps"]}) == 3


def test_names_that_no_job_file_can_hold_are_refused(tmp_path, monkeypatch) -> None:
    for name in ("two\nlines", "{{Task.Param.Row}}"):
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        with pytest.raises(InputError, match="cannot be written into a job file"):
            job_file("make", Path("t.csv"), ".", [2])


def test_a_row_is_painted_alone_and_counts_as_finished(table, tmp_path, monkeypatch, capsys):
    done = []

    folder, started_in = Path.cwd(), [tmp_path]

    def run(options) -> None:
        assert Path.cwd() == started_in[0]
        done.append(os.path.abspath(options.out))
        options.out.write_text("painted")

    monkeypatch.setattr(batch_rows.COMMANDS["write"], "run", run)
    (tmp_path / "b.ply").write_text("another, in the working folder")
    monkeypatch.chdir(tmp_path)
    command = ["batch", str(folder / table), "--folder", str(folder), "--row"]
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
    assert "--array=2,5\n" in emit(capsys, table, "--emit", "slurm")
    assert "--array=2,4-5\n" in emit(capsys, table, "--emit", "slurm", "--again")
    assert main.main(["batch", str(table)]) == 0
    capsys.readouterr()
    assert main.main(["batch", str(table), "--emit", "slurm"]) == 2
    assert "every row is finished; expected --again" in capsys.readouterr().err


def test_a_row_that_fails_ends_its_job_with_an_error(table, monkeypatch, capsys) -> None:
    monkeypatch.setattr(
        "paint3d.cli.batches.rows.run_row", lambda row: Outcome(row.line, "no ink", 0.0, "")
    )
    assert main.main(["batch", str(table), "--row", "5"]) == 2
    told = capsys.readouterr().err.splitlines()
    assert told == ["t.csv:5: no ink", "paint3d: error: t.csv: 1 of 1 rows failed, in line 5"]


def test_nothing_is_written_for_a_table_with_bad_rows(table, capsys) -> None:
    table.write_text(TABLE + "永,bowl,a.ply\n", encoding="utf-8")
    assert main.main(["batch", str(table), "--emit", "make"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "t.csv:6: a.ply is the output of line 2 too" in err
