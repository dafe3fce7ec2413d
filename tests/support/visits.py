"""Which modules of the package the way of some data goes through."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType, FunctionType
from typing import Any

__all__ = ["called_by", "modules_called"]


def called_by(kernel: Callable[..., Any]) -> set[str]:
    """Modules of a kernel and of all that it may call, by the names in its source."""
    seen: set[FunctionType] = set()
    todo: list[Any] = [kernel]
    while todo:
        function = inspect.unwrap(todo.pop())
        ours = isinstance(function, FunctionType) and function.__module__.startswith("paint3d.")
        if ours and function not in seen:
            seen.add(function)
            todo += filter(callable, inspect.getclosurevars(function).globals.values())
    return {function.__module__ for function in seen}


@contextmanager
def modules_called() -> Iterator[set[str]]:
    """Modules of the package whose functions are called meanwhile; kernels are not seen."""
    found: set[str] = set()

    def note(frame: FrameType, event: str, _: object) -> None:
        name = frame.f_globals.get("__name__", "")
        if event == "call" and name.startswith("paint3d."):
            found.add(name)

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        yield found
    finally:
        sys.setprofile(before)
