"""What `paint3d write` writes: a text in known characters or in a font, a drawing, or strokes."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.errors import InputError

if TYPE_CHECKING:
    from paint3d.calligraphy.page.page import Composer
    from paint3d.calligraphy.writing import Written

__all__ = ["STROKES_FILE", "add_source_options", "check_source", "open_page", "save_written"]

STROKES_FILE = (".strokes.json",)

_OF_A_FONT = ("font_number", "features", "variation", "direction", "language")


def add_source_options(parser: argparse.ArgumentParser) -> None:
    """Add what is written instead of a text, and the file that its strokes are kept in."""
    parser.add_argument(
        "--svg", metavar="FILE", type=Path, help="write a drawing instead of a text"
    )
    parser.add_argument(
        "--ids",
        metavar="A,B",
        type=_parse_names,
        help="of the drawing, only the elements and groups with these ids",
    )
    parser.add_argument(
        "--strokes",
        metavar="FILE",
        type=Path,
        help="write what --save-strokes kept (.strokes.json), as it may have been corrected",
    )
    parser.add_argument(
        "--save-strokes",
        metavar="FILE",
        type=Path,
        help="also keep the strokes of a font's text or a drawing in a plain file (.strokes.json)",
    )


def _parse_names(text: str) -> list[str]:
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise argparse.ArgumentTypeError(f"{text!r}; expected names, such as leaf,stem")
    return names


def check_source(options: argparse.Namespace) -> None:
    """Refuse options that do not go together, before any work.

    Raises
    ------
    InputError
        If there is nothing to write, more than one thing, or an option of another one.
    """
    given = [
        name
        for name, value in (
            ("a text", options.text),
            ("--svg", options.svg),
            ("--strokes", options.strokes),
        )
        if value is not None
    ]
    if len(given) != 1:
        got = " and ".join(given) or "nothing to write"
        raise InputError(f"got {got}; expected one of TEXT, --svg FILE and --strokes FILE")
    if options.ids is not None and options.svg is None:
        raise InputError("--ids is given without a drawing; expected --svg FILE")
    if options.save_strokes is not None and options.svg is None:
        raise InputError("--save-strokes is given without a font or drawing; expected --svg FILE")


def open_page(options: argparse.Namespace) -> Composer | None:
    """The page that is to be written; None where it is a text in known characters.

    Raises
    ------
    InputError
        If a font, a drawing or a file of strokes cannot be used.
    """
    if options.svg is not None:
        from paint3d.calligraphy.page.svg_drawing import load_svg

        return load_svg(options.svg, options.ids or ())
    if options.strokes is not None:
        from paint3d.calligraphy.page.strokes_file import load_strokes

        return load_strokes(options.strokes)
    return None


def save_written(written: Written, file: Path) -> None:
    """Keep the strokes of what was written, as it was composed.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    from paint3d.calligraphy.page.strokes_file import save_strokes

    assert written.page is not None
    save_strokes(written.page, file)
