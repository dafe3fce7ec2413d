"""Rotations: the same for one thing, for many, and in kernels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from paint3d.core import quaternion
from paint3d.core.arrays import dots_of, length_of, lengths_of
from paint3d.core.kernel import kernel

PARTS = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(x * x for x in q) > 0.01)
VECTORS = st.tuples(*[st.floats(-99, 99)] * 3)
QUICK = settings(max_examples=50, deadline=None)


@kernel
def _all_of_kernels(a, b, v, out):
    """What kernels make of two quaternions and a vector: (6, 4)."""
    unit = (a[0], a[1], a[2], a[3])
    out[0, 0], out[0, 1], out[0, 2] = quaternion.compiled_turn(a, v[0], v[1], v[2])
    out[1, 0], out[1, 1], out[1, 2] = quaternion.compiled_turn_back(a, v[0], v[1], v[2])
    out[2, 0], out[2, 1], out[2, 2] = quaternion.compiled_x_axis(unit)
    out[3, 0], out[3, 1], out[3, 2] = quaternion.compiled_y_axis(unit)
    out[4, 0], out[4, 1], out[4, 2] = quaternion.compiled_z_axis(unit)
    quaternion.compiled_relative(a, b, out[5])


@QUICK
@given(PARTS, PARTS, VECTORS, st.floats(0, 1))
def test_rotations_of_one_thing_are_those_of_arrays(a, b, v, fraction) -> None:
    """Products and turns to the bit; what takes sines as near as these are."""
    a, b = quaternion.normalized(a), quaternion.normalized(b)
    assert np.array_equal(quaternion.multiply(a, b), quaternion.multiply_quaternions(a, b))
    assert np.array_equal(quaternion.turn(a, v), quaternion.rotate(a, v))
    ours = np.array(quaternion.slerp_one(a, b, fraction))
    theirs = quaternion.slerp(np.array(a), np.array(b), np.float64(fraction))
    assert abs(ours @ theirs) == pytest.approx(1.0)
    rotvec = np.array(v) * 0.03
    xyzw = Rotation.from_rotvec(rotvec).as_quat()
    assert abs(np.roll(xyzw, 1) @ quaternion.turn_by(tuple(rotvec))) == pytest.approx(1.0)


@QUICK
@given(PARTS, PARTS, VECTORS)
def test_kernels_turn_as_arrays_do_to_the_bit(a, b, v) -> None:
    a, b = (np.array(quaternion.normalized(q)) for q in (a, b))
    inverse = a * [1.0, -1.0, -1.0, -1.0]
    out = np.zeros((6, 4))
    _all_of_kernels(a, b, np.array(v), out)
    assert np.array_equal(out[0, :3], quaternion.rotate(a, np.array(v)))
    assert np.array_equal(out[1, :3], quaternion.rotate(inverse, np.array(v)))
    assert np.array_equal(out[2:5, :3].T, quaternion.matrices_from_quaternions(a[None])[0])
    assert np.array_equal(out[5], quaternion.multiply_quaternions(inverse, b))


@QUICK
@given(PARTS, VECTORS)
def test_matrices_turn_as_quaternions_and_go_back(q, v) -> None:
    q = np.array(quaternion.normalized(q))
    matrix = quaternion.matrices_from_quaternions(q[None])[0]
    assert np.allclose(matrix @ v, quaternion.rotate(q, np.array(v)), atol=1e-12)
    assert np.allclose(matrix, Rotation.from_quat(np.roll(q, -1)).as_matrix(), atol=1e-14)
    assert abs(quaternion.quaternions_from_matrices(matrix[None])[0] @ q) == pytest.approx(1.0)


def test_no_matrices_are_no_quaternions() -> None:
    assert quaternion.quaternions_from_matrices(np.empty((0, 3, 3))).shape == (0, 4)


def test_one_matrix_is_one_quaternion() -> None:
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    half = np.sqrt(0.5)
    for shape in ((3, 3), (1, 3, 3), (2, 5, 3, 3)):
        found = quaternion.quaternions_from_matrices(np.broadcast_to(turn, shape))
        expected = np.broadcast_to([half, 0.0, 0.0, half], (*shape[:-2], 4))
        np.testing.assert_allclose(found, expected, atol=1e-15)


# -- arithmetic that is written out ------------------------------------------------------------


@pytest.mark.parametrize("shape", [(0, 3), (1, 3), (200, 3), (7, 5, 4), (3,)])
def test_lengths_are_numpys_to_the_bit(shape) -> None:
    vectors = np.random.default_rng(3).normal(0.0, 40.0, shape)
    np.testing.assert_array_equal(lengths_of(vectors), np.linalg.norm(vectors, axis=-1))
    for vector in vectors.reshape(-1, shape[-1]):
        assert length_of(vector) == np.linalg.norm(vector)


@pytest.mark.parametrize("shape", [(0, 3), (200, 3), (7, 5, 4), (50, 1), (4,)])
def test_scalar_products_are_numpys_sums_to_the_bit(shape) -> None:
    chance = np.random.default_rng(4)
    u, v = chance.normal(0.0, 40.0, shape), chance.normal(0.0, 1e-3, shape)
    np.testing.assert_array_equal(dots_of(u, v), np.sum(u * v, axis=-1))
