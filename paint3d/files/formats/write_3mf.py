"""3MF for printers: sRGB at every corner of every triangle, or one filament a triangle."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from paint3d.files.formats.text_rows import text_rows

__all__ = ["write_3mf"]

CONTENT_TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
RELATIONS = """<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Id="rel0" Target="/3D/3dmodel.model"
 Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIALS = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
UNIT_NAMES = {"mm": "millimeter", "cm": "centimeter", "m": "meter", "in": "inch"}
EARLIEST = (1980, 1, 1, 0, 0, 0)  # a fixed date: the same painting gives the same bytes
FASTEST = 1


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
    """Write one object with the colours of all three corners, or one material, on each triangle.

    Vertices in one place become one, so that what was closed is closed in the file although its
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
        Filaments: materials of the core specification, which slicers map to their extruders.
    face_filaments : (F,) int32
        With `palette`, the one for each triangle.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    places, place_of = _weld(vertices)
    corners = place_of[faces]
    sound = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    if palette is None or face_filaments is None:
        colours, colour_ids = _colours(srgb)
        resource = _colour_group(colours)
        properties = colour_ids[faces[sound]]
    else:
        resource = _base_materials(palette)
        properties = face_filaments[sound, None]
    triangles = np.concatenate([corners[sound], properties], axis=1, dtype=np.int32)
    parts = _model(places, triangles, resource, name, UNIT_NAMES[unit])
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=FASTEST) as archive:
        archive.writestr(_entry("[Content_Types].xml"), CONTENT_TYPES)
        archive.writestr(_entry("_rels/.rels"), RELATIONS)
        # by its name alone it gets the archive's compression, and the fixed date all the same
        with archive.open("3D/3dmodel.model", "w", force_zip64=True) as file:
            file.writelines(parts)


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, EARLIEST)
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry


def _weld(vertices: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return the different positions in the order of the vertices, and each vertex's one."""
    from paint3d.mesh.kernels.topology import weld_positions

    points = np.ascontiguousarray(vertices, np.float32) + np.float32(0.0)  # no minus zero
    table = np.full(1 << (2 * len(points)).bit_length(), -1, np.int32)
    place_of = np.empty(len(points), np.int32)
    weld_positions(points.view(np.uint32), table, place_of)
    _, first = np.unique(place_of, return_index=True)
    return points[first], place_of


def _colours(srgb: NDArray[np.uint8]) -> tuple[list[str], NDArray[np.int32]]:
    """Return the different colours as hex, and the place of each vertex's one."""
    packed = (srgb.astype(np.uint32) << np.array([16, 8, 0], np.uint32)).sum(axis=1)
    used = np.zeros(1 << 24, np.int32)
    used[packed] = 1
    colours = np.flatnonzero(used)
    used[colours] = np.arange(len(colours), dtype=np.int32)
    return [f"#{colour:06X}" for colour in colours.tolist()], used[packed]


def _colour_group(colours: list[str]) -> str:
    lines = "".join(f'<m:color color="{colour}"/>\n' for colour in colours)
    return f'<m:colorgroup id="1">\n{lines}</m:colorgroup>\n'


def _base_materials(palette: NDArray[np.uint8]) -> str:
    codes = [bytes(colour).hex().upper() for colour in palette]
    lines = "".join(
        f'<base name="filament {k} #{code}" displaycolor="#{code}"/>\n'
        for k, code in enumerate(codes, 1)
    )
    return f'<basematerials id="1">\n{lines}</basematerials>\n'


def _model(
    places: NDArray[np.float32], triangles: NDArray[np.int32], resource: str, name: str, unit: str
) -> Iterator[bytes]:
    """Yield the model part; triangles have three corners, and one property or three."""
    three = triangles.shape[1] > 4
    extension = f' requiredextensions="m" xmlns:m="{MATERIALS}"' if three else ""
    yield (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="{unit}" xml:lang="en-US"'
        f' xmlns="{CORE}"{extension}>\n<resources>\n{resource}'
        f'<object id="2" name={quoteattr(name)} type="model" pid="1" pindex="0">'
        "<mesh><vertices>\n"
    ).encode()
    yield from text_rows('<vertex x="{f0}" y="{f1}" z="{f2}"/>\n', places)
    yield b"</vertices><triangles>\n"
    properties = 'p1="{i3}" p2="{i4}" p3="{i5}"' if three else 'p1="{i3}"'
    row = f'<triangle v1="{{i0}}" v2="{{i1}}" v3="{{i2}}" pid="1" {properties}/>\n'
    yield from text_rows(row, integers=triangles)
    yield b"</triangles></mesh></object>\n</resources>\n"
    yield b'<build><item objectid="2"/></build>\n</model>\n'
