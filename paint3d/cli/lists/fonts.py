"""List the fonts of this system that can be written with."""

from __future__ import annotations

import argparse
import sys

__all__ = ["EXAMPLES", "add_arguments", "run"]

EXAMPLES = """
paint3d fonts
paint3d fonts سلام --files
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument(
        "text", metavar="TEXT", nargs="?", default="", help="only fonts that have its characters"
    )
    parser.add_argument("--files", action="store_true", help="also say where each face is kept")


def run(options: argparse.Namespace) -> None:
    """Print families and their styles, or every face with its file.

    Raises
    ------
    InputError
        If fontconfig is not there to be asked, or no font draws the characters.
    """
    from paint3d.calligraphy.fonts.font_file import fonts_that_draw
    from paint3d.errors import InputError

    fonts = fonts_that_draw(options.text)
    if not fonts:
        what = f" with {options.text!r}" if options.text else ""
        raise InputError(
            "no font of outlines{what} on this system; expected one (or --font FILE)",
            what=what,
        )
    if options.files:
        lines = [f"{font.family} {font.style}\t{font.path}" for font in fonts]
    else:
        styles: dict[str, list[str]] = {}
        for font in fonts:
            styles.setdefault(font.family, []).append(font.style)
        lines = [f"{name}: {', '.join(dict.fromkeys(styles[name]))}" for name in styles]
    sys.stdout.write("\n".join(lines) + "\n")
