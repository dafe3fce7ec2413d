"""Paint in other lights, by other observers and on wider screens, against colour-science."""

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.cli import main
from paint3d.colour.difference import (
    compare_spectra,
    delta_e,
    lab_from_reflectance,
    lab_from_srgb,
    lab_from_xyz,
)
from paint3d.colour.illuminants import FINE_NM, OBSERVERS, find_illuminant
from paint3d.colour.inks import keep_ink, kept_inks, load_ink
from paint3d.colour.layers import mixture_reflectance
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import WATER, load_palette, load_pigment
from paint3d.colour.spectra import N_BANDS, WAVELENGTHS, decode_srgb, srgb_from_reflectance
from paint3d.colour.viewing import GAMUTS, Viewing, linear_srgb_of
from paint3d.errors import InputError, PigmentError, UnknownNameError

GROUND = load_material("porcelain").reflectance
FILMS = np.array([mixture_reflectance({p: 1.0}, 0.4, GROUND) for p in load_palette().values()])
WHITE = np.ones((1, N_BANDS))
# colour-science is imported by what uses it: that takes a second, in each process that collects
RESOURCES = Path(find_spec("colour").origin).parent / "io" / "tests" / "resources"


def by_colour_science_xyz(spectra, illuminant, observer):
    """XYZ of white and of spectra, by somebody else's sums."""
    import colour

    shape = colour.SpectralShape(360, 830, 1)
    seen = colour.MSDS_CMFS[OBSERVERS[observer]].copy().align(shape)
    light = colour.SDS_ILLUMINANTS[illuminant].copy()
    light = light.align(shape, interpolator=colour.LinearInterpolator)
    fine = [np.interp(FINE_NM, WAVELENGTHS, r) for r in [np.ones(N_BANDS), *spectra]]
    xyz = colour.msds_to_XYZ(
        colour.MultiSpectralDistributions(np.array(fine).T, FINE_NM), seen, light,
        method="Integration",
    )  # fmt: skip
    return xyz / 100.0


def by_colour_science(spectra, illuminant, observer, transform):
    """Linear sRGB of spectra, by somebody else's sums, adaptation and matrix."""
    import colour

    xyz = by_colour_science_xyz(spectra, illuminant, observer)
    if transform:
        display = colour.xy_to_XYZ((0.3127, 0.3290))
        adapt = colour.adaptation.chromatic_adaptation_VonKries
        xyz = adapt(xyz, xyz[0], display, transform=transform)
    return colour.XYZ_to_RGB(xyz, "sRGB", chromatic_adaptation_transform=None)[1:]


@pytest.mark.parametrize(
    ("illuminant", "observer", "adaptation", "transform"),
    [
        ("A", 2, "cat16", "CAT16"),
        ("D50", 10, "bradford", "Bradford"),
        ("FL2", 2, "cat16", "CAT16"),
        ("LED-B3", 10, "bradford", "Bradford"),
        ("D65", 10, "cat16", "CAT16"),
        ("E", 2, "none", None),
    ],
)
def test_colours_in_a_light_are_those_of_colour_science(
    illuminant, observer, adaptation, transform
):
    ours = Viewing(illuminant, observer, adaptation).linear_rgb(FILMS)
    theirs = by_colour_science(FILMS, illuminant, observer, transform)
    if transform is None:  # as bright as fits in
        white = by_colour_science(np.ones((1, N_BANDS)), illuminant, observer, None)
        theirs = theirs / white.max()
    np.testing.assert_allclose(ours, theirs, atol=1e-3)


def test_daylight_and_two_degrees_are_what_they_always_were():
    for gamut in ("srgb",):
        seen = Viewing("d65", 2, "bradford", gamut)
        assert seen.is_plain
        np.testing.assert_array_equal(seen.codes(FILMS).rgb, srgb_from_reflectance(FILMS))


@pytest.mark.parametrize("adaptation", ["cat16", "bradford"])
@pytest.mark.parametrize("observer", [2, 10])
def test_a_white_sheet_is_white_in_every_light_that_the_eye_is_adapted_to(adaptation, observer):
    for light in ("E", "A", "D50", "F2", "F11", "LED-B3", "1850K"):
        for gamut in GAMUTS:
            seen = Viewing(light, observer, adaptation, gamut).codes(WHITE)
            assert seen.rgb.tolist() == [[255, 255, 255]]
            assert seen.n_clipped == 0


def test_without_adaptation_white_has_the_colour_of_the_light():
    red, green, blue = Viewing("A", 2, "none").codes(WHITE).rgb[0].tolist()
    assert red == 255
    assert red > green + 40 > blue + 80


@settings(deadline=None, max_examples=25)
@given(st.floats(0.02, 1.0), st.sampled_from(["A", "F11", "LED-B3"]))
def test_greys_stay_grey_and_as_light(level, light):
    linear = Viewing(light).linear_rgb(np.full((1, N_BANDS), level))
    np.testing.assert_allclose(linear, level, atol=1e-9)


def test_wider_screens_hold_what_srgb_does_not():
    films = np.array([mixture_reflectance({"verdigris": 1.0}, x, GROUND) for x in (0.05, 0.5, 1)])
    clipped = {gamut: Viewing(gamut=gamut).codes(films).n_clipped for gamut in GAMUTS}
    assert clipped == {"srgb": 3, "p3": 3, "rec2020": 0}
    wide = Viewing(gamut="rec2020").codes(films).rgb
    back = linear_srgb_of(decode_srgb(wide), "rec2020")
    np.testing.assert_allclose(back, Viewing().linear_rgb(films), atol=0.02)
    assert back.min() < -0.1


def test_a_light_from_a_file(tmp_path):
    import colour

    power = find_illuminant("F11")
    rows = "\n".join(f"{nm:g}, {p:g}" for nm, p in zip(FINE_NM, power, strict=True))
    (tmp_path / "shop.spd").write_text(f"# measured\nnm, W\n{rows}\n")
    ours = Viewing(str(tmp_path / "shop.spd")).linear_rgb(FILMS)
    np.testing.assert_allclose(ours, Viewing("F11").linear_rgb(FILMS), atol=1e-4)
    spectrum = colour.SpectralDistribution_IESTM2714(
        str(tmp_path / "shop.spdx"),
        spectral_quantity="relative",
        data=dict(zip(FINE_NM, power, strict=True)),
    )
    spectrum.write()
    ours = Viewing(str(tmp_path / "shop.spdx")).linear_rgb(FILMS)
    np.testing.assert_allclose(ours, Viewing("F11").linear_rgb(FILMS), atol=1e-4)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "holds no spectrum that is known"),
        ("400 1\n500 1\n700 1\n600 2\n", "not in rising order"),
        ("450 1\n700 1\n", "expected to cover 400 to 700"),
        ("400 -1\n700 1\n", "expected light"),
        ("400 nan\n700 1\n", "is not finite"),
        ("400 1\n500 1\n600 1\n700 x\n", ":4: '700 x'; expected a wavelength in nm and a value"),
    ],
)
def test_bad_files_of_light_are_refused_by_name(tmp_path, text, message):
    path = tmp_path / "a.spd"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        find_illuminant(str(path))
    assert str(path) in str(caught.value)


def test_what_is_not_known_is_said():
    with pytest.raises(UnknownNameError, match=r"unknown illuminant 'D56'.*D65"):
        Viewing("D56")
    with pytest.raises(InputError, match="expected 800K to 25000K"):
        Viewing("100K")
    with pytest.raises(UnknownNameError, match="observer"):
        Viewing(observer=4)
    with pytest.raises(UnknownNameError, match="adaptation"):
        Viewing(adaptation="cat97")
    with pytest.raises(UnknownNameError, match="gamut"):
        Viewing(gamut="aces")


def test_an_xml_bomb_is_no_spectrum(tmp_path):
    path = tmp_path / "a.spdx"
    path.write_text('<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>')
    with pytest.raises(InputError, match="document type"):
        find_illuminant(str(path))


def test_metamerism_of_two_inks():
    import colour

    azurite = mixture_reflectance({"azurite": 1.0}, 1.0, GROUND)
    other = mixture_reflectance({"indigo": 0.6, "lapis lazuli": 0.4}, 1.0, GROUND)
    rows = compare_spectra(azurite, other)
    assert [row.illuminant for row in rows][:3] == ["D65", "D50", "A"]
    assert rows[0].shift == pytest.approx(0.0, abs=1e-9)
    assert max(row.shift for row in rows) > 3.0
    for row in compare_spectra(azurite, azurite * 1.0):
        assert row.difference == row.shift == 0.0
    xyz = by_colour_science_xyz([azurite, other], "A", 2)
    white = colour.XYZ_to_xy(xyz[0])
    theirs = colour.delta_E(*(colour.XYZ_to_Lab(x, white) for x in xyz[1:]), method="CIE 2000")
    assert rows[2].difference == pytest.approx(float(theirs), abs=0.05)


def test_lab_is_relative_to_the_white_it_is_given():
    np.testing.assert_allclose(lab_from_xyz((0.5, 0.4, 0.3), (0.5, 0.4, 0.3)), (100.0, 0.0, 0.0))
    assert delta_e((50, 0, 0), (50, 0, 0)) == 0.0


def test_the_command_finds_the_mixture_nearest_to_a_colour(capsys):
    assert main.main(["inks", "--nearest", "#2244aa", "--material", "xuan"]) == 0
    out, err = capsys.readouterr()
    mixture = load_ink(out.strip())
    film = mixture_reflectance(mixture, 1.0, load_material("xuan").reflectance)
    shown = "#" + bytes(srgb_from_reflectance(film).tolist()).hex()
    assert shown in err
    assert 0.0 < float(err.split(", ")[1].split()[0]) < 5.0
    assert main.main(["inks", "--nearest", "blue"]) == 2
    assert "expected #RRGGBB" in capsys.readouterr().err
    assert main.main(["write", "永", "--on", "bowl", "--ink", "#2244aa", "--out", "a.glb"]) == 2
    assert "paint3d inks --nearest '#2244aa'" in capsys.readouterr().err


def test_a_colour_and_its_wash_become_an_ink_with_a_name(capsys, tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path))
    asked = ["inks", "--nearest", "#1f6f78", "--wash", "#cbe0d4", "--keep", "deep teal"]
    assert main.main(asked) == 0
    mixture = capsys.readouterr().out.strip()
    own = load_ink("deep teal")
    assert own == load_ink(mixture)
    for coats, code in ((1.0, "1f6f78"), (0.1, "cbe0d4")):
        film = mixture_reflectance(own, coats, GROUND, by_volume=True)
        wanted = lab_from_srgb(np.array(list(bytes.fromhex(code))) / 255.0)
        assert delta_e(lab_from_reflectance(film), wanted) < 5.0, code
    thin = load_ink("deep teal:1,water:3")
    assert sum(thin.values()) == pytest.approx(4.0)
    assert load_ink("light deep teal")[WATER] > 0.91
    assert main.main(["inks"]) == 0
    assert "deep teal" in capsys.readouterr().out
    with pytest.raises(UnknownNameError):
        load_ink("deep teal", own_tables=False)  # in somebody else's file
    for name in ("indigo", "Indigo", "light", "淡", "a:b", "a,b", "x.csv", " a", ""):
        assert main.main(["inks", "--ink", "ochre", "--keep", name]) == 2, name
    assert main.main(["inks", "--forget", "deep teal"]) == 0
    assert main.main(["inks", "--forget", "deep teal"]) == 2
    assert main.main(["inks", "--nearest", "#1f6f78", "--ink", "ochre"]) == 2


def test_a_list_of_kept_inks_that_cannot_be_used_says_so_and_stops_no_other_ink(
    capsys, tmp_path, monkeypatch
) -> None:
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path))
    kept = tmp_path / "inks.toml"
    for text, why in (
        ("sea = 3", "'sea' is 3; expected the parts of an ink"),
        ("sea = {indigo = 0}", "expected the parts of an ink such as {indigo = 0.8"),
        ("sea = [broken", "cannot be read as a list of inks"),
        ("sea = {bay = 1}\nbay = {sea = 1}", "unknown ink 'sea'"),
    ):
        kept.write_text(text)
        assert main.main(["inks", "--ink", "sea"]) == 2
        assert why in capsys.readouterr().err
        assert main.main(["inks", "--ink", "light indigo"]) == 0
    kept.write_text('bay = {"light indigo" = 1, sea = 1}\nsea = {indigo = 1, water = 3}')
    assert load_ink("bay")[load_pigment("indigo")] == pytest.approx(0.5 * (0.09 + 0.25))


def test_a_kept_ink_is_found_where_the_home_cannot_be_written(tmp_path, monkeypatch) -> None:
    monkeypatch.delenv("PAINT3D_CONFIG", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "home"))
    keep_ink("sea", "indigo:1,water:3")
    monkeypatch.setattr("paint3d.core.own_folders.can_write", lambda folder: False)
    monkeypatch.setattr("paint3d.core.own_folders.private_folder", lambda: tmp_path / "private")
    assert load_ink("sea")[WATER] == pytest.approx(0.75)  # of the home
    keep_ink("bay", "light sea")
    assert set(kept_inks()) == {"sea", "bay"}
    assert load_ink("bay")[WATER] > 0.9


def test_an_ink_of_a_table_is_kept_with_the_table(capsys, tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path / "config"))
    folder = tmp_path / "Ink, paper: 1"
    folder.mkdir()
    (folder / "mine.csv").write_text("name,R_400,R_700\nsea,0.3,0.1\n")
    monkeypatch.chdir(folder)
    keep_ink("bay", "mine.csv:sea:1,water:1")
    monkeypatch.chdir("/")
    assert [pigment.name for pigment in load_ink("bay")] == ["sea", "water"]
    keep_ink("pale bay", "light bay")
    assert load_ink("pale bay")[WATER] == pytest.approx(0.955)
    (folder / "mine.csv").unlink()
    assert main.main(["inks"]) == 0  # all others are listed
    assert "cannot be used" in capsys.readouterr().out


def test_the_command_compares_two_inks(capsys):
    assert main.main(["inks", "--compare", "pine soot", "oil soot", "--illuminant", "A"]) == 0
    head, row = capsys.readouterr().out.splitlines()
    assert head.endswith("dE00,metamerism_index")
    assert row.startswith("A,")
    assert len(row.split(",")) == len(head.split(","))
    assert main.main(["inks", "--compare", "pine soot", "lamp oil"]) == 2
    assert "unknown ink 'lamp oil'" in capsys.readouterr().err


def test_pigments_from_a_measured_masstone(tmp_path):
    import colour

    masstone = mixture_reflectance({"azurite": 1.0}, 20.0, np.full(N_BANDS, 0.9))
    data = dict(zip(WAVELENGTHS, masstone, strict=True))
    path = tmp_path / "blue.spdx"
    colour.SpectralDistribution_IESTM2714(
        str(path), spectral_quantity="reflectance", data=data
    ).write()
    rows = "\n".join(f"{nm:g}\t{r:.6f}" for nm, r in data.items())
    (tmp_path / "blue.txt").write_text(rows)
    (tmp_path / "blue.xml").write_bytes(path.read_bytes())  # as meters write TM-27, too
    for name in (f"{tmp_path / f'blue.{kind}'}:blue" for kind in ("spdx", "xml", "txt")):
        pigment = load_pigment(name)
        thick = mixture_reflectance({pigment: 1.0}, 20.0, np.full(N_BANDS, 0.9))
        np.testing.assert_allclose(thick, masstone, atol=0.01)
        with pytest.raises(PigmentError, match="may not name"):
            load_pigment(name, own_tables=False)
    (tmp_path / "percent.txt").write_text("400 50\n700 60\n")
    with pytest.raises(PigmentError, match="expected the reflectance of a masstone"):
        load_pigment(f"{tmp_path / 'percent.txt'}:percent")
    with pytest.raises(UnknownNameError, match="red"):
        load_pigment(f"{path}:red")


@pytest.mark.skipif(not RESOURCES.is_dir(), reason="colour-science came without its files")
def test_instruments_files_that_colour_science_reads(tmp_path):
    for name in ("RANDOM_001_02._3262K.csv", "ESPD2021_0104_231446.xls"):
        if (RESOURCES / name).is_file():
            (tmp_path / "lamp.txt").write_bytes((RESOURCES / name).read_bytes())
            seen = Viewing(str(tmp_path / "lamp.txt")).codes(WHITE)
            assert seen.rgb.tolist() == [[255, 255, 255]]


def spectrum_file(folder, power_at):
    """A file of a light from 300 to 900 nm."""
    path = folder / "light.spd"
    path.write_text("".join(f"{nm} {power_at(nm)!r}\n" for nm in range(300, 901, 10)))
    return str(path)


def test_a_light_that_nobody_sees_is_refused(tmp_path):
    with pytest.raises(InputError, match="none of its power is from 360 to 830 nm"):
        Viewing(spectrum_file(tmp_path, lambda nm: 1.0 if nm == 320 else 0.0))


@pytest.mark.parametrize("scale", [1e308, 1e-300])
def test_a_lights_unit_does_not_matter(scale, tmp_path):
    seen = Viewing(spectrum_file(tmp_path, lambda _: scale), adaptation="none")
    np.testing.assert_allclose(seen.weights, Viewing("E", adaptation="none").weights, atol=1e-9)


def test_a_light_of_one_line_adapts_as_far_as_it_can(tmp_path):
    for nm in (360, 460, 640, 830):
        light = find_illuminant.__wrapped__(
            spectrum_file(tmp_path, lambda at, nm=nm: 1.0 if at == nm else 0.0)
        )
        assert light.max() == 1.0


@pytest.mark.parametrize("arguments", [
    ["--illuminant", "A"], ["mine.csv", "--compare", "indigo", "azurite"],
])  # fmt: skip
def test_options_that_would_do_nothing_are_refused(arguments, capsys):
    assert main.main(["inks", *arguments]) == 2
    assert "--compare" in capsys.readouterr().err


def test_a_temperature_is_the_black_bodys_of_colour_science():
    import colour

    theirs = colour.sd_blackbody(2700.0, colour.SpectralShape(360, 830, 1)).values
    ours = find_illuminant("2700K")
    np.testing.assert_allclose(
        ours / ours.max(), theirs / theirs.max(), rtol=1e-3
    )  # its c2 is rounded


def test_no_more_of_a_file_is_read_than_a_spectrum_can_have(tmp_path):
    path = tmp_path / "large.spd"
    with path.open("wb") as file:
        file.truncate(1 << 38)  # without taking room on the disk
    with pytest.raises(InputError, match="is larger than 4,194,304 bytes"):
        find_illuminant(str(path))
