"""Undo, redo and the history of strokes after a painting was saved and opened."""

from __future__ import annotations

import dataclasses
import itertools
import re
import shutil
from concurrent.futures import CancelledError
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.app.model import document as document_module
from paint3d.app.model.document import Document
from paint3d.app.model.input.symmetry import MirrorPlane, Symmetry
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, recoverable
from paint3d.errors import InputError
from paint3d.files.project.session import load_session, save_session
from paint3d.surface.state import BRUSH_TRANSFER
from tests.support.app.hands import paint, same_vertices, small_plane
from tests.support.app.repeating import repeated
from tests.support.examples import examples

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from paint3d.app.window.studio import StudioWindow
from tests.support.app.gestures import (
    BUTTON,
    KIND,
    drag,
    mouse,
    pen_stroke,
    wait_for,
)
from tests.support.app.windows import (
    SMALL,
    blind,
    click_row,
    close_unasked,
    press,
    pretend_saved,
    settled,
)

ACTIONS = st.sampled_from(
    ["stroke", "stroke", "stroke", "undo", "undo", "redo", "dry", "time", "dip", "tip", "wipe",
     "hairs", "mirror", "add", "remove", "move", "select"]
)  # fmt: skip
COMMANDS = st.lists(st.tuples(ACTIONS, st.integers(0, 2), st.floats(-20, 20)), max_size=7)


def act(document, action, place, y):
    """Do something that can be done; the same for the same document."""
    place = min(place, len(document.layers) - 1)
    if action == "stroke":
        paint(document, (-15, y), (15, -y), n=8)
    elif action == "dip":
        document.swap_inks()
    elif action == "tip":
        document.dip({"gamboge": 0.25, "water": 0.75}, 0.4)
    elif action == "hairs":
        document.set_brush("feibai" if document.painter.hairs is None else "full")
    elif action == "mirror":
        document.set_symmetry(Symmetry((MirrorPlane((0, 0, 0), (0, 1, 0)),)))
    elif action == "time":
        document.let_time_pass(0.3)
    elif action == "add":
        document.add_layer(place=place)
    elif action == "select":
        document.select_layer(place)
    elif action in ("undo", "redo", "dry", "wipe"):
        getattr(document, action)()
    elif len(document.layers) > 1 and action == "remove":
        document.remove_layer(place)
    elif len(document.layers) > 1:
        document.move_layer(place, 0)


def everything(document):
    """All that may differ between two paintings of the same strokes."""
    surface, painter = document.surface, document.painter
    ink, dry, flow = surface.ink, surface.dry_layers, surface.keep_flow()
    order = np.argsort(dry.vertex_ids)
    n = surface.n_vertices
    depth = np.zeros(n)
    if flow is not None:
        depth[flow["vertices"]] = flow["water"]
    hairs = np.empty(0) if painter.hairs is None else painter.hairs.keep()["load"]
    return {
        "codes": surface.srgb.copy(), "amounts": surface.amounts.copy(),
        "coverage": surface.coverage.copy(), "dried": dry.vertex_ids[order],
        "spectra": dry.spectra[order], "share": dry.coverage[order], "water": depth,
        "load": ink.load.copy(), "off": ink.off_surface.copy(), "reservoirs": ink.reservoirs.copy(),
        "transfer": np.array(ink.transfer[BRUSH_TRANSFER].tolist()), "hairs": hairs,
        "layers": np.array([layer.name for layer in document.layers]),
        "active": np.array(document.active_layer), "brush": np.array(painter.brush.name),
        "steps": np.array([len(document.steps.done), len(document.steps.undone)]),
        "strokes": np.array([
            [s.dipped_since_stroke, len(s.samples), s.duration_s] for s in document.strokes
        ]),
    }  # fmt: skip


def same(one, two):
    now, then = everything(one), everything(two)
    for name in then:
        np.testing.assert_array_equal(now[name], then[name], err_msg=name)
    assert one.painter.ledger() == pytest.approx(two.painter.ledger(), rel=1e-6, abs=1e-3)


def reopened(document, path):
    document.save(path)
    again = Document.open(path)
    assert again.refused_history is None
    return again


@settings(deadline=None, max_examples=25)
@given(before=COMMANDS, after=COMMANDS)
def test_saving_and_opening_changes_nothing_of_what_comes(tmp_path_factory, before, after):
    document = small_plane(2.0, material="xuan")
    document.painter.surface.ink.transfer["pickup"] = 0.03  # it picks wet ink up
    for ink in ("gamboge", "water", "cinnabar"):
        document.dip(ink)
    for action in before:
        act(document, *action)
    symmetry = document.symmetry
    again = reopened(document, tmp_path_factory.mktemp("saved") / "a.p3d")
    again.set_symmetry(symmetry)  # no part of a painting
    same(again, document)
    for action in after:
        for one in (document, again):
            act(one, *action)
        same(again, document)
    for way in ("undo", "redo", "undo"):
        while getattr(document, f"can_{way}"):
            for one in (document, again):
                getattr(one, way)()
            same(again, document)
        assert not getattr(again, f"can_{way}")


def test_saving_again_gives_the_same_file(tmp_path):
    document = small_plane(material="xuan")
    paint(document, (-20, 0), (20, 0))
    document.set_brush("feibai")
    document.let_time_pass(0.3)
    paint(document, (0, -20), (0, 20))
    paint(document, (9, -20), (9, 20))
    document.add_layer()
    document.undo()
    document.undo()
    document.save(tmp_path / "a.p3d")
    for name in ("b.p3d", "c.p3d"):
        document.save(tmp_path / name)
        assert (tmp_path / name).read_bytes() == (tmp_path / "a.p3d").read_bytes()
        document = Document.open(tmp_path / "a.p3d")


def without_steps(document, path):
    """A painting as it was saved before steps were, opened."""
    document.save(path)
    session = load_session(path)
    save_session(dataclasses.replace(session, undone=(), history=None), path)
    return Document.open(path)


def painting_on_layers():
    document = small_plane(material="xuan")
    paint(document, (-20, 0), (20, 0))
    document.add_layer("over")
    document.dip({"cinnabar": 0.5, "water": 0.5})
    document.scale_brush(0.7)
    paint(document, (0, -20), (0, 20))
    document.set_brush("feibai")
    paint(document, (5, -20), (5, 20))
    return document


def test_strokes_without_steps_are_painted_again_underneath(tmp_path):
    document = painting_on_layers()
    document.let_time_pass(0.4)  # which no stroke repeats
    opened = without_steps(document, tmp_path / "a.p3d")
    assert (opened.n_strokes_without_undo, opened.fewest_strokes, opened.can_undo) == (3, 0, True)
    paint(opened, (-20, 12), (20, 12))
    then, layers = everything(opened), opened.layers
    for upto in (3, 2, 1, 0):
        opened.undo()
        assert len(opened.strokes) == upto
        if upto < 3:
            wanted = repeated(opened, upto)
            same_paint(opened.surface, wanted.surface)
            assert [layer.name for layer in opened.layers] == ["1", "over"][: max(1, upto)]
        close(opened)
    assert not opened.can_undo
    while opened.can_redo:
        opened.redo()
    unchanged(opened, then)
    assert opened.layers == layers
    close(opened)
    again = reopened(opened, tmp_path / "b.p3d")
    assert again.n_strokes_without_undo == 0
    for upto in (1, 4, 0, 2):
        for one in (again, opened):
            one.replay_history(upto)
        same(again, opened)


def unchanged(document, then):
    """Nothing is other than then, though there may be more vertices."""
    now = everything(document)
    for name in set(then) - {"steps"}:
        value = now[name][: len(then[name])] if then[name].ndim else now[name]
        np.testing.assert_array_equal(value, then[name], err_msg=name)


def same_paint(one, two):
    """The same places are painted, with the same; sums of layers may be rounded to other codes."""
    seen = []
    for surface in (one, two):
        ids = np.flatnonzero(surface.painted)
        ids = ids[np.lexsort(surface.paint_mesh.vertices[ids].T)]
        seen.append((surface.paint_mesh.vertices[ids], surface.srgb[ids].astype(int)))
    (vertices, codes), (others, wanted) = seen
    np.testing.assert_array_equal(vertices, others)
    assert np.abs(codes - wanted).max(initial=0) <= 1


def close(document):
    """The ledger closes."""
    accounts = document.painter.ledger()
    loaded = accounts.pop("loaded")
    assert sum(accounts.values()) == pytest.approx(loaded, rel=1e-6)


def test_painting_again_can_be_stopped(tmp_path):
    opened = without_steps(painting_on_layers(), tmp_path / "a.p3d")
    paint(opened, (-20, 12), (20, 12))
    opened.undo()
    then, strokes = everything(opened), list(opened.strokes)

    def stop(share):
        if share > 0.5:
            raise CancelledError

    opened.progress = stop
    with pytest.raises(CancelledError):
        opened.replay_history(1)
    opened.progress = None
    unchanged(opened, then)
    assert opened.strokes == strokes
    assert (opened.n_strokes_without_undo, opened.can_redo) == (3, True)
    opened.redo()
    opened.replay_history(0)
    assert not opened.surface.painted.any()


def test_strokes_over_a_recording_are_not_painted_again(tmp_path):
    document = painting_on_layers()
    recording = document.recording()
    document.save(tmp_path / "a.p3d")
    session = load_session(tmp_path / "a.p3d")
    session = dataclasses.replace(session, recordings=(recording,), undone=(), history=None)
    save_session(session, tmp_path / "a.p3d")
    opened = Document.open(tmp_path / "a.p3d")
    assert not opened.can_undo
    assert opened.fewest_strokes == 3
    with pytest.raises(InputError, match="cannot go to stroke 1; expected 3 to 3"):
        opened.replay_history(1)
    with pytest.raises(InputError, match="lie over a recording"):
        opened.recall_strokes()


def test_only_the_nearest_steps_are_kept_where_there_are_too_many(tmp_path, monkeypatch):
    document = small_plane(material="xuan")
    for y in range(-20, 20, 8):
        paint(document, (-20, y), (20, y))
    document.undo()
    monkeypatch.setattr(document_module, "MOST_BYTES", 6_000)
    opened = reopened(document, tmp_path / "a.p3d")
    assert 0 < opened.n_strokes_without_undo < 4
    assert not opened.can_redo  # what was undone is farther
    same_vertices(opened.surface, document.surface)
    for one in (document, opened):
        one.replay_history(1)
    same_vertices(opened.surface, document.surface)
    opened.replay_history(4)
    document.replay_history(4)
    same_vertices(opened.surface, document.surface)


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """A session with steps of every kind."""
    document = painting_on_layers()
    document.let_time_pass(0.3)
    paint(document, (-20, 9), (20, 9))
    document.dry()
    paint(document, (-20, -9), (20, 9))
    document.dry()  # over what has dried: the step keeps what lay there before
    paint(document, (-20, -9), (20, -9))
    document.remove_layer(0)
    document.undo()
    document.undo()
    path = tmp_path_factory.mktemp("saved") / "a.p3d"
    document.save(path)
    return path


def first(value, number):
    """An array of which the first number is another."""
    array = np.array(value)
    array.flat[0] = number
    return array


DAMAGE = {
    "version": ("steps.version", lambda old: 99, "version 99"),
    "strokes": ("done", lambda old: ["stroke"], "steps are counted"),
    "words": ("done", lambda old: [7] * len(old), "expected a word|strokes; expected"),
    "none": ("steps.vertices", lambda old: None, "incomplete near|vertices is"),
    "range": ("steps.vertices", lambda old: first(old, 10**8), "holds .*expected 0 to"),
    "below": ("steps.dry_rows", lambda old: first(old, -1), "do not follow"),
    "count": ("steps.dry_count", lambda old: old + np.int32(2**31 - 9), "do not follow|rows of"),
    "much": ("steps.amounts", lambda old: first(old, 1e30), "holds what is no ink"),
    "nan": ("steps.coverage", lambda old: first(old, np.nan), "no ink|not a finite number"),
    "starts": ("steps.vertices_starts", lambda old: old * 2, "starts do not divide"),
    "of": ("steps.amounts_of", lambda old: first(old, 9999), "is given from"),
    "parts": ("steps.parts", lambda old: old + np.int32(1), "do not share out"),
    "stack": ("steps.stack", lambda old: first(old, 77), "stacks|load has shape"),
    "stacks": ("steps.stacks", lambda old: [[[0, 0], 0]] * len(old), "layers"),
    "layers": ("steps.layers", lambda old: [{"name": 1}] * 9, "described by|incomplete"),
    "brush": ("brushes", lambda old: [{"name": "x"}] * len(old), "describes no brush"),
    "painter": ("painter", lambda old: first(old, 99), "painters are"),
    "hairs": ("hair_loads", lambda old: -np.abs(old) - 1.0, "hairs is out of range"),
    "water": ("steps.flow_water", lambda old: first(old, -5.0), "flow_water holds"),
    "patch": ("steps.flow_size", lambda old: old + np.int32(10**8), "water is kept"),
    "flow rows": ("steps.flow_rows", lambda old: old[::-1].copy(), "not in order"),
    "flow": ("steps.flow_names", lambda old: ["water"], "incomplete near"),
    "stations": ("steps.stations_starts", lambda old: first(old, 1), "starts do not divide"),
    "loaded": ("loaded", lambda old: first(old, np.inf), "out of range"),
}


@pytest.fixture(scope="module")
def whole(saved):
    """The surface that is read of it where nothing is damaged."""
    return Document.open(saved).surface


@pytest.mark.parametrize("name", DAMAGE)
def test_damaged_steps_are_dropped_and_the_painting_is_kept(saved, whole, tmp_path, name):
    where, damage, message = DAMAGE[name]
    session = load_session(saved)
    history = {**session.history, "steps": dict(session.history["steps"])}
    inner = history["steps"] if "." in where else history
    key = where.split(".")[-1]
    inner[key] = damage(inner[key])
    save_session(dataclasses.replace(session, history=history), tmp_path / "a.p3d")
    opened = Document.open(tmp_path / "a.p3d")
    assert re.search(message, opened.refused_history)
    assert "\n" not in opened.refused_history
    same_vertices(opened.surface, whole)
    assert not opened.steps.done
    paint(opened, (-20, 0), (20, 0))
    opened.undo()
    same_paint(opened.surface, whole)


def test_random_damage_never_ends_in_anything_but_a_clear_word(saved, tmp_path):
    """Numbers of the steps are changed here and there, and everything is undone and done again."""
    chance = np.random.default_rng(7)
    for _ in range(examples(12)):
        session = load_session(saved)
        steps = {k: np.array(v) if isinstance(v, np.ndarray) else v
                 for k, v in session.history["steps"].items()}  # fmt: skip
        arrays = [array for array in steps.values() if isinstance(array, np.ndarray) and array.size]
        for array in chance.choice(len(arrays), 2):
            data = arrays[array].reshape(-1).view(np.uint8)
            data[chance.integers(len(data))] ^= 1 << chance.integers(8)
        history = {**session.history, "steps": steps}
        save_session(dataclasses.replace(session, history=history), tmp_path / "a.p3d")
        opened = Document.open(tmp_path / "a.p3d")
        for way in ("undo", "redo"):
            for _ in range(12):
                getattr(opened, way)()
        opened.let_time_pass(0.1)
        assert np.isfinite(opened.surface.amounts).all()


def test_painting_while_looking_at_what_was_before_comes_after_all(tmp_path):
    document = painting_on_layers()
    document.replay_history(1, True)
    with pytest.raises(InputError, match="during a replay"):
        document.remove_layer(0)
    paint(document, (-20, 9), (20, 9))
    assert len(document.strokes) == 4
    document.replay_history(1)
    paint(document, (-20, 9), (20, 9))
    assert len(document.strokes) == 2


def test_strokes_that_were_undone_can_still_be_done_again_after_a_crash(tmp_path):
    document = painting_on_layers()
    document.undo()
    paint_thread = PaintThread(document, recovery=RecoveryFolder(document, tmp_path))
    for command in ("undo", "redo", "redo", "undo", "undo"):
        paint_thread.post(command).result(300)
    paint_thread.stop(keep=True)
    (left,) = recoverable(tmp_path)
    assert len(list(left.folder.glob("base-1.p3d"))) == 1  # no base was needed for that
    recovered = left.recover()
    same(recovered.document, document)
    for _ in range(2):
        for one in (recovered.document, document):
            one.redo()
        same(recovered.document, document)


# -- in the window -----------------------------------------------------------------------------


ROWS = (0.42, 0.47, 0.52, 0.57)


@pytest.fixture(scope="module")
def window(program):
    window = StudioWindow(program)
    window.resize(*SMALL)
    window.show()
    window.workspace.quiet = True
    with blind(window):
        yield window
    close_unasked(window)


@pytest.fixture(scope="module")
def painting(window, tmp_path_factory):
    """A painting of four strokes with a dip, drying and a layer between, saved; and its states."""
    assert window.opening.open_path("plane", 1.5, "xuan", asked=True)
    wait_for(lambda: window.stage.is_lit)
    for k, row in enumerate(ROWS):
        if k == 1:
            choose(window, "swap_inks")
        if k == 2:
            choose(window, "dry")
            choose(window, "add_layer")
        pen_stroke(window.canvas, (0.42, row), (0.55, row), [0.1, *[0.5] * 8, 0.0])
        settled(window)
    states = []
    for upto in range(len(ROWS) + 1):  # undo itself is held to the bit elsewhere
        window.workspace.post("replay_history", upto)
        settled(window)
        states.append(state(window))
    path = tmp_path_factory.mktemp("painting") / "painting.p3d"
    with window.stage.paint_thread.paused() as document:
        document.save(path)
    return path, states


@pytest.fixture
def painted(window, painting, tmp_path):
    """The same in a file of its own."""
    pretend_saved(window.stage.paint_thread)
    return Path(shutil.copy(painting[0], tmp_path)), painting[1]


def choose(window, name) -> None:
    wait_for(window.workspace.actions[name].isEnabled)
    window.workspace.actions[name].trigger()
    settled(window)


def state(window):
    """How many strokes there are, and the colour of every vertex."""
    with window.stage.paint_thread.paused() as document:
        return len(document.strokes), document.surface.srgb.copy()


def looks(window, then) -> None:
    """The painting is as it was then; vertices that came since are left out."""
    n, codes = state(window)
    assert n == then[0]
    np.testing.assert_array_equal(codes[: len(then[1])], then[1])


CTRL, SHIFT = QtCore.Qt.KeyboardModifier.ControlModifier, QtCore.Qt.KeyboardModifier.ShiftModifier
Z = QtCore.Qt.Key.Key_Z


def test_a_painting_that_was_opened_is_undone_and_done_again(window, painted):
    path, states = painted
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    looks(window, states[-1])
    assert window.panels.history.list.count() == len(ROWS)
    wait_for(window.workspace.actions["undo"].isEnabled)
    for _ in range(6):  # four strokes, drying, a layer
        press(window, Z, CTRL)
    looks(window, states[0])
    wait_for(lambda: not window.workspace.actions["undo"].isEnabled())
    assert window.panels.history.list.count() == len(ROWS)  # fainter, and not forgotten
    for _ in range(6):
        press(window, Z, CTRL | SHIFT)
    looks(window, states[-1])


def test_a_click_shows_the_painting_as_it_was_after_a_stroke(window, painted):
    path, states = painted
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    for upto in (3, 1, 4, 1):
        click_row(window, upto - 1)
        looks(window, states[upto])
        assert window.panels.history.list.currentRow() == upto - 1
        assert window.panels.history.slider.value() == upto
    with window.stage.paint_thread.paused() as document:
        document.save()
    assert window.opening.open_path(str(path), asked=True)  # undone when it was saved
    settled(window)
    looks(window, states[1])
    assert window.panels.history.list.count() == len(ROWS)
    click_row(window, 3)
    looks(window, states[4])


@pytest.mark.parametrize("speed", [16.0, None])
def test_replay_plays_all_strokes(window, painted, monkeypatch, speed):
    path, states = painted
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    panel, seen = window.panels.history, []
    show = panel.show_strokes

    def see(strokes, *others) -> None:
        seen.append(len(strokes))
        show(strokes, *others)

    monkeypatch.setattr(panel, "show_strokes", see)
    panel.pace.setCurrentIndex(panel.pace.findData(speed))
    QtTest.QTest.mouseClick(panel.play, QtCore.Qt.MouseButton.LeftButton)
    wait_for(lambda: not panel.is_playing)
    settled(window)  # the last may be asked for and not yet there
    assert [n for n, _ in itertools.groupby(seen)][-5:] == [0, 1, 2, 3, 4]
    looks(window, states[-1])


@pytest.mark.parametrize(
    "samples", [8, pytest.param(80, marks=pytest.mark.long)]
)  # done before the next is shown, or not
def test_painting_while_strokes_are_replayed_loses_none(window, painted, samples):
    path, states = painted
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    panel = window.panels.history
    panel.pace.setCurrentIndex(panel.pace.findData(0.25))
    shown: list[int] = []
    panel.asked.connect(lambda upto, playing: shown.append(upto))
    QtTest.QTest.mouseClick(panel.play, QtCore.Qt.MouseButton.LeftButton)
    wait_for(lambda: shown and shown[-1] >= 1)
    pen_stroke(window.canvas, (0.42, 0.62), (0.55, 0.62), [0.1, *[0.5] * samples, 0.0])
    settled(window)
    assert not panel.is_playing
    assert "replay was stopped" in window.status.message_label.text()
    assert len(window.document.strokes) == 5
    assert len(window.document.strokes[-1].samples) > samples
    press(window, Z, CTRL)
    looks(window, states[-1])


def test_strokes_of_an_older_file_are_painted_again_to_go_back(window, painted):
    path, states = painted
    session = load_session(path)
    save_session(dataclasses.replace(session, undone=(), history=None), path)
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    click_row(window, 0)
    looks(window, states[1])
    assert "repainted" in window.status.message_label.text()
    click_row(window, 3)
    looks(window, states[4])
    assert window.opening.open_path(str(path), asked=True)
    wait_for(window.workspace.actions["undo"].isEnabled)
    press(window, Z, CTRL)
    assert len(window.document.strokes) == 3


def test_damaged_steps_are_dropped_and_it_is_said(window, painted):
    path, states = painted
    session = load_session(path)
    history = {**session.history, "done": ["stroke"]}
    save_session(dataclasses.replace(session, history=history), path)
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    looks(window, states[-1])
    assert "undo steps cannot be used" in window.status.message_label.text()


def test_a_replay_of_nothing_says_so(window):
    pretend_saved(window.stage.paint_thread)
    assert window.opening.open_path("plane", 1.5, "xuan", asked=True)
    settled(window)
    QtTest.QTest.mouseClick(window.panels.history.play, QtCore.Qt.MouseButton.LeftButton)
    assert "no stroke" in window.status.message_label.text()


def test_a_painting_brought_back_after_a_crash_has_its_history(window, painted, tmp_path):
    path, states = painted
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    press(window, Z, CTRL)
    press(window, Z, CTRL)
    sitting = RecoveryFolder(window.document, tmp_path / "left")  # a base, as a crash leaves it
    sitting.note({"do": "redo"})
    sitting.close(keep=True)
    (left,) = recoverable(tmp_path / "left")
    assert window.recovery.recover(left)
    settled(window)
    looks(window, states[3])
    press(window, Z, CTRL | SHIFT)
    looks(window, states[4])
    click_row(window, 0)
    looks(window, states[1])


def test_the_title_marks_only_what_is_otherwise_than_it_was_saved(window, painted):
    """Undo and redo that lead back to it leave nothing to be saved, nor to be asked about."""
    path, _ = painted
    assert window.opening.open_path(str(path), asked=True)
    assert not window.isWindowModified()
    strokes = len(window.document.strokes)
    pen_stroke(window.canvas, (0.42, 0.62), (0.55, 0.62), [0.1, *[0.5] * 8, 0.0])
    settled(window)
    assert window.isWindowModified()
    press(window, Z, CTRL)
    assert len(window.document.strokes) == strokes
    assert not window.isWindowModified()
    press(window, Z, CTRL)
    assert window.isWindowModified()
    pen_stroke(window.canvas, (0.42, 0.62), (0.55, 0.62), [0.1, *[0.5] * 8, 0.0])
    settled(window)
    assert len(window.document.strokes) == strokes
    assert window.isWindowModified()  # as many, and another one
    press(window, Z, CTRL)
    assert window.isWindowModified()


def test_what_was_only_looked_at_in_the_history_is_as_saved(window, painted):
    path, _ = painted
    assert window.opening.open_path(str(path), asked=True)
    for row in (1, 0, len(ROWS) - 1):
        click_row(window, row)
    assert not window.isWindowModified()


def test_a_stroke_that_is_cancelled_leaves_the_painting_as_saved(window, painted):
    path, _ = painted
    assert window.opening.open_path(str(path), asked=True)
    paint_thread = window.stage.paint_thread
    drag(window.canvas, (0.42, 0.62), (0.55, 0.62), release=False)
    wait_for(lambda: window.isWindowModified())
    window.workspace.actions["cancel_stroke"].trigger()
    paint_thread.post(lambda document: None).result(300)
    wait_for(lambda: not window.isWindowModified())
    x, y = 0.55 * window.canvas.width(), 0.62 * window.canvas.height()
    mouse(window.canvas, KIND.MouseButtonRelease, x, y, BUTTON.LeftButton)
    settled(window)
    assert not window.isWindowModified()


def test_what_no_undo_takes_back_stays_unsaved(window, painted):
    path, _ = painted
    assert window.opening.open_path(str(path), asked=True)
    choose(window, "hide_layer")
    choose(window, "undo")
    choose(window, "redo")
    assert window.isWindowModified()
    choose(window, "hide_layer")


def test_older_strokes_painted_again_lead_to_what_was_saved(window, painted):
    """As in `test_strokes_of_an_older_file_are_painted_again_to_go_back`."""
    path, _ = painted
    session = load_session(path)
    save_session(dataclasses.replace(session, history=None), path)
    assert window.opening.open_path(str(path), asked=True)
    n = len(window.document.strokes)
    window.recalling.go_to(0)
    settled(window)
    assert window.isWindowModified()
    window.recalling.go_to(n)
    settled(window)
    assert not window.isWindowModified()
