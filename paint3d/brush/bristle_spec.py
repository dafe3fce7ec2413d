"""What the hairs of a tuft are: how many, how thick, how they hold together."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

from paint3d.core.arrays import as_number
from paint3d.errors import BrushError

__all__ = [
    "MOST_HAIRS", "SHAPE_COLUMNS", "TABLES", "BristleSpec", "ShapeRows", "hair_ranges",
    "shape_rows",
]  # fmt: skip

MOST_HAIRS = 10_000
TABLES = ("energy", "measured")

SHAPE_COLUMNS = ("angle", "height", "offset", "imprint", "upper", "lower", "spread")
"""What a row of measured shapes holds: the handle's angle from the upright (degrees), the root's
height over that of the straight hair, and in hair lengths how far the tip lies ahead of where the
handle's axis meets the paper, the imprint, and the control lengths of the cubic Bezier curve along
the handle and along the paper; the hairs' spread (degrees)."""

ShapeRows = tuple[tuple[float, ...], ...]

_SHAPE_RANGES = (
    (0.0, 60.0),
    (0.0, 1.0),
    (-1.0, 1.5),
    (0.0, 1.5),
    (0.0, 2.0),
    (0.0, 2.0),
    (0.0, 90.0),
)
_MOST_SHAPES = 1000

_RANGES = {
    "hair_mm": (0.01, 2.0),
    "film": (0.0, 0.2),
    "threshold_mm": (0.0, 1.0),
    "unevenness": (0.0, 0.2),
    "parting": (0.0, 1.0),
    "splay": (0.0, 1.0),
    "appetite": (0.0, 0.95),
    "levelling_mm": (0.1, 1e4),
    "set_share": (0.001, 0.5),
}


def hair_ranges() -> dict[str, tuple[float, float]]:
    """Least and greatest value of every number of the hairs."""
    return {"n_hairs": (1.0, float(MOST_HAIRS)), **_RANGES}


@dataclasses.dataclass(frozen=True, slots=True)
class BristleSpec:
    """A tuft of single hairs, checked.

    Parameters
    ----------
    n_hairs : int
        1 to 10,000.
    table : {"energy", "measured"} or rows of numbers
        Where bent shapes come from: the least bending energy of the brush, the shapes measured on a
        real brush (FastBrush), or those of one's own: rows of `SHAPE_COLUMNS`.
    hair_mm : float
        Thickness of a dry hair, mm.
    film : float
        Ink around a full hair on either side, as a share of the tuft's diameter at the root; hairs
        closer than that flow together.
    threshold_mm : float
        How near the surface a hair must be to leave ink, mm.
    unevenness : float
        How much shorter than the longest hair the shortest is, as a share.
    parting : float
        How far the clumps of a dry tuft part, 0 to 1.
    splay : float
        How far the hairs of a dry tuft lie side by side instead of coming to a point, 0 to 1.
    appetite : float
        How differently hairs give, 0 (all alike) to 1.
    levelling_mm : float
        Way over which neighbouring wet hairs share their ink, mm.
    set_share : float
        Descent over which a remembered bend is pressed out, of the tuft's length.

    Raises
    ------
    BrushError
        Naming the parameter, what was got and what was expected.
    """

    n_hairs: int = 1000
    table: str | ShapeRows = "energy"
    hair_mm: float = 0.12
    film: float = 0.011
    threshold_mm: float = 0.15
    unevenness: float = 0.02
    parting: float = 0.9
    splay: float = 0.85
    appetite: float = 0.6
    levelling_mm: float = 30.0
    set_share: float = 0.06

    def __post_init__(self) -> None:
        count = as_number(self.n_hairs, "n_hairs", 1, MOST_HAIRS, BrushError)
        if count != int(count):
            raise BrushError(f"n_hairs is {self.n_hairs}; expected a whole number")
        object.__setattr__(self, "n_hairs", int(count))
        if isinstance(self.table, list | tuple):
            object.__setattr__(self, "table", shape_rows(self.table))
        elif self.table not in TABLES:
            raise BrushError(
                f"table is {self.table!r:.60}; expected {', '.join(TABLES)} or rows of numbers"
            )
        for name, (low, high) in _RANGES.items():
            as_number(getattr(self, name), name, low, high, BrushError)


def shape_rows(rows: Any) -> ShapeRows:
    """Measured shapes, checked and in order: by angle, and the straight hair first.

    Parameters
    ----------
    rows : sequence of sequences of 7 numbers
        `SHAPE_COLUMNS`. An angle without a row of height 1 is given one: the straight hair.

    Raises
    ------
    BrushError
        Naming the row and the column, what was got and what was expected.
    """
    if not isinstance(rows, list | tuple):
        raise BrushError(f"table is {rows!r:.60}; expected rows of numbers")
    if not 1 <= len(rows) <= _MOST_SHAPES:
        raise BrushError(f"table has {len(rows)} rows; expected 1 to {_MOST_SHAPES}")
    checked = set()
    for k, row in enumerate(rows, 1):
        if not isinstance(row, list | tuple) or len(row) != len(SHAPE_COLUMNS):
            raise BrushError(
                f"table: row {k} is {row!r:.60}; expected 7 numbers: {', '.join(SHAPE_COLUMNS)}"
            )
        named = zip(SHAPE_COLUMNS, row, _SHAPE_RANGES, strict=True)
        checked.add(
            tuple(as_number(x, f"table: row {k}: {what}", *r, BrushError) for what, x, r in named)
        )
    checked |= {(angle, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0) for angle, height, *_ in checked} - {
        (angle, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0) for angle, height, *_ in checked if height == 1.0
    }
    ordered = tuple(sorted(checked, key=lambda row: (row[0], -row[1])))
    for one, other in itertools.pairwise(ordered):
        if one[:2] == other[:2]:
            raise BrushError(
                f"table has two rows of angle {one[0]:g} and height {one[1]:g}; expected one"
            )
    for angle in {row[0] for row in ordered}:
        if sum(row[0] == angle for row in ordered) < 2:
            raise BrushError(f"table has no bent hair of angle {angle:g}; expected heights below 1")
    return ordered
