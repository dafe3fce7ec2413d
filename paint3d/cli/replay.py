"""Paint a recording on an object and write the result, in the format of the file's suffix.

`demo` and `write` paint in the same way.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from paint3d.cli.films import add_film_options, film_of
from paint3d.cli.options import (
    TIP_REACH,
    add_force_option,
    add_on_and_out,
    add_painting_options,
    add_quiet_option,
    check_output_file,
    check_overwriting,
    load_object,
    own_file,
    parse_length_mm,
    parse_place,
)
from paint3d.cli.progress import ProgressBar, say_if_compiling
from paint3d.cli.results import (
    Painting,
    refuse_untouched,
    result_suffixes,
    timed,
    write_report,
    write_result,
)
from paint3d.cli.sources import lay_on
from paint3d.errors import InputError, RecordingError

if TYPE_CHECKING:
    from paint3d.brush.spec import BrushSpec
    from paint3d.cli.films import Watch
    from paint3d.colour.pigments import Pigment
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.painter.flat_input import LaidPad
    from paint3d.painter.painter import Painter
    from paint3d.recording.recording import Recording
    from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "DEFAULT_INK",
    "HELP",
    "PaintOptions",
    "add_arguments",
    "paint",
    "prepare",
    "read_for_ink",
    "run",
]

HELP = "paint a recording"
_DEFAULT_BRUSH = "full"
DEFAULT_INK = "pine soot"


@dataclass(frozen=True)
class PaintOptions:
    """What the user asked for; brush and ink None stand for the recording's own.

    With `spread_s` the ink spreads and dries while it is painted, and so many seconds more. `hairs`
    says of how many single hairs the tuft is; 0: solid, None: as the brush has it. `tip` is the ink
    that the tip is dipped in afterwards, over `reach` of the tuft's length.
    """

    brush: str | None = None
    ink: str | None = None
    material: str = "porcelain"
    resolution_mm: float = 0.4
    quiet: bool = False
    spread_s: float | None = None
    hairs: int | None = None
    tip: str | None = None
    reach: float = TIP_REACH
    pickup: float = 0.0

    @classmethod
    def of(cls, options: argparse.Namespace) -> PaintOptions:
        """What the options of `add_painting_options` say."""
        return cls(
            brush=options.brush,
            ink=options.ink,
            material=options.material or cls.material,
            resolution_mm=options.resolution or cls.resolution_mm,
            quiet=options.quiet,
            spread_s=options.spread,
            hairs=options.hairs,
            tip=options.tip,
            reach=options.reach,
            pickup=options.pickup,
        )

    def check(self) -> None:
        """Look up everything that is named, before any work.

        Raises
        ------
        InputError
            If the brush, the ink or the material is not known or cannot be read.
        """
        from paint3d.brush.presets import load_brush
        from paint3d.colour.inks import load_ink
        from paint3d.colour.materials import load_material

        load_material(self.material)
        if self.brush is not None:
            load_brush(self.brush)
        for ink in (self.ink, self.tip):
            if ink is not None:
                load_ink(ink)


def read_for_ink(options: argparse.Namespace) -> list[str]:
    """The files that the inks of `add_ink_options` are read from."""
    from paint3d.colour.ink_text import tables_in

    return [*tables_in(options.ink), *tables_in(options.tip)]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("recording", metavar="RECORDING", type=Path, help="a recording")
    add_on_and_out(parser, needs_out=False)
    add_painting_options(parser)
    parser.set_defaults(material=None, resolution=None)  # a whole painting has its own
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
        "--painted-on",
        metavar="MESH",
        help="what a whole painting was painted on, with its normals, where --on is the same "
        "object meshed anew: strokes lie where they lay (default: the built-in object that it "
        "names)",
    )
    parser.add_argument(
        "--report", metavar="FILE", type=Path, help="write counts and times as JSON"
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
    from paint3d.recording.recording import load_recording
    from paint3d.recording.score import is_score

    if options.out is None and options.film is None:
        raise InputError("nothing is to be written; expected --out FILE, --film FILE or both")
    if options.out is not None:
        check_output_file(options.out, result_suffixes())
    film = film_of(options)
    if options.report is not None:
        check_output_file(options.report, (".json",))
    check_overwriting(
        (options.out, options.film, options.report),
        (
            options.recording,
            options.on,
            *read_for_ink(options),
            own_file(options.brush),
            own_file(options.material),
        ),
        force=options.force,
    )
    if is_score(options.recording):
        from paint3d.cli.scores import replay_score

        replay_score(options, film)
        return
    _refuse_painted_on(options)
    wanted = PaintOptions.of(options)
    wanted.check()
    with ProgressBar("reading", enabled=not options.quiet) as progress:
        recording = load_recording(options.recording, progress=progress)
    mesh = load_object(options)
    seconds: dict[str, float] = {}
    surface = prepare(mesh, wanted, seconds)
    with ProgressBar("laying", enabled=not options.quiet):
        laid = lay_on(mesh, recording, options.at, options.size)
    watch = None if film is None else film.of_recording(surface, laid, wanted.spread_s)
    painting = paint(surface, laid, wanted, seconds, watch)
    with ProgressBar("looking", enabled=not options.quiet):
        refuse_untouched(painting, mesh, str(options.recording))
    with timed(painting.seconds, "export"):
        if options.out is not None:
            write_result(painting, options.out, quiet=options.quiet)
        if watch is not None:
            watch.write()
    if options.report is not None:
        write_report(options.report, painting)
    if not options.quiet:
        sys.stdout.write(f"{options.out or options.film}: {painting.summarize()}\n")


def _refuse_painted_on(options: argparse.Namespace) -> None:
    if options.painted_on is not None:
        raise InputError(
            f"--painted-on is given, and {options.recording} is no whole painting; expected one of "
            "version 2, which says what it was painted on"
        )


def prepare(mesh: TriangleMesh, wanted: PaintOptions, seconds: dict[str, float]) -> PaintedSurface:
    """Make a mesh ready for painting, adding the time that takes to `seconds`.

    Raises
    ------
    InputError
        If the material is not known, or the mesh cannot be painted on at this resolution.
    """
    from paint3d.colour.materials import load_material
    from paint3d.surface.painted_surface import PaintedSurface

    material = load_material(wanted.material)
    say_if_compiling(quiet=wanted.quiet)
    with timed(seconds, "prepare"), ProgressBar("preparing", enabled=not wanted.quiet):
        return PaintedSurface(mesh, resolution=wanted.resolution_mm, material=material)


def paint(
    surface: PaintedSurface,
    recording: Recording | LaidPad,
    wanted: PaintOptions,
    seconds: dict[str, float],
    watch: Watch | None = None,
) -> Painting:
    """Paint a recording on a surface of `prepare`, showing a progress bar on a terminal.

    A `watch` sees how it grows, for a film.

    Raises
    ------
    InputError
        If the brush, the ink or a sample cannot be used.
    """
    from paint3d.painter.painter import Painter
    from paint3d.painter.recorded_tools import recorded_amount

    brush = _brush(recording, wanted.brush)
    ink = _ink(recording, wanted.ink)
    with timed(seconds, "prepare"), ProgressBar("preparing", enabled=not wanted.quiet):
        azimuth = recording.header["azimuth"]
        painter = Painter(
            surface,
            brush,
            ink,
            azimuth,
            wanted.pickup,
            wanted.hairs,
            recorded_amount(recording.header),
        )
        tip, reach = _tip(recording, wanted)
        if tip is not None:
            painter.dip(tip, reach)
    is_shown, rest_s = not wanted.quiet, wanted.spread_s
    with timed(seconds, "paint"):
        with ProgressBar("painting", enabled=is_shown) as progress:
            told = progress if watch is None else watch.over(recording, rest_s, progress)
            rate = None if watch is None else 1.0 / watch.step_s
            painter.replay(recording, told, rate, rest_s is not None)
        if rest_s is not None:
            with ProgressBar("spreading", enabled=is_shown) as progress:
                told = progress if watch is None else watch.resting(progress)
                painter.rest(int(recording.time_ns[-1]), rest_s, told)
        counts = painter.report()
    settings = _in_hand(painter, brush, ink, tip)
    return Painting(surface, counts, seconds, (recording,), settings)


def _in_hand(
    painter: Painter, brush: BrushSpec, ink: dict[Pigment, float], tip: dict[Pigment, float] | None
) -> dict[str, Any]:
    """What a session says of the hand: its brush as it was painted with, and what it holds."""
    from paint3d.brush.spec import DipAmount

    own = None if painter.hairs is None else painter.hairs.spec
    held = replace(brush, bristles=own)
    settings: dict[str, Any] = {
        "brush": asdict(held), "ink": painter.ink.name, "azimuth": painter.azimuth
    }  # fmt: skip
    last = ink if tip is None else tip
    if tip is not None or len(ink) > 1:
        settings["dipped"] = {pigment.name: parts for pigment, parts in last.items()}
    if tip is not None:  # or the next dip would be a whole one in the tip's ink
        from paint3d.app.model.stroke_log import weights_of

        settings["dips"] = [[weights_of(dipped), share] for dipped, share in painter.dips]
    if painter.hairs is not None:
        from paint3d.app.model.persistence.brush_words import hair_words

        settings["hairs"] = hair_words(painter)
    if painter.amount != DipAmount():
        settings["amount"] = painter.amount.words()
    return settings


def _brush(recording: Recording | LaidPad, wished: str | None) -> BrushSpec:
    """The brush that the user wants, or the recording's own, which names no file here."""
    from paint3d.brush.presets import load_brush
    from paint3d.painter.recorded_tools import recorded_brush

    if wished:
        return load_brush(wished)
    try:
        return recorded_brush(recording.header) or load_brush(_DEFAULT_BRUSH)
    except RecordingError as cause:
        raise RecordingError(f"{cause}, or --brush") from None


def _ink(recording: Recording | LaidPad, wished: str | None) -> dict[Pigment, float]:
    """The ink that the user wants, or the recording's own."""
    from paint3d.colour.inks import load_ink
    from paint3d.painter.recorded_tools import recorded_ink

    if wished:
        return load_ink(wished)
    try:
        return recorded_ink(recording.header) or load_ink(DEFAULT_INK)
    except RecordingError as cause:
        raise RecordingError(f"{cause}, or --ink") from None


def _tip(
    recording: Recording | LaidPad, wanted: PaintOptions
) -> tuple[dict[Pigment, float] | None, float]:
    """What the tip is dipped in afterwards, and how far: as the user wants, or the recording."""
    from paint3d.colour.inks import load_ink
    from paint3d.painter.recorded_tools import recorded_tip

    if wanted.tip is not None:
        return load_ink(wanted.tip), wanted.reach
    try:
        own = None if wanted.ink is not None else recorded_tip(recording.header)
    except RecordingError as cause:
        raise RecordingError(f"{cause}, or --ink") from None
    return own or (None, wanted.reach)
