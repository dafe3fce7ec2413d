"""Bending the hairs of a tuft, and painting with them, on one core.

One imprint bent on a plane and on a curved patch; and a stroke in the bowl, with 1,000 hairs and
with a solid tuft.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from paint3d.bench.kernels.standing_bristles import bend_often, deposit_hairs_often, deposit_often
from paint3d.bench.result import Check, Result
from paint3d.bench.stopwatch import alternate
from paint3d.bench.strokes import make_dab, record_dabs, refined_surface
from paint3d.brush.bending import build_tuft
from paint3d.brush.bristles import build_bristles
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BristleSpec
from paint3d.brush_engine.bristles import bend as bt
from paint3d.brush_engine.footprint import make_stamp
from paint3d.device.recorded import Recording
from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["measure"]

_BRUSH = "full"
_COUNTS = (1, 10, 100, 1_000, 10_000)
_WANTED_MS = {1_000: 0.010, 10_000: 0.080}
_MOST_CURVED = 2.5  # times the plane
_VERTICES = 1_000_000
_SAMPLES = 600
_ROUNDS = 60
_STROKES = 4
_DEPOSITS = 60
_MOST_DEPOSIT = 1.0  # times the solid tuft's
_HAIRS_A_ROUND = 1_000_000
_CURVED = np.array([0.0, 0.02, -0.01, -0.01, 0.0, -0.01])  # a ball of 50 mm radius


class HairBend:
    """An imprint of a tuft of hairs to be bent repeatedly: table, contact, 8 points a hair.

    Parameters
    ----------
    n_hairs : int
    patch : (6,) float64
        The surface; see `paint3d.brush_engine.bristles.ground_fit`.
    """

    def __init__(self, n_hairs: int, patch: NDArray[np.float64]) -> None:
        spec = load_brush(_BRUSH)
        self._tuft, hairs = build_tuft(spec), BristleSpec(n_hairs=n_hairs)
        self._bristles = build_bristles(spec, hairs)
        blocks = len(self._bristles.lengths)
        self._turned = bt.make_turned(blocks)
        bt.turn_hairs(self._bristles, 1.0, 0.0, self._turned)
        self._bend, self._block = np.zeros(1, bt.BEND), bt.make_block()
        self.points = bt.make_points(blocks)
        self._cause = bt.Cause(
            descent=0.45 * spec.full_press_mm,
            tilt=0.5 * math.pi,
            pressure=0.45,
            patch=patch,
            dryness=0.0,
            parted=0.0,
            split=0.0,
            set_x=0.0,
            set_y=0.0,
        )

    def run(self, times: int) -> None:
        """Bend all hairs so many times."""
        bend_often(
            times, self._bristles, self._tuft, self._cause, self._turned, self._bend, self._block,
            self.points,
        )  # fmt: skip


def _in_the_bowl(surface: PaintedSurface, n: int) -> Recording:
    """Record a stroke of circles on the floor of the bowl, one sample a millisecond."""
    assert surface.mesh.normals is not None, "the bowl has them"
    floor = surface.mesh.vertices[surface.mesh.normals[:, 2] > 0.9]
    dab = make_dab(_BRUSH, 0.4)
    turn = np.linspace(0.0, 0.01 * n, n)
    centres = np.column_stack([8.0 * np.cos(turn), 8.0 * np.sin(turn), np.zeros(n)])
    centres[:, 2] = float(floor[np.hypot(floor[:, 0], floor[:, 1]) < 10.0, 2].max())
    recording = record_dabs(dab, centres)
    return replace(recording, time_ns=recording.time_ns // 5)


def time_strokes(scale: float = 1.0) -> tuple[dict[int, tuple[float, int, int]], float]:
    """Time strokes in the bowl, with 1,000 hairs and with a solid tuft.

    Returns
    -------
    strokes : dict
        By hairs (0: solid), CPU ms an imprint, imprints, and the bowl's vertices.
    deposit : float
        See `time_deposits`.
    """
    surface = refined_surface(load_mesh("bowl"), max(100, int(_VERTICES * scale)))
    recording = _in_the_bowl(surface, max(60, int(_SAMPLES * scale)))
    painters, counts = {}, {}
    for n in (0, 1_000):
        painter = painters[n] = Painter(surface, _BRUSH, hairs=n)
        painter.replay(recording)
        before = painter.report()["footprints"]
        painter.replay(recording)
        counts[n] = painter.report()["footprints"] - before

    def stroke(n: int) -> None:
        painters[n].dip()
        painters[n].replay(recording)

    best = alternate(_STROKES, {str(n): partial(stroke, n) for n in painters})
    strokes = {
        n: (1e3 * best[str(n)].cpu_s / counts[n], counts[n], surface.n_vertices) for n in painters
    }
    return strokes, time_deposits(painters[1_000], recording, max(4, int(_DEPOSITS * scale)))


def time_deposits(painter: Painter, recording: Recording, times: int) -> float:
    """Measure the ratio of the times that hairs and a solid tuft take to deposit an imprint.

    From the imprint drawn to ink on vertices, `times` times, by turns.
    """
    surface, hairs = painter.surface, painter.hairs
    painter.dip()
    painter.replay(recording.part(0, len(recording) - 1))
    before = make_stamp()
    for copy, last in zip(before, painter.stamp, strict=True):
        copy[:] = last
    painter.dip()
    painter.replay(recording)
    stamps = (before, painter.stamp)
    work = (surface.paint_mesh.arrays, surface.ink, painter.scratch)
    assert hairs is not None, "it is a tuft of hairs"
    own = hairs.work(surface)
    best = alternate(
        _ROUNDS,
        {
            "hairs": partial(deposit_hairs_often, times, *stamps, own, *work),
            "solid": partial(deposit_often, times, *stamps, painter.tuft, *work),
        },
    )
    return best["hairs"].cpu_s / best["solid"].cpu_s


def measure(scale: float = 1.0) -> Result:
    """Measure an imprint: 1 to 10,000 hairs on a plane and on a patch, 1,000 in the bowl."""
    rounds = max(2, int(_ROUNDS * scale))
    rows, checks = [], []
    for n in _COUNTS:
        times = max(1, int(_HAIRS_A_ROUND * scale) // max(n, 200))
        bends = {name: HairBend(n, p) for name, p in (("plane", bt.FLAT), ("curved", _CURVED))}
        for bend in bends.values():
            bend.run(1)
        best = alternate(rounds, {name: partial(bend.run, times) for name, bend in bends.items()})
        plane, curved = (1e3 * best[name].cpu_s / times for name in ("plane", "curved"))
        rows.append([n, plane, curved, curved / plane, 1e6 * plane / n])
        if n in _WANTED_MS:
            checks.append(Check(f"{n:,} hairs on a plane", plane, _WANTED_MS[n], unit="ms"))
            checks.append(Check(f"{n:,} hairs, curved over plane", curved / plane, _MOST_CURVED))
    strokes, deposit = time_strokes(scale)
    solid, (hairs, imprints, vertices) = strokes[0][0], strokes[1_000]
    checks.append(Check("depositing 1,000 hairs over a solid tuft", deposit, _MOST_DEPOSIT))
    checks.append(Check("cores for 500 imprints/s of 1,000 hairs in the bowl", 0.5 * hairs, 0.5))
    return Result(
        "An imprint of hairs: deformation, contact and 8 points a hair, on one core",
        ["hairs", "plane, CPU ms", "curved, CPU ms", "curved/plane", "plane, ns/hair"],
        rows,
        checks,
        [
            f"Painting in a bowl of {vertices:,} vertices, all included: {hairs:.3f} ms an imprint "
            f"with 1,000 hairs ({imprints:,} imprints), {solid:.3f} ms a footprint of the solid "
            f"tuft ({strokes[0][1]:,})."
        ],
    )
