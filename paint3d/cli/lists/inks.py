"""List the inks and colours, or those of a user's own table, with sources and swatches."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.lists.columns import hexadecimal, swatch_cell, table_lines, terminal_columns
from paint3d.cli.options import MATERIALS
from paint3d.errors import InputError

if TYPE_CHECKING:
    from paint3d.colour.pigments import Pigment
    from paint3d.core.arrays import AnyArray

EXAMPLES = """
paint3d inks
paint3d inks --nearest "#2f5d62"
paint3d inks --compare azurite "indigo:0.6,lapis lazuli:0.4"
"""

_WASH, _FULL = 0.1, 1.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "table",
        metavar="TABLE.csv",
        nargs="?",
        type=Path,
        help="check and list your own pigments (K and S, R of a masstone, or a film over white and "
        "black; .spdx, .txt: measured masstones) instead",
    )
    parser.add_argument(
        "--nearest",
        metavar="#RRGGBB",
        type=_parse_colour,
        help="the mixture for --ink of which a coat comes nearest to this colour",
    )
    parser.add_argument(
        "--compare",
        metavar=("A", "B"),
        nargs=2,
        help="how two inks look in several lights, and how far apart (metamerism), as CSV",
    )
    parser.add_argument(
        "--illuminant",
        metavar="LIGHT",
        action="append",
        help="with --compare, in these lights (the first: the one to refer to) instead of D65, "
        "D50, A, F2, F11 and LED-B3; a name, a temperature such as 2700K, or FILE.spd",
    )
    parser.add_argument(
        "--observer",
        metavar="DEGREES",
        type=int,
        choices=(2, 10),
        default=2,
        help="with --compare, 2 or 10 (default: 2)",
    )
    parser.add_argument(
        "--coats",
        metavar="X",
        type=float,
        default=_FULL,
        help="with --compare, how thick both lie (default: 1)",
    )
    parser.add_argument(
        "--material",
        metavar="NAME|FILE",
        default="porcelain",
        help=f"with --compare and --nearest, what they lie on: {', '.join(MATERIALS)}, or a file "
        "of your own (default: porcelain)",
    )


def run(options: argparse.Namespace) -> None:
    """Write the table to stdout, with coloured swatches on a terminal; or compare or find inks.

    Raises
    ------
    PigmentError
        If the user's table cannot be used.
    InputError
        If an ink or a light is not known, or colour-science is missing.
    """
    if options.compare is None and options.illuminant is not None:
        raise InputError("--illuminant is given without inks to compare; expected --compare A B")
    if options.nearest is not None:
        asked = (options.table, options.compare)
        if asked != (None, None):
            raise InputError("--nearest is given beside a table or --compare; expected it alone")
        _tell_nearest(options.nearest, options.material)
        return
    if options.compare is not None and options.table is not None:
        raise InputError(
            "{table} is given beside --compare; expected one of them (--compare takes "
            "FILE.csv:NAME)",
            table=options.table,
        )
    if options.compare is not None:
        sys.stdout.write("\n".join(comparison_table(options)) + "\n")
        return
    from paint3d.colour.pigments import load_palette, load_pigments_csv

    pigments = load_palette() if options.table is None else load_pigments_csv(options.table)
    lines = swatches_table(pigments.values(), sys.stdout.isatty(), terminal_columns())
    sys.stdout.write("\n".join(lines) + "\n")
    if options.table is not None and any(p.basis == "masstone" for p in pigments.values()):
        sys.stderr.write(
            "note: of a masstone the full coat is as it was measured; how it thins is guessed, and "
            "washes and tints may be off by 10 dE00 (docs/ink.md, How far the colours can be "
            "trusted)\n"
        )


def _parse_colour(text: str) -> tuple[int, ...]:
    if re.fullmatch("#?[0-9a-fA-F]{6}", text) is None:
        raise argparse.ArgumentTypeError(f"{text!r} is not a colour; expected #RRGGBB")
    return tuple(bytes.fromhex(text.lstrip("#")))


def _tell_nearest(srgb: tuple[int, ...], material: str) -> None:
    """Write the mixture to stdout, so that a shell can hand it on, and how near it comes after."""
    from paint3d.colour.inks import describe_ink
    from paint3d.colour.materials import load_material
    from paint3d.colour.nearest_mixture import nearest_mixture

    found = nearest_mixture(srgb, load_material(material).reflectance)
    sys.stdout.write(describe_ink(found.parts) + "\n")
    sys.stdout.flush()
    sys.stderr.write(
        f"a coat of it on {material} is {hexadecimal(found.srgb)}, {found.difference:.2g} dE00 "
        f"from {hexadecimal(srgb)}\n"
    )


def comparison_table(options: argparse.Namespace) -> list[str]:
    """Lines of CSV: a head, then one light a line, with colours, dE00 and metamerism index."""
    from paint3d.colour.difference import COMPARED, compare_spectra
    from paint3d.colour.materials import load_material
    from paint3d.core.arrays import as_number

    coats = as_number(options.coats, "--coats", 0.0, 100.0)
    ground = load_material(options.material).reflectance
    one, two = (_film(ink, coats, ground) for ink in options.compare)
    seen = compare_spectra(one, two, options.illuminant or COMPARED, options.observer)
    lines = ["illuminant,L_A,a_A,b_A,L_B,a_B,b_B,dE00,metamerism_index"]
    for row in seen:
        numbers = [*row.lab.ravel().tolist(), row.difference, row.shift]
        lines.append(",".join([_csv_word(row.illuminant), *(f"{x:.2f}" for x in numbers)]))
    return lines


def _film(ink: str, coats: float, ground: AnyArray) -> AnyArray:
    """Reflectance (31,) of a film of an ink in words."""
    from paint3d.colour.inks import load_ink
    from paint3d.colour.layers import mixture_reflectance

    stirred: dict[str | Pigment, float] = {}
    stirred.update(load_ink(ink).items())
    return mixture_reflectance(stirred, coats, ground, by_volume=True)


def _csv_word(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\n') else text


def swatches_table(
    pigments: Iterable[Pigment], colour: bool = False, columns: int | None = None
) -> list[str]:
    """Lines of a table of pigments: a head, then one pigment a line.

    Parameters
    ----------
    pigments : iterable of Pigment
    colour : bool
        Put a block in 24-bit ANSI colour before each hexadecimal colour, for a terminal.
    columns : int, optional
        How wide it may be; see `table_lines`.

    Returns
    -------
    list of str
        Name, Chinese name, colour of a wash (0.1 coats) and of a full coat on porcelain, basis,
        licence and source, in aligned columns.
    """
    wash, full = (swatch_cell(title, colour) for title in ("wash", "full coat"))
    rows: list[Sequence[str]] = [("name", "", wash, full, "basis", "licence", "source")]
    for one in pigments:
        shown = [swatch_cell(_swatch(one, coats), colour) for coats in (_WASH, _FULL)]
        rows.append((one.name, one.chinese, *shown, one.basis, one.licence, one.source))
    return table_lines(rows, columns, colour)


def _swatch(pigment: Pigment, coats: float) -> str:
    """Colour as #rrggbb of so many coats on porcelain."""
    from paint3d.colour.layers import mixture_reflectance
    from paint3d.colour.materials import load_material
    from paint3d.colour.spectra import srgb_from_reflectance

    ground = load_material("porcelain").reflectance
    return hexadecimal(srgb_from_reflectance(mixture_reflectance({pigment: 1.0}, coats, ground)))
