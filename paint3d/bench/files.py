"""Writing a painted object of a million triangles in every format, as `export` does it.

The times are of everything from the arrays to the file on the disk: checks, units, text,
compression, flushing. Colours differ from vertex to vertex, which is the hard case for the formats
that compress.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from paint3d.bench.result import Check, Result
from paint3d.bench.stopwatch import alternate
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["measure"]

_TRIANGLES = 1_000_000
_ROUNDS = 3
_RADIUS_MM = 60.0
_MOST_S = {".ply": 0.5, ".glb": 1.0, ".obj": 3.0, ".3mf": 8.0}
_OTHERS = (".usdz", ".wrl", ".html")


def measure(share: float = 1.0) -> Result:
    """Export a sphere in each format; they take turns."""
    from paint3d.files.export import export

    mesh = _coloured_sphere(max(200, int(_TRIANGLES * share)))
    suffixes = (*_MOST_S, *_OTHERS)
    with tempfile.TemporaryDirectory() as folder:
        paths = {suffix: Path(folder) / f"sphere{suffix}" for suffix in suffixes}
        for path in paths.values():  # compiles and imports
            export(_coloured_sphere(200), path)
        times = alternate(
            _ROUNDS,
            {suffix: lambda path=path: export(mesh, path) for suffix, path in paths.items()},
        )
        sizes = {suffix: path.stat().st_size for suffix, path in paths.items()}
    return Result(
        f"Exporting {mesh.n_faces:,} triangles with {mesh.n_vertices:,} vertices",
        ["format", "s", "CPU s", "MB"],
        [[s, times[s].wall_s, times[s].cpu_s, sizes[s] / 1e6] for s in suffixes],
        [Check(f"s for {s}", times[s].wall_s, most, unit="s") for s, most in _MOST_S.items()],
    )


def _coloured_sphere(n_triangles: int) -> TriangleMesh:
    """A sphere of parallels and meridians, of slowly changing colours."""
    n = int(np.ceil((n_triangles / 2) ** 0.5))
    around, down = np.meshgrid(np.linspace(0.0, 2 * np.pi, n + 1), np.linspace(0.01, 3.13, n + 1))
    ring = np.sin(down)
    places = np.stack([np.cos(around) * ring, np.sin(around) * ring, np.cos(down)], axis=-1)
    normals = places.reshape(-1, 3).astype(np.float32)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    upper = np.stack([corner, corner + n + 1, corner + 1], axis=1)
    lower = np.stack([corner + 1, corner + n + 1, corner + n + 2], axis=1)
    waves = np.stack([np.sin(5 * around), np.cos(7 * down), np.sin(3 * around + down)], axis=-1)
    colours = np.rint(127.5 + 127.5 * waves.reshape(-1, 3)).astype(np.uint8)
    faces = np.concatenate([upper, lower]).astype(np.int32)
    return TriangleMesh(_RADIUS_MM * normals, faces, colours, "sphere", normals)
