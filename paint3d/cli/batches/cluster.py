"""Rows on a Dask cluster, whose workers see the same files under the same paths."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from paint3d.cli.batches.rows import Outcome, Row, placed, run_row
from paint3d.errors import InputError

if TYPE_CHECKING:
    from distributed import Client, Future

__all__ = ["run_on_cluster"]

PATIENCE_S = 30


def run_on_cluster(rows: Sequence[Row], address: str, folder: str = os.curdir) -> Iterator[Outcome]:
    """Run rows on a cluster, files counted from a folder; yield each outcome as it comes.

    A row whose worker is lost, or does not see this folder, is run by another.

    Raises
    ------
    InputError
        If the package ``distributed`` is missing, or the scheduler does not answer or no longer.
    """
    try:
        from distributed import Client
    except ImportError:
        raise InputError(
            "--scheduler needs the package distributed; expected pip install 'paint3d[cluster]'"
        ) from None
    try:
        client = Client(address, timeout=PATIENCE_S)
    except (OSError, ValueError, TypeError) as cause:
        raise InputError(
            "the scheduler {address} does not answer: {cause}",
            address=address,
            cause=cause,
        ) from None
    with client:
        yield from _Work(client, address, os.path.abspath(folder)).run(rows)


class _Work:
    """Rows that a cluster runs, and the workers that do not see their files."""

    def __init__(self, client: Client, address: str, folder: str) -> None:
        self._client, self._address, self._folder = client, address, folder
        self._rows: dict[object, Row] = {}
        self._blind: set[str] = set()

    def run(self, rows: Sequence[Row]) -> Iterator[Outcome]:
        """Run rows all at once, and those that lose their worker once more, one by one.

        A row that kills workers takes rows with it that wait for the same ones; alone it cannot.
        """
        lost = []
        for row, outcome in self._run_together(rows):
            if outcome is None:
                lost.append(row)
            else:
                yield outcome
        for row in lost:
            for _, outcome in self._run_together([row]):
                yield outcome or Outcome(row.line, "its worker died, and another too", 0.0, "")

    def _run_together(self, rows: Sequence[Row]) -> Iterator[tuple[Row, Outcome | None]]:
        """Yield each row with how it went, None if its worker was lost."""
        from distributed import KilledWorker, as_completed

        coming = as_completed([self._submit(row) for row in rows])
        for task in coming:
            row = self._rows.pop(task.key)
            if task.status == "error":
                yield row, None
                continue
            if task.status in ("lost", "pending"):  # its worker died when it had just finished
                self._rows[task.key] = row
                coming.add(task)  # the scheduler has it run again
                continue
            if task.status != "finished":
                raise InputError(
                    "the scheduler {address} no longer answers; what is finished is noted: "
                    "expected another --scheduler, or none, for the rest",
                    address=self._address,
                )
            try:
                worker, outcome = task.result()
            except KilledWorker:  # it died before it could return the outcome
                yield row, None
                continue
            if outcome is not None:
                yield row, Outcome(*outcome)
                continue
            self._blind.add(worker)
            if self._seeing():
                coming.add(self._submit(row))
            else:
                message = f"no worker sees the folder {self._folder}"
                yield row, Outcome(row.line, message, 0.0, "")

    def _submit(self, row: Row) -> Future[Any]:
        where = self._seeing() if self._blind else None
        task = self._client.submit(
            _run_there, self._folder, tuple(row), workers=where, pure=False, retries=0
        )
        self._rows[task.key] = row
        return task

    def _seeing(self) -> list[str]:
        """Return the workers that may see the folder."""
        return [w for w in self._client.scheduler_info(-1)["workers"] if w not in self._blind]


def _run_there(folder: str, row: tuple[Any, ...]) -> tuple[str, tuple[Any, ...] | None]:
    """Run a row on a worker; return its address, and the outcome, None without the folder."""
    from distributed import get_worker

    address = get_worker().address
    if not os.path.isdir(folder):
        return address, None
    return address, tuple(run_row(placed(Row(*row), folder)))
