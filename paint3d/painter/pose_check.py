"""Checks of a recording's poses for a wrong frame: of the tool, or of its base.

A robot's tool frame differs from the pen's: its z axis points at the work, and its origin may be
the tip; its positions are in the frame of its base. Painted as they are, such poses give marks that
were never drawn.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from paint3d.core.arrays import as_number, dots_of
from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.errors import Message
from paint3d.mesh.bvh import ClosestPoints
from paint3d.pose.brush_pose import brush_poses
from paint3d.recording.recording import Recording

__all__ = ["PoseWarnings", "fit_to_tuft", "inspect_poses", "log_warnings"]

_MOST_SAMPLES = 2000
_FAR = 3.0  # tuft lengths between object and brush, in the median
_SUNK = 0.1  # of the tuft's length: no press brings the ferrule nearer to the surface


class PoseWarnings(NamedTuple):
    """Warnings of poses that seem to be wrong, each None if there is no reason for it.

    Attributes
    ----------
    handle : Message or None
        The handle points into the surface.
    ferrule : Message or None
        The ferrule lies at or under it.
    position : Message or None
        The brush presses far from the object.
    """

    handle: Message | None
    ferrule: Message | None = None
    position: Message | None = None


def fit_to_tuft(recording: Recording, length_mm: float) -> Recording:
    """Move the roots of a recording whose tips were logged (``tuft_mm``) to this tuft length."""
    logged_mm = recording.header.get("tuft_mm")
    if logged_mm is None or logged_mm == length_mm:
        return recording
    logged_mm = as_number(logged_mm, "tuft_mm", 0.0, 1000.0)
    up = matrices_from_quaternions(recording.orientation)[:, :, 2]
    return replace(
        recording,
        position=recording.position + (length_mm - logged_mm) * up,
        header={**recording.header, "tuft_mm": length_mm},
    )


def log_warnings(warnings: Iterable[Message | None]) -> None:
    """Log each warning that is not None."""
    for warning in warnings:
        if warning is not None:
            logging.getLogger("paint3d").warning("%s", warning)


def inspect_poses(recording: Recording, surface: ClosestPoints, length_mm: float) -> PoseWarnings:
    """Check the poses of a recording near an object.

    Parameters
    ----------
    recording : Recording
        In the world; of a long one up to 2000 samples, evenly spread, are checked.
    surface : ClosestPoints
        Of the object.
    length_mm : float
        Of the tuft.
    """
    path = brush_poses(recording)
    chosen = np.arange(0, len(path), 1 + len(path) // _MOST_SAMPLES)
    if path.pressure is not None:
        pressed = np.flatnonzero(path.pressure > 0.0)
        chosen = pressed[:: 1 + len(pressed) // _MOST_SAMPLES]
    if not len(chosen):
        return PoseWarnings(None)
    points = path.points[chosen]
    feet = surface.find(points)
    offset = points - feet.points
    height = dots_of(offset, feet.normals)
    gap = np.linalg.norm(offset, axis=1)
    near = (gap <= length_mm) & (height > -0.25 * length_mm)
    up = matrices_from_quaternions(path.orientation[chosen])[:, :, 2]
    into = dots_of(up, feet.normals)[near] < 0.0
    handle = ferrule = position = None
    if len(into) and into.mean() > 0.5:
        handle = Message(
            "in {fraction:.0%} of the samples near the surface the handle points into it; expected "
            "an orientation whose z runs up the handle: if z points at the work, as that of a "
            "robot's tool, name the columns tool_qw, tool_qx, tool_qy, tool_qz",
            fraction=float(into.mean()),
        )
    by_root = ~path.has_contact[chosen]
    if path.pressure is not None and by_root.any():
        sunk = (height <= _SUNK * length_mm)[by_root]
        if sunk.mean() > 0.5:
            ferrule = Message(
                "in {fraction:.0%} of the samples that press, the ferrule lies at or under the "
                "surface; if the tip was logged, name the columns tip_x_mm, tip_y_mm, tip_z_mm "
                "(or _cm, _m)",
                fraction=float(sunk.mean()),
            )
    if path.pressure is not None and np.median(gap) > _FAR * length_mm:
        position = Message(
            "the brush is {gap:.0f} mm from the object where it presses; if its positions are in "
            "another frame, such as that of a robot's base, give the object's position there in "
            "columns object_x_mm, object_y_mm, object_z_mm (or _cm, _m)",
            gap=float(np.median(gap)),
        )
    return PoseWarnings(handle, ferrule, position)
