"""3MF: the build items of the package's model as one mesh, with colours where it has them."""

from __future__ import annotations

import io
import posixpath
import zipfile
import zlib
from dataclasses import dataclass, field, replace
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.files.contents import parse_xml
from paint3d.files.raw_mesh import RawMesh, left_out

__all__ = ["read_3mf"]

UNITS_MM = {
    "micron": 1e-3,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "inch": 25.4,
    "foot": 304.8,
    "meter": 1000.0,
}
CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
MATERIAL = "{http://schemas.microsoft.com/3dmanufacturing/material/2015/02}"
LEFT_OUT = {
    f"{MATERIAL}texture2dgroup": "its pictures",
    f"{MATERIAL}compositematerials": "mixtures of materials",
    f"{MATERIAL}multiproperties": "mixtures of materials",
}
LATTICE = "{http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02}beamlattice"
PRODUCTION = "{http://schemas.microsoft.com/3dmanufacturing/production/2015/06}"
MODEL_RELATION = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
MAX_UNPACKED = 1 << 30
MAX_PARTS = 10_000


@dataclass
class Package:
    """An opened archive: model parts already parsed, and pieces of mesh found so far."""

    archive: zipfile.ZipFile
    models: dict[str, ElementTree.Element] = field(default_factory=dict)
    pieces: list[RawMesh] = field(default_factory=list)

    def model(self, part: str) -> ElementTree.Element:
        """Return the root of a model part."""
        if part not in self.models:
            try:
                self.models[part] = parse_xml(self.archive.read(part.lstrip("/")), part)
            except KeyError:
                raise MeshError(f"it refers to {part!r}, which it does not contain") from None
        return self.models[part]


def read_3mf(data: bytes) -> RawMesh:
    """Read a 3MF package: core, materials (colours), and components in other parts.

    A vertex whose corners have different colours gets their mean.

    Parameters
    ----------
    data : bytes
        The whole file.

    Raises
    ------
    MeshError
        If the archive is broken, encrypted or packed in an unusual way, over 1 GiB unpacked, or
        has no build items with triangles.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            _check_entries(archive)
            return _read_package(Package(archive))
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError) as cause:
        raise MeshError(f"it is not a readable 3MF archive: {cause}") from None


def _check_entries(archive: zipfile.ZipFile) -> None:
    """Refuse what is too large, and what the Open Packaging Conventions (ECMA-376-2) forbid."""
    entries = archive.infolist()
    if sum(entry.file_size for entry in entries) > MAX_UNPACKED:
        raise MeshError(f"it unpacks to over {MAX_UNPACKED >> 30} GiB; expected less")
    for entry in entries:
        if entry.flag_bits & 1 or entry.compress_type not in PACKINGS:
            how = "encrypted" if entry.flag_bits & 1 else f"packed by method {entry.compress_type}"
            raise MeshError(f"its {entry.filename!r:.60} is {how}; expected it plain or deflated")


def _read_package(package: Package) -> RawMesh:
    start = _start_part(package.archive)
    model = package.model(start)
    unit = model.get("unit", "millimeter")
    if unit not in UNITS_MM:
        raise MeshError(f"its unit is {unit!r}; expected one of {', '.join(UNITS_MM)}")
    for item in model.iterfind(f"{CORE}build/{CORE}item"):
        part = item.get(f"{PRODUCTION}path", start)
        _place(package, part, item.get("objectid"), _matrix(item.get("transform")), ())
    if not package.pieces:
        raise MeshError("it has no build items with triangles; expected a surface")
    raw = _merged(package.pieces, UNITS_MM[unit])
    dropped, beams = _dropped(package), _has_beams(package)
    if not len(raw.sizes):
        what = "a beam lattice, which is not read" if beams else "a mesh"
        return replace(raw, announces=what, notes=left_out(dropped))
    return replace(raw, notes=left_out(dropped | ({"beam lattices"} if beams else set())))


def _has_beams(package: Package) -> bool:
    objects = f"{CORE}resources/{CORE}object/{CORE}mesh/{LATTICE}"
    return any(root.find(objects) is not None for root in package.models.values())


def _dropped(package: Package) -> set[str]:
    """What its parts say of colours that is not read."""
    roots = package.models.values()
    tags = {element.tag for root in roots for element in root.iterfind(f"{CORE}resources/*")}
    return {what for tag, what in LEFT_OUT.items() if tag in tags}


def _start_part(archive: zipfile.ZipFile) -> str:
    try:
        relations = parse_xml(archive.read("_rels/.rels"), "_rels/.rels")
    except KeyError:
        raise MeshError("it has no _rels/.rels; expected a 3MF package") from None
    for relation in relations:
        if relation.get("Type") == MODEL_RELATION:
            return posixpath.join("/", relation.get("Target", ""))
    raise MeshError("it names no 3-D model part; expected a 3MF package")


def _place(
    package: Package,
    part: str,
    object_id: str | None,
    matrix: NDArray[np.float64],
    inside: tuple[tuple[str, str | None], ...],
) -> None:
    """Append an object, and the objects it is made of, to the package's pieces."""
    if (part, object_id) in inside or len(package.pieces) > MAX_PARTS:
        raise MeshError(f"object {object_id} contains itself or too many parts")
    model = package.model(part)
    found = (o for o in model.iterfind(f"{CORE}resources/{CORE}object") if o.get("id") == object_id)
    solid = next(found, None)
    if solid is None:
        raise MeshError(f"it refers to object {object_id}, which it does not contain")
    mesh = solid.find(f"{CORE}mesh")
    if mesh is not None:
        package.pieces.append(_mesh(model, solid, mesh, matrix))
    for component in solid.iterfind(f"{CORE}components/{CORE}component"):
        inner = component.get(f"{PRODUCTION}path", part)
        local = _matrix(component.get("transform")) @ matrix
        _place(package, inner, component.get("objectid"), local, (*inside, (part, object_id)))


def _matrix(text: str | None) -> NDArray[np.float64]:
    """Return the 4 x 4 matrix for row vectors, p' = p M, of 12 numbers row by row."""
    matrix = np.eye(4)
    if text is not None:
        matrix[:, :3] = np.array(text.split(), np.float64).reshape(4, 3)
    return matrix


def _mesh(
    model: ElementTree.Element,
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
        raise MeshError(f"a triangle refers to vertex {bad}; expected 0 to {len(vertices) - 1}")
    colours = _colours(model, solid, triangles, faces, len(vertices))
    if np.linalg.det(matrix[:3, :3]) < 0.0:
        faces = faces[:, ::-1]
    return RawMesh.of_triangles(vertices, faces, colours=colours)


def _colours(
    model: ElementTree.Element,
    solid: ElementTree.Element,
    triangles: list[ElementTree.Element],
    faces: NDArray[np.int64],
    n_vertices: int,
) -> NDArray[np.uint8] | None:
    """Return the mean colour of each vertex's corners, white where there is none."""
    palettes = _palettes(model)
    rows, colours = [], []
    for k, triangle in enumerate(triangles):
        palette = palettes.get(triangle.get("pid", solid.get("pid")))
        if palette is None:
            continue
        first = triangle.get("p1", solid.get("pindex", "0"))
        rows.append(k)
        colours += [palette[int(triangle.get(name, first))] for name in ("p1", "p2", "p3")]
    if not rows:
        return None
    corners, codes = faces[rows].ravel(), np.array(colours, np.float64)
    weight = np.bincount(corners, minlength=n_vertices)[:, None]
    total = [np.bincount(corners, codes[:, k], n_vertices) for k in range(3)]
    mean = np.where(weight > 0, np.stack(total, axis=1) / np.maximum(weight, 1), 255.0)
    return np.floor(mean + 0.5).astype(np.uint8)


def _palettes(model: ElementTree.Element) -> dict[str | None, list[tuple[int, int, int]]]:
    """Return the sRGB codes of every colour group and base material list, by resource id."""
    palettes = {}
    kinds = ((f"{MATERIAL}colorgroup", "color"), (f"{CORE}basematerials", "displaycolor"))
    for tag, attribute in kinds:
        for group in model.iter(tag):
            palettes[group.get("id")] = [_hex(entry.get(attribute)) for entry in group]
    return palettes


def _hex(text: str | None) -> tuple[int, int, int]:
    code = (text or "").strip().lstrip("#")
    if len(code) not in (6, 8):
        raise MeshError(f"a colour is {text!r}; expected #RRGGBB")
    return int(code[0:2], 16), int(code[2:4], 16), int(code[4:6], 16)


def _merged(pieces: list[RawMesh], unit_mm: float) -> RawMesh:
    first = np.cumsum([0, *(len(piece.vertices) for piece in pieces)])
    colours = None
    if any(piece.colours is not None for piece in pieces):
        blank = [np.full((len(piece.vertices), 3), 255, np.uint8) for piece in pieces]
        pairs = zip(pieces, blank, strict=True)
        colours = np.concatenate([b if p.colours is None else p.colours for p, b in pairs])
    return RawMesh(
        np.concatenate([piece.vertices for piece in pieces]),
        np.concatenate([p.corners + n for p, n in zip(pieces, first, strict=False)]),
        np.concatenate([piece.sizes for piece in pieces]),
        colours,
        unit_mm=unit_mm,
        up="z",
    )
