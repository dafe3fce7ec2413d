"""A brush that paints the image of a stroke, with ink of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.input.symmetry import transformed
from paint3d.core.arrays import AnyArray
from paint3d.device.sample import DeviceSample
from paint3d.painter.painter import Painter

__all__ = ["ImagePainter"]


class ImagePainter:
    """Paints what a hand does in one of its images, on the same surface, for one stroke.

    It starts with as much ink as the hand's own brush holds, and what it has left is washed out at
    the end. Both are in the hand's ledger, so that one still closes.

    Parameters
    ----------
    painter : Painter
        The hand's own.
    image : (4, 4) float64
        See `Symmetry.images`.
    """

    def __init__(self, painter: Painter, image: NDArray[np.float64]) -> None:
        self._painter = painter
        self._surface = painter.surface
        self._image = image
        hairs = 0 if painter.hairs is None else painter.hairs.spec
        self._twin = Painter(self._surface, painter.brush, None, painter.azimuth, hairs=hairs)
        kept = painter.keep()
        del kept["hairs"]  # the twin has its own, in which the same is
        self._twin.restore({**kept, "loaded": 0.0})
        ink = self._surface.ink
        self._held = ink.load.copy(), ink.reservoirs.copy()
        painter.loaded += painter.in_brush()

    def expect(
        self, loads: Sequence[tuple[int, float]], strengths: Sequence[tuple[int, float]]
    ) -> None:
        """See `Painter.expect`."""
        self._twin.expect(loads, strengths)

    def advance(
        self, samples: Sequence[DeviceSample], then: Callable[[], None] = lambda: None
    ) -> None:
        """Paint the image of what the hand did, and do something while this brush is in hand."""
        moved = transformed(samples, self._image)
        with self._as_twin():
            self._twin.advance(moved)
            then()

    def lift(self, then: Callable[[], None] = lambda: None) -> None:
        """Paint what still waits, though the stroke goes on, and do something as in `advance`."""
        with self._as_twin():
            self._twin.lift()
            then()

    def finish(self, then: Callable[[], None] = lambda: None) -> None:
        """Paint what still waits, do something, and wash the brush out."""
        with self._as_twin():
            self._twin.finish()
            then()
        self._painter.loaded -= self._surface.lasting(self._fitting()[0])

    @contextmanager
    def _as_twin(self) -> Iterator[None]:
        """Within, this brush's ink is there instead of the hand's."""
        surface = self._surface
        own = surface.ink.load.copy(), surface.ink.reservoirs
        self._put(*self._fitting())
        loaded = self._twin.loaded
        try:
            yield
        finally:  # the hand's ink is never left with an image
            self._held = surface.ink.load.copy(), surface.ink.reservoirs
            self._put(*own)
            self._painter.loaded += self._twin.loaded - loaded  # it may have been dipped

    def _fitting(self) -> tuple[AnyArray, AnyArray]:
        """What this brush holds, of all pigments that are known by now."""
        load, reservoirs = self._held
        missing = len(self._surface.pigments) - len(load)
        return np.pad(load, (0, missing)), np.pad(reservoirs, ((0, 0), (0, missing)))

    def _put(self, load: AnyArray, reservoirs: AnyArray) -> None:
        surface = self._surface
        missing = len(surface.pigments) - len(load)
        surface.ink.load[:] = np.pad(load, (0, missing))
        surface.ink = surface.ink._replace(reservoirs=np.pad(reservoirs, ((0, 0), (0, missing))))
