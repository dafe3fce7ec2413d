"""The bytes of files from strangers: read, unpacked, decoded, and refused, in one place."""

from __future__ import annotations

import bz2
import codecs
import gzip
import json
import os
import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO
from urllib.parse import unquote

from paint3d.errors import MeshError

if TYPE_CHECKING:
    from xml.etree import ElementTree

__all__ = [
    "json_text",
    "parse_json",
    "parse_xml",
    "path_beside",
    "plain_name",
    "plain_text",
    "read_beside",
    "read_contents",
]

MAX_BYTES = 1 << 30
PIECE = 1 << 24
PACKED = {".gz": gzip.GzipFile, ".bz2": bz2.BZ2File}
MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
SHOWN_ZEROS = 64  # bytes in which every second one is 0 where UTF-16 comes without a mark


def read_contents(path: Path, most: int = MAX_BYTES) -> bytes:
    """Return a file's bytes, unpacked where its suffix is .gz or .bz2.

    Raises
    ------
    MeshError
        If it cannot be read, is empty, or holds more than `most` bytes.
    """
    packing = PACKED.get(path.suffix.lower())
    try:
        with packing(path) if packing else open(path, "rb") as file:
            data = b"".join(_read_pieces(file, most))
    except (OSError, EOFError, zlib.error) as cause:
        raise MeshError("cannot read it: {cause}", cause=cause) from None
    if len(data) > most:
        raise MeshError("it is larger than {most:,} bytes; expected less", most=most)
    if not data:
        raise MeshError("the file is empty")
    return data


def _read_pieces(file: BinaryIO, most: int) -> Iterator[bytes]:
    """Yield a file piece by piece (one big read would take its memory beforehand)."""
    left = most + 1
    while left > 0 and (piece := file.read(min(PIECE, left))):
        left -= len(piece)
        yield piece


def read_beside(folder: Path, name: str, most: int = MAX_BYTES) -> bytes:
    """Return the bytes of a file that another one refers to, in its folder or below.

    Parameters
    ----------
    folder : Path
        Of the file that refers.
    name : str
        A relative path or URI. Links and ``..`` may not lead out of the folder.

    Raises
    ------
    MeshError
        If it lies elsewhere, is missing, or cannot be read.
    """
    shown = repr(name[:80])
    top = os.path.realpath(folder)
    try:
        file = path_beside(top, name)
        inside = os.path.commonpath([top, file]) == top
        there = inside and os.path.isfile(file)
    except ValueError:  # a NUL in the name
        raise MeshError("it refers to {shown}, which is no file name", shown=shown) from None
    if not inside:
        raise MeshError(
            "it refers to {shown} outside its folder, which is not followed",
            shown=shown,
        )
    if not there:
        raise MeshError("it refers to {shown}, which is missing", shown=shown)
    return read_contents(Path(file), most)


def path_beside(folder: str, name: str) -> str:
    """Resolve a relative path or URI from a folder, through links.

    Raises
    ------
    ValueError
        If there is a NUL in it.
    """
    return os.path.realpath(os.path.join(folder, unquote(name).replace("\\", "/")))


def plain_text(data: bytes) -> bytes:
    r"""Return text as one byte per ASCII character with lines ending in ``\n``.

    UTF-16 (with its mark, or told by its zeros) becomes UTF-8; UTF-8, Latin-1 and the like stay
    as they are, since numbers and keywords are ASCII in all of them.

    Raises
    ------
    MeshError
        If the text is not what its mark says.
    """
    marked = next(((mark, name) for mark, name in MARKS if data.startswith(mark)), None)
    mark, encoding = marked or (b"", _guess_encoding(data[:SHOWN_ZEROS]))
    try:
        data = data[len(mark) :]
        if encoding.startswith("utf-16"):
            data = data.decode(encoding).encode("utf-8")
    except UnicodeDecodeError as cause:
        raise MeshError(
            "it is not the {encoding} text it claims to be: {cause}",
            encoding=encoding,
            cause=cause,
        ) from None
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def _guess_encoding(start: bytes) -> str:
    if len(start) >= 8 and not any(start[1::2]) and all(start[::2]):
        return "utf-16-le"
    if len(start) >= 8 and not any(start[::2]) and all(start[1::2]):
        return "utf-16-be"
    return "bytes"


def parse_json(data: bytes) -> dict[str, Any]:
    """Return the object in a JSON text.

    Raises
    ------
    MeshError
        If it is not JSON, or not an object.
    """
    try:
        document = json.loads(data.decode("utf-8-sig"))
    except UnicodeDecodeError as cause:
        raise MeshError(
            "it is no text that glTF could be: its byte {start} is {data}; expected a glTF "
            "document, or a .glb that begins with 'glTF'",
            start=cause.start,
            data=data[cause.start],
        ) from None
    except (ValueError, RecursionError) as cause:
        raise MeshError("its JSON cannot be read: {cause}", cause=cause) from None
    if not isinstance(document, dict):
        raise MeshError("its JSON is not an object; expected a glTF document")
    return document


def parse_xml(data: bytes, name: str) -> ElementTree.Element:
    """Return the root of an XML text.

    Raises
    ------
    MeshError
        If it is not well-formed.
    """
    from xml.etree import ElementTree  # most files hold none

    try:
        return ElementTree.fromstring(data)
    except (ElementTree.ParseError, LookupError, ValueError) as cause:
        raise MeshError("{name} is not well-formed XML: {cause}", name=name, cause=cause) from None


# ---- Names ---------------------------------------------------------------------------------------
# Text from names that may hold anything: half of a UTF-16 pair, control characters, no UTF-8.
#
# A file name is bytes, and Python tells those that are no UTF-8 as lone surrogates; a stranger's
# session may name its material as it likes. Neither fits into most files.


SURROGATE = re.compile("[\ud800-\udfff]")
NOWHERE = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufdd0-\ufdef\ufffe\uffff]")


def plain_name(text: str) -> str:
    """Return a name as every text format can hold it: what none can is marked by U+FFFD.

    Examples
    --------
    >>> plain_name("碗\\x01\\ud800") == "碗\\ufffd\\ufffd"
    True
    """
    return NOWHERE.sub("\ufffd", text)


def json_text(value: object, **options: Any) -> str:
    """Return JSON for people to read; what UTF-8 cannot hold is escaped and comes back the same.

    Parameters
    ----------
    value : object
    **options
        As `json.dumps` takes them.

    Examples
    --------
    >>> print(json_text({"碗": "\\udcff"}))
    {"碗": "\\udcff"}
    """
    text = json.dumps(value, ensure_ascii=False, **options)
    return SURROGATE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)
