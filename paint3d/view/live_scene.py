"""The live scene, rendered offscreen by VTK; no window system is needed.

It renders into pixels rather than a native window, so the same code runs under X11, Wayland and
without a display, in tests and in the desktop window, which draws its overlays on top.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from paint3d.core.arrays import AnyArray
from paint3d.errors import ExportError
from paint3d.surface.sheen import PLAIN_SHINE
from paint3d.view.camera import Camera, picture_axes
from paint3d.view.edges import SRGB_CODES, SRGB_LIGHT, EdgeShaders
from paint3d.view.kernels.chunks import cone_of
from paint3d.view.kernels.shine import add_shine
from paint3d.view.live_coarse import CoarseObject
from paint3d.view.live_layers import Box, Enlarger, KeptPicture, LastPicture, Target
from paint3d.view.live_light import SHOULDER, BakedLight
from paint3d.view.live_object import PatchUpload
from paint3d.view.live_patches import turned_away
from paint3d.view.paper import Paper
from paint3d.view.studio import Gloss
from paint3d.view.vtk_parts import DrawnMesh, camera_light, quiet_vtk

__all__ = ["DARK", "LIGHT", "Background", "LiveScene"]

_SQUARES = 20  # along a side of the floor; squares without shadow are not drawn
_SHADE = 0.55  # greatest opacity of the object's shadow on the floor
_MARGINS = np.array([-4, -4, 5, 5])  # pixels around a change: for line width and smooth edges
_JITTER = tuple((x, y) for y in (-0.25, 0.25) for x in (-0.25, 0.25))  # sample offsets, pixels
_SAMPLED = 2  # samples of a pixel along each side, where edges of the object are smoothed
_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swr ")
_SAMPLES = 4  # MSAA samples per pixel on a graphics card
_CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], bool)
# Up to this size of triangles, in pixels, highlights are computed per vertex while the view moves.
_FEW_PIXELS = 20.0
# Specular highlights of the three parallel lamps, as VTK's own shader computes them but without
# the terms that are zero here. Vertex alpha selects the gloss: that of the material, of a film of
# water (like glaze), or of matt ink.
_SHINE = """
  vec3 mirrored = reflect(normalize(-vertexVC.xyz), normalVCVSOutput);
  vec3 toward = vec3(dot(mirrored, lightDirectionVC0), dot(mirrored, lightDirectionVC1),
                     dot(mirrored, lightDirectionVC2));
  vec3 facing = vec3(dot(normalVCVSOutput, lightDirectionVC0),
                     dot(normalVCVSOutput, lightDirectionVC1),
                     dot(normalVCVSOutput, lightDirectionVC2));
  float shine = (255.0 * vertexColorVSOutput.a - PLAIN) / (255.0 - PLAIN);
  float film = max(shine, 0.0), matt = max(-shine, 0.0);
  float power = mix(mix(specularPowerUniform, FILM_POWER, film), MATT_POWER, matt);
  float share = mix(mix(specularIntensity, max(specularIntensity, FILM_SHARE), film),
                    min(specularIntensity, MATT_SHARE), matt);
  vec3 bright = step(vec3(0.0), -facing) * pow(max(vec3(1e-5), toward), vec3(power));
  fragOutput0 = vec4(RELIEF * painted
    + share * (bright.x * lightColor0 + bright.y * lightColor1 + bright.z * lightColor2), 1.0);
"""
_LIGHT = f"1.0 - pow(1.0 - ({SRGB_LIGHT}), vec3(1.0 / {SHOULDER}))"  # before the film curve
_CODES = SRGB_CODES.replace("light", f"(1.0 - pow(1.0 - light, vec3({SHOULDER})))")
_EDGES = EdgeShaders.between(_LIGHT, _CODES)
_FILM_POWER, _FILM_SHARE = 120.0, 0.22
_MATT_POWER, _MATT_SHARE = 8.8, 0.02
_LOBES = {
    "PLAIN": PLAIN_SHINE,
    "FILM_POWER": _FILM_POWER,
    "FILM_SHARE": _FILM_SHARE,
    "MATT_POWER": _MATT_POWER,
    "MATT_SHARE": _MATT_SHARE,
}
# Surface grain: waves fixed in the object, as in `haptics.kernels.force`, warped to and fro so that
# no weave is visible, and faded out where pixels are coarser than the grain.
_RELIEF = """
float relief() {
  vec3 turned = surfacePlace * TURNS;
  float seen = clamp(2.0 - 1.6 * length(fwidth(turned)), 0.0, 1.0);
  if (seen <= 0.0) return 1.0;
  turned += 2.3 * sin(0.31 * turned.yzx + vec3(0.7, 3.1, 5.3));
  turned += 1.1 * sin(0.79 * turned.zxy + vec3(2.2, 0.3, 4.1));
  vec3 up = turned.yxz * 0.526 + turned.zyx * 0.851;
  vec3 down = turned.zyx * 0.851 - turned.yxz * 0.526;
  vec3 one = sin(up * vec3(1.0, 0.94, 0.9) + vec3(0.4, 5.1, 3.6));
  vec3 two = sin(down * vec3(0.85, 0.81, 0.97) + vec3(2.9, 1.3, 4.4));
  return 1.0 + DEPTH * seen * (dot(one, vec3(1.0)) + dot(two, vec3(1.0)));
}
"""
# The shadow on the floor: black, with the texture's only channel as its opacity.
_SHADE_ALONE = """
  fragOutput0 = vec4(0.0, 0.0, 0.0, texture(actortexture, tcoordVCVSOutput).r);
"""
_DEEPEST = 0.1  # relative brightening of the bumps of the coarsest grain
_LIGHTS = (  # of highlights and the brush; the object's diffuse light is baked
    ((-0.55, 0.75, 1.0), 0.85, (1.0, 0.985, 0.96)),
    ((0.9, 0.25, 0.45), 0.35, (0.93, 0.96, 1.0)),
    ((0.1, 0.5, -0.7), 0.3, (1.0, 1.0, 1.0)),
)


@dataclass(frozen=True)
class Background:
    """Background gradient, sRGB in [0, 1]: colours at the bottom and the top of the picture."""

    below: tuple[float, float, float]
    above: tuple[float, float, float]


LIGHT = Background((0.815, 0.805, 0.785), (0.640, 0.630, 0.612))
DARK = Background((0.300, 0.296, 0.290), (0.150, 0.150, 0.154))


@dataclass(frozen=True, eq=False)
class _Smaller:
    """Buffers for drawing the object at a reduced resolution, `share` of the pixels per side."""

    share: float
    box: Box
    backdrop: KeptPicture
    enlarger: Enlarger

    @classmethod
    def of(cls, share: float, window: Any, size: tuple[int, int]) -> _Smaller:
        """Create them for a fraction `share` of the pixels along each side of `size`."""
        small = max(1, round(share * size[0])), max(1, round(share * size[1]))
        return cls(share, (0, 0, *small), KeptPicture(window, depth=False), Enlarger(small, size))


class LiveScene:
    """The scene while painting, in three layers: the backdrop, the object, the brush.

    The pictures of the lower layers are cached, so that only what has changed is redrawn: a brush
    over an object costs no more than the brush, and a part of an object no more than that part.

    Parameters
    ----------
    size : (int, int)
        Width and height, pixels.
    mood : Background

    Attributes
    ----------
    uploaded : int
        Bytes sent to the renderer so far.
    frame_s : float
        Duration of the last `draw_object` and `show`, s.

    Raises
    ------
    ExportError
        If OpenGL cannot be started.
    """

    def __init__(self, size: tuple[int, int] = (800, 600), mood: Background = LIGHT) -> None:
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  implements the classes below
        from vtkmodules.vtkCommonDataModel import vtkRecti
        from vtkmodules.vtkRenderingCore import vtkCamera, vtkRenderWindow

        quiet_vtk()
        self._rectangle = vtkRecti
        self._window = vtkRenderWindow()
        self._window.SetOffScreenRendering(1)
        self._window.SetMultiSamples(0)
        self._window.SetSize(*size)
        self._window.SetFrameBlitModeToNoBlit()
        self._window.SetSwapBuffers(False)  # nothing is presented on a screen
        self._size = size
        self._eye = vtkCamera()
        self._backdrop, self.renderer, self._front = (self._layer(n) for n in range(3))
        self._camera = Camera(
            np.array([0.0, -4.0, 0.0]), np.zeros(3), np.array([0.0, 0.0, 1.0]), np.radians(24.0)
        )
        self._axes = _looking_axes(self._camera)
        self.renderer_name = self._start()
        self.is_software = any(word in self.renderer_name.lower() for word in _SOFTWARE)
        if not self.is_software:
            self._window.SetMultiSamples(_SAMPLES)
        self._target = Target(self._window)
        self._kept: tuple[KeptPicture, LastPicture] | None = None
        self._smaller: _Smaller | None = None
        self._is_small = False
        self._beside: dict[DrawnMesh, float] = {}  # other meshes, and their line widths
        self._pixels: AnyArray | None = None
        self._patches: dict[int, DrawnMesh] = {}
        self._sharp: set[int] = set()  # patches with paint: others do without their edges
        self._coarse: list[DrawnMesh] = []
        self._coarse_is_new = False
        self._coarse_object: CoarseObject | None = None
        self._coarse_order: list[int] = []
        self._bounds_of, self._cones = np.empty((0, 6)), np.empty((0, 4))
        self._counts = np.empty(0, np.int64)
        self._is_solid = False
        self._shown = np.empty(0, bool)
        self._boxes: AnyArray | None = None
        self._seen: tuple[int, int] | None = None
        self._ground: DrawnMesh | None = None
        self._gloss = Gloss.of("porcelain")
        self._paper: Paper | None = None
        self._bounds = np.zeros(3), 1.0
        self.uploaded = 0
        self.frame_s = 0.0
        self.set_mood(mood)

    def _layer(self, number: int) -> Any:
        """Create the renderer of one layer: 0 the backdrop, 1 the object, 2 the brush."""
        from vtkmodules.vtkRenderingCore import vtkRenderer

        layer = vtkRenderer()
        layer.SetUseOIT(False)  # translucent actors are added back to front: saves a pass
        layer.SetAutomaticLightCreation(False)
        layer.GetCullers().RemoveAllItems()
        self._window.AddRenderer(layer)
        if number > 0:
            layer.SetActiveCamera(self._eye)
            layer.SetPreserveColorBuffer(True)
            layer.SetPreserveDepthBuffer(number > 1)
            for position, intensity, colour in _LIGHTS:
                layer.AddLight(camera_light(position, intensity, colour))
        return layer

    def _start(self) -> str:
        """Start OpenGL; return the name of the OpenGL renderer."""
        self._window.Render()
        report = self._window.ReportCapabilities() or ""
        names = [line for line in report.splitlines() if "renderer string" in line]
        if not names:
            raise ExportError("nothing can be drawn: no OpenGL of version 3.2 or later was found")
        return names[0].partition(":")[2].strip()

    # -- contents ---------------------------------------------------------------------------

    def set_mood(self, mood: Background) -> None:
        """Set the background colours."""
        self.mood = mood
        self._backdrop.GradientBackgroundOn()
        self._backdrop.SetBackground(*mood.below)
        self._backdrop.SetBackground2(*mood.above)
        self._forget()

    def clear(self, centre: AnyArray, radius: float, gloss: Gloss, *, solid: bool = False) -> None:
        """Remove the object; the next one lies within `radius` mm of `centre`.

        Back faces are culled if the next one is `solid` (`TriangleMesh.is_solid`).
        """
        for drawn in self._patches.values():
            self.renderer.RemoveActor(drawn.actor)
        self._patches, self._sharp = {}, set()
        self.set_coarse(None)
        self._bounds_of, self._cones = np.empty((0, 6)), np.empty((0, 4))
        self._counts = np.empty(0, np.int64)
        self._shown = np.empty(0, bool)
        self._boxes = self._seen = None
        self._is_solid = solid
        if self._ground is not None:
            self.renderer.RemoveActor(self._ground.actor)
            self._ground = None
        self._bounds = np.asarray(centre, np.float64), float(radius)
        self._pixels = None
        self.set_gloss(gloss)

    def set_gloss(self, gloss: Gloss) -> None:
        """Set the gloss of the object's material."""
        self._gloss = gloss
        self._paper = Paper(gloss.paper, quick=self.is_software) if any(gloss.paper) else None
        for drawn in (*self._patches.values(), *self._coarse):
            _shine(drawn.actor.GetProperty(), gloss)

    def apply(self, uploads: Iterable[PatchUpload]) -> list[AnyArray]:
        """Update the arrays of some patches.

        Returns
        -------
        list of (N, 3) float32
            For each patch the corners of the triangles whose appearance changed.
        """
        changed = []
        for upload in uploads:
            drawn = self._patches.get(upload.patch)
            if drawn is None:
                drawn = self._patches[upload.patch] = self._new_piece()
                self._shown = np.empty(0, bool)
            if upload.points is not None and upload.faces is not None:
                drawn.set_shape(upload.points, upload.faces, upload.normals)
                self._bound(upload.patch, upload.points, upload.faces)
            attributes = {"shares": upload.shares}
            if upload.bare is not None:
                attributes["bare"] = upload.bare
            changed.append(drawn.changed_by(upload.colours, **attributes))
            drawn.set_colours(upload.colours)
            for name, values in attributes.items():
                drawn.set_attribute(name, values)
            if upload.patch not in self._sharp and upload.shares.any():
                self._sharp.add(upload.patch)
                drawn.read_attributes()
                _set_shaders(drawn, True, self._gloss, self._paper, sharp=True)
            self.uploaded += upload.n_bytes
        return changed

    def _new_piece(self) -> DrawnMesh:
        """Add an empty mesh with the object's material to the scene."""
        drawn = DrawnMesh(PLAIN_SHINE)
        look = drawn.actor.GetProperty()
        _shine(look, self._gloss)
        look.SetBackfaceCulling(self._is_solid)
        _set_shaders(drawn, True, self._gloss, self._paper)
        drawn.actor.ForceOpaqueOn()  # alpha is the shine, not opacity
        self.renderer.AddActor(drawn.actor)
        return drawn

    def _bound(self, patch: int, points: AnyArray, faces: AnyArray) -> None:
        """Update the bounding box and the cone of normals of a patch."""
        if patch >= len(self._bounds_of):
            more = patch + 1 - len(self._bounds_of)
            self._bounds_of = np.concatenate([self._bounds_of, np.full((more, 6), np.nan)])
            self._cones = np.concatenate([self._cones, np.full((more, 4), np.nan)])
            self._counts = np.concatenate([self._counts, np.zeros(more, np.int64)])
        self._counts[patch] = len(faces)
        if len(points):
            self._bounds_of[patch] = *points.min(axis=0), *points.max(axis=0)
            if self._is_solid:
                cone_of(points, faces, self._cones[patch])
        self._boxes = self._seen = None

    def set_coarse(self, coarse: CoarseObject | None) -> None:
        """Set the coarse version of the object (see `draw_object`), or None for no such version."""
        for drawn in self._coarse:
            self.renderer.RemoveActor(drawn.actor)
        self._coarse, self._coarse_object, self._coarse_order = [], coarse, []
        for piece in coarse.pieces if coarse is not None else ():
            drawn = self._new_piece()
            drawn.set_shape(piece.points, piece.faces, piece.normals)
            drawn.show(False)
            self._coarse.append(drawn)
        self.recolour_coarse()

    @property
    def has_coarse(self) -> bool:
        """Whether the object can be drawn coarsely."""
        return bool(self._coarse)

    def recolour_coarse(self) -> None:
        """Mark the colours of the coarse object as changed."""
        self._coarse_is_new = True

    def _light_coarse(self) -> None:
        """Update the coarse object's colours, with highlights per vertex if triangles are small."""
        coarse, look = self._coarse_object, self._coarse[0].actor.GetProperty()
        assert coarse is not None, "its pieces are there"
        near = coarse.triangle_mm <= _FEW_PIXELS * self.nearest_mm()
        colours = coarse.colours
        if near:
            colours = np.empty_like(coarse.colours)
            axes = self._axes * (1.0, 1.0, -1.0)  # right, up, and toward the eye
            lamps = np.array(
                [
                    [*(axes @ _unit(place)), *(np.array(colour) * light)]
                    for place, light, colour in _LIGHTS
                ]
            )
            share = look.GetSpecular()
            lobes = np.array(
                [
                    [look.GetSpecularPower(), share],
                    [_FILM_POWER, max(share, _FILM_SHARE)],
                    [_MATT_POWER, min(share, _MATT_SHARE)],
                ]
            )
            add_shine(
                coarse.points,
                coarse.normals,
                coarse.colours,
                self._camera.position,
                lamps,
                lobes,
                PLAIN_SHINE,
                colours,
            )
        if near or self._coarse_is_new or not look.GetLighting():
            for drawn, piece in zip(self._coarse, coarse.pieces, strict=True):
                drawn.set_colours(colours[piece.clusters])
            self._coarse_is_new = False
        if bool(look.GetLighting()) == near:
            for drawn in self._coarse:
                drawn.actor.GetProperty().SetLighting(not near)
                _set_shaders(drawn, not near, self._gloss)

    def add(self, drawn: DrawnMesh, *, front: bool = False) -> None:
        """Add another mesh to the object's layer, or to the brush's, in front of it."""
        (self._front if front else self.renderer).AddActor(drawn.actor)
        if not front:
            self._beside[drawn] = drawn.actor.GetProperty().GetLineWidth()

    def remove(self, drawn: DrawnMesh) -> None:
        """Remove a mesh that was added."""
        self._beside.pop(drawn, None)
        self.renderer.RemoveActor(drawn.actor)
        self._front.RemoveActor(drawn.actor)

    def set_ground(self, baked: BakedLight) -> None:
        """Set the object's soft shadow on the floor, which is visible from above only."""
        if self._ground is not None:
            self.renderer.RemoveActor(self._ground.actor)
        ground, drawn = baked.ground, DrawnMesh()
        pixels = _shade_pixels(ground.openness)
        places, faces = _visible_squares(pixels)
        corners = np.concatenate([2.0 * places - 1.0, np.zeros((len(places), 1))], axis=1)
        drawn.set_shape((ground.origin + ground.half * corners) @ baked.axes, faces)
        drawn.set_texture(pixels, places)
        look = drawn.actor.GetProperty()
        look.LightingOff()
        look.BackfaceCullingOn()
        drawn.actor.ForceTranslucentOn()
        drawn.drop_nothing()
        shader = drawn.actor.GetShaderProperty()
        shader.AddFragmentShaderReplacement("//VTK::TCoord::Impl", True, _SHADE_ALONE, False)
        self._ground = drawn
        self.renderer.AddActor(drawn.actor)

    # -- camera -----------------------------------------------------------------------------

    def set_size(self, size: tuple[int, int]) -> None:
        """Set the width and height, pixels."""
        self._size = max(1, int(size[0])), max(1, int(size[1]))
        self._forget()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self._size

    @property
    def camera(self) -> Camera:
        """The present camera."""
        return self._camera

    @property
    def whole(self) -> Box:
        """The box of all pixels."""
        return 0, 0, *self._size

    def set_camera(self, camera: Camera) -> None:
        """Set the camera."""
        self._camera, self._axes = camera, _looking_axes(camera)
        self._pixels = self._boxes = self._seen = None
        eye = self._eye
        eye.SetPosition(*camera.position)
        eye.SetFocalPoint(*camera.focus)
        eye.SetViewUp(*camera.up)
        eye.SetViewAngle(np.degrees(camera.view_angle))
        centre, radius = self._bounds
        depth = float((centre - camera.position) @ self._axes[:, 2])
        far = depth + 5.0 * radius
        eye.SetClippingRange(max(depth - 2.0 * radius, 0.002 * far), far)

    def screen_box(self, points: AnyArray) -> Box | None:
        """Return the screen bounding box of points (N, 3), y up; None if none is in the picture."""
        points = np.asarray(points, np.float64)
        if len(points) == 0:
            return None
        x0, y0, x1, y1 = (int(edge) for edge in self._screen_boxes(points[None])[0])
        return (x0, y0, x1, y1) if x1 > x0 and y1 > y0 else None

    def _patch_boxes(self) -> AnyArray:
        """Return the screen bounding box of each patch (P, 4); empty if out of the picture."""
        if self._boxes is None:
            low, high = self._bounds_of[:, :3], self._bounds_of[:, 3:]
            self._boxes = self._screen_boxes(np.where(_CORNERS, high[:, None], low[:, None]))
        return self._boxes

    def _screen_boxes(self, points: AnyArray) -> AnyArray:
        """Return the boxes (P, 4) int of points (P, N, 3); x1 <= x0 or y1 <= y0 if empty."""
        camera, (width, height) = self._camera, self._size
        away = points - camera.position
        right, up, ahead = (away @ axis for axis in self._axes.T)
        scale = 0.5 * height / np.tan(0.5 * camera.view_angle) / np.maximum(ahead, 1e-9)
        across, along = scale * right + 0.5 * width, scale * up + 0.5 * height
        low = [across.min(axis=1), along.min(axis=1)]  # separately: contiguous rows are fast
        high = [across.max(axis=1), along.max(axis=1)]
        boxes = np.stack([*low, *high], axis=1) + _MARGINS
        boxes[~(ahead.min(axis=1) > 0.0)] = self.whole  # behind the eye, or nan: could be anywhere
        result: AnyArray = np.clip(boxes, 0, (width, height, width, height)).astype(np.int64)
        return result

    # -- pixels -----------------------------------------------------------------------------

    def draw_object(
        self,
        box: Box | None = None,
        *,
        coarse: bool = False,
        fine: bool = False,
        share: float = 1.0,
    ) -> None:
        """Redraw the object; `show` then shows it.

        Parameters
        ----------
        box : (x0, y0, x1, y1), optional
            Redraw only this box of pixels, bit-identical to a full redraw. The cost falls with its
            size and with what lies in it.
        coarse : bool
            Draw the version given to `set_coarse`.
        fine : bool
            Smooth edges also in software; see `smooth`.
        share : float
            Fraction of the pixels along each side to draw and then enlarge: for while the view
            moves. The picture of the object is lost with the next one (`is_lost`).
        """
        started = time.perf_counter()
        backdrop, kept = self._keep()
        box = box or self.whole
        self._choose(box, coarse and bool(self._coarse))
        self._is_small = share < 1.0
        if self._is_small:
            self._draw_smaller(share)
            kept.cover(self.whole, keep=False)
            self.frame_s = time.perf_counter() - started
            return
        backdrop.give(box)
        self._draw_layer(self.renderer, box, (0.0, 0.0))
        kept.keep(box)
        if fine and self.is_software:
            self.smooth(box)
        self.frame_s = time.perf_counter() - started

    def smooth(self, box: Box) -> None:
        """Smooth the edges of what was drawn in a box, in software: for when nothing moves.

        Colours are the means of 2 x 2 samples of each pixel, drawn at once, which costs much less
        than four times: renderers in software pay for triangles more than for pixels. Depths stay.
        """
        backdrop, kept = self._keep()
        width, height = (max(1, pixels // _SAMPLED) for pixels in self._size)
        corners = [
            (x, y) for y in range(0, self._size[1], height) for x in range(0, self._size[0], width)
        ]
        with self._lines_wider(_SAMPLED):
            for x, y in corners:
                shown = x, y, x + width, y + height
                x0, y0, x1, y1 = part = _common(shown, box)
                if x0 >= x1 or y0 >= y1:
                    continue
                large = (
                    (x0 - x) * _SAMPLED,
                    (y0 - y) * _SAMPLED,
                    (x1 - x) * _SAMPLED,
                    (y1 - y) * _SAMPLED,
                )
                self._choose(part, coarse=False)
                kept.cover(large)
                backdrop.give_enlarged(part, large)
                self._draw_enlarged(shown, large)
                pixels = _shrunk(self._target.read(large))
                kept.give(part)
                self._target.write(part, pixels)
                kept.keep(part)

    def _draw_enlarged(self, shown: Box, box: Box) -> None:
        """Draw the object's layer, of which a part fills the window, within a box of that."""
        (width, height), eye = self._size, self._eye
        x0, y0, x1, y1 = shown
        fraction = (y1 - y0) / height
        angle = 2.0 * np.arctan(fraction * np.tan(0.5 * self._camera.view_angle))
        eye.SetViewAngle(np.degrees(angle))
        large = _SAMPLED * (x1 - x0) / width, _SAMPLED * (y1 - y0) / height
        self.renderer.SetViewport(0.0, 0.0, *large)
        centre = (x0 + x1 - width) / (x1 - x0), (y0 + y1 - height) / (y1 - y0)
        self._draw_around(self.renderer, box, centre)
        self.renderer.SetViewport(0.0, 0.0, 1.0, 1.0)
        eye.SetViewAngle(np.degrees(self._camera.view_angle))

    @contextmanager
    def _lines_wider(self, factor: float) -> Iterator[None]:
        """Draw the lines of other meshes so much wider meanwhile."""
        for drawn, width in self._beside.items():
            drawn.actor.GetProperty().SetLineWidth(factor * width)
        try:
            yield
        finally:
            for drawn, width in self._beside.items():
                drawn.actor.GetProperty().SetLineWidth(width)

    def _draw_smaller(self, share: float) -> None:
        """Draw the object at reduced resolution into the lower left corner."""
        if self._smaller is None or self._smaller.share != share:
            if self._smaller is not None:
                self._smaller.backdrop.release()
            self._smaller = _Smaller.of(share, self._window, self._size)
            self._draw_within(self._backdrop, self._smaller.box)
            self._smaller.backdrop.keep(self._smaller.box)
        self._smaller.backdrop.give(self._smaller.box)
        with self._lines_wider(share):
            self._draw_within(self.renderer, self._smaller.box)

    def _draw_within(self, layer: Any, box: Box) -> None:
        """Draw a whole layer scaled into a box of pixels."""
        layer.SetViewport(0.0, 0.0, box[2] / self._size[0], box[3] / self._size[1])
        self._draw_layer(layer, box, (0.0, 0.0))
        layer.SetViewport(0.0, 0.0, 1.0, 1.0)

    def _show_enlarged(self, pixels: AnyArray) -> None:
        """Enlarge the reduced picture, and draw the brush over it at full resolution."""
        assert self._smaller is not None, "it was drawn"
        smaller, kept, top = self._smaller, self._keep()[1], self._size[1]
        smaller.enlarger.enlarge(self._target.read(smaller.box), pixels)
        box = self._front_box()
        if box is not None:
            kept.spread(smaller.box, box)
            self._draw_layer(self._front, box, (0.0, 0.0))
            pixels[top - box[3] : top - box[1], box[0] : box[2]] = self._target.read(box)[::-1]

    def _front_box(self) -> Box | None:
        """Return the box of what is drawn in front of the object; None if there is nothing."""
        bounds = [a.GetBounds() for a in self._front.GetActors() if a.GetVisibility()]
        if not bounds:
            return None
        edges = np.array(bounds).reshape(-1, 3, 2)
        low, high = edges[..., 0].min(axis=0), edges[..., 1].max(axis=0)
        return self.screen_box(np.where(_CORNERS, high, low))

    @property
    def is_lost(self) -> bool:
        """Whether the whole object must be redrawn before `show`."""
        return self._kept is not None and self._kept[1].is_lost

    def show(self, box: Box | None = None, *, fine: bool = False, keep: bool = True) -> AnyArray:
        """Return the picture: the object as it was last drawn, with the brush in front of it.

        Parameters
        ----------
        box : (x0, y0, x1, y1), optional
            The pixels changed since the last call: where the object was redrawn, where the brush
            was, and where it is.
        fine : bool
            Smooth the brush's edges also in software.
        keep : bool
            Keep the object's picture under the brush. Not needed if all of it will be redrawn for
            the next picture; see `is_lost`.

        Returns
        -------
        (H, W, 4) uint8
            sRGB, the first row at the bottom; the next call changes them.
        """
        started = time.perf_counter()
        kept = self._keep()[1]
        if self._pixels is None:
            box, (width, height) = None, self._size
            self._pixels = np.empty((height, width, 4), np.uint8)  # the first row at the top
        if self._is_small:
            self._show_enlarged(self._pixels)
            self.frame_s += time.perf_counter() - started
            return self._pixels[::-1]
        box = box or self.whole
        sums = None
        shifts = _JITTER if fine and self.is_software and self._has_front() else ((0.0, 0.0),)
        for shift in shifts:
            kept.give(box)
            if self._has_front():
                kept.cover(box, keep=keep or len(shifts) > 1)
                self._draw_layer(self._front, box, shift)
            pixels = self._target.read(box)
            if len(shifts) > 1:
                sums = pixels.astype(np.uint16) if sums is None else sums + pixels
        if sums is not None:
            pixels = _mean(sums, len(shifts))
        top = self._size[1]
        self._pixels[top - box[3] : top - box[1], box[0] : box[2]] = pixels[::-1]
        self.frame_s += time.perf_counter() - started
        return self._pixels[::-1]

    def draw(self, *, fine: bool = False, only: Box | None = None) -> NDArray[np.uint8]:
        """Draw and return (H, W, 4) uint8 sRGB pixels, the first row at the bottom.

        The next call changes them.

        Parameters
        ----------
        fine : bool
            Smooth edges also in software, at four times the cost: for when nothing moves.
        only : (x0, y0, x1, y1), optional
            Redraw only this box of pixels; the rest is as before.

        Raises
        ------
        ExportError
            If OpenGL gives no pixels.
        """
        if self._pixels is None:
            only = None
        self.draw_object(only, fine=fine)
        return self.show(only, fine=fine)

    def seen(self) -> tuple[int, int]:
        """Return the numbers of triangles and of patches in the picture."""
        if self._seen is None:
            inside = self._in_sight(self.whole)
            self._seen = int(self._counts[inside].sum()), int(np.count_nonzero(inside))
        return self._seen

    def _in_sight(self, box: Box) -> NDArray[np.bool_]:
        """Return which patches (P,) may be visible within a box of pixels."""
        inside = _overlap(self._patch_boxes(), box)
        if self._is_solid:
            inside &= ~turned_away(self._bounds_of, self._cones, self._camera.position)
        return inside

    def nearest_mm(self) -> float:
        """Return the size of a pixel on the nearest patch in the picture, mm."""
        camera, ahead = self._camera, self._axes[:, 2]
        middle = 0.5 * (self._bounds_of[:, :3] + self._bounds_of[:, 3:])
        depth = ((middle - camera.position) @ ahead)[_overlap(self._patch_boxes(), self.whole)]
        depth = depth[depth > 0.0]
        away = float(depth.min()) if len(depth) else float(np.linalg.norm(camera.focus))
        result: float = 2.0 * away * np.tan(0.5 * camera.view_angle) / self._size[1]
        return result

    def _has_front(self) -> bool:
        """Return whether anything is visible in front of the object."""
        actors = self._front.GetActors()
        return any(actor.GetVisibility() for actor in actors)

    def _choose(self, box: Box, coarse: bool) -> None:
        """Show only the patches in the box, or the coarse object."""
        shown = np.zeros(len(self._bounds_of), bool) if coarse else self._in_sight(box)
        before, self._shown = self._shown, shown
        if len(before) != len(shown):
            before = ~shown
        for patch in np.flatnonzero(before != shown).tolist():
            if patch in self._patches:
                self._patches[patch].show(bool(shown[patch]))
        for drawn in self._coarse:
            drawn.show(coarse)
        if coarse:
            self._light_coarse()
            self._sort_coarse()

    def _sort_coarse(self) -> None:
        """Sort pieces front to back, so that hidden pixels are not shaded."""
        assert self._coarse_object is not None, "its pieces are there"
        centres = np.stack([piece.centre for piece in self._coarse_object.pieces])
        order = np.argsort((centres - self._camera.position) @ self._axes[:, 2], kind="stable")
        if order.tolist() == self._coarse_order:
            return
        self._coarse_order = order.tolist()
        props = self.renderer.GetViewProps()  # RemoveActor would free the arrays on the GPU
        for drawn in self._coarse:
            props.RemoveItem(drawn.actor)
        for k in self._coarse_order:
            props.AddItem(self._coarse[k].actor)

    def _draw_layer(self, layer: Any, box: Box, shift: tuple[float, float]) -> None:
        """Draw one layer within a box, shifted by a fraction of a pixel."""
        self._draw_around(
            layer, box, (2.0 * shift[0] / self._size[0], 2.0 * shift[1] / self._size[1])
        )

    def _draw_around(self, layer: Any, box: Box, centre: tuple[float, float]) -> None:
        """Draw one layer within a box, its middle shifted in halves of the layer's viewport."""
        for other in (self._backdrop, self.renderer, self._front):
            other.SetDraw(other is layer)
        x0, y0, x1, y1 = box
        self._eye.SetScissorRect(self._rectangle(x0, y0, x1 - x0, y1 - y0))
        self._eye.SetUseScissor(True)
        self._eye.SetWindowCenter(*centre)
        self._window.Render()

    def _forget(self) -> None:
        """Release all cached pictures."""
        for kept in self._kept or ():
            kept.release()
        if self._smaller is not None:
            self._smaller.backdrop.release()
        self._kept = self._smaller = self._pixels = self._boxes = self._seen = None
        self._is_small = False

    def _keep(self) -> tuple[KeptPicture, LastPicture]:
        """Return the cached pictures of the backdrop and the object, creating them if needed."""
        if self._kept is None:
            self._window.SetSize(*self._size)
            self._draw_layer(self._backdrop, self.whole, (0.0, 0.0))
            self._kept = KeptPicture(self._window, depth=False), LastPicture(self._window)
            self._kept[0].keep(self.whole)
        return self._kept

    def close(self) -> None:
        """Release all graphics memory."""
        self._forget()
        self._window.Finalize()


def _looking_axes(camera: Camera) -> AnyArray:
    """Return the camera's axes (3, 3): columns right, up and ahead."""
    right, up, back = picture_axes(camera)
    return np.stack([right, up, -back], axis=1)


def _shrunk(pixels: AnyArray) -> AnyArray:
    """Return the rounded means (H, W, 4) uint8 of the squares of pixels (2 H, 2 W, 4)."""
    rows = pixels[::2].astype(np.uint16)
    rows += pixels[1::2]
    return _mean(rows[:, ::2] + rows[:, 1::2], _SAMPLED * _SAMPLED)


def _mean(sums: AnyArray, n: int) -> AnyArray:
    """Return the rounded mean (H, W, 4) uint8 of n pictures from their sum (H, W, 4) uint16."""
    return ((sums + n // 2) // n).astype(np.uint8)


def _overlap(boxes: AnyArray, box: Box) -> NDArray[np.bool_]:
    """Return which of the boxes (P, 4) overlap another box, (P,) bool."""
    low, high = np.maximum(boxes[:, :2], box[:2]), np.minimum(boxes[:, 2:], box[2:])
    return np.asarray((high > low).all(axis=1))


def _common(one: Box, other: Box) -> Box:
    """Return the box that two boxes have in common; x1 <= x0 or y1 <= y0 if there is none."""
    (a0, b0, a1, b1), (x0, y0, x1, y1) = one, other
    return max(a0, x0), max(b0, y0), min(a1, x1), min(b1, y1)


def _unit(vector: Iterable[float]) -> AnyArray:
    array = np.asarray(vector, np.float64)
    return array / np.linalg.norm(array)


def _set_shaders(
    drawn: DrawnMesh, on: bool, gloss: Gloss, paper: Paper | None = None, *, sharp: bool = False
) -> None:
    """Turn per-pixel highlights and grain on or off, with `sharp` edges of paint.

    These read the attributes `bare` and `shares` (see `PatchUpload`).
    """
    shader = drawn.actor.GetShaderProperty()
    shader.ClearAllFragmentShaderReplacements()
    shader.ClearAllVertexShaderReplacements()
    drawn.drop_nothing()
    if not on:
        return
    declare, assign = "//VTK::PositionVC::Dec", "//VTK::PositionVC::Impl"
    vertex, placed, fragment = [declare], [assign], [declare]
    seen = ["relief()"] if gloss.grain > 0.0 else []
    if paper is not None:
        seen.append(paper.light(codes=True))
    shine = _SHINE.replace("RELIEF *", " ".join(f"{factor} *" for factor in seen))
    for name, value in _LOBES.items():
        shine = shine.replace(name, f"{value:.3f}")
    if sharp:
        vertex += [_EDGES.vertex_declared]
        placed += [_EDGES.vertex]
        fragment += [_EDGES.declared]
    found = _EDGES.fragment_on(paper) if sharp else "  vec3 painted = vertexColorVSOutput.rgb;"
    shader.AddFragmentShaderReplacement("//VTK::Light::Impl", True, found + shine, False)
    if seen:
        drawn.keep_places()
        vertex += ["out vec3 surfacePlace;"]
        placed += ["  surfacePlace = vertexMC.xyz;"]
        fragment += ["in vec3 surfacePlace;"]
    if gloss.grain > 0.0:
        depth, turns = _DEEPEST * gloss.grain / 3.0, 2.0 * math.pi / gloss.wave_mm
        relief = _RELIEF.replace("DEPTH", f"{depth:.6f}").replace("TURNS", f"{turns:.6f}")
        fragment += [relief]
    if paper is not None:
        paper.add_to(drawn.actor)
    shader.AddVertexShaderReplacement(declare, True, "\n".join(vertex), False)
    shader.AddVertexShaderReplacement(assign, True, "\n".join(placed), False)
    shader.AddFragmentShaderReplacement(declare, True, "\n".join(fragment), False)


def _shine(look: Any, gloss: Gloss) -> None:
    """Set the material so that only highlights are added: vertex colours are already lit."""
    look.SetAmbient(1.0)
    look.SetDiffuse(0.0)
    look.SetSpecular(0.02 + 0.22 * gloss.coat)
    look.SetSpecularPower(4.0 + 150.0 * (1.0 - gloss.roughness) ** 2 * (0.2 + 0.8 * gloss.coat))
    look.SetInterpolationToPhong()


def _visible_squares(pixels: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Return a grid over a texture (H, W, 1) without squares that are fully transparent.

    Returns
    -------
    places : (K, 2) float64
        u and v of the corners, each in [0, 1].
    faces : (L, 3) int32
    """
    ticks = np.linspace(0.0, 1.0, _SQUARES + 1)
    places = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    edges = [np.rint(ticks * n).astype(np.int64) for n in pixels.shape[:2]]
    dense = maximum_filter(pixels[..., 0], 3) > 0  # filtering spreads a texel to its neighbours
    sums = np.add.reduceat(np.add.reduceat(dense, edges[0][:-1], axis=0), edges[1][:-1], axis=1)
    row, column = np.nonzero(sums)
    a = row * (_SQUARES + 1) + column
    b, c, d = a + 1, a + _SQUARES + 2, a + _SQUARES + 1
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return places, faces.astype(np.int32)


def _shade_pixels(openness: AnyArray) -> NDArray[np.uint8]:
    """Return the shadow's opacity (N, N, 1) uint8 from the openness, faded at the border."""
    n = len(openness)
    ticks = (np.arange(n) + 0.5) / n * 2.0 - 1.0
    radius = np.hypot(ticks[None, :], ticks[:, None])
    fade = np.clip((1.0 - radius) / 0.35, 0.0, 1.0)
    shade = _SHADE * (1.0 - np.clip(openness, 0.0, 1.0)) * fade * fade * (3.0 - 2.0 * fade)
    return np.rint(255.0 * shade).astype(np.uint8)[..., None]
