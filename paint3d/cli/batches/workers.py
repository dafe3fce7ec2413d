"""Rows in processes of this machine."""

from __future__ import annotations

import logging
import multiprocessing
import signal
import sys
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkServerContext, SpawnContext
from multiprocessing.process import BaseProcess
from typing import Any

from paint3d.cli.batches.rows import Outcome, Row, run_row
from paint3d.core.ending import TerminationHandler, end_now, holding_interrupts
from paint3d.core.machine import blocking_interrupts, end_with_parent, ignore_interrupts

__all__ = ["run_here"]

_WARM = "paint3d.cli.batches.warm"


def run_here(
    rows: Sequence[Row], processes: int, retries: int = 0, *, quiet: bool = False
) -> Iterator[Outcome]:
    """Run rows in so many processes; yield each outcome as it comes. Quiet ones print no notes.

    Where a process dies another takes its place, and the row it was at is tried again after the
    others, so many times.
    """
    tries: Counter[Row] = Counter()
    left = list(reversed(rows))
    workers = [_Worker(quiet) for _ in range(min(processes, len(rows)))]
    try:
        for worker in workers:
            worker.start(left.pop())
        while busy := [worker for worker in workers if worker.row is not None]:
            ready = wait([worker.connection for worker in busy])
            for worker in [worker for worker in busy if worker.connection in ready]:
                row = worker.row
                outcome = worker.outcome()
                if outcome is not None:
                    yield outcome
                elif row is not None and tries[row] < retries:
                    tries[row] += 1
                    left.insert(0, row)
                elif row is not None:
                    again = f", {tries[row] + 1} times" if tries[row] else ""
                    yield Outcome(row.line, f"its process died ({worker.death}){again}", 0.0, "")
                if left:
                    worker.start(left.pop())
    finally:
        for worker in workers:
            worker.stop()


def _context() -> SpawnContext | ForkServerContext:
    """Return the context of processes: forked from one that has imported all, if that is safe."""
    if not sys.platform.startswith("linux"):  # elsewhere system libraries do not survive a fork
        return multiprocessing.get_context("spawn")
    from multiprocessing import forkserver

    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([_WARM])
    with holding_interrupts(), blocking_interrupts():  # or the server prints one while it imports
        forkserver.ensure_running()
    return context


class _Worker:
    """A process that runs one row after the other; started anew when it has died."""

    def __init__(self, quiet: bool) -> None:
        self._quiet = quiet
        self.row: Row | None = None
        self.death = ""  # how the last process died
        self.connection: Connection[Any, Any]  # from the first start on
        self._process: BaseProcess | None = None

    def start(self, row: Row) -> None:
        if self._process is None:
            context = _context()
            self.connection, theirs = context.Pipe()
            process = context.Process(target=_serve, args=(theirs, self._quiet), daemon=False)
            process.start()  # returns once the server has imported all, and can be ended
            self._process = process
            theirs.close()
        self.row = row
        with suppress(OSError):  # it has died: `outcome` will find out
            self.connection.send(tuple(row))

    def outcome(self) -> Outcome | None:
        """Return how the row went, when the connection is ready; None where its process died."""
        process, self.row = self._process, None
        assert process is not None, "nothing was started"
        try:
            return Outcome(*self.connection.recv())
        except (EOFError, ConnectionError):
            process.join()
            code = process.exitcode or 0
            self.death = signal.Signals(-code).name if code < 0 else f"exit status {code}"
            self.connection.close()
            self._process = None
            return None

    def stop(self) -> None:
        if self._process is not None:
            self.connection.close()
            if self.row is not None:
                self._process.terminate()
            self._process.join()
            self._process = None


def _serve(connection: Connection[Any, Any], quiet: bool = False) -> None:
    """Run rows until the other end is closed."""
    ignore_interrupts()  # the parent stops us
    end_with_parent(end_now)
    if not sys.warnoptions:
        warnings.simplefilter("ignore")
    if quiet:
        logging.getLogger("paint3d").addHandler(logging.NullHandler())
    with TerminationHandler(grace_s=0.0):  # what is being written is removed
        _run_all(connection)


def _run_all(connection: Connection[Any, Any]) -> None:
    while True:
        try:
            row = Row(*connection.recv())
        except (EOFError, OSError):
            return
        outcome = run_row(row)
        try:
            connection.send(tuple(outcome))
        except OSError:
            return
