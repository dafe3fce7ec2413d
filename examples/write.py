"""Characters on a vase: planned for the brush, painted, and saved to go on with."""

import sys
from pathlib import Path

import paint3d
from paint3d.brush.presets import load_brush
from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.writing import Layout, Pen, write_text

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(exist_ok=True)

vase = paint3d.load_mesh("vase")
pen = Pen(brush=load_brush("zhongkai"), em_mm=30.0)
written = write_text(vase, "永", open_glyphs(None), pen, Layout(side="outside"))
surface = paint3d.PaintedSurface(vase, resolution=0.6)
paint3d.Painter(surface, brush=pen.brush, ink="pine soot").replay(written.recording)
print(f"{len(written.recording)} poses, {written.recording.duration_s:.1f} s of the hand")
paint3d.export(surface, out / "vase.ply")
