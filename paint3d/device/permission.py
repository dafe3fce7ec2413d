"""Why a node cannot be opened, and what to do about it."""

from __future__ import annotations

import errno
import os
import re
import sys

from paint3d.device.hid_nodes import HidNode
from paint3d.errors import DeviceError, PermissionNeededError

__all__ = ["RULES_FILE", "explain_failure", "find_obstacle", "udev_rule"]

RULES_FILE = "/etc/udev/rules.d/70-paint3d.rules"
"""Below 73: the tag is acted upon there (73-seat-late.rules of systemd)."""
_LIBUSB_PATH = re.compile(r"(\d+)-[\d.]+:")


def udev_rule(node: HidNode) -> str:
    """The udev rule that lets the person at the screen open the device, by cable or Bluetooth."""
    if node.backend == "hidraw":
        device = f"{node.vendor:04X}:{node.product:04X}"
        return f'KERNEL=="hidraw*", KERNELS=="*:{device}.*", TAG+="uaccess"'
    return (
        f'SUBSYSTEM=="usb", ATTR{{idVendor}}=="{node.vendor:04x}", '
        f'ATTR{{idProduct}}=="{node.product:04x}", TAG+="uaccess"'
    )


def find_obstacle(node: HidNode) -> str | None:
    """Why the node cannot be opened for reading and writing; None where nothing seems wrong."""
    if not node.path.startswith("/dev/"):
        return None
    try:
        os.close(os.open(node.path, os.O_RDWR | os.O_NONBLOCK))
    except OSError as cause:
        if cause.errno in (errno.EACCES, errno.EPERM):
            return "no permission"
        if cause.errno in (errno.ENOENT, errno.ENODEV, errno.ENXIO):
            return "it has gone"
        return cause.strerror or str(cause)
    return None


def explain_failure(node: HidNode, cause: object = "") -> DeviceError:
    """The exception that says why this node could not be opened, and how to put it right."""
    what = f"{node.name} at {node.path}"
    obstacle = find_obstacle(node)
    if obstacle == "no permission" or (obstacle is None and _LIBUSB_PATH.match(node.path)):
        return PermissionNeededError(
            f"{what} was found but could not be opened: no permission. As root, put the line "
            f"{udev_rule(node)} into {RULES_FILE}, run 'udevadm control --reload' and plug the "
            "device in again"
        )
    if obstacle is not None:
        return DeviceError(f"{what} was found but could not be opened: {obstacle}")
    hint = ""
    if sys.platform == "darwin":
        hint = "; the maker's helper may have seized it: quit 3DconnexionHelper"
    return DeviceError(f"{what} was found but could not be opened ({cause}){hint}")
