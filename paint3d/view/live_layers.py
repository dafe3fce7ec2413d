"""Pictures kept in graphics memory: the backdrop, and the object in front of it with its depth.

What is drawn over a kept picture need not draw it again: a brush that moves costs what the brush
costs. Kept pictures have the size and the form of the one that is drawn into, so that copying is
exact to the bit, depth included.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.errors import ExportError

if TYPE_CHECKING:
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

__all__ = ["Box", "KeptPicture", "Target"]

Box = tuple[int, int, int, int]

_COLOUR, _DEPTH = 0x4000, 0x0100  # OpenGL's bits and names
_NEAREST = 0x2600
_SCISSOR_TEST = 0x0C11
_BYTES, _DEPTH_BITS = 3, 32  # as VTK makes the picture it draws into


class KeptPicture:
    """A copy of the picture that a window draws into: colours and depths.

    Parameters
    ----------
    window : vtkRenderWindow
        It has drawn once at its present size.
    """

    def __init__(self, window: vtkRenderWindow) -> None:
        from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLFramebufferObject

        self._window, self.size = window, tuple(window.GetSize())
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

    def release(self) -> None:
        """Let go of the graphics memory."""
        self._window.MakeCurrent()
        self._kept.ReleaseGraphicsResources(self._window)

    def _copy(self, source: Any, target: Any, box: Box) -> None:
        self._window.MakeCurrent()
        state = self._window.GetState()
        state.PushFramebufferBindings()
        source.Bind(source.GetReadMode())
        source.ActivateReadBuffer(0)
        target.Bind(target.GetDrawMode())
        target.ActivateDrawBuffer(0)
        state.SetEnumState(_SCISSOR_TEST, False)
        x0, y0, x1, y1 = box
        place = (x0, x1, y0, y1)
        source.Blit(place, place, _COLOUR | _DEPTH, _NEAREST)
        state.PopFramebufferBindings()


class Target:
    """The picture that a window draws into.

    Parameters
    ----------
    window : vtkRenderWindow
    """

    def __init__(self, window: vtkRenderWindow) -> None:
        self._window = window

    def read(self, box: Box) -> NDArray[np.uint8]:
        """(H, W, 4) uint8: a box of its pixels, the first row at the bottom.

        Raises
        ------
        ExportError
            If OpenGL gives none.
        """
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        x0, y0, x1, y1 = box
        pixels = vtkUnsignedCharArray()
        self._window.GetRGBACharPixelData(x0, y0, x1 - 1, y1 - 1, 0, pixels)
        if pixels.GetNumberOfTuples() != (x1 - x0) * (y1 - y0):
            raise ExportError("nothing could be drawn: OpenGL gave no pixels")
        result: NDArray[np.uint8] = vtk_to_numpy(pixels).reshape(y1 - y0, x1 - x0, 4)
        return result

    def write(self, box: Box, pixels: AnyArray) -> None:
        """Put pixels (H, W, 4) uint8 there; depths stay as they are."""
        from vtkmodules.util.numpy_support import numpy_to_vtk

        x0, y0, x1, y1 = box
        array = numpy_to_vtk(np.ascontiguousarray(pixels).reshape(-1, 4), deep=True)
        self._window.GetState().SetEnumState(_SCISSOR_TEST, False)
        self._window.SetRGBACharPixelData(x0, y0, x1 - 1, y1 - 1, array, 0, 0, 0)
