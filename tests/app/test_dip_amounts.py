"""How much ink a dip takes up: in scores, sessions, the history, and files that say it wrongly."""

from __future__ import annotations

import dataclasses
import json
from contextlib import nullcontext
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from shapely import LineString

from paint3d.app.model.commands import encode_command, replay_command
from paint3d.app.model.document import Document
from paint3d.app.model.input.symmetry import MirrorPlane, Symmetry
from paint3d.app.model.score.playing import painted, score_of_strokes
from paint3d.app.model.score.stepping import cues_of
from paint3d.app.model.stroke_log import Stroke, strokes_of, weights_of
from paint3d.app.model.stroke_recall import StrokeRecall
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import DipAmount
from paint3d.calligraphy.flying_white import with_ink
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.page.page import Page, Piece
from paint3d.calligraphy.writing import WritingSettings, write_page
from paint3d.cli.main import main
from paint3d.colour.materials import load_material
from paint3d.device.recorded import Recording
from paint3d.errors import InputError, Paint3DError, RecordingError, SessionError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import load_session, save_session
from paint3d.painter.painter import Painter
from paint3d.recording.recording import save_recording
from paint3d.recording.score import load_score, save_score
from paint3d.recording.score_edits import delete_stroke
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.hands import line, pad_stroke, paint, same_vertices, small_plane

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from paint3d.app.model.persistence.settings import load_settings
from tests.app.test_score import read_back, same_paintings
from tests.support.app.gestures import live, pen_stroke, type_key, wait_for
from tests.support.app.windows import faults, opened, settled

LITTLE, MUCH = {"wetted": 0.05, "fullness": 1.5}, {"wetted": 0.5, "fullness": 0.5}
BAD = [
    ({"wetted": 7}, "7; expected"),
    ({"wetted": 0}, "0; expected"),
    ({"fullness": 0.01}, "0.01; expected"),
    ({"fullness": "much"}, "expected"),
    ({"wetted": True}, "expected"),
    ({"wet": 0.5}, "expected"),
    ("half", "expected"),
    (None, "expected"),
    ([0.5, 1.0], "expected"),
]


def sitting() -> Document:
    """Strokes of three amounts."""
    document = small_plane(2.5)
    paint(document, (-15, -10), (15, -10))
    document.dip(amount=LITTLE)
    paint(document, (-15, 0), (15, 0))
    paint(document, (-15, 5), (15, 5))
    document.dip("cinnabar", amount=MUCH)
    paint(document, (-15, 10), (15, 10))
    return document


def in_hand(document: Document) -> tuple[DipAmount, float, float]:
    """The amount, what a dip gives, and how quickly it is given."""
    painter = document.painter
    return painter.amount, painter.tuft.load, painter.tuft.transfer_per_mm


def of_amount(document: Document, amount: DipAmount) -> tuple[DipAmount, float, float]:
    """What `in_hand` is to say."""
    brush = document.painter.brush
    bare = Painter(PaintedSurface(load_mesh("plane"), 5.0, document.surface.material), brush).tuft
    own = amount.of_tuft(bare)
    return amount, own.load, own.transfer_per_mm


def test_strokes_say_what_their_dips_took_up() -> None:
    document = sitting()
    said = [stroke.amount for stroke in document.strokes]
    assert said == [DipAmount(), DipAmount(**LITTLE), DipAmount(**LITTLE), DipAmount(**MUCH)]
    headers = [stroke.recording().header for stroke in document.strokes]
    assert [header.get("dip") for header in headers] == [None, LITTLE, LITTLE, MUCH]


def test_a_score_with_amounts_is_painted_to_the_bit(tmp_path: Path) -> None:
    document = sitting()
    again = painted(read_back(document.score, tmp_path), document.surface.source)
    same_paintings(document, again)
    assert in_hand(again) == in_hand(document) == of_amount(document, DipAmount(**MUCH))


def test_a_score_knows_the_amount_with_which_painting_began(tmp_path: Path) -> None:
    surface = PaintedSurface(load_mesh("plane"), 2.5)
    document = Document(surface, Painter(surface, amount=DipAmount(**LITTLE)))
    paint(document, (-15, 0), (15, 0))
    again = painted(read_back(document.score, tmp_path), surface.source)
    same_paintings(document, again)
    assert in_hand(again) == in_hand(document)


def test_strokes_alone_keep_their_amounts() -> None:
    document = sitting()
    score = score_of_strokes(document.strokes, document.surface)
    assert score is not None
    dips = [line for line in score.events if isinstance(line, dict) and line["do"] == "dip"]
    assert [dip.get("amount") for dip in dips] == [None, LITTLE, MUCH]
    again = painted(score, document.surface.source)
    same_paintings(document, again)


def test_a_session_is_reopened_with_the_amount_in_hand(tmp_path: Path) -> None:
    document = sitting()
    document.save(tmp_path / "a.p3d")
    opened = Document.open(tmp_path / "a.p3d")
    assert in_hand(opened) == in_hand(document)
    assert [s.amount for s in opened.strokes] == [s.amount for s in document.strokes]
    for one in (document, opened):
        one.dip()
        paint(one, (-15, -5), (15, -5))
    assert opened.painter.in_brush() == pytest.approx(document.painter.in_brush())


@pytest.mark.parametrize("is_reopened", [False, True])
def test_undo_leaves_the_amount_that_was_chosen_last(tmp_path: Path, is_reopened: bool) -> None:
    """As the brush and the ink; what is dipped again then takes up as much as it says."""
    document = sitting()
    if is_reopened:
        document.save(tmp_path / "a.p3d")
        document = Document.open(tmp_path / "a.p3d")
    for _ in range(3):
        document.undo()
        assert in_hand(document) == of_amount(document, DipAmount(**MUCH))
    document.dip()
    assert document.painter.in_brush() == pytest.approx(document.painter.tuft.load)


@pytest.mark.parametrize("is_reopened", [False, True])
def test_redo_leads_to_the_amount_that_was_there(tmp_path: Path, is_reopened: bool) -> None:
    """That is, to before the next stroke began: dipped for it already."""
    document = sitting()
    if is_reopened:
        document.save(tmp_path / "a.p3d")
        document = Document.open(tmp_path / "a.p3d")
    for _ in range(4):
        document.undo()
    for amount in (LITTLE, LITTLE, MUCH, MUCH):
        document.redo()
        assert in_hand(document) == of_amount(document, DipAmount(**amount))
    again = sitting()
    assert document.painter.in_brush() == pytest.approx(again.painter.in_brush())


def test_a_session_without_steps_paints_strokes_again_with_their_amounts(tmp_path: Path) -> None:
    sitting().save(tmp_path / "a.p3d")
    save_session(
        dataclasses.replace(load_session(tmp_path / "a.p3d"), history=None), tmp_path / "b.p3d"
    )
    document = Document.open(tmp_path / "b.p3d")
    document.replay_history(1)
    assert in_hand(document) == of_amount(document, DipAmount(**MUCH))
    for amount in (DipAmount(**LITTLE), DipAmount(**LITTLE), DipAmount(**MUCH)):
        document.redo()
        assert in_hand(document) == of_amount(document, amount)


@pytest.mark.parametrize("edit", [{"do": "delete"}, {"do": "ink", "ink": "indigo"}])
def test_an_edit_and_its_undo_leave_the_amount_that_was_chosen_last(edit: dict) -> None:
    document = sitting()
    document.dip(amount=LITTLE)
    document.edit_strokes([1], edit)
    assert in_hand(document) == of_amount(document, DipAmount(**LITTLE))
    document.dip(amount={"wetted": 0.25})
    document.undo()
    assert in_hand(document) == of_amount(document, DipAmount(0.25))
    document.redo()
    again = painted(document.score, document.surface.source)
    assert in_hand(document) == in_hand(again)


def test_an_amount_that_a_deleted_stroke_brought_stays() -> None:
    document = small_plane(2.5)
    document.begin_stroke()
    document.feed(line((-15, 0), (0, 0)))
    document.dip(amount=LITTLE)
    document.feed(line((1, 0), (15, 0), t0=10**9))
    document.end_stroke()
    document.dip()
    paint(document, (-15, 5), (15, 5))
    left = painted(delete_stroke(document.score, 1), document.surface.source)
    assert in_hand(left) == in_hand(document)


def test_a_dip_that_is_refused_changes_nothing() -> None:
    document = small_plane(2.5)
    before, held = in_hand(document), document.painter.in_brush()
    for ink in ("no such ink", {"pine soot": -1.0}, {}):
        with pytest.raises(InputError):
            document.dip(ink, amount=LITTLE)
        assert in_hand(document) == before
        assert document.painter.in_brush() == held
    again = painted(document.score, document.surface.source)
    assert in_hand(again) == before
    assert all(cue.command != "dip" for cue in cues_of(document.score, again.surface))


def test_the_journal_knows_an_amount() -> None:
    document = small_plane(5.0)
    line = encode_command(document, "dip", ("cinnabar",), {"amount": LITTLE})
    note = json.loads(json.dumps(line))
    replay_command(document, note)
    assert in_hand(document) == of_amount(document, DipAmount(**LITTLE))


# -- files that say it wrongly ------------------------------------------------------------------


@pytest.mark.parametrize(("amount", "message"), BAD)
def test_a_score_with_a_bad_amount(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], amount: object, message: str
) -> None:
    file = tmp_path / "a.score.jsonl"
    save_score(sitting().score, file)
    lines = file.read_text().splitlines()
    k = next(k for k, line in enumerate(lines) if "amount" in line)
    lines[k] = json.dumps({"do": "dip", "amount": amount})
    file.write_text("\n".join(lines) + "\n")
    with pytest.raises(RecordingError, match=rf"a\.score\.jsonl:{k + 1}: .*{message}"):
        load_score(file)
    words = ["replay", str(file), "--on", "plane", "--out", str(tmp_path / "a.ply"), "--quiet"]
    assert main(words) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "amount" in error


@pytest.mark.parametrize(("amount", "message"), BAD)
@pytest.mark.parametrize("where", ["settings", "stroke"])
def test_a_session_with_a_bad_amount(
    tmp_path: Path, where: str, amount: object, message: str
) -> None:
    document = sitting()
    document.save(tmp_path / "a.p3d")
    session = load_session(tmp_path / "a.p3d")
    if where == "settings":
        session = dataclasses.replace(session, settings={**session.settings, "amount": amount})
    else:
        first, *rest = session.strokes
        bad = dataclasses.replace(first, header={**first.header, "dip": amount})
        session = dataclasses.replace(session, strokes=(bad, *rest))
    save_session(session, tmp_path / "b.p3d")
    with pytest.raises(SessionError, match=rf"b\.p3d: .*{message}") as caught:
        Document.open(tmp_path / "b.p3d")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("amount", "message"), BAD)
def test_steps_with_a_bad_amount_are_dropped(tmp_path: Path, amount: object, message: str) -> None:
    sitting().save(tmp_path / "a.p3d")
    session = load_session(tmp_path / "a.p3d")
    painters = [{**words, "amount": amount} for words in session.history["painters"]]
    history = {**session.history, "painters": painters}
    save_session(dataclasses.replace(session, history=history), tmp_path / "b.p3d")
    opened = Document.open(tmp_path / "b.p3d")
    assert message.split(";")[-1].strip() in opened.refused_history
    assert not opened.steps.done


@pytest.mark.parametrize("amount", [amount for amount, _ in BAD if amount is not None])
def test_a_document_refuses_a_bad_amount(amount: object) -> None:
    document = small_plane(5.0)
    before = in_hand(document)
    with pytest.raises(Paint3DError, match="expected"):
        document.dip("cinnabar", amount=amount)  # type: ignore[arg-type]
    assert in_hand(document) == before


def test_a_painting_from_the_command_line_keeps_its_amount(tmp_path: Path) -> None:
    """What is dipped anew in the session takes up as much as while it was written."""
    words = ["write", "一一一", "--on", "plane", "--resolution", "2", "--size", "12", "--quiet"]
    assert main([*words, "--dip", "every 3", "--out", str(tmp_path / "a.p3d")]) == 0
    document = Document.open(tmp_path / "a.p3d")
    assert document.painter.amount != DipAmount()
    (recording,) = load_session(tmp_path / "a.p3d").recordings
    assert document.painter.amount == DipAmount.of(recording.header["dip"])


def test_a_stroke_without_an_amount_is_as_the_preset_says() -> None:
    stroke = Stroke(0.0, small_plane(5.0).painter.brush, {"pine soot": 1.0}, "Layer 1")
    assert stroke.amount == DipAmount()


# -- loads that are told -----------------------------------------------------------------------


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
    written = write_page(load_mesh("plane"), page, WritingSettings(load_brush(BRUSH), 24.0))
    return with_ink(written.recording, written.dryness, written.strength, load_material("xuan"))


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
    with opened(program, "plane", RESOLUTION, "xuan", drawn=False) as window:
        window.workspace.post("dip", "pine soot")  # the command's, where a recording names none
        assert window.recordings.replay_file(str(file))
        wait_for(lambda: not window.player.is_playing)
        settled(window)
        same_vertices(window.document.surface, wanted())
        stroke = window.document.strokes[0]
        assert (len(stroke.loads), len(stroke.strengths)) == (len(loads()), len(strengths()))


# -- tips in another ink -----------------------------------------------------------------------


def held(surface: PaintedSurface) -> dict[str, np.ndarray]:
    """Ink along the tuft, by its name."""
    stations = surface.ink.reservoirs
    return {p.name: stations[:, k] for k, p in enumerate(surface.pigments) if stations[:, k].any()}


@pytest.mark.parametrize("how", ["options", "header"])
def test_a_session_by_command_dips_belly_and_tip_again(tmp_path, how) -> None:
    file, out = tmp_path / "a.jsonl", tmp_path / "a.p3d"
    words = ["--ink", "water", "--tip", "indigo", "--reach", "0.4"]
    way = np.column_stack([np.linspace(-8.0, 8.0, 20), np.zeros(20)])
    stroke = pad_stroke(way, 0.4, 1.2)
    if how == "header":
        own = {"ink": "water", "tip": "indigo", "reach": 0.4}
        stroke, words = replace(stroke, header={**stroke.header, **own}), []
    save_recording(stroke, file)
    on = ["--on", "plane", "--resolution", "2.5", "--quiet", "--out", str(out)]
    assert main(["replay", str(file), *on, *words]) == 0
    document = Document.open(out)
    assert [(weights_of(ink), reach) for ink, reach in document.painter.dips] == [
        ({"water": 1.0}, None), ({"indigo": 1.0}, 0.4)
    ]  # fmt: skip
    document.dip()
    fresh = PaintedSurface(load_mesh("plane"), 2.5)
    painter = Painter(fresh, document.painter.brush, "water")
    painter.dip("indigo", 0.4)
    ours, its = held(document.surface), held(fresh)
    assert ours.keys() == its.keys() == {"water", "indigo"}
    for name, along in its.items():
        np.testing.assert_array_equal(ours[name], along)
    document.save(tmp_path / "b.p3d")
    again = Document.open(tmp_path / "b.p3d").painter
    assert [reach for _, reach in again.dips] == [None, 0.4]


@pytest.mark.parametrize("fails", [False, True])
@pytest.mark.parametrize("brush", ["full", "slender"])
def test_a_tip_in_hand_is_there_still_when_old_strokes_were_painted_again(
    tmp_path, monkeypatch, brush, fails
) -> None:
    """With the brush of the old strokes, too, and with another, which is dipped for it anew."""
    document = small_plane(2.5)
    paint(document, (-15, 0), (15, 0))
    document.save(tmp_path / "a.p3d")
    session = load_session(tmp_path / "a.p3d")
    save_session(dataclasses.replace(session, undone=(), history=None), tmp_path / "a.p3d")
    document = Document.open(tmp_path / "a.p3d")
    assert document.n_strokes_without_undo == 1
    document.set_brush(brush)
    document.dip("water")
    document.dip("indigo", 0.4)
    before, full = document.painter.dips, held(document.surface)
    full = {name: along.copy() for name, along in full.items()}
    if fails:

        def fail(_: object) -> None:
            raise InputError("no")

        monkeypatch.setattr(StrokeRecall, "repeat", lambda self, strokes: fail(strokes))
    with pytest.raises(InputError) if fails else nullcontext():
        document.recall_strokes()
    ours = held(document.surface)
    assert ours.keys() == full.keys() == {"water", "indigo"}
    for name, along in full.items():
        np.testing.assert_allclose(ours[name], along, rtol=1e-9)
    assert [(weights_of(ink), reach) for ink, reach in document.painter.dips] == [
        (weights_of(ink), reach) for ink, reach in before
    ]


# -- dips by the hand --------------------------------------------------------------------------


KEY = QtCore.Qt.Key
PRESSURES = [0.1, *[0.6] * 10, 0.0]
LITTLE_LEFT = DipAmount(0.05, 1.5)


@pytest.fixture
def window(program):
    with faults() as found, opened(program, "plane", 2.5, "porcelain", drawn=False) as window:
        window.panels.docks["inks"].raise_()
        live(0.05)
        yield window
        window.workspace.update_settings(dips_by_itself=False)
    assert found == []


def choose(box, percent: float) -> None:
    """Type a share into a box."""
    box.setFocus()
    box.selectAll()
    QtTest.QTest.keyClicks(box, f"{percent:g}")
    QtTest.QTest.keyClick(box, KEY.Key_Return)


def choose_little(window) -> None:
    choose(window.panels.inks.wetted, 5.0)
    choose(window.panels.inks.fullness, 150.0)


def stroke(window, row: float) -> None:
    pen_stroke(window.canvas, (0.35, row), (0.62, row), PRESSURES)
    settled(window)


def dip_by_key(window) -> None:
    window.canvas.setFocus()
    type_key(window.canvas, KEY.Key_D)
    settled(window)


def in_the_hand(window) -> tuple[DipAmount, float]:
    """What dips take up, and what is held against a full brush of the preset."""
    settled(window)
    painter = window.document.painter
    return painter.amount, float(painter.surface.ink.load.sum())


@pytest.mark.parametrize("how", ["a dish", "the key"])
def test_a_dip_takes_up_as_much_as_was_chosen(window, how: str) -> None:
    full = in_the_hand(window)[1]
    choose_little(window)
    assert in_the_hand(window) == (DipAmount(), full)  # nothing is dipped by choosing
    if how == "a dish":
        window.panels.inks.dishes.taken.emit("pine soot")
    else:
        dip_by_key(window)
    amount, held = in_the_hand(window)
    assert amount == LITTLE_LEFT
    assert held == pytest.approx(0.05 * 1.5 * full, rel=1e-6)
    window.panels.inks.dishes.taken.emit("indigo")  # and the next dip, too
    assert in_the_hand(window) == (LITTLE_LEFT, pytest.approx(held))


def test_it_is_kept_in_score_and_session(window, tmp_path: Path) -> None:
    choose_little(window)
    dip_by_key(window)
    stroke(window, 0.4)
    again = painted(window.document.score, window.document.surface.source)
    with window.stage.paint_thread.paused() as document:
        same_paintings(document, again)
    assert again.painter.amount == LITTLE_LEFT
    assert window.saving.save_to(tmp_path / "a.p3d")
    assert Document.open(tmp_path / "a.p3d").painter.amount == LITTLE_LEFT
    choose(window.panels.inks.wetted, 100.0)
    assert window.opening.open_path(tmp_path / "a.p3d")
    settled(window)
    inks = window.panels.inks
    assert (inks.wetted.value(), inks.fullness.value()) == (5.0, 150.0)


def test_the_tip_is_dipped_without_an_amount(window) -> None:
    inks = window.panels.inks
    choose_little(window)
    inks.tip_only.setChecked(True)
    assert not inks.wetted.isEnabled()
    inks.dishes.taken.emit("indigo")
    assert in_the_hand(window)[0] == DipAmount()
    inks.tip_only.setChecked(False)
    assert inks.wetted.isEnabled()


def test_it_is_dipped_by_itself_before_a_stroke_for_which_little_is_left(window) -> None:
    choose(window.panels.inks.wetted, 1.0)
    dip_by_key(window)
    full = in_the_hand(window)[1]
    for row in (0.35, 0.40):
        stroke(window, row)
    assert 0.0 < in_the_hand(window)[1] < 0.25 * full
    stroke(window, 0.45)  # it is not wanted yet
    assert not window.document.strokes[-1].dipped_since_stroke
    window.panels.inks.by_itself.click()
    left = in_the_hand(window)[1]
    stroke(window, 0.50)
    assert window.document.strokes[-1].dipped_since_stroke
    assert in_the_hand(window)[1] > left
    assert window.document.painter.amount == DipAmount(wetted=0.01)
    with window.stage.paint_thread.paused() as document:
        same_paintings(document, painted(document.score, document.surface.source))
    assert load_settings()[0].dips_by_itself


def test_it_is_not_dipped_by_itself_while_enough_is_left_or_when_it_was_rinsed(window) -> None:
    window.panels.inks.by_itself.click()
    stroke(window, 0.35)
    stroke(window, 0.40)  # most is left of a whole dip
    assert [one.dipped_since_stroke for one in window.document.strokes] == [True, False]
    window.workspace.actions["rinse"].trigger()
    settled(window)
    stroke(window, 0.45)
    assert in_the_hand(window)[1] == 0.0
    assert not window.document.strokes[-1].dipped_since_stroke


def test_the_boxes_follow_dips_that_took_up_other_amounts(window) -> None:
    amount = DipAmount(0.25, 0.5)
    window.workspace.post("dip", "cinnabar", None, amount.words())
    inks = window.panels.inks
    wait_for(lambda: inks.amount() == amount)
    dip_by_key(window)
    assert in_the_hand(window)[0] == amount
