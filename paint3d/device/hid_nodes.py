"""Enumeration of connected HID nodes, with the kind of device and the hidapi backend of each.

On Linux the wheel of hidapi holds two backends: ``hidraw`` (the kernel's own HID layer, which
reports a node's usages) and ``hid`` (libusb, which detaches a device from the kernel). hidraw is
preferred; a node that only libusb lists is opened through libusb.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from paint3d.device.catalogue import find_mouse_quirks, is_listed_mouse, is_never_six_dof
from paint3d.device.descriptor import parse_descriptor
from paint3d.device.digitizer import find_digitizer_layout
from paint3d.device.force.haptic_stylus import PRODUCT_ID, VENDOR_ID, is_haptic_stylus
from paint3d.device.six_dof import find_mouse_layout, is_multi_axis
from paint3d.errors import DeviceError

__all__ = ["HidNode", "backend_module", "backends", "kind_of", "list_nodes"]

_MULTI_AXIS = (1, 8)
_PENS = {(page, usage) for page in (0x0D, 0xFF0D) for usage in (1, 2, 0x20)}
_SYSFS = "/sys/class/hidraw/{}/device/report_descriptor"


@dataclass(frozen=True, slots=True)
class HidNode:
    """One node of one device.

    Attributes
    ----------
    path : str
        As the backend names it: ``/dev/hidraw3``, or ``1-2:1.0`` under libusb.
    backend : str
        "hidraw" or "hid".
    vendor, product : int
    name : str
        From the catalogue, else from the device's own strings.
    serial : str
    usage_page, usage : int
        Of its first top-level collection; 0 if the backend does not report them.
    kind : {"mouse", "stylus", "pen", "other"}
        6-DOF mouse, haptic stylus, digitizer.
    """

    path: str
    backend: str
    vendor: int
    product: int
    name: str
    serial: str
    usage_page: int
    usage: int
    kind: str


def backends() -> tuple[str, ...]:
    """Names of hidapi's modules, in order of preference."""
    return ("hidraw", "hid") if sys.platform.startswith("linux") else ("hid",)


def backend_module(backend: str) -> ModuleType:
    """Import the module of a backend.

    Raises
    ------
    DeviceError
        If hidapi lacks it, or it needs a library that is missing.
    """
    try:
        return import_module(backend)
    except ImportError as cause:
        raise DeviceError(
            "hidapi's module {backend!r} cannot be loaded: {cause}",
            backend=backend,
            cause=cause,
        ) from None


def list_nodes(kinds: tuple[str, ...] = ("mouse", "stylus", "pen")) -> list[HidNode]:
    """List nodes of these kinds by path, hidraw's before libusb's.

    A device that hidraw lists is not listed again under libusb.

    Raises
    ------
    DeviceError
        If no backend can be loaded.
    """
    nodes: list[HidNode] = []
    failures = []
    for backend in backends():
        try:
            entries = backend_module(backend).enumerate()
        except DeviceError as failure:
            failures.append(failure)
            continue
        listed = {(node.vendor, node.product) for node in nodes}
        by_path: dict[str, HidNode] = {}  # hidapi lists a node for every top-level collection
        for entry in entries:
            if (entry["vendor_id"], entry["product_id"]) in listed:
                continue
            node = _make_node(backend, entry)
            if node.path not in by_path or by_path[node.path].kind == "other":
                by_path[node.path] = node
        nodes += [by_path[path] for path in sorted(by_path)]
    if len(failures) == len(backends()):
        raise failures[0]
    return [node for node in nodes if node.kind in kinds]


def _make_node(backend: str, entry: dict[str, Any]) -> HidNode:
    vendor, product = entry["vendor_id"], entry["product_id"]
    path = entry["path"].decode(errors="replace")
    usages = (entry["usage_page"], entry["usage"])
    listed = find_mouse_quirks(vendor, product).name
    strings = [entry.get(key) or "" for key in ("manufacturer_string", "product_string")]
    name = listed or " ".join(part for part in strings if part) or f"{vendor:04x}:{product:04x}"
    kind = _kind(backend, path, vendor, product, usages)
    return HidNode(
        path, backend, vendor, product, name, entry.get("serial_number") or "", *usages, kind
    )


def _kind(backend: str, path: str, vendor: int, product: int, usages: tuple[int, int]) -> str:
    if is_never_six_dof(vendor, product):
        return "other"
    if (vendor, product) == (VENDOR_ID, PRODUCT_ID):
        return "stylus"
    if usages == _MULTI_AXIS:
        return "mouse"
    if usages in _PENS:
        return "pen"
    if backend == "hidraw":
        try:  # sysfs may be readable even if the node may not be opened
            return kind_of(Path(_SYSFS.format(Path(path).name)).read_bytes())
        except OSError:
            return "other"
    # libusb's backend reports no usages, so only a device in the catalogue is used.
    return "mouse" if usages == (0, 0) and is_listed_mouse(vendor, product) else "other"


def kind_of(descriptor: bytes) -> str:
    """Classify a report descriptor as "mouse", "stylus", "pen" or "other"."""
    if is_haptic_stylus(descriptor):
        return "stylus"
    try:
        parsed = parse_descriptor(descriptor)
    except DeviceError:
        return "other"
    for kind, find in (("mouse", find_mouse_layout), ("pen", find_digitizer_layout)):
        try:
            find(parsed)
        except DeviceError:
            continue
        if kind == "pen" or is_multi_axis(parsed):
            return kind
    return "other"
