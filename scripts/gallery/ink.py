#!/usr/bin/env python
"""Draw the gallery's pictures of ink: what spreads, what mixes, what glazes.

Usage: python scripts/gallery/ink.py [NAME ...] [--out FOLDER]

flowers        ink flowers and a branch on a vase wrapped in xuan, tip dark and belly light
wet_in_wet     drops into wet washes, on xuan, and the same on paint that has dried
feathering     the same strokes on raw xuan, on bisque and on glaze, a minute later
vermilion      four characters in cinnabar on a bowl of dried soot
bloom          five tones of one ink spread on raw xuan; water into half-dry washes; a later stroke
               beside an earlier one
lotus          a lotus leaf in broken ink with backruns, and a bud
petals         tip dark in a light belly: petals by one side-laid stroke each, solid and with hairs
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

import paint3d
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import DipAmount
from paint3d.colour.pigments import load_pigment
from paint3d.core.quaternion import quaternions_from_matrices
from paint3d.device.recorded import Recording
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SurfaceChart, make_chart
from paint3d.mesh.placement import place
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import load_recording
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.picture import Gloss, render_picture

OUT = Path(__file__).parents[2] / "docs/gallery"
DEMO = Path(paint3d.__file__).parent / "calligraphy/data/demo.jsonl.gz"
RATE = 250.0  # Hz
SPEED = 60.0  # mm/s


def stroke(
    chart: SurfaceChart,
    xy: NDArray,
    press: NDArray,
    lie: NDArray | None = None,
    brush: str = "full",
) -> Recording:
    """A stroke through points (N, 2) of a chart, mm, with pressures (N,) and bends (N,), rad.

    Without `lie` the tuft trails behind its way.
    """
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xy, axis=0), axis=1))])
    n = max(8, int(way[-1] / SPEED * RATE))
    at = np.linspace(0.0, way[-1], n)
    x, y, p = (np.interp(at, way, values) for values in (*xy.T, press))
    heading = np.arctan2(np.gradient(y), np.gradient(x)) + np.pi
    bend = heading if lie is None else np.interp(at, way, lie)
    places = np.column_stack([x, y])
    points, normals = chart.points(places), chart.normals(places)
    turned = places + 0.5 * np.column_stack([np.cos(bend), np.sin(bend)])
    along = chart.points(turned) - points
    return _held(points, normals, along, p, load_brush(brush))


def _held(points, normals, along, press, spec) -> Recording:
    """An upright brush on surface points, bent along directions (N, 3)."""
    z = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    x = along - np.sum(along * z, axis=1, keepdims=True) * z
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    height = spec.length_mm - press * spec.full_press_mm
    frames = np.stack([x, np.cross(z, x), z], axis=2)
    time_ns = (np.arange(len(points)) * (1e9 / RATE)).round().astype(np.int64)
    place_of_pen = points + height[:, None] * z
    return Recording(time_ns, place_of_pen, quaternions_from_matrices(frames), press)


def draw(surface: PaintedSurface, path: Path, size=(1400, 1050), view=None, gloss=None) -> None:
    """Write a picture of the surface as it is."""
    gloss = gloss or Gloss.of(surface.material.name)
    arrays = surface.export_arrays(tolerance=0.5)
    render_picture(*arrays, path, size=size, view=view, gloss=gloss)


def petal(chart, painter, centre, turn, length, width=0.4) -> None:
    """One petal: the brush laid down across it, tip outwards, and drawn to the heart."""
    out = np.array([np.cos(turn), np.sin(turn)])
    ends = centre + out * np.array([[length], [0.25 * length]])
    way = np.linspace(ends[0], ends[1], 12)
    press = width * np.sin(np.pi * np.linspace(0.12, 0.95, 12)) ** 0.7
    painter.replay(stroke(chart, way, press, np.full(12, turn)))


def flower(chart, painter, centre, size, turn) -> None:
    """Five petals in light ink with a red tip, then stamens."""
    for k in range(5):
        painter.dip({"carmine": 0.006, "water": 0.994})
        painter.dip({"carmine": 0.12, "water": 0.88}, reach=0.2)
        petal(chart, painter, np.asarray(centre), turn + k * 2 * np.pi / 5, size)


def line(chart, painter, points, press) -> None:
    """A branch: a stroke through points."""
    painter.replay(stroke(chart, np.asarray(points, float), np.asarray(press, float)))


def twig(chart, painter, points, press, kept, brush: str = "full") -> None:
    """A bent twig through points, lifted over discs (x, y, radius) that are kept for blossoms."""
    knots = np.asarray(points, float)
    t = np.linspace(0.0, 1.0, 120)
    way = CubicSpline(np.linspace(0.0, 1.0, len(knots)), knots)(t)
    way += 0.012 * np.ptp(knots) * np.column_stack([np.sin(23.0 * t), np.sin(17.0 * t)])
    pressures = np.interp(t, np.linspace(0.0, 1.0, len(press)), press)
    pressures *= 1.0 + 0.12 * np.sin(31.0 * t)
    discs = np.asarray(kept, float).reshape(-1, 3)
    away = np.linalg.norm(way[:, None] - discs[:, :2], axis=2)
    free = (away > discs[:, 2]).all(axis=1)
    ends = np.flatnonzero(np.diff(np.r_[False, free, False]))
    for first, last in ends.reshape(-1, 2):
        if last - first > 5:
            painter.replay(stroke(chart, way[first:last], pressures[first:last], brush=brush))


def flowers(folder: Path) -> None:
    """Plum blossom on a vase wrapped in xuan."""
    mesh = load_mesh("vase")
    mesh = TriangleMesh(mesh.vertices * np.float32(0.5), mesh.faces, name="vase")
    surface = PaintedSurface(mesh, 0.22, "xuan")
    chart = make_chart(ClosestPoints(mesh), place(ClosestPoints(mesh), (0.5, 0.56)), 52.0, 88.0)
    blossoms = (
        ((19, 47), 15, 0.3), ((-31, 44), 13, 1.1), ((-3, 6), 15, 0.7), ((36, 16), 12, 0.1),
        ((-36, -20), 13, 0.5), ((3, 76), 10, 0.9),
    )  # fmt: skip
    kept = [(*centre, 0.66 * size) for centre, size, _ in blossoms]
    painter = Painter(surface, "full", {"pine soot": 0.15, "water": 0.85})
    for points, press in (
        ([(-40, -82), (-26, -50), (-22, -20), (-6, 2), (6, 26), (4, 64)],
         [0.12, 0.26, 0.2, 0.17, 0.12, 0.03]),
        ([(-23, -24), (-29, 4), (-23, 32), (-31, 62)], [0.16, 0.11, 0.09, 0.02]),
        ([(2, 16), (20, 24), (30, 40), (34, 60)], [0.13, 0.1, 0.07, 0.02]),
    ):  # fmt: skip
        painter.dip({"pine soot": 0.15, "water": 0.85})
        painter.dip("pine soot", reach=0.4)
        twig(chart, painter, points, press, kept)
    surface.diffuse(4.0)
    surface.dry()
    for centre, size, turn in blossoms:
        flower(chart, painter, centre, 0.8 * size, turn)
        surface.diffuse(1.5)
    surface.diffuse(8.0)
    surface.dry()
    stamens = Painter(surface, "full", "pine soot")
    for centre, _, _ in blossoms:
        for k in range(7):
            out = np.array([np.cos(k * 0.9), np.sin(k * 0.9)])
            way = np.asarray(centre) + out * np.linspace(0.8, 5.2, 5)[:, None]
            stamens.replay(stroke(chart, way, np.array([0.012, 0.008, 0.006, 0.012, 0.02])))
    draw(surface, folder / "ink_flowers.png", (1100, 1400))


def sheet(width: float, height: float, spacing: float = 4.0) -> TriangleMesh:
    """A flat sheet facing +z."""
    x, y = (np.arange(-s / 2, s / 2 + spacing / 2, spacing) for s in (width, height))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    k = np.arange(len(grid)).reshape(len(y), len(x))
    a, b, c, d = (q.ravel() for q in (k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]))
    points = np.column_stack([grid, np.zeros(len(grid))])
    return TriangleMesh(points, np.vstack([np.c_[a, b, c], np.c_[a, c, d]]), name="sheet")


def sheet_chart(mesh: TriangleMesh) -> SurfaceChart:
    """All of a flat sheet but its border."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    closest = ClosestPoints(mesh)
    half = 0.49 * (high - low)
    return make_chart(closest, place(closest, (0.5, 0.5)), half[0], half[1], spacing=10.0)


def drop(surface: PaintedSurface, centre, radius: float, ink: dict[str, float]) -> None:
    """Let a drop fall: so many coats of each ink on a disc (mm), its border soft."""
    mesh = surface.paint_mesh
    away = np.linalg.norm(mesh.vertices[:, :2] - np.asarray(centre), axis=1)
    share = np.clip((radius - away) / 0.5 + 0.5, 0, 1).astype(np.float32)
    ids = np.flatnonzero(share > 0).astype(np.int32)
    for name, coats in ink.items():
        column = surface.column_of(load_pigment(name))
        surface.ink.amounts[ids, column] += np.float32(coats) * share[ids]
    surface.ink.coverage[ids] = np.maximum(surface.ink.coverage[ids], share[ids])
    surface.touch(ids)


def wet_in_wet(folder: Path) -> None:
    """Washes of indigo and gamboge with drops: left while wet, right when dry."""
    mesh = sheet(150.0, 70.0)
    surface = PaintedSurface(mesh, 0.5, "xuan")
    surface.refine_all()
    for x, dries in ((-37.0, False), (37.0, True)):
        drop(surface, (x - 11, 2), 17.0, {"indigo": 0.12, "water": 1.1})
        drop(surface, (x + 13, -4), 15.0, {"gamboge": 0.4, "water": 1.1})
        if dries:
            surface.diffuse(2.0)
            surface.dry()
        drop(surface, (x - 14, 6), 3.5, {"pine soot": 0.5, "water": 2.7})
        drop(surface, (x + 1, 0), 3.0, {"carmine": 0.8, "water": 2.0})
        drop(surface, (x + 16, -8), 3.0, {"water": 5.0})
        surface.diffuse(6.0)
        surface.dry()
    draw(surface, folder / "wet_in_wet.png", (1500, 760))


def feathering(folder: Path) -> None:
    """The same strokes by a free hand on xuan, bisque and glaze, a minute after."""
    from freehand import STROKES, moved  # which takes its sheet from here

    level, falling = (np.array(dict(STROKES)[name], float) for name in "勒磔")
    pictures = []
    for name in ("xuan", "bisque", "porcelain"):
        surface = PaintedSurface(sheet(64.0, 92.0), 0.2, name)
        painter = Painter(surface, "full", {"pine soot": 0.45, "water": 0.55}, azimuth="dragged")
        painter.replay(moved(level * [1.4, 1.4, 1.3], (0.0, 30.0)))
        painter.dip({"pine soot": 0.1, "water": 0.9})
        painter.replay(moved(falling * [1.3, 0.7, 1.2], (0.0, 5.0)))
        painter.dip({"pine soot": 0.3, "water": 0.7})
        painter.wipe(0.8)
        painter.replay(moved(level * [1.4, 2.0, 1.4], (0.0, -26.0), 160.0))
        surface.diffuse(60.0)
        surface.dry()
        path = folder / f"feathering_{name}.png"
        draw(surface, path, (620, 880))
        pictures.append(path)
    join(pictures, folder / "feathering.png")


def join(paths: list[Path], out: Path) -> None:
    """Put pictures side by side in one, and remove them."""
    from PIL import Image

    images = [Image.open(path).convert("RGB") for path in paths]
    whole = Image.new("RGB", (sum(i.width for i in images), images[0].height))
    x = 0
    for image in images:
        whole.paste(image, (x, 0))
        x += image.width
    whole.save(out, optimize=True)
    for path in paths:
        path.unlink()


def vermilion(folder: Path) -> None:
    """The shipped recording in cinnabar, on a bowl that was coated with soot and dried."""
    surface = PaintedSurface(load_mesh("bowl"), 0.4, "bisque")
    column = surface.column_of(load_pigment("pine soot"))
    surface.refine_all()
    n = surface.n_vertices
    surface.ink.amounts[:n, column] = 0.9
    surface.ink.coverage[:n] = 1.0
    surface.dry()
    recording = load_recording(DEMO)
    brush = recording.header.get("brush", "full")
    painter = Painter(surface, brush, "cinnabar", azimuth=recording.header["azimuth"])
    painter.replay(recording)
    draw(surface, folder / "vermilion.png")


def petals(folder: Path) -> None:
    """Two petals and a leaf of bamboo by one stroke each: by a solid tuft, and by 1,000 hairs."""
    mesh = sheet(150.0, 56.0)
    surface, chart = PaintedSurface(mesh, 0.2, "xuan"), sheet_chart(mesh)
    t = np.linspace(0.0, 1.0, 40)
    press = 0.5 * np.sin(np.pi * t) ** 0.6
    some = DipAmount(fullness=0.12)  # wiped on the dish: what is full paints black all over
    for x, hairs in ((-37.0, 0), (37.0, 1_000)):
        painter = Painter(surface, "full", "clear", hairs=hairs, amount=some)
        for at, belly, tip in (
            (-23.0, {"carmine": 0.04, "water": 0.96}, {"carmine": 0.8, "water": 0.2}),
            (2.0, "clear", "thick"),
        ):
            turn = np.radians(115.0 - 50.0 * t)
            out = np.column_stack([np.cos(turn), np.sin(turn)])
            painter.dip(belly)
            painter.dip(tip, reach=0.3)
            way = np.array([x + at, -16.0]) + out * 14.0
            painter.replay(stroke(chart, way, press, turn))
        painter.dip("clear")
        painter.dip("thick", reach=0.3)
        way = np.column_stack([x + 20.0 + 4.0 * np.sin(np.pi * t), 20.0 - 40.0 * t])
        painter.replay(stroke(chart, way, 0.6 * press, 0.0 * t))
    draw(surface, folder / "petals.png", (1500, 560))


def bloom(folder: Path) -> None:
    """Drops of the five tones, what water does to half-dry washes, and a line of glue."""
    mesh = sheet(150.0, 96.0)
    surface = PaintedSurface(mesh, 0.25, "xuan")
    surface.refine_all()
    for k, share in enumerate((1.0, 0.25, 0.15, 0.09, 0.04)):
        soot = {"pine soot": 2.6 * share, "water": 2.6 * (1.0 - share)}
        drop(surface, (-56 + 28 * k, 28), 5.0, soot)
    wash = {"pine soot": 0.16, "water": 1.6}
    drop(surface, (-48, -20), 11.0, wash)
    drop(surface, (-4, -20), 11.0, wash)
    drop(surface, (36, -20), 9.0, {"pine soot": 0.2, "water": 1.4})
    surface.diffuse(30.0)
    drop(surface, (-50, -18), 2.6, {"water": 6.0})
    for x, y in ((-9, -16), (1, -25), (3, -14)):
        drop(surface, (x, y), 1.4, {"water": 6.0, "pine soot": 0.1})
    surface.diffuse(1200.0)
    drop(surface, (52, -20), 6.0, {"pine soot": 0.3, "water": 2.4})
    surface.diffuse(1200.0)
    draw(surface, folder / "bloom.png", (1500, 1000))


def lotus(folder: Path) -> None:
    """A lotus leaf from above: wet washes, dark ink and water into them, veins when it has set."""
    mesh = sheet(190.0, 150.0)
    surface, chart = PaintedSurface(mesh, 0.65, "xuan"), sheet_chart(mesh)
    heart, random = np.array([-22.0, 16.0]), np.random.default_rng(4)
    painter = Painter(surface, "dabaiyun", "light", amount=DipAmount(fullness=0.3))

    def at(turn: float, part: float) -> NDArray:
        """A place of the leaf, whose border waves and has a notch at the stem."""
        wave = 1.0 + 0.05 * np.sin(5.0 * turn + 0.7) + 0.03 * np.sin(11.0 * turn)
        notch = 1.0 - 0.25 * np.exp(-(((turn + 1.35 + np.pi) % (2 * np.pi) - np.pi) ** 2) / 0.02)
        return heart + part * wave * notch * np.array([62.0 * np.cos(turn), 46.0 * np.sin(turn)])

    veins = np.linspace(0.0, 2.0 * np.pi, 12)[:-1] - 1.05 + random.normal(0.0, 0.05, 11)
    for turn in np.sort(np.concatenate([veins + k * 0.19 for k in range(3)])):
        painter.dip("clear")
        painter.dip(random.choice(["clear", "light", "light", "heavy"]), reach=0.2)
        start = random.uniform(0.12, 0.4)
        wide(chart, painter, at(turn, start), at(turn, random.uniform(0.86, 0.96)), 0.26)
    for first in veins[::2]:  # the border, by strokes along it
        arc = np.linspace(first, first + 1.25, 24)
        painter.dip("clear")
        painter.dip(random.choice(["light", "heavy"]), reach=0.3)
        way = np.array([at(turn, 0.85 + 0.02 * np.sin(9.0 * turn)) for turn in arc])
        press = 0.22 * np.sin(np.pi * np.linspace(0.06, 0.94, 24)) ** 0.5
        painter.replay(stroke(chart, way, press, brush="dabaiyun"))
    surface.diffuse(1.5)
    for k in (1, 2, 4, 7, 8, 10):  # broken: dark ink while it is wet
        painter.dip("thick")
        turn = veins[k] + 0.28
        wide(chart, painter, at(turn, 0.5), at(turn + 0.05, 0.84), 0.09)
    surface.diffuse(12.0)
    for turn in veins + 0.28:
        for part in random.uniform(0.45, 0.9, random.integers(1, 3)):
            place = at(turn + random.normal(0.0, 0.05), part)
            drop(surface, place, random.uniform(0.8, 2.6), {"water": 6.0})
    surface.diffuse(150.0)
    veins_and_bud(surface, chart, at, veins)
    surface.diffuse(3.0)
    draw(surface, folder / "lotus.png", (1500, 1180))


def wide(chart, painter, start, end, press: float) -> None:
    """A broad stroke that is laid down, swells, and is lifted."""
    t = np.linspace(0.0, 1.0, 24)
    aside = 0.06 * np.array([start[1] - end[1], end[0] - start[0]])
    way = start + np.outer(t, end - start) + np.outer(np.sin(np.pi * t), aside)
    pressures = press * np.sin(np.pi * np.clip(t, 0.04, 0.97)) ** 0.55
    painter.replay(stroke(chart, way, pressures, brush="dabaiyun"))


def veins_and_bud(surface, chart, at, veins) -> None:
    """Veins that fork, places `at` of a leaf, its stem, and a bud in carmine whose tip is dark."""
    fine = Painter(surface, "xiaobaiyun", "thick")
    t = np.linspace(0.0, 1.0, 16)
    for turn in veins:
        for first, last, aside in ((0.03, 0.9, 0.0), (0.5, 0.88, 0.16), (0.42, 0.84, -0.15)):
            part = first + (last - first) * t
            way = np.array([at(turn + aside * u, p) for u, p in zip(t, part, strict=True)])
            fine.dip("heavy" if aside else "thick")
            press = (0.05 if aside else 0.08) * (1.0 - t)
            fine.replay(stroke(chart, way, press, brush="xiaobaiyun"))
    stem = np.array([at(-1.35, 0.97), (-9, -46), (-10, -60), (-13, -72)])
    fine.dip("heavy")
    fine.replay(stroke(chart, stem, np.array([0.13, 0.16, 0.17, 0.14]), brush="xiaobaiyun"))
    bud = np.array([62.0, 34.0])
    way = np.array([(62, 40), (60, 6), (52, -30), (44, -70)])
    fine.dip("light")
    fine.dip("heavy", reach=0.3)
    fine.replay(stroke(chart, way, np.array([0.08, 0.1, 0.11, 0.1]), brush="xiaobaiyun"))
    for turn, long in ((62, 15.0), (118, 15.0), (90, 19.0)):
        painter = Painter(surface, "full", {"carmine": 0.03, "water": 0.97})
        painter.dip({"carmine": 0.5, "water": 0.5}, reach=0.3)
        petal(chart, painter, bud, np.radians(turn), long, 0.3)


SCENES = {f.__name__: f for f in (flowers, wet_in_wet, feathering, bloom, lotus, vermilion, petals)}


def main() -> None:
    """Run as the module's first lines say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", metavar="NAME", nargs="*", choices=[*SCENES, []])
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.names or SCENES:
        SCENES[name](options.out)


if __name__ == "__main__":
    main()
