"""When the hand did what an event reports: the device's own time on the program's clock.

A window system hands events over when the program asks for them, which is late and in bursts while
a picture is drawn. What depends on speed and standing must not depend on that, so the time that the
event itself carries counts. Where that is the monotonic clock's, as with X11 and Wayland on Linux,
it is taken as it is, however late the first event was handed over. Other clocks are mapped to the
monotonic one once for each kind of device, and again only while nothing is painted. Where the times
of another device lie ahead, as after its first event was handed over late, a stroke begins behind
them and keeps its pace. Where a device gives no times, or the same for all, the time of handing
over is evened out instead, and that is said.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["EventClock"]

_MS = 1_000_000
_TIE_NS = 125_000  # between events of one millisecond
_LOST_NS = 60_000 * _MS  # nobody waits so long for a picture: the clocks have parted
_AHEAD_NS = 20 * _MS  # an event cannot come before it happened; so much is rounding
_NEAR_MS = 5_000  # that an event's own time lies before its handing over, if both are of one clock
_WRAP_MS = 1 << 32  # X11 counts so far, and begins again
_STUCK = 16  # events of one time stamp: more come from no device with a clock
_FIRST_PERIOD_NS = 8 * _MS
_PERIODS_NS = 1 * _MS, 40 * _MS  # of devices, least and most
_PULL, _LEARN = 0.1, 0.1  # how fast evened times follow the handing over, and its period


@dataclass
class _Kind:
    """State of one kind of device's clock."""

    offset_ns: int  # of its stamps to the monotonic clock; untimed: of the handing over
    stamp_ms: int
    n_same: int = 0
    untimed: bool = False
    period_ns: float = _FIRST_PERIOD_NS
    handled_ns: int = 0


class EventClock:
    """Gives events the times at which they happened; they never stand still nor go back.

    Attributes
    ----------
    untimed : set of str
        Kinds of devices that give no times of their own, as found so far.
    """

    def __init__(self) -> None:
        self.untimed: set[str] = set()
        self._kinds: dict[str, _Kind] = {}
        self._last_ns: int | None = None

    def time_ns(self, kind: str, stamp_ms: int, handled_ns: int, painting: bool) -> int:
        """Return when an event happened, ns of the monotonic clock.

        Parameters
        ----------
        kind : str
            "pen", "mouse" or "touch": each may have a clock of its own.
        stamp_ms : int
            The event's own time; 0 for none.
        handled_ns : int
            When it was handed over, ns of the monotonic clock.
        painting : bool
            Whether a stroke is going on: the mapping then stays as it is.
        """
        known = self._kinds.get(kind)
        if known is None:
            known = self._kinds[kind] = _Kind(_offset_ns(stamp_ms, handled_ns), stamp_ms - 1)
            known.handled_ns = handled_ns - _FIRST_PERIOD_NS
        known.n_same = known.n_same + 1 if stamp_ms == known.stamp_ms else 0
        if stamp_ms <= 0 or known.n_same >= _STUCK:
            if not known.untimed:
                known.untimed, known.offset_ns = True, 0
            self.untimed.add(kind)
        elif known.n_same == 0 and known.untimed and stamp_ms > known.stamp_ms > 0:
            known.untimed = False  # it has begun to
            known.offset_ns = _offset_ns(stamp_ms, handled_ns)
        if known.untimed:
            time_ns = self._even_out(known, handled_ns, painting)
        else:
            time_ns = self._map_stamp(known, stamp_ms, handled_ns, painting)
            if not painting and self._last_ns is not None and time_ns < self._last_ns - _MS:
                known.offset_ns += self._last_ns + _TIE_NS - time_ns
        known.stamp_ms, known.handled_ns = stamp_ms, handled_ns
        if self._last_ns is not None:
            time_ns = max(time_ns, self._last_ns + _TIE_NS)
        self._last_ns = time_ns
        return time_ns

    def _map_stamp(self, known: _Kind, stamp_ms: int, handled_ns: int, painting: bool) -> int:
        time_ns = known.offset_ns + stamp_ms * _MS
        astray = time_ns > handled_ns + _AHEAD_NS or time_ns < handled_ns - _LOST_NS
        back = stamp_ms < known.stamp_ms
        later = self._last_ns is None or handled_ns > self._last_ns  # no stroke is squeezed by it
        if back or (astray and later and not painting):
            known.offset_ns = _offset_ns(stamp_ms, handled_ns)
            return known.offset_ns + stamp_ms * _MS
        return time_ns

    def _even_out(self, known: _Kind, handled_ns: int, painting: bool) -> int:
        if not painting:  # times that lead by more than evening out does are gone on with
            lead = 0 if self._last_ns is None else self._last_ns - handled_ns
            known.offset_ns = lead if lead > _AHEAD_NS else 0
        step = float(handled_ns - known.handled_ns)
        least, most = _PERIODS_NS
        if step <= most:  # a longer one is a pause, or a slow picture
            known.period_ns += _LEARN * (max(step, least) - known.period_ns)
        if self._last_ns is None or step > 5 * most:
            return handled_ns + known.offset_ns
        expected = self._last_ns + known.period_ns
        return round(expected + _PULL * (handled_ns + known.offset_ns - expected))


def _offset_ns(stamp_ms: int, handled_ns: int) -> int:
    """Offset from an event's own time to the monotonic clock, ns."""
    late_ms = (handled_ns // _MS - stamp_ms) % _WRAP_MS
    if late_ms < _NEAR_MS:
        return (handled_ns // _MS - late_ms - stamp_ms) * _MS
    return handled_ns - stamp_ms * _MS
