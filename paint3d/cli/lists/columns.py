"""Tables on a terminal: columns, also of Chinese characters, and blocks of colour."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Sequence

__all__ = ["block", "columns_of", "hexadecimal", "padded_line"]


def hexadecimal(srgb: Iterable[int]) -> str:
    """An sRGB colour as #rrggbb."""
    red, green, blue = (int(code) for code in srgb)
    return f"#{red:02x}{green:02x}{blue:02x}"


def block(swatch: str) -> str:
    """A block of a colour #rrggbb and a space, in 24-bit ANSI colour: three columns."""
    red, green, blue = (int(swatch[i : i + 2], 16) for i in (1, 3, 5))
    return f"\x1b[48;2;{red};{green};{blue}m  \x1b[0m "


def columns_of(text: str) -> int:
    """Columns that a text takes on a terminal: Chinese characters take two."""
    return sum(2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text)


def padded_line(cells: Sequence[str], widths: Sequence[int]) -> str:
    """The cells of a row, each as wide as its column."""
    padded = (
        cell + " " * (width - columns_of(cell)) for cell, width in zip(cells, widths, strict=True)
    )
    return "  ".join(padded).rstrip()
