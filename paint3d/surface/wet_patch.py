"""The wet part of a surface: the flow graph with water and pigment on its nodes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.materials import WET_COAT_MM, WET_INK_MM
from paint3d.colour.pigments import WATER
from paint3d.core.arrays import AnyArray
from paint3d.surface.flow_graph import with_room
from paint3d.surface.ink_store import InkStore
from paint3d.surface.kernels.diffusion import give_back, mark_news
from paint3d.surface.kernels.wet_step import WetFields
from paint3d.surface.pores import Pores, clog_pores, even_exp, find_pores, mobility_of

__all__ = ["FIRST_PACE", "WetPatch"]

_KEPT = ("water", "inside", "soaked", "laid", "pigment", "fine", "loose")
_OF_PLACES = ("written", "part")
_OF_NODES = (
    *_KEPT, "changed", "is_held", "residual", "strength", "sieve", "catch", "entry_depth", "entry",
    "dry_entry", "conductance", "place", "bare_entry_depth", "bare_conductance",
)  # fmt: skip
_OF_PORES = ("residual", "strength", "sieve", "catch", "bare_entry_depth", "bare_conductance")
_THICK = 9.0  # coats to the mm of liquid from which on soot's flocs hold together: one part in 4
_LOOSE = 0.6  # of its flocs that ever more water parts
_LAID = 0.5  # of the water on a node, what brushes laid at least if it did not run there
_FRESH = 0.02  # of the liquid on a node, what comes at once where a tuft with ink is
_PARTICLES = 0.65  # what is not fine of a pigment that has no more of a dye than soot has
FIRST_PACE = 1.0 / 30.0  # s: the time step of a block after ink arrived


class WetPatch:
    """Water and pigment on the flow graph (N nodes, C vertices, P pigments, B blocks, L links).

    The patch extends one block beyond what is wet, and never shrinks. Arrays have spare capacity at
    their ends, which is 0.

    Attributes
    ----------
    graph : FlowGraph
    weights : (L,) float64
        Those of the graph times the conductance, which varies with grain and glue.
    totals, residual, strength, entry : (N,) float64
        Of `surface.kernels.diffusion`, varied by the grain.
    sieve : (N,) float64
        Potential from which on pores pass coarse pigment at full speed, mm3/s.
    catch : (N,) float64
        Fraction of the fine pigment arriving through its pores that a node holds back.
    bare_entry_depth, bare_conductance : (N,) float64
        `entry_depth` and `conductance` (factors on the conductance) as they would be without glue.
    entry_depth : (N,) float64
        Depth, mm, at which a dry node is soaked.
    water : (N,) float64
        Depth, mm.
    pigment : (N, P) float64
        Coats times the covered fraction.
    fine : (N, P) float64
        The part of it that goes with the water, until pores catch it on the way.
    loose : (N, P) float64
        The flocs that much water parts: they go with it, too, and are hardly caught.
    mobility : (P,) float64
        Mobility of each pigment's coarse grains in the pores, relative to soot.
    sticks : (P,) float64
        How far its fine part is caught in pores: as soot's, 1; a dye's is not.
    inside : (N,) float32
        See `kernels.diffusion.solve_edges`.
    soaked : (N,) float32
        Fullest since it was last dry: water over `entry_depth`, 0 to 1.
    laid : (N,) float32
        Depth of the liquid that brushes brought there since it was last dry, mm.
    is_held : (N,) bool
        Nodes that let no water pass for now; see `held`.
    changed : (N,) bool
        Nodes whose ink moved since it was handed back.
    owed : (B,) float32
        Time since each block's last step, s; infinite where there is no water.
    pace : (B,) float32
        The time step of each block, s.
    place : (N,) int32
        Scratch, 0 between two steps.
    """

    residual: NDArray[np.float64]
    strength: NDArray[np.float64]
    sieve: NDArray[np.float64]
    catch: NDArray[np.float64]
    mobility: NDArray[np.float64]
    sticks: NDArray[np.float64]
    entry: NDArray[np.float64]
    dry_entry: NDArray[np.float64]
    entry_depth: NDArray[np.float64]
    water: NDArray[np.float64]
    conductance: NDArray[np.float64]
    bare_entry_depth: NDArray[np.float64]
    bare_conductance: NDArray[np.float64]

    def __init__(self, store: InkStore) -> None:
        self._store = store
        self.material = store.material
        self.graph = store.flow_graph
        count = len(store.pigments)
        for name in _OF_NODES:
            setattr(self, name, np.zeros(0))
        self.changed, self.is_held = np.zeros((2, 0), bool)
        self.place = np.zeros(0, np.int32)
        self.inside, self.soaked, self.laid = np.zeros((3, 0), np.float32)
        self.pigment, self.fine, self.loose = np.zeros((3, 0, count))
        self._find_mobility()
        self.written, self.part = np.zeros((0, count), np.float32), np.zeros(0)
        self.weights, self.totals = np.zeros(0), np.zeros(0)
        self._n_nodes = self._n_links = 0
        self._seen = (store.dry_layers, store.dry_layers.changes)
        self.owed = np.full(self.graph.n_blocks, np.inf, np.float32)
        self.pace = np.full(self.graph.n_blocks, FIRST_PACE, np.float32)
        self._follow()

    def keep(self) -> dict[str, AnyArray]:
        """Return the state for `restore`, vertex by vertex, where it is not zero."""
        self._know_pigments()
        n, places = self.graph.n_nodes, self.graph.n_places
        holds = np.zeros(n, bool)
        for name in _KEPT:
            nonzero = getattr(self, name)[:n] != 0.0
            holds |= nonzero if nonzero.ndim == 1 else nonzero.any(axis=1)
        node = self.graph.node_of[:places]
        at = np.flatnonzero(holds[node] | self.written[:places].any(axis=1))
        node = node[at]
        block = self.graph.block[node]
        return {name: getattr(self, name)[node] for name in _KEPT} | {
            "vertices": self.graph.vertices[at],
            "written": self.written[at],
            "owed": np.where(np.isfinite(self.owed[block]), self.owed[block], np.float32(0.0)),
            "pace": self.pace[block],
        }

    def clear(self) -> None:
        """Remove all water and pigment."""
        self._know_pigments()
        for name in _KEPT:
            getattr(self, name)[:] = 0.0
        self.written[:] = 0.0
        self.update_glue()
        self.entry[:] = self.dry_entry
        self.changed[:] = False
        self.owed[:], self.pace[:] = np.inf, FIRST_PACE

    def restore(self, kept: Mapping[str, AnyArray]) -> None:
        """Replace the state by one `kept` by a patch on the same surface."""
        ids = kept["vertices"]
        self.graph.know(self.graph.cells_of(ids))  # links are computed when needed
        self._follow()
        self.clear()
        place = self.graph.places(ids)
        node = self.graph.node_of[place]
        for name in _KEPT:
            getattr(self, name)[node] = kept[name]
        self.written[place] = kept["written"]
        self.entry = np.where(self.soaked >= 1.0, 0.0, self.dry_entry)
        wet = kept["water"] > 0.0
        block = self.graph.block[node[wet]]
        self.owed[block], self.pace[block] = kept["owed"][wet], kept["pace"][wet]

    def fields(self, due: AnyArray, mobile: AnyArray, moved: AnyArray) -> WetFields:
        """Return the arrays for a step of blocks `due` (B,) bool; see `WetFields` for the rest."""
        graph = self.graph
        return WetFields(
            graph.first, graph.last, graph.links, self.weights, graph.area, graph.block,
            graph.closed, self.place, self.residual, self.strength, self.sieve, self.catch,
            self.entry_depth, self.entry, self.water, self.pigment, self.fine, self.loose,
            self.mobility, self.sticks, self.soaked, self.changed, self.owed, due, mobile, moved,
        )  # fmt: skip

    def is_wet(self) -> bool:
        """Whether there is any water left."""
        return bool(np.isfinite(self.owed).any())

    def wet_blocks(self) -> AnyArray:
        """Return the blocks with water (K,), ascending."""
        return np.flatnonzero(np.isfinite(self.owed))

    # -- exchange with the surface ----------------------------------------------------------

    def find_changed(self, fresh: AnyArray) -> AnyArray:
        """Return the places of those vertices (N,) whose ink is not what was handed back."""
        store, graph = self._store, self.graph
        self._know_pigments()
        self.update_glue()
        if not len(fresh):
            return fresh
        place = graph.places(fresh)
        is_new = np.empty(len(fresh), bool)
        mark_news(
            fresh, place, graph.node_of, graph.block, graph.block_open, self.written,
            store.ink.amounts, is_new,
        )  # fmt: skip
        fresh, place = fresh[is_new], place[is_new]
        wet = store.ink.amounts[fresh].any(axis=1)
        if (wet & ((place < 0) | ~self._is_open(place))).any():
            self.reach(fresh[wet])
            place = graph.places(fresh)
        seen = np.zeros(graph.n_places, bool)
        seen[place[place >= 0]] = True
        at = np.flatnonzero(seen)
        now = store.ink.amounts[graph.vertices[at]]
        result: AnyArray = at[(now != self.written[at]).any(axis=1)]
        return result

    def read_surface(self, at: AnyArray) -> AnyArray:
        """Apply changes of the ink at places (N,) to water and pigment; see `find_changed`.

        Returns the nodes (K,) under a tuft with ink, told by how much has just come.
        """
        graph = self.graph
        now = self._store.ink.amounts[graph.vertices[at]]
        change = (now - self.written[at]).astype(np.float64)
        node, part = graph.node_of[at], self.part[at]
        depths = [WET_COAT_MM if p is WATER else WET_INK_MM for p in self._store.pigments]
        came = np.zeros(len(at))
        for column, depth in enumerate(depths):  # see `fibre_relief`: no product of matrices
            came += np.maximum(change[:, column], 0.0) * depth
        went = np.maximum(-change, 0.0).sum(axis=1)
        before = self.written[at].sum(axis=1, dtype=np.float64)
        kept = 1.0 - part * np.divide(went, before, out=np.zeros_like(went), where=before > 0)
        np.multiply.at(self.water, node, kept)
        is_water = np.array([p is WATER for p in self._store.pigments])
        coats = np.maximum(change[:, ~is_water], 0.0).sum(axis=1)
        with_ink = coats > 0.0
        own = np.divide(came, coats, out=np.zeros_like(came), where=with_ink)
        coats += self.pigment[node].sum(axis=1)  # what comes runs together with what is there
        # What ran ahead of a tuft is one with it: of the liquid there it leaves what its ink has
        there = self.water[node]
        ran = with_ink & (self.laid[node] < _LAID * there)
        added = np.where(ran, np.minimum(came, np.maximum(own * coats - there, 0.0)), came)
        liquid = there + added
        thick = np.divide(coats, _THICK * liquid, out=np.ones_like(came), where=liquid > 0.0)
        thin = np.maximum(0.0, 1.0 - thick * thick)
        under_tuft = np.unique(node[with_ink & (came > _FRESH * liquid)])
        np.add.at(self.water, node, part * added)
        np.add.at(self.laid, node, (part * came).astype(np.float32))
        self._add_pigment(node, part[:, None] * change, thin)
        self.written[at] = now
        for column, pigment in enumerate(self._store.pigments):
            if pigment is WATER:  # it is now depth of water, no longer an amount
                self.pigment[node, column] = 0.0
                self.fine[node, column] = self.loose[node, column] = 0.0
        wetted = node[came > 0.0]
        covered = self._store.ink.coverage[graph.vertices[at[came > 0.0]]]
        np.maximum.at(self.soaked, wetted, covered)
        self.entry[wetted[self.soaked[wetted] >= 1.0]] = 0.0
        self.changed[node] = True
        bare = node[self.pigment[node].sum(axis=1) + self.water[node] <= 0.0]
        self.water[bare] = 0.0
        block = graph.block[wetted]
        self.pace[block] = FIRST_PACE
        self.owed[block[np.isinf(self.owed[block])]] = 0.0
        return under_tuft

    def _add_pigment(self, node: AnyArray, change: AnyArray, thin: AnyArray) -> None:
        """Add pigment (N, P) to nodes (N,), or remove it, of all kinds in proportion.

        The thinner the ink is then (N,), 0 to 1, the more of all flocs that come are loose.
        """
        came, before = np.maximum(change, 0.0), self.pigment[node]
        left = 1.0 + np.divide(change - came, before, out=np.zeros_like(came), where=before > 0)
        fine = np.array([pigment.fine for pigment in self._store.pigments])
        loose = _LOOSE * self.mobility * thin[:, None]
        np.add.at(self.pigment, node, change)
        self.pigment[node] = np.maximum(self.pigment[node], 0.0)
        rest = self.pigment[node]
        for kept, fraction in ((self.fine, fine * (1.0 - loose)), (self.loose, loose)):
            np.multiply.at(kept, node, np.clip(left, 0.0, 1.0))
            np.add.at(kept, node, fraction * came)
            kept[node] = np.minimum(kept[node], rest)
            rest = np.maximum(rest - kept[node], 0.0)

    def _know_pigments(self) -> None:
        """Add columns for pigments that are new on the surface."""
        missing = len(self._store.pigments) - self.pigment.shape[1]
        if missing:
            for name in ("pigment", "fine", "loose", "written"):
                setattr(self, name, np.pad(getattr(self, name), ((0, 0), (0, missing))))
            self._find_mobility()

    def _find_mobility(self) -> None:
        grains = np.array([pigment.grain_um for pigment in self._store.pigments], float)
        self.mobility = mobility_of(self.material, grains)
        fine = np.array([pigment.fine for pigment in self._store.pigments], float)
        self.sticks = np.minimum(1.0, (1.0 - fine) / _PARTICLES)

    def write_surface(self) -> None:
        """Write pigment that moved back to the vertices; ink that came since stays there."""
        if not self.changed.any():
            return
        graph, count = self.graph, self.graph.n_places
        ids = np.empty(count, np.int32)
        n = give_back(
            graph.vertices[:count], graph.node_of[:count], self.changed, self.pigment, self.soaked,
            self.written, self._store.ink, ids,
        )  # fmt: skip
        self._store.touch(ids[:n])

    def dry(self, nodes: AnyArray) -> None:
        """Turn the pigment on nodes (N,), which have lost their water, into dried paint.

        Ink that came since is wet, and stays for `read_surface`.
        """
        self.write_surface()
        graph, ink = self.graph, self._store.ink
        at = graph.places_at(nodes)
        ids = graph.vertices[at]
        now, coverage = ink.amounts[ids], ink.coverage[ids]
        came = np.maximum(now - self.written[at], np.float32(0.0))
        ink.amounts[ids] = now - came
        painted = coverage > 0.0
        self.pigment[nodes] = self.fine[nodes] = self.loose[nodes] = 0.0
        self.soaked[nodes] = self.laid[nodes] = 0.0
        self._store.settle(ids[painted])
        dry = self._store.dry_layers
        self._seen = (dry, dry.changes)
        self._clog_pores(nodes)
        self._weigh(nodes)
        self._store.touch(ids[~painted])
        ink.amounts[ids] = came
        ink.coverage[ids] = np.where(came.any(axis=1), coverage, ink.coverage[ids])
        self.written[at] = 0.0

    @contextmanager
    def held(self, nodes: AnyArray) -> Iterator[None]:
        """Stop the water from and to nodes (N,) meanwhile: a tuft lies there."""
        self.is_held[nodes] = True
        self._weigh(nodes)
        try:
            yield
        finally:
            self.is_held[nodes] = False
            self._weigh(nodes)

    # -- growth -----------------------------------------------------------------------------

    def _is_open(self, place: AnyArray) -> NDArray[np.bool_]:
        """Return whether places (N,) are in open blocks, (N,) bool; -1 is not."""
        graph = self.graph
        known = place >= 0
        is_open = np.zeros(len(place), bool)
        is_open[known] = graph.block_open[graph.block[graph.node_of[place[known]]]]
        return is_open

    def reach(self, ids: AnyArray) -> None:
        """Extend the patch to vertices (N,)."""
        cells = self.graph.cells_of(ids)
        self.graph.open(self.graph.blocks_of(cells))
        self._follow()

    def open_some(self, ids: AnyArray, most: int) -> tuple[AnyArray, AnyArray]:
        """Extend the patch to vertices (N,) with ink, opening at most `most` new blocks.

        Returns the vertices whose ink can be taken up now, and those that have to wait.
        """
        place = self.graph.places(ids)
        wanted = self._store.ink.amounts[ids].any(axis=1) & ~self._is_open(place)
        if not wanted.any():
            return ids, ids[:0]
        block = self.graph.block_of(ids)
        waiting = self._open_of(np.unique(block[wanted]), most)
        waits = wanted & np.isin(block, waiting)
        return ids[~waits], ids[waits]

    def open_wet(self, most: int) -> bool:
        """Open at most `most` new blocks with water; return whether all are open now."""
        wet = self.wet_blocks()
        return not len(self._open_of(wet[~self.graph.block_open[wet]], most))

    def _open_of(self, closed: AnyArray, most: int) -> AnyArray:
        """Open those of closed blocks (K,) that were open on saving, and at most `most` others.

        Returns those that stay closed. Blocks that were open on saving do not count, so that a
        restored painting goes on exactly as the saved one would have.
        """
        again = self.graph.was_open[closed]
        new = closed[~again]
        self.open(np.concatenate([closed[again], new[:most]]))
        return new[most:]

    def open(self, blocks: AnyArray) -> None:
        """Open blocks (K,) of the graph."""
        self.graph.open(blocks)
        self._follow()

    def _follow(self) -> None:
        """Initialise the nodes and links that were added to the graph."""
        graph = self.graph
        for name in _OF_NODES:
            setattr(self, name, with_room(getattr(self, name), graph.n_nodes))
        for name in _OF_PLACES:
            setattr(self, name, with_room(getattr(self, name), graph.n_places))
        self.weights = with_room(self.weights, graph.n_links)
        self.totals = with_room(self.totals, graph.n_nodes)
        nodes = slice(self._n_nodes, graph.n_nodes)
        if self._n_nodes < graph.n_nodes:
            # Pores vary with the grain, and with the glue that has dried in them.
            spacing = float(self._store.paint_mesh.arrays.resolution)
            pores = find_pores(graph.points[nodes], self.material, spacing)
            self.residual[nodes], self.strength[nodes], self.sieve[nodes] = pores[:3]
            self.catch[nodes] = 1.0 - even_exp(-np.sqrt(graph.area[nodes]) / pores.catch)
            self.bare_entry_depth[nodes], self.bare_conductance[nodes] = (
                pores.entry_depth,
                pores.conductance,
            )
            self._clog_pores(np.arange(nodes.start, nodes.stop))
            # Each vertex has the fraction of its node's area that is its own.
            first = np.searchsorted(graph.node_of[: graph.n_places], nodes.start)
            places = slice(int(first), graph.n_places)
            areas = self._store.paint_mesh.vertex_areas[graph.vertices[places]]
            self.part[places] = areas / graph.area[graph.node_of[places]]
        links = slice(self._n_links, graph.n_links)
        if self._n_links < graph.n_links:
            self._weigh_links(np.arange(links.start, links.stop))
            owner = graph.owner[links]
            own = np.bincount(owner, self.weights[links], graph.n_nodes)
            self.totals[: graph.n_nodes] += own
        self._n_nodes, self._n_links = graph.n_nodes, graph.n_links

    def _clog_pores(self, nodes: AnyArray) -> None:
        """Clog the pores of nodes (N,) by the glue of the ink that has dried there."""
        store, graph = self._store, self.graph
        first = np.searchsorted(graph.node_of[: graph.n_places], nodes)
        row = store.dry_layers.rows_of(graph.vertices[first])
        glue = np.zeros(len(nodes))
        if (row >= 0).any():
            glue[row >= 0] = store.dry_layers.amounts[row[row >= 0]].sum(axis=1)
        pores = Pores(*(getattr(self, name)[nodes] for name in _OF_PORES))
        entry_depth, entry, conductance = clog_pores(pores, self.material, glue)
        self.entry_depth[nodes], self.dry_entry[nodes], self.conductance[nodes] = (
            entry_depth,
            entry,
            conductance,
        )
        self.entry[nodes] = np.where(self.soaked[nodes] >= 1.0, 0.0, entry)

    def update_glue(self) -> None:
        """Update all pores if dried paint was added or removed by other means than `dry`."""
        dry = self._store.dry_layers
        if (dry, dry.changes) == self._seen:
            return
        self._seen = (dry, dry.changes)
        before = self.conductance.copy()
        self._clog_pores(np.arange(self._n_nodes))
        self._weigh(np.flatnonzero(self.conductance != before))

    def _weigh(self, nodes: AnyArray) -> None:
        """Update the weights of all links from and to nodes (N,) whose conductance has changed."""
        graph = self.graph
        if not len(nodes):
            return
        beside = graph.links[graph.links_of(nodes)]
        owners = np.unique(np.concatenate([nodes, beside]))
        links = graph.links_of(owners)
        self._weigh_links(links)
        place = np.searchsorted(owners, graph.owner[links])
        self.totals[owners] = np.bincount(place, self.weights[links], len(owners))

    def _weigh_links(self, links: AnyArray) -> None:
        """Set weights to the graph's times the harmonic mean of the conductances at both ends.

        0 where one is held.
        """
        graph = self.graph
        owner, other = graph.owner[links], graph.links[links]
        start, end = self.conductance[owner], self.conductance[other]
        weights = graph.weights[links] * (2.0 * start * end / (start + end))
        weights[self.is_held[owner] | self.is_held[other]] = 0.0
        self.weights[links] = weights
