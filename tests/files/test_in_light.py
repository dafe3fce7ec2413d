"""Pictures and exports in another light and on wider screens, and what is clipped is told."""

import io
import logging

import numpy as np
import pytest
from PIL import Image, ImageCms

import paint3d
from paint3d.cli import main
from paint3d.colour.pigments import load_pigment
from paint3d.colour.spectra import WAVELENGTHS, decode_srgb, srgb_from_linear, srgb_from_reflectance
from paint3d.colour.viewing import Viewing, linear_srgb_of
from paint3d.errors import ExportError, InputError
from paint3d.files.colour_tags import icc_profile
from paint3d.files.export import export
from paint3d.files.export_options import ExportOptions
from paint3d.files.load import load_mesh
from paint3d.files.pictures import Turning, write_picture
from paint3d.files.project.painting import warn_of_clipping
from paint3d.files.project.session import Session, save_session
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.shot import Shot

PLANE = load_mesh("plane")


def painted(
    ink="verdigris", coats=0.5, layered=False, own_colours=False, share=1.0
) -> PaintedSurface:
    mesh = PLANE
    if own_colours:
        codes = np.full((mesh.n_vertices, 3), (220, 200, 180), np.uint8)
        mesh = paint3d.TriangleMesh(mesh.vertices, mesh.faces, codes)
    surface = PaintedSurface(mesh, resolution=None, material="xuan")
    lay(surface, ink, coats, slice(0, None, 2), share)
    if layered:
        surface.dry()
        surface.use_layers().add("above", 1)
        lay(surface, "carmine", 0.3, slice(0, None, 3), 0.7)
    return surface


def lay(surface, ink, coats, which, share=1.0) -> None:
    column = surface.column_of(load_pigment(ink))
    ids = np.arange(surface.n_vertices, dtype=np.int32)[which]
    surface.ink.amounts[ids, column] = coats * share
    surface.ink.coverage[ids] = share
    surface.touch(ids)


@pytest.mark.parametrize("own_colours", [False, True])
@pytest.mark.parametrize("layered", [False, True])
def test_the_spectra_of_a_surface_are_of_the_colours_that_it_shows(layered, own_colours):
    surface = painted("gamboge", 0.5, layered, own_colours, share=0.8)
    spectra = surface.spectra()
    assert spectra.shape == (surface.n_vertices, 31)
    shown, told = surface.srgb.astype(int), srgb_from_reflectance(spectra).astype(int)
    assert np.abs(shown - told).max() <= 1
    np.testing.assert_array_equal(surface.spectra([5, 2]), spectra[[5, 2]])


def test_reflectance_is_an_object_of_colour_science():
    import colour

    surface = painted()
    found = surface.reflectance([4, 7])
    assert isinstance(found, colour.MultiSpectralDistributions)
    assert found.labels == ["4", "7"]
    np.testing.assert_array_equal(found.wavelengths, WAVELENGTHS)
    np.testing.assert_array_equal(found.values.T, surface.spectra([4, 7]))
    for bad in ([-1], [surface.n_vertices]):
        with pytest.raises(InputError, match=r"vertex_ids are .*; expected 0 to"):
            surface.spectra(bad)


def test_daylight_changes_no_byte(tmp_path):
    surface = painted()
    export(surface, tmp_path / "a.ply")
    same = ExportOptions(viewing=Viewing("D65", 2, "bradford", "srgb"))
    export(surface, tmp_path / "b.ply", same)
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()


@pytest.mark.parametrize("suffix", [".ply", ".glb", ".3mf", ".p3d.txt"])
def test_an_export_has_the_colours_of_its_light(tmp_path, suffix):
    surface, viewing = painted("gamboge"), Viewing("A")
    options = ExportOptions(viewing=viewing, exact=True)
    export(surface, tmp_path / f"a{suffix}", options)
    colours = load_mesh(tmp_path / f"a{suffix}").colours
    wanted = viewing.codes(surface.spectra()).rgb[surface.paint_mesh.source_order()]
    assert np.abs(colours.astype(int) - wanted).max() <= 1
    assert np.abs(wanted.astype(int) - surface.srgb[surface.paint_mesh.source_order()]).max() > 3


def test_a_mesh_is_seen_in_another_light_by_smooth_spectra(tmp_path):
    surface = painted("gamboge")
    export(surface, tmp_path / "a.ply", ExportOptions(exact=True))
    viewing = ExportOptions(viewing=Viewing("A"))
    export(load_mesh(tmp_path / "a.ply"), tmp_path / "b.ply", viewing)
    export(surface, tmp_path / "c.ply", ExportOptions(exact=True, viewing=Viewing("A")))
    guessed, known = (load_mesh(tmp_path / f"{k}.ply").colours.astype(int) for k in "bc")
    assert 0 < np.abs(guessed - known).max() < 25


def test_what_is_clipped_is_told(tmp_path, caplog):
    n = painted().n_vertices
    for log_of, told in (("verdigris", True), ("pine soot", False)):
        caplog.clear()
        with caplog.at_level(logging.WARNING, "paint3d"):
            export(painted(log_of), tmp_path / "a.ply")
        words = [record.getMessage() for record in caplog.records]
        assert bool(words) == told
        if told:
            assert f"{(n + 1) // 2:,} of {n:,} vertices have colours outside sRGB" in words[0]


def test_a_wide_picture_says_so_and_keeps_the_colours(tmp_path):
    surface = painted(coats=0.05)
    pixels = {}
    for gamut in ("srgb", "p3", "rec2020"):
        path = tmp_path / f"{gamut}.png"
        write_picture(surface, path, Shot("flat", (64, 64)), viewing=Viewing(gamut=gamut))
        with Image.open(path) as picture:
            pixels[gamut] = np.array(picture.convert("RGB")).reshape(-1, 3)
            assert picture.info.get("icc_profile") == (
                None if gamut == "srgb" else icc_profile(gamut)
            )
        data = path.read_bytes()
        at = data.find(b"cICP")
        assert (at > 0) == (gamut != "srgb")
        if gamut != "srgb":
            number = {"p3": 12, "rec2020": 9}[gamut]
            assert list(data[at + 4 : at + 8]) == [number, 13, 0, 1]
    wide = linear_srgb_of(decode_srgb(pixels["p3"]), "p3")
    assert wide[:, 0].min() < -0.02 < decode_srgb(pixels["srgb"])[:, 0].min()
    write_picture(surface, tmp_path / "a.webp", Shot("flat", (64, 64)), viewing=Viewing(gamut="p3"))
    with Image.open(tmp_path / "a.webp") as picture:
        assert picture.info["icc_profile"] == icc_profile("p3")


@pytest.mark.parametrize("gamut", ["p3", "rec2020"])
def test_the_profile_is_read_by_littlecms_as_we_mean_it(gamut):
    codes = np.random.default_rng(3).integers(0, 256, (64, 3)).astype(np.uint8)
    profile = ImageCms.ImageCmsProfile(io.BytesIO(icc_profile(gamut)))
    change = ImageCms.buildTransform(profile, ImageCms.createProfile("sRGB"), "RGB", "RGB", 1)
    theirs = np.asarray(ImageCms.applyTransform(Image.fromarray(codes[None]), change))[0]
    ours = srgb_from_linear(linear_srgb_of(decode_srgb(codes), gamut))
    assert np.abs(theirs.astype(int) - ours).max() <= 2


def test_usd_keeps_what_is_outside_of_srgb(tmp_path):
    usd = pytest.importorskip("pxr.Usd")
    surface = painted(coats=0.05)
    options = ExportOptions(viewing=Viewing(gamut="rec2020"), exact=True)
    export(surface, tmp_path / "a.usdz", options)
    stage = usd.Stage.Open(str(tmp_path / "a.usdz"))
    attribute = stage.GetPrimAtPath("/Painting/Mesh").GetAttribute("primvars:displayColor")
    colours = np.array(attribute.Get())
    wanted = Viewing().linear_rgb(surface.spectra())[surface.paint_mesh.source_order()]
    np.testing.assert_allclose(colours, wanted, atol=0.02)
    assert colours.min() < -0.1


def test_what_has_no_wide_colours_is_refused(tmp_path):
    wide = ExportOptions(viewing=Viewing(gamut="p3"))
    with pytest.raises(ExportError, match=r"\.glb files cannot have gamut; expected one of"):
        export(painted(), tmp_path / "a.glb", wide)
    for form in ("gif", "mp4"):
        with pytest.raises(InputError, match=rf"a \.{form} is in sRGB; expected \.png or \.webp"):
            write_picture(painted(), tmp_path / f"a.{form}", Shot(size=(64, 64)), Turning(1.0, 2.0),
                          viewing=Viewing(gamut="p3"))  # fmt: skip


def test_a_wide_film_says_so(tmp_path):
    for gamut, profile in (("srgb", None), ("p3", icc_profile("p3"))):
        path = tmp_path / f"{gamut}.webp"
        write_picture(
            painted(),
            path,
            Shot("front", (32, 32), "none"),
            Turning(1.0, 2.0),
            viewing=Viewing(gamut=gamut),
        )
        with Image.open(path) as film:
            assert film.n_frames == 2
            assert film.info.get("icc_profile") == profile


def test_commands_take_the_light(tmp_path, capsys):
    save_session(Session(painted()), tmp_path / "a.p3d")
    saved, out = str(tmp_path / "a.p3d"), tmp_path / "a.png"
    options = ["--illuminant", "A", "--observer", "10", "--gamut", "p3"]
    flat = ["--view", "flat", "--pixels", "32x32"]
    assert main.main(["picture", saved, "--out", str(out), *flat, *options]) == 0
    assert "have colours outside Display P3" in capsys.readouterr().err
    assert out.is_file()
    assert main.main(["export", saved, str(tmp_path / "a.ply"), "--illuminant", "F11"]) == 0
    assert main.main(["export", saved, str(tmp_path / "b.ply"), "--illuminant", "nope"]) == 2
    assert "unknown illuminant 'nope'" in capsys.readouterr().err
    assert not (tmp_path / "b.ply").exists()


def test_few_clipped_colours_are_not_told_and_a_tenth_of_the_paint_is(caplog):
    for more, told in ((-1, False), (0, True)):
        surface = PaintedSurface(PLANE, resolution=None, material="xuan")
        n = 10 * (surface.n_vertices // 20)  # of them paint, and a tenth of that verdigris
        clipped = n // 10 + more
        lay(surface, "verdigris", 0.5, slice(0, clipped))
        lay(surface, "pine soot", 0.5, slice(clipped, n))
        caplog.clear()
        with caplog.at_level(logging.WARNING, "paint3d"):
            assert warn_of_clipping(surface, None) == clipped
        assert bool(caplog.records) == told
