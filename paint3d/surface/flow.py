"""Wet ink in a surface that drinks: it spreads, lags, stops, and dries (`kernels.diffusion`).

Runs on the patch of surface that is wet and a margin around it; the patch is refined as painting
would refine it, and grows when the water comes near its rim. What is on the vertices belongs to
`PaintedSurface`; here is how deep the water stands, and how the pigment got where it is. Paint that
comes, is taken up by a brush or dries by command between two calls is noticed and followed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.kernels.diffusion import flow_pigment, potentials, solve_edges, solve_water
from paint3d.surface.wet_patch import WetPatch

if TYPE_CHECKING:
    from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Flow"]

_TOLERANCE = 2e-4  # of the pores' depth, in a node's balance
_MOST_SWEEPS = 60
_FIRST_STEP, _LONGEST_STEP = 1.0 / 30.0, 20.0  # s
_PACE = 0.03  # of the pores' depth: the change a step of our own choosing aims at
_REST = 60.0  # s: steps while nothing moves but air
_EDGE_GAIN, _EDGE_REACH = 8.0, 1.0  # evaporation at the border over that inside, less 1; mm
_EDGE_SWEEPS = 2
_DRY = 1e-9  # mm


class Flow:
    """The water on a surface and its way.

    Parameters
    ----------
    surface : PaintedSurface
    """

    def __init__(self, surface: PaintedSurface) -> None:
        self._surface = surface
        self._patch = WetPatch(surface)
        self._pace = _FIRST_STEP
        self.steps = 0

    @property
    def water(self) -> float:
        """Water on the surface and in its pores, mm3."""
        return float(self._patch.water @ self._patch.area)

    @property
    def n_wet(self) -> int:
        """Nodes with water."""
        return int(np.count_nonzero(self._patch.water > 0.0))

    def depths(self) -> tuple[NDArray, NDArray]:
        """Vertices (C,) int32 of the patch and the depth of water on each (C,), mm."""
        patch = self._patch
        return patch.vertices, patch.water[patch.node_of]

    def keep(self) -> dict[str, NDArray]:
        """What `restore` takes: the patch, vertex by vertex, and the pace (1,), s."""
        return {**self._patch.keep(), "pace": np.array([self._pace])}

    def restore(self, kept: Mapping[str, NDArray]) -> None:
        """Go on where another flow, on the same surface with the same ink, was kept."""
        self._patch.restore(kept)
        self._pace = float(kept["pace"][0])

    def advance(self, seconds: float, step: float | None, fresh: NDArray) -> None:
        """Let time pass; `fresh` (N,) int32 are vertices whose ink may have changed since."""
        patch = self._patch
        if patch.take_up(fresh):
            self._pace = _FIRST_STEP
        left = seconds
        while left > 1e-9 * seconds and patch.is_wet():
            length = min(left, self._pace, step if step is not None else left)
            self._step(length)
            self.steps += 1
            left -= length
        patch.hand_back()

    def _step(self, seconds: float) -> None:
        patch = self._patch
        moved = 0.0
        active = patch.mobile()
        while len(active):
            moved = self._move(active, seconds)
            if moved >= 0.0:
                break
            patch.grow()
            active = patch.mobile()
        self._evaporate(seconds)
        if not len(active):
            self._pace = min(_REST, 2.0 * self._pace)
            return
        wanted = _PACE * patch.material.pores_mm / max(moved, 1e-12)
        self._pace = float(np.clip(self._pace * np.clip(wanted, 0.5, 1.5), 0.0, _LONGEST_STEP))
        self._pace = max(self._pace, _FIRST_STEP)

    def _move(self, active: NDArray, seconds: float) -> float:
        """One step of flow; the largest change of depth, mm, or -1 where the patch is too small."""
        p = self._patch
        drink = p.material
        pores, film = drink.pores_mm, drink.spread_mm2_s
        n = len(p.water)
        nodes = np.empty(n, np.int32)
        nodes[: len(active)] = active
        is_active = np.zeros(n, np.uint8)
        is_active[active] = 1
        # start from where the last step's motion leads
        depth = p.water.copy()
        going = active[p.speed[active] != 0.0]
        floor = pores * p.residual[going]
        depth[going] = np.maximum(floor, p.water[going] + seconds * p.speed[going])
        psi = np.zeros(n)
        potentials(active, depth, pores, p.residual, p.strength, film, psi)
        stats = np.zeros(3)
        graph = p.graph
        links = (graph.runs, graph.links, p.weights)
        count = solve_water(
            nodes, len(active), is_active, graph.rim, p.water, p.area, *links, p.totals,
            seconds, pores, p.residual, p.strength, film, p.entry, _TOLERANCE * pores, _MOST_SWEEPS,
            depth, psi, stats,
        )  # fmt: skip
        if stats[2] > 0.0:
            return -1.0
        reached = nodes[:count]
        order = p.order[psi[p.order] > 0.0]  # nearly sorted: the last step's order
        is_active[order] = 3
        order = np.concatenate([order, reached[(is_active[reached] != 3) & (psi[reached] > 0.0)]])
        order = order[np.argsort(-psi[order], kind="stable")]
        p.order = order
        before = p.water[reached]
        flow_pigment(
            order, reached, count, psi, p.entry, p.area, *links, seconds, drink.passing,
            p.water, p.pigment, np.zeros(n), np.zeros_like(p.pigment),
        )  # fmt: skip
        change = p.water[reached] - before
        p.speed[:] = 0.0
        p.speed[reached] = change / seconds
        p.changed[reached] = True
        p.soak(reached)
        return float(np.abs(change).max())

    def _evaporate(self, seconds: float) -> None:
        p = self._patch
        wet = np.flatnonzero(p.water > 0.0).astype(np.int32)
        rate = np.full(len(wet), p.material.drying_mm_s)
        if p.material.pores_mm > 0.0:
            p.inside[p.water <= 0.0] = 0.0
            solve_edges(
                wet, p.area, p.graph.runs, p.graph.links, p.weights, p.totals, _EDGE_REACH,
                _EDGE_SWEEPS, p.inside,
            )  # fmt: skip
            rate *= 1.0 + _EDGE_GAIN * (1.0 - p.inside[wet])
        p.water[wet] -= seconds * rate
        dried = wet[p.water[wet] <= _DRY]
        if len(dried):
            p.water[dried] = 0.0
            p.dry(dried)
