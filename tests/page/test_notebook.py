"""A painting in a notebook's cell: what the page tells comes back to Python."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import paint3d
from paint3d.app.model.score.playing import painted
from paint3d.errors import ExportError, InputError
from paint3d.page.single_file import bare_score, page_score
from paint3d.recording.score import Score, write_score
from tests.support.web_page import hashes_of


def test_without_anywidget_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "anywidget", None)
    monkeypatch.delitem(sys.modules, "paint3d.page.editor", raising=False)
    with pytest.raises(ExportError, match="anywidget could not be loaded") as refusal:
        paint3d.PaintedSurface(paint3d.load_mesh("square"), 4.0).edit()
    assert refusal.value.hint == "pip install 'paint3d[notebook]'"


@pytest.fixture
def surface() -> paint3d.PaintedSurface:
    return paint3d.PaintedSurface(paint3d.load_mesh("square"), 4.0)


def test_a_surface_is_edited_bare_or_as_a_session_of_its_strokes(
    surface: paint3d.PaintedSurface,
) -> None:
    assert not bare_score(surface, "zhongkai", "pine soot").events
    painter = paint3d.Painter(surface, brush="zhongkai", ink="pine soot")
    stroke = painter.stroke([(-40, 0, 0), (40, 0, 0)], pressure=0.4)
    with pytest.raises(InputError, match="expected a bare one, or a session"):
        bare_score(surface, "zhongkai", "pine soot")
    words = {"brush": "zhongkai", "ink": "pine soot"}
    score = page_score(paint3d.Session(surface, [stroke], words))
    assert hashes_of(painted(score, surface.source).surface) == hashes_of(surface)


class FakeComm:
    """A line to a notebook that nobody looks at."""

    comm_id = "1"

    def __init__(self, **_: Any) -> None:
        self.told: list[dict[str, Any]] = []

    def open(self, *_: Any, **__: Any) -> None:
        pass

    def on_msg(self, hear: Any) -> None:
        self.hear = hear

    def send(self, data: dict[str, Any], *_: Any, **__: Any) -> None:
        if data["method"] == "custom":
            self.told.append(data["content"])

    def say(self, view: str, what: str, text: str = "") -> None:
        content = {"paint3d": what, "text": text, "view": view}
        self.hear({"content": {"data": {"method": "custom", "content": content}}, "buffers": []})


def test_what_is_painted_in_a_cell_comes_back(surface: paint3d.PaintedSurface) -> None:
    pytest.importorskip("anywidget")
    from paint3d.page.editor import Editor

    bare = bare_score(surface, "zhongkai", "pine soot")
    by_hand = paint3d.Painter(paint3d.PaintedSurface(surface.source, 4.0), "zhongkai", "pine soot")
    ways = [[(-40.0, y, 0.0), (40.0, y, 0.0)] for y in (0.0, 30.0)]
    one, two = (by_hand.stroke(way, pressure=0.4) for way in ways)
    events = [({"do": "begin_stroke"}, stroke, {"do": "end_stroke"}) for stroke in (one, two)]
    whole = Score(bare.header, (*events[0], *events[1], {"do": "undo"}))
    lines = list(write_score(whole))
    editor = Editor(surface, bare, "<p>", 300)
    comm = FakeComm()
    editor.comm = comm
    comm.hear = editor._handle_msg
    with pytest.raises(InputError, match="nothing is painted yet"):
        _ = editor.recording
    assert not editor.surface.painted.any()
    comm.say("a", "read")
    assert comm.told[-1] == {"paint3d": "kept", "text": "".join(write_score(bare)), "view": "a"}
    comm.say("a", "begin", lines[0])
    comm.say("a", "append", "".join(lines[1:9]))  # within its first stroke
    assert editor.strokes == 0  # which the page sets, when it has heard
    assert comm.told[-1] == {"paint3d": "heard", "strokes": 1}
    assert 0 < len(editor.recording) < len(one)
    comm.say("a", "append", "".join(lines[9:]))
    assert np.array_equal(editor.recording.position, one.position)  # the other was undone
    assert hashes_of(editor.surface) == hashes_of(painted(whole, surface.source).surface)
    assert editor.surface is editor.surface
    assert not surface.painted.any()
    comm.say("b", "read")  # it is shown once more
    assert comm.told[-1] == {"paint3d": "kept", "text": "".join(lines), "view": "b"}
    n = len(comm.told)
    comm.say("a", "append", '{"do": "undo"}\n')  # by the view that it has left
    assert len(comm.told) == n
    assert len(editor.recording) == len(one)
