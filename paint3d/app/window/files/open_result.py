"""A painting that is about to be shown: its name, and what has to be found out before."""

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
    """What is painted on, in words: the object, its material, its width, depth and height."""
    sides = np.ptp(source.vertices, axis=0)
    size = say_sides(*(side for side in sides if side > 0.05 * sides.max()))
    return f"{say_object(source.name)}, {say_material(material)}, {size}"


_MOST_POINTS = 60_000  # to place a camera by; more show no object any better
_N_WAYS = 200  # and the outermost of all vertices so many ways


@dataclass(frozen=True, eq=False)
class OpenResult:
    """What takes seconds with millions of triangles, and so is made beside the window.

    Make it with `OpenResult.of`, outside the window's thread.

    Attributes
    ----------
    document : Document
    shown : LiveObject
    uploads : list of PatchUpload
        All that is to be drawn at first.
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
        """Find it out.

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
    """Make a painting ready to be shown; the fraction of the work that is done before."""
    progress(fraction)
    return OpenResult.of(document, part_of(progress, fraction, 0.98))


def some_points(points: AnyArray) -> AnyArray:
    """Some of (N, 3) points, spread evenly over the list, and those that lie outermost."""
    step = -(-len(points) // _MOST_POINTS)
    if step == 1:
        return points
    turn = np.arange(_N_WAYS) * np.pi * (3.0 - np.sqrt(5.0))  # a Fibonacci lattice on the sphere
    up = 1.0 - 2.0 * (np.arange(_N_WAYS) + 0.5) / _N_WAYS
    across = np.sqrt(1.0 - up * up)
    ways = np.stack([across * np.cos(turn), across * np.sin(turn), up], axis=1)
    ways = np.concatenate([ways, np.eye(3), -np.eye(3)]).astype(np.float32)
    outermost = np.unique([int((points @ way).argmax()) for way in ways])
    return np.concatenate([points[::step], points[outermost]])
