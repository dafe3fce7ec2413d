"""Live previews: what a brush does, painted by the engine itself on a small sheet."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.spec import BrushSpec
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import Pigment, load_pigment
from paint3d.core.types import AnyArray
from paint3d.device.sample import DeviceSample
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["ink_swatch", "sorted_parts", "stroke_preview"]

Ink = str | Pigment

_COLUMNS, _ROWS = 264, 84
_SHEET_LENGTHS = 4.4  # tuft lengths across the sheet
_SAMPLES = 90
_PRESS = np.array([0.0, 0.62, 0.40, 0.36, 0.50, 0.78, 0.68, 0.34, 0.08, 0.0])
_NO_TURN = np.array([1.0, 0.0, 0.0, 0.0])


def stroke_preview(brush: BrushSpec, ink: Ink | Mapping[Ink, float]) -> NDArray[np.uint8]:
    """(H, W, 3) uint8: one stroke from left to right, pressed twice and lifted slowly.

    Cost: 0.1 s the first time; kept for the last brushes and inks.

    Parameters
    ----------
    brush : BrushSpec
    ink : str, Pigment, or mapping of these to parts
        By name from the palette, or an ink itself, as one that was picked up from the object.
    """
    return _stroke(brush, sorted_parts(ink))


def sorted_parts(ink: Ink | Mapping[Ink, float]) -> tuple[tuple[Ink, float], ...]:
    """Inks and their parts in an order that depends on the names alone."""
    parts = ink if isinstance(ink, Mapping) else {ink: 1.0}
    return tuple(sorted(parts.items(), key=lambda part: _name(part[0])))


def _name(ink: Ink) -> str:
    return ink if isinstance(ink, str) else ink.name


@lru_cache(maxsize=128)
def _stroke(brush: BrushSpec, parts: tuple[tuple[Ink, float], ...]) -> AnyArray:
    width = _SHEET_LENGTHS * brush.length_mm
    surface = PaintedSurface(_sheet(width), None, load_material("xuan"))
    painter = Painter(surface, brush, dict(parts), azimuth="dragged")
    painter.advance(_samples(brush, width))
    painter.finish()
    order = np.argsort(surface.paint_mesh.source_vertices[: _ROWS * _COLUMNS])
    pixels = surface.srgb[order].reshape(_ROWS, _COLUMNS, 3)[::-1].copy()
    pixels.setflags(write=False)
    return pixels


def _sheet(width: float) -> TriangleMesh:
    step = width / (_COLUMNS - 1)
    y, x = np.mgrid[:_ROWS, :_COLUMNS]
    centred = np.stack([x - (_COLUMNS - 1) / 2, y - (_ROWS - 1) / 2, np.zeros_like(x)], axis=-1)
    number = np.arange(_ROWS * _COLUMNS).reshape(_ROWS, _COLUMNS)
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


@lru_cache(maxsize=512)
def ink_swatch(parts: tuple[tuple[Ink, float], ...], n: int = 24) -> NDArray[np.uint8]:
    """(n, 3) uint8: a mixture on paper, from a thin wash to as dark as it gets."""
    from paint3d.colour.vertex_colours import ColourModel

    pigments = [load_pigment(ink) if isinstance(ink, str) else ink for ink, _ in parts]
    shares = np.array([share for _, share in parts], np.float64)
    coats = np.geomspace(0.03, 2.0, n)
    amounts = (coats[:, None] * (shares / shares.sum())).astype(np.float32)
    model = ColourModel(pigments, load_material("xuan").reflectance)
    out = np.empty((n, 3), np.uint8)
    return model.srgb(np.ascontiguousarray(amounts), np.ones(n, np.float32), out)
