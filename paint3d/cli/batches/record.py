"""The record of a batch's finished rows, by which it goes on after an interruption."""

from __future__ import annotations

import json
import os
from pathlib import Path

from paint3d.cli.batches.rows import Row, fingerprint
from paint3d.errors import ExportError

__all__ = ["FinishedRows"]


class FinishedRows:
    """A file of one JSON object a line, appended to when a row is finished.

    Parameters
    ----------
    path : Path
        Made with the first row. Lines that cannot be read, such as one cut short by a crash,
        are passed over.
    folder : str
        That relative paths of the rows start from.
    """

    def __init__(self, path: Path, folder: str = os.curdir) -> None:
        self.path, self._folder = path, os.path.abspath(folder)
        self._known: dict[str, tuple[int, int]] = {}
        self._cut_short = False
        try:
            text = path.read_text(encoding="utf-8", errors="replace")
        except FileNotFoundError:
            return
        except OSError as cause:
            raise ExportError("{file}: cannot read it: {cause}", file=path, cause=cause) from None
        self._cut_short = not text.endswith("\n")
        for line in text.splitlines():
            try:
                entry = json.loads(line)
                self._known[str(entry["row"])] = (int(entry["size"]), int(entry["changed_ns"]))
            except (ValueError, KeyError, TypeError, RecursionError):
                continue

    def has(self, row: Row) -> bool:
        """Return whether this very row was finished, and its output is unchanged since."""
        return self._known.get(fingerprint(row, self._folder), ()) == self._state(row)

    def add(self, row: Row, seconds: float) -> None:
        """Record that a row is finished, and its time.

        Raises
        ------
        ExportError
            If the file cannot be written.
        """
        state = self._state(row)
        if state is None:
            return
        entry: dict[str, object] = {"row": fingerprint(row, self._folder), "output": row.output}
        entry |= {"size": state[0], "changed_ns": state[1], "seconds": round(seconds, 3)}
        try:
            with open(self.path, "a", encoding="utf-8") as file:
                file.write("\n" * self._cut_short + json.dumps(entry) + "\n")
                file.flush()
                os.fsync(file.fileno())
            self._cut_short = False
        except OSError as cause:
            raise ExportError(
                "{file}: cannot write: {cause}", file=self.path, cause=cause
            ) from None

    def _state(self, row: Row) -> tuple[int, int] | None:
        try:
            status = os.stat(os.path.join(self._folder, row.output))
        except (OSError, ValueError):
            return None
        return status.st_size, status.st_mtime_ns
