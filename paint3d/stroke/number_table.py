"""Numbers of a large table by column, with the line that each row came from."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Iterator
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import RecordingError

__all__ = ["NumberTable"]

_BLOCK = 1 << 16  # rows that are read at once
_JOINED = 64  # blocks: an array so large goes back to the system when it is let go
_LARGEST = 2.0**62


class NumberTable:
    """A table of numbers in named columns.

    Blocks of rows that are plain numbers are read as a whole; others row by row, so that the one
    that is wrong is named.

    Parameters
    ----------
    names : list of str
        Of the columns.
    name : str
        Of the file, for messages.
    exact : set of str
        Columns that hold integers.
    may_lack : collection of str
        Columns in which an empty cell stands for NaN.
    """

    def __init__(
        self, names: list[str], name: str, exact: Iterable[str] = (), may_lack: Iterable[str] = ()
    ) -> None:
        self.names, self.name = names, name
        self._exact, self._may_lack = set(exact), set(may_lack)
        kinds = [np.int64 if column in self._exact else np.float64 for column in names]
        self._row = np.dtype([(f"c{k}", kind) for k, kind in enumerate(kinds)])
        self._lines: list[range | NDArray] = []
        self._columns: dict[str, list[NDArray]] = {column: [] for column in names}

    def __len__(self) -> int:
        return sum(map(len, self._lines))

    def read(
        self,
        rows: Iterator[tuple[int, str]],
        delimiter: str | None,
        split: Callable[[str], list[str]],
    ) -> None:
        """Add all rows: numbers of lines, and texts that `split` cuts into cells.

        `delimiter` stands between plain cells, None for white space.

        Raises
        ------
        RecordingError
            ``name:line: what is X; expected Y``.
        """
        while block := list(islice(rows, _BLOCK)):
            lines, texts = zip(*block, strict=True)
            found = self._plain(texts, delimiter)
            if found is None:
                cells = [self._numbers(line, split(text)) for line, text in block]
                found = np.array(cells, self._row)
            self._lines.append(_told_briefly(lines))
            for k, column in enumerate(self.names):
                _append(self._columns[column], found[f"c{k}"].copy())

    def _plain(self, texts: tuple[str, ...], delimiter: str | None) -> NDArray | None:
        """Rows of plain numbers, all at once; None where one may be anything else."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # such as for an integer written 1.0
                found = np.loadtxt(texts, self._row, comments=None, delimiter=delimiter, ndmin=1)
        except (ValueError, OverflowError, Warning):
            return None
        if len(found) != len(texts):
            return None
        for k in range(len(self.names)):
            if not (np.abs(found[f"c{k}"]) < _LARGEST).all():
                return None
        return found

    def _numbers(self, line: int, cells: list[str]) -> tuple[float, ...]:
        if len(cells) != len(self.names):
            raise RecordingError(
                f"{self.name}:{line}: there are {len(cells)} columns; expected {len(self.names)}"
            )
        return tuple(self._number(line, *named) for named in zip(self.names, cells, strict=True))

    def _number(self, line: int, name: str, cell: str) -> float:
        exact = name in self._exact
        if not cell and name in self._may_lack:
            return math.nan
        try:
            value = int(cell) if exact else float(cell)
            if math.isfinite(value) and abs(value) < _LARGEST:
                return value
        except (ValueError, OverflowError):
            pass
        kind = "an integer" if exact else "a finite number"
        raise RecordingError(
            f"{self.name}:{line}: {name} is {cell.strip()[:40]!r}; expected {kind}"
        )

    def line(self, row: int) -> int:
        """The line that a row came from."""
        for lines in self._lines:
            if row < len(lines):
                return int(lines[row])
            row -= len(lines)
        raise IndexError(row)

    def column(self, *names: str) -> tuple[str, NDArray] | None:
        """The first of the named columns that is there, and its values."""
        for name in names:
            if name in self._columns:
                if len(self._columns[name]) != 1:
                    self._columns[name] = [np.concatenate(self._columns[name])]
                return name, self._columns[name][0]
        return None

    def let_go(self, *names: str) -> None:
        """Forget the values of columns that are not asked for again."""
        for name in names:
            self._columns.pop(name, None)

    def check(self, name: str, values: NDArray, low: float, high: float) -> NDArray:
        """Return values that lie between bounds.

        Raises
        ------
        RecordingError
            If one does not; it names its line.
        """
        bad = np.flatnonzero((values < low) | (values > high))
        if len(bad):
            raise RecordingError(
                f"{self.name}:{self.line(bad[0])}: {name} is {values[bad[0]]:.6g}; "
                f"expected {low:g} to {high:g}"
            )
        return values


def _told_briefly(lines: tuple[int, ...]) -> range | NDArray:
    """Numbers of lines; most follow one another."""
    told = range(lines[0], lines[-1] + 1)
    return told if len(told) == len(lines) else np.array(lines, np.int32)


def _append(blocks: list[NDArray], block: NDArray) -> None:
    """Add a block, and join full ones that have become many."""
    blocks.append(block)
    small = [one for one in blocks[-_JOINED:] if len(one) == _BLOCK]
    if len(small) == _JOINED:
        blocks[-_JOINED:] = [np.concatenate(small)]
