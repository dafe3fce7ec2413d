"""Pictures of a brush: the footprints of its presses, and a stroke painted by the engine itself."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import make_footprint
from paint3d.brush.spec import BrushSpec
from paint3d.brush_engine.tuft import greatest_descent
from paint3d.colour.materials import Material, load_material
from paint3d.colour.pigments import Pigment
from paint3d.core.types import AnyArray
from paint3d.device.sample import DeviceSample
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["PRESSES", "draw_brush", "draw_footprints", "draw_stroke"]

Ink = str | Pigment

PRESSES = (0.15, 0.4, 0.7, 1.0)
"""Pressures whose footprints are drawn."""

_COLUMNS, _ROWS = 264, 84
_SHEET_LENGTHS = 4.4  # tuft lengths across the sheet
_SAMPLES = 90
_PRESS = np.array([0.0, 0.62, 0.40, 0.36, 0.50, 0.78, 0.68, 0.34, 0.08, 0.0])
_NO_TURN = np.array([1.0, 0.0, 0.0, 0.0])
_PAPER, _INK = np.array([250, 248, 243]), np.array([42, 40, 44])
_FINER = 4  # pixels of a side that one of the picture is the mean of


def draw_stroke(
    brush: BrushSpec,
    ink: Ink | Mapping[Ink, float],
    material: str | Material = "xuan",
    columns: int = _COLUMNS,
) -> NDArray[np.uint8]:
    """(H, W, 3) uint8: one stroke from left to right, pressed twice and lifted slowly.

    Cost: 0.1 s at 264 columns, and the brush's table the first time.

    Parameters
    ----------
    brush : BrushSpec
    ink : str, Pigment, or mapping of these to parts
    material : str or Material
        Of the sheet, which is 4.4 tufts wide.
    columns : int
        W; H is 84 / 264 of it.

    Raises
    ------
    UnknownNameError, InputError
        For an ink or a material that is not known.
    """
    rows = round(columns * _ROWS / _COLUMNS)
    width = _SHEET_LENGTHS * brush.length_mm
    made_of = load_material(material) if isinstance(material, str) else material
    surface = PaintedSurface(_sheet(width, columns, rows), None, made_of)
    painter = Painter(surface, brush, ink, azimuth="dragged")
    painter.advance(_samples(brush, width))
    painter.finish()
    order = np.argsort(surface.paint_mesh.source_vertices[: rows * columns])
    return surface.srgb[order].reshape(rows, columns, 3)[::-1].copy()


def _sheet(width: float, columns: int, rows: int) -> TriangleMesh:
    step = width / (columns - 1)
    y, x = np.mgrid[:rows, :columns]
    centred = np.stack([x - (columns - 1) / 2, y - (rows - 1) / 2, np.zeros_like(x)], axis=-1)
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, :-1].ravel(), number[1:, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])
    return TriangleMesh((centred.reshape(-1, 3) * step).astype(np.float32), faces)


def _samples(brush: BrushSpec, width: float) -> list[DeviceSample]:
    t = np.linspace(0.0, 1.0, _SAMPLES)
    pressure = np.interp(t, np.linspace(0.0, 1.0, len(_PRESS)), _PRESS)
    pressure[[0, -1]] = 0.0
    x = width * (-0.40 + 0.80 * t)
    y = 0.055 * width * np.sin(1.9 * np.pi * t)
    samples = []
    for k in range(_SAMPLES):
        place = np.array([x[k], y[k], brush.length_mm])
        samples.append(
            DeviceSample(
                8_000_000 * (k + 1), place, _NO_TURN, float(pressure[k]), 0, np.zeros(3), _NO_TURN
            )
        )
    return samples


def draw_footprints(
    brush: BrushSpec, columns: int = 240, presses: Sequence[float] = PRESSES
) -> NDArray[np.uint8]:
    """(W, W, 3) uint8: the footprints of an upright brush, each over the larger ones.

    The tip is on the left. The picture is 1.3 tufts wide, of every brush, so that two of one length
    can be compared.

    Parameters
    ----------
    brush : BrushSpec
    columns : int
        W.
    presses : sequence of float
        Pressures, 0 to 1, that rise.
    """
    tuft = build_tuft(brush)
    n = _FINER * columns
    half = 0.65 * brush.length_mm
    place = (np.arange(n) + 0.5) / n * 2.0 * half - half
    shade = np.zeros((n, n))
    deepest = greatest_descent(tuft, 0.5 * math.pi)
    for k, pe in reversed(list(enumerate(presses))):
        descent = min(pe * tuft.full_press, deepest)
        footprint = make_footprint(tuft, descent, 0.5 * math.pi, 0.0, pe)
        if footprint.is_empty:
            continue
        reach, width = footprint.reach[::-1], footprint.half_width[::-1]
        # the picture's middle is half way between the root's foot and the deepest press's tip
        along = 0.25 * brush.length_mm - place
        across = np.interp(along, reach, width, left=-1.0, right=-1.0)
        shade[np.abs(place)[:, None] < across[None, :]] = 1.0 - 0.8 * k / len(presses)
    mean = shade.reshape(columns, _FINER, columns, _FINER).mean(axis=(1, 3))[..., None]
    return np.asarray(np.rint(_PAPER + mean * (_INK - _PAPER)), np.uint8)


def draw_brush(brush: BrushSpec, ink: Ink | Mapping[Ink, float], rows: int = 240) -> AnyArray:
    """(H, W, 3) uint8: footprints on the left, a stroke on xuan on the right."""
    stroke = draw_stroke(brush, ink, columns=round(rows * _COLUMNS / _ROWS))[:rows]
    picture: AnyArray = np.concatenate([draw_footprints(brush, len(stroke)), stroke], axis=1)
    return picture
