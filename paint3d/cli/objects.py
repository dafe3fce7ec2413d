"""The object that a command paints on: read once for all the rows of a batch that name it."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING, Any

from paint3d.cli.progress import ProgressBar

if TYPE_CHECKING:
    from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["load_object"]

_last: dict[tuple[Any, ...], TriangleMesh] = {}  # the one that was read last


def load_object(options: argparse.Namespace) -> TriangleMesh:
    """Load the mesh that ``--on`` names, as the other options say.

    Raises
    ------
    MeshError
        If the file cannot be read or holds no usable surface.
    """
    path = os.path.abspath(options.on)  # a name means another file in another folder
    how = (options.unit, options.from_points, options.texture, options.up)
    key = (options.on, path, _state(path), *how)
    if key not in _last:
        from paint3d.files.load import load_mesh

        unit, from_points, texture, up = how
        with ProgressBar("reading", enabled=not options.quiet) as progress:
            mesh = load_mesh(
                options.on, unit, from_points=from_points, texture=texture, up=up,
                progress=progress,
            )  # fmt: skip
        _last.clear()
        _last[key] = mesh
    return _last[key]


def _state(path: str) -> tuple[int, int] | None:
    """What tells a file's versions apart; None where there is no file, but a name."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_size, found.st_mtime_ns
