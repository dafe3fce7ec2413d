"""Centre lines of characters, from which the page cuts seals.

A file for the page (`paint3d.page.bundle`). Words: ``{"licence", "units", "characters"}``, the
units of an em. Arrays: how many `strokes` (C,) each character has, how many points the lines
of all strokes have, `lengths` (S,), and these `points` (N, 2) int16 from a corner of the em square.
"""

from __future__ import annotations

import os

import numpy as np

from paint3d.calligraphy.glyph_sources import load_glyphs, open_glyphs
from paint3d.calligraphy.glyphs import EM_UNITS
from paint3d.calligraphy.kanjivg import find_kanjivg, load_lines
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError
from paint3d.page.tables import Table

__all__ = ["EVERY", "seal_table"]

EVERY = "all"
"""Stands for all characters that are installed."""

_TOLERANCE = 2.0  # glyph units between a line and its chords


def seal_table(text: str) -> Table:
    """Make the table of the lines of a text's characters, or of `EVERY` one.

    Raises
    ------
    InputError
        If a character has no lines, or none are installed.
    """
    source, folder = open_glyphs(None), find_kanjivg()
    assert folder is not None, "else open_glyphs refuses"
    if text == EVERY:
        names = (name.removesuffix(".svg") for name in os.listdir(folder) if name.endswith(".svg"))
        characters = [chr(int(name, 16)) for name in sorted(names) if len(name) == 5]
    else:
        characters = list(dict.fromkeys("".join(text.split())))
        load_glyphs(source, "".join(characters))
    strokes: list[int] = []
    lengths: list[int] = []
    points: list[AnyArray] = [np.empty((0, 2), np.int16)]
    available = []
    for one in characters:
        try:
            lines = [_simplified(stroke.line) for stroke in load_lines(folder, one)]
        except InputError:
            if text != EVERY:
                raise
            continue
        available.append(one)
        strokes.append(len(lines))
        lengths += map(len, lines)
        points += lines
    words = {"licence": source.licence, "units": EM_UNITS, "characters": "".join(available)}
    return words, {
        "strokes": np.array(strokes, np.uint8),
        "lengths": np.array(lengths, np.uint8),
        "points": np.concatenate(points),
    }


def _simplified(line: AnyArray) -> AnyArray:
    """Simplify a line (N, 2) to fewer points, int16."""
    import shapely

    simple = shapely.LineString(line).simplify(_TOLERANCE)
    result: AnyArray = np.rint(shapely.get_coordinates(simple)).astype(np.int16)
    return result
