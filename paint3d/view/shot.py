"""Pictures as people ask for them: from the front, from above, flat, in some light, turning."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, as_number
from paint3d.errors import InputError, UnknownNameError
from paint3d.view.camera import Camera, View, find_view, fit_camera, studio_axes, vertex_areas
from paint3d.view.picture import (
    Lighting,
    Setting,
    Stand,
    checked_size,
    develop,
    draw_picture,
    light_object,
)
from paint3d.view.scene import FlatDrawing, Frame, SceneDrawing, draw_flat
from paint3d.view.studio import LIGHTS, Gloss, srgb_to_linear

__all__ = [
    "AUTO",
    "FLAT",
    "UNLIT",
    "VIEWS",
    "Moment",
    "Shot",
    "take_film",
    "take_shot",
    "take_turning",
]

AUTO, FLAT, UNLIT = "auto", "flat", "none"
VIEWS = {  # azimuth from the front (-y) toward the right (+x), and height, degrees
    "front": (0.0, 15.0),
    "right": (90.0, 15.0),
    "back": (180.0, 15.0),
    "left": (270.0, 15.0),
    "above": (0.0, 45.0),
    "top": (0.0, 90.0),
    "bottom": (0.0, -90.0),
}
SIZE = (1600, 1200)
BORDER = 1.06  # of a projection's frame over what is in it
_ANGLES, _BANDS = 24, 32  # of the body that an object sweeps when it turns
_KEPT_BYTES = 300_000_000  # of the light on an object as it turns, about
_ROUND = 1e-6
_STEEP = 89.9  # degrees, from which +y points up in the picture (from below, too)

Arrays = tuple[AnyArray, AnyArray, AnyArray, AnyArray]
"""Vertices (V, 3) float32 mm, faces (F, 3) int32, unit normals (V, 3), srgb (V, 3) uint8."""


@dataclass(frozen=True)
class Shot:
    """How a picture is to be taken.

    Attributes
    ----------
    view : str or (float, float)
        "auto": onto the painted side; "front" (-y), "right", "back", "left", "above", "top",
        "bottom"; azimuth and height in degrees, as of `VIEWS`; or "flat": straight from above,
        to scale, without light and without a border.
    size : (int, int) or None
        Pixels, each 16 to 4096; None: 1600 x 1200, for "flat" the shape of the object.
    light : str
        One of `LIGHTS`, or "none": every colour as it was painted, in a parallel projection.
    transparent : bool
        Leave out the ground and whatever is behind.
    zoom : float
        0.1 to 20; 1 shows the object as large as it can be.

    Raises
    ------
    InputError
        If a value is not possible.
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
        """Whether light falls on the object."""
        return self.light != UNLIT and self.view != FLAT

    def seen_from(self, arrays: Arrays) -> View:
        """The side that is looked at."""
        if self.view == AUTO:
            vertices, faces, normals, srgb = arrays
            found = find_view(vertices, normals, srgb, vertex_areas(vertices, faces))
            return View(found.direction, found.up, self.zoom)
        return self._told_view()

    def check_turning(self) -> None:
        """Refuse a view from which no object is seen to turn.

        Raises
        ------
        InputError
            If it is straight from above or below.
        """
        if self.view != AUTO and _is_steep(self._told_view()):
            raise InputError("an object that turns is seen from the side; expected another view")

    def _told_view(self) -> View:
        told = "top" if self.view == FLAT else self.view
        azimuth, height = VIEWS[told] if isinstance(told, str) else told
        turn, rise = np.radians(azimuth), np.radians(height)
        level = np.cos(rise)
        direction = (np.sin(turn) * level, -np.cos(turn) * level, np.sin(rise))
        up = (0.0, 0.0, 1.0)
        if abs(height) > _STEEP:  # what lies away from the viewer is above
            up = (-np.sin(turn) * np.sign(height), np.cos(turn) * np.sign(height), 0.0)
        return View(direction, up, self.zoom)


def take_shot(arrays: Arrays, shot: Shot, gloss: Gloss | None = None) -> NDArray[np.uint8]:
    """Return the pixels of a picture, (height, width, 3) sRGB codes; four where transparent.

    Parameters
    ----------
    arrays : see `Arrays`
    shot : Shot
    gloss : Gloss, optional
        Default: glazed porcelain.

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
        return draw_flat(*arrays[:2], arrays[3], frame, size, shot.transparent)
    setting = Setting(LIGHTS[shot.light], shot.transparent)
    return draw_picture(*arrays, size=shot.size or SIZE, view=view, gloss=gloss, setting=setting)


def take_turning(
    arrays: Arrays, shot: Shot, n_pictures: int, gloss: Gloss | None = None
) -> Iterator[NDArray[np.uint8]]:
    """Yield the pictures of an object that turns once, to the left in front, under still light.

    Parameters
    ----------
    arrays, shot, gloss
        As for `take_shot`; the view is that of the first picture.
    n_pictures : int

    Raises
    ------
    InputError
        If the view is straight from above or below: nothing would be seen of the turning.
    MeshError, ExportError
        As `take_shot`.
    """
    moments = (Moment(arrays[3], 2.0 * np.pi * k / n_pictures) for k in range(n_pictures))
    return take_film(arrays, shot, moments, gloss, n_pictures)


class Moment(NamedTuple):
    """One picture of a film: the colours (V, 3) uint8, and how far the object has turned, rad.

    And the roughness (V,) of each vertex, 0 to 1, where they differ; of all pictures or of none.
    """

    srgb: NDArray[np.uint8]
    turn: float = 0.0
    roughness: NDArray[np.float32] | None = None


def take_film(
    arrays: Arrays,
    shot: Shot,
    moments: Iterable[Moment],
    gloss: Gloss | None = None,
    n_lights: int = 0,
) -> Iterator[NDArray[np.uint8]]:
    """Yield pictures of an object whose colours change, and which may turn under still light.

    Parameters
    ----------
    arrays : see `Arrays`
        With the colours of the finished painting: by them the side that is looked at is found, and
        how the picture is exposed.
    shot, gloss
        As for `take_shot`.
    moments : iterable of Moment
        One for each picture; asked for one after the other.
    n_lights : int
        How often it is found in a turn what light falls on the object; between two it is mixed. 0
        for an object that does not turn: its pictures are those of `take_shot`.

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
        yield from _unlit(arrays, moments, FlatDrawing(arrays[1], frame, size, shot.transparent))
        return
    setting = Setting(LIGHTS[shot.light], shot.transparent, Stand(axes, camera))
    lights = _Lights(arrays, view, checked_size(shot.size or SIZE), setting, n_lights)
    yield from _lit(lights, moments, gloss or Gloss.of("porcelain"))


def _fitted(vertices: AnyArray, axes: AnyArray, view: View, shot: Shot) -> Camera:
    width, height = checked_size(shot.size or SIZE)
    seen = View(axes @ view.direction, axes @ view.up, view.zoom)
    return fit_camera((vertices @ axes.T.astype(np.float32)), seen, width / height)


def _middle(vertices: AnyArray) -> AnyArray:
    middle: AnyArray = (vertices.max(axis=0) + vertices.min(axis=0)) / 2
    return middle


def _turned(arrays: Arrays, turn: float) -> Arrays:
    vertices, faces, normals, srgb = arrays
    spin, middle = _spin(-turn), _middle(vertices)
    there = ((vertices - middle) @ spin.T + middle).astype(np.float32)
    return there, faces, (normals @ spin.T).astype(np.float32), srgb


def _unlit(
    arrays: Arrays, moments: Iterable[Moment], drawing: FlatDrawing
) -> Iterator[NDArray[np.uint8]]:
    with drawing:
        for moment in moments:
            vertices = _turned(arrays, moment.turn)[0] if moment.turn else arrays[0]
            yield drawing.pixels(vertices, moment.srgb)


def _lit(lights: _Lights, moments: Iterable[Moment], gloss: Gloss) -> Iterator[NDArray[np.uint8]]:
    moments = iter(moments)
    first = next(moments)
    size, transparent = lights.size, lights.setting.transparent
    if first.roughness is not None:
        gloss = replace(gloss, each=first.roughness)
    scene = lights.at(first.turn).scene(srgb_to_linear(first.srgb))
    with SceneDrawing(scene, gloss, size, transparent) as drawing:
        yield develop(drawing.pixels())
        for moment in moments:
            scene = lights.at(moment.turn).scene(srgb_to_linear(moment.srgb))
            drawing.show(scene, moment.roughness)
            yield develop(drawing.pixels())


class _Lights:
    """The light on an object as it turns, found so often in a turn, and mixed between."""

    def __init__(
        self, arrays: Arrays, view: View, size: tuple[int, int], setting: Setting, n: int
    ) -> None:
        self._arrays, self._view, self.size, self.setting, self._n = arrays, view, size, setting, n
        self._still = light_object(arrays, view, size, setting)
        assert setting.stand is not None, "it does not move"
        stand = setting.stand._replace(exposure=self._still.exposure)  # one for all
        self._exposed = setting._replace(stand=stand)
        self._kept: dict[int, Lighting] = {}
        self._most = max(2, _KEPT_BYTES // (24 * len(arrays[0])))

    def at(self, turn: float) -> Lighting:
        """The object there, and the light on it then."""
        if not self._n:
            return self._still
        place = turn / (2.0 * np.pi) * self._n
        before = int(np.floor(place + _ROUND))
        share = max(0.0, place - before)
        near = self._found(before % self._n)
        if share < _ROUND:
            return near
        after = self._found((before + 1) % self._n)
        vertices, _, normals, _ = _turned(self._arrays, turn)
        axes = self._axes
        return near._replace(
            vertices=vertices @ axes.T,
            normals=normals @ axes.T,
            light=near.light + share * (after.light - near.light),
            ground=near.ground if share < 0.5 else after.ground,
        )

    @property
    def _axes(self) -> AnyArray:
        assert self._exposed.stand is not None, "it does not move"
        axes: AnyArray = self._exposed.stand.axes.astype(np.float32)
        return axes

    def _found(self, k: int) -> Lighting:
        if k not in self._kept:
            while len(self._kept) >= self._most:
                del self._kept[next(iter(self._kept))]
            there = _turned(self._arrays, 2.0 * np.pi * k / self._n)
            view, size, setting = self._view, self.size, self._exposed
            self._kept[k] = light_object(there, view, size, setting, everywhere=True)
        return self._kept[k]


def _is_steep(view: View) -> bool:
    """Whether it goes straight down or up."""
    return bool(abs(view.direction[2]) > np.sin(np.radians(_STEEP)))


def _picture_axes(view: View) -> NDArray[np.float64]:
    right = np.cross(view.up, view.direction)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(view.direction, right), view.direction])


def _frame(
    vertices: AnyArray, axes: NDArray[np.float64], shot: Shot
) -> tuple[Frame, tuple[int, int]]:
    """The part of a projection that holds all vertices, and the picture's size in pixels."""
    seen = vertices.astype(np.float64) @ axes[:2].T
    low, high = seen.min(axis=0), seen.max(axis=0)
    wide, tall = np.maximum(high - low, 1e-6 * max(float((high - low).max()), 1e-9)).tolist()
    size = shot.size
    if size is None and shot.view == FLAT:
        longest = SIZE[0] / max(wide, tall)
        across, down = (int(np.clip(round(n * longest), 16, SIZE[0])) for n in (wide, tall))
        size = across, down
    size = checked_size(size or SIZE)
    height = max(tall, wide * size[1] / size[0])
    border = 1.0 if shot.view == FLAT else BORDER
    return Frame(axes, (low + high) / 2, border * height / shot.zoom), size


def _swept(vertices: AnyArray) -> NDArray[np.float64]:
    """Points (N, 3) around the body that an object sweeps when it turns about z through 0."""
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


def _spin(turn: float) -> NDArray[np.float64]:
    c, s = np.cos(turn), np.sin(turn)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
