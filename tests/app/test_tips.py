"""A tip in another ink than the belly: what commands save goes on with the same in the studio."""

from __future__ import annotations

import dataclasses
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from paint3d.app.model.document import Document
from paint3d.app.model.repainting import Repainter
from paint3d.app.model.stroke_log import weights_of
from paint3d.cli.main import main
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import load_session, save_session
from paint3d.painter.painter import Painter
from paint3d.recording.recording import save_recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.hands import pad_stroke, paint, small_plane


def held(surface: PaintedSurface) -> dict[str, np.ndarray]:
    """Ink along the tuft, by its name."""
    stations = surface.ink.reservoirs
    return {p.name: stations[:, k] for k, p in enumerate(surface.pigments) if stations[:, k].any()}


@pytest.mark.parametrize("how", ["options", "header"])
def test_a_session_by_command_dips_belly_and_tip_again(tmp_path, how) -> None:
    file, out = tmp_path / "a.jsonl", tmp_path / "a.p3d"
    words = ["--ink", "water", "--tip", "indigo", "--reach", "0.4"]
    way = np.column_stack([np.linspace(-8.0, 8.0, 20), np.zeros(20)])
    stroke = pad_stroke(way, 0.4, 1.2)
    if how == "header":
        own = {"ink": "water", "tip": "indigo", "reach": 0.4}
        stroke, words = replace(stroke, header={**stroke.header, **own}), []
    save_recording(stroke, file)
    on = ["--on", "plane", "--resolution", "2.5", "--quiet", "--out", str(out)]
    assert main(["replay", str(file), *on, *words]) == 0
    document = Document.open(out)
    assert [(weights_of(ink), reach) for ink, reach in document.painter.dips] == [
        ({"water": 1.0}, None), ({"indigo": 1.0}, 0.4)
    ]  # fmt: skip
    document.dip()
    fresh = PaintedSurface(load_mesh("plane"), 2.5)
    painter = Painter(fresh, document.painter.brush, "water")
    painter.dip("indigo", 0.4)
    ours, its = held(document.surface), held(fresh)
    assert ours.keys() == its.keys() == {"water", "indigo"}
    for name, along in its.items():
        np.testing.assert_array_equal(ours[name], along)
    document.save(tmp_path / "b.p3d")
    again = Document.open(tmp_path / "b.p3d").painter
    assert [reach for _, reach in again.dips] == [None, 0.4]


@pytest.mark.parametrize("fails", [False, True])
@pytest.mark.parametrize("brush", ["full", "slender"])
def test_a_tip_in_hand_is_there_still_when_old_strokes_were_painted_again(
    tmp_path, monkeypatch, brush, fails
) -> None:
    """With the brush of the old strokes, too, and with another, which is dipped for it anew."""
    document = small_plane(2.5)
    paint(document, (-15, 0), (15, 0))
    document.save(tmp_path / "a.p3d")
    session = load_session(tmp_path / "a.p3d")
    save_session(dataclasses.replace(session, undone=(), history=None), tmp_path / "a.p3d")
    document = Document.open(tmp_path / "a.p3d")
    assert document.oldest_stroke == 1
    document.set_brush(brush)
    document.dip("water")
    document.dip("indigo", 0.4)
    before, full = document.painter.dips, held(document.surface)
    full = {name: along.copy() for name, along in full.items()}
    if fails:

        def fail(_: object) -> None:
            raise InputError("no")

        monkeypatch.setattr(Repainter, "repeat", lambda self, strokes: fail(strokes))
    with pytest.raises(InputError) if fails else nullcontext():
        document.recall_strokes()
    ours = held(document.surface)
    assert ours.keys() == full.keys() == {"water", "indigo"}
    for name, along in full.items():
        np.testing.assert_allclose(ours[name], along, rtol=1e-9)
    assert [(weights_of(ink), reach) for ink, reach in document.painter.dips] == [
        (weights_of(ink), reach) for ink, reach in before
    ]
