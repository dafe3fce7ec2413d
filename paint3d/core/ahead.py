"""What is needed next is made while what is there is used, on a second core."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from paint3d.core.machine import leave_interrupts_to_others

__all__ = ["ahead", "beside"]

T = TypeVar("T")


def ahead(makers: Iterable[Callable[[], T]]) -> Iterator[T]:
    """What each of `makers` gives, in order; a thread makes the next while one is used.

    No more than one is made ahead, and none while another is made, so it is the same as calling
    one after the other, sooner, as long as using one changes nothing that making another takes. An
    error comes where the call would have raised it. The first, often the only one, takes no thread.
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
    with ThreadPoolExecutor(1, "ahead", leave_interrupts_to_others) as beside:
        while following is not None:
            coming = beside.submit(following)
            yield made
            made = coming.result()
            following = next(waiting, None)
        yield made


@contextmanager
def beside(make: Callable[[], object]) -> Iterator[None]:
    """Have a thread make what will be asked for, and is kept, while what stands within is done.

    Its end is waited for. An error comes where it is asked for, for that is not kept.
    """
    with ThreadPoolExecutor(1, "beside", leave_interrupts_to_others) as thread:
        thread.submit(make)
        yield
