"""Make one painting for each row of a table: text or recording, object, brush, ink, output."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from paint3d.cli.options import add_quiet_option, parse_count
from paint3d.cli.progress import ProgressBar
from paint3d.core.machine import usable_cores
from paint3d.errors import InputError

if TYPE_CHECKING:
    from paint3d.cli.batches.record import FinishedRows
    from paint3d.cli.batches.rows import Outcome, Row

__all__ = ["EXAMPLES", "add_arguments", "run"]

EXAMPLES = """
paint3d batch orders.csv
paint3d batch orders.csv --processes 4 --again
"""

_SHOWN_LINES = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "table",
        metavar="TABLE.csv",
        type=Path,
        help="columns text or recording, object, output; brush, ink and other options by name",
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--processes",
        metavar="N",
        type=parse_count,
        help="how many rows to paint at once (default: one a core); the results are the same",
    )
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="paint on the Dask cluster of this scheduler"
    )
    where.add_argument(
        "--row",
        metavar="N",
        type=parse_count,
        help="paint the row in line N of the table only, as a job of an array does",
    )
    parser.add_argument(
        "--folder",
        metavar="DIR",
        type=Path,
        help="where files that the table names are counted from (default: the working folder)",
    )
    parser.add_argument(
        "--again", action="store_true", help="paint rows that are finished already, too"
    )
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> None:
    """Paint every row that is not finished; a row that fails does not stop the others.

    Raises
    ------
    InputError
        If the table cannot be used, or, at the end, if rows have failed.
    """
    from paint3d.cli.batches.record import FinishedRows
    from paint3d.cli.batches.table import read_table

    started = time.perf_counter()
    folder = os.path.abspath(options.folder or os.curdir)
    if not os.path.isdir(folder):
        raise InputError(f"{options.folder}: there is no such folder; expected the files' own")
    rows, refused = read_table(options.table)
    if options.row is not None:
        rows, refused = _only(options.row, rows), _only(options.row, refused)
        if not rows and not refused:
            raise InputError(f"{options.table}: there is no row in line {options.row}")
    finished = FinishedRows(options.table.with_name(options.table.name + ".finished"), folder)
    left = [row for row in rows if options.again or not finished.has(row)]
    by_line = {row.line: row for row in left}
    failed = []
    for outcome in refused:
        failed.append(outcome.line)
        _tell_failure(options.table, outcome)
    with ProgressBar("painting rows", enabled=not options.quiet) as progress:
        for done, outcome in enumerate(_outcomes(left, folder, options), 1):
            if outcome.message:
                failed.append(outcome.line)
                _tell_failure(options.table, outcome)
            else:
                _finish(by_line[outcome.line], outcome, finished, quiet=options.quiet)
            progress(done / len(left))
    if not options.quiet:
        painted = len(left) - len(failed) + len(refused)
        seconds = time.perf_counter() - started
        sys.stdout.write(
            f"{options.table}: {painted} painted in {seconds:.1f} s, {len(rows) - len(left)} "
            f"finished before, {len(failed)} failed\n"
        )
    _refuse(options.table, failed, len(rows) + len(refused))


def _only(line: int, rows: list[Any]) -> list[Any]:
    """The row of a line, or its refusal."""
    return [row for row in rows if row.line == line]


def _refuse(table: Path, failed: list[int], total: int) -> None:
    """End with an error where rows have failed."""
    if failed:
        lines = ", ".join(map(str, sorted(failed)[:_SHOWN_LINES]))
        more = " ..." if len(failed) > _SHOWN_LINES else ""
        raise InputError(f"{table}: {len(failed)} of {total} rows failed, in line {lines}{more}")


def _outcomes(rows: list[Row], folder: str, options: argparse.Namespace) -> Iterator[Outcome]:
    from paint3d.cli.batches.cluster import run_on_cluster
    from paint3d.cli.batches.rows import placed, run_row
    from paint3d.cli.batches.workers import run_here

    if not rows:
        return iter(())
    if options.folder is not None:
        rows = [placed(row, folder) for row in rows]
    if options.scheduler is not None:
        return run_on_cluster(rows, options.scheduler, folder)
    from paint3d.cli.progress import say_if_compiling

    say_if_compiling(quiet=options.quiet)
    if options.row is not None:
        return map(run_row, rows)
    processes = options.processes or usable_cores()
    return run_here(rows, processes)


def _finish(row: Row, outcome: Outcome, finished: FinishedRows, *, quiet: bool) -> None:
    finished.add(row, outcome.seconds)
    if not quiet:
        sys.stdout.write(f"{row.output} ({outcome.seconds:.1f} s)\n")
        sys.stdout.flush()


def _tell_failure(table: Path, outcome: Outcome) -> None:
    sys.stderr.write(f"{table}:{outcome.line}: {outcome.message}\n")
    sys.stderr.flush()
