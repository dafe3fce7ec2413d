"""Spectra to sRGB, against colour-science."""

from __future__ import annotations

import warnings
from importlib.resources import files

import numpy as np
import pytest

from paint3d.colour import spectra
from paint3d.colour.difference import delta_e, lab_from_linear_rgb, lab_from_srgb, lab_from_xyz
from paint3d.colour.pigments import load_palette
from paint3d.errors import InputError


@pytest.fixture(scope="module")
def colour():
    """colour-science, which takes seconds to import: only where these tests run."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour
    return colour


def masstones():
    ratio = np.array([p.K / np.maximum(p.S, 1e-9) for p in load_palette().values()])
    return 1 / (1 + ratio + np.sqrt(ratio**2 + 2 * ratio))


def test_perfect_reflector_is_white_and_darkness_black():
    np.testing.assert_allclose(spectra.linear_rgb_from_reflectance(np.ones(31)), 1, atol=1e-12)
    assert spectra.srgb_from_reflectance(np.ones(31)).tolist() == [255, 255, 255]
    assert spectra.srgb_from_reflectance(np.zeros(31)).tolist() == [0, 0, 0]


def test_xyz_agrees_with_colour_science(colour):
    daylight = colour.SDS_ILLUMINANTS["D65"]
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    films = masstones()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theirs = [
            colour.sd_to_XYZ(
                colour.SpectralDistribution(film, spectra.WAVELENGTHS), observer, daylight
            )
            for film in films
        ]
    ours = spectra.xyz_from_reflectance(films)
    apart = delta_e(lab_from_xyz(ours), lab_from_xyz(np.array(theirs) / 100))
    assert apart.mean() < 0.15
    assert apart.max() < 0.5


def test_observer_table_is_the_cie_table(colour):
    shape = colour.SpectralShape(400, 700, 10)
    path = files("paint3d.colour").joinpath("data", "observer.csv")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    np.testing.assert_allclose(table[:, 1:4], observer.values, rtol=1e-8)


def test_matrix_agrees_with_the_standard(colour):
    srgb = colour.RGB_COLOURSPACES["sRGB"]
    computed = colour.normalised_primary_matrix(srgb.primaries, srgb.whitepoint)
    np.testing.assert_allclose(np.linalg.inv(spectra.RGB_FROM_XYZ), computed, atol=1e-12)
    printed_to_four_digits = srgb.matrix_XYZ_to_RGB
    np.testing.assert_allclose(spectra.RGB_FROM_XYZ, printed_to_four_digits, atol=5e-4)


def test_transfer_function_agrees_and_inverts(colour):
    linear = np.linspace(0, 1, 4001)
    theirs = colour.cctf_encoding(linear, function="sRGB")
    np.testing.assert_allclose(spectra.encode_srgb(linear), theirs, atol=1e-12)
    codes = np.arange(256, dtype=np.uint8)
    assert (spectra.srgb_from_linear(spectra.decode_srgb(codes)) == codes).all()
    np.testing.assert_allclose(spectra.encode_srgb(-linear), -theirs, atol=1e-12)


def test_out_of_gamut_goes_to_the_border():
    assert spectra.srgb_from_linear([[-0.2, 0.5, 1.3]]).tolist() == [[0, 188, 255]]


@pytest.mark.parametrize("bad", [np.ones(30), np.full(31, np.nan), 0.5, ["a"] * 31])
def test_wrong_spectra_are_refused(bad):
    with pytest.raises(InputError, match="spectra"):
        spectra.xyz_from_reflectance(bad)


def test_decode_refuses_integers_of_unknown_range():
    with pytest.raises(InputError, match="int64"):
        spectra.decode_srgb(np.array([255]))


# -- differences of colours --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("one", "two", "expected"),
    [
        ((50, 2.6772, -79.7751), (50, 0, -82.7485), 2.0425),
        ((50, 2.49, -0.001), (50, -2.49, 0.0011), 7.2195),
        ((50, 2.49, -0.001), (50, -2.49, 0.0009), 7.1792),
        ((50, 2.5, 0), (73, 25, -18), 27.1492),
        ((2.0776, 0.0795, -1.135), (0.9033, -0.0636, -0.5514), 0.9082),
    ],
)
def test_pairs_of_sharma_wu_and_dalal(one, two, expected):
    assert delta_e(one, two) == pytest.approx(expected, abs=5e-5)
    assert delta_e(two, one) == pytest.approx(expected, abs=5e-5)


def test_agrees_with_colour_science_on_random_pairs(colour):
    rng = np.random.default_rng(5)
    one = rng.uniform([0, -100, -100], [100, 100, 100], (5000, 3))
    two = one + rng.normal(0, 1, one.shape) * rng.choice([0.1, 3, 40], (5000, 1))
    one[:20, 1:] = 0.0
    theirs = colour.delta_E(one, two, method="CIE 2000")
    np.testing.assert_allclose(delta_e(one, two), theirs, atol=1e-9)


def test_same_colour_has_no_difference():
    lab = np.array([[0.0, 0, 0], [50, 0, 0], [60, -40, 20]])
    assert (delta_e(lab, lab) == 0).all()


def test_lab_agrees_with_colour_science(colour):
    xyz = np.random.default_rng(1).uniform(0, 1, (200, 3))
    theirs = colour.XYZ_to_Lab(xyz, illuminant=(0.3127, 0.3290))
    np.testing.assert_allclose(lab_from_xyz(xyz), theirs, atol=1e-9)


def test_white_is_lightness_100():
    np.testing.assert_allclose(lab_from_linear_rgb([1.0, 1, 1]), [100, 0, 0], atol=1e-9)
    np.testing.assert_allclose(lab_from_srgb(np.full(3, 255, np.uint8)), [100, 0, 0], atol=1e-9)
