"""Wavefront OBJ: polygons, relative indices, colours after the position, materials."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError, Message
from paint3d.files.colours import (
    REPEAT,
    VERTEX_COLOURS,
    Look,
    colour_codes,
    is_coloured,
    linear_from_srgb,
    open_picture,
)
from paint3d.files.contents import path_beside, plain_text, read_beside
from paint3d.files.formats.text_rows import UNIT_NAMES, text_rows
from paint3d.files.raw_mesh import RawMesh, index_array, left_out, parse_numbers

__all__ = ["ObjLooks", "read_obj", "write_obj"]

# ---- Materials -----------------------------------------------------------------------------------
# Diffuse colours and pictures of OBJ materials (.mtl), face by face.


MAX_LIBRARY = 1 << 26
OPTIONS = {"-s": 3, "-o": 3, "-t": 3, "-mm": 2, "-bm": 1, "-texres": 1, "-clamp": 1, "-boost": 1}
NUMBERED = ("-s", "-o", "-t")
OPTIONS |= {"-blendu": 1, "-blendv": 1, "-cc": 1, "-imfchan": 1, "-type": 1}  # and their words


LEFT_OUT = {  # what of a material is left out, by the words that begin its lines
    b"bump": Message("relief (a bump map)"),
    b"map_bump": Message("relief (a bump map)"),
    b"norm": Message("relief (a normal map)"),
    b"map_d": Message("transparency"),
    b"map_tr": Message("transparency"),
    b"map_ks": Message("gloss from a picture"),
    b"map_ke": Message("light of its own"),
    b"disp": Message("displacement"),
}


@dataclass
class Material:
    """A material's colour, and the picture that replaces it."""

    diffuse: tuple[float, float, float] = (1.0, 1.0, 1.0)
    picture: NDArray[np.uint8] | None = None
    clamped: bool = False
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)

    def look(self) -> Look:
        """Look of the material, for `RawMesh`."""
        if self.picture is not None:
            return Look(picture=self.picture, wrap=("clamp", "clamp") if self.clamped else REPEAT)
        codes = np.floor(255.0 * np.clip(self.diffuse, 0.0, 1.0) + 0.5).astype(np.uint8)
        red, green, blue = linear_from_srgb(codes).tolist()
        return Look((red, green, blue))


@dataclass(frozen=True)
class ObjLooks:
    """Colours of an OBJ file; see `RawMesh` for looks, look_of, uv and notes.

    Attributes
    ----------
    dropped : frozenset of Message
        What its materials say and paint3d does not take.
    """

    looks: tuple[Look, ...]
    look_of: NDArray[np.int64]
    uv: NDArray[np.float64]
    notes: tuple[Message, ...]
    dropped: frozenset[Message]


def _obj_looks(lines: Sequence[bytes], sizes: NDArray[np.int64], folder: Path) -> ObjLooks:
    """Return the looks of an OBJ's faces; none where it names no readable material.

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
    notes: list[Message] = []
    dropped: set[Message] = set()
    materials: dict[bytes, Material] = {}
    for line in lines:
        if line.startswith(b"mtllib "):
            for name in _library_names(line[7:], folder):
                _read_library(name, folder, materials, notes, dropped)
    names = {name: k for k, name in enumerate(materials)}
    look_of, texture_ids = _read_face_looks(lines, names, int(sizes.sum()))
    noted = tuple(dict.fromkeys(notes)), frozenset(dropped)
    if not (look_of >= 0).any():
        return ObjLooks((), look_of, np.empty((0, 2)), *noted)
    written = [line[3:].split()[:2] for line in lines if line[:3] == b"vt "]
    table = [[*map(float, words), 0.0, 0.0][:2] for words in written]
    known = np.array([*table, [np.nan, np.nan]], np.float64)
    uv = known[np.where(texture_ids < len(table), texture_ids, -1)]
    of_corner = np.repeat(look_of, sizes)
    for k, material in enumerate(materials.values()):
        uv[of_corner == k] = uv[of_corner == k] * material.scale + material.offset
    uv = uv * (1.0, -1.0) + (0.0, 1.0)  # OBJ counts from the lower left
    looks = tuple(material.look() for material in materials.values())
    return ObjLooks(looks, look_of, uv, *noted)


def _name(words: bytes) -> str:
    return words.strip().strip(b'"').decode("utf-8", "surrogateescape")


def _library_names(words: bytes, folder: Path) -> list[str]:
    """Return the names in a line: one that may hold spaces, or, where it is not there, several."""
    whole, names = _name(words), [_name(word) for word in words.split()]
    if b"\0" in words or not all(name.lower().endswith(".mtl") for name in names):
        return [whole]
    is_there = os.path.exists(path_beside(os.path.realpath(folder), whole))
    return [whole] if is_there else names


def _read_face_looks(
    lines: Sequence[bytes], names: dict[bytes, int], n_corners: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return each face's material (-1: none) and each corner's texture coordinate (-1: none)."""
    look, looks = -1, []
    texture_ids = np.full(n_corners, -1, np.int64)
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
                    texture_ids[at] = _texture_index(rest.partition(b"/")[0], so_far)
                at += 1
    return np.array(looks, np.int64), texture_ids


def _texture_index(word: bytes, so_far: int) -> int:
    try:
        index = int(word)
    except ValueError:
        return -1
    return index - 1 if index > 0 else max(so_far + index, -1)


def _read_library(
    name: str,
    folder: Path,
    materials: dict[bytes, Material],
    notes: list[Message],
    dropped: set[Message],
) -> None:
    try:
        text = plain_text(read_beside(folder, name, MAX_LIBRARY))
    except MeshError as cause:
        notes.append(Message("materials are left out: {cause}", cause=cause))
        return
    material, kinds = Material(), set[bytes]()
    for line in text.split(b"\n"):
        words = line.split()
        kind = words[0].lower() if words else b""
        kinds.add(kind)
        if kind == b"newmtl":
            material = materials.setdefault(line.strip()[6:].strip(), Material())
        elif kind == b"kd" and len(words) >= 4:
            material.diffuse = _read_diffuse(words[1:4], material.diffuse)
        elif kind == b"map_kd":
            try:
                name, options = _read_picture_name(words[1:], line)
                material.picture = open_picture(read_beside(folder, name))
            except MeshError as cause:
                notes.append(Message("a texture is left out: {cause}", cause=cause))
                continue
            material.clamped = options.get("-clamp", [b"off"])[:1] == [b"on"]
            material.scale = _pair(options.get("-s", []), 1.0)
            material.offset = _pair(options.get("-o", []), 0.0)
            if options.get("-mm", [b"0", b"1"]) != [b"0", b"1"]:
                dropped.add(Message("brightness and contrast of a picture (-mm)"))
        elif kind in LEFT_OUT:
            dropped.add(LEFT_OUT[kind])
        elif kind == b"d" and _opacity(words[1:2]) < 1.0:
            dropped.add(Message("transparency"))
    if b"map_ka" in kinds and b"map_kd" not in kinds:  # else it is mostly the same picture
        dropped.add(Message("pictures of ambient light"))


def _opacity(words: list[bytes]) -> float:
    try:
        return float(words[0])
    except (ValueError, IndexError):
        return 1.0


def _read_diffuse(
    words: list[bytes], otherwise: tuple[float, float, float]
) -> tuple[float, float, float]:
    try:
        red, green, blue = (float(word) for word in words)
    except ValueError:
        return otherwise
    return (red, green, blue) if np.isfinite((red, green, blue)).all() else otherwise


def _read_picture_name(words: list[bytes], line: bytes) -> tuple[str, dict[str, list[bytes]]]:
    """Return the file name after a map's options, which may hold spaces, and the options."""
    at, options = 0, dict[str, list[bytes]]()
    while at < len(words) and (option := words[at].decode("ascii", "replace").lower()) in OPTIONS:
        at += 1
        first = at
        if option in NUMBERED:  # one to three numbers: many programs leave out the last
            while at < min(len(words) - 1, first + OPTIONS[option]) and _is_number(words[at]):
                at += 1
        else:
            at += OPTIONS[option]
        options[option] = words[first:at]
    if at >= len(words):
        raise MeshError("it names no picture in {line!r}", line=line[:60])
    return _name(line.split(None, 1 + at)[1 + at]), options


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _pair(words: list[bytes], default: float) -> tuple[float, float]:
    """Return the numbers along width and height; `default` for missing ones."""
    numbers = [float(word) for word in words[:2]]
    u, v = [x if np.isfinite(x) else default for x in [*numbers, default, default][:2]]
    return u, v


# ---- The mesh ------------------------------------------------------------------------------------


COLOURED = (6, 7, 8)  # numbers of a vertex line with a colour
OPAQUE = (1.0, 255.0)
POLYPAINT = re.compile(rb"^[ \t]*#MRGB[ \t]+([0-9a-fA-F]+)", re.MULTILINE)
NO_POINTS = {
    b"l": Message("lines"),
    b"curv": Message("curves, which are not read"),
    b"surf": Message("free-form surfaces, which are not read"),
}
PASSED_OVER = {
    b"l": Message("lines"),
    b"p": Message("points"),
    b"curv": Message("curves"),
    b"surf": Message("free-form surfaces"),
}
ATTRIBUTES = re.compile(rb"/\S*")
ODD_EXPONENT = re.compile(rb"(?<=\d)([+-])[eE](?=\d)")


def read_obj(data: bytes, folder: Path, texture: bool = False) -> RawMesh:
    """Read an OBJ file; lines, points, curves and free-form surfaces are passed over, and noted.

    Relative (negative) indices count back from the vertices read so far, as the format says.
    Vertices without a colour, among others with one, are white.

    Parameters
    ----------
    data : bytes
        The whole file.
    folder : Path
        Where its material libraries and pictures lie; others are not followed.
    texture : bool
        Whether materials and their pictures are read, instead of vertex colours.

    Raises
    ------
    MeshError
        If a vertex or face line holds something else than numbers, or an index is 0.
    """
    text = plain_text(data).replace(b"\t", b" ").replace(b"\\\n", b" ")  # lines that go on are one
    lines = [line.partition(b"#")[0].strip() for line in text.split(b"\n")]
    vertex_lines = [line[2:] for line in lines if line[:2] == b"v "]
    face_lines = [line[2:] for line in lines if line[:2] == b"f "]
    vertices, colours, notes = _read_vertices(vertex_lines)
    if colours is None:
        colours, more_notes = _read_polypaint(data, len(vertices))
        notes += more_notes
    sizes = np.array([len(line.split()) for line in face_lines], np.int64)
    corners = index_array(
        parse_numbers(ATTRIBUTES.sub(b"", b"\n".join(face_lines)), Message("a face")), "a face"
    )
    if (corners == 0).any():
        raise MeshError("a face refers to vertex 0; OBJ counts from 1")
    if (corners < 0).any():
        is_vertex = np.array([line[:2] == b"v " for line in lines])
        is_face = np.array([line[:2] == b"f " for line in lines])
        before = np.repeat(np.cumsum(is_vertex)[is_face], sizes)  # vertices, of each face
        corners = np.where(corners < 0, corners + before, corners - 1)
    else:
        corners = corners - 1
    kinds = {line.partition(b" ")[0] for line in lines}
    besides = (what for kind, what in NO_POINTS.items() if kind in kinds)
    announced = "" if len(sizes) else next(besides, "")
    dropped = {what for kind, what in PASSED_OVER.items() if kind in kinds}
    if not texture:
        dropped |= (
            {Message("its colours and pictures")} if {b"mtllib", b"usemtl"} <= kinds else set()
        )
        notes += left_out(dropped)
        return RawMesh(vertices, corners, sizes, colours, announces=announced, notes=notes)
    looks = _obj_looks(lines, sizes, folder)
    more_notes = looks.notes + left_out(dropped | looks.dropped)
    if is_coloured(colours):  # a material that says nothing stands beside them in many files
        if any(look.picture is not None or min(look.factor) < 1.0 for look in looks.looks):
            more_notes = looks.notes + left_out(dropped | looks.dropped | {VERTEX_COLOURS})
        else:
            looks = replace(looks, looks=())
    if not looks.looks:
        return RawMesh(
            vertices, corners, sizes, colours, announces=announced, notes=notes + more_notes
        )
    return RawMesh(
        vertices, corners, sizes, notes=more_notes,
        looks=looks.looks, look_of=looks.look_of, uv=looks.uv,
    )  # fmt: skip


def _read_vertices(
    lines: Sequence[bytes],
) -> tuple[NDArray[np.float64], NDArray[np.uint8] | None, tuple[Message, ...]]:
    widths = np.array([len(line.split()) for line in lines], np.int64)
    if len(lines) == 0:
        return np.empty((0, 3)), None, ()
    if widths.min() < 3:
        line = lines[int(widths.argmin())].decode("ascii", "replace")
        raise MeshError("a vertex line holds {line!r}; expected three numbers", line=line[:40])
    numbers = _parse_vertex_numbers(b"\n".join(lines))
    first = np.cumsum(widths) - widths
    vertices = numbers[first[:, None] + np.arange(3)]
    rgba = np.zeros((len(lines), 4))
    for width in COLOURED:
        rows = np.flatnonzero(widths == width)
        table = numbers[first[rows, None] + np.arange(width)]
        column = _find_colour_column(table)
        rgba_columns = table[:, column : column + 4]
        rgba[rows, : rgba_columns.shape[1]] = rgba_columns
    coloured = np.isin(widths, COLOURED)
    if not coloured.any():
        return vertices, None, ()
    codes, notes = colour_codes(rgba[coloured])
    if codes is None:
        return vertices, None, notes
    colours = np.full((len(lines), 3), 255, np.uint8)
    colours[coloured] = codes
    return vertices, colours, notes


def _find_colour_column(table: NDArray[np.float64]) -> int:
    """Return the index of red in vertex lines of 6, 7 or 8 numbers.

    Eight are a weight, a colour and its opacity after the position. Seven may be a colour with an
    opacity, which is then the same everywhere, or a colour after a weight of 1.
    """
    width = table.shape[1]
    if width != 7 or not len(table):
        return 4 if width == 8 else 3
    is_opaque = table[0, 6] in OPAQUE and (table[:, 6] == table[0, 6]).all()
    is_weighted = bool((table[:, 3] == 1.0).all())
    return 4 if is_weighted and not is_opaque else 3


def _read_polypaint(data: bytes, n: int) -> tuple[NDArray[np.uint8] | None, tuple[Message, ...]]:
    """Return the colours (n, 3) that ZBrush writes as comments: MMRRGGBB for each vertex."""
    digits = b"".join(POLYPAINT.findall(plain_text(data))) if b"#MRGB" in data else b""
    if not digits:
        return None, ()
    if len(digits) != 8 * n:
        return None, left_out(
            [
                Message(
                    "its polypaint, of {n:,} vertices instead of {wanted:,}",
                    n=len(digits) // 8,
                    wanted=n,
                )
            ]
        )
    codes = np.frombuffer(bytes.fromhex(digits.decode("ascii")), np.uint8).reshape(n, 4)
    return codes[:, 1:].copy(), ()


def _parse_vertex_numbers(text: bytes) -> NDArray[np.float64]:
    """Parse numbers; where that fails, read exponents like 3.1+e2, which some programs write."""
    try:
        return parse_numbers(text, Message("a vertex"))
    except MeshError:
        return parse_numbers(ODD_EXPONENT.sub(rb"e\1", text), Message("a vertex"))


# ---- Writing -------------------------------------------------------------------------------------


def write_obj(
    path: Path,
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    normals: NDArray[np.float32],
    srgb: NDArray[np.uint8],
    *,
    name: str = "painting",
    unit: str = "mm",
) -> None:
    """Write ``v x y z r g b`` (sRGB 0 to 1), ``vn`` and ``f v//vn`` lines.

    Parameters
    ----------
    path : Path
    vertices : (V, 3) float32
    faces : (F, 3) int32
    normals : (V, 3) float32, unit
    srgb : (V, 3) uint8
    name : str
        Of the object.
    unit : {"mm", "cm", "m", "in"}
        What the vertices are in, for the comment on top; the format itself has no unit.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    points = np.concatenate([vertices, np.divide(srgb, 255, dtype=np.float32)], axis=1)
    with open(path, "wb") as file:
        word = "".join(c if c.isascii() and c.isalnum() else "_" for c in name) or "painting"
        head = f"# paint3d: {UNIT_NAMES[unit]}, vertex colours sRGB 0 to 1\no {word}\n"
        file.write(head.encode("ascii"))
        file.writelines(text_rows("v {f0} {f1} {f2} {f3} {f4} {f5}\n", points))
        file.writelines(text_rows("vn {f0} {f1} {f2}\n", normals))
        corners = "f {i0}//{i0} {i1}//{i1} {i2}//{i2}\n"
        file.writelines(text_rows(corners, integers=faces + np.int32(1)))
