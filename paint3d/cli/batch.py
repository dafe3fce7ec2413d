"""Make one painting for each row of a table: text or recording, object, brush, ink, output."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.options import add_quiet_option
from paint3d.cli.progress import ProgressBar
from paint3d.errors import InputError

if TYPE_CHECKING:
    from paint3d.cli.batch_record import FinishedRows
    from paint3d.cli.batch_rows import Outcome, Row

__all__ = ["HELP", "add_arguments", "run"]

HELP = "one painting a row of a table"

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
        type=_parse_count,
        help="how many rows to paint at once (default: one a core); the results are the same",
    )
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="paint on the Dask cluster of this scheduler"
    )
    parser.add_argument(
        "--again", action="store_true", help="paint rows that are finished already, too"
    )
    add_quiet_option(parser)


def _parse_count(text: str) -> int:
    count = int(text) if text.isascii() and text.isdigit() else 0
    if count < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a count; expected 1 or more")
    return count


def run(options: argparse.Namespace) -> None:
    """Paint every row that is not finished; a row that fails does not stop the others.

    Raises
    ------
    InputError
        If the table cannot be used, or, at the end, if rows have failed.
    """
    from paint3d.cli.batch_record import FinishedRows
    from paint3d.cli.batch_table import read_table

    started = time.perf_counter()
    rows, refused = read_table(options.table)
    finished = FinishedRows(options.table.with_name(options.table.name + ".finished"))
    left = [row for row in rows if options.again or not finished.has(row)]
    by_line = {row.line: row for row in left}
    failed = []
    for outcome in refused:
        failed.append(outcome.line)
        _tell_failure(options.table, outcome)
    with ProgressBar("painting rows", enabled=not options.quiet) as progress:
        for done, outcome in enumerate(_outcomes(left, finished, options), 1):
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
    if failed:
        lines = ", ".join(map(str, sorted(failed)[:_SHOWN_LINES]))
        more = " ..." if len(failed) > _SHOWN_LINES else ""
        total = len(rows) + len(refused)
        raise InputError(
            f"{options.table}: {len(failed)} of {total} rows failed, in line {lines}{more}"
        )


def _outcomes(
    rows: list[Row], finished: FinishedRows, options: argparse.Namespace
) -> Iterator[Outcome]:
    from paint3d.cli.batch_order import longest_first
    from paint3d.cli.batch_workers import run_here, run_on_cluster, usable_cores

    if not rows:
        return iter(())
    if options.scheduler is not None:
        return run_on_cluster(longest_first(rows, finished), options.scheduler)
    from paint3d.cli.first_run import say_if_compiling

    say_if_compiling(quiet=options.quiet)
    processes = options.processes or usable_cores()
    return run_here(longest_first(rows, finished) if processes > 1 else rows, processes)


def _finish(row: Row, outcome: Outcome, finished: FinishedRows, *, quiet: bool) -> None:
    finished.add(row, outcome.seconds)
    if not quiet:
        sys.stdout.write(f"{row.output} ({outcome.seconds:.1f} s)\n")
        sys.stdout.flush()


def _tell_failure(table: Path, outcome: Outcome) -> None:
    sys.stderr.write(f"{table}:{outcome.line}: {outcome.message}\n")
    sys.stderr.flush()
