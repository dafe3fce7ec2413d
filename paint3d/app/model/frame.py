"""What the painting thread hands to a view: what changed since the last time, and no more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.document import Document
from paint3d.app.model.held_ink import ink_srgb
from paint3d.device.sample import DeviceSample
from paint3d.pose.brush_pose import object_poses
from paint3d.projection.contact import Contact
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["BrushView", "Frame", "Growth", "GrowthWatch", "view_brush"]


@dataclass(frozen=True, eq=False)
class Growth:
    """Vertices and triangles that refinement added.

    Attributes
    ----------
    first_vertex : int
        Number of the first vertex that is new.
    vertices, normals : (N, 3) float32
        Of the new ones, mm.
    srgb : (N, 3) uint8
    roots : (R,) int32
        Faces of `PaintMesh.base_faces` that are divided otherwise than before.
    faces : (F, 3) int32
        All triangles that those consist of now.
    face_roots : (F,) int32
        The root of each.
    cells : (C,) int32
        Cells that were refined.
    """

    first_vertex: int
    vertices: NDArray
    normals: NDArray
    srgb: NDArray
    roots: NDArray
    faces: NDArray
    face_roots: NDArray
    cells: NDArray


@dataclass(frozen=True, eq=False)
class BrushView:
    """The brush as it is now, in the object's frame, for drawing it.

    Attributes
    ----------
    position : (3,) float64
        The tuft's root, mm.
    orientation : (4,) float64
        object_from_pen, w first.
    pressure : float or None
    contact : Contact or None
        How it stands on the surface; None where there is none below it.
    srgb : (3,) uint8
        Colour of the ink in it; of dry hair where it is empty.
    load : float
        Share of a full load, 0 to 1.
    painting : bool
        Whether a stroke is going on.
    """

    position: NDArray
    orientation: NDArray
    pressure: float | None
    contact: Contact | None
    srgb: NDArray
    load: float
    painting: bool


@dataclass(frozen=True, eq=False)
class Frame:
    """One state of the painting, as far as it differs from the frame before.

    Attributes
    ----------
    number : int
        Counts from 1.
    vertex_ids : (N,) int32
        Vertices whose colours changed.
    srgb : (N, 3) uint8
        Their colours: a copy.
    n_vertices : int
    growth : Growth or None
        Vertices and triangles that came; None where none did.
    brush : BrushView or None
        None before the first sample.
    queue_length : int
        Batches of samples and commands that wait; time for the ink is none of them.
    lag_s : float
        How long what was painted last had waited, s.
    can_undo, can_redo : bool
    n_strokes : int
    """

    number: int
    vertex_ids: NDArray
    srgb: NDArray
    n_vertices: int
    growth: Growth | None
    brush: BrushView | None
    queue_length: int
    lag_s: float
    can_undo: bool
    can_redo: bool
    n_strokes: int


class GrowthWatch:
    """Tells what refinement added to a surface since it was last asked."""

    def __init__(self, surface: PaintedSurface) -> None:
        self._surface = surface
        fields = surface.paint_mesh.arrays
        self._counts = fields.counts.copy()
        self._done = fields.done.copy()

    def take(self) -> Growth | None:
        """What is new, or None."""
        mesh = self._surface.paint_mesh
        fields = mesh.arrays
        (first, first_node), (n, nodes) = self._counts, fields.counts.copy()
        if n == first and nodes == first_node:
            return None
        cells = np.flatnonzero(fields.done != self._done).astype(np.int32)
        roots = np.unique(fields.node_root[first_node:nodes])
        divided = np.zeros(len(mesh.base_faces), bool)
        divided[roots] = True
        of = fields.node_root[:nodes]
        leaves = np.flatnonzero(divided[of] & (fields.child[:nodes] < 0))
        self._counts, self._done = np.array([n, nodes]), fields.done.copy()
        new = slice(int(first), int(n))
        return Growth(
            int(first),
            np.stack([getattr(fields, a)[new] for a in ("px", "py", "pz")], axis=1),
            np.stack([getattr(fields, a)[new] for a in ("nx", "ny", "nz")], axis=1),
            self._surface.codes[new].copy(),
            roots,
            fields.node_vertices[leaves],
            of[leaves],
            cells,
        )


def view_brush(document: Document, sample: DeviceSample) -> BrushView:
    """The brush at a sample of both hands."""
    path, painter = object_poses([sample]), document.painter
    position, orientation = path.position[0], path.orientation[0]
    surface = document.surface
    held = surface.ink.load
    place = None if path.contact is None else path.contact[0]
    contact = painter.contact(position, orientation, sample.pressure, place)
    parts = tuple(np.round(held / held.sum(), 3)) if held.sum() > 0.0 else ()
    colour = ink_srgb(tuple(surface.pigments), parts, on_hair=True)
    return BrushView(
        position,
        orientation,
        sample.pressure,
        contact,
        np.array(colour, np.uint8),
        float(min(1.0, held.sum() / painter.tuft.load)),
        document.in_stroke,
    )
