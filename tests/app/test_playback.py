"""What the window plays is what the command paints; in time, with pauses, at any speed."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PIL import Image
from PySide6 import QtTest

from paint3d.app.model.document import Document
from paint3d.app.model.score.playing import painted
from paint3d.app.model.stroke_log import weights_of
from paint3d.app.window.playing import pictures
from paint3d.app.window.playing.pictures import Film, FilmDialog
from paint3d.app.window.wording import say
from paint3d.brush.spec import DipAmount
from paint3d.cli.main import main
from paint3d.files.load import load_mesh
from paint3d.files.project.session import load_session
from paint3d.recording.recording import Recording, save_recording
from paint3d.recording.score import load_score
from tests.support.app.gestures import BUTTON, answer, drag, live, take_file, wait_for
from tests.support.app.hands import same_vertices
from tests.support.app.windows import opened, settled
from tests.support.surface_cases import poses

SCORE = Path(__file__).parents[2] / "examples" / "bamboo.score.jsonl"
HEADERS = (
    {"brush": "slender", "ink": "cinnabar", "azimuth": "dragged"},
    {"brush": "feibai", "ink": "pine soot", "parts": {"pine soot": 0.3, "water": 0.7}},
    {"brush": "full", "ink": "water", "tip": "indigo", "reach": 0.4},
    {"brush": "zhongkai", "ink": "indigo", "dip": {"wetted": 0.02, "fullness": 1.5}},
)


def stroke(header: dict[str, object], seconds: float = 0.6) -> Recording:
    x = np.linspace(-12.0, 12.0, 40)
    points = np.stack([x, 3.0 * np.sin(0.3 * x), np.zeros(40)], axis=1)
    pressure = np.full(40, 0.4)
    pressure[[0, -1]] = 0.0
    held = poses(points, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), pressure, str(header["brush"]))
    times = (np.arange(40) * seconds * 1e9 / 39).astype(np.int64)
    return replace(held, time_ns=times, header=header)


@pytest.fixture
def window(program):
    with opened(program, "plane", 1.5, "porcelain", size=None) as window:
        window.panels.history.pace.setCurrentText("max")
        yield window


def by_menu(window, file: Path) -> None:
    answer(take_file(file))
    window.workspace.actions["replay"].trigger()


def inks_of(surface) -> dict[str, np.ndarray]:
    """Amounts of each ink there is, by name, of vertices in an order of their own."""
    order = np.lexsort(surface.paint_mesh.vertices.T)
    columns = enumerate(pigment.name for pigment in surface.pigments)
    found = {name: surface.amounts[order][:, k] for k, name in columns}
    return {name: amounts for name, amounts in found.items() if amounts.any()}


@pytest.mark.parametrize(
    "header",
    [pytest.param(h, id=h["brush"], marks=pytest.mark.long if k >= 2 else ())
     for k, h in enumerate(HEADERS)],
)  # fmt: skip
def test_a_recording_is_played_with_its_own_tools_as_the_command_does(
    window, tmp_path, header
) -> None:
    file, out = tmp_path / "a.jsonl", tmp_path / "a.p3d"
    save_recording(stroke(header), file)
    window.workspace.post("set_brush", "baiyun" if header["brush"] == "full" else "full")
    window.workspace.post("dip", "oil soot", None, {"wetted": 0.5})
    settled(window)
    in_hand = window.document.painter.brush
    by_menu(window, file)
    wait_for(lambda: not window.player.is_playing)
    settled(window)
    words = ["--on", "plane", "--resolution", "1.5", "--out", str(out), "--quiet"]
    assert main(["replay", str(file), *words]) == 0
    there, here = load_session(out).surface, window.document.surface
    ours, its = inks_of(here), inks_of(there)
    assert ours.keys() == its.keys() != set()
    for name, amounts in its.items():
        np.testing.assert_array_equal(ours[name], amounts, err_msg=name)
    orders = [np.lexsort(s.paint_mesh.vertices.T) for s in (here, there)]
    for get in (lambda s: s.paint_mesh.vertices, lambda s: s.coverage):
        np.testing.assert_array_equal(get(here)[orders[0]], get(there)[orders[1]])
    # the window's knows other inks, too, and so mixes by another table
    codes = here.srgb[orders[0]].astype(int) - there.srgb[orders[1]]
    assert np.abs(codes).max() <= 1
    (log,) = window.document.strokes
    assert log.brush.name == header["brush"]
    painter = window.document.painter  # the hand has its own again
    assert painter.brush == in_hand
    assert painter.azimuth == "commanded"
    assert painter.dipped == "oil soot"
    assert painter.amount == DipAmount(0.5)


def test_the_hand_of_a_painting_by_command_has_its_ink_again_after_a_replay(
    program, tmp_path
) -> None:
    """Such a session does not say in which dips the brush came to it."""
    files, out = [tmp_path / "a.jsonl", tmp_path / "b.jsonl"], tmp_path / "a.p3d"
    for file, header in zip(files, (HEADERS[1], HEADERS[3]), strict=True):
        save_recording(stroke(header), file)
    on = ["--on", "plane", "--resolution", "3", "--quiet"]
    assert main(["replay", str(files[0]), *on, "--out", str(out)]) == 0
    with opened(program, out, 3.0, "porcelain") as window:
        window.panels.history.pace.setCurrentText("max")
        by_menu(window, files[1])
        wait_for(lambda: not window.player.is_playing)
        settled(window)
        painter = window.document.painter
        assert weights_of(painter.dipped) == pytest.approx({"pine soot": 0.3, "water": 0.7})
        assert painter.amount == DipAmount()


@pytest.mark.long
def test_a_whole_painting_is_played_in_time_pauses_and_changes_its_speed(window, tmp_path) -> None:
    window.panels.history.pace.setCurrentText("16 x")
    by_menu(window, SCORE)
    assert window.player.is_playing
    assert window.replay_bar.isVisible()
    assert window.replay_bar.speed.currentText() == "16 x"
    window.replay_bar.speed.setCurrentText("½ x")
    window.replay_bar.speed.activated.emit(window.replay_bar.speed.currentIndex())
    wait_for(lambda: window.document.surface.painted.any())
    assert len(window.document.strokes) < 8
    QtTest.QTest.mouseClick(window.replay_bar.hold, BUTTON.LeftButton)
    settled(window)
    share, n = window.replay_bar.bar.value(), window.document.surface.n_vertices
    live(0.4)
    assert (window.replay_bar.bar.value(), window.document.surface.n_vertices) == (share, n)
    assert window.player.is_paused
    QtTest.QTest.mouseClick(window.replay_bar.hold, BUTTON.LeftButton)
    window.player.set_speed(None)
    wait_for(lambda: not window.player.is_playing)
    settled(window)
    assert not window.replay_bar.isVisible()
    assert "Ready" in window.status.told.text()
    again = painted(load_score(SCORE), load_mesh("plane"))
    same_vertices(window.document.surface, again.surface)
    assert window.document.layers == again.layers
    assert len(window.document.strokes) == len(again.strokes)


def test_a_played_score_is_a_score_again_and_stops_where_it_is(window, tmp_path) -> None:
    window.panels.history.pace.setCurrentText("1 x")
    if not window.workspace.actions["wet"].isChecked():
        window.workspace.actions["wet"].trigger()
    began = time.perf_counter()
    by_menu(window, SCORE)
    wait_for(lambda: len(window.document.strokes) >= 1)
    assert time.perf_counter() - began > 0.15  # as long as the hand took for the stroke
    assert not window.stage.paint_thread.wet  # the score says when ink spreads
    QtTest.QTest.mouseClick(window.replay_bar.button, BUTTON.LeftButton)
    assert not window.player.is_playing
    assert "stopped" in window.status.told.text()
    assert window.stage.paint_thread.wet
    window.workspace.actions["wet"].trigger()
    settled(window)
    document = window.document
    assert not document.in_stroke
    assert 1 <= len(document.strokes) < 8
    again = painted(document.score, load_mesh("plane"))
    same_vertices(document.surface, again.surface)
    assert isinstance(document, Document)


def test_rests_of_a_recording_are_played_as_a_second(window, tmp_path) -> None:
    held = stroke({"brush": "full", "ink": "pine soot"}, 0.2)
    times = held.time_ns.copy()
    times[20:] += 3_600_000_000_000
    file = tmp_path / "a.jsonl"
    save_recording(replace(held, time_ns=times), file)
    window.panels.history.pace.setCurrentText("16 x")
    by_menu(window, file)
    wait_for(lambda: not window.player.is_playing)
    assert len(window.document.strokes) == 1
    assert len(window.document.strokes[0].samples) == 40


@pytest.mark.long
def test_a_film_of_the_painting_that_grew_is_written_by_the_menu(window, tmp_path) -> None:
    assert not grown(window, tmp_path / "no.gif")
    drag(window.canvas, (0.35, 0.5), (0.65, 0.5), n=20)
    settled(window)
    window.targets.folder = tmp_path

    titles: list[str] = []

    def short(dialog: FilmDialog) -> None:
        dialog.seconds.setValue(1.0)
        dialog.rate.setValue(5)
        dialog.size_boxes.width_box.setValue(64)
        titles.append(dialog.windowTitle())
        dialog.accept()

    answer(lambda asked: (take_file(tmp_path / "a.gif")(asked), answer(short)))
    window.workspace.actions["growth"].trigger()
    with Image.open(tmp_path / "a.gif") as film:
        assert film.size[0] == 64
        film.seek(film.n_frames - 1)
        last = np.array(film.convert("L")).astype(int)
        film.seek(0)
        first = np.array(film.convert("L")).astype(int)
    assert titles == [say("Film of the painting growing…").rstrip("…")]
    assert (first - last > 60).sum() > 10
    assert (last - first > 20).sum() < 10
    assert len(window.document.strokes) == 1


def test_a_film_that_grows_too_large_is_refused_before_anything_is_painted(
    window, tmp_path, monkeypatch
) -> None:
    drag(window.canvas, (0.35, 0.5), (0.65, 0.5), n=20)
    settled(window)
    monkeypatch.setattr(pictures, "begun", None)
    told: list[str] = []
    answer(lambda box: (told.append(box.text()), box.accept()))
    assert not window.pictures.growth_to(tmp_path / "a.gif", Film(60.0, 30.0, (1920, 1080)))
    assert "too many" in told[0]


def grown(window, path: Path) -> bool:
    """Ask for a film; what is said instead is read away."""
    answer(lambda box: box.accept())
    return window.pictures.growth_to(path, Film(1.0, 5.0, (64, 48)))
