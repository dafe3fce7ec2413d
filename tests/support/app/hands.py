"""Strokes of a simulated hand over the built-in plane, for the tests of the studio's model."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import ArrayLike

from paint3d.app.model.document import Document
from paint3d.device.recorded import Recording
from paint3d.device.sample import DeviceSample
from paint3d.recording.flat_recording import orientations_from_angles

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def sample(time_ns, x, y, pressure=0.5, height=35.0):
    at = np.array([x, y, height])
    return DeviceSample(time_ns, at, UPRIGHT, pressure, 0, np.zeros(3), UPRIGHT)


def line(start, end, n=20, pressure=0.5, t0=1_000_000, height=35.0):
    """Samples of a straight stroke from (x, y) to (x, y), mm, in even steps of 5 ms.

    The brush comes down at the first and is lifted at the last.
    """
    xy = np.linspace(start, end, n)
    pressures = np.full(n, pressure)
    pressures[[0, -1]] = 0.0
    return [sample(t0 + 5_000_000 * i, *xy[i], float(pressures[i]), height) for i in range(n)]


def small_plane(resolution=1.5, mesh="plane", **options):
    return Document.new(mesh, resolution, **options)


def paint(document, start, end, **options):
    document.begin_stroke()
    document.feed(line(start, end, **options))
    document.end_stroke()


def wait_until(condition):
    """Wait for what another thread soon does."""
    until = time.monotonic() + 300.0
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.005)


def same_vertices(one, two):
    """Check that two surfaces hold the same, vertex by vertex, however these are numbered."""
    orders = [np.lexsort(surface.paint_mesh.vertices.T) for surface in (one, two)]
    for get in (
        lambda s: s.amounts,
        lambda s: s.coverage[:, None],
        lambda s: s.srgb,
        lambda s: s.paint_mesh.vertices,
    ):
        np.testing.assert_array_equal(get(one)[orders[0]], get(two)[orders[1]])


def pad_stroke(line: ArrayLike, pressure: float, altitude: float) -> Recording:
    """A stroke on a pad along a line (N, 2), mm, by a pen that leans down and to the right."""
    points = np.asarray(line, float)
    n = len(points)
    force = np.full(n, pressure)
    force[[0, -1]] = 0.0
    leaning = orientations_from_angles(np.full(n, -0.25 * np.pi), np.full(n, altitude))
    positions = np.column_stack([points, np.zeros(n)])
    times = np.arange(n, dtype=np.int64) * 5_000_000
    return Recording(
        times, positions, leaning, force, np.zeros(n, np.int32), header={"space": "pad"}
    )
