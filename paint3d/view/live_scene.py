"""The scene one paints in, drawn by VTK into pixels; no window system is needed.

Pixels rather than a native window: the same code runs under X11, Wayland and none, in tests and in
the desktop window, which lays its own pictures over them.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import ExportError
from paint3d.view.camera import Camera
from paint3d.view.live_light import BakedLight
from paint3d.view.live_object import PatchUpload
from paint3d.view.studio import Gloss
from paint3d.view.vtk_parts import DrawnMesh, camera_light, quiet_vtk

__all__ = ["DARK", "LIGHT", "Box", "LiveScene", "Mood", "joined_box"]

_SHADE = 0.55  # darkest the object's shade on the floor becomes
_MARGIN = 4  # pixels around what has changed: lines are wide, edges are smoothed
_FINE = 2  # times as many pixels across, averaged, once nothing moves any more
_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swr ")
_SAMPLES = 4  # a pixel, where a graphics card draws
_LIGHTS = (  # of what shines and of the brush; the object's own light is baked
    ((-0.55, 0.75, 1.0), 0.85, (1.0, 0.985, 0.96)),
    ((0.9, 0.25, 0.45), 0.35, (0.93, 0.96, 1.0)),
    ((0.1, 0.5, -0.7), 0.3, (1.0, 1.0, 1.0)),
)


Box = tuple[int, int, int, int]


@dataclass(frozen=True)
class Mood:
    """Colours around the object, sRGB in [0, 1]: at the picture's lower border and its upper."""

    below: tuple[float, float, float]
    above: tuple[float, float, float]


LIGHT = Mood((0.815, 0.805, 0.785), (0.640, 0.630, 0.612))
DARK = Mood((0.300, 0.296, 0.290), (0.150, 0.150, 0.154))


def joined_box(boxes: Iterable[Box | None]) -> Box | None:
    """The smallest box around some; None around none."""
    there = [box for box in boxes if box is not None]
    if not there:
        return None
    low, high = np.array(there)[:, :2].min(axis=0), np.array(there)[:, 2:].max(axis=0)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


class LiveScene:
    """Everything seen while painting.

    Parameters
    ----------
    size : (int, int)
        Width and height, pixels.
    mood : Mood

    Raises
    ------
    ExportError
        If OpenGL cannot be started.
    """

    def __init__(self, size: tuple[int, int] = (800, 600), mood: Mood = LIGHT) -> None:
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  gives the classes below their bodies
        from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

        quiet_vtk()
        self._window = vtkRenderWindow()
        self._window.SetOffScreenRendering(1)
        self._window.SetMultiSamples(0)
        self._window.SetSize(*size)
        self._size = size
        self.renderer = vtkRenderer()
        self._window.AddRenderer(self.renderer)
        self.renderer.SetAutomaticLightCreation(False)
        self._camera = Camera(
            np.array([0.0, -4.0, 0.0]), np.zeros(3), np.array([0.0, 0.0, 1.0]), np.radians(24.0)
        )
        self._pixels: NDArray | None = None
        for position, intensity, colour in _LIGHTS:
            self.renderer.AddLight(camera_light(position, intensity, colour))
        self.set_mood(mood)
        self.renderer_name = self._start()
        self.is_software = any(word in self.renderer_name.lower() for word in _SOFTWARE)
        if not self.is_software:
            self._window.SetMultiSamples(_SAMPLES)
        self._patches: dict[int, DrawnMesh] = {}
        self._ground: DrawnMesh | None = None
        self._gloss = Gloss.of("porcelain")
        self._bounds = np.zeros(3), 1.0
        self.uploaded = 0
        self.frame_s = 0.0

    def _start(self) -> str:
        """Start OpenGL; return the name of what draws."""
        self._window.Render()
        told = self._window.ReportCapabilities() or ""
        names = [line for line in told.splitlines() if "renderer string" in line]
        if not names:
            raise ExportError("nothing can be drawn: no OpenGL of version 3.2 or later was found")
        return names[0].partition(":")[2].strip()

    # -- what is in it ----------------------------------------------------------------------

    def set_mood(self, mood: Mood) -> None:
        """Change the colours around the object."""
        self.mood = mood
        self.renderer.GradientBackgroundOn()
        self._paint_backdrop(0.0, 1.0)
        self._pixels = None

    def _paint_backdrop(self, low: float, high: float) -> None:
        """Let the picture be drawn between two heights of the whole one, 0 to 1."""
        below, above = np.array(self.mood.below), np.array(self.mood.above)
        self.renderer.SetBackground(*(below + low * (above - below)))
        self.renderer.SetBackground2(*(below + high * (above - below)))

    def clear(self, centre: NDArray, radius: float, gloss: Gloss) -> None:
        """Take the object away; the next one lies within `radius` mm of `centre`."""
        for drawn in self._patches.values():
            self.renderer.RemoveActor(drawn.actor)
        self._patches = {}
        if self._ground is not None:
            self.renderer.RemoveActor(self._ground.actor)
            self._ground = None
        self._bounds = np.asarray(centre, np.float64), float(radius)
        self._pixels = None
        self.set_gloss(gloss)

    def set_gloss(self, gloss: Gloss) -> None:
        """Let the object shine as its material does."""
        self._gloss = gloss
        for drawn in self._patches.values():
            _shine(drawn.actor.GetProperty(), gloss)

    def apply(self, uploads: Iterable[PatchUpload]) -> int:
        """Take new arrays of some patches; return how many bytes they were."""
        n_bytes = 0
        for upload in uploads:
            drawn = self._patches.get(upload.patch)
            if drawn is None:
                drawn = self._patches[upload.patch] = DrawnMesh()
                _shine(drawn.actor.GetProperty(), self._gloss)
                self.renderer.AddActor(drawn.actor)
            if upload.faces is not None:
                drawn.set_shape(upload.points, upload.faces, upload.normals)
            drawn.set_colours(upload.colours)
            n_bytes += upload.n_bytes
        self.uploaded += n_bytes
        return n_bytes

    def add(self, drawn: DrawnMesh) -> None:
        """Show something else besides: a brush, a line."""
        self.renderer.AddActor(drawn.actor)

    def remove(self, drawn: DrawnMesh) -> None:
        """Show it no longer."""
        self.renderer.RemoveActor(drawn.actor)

    def set_ground(self, baked: BakedLight) -> None:
        """Let the object cast its soft shade on the floor, which is seen from above only."""
        if self._ground is not None:
            self.renderer.RemoveActor(self._ground.actor)
        ground, drawn = baked.ground, DrawnMesh()
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float64)
        points = (ground.origin + ground.half * corners) @ baked.axes
        drawn.set_shape(points, np.array([[0, 1, 2], [0, 2, 3]]))
        drawn.set_texture(_shade_pixels(ground.openness), corners[:, :2] * 0.5 + 0.5)
        look = drawn.actor.GetProperty()
        look.LightingOff()
        look.BackfaceCullingOn()
        drawn.actor.ForceTranslucentOn()
        self._ground = drawn
        self.renderer.AddActor(drawn.actor)

    # -- where it is seen from --------------------------------------------------------------

    def set_size(self, size: tuple[int, int]) -> None:
        """Change the width and height, pixels."""
        self._size = max(1, int(size[0])), max(1, int(size[1]))
        self._pixels = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self._size

    def set_camera(self, camera: Camera) -> None:
        """Look from there."""
        self._camera = camera
        self._pixels = None
        eye = self.renderer.GetActiveCamera()
        eye.SetPosition(*camera.position)
        eye.SetFocalPoint(*camera.focus)
        eye.SetViewUp(*camera.up)
        centre, radius = self._bounds
        ahead = np.asarray(camera.focus) - camera.position
        depth = float((centre - camera.position) @ (ahead / np.linalg.norm(ahead)))
        far = depth + 5.0 * radius
        eye.SetClippingRange(max(depth - 2.0 * radius, 0.002 * far), far)

    def screen_box(self, points: NDArray) -> Box | None:
        """The smallest box of pixels that points (N, 3) are seen in, y up; None if in none."""
        camera, (width, height) = self._camera, self._size
        back = camera.position - camera.focus
        back = back / np.linalg.norm(back)
        right = np.cross(camera.up, back)
        right /= np.linalg.norm(right)
        seen = (np.asarray(points, np.float64) - camera.position) @ np.stack(
            [right, np.cross(back, right), -back], axis=1
        )
        if len(seen) == 0 or seen[:, 2].min() <= 0.0:
            return (0, 0, width, height) if len(seen) else None
        scale = 0.5 * height / np.tan(0.5 * camera.view_angle) / seen[:, 2]
        x, y = 0.5 * width + scale * seen[:, 0], 0.5 * height + scale * seen[:, 1]
        x0, x1 = (int(np.clip(v, 0, width)) for v in (x.min() - _MARGIN, x.max() + _MARGIN))
        y0, y1 = (int(np.clip(v, 0, height)) for v in (y.min() - _MARGIN, y.max() + _MARGIN))
        return (x0, y0, x1, y1) if x1 > x0 and y1 > y0 else None

    def patch_box(self, patch: int) -> Box | None:
        """The box of pixels that a patch lies within."""
        low_x, high_x, low_y, high_y, low_z, high_z = self._patches[patch].actor.GetBounds()
        corners = np.array(
            [(x, y, z) for x in (low_x, high_x) for y in (low_y, high_y) for z in (low_z, high_z)]
        )
        return self.screen_box(corners)

    # -- pixels -----------------------------------------------------------------------------

    def draw(self, *, fine: bool = False, only: Box | None = None) -> NDArray:
        """(H, W, 4) uint8 sRGB pixels, the first row at the bottom; the next call changes them.

        Parameters
        ----------
        fine : bool
            Smooth edges also where software draws, at some times the cost: for when nothing moves.
        only : (x0, y0, x1, y1), optional
            Draw only this box of pixels anew; the rest is as before. The cost falls with its size
            and with what lies in it.

        Raises
        ------
        ExportError
            If OpenGL cannot be started.
        """
        started = time.perf_counter()
        width, height = self._size
        if only is None or self._pixels is None:
            only = (0, 0, width, height)
        zoom = _FINE if fine and self.is_software else 1
        self._aim(only)
        self._window.SetSize(width * zoom, height * zoom)
        self._window.Render()
        pixels = self._read(*(zoom * edge for edge in only))
        if zoom > 1:
            rows, columns = only[3] - only[1], only[2] - only[0]
            blocks = pixels.reshape(rows, zoom, columns, zoom, 4)
            pixels = (blocks.sum(axis=(1, 3), dtype=np.uint16) // zoom**2).astype(np.uint8)
        if only == (0, 0, width, height):
            self._pixels = np.array(pixels)
        else:
            self._pixels[only[1] : only[3], only[0] : only[2]] = pixels
        self.frame_s = time.perf_counter() - started
        return self._pixels

    def _aim(self, box: Box) -> None:
        """Turn camera, viewport and backdrop to a box of pixels."""
        (width, height), (x0, y0, x1, y1) = self._size, box
        share = (y1 - y0) / height
        half = np.tan(0.5 * self._camera.view_angle) * share
        eye = self.renderer.GetActiveCamera()
        eye.SetViewAngle(np.degrees(2.0 * np.arctan(half)))
        eye.SetWindowCenter((x0 + x1 - width) / (x1 - x0), (y0 + y1 - height) / (y1 - y0))
        self.renderer.SetViewport(x0 / width, y0 / height, x1 / width, y1 / height)
        self._paint_backdrop(y0 / height, y1 / height)

    def _read(self, x0: int, y0: int, x1: int, y1: int) -> NDArray:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        pixels = vtkUnsignedCharArray()
        self._window.GetRGBACharPixelData(x0, y0, x1 - 1, y1 - 1, 0, pixels)
        if pixels.GetNumberOfTuples() != (x1 - x0) * (y1 - y0):
            raise ExportError("nothing could be drawn: OpenGL gave no pixels")
        return vtk_to_numpy(pixels).reshape(y1 - y0, x1 - x0, 4)

    def close(self) -> None:
        """Let go of the graphics memory."""
        self._window.Finalize()


def _shine(look, gloss: Gloss) -> None:
    """Colours come lit; only what glaze mirrors of the lamps is added."""
    look.SetAmbient(1.0)
    look.SetDiffuse(0.0)
    look.SetSpecular(0.02 + 0.22 * gloss.coat)
    look.SetSpecularPower(4.0 + 150.0 * (1.0 - gloss.roughness) ** 2 * (0.2 + 0.8 * gloss.coat))
    look.SetInterpolationToPhong()


def _shade_pixels(openness: NDArray) -> NDArray:
    """(N, N, 4) uint8: black, as dense as the light is kept away, fading toward the border."""
    n = len(openness)
    ticks = (np.arange(n) + 0.5) / n * 2.0 - 1.0
    radius = np.hypot(ticks[None, :], ticks[:, None])
    fade = np.clip((1.0 - radius) / 0.35, 0.0, 1.0)
    pixels = np.zeros((n, n, 4), np.uint8)
    shade = _SHADE * (1.0 - np.clip(openness, 0.0, 1.0)) * fade * fade * (3.0 - 2.0 * fade)
    pixels[..., 3] = np.rint(255.0 * shade)
    return pixels
