"""Pictures kept in graphics memory: the backdrop, and the object in front of it with its depth.

What is drawn over a kept picture need not draw it again: a brush that moves costs what the brush
costs. Kept pictures have the size and the form of the one that is drawn into, so that copying is
exact to the bit, depth included.
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

_COLOUR, _DEPTH = 0x4000, 0x0100  # OpenGL's bits and names
_NEAREST, _LINEAR = 0x2600, 0x2601
_SCISSOR_TEST = 0x0C11
_BYTES, _DEPTH_BITS = 3, 32  # as VTK makes the picture it draws into


def joined_box(boxes: Iterable[Box | None]) -> Box | None:
    """The smallest box around some; None around none."""
    there = [box for box in boxes if box is not None]
    if not there:
        return None
    low, high = np.array(there)[:, :2].min(axis=0), np.array(there)[:, 2:].max(axis=0)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


class KeptPicture:
    """A copy of the picture that a window draws into: colours and depths.

    Parameters
    ----------
    window : vtkRenderWindow
        It has drawn once at its present size.
    depth : bool
        Whether depths are kept: not where nothing has one.
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
        """Take a box of pixels of what the window has drawn."""
        self._copy(self._window.GetRenderFramebuffer(), self._kept, box)

    def give(self, box: Box) -> None:
        """Put a box of pixels back where the window draws."""
        self._copy(self._kept, self._window.GetRenderFramebuffer(), box)

    def spread(self, small: Box, box: Box) -> None:
        """Spread a box of what the window has drawn over all of it, as far as it lies in another.

        What was kept in the small box is lost.
        """
        self._copy(self._window.GetRenderFramebuffer(), self._kept, small)
        state = self._window.GetState()
        x0, y0, x1, y1 = box
        state.vtkglScissor(x0, y0, x1 - x0, y1 - y0)
        whole = (0, 0, *self.size)
        source, target = self._kept, self._window.GetRenderFramebuffer()
        self._blit(source, target, (small, whole), (_COLOUR, _LINEAR), clipped=True)
        self._blit(source, target, (small, whole), (_DEPTH, _NEAREST), clipped=True)

    def release(self) -> None:
        """Let go of the graphics memory."""
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
        """Copy from one box to another what OpenGL's bits name, as its filter does."""
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
    """A kept picture that is copied only when the window draws over it.

    While nothing else is drawn, the window's own picture is the one: an object that turns without a
    brush is copied neither there nor back.

    Attributes
    ----------
    is_lost : bool
        Whether it was drawn over without being copied, and has not been drawn again since.
    """

    def __init__(self, window: vtkRenderWindow) -> None:
        super().__init__(window)
        self._due: Box | None = None  # drawn by the window, and not copied
        self._covered: Box | None = None  # where the window shows something else
        self.is_lost = False

    def keep(self, box: Box) -> None:
        """Take a box of pixels of what the window has drawn, before they are drawn over."""
        self._covered = _without(self._covered, box)
        if self._covered is None:
            self._due, self.is_lost = joined_box((self._due, box)), False
        else:
            super().keep(box)

    def cover(self, box: Box, *, keep: bool = True) -> None:
        """Be told that the window is about to draw something else in a box.

        What was there is kept, or lost: then all of it must be drawn before it is asked for.
        """
        if self._due is not None and keep:
            super().keep(self._due)
        self.is_lost = self.is_lost or not keep
        self._due = None
        self._covered = joined_box((self._covered, box))

    def give(self, box: Box) -> None:
        """Put a box of pixels back where the window draws, if it shows something else there."""
        if self._covered is not None:
            super().give(box)
            self._covered = _without(self._covered, box)


class Enlarger:
    """Spreads a picture over one of more pixels; keeps what that is reckoned with.

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
        """Spread (h, w, 4), the first row at the bottom, over (H, W, 4), the first row at the top.

        Both are C-contiguous.
        """
        small, large = (a.view(np.uint32)[..., 0] for a in (pixels, out))
        enlarge(small, self._rows, self._down, self._columns, self._across, self._mixed, large)


def _between(few: int, many: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Which of a few pixels many more begin after, and how far on they lie, of 256: (many,)."""
    place = np.clip((np.arange(many) + 0.5) * few / many - 0.5, 0.0, few - 1.0)
    before = place.astype(np.int32)
    return before, np.rint(256.0 * (place - before)).astype(np.int32)


def _without(box: Box | None, taken: Box) -> Box | None:
    """A box of which another is taken away: none if that holds all of it, else as it was."""
    if box is None:
        return None
    low = taken[0] <= box[0] and taken[1] <= box[1]
    return None if low and taken[2] >= box[2] and taken[3] >= box[3] else box


class Target:
    """The picture that a window draws into.

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
        """(H, W, 4) uint8: a box of its pixels, the first row at the bottom; until the next call.

        Raises
        ------
        ExportError
            If OpenGL gives none.
        """
        x0, y0, x1, y1 = box
        pixels = self._pixels  # of the same size no memory is asked for
        self._window.GetRGBACharPixelData(x0, y0, x1 - 1, y1 - 1, 0, pixels)
        if pixels.GetNumberOfTuples() != (x1 - x0) * (y1 - y0):
            raise ExportError("nothing could be drawn: OpenGL gave no pixels")
        result: NDArray[np.uint8] = self._as_array(pixels).reshape(y1 - y0, x1 - x0, 4)
        return result

    def write(self, box: Box, pixels: AnyArray) -> None:
        """Put pixels (H, W, 4) uint8 there; depths stay as they are."""
        from vtkmodules.util.numpy_support import numpy_to_vtk

        x0, y0, x1, y1 = box
        array = numpy_to_vtk(np.ascontiguousarray(pixels).reshape(-1, 4), deep=True)
        self._window.GetState().SetEnumState(_SCISSOR_TEST, False)
        self._window.SetRGBACharPixelData(x0, y0, x1 - 1, y1 - 1, array, 0, 0, 0)
