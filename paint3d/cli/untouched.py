"""Why a recording left nothing on an object: what to tell whoever replayed it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from paint3d.errors import RecordingError

if TYPE_CHECKING:
    from paint3d.cli.results import Painting
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.painter.flat_input import LaidPad
    from paint3d.recording.recording import Recording

__all__ = ["refuse_untouched"]

_PART = 1 << 16  # samples that are laid on the object at once
_MOST = 20_000  # samples whose distances are looked at


def refuse_untouched(painting: Painting, mesh: TriangleMesh, name: str) -> None:
    """Refuse a painting of one recording that left no footprint.

    Raises
    ------
    RecordingError
        If there is none; it says how far the brush was, or that it never pressed.
    """
    if painting.counts["footprints"]:
        return
    recording, brush = painting.recordings[0], painting.settings["brush"]
    raise RecordingError(
        f"{name}: the brush never touches {mesh.name}: "
        f"{_reason(recording, mesh, brush['name'], brush['length_mm'])}"
    )


def _reason(
    recording: Recording | LaidPad, mesh: TriangleMesh, brush: str, length_mm: float
) -> str:
    import numpy as np

    from paint3d.mesh.bvh import ClosestPoints
    from paint3d.pose.brush_pose import brush_poses

    pressure = recording.pressure
    if pressure is not None and not pressure.any():
        return "its pressure is 0 throughout; expected strokes that press"
    n = len(recording)
    ways = []
    for first in range(0, n, _PART):
        part = recording.part(first, min(n, first + _PART))
        way = brush_poses(part).way
        if part.pressure is not None:
            way = way[part.pressure > 0.0]
        ways.append(way[:: 1 + n // _MOST])
    way = np.concatenate(ways)
    gaps = np.linalg.norm(ClosestPoints(mesh).find(way).points - way, axis=1)
    near = float(gaps.min())
    if pressure is None:
        return (
            f"the tuft's root comes as near as {near:.1f} mm, and {brush} is {length_mm:g} mm "
            "long; expected a longer brush, another object, or another unit"
        )
    return (
        f"where it presses, the tuft's root is beside the surface, {near:.1f} mm off at the least, "
        "or behind it; expected another object, or another unit"
    )
