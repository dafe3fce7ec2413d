"""PLY: polygons of any and mixed sizes, triangle strips, colours and normals of vertices."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError, Message
from paint3d.files.colours import (
    COLOUR_NAMES,
    NAMED_AS_COLOUR,
    VERTEX_COLOURS,
    Look,
    colour_codes,
    is_coloured,
    open_picture,
)
from paint3d.files.contents import read_beside
from paint3d.files.raw_mesh import (
    FACE_COLOURS,
    RawMesh,
    check_count,
    index_array,
    left_out,
    parse_numbers,
)

__all__ = [
    "Element",
    "PlyLooks",
    "Property",
    "Tables",
    "read_ply",
    "write_ply",
]

# ---- Pictures and colours of faces ---------------------------------------------------------------
# Pictures and colours of the faces of a PLY file, as MeshLab and others write them.


KEYWORD = "TextureFile"
PLACE_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))  # of vertices
MAX_PICTURES = 1000


@dataclass(frozen=True)
class PlyLooks:
    """Looks of the faces; see `RawMesh`."""

    looks: tuple[Look, ...] = ()
    look_of: NDArray[np.int64] | None = None
    uv: NDArray[np.float64] | None = None
    corner_colours: NDArray[np.uint8] | None = None
    notes: tuple[Message, ...] = ()


def _picture_names(tables: Tables) -> list[str]:
    """Names of the pictures in the header's comments."""
    words = (comment.partition(" ") for comment in tables.comments)
    return [name.strip() for word, _, name in words if word == KEYWORD]


def _ply_looks(
    tables: Tables, corners: NDArray[np.int64], sizes: NDArray[np.int64], folder: Path
) -> PlyLooks:
    """Return the looks of the faces: their pictures, else their own colours.

    Places on the pictures are those of the faces' corners (texcoord), else of the vertices (s, t);
    they count from the lower left in the file.

    Parameters
    ----------
    tables : Tables
    corners : (N,) int64
        Of all polygons; within the vertices or not.
    sizes : (P,) int64
        The first polygons are those of the element face.
    folder : Path
        Of the file; pictures elsewhere are not followed.
    """
    faces = [e for e in tables.elements if e.name == "face" and e.list_sizes]
    names = _picture_names(tables)
    if not names or len(faces) > 1:
        return _read_face_colours(faces, sizes)
    uv = _read_uv(tables, faces, corners, sizes)
    if uv is None:
        return PlyLooks(notes=(Message("a texture is left out: the mesh has no places on it"),))
    looks, number, notes = [], [], []
    for name in names[:MAX_PICTURES]:
        number.append(-1)
        try:
            # the header was read byte by byte; a name is UTF-8, or what it is
            file = name.encode("latin-1").decode("utf-8", "surrogateescape")
            looks.append(Look(picture=open_picture(read_beside(folder, file))))
            number[-1] = len(looks) - 1
        except MeshError as cause:
            notes.append(Message("a texture is left out: {cause}", cause=cause))
    if not looks:
        return PlyLooks(notes=tuple(dict.fromkeys(notes)))
    which = _picture_indices(faces, len(sizes))
    inside = (which >= 0) & (which < len(number))
    look_of = np.where(inside, np.array(number)[np.where(inside, which, 0)], -1)
    return PlyLooks(tuple(looks), look_of, uv, notes=tuple(dict.fromkeys(notes)))


def _read_uv(
    tables: Tables, faces: Sequence[Element], corners: NDArray[np.int64], sizes: NDArray[np.int64]
) -> NDArray[np.float64] | None:
    """Texture coordinates (N, 2) of the corners from the upper left, nan where unknown, or None."""
    uv = np.full((len(corners), 2), np.nan)
    vertex = next(e for e in tables.elements if e.name == "vertex")
    pair = next((p for p in PLACE_NAMES if set(p) <= set(vertex.values)), None)
    listed = faces[0].list_sizes.get("texcoord") if faces else None
    if listed is not None:
        own = np.repeat(sizes[: len(listed)], sizes[: len(listed)])
        # others have none, or too few
        has_uv = np.repeat(listed, sizes[: len(listed)]) == 2 * own
        values = faces[0].values["texcoord"].astype(np.float64)
        whole = np.repeat(listed == 2 * sizes[: len(listed)], listed)
        uv[: len(has_uv)][has_uv] = values[whole].reshape(-1, 2)
    elif pair is not None:
        table = np.stack([vertex.values[name] for name in pair], axis=1).astype(np.float64)
        uv = table[np.clip(corners, 0, len(table) - 1)]
    else:
        return None
    return uv * (1.0, -1.0) + (0.0, 1.0)


def _picture_indices(faces: Sequence[Element], n: int) -> NDArray[np.int64]:
    """Index of each polygon's picture; the first by default."""
    which = np.zeros(n, np.int64)
    if faces and "texnumber" in faces[0].values and "texnumber" not in faces[0].list_sizes:
        numbers = index_array(
            faces[0].values["texnumber"].astype(np.float64), Message("a face's texnumber")
        )
        which[: len(numbers)] = numbers
    return which


def _read_face_colours(faces: Sequence[Element], sizes: NDArray[np.int64]) -> PlyLooks:
    names = _colour_names(faces[0]) if len(faces) == 1 else ()
    if not names:
        return PlyLooks()
    codes, notes = colour_codes(_colour_table(faces[0], names), whose=FACE_COLOURS)
    if codes is None:
        return PlyLooks(notes=notes)
    every = np.full((len(sizes), 3), 255, np.uint8)
    every[: len(codes)] = codes
    uv = np.full((int(sizes.sum()), 2), np.nan)
    look_of = np.zeros(len(sizes), np.int64)
    return PlyLooks((Look(),), look_of, uv, np.repeat(every, sizes, axis=0), notes)


# ---- Tables --------------------------------------------------------------------------------------
# The tables of a PLY file: ASCII and binary of both byte orders, any types, any line ends.


TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
KEYWORDS = ("format", "element", "property", "comment", "obj_info")
MAX_HEADER = 1 << 20
Order = Literal["<", ">"]


@dataclass
class Property:
    """A column: a scalar, or a list with its own count type."""

    name: str
    dtype: np.dtype
    count_dtype: np.dtype | None = None


@dataclass
class Element:
    """A table of the file: name, rows, columns, and the columns' values once read."""

    name: str
    count: int
    properties: list[Property] = field(default_factory=list)
    values: dict[str, AnyArray] = field(default_factory=dict)
    list_sizes: dict[str, AnyArray] = field(default_factory=dict)

    @property
    def least_bytes(self) -> int:
        """Size of the shortest possible binary row."""
        return sum(
            (p.dtype if p.count_dtype is None else p.count_dtype).itemsize for p in self.properties
        )


class Tables(NamedTuple):
    """Contents of a PLY file.

    Attributes
    ----------
    elements : tuple of Element
        In the file's order; those after the last one wanted are without values.
    comments : tuple of str
        Without the word that begins them.
    unknown : tuple of str
        Lines of the header that say nothing that PLY knows.
    """

    elements: tuple[Element, ...]
    comments: tuple[str, ...]
    unknown: tuple[str, ...]


def _read_tables(data: bytes, wanted: Collection[str]) -> Tables:
    """Read the elements of a PLY file as far as the last one whose name is wanted.

    Raises
    ------
    MeshError
        If the header is not PLY's, or the body does not hold what the header promises.
    """
    lines, body = _header_lines(data)
    try:
        order, tables = _parse_header(lines)
    except (IndexError, KeyError, ValueError) as cause:
        if isinstance(cause, MeshError):
            raise
        raise MeshError("the header cannot be understood near {cause}", cause=cause) from None
    elements = tables.elements
    last = max((k for k, e in enumerate(elements) if e.name in wanted), default=-1)
    if order == "":
        _read_ascii(elements[: last + 1], data[body:])
    else:
        _read_binary(elements[: last + 1], data, body)
    return tables


def _header_lines(data: bytes) -> tuple[list[str], int]:
    """Return the lines between the first and the last, and where the body begins."""
    if data[:3] != b"ply":
        raise MeshError("it does not start with 'ply'; expected a PLY file")
    end = data.find(b"end_header", 0, MAX_HEADER)
    if end < 0:
        raise MeshError("the header has no end; expected a line end_header")
    lone_return = data[3:4] == b"\r" and data[4:5] != b"\n"
    body = end + len(b"end_header")
    while data[body : body + 1] in (b" ", b"\t"):
        body += 1
    body += 2 if data[body : body + 2] == b"\r\n" and not lone_return else 1
    return data[:end].decode("latin-1").splitlines()[1:], body


def _parse_header(lines: list[str]) -> tuple[str, Tables]:
    """Return the byte order, "" for ASCII, and the tables, still empty.

    Lines that are unknown are passed over before the first element, where some programs write
    comments without saying so; after it, what follows in the file could be misread.
    """
    order, elements, comments, unknown = None, [], [], []
    for line in lines:
        words = line.split()
        if not words or words[0] == "obj_info":
            continue
        if words[0] == "comment":
            comments.append(line.strip()[len("comment") :].strip())
        elif words[0] == "format":
            order = FORMATS[words[1]]
        elif words[0] == "element":
            elements.append(Element(words[1], int(words[2])))
        elif words[0] == "property" and elements:
            elements[-1].properties.append(_parse_property(words, order or "<"))
        elif elements or difflib.get_close_matches(words[0].lower(), KEYWORDS, 1, 0.7):
            raise MeshError("the header has an unknown line {words!r}", words=" ".join(words)[:40])
        else:
            unknown.append(" ".join(words))
    if order is None:
        raise MeshError("the header has no format line")
    return order, Tables(tuple(elements), tuple(comments), tuple(unknown))


def _parse_property(words: list[str], order: str) -> Property:
    if words[1] == "list":
        count, item = (np.dtype(TYPES[w]).newbyteorder(cast("Order", order)) for w in words[2:4])
        return Property(words[4], item, count)
    return Property(words[2], np.dtype(TYPES[words[1]]).newbyteorder(cast("Order", order)))


def _read_binary(elements: Sequence[Element], data: bytes, at: int) -> None:
    for element in elements:
        if not element.properties:
            continue
        check_count(
            element.count,
            element.least_bytes,
            len(data) - at,
            Message("rows of {name}", name=element.name),
        )
        at = _read_binary_rows(element, data, at)


def _read_binary_rows(element: Element, data: bytes, at: int) -> int:
    """Read one element's rows from `at`; return where they end."""
    lists = [p for p in element.properties if p.count_dtype is not None]
    if element.count == 0:
        _store(element, {p.name: np.empty(0, p.dtype) for p in element.properties}, {})
        return at
    sizes = {p.name: 0 for p in lists}
    if lists:
        sizes = _first_row_sizes(element, data, at)
    record = []
    for k, p in enumerate(element.properties):
        if p.count_dtype is not None:
            record += [(f"count {k}", p.count_dtype), (f"item {k}", p.dtype, (sizes[p.name],))]
        else:
            record.append((f"item {k}", p.dtype))
    row = np.dtype(record)
    if row.itemsize * element.count <= len(data) - at:
        rows = np.frombuffer(data, row, element.count, at)
        counts = [(k, p) for k, p in enumerate(element.properties) if p.count_dtype is not None]
        if all((rows[f"count {k}"] == sizes[p.name]).all() for k, p in counts):
            values = {p.name: rows[f"item {k}"] for k, p in enumerate(element.properties)}
            _store(element, values, {n: np.full(element.count, s) for n, s in sizes.items()})
            return at + row.itemsize * element.count
    return _read_uneven_rows(element, data, at)


def _first_row_sizes(element: Element, data: bytes, at: int) -> dict[str, int]:
    sizes = {}
    for p in element.properties:
        if p.count_dtype is None:
            at += p.dtype.itemsize
            continue
        n = _list_size(element, p, data, at)
        sizes[p.name] = n
        at += p.count_dtype.itemsize + n * p.dtype.itemsize
    return sizes


def _list_size(element: Element, p: Property, data: bytes, at: int) -> int:
    assert p.count_dtype is not None, "a number is no list"
    if at + p.count_dtype.itemsize > len(data):
        raise MeshError(
            "it ends within the {element} rows; the file is cut short",
            element=element.name,
        )
    n = int(np.frombuffer(data, p.count_dtype, 1, at)[0])
    check_count(
        n,
        p.dtype.itemsize,
        len(data) - at - p.count_dtype.itemsize,
        Message("entries in a {name} list", name=p.name),
    )
    return n


def _read_uneven_rows(element: Element, data: bytes, at: int) -> int:
    """Read rows whose lists differ in length, one by one."""
    parts: dict[str, list[AnyArray]] = {p.name: [] for p in element.properties}
    sizes: dict[str, list[int]] = {
        p.name: [] for p in element.properties if p.count_dtype is not None
    }
    for _ in range(element.count):
        for p in element.properties:
            n = 1
            if p.count_dtype is not None:
                n = _list_size(element, p, data, at)
                at += p.count_dtype.itemsize
                sizes[p.name].append(n)
            if at + n * p.dtype.itemsize > len(data):
                raise MeshError(
                    "it ends within the {element} rows; the file is cut short",
                    element=element.name,
                )
            parts[p.name].append(np.frombuffer(data, p.dtype, n, at))
            at += n * p.dtype.itemsize
    values = {name: np.concatenate(part) for name, part in parts.items()}
    _store(element, values, {name: np.array(size, np.int64) for name, size in sizes.items()})
    return at


def _store(element: Element, values: dict[str, AnyArray], sizes: dict[str, AnyArray]) -> None:
    element.values = {
        name: np.ravel(array).astype(array.dtype.newbyteorder("="))
        for name, array in values.items()
    }
    element.list_sizes = sizes


def _read_ascii(elements: Sequence[Element], text: bytes) -> None:
    for element in elements:
        check_count(
            element.count,
            2 * max(1, len(element.properties)),
            len(text) + 1,
            Message("rows of {name}", name=element.name),
        )
    numbers, at = parse_numbers(text, Message("the body")), 0
    for element in elements:
        at = _read_ascii_rows(element, numbers, at)


def _read_ascii_rows(element: Element, numbers: AnyArray, at: int) -> int:
    """Take one element's rows from the body's numbers; return where they end."""
    cut_short = MeshError(
        "it ends within the {element} rows; the file is cut short",
        element=element.name,
    )
    properties = element.properties
    if not any(p.count_dtype is not None for p in properties):
        width = len(properties)
        end = at + width * element.count
        if end > len(numbers):
            raise cut_short
        table = numbers[at:end].reshape(element.count, width)
        _store(element, {p.name: _cast(table[:, k], p) for k, p in enumerate(properties)}, {})
        return end
    columns: dict[str, list[Any]] = {p.name: [] for p in properties}
    sizes: dict[str, list[int]] = {p.name: [] for p in properties if p.count_dtype is not None}
    flat = numbers.tolist() if element.count else []
    for _ in range(element.count):
        for p in properties:
            n = 1
            if p.count_dtype is not None:
                if at >= len(flat) or not 0 <= flat[at] <= len(flat) - at:
                    raise cut_short
                n = int(flat[at])
                sizes[p.name].append(n)
                at += 1
            if at + n > len(flat):
                raise cut_short
            columns[p.name] += flat[at : at + n]
            at += n
    values = {p.name: _cast(np.array(columns[p.name], np.float64), p) for p in properties}
    _store(element, values, {name: np.array(size, np.int64) for name, size in sizes.items()})
    return at


def _cast(column: AnyArray, p: Property) -> AnyArray:
    """Return ASCII numbers in the declared type where they fit; only colours need to know it."""
    if p.dtype.kind == "f" or not column.size or not np.isfinite(column).all():
        return column
    limits = np.iinfo(p.dtype)
    fit = limits.min <= column.min() and column.max() <= limits.max
    return column.astype(p.dtype) if fit and (column == np.floor(column)).all() else column


# ---- The mesh ------------------------------------------------------------------------------------


WANTED = ("vertex", "face", "tristrips")
INDEX_NAMES = ("vertex_indices", "vertex_index")
STRIP_END = -1
LISTS_OF_COLOURS = ("rgb", "rgba", "color", "colors", "colour", "colours")
SPLATS = ("f_dc_0", "f_dc_1", "f_dc_2")  # of Gaussian splatting: spherical harmonics of degree 0
SH_0 = 0.28209479177387814  # 1 / (2 sqrt(pi))


def read_ply(data: bytes, folder: Path, texture: bool = False) -> RawMesh:
    """Read a PLY file.

    Parameters
    ----------
    data : bytes
        The whole file.
    folder : Path
        Where its pictures lie; others are not followed.
    texture : bool
        Whether pictures and colours of faces are read, instead of vertex colours.

    Raises
    ------
    MeshError
        If the header is not PLY's, or the body does not hold what the header promises.
    """
    tables = _read_tables(data, WANTED)
    vertex = next((e for e in tables.elements if e.name == "vertex"), None)
    if vertex is None or not {"x", "y", "z"} <= set(vertex.values):
        raise MeshError("no vertex positions; expected an element vertex with x, y and z")
    vertices = np.stack([vertex.values[k].astype(np.float64) for k in "xyz"], axis=1)
    corners, sizes = _read_polygons(tables)
    colours, notes = _read_colours(vertex)
    notes += tuple(
        Message("its header's line {line!r} is passed over", line=line[:60])
        for line in tables.unknown
    )
    dropped = (
        [Message("lines")] if any(e.name == "edge" and e.count for e in tables.elements) else []
    )
    if texture and len(sizes):
        looks = _ply_looks(tables, corners, sizes, folder)
        notes += looks.notes
    else:
        looks = PlyLooks()
        dropped += [Message("its pictures")] if _picture_names(tables) else []
        of_faces = any(_colour_names(e) for e in tables.elements if e.name == "face")
        dropped += [FACE_COLOURS] if of_faces else []
    dropped += [VERTEX_COLOURS] if looks.looks and is_coloured(colours) else []
    dropped += [
        Message("what it calls {names}", names=", ".join(names)[:60])
        for names in map(_unread_colours, tables.elements)
        if names
    ]
    notes += left_out(dropped)
    return RawMesh(
        vertices,
        corners,
        sizes,
        None if looks.looks else colours,
        _read_normals(vertex),
        announces=_announce(tables),
        notes=notes,
        looks=looks.looks,
        look_of=looks.look_of,
        uv=looks.uv,
        corner_colours=looks.corner_colours,
    )


def _announce(tables: Tables) -> str:
    """Name the file's elements besides points; empty where there are none."""
    others = [e for e in tables.elements if e.name != "vertex" and (e.count or e.name in WANTED)]
    if any(element.name in WANTED for element in others):
        return Message("faces")
    return Message("{name!r}, which is not read", name=others[0].name[:40]) if others else ""


def _read_polygons(tables: Tables) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the corners of all polygons, then of the triangles of all strips, and their sizes."""
    corners, sizes = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for kind, what in (("face", Message("a face")), ("tristrips", Message("a strip"))):
        for element in (e for e in tables.elements if e.name == kind):
            name = next((n for n in INDEX_NAMES if n in element.list_sizes), None)
            if name is None:
                continue
            ids = index_array(element.values[name], what)
            each = element.list_sizes[name].astype(np.int64)
            if kind == "tristrips":
                ids = _triangulate_strips(ids, each)
                each = np.full(len(ids) // 3, 3)
            corners.append(ids)
            sizes.append(each)
    return np.concatenate(corners), np.concatenate(sizes)


def _triangulate_strips(ids: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the corners of the triangles of strips (lists of these sizes; -1 begins another).

    Every second triangle of a strip is turned round; those that name a vertex twice only lead on
    to the next.
    """
    ids = np.where(ids == np.iinfo(np.uint32).max, STRIP_END, ids)
    ids = np.insert(ids, np.cumsum(sizes), STRIP_END)
    position = np.arange(len(ids))
    start = np.maximum.accumulate(np.where(ids == STRIP_END, position + 1, 0))
    faces = np.stack([ids[:-2], ids[1:-1], ids[2:]], axis=1)
    odd = (position - start)[:-2] % 2 == 1
    faces[odd] = faces[odd][:, [1, 0, 2]]
    whole = (faces != STRIP_END).all(axis=1)
    whole &= (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    result: NDArray[np.int64] = faces[whole].ravel()
    return result


def _read_colours(vertex: Element) -> tuple[NDArray[np.uint8] | None, tuple[Message, ...]]:
    names = _colour_names(vertex)
    if tuple(name.lower() for name in names) == SPLATS:
        fractions = SH_0 * np.stack([vertex.values[k].astype(np.float64) for k in names], axis=1)
        codes, notes = colour_codes(np.clip(0.5 + fractions, 0.0, 1.0))
        return codes, (Message("its Gaussian splats are taken as points"), *notes)
    return colour_codes(_colour_table(vertex, names)) if names else (None, ())


def _colour_names(element: Element) -> tuple[str, ...]:
    """Return the names of the columns that are an element's colours: three, or one of lists."""
    scalars = {name.lower(): name for name in element.values if name not in element.list_sizes}
    triples = (*COLOUR_NAMES, SPLATS) if element.name == "vertex" else COLOUR_NAMES
    for names in triples:
        if set(names) <= scalars.keys():
            return tuple(scalars[name] for name in names)
    for name in LISTS_OF_COLOURS:
        sizes = element.list_sizes.get(name)
        if sizes is not None and len(sizes) and sizes[0] in (3, 4) and (sizes == sizes[0]).all():
            return (name,)
    return ()


def _colour_table(element: Element, names: tuple[str, ...]) -> AnyArray:
    """Return an element's colours (N, 3), or with opacities (N, 4), of any type."""
    if len(names) == 3:
        columns = [element.values[k] for k in names]
        opacity = element.values.get("alpha", element.values.get("a"))
        if opacity is not None and opacity.dtype == columns[0].dtype and opacity.ndim == 1:
            columns.append(opacity)
        return np.stack(columns, axis=1)
    return element.values[names[0]].reshape(len(element.list_sizes[names[0]]), -1)


def _unread_colours(element: Element) -> list[str]:
    """Return the names of an element's colour columns that are not read."""
    names = [p.name for p in element.properties if NAMED_AS_COLOUR.search(p.name)]
    return [name for name in names if name not in _colour_names(element)] if element.count else []


def _read_normals(vertex: Element) -> NDArray[np.float64] | None:
    if not {"nx", "ny", "nz"} <= set(vertex.values):
        return None
    return np.stack([vertex.values[k].astype(np.float64) for k in ("nx", "ny", "nz")], axis=1)


# ---- Writing -------------------------------------------------------------------------------------


def write_ply(
    path: Path,
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    normals: NDArray[np.float32] | None = None,
    srgb: NDArray[np.uint8] | None = None,
) -> None:
    """Write a little-endian binary PLY: float x y z, nx ny nz, uchar red green blue, triangles.

    Classic type names and byte colours are used because other names and float colours are
    misread by several programs. The output depends on the arrays alone.

    Parameters
    ----------
    path : Path
    vertices : (V, 3) float32, mm
    faces : (F, 3) int32
    normals : (V, 3) float32, optional
    srgb : (V, 3) uint8, optional

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    columns: list[tuple[str, str, str, AnyArray]] = [("x y z", "float", "<f4", vertices)]
    if normals is not None:
        columns.append(("nx ny nz", "float", "<f4", normals))
    if srgb is not None:
        columns.append(("red green blue", "uchar", "u1", srgb))
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    record = []
    for names, kind, dtype, _ in columns:
        header += [f"property {kind} {name}" for name in names.split()]
        record.append((names, dtype, 3))
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    body = np.empty(len(vertices), record)
    for names, _, _, array in columns:
        body[names] = array
    triangles = np.empty(len(faces), [("corners", "u1"), ("vertex_ids", "<i4", 3)])
    triangles["corners"] = 3
    triangles["vertex_ids"] = faces
    with open(path, "wb") as file:
        file.write(("\n".join([*header, "end_header"]) + "\n").encode("ascii"))
        file.write(memoryview(body.data).cast("B"))
        file.write(memoryview(triangles.data).cast("B"))
