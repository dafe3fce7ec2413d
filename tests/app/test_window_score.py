"""A whole painting as a recording, in the window: saved by the menu, and painted again by it."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from paint3d.app.model.document import Document
from paint3d.cli.main import main
from tests.support.app.gestures import drag
from tests.support.app.hands import same_vertices
from tests.support.app.windows import opened, settled


@pytest.fixture
def window(program):
    with opened(program, "plane", 2.0, "porcelain") as window:
        yield window


def test_what_is_saved_is_painted_to_the_bit_by_the_command_and_in_the_window(
    window, tmp_path, monkeypatch
) -> None:
    for k, ink in enumerate(("cinnabar", {"indigo": 0.3, "water": 0.7}, "pine soot")):
        window.workspace.post("dip", ink)
        drag(window.canvas, (0.42, 0.4 + 0.05 * k), (0.58, 0.45 + 0.05 * k), n=20)
        settled(window)
        window.workspace.actions[("add_layer", "undo", "dry")[k]].trigger()
    settled(window)
    file, out = tmp_path / "a.score.jsonl", tmp_path / "a.p3d"
    monkeypatch.setattr(window.targets, "ask", lambda *asked: file)
    window.workspace.actions["save_recording"].trigger()
    before = window.document
    assert main(["replay", str(file), "--on", "plane", "--out", str(out), "--quiet"]) == 0
    monkeypatch.setattr(window.recordings, "_may_leave", lambda: True)
    assert window.recordings.replay_file(str(file))
    settled(window)
    assert window.document is not before
    for again in (window.document, Document.open(out)):
        same_vertices(again.surface, before.surface)
        np.testing.assert_array_equal(again.surface.srgb, before.surface.srgb)
        assert again.layers == before.layers
        assert len(again.strokes) == len(before.strokes) == 2
