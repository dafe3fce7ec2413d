"""Single hairs of a brush: their positions, lengths and tables of bent shapes, for the kernels."""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import LOWEST_TILT, BendingTable, bending_table
from paint3d.brush.spec import DEEPEST_PRESS, BristleSpec, BrushSpec, ShapeRows
from paint3d.brush_engine.bristles.bend import ARCS, BLOCK, SAMPLES, Bristles
from paint3d.core.arrays import AnyArray, zeros_on_lines

__all__ = ["MEASURED", "build_bristles", "energy_shapes", "hair_places", "measured_shapes"]

# ---- Bent shapes ---------------------------------------------------------------------------------
# Two tables of bent hairs. Both hold, for 25 tilts from 30 to 90 degrees and 129 descents (even in
# the square root, 0 to 62 % of the upright height), the points of a hair of length 1 at the fixed
# arc lengths `ARCS` from the tip: x from the root's foot along the bend, z over the plane, and the
# angle to the plane.
#
# *energy*: the least-energy shapes of the brush (`brush.bending`).
#
# *measured*: twelve shapes of a real brush, published in the FastBrush thesis, as cubic Bezier
# curves from the root along the handle to the tip along the paper; or shapes of the user's brush,
# measured in the same way. Four faults of FastBrush's program are corrected:
# - Shapes are interpolated between the measured handle angles (0 and 45 degrees in the thesis) and
#   between heights; beyond the last angle, its shapes hold.
# - Heights count from where the straight hair first touches.
# - The tip's offset counts from where the handle's axis meets the paper, at every angle, so that
#   nothing jumps as the handle leaves the upright.
# - A curve longer than the hair is cut to the hair's length; a shorter one is extended along the
#   paper.

MEASURED: ShapeRows = (
    (0.0, 1.00, 0.0, 0.0, 1.0, 0.0, 0.0),
    (0.0, 0.96, 0.12, 0.06, 0.98, 0.10, 0.0),
    (0.0, 0.83, 0.32, 0.10, 0.60, 0.42, 0.0),
    (0.0, 0.56, 0.62, 0.20, 0.41, 0.71, 10.0),
    (0.0, 0.42, 0.78, 0.26, 0.38, 0.68, 15.0),
    (0.0, 0.29, 0.93, 0.45, 0.30, 0.54, 22.0),
    (45.0, 1.00, 0.0, 0.0, 1.0, 0.0, 0.0),
    (45.0, 0.97, 0.03, 0.0, 1.0, 0.0, 0.0),
    (45.0, 0.85, 0.012, 0.01, 0.94, 0.0, 0.0),
    (45.0, 0.68, 0.26, 0.01, 0.80, 0.0, 0.0),
    (45.0, 0.54, 0.38, 0.01, 0.64, 0.0, 5.0),
    (45.0, 0.24, 0.52, 0.01, 0.26, 0.0, 15.0),
)
"""The shapes of FastBrush (KTH thesis), in rows of `brush.spec.SHAPE_COLUMNS`."""

_FINE = 400  # points of a Bezier curve that is resampled by arc length


def energy_shapes(table: BendingTable) -> tuple[AnyArray, AnyArray]:
    """Shapes (T, D, 3 SAMPLES) and spreads (T, D, 2), float32, of a bending table.

    The spreads, half a fan's angle (rad) and the imprint's length, are 0: how a tuft spreads is the
    brush's own law (Guo 2017, Eq. 2).
    """
    joints = table.arcs
    below = np.clip(np.searchsorted(joints, ARCS, side="right") - 1, 0, len(joints) - 2)
    t = (ARCS - joints[below]) / np.diff(joints)[below]
    shapes = [(1.0 - t) * values[..., below] + t * values[..., below + 1] for values in table.spine]
    spreads = np.zeros((*table.angles.shape[:2], 2), np.float32)
    return np.ascontiguousarray(np.concatenate(shapes, axis=-1), np.float32), spreads


def measured_shapes(
    tilts: NDArray[np.float64], fractions: NDArray[np.float64], rows: ShapeRows = MEASURED
) -> tuple[AnyArray, AnyArray]:
    """Shapes (T, D, 3 SAMPLES) and spreads (T, D, 2), float32, of a measured brush.

    A spread is half the fan's angle, rad, and the length of the imprint, lengths of a hair.

    Parameters
    ----------
    tilts : (T,) float64
        Handle to plane, rad.
    fractions : (D,) float64
        Descent over the straight hair's height.
    rows : tuple of tuples of float
        Measured shapes, as from `brush.spec.shape_rows`. They are interpolated between angles and
        between heights, and held beyond the first and the last.
    """
    shapes = np.empty((len(tilts), len(fractions), 3 * SAMPLES), np.float32)
    spreads = np.empty((len(tilts), len(fractions), 2), np.float32)
    angles = sorted({row[0] for row in rows})
    for i, tilt in enumerate(tilts):
        angle = min(max(90.0 - math.degrees(tilt), angles[0]), angles[-1])
        after = next(a for a in angles if a >= angle)
        before = max(a for a in angles if a <= angle)
        lean = (angle - before) / (after - before) if after > before else 0.0
        for k, fraction in enumerate(fractions):
            upright, leaning = (_measured_at(rows, a, 1.0 - fraction) for a in (before, after))
            offset, imprint, upper, lower, fan = (1.0 - lean) * upright + lean * leaning
            height = math.sin(tilt) * (1.0 - fraction)
            shapes[i, k] = _bezier_hair(tilt, height, offset, upper, lower)
            spreads[i, k] = math.radians(0.5 * fan), imprint
    return shapes, spreads


def _measured_at(rows: ShapeRows, angle: float, height: float) -> AnyArray:
    """Interpolate offset, imprint, upper, lower and spread (5,) at a height, for one angle."""
    known = np.array([row[1:] for row in rows if row[0] == angle])[::-1]  # heights rise
    return np.array([np.interp(height, known[:, 0], known[:, c]) for c in range(1, 6)])


def _bezier_hair(tilt: float, height: float, offset: float, upper: float, lower: float) -> AnyArray:
    """Sample x, z and angle (3 SAMPLES,) at `ARCS` of a hair of length 1 along a Bezier curve.

    It never goes below the paper.
    """
    tip = height / math.tan(tilt) + offset
    corners = np.array(
        [
            [0.0, height],
            [upper * math.cos(tilt), height - upper * math.sin(tilt)],
            [tip - lower, 0.0],
            [tip, 0.0],
        ]
    )
    t = np.linspace(0.0, 1.0, _FINE)[:, None]
    weights = ((1.0 - t) ** 3, 3.0 * t * (1.0 - t) ** 2, 3.0 * t**2 * (1.0 - t), t**3)
    points = sum(w * corner for w, corner in zip(weights, corners, strict=True))
    points[:, 1] = np.maximum(points[:, 1], 0.0)
    beyond_tip = points[-1] + np.array([2.0, 0.0])  # extends a curve shorter than the hair
    points = np.vstack([points, beyond_tip])
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    fine = np.linspace(0.0, 1.0, _FINE)  # from the root
    x, z = np.interp(fine, arc, points[:, 0]), np.interp(fine, arc, points[:, 1])
    angle = np.arctan2(-np.gradient(z, fine), np.gradient(x, fine))
    from_root = 1.0 - ARCS
    return np.concatenate([np.interp(from_root, fine, values) for values in (x, z, angle)])


# ---- The tuft ------------------------------------------------------------------------------------

_ROOT = math.sqrt(2.0) - 1.0  # step of the lengths' sequence: uncorrelated with the golden spiral
_GOLDEN = math.pi * (3.0 - math.sqrt(5.0))
_BUNDLED = 1.3  # width of a bundle over the spacing of its hairs
_CELLS = 512  # cells across the tuft in which clump and appetite are tabulated
_CLUMPS = (9, 31, 3)  # across the tuft: when it parts, when it falls apart, when it splits


def hair_places(n: int) -> AnyArray:
    """Positions (2, n) float32 of hairs in a disc of radius 1, evenly over its area.

    A golden-angle spiral whose radius grows as the square root of the number, so that the density
    is uniform (Vogel's sunflower). A single hair stands in the middle.
    """
    if n == 1:
        return np.zeros((2, 1), np.float32)
    number = np.arange(n)
    radius = np.sqrt((number + 0.5) / n)
    turn = _GOLDEN * number
    return np.stack([radius * np.cos(turn), radius * np.sin(turn)]).astype(np.float32)


@functools.lru_cache(maxsize=32)
def build_bristles(spec: BrushSpec, hairs: BristleSpec) -> Bristles:
    """Build the hairs of a brush; results are cached.

    Raises
    ------
    BrushError
        If the bending of this brush cannot be solved.
    """
    table = bending_table(float(spec.stiffness_exponent), spec.segmentation)
    if hairs.table == "energy":
        shapes, spreads = energy_shapes(table)
    else:
        rows = MEASURED if isinstance(hairs.table, str) else hairs.table
        shapes, spreads = measured_shapes(table.tilts, table.fractions, rows)
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
        fans=spreads,
        clumps=np.stack([_clump_middles(count) for count in _CLUMPS]),
        appetite=(1.0 + hairs.appetite * noise / np.abs(noise).max()).astype(np.float32),
        retention=(np.argsort(np.argsort(noise)) / (_CELLS - 1.0)).astype(np.float32),
        shortest=float(lengths.min()),
        lowest_tilt=LOWEST_TILT,
        greatest_fraction=DEEPEST_PRESS,
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
    """Segment lengths of straight hairs, tip first, as `Bristles.rests`."""
    arcs = ARCS * spec.length_mm
    along, out = np.diff(arcs), np.diff(0.5 * spec.diameters(arcs))
    off = np.sum(places.astype(np.float64) ** 2, axis=0)[:, None, :]
    rests = np.sqrt(along[:, None] ** 2 + off * out[:, None] ** 2) * lengths[:, None, :]
    on_lines = zeros_on_lines(rests.shape, np.float32)
    on_lines[:] = rests
    return on_lines


def _scatter(n: int, seed: float = 0.5, step: float = 0.6180339887498949) -> AnyArray:
    """Low-discrepancy sequence (n,) in [0, 1): multiples of the golden ratio, or of `step`."""
    return np.mod(seed + np.arange(n) * step, 1.0) if n > 1 else np.zeros(n)


def _clump_middles(count: int) -> AnyArray:
    """Middle of the clump at each of `_CELLS` cells of [-1, 1]; clumps differ in width."""
    widths = 1.0 + 0.9 * (_scatter(count, 0.3) - 0.5)
    edges = np.concatenate([[0.0], np.cumsum(widths)]) / widths.sum() * 2.0 - 1.0
    cells = (np.arange(_CELLS) + 0.5) / _CELLS * 2.0 - 1.0
    at = np.clip(np.searchsorted(edges, cells) - 1, 0, count - 1)
    result: AnyArray = (0.5 * (edges[at] + edges[at + 1])).astype(np.float32)
    return result


def _noise() -> AnyArray:
    """Value noise of three scales over the `_CELLS` cells, mean 0."""
    cells = (np.arange(_CELLS) + 0.5) / _CELLS
    noise = np.zeros(_CELLS)
    for count, weight, seed in ((7, 0.45, 0.11), (19, 0.45, 0.47), (47, 0.25, 0.83)):
        values = 2.0 * _scatter(count + 1, seed) - 1.0
        noise += weight * np.interp(cells * count, np.arange(count + 1), values)
    result: AnyArray = noise - noise.mean()
    return result
