"""Filters along an axis: what SciPy gives, to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from paint3d.core.filters import gaussian_filter1d, maximum_filter1d, median, minimum_filter1d

CASES = [((7,), 0), ((400,), 0), ((60, 2), 0), ((33, 41), 1), ((5, 3, 2), 0)]


def values_of(shape: tuple[int, ...]) -> np.ndarray:
    return np.random.default_rng(5).normal(size=shape).cumsum(axis=0)


@pytest.mark.parametrize(("shape", "axis"), CASES)
@pytest.mark.parametrize("mode", ["nearest", "reflect"])
@pytest.mark.parametrize(("sigma", "truncate"), [(0.3, 4.0), (1.5, 2.0), (3, 4.0), (11.7, 4.0)])
def test_gaussians_are_scipys(shape, axis, mode, sigma, truncate) -> None:
    values = values_of(shape)
    found = gaussian_filter1d(values, sigma, axis, mode, truncate)
    expected = ndimage.gaussian_filter1d(values, sigma, axis, mode=mode, truncate=truncate)
    np.testing.assert_array_equal(found, expected)
    assert found.flags.c_contiguous


@pytest.mark.parametrize(("shape", "axis"), CASES)
@pytest.mark.parametrize("mode", ["nearest", "reflect"])
@pytest.mark.parametrize("size", [1, 3, 7, 25])
def test_extremes_are_scipys(shape, axis, mode, size) -> None:
    values = values_of(shape)
    for ours, theirs in (
        (minimum_filter1d, ndimage.minimum_filter1d),
        (maximum_filter1d, ndimage.maximum_filter1d),
    ):
        np.testing.assert_array_equal(
            ours(values, size, axis, mode), theirs(values, size, axis, mode=mode)
        )


@pytest.mark.parametrize("count", [1, 2, 3, 8, 101, 1000])
def test_the_median_is_numpys_to_the_bit(count: int) -> None:
    values = np.random.default_rng(count).normal(size=count) ** 3
    assert median(values) == np.median(values)
    assert median(np.round(values)) == np.median(np.round(values)), "with equal ones"
