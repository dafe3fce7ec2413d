"""Laying a recording from a flat pad on a surface."""

from __future__ import annotations

from dataclasses import replace

from paint3d.device.recorded import Recording
from paint3d.errors import InputError, RecordingError
from paint3d.frames import multiply_quaternions, quaternions_from_matrices
from paint3d.mesh.chart import SurfaceChart

__all__ = ["DIP", "centred", "dipped", "lay"]

DIP = 2  # button bit: the brush is dipped, on a lifted sample


def lay(recording: Recording, chart: SurfaceChart) -> Recording:
    """Carry a pad recording onto a surface; the object stays at rest in the world.

    A sample at (x, y, z) of the pad goes to the chart's point at (x, y) plus z mm along the
    normal there, and its orientation is taken relative to the chart's directions there. With a
    pressure that point is the place that the hand meant: the pad's own pen drew there.

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
        raise RecordingError(f"the recording does not fit: {cause}") from None
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


def centred(recording: Recording, width_mm: float | None = None) -> Recording:
    """A pad recording moved so that its middle is (0, 0), and scaled to a width if one is given.

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
    position = recording.position.copy()
    position[:, :2] = (position[:, :2] - 0.5 * (low + high)) * scale
    return Recording(
        recording.time_ns,
        position,
        recording.orientation,
        recording.pressure,
        recording.buttons,
        recording.object_position,
        recording.object_orientation,
        recording.header,
    )


def dipped(recording: Recording) -> Recording:
    """The recording with the brush dipped before every stroke, if it is never dipped in it.

    A pad knows no ink: what was drawn with a pen that never ran dry would fade out under a brush.
    """
    pressure = recording.pressure
    if pressure is None or ((recording.buttons & DIP) != 0).any():
        return recording
    buttons = recording.buttons.copy()
    buttons[:-1][(pressure[:-1] <= 0.0) & (pressure[1:] > 0.0)] |= DIP
    return replace(recording, buttons=buttons)
