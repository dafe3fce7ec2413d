"""A brush while its parameters are turned: one change at a time, each within its range."""

from __future__ import annotations

import dataclasses
from typing import Any

from paint3d.app.model.brush_size import resized, size_limits
from paint3d.brush.spec import (
    INPUTS,
    SETTINGS,
    BristleSpec,
    BrushSpec,
    hair_ranges,
    parameter_ranges,
)

__all__ = [
    "INPUT_RANGES", "Points", "changed", "points_of", "range_of", "value_of",
    "with_curve", "with_hairs",
]  # fmt: skip

INPUT_RANGES = {
    "pressure": (0.0, 1.0),
    "tilt": (30.0, 90.0),
    "speed": (0.0, 600.0),
    "ink_left": (0.0, 1.0),
    "curvature": (0.0, 0.5),
}
"""Between what a hand's inputs lie mostly: shares, degrees, mm/s, 1/mm (`brush.dynamics`)."""

Points = tuple[tuple[float, float], ...]


def _of_hairs(parameter: str) -> bool:
    return parameter in hair_ranges()


def value_of(brush: BrushSpec, parameter: str) -> float:
    """A number of a brush or of its hairs; those that a solid tuft would have, where it is one."""
    owner = (brush.bristles or BristleSpec()) if _of_hairs(parameter) else brush
    return float(getattr(owner, parameter))


def range_of(brush: BrushSpec, parameter: str) -> tuple[float, float]:
    """Least and greatest value of a number, for a tuft as long as this."""
    if _of_hairs(parameter):
        return hair_ranges()[parameter]
    if parameter == "length_mm":
        return size_limits(brush)
    return parameter_ranges(brush.length_mm)[parameter]


def changed(brush: BrushSpec, parameter: str, value: Any) -> BrushSpec:
    """The brush with another value; with another length, all that is a length goes along.

    Raises
    ------
    BrushError
        If it is out of its range.
    """
    if _of_hairs(parameter) or parameter == "table":
        hairs = dataclasses.replace(brush.bristles or BristleSpec(), **{parameter: value})
        return dataclasses.replace(brush, bristles=hairs)
    if parameter == "length_mm":
        return dataclasses.replace(resized(brush, value), name=brush.name)
    return dataclasses.replace(brush, **{parameter: value})


def with_hairs(brush: BrushSpec, hairs: BristleSpec | None) -> BrushSpec:
    """The brush with these single hairs; None: a solid tuft."""
    return dataclasses.replace(brush, bristles=hairs)


def points_of(brush: BrushSpec, setting: str, name: str) -> Points:
    """The points (input, factor) by which an input drives a setting; empty where it does not."""
    return dict(dict(brush.inputs).get(setting, ())).get(name, ())


def with_curve(brush: BrushSpec, setting: str, name: str, points: Points) -> BrushSpec:
    """The brush with another such curve; without points the input drives nothing.

    Raises
    ------
    BrushError
        If they are no curve.
    """
    curves = {s: {i: points_of(brush, s, i) for i in INPUTS} for s in SETTINGS}
    curves[setting][name] = points
    kept = {s: {i: p for i, p in by_input.items() if p} for s, by_input in curves.items()}
    inputs: Any = {s: by_input for s, by_input in kept.items() if by_input}
    return dataclasses.replace(brush, inputs=inputs)
