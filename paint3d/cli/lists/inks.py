"""List the inks and colours, or those of a user's own table, with sources and swatches."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.lists.columns import block, columns_of, hexadecimal, padded_line

if TYPE_CHECKING:
    from paint3d.colour.pigment import Pigment

HELP = "the palette with sources and swatches"

_WASH, _FULL = 0.1, 1.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "table",
        metavar="TABLE.csv",
        nargs="?",
        type=Path,
        help="check and list your own pigments (K and S, or R of a masstone) instead",
    )


def run(options: argparse.Namespace) -> None:
    """Write the table to stdout, with coloured swatches on a terminal.

    Raises
    ------
    PigmentError
        If the user's table cannot be used.
    """
    from paint3d.colour.pigments import load_palette, load_pigments_csv

    pigments = load_palette() if options.table is None else load_pigments_csv(options.table)
    lines = swatches_table(pigments.values(), colour=sys.stdout.isatty())
    sys.stdout.write("\n".join(lines) + "\n")


def swatches_table(pigments: Iterable[Pigment], colour: bool = False) -> list[str]:
    """Lines of a table of pigments: a head, then one pigment a line.

    Parameters
    ----------
    pigments : iterable of Pigment
    colour : bool
        Put a block in 24-bit ANSI colour before each hexadecimal colour, for a terminal.

    Returns
    -------
    list of str
        Name, Chinese name, colour of a wash (0.1 coats) and of a full coat on porcelain, basis,
        licence and source, in aligned columns.
    """
    head = ("name", "", "wash", "full coat", "basis", "licence", "source")
    rows = [
        (p.name, p.chinese, _swatch(p, _WASH), _swatch(p, _FULL), p.basis, p.licence, p.source)
        for p in pigments
    ]
    widths = [max(map(columns_of, column)) for column in zip(head, *rows, strict=True)]
    lines = [padded_line(head, widths)]
    for row in rows:
        line = padded_line(row, widths)
        for swatch in dict.fromkeys(row[2:4]) if colour else ():
            line = line.replace(swatch, block(swatch) + swatch)
        lines.append(line)
    if colour:
        padded = [*head[:2], *("   " + title for title in head[2:4]), *head[4:]]
        lines[0] = padded_line(padded, [*widths[:2], *(w + 3 for w in widths[2:4]), *widths[4:]])
    return lines


def _swatch(pigment: Pigment, coats: float) -> str:
    """Colour as #rrggbb of so many coats on porcelain."""
    from paint3d.colour.layers import mixture_reflectance
    from paint3d.colour.materials import load_material
    from paint3d.colour.spectra import srgb_from_reflectance

    ground = load_material("porcelain").reflectance
    return hexadecimal(srgb_from_reflectance(mixture_reflectance({pigment: 1.0}, coats, ground)))
