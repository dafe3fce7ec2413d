"""Numbers of a large table by column, with the line that each row came from."""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Callable, Iterable, Iterator
from typing import Protocol

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.errors import RecordingError

__all__ = ["Lines", "NumberTable"]

_FEWEST = 1 << 16  # rows in a column's first piece
_MOST = 1 << 22  # rows in one piece: so much memory goes back to the system when it is freed
_LARGEST = 2.0**62


class Lines(Protocol):
    """Lines of a text, one by one or as blocks: `recording.TextLines`."""

    def __iter__(self) -> Iterator[tuple[int, str]]:
        """Iterate over numbers from 1, and texts."""

    def read_block(self) -> tuple[int, bytes]:
        """The number of the next line, and many whole lines; none at the end."""

    def split_block(self, first: int, data: bytes) -> Iterator[tuple[int, str]]:
        """Yield numbers and texts of the lines in a block whose first has the number `first`."""


class NumberTable:
    """A table of numbers in named columns.

    Blocks of rows that are plain numbers are read by NumPy; others row by row, so that the one that
    is wrong is named.

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
        self._exact = np.array([column in set(exact) for column in names])
        self._may_lack = np.array([column in set(may_lack) for column in names])
        kinds = [np.int64 if exact else np.float64 for exact in self._exact]
        self._row = np.dtype([(str(k), kind) for k, kind in enumerate(kinds)])
        self._lines: list[range | AnyArray] = []
        self._asked: set[str] = set()
        self._columns = {
            column: _Column(np.int64 if exact else np.float64)
            for column, exact in zip(names, self._exact, strict=True)
        }

    def __len__(self) -> int:
        return sum(map(len, self._lines))

    def read(
        self,
        lines: Lines,
        delimiter: str | None,
        split: Callable[[str], list[str] | None],
        comment: str | None = None,
    ) -> None:
        """Add all rows.

        Parameters
        ----------
        lines : Lines
        delimiter : str, optional
            What stands between plain cells; None for white space.
        split : callable
            Splits a line into cells; None for a line that is passed over.
        comment : str, optional
            Plain lines that begin with it are passed over.

        Raises
        ------
        RecordingError
            ``name:line: what is X; expected Y``.
        """
        while True:
            first, data = lines.read_block()
            if not data:
                break
            table, at = self._read_plain(data, delimiter, comment)
            if table is None:
                table, at = self._read_singly(lines.split_block(first, data), split, first)
            self._lines.append(_compact(first, at))
            for k, column in enumerate(self.names):
                self._columns[column].add(table[str(k)])

    def _read_plain(
        self, data: bytes, delimiter: str | None, comment: str | None
    ) -> tuple[AnyArray | None, AnyArray]:
        """Return a block's rows, and their lines; None where one is not plain."""
        none = np.empty(0, np.int32)
        if not data.isascii() or b"\0" in data:
            return None, none
        if delimiter and self._may_lack.any():
            if b"n" in data or b"N" in data:  # of nan, which stands for an empty cell below
                return None, none
            data = _fill_empty_cells(data, delimiter.encode("ascii"))
        mark = comment.encode("ascii") if comment else None

        def is_row(line: bytes) -> bool:
            cells = line.strip()
            return bool(cells) and not (mark and cells.startswith(mark))

        at = np.fromiter((k for k, row in enumerate(io.BytesIO(data)) if is_row(row)), np.int32)
        if not len(at):
            return np.empty(0, self._row), none
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", DeprecationWarning)  # an integer with a point
                table = np.loadtxt(
                    filter(is_row, io.BytesIO(data)), self._row, comments=None,
                    delimiter=delimiter, quotechar='"', ndmin=1,
                )  # fmt: skip
        except (ValueError, DeprecationWarning):
            return None, none
        for k, (exact, may_lack) in enumerate(zip(self._exact, self._may_lack, strict=True)):
            values = table[str(k)]
            sound = (values > -_LARGEST) & (values < _LARGEST)
            if not (sound | np.isnan(values) if may_lack and not exact else sound).all():
                return None, none
        return table, at

    def _read_singly(
        self,
        lines: Iterable[tuple[int, str]],
        split: Callable[[str], list[str] | None],
        first: int,
    ) -> tuple[AnyArray, AnyArray]:
        """Return a block's rows, parsed one by one, so that the faulty one is named."""
        table, at = [], []
        for line, text in lines:
            cells = split(text)
            if cells is not None:
                if len(cells) != len(self.names):
                    raise RecordingError(
                        "{name}:{line}: there are {n} columns; expected {names}",
                        name=self.name,
                        line=line,
                        n=len(cells),
                        names=len(self.names),
                    )
                table.append(tuple(self._number(line, k, cell) for k, cell in enumerate(cells)))
                at.append(line - first)
        return np.array(table, self._row), np.array(at, np.int32)

    def _number(self, line: int, column: int, cell: str) -> float:
        name, exact = self.names[column], self._exact[column]
        if not cell and self._may_lack[column]:
            return math.nan
        try:
            value = int(cell) if exact else float(cell)
            if math.isfinite(value) and abs(value) < _LARGEST:
                return value
        except (ValueError, OverflowError):
            pass
        kind = "an integer" if exact else "a finite number"
        raise RecordingError(
            "{name}:{line}: {name_2} is {cell!r}; expected {kind}",
            name=self.name,
            line=line,
            name_2=name,
            cell=cell.strip()[:40],
            kind=kind,
        )

    def line(self, row: int) -> int:
        """The line number of a row."""
        for lines in self._lines:
            if row < len(lines):
                return int(lines[row])
            row -= len(lines)
        raise IndexError(row)

    def column(self, *names: str) -> tuple[str, AnyArray] | None:
        """The first of the named columns that is there, and its values."""
        for name in names:
            if name in self._columns:
                self._asked.add(name)
                return name, self._columns[name].values()
        return None

    def unread(self) -> list[str]:
        """Columns that were not read."""
        return [name for name in self.names if name not in self._asked]

    def drop(self, *names: str) -> None:
        """Drop the values of columns that are not read again."""
        for name in names:
            self._columns.pop(name, None)

    def check(self, name: str, values: AnyArray, low: float, high: float) -> AnyArray:
        """Refuse values outside bounds; return them.

        Raises
        ------
        RecordingError
            If one does not; it names its line.
        """
        bad = np.flatnonzero((values < low) | (values > high))
        if len(bad):
            raise RecordingError(
                "{name}:{line}: {name_2} is {values:.6g}; expected {low:g} to {high:g}",
                name=self.name,
                line=self.line(bad[0]),
                name_2=name,
                values=values[bad[0]],
                low=low,
                high=high,
            )
        return values


def _fill_empty_cells(data: bytes, delimiter: bytes) -> bytes:
    """Return whole lines with nan in their empty cells, ten times as fast as re.sub."""
    double, n = 2 * delimiter, b"nan"
    for _ in range(2 if double in data else 0):  # of three in a row every second one at a time
        data = data.replace(double, delimiter + n + delimiter)
    for end in (b"\n", b"\r\n"):
        data = data.replace(delimiter + end, delimiter + n + end)
    data = data.replace(b"\n" + delimiter, b"\n" + n + delimiter)
    data = n + data if data.startswith(delimiter) else data
    return data + n if data.endswith(delimiter) else data


def _compact(first: int, lines: AnyArray) -> range | AnyArray:
    """Numbers of lines, from those counted in a block that begins with line `first`."""
    if len(lines) == 0 or lines[-1] - lines[0] == len(lines) - 1:  # they rise: all in between
        start = first + int(lines[0]) if len(lines) else first
        return range(start, start + len(lines))
    return lines + np.int32(first)


class _Column:
    """A growing column of numbers, in pieces: growing one array would hold it twice in memory."""

    def __init__(self, kind: type) -> None:
        self._kind = kind
        self._pieces: list[AnyArray] = []
        self._n_last = 0  # in the last piece

    def add(self, block: AnyArray) -> None:
        while len(block):
            if not self._pieces or self._n_last == len(self._pieces[-1]):
                capacity = 2 * len(self._pieces[-1]) if self._pieces else _FEWEST
                self._pieces.append(np.empty(min(capacity, _MOST), self._kind))
                self._n_last = 0
            piece = self._pieces[-1]
            n = min(len(block), len(piece) - self._n_last)
            piece[self._n_last : self._n_last + n] = block[:n]
            self._n_last += n
            block = block[n:]

    def values(self) -> AnyArray:
        """All pieces in one array."""
        last = self._pieces[-1:]
        if last and self._n_last < len(last[0]):
            last = [last[0][: self._n_last]]
        if len(self._pieces) != 1 or last[0] is not self._pieces[0]:
            whole = [*self._pieces[:-1], *last]
            self._pieces = [np.concatenate(whole) if whole else np.empty(0, self._kind)]
            self._n_last = len(self._pieces[0])
        return self._pieces[0]
