"""Pictures and films by named views and lights: from the front, flat, lit or unlit, turning."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, as_number
from paint3d.errors import InputError, UnknownNameError
from paint3d.view.camera import Camera, View, find_view, fit_camera, studio_axes, vertex_areas
from paint3d.view.daylight import Occluder
from paint3d.view.edges import Edges
from paint3d.view.picture import (
    LARGEST,
    SMALLEST,
    Lighting,
    Setting,
    Stand,
    checked_size,
    develop,
    draw_picture,
    light_object,
)
from paint3d.view.scene import FlatDrawing, Frame, SceneDrawing, draw_flat
from paint3d.view.studio import LIGHTS, NO_PAPER, Gloss

__all__ = [
    "AUTO",
    "FLAT",
    "MOST_LIGHTS",
    "UNLIT",
    "VIEWS",
    "Moment",
    "Shot",
    "flat_size",
    "take_film",
    "take_shot",
    "take_turning",
]

AUTO, FLAT, UNLIT = "auto", "flat", "none"
VIEWS = {  # azimuth from the front (-y) toward the right (+x), and elevation, degrees
    "front": (0.0, 15.0),
    "right": (90.0, 15.0),
    "back": (180.0, 15.0),
    "left": (270.0, 15.0),
    "above": (0.0, 45.0),
    "top": (0.0, 90.0),
    "bottom": (0.0, -90.0),
}
SIZE = (1600, 1200)
BORDER = 1.06  # size of a projection's frame over its content
_ANGLES, _BANDS = 24, 32  # resolution of the body that a turning object sweeps
_KEPT_BYTES = 300_000_000  # approximate cache size for the light on a turning object
MOST_LIGHTS = 30  # angles of a turn at which the light is computed: softboxes are wider than these
_ROUND = 1e-6
_STEEP = 89.9  # elevation, degrees, beyond which the view is straight down, or up

Arrays = tuple[AnyArray, AnyArray, AnyArray, AnyArray]
"""Vertices (V, 3) float32 mm, faces (F, 3) int32, unit normals (V, 3), srgb (V, 3) uint8."""


@dataclass(frozen=True)
class Shot:
    """Settings of a picture.

    Attributes
    ----------
    view : str or (float, float)
        "auto": onto the painted side; "front" (-y), "right", "back", "left", "above", "top",
        "bottom"; azimuth and elevation in degrees, as in `VIEWS`; or "flat": straight from above,
        to scale, without light and without a border.
    size : (int, int) or None
        Pixels, each 16 to 4096; None: 1600 x 1200, for "flat" the shape of the object.
    light : str
        One of `LIGHTS`, or "none": every colour as it was painted, in a parallel projection.
    transparent : bool
        Leave out the ground and the background.
    zoom : float
        0.1 to 20; 1 fits the object to the picture.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    view: str | tuple[float, float] = AUTO
    size: tuple[int, int] | None = None
    light: str = "studio"
    transparent: bool = False
    zoom: float = 1.0

    def __post_init__(self) -> None:
        if isinstance(self.view, str):
            if self.view not in (AUTO, FLAT, *VIEWS):
                raise UnknownNameError("view", self.view, (AUTO, FLAT, *VIEWS))
        else:
            as_number(self.view[0], "azimuth of the view (degrees)", -360.0, 360.0)
            as_number(self.view[1], "height of the view (degrees)", -90.0, 90.0)
        if self.light not in (UNLIT, *LIGHTS):
            raise UnknownNameError("light", self.light, (UNLIT, *LIGHTS))
        if self.size is not None:
            checked_size(self.size)
        as_number(self.zoom, "zoom", 0.1, 20.0)

    @property
    def is_lit(self) -> bool:
        """Whether the object is lit."""
        return self.light != UNLIT and self.view != FLAT

    def paper(self, gloss: Gloss | None) -> tuple[float, float]:
        """Return what an unlit picture shows of paper, as `Gloss.paper`: none without light."""
        return NO_PAPER if gloss is None or self.light == UNLIT else gloss.paper

    def seen_from(self, arrays: Arrays) -> View:
        """Return the view of the object."""
        if self.view == AUTO:
            vertices, faces, normals, srgb = arrays
            auto = find_view(vertices, normals, srgb, vertex_areas(vertices, faces))
            return View(auto.direction, auto.up, self.zoom)
        return self._given_view()

    def check_turning(self) -> None:
        """Refuse a view in which turning would not be visible.

        Raises
        ------
        InputError
            If it is straight from above or below.
        """
        if self.view != AUTO and _is_steep(self._given_view()):
            raise InputError("an object that turns is seen from the side; expected another view")

    def _given_view(self) -> View:
        """Return the view by its name or its angles."""
        given = "top" if self.view == FLAT else self.view
        azimuth, height = VIEWS[given] if isinstance(given, str) else given
        turn, rise = np.radians(azimuth), np.radians(height)
        level = np.cos(rise)
        direction = (np.sin(turn) * level, -np.cos(turn) * level, np.sin(rise))
        up = (0.0, 0.0, 1.0)
        if abs(height) > _STEEP:  # straight down or up: a horizontal up vector
            up = (-np.sin(turn) * np.sign(height), np.cos(turn) * np.sign(height), 0.0)
        return View(direction, up, self.zoom)


def take_shot(
    arrays: Arrays, shot: Shot, gloss: Gloss | None = None, edges: Edges | None = None
) -> NDArray[np.uint8]:
    """Return the pixels of a picture, (height, width, 3) sRGB codes; four where transparent.

    Parameters
    ----------
    arrays : see `Arrays`
    shot : Shot
    gloss : Gloss, optional
        Default: glazed porcelain.
    edges : Edges, optional
        Those of the paint, drawn sharp; by default colours are interpolated there, too.

    Raises
    ------
    MeshError
        If the arrays do not fit together.
    ExportError
        If no OpenGL can be started.
    """
    view = shot.seen_from(arrays)
    if not shot.is_lit:
        axes = _picture_axes(view)
        frame, size = _frame(arrays[0], axes, shot)
        paper = shot.paper(gloss)
        return draw_flat(*arrays[:2], arrays[3], frame, size, shot.transparent, edges, paper)
    setting = Setting(LIGHTS[shot.light], shot.transparent)
    size = shot.size or SIZE
    return draw_picture(*arrays, size=size, view=view, gloss=gloss, setting=setting, edges=edges)


def take_turning(
    arrays: Arrays,
    shot: Shot,
    n_pictures: int,
    gloss: Gloss | None = None,
    edges: Edges | None = None,
) -> Iterator[NDArray[np.uint8]]:
    """Yield the pictures of an object turning once, to the left in front, under fixed light.

    Parameters
    ----------
    arrays, shot, gloss, edges
        As for `take_shot`; the view is that of the first picture.
    n_pictures : int

    Raises
    ------
    InputError
        If the view is straight from above or below: turning would not be visible.
    MeshError, ExportError
        As `take_shot`.
    """
    turns = (2.0 * np.pi * k / n_pictures for k in range(n_pictures))
    moments = (Moment(arrays[3], turn, edges=edges) for turn in turns)
    return take_film(arrays, shot, moments, gloss, min(n_pictures, MOST_LIGHTS))


class Moment(NamedTuple):
    """One picture of a film: the colours (V, 3) uint8, and the object's angle of rotation, rad.

    Also the roughness (V,) of each vertex, 0 to 1, if they differ, and the edges of the paint, if
    they are to be sharp; for all pictures or for none.
    """

    srgb: NDArray[np.uint8]
    turn: float = 0.0
    roughness: NDArray[np.float32] | None = None
    edges: Edges | None = None


def take_film(
    arrays: Arrays,
    shot: Shot,
    moments: Iterable[Moment],
    gloss: Gloss | None = None,
    n_lights: int = 0,
) -> Iterator[NDArray[np.uint8]]:
    """Yield pictures of an object whose colours change, and which may turn under fixed light.

    Parameters
    ----------
    arrays : see `Arrays`
        With the colours of the finished painting, which determine the view and the exposure.
    shot, gloss
        As for `take_shot`.
    moments : iterable of Moment
        One for each picture; consumed one at a time.
    n_lights : int
        Number of angles per turn at which the light on the object is computed; in between it is
        interpolated. 0 for an object that does not turn: its pictures are those of `take_shot`.

    Raises
    ------
    InputError
        If it is to turn, and the view is straight from above or below.
    MeshError, ExportError
        As `take_shot`.
    """
    view = shot.seen_from(arrays)
    if not n_lights:
        axes = studio_axes(arrays[0], view)
        camera = None if not shot.is_lit else _fitted(arrays[0], axes, view, shot)
        frame, size = _frame(arrays[0], _picture_axes(view), shot)
    else:
        shot.check_turning()
        if _is_steep(view):
            view = replace(shot, view="above").seen_from(arrays)
        axes = studio_axes(arrays[0], view)
        middle = _middle(arrays[0])
        swept = _swept(arrays[0] - middle) + middle
        camera = _fitted(swept, axes, view, shot)
        frame, size = _frame(swept, _picture_axes(view), shot)
    if camera is None or not shot.is_lit:
        paper = shot.paper(gloss)
        with FlatDrawing(arrays[1], frame, size, shot.transparent, paper) as drawing:
            for moment, is_new in _news(moments):
                if is_new:
                    vertices = _turned(arrays, moment.turn)[0] if moment.turn else arrays[0]
                    pixels = drawing.pixels(vertices, moment.srgb, moment.edges)
                yield pixels
        return
    setting = Setting(LIGHTS[shot.light], shot.transparent, Stand(axes, camera))
    lights = _Lights(arrays, view, checked_size(shot.size or SIZE), setting, n_lights)
    yield from _lit(lights, moments, gloss or Gloss.of("porcelain"))


def _fitted(vertices: AnyArray, axes: AnyArray, view: View, shot: Shot) -> Camera:
    """Return the camera, in studio axes, that fits the vertices."""
    width, height = checked_size(shot.size or SIZE)
    seen = View(axes @ view.direction, axes @ view.up, view.zoom)
    return fit_camera((vertices @ axes.T.astype(np.float32)), seen, width / height)


def _middle(vertices: AnyArray) -> AnyArray:
    middle: AnyArray = (vertices.max(axis=0) + vertices.min(axis=0)) / 2
    return middle


def _turned(arrays: Arrays, turn: float) -> Arrays:
    """Rotate the object by `-turn` about the vertical axis through its middle."""
    vertices, faces, normals, srgb = arrays
    spin, middle = _spin(turn), _middle(vertices)
    moved = ((vertices - middle) @ spin.T + middle).astype(np.float32)
    return moved, faces, (normals @ spin.T).astype(np.float32), srgb


def _spin(turn: float) -> NDArray[np.float64]:
    """Return the rotation (3, 3) by `-turn` about the vertical axis."""
    c, s = np.cos(-turn), np.sin(-turn)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _lit(lights: _Lights, moments: Iterable[Moment], gloss: Gloss) -> Iterator[NDArray[np.uint8]]:
    moments = iter(moments)
    first = next(moments)
    size, transparent = lights.size, lights.setting.transparent
    if first.roughness is not None:
        gloss = replace(gloss, each=first.roughness)
    scene = lights.at(first.turn).scene(first.srgb, first.edges)
    with SceneDrawing(scene, gloss, size, transparent) as drawing:
        for k, (moment, is_new) in enumerate(_news(chain([first], moments))):
            if k and is_new:
                scene = lights.at(moment.turn).scene(moment.srgb, moment.edges)
                drawing.show(scene, moment.roughness)
            if is_new:
                pixels = develop(drawing.pixels())
            yield pixels


def _news(moments: Iterable[Moment]) -> Iterator[tuple[Moment, bool]]:
    """Moments, and whether each looks otherwise than the one before: a hand is often in the air."""
    before: tuple[Any, ...] | None = None
    for moment in moments:
        parts = (moment.srgb, moment.turn, moment.roughness, *(moment.edges or ()))
        yield moment, before is None or not all(map(np.array_equal, parts, before))
        before = parts


class _Lights:
    """The light on a turning object, computed at n angles and interpolated; results are cached."""

    def __init__(
        self, arrays: Arrays, view: View, size: tuple[int, int], setting: Setting, n: int
    ) -> None:
        self._arrays, self._view, self.size, self.setting, self._n = arrays, view, size, setting, n
        assert setting.stand is not None, "it does not move"
        axes = self._axes = setting.stand.axes.astype(np.float32)
        middle = axes.astype(np.float64) @ _middle(arrays[0])
        self._occluder = Occluder(arrays[0] @ axes.T, arrays[1], middle if n else None)
        self._still = light_object(arrays, view, size, setting, occluder=self._occluder)
        stand = setting.stand._replace(exposure=self._still.exposure)  # the same for all angles
        self._exposed = setting._replace(stand=stand)
        self._kept: dict[int, Lighting] = {}
        self._most = max(2, _KEPT_BYTES // (24 * len(arrays[0])))

    def at(self, turn: float) -> Lighting:
        """Return the object at an angle of rotation, rad, with the light on it."""
        if not self._n:
            return self._still
        position = turn / (2.0 * np.pi) * self._n
        k = int(np.floor(position + _ROUND))
        fraction = max(0.0, position - k)
        before = self._lighting(k % self._n)
        if fraction < _ROUND:
            return before
        after = self._lighting((k + 1) % self._n)
        vertices, _, normals, _ = _turned(self._arrays, turn)
        ground = before.ground
        if ground is not None and after.ground is not None:
            shade = ground.openness + fraction * (after.ground.openness - ground.openness)
            ground = replace(ground, openness=shade)
        return before._replace(
            vertices=vertices @ self._axes.T,
            normals=normals @ self._axes.T,
            light=before.light + fraction * (after.light - before.light),
            ground=ground,
        )

    def _lighting(self, k: int) -> Lighting:
        """Return the light at the k-th angle, from the cache if it is there."""
        if k not in self._kept:
            while len(self._kept) >= self._most:
                del self._kept[next(iter(self._kept))]
            turn, axes = 2.0 * np.pi * k / self._n, self._axes.astype(np.float64)
            occluder = self._occluder.turned(axes @ _spin(turn) @ axes.T)
            turned, view = _turned(self._arrays, turn), self._view
            self._kept[k] = light_object(turned, view, self.size, self._exposed, True, occluder)
        return self._kept[k]


def _is_steep(view: View) -> bool:
    """Return whether a view goes straight down or up."""
    return bool(abs(view.direction[2]) > np.sin(np.radians(_STEEP)))


def _picture_axes(view: View) -> NDArray[np.float64]:
    """Return rows right, up and toward the viewer (3, 3)."""
    right = np.cross(view.up, view.direction)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(view.direction, right), view.direction])


def _frame(
    vertices: AnyArray, axes: NDArray[np.float64], shot: Shot
) -> tuple[Frame, tuple[int, int]]:
    """Return the section of a projection that holds all vertices, and the size in pixels."""
    seen = vertices.astype(np.float64) @ axes[:2].T
    low, high = seen.min(axis=0), seen.max(axis=0)
    wide, tall = np.maximum(high - low, 1e-6 * max(float((high - low).max()), 1e-9)).tolist()
    size = shot.size
    if size is None and shot.view == FLAT:
        size = flat_size(wide, tall)
    size = checked_size(size or SIZE)
    height = max(tall, wide * size[1] / size[0])
    border = 1.0 if shot.view == FLAT else BORDER
    return Frame(axes, (low + high) / 2, border * height / shot.zoom), size


def flat_size(wide: float, tall: float) -> tuple[int, int]:
    """The usual size of a flat picture of an object, pixels: as many as a square of 1600 has."""
    scale = min(SIZE[0] / math.sqrt(wide * tall), LARGEST / max(wide, tall))
    across, down = (max(SMALLEST, round(scale * n)) for n in (wide, tall))
    return across, down


def _swept(vertices: AnyArray) -> NDArray[np.float64]:
    """Return points (N, 3) on the hull of the body that an object turning about z sweeps."""
    radius, z = np.hypot(vertices[:, 0], vertices[:, 1]), vertices[:, 2].astype(np.float64)
    span = max(float(np.ptp(z)), 1e-9)
    band = np.minimum(((z - z.min()) / span * _BANDS).astype(np.int64), _BANDS - 1)
    rings = []
    for k in np.unique(band):
        own = band == k
        rings += [(radius[own].max(), z[own].min()), (radius[own].max(), z[own].max())]
    r, height = np.array(rings).T
    turn = np.linspace(0.0, 2.0 * np.pi, _ANGLES, endpoint=False)
    x, y = np.outer(np.cos(turn), r).ravel(), np.outer(np.sin(turn), r).ravel()
    return np.stack([x, y, np.tile(height, _ANGLES)], axis=1)
