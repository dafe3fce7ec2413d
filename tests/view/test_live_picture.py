"""What is drawn next: no picture takes long, however slow the machine."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.view import live_picture
from paint3d.view.live_picture import LivePicture


class Clock:
    """A clock that knows no busy machine: each look at it takes half a millisecond."""

    def __init__(self) -> None:
        self.now = 100.0

    def perf_counter(self) -> float:
        self.now += 0.0005
        return self.now


@pytest.fixture(autouse=True)
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """Goes on by itself only where `now` is set forward."""
    counted = Clock()
    monkeypatch.setattr(live_picture, "time", counted)
    return counted


class Renderer:
    """Stands for a scene of a million triangles; a picture takes as long as it is told."""

    size = (320, 160)
    whole = (0, 0, 320, 160)
    is_software = True
    is_lost = False

    def __init__(self) -> None:
        self.us_a_triangle = 0.0
        self.triangles = 1_000_000
        self.frame_s, self.share = 0.0, 1.0

    def seen(self) -> tuple[int, int]:
        return 1_000_000, 300

    def prepare(self, most: int) -> bool:
        self.triangles = most
        return True

    def draw_object(
        self,
        box: object = None,
        *,
        coarse: bool = False,
        fine: bool = False,
        share: float = 1.0,
    ) -> None:
        self.is_lost = self.is_lost and box not in (None, self.whole)
        self.share = share
        self.frame_s = 0.002 + 0.006 * share**2 + 1e-6 * self.us_a_triangle * self.triangles

    def smooth(self, box: object) -> None:
        self.frame_s = 0.002

    def show(self, box: object = None, *, fine: bool = False, keep: bool = True) -> np.ndarray:
        assert not self.is_lost, "what is asked for is gone"
        self.is_lost = not keep or self.share < 1.0
        return np.zeros((160, 320, 4), np.uint8)


def turned(picture: LivePicture, n: int) -> None:
    """As many pictures of a view that moves."""
    for _ in range(n):
        picture.touch()
        picture.draw()


def finish(picture: LivePicture) -> None:
    """Draw until nothing is left to draw: half a second of the counted clock, and not for ever."""
    for _ in range(2000):
        if picture.is_done():
            return
        picture.draw()
    pytest.fail("something is always left to draw")


@pytest.mark.parametrize("us_a_triangle", [0.2, 0.35])
def test_a_view_that_moves_is_drawn_in_time_by_a_slow_machine(us_a_triangle: float) -> None:
    renderer = Renderer()
    picture = LivePicture(renderer, renderer.prepare)  # type: ignore[arg-type]
    turned(picture, 20)
    assert (renderer.triangles, renderer.share) == (120_000, 1.0)
    renderer.us_a_triangle = us_a_triangle
    turned(picture, 40)
    assert renderer.frame_s <= 0.018
    assert renderer.triangles >= 30_000
    renderer.us_a_triangle = 0.05  # it is quick again
    turned(picture, 120)
    assert (renderer.triangles, renderer.share) == (120_000, 1.0)


def test_it_is_never_drawn_more_coarsely_than_can_be_looked_at() -> None:
    renderer = Renderer()
    renderer.us_a_triangle = 10.0
    picture = LivePicture(renderer, renderer.prepare)  # type: ignore[arg-type]
    turned(picture, 200)
    assert (renderer.triangles, renderer.share) == (30_000, 0.5)


def test_what_could_not_be_drawn_in_time_is_tried_ever_more_seldom() -> None:
    renderer = Renderer()
    renderer.us_a_triangle = 0.12  # in time by two thirds of the pixels, not by all
    picture = LivePicture(renderer, renderer.prepare)  # type: ignore[arg-type]
    tried = []
    for k in range(1500):
        turned(picture, 1)
        if renderer.frame_s > 0.018:
            tried.append(k)
    assert 0 < len(tried) < 60
    assert np.diff(tried).max() > 250


def test_one_late_picture_changes_nothing() -> None:
    renderer = Renderer()
    picture = LivePicture(renderer, renderer.prepare)  # type: ignore[arg-type]
    for _ in range(12):
        renderer.us_a_triangle = 5.0
        turned(picture, 1)
        renderer.us_a_triangle = 0.07
        turned(picture, 4)
    assert renderer.triangles == 120_000


def test_what_is_not_kept_while_the_view_moves_is_drawn_before_it_is_needed(clock) -> None:
    renderer = Renderer()
    picture = LivePicture(renderer, renderer.prepare)  # type: ignore[arg-type]
    turned(picture, 1)
    assert not renderer.is_lost  # nobody knows yet that it goes on
    turned(picture, 3)
    assert renderer.is_lost
    assert picture.draw() is None  # nothing is asked for, and it may go on
    picture.touch_front((10, 10, 20, 20))
    assert picture.draw() is not None
    assert not renderer.is_lost
    turned(picture, 3)
    assert renderer.is_lost
    clock.now += 0.2
    finish(picture)
    assert not renderer.is_lost


def test_fewer_pixels_are_drawn_only_while_the_view_moves(clock) -> None:
    renderer = Renderer()
    renderer.us_a_triangle = 10.0
    picture = LivePicture(renderer, renderer.prepare)  # type: ignore[arg-type]
    turned(picture, 50)
    assert renderer.share < 1.0
    assert renderer.is_lost
    assert not picture.is_done()
    for touch in (picture.touch_object, picture.touch_front):  # ink comes, the brush moves
        touch((10, 10, 20, 20))
        assert picture.draw() is not None
        assert renderer.share < 1.0  # or what moves would be now blurred, now sharp
        turned(picture, 1)
        assert renderer.share < 1.0
    clock.now += 0.2
    finish(picture)
    assert renderer.share == 1.0


def test_what_is_drawn_for_a_file_is_no_view_that_moves() -> None:
    renderer = Renderer()
    renderer.us_a_triangle = 10.0
    renderer.draw = lambda **_: np.zeros((160, 320, 4), np.uint8)  # type: ignore[attr-defined]
    picture = LivePicture(renderer, renderer.prepare)  # type: ignore[arg-type]
    turned(picture, 50)
    assert renderer.share < 1.0
    picture.draw()
    picture.draw_whole(fine=False)
    assert picture.draw() is not None
    assert renderer.share == 1.0


def test_edges_are_smoothed_once_nothing_moves(clock, monkeypatch) -> None:
    renderer, drawn = Renderer(), []
    draw = renderer.draw_object
    monkeypatch.setattr(
        renderer, "draw_object", lambda *a, **how: drawn.append(False) or draw(*a, **how)
    )
    monkeypatch.setattr(renderer, "smooth", lambda _: drawn.append(True))
    picture = LivePicture(renderer, renderer.prepare)  # type: ignore[arg-type]
    turned(picture, 2)
    clock.now += 0.2  # it stands, but not for long
    picture.draw()
    assert not any(drawn)
    finish(picture)
    assert drawn.count(True) == 2  # as many cells as there are
    picture.touch_object((10, 10, 20, 20))
    picture.draw()
    assert not drawn[-1]
    finish(picture)
    assert drawn.count(True) == 3
