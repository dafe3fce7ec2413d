"""List the materials of surfaces with their numbers, and give a file to start one's own from."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING

from paint3d.cli.lists.columns import hexadecimal, swatch_cell, table_lines, terminal_columns
from paint3d.cli.options import add_actions, add_quiet_option

if TYPE_CHECKING:
    from paint3d.colour.materials import Material

__all__ = ["EXAMPLES", "add_arguments", "material_lines", "run"]

EXAMPLES = """
paint3d materials
paint3d materials show silk > mine.toml
"""

_COLUMNS = (
    ("rough", "roughness"), ("glaze", "coat"), ("drinks", "absorbency"), ("grain", "grain"),
    ("tooth", "tooth_mm"), ("friction", "friction"), ("pores", "pores_mm"),
    ("residual", "residual"), ("advance", "advance"), ("spread", "spread_mm2_s"),
    ("passing", "passing"), ("drying", "drying_mm_s"),
)  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    add_quiet_option(parser)
    add = add_actions(parser, required=False)
    show = add(
        "show",
        "print a material as a file to start your own from, or check one",
        "paint3d materials show silk > mine.toml",
    )
    show.add_argument(
        "material", metavar="NAME|FILE", help="a material of the list, or a file to check"
    )


def run(options: argparse.Namespace) -> None:
    """Write the table or the file to stdout.

    Raises
    ------
    Paint3DError
        If the material is not known, or its file cannot be used.
    """
    from paint3d.colour.materials import load_material, load_materials

    if options.action == "show":
        from paint3d.colour.materials import material_text

        sys.stdout.write(material_text(load_material(options.material)))
    elif not options.quiet:
        lines = material_lines(load_materials().values(), sys.stdout.isatty(), terminal_columns())
        sys.stdout.write("\n".join(lines) + "\n")


def material_lines(
    materials: Iterable[Material], colour: bool = False, columns: int | None = None
) -> list[str]:
    """Return a table of materials: a head, then one a line; lengths in mm, drying in mm/s.

    Parameters
    ----------
    materials : iterable of Material
    colour : bool
        Put a block in 24-bit ANSI colour before each hexadecimal colour, for a terminal.
    columns : int, optional
        How wide it may be; see `table_lines`.
    """
    from paint3d.colour.spectra import srgb_from_reflectance

    materials = list(materials)
    rows = [
        (
            "name",
            "",
            swatch_cell("colour", colour),
            *(head for head, _ in _COLUMNS),
            "reflectance",
            "numbers",
        )
    ]
    for material in materials:
        shown = swatch_cell(hexadecimal(srgb_from_reflectance(material.reflectance)), colour)
        numbers = (f"{getattr(material, field):g}" for _, field in _COLUMNS)
        from_where = f"{material.basis} ({material.source})" if material.source else material.basis
        names = material.name, material.chinese
        rows.append((*names, shown, *numbers, from_where, material.note))
    return table_lines(rows, columns, colour)
