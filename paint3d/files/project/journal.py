"""A journal of the hands' samples while painting, so that a crash costs a moment at most.

The file is only ever appended to. It starts with ``P3DJ`` and a block with the recording's header
(JSON); then come blocks of samples, and an empty block where the journal was closed. A block is

    kind (1 byte: H, P, N or E), length of its content (uint32), CRC-32 of all its other bytes
    (uint32), content

in little-endian order; a sample takes 156 bytes (`SAMPLE`). Blocks S of older journals have samples
of 132 bytes, which mean no place on the surface. A block N is a note (JSON): what was
asked for between samples, which `read_events` gives back in order; after it, time may start over.
Blocks of other kinds are passed over. Every `append` hands its block to the system at once, which
keeps it if the program is killed, and a thread brings it to the disk within 100 ms, which keeps it
if the power goes.
"""

from __future__ import annotations

import json
import math
import os
import struct
import threading
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.core.machine import APPENDING, flush_file
from paint3d.device.recorded import Recording, checked_header
from paint3d.device.sample import DeviceSample
from paint3d.errors import ExportError, Message, RecordingError, SessionError

__all__ = ["SAMPLE", "Journal", "Loss", "read_events", "read_journal"]

MAGIC = b"P3DJ"
BLOCK = struct.Struct("<cII")
HEADER, SAMPLES, NOTE, END = b"H", b"P", b"N", b"E"
_OLD_SAMPLES = b"S"
_OLD_FIELDS = [
    ("time_ns", "<i8"),
    ("position", "<f8", 3),
    ("orientation", "<f8", 4),
    ("pressure", "<f8"),  # NaN: the device has none
    ("buttons", "<i4"),
    ("object_position", "<f8", 3),
    ("object_orientation", "<f8", 4),
]
_OLD_SAMPLE = np.dtype(_OLD_FIELDS)
SAMPLE = np.dtype([*_OLD_FIELDS, ("contact", "<f8", 3)])  # NaN: the hand means no place
_NOWHERE = (math.nan, math.nan, math.nan)
MAX_BYTES = 1 << 31
SYNC_S = 0.1


@dataclass(frozen=True)
class Loss:
    """Part of a journal that could not be read.

    Attributes
    ----------
    n_bytes : int
        Bytes that could not be used.
    at : int
        Where in the file they start.
    reason : Message or None
        One line for the user; None if nothing is missing.
    """

    n_bytes: int = 0
    at: int = 0
    reason: Message | None = None

    def __bool__(self) -> bool:
        return self.reason is not None


class Journal:
    """Writes samples as they come; use it in a ``with`` statement or close it.

    Parameters
    ----------
    path : path-like
        A file that does not exist yet: the journal of a crash is never written over.
    header : mapping
        Of the recording; see `Recording`.

    Raises
    ------
    ExportError
        If the file exists or cannot be made.
    RecordingError
        If the header cannot be that of a recording.
    """

    def __init__(self, path: str | os.PathLike[str], header: Mapping[str, object]) -> None:
        self.path = Path(path)
        try:
            content = json.dumps(checked_header(header), allow_nan=False).encode("utf-8")
        except (TypeError, ValueError) as cause:
            raise RecordingError(
                "the journal's header cannot be kept: {cause}", cause=cause
            ) from None
        try:
            self._file = os.open(self.path, APPENDING | os.O_CREAT | os.O_EXCL, 0o666)
        except OSError as cause:
            raise ExportError(
                "{file}: cannot start a journal: {cause}", file=path, cause=cause
            ) from None
        self._length = 0
        self._waiting: list[bytes] | None = None  # to be written together
        self._last_ns: int | None = None
        self._has_pressure: bool | None = None
        self._failure: ExportError | None = None
        self._closing = threading.Event()
        self._dirty = threading.Event()
        self._write(MAGIC + _make_block(HEADER, content))
        self._syncing = threading.Thread(target=self._keep_synced, daemon=True)
        self._syncing.start()

    def append(self, samples: Iterable[DeviceSample]) -> None:
        """Write samples; when this returns, a crash of the program cannot lose them.

        Raises
        ------
        RecordingError
            If time does not increase, or some samples have a pressure and others have none.
        ExportError
            If they cannot be written; the journal is then whole up to the samples before.
        """
        rows = [
            (
                s.time_ns, tuple(s.position), tuple(s.orientation),
                math.nan if s.pressure is None else s.pressure,
                s.buttons, tuple(s.object_position), tuple(s.object_orientation),
                _NOWHERE if s.contact is None else tuple(s.contact),
            )
            for s in samples
        ]  # fmt: skip
        if not rows:
            return
        table = np.array(rows, SAMPLE)
        self._check(table)
        self._write(_make_block(SAMPLES, table.tobytes()))
        self._last_ns = int(table["time_ns"][-1])

    def note(self, facts: Mapping[str, object]) -> None:
        """Write a note: a JSON object between samples.

        Raises
        ------
        RecordingError
            If JSON cannot hold it.
        ExportError
            If it cannot be written.
        """
        try:
            content = json.dumps(dict(facts), allow_nan=False).encode("utf-8")
        except (TypeError, ValueError) as cause:
            raise RecordingError(
                "a note cannot be kept in the journal: {cause}", cause=cause
            ) from None
        self._write(_make_block(NOTE, content))
        self._last_ns = self._has_pressure = None

    @contextmanager
    def together(self) -> Iterator[None]:
        """Hand what is written meanwhile to the system as this ends, by one call.

        Each call lets other threads of Python's go first, which may take some milliseconds: one by
        one, what came in a second would take longer than that.

        Raises
        ------
        ExportError
            If it cannot be written; the journal is then whole up to what was written before.
        """
        self._waiting = []
        before = self._last_ns, self._has_pressure
        try:
            yield
        finally:
            waiting, self._waiting = self._waiting, None
            try:
                if waiting:
                    self._write(b"".join(waiting))
            except ExportError:  # a note that is not there lets no time start over
                self._last_ns, self._has_pressure = before
                raise

    def _check(self, table: AnyArray) -> None:
        times, missing = table["time_ns"], np.isnan(table["pressure"])
        before = times[:-1] if self._last_ns is None else np.append(self._last_ns, times[:-1])
        if (times[-len(before) :] <= before).any() and len(before):
            raise RecordingError("a sample for the journal is not later than the one before it")
        if self._has_pressure is None:
            self._has_pressure = not missing[0]
        if (missing == self._has_pressure).any():
            raise RecordingError("pressure is given in some samples; expected it in all or none")

    def _write(self, data: bytes) -> None:
        if self._waiting is not None:
            self._waiting.append(data)
            return
        try:
            view = memoryview(data)
            while len(view):
                view = view[os.write(self._file, view) :]
        except OSError as cause:
            with suppress(OSError):
                os.ftruncate(self._file, self._length)
            raise ExportError(
                "{file}: cannot write: {cause}", file=self.path, cause=cause
            ) from None
        self._length += len(data)
        self._dirty.set()

    def _keep_synced(self) -> None:
        while not self._closing.wait(SYNC_S):
            if self._dirty.is_set():
                self._dirty.clear()
                with suppress(OSError):  # writing will tell
                    flush_file(self._file)
        try:
            self._write(_make_block(END, b""))
            with suppress(OSError):
                flush_file(self._file)
        except ExportError as error:
            self._failure = error
        finally:
            os.close(self._file)

    def close_in_background(self) -> None:
        """Mark the journal as whole, sync and close it in its thread; do not wait for that."""
        self._closing.set()

    def close(self) -> None:
        """Mark the journal as whole, sync it and close it.

        Raises
        ------
        ExportError
            If the mark could not be written; raised once.
        """
        self._closing.set()
        self._syncing.join()
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def read_journal(path: str | os.PathLike[str]) -> tuple[Recording, Loss]:
    """Return a journal's content up to its end or the first damage, and the loss.

    Raises
    ------
    SessionError
        If it is no journal, or not one sample can be read.
    """
    header, pieces, loss = _read_pieces(path)
    return _make_recording(path, header, [p for p in pieces if not isinstance(p, dict)], loss)


def read_events(
    path: str | os.PathLike[str],
) -> tuple[dict[str, object], list[Recording | dict[str, object]], Loss]:
    """Return a journal's header, its samples and notes in order, and the loss.

    Samples between two notes are one recording. All is up to the end or the first damage.

    Raises
    ------
    SessionError
        If it is no journal, or its header is damaged.
    """
    header, pieces, loss = _read_pieces(path)
    events: list[Recording | dict[str, object]] = []
    tables: list[AnyArray] = []
    for piece in pieces:
        if isinstance(piece, dict):
            events += [*_join_tables(path, tables), piece]
            tables = []
        else:
            tables.append(piece)
    return header, events + _join_tables(path, tables), loss


def _read_pieces(
    path: str | os.PathLike[str],
) -> tuple[dict[str, object], list[AnyArray | dict[str, object]], Loss]:
    """Return a journal's header, its tables of samples and its notes in order, and the loss."""
    data = _read_bytes(path)
    header: object = None
    pieces: list[AnyArray | dict[str, object]] = []
    at, closed = len(MAGIC), False
    for kind, content, end in _split_blocks(data):
        if kind == HEADER and header is None:
            header = _parse_json(content)
        elif kind == SAMPLES and not len(content) % SAMPLE.itemsize:
            pieces.append(np.frombuffer(content, SAMPLE))
        elif kind == _OLD_SAMPLES and not len(content) % _OLD_SAMPLE.itemsize:
            pieces.append(_without_contact(np.frombuffer(content, _OLD_SAMPLE)))
        elif kind == NOTE and isinstance(note := _parse_json(content), dict):
            pieces.append(note)
        at, closed = end, kind == END
    if not isinstance(header, dict):
        raise SessionError("{file}: its header is damaged", file=path)
    return header, pieces, _describe_loss(len(data), at, closed)


def _without_contact(table: AnyArray) -> AnyArray:
    """Convert samples of an older journal, which had no contact points."""
    whole = np.empty(len(table), SAMPLE)
    for name in table.dtype.names or ():
        whole[name] = table[name]
    whole["contact"] = np.nan
    return whole


def _join_tables(path: str | os.PathLike[str], tables: list[AnyArray]) -> list[Recording]:
    return [_make_recording(path, {}, tables, Loss())[0]] if tables else []


def _read_bytes(path: str | os.PathLike[str]) -> bytes:
    try:
        size = os.path.getsize(path)
        if size > MAX_BYTES:
            raise SessionError(
                "{file}: it has {size:,} bytes; expected up to {most:,}",
                file=path,
                size=size,
                most=MAX_BYTES,
            )
        data = Path(path).read_bytes()
    except OSError as cause:
        raise SessionError("{file}: cannot read it: {cause}", file=path, cause=cause) from None
    if not data.startswith(MAGIC):
        raise SessionError("{file}: it does not start as a journal does", file=path)
    return data


def _make_block(kind: bytes, content: bytes) -> bytes:
    crc = zlib.crc32(content, zlib.crc32(kind + len(content).to_bytes(4, "little")))
    return BLOCK.pack(kind, len(content), crc) + content


def _split_blocks(data: bytes) -> Iterator[tuple[bytes, bytes, int]]:
    """Yield kind, content and end of all blocks up to the first that is damaged."""
    at = len(MAGIC)
    while at + BLOCK.size <= len(data):
        kind, length, _ = BLOCK.unpack_from(data, at)
        content = data[at + BLOCK.size : at + BLOCK.size + length]
        if _make_block(kind, content) != data[at : at + BLOCK.size + length]:
            return
        at += BLOCK.size + length
        yield kind, content, at
        if kind == END:
            return


def _parse_json(content: bytes) -> object:
    try:
        return json.loads(content)
    except (ValueError, RecursionError):
        return None


def _describe_loss(size: int, at: int, closed: bool) -> Loss:
    if at < size:
        most = (size - at) // SAMPLE.itemsize
        reason = Message(
            "it is damaged at byte {at:,}: {n:,} bytes are lost (up to {most} samples)",
            at=at,
            n=size - at,
            most=most,
        )
        return Loss(size - at, at, reason)
    if not closed:
        return Loss(0, at, Message("it was not closed: what came after the last sample is lost"))
    return Loss()


def _make_recording(
    path: str | os.PathLike[str], header: dict[str, Any], tables: list[AnyArray], loss: Loss
) -> tuple[Recording, Loss]:
    """Return the samples up to the first that no recording could have."""
    table = np.concatenate(tables) if tables else np.empty(0, SAMPLE)
    if not len(table):
        if loss.reason is None:
            raise SessionError("{file}: it holds no samples", file=path)
        raise SessionError("{file}: it holds no samples. {cause}", file=path, cause=loss.reason)
    pressure = None if np.isnan(table["pressure"]).all() else table["pressure"]
    columns = {name: table[name] for name in SAMPLE.names or () if name != "pressure"}
    try:
        return Recording(**columns, pressure=pressure, header=header), loss
    except RecordingError as cause:
        raise SessionError(
            "{file}: its samples are no recording: {cause}", file=path, cause=cause
        ) from None
