"""Make one painting for each row of a table: text or recording, object, brush, ink, output.

Columns are named as the options of `paint3d write` and `paint3d replay`, without dashes. With
--group COLUMN, rows with the same cell in that column are pieces of one painting, as `paint3d
compose` takes them. What is finished is noted beside the table, so that the same command goes on
after an interruption.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from paint3d.cli.options import (
    add_quiet_option,
    add_report_option,
    check_input_file,
    check_output_file,
    check_overwriting,
    parse_count,
    parse_number,
)
from paint3d.cli.progress import ProgressBar
from paint3d.cli.report import find_versions
from paint3d.core.atomic import write_atomically
from paint3d.core.machine import usable_cores
from paint3d.errors import InputError
from paint3d.files.contents import json_text

if TYPE_CHECKING:
    from paint3d.cli.batches.rows import Outcome, Row

__all__ = ["EXAMPLES", "add_arguments", "run"]

EXAMPLES = """
paint3d batch orders.csv
paint3d batch mugs.csv --group output --processes 4
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
    parser.add_argument(
        "--group",
        metavar="COLUMN",
        help="rows with the same cell in this column are pieces of one painting: its columns are "
        "text, svg, strokes or seal, object, output, at, size and so on",
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
        "--rows",
        metavar="N[-M]",
        type=_parse_lines,
        help="paint only the rows in lines N to M of the table, here and one after the other, as "
        "a job of an array does",
    )
    parser.add_argument(
        "--retries",
        metavar="N",
        type=_parse_retries,
        default=1,
        help="how often a row is tried again whose process was killed (default: 1)",
    )
    add_report_option(parser)
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
    check_input_file(options.table, "a table (.csv)")
    if options.report is not None:
        check_output_file(options.report, (".json",))
        check_overwriting((options.report,), (options.table,), force=False)
    from paint3d.cli.batches.record import FinishedRows
    from paint3d.cli.batches.rows import without_lacking
    from paint3d.cli.batches.table import read_table

    started = time.perf_counter()
    folder = os.path.abspath(options.folder or os.curdir)
    if not os.path.isdir(folder):
        raise InputError(
            "{folder}: there is no such folder; expected the files' own",
            folder=options.folder,
        )
    rows, refused = read_table(options.table, options.group)
    if options.rows is not None:
        rows, refused = _only(options.rows, rows), _only(options.rows, refused)
        if not rows and not refused:
            first, last = options.rows[0], options.rows[-1]
            lines = f"line {first}" if first == last else f"lines {first} to {last}"
            raise InputError(
                "{table}: there is no row in {lines}",
                table=options.table,
                lines=lines,
            )
    finished = FinishedRows(options.table.with_name(options.table.name + ".finished"), folder)
    left = [row for row in rows if options.again or not finished.has(row)]
    left, lacking = without_lacking(left, folder)
    refused += lacking
    by_line = {row.line: row for row in left}
    failed, outcomes = [], list(refused)
    for outcome in refused:
        failed.append(outcome.line)
        _tell_failure(options.table, outcome)
    with ProgressBar("painting rows", enabled=not options.quiet) as progress:
        for done, outcome in enumerate(_outcomes(left, folder, options), 1):
            outcomes.append(outcome)
            if outcome.message:
                failed.append(outcome.line)
                _tell_failure(options.table, outcome)
            else:
                row = by_line[outcome.line]
                finished.add(row, outcome.seconds)
                if not options.quiet:
                    sys.stdout.write(f"{row.output} ({outcome.seconds:.1f} s)\n")
                    sys.stdout.flush()
            progress(done / len(left))
    if options.report is not None:
        _write_report(options.report, outcomes, rows)
    if not options.quiet:
        n_before = len(rows) - len(left) - len(lacking)
        sys.stdout.write(_summary(options.table, outcomes, n_before, time.perf_counter() - started))
    _refuse(options.table, failed, len(rows) + len(refused) - len(lacking))


def _parse_lines(text: str) -> range:
    """Parse lines of a table, N or N-M."""
    first, dash, last = text.partition("-")
    lines = range(parse_count(first), parse_count(last if dash else first) + 1)
    if not lines:
        raise argparse.ArgumentTypeError(f"{text!r} are no lines; expected N or N-M, such as 2-50")
    return lines


def _parse_retries(text: str) -> int:
    return int(
        parse_number(text, "a count", "0 to 9", lambda n: 0 <= n <= 9 and n == int(n)),
    )


def _only(lines: range, rows: list[Any]) -> list[Any]:
    """Return the rows of these lines, or their refusals."""
    return [row for row in rows if row.line in lines]


def _summary(table: Path, outcomes: list[Outcome], n_before: int, seconds: float) -> str:
    """Return a summary: how many were painted, in what time, the longest one."""
    painted = [outcome for outcome in outcomes if not outcome.message]
    lines = [
        f"{table}: {len(painted)} painted in {seconds:.1f} s, {n_before} finished before, "
        f"{len(outcomes) - len(painted)} failed"
    ]
    if len(painted) > 1:
        longest = max(painted, key=lambda outcome: outcome.seconds)
        mean = sum(outcome.seconds for outcome in painted) / len(painted)
        lines.append(
            f"a painting took {mean:.1f} s in the mean, the one of line {longest.line} longest: "
            f"{longest.seconds:.1f} s"
        )
    return "\n".join(lines) + "\n"


def _write_report(file: Path, outcomes: list[Outcome], rows: list[Row]) -> None:
    """Write each row's outcome as JSON, by line."""
    outputs = {row.line: row.output for row in rows}
    entries = [
        {"line": one.line, "output": outputs.get(one.line), "seconds": round(one.seconds, 3),
         "failure": one.message or None}
        for one in sorted(outcomes)
    ]  # fmt: skip
    text = json_text({"versions": find_versions(), "rows": entries}, indent=2, allow_nan=False)
    with write_atomically(file) as part:
        part.write_text(text + "\n", encoding="utf-8")


def _refuse(table: Path, failed: list[int], total: int) -> None:
    """Raise an error if rows have failed."""
    if failed:
        lines = ", ".join(map(str, sorted(failed)[:_SHOWN_LINES]))
        more = " ..." if len(failed) > _SHOWN_LINES else ""
        raise InputError(
            "{table}: {n} of {total} rows failed, in line {lines}{more}",
            table=table,
            n=len(failed),
            total=total,
            lines=lines,
            more=more,
        )


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
    if options.rows is not None:
        return map(run_row, rows)
    processes = options.processes or usable_cores()
    return run_here(rows, processes, options.retries, quiet=options.quiet)


def _tell_failure(table: Path, outcome: Outcome) -> None:
    sys.stderr.write(f"{table}:{outcome.line}: {outcome.message}\n")
    sys.stderr.flush()
