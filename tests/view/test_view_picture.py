"""Pictures, drawn small: what they show, and that they are written whole or not at all."""

from __future__ import annotations

import ctypes.util
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.ndimage import median_filter

from paint3d.errors import ExportError, InputError, MeshError, UnknownNameError
from paint3d.files.load import load_mesh
from paint3d.files.project.painting import PlainSurface
from paint3d.view import daylight, picture, scene
from paint3d.view.daylight import Ground, Occluder, light_ground
from paint3d.view.picture import Gloss, View, draw_picture, render_picture
from paint3d.view.scene import quiet_vtk
from paint3d.view.shot import VIEWS, Shot, take_shot, take_turning
from paint3d.view.studio import (
    SOFTBOXES,
    Sun,
    light_samples,
    linear_to_srgb,
    make_panorama,
    srgb_to_linear,
)
from tests.support.view_shapes import BARE, INK, ball, sheet

SIZE = (320, 240)
MIDDLE = (slice(112, 128), slice(152, 168))

needs_opengl = pytest.mark.skipif(
    not any(map(ctypes.util.find_library, ("EGL", "OSMesa", "GL"))), reason="no OpenGL at all"
)


def inked_ball():
    vertices, faces, normals = ball()
    srgb = np.tile(BARE, (len(vertices), 1))
    srgb[normals @ np.float32([0.954, 0.0, 0.3]) > 0.96] = INK
    return vertices, faces, normals, srgb


def drawn(folder, arrays, **options) -> np.ndarray:
    path = folder / "picture.png"
    render_picture(*arrays, path, size=SIZE, **options)
    assert [file.name for file in folder.iterdir()] == ["picture.png"]
    with Image.open(path) as image:
        assert image.format == "PNG"
        return np.asarray(image.convert("RGB")).astype(float)


@pytest.fixture(scope="module")
def portrait(tmp_path_factory) -> np.ndarray:
    return drawn(tmp_path_factory.mktemp("portrait"), inked_ball())


@needs_opengl
def test_the_picture_has_the_size_asked_for(portrait):
    assert portrait.shape == (SIZE[1], SIZE[0], 3)


@needs_opengl
def test_ink_faces_the_camera_and_is_black(portrait):
    assert np.median(portrait[130:165, 142:178]) < 50
    assert np.median(portrait[130:165, 80:110]) > 200


@needs_opengl
def test_the_bare_glaze_is_luminous_and_stands_out_from_the_backdrop(portrait):
    brightness = portrait.mean(axis=2)
    glaze = np.quantile(brightness[40:200, 80:240], 0.8)
    backdrop = np.median(brightness[:20])
    assert glaze > 200
    assert 90 < backdrop < glaze - 25


@needs_opengl
def test_the_backdrop_has_no_seam(portrait):
    column = portrait[:, 4].mean(axis=1)  # floor and backdrop beside the object, bottom to top
    assert np.abs(np.diff(column)).max() <= 3


@needs_opengl
def test_the_object_casts_a_shadow_on_the_floor(portrait):
    beside, under = portrait[208:214, 40:60].mean(), portrait[208:214, 199:204].mean()
    assert under < beside - 25


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
def test_behind_the_paint_it_is_bare_and_chalk_has_no_highlights(tmp_path, portrait):
    view, gloss = View((-0.954, 0.0, 0.5)), Gloss.of("plaster")
    back = drawn(tmp_path, inked_ball(), view=view, gloss=gloss)
    assert np.median(back[MIDDLE]) > 180
    assert back.min(axis=2).max() < portrait.min(axis=2).max() - 5


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
def test_a_roughness_told_for_each_vertex_is_that_of_the_whole(tmp_path):
    arrays = inked_ball()
    one = drawn(tmp_path, arrays, gloss=Gloss(0.75, 0.0))
    each = np.full(len(arrays[0]), 0.75)
    same = drawn(tmp_path, arrays, gloss=Gloss(0.75, 0.0, each=each))
    assert np.abs(same - one).max() <= 2.0
    smoother = drawn(tmp_path, arrays, gloss=Gloss(0.75, 0.0, each=0.4 * each))
    assert np.abs(smoother - one).max() > 20.0


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
def test_a_sheet_lies_flat_and_fills_the_frame(tmp_path):
    vertices, faces, normals = sheet(40.0, 30.0)
    srgb = np.tile(BARE, (len(vertices), 1))
    srgb[np.linalg.norm(vertices[:, :2] - (20, 15), axis=1) < 4] = INK
    pixels = drawn(tmp_path, (vertices, faces, normals, srgb), gloss=Gloss.of("xuan"))
    paper = pixels.mean(axis=2)[[20, 20, 220, 220, 120], [20, 300, 20, 300, 60]]
    assert paper.min() > 195
    assert np.ptp(paper) < 25
    assert np.median(pixels[MIDDLE]) < 60


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
def test_without_a_display_it_is_silent_and_the_same(tmp_path, tmp_path_factory):
    path = tmp_path / "a.png"
    code = (
        "from tests.view.test_view_picture import *\nfrom tests.support.less_work import *\n"
        f"with by_few_lights(): render_picture(*inked_ball(), {str(path)!r}, size=SIZE)"
    )
    command = [sys.executable, "-c", code]
    root = Path(__file__).parents[2]
    done = subprocess.run(command, capture_output=True, text=True, env={}, cwd=root, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    with Image.open(path) as image:
        assert np.array_equal(
            np.asarray(image), drawn(tmp_path_factory.mktemp("here"), inked_ball())
        )


@pytest.fixture(scope="module")
def bare_bowl():
    vertices, faces, normals, _ = PlainSurface(load_mesh("bowl")).export_arrays(None)
    srgb = np.tile(BARE, (len(vertices), 1))
    return draw_picture(vertices, faces, normals, srgb, size=(1000, 750)).mean(axis=2)


@pytest.mark.long
@needs_opengl
def test_no_dark_dots_lie_along_a_rim(bare_bowl):
    assert (bare_bowl > median_filter(bare_bowl, 5) - 30.0).all()


@pytest.mark.long
@needs_opengl
@pytest.mark.parametrize("row", [570, 580])
def test_the_shadow_beside_a_foot_has_no_stripes(bare_bowl, row):
    """It turns to light at an even pace, taken over six pixels."""
    beside = np.convolve(bare_bowl[row, 650:730], np.ones(6) / 6, "valid")[::3]
    assert beside[-1] > beside[0] + 30.0
    assert np.abs(np.diff(beside, 2)).mean() < 0.35


@pytest.mark.long
@needs_opengl
def test_an_outline_lies_between_the_pixels():
    """Found from how much of each pixel it covers, it is smooth to a tenth of a pixel."""
    vertices, faces, normals = ball()
    ink = np.tile(np.uint8([10, 10, 12]), (len(vertices), 1))
    pixels = draw_picture(vertices, faces, normals, ink, size=SIZE).astype(float).mean(axis=2)
    rows, edge = np.arange(70, 170), []
    for row in pixels[70:170, :160]:
        k = int(np.abs(np.diff(row)).argmax())
        before, after = row[k - 3], row[k + 4]
        edge.append(k + (row[k - 3 : k + 5] - after).sum() / (before - after))
    powers = np.vander((rows - 120) / 50, 5)
    off = edge - powers @ np.linalg.lstsq(powers, edge, rcond=None)[0]
    assert off.std() < 0.09


def test_a_missing_folder_is_told_and_nothing_is_drawn(tmp_path, monkeypatch):
    monkeypatch.setattr(picture, "draw_scene", lambda *_: pytest.fail("drawn in vain"))
    with pytest.raises(ExportError, match="missing"):
        render_picture(*inked_ball(), tmp_path / "missing" / "a.png", size=SIZE)
    with pytest.raises(ExportError, match="folder"):
        render_picture(*inked_ball(), tmp_path, size=SIZE)


@pytest.mark.usefixtures("lit_by_few")
def test_a_failed_picture_leaves_the_old_one(tmp_path, monkeypatch):
    def fail(*_):
        raise ExportError("no OpenGL")

    path = tmp_path / "a.png"
    path.write_bytes(b"old")
    monkeypatch.setattr(picture, "draw_scene", fail)
    with pytest.raises(ExportError, match="no OpenGL"):
        render_picture(*inked_ball(), path, size=SIZE)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_the_picture_behind_a_link_is_replaced_and_the_link_stays(tmp_path, monkeypatch):
    real, link = tmp_path / "real.png", tmp_path / "link.png"
    real.write_bytes(b"old")
    link.symlink_to(real)
    monkeypatch.setattr(picture, "draw_picture", lambda *_, **__: np.zeros((16, 16, 3), np.uint8))
    render_picture(*inked_ball(), link, size=SIZE)
    assert link.is_symlink()
    assert real.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("position", "value", "message"),
    [
        (0, np.full((3, 3), np.nan), "finite"),
        (0, np.zeros((7200, 3)), "one point"),
        (1, np.zeros((0, 3), int), "no faces"),
        (1, [[0, 1, 10**6]], "faces name"),
        (2, np.zeros((4, 3)), "normals has shape"),
        (3, np.zeros((4, 3), np.uint8), "srgb has shape"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(tmp_path, position, value, message):
    arrays = list(inked_ball())
    arrays[position] = value
    with pytest.raises(MeshError, match=message):
        render_picture(*arrays, tmp_path / "a.png", size=SIZE)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("size", [(0, 100), (100, 5000), (1.5, 100), (100,)])
def test_a_size_out_of_range_is_refused(tmp_path, size):
    with pytest.raises(InputError, match="size"):
        render_picture(*inked_ball(), tmp_path / "a.png", size=size)


def test_gloss_presets_by_material():
    assert Gloss.of("porcelain").coat > Gloss.of("xuan").coat
    with pytest.raises(UnknownNameError, match="porcelain"):
        Gloss.of("porcelein")
    with pytest.raises(InputError, match="roughness"):
        Gloss(1.5, 0.0)


# -- shadows and the mirrored studio -----------------------------------------------------------


FREE = Ground(np.zeros(3), 1.0, np.ones((1, 1)))


def sun(direction, share=0.0) -> Sun:
    direction = np.asarray(direction, dtype=float)
    return Sun(direction / np.linalg.norm(direction), np.ones(3), share)


def test_a_convex_body_is_lit_by_the_cosine_and_does_not_shade_itself():
    vertices, faces, normals = ball(n=120)
    light = sun((1, 2, 3))
    lit, hidden = Occluder(vertices, faces).shine([light], vertices, normals, 0.5, FREE)
    expected = np.maximum(normals @ light.direction, 0)
    assert np.abs(lit[:, 0] - expected).max() < 1e-5
    assert np.all(hidden == 0)


@pytest.mark.parametrize("direction", [(0, 0, 1), (0.5, 0.2, 1), (-1, 0.5, 1)])
def test_a_sheet_shades_exactly_what_lies_behind_it(direction):
    vertices, faces, _ = sheet(40.0, 40.0)
    light = sun(direction, share=0.25)
    ticks = np.linspace(-30, 70, 201)
    x, y = np.meshgrid(ticks, ticks)
    points = np.stack([x, y, np.full_like(x, -10)], axis=-1).reshape(-1, 3).astype(np.float32)
    normals = np.tile(np.float32([0, 0, 1]), (len(points), 1))
    occluder = Occluder(vertices, faces)
    lit, hidden = occluder.shine([light], points, normals, 0.0, FREE)
    crossing = points[:, :2] + 10 * light.direction[:2] / light.direction[2]
    margin = np.minimum(crossing, 40 - crossing).min(axis=1)  # mm inside the sheet's edge
    far = np.abs(margin) > 1.5 * occluder.cell
    assert np.array_equal(lit[far, 0] == 0, margin[far] > 0)
    assert np.allclose(lit[:, 0] + hidden, light.direction[2], atol=1e-6)


def test_the_object_is_looked_at_once_from_each_light(monkeypatch: pytest.MonkeyPatch) -> None:
    """The floor and the object ask for the same depth maps, each of 400,000 samples."""
    filled: list[bytes] = []
    fill = daylight.fill_depth_map
    monkeypatch.setattr(
        daylight, "fill_depth_map", lambda p, to: filled.append(to.axes.tobytes()) or fill(p, to)
    )
    vertices, faces, normals = ball(n=40)
    occluder, suns = Occluder(vertices, faces), light_samples(48)[::6]
    ground = light_ground(occluder, suns)
    light = daylight.light_points(occluder, ground, suns, vertices, normals, 0.8)
    assert len(filled) == len(set(filled)) == len(suns) > 30
    again = daylight.light_points(Occluder(vertices, faces), ground, suns, vertices, normals, 0.8)
    assert np.array_equal(light, again)


def test_the_floor_loses_what_its_places_do_not_get() -> None:
    vertices, faces, _ = ball(n=40)
    occluder, suns = (
        Occluder(vertices, faces),
        [sun((1, 2, 3)), sun((-2, 0.1, 0.4)), sun((0, 0, 1))],
    )
    x, y, z = occluder.centre[0], occluder.centre[1], vertices[:, 2].min()
    floor = Ground(np.array([x, y, z]), 2.5 * occluder.radius, np.ones((50, 50)))
    occluder.shade(suns, floor)
    ticks = ((np.arange(50) + 0.5) / 50 * 2 - 1) * floor.half
    across, along = np.meshgrid(ticks + x, ticks + y)
    points = np.stack([across, along, np.full_like(across, z)], axis=-1).reshape(-1, 3)
    up = np.tile(np.float32([0, 0, 1]), (len(points), 1))
    lit, _ = occluder.shine(suns, points.astype(np.float32), up, 0.0, FREE)
    full = sum(light.irradiance * light.direction[2] for light in suns)
    expected = (lit / full)[:, 0].reshape(50, 50)
    assert 0.1 < (expected < 0.99).mean() < 0.9
    np.testing.assert_allclose(floor.openness, expected, atol=1e-6)


def test_the_floor_is_dark_under_the_object_and_free_far_away():
    vertices, faces, _ = ball(n=120)
    ground = light_ground(Occluder(vertices, faces), light_samples())
    middle = len(ground.openness) // 2
    assert ground.openness.min() >= 0
    assert ground.openness.max() <= 1 + 1e-9
    assert ground.openness[middle, middle] < 0.15
    assert ground.openness[[0, 0, -1, -1], [0, -1, 0, -1]].min() > 0.95


def test_an_object_that_turns_shades_the_floor_as_if_it_had_been_built_so() -> None:
    """On a floor that stays where it is, however far the object reaches now."""
    vertices, faces, _ = ball()
    vertices = (vertices * [3.0, 1.0, 1.0] + [40.0, 0.0, 0.0]).astype(np.float32)
    quarter, middle = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.zeros(3)
    suns = light_samples(48)[::6]
    still = Occluder(vertices, faces, middle)
    turned = light_ground(still.turned(quarter), suns)
    built = light_ground(Occluder(vertices @ quarter.T, faces, middle), suns)
    before = light_ground(still, suns)
    assert turned.half == built.half == before.half
    np.testing.assert_array_equal(turned.origin, before.origin)
    assert np.abs(turned.openness - built.openness).mean() < 1e-3
    assert np.abs(turned.openness - before.openness).mean() > 1e-2


def test_samples_of_the_studio_cover_the_sphere_evenly():
    suns = light_samples()
    directions = np.array([sun.direction for sun in suns])
    shares = np.array([sun.share for sun in suns])
    assert np.allclose(np.linalg.norm(directions, axis=1), 1)
    assert shares.sum() == pytest.approx(1)
    assert np.abs(shares @ directions).max() < 0.01
    cosines = np.maximum(directions @ [0.36, -0.48, 0.8], 0)
    assert shares @ cosines == pytest.approx(0.25, rel=0.02)


def test_the_panorama_shows_each_softbox_where_it_stands():
    panorama = make_panorama(128)
    for box in SOFTBOXES:
        x, y, z = box.axes()[2]
        row = int((np.arcsin(z) / np.pi + 0.5) * 128)
        column = int((np.arctan2(-y, x) / (2 * np.pi) + 0.5) * 256)
        assert np.all(panorama[row, column] >= np.asarray(box.radiance)) == box.mirrored


def test_every_srgb_code_survives_the_way_to_linear_light_and_back():
    codes = np.arange(256, dtype=np.uint8)
    linear = srgb_to_linear(codes)
    assert linear[[0, 255]].tolist() == [0, 1]
    assert linear[188] == pytest.approx(0.5029, abs=1e-4)
    assert np.array_equal(np.rint(255 * linear_to_srgb(linear)), codes)


# -- pictures from named sides -----------------------------------------------------------------


SHOT_SIZE = (64, 48)
SIDES = {  # the colour of a ball around each of its axes
    "right": (200, 20, 20), "left": (20, 200, 20), "back": (20, 20, 200),
    "front": (200, 200, 20), "top": (20, 200, 200), "bottom": (200, 20, 200),
}  # fmt: skip
AXES = {"right": 0, "left": 0, "back": 1, "front": 1, "top": 2, "bottom": 2}


def six_sided():
    """A ball that tells from which side it is seen."""
    vertices, faces, normals = ball()
    srgb = np.zeros((len(vertices), 3), np.uint8)
    nearest = np.abs(normals).argmax(axis=1)
    for side, colour in SIDES.items():
        sign = 1.0 if side in ("right", "back", "top") else -1.0
        srgb[(nearest == AXES[side]) & (normals[:, AXES[side]] * sign > 0.0)] = colour
    return vertices, faces, normals, srgb


def drawn_sheet(width: float, height: float):
    """A sheet, red in its lower left quarter and blue along its upper border."""
    vertices, faces, normals = sheet(width, height)
    srgb = np.full((len(vertices), 3), 255, np.uint8)
    srgb[(vertices[:, 0] < 0.5 * width - 1) & (vertices[:, 1] < 0.5 * height - 1)] = (200, 20, 20)
    srgb[vertices[:, 1] > 0.9 * height] = (20, 20, 200)
    return vertices, faces, normals, srgb


@needs_opengl
@pytest.mark.parametrize("side", SIDES)
def test_a_side_is_seen_from_there(side: str) -> None:
    pixels = take_shot(six_sided(), Shot(side, SHOT_SIZE, light="none"))
    assert pixels.shape == (48, 64, 3)
    assert tuple(pixels[24, 32]) == SIDES[side]  # without light: the code that was painted
    assert tuple(pixels[0, 0]) == (255, 255, 255)


def test_an_interrupt_waits_until_vtk_is_done() -> None:
    """One that came while a module of VTK was loaded made it crash."""
    done: list[bool] = []

    def draw() -> None:
        with quiet_vtk():
            signal.raise_signal(signal.SIGINT)
            done.append(True)

    before = signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # behind a shell it is ignored
    try:
        with pytest.raises(KeyboardInterrupt):
            draw()
    finally:
        signal.signal(signal.SIGINT, before)
    assert done


@needs_opengl
def test_right_and_left_are_where_they_are_from_in_front() -> None:
    pixels = take_shot(six_sided(), Shot((0.0, 0.0), SHOT_SIZE, light="none")).astype(int)
    red, green = ((pixels == SIDES[side]).all(axis=2).nonzero()[1] for side in ("right", "left"))
    assert red.min() > 32 > green.max()
    turned = take_shot(six_sided(), Shot((90.0, 0.0), SHOT_SIZE, light="none"))
    assert tuple(turned[24, 32]) == SIDES["right"]


@needs_opengl
def test_a_flat_picture_is_the_sheet_from_border_to_border() -> None:
    pixels = take_shot(drawn_sheet(80.0, 40.0), Shot("flat"))
    assert pixels.shape == (1131, 2263, 3)  # as many as a square of 1600
    assert tuple(pixels[848, 566]) == (200, 20, 20)
    assert tuple(pixels[848, 1697]) == (255, 255, 255)
    assert tuple(pixels[5, 1131]) == (20, 20, 200)
    shaped = take_shot(drawn_sheet(80.0, 40.0), Shot("flat", (40, 40), transparent=True))
    assert shaped.shape == (40, 40, 4)
    assert (shaped[:9, :, 3] == 0).all()  # what is wanted wider than the sheet is empty
    assert (shaped[12:28, :, 3] == 255).all()


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
@pytest.mark.parametrize("light", ["studio", "none"])
def test_on_nothing_there_is_the_object_and_its_edge(light: str) -> None:
    vertices, faces, normals = ball()
    srgb = np.tile(BARE, (len(vertices), 1))
    pixels = take_shot(
        (vertices, faces, normals, srgb), Shot("front", (96, 72), light, transparent=True)
    )
    seen = pixels[..., 3].astype(int)
    assert seen[36, 48] == 255
    assert seen[0, 0] == seen[71, 95] == seen[0, 95] == 0
    partly = (seen > 0) & (seen < 255)
    assert 20 < partly.sum() < 400  # a rim of one pixel
    assert pixels[partly][:, :3].min() > 60  # of the object's colour, not of something dark behind


@needs_opengl
def test_light_from_another_side_is_other_light() -> None:
    vertices, faces, normals = ball()
    arrays = vertices, faces, normals, np.tile(BARE, (len(vertices), 1))
    shots = {
        name: take_shot(arrays, Shot("front", (96, 72), name)).astype(int)
        for name in ("raking", "soft")
    }
    left, right = (shots["raking"][30:42, x].mean() for x in (slice(26, 36), slice(60, 70)))
    assert left > 1.5 * right
    left, right = (shots["soft"][30:42, x].mean() for x in (slice(26, 36), slice(60, 70)))
    assert left == pytest.approx(right, rel=0.03)
    assert shots["soft"][22:26, 44:52].mean() > shots["soft"][46:50, 44:52].mean()  # from above


@needs_opengl
def test_an_object_turns_once_and_keeps_its_size() -> None:
    shot = Shot("front", SHOT_SIZE, light="none", transparent=True)
    pictures = list(take_turning(six_sided(), shot, 4))
    assert [tuple(p[24, 32][:3]) for p in pictures] == [
        SIDES[side] for side in ("front", "right", "back", "left")
    ]
    covered = [(p[..., 3] > 127).sum() for p in pictures]
    assert max(covered) == min(covered)


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
@pytest.mark.parametrize("light", ["none", "soft"])
def test_a_long_object_is_not_cut_off_as_it_turns(light) -> None:
    """Its ends come nearer and go farther than all of it was in the first picture."""
    vertices, faces, normals = ball()
    stretched = (vertices * [9.0, 1.0, 1.0]).astype(np.float32)
    grey = np.full((len(vertices), 3), 120, np.uint8)
    shot = Shot("front", SHOT_SIZE, light=light, transparent=True)
    pictures = take_turning((stretched, faces, normals, grey), shot, 8)
    widths = [np.flatnonzero((p[..., 3] > 0).any(axis=0)) for p in pictures]
    wide = [int(columns[-1] - columns[0]) for columns in widths]
    assert min(wide[1], wide[3], wide[5], wide[7]) > 0.6 * wide[0]
    assert max(wide[2], wide[6]) < 0.4 * wide[0]


@pytest.mark.long
@needs_opengl
def test_a_lit_object_turns_under_one_light() -> None:
    vertices, faces, normals = ball()
    half = np.where(normals[:, :1] > 0.0, BARE, INK).astype(np.uint8)
    pictures = list(
        take_turning((vertices, faces, normals, half), Shot((90.0, 15.0), SHOT_SIZE, "raking"), 2)
    )
    bright, dark = (float(p[18:30, 24:40].mean()) for p in pictures)
    assert bright > 3.0 * dark
    floor = [p[40:, :8].astype(int) for p in pictures]
    assert np.abs(floor[0] - floor[1]).max() <= 3


def test_what_cannot_be_taken_is_named() -> None:
    with pytest.raises(UnknownNameError, match="unknown view 'frnt': did you mean 'front'"):
        Shot("frnt")
    with pytest.raises(UnknownNameError, match="unknown light 'moon'"):
        Shot(light="moon")
    with pytest.raises(InputError, match="height of the view"):
        Shot((0.0, 120.0))
    with pytest.raises(InputError, match="zoom is 0"):
        Shot(zoom=0.0)
    with pytest.raises(InputError, match="size is"):
        Shot(size=(5, 5))
    with pytest.raises(InputError, match="seen from the side; expected another view"):
        next(take_turning(drawn_sheet(20.0, 20.0), Shot("top", SHOT_SIZE), 3))


@needs_opengl
def test_a_lying_sheet_turns_as_seen_from_the_side() -> None:
    picture = next(take_turning(drawn_sheet(40.0, 40.0), Shot(size=SHOT_SIZE, light="none"), 3))
    assert (picture == (20, 20, 200)).all(axis=2).any()
    assert set(VIEWS) >= {"above"}


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
@pytest.mark.parametrize("shot", [Shot(size=SIZE), Shot("above", SIZE, transparent=True, zoom=2.5)])
def test_what_lies_around_the_object_looks_as_if_all_were_drawn_alike(shot, monkeypatch) -> None:
    boxes = []
    box_of = scene._box_of
    monkeypatch.setattr(scene, "_box_of", lambda *of: boxes.append(box_of(*of)) or boxes[-1])
    arrays = inked_ball()
    boxed = take_shot(arrays, shot)
    monkeypatch.setattr(scene, "_box_of", lambda *of: (0, 0, *of[-1]))
    x0, y0, x1, y1 = boxes[0]
    assert ((x1 - x0) * (y1 - y0) < 0.7 * SIZE[0] * SIZE[1]) == (shot.zoom == 1.0)
    difference = np.abs(boxed.astype(int) - take_shot(arrays, shot))
    assert difference.max() <= 4
    assert difference.mean() < 0.1


@needs_opengl
def test_a_picture_loads_no_package_that_takes_longer_than_itself(tmp_path) -> None:
    code = (
        "import sys\n"
        "import numpy as np\n"
        "from paint3d.files.load import load_mesh\n"
        "from paint3d.files.pictures import write_picture\n"
        "from paint3d.view.shot import Shot\n"
        "write_picture(load_mesh('bowl'), sys.argv[1], Shot(size=(64, 48)))\n"
        "print(*{'matplotlib', 'numba', 'pyvista', 'scipy.ndimage'} & set(sys.modules))\n"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "bowl.png")], capture_output=True, text=True
    )
    assert (ran.returncode, ran.stdout.split()) == (0, []), ran.stderr
    assert (tmp_path / "bowl.png").exists()
