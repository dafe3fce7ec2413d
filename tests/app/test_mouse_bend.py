"""With a mouse the tuft's bend is told by Shift and the mouse's motion (Guo 2015, Table 2: I)."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore

from paint3d.app.model.document import Document
from paint3d.cli.main import main
from paint3d.core.quaternion import rotate
from paint3d.view.camera import picture_axes
from tests.support.app.gestures import BUTTON, KIND, live, mouse
from tests.support.app.hands import same_vertices
from tests.support.app.windows import opened, settled

SHIFT = QtCore.Qt.KeyboardModifier.ShiftModifier
LEFT = BUTTON.LeftButton


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 1.5, "porcelain") as window:
        yield window


def turn_in_place(window, way, keys, goes_on=False):
    """Press in the middle, go a way of (x, y) pixels with these keys held; the samples."""
    canvas = window.canvas
    x, y = 0.5 * canvas.width(), 0.55 * canvas.height()
    mouse(canvas, KIND.MouseMove, x, y)
    mouse(canvas, KIND.MouseButtonPress, x, y, LEFT, LEFT)
    live(0.03)
    for k in range(1, 13):
        place = x + way[0] * k / 12, y + way[1] * k / 12
        mouse(canvas, KIND.MouseMove, *place, BUTTON.NoButton, LEFT, keys)
        live(0.01)
    end = x + way[0], y + way[1]
    if goes_on:
        for _ in range(10):
            end = end[0] + 6.0, end[1]
            mouse(canvas, KIND.MouseMove, *end, BUTTON.NoButton, LEFT)
            live(0.01)
    mouse(canvas, KIND.MouseButtonRelease, *end, LEFT, BUTTON.NoButton)
    settled(window)
    return window.document.strokes[-1].samples


@pytest.mark.parametrize("way", [(60, 0), (-60, 0), (0, 60), (0, -60)])
def test_with_shift_the_mouse_turns_the_bend_and_the_brush_stays(window, way) -> None:
    samples = turn_in_place(window, way, SHIFT)
    places = np.array([sample.contact for sample in samples])
    assert np.ptp(places, axis=0).max() < 1e-6
    right, up, _ = picture_axes(window.hand.camera)
    wanted = way[0] * right - way[1] * up
    bend = rotate(samples[-1].orientation, np.array([1.0, 0.0, 0.0]))
    wanted[2] = bend[2] = 0.0
    assert bend @ wanted > 0.99 * np.linalg.norm(bend) * np.linalg.norm(wanted)


def test_without_shift_the_brush_goes_along(window) -> None:
    samples = turn_in_place(window, (60, 0), QtCore.Qt.KeyboardModifier.NoModifier)
    assert np.ptp([sample.contact[0] for sample in samples]) > 5.0


def test_after_shift_the_brush_goes_on_from_where_it_stood(window) -> None:
    samples = turn_in_place(window, (0, 60), SHIFT, goes_on=True)
    places = np.array([sample.contact for sample in samples])
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert np.ptp(places[:, 0]) > 5.0
    assert np.ptp(places[:, 1]) < 1e-3  # the way that turned the bend moved nothing
    assert steps.max() < 3.0  # no leap to where the pointer is
    bend = rotate(samples[-1].orientation, np.array([1.0, 0.0, 0.0]))
    assert bend[0] < -0.9 * np.linalg.norm(bend[:2])  # and the tuft trails again, as it went


def test_the_mark_is_another_one_and_is_replayed_to_the_bit(window, tmp_path, monkeypatch) -> None:
    marks = []
    for way in ((60, 0), (0, -60)):
        turn_in_place(window, way, SHIFT)
        stroke, other = window.document.strokes[-1], Document.new("plane", 1.5)
        other.begin_stroke()
        other.feed(list(stroke.samples))
        other.end_stroke()
        marks.append(other.surface.coverage)
    assert marks[0].shape != marks[1].shape or not np.array_equal(*marks)
    file, out = tmp_path / "bends.score.jsonl", tmp_path / "bends.p3d"
    monkeypatch.setattr(window.targets, "ask", lambda *asked: file)
    window.workspace.actions["save_recording"].trigger()
    assert main(["replay", str(file), "--on", "plane", "--out", str(out), "--quiet"]) == 0
    again = Document.open(out)
    same_vertices(again.surface, window.document.surface)
    assert len(again.strokes) == len(window.document.strokes) >= 2
