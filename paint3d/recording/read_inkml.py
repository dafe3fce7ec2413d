"""Pad recordings in the W3C's Ink Markup Language (InkML, 2011).

Channels X, Y, Z, F, OA, OE, OR and T are read; others are passed over. Y grows downwards
unless its channel says ``orientation="-ve"``; azimuths turn from the file's x towards its y.
Each trace is a stroke, and the pen is lifted between two of them. Without OA the surface drags
the tip.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from html import escape
from typing import Any
from xml.etree import ElementTree

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.core.foreign_xml import XmlFault, parse_xml
from paint3d.device.recorded import MAX_FORCE_N, Recording
from paint3d.errors import RecordingError
from paint3d.recording.flat_recording import (
    DEFAULT_LEAN,
    angles_from_orientations,
    join_strokes,
    orientations_from_angles,
    spread_ties,
)

__all__ = ["read_inkml", "write_inkml"]

_NAMESPACE = "http://www.w3.org/2003/InkML"
_LENGTHS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "pt": 25.4 / 72, "pc": 25.4 / 6}
_ANGLES = {"deg": math.pi / 180.0, "rad": 1.0}
_TIMES = {"ms": 1_000_000, "s": 1_000_000_000, "us": 1000, "ns": 1}
_DEFAULT_STEP_NS = 10_000_000
_PEN_UP_NS = 100_000_000
_MAX_DEPTH = 64
_NUMBER = re.compile(r"\s*(['\"!]?)\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|\s*(\S)")
_NOTE = "paint3d-header"


def read_inkml(data: bytes, name: str, *, scale: float, y_down: bool) -> Recording:
    """The pad recording in an InkML document.

    Parameters
    ----------
    data : bytes
    name : str
        For messages.
    scale : float
        mm per unit of X, Y and Z where the file gives no unit of length.
    y_down : bool
        Whether Y grows downwards where the file does not say otherwise.

    Raises
    ------
    RecordingError
        If it is not InkML, declares a document type, or a trace is broken.
    """
    try:
        root = parse_xml(data, _MAX_DEPTH, doctypes=False)
    except XmlFault as fault:
        raise RecordingError(f"{name}:{fault.line}: {fault.what}; expected InkML") from None
    if _local(root) != "ink":
        raise RecordingError(f"{name}:1: the root element is <{_local(root)}>; expected <ink>")
    channels, intermittent = _channels(root, name)
    names = [channel["name"] for channel in channels]
    for wanted in ("X", "Y"):
        if wanted not in names:
            raise RecordingError(f"{name}:1: channels are {names}; expected X and Y among them")
    traces = []
    for k, element in enumerate(e for e in root.iter() if _local(e) == "trace"):
        try:
            values = _trace(element.text or "", len(channels), intermittent)
        except RecordingError as cause:
            raise RecordingError(f"{name}: trace {k + 1}: {cause}") from None
        if len(values):
            traces.append(values)
    if not traces:
        raise RecordingError(f"{name}:1: there are no traces with points; expected at least one")
    try:
        return _assemble(traces, channels, _note(root), scale, y_down)
    except RecordingError as cause:
        raise RecordingError(f"{name}: {cause}") from None


def _local(element: ElementTree.Element) -> str:
    return element.tag.rsplit("}", 1)[-1]


def _channels(root: ElementTree.Element, name: str) -> tuple[list[dict[str, str]], int]:
    """Attributes of the channels of the first trace format, and how many are intermittent."""
    formats = [e for e in root.iter() if _local(e) == "traceFormat"]
    if not formats:
        return [{"name": "X"}, {"name": "Y"}], 0
    regular = [dict(e.attrib) for e in formats[0] if _local(e) == "channel"]
    extra = [
        dict(c.attrib)
        for e in formats[0]
        if _local(e) == "intermittentChannels"
        for c in e
        if _local(c) == "channel"
    ]
    channels = regular + extra
    names = [channel.get("name", "") for channel in channels]
    if "" in names or len(set(names)) != len(names):
        raise RecordingError(f"{name}:1: channels are named {names}; expected distinct names")
    return channels, len(extra)


def _trace(text: str, n_channels: int, intermittent: int) -> AnyArray:
    """Points of a trace, (N, C); differences are summed up, and missing channels are NaN."""
    rows: list[list[float]] = []
    order = ["!"] * n_channels
    speed = [0.0] * n_channels
    for point in text.split(","):
        words = _words(point)
        if not words and not point.strip():
            continue
        if not n_channels - intermittent <= len(words) <= n_channels:
            raise RecordingError(
                f"point {len(rows) + 1} has {len(words)} values; expected {n_channels}"
            )
        row = [math.nan] * n_channels
        for c, (prefix, value) in enumerate(words):
            order[c] = prefix or order[c]
            if order[c] == "!":
                row[c] = value
            elif not rows or math.isnan(rows[-1][c]):
                raise RecordingError("the first point is a difference; expected a value")
            else:
                speed[c] = value if order[c] == "'" else speed[c] + value
                row[c] = rows[-1][c] + speed[c]
        rows.append(row)
    return np.array(rows, dtype=np.float64).reshape(-1, n_channels)


def _words(point: str) -> list[tuple[str, float]]:
    words = []
    for match in _NUMBER.finditer(point):
        prefix, number, other = match.groups()
        if other is not None:
            raise RecordingError(f"a point holds {point.strip()[:40]!r}; expected decimal numbers")
        value = float(number)
        if not math.isfinite(value):
            raise RecordingError(f"a value is {number[:40]}; expected a finite number")
        words.append((prefix, value))
    return words


def _assemble(
    traces: list[AnyArray],
    channels: list[dict[str, str]],
    header: dict[str, Any],
    scale: float,
    y_down: bool,
) -> Recording:
    table = np.concatenate(traces)
    stroke = np.repeat(np.arange(len(traces)), [len(t) for t in traces])
    column = {channel["name"]: (k, channel) for k, channel in enumerate(channels)}
    up = -1.0 if _is_down(column["Y"][1], y_down) else 1.0

    def values(key: str, units: dict[str, float], default: float, otherwise: float) -> AnyArray:
        if key not in column:
            return np.full(len(table), otherwise)
        k, channel = column[key]
        unit = channel.get("units")
        if unit is not None and unit not in units and unit not in ("dev", "px", "*"):
            raise RecordingError(f"units of {key} are {unit!r}; expected {' or '.join(units)}")
        found = table[:, k] * (default if unit is None else units.get(unit, default))
        missing = np.isnan(found)
        return np.where(missing, otherwise, found) if missing.any() else found

    x, y, z = (values(key, _LENGTHS, scale, 0.0) for key in "XYZ")
    degree = _ANGLES["deg"]
    azimuth = values("OA", _ANGLES, degree, DEFAULT_LEAN * up) * up
    altitude = values("OE", _ANGLES, degree, 0.5 * math.pi)
    rotation = values("OR", _ANGLES, degree, 0.0)
    if "OA" not in column:
        header = {"azimuth": "dragged", **header}
    return join_strokes(
        _times(table, stroke, column.get("T")),
        np.stack([x, up * y, z], axis=1),
        orientations_from_angles(azimuth, altitude, rotation),
        _pressures(table, column.get("F")),
        stroke,
        header,
    )


def _is_down(channel: dict[str, str], y_down: bool) -> bool:
    orientation = channel.get("orientation")
    return y_down if orientation is None else orientation != "-ve"


def _pressures(table: AnyArray, found: tuple[int, dict[str, str]] | None) -> AnyArray | None:
    """Pressures from F: newtons over 7.9 N, or the channel's own range, or 0 to 1."""
    if found is None:
        return None
    k, channel = found
    force = np.nan_to_num(table[:, k], nan=0.0)
    if channel.get("units") == "N":
        return force / MAX_FORCE_N
    try:
        low, high = float(channel.get("min", "0")), float(channel.get("max", "1"))
    except ValueError:
        raise RecordingError(
            f"F runs from {channel.get('min')!r} to {channel.get('max')!r}; expected numbers"
        ) from None
    if not (math.isfinite(high - low) and low < high):
        raise RecordingError(f"F runs from {low:g} to {high:g}; expected a rising range")
    with np.errstate(over="ignore"):  # what is beyond 1 is refused
        return (force - low) / (high - low)


def _times(table: AnyArray, stroke: AnyArray, found: tuple[int, dict[str, str]] | None) -> AnyArray:
    """Times from T, or 100 points a second with 0.1 s between strokes."""
    n = len(table)
    if found is None:
        result: AnyArray = np.arange(n) * _DEFAULT_STEP_NS + stroke * _PEN_UP_NS
        return result
    k, channel = found
    unit = channel.get("units", "ms")
    if unit not in _TIMES:
        raise RecordingError(f"units of T are {unit!r}; expected {' or '.join(_TIMES)}")
    raw = table[:, k] * _TIMES[unit]
    if not (np.abs(raw) < 2.0**62).all():
        raise RecordingError("T is missing or too large; expected times of at most 146 years")
    times = np.round(raw).astype(np.int64)
    starts = np.flatnonzero(np.diff(stroke)) + 1
    if (times[starts] < times[starts - 1]).any() and (times[starts] == times[0]).all():
        shift = np.concatenate([[0], np.cumsum(times[starts - 1] - times[0] + _PEN_UP_NS)])
        times = times + shift[stroke]  # T counts from the start of each trace
    late = np.flatnonzero(np.diff(times) < 0)
    if len(late):
        raise RecordingError(
            f"point {late[0] + 2}: T is {table[late[0] + 1, k]:.15g}; "
            f"expected at least {table[late[0], k]:.15g}"
        )
    return spread_ties(times)[0]


def _note(root: ElementTree.Element) -> dict[str, Any]:
    """Our header, where we wrote the document."""
    for element in root.iter():
        if _local(element) == "annotation" and element.get("type") == _NOTE:
            try:
                note = json.loads(element.text or "")
            except (ValueError, RecursionError):
                break
            if isinstance(note, dict):
                return {**note, "space": "pad"}
    return {}


def write_inkml(recording: Recording) -> Iterator[str]:
    """The lines of an InkML document with a pad recording, strokes split where the pen is up.

    Lifted samples between strokes are not written (reading puts them back). Y is written
    downwards, as InkML has it; angles in degrees; T in ns from the first sample.

    Raises
    ------
    RecordingError
        If the recording is not a pad's, or the pen never touches.
    """
    if not recording.is_pad:
        raise RecordingError("the recording's space is 'world'; InkML holds 'pad' recordings only")
    down = np.ones(len(recording), bool) if recording.pressure is None else recording.pressure > 0
    if not down.any():
        raise RecordingError("the pen never touches; expected a pressure above 0")
    header = escape(json.dumps(dict(recording.header), allow_nan=False), quote=False)
    yield f'<?xml version="1.0" encoding="UTF-8"?>\n<ink xmlns="{_NAMESPACE}">\n'
    yield f'<annotation type="{_NOTE}">{header}</annotation>\n<traceFormat>\n'
    for key, rest in (
        ("X", 'units="mm"'),
        ("Y", 'units="mm" orientation="+ve"'),
        ("Z", 'units="mm"'),
        ("F", 'min="0" max="1"'),
        ("OA", 'units="deg"'),
        ("OE", 'units="deg"'),
        ("OR", 'units="deg"'),
        ("T", 'units="ns"'),
    ):
        kind = "integer" if key == "T" else "decimal"
        yield f'<channel name="{key}" type="{kind}" {rest}/>\n'
    yield "</traceFormat>\n"
    edges = np.flatnonzero(np.diff(np.concatenate([[False], down, [False]]).astype(np.int8)))
    columns = _written(recording)
    times = recording.time_ns - recording.time_ns[0]
    for first, last in edges.reshape(-1, 2):
        points = (
            " ".join([*map(repr, columns[i].tolist()), str(times[i])]) for i in range(first, last)
        )
        yield "<trace>" + ", ".join(points) + "</trace>\n"
    yield "</ink>\n"


def _written(recording: Recording) -> AnyArray:
    azimuth, altitude, rotation = angles_from_orientations(recording.orientation)
    pressure = 0.5 if recording.pressure is None else recording.pressure
    return np.column_stack(
        [
            recording.position * [1.0, -1.0, 1.0],
            np.broadcast_to(pressure, len(recording)),
            np.degrees(-azimuth),
            np.degrees(altitude),
            np.degrees(rotation),
        ]
    )
