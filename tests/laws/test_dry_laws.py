"""Laws of a brush that runs dry: streaks along its way, on any mesh and in any direction."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from paint3d.calligraphy.kernels.raster import fill_triangles
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.cases import long_but
from tests.support.surface_cases import flat, sheet

BOX = (-12.0, 12.0, -2.0, 2.0)  # along the stroke and across, mm
GRID_MM = 0.05


def stroke(turn: float, pressure: float, aside: float = 0.0) -> Recording:
    """Straight, the tuft trailing, or turned aside from there by an angle."""
    n = 160
    x = np.linspace(-20.0, 20.0, n)
    position = np.stack([math.cos(turn) * x, math.sin(turn) * x, np.full(n, 30.0)], axis=1)
    half = 0.5 * (turn + math.pi + aside)
    turned = np.tile([math.cos(half), 0.0, 0.0, math.sin(half)], (n, 1))
    return Recording(np.arange(n) * 4_000_000, position, turned, np.full(n, pressure))


@functools.cache
def covered(
    resolution: float = 0.1, turn: float = 0.0, load: float = 0.16, pressure: float = 0.4,
    hairs: int | None = None, down: float = 0.0, wide: float = BOX[3], material: str = "xuan",
) -> np.ndarray:  # fmt: skip
    """Coverage on a grid of `GRID_MM`, rows across the stroke, which lies so many mm aside."""
    surface = PaintedSurface(sheet(flat, (35.0, 35.0), 4.0), resolution, material)
    painter = Painter(surface, "full", "pine soot", hairs=hairs)
    painter.wipe(1.0 - load)
    along = stroke(turn, pressure)
    place = along.position + np.array([-math.sin(turn) * down, math.cos(turn) * down, 0.0])
    painter.replay(Recording(along.time_ns, place, along.orientation, along.pressure))
    ledger = painter.report()["ink_ledger"]
    kept = sum(ledger[name] for name in ("in_brush", "wet", "dry", "off_surface"))
    assert kept == pytest.approx(ledger["loaded"], rel=1e-8)
    # it gives no more than what it touches takes up: the sheet is wider than the stroke
    assert ledger["off_surface"] == pytest.approx(0.0, abs=1e-6 * ledger["loaded"])
    vertices = np.asarray(surface.mesh.vertices, float)
    x = math.cos(turn) * vertices[:, 0] + math.sin(turn) * vertices[:, 1]
    y = math.cos(turn) * vertices[:, 1] - math.sin(turn) * vertices[:, 0]
    places = (np.stack([x, y - down], axis=1) - [BOX[0], -wide]) / GRID_MM
    picture = np.empty((round(2.0 * wide / GRID_MM), round((BOX[1] - BOX[0]) / GRID_MM)), "f4")
    faces = np.asarray(surface.mesh.faces, np.int32)
    fill_triangles(places, surface.coverage.astype(np.float32), faces, picture)
    return picture


def correlation_mm(picture: np.ndarray, axis: int) -> float:
    """Way over which the autocorrelation falls to 1/e."""
    picture = picture - picture.mean()
    n = picture.shape[axis]
    for k in range(1, n // 2):
        a, b = np.take(picture, range(n - k), axis), np.take(picture, range(k, n), axis)
        if (a * b).mean() < (picture**2).mean() / math.e:
            return GRID_MM * k
    return GRID_MM * (n // 2)


@pytest.mark.parametrize("turn", long_but([0.0, 0.5], [0.0, 0.5, 0.785]))
def test_streaks_are_long_and_narrow_in_any_direction(turn) -> None:
    """Law 10: no lattice shows. Square speckle has a ratio of 1."""
    picture = covered(turn=turn)
    assert correlation_mm(picture, 1) > 3.0 * correlation_mm(picture, 0)
    by_place = [
        [covered(0.2, turn=to, down=down).mean() for down in (-12.0, -4.0, 0.0, 4.0, 12.0)]
        for to in (0.0, turn)
    ]
    assert np.mean(by_place[0]) == pytest.approx(np.mean(by_place[1]), abs=0.1)


def test_coarse_vertices_show_the_grey_of_the_streaks() -> None:
    """Law 10: bumps and bundles that are left out go into the grey and soften it, none twice."""
    strokes = [
        [covered(resolution, down=down) for resolution in (0.1, 0.2, 0.4)]
        for down in (-12.0, -8.0, -4.0, 0.0, 4.0, 8.0, 12.0)
    ]
    fine, *coarse = np.mean([[picture.mean() for picture in row] for row in strokes], axis=0)
    assert coarse == pytest.approx([fine, fine], abs=0.03)
    fine, *coarse = np.mean([[picture.std() for picture in row] for row in strokes], axis=0)
    assert coarse[0] < fine
    assert coarse[1] < 0.65 * fine


@pytest.mark.parametrize("hairs", [0, 500])
def test_a_dry_brush_that_is_pressed_in_its_place_leaves_flecks(hairs) -> None:
    """Ink or paper, no mist: what is touched while it comes down stays the same places."""
    surface = PaintedSurface(sheet(flat, (20.0, 20.0), 4.0), 0.15, "xuan")
    painter = Painter(surface, "full", "pine soot", hairs=hairs)
    painter.wipe(0.84)
    n = 120
    turned = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    place, pressure = np.tile([0.0, 0.0, 30.0], (n, 1)), np.linspace(0.0, 0.35, n)
    painter.replay(Recording(np.arange(n) * 4_000_000, place, turned, pressure))
    values = painter.stamp.values[0]
    away = np.linalg.norm(
        surface.paint_mesh.vertices[:, :2]
        - (values["origin"] + 0.5 * (values["heel"] + values["tip"]) * values["bend"])[:2],
        axis=1,
    )
    within = away < 0.8 * values["widest"]
    cover = surface.coverage[within]
    assert 0.2 < cover.mean() < 0.7
    assert ((cover < 0.2) | (cover > 0.8)).mean() > 0.75


def test_less_ink_and_less_pressure_cover_less() -> None:
    """Law 12."""
    by_load = [covered(0.2, load=load).mean() for load in (0.08, 0.12, 0.16, 0.24)]
    middle = slice(24, 56)  # .8 mm to each side: a harder press is wider, too
    # of less ink than this a harder press spends too much to cover more
    by_pressure = [covered(0.2, load=0.2, pressure=p)[middle].mean() for p in (0.1, 0.2, 0.35)]
    assert (np.diff(by_load) > 0.0).all()
    assert (np.diff(by_pressure) > 0.0).all()


def streak_mm(picture: np.ndarray) -> float:
    """How wide gaps and marks are across, were half of it bare; flecks of paper are evened out."""
    along = picture.reshape(len(picture), -1, round(2.0 / GRID_MM)).mean(axis=2)  # over 2 mm
    bare = along < 0.5
    edges = np.count_nonzero(np.diff(bare, axis=0))
    return 4.0 * bare.mean() * (1.0 - bare.mean()) * GRID_MM * bare.size / edges


@pytest.mark.long
def test_more_hairs_leave_finer_gaps() -> None:
    """Law 11."""
    widths = [
        np.mean([streak_mm(covered(hairs=hairs, down=down)) for down in (-8.0, 0.0, 8.0)])
        for hairs in (100, 1000, 10000)
    ]
    assert widths[1] < 0.75 * widths[0]
    assert widths[2] < 0.75 * widths[1]


@pytest.mark.parametrize("hairs", [0, 1000])
def test_a_tuft_that_goes_sideways_touches_as_much(hairs) -> None:
    """What is badly supplied is the rim of what goes along, not all that is long."""
    shares = []
    for aside in (0.0, 0.5 * math.pi):
        inked = []
        for load in (0.2, 1.0):
            surface = PaintedSurface(sheet(flat, (35.0, 35.0), 4.0), 0.3, "xuan")
            painter = Painter(surface, "full", "pine soot", hairs=hairs)
            painter.wipe(1.0 - load)
            painter.replay(stroke(0.0, 0.4, aside))
            inked.append(surface.coverage.sum())
        shares.append(inked[0] / inked[1])
    assert shares[1] > 0.8 * shares[0]


def test_each_press_parts_the_hairs_anew() -> None:
    """Strokes beside each other have other streaks; one that is repeated at its place, the same."""
    strokes = [covered(0.2, load=0.13, down=down) for down in (0.0, -8.0, 4.0, 6.0)]
    profiles = [picture[:, 200:280].mean(axis=1) for picture in strokes]
    assert all(profile.std() > 0.1 for profile in profiles)  # there are streaks
    alike = np.corrcoef(profiles)[np.triu_indices(4, 1)]
    assert alike.mean() < 0.8
    assert alike.min() < 0.6
    assert np.array_equal(covered.__wrapped__(0.2, load=0.13), strokes[0])


def test_lanes_of_a_wet_brush_foretell_where_it_will_run_dry() -> None:
    """Bundles that bring much while wet leave ink longest: docs/model.md, equations (12), (13)."""
    alike = []
    for down in (0.0, -8.0, 4.0):
        surface = PaintedSurface(sheet(flat, (35.0, 35.0), 4.0), 0.2, "xuan")
        painter = Painter(surface, "full", {"pine soot": 0.3, "water": 0.7}, hairs=0)
        along = stroke(0.0, 0.4)
        painter.replay(replace(along, position=along.position + np.array([0.0, down, 0.0])))
        x, y, _ = surface.paint_mesh.vertices.T
        amounts, within = surface.amounts.sum(axis=1), (abs(x) < 4.0)
        edges = np.linspace(-1.9, 1.9, 20)  # mm across
        film = [
            amounts[within & (y - down > low) & (y - down < high)].mean()
            for low, high in itertools.pairwise(edges)
        ]
        picture = covered(0.2, load=0.13, down=down)[:, 160:320]
        cover = picture.mean(axis=1)[2:78].reshape(19, 4).mean(axis=1)
        bowed = [values - np.polyval(np.polyfit(edges[:-1], values, 2), edges[:-1])
                 for values in (film, cover)]  # fmt: skip
        alike.append(np.corrcoef(bowed)[0, 1])
    assert np.mean(alike) > 0.7


def _wobble(load: float, mm_s: float) -> float:
    """Deviation (mm) of a stroke's edges on xuan from smooth curves."""
    surface = PaintedSurface(sheet(flat, (35.0, 35.0), 4.0), 0.1, "xuan")
    painter = Painter(surface, "full", {"pine soot": 0.3, "water": 0.7}, hairs=0)
    painter.wipe(1.0 - load)
    along = stroke(0.0, 0.3)
    painter.replay(replace(along, time_ns=np.linspace(0.0, 4e10 / mm_s, 160).astype(np.int64)))
    places = (np.asarray(surface.mesh.vertices)[:, :2] - [BOX[0], -8.0]) / GRID_MM
    picture = np.empty((320, round((BOX[1] - BOX[0]) / GRID_MM)), "f4")
    faces = np.asarray(surface.mesh.faces, np.int32)
    fill_triangles(places, surface.coverage.astype(np.float32), faces, picture)
    halves = [GRID_MM * (half > 0.5).sum(axis=0) for half in (picture[:160], picture[160:])]
    at = np.arange(picture.shape[1])
    return float(np.mean([np.std(h - np.polyval(np.polyfit(at, h, 3), at)) for h in halves]))


def test_edges_are_rougher_the_faster_and_the_drier_the_brush() -> None:
    """Ink that is plenty and has time runs together: docs/model.md, equation (20a)."""
    calm = _wobble(1.0, 20.0)
    assert _wobble(1.0, 150.0) > 1.4 * calm
    assert _wobble(0.5, 60.0) > 1.1 * _wobble(1.0, 60.0)


def test_a_thin_line_has_a_cleaner_edge_than_a_broad_stroke() -> None:
    """It brings little ink that fibres could draw on: docs/model.md, equation (20)."""
    thin, broad = (
        GRID_MM * (covered(load=1.0, pressure=pressure, wide=8.0)[160:] > 0.5).sum(axis=0)
        for pressure in (0.02, 0.4)
    )
    assert 2.0 * thin.mean() < 1.5 < 5.0 < 2.0 * broad.mean()
    assert thin.std() < 0.5 * broad.std()


@pytest.mark.parametrize(("hairs", "least"), [(0, 0.65), (1000, 0.4)])
def test_what_a_nearly_dry_brush_touches_stays_dark(hairs, least) -> None:
    """Docs/model.md, equations (10a) and (12a): it covers less, and does not turn grey."""
    films = []
    for load in (0.06, 1.0):
        surface = PaintedSurface(sheet(flat, (35.0, 35.0), 4.0), 0.2, "xuan")
        painter = Painter(surface, "full", "pine soot", hairs=hairs)
        painter.wipe(1.0 - load)
        painter.replay(stroke(0.0, 0.3))
        touched = surface.coverage > 0.5
        films.append(np.median(surface.amounts.sum(axis=1)[touched] / surface.coverage[touched]))
    assert films[0] > least * films[1]


@pytest.mark.parametrize("material", ["xuan", "bisque", "silk"])
@pytest.mark.parametrize("hairs", [0, 300, 1000])
def test_a_nearly_dry_brush_marks_to_the_end_of_its_way(hairs, material) -> None:
    """Its mark breaks up more and more; hairs do not all cease at one place."""
    load = {"xuan": 0.05, "bisque": 0.05, "silk": 0.03}[material]
    picture = covered(0.2, load=load, hairs=hairs, material=material)
    marks = picture.mean(axis=0).reshape(6, -1).mean(axis=1)
    assert marks.min() > 0.001
    assert marks.mean() > 0.05
