"""What fingers mean, step by step."""

import math

import pytest

from paint3d.app.model.input.fingers import Fingers

MS = 1_000_000


def said_by(*steps):
    """What is said over steps of (milliseconds, places); as (kind, ...) in order."""
    fingers = Fingers()
    return [one for ms, places in steps for one in fingers.follow(ms * MS, places)]


def kinds(said):
    return [one.kind for one in said]


def test_one_finger_paints_from_where_and_when_it_came_down():
    said = said_by((0, {1: (10, 10)}), (8, {1: (14, 10)}), (16, {1: (30, 10)}), (24, {}))
    assert kinds(said) == ["press", "move", "move", "lift"]
    assert [(one.time_ns // MS, one.x) for one in said] == [(0, 10), (8, 14), (16, 30), (24, 30)]


def test_a_dab_is_a_press_and_a_lift():
    assert kinds(said_by((0, {1: (10, 10)}), (60, {}))) == ["press", "lift"]
    held = said_by((0, {1: (10, 10)}), (130, {1: (11, 10)}), (200, {}))
    assert kinds(held) == ["press", "move", "lift"]


@pytest.mark.parametrize("count", [2, 3])
def test_taps_are_counted_and_leave_no_dot(count):
    down = {k: (100.0 * k, 50.0) for k in range(count)}
    one_by_one = [(20 * k, {j: down[j] for j in range(k + 1)}) for k in range(count)]
    said = said_by(*one_by_one, (120, down), (140, {0: down[0]}), (150, {}))
    assert [(one.kind, one.count) for one in said] == [("tap", count)]
    slow = said_by((0, down), (600, {}))
    assert slow == []


def test_two_fingers_move_zoom_and_roll():
    fingers = Fingers()
    fingers.follow(0, {1: (100, 100), 2: (200, 100)})
    said = []
    for k in range(1, 11):  # turned by a right angle clockwise, twice as far apart, moved by 50
        turn, half = 0.05 * math.pi * k, 50 * (1 + k / 10)
        x, y = 150 + 5 * k, 100
        dx, dy = half * math.cos(turn), half * math.sin(turn)
        places = {1: (x - dx, y - dy), 2: (x + dx, y + dy)}
        said += fingers.follow(10 * k * MS, places)
    said += fingers.follow(200 * MS, {})
    assert set(kinds(said)) == {"pinch"}
    factor = math.prod(one.factor for one in said)
    assert factor == pytest.approx(2.0, rel=0.15)  # the first pixels tell a drag from a tap
    assert sum(one.angle for one in said) == pytest.approx(-math.pi / 2, rel=0.15)
    assert sum(one.dx for one in said) == pytest.approx(50, abs=6)


def test_three_fingers_turn():
    places = {k: (100.0 * k, 50.0) for k in range(3)}
    moved = {k: (x + 20, y) for k, (x, y) in places.items()}
    again = {k: (x + 20, y) for k, (x, y) in moved.items()}
    said = said_by((0, places), (20, moved), (40, again), (60, {}))
    assert kinds(said) == ["turn", "turn"]
    assert said[1].dx == pytest.approx(20)


def test_a_second_finger_soon_takes_the_stroke_back_and_later_is_passed_over():
    began = [(0, {1: (10, 10)}), (20, {1: (40, 10)})]
    soon = said_by(*began, (120, {1: (60, 10), 2: (200, 10)}), (150, {}))
    assert kinds(soon) == ["press", "move", "cancel"]
    late = said_by(
        *began, (400, {1: (60, 10), 2: (200, 10)}), (420, {1: (80, 10), 2: (200, 10)}), (450, {})
    )
    assert kinds(late) == ["press", "move", "move", "move", "lift"]
    lifted = said_by(*began, (400, {1: (60, 10), 2: (9, 9)}), (420, {2: (9, 9)}), (450, {}))
    assert kinds(lifted) == ["press", "move", "move", "lift"]


def test_a_finger_that_stays_begins_nothing_new():
    said = said_by(
        (0, {1: (0, 0), 2: (90, 0)}), (20, {1: (30, 0), 2: (120, 0)}), (40, {2: (120, 0)}),
        (60, {2: (150, 50)}), (80, {}), (100, {3: (5, 5)}), (110, {}),
    )  # fmt: skip
    assert kinds(said) == ["pinch", "press", "lift"]
    fingers = Fingers()
    fingers.follow(0, {1: (0, 0)})
    assert kinds(fingers.follow(10 * MS, {1: (50, 0)})) == ["press", "move"]
    assert kinds(fingers.cancel(20 * MS)) == ["cancel"]
    assert kinds(fingers.follow(30 * MS, {4: (0, 0)})) == []
    assert kinds(fingers.follow(40 * MS, {})) == ["press", "lift"]
