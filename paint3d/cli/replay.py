"""Paint a recording on an object and write the result, in the format of the file's suffix."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from paint3d.cli.objects import load_object
from paint3d.cli.options import (
    add_force_option,
    add_on_and_out,
    add_painting_options,
    add_quiet_option,
    check_output_file,
    check_overwriting,
    own_table,
    parse_length_mm,
    parse_place,
    parse_seconds,
)
from paint3d.cli.pads import lay_on
from paint3d.cli.painting import PaintOptions, paint, prepare, timed, write_report
from paint3d.cli.progress import ProgressBar
from paint3d.cli.results import result_suffixes, write_result
from paint3d.cli.untouched import refuse_untouched

__all__ = ["HELP", "add_arguments", "run"]

HELP = "paint a recording"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("recording", metavar="RECORDING", type=Path, help="a recording")
    add_on_and_out(parser)
    add_painting_options(parser)
    parser.add_argument(
        "--at",
        metavar="U,V",
        type=parse_place,
        help="where on the object to lay a pad's recording (default: 0.5,0.5)",
    )
    parser.add_argument(
        "--size",
        metavar="MM",
        type=parse_length_mm,
        help="how wide to lay a pad's recording (default: as it was drawn)",
    )
    parser.add_argument(
        "--spread",
        metavar="S",
        type=parse_seconds,
        help="let the ink spread and dry while it is painted, and S seconds more",
    )
    parser.add_argument(
        "--report", metavar="FILE", type=Path, help="write counts and times as JSON"
    )
    add_force_option(parser)
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> None:
    """Check, read, paint, write: nothing is written unless all of it went well.

    Raises
    ------
    Paint3DError
        If anything handed in cannot be used, or the result cannot be written.
    """
    from paint3d.recording.recording import load_recording

    check_output_file(options.out, result_suffixes())
    if options.report is not None:
        check_output_file(options.report, (".json",))
    check_overwriting(
        (options.out, options.report),
        (options.recording, options.on, own_table(options.ink)),
        force=options.force,
    )
    wanted = PaintOptions(
        brush=options.brush,
        ink=options.ink,
        material=options.material,
        resolution_mm=options.resolution,
        hairs=options.hairs,
        quiet=options.quiet,
        spread_s=options.spread,
    )
    wanted.check()
    with ProgressBar("reading", enabled=not options.quiet) as progress:
        recording = load_recording(options.recording, progress=progress)
    mesh = load_object(options)
    seconds: dict[str, float] = {}
    surface = prepare(mesh, wanted, seconds)
    with ProgressBar("laying", enabled=not options.quiet):
        laid = lay_on(mesh, recording, options.at, options.size)
    painting = paint(surface, laid, wanted, seconds)
    with ProgressBar("looking", enabled=not options.quiet):
        refuse_untouched(painting, mesh, str(options.recording))
    with timed(painting.seconds, "export"):
        write_result(painting, options.out, quiet=options.quiet)
    if options.report is not None:
        write_report(options.report, painting)
    if not options.quiet:
        sys.stdout.write(f"{options.out}: {painting.summarize()}\n")
