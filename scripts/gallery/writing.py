"""Pictures of writing: techniques, centre lines, characters on objects, a poem."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

import paint3d
from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import choose_brush, load_brush
from paint3d.brush.spec import DipAmount
from paint3d.calligraphy.dips import apply_dip_option
from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.kanjivg import find_kanjivg, load_lines
from paint3d.calligraphy.kernels import raster
from paint3d.calligraphy.layout import Layout
from paint3d.calligraphy.path_fit import TECHNIQUES, PlanSettings
from paint3d.calligraphy.writing import WritingSettings, write_text
from paint3d.cli.painting import WRITING_INK
from paint3d.colour.materials import Material, load_material
from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface

POEM = "千山鳥飛絕\n萬徑人蹤滅\n孤舟蓑笠翁\n獨釣寒江雪"
FINER = 3  # samples to a side of a pixel


def painted(
    recording: Recording, name: str, resolution: float, material: Material
) -> PaintedSurface:
    """An object with a recording on it."""
    surface = PaintedSurface(load_mesh(name), resolution=resolution, material=material)
    header = recording.header
    brush, ink = header.get("brush", "full"), header.get("ink", WRITING_INK)
    amount = DipAmount.of(header.get("dip", {}))
    Painter(surface, brush, ink, amount=amount).replay(recording)
    return surface


def written(text: str, name: str, em: float, glyphs: Path | None, layout: Layout, **look):
    """A text on an object."""
    settings = PlanSettings(technique=look.pop("technique", None))
    settings = WritingSettings(
        load_brush(look.pop("brush", choose_brush(em))), em, settings, variation=1.0
    )
    written = write_text(load_mesh(name), text, open_glyphs(glyphs), settings, layout, header=look)
    material = load_material("xuan" if "plane" in name or "sheet" in name else "porcelain")
    recording = apply_dip_option(written.recording, settings.brush, "auto", material)
    return painted(recording, name, em / 200.0, material)


def seen_from_above(surface: PaintedSurface, box: tuple[float, ...], width: int) -> Image.Image:
    """The part (low x, low y, high x, high y; mm) of a painted plane, straight from above."""
    low = np.array(box[:2])
    scale = width * FINER / (box[2] - box[0])
    size = round((box[3] - box[1]) * scale / FINER) * FINER, width * FINER
    mesh = surface.mesh
    points = np.ascontiguousarray((np.asarray(mesh.vertices, float)[:, :2] - low) * scale)
    srgb = np.asarray(surface.srgb)[: len(points)]
    layers = []
    for channel in range(3):
        layer = np.zeros(size, np.float32)
        values = srgb[:, channel].astype(np.float32)
        raster.fill_triangles(points, values, np.asarray(mesh.faces, np.int32), layer)
        layers.append(layer.reshape(size[0] // FINER, FINER, width, FINER).mean(axis=(1, 3)))
    return Image.fromarray(np.stack(layers, axis=-1)[::-1].round().astype(np.uint8))


def straight(angle: float, y: float, pressure: float) -> NDArray:
    """Rows of x, y, azimuth and pressure: pressed, drawn to the right, lifted where it ends."""
    t = np.linspace(0.0, 1.0, 240)
    x = 48.0 * (np.clip((t - 0.2) / 0.6, 0.0, 1.0) - 0.5)
    press = pressure * np.clip(6.0 * np.minimum(t, 1.0 - t), 0.0, 1.0)
    return np.stack([x, y + 0.0 * t, angle + 0.0 * t, press], axis=1)


def draw_techniques(file: Path, glyphs: Path) -> None:
    """One stroke at 4 N in three techniques, and one character in each."""
    tuft = build_tuft(load_brush("slender"))
    strips = []
    for name, angle in TECHNIQUES.items():
        rows = straight(angle, -11.0 * math.sin(angle), 4.0 / 7.9)
        half = 0.5 * rows[:, 2]
        turn = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1)
        root = np.column_stack([rows[:, :2], tuft.length - rows[:, 3] * tuft.full_press])
        time_ns = np.arange(len(rows)) * 8_000_000
        header = {"brush": "slender"}
        recording = Recording(time_ns, root, turn, rows[:, 3], header=header)
        stroke = seen_from_above(painted(recording, "plane", 0.25, "xuan"), (-42, -12, 42, 12), 560)
        surface = written("永", "plane", 60.0, glyphs, Layout(), technique=name)
        character = seen_from_above(surface, (-56, -33, 56, 33), 560)
        strips.append(stacked([titled(stroke, name), character]))
    beside(strips).save(file)


def draw_centre_lines(file: Path, glyphs: Path) -> None:
    """Centre lines, what is made of them, and the outlines of the font."""
    text, side = "永水我心大国学風書漫", 150
    lines, font, shaped = find_kanjivg(), open_glyphs(glyphs), open_glyphs(None)
    sheet = Image.new("L", (side * len(text), side * 3), 255)
    for k, character in enumerate(text):
        rows = [
            [(stroke.line, False) for stroke in load_lines(lines, character)],
            [(stroke.outline, True) for stroke in shaped.load(character).strokes],
            [(stroke.outline, True) for stroke in font.load(character).strokes],
        ]
        for row, shapes in enumerate(rows):
            sheet.paste(drawn(shapes, side), (k * side, row * side))
    sheet.save(file)


def drawn(shapes: list[tuple[NDArray, bool]], side: int) -> Image.Image:
    """Lines or filled outlines in an em square."""
    large = Image.new("L", (4 * side, 4 * side), 255)
    pen = ImageDraw.Draw(large)
    for points, filled in shapes:
        at = [tuple(p) for p in (points * [1, -1] + [0, 900]) * (4 * side / 1024)]
        pen.polygon(at, fill=0) if filled else pen.line(at, fill=0, width=side // 14)
    return large.resize((side, side), Image.LANCZOS)


def draw_objects(file: Path, glyphs: Path) -> None:
    """Characters on the side of the bowl, down the vase, around the sphere, and in the bowl."""
    wishes = [
        ("漫步人生", "bowl", 34.0, Layout("row")),
        ("上善若水", "vase", 70.0, Layout()),
        ("天圆地方", "sphere", 34.0, Layout()),
        ("福", "bowl", 40.0, Layout(side="top")),
    ]
    pictures = []
    for text, name, em, layout in wishes:
        surface = written(text, name, em, glyphs, layout)
        paint3d.export(surface, file)
        pictures.append(Image.open(file).convert("RGB").resize((640, 480), Image.LANCZOS))
    pairs = [beside(pictures[:2]), beside(pictures[2:])]
    stacked(pairs).save(file)


def draw_poem(file: Path, glyphs: Path) -> None:
    """A poem of 20 characters on the bowl."""
    paint3d.export(written(POEM, "bowl", 11.0, glyphs, Layout(gap=0.35)), file)
    Image.open(file).convert("RGB").resize((1000, 750), Image.LANCZOS).save(file)


def draw_poem_on_paper(file: Path, glyphs: Path) -> None:
    """The same poem on paper, from centre lines, as `paint3d write` varies and dips it."""
    layout = Layout(gap=0.25, between=0.12)
    surface = written(POEM.replace("絕", "絶"), "sheet:150x180", 26.0, None, layout)
    seen_from_above(surface, (-75, -90, 75, 90), 900).save(file)


def titled(picture: Image.Image, title: str) -> Image.Image:
    """A picture with a line of text in its corner."""
    ImageDraw.Draw(picture).text((10, 8), title, fill=(110, 60, 50))
    return picture


def beside(pictures: list[Image.Image]) -> Image.Image:
    """Pictures from left to right."""
    width, height = sum(p.width for p in pictures), max(p.height for p in pictures)
    sheet = Image.new("RGB", (width, height), "white")
    x = 0
    for picture in pictures:
        sheet.paste(picture, (x, 0))
        x += picture.width
    return sheet


def stacked(pictures: list[Image.Image]) -> Image.Image:
    """Pictures from top to bottom, centred."""
    width, height = max(p.width for p in pictures), sum(p.height for p in pictures)
    sheet = Image.new("RGB", (width, height), "white")
    y = 0
    for picture in pictures:
        sheet.paste(picture, ((width - picture.width) // 2, y))
        y += picture.height
    return sheet


def draw_dips(file: Path, glyphs: Path) -> None:
    """A column in full black, dipped as a writer would, and so with single hairs."""
    text, em = "春眠不覚暁", 20.0
    settings = WritingSettings(load_brush(choose_brush(em)), em)
    written = write_text(load_mesh("plane"), text, open_glyphs(None), settings, Layout())
    dipped = apply_dip_option(written.recording, settings.brush, "auto", load_material("xuan"))
    columns = []
    for recording, hairs in ((written.recording, 0), (dipped, 0), (dipped, 1000)):
        surface = PaintedSurface(load_mesh("plane"), resolution=0.1, material="xuan")
        amount = DipAmount.of(recording.header.get("dip", {}))
        Painter(surface, settings.brush, hairs=hairs, amount=amount).replay(recording)
        columns.append(seen_from_above(surface, (-12, -52, 12, 52), 320))
    beside(columns).save(file)


PICTURES = {
    "dips.png": draw_dips,
    "techniques.png": draw_techniques,
    "centre_lines.png": draw_centre_lines,
    "objects.png": draw_objects,
    "poem_on_bowl.png": draw_poem,
    "poem_on_paper.png": draw_poem_on_paper,
}
