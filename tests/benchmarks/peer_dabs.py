#!/usr/bin/env python3
"""Paint the dabs that another program paints, on the same mesh, and print one line of JSON.

``peer_dabs.py MESH.ply DABS.json``; README.md in this folder says what they hold.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np

from paint3d.bench.dabs import time_dabs
from paint3d.bench.strokes import make_dab, record_dabs
from paint3d.files.load import load_mesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface

ROUNDS = 5


def main(mesh_file: str, dabs_file: str) -> None:
    """Load, scale, paint, print."""
    wanted = json.loads(Path(dabs_file).read_text(encoding="utf-8"))
    dab = make_dab()
    centres = np.asarray(wanted["dabs_world"], dtype=np.float64)
    middle = centres.mean(axis=0)
    scale = dab.radius / wanted["radius_world"]
    source = load_mesh(mesh_file)
    mesh = TriangleMesh((source.vertices - middle) * scale, source.faces, name=source.name)
    started = time.perf_counter()
    surface = PaintedSurface(mesh, resolution=None)
    built = time.perf_counter() - started
    stroke = record_dabs(dab, (centres - middle) * scale, wanted["normal"])
    found = time_dabs(surface, dab, stroke, ROUNDS)
    result = {
        "program": "paint3d",
        "verts": surface.n_vertices,
        "ms_per_dab": round(found.wall_ms, 4),
        "cpu_ms_per_dab": round(found.cpu_ms, 4),
        "ms_per_stroke_fixed": round(found.pen_down_ms, 2),
        "build_s": round(built, 2),
        "visited_per_dab": round(found.visited),
        "painted_per_dab": round(found.painted),
        "changed_total": found.changed,
    }
    sys.stdout.write(json.dumps(result) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
