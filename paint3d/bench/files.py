"""Writing a painted object of a million triangles in every format, and a session and back.

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
from paint3d.colour.pigments import load_pigment
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["measure"]

_TRIANGLES = 1_000_000
_ROUNDS = 3
_RADIUS_MM = 60.0
_MOST_S = {".ply": 0.5, ".glb": 1.0, ".obj": 3.0, ".3mf": 8.0}
_OTHERS = (".usdz", ".html")
_SESSION, _OPENED = "session, saved", "session, opened"
_MOST_SESSION_S = 2.0
_RESOLUTION_MM = 0.4
_INKED_ABOVE_MM = 20.0


def measure(scale: float = 1.0) -> Result:
    """Export a sphere in each format, save it with ink on it and open it; they take turns."""
    from paint3d.files.export import export
    from paint3d.files.project.session import Session, load_session, save_session

    mesh = _coloured_sphere(max(200, int(_TRIANGLES * scale)))
    session = Session(_inked(mesh))
    suffixes = (*_MOST_S, *_OTHERS)
    with tempfile.TemporaryDirectory() as folder:
        paths = {suffix: Path(folder) / f"sphere{suffix}" for suffix in suffixes}
        for path in paths.values():  # compiles and imports
            export(_coloured_sphere(200), path)
        saved = Path(folder) / "sphere.p3d"
        save_session(session, saved)
        load_session(saved)
        times = alternate(
            _ROUNDS,
            {suffix: lambda path=path: export(mesh, path) for suffix, path in paths.items()}
            | {
                _SESSION: lambda: save_session(session, saved),
                _OPENED: lambda: load_session(saved),
            },
        )
        sizes = {suffix: path.stat().st_size for suffix, path in paths.items()}
        sizes |= dict.fromkeys((_SESSION, _OPENED), saved.stat().st_size)
    most = _MOST_S | dict.fromkeys((_SESSION, _OPENED), _MOST_SESSION_S)
    return Result(
        f"Exporting {mesh.n_faces:,} triangles with {mesh.n_vertices:,} vertices",
        ["format", "s", "CPU s", "MB"],
        [[name, times[name].wall_s, times[name].cpu_s, sizes[name] / 1e6] for name in times],
        [
            Check(f"s for {name}", times[name].wall_s, limit, unit="s")
            for name, limit in most.items()
        ],
    )


def _inked(mesh: TriangleMesh) -> PaintedSurface:
    """Make a surface of the mesh with wet ink on its upper part."""
    surface = PaintedSurface(mesh, _RESOLUTION_MM)
    column = surface.column_of(load_pigment("pine soot"))
    base = surface.paint_mesh.vertices[: surface.paint_mesh.n_base_vertices]
    ids = np.flatnonzero(base[:, 2] > _INKED_ABOVE_MM).astype(np.int32)
    surface.ink.amounts[ids, column] = surface.ink.coverage[ids] = 0.5
    surface.touch(ids)
    return surface


def _coloured_sphere(n_triangles: int) -> TriangleMesh:
    """Make a sphere of parallels and meridians, of slowly changing colours."""
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
