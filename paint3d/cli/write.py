"""Write a text or a drawing on an object: plan the strokes, replay them, export the painting."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.films import add_film_options, film_of
from paint3d.cli.options import (
    DIPS,
    add_dip_option,
    add_force_option,
    add_on_and_out,
    add_painting_options,
    add_quiet_option,
    check_output_file,
    check_overwriting,
    load_object,
    own_file,
    parse_count,
    parse_length_mm,
    parse_place,
)
from paint3d.cli.progress import ProgressBar
from paint3d.cli.replay import DEFAULT_INK, PaintOptions, paint, prepare, read_for_ink
from paint3d.cli.results import (
    Painting,
    check_is_plane,
    export_outlines,
    result_suffixes,
    timed,
    write_report,
    write_result,
)
from paint3d.cli.sources import (
    STROKES_FILE,
    TRIALS,
    add_source_options,
    check_source,
    open_page,
    save_written,
)
from paint3d.core.machine import usable_cores
from paint3d.errors import InputError

if TYPE_CHECKING:
    from paint3d.calligraphy.photo.flat_page import FlatPage
    from paint3d.calligraphy.writing import Pen, Written
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["HELP", "add_arguments", "add_task_options", "carry_out", "check_files", "run"]

HELP = "write a text or a drawing: plan the strokes, then replay them"

_RECORDINGS = (".jsonl", ".csv", ".jsonl.gz", ".csv.gz")
_TECHNIQUES = ("zhongfeng", "cefeng", "pianfeng")
_SIDES = ("outside", "inside", "top", "bottom")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "text",
        metavar="TEXT",
        nargs="?",
        help="what to write; a line break starts a new column or row",
    )
    add_source_options(parser)
    add_task_options(parser)
    add_dip_option(parser, f"{DIPS}; of drawings always")


def add_task_options(parser: argparse.ArgumentParser) -> None:
    """Add where strokes are written, with what, and which files are made: what `carry_out` asks."""
    add_on_and_out(parser)
    _add_writing_options(parser)
    add_painting_options(parser, brush="one that suits the size", ink=DEFAULT_INK)
    parser.add_argument(
        "--recording", metavar="FILE", type=Path, help="also write the way of the hand"
    )
    parser.add_argument(
        "--report", metavar="FILE", type=Path, help="write frames, counts and times as JSON"
    )
    parser.add_argument(
        "--processes",
        metavar="N",
        type=parse_count,
        help="how many to plan in at once (default: one a core); the result is the same",
    )
    add_film_options(parser)
    add_force_option(parser)
    add_quiet_option(parser)


def _add_writing_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--glyphs",
        metavar="DIR",
        type=Path,
        help="a folder of hanzi-writer-data (default: the lines of the package kanjivg)",
    )
    parser.add_argument(
        "--size",
        metavar="MM",
        type=parse_length_mm,
        default=20.0,
        help="side of a character's square, longer side of a drawing (default: 20)",
    )
    parser.add_argument(
        "--layout",
        choices=("columns", "row"),
        help="columns from right to left, or rows (default: columns; with --font as its script is "
        "written)",
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--at", metavar="U,V", type=parse_place, help="where the text's middle goes (see the guide)"
    )
    where.add_argument(
        "--around", action="store_true", help="spread the text evenly around the body"
    )
    parser.add_argument(
        "--side", choices=_SIDES, help="from where the object is looked at (default: by its shape)"
    )
    parser.add_argument(
        "--azimuth",
        choices=("commanded", "dragged"),
        default="commanded",
        help="who turns the tuft: the handle, or the surface that drags it (default: commanded)",
    )
    parser.add_argument(
        "--technique", choices=_TECHNIQUES, help="how the tip is held (default: as the shape asks)"
    )


def run(options: argparse.Namespace) -> None:
    """Check, plan, paint, write: nothing is written unless all of it went well.

    Raises
    ------
    Paint3DError
        If anything handed in cannot be used, or a result cannot be written.
    """
    check_files(options, (options.font, options.svg, options.strokes))
    PaintOptions.of(options).check()
    check_source(options)
    dips = options.dip or (DIPS if options.text is not None else "always")
    write, source = _prepared(options)
    trials = 0
    if options.strokes is not None:
        trials = TRIALS if options.trials is None else options.trials
    carry_out(options, write, source, dips, trials)


def carry_out(
    options: argparse.Namespace,
    write: Callable[..., Written],
    source: dict[str, str],
    dips: str | int,
    trials: int = 0,
    sheet: FlatPage | None = None,
) -> tuple[Written, Painting]:
    """Plan, paint and write the files that the options of `add_task_options` name.

    Parameters
    ----------
    options : Namespace
    write : callable
        `write_page` or `write_text`, with what is written.
    source : dict
        What the recording's header says of it besides.
    dips : {"auto", "always"} or int
        See `dipped_as`.
    trials : int
        How often it is painted beforehand, where strokes say how dry or how pale they are.
    sheet : FlatPage, optional
        The page where it was photographed.

    Raises
    ------
    Paint3DError
        If it does not fit, cannot be planned, or a file cannot be written.
    """
    from paint3d.calligraphy.dips import dipped_as
    from paint3d.calligraphy.flying_white import inked_as

    wanted = PaintOptions.of(options)
    film, pen = film_of(options), _pen(options)
    as_outlines = options.out.name.lower().endswith(".svg")
    if as_outlines and options.azimuth != "commanded":
        raise InputError("--azimuth dragged turns the tuft; outlines (.svg) need a commanded one")
    seconds: dict[str, float] = {}
    mesh, surface = _made_ready(options, wanted, pen, seconds, flat=as_outlines)
    with timed(seconds, "plan"):
        written = _plan(options, mesh, write, pen, source)
        written = replace(written, recording=dipped_as(written.recording, pen.brush, dips))
    if trials:
        written = _rehearsed(written, mesh, wanted, seconds, trials, sheet)
    recording = inked_as(written.recording, written.dryness, written.strength, surface.material)
    watch = None if film is None else film.of_recording(surface, recording, wanted.spread_s)
    painting = paint(surface, recording, wanted, seconds, watch)
    header, written = recording.header, replace(written, recording=recording)
    told = {key: header[key] for key in ("glyphs", "source") if key in header}
    painting.counts.update(told, characters=written.characters)
    with timed(painting.seconds, "export"):
        if as_outlines:
            with ProgressBar("writing", enabled=not options.quiet):
                export_outlines(mesh, recording, pen.brush, options.ink or DEFAULT_INK, options.out)
        else:
            write_result(painting, options.out, quiet=options.quiet)
        if watch is not None:
            watch.write()
    _write_beside(options, written, painting)
    return written, painting


def _made_ready(
    options: argparse.Namespace,
    wanted: PaintOptions,
    pen: Pen,
    seconds: dict[str, float],
    *,
    flat: bool,
) -> tuple[TriangleMesh, PaintedSurface]:
    """The object and its surface; what the brush's bent shapes are looked up in is made beside."""
    from paint3d.brush.bending import build_tuft
    from paint3d.core.ahead import beside

    with beside(partial(build_tuft, pen.brush)):
        mesh = load_object(options)
        if flat:
            check_is_plane(mesh)
        return mesh, prepare(mesh, wanted, seconds)


def _rehearsed(
    written: Written,
    mesh: TriangleMesh,
    wanted: PaintOptions,
    seconds: dict[str, float],
    trials: int,
    sheet: FlatPage | None,
) -> Written:
    """A plan, corrected by what comes of it on fresh surfaces."""
    from paint3d.calligraphy.flying_white import inked_as
    from paint3d.calligraphy.photo.rehearsal import rehearsed
    from paint3d.colour.materials import load_material

    material = load_material(wanted.material)

    def on_trial(plan: Written) -> PaintedSurface:
        surface = prepare(mesh, wanted, seconds)
        recording = inked_as(plan.recording, plan.dryness, plan.strength, material)
        return paint(surface, recording, wanted, seconds).surface

    return rehearsed(written, on_trial, material, trials, sheet)


def _write_beside(options: argparse.Namespace, written: Written, painting: Painting) -> None:
    """Write the recording, the strokes and the report where they are asked for; tell the result."""
    from paint3d.recording.recording import save_recording

    if options.recording is not None:
        with ProgressBar("writing", enabled=not options.quiet) as progress:
            save_recording(written.recording, options.recording, progress)
    if options.save_strokes is not None:
        save_written(written, options.save_strokes)
    if options.report is not None:
        write_report(options.report, painting)
    if not options.quiet:
        sys.stdout.write(f"{options.out}: {painting.summarize()}\n")


def check_files(
    options: argparse.Namespace,
    sources: Iterable[str | Path | None],
    also: Iterable[Path | None] = (),
) -> None:
    """Refuse files that could not be written at the end, or that are read from.

    `sources` are read, and `also` written, besides what the options of `add_task_options` name.

    Raises
    ------
    ExportError
        Which one, and why.
    """
    check_output_file(options.out, (*result_suffixes(), ".svg"))
    for file, suffixes in (
        (options.report, (".json",)),
        (options.recording, _RECORDINGS),
        (options.save_strokes, STROKES_FILE),
    ):
        if file is not None:
            check_output_file(file, suffixes)
    check_overwriting(
        (options.out, options.film, options.report, options.recording, options.save_strokes, *also),
        (
            options.on,
            *read_for_ink(options),
            own_file(options.brush),
            own_file(options.material),
            *sources,
        ),
        force=options.force,
    )


def _prepared(options: argparse.Namespace) -> tuple[Callable[..., Written], dict[str, str]]:
    """What plans a page, or a text in characters that are known, and where these are from."""
    from paint3d.calligraphy.glyph_sources import missing_glyphs, open_glyphs
    from paint3d.calligraphy.writing import write_page, write_text

    with ProgressBar("looking", enabled=not options.quiet):
        page = open_page(options)
    if page is not None:
        return partial(write_page, text=page), {}
    source = open_glyphs(options.glyphs)
    if missing_glyphs(source, options.text):
        from paint3d.calligraphy.fonts.fallback import with_fallback

        source = with_fallback(source, options.text)
    return partial(write_text, text=options.text, source=source), {"glyphs": source.name}


def _plan(
    options: argparse.Namespace,
    mesh: TriangleMesh,
    write: Callable[..., Written],
    pen: Pen,
    source: dict[str, str],
) -> Written:
    """Plan what is written, telling the progress."""
    from paint3d.calligraphy.layout import Layout
    from paint3d.colour.inks import describe_ink, load_ink

    layout = Layout(options.layout or "columns", options.at, options.around, options.side)
    header: dict[str, object] = {
        "ink": describe_ink(load_ink(options.ink or DEFAULT_INK)),
        **source,
    }
    if options.tip is not None:
        header |= {"tip": describe_ink(load_ink(options.tip)), "reach": options.reach}
    with ProgressBar("planning", enabled=not options.quiet) as bar:

        def tell(character: str, fraction: float) -> None:
            if not options.quiet:
                bar.note(f"planned {character}")
            bar(fraction)

        return write(
            mesh,
            pen=pen,
            layout=layout,
            header=header,
            processes=options.processes or usable_cores(),
            progress=tell,
        )


def _pen(options: argparse.Namespace) -> Pen:
    from paint3d.brush.presets import choose_brush, load_brush
    from paint3d.calligraphy.planning import PlanSettings
    from paint3d.calligraphy.writing import Pen

    brush = load_brush(options.brush or choose_brush(options.size))
    settings = PlanSettings(technique=options.technique, azimuth=options.azimuth)
    return Pen(brush, options.size, settings)
