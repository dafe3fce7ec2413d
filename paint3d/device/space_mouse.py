"""A 6-DOF mouse at work: events of deflection and of buttons from an open link."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.device.catalogue import MouseQuirks
from paint3d.device.deflection import DeflectionSettings, calibrate_rest, deflection
from paint3d.device.descriptor import parse_descriptor
from paint3d.device.device_loop import DeviceLoop
from paint3d.device.hid_link import Link
from paint3d.device.six_dof import MouseReading, find_mouse_layout

__all__ = ["MouseEvent", "SpaceMouse"]

_KEPT = 64


@dataclass(frozen=True, eq=False, slots=True)
class MouseEvent:
    """What a 6-DOF mouse said at `time_ns`: deflection (6,), -1 to 1, and buttons held."""

    time_ns: int
    deflection: NDArray[np.float64]
    buttons: int


class SpaceMouse:
    """Reads a 6-DOF mouse in a thread; its light is on while it is in use.

    Parameters
    ----------
    link : Link
        Closed by `stop`.
    quirks : MouseQuirks
    settings : DeflectionSettings
    log : callable, optional
        See `DeviceLoop`.

    Raises
    ------
    DeviceError
        If the link's descriptor is no 6-DOF mouse's.
    """

    def __init__(
        self,
        link: Link,
        quirks: MouseQuirks,
        settings: DeflectionSettings | None = None,
        log: Callable[[int, bytes], None] | None = None,
    ) -> None:
        self.layout = find_mouse_layout(parse_descriptor(link.descriptor))
        self.quirks = quirks
        self.settings = settings or DeflectionSettings()
        self.reading = MouseReading()
        self._recent: list[tuple[int, ...]] = []
        self.loop = DeviceLoop(link, self._decode, log, self._at_end)
        self.set_light(True)

    def take(self) -> list[MouseEvent]:
        """All events since the last call; the last one of a device that goes is rest."""
        return self.loop.take()

    def set_light(self, on: bool) -> None:
        """Turn the light on or off, where there is one."""
        self.loop.write(self.layout.encode_light(on))

    def calibrate_rest(self) -> None:
        """Take where the cap stood in the last reports as its rest.

        Raises
        ------
        DeviceError
            If the cap moved, or rests far from zero.
        """
        self.settings = calibrate_rest(
            np.array(self._recent, dtype=np.float64).reshape(-1, 6), self.quirks, self.settings
        )

    def stop(self) -> None:
        """Light off, stop reading, close."""
        self.set_light(False)
        self.loop.stop()

    def _decode(self, time_ns: int, report: bytes) -> Iterator[MouseEvent]:
        self.reading = self.layout.decode(report, self.reading)
        self._recent = [*self._recent[-_KEPT + 1 :], self.reading.axes]
        yield MouseEvent(
            time_ns,
            deflection(self.reading.axes, self.quirks, self.settings),
            self.reading.buttons,
        )

    def _at_end(self, time_ns: int) -> list[MouseEvent]:
        return [MouseEvent(time_ns, np.zeros(6), 0)]
