"""Which stylus pushes back: chosen in words, found, and told what it needs where it is missing."""

from __future__ import annotations

import logging
import re
from dataclasses import dataclass

import numpy as np

from paint3d.device.force.force_port import ForcePort, HidForcePort
from paint3d.device.force.haptic_stylus import PRODUCT_ID, VENDOR_ID
from paint3d.device.force.inverse3 import MAX_FORCE_N as INVERSE3_FORCE_N
from paint3d.device.force.inverse3 import URI, Inverse3Port
from paint3d.device.force.openhaptics import WORLD_FROM_OPENHAPTICS, OpenHapticsPort
from paint3d.device.hid_link import explain_failure, find_obstacle
from paint3d.device.hid_nodes import HidNode, list_nodes
from paint3d.errors import DeviceError, InputError
from paint3d.haptics.settings import PHANTOM_DESKTOP, TOUCH, DeviceLimits
from paint3d.pose.calibration import DeviceCalibration

__all__ = ["STYLI", "FoundStylus", "check_stylus", "find_stylus", "key_of_node"]

STYLI = ("auto", "hid", "openhaptics", "inverse3", "none")
"""What a stylus may be chosen by; those of a library or service may say where, after "="."""

_WITH_PLACE = ("openhaptics", "inverse3")
_HAPLY = DeviceLimits(INVERSE3_FORCE_N, 0.5)  # stiffness chosen to be cautious, not measured

log = logging.getLogger("paint3d")


@dataclass(frozen=True)
class FoundStylus:
    """A stylus that answers.

    Attributes
    ----------
    kind : {"hid", "openhaptics", "inverse3"}
    name : str
        For people.
    key : str
        Which device it is, for what is kept of it: letters, digits and dashes.
    port : ForcePort
        Opens and runs it.
    limits : DeviceLimits
    frame : DeviceCalibration
        Its own axes in the world's, where it has not been calibrated.
    """

    kind: str
    name: str
    key: str
    port: ForcePort
    limits: DeviceLimits
    frame: DeviceCalibration


def check_stylus(choice: str) -> str:
    """A choice as it was given.

    Raises
    ------
    InputError
        If it is none of `STYLI`, or names a place where there is none to be named.
    """
    _split(choice)
    return choice


def _split(choice: str) -> tuple[str, str]:
    """The kind, and the place behind "=" or an empty one."""
    kind, equals, place = choice.partition("=") if isinstance(choice, str) else ("", "", "")
    if kind not in STYLI or (equals and (kind not in _WITH_PLACE or not place)):
        raise InputError(
            f"stylus is {choice!r}; expected {', '.join(STYLI)}, "
            "openhaptics=/PATH/libHD.so or inverse3=ws://HOST:PORT"
        )
    return kind, place


def find_stylus(choice: str = "auto") -> FoundStylus | None:
    """The stylus that was chosen; None where none is wanted, or by "auto" none is there.

    "auto" takes the first that is there of paint3d's own HID protocol, OpenHaptics, Inverse3.

    Raises
    ------
    InputError
        See `check_stylus`.
    DeviceError
        If the one that was chosen does not answer: what is missing, and where it comes from.
        By "auto" only if a HID stylus was found that may not be opened.
    """
    kind, place = _split(choice)
    if kind == "none":
        return None
    if kind != "auto":
        return {"hid": _find_hid, "openhaptics": _find_openhaptics, "inverse3": _find_inverse3}[
            kind
        ](place)
    if _has_hid():
        return _find_hid("")
    for find, is_there in (
        (_find_openhaptics, OpenHapticsPort().is_installed),
        (_find_inverse3, Inverse3Port().is_served),
    ):
        if not is_there():
            continue
        try:
            return find("")
        except DeviceError as failure:
            log.warning("%s", failure)
    return None


def _has_hid() -> bool:
    try:
        return bool(list_nodes(("stylus",)))
    except DeviceError as failure:  # without hidapi there may be another
        log.info("%s", failure)
        return False


def _find_hid(_: str) -> FoundStylus:
    nodes = list_nodes(("stylus",))
    if not nodes:
        raise DeviceError(
            "no HID haptic stylus is plugged in; expected a device "
            f"{VENDOR_ID:04x}:{PRODUCT_ID:04x} (docs/devices.md says what it sends)"
        )
    node = nodes[0]
    if find_obstacle(node) is not None:
        raise explain_failure(node)
    port = HidForcePort(node)
    frame = DeviceCalibration()
    return FoundStylus("hid", node.name, key_of_node(node), port, PHANTOM_DESKTOP, frame)


def _find_openhaptics(place: str) -> FoundStylus:
    is_library = "/" in place or ".so" in place or place.endswith(".dll")
    port = OpenHapticsPort(library=place) if is_library else OpenHapticsPort(place)
    force, stiffness = port.read_limits()
    limits = DeviceLimits(force, stiffness or TOUCH.max_stiffness)
    frame = DeviceCalibration(np.array(WORLD_FROM_OPENHAPTICS))
    name = port.name or "default device"
    return FoundStylus(
        "openhaptics", f"OpenHaptics {name}", _key("openhaptics", port.name), port, limits, frame
    )


def _find_inverse3(place: str) -> FoundStylus:
    port = Inverse3Port(place or URI)
    name = port.read_name()
    return FoundStylus(
        "inverse3",
        f"Haply Inverse3 {name}",
        _key("inverse3", name),
        port,
        _HAPLY,
        DeviceCalibration(),
    )


def key_of_node(node: HidNode) -> str:
    """Which HID device it is, for what is kept of it."""
    kind = "pen" if node.kind == "pen" else "hid"
    return _key(kind, f"{node.vendor:04x}-{node.product:04x}", node.serial)


def _key(*parts: str) -> str:
    """Parts as one word that may name a file."""
    words = [re.sub(r"[^A-Za-z0-9]+", "-", part).strip("-") for part in parts]
    return "-".join(word for word in words if word)[:80].lower()
