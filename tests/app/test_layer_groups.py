"""Groups of layers: made, moved in and out, shown, undone, saved, recovered and played again."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.app.model.document import Document
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, recoverable
from paint3d.app.model.score.playing import painted
from paint3d.errors import LayerError, Paint3DError
from tests.app.test_layers import ACROSS, ALONG, paint, shown, small_plane


@pytest.fixture
def document() -> Document:
    """Three layers: cinnabar, soot across it, and azurite along it."""
    document = small_plane()
    document.dip("cinnabar")
    paint(document, *ACROSS)
    document.add_layer()
    document.dip("pine soot")
    paint(document, *ALONG)
    document.add_layer()
    document.dip("azurite")
    paint(document, (-12.0, 6.0), (12.0, -6.0))
    return document


def groups(document: Document) -> list[str]:
    """The name of each layer's group, the lowest first."""
    return ["" if one.group is None else one.group.name for one in document.layers]


def test_a_normal_group_passes_through(document) -> None:
    seen = shown(document)
    document.add_group(1, 2, "branch")
    assert groups(document) == ["", "branch", "branch"]
    np.testing.assert_array_equal(shown(document), seen)
    document.set_blend(2, "multiply")  # on what is below the group, too
    multiplied = shown(document)
    document.ungroup(1)
    np.testing.assert_array_equal(shown(document), multiplied)


def test_opacity_of_a_group_mixes_what_shows_with_and_without_all_of_it(document) -> None:
    document.add_group(1, 2)
    full = shown(document).astype(float)
    document.set_group_visible(1, False)
    without = shown(document).astype(float)
    document.set_visible(1, False)
    document.set_visible(2, False)
    document.set_group_visible(2, True)
    np.testing.assert_array_equal(shown(document), without)
    document.set_visible(1)
    document.set_visible(2)
    document.set_group_opacity(2, 0.0)
    np.testing.assert_array_equal(shown(document), without)
    document.set_group_opacity(2, 0.5)
    half = shown(document).astype(float)
    apart = np.abs(full - without).sum(axis=1) > 60
    assert apart.any()
    assert (np.abs(half - without).sum(axis=1)[apart] > 5).all()
    assert (np.abs(half - full).sum(axis=1)[apart] > 5).all()
    document.set_opacity(1, 0.5)
    document.set_opacity(2, 0.5)
    document.set_group_opacity(2, 1.0)  # not the same as half of each layer
    assert np.abs(shown(document).astype(float) - half).max() > 5


def test_edges_are_drawn_by_what_shows_of_a_group(document) -> None:
    document.add_group(1, 2)
    document.set_visible(0, False)
    ids = np.arange(document.surface.n_vertices, dtype=np.int32)
    whole = document.surface.layers.coverage_at(ids)
    assert whole.max() > 0.9
    document.set_group_opacity(1, 0.25)
    np.testing.assert_allclose(document.surface.layers.coverage_at(ids), 0.25 * whole, rtol=1e-6)


def test_a_group_that_multiplies_darkens(document) -> None:
    document.add_group(1, 2)
    normal = shown(document).astype(float)
    document.set_group_blend(1, "multiply")
    assert (shown(document) <= normal + 3.0).all()  # red, which azurite takes as soot does
    assert (shown(document) < normal - 3.0).any()
    document.undo()
    np.testing.assert_array_equal(shown(document), normal)


def test_layers_move_in_and_out_and_new_ones_come_where_one_paints(document) -> None:
    document.add_group(1, 2, "a")
    document.move_layer(0, 0, within=1)
    assert groups(document) == ["a", "a", "a"]
    document.move_layer(2, 2, within=-1)
    assert groups(document) == ["a", "a", ""]
    document.move_layer(2, 1)  # between two of a group
    assert groups(document) == ["a", "a", "a"]
    document.select_layer(1)
    document.add_layer()
    document.duplicate_layer(2)
    assert groups(document) == ["a"] * 5
    document.move_layer(4, 4, within=-1)
    document.add_group(4, name="b")
    document.move_group(4, 0)
    assert groups(document) == ["b", "a", "a", "a", "a"]
    document.move_layer(1, 0)  # beyond another group: out of its own
    assert groups(document) == ["", "b", "a", "a", "a"]
    for _ in range(10):
        document.undo()
    assert groups(document) == ["", "", ""]
    for _ in range(10):
        document.redo()
    assert groups(document) == ["", "b", "a", "a", "a"]


def test_a_copy_of_a_group_shows_its_paint_and_comes_apart(document) -> None:
    document.add_group(0, 1, "a")
    document.set_group_opacity(0, 0.5)
    document.duplicate_group(0)
    assert groups(document) == ["a", "a", "1", "1", ""]
    assert [one.name for one in document.layers] == ["1", "2", "1", "2", "3"]
    assert document.active_layer == 3
    assert document.layers[2].group.opacity == 0.5
    document.set_group_visible(0, False)
    document.set_group_opacity(2, 1.0)
    copied = shown(document)
    document.remove_group(2)
    document.set_group_visible(0, True)
    document.set_group_opacity(0, 1.0)
    np.testing.assert_array_equal(shown(document), copied)
    for _ in range(4):
        document.undo()
    assert groups(document) == ["a", "a", ""]


def test_what_cannot_be_done_is_told_and_changes_nothing(document) -> None:
    document.add_group(1, 2, "a")
    document.add_layer(place=0)
    before, n = document.layers, len(document.steps.done)
    for refused in (
        lambda: document.ungroup(0),
        lambda: document.add_group(7),
        lambda: document.add_group(2, 1),
        lambda: document.add_group(0, name=" "),
        lambda: document.move_layer(0, 3, within=7),
        lambda: document.move_layer(0, 0, within=2),
        lambda: document.move_layer(2, 0, within=3),
        lambda: document.move_group(2, 3),
        lambda: document.move_group(0, 1),
        lambda: document.duplicate_group(1),
        lambda: document.set_group_opacity(2, 1.5),
        lambda: document.set_group_opacity(0, 0.5),
        lambda: document.set_group_blend(2, "screen"),
        lambda: document.merge_layer(2),
    ):
        with pytest.raises(Paint3DError):
            refused()
        assert (document.layers, len(document.steps.done)) == (before, n)
    document.add_group(0, 3, "all")  # takes them over from "a"
    with pytest.raises(Paint3DError):
        document.remove_group(0)
    document.set_group_visible(0, False)
    with pytest.raises(LayerError, match="group"):
        document.begin_stroke()


def test_files_scores_and_their_steps_bring_groups_back(document, tmp_path) -> None:
    document.add_group(1, 2, "branch")
    document.set_group_opacity(1, 0.4)
    document.ungroup(1)
    document.add_group(0, 1, "other")
    document.set_group_folded(0)
    document.duplicate_group(0, "copy")
    document.rename_group(0, "first")
    seen, layers = shown(document), document.layers
    document.save(tmp_path / "one.p3d")
    again = Document.open(tmp_path / "one.p3d")
    assert again.layers == layers
    np.testing.assert_array_equal(shown(again), seen)
    again.add_group(4)
    assert len({one.group.key for one in again.layers}) == 3
    again.undo()
    for _ in range(5):
        document.undo()
        again.undo()
        assert again.layers == document.layers
        np.testing.assert_array_equal(shown(again), shown(document))
    for _ in range(5):
        document.redo()
        again.redo()
    np.testing.assert_array_equal(shown(again), seen)
    played = painted(document.score, document.surface.source)
    assert played.layers == layers
    np.testing.assert_array_equal(shown(played), seen)


def test_groups_come_back_after_a_crash(tmp_path) -> None:
    document = Document.new("plane", 4.0, "xuan")
    folder = RecoveryFolder(document, tmp_path)
    paint_thread = PaintThread(document, recovery=folder)
    for asked in (("add_layer",), ("add_group", 0, 1, "g"), ("set_group_opacity", 1, 0.25),
                  ("set_group_folded", 0), ("duplicate_group", 0)):  # fmt: skip
        paint_thread.post(*asked).result(300)
    paint_thread.stop(keep=True)
    recovered = recoverable(tmp_path)[0].recover().document
    assert recovered.layers == document.layers
    assert recovered.layers[3].group.opacity == 0.25


def test_a_file_without_groups_is_as_it_was(document, tmp_path) -> None:
    document.save(tmp_path / "old.p3d")
    assert b'"group' not in (tmp_path / "old.p3d").read_bytes()
    again = Document.open(tmp_path / "old.p3d")
    again.add_group(0, 2)
    again.undo()
    again.undo()
    assert groups(again) == ["", "", ""]
    assert again.layers == document.layers
