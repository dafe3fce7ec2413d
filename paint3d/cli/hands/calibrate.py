"""`paint3d devices calibrate`: touch known points, see the error, keep where the stylus stands."""

from __future__ import annotations

import argparse
import re
import select
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.hands.options import add_stylus_option
from paint3d.cli.options import add_force_option, check_output_file, check_overwriting
from paint3d.errors import DeviceError

if TYPE_CHECKING:
    from paint3d.cli.hands.opened import OpenedDevices
    from paint3d.pose.touching import Touches

__all__ = ["add_calibrate", "calibrate"]

_CORNERS = ("near left corner", "near right corner", "far right corner", "far left corner")
_TAKE_S = 0.02
_PATIENCE_S = 600.0


def _parse_sheet(text: str) -> tuple[float, float]:
    found = re.fullmatch(r"(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)", text)
    if found is None or not all(20.0 <= float(side) <= 2000.0 for side in found.groups()):
        raise argparse.ArgumentTypeError(
            f"{text!r} is no sheet; expected WIDTHxDEPTH in mm, each 20 to 2000, such as 210x148"
        )
    return float(found[1]), float(found[2])


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
    """Have the points touched, fit the device's frame, keep it.

    Raises
    ------
    DeviceError
        If there is no stylus, or the touches give no frame: by how much.
    """
    from paint3d.app.model.persistence.calibrations import keep_calibration
    from paint3d.cli.hands.opened import OpenedDevices
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
        file = keep_calibration(key, fitted.calibration)
    errors = ", ".join(f"{error:.2f}" for error in fitted.errors_mm)
    residual = fitted.calibration.residual_mm
    sys.stdout.write(f"{file}: {residual:.2f} mm off (root mean square of {errors})\n")


def _touch_all(devices: OpenedDevices, touches: Touches, names: list[str]) -> None:
    """Ask for point after point, until all were touched: by a button of the stylus, or Enter."""
    end = time.monotonic() + _PATIENCE_S
    asked, typed = -1, _can_type()
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
            raise DeviceError(f"{n} of {len(names)} points were touched in {_PATIENCE_S:g} s")
        time.sleep(_TAKE_S)
        try:
            touches.hear(devices.take_stylus())
            if typed and select.select([sys.stdin], [], [], 0.0)[0]:
                typed = bool(sys.stdin.readline())
                if typed:
                    touches.touch()
        except DeviceError as cause:
            asked = -1
            sys.stderr.write(f"{cause}\n")
        if devices.reader is not None and devices.reader.gone is not None:
            raise DeviceError(devices.reader.gone)


def _can_type() -> bool:
    if sys.stdin is None:
        return False
    try:
        select.select([sys.stdin], [], [], 0.0)
    except (OSError, ValueError):
        return False
    return True
