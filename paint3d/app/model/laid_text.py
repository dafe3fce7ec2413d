"""Texts that lie on an object to be written after: what they say, where, how large, how turned.

They belong to the painting: laying, moving and removing one is a step that undo takes back, and
scores, journals and sessions hold them in the words of `LaidText.words`.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from paint3d.brush.presets import brush_for
from paint3d.calligraphy.layout import LAYOUTS, LEAST_EM_MM, MOST_EM_MM, Layout
from paint3d.core.arrays import as_array, as_number
from paint3d.errors import InputError

__all__ = ["GRIDS", "LaidText", "pack_texts", "unpack_texts"]

GRIDS = ("frame", "mi", "jiu", "tian", "columns", "none")
"""What is drawn around characters: their squares alone; with a cross and diagonals (米字格), nine
fields (九宮格), or a cross (田字格); lines between columns or rows; nothing."""

_MOST_GAP = 5.0  # ems
_MOST_STROKES = 1_000_000_000
_LONGEST, _MOST_TEXTS, _MOST_CELLS = 2000, 50, 40


@dataclass(frozen=True)
class LaidText:
    """A text, or an empty grid, as it lies on an object.

    Attributes
    ----------
    text : str
        A line break starts a new column or row. Empty for a grid alone.
    em_mm : float
        Side of a character's square, mm.
    font : str
        Of the system; empty for known characters.
    order : {"columns", "row"}
    point : (float, float, float), optional
        Where its middle is, mm; by default where it fits.
    turn : float
        To the left, degrees.
    gap, between : float
        Room between columns, or rows, and between the characters of one, ems.
    grid : str
        One of `GRIDS`.
    cells : (int, int)
        Squares of a grid alone: across and down.
    is_signature : bool
        Whether it says who wrote the others.
    n_before : int
        Strokes that were there when it was laid: they are no writing of it.
    around : bool
        Whether it is spread all around the body.

    Raises
    ------
    InputError
        Naming what was got and what was expected.
    """

    text: str = ""
    em_mm: float = 40.0
    font: str = ""
    order: str = "columns"
    point: tuple[float, float, float] | None = None
    turn: float = 0.0
    gap: float = 0.1
    between: float = 0.0
    grid: str = "frame"
    cells: tuple[int, int] = (4, 5)
    is_signature: bool = False
    n_before: int = 0
    around: bool = False

    def __post_init__(self) -> None:
        for name in ("text", "font"):
            value = getattr(self, name)
            if not isinstance(value, str) or len(value) > _LONGEST:
                raise InputError(
                    "{name} is {value}; expected up to {most} characters",
                    name=name,
                    value=f"{value!r:.40}",
                    most=_LONGEST,
                )
        for name, known in (("order", LAYOUTS), ("grid", GRIDS)):
            if getattr(self, name) not in known:
                raise InputError(
                    "{name} is {value!r}; expected {known}",
                    name=name,
                    value=getattr(self, name),
                    known=" or ".join(known),
                )
        for name, low, high in (
            ("em_mm", LEAST_EM_MM, MOST_EM_MM), ("turn", -180.0, 180.0),
            ("gap", 0.0, _MOST_GAP), ("between", 0.0, _MOST_GAP),
        ):  # fmt: skip
            number = as_number(getattr(self, name), name, low, high)
            object.__setattr__(self, name, number)
        if self.point is not None:
            x, y, z = as_array(self.point, "point", (3,)).tolist()
            object.__setattr__(self, "point", (x, y, z))
        cells = tuple(self.cells)
        if len(cells) != 2 or not all(type(n) is int and 1 <= n <= _MOST_CELLS for n in cells):
            raise InputError(
                "cells are {cells}; expected two counts to {most}",
                cells=f"{self.cells!r:.40}",
                most=_MOST_CELLS,
            )
        object.__setattr__(self, "cells", cells)
        for name in ("is_signature", "around"):
            if not isinstance(getattr(self, name), bool):
                raise InputError(
                    "{name} is {value}; expected true or false",
                    name=name,
                    value=f"{getattr(self, name)!r:.40}",
                )
        if type(self.n_before) is not int or not 0 <= self.n_before <= _MOST_STROKES:
            raise InputError(
                "n_before is {value}; expected a count of strokes",
                value=f"{self.n_before!r:.40}",
            )

    @property
    def layout(self) -> Layout:
        """Layout of the text; around an object it lies level."""
        return Layout(
            self.order, gap=self.gap, between=self.between, point=self.point,
            turn=0.0 if self.around else self.turn, around=self.around,
            brush_mm=brush_for(self.em_mm).length_mm,
        )  # fmt: skip

    def words(self) -> dict[str, Any]:
        """Dictionary from which `of` makes the same text, for JSON; without defaults."""
        usual = LaidText()
        values = {one.name: getattr(self, one.name) for one in dataclasses.fields(self)}
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in values.items()
            if value != getattr(usual, name)
        }

    @classmethod
    def of(cls, words: Mapping[str, Any]) -> LaidText:
        """The text that words say.

        Raises
        ------
        InputError
            If they say none.
        """
        if not isinstance(words, Mapping):
            raise InputError(
                "a text is {words}; expected what it says by names", words=f"{words!r:.40}"
            )
        unknown = set(words) - {one.name for one in dataclasses.fields(cls)}
        if unknown:
            raise InputError(
                "a text has {names}; none is known", names=", ".join(sorted(map(str, unknown)))
            )
        try:
            return cls(**words)
        except TypeError as cause:
            raise InputError("a text is incomplete: {cause}", cause=cause) from None

    def moved(self, **changes: Any) -> LaidText:
        """The same with other values."""
        return dataclasses.replace(self, **changes)


def pack_texts(texts: Iterable[LaidText]) -> str:
    """Texts as one line of JSON."""
    return json.dumps([text.words() for text in texts], ensure_ascii=False)


def unpack_texts(packed: object) -> tuple[LaidText, ...]:
    """The texts of such a line, or of the list that it holds.

    Raises
    ------
    InputError
        If it holds something else.
    """
    try:
        rows = json.loads(packed) if isinstance(packed, str) else packed
    except ValueError:
        rows = None
    if not isinstance(rows, list) or len(rows) > _MOST_TEXTS:
        raise InputError(
            "texts are {packed}; expected a list of up to {most}",
            packed=f"{packed!r:.40}",
            most=_MOST_TEXTS,
        )
    return tuple(map(LaidText.of, rows))
