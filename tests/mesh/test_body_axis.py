"""The axis of a body: what sticks out of it does not move it, and what is even keeps its middle."""

import math

import numpy as np
import pytest

from paint3d.files.load import BUILT_IN_OBJECTS, load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.placement import place
from tests.support.mugs import make_mug


@pytest.mark.parametrize("square", [False, True])
@pytest.mark.parametrize("degrees", [0.0, 37.0, 90.0, 180.0, 286.0])
def test_a_handle_does_not_move_the_axis(degrees, square):
    axis = make_mug(degrees, square=square, at=(7.0, -3.0)).body_axis
    assert axis == pytest.approx((7.0, -3.0), abs=0.05)


@pytest.mark.parametrize("name", [*BUILT_IN_OBJECTS, "scroll", "fan"])
def test_what_is_even_has_it_in_the_middle_of_its_box_to_the_last_bit(name):
    mesh = load_mesh(name)
    assert mesh.body_axis == tuple((0.5 * mesh.bounds.sum(axis=0)).tolist()[:2])


def test_the_front_of_a_mug_is_in_front_of_its_middle():
    surface = ClosestPoints(make_mug(0.0))
    for u in (0.25, 0.4, 0.5, 0.7, 1.0):
        turn = 2.0 * math.pi * (u - 0.5) - 0.5 * math.pi
        found = place(surface, (u, 0.2))
        outward = np.array([math.cos(turn), math.sin(turn)])
        np.testing.assert_allclose(found.origin[:2], 41.0 * outward, atol=0.1)
    assert place(surface, (0.5, 0.2), side="inside").origin[0] == pytest.approx(0.0, abs=0.1)
