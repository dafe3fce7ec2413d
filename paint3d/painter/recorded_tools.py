"""What a recording of version 1 says of brush and ink: in its header, of no file of a machine."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.dip_amount import DipAmount
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BrushSpec
from paint3d.colour.inks import load_ink
from paint3d.colour.pigment import Pigment
from paint3d.colour.pigments import load_pigment
from paint3d.core.arrays import as_number
from paint3d.errors import BrushError, InputError, PigmentError, RecordingError, UnknownNameError

__all__ = [
    "TIP_REACH",
    "loads_at",
    "recorded_amount",
    "recorded_brush",
    "recorded_ink",
    "recorded_loads",
    "recorded_strengths",
    "recorded_tip",
]

TIP_REACH = 0.35  # of the tuft's length that a tip is dipped, where nothing is said


def recorded_brush(header: Mapping[str, Any]) -> BrushSpec | None:
    """The brush that a recording names; None where it names none.

    Raises
    ------
    RecordingError
        If it is not known.
    """
    name = _named_in(header, "brush")
    if name is None:
        return None
    try:
        return load_brush(name, own_files=False)
    except (BrushError, UnknownNameError) as cause:
        raise RecordingError(f"the header: {cause}") from None


def recorded_ink(header: Mapping[str, Any]) -> dict[Pigment, float] | None:
    """The parts of the ink that a recording names; None where it names none.

    Raises
    ------
    RecordingError
        If one is not known.
    """
    parts = header.get("parts")
    try:
        if isinstance(parts, dict) and len(parts) > 1:  # "ink" is the most of them
            return {load_pigment(str(name), own_tables=False): n for name, n in parts.items()}
        name = _named_in(header, "ink")
        return None if name is None else load_ink(name, own_tables=False)
    except PigmentError as cause:
        raise RecordingError(f"the header: {cause}") from None


def recorded_tip(header: Mapping[str, Any]) -> tuple[dict[Pigment, float], float] | None:
    """What the tip is dipped in afterwards, and over which share of the tuft; None: in nothing.

    Raises
    ------
    RecordingError
        If the ink is not known, or the reach is no share.
    """
    name = _named_in(header, "tip")
    if name is None:
        return None
    reach = as_number(
        header.get("reach", TIP_REACH), "the header's reach", 0.0, 1.0, RecordingError
    )
    try:
        return load_ink(name, own_tables=False), reach
    except PigmentError as cause:
        raise RecordingError(f"the header: {cause}") from None


def recorded_amount(header: Mapping[str, Any]) -> DipAmount:
    """How much ink a recording's dips take up; what the brush's preset says where it says nothing.

    Raises
    ------
    RecordingError
        If it is no amount.
    """
    try:
        return DipAmount.of(header.get("dip", {}))
    except InputError as cause:
        raise RecordingError(f"the header: {cause}") from None


def recorded_loads(header: Mapping[str, Any]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """When the brush comes to hold how much, beyond what dips and its way make of it.

    Returns
    -------
    (K,) int64
        Times, ns, growing.
    (K,) float64
        Shares of what a dip gives, 0 to 1.

    Raises
    ------
    RecordingError
        If they are no such pairs.
    """
    return _told_in(header, "loads")


def recorded_strengths(
    header: Mapping[str, Any],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """When the brush comes to hold how much ink in water; returns and raises as `recorded_loads`.

    The shares are of the mixture that it was dipped in; the rest is water.
    """
    return _told_in(header, "strengths")


def _told_in(header: Mapping[str, Any], name: str) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    told = header.get(name, [])
    expected = "pairs of a time (ns) and a share from 0 to 1, in the order of time"
    try:
        times = np.array([when for when, _ in told], np.int64)
        shares = np.array([as_number(share, "share", 0.0, 1.0) for _, share in told], np.float64)
    except (TypeError, ValueError, OverflowError, InputError):
        raise RecordingError(f"the header's {name} are {told!r:.60}; expected {expected}") from None
    whole = all(type(when) is int for when, _ in told)
    if not (whole and (times[1:] > times[:-1]).all()):
        raise RecordingError(f"the header's {name} are {told!r:.60}; expected {expected}")
    return times, shares


def loads_at(
    time_ns: NDArray[np.int64], when: NDArray[np.int64], shares: NDArray[np.float64]
) -> list[tuple[int, float]]:
    """The sample from which on each share is held, of samples at times; none beyond the last."""
    at = np.searchsorted(time_ns, when)
    told = [(int(k), float(share)) for k, share in zip(at, shares, strict=True)]
    return [one for one in told if one[0] < len(time_ns)]


def _named_in(header: Mapping[str, Any], what: str) -> str | None:
    name = header.get(what)
    if name is not None and not isinstance(name, str):
        raise RecordingError(f"the header's {what} is {name!r:.60}; expected a name")
    return name
