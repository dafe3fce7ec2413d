"""Recordings as tables: CSV with named columns, and plain columns of time, x, y, pressure.

Columns are found by name, without regard to case; others are passed over:

==================  ====================================================  ===================
meaning             names                                                 unit
==================  ====================================================  ===================
time                time_ns                                               ns, kept exactly
..                  time_ms, timestamp, sensor_timestamp                  ms
..                  time, time_s, t                                       s
place               x_mm, y_mm, z_mm; x_cm, ...; x_m, ...                 by name, y upwards
..                  x, y, z; spline_x, spline_y; pos_x, pos_y             of pads `scale` and
                                                                          `y_down`; else as _mm
pressure            pressure, sensor_pressure, p                          0 to 1
..                  force, force_n                                        N, 0 to 7.9
lean of the handle  altitude, azimuth, rotation; sensor_altitude, ...     rad
..                  altitude_deg, azimuth_deg, rotation_deg               degrees
orientation         qw, qx, qy, qz                                        unit quaternion
object              object_x_mm ..., object_qw ...                        mm, unit quaternion
contact             contact_x_mm ..., an empty cell for none              mm
stroke              idx, stroke, stroke_id                                of pads, a new one lifts
buttons             buttons                                               bits
==================  ====================================================  ===================

A first line ``# {...}`` holds the header as JSON. Tables without quaternions are pads;
without an azimuth the surface drags the tip. Of a pad that tells z or newtons, as robots do and
screens do not, x and y are mm, y upwards, unless the caller says what they are.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from paint3d.core.arrays import AnyArray
from paint3d.device.recorded import MAX_FORCE_N, Recording
from paint3d.errors import RecordingError
from paint3d.recording.flat_recording import (
    DEFAULT_LEAN,
    MM_PER_PIXEL,
    Lifts,
    notes_of,
    orientations_from_angles,
    spread_ties,
)
from paint3d.recording.number_table import Lines, NumberTable

__all__ = ["read_csv", "read_plain_table", "write_csv"]

_TIMES = {
    "time_ns": 1.0,
    **dict.fromkeys(("time_ms", "timestamp", "sensor_timestamp"), 1e6),
    **dict.fromkeys(("time", "time_s", "t"), 1e9),
}
_PLACES = {
    axis: (
        *(f"{axis}_{unit}" for unit in ("mm", "cm", "m")),
        *(axis, f"spline_{axis}", f"pos_{axis}", f"position_{axis}"),
    )
    for axis in "xyz"
}
_UNITS = {"_mm": 1.0, "_cm": 10.0, "_m": 1000.0}  # mm, by how a column's name ends
_PRESSURES = ("pressure", "sensor_pressure", "p", "force", "force_n")
_STROKES = ("idx", "stroke", "stroke_id")
_AZIMUTHS = ("azimuth", "sensor_azimuth", "azimuth_deg")
_QUATERNION = ("qw", "qx", "qy", "qz")
_OBJECT = ("object_x_mm", "object_y_mm", "object_z_mm", *(f"object_{q}" for q in _QUATERNION))
_CONTACT = ("contact_x_mm", "contact_y_mm", "contact_z_mm")
_EXACT = ("time_ns", "buttons")
_LARGEST = 1e9
_TOO_FAST_MS = 0.05
"""A pad read more often than every 0.05 ms does not exist: such steps are seconds."""


def read_csv(lines: Lines, name: str, *, scale: float, y_down: bool) -> Recording:
    """The recording in a table with named columns.

    Parameters
    ----------
    lines : Lines
    name : str
        For messages.
    scale : float
        mm per unit of x, y and z of a pad, where their columns do not say it.
    y_down : bool
        Whether y of a pad grows downwards where its column does not say a unit.

    Raises
    ------
    RecordingError
        ``name:line: what is X; expected Y``.
    """
    filled = ((number, text.strip()) for number, text in lines if text.strip())
    number, text = next(filled, (1, ""))
    header: dict[str, Any] = {}
    if text.startswith("#"):
        header = _header(text[1:], f"{name}:{number}")
        number, text = next(filled, (number + 1, ""))
    delimiter = max(",;\t", key=text.count)
    names = [cell.strip().strip('"').lower() for cell in text.split(delimiter)]
    if len(set(names)) != len(names) or not any(time in names for time in _TIMES):
        raise RecordingError(
            "{name}:{number}: columns are {names}; expected distinct names, among them one of "
            "{times}",
            name=name,
            number=number,
            names=", ".join(names)[:200],
            times=", ".join(_TIMES),
        )
    table = NumberTable(names, name, _EXACT, _CONTACT)
    table.read(lines, delimiter, partial(_cells, delimiter=delimiter))
    return _assemble(table, header, scale, y_down)


def read_plain_table(lines: Lines, name: str, *, scale: float, y_down: bool) -> Recording:
    """The pad recording in lines of ``time x y pressure``: s, units of `scale`, and 0 to 1.

    Raises
    ------
    RecordingError
        ``name:line: what is X; expected Y``.
    """
    table = NumberTable(["time", "x", "y", "pressure"], name)
    table.read(lines, None, _words, "#")
    return _assemble(table, {}, scale, y_down)


def _cells(line: str, delimiter: str) -> list[str] | None:
    """The cells of a line; None where it is blank."""
    row = line.strip()
    return [cell.strip().strip('"') for cell in row.split(delimiter)] if row else None


def _words(line: str) -> list[str] | None:
    """The cells of a line that white space stands between; None where it is blank or a comment."""
    return None if line.startswith("#") else line.split() or None


def _header(text: str, where: str) -> dict[str, Any]:
    if not text.strip().startswith("{"):
        return {}
    try:
        header = json.loads(text)
    except (ValueError, RecursionError) as cause:
        raise RecordingError(
            "{where}: the header is not JSON ({cause})", where=where, cause=cause
        ) from None
    result: dict[str, Any] = header
    return result


def _assemble(table: NumberTable, header: dict[str, Any], scale: float, y_down: bool) -> Recording:
    if not len(table):
        raise RecordingError(
            "{table}: there are no samples; expected at least one",
            table=table.name,
        )
    is_posed = table.column("qw") is not None
    if is_posed:
        scale, y_down = 1.0, False
    for axis in "xyz":
        _check_place(table, axis)
    told: list[str] = []
    if not is_posed and scale == MM_PER_PIXEL and y_down:
        scale, y_down, told = _pad_unit(table)
    y = table.column(*_PLACES["y"])
    assert y is not None, "it was checked"
    up = 1.0 if _unit_of(y[0]) or not y_down else -1.0
    changes = _changes(table)
    time_ns, notes = _times(table, np.concatenate([[0], changes]))
    notes = [*notes, *told]
    table.let_go(*_TIMES, *_STROKES)
    if notes:
        header = {**header, "notes": [*notes_of(header), *notes]}
    buttons = table.column("buttons")
    pressed = None if buttons is None else table.check("buttons", buttons[1], 0, 2**31 - 1)
    pressure = _pressures(table)
    table.let_go(*_PRESSURES)
    try:
        if is_posed:
            position = np.stack(list(_places(table, scale, up)), axis=1)
            return _posed(table, header, time_ns, position, pressure, pressed)
        orientation = _leaning(table, up)
        if table.column(*_AZIMUTHS) is None:
            header = {"azimuth": "dragged", **header}
        if pressure is None:
            pressure = np.full(len(table), 0.5)
        lifts = Lifts(time_ns, pressure, changes - 1)
        position = lifts.put_columns(_places(table, scale, up))
        return Recording(
            lifts.put_times(time_ns),
            position,
            lifts.put(orientation),
            lifts.put_pressure(pressure),
            **({} if pressed is None else {"buttons": lifts.put(pressed)}),
            header={"space": "pad", **header},
        )
    except RecordingError as cause:
        raise RecordingError("{table}: {cause}", table=table.name, cause=cause) from None


def _changes(table: NumberTable) -> AnyArray:
    """First samples of all strokes but the first."""
    found = table.column(*_STROKES)
    if found is None:
        return np.array([], np.int64)
    stroke = found[1]
    return np.flatnonzero(stroke[1:] != stroke[:-1]) + 1


def _posed(
    table: NumberTable,
    header: dict[str, Any],
    time_ns: AnyArray,
    position: AnyArray,
    pressure: AnyArray | None,
    buttons: AnyArray | None,
) -> Recording:
    orientation = _columns(table, _QUATERNION)
    given = {} if buttons is None else {"buttons": buttons}
    if table.column(_OBJECT[0]):
        held = _columns(table, _OBJECT)
        given |= {"object_position": held[:, :3], "object_orientation": held[:, 3:]}
    contact = _columns(table, _CONTACT) if table.column(_CONTACT[0]) else None
    return Recording(
        time_ns, position, orientation, pressure, header=header, contact=contact, **given
    )


def _columns(table: NumberTable, names: tuple[str, ...]) -> AnyArray:
    checked = []
    for wanted in names:
        found = table.column(wanted)
        if found is None:
            raise RecordingError("there is no column {wanted!r}", wanted=wanted)
        checked.append(table.check(*found, -_LARGEST, _LARGEST))
    return np.stack(checked, axis=1)


def _unit_of(column: str) -> float | None:
    """Length in mm that a column's name says it counts in; None where it says none."""
    return _UNITS.get(column[column.rfind("_") :]) if "_" in column else None


def _pad_unit(table: NumberTable) -> tuple[float, bool, list[str]]:
    """Scale and direction of y of a pad that does not tell them, and what is to be told of it."""
    found = table.column(*_PLACES["x"])
    if found is None or _unit_of(found[0]):
        return MM_PER_PIXEL, True, []
    force, height = table.column("force", "force_n"), table.column(*_PLACES["z"])
    if force is None and height is None:
        note = (
            "x and y are taken for pixels of 1/96 inch, y downwards, as a screen counts; columns "
            "named x_mm and y_mm are mm, y upwards"
        )
        return MM_PER_PIXEL, True, [note]
    reason = "z" if force is None else "a force in newtons"
    notes = [f"x and y are taken for mm, y upwards, for there is {reason}"]
    if height is not None and table.column(*_PRESSURES) is not None:
        notes.append("how deep the brush goes is told by its pressure, not by z")
    return 1.0, False, notes


def _check_place(table: NumberTable, axis: str) -> None:
    found = table.column(*_PLACES[axis])
    if found is not None:
        table.check(*found, -_LARGEST, _LARGEST)
    elif axis != "z":
        names = ", ".join(_PLACES[axis])
        raise RecordingError(
            "{table}: there is no column for {axis}; expected one of {names}",
            table=table.name,
            axis=axis,
            names=names,
        )


def _places(table: NumberTable, scale: float, up: float) -> Iterator[AnyArray]:
    """x, y and z in mm, y upwards; each is forgotten by the table when the next is asked for."""
    for axis in "xyz":
        found = table.column(*_PLACES[axis])
        if found is None:
            yield np.zeros(len(table))
            continue
        name, values = found
        table.let_go(*_PLACES[axis])
        del found
        unit = _unit_of(name) or scale
        if unit != 1.0:
            values = values * unit
        yield -values if axis == "y" and up < 0.0 else values


def _pressures(table: NumberTable) -> AnyArray | None:
    found = table.column(*_PRESSURES)
    if found is None:
        return None
    name, values = found
    most = MAX_FORCE_N if name.startswith("force") else 1.0
    checked = table.check(name, values, 0.0, most)
    return checked if most == 1.0 else checked / most


def _leaning(table: NumberTable, up: float) -> AnyArray:
    """Orientations from the lean; upright, the tip pointing up left, where it is not known."""
    angles, known = [], False
    for key, otherwise in (
        ("azimuth", DEFAULT_LEAN * up),
        ("altitude", 0.5 * math.pi),
        ("rotation", 0.0),
    ):
        found = table.column(key, f"sensor_{key}", f"{key}_deg")
        values = np.full(1, otherwise) if found is None else found[1]
        known = known or found is not None
        if found is not None and found[0].endswith("_deg"):
            values = np.radians(values)
        angles.append(table.check(key, values, -100.0, 100.0))
    if known:
        angles = [np.broadcast_to(values, len(table)) for values in angles]
    same = orientations_from_angles(angles[0] * up, angles[1], angles[2])
    return np.broadcast_to(same, (len(table), 4))


def _times(table: NumberTable, starts: AnyArray) -> tuple[AnyArray, list[str]]:
    """Times in ns, and what had to be done to them; `starts` are the strokes' first samples."""
    found = table.column(*_TIMES)
    assert found is not None, "the reader asks for one"
    name, values = found
    late = np.flatnonzero(values[1:] < values[:-1])
    if len(late):
        i = int(late[0]) + 1
        raise RecordingError(
            "{table}:{line}: {name} is {value:.17g}; expected at least {before:.17g}, the time "
            "before it",
            table=table.name,
            line=table.line(i),
            name=name,
            value=values[i],
            before=values[i - 1],
        )
    if name == "time_ns":
        times, notes = values, list[str]()
    else:
        times, notes = _rounded(values, _TIMES[name], starts)
    times, n_moved = spread_ties(times)
    if n_moved:
        notes.append(f"{n_moved} samples shared a time stamp; spread evenly up to the next one")
    tied = np.flatnonzero(times[1:] <= times[:-1])
    if len(tied):
        i = int(tied[0]) + 1
        raise RecordingError(
            "{table}:{line}: more samples share a time than ns are left",
            table=table.name,
            line=table.line(i),
        )
    return times, notes


def _rounded(values: AnyArray, unit: float, starts: AnyArray) -> tuple[AnyArray, list[str]]:
    """ns from the first stamp; strokes that start in ms but go on in s are put right."""
    counts = np.diff(np.append(starts, len(values)))
    total = values - np.repeat(values[starts], counts)
    notes = []
    in_seconds = unit == 1e6 and _starts_in_ms(values, starts, total)
    if in_seconds:
        notes.append("time stamps count in ms between strokes but in s within them")
    total *= 1e9 if in_seconds else unit
    total += np.repeat((values[starts] - values[0]) * unit, counts)
    if len(total) and total[-1] >= 2.0**62:
        raise RecordingError("the times span over 146 years; expected a recording")
    return np.round(total, out=total).astype(np.int64), notes


def _starts_in_ms(values: AnyArray, starts: AnyArray, since: AnyArray) -> bool:
    """Return whether strokes start at times in ms, but count s `since` then."""
    steps = np.diff(since)
    steps = steps[steps > 0]
    if len(steps) < 2 or np.median(steps) >= _TOO_FAST_MS:
        return False
    ends = np.append(starts[1:], len(values)) - 1
    begin = (values[starts] - values[0]) * 1e6
    return bool((begin[1:] > begin[:-1] + (since * 1e9)[ends[:-1]]).all())


def write_csv(recording: Recording) -> Iterator[str]:
    """The lines of a table from which every number reads back exactly."""
    yield "# " + json.dumps(dict(recording.header), allow_nan=False) + "\n"
    pressure = () if recording.pressure is None else ("pressure",)
    names = ["time_ns", "x_mm", "y_mm", "z_mm", *_QUATERNION, *pressure, "buttons", *_OBJECT]
    names += () if recording.contact is None else _CONTACT
    yield ",".join(names) + "\n"
    floats = [recording.position, recording.orientation]
    if recording.pressure is not None:
        floats.append(recording.pressure[:, None])
    left = np.hstack([*floats])
    right = np.hstack([recording.object_position, recording.object_orientation])
    if recording.contact is not None:
        right = np.hstack([right, recording.contact])
    for i in range(len(recording)):
        yield (
            ",".join(
                [
                    str(recording.time_ns[i]),
                    *map(repr, left[i].tolist()),
                    str(recording.buttons[i]),
                    *("" if math.isnan(value) else repr(value) for value in right[i].tolist()),
                ]
            )
            + "\n"
        )
