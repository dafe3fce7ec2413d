"""Reading and writing recordings; the format of a file is told by its contents.

JSON Lines is the native form. W3C InkML, tables with named columns (CSV) and plain tables of
``time x y pressure`` are read too. Any of them may be gzipped, whatever its name says.
Files from strangers cannot exhaust the machine: lines are limited to 64 KiB, files to 512 MiB
after decompression (InkML to 64 MiB, since XML is read whole).
"""

from __future__ import annotations

import gzip
import io
import os
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import BinaryIO

from paint3d.core.atomic import write_atomically
from paint3d.device.recorded import Recording
from paint3d.errors import ExportError, RecordingError
from paint3d.recording.flat_recording import MM_PER_PIXEL
from paint3d.recording.read_inkml import read_inkml, write_inkml
from paint3d.recording.read_jsonl import read_jsonl, write_jsonl
from paint3d.recording.read_table import read_csv, read_plain_table, write_csv
from paint3d.recording.text_lines import TextLines

__all__ = ["Recording", "load_recording", "save_recording"]

_GZIP_MAGIC = b"\x1f\x8b"
_MAX_XML_BYTES = 1 << 26
_WRITERS = {
    ".jsonl": write_jsonl,
    ".json": write_jsonl,
    ".inkml": write_inkml,
    ".csv": write_csv,
}


def load_recording(
    path: str | os.PathLike[str],
    *,
    scale: float = MM_PER_PIXEL,
    y_down: bool = True,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Read a recording.

    Parameters
    ----------
    path : path-like
        JSON Lines, InkML, CSV or a plain table, gzipped or not.
    scale : float
        mm per unit of a pad's x and y where the file does not say; 25.4/96 for pixels.
    y_down : bool
        Whether y grows downwards in files of pads that do not say, as on screens.
    progress : callable, optional
        Called with the share of the file that is read, now and then; what it raises stops it.

    Raises
    ------
    RecordingError
        ``file:line: what is X; expected Y`` for anything that is wrong with the file, and when
        it cannot be read at all.
    """
    name = Path(path).name
    try:
        with open(path, "rb") as raw:
            stream = _decompressed(raw)
            start = stream.peek(512)[:512].lstrip(b"\xef\xbb\xbf \t\r\n")
            told = None if progress is None else _share_read(raw, progress)
            return _read(stream, start, name, Path(path), scale, y_down, told)
    except (EOFError, gzip.BadGzipFile, zlib.error) as cause:
        raise RecordingError(f"{name}: the gzip data are damaged or cut short ({cause})") from None
    except OSError as cause:
        reason = cause.strerror or str(cause)
        raise RecordingError(f"{path}: cannot be read: {reason}; expected a recording") from None


def _read(
    stream: BinaryIO,
    start: bytes,
    name: str,
    path: Path,
    scale: float,
    y_down: bool,
    told: Callable[[], None] | None,
) -> Recording:
    if start.startswith(b"<"):
        return read_inkml(_whole(stream, name), name, scale=scale, y_down=y_down)
    lines = TextLines(stream, name, told)
    suffixes = [s.lower() for s in path.suffixes]
    if start.startswith(b"{") or ".jsonl" in suffixes or ".json" in suffixes or not start:
        return read_jsonl(lines, name)
    if ".csv" in suffixes or start.startswith(b"#") or b"," in start.split(b"\n", 1)[0]:
        return read_csv(lines, name, scale=scale, y_down=y_down)
    if start[:1] in b"+-.0123456789":
        return read_plain_table(lines, name, scale=scale, y_down=y_down)
    raise RecordingError(
        f"{name}:1: the file starts with {start[:20]!r}; "
        "expected JSON Lines, InkML, CSV or a table of time, x, y, pressure"
    )


def _decompressed(raw: io.BufferedReader) -> io.BufferedReader:
    if raw.peek(2)[:2] == _GZIP_MAGIC:
        return io.BufferedReader(gzip.GzipFile(fileobj=raw))
    return raw


def _share_read(raw: BinaryIO, progress: Callable[[float], None]) -> Callable[[], None] | None:
    """What tells how much of a file has been read, packed or not; nobody knows of a pipe."""
    if not raw.seekable():
        return None
    size = max(1, os.fstat(raw.fileno()).st_size)
    return lambda: progress(min(1.0, raw.tell() / size))


def _whole(stream: BinaryIO, name: str) -> bytes:
    data = stream.read(_MAX_XML_BYTES + 1)
    if len(data) > _MAX_XML_BYTES:
        raise RecordingError(f"{name}: the InkML is longer than {_MAX_XML_BYTES} bytes")
    return data


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
    """
    target = Path(path)
    zipped = target.suffix.lower() == ".gz"
    suffix = (target.with_suffix("") if zipped else target).suffix.lower()
    if suffix not in _WRITERS:
        raise ExportError(f"{target}: suffix is {suffix!r}; expected {', '.join(_WRITERS)} [.gz]")
    with write_atomically(target, progress) as part, open(part, "wb") as raw:
        _write_lines(_WRITERS[suffix](recording), raw, zipped)


def _write_lines(lines: Iterable[str], raw: BinaryIO, zipped: bool) -> None:
    data = "".join(lines).encode()
    if not zipped:
        raw.write(data)
        return
    with gzip.GzipFile(filename="", mode="wb", fileobj=raw, mtime=0) as packed:
        packed.write(data)
