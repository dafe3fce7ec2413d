"""Work that has nothing to do with one another, on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import TypeVar

__all__ = ["each"]

_MOST_THREADS = 4
_Given = TypeVar("_Given")
_Found = TypeVar("_Found")


def each(work: Callable[[_Given], _Found], items: Sequence[_Given]) -> list[_Found]:
    """What `work` gives for each item, in their order; kernels in it run at the same time."""
    if len(items) < 2:
        return [work(item) for item in items]
    return list(_threads(os.getpid()).map(work, items))


@lru_cache(maxsize=1)
def _threads(process: int) -> ThreadPoolExecutor:
    """The threads of this process: one that was forked has none of its parent's."""
    count = min(_MOST_THREADS, os.cpu_count() or 1)
    return ThreadPoolExecutor(count, thread_name_prefix="paint3d-flow")
