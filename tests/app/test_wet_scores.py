"""Sittings with wet ink in the window, saved as whole paintings: every way to play them paints the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from paint3d.cli.main import main
from paint3d.files.project.session import load_session
from tests.support.app.gestures import drag, live, wait_for
from tests.support.app.hands import same_vertices
from tests.support.app.windows import opened, settled

RESOLUTION = 1.5
COMMANDS = ("dip", "tip", "layer", "undo", "dry", "rest", "wet", "brush", "rinse", "hide")


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", RESOLUTION, "xuan") as window:
        yield window


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
    "seed", [1, 2, 3, *(pytest.param(k, marks=pytest.mark.long) for k in range(4, 16))]
)
def test_what_was_painted_wet_is_painted_again_to_the_bit(
    program, window, tmp_path, monkeypatch, seed
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
        for speed in (None, 16.0):
            with monkeypatch.context() as own:
                own.setattr(window.recordings, "_may_leave", lambda: True)
                assert window.recordings.replay_file(str(file), speed)
                wait_for(lambda: not window.player.is_playing)
                settled(window)
            assert window.document is not before
            same_ink(window.document.surface, load_session(out).surface)
