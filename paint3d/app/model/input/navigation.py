"""Moving the camera around the object, as pure steps: orbit, pan, dolly, roll, frame.

Drags are counted in pixels of a picture of some height, so that what lies under the pointer at the
focus stays under it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from paint3d.core.arrays import AnyArray, as_array, as_number, cross, length_of
from paint3d.errors import InputError
from paint3d.view.camera import Camera, picture_axes

__all__ = [
    "SIDES",
    "Ray",
    "approach",
    "dolly",
    "frame",
    "orbit",
    "pan",
    "pixels_of",
    "ray_at",
    "roll",
    "roll_at",
    "roll_of",
    "turn_to_see",
    "zoom_at",
]

_TURN_PER_HEIGHT = math.pi  # rad: a drag over the picture's height turns the object half round
_STEEPEST = math.radians(89.0)
_NO_ROLL = math.sin(math.radians(89.9))  # looked at along z from so near, nothing is upright
_FILL = 0.85
_SEEN = 0.35  # cosine of the angle to a surface from which what is on it can still be read
_NEAREST, _FARTHEST = 1e-3, 1e6  # mm, from the focus

SIDES = {
    "front": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    "back": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "right": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "left": ((-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "top": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    "bottom": ((0.0, 0.0, -1.0), (0.0, -1.0, 0.0)),
}
"""Where the camera stands to look at a side, and what is up then."""


@dataclass(frozen=True, eq=False)
class Ray:
    """A ray of sight: origin (3,) mm and unit direction (3,)."""

    origin: AnyArray
    direction: AnyArray


def orbit(camera: Camera, dx: float, dy: float, height: float, z_up: bool = True) -> Camera:
    """Turn about the focus by a drag of (dx, dy) pixels, y downwards: the object follows the hand.

    Parameters
    ----------
    camera : Camera
    dx, dy : float
    height : float
        Of the picture, pixels.
    z_up : bool
        Keep the z axis as upright in the picture as it is, however the picture is rolled; else turn
        freely.
    """
    rolled = roll_of(camera) if z_up else 0.0
    if rolled != 0.0:
        c, s = math.cos(rolled), math.sin(rolled)
        turned = orbit(roll(camera, -rolled), c * dx - s * dy, s * dx + c * dy, height)
        return roll(turned, rolled)
    per_pixel = _TURN_PER_HEIGHT / as_number(height, "height of the picture (pixels)", 1.0)
    right, up, back = picture_axes(camera)
    reach = camera.position - camera.focus
    if not z_up:
        reach = _rotate_about(_rotate_about(reach, up, -dx * per_pixel), right, -dy * per_pixel)
        new_up = _rotate_about(up, right, -dy * per_pixel)
        return replace(camera, position=camera.focus + reach, up=_unit(new_up))
    flat = right[:2] / max(length_of(right[:2]), 1e-12)
    azimuth = math.atan2(-flat[0], flat[1])  # of `back`, also where that points straight up
    elevation = math.asin(min(max(float(back[2]), -1.0), 1.0))
    azimuth -= dx * per_pixel
    elevation = min(max(elevation + dy * per_pixel, -_STEEPEST), _STEEPEST)
    level = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
    z = np.array([0.0, 0.0, 1.0])
    back = math.cos(elevation) * level + math.sin(elevation) * z
    new_up = math.cos(elevation) * z - math.sin(elevation) * level
    distance = length_of(reach)
    return replace(camera, position=camera.focus + distance * back, up=new_up)


def roll(camera: Camera, angle: float) -> Camera:
    """Turn the picture about its middle, anticlockwise, rad."""
    _, up, back = picture_axes(camera)
    return replace(camera, up=_rotate_about(up, back, -angle))


def roll_of(camera: Camera) -> float:
    """Angle by which the picture is rolled from upright, anticlockwise, rad in (-pi, pi].

    Upright is the z axis; where one looks along it the picture counts as upright.
    """
    right, up, back = picture_axes(camera)
    if abs(float(back[2])) >= _NO_ROLL:
        return 0.0
    angle = math.atan2(-float(right[2]), float(up[2]))
    return 0.0 if abs(angle) < 1e-9 else angle


def roll_at(camera: Camera, angle: float, x: float, y: float, size: tuple[float, float]) -> Camera:
    """Roll by an angle so that what is under the pointer stays there; see `roll` and `zoom_at`."""
    off_x, off_y = x - 0.5 * size[0], y - 0.5 * size[1]
    c, s = math.cos(angle), math.sin(angle)
    moved_x, moved_y = c * off_x + s * off_y, -s * off_x + c * off_y
    return pan(roll(camera, angle), off_x - moved_x, off_y - moved_y, size[1])


def pan(camera: Camera, dx: float, dy: float, height: float) -> Camera:
    """Move along the picture by a drag of (dx, dy) pixels: the focus follows the hand."""
    right, up, _ = picture_axes(camera)
    shift = _mm_per_pixel(camera, height) * (dy * up - dx * right)
    return replace(camera, position=camera.position + shift, focus=camera.focus + shift)


def dolly(camera: Camera, factor: float) -> Camera:
    """Go nearer (factor over 1) or farther; the distance to the focus is divided by it."""
    factor = as_number(factor, "dolly (factor)", 1e-6, 1e6)
    reach = camera.position - camera.focus
    distance = length_of(reach)
    wanted = min(max(distance / factor, _NEAREST), _FARTHEST)
    return replace(camera, position=camera.focus + reach * (wanted / distance))


def zoom_at(camera: Camera, factor: float, x: float, y: float, size: tuple[float, float]) -> Camera:
    """Go nearer so that what is under the pointer, as far off as the focus, stays there.

    Parameters
    ----------
    camera : Camera
    factor : float
        See `dolly`.
    x, y : float
        Pixels, from the picture's upper left corner.
    size : (float, float)
        Width and height of the picture, pixels.
    """
    off_x, off_y = x - 0.5 * size[0], y - 0.5 * size[1]
    nearer = dolly(camera, factor)
    before, after = _mm_per_pixel(camera, size[1]), _mm_per_pixel(nearer, size[1])
    right, up, _ = picture_axes(camera)
    shift = (before - after) * (off_x * right - off_y * up)
    return replace(nearer, position=nearer.position + shift, focus=nearer.focus + shift)


def turn_to_see(camera: Camera, points: ArrayLike, normals: ArrayLike) -> Camera:
    """Turn about the z axis through the focus until what stands on a body is on its near side.

    Parameters
    ----------
    camera : Camera
    points, normals : (N, 3) array_like
        Where it stands, mm, and unit vectors outwards.

    Returns
    -------
    Camera
        The same where half of it can be read already, or it stands all around.
    """
    points, normals = as_array(points, "points", (None, 3)), as_array(normals, "normals", (None, 3))
    toward = camera.position - points
    seen = np.sum(toward * normals, axis=1) > _SEEN * np.linalg.norm(toward, axis=1)
    x, y, _ = normals.mean(axis=0)
    if seen.mean() >= 0.5 or math.hypot(x, y) < _SEEN:
        return camera
    back = camera.position - camera.focus
    angle, z = math.atan2(y, x) - math.atan2(back[1], back[0]), np.array([0.0, 0.0, 1.0])
    return replace(
        camera,
        position=camera.focus + _rotate_about(back, z, angle),
        up=_rotate_about(camera.up, z, angle),
    )


def frame(camera: Camera, centre: ArrayLike, radius: float, aspect: float = 1.0) -> Camera:
    """Look at a ball from the same side, so that it fills the picture.

    Parameters
    ----------
    camera : Camera
    centre : (3,) array_like
        mm.
    radius : float
        mm; above 0.
    aspect : float
        Width of the picture over its height.
    """
    centre = as_array(centre, "centre", (3,))
    radius = as_number(radius, "radius (mm)", 1e-6)
    aspect = as_number(aspect, "aspect", 1e-3, 1e3)
    half = 0.5 * camera.view_angle
    half = min(half, math.atan(math.tan(half) * aspect))
    distance = radius / (_FILL * math.sin(half))
    _, up, back = picture_axes(camera)
    return replace(camera, position=centre + distance * back, focus=centre, up=up)


def approach(camera: Camera, centre: ArrayLike, radius: float, aspect: float = 1.0) -> Camera:
    """Look at a ball from near, and never from farther than now; arguments as of `frame`."""
    nearer = frame(camera, centre, radius, aspect)
    now = length_of(camera.position - camera.focus)
    wanted = length_of(nearer.position - nearer.focus)
    return nearer if wanted <= now else dolly(nearer, wanted / now)


def ray_at(camera: Camera, x: float, y: float, size: tuple[float, float]) -> Ray:
    """The ray of sight through a pixel; arguments as of `zoom_at`."""
    width, height = (as_number(s, "size of the picture (pixels)", 1.0) for s in size)
    right, up, back = picture_axes(camera)
    per_pixel = 2.0 * math.tan(0.5 * camera.view_angle) / height
    across, upwards = (x - 0.5 * width) * per_pixel, (0.5 * height - y) * per_pixel
    return Ray(np.array(camera.position), _unit(across * right + upwards * up - back))


def pixels_of(camera: Camera, points: ArrayLike, size: tuple[float, float]) -> AnyArray:
    """Project points (N, 3) to the picture: (N, 2) pixels, y down; NaN behind the camera."""
    width, height = (as_number(s, "size of the picture (pixels)", 1.0) for s in size)
    right, up, back = picture_axes(camera)
    away = np.asarray(points, np.float64) - camera.position
    depth = -(away @ back)
    per_mm = 0.5 * height / (math.tan(0.5 * camera.view_angle) * np.where(depth > 0, depth, np.nan))
    return np.stack(
        [0.5 * width + away @ right * per_mm, 0.5 * height - away @ up * per_mm], axis=1
    )


def _mm_per_pixel(camera: Camera, height: float) -> float:
    """Size of a pixel as far off as the focus."""
    height = as_number(height, "height of the picture (pixels)", 1.0)
    distance = length_of(camera.position - camera.focus)
    return 2.0 * distance * math.tan(0.5 * camera.view_angle) / height


def _rotate_about(vector: AnyArray, axis: AnyArray, angle: float) -> AnyArray:
    """Rodrigues' rotation about a unit axis."""
    across, along = cross(axis, vector), axis @ vector
    return (
        math.cos(angle) * vector + math.sin(angle) * across + (1 - math.cos(angle)) * along * axis
    )


def _unit(vector: AnyArray) -> AnyArray:
    length = length_of(vector)
    if length < 1e-12:
        raise InputError("the camera stands at its focus, or looks along its own up")
    return vector / length
