"""Pieces that a hand did in the real window, from an empty one to what is saved, played again.

The recordings are `pieces/*.jsonl`: mouse, keys and a pen, by what they were for (`README.md`).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import trimesh

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.window.studio import StudioWindow
from paint3d.core.arrays import AnyArray
from tests.support.app.controls import CANVAS, find_control
from tests.support.app.event_player import EventRecording
from tests.support.app.hands import same_vertices
from tests.support.app.window_player import WindowPlayer
from tests.support.app.windows import close_unasked

PIECES = Path(__file__).parent / "pieces"


@pytest.fixture(autouse=True, scope="module")
def mouse_as_it_is() -> None:
    """A mouse is steadied as users have it."""


@pytest.fixture
def window(program, wet_at_first, tmp_path: Path, monkeypatch) -> Iterator[StudioWindow]:
    """An empty window of somebody who has never used it, in a folder of their own."""
    monkeypatch.chdir(tmp_path)
    QtWidgets.QFileDialog(None, "", str(tmp_path)).deleteLater()  # dialogs begin in the last one's
    window = StudioWindow(program)
    window.show()
    window.recent.show()
    yield window
    close_unasked(window)


def play(window: StudioWindow, name: str) -> Document:
    """Play a piece to its end."""
    WindowPlayer(window).play(EventRecording.load(PIECES / f"{name}.jsonl"))
    return window.document


def steps(document: Document) -> list[str]:
    """What undo takes back, one after the other."""
    return [step if isinstance(step, str) else "stroke" for step in document.steps.done]


def colours(document: Document) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Points (N, 3), mm, of what is painted, and which of them are black or red."""
    surface = document.surface
    n = len(surface.painted)
    places, srgb = surface.paint_mesh.vertices[:n], surface.srgb[:n].astype(int)
    return places, srgb.max(axis=1) < 110, srgb[:, 0] - srgb[:, 2] > 60


def aside_px(window: StudioWindow, name: str, strokes: int) -> float:
    """How far the last strokes lie from where the recorded pen went, in the view of now, pixels."""
    control = find_control(window, CANVAS, (0.5, 0.5))
    assert control is not None
    events = EventRecording.load(PIECES / f"{name}.jsonl").events
    places = [control.place(one.place) for one in events if one.device == "pen" and one.buttons]
    went = [window.canvas.mapFromGlobal(place).toTuple() for place in places]
    samples = [s for stroke in window.document.strokes[-strokes:] for s in stroke.samples]
    touched = np.array([sample.contact for sample in samples if sample.pressure > 0.0])
    seen = window.hand.pixels_of(touched)
    return float(np.linalg.norm(seen[:, None] - np.array(went), axis=2).min(axis=1).max())


def reopened(document: Document, path: Path) -> None:
    """Check that what was saved opens as it was left."""
    again = Document.open(path)
    same_vertices(again.surface, document.surface)
    assert steps(again) == steps(document)
    assert len(again.strokes) == len(document.strokes)
    assert len(again.pressed_seals()) == len(document.pressed_seals())
    assert [laid.text for laid in again.texts] == [laid.text for laid in document.texts]


@pytest.mark.long
def test_a_scroll_with_a_poem_is_signed_sealed_and_saved(window, tmp_path: Path) -> None:
    document = play(window, "scroll")
    poem, signature = document.texts
    assert poem.text.replace("\n", "") == "靜夜思床前明月光疑是地上霜舉頭望明月低頭思故鄉"
    assert signature.text == "山人書"
    assert steps(document) == ["text", "stroke", "text", "stroke", "seal", "dry"]
    places, black, red = colours(document)
    written, seal = places[black], places[red]
    assert np.ptp(written, axis=0)[:2] == pytest.approx([101.0, 294.0], rel=0.1)  # three columns
    assert (seal.mean(axis=0) < written.mean(axis=0))[:2].all()  # at the left, below
    assert np.ptp(seal, axis=0)[:2].max() < 12.0
    reopened(document, tmp_path / "scroll.p3d")


def test_a_fan_with_bamboo_in_wet_ink_by_a_leaning_pen_is_sealed_and_saved(
    window, tmp_path: Path
) -> None:
    document = play(window, "fan")
    assert document.surface.source.name.startswith("fan:300x100")
    assert [layer.name for layer in document.layers] == ["1", "2"]
    assert steps(document) == [*["stroke"] * 3, "add layer", *["stroke"] * 5, "seal", "dry"]
    assert document.surface.flow.water == 0.0
    for stroke in document.strokes:
        pressures = np.array([sample.pressure for sample in stroke.samples])
        quarter = len(pressures) // 4  # it comes down and goes up whatever the pen says
        assert np.ptp(pressures[quarter:-quarter]) > 0.02
    places, black, red = colours(document)
    culm, seal = places[black], places[red]
    assert culm[:, 0].max() < 20.0  # mm, of the fan's middle
    assert seal[:, 0].min() > 70.0
    np.testing.assert_allclose(np.ptp(seal, axis=0)[:2], 16.0, atol=1.5)
    reopened(document, tmp_path / "fan.p3d")


def make_cup(path: Path) -> None:
    """Write a cup of 76 x 80 mm, as from a program for solids."""
    wall = [(0, 0), (30, 0), (38, 80), (35, 80), (27.5, 4), (0, 4)]
    trimesh.creation.revolve(wall, sections=96).export(path)


def test_an_own_cup_has_a_name_around_and_a_branch_inside(window, tmp_path: Path) -> None:
    make_cup(tmp_path / "cup.stl")
    document = play(window, "cup")
    assert document.surface.source.name == "cup"
    assert [laid.text for laid in document.texts] == ["王小明"]
    assert steps(document) == ["text", *["stroke"] * 6]
    assert [stroke.brush.length_mm < 20.0 for stroke in document.strokes] == [False] + [True] * 5
    assert aside_px(window, "cup", 5) < 2.0
    places, black, _ = colours(document)
    ink, normals = places[black], document.surface.paint_mesh.normals[: len(black)][black]
    outside = (ink[:, :2] * normals[:, :2]).sum(axis=1) > 0.0
    turns = np.degrees(np.arctan2(*ink[outside, 1::-1].T))
    counts, _ = np.histogram(turns, bins=np.linspace(-180.0, 180.0, 13))
    assert np.count_nonzero(counts > 20) >= 3, "three characters all around"
    assert np.ptp(turns) > 200.0
    assert np.count_nonzero(~outside) > 100
    assert ink[~outside, 2].min() > 40.0, "the branch is high inside"
    reopened(document, tmp_path / "cup.p3d")
