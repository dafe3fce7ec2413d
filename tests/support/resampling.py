"""The same motion, read by the devices at another rate."""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.arrays import as_number
from paint3d.core.types import AnyArray
from paint3d.device.recorded import Recording
from paint3d.errors import RecordingError
from paint3d.pose.brush_pose import BrushPath
from paint3d.pose.interpolation import densify, evaluate

__all__ = ["resample"]

_MAX_SAMPLES = 20_000_000


def resample(recording: Recording, rate_hz: float) -> Recording:
    """Read a recording's motion again at `rate_hz`.

    Both hands are interpolated as `paint3d.pose.interpolation` does it; buttons hold. The
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
