"""A stroke of a painting edited afterwards: painted anew from there, and undone to the bit."""

from __future__ import annotations

import dataclasses
from itertools import chain

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from paint3d.app.model.commands import decode_command, encode_command, replay_command
from paint3d.app.model.document import Document
from paint3d.app.model.input.symmetry import MirrorPlane, Symmetry
from paint3d.app.model.mask import AngleMask, Mask
from paint3d.app.model.score.playing import painted
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BristleSpec
from paint3d.errors import InputError, LayerError, Paint3DError, RecordingError
from paint3d.recording.score import write_score
from tests.app.test_score import OWN, PASSAGES, do
from tests.support.app.hands import paint, small_plane
from tests.support.examples import examples

EDITS = st.sampled_from(
    [
        {"do": "delete"},
        {"do": "move", "along": (2.0, -1.5), "turn_deg": 20.0},
        {"do": "ink", "ink": {OWN: 1.0, "water": 0.5}},
        {"do": "brush", "brush": load_brush("feibai")},
        {"do": "time", "factor": 1.7},
    ]
)


def snap(document: Document) -> dict:
    document.refresh()
    surface = document.surface
    return {
        "srgb": surface.srgb.copy(), "amounts": surface.amounts.copy(),
        "coverage": surface.coverage.copy(), "load": surface.ink.load.copy(),
        "layers": document.layers, "active": document.active_layer,
        "strokes": [(s.brush, s.ink, len(s.samples)) for s in document.strokes],
        "undone": len(document.undone_strokes), "brush": document.painter.brush,
        "steps": len(document.steps.done),
    }  # fmt: skip


def same(one: dict, other: dict, but: tuple[str, ...] = ()) -> None:
    """To the bit, apart from vertices and pigments that came since, of which there is nothing."""
    for name in one.keys() - set(but):
        a, b = one[name], other[name]
        if not isinstance(a, np.ndarray):
            assert a == b, name
            continue
        if name == "srgb":
            off = np.abs(b[: len(a)].astype(int) - a)
            assert off.max() <= 1  # with every pigment that comes to it sums round otherwise
            continue
        common = tuple(slice(0, n) for n in a.shape)
        np.testing.assert_array_equal(a, b[common], err_msg=name)
        assert b.sum() == pytest.approx(a.sum())


def as_replayed(document: Document) -> None:
    """It looks as its score does when that is painted on a bare object."""
    again = painted(document.score, document.surface.source)
    again.refresh(), document.refresh()
    one, other = document.surface, again.surface
    off, at = cKDTree(one.paint_mesh.vertices).query(other.paint_mesh.vertices)
    assert off.max() == 0.0
    np.testing.assert_allclose(one.coverage[at], other.coverage, atol=1e-4)
    apart = np.abs(one.srgb[at].astype(int) - other.srgb.astype(int)).max(axis=1)
    assert apart.max(initial=0) <= 2
    assert [layer.name for layer in again.layers] == [layer.name for layer in document.layers]
    assert len(again.strokes) == len(document.strokes)


@settings(deadline=None, max_examples=examples(25), phases=(Phase.generate,))
@given(st.lists(PASSAGES, min_size=2, max_size=4), st.integers(0, 3), EDITS)
def test_any_stroke_of_any_sitting_is_edited_as_its_score_is(passages, number, edit) -> None:
    document = small_plane(5.0, material="xuan")
    for k, one in enumerate(chain.from_iterable(passages)):
        do(document, one, 1_000_000_000 * (k + 1))
    document.break_off()
    if document.looks_back:
        document.replay_history(len(document.strokes) + len(document.undone_strokes))
    before, score = snap(document), list(write_score(document.score))
    if not document.strokes:
        with pytest.raises(InputError, match=r"stroke 1"):
            document.edit_strokes([0], edit)
        return
    number %= len(document.strokes)
    try:
        document.edit_strokes([number], edit)
    except Paint3DError:  # off the plane, or a later line cannot be done any more
        same(before, snap(document))
        assert list(write_score(document.score)) == score
        return
    after, edited = snap(document), list(write_score(document.score))
    as_replayed(document)
    document.undo()
    same(before, snap(document))
    assert list(write_score(document.score)) == score
    document.redo()
    same(after, snap(document))
    assert list(write_score(document.score)) == edited


def sitting(n: int = 5, **options) -> Document:
    document = small_plane(3.0, material="xuan", **options)
    for k, y in enumerate(np.linspace(-15, 15, n)):
        if k == 2:
            document.dip("indigo")
        paint(document, (-12, y), (12, y + 2), t0=1_000_000_000 * (k + 1))
        document.follow_time(0.05)
    return document


def test_edits_are_steps_among_others() -> None:
    document = sitting()
    states = [snap(document)]
    document.edit_strokes([1], {"do": "move", "along": (3.0, 0.0)})
    states.append(snap(document))
    document.edit_strokes([3], {"do": "delete"})
    states.append(snap(document))
    paint(document, (-10, -10), (10, 10), t0=9_000_000_000)
    states.append(snap(document))
    document.edit_strokes([0], {"do": "ink", "ink": "cinnabar"})
    states.append(snap(document))
    for state in reversed(states[:-1]):
        document.undo()
        same(state, snap(document), but=("load", "undone"))
    document.undo()
    assert len(document.strokes) == 4
    document.redo()
    for state in states[1:]:
        document.redo()
        same(state, snap(document), but=("load", "undone"))
    assert not document.can_redo
    as_replayed(document)


def test_an_edit_that_was_undone_is_forgotten_with_the_next_stroke() -> None:
    document = sitting()
    document.edit_strokes([2], {"do": "delete"})
    document.undo()
    assert document.can_redo
    paint(document, (-10, -10), (10, 10), t0=9_000_000_000)
    assert not document.can_redo
    document.redo()
    assert len(document.strokes) == 6
    as_replayed(document)


def test_the_history_goes_through_the_edited_strokes() -> None:
    document = sitting()
    document.edit_strokes([1], {"do": "delete"})
    whole = snap(document)
    for upto in (1, 3, 0, 4):
        document.replay_history(upto)
        assert len(document.strokes) == upto
        as_replayed(document)
    same(whole, snap(document))
    document.undo()
    assert len(document.strokes) == 5


def test_strokes_that_one_only_looked_behind_come_back_for_an_edit() -> None:
    document = sitting()
    whole = snap(document)
    document.replay_history(2)
    document.edit_strokes([3], {"do": "ink", "ink": "cinnabar"})
    assert [s.ink for s in document.strokes][2:4] == [{"indigo": 1.0}, {"cinnabar": 1.0}]
    assert len(document.strokes) == 5
    document.undo()
    same(whole, snap(document))
    document.undo()  # and one that was undone does not
    with pytest.raises(InputError, match="stroke 5 is undone; expected 1 to 4"):
        document.edit_strokes([4], {"do": "delete"})


def test_symmetry_mask_and_layers_are_as_they_were_when_it_was_painted(tmp_path) -> None:
    document = small_plane(3.0)
    document.set_symmetry(Symmetry((MirrorPlane((0, 0, 0), (0, 1, 0)),)))
    paint(document, (-12, 4), (12, 6), t0=1_000_000_000)
    document.set_symmetry(Symmetry())
    document.set_mask(Mask(AngleMask((0.0, 0.0, -1.0), 10.0)))
    paint(document, (-12, -12), (12, -12), t0=2_000_000_000)
    document.add_layer("二")
    document.set_mask(Mask())
    paint(document, (-12, 12), (12, 12), t0=3_000_000_000)
    document.set_locked(0)
    document.set_visible(1, False)
    document.save(tmp_path / "a.p3d")
    mask, layers = document.mask, document.layers
    for number in range(3):
        document.edit_strokes([number], {"do": "move", "along": (1.0, 0.0)})
        as_replayed(document)
        assert (document.mask, document.layers) == (mask, layers)
        assert document.modified
    for _ in range(3):
        document.undo()
    assert not document.modified


@pytest.mark.parametrize(
    ("command", "arguments"),
    [
        ("dry", ()),
        ("blot", ()),
        ("press_seal", ([[(-2, -2), (2, -2), (2, 2), (-2, 2)]], (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))),
        ("merge_layer", (1,)),
    ],
)
def test_what_a_locked_layer_refused_stays_undone_by_an_edit(command, arguments) -> None:
    document = sitting(2)
    document.add_layer("二")
    document.set_locked(0)
    paint(document, (-12, 12), (12, 12), t0=5_000_000_000)
    document.select_layer(0)
    with pytest.raises(LayerError, match="locked"):
        getattr(document, command)(*arguments)
    document.set_locked(0, False)
    document.select_layer(1)
    wet, layers = document.surface.wet_ink(), document.layers
    document.edit_strokes([2], {"do": "move", "along": (1.0, 0.0)})
    assert document.layers == layers
    assert document.surface.wet_ink() == pytest.approx(wet, rel=0.02)
    as_replayed(document)


def test_strokes_of_single_hairs_are_edited_and_the_ledger_closes() -> None:
    hairs = dataclasses.replace(load_brush("full"), bristles=BristleSpec(n_hairs=40))
    document = sitting(brush=hairs)
    before = snap(document)
    for edit in ({"do": "ink", "ink": "cinnabar"}, {"do": "brush", "brush": "feibai"}):
        document.edit_strokes([1], edit)
        accounts = document.painter.ledger()
        loaded = accounts.pop("loaded")
        assert sum(accounts.values()) == pytest.approx(loaded)
        assert document.painter.brush == hairs
        document.undo()
        same(before, snap(document))


def test_an_edit_that_is_stopped_or_fails_leaves_everything() -> None:
    document = sitting()
    before, score = snap(document), list(write_score(document.score))
    shares = []

    class Stopped(Exception): ...

    def stop(share: float) -> None:
        shares.append(share)
        if len(shares) > 5:
            raise Stopped

    document.progress = stop
    with pytest.raises(Stopped):
        document.edit_strokes([1], {"do": "brush", "brush": "feibai"})
    document.progress = None
    for edit, error in (
        ({"do": "ink", "ink": "sut"}, Paint3DError),
        ({"do": "brush", "brush": "borad"}, RecordingError),
        ({"do": "move", "along": (900.0, 0.0)}, RecordingError),
        ({"do": "colour"}, InputError),
    ):
        with pytest.raises(error):
            document.edit_strokes([1], edit)
    same(before, snap(document))
    assert list(write_score(document.score)) == score
    assert shares == sorted(shares)
    assert document.edit_strokes([1], {"do": "delete"}).size


def test_a_journal_does_an_edit_again() -> None:
    documents = [sitting(), sitting()]
    edit = {"do": "ink", "ink": {OWN: 1.0, "cinnabar": 2.0}}
    name, given, options = decode_command(
        encode_command(documents[0], "edit_strokes", ([2], edit), {}), documents[1].surface
    )
    documents[0].edit_strokes([2], edit)
    getattr(documents[1], name)(*given, **options)
    same(snap(documents[0]), snap(documents[1]))


def test_a_journal_of_before_edits_of_several_is_done_again() -> None:
    documents = [sitting(), sitting()]
    documents[0].edit_strokes([2], {"do": "delete"})
    replay_command(documents[1], {"do": "edit_stroke", "number": 2, "edit": {"do": "delete"}})
    same(snap(documents[0]), snap(documents[1]))


@pytest.mark.parametrize(
    ("strokes", "seal"), [("numbers", "number"), ("places", "place"), ("indices", "index")]
)
def test_a_journal_that_called_indices_otherwise_is_done_again(strokes: str, seal: str) -> None:
    surface = small_plane().surface
    edit = {"do": "delete"}
    line = {"do": "edit_strokes", strokes: [2], "edit": edit}
    assert decode_command(line, surface)[2] == {"indices": [2], "edit": edit}
    line = {"do": "edit_seal", seal: 1, "edit": edit}
    assert decode_command(line, surface)[2] == {"index": 1, "edit": edit}


def test_a_painting_that_was_saved_is_edited_on(tmp_path) -> None:
    document = sitting()
    document.edit_strokes([3], {"do": "delete"})
    document.save(tmp_path / "a.p3d")
    opened = Document.open(tmp_path / "a.p3d")
    opened.edit_strokes([0], {"do": "move", "along": (0.0, 2.0)})
    as_replayed(opened)
    opened.undo()
    same(snap(document), snap(opened))


def test_strokes_of_which_the_score_is_not_known_are_not_edited() -> None:
    document = sitting(2)
    document.recorder = None
    with pytest.raises(InputError, match="only the strokes of this painting are known"):
        document.edit_strokes([0], {"do": "delete"})
