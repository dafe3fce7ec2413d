"""What the triangles of 3MF parts look like: colour groups, base materials, textures."""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Sequence
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.files.readers.textures import Look, open_picture

__all__ = ["CORE", "Paint3mf", "Seen"]

CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
MATERIAL = "{http://schemas.microsoft.com/3dmanufacturing/material/2015/02}"
LEFT_OUT = {
    f"{MATERIAL}compositematerials": "mixtures of materials",
    f"{MATERIAL}multiproperties": "mixtures of materials",
}
TILED = {"wrap": "repeat", "mirror": "mirror", "clamp": "clamp", "none": "clamp"}


class Seen(NamedTuple):
    """What the triangles of a mesh look like.

    Attributes
    ----------
    colours : (3 T, 3) float64 or None
        sRGB codes of the corners, white where nothing is said.
    coloured : (T,) bool
        Which triangles have colours of their own.
    look_of : (T,) int64
        -1 for none.
    uv : (3 T, 2) float64
        Places on the pictures, from the upper left; nan where there are none.
    """

    colours: NDArray[np.float64] | None
    coloured: NDArray[np.bool_]
    look_of: NDArray[np.int64]
    uv: NDArray[np.float64]


class _Group(NamedTuple):
    values: NDArray[np.float64]  # colours (N, 3), or places on a picture (N, 2)
    look: int  # -1: colours


class Paint3mf:
    """The colours and pictures of a package's parts.

    Parameters
    ----------
    read_part : callable
        Returns the bytes of a part of the package by its name; raises MeshError.
    texture : bool
        Whether pictures are read.

    Attributes
    ----------
    notes : list of str
        Pictures that could not be read, and why.
    dropped : set of str
        What is said and not taken.
    looks : list of Look
    """

    def __init__(self, read_part: Callable[[str], bytes], texture: bool) -> None:
        self.notes: list[str] = []
        self.dropped: set[str] = set()
        self.looks: list[Look] = []
        self._read_part, self._texture = read_part, texture
        self._groups: dict[str, dict[str | None, _Group]] = {}

    def see(
        self,
        part: str,
        model: ElementTree.Element,
        solid: ElementTree.Element,
        triangles: Sequence[ElementTree.Element],
    ) -> Seen:
        """Return what an object's triangles look like.

        Raises
        ------
        MeshError
            If one refers to a colour or a place on a picture that its group does not have.
        """
        groups = self._of_part(part, model)
        colours = np.full((len(triangles), 3, 3), 255.0)
        coloured = np.zeros(len(triangles), np.bool_)
        look_of = np.full(len(triangles), -1)
        uv = np.full((len(triangles), 3, 2), np.nan)
        otherwise = solid.get("pid"), solid.get("pindex", "0")
        for k, triangle in enumerate(triangles):
            number = triangle.get("pid", otherwise[0])
            group = groups.get(number)
            if group is None:
                continue
            first = triangle.get("p1", otherwise[1])
            rows = [_index(triangle.get(p, first), group, number) for p in ("p1", "p2", "p3")]
            if group.look < 0:
                colours[k], coloured[k] = group.values[rows], True
            else:
                uv[k], look_of[k] = group.values[rows], group.look
        return Seen(
            colours.reshape(-1, 3) if coloured.any() else None, coloured, look_of,
            uv.reshape(-1, 2),
        )  # fmt: skip

    def _of_part(self, part: str, model: ElementTree.Element) -> dict[str | None, _Group]:
        """Groups of one model part, by resource id; those that are not taken are missing."""
        if part not in self._groups:
            tags = {element.tag for element in model.iterfind(f"{CORE}resources/*")}
            self.dropped |= {what for tag, what in LEFT_OUT.items() if tag in tags}
            self._groups[part] = {**_palettes(model), **self._pictures(model)}
        return self._groups[part]

    def _pictures(self, model: ElementTree.Element) -> dict[str | None, _Group]:
        found = list(model.iter(f"{MATERIAL}texture2dgroup"))
        if found and not self._texture:
            self.dropped.add("its pictures")
            return {}
        textures = {texture.get("id"): texture for texture in model.iter(f"{MATERIAL}texture2d")}
        looks = {id: self._look(textures.get(id)) for id in {one.get("texid") for one in found}}
        groups = {}
        for group in found:
            look = looks[group.get("texid")]
            if look >= 0:
                places = [[entry.get(axis, "nan") for axis in "uv"] for entry in group]
                uv = np.array(places, np.float64).reshape(-1, 2)
                groups[group.get("id")] = _Group(uv * (1.0, -1.0) + (0.0, 1.0), look)  # from below
        return groups

    def _look(self, texture: ElementTree.Element | None) -> int:
        """Place of a texture among the looks; -1 where it cannot be read."""
        try:
            if texture is None:
                raise MeshError("it refers to one that it does not contain")
            part = posixpath.join("/", texture.get("path", ""))
            picture = open_picture(self._read_part(part))
        except MeshError as cause:
            self.notes.append(f"a texture is left out: {cause}")
            return -1
        u, v = (TILED.get(texture.get(f"tilestyle{axis}", "wrap"), "repeat") for axis in "uv")
        self.looks.append(Look(picture=picture, wrap=(u, v)))
        return len(self.looks) - 1


def _index(text: str, group: _Group, number: str | None) -> int:
    index = int(text)
    if not 0 <= index < len(group.values):
        what = "colour" if group.look < 0 else "place on a picture"
        n = len(group.values)
        raise MeshError(
            f"a triangle has {what} {index} of resource {number}, which has {n}; "
            f"expected 0 to {n - 1}"
        )
    return index


def _palettes(model: ElementTree.Element) -> dict[str | None, _Group]:
    """Return the sRGB codes of every colour group and base material list, by resource id."""
    palettes = {}
    kinds = ((f"{MATERIAL}colorgroup", "color"), (f"{CORE}basematerials", "displaycolor"))
    for tag, attribute in kinds:
        for group in model.iter(tag):
            codes = [_hex(entry.get(attribute)) for entry in group]
            palettes[group.get("id")] = _Group(np.array(codes, np.float64).reshape(-1, 3), -1)
    return palettes


def _hex(text: str | None) -> tuple[int, int, int]:
    code = (text or "").strip().lstrip("#")
    try:
        if len(code) not in (6, 8):
            raise ValueError
        return int(code[0:2], 16), int(code[2:4], 16), int(code[4:6], 16)
    except ValueError:
        raise MeshError(f"a colour is {text!r:.40}; expected #RRGGBB") from None
