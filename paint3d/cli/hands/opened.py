"""What a command reads: HID devices, and a stylus that is reached by a library or a service."""

from __future__ import annotations

import sys
from collections.abc import Callable

from paint3d.app.model.persistence.calibrations import kept_calibration
from paint3d.app.model.persistence.settings import load_settings
from paint3d.device.force.force_port import HidForcePort
from paint3d.device.force.port_reader import PortReader
from paint3d.device.hid_nodes import HidNode, list_nodes
from paint3d.device.hot_plug import PluggedDevices
from paint3d.device.sample import StylusReading
from paint3d.errors import DeviceError
from paint3d.haptics.stylus_choice import FoundStylus, find_stylus, key_of_node
from paint3d.pose.calibration import DeviceCalibration
from paint3d.pose.mouse_settings import MouseSettings

__all__ = ["OpenedDevices"]

_NOTHING = "no 6-DOF mouse, stylus or pen tablet is plugged in"
_KINDS = {"auto": ("mouse", "stylus", "pen"), "hid": ("mouse", "stylus")}

Log = Callable[[HidNode, bytes, int, bytes], None]


class OpenedDevices(PluggedDevices):
    """Everything that is there and was chosen, read as the user's settings say.

    Parameters
    ----------
    stylus : str
        See `find_stylus`; "auto" takes HID styli and pens, and others where there is none of them.
    log : callable, optional
        See `PluggedDevices`.

    Attributes
    ----------
    mouse : MouseSettings
        The user's.
    reader : PortReader or None
        Of a stylus that is not read by hidapi.

    Raises
    ------
    DeviceError
        If what was chosen is not there, or nothing is, or nothing could be opened.
    """

    def __init__(self, stylus: str = "auto", log: Log | None = None) -> None:
        settings, problem = load_settings()
        if problem is not None:
            sys.stderr.write(f"{problem}\n")
        self.mouse = MouseSettings.from_words(settings.mouse)
        self.reader: PortReader | None = None
        self._found: FoundStylus | None = None
        kinds = _KINDS.get(stylus, ("mouse",))
        if stylus == "hid":
            find_stylus("hid")
        super().__init__(lambda: list_nodes(kinds), log=log, deflection=self.mouse.deflection())
        try:
            self._read_other(stylus)
        except BaseException:
            self.stop()
            raise
        if not self.names():
            failures = list(self.failures.values())
            self.stop()
            raise DeviceError(failures[0] if failures else _NOTHING)

    def _read_other(self, stylus: str) -> None:
        if stylus in ("hid", "none") or (stylus == "auto" and self.styli()):
            return
        found = find_stylus(stylus)
        if found is not None and not isinstance(found.port, HidForcePort):
            self._found, self.reader = found, PortReader(found.port, found.name)

    def names(self) -> list[str]:
        """Of what is open."""
        others = [] if self.reader is None else [self.reader.name]
        return [node.name for node in self.nodes()] + others

    def take_stylus(self) -> list[StylusReading]:
        """Readings of all styli, in the order of their times."""
        others = [] if self.reader is None else self.reader.take()
        return sorted([*super().take_stylus(), *others], key=lambda reading: reading.time_ns)

    def key(self) -> str:
        """Which stylus or pen it is: the first that is open.

        Raises
        ------
        DeviceError
            If there is none.
        """
        if self._found is not None:
            return self._found.key
        for node in self.nodes():
            if node.kind != "mouse":
                return key_of_node(node)
        raise DeviceError("no stylus or pen tablet is open; expected one for the right hand")

    def calibration(self) -> DeviceCalibration:
        """Where the stylus stands in the world: as it was calibrated, else its own axes."""
        frame = DeviceCalibration() if self._found is None else self._found.frame
        if self._found is None and all(node.kind == "mouse" for node in self.nodes()):
            return frame
        return kept_calibration(self.key()) or frame

    def stop(self) -> None:
        """Stop looking and close everything."""
        if self.reader is not None:
            self.reader.stop()
        super().stop()
