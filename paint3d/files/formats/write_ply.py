"""Binary PLY in the one dialect that every program reads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["write_ply"]


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
