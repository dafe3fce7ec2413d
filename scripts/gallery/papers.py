"""The papers' figures, made anew: docs/papers.md sets them beside what is printed there."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy.interpolate import CubicSpline

sys.path.insert(0, str(Path(__file__).parent))
from ink import draw, sheet, sheet_chart
from ink import stroke as way_of
from writing import beside, drawn, seen_from_above, stacked, titled, written

from paint3d.brush.presets import load_brush
from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.layout import Layout
from paint3d.calligraphy.path_fit import TECHNIQUES, PlanSettings
from paint3d.calligraphy.writing import WritingSettings, write_text
from paint3d.device.sample import DeviceSample
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import make_chart
from paint3d.mesh.placement import place
from paint3d.painter.painter import Painter
from paint3d.pose.brush_pose import object_poses
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.brush_shape import (
    BrushStand,
    grid_faces,
    grid_normals,
    handle_rings,
    tuft_rings,
)
from paint3d.view.camera import View
from paint3d.view.picture import draw_picture
from paint3d.view.pressed_tuft import TuftFollower
from paint3d.view.studio import Gloss

FORCES = (0.5, 2.0, 4.0, 6.0, 7.9)  # N
GREATEST = 7.9  # N, of the papers' device
STEP = 40.0  # mm between brushes
SPACING = 0.144  # the same as a share of the picture's width
HAIR = (52, 46, 40)
RED = (190, 40, 30)
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def press(x: float, y: float, force: float, brush: str) -> list[DeviceSample]:
    """Samples of an upright brush that comes down onto z = 0 at a place with so much force."""
    spec = load_brush(brush)
    pressures = np.linspace(0.0, force / GREATEST, 60)
    return [
        DeviceSample(
            (k + 1) * 8_000_000,
            np.array([x, y, spec.length_mm - pe * spec.full_press_mm]),
            UPRIGHT,
            float(pe),
            0,
            np.zeros(3),
            UPRIGHT,
        )
        for k, pe in enumerate(pressures)
    ]


def standing(x: float, force: float, brush: str) -> list[tuple[NDArray, ...]]:
    """Vertices, faces, normals and colours of a brush pressed with a force, tuft and handle."""
    mesh = sheet(STEP, STEP)
    painter = Painter(PaintedSurface(mesh, None, "xuan"), brush, "pine soot")
    samples = press(0.0, 0.0, force, brush)
    pressed = TuftFollower().follow(painter, object_poses(samples))
    stand = BrushStand.of(painter.tuft, samples[-1].position, np.eye(3), pressed)
    parts = []
    rings, _ = tuft_rings(painter.tuft, stand)
    dark = np.broadcast_to(HAIR, rings.shape)
    handle, colours = handle_rings(painter.tuft, stand)
    for points, shade in ((rings, dark), (handle[:9], colours[:9])):
        normals = grid_normals(points).reshape(-1, 3)
        faces = grid_faces(len(points))
        there = points.reshape(-1, 3) + np.array([x, 0.0, 0.0])
        parts.append((there, faces, normals, np.clip(shade.reshape(-1, 3), 0, 255)))
    return parts


def joined(parts: list[tuple[NDArray, ...]]) -> tuple[NDArray, ...]:
    """Meshes as one."""
    first = np.cumsum([0, *(len(part[0]) for part in parts)])
    faces = [part[1] + n for part, n in zip(parts, first, strict=False)]
    vertices, _, normals, colours = (np.concatenate(some) for some in zip(*parts, strict=True))
    return (
        vertices.astype(np.float32), np.concatenate(faces).astype(np.int32),
        normals.astype(np.float32), np.rint(colours).astype(np.uint8),
    )  # fmt: skip


def row_of_brushes(brushes: list[str], forces: list[float], size: tuple[int, int]) -> Image.Image:
    """Brushes that stand on a sheet side by side, and before each what it leaves."""
    width = STEP * len(brushes)
    surface = PaintedSurface(sheet(width + STEP, 2.0 * STEP), 0.2, "xuan")
    parts = []
    for k, (brush, force) in enumerate(zip(brushes, forces, strict=True)):
        x = STEP * (k - 0.5 * (len(brushes) - 1))
        painter = Painter(surface, brush, "pine soot")
        painter.advance(press(x, -0.55 * STEP, force, brush))
        painter.finish()
        parts += standing(x, force, brush)
    whole = joined([surface.export_arrays(tolerance=0.5), *parts])
    gloss = Gloss.of("xuan")
    view = View((0.0, -1.0, 0.62), (0.0, 0.0, 1.0), 1.12)
    return Image.fromarray(draw_picture(*whole, size=size, view=view, gloss=gloss))


def draw_deformation(file: Path, _glyphs: Path) -> None:
    """The tuft under five forces, and before it the footprint that it leaves."""
    picture = row_of_brushes(["slender"] * len(FORCES), list(FORCES), (1500, 720))
    named(picture, [f"{force:g} N" for force in FORCES]).save(file)


def draw_sizes(file: Path, _glyphs: Path) -> None:
    """Brushes of five sizes under one force."""
    brushes = ["gongbi", "xiaokai", "xiaobaiyun", "slender", "full"]
    picture = row_of_brushes(brushes, [4.0] * len(brushes), (1500, 720))
    named(picture, [f"{name}, 4 N" for name in brushes]).save(file)


def named(picture: Image.Image, words: list[str]) -> Image.Image:
    """A picture with words below, from left to right."""
    page = Image.new("RGB", (picture.width, picture.height + 34), "white")
    page.paste(picture, (0, 0))
    pen = ImageDraw.Draw(page)
    for k, word in enumerate(words):
        x = picture.width * (0.5 + SPACING * (k - 0.5 * (len(words) - 1)))
        pen.text((x, picture.height + 8), word, fill=(60, 40, 40), anchor="ma", font_size=18)
    return page


def draw_force_and_technique(file: Path, _glyphs: Path) -> None:
    """One stroke under four forces in three techniques: the bend in red, the way in blue."""
    columns = []
    for name, angle in TECHNIQUES.items():
        rows = []
        for force in (1.0, 3.0, 5.0, 7.9):
            surface = PaintedSurface(sheet(120.0, 60.0), 0.2, "xuan")
            t = np.linspace(-26.0, 26.0, 120)
            chart = sheet_chart(surface.source)
            pe = force / GREATEST * np.clip(0.25 * np.minimum(t + 26.0, 26.0 - t), 0.0, 1.0)
            lie = np.full(len(t), angle)
            way = np.column_stack([t - 8.0 * np.cos(angle), -11.0 * np.sin(angle) + 0 * t])
            Painter(surface, "slender", "pine soot").replay(way_of(chart, way, pe, lie, "slender"))
            picture = seen_from_above(surface, (-48, -22, 48, 22), 560)
            rows.append(with_arrows(titled(picture, f"{name}, {force:g} N"), angle))
        columns.append(stacked(rows))
    beside(columns).save(file)


def with_arrows(picture: Image.Image, bend: float) -> Image.Image:
    """Draw which way the tuft is bent, and which way it goes."""
    pen = ImageDraw.Draw(picture)
    middle = np.array([picture.width - 54.0, 34.0])
    for angle, colour in ((bend, RED), (0.0, (40, 70, 170))):
        along = np.array([np.cos(angle), -np.sin(angle)])
        tip = middle + 24.0 * along
        pen.line([tuple(middle), tuple(tip)], fill=colour, width=3)
        for side in (-1.0, 1.0):
            across = side * np.array([-along[1], along[0]])
            pen.line([tuple(tip), tuple(tip - 9.0 * along + 6.0 * across)], fill=colour, width=3)
    return picture


def draw_common_strokes(file: Path, glyphs: Path) -> None:
    """Strokes of regular script, written as characters of one stroke each and as parts of some."""
    surface = written("一丨丿丶\n乙亅乛乚", "plane", 40.0, glyphs, Layout("row", gap=0.05))
    box = np.asarray(surface.mesh.vertices)[surface.painted][:, :2]
    low, high = box.min(axis=0) - 6.0, box.max(axis=0) + 6.0
    seen_from_above(surface, (*low, *high), 1400).save(file)


def draw_beside_copybook(file: Path, glyphs: Path) -> None:
    """Characters of the copybook (the font's outlines) above those that the brush writes."""
    text, side = "永和九年書道", 240
    book, rows = open_glyphs(glyphs), []
    for character in text:
        shapes = [(stroke.outline, True) for stroke in book.load(character).strokes]
        surface = written(character, "plane", 60.0, glyphs, Layout())
        ours = seen_from_above(surface, (-30, -30, 30, 30), side)
        rows.append(stacked([drawn(shapes, side).convert("RGB"), ours]))
    beside(rows).save(file)


def draw_bowl_bottom(file: Path, glyphs: Path) -> None:
    """A branch of plum in the bottom of the bowl: a twig dark at its tip, pale petals, buds."""
    surface = PaintedSurface(load_mesh("bowl"), 0.2, "porcelain")
    plum(surface, 0.0)
    draw(surface, file, (1400, 1050), View((0.0, -0.5, 1.0), (0.0, 0.0, 1.0), 2.3))


def line(chart, painter, points, press) -> None:
    """A branch: a stroke through points."""
    painter.replay(way_of(chart, np.asarray(points, float), np.asarray(press, float)))


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
            painter.replay(way_of(chart, way[first:last], pressures[first:last], brush=brush))


def plum(surface: PaintedSurface, seconds: float) -> None:
    """The branch, lifted where blossoms sit, and after a time the blossoms."""
    closest = ClosestPoints(load_mesh("bowl"))
    chart = make_chart(closest, place(closest, (0.5, 0.5), side="top"), 44.0, 44.0)
    painter = Painter(surface, "xiaobaiyun", "heavy")
    twigs = (
        (
            [(-17, -9), (-10, -6), (-3, -4.5), (4, 1), (9, 3.5), (15, 10)],
            (0.5, 0.34, 0.4, 0.24, 0.02),
        ),
        ([(-8, -6), (-7.5, 0), (-5, 5), (-4.5, 12), (-2, 17)], (0.26, 0.2, 0.12, 0.02)),
        ([(3, 0), (8, -2), (12, -7)], (0.24, 0.15, 0.02)),
        ([(5.5, 2), (6, 8), (9, 14)], (0.16, 0.11, 0.02)),
    )
    blossoms = ((13.5, 1.5, 0.9, 0.2), (-8.5, 9.5, 0.95, 0.9), (-14.0, 0.5, 0.85, 0.6))
    kept = [(x, y, 5.0 * size) for x, y, size, _ in blossoms]
    for points, presses in twigs:
        painter.dip("heavy")
        painter.dip("burnt", reach=0.4)
        twig(chart, painter, points, presses, kept, "xiaobaiyun")
    surface.diffuse(seconds)
    surface.dry()
    for x, y, size, turn in blossoms:
        blossom(chart, painter, np.array([x, y]), size, turn)
    for x, y, turn in ((11.6, -6.6, -0.8), (8.8, 13.6, 1.2), (-2.2, 16, 1.4), (14.4, 9.6, 0.6)):
        petal(chart, painter, np.array([x, y]), turn, 0.55, 0.2)
    surface.diffuse(0.2)
    surface.dry()
    for x, y, _, turn in blossoms:
        stamens(chart, painter, np.array([x, y]), turn)


def petal(chart, painter: Painter, centre: NDArray, turn: float, size: float, deep: float) -> None:
    """A round dab, dark without and pale within, whose tip points away from its heart."""
    painter.rinse()
    painter.dip({"carmine": 0.003, "water": 0.997})
    painter.dip({"carmine": deep, "water": 1.0 - deep}, reach=0.3)
    for aside in (-0.34, 0.34):  # two halves, so that it is round
        out = np.array([np.cos(turn + aside), np.sin(turn + aside)])
        way = centre + size * out * np.linspace(2.3, 1.3, 16)[:, None]
        press = 0.36 * size * np.sin(np.pi * np.linspace(0.0, 1.0, 16)) ** 0.6
        painter.replay(way_of(chart, way, press, np.full(16, turn + 0.6 * aside), "xiaobaiyun"))


def blossom(chart, painter: Painter, centre: NDArray, size: float, turn: float) -> None:
    """Five petals."""
    for k in range(5):
        angle = turn + k * 2.0 * np.pi / 5.0 + 0.15 * np.sin(7.0 * k)
        petal(chart, painter, centre, angle, size * (1.0 + 0.1 * np.cos(3.0 * k)), 0.05)


def stamens(chart, painter: Painter, centre: NDArray, turn: float) -> None:
    """Lines from the heart, and dots at their ends."""
    painter.rinse()
    painter.dip("burnt")
    for k in range(7):
        angle = turn + 0.3 + k * 2.0 * np.pi / 7.0
        out = np.array([np.cos(angle), np.sin(angle)])
        length = 2.2 + 0.4 * np.cos(5.0 * k)
        line(
            chart, painter, centre + np.outer([0.3, length, length + 0.25], out), [0.01, 0.02, 0.07]
        )


def draw_shi(file: Path, glyphs: Path) -> None:
    """世 on the side of the bowl."""
    draw(written("世", "bowl", 50.0, glyphs, Layout()), file)


def draw_manbu(file: Path, glyphs: Path) -> None:
    """漫步人生 on the bowl as it is written, and later: xuan drinks; then a plum in its bottom."""
    settings = WritingSettings(load_brush("xiaobaiyun"), 30.0, PlanSettings())
    mesh, pictures = load_mesh("bowl"), []
    told = write_text(mesh, "漫步人生", open_glyphs(glyphs), settings, Layout("row"))
    side = View((0.0, -1.0, 0.3), (0.0, 0.0, 1.0), 1.12)
    for seconds in (0.0, 20.0):
        surface = PaintedSurface(mesh, 0.3, "xuan")
        painter = Painter(surface, "xiaobaiyun", "thick")
        painter.replay(told.recording)
        surface.diffuse(seconds)
        part = file.with_name(f"part_{seconds:g}.png")
        draw(surface, part, (900, 675), side)
        pictures.append(Image.open(part).convert("RGB"))
        part.unlink()
    surface.dry()
    plum(surface, 0.0)
    surface.diffuse(0.15)
    draw(surface, file, (900, 675), View((0.0, -0.5, 1.0), (0.0, 0.0, 1.0), 2.3))
    beside([*pictures, Image.open(file).convert("RGB")]).save(file)


def draw_sea_of_clouds(file: Path, glyphs: Path) -> None:
    """云海, written four times as fast with a dry brush of single hairs: flying white."""
    settings = WritingSettings(load_brush("feibai"), 90.0, PlanSettings())
    told = write_text(load_mesh("plane"), "云海", open_glyphs(glyphs), settings, Layout("row"))
    slow = told.recording
    fast = Recording(
        slow.time_ns // 4, slow.position, slow.orientation, slow.pressure, header=slow.header
    )
    surface = PaintedSurface(load_mesh("plane"), 0.2, "xuan")
    painter = Painter(surface, "feibai", "pine soot", hairs=1_000)
    painter.wipe(0.6)
    painter.replay(fast)
    seen_from_above(surface, (-100, -55, 100, 55), 1400).save(file)


PICTURES = {
    "deformation.png": draw_deformation,
    "brush_sizes.png": draw_sizes,
    "force_and_technique.png": draw_force_and_technique,
    "common_strokes.png": draw_common_strokes,
    "beside_copybook.png": draw_beside_copybook,
    "bowl_bottom.png": draw_bowl_bottom,
    "shi_on_bowl.png": draw_shi,
    "manbu_with_diffusion.png": draw_manbu,
    "sea_of_clouds.png": draw_sea_of_clouds,
}
