"""Parallel work in processes of its own, with results in order.

A process that is started here ends with the one that started it, however that ends: being killed
leaves nothing behind. An interrupt is the starter's affair; it ends the others at once.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from multiprocessing.reduction import ForkingPickler
from typing import Any, NamedTuple, TypeVar, cast

from paint3d.core.ending import holding_interrupts
from paint3d.core.machine import blocking_interrupts, end_with_parent, ignore_interrupts
from paint3d.errors import Paint3DError

__all__ = ["in_processes", "serve"]

_PATIENCE = 10  # of niceness
_Answer = tuple[int, object, Exception | None]  # the item's number, its result, its error
_Given = TypeVar("_Given")
_Found = TypeVar("_Found")


class _Worker(NamedTuple):
    process: BaseProcess
    connection: Connection[Any, Any]


def in_processes(
    work: Callable[[_Given], _Found],
    items: Sequence[_Given],
    n: int,
    *,
    is_patient: bool = False,
) -> Generator[_Found]:
    """Yield what `work` gives for each item, in their order, computed by `n` processes.

    All of it must be such as can be sent to another process. With `is_patient` they give way to
    others.

    Raises
    ------
    Paint3DError
        If a process dies, or finds what cannot be sent. What `work` raises is raised here.
    """
    workers = list[_Worker]()
    left, results = iter(enumerate(items)), dict[int, _Found]()
    try:
        _start(workers, work, n, is_patient=is_patient)
        busy = [w for w in workers if _send_next(w, left)]
        for k in range(len(items)):
            while k not in results:
                ready = wait([worker.connection for worker in busy])
                for worker in [one for one in busy if one.connection in ready]:
                    number, result, fault = _receive_answer(worker)
                    if fault is not None:
                        raise fault
                    results[number] = cast("_Found", result)
                    if not _send_next(worker, left):
                        busy.remove(worker)
            yield results.pop(k)
    finally:
        for worker in workers:
            worker.process.kill()  # it has nothing to end, and may hold back what asks it to
        for worker in workers:
            worker.process.join()
            worker.connection.close()


def _start(
    workers: list[_Worker], work: Callable[..., Any], n: int, *, is_patient: bool = False
) -> None:
    """Start n more workers; those already started stay known if the next one fails."""
    context = multiprocessing.get_context("spawn")
    with holding_interrupts(), blocking_interrupts():
        for _ in range(n):
            ours, theirs = context.Pipe()
            process = context.Process(target=serve, args=(work, theirs, is_patient), daemon=True)
            process.start()
            theirs.close()
            workers.append(_Worker(process, ours))


def _send_next(worker: _Worker, left: Iterator[tuple[int, object]]) -> bool:
    """Give a worker the next item; False where there is none."""
    for numbered in left:
        with suppress(OSError):  # it has died: `_receive_answer` will find out
            worker.connection.send(numbered)
        return True
    return False


def _receive_answer(worker: _Worker) -> _Answer:
    try:
        result: _Answer = worker.connection.recv()
        return result
    except (EOFError, ConnectionError):
        worker.process.join()
        raise Paint3DError(
            "a worker process died (exit status {exitcode})",
            exitcode=worker.process.exitcode,
        ) from None


def serve(
    work: Callable[..., Any], connection: Connection[Any, Any], is_patient: bool = False
) -> None:
    """Work on items until the other end is closed."""
    if is_patient and hasattr(os, "nice"):
        os.nice(_PATIENCE)
    ignore_interrupts()
    end_with_parent()
    while True:
        try:
            number, item = connection.recv()
        except (EOFError, OSError):
            return
        try:
            answer: _Answer = (number, work(item), None)
        except Exception as fault:
            answer = (number, None, fault)
        try:
            connection.send_bytes(_pack_answer(answer))
        except OSError:  # whoever asked is gone
            return


def _pack_answer(answer: _Answer) -> memoryview | bytes:
    """An answer as it is sent; one that cannot be sent becomes an error that says so."""
    number, _, fault = answer
    try:
        packed = ForkingPickler.dumps(answer)
        if fault is not None:
            ForkingPickler.loads(packed)  # some errors can be sent, but not be made again
    except Exception as cause:
        reason = f"{type(cause).__name__}: {cause}"
        if fault is not None:
            reason = f"{type(fault).__name__}: {fault} ({reason})"
        unsent = Paint3DError("the result of a process could not be sent back: {told}", told=reason)
        packed = ForkingPickler.dumps((number, None, unsent))
    return packed
