"""Logs of raw device reports, and their playback as devices.

JSON Lines, gzipped if the name ends in .gz. The first line names format and version. A device is
described, with its descriptor, before its first report; a report is a line
``[time_ns, device, "report in hex"]``. As reports are raw, later and better decoders can decode a
log again.
"""

from __future__ import annotations

import gzip
import io
import json
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Lock
from typing import IO, Any

from paint3d.core.machine import copy_permissions
from paint3d.device.hid_link import DeviceGoneError
from paint3d.device.hid_nodes import HidNode
from paint3d.errors import DeviceError, Message

__all__ = ["DeviceLog", "PlaybackLink", "read_device_log"]

_FORMAT, _VERSION = "paint3d-device-log", 1
_MAX_LINE = 1 << 16

LogEntry = tuple[int, bytes]


class DeviceLog:
    """Writes reports as they come; thread-safe.

    The log is written to a temporary file beside `path` and moved there by `close`. A symbolic link
    is followed.

    Raises
    ------
    DeviceError
        If it cannot be written.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._path = Path(os.path.realpath(path) if os.path.islink(path) else path)
        self._part = self._path.with_name(self._path.name + ".part")
        self._lock = Lock()
        self._devices: dict[str, int] = {}
        if self._path.exists() and not self._path.is_file():
            what = Message("a folder") if self._path.is_dir() else Message("a pipe or a device")
            raise DeviceError("{file}: it is {what}; expected a file name", file=path, what=what)
        try:
            raw = self._part.open("wb")
        except OSError as cause:
            raise DeviceError(
                "{file}: cannot be written: {cause}", file=path, cause=cause
            ) from None
        is_gz = self._path.suffix == ".gz"
        self._file = gzip.GzipFile(fileobj=raw, mode="wb", mtime=0) if is_gz else raw
        self._raw = raw
        self._write({"format": _FORMAT, "version": _VERSION})

    def append(self, node: HidNode, descriptor: bytes, time_ns: int, report: bytes) -> None:
        """Write one report, preceded by the device's description if it is its first."""
        with self._lock:
            if node.path not in self._devices:
                self._devices[node.path] = len(self._devices)
                self._write(
                    {
                        "device": self._devices[node.path],
                        "kind": node.kind,
                        "name": node.name,
                        "vendor": node.vendor,
                        "product": node.product,
                        "descriptor": descriptor.hex(),
                    }
                )
            self._write([time_ns, self._devices[node.path], report.hex()])

    def discard(self) -> None:
        """Close and delete the log."""
        with self._lock:
            self._file.close()
            self._raw.close()
            self._part.unlink(missing_ok=True)

    def close(self) -> None:
        """Finish the log and move it to its path."""
        with self._lock:
            self._file.close()
            self._raw.close()
            if self._path.exists():
                copy_permissions(self._path, self._part)
            self._part.replace(self._path)

    def _write(self, entry: object) -> None:
        self._file.write(json.dumps(entry, separators=(",", ":")).encode() + b"\n")


class PlaybackLink:
    """A device played back from a log: gives its reports at their times, then disconnects.

    Parameters
    ----------
    node : HidNode
    descriptor : bytes
    entries : list of (int, bytes)
        Times (ns) and reports.
    now_ns : callable
        The clock; `time.monotonic_ns`, or a simulated one.
    """

    def __init__(
        self,
        node: HidNode,
        descriptor: bytes,
        entries: list[LogEntry],
        now_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self.node = node
        self.name = node.name
        self.descriptor = descriptor
        self.entries = entries
        self.sent: list[bytes] = []
        self._now_ns = now_ns
        self._start_ns: int | None = None
        self._next = 0

    def start(self, at_ns: int, first_ns: int) -> None:
        """Play the report of `first_ns` at `at_ns`, the others relative to it."""
        self._start_ns = at_ns - first_ns

    def read(self, timeout_ms: int) -> list[LogEntry]:
        """Return the reports that are due.

        Raises
        ------
        DeviceGoneError
            After the last one.
        """
        if self._next == len(self.entries):
            raise DeviceGoneError("{name}: the recording is over", name=self.name)
        if self._start_ns is None:
            self.start(self._now_ns(), self.entries[0][0])
        start_ns = self._start_ns or 0
        due = self.entries[self._next][0] + start_ns
        wait_s = min(timeout_ms * 1e-3, (due - self._now_ns()) * 1e-9)
        if wait_s > 0.0:
            time.sleep(wait_s)
        now, ready = self._now_ns(), []
        while self._next < len(self.entries):
            time_ns, report = self.entries[self._next]
            if time_ns + start_ns > now:
                break
            ready.append((time_ns + start_ns, report))
            self._next += 1
        return ready

    def write(self, report: bytes) -> None:
        """Record an output report in `sent`."""
        self.sent.append(report)

    def close(self) -> None:
        """Do nothing; there is no device to release."""


def read_device_log(path: str | os.PathLike[str]) -> list[PlaybackLink]:
    """Read the devices of a log, ready to play.

    Raises
    ------
    DeviceError
        ``file:line: what is wrong; what was expected``.
    """
    name = Path(path).name
    links: list[PlaybackLink] = []
    try:
        with open(path, "rb") as raw:
            zipped = raw.peek(2)[:2] == b"\x1f\x8b"
            file: IO[bytes] = io.BufferedReader(gzip.GzipFile(fileobj=raw)) if zipped else raw
            for number, line in _lines(file):
                try:
                    _parse_entry(json.loads(line), number, links)
                except (ValueError, KeyError, TypeError, IndexError) as cause:
                    raise DeviceError(
                        "{name}:{number}: {cause}",
                        name=name,
                        number=number,
                        cause=cause,
                    ) from None
    except (OSError, EOFError) as cause:
        raise DeviceError(
            "{file}: no device log can be read ({cause})", file=path, cause=cause
        ) from None
    if not links:
        raise DeviceError("{name}: no device in the log; expected at least one", name=name)
    return links


def _lines(file: IO[bytes]) -> Iterator[tuple[int, bytes]]:
    """Yield numbered lines, of bounded length."""
    number = 0
    while line := file.readline(_MAX_LINE + 1):
        number += 1
        if len(line) > _MAX_LINE:
            raise EOFError(f"line {number} is longer than {_MAX_LINE} bytes")
        yield number, line


def _parse_entry(entry: Any, number: int, links: list[PlaybackLink]) -> None:
    """Check the header, add a device to `links`, or add a report to its device."""
    if number == 1:
        if not isinstance(entry, dict) or entry.get("format") != _FORMAT:
            raise ValueError(f"expected format {_FORMAT!r} in the first line")
        if entry.get("version") != _VERSION:
            raise ValueError(f"version is {entry.get('version')!r}; expected {_VERSION}")
    elif isinstance(entry, dict):
        kind, vendor, product = str(entry["kind"]), int(entry["vendor"]), int(entry["product"])
        path = f"log:{len(links)}"
        node = HidNode(path, "log", vendor, product, str(entry["name"]), "", 0, 0, kind)
        links.append(PlaybackLink(node, bytes.fromhex(entry["descriptor"]), []))
    else:
        time_ns, device, report = entry
        if not 0 <= device < len(links):
            raise ValueError(f"device {device!r} was not described before")
        entries = links[device].entries
        if not isinstance(time_ns, int) or (entries and time_ns < entries[-1][0]):
            raise ValueError(f"time {time_ns!r}; expected an integer, not before the last one")
        entries.append((time_ns, bytes.fromhex(report)))
