"""The time that the ink of a wet replay is given after its last sample."""

from __future__ import annotations

import math

import numpy as np
import pytest

from paint3d.errors import InputError
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.surface_cases import flat, poses, sheet

LAST_NS = 1_020_000_000  # between two pieces


def wet_painter() -> Painter:
    surface = PaintedSurface(sheet(flat, (12.0, 6.0), 2.0), 0.8, "xuan")
    painter = Painter(surface, "slender", {"pine soot": 0.2, "water": 0.8})
    x = np.linspace(-8.0, 8.0, 20)
    points = np.stack([x, 0.0 * x, 0.0 * x], axis=1)
    pressure = np.full(20, 0.4)
    painter.replay(poses(points, (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), pressure, "slender"), wet=True)
    return painter


def test_ink_gets_its_own_time_though_it_stands_still_now_and_then(monkeypatch) -> None:
    painter = wet_painter()
    passed, shares, standing = [], [], [False, True, True, False, True]
    follow = painter.surface.follow_time

    def followed(seconds: float) -> bool:
        if painter.surface.keeps_up:
            passed.append(seconds)
        follow(seconds)
        painter.surface.keeps_up = not (standing and standing.pop())
        return painter.surface.keeps_up

    monkeypatch.setattr(painter.surface, "follow_time", followed)
    painter.rest(LAST_NS, 0.5, shares.append)
    assert passed == [0.05] * 10
    assert len(shares) == 13
    assert shares == sorted(shares)
    assert len(set(shares)) == 10
    assert shares[-1] == 1.0


@pytest.mark.parametrize(("seconds", "pieces"), [(0.0, 0), (0.02, 0), (0.03, 1), (0.08, 2)])
def test_pieces_go_on_from_the_last_sample(seconds: float, pieces: int) -> None:
    shares: list[float] = []
    wet_painter().rest(LAST_NS, seconds, shares.append)
    assert len(shares) == pieces


@pytest.mark.parametrize("seconds", [3600.0, 1e300])
def test_no_more_time_passes_once_the_ink_is_dry(seconds: float) -> None:
    painter, shares = wet_painter(), []
    painter.surface.dry()
    painter.rest(LAST_NS, seconds, shares.append)
    assert len(shares) == 1
    assert shares[0] < 1e-3


@pytest.mark.parametrize("seconds", [math.nan, math.inf, -1.0, "long"])
def test_a_rest_that_is_no_time_is_refused(seconds: float) -> None:
    with pytest.raises(InputError, match=r"rest \(s\)"):
        wet_painter().rest(LAST_NS, seconds)
