"""Reading and writing recordings; the format of a file is recognized by its contents.

W3C InkML, tables with named columns (CSV) and plain tables of ``time x y pressure`` are read, and
the native form, JSON Lines: a header, then one sample a line. Any of them may be gzipped, whatever
its name says. Files from strangers cannot exhaust the machine: lines are limited to 64 KiB, files
to 512 MiB after decompression (InkML to 64 MiB, since XML is read whole).

A sample in JSON is ``{"time_ns": .., "position": [x, y, z], "orientation": [w, x, y, z],
"pressure": .., "buttons": .., "contact": [x, y, z],
"object": {"position": [..], "orientation": [..]}}``.
``force`` (N) may stand for ``pressure``; the brush may be nested under ``right`` or
``right_hand`` and the object is also found under ``left`` or ``left_hand``. The object's pose
holds until it changes. Keys that are not known are passed over, unless they look like a slip
of the pen.
"""

from __future__ import annotations

import difflib
import gzip
import io
import json
import logging
import math
import os
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.core.atomic import write_atomically
from paint3d.device.recorded import FORMAT, MAX_FORCE_N, UNIT_TOLERANCE, Recording, checked_header
from paint3d.errors import ExportError, RecordingError
from paint3d.recording.flat_recording import MM_PER_PIXEL, notes_of
from paint3d.recording.table import read_csv, read_plain_table, write_csv
from paint3d.recording.units import TO_MM, units_of

__all__ = [
    "AT_REST",
    "MAX_LINE",
    "HandTime",
    "Recording",
    "SampleRows",
    "TextLines",
    "decode_line",
    "fraction_reporter",
    "load_recording",
    "open_recording",
    "sample_lines",
    "save_lines",
    "save_recording",
    "write_jsonl",
]

_LOG = logging.getLogger("paint3d")
_GZIP_MAGIC = b"\x1f\x8b"
_MAX_XML_BYTES = 1 << 26
_RIGHT = ("right", "right_hand")
_LEFT = ("object", "left", "left_hand")
_KEYS = {
    "time_ns", "position", "orientation", "pressure", "force", "buttons", "contact",
    *_RIGHT, *_LEFT,
}  # fmt: skip
_NOWHERE = [math.nan, math.nan, math.nan]
_LARGEST = 1e9
"""Positions further out than this (a thousand km) are taken for damage."""
MAX_LINE = 1 << 16
_MAX_BYTES = 1 << 29
_BLOCK = 1 << 21  # bytes
_REPORT_EVERY = 1 << 14  # lines
AT_REST = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
"""Position and orientation of an object that never moved."""
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"  # that some programs put before UTF-8


def load_recording(
    path: str | os.PathLike[str],
    *,
    scale: float = MM_PER_PIXEL,
    y_down: bool = True,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Read a recording; what was assumed or put right is logged, and in the header's ``notes``.

    Parameters
    ----------
    path : path-like
        JSON Lines, InkML, CSV or a plain table, gzipped or not.
    scale : float
        mm per unit of a pad's x and y where the file does not say; 25.4/96 for pixels.
    y_down : bool
        Whether y grows downwards in files of pads that do not say, as on screens.
    progress : callable, optional
        Called with the fraction of the file that is read, now and then; what it raises stops it.

    Raises
    ------
    RecordingError
        ``file:line: what is X; expected Y`` for anything that is wrong with the file, and when
        it cannot be read at all.
    """
    file = Path(path)
    name = file.name
    with open_recording(path) as (raw, stream):
        start = stream.peek(512)[:512].lstrip(b"\xef\xbb\xbf \t\r\n")
        on_read = None if progress is None else fraction_reporter(raw, progress)
        if start.startswith(b"<"):
            from paint3d.recording.inkml import read_inkml  # XML, which few recordings are in

            data = stream.read(_MAX_XML_BYTES + 1)
            if len(data) > _MAX_XML_BYTES:
                raise RecordingError(
                    "{name}: the InkML is longer than {most} bytes",
                    name=name,
                    most=_MAX_XML_BYTES,
                )
            recording = read_inkml(data, name, scale=scale, y_down=y_down)
        else:
            lines = TextLines(stream, name, on_read)
            suffixes = [s.lower() for s in file.suffixes]
            if start.startswith(b"{") or ".jsonl" in suffixes or ".json" in suffixes or not start:
                recording = _read_jsonl(lines, name)
            elif ".csv" in suffixes or start.startswith(b"#") or b"," in start.split(b"\n", 1)[0]:
                recording = read_csv(lines, name, scale=scale, y_down=y_down)
            elif start[:1] in b"+-.0123456789":
                recording = read_plain_table(lines, name, scale=scale, y_down=y_down)
            else:
                raise RecordingError(
                    "{name}:1: the file starts with {start!r}; expected JSON Lines, InkML, CSV or "
                    "a table of time, x, y, pressure",
                    name=name,
                    start=start[:20],
                )
    for note in notes_of(recording.header):
        _LOG.warning("%s: %s", path, note)
    return recording


@contextmanager
def open_recording(path: str | os.PathLike[str]) -> Iterator[tuple[BinaryIO, io.BufferedReader]]:
    """Open a recording's file: the raw file, and its bytes when they are unpacked.

    Raises
    ------
    RecordingError
        If it cannot be read, or its packing is damaged.
    """
    try:
        with open(path, "rb") as raw:
            is_zipped = raw.peek(2)[:2] == _GZIP_MAGIC
            yield raw, io.BufferedReader(gzip.GzipFile(fileobj=raw)) if is_zipped else raw
    except (EOFError, gzip.BadGzipFile, zlib.error) as cause:
        name = Path(path).name
        raise RecordingError(
            "{name}: the gzip data are damaged or cut short ({cause})",
            name=name,
            cause=cause,
        ) from None
    except OSError as cause:
        raise RecordingError(
            "{file}: cannot be read: {cause}; expected a recording",
            file=path,
            cause=cause,
        ) from None


def fraction_reporter(
    raw: BinaryIO, progress: Callable[[float], None]
) -> Callable[[], None] | None:
    """Return a function that reports the fraction of a file read so far; None of a pipe."""
    if not raw.seekable():
        return None
    size = max(1, os.fstat(raw.fileno()).st_size)
    return lambda: progress(min(1.0, raw.tell() / size))


class TextLines:
    """Iterate over (number from 1, text) of the lines that were not returned in a block yet.

    Parameters
    ----------
    stream : binary file
    name : str
        Of the file, for messages.
    on_read : callable, optional
        Called now and then while lines are read.

    Raises
    ------
    RecordingError
        When iterated over: ``name:line: what is wrong``.
    """

    def __init__(
        self, stream: BinaryIO, name: str, on_read: Callable[[], None] | None = None
    ) -> None:
        self._stream, self._name, self._on_read = stream, name, on_read
        self._number = self._n_bytes = 0

    def __iter__(self) -> Iterator[tuple[int, str]]:
        return self

    def __next__(self) -> tuple[int, str]:
        line = self._stream.readline(MAX_LINE + 1)
        if not line:
            raise StopIteration
        self._number += 1
        if self._on_read is not None and self._number % _REPORT_EVERY == 0:
            self._on_read()
        self._n_bytes += len(line)
        return self._number, self._decode(line, self._number, self._n_bytes)

    def read_block(self) -> tuple[int, bytes]:
        """The number of the next line, and some 2 MiB of whole lines; none at the end.

        What is in them is not looked at: `cut` does that.

        Raises
        ------
        RecordingError
            If the file is too long.
        """
        if self._on_read is not None:
            self._on_read()
        data = self._stream.read(_BLOCK)
        if data and not data.endswith(b"\n"):
            data += self._stream.readline(MAX_LINE + 1)
        first = self._number + 1
        if self._n_bytes + len(data) > _MAX_BYTES:
            for _ in self.split_block(
                first, data
            ):  # some line is one too many, or wrong before that
                pass
        self._number += data.count(b"\n") + (not data.endswith(b"\n"))
        self._n_bytes += len(data)
        return first, data.removeprefix(_BYTE_ORDER_MARK) if first == 1 else data

    def split_block(self, first: int, data: bytes) -> Iterator[tuple[int, str]]:
        """Yield numbers and texts of the lines in a block whose first has the number `first`.

        Raises
        ------
        RecordingError
            ``name:line: what is wrong``.
        """
        n_bytes = 0 if first <= self._number else self._n_bytes  # those of blocks before are known
        lines = io.BytesIO(data)
        for number, line in enumerate(iter(lambda: lines.readline(MAX_LINE + 1), b""), first):
            n_bytes += len(line)
            yield number, self._decode(line, number, n_bytes)

    def _decode(self, line: bytes, number: int, n_bytes: int) -> str:
        """Text of a line, which with all before it has `n_bytes`."""
        if len(line) > MAX_LINE:
            raise RecordingError(
                "{name}:{number}: the line is longer than {most} bytes",
                name=self._name,
                number=number,
                most=MAX_LINE,
            )
        if n_bytes > _MAX_BYTES:
            raise RecordingError(
                "{name}:{number}: the file is longer than {most} bytes once decompressed",
                name=self._name,
                number=number,
                most=_MAX_BYTES,
            )
        try:
            return line.decode("utf-8-sig" if number == 1 else "utf-8")
        except UnicodeDecodeError as cause:
            raise RecordingError(
                "{name}:{number}: byte {start} is not UTF-8; expected UTF-8 text",
                name=self._name,
                number=number,
                start=cause.start,
            ) from None


def _read_jsonl(lines: Iterator[tuple[int, str]], name: str) -> Recording:
    """Read the recording in numbered lines of text.

    Parameters
    ----------
    lines : iterator of (int, str)
        Line numbers from 1, and the lines.
    name : str
        The file's name, for messages.

    Raises
    ------
    RecordingError
        ``name:line: what is X; expected Y``, for the first thing that is wrong.
    """
    numbered = ((number, text) for number, text in lines if text.strip())
    first = next(numbered, None)
    if first is None:
        raise RecordingError("{name}:1: the file is empty; expected a header line", name=name)
    try:
        header = decode_line(first[1])
        for key in ("format", "version"):
            if key not in header:
                raise RecordingError(
                    "the header has no {key!r}; expected {key!r} of {expected!r}",
                    key=key,
                    expected=FORMAT,
                )
        units = {"position": "mm", "time": "ns", "force": "N", **units_of(header)}
        header = {**header, "units": units}
        if header["version"] == 2:
            raise RecordingError(
                "version is 2; expected 1, a recording of samples: this is a whole painting, which "
                "load_score reads"
            )
        header = checked_header(header)
        scale = TO_MM[header["units"]["position"]]
    except RecordingError as cause:
        raise RecordingError(
            "{name}:{first}: {cause}", name=name, first=first[0], cause=cause
        ) from None
    header["units"] = {**header["units"], "position": "mm"}
    rows = SampleRows(scale)
    for number, text in numbered:
        try:
            rows.add(decode_line(text))
        except RecordingError as cause:
            raise RecordingError(
                "{name}:{number}: {cause}", name=name, number=number, cause=cause
            ) from None
    if not rows.times:
        raise RecordingError(
            "{name}:{first}: there are no samples; expected at least one",
            name=name,
            first=first[0] + 1,
        )
    return rows.recording(header)


def _refuse_constant(word: str) -> float:
    raise RecordingError("a number is {word}; expected finite numbers", word=word)


_DECODER = json.JSONDecoder(parse_constant=_refuse_constant)


def decode_line(text: str) -> dict[str, Any]:
    """The object that a line holds.

    Raises
    ------
    RecordingError
        If it is no JSON object, or a number in it is not finite.
    """
    try:
        value = _DECODER.decode(text)
    except RecordingError:
        raise
    except (ValueError, RecursionError) as cause:
        raise RecordingError(
            "the line is not JSON ({cause}); expected one object", cause=cause
        ) from None
    if type(value) is not dict:
        raise RecordingError(
            "the line is a JSON {kind}; expected an object",
            kind=type(value).__name__,
        )
    return value


class SampleRows:
    """Collect samples for arrays; every check is made while the line is known.

    Parameters
    ----------
    scale : float
        mm per unit of length.
    object_pose : sequence of 7 floats
        Position (in the lines' unit) and orientation of the object as the lines before say it.
    """

    def __init__(self, scale: float, object_pose: Sequence[float] = AT_REST) -> None:
        self.scale = scale
        self.times: list[int] = []
        self.positions: list[list[float]] = []
        self.orientations: list[list[float]] = []
        self.pressures: list[float | None] = []
        self.buttons: list[int] = []
        self.object_positions: list[list[float]] = []
        self.object_orientations: list[list[float]] = []
        self.contacts: list[list[float]] = []
        self.object = (list(object_pose[:3]), list(object_pose[3:]))
        self.accepted = set(_KEYS)

    def add(self, sample: dict[str, Any]) -> None:
        """Add a line.

        Raises
        ------
        RecordingError
            If it is no sample, or cannot follow those before it.
        """
        if not self.accepted.issuperset(sample):
            self._accept_keys(sample)
        right = _optional_object(sample, _RIGHT) or sample
        if right is not sample and not self.accepted.issuperset(right):
            self._accept_keys(right)
        time_ns = _read_integer(
            sample if "time_ns" in sample else right, "time_ns", -(2**62), 2**62
        )
        if self.times and time_ns <= self.times[-1]:
            raise RecordingError(
                "time_ns is {time_ns}; expected more than {times}, the sample before it",
                time_ns=time_ns,
                times=self.times[-1],
            )
        position = _read_vector(right, "position", 3, _LARGEST)
        orientation = _read_quaternion(right)
        pressure = _read_pressure(right)
        contact = _NOWHERE
        if right.get("contact") is not None:
            contact = _read_vector(right, "contact", 3, _LARGEST)
            if pressure is None:
                raise RecordingError("contact is given without a pressure; expected both")
        if self.times and (pressure is None) != (self.pressures[0] is None):
            raise RecordingError(
                "pressure is given, or not, unlike in the first sample; expected it in all samples "
                "or in none"
            )
        button_owner = right if "buttons" in right else sample
        buttons = (
            _read_integer(button_owner, "buttons", 0, 2**31 - 1) if "buttons" in button_owner else 0
        )
        left = _optional_object(sample, _LEFT)
        if left is not None:
            self.object = (_read_vector(left, "position", 3, _LARGEST), _read_quaternion(left))
        self.times.append(time_ns)
        self.positions.append(position)
        self.orientations.append(orientation)
        self.pressures.append(pressure)
        self.buttons.append(buttons)
        self.contacts.append(contact)
        self.object_positions.append(self.object[0])
        self.object_orientations.append(self.object[1])

    def _accept_keys(self, keys: dict[str, Any]) -> None:
        """Ignore unknown keys from now on, unless one looks like a typing error."""
        for key in keys:
            near = difflib.get_close_matches(key, _KEYS, n=1, cutoff=0.8)
            if key not in self.accepted and near:
                raise RecordingError("a key is {key!r}; expected {first!r}", key=key, first=near[0])
            self.accepted.add(key)

    def recording(self, header: dict[str, Any]) -> Recording:
        """Recording of all samples; at least one was added."""
        with_pressure = self.pressures[0] is not None
        return Recording(
            np.array(self.times, dtype=np.int64),
            np.array(self.positions, dtype=np.float64) * self.scale,
            np.array(self.orientations, dtype=np.float64),
            np.array(self.pressures, dtype=np.float64) if with_pressure else None,
            np.array(self.buttons, dtype=np.int32),
            np.array(self.object_positions, dtype=np.float64) * self.scale,
            np.array(self.object_orientations, dtype=np.float64),
            header,
            np.array(self.contacts, dtype=np.float64) * self.scale,
        )


def _optional_object(sample: dict[str, Any], names: tuple[str, ...]) -> dict[str, Any] | None:
    for name in names:
        value = sample.get(name)
        if value is not None:
            if type(value) is not dict:
                raise RecordingError(
                    "{name} is {value!r:.60}; expected an object",
                    name=name,
                    value=value,
                )
            return value
    return None


def _read_vector(owner: dict[str, Any], key: str, n: int, largest: float) -> list[float]:
    value = owner.get(key)
    if type(value) is not list or len(value) != n:
        got = "missing" if key not in owner else f"{value!r:.60}"
        raise RecordingError("{key} is {got}; expected {n} numbers", key=key, got=got, n=n)
    for number in value:
        kind = type(number)
        if (kind is not float and kind is not int) or not -largest <= number <= largest:
            raise RecordingError(
                "{key} holds {number!r:.60}; expected numbers from {low:g} to {high:g}",
                key=key,
                number=number,
                low=-largest,
                high=largest,
            )
    return value


def _read_quaternion(owner: dict[str, Any]) -> list[float]:
    w, x, y, z = value = _read_vector(owner, "orientation", 4, 2.0)
    length = (w * w + x * x + y * y + z * z) ** 0.5
    if abs(length - 1.0) > UNIT_TOLERANCE:
        raise RecordingError(
            "orientation has length {length:.6g}; expected 1 within {unit_tolerance:g}",
            length=length,
            unit_tolerance=UNIT_TOLERANCE,
        )
    return value


def _read_pressure(owner: dict[str, Any]) -> float | None:
    for key, most in (("pressure", 1.0), ("force", MAX_FORCE_N)):
        value = owner.get(key)
        if value is None:
            continue
        kind = type(value)
        if (kind is not float and kind is not int) or not 0 <= value <= most:
            unit = " N" if key == "force" else ""
            raise RecordingError(
                "{key} is {value!r:.60}; expected 0 to {most:g}{unit}",
                key=key,
                value=value,
                most=most,
                unit=unit,
            )
        return float(value / most)
    return None


def _read_integer(owner: dict[str, Any], key: str, least: int, most: int) -> int:
    value = owner.get(key)
    if type(value) is not int or not least <= value <= most:
        got = "missing" if key not in owner else f"{value!r:.60}"
        raise RecordingError(
            "{key} is {got}; expected an integer from {least} to {most}",
            key=key,
            got=got,
            least=least,
            most=most,
        )
    return value


def write_jsonl(recording: Recording) -> Iterator[str]:
    """The lines of a recording, each ending in a newline; numbers read back exactly."""
    yield json.dumps(dict(recording.header), separators=(",", ":"), allow_nan=False) + "\n"
    yield from sample_lines(recording)


def sample_lines(recording: Recording, object_pose: AnyArray | None = None) -> Iterator[str]:
    """Yield the lines of a recording's samples.

    Parameters
    ----------
    recording : Recording
    object_pose : (7,) float64, optional
        Position and orientation of the object as the lines before say it: it is said again where it
        is another one, and then written here. By default it is where it was before it moved.
    """
    poses = np.hstack([recording.object_position, recording.object_orientation])
    previous = np.array(AT_REST) if object_pose is None else object_pose
    pressures = recording.pressure
    for i in range(len(recording)):
        parts = [
            f'{{"time_ns":{recording.time_ns[i]}',
            f'"position":{_format_numbers(recording.position[i])}',
            f'"orientation":{_format_numbers(recording.orientation[i])}',
        ]
        if pressures is not None:
            parts.append(f'"pressure":{_format_numbers(pressures[i : i + 1])[1:-1]}')
        parts.append(f'"buttons":{recording.buttons[i]}')
        if recording.contact is not None and not np.isnan(recording.contact[i, 0]):
            parts.append(f'"contact":{_format_numbers(recording.contact[i])}')
        if (poses[i] != previous).any():
            previous[:] = poses[i]
            parts.append(
                f'"object":{{"position":{_format_numbers(previous[:3])},'
                f'"orientation":{_format_numbers(previous[3:])}}}'
            )
        yield ",".join(parts) + "}\n"


def _format_numbers(numbers: AnyArray) -> str:
    words = (repr(number) for number in numbers.tolist())
    return (
        "["
        + ",".join(word[:-2] if word.endswith(".0") and word != "-0.0" else word for word in words)
        + "]"
    )


def _inkml(recording: Recording) -> Iterator[str]:
    from paint3d.recording.inkml import write_inkml

    return write_inkml(recording)


_WRITERS = {
    ".jsonl": write_jsonl,
    ".json": write_jsonl,
    ".inkml": _inkml,
    ".csv": write_csv,
}


def save_recording(
    recording: Recording,
    path: str | os.PathLike[str],
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write a recording: .jsonl, .csv or .inkml, each also with .gz.

    The file appears whole or not at all, and the same recording gives the same bytes. JSON
    Lines and CSV keep every number exactly; InkML keeps pad recordings (see `write_inkml`).

    Parameters
    ----------
    recording : Recording
    path : path-like
        Where it is a symbolic link, the file behind it is replaced.
    progress : callable, optional
        Called with 1 when all is written, before the file takes its place; what it raises leaves
        everything as it was.

    Raises
    ------
    ExportError
        If the suffix is not known or the file cannot be written.
    RecordingError
        If the recording has no place in the format.

    Examples
    --------
    >>> import paint3d
    >>> surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=1.0)
    >>> line = paint3d.Painter(surface).stroke([(-20, 0, 0), (20, 0, 0)], speed=40.0)
    >>> paint3d.save_recording(line, "line.csv")
    >>> round(paint3d.load_recording("line.csv").duration_s, 2)
    1.0
    """
    writers = {suffix: partial(write, recording) for suffix, write in _WRITERS.items()}
    save_lines(writers, path, progress)


def save_lines(
    writers: Mapping[str, Callable[[], Iterable[str]]],
    path: str | os.PathLike[str],
    progress: Callable[[float], None] | None,
) -> None:
    """Write a file of lines by its suffix, also with .gz; see `save_recording`."""
    target = Path(path)
    zipped = target.suffix.lower() == ".gz"
    suffix = (target.with_suffix("") if zipped else target).suffix.lower()
    if suffix not in writers:
        raise ExportError(
            "{target}: suffix is {suffix!r}; expected {writers} [.gz]",
            target=target,
            suffix=suffix,
            writers=", ".join(writers),
        )
    with write_atomically(target, progress) as part, open(part, "wb") as raw:
        data = "".join(writers[suffix]()).encode()
        if not zipped:
            raw.write(data)
            return
        # without a name and a time the same lines give the same bytes
        with gzip.GzipFile(filename="", mode="wb", fileobj=raw, mtime=0) as packed:
            packed.write(data)


# ---- Without long rests --------------------------------------------------------------------------
# The time of the hand in a recording, as it is shown again: without long rests.


_LONGEST_REST_S = 1.0
_BETWEEN_S = 0.3  # between two strokes whose clocks have nothing to do with each other


class HandTime:
    """Counts the time that a film or a playback takes at the hand's own speed.

    Between two samples as much time passes as between them did, but at most `_LONGEST_REST_S`,
    since nothing is to be seen then; where ink spreads meanwhile, that counts in full.

    Parameters
    ----------
    in_full : bool
        Count every rest in full.

    Attributes
    ----------
    seconds : float
        Since the beginning.
    """

    def __init__(self, in_full: bool = False) -> None:
        self.seconds = 0.0
        self._in_full = in_full
        self._last_ns: int | None = None
        self._ink_s = 0.0

    def pass_samples(self, time_ns: NDArray[np.int64]) -> NDArray[np.float64]:
        """Count samples, (N,) ns, that follow those before; return when each is, (N,) s."""
        if not len(time_ns):
            return np.zeros(0)
        gaps = np.diff(time_ns, prepend=time_ns[:1]) * 1e-9
        if self._last_ns is not None:
            since = (int(time_ns[0]) - self._last_ns) * 1e-9
            gaps[0] = max(0.0, (since if since >= 0.0 else _BETWEEN_S) - self._ink_s)
        if not self._in_full:
            gaps = np.minimum(gaps, _LONGEST_REST_S)
        when = self.seconds + np.cumsum(gaps)
        self._last_ns, self._ink_s = int(time_ns[-1]), 0.0
        self.seconds = float(when[-1])
        return when

    def pass_ink(self, seconds: float) -> None:
        """Count time in which ink spreads and dries."""
        self._ink_s += seconds
        self.seconds += seconds
