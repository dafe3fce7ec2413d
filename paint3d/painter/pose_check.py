"""What a recording's poses tell of the frames that were logged: of the tool, and of its base.

A robot's tool frame differs from the pen's: its z axis points at the work, and its origin may be
the tip; its positions are in the frame of its base. Painted as they are, such poses give marks that
nobody drew.
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

__all__ = ["Doubts", "doubts_of", "log_doubts", "rooted"]

_MOST = 2000  # samples that are looked at
_FAR = 3.0  # times the tuft's length: half of what presses is further off
_SUNK = 0.1  # of the tuft's length: no press brings the ferrule nearer to the surface


class Doubts(NamedTuple):
    """What seems to be wrong with poses, each None where nothing does.

    Attributes
    ----------
    handle : Message or None
        The handle points into the surface.
    ferrule : Message or None
        The ferrule lies at or under it.
    place : Message or None
        The brush presses far from the object.
    """

    handle: Message | None
    ferrule: Message | None = None
    place: Message | None = None


def rooted(recording: Recording, length_mm: float) -> Recording:
    """The recording for a tuft of this length, where its tip was logged (``tuft_mm``)."""
    meant = recording.header.get("tuft_mm")
    if meant is None or meant == length_mm:
        return recording
    meant = as_number(meant, "tuft_mm", 0.0, 1000.0)
    up = matrices_from_quaternions(recording.orientation)[:, :, 2]
    return replace(
        recording,
        position=recording.position + (length_mm - meant) * up,
        header={**recording.header, "tuft_mm": length_mm},
    )


def log_doubts(doubts: Iterable[Message | None]) -> None:
    """Log each doubt that is not None."""
    for doubt in doubts:
        if doubt is not None:
            logging.getLogger("paint3d").warning("%s", doubt)


def doubts_of(recording: Recording, surface: ClosestPoints, length_mm: float) -> Doubts:
    """What seems to be wrong with the poses of a recording near an object.

    Parameters
    ----------
    recording : Recording
        In the world; of a long one every so many samples are looked at.
    surface : ClosestPoints
        Of the object.
    length_mm : float
        Of the tuft.
    """
    path = brush_poses(recording)
    chosen = np.arange(0, len(path), 1 + len(path) // _MOST)
    if path.pressure is not None:
        pressed = np.flatnonzero(path.pressure > 0.0)
        chosen = pressed[:: 1 + len(pressed) // _MOST]
    if not len(chosen):
        return Doubts(None)
    places = path.points[chosen]
    found = surface.find(places)
    off = places - found.points
    height = dots_of(off, found.normals)
    gap = np.linalg.norm(off, axis=1)
    near = (gap <= length_mm) & (height > -0.25 * length_mm)
    up = matrices_from_quaternions(path.orientation[chosen])[:, :, 2]
    into = dots_of(up, found.normals)[near] < 0.0
    handle = ferrule = place = None
    if len(into) and into.mean() > 0.5:
        handle = Message(
            "in {share:.0%} of the samples near the surface the handle points into it; expected an "
            "orientation whose z runs up the handle: where z points at the work, as a robot's "
            "tool's does, name the columns tool_qw, tool_qx, tool_qy, tool_qz",
            share=float(into.mean()),
        )
    by_root = ~path.has_contact[chosen]
    if path.pressure is not None and by_root.any():
        sunk = (height <= _SUNK * length_mm)[by_root]
        if sunk.mean() > 0.5:
            ferrule = Message(
                "in {share:.0%} of the samples that press, the ferrule lies at or under the "
                "surface; is it the tip that is logged? then name the columns tip_x_mm, tip_y_mm, "
                "tip_z_mm (or _cm, _m)",
                share=float(sunk.mean()),
            )
    if path.pressure is not None and np.median(gap) > _FAR * length_mm:
        place = Message(
            "the brush is {gap:.0f} mm from the object where it presses; are its places in another "
            "frame, such as a robot's base? then say where the object lies there, in columns "
            "object_x_mm, object_y_mm, object_z_mm (or _cm, _m)",
            gap=float(np.median(gap)),
        )
    return Doubts(handle, ferrule, place)
