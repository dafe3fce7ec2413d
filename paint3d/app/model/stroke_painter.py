"""Strokes with their mirror and radial images, painted where the mask lets paint be taken."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.input.symmetry import Symmetry, transform_samples
from paint3d.app.model.mask import Mask, Stencil
from paint3d.core.arrays import AnyArray
from paint3d.device.sample import DeviceSample
from paint3d.painter.painter import Painter
from paint3d.surface.eraser import Eraser
from paint3d.surface.undo import UndoHistory

__all__ = ["ImagePainter", "StrokePainter"]


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
        state = painter.keep()
        del state["hairs"]  # the twin has its own, in which the same is
        self._twin.restore({**state, "loaded": 0.0})
        ink = self._surface.ink
        self._held = ink.load.copy(), ink.reservoirs.copy()
        painter.loaded += painter.in_brush()

    def schedule(
        self, loads: Sequence[tuple[int, float]], strengths: Sequence[tuple[int, float]]
    ) -> None:
        """See `Painter.schedule`."""
        self._twin.schedule(loads, strengths)

    def advance(
        self, samples: Sequence[DeviceSample], then: Callable[[], None] = lambda: None
    ) -> None:
        """Paint the image of what the hand did, and do something while this brush is in hand."""
        moved = transform_samples(samples, self._image)
        with self._exchange_ink():
            self._twin.advance(moved)
            then()

    def lift(self, then: Callable[[], None] = lambda: None) -> None:
        """Paint what still waits, though the stroke goes on, and do something as in `advance`."""
        with self._exchange_ink():
            self._twin.lift()
            then()

    def finish(self, then: Callable[[], None] = lambda: None) -> None:
        """Paint what still waits, do something, and wash the brush out."""
        with self._exchange_ink():
            self._twin.finish()
            then()
        self._painter.loaded -= self._surface.lasting(self._pad_ink(*self._held)[0])

    @contextmanager
    def _exchange_ink(self) -> Iterator[None]:
        """Use this brush's ink instead of the hand's, within."""
        surface = self._surface
        own = surface.ink.load.copy(), surface.ink.reservoirs
        self._put_ink(*self._held)
        loaded = self._twin.loaded
        try:
            yield
        finally:  # the hand's ink is never left with an image
            self._held = surface.ink.load.copy(), surface.ink.reservoirs
            self._put_ink(*own)
            self._painter.loaded += self._twin.loaded - loaded  # it may have been dipped

    def _pad_ink(self, load: AnyArray, reservoirs: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Ink of a brush padded with columns for pigments added since."""
        missing = len(self._surface.pigments) - len(load)
        return np.pad(load, (0, missing)), np.pad(reservoirs, ((0, 0), (0, missing)))

    def _put_ink(self, load: AnyArray, reservoirs: AnyArray) -> None:
        surface = self._surface
        surface.ink.load[:], reservoirs = self._pad_ink(load, reservoirs)
        surface.ink = surface.ink._replace(reservoirs=reservoirs)


class StrokePainter:
    """Paints a stroke and its images, and wipes off what falls on the mask.

    Parameters
    ----------
    painter : Painter
    undo : UndoHistory
        Knows what was under a stroke.

    Attributes
    ----------
    symmetry : Symmetry
        Images of every stroke that begins from now on.
    mask : Mask
    stencil : Stencil or None
        The mask as it lies on the surface; None where paint is taken everywhere.
    """

    def __init__(self, painter: Painter, undo: UndoHistory) -> None:
        self._painter, self._undo = painter, undo
        self.symmetry = Symmetry()
        self.mask = Mask()
        self.stencil: Stencil | None = None
        self._images: list[ImagePainter] = []
        self._eraser: Eraser | None = None

    def set_mask(self, mask: Mask) -> None:
        """Take paint only where a mask allows.

        Raises
        ------
        InputError
            If it names a face that is not there.
        """
        self.stencil = None if mask.is_open else Stencil(self._painter.surface, mask)
        self.mask = mask

    def begin(
        self,
        loads: Sequence[tuple[int, float]],
        strengths: Sequence[tuple[int, float]],
        *,
        erase: bool = False,
    ) -> None:
        """Begin a stroke with the brush's ink known, or one that erases.

        See `Painter.schedule` and `Eraser`.
        """
        self._eraser = Eraser(self._painter.surface) if erase else None
        self._images = [ImagePainter(self._painter, image) for image in self.symmetry.images()]
        self._painter.schedule(loads, strengths)
        for image in self._images:
            image.schedule(loads, strengths)

    def advance(self, samples: Sequence[DeviceSample]) -> None:
        """Paint samples, in the order of time."""
        alone = self.stencil is None and self._eraser is None and not self._images
        # else who comes first would matter
        for batch in [samples] if alone else [[sample] for sample in samples]:
            self._painter.advance(batch)
            self._wipe()
            for image in self._images:
                image.advance(batch, self._wipe)

    def lift(self) -> None:
        """Paint what still waits, though the stroke goes on elsewhere."""
        self._painter.lift()
        self._wipe()
        for image in self._images:
            image.lift(self._wipe)

    def finish(self) -> None:
        """Paint what still waits, and end the stroke."""
        self._painter.finish()
        self._wipe()
        for image in self._images:
            image.finish(self._wipe)
        self._images, self._eraser = [], None

    def abandon(self) -> None:
        """Forget the stroke; undo takes back what is painted of it."""
        self._painter.abandon()
        self._images, self._eraser = [], None

    def _wipe(self) -> None:
        if self.stencil is not None:
            self.stencil.wipe(self._undo.before)
        if self._eraser is not None:
            self._painter.loaded -= self._eraser.wipe()
