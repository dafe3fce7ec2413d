"""A painting that is about to be shown: its name, and what is computed before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.document import Document
from paint3d.app.window.job import JobProgress
from paint3d.app.window.wording import say_material, say_object, say_sides
from paint3d.colour.materials import Material
from paint3d.core.arrays import AnyArray
from paint3d.files.progress import part_of
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.view.live_object import LiveObject, PatchUpload

__all__ = [
    "OpenResult",
    "described",
    "open_with_progress",
    "some_points",
]


def described(source: TriangleMesh, material: Material) -> str:
    """Describe the object painted on: its name, material, width, depth and height."""
    sides = np.ptp(source.vertices, axis=0)
    size = say_sides(*(side for side in sides if side > 0.05 * sides.max()))
    return f"{say_object(source.name)}, {say_material(material)}, {size}"


_MOST_POINTS = 60_000  # to place a camera by; more show no object any better
_N_WAYS = 200  # directions in which the outermost vertex is added


@dataclass(frozen=True, eq=False)
class OpenResult:
    """A document ready to be shown; takes seconds for millions of triangles, beside the window.

    Make it with `OpenResult.of`, outside the window's thread.

    Attributes
    ----------
    document : Document
    shown : LiveObject
    uploads : list of PatchUpload
        Everything for the first picture.
    surface : ClosestPoints
        Of the object's own triangles.
    points : (N, 3) float32
        Enough of the object's vertices to place a camera by, mm.
    """

    document: Document
    shown: LiveObject
    uploads: list[PatchUpload]
    surface: ClosestPoints
    points: NDArray[np.float32]

    @classmethod
    def of(
        cls, document: Document, progress: Callable[[float], None] = lambda _: None
    ) -> OpenResult:
        """Prepare a document.

        Parameters
        ----------
        document : Document
            Nobody else may change it meanwhile.
        progress : callable
            Called with the fraction done between the steps; what it raises ends them.
        """
        shown = LiveObject(document.surface)
        progress(0.4)
        uploads = shown.uploads(document.refresh())
        progress(0.6)
        surface = document.surface.closest_points
        _ = document.surface.contact_tree  # built here, beside the window
        progress(0.9)
        return cls(document, shown, uploads, surface, some_points(document.surface.source.vertices))


def open_with_progress(document: Document, progress: JobProgress, fraction: float) -> OpenResult:
    """Prepare a document, as the part of some work from `fraction` on."""
    progress(fraction)
    return OpenResult.of(document, part_of(progress, fraction, 0.98))


def some_points(points: AnyArray) -> AnyArray:
    """Return some of (N, 3) points, evenly from the list, and the outermost ones."""
    step = -(-len(points) // _MOST_POINTS)
    if step == 1:
        return points
    turn = np.arange(_N_WAYS) * np.pi * (3.0 - np.sqrt(5.0))  # a Fibonacci lattice on the sphere
    up = 1.0 - 2.0 * (np.arange(_N_WAYS) + 0.5) / _N_WAYS
    across = np.sqrt(1.0 - up * up)
    directions = np.stack([across * np.cos(turn), across * np.sin(turn), up], axis=1)
    directions = np.concatenate([directions, np.eye(3), -np.eye(3)]).astype(np.float32)
    outermost = np.unique([int((points @ direction).argmax()) for direction in directions])
    return np.concatenate([points[::step], points[outermost]])
