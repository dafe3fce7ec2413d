"""Two layers: what lies above glazes over what lies below, and can be hidden again."""

import sys
from pathlib import Path

import paint3d

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(exist_ok=True)

surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=0.6)
layers = surface.use_layers()  # what there is, is the first
painter = paint3d.Painter(surface, "full", "gamboge")
painter.stroke([(-40, 0, 0), (40, 0, 0)], pressure=(0.3, 0.6, 0.3))
layers.add("seal", place=1)  # painted on from now on
painter.dip("cinnabar")
painter.stroke([(0, -30, 0), (0, 30, 0)], pressure=(0.3, 0.6, 0.3))
for visible in (True, False):
    layers.set_properties(1, visible=visible)
    surface.touch(layers.painted_ids())
    name = out / f"seal_{'shown' if visible else 'hidden'}.glb"
    paint3d.export(surface, name)
    darkest = surface.srgb.min(axis=0)
    print(f"{name.name}: darkest codes {darkest}")
