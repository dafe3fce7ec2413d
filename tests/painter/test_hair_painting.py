"""Painting with single hairs: ink in each, imprints near enough, streaks, memory, repeats."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import subprocess
import sys
from argparse import ArgumentTypeError
from importlib.resources import files
from itertools import product
from pathlib import Path

import numba
import numpy as np
import pytest
from scipy.spatial import cKDTree

from paint3d.brush.presets import load_brush
from paint3d.brush.spec import MOST_HAIRS, BristleSpec
from paint3d.brush_engine.bristles.bend import BLOCK, SAMPLES
from paint3d.brush_engine.bristles.contact import BEGIN, END, FINDINGS, GIVES, HELD
from paint3d.brush_engine.bristles.ink_transfer import settle_deposits, sum_hairs
from paint3d.brush_engine.bristles.state import PARTED, SPLIT
from paint3d.brush_engine.dry_contact import bundle_noise, contact_noise
from paint3d.cli.options import parse_hairs
from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.colour.pigments import load_pigment
from paint3d.core.quaternion import quaternions_from_matrices
from paint3d.device.sample import DeviceSample
from paint3d.errors import InputError
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.cases import long_but
from tests.support.surface_cases import ball, bowl, flat, on_sphere, poses, sheet

UP = (0.0, 0.0, 1.0)
MIDDLE = 8.0  # mm to either side of the middle of a stroke, where it is as wide as it gets


def plane(resolution=0.5, half=(60.0, 25.0), material="porcelain"):
    return PaintedSurface(sheet(flat, half, 5.0), resolution, material)


def stroke(press=0.4, start=-30.0, end=30.0, y=0.0, brush="full", n=40, along=(-1.0, 0.0, 0.0)):
    x, share = np.linspace(start, end, n), np.linspace(0.0, 1.0, n)
    points = np.column_stack([x, np.full(n, y), np.zeros(n)])
    pressure = press * np.clip(6.0 * np.minimum(share, 1.0 - share), 0.0, 1.0)
    return poses(points, UP, along, pressure, brush, rate=125.0)


def paint(*recordings, surface=None, hairs=400, brush="full", wipe=0.0, **options):
    painter = Painter(surface or plane(), brush, hairs=hairs, **options)
    painter.wipe(wipe)
    for recording in recordings:
        painter.replay(recording)
    return painter


def balance(painter):
    ledger = painter.ledger()
    there = sum(ledger[k] for k in ("in_brush", "wet", "dry", "off_surface"))
    return abs(there / ledger["loaded"] - 1.0)


@pytest.mark.parametrize("hairs", [50, 0])
def test_who_presses_paints_from_any_height(hairs):
    """Where the hand says how hard it presses, the position says only where."""
    recording = stroke()
    painted = []
    for height in (0.0, 200.0):
        away = recording.position + np.array([0.0, 0.0, height])
        painter = paint(dataclasses.replace(recording, position=away), hairs=hairs)
        painted.append(painter.surface.coverage)
    assert painted[0].any()
    np.testing.assert_allclose(painted[0], painted[1], atol=2e-3)


def bytes_of(painter):
    surface = painter.surface
    arrays = (surface.amounts, surface.coverage, surface.srgb, surface.paint_mesh.vertices)
    return b"".join(a.tobytes() for a in arrays)


def covered(painter, least=0.5):
    return painter.surface.mesh.vertices[painter.surface.coverage > least].astype(float)


def widths(painter):
    """Length of what was painted; from side to side, and its mean width, in the middle, mm."""
    points = covered(painter)
    sides = points[np.abs(points[:, 0]) < MIDDLE, 1]
    middle = np.abs(painter.surface.mesh.vertices[:, 0]) < MIDDLE
    area = (painter.surface.vertex_areas * painter.surface.coverage)[middle].sum()
    return np.array([np.ptp(points[:, 0]), np.ptp(sides), area / (2.0 * MIDDLE)])


@pytest.mark.parametrize(
    ("brush", "press"),
    long_but(
        [("full", 0.25), ("full", 0.7), ("zhongkai", 0.5), ("slender", 0.5)],
        [("full", 0.25), ("full", 0.7), ("zhongkai", 0.5), ("xiaokai", 0.5), ("slender", 0.3),
         ("slender", 0.5), ("slender", 0.7)],
    ),
)  # fmt: skip
def test_hairs_and_solid_tuft_agree_in_width_and_length(brush, press):
    fine = {"xiaokai": 0.2, "slender": 0.15}.get(brush, 0.4)
    solid, bristles = (
        widths(paint(stroke(press, brush=brush), surface=plane(fine), hairs=n, brush=brush))
        for n in (0, 1000)
    )
    assert bristles == pytest.approx(solid, rel=0.1)


def test_a_full_tuft_gives_what_a_solid_one_gives():
    solid, hairs = (paint(stroke(), hairs=n).ledger()["wet"] for n in (0, 400))
    assert hairs == pytest.approx(solid, rel=0.1)


def share_at_the_sides(painter):
    """Ink beyond three quarters of a stroke's half width, over all, in the middle of the stroke."""
    vertices = painter.surface.mesh.vertices
    middle = np.abs(vertices[:, 0]) < MIDDLE
    ink = painter.surface.amounts.sum(axis=1) * painter.surface.vertex_areas * middle
    across = np.abs(vertices[:, 1])
    half_width = 0.5 * widths(painter)[2]
    return ink[across > 0.75 * half_width].sum() / ink.sum()


@pytest.mark.parametrize("press", [0.3, 0.42, 0.6])
def test_the_sides_of_a_stroke_get_their_ink(press):
    solid, hairs = (
        share_at_the_sides(paint(stroke(press), surface=plane(0.3), hairs=n, wipe=0.5))
        for n in (0, 1000)
    )
    assert 0.61 < hairs / solid < 1.4


@pytest.mark.parametrize("wipe", [0.0, 0.8])
@pytest.mark.parametrize("pickup", [0.0, 0.05])
def test_ink_is_kept(wipe, pickup):
    painter = Painter(plane(), "full", "pine soot", hairs=200, pickup=pickup, azimuth="dragged")
    painter.wipe(wipe)
    painter.replay(stroke(y=24.5))  # half of it over the edge
    painter.dip("cinnabar", reach=0.5)
    painter.replay(stroke(y=4.0, along=(0.0, 1.0, 0.0)))
    painter.dip({"cinnabar": 0.3, "water": 0.7})
    painter.replay(stroke(y=-4.0))
    assert balance(painter) < 1e-6
    assert painter.ledger()["off_surface"] > 0.0
    assert painter.surface.amounts.min() >= 0.0
    assert painter.hairs.load.min() >= 0.0
    np.testing.assert_allclose(painter.hairs.total(), painter.surface.ink.load)


def test_hairs_that_touch_more_give_more():
    painter = paint(stroke(), hairs=BristleSpec(n_hairs=400, levelling_mm=1e4))
    held = painter.hairs.load[:, 0]
    assert held.min() < 0.9 * held.max()


def streaks(painter):
    """Covered share (lanes, steps) over the middle of a stroke along x."""
    vertices = painter.surface.mesh.vertices
    seen = np.abs(vertices[:, 0]) < 15.0
    x, y = vertices[seen, 0], vertices[seen, 1]
    bins = [np.linspace(-3.0, 3.0, 16), np.linspace(-15.0, 15.0, 16)]
    total = np.histogram2d(y, x, bins, weights=painter.surface.coverage[seen])[0]
    return total / np.maximum(np.histogram2d(y, x, bins)[0], 1.0)


def test_a_wet_stroke_is_closed_and_a_dry_one_breaks_into_streaks():
    wet, dry = (
        streaks(paint(stroke(), surface=plane(0.3), hairs=1000, wipe=w)) for w in (0.0, 0.9)
    )
    assert wet.min() > 0.98
    assert 0.05 < dry.mean() < 0.8
    across, along = dry.mean(axis=1).std(), dry.std(axis=1).mean()
    assert across > 0.15
    assert across > along  # streaks run along the stroke


def test_a_long_stroke_runs_dry_hair_by_hair():
    there = [stroke(y=y, start=-50.0, end=50.0) for y in (-12.0, -4.0, 4.0, 12.0)]
    painter = Painter(plane(0.5, (70.0, 25.0)), "full", hairs=400)
    painter.wipe(0.82)
    shares = []
    for recording in there:
        before = painter.surface.coverage.copy()
        painter.replay(recording)
        y = recording.position[0, 1]
        vertices = painter.surface.mesh.vertices
        lane = (np.abs(vertices[:, 1] - y) < 2.5) & (np.abs(vertices[:, 0]) < 30.0)
        now = painter.surface.coverage
        shares.append(now[lane].mean())
        assert (now[: len(before)] >= before).all()
    assert shares[0] > 0.8
    assert shares[-1] < 0.88 * shares[0]


def sample_of(recording, k):
    return DeviceSample(
        int(recording.time_ns[k]), recording.position[k], recording.orientation[k],
        float(recording.pressure[k]), 0, recording.object_position[k],
        recording.object_orientation[k],
    )  # fmt: skip


def test_the_same_recording_gives_the_same_bytes_in_any_portions():
    recording = stroke(n=30)
    whole = paint(recording, recording)
    samples = [sample_of(recording, k) for k in range(len(recording))]
    parts = Painter(plane(), "full", hairs=400)
    parts.wipe(0.0)
    for _ in range(2):
        for k in range(0, len(samples), 7):
            parts.advance(samples[k : k + 7])
        parts.finish()
    assert bytes_of(whole) == bytes_of(parts)
    assert bytes_of(whole) == bytes_of(paint(recording, recording))
    assert (whole.hairs.load == parts.hairs.load).all()


CHILD = """
import hashlib
from tests.painter.test_hair_painting import bytes_of, paint, stroke
print(hashlib.sha256(bytes_of(paint(stroke(n=20), wipe=0.7))).hexdigest())
"""


def test_the_number_of_threads_does_not_matter():
    threads = "2" if numba.config.NUMBA_NUM_THREADS == 1 else "1"  # another number than here
    environment = {**os.environ, "NUMBA_NUM_THREADS": threads}
    environment["PYTHONPATH"] = os.pathsep.join(p for p in sys.path if p)
    done = subprocess.run(
        [sys.executable, "-c", CHILD], capture_output=True, text=True, check=True,
        env=environment, cwd=Path(__file__).parents[2],
    )  # fmt: skip
    here = hashlib.sha256(bytes_of(paint(stroke(n=20), wipe=0.7))).hexdigest()
    assert done.stdout.strip() == here


def test_sums_over_hairs_take_every_hair_and_every_pigment():
    for n in (1, BLOCK - 1, BLOCK, 2 * BLOCK + 21):
        load = np.arange(3.0 * n).reshape(n, 3)
        held = np.empty(3)
        sum_hairs(load, held)
        assert (held == load.sum(axis=0)).all()  # whole numbers: no rounding
        held = np.empty(1)
        sum_hairs(np.ascontiguousarray(load[:, :1]), held)
        assert held == load[:, 0].sum()


def test_hairs_give_by_the_law_at_every_rate():
    wishes = np.linspace(0.0, 1.9, BLOCK)
    for rate in (1e-6, 0.02, 0.7, 40.0):
        hair_contacts = np.zeros((1, FINDINGS * BLOCK), np.float32)
        hair_contacts[0, GIVES : GIVES + BLOCK] = wishes
        hair_contacts[0, HELD : HELD + BLOCK] = 2.0
        told = settle_deposits(BLOCK, float(BLOCK), rate, hair_contacts, np.zeros(BLOCK))
        gives = hair_contacts[0, GIVES : GIVES + BLOCK]
        np.testing.assert_allclose(gives, -np.expm1(-rate * wishes), rtol=2e-6)
        assert told == pytest.approx(2.0 * gives.sum(dtype=np.float64), rel=1e-12)


@pytest.mark.parametrize("wipe", [0.0, 0.85])
def test_hairs_that_hardly_move_are_kept_and_paint_the_same(wipe):
    recording = stroke(n=400, start=-20.0, end=20.0)
    painters = []
    for anew in (False, True):
        surface = plane()
        surface.refine_all()  # with vertices in the same order
        painter = paint(surface=surface, wipe=wipe)
        for k in range(len(recording)):
            if anew:
                painter.hairs.work(painter.surface).kept["touching"] = 0.0
            painter.advance([sample_of(recording, k)])
        painter.finish()
        painters.append(painter)
    kept, anew = painters
    assert bytes_of(kept) != bytes_of(anew)  # so it does happen
    assert balance(kept) < 1e-6
    assert kept.ledger()["wet"] == pytest.approx(anew.ledger()["wet"], rel=0.01)
    colours = [lab_from_srgb(painter.surface.srgb) for painter in painters]
    here = (kept.surface.coverage > 0.0) | (anew.surface.coverage > 0.0)
    differences = delta_e(*colours)[here]
    assert differences.mean() < 0.5
    assert np.percentile(differences, 99) < 8.0


def turning(angle=1.5, n=4, press=0.5, swings=0):
    """A pressed brush that turns where it stands; then so often back and forth."""
    azimuth = np.concatenate([np.linspace(0.0, angle, n), np.tile([0.0, angle], swings)])
    n = len(azimuth)
    bend = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(n)], axis=1)
    up = np.tile(UP, (n, 1))
    frames = np.stack([bend, np.cross(up, bend), up], axis=2)
    spec = load_brush("full")
    position = np.tile([0.0, 0.0, spec.length_mm - press * spec.full_press_mm], (n, 1))
    return Recording(
        (np.arange(n) * 30_000_000).astype(np.int64), position,
        quaternions_from_matrices(frames), np.full(n, press),
    )  # fmt: skip


def pushed_back(press=0.4):
    """Pressed, pushed 8 mm towards its tip, and drawn away over 60 mm."""
    x = np.concatenate([np.linspace(-22.0, -30.0, 20), np.linspace(-30.0, 30.0, 60)])
    points = np.stack([x, np.zeros(80), np.zeros(80)], axis=1)
    return poses(points, UP, (-1.0, 0.0, 0.0), np.full(80, press), "full", rate=125.0)


def test_a_dry_tuft_that_is_pushed_back_splits_until_it_is_brought_to_a_point():
    painters = [paint(r, surface=plane(0.25), hairs=1000, wipe=0.85) for r in
                (stroke(), pushed_back())]  # fmt: skip
    split = [painter.hairs.memory[SPLIT] for painter in painters]
    assert split[0] < 0.02
    assert split[1] > 0.3
    bare = []
    for painter in painters:  # widest gap across the way, over 20 mm of it
        x, y = painter.surface.mesh.vertices[:, :2].T
        here = (np.abs(x - 10.0) < 10.0) & (np.abs(y) < 3.0)
        by_lane = [painter.surface.coverage[here & (np.abs(y - lane) < 0.15)].mean()
                   for lane in np.arange(-2.7, 2.8, 0.3)]  # fmt: skip
        bare.append(min(by_lane) / max(by_lane))
    assert bare[1] < 0.8 * bare[0]
    painters[1].shape()
    assert painters[1].hairs.memory[SPLIT] == 0.0
    painters[1].replay(pushed_back())
    painters[1].dip()
    assert painters[1].hairs.memory[SPLIT] == 0.0


def test_a_wet_tuft_does_not_split():
    painter = paint(pushed_back(), hairs=400)
    assert painter.hairs.memory[SPLIT] == 0.0


def covered_area(painter):
    return (painter.surface.coverage * painter.surface.vertex_areas).sum()


@pytest.mark.parametrize("hairs", [0, 300])
def test_a_brush_turned_on_the_spot_lies_in_a_heap_and_draws_no_fan(hairs):
    by_angle = [covered_area(paint(turning(a, 60), hairs=hairs)) for a in (0.2, 1.5, 3.0, 6.0)]
    assert by_angle[1] < 2.3 * by_angle[0]  # a fan of 1.5 rad has 2.5 times as much
    assert by_angle[2:] == pytest.approx([by_angle[1]] * 2, rel=0.02)


@pytest.mark.parametrize("hairs", [0, 300])
def test_a_hand_that_trembles_does_not_heap_a_tuft(hairs):
    once, often = (covered_area(paint(turning(0.1, swings=n), hairs=hairs)) for n in (0, 40))
    assert often == pytest.approx(once, rel=0.05)


@pytest.mark.parametrize(("plasticity", "apart"), [(0.0, 0.005), (0.8, 0.02)])
@pytest.mark.parametrize(
    ("azimuth", "press"),
    long_but([("commanded", 0.2), ("dragged", 0.5)], product(("commanded", "dragged"), (0.2, 0.5))),
)
def test_wet_hairs_are_one_film_that_covers_what_a_solid_tuft_does(
    plasticity, apart, azimuth, press
):
    """Hairs remember their bend, and lift off a little behind where a solid tuft does."""
    brush = dataclasses.replace(load_brush("full"), plasticity=plasticity)
    at = np.stack(np.meshgrid(np.arange(-45.0, 40.0, 0.3), np.arange(-10.0, 10.0, 0.3)), axis=-1)
    covered = []
    for n in (0, 1000):
        painter = paint(stroke(press), surface=plane(0.3), brush=brush, hairs=n, azimuth=azimuth)
        vertices = painter.surface.mesh.vertices[:, :2].astype(float)
        away, nearest = cKDTree(vertices).query(at, k=3)
        share = 1.0 / (away + 1e-6)
        covered.append((painter.surface.coverage[nearest] * share).sum(-1) / share.sum(-1))
    solid, hairs = covered
    assert np.abs(hairs - solid).sum() < apart * solid.sum()


def test_no_two_imprints_are_further_apart_than_vertices_at_the_fastest_hair():
    painter = paint(turning(), surface=plane(0.5), hairs=300)
    tip = np.hypot(*covered(painter)[:, :2].T).max()
    assert tip > 10.0
    assert painter.report()["footprints"] * 0.5 >= 0.95 * 1.5 * (tip - 1.0)
    points, angles = covered(painter, 0.9), np.linspace(0.2, 0.8, 8)
    for radius in (6.0, 9.0):  # the fan has no gaps, until the tuft lies in a heap
        wanted = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        near = np.linalg.norm(points[None, :, :2] - wanted[:, None], axis=2).min(axis=1)
        assert near.max() < 0.5


def test_a_tuft_remembers_until_it_is_dipped_or_shaped():
    painter = paint(stroke(press=0.6), wipe=0.9)
    bent = np.hypot(*painter.hairs.memory[:2])
    assert bent > 0.5
    assert painter.hairs.memory[PARTED] > 0.3
    kept = painter.hairs.memory.copy()
    painter.replay(stroke(press=0.0))  # nothing touches
    assert (painter.hairs.memory == kept).all()
    painter.shape()
    assert not painter.hairs.memory[: PARTED + 1].any()
    painter.replay(stroke(press=0.6, y=8.0))
    assert painter.hairs.memory[PARTED] > 0.0
    painter.dip()
    assert not painter.hairs.memory.any()


def test_a_bent_tuft_lands_where_its_tip_stands():
    touches = []
    for first in (None, stroke(press=0.7)):
        painter = Painter(plane(0.3), "full", hairs=400)
        if first is not None:
            painter.replay(first)
            painter.surface.dry()
        painter.replay(stroke(press=0.04, start=-10.0, end=10.0, y=15.0))
        points = covered(painter, 0.3)
        touches.append(points[points[:, 1] > 11.0, 0].min())
    fresh, bent = touches
    assert bent < fresh - 0.2  # the bend points along -x


def test_kept_and_restored_paints_the_same():
    painter, other = (paint(stroke(y=-8.0), wipe=0.6) for _ in range(2))
    kept = painter.keep()
    load, memory = painter.hairs.load.copy(), painter.hairs.memory.copy()
    ink = painter.surface.ink.load.copy()
    painter.replay(stroke(y=8.0))
    first = painter.hairs.load.copy()
    assert (first != load).any()
    other.replay(stroke(y=-8.0))  # not where it paints later: what is covered takes no first film
    other.restore(kept)
    other.surface.ink.load[:] = ink
    assert (other.hairs.load == load).all()
    assert (other.hairs.memory == memory).all()
    other.replay(stroke(y=8.0))
    assert (other.hairs.load == first).all()


def test_a_brush_may_be_of_hairs_by_itself():
    spec = dataclasses.replace(load_brush("full"), bristles=BristleSpec(n_hairs=50))
    assert Painter(plane(), spec).report()["hairs"] == 50
    assert Painter(plane(), spec, hairs=0).report()["hairs"] == 0
    assert Painter(plane(), spec, hairs=20).report()["hairs"] == 20
    assert Painter(plane(), "full").report()["hairs"] == 0


@pytest.mark.parametrize("n", [1, 10])
def test_few_hairs_are_lines(n):
    painter = paint(stroke(), hairs=n, surface=plane(0.25))
    middle = np.abs(painter.surface.mesh.vertices[:, 0]) < MIDDLE
    area = (painter.surface.coverage * painter.surface.vertex_areas)[middle].sum()
    whole = paint(stroke(), hairs=0, surface=plane(0.25))
    middle = np.abs(whole.surface.mesh.vertices[:, 0]) < MIDDLE
    solid = (whole.surface.coverage * whole.surface.vertex_areas)[middle].sum()
    assert 0.0 < area < (0.1 if n == 1 else 0.95) * solid


@pytest.mark.parametrize("mesh", ["ball", "bowl"])
def test_hairs_paint_curved_surfaces(mesh):
    n = 30
    turn = np.linspace(-0.4, 0.4, n)
    if mesh == "ball":
        surface = PaintedSurface(ball(40.0), 0.5)
        normals = np.stack([np.sin(turn), np.zeros(n), np.cos(turn)], axis=1)
        points = 40.0 * normals
    else:
        surface = PaintedSurface(bowl(60.0), 0.5)
        normals = np.stack([-np.sin(turn), np.zeros(n), np.cos(turn)], axis=1)
        points = -60.0 * normals
    press = 0.4 * np.sin(np.pi * np.linspace(0.0, 1.0, n))
    recording = poses(points, normals, (0.0, 1.0, 0.0), press, "full", rate=125.0)
    painters = [Painter(surface, "full", hairs=600)]
    painters[0].replay(recording)
    assert balance(painters[0]) < 1e-6
    points = covered(painters[0])
    assert len(points) > 300
    if mesh == "bowl":  # the outer side stays bare
        assert (np.linalg.norm(points, axis=1) < 61.0).all()


def test_the_command_line_knows_how_many_hairs_there_can_be():
    assert [parse_hairs(text) for text in ("0", "1", str(MOST_HAIRS))] == [0, 1, MOST_HAIRS]
    for text in ("-1", str(MOST_HAIRS + 1), "2.5", "many", "", "9" * 30):
        with pytest.raises(ArgumentTypeError, match="expected 0 to 10000"):
            parse_hairs(text)


@pytest.mark.parametrize("hairs", [-3, 20_000, 2.5, "many", True])
def test_bad_hairs_are_named(hairs):
    with pytest.raises(InputError, match="hairs"):
        Painter(plane(), hairs=hairs)


# -- footprints of hairs -----------------------------------------------------------------------


UPWARD, BACK = (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)
PRESETS = sorted(json.loads(files("paint3d.brush").joinpath("presets.json").read_text()))
STANCES = [(tilt, press) for tilt in (90, 60, 45) for press in (0.25, 0.4, 0.7)]


def standing(painter, tilt, press):
    """Length and width of the footprint of a brush that stands pressed, mm."""
    still = np.zeros((6, 3))
    still[:, 0] = np.linspace(0.0, -0.02, 6)
    pressure, brush = np.full(6, press), painter.brush.name
    recording = poses(still, UPWARD, BACK, pressure, brush, np.radians(tilt), 125.0)
    painter.dip()
    painter.advance(sample_of(recording, k) for k in range(6))
    values = painter.stamp.values[0].copy()
    painter.finish()
    return values["tip"] - values["heel"], 2.0 * values["widest"]


@pytest.mark.parametrize("brush", PRESETS)
def test_hairs_and_solid_tuft_stand_alike(brush):
    surface = PaintedSurface(sheet(flat, (75.0, 40.0), 5.0), 0.5, "porcelain")
    painters = [Painter(surface, brush, hairs=n) for n in (0, 1000)]
    sizes = np.array([[standing(p, *stance) for stance in STANCES] for p in painters])
    off = np.abs(sizes[1] / sizes[0] - 1.0)
    assert (off[:, 0] <= 0.1).sum() >= 7
    assert off[:, 0].max() <= (0.14 if brush == "gongbi" else 0.13)  # 0.4 mm of the finest
    slim = 0.42 / sizes[0, :, 1]  # mm: hairs and their film are no thinner under a thin brush
    assert (off[:, 1] <= np.maximum(0.135, slim)).all()


@pytest.mark.parametrize(
    ("brush", "press", "tilt"),
    [("full", 0.25, 90), ("full", 0.4, 60), ("full", 0.7, 45), ("zhongkai", 0.4, 90),
     ("dabaiyun", 0.4, 60)],
)  # fmt: skip
def test_what_they_paint_standing_is_alike(brush, press, tilt):
    still = np.zeros((4, 3))
    still[:, 0] = [0.0, -0.03, -0.07, -0.1]  # mm: so much that it inks
    recording = poses(still, UPWARD, BACK, np.full(4, press), brush, np.radians(tilt), 125.0)
    found = [
        covered(paint(recording, surface=plane(0.3, (60.0, 15.0)), hairs=n, brush=brush))
        for n in (0, 1000)
    ]
    (length, width), (hair_length, hair_width) = (np.ptp(points[:, :2], axis=0) for points in found)
    assert hair_length == pytest.approx(length, rel=0.1)
    assert hair_width == pytest.approx(width, abs=max(0.1 * width, 0.7))  # two vertices


@pytest.mark.parametrize("tilt", [90, 60])
def test_a_light_touch_widens_without_steps(tilt):
    """Writing is done with the last millimetres of the tuft: a hair more must not be seen."""
    surface = PaintedSurface(sheet(flat, (75.0, 40.0), 5.0), 0.5, "porcelain")
    presses = np.arange(0.02, 0.122, 0.006)
    painters = [Painter(surface, "zhongbaiyun", hairs=n) for n in (0, 1000)]
    solid, hairs = (np.array([standing(p, tilt, press) for press in presses]) for p in painters)
    assert np.abs(hairs[:, 1] / solid[:, 1] - 1.0).max() < 0.2
    assert np.abs(hairs[:, 0] - solid[:, 0]).max() < 0.35  # mm
    assert np.diff(hairs[:, 1]).max() < 0.3  # mm, of both sides
    assert np.diff(hairs[:, 1]).min() > -0.05


@pytest.mark.parametrize("press", [0.05, 0.062, 0.2])
@pytest.mark.parametrize("tilt", [90, 60])
def test_what_touches_lies_on_the_paper(tilt, press):
    """No hair touches first where it hangs over the surface: half a millimetre on the straight line
    between two of its points is the most that its curve may lie below that."""
    surface = PaintedSurface(sheet(flat, (75.0, 40.0), 5.0), 0.5, "porcelain")
    painter = Painter(surface, "zhongbaiyun", hairs=1000)
    standing(painter, tilt, press)
    work = painter.hairs.work(surface)
    heights = work.points[:, :, 2 * BLOCK :].astype(float)  # block, point, hair
    hair_contacts = work.hair_contacts.astype(float)
    touching = 0
    for g, row in enumerate(hair_contacts):
        for j in range(BLOCK):
            begin, end = row[BEGIN + j], row[END + j]
            if end < 0.0:
                continue
            touching += 1
            height = np.interp(begin, np.arange(SAMPLES), heights[g, :, j])
            assert height <= 0.5, (g, j, begin, end)
    assert touching > 300


def painted(press, hairs, brush, way, material="porcelain"):
    n = len(press)
    points = np.zeros((n, 3))
    points[:, 0] = np.linspace(-0.5 * way, 0.5 * way, n)
    painter = Painter(
        PaintedSurface(sheet(flat, (45.0, 20.0), 5.0), 0.4, material), brush, hairs=hairs
    )
    painter.replay(poses(points, UPWARD, BACK, press, brush, rate=125.0))
    return painter


def widths_along(painter):
    """Width of what was painted, mm, in steps of 1 mm along the stroke."""
    points = painter.surface.mesh.vertices[painter.surface.coverage > 0.5].astype(float)
    at = np.floor(points[:, 0] + 45.0).astype(int)
    return np.array([np.ptp(points[at == k, 1]) if (at == k).any() else 0.0 for k in range(90)])


@pytest.mark.parametrize("brush", ["full", "zhongkai", "dabaiyun"])
def test_a_press_that_comes_and_goes_is_as_wide_everywhere(brush):
    press = 0.6 * np.sin(np.pi * np.linspace(0.0, 1.0, 40))
    solid, hairs = (widths_along(painted(press, n, brush, 16.0)) for n in (0, 1000))
    assert np.abs(hairs - solid).sum() < 0.09 * solid.sum()
    assert np.abs(hairs - solid).max() < 0.22 * solid.max()


@pytest.mark.parametrize("press", [0.04, 0.08])
def test_a_light_hand_gives_what_it_gives_with_a_solid_tuft(press):
    held = np.full(40, press)
    solid, hairs = (painted(held, n, "full", 24.0) for n in (0, 1000))
    assert hairs.ledger()["wet"] == pytest.approx(solid.ledger()["wet"], rel=0.1)
    assert hairs.surface.coverage.sum() == pytest.approx(solid.surface.coverage.sum(), rel=0.15)


def painted_round(radius, tilt, press, hairs):
    """A stroke of 36 mm along a sphere, from outside or (negative radius) from inside."""
    painter = Painter(
        PaintedSurface(sheet(on_sphere(radius), (30.0, 20.0), 2.5), 0.5, "porcelain"),
        "full", hairs=hairs,
    )  # fmt: skip
    angle, out = np.linspace(-18.0, 18.0, 40) / abs(radius), np.sign(radius)
    sine, cosine, none = np.sin(angle), np.cos(angle), np.zeros(40)
    points = np.stack([abs(radius) * sine, none, radius * (cosine - 1.0)], axis=1)
    normals = np.stack([out * sine, none, cosine], axis=1)
    back = np.stack([-cosine, none, out * sine], axis=1)
    for k in range(40):
        held = np.full(1, press)
        recording = poses(points[k : k + 1], normals[k], back[k], held, "full", np.radians(tilt))
        sample = sample_of(recording, 0)
        painter.advance([dataclasses.replace(sample, time_ns=8_000_000 * k)])
    painter.finish()
    return painter


@pytest.mark.parametrize("radius", long_but([75.0, -40.0], [75.0, 150.0, -40.0]))
@pytest.mark.parametrize(
    ("tilt", "press"),
    long_but(
        [(60, 0.05), (60, 0.3), (45, 0.15)],
        [(60, 0.05), (60, 0.15), (60, 0.3), (45, 0.15), (90, 0.15)],
    ),
)
def test_hairs_find_a_curved_surface_as_the_solid_tuft_does(radius, tilt, press):
    """How deep they are pressed counts from where the tuft touches, not from the plane there."""
    solid, hairs = (painted_round(radius, tilt, press, n) for n in (0, 1000))
    per_area = [
        p.ledger()["wet"] / (p.surface.coverage @ p.surface.vertex_areas) for p in (solid, hairs)
    ]  # the first film goes with what is covered
    assert per_area[1] == pytest.approx(per_area[0], rel=0.2)
    wide = [np.count_nonzero(p.surface.coverage > 0.5) for p in (solid, hairs)]
    assert 0.8 < wide[1] / wide[0] < 1.5


# -- tips that run dry -------------------------------------------------------------------------


CELL_MM = 0.25
THINNEST_MM = 0.4  # a wet hair


def lifted(n: int, brush: str) -> Recording:
    """A stroke along x that is lifted evenly from place 1 mm to where it ends, at 10 mm."""
    x = np.linspace(-8.0, 10.0, n)
    points = np.stack([x, 0.0 * x, 0.0 * x], axis=1)
    pressure = 0.42 * np.clip((10.0 - x) / 9.0, 0.0, 1.0)
    return poses(points, (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), pressure, brush, rate=125.0)


def dry_brush(hairs: int, load: float, place=flat, brush: str = "full") -> Painter:
    surface = PaintedSurface(sheet(place, (24.0, 7.0), 2.0), 0.15, "porcelain")
    painter = Painter(surface, brush, hairs=hairs)
    painter.wipe(1.0 - load)
    return painter


def widths_of_hairs(surface: PaintedSurface) -> np.ndarray:
    """Width of the mark (mm) in cells along x, from place 0 to its end."""
    vertices = np.asarray(surface.mesh.vertices, float)[surface.coverage > 0.3]
    cells = np.floor(vertices[:, 0] / CELL_MM).astype(int)
    return np.array([np.ptp(vertices[cells == k, 1]) for k in range(cells.max() + 1)])


@pytest.mark.parametrize("place", [flat, on_sphere(75.0)], ids=["flat", "ball"])
@pytest.mark.parametrize(
    ("hairs", "load"),
    long_but([(1000, 0.25), (100, 0.36)], [(1000, 0.36), (1000, 0.25), (100, 0.36)]),
)
def test_beyond_a_dry_tip_no_line_is_drawn(hairs, load, place):
    """Where most hairs have left the surface the few that have not draw no line on: it tapers."""
    painter = dry_brush(hairs, load, place)
    painter.replay(lifted(120, "full"))
    widths = widths_of_hairs(painter.surface)
    thin = len(widths) - 1 - np.flatnonzero(widths > THINNEST_MM)[-1]
    assert thin * CELL_MM <= 0.75
    assert -np.diff(widths).min() < 0.6


@pytest.mark.parametrize(
    ("brush", "load"),
    long_but(
        [("full", 0.5), ("full", 0.16), ("slender", 0.36)],
        product(("full", "slender"), (0.5, 0.36, 0.16)),
    ),
)
def test_the_outline_of_hairs_changes_without_jumps(brush, load):
    """Law 1 for hairs that are lifted: neither end of the outline, nor its width, jumps (mm)."""
    painter, recording = dry_brush(1000, load, brush=brush), lifted(180, brush)
    found = []
    for k in range(len(recording)):
        painter.advance([sample_of(recording, k)])
        values = painter.stamp.values[0]
        if 0.0 < recording.pressure[k] < 0.4 and values["touches"] > 0.0:
            found.append((values["heel"], values["tip"], values["widest"]))
    painter.finish()
    assert len(found) > 70
    assert np.abs(np.diff(found, n=2, axis=0)).max() < 0.15


def test_bundles_are_read_from_the_noise_of_the_tooth():
    """Four bytes to a number: a place, a step across, a step along, and both; it repeats."""
    noise, four = contact_noise().reshape(64, 64, 64), bundle_noise().view(np.int8)
    for layer, packed in zip((3, 35), four.reshape(2, 64, 64, 4), strict=True):
        for place, (across, along) in enumerate(((0, 0), (1, 0), (0, 1), (1, 1))):
            there = np.roll(noise[layer], (-across, -along), axis=(0, 1))
            assert (packed[:, :, place] == there).all()
    assert (four != 0).any()


def test_a_pigment_that_is_known_but_not_in_the_brush_changes_nothing() -> None:
    """As after a dip that was undone: what was painted before it is painted alike."""
    painted = []
    for others in ((), ("cinnabar", "indigo")):
        surface = plane(material="xuan")
        for name in ("pine soot", *others):
            surface.column_of(load_pigment(name))
        paint(stroke(brush="feibai"), surface=surface, hairs=None, brush="feibai")
        painted.append((surface.coverage.copy(), surface.amounts.sum(axis=1)))
    np.testing.assert_array_equal(painted[0][0], painted[1][0])
    np.testing.assert_allclose(painted[0][1], painted[1][1], rtol=1e-5, atol=1e-6)
