"""Walking around the object: turn, shift, come nearer; never upside down."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.view.camera import Camera, View, fit_camera, is_flat, studio_axes

__all__ = ["Orbit", "pixel_ray"]

_TURN = 0.0085  # rad a pixel
_NEARER = 0.88  # of the distance, a notch
_STEEPEST = np.radians(89.0)
_FRONT = View((0.12, -1.0, 0.62))
_NEAREST, _FARTHEST = 0.02, 8.0  # of the object's size
SIDES = {"front": (0, -1, 0.0), "right": (1, 0, 0.0), "top": (0, -0.02, 1.0)}


class Orbit:
    """A camera on a sphere around what it looks at.

    Parameters
    ----------
    points : (V, 3) array
        The object, mm.
    aspect : float
        Width over height of the picture.
    """

    def __init__(self, points: NDArray, aspect: float) -> None:
        self._points = points
        self._size = float(np.linalg.norm(np.ptp(points, axis=0)))
        self.aspect = aspect
        self.frame()

    @property
    def camera(self) -> Camera:
        """Where it looks from now."""
        back = self._back()
        return Camera(self._focus + self._distance * back, self._focus, self._up(), self._angle)

    def turned(self, angle: float) -> Camera:
        """Where it would look from had the object been turned by so much (rad) on its foot."""
        kept = self._azimuth
        self._azimuth = kept - angle
        camera, self._azimuth = self.camera, kept
        return camera

    def frame(self, side: str | None = None) -> None:
        """See the whole object: from where it was painted at first, or from a side."""
        view = _FRONT
        if side is not None:
            view = View(SIDES[side], (0, 0, 1))
        elif is_flat(self._points):
            axes = studio_axes(self._points, View((0.0, -0.6, 1.0)))
            view = View(axes.T @ np.array([0.0, -0.45, 1.0]), axes[1])
        camera = fit_camera(self._points, view, self.aspect)
        back = camera.position - camera.focus
        self._distance = float(np.linalg.norm(back))
        back /= self._distance
        self._focus, self._angle = camera.focus.copy(), camera.view_angle
        self._azimuth = float(np.arctan2(back[1], back[0]))
        self._elevation = float(np.arcsin(np.clip(back[2], -1.0, 1.0)))
        self._elevation = float(np.clip(self._elevation, -_STEEPEST, _STEEPEST))

    def turn(self, right: float, down: float) -> None:
        """Turn the object by a drag of so many pixels."""
        self._azimuth -= _TURN * right
        self._elevation = float(np.clip(self._elevation + _TURN * down, -_STEEPEST, _STEEPEST))

    def shift(self, right: float, down: float, height: int) -> None:
        """Move the object by a drag of so many pixels in a picture `height` pixels high."""
        mm = 2.0 * self._distance * np.tan(0.5 * self._angle) / height
        up = self._up()
        across = np.cross(up, self._back())
        self._focus = self._focus - mm * right * across + mm * down * up

    def nearer(self, notches: float, toward: NDArray | None = None) -> None:
        """Come nearer, so that the point `toward` (3,) stays where it is seen."""
        factor = _NEARER**notches
        wanted = self._distance * factor
        wanted = min(max(wanted, _NEAREST * self._size), _FARTHEST * self._size)
        factor = wanted / self._distance
        if toward is not None:
            self._focus = toward + factor * (self._focus - toward)
        self._distance = wanted

    def _back(self) -> NDArray:
        level = np.cos(self._elevation)
        return np.array(
            [level * np.cos(self._azimuth), level * np.sin(self._azimuth), np.sin(self._elevation)]
        )

    def _up(self) -> NDArray:
        height = np.sin(self._elevation)
        level = np.cos(self._elevation)
        return np.array([-height * np.cos(self._azimuth), -height * np.sin(self._azimuth), level])


def pixel_ray(camera: Camera, size: tuple[float, float], x: float, y: float) -> tuple:
    """Origin and unit direction (3,) of the ray through a pixel, y down."""
    width, height = size
    ahead = camera.focus - camera.position
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, camera.up)
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    half = np.tan(0.5 * camera.view_angle)
    across = (2.0 * x / width - 1.0) * half * width / height
    direction = ahead + across * right + (1.0 - 2.0 * y / height) * half * up
    return camera.position, direction / np.linalg.norm(direction)
