"""How much ink a dip takes up: in scores, sessions, the history, and files that say it wrongly."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import pytest

from paint3d.app.model.commands import do_again, encode_command
from paint3d.app.model.document import Document
from paint3d.app.model.score.playing import painted, score_of_strokes
from paint3d.app.model.score.stepping import cues_of
from paint3d.app.model.stroke_log import Stroke
from paint3d.brush.spec import DipAmount
from paint3d.cli.main import main
from paint3d.errors import InputError, Paint3DError, RecordingError, SessionError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import load_session, save_session
from paint3d.painter.painter import Painter
from paint3d.recording.score import load_score, save_score
from paint3d.recording.score_edits import delete_stroke
from paint3d.surface.painted_surface import PaintedSurface
from tests.app.test_score import read_back, same_paintings
from tests.support.app.hands import line, paint, small_plane

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
    document.edit_stroke(1, edit)
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
    do_again(document, note)
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
