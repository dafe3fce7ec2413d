"""What the painting thread hands to a view: what changed since the last time, and no more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.document import Document
from paint3d.app.model.held_ink import ink_srgb
from paint3d.brush_engine.contact import Contact
from paint3d.device.sample import DeviceSample
from paint3d.pose.brush_pose import object_poses

__all__ = ["BrushView", "Frame", "view_brush"]


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

    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    pressure: float | None
    contact: Contact | None
    srgb: NDArray[np.uint8]
    load: float
    painting: bool


@dataclass(frozen=True, eq=False)
class Frame:
    """One state of the painting, as far as it differs from the frame before.

    Attributes
    ----------
    vertex_ids : (N,) int32
        Vertices whose colours changed.
    has_grown : bool
        Whether refinement added vertices or triangles.
    brush : BrushView or None
        None before the first sample.
    queue_length : int
        Batches of samples and commands that were asked for before it was taken and that it does not
        show yet; time for the ink is none of them.
    lag_s : float
        How long what was painted last had waited, s.
    can_undo, can_redo : bool
    n_strokes : int
    """

    vertex_ids: NDArray[np.int32]
    has_grown: bool
    brush: BrushView | None
    queue_length: int
    lag_s: float
    can_undo: bool
    can_redo: bool
    n_strokes: int


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
