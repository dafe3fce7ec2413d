"""List inks, those of a user's own table, or a mixture, with swatches; find and keep mixtures."""

from __future__ import annotations

import argparse
import re
import shlex
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
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
paint3d inks --nearest "#1f6f78" --wash "#cbe0d4" --keep "deep teal"
paint3d inks --compare azurite "indigo:0.6,lapis lazuli:0.4"
"""

_FULL, _PRESSED = 1.0, 2.0  # coats; a pressed brush leaves about two


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
        "--wash",
        metavar="#RRGGBB",
        type=_parse_colour,
        help="with --nearest, the colour that a tenth of a coat comes near to besides",
    )
    parser.add_argument("--ink", metavar="INK", help="show this ink or mixture instead")
    parser.add_argument(
        "--keep",
        metavar="NAME",
        help="with --nearest or --ink, keep it: from then on every --ink takes it by this name",
    )
    parser.add_argument("--forget", metavar="NAME", help="forget an ink that was kept")
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
    wishes = {
        "a table": options.table, "--nearest": options.nearest, "--ink": options.ink,
        "--compare": options.compare, "--forget": options.forget,
    }  # fmt: skip
    asked = [name for name, wish in wishes.items() if wish is not None]
    if len(asked) > 1:
        raise InputError(
            "{first} is given beside {second}; expected one of them (inks of a table are "
            "FILE.csv:NAME)",
            first=asked[0],
            second=asked[1],
        )
    if options.keep is not None and asked not in (["--nearest"], ["--ink"]):
        raise InputError("--keep is given without an ink; expected --nearest or --ink beside it")
    if options.wash is not None and asked != ["--nearest"]:
        raise InputError("--wash is given without --nearest; expected both")
    if options.compare is not None:
        sys.stdout.write("\n".join(comparison_table(options)) + "\n")
    elif options.forget is not None:
        from paint3d.colour.inks import forget_ink

        sys.stderr.write(f"{forget_ink(options.forget)}: has no {options.forget} any more\n")
    elif options.nearest is not None:
        _keep(options.keep, _print_nearest(options.nearest, options.wash, options.material))
    else:
        _list(options.table, options.ink)
        _keep(options.keep, options.ink)


def _list(table: Path | None, ink: str | None) -> None:
    """Print all inks, those of a table, or one alone."""
    from paint3d.colour.inks import kept_inks
    from paint3d.colour.pigments import load_palette, load_pigments_csv

    pigments: Mapping[str, Pigment] = {}
    mixtures: dict[str, str] = {}
    if ink is not None:
        mixtures = {ink: ""}
    elif table is not None:
        pigments = load_pigments_csv(table)
    else:
        pigments = load_palette()
        for name, parts in kept_inks().items():
            mixtures[name] = ",".join(f"{part}:{weight:g}" for part, weight in parts.items())
    lines = swatches_table(pigments.values(), sys.stdout.isatty(), terminal_columns(), mixtures)
    sys.stdout.write("\n".join(lines) + "\n")
    if table is not None and any(p.basis == "masstone" for p in pigments.values()):
        sys.stderr.write(
            "note: of a masstone the full coat is as it was measured; how it thins is guessed, and "
            "washes and tints may be off by 10 dE00 (docs/ink.md, How far the colours can be "
            "trusted)\n"
        )


def _keep(name: str | None, ink: str) -> None:
    if name is not None:
        from paint3d.colour.inks import keep_ink

        sys.stderr.write(f"kept in {keep_ink(name, ink)}: --ink {shlex.quote(name)}\n")


def _parse_colour(text: str) -> tuple[int, ...]:
    if re.fullmatch("#?[0-9a-fA-F]{6}", text) is None:
        raise argparse.ArgumentTypeError(f"{text!r} is not a colour; expected #RRGGBB")
    return tuple(bytes.fromhex(text.lstrip("#")))


def _print_nearest(srgb: tuple[int, ...], wash: tuple[int, ...] | None, material: str) -> str:
    """Print the mixture to stdout, for a shell to pass on, and its difference to stderr."""
    from paint3d.colour.inks import describe_ink
    from paint3d.colour.materials import load_material
    from paint3d.colour.nearest_mixture import nearest_mixture

    nearest = nearest_mixture(srgb, load_material(material).reflectance, wash=wash)
    ink = describe_ink(nearest.parts)
    sys.stdout.write(ink + "\n")
    sys.stdout.flush()
    films = [("coat", nearest.srgb, nearest.difference, srgb)]
    if wash is not None and nearest.wash_difference is not None:
        films.append(("wash", nearest.wash_srgb, nearest.wash_difference, wash))
    for film, own, off, wanted in films:
        sys.stderr.write(
            f"a {film} of it on {material} is {hexadecimal(own)}, {off:.2g} dE00 from "
            f"{hexadecimal(wanted)}\n"
        )
    return ink


def comparison_table(options: argparse.Namespace) -> list[str]:
    """Return CSV: a head, then one light a line, with colours, dE00 and metamerism index."""
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
    """Return the reflectance (31,) of a film of an ink, given as text."""
    from paint3d.colour.inks import load_ink
    from paint3d.colour.layers import mixture_reflectance

    stirred: dict[str | Pigment, float] = {}
    stirred.update(load_ink(ink).items())
    return mixture_reflectance(stirred, coats, ground, by_volume=True)


def _csv_word(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\n') else text


def swatches_table(
    pigments: Iterable[Pigment],
    colour: bool = False,
    columns: int | None = None,
    mixtures: Mapping[str, str] = MappingProxyType({}),
) -> list[str]:
    """Return a table of pigments: a head, then one pigment a line.

    Parameters
    ----------
    pigments : iterable of Pigment
    colour : bool
        Put a block in 24-bit ANSI colour before each hexadecimal colour, for a terminal.
    columns : int, optional
        How wide it may be; see `table_lines`.
    mixtures : mapping of str to str
        Inks that come after the pigments: what they are mixed of, by name.

    Returns
    -------
    list of str
        Name, Chinese name, colour of a wash (0.1 coats), of a full coat and of two, as a pressed
        brush leaves them, on porcelain, basis, licence and source, in aligned columns.
    """
    from paint3d.colour.inks import load_ink
    from paint3d.colour.nearest_mixture import WASH_COATS

    kinds = {"wash": WASH_COATS, "full coat": _FULL, "two coats": _PRESSED}
    shown = [swatch_cell(kind, colour) for kind in kinds]
    rows: list[Sequence[str]] = [("name", "", *shown, "basis", "licence", "source")]
    for one in pigments:
        films = [swatch_cell(_swatch({one: 1.0}, coats), colour) for coats in kinds.values()]
        rows.append((one.name, one.chinese, *films, one.basis, one.licence, one.source))
    for name, parts in mixtures.items():
        try:
            stirred = load_ink(name)
        except InputError as cause:  # its table is gone, say
            if not parts:
                raise
            rows.append((name, "", "", "", "", f"cannot be used: {cause}", "", ""))
            continue
        films = [swatch_cell(_swatch(stirred, coats), colour) for coats in kinds.values()]
        rows.append((name, "", *films, parts or "mixture", "", ""))
    return table_lines(rows, columns, colour)


def _swatch(ink: Mapping[Pigment, float], coats: float) -> str:
    """Return the colour of so many coats on porcelain, as #rrggbb."""
    from paint3d.colour.layers import mixture_reflectance
    from paint3d.colour.materials import load_material
    from paint3d.colour.spectra import srgb_from_reflectance

    ground = load_material("porcelain").reflectance
    stirred: dict[str | Pigment, float] = dict(ink.items())
    film = mixture_reflectance(stirred, coats, ground, by_volume=True)
    return hexadecimal(srgb_from_reflectance(film))
