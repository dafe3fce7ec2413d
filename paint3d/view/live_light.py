"""Light on the live object, baked into its vertices once so that every frame is cheap.

The studio of the offscreen pictures (`daylight`) is fixed to the object while the camera moves.
Unshadowed light is available at once; `bake` computes soft shadows, and may run in a thread.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, grown
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.view.camera import find_view, studio_axes
from paint3d.view.daylight import Ground, Occluder, light_ground, light_points
from paint3d.view.kernels.chunks import light_of_added, shown_colours
from paint3d.view.studio import LIGHTS, Sun, light_samples, linear_to_srgb, srgb_to_linear

__all__ = ["LIVE_LIGHTS", "SHOULDER", "BakedLight", "LiveLight"]

LIVE_LIGHTS = (*LIGHTS, "plain")
"""Lights by name: those of pictures, and one that lights all places alike."""

_N_DOME = 48
_WHITE = 0.72  # linear brightness of ideal white where lit best
_LIT_BEST = 0.88  # fraction of the area that is lit no better than `_WHITE`
SHOULDER = 1.5  # the film curve of `picture`
_ALBEDO = 0.8
_CODES = 1 << 14  # steps of linear light in the table of the film curve
_CHUNK = 200_000  # vertices lit at once


@dataclass(frozen=True, eq=False)
class BakedLight:
    """Soft light on the base vertices, and the object's shadow on the floor.

    Attributes
    ----------
    light : (B, 3) float32
    ground : Ground
        In studio axes.
    axes : (3, 3) float64
        Rows: the studio's right, depth and up in the object's frame.
    setting : (str, float)
        As `LiveLight.setting`.
    """

    light: NDArray[np.float32]
    ground: Ground
    axes: NDArray[np.float64]
    setting: tuple[str, float] = ("studio", 0.0)


class LiveLight:
    """The light on each vertex of a paint mesh, including vertices added by refinement.

    Attributes
    ----------
    mesh : PaintMesh
    axes : (3, 3) float64
        Rows: the studio's right, depth and up in the object's frame.
    setting : (str, float)
        One of `LIVE_LIGHTS`, and how far its lamps are turned about the upright axis, rad.
    """

    def __init__(self, mesh: PaintMesh) -> None:
        self.mesh = mesh
        self.setting = ("studio", 0.0)
        n = mesh.n_base_vertices
        self._points, self._normals = mesh.vertices[:n], mesh.normals[:n]
        self._areas = np.maximum(mesh.vertex_areas[:n], 1e-12)
        bare = np.full((n, 3), 200, np.uint8)
        view = find_view(self._points, self._normals, bare, self._areas)
        self.axes = studio_axes(self._points, view)
        self._linear = srgb_to_linear(np.arange(256, dtype=np.uint8))
        # sRGB codes of even steps of linear light, through the film curve of the pictures.
        x = np.linspace(0.0, 1.0, _CODES)
        codes = np.rint(255.0 * linear_to_srgb(1.0 - (1.0 - x) ** SHOULDER))
        self._codes = codes.astype(np.uint8)
        self._light = np.empty((0, 3), np.float32)
        self._known = 0
        self.take(self._unshadowed())

    def take(self, light: AnyArray) -> None:
        """Set the light (B, 3) of the base vertices."""
        self._light = np.ascontiguousarray(light, np.float32)
        self._known = len(light)

    def bake(self) -> BakedLight:
        """Compute the soft light; thread-safe, since it changes nothing and reads only constants.

        Cost: 1 s, and 3 s more for each million vertices.
        """
        setting = self.setting
        axes = self.axes.astype(np.float32)
        points, normals = self._points @ axes.T, self._normals @ axes.T
        occluder, suns = Occluder(points, self.mesh.base_faces), _suns(*setting)
        ground = light_ground(occluder, suns)
        if setting[0] == "plain":
            return BakedLight(self._plain(), ground, self.axes, setting)
        light = light_points(occluder, ground, suns, points, normals, _ALBEDO)
        return BakedLight(self._exposed(light), ground, self.axes, setting)

    def change(self, setting: tuple[str, float]) -> None:
        """Take another light, without shadows until it is baked."""
        self.setting = setting
        self.take(self._plain() if setting[0] == "plain" else self._unshadowed())

    def _plain(self) -> AnyArray:
        """Return light (B, 3) that is the same everywhere."""
        return np.full((len(self._normals), 3), _WHITE, np.float32)

    def colours(self, vertex_ids: AnyArray, srgb: AnyArray) -> AnyArray:
        """Return lit colours (N, 3) uint8 of vertices (N,) int32; srgb (V, 3) is the paint."""
        n = self.mesh.n_vertices
        if self._known < n:  # refinement has added vertices
            if len(self._light) < n:
                self._light = grown(self._light, self._known, self.mesh.capacity)
            light_of_added(self.mesh.arrays.parents, self._known, n, self._light)
            self._known = n
        out = np.empty((len(vertex_ids), 3), np.uint8)
        shown_colours(vertex_ids, srgb, self._light, self._linear, self._codes, out)
        return out

    def _unshadowed(self) -> AnyArray:
        """Return the light (B, 3) on every vertex without any shadows."""
        suns = _suns(*self.setting)
        toward = np.stack([sun.direction for sun in suns]) @ self.axes
        shine = np.stack([sun.irradiance for sun in suns]) / np.pi
        toward, shine = toward.astype(np.float32), shine.astype(np.float32)
        light = np.empty((len(self._normals), 3), np.float32)
        for start in range(0, len(light), _CHUNK):
            cosines = np.maximum(self._normals[start : start + _CHUNK] @ toward.T, 0.0)
            light[start : start + _CHUNK] = cosines @ shine
        return self._exposed(light)

    def _exposed(self, light: AnyArray) -> AnyArray:
        """Scale light (B, 3) so that best-lit white has the brightness `_WHITE`."""
        brightness = light.mean(axis=1)
        order = np.argsort(brightness)
        fraction = np.cumsum(self._areas[order]) / self._areas.sum()
        best = brightness[order[min(int(np.searchsorted(fraction, _LIT_BEST)), len(order) - 1)]]
        return light * (_WHITE / max(float(best), 1e-6))


def _suns(kind: str, turn: float) -> list[Sun]:
    """Return a light as parallel ones, turned about the upright axis; overcast for a plain one."""
    if kind == "studio":
        suns = light_samples(_N_DOME)
    else:
        suns = light_samples(_N_DOME, LIGHTS["soft" if kind == "plain" else kind])
    if turn == 0.0:
        return suns
    c, s = np.cos(turn), np.sin(turn)
    about = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return [replace(sun, direction=about @ sun.direction) for sun in suns]
