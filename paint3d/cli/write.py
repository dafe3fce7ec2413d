"""Write a text or a drawing on an object: plan the strokes, replay them, export the painting.

With a painting (.p3d) as --on, it goes on with that; --layer keeps what is written by itself.
"""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from paint3d.cli.films import add_film_options, film_of
from paint3d.cli.options import (
    BRUSH,
    DIPS,
    FILES,
    PLACE,
    add_at_option,
    add_dip_option,
    add_force_option,
    add_quiet_option,
    add_report_option,
    add_seed_option,
    add_side_option,
    check_input_file,
    check_output_file,
    check_overwriting,
    group_of,
    parse_count,
    parse_gap,
    parse_hand_speed,
    parse_length_mm,
    parse_turn,
    parse_variation,
)
from paint3d.cli.painting import (
    WRITING_INK,
    PaintingOptions,
    add_out_option,
    load_object,
    new_document,
    open_document,
    paint,
    paint_onto,
    prepare,
    take_layer,
)
from paint3d.cli.progress import ProgressBar
from paint3d.cli.results import (
    PaintingResult,
    add_layer_option,
    check_is_plane,
    export_outlines,
    finish,
    result_suffixes,
    timed,
    write_report,
)
from paint3d.cli.sources import (
    STROKES_FILE,
    TRIALS,
    WHAT,
    add_source_options,
    check_source,
    open_page,
    save_written,
)
from paint3d.core.machine import usable_cores
from paint3d.errors import InputError
from paint3d.mesh.sheets import is_sheet

if TYPE_CHECKING:
    from paint3d.app.model.document import Document
    from paint3d.calligraphy.photo.flat_page import FlatPage
    from paint3d.calligraphy.seal.stone import Seal
    from paint3d.calligraphy.writing import WritingSettings, Written
    from paint3d.core.arrays import AnyArray
    from paint3d.recording.recording import Recording
    from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "EXAMPLES",
    "add_arguments",
    "add_task_options",
    "carry_out",
    "check_files",
    "run",
    "say_if_hidden",
    "settings_of",
    "settle_size",
    "sign",
    "signature_of",
]

EXAMPLES = """
paint3d write 永和九年 --on vase --size 60 --out vase.glb
paint3d write Hello --font "DejaVu Sans" --on mug.glb --at 0.5,0.5 --size 25 --out hello.glb
paint3d write --svg logo.svg --on hello.p3d --size 40 --out both.p3d
"""

_RECORDINGS = (".jsonl", ".csv", ".jsonl.gz", ".csv.gz")
_TECHNIQUES = ("zhongfeng", "cefeng", "pianfeng")
_USUAL_MM, _GAP = 20.0, 0.1
_FINE, _FINER = 40.0, 75.0  # vertices to a character's side: fewer show ragged strokes; enough
_SEEN = 1.0 / 3.0  # of the way round a body: what is not too oblique from one side
_LEVEL = 0.9  # height of a unit normal from which on a surface lies flat
_LOG = logging.getLogger("paint3d")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "text",
        metavar="TEXT",
        nargs="?",
        help="what to write; a line break starts a new column or row",
    )
    add_source_options(parser)
    what = group_of(parser, WHAT)
    what.add_argument(
        "--sign", metavar="TEXT", help="a signature, in smaller characters beside the text"
    )
    what.add_argument(
        "--seal",
        metavar="TEXT",
        help="1 to 4 characters of a seal, pressed below the signature; without one, left of "
        "the text's end",
    )
    add_task_options(parser)
    add_dip_option(parser, f"{DIPS}; of drawings always")
    brush = group_of(parser, BRUSH)
    brush.add_argument(
        "--variation",
        type=parse_variation,
        default=1.0,
        metavar="V",
        help="how much strokes differ as a hand's do: 0 as the copybook has them, at most 3 "
        "(default: 1)",
    )
    add_seed_option(brush, "how strokes vary")
    brush.add_argument(
        "--hand-speed",
        type=parse_hand_speed,
        default=1.0,
        metavar="X",
        help="how many times as fast as usual the hand writes, 1 to 4: where a brush is fast it "
        "leaves streaks bare (default: 1)",
    )


def add_task_options(parser: argparse.ArgumentParser, **unsaid: str) -> None:
    """Add the options of `carry_out`: position, brush and ink, and the files to write.

    `unsaid` are the help's texts of defaults, where a command differs.
    """
    unsaid = {"brush": "one that suits the size", "ink": WRITING_INK, **unsaid}
    PaintingOptions.add_to(parser, unsaid=unsaid)
    _add_writing_options(parser)
    add_layer_option(parser)
    add_out_option(parser)
    files = group_of(parser, FILES)
    files.add_argument(
        "--recording", metavar="FILE", type=Path, help="also write the way of the hand"
    )
    add_report_option(parser)
    files.add_argument(
        "--processes",
        metavar="N",
        type=parse_count,
        help="how many to plan in at once (default: one a core); the result is the same",
    )
    add_film_options(parser)
    add_force_option(parser)
    add_quiet_option(parser)


def _add_writing_options(parser: argparse.ArgumentParser) -> None:
    place, brush = group_of(parser, PLACE), group_of(parser, BRUSH)
    place.add_argument(
        "--glyphs",
        metavar="DIR",
        type=Path,
        help="a folder of hanzi-writer-data (default: the lines of the package kanjivg)",
    )
    place.add_argument(
        "--size",
        metavar="MM",
        type=parse_length_mm,
        help="side of a character's square, longer side of a drawing (default: a text fills a "
        f"sheet, in as many columns as let it be largest; else {_USUAL_MM:g})",
    )
    place.add_argument(
        "--layout",
        choices=("columns", "row"),
        help="columns from right to left, or rows (default: columns; rows for a text with letters "
        "of an alphabet, with --font for one that begins with them)",
    )
    add_at_option(place, "the text's")
    place.add_argument(
        "--around",
        action="store_true",
        help="spread the text evenly around the body, in columns or rows as --layout says; "
        "beside a handle it takes the free arc. --at says where its middle goes",
    )
    add_side_option(place)
    place.add_argument(
        "--rotate", metavar="DEG", type=parse_turn, default=0.0,
        help="turn the text to the left, degrees (default: 0); not with --around, which lies level",
    )  # fmt: skip
    for name, what, usual in (
        ("gap", "columns, or rows,", _GAP), ("between", "the characters of one", 0.0),
    ):  # fmt: skip
        place.add_argument(
            f"--{name}", metavar="SHARE", type=parse_gap,
            help=f"distance between {what} in parts of the size (default: {usual:g}; on a sheet "
            "what lets the text fill it)",
        )  # fmt: skip
    brush.add_argument(
        "--azimuth",
        choices=("commanded", "dragged"),
        default="commanded",
        help="who turns the tuft: the handle, or the surface that drags it (default: commanded)",
    )
    brush.add_argument(
        "--technique", choices=_TECHNIQUES, help="how the tip is held (default: as the shape asks)"
    )


def run(options: argparse.Namespace) -> None:
    """Check, plan, paint, write: nothing is written unless all of it went well.

    Raises
    ------
    Paint3DError
        If anything handed in cannot be used, or a result cannot be written.
    """
    check_source(options)
    wanted = PaintingOptions.of(options)
    check_files(options, wanted, (options.font, options.svg, options.strokes))
    wanted.check()
    settle_size(options, wanted.on)
    dips = options.dip or (DIPS if options.text is not None else "always")
    write, source = planner(options)
    trials = 0
    if options.strokes is not None:
        trials = TRIALS if options.rehearsals is None else options.rehearsals
    carry_out(options, wanted, write, source, dips, trials)


def carry_out(
    options: argparse.Namespace,
    wanted: PaintingOptions,
    write: Callable[..., Written],
    source: dict[str, str],
    dips: str | int,
    trials: int = 0,
    sheet: FlatPage | None = None,
) -> tuple[Written, PaintingResult]:
    """Plan, paint and write the files that the options of `add_task_options` name.

    Parameters
    ----------
    options : Namespace
    wanted : PaintingOptions
    write : callable
        `write_page` or `write_text`, with its text or page bound.
    source : dict
        Added to the recording's header.
    dips : {"auto", "always"} or int
        See `apply_dip_option`.
    trials : int
        How often it is painted beforehand, where strokes say how dry or how pale they are.
    sheet : FlatPage, optional
        The page where it was photographed.

    Raises
    ------
    Paint3DError
        If it does not fit, cannot be planned, or a file cannot be written.
    """
    from paint3d.files.project.session import is_session_path
    from paint3d.recording.recording import save_recording

    film = film_of(options)
    is_signed = bool(getattr(options, "sign", None) or getattr(options, "seal", None))
    as_outlines = options.out.name.lower().endswith(".svg")
    if is_signed and (film is not None or as_outlines):
        raise InputError(
            "--sign and --seal are painted after the text; expected them without a film or "
            "outlines (.svg)"
        )
    if as_outlines and options.azimuth != "commanded":
        raise InputError("--azimuth dragged turns the tuft; outlines (.svg) need a commanded one")
    settings = settings_of(options)
    signature = signature_of(options) if is_signed else None
    seconds: dict[str, float] = {}
    document = open_document(wanted, options) if is_session_path(wanted.on) else None
    if document is None and signature is not None:
        document = new_document(wanted)
    if document is None:
        surface = _prepare_object(wanted, settings, seconds, flat=as_outlines)
    else:
        surface = document.surface
        if as_outlines:
            check_is_plane(surface.source)
    take_layer(document or surface, options.layer)
    written = plan(options, surface, write, settings, source, dips, seconds)
    if options.text is not None and not as_outlines:
        _say_if_coarse(settings.em_mm, surface)
        if not options.around:
            say_if_hidden(written, surface)
    if trials:
        written = _rehearse(written, surface, wanted, seconds, trials, sheet)
    recording = inked(written, surface)
    watch = None if film is None else film.of_recording(surface, recording, wanted.spread)
    if document is None:
        painting = paint(surface, recording, wanted, seconds, watch)
    else:
        painting = paint_onto(document, recording, wanted, seconds, watch)
        if signature is not None:
            sign(document, signature, wanted, written, seconds)
    header, written = recording.header, replace(written, recording=recording)
    source_words = {key: header[key] for key in ("glyphs", "source") if key in header}
    painting.counts.update(source_words, characters=written.characters)
    if as_outlines:
        with timed(painting.seconds, "export"):
            with ProgressBar("writing", enabled=not options.quiet):
                ink = options.ink or WRITING_INK
                export_outlines(surface.source, recording, settings.brush, ink, options.out)
            if watch is not None:
                watch.write()
        if options.report is not None:
            write_report(options.report, painting)
    else:
        finish(painting, options, watch)
    if options.recording is not None:
        with ProgressBar("writing", enabled=not options.quiet) as progress:
            save_recording(written.recording, options.recording, progress)
    if options.save_strokes is not None:
        save_written(written, options.save_strokes)
    if not options.quiet:
        sys.stdout.write(f"{options.out}: {painting.summarize()}\n")
    return written, painting


def settle_size(options: argparse.Namespace, on: str) -> None:
    """Give a text without a size the one that fills its sheet, or the usual one.

    Its columns, distances and position are then set, too.
    """
    if options.size is not None:
        return
    options.size = _USUAL_MM
    is_free = options.at is None and not options.around and options.rotate == 0.0
    is_free = is_free and options.side in (None, "top", "front")
    text = getattr(options, "text", None)
    if text is None or not is_free or not is_sheet(on):
        return
    from paint3d.calligraphy.composition import compose, place_on
    from paint3d.mesh.sheets import parse_sheet

    sheet = parse_sheet(on)
    signature = None  # of so many characters; 0 for a seal alone
    if options.sign or options.seal:
        signature = len("".join((options.sign or "").split()))
    composition = compose(
        sheet, text, options.layout or "columns",
        signature=signature, gap=options.gap, between=options.between,
    )  # fmt: skip
    if composition is None:
        return
    options.text = "\n".join(composition.lines)
    options.size, options.gap, options.between = (
        composition.em_mm,
        composition.gap,
        composition.between,
    )
    if composition.point is not None:
        options.at = place_on(sheet, composition.point)
    if not options.quiet:
        n, lines = len("".join(composition.lines)), len(composition.lines)
        what = "row" if options.layout == "row" else "column"
        sys.stderr.write(
            f"{n} character{'s' if n > 1 else ''} of {composition.em_mm:.0f} mm in {lines} {what}"
            f"{'s' if lines > 1 else ''} fill{'' if n > 1 else 's'} the sheet\n"
        )


def _say_if_coarse(em_mm: float, surface: PaintedSurface) -> None:
    """Warn that fine strokes of a text come out ragged, if vertices lie too far apart for them."""
    spacing = surface.resolution
    if spacing is not None and spacing * _FINE > em_mm:
        _LOG.warning(
            "vertices %g mm apart are too coarse for characters of %g mm: thin strokes come out "
            "ragged; expected --resolution %.2g where the object is made ready",
            spacing,
            em_mm,
            em_mm / _FINER,
        )


def say_if_hidden(written: Written, surface: PaintedSurface) -> None:
    """Warn that a text goes farther round a body than is seen from one side."""
    import numpy as np

    from paint3d.mesh.placement import turns_of

    mesh = surface.source
    boxes = np.concatenate([piece.square.points.reshape(-1, 3) for piece in written.placed])
    normals = np.array([piece.square.chart.frame.normal for piece in written.placed])
    radii = boxes[:, :2] - np.asarray(mesh.body_axis)
    outwards = [piece.square.chart.frame.origin[:2] - mesh.body_axis for piece in written.placed]
    if (normals[:, :2] * np.array(outwards)).sum(axis=1).min() <= 0.0:
        return  # within a bowl, or on what is flat
    turns = np.sort(turns_of(mesh, boxes))
    span = 1.0 - float(np.diff(turns, append=turns[0] + 1.0).max())
    if span > _SEEN and np.abs(normals[:, 2]).max() < _LEVEL:
        girth = 2.0 * np.pi * float(np.linalg.norm(radii, axis=1).mean())
        _LOG.warning(
            "the text goes %.0f of %.0f mm round: from one side about %.0f are seen",
            span * girth, girth, _SEEN * girth,
        )  # fmt: skip


def inked(written: Written, surface: PaintedSurface) -> Recording:
    """Return the recording of a plan, as dry and as pale as it asks for on this surface."""
    from paint3d.calligraphy.flying_white import with_ink

    return with_ink(written.recording, written.dryness, written.strength, surface.material)


class Signature(NamedTuple):
    """A signature and a seal beside a text, read before anything is painted.

    Attributes
    ----------
    options : Namespace
        As for a text of its own; its text is empty where there is a seal alone.
    planner : tuple or None
        See `planner`.
    cut : callable or None
        Cuts the seal at a size, mm.
    """

    options: argparse.Namespace
    planner: tuple[Callable[..., Written], dict[str, str]] | None
    cut: Callable[[float], Seal] | None


def signature_of(options: argparse.Namespace) -> Signature:
    """Read the signature and cut the seal that options ask for.

    Raises
    ------
    Paint3DError
        If there is no glyph for one of their characters, or the seal cannot be cut.
    """
    own = argparse.Namespace(**vars(options))
    own.text = "".join((options.sign or "").split())
    if options.sign is not None and not own.text:
        raise InputError("--sign has no characters; expected a signature")
    own.svg = own.strokes = own.at = None
    own.around = False
    own.layout = own.layout or "columns"
    cut = None
    if options.seal:
        from paint3d.calligraphy.fonts.fallback import with_fallback
        from paint3d.calligraphy.glyph_sources import open_glyphs
        from paint3d.calligraphy.seal.stone import cut_known

        source = with_fallback(open_glyphs(options.glyphs), options.seal)
        cut = partial(cut_known, options.seal, source, "zhuwen")
        cut(_USUAL_MM)  # so that it is refused before painting
    return Signature(own, planner(own) if own.text else None, cut)


def sign(
    document: Document,
    signature: Signature,
    wanted: PaintingOptions,
    written: Written,
    seconds: dict[str, float],
) -> None:
    """Write a signature beside a text, and press a seal below it, or beside the text's end.

    Raises
    ------
    Paint3DError
        If there is no place for them.
    """
    from paint3d.calligraphy.composition import sign_beside

    own = signature.options
    mesh, order = document.surface.source, own.layout or "columns"
    beside = sign_beside(mesh, [piece.square for piece in written.placed], len(own.text), order)
    if signature.planner is not None:
        own.size, own.between = beside.em_mm, beside.between
        _say_if_coarse(own.size, document.surface)
        if not wanted.brush:
            own.brush = None
        make, source = signature.planner
        settings = settings_of(own)
        line = plan(own, document.surface, make, settings, source, DIPS, seconds, beside.point)
        paint_onto(document, inked(line, document.surface), wanted, seconds)
    if signature.cut is not None:
        rings = [ring.tolist() for ring in signature.cut(beside.seal_mm).rings]
        with ProgressBar("pressing", enabled=not own.quiet):
            document.press_seal(rings, beside.seal_point.tolist(), beside.up.tolist())


def _prepare_object(
    wanted: PaintingOptions, settings: WritingSettings, seconds: dict[str, float], *, flat: bool
) -> PaintedSurface:
    """Return the object's surface; the brush's table of bent shapes is built beside."""
    from paint3d.brush.bending import build_tuft
    from paint3d.core.ahead import beside

    with beside(partial(build_tuft, settings.brush)):
        mesh = load_object(wanted)
        if flat:
            check_is_plane(mesh)
        return prepare(mesh, wanted, seconds)


def _rehearse(
    written: Written,
    surface: PaintedSurface,
    wanted: PaintingOptions,
    seconds: dict[str, float],
    trials: int,
    sheet: FlatPage | None,
) -> Written:
    """Correct a plan by trials on fresh surfaces."""
    from paint3d.calligraphy.photo.rehearsal import rehearse
    from paint3d.surface.painted_surface import PaintedSurface

    def on_trial(plan: Written) -> PaintedSurface:
        fresh = PaintedSurface(surface.source, surface.resolution, surface.material)
        return paint(fresh, inked(plan, fresh), wanted, seconds).surface

    return rehearse(written, on_trial, surface.material, trials, sheet)


def check_files(
    options: argparse.Namespace,
    wanted: PaintingOptions,
    sources: Iterable[str | Path | None],
    also: Iterable[Path | None] = (),
) -> None:
    """Refuse output files that could not be written at the end, or that are inputs.

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
        (*wanted.files(), *sources),
        force=options.force,
    )
    wanted.check_object()
    for source in sources:
        if isinstance(source, Path):  # a font may be a name
            check_input_file(source, "a file to read")


def planner(options: argparse.Namespace) -> tuple[Callable[..., Written], dict[str, str]]:
    """Return a function that plans a page or a text in known characters, and their source."""
    from paint3d.calligraphy.glyph_sources import has_letters, missing_glyphs, open_glyphs
    from paint3d.calligraphy.writing import write_page, write_text

    with ProgressBar("looking", enabled=not options.quiet):
        page = open_page(options)
    if page is not None:
        return partial(write_page, composer=page), {}
    source = open_glyphs(options.glyphs)
    if has_letters(options.text) or missing_glyphs(source, options.text):
        from paint3d.calligraphy.fonts.fallback import set_whole, with_fallback

        page = set_whole(source, options.text, options.layout, around=options.around)
        if page is not None:
            return partial(write_page, composer=page), {}
        source = with_fallback(source, options.text)
    return partial(write_text, text=options.text, source=source), {"glyphs": source.name}


def plan(
    options: argparse.Namespace,
    surface: PaintedSurface,
    write: Callable[..., Written],
    settings: WritingSettings,
    source: dict[str, str],
    dips: str | int,
    seconds: dict[str, float],
    point: AnyArray | None = None,
) -> Written:
    """Plan a text or a page on a surface with its dips, showing progress; see `carry_out`."""
    from paint3d.calligraphy.dips import apply_dip_option
    from paint3d.calligraphy.layout import Layout
    from paint3d.colour.inks import describe_ink, load_ink

    layout = Layout(
        options.layout or "columns", options.at, options.around, options.side,
        _GAP if options.gap is None else options.gap, options.between or 0.0, turn=options.rotate,
        point=None if point is None else tuple(point.tolist()),
    )  # fmt: skip
    header: dict[str, object] = {
        "ink": describe_ink(load_ink(options.ink or WRITING_INK)),
        **source,
    }
    if options.tip is not None:
        header |= {"tip": describe_ink(load_ink(options.tip)), "reach": options.reach}
    n = len("".join((getattr(options, "text", None) or "").split()))
    label = f"planning {n} character{'s' if n > 1 else ''}" if n else "planning"
    with timed(seconds, "plan"), ProgressBar(label, enabled=not options.quiet) as bar:

        def report(character: str, fraction: float) -> None:
            if not options.quiet:
                bar.note(f"planned {character}")
            bar(fraction)

        written = write(
            surface.source,
            settings=settings,
            layout=layout,
            header=header,
            processes=options.processes or usable_cores(),
            progress=report,
        )
        dipped = apply_dip_option(written.recording, settings.brush, dips, surface.material)
        return replace(written, recording=dipped)


def settings_of(options: argparse.Namespace) -> WritingSettings:
    """Return the settings of writing: the given brush or the one that suits the size, its hold."""
    from paint3d.brush.presets import brush_for, load_brush
    from paint3d.calligraphy.path_fit import PlanSettings
    from paint3d.calligraphy.writing import WritingSettings

    brush = load_brush(options.brush) if options.brush else brush_for(options.size)
    planning = PlanSettings(technique=options.technique, azimuth=options.azimuth)
    return WritingSettings(
        brush,
        options.size,
        planning,
        variation=options.variation,
        seed=1 if options.seed is None else options.seed,
        hand_speed=options.hand_speed,
    )
