"""How much the brush holds along a dry recording: the studio paints, keeps and tells the same."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from shapely import LineString

from paint3d.app.model.document import Document
from paint3d.app.model.score.of_strokes import score_of_strokes
from paint3d.app.model.score.playing import painted
from paint3d.app.model.stroke_log import strokes_of
from paint3d.brush.dip_amount import DipAmount
from paint3d.brush.presets import load_brush
from paint3d.calligraphy.flying_white import dried_as
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.page.page import Page, Piece
from paint3d.calligraphy.writing import Pen, write_page
from paint3d.colour.materials import load_material
from paint3d.device.recorded import Recording
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import save_recording
from paint3d.recording.score import load_score, save_score
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.hands import same_vertices

BRUSH, RESOLUTION = "xiaokai", 0.8


@cache
def dry_recording() -> Recording:
    """Two bars, each drier towards its end."""
    strokes = []
    for y in (300.0, 700.0):
        line = np.array([[100.0, y], [900.0, y]])
        outline = np.array(LineString(line).buffer(60.0).exterior.coords)[:-1]
        strokes.append(GlyphStroke(outline, line, (), (0.0, 0.3, 0.6, 0.9)))
    glyph = Glyph("two", tuple(strokes), (0.0, 0.0, 1000.0, 1000.0))
    page = Page((Piece(glyph, (0.0, 0.0)),), "bars", "mine")
    written = write_page(load_mesh("plane"), page, Pen(load_brush(BRUSH), 24.0))
    return dried_as(written.recording, written.dryness, load_material("xuan"))


def bare() -> PaintedSurface:
    return PaintedSurface(load_mesh("plane"), RESOLUTION, load_material("xuan"))


@cache
def wanted() -> PaintedSurface:
    """As `paint3d replay` paints it."""
    recording, surface = dry_recording(), bare()
    Painter(surface, BRUSH, "pine soot", "commanded", amount=amount()).replay(recording)
    return surface


def amount() -> DipAmount:
    return DipAmount.of(dry_recording().header["dip"])


def loads() -> tuple[tuple[int, float], ...]:
    recording = dry_recording()
    times = recording.time_ns.tolist()
    return tuple((times.index(when), share) for when, share in recording.header["loads"])


def by_hand(batch: int) -> Document:
    """As the studio paints it, so many samples at once."""
    surface = bare()
    document = Document(surface, Painter(surface, BRUSH, "pine soot", "commanded", amount=amount()))
    document.begin_stroke(0.0, loads=loads())
    samples = list(dry_recording().samples())
    for at in range(0, len(samples), batch):
        document.feed(samples[at : at + batch])
    document.end_stroke()
    return document


def test_it_has_loads_and_stays_bare() -> None:
    assert len(loads()) > 10
    covered = wanted().coverage
    assert (covered > 0.5).any()
    plain = bare()
    header = {k: v for k, v in dry_recording().header.items() if k != "loads"}
    wet = replace(dry_recording(), header=header)
    Painter(plain, BRUSH, "pine soot", "commanded", amount=amount()).replay(wet)
    assert plain.coverage.sum() > 1.2 * covered.sum()


@pytest.mark.parametrize("batch", [5, 64])
def test_a_live_stroke_holds_what_was_told(batch: int) -> None:
    same_vertices(by_hand(batch).surface, wanted())


def test_the_next_stroke_was_told_nothing() -> None:
    document = by_hand(64)
    document.begin_stroke(0.0)
    assert document.current_stroke is not None
    assert document.current_stroke.loads == ()
    document.dip()
    document.feed(list(dry_recording().samples()))
    document.end_stroke()
    assert document.surface.coverage.sum() > 1.2 * wanted().coverage.sum()


def test_a_whole_painting_knows_the_loads(tmp_path: Path) -> None:
    document = by_hand(64)
    assert document.score is not None
    save_score(document.score, tmp_path / "a.score.jsonl")
    again = painted(load_score(tmp_path / "a.score.jsonl"), load_mesh("plane"))
    same_vertices(again.surface, wanted())
    told = score_of_strokes(document.strokes, document.surface)
    assert told is not None
    same_vertices(painted(told, load_mesh("plane")).surface, wanted())


def test_a_stroke_keeps_its_loads_with_a_session_and_as_a_recording() -> None:
    document = by_hand(64)
    stroke = document.strokes[0]
    assert stroke.loads == loads()
    assert strokes_of([stroke.recording()])[0].loads == loads()
    recording = document.recording()
    assert recording is not None
    assert recording.header["loads"] == dry_recording().header["loads"]


@pytest.mark.parametrize(
    "told", [((0, 1.5),), ((2, 0.5), (1, 0.5)), ((-1, 0.5),), ((0.5, 0.5),), (3,), "no"]
)
def test_loads_that_are_none_are_refused(told) -> None:
    surface = bare()
    document = Document(surface, Painter(surface, BRUSH))
    with pytest.raises(InputError, match="pairs of a sample"):
        document.begin_stroke(0.0, loads=told)
    document.end_stroke()
    document.begin_stroke(0.0)
    assert document.in_stroke


def test_the_window_replays_it_as_the_command_does(program, tmp_path: Path) -> None:
    pytest.importorskip("PySide6", reason="PySide6 is not installed")
    from tests.support.app.gestures import wait_for
    from tests.support.app.windows import opened, settled

    file = tmp_path / "dry.jsonl"
    save_recording(dry_recording(), file)
    with opened(program, "plane", RESOLUTION, "xuan") as window:
        assert window.recordings.replay_file(str(file))
        wait_for(lambda: not window.player.is_playing)
        settled(window)
        same_vertices(window.document.surface, wanted())
        assert len(window.document.strokes[0].loads) == len(loads())
