"""The same motion, read by the devices at another rate."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, as_number
from paint3d.core.quaternion import slerp
from paint3d.device.recorded import Recording
from paint3d.errors import RecordingError
from paint3d.pose.brush_pose import BrushPath, joined_samples, velocities

__all__ = ["DensePath", "densify", "evaluate", "resample"]

_MAX_SAMPLES = 20_000_000


@dataclass(frozen=True, eq=False)
class DensePath:
    """A path made ready for `evaluate`.

    Attributes
    ----------
    path : BrushPath
        The N samples.
    joined : (N,) bool
        See `joined_samples`.
    velocity : (N, 3) float64
        See `velocities`.
    """

    path: BrushPath
    joined: NDArray[np.bool_]
    velocity: NDArray[np.float64]


def resample(recording: Recording, rate_hz: float) -> Recording:
    """Read a recording's motion again at `rate_hz`.

    Both hands are interpolated as `paint3d.pose.brush_pose` does it; buttons hold. The
    first and the last sample stay.

    Raises
    ------
    InputError
        If the rate is not between 1e-3 and 1e9 Hz, or would give more than 20 million samples.
    """
    rate = as_number(rate_hz, "rate_hz", 1e-3, 1e9)
    old = recording.time_ns
    if len(old) == 1:
        return recording
    n = math.ceil(recording.duration_s * rate)
    if n > _MAX_SAMPLES:
        raise RecordingError(f"{n} samples at {rate:g} Hz; expected at most {_MAX_SAMPLES}")
    steps = np.round(np.arange(n) * (1e9 / rate)).astype(np.int64)
    times = np.append(old[0] + steps[steps < old[-1] - old[0]], old[-1])
    index = np.clip(np.searchsorted(old, times, side="right") - 1, 0, len(old) - 2)
    fraction = (times - old[index]) / (old[index + 1] - old[index])
    brush = _hand(recording, recording.position, recording.orientation)
    position, orientation, pressure = evaluate(densify(brush), index, fraction)
    thing = _hand(recording, recording.object_position, recording.object_orientation)
    object_position, object_orientation, _ = evaluate(densify(thing), index, fraction)
    contact = None
    if recording.contact is not None:
        meant = _hand(recording, recording.contact, recording.orientation)
        contact, _, _ = evaluate(densify(meant), index, fraction)
    return Recording(
        times,
        position,
        orientation,
        pressure,
        recording.buttons[index + (fraction >= 1.0)],
        object_position,
        object_orientation,
        recording.header,
        contact,
    )


def _hand(recording: Recording, position: AnyArray, orientation: AnyArray) -> BrushPath:
    time_s = (recording.time_ns - recording.time_ns[0]) * 1e-9
    return BrushPath(time_s, position, orientation, recording.pressure, recording.buttons)


def densify(path: BrushPath) -> DensePath:
    """Make a path ready for `evaluate`."""
    joined = joined_samples(path)
    return DensePath(path, joined, velocities(path, joined))


def evaluate(
    dense: DensePath, sample_index: AnyArray, fraction: NDArray[np.float64]
) -> tuple[AnyArray, AnyArray, AnyArray | None]:
    """The pose a fraction of the way from sample i to sample i + 1.

    Intervals that are not joined are crossed on a straight line.

    Parameters
    ----------
    dense : DensePath
    sample_index : (M,) int
        0 to N - 2.
    fraction : (M,) float64
        0 to 1 in time.

    Returns
    -------
    position : (M, 3) float64
        mm.
    orientation : (M, 4) float64
    pressure : (M,) float64 or None
    """
    path, i, t = dense.path, np.asarray(sample_index), np.asarray(fraction, dtype=np.float64)
    h = (path.time_s[i + 1] - path.time_s[i])[:, None]
    s = t[:, None]
    start, end = path.position[i], path.position[i + 1]
    rise = s * s * (3.0 - 2.0 * s)
    cubic = (
        start
        + rise * (end - start)
        + s * (1.0 - s) * h * ((1.0 - s) * dense.velocity[i] - s * dense.velocity[i + 1])
    )
    position = np.where(dense.joined[i + 1][:, None], cubic, start + s * (end - start))
    orientation = slerp(path.orientation[i], path.orientation[i + 1], t)
    if path.pressure is None:
        return position, orientation, None
    return position, orientation, (1.0 - t) * path.pressure[i] + t * path.pressure[i + 1]
