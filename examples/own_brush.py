"""A brush of one's own: a preset with a longer, softer tuft, beside the preset."""

import dataclasses
import sys
from pathlib import Path

import paint3d

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(exist_ok=True)

full = paint3d.load_brush("full")
mine = dataclasses.replace(
    full,
    name="mine",
    length_mm=45.0,
    tip_segment_mm=1.3,
    full_press_mm=24.0,
    root_diameter_mm=9.0,
    hardness=0.4,
)
surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=0.6, material="xuan")
for y, brush in ((15.0, full), (-15.0, mine)):
    before = surface.painted.sum()
    painter = paint3d.Painter(surface, brush, "pine soot")
    painter.stroke([(-40, y, 0), (40, y, 0)], pressure=(0.0, 0.5, 0.2, 0.5, 0.0))
    print(f"{brush.name:6} {surface.painted.sum() - before} vertices")
paint3d.export(surface, out / "brushes.glb")
