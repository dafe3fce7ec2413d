from __future__ import annotations

import pytest

from paint3d.errors import SessionError
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import UndoHistory
from paint3d.surface.undo_state import restore_undo, undo_state
from scripts.solids import make_plane


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
