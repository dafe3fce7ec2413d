"""Everything that takes bytes from a device, as targets for a fuzzer.

Each target either returns or raises a `Paint3DError`; anything else is a bug.
"""

from __future__ import annotations

from collections.abc import Callable

from paint3d.device.descriptor import parse_descriptor
from paint3d.device.digitizer import find_digitizer_layout
from paint3d.device.force.haptic_stylus import decode_force, decode_pose
from paint3d.device.force.inverse3 import decode_state
from paint3d.device.six_dof import MouseReading, find_mouse_layout
from paint3d.errors import DeviceError

__all__ = ["TARGETS", "decode_any"]


def _mouse(data: bytes) -> None:
    descriptor, reports = _halves(data)
    layout = find_mouse_layout(parse_descriptor(descriptor))
    layout.encode_light(True)
    reading = MouseReading()
    for report in reports:
        reading = layout.decode(report, reading)


def _pen(data: bytes) -> None:
    descriptor, reports = _halves(data)
    layout = find_digitizer_layout(parse_descriptor(descriptor))
    for report in reports:
        layout.decode(report)


def _halves(data: bytes) -> tuple[bytes, list[bytes]]:
    """Two bytes of length, a descriptor of that length, then reports of 16 bytes."""
    n = int.from_bytes(data[:2], "little")
    body = data[2 + n :]
    return data[2 : 2 + n], [body[i : i + 16] for i in range(0, len(body), 16)]


TARGETS: dict[str, Callable[[bytes], object]] = {
    "descriptor": parse_descriptor,
    "mouse": _mouse,
    "pen": _pen,
    "stylus pose": decode_pose,
    "stylus force": decode_force,
    "inverse3 state": decode_state,
}
"""Name: a function of bytes that returns or raises a `Paint3DError`."""


def decode_any(data: bytes) -> dict[str, str]:
    """Hand the same bytes to every target; what each of them said.

    Returns
    -------
    dict
        Name of the target: "" where it accepted the bytes, else the message of its refusal.
    """
    said = {}
    for name, target in TARGETS.items():
        try:
            target(data)
            said[name] = ""
        except DeviceError as refusal:
            said[name] = str(refusal)
    return said
