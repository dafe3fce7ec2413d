"""Stylus without force feedback: readings of a haptic stylus or a pen from an open link."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator

from paint3d.device.descriptor import parse_descriptor
from paint3d.device.device_loop import DeviceLoop
from paint3d.device.digitizer import DigitizerLayout, find_digitizer_layout
from paint3d.device.force.haptic_stylus import decode_pose, encode_force, is_haptic_stylus
from paint3d.device.hid_link import Link
from paint3d.device.report_timing import ReportClock, stamp
from paint3d.device.sample import StylusReading

__all__ = ["Stylus"]

_PERIOD_NS = 1e6  # of a haptic stylus


class Stylus:
    """Reads a haptic stylus or a digitizer in a thread.

    Parameters
    ----------
    link : Link
        Closed by `stop`.
    log : callable, optional
        See `DeviceLoop`.

    Attributes
    ----------
    lost : int
        Reports that never came, if the device numbers them.

    Raises
    ------
    DeviceError
        If the link's descriptor is neither's.
    """

    def __init__(self, link: Link, log: Callable[[int, bytes], None] | None = None) -> None:
        self._clock = ReportClock(_PERIOD_NS)
        self._layout: DigitizerLayout | None = None
        if not is_haptic_stylus(link.descriptor):
            self._layout = find_digitizer_layout(parse_descriptor(link.descriptor))
        self.loop = DeviceLoop(link, self._decode, log)

    @property
    def has_force(self) -> bool:
        """True if the device can push back."""
        return self._layout is None

    @property
    def lost(self) -> int:
        """See the class."""
        return self._clock.lost

    def take(self) -> list[StylusReading]:
        """Return all readings since the last call, oldest first."""
        return self.loop.take()

    def stop(self) -> None:
        """Stop reading and close, with the force of a haptic stylus set to zero."""
        if self.has_force:
            self.loop.write(encode_force((0.0, 0.0, 0.0)))
        self.loop.stop()

    def _decode(self, time_ns: int, report: bytes) -> Iterator[StylusReading]:
        if self._layout is not None:
            reading = self._layout.decode(report, time_ns)
            if reading is not None:
                yield reading
            return
        reading, sequence = decode_pose(report, time_ns)
        at_ns, self._clock = stamp(self._clock, time_ns, sequence)
        yield dataclasses.replace(reading, time_ns=at_ns)
