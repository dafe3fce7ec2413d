"""Fitting a brush to measurements of a real one.

*Presses* of an upright brush: depth, the footprint's width and length, and how far behind the
handle it begins. The tuft's shape and stiffness are fitted by least squares, within the ranges of
the papers, to the model's footprints (Guo 2017, Eqs. 2 to 8).

*Bent hairs*: the cubic Bezier curve that a hair follows, for some angles of the handle and heights
of its root, as FastBrush took them from photographs.
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

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import make_footprint
from paint3d.brush.spec import (
    DEEPEST_PRESS,
    SHAPE_COLUMNS,
    BrushSpec,
    ShapeRows,
    parameter_ranges,
    shape_rows,
)
from paint3d.core.arrays import AnyArray, as_number
from paint3d.errors import BrushError, InputError

__all__ = [
    "POINT_COLUMNS", "PRESS_COLUMNS", "fit_presses", "is_table_of_shapes", "predict_presses",
    "press_errors", "read_presses", "read_shapes",
]  # fmt: skip

PRESS_COLUMNS = ("depth_mm", "width_mm", "offset_mm", "drag_mm")
"""Columns of a table of presses, mm: descent of the root since the tip touched, greatest width of
the footprint, how far behind the handle it begins, and its length from there."""

POINT_COLUMNS = ("angle", "x0", "z0", "x1", "z1", "x2", "z2", "x3", "z3")
"""Columns of a table of curves: the handle's angle from the upright (degrees), and the control
points from the root to the tip, mm, z over the paper; `spread` (degrees) is optional."""

_FREE = ("root_diameter_mm", "taper", "full_press_mm", "point_mm")
_EXPONENTS = (2.5, 3.0, 3.5, 4.0, 4.5, 5.0)
_STEP = 5e-3  # relative step of the finite differences
_MOST_TRIES = 25
_MOST_BYTES = 1 << 20
_MOST_MM = 1000.0  # of a reading


def _read_text(path: Path) -> str:
    try:
        with path.open("rb") as stream:
            data = stream.read(_MOST_BYTES + 1)
        if len(data) > _MOST_BYTES:
            raise InputError("{file}: is over 1 MiB; expected a table of measurements", file=path)
        return data.decode("utf-8-sig")
    except OSError as cause:
        raise InputError("{file}: {cause}", file=path, cause=cause) from None
    except UnicodeDecodeError:
        raise InputError(
            "{file}: is no text in UTF-8; expected a table in .csv", file=path
        ) from None


def _rows(path: Path, *wanted: Sequence[str]) -> list[tuple[int, dict[str, float]]]:
    """Read the line and numbers of every row of a table with all columns of one `wanted` set."""
    lines = ["" if line.startswith("#") else line for line in _read_text(path).splitlines()]
    first = next((k for k, line in enumerate(lines) if line.strip()), 0)
    reader = csv.DictReader(lines[first:])
    try:
        names = [name.strip() for name in reader.fieldnames or ()]
        reader.fieldnames = names
        columns = next((c for c in wanted if set(c) <= set(names)), None)
        if columns is None:
            expected = ", or ".join(", ".join(c) for c in wanted)
            got = ", ".join(names)[:200] or "none"
            raise InputError(
                "{file}: has the columns {got}; expected {expected}",
                file=path,
                got=got,
                expected=expected,
            )
        rows = []
        for row in reader:
            line = first + reader.line_num
            rows.append((line, _numbers(row, columns, f"{path}:{line}")))
    except csv.Error as cause:
        raise InputError(
            "{file}: cannot be read as a table: {cause}", file=path, cause=cause
        ) from None
    if not rows:
        raise InputError("{file}: has no rows; expected measurements", file=path)
    return rows


def _numbers(row: Mapping[str, Any], columns: Sequence[str], where: str) -> dict[str, float]:
    numbers = {}
    for name, text in row.items():
        if name not in columns and (name != "spread" or not text):
            continue
        try:
            numbers[name] = float(text)
        except (TypeError, ValueError):
            numbers[name] = math.nan
        if not math.isfinite(numbers[name]):
            raise InputError(
                "{where}: {name} is {text!r:.40}; expected a number",
                where=where,
                name=name,
                text=text,
            )
    return numbers


# ---- Presses -------------------------------------------------------------------------------------


def read_presses(path: str | Path) -> NDArray[np.float64]:
    """Read a table of presses (N, 4), mm: depth, width, heel offset and length, by depth.

    Readings of one depth are averaged: they scatter more than the model errs.

    Raises
    ------
    InputError
        If there is no such table, it lacks a column, or a cell holds no number or one that is out
        of range.
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
    """Predict width, heel offset and length (N, 3), mm, of an upright brush at depths (N,), mm.

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
    """RMS errors over the depths, mm, of width, heel offset and length against readings (N, 4)."""
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
    """Fit a brush to readings by least squares; takes some seconds.

    Root diameter, taper, full press and point are fitted for each stiffness exponent, and the best
    brush returned; everything else, including the length, is the base's.

    Parameters
    ----------
    presses : (N, 4)
        From `read_presses`.
    base : BrushSpec
    name : str
        Name of the fitted brush.
    progress : callable, optional
        Called with the fraction done.
    exponents : sequence of float
        Stiffness exponents to try in addition to the base's.

    Raises
    ------
    InputError
        For fewer than three depths, or one below 0 or beyond .62 of the length.
    """
    depths, deepest = presses[:, 0], DEEPEST_PRESS * base.length_mm
    if len(presses) < 3:
        raise InputError("there are presses of {n} depths; expected 3 or more", n=len(presses))
    if depths.min() < 0.0 or depths.max() > deepest:
        raise InputError(
            "depths are {least:g} to {most:g} mm; expected 0 to {deepest:g} ({greatest_fraction:g} "
            "of the tuft's length, {length_mm:g} mm)",
            least=depths.min(),
            most=depths.max(),
            deepest=deepest,
            greatest_fraction=DEEPEST_PRESS,
            length_mm=base.length_mm,
        )
    tried = dict.fromkeys((*map(float, exponents), float(base.stiffness_exponent)))
    fitted = []
    for k, exponent in enumerate(tried):
        start = dataclasses.replace(
            base, name=name, stiffness_exponent=exponent, rated_hardness=base.hardness,
            rated_segments=base.n_segments, rated_tip_share=math.nan,
        )  # fmt: skip
        fitted.append(_fit(start, presses))
        if progress is not None:
            progress((k + 1) / len(tried))
    return min(fitted, key=lambda brush: float(np.square(press_errors(brush, presses)).sum()))


def _fit(base: BrushSpec, presses: AnyArray) -> BrushSpec:
    """Fit the parameters `_FREE` of a brush to readings (N, 4), starting from its own."""
    from scipy.optimize import least_squares

    ranges = parameter_ranges(base.length_mm)
    low, high = np.array([ranges[name] for name in _FREE]).T

    def brush_with(values: AnyArray) -> BrushSpec:  # each over the upper end of its range
        numbers = zip(_FREE, np.clip(values * high, low, high), strict=True)
        changed: dict[str, Any] = {key: float(f"{number:.4g}") for key, number in numbers}
        return dataclasses.replace(base, **changed)

    def residuals(values: AnyArray) -> AnyArray:
        errors: AnyArray = predict_presses(brush_with(values), presses[:, 0]) - presses[:, 1:]
        return errors.ravel()

    start = np.array([getattr(base, name) for name in _FREE]) / high
    inside = np.clip(start, low / high + 1e-6, 1.0 - 1e-6)
    limits = (low / high, np.ones(len(high)))
    best = least_squares(residuals, inside, bounds=limits, diff_step=_STEP, max_nfev=_MOST_TRIES)
    return brush_with(best.x)


# ---- Bent hairs ----------------------------------------------------------------------------------


def is_table_of_shapes(path: str | Path) -> bool:
    """Return whether a table holds bent hairs rather than presses, by its header line."""
    try:
        with Path(path).open(encoding="utf-8-sig", errors="replace") as stream:
            lines = stream.read(1 << 12).splitlines()
            head = next((line for line in lines if line[:1] != "#" and line.strip()), "")
            names = {name.strip(' "') for name in head.split(",")}
    except OSError:
        return False
    return "angle" in names


def read_shapes(path: str | Path, length_mm: float) -> ShapeRows:
    """Read measured bent shapes from a table, for `BristleSpec.table`.

    Parameters
    ----------
    path : path-like
        With the columns `SHAPE_COLUMNS`, or `POINT_COLUMNS` in mm.
    length_mm : float
        Of the tuft; used with `POINT_COLUMNS`.

    Raises
    ------
    InputError
        If there is no such table, it lacks a column, or a cell holds no number.
    BrushError
        If a row is not a bent hair.
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
        raise BrushError("{file}: {cause}", file=path, cause=cause) from None


def _shape_of(row: Mapping[str, float], length: float, where: str) -> tuple[float, ...]:
    """Convert the control points of a measured curve to `SHAPE_COLUMNS`.

    The model's curve leaves the root along the handle and ends along the paper; a measured one need
    not. So of the two inner points only their distances from the ends are used.
    """
    angle = row["angle"]
    if not 0.0 <= angle <= 60.0:
        raise InputError(
            "{where}: angle is {angle:g}; expected 0 to 60 degrees from the upright",
            where=where,
            angle=angle,
        )
    tilt = math.radians(90.0 - angle)
    x, z = (np.array([row[f"{axis}{k}"] for k in range(4)]) / length for axis in "xz")
    side = 1.0 if x[3] >= x[0] else -1.0  # a photograph may be taken from either side
    height = float(z[0] - z[3])
    if not 0.0 < height <= 1.001 * math.sin(tilt):
        raise InputError(
            "{where}: the root is {height:.4g} mm over the tip; expected above 0, to {most:.4g}, "
            "as high as {length:g} mm of hair stand at this angle",
            where=where,
            height=length * height,
            most=length * math.sin(tilt),
            length=length,
        )
    offset = side * float(x[3] - x[0]) - height / math.tan(tilt)
    upper, lower = math.hypot(x[1] - x[0], z[1] - z[0]), math.hypot(x[3] - x[2], z[3] - z[2])
    fraction = min(height / math.sin(tilt), 1.0)
    return (angle, fraction, offset, 0.0, upper, lower, row.get("spread", 0.0))
