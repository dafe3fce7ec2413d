"""3MF: the build items of a package as one mesh with its colours, and paintings for printers."""

from __future__ import annotations

import io
import json
import posixpath
import re
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError, Message
from paint3d.files.colours import Look, open_picture
from paint3d.files.contents import json_text, parse_xml
from paint3d.files.formats.text_rows import text_rows
from paint3d.files.raw_mesh import RawMesh, join_meshes, left_out

__all__ = ["CORE", "Paint3mf", "Seen", "read_3mf", "write_3mf"]

# ---- Tables --------------------------------------------------------------------------------------
# Of packages, of colours, of what is written, and of slicers.


UNITS_MM = {
    "micron": 1e-3,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "inch": 25.4,
    "foot": 304.8,
    "meter": 1000.0,
}
SLICER_SETTINGS = (  # Bambu Studio's and Orca's, PrusaSlicer's
    "Metadata/model_settings.config",
    "Metadata/Slic3r_PE_model.config",
)
OTHER_FILAMENT = re.compile(rb'key="extruder"\s+value="0*(?:[2-9]|1\d)')
LATTICE = "{http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02}beamlattice"
PRODUCTION = "{http://schemas.microsoft.com/3dmanufacturing/production/2015/06}"
MODEL_RELATION = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
MAX_UNPACKED = 1 << 30
MAX_PARTS = 10_000

CORE_SCHEMA = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIAL_SCHEMA = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
CORE, MATERIAL = f"{{{CORE_SCHEMA}}}", f"{{{MATERIAL_SCHEMA}}}"
LEFT_OUT = {
    f"{MATERIAL}compositematerials": Message("mixtures of materials"),
    f"{MATERIAL}multiproperties": Message("mixtures of materials"),
    "painted": Message("colours painted in a slicer"),
}
PAINTED = ("paint_color", "mmu_segmentation")  # of triangles, by slicers: pieces of each
TILED = {"wrap": "repeat", "mirror": "mirror", "clamp": "clamp", "none": "clamp"}

CONTENT_TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
<Default Extension="config" ContentType="text/plain"/>
</Types>
"""
RELATIONS = """<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Id="rel0" Target="/3D/3dmodel.model"
 Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""
UNIT_NAMES = {"mm": "millimeter", "cm": "centimeter", "m": "meter", "in": "inch"}
EARLIEST = (1980, 1, 1, 0, 0, 0)  # a fixed date: the same painting gives the same bytes
FASTEST = 1

BAMBU = "BambuStudio-02.00.00.00"
BAMBU_SCHEMA = "http://schemas.bambulab.com/package/2021"
PRUSA_SCHEMA = "http://schemas.slic3r.org/3mf/2017/06"
MOST_PAINTED = 16  # filaments that slicers know
_CODED = 3  # the first filament that takes two digits


# ---- Colours -------------------------------------------------------------------------------------
# What the triangles of 3MF parts look like: colour groups, base materials, textures.


class Seen(NamedTuple):
    """Looks of the triangles of a mesh.

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
    values: NDArray[np.float64]  # colours (N, 3), or texture coordinates (N, 2)
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
    notes : list of Message
        Pictures that could not be read, and why.
    dropped : set of Message
        What is said and not taken.
    looks : list of Look
    """

    def __init__(self, read_part: Callable[[str], bytes], texture: bool) -> None:
        self.notes: list[Message] = []
        self.dropped: set[Message] = set()
        self.looks: list[Look] = []
        self._read_part, self._texture = read_part, texture
        self._groups: dict[str, dict[str | None, _Group]] = {}
        self._present: dict[str, set[str | None]] = {}  # numbers of a part's resources

    def see(
        self,
        part: str,
        model: ElementTree.Element,
        solid: ElementTree.Element,
        triangles: Sequence[ElementTree.Element],
    ) -> Seen:
        """Return the looks of an object's triangles.

        Raises
        ------
        MeshError
            If one refers to a colour or a texture coordinate that its group does not have.
        """
        groups = self._groups_of_part(part, model)
        colours = np.full((len(triangles), 3, 3), 255.0)
        coloured = np.zeros(len(triangles), np.bool_)
        look_of = np.full(len(triangles), -1)
        uv = np.full((len(triangles), 3, 2), np.nan)
        otherwise = solid.get("pid"), solid.get("pindex", "0")
        for k, triangle in enumerate(triangles):
            number = triangle.get("pid", otherwise[0])
            group = groups.get(number)
            if group is None:
                if number is not None and number not in self._present[part]:
                    self.dropped.add(Message("colours of resources that it does not contain"))
                continue
            first = triangle.get("p1", otherwise[1])
            rows = [_check_index(triangle.get(p, first), group, number) for p in ("p1", "p2", "p3")]
            if group.look < 0:
                colours[k], coloured[k] = group.values[rows], True
            else:
                uv[k], look_of[k] = group.values[rows], group.look
        return Seen(
            colours.reshape(-1, 3) if coloured.any() else None, coloured, look_of,
            uv.reshape(-1, 2),
        )  # fmt: skip

    def _groups_of_part(self, part: str, model: ElementTree.Element) -> dict[str | None, _Group]:
        """Groups of one model part, by resource id; those that are not taken are missing."""
        if part not in self._groups:
            resources = list(model.iterfind(f"{CORE}resources/*"))
            tags = {element.tag for element in resources}
            self.dropped |= {what for tag, what in LEFT_OUT.items() if tag in tags}
            self._present[part] = {element.get("id") for element in resources}
            self._groups[part] = {**_read_palettes(model), **self._read_pictures(model)}
        return self._groups[part]

    def _read_pictures(self, model: ElementTree.Element) -> dict[str | None, _Group]:
        picture_groups = list(model.iter(f"{MATERIAL}texture2dgroup"))
        if picture_groups and not self._texture:
            self.dropped.add(Message("its pictures"))
            return {}
        textures = {texture.get("id"): texture for texture in model.iter(f"{MATERIAL}texture2d")}
        looks = {
            id: self._add_look(textures.get(id))
            for id in {one.get("texid") for one in picture_groups}
        }
        groups = {}
        for group in picture_groups:
            look = looks[group.get("texid")]
            if look >= 0:
                rows = [[entry.get(axis, "nan") for axis in "uv"] for entry in group]
                uv = np.array(rows, np.float64).reshape(-1, 2)
                groups[group.get("id")] = _Group(uv * (1.0, -1.0) + (0.0, 1.0), look)  # from below
        return groups

    def _add_look(self, texture: ElementTree.Element | None) -> int:
        """Index of a texture among the looks; -1 where it cannot be read."""
        try:
            if texture is None:
                raise MeshError("it refers to one that it does not contain")
            part = posixpath.join("/", texture.get("path", ""))
            picture = open_picture(self._read_part(part))
        except MeshError as cause:
            self.notes.append(Message("a texture is left out: {cause}", cause=cause))
            return -1
        u, v = (TILED.get(texture.get(f"tilestyle{axis}", "wrap"), "repeat") for axis in "uv")
        self.looks.append(Look(picture=picture, wrap=(u, v)))
        return len(self.looks) - 1


def _check_index(text: str, group: _Group, number: str | None) -> int:
    index = int(text)
    if not 0 <= index < len(group.values):
        what = Message("colour") if group.look < 0 else Message("place on a picture")
        n = len(group.values)
        raise MeshError(
            "a triangle has {what} {index} of resource {number}, which has {n}; expected 0 to "
            "{last}",
            what=what,
            index=index,
            number=number,
            n=n,
            last=n - 1,
        )
    return index


def _read_palettes(model: ElementTree.Element) -> dict[str | None, _Group]:
    """Return the sRGB codes of every colour group and base material list, by resource id."""
    palettes = {}
    kinds = ((f"{MATERIAL}colorgroup", "color"), (f"{CORE}basematerials", "displaycolor"))
    for tag, attribute in kinds:
        for group in model.iter(tag):
            codes = [_parse_hex(entry.get(attribute)) for entry in group]
            palettes[group.get("id")] = _Group(np.array(codes, np.float64).reshape(-1, 3), -1)
    return palettes


def _parse_hex(text: str | None) -> tuple[int, int, int]:
    code = (text or "").strip().lstrip("#")
    try:
        if len(code) not in (6, 8):
            raise ValueError
        return int(code[0:2], 16), int(code[2:4], 16), int(code[4:6], 16)
    except ValueError:
        raise MeshError("a colour is {text!r:.40}; expected #RRGGBB", text=text) from None


# ---- Reading -------------------------------------------------------------------------------------


@dataclass
class Package:
    """An opened archive: model parts already parsed, and pieces of mesh found so far."""

    archive: zipfile.ZipFile
    paint: Paint3mf
    filaments: NDArray[np.float64]  # (k, 3) sRGB codes of those that a slicer's settings name
    models: dict[str, ElementTree.Element] = field(default_factory=dict)
    pieces: list[RawMesh] = field(default_factory=list)

    def model(self, part: str) -> ElementTree.Element:
        """Return the root of a model part."""
        if part not in self.models:
            self.models[part] = parse_xml(read_part(self.archive, part), part)
        return self.models[part]


def read_part(archive: zipfile.ZipFile, part: str) -> bytes:
    """Return the bytes of a part.

    Raises
    ------
    MeshError
        If there is none of that name.
    """
    try:
        return archive.read(part.lstrip("/"))
    except KeyError:
        raise MeshError("it refers to {part!r:.80}, which it does not contain", part=part) from None


def read_3mf(data: bytes, texture: bool = False) -> RawMesh:
    """Read a 3MF package: core, materials (colours, textures), components in other parts.

    A vertex whose corners have different colours gets their mean; the corners' are handed on.

    Parameters
    ----------
    data : bytes
        The whole file.
    texture : bool
        Whether pictures are read, and colours of corners kept apart.

    Raises
    ------
    MeshError
        If the archive is broken, encrypted or packed in an unusual way, over 1 GiB unpacked, or
        has no build items with triangles.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            _check_entries(archive)
            paint = Paint3mf(partial(read_part, archive), texture)
            raw = _read_package(Package(archive, paint, _read_filaments(archive)))
            return raw if texture else replace(raw, looks=(), look_of=None, uv=None)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError) as cause:
        raise MeshError("it is not a readable 3MF archive: {cause}", cause=cause) from None


def _check_entries(archive: zipfile.ZipFile) -> None:
    """Refuse what is too large, and what the Open Packaging Conventions (ECMA-376-2) forbid."""
    entries = archive.infolist()
    if sum(entry.file_size for entry in entries) > MAX_UNPACKED:
        raise MeshError("it unpacks to over {most} GiB; expected less", most=MAX_UNPACKED >> 30)
    for entry in entries:
        if entry.flag_bits & 1 or entry.compress_type not in PACKINGS:
            how = (
                Message("encrypted")
                if entry.flag_bits & 1
                else Message("packed by method {method}", method=entry.compress_type)
            )
            raise MeshError(
                "its {filename!r:.60} is {how}; expected it plain or deflated",
                filename=entry.filename,
                how=how,
            )


def _read_package(package: Package) -> RawMesh:
    start = _find_start(package.archive)
    model = package.model(start)
    unit = model.get("unit", "millimeter")
    if unit not in UNITS_MM:
        raise MeshError(
            "its unit is {unit!r}; expected one of {units_mm}",
            unit=unit,
            units_mm=", ".join(UNITS_MM),
        )
    for item in model.iterfind(f"{CORE}build/{CORE}item"):
        part = item.get(f"{PRODUCTION}path", start)
        _add_object(package, part, item.get("objectid"), _parse_matrix(item.get("transform")), ())
    if not package.pieces:
        raise MeshError("it has no build items with triangles; expected a surface")
    raw = join_meshes(package.pieces)
    plain = package.paint.looks or raw.colours is not None
    looks = (*package.paint.looks, Look()) if plain else ()  # faces without one are as coloured
    raw = replace(raw, unit_mm=UNITS_MM[unit], up="z", looks=looks)
    notes, dropped = tuple(dict.fromkeys(package.paint.notes)), package.paint.dropped
    if raw.colours is None and _has_filaments(package.archive):
        dropped = dropped | {Message("filaments that a slicer gave its parts")}
    if len(raw.sizes):
        dropped = dropped | ({Message("beam lattices")} if _has_beams(package) else set())
        return replace(raw, notes=notes + left_out(dropped))
    beams = Message("a beam lattice, which is not read")
    what = beams if _has_beams(package) else Message("a mesh")
    return replace(raw, announces=what, notes=notes + left_out(dropped))


def _has_filaments(archive: zipfile.ZipFile) -> bool:
    """Return whether a slicer's settings give parts another filament than the first."""
    there = set(archive.namelist())
    return any(
        OTHER_FILAMENT.search(archive.read(name)) for name in SLICER_SETTINGS if name in there
    )


def _has_beams(package: Package) -> bool:
    objects = f"{CORE}resources/{CORE}object/{CORE}mesh/{LATTICE}"
    return any(root.find(objects) is not None for root in package.models.values())


def _find_start(archive: zipfile.ZipFile) -> str:
    try:
        relations = parse_xml(archive.read("_rels/.rels"), "_rels/.rels")
    except KeyError:
        raise MeshError("it has no _rels/.rels; expected a 3MF package") from None
    for relation in relations:
        if relation.get("Type") == MODEL_RELATION:
            return posixpath.join("/", relation.get("Target", ""))
    raise MeshError("it names no 3-D model part; expected a 3MF package")


def _add_object(
    package: Package,
    part: str,
    object_id: str | None,
    matrix: NDArray[np.float64],
    inside: tuple[tuple[str, str | None], ...],
) -> None:
    """Append an object, and the objects it is made of, to the package's pieces."""
    if (part, object_id) in inside or len(package.pieces) > MAX_PARTS:
        raise MeshError("object {object_id} contains itself or too many parts", object_id=object_id)
    model = package.model(part)
    objects = (
        o for o in model.iterfind(f"{CORE}resources/{CORE}object") if o.get("id") == object_id
    )
    solid = next(objects, None)
    if solid is None:
        raise MeshError(
            "it refers to object {object_id}, which it does not contain",
            object_id=object_id,
        )
    mesh = solid.find(f"{CORE}mesh")
    if mesh is not None:
        package.pieces.append(_read_mesh(package, part, solid, mesh, matrix))
    for component in solid.iterfind(f"{CORE}components/{CORE}component"):
        inner = component.get(f"{PRODUCTION}path", part)
        local = _parse_matrix(component.get("transform")) @ matrix
        _add_object(package, inner, component.get("objectid"), local, (*inside, (part, object_id)))


def _parse_matrix(text: str | None) -> NDArray[np.float64]:
    """Return the 4 x 4 matrix for row vectors, p' = p M, of 12 numbers row by row."""
    matrix = np.eye(4)
    if text is not None:
        matrix[:, :3] = np.array(text.split(), np.float64).reshape(4, 3)
    return matrix


def _read_mesh(
    package: Package,
    part: str,
    solid: ElementTree.Element,
    mesh: ElementTree.Element,
    matrix: NDArray[np.float64],
) -> RawMesh:
    points = [[v.get(k, "nan") for k in "xyz"] for v in mesh.iter(f"{CORE}vertex")]
    vertices = np.array(points, np.float64).reshape(-1, 3) @ matrix[:3, :3] + matrix[3, :3]
    triangles = list(mesh.iter(f"{CORE}triangle"))
    ids = [[t.get(k, "-1") for k in ("v1", "v2", "v3")] for t in triangles]
    faces = np.array(ids, np.int64).reshape(-1, 3)
    if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
        bad = faces.min() if faces.min() < 0 else faces.max()
        raise MeshError(
            "a triangle refers to vertex {bad}; expected 0 to {last}",
            bad=bad,
            last=len(vertices) - 1,
        )
    seen = package.paint.see(part, package.model(part), solid, triangles)
    codes = [next((t.get(k, "") for k in t.keys() if k.endswith(PAINTED)), "") for t in triangles]  # noqa: SIM118
    plain = ~seen.coloured & (seen.look_of < 0)
    if any(code for code, own in zip(codes, plain, strict=True) if own):
        if len(package.filaments) and plain.all():
            vertices, faces, filaments = _split_as_painted(vertices, faces, codes)
            seen = _see_filaments(package.filaments, filaments, package.paint)
        else:
            package.paint.dropped.add(LEFT_OUT["painted"])
    corners = None if seen.colours is None else seen.colours.reshape(-1, 3, 3)
    uv = seen.uv.reshape(-1, 3, 2)
    colours = None if corners is None else _mean_colours(seen, faces, len(vertices))
    if np.linalg.det(matrix[:3, :3]) < 0.0:
        faces, uv = faces[:, ::-1], uv[:, ::-1]
        corners = None if corners is None else corners[:, ::-1]
    return RawMesh.of_triangles(
        vertices, faces, colours=colours, look_of=seen.look_of, uv=uv.reshape(-1, 2),
        corner_colours=None if corners is None else corners.reshape(-1, 3).astype(np.uint8),
    )  # fmt: skip


def _mean_colours(seen: Seen, faces: NDArray[np.int64], n_vertices: int) -> NDArray[np.uint8]:
    """Return the mean colour of each vertex's corners, white where there is none."""
    corners = faces[seen.coloured].ravel()
    assert seen.colours is not None, "there are means of colours only"
    codes = seen.colours.reshape(-1, 3, 3)[seen.coloured].reshape(-1, 3)
    weight = np.bincount(corners, minlength=n_vertices)[:, None]
    total = [np.bincount(corners, codes[:, k], n_vertices) for k in range(3)]
    mean = np.where(weight > 0, np.stack(total, axis=1) / np.maximum(weight, 1), 255.0)
    return np.floor(mean + 0.5).astype(np.uint8)


# ---- Painted in slicers --------------------------------------------------------------------------
# Bambu Studio, Orca and PrusaSlicer paint with filaments, and halve the edges of triangles where
# paint ends. A triangle's attribute is that tree in hexadecimal digits, the last one first: of
# each digit the low two bits are how many edges are halved, the others which corner comes first,
# or the filament, 0 for the part's own and 3 for 3 more than the next digit. Children come from
# the last to the first.


SETTINGS = "Metadata/project_settings.config"  # Bambu Studio's and Orca's, JSON
PRUSA_SETTINGS = "Metadata/Slic3r_PE.config"
_PRUSA_COLOURS = re.compile(r"^; (extruder|filament)_colour = (.*)$", re.MULTILINE)


def _read_filaments(archive: zipfile.ZipFile) -> NDArray[np.float64]:
    """Return the colours (k, 3) of the filaments that a slicer's settings name; none: (0, 3)."""
    there = set(archive.namelist())
    named: list[str] = []
    if SETTINGS in there:
        try:
            settings = json.loads(archive.read(SETTINGS))
            named = list(settings["filament_colour"])
        except (ValueError, KeyError, TypeError, RecursionError):
            pass
    elif PRUSA_SETTINGS in there:
        text = archive.read(PRUSA_SETTINGS).decode("utf-8", "replace")
        lists = {
            kind: line.replace('"', "").split(";") for kind, line in _PRUSA_COLOURS.findall(text)
        }
        own = lists.get("extruder", [])  # where an extruder has none it shows its filament's
        named = [
            (own[k].strip() if k < len(own) else "") or colour.strip()
            for k, colour in enumerate(lists.get("filament", own))
        ]
    try:
        codes = [_parse_hex(colour) for colour in named]
    except (MeshError, AttributeError):
        codes = []
    return np.array(codes, np.float64).reshape(-1, 3)


def _see_filaments(colours: NDArray[np.float64], filaments: list[int], paint: Paint3mf) -> Seen:
    """Return the looks of triangles in filaments counted from 0, -1 for the part's own."""
    which = np.array(filaments)
    if which.max() >= len(colours):
        paint.dropped.add(Message("colours of filaments that its settings do not name"))
        which[which >= len(colours)] = -1
    n = len(which)
    corners = np.repeat(colours[np.maximum(which, 0)], 3, axis=0)
    return Seen(corners, np.ones(n, np.bool_), np.full(n, -1), np.full((3 * n, 2), np.nan))


def _split_as_painted(
    vertices: NDArray[np.float64], faces: NDArray[np.int64], codes: Sequence[str]
) -> tuple[NDArray[np.float64], NDArray[np.int64], list[int]]:
    """Return vertices and triangles split where they are painted, and the filament of each.

    What lies beside a split edge is split there, too, from a vertex in its middle: the surface
    stays closed.
    """
    halves: dict[tuple[int, int], int] = {}
    n = len(vertices)

    def half(a: int, b: int) -> int:
        return halves.setdefault((a, b) if a < b else (b, a), n + len(halves))

    leaves = [
        leaf
        for (a, b, c), code in zip(faces.tolist(), codes, strict=True)
        for leaf in _read_leaves((a, b, c), code, half)
    ]
    points = np.concatenate([vertices, np.empty((len(halves), 3))])
    for (a, b), k in halves.items():  # those of finer edges come later
        points[k] = 0.5 * (points[a] + points[b])

    def edge_path(a: int, b: int) -> list[int]:
        """The vertices from a to b, without b."""
        vertex_ids, open_edges = [], [(a, b)]
        while open_edges:
            a, b = open_edges.pop()
            middle = halves.get((a, b) if a < b else (b, a))
            if middle is None:
                vertex_ids.append(a)
            else:
                open_edges += [(middle, b), (a, middle)]
        return vertex_ids

    triangles: list[tuple[int, int, int]] = []
    filaments: list[int] = []
    middles: list[NDArray[np.float64]] = []
    for corners, filament in leaves:
        a, b, c = corners
        ring = [*edge_path(a, b), *edge_path(b, c), *edge_path(c, a)]
        if len(ring) == 3:
            parts = [corners]
        else:
            middle = len(points) + len(middles)
            middles.append(points[list(corners)].mean(axis=0))
            parts = [(p, q, middle) for p, q in zip(ring, [*ring[1:], ring[0]], strict=True)]
        triangles += parts
        filaments += [filament] * len(parts)
    points = np.concatenate([points, np.reshape(middles, (-1, 3))])
    return points, np.array(triangles, np.int64).reshape(-1, 3), filaments


def _read_leaves(
    corners: tuple[int, int, int], code: str, half: Callable[[int, int], int]
) -> list[tuple[tuple[int, int, int], int]]:
    """The parts of a painted triangle, and the filament of each, from 0; -1 is the part's own."""
    if not code:
        return [(corners, -1)]
    leaves, left = [], [corners]
    try:
        digits = iter([int(digit, 16) for digit in reversed(code.strip())])
        while left:
            a, b, c = left.pop()
            split, code_bits = (digit := next(digits)) & 3, digit >> 2
            if not split:
                filament = 3 + next(digits) if code_bits == 3 else code_bits
                leaves.append(((a, b, c), filament - 1))
                continue
            a, b, c = ((a, b, c), (b, c, a), (c, a, b))[code_bits % 3]
            if split == 1:
                left += [(a, b, half(b, c)), (half(b, c), c, a)]
            elif split == 2:
                ab, ca = half(a, b), half(a, c)
                left += [(a, ab, ca), (ab, b, ca), (b, c, ca)]
            else:
                ab, bc, ca = half(a, b), half(b, c), half(c, a)
                left += [(a, ab, ca), (ab, b, bc), (bc, c, ca), (ab, bc, ca)]
    except (ValueError, StopIteration):
        raise MeshError(
            "the painting of a triangle is {code!r:.40}; expected the digits of a slicer", code=code
        ) from None
    return leaves


# ---- Writing -------------------------------------------------------------------------------------


def write_3mf(
    path: Path,
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    srgb: NDArray[np.uint8],
    *,
    name: str = "painting",
    unit: str = "mm",
    palette: NDArray[np.uint8] | None = None,
    face_filaments: NDArray[np.int32] | None = None,
) -> None:
    """Write one object with the colours of all three corners, or one filament, on each triangle.

    Vertices at one position become one, so that what was closed is closed in the file although its
    creases had several normals. The specification forbids triangles that name a vertex twice;
    they are left out.

    Parameters
    ----------
    path : Path
    vertices : (V, 3) float32
    faces : (F, 3) int32
    srgb : (V, 3) uint8
    name : str
        Of the object.
    unit : {"mm", "cm", "m", "in"}
        Of the vertices.
    palette : (k, 3) uint8, optional
        Filaments: a colour group, and up to 16 as slicers themselves paint; triangles then come
        filament by filament.
    face_filaments : (F,) int32
        With `palette`, the one for each triangle.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    points, point_of = _weld(vertices)
    corners = point_of[faces]
    sound = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    beside: dict[str, str] = {}
    if palette is None or face_filaments is None:
        colours, colour_ids = _distinct_colours(srgb)
        properties = colour_ids[faces[sound]]
        triangles = np.concatenate([corners[sound], properties], axis=1, dtype=np.int32)
        body = text_rows(_triangle_row('p1="{i3}" p2="{i4}" p3="{i5}"'), integers=triangles)
        parts = _write_model(points, body, colours, name, UNIT_NAMES[unit])
    else:
        colours = [f"#{bytes(colour).hex().upper()}" for colour in palette]
        body = _write_by_filament(corners[sound], face_filaments[sound], len(palette))
        parts = _write_model(points, body, colours, name, UNIT_NAMES[unit], for_slicers=True)
        if len(palette) <= MOST_PAINTED:
            beside = _slicer_settings(colours, name)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=FASTEST) as archive:
        archive.writestr(_zip_entry("[Content_Types].xml"), CONTENT_TYPES)
        archive.writestr(_zip_entry("_rels/.rels"), RELATIONS)
        # by its name alone it gets the archive's compression, and the fixed date all the same
        with archive.open("3D/3dmodel.model", "w", force_zip64=True) as file:
            file.writelines(parts)
        for part, text in beside.items():
            archive.writestr(_zip_entry(part), text)


def _triangle_row(properties: str) -> str:
    return f'<triangle v1="{{i0}}" v2="{{i1}}" v3="{{i2}}" pid="1" {properties}/>\n'


def _zip_entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, EARLIEST)
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry


def _weld(vertices: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return the distinct positions in the order of the vertices, and each vertex's index."""
    from paint3d.mesh.base_surface import weld

    points, point_of = weld(vertices)
    _, first = np.unique(point_of, return_index=True)
    return points[first], point_of


def _distinct_colours(srgb: NDArray[np.uint8]) -> tuple[list[str], NDArray[np.int32]]:
    """Return the different colours as hex, and the index of each vertex's."""
    packed = (srgb.astype(np.uint32) << np.array([16, 8, 0], np.uint32)).sum(axis=1)
    used = np.zeros(1 << 24, np.int32)
    used[packed] = 1
    colours = np.flatnonzero(used)
    used[colours] = np.arange(len(colours), dtype=np.int32)
    return [f"#{colour:06X}" for colour in colours.tolist()], used[packed]


def _write_model(
    points: NDArray[np.float32],
    triangles: Iterable[bytes],
    colours: list[str],
    name: str,
    unit: str,
    *,
    for_slicers: bool = False,
) -> Iterator[bytes]:
    """Yield the model part: one object, for slicers as one part of another, with their names."""
    schemas, metadata = "", ""
    if for_slicers:
        schemas = f' xmlns:slic3rpe="{PRUSA_SCHEMA}" xmlns:BambuStudio="{BAMBU_SCHEMA}"'
    if for_slicers and len(colours) <= MOST_PAINTED:
        metadata = (
            f'<metadata name="Application">{BAMBU}</metadata>\n'
            '<metadata name="BambuStudio:3mfVersion">1</metadata>\n'
            '<metadata name="Description">painted by paint3d</metadata>\n'
        )
    group = "".join(f'<m:color color="{colour}"/>\n' for colour in colours)
    yield (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="{unit}" xml:lang="en-US"'
        f' xmlns="{CORE_SCHEMA}" requiredextensions="m" xmlns:m="{MATERIAL_SCHEMA}"{schemas}>\n'
        f'{metadata}<resources>\n<m:colorgroup id="1">\n{group}</m:colorgroup>\n'
        f'<object id="2" name={quoteattr(name)} type="model" pid="1" pindex="0">'
        "<mesh><vertices>\n"
    ).encode()
    yield from text_rows('<vertex x="{f0}" y="{f1}" z="{f2}"/>\n', points)
    yield b"</vertices><triangles>\n"
    yield from triangles
    yield b"</triangles></mesh></object>\n"
    if for_slicers:
        yield (
            f'<object id="3" name={quoteattr(name)} type="model"><components>'
            '<component objectid="2"/></components></object>\n'
        ).encode()
    item = 3 if for_slicers else 2
    yield f'</resources>\n<build><item objectid="{item}"/></build>\n</model>\n'.encode()


# ---- For slicers ---------------------------------------------------------------------------------
# What Bambu Studio, Orca and PrusaSlicer write themselves where triangles are painted. They compare
# names with their prefix, so that m and slic3rpe are part of them. Bambu Studio and Orca read their
# own settings, among them the colours of filaments, only of a file that says that Bambu Studio made
# it; of versions, 02.00.00.00 is one that both of them take.


def _write_by_filament(
    corners: NDArray[np.int32], filaments: NDArray[np.int32], n_filaments: int
) -> Iterator[bytes]:
    """Yield triangles filament by filament, in their order within each."""
    for k in range(n_filaments):
        properties = f'p1="{k}"'
        if n_filaments <= MOST_PAINTED:
            code = _paint_code(k + 1)
            properties += f' paint_color="{code}" slic3rpe:mmu_segmentation="{code}"'
        own = np.ascontiguousarray(corners[filaments == k], np.int32)
        if len(own):
            yield from text_rows(_triangle_row(properties), integers=own)


def _paint_code(filament: int) -> str:
    """Slicers' code for a triangle of a single filament, counted from 1.

    Hexadecimal digits, the last one first: two bits of how it is split, which it is not, two of the
    filament; from the third on these are both set, and another digit counts on.
    """
    return f"{filament << 2:X}" if filament < _CODED else f"{filament - _CODED:X}C"


def _slicer_settings(colours: list[str], name: str) -> dict[str, str]:
    """Return the parts of a package with the filaments' colours, and the object's type."""
    called = f'<metadata key="name" value={quoteattr(name)}/>'
    return {
        "Metadata/project_settings.config": json_text(
            {"filament_colour": colours, "from": "project", "name": "project_settings",
             "version": BAMBU.rpartition("-")[2]}
        ),
        "Metadata/model_settings.config": (
            f'<?xml version="1.0" encoding="UTF-8"?>\n<config>\n<object id="3">{called}'
            '<metadata key="extruder" value="1"/>\n'
            f'<part id="2" subtype="normal_part">{called}</part>\n</object>\n</config>\n'
        ),
    }  # fmt: skip
