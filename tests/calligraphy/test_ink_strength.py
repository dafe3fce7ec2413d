"""How black the ink of strokes is: found on a photograph, kept in files, painted with water."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from shapely import LineString

from paint3d.brush.presets import load_brush
from paint3d.calligraphy.flying_white import BLACKEST, DENSITY, dilution_for, with_strengths
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.page.correcting import CorrectedPage
from paint3d.calligraphy.page.page import Page, Piece
from paint3d.calligraphy.page.strokes_file import load_strokes, save_strokes
from paint3d.calligraphy.photo.copying import Asked, copy_sheet
from paint3d.calligraphy.photo.flat_page import FlatPage
from paint3d.calligraphy.photo.likeness import painted_sheet, strength_of_both
from paint3d.calligraphy.photo.rehearsal import rehearse
from paint3d.calligraphy.writing import WritingSettings, Written, write_page
from paint3d.colour.materials import load_material
from paint3d.errors import InputError, RecordingError
from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import load_recording, save_recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.copied_photographs import painted_copy

STRENGTHS = (1.0, 0.8, 0.5, 0.25)
EM_MM = 24.0


def page_of(strengths=STRENGTHS) -> Page:
    """A bar for each strength, one below the other."""
    strokes = []
    for k, strength in enumerate(strengths):
        line = np.array([[100.0, 900.0 - 220.0 * k], [900.0, 900.0 - 220.0 * k]])
        outline = np.array(LineString(line).buffer(55.0).exterior.coords)[:-1]
        strokes.append(GlyphStroke(outline, line, strength=strength))
    glyph = Glyph("bars", tuple(strokes), (0.0, 0.0, 1000.0, 1000.0))
    return Page((Piece(glyph, (0.0, 0.0)),), "bars", "mine")


@cache
def written() -> Written:
    return write_page(load_mesh("plane"), page_of(), WritingSettings(load_brush("xiaokai"), EM_MM))


def painted(recording) -> list[float]:
    """What share of the surface's light each bar takes, of what the first does."""
    surface = PaintedSurface(load_mesh("plane"), 0.5, "porcelain")
    Painter(surface, "xiaokai").replay(recording)
    surface.refresh()
    frame = written().placed[0].square.chart.frame
    n = len(surface.coverage)
    places = surface.paint_mesh.vertices[:n] - frame.origin
    x, y = places @ frame.x_axis, places @ frame.y_axis
    codes = surface.mesh.colours[:n].astype(float) / 255.0
    light = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)[:, 1]
    bare = float(np.median(light[surface.coverage < 0.01]))
    taken = []
    for k in range(len(STRENGTHS)):
        middle = (900.0 - 220.0 * k - 500.0) * EM_MM / 1024.0
        inside = (np.abs(y - middle) < 0.5) & (np.abs(x) < 7.0)
        taken.append(1.0 - float(np.median(light[inside])) / bare)
    return [t / taken[0] for t in taken]


def test_strokes_take_as_much_light_as_was_asked_for() -> None:
    recording = with_strengths(written().recording, written().strength)
    got = painted(recording)
    np.testing.assert_allclose(got, STRENGTHS, atol=0.15)  # what trials correct
    assert (np.diff(got) < -0.1).all()
    assert painted(written().recording) == pytest.approx([1.0] * 4, abs=0.02)


def test_the_next_dip_is_in_the_ink_itself() -> None:
    surface = PaintedSurface(load_mesh("plane"), 2.0, "porcelain")
    painter = Painter(surface, "xiaokai", "pine soot")
    whole = surface.ink.load.sum()
    painter.thin_to(0.25)
    assert surface.ink.load.sum() == pytest.approx(whole)
    assert surface.ink.load.max() == pytest.approx(0.75 * whole)  # of water
    assert painter.dipped != {}
    painter.dip()
    assert surface.ink.load.max() == pytest.approx(whole)
    with pytest.raises(InputError, match="fraction"):
        painter.thin_to(1.5)


@pytest.mark.parametrize("ink", ["pine soot:1,water:1", {"pine soot": 1.0, "water": 1.0}])
def test_ink_that_is_thin_already_becomes_thinner(ink) -> None:
    surface = PaintedSurface(load_mesh("plane"), 2.0, "porcelain")
    painter = Painter(surface, "xiaokai", ink)
    painter.thin_to(0.5)
    held = dict(zip((p.name for p in surface.pigments), surface.ink.load, strict=True))
    assert held["pine soot"] == pytest.approx(0.25 * surface.ink.load.sum())


def test_a_tip_of_another_ink_stays_one() -> None:
    surface = PaintedSurface(load_mesh("plane"), 2.0, "porcelain")
    painter = Painter(surface, "xiaokai", "pine soot")
    painter.dip("cinnabar", 0.5)
    before = surface.ink.reservoirs.copy()
    dips = painter.dips
    for _ in range(2):  # of what it was dipped in, not of what it holds
        painter.thin_to(0.5)
        names = [p.name for p in surface.pigments]
        now = surface.ink.reservoirs[:, [names.index("pine soot"), names.index("cinnabar")]]
        np.testing.assert_allclose(now, 0.5 * before, atol=1e-9)
    assert painter.dips == dips
    painter.thin_to(1.0)
    np.testing.assert_allclose(surface.ink.reservoirs[:, : before.shape[1]], before, atol=1e-9)


def test_the_stronger_the_less_water() -> None:
    share = dilution_for(np.linspace(0.05, 1.0, 20))
    assert share[-1] == 1.0
    assert (np.diff(share) > 0.0).all()
    assert share[0] == pytest.approx(-np.log10(1.0 - 0.05 * BLACKEST) / DENSITY)


def test_black_strokes_alone_tell_nothing() -> None:
    one = write_page(
        load_mesh("plane"), page_of((1.0,)), WritingSettings(load_brush("xiaokai"), EM_MM)
    )
    assert one.strength is None
    assert with_strengths(one.recording, one.strength) is one.recording


def test_the_header_tells_each_stroke_once_and_is_read_again(tmp_path) -> None:
    recording = with_strengths(written().recording, written().strength)
    told = recording.header["strengths"]
    assert [share for _, share in told] == pytest.approx(
        dilution_for(np.array(STRENGTHS)), abs=1e-4
    )
    save_recording(recording, tmp_path / "a.jsonl")
    assert load_recording(tmp_path / "a.jsonl").header["strengths"] == told
    for share in (0.0, 2.0, float("nan")):
        broken = replace(recording, header={**recording.header, "strengths": [[0, share]]})
        with pytest.raises(RecordingError, match="strengths"):
            painted(broken)


def test_a_strength_that_changes_at_once_is_told_at_once() -> None:
    recording = written().recording
    strength = np.full(len(recording), np.nan)
    strength[10:20], strength[20:30], strength[40:50] = 1.0, 0.5, 0.5
    told = with_strengths(recording, strength).header["strengths"]
    assert [when for when, _ in told] == recording.time_ns[[10, 20, 40]].tolist()
    assert told[1][1] == told[2][1] == pytest.approx(dilution_for(0.5), abs=1e-4)


def test_files_keep_the_strength_and_so_do_corrections(tmp_path) -> None:
    save_strokes(page_of(), tmp_path / "a.strokes.json")
    page = load_strokes(tmp_path / "a.strokes.json")
    assert tuple(one.strength for one in page.pieces[0].glyph.strokes) == STRENGTHS
    corrected = CorrectedPage.of(page).split(2, (0.0, -40.0)).reverse(0)
    kept = [one.stroke.strength for one in corrected.strokes]
    assert kept == [1.0, 0.8, 0.5, 0.5, 0.25]
    joined, _ = corrected.join(2, 3)
    assert joined.strokes[2].stroke.strength == pytest.approx(0.5)
    text = (tmp_path / "a.strokes.json").read_text(encoding="utf-8")
    (tmp_path / "b.strokes.json").write_text(text.replace("0.25}", "7}"), encoding="utf-8")
    with pytest.raises(InputError, match="strength"):
        load_strokes(tmp_path / "b.strokes.json")


@cache
def scanned():
    """A scan of three bars, each paler than the one above."""
    rng = np.random.default_rng(4)
    light = np.full((640, 520), 0.85)
    for k, strength in enumerate(STRENGTHS[:3]):
        light[120 + 190 * k : 138 + 190 * k, 150:370] *= 1.0 - 0.95 * strength
    light = np.clip(light + rng.normal(0.0, 0.004, light.shape), 0.0, 1.0)
    codes = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    pixels = np.repeat(np.round(255.0 * codes).astype(np.uint8)[..., None], 3, axis=2)
    return copy_sheet(pixels, "bars", Asked(whole=True))


def test_a_scan_tells_how_strong_each_stroke_is() -> None:
    pytest.importorskip("skimage")
    found = [one.strength for piece in scanned().page.pieces for one in piece.glyph.strokes]
    np.testing.assert_allclose(sorted(found), sorted(STRENGTHS[:3]), atol=0.1)


def test_strokes_of_a_rubbing_hold_no_ink() -> None:
    pytest.importorskip("skimage")
    pixels = np.full((640, 520, 3), 30, np.uint8)
    for k, level in enumerate((230, 130, 110)):
        pixels[120 + 190 * k : 138 + 190 * k, 150:370] = level
    sheet = copy_sheet(pixels, "r", Asked(whole=True, invert=True))
    strokes = [one for piece in sheet.page.pieces for one in piece.glyph.strokes]
    assert len(strokes) > 1
    assert {one.strength for one in strokes} == {1.0}


def test_of_a_stroke_that_left_no_ink_a_trial_tells_nothing() -> None:
    pytest.importorskip("skimage")
    sheet = scanned()
    plan = write_page(load_mesh("plane"), sheet.page, WritingSettings(load_brush("xiaokai"), EM_MM))
    bare = PaintedSurface(load_mesh("plane"), 2.0, "xuan")
    bare.refresh()
    after = rehearse(plan, lambda _: bare, load_material("xuan"), 1, sheet)
    np.testing.assert_allclose(after.strength, plan.strength)


def test_a_trial_brings_the_strength_nearer() -> None:
    pytest.importorskip("skimage")
    sheet, off = scanned(), []
    for trials in (0, 1):
        asked, got = strength_of_both(sheet, painted_copy(sheet, sheet.page, "xuan", trials, 0.5))
        off.append(float(np.abs(asked - got).max()))
    assert off[1] < 0.1  # lanes of bristles lie under what is measured
    assert off[1] < 0.6 * off[0]


@pytest.mark.parametrize("material", ["porcelain", "xuan"])
def test_a_page_that_was_never_photographed_is_corrected_too(material) -> None:
    """As `paint3d write --strokes` does, and `copy --dryness none`: with grain and without."""
    mesh, made_of, off = load_mesh("plane"), load_material(material), []

    def paint(plan: Written) -> PaintedSurface:
        surface = PaintedSurface(mesh, 0.5, material=made_of)
        Painter(surface, "xiaokai").replay(with_strengths(plan.recording, plan.strength))
        surface.refresh()
        return surface

    sheet = FlatPage.of(page_of())
    for trials in (0, 1):
        plan = rehearse(written(), paint, made_of, trials)
        placed = list(zip(plan.page.pieces, plan.placed, strict=True))
        asked, got = strength_of_both(sheet, painted_sheet(sheet, placed, paint(plan)))
        off.append(float(np.abs(asked - got).max()))
    assert off[0] > 0.04
    assert off[1] < 0.015
    assert rehearse(plan, paint, made_of, 0) is plan


def test_strokes_beside_their_box_are_corrected_alike() -> None:
    """What a file of strokes says of a box need not be true: they are looked for where they lie."""
    page, mesh = page_of((1.0, 0.4)), load_mesh("plane")
    glyph = replace(page.pieces[0].glyph, box=(2000.0, 0.0, 3000.0, 1000.0))
    beside = replace(page, pieces=(Piece(glyph, (0.0, 0.0)),))

    def paint(plan: Written) -> PaintedSurface:
        surface = PaintedSurface(mesh, 0.5, "porcelain")
        Painter(surface, "xiaokai").replay(with_strengths(plan.recording, plan.strength))
        surface.refresh()
        return surface

    plans = [
        write_page(mesh, one, WritingSettings(load_brush("xiaokai"), EM_MM))
        for one in (page, beside)
    ]
    least = [
        np.nanmin(rehearse(plan, paint, load_material("porcelain"), 1).strength) for plan in plans
    ]
    assert least[0] < 0.42  # it came out too dark
    assert least[1] == pytest.approx(least[0], abs=0.01)


def test_strokes_that_ask_for_nothing_are_not_painted_on_trial() -> None:
    plan = write_page(
        load_mesh("plane"), page_of((1.0,)), WritingSettings(load_brush("xiaokai"), EM_MM)
    )

    def never(_: Written) -> PaintedSurface:
        raise AssertionError("it was painted")

    assert rehearse(plan, never, load_material("xuan"), 2) is plan


def test_a_dry_page_on_smooth_ground_is_not_painted_on_trial() -> None:
    page = page_of((1.0,))
    glyph = page.pieces[0].glyph
    dry = replace(glyph, strokes=(replace(glyph.strokes[0], dryness=(0.1, 0.8, 0.4)),))
    page = replace(page, pieces=(Piece(dry, (0.0, 0.0)),))
    plan = write_page(load_mesh("plane"), page, WritingSettings(load_brush("xiaokai"), EM_MM))
    seen = []

    def paint(_: Written) -> PaintedSurface:
        seen.append(1)
        bare = PaintedSurface(load_mesh("plane"), 2.0, "xuan")
        bare.refresh()
        return bare

    assert rehearse(plan, paint, load_material("porcelain"), 2) is plan
    assert not seen
    drier = rehearse(plan, paint, load_material("xuan"), 1)
    assert seen == [1]
    known = np.isfinite(plan.dryness)
    assert (drier.dryness[known] < plan.dryness[known]).mean() > 0.8  # all of it was bare
