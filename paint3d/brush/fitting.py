"""Brushes fitted to what was measured on a real one: presses with their footprints, bent hairs.

*Presses* of an upright brush: how deep it was pressed, how wide and long its footprint is, and how
far behind the handle that begins. The tuft's shape and stiffness are sought within the ranges of
the papers, so that the model's footprints (Guo 2017, Eqs. 2 to 8) come closest in least squares.

*Bent hairs*: for some angles of the handle and some heights of its root, the cubic Bezier curve
that a hair lies along, as FastBrush took them from photographs.
"""

from __future__ import annotations

import csv
import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import GREATEST_FRACTION, build_tuft
from paint3d.brush.footprint import make_footprint
from paint3d.brush.spec import SHAPE_COLUMNS, BrushSpec, ShapeRows, parameter_ranges, shape_rows
from paint3d.core.arrays import AnyArray, as_number
from paint3d.errors import BrushError, InputError

__all__ = [
    "POINT_COLUMNS", "PRESS_COLUMNS", "fit_presses", "is_table_of_shapes", "predict_presses",
    "press_errors", "read_presses", "read_shapes",
]  # fmt: skip

PRESS_COLUMNS = ("depth_mm", "width_mm", "offset_mm", "drag_mm")
"""Columns of a table of presses, mm: of the root below where the tip touched first, of the widest
place, of the footprint's beginning behind the handle, and from there to its end."""

POINT_COLUMNS = ("angle", "x0", "z0", "x1", "z1", "x2", "z2", "x3", "z3")
"""Columns of a table of curves: the handle's angle from the upright (degrees), and the points of
the curve from the root to the tip, mm, z over the paper; `spread` (degrees) may be there, too."""

_SOUGHT = ("root_diameter_mm", "taper", "full_press_mm", "point_mm")
_EXPONENTS = (2.5, 3.0, 3.5, 4.0, 4.5, 5.0)
_STEP = 5e-3  # of a parameter, over which the model's slope is taken
_MOST_TRIES = 25
_MOST_BYTES = 1 << 20
_MOST_MM = 1000.0  # of a reading


def _text(path: Path) -> str:
    try:
        with path.open("rb") as stream:
            data = stream.read(_MOST_BYTES + 1)
        if len(data) > _MOST_BYTES:
            raise InputError(f"{path}: is over 1 MiB; expected a table of measurements")
        return data.decode("utf-8-sig")
    except OSError as cause:
        raise InputError(f"{path}: {cause.strerror or cause}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: is no text in UTF-8; expected a table in .csv") from None


def _rows(path: Path, *wanted: Sequence[str]) -> list[tuple[int, dict[str, float]]]:
    """Line and numbers of every row of a table that has all columns of one of those wanted."""
    lines = ["" if line.startswith("#") else line for line in _text(path).splitlines()]
    first = next((k for k, line in enumerate(lines) if line.strip()), 0)
    reader = csv.DictReader(lines[first:])
    try:
        names = [name.strip() for name in reader.fieldnames or ()]
        reader.fieldnames = names
        columns = next((c for c in wanted if set(c) <= set(names)), None)
        if columns is None:
            told = ", or ".join(", ".join(c) for c in wanted)
            got = ", ".join(names)[:200] or "none"
            raise InputError(f"{path}: has the columns {got}; expected {told}")
        rows = []
        for row in reader:
            line = first + reader.line_num
            rows.append((line, _numbers(row, columns, f"{path}:{line}")))
    except csv.Error as cause:
        raise InputError(f"{path}: cannot be read as a table: {cause}") from None
    if not rows:
        raise InputError(f"{path}: has no rows; expected measurements")
    return rows


def _numbers(row: Mapping[str, Any], columns: Sequence[str], where: str) -> dict[str, float]:
    found = {}
    for name, text in row.items():
        if name not in columns and (name != "spread" or not text):
            continue
        try:
            found[name] = float(text)
        except (TypeError, ValueError):
            found[name] = math.nan
        if not math.isfinite(found[name]):
            raise InputError(f"{where}: {name} is {text!r:.40}; expected a number")
    return found


# -- presses ------------------------------------------------------------------------------------


def read_presses(path: str | Path) -> NDArray[np.float64]:
    """Readings (N, 4) of a table, mm: depth, width, heel offset and length, by depth.

    Readings of one depth are averaged: they scatter by more than the model is wrong.

    Raises
    ------
    InputError
        If there is no such table, or it lacks a column, or a cell holds no number, or one that no
        footprint has.
    """
    rows = _rows(Path(path), PRESS_COLUMNS)
    for line, row in rows:
        for column in PRESS_COLUMNS:
            least = -_MOST_MM if column == "offset_mm" else 0.0
            as_number(row[column], f"{path}:{line}: {column}", least, _MOST_MM)
    readings = np.array([[row[column] for column in PRESS_COLUMNS] for _, row in rows])
    depths = np.unique(readings[:, 0])
    return np.array([readings[readings[:, 0] == depth].mean(axis=0) for depth in depths])


def predict_presses(brush: BrushSpec, depths: AnyArray) -> NDArray[np.float64]:
    """Width, heel offset and length (N, 3), mm, of a brush held upright, at depths (N,), mm.

    Raises
    ------
    BrushError
        If a depth is out of the brush's reach.
    """
    tuft = build_tuft(brush)
    sizes = np.zeros((len(depths), 3))
    for size, depth in zip(sizes, depths, strict=True):
        footprint = make_footprint(tuft, float(depth), 0.5 * math.pi)
        if not footprint.is_empty:
            size[:] = footprint.width, footprint.reach[-1], footprint.length
    return sizes


def press_errors(brush: BrushSpec, presses: AnyArray) -> tuple[float, float, float]:
    """RMS over the depths, mm, of width, heel offset and length against readings (N, 4)."""
    errors = predict_presses(brush, presses[:, 0]) - presses[:, 1:]
    width, offset, length = np.sqrt((errors**2).mean(axis=0))
    return float(width), float(offset), float(length)


def fit_presses(
    presses: AnyArray,
    base: BrushSpec,
    name: str,
    progress: Callable[[float], None] | None = None,
    exponents: Sequence[float] = _EXPONENTS,
) -> BrushSpec:
    """The brush whose footprints come closest to readings, in least squares; some seconds.

    Sought are root diameter, taper, full press and point, for each exponent of stiffness; all else,
    the length among it, is that of the base.

    Parameters
    ----------
    presses : (N, 4)
        As `read_presses` gives them.
    base : BrushSpec
    name : str
        What it is called.
    progress : callable, optional
        Called with the share done.
    exponents : sequence of float
        Of stiffness, to be tried beside that of the base.

    Raises
    ------
    InputError
        For fewer than three depths, or one below 0 or beyond .62 of the length.
    """
    depths, deepest = presses[:, 0], GREATEST_FRACTION * base.length_mm
    if len(presses) < 3:
        raise InputError(f"there are presses of {len(presses)} depths; expected 3 or more")
    if depths.min() < 0.0 or depths.max() > deepest:
        raise InputError(
            f"depths are {depths.min():g} to {depths.max():g} mm; expected 0 to {deepest:g} "
            f"({GREATEST_FRACTION:g} of the tuft's length, {base.length_mm:g} mm)"
        )
    tried = dict.fromkeys((*map(float, exponents), float(base.stiffness_exponent)))
    found = []
    for k, exponent in enumerate(tried):
        stated = dataclasses.replace(
            base, name=name, stiffness_exponent=exponent, rated_hardness=base.hardness,
            rated_segments=base.n_segments, rated_tip_share=math.nan,
        )  # fmt: skip
        found.append(_fitted(stated, presses))
        if progress is not None:
            progress((k + 1) / len(tried))
    return min(found, key=lambda brush: float(np.square(press_errors(brush, presses)).sum()))


def _fitted(base: BrushSpec, presses: AnyArray) -> BrushSpec:
    """The base with those parameters `_SOUGHT` that come closest to readings (N, 4)."""
    from scipy.optimize import least_squares

    ranges = parameter_ranges(base.length_mm)
    low, high = np.array([ranges[name] for name in _SOUGHT]).T

    def made(values: AnyArray) -> BrushSpec:
        numbers = zip(_SOUGHT, np.clip(values * high, low, high), strict=True)
        changed: dict[str, Any] = {key: float(f"{number:.4g}") for key, number in numbers}
        return dataclasses.replace(base, **changed)

    def off(values: AnyArray) -> AnyArray:
        residuals: AnyArray = predict_presses(made(values), presses[:, 0]) - presses[:, 1:]
        return residuals.ravel()

    start = np.array([getattr(base, name) for name in _SOUGHT]) / high
    inside = np.clip(start, low / high + 1e-6, 1.0 - 1e-6)
    limits = (low / high, np.ones(len(high)))
    best = least_squares(off, inside, bounds=limits, diff_step=_STEP, max_nfev=_MOST_TRIES)
    return made(best.x)


# -- bent hairs ---------------------------------------------------------------------------------


def is_table_of_shapes(path: str | Path) -> bool:
    """Whether a table holds bent hairs, and no presses: what the first line with words names."""
    try:
        with Path(path).open(encoding="utf-8-sig", errors="replace") as stream:
            lines = stream.read(1 << 12).splitlines()
            head = next((line for line in lines if line[:1] != "#" and line.strip()), "")
            names = {name.strip(' "') for name in head.split(",")}
    except OSError:
        return False
    return "angle" in names


def read_shapes(path: str | Path, length_mm: float) -> ShapeRows:
    """Bent shapes of one's own brush from a table, for `BristleSpec.table`.

    Parameters
    ----------
    path : path-like
        With the columns `SHAPE_COLUMNS`, or `POINT_COLUMNS` in mm.
    length_mm : float
        Of the tuft, for points.

    Raises
    ------
    InputError
        If there is no such table, or it lacks a column, or a cell holds no number.
    BrushError
        If a row describes no bent hair.
    """
    path = Path(path)
    rows = _rows(path, SHAPE_COLUMNS, POINT_COLUMNS)
    if "upper" in rows[0][1]:
        shapes = [tuple(row[column] for column in SHAPE_COLUMNS) for _, row in rows]
    else:
        shapes = [_shape_of(row, length_mm, f"{path}:{line}") for line, row in rows]
    try:
        return shape_rows(shapes)
    except BrushError as cause:
        raise BrushError(f"{path}: {cause}") from None


def _shape_of(row: Mapping[str, float], length: float, where: str) -> tuple[float, ...]:
    """`SHAPE_COLUMNS` of the points of a curve, which need not lie as the model has them.

    The model's curve leaves the root along the handle and ends along the paper: of the points
    between the ends, the distances from these are taken.
    """
    angle = row["angle"]
    if not 0.0 <= angle <= 60.0:
        raise InputError(f"{where}: angle is {angle:g}; expected 0 to 60 degrees from the upright")
    tilt = math.radians(90.0 - angle)
    x, z = (np.array([row[f"{axis}{k}"] for k in range(4)]) / length for axis in "xz")
    way = 1.0 if x[3] >= x[0] else -1.0  # a photograph may be taken from either side
    height = float(z[0] - z[3])
    if not 0.0 < height <= 1.001 * math.sin(tilt):
        raise InputError(
            f"{where}: the root is {length * height:.4g} mm over the tip; expected above 0, to "
            f"{length * math.sin(tilt):.4g}, as high as {length:g} mm of hair stand at this angle"
        )
    offset = way * float(x[3] - x[0]) - height / math.tan(tilt)
    upper, lower = math.hypot(x[1] - x[0], z[1] - z[0]), math.hypot(x[3] - x[2], z[3] - z[2])
    share = min(height / math.sin(tilt), 1.0)
    return (angle, share, offset, 0.0, upper, lower, row.get("spread", 0.0))
