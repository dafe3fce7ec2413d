"""Mapping of recordings drawn on a flat pad onto a surface."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, dots_of
from paint3d.core.quaternion import multiply_quaternions, quaternions_from_matrices
from paint3d.device.recorded import Recording
from paint3d.device.sample import DIP
from paint3d.errors import InputError, RecordingError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SurfaceChart, frame_at, make_chart
from paint3d.mesh.placement import place as find_place
from paint3d.mesh.placement import upwards
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.pose.brush_pose import brush_poses

__all__ = ["LaidPad", "add_dips", "lay", "lay_at", "lift_off", "pad_extent"]

_MARGIN_MM = 1.0  # around what is laid
_REACH = 1.4  # half the side of the sheet, over the strokes' reach
_MOST_OFF_MM = 0.5  # distance of a foot from the sheet's surface


def lay(recording: Recording, chart: SurfaceChart) -> Recording:
    """Map a pad recording onto a surface; the object stays at rest in the world.

    A sample at (x, y, z) of the pad goes to the chart's point at (x, y) plus z mm along the
    normal there; its orientation is relative to the chart's tangent frame there. If the recording
    has a pressure, that point is also its contact: the pad's own pen drew there.

    Parameters
    ----------
    recording : Recording
        In pad space.
    chart : SurfaceChart

    Returns
    -------
    Recording
        In world space, the world being the object's frame.

    Raises
    ------
    RecordingError
        If the recording is not a pad's, or leaves the chart.
    """
    if not recording.is_pad:
        raise RecordingError("the recording's space is 'world'; expected 'pad'")
    xy = recording.position[:, :2]
    try:
        points, frames = chart.points(xy), chart.tangents(xy)
    except InputError as cause:
        raise RecordingError("the recording does not fit: {cause}", cause=cause) from None
    world_from_pad = quaternions_from_matrices(frames)
    return Recording(
        recording.time_ns,
        points + recording.position[:, 2:] * frames[..., 2],
        multiply_quaternions(world_from_pad, recording.orientation),
        recording.pressure,
        recording.buttons,
        header={**recording.header, "space": "world"},
        contact=None if recording.pressure is None else points,
    )


@dataclass(frozen=True, eq=False)
class LaidPad:
    """A pad recording that is mapped onto a surface part by part, on demand.

    Ten million samples mapped at once would take four times the memory of the recording.

    Attributes
    ----------
    pad : Recording
    chart : SurfaceChart
    middle : (2,) float64
        The point of the pad that is mapped to the chart's origin, mm.
    scale : float
        mm on the surface per mm of the pad.
    """

    pad: Recording
    chart: SurfaceChart
    middle: NDArray[np.float64]
    scale: float = 1.0

    def __len__(self) -> int:
        return len(self.pad)

    @property
    def time_ns(self) -> NDArray[np.int64]:
        """Times (N,) int64 of the pad's samples."""
        return self.pad.time_ns

    @property
    def pressure(self) -> NDArray[np.float64] | None:
        """Pressures (N,) float64 in [0, 1] of the pad's samples, or None."""
        return self.pad.pressure

    @property
    def header(self) -> dict[str, Any]:
        """The pad's header, with the space "world"."""
        return {**self.pad.header, "space": "world"}

    def part(self, first: int, last: int) -> Recording:
        """Map the samples from `first` up to, not including, `last`.

        Raises
        ------
        RecordingError
            If they leave the chart.
        """
        part = self.pad.part(first, last)
        position = part.position.copy()
        position[:, :2] = (position[:, :2] - self.middle) * self.scale
        return lay(replace(part, position=position), self.chart)

    def whole(self) -> Recording:
        """Map all samples; raises as `part`."""
        return self.part(0, len(self))


def lay_at(
    recording: Recording,
    mesh: TriangleMesh,
    place: tuple[float, float] = (0.5, 0.5),
    width_mm: float | None = None,
) -> LaidPad:
    """Lay a pad's recording on an object; one without dips gets one before every stroke.

    Parameters
    ----------
    recording : Recording
        In pad space.
    mesh : TriangleMesh
    place : (float, float)
        Where its middle goes, U,V as ``--at`` of the command line has them.
    width_mm : float, optional
        On the object; by default as drawn.

    Raises
    ------
    RecordingError
        If the recording is not a pad's, or has no width to scale.
    InputError
        If it does not fit there, or there is no surface.
    """
    middle, half, scale = pad_extent(recording, width_mm)
    surface = ClosestPoints(mesh)
    half_width, half_height = half + _MARGIN_MM
    chart = make_chart(surface, find_place(surface, place), half_width, half_height)
    return LaidPad(add_dips(recording), chart, middle, scale)


def pad_extent(
    recording: Recording, width_mm: float | None = None
) -> tuple[AnyArray, AnyArray, float]:
    """Return a pad recording's middle, its half extent on the surface, and the scale.

    Parameters
    ----------
    recording : Recording
    width_mm : float, optional
        Width on the surface; by default as drawn.

    Returns
    -------
    middle, half : (2,) float64
        mm: the middle on the pad, and half the extent on the surface.
    scale : float
        mm on the surface per mm of the pad.

    Raises
    ------
    RecordingError
        If the recording is not a pad's, or has no width to scale.
    """
    if not recording.is_pad:
        raise RecordingError("the recording's space is 'world'; expected 'pad'")
    low, high = recording.position[:, :2].min(axis=0), recording.position[:, :2].max(axis=0)
    scale = 1.0
    if width_mm is not None:
        if high[0] <= low[0]:
            raise RecordingError("the recording has no width; expected one to scale")
        scale = width_mm / (high[0] - low[0])
    middle = 0.5 * (low + high)
    return middle, np.maximum(middle - low, high - middle) * scale, scale


def lift_off(recording: Recording, surface: ClosestPoints) -> Recording:
    """Turn a recording on an object into a pad's, to be laid on another: the inverse of `lay`.

    The chart's origin is the middle of all points where the brush presses.

    Parameters
    ----------
    recording : Recording
        In world space.
    surface : ClosestPoints
        Of the object that it was made on.

    Raises
    ------
    RecordingError
        If the strokes reach so far around the object that no sheet holds them.
    """
    path = brush_poses(recording)
    pressed = np.ones(len(recording), np.bool_)
    if recording.pressure is not None and recording.pressure.any():
        pressed = recording.pressure > 0.0
    feet = surface.find(path.points).points
    middle = feet[pressed].mean(axis=0)
    frame = frame_at(surface, middle, upwards(surface.find(middle[None]).normals[0]))
    half = _REACH * float(np.linalg.norm(feet[pressed] - frame.origin, axis=1).max()) + 1.0
    try:
        chart = make_chart(surface, frame, half, half)
        xy = chart.coordinates(feet, most_off=_MOST_OFF_MM)
    except InputError as cause:
        raise RecordingError("no sheet holds its strokes: {cause}", cause=cause) from None
    known = np.isfinite(xy[:, 0])
    if not known[pressed].all():
        raise RecordingError("no sheet holds its strokes: they reach too far around the object")
    index = np.arange(len(xy))
    for column in xy.T:  # between strokes the hand may be anywhere
        column[~known] = np.interp(index[~known], index[known], column[known])
    frames = chart.tangents(xy)
    height = dots_of(path.position - chart.points(xy), np.ascontiguousarray(frames[..., 2]))
    turned = quaternions_from_matrices(frames) * (1.0, -1.0, -1.0, -1.0)
    return Recording(
        recording.time_ns,
        np.column_stack([xy, height]),
        multiply_quaternions(turned, path.orientation),
        recording.pressure,
        path.buttons,
        header={**recording.header, "space": "pad"},
    )


def add_dips(recording: Recording) -> Recording:
    """Add a dip before every stroke to a recording that has none.

    A pad's pen never runs dry: without dips, such a drawing would fade out under a brush.
    """
    pressure = recording.pressure
    if pressure is None or ((recording.buttons & DIP) != 0).any():
        return recording
    buttons = recording.buttons.copy()
    buttons[:-1][(pressure[:-1] <= 0.0) & (pressure[1:] > 0.0)] |= DIP
    return replace(recording, buttons=buttons)
