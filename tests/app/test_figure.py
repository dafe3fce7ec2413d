"""The brush that is drawn lies on the surface where the brush that paints does."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from paint3d.app.model.document import Document
from paint3d.app.model.frame import view_brush
from paint3d.app.model.input.hand import root_over
from paint3d.brush_engine.bristles.state import PARTED, SPLIT
from paint3d.core.quaternion import matrices_from_quaternions, quaternions_from_matrices
from paint3d.device.sample import DeviceSample
from paint3d.view import brush_shape
from paint3d.view.brush_shape import BrushStand, grid_faces, torn_faces, tuft_rings
from paint3d.view.kernels.drape import drape_points
from paint3d.view.live_brush import laid_rings
from tests.support.cases import long_but

MOST_MM = 0.3
N = 60
TURN = np.radians(-150.0)
CASES = [  # brush, azimuth, tilt, lean aside (degrees), pressure, turn on the spot (degrees)
    ("full", "commanded", 90, 0, 0.3, 0), ("full", "commanded", 40, 0, 0.8, 0),
    ("full", "commanded", 60, 25, 0.5, 0), ("full", "commanded", 75, 0, 0.6, 80),
    ("full", "dragged", 90, 0, 0.3, 0), ("full", "dragged", 60, 25, 0.8, 0),
    ("feibai", "commanded", 70, 0, 0.3, 0), ("feibai", "commanded", 70, 0, 0.8, 0),
    ("feibai", "dragged", 70, 0, 0.6, 0),
]  # fmt: skip


def on_plane(document):
    share = np.linspace(0.0, 1.0, N)
    places = np.stack([25.0 * share - 10.0, 6.0 * np.sin(2.5 * share), 0.0 * share], axis=1)
    return places, np.tile([0.0, 0.0, 1.0], (N, 1))


def in_bowl(document):
    """Around its inside, half-way up."""
    vertices = document.surface.source.vertices
    radius = 0.5 * np.linalg.norm(vertices[:, :2], axis=1).max()
    angle, above = np.linspace(0.0, 0.6, N), vertices[:, 2].max() + 5.0
    places = [radius * np.cos(angle), radius * np.sin(angle), np.full(N, above)]
    out, landed = np.zeros((N, 6)), np.zeros(N, np.uint8)
    tree, down = document.surface.contact_tree, np.array([0.0, 0.0, -1.0])
    drape_points(tree, np.stack(places, axis=1), down, 500.0, out, landed)
    assert landed.all()
    return out[:, :3].copy(), out[:, 3:].copy()


def held(brush, place, normal, bend, lean, pressure, time_ns):
    """A sample of a brush held over a place; `lean` against the bend and aside, rad."""
    bend = bend - (bend @ normal) * normal
    bend /= np.linalg.norm(bend)
    up = math.cos(lean[0]) * normal - math.sin(lean[0]) * bend
    up = math.cos(lean[1]) * up + math.sin(lean[1]) * np.cross(normal, bend)
    x = bend - (bend @ up) * up
    x /= np.linalg.norm(x)
    turned = quaternions_from_matrices(np.stack([x, np.cross(up, x), up], axis=1)[None])[0]
    root = root_over(brush, place, normal, bend, up, pressure)
    still = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    return DeviceSample(time_ns, root, turned, pressure, 0, *still, place.copy())


def stroke(document, tilt, aside, pressure, turn):
    """Samples of a stroke that ends pressed, and turned where it stands if it turns."""
    where = in_bowl if document.surface.source.name == "bowl" else on_plane
    places, normals = where(document)
    late = np.maximum(0.0, np.linspace(-1.0, 1.0, N))
    if turn:
        places[N // 2 :], normals[N // 2 :] = places[N // 2], normals[N // 2]
    lean = math.radians(90.0 - tilt), math.radians(aside)
    samples = []
    for k in range(N):
        angle = TURN + math.radians(turn) * late[k]
        bend = np.array([math.cos(angle), math.sin(angle), 0.1])
        press = pressure * min(1.0, 0.2 + 3.0 * k / N)
        at = document.painter.brush, places[k], normals[k], bend, lean, press
        samples.append(held(*at, time_ns=1_000_000_000 + 4_000_000 * k))
    return samples


def rested(samples, n=4):
    """Then the hand rests until all is painted."""
    last = samples[-1]
    return [replace(last, time_ns=last.time_ns + 4_000_000 * (k + 1)) for k in range(n)]


def painted(mesh, brush, *how, azimuth="commanded"):
    """A document with such a stroke, all of which is painted, and its last sample."""
    document = Document.new(mesh, 1.0, "porcelain", brush=brush)
    document.painter.azimuth = azimuth
    samples = stroke(document, *how)
    samples += rested(samples)
    document.begin_stroke()
    for k in range(0, len(samples), 16):
        document.feed(samples[k : k + 16])
    return document, samples[-1]


def stand_of(document, view):
    axes = matrices_from_quaternions(view.orientation[None])[0]
    return BrushStand.of(document.painter.tuft, view.position, axes, view.pressed)


def painted_outline(stamp):
    """(M, 2) mm, along and across from the stamp's origin."""
    values = stamp.values[0]
    reach = np.linspace(values["heel"], values["tip"], 65)
    fine = np.linspace(values["heel"], values["tip"], 400)
    half = np.interp(fine, reach, stamp.half_widths[:65])
    return np.concatenate([np.stack([fine, half], 1), np.stack([fine, -half], 1)[::-1]])


def in_plane(stamp, points):
    values = stamp.values[0]
    away = points - values["origin"]
    return np.stack([away @ values["bend"], away @ values["cross"]], axis=-1)


def apart(a, b):
    """The farthest that a point of one outline lies from the other, mm."""
    lines = []
    for line in (a, b):
        closed = np.concatenate([line, line[:1]])
        way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
        at = np.linspace(0.0, way[-1], 600)
        lines.append(np.stack([np.interp(at, way, closed[:, k]) for k in (0, 1)], axis=1))
    distance = np.linalg.norm(lines[0][:, None] - lines[1][None], axis=2)
    return max(distance.min(axis=0).max(), distance.min(axis=1).max())


def drawn_ground(tuft, stand):
    """(M, 3) mm: where the drawn tuft meets the plane of its stand, and what of it is below."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(brush_shape, "_LIFT", -np.inf)
        rings, _ = tuft_rings(tuft, stand)
    height = (rings - stand.origin) @ stand.axes[2]
    found = [rings[height <= 0.0]]
    pairs = [(rings[1:], height[1:], rings[:-1], height[:-1])]
    pairs.append((np.roll(rings, -1, 1), np.roll(height, -1, 1), rings, height))
    for other, high, here, low in pairs:
        crosses = (high <= 0.0) != (low <= 0.0)
        share = (low / np.where(crosses, low - high, 1.0))[crosses][:, None]
        found.append(here[crosses] + share * (other[crosses] - here[crosses]))
    return np.concatenate(found)


def hull(points):
    return points[ConvexHull(points).vertices]


def assert_alike(document, view):
    stamp, tuft, stand = document.painter.stamp, document.painter.tuft, stand_of(document, view)
    wanted = painted_outline(stamp)
    assert stamp.values[0]["touches"] > 0.0
    assert apart(in_plane(stamp, stand.outline()), wanted) < 0.1
    drawn = in_plane(stamp, drawn_ground(tuft, stand))
    assert apart(hull(drawn), hull(wanted)) < MOST_MM


@pytest.mark.parametrize("mesh", long_but(["bowl"], ["plane", "bowl"]))
@pytest.mark.parametrize(("brush", "azimuth", "tilt", "aside", "pressure", "turn"), CASES)
def test_the_figure_lies_where_the_stamp_does(
    mesh, brush, azimuth, tilt, aside, pressure, turn
) -> None:
    document, last = painted(mesh, brush, tilt, aside, pressure, turn, azimuth=azimuth)
    assert_alike(document, view_brush(document, last))
    if turn:
        assert document.painter.stamp.values[0]["bent"] < 0.2  # it lies in a heap


def test_before_the_painter_comes_there_the_figure_has_gone_on() -> None:
    """What is drawn for a sample that still waits is what is painted when it comes."""
    document = Document.new("plane", 1.0, "porcelain", brush="full")
    document.painter.azimuth = "dragged"
    samples = stroke(document, 70, 0, 0.6, 0)
    document.begin_stroke()
    document.feed(samples)
    behind = document.painter.stamp.values[0]["origin"].copy()
    view = view_brush(document, samples[-1])
    assert np.linalg.norm(behind - view.pressed.origin) > 0.5
    document.feed(rested(samples))
    assert_alike(document, view)


def test_in_a_bowl_all_that_lies_is_seen() -> None:
    document, last = painted("bowl", "full", 40, 0, 0.8, 0)
    tuft, stand = document.painter.tuft, stand_of(document, view_brush(document, last))
    rings, _ = tuft_rings(tuft, stand)
    normal, tree = stand.axes[2], document.surface.contact_tree
    lies = (rings - stand.origin) @ normal < 0.13
    laid = laid_rings(tuft, rings, stand, tree)[lies]
    out, landed = np.zeros((len(laid), 6)), np.zeros(len(laid), np.uint8)
    drape_points(tree, laid + 20.0 * normal, -normal, 60.0, out, landed)
    over = np.einsum("kc,kc->k", laid - out[:, :3], out[:, 3:])
    assert landed.all()
    assert 0.0 < over.min() <= over.max() < MOST_MM


def test_a_tuft_that_has_split_is_drawn_apart() -> None:
    document, last = painted("plane", "feibai", 70, 0, 0.6, 0)
    drawn = []
    for split in (0.0, 1.0):
        document.painter.hairs.memory[[PARTED, SPLIT]] = 0.0, split
        stand = stand_of(document, view_brush(document, last))
        tuft = document.painter.tuft
        rings, _ = tuft_rings(tuft, stand)
        drawn.append((rings @ stand.axes[1], torn_faces(tuft, stand.pressed)))
    (whole, none), (apart_, faces) = drawn
    assert none is None
    assert len(faces) < len(grid_faces(len(whole)))
    ring = len(whole) // 4
    gaps = [np.diff(np.sort(across[ring])).max() for across in (whole, apart_)]
    assert gaps[1] > 2.0 * gaps[0]
    assert np.ptp(apart_[ring]) == pytest.approx(np.ptp(whole[ring]), rel=0.02)
