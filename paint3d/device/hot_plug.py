"""Hot plugging: devices that connect and disconnect while the program runs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from paint3d.device.catalogue import find_mouse_quirks
from paint3d.device.hid_link import Link, open_node
from paint3d.device.hid_nodes import HidNode, list_nodes
from paint3d.device.sample import StylusReading
from paint3d.device.space_mouse import DeflectionSettings, MouseEvent, SpaceMouse
from paint3d.device.stylus import Stylus
from paint3d.errors import DeviceError

__all__ = ["Changes", "PluggedDevices", "compare_nodes"]

_INTERVAL_S = 1.0
_RESTING_NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Changes:
    """Nodes connected and disconnected between two enumerations."""

    added: tuple[HidNode, ...]
    removed: tuple[HidNode, ...]


def compare_nodes(before: list[HidNode], now: list[HidNode]) -> Changes:
    """Compare two enumerations; a node reconnected at the same path is unchanged."""
    old, new = {n.path: n for n in before}, {n.path: n for n in now}
    return Changes(
        tuple(n for p, n in new.items() if old.get(p) != n),
        tuple(n for p, n in old.items() if new.get(p) != n),
    )


class PluggedDevices:
    """All connected mice and styli: opens new ones once a second and closes those that are gone.

    Parameters
    ----------
    find : callable
        Lists the nodes: `list_nodes`, or a stand-in.
    open_link : callable
        Opens a node: `open_node`, or a stand-in.
    interval_s : float
        Between two enumerations; 0 enumerates only when `rescan` is called.
    log : callable, optional
        Called with the node, its descriptor, the time and every raw report.
    deflection : DeflectionSettings, optional
        For the caps of mice.
    """

    def __init__(
        self,
        find: Callable[[], list[HidNode]] = list_nodes,
        open_link: Callable[[HidNode], Link] = open_node,
        interval_s: float = _INTERVAL_S,
        log: Callable[[HidNode, bytes, int, bytes], None] | None = None,
        deflection: DeflectionSettings | None = None,
    ) -> None:
        self._find = find
        self._deflection = deflection or DeflectionSettings()
        self._open = open_link
        self._log = log
        self._lock = threading.Lock()
        self._devices: dict[str, tuple[HidNode, SpaceMouse | Stylus]] = {}
        self._active_mouse: str | None = None  # path of the one whose events are taken
        self._moved_ns = 0  # when it last moved
        # Sent by devices that have gone since:
        self._last_events: list[tuple[str, list[MouseEvent]]] = []
        self._last_readings: list[StylusReading] = []
        self.failures: dict[str, DeviceError] = {}
        self._stop = threading.Event()
        self._thread = None
        self.rescan()
        if interval_s > 0.0:
            self._thread = threading.Thread(
                target=self._watch, args=(interval_s,), name="hot-plug", daemon=True
            )
            self._thread.start()

    def rescan(self) -> Changes:
        """Enumerate once: open new devices and close those that are gone."""
        nodes = self._find()
        with self._lock:
            for path, (_, device) in list(self._devices.items()):
                if device.loop.status.gone is not None:
                    self._retire(path)
            changes = compare_nodes([node for node, _ in self._devices.values()], nodes)
            for node in changes.removed:
                self._retire(node.path)
            for node in changes.added:
                self._try_open(node)
            current = {node.path for node in nodes} | {"enumeration"}
            self.failures = {p: why for p, why in self.failures.items() if p in current}
        return changes

    def nodes(self) -> list[HidNode]:
        """List the open nodes."""
        with self._lock:
            return [node for node, _ in self._devices.values()]

    def mice(self) -> list[SpaceMouse]:
        """List the open 6-DOF mice."""
        return [device for device in self._all() if isinstance(device, SpaceMouse)]

    def styli(self) -> list[Stylus]:
        """List the open styli and pens."""
        return [device for device in self._all() if isinstance(device, Stylus)]

    def set_deflection(self, deflection: DeflectionSettings) -> None:
        """Change the settings of all caps, now and later; each keeps its own rest position."""
        with self._lock:
            self._deflection = deflection
            for _, device in self._devices.values():
                if isinstance(device, SpaceMouse):
                    device.settings = replace(deflection, rest=device.settings.rest)

    def take_mouse(self) -> list[MouseEvent]:
        """Return the events of the active mouse since the last call, by time.

        One mouse may have two nodes (cable and receiver). The one that sends is active until it has
        been at rest for a second and another one moves.
        """
        taken: list[MouseEvent] = []
        with self._lock:
            received, self._last_events = self._last_events, []
            for path, (_, device) in self._devices.items():
                if isinstance(device, SpaceMouse):
                    received.append((path, device.take()))
        for path, events in received:
            for event in events:
                is_moving = bool(event.deflection.any() or event.buttons)
                if is_moving and (
                    self._active_mouse is None or event.time_ns - self._moved_ns > _RESTING_NS
                ):
                    self._active_mouse = path
                if path == self._active_mouse:
                    if is_moving:
                        self._moved_ns = event.time_ns
                    taken.append(event)
        return sorted(taken, key=lambda event: event.time_ns)

    def take_stylus(self) -> list[StylusReading]:
        """Return the readings of all styli since the last call, by time."""
        with self._lock:
            readings, self._last_readings = self._last_readings, []
            for _, device in self._devices.values():
                if isinstance(device, Stylus):
                    readings += device.take()
        return sorted(readings, key=lambda reading: reading.time_ns)

    def stop(self) -> None:
        """Stop enumerating and close all devices."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=2.0)
        with self._lock:
            for _, device in self._devices.values():
                device.stop()
            self._devices.clear()

    def _all(self) -> list[SpaceMouse | Stylus]:
        with self._lock:
            return [device for _, device in self._devices.values()]

    def _watch(self, interval_s: float) -> None:
        while not self._stop.wait(interval_s):
            try:
                self.rescan()
            except DeviceError as cause:
                self.failures["enumeration"] = cause

    def _retire(self, path: str) -> None:
        """Close a device, keeping what it sent before."""
        _, device = self._devices.pop(path)
        device.stop()
        if isinstance(device, SpaceMouse):
            self._last_events.append((path, device.take()))
        else:
            self._last_readings += device.take()

    def _try_open(self, node: HidNode) -> None:
        link = None
        try:
            link = self._open(node)
            log = None if self._log is None else partial(self._log, node, link.descriptor)
            if node.kind == "mouse":
                quirks = find_mouse_quirks(node.vendor, node.product)
                self._devices[node.path] = node, SpaceMouse(link, quirks, self._deflection, log)
            else:
                self._devices[node.path] = node, Stylus(link, log)
            self.failures.pop(node.path, None)
        except DeviceError as failure:
            self.failures[node.path] = failure
            if link is not None:
                link.close()
