"""The painted surface: what it takes, what it keeps while it grows, what it hands out."""

from __future__ import annotations

import numpy as np
import pytest

import paint3d
from paint3d.colour.pigments import load_pigment
from paint3d.errors import InputError, SessionError, UnknownNameError
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import UndoHistory
from paint3d.surface.undo_state import restore_undo, undo_state
from scripts.solids import make_plane


@pytest.mark.parametrize("name", ["plane", "sphere"])
def test_an_unpainted_object_comes_out_as_it_went_in(name):
    mesh = paint3d.load_mesh(name)
    surface = paint3d.PaintedSurface(mesh, resolution=1.0)
    surface.refine_all()
    assert surface.n_vertices > 2 * mesh.n_vertices
    vertices, faces, normals, srgb = surface.export_arrays()
    np.testing.assert_array_equal(vertices, mesh.vertices)
    np.testing.assert_array_equal(faces, mesh.faces)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)
    assert (srgb == srgb[0]).all()


def test_growing_keeps_ink_and_colours():
    surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=2.0)
    surface.column_of(load_pigment("pine soot"))
    surface.ink.amounts[5, 0] = 1.0
    surface.ink.coverage[5] = 1.0
    surface.ink.dirty[5] = 1
    surface.ink.dirty_ids[0] = 5
    surface.ink.n_dirty[0] = 1
    capacity = surface.paint_mesh.capacity
    surface.make_room(100_000)
    assert surface.paint_mesh.capacity > capacity
    assert surface.ink.amounts[5, 0] == 1.0
    before = surface.srgb.copy()
    assert before[5].max() < 90 < before[4].min()
    surface.make_room(200_000)
    np.testing.assert_array_equal(surface.srgb, before)


def test_a_second_pigment_keeps_the_first():
    surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=2.0)
    assert surface.column_of(load_pigment("pine soot")) == 0
    surface.ink.amounts[3, 0] = 0.5
    assert surface.column_of(load_pigment("cinnabar")) == 1
    assert surface.column_of(load_pigment("pine soot")) == 0
    assert surface.amounts.shape == (surface.n_vertices, 2)
    assert surface.amounts[3].tolist() == [0.5, 0.0]


def test_what_is_painted_is_coloured_anew_once_another_pigment_has_come():
    """Single vertices of the window were one code off those of the file that it saved."""
    surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=1.0)
    surface.refine_all()
    surface.column_of(load_pigment("pine soot"))
    ids = np.arange(surface.n_vertices, dtype=np.int32)
    surface.ink.amounts[ids, 0] = np.linspace(0.0, 1.2, len(ids))
    surface.ink.coverage[ids[1:]] = np.linspace(0.05, 1.0, len(ids) - 1)
    surface.touch(ids)
    alone = surface.srgb.copy()
    assert len(surface.take_changed())
    assert not len(surface.take_changed())
    assert not len(surface.refresh())
    surface.column_of(load_pigment("cinnabar"))
    np.testing.assert_array_equal(surface.refresh(), ids[1:])
    np.testing.assert_array_equal(surface.take_changed(), ids[1:])
    kept = surface.srgb.copy()
    surface.colour_as_one(ids)
    np.testing.assert_array_equal(kept, surface.srgb)
    assert (kept != alone).any()
    assert not len(surface.refresh())


@pytest.mark.parametrize("resolution", [0.0, -1.0, float("nan"), float("inf"), "fine"])
def test_a_resolution_must_be_a_length(resolution):
    with pytest.raises(InputError, match="resolution"):
        paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=resolution)


def test_an_unknown_material_is_named():
    with pytest.raises(UnknownNameError, match="porcelain"):
        paint3d.PaintedSurface(paint3d.load_mesh("plane"), material="procelain")


def test_only_meshes_can_be_painted():
    with pytest.raises(InputError, match=r"expected \(vertices, faces\)"):
        paint3d.PaintedSurface("bowl")


# -- undo --------------------------------------------------------------------------------------


def layered() -> PaintedSurface:
    surface = PaintedSurface(make_plane(), resolution=None)
    surface.use_layers()
    return surface


def test_steps_are_not_read_onto_a_surface_without_layers() -> None:
    surface = layered()
    history = UndoHistory(surface)
    history.begin("step")
    history.change(surface.use_layers().state, lambda: surface.use_layers().add("above", 1))
    saved = undo_state(surface, history, 1 << 20)
    bare = PaintedSurface(make_plane(), resolution=None)
    with pytest.raises(SessionError, match="no layers; expected those that the steps were made on"):
        restore_undo(bare, UndoHistory(bare), saved.state, saved.done, saved.undone, saved.kept)
