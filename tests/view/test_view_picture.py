"""Pictures, drawn small: what they show, and that they are written whole or not at all."""

from __future__ import annotations

import ctypes.util
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
from paint3d.view import picture
from paint3d.view.picture import Gloss, View, draw_picture, render_picture
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
        "from tests.view.test_view_picture import *\nfrom tests.support.lights import *\n"
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
