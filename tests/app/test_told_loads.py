"""What the brush holds along a dry and pale recording: the studio paints, keeps, tells the same."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from shapely import LineString

from paint3d.app.model.document import Document
from paint3d.app.model.input.symmetry import MirrorPlane, Symmetry
from paint3d.app.model.score.playing import painted, score_of_strokes
from paint3d.app.model.stroke_log import strokes_of
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import DipAmount
from paint3d.calligraphy.flying_white import inked_as
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
    """Two bars, each drier towards its end, the second one pale."""
    strokes = []
    for y, strength in ((300.0, 1.0), (700.0, 0.4)):
        line = np.array([[100.0, y], [900.0, y]])
        outline = np.array(LineString(line).buffer(60.0).exterior.coords)[:-1]
        strokes.append(GlyphStroke(outline, line, (), (0.0, 0.3, 0.6, 0.9), strength))
    glyph = Glyph("two", tuple(strokes), (0.0, 0.0, 1000.0, 1000.0))
    page = Page((Piece(glyph, (0.0, 0.0)),), "bars", "mine")
    written = write_page(load_mesh("plane"), page, Pen(load_brush(BRUSH), 24.0))
    return inked_as(written.recording, written.dryness, written.strength, load_material("xuan"))


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


def told(name: str) -> tuple[tuple[int, float], ...]:
    recording = dry_recording()
    times = recording.time_ns.tolist()
    return tuple((times.index(when), share) for when, share in recording.header[name])


def loads() -> tuple[tuple[int, float], ...]:
    return told("loads")


def strengths() -> tuple[tuple[int, float], ...]:
    return told("strengths")


def by_hand(batch: int) -> Document:
    """As the studio paints it, so many samples at once."""
    surface = bare()
    document = Document(surface, Painter(surface, BRUSH, "pine soot", "commanded", amount=amount()))
    document.begin_stroke(0.0, loads=loads(), strengths=strengths())
    samples = list(dry_recording().samples())
    for at in range(0, len(samples), batch):
        document.feed(samples[at : at + batch])
    document.end_stroke()
    return document


def test_it_has_loads_and_stays_bare() -> None:
    assert len(loads()) > 10
    assert len(strengths()) == 2
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


def test_what_is_told_of_the_first_sample_is_held_from_it_on() -> None:
    surface = bare()
    document = Document(surface, Painter(surface, BRUSH, "pine soot", "commanded", amount=amount()))
    document.begin_stroke(0.0, loads=((0, 0.3),), strengths=((0, 0.5),))
    for sample in list(dry_recording().samples())[:6]:  # in the air
        document.feed([sample])
    held = surface.ink.load
    assert held.sum() == pytest.approx(0.3 * document.painter.tuft.load)
    assert held.min() == pytest.approx(0.5 * held.sum())


def test_the_next_stroke_was_told_nothing() -> None:
    document = by_hand(64)
    document.begin_stroke(0.0)
    assert document.current_stroke is not None
    assert document.current_stroke.loads == document.current_stroke.strengths == ()
    document.dip()
    document.feed(list(dry_recording().samples()))
    document.end_stroke()
    assert document.surface.coverage.sum() > 1.2 * wanted().coverage.sum()


@pytest.mark.long
def test_the_images_of_a_stroke_hold_it_too() -> None:
    surface = bare()
    document = Document(surface, Painter(surface, BRUSH, "pine soot", "commanded", amount=amount()))
    document.set_symmetry(Symmetry((MirrorPlane((0.0, 40.0, 0.0), (0.0, 1.0, 0.0)),)))
    document.begin_stroke(0.0, loads=loads(), strengths=strengths())
    document.feed(list(dry_recording().samples()))
    document.end_stroke()
    one, both = wanted(), surface
    inks = [{p.name: a for p, a in zip(s.pigments, s.ink.amounts.sum(axis=0), strict=True)}
            for s in (one, both)]  # fmt: skip
    for name in ("pine soot", "water"):
        assert inks[1][name] == pytest.approx(2.0 * inks[0][name], rel=0.1)
    document.undo()
    assert not surface.coverage.any()
    document.redo()
    assert surface.coverage.any()


def test_a_whole_painting_knows_the_loads(tmp_path: Path) -> None:
    document = by_hand(64)
    assert document.score is not None
    save_score(document.score, tmp_path / "a.score.jsonl")
    played = painted(load_score(tmp_path / "a.score.jsonl"), load_mesh("plane"))
    same_vertices(played.surface, wanted())
    again = score_of_strokes(document.strokes, document.surface)
    assert again is not None
    same_vertices(painted(again, load_mesh("plane")).surface, wanted())


def test_a_stroke_keeps_what_was_told_with_a_session_and_as_a_recording() -> None:
    document = by_hand(64)
    stroke = document.strokes[0]
    assert (stroke.loads, stroke.strengths) == (loads(), strengths())
    kept = strokes_of([stroke.recording()])[0]
    assert (kept.loads, kept.strengths) == (loads(), strengths())
    recording = document.recording()
    assert recording is not None
    for name in ("loads", "strengths"):
        assert recording.header[name] == dry_recording().header[name]


@pytest.mark.parametrize("name", ["loads", "strengths"])
@pytest.mark.parametrize(
    "pairs", [((0, 1.5),), ((2, 0.5), (1, 0.5)), ((-1, 0.5),), ((0.5, 0.5),), (3,), "no"]
)
def test_what_is_no_pairs_is_refused(name, pairs) -> None:
    surface = bare()
    document = Document(surface, Painter(surface, BRUSH))
    with pytest.raises(InputError, match=f"{name} are .* pairs of a sample"):
        document.begin_stroke(0.0, **{name: pairs})
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
        stroke = window.document.strokes[0]
        assert (len(stroke.loads), len(stroke.strengths)) == (len(loads()), len(strengths()))
