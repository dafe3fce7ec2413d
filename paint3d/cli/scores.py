"""A recording of version 2, a whole painting, painted by `paint3d replay`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from paint3d.cli.painting import PaintingOptions, load_object
from paint3d.cli.progress import ProgressBar, say_if_compiling
from paint3d.cli.results import Painting, timed, write_report, write_result
from paint3d.errors import InputError, RecordingError

if TYPE_CHECKING:
    from paint3d.app.model.document import Document
    from paint3d.app.model.score.playing import PlaybackStep
    from paint3d.cli.films import FilmWanted, Watch
    from paint3d.recording.score import Score

__all__ = ["replay_score"]

_OWN = ("brush", "ink", "tip", "reach", "pickup", "hairs", "at", "size", "spread", "layer")


def replay_score(options: argparse.Namespace, film: FilmWanted | None = None) -> None:
    """Paint a whole painting, and write it, and a film of how it came about if one is wanted.

    Raises
    ------
    Paint3DError
        If anything handed in cannot be used, or the result cannot be written.
    """
    from paint3d.files.project.session import is_session_path
    from paint3d.recording.score import load_score

    for name in _OWN:
        if getattr(options, name) is not None:
            raise InputError(
                "--{name} is given, and {recording} is a whole painting with brushes, inks, places "
                "and time of its own; expected no --{name}",
                name=name,
                recording=options.recording,
            )
    with ProgressBar("reading", enabled=not options.quiet) as progress:
        score = load_score(options.recording, progress)
    if is_session_path(options.on):
        raise InputError(
            "{recording} is a whole painting, which begins on a bare object; expected --on MESH, "
            "not {on}",
            recording=options.recording,
            on=options.on,
        )
    document, painting, watch = _paint(score, options, film)
    if not painting.counts["footprints"]:
        raise RecordingError(
            "{recording}: no stroke of it touches {source}; expected the object that it was "
            "painted on ({object})",
            recording=options.recording,
            source=document.surface.source.name,
            object=score.header.get("object", "not said"),
        )
    with timed(painting.seconds, "export"):
        if options.out is not None:
            write_result(painting, options.out, quiet=options.quiet)
        if watch is not None:
            watch.write()
    if options.report is not None:
        write_report(options.report, painting)
    if not options.quiet:
        sys.stdout.write(f"{options.out or options.film}: {painting.summarize()}\n")


def _paint(
    score: Score, options: argparse.Namespace, film: FilmWanted | None
) -> tuple[Document, Painting, Watch | None]:
    from paint3d.app.model.score.playing import begun, play
    from paint3d.app.model.score.stepping import seconds_of
    from paint3d.colour.materials import load_material
    from paint3d.files.load import load_mesh

    material = None if options.material is None else load_material(options.material)
    mesh = load_object(PaintingOptions.of(options))
    seconds: dict[str, float] = {}
    say_if_compiling(quiet=options.quiet)
    with timed(seconds, "prepare"), ProgressBar("preparing", enabled=not options.quiet):
        original = None
        if options.painted_on is not None:
            original = load_mesh(options.painted_on, options.unit, up=options.up)
        document = begun(score, mesh, options.resolution, material, original)
    watch = None if film is None else film.begun(document.surface, seconds_of(score))
    with timed(seconds, "paint"), ProgressBar("painting", enabled=not options.quiet) as progress:
        for step in play(document, score) if watch is None else _watched(document, score, watch):
            progress(step.fraction)
        if document.in_stroke:
            document.end_stroke()
        counts = document.painter.report()
    return document, Painting(document.surface, counts, seconds, document=document), watch


def _watched(document: Document, score: Score, watch: Watch) -> Iterator[PlaybackStep]:
    """Play a score sample by sample for a film."""
    from paint3d.app.model.score.playing import play
    from paint3d.app.model.score.stepping import in_pieces, pass_step
    from paint3d.recording.recording import HandTime

    clock = HandTime()
    for step in play(document, in_pieces(score)):
        pass_step(clock, step)
        watch.at(clock.seconds)
        yield step
