"""Wet paint in files and pictures: smoother and darker than dry, and nothing where all is dry."""

from __future__ import annotations

import dataclasses
import json
import runpy
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from scipy.ndimage import binary_erosion
from scipy.spatial import cKDTree

import paint3d
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import WATER, load_pigment
from paint3d.colour.spectra import decode_srgb, encode_srgb
from paint3d.colour.viewing import Viewing
from paint3d.colour.wet_look import MATT_ROUGHNESS, darkened
from paint3d.files.export import export, gloss_of
from paint3d.files.export_options import ExportOptions
from paint3d.files.load import load_mesh
from paint3d.files.pictures import write_picture
from paint3d.files.project.painting import Painting, read_painting
from paint3d.files.project.session import Session, load_session, save_session
from paint3d.files.reading import ReadOptions, read_surface_apart
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.shot import Shot
from paint3d.view.studio import Gloss

SCRIPT = runpy.run_path(str(Path(__file__).parents[2] / "scripts" / "validate_exports.py"))

UPRIGHT = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # of glTF's axes, to ours


def ball(ink="cinnabar", material="sized xuan"):
    """A ball with a patch of ink on the side that is looked at."""
    solid = trimesh.creation.icosphere(subdivisions=4, radius=10.0)
    mesh = TriangleMesh(np.float32(solid.vertices), np.int32(solid.faces))
    surface = PaintedSurface(mesh, None, material=material)
    return inked(surface, ink)


def inked(surface, ink):
    column = surface.column_of(load_pigment(ink))
    front = surface.paint_mesh.vertices @ np.array([-0.4, -0.8, 0.45]) > 6.0
    ids = np.flatnonzero(front).astype(np.int32)
    surface.ink.amounts[ids, column] = 2.0
    surface.ink.coverage[ids] = 1.0
    surface.touch(ids)
    return surface


@pytest.fixture(scope="module")
def wet():
    surface = ball()
    surface.diffuse(0.1)
    return surface


def test_what_is_dry_has_no_look_of_its_own():
    surface = ball()
    assert surface.wet_look is None  # no time has passed: nothing is known of water
    surface.diffuse(0.1)
    assert surface.wet_look is not None
    surface.dry()
    assert surface.wet_look is None
    assert read_painting(surface, ExportOptions()).look is None


def test_a_film_is_smooth_and_dark_and_the_rest_as_the_material(wet):
    look, inked_there = wet.wet_look, wet.coverage > 0.5
    rough = look.roughness(wet.material.roughness)
    assert rough[inked_there].max() < 0.15
    assert (rough[look.damp == 0.0] == np.float32(wet.material.roughness)).all()
    painting = read_painting(wet, ExportOptions(exact=True))
    dry, shown = painting.srgb.astype(int), painting.shown_srgb.astype(int)
    assert (shown <= dry).all()
    assert (shown[painting.look.damp == 0.0] == dry[painting.look.damp == 0.0]).all()
    assert (dry - shown)[painting.look.damp > 0.9, 0].min() > 15


def test_clear_water_keeps_its_outline_though_its_colours_are_the_papers():
    """Vertices that only water tells apart stay, when triangles of one colour are joined."""
    surface = PaintedSurface(paint3d.load_mesh("plane"), 1.0, "xuan")
    surface.refine_all()
    column = surface.column_of(WATER)
    near = np.linalg.norm(surface.paint_mesh.vertices[:, :2], axis=1) < 15.0
    ids = np.flatnonzero(near).astype(np.int32)
    surface.ink.amounts[ids, column] = 2.0
    surface.ink.coverage[ids] = 1.0
    surface.touch(ids)
    surface.diffuse(0.1)
    painting = read_painting(surface, ExportOptions())
    assert len(painting.vertices) < surface.n_vertices // 10
    corners = painting.vertices[painting.faces]
    two_sides = corners[:, 1:] - corners[:, :1]
    areas = 0.5 * np.linalg.norm(np.cross(two_sides[:, 0], two_sides[:, 1]), axis=1)
    damp = painting.look.damp[painting.faces].mean(axis=1) @ areas
    assert damp == pytest.approx(np.pi * 15.0**2, rel=0.05)


@pytest.mark.parametrize(("dry", "wet"), [(0.75, 0.61), (0.55, 0.39)])
def test_under_water_a_surface_reflects_what_lekner_and_dorf_say(dry, wet):
    codes = np.rint(255.0 * encode_srgb(np.full((1, 3), dry))).astype(np.uint8)
    seen = decode_srgb(darkened(codes, np.ones(1)))
    np.testing.assert_allclose(seen, wet, atol=0.012)  # two codes


def test_raw_paper_gets_dark_and_stays_matt():
    surface = ball(material="xuan")
    surface.diffuse(1.0)
    look = surface.wet_look
    assert look.damp.max() > 0.3
    assert look.film.max() == 0.0


def test_oil_soot_dries_glossier_than_pine_soot():
    pine, oil = ball("pine soot", "xuan"), ball("oil soot", "xuan")
    for surface in (pine, oil):
        surface.dry()
    assert pine.wet_look is None
    rough = oil.wet_look.roughness(0.95)
    there = oil.painted_coverage() > 0.5
    assert rough[there].max() < 0.75
    assert (rough[~there] == np.float32(0.95)).all()


def test_on_glaze_ink_is_glossy_while_wet_and_matt_when_dry(tmp_path):
    """Pine soot hides the glaze, oil soot keeps some gloss, a thin wash most of the glaze's."""
    pine, oil = ball("pine soot", "porcelain"), ball("oil soot", "porcelain")
    there, glaze = pine.coverage > 0.5, pine.material.roughness
    pine.diffuse(0.1)
    assert pine.wet_look.roughness(glaze)[there].max() < glaze
    pine.dry()
    rough = pine.wet_look.roughness(glaze)
    assert rough[there].min() > MATT_ROUGHNESS - 0.01
    assert (rough[pine.painted_coverage() == 0.0] == np.float32(glaze)).all()
    between = oil.wet_look.roughness(glaze)[there]
    assert glaze + 0.1 < between.min()
    assert between.max() < MATT_ROUGHNESS - 0.1
    thin = ball("pine soot", "porcelain")
    thin.ink.amounts[there] *= 0.05
    assert thin.wet_look.roughness(glaze)[there].max() < 0.5 * (glaze + MATT_ROUGHNESS)
    export(pine, tmp_path / "dry.glb", ExportOptions(exact=True))
    (read,) = trimesh.load(tmp_path / "dry.glb", process=False).geometry.values()
    again = read_surface_apart(tmp_path / "dry.glb", ReadOptions(texture=True))
    assert again.notes == ("left out: the gloss of its ink (a painting, .p3d, keeps it)",)
    picture = np.asarray(read.visual.material.metallicRoughnessTexture.convert("RGB"))
    found = picture[0, np.rint(read.visual.uv[:, 0] * 256.0 - 0.5).astype(int), 1] / 255.0
    assert picture.shape == (1, 256, 3)
    assert picture[0, :, 1].tolist() == list(range(256))
    assert found.max() == pytest.approx(MATT_ROUGHNESS, abs=0.005)
    assert read.visual.vertex_attributes["color"].shape == (len(read.vertices), 4)


def test_a_picture_shows_the_lamps_in_wet_ink_on_glaze_but_not_in_dry(tmp_path):
    surface, seen = ball("pine soot", "porcelain"), []
    for change in (lambda: surface.diffuse(0.1), surface.dry):
        change()
        write_picture(surface, tmp_path / "a.png", Shot(size=(160, 160), view="front"))
        seen.append(np.asarray(Image.open(tmp_path / "a.png").convert("L"), float))
        (tmp_path / "a.png").unlink()
    wet, dry = seen
    black = binary_erosion(dry < 100.0, iterations=2)
    assert black.sum() > 1000
    assert (wet - dry)[black].max() > 15.0  # a lamp


def test_dry_and_wet_coats_hide_together():
    surface = ball("pine soot", "porcelain")
    there = surface.coverage > 0.5
    surface.ink.amounts[there] *= 0.05
    surface.dry()
    inked(surface, "pine soot")
    surface.ink.amounts[there] *= 0.1
    np.testing.assert_allclose(surface.wet_look.hidden[there], 1.0 - np.exp(-0.9), rtol=1e-3)


def test_ink_of_every_visible_layer_dulls_the_glaze():
    surface = ball("pine soot", "porcelain")
    there, stack = surface.coverage > 0.5, surface.use_layers()
    alone = surface.wet_look.hidden
    stack.add("2", 1)
    np.testing.assert_array_equal(surface.wet_look.hidden, alone)
    stack.set_properties(0, visible=False)
    surface.touch(stack.painted_ids())
    assert surface.wet_look.hidden[there].max() == 0.0


def textured(surface, path, **options):
    """An object in a texture as trimesh reads it, its material, its pictures at the vertices."""
    pytest.importorskip("xatlas")
    export(surface, path, ExportOptions(texture=1024, **options))
    read = trimesh.load(path, process=False, force="mesh")
    look = read.visual.material
    pictures = []
    for picture in (look.baseColorTexture, look.metallicRoughnessTexture):
        if picture is not None:
            width, height = picture.size
            at = read.visual.uv * (width, -height) + (0.0, height)
            x, y = np.clip(at.astype(int).T, 0, [[width - 1], [height - 1]])
            pictures.append(np.asarray(picture.convert("RGB"))[y, x])
    return read, look, pictures


def test_a_texture_says_how_rough_and_dark_it_is_where_it_is_wet(wet, tmp_path):
    read, look, (colours, rough) = textured(wet, tmp_path / "wet.glb")
    _, nearest = cKDTree(wet.paint_mesh.vertices).query(1000.0 * read.vertices @ UPRIGHT)
    wanted = wet.wet_look.roughness(wet.material.roughness)[nearest]
    assert np.abs(rough[:, 1] / 255.0 - wanted).mean() < 0.01
    assert rough[:, 2].max() == 0  # no metal
    assert look.roughnessFactor == 1.0
    shown = wet.wet_look.seen(wet.srgb)[nearest].astype(int)
    assert np.abs(colours - shown).mean() < 2.0
    assert np.abs(colours - wet.srgb[nearest].astype(int)).mean() > 3.0


def test_a_texture_says_how_rough_dry_ink_on_glaze_is(tmp_path):
    surface = ball("pine soot", "porcelain")
    read, _, (_, rough) = textured(surface, tmp_path / "dry.glb")
    _, nearest = cKDTree(surface.paint_mesh.vertices).query(1000.0 * read.vertices @ UPRIGHT)
    found, is_inked = rough[:, 1] / 255.0, surface.coverage[nearest] > 0.0
    assert np.median(found[is_inked]) == pytest.approx(MATT_ROUGHNESS, abs=0.005)
    glaze = gloss_of(read_painting(surface, ExportOptions())).roughness
    assert np.median(found[~is_inked]) == pytest.approx(glaze, abs=0.005)


def test_a_dry_texture_has_one_roughness_and_an_unlit_one_none(wet, tmp_path):
    for surface, options in ((ball(), {}), (wet, {"unlit": True})):
        _, look, _ = textured(surface, tmp_path / "plain.glb", **options)
        assert look.metallicRoughnessTexture is None
        assert look.roughnessFactor == pytest.approx(surface.material.roughness)


def test_gltf_says_how_rough_each_vertex_is(wet, tmp_path):
    export(wet, tmp_path / "wet.glb", ExportOptions(exact=True))
    read = trimesh.load(tmp_path / "wet.glb", process=False, force="mesh")
    picture = np.asarray(read.visual.material.metallicRoughnessTexture.convert("RGB"))
    u = read.visual.uv[:, 0]
    found = picture[0, np.rint(u * 256.0 - 0.5).astype(int), 1] / 255.0
    painting = read_painting(wet, ExportOptions(exact=True))
    wanted = painting.look.roughness(wet.material.roughness)
    np.testing.assert_allclose(found, wanted, atol=0.003)
    assert picture[..., 2].max() == 0  # no metal
    assert read.visual.material.roughnessFactor == 1.0


def test_khronos_validator_finds_nothing(wet, tmp_path):
    export(wet, tmp_path / "wet.glb")
    try:
        assert SCRIPT["gltf_validator"](tmp_path) == []
    except SCRIPT["MissingToolError"] as missing:
        pytest.skip(f"not here: {missing}")


def test_usd_says_how_rough_each_vertex_is(wet, tmp_path):
    usd = pytest.importorskip("pxr.Usd")
    from pxr import UsdGeom, UsdShade

    export(wet, tmp_path / "wet.usdz", ExportOptions(exact=True))
    stage = usd.Stage.Open(str(tmp_path / "wet.usdz"))
    prim = stage.GetPrimAtPath("/Painting/Mesh")
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("roughness")
    assert primvar.GetInterpolation() == "vertex"
    painting = read_painting(wet, ExportOptions(exact=True))
    wanted = painting.look.roughness(wet.material.roughness)
    np.testing.assert_array_equal(np.array(primvar.Get()), wanted)
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
    surface = material.ComputeSurfaceSource()[0]
    source = surface.GetInput("roughness").GetConnectedSources()[0][0].source
    reader = UsdShade.Shader(source.GetPrim())
    assert reader.GetShaderId() == "UsdPrimvarReader_float"
    assert reader.GetInput("varname").Get() == "roughness"
    try:
        assert [p for p in SCRIPT["CHECKS"]["usd"](tmp_path) if "wet" in p] == []
    except (SCRIPT["MissingToolError"], KeyError) as missing:
        pytest.skip(f"not here: {missing}")


def test_a_wet_spot_mirrors_the_lamps_in_a_picture(wet, tmp_path):
    shot = Shot(size=(120, 120), view="front")
    write_picture(wet, tmp_path / "wet.png", shot)
    dry = ball()
    write_picture(dry, tmp_path / "dry.png", shot)
    one, two = (
        np.asarray(Image.open(tmp_path / f"{n}.png").convert("RGB"), float) for n in ("wet", "dry")
    )
    spot = two[..., 0] - two[..., 2] > 60.0  # vermilion
    assert spot.sum() > 1000
    assert np.median(one[spot, 0]) < np.median(two[spot, 0]) - 10.0  # darker,
    assert np.percentile(one[spot, 2], 99) > np.percentile(two[spot, 2], 99) + 30.0  # and it shines


def test_the_gloss_of_another_material_is_that_of_its_dry_parts(wet):
    painting = read_painting(wet, ExportOptions(exact=True))
    glazed = gloss_of(painting, Gloss.of("porcelain"))
    assert glazed.coat == Gloss.of("porcelain").coat
    dry = painting.look.damp == 0.0
    assert (glazed.each[dry] == np.float32(Gloss.of("porcelain").seen_roughness)).all()
    assert glazed.each[~dry].min() < 0.1


def test_dry_ink_is_matt_on_a_glaze_over_what_is_rough(tmp_path):
    """Its body was asked how rough it is, not its glaze, and the ink mirrored the lamps."""
    porcelain, seen = load_material("porcelain"), []
    for name, roughness in (("porcelain", porcelain.roughness), ("my own", 0.9)):
        surface = ball("pine soot", dataclasses.replace(porcelain, name=name, roughness=roughness))
        watch = surface.watch_wet()
        watch.follow(np.arange(surface.n_vertices, dtype=np.int32))
        assert not watch.is_plain  # in the window
        write_picture(surface, tmp_path / "dry.png", Shot(size=(120, 120), view="front"))
        seen.append(np.asarray(Image.open(tmp_path / "dry.png").convert("L"), float))
    black = binary_erosion(seen[0] < 100.0, iterations=2)
    assert black.sum() > 500
    np.testing.assert_allclose(seen[1][black], seen[0][black], atol=6.0)


@pytest.mark.parametrize(
    "viewing", [pytest.param(None, marks=pytest.mark.long), Viewing(gamut="p3")]
)
def test_dry_ink_is_matt_on_the_glaze_of_another_material(viewing, tmp_path):
    """Painted on paper it is as rough as that; shown on porcelain it mirrored the lamps."""
    surface, seen = ball("pine soot"), []
    assert surface.wet_look is None
    for name, on in (("own", ball("pine soot", "porcelain")), ("other", surface)):
        shot, path = Shot(size=(120, 120), view="front"), tmp_path / f"{name}.png"
        write_picture(on, path, shot, material="porcelain", viewing=viewing)
        seen.append(np.asarray(Image.open(path).convert("L"), float))
    black = binary_erosion(seen[0] < 100.0, iterations=2)
    assert black.sum() > 500
    np.testing.assert_allclose(seen[1][black], seen[0][black], atol=2.0)


def test_another_light_keeps_what_is_wet(wet, tmp_path):
    painting = read_painting(wet, ExportOptions(viewing=Viewing(gamut="p3")))
    assert painting.look is not None
    assert painting.gamut == "p3"
    assert (painting.shown_srgb < painting.srgb).any()


# -- materials of one's own --------------------------------------------------------------------


LACQUER = dataclasses.replace(
    load_material("porcelain"), name="lacquer", roughness=0.37, coat=0.4, tooth_mm=0.0
)


def test_pictures_of_it_shine_so(tmp_path: Path) -> None:
    save_session(Session(PaintedSurface(load_mesh("plane"), 20.0, LACQUER)), tmp_path / "a.p3d")
    read = read_painting(load_session(tmp_path / "a.p3d").surface, ExportOptions())
    assert isinstance(read, Painting)
    assert gloss_of(read) == Gloss(0.37, 0.4)
    bare = read_painting(load_mesh("plane"), ExportOptions())
    assert isinstance(bare, Painting)
    assert gloss_of(bare) is None


def test_those_of_the_program_shine_in_pictures_as_before() -> None:
    for name, gloss in (
        ("porcelain", Gloss(0.3, 0.9)),
        ("xuan", Gloss(0.95, 0.0, paper=(1.0, 1.0))),
    ):
        assert Gloss.of(name) == Gloss.of(load_material(name)) == gloss
    silk = load_material("silk")
    assert Gloss.of("silk") == Gloss(silk.roughness, silk.coat)
    assert Gloss.of(LACQUER) == Gloss(0.37, 0.4)


@pytest.mark.parametrize("texture", [None, 64])
def test_a_glb_is_as_rough(tmp_path: Path, texture: int | None) -> None:
    if texture is not None:
        pytest.importorskip("xatlas")
    surface = PaintedSurface(load_mesh("plane"), 20.0, LACQUER)
    export(surface, tmp_path / "a.glb", options=ExportOptions(texture=texture or False))
    data = (tmp_path / "a.glb").read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    assert document["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] == 0.37
