"""The table of the kernels that Python calls, with the types of what they take: entries.txt."""

from __future__ import annotations

import importlib
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

__all__ = [
    "TABLE",
    "Array",
    "Entry",
    "Number",
    "Row",
    "Table",
    "TableError",
    "dtype_of",
    "read_table",
    "resolve",
]

TABLE = Path(__file__).with_name("entries.txt")
_NUMBERS = {"float": "f8", "int": "i8", "bool": "b1", "f4": "f4"}
_DTYPES = {"f4", "f8", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "b1"}
_KNOWN = (
    f"one of {', '.join(_NUMBERS)}, an array such as f8[:,:] of {', '.join(sorted(_DTYPES))} or "
    "of a.module.CONSTANT, (type, type), or a tuple of a line above"
)
_PART = re.compile(r"\s*(\w+) ((?:\([^)]*\)|\[[^]]*\]|[^,(\[])+)(?:,|$)")
_ARRAY = re.compile(r"([\w.]+)\[(:(?:,:)*)\]")


class TableError(ValueError):
    """A line of the table that is malformed, or disagrees with the source."""


@dataclass(frozen=True)
class Number:
    """A number: f8, f4, i8 or b1."""

    code: str


@dataclass(frozen=True)
class Array:
    """A C-contiguous array."""

    dtype: str  # NumPy's short name, or module.CONSTANT of records
    axes: int


@dataclass(frozen=True)
class Row:
    """A tuple; `of` is the named tuple's module and name, "" for a plain one."""

    of: str
    parts: tuple[Number | Array | Row, ...]
    names: tuple[str, ...] = ()
    line: int = field(default=0, compare=False, repr=False)


@dataclass(frozen=True)
class Entry:
    """A kernel that Python calls, with its arguments by name."""

    module: str  # after paint3d.
    name: str
    takes: dict[str, Number | Array | Row] = field(hash=False)
    line: int = field(default=0, compare=False, repr=False)

    @property
    def kernel(self) -> str:
        """Full name of the kernel."""
        return f"paint3d.{self.module}.{self.name}"

    @property
    def modules(self) -> set[str]:
        """Full names of the modules that define the kernel and records among its arguments."""
        named = {of for part in self.takes.values() for of, is_record in _named(part) if is_record}
        return {f"paint3d.{name.rpartition('.')[0]}" for name in {f"{self.module}.", *named}}

    @property
    def tuples(self) -> set[str]:
        """Full names of the modules that define the tuples among its arguments."""
        return {f"paint3d.{of.rpartition('.')[0]}" for of in self.named_tuples}

    @property
    def named_tuples(self) -> set[str]:
        """Dotted names of all tuples among its arguments, after paint3d."""
        return {
            of for part in self.takes.values() for of, is_record in _named(part) if not is_record
        }


@dataclass(frozen=True)
class Table:
    """Contents of a table, in its order."""

    name: str  # of its file
    tuples: list[Row]
    entries: list[Entry]


def read_table(path: Path = TABLE) -> Table:
    """Read a table; whether it agrees with the sources is not checked here (`checking`).

    Raises
    ------
    TableError
        With the line.
    """
    tuples: dict[str, Row] = {}
    entries: list[Entry] = []
    for line, text in _lines(path.read_text("utf-8")):
        place = f"{path.name}:{line}"
        head, colon, rest = text.partition(": ")
        if not colon:
            raise TableError(f"{place}: expected 'module.kernel: name type, ...', got {text!r}")
        parts: dict[str, Number | Array | Row] = {}
        for name, of in _parts(rest):
            if not name:
                raise TableError(f"{place}: {head}: expected 'name type, ...', got {of!r}")
            try:
                parts[name] = _type_of(of.strip(), tuples)
            except KeyError as error:
                raise TableError(
                    f"{place}: {head}: {name} has unknown type {error}; expected {_KNOWN}"
                ) from None
        if head.startswith("tuple "):
            of, _, name = head.removeprefix("tuple ").partition(" as ")
            row = Row(of, tuple(parts.values()), tuple(parts), line)
            tuples[name or of.rpartition(".")[2]] = row
        else:
            module, _, name = head.rpartition(".")
            entries.append(Entry(module, name, parts, line))
    return Table(path.name, list(tuples.values()), entries)


def resolve(of: str) -> Any:
    """Resolve a dotted name after ``paint3d.`` to a class, function or constant."""
    module, _, name = of.rpartition(".")
    return getattr(importlib.import_module(f"paint3d.{module}"), name)


def dtype_of(array: Array) -> np.dtype:
    """Return the type of an array's elements."""
    return np.dtype(array.dtype) if array.dtype in _DTYPES else resolve(array.dtype)


def _named(part: Number | Array | Row) -> Iterator[tuple[str, bool]]:
    """Yield the dotted names of named tuples and records in a type, and whether it is a record."""
    if isinstance(part, Row):
        if part.of:
            yield part.of, False
        for inner in part.parts:
            yield from _named(inner)
    elif isinstance(part, Array) and part.dtype not in _DTYPES:
        yield part.dtype, True


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield lines with their numbers, without comments; continued ones are joined."""
    at, whole = 0, ""
    for number, line in enumerate([*re.sub(r"#.*", "", text).splitlines(), "end"], 1):
        if line[:1].isspace():
            whole += f" {line.strip()}"
        elif line:
            if whole:
                yield at, whole
            at, whole = number, line.rstrip()


def _parts(text: str) -> Iterator[tuple[str, str]]:
    """Yield names and types; a part that cannot be read has no name."""
    at = 0
    while at < len(text):
        found = _PART.match(text, at)
        if not found:
            yield "", text[at:]
            return
        yield found[1], found[2]
        at = found.end()


def _type_of(text: str, tuples: dict[str, Row]) -> Number | Array | Row:
    if text in _NUMBERS:
        return Number(_NUMBERS[text])
    array = _ARRAY.fullmatch(text)
    if array:
        if array[1] not in _DTYPES and "." not in array[1]:
            raise KeyError(text)
        return Array(array[1], array[2].count(":"))
    if text.startswith("("):
        parts = (part.strip() for part in text[1:-1].split(","))
        return Row("", tuple(_type_of(part, tuples) for part in parts))
    return tuples[text]
