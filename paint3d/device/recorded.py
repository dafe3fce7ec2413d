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
MODEL = 14
"""Version of the brush and ink by which strokes are painted: it goes up where marks change."""
MAX_FORCE_N = 7.9
"""Greatest force of the papers' device (Guo 2017, section 5): pressure 1."""
UNIT_TOLERANCE = 1e-3
"""A quaternion's length may differ from 1 by this much; it is then normalised."""

_ROUNDING = 1e-12
_CHOICES = {"space": ("world", "pad"), "azimuth": ("commanded", "dragged")}


@dataclass(frozen=True, eq=False, repr=False)
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

    def __repr__(self) -> str:
        kind = "pad" if self.is_pad else "poses"
        seconds = (self.time_ns[-1] - self.time_ns[0]) / 1e9
        return f"<Recording: {kind}, {len(self)} samples in {seconds:.3g} s>"

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
        raise RecordingError(
            "format is {format!r}; expected {expected!r}",
            format=filled["format"],
            expected=FORMAT,
        )
    version = filled["version"]
    if isinstance(version, bool) or version != VERSION:
        raise RecordingError(
            "version is {version!r}; expected {expected}",
            version=version,
            expected=VERSION,
        )
    model = filled["model"]
    if type(model) is not int or model < 1:
        raise RecordingError("model is {model!r}; expected a whole number from 1", model=model)
    for key, known in _CHOICES.items():
        if filled[key] not in known:
            raise RecordingError(
                "{key} is {filled!r}; expected {known}",
                key=key,
                filled=filled[key],
                known=" or ".join(known),
            )
    return filled


def _times(values: ArrayLike) -> AnyArray:
    raw = np.asarray(values)
    if raw.ndim != 1 or raw.dtype.kind not in "iu":
        raise RecordingError(
            "time_ns has shape {raw_shape} and type {raw_dtype}; expected (N,) integers",
            raw_shape=raw.shape,
            raw_dtype=raw.dtype,
        )
    if len(raw) == 0:
        raise RecordingError("the recording has no samples; expected at least one")
    times = _own(raw.astype(np.int64, copy=False), values)
    late = np.flatnonzero(times[1:] <= times[:-1])
    if len(late):
        i = int(late[0]) + 1
        raise RecordingError(
            "sample {i}: time_ns is {times}; expected more than {i_times}, the sample before it",
            i=i,
            times=times[i],
            i_times=times[i - 1],
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
            "sample {first}: {name} has length {length:.6g}; expected 1 within {unit_tolerance:g}",
            first=bad[0],
            name=name,
            length=length[bad[0]],
            unit_tolerance=UNIT_TOLERANCE,
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
        raise RecordingError(
            "sample {first}: pressure is {array:.6g}; expected 0 to 1",
            first=bad[0],
            array=array[bad[0]],
        )
    return array


def _contacts(values: ArrayLike | None, n: int, with_pressure: bool) -> AnyArray | None:
    """Check contact points; None if no sample has one."""
    if values is None:
        return None
    array = np.array(values, dtype=np.float64)
    if array.shape != (n, 3):
        raise RecordingError(
            "contact has shape {array_shape}; expected ({n}, 3)",
            array_shape=array.shape,
            n=n,
        )
    if np.isfinite(array).all():
        return _with_pressure(array, with_pressure)
    missing = np.isnan(array)
    bad = np.flatnonzero((missing.any(axis=1) & ~missing.all(axis=1)) | np.isinf(array).any(axis=1))
    if len(bad):
        raise RecordingError(
            "sample {first}: contact is {array}; expected finite numbers",
            first=bad[0],
            array=array[bad[0]].tolist(),
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
            "buttons has shape {raw_shape} and type {raw_dtype}; expected ({n},) integers",
            raw_shape=raw.shape,
            raw_dtype=raw.dtype,
            n=n,
        )
    bad = np.flatnonzero((raw < 0) | (raw > 0x7FFFFFFF))
    if len(bad):
        raise RecordingError(
            "sample {first}: buttons is {raw}; expected 0 to 2147483647",
            first=bad[0],
            raw=raw[bad[0]],
        )
    return _own(raw.astype(np.int32, copy=False), values)
