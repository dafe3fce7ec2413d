"""Lines of a text from strangers, counted and limited: one by one, or many as one block.

A line may be 64 KiB long and a file 512 MiB, decompressed, so that none exhausts the machine.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from typing import BinaryIO

from paint3d.errors import RecordingError

__all__ = ["TextLines"]

_MAX_LINE = 1 << 16
_MAX_BYTES = 1 << 29
_BLOCK = 1 << 21  # bytes
_TELL_EVERY = 1 << 14  # lines
_MARK = b"\xef\xbb\xbf"  # that some programs put before UTF-8


class TextLines:
    """Iterates over (number from 1, text) of the lines that were not handed out as a block yet.

    Parameters
    ----------
    stream : binary file
    name : str
        Of the file, for messages.
    told : callable, optional
        Called now and then while lines are read.

    Raises
    ------
    RecordingError
        When iterated over: ``name:line: what is wrong``.
    """

    def __init__(self, stream: BinaryIO, name: str, told: Callable[[], None] | None = None) -> None:
        self._stream, self._name, self._told = stream, name, told
        self._number = self._n_bytes = 0

    def __iter__(self) -> Iterator[tuple[int, str]]:
        return self

    def __next__(self) -> tuple[int, str]:
        line = self._stream.readline(_MAX_LINE + 1)
        if not line:
            raise StopIteration
        self._number += 1
        if self._told is not None and self._number % _TELL_EVERY == 0:
            self._told()
        self._n_bytes += len(line)
        return self._number, self._checked(line, self._number, self._n_bytes)

    def block(self) -> tuple[int, bytes]:
        """The number of the next line, and some 2 MiB of whole lines; none at the end.

        What is in them is not looked at: `cut` does that.

        Raises
        ------
        RecordingError
            If the file is too long.
        """
        if self._told is not None:
            self._told()
        data = self._stream.read(_BLOCK)
        if data and not data.endswith(b"\n"):
            data += self._stream.readline(_MAX_LINE + 1)
        first = self._number + 1
        if self._n_bytes + len(data) > _MAX_BYTES:
            for _ in self.cut(first, data):  # some line is one too many, or wrong before that
                pass
        self._number += data.count(b"\n") + (not data.endswith(b"\n"))
        self._n_bytes += len(data)
        return first, data.removeprefix(_MARK) if first == 1 else data

    def cut(self, first: int, data: bytes) -> Iterator[tuple[int, str]]:
        """Numbers and texts of the lines in a block whose first has the number `first`.

        Raises
        ------
        RecordingError
            ``name:line: what is wrong``.
        """
        n_bytes = 0 if first <= self._number else self._n_bytes  # those of blocks before are known
        lines = io.BytesIO(data)
        for number, line in enumerate(iter(lambda: lines.readline(_MAX_LINE + 1), b""), first):
            n_bytes += len(line)
            yield number, self._checked(line, number, n_bytes)

    def _checked(self, line: bytes, number: int, n_bytes: int) -> str:
        """A line's text; `n_bytes` were read with it."""
        if len(line) > _MAX_LINE:
            raise RecordingError(
                f"{self._name}:{number}: the line is longer than {_MAX_LINE} bytes"
            )
        if n_bytes > _MAX_BYTES:
            raise RecordingError(
                f"{self._name}:{number}: the file is longer than {_MAX_BYTES} bytes once "
                "decompressed"
            )
        try:
            return line.decode("utf-8-sig" if number == 1 else "utf-8")
        except UnicodeDecodeError as cause:
            raise RecordingError(
                f"{self._name}:{number}: byte {cause.start} is not UTF-8; expected UTF-8 text"
            ) from None
