"""Devices that come and go while the program runs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace

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
    """Nodes that came and went between two looks."""

    came: tuple[HidNode, ...]
    went: tuple[HidNode, ...]


def compare_nodes(before: list[HidNode], now: list[HidNode]) -> Changes:
    """What changed; a node that was pulled and put back under the same path did not."""
    old, new = {n.path: n for n in before}, {n.path: n for n in now}
    return Changes(
        tuple(n for p, n in new.items() if old.get(p) != n),
        tuple(n for p, n in old.items() if new.get(p) != n),
    )


class PluggedDevices:
    """Opens every mouse and stylus that is there or comes, once a second, and forgets what goes.

    Parameters
    ----------
    find : callable
        Gives the nodes: `list_nodes`, or a stand-in.
    open_link : callable
        Opens a node: `open_node`, or a stand-in.
    interval_s : float
        Between two looks; 0 looks only when `look` is called.
    log : callable, optional
        Called with the node, its descriptor, the time and every raw report.
    deflection : DeflectionSettings, optional
        How the caps of mice are read.
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
        self._speaking: str | None = None
        self._heard_ns = 0
        self._left_mouse: list[tuple[str, list[MouseEvent]]] = []
        self._left_stylus: list[StylusReading] = []
        self.failures: dict[str, str] = {}
        self._stop = threading.Event()
        self._thread = None
        self.look()
        if interval_s > 0.0:
            self._thread = threading.Thread(
                target=self._watch, args=(interval_s,), name="hot-plug", daemon=True
            )
            self._thread.start()

    def look(self) -> Changes:
        """Look once: open what came, let go what went."""
        nodes = self._find()
        with self._lock:
            for path, (_, device) in list(self._devices.items()):
                if device.loop.status.gone is not None:
                    self._retire(path)
            changes = compare_nodes([node for node, _ in self._devices.values()], nodes)
            for node in changes.went:
                self._retire(node.path)
            for node in changes.came:
                self._try_open(node)
            self.failures = {p: why for p, why in self.failures.items() if p in _paths(nodes)}
        return changes

    def nodes(self) -> list[HidNode]:
        """The nodes that are open."""
        with self._lock:
            return [node for node, _ in self._devices.values()]

    def mice(self) -> list[SpaceMouse]:
        """The 6-DOF mice that are open."""
        return [device for device in self._all() if isinstance(device, SpaceMouse)]

    def styli(self) -> list[Stylus]:
        """The styli and pens that are open."""
        return [device for device in self._all() if isinstance(device, Stylus)]

    def read_caps(self, deflection: DeflectionSettings) -> None:
        """Read the caps of mice that are there or come otherwise; where each rests stays."""
        with self._lock:
            self._deflection = deflection
            for _, device in self._devices.values():
                if isinstance(device, SpaceMouse):
                    device.settings = replace(deflection, rest=device.settings.rest)

    def take_mouse(self) -> list[MouseEvent]:
        """Events of the mouse in use.

        One mouse may show two nodes (cable and receiver): the one that sends is taken, until it
        has been at rest for a second and another one moves.
        """
        taken: list[MouseEvent] = []
        with self._lock:
            heard, self._left_mouse = self._left_mouse, []
            for path, (_, device) in self._devices.items():
                if isinstance(device, SpaceMouse):
                    heard.append((path, device.take()))
        for path, events in heard:
            for event in events:
                moved = bool(event.deflection.any() or event.buttons)
                if moved and (
                    self._speaking is None or event.time_ns - self._heard_ns > _RESTING_NS
                ):
                    self._speaking = path
                if path == self._speaking:
                    if moved:
                        self._heard_ns = event.time_ns
                    taken.append(event)
        return sorted(taken, key=lambda event: event.time_ns)

    def take_stylus(self) -> list[StylusReading]:
        """Readings of all styli, in the order of their times."""
        with self._lock:
            readings, self._left_stylus = self._left_stylus, []
            for _, device in self._devices.values():
                if isinstance(device, Stylus):
                    readings += device.take()
        return sorted(readings, key=lambda reading: reading.time_ns)

    def stop(self) -> None:
        """Stop looking and close everything."""
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
                self.look()
            except DeviceError as cause:
                self.failures["enumeration"] = str(cause)

    def _retire(self, path: str) -> None:
        """Let a device go, but not what it said before."""
        _, device = self._devices.pop(path)
        device.stop()
        if isinstance(device, SpaceMouse):
            self._left_mouse.append((path, device.take()))
        else:
            self._left_stylus += device.take()

    def _try_open(self, node: HidNode) -> None:
        link = None
        try:
            link = self._open(node)
            log = None if self._log is None else _bound(self._log, node, link.descriptor)
            if node.kind == "mouse":
                quirks = find_mouse_quirks(node.vendor, node.product)
                self._devices[node.path] = node, SpaceMouse(link, quirks, self._deflection, log)
            else:
                self._devices[node.path] = node, Stylus(link, log)
            self.failures.pop(node.path, None)
        except DeviceError as failure:
            self.failures[node.path] = str(failure)
            if link is not None:
                link.close()


def _bound(
    log: Callable[[HidNode, bytes, int, bytes], None], node: HidNode, descriptor: bytes
) -> Callable[[int, bytes], None]:
    return lambda time_ns, report: log(node, descriptor, time_ns, report)


def _paths(nodes: list[HidNode]) -> set[str]:
    return {node.path for node in nodes} | {"enumeration"}
