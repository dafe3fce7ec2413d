"""Recordings of both hands: checked arrays, and their playback as device samples."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_array, lengths_of
from paint3d.device.sample import DeviceSample
from paint3d.errors import RecordingError

__all__ = ["FORMAT", "MAX_FORCE_N", "MODEL", "UNIT_TOLERANCE", "VERSION", "Recording"]

FORMAT = "paint3d-recording"
VERSION = 1
MODEL = 2
"""Version of the brush and ink by which strokes are painted: it goes up where marks change."""
MAX_FORCE_N = 7.9
"""Greatest force of the papers' device (Guo 2017, section 5): pressure 1."""
UNIT_TOLERANCE = 1e-3
"""A quaternion's length may differ from 1 by this much; it is then normalised."""

_ROUNDING = 1e-12
_CHOICES = {"space": ("world", "pad"), "azimuth": ("commanded", "dragged")}


@dataclass(frozen=True, eq=False)
class Recording:
    """N samples of the brush (right hand) and of the object (left hand), in time order.

    `position` is the tuft's root P_m, where the hairs leave the ferrule. With `pressure`, the force
    (pressure times 7.9 N) determines the descent by Guo 2017, Eq. 4, and the position only where on
    the surface; without it the descent follows from the root's distance to the surface. In pad
    space (``header["space"] == "pad"``) x and y are mm on a flat pad and z the height of the lifted
    pen above it; `paint3d.painter.flat_input.lay` maps such a recording onto a surface.

    Attributes
    ----------
    time_ns : (N,) int64
        Strictly increasing; N is at least 1.
    position : (N, 3) float64
        mm, in the world.
    orientation : (N, 4) float64
        world_from_pen, unit quaternions, w first. Pen z runs from tip to root, pen x is the
        direction in which the tip bends.
    pressure : (N,) float64 in [0, 1], or None
    buttons : (N,) int32
    object_position : (N, 3) float64
        mm; zero where the left hand never moved.
    object_orientation : (N, 4) float64
        world_from_object, unit quaternions, w first.
    contact : (N, 3) float64, or None
        Intended contact points on the surface, in the world, mm; rows of NaN for samples without
        one. The footprint is centred there, wherever the root is. Requires a pressure; None if no
        sample has one.
    header : dict
        format, version, units, devices, brush, ink, object, licence, space ("world" or "pad"),
        azimuth ("commanded" or "dragged"); other entries are kept.

    Raises
    ------
    RecordingError
        If lengths differ, a value is not finite or out of range, time does not increase, or a
        quaternion's length is further than 1e-3 from 1.
    """

    time_ns: NDArray[np.int64]
    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    pressure: NDArray[np.float64] | None = None
    buttons: NDArray[np.int32] = None  # type: ignore[assignment]  # filled in below
    object_position: NDArray[np.float64] = None  # type: ignore[assignment]  # filled in below
    object_orientation: NDArray[np.float64] = None  # type: ignore[assignment]  # filled in below
    header: Mapping[str, Any] = field(default_factory=dict)
    contact: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        time_ns = _times(self.time_ns)
        n = len(time_ns)
        identity = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (n, 4))
        checked = {
            "time_ns": time_ns,
            "position": _floats(self.position, "position", (n, 3)),
            "orientation": _unit(self.orientation, "orientation", n),
            "pressure": None if self.pressure is None else _pressures(self.pressure, n),
            "buttons": _buttons(self.buttons, n),
            "object_position": np.broadcast_to(np.zeros(3), (n, 3))
            if self.object_position is None
            else _floats(self.object_position, "object_position", (n, 3)),
            "object_orientation": identity
            if self.object_orientation is None
            else _unit(self.object_orientation, "object_orientation", n),
            "contact": _contacts(self.contact, n, self.pressure is not None),
        }
        for name, array in checked.items():
            if array is not None and array.flags.writeable:
                array.setflags(write=False)
            object.__setattr__(self, name, array)
        object.__setattr__(self, "header", checked_header(self.header))

    def __len__(self) -> int:
        return len(self.time_ns)

    @property
    def is_pad(self) -> bool:
        """True if the samples lie on a flat pad, and must be mapped onto a surface first."""
        return bool(self.header["space"] == "pad")

    @property
    def duration_s(self) -> float:
        """Time from the first sample to the last, s."""
        return float(self.time_ns[-1] - self.time_ns[0]) * 1e-9

    def part(self, first: int, last: int) -> Recording:
        """Return the samples from `first` up to, not including, `last`; its arrays are views."""
        part = object.__new__(Recording)
        for entry in fields(self):
            value = getattr(self, entry.name)
            cut = value[first:last] if isinstance(value, np.ndarray) else value
            object.__setattr__(part, entry.name, cut)
        return part

    def samples(self) -> Iterator[DeviceSample]:
        """Yield the samples one by one, as a live device would."""
        for i in range(len(self)):
            contact = None if self.contact is None else self.contact[i]
            yield DeviceSample(
                int(self.time_ns[i]),
                self.position[i],
                self.orientation[i],
                None if self.pressure is None else float(self.pressure[i]),
                int(self.buttons[i]),
                self.object_position[i],
                self.object_orientation[i],
                None if contact is None or np.isnan(contact[0]) else contact,
            )


def checked_header(header: Mapping[str, Any]) -> dict[str, Any]:
    """Copy `header` and fill in its defaults.

    Raises
    ------
    RecordingError
        For an unknown format, version, space or azimuth.
    """
    filled: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "model": MODEL,
        "units": {"position": "mm", "time": "ns", "force": "N"},
        "space": "world",
        "azimuth": "commanded",
        **header,
    }
    if filled["format"] != FORMAT:
        raise RecordingError(f"format is {filled['format']!r}; expected {FORMAT!r}")
    version = filled["version"]
    if isinstance(version, bool) or version != VERSION:
        raise RecordingError(f"version is {version!r}; expected {VERSION}")
    model = filled["model"]
    if type(model) is not int or model < 1:
        raise RecordingError(f"model is {model!r}; expected a whole number from 1")
    for key, known in _CHOICES.items():
        if filled[key] not in known:
            raise RecordingError(f"{key} is {filled[key]!r}; expected {' or '.join(known)}")
    return filled


def _times(values: ArrayLike) -> AnyArray:
    raw = np.asarray(values)
    if raw.ndim != 1 or raw.dtype.kind not in "iu":
        raise RecordingError(
            f"time_ns has shape {raw.shape} and type {raw.dtype}; expected (N,) integers"
        )
    if len(raw) == 0:
        raise RecordingError("the recording has no samples; expected at least one")
    times = _own(raw.astype(np.int64, copy=False), values)
    late = np.flatnonzero(times[1:] <= times[:-1])
    if len(late):
        i = int(late[0]) + 1
        raise RecordingError(
            f"sample {i}: time_ns is {times[i]}; expected more than {times[i - 1]}, "
            "the sample before it"
        )
    return times


def _floats(values: ArrayLike, name: str, shape: tuple[int, ...]) -> AnyArray:
    if _is_one_row(values, shape):  # check and keep just one
        return np.broadcast_to(_floats(values[:1], name, (1, *shape[1:])), shape)
    return _own(as_array(values, name, shape, error=RecordingError), values)


def _own(array: AnyArray, given: object) -> AnyArray:
    """Copy an array, unless it is the given one, owns its memory and is read-only."""
    frozen = array is given and array.base is None and not array.flags.writeable
    return array if frozen else array.copy()


def _is_one_row(values: ArrayLike, shape: tuple[int, ...]) -> TypeGuard[AnyArray]:
    """Return whether it is an array of that shape with one row broadcast to all."""
    if not isinstance(values, np.ndarray) or values.shape != shape or len(shape) != 2:
        return False
    return shape[0] > 1 and values.strides[0] == 0


def _unit(values: ArrayLike, name: str, n: int) -> AnyArray:
    if _is_one_row(values, (n, 4)):
        return np.broadcast_to(_unit(values[:1], name, 1), (n, 4))
    array = _floats(values, name, (n, 4))
    with np.errstate(over="ignore"):
        length = lengths_of(array)
    bad = np.flatnonzero(np.abs(length - 1.0) > UNIT_TOLERANCE)
    if len(bad):
        raise RecordingError(
            f"sample {bad[0]}: {name} has length {length[bad[0]]:.6g}; "
            f"expected 1 within {UNIT_TOLERANCE:g}"
        )
    off = np.abs(length - 1.0) > _ROUNDING
    if off.any():
        array = array if array.flags.writeable else array.copy()
        array[off] /= length[off, None]
    return array


def _pressures(values: ArrayLike, n: int) -> AnyArray:
    array = _floats(values, "pressure", (n,))
    bad = np.flatnonzero((array < 0.0) | (array > 1.0))
    if len(bad):
        raise RecordingError(f"sample {bad[0]}: pressure is {array[bad[0]]:.6g}; expected 0 to 1")
    return array


def _contacts(values: ArrayLike | None, n: int, with_pressure: bool) -> AnyArray | None:
    """Check contact points; None if no sample has one."""
    if values is None:
        return None
    array = np.array(values, dtype=np.float64)
    if array.shape != (n, 3):
        raise RecordingError(f"contact has shape {array.shape}; expected ({n}, 3)")
    if np.isfinite(array).all():
        return _with_pressure(array, with_pressure)
    missing = np.isnan(array)
    bad = np.flatnonzero((missing.any(axis=1) & ~missing.all(axis=1)) | np.isinf(array).any(axis=1))
    if len(bad):
        raise RecordingError(
            f"sample {bad[0]}: contact is {array[bad[0]].tolist()}; expected finite numbers"
        )
    return None if missing.all() else _with_pressure(array, with_pressure)


def _with_pressure(contact: AnyArray, with_pressure: bool) -> AnyArray:
    if not with_pressure:
        raise RecordingError("contact is given without a pressure; expected both")
    return contact


def _buttons(values: ArrayLike | None, n: int) -> AnyArray:
    if values is None:
        return np.zeros(n, dtype=np.int32)
    raw = np.asarray(values)
    if raw.shape != (n,) or raw.dtype.kind not in "iu":
        raise RecordingError(
            f"buttons has shape {raw.shape} and type {raw.dtype}; expected ({n},) integers"
        )
    bad = np.flatnonzero((raw < 0) | (raw > 0x7FFFFFFF))
    if len(bad):
        raise RecordingError(f"sample {bad[0]}: buttons is {raw[bad[0]]}; expected 0 to 2147483647")
    return _own(raw.astype(np.int32, copy=False), values)
