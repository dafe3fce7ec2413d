"""Playing a recording at any speed: which samples are due by now."""

from __future__ import annotations

from paint3d.arrays import as_number
from paint3d.device.recorded import Recording
from paint3d.device.sample import DeviceSample

__all__ = ["Player"]

_SLOWEST, _FASTEST = 1e-3, 1e3


class Player:
    """Hands out a recording's samples as time goes by; whoever calls says what time it is.

    Parameters
    ----------
    recording : Recording
    speed : float
        1 for the recording's own, 0.001 to 1000.
    now_s : float
        The time at the start, s.

    Attributes
    ----------
    paused : bool
    """

    def __init__(self, recording: Recording, speed: float = 1.0, now_s: float = 0.0) -> None:
        self._times_s = (recording.time_ns - recording.time_ns[0]) * 1e-9
        self._samples = list(recording.samples())
        self._speed = as_number(speed, "speed", _SLOWEST, _FASTEST)
        self._now_s = now_s
        self._position_s = 0.0
        self._next = 0
        self.paused = False

    @property
    def duration_s(self) -> float:
        """Of the recording at its own speed, s."""
        return float(self._times_s[-1])

    @property
    def position_s(self) -> float:
        """How far it has been played, s of the recording."""
        return self._position_s

    @property
    def is_over(self) -> bool:
        """Whether every sample was handed out."""
        return self._next >= len(self._samples)

    @property
    def speed(self) -> float:
        """How many seconds of the recording go by in one."""
        return self._speed

    def set_speed(self, speed: float, now_s: float) -> list[DeviceSample]:
        """Go on at another speed; the samples that were due until now."""
        due = self.take(now_s)
        self._speed = as_number(speed, "speed", _SLOWEST, _FASTEST)
        return due

    def take(self, now_s: float) -> list[DeviceSample]:
        """The samples that have become due, oldest first."""
        if not self.paused:
            gone = max(0.0, now_s - self._now_s) * self._speed
            self._position_s = min(self._position_s + gone, self.duration_s)
        self._now_s = max(self._now_s, now_s)
        first = self._next
        while self._next < len(self._samples) and self._times_s[self._next] <= self._position_s:
            self._next += 1
        return self._samples[first : self._next]
