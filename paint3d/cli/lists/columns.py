"""Tables on a terminal: columns, also of Chinese characters, and blocks of colour."""

from __future__ import annotations

import re
import shutil
import sys
import unicodedata
from collections.abc import Iterable, Sequence

__all__ = ["hexadecimal", "swatch_cell", "table_lines", "terminal_columns"]

_SWATCH = re.compile("   (#[0-9a-f]{6})")  # as `swatch_cell` has it
_LEAST_TEXT = 24  # columns that a text is wrapped to, at least


def hexadecimal(srgb: Iterable[int]) -> str:
    """Format an sRGB colour as #rrggbb."""
    red, green, blue = (int(code) for code in srgb)
    return f"#{red:02x}{green:02x}{blue:02x}"


def swatch_cell(swatch: str, colour: bool) -> str:
    """Return the cell of a colour #rrggbb, or of its column's head, with room for a block of it."""
    return f"   {swatch}" if colour else swatch


def terminal_columns() -> int | None:
    """Return the width of the terminal of stdout; None for a file or a pipe."""
    return shutil.get_terminal_size((100, 24)).columns if sys.stdout.isatty() else None


def columns_of(text: str) -> int:
    """Return the columns of a text on a terminal: Chinese characters take two."""
    return sum(2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text)


def table_lines(
    rows: Sequence[Sequence[str]], columns: int | None = None, colour: bool = False
) -> list[str]:
    """Return the lines of a table.

    Parameters
    ----------
    rows : sequence of rows
        The head first; the first cell of each is its name.
    columns : int, optional
        How wide it may be: columns that have no room follow below with the names repeated, and
        long texts are wrapped. By default each row is one line.
    colour : bool
        Put a block in 24-bit ANSI colour before each colour of `swatch_cell`.
    """
    widths = [max(map(columns_of, column)) for column in zip(*rows, strict=True)]
    blocks: list[list[int]] = [[0]]
    for k, width in enumerate(widths[1:], 1):
        taken = sum(widths[j] + 2 for j in blocks[-1]) + width
        if columns is not None and taken > columns and blocks[-1] != [0]:
            blocks.append([0])
        blocks[-1].append(k)
    lines: list[str] = []
    for block in blocks:
        lines += [""] if lines else []
        for row in rows:
            lines += _row_lines([row[k] for k in block], [widths[k] for k in block], columns)
    return [_SWATCH.sub(_coloured, line) for line in lines] if colour else lines


def _row_lines(cells: list[str], widths: list[int], columns: int | None) -> list[str]:
    """Return a row, its last cell wrapped to the columns left."""
    before = "  ".join(
        cell + " " * (width - columns_of(cell))
        for cell, width in zip(cells[:-1], widths, strict=False)
    )
    indent = columns_of(before) + 2
    if columns is None or indent + columns_of(cells[-1]) <= columns:
        return [f"{before}  {cells[-1]}".rstrip()]
    room, texts = max(columns - indent, _LEAST_TEXT), [""]
    for word in cells[-1].split(" "):
        if texts[-1] and columns_of(f"{texts[-1]} {word}") > room:
            texts.append("")
        texts[-1] = f"{texts[-1]} {word}".strip()
    return [f"{before}  {texts[0]}", *(" " * indent + text for text in texts[1:])]


def _coloured(match: re.Match[str]) -> str:
    red, green, blue = (int(match[1][i : i + 2], 16) for i in (1, 3, 5))
    return f"\x1b[48;2;{red};{green};{blue}m  \x1b[0m {match[1]}"
