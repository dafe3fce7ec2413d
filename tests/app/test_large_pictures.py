"""Large pictures of what is seen: drawn part by part under a bar, and stopped between parts."""

from __future__ import annotations

import time
from concurrent.futures import CancelledError

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PIL import Image
from PySide6 import QtWidgets

from paint3d.app.window.playing.pictures import FilmOptions
from tests.support.app.gestures import drag, wait_for
from tests.support.app.windows import opened, settled

SIZE = 1400, 1000


@pytest.fixture(autouse=True, scope="module")
def plain_edges() -> None:
    """Edges are smoothed here as users see them."""


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sphere", 4.0, "porcelain") as window:
        drag(window.canvas, (0.4, 0.5), (0.6, 0.5))
        settled(window)
        yield window


def test_a_picture_drawn_by_parts_is_that_drawn_at_once(window, tmp_path) -> None:
    window.stage.set_size(SIZE)
    whole = np.array(window.stage.picture(fine=True)[::-1, :, :3])
    window.stage.set_size(window.canvas.pixel_size)
    assert window.pictures.picture_to(tmp_path / "a.png", SIZE)
    seen = np.array(Image.open(tmp_path / "a.png"))
    assert seen.shape == (SIZE[1], SIZE[0], 3)
    np.testing.assert_array_equal(seen, whole)
    assert window.stage.scene.size == window.canvas.pixel_size


@pytest.mark.parametrize("what", ["picture", "film"])
def test_the_bar_moves_between_parts_and_cancel_stops_before_the_next(
    window, tmp_path, monkeypatch, what
) -> None:
    drawn, draw = [], window.stage.scene.draw_object

    def slow(box=None, **how) -> None:
        bar = QtWidgets.QApplication.activeModalWidget()
        drawn.append(bar.value())
        time.sleep(0.1)
        draw(box, **how)
        if len(drawn) == 3:
            bar.findChild(QtWidgets.QPushButton).click()

    monkeypatch.setattr(window.stage.scene, "draw_object", slow)
    if what == "picture":
        assert not window.pictures.picture_to(tmp_path / "b.png", SIZE)
    else:
        assert not window.pictures.turntable_to(tmp_path / "b.gif", FilmOptions(0.5, 4.0, SIZE))
    monkeypatch.undo()
    assert isinstance(window.workspace.error, CancelledError)
    assert len(drawn) == 3  # of nine for each picture
    assert drawn[2] > drawn[0]
    wait_for(lambda: list(tmp_path.iterdir()) == [])
    assert window.stage.scene.size == window.canvas.pixel_size
    before = len(window.document.strokes)
    drag(window.canvas, (0.4, 0.6), (0.6, 0.6))
    settled(window)
    assert len(window.document.strokes) == before + 1
