"""Prefetching: a worker thread computes the next item while the caller uses the current one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from paint3d.core.machine import block_termination_signals

__all__ = ["ahead", "beside"]

T = TypeVar("T")


def ahead(makers: Iterable[Callable[[], T]]) -> Iterator[T]:
    """Yield the results of `makers` in order; a thread makes the next while one is used.

    Only one is made ahead, and never two at a time, so the results are those of calling one after
    the other, sooner, as long as using one changes nothing that making the next reads. An error is
    raised where the call would have raised it. The first, often the only one, needs no thread.
    """
    waiting = iter(makers)
    first = next(waiting, None)
    if first is None:
        return
    made = first()
    following = next(waiting, None)
    if following is None:
        yield made
        return
    with ThreadPoolExecutor(1, "ahead", block_termination_signals) as executor:
        while following is not None:
            future = executor.submit(following)
            yield made
            made = future.result()
            following = next(waiting, None)
        yield made


@contextmanager
def beside(make: Callable[[], object]) -> Iterator[None]:
    """Run `make`, which fills a cache, in a thread beside the body of the ``with`` statement.

    The end of the body waits for it. An error in it is dropped: nothing is cached then, and
    whoever needs the result raises it again.
    """
    with ThreadPoolExecutor(1, "beside", block_termination_signals) as executor:
        executor.submit(make)
        yield
