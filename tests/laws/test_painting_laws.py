"""Laws of painting: ink is kept, a replay repeats, and neither rate nor order nor place matters."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.core.quaternion import multiply_quaternions, quaternions_from_matrices
from paint3d.device.sample import DIP
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.colour_codes import worth_of_one_code
from tests.support.examples import examples
from tests.support.resampling import resample
from tests.support.surface_cases import UPRIGHT, ball, flat, on_cylinder, poses, sheet

LENGTH, FULL_PRESS = 35.0, 17.5  # of the brush "full"
LAW = settings(deadline=None, max_examples=examples(25))


def smooth(u, a: float, b: float):
    """0 before a, 1 after b, smooth between."""
    x = np.clip((u - a) / (b - a), 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def natural(rate: float = 1000.0, force: bool = True, press: float = 0.45) -> Recording:
    """A curved stroke as a hand makes it: lands, presses, turns and leans the brush, leaves."""
    seconds = 1.2
    t = np.arange(int(seconds * rate) + 1) / rate
    u = t / seconds
    way = smooth(u, 0.1, 0.9)
    pressure = press * smooth(u, 0.08, 0.3) * (1.0 - smooth(u, 0.72, 0.93))
    pressure *= 1.0 + 0.25 * np.sin(9.0 * u)
    azimuth = 0.8 * np.pi + 1.2 * np.sin(3.0 * u)
    lean = 0.25 * np.sin(2.0 * u)
    bend = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(u)], axis=1)
    side = np.cross([0.0, 0.0, 1.0], bend)
    frames = np.stack([bend, side, np.tile([0.0, 0.0, 1.0], (len(u), 1))], axis=2)
    frames = Rotation.from_rotvec(-lean[:, None] * side).as_matrix() @ frames
    lifted = 3.0 * (1.0 - smooth(u, 0.0, 0.08)) + 3.0 * smooth(u, 0.93, 1.0)
    descent = np.where(pressure > 0.0, pressure * FULL_PRESS, -lifted)
    height = LENGTH * np.cos(lean) - descent
    position = np.stack([60.0 * way - 30.0, 12.0 * np.sin(2.2 * np.pi * way), height], axis=1)
    return Recording(
        np.round(t * 1e9).astype(np.int64),
        position,
        quaternions_from_matrices(frames),
        pressure if force else None,
    )


def line(
    a, b, press: float = 0.4, n: int = 12, along=(0.0, 1.0, 0.0), brush: str = "full"
) -> Recording:
    """A straight stroke on z = 0 that lands and leaves."""
    share = np.linspace(0.0, 1.0, n)[:, None]
    points = np.column_stack([np.asarray(a, float) + share * np.subtract(b, a), np.zeros(n)])
    pressure = press * np.sin(np.pi * share[:, 0])
    return poses(points, (0.0, 0.0, 1.0), along, pressure, brush, rate=125.0)


def plane(half: float = 50.0) -> TriangleMesh:
    return sheet(flat, (half, half), 6.0)


def paint(mesh, *recordings, brush="full", resolution=0.6, uniform=False, **options) -> Painter:
    surface = PaintedSurface(mesh, resolution)
    if uniform:
        surface.refine_all()
    painter = Painter(surface, brush, **options)
    for recording in recordings:
        painter.replay(recording)
    return painter


def bytes_of(painter: Painter) -> bytes:
    surface = painter.surface
    arrays = (surface.amounts, surface.coverage, surface.srgb, surface.paint_mesh.vertices)
    return b"".join(a.tobytes() for a in arrays)


def by_place(surface) -> dict:
    """Vertex ids by what tells a vertex from all others, whatever its id."""
    keys = surface.paint_mesh.arrays.key[: surface.n_vertices]
    normals = surface.paint_mesh.normals
    return {(int(k), n.tobytes()): i for i, (k, n) in enumerate(zip(keys, normals, strict=True))}


def matched(a: PaintedSurface, b: PaintedSurface) -> tuple[np.ndarray, np.ndarray]:
    """Ids of the vertices that both have; all painted ones are among them."""
    ours, theirs = by_place(a), by_place(b)
    shared = sorted(ours.keys() & theirs.keys())
    i, j = np.array([ours[k] for k in shared]), np.array([theirs[k] for k in shared])
    for surface, ids in ((a, i), (b, j)):
        assert np.count_nonzero(surface.coverage[ids]) == np.count_nonzero(surface.coverage)
    return i, j


# -- 1. ink ---------------------------------------------------------------------------------------


def balance(painter: Painter) -> float:
    """Relative error of the account."""
    ledger = painter.ledger()
    there = sum(ledger[k] for k in ("in_brush", "wet", "dry", "off_surface"))
    return abs(there / ledger["loaded"] - 1.0)


@given(
    seed=st.integers(0, 10_000),
    brush=st.sampled_from(["full", "slender", "xiaokai"]),
    azimuth=st.sampled_from(["commanded", "dragged"]),
)
@settings(LAW, max_examples=25)
def test_ink_is_kept(seed, brush, azimuth):
    rng = np.random.default_rng(seed)
    painter = Painter(PaintedSurface(plane(30.0), 0.8), brush, azimuth=azimuth)
    for _ in range(4):
        a, b = rng.uniform(-40.0, 40.0, (2, 2))  # some strokes lead over the edge
        painter.replay(line(a, b, rng.uniform(0.1, 0.9), brush=brush))
        if rng.random() < 0.5:
            painter.dip("cinnabar" if rng.random() < 0.5 else None)
    assert balance(painter) < 1e-6
    assert painter.ledger()["in_brush"] < painter.ledger()["loaded"]
    assert painter.surface.amounts.min() >= 0.0


@pytest.mark.parametrize("hairs", [0, 300])
def test_a_wet_brush_leaves_a_film_where_it_comes_however_lightly(hairs):
    """Starts and ends are not seen through: their film is not much thinner than the rest."""
    surface = PaintedSurface(plane(30.0), 0.5, "xuan")
    Painter(surface, hairs=hairs).replay(line((-20, 0), (20, 0), 0.4, n=60))
    whole = surface.coverage > 0.95
    mesh = surface.paint_mesh
    coats = surface.amounts[whole].sum(axis=1) / mesh.arrays.take[: mesh.n_vertices][whole]
    assert np.percentile(coats, 1) > 0.75 * np.median(coats)


def test_paper_that_has_drunk_takes_less_and_glaze_does_not():
    """A stroke runs into a wet one that it crosses instead of lying on it like a sheet of film."""
    again = {}
    for material in ("xuan", "porcelain"):
        surface = PaintedSurface(plane(30.0), 0.5, material)
        painter = Painter(surface)
        recording = line((-20, 0), (20, 0), 0.4, n=60)
        painter.replay(recording)
        once = painter.surface.wet_ink()
        painter.replay(recording)
        again[material] = painter.surface.wet_ink() / once - 1.0
    assert again["xuan"] < 0.25
    assert again["xuan"] < 0.6 * again["porcelain"]


def test_ink_runs_off_the_edge():
    inside = paint(plane(30.0), line((-15, 0), (10, 0)))
    across = paint(plane(30.0), line((10, 0), (36, 0), along=(1.0, 0.0, 0.0)))
    assert inside.ledger()["off_surface"] == 0.0
    assert across.ledger()["off_surface"] > 0.05 * across.ledger()["wet"]
    assert balance(across) < 1e-6


def test_a_dip_fills_the_brush_again():
    recording = line((-20, 0), (20, 0), n=40)
    buttons = np.zeros(40, np.int32)
    pressure = np.array(recording.pressure)
    buttons[20], pressure[19:22] = DIP, 0.0
    dipped = dataclasses.replace(recording, buttons=buttons, pressure=pressure)
    once = paint(plane(), dataclasses.replace(recording, pressure=pressure))
    twice = paint(plane(), dipped)
    assert twice.in_brush() > once.in_brush()
    assert twice.loaded > twice.tuft.load
    assert balance(twice) < 1e-6


def test_a_brush_runs_dry():
    painter = Painter(PaintedSurface(plane(), 0.8), "gongbi")
    for _ in range(4):
        painter.replay(line((-30, 0), (30, 0), 0.6, brush="gongbi"))
    assert 0.0 < painter.in_brush() < 0.5 * painter.tuft.load
    assert balance(painter) < 1e-6


# -- 2. repeatable --------------------------------------------------------------------------------


@pytest.mark.parametrize("chunk", [1, 2, 7, 1000])
@pytest.mark.parametrize("force", [True, False])
def test_live_painting_equals_replay(chunk, force):
    recording = natural(125.0, force)
    whole = paint(plane(), recording)
    live = Painter(PaintedSurface(plane(), 0.6), "full")
    samples = list(recording.samples())
    for start in range(0, len(samples), chunk):
        live.advance(samples[start : start + chunk])
    live.finish()
    assert bytes_of(live) == bytes_of(whole)
    assert live.ledger() == whole.ledger()
    assert live.report()["samples"] == whole.report()["samples"] == len(recording)


def test_replay_is_repeatable():
    first, second = (paint(plane(), natural(125.0)) for _ in range(2))
    assert bytes_of(first) == bytes_of(second)


CHILD = """
import hashlib
from tests.laws.test_painting_laws import bytes_of, natural, paint, plane
print(hashlib.sha256(bytes_of(paint(plane(), natural(125.0)))).hexdigest())
"""


def test_the_number_of_threads_does_not_matter():
    import os
    from pathlib import Path

    digests = set()
    for threads in ("1", "2"):
        environment = {**os.environ, "NUMBA_NUM_THREADS": threads}
        environment["PYTHONPATH"] = os.pathsep.join(p for p in sys.path if p)
        done = subprocess.run(
            [sys.executable, "-c", CHILD],
            capture_output=True,
            text=True,
            check=True,
            env=environment,
            cwd=Path(__file__).parents[2],
        )
        digests.add(done.stdout.strip())
    assert len(digests) == 1


# -- 3. where it is does not matter ---------------------------------------------------------------


def moved(mesh: TriangleMesh, recording: Recording, turn: Rotation, by) -> tuple:
    w_last = turn.as_quat()
    q = np.array([w_last[3], *w_last[:3]])
    return (
        TriangleMesh(turn.apply(mesh.vertices.copy()) + by, mesh.faces),
        dataclasses.replace(
            recording,
            position=turn.apply(recording.position.copy()) + by,
            orientation=multiply_quaternions(
                np.tile(q, (len(recording), 1)), recording.orientation
            ),
        ),
    )


@functools.cache
def unmoved() -> tuple[TriangleMesh, Recording, Painter]:
    """A sheet, a stroke, and who painted it."""
    mesh, recording = sheet(on_cylinder(60.0), (50.0, 40.0), 3.0), natural(125.0)
    return mesh, recording, paint(mesh, recording)


@given(seed=st.integers(0, 10_000))
@LAW
def test_moving_mesh_and_brush_together_changes_nothing(seed):
    rng = np.random.default_rng(seed)
    mesh, recording, here = unmoved()
    turn = Rotation.random(random_state=seed)
    there = paint(*moved(mesh, recording, turn, rng.uniform(-80.0, 80.0, 3)))
    wet = [p.ledger()["wet"] for p in (here, there)]
    area = [float(p.surface.vertex_areas @ p.surface.coverage) for p in (here, there)]
    assert wet[1] == pytest.approx(wet[0], rel=3e-3)
    assert area[1] == pytest.approx(area[0], rel=1e-2)


def test_moving_both_hands_changes_nothing():
    recording = natural(125.0)
    turn = Rotation.from_rotvec([0.3, -0.7, 1.1])
    w_last = turn.as_quat()
    q = np.tile([w_last[3], *w_last[:3]], (len(recording), 1))
    both = dataclasses.replace(
        moved(plane(), recording, turn, (5.0, -3.0, 8.0))[1],
        object_position=np.tile([5.0, -3.0, 8.0], (len(recording), 1)),
        object_orientation=q,
    )
    here, there = paint(plane(), recording), paint(plane(), both)
    i, j = matched(here.surface, there.surface)
    np.testing.assert_allclose(
        there.surface.coverage[j], here.surface.coverage[i], atol=1e-5, rtol=0.0
    )


# -- 4. how often the device was read does not matter ---------------------------------------------


@pytest.mark.parametrize("force", [True, False])
@pytest.mark.parametrize("rate", [250.0, 60.0])
def test_the_rate_does_not_matter(rate, force):
    recording = natural(1000.0, force)
    fine = paint(plane(), recording, resolution=0.4)
    coarse = paint(plane(), resample(recording, rate), resolution=0.4)
    i, j = matched(fine.surface, coarse.surface)
    one, two = fine.surface.coverage[i], coarse.surface.coverage[j]
    painted = (one > 0.0) | (two > 0.0)
    codes = [s.srgb[k[painted]] for s, k in ((fine.surface, i), (coarse.surface, j))]
    colours = [lab_from_srgb(one) for one in codes]
    difference = delta_e(*colours)
    assert difference.mean() < 0.25
    lightest, darkest = (colours[0][pick(colours[0][:, 0])] for pick in (np.argmax, np.argmin))
    contrast = delta_e(lightest, darkest)
    # all of these lie on the edge, which is crisp: there the ink's own darkness counts
    assert np.percentile(difference, 99) < 0.06 * contrast
    whole = np.minimum(one, two)[painted] > 0.999
    beyond_codes = difference - worth_of_one_code(codes[0])
    assert np.percentile(beyond_codes[whole], 99.5) < 0.25
    area = fine.surface.vertex_areas[i]
    both, either = (one >= 0.5) & (two >= 0.5), (one >= 0.5) | (two >= 0.5)
    assert area[both].sum() > 0.99 * area[either].sum()
    assert coarse.ledger()["wet"] == pytest.approx(fine.ledger()["wet"], rel=5e-3)


@pytest.mark.parametrize("hairs", [0, 60])
@pytest.mark.parametrize("rate", [1000.0, 4000.0])
def test_noise_of_a_quick_device_gives_no_ink(rate, hairs):
    """A pen that stands for a second, or creeps, gives what its way asks for and no more."""
    n = int(rate)
    rng = np.random.default_rng(3)

    def creeping(step: int, noise: float) -> Recording:
        along = np.concatenate([np.zeros(n), np.linspace(0.0, 8.0, n), np.full(n, 8.0)])[::step]
        points = np.column_stack([along, np.zeros(len(along)), np.zeros(len(along))])
        points[:, :2] += rng.uniform(-noise, noise, (len(along), 2))
        return poses(
            points, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), np.full(len(along), 0.4), "full",
            rate=rate / step,
        )  # fmt: skip

    noisy, clean = (
        paint(plane(20.0), creeping(*how), resolution=0.4, hairs=hairs).surface
        for how in ((1, 0.01), (n // 50, 0.0))
    )
    assert noisy.wet_ink() == pytest.approx(clean.wet_ink(), rel=0.03)


# -- 5. no gaps -----------------------------------------------------------------------------------


def turning(n, angle):
    """A press that turns on the spot in n - 1 steps, painted."""
    turn = np.linspace(0.0, angle, n)
    along = np.stack([np.cos(turn), np.sin(turn), np.zeros(n)], axis=1)
    return paint(plane(20.0), poses(np.zeros((n, 3)), (0.0, 0.0, 1.0), along, np.full(n, 0.4)))


@pytest.mark.parametrize("n", [2, 3, 20])
def test_turning_on_the_spot_leaves_no_gaps(n):
    """What a tuft turns by before it heaps is painted as a fan without spokes, in any steps."""
    painter = turning(n, 0.7)
    vertices, coverage = painter.surface.paint_mesh.vertices, painter.surface.coverage
    radius = np.linalg.norm(vertices[:, :2], axis=1)
    turned = np.arctan2(vertices[:, 1], vertices[:, 0])
    ring = (radius > 4.5) & (radius < 9.5) & (turned > 0.0) & (turned < 0.65)
    assert ring.sum() > 150
    assert coverage[ring].min() == 1.0


def test_half_a_turn_on_the_spot_is_the_same_in_any_steps():
    first, *others = (turning(n, np.pi) for n in (400, 20, 3))
    areas = [float((p.surface.coverage * p.surface.vertex_areas).sum()) for p in (first, *others)]
    assert areas[1:] == pytest.approx(areas[:1] * 2, rel=0.02)


def test_a_fast_stroke_leaves_no_gaps():
    painter = paint(plane(), line((-40.0, 0.0), (30.0, 0.0), n=6))
    vertices, coverage = painter.surface.paint_mesh.vertices, painter.surface.coverage
    middle = (np.abs(vertices[:, 0] + 5.0) < 10.0) & (np.abs(vertices[:, 1] - 6.5) < 1.5)
    assert middle.sum() > 100
    assert coverage[middle].min() == 1.0


# -- 6, 7. refinement and order -------------------------------------------------------------------


@pytest.mark.parametrize("shape", ["plane", "ball"])
def test_lazy_refinement_paints_what_uniform_does(shape):
    if shape == "plane":
        mesh, recording = plane(30.0), natural(125.0, press=0.3)
    else:
        mesh = ball(30.0, 4.0)
        angle = np.linspace(-0.5, 0.5, 15)
        normal = np.stack([np.sin(angle), np.zeros(15), np.cos(angle)], axis=1)
        pressure = 0.3 * np.cos(np.pi * angle)
        recording = poses(30.0 * normal, normal, (0.0, 1.0, 0.0), pressure)
    lazy = paint(mesh, recording).surface
    uniform = paint(mesh, recording, uniform=True).surface
    assert uniform.n_vertices > lazy.n_vertices
    i, j = matched(lazy, uniform)
    order = np.argsort(i)
    i, j = i[order], j[order]
    painted = lazy.coverage[i] > 0.0
    np.testing.assert_array_equal(lazy.coverage[i], uniform.coverage[j])
    np.testing.assert_array_equal(lazy.amounts[i], uniform.amounts[j])
    np.testing.assert_array_equal(lazy.vertex_areas[i][painted], uniform.vertex_areas[j][painted])


@functools.cache
def crossing(order: tuple[int, ...]) -> PaintedSurface:
    """Four strokes that cross, in an order."""
    strokes = [
        line((-20, -5), (15, 8)),
        line((-10, 15), (20, -15), 0.6),
        line((0, -20), (2, 20), 0.2),
        line((-25, 10), (25, 12), 0.3),
    ]
    return paint(plane(40.0), *(strokes[k] for k in order)).surface


ORDERS = list(itertools.permutations(range(4)))[1:]


@pytest.mark.parametrize("order", [pytest.param(order, marks=pytest.mark.long if k % 4 else ())
                                   for k, order in enumerate(ORDERS)])  # fmt: skip
def test_any_order_of_strokes_paints_the_same_vertices(order):
    one, two = crossing((0, 1, 2, 3)), crossing.__wrapped__(order)
    i, j = matched(one, two)
    np.testing.assert_array_equal(one.coverage[i], two.coverage[j])
    assert one.n_vertices == two.n_vertices


# -- 9. the dragged tip ---------------------------------------------------------------------------


def heading(painter: Painter) -> np.ndarray:
    """Where the tip points from the foot point, at the last stamp that touched (in the plane)."""
    return painter.stamp.values[0]["bend"][:2]


@pytest.mark.parametrize("tilt", [UPRIGHT, 1.2])
def test_the_dragged_tip_trails(tilt):
    n = 40
    points = np.column_stack([np.linspace(-20, 20, n), np.zeros((n, 2))])
    ahead = poses(points, (0.0, 0.0, 1.0), (0.6, 0.8, 0.0), np.full(n, 0.4), tilt=tilt)
    painter = paint(plane(), azimuth="dragged")
    painter.replay(ahead)
    assert heading(painter) == pytest.approx([-1.0, 0.0], abs=0.02)


def test_a_dragged_corner_follows_the_tractrix():
    """tan(delta / 2) falls as exp(-s / l) after a right corner."""
    from paint3d.brush_engine.drag import drag_length

    painter = paint(plane(), azimuth="dragged")
    slack = drag_length(0.4 * FULL_PRESS, LENGTH, painter.tuft.drag_fraction)
    way = 1.3 * slack
    x = np.concatenate([np.linspace(-40.0, 0.0, 60), np.zeros(30)])
    y = np.concatenate([np.zeros(60), np.linspace(0.0, way, 31)[1:]])
    points = np.column_stack([x, y, np.zeros(90)])
    recording = poses(points, (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), np.full(90, 0.4))
    painter.replay(recording)
    bend = heading(painter)
    left = np.arccos(np.clip(-bend[1], -1.0, 1.0))
    law = 2.0 * np.arctan(np.tan(0.25 * np.pi) * np.exp(-1.3))
    assert left == pytest.approx(law, abs=0.06)
