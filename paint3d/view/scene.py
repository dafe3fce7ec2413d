"""Offscreen rendering with VTK: lit scenes (object, ground, studio), and unlit projections."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.core.ending import holding_interrupts
from paint3d.errors import ExportError
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.view.camera import Camera, picture_axes
from paint3d.view.daylight import Ground
from paint3d.view.edges import (
    SRGB_CODES,
    SRGB_LIGHT,
    Edges,
    EdgeShaders,
    draw_edges,
    set_edges,
)
from paint3d.view.paper import Paper, show_paper
from paint3d.view.studio import (
    LIGHTS,
    NO_PAPER,
    Gloss,
    Studio,
    linear_to_srgb,
    make_panorama,
    srgb_to_linear,
)
from paint3d.view.vtk_parts import DrawnMesh, make_texture

__all__ = [
    "FlatDrawing",
    "Frame",
    "Scene",
    "SceneDrawing",
    "draw_flat",
    "draw_scene",
    "join_pixels",
    "opengl_errors",
    "quiet_vtk",
]

BACKDROP = np.array([0.238, 0.226, 0.210])  # linear light of the backdrop far from the object
POOL = np.array([0.600, 0.572, 0.535])  # the same around the object, in the key light
DIFFUSE = 0.924  # fraction of even light that VTK reflects from rough white; measured
SAMPLES_A_PIXEL = 8  # if the driver has as many: software has 4, and none over some edges
FINER = 2  # supersampling along each axis
MOST_PIXELS = 8192  # greatest number drawn along a side
_MARGIN = 2  # pixels around an object
_ROWS = 16  # of a picture that are joined at once: so few stay in the processor's cache
MATTE_IOR, GLAZE_IOR = 1.1, 1.53
_FILM_MIRRORS = (
    "vec3(mix(max(baseF0Uniform, 0.02), baseF0Uniform, smoothstep(0.1, 0.6, roughness)))"
)
"""GLSL: reflectance at normal incidence, for smooth surfaces at least that of water."""
_LIT_EDGES = EdgeShaders.between("pow(codes, vec3(2.2))", "pow(light, vec3(1.0 / 2.2))")
_FLAT_EDGES = EdgeShaders.between(SRGB_LIGHT, SRGB_CODES)
POOL_RADIUS = 0.62  # of the ground's half-width


@dataclass(frozen=True)
class Scene:
    """Everything visible, in studio axes and mm.

    `colours` (V, 3) uint8 are (light / `peak`)^(1/2.2); `exposure` converts the studio's radiance
    to linear brightness; `ground` is None in views from below and in transparent pictures.
    `edges` are those of the paint, their bare colours like `colours`; None: interpolate. `places`
    (V, 3) are the vertices on the object at rest, where its paper is read.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32]
    colours: NDArray[np.uint8]
    peak: float
    exposure: float
    ground: Ground | None
    camera: Camera
    places: NDArray[np.float32]
    studio: Studio = LIGHTS["studio"]
    edges: Edges | None = None


def draw_scene(
    scene: Scene, gloss: Gloss, size: tuple[int, int], transparent: bool = False
) -> NDArray[np.uint8]:
    """Return the (height, width, 3) sRGB pixels of the scene, or (height, width, 4).

    A `transparent` picture has the object's coverage as its fourth channel, 255 for all of a pixel.

    Raises
    ------
    ExportError
        If OpenGL cannot be started.
    """
    with SceneDrawing(scene, gloss, size, transparent) as drawing:
        return drawing.pixels()


class SceneDrawing:
    """Repeated drawing of a scene, recoloured or turned; a context manager.

    Parameters
    ----------
    scene : Scene
    gloss : Gloss
    size : (int, int)
        Width and height in pixels.
    transparent : bool

    Raises
    ------
    ExportError
        If OpenGL cannot be started.
    """

    def __init__(
        self, scene: Scene, gloss: Gloss, size: tuple[int, int], transparent: bool = False
    ) -> None:
        self._scene, self._gloss, self._transparent = scene, gloss, transparent
        finer = FINER + transparent
        self._scale = finer if max(size) * finer <= MOST_PIXELS else 1
        self._size = size
        self._ground: Any = None
        self._behind: NDArray[np.uint8] | None = None
        self._roughness = gloss.each
        self._last: NDArray[np.uint8] | None = None  # the picture before, and what of it is old:
        self._changed = scene.vertices

    def __enter__(self) -> Self:
        scene = self._scene
        with quiet_vtk(), opengl_errors():
            self._canvas = _Canvas(linear_to_srgb(BACKDROP))
            try:
                self._object = _lit_object(scene, self._gloss)
                self._canvas.renderer.AddActor(self._object.actor)
                self._show_ground(scene.ground)
                _add_studio(self._canvas.renderer, scene)
            except BaseException:
                self._canvas.close()
                raise
        return self

    def __exit__(self, *_: object) -> None:
        self._canvas.close()

    def show(self, scene: Scene, roughness: AnyArray | None = None) -> None:
        """Replace the scene by one of the same faces, camera and studio.

        `roughness` (V,) replaces each vertex's own, if the gloss had one for each.
        """
        drawn, renderer, before = self._object, self._canvas.renderer, self._scene
        is_still = scene.vertices is before.vertices and scene.peak == before.peak
        if scene.edges is None and is_still and scene.ground is before.ground:
            changed = [self._changed, drawn.changed_by(scene.colours)]
            if roughness is not None:
                marked = (roughness != self._roughness)[scene.faces].any(axis=1)
                changed.append(scene.vertices[scene.faces[marked].ravel()])
            self._changed = np.concatenate(changed)
        else:
            self._last = None
        if roughness is not None:
            assert self._roughness is not None, "the gloss had one for each"
            self._roughness = roughness.copy()
            _set_roughness(drawn, roughness)
        drawn.set_colours(scene.colours)
        if scene.edges is not None:
            set_edges(drawn.data, scene.edges)
        if scene.peak != before.peak:
            _light_body(renderer, scene.peak)
        if scene.ground is not None:
            self._show_ground(scene.ground)
        if scene.vertices is not before.vertices:
            drawn.set_shape(scene.vertices, scene.faces, scene.normals)
        self._scene = scene

    def _show_ground(self, ground: Ground | None) -> None:
        """Replace the ground, if it is another one."""
        if self._ground is not None and ground is not self._scene.ground:
            self._canvas.renderer.RemoveActor(self._ground)
            self._ground = self._behind = None
        if self._ground is None and ground is not None:
            self._ground = _draw_ground(ground)
            self._canvas.renderer.AddActor(self._ground)

    def pixels(self) -> NDArray[np.uint8]:
        """Draw and return the pixels as `draw_scene` does.

        The ground and the backdrop have no edges: what lies around the object is drawn without
        supersampling, and once for as long as it stays. Where only colours have changed since the
        picture before, only their box is drawn anew.
        """
        width, height = self._size
        shown = self._scene.vertices if self._last is None else self._changed
        box = x0, y0, x1, y1 = _box_of(shown, self._scene.camera, self._size)
        with quiet_vtk(), opengl_errors():
            if self._behind is None and self._transparent:
                self._behind = np.zeros((height, width, 4), np.uint8)
            elif self._behind is None:
                self._behind = self._draw((0, 0, width, height), 1, around=True)
            pixels = (self._behind if self._last is None else self._last).copy()
            if x1 > x0 and y1 > y0:
                fine = self._draw(box, self._scale)
                pixels[y0:y1, x0:x1] = join_pixels(fine, self._scale, self._transparent)
        self._last, self._changed = pixels, self._changed[:0]
        return pixels

    def _draw(
        self, box: tuple[int, int, int, int], scale: int, *, around: bool = False
    ) -> NDArray[np.uint8]:
        """Return the pixels of a box of the picture, `scale` times as fine, or what is `around`."""
        canvas = self._canvas
        self._object.show(not around)
        # of what is transparent, samples must be object or not, never a mix
        canvas.window.SetMultiSamples(0 if around or self._transparent else SAMPLES_A_PIXEL)
        canvas.window.SetSize(scale * (box[2] - box[0]), scale * (box[3] - box[1]))
        _place_camera(canvas.renderer, self._scene.camera, box, self._size)
        return canvas.pixels(transparent=self._transparent)


class _Canvas:
    """A window that is never shown, with one renderer, `renderer`, that has no lights."""

    def __init__(self, background: AnyArray) -> None:
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  implements the classes below
        from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

        self.window, self.renderer = vtkRenderWindow(), vtkRenderer()
        self.window.SetOffScreenRendering(1)
        self.window.AddRenderer(self.renderer)
        self.renderer.SetAutomaticLightCreation(False)
        self.renderer.SetBackground(*background)

    def pixels(self, *, transparent: bool) -> NDArray[np.uint8]:
        """Draw; return the pixels (H, W, 3), or 4 if transparent, first row at the top."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        width, height = self.window.GetSize()
        self.renderer.SetBackgroundAlpha(0.0 if transparent else 1.0)
        self.window.SetAlphaBitPlanes(transparent)
        self.window.Render()
        shown, box = vtkUnsignedCharArray(), (0, 0, width - 1, height - 1)
        right = 0  # of two eyes
        front = 1  # of the buffers: there samples are joined by light, in the other one by codes
        if transparent:
            self.window.GetRGBACharPixelData(*box, front, shown, right)
        else:
            self.window.GetPixelData(*box, front, shown, right)
        if shown.GetNumberOfTuples() != width * height:
            raise RuntimeError("it gave no pixels")
        pixels: NDArray[np.uint8] = vtk_to_numpy(shown).reshape(height, width, -1)[::-1]
        return pixels

    def close(self) -> None:
        """Give the memory of the window back."""
        self.window.Finalize()


@contextmanager
def opengl_errors() -> Iterator[None]:
    """Raise an ExportError of one line where OpenGL cannot be started."""
    try:
        yield
    except RuntimeError as cause:
        raise ExportError("no picture could be drawn with OpenGL: {cause}", cause=cause) from None


def join_pixels(pixels: AnyArray, scale: int, transparent: bool) -> NDArray[np.uint8]:
    """Downsample by averaging scale x scale pixels in linear light.

    Parameters
    ----------
    pixels : (scale H, scale W, 3 or 4) uint8
        If `transparent`, the fourth says whether a pixel is covered.
    scale : int
    transparent : bool

    Returns
    -------
    (H, W, 3) uint8, or (H, W, 4)
    """
    if scale == 1:
        return np.ascontiguousarray(pixels[..., : 3 + transparent])
    height, width = pixels.shape[0] // scale, pixels.shape[1] // scale
    joined = np.empty((height, width, 3 + transparent), np.uint8)
    for top in range(0, height, _ROWS):
        rows = pixels[scale * top : scale * min(top + _ROWS, height)]
        joined[top : top + _ROWS] = _join_rows(rows, scale, transparent)
    return joined


def _join_rows(pixels: AnyArray, scale: int, transparent: bool) -> AnyArray:
    """See `join_pixels`."""
    linear = srgb_to_linear(np.arange(256, dtype=np.uint8))
    height, width = pixels.shape[0] // scale, pixels.shape[1] // scale
    light = np.zeros((height, width, 3), np.float32)
    covered = np.zeros((height, width, 1), np.float32)
    for row, column in np.ndindex(scale, scale):
        part = pixels[row::scale, column::scale]
        own = np.take(linear, part[..., :3], mode="clip")  # which spares the check of each
        is_covered = (part[..., 3:] > 127).astype(np.float32) if transparent else np.float32(1.0)
        light += own * is_covered if transparent else own
        covered += is_covered
    light /= np.maximum(covered, 1.0)
    codes = np.rint(255 * linear_to_srgb(light))
    shown = [codes, np.rint(covered * (255.0 / scale**2))] if transparent else [codes]
    return np.concatenate(shown, axis=2)


def _lit_object(scene: Scene, gloss: Gloss) -> DrawnMesh:
    drawn = DrawnMesh()
    drawn.set_shape(scene.vertices, scene.faces, scene.normals)
    drawn.set_colours(scene.colours)
    drawn.drop_nothing()
    actor = drawn.actor
    surface, shader = actor.GetProperty(), actor.GetShaderProperty()
    surface.SetBackfaceCulling(TriangleMesh(scene.vertices, scene.faces).is_solid)
    surface.SetInterpolationToPBR()
    surface.SetMetallic(0.0)
    surface.SetRoughness(gloss.seen_roughness if gloss.each is None else 1.0)  # times a texture's
    # A matte surface's own reflection is already part of its painted colour.
    surface.SetBaseIOR(MATTE_IOR + gloss.coat * (GLAZE_IOR - MATTE_IOR))
    if gloss.each is not None:
        _set_roughness(drawn, gloss.each)
        scale = np.zeros((1, 256, 3), np.uint8)  # occlusion, roughness, metallic
        scale[..., 0] = 255
        scale[..., 1] = np.arange(256)
        surface.SetORMTexture(_texture(scale))
        shader.AddFragmentShaderReplacement("vec3(baseF0Uniform)", False, _FILM_MIRRORS, True)
    paper = Paper(gloss.paper) if any(gloss.paper) else None
    if scene.edges is not None:
        draw_edges(actor, drawn.data, scene.edges, _LIT_EDGES, paper)
    if paper is not None:
        show_paper(actor, drawn.data, scene.places, paper, codes=False)
    return drawn


def _set_roughness(drawn: DrawnMesh, roughness: AnyArray) -> None:
    """Set the roughness (V,) of each vertex as a place in a texture of 256 levels."""
    u = (255.0 * np.clip(roughness, 0.0, 1.0) + 0.5) / 256.0
    drawn.set_texture_coordinates(np.stack([u, np.full_like(u, 0.5)], axis=1))


def _draw_ground(ground: Ground) -> Any:
    """Return the actor of the ground."""
    half, origin = ground.half, ground.origin
    corners = origin + half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    square = DrawnMesh()
    square.set_shape(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    square.set_texture_coordinates(np.array([[0, 0], [1, 0], [1, 1], [0, 1]]))
    pixels = np.rint(255 * linear_to_srgb(_ground_light(ground))).astype(np.uint8)
    square.actor.SetTexture(_texture(pixels))
    square.actor.GetProperty().SetLighting(False)
    return square.actor


def _ground_light(ground: Ground) -> NDArray[np.float64]:
    """Return the (N, N, 3) linear light of the ground: a pool of light, fading to the backdrop."""
    n = len(ground.openness)
    ticks = (np.arange(n) + 0.5) / n * 2 - 1
    radius = np.hypot(ticks[None, :], ticks[:, None])
    pool = np.exp(-((radius / POOL_RADIUS) ** 2)) * np.clip(1.0 - radius, 0, 1) ** 0.5
    fade = np.clip((1.0 - radius) / 0.35, 0, 1)
    shade = 1 - (1 - ground.openness) * fade * fade * (3 - 2 * fade)
    result: NDArray[np.float64] = (BACKDROP + pool[..., None] * (POOL - BACKDROP)) * shade[
        ..., None
    ]
    return result


def _add_studio(renderer: Any, scene: Scene) -> None:
    """Reflect the panorama; light the body evenly, since vertex colours include the light."""
    renderer.SetUseImageBasedLighting(True)
    renderer.SetEnvironmentTexture(
        _texture(scene.exposure * make_panorama(studio=scene.studio), mipmaps=True), False
    )
    renderer.SetUseSphericalHarmonics(False)
    renderer.SetEnvironmentRight(1, 0, 0)
    renderer.SetEnvironmentUp(0, 0, 1)
    mirrored = renderer.GetEnvMapPrefiltered()
    mirrored.SetPrefilterLevels(6)
    mirrored.SetPrefilterMaxSamples(64)
    renderer.GetEnvMapLookupTable().SetLUTSize(128)
    renderer.GetEnvMapLookupTable().SetLUTSamples(64)
    _light_body(renderer, scene.peak)


def _light_body(renderer: Any, peak: float) -> None:
    """Set even light such that vertex colours appear as light times `peak`."""
    irradiance = renderer.GetEnvMapIrradiance()
    irradiance.SetInputTexture(
        _texture(np.full((2, 4, 3), peak / DIFFUSE, np.float32), mipmaps=True)
    )
    irradiance.SetIrradianceSize(4)
    irradiance.SetIrradianceStep(0.1)


def _box_of(points: AnyArray, camera: Camera, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return the box of the picture that holds points (N, 3): left, top, right, bottom, pixels."""
    width, height = size
    if not len(points):
        return 0, 0, 0, 0
    seen = (points - camera.position) @ np.stack(picture_axes(camera), axis=1)
    depth = -seen[:, 2]
    if not depth.min() > 0.0:  # part of it lies behind the camera
        return 0, 0, width, height
    places = seen[:, :2] / depth[:, None] / np.tan(camera.view_angle / 2) * (height / 2)
    x, y = places[:, 0] + width / 2, height / 2 - places[:, 1]
    low = np.floor([x.min(), y.min()]).astype(int) - _MARGIN
    high = np.ceil([x.max(), y.max()]).astype(int) + _MARGIN
    (x0, y0), (x1, y1) = (np.clip(end, 0, size).tolist() for end in (low, high))
    return x0, y0, x1, y1


def _place_camera(
    renderer: Any, eye: Camera, box: tuple[int, int, int, int], size: tuple[int, int]
) -> None:
    """Point a renderer at a box of the picture that a camera takes."""
    (x0, y0, x1, y1), (width, height), camera = box, size, renderer.GetActiveCamera()
    camera.SetPosition(*eye.position)
    camera.SetFocalPoint(*eye.focus)
    camera.SetViewUp(*eye.up)
    part = (y1 - y0) / height
    camera.SetViewAngle(np.degrees(2 * np.arctan(part * np.tan(eye.view_angle / 2))))
    camera.SetWindowCenter((x0 + x1 - width) / (x1 - x0), (height - y0 - y1) / (y1 - y0))
    renderer.ResetCameraClippingRange()


def _texture(pixels: AnyArray, *, mipmaps: bool = False) -> Any:
    """Return a texture of the (H, W, 3) array, first row at the bottom, values unchanged.

    Transitions between `mipmaps` are visible at grazing angles.
    """
    from vtkmodules.vtkRenderingCore import vtkTexture

    texture = make_texture(pixels)
    texture.SetWrap(vtkTexture.Repeat)
    texture.SetMipmap(mipmaps)
    return texture


@contextmanager
def quiet_vtk() -> Iterator[None]:
    """Suppress VTK's warning that it found no X server before it takes EGL or OSMesa.

    Also hold interrupts: VTK crashes if one comes while a module of it is loaded.
    """
    with holding_interrupts():
        from vtkmodules.vtkCommonCore import vtkLogger

        cutoff = vtkLogger.GetCurrentVerbosityCutoff()
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
        try:
            yield
        finally:
            vtkLogger.SetStderrVerbosity(cutoff)


# ---- Unlit projection ----------------------------------------------------------------------------
# Every colour as it was painted, in a parallel projection, to scale.


_FINER = 3
_FAR = 4.0  # distance of the camera, in depths of the object


class Frame(NamedTuple):
    """The section of a projection to draw.

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
    edges: Edges | None = None,
    paper: tuple[float, float] = NO_PAPER,
) -> NDArray[np.uint8]:
    """Return the pixels of a projection, (height, width, 3) on white, or 4 if transparent.

    Parameters
    ----------
    vertices : (V, 3) float32
        mm.
    faces : (F, 3) int32
    srgb : (V, 3) uint8
        Interpolated as codes, as viewers of mesh files do.
    frame : Frame
    size : (int, int)
        Width and height in pixels, which are square: `frame.height` spans the height.
    transparent : bool
    edges : Edges, optional
        Those of the paint, drawn sharp; by default codes are interpolated there, too.
    paper : (2,) of float
        As in `Gloss`.

    Raises
    ------
    ExportError
        If no OpenGL can be started.
    """
    with FlatDrawing(faces, frame, size, transparent, paper) as drawing:
        return drawing.pixels(vertices, srgb, edges)


class FlatDrawing:
    """Repeated drawing of a projection, recoloured or turned; a context manager.

    Parameters
    ----------
    faces, frame, size, transparent, paper
        As for `draw_flat`.

    Raises
    ------
    ExportError
        If no OpenGL can be started.
    """

    def __init__(
        self,
        faces: AnyArray,
        frame: Frame,
        size: tuple[int, int],
        transparent: bool = False,
        paper: tuple[float, float] = NO_PAPER,
    ) -> None:
        self._faces, self._frame, self._transparent = faces, frame, transparent
        self._paper = paper
        self._scale = _FINER if max(size) * _FINER <= MOST_PIXELS else 1
        self._size = (self._scale * size[0], self._scale * size[1])
        self._drawn: DrawnMesh | None = None

    def __enter__(self) -> Self:
        with quiet_vtk(), opengl_errors():
            self._canvas = _Canvas(np.ones(3))
            self._canvas.window.SetSize(*self._size)
            self._canvas.window.SetMultiSamples(SAMPLES_A_PIXEL)
        return self

    def __exit__(self, *_: object) -> None:
        self._canvas.close()

    def pixels(
        self, vertices: AnyArray, srgb: AnyArray, edges: Edges | None = None
    ) -> NDArray[np.uint8]:
        """Draw and return the pixels as `draw_flat` does, of equally many vertices each time.

        Edges are drawn sharp each time or never.
        """
        seen = (vertices @ self._frame.axes.T).astype(np.float32)
        with quiet_vtk(), opengl_errors():
            if self._drawn is None:
                drawn = self._drawn = DrawnMesh()
                drawn.actor.GetProperty().SetLighting(False)
                paper = Paper(self._paper) if any(self._paper) else None
                if edges is not None:
                    draw_edges(drawn.actor, drawn.data, edges, _FLAT_EDGES, paper)
                if paper is not None:
                    show_paper(drawn.actor, drawn.data, vertices, paper, codes=True)
                self._canvas.renderer.AddActor(drawn.actor)
            elif edges is not None:
                set_edges(self._drawn.data, edges)
            self._drawn.set_shape(seen, self._faces)
            self._drawn.set_colours(srgb)
            self._place_camera(seen)
            shown = self._canvas.pixels(transparent=self._transparent)
        return join_pixels(shown, self._scale, self._transparent)

    def _place_camera(self, seen: AnyArray) -> None:
        frame, camera = self._frame, self._canvas.renderer.GetActiveCamera()
        deep = max(float(np.ptp(seen[:, 2])), 1e-3 * frame.height)
        x, y = frame.middle.tolist()
        middle = float(seen[:, 2].max() + seen[:, 2].min()) / 2
        camera.ParallelProjectionOn()
        camera.SetParallelScale(frame.height / 2)
        camera.SetFocalPoint(x, y, middle)
        camera.SetPosition(x, y, middle + _FAR * deep)
        camera.SetViewUp(0.0, 1.0, 0.0)
        self._canvas.renderer.ResetCameraClippingRange()
