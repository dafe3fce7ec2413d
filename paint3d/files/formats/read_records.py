"""Reading the paper's records, .p3d.txt, as a mesh: with its faces, or as points with normals."""

from __future__ import annotations

import numpy as np

from paint3d.files.formats.records import parse_records
from paint3d.files.raw_mesh import RawMesh

__all__ = ["read_records"]


def read_records(data: bytes) -> RawMesh:
    """Read the paper's records as a mesh: positions, normals, and the colours as its ground.

    Without faces, as in the paper, it is a cloud of points with normals, and a surface is built
    through them.

    Raises
    ------
    MeshError
        With the number of the line that is not as expected.
    """
    records = parse_records(data)
    faces = np.empty((0, 3), np.int64) if records.faces is None else records.faces
    announces = "" if records.faces is None else "faces"
    return RawMesh.of_triangles(
        records.vertices,
        faces,
        colours=records.srgb,
        normals=records.normals,
        unit_mm=1.0,
        up="z",
        announces=announces,
    )
