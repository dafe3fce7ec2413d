"""Photographs of writing: sheet, light, inks, strokes, dryness, messages."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
import shapely
from PIL import Image
from scipy import ndimage
from scipy.ndimage import gaussian_filter1d

from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.kernels.raster import fill_depths, label_patches
from paint3d.calligraphy.photo.characters import characters_of
from paint3d.calligraphy.photo.copying import Asked, CopiedSheet, copy_sheet
from paint3d.calligraphy.photo.ink_mask import polygons_in
from paint3d.calligraphy.photo.likeness import likeness_of
from paint3d.calligraphy.photo.sheet import (
    blur_matrix,
    find_sheets,
    homography,
    map_points,
    remove_light,
    sheet_size,
)
from paint3d.errors import InputError
from tests.support.cases import long_but
from tests.support.copied_photographs import painted_copy
from tests.support.photographs import (
    Camera,
    Photographed,
    hairs_below_a_stroke,
    judge,
    photograph,
    sheet_of,
)

pytest.importorskip("skimage")


@cache
def shot(text: str, seed: int, dry: float, camera: Camera, seals: int = 1) -> Photographed:
    """A photograph of characters."""
    source = open_glyphs(None)
    glyphs = [source.load(one) for one in text]
    return photograph(sheet_of(glyphs, seed, dry=dry, seals=seals, longest=700), seed, camera)


@cache
def copied(text: str, seed: int, dry: float) -> tuple[Photographed, CopiedSheet]:
    """A photograph of characters that are known, and what was found."""
    source = open_glyphs(None)
    there = shot(text, seed, dry, Camera(size=900))
    known = {one: source.load(one) for one in text}
    return there, copy_sheet(there.pixels, "sheet.jpg", Asked(lines=(text,), templates=known))


@pytest.mark.parametrize("seed", long_but([0], range(8)))
def test_corners_are_found(seed: int) -> None:
    there = shot("永", seed, 0.0, Camera(size=640))
    side = np.linalg.norm(there.corners - np.roll(there.corners, -1, axis=0), axis=1).mean()
    off = np.linalg.norm(find_sheets(there.pixels)[0] - there.corners, axis=1)
    assert off.max() < 0.006 * side


def test_a_seal_beside_the_edge_is_no_side_of_the_sheet() -> None:
    """A side of the sheet is weaker than a seal's, and longer."""
    rng = np.random.default_rng(3)
    pixels = np.full((900, 700, 3), (105, 100, 98), float)
    pixels[90:810, 80:620] = (172, 164, 142)
    pixels[300:480, 440:602] = (150, 40, 40)
    pixels = (pixels + rng.normal(0.0, 3.0, pixels.shape)).clip(0, 255).astype(np.uint8)
    true = np.array([[80.0, 90.0], [620.0, 90.0], [620.0, 810.0], [80.0, 810.0]])
    assert np.abs(find_sheets(pixels)[0] - true).max() < 2.0


def table(*papers: tuple[int, int, int, int], framed: bool = False) -> np.ndarray:
    """A photograph of sheets on a dark table: left, upper, right and lower side of each."""
    rng = np.random.default_rng(7)
    pixels = np.full((700, 900, 3), (70, 60, 52), float)
    for left, upper, right, lower in papers:
        pixels[upper:lower, left:right] = (225, 220, 205)
        if framed:
            pixels[upper + 30 : lower - 30, left + 30 : right - 30] = (40, 38, 36)
            pixels[upper + 40 : lower - 40, left + 40 : right - 40] = (225, 220, 205)
        middle = (left + right) // 2
        pixels[upper + 60 : lower - 60, middle - 9 : middle + 9] = (25, 24, 26)
    return (pixels + rng.normal(0.0, 3.0, pixels.shape)).clip(0, 255).astype(np.uint8)


FOUR = ((60, 40, 400, 320), (480, 50, 840, 330), (70, 380, 410, 660), (490, 370, 830, 650))


@pytest.mark.parametrize("n", long_but([2], [1, 2, 4]))
def test_every_sheet_in_a_picture_is_named(n: int) -> None:
    pixels = table(*FOUR[:n])
    found = find_sheets(pixels)
    assert len(found) == n
    boxes = sorted((*one.min(axis=0), *one.max(axis=0)) for one in found)
    np.testing.assert_allclose(boxes, sorted(FOUR[:n]), atol=3.0)
    sheet = copy_sheet(pixels, "sheets.jpg")
    notes = [note for note in sheet.notes if "sheets stand out" in note]
    assert len(notes) == (n > 1)
    if n > 1:
        assert notes[0].startswith(f"{n} sheets stand out in the picture")
        for one in found:
            assert " ".join(f"{x:.0f},{y:.0f}" for x, y in one) in notes[0]
        assert copy_sheet(pixels, "sheets.jpg", Asked(corners=found[0])).notes == ()


def stained() -> np.ndarray:
    """A scan of two bars of ink, with a pale blot and three small spots of ink."""
    pixels = np.full((600, 600, 3), 235, np.uint8)
    pixels[120:480, 180:220] = pixels[120:480, 380:420] = 30
    pixels[60:110, 40:560] = 150  # a blot, which takes four tenths of the ink's light
    for x in (60, 110, 520):
        pixels[300:336, x : x + 36] = 30
    return pixels


@pytest.mark.parametrize(
    ("asked", "n"),
    [
        pytest.param(Asked(whole=True), 8, marks=pytest.mark.long),  # the blot is taken for three
        pytest.param(Asked(whole=True, darker=0.6), 5, marks=pytest.mark.long),
        pytest.param(Asked(whole=True, least=0.01), 5, marks=pytest.mark.long),
        (Asked(whole=True, least=0.01, darker=0.6), 2),
    ],
)
def test_what_is_pale_or_small_is_left_out_where_it_is_asked(asked: Asked, n: int) -> None:
    sheet = copy_sheet(stained(), "a.png", asked)
    shapes = [stroke for piece in sheet.page.pieces for stroke in piece.glyph.strokes]
    assert len(shapes) == n


@pytest.mark.parametrize(("cut", "darkness", "size"), [(400, 40.0, 8.0), (130, 45.0, 6.0)])
def test_soft_pale_blots_are_stains_which_is_told(cut: int, darkness: float, size: float) -> None:
    """Old paper: blots of two thirds of the ink's darkness at the most, ink with crisp edges.

    A fold may end the blots sharply.
    """
    rng = np.random.default_rng(4)
    blots = ndimage.gaussian_filter(rng.standard_normal((500, 400)), size)
    light = 190.0 + 3.0 * rng.standard_normal((500, 400))
    light[:150, :cut] -= darkness * np.clip(blots / blots.std(), 0.0, 2.0)[:150, :cut]
    light[200:420, 120:145] = light[200:420, 260:285] = 60.0
    light[300:325, 120:285] = 85.0  # thinner ink, with the edges of ink
    codes = np.clip(ndimage.gaussian_filter(light, 0.8), 0, 255).astype(np.uint8)
    pixels = np.repeat(codes[..., None], 3, axis=2)
    sheet = copy_sheet(pixels, "s", Asked(whole=True))
    assert [one for one in sheet.notes if "stain" in one]
    assert not sheet.ink.body[:190].any()
    assert left_out(sheet, (200, 420, 120, 145)) < 0.05
    assert left_out(sheet, (300, 325, 150, 255)) < 0.1
    assert copy_sheet(pixels, "s", Asked(whole=True, darker=0.0)).ink.body[:190].any()


@pytest.mark.parametrize(("darkness", "ink"), [(0.9, 45.0), (2.0, 45.0), (0.9, 110.0)])
def test_broad_stains_as_dark_as_ink_are_none(darkness: float, ink: float) -> None:
    """Brown, beside strokes and across them: the strokes stay."""
    y, x = np.mgrid[:500, :400]
    blots = [np.hypot(x - 60, y - 260), np.hypot(x - 270, y - 160)]
    stain = darkness / (1.0 + np.exp((np.minimum(*blots) - 70.0) / 12.0))
    light = np.array([222.0, 208.0, 180.0]) * np.exp(-stain[..., None] * [0.55, 0.8, 1.1])
    bars = (60, 420, 180, 205), (60, 420, 300, 325)
    inked = np.zeros((500, 400))
    for top, bottom, left, right in bars:
        inked[top:bottom, left:right] = 1.0
    inked = ndimage.gaussian_filter(inked, 0.8)[..., None]
    light += inked * (np.minimum(light, ink) - light)
    light += 2.0 * np.random.default_rng(5).standard_normal((500, 400, 1))
    pixels = np.clip(light, 0, 255).astype(np.uint8)
    sheet = copy_sheet(pixels, "s", Asked(whole=True))
    assert sum(len(piece.glyph.strokes) for piece in sheet.page.pieces) == 2
    assert max(left_out(sheet, bar) for bar in bars) < 0.06
    assert [one for one in sheet.notes if "stain" in one]


@pytest.mark.parametrize("blur", [0.8, 1.2, 2.0])
def test_a_broad_head_of_a_thin_stroke_is_no_stain(blur: float) -> None:
    """As the serifs of print, triangles much broader than the bar they end."""
    y, x = np.mgrid[:400, :600]
    head = (y < 215) & (np.abs(x - 490) < 0.8 * (y - 135))
    ink = head | (y >= 195) & (y < 215) & (x >= 60) & (x < 500)
    codes = ndimage.gaussian_filter(np.where(ink, 25.0, 250.0), blur).astype(np.uint8)
    sheet = copy_sheet(np.repeat(codes[..., None], 3, axis=2), "s", Asked(whole=True))
    assert sheet.ink.mask[ndimage.binary_erosion(ink, iterations=3)].mean() > 0.99
    assert not sheet.notes


def brown_stains(kind: str) -> np.ndarray:
    """Density (500, 400) of dark spots, or of the rim of a water stain, with sharp edges."""
    y, x = np.mgrid[:500, :400]
    rng = np.random.default_rng(3)
    if kind == "tide line":
        beyond = np.hypot(x - 90, y - 120) - 190.0 + 8.0 * np.sin(x / 17.0)
        rim = np.exp(np.minimum(beyond, 0.0) / 5.0)
        return ndimage.gaussian_filter(np.where(beyond < 0.0, 0.15 + rim, 0.0), 0.7)
    stain = np.zeros((500, 400))
    for cy, cx, radius in rng.uniform((20, 20, 3), (480, 380, 14), (40, 3)):
        spot = np.hypot(x - cx, y - cy) < radius
        stain[spot] = np.maximum(stain[spot], rng.uniform(0.4, 1.0))
    return ndimage.gaussian_filter(stain, 0.8)


@pytest.mark.parametrize("ink", [45.0, 105.0])
@pytest.mark.parametrize("kind", ["foxing", "tide line"])
def test_brown_stains_with_sharp_edges_are_none(kind: str, ink: float) -> None:
    """Beside strokes and across them: the strokes stay, as they do without."""
    light = np.array([222.0, 208.0, 180.0]) * np.exp(
        -brown_stains(kind)[..., None] * [0.55, 0.8, 1.1]
    )
    bars = (60, 420, 180, 205), (60, 420, 300, 325), (250, 275, 40, 160)
    inked = np.zeros((500, 400))
    for top, bottom, left, right in bars:
        inked[top:bottom, left:right] = 1.0
    inked = ndimage.gaussian_filter(inked, 0.8)[..., None]
    light += inked * (np.minimum(light, ink) - light)
    light += 2.0 * np.random.default_rng(5).standard_normal((500, 400, 1))
    sheet = copy_sheet(np.clip(light, 0, 255).astype(np.uint8), "s", Asked(whole=True))
    assert sum(len(piece.glyph.strokes) for piece in sheet.page.pieces) == 3
    assert max(left_out(sheet, bar) for bar in bars) < 0.06
    assert [one for one in sheet.notes if "stain" in one]


def test_all_that_is_too_small_is_said() -> None:
    with pytest.raises(InputError, match="all pieces of ink on the sheet are smaller"):
        copy_sheet(stained(), "a.png", Asked(whole=True, least=9.0))


def test_a_frame_on_a_sheet_and_a_scrap_beside_it_are_no_sheets() -> None:
    assert len(find_sheets(table((60, 60, 640, 640), framed=True))) == 1
    assert len(find_sheets(table((60, 60, 640, 640), (700, 100, 860, 250)))) == 1


def test_strokes_of_a_wet_sheet_are_found() -> None:
    there, sheet = copied("永和", 4, 0.0)
    found = judge(there, sheet)
    assert found.ink_iou > 0.95
    assert found.seal < 0.005
    assert found.dryness_error < 0.05
    assert [len(piece.glyph.strokes) for piece in sheet.page.pieces] == [5, 8]


def test_dry_strokes_are_known_along_their_way() -> None:
    there, sheet = copied("永大", 5, 0.9)
    found = judge(there, sheet)
    assert found.ink_iou > 0.9
    assert found.dryness_r > 0.85
    assert found.dryness_error < 0.11


@pytest.mark.long
def test_trials_bring_flying_white_where_it_was() -> None:
    _, sheet = copied("永大", 5, 0.9)
    without, after = (
        likeness_of(sheet, painted_copy(sheet, sheet.page, "xuan", trials, 0.4))
        for trials in (0, 2)
    )
    assert 1.0 - after.dryness_r < 0.5 * (1.0 - without.dryness_r)
    assert after.dryness_error < 0.75 * without.dryness_error


def test_a_seal_is_no_ink() -> None:
    there, sheet = copied("永和", 4, 0.0)
    assert (sheet.red > 0.2).sum() > 200
    assert judge(there, sheet).seal < 0.005


def brown_ink(sealed: bool) -> np.ndarray:
    """An old sheet whose ink is a warm black, (44, 32, 24), with a red seal on it or none."""
    rng = np.random.default_rng(5)
    pixels = np.full((420, 420, 3), (205, 195, 175), float)
    if sealed:
        pixels[330:390, 330:390] = (170, 50, 45)
    grain = ndimage.gaussian_filter(rng.normal(0.0, 14.0, (420, 420)), 1.0)[..., None]
    bars = np.zeros((420, 420), bool)
    for k in range(4):
        bars[60 + 70 * k : 78 + 70 * k, 70:300] = True
    pixels[bars] = (np.array((44.0, 32.0, 24.0)) + grain)[bars]
    return pixels.clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize("sealed", [False, True])
def test_a_warm_black_is_ink_and_no_seal(sealed: bool) -> None:
    """Ink of old paper is brownish, and the darker the more in density; strokes stay whole."""
    sheet = copy_sheet(brown_ink(sealed), "old.jpg", Asked(whole=True))
    assert [len(piece.glyph.strokes) for piece in sheet.page.pieces] in ([4], [1] * 4)
    for k in range(4):
        bar = np.s_[63 + 70 * k : 75 + 70 * k, 75:295]
        assert sheet.ink.mask[bar].mean() > 0.995
        assert sheet.red[bar].max() < 0.5
    assert (sheet.red > 0.3).mean() == pytest.approx(0.0204 if sealed else 0.0, abs=0.004)


def test_a_shadow_is_no_ink() -> None:
    sheet = np.full((300, 240, 3), 0.8, np.float32)
    sheet[:, 150:] *= 0.45  # a hand's
    sheet[100:110, 40:200] *= 0.05
    reflected, _ = remove_light(sheet)
    assert reflected[200:, :145].min() > 0.9
    assert reflected[200:, 156:].min() > 0.9
    assert reflected[104:106, 60:180].max() < 0.15


def test_the_order_and_direction_are_the_characters_own() -> None:
    _, sheet = copied("永和", 4, 0.0)
    template = open_glyphs(None).load("和")
    found = sheet.page.pieces[1].glyph
    for one, other in zip(found.strokes, template.strokes, strict=True):
        along = (one.median[-1] - one.median[0]) @ (other.median[-1] - other.median[0])
        assert along > 0.0


def test_proportions_follow_from_the_perspective() -> None:
    """A sheet of 2 : 3 seen from the side by a camera whose focal length is that of its picture."""
    flat = np.array([[-1.0, -1.5], [1.0, -1.5], [1.0, 1.5], [-1.0, 1.5]])
    turned = np.column_stack([flat[:, 0] * np.cos(0.5), flat[:, 1], 5.0 + flat[:, 0] * np.sin(0.5)])
    tilted = turned.copy()
    tilted[:, 1] = turned[:, 1] * np.cos(0.4)
    tilted[:, 2] = turned[:, 2] + turned[:, 1] * np.sin(0.4)
    corners = 1000.0 * tilted[:, :2] / tilted[:, 2:] + np.array([500.0, 400.0])
    height, width = sheet_size(corners, (800, 1000), 600)
    assert width / height == pytest.approx(2.0 / 3.0, rel=0.06)


def test_a_homography_carries_its_points() -> None:
    start = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    end = np.array([[1.0, 1.0], [9.0, 2.0], [8.0, 7.0], [0.0, 6.0]])
    assert map_points(homography(start, end), start) == pytest.approx(end)


def test_a_rubbing_is_read_by_its_white_strokes() -> None:
    there = shot("大", 2, 0.0, Camera(size=700, fills=True, shadow=0.0), seals=0)
    sheet = copy_sheet(255 - there.pixels, "r", Asked(whole=True, invert=True))
    assert judge(there, sheet).ink_iou > 0.85
    assert sheet.notes == ()


def rubbing_of(text: str, seed: int) -> tuple[np.ndarray, np.ndarray, int]:
    """A rubbing of worn stone: its pixels, where strokes are, and how many there are.

    Grain lies all over it and in bands, as cracked stone leaves it; it mottles the strokes too, and
    the stone is chipped along one edge.
    """
    rng = np.random.default_rng(seed)
    glyphs = [open_glyphs(None).load(one) for one in text]
    carved = sheet_of(glyphs, seed, seals=0, longest=600).body
    down = np.arange(carved.shape[0])[:, None]
    often = 0.004 + 0.06 * np.exp(-(((down - 0.15 * len(down)) / 9.0) ** 2))
    grain = ndimage.binary_dilation(rng.random(carved.shape) < often, np.ones((2, 4)))
    light = 28.0 + 8.0 * rng.standard_normal(carved.shape)
    light[grain] = 150.0
    light[:40, 200:320] = 120.0 + 60.0 * rng.standard_normal((40, 120))
    worn = ndimage.gaussian_filter(rng.standard_normal(carved.shape), 3.0)
    light[carved] = 195.0 + (20.0 * worn / worn.std())[carved]
    light[carved & grain] = 90.0
    codes = np.clip(ndimage.gaussian_filter(light, 0.7), 0, 255).astype(np.uint8)
    return np.repeat(codes[..., None], 3, axis=2), carved, sum(len(one.strokes) for one in glyphs)


@pytest.mark.parametrize(
    ("text", "seed"), long_but([("永", 1)], [("永", 1), ("木大", 2), ("和", 3)])
)
def test_stone_grain_is_neither_strokes_nor_flying_white(text: str, seed: int) -> None:
    pixels, carved, n = rubbing_of(text, seed)
    sheet = copy_sheet(pixels, "r", Asked(whole=True, invert=True))
    strokes = [stroke for piece in sheet.page.pieces for stroke in piece.glyph.strokes]
    assert n <= len(strokes) <= 1.2 * n
    assert all(max(stroke.dryness) < 0.02 for stroke in strokes)
    assert (sheet.ink.body & carved).sum() > 0.9 * (sheet.ink.body | carved).sum()


def test_a_wide_stroke_of_a_rubbing_is_not_hollow() -> None:
    pixels = np.full((400, 400, 3), 25, np.uint8)
    pixels[80:320, 60:80] = pixels[120:280, 160:340] = 200
    sheet = copy_sheet(pixels, "r", Asked(whole=True, invert=True))
    assert sheet.ink.body[125:275, 165:335].all()


def test_a_mount_around_a_rubbing_is_left_out_and_told() -> None:
    there = shot("大", 2, 0.0, Camera(size=700, fills=True, shadow=0.0), seals=0)
    mounted = np.pad(255 - there.pixels, ((150, 150), (150, 150), (0, 0)), constant_values=235)
    sheet = copy_sheet(mounted, "r", Asked(whole=True, invert=True))
    (note,) = sheet.notes
    assert note.fields["share"] > 0.5
    assert not sheet.ink.body[:140].any()


def test_what_lies_along_the_edge_of_a_rubbing_is_told() -> None:
    """A stroke across the edge is one; what lies along it for longer is none, and said."""
    pixels = np.full((500, 400, 3), 25, np.uint8)
    pixels[100:400, 190:215] = pixels[240:265, 100:300] = 200
    crossed = pixels.copy()
    crossed[:60, 300:325] = 200
    assert copy_sheet(crossed, "r", Asked(whole=True, invert=True)).notes == ()
    pixels[200:290, :30] = 200
    (note,) = copy_sheet(pixels, "r", Asked(whole=True, invert=True)).notes
    assert str(note).startswith("a white piece along the edge of the sheet")


def test_a_sheet_that_is_no_rubbing_is_refused_as_one() -> None:
    there = shot("大", 2, 0.0, Camera(size=700, fills=True, shadow=0.0), seals=0)
    told = refused(there.pixels, whole=True, invert=True)
    assert "no white strokes" in told


def inked(*boxes: tuple[int, int, int, int]) -> np.ndarray:
    """A scan (300, 200) with bars of ink, each from row to row and from column to column."""
    pixels = np.full((300, 200, 3), 255, np.uint8)
    for top, bottom, left, right in boxes:
        pixels[top:bottom, left:right] = 0
    return pixels


def test_counters_stay_open_beside_flying_white() -> None:
    """Bars with narrow counters between them, and a dry stroke's hairs near by."""
    bars = [(60 + 26 * k, 80 + 26 * k, 30, 90) for k in range(4)]
    hairs = [(40, 170, x, x + 3) for x in (*range(96, 126, 6), *range(6, 26, 6))]
    sides = (60, 158, 30, 45), (60, 158, 78, 90)
    sheet = copy_sheet(inked(*bars, *sides, *hairs), "c", Asked(whole=True))
    for k in range(3):
        assert not sheet.ink.body[81 + 26 * k : 85 + 26 * k, 50:74].any()
    assert sheet.ink.body[60:150, 100:118].mean() > 0.95


@pytest.mark.parametrize("ink", [10, 60])
def test_the_crossing_of_strokes_that_fill_the_sheet_is_no_shadow(ink: int) -> None:
    codes = np.full((420, 420, 3), 250, np.uint8)
    codes[160:212, 50:370] = codes[50:370, 180:232] = ink
    sheet = copy_sheet(codes, "s", Asked(whole=True))
    assert sheet.ink.mask[162:210, 182:230].all()


def test_counters_of_print_stay_open_between_thin_bars() -> None:
    """Bars a fifth as wide as the stems that they join are no hairs of a dry stroke."""
    codes = np.full((400, 300, 3), 255, np.uint8)
    for left in (50, 133, 216):
        codes[60:340, left : left + 38] = 0
    for top in (80, 119, 158, 197, 236):
        codes[top : top + 7, 50:254] = 0
    sheet = copy_sheet(codes, "s", Asked(whole=True))
    gaps = [sheet.ink.body[top + 13 : top + 33, 95:126] for top in (80, 119, 158, 197)]
    assert not any(gap.any() for gap in gaps)


def cut_up(text: str, apart: float) -> np.ndarray:
    """A scan in black and white of a character cut up in its middle by ragged streaks."""
    body = np.pad(sheet_of([open_glyphs(None).load(text)], 1, seals=0, longest=560).body, 10)
    noise = np.random.default_rng(2).standard_normal(body.shape)
    y, x = np.indices(body.shape)
    streaks = (x + 0.35 * y + 7.0 * ndimage.gaussian_filter(noise, 1.2)) % apart < 2.0
    streaks &= (0.35 * len(body) < y) & (y < 0.75 * len(body))
    return np.repeat(np.where(body & ~streaks, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


@pytest.mark.parametrize(
    ("text", "apart", "n_shapes", "n"), [("三", 9.0, 3, 3), ("川", 11.0, 3, 3), ("非", 9.0, 2, 8)]
)
def test_strokes_cut_up_by_streaks_are_whole_and_apart(
    text: str, apart: float, n_shapes: int, n: int
) -> None:
    sheet = copy_sheet(cut_up(text, apart), "c", Asked(whole=True))
    assert len(polygons_in(sheet.ink.body, sheet.ink.width)) == n_shapes
    assert sum(len(piece.glyph.strokes) for piece in sheet.page.pieces) == n


def left_out(sheet: CopiedSheet, box: tuple[int, int, int, int]) -> float:
    """What share of a box of pixels no stroke covers."""
    top, bottom, left, right = box
    regions = [shapely.Polygon(one.outline, one.holes).buffer(0.0) for one in sheet.drawn()]
    covered = shapely.unary_union(regions).intersection(shapely.box(left, top, right, bottom))
    return 1.0 - covered.area / ((bottom - top) * (right - left))


def test_ink_on_either_side_of_a_hairline_is_copied() -> None:
    bars = (40, 60, 30, 150), (120, 140, 30, 170)
    pixels = inked(*bars)
    for k in range(60):
        pixels[60 + k, 140 - k // 2] = 0
    sheet = copy_sheet(pixels, "h", Asked(whole=True))
    for bar in bars:
        assert left_out(sheet, bar) < 0.02
    assert sheet.notes == ()


def test_ink_within_a_ring_is_copied_and_its_counter_stays_open() -> None:
    """A bar that a pixel joins to the frame around it."""
    frame = (40, 52, 30, 170), (238, 250, 30, 170), (40, 250, 30, 42), (40, 250, 158, 170)
    bar = (130, 145, 60, 140)
    pixels = inked(*frame, bar)
    pixels[137, 42:60] = 0
    sheet = copy_sheet(pixels, "r", Asked(whole=True))
    for side in (*frame, bar):
        assert left_out(sheet, side) < 0.02
    for counter in (55, 125, 45, 155), (150, 235, 45, 155):
        assert left_out(sheet, counter) > 0.98


def test_ink_that_no_stroke_covers_is_told(tmp_path) -> None:
    pixels = np.asarray(Image.open(hairs_below_a_stroke(tmp_path)))
    sheet = copy_sheet(pixels, "h", Asked(whole=True))
    (note,) = sheet.notes
    told = re.fullmatch(r"1 \((\d+)%\)", note.fields["lost"])
    assert told is not None, note
    assert 3 <= int(told[1]) <= 10


@pytest.mark.parametrize(
    ("level", "words"),
    [(0, "lies in black shadow"), (20, "lies in black shadow"), (90, "no ink was found")],
)
def test_a_sheet_of_one_tone_has_no_ink(level: int, words: str) -> None:
    """As where a bar of ink was taken for the sheet."""
    with pytest.raises(InputError, match=words):
        copy_sheet(np.full((300, 200, 3), level, np.uint8), "b", Asked(whole=True))


def one_bit(pixels: np.ndarray, dither: Image.Dither) -> np.ndarray:
    """A picture in black and white alone, as a scanner or a program makes it."""
    grey = Image.fromarray(pixels).convert("L")
    return np.array(grey.convert("1", dither=dither).convert("RGB"))


def test_a_scan_in_black_and_white_is_read() -> None:
    there = shot("永和", 4, 0.0, Camera(size=700, fills=True, shadow=0.0), seals=0)
    sheet = copy_sheet(one_bit(there.pixels, Image.Dither.NONE), "b", Asked(whole=True))
    assert judge(there, sheet).ink_iou > 0.8
    assert len(sheet.page.pieces) == 2


@pytest.mark.parametrize("whole", long_but([True], [True, False]))
def test_a_dithered_one_is_told(whole: bool) -> None:
    there = shot("永和", 4, 0.0, Camera(size=700, fills=whole, shadow=0.0), seals=0)
    told = refused(one_bit(there.pixels, Image.Dither.FLOYDSTEINBERG), whole=whole)
    assert "scan in grey" in told


# -- what belongs together ----------------------------------------------------------------------


def boxes(*corners: tuple[float, float, float, float]) -> list[object]:
    """Rectangles as inks."""
    import shapely

    return [shapely.box(*one) for one in corners]


def test_columns_are_read_from_the_right_and_rows_from_the_left() -> None:
    parts = boxes((0, 0, 80, 80), (100, 0, 180, 80), (0, 100, 80, 180), (100, 100, 180, 180))
    columns = characters_of(parts, 8.0, ("東南西北",))
    assert [one.shape.bounds[:2] for one in columns] == [(100, 0), (100, 100), (0, 0), (0, 100)]
    rows = characters_of(parts, 8.0, ("東南", "西北"), columns=False)
    assert [one.shape.bounds[:2] for one in rows] == [(0, 0), (100, 0), (0, 100), (100, 100)]
    unknown = characters_of(parts, 8.0)
    assert [one.shape.bounds[:2] for one in unknown] == [(100, 0), (100, 100), (0, 0), (0, 100)]


def test_three_bars_of_one_character_are_kept_apart_from_the_next() -> None:
    three = [(10, 0, 70, 8), (14, 34, 66, 42), (2, 70, 78, 80)]
    parts = boxes(*three, (0, 105, 80, 113), (0, 140, 80, 180))
    found = characters_of(parts, 8.0, ("三二",))
    assert [len(one.shape.geoms) for one in found] == [3, 2]


def test_many_inks_are_put_together_by_their_gaps() -> None:
    """Nine characters, each of three dots above two bars."""
    own = [*((24 * k, 0, 24 * k + 10, 10) for k in range(3)), (0, 18, 58, 28), (0, 36, 58, 46)]
    at = [(120 * i, 120 * j) for i, j in product(range(3), repeat=2)]
    parts = boxes(*((x + a, y + b, x + c, y + d) for a, b, c, d in own for x, y in at))
    found = characters_of(parts, 8.0)
    assert [len(one.shape.geoms) for one in found] == [5] * 9
    assert {one.size for one in found} == {(58.0, 46.0)}


def test_halves_of_a_character_are_no_lines() -> None:
    found = characters_of(boxes((0, 0, 30, 80), (60, 0, 100, 80)), 8.0, ("林",))
    assert [len(one.shape.geoms) for one in found] == [2]


def test_a_text_that_is_longer_than_the_sheet_is_refused() -> None:
    with pytest.raises(InputError, match=r"5 characters, the sheet 2 inks"):
        characters_of(boxes((0, 0, 80, 80), (100, 0, 180, 80)), 8.0, ("一二三四五",))


# -- messages -----------------------------------------------------------------------------------


def refused(pixels: np.ndarray, **asked: object) -> str:
    """Why a picture cannot be copied."""
    with pytest.raises(InputError) as fault:
        copy_sheet(pixels, "x", Asked(**asked))  # type: ignore[arg-type]
    told = str(fault.value)
    assert "expected" in told
    return told


def test_a_picture_without_a_sheet_says_what_to_give() -> None:
    noise = np.random.default_rng(1).integers(90, 130, (400, 500, 3)).astype(np.uint8)
    assert "--corners" in refused(noise)
    assert "--whole" in refused(noise)


def test_an_empty_sheet_has_no_ink() -> None:
    rng = np.random.default_rng(2)
    paper = (225 + 3 * rng.standard_normal((250, 200, 3))).clip(0, 255).astype(np.uint8)
    assert "no ink" in refused(paper, whole=True)


def test_a_rubbing_that_is_not_said_to_be_one_is_told() -> None:
    there = shot("大", 2, 0.0, Camera(size=700, fills=True, shadow=0.0), seals=0)
    assert "--invert" in refused(255 - there.pixels, whole=True)


def test_strokes_of_few_pixels_are_too_coarse() -> None:
    there = shot("書道", 3, 0.0, Camera(size=700, fills=True), seals=0)
    assert "pixels wide" in refused(there.pixels[::6, ::6].copy(), whole=True)


def test_more_pieces_of_ink_than_a_sheet_of_writing_has_are_told() -> None:
    pixels = np.full((620, 620, 3), 240, np.uint8)
    for y in range(30, 590, 12):
        for x in range(30, 590, 12):
            pixels[y : y + 6, x : x + 6] = 20
    told = refused(pixels, whole=True)
    assert "2,209 pieces" in told
    assert "crop it" in told


def test_more_strokes_than_a_sheet_of_writing_has_are_told(monkeypatch) -> None:
    there = shot("永和", 4, 0.0, Camera(size=700, fills=True, shadow=0.0), seals=0)
    monkeypatch.setattr("paint3d.calligraphy.photo.copying._MOST_STROKES", 12)
    assert "more than 12 strokes" in refused(there.pixels, whole=True)


@pytest.mark.parametrize(("n", "sigma"), [(120, 30.0), (90, 0.96), (5, 3.0), (1, 0.7), (7, 40.0)])
def test_light_is_blurred_as_scipy_blurs_it(n: int, sigma: float) -> None:
    row = np.random.default_rng(n).random((n, 3))
    ours, theirs = blur_matrix(n, sigma) @ row, gaussian_filter1d(row, sigma, axis=0)
    np.testing.assert_allclose(ours, theirs, rtol=1e-12)


def test_a_highlight_is_told() -> None:
    there = shot("大", 2, 0.0, Camera(size=700, fills=True, shadow=0.0), seals=0)
    pixels = (0.8 * there.pixels).astype(np.uint8)
    y, x = np.mgrid[0 : pixels.shape[0], 0 : pixels.shape[1]]
    pixels[(y - 300) ** 2 + (x - 300) ** 2 < 120**2] = 255
    assert "highlight" in refused(pixels, whole=True)


def test_a_black_shadow_is_told() -> None:
    there = shot("大", 2, 0.0, Camera(size=700, fills=True, shadow=0.0), seals=0)
    pixels = there.pixels.copy()
    pixels[:, : pixels.shape[1] // 3] = 4
    assert "shadow" in refused(pixels, whole=True)


def test_a_wet_page_says_nothing_of_dryness() -> None:
    _, sheet = copied("永大", 5, 0.9)
    assert any(stroke.dryness for stroke in sheet.page.pieces[0].glyph.strokes)
    assert not any(s.dryness for piece in sheet.wet_page.pieces for s in piece.glyph.strokes)
    assert replace(sheet, page=sheet.wet_page).page.source == "sheet.jpg"


# -- patches of a mask -------------------------------------------------------------------------


def a_mask(share: float, shape: tuple[int, int]) -> np.ndarray:
    mask = np.random.default_rng(9).random(shape) < share
    mask[shape[0] // 2, shape[1] // 3] = False
    return mask


@pytest.mark.parametrize("shape", [(1, 9), (40, 57), (120, 30)])
@pytest.mark.parametrize("share", [0.0, 0.4, 0.62, 0.99, 1.0])
def test_patches_are_scipys(share: float, shape: tuple[int, int]) -> None:
    mask = a_mask(share, shape)
    depths, labels = np.empty(shape), np.empty(shape, np.int32)
    fill_depths(mask, depths)
    n = label_patches(mask, labels)
    expected, count = ndimage.label(mask)
    assert n == count
    np.testing.assert_array_equal(labels, expected)
    np.testing.assert_array_equal(depths, ndimage.distance_transform_edt(mask))
