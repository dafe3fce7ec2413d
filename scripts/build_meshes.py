#!/usr/bin/env python3
"""Write the built-in objects, meshes/*.ply, and their table, meshes/README.md.

The files are a function of scripts/solids.py alone; run this after changing it.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from paint3d.files.formats.ply import write_ply
from paint3d.mesh.triangle_mesh import TriangleMesh
from scripts.solids import make_bowl, make_plane, make_plate, make_sphere, make_vase

FOLDER = Path(__file__).resolve().parents[1] / "meshes"
HEADER = """# Built-in objects

Written by `python -m scripts.build_meshes` from the formulas in `scripts/solids.py`; do not edit by
hand. Ours, MIT licence like the rest of the project. Millimetres, z up; vessels stand on z = 0
with z as their axis. Binary little-endian PLY with the exact normals of the shape.

| file | size (mm) | vertices | triangles | area (mm2) | closed | bytes | sha256 |
|---|---|---|---|---|---|---|---|
"""


def main() -> None:
    """Write every object and the table."""
    rows = []
    for make in (make_bowl, make_plate, make_vase, make_sphere, make_plane):
        mesh = make()
        path = FOLDER / f"{mesh.name}.ply"
        write_ply(path, mesh.vertices, mesh.faces, mesh.normals)
        rows.append(row(mesh, path.read_bytes()))
    (FOLDER / "README.md").write_text(HEADER + "".join(rows), encoding="utf-8")


def row(mesh: TriangleMesh, data: bytes) -> str:
    """Return the table row of one object."""
    low, high = mesh.bounds
    size = " x ".join(f"{extent:.4g}" for extent in high - low)
    closed = "no" if mesh.name == "plane" else "yes"
    return (
        f"| {mesh.name}.ply | {size} | {mesh.n_vertices} | {mesh.n_faces} | {mesh.area:.0f} "
        f"| {closed} | {len(data)} | {hashlib.sha256(data).hexdigest()} |\n"
    )


if __name__ == "__main__":
    main()
