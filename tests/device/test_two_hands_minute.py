"""Painting with both virtual hands, in simulated time: a few seconds of the minute."""

from __future__ import annotations

from scripts.two_hands_minute import simulate


def test_no_sample_is_lost_and_nothing_drifts() -> None:
    found = simulate(6.0, resolution=2.0)  # a swing, a rest, and a second more
    assert found.painted == found.sent == 6000
    assert found.late == 0
    assert found.ring_error_mm < 0.003
    assert found.last_second_error_mm < 0.003
    assert found.turn_error < 1e-9
    assert found.ink_error < 1e-6  # wet ink is kept in single precision
    assert 1.0 < found.strongest_n < 7.9
