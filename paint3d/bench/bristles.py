"""Bending the hairs of a tuft: one imprint on a plane and on a curved patch, on one core."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from numpy.typing import NDArray

from paint3d.bench.result import Check, Result
from paint3d.bench.stopwatch import alternate
from paint3d.brush.bending import build_tuft
from paint3d.brush.bristle_spec import BristleSpec
from paint3d.brush.bristles import build_bristles
from paint3d.brush.presets import load_brush
from paint3d.kernels import bristle_tuft as bt
from paint3d.kernels.bristle_standing import bend_often

__all__ = ["HairBend", "measure"]

_BRUSH = "full"
_COUNTS = (1, 10, 100, 1_000, 10_000)
_WANTED_MS = {1_000: 0.010, 10_000: 0.080}
_MOST_CURVED = 2.5  # times the plane
_ROUNDS = 60
_HAIRS_A_ROUND = 1_000_000
_CURVED = np.array([0.0, 0.02, -0.01, -0.01, 0.0, -0.01])  # a ball of 50 mm radius


class HairBend:
    """One imprint of a tuft of hairs, bent again and again: table, contact, 8 points a hair.

    Parameters
    ----------
    n_hairs : int
    patch : (6,) float64
        The surface; see `paint3d.kernels.bristle_patch`.
    """

    def __init__(self, n_hairs: int, patch: NDArray) -> None:
        spec = load_brush(_BRUSH)
        self._tuft, hairs = build_tuft(spec), BristleSpec(n_hairs=n_hairs)
        self._bristles = build_bristles(spec, hairs)
        blocks = len(self._bristles.lengths)
        self._turned = np.zeros((blocks, bt.KNOWN * bt.BLOCK), np.float32)
        bt.turn_hairs(self._bristles, 1.0, 0.0, self._turned)
        self._bend, self._block = np.zeros(bt.BEND_SIZE), bt.make_block()
        self.points = np.zeros((blocks, bt.SAMPLES, 3 * bt.BLOCK), np.float32)
        self._patch, self._descent = patch, 0.45 * spec.full_press_mm

    def run(self, times: int) -> None:
        """Bend all hairs so many times."""
        bend_often(
            times, self._bristles, self._tuft, self._descent, 0.5 * math.pi, 0.45, self._patch,
            self._turned, self._bend, self._block, self.points,
        )  # fmt: skip


def measure(share: float = 1.0) -> Result:
    """Milliseconds of CPU per imprint for 1 to 10,000 hairs, on a plane and on a curved patch."""
    rounds = max(2, int(_ROUNDS * share))
    rows, checks = [], []
    for n in _COUNTS:
        times = max(1, int(_HAIRS_A_ROUND * share) // max(n, 200))
        bends = {name: HairBend(n, p) for name, p in (("plane", bt.FLAT), ("curved", _CURVED))}
        for bend in bends.values():
            bend.run(1)
        found = alternate(rounds, {name: partial(bend.run, times) for name, bend in bends.items()})
        plane, curved = (1e3 * found[name].cpu_s / times for name in ("plane", "curved"))
        rows.append([n, plane, curved, curved / plane, 1e6 * plane / n])
        if n in _WANTED_MS:
            checks.append(Check(f"{n:,} hairs on a plane", plane, _WANTED_MS[n], unit="ms"))
            checks.append(Check(f"{n:,} hairs, curved over plane", curved / plane, _MOST_CURVED))
    return Result(
        "An imprint of hairs: deformation, contact and 8 points a hair, on one core",
        ["hairs", "plane, CPU ms", "curved, CPU ms", "curved/plane", "plane, ns/hair"],
        rows,
        checks,
    )
