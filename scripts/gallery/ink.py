#!/usr/bin/env python
"""Draw the gallery's pictures of ink: what spreads, what mixes, what glazes.

Usage: python scripts/gallery/ink.py [NAME ...] [--out FOLDER]

flowers        plum blossom on a vase wrapped in xuan: a dry trunk, petals by one dab each
wet_in_wet     ink, carmine and water touched into wet washes, and the same on dried ones
feathering     the same strokes on raw xuan, on bisque and on glaze, a minute later
vermilion      four characters in cinnabar on a bowl of dried soot
bloom          five tones of one ink spread on raw xuan; water into half-dry washes; a later stroke
               beside an earlier one
lotus          a lotus leaf in broken ink with backruns, and a bud
petals         tip dark in a light belly: bamboo, a leaf by one stroke, solid and with hairs
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.interpolate import CubicSpline, PchipInterpolator

import paint3d
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import DipAmount
from paint3d.colour.pigments import load_pigment
from paint3d.core.quaternion import quaternions_from_matrices
from paint3d.device.recorded import Recording
from paint3d.files.export import gloss_of
from paint3d.files.export_options import ExportOptions
from paint3d.files.load import load_mesh
from paint3d.files.project.painting import read_painting
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SurfaceChart, make_chart
from paint3d.mesh.placement import place
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import load_recording
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.picture import draw_picture

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


def draw(surface: PaintedSurface, path: Path, size=(1400, 1050), view=None) -> None:
    """Write a picture of the surface as `paint3d picture` does."""
    read = read_painting(surface, ExportOptions())
    pixels = draw_picture(
        *read[:3], read.shown_srgb, size=size, view=view, gloss=gloss_of(read), edges=read.edges
    )
    Image.fromarray(pixels).save(path, optimize=True)


def hand(
    chart: SurfaceChart, painter: Painter, knots, aside=0.0, speed: float = 80.0, wet: bool = True
) -> None:
    """Paint one stroke of a living hand through knots: rows of x, y (mm) and pressure.

    It is slow where it enters, turns and leaves, fast (mm/s) between, and trembles. The tuft
    trails, or lies `aside` of that by angles (rad) along the way. `wet`: ink spreads meanwhile.
    """
    knots = np.asarray(knots, float)
    random = np.random.default_rng(int(1e3 * np.abs(knots).sum()))
    ends = np.r_[0.0, np.cumsum(np.hypot(*np.diff(knots[:, :2], axis=0).T))]
    s = np.linspace(0.0, ends[-1], max(24, int(4.0 * ends[-1])))
    xy = CubicSpline(ends, knots[:, :2])(s)
    heading = np.unwrap(np.arctan2(*np.gradient(xy, s, axis=0).T[::-1]))
    v = speed * (0.3 + 0.7 * np.sin(np.pi * np.linspace(0.0, 1.0, len(s))).clip(0.0) ** 0.7)
    v /= 1.0 + 6.0 * np.abs(np.gradient(heading, s))
    time = np.r_[0.0, np.cumsum(np.diff(s) / (0.5 * (v[1:] + v[:-1])))]
    t = np.arange(0.0, time[-1], 1.0 / RATE)
    at = np.interp(t, time, s)
    turn = np.interp(at, s, heading)

    def tremor(*periods: float) -> NDArray:
        return sum(np.sin(2.0 * np.pi * (t / period + random.random())) for period in periods)

    way = np.column_stack([np.interp(at, s, c) for c in xy.T])
    way += 0.1 * tremor(0.31, 0.17)[:, None] * np.column_stack([-np.sin(turn), np.cos(turn)])
    press = PchipInterpolator(ends, knots[:, 2])(at) * (1.0 + 0.06 * tremor(0.9, 0.5, 0.23))
    aside = np.atleast_1d(aside)
    lie = turn + np.pi + np.interp(at, np.linspace(0.0, ends[-1], len(aside)), aside)
    points, normals = chart.points(way), chart.normals(way)
    along = chart.points(way + 0.5 * np.column_stack([np.cos(lie), np.sin(lie)])) - points
    painter.replay(_held(points, normals, along, press.clip(0.0, 1.0), painter.brush), wet=wet)


def flowers(folder: Path) -> None:
    """Plum blossom on a vase wrapped in xuan."""
    mesh = load_mesh("vase")
    mesh = TriangleMesh(mesh.vertices * np.float32(0.5), mesh.faces, name="vase")
    surface, random = PaintedSurface(mesh, 0.22, "xuan"), np.random.default_rng(3)
    chart = make_chart(ClosestPoints(mesh), place(ClosestPoints(mesh), (0.5, 0.56)), 52.0, 88.0)
    old = Painter(surface, "full", "burnt", hairs=800)
    for knots, dryness in (
        ([(-46, -84, 0.3), (-37, -68, 0.24), (-36, -52, 0.32), (-20, -31, 0.2),
        (-15, -16, 0.24)], 0.9),
        ([(-16, -12, 0.16), (-21, 8, 0.1), (-6, 24, 0.13), (2, 36, 0.05)], 0.85),
    ):  # fmt: skip
        old.dip("heavy")
        old.dip("burnt", reach=0.3)
        old.wipe(dryness)
        hand(chart, old, knots, 0.5, 70.0, wet=False)
    fine = Painter(surface, "langhao", "thick")
    for knots in (
        [(2, 38, 0.16), (9, 52, 0.08), (7, 66, 0.1), (13, 84, 0.01)],
        [(-30, -44, 0.22), (-40, -26, 0.1), (-38, -8, 0.14), (-46, 14, 0.01)],
        [(-12, -14, 0.22), (6, -8, 0.12), (15, 4, 0.16), (36, 10, 0.08), (46, 24, 0.01)],
        [(-22, 10, 0.14), (-30, 24, 0.08), (-27, 40, 0.01)],
        [(16, 5, 0.12), (20, 18, 0.06), (30, 30, 0.01)],
    ):
        fine.dip("thick")
        fine.wipe(0.3)
        hand(chart, fine, knots, speed=110.0, wet=False)
    surface.diffuse(3.0)
    surface.dry()
    rose = Painter(surface, "zhongbaiyun", "clear", amount=DipAmount(fullness=0.3))
    blossoms = (
        (14, 22, 11, 0.3, 0.95, 5), (-28, 49, 10, 1.3, 0.8, 5), (30, -2, 9, -0.4, 0.6, 4),
        (-4, 4, 9, 2.0, 0.9, 5), (15, 68, 8, 0.9, 0.55, 3),
    )  # fmt: skip

    def dab(x: float, y: float, out: NDArray, dark: float, press: float, aside) -> None:
        """A petal or bud: the tip, in dark, laid outwards from its heart, and turned."""
        rose.dip({"carmine": 0.1 * dark, "water": 1.0 - 0.1 * dark})
        rose.dip({"carmine": dark, "water": 1.0 - dark}, reach=0.17)
        way = np.add((x, y), np.outer([0.7, 0.55, 0.35], out))
        hand(chart, rose, np.c_[way, press * np.array([0.3, 1.0, 0.2])], aside, 30.0, wet=False)

    for x, y, size, turn, flat, n in blossoms:
        c, s = np.cos(turn), np.sin(turn)
        for k in range(n):
            angle = k * 2.0 * np.pi / 5.0 + random.normal(0.0, 0.12)
            out = np.array([[c, -s], [s, c]]) @ [np.cos(angle), flat * np.sin(angle)]
            press = np.hypot(*out) * random.uniform(0.24, 0.34)
            out *= size * random.uniform(0.9, 1.1)
            dab(x, y, out, random.uniform(0.06, 0.2), press, [-0.6, 0.6])
        surface.diffuse(1.0)
    for x, y, turn in (
        (-44, 9, 1.7), (-41, -16, 2.6), (45, 20, 0.6), (31, 32, 1.0), (9, 79, 2.2), (28, 26, 0.1),
    ):  # fmt: skip
        out = 5.0 * np.array([np.cos(turn), np.sin(turn)])
        dab(x, y, out, 0.4, random.uniform(0.12, 0.2), 0.2)
    surface.diffuse(8.0)
    surface.dry()
    for x, y, size, turn, flat, n in blossoms:
        fine.dip("thick")
        for angle in turn + np.linspace(0.2, 1.25 * n, 4 + n // 2):
            angle += random.normal(0.0, 0.2)
            out = size * random.uniform(0.25, 0.5) * np.array([np.cos(angle), flat * np.sin(angle)])
            way = np.array([x, y]) + np.outer([0.15, 0.6, 1.0, 1.08], out)
            hand(chart, fine, np.c_[way, [0.05, 0.02, 0.05, 0.14]], wet=False)
    fine.dip("burnt")
    for x, y in (
        (-40, -62), (-38, -59), (-31, -50), (-30, -38), (-25, -33), (-11, -16), (-22, 3), (-8, 27),
    ):  # fmt: skip
        away_x, away_y = random.normal((1.0, 0.5), 1.0)
        dot = [(x, y, 0.04), (x + away_x / 2, y + away_y / 2, 0.3), (x + away_x, y + away_y, 0.02)]
        hand(chart, fine, dot, wet=False)
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


def drop(
    surface: PaintedSurface, centre, radius: float, ink: dict[str, float], even: bool = False
) -> None:
    """Let a drop fall, a cap of so many coats of each ink in the mean; or lay an `even` wash.

    It lies on a disc (mm) that the fall has made a little uneven, its border soft.
    """
    mesh = surface.paint_mesh
    off = mesh.vertices[:, :2] - np.asarray(centre)
    away, turn = np.linalg.norm(off, axis=1), np.arctan2(off[:, 1], off[:, 0])
    turn = turn + np.sum(centre)
    reach = radius * (1.0 + 0.03 * np.sin(2.0 * turn) + 0.02 * np.sin(3.0 * turn + 1.0))
    share = np.clip((reach - away) / 0.5 + 0.5, 0, 1).astype(np.float32)
    height = np.ones_like(share) if even else 2.0 * np.clip(1.0 - (away / reach) ** 2, 0.04, 1)
    ids = np.flatnonzero(share > 0).astype(np.int32)
    for name, coats in ink.items():
        column = surface.column_of(load_pigment(name))
        surface.ink.amounts[ids, column] += (coats * height * share).astype(np.float32)[ids]
    surface.ink.coverage[ids] = np.maximum(surface.ink.coverage[ids], share[ids])
    surface.touch(ids)


def wet_in_wet(folder: Path) -> None:
    """A fruit in gamboge before one in indigo, touched again: left while wet, right when dry."""
    mesh = sheet(170.0, 86.0)
    surface, chart = PaintedSurface(mesh, 0.4, "xuan"), sheet_chart(mesh)
    wash = Painter(surface, "yanghao", "water", amount=DipAmount(fullness=0.4))
    touch = Painter(surface, "zhongbaiyun", "water", amount=DipAmount(fullness=0.5))
    fine = Painter(surface, "langhao", "thick")
    for x, dries in ((-43.0, False), (43.0, True)):
        for dx, dy, ink, halves in (
            (-13, 3, {"indigo": 0.3, "water": 0.7}, ((1.9, 5.0), (1.5, -1.1))),
            (10, -8, {"gamboge": 0.6, "water": 0.4}, ((1.8, 4.9), (1.3, -1.3))),
        ):
            for first, last in halves:  # round its heart, the tip along the border
                turns = np.linspace(first, last, 6)
                way = np.column_stack([1.25 * np.cos(turns), np.sin(turns)]) * -4.0
                wash.dip(ink)
                lie = np.sign(first - last) * np.pi / 2.0
                press = 0.3 * np.array([0.5, 0.95, 1.0, 0.97, 0.9, 0.4])
                hand(chart, wash, np.c_[np.add(way, (x + dx, dy)), press], lie, 50.0)
        surface.diffuse(2.0)
        if dries:
            surface.dry()
        for painter, ink, strokes in (
            (touch, {"carmine": 0.2, "water": 0.8}, [
                [(18, -2, 0.01), (23, -6, 0.14), (22, -14, 0.005)],
            ]),
            (fine, "thick", [
                [(8, 0, 0.2), (2, 3, 0.3), (-4, 0, 0.01)],
                [(10, 0, 0.2), (15, 2, 0.26), (18, -1, 0.01)],
                [(8, -1, 0.2), (7, -4, 0.26), (9, -9, 0.01)],
                [(10, 1, 0.25), (12, 7, 0.16), (10, 15, 0.3)],
                [(-15, 12, 0.2), (-21, 10, 0.4), (-25, 5, 0.01)],
                [(-13, 12, 0.2), (-9, 11, 0.3), (-6, 7, 0.01)],
                [(-14, 13, 0.4), (-11, 22, 0.16), (-15, 33, 0.28)],
            ]),
            (wash, "water", [[(-27, -1, 0.02), (-26, -6, 0.16), (-21, -11, 0.01)]]),
        ):  # fmt: skip
            for knots in strokes:
                painter.dip(ink)
                hand(chart, painter, np.add(knots, (x, 0.0, 0.0)))
        surface.diffuse(20.0)
        surface.dry()
    draw(surface, folder / "wet_in_wet.png", (1500, 800))


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
    """A spray of bamboo, a leaf by one stroke: by a solid tuft, and by 1,000 hairs."""
    mesh = sheet(170.0, 80.0)
    surface, chart = PaintedSurface(mesh, 0.25, "xuan"), sheet_chart(mesh)
    for x, hairs in ((-41.0, 0), (40.0, 1_000)):
        painter = Painter(surface, "full", "light", hairs=hairs, amount=DipAmount(fullness=0.14))
        twig = Painter(surface, "langhao", "heavy", hairs=hairs // 4)
        for knots in (
            [(-38, 33, 0.12), (-24, 29, 0.07), (-13, 22, 0.14)],
            [(-12, 21, 0.14), (2, 15, 0.06), (14, 5, 0.1)],
            [(-14, 20, 0.1), (-16, 14, 0.03), (-20, 9, 0.02)],
        ):
            twig.dip("thick")
            twig.wipe(0.4)
            hand(chart, twig, np.add(knots, (x, 0.0, 0.0)), speed=100.0, wet=False)
        for at_x, at_y, turn, long, press, tip in (
            (-21, 8, -120, 27, 0.2, "heavy"), (-20, 8, -92, 36, 0.28, "burnt"),
            (-19, 9, -62, 22, 0.16, "burnt"), (14, 4, -134, 33, 0.24, "burnt"),
            (15, 3, -101, 40, 0.32, "burnt"), (16, 4, -60, 34, 0.25, "thick"),
            (16, 6, -14, 24, 0.18, "light"), (-5, 18, 22, 26, 0.2, "heavy"),
        ):  # fmt: skip
            painter.dip("clear")
            painter.dip(tip, reach=0.17)
            way = np.radians(turn) + np.array([0.12, 0.06, 0.0, -0.05, -0.1])
            away = long * np.array([0.0, 0.15, 0.4, 0.75, 1.0])
            knots = np.column_stack([x + at_x + away * np.cos(way), at_y + away * np.sin(way)])
            hand(
                chart,
                painter,
                np.c_[knots, press * np.array([0.08, 0.6, 1.0, 0.5, 0.01])],
                0.35,
                110.0,
            )
    surface.diffuse(2.0)
    surface.dry()
    draw(surface, folder / "petals.png", (1500, 760))


def bloom(folder: Path) -> None:
    """Drops of the five tones, what water does to half-dry washes, and a line of glue."""
    mesh = sheet(170.0, 104.0)
    surface, chart = PaintedSurface(mesh, 0.35, "xuan"), sheet_chart(mesh)
    surface.refine_all()
    for x, y, radius, tone in (
        (-66, 31, 5.4, 1.0), (-37, 37, 4.2, 0.25), (-8, 29, 5.6, 0.15), (26, 35, 4.6, 0.09),
        (58, 28, 5.8, 0.04), (-57, 39, 1.1, 1.0), (-29, 32, 0.7, 0.25), (3, 39, 1.2, 0.15),
        (35, 41, 1.0, 0.09),
    ):  # fmt: skip
        drop(surface, (x, y), radius, {"pine soot": 2.6 * tone, "water": 2.6 * (1.0 - tone)})
    wash = Painter(surface, "yanghao", "light", amount=DipAmount(fullness=0.5))
    touch = Painter(surface, "zhongbaiyun", "water")
    for knots in (
        [(-56, -9, 0.15), (-50, -11, 0.36), (-36, -9, 0.34), (-27, -12, 0.05)],
        [(-46, -21, 0.15), (-52, -22, 0.38), (-64, -20, 0.3), (-73, -24, 0.05)],
        [(-2, -9, 0.15), (4, -11, 0.38), (15, -8, 0.34), (24, -11, 0.05)],
        [(9, -21, 0.15), (2, -22, 0.36), (-12, -20, 0.32), (-20, -24, 0.05)],
        [(46, -12, 0.15), (47, -19, 0.36), (45, -31, 0.3), (47, -41, 0.04)],
    ):
        wash.dip("light")
        hand(chart, wash, knots, 0.3)
    surface.diffuse(190.0)  # half dry
    for knots in (
        [(-54, -11, 0.05), (-52, -15, 0.5), (-46, -18, 0.05)],
        [(-6, -10, 0.05), (-4, -12, 0.26), (-1, -13, 0.03)],
        [(8, -17, 0.05), (10, -20, 0.36), (14, -21, 0.03)],
    ):
        touch.dip("water")
        hand(chart, touch, knots)
    surface.diffuse(600.0)
    wash.dip("heavy")
    hand(chart, wash, [(62, -10, 0.15), (61, -17, 0.36), (63, -30, 0.32), (61, -40, 0.05)], 0.3)
    surface.diffuse(600.0)
    draw(surface, folder / "bloom.png", (1500, 960))


def lotus(folder: Path) -> None:
    """A lotus leaf in broken ink: dark and water into wet strokes, then veins; and a bud."""
    mesh = sheet(200.0, 160.0)
    surface, chart = PaintedSurface(mesh, 0.45, "xuan"), sheet_chart(mesh)
    big = Painter(surface, "yanghao", "light", amount=DipAmount(fullness=0.4))
    small = Painter(surface, "zhongbaiyun", "water")

    def at(degrees: float, part: float) -> NDArray:
        """A point of the leaf, seen aslant."""
        turn = np.radians(degrees)
        return np.array([-26.0, 30.0]) + part * np.array(
            [62.0 * np.cos(turn), (36.0 if np.sin(turn) > 0.0 else 56.0) * np.sin(turn)]
        )

    for turn, last, first, to, press, belly, tip, aside in (  # from the heart, side-laid
        (112, 120, 0.22, 0.86, 0.54, "clear", "light", 1.0),
        (150, 166, 0.14, 0.95, 0.62, "heavy", "burnt", 1.0),
        (74, 72, 0.24, 0.88, 0.52, "light", "heavy", 0.8),
        (34, 40, 0.2, 0.93, 0.6, "clear", "heavy", 1.1),
        (2, 6, 0.26, 1.0, 0.58, "light", "thick", 1.0),
        (-170, -162, 0.22, 0.97, 0.58, "clear", "thick", 0.9),
        (-140, -134, 0.2, 0.92, 0.56, "light", "heavy", -0.9),
        (-92, -98, 0.16, 0.97, 0.54, "thick", "burnt", 0.7),
        (-62, -52, 0.2, 0.9, 0.56, "clear", "heavy", 0.9),
        (-28, -26, 0.25, 0.97, 0.5, "clear", "clear", 1.1),
    ):
        big.dip(belly)
        big.dip(tip, reach=0.1)
        u = np.linspace(0.0, 1.0, 5)
        way = [at(turn + (last - turn) * k**1.5, first + (to - first) * k) for k in u]
        hand(chart, big, np.c_[way, press * np.array([0.1, 0.5, 0.9, 1.0, 0.45])], aside)
    for turn, first, to, press in (
        (12, 0.6, 0.95, 0.14),
        (-96, 0.45, 0.8, 0.18),
        (150, 0.5, 0.8, 0.12),
    ):
        big.dip("thick")
        way = [at(turn, first), at(turn + 5, 0.5 * (first + to)), at(turn + 7, to)]
        hand(chart, big, np.c_[way, [0.02, press, 0.02]])
    surface.diffuse(15.0)
    for turn, first, to, press in (
        (170, 0.05, 0.86, 0.07), (58, 0.06, 0.8, 0.06), (14, 0.05, 0.88, 0.07),
        (-38, 0.1, 0.7, 0.05), (-84, 0.05, 0.86, 0.08), (-138, 0.07, 0.74, 0.06),
    ):  # fmt: skip
        small.dip("thick")
        small.wipe(0.7)
        bow = 9.0 if press > 0.055 else -8.0
        way = [
            at(turn + bow * np.sin(2.6 * k), first + (to - first) * k) for k in (0, 0.3, 0.65, 1)
        ]
        hand(chart, small, np.c_[way, press * np.array([0.7, 0.5, 0.35, 0.02])], 0.25, 140.0)
    for turn, part in ((140, 0.7), (52, 0.75), (-24, 0.6), (-128, 0.7), (-66, 0.7)):
        x, y = at(turn, part)
        small.dip("water")
        hand(chart, small, [(x, y, 0.05), (x + 1.5, y + 1, 0.3), (x + 5, y - 1, 0.03)])
    surface.diffuse(40.0)
    for tip, dryness, speed, knots in (
        ("thick", 0.7, 110.0, [(-21, -28, 0.03), (-18, -36, 0.13), (-12, -50, 0.08),
        (-10, -64, 0.09), (-13, -77, 0.14)]),
        ("thick", 0.8, 140.0, [(61, 38, 0.02), (62, 30, 0.09), (58, 4, 0.05), (50, -26, 0.07),
        (45, -52, 0.05), (46, -72, 0.01)]),
    ):  # fmt: skip
        small.dip("light")
        small.dip(tip, reach=0.2)
        small.wipe(dryness)
        hand(chart, small, knots, 0.3, speed, wet=False)
    rose = Painter(surface, "full", "water", amount=DipAmount(fullness=0.3))
    for knots, aside in (
        ([(57, 61, 0.02), (55.5, 54, 0.2), (57, 46, 0.26), (61, 39, 0.06)], (0.3, 0.1)),
        ([(65, 60, 0.02), (66.5, 54, 0.2), (66, 46, 0.22), (62.5, 39, 0.04)], (-0.3, 0.0)),
        ([(61, 68, 0.01), (60, 60, 0.22), (61, 48, 0.3), (62, 39, 0.05)], (0.1, 0.3)),
    ):
        rose.dip({"carmine": 0.02, "water": 0.98})
        rose.dip({"carmine": 0.5, "water": 0.5}, reach=0.17)
        hand(chart, rose, knots, aside, 50.0)
    dot = Painter(surface, "langhao", "thick")
    for x, y, press in ((-18, -40, 0.12), (-9, -57, 0.18), (62, 18, 0.1), (54, -12, 0.16)):
        dot.dip("thick")
        hand(chart, dot, [(x, y, 0.03), (x + 0.9, y - 0.7, press), (x + 1.8, y - 1.3, 0.03)])
    surface.diffuse(4.0)
    surface.dry()
    draw(surface, folder / "lotus.png", (1500, 1180))


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
