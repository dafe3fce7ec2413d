"""Wet ink in a surface that drinks: it spreads, lags, stops, and dries (`kernels.diffusion`).

Runs on the patch of surface that is wet and a margin around it; the patch is refined as painting
would refine it, and grows when the water comes near its rim. What is on the vertices belongs to
`PaintedSurface`; here is how deep the water stands, and how the pigment got where it is. Paint that
comes, is taken up by a brush or dries by command between two calls is noticed and followed.

Every block of the patch has a step of its own: short while ink runs there, seconds long where it
has nearly come to rest. So what a painting costs goes with what moves, not with what is wet.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.kernels.diffusion import (
    evaporate,
    flow_pigment,
    note_motion,
    potentials,
    solve_edges,
    solve_water,
    weigh_links,
)
from paint3d.surface.side_by_side import each
from paint3d.surface.wet_patch import FIRST_PACE, WetPatch

if TYPE_CHECKING:
    from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Flow"]

_BUNDLE = 4000  # nodes that are moved by one thread, or more

_TOLERANCE = 5e-4  # of the pores' depth, in a node's balance
_MOST_SWEEPS = 60
_LONGEST_STEP = 20.0  # s
_PACE = 0.05  # of the pores' depth: the change a step of our own choosing aims at
_REST = 60.0  # s: steps while nothing moves but air
_PIECE = 0.05  # s: time that passes at once beside a hand
_LATE = 0.12  # s: steps as long can be taken where ink has just come; radii are 2 % off then
_NEARLY = 0.7  # of its step: then a block may take it along with others
_EDGE_GAIN, _EDGE_REACH = 8.0, 1.0  # evaporation at the border over that inside, less 1; mm
_EDGE_SWEEPS = 2
_DRY = 1e-9  # mm


@dataclass(eq=False)
class _Step:
    """What is found of each block (B,) in a step.

    Attributes
    ----------
    due, mobile, still_wet : (B,) bool
        Whether it takes part, has water that can move, and has water left.
    moved : (B,) float64
        The greatest change of depth, mm.
    rings : int
        How often more of the surface had to be known.
    """

    due: NDArray
    moved: NDArray
    mobile: NDArray
    still_wet: NDArray
    rings: int = 0


class Flow:
    """The water on a surface and its way.

    Parameters
    ----------
    surface : PaintedSurface
    """

    def __init__(self, surface: PaintedSurface) -> None:
        self._surface = surface
        self._patch = WetPatch(surface)
        self.steps = 0

    @property
    def water(self) -> float:
        """Water on the surface and in its pores, mm3."""
        n = self._patch.graph.n_nodes
        return float(self._patch.water[:n] @ self._patch.graph.area[:n])

    @property
    def n_wet(self) -> int:
        """Nodes with water."""
        return int(np.count_nonzero(self._patch.water > 0.0))

    @property
    def patience(self) -> float:
        """Time that may pass before anything has to move, s; infinite where nothing is wet."""
        patch = self._patch
        wet = patch.wet_blocks()
        return max(0.0, float((patch.pace[wet] - patch.owed[wet]).min(initial=np.inf)))

    def depths(self) -> tuple[NDArray, NDArray]:
        """Vertices (C,) int32 of the patch and the depth of water on each (C,), mm."""
        graph = self._patch.graph
        node = graph.node_of[: graph.n_places]
        return graph.vertices[: graph.n_places], self._patch.water[node]

    def keep(self) -> dict[str, NDArray]:
        """What `restore` takes: what is on the patch, vertex by vertex."""
        return self._patch.keep()

    def restore(self, kept: Mapping[str, NDArray]) -> None:
        """Go on where another flow, on the same surface with the same ink, was kept."""
        self._patch.restore(kept)

    # -- time -------------------------------------------------------------------------------

    def advance(self, seconds: float, step: float | None, fresh: NDArray) -> None:
        """Let time pass; `fresh` (N,) int32 are vertices whose ink may have changed since."""
        patch = self._patch
        self._take_up(fresh)
        left = seconds
        longest = np.inf if step is None else step
        while left > 1e-9 * seconds and patch.is_wet():
            wet = patch.wet_blocks()
            pace = np.minimum(patch.pace[wet], longest)
            gone = min(left, longest, max(float((pace - patch.owed[wet]).min()), FIRST_PACE))
            left -= gone
            patch.owed += gone
            if left <= 1e-9 * seconds:
                self._step(wet)  # all are brought to now
            else:
                self._step(wet[patch.owed[wet] >= _NEARLY * pace])
        patch.hand_back()

    def follow(self, seconds: float, fresh: NDArray, most_nodes: int) -> bool:
        """Let time pass, and let what is due move, as far as there is time for it.

        Water that moves little is left where it is until its step is due, and of what is due no
        more is done than `most_nodes` for every 1/20 s, what waits longest first; the rest is due
        at the next call, which may be for no time at all. How far anything is behind, and what is
        done in one call, does not depend on a clock.

        Returns
        -------
        bool
            Whether no water waits so long for its step that this could be seen: more than 0.12 s,
            and three times what suits it.
        """
        patch = self._patch
        self._take_up(fresh)
        pieces = max(1, math.ceil(seconds / _PIECE))
        for _ in range(pieces):
            patch.owed += seconds / pieces
            wet = patch.wet_blocks()
            due = wet[patch.owed[wet] >= _NEARLY * patch.pace[wet]]
            chosen = self._most_urgent(due, most_nodes)
            self._step(chosen)
        patch.hand_back()
        wet = patch.wet_blocks()
        return not (patch.owed[wet] >= np.maximum(_LATE, 3.0 * patch.pace[wet])).any()

    def _most_urgent(self, due: NDArray, most_nodes: int) -> NDArray:
        """Those of the blocks (K,) that wait longest for their pace, rising; one at least."""
        patch = self._patch
        late = np.argsort(-patch.owed[due] / patch.pace[due], kind="stable")
        sizes = np.cumsum(patch.graph.block_nodes[due[late]])
        n = int(np.searchsorted(sizes, most_nodes, side="right"))
        return np.sort(due[late[: max(1, n)]])

    def _take_up(self, fresh: NDArray) -> None:
        """Follow what happened to the ink, after the water there was brought to now."""
        patch = self._patch
        at = patch.find_changed(fresh)
        if not len(at):
            return
        blocks = np.unique(patch.graph.block[patch.graph.node_of[at]])
        owed = patch.owed[blocks]
        self._step(blocks[np.isfinite(owed) & (owed > 0.0)])
        patch.take_up(at)

    # -- steps ------------------------------------------------------------------------------

    def _step(self, blocks: NDArray) -> None:
        """Let the water of some blocks (K,), rising, move and dry for the time they are owed."""
        if not len(blocks):
            return
        patch = self._patch
        self.steps += 1
        step = _Step(
            due=np.zeros(patch.graph.n_blocks, bool),
            moved=np.zeros(patch.graph.n_blocks),
            mobile=np.zeros(patch.graph.n_blocks, bool),
            still_wet=np.zeros(patch.graph.n_blocks, bool),
        )
        step.due[blocks] = True
        bundles = [blocks]
        if patch.material.pores_mm > 0.0:
            patch.open(blocks)
            bundles = self._bundles(blocks)
        nodes = [patch.graph.nodes_of(bundle) for bundle in bundles]
        done = each(lambda own: self._move_and_dry(own, step), nodes)
        dried = []
        for own, gone in zip(nodes, done, strict=True):
            while gone is None:  # more of the surface has to be known first
                patch.open(self._wanted(own, step))
                gone = self._move_and_dry(own, step)
            dried.append(gone)
        dry = np.concatenate(dried)
        if len(dry):
            patch.dry(dry)
        patch.owed[step.due] = np.where(step.still_wet[step.due], 0.0, np.inf)
        self._choose_pace(step)

    def _bundles(self, blocks: NDArray) -> list[NDArray]:
        """Blocks (K,) in bundles that have nothing to do with one another, none very small."""
        graph = self._patch.graph
        bundles: list[list[NDArray]] = []
        size = _BUNDLE
        for group in graph.apart(blocks):
            if size >= _BUNDLE:
                bundles.append([])
                size = 0
            bundles[-1].append(group)
            size += int(graph.block_nodes[group].sum())
        return [np.sort(np.concatenate(bundle)) for bundle in bundles]

    def _choose_pace(self, step: _Step) -> None:
        p, due = self._patch, step.due
        aim = _PACE * p.material.pores_mm
        pace = p.pace[due]
        longer = pace * np.clip(aim / np.maximum(step.moved[due], 1e-12), 0.5, 1.5)
        longer = np.clip(longer, FIRST_PACE, _LONGEST_STEP)
        p.pace[due] = np.where(step.mobile[due], longer, np.minimum(_REST, 2.0 * pace))
        p.pace[np.isinf(p.owed)] = FIRST_PACE
        woken = (step.moved > 0.5 * aim) & ~due  # a neighbour let in more than a step's worth
        p.pace[woken] = FIRST_PACE

    def _move_and_dry(self, nodes: NDArray, step: _Step) -> NDArray | None:
        """A step of some nodes (N,), which touches nothing that other bundles know of.

        Returns those that are dry now, or None where more of the surface has to be known: then
        nothing was done.
        """
        if self._patch.material.pores_mm > 0.0 and not self._move(nodes, step):
            return None
        return self._evaporate(nodes, step)

    def _weigh(self, nodes: NDArray, step: _Step) -> NDArray:
        """Find for how long water runs on each link of some nodes (N,); the nodes around (R,)."""
        p = self._patch
        graph = p.graph
        ring = np.empty(graph.n_nodes, np.int32)
        n_ring = weigh_links(
            nodes, graph.first, graph.last, graph.links, p.weights, graph.block, p.owed, step.due,
            p.marks, p.exchange, p.exchanged, ring,
        )  # fmt: skip
        return ring[:n_ring]

    def _move(self, nodes: NDArray, step: _Step) -> bool:
        """Let water flow; whether all that it reaches is known."""
        p = self._patch
        graph = p.graph
        ring = self._weigh(nodes, step)
        if ((graph.closed[ring] != 0) & (p.water[ring] > 0.0)).any():
            return False
        around = np.concatenate([nodes, ring])
        active = around[p.water[around] > p.material.pores_mm * p.residual[around]]
        step.mobile[graph.block[active]] = True
        if not len(active):
            return True
        count, reached, is_solved = self._solve(active)
        if is_solved:
            self._carry(reached, count, nodes, step)
        else:
            p.psi[reached[:count]] = 0.0
            p.marks[reached[:count]] = 0
        return is_solved

    def _wanted(self, nodes: NDArray, step: _Step) -> NDArray:
        """Blocks to be opened before the water on some nodes (N,) can move."""
        graph, water = self._patch.graph, self._patch.water
        ring = self._weigh(nodes, step)
        asked = ring[(graph.closed[ring] == 2) | ((graph.closed[ring] == 1) & (water[ring] > 0.0))]
        step.rings += 1
        wanted = np.unique(graph.block[asked])
        for _ in range(step.rings // 2):  # the farther the water goes at once, the farther we look
            wanted = graph.blocks_around(wanted)
        return wanted

    def _solve(self, active: NDArray) -> tuple[int, NDArray, bool]:
        """Find the depths: how many nodes were reached, which, and whether all were known."""
        p = self._patch
        graph, drink = p.graph, p.material
        pores, film = drink.pores_mm, drink.spread_mm2_s
        reached = np.empty(graph.n_nodes, np.int32)
        reached[: len(active)] = active
        p.marks[active] = 1
        # start from where the last step's motion leads
        depth = np.empty(graph.n_nodes)
        gone = p.owed[graph.block[active]]
        gone[np.isinf(gone)] = 0.0
        depth[active] = np.maximum(
            pores * p.residual[active], p.water[active] + gone * p.speed[active]
        )
        potentials(active, depth, pores, p.residual, p.strength, film, p.psi)
        stats = np.zeros(3)
        count = solve_water(
            reached, len(active), p.marks, graph.closed, p.water, graph.area, graph.first,
            graph.last, graph.links, p.exchange, p.exchanged, pores, p.residual, p.strength, film,
            p.entry, _TOLERANCE * pores, _MOST_SWEEPS, depth, p.psi, stats,
        )  # fmt: skip
        return count, reached, stats[2] == 0.0

    def _carry(self, reached: NDArray, count: int, nodes: NDArray, step: _Step) -> None:
        """Move water and pigment as the potentials say, and note what that did."""
        p = self._patch
        graph = p.graph
        here = reached[:count]
        order = here[p.psi[here] > 0.0]
        order = order[np.argsort(-p.psi[order], kind="stable")]
        before = p.water[here]
        flow_pigment(
            order, reached, count, p.psi, p.entry, graph.area, graph.first, graph.last,
            graph.links, p.exchange, p.material.passing, p.water, p.pigment, p.gained, p.brought,
        )  # fmt: skip
        p.speed[nodes] = 0.0
        note_motion(
            reached, count, before, p.water, graph.block, p.owed, step.due, p.held, p.speed,
            p.changed, p.soaked, p.entry, step.moved,
        )  # fmt: skip
        p.psi[here] = 0.0
        p.marks[here] = 0
        blocks = np.unique(graph.block[here])
        p.owed[blocks[np.isinf(p.owed[blocks]) & (step.moved[blocks] > 0.0)]] = 0.0

    def _evaporate(self, nodes: NDArray, step: _Step) -> NDArray:
        """Let the water of some nodes (N,) dry; return those that are dry now."""
        p = self._patch
        graph = p.graph
        is_wet = p.water[nodes] > 0.0
        wet = nodes[is_wet]
        gain = 0.0
        if p.material.pores_mm > 0.0:
            gain = _EDGE_GAIN
            p.inside[nodes[~is_wet]] = 0.0
            solve_edges(
                wet, graph.area, graph.first, graph.last, graph.links, p.weights, p.totals,
                _EDGE_REACH, _EDGE_SWEEPS, p.inside,
            )  # fmt: skip
        dried = np.empty(len(wet), np.int32)
        count = evaporate(
            wet, graph.block, p.owed, p.material.drying_mm_s, gain, p.inside, _DRY, p.water,
            dried, step.still_wet,
        )  # fmt: skip
        return dried[:count]
