"""Measure the speed on this machine: tables, and the figures that should keep a bound."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.options import add_quiet_option, check_output_file
from paint3d.cli.progress import ProgressBar, say_if_compiling
from paint3d.cli.report import find_versions
from paint3d.core.atomic import write_atomically
from paint3d.errors import UnknownNameError

if TYPE_CHECKING:
    from paint3d.bench.result import Result

__all__ = ["EXAMPLES", "add_arguments", "format_result", "run"]

EXAMPLES = """
paint3d bench --list
paint3d bench replay dab --json speed.json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("names", metavar="NAME", nargs="*", help="which (default: all; see --list)")
    parser.add_argument("--list", action="store_true", help="say what can be measured")
    parser.add_argument("--json", metavar="FILE", type=Path, help="also write the results as JSON")
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> None:
    """Measure, print each table when it is there, and write the JSON at the end.

    Raises
    ------
    Paint3DError
        For a name that is not known, or a file that could not be written.
    """
    from paint3d.bench.registry import BENCHMARKS, run_benchmark

    if options.list:
        sys.stdout.writelines(f"{name:10}{about}\n" for name, (_, about) in BENCHMARKS.items())
        return
    names = options.names or list(BENCHMARKS)
    for name in names:
        if name not in BENCHMARKS:
            raise UnknownNameError("benchmark", name, BENCHMARKS)
    if options.json is not None:
        check_output_file(options.json, (".json",))
    say_if_compiling(quiet=options.quiet)
    results = {}
    for k, name in enumerate(names):
        with ProgressBar(f"measuring {name}", enabled=not options.quiet) as progress:
            progress(k / len(names))
            results[name] = run_benchmark(name)
        sys.stdout.write("\n".join([*format_result(results[name]), "", ""]))
        sys.stdout.flush()
    if options.json is not None:
        figures = {name: result.as_dict() for name, result in results.items()}
        text = json.dumps({"versions": find_versions(), "benchmarks": figures}, indent=2)
        with write_atomically(options.json) as part:
            part.write_text(text + "\n", encoding="utf-8")


def format_result(result: Result) -> list[str]:
    """Return the lines of a result: title, aligned table, bounds kept or not, notes."""
    rows = [list(result.columns), *([_cell(cell) for cell in row] for row in result.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [result.title]
    for row in rows:
        cells = (cell.rjust(width) for cell, width in zip(row, widths, strict=True))
        lines.append("  " + "  ".join(cells))
    for check in result.checks:
        verdict = "kept  " if check.is_met else "MISSED"
        sign = "<=" if check.at_most else ">="
        value = f"{check.value:.4g} (wanted {sign} {check.bound:g}) {check.unit}".rstrip()
        lines.append(f"  {verdict}  {check.name}: {value}")
    return lines + [f"  {note}" for note in result.notes]


def _cell(value: str | int | float | None) -> str:
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    return f"{value:,}" if isinstance(value, int) else value
