"""The text that names an ink: its parts, and the tables that they refer to. Needs no NumPy."""

from __future__ import annotations

import math
import os
from collections.abc import Callable

from paint3d.errors import PigmentError

__all__ = ["names_table", "split_ink", "table_of", "tables_in", "with_tables"]

_TABLES = (".csv", ".spdx", ".xml", ".txt")  # pigments, and measured spectra


def table_of(name: str) -> str | None:
    """Return the user's table that an ink's name refers to; None for other names.

    Examples
    --------
    >>> table_of("mine.csv:iron gall"), table_of("pine soot")
    ('mine.csv', None)
    """
    file, colon, _ = name.rpartition(":")
    return file if colon and file.lower().endswith(_TABLES) else None


def split_ink(text: str) -> list[tuple[str, float]]:
    """Split the text of a mixture into the name and the parts of each ink.

    Parameters
    ----------
    text : str
        ``NAME``, or ``NAME:PARTS,NAME:PARTS``; without parts, a name counts one. A name may be
        ``FILE.csv:NAME``.

    Raises
    ------
    PigmentError
        If an ink has no name, or its parts are not a number above 0.

    Examples
    --------
    >>> split_ink("pine soot:0.2, water:0.8")
    [('pine soot', 0.2), ('water', 0.8)]
    >>> split_ink("mine.csv:iron gall")
    [('mine.csv:iron gall', 1.0)]
    """
    return [_split_part(piece.strip(), text) for piece in _split_commas(text)]


def _split_commas(text: str) -> list[str]:
    """Split at commas, unless it is one ink of a table with a comma in the file's or ink's name."""
    file = table_of(text)
    is_single = file is not None and "," in text and os.path.isfile(file)
    return [text] if is_single else text.split(",")


def _split_part(piece: str, text: str) -> tuple[str, float]:
    name, colon, parts = piece.rpartition(":")
    if not colon or name.lower().endswith(_TABLES):
        name, parts = piece, "1"
    name = name.strip()
    if not name:
        raise PigmentError(
            "the ink {text!r} has a part without a name; expected NAME or NAME:PARTS,NAME:PARTS "
            "such as 'pine soot:0.2,water:0.8'",
            text=text[:100],
        )
    try:
        weight = float(parts)
    except ValueError:
        weight = math.nan
    if not (math.isfinite(weight) and weight >= 1e-9):
        raise PigmentError(
            "the ink {text!r} has {parts!r} parts of {name!r}; expected a number above 0",
            text=text[:100],
            parts=parts.strip(),
            name=name,
        )
    return name, weight


def names_table(text: str) -> bool:
    """Return whether the text of an ink may refer to a table; the file is not looked for."""
    return any(f"{suffix}:" in text.lower() for suffix in _TABLES)


def tables_in(text: str | None) -> list[str]:
    """List the users' tables that the text of an ink refers to."""
    if not text:
        return []
    found = []
    for piece in _split_commas(text):
        name = piece.strip()
        file = table_of(name) or table_of(name.rpartition(":")[0])
        found += [file] if file else []
    return found


def with_tables(text: str, place: Callable[[str], str]) -> str:
    """Replace the path of each table in the text of an ink by ``place(path)``."""
    placed = []
    for piece in _split_commas(text):
        name = piece.strip()
        file = table_of(name) or table_of(name.rpartition(":")[0])
        placed.append(piece if file is None else place(file) + name[len(file) :])
    return ",".join(placed)
