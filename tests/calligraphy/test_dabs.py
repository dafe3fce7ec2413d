"""Filled shapes have no bare patches."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt
from shapely import Polygon, contains_xy, unary_union

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import choose_brush, load_brush
from paint3d.calligraphy.footprint_table import FootprintTable, tabulate_footprints
from paint3d.calligraphy.glyphs import EM_UNITS, Glyph
from paint3d.calligraphy.kernels import planning as kernels
from paint3d.calligraphy.page.strokes_file import load_strokes, save_strokes
from paint3d.calligraphy.page.svg_drawing import load_svg
from paint3d.calligraphy.path_fit import PlanSettings
from paint3d.calligraphy.planning import on_paper, plan_glyph
from paint3d.calligraphy.writing import WritingSettings, write_page
from paint3d.device.sample import DIP
from paint3d.files.load import load_mesh
from tests.support.cases import long_but

EM = 40.0
HEAD = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">'


def gear(teeth: int) -> str:
    """A wheel with pointed teeth and a hole."""
    points = []
    for k in range(4 * teeth):
        r, turn = (48.0 if k % 4 < 2 else 40.0), 0.5 * math.pi * k / teeth
        points.append(f"{50 + r * math.cos(turn):.3f},{50 + r * math.sin(turn):.3f}")
    return (
        f'<path fill-rule="evenodd" d="M{" L".join(points)} Z'
        ' M50,22 A28,28 0 1 0 50.1,22 Z"/>'
    )  # fmt: skip


HOOKS = (  # two square hooks that lie in each other, as two snakes
    '<path d="M10,5 H55 V50 H25 V65 H10 Z M90,95 H45 V60 H75 V40 H90 Z"/>'
    '<path d="M62,6 L94,6 L94,30 L78,12 Z"/>'
)


@pytest.fixture(scope="module")
def footprints() -> FootprintTable:
    return tabulate_footprints(build_tuft(load_brush(choose_brush(EM))), 0.2 * EM)


def bare_in(glyph: Glyph, footprints: FootprintTable, asked: PlanSettings) -> tuple[float, float]:
    """Half the widest bare patch in ems, and what is painted beside the shape over its area."""
    grid = np.array([-0.05 * EM, -0.05 * EM, EM / 1024])
    painted = np.zeros((1230, 1230), np.bool_)
    for path in plan_glyph(glyph, EM, footprints, asked):
        kernels.cover(
            footprints.points, path.level, path.centre, path.azimuth, path.share, grid,
            painted,
        )  # fmt: skip
    shapes = [
        Polygon(on_paper(one.outline, EM), [on_paper(hole, EM) for hole in one.holes]).buffer(0.0)
        for one in glyph.strokes
    ]
    y, x = np.mgrid[: painted.shape[0], : painted.shape[1]]
    inked = contains_xy(unary_union(shapes), grid[0] + grid[2] * x, grid[1] + grid[2] * y)
    deepest = distance_transform_edt(inked & ~painted).max() / EM_UNITS
    return float(deepest), float((painted & ~inked).sum() / inked.sum())


@pytest.mark.parametrize(
    ("inner", "azimuth"),
    long_but(
        [(gear(9), "commanded"), (HOOKS, "commanded")],
        [
            (inner, azimuth)
            for inner in (gear(24), gear(9), HOOKS)
            for azimuth in ("commanded", "dragged")
        ],
    ),
)
def test_filled_shapes_have_no_bare_patches(tmp_path, footprints, inner, azimuth) -> None:
    """What strokes alone leave bare is wider."""
    (tmp_path / "a.svg").write_text(f"{HEAD}{inner}</svg>", "utf-8")
    asked = PlanSettings(azimuth=azimuth)
    most = 0.0
    for piece in load_svg(tmp_path / "a.svg").pieces:
        plain, _ = bare_in(replace(piece.glyph, solid=False), footprints, asked)
        deepest, beside = bare_in(piece.glyph, footprints, asked)
        assert deepest < 3.5 / EM_UNITS
        assert beside < 0.02
        most = max(most, plain)
    assert most > 5.0 / EM_UNITS


def test_a_file_of_strokes_says_what_is_a_filled_shape(tmp_path: Path) -> None:
    (tmp_path / "a.svg").write_text(f"{HEAD}{HOOKS}</svg>", "utf-8")
    save_strokes(load_svg(tmp_path / "a.svg"), tmp_path / "a.strokes.json")
    assert all(piece.glyph.solid for piece in load_strokes(tmp_path / "a.strokes.json").pieces)


def test_a_filled_shape_does_not_vary_and_is_dipped_for_as_often_as_it_takes(tmp_path) -> None:
    """One load would leave its last strokes grey, and strokes of a hand would leave gaps."""
    (tmp_path / "a.svg").write_text(f"{HEAD}{HOOKS}</svg>", "utf-8")
    page, mesh = load_svg(tmp_path / "a.svg"), load_mesh("plane")
    settings = WritingSettings(load_brush(choose_brush(EM)), EM)
    plain = write_page(mesh, page, settings).recording
    varied = write_page(mesh, page, replace(settings, variation=1.0)).recording
    assert np.array_equal(plain.position, varied.position)
    dips = np.count_nonzero(np.diff(plain.buttons & DIP, prepend=0) > 0)
    assert dips > len(page.pieces) + 1
