"""Strokes, a character and a seal on a bowl: what one would do by hand."""

import sys
from pathlib import Path

import paint3d

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(exist_ok=True)

surface = paint3d.PaintedSurface(paint3d.load_mesh("bowl"), resolution=0.6)
painter = paint3d.Painter(surface, brush="full", ink="pine soot")
painter.stroke(
    [(0.35, 0.7), (0.5, 0.8), (0.65, 0.7)], pressure=(0.1, 0.6, 0.2)
)  # U,V: round it, up
painter.dip("azurite")
painter.stroke([(0.4, 0.6), (0.6, 0.6)], pressure=0.3, tilt=40)  # the handle leans
painter.dip("pine soot")
written = painter.write("永", at=(0.5, 0.35), size=24)
touched = painter.seal("和", at=(0.6, 0.35), size=10)
print(
    f"{surface.painted.sum()} of {surface.n_vertices} vertices have ink, {touched:.0%} of the seal"
)
paint3d.save_recording(written, out / "yong.jsonl.gz")
paint3d.export(surface, out / "bowl.glb")
