"""Recordings as tables: CSV with named columns, and plain columns of time, x, y, pressure.

Columns are found by name, without regard to case; others are passed over, which is noted:

==================  ====================================================  ===================
meaning             names                                                 unit
==================  ====================================================  ===================
time                time_ns                                               ns, kept exactly
..                  time_ms; timestamp, sensor_timestamp                  ms
..                  time_s; time, t                                       s
place               x_mm, y_mm, z_mm; x_cm, ...; x_m, ...                 by name, y upwards
..                  x, y, z; spline_x, spline_y; pos_x, pos_y             of pads `scale` and
                                                                          `y_down`; else as _mm
of the tuft's tip   tip_x_mm, ..., with an orientation                    as x, y, z
pressure            pressure, sensor_pressure, p                          0 to 1
..                  force, force_n, fz, fz_n, force_z                     N, 0 to 7.9
lean of the handle  altitude, azimuth, rotation; sensor_altitude, ...     rad
..                  altitude_deg, azimuth_deg, rotation_deg               degrees
orientation         qw, qx, qy, qz                                        unit quaternion
.. of a tool        tool_qw, ...: its z points at the work                unit quaternion
object              object_x_mm ..., object_qw ... (upright without)      as x, y, z
contact             contact_x_mm ..., an empty cell for none              as x, y, z
stroke              idx, stroke, stroke_id                                of pads, a new one lifts
buttons             buttons                                               bits
==================  ====================================================  ===================

A first line ``# {...}`` holds the header as JSON; its ``units`` are those of columns whose names
say none. Tables without quaternions are pads; without an azimuth the surface drags the tip. Of a
pad that tells z or newtons, as robots do and screens do not, x and y are mm, y upwards, unless the
caller says what they are.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from paint3d.brush.presets import load_brush
from paint3d.core.arrays import AnyArray
from paint3d.core.quaternion import matrices_from_quaternions, multiply_quaternions
from paint3d.device.recorded import FORMAT, MAX_FORCE_N, Recording
from paint3d.errors import Message, RecordingError
from paint3d.recording.flat_recording import (
    DEFAULT_LEAN,
    MM_PER_PIXEL,
    Lifts,
    notes_of,
    orientations_from_angles,
    spread_equal_times,
)
from paint3d.recording.number_table import Lines, NumberTable
from paint3d.recording.units import TO_MM, TO_NS, units_of

__all__ = ["read_csv", "read_plain_table", "write_csv"]

_TIMES = {
    "time_ns": 1.0,
    **dict.fromkeys(("time_ms", "timestamp", "sensor_timestamp"), 1e6),
    **dict.fromkeys(("time", "time_s", "t"), 1e9),
}
_COORDINATES = {
    axis: (
        *(f"{axis}_{unit}" for unit in ("mm", "cm", "m")),
        *(axis, f"spline_{axis}", f"pos_{axis}", f"position_{axis}"),
    )
    for axis in "xyz"
}
_UNITS = {"_mm": 1.0, "_cm": 10.0, "_m": 1000.0}  # mm, by how a column's name ends
_FORCES = ("force", "force_n", "fz", "fz_n", "force_z")
_PRESSURES = ("pressure", "sensor_pressure", "p", *_FORCES)
_STROKES = ("idx", "stroke", "stroke_id")
_AZIMUTHS = ("azimuth", "sensor_azimuth", "azimuth_deg")
_QUATERNION = ("qw", "qx", "qy", "qz")
_OBJECT = ("object_x_mm", "object_y_mm", "object_z_mm", *(f"object_{q}" for q in _QUATERNION))
_CONTACT = ("contact_x_mm", "contact_y_mm", "contact_z_mm")
_PREFIXES = ("tip_", "contact_", "object_")
_MAY_BE_EMPTY = tuple(f"contact_{axis}{unit}" for axis in "xyz" for unit in (*_UNITS, ""))
_TURNED = (0.0, 1.0, 0.0, 0.0)  # half a turn about x: from a z at the work to one up the handle
_EXACT = ("time_ns", "buttons")
_LARGEST = 1e9
_TOO_FAST_MS = 0.05
"""A pad read more often than every 0.05 ms does not exist: such steps are seconds."""


_LEAST_MM = 0.5
"""A path or a stroke that spans less is hardly in the unit that it is taken for."""
_NOISE_N, _NOISE_FRACTION = 0.2, 0.1
"""Forces up to 0.2 N, and up to a tenth of the greatest, may be noise of a sensor."""
_TOUCH_NS = 200_000_000
"""A touch by noise is shorter."""


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
        header = _parse_header(text[1:], f"{name}:{number}")
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
            hint="in Python, painter.stroke(points, pressure=...) needs no times",
        )
    table = NumberTable(names, name, _EXACT, _MAY_BE_EMPTY)
    table.read(lines, delimiter, partial(_split_cells, delimiter=delimiter))
    return _assemble(table, header, scale, y_down)


def read_plain_table(lines: Lines, name: str, *, scale: float, y_down: bool) -> Recording:
    """The pad recording in lines of ``time x y pressure``: s, units of `scale`, and 0 to 1.

    Raises
    ------
    RecordingError
        ``name:line: what is X; expected Y``.
    """
    table = NumberTable(["time", "x", "y", "pressure"], name)
    table.read(lines, None, _split_words, "#")
    return _assemble(table, {}, scale, y_down)


def _split_cells(line: str, delimiter: str) -> list[str] | None:
    """The cells of a line; None where it is blank."""
    row = line.strip()
    return [cell.strip().strip('"') for cell in row.split(delimiter)] if row else None


def _split_words(line: str) -> list[str] | None:
    """The cells of a line that white space stands between; None where it is blank or a comment."""
    return None if line.startswith("#") else line.split() or None


def _parse_header(text: str, where: str) -> dict[str, Any]:
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
    both = (_QUATERNION, tuple(f"tool_{q}" for q in _QUATERNION))
    quaternion = next((names for names in both if _first_present(table, names)), None)
    units = _check_units(table, header)
    header = {key: value for key, value in header.items() if key != "units"}
    notes: list[str] = []
    if quaternion is not None:
        scale, y_down = TO_MM[units.get("position", "mm")], False
        tip = "tip_" if _has_columns(table, "tip_") else ""
        if "position" not in units:
            notes += _unit_notes(table, tip)
    else:
        if _has_columns(table, "tip_"):
            raise RecordingError(
                "{table}: a tip is told without an orientation; expected columns {names} or those "
                "of a tool whose z points at the work, {tools}",
                table=table.name,
                names=", ".join(both[0]),
                tools=", ".join(both[1]),
            )
        for axis in "xyz":
            column = table.column(*_COORDINATES[axis])
            if column is not None:
                table.check(*column, -_LARGEST, _LARGEST)
            elif axis != "z":
                known = ", ".join(_COORDINATES[axis])
                raise RecordingError(
                    "{table}: there is no column for {axis}; expected one of {names}",
                    table=table.name,
                    axis=axis,
                    names=known,
                )
        if "position" in units:
            scale, y_down = TO_MM[units["position"]], False
        elif scale == MM_PER_PIXEL and y_down:
            scale, y_down, notes = _guess_pad_unit(table)
        if table.column(*_COORDINATES["z"]) and table.column(*_PRESSURES):
            notes.append(
                Message(
                    "without an orientation (qw, qx, qy, qz) x and y are those of a sheet that is "
                    "laid on the object; how deep the brush goes is told by its pressure, not by z"
                )
            )
        y = table.column(*_COORDINATES["y"])
        assert y is not None, "it was checked"
        up = 1.0 if _unit_of(y[0]) or not y_down else -1.0
    strokes = table.column(*_STROKES)
    stroke = np.zeros(0) if strokes is None else strokes[1]
    changes = np.flatnonzero(stroke[1:] != stroke[:-1]) + 1  # first samples of later strokes
    time_ns, time_notes = _read_times(table, np.concatenate([[0], changes]), units.get("time"))
    notes = [*time_notes, *notes]
    table.drop(*_TIMES, *_STROKES)
    buttons = table.column("buttons")
    pressed = None if buttons is None else table.check("buttons", buttons[1], 0, 2**31 - 1)
    pressure = _read_pressure(table, time_ns, notes)
    table.drop(*_PRESSURES)
    try:
        if quaternion is not None:
            given = {} if pressed is None else {"buttons": pressed}
            return _pose_recording(
                table, header, notes, time_ns, quaternion, tip, scale, pressure, given
            )
        orientation = _read_orientation(table, up)
        if table.column(*_AZIMUTHS) is None:
            header = {"azimuth": "dragged", **header}
        if pressure is None:
            pressure = np.full(len(table), 0.5)
        lifts = Lifts(time_ns, pressure, changes - 1)
        position = lifts.put_columns(_read_coordinates(table, scale, up))
        pressure = lifts.put_pressure(pressure)
        notes += [*_scale_notes(position, pressure, ""), *_unread_notes(table)]
        return Recording(
            lifts.put_times(time_ns),
            position,
            lifts.put(orientation),
            pressure,
            **({} if pressed is None else {"buttons": lifts.put(pressed)}),
            header=_with_notes({"space": "pad", **header}, notes),
        )
    except RecordingError as cause:
        raise RecordingError("{table}: {cause}", table=table.name, cause=cause) from None


def _with_notes(header: dict[str, Any], notes: list[str]) -> dict[str, Any]:
    """The header with these notes added to its own."""
    return {**header, "notes": [*notes_of(header), *notes]} if notes else header


def _unread_notes(table: NumberTable) -> list[str]:
    """Notes on columns that are ignored."""
    names = ", ".join(table.unread())[:200]
    return [Message("columns not read: {names}", names=names)] if names else []


def _check_units(table: NumberTable, header: dict[str, Any]) -> dict[str, Any]:
    """Units of positions and times in the header, which may not contradict the columns' names."""
    try:
        units = units_of(header, tuple(TO_NS))
    except RecordingError as cause:
        raise RecordingError("{table}: {cause}", table=table.name, cause=cause) from None
    unknown = set(units) - {"position", "time", "force"}
    if unknown:
        raise RecordingError(
            "{table}: units has {unknown}; expected position, time, force",
            table=table.name,
            unknown=", ".join(sorted(unknown)),
        )
    coordinates = [f"{prefix}{axis}" for prefix in ("", *_PREFIXES) for axis in "xyz"]
    for key, starts, wanted in (("position", coordinates, TO_MM), ("time", ["time"], TO_NS)):
        columns = [
            f"{start}_{unit}" for start in starts for unit in wanted if unit != units.get(key, unit)
        ]
        other = _first_present(table, tuple(columns))
        if other is not None:
            raise RecordingError(
                "{table}: units: {key} is {unit}, and a column is {column}; expected one unit",
                table=table.name,
                key=key,
                unit=units[key],
                column=other,
            )
    return units


def _pose_recording(
    table: NumberTable,
    header: dict[str, Any],
    notes: list[str],
    time_ns: AnyArray,
    quaternion: tuple[str, ...],
    tip: str,
    scale: float,
    pressure: AnyArray | None,
    given: dict[str, AnyArray],
) -> Recording:
    """A recording of poses; `tip` begins the names of coordinates that are the tuft's tip."""
    orientation = _stack_columns(table, quaternion)
    if quaternion != _QUATERNION:
        orientation = multiply_quaternions(orientation, np.array(_TURNED))
    position = _read_positions(table, tip, scale)
    ours = header.get("format") == FORMAT  # in the unit that it says
    notes += [] if ours else _scale_notes(position, pressure, tip)
    contact = None
    if _has_columns(table, "contact_"):
        contact = _read_positions(table, "contact_", scale)
        notes += [] if ours else _scale_notes(contact, pressure, "contact_")
    if tip:
        if pressure is not None and contact is None:
            contact = position
        length_mm = load_brush("full").length_mm
        position = position + length_mm * matrices_from_quaternions(orientation)[:, :, 2]
        header = {**header, "tuft_mm": length_mm}
    if contact is not None and pressure is None and not np.isnan(contact).all():
        raise RecordingError(
            "a contact is given without a force (columns not read: {unread}); expected a column "
            "{names}",
            unread=", ".join(table.unread())[:200] or "-",
            names=", ".join(_PRESSURES),
        )
    if _has_columns(table, "object_"):
        given = given | {"object_position": _read_positions(table, "object_", scale)}
        names = tuple(f"object_{q}" for q in _QUATERNION)
        if _first_present(table, names):
            given["object_orientation"] = _stack_columns(table, names)
    notes += _unread_notes(table)
    header = _with_notes(header, notes)
    return Recording(
        time_ns, position, orientation, pressure, header=header, contact=contact, **given
    )


def _stack_columns(table: NumberTable, names: tuple[str, ...]) -> AnyArray:
    checked = []
    for wanted in names:
        column = table.column(wanted)
        if column is None:
            raise RecordingError("there is no column {wanted!r}", wanted=wanted)
        checked.append(table.check(*column, -_LARGEST, _LARGEST))
    return np.stack(checked, axis=1)


def _coordinate_names(prefix: str, axis: str) -> tuple[str, ...]:
    """Names that a column of coordinates may have."""
    if prefix:
        return tuple(f"{prefix}{axis}{unit}" for unit in (*_UNITS, ""))
    return _COORDINATES[axis]


def _has_columns(table: NumberTable, prefix: str) -> bool:
    return any(name in table.names for axis in "xyz" for name in _coordinate_names(prefix, axis))


def _read_positions(table: NumberTable, prefix: str, scale: float) -> AnyArray:
    """Positions (N, 3) in mm; z of the brush's own is 0 where there is no column for it."""
    columns = []
    for axis in "xyz":
        column = table.column(*_coordinate_names(prefix, axis))
        if column is None and (prefix or axis != "z"):
            raise RecordingError(
                "there is no column for {axis}; expected one of {names}",
                axis=f"{prefix}{axis}",
                names=", ".join(_coordinate_names(prefix, axis)),
            )
        if column is None:
            columns.append(np.zeros(len(table)))
        else:
            values = table.check(*column, -_LARGEST, _LARGEST)
            columns.append(values * (_unit_of(column[0]) or scale))
    return np.stack(columns, axis=1)


def _unit_notes(table: NumberTable, tip: str) -> list[str]:
    """Notes on poses whose columns give no unit."""
    of = [_coordinate_names(prefix, axis) for prefix in (tip, *_PREFIXES[1:]) for axis in "xyz"]
    bare = [
        name
        for name in (_first_present(table, names) for names in of)
        if name and not _unit_of(name)
    ]
    if not bare:
        return []
    return [
        Message(
            "{columns} are taken for mm, along the axes of the object (z upwards on a built-in "
            "one); metres are named {metres}",
            columns=", ".join(bare),
            metres=", ".join(f"{tip}{axis}_m" for axis in "xyz"),
        )
    ]


def _first_present(table: NumberTable, names: tuple[str, ...]) -> str | None:
    """Name of the first of these columns that is present, or None."""
    return next((name for name in names if name in table.names), None)


def _scale_notes(positions: AnyArray, pressure: AnyArray | None, prefix: str) -> list[str]:
    """Notes on a path (N, 3), mm, that is hardly in the unit it is taken for."""
    metres = ", ".join(f"{prefix}{axis}_m" for axis in "xyz")
    what = ", ".join(f"{prefix}{axis}" for axis in "xyz")
    if np.isnan(positions).all():
        return []
    span = float((np.nanmax(positions, axis=0) - np.nanmin(positions, axis=0)).max())
    if 0.0 < span < _LEAST_MM:
        return [
            Message(
                "{what} span {span:.2g} mm in all; expected metres? name the columns {metres}",
                what=what,
                span=span,
                metres=metres,
            )
        ]
    starts, ends = _runs(np.ones(len(positions), bool) if pressure is None else pressure > 0.0)
    if span == 0.0 or not len(starts):
        return []
    cuts = np.column_stack([starts, ends]).ravel()
    cuts = cuts[:-1] if cuts[-1] == len(positions) else cuts
    high, low = (f.reduceat(positions, cuts, axis=0)[::2] for f in (np.fmax, np.fmin))
    most = float(np.nan_to_num(high - low).max())
    if not 0.0 < most < _LEAST_MM:
        return []
    return [
        Message(
            "no stroke spans more than {span:.2g} mm in {what}; expected metres? name the columns "
            "{metres}",
            what=what,
            span=most,
            metres=metres,
        )
    ]


def _runs(flags: AnyArray) -> tuple[AnyArray, AnyArray]:
    """First samples of runs of true flags (N,), and those after their last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    return edges[::2], edges[1::2]


def _unit_of(column: str) -> float | None:
    """Length in mm of the unit in a column's name, or None."""
    return _UNITS.get(column[column.rfind("_") :]) if "_" in column else None


def _guess_pad_unit(table: NumberTable) -> tuple[float, bool, list[str]]:
    """Scale of a pad that gives none, whether its y grows downwards, and notes on both."""
    x = table.column(*_COORDINATES["x"])
    if x is None or _unit_of(x[0]):
        return MM_PER_PIXEL, True, []
    force, height = table.column(*_FORCES), table.column(*_COORDINATES["z"])
    if force is None and height is None:
        note = (
            "x and y are taken for pixels of 1/96 inch, y downwards, as a screen counts; columns "
            "named x_mm and y_mm are mm, y upwards"
        )
        return MM_PER_PIXEL, True, [note]
    reason = "z" if force is None else "a force in newtons"
    notes = [f"x and y are taken for mm, y upwards, for there is {reason}"]
    return 1.0, False, notes


def _read_coordinates(table: NumberTable, scale: float, up: float) -> Iterator[AnyArray]:
    """Yield x, y and z in mm, y upwards; the table drops each as it is read, to save memory."""
    for axis in "xyz":
        column = table.column(*_COORDINATES[axis])
        if column is None:
            yield np.zeros(len(table))
            continue
        name, values = column
        table.drop(*_COORDINATES[axis])
        del column
        unit = _unit_of(name) or scale
        if unit != 1.0:
            values = values * unit
        yield -values if axis == "y" and up < 0.0 else values


def _read_pressure(table: NumberTable, time_ns: AnyArray, notes: list[str]) -> AnyArray | None:
    """Pressures, 0 to 1; of a force without its sensor's noise, which is added to `notes`."""
    column = table.column(*_PRESSURES)
    if column is None:
        return None
    name, values = column
    if name not in _FORCES:
        return table.check(name, values, 0.0, 1.0)
    noise = min(_NOISE_N, _NOISE_FRACTION * float(np.abs(values).max()))
    if values.max() <= noise and values.min() < -noise:
        values = -values
        notes.append(Message("{name} is negative throughout: its sign is turned", name=name))
    low = values < 0.0
    beyond = np.flatnonzero(values < -noise)
    if len(beyond):
        raise RecordingError(
            "{table}:{line}: {name} is {value:.6g}; expected 0 to {most:g} N, how hard the brush "
            "presses: take the offset off that the sensor has in the air, and turn the sign where "
            "pressing is negative",
            table=table.name,
            line=table.line(int(beyond[0])),
            name=name,
            value=column[1][beyond[0]],
            most=MAX_FORCE_N,
        )
    if low.any():
        notes.append(
            Message(
                "{name} is {low:.2g} N in a sample: it counts as 0",
                "{name} lies between {low:.2g} and 0 N in {n} samples: they count as 0",
                name=name,
                low=float(values.min()),
                n=int(np.count_nonzero(low)),
            )
        )
        values = np.where(low, 0.0, values)
    values = table.check(name, values, 0.0, MAX_FORCE_N)
    starts, ends = _runs(values > 0.0)
    if len(starts):
        cuts = np.column_stack([starts, ends]).ravel()
        peaks = np.maximum.reduceat(values, cuts[:-1] if cuts[-1] == len(values) else cuts)[::2]
        touches = (peaks <= noise) & (time_ns[ends - 1] - time_ns[starts] < _TOUCH_NS)
        if touches.any():
            values = values.copy()
            for first, end in zip(starts[touches], ends[touches], strict=True):
                values[first:end] = 0.0
            notes.append(
                Message(
                    "a touch of less than {seconds:g} s and at most {noise:.2g} N is left out: "
                    "noise in the air",
                    "{n} touches of less than {seconds:g} s and at most {noise:.2g} N are left "
                    "out: noise in the air",
                    n=int(np.count_nonzero(touches)),
                    seconds=_TOUCH_NS * 1e-9,
                    noise=noise,
                )
            )
    return values / MAX_FORCE_N


def _read_orientation(table: NumberTable, up: float) -> AnyArray:
    """Orientations from the lean; upright, the tip pointing up left, where it is not known."""
    angles, known = [], False
    for key, otherwise in (
        ("azimuth", DEFAULT_LEAN * up),
        ("altitude", 0.5 * math.pi),
        ("rotation", 0.0),
    ):
        column = table.column(key, f"sensor_{key}", f"{key}_deg")
        values = np.full(1, otherwise) if column is None else column[1]
        known = known or column is not None
        if column is not None and column[0].endswith("_deg"):
            values = np.radians(values)
        angles.append(table.check(key, values, -100.0, 100.0))
    if known:
        angles = [np.broadcast_to(values, len(table)) for values in angles]
    same = orientations_from_angles(angles[0] * up, angles[1], angles[2])
    return np.broadcast_to(same, (len(table), 4))


def _read_times(
    table: NumberTable, starts: AnyArray, unit: str | None
) -> tuple[AnyArray, list[str]]:
    """Times in ns, and notes on corrections.

    `starts` are the strokes' first samples; `unit` is the header's, for a column that has none.
    """
    column = table.column(*_TIMES)
    assert column is not None, "the reader asks for one"
    name, values = column
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
        is_bare = name not in ("time_ms", "time_s")
        unit_ns = TO_NS[unit] if unit is not None and is_bare else _TIMES[name]
        times, notes = _times_in_ns(values, unit_ns, starts)
    times, n_moved = spread_equal_times(times)
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


def _times_in_ns(values: AnyArray, unit: float, starts: AnyArray) -> tuple[AnyArray, list[str]]:
    """Times in ns from the first stamp; strokes that start in ms but go on in s are corrected."""
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
