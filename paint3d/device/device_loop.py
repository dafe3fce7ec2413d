"""A thread that reads and decodes one device's reports until it disconnects."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from paint3d.device.hid_link import DeviceGoneError, Link
from paint3d.errors import DeviceError, Message

__all__ = ["DeviceLoop", "DeviceStatus"]

_WAIT_MS = 50
_CAPACITY = 100_000  # events to be taken; the oldest are dropped


@dataclass
class DeviceStatus:
    """Counters and state of a device's stream of reports.

    Attributes
    ----------
    n_reports : int
        Reports decoded.
    n_refused : int
        Reports that could not be decoded; `last_refusal` says why, for the last of them.
    n_dropped : int
        Events that were not taken in time.
    last_report_ns : int
        When the last report was read; 0 before the first.
    longest_gap_ns : int
        Longest time between two reports.
    gone : str or None
        Why the device has disconnected; None while it is there.
    """

    n_reports: int = 0
    n_refused: int = 0
    n_dropped: int = 0
    last_report_ns: int = 0
    longest_gap_ns: int = 0
    last_refusal: str = ""
    gone: Message | None = None


class DeviceLoop:
    """Reads a link in its own thread.

    Parameters
    ----------
    link : Link
    decode : callable
        Turns a time (ns) and a report into events; a `DeviceError` it raises is counted.
    log : callable, optional
        Called with the time and every raw report, before it is decoded.
    at_end : callable, optional
        Called with the time (ns) when the device is gone or closed; returns the last events.
    """

    def __init__(
        self,
        link: Link,
        decode: Callable[[int, bytes], Iterable[object]],
        log: Callable[[int, bytes], None] | None = None,
        at_end: Callable[[int], Iterable[object]] | None = None,
    ) -> None:
        self.link = link
        self.status = DeviceStatus()
        self._decode = decode
        self._log = log
        self._at_end = at_end
        self._events: deque[Any] = deque()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"read {link.name}", daemon=True)
        self._thread.start()

    def take(self) -> list[Any]:
        """Return all events since the last call, oldest first."""
        events = []
        while self._events:
            events.append(self._events.popleft())
        return events

    def write(self, report: bytes | None) -> None:
        """Send an output report; does nothing for None, or if the device is gone."""
        if report is None or self.status.gone is not None:
            return
        try:
            self.link.write(report)
        except DeviceGoneError as cause:
            self.status.gone = cause.message

    def stop(self) -> None:
        """Stop reading and close the device."""
        self._stop.set()
        self._thread.join(timeout=2.0)
        self.link.close()

    def _run(self) -> None:
        try:
            while not self._stop.is_set() and self.status.gone is None:
                for time_ns, report in self.link.read(_WAIT_MS):
                    self._handle(time_ns, report)
        except DeviceGoneError as cause:
            self.status.gone = cause.message
        if self._at_end is not None:
            self._deliver(self._at_end(time.monotonic_ns()))

    def _handle(self, time_ns: int, report: bytes) -> None:
        status = self.status
        if status.last_report_ns:
            gap_ns = time_ns - status.last_report_ns
            status.longest_gap_ns = max(status.longest_gap_ns, gap_ns)
        status.last_report_ns = time_ns
        if self._log is not None:
            self._log(time_ns, report)
        try:
            self._deliver(self._decode(time_ns, report))
            status.n_reports += 1
        except DeviceError as refusal:
            status.n_refused += 1
            status.last_refusal = str(refusal)

    def _deliver(self, events: Iterable[object]) -> None:
        for event in events:
            if len(self._events) >= _CAPACITY:
                self._events.popleft()
                self.status.n_dropped += 1
            self._events.append(event)
