"""The hairs of a brush, ready for kernels."""

from __future__ import annotations

import functools
import math

import numpy as np

from paint3d.brush.bending import GREATEST_FRACTION, LOWEST_TILT, bending_table
from paint3d.brush.bristle_shapes import MEASURED, energy_shapes, measured_shapes
from paint3d.brush.bristle_spec import BristleSpec
from paint3d.brush.spec import BrushSpec
from paint3d.brush_engine.bristles.bend import ARCS, BLOCK, Bristles
from paint3d.core.arrays import zeros_on_lines
from paint3d.core.types import AnyArray

__all__ = ["build_bristles", "hair_places"]

_ROOT = math.sqrt(2.0) - 1.0  # steps of lengths: no hair is long because of where it stands
_GOLDEN = math.pi * (3.0 - math.sqrt(5.0))
_BUNDLED = 1.3  # times as broad as the room of a hair is a bundle of them
_CELLS = 512  # places across the tuft that tell clump and appetite
_CLUMPS = (9, 31, 3)  # across the tuft: when it parts, when it falls apart, when it splits


def hair_places(n: int) -> AnyArray:
    """Places (2, n) float32 of hairs in a disc of radius 1, evenly over its area.

    A spiral by the golden angle with the radius as the square root of the number: as many hairs
    to every mm2 in the middle as at the rim. A single hair stands in the middle.
    """
    if n == 1:
        return np.zeros((2, 1), np.float32)
    number = np.arange(n)
    radius = np.sqrt((number + 0.5) / n)
    turn = _GOLDEN * number
    return np.stack([radius * np.cos(turn), radius * np.sin(turn)]).astype(np.float32)


@functools.lru_cache(maxsize=32)
def build_bristles(spec: BrushSpec, hairs: BristleSpec) -> Bristles:
    """The hairs of a brush; kept in memory, so that asking again costs nothing.

    Raises
    ------
    BrushError
        If the bending of this brush cannot be solved.
    """
    table = bending_table(float(spec.stiffness_exponent), spec.chain)
    if hairs.table == "energy":
        shapes, fans = energy_shapes(table)
    else:
        rows = MEASURED if isinstance(hairs.table, str) else hairs.table
        shapes, fans = measured_shapes(table.tilts, table.fractions, rows)
    n, noise = hairs.n_hairs, _noise()
    radius = 0.5 * hairs.hair_mm
    padded = np.minimum(np.arange(-(-n // BLOCK) * BLOCK), n - 1).reshape(-1, BLOCK)
    lengths = (1.0 - hairs.unevenness * _scatter(n, step=_ROOT)).astype(np.float32)
    places = np.ascontiguousarray(hair_places(n)[:, padded])
    bristles = Bristles(
        count=n,
        places=places,
        lengths=np.ascontiguousarray(lengths[padded]),
        rests=_rest_lengths(spec, places, lengths[padded]),
        shapes=shapes,
        fans=fans,
        clumps=np.stack([_clump_middles(count) for count in _CLUMPS]),
        appetite=(1.0 + hairs.appetite * noise / np.abs(noise).max()).astype(np.float32),
        retention=(np.argsort(np.argsort(noise)) / (_CELLS - 1.0)).astype(np.float32),
        shortest=float(lengths.min()),
        lowest_tilt=LOWEST_TILT,
        greatest_fraction=GREATEST_FRACTION,
        hair_mm=radius,
        film_mm=float(hairs.film * spec.root_diameter_mm),
        threshold_mm=float(hairs.threshold_mm),
        parting=float(hairs.parting),
        splay=float(hairs.splay),
        levelling_mm=float(hairs.levelling_mm),
        root_mm=float(spec.root_diameter_mm),
        bundle_mm=_BUNDLED * math.sqrt(0.25 * math.pi / n) * spec.root_diameter_mm,
        set_mm=float(hairs.set_share * spec.length_mm),
    )
    for array in bristles[1:9]:
        array.setflags(write=False)
    return bristles


def _rest_lengths(spec: BrushSpec, places: AnyArray, lengths: AnyArray) -> AnyArray:
    """Lengths of a straight hair's pieces, tip first, as `Bristles.rests`."""
    arcs = ARCS * spec.length_mm
    along, out = np.diff(arcs), np.diff(0.5 * spec.diameters(arcs))
    off = np.sum(places.astype(np.float64) ** 2, axis=0)[:, None, :]
    rests = np.sqrt(along[:, None] ** 2 + off * out[:, None] ** 2) * lengths[:, None, :]
    on_lines = zeros_on_lines(rests.shape, np.float32)
    on_lines[:] = rests
    return on_lines


def _scatter(n: int, seed: float = 0.5, step: float = 0.6180339887498949) -> AnyArray:
    """n numbers, evenly over 0 to 1 and without order: multiples of the golden ratio, or a step."""
    return np.mod(seed + np.arange(n) * step, 1.0) if n > 1 else np.zeros(n)


def _clump_middles(count: int) -> AnyArray:
    """For `_CELLS` places in [-1, 1], the middle of the clump there; clumps differ in width."""
    widths = 1.0 + 0.9 * (_scatter(count, 0.3) - 0.5)
    edges = np.concatenate([[0.0], np.cumsum(widths)]) / widths.sum() * 2.0 - 1.0
    places = (np.arange(_CELLS) + 0.5) / _CELLS * 2.0 - 1.0
    at = np.clip(np.searchsorted(edges, places) - 1, 0, count - 1)
    result: AnyArray = (0.5 * (edges[at] + edges[at + 1])).astype(np.float32)
    return result


def _noise() -> AnyArray:
    """For `_CELLS` places, how hairs differ there: noise in three widths, mean 0."""
    places = (np.arange(_CELLS) + 0.5) / _CELLS
    noise = np.zeros(_CELLS)
    for count, weight, seed in ((7, 0.45, 0.11), (19, 0.45, 0.47), (47, 0.25, 0.83)):
        values = 2.0 * _scatter(count + 1, seed) - 1.0
        noise += weight * np.interp(places * count, np.arange(count + 1), values)
    result: AnyArray = noise - noise.mean()
    return result
