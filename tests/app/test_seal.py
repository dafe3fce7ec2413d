"""A seal on a document: a step like any other, for undo, sessions, scores and journals."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.app.model.commands import do_again, encode_command
from paint3d.app.model.document import Document
from paint3d.app.model.mask import AngleMask, Mask
from paint3d.app.model.score.playing import painted
from paint3d.colour.pigments import load_pigment
from paint3d.errors import InputError, LayerError
from paint3d.recording.score import load_score, save_score
from tests.support.app.hands import paint, small_plane

RINGS = [[[-6, -6], [6, -6], [6, 6], [-6, 6]], [[-5, -5], [5, -5], [5, 5], [-5, 5]],
         [[-3, -1], [3, -1], [3, 1], [-3, 1]]]  # fmt: skip
HERE, UP = [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]


@pytest.fixture
def document() -> Document:
    made = Document.new(small_plane().surface.source, 0.5, "xuan")
    paint(made, (-15, 0), (15, 0))
    return made


def state(document: Document):
    surface = document.surface
    return surface.srgb.copy(), surface.share_painted(), surface.wet_ink(), surface.dry_ink()


def same(one, other) -> None:
    n = min(len(one[0]), len(other[0]))
    for a, b in zip(one[:2], other[:2], strict=True):
        np.testing.assert_array_equal(a[:n], b[:n])
    np.testing.assert_allclose(one[2:], other[2:], rtol=1e-9)


def test_a_seal_can_be_undone_and_done_again(document: Document) -> None:
    document.press_seal(RINGS, HERE, UP)
    document.undo()
    before = state(document)
    document.redo()
    after = state(document)
    assert document.steps.done[-1] == "seal"
    red = after[0].astype(int)
    assert ((red[:, 0] > 1.6 * red[:, 1]) & (after[1] > 0.9)).sum() > 50
    document.undo()
    same(before, state(document))


def test_it_lies_on_what_was_painted_and_its_paste_is_counted(document: Document) -> None:
    wet = document.surface.wet_ink()
    document.press_seal(RINGS, HERE, UP)
    accounts = document.painter.ledger()
    loaded = accounts.pop("loaded")
    assert sum(accounts.values()) == pytest.approx(loaded, rel=1e-6)
    assert accounts["wet"] < wet  # what was below has dried
    middle = int(np.argmin(np.linalg.norm(document.surface.mesh.vertices, axis=1)))
    r, g, _ = document.surface.srgb[middle].astype(int)
    assert r > 1.5 * g  # a full coat of vermilion over black ink


def test_sessions_keep_it_with_its_step(document: Document, tmp_path) -> None:
    document.press_seal(RINGS, HERE, UP, seed=7)
    document.save(tmp_path / "a.p3d")
    again = Document.open(tmp_path / "a.p3d")
    same(state(document), state(again))
    assert again.refused_history == ""
    again.undo()
    document.undo()
    same(state(document), state(again))


def test_a_score_repeats_it_to_the_bit(document: Document, tmp_path) -> None:
    document.press_seal(RINGS, HERE, UP, {"cinnabar": 2.0, "minium": 1.0}, coats=0.8, wear=2.0)
    assert document.score is not None
    save_score(document.score, tmp_path / "a.jsonl")
    again = painted(load_score(tmp_path / "a.jsonl"), small_plane().surface.source)
    np.testing.assert_array_equal(again.surface.srgb, document.surface.srgb)


def test_a_journal_repeats_it(document: Document) -> None:
    other = Document.new(small_plane().surface.source, 0.5, "xuan")
    note = encode_command(other, "press_seal", [RINGS, HERE, UP], {"seed": 3})
    do_again(other, note)
    assert other.steps.done == ["seal"]
    assert other.surface.painted.any()


def test_masks_and_layers_are_heeded(document: Document) -> None:
    document.surface.column_of(load_pigment("cinnabar"))  # what comes later colours all anew
    document.set_mask(Mask(AngleMask((0.0, 0.0, -1.0), 30.0)))  # nothing faces down
    before = state(document)
    document.press_seal(RINGS, HERE, UP)
    same(before, state(document))
    document.set_mask(Mask())
    document.set_locked(0)
    with pytest.raises(LayerError):
        document.press_seal(RINGS, HERE, UP)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (([], HERE), "a seal of 0 rings"),
        (([[[0, 0], [1, 1]]], HERE), "expected rings of three"),
        (([[[0, 0], [0, 0], [0, 0]]], HERE, UP), "go around no area"),
        ((RINGS, HERE, (0, 0, 1)), "along the surface's normal"),
        ((RINGS, HERE, UP, {}), "a paste of nothing"),
        ((RINGS, HERE, UP, "cinnabar", 0.0), "coats"),
    ],
)
def test_what_cannot_be_pressed_is_said(document: Document, given, words: str) -> None:
    steps = list(document.steps.done)
    with pytest.raises(InputError, match=words):
        document.press_seal(*given)
    assert document.steps.done == steps


def test_no_wet_ink_is_lost_below_it(document: Document) -> None:
    """What is dipped for is the paste alone, on wet ink as on bare paper."""
    bare = Document.new(small_plane().surface.source, 0.5, "xuan")
    paint(bare, (-15, 0), (15, 0))
    bare.undo()  # the same vertices, without ink
    paste = []
    for one in (document, bare):
        before = one.painter.loaded
        one.press_seal(RINGS, HERE, UP)
        paste.append(one.painter.loaded - before)
    assert paste[0] == pytest.approx(paste[1], rel=0.01)


def test_it_is_not_pressed_within_a_stroke(document: Document) -> None:
    document.begin_stroke()
    with pytest.raises(InputError, match="a seal"):
        document.press_seal(RINGS, HERE, UP)
    document.end_stroke()


def test_what_was_undone_only_to_look_at_it_is_there_below_a_seal(document: Document) -> None:
    document.replay_history(0, passing=True)
    assert len(document.strokes) == 0
    document.press_seal(RINGS, HERE, UP)
    assert len(document.strokes) == 1
    document.undo()
    assert document.surface.painted.any()
