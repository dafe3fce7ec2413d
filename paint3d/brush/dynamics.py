"""Curves that let the hand drive a brush's settings; see `paint3d.brush_engine.stroke_loop`."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np

from paint3d.brush_engine.tuft import MOST_POINTS, Curves, no_curves
from paint3d.core.arrays import as_number
from paint3d.errors import BrushError

__all__ = ["INPUTS", "SETTINGS", "InputCurves", "build_curves", "check_curves"]

SETTINGS = ("stiffness", "spread", "load", "wetness")
INPUTS = ("pressure", "tilt", "speed", "ink_left", "curvature")
_FACTORS = (0.05, 20.0)

Points = tuple[tuple[float, float], ...]
InputCurves = tuple[tuple[str, tuple[tuple[str, Points], ...]], ...]
"""By setting and input, the points (input, factor) of a curve; hashable."""


def check_curves(
    curves: Mapping[str, Mapping[str, object]] | InputCurves, brush: str
) -> InputCurves:
    """Curves as a preset has them (setting: {input: [[x, factor], ...]}), checked.

    Raises
    ------
    BrushError
        Naming the brush, the curve, what was got and what was expected.
    """
    what = f"brush {brush!r}: inputs"
    found = []
    for setting, by_input in _items(curves, what):
        if setting not in SETTINGS:
            raise BrushError(f"{what} drive {setting!r:.40}; expected {', '.join(SETTINGS)}")
        lines = []
        for name, points in _items(by_input, f"{what} of {setting}"):
            if name not in INPUTS:
                raise BrushError(f"{what}: {name!r:.40}; expected one of {', '.join(INPUTS)}")
            lines.append((name, _points(points, f"{what}: {setting} by {name}")))
        found.append((setting, tuple(lines)))
    return tuple(found)


def _items(value: Any, what: str) -> list[tuple[str, Any]]:
    try:
        pairs: list[tuple[str, Any]] = list(value.items() if isinstance(value, Mapping) else value)
        names = [name for name, _ in pairs]
    except (TypeError, ValueError):
        raise BrushError(f"{what} is {value!r:.60}; expected names with curves") from None
    if len(set(map(str, names))) < len(names):
        raise BrushError(f"{what} names something twice")
    return pairs


def _points(points: Any, what: str) -> Points:
    try:
        pairs = [(x, y) for x, y in points]
    except (TypeError, ValueError):
        raise BrushError(f"{what} is {points!r:.60}; expected points [input, factor]") from None
    if not 1 <= len(pairs) <= MOST_POINTS:
        raise BrushError(f"{what} has {len(pairs)} points; expected 1 to {MOST_POINTS}")
    xs = [as_number(x, f"{what}: an input", error=BrushError) for x, _ in pairs]
    ys = [as_number(y, f"{what}: a factor", *_FACTORS, BrushError) for _, y in pairs]
    if any(b <= a for a, b in itertools.pairwise(xs)):
        raise BrushError(f"{what} has inputs {xs}; expected them to rise")
    return tuple(zip(xs, ys, strict=True))


def build_curves(curves: InputCurves) -> Curves:
    """Checked curves, ready for kernels."""
    built = no_curves()
    for setting, by_input in curves:
        row = SETTINGS.index(setting)
        for name, points in by_input:
            column = INPUTS.index(name)
            built.counts[row, column] = len(points)
            built.points[row, column, : len(points)] = np.array(points)
    built.any[0] = np.count_nonzero(built.counts)
    return built
