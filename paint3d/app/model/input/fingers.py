"""What fingers on the picture mean: one paints or turns, two move, roll and zoom, taps undo.

Pure steps over positions in pixels and times; nothing here has a clock or knows of a window.

One finger waits until it has moved or stayed a moment, so that a second one that follows makes a
gesture of both and leaves no dot. Up to a quarter of a second later the second one takes the stroke
back; after that it is the side of a hand, and passed over.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

__all__ = ["Fingers", "Meaning"]

_MS = 1_000_000
_STILL = 9.0  # pixels that a finger rolls while it taps
_WAIT_NS = 120 * _MS  # until one finger alone is believed
_TAKEN_BACK_NS = 250 * _MS  # within which a second finger takes back what the first began
_TAP_NS = 350 * _MS

Positions = Mapping[int, tuple[float, float]]


@dataclass(frozen=True)
class Meaning:
    """A request that fingers make.

    Attributes
    ----------
    kind : str
        "press", "move", "release", "cancel" of one finger; "turn" by (dx, dy); "pinch": move by
        (dx, dy), go nearer by `factor` and roll anticlockwise by `angle` at (x, y); "tap" with
        `count` fingers.
    time_ns : int
    x, y : float
        Pixels, y down.
    dx, dy : float
        Pixels.
    factor : float
    angle : float
        rad.
    count : int
    """

    kind: str
    time_ns: int
    x: float = 0.0
    y: float = 0.0
    dx: float = 0.0
    dy: float = 0.0
    factor: float = 1.0
    angle: float = 0.0
    count: int = 0


class Fingers:
    """Follows all fingers on one picture."""

    def __init__(self) -> None:
        self._forget()

    def _forget(self) -> None:
        self._down: dict[int, tuple[float, float]] = {}
        self._from: dict[int, tuple[float, float]] = {}
        self._first = -1
        self._began = self._pressed = 0
        self._state = "none"  # none, waiting, one, several, over
        self._waiting: list[tuple[int, float, float]] = []
        self._most = 0
        self._moved = False
        self._last = (0.0, 0.0)

    def follow(self, time_ns: int, positions: Positions) -> list[Meaning]:
        """Follow the fingers that are down now; return what they ask for.

        Parameters
        ----------
        time_ns : int
        positions : mapping of int to (float, float)
            Pixels of every finger that is down, by its number; those that are missing have left.
        """
        meanings: list[Meaning] = []
        before, self._down = self._down, dict(positions)
        came = [number for number in positions if number not in before]
        if came and self._state == "none":
            down = self._down
            self._forget()
            self._down, self._state = down, "waiting"
            self._first, self._began = came[0], time_ns
        self._most = max(self._most, len(positions))
        for number in came:
            self._from[number] = positions[number]
        self._moved = self._moved or any(
            math.dist(position, self._from[number]) > _STILL
            for number, position in positions.items()
        )
        if len(positions) > 1 and self._state in ("waiting", "one"):
            meanings += self._join_finger(time_ns)
        if self._state in ("waiting", "one"):
            meanings += self._follow_one(time_ns)
        elif self._state == "several":
            meanings += self._follow_several(time_ns, before, bool(came))
        if not positions:
            most, quick = self._most, time_ns - self._began <= _TAP_NS
            tapped = self._state == "several" and not self._moved and quick
            self._forget()
            meanings += [Meaning("tap", time_ns, count=most)] if tapped else []
        return meanings

    def cancel(self, time_ns: int) -> list[Meaning]:
        """Forget all fingers: the system took them away."""
        pressed = self._state == "one"
        self._forget()
        return [Meaning("cancel", time_ns)] if pressed else []

    # -- steps ------------------------------------------------------------------------------

    def _join_finger(self, time_ns: int) -> list[Meaning]:
        """Another finger came: a gesture of all, unless the first one paints for long already."""
        if self._state == "waiting":
            self._state = "several"
            return []
        if time_ns - self._pressed <= _TAKEN_BACK_NS:
            self._state = "several"
            return [Meaning("cancel", time_ns)]
        return []

    def _follow_one(self, time_ns: int) -> list[Meaning]:
        position = self._down.get(self._first)
        if position is None:
            meanings = self._press(time_ns) if self._state == "waiting" else []
            self._state = "over"
            x, y = self._last
            return [*meanings, Meaning("release", time_ns, x, y)]
        self._last = position
        if self._state == "one":
            return [Meaning("move", time_ns, *position)]
        self._waiting.append((time_ns, *position))
        if self._moved or time_ns - self._began > _WAIT_NS:
            return self._press(time_ns)
        return []

    def _press(self, time_ns: int) -> list[Meaning]:
        """Believe in one finger: it came down where it did, and went where it went since."""
        self._state, self._pressed = "one", time_ns
        first, *rest = self._waiting
        self._waiting = []
        return [Meaning("press", *first), *(Meaning("move", *one) for one in rest)]

    def _follow_several(self, time_ns: int, before: Positions, came: bool) -> list[Meaning]:
        both = [number for number in self._down if number in before]
        if came or len(both) != len(before) or len(both) < 2 or not self._moved:
            return []
        old, new = [before[n] for n in both], [self._down[n] for n in both]
        x, y = _middle(new)
        dx, dy = x - _middle(old)[0], y - _middle(old)[1]
        if len(both) > 2:
            return [Meaning("turn", time_ns, x, y, dx, dy)]
        spread, angle = _span_and_angle(new)
        old_spread, old_angle = _span_and_angle(old)
        turned = math.remainder(old_angle - angle, 2.0 * math.pi)  # y points down
        factor = spread / old_spread if min(spread, old_spread) > 1.0 else 1.0
        return [Meaning("pinch", time_ns, x, y, dx, dy, factor, turned)]


def _middle(positions: list[tuple[float, float]]) -> tuple[float, float]:
    return sum(x for x, _ in positions) / len(positions), sum(y for _, y in positions) / len(
        positions
    )


def _span_and_angle(positions: list[tuple[float, float]]) -> tuple[float, float]:
    """Distance of two positions, pixels, and the direction from one to the other, rad."""
    (x0, y0), (x1, y1) = positions
    return math.hypot(x1 - x0, y1 - y0), math.atan2(y1 - y0, x1 - x0)
