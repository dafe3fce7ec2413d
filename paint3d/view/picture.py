"""Offscreen pictures of a painted object in a studio, softly lit; no display is needed.

Diffuse light is computed per vertex (`daylight`: soft shadows, occlusion, one bounce) and passed to
VTK in the vertex colours; VTK's physically based shading, under even light, shows it and adds the
reflections of the surface and its glaze.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from paint3d.core.arrays import AnyArray, as_array
from paint3d.core.atomic import write_atomically
from paint3d.errors import InputError, MeshError
from paint3d.view.camera import Camera, View, find_view, fit_camera, studio_axes, vertex_areas
from paint3d.view.daylight import Ground, Occluder, light_ground, light_points
from paint3d.view.edges import Edges
from paint3d.view.scene import Scene, draw_scene
from paint3d.view.studio import LIGHTS, Gloss, Studio, light_samples, linear_to_srgb, srgb_to_linear

__all__ = [
    "Gloss",
    "Lighting",
    "Setting",
    "Stand",
    "View",
    "checked_size",
    "develop",
    "draw_picture",
    "light_object",
    "render_picture",
    "set_up_scene",
]

VTK_GAMMA = 2.2  # VTK's physically based shading reads vertex colours as powers of 2.2
LIT_BEST = 0.88  # fraction of the visible vertices that are lit no better than WHITE_POINT
SHALLOWEST = 0.02  # sine of the camera's elevation below which the ground is left out
VIGNETTE = 0.34  # relative darkening in the corners
SMALLEST, LARGEST = 16, 4096  # pixels
WHITE_POINT = 0.74  # linear brightness of best-lit ideal white: leaves headroom for highlights
_LEVELS = 65535  # of linear light in a table
SHOULDER = 1.5  # power of the film curve, see `develop`


class Stand(NamedTuple):
    """A fixed studio, camera and exposure, for pictures that belong together.

    `axes` (3, 3) are the studio's in the object's frame, as `studio_axes` returns them; the camera
    is in the studio's frame. `exposure` is that of another picture's `Scene`, or None to compute
    the picture's own.
    """

    axes: NDArray[np.float64]
    camera: Camera
    exposure: float | None = None


class Setting(NamedTuple):
    """Lighting and background of a picture: on the studio's floor, or on nothing if transparent.

    Without a `stand` it is computed from the view.
    """

    studio: Studio = LIGHTS["studio"]
    transparent: bool = False
    stand: Stand | None = None


def render_picture(
    vertices: ArrayLike,
    faces: ArrayLike,
    normals: ArrayLike,
    srgb: ArrayLike,
    path: str | os.PathLike[str],
    *,
    size: tuple[int, int] = (1600, 1200),
    view: View | None = None,
    gloss: Gloss | None = None,
) -> None:
    """Write a PNG picture of the painted object.

    Parameters
    ----------
    vertices, faces, normals, srgb, size, view, gloss
        As for `draw_picture`.
    path : path-like
        Replaced as a whole, or left untouched on failure. Of a symbolic link, the file that it
        leads to is replaced.

    Raises
    ------
    MeshError
        If the arrays do not fit together.
    InputError
        If the size is out of range.
    ExportError
        If the path cannot be written, or no OpenGL can be started.
    """
    path, size = Path(path), checked_size(size)
    arrays = _checked_arrays(vertices, faces, normals, srgb)
    with write_atomically(path) as temporary:
        pixels = draw_picture(*arrays, size=size, view=view, gloss=gloss)
        Image.fromarray(pixels).save(temporary, format="PNG")


def draw_picture(
    vertices: ArrayLike,
    faces: ArrayLike,
    normals: ArrayLike,
    srgb: ArrayLike,
    *,
    size: tuple[int, int] = (1600, 1200),
    view: View | None = None,
    gloss: Gloss | None = None,
    setting: Setting | None = None,
    edges: Edges | None = None,
) -> NDArray[np.uint8]:
    """Return the pixels of a picture of the painted object, (height, width, 3) sRGB codes.

    With a transparent setting there are four: the last is the object's coverage, 0 to 255.

    Parameters
    ----------
    vertices : (V, 3) array_like
        mm.
    faces : (F, 3) array_like of int
    normals : (V, 3) array_like
        Unit, outward.
    srgb : (V, 3) array_like of uint8
        Painted colours.
    size : (int, int)
        Width and height in pixels, each 16 to 4096.
    view : View, optional
        Default: onto the painted side, from slightly above; a flat sheet squarely.
    gloss : Gloss, optional
        Default: glazed porcelain.
    setting : Setting, optional
        Default: the studio, on its floor.
    edges : Edges, optional
        Those of the paint (V vertices), drawn sharp; by default colours are interpolated there,
        too.

    Raises
    ------
    MeshError
        If the arrays do not fit together.
    InputError
        If the size is out of range.
    ExportError
        If no OpenGL can be started.
    """
    size, setting = checked_size(size), setting or Setting()
    vertices, faces, normals, srgb = _checked_arrays(vertices, faces, normals, srgb)
    if view is None:
        view = find_view(vertices, normals, srgb, vertex_areas(vertices, faces))
    scene = set_up_scene((vertices, faces, normals, srgb), view, size, setting, edges)
    transparent = setting.transparent
    return develop(draw_scene(scene, gloss or Gloss.of("porcelain"), size, transparent))


def set_up_scene(
    arrays: tuple[AnyArray, AnyArray, AnyArray, AnyArray],
    view: View,
    size: tuple[int, int],
    setting: Setting,
    edges: Edges | None = None,
) -> Scene:
    """Light an object and place the camera.

    Parameters
    ----------
    arrays : vertices (V, 3) float32, faces (F, 3) int32, normals (V, 3), srgb (V, 3) uint8
    view : View
        If the setting has a stand, only its direction counts.
    size : (int, int)
    setting : Setting
    edges : Edges, optional
    """
    lit = light_object(arrays, view, size, setting)
    return lit.scene(arrays[3], edges)


class Lighting(NamedTuple):
    """An object placed in the studio, and the light on it, independent of its colours.

    `vertices` and `normals` (V, 3) are in the studio's axes, `places` (V, 3) in the object's;
    `light` (S, 3) falls on the S vertices marked in `seen` (V,), and includes the `exposure`.
    """

    vertices: NDArray[np.float32]
    normals: NDArray[np.float32]
    faces: NDArray[np.int32]
    seen: NDArray[np.bool_]
    light: NDArray[np.float64]
    exposure: float
    ground: Ground | None
    camera: Camera
    places: NDArray[np.float32]
    studio: Studio

    def scene(self, srgb: AnyArray, edges: Edges | None = None) -> Scene:
        """Return the scene with colours `srgb`, (V, 3) uint8."""
        peak = max(float(self.light.max()), 1.0)
        if edges is not None:
            edges = edges._replace(bare=self._lit(edges.bare, peak))
        return Scene(
            self.vertices, self.faces, self.normals, self._lit(srgb, peak), peak, self.exposure,
            self.ground, self.camera, self.places, self.studio, edges,
        )  # fmt: skip

    def _lit(self, srgb: AnyArray, peak: float) -> NDArray[np.uint8]:
        albedo = srgb_to_linear(srgb)
        shown = np.zeros_like(albedo)
        shown[self.seen] = albedo[self.seen] * self.light / peak
        codes: NDArray[np.uint8] = np.rint(255 * shown ** (1 / VTK_GAMMA)).astype(np.uint8)
        return codes


def light_object(
    arrays: tuple[AnyArray, AnyArray, AnyArray, AnyArray],
    view: View,
    size: tuple[int, int],
    setting: Setting,
    everywhere: bool = False,
    occluder: Occluder | None = None,
) -> Lighting:
    """Light an object and place the camera; see `set_up_scene`.

    The light depends on the colours by their mean alone. Only visible vertices are lit, or all
    with `everywhere`. `occluder` is the object's, where it is known.
    """
    vertices, faces, normals, srgb = arrays
    places, areas = vertices, vertex_areas(vertices, faces)
    stand = setting.stand
    axes = (studio_axes(vertices, view) if stand is None else stand.axes).astype(np.float32)
    vertices, normals = vertices @ axes.T, normals @ axes.T
    view = View(axes @ view.direction, axes @ view.up, view.zoom)
    camera = fit_camera(vertices, view, size[0] / size[1]) if stand is None else stand.camera
    occluder, suns = occluder or Occluder(vertices, faces), light_samples(studio=setting.studio)
    ground = light_ground(occluder, suns)
    on_ground = view.direction[2] > SHALLOWEST and not setting.transparent
    albedo = srgb_to_linear(srgb)
    seen = np.ones(len(normals), np.bool_)
    if not everywhere:
        seen = _needs_light(normals, camera.position - vertices, faces)
    mean_albedo = float(areas @ albedo.mean(axis=1) / areas.sum())
    light = light_points(occluder, ground, suns, vertices[seen], normals[seen], mean_albedo)
    exposure = None if stand is None else stand.exposure
    if exposure is None:
        exposure = WHITE_POINT / float(np.quantile(light.mean(axis=1), LIT_BEST))
    light *= exposure
    shown_ground = ground if on_ground else None
    return Lighting(
        vertices, normals, faces, seen, light, exposure, shown_ground, camera, places,
        setting.studio,
    )  # fmt: skip


def _needs_light(normals: AnyArray, to_camera: AnyArray, faces: AnyArray) -> NDArray[np.bool_]:
    """Return which vertices (V,) belong to a triangle with any vertex facing the camera.

    A triangle needs light on all three, or it would fade into black.
    """
    ahead = np.einsum("ij,ij->i", normals, to_camera) > 0.0
    seen = np.zeros(len(normals), np.bool_)
    seen[faces[ahead[faces].any(axis=1)]] = True
    return seen


def develop(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Apply the film curve 1 - (1 - x)^SHOULDER and a vignette to a picture (H, W, 3).

    The curve lifts midtones, rolls off toward white instead of clipping, and keeps black. A fixed
    grain of half a step dithers slow gradients. A transparent picture (H, W, 4) keeps its alpha,
    and gets no vignette.
    """
    if pixels.shape[2] == 4:
        return np.concatenate([_printed(pixels[..., :3], 1.0), pixels[..., 3:]], axis=2)
    return _printed(pixels, _vignette(*pixels.shape[:2]))


def _printed(pixels: NDArray[np.uint8], vignette: AnyArray | float) -> NDArray[np.uint8]:
    height, width = pixels.shape[:2]
    shown = 1 - (1 - srgb_to_linear(np.arange(256, dtype=np.uint8))) ** SHOULDER
    codes = 255 * linear_to_srgb(np.arange(_LEVELS + 1, dtype=np.float32) / _LEVELS)
    printed = np.take(_LEVELS * shown, pixels) * vignette
    grain = np.random.default_rng(7).random((height, width, 1), dtype=np.float32) - 0.5
    seen = np.take(codes, (printed + np.float32(0.5)).astype(np.uint16)) + grain
    result: NDArray[np.uint8] = np.rint(np.clip(seen, 0, 255, out=seen), out=seen).astype(np.uint8)
    return result


def _vignette(height: int, width: int) -> NDArray[np.float32]:
    """Return (height, width, 1) factors: 1 in the middle, a little darker toward the corners."""
    x = np.linspace(-1, 1, width, dtype=np.float32)
    y = np.linspace(-1, 1, height, dtype=np.float32)
    corner = (x[None, :] ** 2 + y[:, None] ** 2) / 2
    return np.asarray((1 - VIGNETTE * corner**2)[..., None], np.float32)


def checked_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return width and height in pixels.

    Raises
    ------
    InputError
        If they are not whole numbers of 16 to 4096.
    """
    fits = len(size) == 2 and all(
        isinstance(n, int | np.integer) and SMALLEST <= n <= LARGEST for n in size
    )
    if not fits:
        raise InputError(
            "size is {size}; expected (width, height), each {smallest} to {most}",
            size=size,
            smallest=SMALLEST,
            most=LARGEST,
        )
    return int(size[0]), int(size[1])


def _checked_arrays(
    vertices: ArrayLike, faces: ArrayLike, normals: ArrayLike, srgb: ArrayLike
) -> tuple[AnyArray, AnyArray, AnyArray, AnyArray]:
    vertices = as_array(vertices, "vertices", (None, 3), np.float32, MeshError)
    faces = as_array(faces, "faces", (None, 3), np.int32, MeshError)
    n_vertices = len(vertices)
    normals = as_array(normals, "normals", (n_vertices, 3), np.float32, MeshError)
    srgb = as_array(srgb, "srgb", (n_vertices, 3), np.uint8, MeshError)
    if len(faces) == 0:
        raise MeshError("the mesh has no faces; expected at least one to draw")
    if faces.min() < 0 or faces.max() >= n_vertices:
        raise MeshError(
            "faces name vertices {least} to {most} of {n_vertices}",
            least=faces.min(),
            most=faces.max(),
            n_vertices=n_vertices,
        )
    if np.ptp(vertices, axis=0).max() <= 0:
        raise MeshError("all vertices lie in one point; expected an object to draw")
    return vertices, faces, normals, srgb
