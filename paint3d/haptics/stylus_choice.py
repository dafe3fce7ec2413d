"""Choice of the force-feedback stylus: parsing it, and finding the device."""

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

__all__ = ["STYLI", "DetectedStylus", "check_stylus", "find_stylus", "key_of_node"]

STYLI = ("auto", "hid", "openhaptics", "inverse3", "none")
"""Choices of a stylus; one with a library or service may give its location after "="."""

_WITH_LOCATION = ("openhaptics", "inverse3")
_HAPLY = DeviceLimits(INVERSE3_FORCE_N, 0.5)  # stiffness chosen to be cautious, not measured

log = logging.getLogger("paint3d")


@dataclass(frozen=True)
class DetectedStylus:
    """A force-feedback stylus that is connected.

    Attributes
    ----------
    kind : {"hid", "openhaptics", "inverse3"}
    name : str
        For display.
    key : str
        Identifies the device in saved files: letters, digits and dashes.
    port : ForcePort
        Opens and runs it.
    limits : DeviceLimits
    frame : DeviceCalibration
        From its own axes to the world's, until it is calibrated.
    """

    kind: str
    name: str
    key: str
    port: ForcePort
    limits: DeviceLimits
    frame: DeviceCalibration


def check_stylus(choice: str) -> str:
    """Return a choice if it is valid.

    Raises
    ------
    InputError
        If it is none of `STYLI`, or gives a location that its kind does not have.
    """
    _split(choice)
    return choice


def _split(choice: str) -> tuple[str, str]:
    """Split a choice into kind and location, which may be empty."""
    kind, equals, location = choice.partition("=") if isinstance(choice, str) else ("", "", "")
    if kind not in STYLI or (equals and (kind not in _WITH_LOCATION or not location)):
        raise InputError(
            "stylus is {choice!r}; expected {styli}, openhaptics=/PATH/libHD.so or "
            "inverse3=ws://HOST:PORT",
            choice=choice,
            styli=", ".join(STYLI),
        )
    return kind, location


def find_stylus(choice: str = "auto") -> DetectedStylus | None:
    """Find the chosen stylus; None for "none", or if "auto" finds none.

    "auto" takes the first available of paint3d's own HID protocol, OpenHaptics, Inverse3.

    Raises
    ------
    InputError
        See `check_stylus`.
    DeviceError
        If the chosen one does not answer; the message says what is missing and where to get it.
        For "auto" only if there is a HID stylus that may not be opened.
    """
    kind, location = _split(choice)
    if kind == "none":
        return None
    if kind != "auto":
        finders = {
            "hid": _find_hid,
            "openhaptics": _find_openhaptics,
            "inverse3": _find_inverse3,
        }
        return finders[kind](location)
    try:
        has_hid = bool(list_nodes(("stylus",)))
    except DeviceError as failure:  # hidapi is missing; the others do without
        log.info("%s", failure)
        has_hid = False
    if has_hid:
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


def _find_hid(_: str) -> DetectedStylus:
    nodes = list_nodes(("stylus",))
    if not nodes:
        raise DeviceError(
            "no HID haptic stylus is plugged in; expected a device "
            "{vendor_id:04x}:{product_id:04x} (docs/devices.md says what it sends)",
            vendor_id=VENDOR_ID,
            product_id=PRODUCT_ID,
        )
    node = nodes[0]
    if find_obstacle(node) is not None:
        raise explain_failure(node)
    port = HidForcePort(node)
    frame = DeviceCalibration()
    return DetectedStylus("hid", node.name, key_of_node(node), port, PHANTOM_DESKTOP, frame)


def _find_openhaptics(location: str) -> DetectedStylus:
    is_library = "/" in location or ".so" in location or location.endswith(".dll")
    port = OpenHapticsPort(library=location) if is_library else OpenHapticsPort(location)
    force, stiffness = port.read_limits()
    limits = DeviceLimits(force, stiffness or TOUCH.max_stiffness)
    frame = DeviceCalibration(np.array(WORLD_FROM_OPENHAPTICS))
    name = port.name or "default device"
    return DetectedStylus(
        "openhaptics", f"OpenHaptics {name}", _key("openhaptics", port.name), port, limits, frame
    )


def _find_inverse3(location: str) -> DetectedStylus:
    port = Inverse3Port(location or URI)
    name = port.read_name()
    return DetectedStylus(
        "inverse3",
        f"Haply Inverse3 {name}",
        _key("inverse3", name),
        port,
        _HAPLY,
        DeviceCalibration(),
    )


def key_of_node(node: HidNode) -> str:
    """Return the key that identifies a HID device in saved files."""
    kind = "pen" if node.kind == "pen" else "hid"
    return _key(kind, f"{node.vendor:04x}-{node.product:04x}", node.serial)


def _key(*parts: str) -> str:
    """Join parts to one word that can be a file name."""
    words = [re.sub(r"[^A-Za-z0-9]+", "-", part).strip("-") for part in parts]
    return "-".join(word for word in words if word)[:80].lower()
