"""A line on the plane as a recording: what a hand would have done."""

import numpy as np

import paint3d


def line(start, end, press, seconds=1.0, rate_hz=100):
    """A stroke from `start` to `end` (x, y in mm), pressed as `press` (0 to 1) says along it."""
    n = int(seconds * rate_hz)
    t = np.linspace(0.0, 1.0, n)
    place = np.zeros((n, 3))
    place[:, :2] = np.outer(1.0 - t, start) + np.outer(t, end)
    place[:, 2] = 30.0  # with a pressure, the height does not matter
    upright = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    return paint3d.Recording(
        time_ns=(1e9 * seconds * t).astype(np.int64),
        position=place,
        orientation=upright,
        pressure=np.interp(t, np.linspace(0.0, 1.0, len(press)), press),
        header={"azimuth": "dragged"},
    )
