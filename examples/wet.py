"""Ink that spreads on paper: how far it has come after some seconds, and when it is dry."""

import sys
from pathlib import Path

import paint3d

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(exist_ok=True)

surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=0.8, material="xuan")
painter = paint3d.Painter(surface, "full", {"pine soot": 0.12, "water": 0.88})
painter.stroke([(-15, 0, 0), (15, 0, 0)], pressure=(0.2, 0.4, 0.2))
for seconds in (0.0, 1.0, 4.0):
    surface.diffuse(seconds)
    area = surface.vertex_areas[surface.painted].sum()
    print(f"after {seconds:.0f} s more: {area:6.0f} mm2, {surface.flow.water:6.2f} mm3 of water")
surface.dry()
paint3d.save_session(paint3d.Session(surface), out / "wash.p3d")
