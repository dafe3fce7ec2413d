"""Undo and redo, to the bit, whatever happened between: the property of the way back."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.surface.ink_store import union
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.state import BRUSH_TRANSFER
from paint3d.surface.undo import UndoHistory
from tests.support.app.hands import line
from tests.support.cases import long_but
from tests.support.examples import examples

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from tests.support.app.gestures import drag, live, wait_for
from tests.support.app.pointers import places, tap
from tests.support.app.windows import faults, opened, settled

ACTIONS = st.sampled_from(
    ["stroke", "stroke", "time", "long time", "dry", "dip", "tip", "wipe", "look"]
)
PLACES = st.tuples(*[st.floats(-25, 25) for _ in range(4)])


def wide(array, columns):
    return np.pad(array, ((0, 0), (0, columns - array.shape[1])))


def state(surface, painter, n, columns):
    """Everything of the first n vertices, with so many pigments."""
    dry, ink = surface.dry_layers, surface.ink
    depth = np.zeros(n)
    kept = surface.keep_flow()
    if kept is not None:
        ids = kept["vertices"]
        depth[ids[ids < n]] = kept["water"][ids < n]
    return {
        "amounts": wide(surface.amounts[:n], columns),
        "coverage": surface.coverage[:n].copy(),
        "dried": dry.vertex_ids.copy(),
        "spectra": dry.spectra.copy(),
        "dried_amounts": wide(dry.amounts, columns),
        "dried_share": dry.coverage.copy(),
        "load": np.pad(ink.load, (0, columns - len(ink.load))),
        "off": np.pad(ink.off_surface, (0, columns - len(ink.off_surface))),
        "reservoirs": wide(ink.reservoirs, columns),
        "transfer": np.array(ink.transfer[BRUSH_TRANSFER].tolist()),
        "loaded": np.array(painter.loaded),
        "srgb": surface.srgb[:n].copy(),
        "water": depth,
    }


def act(surface, painter, action, place):
    if action == "stroke":
        painter.advance(line(place[:2], place[2:], n=12))
        painter.finish()
    elif action == "time":
        surface.diffuse(0.2)
    elif action == "long time":
        surface.diffuse(40.0)
    elif action == "dry":
        surface.dry()
    elif action == "dip":
        painter.dip("cinnabar")
    elif action == "tip":
        painter.dip({"pine soot": 1.0, "water": 3.0}, 0.4)
    elif action == "wipe":
        painter.wipe(0.3)
    else:
        surface.refresh()


@settings(deadline=None, max_examples=examples(40))
@given(
    steps=st.lists(
        st.lists(st.tuples(ACTIONS, PLACES), min_size=2, max_size=4), min_size=2, max_size=5
    ),
    budget=st.sampled_from([0, 1 << 30]),
)
def test_undo_and_redo_lead_back_to_the_bit(steps, budget):
    surface = PaintedSurface(load_mesh("plane"), 2.5, "xuan")
    painter = Painter(surface, pickup=0.03)
    for name in ("cinnabar", "water", "pine soot"):
        painter.dip(name)
    history = UndoHistory(surface, budget, painter.keep, painter.restore)
    n, columns = surface.n_vertices, len(surface.pigments)
    sizes, seen = [n], [state(surface, painter, n, columns)]
    for step in steps:
        history.begin("step")
        for action, place in step:
            act(surface, painter, action, place)
        sizes.append(surface.n_vertices)
        seen.append(state(surface, painter, surface.n_vertices, columns))
    if budget == 0:
        done, _, _ = history.steps()
        assert not sum(part.n_bytes for old in done[:-1] for part in old.parts)
    back = [*range(len(steps) - 1, -1, -1)]
    for k in [*back, *range(1, len(steps) + 1), *back]:
        history.undo() if len(history.done) > k else history.redo()
        now = state(surface, painter, sizes[k], columns)
        for name, then in seen[k].items():
            np.testing.assert_array_equal(now[name], then, err_msg=name)
        accounts = painter.ledger()
        gone = accounts.pop("loaded") - sum(accounts.values())
        assert abs(gone) < 1e-4 * painter.tuft.load


def test_the_first_water_dipped_in_and_taken_back_is_known_afterwards():
    """Else ink that has drained into paper no longer counts, until the painting is reopened."""
    surface = PaintedSurface(load_mesh("plane"), 4.0)
    painter = Painter(surface)
    history = UndoHistory(surface, 10**8, painter.keep, painter.restore)
    history.begin("dip")
    painter.dip({"pine soot": 1.0, "water": 3.0})
    history.undo()
    painter.dip({"pine soot": 1.0, "water": 3.0})
    names = [pigment.name for pigment in surface.pigments]
    assert surface.ink.transfer["water"].tolist() == [names.index("water")]


def test_a_step_takes_room_for_what_it_touched_only():
    surface = PaintedSurface(load_mesh("plane"), 2.5)
    painter = Painter(surface)
    history = UndoHistory(surface, keep=painter.keep, restore=painter.restore)
    surface.refine_all()
    sizes = []
    for y in (0, 20):
        history.begin(y)
        act(surface, painter, "stroke", (-10, y, 10, y))
        history.begin("next")
        sizes.append(history.n_bytes - sum(sizes))
    painted = np.count_nonzero(surface.coverage)
    assert surface.n_vertices > 20 * painted
    assert max(sizes) < 24 * painted


def test_what_was_undone_goes_when_something_new_comes():
    surface = PaintedSurface(load_mesh("plane"), 2.5)
    painter = Painter(surface)
    history = UndoHistory(surface, keep=painter.keep, restore=painter.restore)
    assert not len(history.undo())
    assert not len(history.redo())
    for label in "ab":
        history.begin(label)
        act(surface, painter, "stroke", (-10, 0, 10, 0))
    history.undo()
    assert (history.done, history.undone) == (["a"], ["b"])
    history.begin("c")
    assert (history.done, history.undone) == (["a", "c"], [])


PLACES = [(-3, 2, 3, -2), (-10, 20, 10, -20), (-10, 70, 10, 60)]


@pytest.mark.parametrize(
    ("place", "redo"),
    long_but(zip(PLACES, (True, False, True), strict=True), product(PLACES, (True, False))),
)
def test_time_goes_on_after_undo_as_if_the_step_had_never_been(place, redo):
    surfaces = []
    for again in (False, True):
        surface = PaintedSurface(load_mesh("plane"), 2.0, "xuan")
        surface.refine_all()
        painter = Painter(surface)
        history = UndoHistory(surface, keep=painter.keep, restore=painter.restore)
        history.begin("a")
        act(surface, painter, "stroke", (-10, 0, 10, 0))
        surface.diffuse(0.3)
        surface.refresh()
        if again:
            history.begin("b")
            act(surface, painter, "stroke", place)
            surface.diffuse(2.0)
            history.undo()
        if again and redo:  # also from where no water had ever moved
            history.undo()
            history.redo()
        surface.diffuse(3.0)
        surfaces.append(surface)
    one, two = surfaces
    np.testing.assert_array_equal(two.amounts, one.amounts)
    np.testing.assert_array_equal(two.srgb, one.srgb)
    assert two.flow.water == pytest.approx(one.flow.water, rel=1e-12)


def test_redo_first_takes_back_what_the_clock_did_since():
    surface = PaintedSurface(load_mesh("plane"), 2.5, "xuan")
    painter = Painter(surface)
    history = UndoHistory(surface, keep=painter.keep, restore=painter.restore)
    for y in (0, 8):
        history.begin(y)
        act(surface, painter, "stroke", (-10, y, 10, y))
        surface.diffuse(0.3)
    n, then = surface.n_vertices, None
    then = state(surface, painter, n, 1)
    history.undo()
    surface.diffuse(2.0)
    history.redo()
    now = state(surface, painter, n, 1)
    for name in then:
        np.testing.assert_array_equal(now[name], then[name], err_msg=name)


def test_old_steps_go_to_the_disk_and_come_back():
    surface = PaintedSurface(load_mesh("plane"), 2.5)
    painter = Painter(surface)
    history = UndoHistory(surface, 0, painter.keep, painter.restore)
    for y in (0, 10, 20):
        history.begin(y)
        act(surface, painter, "stroke", (-10, y, 10, y))
    history.begin("last")
    assert history.n_spilled == 3
    assert history.n_bytes == 0
    for _ in range(4):
        history.undo()
    assert not surface.painted.any()


def test_rows_that_were_taken_back_are_as_new_for_what_dries_next():
    def dried(again):
        surface = PaintedSurface(load_mesh("plane"), 2.5)
        surface.refine_all()
        painter = Painter(surface)
        history = UndoHistory(surface, keep=painter.keep, restore=painter.restore)
        for y in [0, 15] if again else [15]:
            history.begin(y)
            act(surface, painter, "stroke", (-10, y, 10, y))
            surface.dry()
            if y == 0:
                history.undo()
        return surface.dry_layers

    once, again = dried(False), dried(True)
    np.testing.assert_array_equal(again.amounts, once.amounts)
    np.testing.assert_array_equal(again.coverage, once.coverage)


@pytest.mark.parametrize("memory", [0, 1 << 30])
def test_reverting_forgets_the_step(memory):
    surface = PaintedSurface(load_mesh("plane"), 2.5)
    painter = Painter(surface)
    history = UndoHistory(surface, memory, painter.keep, painter.restore)
    history.begin("a")
    act(surface, painter, "stroke", (-10, 0, 10, 0))
    history.revert()
    assert (history.done, history.undone) == ([], [])
    assert not surface.painted.any()


@pytest.mark.parametrize("capacity", [6, 10_000])
def test_sets_of_vertices_are_joined_by_marks_or_by_sorting(capacity):
    joined = union([np.array([5, 1], np.int32), np.array([1, 3])], capacity)
    assert joined.dtype == np.int32
    assert joined.tolist() == [1, 3, 5]
    assert union([], capacity).tolist() == []


# -- in quick succession -----------------------------------------------------------------------


CTRL, SHIFT = QtCore.Qt.KeyboardModifier.ControlModifier, QtCore.Qt.KeyboardModifier.ShiftModifier
N_STROKES = 4


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 2.5, "xuan", drawn=False) as window, faults() as found:
        yield window
        assert not found


def give_keys(window) -> None:
    """Give the keyboard to the canvas."""
    window.activateWindow()
    wait_for(window.isActiveWindow)
    window.canvas.setFocus()


@pytest.fixture(params=["dry", "wet"])
def painted(window, request: pytest.FixtureRequest):
    """A window with some strokes, and codes of all colours after none, one, two... of them."""
    assert window.opening.open_path("plane", 2.5, "xuan", asked=True)
    window.stage.paint_thread.wet = request.param == "wet"
    give_keys(window)
    seen = [colours(window)]
    for y in np.linspace(0.35, 0.65, N_STROKES):
        drag(window.canvas, (0.42, y), (0.58, y), n=6)
        settled(window)
        seen.append(colours(window))
    return window, seen


def colours(window) -> np.ndarray:
    with window.stage.paint_thread.paused() as document:
        n = document.surface.source.n_vertices
        return document.surface.srgb[:n].copy()


@contextmanager
def no_frames(window) -> Iterator[None]:
    """Let no frame come meanwhile, as on a machine that is busy."""
    window.workspace.hold()
    try:
        yield
    finally:
        window.workspace.go_on()


def ask(window, step: str) -> None:
    keys = CTRL if step == "undo" else CTRL | SHIFT
    QtTest.QTest.keyClick(window.canvas, QtCore.Qt.Key.Key_Z, keys)


def wait_for_buttons(window, *enabled: bool) -> None:
    actions = window.workspace.actions["undo"], window.workspace.actions["redo"]
    wait_for(lambda: tuple(action.isEnabled() for action in actions) == enabled)


@pytest.mark.parametrize("seed", long_but([1], range(8)))
def test_any_keys_of_undo_and_redo_leave_what_they_spell(painted, seed: int) -> None:
    window, seen = painted
    document, chance, done = window.document, random.Random(seed), N_STROKES
    for _ in range(12):  # else where they end hides what was lost: undo at the start does nothing
        for _ in range(chance.randint(2, 5)):
            step = chance.choice(["undo", "redo"])
            done = min(max(0, done + (1 if step == "redo" else -1)), N_STROKES)
            ask(window, step)
            live(chance.choice([0.0, 0.0, chance.uniform(0.0, 0.06)]))
        settled(window)
        assert (len(document.strokes), len(document.undone_strokes)) == (done, N_STROKES - done)
        if not window.stage.paint_thread.wet:  # on which water goes on running
            np.testing.assert_array_equal(colours(window), seen[done])
        wait_for_buttons(window, done > 0, done < N_STROKES)


def fine_colours(window) -> np.ndarray:
    """Codes of all vertices, also of those that strokes have added."""
    with window.stage.paint_thread.paused() as document:
        return document.surface.codes.copy()


@pytest.fixture
def running_ink(window):
    """A wet scroll whose ink runs, and codes after none, one, two... of its strokes.

    They are taken just before the next stroke, where undo leads back to; no time passes meanwhile.
    """
    assert window.opening.open_path("scroll:170x680", 0.6, "xuan", asked=True)
    thread = window.stage.paint_thread
    give_keys(window)
    seen = [fine_colours(window)]
    for y in np.linspace(0.35, 0.65, N_STROKES):
        drag(window.canvas, (0.46, y), (0.54, y), n=6)
        thread.wet = True
        live(0.2)
        thread.wet = False
        settled(window)
        seen.append(fine_colours(window))
    thread.wet = True
    return window, seen


@pytest.mark.parametrize("seed", long_but([2], range(4)))
def test_two_hundred_keys_in_haste_on_a_wet_scroll_leave_what_they_spell(
    running_ink, seed: int
) -> None:
    window, seen = running_ink
    document, chance, done = window.document, random.Random(seed), N_STROKES
    for count in range(1, 201):
        step = chance.choice(["undo", "redo"])
        done = min(max(0, done + (1 if step == "redo" else -1)), N_STROKES)
        ask(window, step)
        live(0.02 * 15.0 ** chance.random())  # s: 20 to 300 ms, half of them below 80
        if count % 20 == 0:  # else the ends hide what was lost: undo does nothing at the start
            settled(window)
            assert (len(document.strokes), len(document.undone_strokes)) == (
                done, N_STROKES - done,
            )  # fmt: skip
    window.stage.paint_thread.wet = False
    for _ in range(done, N_STROKES):
        ask(window, "redo")
    for done in reversed(range(N_STROKES)):
        ask(window, "undo")
        settled(window)
        np.testing.assert_array_equal(fine_colours(window)[: len(seen[done])], seen[done])


def test_a_redo_right_after_an_undo_saves_the_stroke_from_the_next_one(painted) -> None:
    window, _ = painted
    ask(window, "undo")
    ask(window, "redo")
    drag(window.canvas, (0.45, 0.3), (0.55, 0.3), n=5)
    settled(window)
    assert len(window.document.strokes) == N_STROKES + 1


def test_an_undo_right_after_the_first_stroke_is_heard(window) -> None:
    assert window.opening.open_path("plane", 2.5, "xuan", asked=True)
    window.canvas.setFocus()
    settled(window)
    with no_frames(window):
        drag(window.canvas, (0.42, 0.5), (0.58, 0.5), n=6)
        ask(window, "undo")
    settled(window)
    assert (len(window.document.strokes), len(window.document.undone_strokes)) == (0, 1)


def test_taps_of_fingers_are_heard_as_quickly(painted) -> None:
    window, _ = painted
    two, three = places(window, (0.42, 0.5), (0.58, 0.5)), [(0.42, 0.5), (0.58, 0.5), (0.5, 0.6)]
    with no_frames(window):
        tap(window.canvas, *two)
        tap(window.canvas, *places(window, *three))
    settled(window)
    assert len(window.document.strokes) == N_STROKES


def test_with_nothing_open_they_do_nothing(program) -> None:
    from paint3d.app.window.studio import StudioWindow

    window = StudioWindow(program)
    window.show()
    window.activateWindow()
    wait_for(window.isActiveWindow)
    with faults() as found:
        ask(window, "undo")
        ask(window, "redo")
        window.steering.asked.emit("undo")
        live()
    assert not found
    window.close()
