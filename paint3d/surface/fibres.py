"""The fibres of a sheet: streaks of noise in space, along which its pores lead further.

A sheet of paper is felted of fibres a few millimetres long that lie in all directions. Water runs
along them first, so ink feathers in fine points instead of round bumps. Here several noises, each
drawn out along a direction of its own, lie over one another, and the strongest counts: a place in
space has the same fibres on any mesh. The directions are spread evenly, and space is bent a little
before, so that no direction comes back.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.surface.kernels.grain import fill_grain

__all__ = ["fibre_relief"]

_DIRECTIONS = 12
_LONG = 8.0  # times as long as broad
_BENDS_MM, _BENT = 4.0, 0.6  # how far apart space is bent, and by how much of it
_USUAL, _SPAN = 0.74, 0.12  # of the strongest of so many noises: middle, and twice its deviation
_ASKEW = np.array([0.3, 0.5, 0.8])


def _frames() -> NDArray[np.float64]:
    """(K, 3, 3) rows: along each direction, even over a half sphere, and across it."""
    i = np.arange(_DIRECTIONS) + 0.5
    turn, z = np.pi * (1.0 + 5.0**0.5) * i, 1.0 - i / _DIRECTIONS
    flat = np.sqrt(1.0 - z * z)
    along = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])
    across = np.cross(along, _ASKEW)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return np.stack([along, across, np.cross(along, across)], axis=1)


_FRAMES = _frames()


def fibre_relief(points: NDArray[np.float64], width_mm: float) -> NDArray[np.float64]:
    """How far points (N, 3), mm, lie on fibres so broad: 1 on one, -1 between them, mean near 0."""
    bent = points.copy()
    height = np.empty(len(points))
    for axis in range(3):
        fill_grain(points + 31.7 * axis, _BENDS_MM, height)
        bent[:, axis] += _BENT * _BENDS_MM * (height - 0.5)
    strongest = np.zeros(len(points))
    scale = np.array([_LONG * width_mm, width_mm, width_mm])
    for k, frame in enumerate(_FRAMES):
        fill_grain(np.ascontiguousarray(bent @ frame.T / scale + 7.7 * k), 1.0, height)
        np.maximum(strongest, height, out=strongest)
    relief: NDArray[np.float64] = np.clip((strongest - _USUAL) / _SPAN, -1.0, 1.0)
    return relief
