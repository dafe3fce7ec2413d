"""Links to open HID devices, and explanations of why one cannot be opened."""

from __future__ import annotations

import errno
import os
import re
import sys
import time
from typing import Any, Protocol

from paint3d.device.hid_nodes import HidNode, backend_module
from paint3d.errors import DeviceError, Message, PermissionNeededError

__all__ = ["DeviceGoneError", "Link", "explain_failure", "find_obstacle", "open_node"]

# ---- Permissions ---------------------------------------------------------------------------------

RULES_FILE = "/etc/udev/rules.d/70-paint3d.rules"
"""Its number is below 73, as systemd's 73-seat-late.rules acts on the tag."""
_LIBUSB_PATH = re.compile(r"(\d+)-[\d.]+:")


def udev_rule(node: HidNode) -> str:
    """Return the udev rule that lets the user at the screen open the device, on any bus."""
    if node.backend == "hidraw":
        device = f"{node.vendor:04X}:{node.product:04X}"
        return f'KERNEL=="hidraw*", KERNELS=="*:{device}.*", TAG+="uaccess"'
    return (
        f'SUBSYSTEM=="usb", ATTR{{idVendor}}=="{node.vendor:04x}", '
        f'ATTR{{idProduct}}=="{node.product:04x}", TAG+="uaccess"'
    )


_FORBIDDEN = Message("no permission")


def find_obstacle(node: HidNode) -> Message | None:
    """Return why the node cannot be opened for reading and writing; None if it seems it can."""
    if not node.path.startswith("/dev/"):
        return None
    try:
        os.close(os.open(node.path, os.O_RDWR | os.O_NONBLOCK))
    except OSError as cause:
        if cause.errno in (errno.EACCES, errno.EPERM):
            return _FORBIDDEN
        if cause.errno in (errno.ENOENT, errno.ENODEV, errno.ENXIO):
            return Message("it has gone")
        return Message(cause.strerror or str(cause))
    return None


def explain_failure(node: HidNode, cause: object = "") -> DeviceError:
    """Make the exception for a node that could not be opened: why, and the remedy."""
    what = Message("{device} at {path}", device=node.name, path=node.path)
    obstacle = find_obstacle(node)
    if obstacle is _FORBIDDEN or (obstacle is None and _LIBUSB_PATH.match(node.path)):
        return PermissionNeededError(
            "{what} was found but could not be opened: no permission. As root, put the line "
            "{udev_rule} into {rules_file}, have udev read its rules again and plug the device in "
            "again",
            hint="udevadm control --reload",
            what=what,
            udev_rule=udev_rule(node),
            rules_file=RULES_FILE,
        )
    if obstacle is not None:
        return DeviceError(
            "{what} was found but could not be opened: {obstacle}",
            what=what,
            obstacle=obstacle,
        )
    if sys.platform == "darwin":
        return DeviceError(
            "{what} was found but could not be opened ({cause}); the maker's helper may have "
            "seized it: quit 3DconnexionHelper",
            what=what,
            cause=cause,
        )
    return DeviceError("{what} was found but could not be opened ({cause})", what=what, cause=cause)


# ---- Links ---------------------------------------------------------------------------------------

MAX_REPORT = 64
_MOST_AT_ONCE = 256
"""The kernel queues 64; the limit ends a read from a device that sends faster than we read."""


class DeviceGoneError(DeviceError):
    """The device was unplugged, or its driver released it."""


class Link(Protocol):
    """Interface of an open device: `HidLink`, or `PlaybackLink`, which plays a log."""

    name: str
    descriptor: bytes

    def read(self, timeout_ms: int) -> list[tuple[int, bytes]]:
        """Return all queued reports, oldest first, each with its time in ns."""

    def write(self, report: bytes) -> None:
        """Send an output report, id first."""

    def close(self) -> None:
        """Release the device."""


class HidLink:
    """A device opened by hidapi; see `open_node`."""

    def __init__(self, device: Any, name: str) -> None:
        self._device = device
        self.name = name
        self.descriptor = bytes(device.get_report_descriptor())
        device.set_nonblocking(1)

    def read(self, timeout_ms: int) -> list[tuple[int, bytes]]:
        """Wait for a report, then take all that are queued.

        The kernel keeps the oldest 63 reports and drops the newest, so a queue that is not emptied
        goes stale.

        Parameters
        ----------
        timeout_ms : int
            How long to wait for the first; 0 does not wait.

        Returns
        -------
        list of (int, bytes)
            Time of reading, ns on the monotonic clock, and report; empty after a timeout.

        Raises
        ------
        DeviceGoneError
            If the device is gone.
        """
        reports = []
        report = self._read_one(timeout_ms)
        while report:
            reports.append((time.monotonic_ns(), report))
            if len(reports) == _MOST_AT_ONCE:
                break
            report = self._read_one(0)
        return reports

    def _read_one(self, timeout_ms: int) -> bytes:
        try:
            if timeout_ms > 0:
                return bytes(self._device.read(MAX_REPORT, timeout_ms))
            return bytes(self._device.read(MAX_REPORT))
        except (OSError, ValueError) as cause:
            raise DeviceGoneError(
                "{name} has gone ({cause})", name=self.name, cause=cause
            ) from None

    def write(self, report: bytes) -> None:
        """Send an output report, id first.

        Raises
        ------
        DeviceGoneError
            If it could not be sent.
        """
        try:
            sent = self._device.write(report)
        except (OSError, ValueError) as cause:
            raise DeviceGoneError(
                "{name} has gone ({cause})", name=self.name, cause=cause
            ) from None
        if sent < 0:
            raise DeviceGoneError("{name} has gone: a report could not be sent", name=self.name)

    def close(self) -> None:
        """Release the device; idempotent."""
        self._device.close()


def open_node(node: HidNode) -> HidLink:
    """Open a node.

    Raises
    ------
    PermissionNeededError
        If it may not be opened; the message holds the udev rule to add.
    DeviceError
        If it cannot be opened for another reason, or has no report descriptor.
    """
    device = backend_module(node.backend).device()
    try:
        device.open_path(node.path.encode())
    except OSError as cause:
        raise explain_failure(node, cause) from None
    try:
        return HidLink(device, node.name)
    except (OSError, ValueError) as cause:
        device.close()
        raise DeviceError(
            "{device} at {path} gives no report descriptor ({cause})",
            device=node.name,
            path=node.path,
            cause=cause,
        ) from None
