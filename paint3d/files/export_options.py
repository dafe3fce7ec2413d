"""Options of an export, checked before any work."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from paint3d.colour.viewing import Viewing
from paint3d.core.arrays import as_number
from paint3d.errors import ExportError, InputError, UnknownNameError
from paint3d.files.load import UNITS_MM

__all__ = ["MOST_FILAMENTS", "UP_AXES", "ExportOptions"]

UP_AXES = ("y", "z")
MOST_FILAMENTS = 64
TEXTURE_SIZES = (16, 16384)
_WISHES = ("unit", "up_axis", "unlit", "texture", "filaments", "packed_normals", "size", "gamut")
HEX = re.compile(r"#?([0-9a-fA-F]{6})")


@dataclass(frozen=True)
class ExportOptions:
    """Options of a file; None stands for the format's default.

    Attributes
    ----------
    tolerance : float
        dE00 by which a colour may be missed where vertices that were added for painting are left
        out again; at least 0.
    exact : bool
        Leave no vertex out.
    unit : {"mm", "cm", "m", "in"} or None
        Length of one unit in the file.
    up_axis : {"y", "z"} or None
        The axis of the file that points up; in paint3d it is z.
    unlit : bool
        Show the colours as they are, without light (glTF).
    texture : bool or int
        Bake the colours into a texture (glTF): True, or the pixels of its longer side.
    filaments : int, sequence of str, or None
        Reduce the colours to one of these for each triangle: how many, or their sRGB as hex.
    packed_normals : bool
        Write the paper's seven numbers a vertex, with one for the normal, instead of nine.
    size : (int, int) or None
        Width and height of a picture, pixels.
    viewing : Viewing or None
        In which light, by which observer and for which screen the colours are to be.
    note : str
        What a page that shows the object says below it (HTML).

    Raises
    ------
    InputError
        If a value is not possible, or two exclude each other.
    """

    tolerance: float = 1.0
    exact: bool = False
    unit: str | None = None
    up_axis: str | None = None
    unlit: bool = False
    texture: bool | int = False
    filaments: int | Sequence[str] | None = None
    packed_normals: bool = False
    size: tuple[int, int] | None = None
    viewing: Viewing | None = None
    note: str = ""

    @property
    def gamut(self) -> str | None:
        """The screen's gamut where it is not that of sRGB."""
        viewing = self.viewing
        return None if viewing is None or viewing.gamut == "srgb" else viewing.gamut

    def __post_init__(self) -> None:
        as_number(self.tolerance, "tolerance (dE00)", low=0.0)
        if self.unit is not None and self.unit not in UNITS_MM:
            raise UnknownNameError("unit", str(self.unit), UNITS_MM)
        if self.up_axis is not None and self.up_axis not in UP_AXES:
            raise UnknownNameError("up axis", str(self.up_axis), UP_AXES)
        if not isinstance(self.texture, bool):
            as_number(self.texture, "texture (pixels)", *TEXTURE_SIZES)
        if self.filaments is not None:
            _check_filaments(self.filaments)
            if self.texture:
                raise InputError("texture and filaments exclude each other; expected one of them")

    def refuse_others(self, takes: frozenset[str], suffix: str, formats: dict[str, str]) -> None:
        """Refuse options that a format does not support.

        Parameters
        ----------
        takes : set of str
            The wishes that the format knows.
        suffix : str
            Of the format.
        formats : dict
            For each wish the suffixes of the formats that know it.

        Raises
        ------
        ExportError
            For the first wish that it does not know.
        """
        for wish in _WISHES:
            if getattr(self, wish) not in (None, False) and wish not in takes:
                raise ExportError(
                    "{suffix} files cannot have {wish}; expected one of {formats}",
                    suffix=suffix,
                    wish=wish.replace("_", " "),
                    formats=formats[wish],
                )


def _check_filaments(filaments: int | Sequence[str]) -> None:
    if isinstance(filaments, int) and not isinstance(filaments, bool):
        as_number(filaments, "filaments", 1, MOST_FILAMENTS)
        return
    if isinstance(filaments, str | bytes) or not isinstance(filaments, Sequence):
        raise InputError(
            "filaments is {filaments!r:.60}; expected how many, or a list of colours like #2B1F1A",
            filaments=filaments,
        )
    as_number(len(filaments), "the number of filaments", 1, MOST_FILAMENTS)
    for colour in filaments:
        if not isinstance(colour, str) or not HEX.fullmatch(colour):
            raise InputError(
                "filament {colour!r:.60} is not a colour; expected one like #2B1F1A",
                colour=colour,
            )
