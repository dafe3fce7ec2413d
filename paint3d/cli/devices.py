"""The hands' devices: what is plugged in, what it says, how steadily, and a recording of it."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from paint3d.cli.hands.calibrate import add_calibrate, calibrate
from paint3d.cli.hands.options import add_stylus_option
from paint3d.cli.hands.settings import add_set, set_devices
from paint3d.cli.options import (
    add_force_option,
    check_output_file,
    check_output_folder,
    check_overwriting,
    parse_number,
)
from paint3d.core.ending import heard_by
from paint3d.errors import DeviceError

if TYPE_CHECKING:
    from paint3d.cli.hands.opened import OpenedDevices
    from paint3d.device.force.port_reader import PortReader
    from paint3d.device.hid_nodes import HidNode
    from paint3d.device.sample import DeviceSample
    from paint3d.pose.calibration import DeviceCalibration
    from paint3d.pose.two_hands import TwoHands

__all__ = ["HELP", "add_arguments", "rounds", "run"]

HELP = "what is plugged in, live values, rate and latency, a recording, calibration, settings"
_KINDS = {"mouse": "6-DOF mouse", "stylus": "haptic stylus", "pen": "pen tablet"}
_LINES_HZ = 10.0
_TAKE_S = 0.02
_SETTLED_NS = 2_000_000  # what was measured so long ago has been read
_LONGEST_S = 24 * 3600.0
_SUFFIXES = (".jsonl", ".jsonl.gz", ".csv", ".csv.gz")


def _parse_seconds(text: str) -> float:
    return parse_number(text, "a time", "seconds above 0", lambda n: 0.0 < n <= _LONGEST_S)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the deeds and their options."""
    deeds = parser.add_subparsers(metavar="DEED", required=True, dest="deed")
    listed = deeds.add_parser("list", help="what is plugged in; where it cannot be opened, why")
    watch = deeds.add_parser("watch", help="live values, until Ctrl-C")
    check = deeds.add_parser("check", help="rate, gaps, latency")
    record = deeds.add_parser("record", help="write a recording of both hands, until Ctrl-C")
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
        deeds.add_parser("calibrate", help="touch known points, to say where the stylus stands")
    )
    add_set(deeds.add_parser("set", help="how mouse and stylus are read, in the studio too"))
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
    found = None if by_hid else find_stylus(choice)
    if found is not None and found.kind != "hid":
        sys.stdout.write(f"{found.name}, haptic stylus, {found.limits.max_force:g} N: ready\n")
    elif not nodes:
        sys.stdout.write("no 6-DOF mouse, stylus or pen tablet is plugged in\n")
    for node in nodes:
        ids = f"{node.vendor:04x}:{node.product:04x}"
        sys.stdout.write(
            f"{node.name}, {_KINDS[node.kind]}, {ids}, {node.path} by "
            f"{'libusb' if node.backend == 'hid' else node.backend}: {_state(node)}\n"
        )


def _state(node: HidNode) -> str:
    """Whether a node can be opened, found out by opening it."""
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
    heard = [(stylus.loop.link.name, stylus.take()) for stylus in devices.styli()]
    if devices.reader is not None:
        if devices.reader.gone is not None:
            lines.append(devices.reader.gone)
        else:
            heard.append((devices.reader.name, devices.reader.take()))
    for name, readings in heard:
        if not readings:
            lines.append(f"{name} silent")
            continue
        last = readings[-1]
        place = " ".join(f"{value:+8.2f}" for value in last.position)
        turn = " ".join(f"{value:+.3f}" for value in last.orientation)
        force = "" if last.pressure is None else f" pressure {last.pressure:.2f}"
        lines.append(
            f"{name} {place} mm, {turn}{force} buttons {last.buttons:b}"
            f"{'' if last.in_range else ' out of range'}"
        )
    return lines


# -- check ------------------------------------------------------------------------------------


def _check(options: argparse.Namespace) -> None:
    heard: dict[str, tuple[HidNode, list[tuple[int, bytes]]]] = {}

    def keep(node: HidNode, _: bytes, time_ns: int, report: bytes) -> None:
        heard.setdefault(node.path, (node, []))[1].append((time_ns, report))

    devices = _plug_in(options.stylus, keep)
    times: list[int] = []
    try:
        for _ in rounds(options.seconds, 0.1):
            devices.take_mouse()
            times += [reading.time_ns for reading in devices.take_stylus()]
        for node in devices.nodes():
            heard.setdefault(node.path, (node, []))
        lines = [_rate_of(*found) for _, found in sorted(heard.items())]
        if devices.reader is not None:
            lines += [*_rate_at(devices.reader.name, times), *_state_of(devices.reader)]
        lines += [line for stylus in devices.styli() for line in _health_of(stylus)]
        lines += [line for mouse in devices.mice() for line in _health_of(mouse)]
    finally:
        devices.stop()
    sys.stdout.write("\n".join(lines) + "\n")


def _rate_at(name: str, times: list[int]) -> list[str]:
    from paint3d.device.report_rate import find_report_rate

    rate = find_report_rate(times)
    if not rate.rate_hz:
        return [f"{name}: {rate.n} reports; move it while it is checked"]
    return [
        f"{name}: {rate.n} reports, {rate.rate_hz:.1f} Hz, interval "
        f"{rate.interval_p50_ms:.2f} ms, p99 {rate.interval_p99_ms:.2f}, "
        f"longest {rate.longest_ms:.2f}, pauses {rate.pauses}"
    ]


def _state_of(reader: PortReader) -> list[str]:
    refused = f"{reader.name}: {reader.n_refused} reports refused"
    gone = [] if reader.gone is None else [reader.gone]
    return [refused] * bool(reader.n_refused) + gone


def _rate_of(node: HidNode, reports: list[tuple[int, bytes]]) -> str:
    import numpy as np

    from paint3d.device.report_rate import lateness_ms

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
    """p99 of 100 force reports of zero, ms."""
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
        devices = _plug_in(options.stylus, None if log is None else log.keep)
        try:
            if log is not None and devices.reader is not None:
                raise DeviceError(
                    f"--raw keeps HID reports, and {devices.reader.name} sends none; "
                    "expected --stylus hid, or no --raw"
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
    """Open what is there and was chosen; see `OpenedDevices`."""
    from paint3d.cli.hands.opened import OpenedDevices

    return OpenedDevices(stylus or "auto", log)


def rounds(seconds: float | None, pause_s: float) -> Iterator[None]:
    """Once every `pause_s`, for so long or until Ctrl-C, or `kill`, which cuts no round short."""
    end = None if seconds is None else time.monotonic() + seconds
    over: list[bool] = []
    with heard_by(lambda _: over.append(True)):
        while not over and (end is None or time.monotonic() < end):
            time.sleep(pause_s)
            yield
