"""Copy writing from a photograph onto an object: find its strokes, then write them.

The sheet is found and laid flat, ink told from paper and seals, taken apart into strokes, and
painted as dry as each was along its way.
"""

from __future__ import annotations

import argparse
import logging
import math
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from paint3d.cli.options import FILES, check_output_file, group_of, parse_number
from paint3d.cli.painting import PaintingOptions
from paint3d.cli.progress import ProgressBar
from paint3d.cli.sources import TRIALS, add_rehearsals_option
from paint3d.cli.write import add_task_options, carry_out, check_files, settings_of
from paint3d.errors import InputError

if TYPE_CHECKING:
    from paint3d.calligraphy.glyphs import Glyph
    from paint3d.calligraphy.photo.copying import Asked, CopiedSheet
    from paint3d.calligraphy.writing import Written
    from paint3d.cli.results import PaintingResult

__all__ = ["EXAMPLES", "add_arguments", "run", "show_beside"]

EXAMPLES = """
paint3d copy sheet.jpg --on bowl --size 40 --out copy.glb
paint3d copy scan.png --whole --text 永和九年 --on vase --out vase.p3d --beside beside.png
"""

_LOG = logging.getLogger("paint3d")
_MATERIAL = "xuan"  # a brush that runs dry shows on its grain
_SIZE_MM = 40.0
_PICTURES = (".png", ".jpg", ".jpeg")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "photo",
        metavar="PHOTO",
        type=Path,
        help="a photograph or a scan: .jpg, .png, .tif, .webp, .heic and others",
    )
    photograph = group_of(parser, "the photograph")
    where = photograph.add_mutually_exclusive_group()
    where.add_argument(
        "--corners",
        metavar="X,Y",
        nargs=4,
        type=_parse_pixel,
        help="of the sheet, pixels from the picture's upper left corner, one after another around "
        "it from the sheet's upper left (default: it is looked for)",
    )
    where.add_argument(
        "--whole", action="store_true", help="the picture is the sheet, as from a scanner"
    )
    photograph.add_argument(
        "--invert", action="store_true", help="a rubbing: the strokes are white on black"
    )
    photograph.add_argument(
        "--least",
        metavar="MM2",
        type=lambda text: parse_number(text, "an area", "0 or more, mm2", lambda n: n >= 0.0),
        default=0.0,
        help="bits of ink that would be smaller than that on the object, mm2, are no strokes",
    )
    photograph.add_argument(
        "--darker",
        metavar="SHARE",
        type=lambda text: parse_number(text, "a share", "0 to 1", lambda n: 0.0 <= n <= 1.0),
        help="what takes less than this share of the light that the ink takes is no ink; 0: all "
        "is, stains too (default: all but blots that are brown or have soft edges)",
    )
    photograph.add_argument(
        "--text",
        metavar="TEXT",
        help="the characters on the sheet, a line break after each column or row: their strokes' "
        "order and direction are known then",
    )
    photograph.add_argument(
        "--dryness",
        choices=("photo", "none"),
        default="photo",
        help="paint as dry as the photograph shows, on a material with grain, or with a full brush "
        "(default: photo)",
    )
    add_rehearsals_option(photograph)
    files = group_of(parser, FILES)
    files.add_argument(
        "--beside",
        metavar="FILE",
        type=Path,
        help="also show the painting beside the photograph (.png), and say how alike they are",
    )
    files.add_argument(
        "--save-strokes",
        metavar="FILE",
        type=Path,
        help="also keep the strokes in a plain file (.strokes.json) to correct, for `paint3d "
        "write --strokes`",
    )
    add_task_options(parser, material=_MATERIAL)
    parser.set_defaults(
        size=_SIZE_MM, variation=0.0, hand_speed=1.0, seed=None
    )  # as the photograph has it


def _parse_pixel(text: str) -> tuple[float, float]:
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a place; expected X,Y such as 120,80")
    return x, y


def run(options: argparse.Namespace) -> None:
    """Check, read, find the strokes, plan, paint, write.

    Raises
    ------
    Paint3DError
        If the photograph cannot be used, or as `carry_out` says.
    """
    from paint3d.calligraphy.photo.copying import check_widths
    from paint3d.calligraphy.writing import write_page

    wanted = PaintingOptions.of(options, material=_MATERIAL)
    check_files(options, wanted, (options.photo,), (options.beside,))
    if options.beside is not None:
        check_output_file(options.beside, _PICTURES)
    wanted.check()
    sheet = _read_sheet(options)
    check_widths(sheet.page, settings_of(options).brush, options.size, wanted.resolution)
    page = sheet.page if options.dryness == "photo" else sheet.wet_page
    trials = TRIALS if options.rehearsals is None else options.rehearsals
    sheet = replace(sheet, page=page)
    write = partial(write_page, composer=page)
    written, painting = carry_out(options, wanted, write, {}, "always", trials, sheet)
    if written.dryness is not None and not painting.surface.material.grain > 0.0:
        _LOG.warning(
            "%s has no grain, so no stroke stays bare in places; --material xuan has",
            painting.surface.material.name,
        )
    if options.beside is not None:
        show_beside(sheet, written, painting, options)


def _read_sheet(options: argparse.Namespace) -> CopiedSheet:
    """Read the strokes of the photographed sheet."""
    from paint3d.calligraphy.photo.copying import copy_sheet
    from paint3d.files.photographs import load_photograph

    with ProgressBar("reading", enabled=not options.quiet) as progress:
        pixels, scale = load_photograph(options.photo, progress)
    with ProgressBar("looking", enabled=not options.quiet) as progress:
        try:
            sheet = copy_sheet(pixels, options.photo.name, _asked(options, scale), progress)
        except InputError as cause:
            raise InputError("{photo}: {cause}", photo=options.photo, cause=cause) from None
    for note in sheet.notes:
        _LOG.warning("%s: %s", options.photo, note)
    return sheet.taken_from(options.photo, scale, invert=options.invert)


def _asked(options: argparse.Namespace, scale: float) -> Asked:
    """Return the options of a photograph each of whose pixels shows `scale` of the file's."""
    import numpy as np

    from paint3d.calligraphy.photo.copying import Asked

    corners = None if options.corners is None else np.array(options.corners) / scale
    lines = tuple("".join(line.split()) for line in (options.text or "").splitlines())
    lines = tuple(filter(None, lines))
    return Asked(
        corners,
        whole=options.whole,
        invert=options.invert,
        lines=lines,
        columns=(options.layout or "columns") == "columns",
        templates=_templates("".join(lines), options.glyphs),
        least=options.least / options.size**2,
        darker=options.darker,
    )


def _templates(text: str, folder: Path | None) -> dict[str, Glyph]:
    """Return the known characters of a text."""
    from paint3d.calligraphy.glyph_sources import open_glyphs
    from paint3d.calligraphy.kanjivg import find_kanjivg

    if not text or (folder is None and find_kanjivg() is None):
        return {}
    source = open_glyphs(folder)
    return {one: source.load(one) for one in dict.fromkeys(text) if source.has(one)}


# ---- Beside the photograph -----------------------------------------------------------------------
# A finished copy beside its photograph, and how alike they are.


_GAP = 24  # pixels between the two pictures


def show_beside(
    sheet: CopiedSheet, written: Written, painting: PaintingResult, options: argparse.Namespace
) -> None:
    """Write the sheet and the painting side by side, and print their likeness.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    from PIL import Image

    from paint3d.calligraphy.photo.likeness import likeness_of, painted_sheet
    from paint3d.core.atomic import write_atomically

    with ProgressBar("comparing", enabled=not options.quiet):
        assert written.page is not None
        placed = list(zip(written.page.pieces, written.placed, strict=True))
        painted = painted_sheet(sheet, placed, painting.surface)
        figures = likeness_of(sheet, painted)
        gap = np.full((sheet.picture.shape[0], _GAP, 3), 255, np.uint8)
        both = np.concatenate([sheet.picture, gap, painted.picture], axis=1)
        with write_atomically(options.beside) as part:
            kind = "PNG" if options.beside.suffix.lower() == ".png" else "JPEG"
            Image.fromarray(both).save(part, kind)
    if not options.quiet:
        sys.stdout.write(f"{options.beside}: {figures.summary()}\n")
