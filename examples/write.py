"""Characters on a vase, planned for a brush that suits them, and saved to go on with."""

import sys
from pathlib import Path

import paint3d

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(exist_ok=True)

surface = paint3d.PaintedSurface(paint3d.load_mesh("vase"), resolution=0.6)
painter = paint3d.Painter(surface, brush="zhongkai", ink="pine soot")
written = painter.write("永", size=30, side="outside")
print(f"{len(written)} poses, {written.duration_s:.1f} s of the hand")
paint3d.save_session(paint3d.Session(surface, (written,)), out / "vase.p3d")
paint3d.export(surface, out / "vase.ply")
