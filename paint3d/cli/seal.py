"""Press a seal with vermilion paste: onto an object, or onto a painting that is finished."""

from __future__ import annotations

import argparse
import math
import sys
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.options import (
    PLACE,
    add_at_option,
    add_force_option,
    add_quiet_option,
    add_seed_option,
    add_side_option,
    check_input_file,
    check_output_file,
    check_overwriting,
    group_of,
    parse_length_mm,
    parse_number,
)
from paint3d.cli.painting import (
    Before,
    PaintingOptions,
    add_out_option,
    fraction_over,
    new_document,
    open_document,
    take_layer,
)
from paint3d.cli.progress import ProgressBar
from paint3d.cli.results import add_layer_option, result_suffixes, say_if_over
from paint3d.cli.sources import WHAT, add_drawing_options, parse_face
from paint3d.errors import InputError, MeshError

if TYPE_CHECKING:
    from paint3d.app.model.document import Document

__all__ = ["EXAMPLES", "add_arguments", "add_seal_options", "check_seal", "press", "run"]

EXAMPLES = """
paint3d seal 浩然 --on poem.p3d --at 0.3,0.3 --size 13 --layer seal --out sealed.p3d
paint3d seal --svg logo.svg --on vase --size 20 --out vase.glb
"""

_STYLES = ("zhuwen", "baiwen")
_SHAPES = ("square", "upright", "level")
_RESOLUTION_MM = 0.1
_MOST_PLACES = 12


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "text",
        metavar="TEXT",
        nargs="?",
        help="1 to 4 characters, in columns from the right; with --font any text",
    )
    PaintingOptions.add_to(
        parser, "on", "material", "resolution", "unit", "up",
        unsaid={"resolution": f"{_RESOLUTION_MM:g}"},
    )  # fmt: skip
    add_seal_options(parser)
    add_layer_option(parser)
    add_out_option(parser)
    add_force_option(parser)
    add_quiet_option(parser)


def add_seal_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `press`: the seal's design, and its position."""
    add_drawing_options(group_of(parser, WHAT), "cut a drawing instead of a text")
    _add_stone_options(group_of(parser, WHAT))
    _add_place_options(group_of(parser, PLACE))


def _add_stone_options(parser: argparse._ActionsContainer) -> None:
    add = parser.add_argument
    add(
        "--style",
        choices=_STYLES,
        default=_STYLES[0],
        help="zhuwen: red lines in a frame; baiwen: white lines on red (default: zhuwen)",
    )
    add(
        "--shape",
        choices=_SHAPES,
        default=_SHAPES[0],
        help="of the stone: square; upright, its characters one above the other; or level, in a "
        "row from the right (default: square)",
    )
    add(
        "--size",
        metavar="MM",
        type=parse_length_mm,
        default=16.0,
        help="longer side of the stone (default: 16)",
    )
    add("--font", metavar="FONT", help="cut the shapes of a font (default: lines of one width)")
    add("--font-number", metavar="N", type=parse_face, help="which face of a .ttc, from 0")
    add(
        "--glyphs",
        metavar="DIR",
        type=Path,
        help="a folder of hanzi-writer-data (default: the lines of the package kanjivg)",
    )
    add("--ink", metavar="INK", help="of the paste, as --ink of write (default: cinnabar)")
    add(
        "--coats",
        metavar="N",
        type=lambda text: parse_number(text, "a thickness", "above 0 to 10", lambda n: 0 < n <= 10),
        help="thickness of the paste (default: 1.3)",
    )
    add(
        "--pad",
        metavar="MM",
        type=lambda text: parse_number(text, "a pad", "above 0 to 100", lambda n: 0 < n <= 100),
        help="how far the pad gives way: what falls farther away is not touched (default: 3)",
    )
    add(
        "--wear",
        metavar="SHARE",
        type=lambda text: parse_number(text, "a wear", "0 to 3", lambda n: 0 <= n <= 3),
        help="how worn the stone is: 0 as it was cut, up to 3 (default: 1)",
    )
    add_seed_option(parser, "other spots stay bare, and other chips")


def _add_place_options(parser: argparse._ActionsContainer) -> None:
    add_at_option(parser, "its")
    add_side_option(parser)
    parser.add_argument(
        "--rotate",
        metavar="DEG",
        type=lambda text: parse_number(text, "an angle", "-360 to 360", lambda n: abs(n) <= 360),
        default=0.0,
        help="turn it anticlockwise (default: 0)",
    )


def run(options: argparse.Namespace) -> None:
    """Check, cut, press, write.

    Raises
    ------
    Paint3DError
        If anything handed in cannot be used, or the result cannot be written.
    """
    wanted = PaintingOptions.of(options, resolution=_RESOLUTION_MM)
    check_seal(options)
    check_output_file(options.out, result_suffixes())
    wanted.check_object()
    check_input_file(options.svg, "a drawing (.svg)")
    check_overwriting((options.out,), (options.on, options.font, options.svg), force=options.force)
    from paint3d.files.project.session import is_session_path

    if is_session_path(options.on):
        document = open_document(wanted, options)
    else:
        document = new_document(wanted)
    take_layer(document, options.layer)
    before = Before.of(document)
    summary = press(document, options)
    say_if_over(fraction_over(document, before))
    with ProgressBar("writing", enabled=not options.quiet) as progress:
        document.export(options.out, progress=progress)
    if not options.quiet:
        sys.stdout.write(f"{options.out}: {summary}\n")


def check_seal(options: argparse.Namespace) -> None:
    """Refuse options that do not go together, before any work.

    Raises
    ------
    InputError
        Which ones, and what was expected.
    """
    if (options.text is None) == (options.svg is None):
        got = "nothing to cut" if options.text is None else "a text and --svg"
        raise InputError("got {got}; expected one of TEXT and --svg FILE", got=got)
    if options.ids is not None and options.svg is None:
        raise InputError("--ids is given without a drawing; expected --svg FILE")
    for name in ("font", "glyphs"):
        if getattr(options, name) is not None and options.text is None:
            raise InputError("--{name} is given without a text; expected TEXT", name=name)
    if options.font is not None and options.glyphs is not None:
        raise InputError("--font and --glyphs are given; expected one of them")
    if options.font_number is not None and options.font is None:
        raise InputError("--font-number is given without a font; expected --font FONT")


def press(document: Document, options: argparse.Namespace) -> str:
    """Cut a seal and press it at the given position, or at the first one that has room.

    Returns
    -------
    str
        A summary of the seal.

    Raises
    ------
    Paint3DError
        If it cannot be cut, or there is no place for it.
    """
    from paint3d.calligraphy.layout import frames_for
    from paint3d.calligraphy.seal.stone import cut_seal
    from paint3d.colour.inks import load_ink

    paste = None if options.ink is None else load_ink(options.ink)
    seal = cut_seal(
        options.text,
        options.svg,
        options.style,
        options.size,
        shape=options.shape,
        ids=options.ids or (),
        font=options.font,
        font_number=options.font_number or 0,
        glyphs=options.glyphs,
    )
    given = {"coats": options.coats, "pad_mm": options.pad, "wear": options.wear,
             "seed": options.seed, "ink": paste}  # fmt: skip
    given = {name: value for name, value in given.items() if value is not None}
    rings = [ring.tolist() for ring in seal.rings]
    angle, fault = math.radians(options.rotate), None
    with ProgressBar("pressing", enabled=not options.quiet):
        closest = document.surface.closest_points
        frames = frames_for(closest, options.at, options.side)
        for frame in islice(frames, _MOST_PLACES):
            up = math.cos(angle) * frame.y_axis - math.sin(angle) * frame.x_axis
            try:
                touched = document.press_seal(rings, frame.origin.tolist(), up.tolist(), **given)
                break
            except (MeshError, InputError) as cause:
                fault = fault or cause
        else:
            name = document.surface.source.name
            raise fault or MeshError(
                "{name}: there is no place for a seal; expected a surface",
                name=name,
            )
    return (
        f"{seal.text}, {seal.style}, {seal.width_mm:.1f} x {seal.height_mm:.1f} mm, "
        f"{100.0 * touched:.0f} % touched"
    )
