"""An ink from absorption and scattering in 31 bands, and mixtures of it with cinnabar."""

import sys
from pathlib import Path

import numpy as np

import paint3d
from paint3d.colour.pigments import BANDS_NM, Pigment

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(exist_ok=True)

blue = Pigment(
    name="my blue",
    chinese="我的蓝",
    K=0.2 + 4.0 / (1.0 + np.exp((510.0 - BANDS_NM) / 20.0)),  # absorbs from green to red
    S=np.full(BANDS_NM.shape, 0.6),
    source="made up for this example",
)
surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=0.6)
painter = paint3d.Painter(surface, "full", blue)
for k, share in enumerate((0.0, 0.25, 0.5, 0.75)):
    painter.dip({blue: 1.0 - share, "cinnabar": share} if share else blue)
    before = surface.painted.copy()
    y = 30.0 - 20.0 * k
    painter.stroke([(-40, y, 0), (40, y, 0)], pressure=(0.0, 0.4, 0.4, 0.0))
    fresh = surface.painted.copy()
    fresh[: len(before)] &= ~before
    print(f"{share:4.0%} cinnabar: sRGB {surface.srgb[fresh].mean(axis=0).round().astype(int)}")
paint3d.export(surface, out / "inks.glb")
