"""Each measure of marks, on marks that are made to be good or bad."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.triangle_mesh import TriangleMesh
from tests.support.app.marks import (
    Mark,
    Way,
    begins_and_goes_on,
    beyond,
    cut_faces,
    ink_per_mm,
    inked_share,
    largest_jump,
    largest_rise,
    off_the_way,
    stations,
    stray,
    strongest_spot,
)

SPACING = 0.1
WAY = Way([[0.0, 0.0, 0.0], [60.0, 0.0, 0.0]])


def made(
    half_width, middle=lambda x: 0.0 * x, ink=lambda x: 1.0 + 0.0 * x, ends=(0.0, 60.0)
) -> Mark:
    """A mark along x whose half width, middle and ink are functions of x."""
    x, y = np.meshgrid(
        np.arange(-10.0, 80.0, SPACING) + 0.5 * SPACING, np.arange(-20.0, 20.0, SPACING) + 0.05
    )
    x, y = x.ravel(), y.ravel()
    inside = (np.abs(y - middle(x)) < half_width(x)) & (x >= ends[0]) & (x <= ends[1])
    x, y = x[inside], y[inside]
    points = np.stack([x, y, np.zeros_like(x)], axis=1)
    return Mark(points, np.full(len(x), SPACING**2), np.ones(len(x)), ink(x))


def even(half: float):
    return lambda x: half + 0.0 * x


def test_a_straight_mark_is_as_wide_as_it_is_and_in_the_middle() -> None:
    found = stations(made(even(3.0)), WAY)
    np.testing.assert_allclose(found.width, 6.0, rtol=0.02)
    assert off_the_way(found) < 0.06
    assert largest_jump(found) < 0.1
    assert ink_per_mm(made(even(3.0)), WAY) == pytest.approx(6.0, rel=0.02)


def test_a_mark_beside_the_way_is_found_beside_it() -> None:
    found = stations(made(even(3.0), lambda x: 6.5 + 0.0 * x), WAY)
    assert off_the_way(found, 50.0) == pytest.approx(6.5, abs=0.1)
    assert off_the_way(stations(made(even(3.0), ends=(70.0, 71.0)), WAY)) == np.inf


def test_the_sides_are_those_of_the_surface() -> None:
    """On the wall of a cylinder about z, left of a way up is against its turn."""
    angle = np.linspace(0.0, 1.0, 300)
    way = Way([[50.0, 0.0, 0.0], [50.0, 0.0, 40.0]], [1.0, 0.0, 0.0])
    z = np.full(300, 20.0)
    points = np.stack([50.0 * np.cos(0.1 * angle), 50.0 * np.sin(0.1 * angle), z], axis=1)
    along, aside = way.place(points)
    np.testing.assert_allclose(along, 20.0, atol=1e-9)
    assert aside[-1] == pytest.approx(-50.0 * np.sin(0.1))


def test_a_curved_way_is_followed() -> None:
    angle = np.linspace(0.0, np.pi, 400)
    circle = np.stack([30.0 * np.cos(angle), 30.0 * np.sin(angle), 0.0 * angle], axis=1)
    way = Way(circle)
    assert way.length_mm == pytest.approx(30.0 * np.pi, rel=1e-3)
    along, aside = way.place(1.1 * circle[::50])
    np.testing.assert_allclose(along, 30.0 * angle[::50], atol=0.02)
    np.testing.assert_allclose(aside, -3.0, atol=0.02)


def test_gaps_are_not_inked() -> None:
    whole, broken = made(even(3.0)), made(lambda x: 3.0 * (np.abs(x - 30.0) > 8.0))
    assert inked_share(whole, WAY, 2.5) == 1.0
    assert inked_share(broken, WAY, 2.5) == pytest.approx(1.0 - (16.0 - 5.0) / 60.0, abs=0.01)
    aside = made(even(3.0), lambda x: 6.5 + 0.0 * x)
    assert inked_share(aside, WAY, 2.5) == 0.0
    assert inked_share(whole.where(np.zeros(len(whole.points), bool)), WAY, 2.5) == 0.0


def test_a_jump_is_measured_where_it_is() -> None:
    found = stations(made(even(2.0), lambda x: 4.0 * (x > 30.0)), WAY)
    assert largest_jump(found) == pytest.approx(4.0, abs=0.2)
    assert stray(made(even(2.0)), WAY, 2.5) == 0.0
    assert stray(made(even(2.0), lambda x: 9.0 * (x > 30.0)), WAY, 2.5) == pytest.approx(
        8.5, abs=0.2
    )


def test_ink_over_the_end_is_found() -> None:
    assert beyond(made(even(2.0)), WAY) < 0.1
    assert beyond(made(even(2.0), ends=(0.0, 63.0)), WAY) == pytest.approx(3.0, abs=0.1)


def test_a_knob_at_the_start_is_wider_than_what_follows() -> None:
    early, late = begins_and_goes_on(stations(made(even(2.5)), WAY), 35.0)
    assert early == pytest.approx(late, rel=0.02)
    knob = made(lambda x: np.where(x < 4.0, 4.0, 2.5))
    early, late = begins_and_goes_on(stations(knob, WAY), 35.0)
    assert early > 1.4 * late


def test_widths_that_fall_never_rise() -> None:
    taper = stations(made(lambda x: 4.0 * (1.0 - x / 62.0)), WAY)
    assert largest_rise(taper.width) < 0.03
    scallops = stations(made(lambda x: 4.0 - x / 20.0 + 0.5 * np.sin(x)), WAY)
    assert largest_rise(scallops.width) > 0.1
    dot = stations(made(lambda x: np.where(x > 58.0, 1.5, 4.0 * (1.0 - x / 62.0))), WAY)
    assert largest_rise(dot.width) > 0.2


def test_a_dark_drop_at_an_end_is_found() -> None:
    assert strongest_spot(made(even(3.0)), WAY, 6.0) == pytest.approx(1.0)
    drop = made(even(3.0), ink=lambda x: np.where(x > 57.0, 2.5, 1.0))
    assert strongest_spot(drop, WAY, 6.0) == pytest.approx(2.5)


def test_only_what_is_near_is_taken() -> None:
    both = Mark(*map(np.concatenate, zip(
        made(even(1.0)), made(even(1.0), lambda x: 12.0 + 0.0 * x), strict=True
    )))  # fmt: skip
    assert off_the_way(stations(both, WAY)) > 5.0
    assert off_the_way(stations(both.within(WAY, 5.0), WAY)) < 0.1
    assert off_the_way(stations(both, WAY, reach_mm=5.0)) < 0.1


def test_faces_are_cut_into_pieces_of_their_whole_area() -> None:
    vertices = np.array([[0.0, 0, 0], [2.0, 0, 0], [0, 2.0, 0]])
    cover = np.array([1.0, 0.0, 0.5])
    mark = cut_faces(vertices, np.array([[0, 1, 2]]), cover, 3.0 * cover, 4)
    assert mark.areas.sum() == pytest.approx(2.0)
    assert (mark.areas * mark.cover).sum() == pytest.approx(2.0 * 0.5)
    assert (mark.areas * mark.ink).sum() == pytest.approx(2.0 * 1.5)
    np.testing.assert_allclose(mark.cover, 1.0 - mark.points[:, 0] / 2 - mark.points[:, 1] / 4)


def test_where_the_way_leads_through_the_air_nothing_is_asked() -> None:
    """A way over the edge of a table to the floor: 20 mm on each, and 30 through the air."""
    corners = [[0, -9, 30], [20, -9, 30], [20, 9, 30], [0, 9, 30],
               [20, -9, 0], [40, -9, 0], [40, 9, 0], [20, 9, 0]]  # fmt: skip
    faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
    surface = ClosestPoints(TriangleMesh(np.array(corners, float), np.array(faces)))
    line = [[0.0, 0.0, 30.0], [20.0, 0.0, 30.0], [21.0, 0.0, 0.0], [40.0, 0.0, 0.0]]
    way = Way(line, surface=surface)
    assert way.in_the_air_mm == pytest.approx(29.0, abs=0.5)
    points = np.array([[x, y, 30.0 * (x < 20)] for x in np.arange(0.25, 40) for y in (-2, 2)])
    mark = Mark(points, *np.ones((3, len(points))))
    assert inked_share(mark, way, 2.4) == 1.0
    assert inked_share(mark.where(points[:, 0] < 20), way, 2.4) == pytest.approx(0.51, abs=0.02)
    assert inked_share(mark, Way(line), 2.4) < 0.65
    middle = stations(mark, way).middle
    assert np.isnan(middle[22:48]).all()
    assert np.abs(middle[np.isfinite(middle)]).max() < 0.1


def test_where_a_ray_leaps_past_an_edge_nothing_is_asked_though_the_surface_is_near() -> None:
    surface, laid = fold(0.0)
    line = [(x, 0.0) for x in (*np.arange(-20.0, 0.1, 0.5), *np.arange(6.0, 20.1, 0.5))]
    way = way_over(surface, laid, line)
    assert way.in_the_air_mm == 0.0
    places = laid(*np.array(line).T)
    way = Way(places, surface.find(places).normals, surface=surface, leap_mm=3.0)
    assert way.in_the_air_mm == pytest.approx(6.0, abs=0.6)
    whole = band(laid, -2.4, 2.4)
    bare = whole.where((whole.points[:, 0] < 0.0) | (whole.points[:, 0] > 6.0))
    assert inked_share(bare, way, 2.4) == 1.0
    assert np.isnan(stations(bare, way).middle[21:25]).all()
    assert inked_share(whole.where(whole.points[:, 0] < 0.0), way, 2.4) < 0.7


def fold(turn_degrees: float, slant_degrees: float = 50.0):
    """A sheet with a fold across it, aslant to x, and how places of the flat sheet come to lie."""
    slant, turn = np.radians(slant_degrees), np.radians(turn_degrees)
    along = np.array([np.cos(slant), np.sin(slant), 0.0])
    over = np.array([np.sin(slant), -np.cos(slant), 0.0])  # to the half that is folded up
    up = np.cos(turn) * over + np.sin(turn) * np.array([0.0, 0.0, 1.0])

    def laid(x, y):
        far = x * over[0] + y * over[1]
        on = x * along[0] + y * along[1]
        flat, raised = np.minimum(far, 0.0), np.maximum(far, 0.0)
        return on[:, None] * along + flat[:, None] * over + raised[:, None] * up

    sides = (-60.0 * over, 0.0 * over, 60.0 * up)
    corners = [k * 60.0 * along + side for side in sides for k in (-1.0, 1.0)]
    faces = np.array([(0, 3, 1), (0, 2, 3), (2, 5, 3), (2, 4, 5)])
    return ClosestPoints(TriangleMesh(np.array(corners), faces)), laid


def band(laid, low: float, high: float) -> Mark:
    """A mark from y = low to high along x, folded with its sheet."""
    x, y = np.meshgrid(np.arange(-22.0, 22.0, SPACING), np.arange(low, high, SPACING) + 0.05)
    points = laid(x.ravel(), y.ravel())
    one = np.ones(len(points))
    return Mark(points, SPACING**2 * one, one, one)


def way_over(surface, laid, line) -> Way:
    places = laid(*np.array(line, float).T)
    return Way(places, surface.find(places).normals, surface=surface)


@pytest.mark.parametrize("slant", [12.0, 50.0])
@pytest.mark.parametrize(
    "turn",
    [-90.0, 0.0, 60.0, *(pytest.param(t, marks=pytest.mark.long) for t in (-60.0, 90.0, 110.0))],
)
def test_a_mark_over_a_fold_that_is_crossed_aslant_is_measured_along_it(turn, slant) -> None:
    """By what is nearest in space such a mark is 1.1 mm off its own middle, and jumps 1.6."""
    surface, laid = fold(turn, slant)
    way = way_over(surface, laid, [(x, 0.0) for x in np.arange(-20.0, 20.1, 0.5)])
    inner = stations(band(laid, -2.4, 2.4), way)
    assert off_the_way(inner, ends_mm=1.0) < 0.5
    assert largest_jump(inner) < 0.6
    beside = stations(band(laid, -0.9, 3.9), way)
    assert off_the_way(beside, 50.0, ends_mm=1.0) == pytest.approx(1.5, abs=0.2)
    half = stations(band(laid, 0.0, 2.4), way)
    assert off_the_way(half, 50.0, ends_mm=1.0) == pytest.approx(1.2, abs=0.2)
    wings = band(laid, -2.4, 2.4)
    wing = band(laid, 2.4, 6.0).where(np.abs(band(laid, 2.4, 6.0).points[:, 0] - 8.0) < 3.0)
    both = Mark(*(np.concatenate(pair) for pair in zip(wings, wing, strict=True)))
    assert off_the_way(stations(both, way), ends_mm=1.0) > 1.0
    assert largest_jump(stations(both, way)) > 0.8


def test_a_mark_of_a_way_that_comes_back_beside_itself_is_in_the_middle_of_both() -> None:
    surface, laid = fold(0.0)
    there = [(x, 0.0) for x in np.arange(-20.0, 10.1, 0.5)]
    back = [(x, 0.3) for x in np.arange(10.0, -10.1, -0.5)]
    whole = band(laid, -2.4, 2.7)
    mark = whole.where(whole.points[:, 0] < 12.4)
    found = stations(mark, way_over(surface, laid, there + back))
    assert off_the_way(found, 95.0, ends_mm=1.0) < 0.4


def test_a_bare_side_is_found_on_a_surface_too() -> None:
    surface, laid = fold(90.0)
    way = way_over(surface, laid, [(x, 0.0) for x in np.arange(-20.0, 20.1, 0.5)])
    whole = band(laid, -2.4, 2.4)
    cut = whole.where((whole.points[:, 2] <= 0.0) | (way.place(whole.points)[1] < 0.0))
    assert off_the_way(stations(cut, way), ends_mm=1.0) > 1.0
    assert off_the_way(stations(whole.where(whole.areas < 0.0), way)) == np.inf
