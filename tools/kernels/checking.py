"""Check of the table against the sources, before anything is compiled."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tools.kernels.table import (
    TABLE,
    Array,
    Entry,
    Number,
    Row,
    Table,
    TableError,
    dtype_of,
    read_table,
    resolve,
)

__all__ = ["checked_table"]


def checked_table(path: Path = TABLE) -> Table:
    """Read a table and check all that it names; nothing is compiled.

    Raises
    ------
    TableError
        Every fault with its line, and what was expected.
    """
    table = read_table(path)
    faults = [
        *((of.line, fault) for of in table.tuples for fault in _tuple_faults(of)),
        *((entry.line, fault) for entry in table.entries for fault in _entry_faults(entry)),
        *_doubles(table),
        *_unused(table),
    ]
    if faults:
        raise TableError("\n".join(f"{table.name}:{line}: {what}" for line, what in sorted(faults)))
    return table


def _entry_faults(entry: Entry) -> Iterator[str]:
    kernel = _resolve(f"{entry.module}.{entry.name}")
    if isinstance(kernel, str):
        yield kernel
    elif not hasattr(kernel, "py_func"):
        yield f"{entry.kernel} is no kernel: expected one decorated with @kernel or @uncounted"
    else:
        names = tuple(inspect.signature(kernel.py_func).parameters)
        if names != tuple(entry.takes):
            got = _format_names(entry.takes)
            yield f"{entry.kernel}: expected {_format_names(names)}, as it takes, got {got}"
    yield from (fault for part in entry.takes.values() for fault in _record_faults(part))


def _tuple_faults(of: Row) -> Iterator[str]:
    kind = _resolve(of.of)
    if isinstance(kind, str):
        yield kind
    elif not hasattr(kind, "_fields"):
        yield f"paint3d.{of.of} is no named tuple"
    elif kind._fields != of.names:
        got = _format_names(of.names)
        yield f"paint3d.{of.of}: expected {_format_names(kind._fields)}, as it has, got {got}"
    yield from (fault for part in of.parts for fault in _record_faults(part))


def _record_faults(part: Number | Array | Row) -> Iterator[str]:
    """Yield the faults of an array of records; tuples have lines of their own in the table."""
    if isinstance(part, Array) and "." in part.dtype:
        constant = _resolve(part.dtype)
        if isinstance(constant, str):
            yield constant
        elif not isinstance(constant, np.dtype) or dtype_of(part).names is None:
            yield f"paint3d.{part.dtype} is no dtype of records"


def _resolve(of: str) -> object:
    """Resolve a name; return the object, or the fault as text."""
    try:
        return resolve(of)
    except (ImportError, AttributeError) as error:
        return f"paint3d.{of} is not there: {error}"


def _doubles(table: Table) -> Iterator[tuple[int, str]]:
    seen: list[Entry] = []
    for entry in table.entries:
        if entry in seen:
            yield entry.line, f"{entry.kernel} stands here twice with the same types"
        seen.append(entry)


def _unused(table: Table) -> Iterator[tuple[int, str]]:
    used = {of for entry in table.entries for of in entry.named_tuples}
    for of in table.tuples:
        if of.of not in used:
            yield of.line, f"paint3d.{of.of} is taken by no kernel"


def _format_names(names: object) -> str:
    return f"({', '.join(names)})"
