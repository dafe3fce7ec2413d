"""From the pressure that a device sends to the one that is painted with."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import PchipInterpolator

from paint3d.core.arrays import AnyArray, as_array
from paint3d.errors import InputError

__all__ = ["PressureCurve"]

_STEPS = 1024
_MOST_POINTS = 16


@dataclass(frozen=True)
class PressureCurve:
    """A curve through points that never falls: the monotone cubic of Fritsch and Carlson (1980).

    Attributes
    ----------
    points : tuple of (float, float)
        What comes in and what goes out, both 0 to 1, 2 to 16 of them, the first at 0 and the last
        at 1; in between what comes in rises, and what goes out does not fall.

    Raises
    ------
    InputError
        If the points are none of those.
    """

    points: tuple[tuple[float, float], ...] = ((0.0, 0.0), (1.0, 1.0))
    _table: AnyArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        given = np.round(as_array(self.points, "pressure curve", (None, 2)), 6)
        if not 2 <= len(given) <= _MOST_POINTS:
            raise InputError("pressure curve has {n} points; expected 2 to 16", n=len(given))
        if given.min() < 0.0 or given.max() > 1.0:
            raise InputError("pressure curve leaves 0 to 1")
        if given[0, 0] != 0.0 or given[-1, 0] != 1.0:
            raise InputError("pressure curve must go from a pressure of 0 to one of 1")
        if (np.diff(given[:, 0]) <= 0.0).any() or (np.diff(given[:, 1]) < 0.0).any():
            raise InputError("pressure curve falls or turns back; expected it to rise")
        object.__setattr__(self, "points", tuple((float(x), float(y)) for x, y in given))
        steps = np.linspace(0.0, 1.0, _STEPS + 1)
        curve = PchipInterpolator(given[:, 0], given[:, 1])(steps)
        curve[0], curve[-1] = given[0, 1], given[-1, 1]
        object.__setattr__(
            self, "_table", np.maximum.accumulate(np.clip(curve, given[0, 1], given[-1, 1]))
        )

    def __call__(self, pressure: float) -> float:
        """The pressure painted with, for one that was sent, both 0 to 1."""
        at = pressure * _STEPS
        i = min(int(at), _STEPS - 1)
        low, high = self._table[i], self._table[i + 1]
        return float(low + (at - i) * (high - low))

    def moved(self, index: int, x: float, y: float) -> PressureCurve:
        """The curve with one point where it was dragged, as far as its neighbours let it go.

        The first and the last stay at 0 and 1.
        """
        points = list(self.points)
        gap = 0.01
        left = points[index - 1] if index > 0 else None
        right = points[index + 1] if index + 1 < len(points) else None
        low = left[0] + gap if left else 0.0
        high = right[0] - gap if right else 1.0
        x = 0.0 if left is None else 1.0 if right is None else min(max(x, low), high)
        y = min(max(y, left[1] if left else 0.0), right[1] if right else 1.0)
        points[index] = (x, y)
        return PressureCurve(tuple(points))

    def with_point(self, x: float, y: float) -> PressureCurve:
        """The curve with one point more, moved to where it can be.

        Raises
        ------
        InputError
            If there are 16, or one is there already.
        """
        index = sum(px < x for px, _ in self.points)
        middle = [*self.points[:index], (x, self(min(max(x, 0.0), 1.0))), *self.points[index:]]
        return PressureCurve(tuple(middle)).moved(index, x, y)

    def without_point(self, index: int) -> PressureCurve:
        """The curve without one of the points between the first and the last.

        Raises
        ------
        InputError
            If there is none.
        """
        if not 0 < index < len(self.points) - 1:
            raise InputError(
                "point {index} of the pressure curve cannot be removed; expected one between "
                "its ends",
                index=index,
            )
        return PressureCurve(self.points[:index] + self.points[index + 1 :])
