"""Patches of a mask: their numbers and depths are what SciPy gives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from paint3d.calligraphy.kernels.raster import fill_depths, label_patches


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
