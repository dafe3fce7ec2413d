"""Undo, redo and the history of strokes after a painting was saved and opened."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.app.model.document import Document
from paint3d.app.model.symmetry import MirrorPlane, Symmetry
from tests.app.hands import paint, small_plane

ACTIONS = st.sampled_from(
    ["stroke", "stroke", "stroke", "undo", "undo", "redo", "dry", "time", "dip", "tip", "wipe",
     "hairs", "mirror", "add", "remove", "move", "select"]
)  # fmt: skip
COMMANDS = st.lists(st.tuples(ACTIONS, st.integers(0, 2), st.floats(-20, 20)), max_size=7)


def act(document, action, place, y):
    """Do something that can be done; the same for the same document."""
    place = min(place, len(document.layers) - 1)
    if action == "stroke":
        paint(document, (-15, y), (15, -y), n=8)
    elif action == "dip":
        document.swap_inks()
    elif action == "tip":
        document.dip({"gamboge": 0.25, "water": 0.75}, 0.4)
    elif action == "hairs":
        document.set_brush("feibai" if document.painter.hairs is None else "full")
    elif action == "mirror":
        document.set_symmetry(Symmetry((MirrorPlane((0, 0, 0), (0, 1, 0)),)))
    elif action == "time":
        document.let_time_pass(0.3)
    elif action == "add":
        document.add_layer(place=place)
    elif action == "select":
        document.select_layer(place)
    elif action in ("undo", "redo", "dry", "wipe"):
        getattr(document, action)()
    elif len(document.layers) > 1 and action == "remove":
        document.remove_layer(place)
    elif len(document.layers) > 1:
        document.move_layer(place, 0)


def everything(document):
    """All that may differ between two paintings of the same strokes."""
    surface, painter = document.surface, document.painter
    ink, dry, flow = surface.ink, surface.dry_layers, surface.keep_flow()
    order = np.argsort(dry.vertex_ids)
    n = surface.n_vertices
    depth = np.zeros(n)
    if flow is not None:
        depth[flow["vertices"]] = flow["water"]
    hairs = np.empty(0) if painter.hairs is None else painter.hairs.keep()["load"]
    return {
        "codes": surface.srgb.copy(), "amounts": surface.amounts.copy(),
        "coverage": surface.coverage.copy(), "dried": dry.vertex_ids[order],
        "spectra": dry.spectra[order], "share": dry.share[order], "water": depth,
        "load": ink.load.copy(), "off": ink.off_surface.copy(), "stations": ink.stations.copy(),
        "habit": ink.habit.copy(), "hairs": hairs,
        "layers": np.array([layer.name for layer in document.layers]),
        "active": np.array(document.active_layer), "brush": np.array(painter.brush.name),
        "steps": np.array([len(document.steps.done), len(document.steps.undone)]),
        "strokes": np.array([[s.dipped, len(s.samples), s.duration_s] for s in document.strokes]),
    }  # fmt: skip


def same(one, two):
    now, then = everything(one), everything(two)
    for name in then:
        np.testing.assert_array_equal(now[name], then[name], err_msg=name)
    assert one.painter.ledger() == pytest.approx(two.painter.ledger(), rel=1e-6, abs=1e-3)


def reopened(document, path):
    document.save(path)
    again = Document.open(path)
    assert again.refused_history == ""
    return again


@settings(deadline=None, max_examples=10)
@given(before=COMMANDS, after=COMMANDS)
def test_saving_and_opening_changes_nothing_of_what_comes(tmp_path_factory, before, after):
    document = small_plane(2.0, material="xuan")
    document.painter.surface.ink.habit[0] = 0.03  # it picks wet ink up
    for ink in ("gamboge", "water", "cinnabar"):
        document.dip(ink)
    for action in before:
        act(document, *action)
    symmetry = document.symmetry
    again = reopened(document, tmp_path_factory.mktemp("saved") / "a.p3d")
    again.set_symmetry(symmetry)  # no part of a painting
    same(again, document)
    for action in after:
        for one in (document, again):
            act(one, *action)
        same(again, document)
    for way in ("undo", "redo", "undo"):
        while getattr(document, f"can_{way}"):
            for one in (document, again):
                getattr(one, way)()
            same(again, document)
        assert not getattr(again, f"can_{way}")


def test_saving_again_gives_the_same_file(tmp_path):
    document = small_plane(material="xuan")
    paint(document, (-20, 0), (20, 0))
    document.set_brush("feibai")
    document.let_time_pass(0.3)
    paint(document, (0, -20), (0, 20))
    paint(document, (9, -20), (9, 20))
    document.add_layer()
    document.undo()
    document.undo()
    document.save(tmp_path / "a.p3d")
    for name in ("b.p3d", "c.p3d"):
        document.save(tmp_path / name)
        assert (tmp_path / name).read_bytes() == (tmp_path / "a.p3d").read_bytes()
        document = Document.open(tmp_path / "a.p3d")
