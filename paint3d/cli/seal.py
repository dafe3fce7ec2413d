"""Press a seal with vermilion paste: onto an object, or onto a painting that is finished."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.options import (
    MATERIALS,
    UNITS,
    add_force_option,
    add_on_and_out,
    add_quiet_option,
    add_surface_options,
    add_up_option,
    check_output_file,
    check_overwriting,
    load_object,
    parse_length_mm,
    parse_number,
    parse_place,
)
from paint3d.cli.progress import ProgressBar
from paint3d.cli.results import result_suffixes
from paint3d.cli.sources import add_drawing_options, parse_face
from paint3d.errors import InputError, MeshError, Paint3DError

if TYPE_CHECKING:
    from paint3d.app.model.document import Document
    from paint3d.calligraphy.seal.stone import Seal
    from paint3d.colour.pigments import Pigment
    from paint3d.mesh.chart import SurfaceFrame
    from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["HELP", "add_arguments", "run"]

HELP = "press a seal, of text or a drawing"

_STYLES = ("zhuwen", "baiwen")
_SIDES = ("outside", "inside", "top", "bottom")
_RESOLUTION_MM = 0.1
_MOST_PLACES = 12
_MOST_SEED = 1_000_000
_COARSE = 2.5  # vertices across a line below which a note says that it is coarse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "text",
        metavar="TEXT",
        nargs="?",
        help="1 to 4 characters, in columns from the right; with --font any text",
    )
    add_drawing_options(parser, "cut a drawing instead of a text")
    add_on_and_out(parser)
    _add_stone_options(parser)
    _add_place_options(parser)
    add_surface_options(parser)
    parser.set_defaults(material=None, resolution=None)  # a painting has its own
    parser.add_argument(
        "--unit", choices=UNITS, help="length of one unit in a mesh file (default: as it says)"
    )
    add_up_option(parser)
    add_force_option(parser)
    add_quiet_option(parser)


def _add_stone_options(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add(
        "--style",
        choices=_STYLES,
        default=_STYLES[0],
        help="zhuwen: red lines in a frame; baiwen: white lines on red (default: zhuwen)",
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
    add(
        "--seed",
        metavar="N",
        type=_parse_seed,
        help="another one leaves other spots bare and other chips (default: 1)",
    )


def _parse_seed(text: str) -> int:
    return int(
        parse_number(
            text, "a seed", f"a whole number, 0 to {_MOST_SEED:,}",
            lambda n: 0 <= n <= _MOST_SEED and n == int(n),
        )
    )  # fmt: skip


def _add_place_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--at", metavar="U,V", type=parse_place, help="where its middle goes (see the guide)"
    )
    parser.add_argument(
        "--side", choices=_SIDES, help="from where the object is looked at (default: by its shape)"
    )
    parser.add_argument(
        "--turn",
        metavar="DEG",
        type=lambda text: parse_number(text, "an angle", "-360 to 360", lambda n: abs(n) <= 360),
        default=0.0,
        help="turn it anticlockwise (default: 0)",
    )
    parser.add_argument(
        "--layer", metavar="NAME", help="press it onto a layer of its own (default: the one used)"
    )


def run(options: argparse.Namespace) -> None:
    """Check, cut, press, write.

    Raises
    ------
    Paint3DError
        If anything handed in cannot be used, or the result cannot be written.
    """
    from paint3d.calligraphy.seal.stone import cut_seal
    from paint3d.colour.inks import load_ink
    from paint3d.files.project.session import is_session_path

    _check(options)
    paste = None if options.ink is None else load_ink(options.ink)
    seal = cut_seal(
        options.text,
        options.svg,
        options.style,
        options.size,
        ids=options.ids or (),
        font=options.font,
        font_number=options.font_number or 0,
        glyphs=options.glyphs,
    )
    document = _opened(options, is_session=is_session_path(options.on))
    if options.layer is not None:
        _take_layer(document, options.layer)
    with ProgressBar("pressing", enabled=not options.quiet):
        touched = _press(document, seal, paste, options)
    with ProgressBar("writing", enabled=not options.quiet) as progress:
        document.export(options.out, progress=progress)
    if not options.quiet:
        _tell_coarse(document, seal)
        sys.stdout.write(
            f"{options.out}: {seal.text}, {seal.style}, {seal.width_mm:.1f} x "
            f"{seal.height_mm:.1f} mm, {100.0 * touched:.0f} % touched\n"
        )


def _check(options: argparse.Namespace) -> None:
    if (options.text is None) == (options.svg is None):
        got = "nothing to cut" if options.text is None else "a text and --svg"
        raise InputError(f"got {got}; expected one of TEXT and --svg FILE")
    if options.ids is not None and options.svg is None:
        raise InputError("--ids is given without a drawing; expected --svg FILE")
    for name in ("font", "glyphs"):
        if getattr(options, name) is not None and options.text is None:
            raise InputError(f"--{name} is given without a text; expected TEXT")
    if options.font is not None and options.glyphs is not None:
        raise InputError("--font and --glyphs are given; expected one of them")
    if options.font_number is not None and options.font is None:
        raise InputError("--font-number is given without a font; expected --font FONT")
    check_output_file(options.out, result_suffixes())
    check_overwriting((options.out,), (options.on, options.font, options.svg), force=options.force)


def _opened(options: argparse.Namespace, *, is_session: bool) -> Document:
    """The painting that is there, or a bare object."""
    from paint3d.app.model.document import Document

    if not is_session:
        material = options.material or MATERIALS[0]
        return Document.new(_mesh(options), options.resolution or _RESOLUTION_MM, material)
    for name in ("material", "resolution", "unit", "up"):
        if getattr(options, name) is not None:
            raise InputError(f"--{name} is given, and {options.on} is a painting with its own")
    with ProgressBar("opening", enabled=not options.quiet) as progress:
        return Document.open(options.on, progress=progress)


def _mesh(options: argparse.Namespace) -> TriangleMesh:
    options.from_points, options.texture = None, False
    return load_object(options)


def _take_layer(document: Document, name: str) -> None:
    names = [layer.name for layer in document.layers]
    if name in names:
        document.select_layer(names.index(name))
    else:
        document.add_layer(name, len(names))


def _press(
    document: Document, seal: Seal, paste: dict[Pigment, float] | None, options: argparse.Namespace
) -> float:
    """Press it where it is asked for, or at the first place that has room."""
    given = {"coats": options.coats, "pad_mm": options.pad, "wear": options.wear,
             "seed": options.seed, "ink": paste}  # fmt: skip
    given = {name: value for name, value in given.items() if value is not None}
    fault: Paint3DError | None = None
    for frame in _frames(document, options):
        angle = math.radians(options.turn)
        up = math.cos(angle) * frame.y_axis - math.sin(angle) * frame.x_axis
        rings = [ring.tolist() for ring in seal.rings]
        try:
            return document.press_seal(rings, frame.origin.tolist(), up.tolist(), **given)
        except (MeshError, InputError) as cause:
            fault = fault or cause
    raise fault or MeshError(f"{options.on}: there is no place for a seal; expected a surface")


def _frames(document: Document, options: argparse.Namespace) -> Iterator[SurfaceFrame]:
    from itertools import islice

    from paint3d.calligraphy.layout import frames_to_try
    from paint3d.mesh.bvh import ClosestPoints
    from paint3d.mesh.placement import place

    closest = ClosestPoints(document.surface.source)
    if options.at is not None:
        yield place(closest, options.at, side=options.side)
        return
    yield from islice(frames_to_try(closest, options.side), _MOST_PLACES)


def _tell_coarse(document: Document, seal: Seal) -> None:
    resolution = document.surface.resolution
    if resolution is not None and seal.line_mm < _COARSE * resolution:
        sys.stderr.write(
            f"paint3d: note: its lines are {seal.line_mm:.2f} mm wide, and vertices "
            f"{resolution:g} mm apart: paint with a --resolution of "
            f"{seal.line_mm / _COARSE:.2g}, or press a larger seal\n"
        )
