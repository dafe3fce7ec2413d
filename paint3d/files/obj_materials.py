"""Diffuse colours of OBJ materials (.mtl), read at the vertices."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.files.contents import plain_text, read_beside
from paint3d.files.textures import (
    linear_from_srgb,
    open_picture,
    sample_picture,
    srgb_from_linear,
)

__all__ = ["obj_colours"]

MAX_LIBRARY = 1 << 26
OPTIONS = {"-s": 3, "-o": 3, "-t": 3, "-mm": 2, "-bm": 1, "-texres": 1, "-clamp": 1, "-boost": 1}
OPTIONS |= {"-blendu": 1, "-blendv": 1, "-cc": 1, "-imfchan": 1, "-type": 1}  # and their words


@dataclass
class Material:
    """A material's colour, and the picture that replaces it."""

    diffuse: tuple[float, float, float] = (1.0, 1.0, 1.0)
    picture: NDArray[np.uint8] | None = None


def obj_colours(
    lines: Sequence[bytes], n_vertices: int, folder: Path
) -> tuple[NDArray[np.uint8] | None, list[str]]:
    """Return the mean sRGB colour (V, 3) of each vertex's corners, and notes on what is left out.

    A texture replaces the diffuse colour. Vertices that no face uses are white. None where the
    file names no material that could be read.

    Parameters
    ----------
    lines : sequence of bytes
        Of the OBJ file, stripped.
    n_vertices : int
        V.
    folder : Path
        Of the file; material libraries and pictures elsewhere are not followed.
    """
    notes: list[str] = []
    materials: dict[bytes, Material] = {}
    places = [line[3:].split()[:2] for line in lines if line[:3] == b"vt "]
    uv = np.array([(*map(float, words), 0.0)[:2] for words in places], np.float64).reshape(-1, 2)
    for line in lines:
        if line.startswith(b"mtllib "):
            _read_library(_name(line[7:]), folder, materials, notes)
    total, count = np.zeros((n_vertices, 3)), np.zeros(n_vertices)
    for name, vertices, places in _corners(lines, n_vertices, len(uv)):
        if name not in materials:
            continue
        colours = _corner_colours(materials[name], uv, places)
        for channel in range(3):
            total[:, channel] += np.bincount(vertices, colours[:, channel], n_vertices)
        count += np.bincount(vertices, minlength=n_vertices)
    if not count.any():
        return None, notes
    mean = np.where(count[:, None] > 0, total / np.maximum(count, 1.0)[:, None], 1.0)
    return srgb_from_linear(mean), notes


def _name(words: bytes) -> str:
    return words.strip().decode("utf-8", "surrogateescape")


def _corner_colours(
    material: Material, uv: NDArray[np.float64], places: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return linear colours (N, 3) at corners with these texture places (N,), -1: none."""
    codes = np.floor(255.0 * np.clip(material.diffuse, 0.0, 1.0) + 0.5).astype(np.uint8)
    colours = np.tile(linear_from_srgb(codes), (len(places), 1))
    if material.picture is not None:
        known = places >= 0
        flipped = uv[places[known]] * (1.0, -1.0) + (0.0, 1.0)  # OBJ counts from the lower left
        colours[known] = sample_picture(material.picture, flipped)
    return colours


def _corners(
    lines: Sequence[bytes], n_vertices: int, n_places: int
) -> Iterator[tuple[bytes, NDArray[np.int64], NDArray[np.int64]]]:
    """Yield each material's name with the vertices and the texture places (-1: none) it covers."""
    vertices_so_far = places_so_far = 0
    name = b""
    found: dict[bytes, tuple[list[int], list[int]]] = {}
    for line in lines:
        if line[:2] == b"v ":
            vertices_so_far += 1
        elif line[:3] == b"vt ":
            places_so_far += 1
        elif line.startswith(b"usemtl"):
            name = line[6:].strip()
        elif line[:2] == b"f ":
            vertices, places = found.setdefault(name, ([], []))
            for corner in line[2:].split():
                v, _, rest = corner.partition(b"/")
                vertices.append(_index(v, vertices_so_far))
                places.append(_index(rest.partition(b"/")[0], places_so_far))
    for name, (vertices, places) in found.items():
        v, t = np.array(vertices, np.int64), np.array(places, np.int64)
        inside = (v >= 0) & (v < n_vertices)
        yield name, v[inside], np.where(t < n_places, t, -1)[inside]


def _index(word: bytes, so_far: int) -> int:
    try:
        index = int(word)
    except ValueError:
        return -1
    return index - 1 if index > 0 else max(so_far + index, -1)


def _read_library(
    name: str, folder: Path, materials: dict[bytes, Material], notes: list[str]
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
            except MeshError as cause:
                notes.append(f"a texture is left out: {cause}")


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
