"""VRML97 (ISO/IEC 14772-1), which the older colour printers take."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.files.writers.text_rows import UNIT_NAMES, text_rows

__all__ = ["write_wrl"]


def write_wrl(
    path: Path,
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    normals: NDArray[np.float32],
    srgb: NDArray[np.uint8],
    *,
    name: str = "painting",
    unit: str = "m",
) -> None:
    """Write one IndexedFaceSet with a colour and a normal at each vertex.

    The standard says metres with y up (4.4.5) and nothing of colour spaces; programs take the
    colours as sRGB.

    Parameters
    ----------
    path : Path
    vertices : (V, 3) float32
    faces : (F, 3) int32
    normals : (V, 3) float32, unit
    srgb : (V, 3) uint8
    name : str
        The world's title.
    unit : {"mm", "cm", "m", "in"}
        Of the vertices, to be named in the file.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    title = json.dumps(name, ensure_ascii=False)  # a string is escaped as in VRML
    row = "{f0} {f1} {f2}\n"
    with open(path, "wb") as file:
        file.write(
            f'#VRML V2.0 utf8\nWorldInfo {{ title {title} info "unit: {UNIT_NAMES[unit]}" }}\n'
            "Shape {\nappearance Appearance { material Material { diffuseColor 1 1 1 } }\n"
            "geometry IndexedFaceSet {\nsolid FALSE\ncoord Coordinate { point [\n".encode()
        )
        file.writelines(text_rows(row, vertices))
        file.write(b"] }\nnormal Normal { vector [\n")
        file.writelines(text_rows(row, normals))
        file.write(b"] }\ncolor Color { color [\n")
        file.writelines(text_rows(row, np.divide(srgb, 255, dtype=np.float32)))
        file.write(b"] }\ncoordIndex [\n")
        file.writelines(text_rows("{i0} {i1} {i2} -1\n", integers=faces))
        file.write(b"]\n}\n}\n")
