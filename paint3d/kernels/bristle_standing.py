"""Imprints of hairs without a stroke: bent again and again, to be measured."""

from __future__ import annotations

from numba import njit

from paint3d.kernels.bristle_tuft import bend_hairs, fill_bend

__all__ = ["bend_often"]


@njit(cache=True, nogil=True)
def bend_often(times, bristles, tuft, descent, tilt, pe, patch, turned, bend, block, points):
    """Bend all hairs `times` times, each from its table; arguments as in `kernels.bristle_tuft`."""
    for _ in range(times):
        fill_bend(bristles, tuft, descent, tilt, pe, patch, 0.0, 0.0, 0.0, 0.0, bend)
        bend_hairs(bristles.rests, turned, bend, block, points)
