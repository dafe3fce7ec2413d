"""A table of paintings: every row that can be painted is, to the same bytes wherever it is."""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from paint3d.core.kernel_library import library

HEADER = ("recording", "object", "brush", "ink", "output", "resolution", "text")
CLUSTER = """
import sys
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""
INTERRUPTED = """
import os, signal, sys
from multiprocessing import connection, forkserver
from paint3d.cli.main import main

ask, number = forkserver.connect_to_new_process, int(sys.argv.pop(1))

def ask_and_be_interrupted(*given):
    status, data = ask(*given)
    connection.wait([status])  # it is there, and waits for what it is to do
    os.kill(os.getpid(), number)
    return status, data

forkserver.connect_to_new_process = ask_and_be_interrupted
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def write_table(tmp_path: Path, recording: Path):
    """Write a table of rows (brush, ink, output) that replay the recording on the plane."""

    def write(*rows, name: str = "table.csv", **columns: str) -> Path:
        with open(tmp_path / name, "w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow([*HEADER, *columns])
            for brush, ink, output in rows:
                cells = [recording, "plane", brush, ink, tmp_path / output, "0.8", ""]
                table.writerow([*cells, *columns.values()])
        return tmp_path / name

    return write


ROWS = [("full", "pine soot", "a.ply"), ("slender", "cinnabar", "b.p3d"), ("", "", "c.obj")]


def bytes_of(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for _, _, name in ROWS}


def test_rows_are_painted_as_alone_and_bad_ones_do_not_stop_them(
    paint3d, write_table, recording: Path, tmp_path: Path
) -> None:
    bad = [("fulll", "", "x.ply"), ("", "no such ink", "y.ply"), ("", "", "z.nothing")]
    table = write_table(ROWS[0], *bad, ("", "", "a.ply"), *ROWS[1:])
    done = paint3d("batch", table, "--processes", "2")
    assert done.returncode == 2
    lines = done.stderr.splitlines()
    assert lines[-1] == f"paint3d: error: {table}: 4 of 7 rows failed, in line 3, 4, 5, 6"
    told = {line.partition(": ")[0]: line for line in lines[:-1]}
    assert "did you mean 'full'?" in told[f"{table}:3"]
    assert "unknown ink 'no such ink'" in told[f"{table}:4"]
    assert "z.nothing: unknown kind of file" in told[f"{table}:5"]
    assert "is the output of line 2 too" in told[f"{table}:6"]
    assert "table.csv: 3 painted in " in done.stdout
    assert not any((tmp_path / name).exists() for _, _, name in bad)
    made = bytes_of(tmp_path)
    alone = paint3d("replay", recording, "--on", "plane", "--brush", "full", "--ink", "pine soot",
                    "--resolution", "0.8", "--out", tmp_path / "alone.ply")  # fmt: skip
    assert alone.returncode == 0, alone.stderr
    assert made["a.ply"] == (tmp_path / "alone.ply").read_bytes()


def test_an_interrupted_batch_goes_on(paint3d, write_table, tmp_path: Path) -> None:
    more = [("", "", f"more_{k}.ply") for k in range(12)]  # time for the signal to arrive
    table = write_table(*ROWS, *more)
    command = [sys.executable, "-m", "paint3d", "batch", table, "--processes", "1"]
    running = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        # a shell's background jobs, as tests may be, ignore what they are to obey here
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    assert running.stdout is not None
    first = running.stdout.readline()
    assert first.startswith(str(tmp_path / "a.ply"))
    running.send_signal(signal.SIGINT)
    _, errors = running.communicate(timeout=300)
    assert running.returncode == 130
    *before, last = errors.splitlines()
    assert last == "paint3d: error: interrupted"
    assert all(line.startswith("painting rows") for line in before)  # how far a slow machine came
    finished = tmp_path / "table.csv.finished"
    assert json.loads(finished.read_text().splitlines()[0])["output"] == str(tmp_path / "a.ply")
    with open(finished, "a", encoding="utf-8") as file:
        file.write('{"row": "cut sho')
    before = (tmp_path / "a.ply").stat().st_mtime_ns
    done = paint3d("batch", table)
    assert done.returncode == 0, done.stderr
    before_it = re.search(r"(\d+) finished before", done.stdout)
    assert before_it is not None
    assert 1 <= int(before_it[1]) < 3 + len(more)
    assert (tmp_path / "a.ply").stat().st_mtime_ns == before
    assert all((tmp_path / name).exists() for _, _, name in ROWS)


LAST = "llvmlite" if library() is None else "machine_code"  # what brings the kernels


def is_loading(process: int, library: str) -> bool:
    """Whether a process has come as far as loading a library; also where it has ended."""
    try:
        return library in Path(f"/proc/{process}/maps").read_text()
    except OSError:
        return True


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="needs /proc")
@pytest.mark.parametrize("library", ["", "_multiarray_umath", LAST])  # started, importing
def test_a_batch_is_interrupted_while_its_processes_start(write_table, library: str) -> None:
    command = [sys.executable, "-m", "paint3d", "batch", write_table(*ROWS), "--processes", "2"]
    running = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    children = Path(f"/proc/{running.pid}/task/{running.pid}/children")
    started: list[int] = []
    while len(started) < 2 and running.poll() is None:
        started = [int(number) for number in children.read_text().split()]
        time.sleep(0.01)
    assert len(started) == 2  # what looks after memory, and what all others are forked from
    while not is_loading(started[1], library):
        time.sleep(0.001)
    os.killpg(running.pid, signal.SIGINT)  # as a terminal does: all of them get it
    _, errors = running.communicate(timeout=300)
    assert running.returncode == 130
    *before, last = errors.splitlines()
    assert last == "paint3d: error: interrupted"
    assert all(line.startswith("painting rows") for line in before)  # how far a slow machine came


@pytest.mark.parametrize(
    ("number", "status", "told"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "asked to end")],
)
def test_an_end_while_a_process_is_asked_for_is_told_by_one_alone(
    write_table, number: int, status: int, told: str
) -> None:
    """It gets half of what it is to do, which is not told; another thread may hear of the end."""
    command = [sys.executable, "-c", INTERRUPTED, str(int(number)), "batch", write_table(*ROWS)]
    done = subprocess.run(
        [*command, "--processes", "1"], capture_output=True, text=True, check=False, timeout=300,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "2"},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    assert done.stderr == f"paint3d: error: {told}\n"
    assert done.returncode == status


def test_a_cluster_paints_the_same_bytes(paint3d, write_table, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    done = paint3d("batch", write_table(*ROWS))
    assert done.returncode == 0, done.stderr
    here = bytes_of(tmp_path)
    script = tmp_path / "cluster.py"
    script.write_text(CLUSTER)
    cluster = subprocess.Popen(
        [sys.executable, "-W", "ignore", script],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    try:
        assert cluster.stdout is not None
        address = cluster.stdout.readline().strip()
        for _, _, name in ROWS:
            (tmp_path / name).unlink()
        rows = [*ROWS, ("", "no such ink", "x.ply")]
        done = paint3d("batch", write_table(*rows), "--scheduler", address)
        assert done.returncode == 2
        assert "1 of 4 rows failed, in line 5" in done.stderr
        assert bytes_of(tmp_path) == here
    finally:
        cluster.communicate("", timeout=300)


def test_a_process_that_dies_costs_its_row_only(tmp_path: Path) -> None:
    code = """
import os, signal, sys
import paint3d.cli.batches.rows as rows
import paint3d.cli.batches.workers as workers

def run(row):
    if row.output == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    if row.output == "exit":
        os._exit(3)
    return rows.Outcome(row.line, "", 0.0, "")

workers.run_row = run
if __name__ == "__main__":
    table = [rows.Row(k, o, ()) for k, o in enumerate(("a", "kill", "b", "exit", "c"))]
    for outcome in sorted(workers.run_here(table, 2)):
        print(outcome.line, outcome.message)
"""
    script = tmp_path / "die.py"
    script.write_text(code)
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert lines == [
        "0 ", "1 its process died (SIGKILL)", "2 ", "3 its process died (exit status 3)", "4 "
    ]  # fmt: skip


def test_a_quiet_batch_tells_no_notes(tmp_path: Path) -> None:
    code = """
import logging
import paint3d.cli.write
from paint3d.cli.main import main

def run(options):
    logging.getLogger("paint3d.calligraphy").warning("it blots")
    options.out.write_text("painted")

paint3d.cli.write.run = run
if __name__ == "__main__":
    main(["batch", "t.csv", "--processes", "1"])
    main(["batch", "t.csv", "--processes", "1", "--again", "--quiet"])
"""
    (tmp_path / "noted.py").write_text(code)
    (tmp_path / "t.csv").write_text("text,object,output\n永,bowl,a.ply\n", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "noted.py"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stderr == "paint3d: note: line 2, a.ply: it blots\n"
