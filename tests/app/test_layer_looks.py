"""Opacity, blends, copies and merging of layers, undone, saved and recovered."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.app.model.document import Document
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, recoverable
from paint3d.app.model.score.playing import painted
from paint3d.errors import LayerError, Paint3DError
from tests.app.test_layers import ACROSS, ALONG, close, differences, paint, shown, small_plane

MOST_OFF = 2.0  # CIEDE2000, by which three points stand for what layers show over any ground


@pytest.fixture
def document() -> Document:
    """A cinnabar stroke, and one of soot across it on a layer of its own."""
    document = small_plane()
    document.dip("cinnabar")
    paint(document, *ACROSS)
    document.add_layer()
    document.dip("pine soot")
    paint(document, *ALONG)
    return document


def test_opacity_mixes_what_shows_with_and_without_the_layer(document) -> None:
    full = shown(document).astype(float)
    document.set_opacity(1, 0.0)
    without = shown(document).astype(float)
    document.set_opacity(1, 0.4)
    partly = shown(document).astype(float)
    darker = full.sum(axis=1) < without.sum(axis=1) - 30.0
    assert darker.any()
    assert (partly[darker].sum(axis=1) > full[darker].sum(axis=1)).all()
    assert (partly[darker].sum(axis=1) < without[darker].sum(axis=1)).all()
    np.testing.assert_array_equal(partly[full.sum(1) == without.sum(1)],
                                  without[full.sum(1) == without.sum(1)])  # fmt: skip
    for _ in range(2):
        document.undo()
    np.testing.assert_array_equal(shown(document), full.astype(np.uint8))
    document.redo()
    np.testing.assert_array_equal(shown(document), without.astype(np.uint8))


def test_a_layer_that_multiplies_lets_opaque_paint_glaze() -> None:
    document = small_plane()
    document.dip("pine soot")
    paint(document, *ACROSS)
    document.add_layer()
    document.dip("cinnabar")
    paint(document, *ALONG)
    above = shown(document).astype(float)
    document.set_blend(1, "multiply")
    glazed = shown(document).astype(float)
    assert (glazed <= above + 1.0).all()
    assert (glazed.sum(axis=1) < above.sum(axis=1) - 3.0).any()
    document.undo()
    np.testing.assert_array_equal(shown(document), above.astype(np.uint8))


def test_a_copy_is_painted_on_by_itself(document) -> None:
    before = document.painter.ledger()
    document.duplicate_layer(1)
    assert [layer.name for layer in document.layers] == ["1", "2", "3"]
    assert document.active_layer == 2
    close(document)
    document.set_visible(1, False)
    document.set_visible(2, False)
    bare = shown(document)
    document.set_visible(2)
    assert differences(shown(document), bare).max() > 5.0
    document.undo()
    assert [layer.name for layer in document.layers] == ["1", "2"]
    assert document.painter.ledger() == before


@pytest.mark.parametrize("look", [(1.0, "normal"), (0.5, "normal"), (0.7, "multiply")])
def test_merging_leaves_what_shows_and_the_ink_and_is_undone_to_the_bit(document, look) -> None:
    opacity, blend = look
    if opacity < 1.0:
        document.set_opacity(1, opacity)
    if blend != "normal":
        document.set_blend(1, blend)
    seen, ledger = shown(document), document.painter.ledger()
    document.merge_layer(1)
    assert [layer.name for layer in document.layers] == ["1"]
    assert document.layers[0].is_plain
    assert differences(shown(document), seen).max() <= MOST_OFF
    close(document)
    merged = shown(document)
    document.undo()
    np.testing.assert_array_equal(shown(document), seen)
    assert document.painter.ledger() == ledger
    document.redo()
    np.testing.assert_array_equal(shown(document), merged)
    paint(document, (-10.0, 5.0), (10.0, 5.0))  # it is a layer like others
    document.undo()
    np.testing.assert_array_equal(shown(document)[: len(merged)], merged)


def test_what_cannot_be_done_is_told_and_leaves_no_step(document) -> None:
    n = len(document.steps.done)
    for refused in (
        lambda: document.merge_layer(0),
        lambda: document.merge_layer(5),
        lambda: document.set_opacity(0, 1.5),
        lambda: document.set_opacity(4, 0.5),
        lambda: document.set_blend(0, "screen"),
        lambda: document.duplicate_layer(7),
    ):
        with pytest.raises(Paint3DError):
            refused()
        assert len(document.steps.done) == n
    document.set_locked(0)
    with pytest.raises(LayerError):
        document.merge_layer(1)
    assert len(document.layers) == 2


def test_files_scores_and_recovery_bring_looks_back(document, tmp_path) -> None:
    document.set_opacity(1, 0.3)
    document.set_blend(0, "multiply")
    document.duplicate_layer(1)
    document.merge_layer(2)
    seen, layers = shown(document), document.layers
    document.save(tmp_path / "one.p3d")
    again = Document.open(tmp_path / "one.p3d")
    assert again.layers == layers
    np.testing.assert_array_equal(shown(again), seen)
    for _ in range(4):
        document.undo()
        again.undo()
        assert again.layers == document.layers
        np.testing.assert_array_equal(shown(again), shown(document))
    for _ in range(4):
        document.redo()
        again.redo()
    np.testing.assert_array_equal(shown(again), seen)
    played = painted(document.score, document.surface.source)
    assert played.layers == layers
    np.testing.assert_array_equal(shown(played), seen)


def test_looks_come_back_after_a_crash(tmp_path) -> None:
    document = Document.new("plane", 4.0, "xuan")
    folder = RecoveryFolder(document, tmp_path)
    paint_thread = PaintThread(document, recovery=folder)
    paint_thread.post("duplicate_layer", 0).result(300)
    paint_thread.post("set_opacity", 1, 0.25).result(300)
    paint_thread.post("set_blend", 1, "multiply").result(300)
    paint_thread.stop(keep=True)
    recovered = recoverable(tmp_path)[0].recover().document
    assert recovered.layers == document.layers
    assert (recovered.layers[1].opacity, recovered.layers[1].blend) == (0.25, "multiply")
