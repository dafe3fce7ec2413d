"""The times of a device's events, however late and in whatever bursts they are handed over."""

from itertools import pairwise

from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.app.model.input.event_clock import EventClock

MS = 1_000_000
START_MS = 7_000_000


def times(stamps, handled, kind="pen"):
    clock = EventClock()
    found = [
        clock.time_ns(kind, stamp, round(at), painting=k > 0)
        for k, (stamp, at) in enumerate(zip(stamps, handled, strict=True))
    ]
    return found, clock


def steps(values):
    return [b - a for a, b in pairwise(values)]


WAITS = st.lists(st.floats(0.0, 400.0), min_size=30, max_size=30)


@settings(deadline=None)
@given(st.lists(st.integers(1, 60), min_size=30, max_size=30), WAITS)
def test_the_steps_are_the_devices_own(gaps, waits):
    stamps = [START_MS + sum(gaps[: k + 1]) for k in range(len(gaps))]
    late, at = [], 0.0
    for stamp, wait in zip(stamps, waits, strict=True):  # in order, and never before it happened
        at = max(at, 3e12 + (stamp - START_MS + wait) * MS)
        late.append(at)
    at_once, _ = times(stamps, [3e12 + (s - START_MS) * MS for s in stamps])
    found, clock = times(stamps, late)
    assert steps(found) == steps(at_once) == [MS * gap for gap in gaps[1:]]
    assert not clock.untimed


def test_events_of_one_millisecond_keep_their_order():
    found, clock = times([START_MS] * 8 + [START_MS + 1], [5e12] * 9)
    assert steps(found) == [125_000] * 8
    assert not clock.untimed


def test_a_device_without_times_gets_even_ones():
    handed = [5e12 + 200 * MS * (k // 25) + 10_000 * (k % 25) for k in range(100)]  # 5 a second
    for stamps in ([0] * 100, [START_MS] * 100):
        found, clock = times(stamps, handed)
        assert clock.untimed == {"pen"}
        later = steps(found)[25:]
        assert min(later) > 0
        assert max(later) < 60 * MS < max(steps(handed))


def test_a_stamp_that_jumps_back_does_not_turn_time():
    found, _ = times([START_MS, START_MS + 8, 50, 58], [5e12, 5e12 + 8e6, 5e12 + 16e6, 5e12 + 24e6])
    assert steps(found) == [8 * MS] * 3


def test_an_event_that_seems_to_come_from_the_future_maps_the_clock_anew_between_strokes():
    clock = EventClock()
    late = 300 * MS
    clock.time_ns("pen", START_MS, 5 * 10**12 + late, False)  # the first one waited for a picture
    handed = 5 * 10**12 + 100 * MS
    assert clock.time_ns("pen", START_MS + 100, 5 * 10**12 + late + 1, True) > handed
    clock.time_ns("pen", START_MS + 101, 5 * 10**12 + late + 2, False)  # a burst's pause
    assert clock.time_ns("pen", START_MS + 109, 5 * 10**12 + late + 3, True) == handed + 309 * MS
    found = clock.time_ns("pen", START_MS + 600, 5 * 10**12 + 600 * MS, False)
    assert found == 5 * 10**12 + 600 * MS


@given(late=st.integers(0, 4000), wraps=st.integers(0, 3), rest=st.integers(0, MS - 1))
def test_a_clock_that_is_the_programs_own_is_taken_as_it_is(late, wraps, rest):
    """However late the first event is handed over, the next stroke keeps its distance."""
    clock, now = EventClock(), START_MS + wraps * (1 << 32)
    for k, wait in enumerate((late, 0, late, 0)):
        handed = (now + 1000 * k + wait) * MS + rest
        found = clock.time_ns("pen", START_MS + 1000 * k, handed, False)
        assert found == (now + 1000 * k) * MS


def test_a_stroke_of_another_device_begins_behind_the_last_and_keeps_its_pace():
    clock, now = EventClock(), 5 * 10**12
    for k in range(100):  # handed over faster than the hand wrote
        pen = clock.time_ns("pen", START_MS + 10 * k, now + k, painting=k > 0)
    found = [
        clock.time_ns("touch", START_MS + 1000 + 10 * k, now + 200 * MS + k, painting=k > 0)
        for k in range(20)
    ]
    assert found[0] > pen
    assert steps(found) == [10 * MS] * 19
    later = clock.time_ns("touch", START_MS + 4000, now + 3200 * MS, painting=False)
    assert later == now + 3200 * MS
