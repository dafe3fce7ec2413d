"""What is drawn bit by bit is, to the bit, what would be drawn at once."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from paint3d.app.model.document import Document
from paint3d.app.window.files.open_result import OpenResult
from paint3d.app.window.stage import Stage
from paint3d.device.sample import DeviceSample
from paint3d.view import live_picture, live_scene
from paint3d.view.camera import View, fit_camera
from paint3d.view.live_light import LiveLight

SIZE = (317, 243)  # odd on purpose: no share of it is a round number
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def sample(k: int, x: float, y: float, z: float = 32.0, pressure: float | None = None):
    place = np.array([x, y, z])
    return DeviceSample(4_000_000 * (k + 1), place, UPRIGHT, pressure, 0, np.zeros(3), UPRIGHT)


def standing(name: str, resolution: float, view: View, screen: str) -> Stage:
    assert screen
    stage = Stage(SIZE)
    stage.open(OpenResult.of(Document.new(name, resolution, "xuan")))
    stage.set_camera(fit_camera(stage.points, view, SIZE[0] / SIZE[1]))
    until = time.perf_counter() + 300.0
    while not (stage.is_lit and stage.paint_thread.is_still):
        assert time.perf_counter() < until
        stage.follow()
        time.sleep(0.005)
    stage.draw()
    return stage


def test_the_first_picture_comes_before_soft_light_is_looked_for(
    screen: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert screen
    looked: list[LiveLight] = []
    bake = LiveLight.bake
    monkeypatch.setattr(LiveLight, "bake", lambda light: looked.append(light) or bake(light))
    stage = Stage(SIZE)
    stage.open(OpenResult.of(Document.new("plane", 3.0, "xuan")))
    view = View((0.2, -0.6, 1.0), (0, 1, 0))
    stage.set_camera(fit_camera(stage.points, view, SIZE[0] / SIZE[1]))
    assert stage.draw() is not None
    assert looked == []
    assert not stage.is_lit
    until = time.perf_counter() + 300.0
    while not stage.is_lit:
        assert time.perf_counter() < until
        stage.follow()
        time.sleep(0.005)
    assert len(looked) == 1
    stage.close()


@pytest.fixture(autouse=True, scope="module")
def plain_edges() -> None:
    """Edges are smoothed here as users see them."""


@pytest.fixture(autouse=True)
def all_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw whole pictures by all of their pixels, though the machine may be slow."""
    monkeypatch.setattr(live_picture, "_LEVELS", ((120_000, 1.0),))


@pytest.fixture
def stage(screen: str) -> Iterator[Stage]:
    found = standing("plane", 1.5, View((0.2, -0.6, 1.0), (0, 1, 0)), screen)
    yield found
    found.close()


def follow(stage: Stage) -> None:
    """Take all that the painting thread has."""
    until = time.perf_counter() + 300.0
    while not stage.paint_thread.is_still:
        assert time.perf_counter() < until
        stage.follow()
        time.sleep(0.001)
    stage.follow()


def at_once(stage: Stage) -> NDArray:
    """All of the picture drawn anew, as the next picture will be again."""
    stage.touch()
    return stage.draw().copy()


def test_a_brush_that_wanders_leaves_nothing_behind(stage: Stage) -> None:
    rng, place = np.random.default_rng(4), np.zeros(2)
    for k in range(25):
        place = np.clip(place + rng.normal(0.0, 28.0, 2), -115.0, 115.0)  # over the edge too
        stage.paint_thread.hover(sample(k, *place, z=float(rng.uniform(8.0, 60.0))))
        follow(stage)
        drawn = stage.draw().copy()
        assert np.array_equal(drawn, at_once(stage)), f"step {k}, brush at {place}"
    stage.hide_brush()
    assert np.array_equal(stage.draw().copy(), at_once(stage))


def test_paint_is_drawn_in_its_place_to_the_bit(stage: Stage) -> None:
    stage.paint_thread.post("dip").result()
    stage.paint_thread.post("begin_stroke").result()
    for k in range(12):
        stage.paint_thread.feed([sample(k, 12.0 * k - 70.0, 9.0 * np.sin(k), 20.0, 0.4)])
        follow(stage)
        drawn = stage.draw().copy()
        assert np.array_equal(drawn, at_once(stage)), f"step {k}"
    stage.paint_thread.post("end_stroke").result()
    with stage.paint_thread.paused() as document:
        assert document.surface.painted.sum() > 50


def test_lines_of_which_few_change_are_drawn_anew_only_there(stage: Stage) -> None:
    """Else a large sheet would be drawn coarsely at each character that is written on it."""
    places, red = np.linspace(-70.0, 70.0, 6), (200, 40, 30, 220)
    lines = [np.array([(x, -6.0, 0.1), (x + 9.0, 7.0, 0.1), (x, 8.0, 0.1)]) for x in places]
    stage.show_lines("marks", lines, red, 2.0)
    bare = stage.draw().copy()
    for fewer, colour in ((lines[1:], red), (lines[1:], red), (lines[2:], red), (lines, red)):
        stage.show_lines("marks", [line.copy() for line in fewer], colour, 2.0)
        drawn = stage.draw()
        if drawn is not None:
            x0, y0, x1, y1 = stage.changed or (0, 0, *SIZE)
            assert (x1 - x0) * (y1 - y0) < 0.1 * SIZE[0] * SIZE[1]
            drawn = drawn.copy()
            assert np.array_equal(drawn, at_once(stage))
    assert np.array_equal(drawn, bare)
    stage.show_lines("marks", lines, (30, 40, 200, 220), 2.0)  # all of them, in another colour
    drawn = stage.draw().copy()
    assert not np.array_equal(drawn, bare)
    assert np.array_equal(drawn, at_once(stage))


def test_the_brush_is_drawn_where_the_hand_is_while_the_painting_is_behind(stage: Stage) -> None:
    stage.paint_thread.hover(sample(0, -60.0, 0.0))
    follow(stage)
    before = stage.draw().copy()
    with stage.paint_thread.paused():
        stage.paint_thread.hover(sample(1, 60.0, 0.0))
        assert stage.paint_thread.newest.position[0] == 60.0
        moved = stage.draw()
        assert moved is not None
        moved = moved.copy()
    follow(stage)
    later = stage.draw()
    changed = np.abs(moved.astype(int) - before).sum(axis=2) > 30
    columns = np.flatnonzero(changed.any(axis=0))
    assert columns.max() > 0.6 * SIZE[0]  # it is where the hand is,
    assert columns.min() < 0.4 * SIZE[0]  # and no longer where it was
    if later is not None:
        away = np.abs(later.astype(int) - moved).sum(axis=2) > 30
        assert away.sum() < 0.02 * away.size  # as it is drawn when the painting has come there


def test_a_view_that_moves_is_drawn_coarsely_and_then_to_the_last_triangle(
    screen: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live_picture, "_MANY", 2000)
    monkeypatch.setattr(live_picture, "_CELL", 64)
    stage = standing("bowl", 4.0, View((0.12, -1.0, 0.62)), screen)
    if not stage.scene.is_software:
        pytest.skip("a graphics card draws every triangle")
    stage.set_camera(fit_camera(stage.points, View((0.5, -1.0, 0.62)), SIZE[0] / SIZE[1]))
    coarse = stage.draw().copy()
    assert not stage.is_drawn
    pictures, until = [], time.perf_counter() + 300.0
    while not stage.is_drawn:
        assert time.perf_counter() < until
        drawn = stage.draw()
        if drawn is not None:
            pictures.append(drawn.copy())
        time.sleep(0.002)
    assert len(pictures) > 1
    fine, whole = pictures[-1], stage.picture(fine=True).copy()
    assert np.array_equal(fine, whole)
    away = np.abs(coarse.astype(int) - whole).max(axis=2)
    assert 0 < (away > 12).mean() < 0.05  # coarse, but the same thing
    stage.close()


def test_ink_that_runs_by_itself_is_taken_seldom_until_the_hand_moves(
    screen: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage = standing("plane", 6.0, View((0.0, -0.45, 1.0)), screen)
    thread, until = stage.paint_thread, time.perf_counter() + 300.0
    thread.wet = True
    for after_s, taken in ((60.0, False), (0.0, True)):
        monkeypatch.setattr(stage, "_cost_s", 1.0)  # a picture took so long
        monkeypatch.setattr(stage, "_taken_s", time.monotonic())
        thread.hover(sample(0, 0.0, 0.0))
        while thread.is_still or thread._slot is None:
            assert time.perf_counter() < until
            time.sleep(0.002)
        thread.last_asked_s = time.monotonic() - after_s
        assert (stage.follow() is not None) == taken
    stage.close()


@pytest.mark.parametrize(("long_s", "falls_short"), [(0.0, True), (1e9, False)])
def test_a_card_that_takes_long_draws_coarsely_while_the_view_moves_and_none_else(
    screen: str, monkeypatch: pytest.MonkeyPatch, long_s: float, falls_short: bool
) -> None:
    monkeypatch.setattr(live_scene, "_SOFTWARE", ())  # what draws passes for a card
    monkeypatch.setattr(live_picture, "_CARD_LEVELS", ((math.inf, 1.0), (2000, 1.0)))
    monkeypatch.setattr(live_picture, "_CARD_LONG_S", long_s)
    monkeypatch.setattr(live_picture, "_SETTLED_S", 2.0)  # a busy machine draws as slowly
    monkeypatch.setattr(live_picture, "_MANY", 100)
    monkeypatch.setattr(live_picture, "_CELL", 64)
    stage = standing("bowl", 4.0, View((0.12, -1.0, 0.62)), screen)
    assert not stage.scene.is_software
    for k in range(12):
        view = View((0.1 * k, -1.0, 0.62))
        stage.set_camera(fit_camera(stage.points, view, SIZE[0] / SIZE[1]))
        moving = stage.draw().copy()
    assert stage.scene.has_coarse == falls_short
    shown, until, n_drawn, draw = moving, time.perf_counter() + 300.0, [], stage.scene.draw_object
    monkeypatch.setattr(stage.scene, "draw_object", lambda *at: n_drawn.append(at) or draw(*at))
    while not stage.is_drawn:
        assert time.perf_counter() < until
        drawn = stage.draw()
        shown = shown if drawn is None else drawn.copy()
        time.sleep(0.002)
    assert n_drawn == [()] * falls_short  # all of it at once, not cell by cell
    monkeypatch.setattr(stage.scene, "draw_object", draw)
    whole = stage.picture().copy()
    away = np.abs(moving.astype(int) - whole).max(axis=2)
    assert ((away > 12).any()) == falls_short
    assert (away > 12).mean() < 0.05
    assert np.array_equal(shown, whole)
    stage.close()


def test_a_brush_before_a_view_that_moves_has_no_card_draw_all_triangles(
    screen: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live_scene, "_SOFTWARE", ())
    monkeypatch.setattr(live_picture, "_CARD_LEVELS", ((math.inf, 1.0), (2000, 1.0)))
    monkeypatch.setattr(live_picture, "_CARD_LONG_S", 0.0)
    monkeypatch.setattr(live_picture, "_SETTLED_S", 1e9)  # the view never rests
    stage = standing("bowl", 4.0, View((0.12, -1.0, 0.62)), screen)
    stage.paint_thread.hover(sample(0, -20.0, 0.0, 60.0))
    follow(stage)
    for k in range(8):
        view = View((0.1 * k, -1.0, 0.62))
        stage.set_camera(fit_camera(stage.points, view, SIZE[0] / SIZE[1]))
        stage.draw()
    drawn: list[bool] = []
    draw = stage.scene.draw_object
    monkeypatch.setattr(
        stage.scene,
        "draw_object",
        lambda *at, coarse=False, **how: drawn.append(coarse) or draw(*at, coarse=coarse, **how),
    )
    for k in range(1, 4):
        stage.paint_thread.hover(sample(k, 10.0 * k - 20.0, 0.0, 60.0))
        follow(stage)
        assert stage.draw() is not None
    assert drawn
    assert all(drawn)
    monkeypatch.setattr(live_picture, "_SETTLED_S", 0.0)  # it rests,
    monkeypatch.setattr(live_picture, "_MANY", 100)
    for _ in range(2):
        drawn.clear()
        stage.draw()
        assert drawn == [False]  # all of it at once
        stage.touch()  # and another light falls on it
    stage.draw()
    assert stage.is_drawn
    stage.close()
