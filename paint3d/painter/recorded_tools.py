"""Brush and ink named in the header of a version 1 recording; the end of the pen in its samples.

A recording may come from a stranger, so these names never open a file of this machine.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BrushSpec, DipAmount
from paint3d.colour.inks import load_ink
from paint3d.colour.pigments import Pigment, load_pigment
from paint3d.core.arrays import as_number
from paint3d.device.sample import ERASER
from paint3d.errors import (
    BrushError,
    InputError,
    Message,
    PigmentError,
    RecordingError,
    UnknownNameError,
)

__all__ = [
    "LEAST_INK",
    "TIP_REACH",
    "changes_at",
    "eraser_runs",
    "recorded_amount",
    "recorded_brush",
    "recorded_ink",
    "recorded_tip",
]

TIP_REACH = 0.35  # default fraction of the tuft's length that a dip of the tip reaches
LEAST_INK = 1e-4
"""Least fraction of ink in water to which a brush can be thinned."""


def recorded_brush(header: Mapping[str, Any]) -> BrushSpec | None:
    """Return the brush that a header names, or None.

    Raises
    ------
    RecordingError
        If it is unknown.
    """
    name = _name_in(header, "brush")
    if name is None:
        return None
    try:
        return load_brush(name, own_files=False)
    except (BrushError, UnknownNameError) as cause:
        raise RecordingError("the header: {cause}", cause=cause) from None


def recorded_ink(header: Mapping[str, Any]) -> dict[Pigment, float] | None:
    """Return the parts, by pigment, of the ink that a header names, or None.

    Raises
    ------
    RecordingError
        If a pigment is unknown.
    """
    parts = header.get("parts")
    try:
        if isinstance(parts, dict) and len(parts) > 1:  # "ink" names the largest only
            return {load_pigment(str(name), own_tables=False): n for name, n in parts.items()}
        name = _name_in(header, "ink")
        return None if name is None else load_ink(name, own_tables=False)
    except PigmentError as cause:
        raise RecordingError("the header: {cause}", cause=cause) from None


def recorded_tip(header: Mapping[str, Any]) -> tuple[dict[Pigment, float], float] | None:
    """Return the ink for a second dip of the tip and its reach (fraction of the tuft), or None.

    Raises
    ------
    RecordingError
        If the ink is unknown, or the reach is not between 0 and 1.
    """
    name = _name_in(header, "tip")
    if name is None:
        return None
    reach = as_number(
        header.get("reach", TIP_REACH), "the header's reach", 0.0, 1.0, RecordingError
    )
    try:
        return load_ink(name, own_tables=False), reach
    except PigmentError as cause:
        raise RecordingError("the header: {cause}", cause=cause) from None


def recorded_amount(header: Mapping[str, Any]) -> DipAmount:
    """Return the amount of ink that a recording's dips take up; by default the full load.

    Raises
    ------
    RecordingError
        If the header's "dip" is not an amount.
    """
    try:
        return DipAmount.of(header.get("dip", {}))
    except InputError as cause:
        raise RecordingError("the header: {cause}", cause=cause) from None


def changes_at(
    header: Mapping[str, Any], time_ns: NDArray[np.int64]
) -> tuple[list[tuple[int, float]], list[tuple[int, float]]]:
    """Read a header's ``loads`` and ``strengths`` as changes at samples (N,) of these times, ns.

    Returns
    -------
    loads, strengths : list of (int, float)
        A sample, and the fraction of a dip, or of ink in water, that the brush holds from there on;
        none beyond the last sample.

    Raises
    ------
    RecordingError
        If they are not pairs of a time (ns) and a fraction, in the order of time.
    """
    loads = _changes_in(header, "loads", 0.0, time_ns)
    return loads, _changes_in(header, "strengths", LEAST_INK, time_ns)


def eraser_runs(buttons: ArrayLike) -> list[tuple[int, int, bool]]:
    """Return the runs of samples (N,) in which one end of the pen is down, from their buttons.

    Returns
    -------
    list of (int, int, bool)
        The first sample, the one after the last, and whether the eraser end is down.
    """
    erases = (np.asarray(buttons) & ERASER) != 0
    if not erases.any():
        return [(0, len(erases), False)]
    edges = [0, *(np.flatnonzero(np.diff(erases)) + 1).tolist(), len(erases)]
    return [(a, b, bool(erases[a])) for a, b in pairwise(edges)]


def _changes_in(
    header: Mapping[str, Any], name: str, least: float, time_ns: NDArray[np.int64]
) -> list[tuple[int, float]]:
    """Read one list of changes, by sample; fractions are at least `least`."""
    stated = header.get(name, [])
    expected = Message(
        "pairs of a time (ns) and a fraction from {least:g} to 1, in the order of time", least=least
    )
    try:
        times = np.array([when for when, _ in stated], np.int64)
        fractions = [as_number(fraction, "fraction", least, 1.0) for _, fraction in stated]
    except (TypeError, ValueError, OverflowError, InputError):
        raise RecordingError(
            "the header's {name} are {stated!r:.60}; expected {expected}",
            name=name,
            stated=stated,
            expected=expected,
        ) from None
    whole = all(type(when) is int for when, _ in stated)  # np.array above truncates floats
    if not (whole and (times[1:] > times[:-1]).all()):
        raise RecordingError(
            "the header's {name} are {stated!r:.60}; expected {expected}",
            name=name,
            stated=stated,
            expected=expected,
        )
    at = np.searchsorted(time_ns, times)
    return [(int(k), x) for k, x in zip(at, fractions, strict=True) if k < len(time_ns)]


def _name_in(header: Mapping[str, Any], key: str) -> str | None:
    """Return the name at a key, or None; RecordingError if it is no text."""
    name = header.get(key)
    if name is not None and not isinstance(name, str):
        raise RecordingError(
            "the header's {key} is {name!r:.60}; expected a name",
            key=key,
            name=name,
        )
    return name
