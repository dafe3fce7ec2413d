"""paint3d's own HID haptic stylus: pose in, force out, on a vendor-defined page.

Input report 1, 24 bytes: int32 x, y, z in um, int16 quaternion w, x, y, z in 1/16384 (Q14), uint8
buttons, uint8 reserved, uint16 sequence number. Output report 2, 8 bytes: int16 force x, y, z in
mN, uint16 the sequence number of the pose that it answers. Little-endian. The device must set its
force to zero by itself when no force report has come for 10 ms.
"""

from __future__ import annotations

import math
import struct
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from paint3d.device.recorded import MAX_FORCE_N
from paint3d.device.sample import StylusReading
from paint3d.errors import DeviceError

__all__ = [
    "DESCRIPTOR",
    "PRODUCT_ID",
    "VENDOR_ID",
    "PoseNumbers",
    "checked_force",
    "decode_force",
    "decode_numbers",
    "decode_pose",
    "encode_force",
    "encode_pose",
    "is_haptic_stylus",
]

VENDOR_ID, PRODUCT_ID = 0xF055, 0x4A50
DESCRIPTOR = bytes.fromhex(
    "0600ff 0901 a101"  # vendor page, usage 1, application
    "8501 0902 1500 26ff00 7508 9518 8102"  # report 1, 24 bytes in
    "8502 0903 1500 26ff00 7508 9508 9102"  # report 2, 8 bytes out
    "c0"
)
_POSE = struct.Struct("<BiiihhhhBBH")
_FORCE = struct.Struct("<BhhhH")
_POSE_ID, _FORCE_ID = 1, 2
_Q14 = 16384.0
_WORST_LENGTH = 0.05  # a quaternion further from unit length is a broken report
_FARTHEST = 2_000_000  # um
_MILLI = 1000.0


def is_haptic_stylus(descriptor: bytes) -> bool:
    """Return whether a descriptor is this stylus'."""
    return bytes(descriptor) == DESCRIPTOR


class PoseNumbers(NamedTuple):
    """A pose as plain numbers, which the servo handles without allocating arrays.

    `position` in mm and unit `orientation`, w first, in the device's frame.
    """

    time_ns: int
    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float]
    buttons: int
    sequence: int


def decode_numbers(data: bytes, time_ns: int = 0) -> PoseNumbers:
    """Decode the pose in an input report; trailing padding is ignored.

    Raises
    ------
    DeviceError
        If it is another report or too short, its position is beyond 2 m, or its quaternion is not
        of unit length.
    """
    if len(data) < _POSE.size or data[0] != _POSE_ID:
        raise DeviceError(
            "a stylus report of {n} bytes, {data} first; expected {pose_size}, 01 first",
            n=len(data),
            data=data[:1].hex() or "no",
            pose_size=_POSE.size,
        )
    _, x, y, z, qw, qx, qy, qz, buttons, _, sequence = _POSE.unpack_from(data)
    if not -_FARTHEST <= min(x, y, z) <= max(x, y, z) <= _FARTHEST:
        position = f"({x / _MILLI:g}, {y / _MILLI:g}, {z / _MILLI:g})"
        raise DeviceError(
            "the stylus is at {position} mm; expected within {most:g}",
            position=position,
            most=_FARTHEST / _MILLI,
        )
    length = math.sqrt(qw * qw + qx * qx + qy * qy + qz * qz)
    if abs(length / _Q14 - 1.0) > _WORST_LENGTH:
        raise DeviceError(
            "the stylus' quaternion has length {length:.3g}; expected 1",
            length=length / _Q14,
        )
    return PoseNumbers(
        time_ns,
        (x / _MILLI, y / _MILLI, z / _MILLI),
        (qw / length, qx / length, qy / length, qz / length),
        buttons,
        sequence,
    )


def decode_pose(data: bytes, time_ns: int = 0) -> tuple[StylusReading, int]:
    """Decode the reading and the sequence number in an input report; see `decode_numbers`."""
    pose = decode_numbers(data, time_ns)
    reading = StylusReading(
        time_ns, np.array(pose.position), np.array(pose.orientation), None, pose.buttons
    )
    return reading, pose.sequence


def encode_pose(
    position: ArrayLike, orientation: ArrayLike, buttons: int = 0, sequence: int = 0
) -> bytes:
    """Encode the input report of a pose, as the device or a virtual one sends it."""
    micro = np.round(np.asarray(position, np.float64) * _MILLI).astype(np.int64)
    parts = np.round(np.asarray(orientation, np.float64) * _Q14).astype(np.int64)
    return _POSE.pack(
        _POSE_ID, *micro.tolist(), *parts.tolist(), buttons & 0xFF, 0, sequence & 0xFFFF
    )


def encode_force(force: ArrayLike, sequence: int = 0) -> bytes:
    """Encode the output report of a force (3,) in N, in the device's frame.

    Raises
    ------
    DeviceError
        If the force is not finite or above the device's limit; the caller must limit it.
    """
    x, y, z = checked_force(force, MAX_FORCE_N)
    # int() truncates towards zero: rounding must not exceed the limit.
    return _FORCE.pack(
        _FORCE_ID, int(x * _MILLI), int(y * _MILLI), int(z * _MILLI), sequence & 0xFFFF
    )


def checked_force(force: ArrayLike, most: float) -> tuple[float, float, float]:
    """Return a force (3,), N, as plain numbers.

    Raises
    ------
    DeviceError
        If it is not finite or above `most`, N.
    """
    x, y, z = np.asarray(force, np.float64).tolist()
    if not math.hypot(x, y, z) <= most + 1e-6:  # negated to catch NaN
        raise DeviceError(
            "force is ({x:g}, {y:g}, {z:g}) N; expected at most {most} N", x=x, y=y, z=z, most=most
        )
    return x, y, z


def decode_force(data: bytes) -> tuple[tuple[float, float, float], int]:
    """Decode the force in N and the sequence number of an output report, as the device does.

    Raises
    ------
    DeviceError
        If it is another report.
    """
    if len(data) != _FORCE.size or data[0] != _FORCE_ID:
        raise DeviceError(
            "a force report of {n} bytes; expected {force_size}",
            n=len(data),
            force_size=_FORCE.size,
        )
    _, x, y, z, sequence = _FORCE.unpack(data)
    return (x / _MILLI, y / _MILLI, z / _MILLI), sequence
