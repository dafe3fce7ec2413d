"""Camera placement: find the painted side, and fit a camera to the object."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_array, as_number, cross
from paint3d.errors import InputError

__all__ = [
    "Camera",
    "View",
    "find_view",
    "fit_camera",
    "is_flat",
    "picture_axes",
    "studio_axes",
    "vertex_areas",
]

VIEW_ANGLE = np.radians(24.0)  # a long lens: little perspective, as in product photography
FILL = 0.80  # fraction of the frame's half-width or half-height that the object may fill
FLAT_FILL = 0.92
FLAT_RATIO = 0.05  # thickness over length below which an object counts as a sheet
PAINT_STEP = 12  # least difference from the bare colour, sRGB steps, of a painted vertex
LEVEL_RATIO = 0.3  # horizontal over vertical part of a normal below which it points up or down
LOWEST, HIGHEST, RAISED = np.radians([16.0, 58.0, 14.0])  # elevations: bounds, and offset
_TURNS = 24  # level directions that are tried
_ALIKE = 0.97  # of the most paint that is seen: as good, where it is nearer to the front
Z_AXIS = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class View:
    """A side to look at.

    Parameters
    ----------
    direction : (3,) array_like
        From the object toward the camera, in the object's frame; any length but 0.
    up : (3,) array_like
        Up in the picture, normal to the ground. Not parallel to `direction`.
    zoom : float
        1 fills the frame with the object, 2 shows half of it; 0.1 to 20.

    Raises
    ------
    InputError
        If a vector is 0 or not three finite numbers, both are parallel, or zoom is out of range.
    """

    direction: NDArray[np.float64]
    up: NDArray[np.float64] = (0.0, 0.0, 1.0)  # type: ignore[assignment]  # made an array below
    zoom: float = 1.0

    if TYPE_CHECKING:  # the constructor accepts more types than the fields hold

        def __init__(
            self, direction: ArrayLike, up: ArrayLike = ..., zoom: float = 1.0
        ) -> None: ...

    def __post_init__(self) -> None:
        direction = _unit(as_array(self.direction, "view direction", (3,)), "view direction")
        up = _unit(as_array(self.up, "view up", (3,)), "view up")
        if np.linalg.norm(np.cross(direction, up)) < 1e-6:
            raise InputError(
                "view up {up} is parallel to the direction {direction}",
                up=self.up,
                direction=self.direction,
            )
        object.__setattr__(self, "direction", direction)
        object.__setattr__(self, "up", up)
        object.__setattr__(self, "zoom", as_number(self.zoom, "view zoom", 0.1, 20.0))


@dataclass(frozen=True, eq=False)
class Camera:
    """A placed camera: `position` and `focus` in mm, unit `up`, vertical `view_angle` in rad."""

    position: NDArray[np.float64]
    focus: NDArray[np.float64]
    up: NDArray[np.float64]
    view_angle: float


@lru_cache(maxsize=4)  # called with every move of a pen
def picture_axes(camera: Camera) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Return unit vectors right and up in the picture, and back towards the viewer; read-only.

    Raises
    ------
    InputError
        If the camera stands at its focus, or looks along its own up.
    """
    back = _unit(camera.position - camera.focus, "camera's way to its focus")
    right = _unit(cross(camera.up, back), "way across a camera's view and its up")
    axes = right, cross(back, right), back
    for axis in axes:
        axis.flags.writeable = False
    return axes


def vertex_areas(vertices: AnyArray, faces: AnyArray) -> NDArray[np.float64]:
    """Return a third of the area of the faces around each vertex, (V,) mm^2."""
    a, b, c = (vertices[faces[:, k]].astype(np.float64) for k in range(3))
    third = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    return np.bincount(faces.ravel(), np.repeat(third, 3), len(vertices)).astype(np.float64)


def is_flat(vertices: AnyArray) -> bool:
    """Return whether the object is a sheet: far thinner than long, in any orientation."""
    spread = vertices - vertices.mean(axis=0, dtype=np.float64)
    axes = np.linalg.eigh(spread.T @ spread)[1]
    extents = np.ptp(spread @ axes, axis=0)
    return bool(extents.min() < FLAT_RATIO * extents.max() and np.sort(extents)[1] > 0)


def find_view(
    vertices: AnyArray, normals: AnyArray, srgb: NDArray[np.uint8], areas: AnyArray
) -> View:
    """Return the view onto the painted side, from slightly above; a sheet is viewed squarely.

    A vertex is painted if it differs from the colour covering the largest area. Without paint the
    object is viewed from the front (-y). Paint that faces no side more than others is viewed from
    the side that shows most of it, or from above where that shows more, as within a bowl.

    Parameters
    ----------
    vertices, normals : (V, 3) arrays, mm and unit vectors
    srgb : (V, 3) uint8
    areas : (V,) mm^2
    """
    weights = _paint_weights(srgb, areas)
    facing = weights @ normals
    if is_flat(vertices):
        return _sheet_view(vertices, facing if weights.any() else areas @ normals)
    total = weights.sum()
    level = np.hypot(facing[0], facing[1])
    if total > 0 and (
        np.linalg.norm(facing) < 0.25 * total or level <= LEVEL_RATIO * abs(facing[2])
    ):
        painted = weights > 0
        away = vertices[painted] - areas @ vertices / areas.sum()
        facing = _most_seen(weights[painted], normals[painted], away)
    return _raised_view(facing)


def fit_camera(vertices: AnyArray, view: View, aspect: float) -> Camera:
    """Return the camera that sees all `vertices` as large as the frame allows.

    Parameters
    ----------
    vertices : (V, 3) array, mm
    view : View
    aspect : float
        Width over height of the picture.
    """
    back = view.direction
    right = _unit(np.cross(view.up, back), "right")
    up = np.cross(back, right)
    x, y, z = (vertices @ np.stack([right, up, back]).T).astype(np.float64).T
    tall = np.tan(VIEW_ANGLE / 2) * (FLAT_FILL if is_flat(vertices) else FILL)
    wide = tall * aspect
    cx, cy = (x.max() + x.min()) / 2, (y.max() + y.min()) / 2
    for _ in range(8):  # centre and distance depend on each other: iterate
        eye = np.max(z + np.maximum(np.abs(x - cx) / wide, np.abs(y - cy) / tall))
        depth = eye - z
        seen_x, seen_y = (x - cx) / depth, (y - cy) / depth
        middle = depth.mean()
        cx += middle * (seen_x.max() + seen_x.min()) / 2
        cy += middle * (seen_y.max() + seen_y.min()) / 2
    focus = cx * right + cy * up + z.mean() * back
    angle = 2 * np.arctan(np.tan(VIEW_ANGLE / 2) / view.zoom)
    return Camera(focus + (eye - z.mean()) * back, focus, up, float(angle))


def studio_axes(vertices: AnyArray, view: View) -> NDArray[np.float64]:
    """Return rows right, away from the camera and up: the studio's axes in the object's frame.

    Up is the view's; for a sheet viewed from above it is the sheet's normal, so that the sheet lies
    on the ground.
    """
    up = view.up
    if is_flat(vertices):
        normal = _thin_axis(vertices)
        normal = normal if normal @ view.direction > 0 else -normal
        up = normal if normal @ view.direction > 0.7 else up
    away = -view.direction if abs(view.direction @ up) < 0.99 else view.up
    away = _unit(away - (away @ up) * up, "view direction")
    return np.stack([np.cross(away, up), away, up])


def _thin_axis(vertices: AnyArray) -> NDArray[np.float64]:
    """Return the axis (3,) of least variance: a sheet's normal, of either sign."""
    spread = vertices - vertices.mean(axis=0, dtype=np.float64)
    return np.linalg.eigh(spread.T @ spread)[1][:, 0]


def _paint_weights(srgb: AnyArray, areas: AnyArray) -> NDArray[np.float64]:
    """Return area times difference from the bare colour of painted vertices (V,), else 0."""
    packed = srgb.astype(np.int64) @ np.array([65536, 256, 1])
    colours, index = np.unique(packed, return_inverse=True)
    bare = colours[np.argmax(np.bincount(index, areas))]
    bare_srgb = np.array([bare >> 16, bare >> 8 & 255, bare & 255])
    away = np.abs(srgb.astype(np.int64) - bare_srgb).max(axis=1)
    return np.where(away >= PAINT_STEP, areas * away, 0.0)


def _sheet_view(vertices: AnyArray, facing: AnyArray) -> View:
    normal = _thin_axis(vertices)
    normal = normal if normal @ facing >= 0 else -normal
    up = Z_AXIS if abs(normal[2]) < 0.7 else np.array([0.0, 1.0, 0.0])
    return View(normal, _unit(up - (up @ normal) * normal, "up"))


def _most_seen(weights: AnyArray, normals: AnyArray, away: AnyArray) -> NDArray[np.float64]:
    """Return what faces most of the paint that is seen: a level direction (3,), or straight up.

    From the side, paint that faces the object's middle is hidden by what is before it; from above
    one looks over the rim.

    Parameters
    ----------
    weights : (N,), of painted vertices
    normals : (N, 3)
    away : (N, 3)
        Their places from the object's middle.
    """
    turn = 2 * np.pi * np.arange(_TURNS) / _TURNS
    turn = np.where(turn > np.pi, turn - 2 * np.pi, turn)  # from the front
    turn = turn[np.argsort(np.abs(turn), kind="stable")]
    level = np.stack([np.sin(turn), -np.cos(turn), np.zeros(_TURNS)], axis=1)
    low, high = (np.cos(rise) * level + np.sin(rise) * Z_AXIS for rise in (LOWEST, HIGHEST))
    outward = np.sum(normals[:, :2] * away[:, :2], axis=1) > 0
    from_side = weights[outward] @ np.maximum(normals[outward] @ low.T, 0.0)
    from_above = float(weights @ np.maximum(normals @ high[0], 0.0))
    if from_above > from_side.max():
        return Z_AXIS
    found: NDArray[np.float64] = level[np.argmax(from_side >= _ALIKE * from_side.max())]
    return found


def _raised_view(facing: AnyArray) -> View:
    """Return the view onto a side that faces (3,), raised by `RAISED` within bounds."""
    level = np.hypot(facing[0], facing[1])
    if level <= LEVEL_RATIO * abs(facing[2]) or level < 1e-12:  # faces up or down: from the front
        upward = HIGHEST if facing[2] > 0 else LOWEST
        facing, level = np.array([0.0, -1.0, np.tan(upward - RAISED)]), 1.0
    elevation = np.clip(np.arctan2(facing[2], level) + RAISED, LOWEST, HIGHEST)
    flat = facing[:2] / np.hypot(*facing[:2])
    return View(np.append(flat * np.cos(elevation), np.sin(elevation)), Z_AXIS)


def _unit(vector: AnyArray, name: str) -> NDArray[np.float64]:
    length = np.linalg.norm(vector)
    if length < 1e-12:
        raise InputError("{name} has length 0; expected a direction", name=name)
    result: NDArray[np.float64] = vector / length
    return result
