"""Wavefront OBJ with colours after the positions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.files.formats.text_rows import UNIT_NAMES, text_rows

__all__ = ["write_obj"]


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
        head = f"# paint3d: {UNIT_NAMES[unit]}, vertex colours sRGB 0 to 1\no {_word(name)}\n"
        file.write(head.encode("ascii"))
        file.writelines(text_rows("v {f0} {f1} {f2} {f3} {f4} {f5}\n", points))
        file.writelines(text_rows("vn {f0} {f1} {f2}\n", normals))
        corners = "f {i0}//{i0} {i1}//{i1} {i2}//{i2}\n"
        file.writelines(text_rows(corners, integers=faces + np.int32(1)))


def _word(name: str) -> str:
    """Return a name as one printable ASCII word."""
    return "".join(c if c.isascii() and c.isalnum() else "_" for c in name) or "painting"
