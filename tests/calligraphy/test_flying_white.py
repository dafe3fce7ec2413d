"""Dryness that strokes tell, as the load of the brush that paints them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from paint3d.brush.presets import load_brush
from paint3d.calligraphy.flying_white import loads_for, with_dryness, with_loads
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.page.page import Page, Piece
from paint3d.calligraphy.page.strokes_file import load_strokes, save_strokes
from paint3d.calligraphy.writing import WritingSettings, Written, write_page
from paint3d.colour.materials import load_material
from paint3d.device.recorded import Recording
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.painter.recorded_tools import recorded_amount
from paint3d.recording.recording import load_recording, save_recording
from paint3d.surface.painted_surface import PaintedSurface

BAR = np.array([[100.0, 340.0], [900.0, 340.0], [900.0, 440.0], [100.0, 440.0]])
WAY = np.array([[150.0, 390.0], [850.0, 390.0]])


def bar(dryness: tuple[float, ...]) -> Page:
    glyph = Glyph("bar", (GlyphStroke(BAR, WAY, (), dryness),))
    return Page((Piece(glyph, glyph.middle),), "bar", "")


def written(dryness: tuple[float, ...]) -> Written:
    return write_page(
        load_mesh("plane"), bar(dryness), WritingSettings(load_brush("zhongbaiyun"), 40.0)
    )


def bare_shares(dryness: tuple[float, ...], material: str = "xuan") -> list[float]:
    """Share left bare in the quarters of a bar, within its middle."""
    one = written(dryness)
    surface = PaintedSurface(load_mesh("plane"), 0.25, material=material)
    recording = with_dryness(one.recording, one.dryness, load_material(material))
    amount = recorded_amount(recording.header)
    Painter(surface, "zhongbaiyun", amount=amount).replay(recording)
    frame = one.placed[0].square.chart.frame
    n = len(surface.coverage)
    places = surface.paint_mesh.vertices[:n] - frame.origin
    x, y = places @ frame.x_axis, places @ frame.y_axis
    inside = (np.abs(x) < 13.0) & (np.abs(y) < 1.2)
    quarter = np.floor((x[inside] + 13.0) / 6.5).astype(int)
    bare = surface.coverage[inside] < 0.5
    return [float(bare[quarter == k].mean()) for k in range(4)]


def test_a_stroke_is_as_dry_as_was_asked_for_where_it_was():
    found = bare_shares((0.0, 0.0, 0.0, 0.2, 0.4, 0.6, 0.8, 0.8))
    assert found[0] < 0.05
    assert found[1] < 0.2
    assert 0.2 < found[2] < 0.85  # bundles of hairs that are supplied worse: see trials of copies
    assert found[3] > 0.5
    assert all(after > before - 0.02 for before, after in pairwise(found))


def test_a_glaze_has_no_grain_to_leave_bare():
    one = written((0.8,) * 8)
    recording = with_dryness(one.recording, one.dryness, load_material("porcelain"))
    assert recording is one.recording


def test_strokes_that_say_nothing_are_written_as_before():
    assert written(()).dryness is None


def test_loads_fall_with_dryness_and_with_pressure():
    loads = loads_for(np.array([0.0, 0.2, 0.5, 0.9, np.nan]), np.full(5, 0.3), 0.5)
    assert (np.diff(loads[:4]) < 0.0).all()
    assert np.isnan(loads[4])
    light, pressed = loads_for(np.array([0.5, 0.5]), np.array([0.1, 0.9]), 0.5)
    assert pressed < light


def resting(n: int) -> Recording:
    """Samples of a brush that is pressed and not moved, 4 ms apart."""
    return Recording(
        4_000_000 * np.arange(n, dtype=np.int64),
        np.zeros((n, 3)),
        np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)),
        np.full(n, 0.3),
        np.zeros(n, np.int32),
        header={},
    )


def test_what_is_told_is_little_and_survives_a_file(tmp_path: Path):
    n = 4000
    loads = np.where(np.arange(n) % 2 == 0, 0.1, 0.4)  # more changes than a header has room for
    told = with_loads(resting(n), loads)
    assert 0 < len(told.header["loads"]) <= 1500
    save_recording(told, tmp_path / "a.jsonl")
    assert load_recording(tmp_path / "a.jsonl").header["loads"] == told.header["loads"]


def test_a_recording_paints_what_its_plan_painted(tmp_path: Path):
    one = written((0.0, 0.3, 0.6, 0.8))
    recording = with_dryness(one.recording, one.dryness, load_material("xuan"))
    save_recording(recording, tmp_path / "a.jsonl.gz")
    painted = []
    for way in (recording, load_recording(tmp_path / "a.jsonl.gz")):
        surface = PaintedSurface(load_mesh("plane"), 0.5, material="xuan")
        Painter(surface, "zhongbaiyun", amount=recorded_amount(way.header)).replay(way)
        painted.append(surface.amounts.copy())
    assert np.array_equal(*painted)


def test_dryness_of_a_strokes_file_is_painted(tmp_path: Path):
    file = tmp_path / "bar.strokes.json"
    save_strokes(bar((0.0, 0.5, 1.0)), file)
    page = load_strokes(file)
    again = write_page(load_mesh("plane"), page, WritingSettings(load_brush("zhongbaiyun"), 40.0))
    assert again.dryness is not None
    known = again.dryness[np.isfinite(again.dryness)]
    assert known.min() < 0.1
    assert known.max() > 0.8
    dull = replace(page.pieces[0].glyph.strokes[0], dryness=())
    assert dull.dryness == ()


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_whatever_is_asked_for_is_a_load(share: float):
    loads = loads_for(np.array([share]), np.array([1.0]), 1.0)
    assert 0.0 < loads[0] <= 1.0


def test_more_dry_strokes_than_a_header_has_room_for_are_refused():
    n = 2 * 1501
    loads = np.where(np.arange(n) % 2 == 0, 0.2, np.nan)  # every other sample a stroke of its own
    with pytest.raises(InputError, match=r"1501 strokes .*; expected 1500 or fewer"):
        with_loads(resting(n), loads)
