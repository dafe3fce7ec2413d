"""6-DOF mouse: events of deflection and buttons from an open link."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import as_array, as_number
from paint3d.device.catalogue import MouseQuirks
from paint3d.device.descriptor import parse_descriptor
from paint3d.device.device_loop import DeviceLoop
from paint3d.device.hid_link import Link
from paint3d.device.six_dof import MouseReading, find_mouse_layout
from paint3d.errors import DeviceError

__all__ = [
    "SILENCE_NS",
    "DeflectionSettings",
    "MouseEvent",
    "SpaceMouse",
    "calibrate_rest",
    "deflection",
]

# ---- Deflection ----------------------------------------------------------------------------------
# From raw axes to a deflection that is zero when the hand is off: subtract the rest position,
# scale, and cut out a dead zone without a jump at its edge.

SILENCE_NS = 150_000_000
"""Time without a report after which the deflection is zero, ns: a mouse stops sending at rest, and
its last report need not have been zero."""
_REST_LIMIT = 0.15


@dataclass(frozen=True, slots=True)
class DeflectionSettings:
    """Calibration and response of the axes.

    Parameters
    ----------
    dead_zone : float
        Fraction of the full deflection that counts as rest, 0 to 0.9.
    rest : tuple of 6 float
        Counts that this device sends at rest; see `calibrate_rest`.
    curve : float
        Exponent of the response, 1 to 4: 1 is linear, a larger one is finer near rest.

    Raises
    ------
    DeviceError
        If one is out of range.
    """

    dead_zone: float = 0.05
    rest: tuple[float, ...] = (0.0,) * 6
    curve: float = 1.6

    def __post_init__(self) -> None:
        as_number(self.dead_zone, "dead_zone", 0.0, 0.9, DeviceError)
        as_number(self.curve, "curve", 1.0, 4.0, DeviceError)
        as_array(self.rest, "rest", (6,), error=DeviceError)


def deflection(
    axes: ArrayLike, quirks: MouseQuirks, settings: DeflectionSettings
) -> NDArray[np.float64]:
    """Compute the deflection (6,), each -1 to 1, in a right-handed frame: x right, y away, z up.

    Translation first, then rotation about the same axes. Counts are clamped at the nominal full
    deflection, which some caps exceed.
    """
    counts = as_array(axes, "axes", (6,), error=DeviceError) - np.asarray(settings.rest)
    linear = np.clip(counts / quirks.full_deflection, -1.0, 1.0)
    beyond = np.maximum(np.abs(linear) - settings.dead_zone, 0.0) / (1.0 - settings.dead_zone)
    result: NDArray[np.float64] = (
        np.sign(linear) * beyond**settings.curve * np.asarray(quirks.axes_signs, np.float64)
    )
    return result


def calibrate_rest(
    readings: ArrayLike, quirks: MouseQuirks, settings: DeflectionSettings
) -> DeflectionSettings:
    """Return the settings with the rest position measured in these readings.

    Parameters
    ----------
    readings : (N, 6) array_like
        Raw axes while the hand was off. With N = 0 the cap rests at zero.
    quirks : MouseQuirks
    settings : DeflectionSettings

    Raises
    ------
    DeviceError
        If the cap moved, or rests further than 15 % from zero.
    """
    counts = as_array(readings, "readings", (None, 6), error=DeviceError)
    if len(counts) == 0:
        return dataclasses.replace(settings, rest=(0.0,) * 6)
    middle = np.median(counts, axis=0)
    spread = np.abs(counts - middle).max() / quirks.full_deflection
    if spread > max(settings.dead_zone, 0.02):
        raise DeviceError(
            "the cap moved by {spread:.0%} of its range during the rest calibration; expected "
            "nobody to touch it",
            spread=spread,
        )
    if np.abs(middle).max() > _REST_LIMIT * quirks.full_deflection:
        worst = float(np.abs(middle).max())
        raise DeviceError(
            "the cap rests at {worst:g} counts; expected within {rest_limit:g} (is something "
            "leaning on it?)",
            worst=worst,
            rest_limit=_REST_LIMIT * quirks.full_deflection,
        )
    return dataclasses.replace(settings, rest=tuple(middle.tolist()))


# ---- The mouse -----------------------------------------------------------------------------------

_RECENT = 64  # readings that the rest is measured from


@dataclass(frozen=True, eq=False, slots=True)
class MouseEvent:
    """State of a 6-DOF mouse at `time_ns`: deflection (6,), -1 to 1, and buttons held."""

    time_ns: int
    deflection: NDArray[np.float64]
    buttons: int


class SpaceMouse:
    """Reads a 6-DOF mouse in a thread, with its light on meanwhile.

    Parameters
    ----------
    link : Link
        Closed by `stop`.
    quirks : MouseQuirks
    settings : DeflectionSettings
    log : callable, optional
        See `DeviceLoop`.

    Raises
    ------
    DeviceError
        If the link's descriptor is not a 6-DOF mouse's.
    """

    def __init__(
        self,
        link: Link,
        quirks: MouseQuirks,
        settings: DeflectionSettings | None = None,
        log: Callable[[int, bytes], None] | None = None,
    ) -> None:
        self.layout = find_mouse_layout(parse_descriptor(link.descriptor))
        self.quirks = quirks
        self.settings = settings or DeflectionSettings()
        self.reading = MouseReading()
        self._recent: list[tuple[int, ...]] = []
        self.loop = DeviceLoop(link, self._decode, log, self._at_end)
        self.set_light(True)

    def take(self) -> list[MouseEvent]:
        """Return all events since the last call; a device that disconnects ends with rest."""
        return self.loop.take()

    def set_light(self, on: bool) -> None:
        """Turn the light on or off, if there is one."""
        self.loop.write(self.layout.encode_light(on))

    def calibrate_rest(self) -> None:
        """Set the rest position from the last reports.

        Raises
        ------
        DeviceError
            If the cap moved, or rests far from zero.
        """
        self.settings = calibrate_rest(
            np.array(self._recent, dtype=np.float64).reshape(-1, 6), self.quirks, self.settings
        )

    def stop(self) -> None:
        """Turn the light off, stop reading and close."""
        self.set_light(False)
        self.loop.stop()

    def _decode(self, time_ns: int, report: bytes) -> Iterator[MouseEvent]:
        self.reading = self.layout.decode(report, self.reading)
        self._recent = [*self._recent[-_RECENT + 1 :], self.reading.axes]
        yield MouseEvent(
            time_ns,
            deflection(self.reading.axes, self.quirks, self.settings),
            self.reading.buttons,
        )

    def _at_end(self, time_ns: int) -> list[MouseEvent]:
        return [MouseEvent(time_ns, np.zeros(6), 0)]
