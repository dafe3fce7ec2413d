"""Pictures of a painting as it grows: what is kept of it, and how it is drawn."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from paint3d.colour.pigments import load_pigment
from paint3d.colour.wet_look import MATT_ROUGHNESS
from paint3d.files import pictures
from paint3d.files.pictures import Filmed, Turning, write_growth, write_picture
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.daylight import Occluder
from paint3d.view.film import Growth
from paint3d.view.scene import FlatDrawing, SceneDrawing
from paint3d.view.shot import Moment, Shot, take_film, take_shot
from paint3d.view.studio import Gloss
from tests.support.surface_cases import flat, poses, sheet
from tests.support.view_shapes import BARE, INK, ball
from tests.view.test_view_picture import needs_opengl

SIZE = (96, 72)


def lines():
    """Two strokes on a sheet, one after the other."""
    x = np.linspace(-10.0, 10.0, 30)
    for y in (-4.0, 4.0):
        points = np.stack([x, np.full(30, y), np.zeros(30)], axis=1)
        yield poses(points, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), np.full(30, 0.4), "slender")


def coloured_sheet() -> TriangleMesh:
    mesh = sheet(flat, (40.0, 20.0), 4.0)
    codes = np.rint(120 + 3 * mesh.vertices).clip(0, 255).astype(np.uint8)
    return TriangleMesh(mesh.vertices, mesh.faces, colours=codes)


@pytest.mark.parametrize("mesh", [sheet(flat, (40.0, 20.0), 4.0), coloured_sheet()])
def test_colours_come_back_as_they_were_and_bare_where_nothing_was_yet(mesh) -> None:
    surface = PaintedSurface(mesh, 0.8)
    painter = Painter(surface, "slender", "pine soot")
    with Growth(surface, 0.5) as growth:
        seen = [surface.srgb.copy()]
        for k, stroke in enumerate(lines()):
            painter.replay(stroke)
            growth.at(0.2 + k)  # too early for one more; then two at once
            seen.append(surface.srgb.copy())
        growth.end(1.2)
        shown = [picture.srgb.copy() for picture in growth.pictures()]
        again = [picture.srgb.copy() for picture in growth.pictures()]
    assert len(shown) == growth.n_pictures == 4
    bare = surface.bare_codes
    assert len(bare) == len(seen[-1]) > len(seen[1]) > len(seen[0])
    np.testing.assert_array_equal(shown[0], bare)
    np.testing.assert_array_equal(shown[1], bare)  # at .5 s nobody had looked
    np.testing.assert_array_equal(shown[2], seen[2])
    np.testing.assert_array_equal(shown[3], seen[2])
    assert (seen[2] != bare).any()
    np.testing.assert_array_equal(again, shown)


def two_balls():
    vertices, faces, normals = ball(n=24)
    bare = np.tile(np.array(BARE, np.uint8), (len(vertices), 1))
    inked = bare.copy()
    inked[normals[:, 1] < -0.8] = INK
    return (vertices, faces, normals, inked), bare


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
@pytest.mark.parametrize("light", ["studio", "none"])
def test_the_last_picture_is_the_finished_painting_s_own(light: str) -> None:
    arrays, bare = two_balls()
    shot = Shot("front", SIZE, light)
    first, last = take_film(arrays, shot, [Moment(bare), Moment(arrays[3])])
    np.testing.assert_array_equal(last, take_shot(arrays, shot))
    assert (first[36, 48].astype(int) - last[36, 48] > 60).all()
    np.testing.assert_array_equal(first[-3:], last[-3:])  # the floor stays


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
@pytest.mark.parametrize("light", ["studio", "none"])
def test_a_picture_like_the_one_before_is_not_drawn_again(light: str, monkeypatch) -> None:
    drawn: list[int] = []
    for kind in (SceneDrawing, FlatDrawing):

        def counted(drawing, *values, pixels=kind.pixels):
            drawn.append(1)
            return pixels(drawing, *values)

        monkeypatch.setattr(kind, "pixels", counted)
    arrays, bare = two_balls()
    rough = np.full(len(bare), 0.3, np.float32)
    moments = [Moment(bare.copy(), 0.0, rough), Moment(bare.copy(), 0.0, rough.copy())]
    moments += [Moment(arrays[3], 0.0, rough), Moment(bare, 0.0, rough)]
    shown = list(take_film(arrays, Shot("front", SIZE, light), moments))
    assert len(drawn) == 3
    np.testing.assert_array_equal(shown[1], shown[0])
    np.testing.assert_array_equal(shown[3], shown[0])
    assert (shown[2] != shown[0]).any()


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
def test_where_a_part_changes_a_film_looks_as_if_it_were_drawn_whole() -> None:
    arrays, bare = two_balls()
    dull = np.full(len(bare), 0.9, np.float32)
    wet = np.where(arrays[2][:, 1] < -0.8, np.float32(0.05), dull)
    shot = Shot("front", SIZE)
    moments = [Moment(bare, 0.0, dull), Moment(bare, 0.0, wet), Moment(arrays[3], 0.0, wet)]
    grown = list(take_film(arrays, shot, moments))
    for picture, moment in zip(grown, moments, strict=True):
        np.testing.assert_array_equal(picture, next(take_film(arrays, shot, [moment])))
    assert (grown[0] != grown[1]).any()


@needs_opengl
@pytest.mark.long
def test_light_between_two_places_of_a_turn_is_between() -> None:
    arrays, _ = two_balls()
    angle = 2.0 * np.pi / 8
    moments = [Moment(arrays[3], angle * share) for share in (0.0, 0.5, 1.0)]
    start, middle, end = take_film(arrays, Shot("right", SIZE), moments, n_lights=8)
    exact = list(take_film(arrays, Shot("right", SIZE), moments, n_lights=16))
    assert np.abs(middle.astype(int) - exact[1]).mean() < 2.0
    assert np.abs(start.astype(int) - exact[0]).mean() < 0.5
    assert np.abs(start.astype(int) - end).mean() > 0.5


@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
def test_films_of_either_kind_are_written_as_mp4(tmp_path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    surface = PaintedSurface(sheet(flat, (40.0, 20.0), 4.0), 1.0)
    shot = Shot("flat", (64, 32))
    with Growth(surface, 0.1) as growth:
        Painter(surface, "slender", "pine soot").replay(next(lines()))
        growth.end(0.3)
        n = write_growth(growth, tmp_path / "a.mp4", shot, Filmed(10.0))
    assert n == 5 + 10
    turning = Turning(0.5, 8.0)
    write_picture(surface, tmp_path / "b.mp4", Shot("above", (64, 48), "none"), turning)
    for name in ("a.mp4", "b.mp4"):
        assert (tmp_path / name).read_bytes()[4:8] == b"ftyp"


@needs_opengl
def test_a_film_ends_with_the_finished_painting_which_stays(tmp_path, monkeypatch) -> None:
    shown: list[np.ndarray] = []

    def keep(part, drawn, *_) -> None:
        shown.extend(np.asarray(picture) for picture in drawn)
        part.touch()

    monkeypatch.setattr(pictures, "write_film", keep)
    surface = PaintedSurface(sheet(flat, (40.0, 20.0), 4.0), 1.0)
    shot = Shot("flat", (64, 32))
    with Growth(surface, 0.1) as growth:
        Painter(surface, "slender", "pine soot").replay(next(lines()))
        growth.end(0.3)
        write_growth(growth, tmp_path / "a.webp", shot, Filmed(10.0))
    write_picture(surface, tmp_path / "now.png", shot)
    finished = np.asarray(Image.open(tmp_path / "now.png")).astype(int)
    unlike = [np.abs(picture - finished).mean() for picture in shown]
    is_finished = [off < 0.1 * unlike[0] for off in unlike]  # triangles of one colour joined
    assert is_finished == [False] * 3 + [True] * 12  # two when it ended, then held a second


@pytest.mark.long
@needs_opengl
@pytest.mark.usefixtures("lit_by_few")
def test_wet_ink_shines_in_a_film_as_in_a_picture(tmp_path) -> None:
    surface = PaintedSurface(sheet(flat, (40.0, 20.0), 4.0), 0.5, "sized xuan")
    shot = Shot("above", SIZE)
    painter = Painter(surface, "slender", "cinnabar")
    with Growth(surface, 0.5) as growth:
        for k, stroke in enumerate(lines()):
            painter.replay(stroke, wet=True)
            growth.at(0.5 * (k + 1))
        wet = growth_pictures(growth, shot)
        picture = taken(surface, shot, tmp_path)
        surface.dry()
        growth.end(1.0)
        dry = growth_pictures(growth, shot)
    still = [picture, taken(surface, shot, tmp_path)]  # whose edges are sharp
    unlike = np.array([[np.abs(a - b).mean() for b in still] for a in (wet[-1], dry[-1])])
    assert unlike[0, 0] < 0.3 * unlike[0, 1]
    assert unlike[1, 1] < 0.3 * unlike[1, 0]


def test_a_film_shows_bare_glaze_as_smooth_as_a_picture_does() -> None:
    surface = PaintedSurface(sheet(flat, (40.0, 20.0), 4.0), None, "porcelain")
    with Growth(surface, 0.5) as growth:
        column = surface.column_of(load_pigment("pine soot"))
        surface.ink.amounts[:5, column], surface.ink.coverage[:5] = 3.0, 1.0
        surface.touch(np.arange(5, dtype=np.int32))
        surface.refresh()
        growth.end(1.0)
        shown = [picture.roughness.copy() for picture in growth.pictures()]
    glaze = Gloss.of("porcelain").seen_roughness
    np.testing.assert_allclose(shown[0], glaze, atol=0.002)
    np.testing.assert_allclose(shown[-1][5:], glaze, atol=0.002)
    np.testing.assert_allclose(shown[-1][:5], MATT_ROUGHNESS, atol=0.002)


def growth_pictures(growth: Growth, shot: Shot) -> list[np.ndarray]:
    surface = growth.surface
    ids = surface.paint_mesh.source_order()
    moments = (Moment(p.srgb[ids], 0.0, p.roughness[ids]) for p in growth.pictures())
    arrays = surface.export_arrays(None)
    drawn = take_film(arrays, shot, moments, Gloss.of(surface.material))
    return [pixels.astype(int) for pixels in drawn]


def taken(surface: PaintedSurface, shot: Shot, folder) -> np.ndarray:
    write_picture(surface, folder / "now.png", shot)
    return np.asarray(Image.open(folder / "now.png").convert("RGB")).astype(int)


def test_the_floor_stays_below_what_turns_about_another_axis() -> None:
    mesh = sheet(flat, (40.0, 20.0), 4.0)
    occluder = Occluder(mesh.vertices, mesh.faces)
    c, s = np.cos(0.5), np.sin(0.5)
    upright = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    assert occluder.turned(upright).lowest == occluder.lowest
    leaning = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    lowest = (mesh.vertices @ leaning.T)[:, 2].min()
    assert occluder.turned(leaning).lowest == pytest.approx(lowest, abs=0.5)
