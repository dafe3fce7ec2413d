"""Pad recordings in the W3C's Ink Markup Language (InkML, 2011).

Channels X, Y, Z, F, OA, OE, OTx, OTy, OR and T are read; others are passed over. Y grows downwards
unless its channel says ``orientation="-ve"``; azimuths turn from the file's x towards its y.
Counts of a device become lengths, angles or times by its channel's property ``resolution``. Each
trace is a stroke, with those that continue it, and the pen is lifted between two of them; a trace
of type penUp is its way through the air. Without OA or tilts, or where OE is 0 all along, the
surface drags the tip. Times are those of T, else of the traces' timeOffset, else of the ink
source's sampleRate. Points lie where an affine mapping to the canvas has them; of other mappings a
note says that they are left out.
"""

from __future__ import annotations

import json
import logging
import math
import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from html import escape
from typing import Any, NamedTuple
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
    spread_equal_times,
)

__all__ = ["read_inkml", "write_inkml"]

_LOG = logging.getLogger("paint3d")
_NAMESPACE = "http://www.w3.org/2003/InkML"
_ID = "{http://www.w3.org/XML/1998/namespace}id"
_LENGTHS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "pt": 25.4 / 72, "pc": 25.4 / 6}
_LENGTHS |= {"himetric": 0.01}
_KNOWN = ("X", "Y", "Z", "F", "OA", "OE", "OTx", "OTy", "OR", "T")
_TILTS = ("OTx", "OTy")
_STEEPEST = 0.49 * math.pi  # a tilt
_CONTEXT_PARTS = ("traceFormatRef", "inkSourceRef")
_COUNTS = ("dev", "px", "*")  # units that say nothing of lengths, angles or times
_ANGLES = {"deg": math.pi / 180.0, "rad": 1.0}
_TIMES = {"ms": 1_000_000, "s": 1_000_000_000, "us": 1000, "ns": 1}
_DEFAULT_STEP_NS = 10_000_000
_PEN_UP_NS = 100_000_000
_LONGEST_MS = 4e12  # 127 years
_PRESSED = 0.5  # where the pad tells no pressure
_MAX_DEPTH = 64
_NUMBER = re.compile(  # prefix (' difference, " second difference, ! value), number or word; other
    r"\s*(['\"!]?)\s*([-+]?(?:#[\dA-Fa-f]+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|[TF*?])|\s*(\S)"
)
_TRUTH = {"T": 1.0, "F": 0.0}
_GO_ON, _UNKNOWN = "*", "?"
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
        raise RecordingError(
            "{name}:{line}: {what}; expected InkML",
            name=name,
            line=fault.line,
            what=fault.what,
        ) from None
    if _local_name(root) != "ink":
        raise RecordingError(
            "{name}:1: the root element is <{local}>; expected <ink>",
            name=name,
            local=_local_name(root),
        )
    format_of = _find_formats(root, name)
    started = _find_starts(root)
    traces = []
    for k, (element, context) in enumerate(_find_traces(root)):
        layout = format_of(context)
        try:
            values = _read_points(element.text or "", layout)
        except RecordingError as cause:
            raise RecordingError(
                "{name}: trace {k}: {cause}", name=name, k=k + 1, cause=cause
            ) from None
        if len(values):
            is_up = element.get("type") == "penUp"
            traces.append(_Trace(values, layout, is_up, element, *started(element, context)))
    traces = _join_continued(traces)
    if not traces:
        raise RecordingError(
            "{name}:1: there are no traces with points; expected at least one",
            name=name,
        )
    try:
        return _assemble(traces, _read_header(root), scale, y_down)
    except RecordingError as cause:
        raise RecordingError("{name}: {cause}", name=name, cause=cause) from None


class _Format(NamedTuple):
    """Channels of a trace: the meaning of a point's numbers.

    `channels` are attributes by name, in the points' order, of which the last `intermittent` may
    be missing; `resolutions` are counts to a unit, `step_ns` is from one point to the next, and
    `canvas` is where the points lie, if that is elsewhere.
    """

    channels: dict[str, dict[str, str]]
    intermittent: int
    resolutions: dict[str, tuple[float, str]]
    step_ns: int
    canvas: _Canvas | None = None


class _Canvas(NamedTuple):
    """Affine map of channels to a canvas: `targets` are rows @ (the values of `sources`, 1).

    `channels` are the attributes of the targets there; none where nothing is said.
    """

    sources: list[str]
    targets: list[str]
    rows: AnyArray
    channels: dict[str, dict[str, str]]


class _Trace(NamedTuple):
    """Points (N, C) in a format, of a pen that touches or not.

    `start_ms` and `duration_ms` are NaN where nothing is said; the same `stroke` as that of the one
    before is that stroke's continuation.
    """

    values: AnyArray
    layout: _Format
    is_up: bool
    element: ElementTree.Element
    start_ms: float
    duration_ms: float
    stroke: int = 0


def _local_name(element: ElementTree.Element) -> str:
    return element.tag.rsplit("}", 1)[-1]


def _find_traces(
    element: ElementTree.Element, context: str = ""
) -> Iterator[tuple[ElementTree.Element, str]]:
    """Yield the traces of an element, and the identifiers of their contexts, inherited from groups.

    Those among definitions are there to be referred to; they count where there are no others.
    """
    every = list(_walk_traces(element, context, False))
    shown = [(trace, inherited) for trace, inherited, is_defined in every if not is_defined]
    yield from shown or [(trace, inherited) for trace, inherited, _ in every]


def _walk_traces(
    element: ElementTree.Element, context: str, is_defined: bool
) -> Iterator[tuple[ElementTree.Element, str, bool]]:
    context = element.get("contextRef", "")[1:] or context
    if _local_name(element) == "trace":
        yield element, context, is_defined
        return
    is_defined = is_defined or _local_name(element) == "definitions"
    for inner in element:
        yield from _walk_traces(inner, context, is_defined)


def _join_continued(traces: list[_Trace]) -> list[_Trace]:
    """Assign stroke numbers to traces, each behind the one that it continues.

    That is the one that its priorRef names, else the last one of a stroke that is not at its end.
    """
    strokes: list[list[_Trace]] = []
    stroke_of: dict[str | None, int] = {}
    is_open = False
    for trace in traces:
        said = trace.element.get("continuation", "")
        prior = stroke_of.get(trace.element.get("priorRef", "")[1:] or None)
        if prior is None and said in ("middle", "end") and is_open:
            prior = len(strokes) - 1
        if prior is None or trace.is_up:
            strokes.append([])
            prior = len(strokes) - 1
        strokes[prior].append(trace)
        name = trace.element.get(_ID) or trace.element.get("id")
        stroke_of |= {name: prior} if name else {}
        is_open = said in ("begin", "middle")
    return [trace._replace(stroke=k) for k, stroke in enumerate(strokes) for trace in stroke]


def _find_starts(
    root: ElementTree.Element,
) -> Callable[[ElementTree.Element, str], tuple[float, float]]:
    """Return a function: start and duration of a trace, ms; NaN where unspecified."""
    named = {e.get(_ID) or e.get("id") or None: e for e in root.iter()}

    def of_timestamp(reference: str) -> float:
        total, seen = 0.0, set[str]()
        while reference and reference not in seen:
            seen.add(reference)
            stamp = named.get(reference[1:])
            if stamp is None:
                break
            for key in ("time", "timeOffset"):
                total += _milliseconds(stamp, key, 0.0)
            reference = stamp.get("timestampRef", "")
        return total

    def started(trace: ElementTree.Element, context: str) -> tuple[float, float]:
        start, duration = (_milliseconds(trace, key) for key in ("timeOffset", "duration"))
        inherited = named.get(context) if context else None
        since = ""  # the reference of its context to when times begin
        if inherited is not None:
            inside = (e for e in inherited.iter() if _local_name(e) == "timestamp")
            stamp = next((e.get(_ID) or e.get("id") for e in inside), None)
            since = inherited.get("timestampRef", "") or (f"#{stamp}" if stamp else "")
        return start + of_timestamp(since), duration

    return started


def _milliseconds(element: ElementTree.Element, key: str, otherwise: float = math.nan) -> float:
    try:
        value = float(element.get(key, ""))
    except ValueError:
        return otherwise
    return value if abs(value) < _LONGEST_MS else otherwise


def _find_formats(root: ElementTree.Element, name: str) -> Callable[[str], _Format]:
    """Return a function: format of a trace by its context; by default the document's first."""
    named = {e.get(_ID) or e.get("id") or None: e for e in root.iter()}

    @cache
    def described(
        element: ElementTree.Element,
    ) -> tuple[ElementTree.Element | None, dict[str, tuple[float, str]], int]:
        """The first trace format in an element, the resolutions that belong to it, and its step.

        A canvas's format is not that of traces.
        Those are its ink source's; where it stands in none, all there are.
        """
        inner = {
            e for canvas in element.iter() if _local_name(canvas) == "canvas" for e in canvas.iter()
        }
        every = [e for e in element.iter() if e not in inner]
        layout = next((e for e in every if _local_name(e) == "traceFormat"), None)
        for source in (e for e in every if _local_name(e) == "inkSource"):
            if layout is not None and layout in source.iter():
                every = list(source.iter())
                break
        return layout, _read_resolutions(every, name), _read_step_ns(every)

    @cache
    def channels(layout: ElementTree.Element | None) -> tuple[dict[str, dict[str, str]], int]:
        return ({"X": {}, "Y": {}}, 0) if layout is None else _read_channels(layout, name)

    @cache
    def format_of(context: str) -> _Format:
        contexts: list[ElementTree.Element] = []
        element = named.get(context) if context else None
        while element is not None and element not in contexts and len(contexts) < _MAX_DEPTH:
            contexts.append(element)
            others = (named.get(element.get(key, "")[1:]) for key in _CONTEXT_PARTS)
            contexts += [other for other in others if other is not None]
            element = named.get(element.get("contextRef", "")[1:])  # what it does not say itself
        descriptions = [described(context) for context in contexts]
        if all(layout is None for layout, _, _ in descriptions):
            descriptions.append(described(root))
        layout = next((layout for layout, _, _ in descriptions if layout is not None), None)
        resolutions: dict[str, tuple[float, str]] = {}
        for _, counts, _ in reversed(descriptions):
            resolutions |= counts
        step_ns = next((step for _, _, step in descriptions if step), _DEFAULT_STEP_NS)
        named_channels, intermittent = channels(layout)
        canvas = _find_canvas(contexts, named, named_channels, name)
        return _Format(named_channels, intermittent, resolutions, step_ns, canvas)

    return format_of


def _find_canvas(
    contexts: list[ElementTree.Element],
    named: Mapping[str | None, ElementTree.Element],
    channels: Mapping[str, object],
    name: str,
) -> _Canvas | None:
    """The affine map of a context's traces to its canvas; None where there is no usable one."""

    def inherited(kind: str) -> ElementTree.Element | None:
        for context in contexts:
            inside = next((e for e in context.iter() if _local_name(e) == kind), None)
            referred = named.get(context.get(f"{kind}Ref", "")[1:])
            if inside is not None or referred is not None:
                return inside if inside is not None else referred
        return None

    transform = inherited("canvasTransform")
    if transform is None:
        return None
    mapping = next((e for e in transform if _local_name(e) == "mapping"), None)
    seen: list[ElementTree.Element] = []
    while mapping is not None and mapping.get("mappingRef") and mapping not in seen:
        seen.append(mapping)
        mapping = named.get(mapping.get("mappingRef", "")[1:])
    kind = "identity" if mapping is None else mapping.get("type", "unknown")
    if kind == "identity":
        return None
    affine = (
        _read_affine(mapping, list(channels)) if mapping is not None and kind == "affine" else None
    )
    if affine is None:
        _LOG.warning("%s: left out: a mapping to a canvas that is not affine", name)
        return None
    canvas = inherited("canvas")
    layout = None if canvas is None else named.get(canvas.get("traceFormatRef", "")[1:])
    if canvas is not None and layout is None:
        layout = next((e for e in canvas.iter() if _local_name(e) == "traceFormat"), None)
    there = {} if layout is None else _read_channels(layout, name)[0]
    return _Canvas(*affine, there)


def _read_affine(
    mapping: ElementTree.Element, channels: list[str]
) -> tuple[list[str], list[str], AnyArray] | None:
    """Sources, targets and rows of an affine mapping of X, Y and the like, or None.

    By its bindings; without, of the first channels to themselves.
    """
    text = next((e.text or "" for e in mapping if _local_name(e) in ("matrix", "affine")), "")
    try:
        rows = [[float(word) for word in row.split()] for row in text.strip(", \n").split(",")]
    except ValueError:
        return None
    n = len(rows[0]) - 1
    if n < 1 or any(len(row) != n + 1 for row in rows) or not np.isfinite(rows).all():
        return None
    binds = [e for e in mapping if _local_name(e) == "bind"]
    sources = [bind.get("source", "") for bind in binds if bind.get("source")] or channels[:n]
    targets = [bind.get("target", "") for bind in binds if bind.get("target")] or channels[
        : len(rows)
    ]
    known = len(sources) == n and len(targets) == len(rows) and set(sources) <= set(channels)
    if not known or not set(targets) <= {"X", "Y", "Z"}:
        return None
    return sources, targets, np.array(rows)


def _map_to_canvas(table: AnyArray, layout: _Format) -> tuple[AnyArray, _Format]:
    """Map points (N, C) to their canvas; return them with its format."""
    if layout.canvas is None:
        return table, layout
    sources, targets, rows, there = layout.canvas
    names = list(layout.channels)
    own = table[:, [names.index(key) for key in sources]]
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused
        moved = own @ rows[:, :-1].T + rows[:, -1]
    columns = dict(zip(names, table.T, strict=True)) | dict(zip(targets, moved.T, strict=True))
    replaced = {key: {**layout.channels.get(key, {}), "type": "decimal"} for key in targets}
    channels = {
        **layout.channels,
        **replaced,
        **{key: there[key] for key in targets if key in there},
    }
    resolutions = {
        k: resolution for k, resolution in layout.resolutions.items() if k not in targets
    }
    return (
        np.column_stack([columns[key] for key in channels]),
        layout._replace(channels=channels, resolutions=resolutions),
    )


def _read_channels(layout: ElementTree.Element, name: str) -> tuple[dict[str, dict[str, str]], int]:
    """Attributes of a format's channels by name, and how many are intermittent."""
    regular = [dict(e.attrib) for e in layout if _local_name(e) == "channel"]
    extra = [
        dict(c.attrib)
        for e in layout
        if _local_name(e) == "intermittentChannels"
        for c in e
        if _local_name(c) == "channel"
    ]
    names = [channel.get("name", "") for channel in regular + extra]
    if "" in names or len(set(names)) != len(names):
        raise RecordingError(
            "{name}:1: channels are named {names}; expected distinct names",
            name=name,
            names=names,
        )
    for wanted in ("X", "Y"):
        if wanted not in names:
            raise RecordingError(
                "{name}:1: channels are {names}; expected X and Y among them",
                name=name,
                names=names,
            )
    return dict(zip(names, regular + extra, strict=True)), len(extra)


def _read_step_ns(elements: list[ElementTree.Element]) -> int:
    """ns from one point to the next of a source with an even rate; else 0."""
    for element in elements:
        if _local_name(element) == "sampleRate" and element.get("uniform") != "false":
            rate = _milliseconds(element, "value", 0.0)  # points a second
            return round(1e9 / rate) if 1.0 <= rate <= 1e6 else 0
    return 0


def _read_resolutions(
    elements: list[ElementTree.Element], name: str
) -> dict[str, tuple[float, str]]:
    """Counts per unit, "" for the channel's own, of the channel properties among these."""
    result: dict[str, tuple[float, str]] = {}
    for entry in elements:
        key = entry.get("channel", "")
        if _local_name(entry) != "channelProperty" or entry.get("name") != "resolution":
            continue
        if key not in _KNOWN or key in result:
            continue
        value = entry.get("value", "")
        try:
            counts = float(value)
        except ValueError:
            counts = math.nan
        if not (math.isfinite(counts) and counts >= 0.0):
            raise RecordingError(
                "{name}:1: the resolution of {key} is {told!r}; expected a number from 0",
                name=name,
                key=key,
                told=value[:40],
            )
        result[key] = counts, entry.get("units", "").replace(" ", "").removeprefix("1/")
    return result


def _read_points(text: str, layout: _Format) -> AnyArray:
    """Points of a trace, (N, C); differences are summed up, and missing channels go on as before.

    What is unknown from the beginning is the channel's default, else NaN.
    """
    n_channels = len(layout.channels)
    default = [_default_value(channel) for channel in layout.channels.values()]
    rows: list[list[float]] = []
    order = ["!"] * n_channels  # prefixes hold until a channel has another one
    speed = [0.0] * n_channels
    said = list(default)
    for point in text.split(","):
        words = _split_point(point)
        if not words and not point.strip():
            continue
        if not n_channels - layout.intermittent <= len(words) <= n_channels:
            raise RecordingError(
                "point {n} has {words} values; expected {n_channels}",
                n=len(rows) + 1,
                words=len(words),
                n_channels=n_channels,
            )
        row = list(rows[-1] if rows else default)
        for c, (prefix, value) in enumerate(words):
            if value is None:  # it is as it was
                continue
            order[c] = prefix or order[c]
            said[c] = said[c] if math.isnan(value) else value
            if order[c] == "!":
                row[c] = said[c]
            elif not rows or math.isnan(rows[-1][c]):
                raise RecordingError("the first point is a difference; expected a value")
            else:
                speed[c] = said[c] if order[c] == "'" else speed[c] + said[c]
                row[c] = rows[-1][c] + speed[c]
        rows.append(row)
    return np.array(rows, dtype=np.float64).reshape(-1, n_channels)


def _default_value(channel: Mapping[str, str]) -> float:
    default = channel.get("default", "")
    try:
        return _TRUTH[default] if default in _TRUTH else float(default)
    except ValueError:
        return math.nan


def _split_point(point: str) -> list[tuple[str, float | None]]:
    """Prefixes and values of a point: NaN for the same value or difference, None for nothing."""
    words: list[tuple[str, float | None]] = []
    for match in _NUMBER.finditer(point):
        prefix, word, other = match.groups()
        if other is not None:
            raise RecordingError(
                "a point holds {point!r}; expected decimal numbers",
                point=point.strip()[:40],
            )
        if word in (_GO_ON, _UNKNOWN):
            words.append((prefix, math.nan if word == _GO_ON else None))
            continue
        if word in _TRUTH:
            words.append((prefix, _TRUTH[word]))
            continue
        sign, is_hexadecimal, digits = word.rpartition("#")
        try:
            value = float(int(sign + digits, 16)) if is_hexadecimal else float(word)
        except OverflowError:
            value = math.inf
        if not math.isfinite(value):
            raise RecordingError(
                "a value is {number}; expected a finite number",
                number=word[:40],
            )
        words.append((prefix, value))
    return words


def _assemble(
    traces: list[_Trace], header: dict[str, Any], scale: float, y_down: bool
) -> Recording:
    sizes = [len(trace.values) for trace in traces]
    piece = np.repeat(np.arange(len(traces)), sizes)
    stroke = np.array([trace.stroke for trace in traces])[piece]
    first = np.cumsum([0, *sizes])
    groups: dict[int, list[int]] = {}
    for k, trace in enumerate(traces):
        groups.setdefault(id(trace.layout), []).append(k)
    parts: list[tuple[AnyArray, dict[str, AnyArray]]] = []
    for group in groups.values():
        rows = np.concatenate([np.arange(first[k], first[k + 1]) for k in group])
        table = np.concatenate([traces[k].values for k in group])
        part = _measure_channels(table, traces[group[0]].layout, scale, y_down)
        _drop_flat_angles(part, piece[rows])
        parts.append((rows, part))

    def whole(key: str, otherwise: float) -> AnyArray:
        result = np.full(len(stroke), otherwise)
        for rows, part in parts:
            if key in part:
                result[rows] = np.where(np.isnan(part[key]), otherwise, part[key])
        return result

    def is_known(key: str) -> bool:
        return all(key in part and not np.isnan(part[key]).all() for _, part in parts)

    pressure = whole("F", 0.0)
    pressure[np.array([trace.is_up for trace in traces])[piece]] = 0.0
    position = np.stack([whole("X", math.nan), whole("Y", math.nan), whole("Z", 0.0)], axis=1)
    if np.isnan(position).any():
        raise RecordingError(
            "point {first}: X or Y is unknown; expected numbers",
            first=int(np.flatnonzero(np.isnan(position).any(axis=1))[0]) + 1,
        )
    if not is_known("OA"):
        header = {"azimuth": "dragged", **header}
    return join_strokes(
        _find_times(whole("T", math.nan) if is_known("T") else None, piece, traces),
        position,
        orientations_from_angles(
            whole("OA", DEFAULT_LEAN), whole("OE", 0.5 * math.pi), whole("OR", 0.0)
        ),
        pressure,
        stroke,
        header,
    )


def _drop_flat_angles(part: dict[str, AnyArray], pieces: AnyArray) -> None:
    """Set directions to NaN in traces (N,) whose pen lies flat on the pad throughout.

    None can: office programs write angles of 0 for pens, fingers and mice that tell none.
    """
    if "OE" in part:
        is_raised = np.isin(pieces, pieces[~(part["OE"] <= 0.0)])
        for key in {"OA", "OE"} & part.keys():
            part[key] = np.where(is_raised, part[key], math.nan)


def _measure_channels(
    table: AnyArray, layout: _Format, scale: float, y_down: bool
) -> dict[str, AnyArray]:
    """The known channels of points (N, C) in mm, rad, fractions of the highest force, and ns."""
    table, layout = _map_to_canvas(table, layout)
    degree = _ANGLES["deg"]
    orientation = layout.channels["Y"].get("orientation")
    is_down = y_down if orientation is None else orientation != "-ve"
    up = -1.0 if is_down else 1.0
    right = -1.0 if layout.channels["X"].get("orientation") == "-ve" else 1.0
    result: dict[str, AnyArray] = {"F": np.full(len(table), _PRESSED)}
    for column, key in zip(table.T, layout.channels, strict=True):
        if key in ("X", "Y", "Z"):
            result[key] = _convert_units(column, key, layout, _LENGTHS, scale)
        elif key in ("OA", "OE", "OR", *_TILTS):
            result[key] = _convert_units(column, key, layout, _ANGLES, degree)
        elif key == "F":
            result[key] = _convert_pressures(column, layout)
        elif key == "T":
            result[key] = _convert_units(column, key, layout, _TIMES, _TIMES["ms"])
    if "OA" not in result and set(_TILTS) <= set(result):
        lean_x, lean_y = (np.tan(np.clip(result[key], -_STEEPEST, _STEEPEST)) for key in _TILTS)
        result["OA"] = np.arctan2(lean_y, lean_x)
        result.setdefault("OE", np.arctan2(1.0, np.hypot(lean_x, lean_y)))
    if "OA" in result:
        result["OA"] = np.arctan2(up * np.sin(result["OA"]), right * np.cos(result["OA"]))
    result["X"], result["Y"] = right * result["X"], up * result["Y"]
    return result


def _convert_units(
    values: AnyArray, key: str, layout: _Format, units: Mapping[str, float], otherwise: float
) -> AnyArray:
    """Values of a channel in one of these units; `otherwise` is the factor of unknown ones.

    Office programs tell a unit and mean counts, of which as many go to it as the resolution says.
    A channel of decimal numbers has them in its unit, and the resolution is only the device's.
    """
    channel = layout.channels[key]
    unit = channel.get("units")
    if unit is not None and unit not in units and unit not in _COUNTS:
        raise RecordingError(
            "units of {key} are {unit!r}; expected {units}",
            key=key,
            unit=unit,
            units=" or ".join(units),
        )
    counts, of = layout.resolutions.get(key, (0.0, ""))
    of = of or unit or ""
    kind = channel.get("type")
    if kind is None and (np.isnan(values) | (values == np.floor(values))).all():
        kind = "integer"
    factor = otherwise if unit is None else units.get(unit, otherwise)
    if counts > 0.0 and of in units and (kind == "integer" or unit not in units):
        factor = units[of] / counts
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused
        return values * factor


def _convert_pressures(column: AnyArray, layout: _Format) -> AnyArray:
    """Pressures from F: newtons over 7.9 N, or the channel's own range, or 0 to 1."""
    channel = layout.channels["F"]
    if channel.get("units") == "N":
        return _convert_units(column, "F", layout, {"N": 1.0}, 1.0) / MAX_FORCE_N
    try:
        low, high = float(channel.get("min", "0")), float(channel.get("max", "1"))
    except ValueError:
        raise RecordingError(
            "F runs from {min!r} to {max!r}; expected numbers",
            min=channel.get("min"),
            max=channel.get("max"),
        ) from None
    if not (math.isfinite(high - low) and low < high):
        raise RecordingError(
            "F runs from {low:g} to {high:g}; expected a rising range",
            low=low,
            high=high,
        )
    with np.errstate(over="ignore"):  # what is beyond 1 is refused
        return (column - low) / (high - low)


def _find_times(raw: AnyArray | None, piece: AnyArray, traces: list[_Trace]) -> AnyArray:
    """Times of points in ns: of T, else of the traces' offsets, else of the sources' rates."""
    n, starts = len(piece), np.flatnonzero(np.diff(piece, prepend=-1))
    offsets = 1e6 * np.array([trace.start_ms for trace in traces])
    has_offsets = bool(np.isfinite(offsets).all() and (np.diff(offsets) >= 0.0).all())
    has_offsets = has_offsets and bool(offsets[-1] - offsets[0] < 2.0**62)
    offsets = (
        np.round(offsets - offsets[0]).astype(np.int64) if has_offsets else np.zeros(0, np.int64)
    )
    if raw is None and has_offsets and (len(traces) > 1 or traces[0].duration_ms > 0.0):
        times = (
            offsets[piece] + (np.arange(n) - starts[piece]) * _find_steps(traces, offsets)[piece]
        )
        return spread_equal_times(times)[0]
    if raw is None:
        step = np.array([trace.layout.step_ns for trace in traces])[piece]
        gaps = np.diff([trace.stroke for trace in traces], prepend=0)[piece] * _PEN_UP_NS
        gaps[np.arange(n) != starts[piece]] = 0
        result: AnyArray = np.cumsum(step + gaps) - step[0]
        return result
    if not (np.abs(raw) < 2.0**62).all():
        raise RecordingError("T is missing or too large; expected times of at most 146 years")
    times = np.round(raw).astype(np.int64)
    if len(starts) > 1 and (times[starts] == times[0]).all():  # counts from the start of each trace
        if (
            has_offsets
            and (offsets[1:] + times[0] >= (times + offsets[piece])[starts[1:] - 1]).all()
        ):
            times = times + offsets[piece]
        elif (times[starts[1:]] < times[starts[1:] - 1]).any():
            step = np.diff([trace.stroke for trace in traces]) * _PEN_UP_NS
            step = np.maximum(step, [trace.layout.step_ns for trace in traces[1:]])
            shift = np.cumsum(times[starts[1:] - 1] - times[0] + step)
            times = times + np.concatenate([[0], shift])[piece]
    late = np.flatnonzero(np.diff(times) < 0)
    if len(late):
        now, before = (raw[late[0] + k] / _TIMES["ms"] for k in (1, 0))
        raise RecordingError(
            "point {first}: T is {now:.15g}; expected at least {before:.15g} ms",
            first=late[0] + 2,
            now=now,
            before=before,
        )
    return spread_equal_times(times)[0]


def _find_steps(traces: list[_Trace], offsets: AnyArray) -> AnyArray:
    """Steps between points of each trace, ns: by its duration, or as the next one allows."""
    n = np.array([len(trace.values) for trace in traces])
    available = np.append(np.diff(offsets), np.iinfo(np.int64).max)
    usual = np.array([trace.layout.step_ns for trace in traces])
    lasts = np.array([1e6 * trace.duration_ms for trace in traces])
    steps = np.where(lasts > 0.0, lasts / np.maximum(n - 1, 1), usual)
    result: AnyArray = np.minimum(np.round(steps), available // n).astype(np.int64)
    return result


def _read_header(root: ElementTree.Element) -> dict[str, Any]:
    """Header that `write_inkml` put into the document; empty in others' documents."""
    for element in root.iter():
        if _local_name(element) == "annotation" and element.get("type") == _NOTE:
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
    azimuth, altitude, rotation = angles_from_orientations(recording.orientation)
    pressure = 0.5 if recording.pressure is None else recording.pressure
    columns = np.column_stack(
        [
            recording.position * [1.0, -1.0, 1.0],
            np.broadcast_to(pressure, len(recording)),
            np.degrees(-azimuth),
            np.degrees(altitude),
            np.degrees(rotation),
        ]
    )
    times = recording.time_ns - recording.time_ns[0]
    for first, last in edges.reshape(-1, 2):
        points = (
            " ".join([*map(repr, columns[i].tolist()), str(times[i])]) for i in range(first, last)
        )
        yield "<trace>" + ", ".join(points) + "</trace>\n"
    yield "</ink>\n"
