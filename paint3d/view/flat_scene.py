"""A painting without light: every colour as it was painted, in a parallel projection, to scale."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.errors import ExportError
from paint3d.view.scene import MOST_PIXELS, join_pixels, quiet_vtk

__all__ = ["Frame", "draw_flat"]

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
    import pyvista as pv

    seen = (vertices @ frame.axes.T).astype(np.float32)
    deep = max(float(np.ptp(seen[:, 2])), 1e-3 * frame.height)
    scale = _FINER if max(size) * _FINER <= MOST_PIXELS else 1
    drawn = tuple(scale * n for n in size)
    with quiet_vtk():
        plotter = pv.Plotter(off_screen=True, window_size=drawn, lighting="none")
        try:
            plotter.set_background("white")
            mesh = pv.PolyData.from_regular_faces(seen, faces)
            mesh.point_data["srgb"] = srgb
            plotter.add_mesh(mesh, scalars="srgb", rgb=True, lighting=False)
            x, y = frame.middle.tolist()
            middle = float(seen[:, 2].max() + seen[:, 2].min()) / 2
            camera = plotter.camera
            camera.parallel_projection = True
            camera.parallel_scale = frame.height / 2
            camera.focal_point = (x, y, middle)
            camera.position = (x, y, middle + _FAR * deep)
            camera.up = (0.0, 1.0, 0.0)
            plotter.renderer.ResetCameraClippingRange()
            pixels = plotter.screenshot(return_img=True, transparent_background=transparent)
        except RuntimeError as cause:
            raise ExportError(f"no picture could be drawn with OpenGL: {cause}") from None
        finally:
            plotter.close()
    return join_pixels(pixels, scale, transparent)
