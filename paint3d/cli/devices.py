"""The hands' devices: what is plugged in, what it says, how steadily, and a recording of it."""

from __future__ import annotations

import argparse
import re
import select
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from paint3d.app.model.persistence.settings import load_settings, stored_calibration
from paint3d.cli.options import (
    add_actions,
    add_force_option,
    add_stylus_option,
    check_output_file,
    check_output_folder,
    check_overwriting,
    parse_number,
)
from paint3d.core.ending import signals_handled_by
from paint3d.device.force.force_port import HidForcePort
from paint3d.device.force.port_reader import PortReader
from paint3d.device.hid_nodes import HidNode, list_nodes
from paint3d.device.hot_plug import PluggedDevices
from paint3d.device.sample import StylusReading
from paint3d.errors import DeviceError, Paint3DError
from paint3d.haptics.stylus_choice import DetectedStylus, find_stylus, key_of_node
from paint3d.pose.calibration import DeviceCalibration
from paint3d.pose.mouse_settings import MouseSettings

if TYPE_CHECKING:
    from paint3d.device.force.port_reader import PortReader
    from paint3d.device.hid_nodes import HidNode
    from paint3d.device.sample import DeviceSample
    from paint3d.pose.calibration import DeviceCalibration
    from paint3d.pose.touching import Touches
    from paint3d.pose.two_hands import TwoHands

__all__ = [
    "EXAMPLES",
    "OpenedDevices",
    "add_arguments",
    "add_calibrate",
    "add_set",
    "calibrate",
    "rounds",
    "run",
    "set_devices",
]

# ---- Opening -------------------------------------------------------------------------------------
# HID devices, and a stylus that is reached by a library or a service.


_NOTHING = "no 6-DOF mouse, stylus or pen tablet is plugged in"
_OPENED_KINDS = {"auto": ("mouse", "stylus", "pen"), "hid": ("mouse", "stylus")}

Log = Callable[[HidNode, bytes, int, bytes], None]


class OpenedDevices(PluggedDevices):
    """The chosen devices that are plugged in, read by the user's settings.

    Parameters
    ----------
    stylus : str
        See `find_stylus`; "auto" takes HID styli and pens, and others where there is none of them.
    log : callable, optional
        See `PluggedDevices`.

    Attributes
    ----------
    mouse : MouseSettings
        The user's.
    reader : PortReader or None
        Of a stylus that is not read by hidapi.

    Raises
    ------
    DeviceError
        If no device is there, not the chosen one, or none could be opened.
    """

    def __init__(self, stylus: str = "auto", log: Log | None = None) -> None:
        settings, problem = load_settings()
        if problem is not None:
            sys.stderr.write(f"{problem}\n")
        self.mouse = MouseSettings.from_dict(settings.mouse)
        self.reader: PortReader | None = None
        self._other: DetectedStylus | None = None  # reached by a library or a service
        kinds = _OPENED_KINDS.get(stylus, ("mouse",))
        if stylus == "hid":
            find_stylus("hid")
        super().__init__(lambda: list_nodes(kinds), log=log, deflection=self.mouse.deflection())
        try:
            if stylus not in ("hid", "none") and not (stylus == "auto" and self.styli()):
                other = find_stylus(stylus)
                if other is not None and not isinstance(other.port, HidForcePort):
                    self._other, self.reader = other, PortReader(other.port, other.name)
        except BaseException:
            self.stop()
            raise
        if not self.names():
            failures = list(self.failures.values())
            self.stop()
            raise DeviceError(failures[0] if failures else _NOTHING)

    def names(self) -> list[str]:
        """Return the names of the open devices."""
        others = [] if self.reader is None else [self.reader.name]
        return [node.name for node in self.nodes()] + others

    def take_stylus(self) -> list[StylusReading]:
        """Return readings of all styli, in the order of their times."""
        others = [] if self.reader is None else self.reader.take()
        return sorted([*super().take_stylus(), *others], key=lambda reading: reading.time_ns)

    def key(self) -> str:
        """Return the key of the first stylus or pen that is open.

        Raises
        ------
        DeviceError
            If there is none.
        """
        if self._other is not None:
            return self._other.key
        for node in self.nodes():
            if node.kind != "mouse":
                return key_of_node(node)
        raise DeviceError("no stylus or pen tablet is open; expected one for the right hand")

    def calibration(self) -> DeviceCalibration:
        """Return the stylus's frame in the world: as it was calibrated, else its own axes."""
        frame = DeviceCalibration() if self._other is None else self._other.frame
        if self._other is None and all(node.kind == "mouse" for node in self.nodes()):
            return frame
        return stored_calibration(self.key()) or frame

    def stop(self) -> None:
        """Stop looking and close everything."""
        if self.reader is not None:
            self.reader.stop()
        super().stop()


# ---- Calibration ---------------------------------------------------------------------------------
# `paint3d devices calibrate`: touch known points, print the error, save the stylus's frame.


_CORNERS = ("near left corner", "near right corner", "far right corner", "far left corner")

_PATIENCE_S = 600.0


def _parse_sheet(text: str) -> tuple[float, float]:
    match = re.fullmatch(r"(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)", text)
    if match is None or not all(20.0 <= float(side) <= 2000.0 for side in match.groups()):
        raise argparse.ArgumentTypeError(
            f"{text!r} is no sheet; expected WIDTHxDEPTH in mm, each 20 to 2000, such as 210x148"
        )
    return float(match[1]), float(match[2])


def _parse_point(text: str) -> tuple[float, ...]:
    try:
        point = tuple(float(part) for part in text.split(","))
    except ValueError:
        point = ()
    if len(point) != 3 or not all(abs(part) <= 1e4 for part in point):
        raise argparse.ArgumentTypeError(f"{text!r} is no point; expected X,Y,Z in mm")
    return point


def add_calibrate(parser: argparse.ArgumentParser) -> None:
    """Add the options of this deed."""
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--sheet",
        metavar="WxD",
        type=_parse_sheet,
        default=(210.0, 148.0),
        help="touch the corners of a sheet on the table so wide and deep, mm; its middle becomes "
        "the world's origin, x to the right, y away, z up (default: 210x148, A5)",
    )
    where.add_argument(
        "--point",
        metavar="X,Y,Z",
        type=_parse_point,
        action="append",
        help="touch these points of the world instead, mm; three or more (--point=-90,0,0)",
    )
    parser.add_argument("--scaled", action="store_true", help="let lengths be scaled, too")
    parser.add_argument(
        "--out", metavar="FILE", type=Path, help="keep it in a file of your own (.json) instead"
    )
    add_stylus_option(parser, " (default: the first there is)")
    add_force_option(parser)


def calibrate(options: argparse.Namespace) -> None:
    """Ask for touches of the points, fit the device's frame, save it.

    Raises
    ------
    DeviceError
        If there is no stylus, or the touches give no frame: by how much.
    """
    from paint3d.app.model.persistence.settings import store_calibration
    from paint3d.pose.calibration import save_calibration
    from paint3d.pose.touching import Touches, sheet_corners

    if options.out is not None:
        check_output_file(options.out, (".json",))
        check_overwriting((options.out,), (), force=options.force)
    points = options.point or sheet_corners(*options.sheet)
    touches = Touches(points)
    names = (
        list(_CORNERS) if options.point is None else [f"point {k + 1}" for k in range(len(points))]
    )
    devices = OpenedDevices(options.stylus or "auto")
    try:
        key = devices.key()
        _touch_all(devices, touches, names)
    finally:
        devices.stop()
    fitted = touches.fit(scaled=options.scaled)
    if options.out is not None:
        save_calibration(fitted.calibration, options.out)
        file = options.out
    else:
        file = store_calibration(key, fitted.calibration)
    errors = ", ".join(f"{error:.2f}" for error in fitted.errors_mm)
    residual = fitted.calibration.residual_mm
    sys.stdout.write(f"{file}: {residual:.2f} mm off (root mean square of {errors})\n")


def _touch_all(devices: OpenedDevices, touches: Touches, names: list[str]) -> None:
    """Ask for point after point, until all were touched: by a button of the stylus, or Enter."""
    end = time.monotonic() + _PATIENCE_S
    asked, typed = -1, sys.stdin is not None
    if typed:
        try:  # it may be closed, or nothing that can be waited for
            select.select([sys.stdin], [], [], 0.0)
        except (OSError, ValueError):
            typed = False
    while not touches.is_done:
        n = len(touches.touched)
        if n != asked:
            asked = n
            x, y, z = touches.points[n]
            sys.stderr.write(
                f"touch {n + 1} of {len(touches.points)}: the {names[n]} ({x:g}, {y:g}, {z:g}) mm; "
                "hold it still and press the stylus' button, or Enter\n"
            )
            sys.stderr.flush()
        if time.monotonic() > end:
            raise DeviceError(
                "{n} of {names} points were touched in {patience_s:g} s",
                n=n,
                names=len(names),
                patience_s=_PATIENCE_S,
            )
        time.sleep(_TAKE_S)
        try:
            touches.add(devices.take_stylus())
            if typed and select.select([sys.stdin], [], [], 0.0)[0]:
                typed = bool(sys.stdin.readline())
                if typed:
                    touches.touch()
        except DeviceError as cause:
            asked = -1
            sys.stderr.write(f"{cause}\n")
        if devices.reader is not None and devices.reader.gone is not None:
            raise DeviceError(devices.reader.gone)


# ---- Settings ------------------------------------------------------------------------------------
# `paint3d devices set`: settings of the hands' devices, for the studio and for recording.


_ON = {"on": True, "off": False}
_NUMBERS = (
    ("--mouse-speed", "speed_mm_s", "MM/S", 5000.0, "how fast the object moves at full deflection"),
    ("--mouse-turn", "turn_deg_s", "DEG/S", 2800.0, "how fast it turns"),
    ("--mouse-dead-zone", "dead_zone", "SHARE", 0.9, "of the deflection, that counts as rest"),
)


def _number(most: float, least: float = 0.0) -> Any:
    expected = f"{least:g} to {most:g}"
    return lambda text: parse_number(text, "a number", expected, lambda n: least <= n <= most)


def _parse_axes(text: str) -> tuple[str, ...]:
    from paint3d.pose.mouse_settings import parse_axes

    axes: tuple[str, ...] = _as_argument_error(lambda: parse_axes(text))
    return axes


def _parse_button(text: str) -> tuple[int, str]:
    from paint3d.pose.mouse_settings import checked_actions

    number, _, action = text.partition("=")
    if not number.isdecimal() or not 1 <= int(number) <= 31:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no button; expected N=ACTION with N from 1 to 31, or N= for nothing"
        )
    if action:
        _as_argument_error(lambda: checked_actions({int(number) - 1: action}))
    return int(number) - 1, action


def _as_argument_error(parse: Any) -> Any:
    try:
        return parse()
    except Paint3DError as cause:
        raise argparse.ArgumentTypeError(str(cause)) from None


def add_set(parser: argparse.ArgumentParser) -> None:
    """Add the options of this deed."""
    parser.add_argument(
        "--mouse-mode", choices=("object", "camera"), help="whether the cap is the object or you"
    )
    for option, name, what, most, about in _NUMBERS:
        parser.add_argument(option, dest=name, metavar=what, type=_number(most), help=about)
    parser.add_argument(
        "--mouse-curve",
        dest="curve",
        metavar="N",
        type=_number(4.0, 1.0),
        help="exponent of the response: 1 is linear, more is finer near rest",
    )
    parser.add_argument(
        "--mouse-axes",
        dest="axes",
        metavar="LIST",
        type=_parse_axes,
        help="which axis of the cap gives each motion (right, away, up, turns about them), - turns "
        "it round: --mouse-axes=x,z,-y,rx,rz,-ry",
    )
    parser.add_argument(
        "--mouse-zoom", dest="zoom_axis", choices=("y", "z"), help="pushed or lifted comes near"
    )
    for option, name, about in (
        ("--mouse-moves", "moving", "whether it moves the object"),
        ("--mouse-turns", "turning", "whether it turns it"),
        ("--mouse-one-axis", "dominant_axis", "follow only the axis that is deflected most"),
    ):
        parser.add_argument(option, dest=name, choices=tuple(_ON), help=about)
    parser.add_argument(
        "--mouse-button",
        dest="buttons",
        metavar="N=ACTION",
        type=_parse_button,
        action="append",
        help="what a button does, from 1; recentre, dip, undo, redo, toggle_turning, "
        "toggle_moving, toggle_dominant_axis, toggle_camera, calibrate_rest, or nothing",
    )
    _add_stylus(parser)
    parser.add_argument("--defaults", action="store_true", help="begin with how it was at first")


def _add_stylus(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--stylus-limit",
        dest="limit_n",
        metavar="N",
        type=_number(7.9),
        help="the stylus never pushes harder, N",
    )
    parser.add_argument(
        "--stylus-anticipation",
        dest="anticipation_mm",
        metavar="MM",
        type=_number(20.0),
        help="so far before the surface a gentle force begins; 0: none",
    )
    parser.add_argument(
        "--stylus-click",
        dest="click_n",
        metavar="N",
        type=_number(1.0),
        help="force of the click when the brush is dipped; 0: none",
    )
    parser.add_argument(
        "--stylus-texture",
        dest="texture",
        metavar="SHARE",
        type=_number(1.0),
        help="how much of the surface's grain is felt; 0: nothing, 1: all (at first)",
    )
    add_stylus_option(parser, "")


def set_devices(options: argparse.Namespace) -> None:
    """Save the options as settings, and print all settings.

    Raises
    ------
    Paint3DError
        If the settings cannot be written.
    """
    import dataclasses

    from paint3d.app.model.persistence.settings import load_settings, save_settings
    from paint3d.haptics.settings import Feel
    from paint3d.pose.mouse_settings import DEFAULT_ACTIONS, MouseSettings

    settings, problem = load_settings()
    if problem is not None:
        sys.stderr.write(f"{problem}\n")
    before = settings
    if options.defaults:
        settings = dataclasses.replace(
            settings, mouse={}, feel={}, stylus="auto", buttons=dict(DEFAULT_ACTIONS)
        )
    mouse = dataclasses.replace(
        MouseSettings.from_dict(settings.mouse), **_chosen(options, MouseSettings)
    )
    feel = dataclasses.replace(Feel.from_dict(settings.feel), **_chosen(options, Feel))
    buttons = {**settings.buttons, **dict(options.buttons or ())}
    settings = dataclasses.replace(
        settings,
        mouse=mouse.as_dict(),
        feel=feel.as_dict(),
        buttons={number: action for number, action in buttons.items() if action},
        stylus=options.stylus or settings.stylus,
    )
    if settings != before:
        save_settings(settings)
    _show(mouse.as_dict(), settings.buttons, {"stylus": settings.stylus, **feel.as_dict()})


def _chosen(options: argparse.Namespace, kind: type) -> dict[str, Any]:
    """Return the options that were given for the fields of a class."""
    import dataclasses

    given = {"mode": options.mouse_mode}
    for own in dataclasses.fields(kind):
        given.setdefault(own.name, getattr(options, own.name, None))
    words = {name: _ON.get(value, value) if isinstance(value, str) else value
             for name, value in given.items()}  # fmt: skip
    known = {own.name for own in dataclasses.fields(kind)}
    return {name: value for name, value in words.items() if value is not None and name in known}


def _show(mouse: Mapping[str, Any], buttons: Mapping[int, str], feel: Mapping[str, Any]) -> None:
    for name, value in mouse.items():
        shown = ",".join(value) if isinstance(value, list) else value
        sys.stdout.write(
            f"mouse {name}: {round(shown, 3) if isinstance(shown, float) else shown}\n"
        )
    for number, action in sorted(buttons.items()):
        sys.stdout.write(f"mouse button {number + 1}: {action}\n")
    for name, value in feel.items():
        sys.stdout.write(f"{name if name == 'stylus' else f'stylus {name}'}: {value}\n")


# ---- The command ---------------------------------------------------------------------------------


EXAMPLES = """
paint3d devices list
paint3d devices record strokes.jsonl.gz
"""
_KINDS = {"mouse": "6-DOF mouse", "stylus": "haptic stylus", "pen": "pen tablet"}
_LINES_HZ = 10.0
_TAKE_S = 0.02
_SETTLED_NS = 2_000_000  # older reports have been read
_LONGEST_S = 24 * 3600.0
_SUFFIXES = (".jsonl", ".jsonl.gz", ".csv", ".csv.gz")


def _parse_seconds(text: str) -> float:
    return parse_number(text, "a time", "seconds above 0", lambda n: 0.0 < n <= _LONGEST_S)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the deeds and their options."""
    add = add_actions(parser, "deed")
    listed = add(
        "list",
        "what is plugged in; where it cannot be opened, why, and the rule that allows it",
        "paint3d devices list",
    )
    watch = add(
        "watch",
        "what devices say, live, until Ctrl-C",
        "paint3d devices watch --seconds 10",
    )
    check = add(
        "check",
        "how steadily they report: rate, gaps, how late reports are read, what was refused",
        "paint3d devices check --seconds 5",
    )
    record = add(
        "record",
        "write a recording of both hands, until Ctrl-C",
        "paint3d devices record strokes.jsonl.gz --smooth",
    )
    record.add_argument("file", metavar="FILE", type=Path, help="recording, by suffix")
    record.add_argument("--raw", metavar="LOG", type=Path, help="also keep every report, as sent")
    record.add_argument(
        "--calibration",
        metavar="FILE",
        type=Path,
        help="where the stylus stands in the world (default: as it was calibrated last)",
    )
    record.add_argument(
        "--smooth", action="store_true", help="smooth the recording (the raw log never is)"
    )
    add_force_option(record)
    for deed in (listed, watch, check, record):
        add_stylus_option(deed, " (default: the first there is)")
    add_calibrate(
        add(
            "calibrate",
            "touch known points, to say where the stylus stands",
            "paint3d devices calibrate --sheet 210x148",
        )
    )
    add_set(
        add(
            "set",
            "how mouse and stylus are read, in the studio too",
            "paint3d devices set --mouse-speed 200 --stylus-limit 3",
        )
    )
    for deed, default in ((watch, None), (check, 5.0), (record, None)):
        deed.add_argument(
            "--seconds",
            metavar="S",
            type=_parse_seconds,
            default=default,
            help="how long" + (f" (default: {default:g})" if default else ""),
        )


def run(options: argparse.Namespace) -> None:
    """Do what was asked.

    Raises
    ------
    Paint3DError
        If nothing is plugged in, nothing could be opened, or a file cannot be written.
    """
    deeds = {
        "list": _list, "watch": _watch, "check": _check, "record": _record,
        "calibrate": calibrate, "set": set_devices,
    }  # fmt: skip
    deeds[options.deed](options)


# -- list -------------------------------------------------------------------------------------


def _list(options: argparse.Namespace) -> None:
    from paint3d.device.hid_nodes import list_nodes
    from paint3d.haptics.stylus_choice import find_stylus

    nodes, choice = list_nodes(), options.stylus or "auto"
    by_hid = choice == "auto" and any(node.kind == "stylus" for node in nodes)
    other = None if by_hid else find_stylus(choice)
    if other is not None and other.kind != "hid":
        sys.stdout.write(f"{other.name}, haptic stylus, {other.limits.max_force:g} N: ready\n")
    elif not nodes:
        sys.stdout.write("no 6-DOF mouse, stylus or pen tablet is plugged in\n")
    for node in nodes:
        ids = f"{node.vendor:04x}:{node.product:04x}"
        sys.stdout.write(
            f"{node.name}, {_KINDS[node.kind]}, {ids}, {node.path} by "
            f"{'libusb' if node.backend == 'hid' else node.backend}: {_state(node)}\n"
        )


def _state(node: HidNode) -> str:
    """Return "ready" for a node that can be opened, else why not."""
    from paint3d.device.hid_link import open_node

    try:
        open_node(node).close()
    except DeviceError as failure:
        return str(failure).removeprefix(f"{node.name} at {node.path} was ")
    return "ready"


# -- watch ------------------------------------------------------------------------------------


def _watch(options: argparse.Namespace) -> None:
    devices = _plug_in(options.stylus)
    try:
        for _ in rounds(options.seconds, 1.0 / _LINES_HZ):
            line = " | ".join([*_mouse_values(devices), *_stylus_values(devices)])
            sys.stdout.write(f"\r\x1b[K{line}" if sys.stdout.isatty() else f"{line}\n")
            sys.stdout.flush()
    finally:
        devices.stop()
    if sys.stdout.isatty():
        sys.stdout.write("\n")


def _mouse_values(devices: OpenedDevices) -> list[str]:
    devices.take_mouse()
    lines = []
    for mouse in devices.mice():
        reading = mouse.reading
        axes = " ".join(f"{value:+5d}" for value in reading.axes)
        charge = "" if reading.battery is None else f" {reading.battery} %"
        lines.append(f"{mouse.loop.link.name} {axes} buttons {reading.buttons:b}{charge}")
    return lines


def _stylus_values(devices: OpenedDevices) -> list[str]:
    lines = []
    readings_by_name = [(stylus.loop.link.name, stylus.take()) for stylus in devices.styli()]
    if devices.reader is not None:
        if devices.reader.gone is not None:
            lines.append(devices.reader.gone)
        else:
            readings_by_name.append((devices.reader.name, devices.reader.take()))
    for name, readings in readings_by_name:
        if not readings:
            lines.append(f"{name} silent")
            continue
        last = readings[-1]
        position = " ".join(f"{value:+8.2f}" for value in last.position)
        turn = " ".join(f"{value:+.3f}" for value in last.orientation)
        force = "" if last.pressure is None else f" pressure {last.pressure:.2f}"
        lines.append(
            f"{name} {position} mm, {turn}{force} buttons {last.buttons:b}"
            f"{'' if last.in_range else ' out of range'}"
        )
    return lines


# -- check ------------------------------------------------------------------------------------


def _check(options: argparse.Namespace) -> None:
    reports_by_path: dict[str, tuple[HidNode, list[tuple[int, bytes]]]] = {}

    def keep(node: HidNode, _: bytes, time_ns: int, report: bytes) -> None:
        reports_by_path.setdefault(node.path, (node, []))[1].append((time_ns, report))

    devices = _plug_in(options.stylus, keep)
    times: list[int] = []
    try:
        for _ in rounds(options.seconds, 0.1):
            devices.take_mouse()
            times += [reading.time_ns for reading in devices.take_stylus()]
        for node in devices.nodes():
            reports_by_path.setdefault(node.path, (node, []))
        lines = [_rate_of(*entry) for _, entry in sorted(reports_by_path.items())]
        if devices.reader is not None:
            reader = devices.reader
            lines += _rate_at(reader.name, times)
            if reader.n_refused:
                lines.append(f"{reader.name}: {reader.n_refused} reports refused")
            if reader.gone is not None:
                lines.append(reader.gone)
        lines += [line for stylus in devices.styli() for line in _health_of(stylus)]
        lines += [line for mouse in devices.mice() for line in _health_of(mouse)]
    finally:
        devices.stop()
    sys.stdout.write("\n".join(lines) + "\n")


def _rate_at(name: str, times: list[int]) -> list[str]:
    from paint3d.device.report_timing import measure_report_rate

    rate = measure_report_rate(times)
    if not rate.rate_hz:
        return [f"{name}: {rate.n} reports; move it while it is checked"]
    return [
        f"{name}: {rate.n} reports, {rate.rate_hz:.1f} Hz, interval "
        f"{rate.interval_p50_ms:.2f} ms, p99 {rate.interval_p99_ms:.2f}, "
        f"longest {rate.longest_ms:.2f}, pauses {rate.pauses}"
    ]


def _rate_of(node: HidNode, reports: list[tuple[int, bytes]]) -> str:
    import numpy as np

    from paint3d.device.report_timing import lateness_ms

    (line,) = _rate_at(node.name, [time_ns for time_ns, _ in reports])
    numbered = [(t, r) for t, r in reports if node.kind == "stylus" and len(r) >= 25]
    if len(numbered) > 2:
        late = lateness_ms(
            [t for t, _ in numbered], [int.from_bytes(r[23:25], "little") for _, r in numbered]
        )
        p50, p99 = np.percentile(late, (50, 99))
        line += f", read late by {p50:.2f} ms, p99 {p99:.2f}, most {late.max():.2f}"
    return line


def _health_of(device: Any) -> list[str]:
    status = device.loop.status
    name = device.loop.link.name
    lines = []
    if getattr(device, "has_force", False) and status.gone is None:
        lines.append(f"{name}: sending a force takes {_time_writing(device):.3f} ms at p99")
    if getattr(device, "lost", 0):
        lines.append(f"{name}: {device.lost} reports lost")
    if status.n_refused:
        lines.append(f"{name}: {status.n_refused} reports refused, last: {status.last_refusal}")
    if status.gone is not None:
        lines.append(status.gone)
    return lines


def _time_writing(stylus: Any) -> float:
    """Return the p99 of the time to send a force of zero, of 100 reports, ms."""
    from paint3d.device.force.haptic_stylus import encode_force

    spent = []
    for _ in range(100):
        started = time.perf_counter()
        stylus.loop.write(encode_force((0.0, 0.0, 0.0)))
        spent.append(1e3 * (time.perf_counter() - started))
        time.sleep(0.001)
    return sorted(spent)[98]


# -- record -----------------------------------------------------------------------------------


def _record(options: argparse.Namespace) -> None:
    from paint3d.pose.calibration import load_calibration

    check_output_file(options.file, _SUFFIXES)
    if options.raw is not None:
        check_output_folder(options.raw.parent)
    written = (options.file, options.raw)
    check_overwriting(written, (options.calibration,), force=options.force)
    calibration = None
    if options.calibration is not None:
        calibration = load_calibration(options.calibration)
    samples, names = _take_samples(options, calibration)
    if not samples:
        raise DeviceError("the stylus sent nothing; expected it to be moved while recording")
    n_all, pressing = len(samples), samples[0].pressure is not None
    samples = [s for s in samples if (s.pressure is not None) == pressing]
    _save(samples, names, options.file)
    seconds = (samples[-1].time_ns - samples[0].time_ns) * 1e-9
    others = f", {n_all - len(samples)} of another stylus left out" if n_all > len(samples) else ""
    sys.stdout.write(f"{options.file}: {len(samples)} samples in {seconds:.1f} s{others}\n")


def _take_samples(
    options: argparse.Namespace, calibration: DeviceCalibration | None
) -> tuple[list[DeviceSample], list[str]]:
    from paint3d.device.device_log import DeviceLog
    from paint3d.pose.two_hands import SmoothingSettings, TwoHands

    log = None if options.raw is None else DeviceLog(options.raw)
    try:
        devices = _plug_in(options.stylus, None if log is None else log.append)
        try:
            if log is not None and devices.reader is not None:
                raise DeviceError(
                    "--raw keeps HID reports, and {reader} sends none; expected --stylus hid, or "
                    "no --raw",
                    reader=devices.reader.name,
                )
            hands = TwoHands(
                calibration or devices.calibration(),
                devices.mouse.steering(),
                SmoothingSettings() if options.smooth else None,
                time.monotonic_ns(),
            )
            names, samples = devices.names(), list[Any]()
            for _ in rounds(options.seconds, _TAKE_S):
                samples += _merge(devices, hands, time.monotonic_ns() - _SETTLED_NS)
            samples += _merge(devices, hands, time.monotonic_ns())
            if devices.reader is not None and devices.reader.gone is not None:
                sys.stderr.write(f"{devices.reader.gone}\n")
        finally:
            devices.stop()
    except BaseException:
        if log is not None:
            log.discard()
        raise
    if log is not None:
        log.close()
    return samples, names


def _merge(devices: OpenedDevices, hands: TwoHands, until_ns: int) -> list[DeviceSample]:
    for event in devices.take_mouse():
        hands.add_deflection(event.time_ns, event.deflection)
    hands.add_stylus(devices.take_stylus())
    return hands.take(until_ns)


def _save(samples: list[DeviceSample], names: list[str], file: Path) -> None:
    import numpy as np

    from paint3d.recording.recording import Recording, save_recording

    pressures = [s.pressure for s in samples if s.pressure is not None]
    recording = Recording(
        np.array([s.time_ns - samples[0].time_ns for s in samples], dtype=np.int64),
        np.array([s.position for s in samples]),
        np.array([s.orientation for s in samples]),
        np.array(pressures) if pressures else None,
        np.array([s.buttons for s in samples], dtype=np.int32),
        np.array([s.object_position for s in samples]),
        np.array([s.object_orientation for s in samples]),
        {"devices": names},
    )
    save_recording(recording, file)


# -- common -----------------------------------------------------------------------------------


def _plug_in(
    stylus: str | None, log: Callable[[HidNode, bytes, int, bytes], None] | None = None
) -> OpenedDevices:
    """Open the chosen devices; see `OpenedDevices`."""

    return OpenedDevices(stylus or "auto", log)


def rounds(seconds: float | None, pause_s: float) -> Iterator[None]:
    """Yield every `pause_s`, for so long or until Ctrl-C or `kill`, which cut no round short."""
    end = None if seconds is None else time.monotonic() + seconds
    over: list[bool] = []
    with signals_handled_by(lambda _: over.append(True)):
        while not over and (end is None or time.monotonic() < end):
            time.sleep(pause_s)
            yield
