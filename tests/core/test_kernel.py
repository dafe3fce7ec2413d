"""Kernels that count no references: none is counted, and none is lost."""

from __future__ import annotations

import dataclasses
import gc
import sys
from typing import NamedTuple

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from paint3d.brush.presets import load_brush
from paint3d.core.kernel import uncounted
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.surface_cases import flat, poses, sheet


class Room(NamedTuple):
    """Some arrays."""

    low: NDArray
    high: NDArray


def sum_of(room, n):
    """A kernel of a named tuple."""
    total = 0.0
    for k in range(n):
        total += room.low[k] * room.high[k]
    return total


def test_no_reference_is_counted() -> None:
    room = Room(np.ones(4), np.full(4, 2.0))
    found = []
    for compiled in (njit(sum_of), uncounted(cache=False)(sum_of)):
        assert compiled(room, 3) == 6.0
        (code,) = compiled.inspect_asm().values()
        found.append("NRT_incref" in code or "NRT_decref" in code)
    assert found == [True, False]


@pytest.mark.parametrize("hairs", [0, 200])
@pytest.mark.parametrize("inputs", [{}, {"spread": {"pressure": ((0.0, 1.0), (1.0, 1.5))}}])
def test_painting_leaves_arrays_held_as_often_as_before(inputs: dict, hairs: int) -> None:
    share = np.linspace(0.0, 1.0, 30)
    points = np.column_stack([40.0 * share - 20.0, 0.0 * share, 0.0 * share])
    press = 0.5 * np.sin(np.pi * share)
    recording = poses(points, (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), press, "full", rate=125.0)
    surface = PaintedSurface(sheet(flat, (40.0, 20.0), 5.0), 0.6)
    painter = Painter(surface, dataclasses.replace(load_brush("full"), inputs=inputs), hairs=hairs)
    painter.replay(recording)  # whatever grows has grown
    scratch = painter.scratch
    held = [
        *painter.tuft,
        *painter.curves,
        *scratch,
        *scratch.patch,
        *scratch.query,
        *scratch.block,
    ]
    held += [*scratch.found, *surface.contact_tree, *surface.paint_mesh.arrays, *surface.ink]
    if painter.hairs is not None:
        work = painter.hairs.work(surface)
        held += [*work, *work.bristles, *work.imprint]
    held = [array for array in held if isinstance(array, np.ndarray)]
    gc.collect()  # what earlier tests left may hold the tables of a brush
    before = [sys.getrefcount(array) for array in held]
    for _ in range(3):
        painter.replay(recording)
    after = [sys.getrefcount(array) for array in held]
    assert after == before
    assert painter.report()["footprints"] > 100
