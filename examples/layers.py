"""Two layers: what lies above glazes over what lies below, and can be hidden again."""

import sys
from pathlib import Path

from _stroke import line

import paint3d

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(exist_ok=True)

surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=0.6)
layers = surface.use_layers()  # what there is, is the first
paint3d.Painter(surface, "full", "gamboge").replay(line((-40, 0), (40, 0), press=(0.3, 0.6, 0.3)))
layers.add("seal", place=1)  # painted on from now on
paint3d.Painter(surface, "full", "cinnabar").replay(line((0, -30), (0, 30), press=(0.3, 0.6, 0.3)))
for visible in (True, False):
    layers.describe(1, visible=visible)
    surface.touch(layers.painted_ids())
    name = out / f"seal_{'shown' if visible else 'hidden'}.glb"
    paint3d.export(surface, name)
    darkest = surface.srgb.min(axis=0)
    print(f"{name.name}: darkest codes {darkest}")
