"""Wet ink in a surface that drinks: it spreads, lags, stops, and dries.

The equations are in `surface.kernels.diffusion`.
Runs on the patch of surface that is wet and a margin around it; the patch is refined as painting
would refine it, and grows when the water comes near its rim. What is on the vertices belongs to
`PaintedSurface`; here is how deep the water stands, and how the pigment got where it is. Paint that
comes, is taken up by a brush or dries by command between two calls is noticed and followed.

Every block of the patch has a step of its own: short while ink runs there, seconds long where it
has nearly come to rest. So what a painting costs goes with what moves, not with what is wet. Blocks
that have nothing to do with one another are moved on all cores.
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
from paint3d.surface.kernels.wet_step import TOO_LITTLE_ROOM, Drink, Room, move_water
from paint3d.surface.pores import capacity_of, film_of
from paint3d.surface.wet_patch import FIRST_PACE, WetPatch

__all__ = ["Flow", "Water", "WorkMemory", "work_memory"]

_BUNDLE = 4000  # nodes that are moved by one thread, or more

_LONGEST_STEP = 20.0  # s
_SHORTEST = 0.05  # s: no step in which much moves is cut to less
_MOST, _MEAN = 0.3, 0.01  # of the pores' depth: the changes a step of our own choosing aims at
_EASE = 2.5  # times as much beside a hand
_CARE = 0.15  # of it where time is asked for: then the outcome is within 1 %, whatever the steps
_GROWTH = 1.5
_UNLIKE = 1.15  # times as long as a neighbour's may a block's steps be
_REST = 60.0  # s: steps while nothing moves but air
_PIECE = 0.05  # s: time that passes at once beside a hand
_LATE = 0.12  # s: steps as long can be taken where ink has just come; radii are 2 % off then
_OPENED = 6  # blocks whose ways are learnt in one call beside a hand: some 3 ms each
_NEARLY = 0.7  # of its step: then a block may take it along with others
_BESIDE = 0.35  # of it: the same where a neighbour takes one
_EDGE_GAIN, _EDGE_REACH = 8.0, 1.0  # evaporation at the border over that inside, less 1; mm
_EDGE_SWEEPS = 2
_DRY = 1e-9  # mm
_MOST_THREADS = 4
_ROOM, _MOST_ROOM = 1 << 18, 1 << 24  # numbers to work with that a thread keeps; 128 MiB
_Given = TypeVar("_Given")
_Found = TypeVar("_Found")


class WorkMemory(threading.local):
    """Memory for the work of a thread: what is asked for anew the system clears at each step.

    Attributes
    ----------
    room : Room
        What a step is handed to work in.
    """

    def __init__(self) -> None:
        self._make(_ROOM)

    def _make(self, size: int) -> None:
        self.room = Room(np.empty(size), np.empty(size // 2, np.int32))

    def grow(self) -> None:
        """Make it twice as large."""
        self._make(2 * len(self.room.floats))

    def give_back(self) -> None:
        """Keep no more than a sheet's worth."""
        if len(self.room.floats) > _MOST_ROOM:
            self._make(_ROOM)


work_memory = WorkMemory()


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

    due: NDArray[np.bool_]
    moved: NDArray[np.float64]
    mobile: NDArray[np.bool_]
    still_wet: NDArray[np.bool_]
    rings: int = 0


class Flow:
    """The water on a surface and its way.

    Parameters
    ----------
    store : InkStore

    Attributes
    ----------
    steps : int
        Taken so far.
    waiting : (N,) int32
        Vertices whose ink `follow` has not taken up yet: they are fresh at the next call, too.
    """

    def __init__(self, store: InkStore) -> None:
        self._store = store
        self._patch = WetPatch(store)
        made_of = store.material
        self._drink = Drink(capacity_of(made_of), film_of(made_of), made_of.passing)
        self.steps = 0
        self._ease = 1.0
        self.waiting = np.zeros(0, np.int32)
        self._waited = 0.0  # s, since all fresh ink was taken up

    @property
    def water(self) -> float:
        """Water on the surface and in its pores, mm3."""
        n = self._patch.graph.n_nodes
        return math.fsum(self._patch.water[:n] * self._patch.graph.area[:n])

    @property
    def n_wet(self) -> int:
        """Nodes with water."""
        return int(np.count_nonzero(self._patch.water > 0.0))

    @property
    def is_dry(self) -> bool:
        """Whether no water is left, nor ink that `follow` has not taken up."""
        return not (self._patch.is_wet() or len(self.waiting))

    @property
    def is_wet(self) -> bool:
        """Whether any water is left that `depths` tells."""
        return self._patch.is_wet()

    @property
    def patience(self) -> float:
        """Time that may pass before anything has to move, s; infinite where nothing is wet."""
        patch = self._patch
        wet = patch.wet_blocks()
        return max(0.0, float((patch.pace[wet] - patch.owed[wet]).min(initial=np.inf)))

    def depths(self) -> tuple[AnyArray, AnyArray]:
        """Vertices (C,) int32 of the patch and the depth of water on each (C,), mm."""
        graph = self._patch.graph
        node = graph.node_of[: graph.n_places]
        return graph.vertices[: graph.n_places], self._patch.water[node]

    def keep(self) -> dict[str, AnyArray]:
        """What `restore` takes: what is on the patch, vertex by vertex."""
        return self._patch.keep()

    def clear(self) -> None:
        """Take all water away."""
        self._patch.clear()
        self.waiting = self.waiting[:0]

    def restore(self, kept: Mapping[str, AnyArray]) -> None:
        """Go on where another flow, on the same surface with the same ink, was kept."""
        self.waiting = self.waiting[:0]
        self._patch.restore(kept)

    # -- time -------------------------------------------------------------------------------

    def advance(self, seconds: float, step: float | None, fresh: AnyArray) -> None:
        """Let time pass; `fresh` (N,) int32 are vertices whose ink may have changed since."""
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
        self._bring_to_now()
        patch.hand_back()

    def _bring_to_now(self) -> None:
        patch = self._patch
        while len(wet := patch.wet_blocks()) and patch.owed[wet].any():
            self._step(wet[patch.owed[wet] > 0.0])

    def follow(self, seconds: float, fresh: AnyArray, most_nodes: int) -> bool:
        """Let time pass, and let what is due move, as far as there is time for it.

        Water that moves little is left where it is until its step is due, and of what is due no
        more is done than `most_nodes` for every 1/20 s, what waits longest first; and no more than
        a few blocks are opened. The rest is due at the next call, which may be for no time at all.
        How far anything is behind, and what is done in one call, does not depend on a clock.

        Returns
        -------
        bool
            Whether nothing waits so long that this could be seen: water for its step more than
            0.12 s, and three times what suits it; ink to be taken up 0.12 s.
        """
        patch = self._patch
        self._ease = _EASE
        now, self.waiting = patch.open_some(fresh, _OPENED)
        self._waited = self._waited + seconds if len(self.waiting) else 0.0
        self._take_up(now)
        if not patch.open_wet(_OPENED):
            patch.owed += seconds
            patch.hand_back()
            return False
        pieces = max(1, math.ceil(seconds / _PIECE))
        for _ in range(pieces):
            patch.owed += seconds / pieces
            wet = patch.wet_blocks()
            self._step(self._most_urgent(self._due(wet, patch.pace[wet]), most_nodes))
        patch.hand_back()
        wet = patch.wet_blocks()
        is_late = patch.owed[wet] >= np.maximum(_LATE, 3.0 * patch.pace[wet])
        return not is_late.any() and self._waited < _LATE

    def _due(self, wet: AnyArray, pace: AnyArray) -> AnyArray:
        """Those of the wet blocks (K,), of paces (K,), that take a step now."""
        patch, graph = self._patch, self._patch.graph
        share = np.zeros(graph.n_blocks)
        share[wet] = patch.owed[wet] / pace
        is_due = share >= _NEARLY
        for block in np.flatnonzero(is_due):
            beside = graph.beside[graph.first_beside[block] : graph.last_beside[block]]
            is_due[beside] |= share[beside] >= _BESIDE
        return np.flatnonzero(is_due)

    def _most_urgent(self, due: AnyArray, most_nodes: int) -> AnyArray:
        """Those of the blocks (K,) that wait longest for their pace, rising; one at least."""
        patch = self._patch
        late = np.argsort(-patch.owed[due] / patch.pace[due], kind="stable")
        sizes = np.cumsum(patch.graph.block_nodes[due[late]])
        n = int(np.searchsorted(sizes, most_nodes, side="right"))
        return np.sort(due[late[: max(1, n)]])

    def _take_up(self, fresh: AnyArray) -> None:
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

    def _step(self, blocks: AnyArray) -> None:
        """Let the water of some blocks (K,), rising, move and dry for the time they are owed."""
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
        self._ease_entries(blocks, step)
        bundles = self._bundles(blocks)
        work = [(bundle, np.zeros(1)) for bundle in bundles]
        done = each(lambda own: self._move_and_dry(*own, step), work)
        dried = []
        for own, gone in zip(work, done, strict=True):
            while gone is None:  # more of the surface has to be known first
                patch.open(self._wanted(own[0], step))
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

    def _ease_entries(self, blocks: AnyArray, step: _Step) -> None:
        """Let the water in and around some blocks (K,) find its way into notches of its border."""
        p = self._patch
        nodes = np.concatenate([p.graph.nodes_of(blocks), p.graph.rims_of(blocks)])
        ease_entries(nodes, p.fields(step.due, step.mobile, step.moved), p.dry_entry)

    def _bundles(self, blocks: AnyArray) -> list[AnyArray]:
        """Blocks (K,) in bundles that have nothing to do with one another, none very small."""
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
        """Let the next steps follow the motion in these; `came` (K,) are blocks wet since."""
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
        """A step of some blocks (K,), which touches nothing that other bundles know of.

        Returns the nodes that are dry now, or None where more of the surface has to be known: then
        nothing was done.
        """
        p = self._patch
        nodes = p.graph.nodes_of(blocks)
        fields, rims = p.fields(step.due, step.mobile, step.moved), p.graph.rims_of(blocks)
        while True:
            stages = move_water(fields, nodes, rims, self._drink, _SHORTEST, rest, work_memory.room)
            if stages != TOO_LITTLE_ROOM:
                break
            work_memory.grow()
        work_memory.give_back()
        if stages < 0:
            return None
        return self._evaporate(nodes, float(rest[0]), step)

    def _wanted(self, blocks: AnyArray, step: _Step) -> AnyArray:
        """Blocks to be opened before the water on some blocks (K,) can move."""
        graph, water = self._patch.graph, self._patch.water
        ring = graph.rims_of(blocks)
        ring = ring[~step.due[graph.block[ring]]]
        asked = ring[(graph.closed[ring] == 2) | ((graph.closed[ring] == 1) & (water[ring] > 0.0))]
        step.rings += 1
        wanted = np.unique(graph.block[asked])
        for _ in range(step.rings // 2):  # the farther the water goes at once, the farther we look
            wanted = graph.blocks_around(wanted)
        return wanted

    def _evaporate(self, nodes: AnyArray, rest: float, step: _Step) -> AnyArray:
        """Let the water of some nodes (N,) dry; return those that are dry now."""
        p = self._patch
        fields = p.fields(step.due, step.mobile, step.moved)
        is_wet = p.water[nodes] > 0.0
        wet = nodes[is_wet]
        p.inside[nodes[~is_wet]] = 0.0
        solve_edges(wet, fields, p.totals, _EDGE_REACH, _EDGE_SWEEPS, p.inside)
        dried = np.empty(len(wet), np.int32)
        drying = Drying(float(p.material.drying_mm_s), _EDGE_GAIN, _DRY)
        count = evaporate(wet, fields, rest, drying, p.inside, dried, step.still_wet)
        return dried[:count]


def each(work: Callable[[_Given], _Found], items: Sequence[_Given]) -> list[_Found]:
    """What `work` gives for each item, in their order; kernels in it run at the same time."""
    if len(items) < 2:
        return [work(item) for item in items]
    return list(_threads(os.getpid()).map(work, items))


@lru_cache(maxsize=1)
def _threads(process: int) -> ThreadPoolExecutor:
    """The threads of this process: one that was forked has none of its parent's."""
    count = min(_MOST_THREADS, os.cpu_count() or 1)
    return ThreadPoolExecutor(count, thread_name_prefix="paint3d-flow")


# ---- Water ---------------------------------------------------------------------------------------
# Water on a surface, and the ink that it has not heard of yet.


class Water:
    """The water on the layer that is painted on; there is none until it is asked for.

    Parameters
    ----------
    store : InkStore

    Attributes
    ----------
    fresh : list of (N,) int32, or None
        Vertices whose ink may have changed since the water was told; None while there is none.
    """

    def __init__(self, store: InkStore) -> None:
        self._store = store
        self._flow: Flow | None = None
        self._still: Flow | None = None  # one that was dropped: its graph may serve again
        self.fresh: list[AnyArray] | None = None

    @property
    def flow(self) -> Flow:
        """The water and its way, from the first time that it is asked for."""
        if self._flow is None:
            self._flow, self._still = self._still or Flow(self._store), None
            self._flow.clear()
            self.fresh = [np.flatnonzero(self._store.coverage > 0.0).astype(np.int32)]
        return self._flow

    @property
    def patience(self) -> float:
        """Time that may pass before there is anything to do, s; infinite if all is dry."""
        n_dirty = self._store.ink.n_dirty[0]
        if self._flow is None:
            return 0.0 if n_dirty or self._store.coverage.any() else np.inf
        is_fresh = n_dirty > 0 or any(len(ids) for ids in self.fresh or ())
        return 0.0 if is_fresh else self._flow.patience

    def depths(self) -> tuple[AnyArray, AnyArray] | None:
        """Vertices (C,) int32 and the depth of water on each, mm; None where there is none."""
        if self._flow is None or not self._flow.is_wet:
            return None
        return self._flow.depths()

    def advance(self, seconds: float, step: float | None) -> None:
        """See `Flow.advance`."""
        self.flow.advance(seconds, step, self._take_fresh())

    def follow(self, seconds: float, most_nodes: int) -> bool:
        """See `Flow.follow`."""
        keeps_up = self.flow.follow(seconds, self._take_fresh(), most_nodes)
        self.fresh = [*(self.fresh or ()), self.flow.waiting]
        return keeps_up

    def keep(self) -> dict[str, AnyArray] | None:
        """What `restore` takes, or None where no water has ever moved.

        Besides what `Flow.keep` says, fresh (N,) int32: vertices whose ink came since.
        """
        if self._flow is None:
            return None
        fresh = [*(self.fresh or ()), self._dirty()]
        return {**self._flow.keep(), "fresh": union(fresh, self._store.paint_mesh.capacity)}

    def restore(self, kept: Mapping[str, AnyArray]) -> None:
        """Go on as on the surface that it was kept from."""
        kept, count = dict(kept), len(self._store.pigments)
        for name in ("pigment", "fine", "written"):  # pigments may have come since
            missing = count - kept[name].shape[1]
            kept[name] = np.pad(kept[name], ((0, 0), (0, missing)))
        self.flow.restore(kept)
        self.fresh = [kept["fresh"]]

    def drop(self) -> None:
        """Let there be none in motion."""
        self._still = self._flow or self._still
        self._flow, self.fresh = None, None

    def _take_fresh(self) -> AnyArray:
        """Vertices (N,) int32 whose ink may have changed since the water was told."""
        fresh = [*(self.fresh or ()), self._dirty()]
        self.fresh = []
        return np.concatenate(fresh)

    def _dirty(self) -> AnyArray:
        ink = self._store.ink
        return ink.dirty_ids[: int(ink.n_dirty[0])]
