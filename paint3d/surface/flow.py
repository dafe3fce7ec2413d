"""Time integration of wet ink on an absorbent surface: it spreads, lags, stops, and dries.

The equations are in `surface.kernels.diffusion`. The simulation runs on a patch: the wet part of
the surface and a margin around it. The patch is refined as painting would refine it, and grows when
water comes near its rim. The ink on the vertices belongs to `PaintedSurface`; the patch holds the
depth of the water and the pigment in it, and is synchronised with paint that is added, picked up by
a brush or dried on command between two calls.

Every block of the patch has a time step of its own: short while ink runs there, seconds long where
it has nearly come to rest. So the cost grows with what moves, not with what is wet. Groups of
blocks that share no neighbour are moved on all cores.
"""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.materials import WET_COAT_MM
from paint3d.core.arrays import AnyArray
from paint3d.surface.ink_store import InkStore, union
from paint3d.surface.kernels.diffusion import Drying, ease_entries, evaporate, solve_edges
from paint3d.surface.kernels.wet_graph import grade_paces
from paint3d.surface.kernels.wet_step import WORKSPACE_TOO_SMALL, Absorption, Workspace, move_water
from paint3d.surface.pores import capacity_of, entry_ratio_of, film_of
from paint3d.surface.wet_patch import FIRST_PACE, WetPatch

__all__ = ["Flow", "Water", "WorkMemory", "work_memory"]

_BUNDLE = 4000  # nodes, at least, that one thread moves as a unit of work

_LONGEST_STEP = 20.0  # s
_SHORTEST = 0.05  # s: a step is not split below this, however much moves
_MOST, _MEAN = 0.3, 0.01  # target greatest and mean change per step, of the pores' depth
_EASE = 2.5  # factor on these targets while somebody is painting (`Flow.follow`)
_CARE = 0.15  # the same in `Flow.advance`: the result is within 1 % whatever the steps
_GROWTH = 1.5  # factor by which a block's step may grow at once
_UNLIKE = 1.15  # greatest ratio of the steps of neighbouring blocks
_FRESH_S = 2.0  # s: of time t the steps are done by log(1 + t / this), about, as ink comes to rest
_REST = 60.0  # s: longest step while nothing moves and water only evaporates
_PIECE = 0.05  # s: longest time that `Flow.follow` lets pass at once
_LATE = 0.12  # s: tolerated delay; steps this long in fresh ink put radii off by 2 %
_OPENED = 6  # most blocks opened in one call of `Flow.follow`, some 3 ms each
_NEARLY = 0.7  # fraction of its step after which a block is due
_BESIDE = 0.35  # the same beside a block that is due
_EDGE_GAIN, _EDGE_REACH = 8.0, 1.0  # evaporation at the border over that inside, minus 1; mm
_EDGE_SWEEPS = 2
_DRY = 1e-9  # mm: less water counts as none
_MOST_THREADS = 4
# Floats of work memory per thread; at most 128 MiB stays.
_WORKSPACE, _MOST_WORKSPACE = 1 << 18, 1 << 24
_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


class WorkMemory(threading.local):
    """Scratch memory of a thread, reused: the system would clear new memory at each step.

    Attributes
    ----------
    workspace : Workspace
        Scratch arrays passed to each step.
    """

    def __init__(self) -> None:
        self._make(_WORKSPACE)

    def _make(self, size: int) -> None:
        self.workspace = Workspace(np.empty(size), np.empty(size // 2, np.int32))

    def grow(self) -> None:
        """Double the scratch arrays."""
        self._make(2 * len(self.workspace.floats))

    def give_back(self) -> None:
        """Shrink to the initial size if a large step made the arrays exceptionally large."""
        if len(self.workspace.floats) > _MOST_WORKSPACE:
            self._make(_WORKSPACE)


work_memory = WorkMemory()


@dataclass(eq=False)
class _Step:
    """Per-block results (B blocks) of one step.

    Attributes
    ----------
    due, mobile, still_wet : (B,) bool
        Whether the block takes part, has water that can move, and has water left.
    moved : (B, 3) float64
        Greatest change of depth, mm; the changed volume; the area that it is spread over.
    rings : int
        How often more of the surface had to be opened.
    """

    due: NDArray[np.bool_]
    moved: NDArray[np.float64]
    mobile: NDArray[np.bool_]
    still_wet: NDArray[np.bool_]
    rings: int = 0


class Flow:
    """The water on a surface, moved step by step.

    Parameters
    ----------
    store : InkStore

    Attributes
    ----------
    steps : int
        Number of steps taken so far.
    waiting : (N,) int32
        Vertices whose ink `follow` has not taken up yet: they are fresh at the next call, too.
    """

    def __init__(self, store: InkStore) -> None:
        self._store = store
        self._patch = WetPatch(store)
        made_of = store.material
        self._absorption = Absorption(
            capacity_of(made_of), film_of(made_of), made_of.passing, made_of.pores_mm,
            entry_ratio_of(made_of),
        )  # fmt: skip
        self.steps = 0
        self._ease = 1.0
        self.waiting = np.zeros(0, np.int32)
        self._waited = 0.0  # s since all fresh ink was last taken up

    @property
    def water(self) -> float:
        """Water on the surface and in its pores, mm3."""
        n = self._patch.graph.n_nodes
        return math.fsum(self._patch.water[:n] * self._patch.graph.area[:n])

    @property
    def n_wet(self) -> int:
        """Number of nodes with water."""
        return int(np.count_nonzero(self._patch.water > 0.0))

    @property
    def is_dry(self) -> bool:
        """Whether no water is left, nor ink that `follow` has not taken up."""
        return not (self._patch.is_wet() or len(self.waiting))

    @property
    def is_wet(self) -> bool:
        """Whether any water is left on the patch; ink still waiting does not count."""
        return self._patch.is_wet()

    @property
    def patience(self) -> float:
        """Time until the next block is due for a step, s; infinite where nothing is wet."""
        patch = self._patch
        wet = patch.wet_blocks()
        return max(0.0, float((patch.pace[wet] - patch.owed[wet]).min(initial=np.inf)))

    def depths(self) -> tuple[AnyArray, AnyArray]:
        """Return the vertices (C,) int32 of the patch and the depth of water on each (C,), mm."""
        graph = self._patch.graph
        node = graph.node_of[: graph.n_places]
        return graph.vertices[: graph.n_places], self._patch.water[node]

    def keep(self) -> dict[str, AnyArray]:
        """Return the state of the patch, vertex by vertex, for `restore`."""
        return self._patch.keep()

    def clear(self) -> None:
        """Remove all water."""
        self._patch.clear()
        self.waiting = self.waiting[:0]

    def restore(self, kept: Mapping[str, AnyArray]) -> None:
        """Continue from the state `kept` by a flow on the same surface with the same ink."""
        self.waiting = self.waiting[:0]
        self._patch.restore(kept)

    # -- time -------------------------------------------------------------------------------

    def advance(
        self,
        seconds: float,
        step: float | None,
        fresh: AnyArray,
        progress: Callable[[float], None] | None = None,
    ) -> None:
        """Advance time in full; the ink of vertices `fresh` (N,) int32 may have changed since."""
        patch = self._patch
        self._ease = _CARE
        self._take_up(fresh)
        left = seconds
        longest = np.inf if step is None else step
        while left > 1e-9 * seconds and patch.is_wet():
            wet = patch.wet_blocks()
            pace = np.minimum(patch.pace[wet], longest)
            gone = min(left, longest, max(float((pace - patch.owed[wet]).min()), FIRST_PACE))
            left -= gone
            patch.owed += gone
            if left > 1e-9 * seconds:
                self._step(self._due(wet, pace))
            if progress is not None and left > 0.0:
                progress(math.log1p((seconds - left) / _FRESH_S) / math.log1p(seconds / _FRESH_S))
        # Bring every block up to the present, due or not.
        while len(wet := patch.wet_blocks()) and patch.owed[wet].any():
            self._step(wet[patch.owed[wet] > 0.0])
        patch.write_surface()
        if progress is not None:
            progress(1.0)

    def follow(self, seconds: float, fresh: AnyArray, most_nodes: int) -> bool:
        """Advance time interactively: a bounded amount of work, the most urgent blocks first.

        Water that moves little waits until its step is due. Of the blocks due, no more than
        `most_nodes` nodes are moved for every 1/20 s, the longest overdue first, and only a few
        blocks are opened. The rest is due at the next call, which may be for 0 s. The work done in
        a call depends on simulated time alone, never on a clock.

        Returns
        -------
        bool
            Whether nothing lags visibly: no block is more than 0.12 s and three of its steps
            behind, and no ink has waited 0.12 s to be taken up.
        """
        patch = self._patch
        self._ease = _EASE
        now, self.waiting = patch.open_some(fresh, _OPENED)
        self._waited = self._waited + seconds if len(self.waiting) else 0.0
        under_tuft = self._take_up(now)
        if not patch.open_wet(_OPENED):
            patch.owed += seconds
            patch.write_surface()
            return False
        pieces = max(1, math.ceil(seconds / _PIECE))
        with patch.held(under_tuft):
            for _ in range(pieces):
                patch.owed += seconds / pieces
                wet = patch.wet_blocks()
                self._step(self._most_urgent(self._due(wet, patch.pace[wet]), most_nodes))
        patch.write_surface()
        wet = patch.wet_blocks()
        is_late = patch.owed[wet] >= np.maximum(_LATE, 3.0 * patch.pace[wet])
        return not is_late.any() and self._waited < _LATE

    def _due(self, wet: AnyArray, pace: AnyArray) -> AnyArray:
        """Return those of the wet blocks (K,), with steps `pace` (K,), that take a step now."""
        patch, graph = self._patch, self._patch.graph
        elapsed = np.zeros(graph.n_blocks)  # as a fraction of the block's step
        elapsed[wet] = patch.owed[wet] / pace
        is_due = elapsed >= _NEARLY
        for block in np.flatnonzero(is_due):
            beside = graph.beside[graph.first_beside[block] : graph.last_beside[block]]
            is_due[beside] |= elapsed[beside] >= _BESIDE
        return np.flatnonzero(is_due)

    def _most_urgent(self, due: AnyArray, most_nodes: int) -> AnyArray:
        """Return the most overdue of blocks (K,) within `most_nodes`, ascending; at least one."""
        patch = self._patch
        late = np.argsort(-patch.owed[due] / patch.pace[due], kind="stable")
        sizes = np.cumsum(patch.graph.block_nodes[due[late]])
        n = int(np.searchsorted(sizes, most_nodes, side="right"))
        return np.sort(due[late[: max(1, n)]])

    def _take_up(self, fresh: AnyArray) -> AnyArray:
        """Synchronise with ink that changed, after bringing the water there up to the present.

        Returns the nodes (K,) on which a tuft lies.
        """
        patch = self._patch
        at = patch.find_changed(fresh)
        if not len(at):
            return at
        blocks = np.unique(patch.graph.block[patch.graph.node_of[at]])
        owed = patch.owed[blocks]
        self._step(blocks[np.isfinite(owed) & (owed > 0.0)])
        return patch.read_surface(at)

    # -- steps ------------------------------------------------------------------------------

    def _step(self, blocks: AnyArray) -> None:
        """Move and dry the water of blocks (K,), ascending, for the time that they are behind."""
        if not len(blocks):
            return
        patch = self._patch
        blocks = blocks.astype(np.int64)
        self.steps += 1
        step = _Step(
            due=np.zeros(patch.graph.n_blocks, bool),
            moved=np.zeros((patch.graph.n_blocks, 3)),
            mobile=np.zeros(patch.graph.n_blocks, bool),
            still_wet=np.zeros(patch.graph.n_blocks, bool),
        )
        step.due[blocks] = True
        was_dry = np.isinf(patch.owed)
        patch.open(blocks)
        patch.open(patch.graph.open_before(blocks))
        # Water in and around these blocks flows into notches of the wet border.
        nodes = np.concatenate([patch.graph.nodes_of(blocks), patch.graph.rims_of(blocks)])
        ease_entries(nodes, patch.fields(step.due, step.mobile, step.moved), patch.dry_entry)
        bundles = self._bundles(blocks)
        work = [(bundle, np.zeros(1)) for bundle in bundles]
        done = each(lambda own: self._move_and_dry(*own, step), work)
        dried = []
        for own, gone in zip(work, done, strict=True):
            while gone is None:  # more of the surface has to be opened first
                patch.open(self._blocks_to_open(own[0], step))
                gone = self._move_and_dry(*own, step)
            dried.append(gone)
        dry = np.concatenate(dried)
        if len(dry):
            patch.dry(dry)
        for bundle, rest in work:
            length = float(patch.owed[bundle].max()) - rest
            patch.pace[bundle] = np.minimum(patch.pace[bundle], length)
            left = np.minimum(patch.owed[bundle], rest)
            patch.owed[bundle] = np.where(step.still_wet[bundle], left, np.inf)
        self._choose_pace(step, np.flatnonzero(was_dry & np.isfinite(patch.owed)))

    def _bundles(self, blocks: AnyArray) -> list[AnyArray]:
        """Group blocks (K,) into independent bundles of at least `_BUNDLE` nodes where possible."""
        graph = self._patch.graph
        bundles: list[list[AnyArray]] = []
        size = _BUNDLE
        for group in graph.apart(blocks):
            if size >= _BUNDLE:
                bundles.append([])
                size = 0
            bundles[-1].append(group)
            size += int(graph.block_nodes[group].sum())
        return [np.sort(np.concatenate(bundle)) for bundle in bundles]

    def _choose_pace(self, step: _Step, came: AnyArray) -> None:
        """Adapt the time steps to the motion in this one; `came` (K,) are newly wet blocks."""
        p, due, graph = self._patch, step.due, self._patch.graph
        pores = max(p.material.pores_mm, WET_COAT_MM)
        pace = p.pace[due]
        most, volume, area = step.moved[due].T
        change = np.maximum(most / _MOST, volume / np.maximum(area, 1e-12) / _MEAN)
        longer = pace * np.clip(self._ease * pores / np.maximum(change, 1e-12), 0.5, _GROWTH)
        longer = np.clip(longer, FIRST_PACE, _LONGEST_STEP)
        p.pace[due] = np.where(step.mobile[due], longer, np.minimum(_REST, 2.0 * pace))
        p.pace[came] = p.pace[due].min(initial=_LONGEST_STEP)
        p.pace[np.isinf(p.owed)] = np.inf
        grade_paces(
            p.wet_blocks(), graph.first_beside, graph.last_beside, graph.beside, _UNLIKE, p.pace
        )
        p.pace[np.isinf(p.owed)] = FIRST_PACE

    def _move_and_dry(self, blocks: AnyArray, rest: AnyArray, step: _Step) -> AnyArray | None:
        """Move and dry the water of one bundle of blocks (K,); touches no other bundle's state.

        Returns the nodes that have dried, or None if more of the surface has to be opened first:
        then nothing was done.
        """
        p = self._patch
        nodes = p.graph.nodes_of(blocks)
        fields, rims = p.fields(step.due, step.mobile, step.moved), p.graph.rims_of(blocks)
        while True:
            stages = move_water(
                fields, nodes, rims, self._absorption, _SHORTEST, rest, work_memory.workspace
            )
            if stages != WORKSPACE_TOO_SMALL:
                break
            work_memory.grow()
        work_memory.give_back()
        if stages < 0:
            return None
        # Evaporation, faster at the border of the wet area.
        is_wet = p.water[nodes] > 0.0
        wet = nodes[is_wet]
        p.inside[nodes[~is_wet]] = 0.0
        solve_edges(wet, fields, p.totals, _EDGE_REACH, _EDGE_SWEEPS, p.inside)
        dried = np.empty(len(wet), np.int32)
        rate = float(p.material.drying_mm_s)
        drying = Drying(rate, _EDGE_GAIN, _DRY, capacity_of(p.material))
        count = evaporate(wet, fields, float(rest[0]), drying, p.inside, dried, step.still_wet)
        return dried[:count]

    def _blocks_to_open(self, blocks: AnyArray, step: _Step) -> AnyArray:
        """Return the blocks to open before the water on blocks (K,) can move."""
        graph, water = self._patch.graph, self._patch.water
        ring = graph.rims_of(blocks)
        ring = ring[~step.due[graph.block[ring]]]
        missing = (graph.closed[ring] == 2) | ((graph.closed[ring] == 1) & (water[ring] > 0.0))
        step.rings += 1
        wanted = np.unique(graph.block[ring[missing]])
        for _ in range(step.rings // 2):  # look further ahead each time water outruns the patch
            wanted = graph.blocks_around(wanted)
        return wanted


def each(work: Callable[[_Item], _Result], items: Sequence[_Item]) -> list[_Result]:
    """Map `work` over items on threads, results in order; kernels release the GIL."""
    if len(items) < 2:
        return [work(item) for item in items]
    return list(_threads(os.getpid()).map(work, items))


@lru_cache(maxsize=1)
def _threads(process: int) -> ThreadPoolExecutor:
    """Return the thread pool of a process; a forked child cannot use its parent's."""
    count = min(_MOST_THREADS, os.cpu_count() or 1)
    return ThreadPoolExecutor(count, thread_name_prefix="paint3d-flow")


class Water:
    """The active layer's water, created on first use, with the ink that it has yet to take up.

    Parameters
    ----------
    store : InkStore

    Attributes
    ----------
    fresh : list of (N,) int32, or None
        Vertices whose ink may have changed since the flow last took it up; None without a flow.
    """

    def __init__(self, store: InkStore) -> None:
        self._store = store
        self._flow: Flow | None = None
        self._still: Flow | None = None  # one that was dropped, kept because its graph is reusable
        self.fresh: list[AnyArray] | None = None

    @property
    def flow(self) -> Flow:
        """The simulation of the water, created on first access."""
        if self._flow is None:
            self._flow, self._still = self._still or Flow(self._store), None
            self._flow.clear()
            self.fresh = [np.flatnonzero(self._store.coverage > 0.0).astype(np.int32)]
        return self._flow

    @property
    def patience(self) -> float:
        """Time until there is anything to do, s; infinite if all is dry."""
        n_dirty = self._store.ink.n_dirty[0]
        if self._flow is None:
            return 0.0 if n_dirty or self._store.coverage.any() else np.inf
        is_fresh = n_dirty > 0 or any(len(ids) for ids in self.fresh or ())
        return 0.0 if is_fresh else self._flow.patience

    def depths(self) -> tuple[AnyArray, AnyArray] | None:
        """Return vertices (C,) int32 and the depth of water on each, mm; None without water."""
        if self._flow is None or not self._flow.is_wet:
            return None
        return self._flow.depths()

    def advance(
        self, seconds: float, step: float | None, progress: Callable[[float], None] | None
    ) -> None:
        """See `Flow.advance`."""
        self.flow.advance(seconds, step, self._take_fresh(), progress)

    def follow(self, seconds: float, most_nodes: int) -> bool:
        """See `Flow.follow`."""
        keeps_up = self.flow.follow(seconds, self._take_fresh(), most_nodes)
        self.fresh = [*(self.fresh or ()), self.flow.waiting]
        return keeps_up

    def keep(self) -> dict[str, AnyArray] | None:
        """Return the state for `restore`, or None where no water has ever moved.

        Adds to what `Flow.keep` returns fresh (N,) int32: vertices whose ink came since.
        """
        if self._flow is None:
            return None
        fresh = [*(self.fresh or ()), self._dirty()]
        return {**self._flow.keep(), "fresh": union(fresh, self._store.paint_mesh.capacity)}

    def restore(self, kept: Mapping[str, AnyArray]) -> None:
        """Continue from a state returned by `keep`."""
        kept, count = dict(kept), len(self._store.pigments)
        for name in ("pigment", "fine", "loose", "written"):  # pigments may have come since
            missing = count - kept[name].shape[1]
            kept[name] = np.pad(kept[name], ((0, 0), (0, missing)))
        self.flow.restore(kept)
        self.fresh = [kept["fresh"]]

    def drop(self) -> None:
        """Discard all water."""
        self._still = self._flow or self._still
        self._flow, self.fresh = None, None

    def _take_fresh(self) -> AnyArray:
        """Return and clear the vertices (N,) int32 whose ink may have changed."""
        fresh = [*(self.fresh or ()), self._dirty()]
        self.fresh = []
        return np.concatenate(fresh)

    def _dirty(self) -> AnyArray:
        ink = self._store.ink
        return ink.dirty_ids[: int(ink.n_dirty[0])]
