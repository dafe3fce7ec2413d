"""Strokes of a pen at random places of whatever is open, from whatever side it is seen."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from paint3d.app.model.input import navigation
from paint3d.app.window.studio import StudioWindow
from paint3d.mesh.bvh import ClosestPoints
from tests.support.app.event_player import DeviceEvent, EventRecording, surface_of

__all__ = ["random_strokes"]

STEP_MS = 10
SPEED_MM_S = 80.0
FACING = 0.3  # least cosine between the ray and the surface's normal: no stroke around an edge
MOST_STEP = 3.0  # of a ray's hits, over a pixel's size there: more is a leap to what lies behind
TRIES = 4000


def random_strokes(
    window: StudioWindow,
    rng: Generator,
    n: int,
    side: str = "any",
    *,
    tilt_degrees: float = 0.0,
    pressure: float = 0.25,
    lengths_mm: tuple[float, float] = (20.0, 50.0),
) -> Iterator[EventRecording]:
    """Recordings of one stroke each; the window looks from where each of them is to be played.

    Parameters
    ----------
    window : StudioWindow
    rng : Generator
    n : int
    side : {"any", "in", "out"}
        Of a vessel about the z axis.
    tilt_degrees : float
        The most that the pen leans, to any side.
    pressure : float
    lengths_mm : (float, float)
        Of the strokes, as far as the surface goes.
    """
    surface = surface_of(window)
    for _ in range(n):
        for _ in range(TRIES):
            _turn(window, rng, side)
            way = _way(window, surface, rng, lengths_mm, side)
            if way is not None:
                break
        else:
            raise AssertionError(f"no place for a stroke on the side {side!r}")
        yield _recording(window, way, _tilt(rng, tilt_degrees), pressure)


def _turn(window: StudioWindow, rng: Generator, side: str) -> None:
    """Look from anywhere; into a vessel from above."""
    window.hand.show_all()
    height = window.canvas.height()
    lowest = 0.05 if side == "in" else -0.25
    turned = navigation.orbit(
        window.hand.camera, rng.uniform(-1, 1) * height, rng.uniform(lowest, 0.25) * height, height
    )
    window.hand.look(navigation.dolly(turned, rng.uniform(1.0, 1.5)))


def _way(
    window: StudioWindow, surface: ClosestPoints, rng: Generator, lengths, side: str
) -> NDArray | None:
    """Shares (N, 2) of the canvas on a smooth part of the surface; None where there is none."""
    size = np.array([window.canvas.width(), window.canvas.height()], float)
    start = rng.uniform(0.1, 0.9, 2) * size
    camera = window.hand.camera
    there = _meet(camera, surface, start[None], size)
    if there is None:
        return None
    away = float(np.linalg.norm(there[0][0] - camera.position))
    pixel_mm = 2.0 * math.tan(0.5 * camera.view_angle) * away / size[1]
    length = rng.uniform(*lengths) / pixel_mm
    angle = rng.uniform(0.0, 2.0 * math.pi)
    bow = rng.uniform(-0.2, 0.2)
    t = np.linspace(0.0, 1.0, math.ceil(1000.0 / STEP_MS * length * pixel_mm / SPEED_MM_S) + 1)
    line = length * np.stack([t, bow * np.sin(math.pi * t)], axis=1)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    pixels = start + line @ turn
    if (pixels < 0.05 * size).any() or (pixels > 0.95 * size).any():
        return None
    found = _meet(camera, surface, pixels, size)
    if found is None or not _is_smooth(found, pixels, pixel_mm, camera.position, side):
        return None
    return pixels / size


def _is_smooth(found, pixels: NDArray, pixel_mm: float, eye: NDArray, side: str) -> bool:
    points, normals = found
    to_eye = eye - points
    to_eye /= np.linalg.norm(to_eye, axis=1, keepdims=True)
    if (np.einsum("ij,ij->i", to_eye, normals) < FACING).any():
        return False
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    moved = pixel_mm * np.linalg.norm(np.diff(pixels, axis=0), axis=1)
    if (steps > MOST_STEP / FACING * moved).any():
        return False
    outward = np.einsum("ij,ij->i", points[:, :2], normals[:, :2])
    return side == "any" or bool((outward > 0.0).all() if side == "out" else (outward < 0.0).all())


def _meet(camera, surface: ClosestPoints, pixels: NDArray, size) -> tuple[NDArray, NDArray] | None:
    rays = [navigation.ray_at(camera, x, y, tuple(size)) for x, y in pixels]
    hits = surface.cast(
        np.array([ray.origin for ray in rays]), np.array([ray.direction for ray in rays])
    )
    if not hits.hit.all():
        return None
    return hits.points, surface.find(hits.points).normals


def _tilt(rng: Generator, most: float) -> tuple[float, float]:
    """Any lean up to the most, to any side, as a tablet tells it."""
    slope, side = math.tan(math.radians(rng.uniform(0.0, most))), rng.uniform(0.0, 2.0 * math.pi)
    x, y = slope * math.cos(side), slope * math.sin(side)
    return math.degrees(math.atan(x)), math.degrees(math.atan(y))


def _recording(window: StudioWindow, way: NDArray, tilt, pressure: float) -> EventRecording:
    camera = window.hand.camera
    header = {
        "places": "canvas",
        "aspect": window.canvas.width() / window.canvas.height(),
        "view": {
            "position": camera.position.tolist(),
            "focus": camera.focus.tolist(),
            "up": camera.up.tolist(),
            "view_angle": camera.view_angle,
        },
    }
    events = []
    for k, place in enumerate(way):
        kind = "press" if k == 0 else "move"
        time_ms = STEP_MS * k
        events.append(
            DeviceEvent("pen", kind, tuple(place), pressure, tilt, 0.0, ("left",), time_ms=time_ms,
                        handled_ms=time_ms + 3)
        )  # fmt: skip
    after = STEP_MS * len(way)
    events.append(
        DeviceEvent(
            "pen", "release", tuple(way[-1]), 0.0, tilt, time_ms=after, handled_ms=after + 3
        )
    )
    return EventRecording(header, tuple(events))
