"""The tables of a PLY file: ASCII and binary of both byte orders, any types, any line ends."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, cast

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError
from paint3d.files.readers.raw_mesh import check_count, parse_numbers

__all__ = ["Element", "Property", "Tables", "read_tables"]

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
KEYWORDS = ("format", "element", "property", "comment", "obj_info")
MAX_HEADER = 1 << 20
Order = Literal["<", ">"]


@dataclass
class Property:
    """A column: a scalar, or a list with its own count type."""

    name: str
    dtype: np.dtype
    count_dtype: np.dtype | None = None


@dataclass
class Element:
    """A table of the file: name, rows, columns, and the columns' values once read."""

    name: str
    count: int
    properties: list[Property] = field(default_factory=list)
    values: dict[str, AnyArray] = field(default_factory=dict)
    list_sizes: dict[str, AnyArray] = field(default_factory=dict)

    @property
    def least_bytes(self) -> int:
        """Size of the shortest possible binary row."""
        return sum(
            (p.dtype if p.count_dtype is None else p.count_dtype).itemsize for p in self.properties
        )


class Tables(NamedTuple):
    """What a PLY file holds.

    Attributes
    ----------
    elements : tuple of Element
        In the file's order; those after the last one wanted are without values.
    comments : tuple of str
        Without the word that begins them.
    unknown : tuple of str
        Lines of the header that say nothing that PLY knows.
    """

    elements: tuple[Element, ...]
    comments: tuple[str, ...]
    unknown: tuple[str, ...]


def read_tables(data: bytes, wanted: Collection[str]) -> Tables:
    """Read the elements of a PLY file as far as the last one whose name is wanted.

    Raises
    ------
    MeshError
        If the header is not PLY's, or the body does not hold what the header promises.
    """
    lines, body = _header_lines(data)
    try:
        order, tables = _parse_header(lines)
    except (IndexError, KeyError, ValueError) as cause:
        if isinstance(cause, MeshError):
            raise
        raise MeshError(f"the header cannot be understood near {cause}") from None
    elements = tables.elements
    last = max((k for k, e in enumerate(elements) if e.name in wanted), default=-1)
    if order == "":
        _read_ascii(elements[: last + 1], data[body:])
    else:
        _read_binary(elements[: last + 1], data, body)
    return tables


def _header_lines(data: bytes) -> tuple[list[str], int]:
    """Return the lines between the first and the last, and where the body begins."""
    if data[:3] != b"ply":
        raise MeshError("it does not start with 'ply'; expected a PLY file")
    end = data.find(b"end_header", 0, MAX_HEADER)
    if end < 0:
        raise MeshError("the header has no end; expected a line end_header")
    lone_return = data[3:4] == b"\r" and data[4:5] != b"\n"
    body = end + len(b"end_header")
    while data[body : body + 1] in (b" ", b"\t"):
        body += 1
    body += 2 if data[body : body + 2] == b"\r\n" and not lone_return else 1
    return data[:end].decode("latin-1").splitlines()[1:], body


def _parse_header(lines: list[str]) -> tuple[str, Tables]:
    """Return the byte order, "" for ASCII, and the tables, still empty.

    Lines that are unknown are passed over before the first element, where some programs write
    comments without saying so; after it, what follows in the file could be misread.
    """
    order, elements, comments, unknown = None, [], [], []
    for line in lines:
        words = line.split()
        if not words or words[0] == "obj_info":
            continue
        if words[0] == "comment":
            comments.append(line.strip()[len("comment") :].strip())
        elif words[0] == "format":
            order = FORMATS[words[1]]
        elif words[0] == "element":
            elements.append(Element(words[1], int(words[2])))
        elif words[0] == "property" and elements:
            elements[-1].properties.append(_property(words, order or "<"))
        elif elements or difflib.get_close_matches(words[0].lower(), KEYWORDS, 1, 0.7):
            raise MeshError(f"the header has an unknown line {' '.join(words)[:40]!r}")
        else:
            unknown.append(" ".join(words))
    if order is None:
        raise MeshError("the header has no format line")
    return order, Tables(tuple(elements), tuple(comments), tuple(unknown))


def _property(words: list[str], order: str) -> Property:
    if words[1] == "list":
        count, item = (np.dtype(TYPES[w]).newbyteorder(cast("Order", order)) for w in words[2:4])
        return Property(words[4], item, count)
    return Property(words[2], np.dtype(TYPES[words[1]]).newbyteorder(cast("Order", order)))


def _read_binary(elements: Sequence[Element], data: bytes, at: int) -> None:
    for element in elements:
        if not element.properties:
            continue
        check_count(element.count, element.least_bytes, len(data) - at, f"of {element.name}")
        at = _binary_rows(element, data, at)


def _binary_rows(element: Element, data: bytes, at: int) -> int:
    """Read one element's rows from `at`; return where they end."""
    lists = [p for p in element.properties if p.count_dtype is not None]
    if element.count == 0:
        _store(element, {p.name: np.empty(0, p.dtype) for p in element.properties}, {})
        return at
    sizes = {p.name: 0 for p in lists}
    if lists:
        sizes = _first_row_sizes(element, data, at)
    record = []
    for k, p in enumerate(element.properties):
        if p.count_dtype is not None:
            record += [(f"count {k}", p.count_dtype), (f"item {k}", p.dtype, (sizes[p.name],))]
        else:
            record.append((f"item {k}", p.dtype))
    row = np.dtype(record)
    if row.itemsize * element.count <= len(data) - at:
        rows = np.frombuffer(data, row, element.count, at)
        counts = [(k, p) for k, p in enumerate(element.properties) if p.count_dtype is not None]
        if all((rows[f"count {k}"] == sizes[p.name]).all() for k, p in counts):
            values = {p.name: rows[f"item {k}"] for k, p in enumerate(element.properties)}
            _store(element, values, {n: np.full(element.count, s) for n, s in sizes.items()})
            return at + row.itemsize * element.count
    return _uneven_rows(element, data, at)


def _first_row_sizes(element: Element, data: bytes, at: int) -> dict[str, int]:
    sizes = {}
    for p in element.properties:
        if p.count_dtype is None:
            at += p.dtype.itemsize
            continue
        n = _list_size(element, p, data, at)
        sizes[p.name] = n
        at += p.count_dtype.itemsize + n * p.dtype.itemsize
    return sizes


def _list_size(element: Element, p: Property, data: bytes, at: int) -> int:
    assert p.count_dtype is not None, "a number is no list"
    if at + p.count_dtype.itemsize > len(data):
        raise MeshError(f"it ends within the {element.name} rows; the file is cut short")
    n = int(np.frombuffer(data, p.count_dtype, 1, at)[0])
    check_count(n, p.dtype.itemsize, len(data) - at - p.count_dtype.itemsize, f"in a {p.name} list")
    return n


def _uneven_rows(element: Element, data: bytes, at: int) -> int:
    """Read rows whose lists differ in length, one by one."""
    parts: dict[str, list[AnyArray]] = {p.name: [] for p in element.properties}
    sizes: dict[str, list[int]] = {
        p.name: [] for p in element.properties if p.count_dtype is not None
    }
    for _ in range(element.count):
        for p in element.properties:
            n = 1
            if p.count_dtype is not None:
                n = _list_size(element, p, data, at)
                at += p.count_dtype.itemsize
                sizes[p.name].append(n)
            if at + n * p.dtype.itemsize > len(data):
                raise MeshError(f"it ends within the {element.name} rows; the file is cut short")
            parts[p.name].append(np.frombuffer(data, p.dtype, n, at))
            at += n * p.dtype.itemsize
    values = {name: np.concatenate(part) for name, part in parts.items()}
    _store(element, values, {name: np.array(size, np.int64) for name, size in sizes.items()})
    return at


def _store(element: Element, values: dict[str, AnyArray], sizes: dict[str, AnyArray]) -> None:
    element.values = {
        name: np.ravel(array).astype(array.dtype.newbyteorder("="))
        for name, array in values.items()
    }
    element.list_sizes = sizes


def _read_ascii(elements: Sequence[Element], text: bytes) -> None:
    for element in elements:
        check_count(element.count, 2 * max(1, len(element.properties)), len(text) + 1,
                    f"of {element.name}")  # fmt: skip
    numbers, at = parse_numbers(text, "the body"), 0
    for element in elements:
        at = _ascii_rows(element, numbers, at)


def _ascii_rows(element: Element, numbers: AnyArray, at: int) -> int:
    """Take one element's rows from the body's numbers; return where they end."""
    cut_short = MeshError(f"it ends within the {element.name} rows; the file is cut short")
    properties = element.properties
    if not any(p.count_dtype is not None for p in properties):
        width = len(properties)
        end = at + width * element.count
        if end > len(numbers):
            raise cut_short
        table = numbers[at:end].reshape(element.count, width)
        _store(element, {p.name: _cast(table[:, k], p) for k, p in enumerate(properties)}, {})
        return end
    columns: dict[str, list[Any]] = {p.name: [] for p in properties}
    sizes: dict[str, list[int]] = {p.name: [] for p in properties if p.count_dtype is not None}
    flat = numbers.tolist() if element.count else []
    for _ in range(element.count):
        for p in properties:
            n = 1
            if p.count_dtype is not None:
                if at >= len(flat) or not 0 <= flat[at] <= len(flat) - at:
                    raise cut_short
                n = int(flat[at])
                sizes[p.name].append(n)
                at += 1
            if at + n > len(flat):
                raise cut_short
            columns[p.name] += flat[at : at + n]
            at += n
    values = {p.name: _cast(np.array(columns[p.name], np.float64), p) for p in properties}
    _store(element, values, {name: np.array(size, np.int64) for name, size in sizes.items()})
    return at


def _cast(column: AnyArray, p: Property) -> AnyArray:
    """Return ASCII numbers in the declared type where they fit; only colours need to know it."""
    if p.dtype.kind == "f" or not column.size or not np.isfinite(column).all():
        return column
    limits = np.iinfo(p.dtype)
    fit = limits.min <= column.min() and column.max() <= limits.max
    return column.astype(p.dtype) if fit and (column == np.floor(column)).all() else column
