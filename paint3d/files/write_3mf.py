"""3MF for colour printers: millimetres, sRGB colours at every corner of every triangle."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

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
MODEL = """<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xml:lang="en-US" requiredextensions="m"
 xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
 xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02">
<resources>
"""
EARLIEST = (1980, 1, 1, 0, 0, 0)  # a fixed date: the same painting gives the same bytes
CHUNK = 100_000
FASTEST = 1


def write_3mf(
    path: Path,
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    srgb: NDArray[np.uint8],
    *,
    name: str = "painting",
) -> None:
    """Write one object with a colour group and the colour of all three corners on each triangle.

    The specification forbids triangles that name a vertex twice; they are left out.

    Parameters
    ----------
    path : Path
    vertices : (V, 3) float32, mm
    faces : (F, 3) int32
    srgb : (V, 3) uint8
    name : str
        Of the object.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=FASTEST) as archive:
        archive.writestr(_entry("[Content_Types].xml"), CONTENT_TYPES)
        archive.writestr(_entry("_rels/.rels"), RELATIONS)
        with archive.open(_entry("3D/3dmodel.model"), "w", force_zip64=True) as file:
            for text in _model(vertices, faces, srgb, name):
                _write(file, text)


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, EARLIEST)
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry


def _write(file: IO[bytes], text: str) -> None:
    file.write(text.encode("utf-8"))


def _model(vertices: NDArray, faces: NDArray, srgb: NDArray, name: str) -> Iterator[str]:
    """Yield the text of the model part."""
    packed = srgb.astype(np.uint32) @ np.array([65536, 256, 1], np.uint32)
    colours, colour_ids = np.unique(packed, return_inverse=True)
    yield MODEL
    yield '<m:colorgroup id="1">\n'
    yield "".join(f'<m:color color="#{colour:06X}"/>\n' for colour in colours.tolist())
    yield "</m:colorgroup>\n"
    yield f'<object id="2" name={quoteattr(name)} type="model" pid="1" pindex="0">'
    yield "<mesh><vertices>\n"
    yield from _rows('<vertex x="%.6f" y="%.6f" z="%.6f"/>\n', vertices)
    yield "</vertices><triangles>\n"
    corners = np.concatenate([faces, colour_ids[faces]], axis=1)
    row = '<triangle v1="%d" v2="%d" v3="%d" pid="1" p1="%d" p2="%d" p3="%d"/>\n'
    yield from _rows(row, corners)
    yield "</triangles></mesh></object>\n</resources>\n"
    yield '<build><item objectid="2"/></build>\n</model>\n'


def _rows(row: str, table: NDArray) -> Iterator[str]:
    for first in range(0, len(table), CHUNK):
        part = table[first : first + CHUNK]
        yield row * len(part) % tuple(part.ravel().tolist())
