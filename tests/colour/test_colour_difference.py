"""CIE L*a*b* and CIEDE2000, against colour-science and published pairs."""

import warnings

import numpy as np
import pytest

from paint3d.colour.difference import delta_e, lab_from_linear_rgb, lab_from_srgb, lab_from_xyz

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import colour


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


def test_agrees_with_colour_science_on_random_pairs():
    rng = np.random.default_rng(5)
    one = rng.uniform([0, -100, -100], [100, 100, 100], (5000, 3))
    two = one + rng.normal(0, 1, one.shape) * rng.choice([0.1, 3, 40], (5000, 1))
    one[:20, 1:] = 0.0
    theirs = colour.delta_E(one, two, method="CIE 2000")
    np.testing.assert_allclose(delta_e(one, two), theirs, atol=1e-9)


def test_same_colour_has_no_difference():
    lab = np.array([[0.0, 0, 0], [50, 0, 0], [60, -40, 20]])
    assert (delta_e(lab, lab) == 0).all()


def test_lab_agrees_with_colour_science():
    xyz = np.random.default_rng(1).uniform(0, 1, (200, 3))
    theirs = colour.XYZ_to_Lab(xyz, illuminant=(0.3127, 0.3290))
    np.testing.assert_allclose(lab_from_xyz(xyz), theirs, atol=1e-9)


def test_white_is_lightness_100():
    np.testing.assert_allclose(lab_from_linear_rgb([1.0, 1, 1]), [100, 0, 0], atol=1e-9)
    np.testing.assert_allclose(lab_from_srgb(np.full(3, 255, np.uint8)), [100, 0, 0], atol=1e-9)
