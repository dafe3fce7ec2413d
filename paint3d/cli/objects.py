"""The object that a command paints on: read once for all the rows of a batch that name it."""

from __future__ import annotations

import argparse
import os
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["load_object"]


def load_object(options: argparse.Namespace) -> TriangleMesh:
    """Load the mesh that ``--on`` names, as the other options say.

    Raises
    ------
    MeshError
        If the file cannot be read or holds no usable surface.
    """
    path = os.path.abspath(options.on)  # a name means another file in another folder
    how = (options.unit, options.from_points, options.texture, options.up)
    return _load(options.on, path, _state(path), *how)


def _state(path: str) -> tuple[int, int] | None:
    """What tells a file's versions apart; None where there is no file, but a name."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_size, found.st_mtime_ns


@lru_cache(maxsize=1)
def _load(
    name: str,
    path: str,
    state: tuple[int, int] | None,
    unit: str | None,
    from_points: bool | None,
    texture: bool,
    up: str | None,
) -> TriangleMesh:
    from paint3d.files.load import load_mesh

    return load_mesh(name, unit, from_points=from_points, texture=texture, up=up)
