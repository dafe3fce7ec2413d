"""Stylus without force feedback: readings of a haptic stylus or a pen from an open link.

A report is read some time after it was measured, when the reader was busy, or several at once, when
they queued up. If the device measures at a steady rate and numbers its reports, the time of
measurement can be recovered: report n was measured n periods after the first, and never after it
was read.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from paint3d.device.descriptor import parse_descriptor
from paint3d.device.device_loop import DeviceLoop
from paint3d.device.digitizer import DigitizerLayout, find_digitizer_layout
from paint3d.device.force.haptic_stylus import decode_pose, encode_force, is_haptic_stylus
from paint3d.device.hid_link import Link
from paint3d.device.sample import StylusReading

__all__ = ["ReportClock", "Stylus", "stamp"]

_RELOCK_NS = 50_000_000
_GAIN = 1.0 / 64.0
_WRAP = 1 << 16
_PERIOD_NS = 1e6


@dataclass(frozen=True, slots=True)
class ReportClock:
    """State of the estimate of a device's measurement times.

    Attributes
    ----------
    period_ns : float
        Between two measurements.
    last_ns : int
        Time assigned to the last report; 0 before the first.
    last_sequence : int
    lost : int
        Reports missing by their numbers.
    """

    period_ns: float
    last_ns: int = 0
    last_sequence: int = 0
    lost: int = 0


def stamp(clock: ReportClock, read_ns: int, sequence: int) -> tuple[int, ReportClock]:
    """Estimate when a report was measured; return the time and the updated clock.

    Parameters
    ----------
    clock : ReportClock
    read_ns : int
        When it was read; not earlier than the one before.
    sequence : int
        Its number, modulo 65536.

    Returns
    -------
    (int, ReportClock)
        The time is later than the last one, if possible not later than `read_ns`, and follows the
        steady rate; after a break of 50 ms the clock locks anew.
    """
    steps = (sequence - clock.last_sequence) % _WRAP
    expected = clock.last_ns + steps * clock.period_ns
    fresh = clock.last_ns == 0 or steps == 0 or steps > _WRAP // 2
    if fresh or read_ns - clock.last_ns > _RELOCK_NS + steps * clock.period_ns:
        at = max(read_ns, clock.last_ns + 1)
        return at, ReportClock(clock.period_ns, at, sequence, clock.lost)
    late = read_ns - expected
    at = round(expected + _GAIN * late if late > 0 else read_ns)
    at = max(at, clock.last_ns + 1)
    return at, ReportClock(clock.period_ns, at, sequence, clock.lost + steps - 1)


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
