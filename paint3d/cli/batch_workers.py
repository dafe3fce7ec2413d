"""Where rows are run: in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import suppress
from multiprocessing import forkserver, resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.context import BaseContext
from multiprocessing.process import BaseProcess

from paint3d.cli.batch_rows import Outcome, Row, run_row
from paint3d.errors import InputError

__all__ = ["run_here", "run_on_cluster", "usable_cores"]

PATIENCE_S = 30
_WARM = "paint3d.cli.batch_warm"


def usable_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_here(rows: Sequence[Row], processes: int) -> Iterator[Outcome]:
    """Run rows in so many processes; yield each outcome as it comes.

    A process that dies costs the row it was at, and another takes its place.
    """
    left = list(reversed(rows))
    workers = [_Worker() for _ in range(min(processes, len(rows)))]
    try:
        for worker in workers:
            worker.start(left.pop())
        while busy := {w.connection: w for w in workers if w.row is not None}:
            for connection in wait(list(busy)):
                worker = busy[connection]
                yield worker.outcome()
                if left:
                    worker.start(left.pop())
    finally:
        for worker in workers:
            worker.stop()


def _context() -> BaseContext:
    """How processes come to be: forked from one that has imported all, where that is safe."""
    if not sys.platform.startswith("linux"):  # elsewhere system libraries do not survive a fork
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([_WARM])
    resource_tracker.ensure_running()  # would unblock signals below
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:  # the server inherits the mask: no traceback where it is interrupted while it imports
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
    return context


class _Worker:
    """A process that runs one row after the other; started anew when it has died."""

    def __init__(self) -> None:
        self.row: Row | None = None
        self.connection: Connection | None = None
        self._process: BaseProcess | None = None

    def start(self, row: Row) -> None:
        if self._process is None:
            context = _context()
            self.connection, theirs = context.Pipe()
            process = context.Process(target=_serve, args=(theirs,), daemon=False)
            process.start()
            self._process = process
            theirs.close()
        self.row = row
        with suppress(OSError):  # it has died: `outcome` will find out
            self.connection.send(tuple(row))

    def outcome(self) -> Outcome:
        """Return how the row went, when the connection is ready."""
        row, self.row = self.row, None
        try:
            return Outcome(*self.connection.recv())
        except (EOFError, ConnectionError):
            self._process.join()
            code = self._process.exitcode or 0
            how = signal.Signals(-code).name if code < 0 else f"exit status {code}"
            self.connection.close()
            self._process = None
            return Outcome(row.line, f"its process died ({how})", 0.0, "")

    def stop(self) -> None:
        if self._process is not None:
            self.connection.close()
            if self.row is not None:
                self._process.terminate()
            self._process.join()
            self._process = None


def _serve(connection: Connection) -> None:
    """Run rows until the other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent stops us
    if not sys.warnoptions:
        warnings.simplefilter("ignore")
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


def run_on_cluster(rows: Sequence[Row], address: str) -> Iterator[Outcome]:
    """Run rows on a Dask cluster, whose workers see the same files under the same paths.

    Raises
    ------
    InputError
        If the package ``distributed`` is missing, or the scheduler does not answer.
    """
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise InputError(
            "--scheduler needs the package distributed; expected pip install 'paint3d[cluster]'"
        ) from None
    try:
        client = Client(address, timeout=PATIENCE_S)
    except (OSError, ValueError, TypeError) as cause:
        raise InputError(f"the scheduler {address} does not answer: {cause}") from None
    with client:
        folder = os.getcwd()
        tasks = {
            client.submit(_run_in, folder, tuple(row), pure=False, retries=0): row for row in rows
        }
        for task in as_completed(tasks):
            if task.status == "finished":
                yield Outcome(*task.result())
            else:
                yield Outcome(tasks[task].line, f"its worker failed: {task.exception()}", 0.0, "")


def _run_in(folder: str, row: tuple) -> tuple:
    """Run a row on a worker as from this folder.

    Raises
    ------
    FileNotFoundError
        If the worker does not see the folder.
    """
    if os.getcwd() != folder:
        os.chdir(folder)
    return tuple(run_row(Row(*row)))
