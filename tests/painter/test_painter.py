"""The painter and the painted surface: what they accept, count and report."""

from __future__ import annotations

import csv
import dataclasses
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from paint3d.brush.bending import tuft_on
from paint3d.brush.presets import load_brush
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import load_pigment
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.errors import InputError, RecordingError, UnknownNameError
from paint3d.painter import painter as engine
from paint3d.painter.painter import DIP, Painter
from paint3d.painter.stroke_table import StrokeTable
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.outlines import lift_off
from tests.support.surface_cases import UPRIGHT, flat, poses, sheet

UP = (0.0, 0.0, 1.0)


def surface(resolution: float | None = 0.8, half: float = 40.0) -> PaintedSurface:
    return PaintedSurface(sheet(flat, (half, half), 5.0), resolution)


def stroke(pressures, tilt: float = UPRIGHT, start: float = -15.0) -> Recording:
    n = len(pressures)
    x = np.linspace(start, start + 30.0, n)
    points = np.column_stack([x, np.zeros((n, 2))])
    return poses(points, UP, (0.0, 1.0, 0.0), np.asarray(pressures), tilt=tilt)


LANDING = np.array([0.0, 0.1, 0.3, 0.4, 0.4, 0.3, 0.1, 0.0])


def test_a_stroke_leaves_ink_and_a_report():
    painter = Painter(surface(), "full", "pine soot")
    painter.replay(stroke(LANDING))
    report = painter.report()
    assert report["brush"] == "full"
    assert report["ink"] == "pine soot"
    assert report["azimuth"] == "commanded"
    assert report["samples"] == 8
    assert report["samples_in_contact"] == 7
    assert report["footprints"] >= 7
    assert report["vertices"] == painter.surface.n_vertices
    assert report["vertices_painted"] == np.count_nonzero(painter.surface.coverage) > 100
    assert report["vertices_painted"] <= report["deposits"]
    assert report["tilt_limited"] == report["overpressed"] == report["leaning_over"] == 0
    assert set(report["seconds"]) == {"poses", "stroke", "colour"}
    assert report["ink_ledger"]["wet"] > 0.0
    assert painter.surface.n_vertices == len(painter.surface.srgb) == len(painter.surface.amounts)


def test_counts_go_on_through_dips_and_while_the_surface_grows():
    painter, counts = Painter(surface(0.2)), []
    capacity = painter.surface.paint_mesh.capacity
    for start in (-15.0, -25.0, -5.0):
        painter.dip("cinnabar" if counts else None)
        painter.replay(stroke(LANDING, start=start))
        counts.append(painter.report()["footprints"])
    assert painter.surface.paint_mesh.capacity > capacity
    assert counts[0] >= 7
    assert counts[1] >= counts[0] + 7
    assert counts[2] >= counts[1] + 7


def test_only_painted_vertices_change_colour():
    painter = Painter(surface())
    bare = painter.surface.srgb[0].copy()
    painter.replay(stroke(LANDING))
    dirty = painter.surface.refresh()
    painted = painter.surface.coverage > 0.0
    assert sorted(dirty.tolist()) == np.flatnonzero(painted).tolist()
    assert (painter.surface.srgb[~painted] == bare).all()
    assert (painter.surface.srgb[painter.surface.coverage == 1.0].mean(axis=1) < bare.mean()).all()
    assert len(painter.surface.refresh()) == 0


def test_bad_arguments_are_named():
    with pytest.raises(InputError, match="azimuth is 'free'; expected 'commanded' or 'dragged'"):
        Painter(surface(), azimuth="free")
    with pytest.raises(UnknownNameError, match="brush"):
        Painter(surface(), "broom")
    with pytest.raises(UnknownNameError, match="mud"):
        Painter(surface(), "full", "mud")
    with pytest.raises(InputError, match=r"expected \(vertices, faces\)"):
        PaintedSurface("bowl.ply")
    with pytest.raises(InputError, match="resolution"):
        PaintedSurface(sheet(flat, (5.0, 5.0)), 0.0)


def test_a_pad_recording_must_be_laid_first():
    pad = dataclasses.replace(stroke(LANDING), header={"space": "pad"})
    with pytest.raises(RecordingError, match="space is 'pad'; expected 'world'"):
        Painter(surface()).replay(pad)


def test_brush_and_ink_may_be_objects():
    painter = Painter(surface(), load_brush("slender"), load_pigment("cinnabar"))
    assert painter.report()["brush"] == "slender"
    assert painter.report()["ink"] == "cinnabar"


@pytest.mark.parametrize("pressures", [[0.0], [0.0, 0.0, 0.0], [0.4]])
def test_without_a_touch_nothing_happens(pressures):
    painter = Painter(surface())
    painter.replay(stroke(pressures))
    assert not painter.surface.coverage.any()
    assert painter.in_brush() == painter.loaded
    assert painter.report()["samples"] == len(pressures)


@pytest.mark.parametrize("pressed", [True, False])
def test_far_beside_the_surface_or_above_it_unpressed_nothing_happens(pressed):
    recording = stroke(LANDING)
    away = recording.position + np.array([80.0 if pressed else 0.0, 0.0, 60.0])
    pressure = recording.pressure if pressed else None
    lifted = dataclasses.replace(recording, position=away, pressure=pressure)
    painter = Painter(surface())
    painter.replay(lifted)
    assert painter.in_brush() == painter.loaded
    assert not painter.surface.coverage.any()


def test_beside_the_surface_ink_runs_off_or_stays():
    painter = Painter(surface(half=10.0))
    painter.replay(stroke(np.full(30, 0.4), start=9.0))
    ledger = painter.ledger()
    assert ledger["loaded"] == pytest.approx(sum(list(ledger.values())[1:]), rel=1e-6)
    assert ledger["off_surface"] > 0.0


def test_geometry_alone_presses_as_the_force_does():
    forced = Painter(surface())
    forced.replay(stroke(np.full(10, 0.4)))
    free = Painter(surface())
    free.replay(dataclasses.replace(stroke(np.full(10, 0.4)), pressure=None))
    np.testing.assert_allclose(free.surface.coverage, forced.surface.coverage, atol=1e-4)
    assert free.in_brush() == pytest.approx(forced.in_brush(), rel=1e-6)


@pytest.mark.parametrize(("pushed", "is_over"), [(1.0, True), (-1.0, False)])
def test_a_handle_that_leans_over_its_bend_is_counted(pushed, is_over):
    """It leans to where y is less; the tuft trails against the way."""
    way = np.linspace(0.0, 15.0, 20)
    points = np.stack([0.0 * way, pushed * way, 0.0 * way], axis=1)
    held = poses(points, UP, (0.0, 1.0, 0.0), np.full(20, 0.4), tilt=1.1)
    painter = Painter(surface(), azimuth="dragged")
    painter.replay(held)
    report = painter.report()
    assert (report["leaning_over"] > 0.5 * report["footprints"]) == is_over
    assert report["tilt_limited"] == 0


def test_limits_of_the_model_are_counted():
    flat_pen = Painter(surface())
    flat_pen.replay(stroke(np.full(5, 0.3), tilt=0.4))
    assert flat_pen.report()["tilt_limited"] > 0
    deep = Painter(surface())
    recording = stroke(np.full(5, 0.4))
    pressed = recording.position - np.array([0.0, 0.0, 20.0])
    deep.replay(dataclasses.replace(recording, position=pressed, pressure=None))
    assert deep.report()["overpressed"] > 0


def test_two_inks_mix_where_they_meet():
    painter = Painter(surface(), "full", "pine soot")
    painter.replay(stroke(LANDING))
    painter.dip("cinnabar")
    painter.replay(stroke(LANDING))
    amounts = painter.surface.amounts
    assert amounts.shape == (painter.surface.n_vertices, 2)
    assert ((amounts > 0.0).all(axis=1)).sum() > 100
    assert [p.name for p in painter.surface.pigments] == ["pine soot", "cinnabar"]
    painter.dip("pine soot")
    assert painter.surface.amounts.shape[1] == 2


def test_the_button_dips():
    pressures = np.concatenate([LANDING, LANDING])
    buttons = np.zeros(16, np.int32)
    buttons[8] = DIP
    recording = dataclasses.replace(stroke(pressures), buttons=buttons)
    painter = Painter(surface())
    painter.replay(recording)
    undipped = Painter(surface())
    undipped.replay(stroke(pressures))
    assert painter.loaded > painter.tuft.load
    assert painter.in_brush() > undipped.in_brush()
    live = Painter(surface())
    for sample in recording.samples():
        live.advance([sample])
    live.finish()
    assert live.ledger() == painter.ledger()


@pytest.mark.parametrize("hairs", [0, 40])
def test_dipping_again_dips_belly_and_tip(hairs):
    """The button of a recording lost the tip: the whole tuft was dipped in its ink."""
    painter = Painter(surface(), ink="light", hairs=hairs)
    painter.dip("burnt", reach=0.5)
    painter.dip("oil soot", reach=0.25)
    before = painter.surface.ink.load.copy(), painter.surface.ink.reservoirs.copy()
    pressures = np.concatenate([LANDING, np.zeros(8)])
    buttons = np.zeros(16, np.int32)
    buttons[14] = DIP
    painter.replay(dataclasses.replace(stroke(pressures), buttons=buttons))
    assert painter.ledger()["wet"] > 0.0
    np.testing.assert_allclose(painter.surface.ink.load, before[0], rtol=1e-9)
    np.testing.assert_allclose(painter.surface.ink.reservoirs, before[1], rtol=1e-9)
    painter.dip("cinnabar")
    painter.dip()
    held = dict(zip(painter.surface.pigments, painter.surface.ink.load, strict=True))
    assert held[load_pigment("cinnabar")] == pytest.approx(painter.tuft.load)


def test_inks_may_be_words():
    words, parts = (
        Painter(surface(), ink="light"),
        Painter(surface(), ink={"pine soot": 0.09, "water": 0.91}),
    )
    assert words.ledger() == parts.ledger()
    assert words.ink is load_pigment("pine soot")


@pytest.mark.parametrize("part", [6, 7, 20])
@pytest.mark.parametrize("how", [{}, {"wet": True}, {"frame_rate": 60.0}])
def test_however_many_samples_are_made_ready_at_once_the_painting_is_the_same(
    monkeypatch, part, how
):
    pressures = np.tile([0.0, 0.1, 0.3, 0.4, 0.5, 0.4, 0.0, 0.0, 0.2, 0.3], 5)
    turn = np.linspace(0.0, 25.0, len(pressures))
    points = np.column_stack([turn - 12.0, 9.0 * np.sin(turn), 0.0 * turn])
    recording = poses(points, UP, (0.0, 1.0, 0.0), pressures, tilt=UPRIGHT)
    buttons = np.where(np.arange(len(recording)) % 13 == 12, DIP, 0)
    recording = dataclasses.replace(recording, buttons=buttons)
    whole, parted = Painter(surface(), azimuth="dragged"), Painter(surface(), azimuth="dragged")
    whole.replay(recording, **how)
    monkeypatch.setattr(engine, "_PART", part)
    shares = []
    parted.replay(recording, progress=shares.append, **how)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert parted.report()["footprints"] == whole.report()["footprints"] > 50
    for name in ("amounts", "coverage", "srgb"):
        np.testing.assert_array_equal(getattr(parted.surface, name), getattr(whole.surface, name))
    assert parted.ledger() == whole.ledger()


def test_progress_is_told():
    told = []
    Painter(surface()).replay(stroke(LANDING), told.append)
    assert told == [1.0]


def test_growing_changes_nothing(monkeypatch):
    """However often the mesh runs out of room, the painting is the same."""
    from paint3d.mesh import refined_mesh as paint_mesh

    roomy = Painter(surface(0.4))
    roomy.replay(stroke(LANDING))
    monkeypatch.setattr(paint_mesh, "_GROWTH", 100)
    tight = Painter(surface(0.4))
    start = tight.surface.paint_mesh.capacity
    tight.replay(stroke(LANDING))
    assert tight.surface.paint_mesh.capacity > start
    assert tight.surface.n_vertices == roomy.surface.n_vertices
    np.testing.assert_array_equal(tight.surface.amounts, roomy.surface.amounts)
    np.testing.assert_array_equal(tight.surface.srgb, roomy.surface.srgb)
    assert tight.ledger() == roomy.ledger()


def test_a_mesh_may_keep_its_own_vertices():
    painter = Painter(surface(None))
    before = painter.surface.n_vertices
    painter.replay(stroke(LANDING))
    assert painter.surface.n_vertices == before
    assert painter.ledger()["wet"] > 0.0


def test_the_refined_mesh_is_whole():
    painter = Painter(surface())
    source = painter.surface.source
    painter.replay(stroke(LANDING))
    mesh = painter.surface.mesh
    assert mesh.n_vertices == painter.surface.n_vertices > source.n_vertices
    assert mesh.area == pytest.approx(source.area, rel=1e-6)
    assert painter.surface.vertex_areas.sum() == pytest.approx(source.area, rel=1e-6)
    assert (mesh.colours == painter.surface.srgb).all()


def test_wet_replays_take_what_is_due_and_come_out_as_if_all_were_moved():
    recording = stroke(np.append(np.full(60, 0.5), np.zeros(400)))
    found = []
    for exactly in (False, True):
        surface = PaintedSurface(sheet(flat, (40.0, 40.0), 5.0), 0.8, "xuan")
        if exactly:
            surface.follow_time = lambda seconds, own=surface: own.diffuse(seconds)
        Painter(surface, "zhongbaiyun", "pine soot").replay(recording, wet=True)
        surface.diffuse(0.0)  # brings all to now
        ink, areas = surface.amounts.sum(axis=1).astype(float), surface.vertex_areas
        found.append((areas[ink > 0.02].sum(), ink**2 @ areas, ink @ areas, surface.flow.steps))
    (area, square, whole, steps), exact = found
    assert area == pytest.approx(exact[0], rel=0.02)
    assert square == pytest.approx(exact[1], rel=0.02)
    assert whole == pytest.approx(exact[2], rel=3e-3)
    assert steps < 0.8 * exact[3]


# -- loads that a recording tells ---------------------------------------------------------------


def loaded(*loads: list[float], pressures=LANDING) -> Recording:
    """A stroke whose header tells the brush's load from samples on."""
    recording = stroke(pressures)
    told = [[int(recording.time_ns[int(k)]), share] for k, share in loads]
    return dataclasses.replace(recording, header={**recording.header, "loads": told})


def test_a_recording_tells_how_much_the_brush_holds():
    painter = Painter(surface())
    full = painter.tuft.load
    painter.replay(loaded([2, 0.2], [5, 0.1]))
    assert 0.05 * full < painter.in_brush() <= 0.1 * full
    accounts = painter.ledger()
    loaded_ink = accounts.pop("loaded")
    assert loaded_ink == pytest.approx(sum(accounts.values()), rel=1e-6)


@pytest.mark.parametrize("told_ns", [0, -5])
def test_a_load_may_be_told_from_the_start(told_ns):
    way = stroke(LANDING)
    way = dataclasses.replace(way, header={**way.header, "loads": [[told_ns, 0.1]]})
    painter = Painter(surface())
    painter.replay(way)
    assert painter.in_brush() <= 0.1 * painter.tuft.load


def test_loads_are_heeded_whatever_the_parts(monkeypatch):
    way = loaded([5, 0.2], [19, 0.1], [30, 0.3], pressures=0.3 * np.sin(np.linspace(0, 3.1, 40)))
    whole = Painter(surface())
    whole.replay(way)
    monkeypatch.setattr(engine, "_PART", 12)
    parts = Painter(surface())
    parts.replay(way)
    assert np.array_equal(whole.surface.amounts, parts.surface.amounts)


def test_a_brush_that_was_rinsed_is_filled_with_what_it_was_dipped_in():
    painter = Painter(surface(), ink="cinnabar")
    painter.rinse()
    painter.fill_to(0.5)
    assert painter.in_brush() == pytest.approx(0.5 * painter.tuft.load)
    with pytest.raises(InputError, match="fraction"):
        painter.fill_to(1.5)


@pytest.mark.parametrize(
    "empty", [lambda painter: painter.rinse(), lambda painter: painter.wipe(1.0)]
)
def test_an_empty_brush_is_filled_with_belly_and_tip(empty):
    painter = Painter(surface(), ink="light")
    painter.dip("pine soot", reach=0.3)
    painter.fill_to(0.5)
    whole = painter.surface.ink.reservoirs.copy()
    empty(painter)
    painter.fill_to(0.5)
    np.testing.assert_allclose(painter.surface.ink.reservoirs, whole)


@pytest.mark.parametrize(
    "told",
    ["much", [[1]], [[5, 0.1], [5, 0.2]], [[0, 2.0]], [[0.5, 0.1]], [[0, None]], 7, [[0, "0.5"]],
     [[0, [0.5, 0.5]]], [[0, [0.5]]], [[0, True]], [[0, float("nan")]], None,
     [[-(2**63), 0.1], [2**63 - 1, 0.2], [0, 0.1]]],
)  # fmt: skip
def test_loads_that_are_none_are_refused(told):
    recording = stroke(LANDING)
    recording = dataclasses.replace(recording, header={**recording.header, "loads": told})
    with pytest.raises(RecordingError, match=r"loads are .* expected pairs"):
        Painter(surface()).replay(recording)


# -- the time that ink is given at the end -----------------------------------------------------


LAST_NS = 1_020_000_000  # between two pieces


def wet_painter() -> Painter:
    surface = PaintedSurface(sheet(flat, (12.0, 6.0), 2.0), 0.8, "xuan")
    painter = Painter(surface, "slender", {"pine soot": 0.2, "water": 0.8})
    x = np.linspace(-8.0, 8.0, 20)
    points = np.stack([x, 0.0 * x, 0.0 * x], axis=1)
    pressure = np.full(20, 0.4)
    painter.replay(poses(points, (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), pressure, "slender"), wet=True)
    return painter


def test_ink_gets_its_own_time_though_it_stands_still_now_and_then(monkeypatch) -> None:
    painter = wet_painter()
    passed, shares, standing = [], [], [False, True, True, False, True]
    follow = painter.surface.follow_time

    def followed(seconds: float) -> bool:
        if painter.surface.keeps_up:
            passed.append(seconds)
        follow(seconds)
        painter.surface.keeps_up = not (standing and standing.pop())
        return painter.surface.keeps_up

    monkeypatch.setattr(painter.surface, "follow_time", followed)
    painter.rest(LAST_NS, 0.5, shares.append)
    assert passed == [0.05] * 10
    assert len(shares) == 13
    assert shares == sorted(shares)
    assert len(set(shares)) == 10
    assert shares[-1] == 1.0


@pytest.mark.parametrize(("seconds", "pieces"), [(0.0, 0), (0.02, 0), (0.03, 1), (0.08, 2)])
def test_pieces_go_on_from_the_last_sample(seconds: float, pieces: int) -> None:
    shares: list[float] = []
    wet_painter().rest(LAST_NS, seconds, shares.append)
    assert len(shares) == pieces


@pytest.mark.parametrize("seconds", [3600.0, 1e300])
def test_no_more_time_passes_once_the_ink_is_dry(seconds: float) -> None:
    painter, shares = wet_painter(), []
    painter.surface.dry()
    painter.rest(LAST_NS, seconds, shares.append)
    assert len(shares) == 1
    assert shares[0] < 1e-3


@pytest.mark.parametrize("seconds", [math.nan, math.inf, -1.0, "long"])
def test_a_rest_that_is_no_time_is_refused(seconds: float) -> None:
    with pytest.raises(InputError, match=r"rest \(s\)"):
        wet_painter().rest(LAST_NS, seconds)


# -- lifting the brush -------------------------------------------------------------------------


BEGINS, LIFT_MM = 0.25, 14.0  # 70 ms of a hand of 200 mm/s
RESOLUTION = 0.1  # mm
COLUMN = 0.5  # mm: rows of vertices, 2 / 16 mm apart, fall evenly into it
THIN = 1.0  # mm


def painted_widths(hairs: int | None, azimuth: str) -> tuple[NDArray, NDArray, float]:
    """Middles of columns (mm), how wide all the mark is there (mm), and where it ends (mm)."""
    x = np.arange(-14.0, LIFT_MM + 1e-9, 0.8)  # 250 samples a second
    places = np.stack([x, 0.0 * x, 0.0 * x], axis=1)
    pressure = BEGINS * np.clip(1.0 - x / LIFT_MM, 0.0, 1.0)
    recording = poses(places, (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), pressure, "full", rate=250.0)
    surface = PaintedSurface(sheet(flat, (22.0, 7.0), 2.0), RESOLUTION, "porcelain")
    Painter(surface, "full", azimuth=azimuth, hairs=hairs).replay(recording)
    along, cover = np.asarray(surface.paint_mesh.vertices)[:, 0], surface.coverage
    edges = np.arange(0.2, LIFT_MM + 1.0, COLUMN)
    areas, _ = np.histogram(along, edges, weights=np.minimum(cover, 1.0) * surface.vertex_areas)
    return edges[:-1] + 0.5 * COLUMN, areas / COLUMN, float(along[cover > 0.2].max())


@pytest.mark.parametrize("azimuth", ["commanded", "dragged"])
@pytest.mark.parametrize(("hairs", "narrower"), [(None, 0.04), (1000, 0.32)])
def test_a_tail_is_as_long_as_the_way_that_a_footprint_is_narrow(hairs, narrower, azimuth):
    """No lag and no raster shortens it, and nothing of it swells; hairs end .9 mm sooner."""
    glaze = load_material("porcelain")
    meant, half = lift_off(tuft_on(load_brush("full"), glaze), BEGINS, LIFT_MM)
    at, width, end = painted_widths(hairs, azimuth)
    on_the_way = at < end - 0.5 * COLUMN
    at, width = at[on_the_way], width[on_the_way]
    missing = np.interp(at, meant, 2.0 * half) - width
    assert missing.min() > -0.04
    assert missing.max() < narrower
    tail = end - np.interp(-THIN, -width, at)
    assert tail == pytest.approx(meant[half > 0.0][-1] - meant[half > 0.5 * THIN][-1], abs=0.25)
    assert end > LIFT_MM - 1.1
    slope = -np.diff(width) / COLUMN
    assert slope.min() > 0.0
    assert np.abs(np.diff(slope)).max() < 0.06


# -- the table of strokes ----------------------------------------------------------------------


def two_strokes(force: float = 0.3) -> Recording:
    """Two lines of 30 mm, the second pressed twice as hard, with air between."""
    first, second = (stroke(np.clip(factor * LANDING, 0.0, force * factor)) for factor in (1, 2))
    later = first.time_ns[-1] + 500_000_000 + second.time_ns - second.time_ns[0]
    joined = [np.concatenate([getattr(first, name), getattr(second, name)])
              for name in ("position", "orientation", "pressure")]  # fmt: skip
    return Recording(np.concatenate([first.time_ns, later]), *joined)


@pytest.mark.parametrize("hairs", [0, 60])
def test_a_table_has_a_row_for_every_stroke_and_changes_nothing(hairs: int, tmp_path) -> None:
    recording, table = two_strokes(), StrokeTable()
    with_table, without = (Painter(surface(), "full", "pine soot", hairs=hairs) for _ in range(2))
    with_table.replay(recording, table=table)
    without.replay(recording)
    assert np.array_equal(with_table.surface.amounts, without.surface.amounts)
    assert [row.stroke for row in table.rows] == [1, 2]
    soft, firm = table.rows
    assert soft.ink_left < firm.ink_left
    assert soft.most_force_n == pytest.approx(0.3 * MAX_FORCE_N)
    assert firm.mean_force_n == pytest.approx(2.0 * soft.mean_force_n, rel=0.1)
    ledger = with_table.ledger()
    given = ledger["wet"] + ledger["dry"] + ledger["off_surface"]
    assert soft.ink_left + firm.ink_left == pytest.approx(given)
    assert firm.ink_in_brush == pytest.approx(ledger["in_brush"])
    assert sum(row.footprints for row in table.rows) == with_table.report()["footprints"]
    assert 0.0 <= soft.start_s < soft.end_s <= firm.start_s < firm.end_s
    assert soft.end_s == pytest.approx(1e-9 * (recording.time_ns[6] - recording.time_ns[0]))
    table.write(tmp_path / "strokes.csv")
    with open(tmp_path / "strokes.csv", newline="") as file:
        read = list(csv.DictReader(file))
    assert [float(row["ink_left"]) for row in read] == [row.ink_left for row in table.rows]


def test_a_tables_length_is_the_way_that_was_drawn() -> None:
    painter, table = Painter(surface(), "full", "pine soot"), StrokeTable()
    line = painter.stroke([(-20, 0, 0), (20, 0, 0)], pressure=(0.2, 0.4, 0.2))
    painter.replay(line, table=table)
    assert table.rows[0].length_mm == pytest.approx(40.0, rel=0.1)
    painter.replay(line, table=table)  # goes on
    assert [row.stroke for row in table.rows] == [1, 2]


def test_a_tables_mean_force_is_that_of_an_even_press() -> None:
    painter, table = Painter(surface(), "full", "pine soot"), StrokeTable()
    painter.replay(painter.stroke([(-20, 0, 0), (20, 0, 0)], pressure=0.4), table=table)
    assert table.rows[0].mean_force_n == pytest.approx(0.4 * MAX_FORCE_N, rel=0.02)
    assert table.rows[0].most_force_n == pytest.approx(0.4 * MAX_FORCE_N)


def test_a_table_of_a_wet_replay_has_the_same_strokes() -> None:
    pressed = stroke(np.full(8, 0.3))  # from its first sample on, and slow: ink is stepped at once
    slow = dataclasses.replace(pressed, time_ns=np.arange(8) * 60_000_000)
    tables = [StrokeTable(), StrokeTable()]
    for wet, table in enumerate(tables):
        Painter(surface(), "full", "pine soot").replay(slow, wet=bool(wet), table=table)
    dry, wet_rows = (table.rows for table in tables)
    assert [row.length_mm for row in wet_rows] == [row.length_mm for row in dry]
    assert len(dry) == 1


def test_a_table_has_no_row_of_a_stroke_that_ended_pressed_before() -> None:
    painter, table = Painter(surface(), "full", "pine soot"), StrokeTable()
    painter.replay(stroke(LANDING[:5]), table=table)  # it ends on the surface
    in_air = stroke(np.concatenate([np.zeros(4), LANDING]))
    painter.replay(in_air, table=table)
    assert len(table.rows) == 2
    assert table.rows[1].start_s > 0.0
