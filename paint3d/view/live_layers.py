"""Cached framebuffers in graphics memory: the backdrop, and the object in front of it with depth.

What is drawn over a cached picture need not draw it again: a moving brush costs no more than the
brush. Cached framebuffers have the size and format of the render target, so that copying is
bit-exact, depth included.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import ExportError
from paint3d.view.kernels.enlarge import enlarge

if TYPE_CHECKING:
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

__all__ = ["Box", "Enlarger", "KeptPicture", "LastPicture", "Target", "joined_box"]

Box = tuple[int, int, int, int]

_COLOUR, _DEPTH = 0x4000, 0x0100  # OpenGL's bits and enums
_NEAREST, _LINEAR = 0x2600, 0x2601
_SCISSOR_TEST = 0x0C11
_BYTES, _DEPTH_BITS = 3, 32  # as in VTK's own render framebuffer


def joined_box(boxes: Iterable[Box | None]) -> Box | None:
    """Return the smallest box around all boxes; None if there is none."""
    given = [box for box in boxes if box is not None]
    if not given:
        return None
    low, high = np.array(given)[:, :2].min(axis=0), np.array(given)[:, 2:].max(axis=0)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


class KeptPicture:
    """A copy of a window's render framebuffer: colours and depths.

    Parameters
    ----------
    window : vtkRenderWindow
        It must have drawn once at its present size.
    depth : bool
        Whether depths are copied too.
    """

    def __init__(self, window: vtkRenderWindow, *, depth: bool = True) -> None:
        from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLFramebufferObject

        self._window, self.size = window, tuple(window.GetSize())
        self._parts = _COLOUR | _DEPTH if depth else _COLOUR
        self._kept = vtkOpenGLFramebufferObject()
        self._kept.SetContext(window)
        window.MakeCurrent()
        samples = window.GetRenderFramebuffer().GetMultiSamples()
        stencil = bool(window.GetStencilCapable())
        if not self._kept.PopulateFramebuffer(
            *self.size, True, 1, _BYTES, True, _DEPTH_BITS, samples, stencil
        ):
            raise ExportError("nothing can be drawn: OpenGL gave no room for a picture")

    def keep(self, box: Box) -> None:
        """Copy a box of pixels from the window."""
        self._copy(self._window.GetRenderFramebuffer(), self._kept, box)

    def give(self, box: Box) -> None:
        """Copy a box of pixels back to the window."""
        self._copy(self._kept, self._window.GetRenderFramebuffer(), box)

    def spread(self, small: Box, box: Box) -> None:
        """Scale the box `small` of the window up to all of it, clipped to `box`.

        What was copied in the small box is lost.
        """
        self._copy(self._window.GetRenderFramebuffer(), self._kept, small)
        state = self._window.GetState()
        x0, y0, x1, y1 = box
        state.vtkglScissor(x0, y0, x1 - x0, y1 - y0)
        whole = (0, 0, *self.size)
        source, target = self._kept, self._window.GetRenderFramebuffer()
        self._blit(source, target, (small, whole), (_COLOUR, _LINEAR), clipped=True)
        self._blit(source, target, (small, whole), (_DEPTH, _NEAREST), clipped=True)

    def give_enlarged(self, box: Box, large: Box) -> None:
        """Copy the colours of a box of pixels to a larger box of the window, without depths."""
        target = self._window.GetRenderFramebuffer()
        self._blit(self._kept, target, (box, large), (_COLOUR, _NEAREST))

    def release(self) -> None:
        """Release the graphics memory."""
        self._window.MakeCurrent()
        self._kept.ReleaseGraphicsResources(self._window)

    def _copy(self, source: Any, target: Any, box: Box) -> None:
        self._blit(source, target, (box, box), (self._parts, _NEAREST))

    def _blit(
        self,
        source: Any,
        target: Any,
        boxes: tuple[Box, Box],
        how: tuple[int, int],
        *,
        clipped: bool = False,
    ) -> None:
        """Blit from one box to another; `how` is OpenGL's buffer bits and filter."""
        self._window.MakeCurrent()
        state = self._window.GetState()
        state.PushFramebufferBindings()
        source.Bind(source.GetReadMode())
        source.ActivateReadBuffer(0)
        target.Bind(target.GetDrawMode())
        target.ActivateDrawBuffer(0)
        state.SetEnumState(_SCISSOR_TEST, clipped)
        source.Blit(*((x0, x1, y0, y1) for x0, y0, x1, y1 in boxes), *how)
        state.PopFramebufferBindings()


class LastPicture(KeptPicture):
    """A lazy `KeptPicture`: copied only when the window is about to draw over it.

    While nothing else is drawn, the window's own framebuffer holds the picture: an object that
    turns without a brush is copied neither there nor back.

    Attributes
    ----------
    is_lost : bool
        Whether it was drawn over without being copied, and has not been redrawn since.
    """

    def __init__(self, window: vtkRenderWindow) -> None:
        super().__init__(window)
        self._due: Box | None = None  # drawn by the window, and not yet copied
        self._covered: Box | None = None  # where the window shows something else
        self.is_lost = False

    def keep(self, box: Box) -> None:
        """Register a box of pixels that the window has drawn; it is copied when needed."""
        self._covered = _without(self._covered, box)
        if self._covered is None:
            self._due, self.is_lost = joined_box((self._due, box)), False
        else:
            super().keep(box)

    def cover(self, box: Box, *, keep: bool = True) -> None:
        """Prepare for the window to draw something else in a box.

        The picture is copied or, without `keep`, lost: it must be redrawn before `give`.
        """
        if self._due is not None and keep:
            super().keep(self._due)
        self.is_lost = self.is_lost or not keep
        self._due = None
        self._covered = joined_box((self._covered, box))

    def give(self, box: Box) -> None:
        """Copy a box of pixels back to the window, if that shows something else there."""
        if self._covered is not None:
            super().give(box)
            self._covered = _without(self._covered, box)


class Enlarger:
    """Bilinear enlargement from one size to another, with precomputed weights.

    Parameters
    ----------
    small, large : (int, int)
        Widths and heights, pixels.
    """

    def __init__(self, small: tuple[int, int], large: tuple[int, int]) -> None:
        self._columns, self._across = _between(small[0], large[0])
        self._rows, self._down = _between(small[1], large[1])
        self._mixed = np.empty(small[0] + 1, np.uint64)

    def enlarge(self, pixels: NDArray[np.uint8], out: NDArray[np.uint8]) -> None:
        """Enlarge (h, w, 4), the first row at the bottom, to (H, W, 4), the first row at the top.

        Both are C-contiguous.
        """
        small, large = (a.view(np.uint32)[..., 0] for a in (pixels, out))
        enlarge(small, self._rows, self._down, self._columns, self._across, self._mixed, large)


def _between(few: int, many: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return the source pixel before each of `many` and the fraction past it, in 1/256: (many,)."""
    place = np.clip((np.arange(many) + 0.5) * few / many - 0.5, 0.0, few - 1.0)
    before = place.astype(np.int32)
    return before, np.rint(256.0 * (place - before)).astype(np.int32)


def _without(box: Box | None, taken: Box) -> Box | None:
    """Return None if `taken` holds all of a box, else the box unchanged."""
    if box is None:
        return None
    low = taken[0] <= box[0] and taken[1] <= box[1]
    return None if low and taken[2] >= box[2] and taken[3] >= box[3] else box


class Target:
    """Pixel access to a window's render framebuffer.

    Parameters
    ----------
    window : vtkRenderWindow
    """

    def __init__(self, window: vtkRenderWindow) -> None:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        self._window = window
        self._pixels, self._as_array = vtkUnsignedCharArray(), vtk_to_numpy

    def read(self, box: Box) -> NDArray[np.uint8]:
        """Return a box of pixels (H, W, 4) uint8, bottom row first; valid until the next call.

        Raises
        ------
        ExportError
            If OpenGL returns none.
        """
        x0, y0, x1, y1 = box
        pixels = self._pixels  # reused: VTK allocates only if the size changes
        self._window.GetRGBACharPixelData(x0, y0, x1 - 1, y1 - 1, 0, pixels)
        if pixels.GetNumberOfTuples() != (x1 - x0) * (y1 - y0):
            raise ExportError("nothing could be drawn: OpenGL gave no pixels")
        result: NDArray[np.uint8] = self._as_array(pixels).reshape(y1 - y0, x1 - x0, 4)
        return result

    def write(self, box: Box, pixels: AnyArray) -> None:
        """Write pixels (H, W, 4) uint8 to a box; depths are unchanged."""
        from vtkmodules.util.numpy_support import numpy_to_vtk

        x0, y0, x1, y1 = box
        array = numpy_to_vtk(np.ascontiguousarray(pixels).reshape(-1, 4), deep=True)
        self._window.GetState().SetEnumState(_SCISSOR_TEST, False)
        self._window.SetRGBACharPixelData(x0, y0, x1 - 1, y1 - 1, array, 0, 0, 0)
