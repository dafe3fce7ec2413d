"""A format of one's own: points with normals and colours, as text, straight from the arrays."""

import sys
from pathlib import Path

import numpy as np

import paint3d

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(exist_ok=True)

surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=1.0)
painter = paint3d.Painter(surface, "full", "azurite")
painter.stroke([(-30, 0, 0), (30, 0, 0)], pressure=(0.2, 0.5, 0.2))
vertices, faces, normals, srgb = surface.export_arrays()  # no more vertices than the colours need
rows = np.column_stack([vertices, normals, srgb])
np.savetxt(out / "cloud.xyz", rows, fmt=["%.4f"] * 6 + ["%d"] * 3)
print(f"{len(vertices)} points of {surface.n_vertices} vertices, {len(faces)} triangles")
