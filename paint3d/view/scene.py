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
from paint3d.view.camera import Camera
from paint3d.view.daylight import Ground
from paint3d.view.edges import (
    SRGB_CODES,
    SRGB_LIGHT,
    Edges,
    EdgeShaders,
    draw_edges,
    own_mapper,
    set_edges,
)
from paint3d.view.paper import Paper, show_paper
from paint3d.view.studio import LIGHTS, Gloss, Studio, linear_to_srgb, make_panorama, srgb_to_linear

__all__ = [
    "FlatDrawing",
    "Frame",
    "Scene",
    "SceneDrawing",
    "draw_flat",
    "draw_scene",
    "join_pixels",
    "quiet_vtk",
    "told_of_opengl",
]

BACKDROP = np.array([0.238, 0.226, 0.210])  # linear light of the backdrop far from the object
POOL = np.array([0.600, 0.572, 0.535])  # the same around the object, in the key light
DIFFUSE = 0.924  # fraction of even light that VTK reflects from rough white; measured
SAMPLES_A_PIXEL = 8  # if the driver has as many: software has 4, and none over some edges
FINER = 2  # supersampling along each axis
MOST_PIXELS = 8192  # greatest number drawn along a side
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
        self._size = tuple(self._scale * n for n in size)
        self._plotter: Any = None

    def __enter__(self) -> Self:
        scene = self._scene
        with quiet_vtk(), told_of_opengl():
            import pyvista as pv

            plotter = pv.Plotter(off_screen=True, window_size=self._size, lighting="none")
            self._plotter = plotter
            try:
                plotter.set_background(linear_to_srgb(BACKDROP))
                self._object = _add_object(plotter, scene, self._gloss)
                self._ground = None
                if scene.ground is not None:
                    self._ground = _add_ground(plotter, scene.ground)
                _add_studio(plotter, scene)
                _place_camera(plotter, scene)
                if not self._transparent:  # else samples must be object or not, never a mix
                    plotter.enable_anti_aliasing("msaa", multi_samples=SAMPLES_A_PIXEL)
            except BaseException:
                plotter.close()
                raise
        return self

    def __exit__(self, *_: object) -> None:
        self._plotter.close()

    def show(self, scene: Scene, roughness: AnyArray | None = None) -> None:
        """Replace the scene by one of the same faces, camera and studio.

        `roughness` (V,) replaces each vertex's own, if the gloss had one for each.
        """
        mesh = self._object
        if roughness is not None:
            mesh.active_texture_coordinates[:] = _roughness_coordinates(roughness)
            mesh.GetPointData().GetTCoords().Modified()
        mesh.point_data["light"][:] = scene.colours
        mesh.GetPointData().GetScalars().Modified()
        if scene.edges is not None:
            set_edges(mesh, scene.edges)
        if scene.vertices is not self._scene.vertices:
            mesh.points[:] = scene.vertices
            mesh.GetPoints().Modified()
            mesh.point_data["Normals"][:] = scene.normals
            mesh.GetPointData().GetNormals().Modified()
        if scene.peak != self._scene.peak:
            _light_body(self._plotter.renderer, scene.peak)
        if scene.ground is not None and scene.ground is not self._scene.ground:
            self._plotter.remove_actor(self._ground, render=False)
            self._ground = _add_ground(self._plotter, scene.ground)
        mesh.Modified()
        if scene.vertices is not self._scene.vertices:  # the depth range has changed
            self._plotter.reset_camera_clipping_range()
        self._scene = scene

    def pixels(self) -> NDArray[np.uint8]:
        """Draw and return the pixels as `draw_scene` does."""
        plotter = self._plotter
        with quiet_vtk(), told_of_opengl():
            plotter.render()
            shown = plotter.screenshot(return_img=True, transparent_background=self._transparent)
        return join_pixels(shown, self._scale, self._transparent)


@contextmanager
def told_of_opengl() -> Iterator[None]:
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


def _add_object(plotter: Any, scene: Scene, gloss: Gloss) -> Any:
    import pyvista as pv

    mesh = pv.PolyData.from_regular_faces(scene.vertices, scene.faces)
    mesh.point_data["Normals"] = scene.normals
    mesh.GetPointData().SetActiveNormals("Normals")
    mesh.point_data["light"] = scene.colours
    roughness = gloss.seen_roughness
    if gloss.each is not None:
        mesh.active_texture_coordinates = _roughness_coordinates(gloss.each)
        roughness = 1.0  # multiplies the texture's
    actor = plotter.add_mesh(
        mesh, scalars="light", rgb=True, pbr=True, metallic=0.0, roughness=roughness
    )
    # A matte surface's own reflection is already part of its painted colour.
    actor.GetProperty().SetBaseIOR(MATTE_IOR + gloss.coat * (GLAZE_IOR - MATTE_IOR))
    if gloss.each is not None:
        scale = np.zeros((1, 256, 3), np.uint8)  # occlusion, roughness, metallic
        scale[..., 0] = 255
        scale[..., 1] = np.arange(256)
        actor.GetProperty().SetORMTexture(_texture(scale, plain=True))
        shader = actor.GetShaderProperty()
        shader.AddFragmentShaderReplacement("vec3(baseF0Uniform)", False, _FILM_MIRRORS, True)
    own_mapper(actor, mesh, "light")
    paper = Paper(gloss.paper) if gloss.paper > 0.0 else None
    if scene.edges is not None:
        draw_edges(actor, mesh, scene.edges, _LIT_EDGES, paper)
    if paper is not None:
        show_paper(actor, mesh, scene.places, paper, codes=False)
    return mesh


def _roughness_coordinates(roughness: AnyArray) -> AnyArray:
    """Return texture coordinates (V, 2) of roughnesses (V,) in a texture of 256 levels."""
    u = (255.0 * np.clip(roughness, 0.0, 1.0) + 0.5) / 256.0
    coordinates: AnyArray = np.stack([u, np.full_like(u, 0.5)], axis=1)
    return coordinates


def _add_ground(plotter: Any, ground: Ground) -> Any:
    import pyvista as pv

    half, origin = ground.half, ground.origin
    corners = origin + half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    square = pv.PolyData.from_regular_faces(corners, [[0, 1, 2], [0, 2, 3]])
    square.active_texture_coordinates = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    pixels = np.rint(255 * linear_to_srgb(_ground_light(ground))).astype(np.uint8)
    texture = _texture(pixels, plain=True)
    return plotter.add_mesh(square, texture=texture, lighting=False, reset_camera=False)


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


def _add_studio(plotter: Any, scene: Scene) -> None:
    """Reflect the panorama; light the body evenly, since vertex colours include the light."""
    renderer = plotter.renderer
    renderer.SetAutomaticLightCreation(False)
    renderer.SetUseImageBasedLighting(True)
    renderer.SetEnvironmentTexture(
        _texture(scene.exposure * make_panorama(studio=scene.studio)), False
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
    irradiance.SetInputTexture(_texture(np.full((2, 4, 3), peak / DIFFUSE, np.float32)))
    irradiance.SetIrradianceSize(4)
    irradiance.SetIrradianceStep(0.1)


def _place_camera(plotter: Any, scene: Scene) -> None:
    camera = plotter.camera
    camera.position, camera.focal_point = scene.camera.position, scene.camera.focus
    camera.up = scene.camera.up
    camera.view_angle = np.degrees(scene.camera.view_angle)
    plotter.reset_camera_clipping_range()


def _texture(pixels: AnyArray, *, plain: bool = False) -> Any:
    """Return a texture of the (H, W, 3) array, first row at the bottom, values unchanged.

    A `plain` one has no mipmaps, whose transitions would be visible at grazing angles.
    """
    import pyvista as pv

    height, width = pixels.shape[:2]
    image = pv.ImageData(dimensions=(width, height, 1))
    image.point_data["pixels"] = np.ascontiguousarray(pixels).reshape(-1, 3)
    image.GetPointData().SetActiveScalars("pixels")
    texture = pv.Texture(image)
    texture.SetColorModeToDirectScalars()
    texture.SetInterpolate(True)
    texture.SetMipmap(not plain)
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
    paper: float = 0.0,
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
    paper : float
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
        paper: float = 0.0,
    ) -> None:
        self._faces, self._frame, self._transparent = faces, frame, transparent
        self._paper = paper
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

    def pixels(
        self, vertices: AnyArray, srgb: AnyArray, edges: Edges | None = None
    ) -> NDArray[np.uint8]:
        """Draw and return the pixels as `draw_flat` does, of equally many vertices each time.

        Edges are drawn sharp each time or never.
        """
        import pyvista as pv

        seen = (vertices @ self._frame.axes.T).astype(np.float32)
        plotter = self._plotter
        with quiet_vtk(), told_of_opengl():
            if self._mesh is None:
                mesh = self._mesh = pv.PolyData.from_regular_faces(seen, self._faces)
                mesh.point_data["srgb"] = srgb
                actor = plotter.add_mesh(mesh, scalars="srgb", rgb=True, lighting=False)
                own_mapper(actor, mesh, "srgb")
                paper = Paper(self._paper) if self._paper > 0.0 else None
                if edges is not None:
                    draw_edges(actor, mesh, edges, _FLAT_EDGES, paper)
                if paper is not None:
                    show_paper(actor, mesh, vertices, paper, codes=True)
            else:
                self._mesh.points[:] = seen
                self._mesh.GetPoints().Modified()
                self._mesh.point_data["srgb"][:] = srgb
                self._mesh.GetPointData().GetScalars().Modified()
                if edges is not None:
                    set_edges(self._mesh, edges)
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
