"""List the brushes with their parameters, draw them, and give a file to start one's own from."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.options import add_quiet_option, check_output_folder
from paint3d.cli.progress import ProgressBar
from paint3d.errors import ExportError

if TYPE_CHECKING:
    from paint3d.brush.spec import BrushSpec

__all__ = ["HELP", "add_arguments", "brush_lines", "run"]

HELP = "the brushes with parameters and pictures; a file to start your own from"

_COLUMNS = (
    ("H", "hardness"), ("l1", "tip_segment_mm"), ("n", "n_segments"), ("mu", "friction"),
    ("b", "spread_by_pressure"), ("c", "spread_by_friction"), ("L", "length_mm"),
    ("root", "root_diameter_mm"), ("taper", "taper"), ("press", "full_press_mm"),
)  # fmt: skip
_PICTURE_INK = "pine soot"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "--pictures",
        metavar="DIR",
        type=Path,
        help="also write NAME.png for each: footprints at 15, 40, 70 and 100 %% of the force, "
        "and a stroke; the folder is made where missing",
    )
    add_quiet_option(parser)
    actions = parser.add_subparsers(metavar="ACTION", dest="action")
    show = actions.add_parser(
        "show",
        help="print a brush as a file: paint3d brushes show full > mine.toml",
        allow_abbrev=False,
    )
    show.add_argument("brush", metavar="NAME|FILE", help="a brush of the list, or a file to check")


def run(options: argparse.Namespace) -> None:
    """Write the table, the pictures or the file.

    Raises
    ------
    Paint3DError
        If the brush cannot be used, or a picture cannot be written.
    """
    if options.action == "show":
        _show(options.brush)
        return
    from paint3d.brush.presets import brush_note, load_presets

    presets = load_presets()
    if options.pictures is not None:
        _draw(presets.values(), options.pictures, quiet=options.quiet)
    if not options.quiet:
        notes = {name: brush_note(name) for name in presets}
        sys.stdout.write("\n".join(brush_lines(presets.values(), notes)) + "\n")


def _show(name: str) -> None:
    from paint3d.brush.brush_file import brush_text
    from paint3d.brush.presets import brush_note, load_brush

    brush = load_brush(name)
    sys.stdout.write(brush_text(brush, brush_note(brush.name)))


def brush_lines(brushes: Iterable[BrushSpec], notes: dict[str, str]) -> list[str]:
    """Lines of a table of brushes: a head, then one brush a line, lengths in mm.

    Parameters
    ----------
    brushes : iterable of BrushSpec
    notes : dict
        What each is for, by name.
    """
    rows = [("name", "hair", *(head for head, _ in _COLUMNS), "hairs", "for")]
    for brush in brushes:
        numbers = [f"{getattr(brush, field):g}" for _, field in _COLUMNS]
        hairs = "solid" if brush.bristles is None else str(brush.bristles.n_hairs)
        rows.append((brush.name, brush.hair, *numbers, hairs, notes.get(brush.name, "")))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [_line(row, widths) for row in rows]


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    *cells, last = (cell.ljust(width) for cell, width in zip(cells, widths, strict=True))
    return "  ".join([*cells, last.rstrip()])


def _draw(brushes: Iterable[BrushSpec], folder: Path, *, quiet: bool) -> None:
    """Write a picture of each brush."""
    check_output_folder(folder)
    from PIL import Image

    from paint3d.core.atomic import write_atomically
    from paint3d.view.brush_picture import draw_brush

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError(f"{folder}: {error.strerror or error}") from None
    brushes = list(brushes)
    with ProgressBar("drawing", enabled=not quiet) as progress:
        for k, brush in enumerate(brushes):
            pixels = draw_brush(brush, _PICTURE_INK)
            with write_atomically(folder / f"{brush.name}.png") as file:
                Image.fromarray(pixels).save(file, format="PNG")
            progress((k + 1) / len(brushes))
