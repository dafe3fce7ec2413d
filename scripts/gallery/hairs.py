"""The gallery's pictures of single hairs: how many, how wet, and flying white on a bowl."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from ink import draw, join, sheet, sheet_chart, stroke

from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import make_chart
from paint3d.mesh.placement import place
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

COUNTS = (1, 10, 100, 1_000, 10_000, 0)
LOADS = (1.0, 0.36, 0.25, 0.18)
COLUMN, ROW = 62.0, 17.0  # mm


def bristles(file: Path, _glyphs: Path) -> None:
    """Rows by hairs (the last is solid), columns by how much ink is left."""
    mesh = sheet(COLUMN * len(LOADS), ROW * len(COUNTS))
    surface, chart = PaintedSurface(mesh, 0.22, "xuan"), sheet_chart(mesh)
    wave = np.linspace(-24.0, 24.0, 241)
    press = 0.42 * np.clip(np.minimum(wave + 24.0, 24.0 - wave) / 9.0, 0.0, 1.0)
    for i, count in enumerate(COUNTS):
        for j, load in enumerate(LOADS):
            centre = np.array([j - 0.5 * (len(LOADS) - 1), 0.5 * (len(COUNTS) - 1) - i])
            centre *= (COLUMN, ROW)
            way = centre + np.column_stack([wave, 2.0 * np.sin(wave / 9.0)])
            painter = Painter(surface, "full", "pine soot", hairs=count)
            painter.wipe(1.0 - load)
            painter.replay(stroke(chart, way, press))
    draw(surface, file, (1500, 720))


def feibai(file: Path, _glyphs: Path) -> None:
    """Two sweeping strokes on the outside of a bowl before it is glazed, the brush nearly dry."""
    paths = []
    for name, count in (("hairs", 1_000), ("solid", 0)):
        mesh = load_mesh("bowl")
        surface, closest = PaintedSurface(mesh, 0.2, "bisque"), ClosestPoints(mesh)
        chart = make_chart(closest, place(closest, (0.5, 0.5)), 55.0, 30.0)
        painter = Painter(surface, "full", "pine soot", hairs=count)
        painter.wipe(0.84)
        turn = np.linspace(0.0, 1.0, 300)
        arch = np.column_stack([-46.0 + 92.0 * turn, 6.0 + 9.0 * np.sin(np.pi * turn)])
        swell = np.sin(np.pi * np.clip(turn, 0.0, 1.0)) ** 0.4  # comes down and leaves as it goes
        press = 0.55 * swell * (1.0 - 0.25 * turn)
        painter.replay(stroke(chart, arch, press))
        hook = np.column_stack([-30.0 + 66.0 * turn, -8.0 - 9.0 * turn + 5.0 * np.sin(5 * turn)])
        painter.replay(stroke(chart, hook, 0.8 * press))
        path = file.with_name(f"feibai_{name}.png")
        draw(surface, path, (900, 760))
        paths.append(path)
    join(paths, file)


PICTURES = {"bristles.png": bristles, "feibai.png": feibai}
