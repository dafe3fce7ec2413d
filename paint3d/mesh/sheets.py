"""Sheets to write and paint on: their forms and sizes, and the names that say them.

A name is a form, then what is otherwise than usual, after colons: ``scroll``, ``scroll:340x1000``,
``sheet:340x1360:mounted``, ``square:690:margin=40``. `Sheet.name` says a sheet in the same words.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from paint3d.errors import InputError

__all__ = ["FORMS", "Form", "Sheet", "is_sheet", "parse_sheet"]

_LEAST_MM, _MOST_MM = 10.0, 5000.0
_DETAIL_MM, _COARSER_MM, _LARGE_MM = 0.4, 0.6, 1000.0
_FINEST_MM, _ACROSS = 0.15, 600.0  # of small sheets: so many vertices along the longer side
_SIZE = re.compile(r"(\d+(?:\.\d+)?)(?:x(\d+(?:\.\d+)?))?")


@dataclass(frozen=True)
class Form:
    """Usual dimensions and materials of sheets of one form.

    Attributes
    ----------
    chinese : str
    shape : {"rectangle", "disc", "sector"}
        A sector is the leaf of a folding fan, a part of a ring.
    width_mm, height_mm : float
        Of one panel. A disc's are its diameter; a sector's its chord and its breadth along a rib.
    margin_mm : float
        Kept free by text.
    material : str
        That suits it.
    mount : {"scroll", "board"}
        Silk with rods above and below it, or a border all round.
    panels : int
        Side by side, written from the right.
    """

    chinese: str
    shape: str
    width_mm: float
    height_mm: float
    margin_mm: float
    material: str
    mount: str = "board"
    panels: int = 1


FORMS: Mapping[str, Form] = {
    "scroll": Form("条幅", "rectangle", 340.0, 1380.0, 35.0, "xuan", "scroll"),
    "couplet": Form("对联", "rectangle", 340.0, 1380.0, 35.0, "tinted xuan", "scroll", 2),
    "square": Form("斗方", "rectangle", 340.0, 340.0, 25.0, "xuan"),
    "horizontal": Form("横幅", "rectangle", 1380.0, 340.0, 35.0, "xuan"),
    "fan": Form("折扇", "sector", 510.0, 170.0, 10.0, "sized xuan"),
    "round-fan": Form("团扇", "disc", 250.0, 250.0, 20.0, "silk"),
    "album": Form("册页", "rectangle", 460.0, 340.0, 25.0, "sized xuan"),
    "handscroll": Form("手卷", "rectangle", 2000.0, 300.0, 25.0, "xuan"),
    "a4": Form("A4", "rectangle", 210.0, 297.0, 15.0, "xuan"),
    "a3": Form("A3", "rectangle", 297.0, 420.0, 20.0, "xuan"),
    "sheet": Form("纸", "rectangle", 340.0, 690.0, 25.0, "xuan"),
}
"""Forms by name; docs/materials.md says where the sizes are from."""


@dataclass(frozen=True)
class Sheet:
    """A sheet of a form, of a size.

    Raises
    ------
    InputError
        If the form is not known, or a length is out of its range.
    """

    form: str
    width_mm: float
    height_mm: float
    margin_mm: float
    mounted: bool = False

    def __post_init__(self) -> None:
        if self.form not in FORMS:
            raise InputError(
                "no sheet is called {form!r}; expected {forms}",
                form=self.form,
                forms=", ".join(FORMS),
            )
        if not all(_LEAST_MM <= mm <= _MOST_MM for mm in (self.width_mm, self.height_mm)):
            raise InputError(
                "a sheet of {width:g} x {height:g} mm; expected {least:g} to {most:g} mm a side",
                width=self.width_mm,
                height=self.height_mm,
                least=_LEAST_MM,
                most=_MOST_MM,
            )
        most = 0.5 * min(self.width_mm, self.height_mm) - 1.0
        if not 0.0 <= self.margin_mm <= most:
            raise InputError(
                "a margin of {margin_mm:g} mm on a sheet of {width_mm:g} x {height_mm:g} mm; "
                "expected 0 to {most:g} mm",
                margin_mm=self.margin_mm,
                width_mm=self.width_mm,
                height_mm=self.height_mm,
                most=most,
            )
        shape = FORMS[self.form].shape
        if shape == "disc" and self.width_mm != self.height_mm:
            raise InputError("a round fan is as high as it is wide; expected one number")
        if shape == "sector" and self.height_mm > 0.45 * self.width_mm:
            raise InputError(
                "a fan's leaf of {height_mm:g} mm is too broad for {width_mm:g} mm; expected at "
                "most {most:g} mm",
                height_mm=self.height_mm,
                width_mm=self.width_mm,
                most=0.45 * self.width_mm,
            )

    @property
    def usual(self) -> Form:
        """Usual values of its form."""
        return FORMS[self.form]

    @property
    def name(self) -> str:
        """Name that `parse_sheet` makes the same sheet of."""
        usual, words = self.usual, [self.form]
        if self.form == "sheet" or self.size != (usual.width_mm, usual.height_mm):
            one = usual.shape == "disc"
            words.append(f"{self.width_mm:g}" + ("" if one else f"x{self.height_mm:g}"))
        if self.margin_mm != _margin(usual, self.size):
            words.append(f"margin={self.margin_mm:g}")
        return ":".join(words + ["mounted"] * self.mounted)

    @property
    def detail_mm(self) -> float:
        """Distance of vertices that suits it, mm: its characters grow with it."""
        longest = max(self.size)
        if longest >= _LARGE_MM:
            return _COARSER_MM
        return min(_DETAIL_MM, max(_FINEST_MM, round(longest / _ACROSS, 2)))

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of one panel, mm."""
        return self.width_mm, self.height_mm


def _margin(usual: Form, size: tuple[float, float]) -> float:
    """The margin of a sheet where none is said: the form's, narrower on a small one."""
    usual_side = min(usual.width_mm, usual.height_mm)
    return float(math.floor(usual.margin_mm * min(1.0, min(size) / usual_side)))


def is_sheet(name: str) -> bool:
    """Whether a name says a sheet, were its numbers out of range."""
    return name.split(":")[0] in FORMS


def parse_sheet(name: str) -> Sheet:
    """The sheet that a name says.

    Raises
    ------
    InputError
        If it says none, or a length is out of its range.
    """
    form, *words = name.split(":")
    if form not in FORMS:
        raise InputError(
            "no sheet is called {form!r}; expected {forms}",
            form=form,
            forms=", ".join(FORMS),
        )
    usual = FORMS[form]
    size, margin, mounted = (usual.width_mm, usual.height_mm), None, False
    for word in words:
        found = _SIZE.fullmatch(word)
        if found:
            width = float(found[1])
            size = width, float(found[2]) if found[2] else width
        elif word.startswith("margin=") and _SIZE.fullmatch(word[7:]):
            margin = float(word[7:].split("x")[0])
        elif word == "mounted":
            mounted = True
        else:
            raise InputError(
                "{name}: {word!r} is no option of a sheet; expected WIDTHxHEIGHT in mm, "
                "margin=MM or mounted",
                name=name,
                word=word,
            )
    if form == "sheet" and not any(map(_SIZE.fullmatch, words)):
        raise InputError("{name}: no size is given; expected sheet:WIDTHxHEIGHT in mm", name=name)
    return Sheet(form, *size, _margin(usual, size) if margin is None else margin, mounted)
