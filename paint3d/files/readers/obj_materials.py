"""Diffuse colours and pictures of OBJ materials (.mtl), face by face."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.files.readers.contents import plain_text, read_beside
from paint3d.files.readers.textures import REPEAT, Look, linear_from_srgb, open_picture

__all__ = ["ObjLooks", "names_materials", "obj_looks"]

MAX_LIBRARY = 1 << 26
OPTIONS = {"-s": 3, "-o": 3, "-t": 3, "-mm": 2, "-bm": 1, "-texres": 1, "-clamp": 1, "-boost": 1}
OPTIONS |= {"-blendu": 1, "-blendv": 1, "-cc": 1, "-imfchan": 1, "-type": 1}  # and their words


LEFT_OUT = {  # what of a material is left out, by the words that begin its lines
    b"bump": "relief (a bump map)",
    b"map_bump": "relief (a bump map)",
    b"norm": "relief (a normal map)",
    b"map_d": "transparency",
    b"map_ks": "gloss from a picture",
    b"map_ke": "light of its own",
    b"disp": "displacement",
}


@dataclass
class Material:
    """A material's colour, and the picture that replaces it."""

    diffuse: tuple[float, float, float] = (1.0, 1.0, 1.0)
    picture: NDArray[np.uint8] | None = None
    clamped: bool = False

    def look(self) -> Look:
        """What is seen of it."""
        if self.picture is not None:
            return Look(picture=self.picture, wrap=("clamp", "clamp") if self.clamped else REPEAT)
        codes = np.floor(255.0 * np.clip(self.diffuse, 0.0, 1.0) + 0.5).astype(np.uint8)
        red, green, blue = linear_from_srgb(codes).tolist()
        return Look((red, green, blue))


@dataclass(frozen=True)
class ObjLooks:
    """What an OBJ file says of its colours; see `RawMesh` for looks, look_of, uv and notes.

    Attributes
    ----------
    dropped : frozenset of str
        What its materials say and paint3d does not take.
    """

    looks: tuple[Look, ...]
    look_of: NDArray[np.int64]
    uv: NDArray[np.float64]
    notes: tuple[str, ...]
    dropped: frozenset[str]


def obj_looks(lines: Sequence[bytes], sizes: NDArray[np.int64], folder: Path) -> ObjLooks:
    """Return the looks of an OBJ's faces; none where it names no material that could be read.

    A texture replaces the diffuse colour.

    Parameters
    ----------
    lines : sequence of bytes
        Of the OBJ file, stripped.
    sizes : (P,) int64
        Corners of each face.
    folder : Path
        Of the file; material libraries and pictures elsewhere are not followed.
    """
    notes: list[str] = []
    dropped: set[str] = set()
    materials: dict[bytes, Material] = {}
    for line in lines:
        if line.startswith(b"mtllib "):
            _read_library(_name(line[7:]), folder, materials, notes, dropped)
    names = {name: k for k, name in enumerate(materials)}
    look_of, places = _by_face(lines, names, int(sizes.sum()))
    told = tuple(dict.fromkeys(notes)), frozenset(dropped)
    if not (look_of >= 0).any():
        return ObjLooks((), look_of, np.empty((0, 2)), *told)
    written = [line[3:].split()[:2] for line in lines if line[:3] == b"vt "]
    table = [[*map(float, words), 0.0, 0.0][:2] for words in written]
    known = np.array([*table, [np.nan, np.nan]], np.float64)
    known = known * (1.0, -1.0) + (0.0, 1.0)  # OBJ counts from the lower left
    uv = known[np.where(places < len(table), places, -1)]
    looks = tuple(material.look() for material in materials.values())
    return ObjLooks(looks, look_of, uv, *told)


def names_materials(lines: Sequence[bytes]) -> bool:
    """Whether an OBJ file has colours in a material library."""
    kinds = {line.partition(b" ")[0] for line in lines}
    return {b"mtllib", b"usemtl"} <= kinds


def _name(words: bytes) -> str:
    return words.strip().decode("utf-8", "surrogateescape")


def _by_face(
    lines: Sequence[bytes], names: dict[bytes, int], n_corners: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return each face's material (-1: none) and each corner's texture place (-1: none)."""
    look, looks = -1, []
    places = np.full(n_corners, -1, np.int64)
    so_far = at = 0
    for line in lines:
        if line[:3] == b"vt ":
            so_far += 1
        elif line.startswith(b"usemtl"):
            look = names.get(line[6:].strip(), -1)
        elif line[:2] == b"f ":
            looks.append(look)
            for corner in line[2:].split():
                rest = corner.partition(b"/")[2]
                if rest and look >= 0:
                    places[at] = _index(rest.partition(b"/")[0], so_far)
                at += 1
    return np.array(looks, np.int64), places


def _index(word: bytes, so_far: int) -> int:
    try:
        index = int(word)
    except ValueError:
        return -1
    return index - 1 if index > 0 else max(so_far + index, -1)


def _read_library(
    name: str,
    folder: Path,
    materials: dict[bytes, Material],
    notes: list[str],
    dropped: set[str],
) -> None:
    try:
        text = plain_text(read_beside(folder, name, MAX_LIBRARY))
    except MeshError as cause:
        notes.append(f"materials are left out: {cause}")
        return
    material = Material()
    for line in text.split(b"\n"):
        words = line.split()
        if words[:1] == [b"newmtl"]:
            material = materials.setdefault(line.strip()[6:].strip(), Material())
        elif words[:1] == [b"Kd"] and len(words) >= 4:
            material.diffuse = _diffuse(words[1:4], material.diffuse)
        elif words[:1] == [b"map_Kd"]:
            try:
                picture = open_picture(read_beside(folder, _picture_name(words[1:], line)))
                material.picture = picture
                material.clamped = b"-clamp on" in line
            except MeshError as cause:
                notes.append(f"a texture is left out: {cause}")
        elif words and words[0].lower() in LEFT_OUT:
            dropped.add(LEFT_OUT[words[0].lower()])
        elif words[:1] == [b"d"] and _part(words[1:2]) < 1.0:
            dropped.add("transparency")


def _part(words: list[bytes]) -> float:
    try:
        return float(words[0])
    except (ValueError, IndexError):
        return 1.0


def _diffuse(
    words: list[bytes], otherwise: tuple[float, float, float]
) -> tuple[float, float, float]:
    try:
        red, green, blue = (float(word) for word in words)
    except ValueError:
        return otherwise
    return (red, green, blue) if np.isfinite((red, green, blue)).all() else otherwise


def _picture_name(words: list[bytes], line: bytes) -> str:
    """Return the file name after a map's options; it may hold spaces."""
    at = 0
    while at < len(words) and words[at].decode("ascii", "replace") in OPTIONS:
        at += 1 + OPTIONS[words[at].decode("ascii")]
    if at >= len(words):
        raise MeshError(f"it names no picture in {line[:60]!r}")
    return _name(line[line.find(words[at], len(b"map_Kd")) :])
