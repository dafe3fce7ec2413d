"""Units in a recording's header."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from paint3d.errors import RecordingError

__all__ = ["TO_MM", "TO_NS", "units_of"]

TO_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
TO_NS = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}


def units_of(header: Mapping[str, Any], times: tuple[str, ...] = ("ns",)) -> dict[str, Any]:
    """The units in a header, checked; `length` is `position`.

    Parameters
    ----------
    header : mapping
    times : tuple of str
        Units of time that the file may have.

    Raises
    ------
    RecordingError
        If one is not known.
    """
    units = header.get("units", {})
    if isinstance(units, str):
        units = {"position": units}
    if not isinstance(units, dict):
        raise RecordingError(
            "units is {units!r}; expected an object such as {{'position': 'mm'}}",
            units=units,
        )
    length = units.get("length")
    said = {**({"position": length} if length else {}), **units}
    said.pop("length", None)
    for key, names in {"position": tuple(TO_MM), "time": times, "force": ("N",)}.items():
        if key in said and said[key] not in names:
            raise RecordingError(
                "units: {key} is {merged!r}; expected {names}",
                key=key,
                merged=said[key],
                names=" or ".join(names),
            )
    return said
