"""Whatever time is asked of what is wet: it ends, loses nothing, and is the same by any steps."""

from __future__ import annotations

import tracemalloc
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any
from unittest import mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import paint3d.surface.flow as flows
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.kernels.wet_step import move_water
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.surface_cases import ball
from tests.surface.test_diffusion import drop, everything, grid, irregular

MATERIALS = ("xuan", "bisque", "plaster", "porcelain")


def one_triangle() -> TriangleMesh:
    corners = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0]], np.float32)
    return TriangleMesh(corners, np.array([[0, 1, 2]], np.int32))


PATCHES = {  # mesh, resolution, a place on it
    "sheet": (lambda: grid(30.0, 3.75), 0.8, (0.0, 0.0, 0.0)),
    "uneven triangles": (lambda: irregular(14.0, 0.6), None, (0.0, 0.0, 0.0)),
    "rim": (lambda: grid(12.0, 0.6), None, (6.0, 0.0, 0.0)),
    "closed": (lambda: ball(5.0, 0.6), None, (0.0, 0.0, 5.0)),
    "triangle": (one_triangle, 0.4, (1.0, 1.0, 0.0)),
}


def wetted(patch: str, material: str, coats: float, radius: float = 2.0) -> PaintedSurface:
    """A patch with a disc of wet ink on it."""
    make, resolution, place = PATCHES[patch]
    surface = PaintedSurface(make(), resolution, material)
    surface.refine_all()
    return drop(surface, coats, radius, place)


def outcome(surface: PaintedSurface) -> NDArray[np.float64]:
    """Ink, coats x mm2; radius of gyration, mm; the area that it stands on, mm2."""
    ink, areas = everything(surface), np.asarray(surface.vertex_areas, float)
    mass = ink * areas
    points = np.asarray(surface.paint_mesh.vertices, float)
    away = points - mass @ points / mass.sum()
    radius = np.sqrt((away**2).sum(axis=1) @ mass / mass.sum())
    return np.array([mass.sum(), radius, mass.sum() ** 2 / (ink**2 @ areas)])


@contextmanager
def bound_steps(surface: PaintedSurface, most: float) -> Iterator[None]:
    """Fail at once where more steps than so many are taken: what never ends would tell nothing."""
    first = surface.flow.steps

    def counted(*given: Any) -> int:
        assert surface.flow.steps - first < most
        return move_water(*given)

    with mock.patch.object(flows, "move_water", counted):
        yield


@given(
    patch=st.sampled_from(sorted(PATCHES)),
    material=st.sampled_from(MATERIALS),
    coats=st.floats(-2.0, 0.8).map(lambda power: 10.0**power),
    seconds=st.floats(-9.0, 9.0).map(lambda power: 10.0**power),
)
@settings(max_examples=25, deadline=None)
def test_it_ends_and_loses_nothing(patch: str, material: str, coats: float, seconds: float) -> None:
    surface = wetted(patch, material, coats)
    laid = surface.wet_ink()
    with bound_steps(surface, 2000 + 40 * min(seconds, 60.0)):
        surface.diffuse(seconds)
    assert surface.wet_ink() + surface.dry_ink() == pytest.approx(laid, rel=1e-7)
    assert surface.amounts.min() >= 0.0
    assert np.isfinite(surface.flow.water)
    with bound_steps(surface, 4000):
        surface.diffuse(1e12)  # all dries, and then nothing is done any more
        assert surface.flow.is_dry
        surface.diffuse(1e12)


@pytest.mark.parametrize(
    ("patch", "material", "coats"),
    [
        ("sheet", "xuan", 2.0),
        pytest.param("uneven triangles", "xuan", 2.0, marks=pytest.mark.long),
        ("closed", "bisque", 2.0),
        pytest.param("closed", "xuan", 30.0, marks=pytest.mark.long),
        ("rim", "plaster", 0.5),
    ],
)
def test_the_outcome_is_the_same_by_any_steps(patch: str, material: str, coats: float) -> None:
    """A minute at once, second by second, and by steps of 1/30 s."""
    outcomes = []
    for parts in ([60.0], [1.0] * 60, [1.0 / 30.0] * 1800):
        outcomes.append(after(parts, wetted(patch, material, coats)))
    for other in outcomes[:2]:
        np.testing.assert_allclose(other, outcomes[2], rtol=0.01)


def after(parts: Sequence[float], surface: PaintedSurface) -> NDArray[np.float64]:
    for seconds in parts:
        surface.diffuse(seconds)
    return outcome(surface)


def test_memory_is_bounded() -> None:
    """What a long time takes is what the surface's vertices take, however often it is asked."""
    surface = wetted("sheet", "xuan", 20.0)
    surface.diffuse(20.0)
    vertices = surface.n_vertices
    tracemalloc.start()
    try:
        for _ in range(40):
            surface.diffuse(1.0)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert surface.n_vertices == vertices  # it was refined all over
    assert most < 2500 * vertices
