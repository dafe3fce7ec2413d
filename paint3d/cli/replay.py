"""Paint a recording on an object, and write the result in the format of the file's suffix.

A recording says which brush and ink it was painted with; options say otherwise. A pad's recording
is laid on the object with --at and --size. With a painting (.p3d) as --on, it goes on with that.
"""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.films import add_film_options, film_of
from paint3d.cli.options import (
    FILES,
    PLACE,
    add_force_option,
    add_quiet_option,
    add_report_option,
    check_input_file,
    check_output_file,
    check_overwriting,
    group_of,
    parse_length_mm,
    parse_place,
)
from paint3d.cli.painting import (
    PaintingOptions,
    add_out_option,
    check_poses,
    load_object,
    open_document,
    paint,
    paint_onto,
    prepare,
    take_layer,
)
from paint3d.cli.progress import ProgressBar, say_if_compiling
from paint3d.cli.results import (
    PaintingResult,
    add_layer_option,
    finish,
    refuse_untouched,
    result_suffixes,
    timed,
)
from paint3d.cli.sources import lay_on
from paint3d.errors import InputError, RecordingError

if TYPE_CHECKING:
    from paint3d.app.model.document import Document
    from paint3d.app.model.score.playing import PlaybackStep
    from paint3d.cli.films import FilmWanted, Watch
    from paint3d.errors import Message
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.recording.recording import Recording
    from paint3d.recording.score import Score

__all__ = ["EXAMPLES", "add_arguments", "run"]

EXAMPLES = """
paint3d replay strokes.jsonl.gz --on bowl --out bowl.glb
paint3d replay strokes.inkml --on jug.obj --at 0.5,0.4 --size 60 --ink cinnabar --out jug.ply
"""

_LOG = logging.getLogger("paint3d")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("recording", metavar="RECORDING", type=Path, help="a recording")
    PaintingOptions.add_to(parser)
    place = group_of(parser, PLACE)
    place.add_argument(
        "--at",
        metavar="U,V",
        type=parse_place,
        help="where on the object to lay a pad's recording (default: 0.5,0.5), or one that was "
        "made on another object (default: where it was)",
    )
    place.add_argument(
        "--size",
        metavar="MM",
        type=parse_length_mm,
        help="how wide to lay it (default: as it was drawn)",
    )
    place.add_argument(
        "--painted-on",
        metavar="MESH",
        help="what it was painted on (default: the built-in object that it names): a whole "
        "painting's strokes lie where they lay, with the normals of this file, where --on is the "
        "same object meshed anew",
    )
    add_layer_option(parser)
    add_out_option(parser, required=False)
    add_report_option(parser)
    group_of(parser, FILES).add_argument(
        "--stroke-table",
        metavar="FILE.csv",
        type=Path,
        help="write a table of the strokes: times, length, force, ink that each left",
    )
    add_film_options(parser)
    add_force_option(parser)
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> None:
    """Check, read, paint, write: nothing is written unless all of it went well.

    Raises
    ------
    Paint3DError
        If anything handed in cannot be used, or the result cannot be written.
    """
    if options.out is None and options.film is None:
        raise InputError("nothing is to be written; expected --out FILE, --film FILE or both")
    wanted = PaintingOptions.of(options)
    if options.out is not None:
        check_output_file(options.out, result_suffixes())
    film = film_of(options)
    if options.report is not None:
        check_output_file(options.report, (".json",))
    if options.stroke_table is not None:
        check_output_file(options.stroke_table, (".csv",))
    check_overwriting(
        (options.out, options.film, options.report, options.stroke_table),
        (options.recording, *wanted.files()),
        force=options.force,
    )
    check_input_file(options.recording, "a recording")
    wanted.check_object()
    from paint3d.device.recorded import MODEL
    from paint3d.files.project.session import is_session_path
    from paint3d.painter.pose_check import log_warnings
    from paint3d.painter.stroke_table import StrokeTable
    from paint3d.recording.recording import Recording, load_recording
    from paint3d.recording.score import is_score

    if options.stroke_table is not None and (
        is_score(options.recording) or is_session_path(wanted.on)
    ):
        raise InputError(
            "--stroke-table is of a recording on an object; {file} is a painting that has its "
            "history",
            file=options.recording if is_score(options.recording) else wanted.on,
        )
    if is_score(options.recording):
        _replay_score(options, film)
        return
    if options.painted_on is not None and options.at is None:
        raise InputError(
            "--painted-on is given, and {recording} is no whole painting; expected one of version "
            "2, or --at U,V, where its strokes are laid",
            recording=options.recording,
        )
    wanted.check()
    with ProgressBar("reading", enabled=not options.quiet) as progress:
        recording = load_recording(options.recording, progress=progress)
    if recording.header["model"] != MODEL:
        _LOG.warning(
            "%s was recorded with version %d of brush and ink; this program paints with version "
            "%d, so its marks differ",
            options.recording, recording.header["model"], MODEL,
        )  # fmt: skip
    seconds: dict[str, float] = {}
    document = open_document(wanted, options) if is_session_path(wanted.on) else None
    if document is None:
        mesh = load_object(wanted)
        surface = prepare(mesh, wanted, seconds)
    else:
        surface = document.surface
        mesh = surface.source
    take_layer(document or surface, options.layer)
    with ProgressBar("laying", enabled=not options.quiet):
        laid = lay_on(mesh, _relate_to_object(recording, mesh, options), options.at, options.size)
    warnings: tuple[Message | None, ...] = ()
    if isinstance(laid, Recording) and not recording.is_pad:
        warnings = check_poses(laid, surface, wanted.brush, str(options.recording))
    watch = None if film is None else film.of_recording(surface, laid, wanted.spread)
    table = None if options.stroke_table is None else StrokeTable()
    if document is None:
        painting = paint(surface, laid, wanted, seconds, watch, table)
    else:
        painting = paint_onto(document, laid, wanted, seconds, watch)
    with ProgressBar("looking", enabled=not options.quiet):
        refuse_untouched(painting, laid, mesh, str(options.recording))
    if document is not None:  # else the painter has logged them
        log_warnings(warnings)
    finish(painting, options, watch)
    if table is not None:
        table.write(options.stroke_table)
    if not options.quiet:
        sys.stdout.write(f"{options.out or options.film}: {painting.summarize()}\n")


def _relate_to_object(
    recording: Recording, mesh: TriangleMesh, options: argparse.Namespace
) -> Recording:
    """Return the recording for this object: with --at, one in the world becomes a pad's.

    Warns of one that was made on another object and is not laid anew.
    """
    made_on = recording.header.get("object")
    if recording.is_pad or not isinstance(made_on, str):
        return recording
    if options.at is None:
        if made_on != mesh.name:
            _LOG.warning(
                "%s was recorded on %s: its strokes lie where they lay there; --at U,V lays them "
                "on %s",
                options.recording, made_on, mesh.name,
            )  # fmt: skip
        return recording
    from paint3d.files.load import is_built_in, load_mesh
    from paint3d.mesh.bvh import ClosestPoints
    from paint3d.painter.flat_input import lift_off

    if options.painted_on is None and not is_built_in(made_on):
        raise InputError(
            "{recording} was recorded on {made_on}; expected --painted-on MESH, that object's "
            "file, for it to be laid elsewhere",
            recording=options.recording,
            made_on=made_on,
        )
    return lift_off(recording, ClosestPoints(load_mesh(options.painted_on or made_on)))


# ---- Whole paintings -----------------------------------------------------------------------------
# A recording of version 2, with brushes, inks, places and time of its own.


_OWN = ("brush", "ink", "tip", "reach", "pickup", "hairs", "at", "size", "spread", "layer")


def _replay_score(options: argparse.Namespace, film: FilmWanted | None = None) -> None:
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
    finish(painting, options, watch)
    if not options.quiet:
        sys.stdout.write(f"{options.out or options.film}: {painting.summarize()}\n")


def _paint(
    score: Score, options: argparse.Namespace, film: FilmWanted | None
) -> tuple[Document, PaintingResult, Watch | None]:
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
    return document, PaintingResult(document.surface, counts, seconds, document=document), watch


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
