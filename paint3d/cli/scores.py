"""A recording of version 2, a whole painting, painted by `paint3d replay`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.first_run import say_if_compiling
from paint3d.cli.objects import load_object
from paint3d.cli.progress import ProgressBar
from paint3d.cli.results import Painting, timed, write_report, write_result
from paint3d.errors import InputError, RecordingError

if TYPE_CHECKING:
    from paint3d.app.model.document import Document
    from paint3d.recording.score import Score

__all__ = ["replay_score"]

_OWN = ("brush", "ink", "tip", "pickup", "hairs", "at", "size", "spread")  # what a score says
_UNSAID = {"pickup": 0.0}  # options that are not None where they are not given


def replay_score(options: argparse.Namespace) -> None:
    """Paint a whole painting, and write it.

    Raises
    ------
    Paint3DError
        If anything handed in cannot be used, or the result cannot be written.
    """
    from paint3d.recording.score import load_score

    for name in _OWN:
        if getattr(options, name) != _UNSAID.get(name):
            raise InputError(
                f"--{name} is given, and {options.recording} is a whole painting with brushes, "
                f"inks, places and time of its own; expected no --{name}"
            )
    with ProgressBar("reading", enabled=not options.quiet) as progress:
        score = load_score(options.recording, progress)
    document, painting = _painted(score, options)
    if not painting.counts["footprints"]:
        raise RecordingError(
            f"{options.recording}: no stroke of it touches {document.surface.source.name}; "
            f"expected the object that it was painted on ({score.header.get('object', 'not said')})"
        )
    with timed(painting.seconds, "export"):
        _write(document, painting, options.out, quiet=options.quiet)
    if options.report is not None:
        write_report(options.report, painting)
    if not options.quiet:
        sys.stdout.write(f"{options.out}: {painting.summarize()}\n")


def _painted(score: Score, options: argparse.Namespace) -> tuple[Document, Painting]:
    from paint3d.app.model.score.playing import begun, play
    from paint3d.colour.materials import load_material

    material = None if options.material is None else load_material(options.material)
    mesh = load_object(options)
    seconds: dict[str, float] = {}
    say_if_compiling(quiet=options.quiet)
    with timed(seconds, "prepare"), ProgressBar("preparing", enabled=not options.quiet):
        document = begun(score, mesh, options.resolution, material)
    with timed(seconds, "paint"), ProgressBar("painting", enabled=not options.quiet) as progress:
        for step in play(document, score):
            progress(step.share)
        if document.in_stroke:
            document.end_stroke()
        counts = document.painter.report()
    return document, Painting(document.surface, counts, seconds)


def _write(document: Document, painting: Painting, file: Path, *, quiet: bool) -> None:
    from paint3d.files.project.session import is_session_path

    if not is_session_path(file):
        write_result(painting, file, quiet=quiet)
        return
    with ProgressBar("writing", enabled=not quiet) as progress:
        document.save_copy(file, progress)
