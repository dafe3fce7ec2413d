"""Inks in words: names, parts, and the files that they lead to. Known before NumPy is loaded."""

from __future__ import annotations

import math
import os
from collections.abc import Callable

from paint3d.errors import PigmentError

__all__ = ["names_table", "split_ink", "table_of", "tables_in", "with_tables"]

_TABLES = (".csv", ".spdx", ".xml", ".txt")  # pigments, and measured spectra


def table_of(name: str) -> str | None:
    """The file of a user's own table that one ink's name leads to; None for the others.

    Examples
    --------
    >>> table_of("mine.csv:iron gall"), table_of("pine soot")
    ('mine.csv', None)
    """
    file, colon, _ = name.rpartition(":")
    return file if colon and file.lower().endswith(_TABLES) else None


def split_ink(text: str) -> list[tuple[str, float]]:
    """The inks that a text stirs, by name, and the parts of each.

    Parameters
    ----------
    text : str
        ``NAME``, or ``NAME:PARTS,NAME:PARTS``; who says no parts stands for one. A name may be
        ``FILE.csv:NAME``.

    Raises
    ------
    PigmentError
        If an ink has no name, or its parts are no number above 0.

    Examples
    --------
    >>> split_ink("pine soot:0.2, water:0.8")
    [('pine soot', 0.2), ('water', 0.8)]
    >>> split_ink("mine.csv:iron gall")
    [('mine.csv:iron gall', 1.0)]
    """
    pieces = [text] if _is_one(text) else text.split(",")
    return [_split_part(piece.strip(), text) for piece in pieces]


def _is_one(text: str) -> bool:
    """Whether the text is one ink of a table, with a comma in its file's name or in its own."""
    file = table_of(text)
    return file is not None and "," in text and os.path.isfile(file)


def _split_part(piece: str, text: str) -> tuple[str, float]:
    name, colon, parts = piece.rpartition(":")
    if not colon or name.lower().endswith(_TABLES):
        name, parts = piece, "1"
    name = name.strip()
    if not name:
        raise PigmentError(
            f"the ink {text[:100]!r} has a part without a name; expected NAME or "
            "NAME:PARTS,NAME:PARTS such as 'pine soot:0.2,water:0.8'"
        )
    try:
        weight = float(parts)
    except ValueError:
        weight = math.nan
    if not (math.isfinite(weight) and weight >= 1e-9):
        raise PigmentError(
            f"the ink {text[:100]!r} has {parts.strip()!r} parts of {name!r}; "
            "expected a number above 0"
        )
    return name, weight


def names_table(text: str) -> bool:
    """Whether an ink in words could lead to a file, which is not looked for."""
    return any(f"{suffix}:" in text.lower() for suffix in _TABLES)


def tables_in(text: str | None) -> list[str]:
    """The files of users' own tables that an ink in words leads to."""
    if not text:
        return []
    pieces = [text] if _is_one(text) else text.split(",")
    found = []
    for piece in pieces:
        name = piece.strip()
        file = table_of(name) or table_of(name.rpartition(":")[0])
        found += [file] if file else []
    return found


def with_tables(text: str, place: Callable[[str], str]) -> str:
    """The ink with the files of its tables as `place` has them."""
    pieces = [text] if _is_one(text) else text.split(",")
    placed = []
    for piece in pieces:
        name = piece.strip()
        file = table_of(name) or table_of(name.rpartition(":")[0])
        placed.append(piece if file is None else place(file) + name[len(file) :])
    return ",".join(placed)
