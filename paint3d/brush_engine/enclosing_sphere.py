"""The smallest sphere around a bent tuft, by growing a ball (Guo 2017, Eqs. 10, 11).

The ball starts on a far pair of points of the tuft's surface and grows towards the farthest
outlier. A grown ball need not hold the old one, so passes repeat until no outlier lies more than
0.3 % outside; then the radius takes in what is left. With c the smallest ball's centre and R its
radius, Eqs. 10 and 11 keep |D - c|^2 + r^2 <= R^2, so the ball never outgrows the smallest one. The
tuft is symmetric, c lies in the bend plane, and D moved there by z may have r^2 grow by z^2: this
counts an outlier and its mirror image in one step, and half of the surface is enough.

A tuft's spheres are found once, over tilt, descent and spread; painting looks them up
(`tuft.enclose_tuft`).
"""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["tabulate_spheres"]

_HALF_RING = 5  # points on one half of each section
_COS = np.cos(np.linspace(0.0, np.pi, _HALF_RING))
_SIN = np.sin(np.linspace(0.0, np.pi, _HALF_RING))
_TOLERANCE = 3e-3  # an outlier nearer than this (relative) ends the passes
_PASSES = 40


@kernel
def _place_points(sections, radii, spread, points):
    """Fill points (K, 3), along, up and to one side: the tip, and half a ring at every section."""
    last = radii.shape[0] - 1
    n = 0
    for j in range(last + 1):
        along, up, angle = sections[0, j], sections[1, j], sections[2, j]
        widening = spread if j < last else 1.0  # the papers keep the root's circle as it is
        major, minor = radii[j] * widening, radii[j] / widening
        for i in range(_HALF_RING if j > 0 else 1):
            points[n, 0] = along + minor * math.sin(angle) * _COS[i]
            points[n, 1] = up + minor * math.cos(angle) * _COS[i]
            points[n, 2] = major * _SIN[i]
            n += 1
    return n


@kernel
def _farthest(points, n, x, y, z):
    """Which point lies farthest from (x, y, z), and the square of how far."""
    index, greatest = 0, -1.0
    for i in range(n):
        dx, dy, dz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
        square = dx * dx + dy * dy + dz * dz
        if square > greatest:
            index, greatest = i, square
    return index, greatest


@kernel
def _enclose(points, n):
    """Centre (along, up) and radius of the smallest ball around points and their mirror images."""
    b, _ = _farthest(points, n, points[0, 0], points[0, 1], points[0, 2])
    c, square = _farthest(points, n, points[b, 0], points[b, 1], -points[b, 2])
    x = 0.5 * (points[b, 0] + points[c, 0])
    y = 0.5 * (points[b, 1] + points[c, 1])
    z = 0.5 * (points[b, 2] - points[c, 2])
    radius = math.sqrt(0.25 * square + z * z)
    for _ in range(_PASSES):
        e, square = _farthest(points, n, x, y, 0.0)
        distance = math.sqrt(square)
        if distance <= radius * (1.0 + _TOLERANCE):
            break
        grown = (radius * radius + square) / (2.0 * distance)  # Eq. 10
        step = math.sqrt(max(grown * grown - radius * radius, 0.0)) / distance  # Eq. 11
        x += step * (points[e, 0] - x)
        y += step * (points[e, 1] - y)
        z = step * points[e, 2]
        radius = math.sqrt(grown * grown + z * z)
    _, square = _farthest(points, n, x, y, 0.0)
    return x, y, math.sqrt(square)


@kernel
def tabulate_spheres(sections, radii, spreads, out):
    """The spheres around a tuft's bent shapes.

    Parameters
    ----------
    sections : (T, D, 3, R) float64
        Along, up and angle (rad) of sections of each shape, the tip first, the root last.
    radii : (R,) float64
        Of the sections when they are round, in the unit of the shapes.
    spreads : (K,) float64
        How far sections are widened (Guo 2017, Eq. 2).
    out : (T, D, K, 3) float64
        Along and up of the centre, and the radius.
    """
    points = np.empty((radii.shape[0] * _HALF_RING, 3))
    for i in range(out.shape[0]):
        for k in range(out.shape[1]):
            for j in range(out.shape[2]):
                n = _place_points(sections[i, k], radii, spreads[j], points)
                x, y, radius = _enclose(points, n)
                out[i, k, j, 0], out[i, k, j, 1], out[i, k, j, 2] = x, y, radius
