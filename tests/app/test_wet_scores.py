"""What is painted and played wet in the window is what the command paints, by the real clock."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from paint3d.cli.main import main
from paint3d.files.project.session import load_session
from paint3d.recording.recording import Recording, load_recording, save_recording
from tests.app.test_playback import HEADERS, inks_of, stroke
from tests.support.app.gestures import drag, live, wait_for
from tests.support.app.hands import same_vertices
from tests.support.app.windows import opened, settled
from tests.support.cases import long_but

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


def same_ink(one, other) -> None:
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
    with opened(program, "plane", RESOLUTION, "xuan") as window:
        paint(window, seed)
        file, out = tmp_path / "a.score.jsonl", tmp_path / "a.p3d"
        monkeypatch.setattr(window.targets, "ask", lambda *asked: file)
        window.workspace.actions["save_recording"].trigger()
        before = window.document
        words = ["replay", str(file), "--on", "plane", "--out", str(out), "--quiet"]
        assert main(words) == 0
        same_ink(before.surface, load_session(out).surface)
        for speed in speeds:
            with monkeypatch.context() as own:
                own.setattr(window.recordings, "_may_leave", lambda: True)
                assert window.recordings.replay_file(str(file), speed)
                wait_for(lambda: not window.player.is_playing)
                settled(window)
            assert window.document is not before
            same_ink(window.document.surface, load_session(out).surface)


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
    with opened(program, "plane", RESOLUTION, "xuan") as window:
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
        wait_for(lambda: time_goes_on(window), 30.0)
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
