"""Compile one part of the entries, in a process of its own."""

from __future__ import annotations

import gc
import json
import os
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tools.kernels.lowering import letter, lower
from tools.kernels.numba_inside import Dispatcher
from tools.kernels.optimising import Prepared, emit, optimise_for, prepare
from tools.kernels.processors import made_for
from tools.kernels.sources import ROOT, sources_of
from tools.kernels.table import Array, Entry, Number, Row, dtype_of

__all__ = ["compile_part"]

_NUMBERS = {"f8": "d", "f4": "f", "i8": "i", "b1": "b"}


def compile_part(
    groups: list[dict[str, Entry]], processors: list[str], folder: Path, say: Callable[[], None]
) -> None:
    """Write an object file of each group for each processor, and what its entries take and give.

    Parameters
    ----------
    groups : list of dict
        What is optimised together: entries by the names of their functions of C.
    processors : list of str
        Of one architecture.
    folder : Path
        Gets ``<k>-<processor>.o`` of the k-th group, and ``entries.json``.
    say : callable
        Called when an entry is lowered, when all is prepared, and when an object file is written;
        there in a process of its own.
    """
    gc.disable()  # it costs an eighth, and what is made is needed to the end
    entries = {symbol: entry for group in groups for symbol, entry in group.items()}
    lowered = lower(entries, say)
    _check_sources([*entries.values()])
    described = {
        symbol: {"symbol": symbol, **_describe(entry, *lowered.gives[symbol])}
        for symbol, entry in entries.items()
    }
    (folder / "entries.json").write_text(json.dumps(described), "utf-8")
    prepared = prepare(lowered, processors[0])
    say()
    _side_by_side([partial(_emit_for, one, groups, prepared, folder, say) for one in processors])


def _emit_for(
    processor: str,
    groups: list[dict[str, Entry]],
    prepared: Prepared,
    folder: Path,
    say: Callable[[], None],
) -> None:
    """The object files for a processor."""
    kinds = [made_for(processor, {entry.module for entry in group.values()}) for group in groups]
    first = optimise_for(kinds[0], prepared)

    def write(k: int) -> None:
        optimised = first if kinds[k] == kinds[0] else optimise_for(kinds[k], prepared)
        (folder / f"{k}-{processor}.o").write_bytes(emit(optimised, groups[k], kinds[k]))
        say()

    _side_by_side([partial(write, k) for k in range(len(groups))])


def _side_by_side(works: list[Callable[[], None]]) -> None:
    """Do the first here, and the others in processes of their own, from what this one holds."""
    children = [_in_child(work) for work in works[1:]]
    works[0]()
    for child in children:
        if os.waitpid(child, 0)[1]:
            raise SystemExit("a process that optimises kernels has ended early")


def _in_child(work: Callable[[], None]) -> int:
    child = os.fork()
    if child == 0:
        status = 1
        try:
            work()
            status = 0
        finally:
            os._exit(status)
    return child


def _check_sources(entries: list[Entry]) -> None:
    """See that no kernel was compiled that the entries would not be known to depend on."""
    known = {path for e in entries for path in sources_of(e.modules, e.tuples)}
    for module in [m for name, m in sys.modules.items() if name.startswith("paint3d.")]:
        for thing in vars(module).values():
            if isinstance(thing, Dispatcher) and thing.overloads:
                path = Path(thing.py_func.__code__.co_filename).relative_to(ROOT).as_posix()
                if path not in known:
                    raise RuntimeError(f"kernels call {path}, which `sources_of` does not see")


def _describe(entry: Entry, gives: str, n_gives: int) -> dict[str, Any]:
    """What a kernel takes and gives, for caller.c and for messages."""
    records: list[Any] = []
    takes = "".join(_specify(part, records) for part in entry.takes.values())
    return {
        "takes": f"({takes})",
        "gives": gives,
        "n_takes": sum(map(_count, entry.takes.values())),
        "n_gives": n_gives,
        "records": [_fields(dtype) for dtype in records],
        "expected": {name: _expect(part) for name, part in entry.takes.items()},
    }


def _specify(part: Number | Array | Row, records: list[Any]) -> str:
    if isinstance(part, Number):
        return _NUMBERS[part.code]
    if isinstance(part, Row):
        return f"({''.join(_specify(inner, records) for inner in part.parts)})"
    dtype = dtype_of(part)
    if dtype.names is None:
        return f"[{letter(dtype)}{part.axes}"
    if dtype not in records:
        records.append(dtype)
    return f"{{{chr(ord('A') + records.index(dtype))}{part.axes}"


def _count(part: Number | Array | Row) -> int:
    if isinstance(part, Row):
        return sum(map(_count, part.parts))
    return 1 + part.axes if isinstance(part, Array) else 1


def _expect(part: Number | Array | Row) -> str | dict[str, Any]:
    if isinstance(part, Number):
        return part.code
    if isinstance(part, Array):
        return f"{part.dtype}[{','.join(':' * part.axes)}]"
    names = part.names or tuple(map(str, range(len(part.parts))))
    return {name: _expect(inner) for name, inner in zip(names, part.parts, strict=True)}


def _fields(dtype: np.dtype) -> dict[str, Any]:
    """The fields of a record, to be made a dtype of again."""
    names = list(dtype.names)
    fields = [dtype.fields[name] for name in names]
    return {
        "names": names,
        "formats": [[of.base.str, list(of.shape)] if of.shape else of.str for of, *_ in fields],
        "offsets": [offset for _, offset, *_ in fields],
        "itemsize": dtype.itemsize,
    }
