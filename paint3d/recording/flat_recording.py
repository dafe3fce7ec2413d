"""Pads and tablets: strokes on a flat sheet, their angles, scale and times."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.core.quaternion import (
    matrices_from_quaternions,
    multiply_quaternions,
    quaternions_from_matrices,
)
from paint3d.device.recorded import Recording

__all__ = [
    "DEFAULT_LEAN",
    "MM_PER_PIXEL",
    "Lifts",
    "angles_from_orientations",
    "join_strokes",
    "notes_of",
    "orientations_from_angles",
    "spread_equal_times",
]

DEFAULT_LEAN = -0.25 * math.pi
"""Azimuth where a pad gives none, rad: down and to the right, so that the tip points up left."""
MM_PER_PIXEL = 25.4 / 96.0
"""CSS pixels and Wacom's device-independent pixels, mm."""
_LIFT_NS = 1_000_000
"""A lifted sample is put this long after a stroke's end and before the next one's start."""
_UPRIGHT = 1e-9


def orientations_from_angles(
    azimuth: NDArray[np.float64],
    altitude: NDArray[np.float64],
    rotation: NDArray[np.float64] | float = 0.0,
) -> AnyArray:
    """Pen orientations whose tip trails opposite to the lean.

    Parameters
    ----------
    azimuth : (N,) float64
        Direction in which the handle leans, rad from the pad's x towards its y axis.
    altitude : (N,) float64
        Angle of the handle above the pad, rad; pi/2 stands upright.
    rotation : (N,) float64 or float
        Roll about the handle, rad; 0 turns the tip (pen x) away from the lean.

    Returns
    -------
    (N, 4) float64
        pad_from_pen, unit quaternions, w first.
    """
    ca, sa = np.cos(azimuth), np.sin(azimuth)
    ce, se = np.cos(altitude), np.sin(altitude)
    z = np.stack([ce * ca, ce * sa, se], axis=-1)
    x = np.stack([-se * ca, -se * sa, ce], axis=-1)
    leaning = quaternions_from_matrices(np.stack([x, np.cross(z, x), z], axis=-1))
    half = 0.5 * np.broadcast_to(np.asarray(rotation, dtype=np.float64), ca.shape)
    zero = np.zeros_like(half)
    return multiply_quaternions(leaning, np.stack([np.cos(half), zero, zero, np.sin(half)], -1))


def angles_from_orientations(orientations: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Azimuth, altitude and rotation (rad, each (N,)) of pad orientations (N, 4)."""
    axes = matrices_from_quaternions(orientations)
    x, z = axes[..., 0], axes[..., 2]
    flat = np.hypot(z[:, 0], z[:, 1])
    upright = flat < _UPRIGHT
    azimuth = np.where(upright, np.arctan2(-x[:, 1], -x[:, 0]), np.arctan2(z[:, 1], z[:, 0]))
    altitude = np.arctan2(z[:, 2], flat)
    plain = matrices_from_quaternions(orientations_from_angles(azimuth, altitude))
    along = np.sum(x * plain[..., 0], axis=-1)
    across = np.sum(x * plain[..., 1], axis=-1)
    return azimuth, altitude, np.arctan2(across, along)


def spread_equal_times(time_ns: NDArray[np.int64]) -> tuple[AnyArray, int]:
    """Times with runs of equal ones spread evenly up to the next later time.

    Tablets hand over several points at once under one time stamp. Nothing is dropped and no
    sample moves past the next stamp. A run at the end takes the step before it (1 ms if none).

    Parameters
    ----------
    time_ns : (N,) int64
        Not decreasing.

    Returns
    -------
    times : (N,) int64
        Strictly increasing if stamps that differ lie at least a run's length of ns apart; the
        same array where nothing was to do.
    n_moved : int
        How many samples got a new time.
    """
    if (time_ns[1:] > time_ns[:-1]).all():
        return time_ns, 0
    stamps, first, counts = np.unique(time_ns, return_index=True, return_counts=True)
    steps = np.diff(stamps)
    last = steps[-1] if len(steps) else _LIFT_NS
    room = np.append(steps, max(int(last), int(counts[-1])))
    rank = np.arange(len(time_ns)) - np.repeat(first, counts)
    return np.repeat(stamps, counts) + np.repeat(room, counts) * rank // np.repeat(
        counts, counts
    ), int(len(time_ns) - len(stamps))


class Lifts:
    """Lifts of the pen between strokes, found before the samples are put together.

    Where two strokes meet and either end is pressed, a sample with pressure 0 is put at the first
    one's end and another at the second one's start, 1 ms away (or a quarter of the gap, if that is
    less).

    Parameters
    ----------
    time_ns : (N,) int64
    pressed : (N,) float64
    ends : (M,) int64
        Last samples of all strokes but the last one.
    """

    def __init__(
        self, time_ns: NDArray[np.int64], pressed: NDArray[np.float64], ends: NDArray[np.int64]
    ) -> None:
        gaps = time_ns[ends + 1] - time_ns[ends]
        lift = np.minimum(_LIFT_NS, gaps // 4)
        after = (pressed[ends] > 0) & (lift > 0)
        before = (pressed[ends + 1] > 0) & (lift > 0)
        # a lift goes behind its stroke's last sample, another before the next stroke's first
        self._source = np.concatenate([ends[after], ends[before] + 1])
        self._places = np.concatenate([ends[after], ends[before]]) + 1
        self._times = np.concatenate(
            [time_ns[ends[after]] + lift[after], time_ns[ends[before] + 1] - lift[before]]
        )

    def put_times(self, time_ns: AnyArray) -> AnyArray:
        """(N + L,) the times with those of the lifted samples."""
        return _frozen(np.insert(time_ns, self._places, self._times))

    def put_pressure(self, pressed: AnyArray) -> AnyArray:
        """(N + L,) the pressures with 0 where the pen is lifted."""
        return _frozen(np.insert(pressed, self._places, 0.0))

    def put(self, values: AnyArray) -> AnyArray:
        """(N + L, ...) the values, lifted samples having those of the end that they belong to."""
        if values.ndim == 2 and values.strides[0] == 0:  # one for all, whichever sample
            return np.broadcast_to(values[:1], (len(values) + len(self._places), values.shape[1]))
        return _frozen(np.insert(values, self._places, values[self._source], axis=0))

    def put_columns(self, columns: Iterable[AnyArray]) -> AnyArray:
        """(N + L, K) columns side by side with the lifted samples', each dropped in turn."""
        whole: NDArray[np.float64] | None = None
        for k, column in enumerate(columns):
            with_lifts = self.put(column)
            if whole is None:
                whole = np.empty((len(with_lifts), 3))
            whole[:, k] = with_lifts
        assert whole is not None, "no columns"
        return _frozen(whole)


def join_strokes(
    time_ns: AnyArray,
    position: AnyArray,
    orientation: AnyArray,
    pressure: AnyArray | None,
    stroke: NDArray[np.int64],
    header: dict[str, Any],
) -> Recording:
    """Join several strokes to one pad recording, with the pen lifted between (see `Lifts`).

    A pad without pressure is taken to press at 0.5 while it touches.

    Parameters
    ----------
    time_ns, position, orientation, pressure
        As in `Recording`, without lifted samples.
    stroke : (N,) int64
        Number of each sample's stroke.
    header : dict
        Entries for the recording's header.
    """
    pressed = np.full(len(time_ns), 0.5) if pressure is None else np.asarray(pressure)
    lifts = Lifts(time_ns, pressed, np.flatnonzero(np.diff(stroke) != 0))
    return Recording(
        lifts.put_times(time_ns),
        lifts.put(position),
        lifts.put(orientation),
        lifts.put_pressure(pressed),
        header={"space": "pad", **header},
    )


def notes_of(header: Mapping[str, object]) -> list[str]:
    """Notes in a recording's header on what was assumed or put right when it was read."""
    notes = header.get("notes")
    return [note for note in notes if isinstance(note, str)] if isinstance(notes, list) else []


def _frozen(array: AnyArray) -> AnyArray:
    """A new read-only array, so that it need not be copied."""
    array.setflags(write=False)
    return array
