"""One stroke, from numbers, on a bowl: pressed, drawn, lifted."""

import sys
from pathlib import Path

import numpy as np

import paint3d

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(exist_ok=True)

surface = paint3d.PaintedSurface(paint3d.load_mesh("bowl"), resolution=0.6)
painter = paint3d.Painter(surface, brush="full", ink="pine soot")

# The hand goes a sixth of the way around the bowl, the handle pointing away from its axis.
points = surface.source.vertices
radius, height = np.hypot(points[:, 0], points[:, 1]).max(), points[:, 2].mean()
n = 120
angle = np.linspace(-0.5, 0.5, n)
position = np.column_stack(
    [(radius + 30.0) * np.cos(angle), (radius + 30.0) * np.sin(angle), np.full(n, height)]
)
half = np.full(n, np.pi / 4.0)  # the pen's z axis turned from up to outwards, about y ...
tilt = np.column_stack([np.cos(half), 0.0 * half, np.sin(half), 0.0 * half])
turn = np.column_stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)])
w, x, y, z = turn.T
a, b, c, d = tilt.T  # ... and then with the hand, about the bowl's axis
orientation = np.column_stack(
    [
        w * a - x * b - y * c - z * d,
        w * b + x * a + y * d - z * c,
        w * c - x * d + y * a + z * b,
        w * d + x * c - y * b + z * a,
    ]
)
stroke = paint3d.Recording(
    time_ns=np.linspace(0, 1_500_000_000, n).astype(np.int64),
    position=position,
    orientation=orientation,
    pressure=0.5 * np.sin(np.linspace(0.0, np.pi, n)),
    header={"azimuth": "dragged"},
)
painter.replay(stroke)
print(f"{surface.painted.sum()} of {surface.n_vertices} vertices have ink")
paint3d.export(surface, out / "bowl.glb")
