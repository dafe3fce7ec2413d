"""What the painting thread hands to a view: what changed since the last time, and no more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.document import Document
from paint3d.app.model.held_ink import ink_srgb
from paint3d.device.sample import DeviceSample
from paint3d.pose.brush_pose import object_poses
from paint3d.view.pressed_tuft import PressedTuft

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
    pressed : PressedTuft or None
        How its tuft lies on the surface; None where it touches nothing.
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
    pressed: PressedTuft | None
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
    """The brush at a sample of both hands, its tuft as painting will have it there."""
    samples, painted = _way_to(document, sample)
    path, painter = object_poses(samples), document.painter
    held = document.surface.ink.load
    parts = tuple(np.round(held / held.sum(), 3)) if held.sum() > 0.0 else ()
    colour = ink_srgb(tuple(document.surface.pigments), parts, on_hair=True)
    return BrushView(
        path.position[-1],
        path.orientation[-1],
        sample.pressure,
        document.tuft_follower.follow(painter, path, painted=painted),
        np.array(colour, np.uint8),
        float(min(1.0, held.sum() / painter.tuft.load)),
        document.in_stroke,
    )


def _way_to(document: Document, sample: DeviceSample) -> tuple[list[DeviceSample], bool]:
    """The samples of the stroke from the one that is painted to this one; and whether that is so.

    A sample that cannot follow the stroke's is one by itself.
    """
    samples, painted = document.unpainted
    if samples and samples[-1] is sample:
        return samples, painted
    if not samples or samples[-1].time_ns >= sample.time_ns:
        return [sample], False
    if (samples[-1].pressure is None) != (sample.pressure is None):
        return [sample], False
    return [*samples, sample], painted
