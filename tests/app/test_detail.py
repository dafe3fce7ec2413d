"""A surface too coarse for what is to be written: said before, and painted anew more finely."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtWidgets

from paint3d.app.model.document import Document
from tests.support.app.gestures import answer, drag, wait_for
from tests.support.app.windows import opened, settled


@pytest.fixture
def window(program):
    """A window with a small sheet in it, whose vertices lie far apart."""
    with opened(program, "sheet:100x100", 1.2, "xuan", drawn=False) as window:
        yield window


def lay_small(window) -> None:
    assert window.copying.layout_text("永", 10.0, True)
    wait_for(lambda: window.document.texts)
    settled(window)


def press(text: str):
    """Make a `press` for the button that says this, of a box that says what breaks up."""

    def act(box: QtWidgets.QMessageBox) -> None:
        assert box.text() == (
            "Characters of 10 mm break up on this surface: they need a detail of 0.25 mm, or to be "
            "22 mm large"
        )
        next(button for button in box.buttons() if button.text() == text).click()

    return act


def written(window) -> None:
    wait_for(lambda: window.document.strokes and not window.player.is_playing)
    settled(window)


def test_small_characters_on_a_coarse_surface_are_said_when_they_are_laid(window) -> None:
    lay_small(window)
    assert "break up" in window.status.message_label.text()
    window.copying.change({"em_mm": 40.0})
    settled(window)
    assert window.copying.layout_text("永", 40.0, True)
    assert "break up" not in window.status.message_label.text()


def test_all_is_painted_anew_more_finely_before_they_are_written(window, tmp_path) -> None:
    window.document.save(tmp_path / "a.p3d")
    drag(window.canvas, (0.4, 0.3), (0.6, 0.3))
    settled(window)
    window.workspace.post("add_layer", "signed")
    lay_small(window)
    before, stroke, coarse = window.document, window.document.strokes[0], ink_on(window.document)
    camera = window.hand.open_camera
    answer(press("Paint anew at 0.25 mm"))
    window.writing.do_write_text()
    written(window)
    now = window.document
    assert now is not before
    assert now.surface.resolution == 0.25
    assert now.path == tmp_path / "a.p3d"
    assert now.modified
    assert [layer.name for layer in now.layers] == ["1", "signed"]
    assert [laid.text for laid in now.texts] == ["永"]
    times = [[sample.time_ns for sample in one.samples] for one in (now.strokes[0], stroke)]
    assert times[0] == times[1]
    assert len(now.strokes) == 2
    np.testing.assert_allclose(window.hand.open_camera.position, camera.position)
    window.workspace.post("undo")
    settled(window)
    assert ink_on(window.document) == pytest.approx(coarse, rel=0.1)
    for _ in range(3):
        window.workspace.post("undo")
    settled(window)
    assert not window.document.surface.painted.any()


def ink_on(document: Document) -> float:
    """Ink on the surface, of all that was loaded."""
    accounts = document.painter.ledger()
    return accounts["wet"] + accounts["dry"]


def test_it_is_written_so_or_not_at_all(window) -> None:
    lay_small(window)
    answer(press("Cancel"))
    window.writing.do_write_text()
    settled(window)
    assert not window.player.is_playing
    assert not window.document.strokes
    answer(press("Write it so"))
    window.writing.do_write_text()
    written(window)
    assert window.document.surface.resolution == 1.2


def test_nothing_is_offered_where_it_is_not_known_how_it_was_painted(window) -> None:
    lay_small(window)
    window.document.recorder = None
    offered = []
    answer(lambda box: (offered.extend(one.text() for one in box.buttons()), box.reject()))
    window.writing.do_write_text()
    settled(window)
    assert sorted(offered) == ["Cancel", "Write it so"]
    assert not window.document.strokes


def test_the_detail_is_asked_for_by_the_menu(window) -> None:
    drag(window.canvas, (0.4, 0.3), (0.6, 0.3))
    settled(window)

    def finer(dialog: QtWidgets.QDialog) -> None:
        dialog.findChild(QtWidgets.QDoubleSpinBox).setValue(0.5)
        dialog.accept()

    answer(finer)
    window.workspace.actions["set_detail"].trigger()
    settled(window)
    assert window.document.surface.resolution == 0.5
    assert len(window.document.strokes) == 1
