"""A painting without light: every colour as it was painted, in a parallel projection, to scale."""

from __future__ import annotations

from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.view.scene import MOST_PIXELS, join_pixels, quiet_vtk, told_of_opengl

__all__ = ["FlatDrawing", "Frame", "draw_flat"]

_FINER = 3
_FAR = 4.0  # depths of the object that the camera stands away


class Frame(NamedTuple):
    """The part of a projection that is drawn.

    Attributes
    ----------
    axes : (3, 3) array
        Unit rows: right and up in the picture, and toward the viewer.
    middle : (2,) array
        Of the picture, mm along right and up.
    height : float
        Of the picture, mm.
    """

    axes: NDArray[np.float64]
    middle: NDArray[np.float64]
    height: float


def draw_flat(
    vertices: AnyArray,
    faces: AnyArray,
    srgb: AnyArray,
    frame: Frame,
    size: tuple[int, int],
    transparent: bool = False,
) -> NDArray[np.uint8]:
    """Return the pixels of a projection on white, (height, width, 3), or on nothing, four.

    Parameters
    ----------
    vertices : (V, 3) float32
        mm.
    faces : (F, 3) int32
    srgb : (V, 3) uint8
        Mixed along edges as codes, as files show them.
    frame : Frame
    size : (int, int)
        Width and height in pixels; those are square, so the width is what follows.
    transparent : bool

    Raises
    ------
    ExportError
        If no OpenGL can be started.
    """
    with FlatDrawing(faces, frame, size, transparent) as drawing:
        return drawing.pixels(vertices, srgb)


class FlatDrawing:
    """A projection that is drawn again and again, in other colours or turned; used with `with`.

    Parameters
    ----------
    faces, frame, size, transparent
        As for `draw_flat`.

    Raises
    ------
    ExportError
        If no OpenGL can be started.
    """

    def __init__(
        self, faces: AnyArray, frame: Frame, size: tuple[int, int], transparent: bool = False
    ) -> None:
        self._faces, self._frame, self._transparent = faces, frame, transparent
        self._scale = _FINER if max(size) * _FINER <= MOST_PIXELS else 1
        self._size = tuple(self._scale * n for n in size)
        self._plotter: Any = None
        self._mesh: Any = None

    def __enter__(self) -> Self:
        with quiet_vtk(), told_of_opengl():
            import pyvista as pv

            self._plotter = pv.Plotter(off_screen=True, window_size=self._size, lighting="none")
            self._plotter.set_background("white")
        return self

    def __exit__(self, *_: object) -> None:
        self._plotter.close()

    def pixels(self, vertices: AnyArray, srgb: AnyArray) -> NDArray[np.uint8]:
        """The pixels as `draw_flat` returns them; of as many vertices every time."""
        import pyvista as pv

        seen = (vertices @ self._frame.axes.T).astype(np.float32)
        plotter = self._plotter
        with quiet_vtk(), told_of_opengl():
            if self._mesh is None:
                mesh = self._mesh = pv.PolyData.from_regular_faces(seen, self._faces)
                mesh.point_data["srgb"] = srgb
                plotter.add_mesh(mesh, scalars="srgb", rgb=True, lighting=False)
            else:
                self._mesh.points[:] = seen
                self._mesh.GetPoints().Modified()
                self._mesh.point_data["srgb"][:] = srgb
                self._mesh.GetPointData().GetScalars().Modified()
            self._place_camera(seen)
            plotter.render()
            shown = plotter.screenshot(return_img=True, transparent_background=self._transparent)
        return join_pixels(shown, self._scale, self._transparent)

    def _place_camera(self, seen: AnyArray) -> None:
        frame, camera = self._frame, self._plotter.camera
        deep = max(float(np.ptp(seen[:, 2])), 1e-3 * frame.height)
        x, y = frame.middle.tolist()
        middle = float(seen[:, 2].max() + seen[:, 2].min()) / 2
        camera.parallel_projection = True
        camera.parallel_scale = frame.height / 2
        camera.focal_point = (x, y, middle)
        camera.position = (x, y, middle + _FAR * deep)
        camera.up = (0.0, 1.0, 0.0)
        self._plotter.renderer.ResetCameraClippingRange()
