"""How the colours of a painting came about: what is kept while it is painted, for a film of it."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Growth"]

_IN_MEMORY = 64_000_000  # bytes; more goes to the disk
_ROUND = 1e-9


class Growth:
    """The colours of a surface at equal steps of time, kept as what changed; used with `with`.

    Vertices that come later are shown from the beginning, bare until something is painted on them.
    Nothing that is painted becomes otherwise by being looked at.

    Parameters
    ----------
    surface : PaintedSurface
        As the film begins.
    step_s : float
        Between two pictures, s of the painting's own time.

    Attributes
    ----------
    surface : PaintedSurface
    """

    def __init__(self, surface: PaintedSurface, step_s: float) -> None:
        self.surface, self._step_s = surface, step_s
        self._start = surface.srgb.copy()
        self._last = self._start
        self._lengths: list[int] = []
        self._file = tempfile.SpooledTemporaryFile(max_size=_IN_MEMORY)  # noqa: SIM115

    def __enter__(self) -> Growth:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    @property
    def n_pictures(self) -> int:
        """How many there are by now; the first is as the film begins."""
        return 1 + len(self._lengths)

    def at(self, seconds: float) -> None:
        """Keep what is there, if it is time for a picture, or for more than one.

        Parameters
        ----------
        seconds : float
            Since the beginning; does not go back.
        """
        due = math.floor(seconds / self._step_s + _ROUND) - len(self._lengths)
        if due > 0:
            self._lengths += [0] * (due - 1)
            self._keep()

    def end(self, seconds: float) -> None:
        """Keep what is there as the last picture."""
        self.at(seconds)
        self._keep()

    def _keep(self) -> None:
        now, last = self.surface.srgb, self._last
        changed = np.flatnonzero((now[: len(last)] != last).any(axis=1))
        ids = np.concatenate([changed, np.arange(len(last), len(now))]).astype(np.int32)
        self._file.write(ids.tobytes() + now[ids].tobytes())
        self._lengths.append(len(ids))
        self._last = now.copy()

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """The colours (V, 3) of each picture, of all vertices there are in the end.

        What comes out is another one's next time: it is to be used before the next is asked for.
        """
        codes = self.surface.bare_codes
        codes[: len(self._start)] = self._start
        yield codes
        self._file.seek(0)
        for n in self._lengths:
            ids = np.frombuffer(self._file.read(4 * n), np.int32)
            codes[ids] = np.frombuffer(self._file.read(3 * n), np.uint8).reshape(n, 3)
            yield codes
