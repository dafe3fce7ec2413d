"""Photographs of writing whose truth is known: a sheet, its inks, a table, light and a camera.

Everything is drawn at random by a seed. What is on the sheet comes from strokes with outlines and
lines; some are dry, by a model of hairs that let go one after another.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy.ndimage import gaussian_filter, map_coordinates, zoom

from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.photo.copying import CopiedSheet
from paint3d.calligraphy.photo.flat_page import on_sheet
from paint3d.calligraphy.photo.sheet import homography, map_points
from paint3d.core.arrays import AnyArray

__all__ = [
    "Camera",
    "Judged",
    "Photographed",
    "TrueSheet",
    "carried",
    "hairs_below_a_stroke",
    "judge",
    "photograph",
    "sheet_of",
    "strengths_of",
]


@dataclass(frozen=True, eq=False)
class TrueSheet:
    """Truth about a sheet: ink 0 to 1, the strokes' whole shapes, the red of seals 0 to 1.

    And what share of the light its ink takes, of that which black ink takes; 1 off the strokes.
    """

    ink: NDArray[np.float32]
    body: NDArray[np.bool_]
    red: NDArray[np.float32]
    strength: NDArray[np.float32]


@dataclass(frozen=True)
class Camera:
    """Conditions of a photograph; every number is a strength, 1 about the usual."""

    size: int = 1500
    perspective: float = 1.0
    light: float = 1.0
    shadow: float = 1.0
    vignette: float = 1.0
    noise: float = 1.0
    blur: float = 0.8  # pixels
    jpeg: int = 85
    fills: bool = False  # the picture is the sheet, as from a scanner


@dataclass(frozen=True, eq=False)
class Photographed:
    """A photograph (H, W, 3) uint8 and the true corners (4, 2) of its sheet."""

    pixels: NDArray[np.uint8]
    corners: NDArray[np.float64]
    sheet: TrueSheet


def sheet_of(
    glyphs: Sequence[Glyph],
    seed: int,
    *,
    dry: float = 0.0,
    seals: int = 1,
    longest: int = 1400,
    columns: int | None = None,
    pale: float = 0.0,
) -> TrueSheet:
    """Write glyphs on a sheet in columns from the right; a share of the strokes in thin ink."""
    rng = np.random.default_rng(seed)
    n = len(glyphs)
    columns = columns or max(1, round(np.sqrt(n * 0.6)))
    rows = -(-n // columns)
    cell = longest / max(rows, columns)
    margin = rng.uniform(0.25, 0.5) * cell
    width, height = (round(k * cell + 2.0 * margin) for k in (columns, rows))
    factor = longest / max(width, height)
    cell, margin = factor * cell, factor * margin
    width, height = round(factor * width), round(factor * height)
    strokes = []
    for k, glyph in enumerate(glyphs):
        column, row = divmod(k, rows)
        corner = np.array([margin + (columns - 1 - column) * cell, margin + row * cell])
        corner = corner + rng.uniform(-0.03, 0.03, 2) * cell
        scale = 0.92 * cell / 1024.0
        strokes += [_moved(stroke, corner, scale) for stroke in glyph.strokes]
    ink = np.zeros((height, width), np.float32)
    body = np.zeros((height, width), bool)
    strength, thin = np.ones((height, width), np.float32), np.random.default_rng(seed + 31)
    for outline, line in strokes:
        region = _filled(outline, (height, width))
        if pale and thin.random() < pale:
            grown = gaussian_filter(region.astype(np.float32), 1.5) > 0.02
            strength[grown & ~body] = thin.uniform(0.3, 0.9)
        else:
            strength[region] = 1.0
        body |= region
        dryness = dry * rng.uniform(0.35, 1.0) if dry and rng.random() < 0.65 else 0.0
        values = _hairs(region, line, dryness, rng)
        ink = np.maximum(ink, values)
    ink = gaussian_filter(ink, 0.6)
    red = np.zeros((height, width), np.float32)
    for _ in range(seals):
        _press_seal(red, cell, rng)
    return TrueSheet(ink, body, red, strength)


def _moved(stroke: GlyphStroke, corner: AnyArray, scale: float) -> tuple[AnyArray, AnyArray]:
    def move(points: AnyArray) -> AnyArray:
        return corner + scale * np.column_stack([points[:, 0], 900.0 - points[:, 1]])

    return move(stroke.outline), move(stroke.median)


def _filled(outline: AnyArray, size: tuple[int, int]) -> NDArray[np.bool_]:
    image = Image.new("1", size[::-1], 0)
    ImageDraw.Draw(image).polygon([tuple(point - 0.5) for point in outline], fill=1)
    return np.array(image)


def _hairs(region: AnyArray, line: AnyArray, dry: float, rng: np.random.Generator) -> AnyArray:
    """Ink of one stroke: hairs across it let go at places along it."""
    from scipy.spatial import cKDTree

    ink = region.astype(np.float32)
    if dry <= 0.0:
        return ink
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    fine = np.linspace(0.0, way[-1], max(8, int(way[-1])))
    points = np.column_stack([np.interp(fine, way, line[:, k]) for k in (0, 1)])
    tangent = np.gradient(points, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-9)
    rows, columns = np.nonzero(region)
    places = np.column_stack([columns, rows]) + 0.5
    _, k = cKDTree(points).query(places)
    off = places - points[k]
    side = off[:, 1] * tangent[k, 0] - off[:, 0] * tangent[k, 1]
    width = region.sum() / max(way[-1], 1.0)
    t = k / max(1, len(points) - 1)
    n = int(rng.integers(14, 40))
    lane = np.clip((side / width + 0.65) / 1.3, 0.0, 0.999) * (n - 1)
    hair = gaussian_filter(rng.standard_normal(n), 0.8, mode="wrap")
    along = gaussian_filter(rng.standard_normal((n, 200)), (0.6, 7.0))
    hair, along = hair / hair.std(), along / along.std()
    low = lane.astype(int)
    kind = rng.integers(3)  # dries out; dry in the middle, where it was quick; dry from the start
    profile = (np.clip((t - 0.2) / 0.8, 0, 1), np.sin(np.pi * t), 0.6 + 0.4 * t)[kind]
    value = 0.8 * hair[low] + 0.7 * along[low, (199 * t).astype(int)]
    bare = value < -2.6 + 3.6 * dry * profile
    ink[rows, columns] = np.where(bare, 0.0, 1.0 - 0.3 * dry * profile)
    return ink


def _press_seal(red: AnyArray, cell: float, rng: np.random.Generator) -> None:
    """A square seal, red lines or white ones, somewhere on the sheet."""
    size = int(rng.uniform(0.2, 0.4) * cell)
    height, width = red.shape
    x, y = (int(rng.uniform(0.03, 0.95) * (n - size)) for n in (width, height))
    border = max(2, size // 14)
    stone = np.ones((size, size), np.float32)
    stone[2 * border : -2 * border, 2 * border : -2 * border] = 0
    for at in rng.uniform(0.2, 0.75, 3):
        first = int(at * size)
        stone[3 * border : -3 * border, first : first + border] = 1
    for at in rng.uniform(0.25, 0.75, 2):
        first = int(at * size)
        stone[first : first + border, 3 * border : -3 * border] = 1
    if rng.random() < 0.4:
        stone = 1.0 - stone
        stone[:border] = stone[-border:] = 1.0
    stone *= rng.random((size, size)) > 0.05
    there = red[y : y + size, x : x + size]
    np.maximum(there, gaussian_filter(stone, 0.9), out=there)


# -- the camera ---------------------------------------------------------------------------------


def photograph(sheet: TrueSheet, seed: int, camera: Camera | None = None) -> Photographed:
    """Photograph a sheet."""
    camera = camera or Camera()
    rng = np.random.default_rng(seed + 7919)
    height, width = sheet.ink.shape
    paper = _paper(height, width, rng)
    dark = rng.uniform(0.9, 1.5)
    black = dark * sheet.ink * np.exp(0.1 * _noise(height, width, (50, 140), rng))
    tone = np.array([1.0, 1.0, rng.uniform(0.94, 1.0)])
    hue = np.array([rng.uniform(0.05, 0.18), 1.0, rng.uniform(0.75, 1.0)])
    red = 10.0 ** -(rng.uniform(0.55, 0.9) * sheet.red[..., None] * hue)
    if rng.random() < 0.5:  # ink that thins out towards its edges
        back = 10.0 ** -(black[..., None] * tone)
    else:  # ink with edges as sharp as the paper's grain lets them be
        cover = np.clip(sheet.ink, 0.0, 1.0)[..., None]
        back = 1.0 - cover * (
            1.0 - 10.0 ** -((black / np.maximum(sheet.ink, 0.05))[..., None] ** tone)
        )
    back = 1.0 - sheet.strength[..., None] * (1.0 - back)
    shown = (paper * back * red + 0.01).astype(np.float32)
    corners, size = _corners(width, height, camera, rng)
    image = _seen(shown, corners, size, rng, camera)
    image *= _light(size, camera, rng)[..., None]
    image *= np.array([1.0, rng.uniform(0.86, 1.0), rng.uniform(0.68, 1.0)])
    image *= rng.uniform(0.75, 1.05) / max(float(np.percentile(image, 98.0)), 0.05)
    image = np.stack([gaussian_filter(image[..., k], camera.blur) for k in range(3)], axis=-1)
    spread = camera.noise * (0.003 + 0.010 * np.sqrt(np.clip(image, 0.0, 1.0)))
    image += rng.standard_normal(image.shape) * spread
    image = np.clip(image, 0.0, 1.0)
    codes = np.where(image <= 0.0031308, 12.92 * image, 1.055 * image ** (1 / 2.4) - 0.055)
    pixels = np.round(255.0 * codes).astype(np.uint8)
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG", quality=camera.jpeg)
    return Photographed(np.array(Image.open(file).convert("RGB")), corners, sheet)


def _noise(height: int, width: int, scales: Sequence[int], rng: np.random.Generator) -> AnyArray:
    total = np.zeros((height, width), np.float32)
    for scale in scales:
        small = rng.standard_normal((height // scale + 3, width // scale + 3)).astype(np.float32)
        total += zoom(small, scale, order=1)[:height, :width]
    return total / max(float(total.std()), 1e-6)


def _paper(height: int, width: int, rng: np.random.Generator) -> AnyArray:
    white = np.array([0.88, 0.84, 0.76]) * rng.uniform(0.85, 1.0, 3)
    fibre = 0.025 * _noise(height, width, (2, 5, 17), rng)
    blotch = 0.03 * _noise(height, width, (90, 200), rng)
    return (np.exp(fibre + blotch)[..., None] * white).astype(np.float32)


def _corners(
    width: int, height: int, camera: Camera, rng: np.random.Generator
) -> tuple[AnyArray, tuple[int, int]]:
    """Project the sheet's corners; return them and the picture's height and width."""
    if camera.fills:
        scale = camera.size / max(width, height)
        size = round(height * scale), round(width * scale)
        flat = np.array([[0, 0], [size[1], 0], [size[1], size[0]], [0, size[0]]], float)
        return flat, size
    size = (camera.size, round(0.75 * camera.size))
    size = size if height >= width else size[::-1]
    fit = rng.uniform(0.72, 0.86) * min(size[1] / width, size[0] / height)
    flat = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array([width, height]) * 0.5 * fit
    turn = np.radians(rng.uniform(-6.0, 6.0))
    cosine, sine = np.cos(turn), np.sin(turn)
    flat = flat @ np.array([[cosine, sine], [-sine, cosine]])
    tilt = camera.perspective * rng.uniform(-0.28, 0.28, 2)  # rad about both axes
    depth = 1.2 * camera.size
    z = flat @ np.sin(tilt)
    seen = flat * np.cos(tilt) * (depth / (depth + z))[:, None]
    middle = np.array(size[::-1]) * 0.5 + rng.uniform(-0.02, 0.02, 2) * camera.size
    return seen + middle, size


def _seen(
    shown: AnyArray, corners: AnyArray, size: tuple[int, int], rng: np.random.Generator,
    camera: Camera,
) -> AnyArray:  # fmt: skip
    height, width = shown.shape[:2]
    flat = np.array([[0, 0], [width, 0], [width, height], [0, height]], float)
    matrix = homography(corners, flat)
    y, x = np.mgrid[0 : size[0], 0 : size[1]] + 0.5
    at = map_points(matrix, np.column_stack([x.ravel(), y.ravel()]))
    inside = ((at >= 0.0) & (at <= (width, height))).all(axis=1).reshape(size)
    shrink = width / np.linalg.norm(corners[1] - corners[0])
    image = np.empty((*size, 3), np.float32)
    for k in range(3):
        plane = shown[..., k]
        if shrink > 1.2:
            plane = gaussian_filter(plane, 0.4 * np.sqrt(shrink**2 - 1.0))
        image[..., k] = map_coordinates(plane, at[:, ::-1].T - 0.5, order=1).reshape(size)
    if camera.fills:
        return image
    tables = ([0.10, 0.07, 0.05], [0.25, 0.16, 0.09], [0.12, 0.2, 0.14], [0.3, 0.3, 0.32])
    table = np.array(tables[rng.integers(len(tables))]) * rng.uniform(0.7, 1.2)
    grain = np.exp(0.15 * _noise(*size, (3, 31), rng))[..., None]
    smooth = gaussian_filter(inside.astype(np.float32), 0.7)[..., None]
    return image * smooth + table * grain * (1.0 - smooth)


def _light(size: tuple[int, int], camera: Camera, rng: np.random.Generator) -> AnyArray:
    y, x = np.mgrid[0 : size[0], 0 : size[1]].astype(np.float32)
    x, y = x / max(size), y / max(size)
    lamp = rng.uniform(0.0, 0.9, 2)
    fall = np.exp(-((x - lamp[0]) ** 2 + (y - lamp[1]) ** 2) / rng.uniform(0.5, 1.5))
    light = 1.0 + camera.light * rng.uniform(0.5, 1.6) * fall
    way = rng.uniform(0.0, 2.0 * np.pi)
    across = x * np.cos(way) + y * np.sin(way)
    at = float(np.quantile(across, rng.uniform(0.6, 0.9)))
    soft = rng.uniform(0.008, 0.05)
    light *= 1.0 - camera.shadow * rng.uniform(0.15, 0.5) / (1.0 + np.exp((at - across) / soft))
    off = (x - x.mean()) ** 2 + (y - y.mean()) ** 2
    return light * (1.0 - camera.vignette * rng.uniform(0.0, 0.6) * off)


# -- what was found -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Judged:
    """Agreement of what was found on a photograph with the truth."""

    corners: float  # the worst, shares of a mean side
    ink_iou: float
    body_iou: float
    seal: float  # share of bare seals that was taken for ink
    dryness_r: float
    dryness_error: float


def judge(there: Photographed, sheet: CopiedSheet) -> Judged:
    """Compare a sheet that was found with the true one, carried onto its raster."""
    ink, body, red = carried(there, sheet)
    side = np.linalg.norm(there.corners - np.roll(there.corners, -1, axis=0), axis=1).mean()
    off = np.linalg.norm(sheet.corners - there.corners, axis=1).max()
    bare_seal = (red > 0.5) & (ink < 0.1)
    true, found = _dryness(sheet, ink, body > 0.5)
    spread = min(np.ptp(true), np.ptp(found)) if len(true) > 2 else 0.0
    return Judged(
        float(off / side),
        _iou(sheet.ink.mask, ink > 0.5),
        _iou(sheet.ink.body, body > 0.5),
        float((sheet.ink.mask & bare_seal).sum() / max(bare_seal.sum(), 1)),
        float(np.corrcoef(true, found)[0, 1]) if spread > 0.1 else float("nan"),
        float(np.abs(true - found).mean()) if len(true) else 0.0,
    )


def carried(there: Photographed, sheet: CopiedSheet) -> tuple[AnyArray, AnyArray, AnyArray]:
    """True ink, bodies and seals on the raster of the sheet that was found."""
    size = sheet.ink.mask.shape
    height, width = there.sheet.ink.shape
    flat = np.array([[0, 0], [size[1], 0], [size[1], size[0]], [0, size[0]]], float)
    true = np.array([[0, 0], [width, 0], [width, height], [0, height]], float)
    matrix = homography(there.corners, true) @ homography(flat, sheet.corners)
    y, x = np.mgrid[0 : size[0], 0 : size[1]] + 0.5
    at = map_points(matrix, np.column_stack([x.ravel(), y.ravel()]))[:, ::-1].T - 0.5
    planes = (there.sheet.ink, there.sheet.body, there.sheet.red)
    seen = [map_coordinates(p.astype(np.float32), at, order=1).reshape(size) for p in planes]
    return seen[0], seen[1], seen[2]


def strengths_of(there: Photographed, sheet: CopiedSheet) -> tuple[AnyArray, AnyArray]:
    """True and found strength of the ink of every stroke that was found."""
    height, width = there.sheet.ink.shape
    per_pixel = there.sheet.strength
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], float)
    size = sheet.ink.mask.shape
    flat = np.array([[0, 0], [size[1], 0], [size[1], size[0]], [0, size[0]]], float)
    matrix = homography(there.corners, corners) @ homography(flat, sheet.corners)
    true, found = [], []
    for piece in sheet.page.pieces:
        for stroke in piece.glyph.strokes:
            seen = on_sheet(stroke, sheet.per_unit, sheet.origin)
            rows, columns = np.nonzero(_filled(seen.outline, size) & sheet.ink.body)
            at = map_points(matrix, np.column_stack([columns, rows]) + 0.5).astype(int)
            at = np.clip(at, 0, (width - 1, height - 1))
            inside = there.sheet.body[at[:, 1], at[:, 0]]
            if inside.sum() > 15:
                true.append(float(np.median(per_pixel[at[inside, 1], at[inside, 0]])))
                found.append(stroke.strength)
    return np.array(true), np.array(found)


def _iou(one: AnyArray, other: AnyArray) -> float:
    return float((one & other).sum() / max((one | other).sum(), 1))


def _dryness(sheet: CopiedSheet, ink: AnyArray, body: AnyArray) -> tuple[AnyArray, AnyArray]:
    """True and found shares that are bare, at the stations of the strokes that were found."""
    from scipy.spatial import cKDTree

    true, found = [], []
    for piece in sheet.page.pieces:
        for stroke in piece.glyph.strokes:
            seen = on_sheet(stroke, sheet.per_unit, sheet.origin)
            region = _filled(seen.outline, body.shape) & body
            for hole in seen.holes:
                region &= ~_filled(hole, body.shape)
            rows, columns = np.nonzero(region)
            n = len(stroke.dryness)
            steps = np.linalg.norm(np.diff(seen.median, axis=0), axis=1)
            way = np.concatenate([[0.0], np.cumsum(steps)])
            at = (np.arange(n) + 0.5) / n * way[-1]
            stations = np.column_stack([np.interp(at, way, seen.median[:, k]) for k in (0, 1)])
            _, near = cKDTree(stations).query(np.column_stack([columns, rows]) + 0.5)
            counts = np.bincount(near, minlength=n)
            bare = np.bincount(near, ink[rows, columns] <= 0.5, minlength=n) / np.maximum(counts, 1)
            known = counts > 15
            true += bare[known].tolist()
            found += np.array(stroke.dryness)[known].tolist()
    return np.array(true), np.array(found)


def hairs_below_a_stroke(folder: Path) -> Path:
    """A scan of two strokes, the upper one with hairs of a pixel below it that no stroke covers."""
    pixels = np.full((300, 300, 3), 235, np.uint8)
    for top in (40, 180):  # a bar that turns down: no sheet of paper is taken for it
        pixels[top : top + 20, 50:250] = pixels[top : top + 80, 230:250] = 20
    for start in range(60, 210, 30):
        for k in range(58):
            pixels[60 + k, start + k // 3] = 20
    file = folder / "hairs.png"
    Image.fromarray(pixels).save(file)
    return file
