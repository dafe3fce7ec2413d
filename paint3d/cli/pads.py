"""Recordings from a flat pad: where on the object, and how large, they are laid."""

from __future__ import annotations

from typing import TYPE_CHECKING

from paint3d.errors import InputError

if TYPE_CHECKING:
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.painter.flat_input import LaidPad
    from paint3d.recording.recording import Recording

__all__ = ["lay_on"]

_MIDDLE = (0.5, 0.5)
_MARGIN_MM = 1.0


def lay_on(
    mesh: TriangleMesh,
    recording: Recording,
    place: tuple[float, float] | None,
    width_mm: float | None,
) -> Recording | LaidPad:
    """The recording in the world: laid on the mesh if it is a pad's, else as it is.

    A pad's recording that knows no dips gets one before every stroke.

    Parameters
    ----------
    mesh : TriangleMesh
    recording : Recording
    place : (float, float) or None
        Where its middle goes, as `paint3d.mesh.placement.place` takes it; None: the middle.
    width_mm : float or None
        How wide to lay it; None: as wide as it was drawn.

    Raises
    ------
    InputError
        If it does not fit there, or a place is given for a recording that has its own.
    """
    if not recording.is_pad:
        if place is not None or width_mm is not None:
            raise InputError(
                "--at and --size lay a pad's recording; this one has its own place in the world"
            )
        return recording
    from paint3d.mesh.bvh import ClosestPoints
    from paint3d.mesh.chart import make_chart
    from paint3d.mesh.placement import place as find_place
    from paint3d.painter.flat_input import LaidPad, dipped, size_of

    middle, half, scale = size_of(recording, width_mm)
    half_width, half_height = half + _MARGIN_MM
    surface = ClosestPoints(mesh)
    frame = find_place(surface, place or _MIDDLE)
    chart = make_chart(surface, frame, half_width, half_height)
    return LaidPad(dipped(recording), chart, middle, scale)
