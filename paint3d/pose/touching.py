"""Calibration by touching known points: picks the touches from a stylus' readings and fits them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.device.sample import StylusReading
from paint3d.errors import DeviceError, Message
from paint3d.pose.calibration import DeviceCalibration, fit_calibration

__all__ = ["SHEET_MM", "TouchFit", "Touches", "sheet_corners"]

SHEET_MM = (210.0, 148.0)
"""Width and depth of an A5 sheet in landscape, mm."""

_HELD_NS = 60_000_000  # over which a touch is measured
_STILL_MM = 3.0
_LEAST_APART_MM = 10.0
_LEAST_WIDE_MM = 5.0  # root mean square, across the line nearest to the points
_LEAST_WIDE = 0.1  # the same over their spread along that line
_GREATEST_ERROR = 0.05  # over the greatest distance between points; beyond, a touch is misplaced
_MOST_READINGS = 4096


def sheet_corners(width: float = SHEET_MM[0], depth: float = SHEET_MM[1]) -> NDArray[np.float64]:
    """Corners (4, 3) of a sheet on the table, mm: near left, near right, far right, far left.

    The world's origin lies in its middle, x to the right, y away, z up.
    """
    x = 0.5 * as_number(width, "width of the sheet (mm)", 20.0, 2000.0, DeviceError)
    y = 0.5 * as_number(depth, "depth of the sheet (mm)", 20.0, 2000.0, DeviceError)
    return np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])


@dataclass(frozen=True, eq=False)
class TouchFit:
    """A calibration fitted to touches, and how well it fits.

    Attributes
    ----------
    calibration : DeviceCalibration
        Its `residual_mm` is the root mean square of `errors_mm`.
    errors_mm : (N,) float64
        How far each touch lies from its point.
    """

    calibration: DeviceCalibration
    errors_mm: NDArray[np.float64]


class Touches:
    """Known points to be touched in turn, and the touches so far.

    Parameters
    ----------
    points : (N, 3) array_like
        In the world, mm, at least 3 that are not on a line.

    Attributes
    ----------
    points : (N, 3) float64
    touched : list of (3,) float64
        In the device's frame, mm.

    Raises
    ------
    DeviceError
        If there are too few points, or they do not determine a frame.
    """

    def __init__(self, points: ArrayLike) -> None:
        self.points = as_array(points, "points", (None, 3), error=DeviceError)
        if len(self.points) < 3:
            raise DeviceError("{n} points to touch; expected at least 3", n=len(self.points))
        _check_spread(self.points, Message("points to touch"))
        self.touched: list[AnyArray] = []
        self._recent: deque[StylusReading] = deque(maxlen=_MOST_READINGS)
        self._buttons: int | None = None

    @property
    def is_done(self) -> bool:
        """True if all points have been touched."""
        return len(self.touched) == len(self.points)

    def add(self, readings: Iterable[StylusReading]) -> bool:
        """Follow the stylus, in its own frame; return whether a button press touched a point.

        Raises
        ------
        DeviceError
            See `touch`; the point remains to be touched.
        """
        touched = False
        for reading in readings:
            self._recent.append(reading)
            while self._recent[0].time_ns < reading.time_ns - _HELD_NS:
                self._recent.popleft()
            before, self._buttons = self._buttons, reading.buttons
            if before is not None and reading.buttons & ~before and not self.is_done:
                self.touch()
                touched = True
        return touched

    def touch(self) -> None:
        """Take the stylus' position as the touch of the next point.

        Raises
        ------
        DeviceError
            If there are no readings, it was not held still, or it is at an earlier touch.
        """
        if not self._recent:
            raise DeviceError("the stylus sent nothing; expected it to be awake")
        positions = np.array([reading.position for reading in self._recent])
        middle = np.median(positions, axis=0)
        moved = float(np.linalg.norm(positions - middle, axis=1).max())
        if moved > _STILL_MM:
            raise DeviceError(
                "the stylus moved by {moved:.1f} mm while point {n} was touched; expected it to be "
                "held within {still_mm:g} mm for {held_ns:g} s",
                moved=moved,
                n=len(self.touched) + 1,
                still_mm=_STILL_MM,
                held_ns=_HELD_NS / 1e9,
            )
        for k, before in enumerate(self.touched):
            apart = float(np.linalg.norm(middle - before))
            if apart < _LEAST_APART_MM:
                raise DeviceError(
                    "point {n} was touched {apart:.2f} mm from point {k}; expected at least "
                    "{least:g}",
                    n=len(self.touched) + 1,
                    apart=apart,
                    k=k + 1,
                    least=_LEAST_APART_MM,
                )
        self.touched.append(middle)
        self._recent.clear()

    def fit(self, *, scaled: bool = False) -> TouchFit:
        """Fit the device's frame in the world to the touches.

        Parameters
        ----------
        scaled : bool
            Whether the device may be larger or smaller than the world.

        Raises
        ------
        DeviceError
            If touches are missing, too near to each other or to one line, or do not fit their
            points, with the errors.
        """
        if not self.is_done:
            raise DeviceError(
                "{n} of {points} points were touched; expected all",
                n=len(self.touched),
                points=len(self.points),
            )
        device = np.array(self.touched)
        _check_spread(device, Message("touches"))
        if not scaled:
            _check_distances(device, self.points)
        calibration = fit_calibration(device, self.points, scaled=scaled)
        errors = np.linalg.norm(calibration.to_world(device) - self.points, axis=1)
        most = _GREATEST_ERROR * _greatest_distance(self.points)
        if errors.max() > most:
            each = ", ".join(f"{error:.1f}" for error in errors)
            raise DeviceError(
                "the touches lie {each} mm off their points; expected at most {most:.1f} mm: were "
                "they touched in the order asked for, and are the points as far apart as given?",
                each=each,
                most=most,
            )
        return TouchFit(calibration, errors)


def _check_spread(points: AnyArray, what: Message) -> None:
    """Raise if points lie too close together or on one line."""
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    apart[np.diag_indices(len(points))] = np.inf
    i, j = np.unravel_index(np.argmin(apart), apart.shape)
    if apart[i, j] < _LEAST_APART_MM:
        raise DeviceError(
            "{what} {i} and {j} lie {apart:.2f} mm apart; expected at least {least:g}",
            what=what,
            i=min(i, j) + 1,
            j=max(i, j) + 1,
            apart=apart[i, j],
            least=_LEAST_APART_MM,
        )
    spread = np.linalg.svd(points - points.mean(axis=0))[1] / np.sqrt(len(points))
    least = max(_LEAST_WIDE_MM, _LEAST_WIDE * float(spread[0]))
    if spread[1] < least:
        raise DeviceError(
            "the {what} lie within {second:.2f} mm of one line, along which they spread "
            "{first:.1f} mm; expected at least {least:.1f} across it",
            what=what,
            second=spread[1],
            first=spread[0],
            least=least,
        )


def _check_distances(device: AnyArray, world: AnyArray) -> None:
    """Raise if distances between touches differ from those of their points, in any frame."""
    between = [np.linalg.norm(p[:, None] - p[None], axis=2) for p in (device, world)]
    off = np.abs(between[0] - between[1])
    i, j = np.unravel_index(np.argmax(off), off.shape)
    most = _GREATEST_ERROR * _greatest_distance(world)
    if off[i, j] > most:
        raise DeviceError(
            "touches {i} and {j} lie {first:.1f} mm apart, their points {wanted:.1f}; expected "
            "within {most:.1f}: were they touched in the order asked for, and is the sheet as "
            "large as given?",
            i=min(i, j) + 1,
            j=max(i, j) + 1,
            first=between[0][i, j],
            wanted=between[1][i, j],
            most=most,
        )


def _greatest_distance(points: AnyArray) -> float:
    return float(np.linalg.norm(points[:, None] - points[None], axis=2).max())
