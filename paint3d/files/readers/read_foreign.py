"""Formats that trimesh reads and we do not: COLLADA, XAML, OpenCTM, points, plates of DXF and SVG.

Their packages are imported here, in the child process, and given bytes: a file that refers to
others gets none of them.
"""

from __future__ import annotations

import io
import tempfile
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from paint3d.core.foreign_xml import XmlFault, parse_xml
from paint3d.errors import MeshError
from paint3d.files.readers.contents import plain_text
from paint3d.files.readers.package_meshes import read_trimesh
from paint3d.files.readers.raw_mesh import RawMesh, left_out, parse_numbers
from paint3d.files.readers.vertex_colours import colour_codes

__all__ = ["FOREIGN", "read_foreign"]

_DEEPEST = 512  # elements of a stranger's XML in one another
_MOST_BYTES = 1 << 28  # of a packed document
_UP = {"X_UP": "x", "Y_UP": "y", "Z_UP": "z"}


class Foreign(NamedTuple):
    """A format: its name, the packages that trimesh needs for it, and how it is looked at first."""

    name: str
    needs: tuple[str, ...] = ()
    xml: str = ""  # "plain", or "packed": XML in a ZIP
    flat: bool = False
    named: bool = False  # its reader opens the file by itself


FOREIGN = {
    ".dae": Foreign("COLLADA", ("pycollada",), "plain"),
    ".zae": Foreign("packed COLLADA", ("pycollada",), "packed"),
    ".xaml": Foreign("XAML", ("lxml",), "plain"),
    ".ctm": Foreign("OpenCTM", ("openctm",), named=True),
    ".xyz": Foreign("a list of points"),
    ".dxf": Foreign("DXF", ("networkx", "shapely"), flat=True),
    ".svg": Foreign("SVG", ("svg.path", "lxml", "networkx", "shapely"), "plain", flat=True),
}
_INSUNITS_MM = {
    1: 25.4,
    2: 304.8,
    4: 1.0,
    5: 10.0,
    6: 1000.0,
    9: 0.0254,
    10: 914.4,
    13: 1e-3,
    14: 100.0,
}
"""Of DXF's header. trimesh's own `units` take $LUNITS, how numbers are shown, for a unit, too."""
_MODULES = {"pycollada": "collada"}  # packages whose module has another name


def read_foreign(data: bytes, suffix: str, texture: bool = False) -> RawMesh:
    """Read a file by trimesh.

    Parameters
    ----------
    data : bytes
    suffix : str
        One of `FOREIGN`.
    texture : bool
        Whether to take colours of materials; pictures beside the file are left out.

    Raises
    ------
    MeshError
        If trimesh or what it needs is missing, or it finds nothing to paint on.
    """
    form = FOREIGN[suffix]
    trimesh = _package("trimesh", form, 'pip install "paint3d[meshes]"')
    for need in form.needs:
        _package(_MODULES.get(need, need), form, _how_to_get(need))
    up = None
    for root in _documents(data, form):
        up = up or _up_of(root)
    kind = suffix[1:]
    try:
        if form.flat:
            return _flat(trimesh.load_path(io.BytesIO(data), file_type=kind))
        with tempfile.NamedTemporaryFile(suffix=suffix) if form.named else io.BytesIO() as given:
            given.write(data)
            given.flush()
            given.seek(0)
            found = trimesh.load_scene(given, file_type=kind)
        raw = _raw(found, texture)  # looks at what was only noted down until now
        if suffix == ".xyz" and raw.colours is not None:
            colours, notes = _colours_of_points(data, len(raw.vertices))
            raw = replace(raw, colours=colours, notes=(*raw.notes, *notes))
    except MeshError:
        raise
    except Exception as cause:  # of any kind: its readers trust what they read
        words = " ".join(str(cause).split()) or type(cause).__name__
        raise MeshError(f"{form.name} is read by trimesh, which says: {words:.200}") from None
    if suffix in (".dae", ".zae"):
        up = up or "y"  # as COLLADA says where a file does not
    return replace(raw, up=up)


def _raw(found: Any, texture: bool) -> RawMesh:
    clouds = [one for one in found.geometry.values() if hasattr(one, "vertices")]
    if len(clouds) == 1 and not hasattr(clouds[0], "faces"):
        return _points(clouds[0])
    return read_trimesh(found, texture)


def _how_to_get(package: str) -> str:
    return "pip install openctm" if package == "openctm" else 'pip install "paint3d[meshes]"'


def _package(module: str, form: Foreign, install: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        raise MeshError(
            f"{form.name} is read by trimesh, and {module} is missing; expected it installed: "
            f"{install} (or the object in a format that needs nothing, such as .glb)"
        ) from None


def _documents(data: bytes, form: Foreign) -> Iterator[ElementTree.Element]:
    """The XML in a file, after a look that it declares no entities."""
    if form.xml == "plain":
        yield _checked_xml(data, form)
    elif form.xml == "packed":
        try:
            with zipfile.ZipFile(io.BytesIO(data)) as package:
                if sum(entry.file_size for entry in package.infolist()) > _MOST_BYTES:
                    raise MeshError(f"it unpacks to more than {_MOST_BYTES:,} bytes; expected less")
                for entry in package.infolist():
                    content = package.read(entry)
                    if content.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] == b"<":
                        yield _checked_xml(content, form)
        except MeshError:
            raise
        except Exception as cause:  # of any kind: every packing has its own
            raise MeshError(f"{form.name} is a ZIP, which cannot be unpacked: {cause}") from None


def _checked_xml(data: bytes, form: Foreign) -> ElementTree.Element:
    try:
        return parse_xml(data, _DEEPEST, doctypes=form.flat)
    except XmlFault as fault:
        raise MeshError(f"it is not {form.name} that is read: {fault}") from None


def _up_of(root: ElementTree.Element) -> str | None:
    for element in root.iter():
        if element.tag.rpartition("}")[2] == "up_axis":
            return _UP.get((element.text or "").strip())
    return None


def _colours_of_points(data: bytes, n: int) -> tuple[NDArray[np.uint8] | None, tuple[str, ...]]:
    """Colours of a list of n points, of which trimesh makes bytes whatever they are."""
    numbers = parse_numbers(plain_text(data).replace(b",", b" "), "a point")
    rgb = numbers.reshape(n, -1)[:, 3:6]
    return colour_codes(rgb, 255 if (rgb == np.floor(rgb)).all() else 1)


def _points(cloud: Any) -> RawMesh:
    colours = getattr(cloud, "colors", None)
    vertices = np.asarray(cloud.vertices, np.float64)
    codes = None
    if colours is not None and np.shape(colours) in ((len(vertices), 3), (len(vertices), 4)):
        codes = np.ascontiguousarray(np.asarray(colours)[:, :3], np.uint8)
    return RawMesh.of_triangles(vertices, np.empty((0, 3), np.int64), colours=codes)


def _flat(path: Any) -> RawMesh:
    """The plate that the closed outlines of a drawing bound, holes left out, facing up."""
    shapely = import_module("shapely")
    outlines = [outline for outline in path.polygons_closed if outline is not None]
    if not outlines:
        raise MeshError("it has no closed outlines; expected one at least, to be a plate")
    region = shapely.symmetric_difference_all(
        outlines
    )  # even and odd: what is inside one is a hole
    cut = shapely.get_parts(shapely.constrained_delaunay_triangles(shapely.get_parts(region)))
    triangles = np.array([shapely.get_coordinates(one)[:3] for one in cut], np.float64)
    sides = triangles[:, 1:] - triangles[:, :1]
    down = sides[:, 0, 0] * sides[:, 1, 1] < sides[:, 0, 1] * sides[:, 1, 0]
    triangles[down] = triangles[down, ::-1]
    flat, faces = np.unique(triangles.reshape(-1, 2), axis=0, return_inverse=True)
    vertices = np.column_stack([flat, np.zeros(len(flat))])
    unit = _INSUNITS_MM.get(path.metadata.get("$INSUNITS", 0))
    notes = left_out(["outlines that are not closed"]) if _has_open(path) else ()
    return RawMesh.of_triangles(vertices, faces, unit_mm=unit, up="z", notes=notes)


def _has_open(path: Any) -> bool:
    return len(path.paths) > len(path.polygons_closed)
