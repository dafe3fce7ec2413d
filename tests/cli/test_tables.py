"""Tables that commands print: they fit the terminal, and a pipe gets a row a line."""

from __future__ import annotations

import re
import unicodedata

import pytest

from paint3d.brush.presets import load_presets
from paint3d.cli.lists.brushes import brush_lines
from paint3d.cli.lists.inks import swatches_table
from paint3d.cli.lists.materials import material_lines
from paint3d.colour.materials import load_materials
from paint3d.colour.pigments import load_palette

TABLES = {
    "inks": lambda **how: swatches_table(load_palette().values(), **how),
    "materials": lambda **how: material_lines(load_materials().values(), **how),
    "brushes": lambda columns=None, colour=False: brush_lines(
        load_presets().values(),
        dict.fromkeys(load_presets(), "for long lines of text " * 6),
        columns,
    ),
}
NAMES = {"inks": load_palette, "materials": load_materials, "brushes": load_presets}


def width(line: str) -> int:
    plain = re.sub("\x1b\\[[0-9;]*m", "", line)
    return sum(2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in plain)


@pytest.mark.parametrize("colour", [False, True])
@pytest.mark.parametrize("columns", [80, 120, 200])
@pytest.mark.parametrize("table", TABLES)
def test_a_table_fits_the_terminal(table: str, columns: int, colour: bool) -> None:
    lines = TABLES[table](columns=columns, colour=colour)
    assert max(map(width, lines)) <= columns
    whole = " ".join(" ".join(TABLES[table]()).split())
    fitted = re.sub("\x1b\\[[0-9;]*m", "", " ".join(lines))
    assert set(whole.split()) == set(fitted.split())  # nothing is lost


@pytest.mark.parametrize("table", TABLES)
def test_a_pipe_gets_one_line_a_row(table: str) -> None:
    assert len(TABLES[table]()) == 1 + len(NAMES[table]())
