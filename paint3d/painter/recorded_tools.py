"""What a recording of version 1 says of brush and ink: in its header, of no file of a machine."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BrushSpec, DipAmount
from paint3d.colour.inks import load_ink
from paint3d.colour.pigments import Pigment, load_pigment
from paint3d.core.arrays import as_number
from paint3d.errors import BrushError, InputError, PigmentError, RecordingError, UnknownNameError

__all__ = [
    "LEAST_INK",
    "TIP_REACH",
    "recorded_amount",
    "recorded_brush",
    "recorded_ink",
    "recorded_tip",
    "told_at",
]

TIP_REACH = 0.35  # of the tuft's length that a tip is dipped, where nothing is said
LEAST_INK = 1e-4
"""Share of ink in water, that a brush is thinned to at the least."""


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


def told_at(
    header: Mapping[str, Any], time_ns: NDArray[np.int64]
) -> tuple[list[tuple[int, float]], list[tuple[int, float]]]:
    """What a header tells of samples at times: its ``loads``, and its ``strengths``.

    Returns
    -------
    loads, strengths : list of (int, float)
        From which sample on the brush holds which share of a dip, and which share of ink, the rest
        being water; none beyond the last sample.

    Raises
    ------
    RecordingError
        If they are no pairs of a time (ns) and a share, in the order of time.
    """
    loads = _told_in(header, "loads", 0.0, time_ns)
    return loads, _told_in(header, "strengths", LEAST_INK, time_ns)


def _told_in(
    header: Mapping[str, Any], name: str, least: float, time_ns: NDArray[np.int64]
) -> list[tuple[int, float]]:
    told = header.get(name, [])
    expected = f"pairs of a time (ns) and a share from {least:g} to 1, in the order of time"
    try:
        times = np.array([when for when, _ in told], np.int64)
        shares = [as_number(share, "share", least, 1.0) for _, share in told]
    except (TypeError, ValueError, OverflowError, InputError):
        raise RecordingError(f"the header's {name} are {told!r:.60}; expected {expected}") from None
    whole = all(type(when) is int for when, _ in told)
    if not (whole and (times[1:] > times[:-1]).all()):
        raise RecordingError(f"the header's {name} are {told!r:.60}; expected {expected}")
    at = np.searchsorted(time_ns, times)
    return [(int(k), share) for k, share in zip(at, shares, strict=True) if k < len(time_ns)]


def _named_in(header: Mapping[str, Any], what: str) -> str | None:
    name = header.get(what)
    if name is not None and not isinstance(name, str):
        raise RecordingError(f"the header's {what} is {name!r:.60}; expected a name")
    return name
