"""Laying a pad's recording on an object as it is seen: upright, in the picture's middle."""

from __future__ import annotations

from paint3d.app.model.input.navigation import ray_at
from paint3d.device.recorded import Recording
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import frame_at, make_chart
from paint3d.mesh.placement import place, upwards
from paint3d.painter.flat_input import LaidPad, dipped, size_of
from paint3d.view.camera import Camera, picture_axes

__all__ = ["lay_in_view"]

_MARGIN_MM = 1.0
_ALONG = 0.999  # cosine to the normal: what is up in the picture says nothing


def lay_in_view(recording: Recording, surface: ClosestPoints, camera: Camera) -> Recording:
    """Carry a pad's recording to the object, as large as it was drawn.

    Its middle comes to lie where the middle of the picture is; where that is beside the object, at
    the object's front. A recording that knows no dips gets one before every stroke.

    Parameters
    ----------
    recording : Recording
        In pad space.
    surface : ClosestPoints
        Of the object.
    camera : Camera
        From where it is seen.

    Returns
    -------
    Recording
        In the object's frame.

    Raises
    ------
    MeshError, InputError, RecordingError
        If it does not fit there.
    """
    middle, half, scale = size_of(recording)
    ray = ray_at(camera, 0.5, 0.5, (1.0, 1.0))
    hits = surface.cast(ray.origin[None], ray.direction[None])
    if hits.hit[0]:
        normal = surface.find(hits.points[:1]).normals[0]
        up = picture_axes(camera)[1]
        up = upwards(normal) if abs(float(up @ normal)) > _ALONG else up
        frame = frame_at(surface, hits.points[0], up)
    else:
        frame = place(surface, (0.5, 0.5))
    chart = make_chart(surface, frame, *(half + _MARGIN_MM))
    return LaidPad(dipped(recording), chart, middle, scale).whole()
