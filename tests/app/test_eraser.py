"""Paint that is erased: by the pen's other end, by E, on one layer, undone, saved and replayed."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.input.symmetry import MirrorPlane, Symmetry
from paint3d.app.model.score.playing import painted, score_of_strokes
from paint3d.errors import Paint3DError
from tests.app.test_layers import ACROSS, ALONG, close, paint, shown, small_plane
from tests.support.app.event_player import PENS
from tests.support.app.gestures import BUTTON, HAND, KIND, NO_KEY, drag, live, type_key, wait_for
from tests.support.app.hands import line
from tests.support.app.windows import opened, settled

BESIDE = 8.6  # mm, of the print of an upright brush from its root


def erase(document, start, end, n: int = 12) -> None:
    document.begin_stroke(erase=True)
    document.feed(line(start, end, n=n))
    document.end_stroke()


@pytest.fixture
def document() -> Document:
    document = small_plane()
    document.dip("cinnabar")
    paint(document, *ACROSS)
    document.add_layer()
    document.dip("pine soot")
    paint(document, *ALONG)
    return document


def test_it_takes_off_what_lies_under_it_of_its_own_layer_alone(document) -> None:
    document.set_visible(1, False)
    cinnabar = shown(document)
    document.set_visible(1)
    full, held = shown(document), document.surface.ink.load.sum()
    erase(document, (0.0, -12.0), (0.0, 12.0), n=24)
    after, mesh = shown(document), document.surface.paint_mesh.vertices
    at = np.abs(mesh[: document.surface.n_vertices] - [BESIDE, 0.0, 0.0]) < [0.6, 6.0, 9.0]
    middle = at.all(axis=1)[: len(cinnabar)]
    assert (np.abs(full[: len(cinnabar)][middle].astype(int) - cinnabar[middle]) > 20).any()
    np.testing.assert_allclose(after[: len(cinnabar)][middle], cinnabar[middle], atol=2)
    far = np.abs(mesh[: len(full), 1]) > 19.0
    np.testing.assert_array_equal(after[: len(full)][far], full[far])
    close(document)
    assert document.surface.ink.load.sum() == pytest.approx(held)
    document.undo()
    np.testing.assert_array_equal(shown(document)[: len(full)], full)
    document.redo()
    np.testing.assert_array_equal(shown(document), after)


def test_batches_make_no_difference_and_a_mirror_erases_too() -> None:
    found = []
    for size in (1, 5, 24):
        document = small_plane()
        paint(document, (-25.0, 0.0), (15.0, 0.0))
        document.set_symmetry(Symmetry((MirrorPlane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),)))
        samples = line((0.0, -8.0), (0.0, 8.0), n=24)
        document.begin_stroke(erase=True)
        for k in range(0, len(samples), size):
            document.feed(samples[k : k + size])
        document.end_stroke()
        found.append(shown(document))
        close(document)
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])
    vertices = document.surface.paint_mesh.vertices[: len(found[0])]
    bare = document.surface.share_painted()[: len(vertices)]
    for x in (-BESIDE, BESIDE):
        spot = (np.abs(vertices[:, :2] - [x, 0.0]) < 0.5).all(axis=1)
        assert bare[spot].max() < 0.05
    spot = (np.abs(vertices[:, :2]) < 0.5).all(axis=1)
    assert bare[spot].max() > 0.5


def test_wet_ink_dries_first_and_does_not_come_back() -> None:
    document = small_plane(material="xuan")
    paint(document, (-20.0, 0.0), (15.0, 0.0))
    document.let_time_pass(0.5)
    erase(document, (0.0, -10.0), (0.0, 10.0), n=24)
    document.let_time_pass(5.0)
    vertices = document.surface.paint_mesh.vertices[: document.surface.n_vertices]
    spot = (np.abs(vertices[:, :2] - [BESIDE, 0.0]) < 0.5).all(axis=1)
    assert document.surface.share_painted()[: len(vertices)][spot].max() < 0.05
    close(document)


def test_cancelling_leaves_all_as_it_was(document) -> None:
    full = shown(document)
    document.begin_stroke(erase=True)
    document.feed(line((0.0, -12.0), (0.0, 12.0), n=24))
    document.cancel_stroke()
    np.testing.assert_array_equal(shown(document)[: len(full)], full)
    close(document)


def test_files_and_scores_erase_again(document, tmp_path) -> None:
    erase(document, (0.0, -12.0), (0.0, 12.0), n=24)
    seen = shown(document)
    document.save(tmp_path / "one.p3d")
    opened = Document.open(tmp_path / "one.p3d")
    np.testing.assert_array_equal(shown(opened), seen)
    played = painted(document.score, document.surface.source)
    np.testing.assert_array_equal(shown(played), seen)
    alone = score_of_strokes(document.strokes, document.surface)
    begun = [e for e in alone.events if isinstance(e, dict) and e["do"] == "begin_stroke"]
    assert [e.get("erase", False) for e in begun] == [False, False, True]


KEY = QtCore.Qt.Key


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sheet:120x120", 1.5, "xuan", drawn=False) as window:
        yield window


@pytest.fixture(autouse=True)
def bare(request) -> None:
    if "window" in request.fixturenames:
        window = request.getfixturevalue("window")
        while window.document.can_undo:
            window.stage.paint_thread.post("undo").result(300)
        settled(window)


def ink(window) -> float:
    surface = window.document.surface
    return surface.wet_ink() + surface.dry_ink()


def turned_pen(canvas, kind, x: float, y: float, pressure: float) -> None:
    """One event of the pen's other end."""
    down = BUTTON.NoButton if kind == KIND.TabletRelease else BUTTON.LeftButton
    place = QtCore.QPointF(x, y)
    event = QtGui.QTabletEvent(
        kind, PENS["eraser"], place, canvas.mapToGlobal(place), pressure, 0.0, 0.0, 0.0, 0.0,
        0.0, NO_KEY, BUTTON.LeftButton, down,
    )  # fmt: skip
    event.setTimestamp(HAND.now_ms)
    QtWidgets.QApplication.sendEvent(canvas, event)


def test_the_pens_other_end_erases(window) -> None:
    canvas = window.canvas
    drag(canvas, (0.35, 0.5), (0.65, 0.5))
    settled(window)
    before = ink(window)
    x, y = 0.5 * canvas.width(), 0.5 * canvas.height()
    HAND.begin()
    for k in range(16):
        kind = (KIND.TabletPress, KIND.TabletMove, KIND.TabletRelease)[(k > 0) + (k == 15)]
        turned_pen(canvas, kind, x, y + 8.0 * (k - 8), 0.6)
        live(0.008)
        HAND.pass_by(0.008)
    settled(window)
    assert ink(window) < 0.95 * before
    assert len(window.document.strokes) == 2
    assert "eraser" in window.panels.history.list.item(1).text()


def test_e_turns_the_brush_into_an_eraser_and_back(window) -> None:
    drag(window.canvas, (0.35, 0.5), (0.65, 0.5))
    settled(window)
    before = ink(window)
    type_key(window.canvas, KEY.Key_E)
    wait_for(lambda: window.workspace.actions["erase"].isChecked())
    drag(window.canvas, (0.5, 0.4), (0.5, 0.6))
    settled(window)
    erased = ink(window)
    assert erased < 0.95 * before
    type_key(window.canvas, KEY.Key_E)
    drag(window.canvas, (0.4, 0.3), (0.6, 0.3))
    settled(window)
    assert ink(window) > erased


def test_a_water_brush_leaves_no_colour(window) -> None:
    type_key(window.canvas, KEY.Key_R, QtCore.Qt.KeyboardModifier.ShiftModifier)
    settled(window)
    drag(window.canvas, (0.35, 0.5), (0.65, 0.5))
    settled(window)
    (stroke,) = window.document.strokes
    assert set(stroke.ink) == {"water"}
    codes = window.document.surface.srgb.astype(int)
    assert np.ptp(codes, axis=0).max() <= 3


def test_blotting_paper_lifts_what_is_wet_and_leaves_what_is_dry() -> None:
    document = small_plane(material="xuan")
    document.dip("cinnabar")
    paint(document, (-15.0, -12.0), (15.0, -12.0))
    document.dry()
    document.dip("pine soot")
    paint(document, (-15.0, 8.0), (15.0, 8.0))
    document.let_time_pass(0.3)
    before, surface = shown(document), document.surface
    wet, dry = surface.wet_ink(), surface.dry_ink()
    document.blot()
    assert surface.wet_ink() == 0.0
    assert surface.dry_ink() == pytest.approx(dry + 0.2 * wet, rel=0.02)
    close(document)
    after = shown(document)
    vertices = surface.paint_mesh.vertices[: len(before)]
    low, high = vertices[:, 1] < -2.0, vertices[:, 1] > -2.0
    np.testing.assert_array_equal(after[: len(before)][low], before[low])
    assert after[: len(before)][high].astype(int).sum() > before[high].astype(int).sum()
    document.let_time_pass(5.0)
    np.testing.assert_array_equal(shown(document)[: len(after)], after)  # no water is left
    played = painted(document.score, surface.source)
    np.testing.assert_array_equal(shown(played), shown(document))
    document.undo()
    np.testing.assert_array_equal(shown(document)[: len(before)], before)
    with pytest.raises(Paint3DError):
        document.blot(2.0)


def test_its_key_blots(window) -> None:
    window.stage.paint_thread.post("dip", "pine soot").result(60)
    drag(window.canvas, (0.35, 0.5), (0.65, 0.5))
    settled(window)
    before = ink(window)
    type_key(window.canvas, KEY.Key_E, QtCore.Qt.KeyboardModifier.ShiftModifier)
    wait_for(lambda: ink(window) < 0.4 * before)
