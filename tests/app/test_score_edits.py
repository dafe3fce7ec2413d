"""Edited scores, painted: what an edit changes of a painting, and what it leaves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.app.model.document import Document
from paint3d.app.model.score.playing import painted
from paint3d.errors import Paint3DError
from paint3d.recording import change_brush, change_ink, delete_stroke
from paint3d.recording.score import Score
from tests.support.app.hands import line, paint, small_plane
from tests.support.examples import examples

ENDS = st.tuples(st.floats(-18, 18), st.floats(-18, 18))
BETWEEN = st.sampled_from([None, None, ("dip", "indigo"), ("let_time_pass", 0.3), ("wipe", 0.5),
                           ("step_brush", -1), ("dip", "cinnabar", 0.5)])  # fmt: skip
STROKES = st.tuples(ENDS, ENDS, st.floats(0.2, 0.8), BETWEEN)


def sitting(strokes, **options) -> list[Document]:
    """A sitting; the painting as it was after each stroke, and before the first."""
    document = small_plane(5.0, **options)
    for start, end, press, between in strokes:
        if between:
            getattr(document, between[0])(*between[1:])
        paint(document, start, end, n=6, pressure=press)
    return document


def same_bits(one: Document, other: Document) -> None:
    for get in (
        lambda d: d.surface.paint_mesh.vertices,
        lambda d: d.surface.amounts,
        lambda d: d.surface.coverage,
        lambda d: d.surface.srgb,
        lambda d: d.surface.ink.load,
    ):
        one.refresh(), other.refresh()
        np.testing.assert_array_equal(get(one), get(other))


@settings(deadline=None, max_examples=examples(25))
@given(st.lists(STROKES, min_size=1, max_size=3), st.sampled_from(["xuan", "porcelain"]))
def test_without_the_last_stroke_it_is_as_before_that(strokes, material) -> None:
    document = sitting(strokes, material=material)
    mesh, before = document.surface.source, document.score
    paint(document, (-10, 3), (15, -9))
    document.follow_time(0.05)
    after = document.score
    shorter = Score(after.header, after.events[: len(before.events)])
    same_bits(painted(shorter, mesh), painted(before, mesh))
    without = delete_stroke(after, len(strokes) + 1)
    assert without.events[-1] == {"do": "follow_time", "seconds": 0.05}
    same_bits(painted(Score(without.header, without.events[:-1]), mesh), painted(before, mesh))


@settings(deadline=None, max_examples=examples(25))
@given(st.lists(STROKES, min_size=2, max_size=3), st.integers(1, 3), st.sampled_from([0, 30]))
def test_another_ink_lies_where_the_first_did_and_as_thick(strokes, number, hairs) -> None:
    document = sitting([(*stroke[:3], None) for stroke in strokes])
    score = document.score
    both = [{"do": "dip", "ink": ink} for ink in ("cinnabar", "pine soot")]  # rounding differs by
    header = {**score.header, **({"hairs": hairs} if hairs else {})}  # how many inks there are
    score = Score(header, (*both, *score.events))
    number = min(number, len(strokes))
    one = painted(score, document.surface.source)
    other = painted(change_ink(score, number, "cinnabar"), document.surface.source)
    np.testing.assert_array_equal(
        other.surface.paint_mesh.vertices, one.surface.paint_mesh.vertices
    )
    np.testing.assert_allclose(other.surface.coverage, one.surface.coverage, atol=1e-6)
    sums = [d.surface.amounts.sum(axis=1) for d in (other, one)]
    np.testing.assert_allclose(*sums, atol=2e-6)
    assert [s.ink for s in other.strokes][number - 1] == {"cinnabar": 1.0}
    assert {*other.strokes[number - 1].ink} != {*one.strokes[number - 1].ink}
    assert other.painter.dipped == one.painter.dipped
    ledger = other.painter.ledger()
    assert ledger["loaded"] == pytest.approx(sum(ledger.values()) - ledger["loaded"])


def test_another_brush_is_for_one_stroke_and_leaves_the_own_one_as_it_was() -> None:
    document = sitting([((-15, y), (15, y), 0.5, None) for y in (-9, 0, 9)])
    mesh, score = document.surface.source, document.score
    other = painted(change_brush(score, 2, "feibai"), mesh)
    assert [s.brush.name for s in other.strokes] == ["full", "feibai", "full"]
    assert other.painter.brush.name == "full"
    without = painted(delete_stroke(score, 2), mesh)
    np.testing.assert_array_equal(without.surface.ink.load, other.surface.ink.load)
    ledger = other.painter.ledger()
    assert ledger["loaded"] == pytest.approx(sum(ledger.values()) - ledger["loaded"])


@pytest.mark.parametrize("end", ["end_stroke", "cancel_stroke", "undo"])
def test_what_was_lent_for_a_stroke_comes_back_however_it_ends(end) -> None:
    document = small_plane(2.0, brush="full", ink="pine soot")
    load, loaded = document.surface.ink.load.copy(), document.painter.loaded
    document.begin_stroke(brush=document.painter.brush, ink={"cinnabar": 1.0})
    document.feed(line((-10, 0), (10, 0)))
    getattr(document, end)()
    assert document.painter.dipped == "pine soot"
    np.testing.assert_array_equal(document.surface.ink.load[: len(load)], load)
    if end != "end_stroke":
        assert document.painter.loaded == loaded
        assert not document.strokes


def test_a_stroke_with_an_ink_that_is_none_does_not_begin() -> None:
    document = small_plane(2.0)
    with pytest.raises(Paint3DError, match="unknown ink"):
        document.begin_stroke(ink="sut")
    document.feed(line((-10, 0), (10, 0)))  # passed over
    document.end_stroke()
    assert not document.strokes
    assert not document.steps.done
    assert not document.surface.painted.any()
    paint(document, (-10, 0), (10, 0))
    assert len(document.strokes) == 1
