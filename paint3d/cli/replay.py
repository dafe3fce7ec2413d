"""Paint a recording on an object and write the result, in the format of the file's suffix.

`demo` and `write` paint in the same way.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.first_run import say_if_compiling
from paint3d.cli.objects import load_object
from paint3d.cli.options import (
    TIP_REACH,
    add_force_option,
    add_on_and_out,
    add_painting_options,
    add_quiet_option,
    check_output_file,
    check_overwriting,
    own_brush,
    parse_length_mm,
    parse_place,
)
from paint3d.cli.pads import lay_on
from paint3d.cli.progress import ProgressBar
from paint3d.cli.results import Painting, result_suffixes, timed, write_report, write_result
from paint3d.cli.untouched import refuse_untouched
from paint3d.errors import BrushError, InputError, PigmentError, RecordingError, UnknownNameError

if TYPE_CHECKING:
    from paint3d.brush.dip_amount import DipAmount
    from paint3d.brush.spec import BrushSpec
    from paint3d.colour.pigment import Pigment
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.painter.flat_input import LaidPad
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
    add_on_and_out(parser)
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
    from paint3d.recording.score import is_score

    check_output_file(options.out, result_suffixes())
    if options.report is not None:
        check_output_file(options.report, (".json",))
    check_overwriting(
        (options.out, options.report),
        (options.recording, options.on, *read_for_ink(options), own_brush(options.brush)),
        force=options.force,
    )
    if is_score(options.recording):
        from paint3d.cli.scores import replay_score

        replay_score(options)
        return
    wanted = PaintOptions.of(options)
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
) -> Painting:
    """Paint a recording on a surface of `prepare`, showing a progress bar on a terminal.

    Raises
    ------
    InputError
        If the brush, the ink or a sample cannot be used.
    """
    from paint3d.painter.painter import Painter

    brush = _brush(recording, wanted.brush)
    ink = _ink(recording, wanted.ink)
    with timed(seconds, "prepare"), ProgressBar("preparing", enabled=not wanted.quiet):
        azimuth = recording.header["azimuth"]
        painter = Painter(
            surface, brush, ink, azimuth, wanted.pickup, wanted.hairs, _dip_amount(recording)
        )
        tip, reach = _tip(recording, wanted)
        if tip is not None:
            painter.dip(tip, reach)
    with (
        timed(seconds, "paint"),
        ProgressBar("painting", enabled=not wanted.quiet) as progress,
    ):
        rest_s = wanted.spread_s
        painter.replay(recording, progress, wet=rest_s is not None, rest_s=rest_s or 0.0)
        counts = painter.report()
    settings = {"brush": asdict(brush), "ink": painter.ink.name, "azimuth": azimuth}
    last = ink if tip is None else tip
    if tip is not None or len(ink) > 1:
        settings["dipped"] = {pigment.name: parts for pigment, parts in last.items()}
    if painter.hairs is not None:
        settings["hairs"] = asdict(painter.hairs.spec)
    return Painting(surface, counts, seconds, (recording,), settings)


def _dip_amount(recording: Recording | LaidPad) -> DipAmount:
    """How much ink the recording's dips take up."""
    from paint3d.brush.dip_amount import DipAmount

    try:
        return DipAmount.of(recording.header.get("dip", {}))
    except InputError as cause:
        raise RecordingError(f"the header: {cause}") from None


def _brush(recording: Recording | LaidPad, wished: str | None) -> BrushSpec:
    """The brush that the user wants, or the recording's own, which names no file here."""
    from paint3d.brush.presets import load_brush

    if wished:
        return load_brush(wished)
    try:
        return load_brush(_named_in(recording, "brush", _DEFAULT_BRUSH), own_files=False)
    except (BrushError, UnknownNameError) as cause:
        raise RecordingError(f"the header: {cause}, or --brush") from None


def _ink(recording: Recording | LaidPad, wished: str | None) -> dict[Pigment, float]:
    """The ink that the user wants, or the recording's own."""
    from paint3d.colour.inks import load_ink

    if wished:
        return load_ink(wished)
    parts = recording.header.get("parts")
    if isinstance(parts, dict) and len(parts) > 1:  # "ink" is the most of them
        return _stirred(parts)
    return _own_ink(_named_in(recording, "ink", DEFAULT_INK))


def _stirred(parts: dict[str, float]) -> dict[Pigment, float]:
    """A recording's pigments by their parts; they name no file of this machine."""
    from paint3d.colour.pigments import load_pigment

    try:
        return {load_pigment(str(name), own_tables=False): part for name, part in parts.items()}
    except PigmentError as cause:
        raise RecordingError(f"the header: {cause}, or --ink") from None


def _tip(
    recording: Recording | LaidPad, wanted: PaintOptions
) -> tuple[dict[Pigment, float] | None, float]:
    """What the tip is dipped in afterwards, and how far: as the user wants, or the recording."""
    from paint3d.colour.inks import load_ink
    from paint3d.core.arrays import as_number

    if wanted.tip is not None:
        return load_ink(wanted.tip), wanted.reach
    if wanted.ink is not None or "tip" not in recording.header:
        return None, wanted.reach
    reach = recording.header.get("reach", TIP_REACH)
    ink = _own_ink(_named_in(recording, "tip", DEFAULT_INK))
    return ink, as_number(reach, "the header's reach", 0.0, 1.0, RecordingError)


def _own_ink(name: str) -> dict[Pigment, float]:
    """An ink of a recording's header, which names no file of this machine."""
    from paint3d.colour.inks import load_ink

    try:
        return load_ink(name, own_tables=False)
    except PigmentError as cause:
        raise RecordingError(f"the header: {cause}, or --ink") from None


def _named_in(recording: Recording | LaidPad, what: str, default: str) -> str:
    """The recording's own brush or ink, or the default where it names none."""
    name = recording.header.get(what)
    if name is None:
        return default
    if not isinstance(name, str):
        raise RecordingError(f"the header's {what} is {name!r:.60}; expected a name")
    return name
