"""What the window plays is what the command paints; in time, with pauses, at any speed."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PIL import Image
from PySide6 import QtCore, QtTest

from paint3d.app.model.document import Document
from paint3d.app.model.persistence.recovery_folder import recoverable
from paint3d.app.model.score.playing import painted
from paint3d.app.model.stroke_log import weights_of
from paint3d.app.window.playing import pictures
from paint3d.app.window.playing.pictures import FilmDialog, FilmOptions
from paint3d.app.window.wording import say
from paint3d.brush.spec import DipAmount
from paint3d.cli.main import main
from paint3d.device.recorded import Recording as DeviceRecording
from paint3d.errors import Paint3DError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import load_session
from paint3d.recording.recording import Recording, load_recording, save_recording
from paint3d.recording.score import load_score
from tests.support.app.gestures import BUTTON, answer, drag, live, take_file, wait_for
from tests.support.app.hands import pad_stroke, same_vertices
from tests.support.app.windows import opened, settled
from tests.support.cases import long_but
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
    with opened(program, "plane", 1.5, "porcelain", size=None, drawn=False) as window:
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
    assert np.abs(codes).max() <= 2
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
    with opened(program, out, 3.0, "porcelain", drawn=False) as window:
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
    assert "Ready" in window.status.message_label.text()
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
    assert "stopped" in window.status.message_label.text()
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
    assert not window.pictures.growth_to(tmp_path / "a.gif", FilmOptions(60.0, 30.0, (1920, 1080)))
    assert "too many" in told[0]


def grown(window, path: Path) -> bool:
    """Ask for a film; what is said instead is read away."""
    answer(lambda box: box.accept())
    return window.pictures.growth_to(path, FilmOptions(1.0, 5.0, (64, 48)))


# -- painted and played wet --------------------------------------------------------------------


RESOLUTION = 2.5
COMMANDS = ("dip", "tip", "layer", "undo", "dry", "rest", "wet", "brush", "rinse", "hide")
SPEEDS = (None, 16.0)
ALL_ASKED = (73, 120)  # seeds that between them ask for all of these


def asked(window, chance: np.random.Generator) -> None:
    """Something that happens between two strokes."""
    post, actions = window.workspace.post, window.workspace.actions
    what = chance.choice(COMMANDS)
    ink = str(chance.choice(["pine soot", "indigo", "cinnabar"]))
    if what == "dip":
        post("dip", {ink: 0.3, "water": 0.7})
    elif what == "tip":
        post("dip", "water")
        post("dip", ink, 0.4)
    elif what == "layer":
        actions["add_layer"].trigger()
    elif what in ("undo", "dry"):
        actions[what].trigger()
    elif what == "rest":
        live(float(chance.uniform(0.1, 0.5)))
    elif what == "wet":
        actions["wet"].trigger()
    elif what == "brush":
        post("set_brush", str(chance.choice(["slender", "full"])))
    elif what == "rinse":
        post("rinse")
    else:
        post("set_visible", 0, bool(chance.integers(2)))


def paint(window, seed: int) -> None:
    chance = np.random.default_rng(seed)
    if not window.workspace.actions["wet"].isChecked():
        window.workspace.actions["wet"].trigger()
    for _ in range(5):
        ends = chance.uniform(0.35, 0.65, (2, 2))
        drag(window.canvas, tuple(ends[0]), tuple(ends[1]), n=12)
        for _ in range(int(chance.integers(0, 3))):
            asked(window, chance)
    live(0.15)
    if window.workspace.actions["wet"].isChecked():
        window.workspace.actions["wet"].trigger()
    settled(window)


def same_wet_ink(one, other) -> None:
    same_vertices(one, other)
    first, second = one.keep_flow(), other.keep_flow()
    assert (first is None) == (second is None)
    for kept in ("water", "owed", "pace", "soaked", "pigment") if first is not None else ():
        np.testing.assert_array_equal(np.sort(first[kept], axis=0), np.sort(second[kept], axis=0))


@pytest.mark.parametrize(
    ("seed", "speeds"),
    long_but(
        [(ALL_ASKED[1], (SPEEDS[1],))], zip(ALL_ASKED, ((speed,) for speed in SPEEDS), strict=True)
    )
    + [pytest.param(k, SPEEDS, marks=pytest.mark.long) for k in (*ALL_ASKED, *range(1, 16))],
)
def test_what_was_painted_wet_is_painted_again_to_the_bit(
    program, tmp_path, monkeypatch, seed, speeds
) -> None:
    with opened(program, "plane", RESOLUTION, "xuan", drawn=False) as window:
        paint(window, seed)
        file, out = tmp_path / "a.score.jsonl", tmp_path / "a.p3d"
        monkeypatch.setattr(window.targets, "ask", lambda *asked: file)
        window.workspace.actions["save_recording"].trigger()
        before = window.document
        words = ["replay", str(file), "--on", "plane", "--out", str(out), "--quiet"]
        assert main(words) == 0
        same_wet_ink(before.surface, load_session(out).surface)
        for speed in speeds:
            with monkeypatch.context() as own:
                own.setattr(window.recordings, "_may_leave", lambda: True)
                assert window.recordings.replay_file(str(file), speed)
                wait_for(lambda: not window.player.is_playing)
                settled(window)
            assert window.document is not before
            same_wet_ink(window.document.surface, load_session(out).surface)


def with_a_rest(header) -> Recording:
    """A stroke with a rest of half a second in it, twice as long as the hand may be late."""
    held = stroke(header, 0.3)
    times = held.time_ns.copy()
    times[20:] += 500_000_000
    pressure = held.pressure.copy()
    pressure[19:21] = 0.0
    return replace(held, time_ns=times, pressure=pressure)


def pieces_after(document) -> int:
    """Pieces of time that passed when the stroke had ended, until the ink was held."""
    score = document.score
    ends = max(k for k, e in enumerate(score.events) if not isinstance(e, Recording)
               and e["do"] == "end_stroke")  # fmt: skip
    after = [e for e in score.events[ends:] if e["do"] == "follow_time"]
    return sum(event.get("times", 1) for event in after)


def time_goes_on(window) -> bool:
    """Whether time passes for the ink by the wall's clock after what was played."""
    with window.workspace.paint_thread.paused() as document:
        return pieces_after(document) > 0


@pytest.mark.parametrize(
    ("header", "speed", "pause"),
    long_but(
        [(HEADERS[2], None, False)],
        [(HEADERS[0], 0.5, True), (HEADERS[2], None, False), (HEADERS[3], 16.0, False),
         (HEADERS[1], 2.0, True)],
    ),
)  # fmt: skip
def test_a_recording_is_played_wet_as_the_command_does(
    program, tmp_path, header, speed, pause
) -> None:
    file, out = tmp_path / "a.jsonl", tmp_path / "a.p3d"
    save_recording(with_a_rest(header), file)
    with opened(program, "plane", RESOLUTION, "xuan", drawn=False) as window:
        if not window.workspace.actions["wet"].isChecked():
            window.workspace.actions["wet"].trigger()
        settled(window)
        assert window.recordings.replay_file(str(file), speed)
        if pause:
            wait_for(lambda: window.document.surface.painted.any())
            window.player.pause(True)
            live(0.6)
            window.player.pause(False)
        wait_for(lambda: not window.player.is_playing)
        wait_for(lambda: time_goes_on(window))
        window.workspace.actions["wet"].trigger()
        settled(window)
        assert window.document.score is not None
        last_s = 1e-9 * load_recording(file).time_ns[-1]
        rest_s = 0.05 * (int(last_s / 0.05) + pieces_after(window.document) + 0.5) - last_s
        words = ["--on", "plane", "--material", "xuan", "--resolution", str(RESOLUTION)]
        words += ["--spread", f"{max(rest_s, 0.0):.6f}", "--out", str(out), "--quiet"]
        assert main(["replay", str(file), *words]) == 0
        here, there = window.document.surface, load_session(out).surface
        orders = [np.lexsort(s.paint_mesh.vertices.T) for s in (here, there)]
        for get in (lambda s: s.paint_mesh.vertices, lambda s: s.coverage):
            np.testing.assert_array_equal(get(here)[orders[0]], get(there)[orders[1]])
        ours, its = inks_of(here), inks_of(there)
        assert ours.keys() == its.keys() != set()
        for name, amounts in its.items():
            np.testing.assert_array_equal(ours[name], amounts, err_msg=name)


# -- replaying in the window -------------------------------------------------------------------


TIMES = 300  # to and fro
REST_NS = 600_000_000_000
CHUNKS = 3 * 64  # samples that may be painted after a replay was stopped


@pytest.fixture
def studio(program):
    with opened(program, "plane", 2.0, "porcelain", drawn=False) as studio:
        studio.panels.history.pace.setCurrentText("max")
        yield studio


def long_file(studio, folder: Path, rest_ns: int = 0, times: int = TIMES) -> Path:
    """A line that goes to and fro, and rests in the middle of it."""
    drag(studio.canvas, (0.42, 0.5), (0.58, 0.5), n=20)
    settled(studio)
    line = studio.document.strokes[0].samples
    studio.workspace.actions["undo"].trigger()
    settled(studio)
    samples, at_ns = [], 0
    for k in range(times):
        for sample in line if k % 2 == 0 else line[::-1]:
            at_ns += 8_000_000 + (rest_ns if len(samples) == times * len(line) // 2 else 0)
            samples.append(replace(sample, time_ns=at_ns))
    file = folder / "long.jsonl"
    save_recording(joined(samples), file)
    return file


def joined(samples) -> DeviceRecording:
    return DeviceRecording(
        [s.time_ns for s in samples],
        [s.position for s in samples],
        [s.orientation for s in samples],
        [s.pressure for s in samples],
        contact=[s.contact for s in samples],
    )


def replay(studio, file: Path, times: int = TIMES) -> int:
    """By the menu; how many samples there are."""
    answer(take_file(file))
    studio.workspace.actions["replay"].trigger()
    assert studio.player.is_playing
    return times * 20


def by_button(studio) -> None:
    QtTest.QTest.mouseClick(studio.replay_bar.button, BUTTON.LeftButton)


def press(studio, key: QtCore.Qt.Key, *held: QtCore.Qt.KeyboardModifier) -> None:
    studio.activateWindow()  # a dialog had the keys until now
    assert QtTest.QTest.qWaitForWindowActive(studio, 60_000)
    studio.canvas.setFocus()
    QtTest.QTest.keyClick(studio.canvas, key, *held)


def by_key(studio) -> None:
    press(studio, QtCore.Qt.Key.Key_Escape)


def test_it_is_ready_when_all_is_painted_and_a_bar_says_how_far_it_is(studio, tmp_path) -> None:
    file = long_file(studio, tmp_path, times=TIMES // 6)  # all of it is waited for
    shares: list[int] = []
    paint_thread = studio.stage.paint_thread
    for k in range(5):  # what was painted before does not count
        drag(studio.canvas, (0.42, 0.4 + 0.01 * k), (0.58, 0.4 + 0.01 * k), n=40)
    settled(studio)
    before, n = paint_thread.n_painted, replay(studio, file, TIMES // 6)
    with paint_thread.paused():  # wherever it is
        studio.player.tick()
        shares.append(studio.replay_bar.bar.value())
        of_all = 1000 * (paint_thread.n_painted - before) / n
        assert of_all - 20 < shares[0] <= of_all + 1
    while studio.player.is_playing:
        assert studio.replay_bar.bar.value() <= 1000 * (paint_thread.n_painted - before) / n + 1
        assert "Ready" not in studio.status.message_label.text()
        assert studio.replay_bar.isVisible()
        shares.append(studio.replay_bar.bar.value())
        live(0.0)
    assert len(studio.document.strokes) == 6
    assert not studio.document.in_stroke
    assert "Ready" in studio.status.message_label.text()
    assert not studio.replay_bar.isVisible()
    assert shares == sorted(shares)


@pytest.mark.parametrize("stop", [by_button, pytest.param(by_key, marks=pytest.mark.long)])
def test_it_is_stopped_at_once_and_undone_as_a_whole(studio, tmp_path, stop) -> None:
    file = long_file(studio, tmp_path)
    paint_thread = studio.stage.paint_thread
    before, n = paint_thread.n_painted, replay(studio, file)
    wait_for(lambda: paint_thread.n_painted > before + 200)
    stop(studio)
    at = paint_thread.n_painted
    assert not studio.player.is_playing
    assert not studio.replay_bar.isVisible()
    assert "stopped" in studio.status.message_label.text()
    settled(studio)
    assert paint_thread.n_painted <= at + CHUNKS
    (stroke,) = studio.document.strokes
    assert len(stroke.samples) == paint_thread.n_painted - before < n
    assert studio.document.surface.painted.any()
    studio.workspace.actions["undo"].trigger()
    settled(studio)
    assert not studio.document.strokes
    assert not studio.document.surface.painted.any()
    drag(studio.canvas, (0.45, 0.4), (0.55, 0.4), n=6)
    settled(studio)
    assert len(studio.document.strokes) == 1


def test_undo_stops_it_and_takes_all_of_it_back(studio, tmp_path) -> None:
    file = long_file(studio, tmp_path)
    replay(studio, file)
    wait_for(lambda: studio.document.surface.painted.any())
    press(studio, QtCore.Qt.Key.Key_Z, QtCore.Qt.KeyboardModifier.ControlModifier)
    settled(studio)
    assert not studio.player.is_playing
    assert not studio.document.strokes
    assert not studio.document.surface.painted.any()
    assert "undone" in studio.status.message_label.text()


def test_the_rest_of_a_wet_recording_is_not_waited_for(studio, tmp_path) -> None:
    """Ten minutes that pass for the ink are 12,000 pieces of time."""
    file = long_file(studio, tmp_path, REST_NS, times=60)
    studio.workspace.actions["wet"].trigger()
    replay(studio, file, 60)
    paint_thread = studio.stage.paint_thread
    wait_for(lambda: paint_thread.queue_length > 1000)
    by_key(studio)
    assert paint_thread.queue_length < 10
    settled(studio)
    studio.workspace.actions["wet"].trigger()
    studio.workspace.actions["undo"].trigger()
    settled(studio)
    assert not studio.document.strokes


def test_what_was_not_painted_does_not_come_back_after_a_crash(studio, tmp_path) -> None:
    file = long_file(studio, tmp_path)
    replay(studio, file)
    paint_thread = studio.stage.paint_thread
    wait_for(lambda: studio.document.surface.painted.any())
    by_key(studio)
    settled(studio)
    (stroke,) = studio.document.strokes
    paint_thread.stop(keep=True)
    back = recoverable()[0].recover().document
    assert [len(s.samples) for s in back.strokes] == [len(stroke.samples)]
    recoverable()[0].discard()


@pytest.mark.parametrize("beside", [False, True])
def test_a_pads_recording_is_laid_where_the_picture_is_looked_at(
    program, tmp_path, beside: bool
) -> None:
    """It was painted as if it knew where the object is: in the middle of the ball, say."""
    line = np.linspace((100.0, 50.0), (130.0, 50.0), 40)  # anywhere on the pad
    file = tmp_path / "pad.jsonl"
    save_recording(pad_stroke(line, 0.3, np.radians(60.0)), file)
    with opened(program, "sphere", 1.0, "porcelain", drawn=False) as studio:
        studio.workspace.actions["look_left"].trigger()
        for _ in range(20 * beside):
            studio.workspace.actions["pan_left"].trigger()
        assert studio.recordings.replay_file(str(file))
        wait_for(lambda: not studio.player.is_playing)
        (stroke,) = studio.document.strokes
        places = np.array([sample.contact for sample in stroke.samples])
        assert np.linalg.norm(np.diff(places, axis=0), axis=1).sum() == pytest.approx(30.0, rel=0.1)
        points = studio.document.surface.source.vertices
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        side = (places.mean(axis=0) - middle) / np.linalg.norm(places.mean(axis=0) - middle)
        towards = (0.0, -1.0, 0.0) if beside else (-1.0, 0.0, 0.0)  # its front, or what is seen
        assert side @ towards > 0.95
        assert studio.document.surface.painted.any()
        assert "Ready" in studio.status.message_label.text()


def test_a_pads_recording_that_does_not_fit_is_refused_in_words(studio, tmp_path) -> None:
    file = tmp_path / "pad.jsonl"
    save_recording(pad_stroke([(0.0, 0.0), (4000.0, 0.0)], 0.3, 1.0), file)
    assert not studio.recordings.replay_file(str(file))
    assert isinstance(studio.workspace.error, Paint3DError)
    assert not studio.document.strokes


def test_a_stroke_by_hand_that_waits_behind_it_is_kept(studio, tmp_path) -> None:
    """All is handed on and the rest waits: what is stopped is the replay alone."""
    file, paint_thread = (
        long_file(studio, tmp_path, times=100),
        studio.stage.paint_thread,
    )
    with paint_thread.paused() as document:
        assert document is not None
        replay(studio, file)
        waiting = -1
        while paint_thread.queue_length > waiting:  # until no more of it is handed on
            waiting = paint_thread.queue_length
            live(0.1)
        drag(studio.canvas, (0.45, 0.4), (0.55, 0.4), n=6)
        by_button(studio)
    settled(studio)
    (own,) = studio.document.strokes  # nothing of the recording had been painted
    assert 100 * 20 > len(own.samples) >= 6
