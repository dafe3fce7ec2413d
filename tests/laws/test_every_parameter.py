"""Nothing that a file of a brush or a material may say is without effect.

Every parameter is turned by itself, and something must change: what is painted, how it looks, or
the force that is felt. What is left out says why.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator

import numpy as np
import pytest

from paint3d.brush.presets import load_brush
from paint3d.brush.spec import HAIRS, TABLES, BristleSpec, BrushSpec, hair_ranges, parameter_ranges
from paint3d.colour.materials import Material, load_material, material_ranges
from paint3d.core.quaternion import multiply_quaternions
from paint3d.errors import InputError
from paint3d.haptics.settings import HapticSettings
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.live_brush import HAIR_COLOURS
from paint3d.view.studio import Gloss
from scripts.solids import make_plane
from tests.support.force_model import ForceModel

WITHOUT_EFFECT = {
    "name": "what it is called",
    "chinese": "what it is called",
    "source": "told by `paint3d materials`, and to who reads a session",
    "basis": "told by `paint3d materials`, and to who reads a session",
    "licence": "told by `paint3d materials`, and to who reads a session",
    "note": "told by `paint3d materials`, and to who reads a session",
}
FULL = load_brush("full")
HAIRY = dataclasses.replace(
    FULL, bristles=BristleSpec(n_hairs=60, hair_mm=0.3), plasticity=0.5, name="hairy"
)
PAPER = load_material("xuan")
MINE = dataclasses.replace(PAPER, name="mine")
CURVES = {"spread": {"pressure": [[0.0, 1.0], [1.0, 1.4]]}}
N = 40


def strokes() -> Recording:
    """Two strokes: one turns under growing pressure, leaning; the next is pressed hard at once."""
    share = np.linspace(0.0, 1.0, N)
    lean = np.array([np.cos(0.2), np.sin(0.2), 0.0, 0.0])
    turned = [
        multiply_quaternions(np.array([np.cos(a / 2), 0.0, 0.0, np.sin(a / 2)]), lean)
        for a in 1.5 * share
    ]
    places, pressures = [], []
    for k, pressure in enumerate((0.1 + 0.8 * share, 0.8 - 0.5 * share)):
        at = np.column_stack([14.0 * share - 7.0, 6.0 * k + 2.0 * share, np.full(N, 30.0)])
        places.append(at)
        pressure[[0, -1]] = 0.0
        pressures.append(pressure)
    times = np.arange(2 * N, dtype=np.int64) * 8_000_000
    return Recording(times, np.concatenate(places), np.array(turned * 2), np.concatenate(pressures))


def painted(brush: BrushSpec, material: Material) -> Iterator[bytes]:
    """What two strokes leave, the second from a brush that is nearly dry, and then five seconds.

    As it comes about: who compares it stops at the first difference.
    """
    surface = PaintedSurface(make_plane(), 0.8, material)
    painter = Painter(surface, brush, {"pine soot": 0.3, "water": 0.7}, "dragged")
    for wiped in (0.0, 0.85):
        painter.wipe(wiped)
        painter.replay(strokes())
        yield np.float64(painter.in_brush()).tobytes()
        yield surface.amounts.tobytes() + surface.coverage.tobytes()
    for seconds in (0.25, 4.75):
        surface.diffuse(seconds)
        surface.refresh()
        yield surface.amounts.tobytes() + surface.srgb.tobytes()


@functools.lru_cache(maxsize=1)
def tree():
    return PaintedSurface(make_plane(), resolution=None).contact_tree


def felt(brush: BrushSpec, material: Material) -> bytes:
    """The force of a slide."""
    model = ForceModel(tree(), HapticSettings.for_brush(brush, material=material), awake=True)
    height = 0.75 * brush.length_mm
    return b"".join(model.step([0.05 * i, 0.0, height]).force.tobytes() for i in range(120))


def seen(brush: BrushSpec, material: Material) -> object:
    """What the picture shows of both besides paint."""
    return HAIR_COLOURS[brush.hair], Gloss.of(material)


def turned(record, name: str, low: float, high: float):
    """The record with one number changed, as far as its other numbers allow."""
    value = float(getattr(record, name))
    for other in (1.3 * value, value / 1.3, 1.05 * value, 0.95 * value, low, high, 0.5 * high):
        other = round(other) if isinstance(getattr(record, name), int) else other
        if low <= other <= high and other != value:
            try:
                return dataclasses.replace(record, **{name: other})
            except InputError:
                continue
    raise AssertionError(f"{name} cannot be turned from {value}")


@functools.lru_cache(maxsize=4)
def at_first(brush: BrushSpec, material: Material):
    return tuple(painted(brush, material)), felt(brush, material), seen(brush, material)


def acts(brush: BrushSpec, material: Material, first: tuple[BrushSpec, Material]) -> bool:
    """Whether another brush or material makes a difference."""
    before = at_first(*first)
    return (
        seen(brush, material) != before[2]
        or felt(brush, material) != before[1]
        or any(now != then for now, then in zip(painted(brush, material), before[0], strict=True))
    )


def names(kind: type) -> list[str]:
    return [f.name for f in dataclasses.fields(kind) if f.name not in WITHOUT_EFFECT]


def test_the_same_twice_is_the_same() -> None:
    """Or else everything would seem to act."""
    assert not acts(FULL, PAPER, (FULL, PAPER))
    assert not acts(HAIRY, PAPER, (HAIRY, PAPER))


@pytest.mark.parametrize("name", names(BrushSpec))
def test_every_parameter_of_a_brush_acts(name: str) -> None:
    brush = dataclasses.replace(FULL, plasticity=0.5, name="one")
    ranges = parameter_ranges(brush.length_mm)
    if name in ranges:
        other = turned(brush, name, *ranges[name])
    else:
        words = {
            "hair": next(hair for hair in HAIRS if hair != brush.hair),
            "bristles": BristleSpec(n_hairs=60),
            "inputs": CURVES,
        }
        other = dataclasses.replace(brush, **{name: words[name]})
    assert acts(other, PAPER, (brush, PAPER))


@pytest.mark.parametrize("name", names(BristleSpec))
def test_every_parameter_of_the_hairs_acts(name: str) -> None:
    hairs = HAIRY.bristles
    ranges = hair_ranges()
    if name in ranges:
        other = turned(hairs, name, *ranges[name])
    else:
        words = {"table": next(table for table in TABLES if table != hairs.table)}
        other = dataclasses.replace(hairs, **{name: words[name]})
    assert acts(dataclasses.replace(HAIRY, bristles=other), PAPER, (HAIRY, PAPER))


@pytest.mark.parametrize("name", names(Material))
def test_every_parameter_of_a_material_acts(name: str) -> None:
    if name == "reflectance":
        other = dataclasses.replace(MINE, reflectance=0.9 * MINE.reflectance)
    else:
        other = turned(MINE, name, *material_ranges()[name])
    assert acts(FULL, other, (FULL, MINE))


def test_what_is_left_out_is_there_and_has_its_reason() -> None:
    there = {
        f.name for kind in (BrushSpec, BristleSpec, Material) for f in dataclasses.fields(kind)
    }
    assert set(WITHOUT_EFFECT) <= there
    assert all(WITHOUT_EFFECT.values())
