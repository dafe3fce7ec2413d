"""How the colours of a painting came about: what is kept while it is painted, for a film of it."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.studio import Gloss

__all__ = ["Grown", "Growth"]

_IN_MEMORY = 64_000_000  # bytes; more goes to the disk
_ROUND = 1e-9


class Grown(NamedTuple):
    """One picture: colours as they are seen, and roughness, None where all is as the material."""

    srgb: NDArray[np.uint8]  # (V, 3)
    roughness: NDArray[np.float32] | None  # (V,)


class Growth:
    """How a surface looked at equal steps of time, kept as what changed; used with `with`.

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
        self._material = Gloss.of(surface.material).seen_roughness
        self._is_plain = True  # nothing was wet, and all ink dried as its material is
        self._start = self._seen()
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
        now, last = self._seen(), self._last
        changed = np.flatnonzero((now[: len(last)] != last).any(axis=1))
        ids = np.concatenate([changed, np.arange(len(last), len(now))]).astype(np.int32)
        self._file.write(ids.tobytes() + now[ids].tobytes())
        self._lengths.append(len(ids))
        self._last = now

    def _seen(self) -> NDArray[np.uint8]:
        """(V, 4): colours as they are seen, and roughness in steps of 1/255."""
        codes, look = self.surface.srgb, self.surface.wet_look
        if look is None:
            return self._with_roughness(codes, self._material)
        self._is_plain = False
        return self._with_roughness(look.seen(codes), look.roughness(self._material))

    @staticmethod
    def _with_roughness(codes: AnyArray, roughness: AnyArray | float) -> NDArray[np.uint8]:
        seen = np.empty((len(codes), 4), np.uint8)
        seen[:, :3], seen[:, 3] = codes, np.rint(255.0 * np.asarray(roughness))
        return seen

    def pictures(self) -> Iterator[Grown]:
        """Each picture, of all vertices there are in the end.

        What comes out is another one's next time: it is to be used before the next is asked for.
        """
        seen = self._with_roughness(self.surface.bare_codes, self._material)
        seen[: len(self._start)] = self._start
        yield self._grown(seen)
        self._file.seek(0)
        for n in self._lengths:
            ids = np.frombuffer(self._file.read(4 * n), np.int32)
            seen[ids] = np.frombuffer(self._file.read(4 * n), np.uint8).reshape(n, 4)
            yield self._grown(seen)

    def _grown(self, seen: NDArray[np.uint8]) -> Grown:
        rough = None if self._is_plain else seen[:, 3].astype(np.float32) / np.float32(255.0)
        return Grown(seen[:, :3], rough)
