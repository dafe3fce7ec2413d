"""The wet part of a surface as a graph, with the water and the pigment on its nodes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.ink.materials import WET_COAT_MM
from paint3d.ink.pigments import WATER
from paint3d.kernels.diffusion import activate_cells
from paint3d.kernels.grain import fill_grain
from paint3d.mesh.flow_graph import FlowGraph, build_flow_graph

if TYPE_CHECKING:
    from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["WetPatch"]

_GRAIN_MM = 1.2  # bumps of the paper that ink runs around
_GRAIN_OF_PORES = 1.5  # of the residual, per unit of the material's grain
_GRAIN_OF_WAYS = 2.0  # of the conductance
_KEPT = ("water", "speed", "inside", "soaked", "pigment")
_RINGS = 1  # pieces of surface ahead of the water; doubled whenever it is too few


class WetPatch:
    """Nodes, their neighbours, and what is on them (N nodes, C vertices, P pigments).

    Attributes
    ----------
    graph : FlowGraph
    area : (N,) float64
        mm2.
    weights, totals, residual, strength, entry
        Of `kernels.diffusion`, with the grain in them.
    held : (N,) float64
        Depth, mm, to which a dry node fills before water goes on.
    water : (N,) float64
        Depth, mm.
    pigment : (N, P) float64
        Coats times the covered share.
    speed : (N,) float64
        Change of depth in the last step, mm/s.
    inside : (N,) float64
        See `kernels.diffusion.solve_edges`.
    soaked : (N,) float64
        Greatest share of the node's area that was under water since it was last dry, 0 to 1.
    order : (A,) int32
        Nodes in falling order of the potential, as the last step had them.
    changed : (N,) bool
        Nodes whose ink moved since it was handed back.
    """

    def __init__(self, surface: PaintedSurface) -> None:
        self._surface = surface
        self.material = surface.material
        self._place = np.zeros(0, np.int32)  # of each vertex among those of the patch, plus 1
        self._rings = _RINGS
        self._empty(0)

    def _empty(self, n: int) -> None:
        pigments = len(self._surface.pigments)
        self.graph: FlowGraph | None = None
        self.vertices = np.empty(0, np.int32)
        self.node_of = np.empty(0, np.int32)
        self.area = np.zeros(n)
        self.water, self.speed, self.inside = np.zeros(n), np.zeros(n), np.zeros(n)
        self.soaked = np.zeros(n)
        self.pigment = np.zeros((n, pigments))
        self.changed = np.zeros(n, bool)
        self.order = np.empty(0, np.int32)
        self._written = np.zeros((0, pigments), np.float32)
        self._share = np.empty(0)

    def keep(self) -> dict[str, NDArray]:
        """What `restore` takes, vertex by vertex."""
        self._know_pigments()
        node = self.node_of
        first = np.empty(len(self.water), np.int64)
        first[node[::-1]] = np.arange(len(node))[::-1]  # of its vertices
        kept = {name: getattr(self, name)[node] for name in _KEPT}
        return kept | {
            "vertices": self.vertices,
            "rim": np.zeros(0, np.uint8) if self.graph is None else self.graph.rim[node],
            "written": self._written.copy(),
            "order": self.vertices[first[self.order]],
        }

    def restore(self, kept: Mapping[str, NDArray]) -> None:
        """Take over what another patch kept, on the same vertices of the same surface.

        Where this patch reaches beyond all that is wet, it stays: how far changes nothing.
        """
        place = self._places(kept["vertices"])
        holds = np.zeros(len(place), bool)
        for name in (*_KEPT, "written"):
            holds |= kept[name].any(axis=tuple(range(1, kept[name].ndim)))
        outside = (place < 0) | self._on_rim(place)
        if self.graph is None or (holds & outside).any():
            self._reach(kept)
            self._find_grain()
            place = self._places(kept["vertices"])
        self._know_pigments()
        for name in _KEPT:
            getattr(self, name)[:] = 0.0
        self._written[:] = 0.0
        here = place >= 0
        for name in _KEPT:
            getattr(self, name)[self.node_of[place[here]]] = kept[name][here]
        self._written[place[here]] = kept["written"][here]
        order = self._places(kept["order"])
        self.order = self.node_of[order[order >= 0]].astype(np.int32)
        self.entry = np.where(self.soaked >= 1.0, 0.0, self._dry_entry)
        self.changed[:] = False

    def _reach(self, kept: Mapping[str, NDArray]) -> None:
        """Be as large as the patch that was kept."""
        mesh = self._surface.paint_mesh
        fields, n = mesh.arrays, mesh.n_vertices
        sheets = np.zeros(mesh.n_sheets, bool)
        sheets[fields.vertex_sheet[kept["vertices"][kept["rim"] == 0]]] = True
        in_patch = sheets[fields.vertex_sheet[:n]]
        self._take_over(build_flow_graph(fields, mesh.leaf_faces(), mesh.vertex_areas, in_patch))

    def is_wet(self) -> bool:
        """Whether there is any water left."""
        return bool((self.water > 0.0).any())

    def mobile(self) -> NDArray:
        """(A,) int32 nodes whose water can move."""
        if self.material.pores_mm <= 0.0:
            return np.empty(0, np.int32)
        return np.flatnonzero(self.water > self.residual * self.material.pores_mm).astype(np.int32)

    # -- what comes and goes ----------------------------------------------------------------

    def take_up(self, fresh: NDArray) -> bool:
        """Follow what happened to the ink of some vertices (N,); whether there is new water."""
        surface = self._surface
        self._know_pigments()
        place = self._places(fresh)
        wet = surface.ink.amounts[fresh].any(axis=1)
        outside = (place < 0) | (wet & self._on_rim(place))
        if (outside & wet).any():
            self._build(fresh[wet])
            place = self._places(fresh)
        seen = np.zeros(len(self.vertices), bool)
        seen[place[place >= 0]] = True
        at = np.flatnonzero(seen)
        now = surface.ink.amounts[self.vertices[at]]
        differs = (now != self._written[at]).any(axis=1)  # most are what was handed back
        if not differs.any():
            return False
        at, now = at[differs], now[differs]
        change = (now - self._written[at]).astype(np.float64)
        node, share = self.node_of[at], self._share[at]
        came = np.maximum(change, 0.0).sum(axis=1)
        went = np.maximum(-change, 0.0).sum(axis=1)
        before = self._written[at].sum(axis=1, dtype=np.float64)
        kept = 1.0 - share * np.divide(went, before, out=np.zeros_like(went), where=before > 0)
        np.multiply.at(self.water, node, kept)
        np.add.at(self.water, node, WET_COAT_MM * share * came)
        np.add.at(self.pigment, node, share[:, None] * change)
        np.maximum(self.pigment, 0.0, out=self.pigment)
        self._written[at] = now
        self._drop_water(at)
        laid = node[came > 0.0]
        self.soaked[laid] = 1.0  # wetted by the brush
        self.entry[laid] = 0.0
        self.changed[node] = True
        self.water[self.pigment.sum(axis=1) + self.water <= 0.0] = 0.0
        return bool((came > 0.0).any())

    def _know_pigments(self) -> None:
        missing = len(self._surface.pigments) - self.pigment.shape[1]
        if missing:
            self.pigment = np.pad(self.pigment, ((0, 0), (0, missing)))
            self._written = np.pad(self._written, ((0, 0), (0, missing)))

    def _drop_water(self, at: NDArray) -> None:
        """Plain water has become depth: it is no longer an amount."""
        for column, pigment in enumerate(self._surface.pigments):
            if pigment is WATER:
                self.pigment[self.node_of[at], column] = 0.0

    def hand_back(self) -> None:
        """Put the pigment back on the vertices, where it moved."""
        at = np.flatnonzero(self.changed[self.node_of])
        if not len(at):
            return
        ink, ids, nodes = self._surface.ink, self.vertices[at], self.node_of[at]
        amounts = self.pigment[nodes].astype(np.float32)
        ink.amounts[ids] = amounts
        self._written[at] = amounts
        inked = amounts.any(axis=1)
        ink.coverage[ids[inked]] = np.maximum(
            ink.coverage[ids[inked]], self.soaked[nodes[inked]].astype(np.float32)
        )
        self._surface.touch(ids)
        self.changed[:] = False

    def dry(self, nodes: NDArray) -> None:
        """What is on some nodes (N,) has lost its water: it becomes a dry layer."""
        self.hand_back()
        gone = np.zeros(len(self.water), bool)
        gone[nodes] = True
        at = np.flatnonzero(gone[self.node_of])
        ids = self.vertices[at]
        painted = self._surface.ink.coverage[ids] > 0.0
        self.pigment[nodes] = 0.0
        self.soaked[nodes] = 0.0
        self.entry[nodes] = self._dry_entry[nodes]
        self._surface.settle(ids[painted])
        self._surface.touch(ids[~painted])
        self._surface.ink.amounts[ids] = 0.0
        self._written[at] = 0.0

    def soak(self, nodes: NDArray) -> None:
        """Note how much of some nodes (N,) is under water now."""
        water, held = self.water[nodes], self.held[nodes]
        share = np.divide(water, held, out=np.ones_like(water), where=water < held)
        self.soaked[nodes] = np.maximum(self.soaked[nodes], share)
        self.entry[nodes[self.soaked[nodes] >= 1.0]] = 0.0

    # -- where ------------------------------------------------------------------------------

    def _places(self, ids: NDArray) -> NDArray:
        """(N,) place of vertices among those of the patch, -1 for others."""
        known = ids < len(self._place)  # the mesh may have grown since
        place = np.full(len(ids), -1, np.int32)
        place[known] = self._place[ids[known]] - 1
        return place

    def _on_rim(self, place: NDArray) -> NDArray:
        if self.graph is None or not len(self.vertices):
            return np.zeros(len(place), bool)
        return (place >= 0) & (self.graph.rim[self.node_of[np.maximum(place, 0)]] == 1)

    def grow(self) -> None:
        """Look further ahead of the water."""
        self._rings *= 2
        self._build(np.empty(0, np.int32))
        self._rings = max(_RINGS, self._rings // 2)

    def _build(self, fresh: NDArray) -> None:
        """Make the graph of everything wet, of some fresh vertices (N,), and of a margin."""
        surface = self._surface
        held = np.flatnonzero((self.water > 0.0) | self.pigment.any(axis=1))
        kept = np.zeros(len(self.water), bool)
        kept[held] = True
        ids = np.concatenate([self.vertices[kept[self.node_of]], fresh]).astype(np.int32)
        sheets = self._refined_sheets(ids)
        mesh = surface.paint_mesh
        fields, n = mesh.arrays, mesh.n_vertices
        in_patch = sheets[fields.vertex_sheet[:n]]
        graph = build_flow_graph(fields, mesh.leaf_faces(), mesh.vertex_areas, in_patch)
        self._take_over(graph)
        self._find_grain()

    def _refined_sheets(self, ids: NDArray) -> NDArray:
        """(S,) bool: the pieces of surface of some vertices and a margin, refined."""
        surface = self._surface
        fields = surface.paint_mesh.arrays
        sheets = np.zeros(surface.paint_mesh.n_sheets, bool)
        sheets[fields.vertex_sheet[ids]] = True
        for _ in range(self._rings if self.material.pores_mm > 0.0 else 0):
            from_ = np.flatnonzero(sheets)
            counts = fields.sheet_links[from_ + 1] - fields.sheet_links[from_]
            starts = np.repeat(fields.sheet_links[from_] - np.cumsum(counts) + counts, counts)
            sheets[fields.linked_sheet[starts + np.arange(len(starts))]] = True
        cells = np.unique(fields.sheet_cell[sheets])
        done = 0
        while done < len(cells):
            done = activate_cells(surface.paint_mesh.arrays, cells, done)
            if done < len(cells):
                surface.make_room()
        return sheets

    def _take_over(self, graph: FlowGraph) -> None:
        """Carry what is on the old graph to the new one."""
        old_vertices, old_node_of, written = self.vertices, self.node_of, self._written
        names = ("water", "speed", "inside", "soaked", "pigment")
        old = [getattr(self, name) for name in names]
        place = np.zeros(self._surface.paint_mesh.capacity, np.int32)
        place[graph.vertices] = np.arange(1, len(graph.vertices) + 1, dtype=np.int32)
        self._empty(graph.n_nodes)
        self.graph, self._place = graph, place
        self.vertices, self.node_of, self.area = graph.vertices, graph.node_of, graph.area
        areas = self._surface.paint_mesh.vertex_areas[graph.vertices]
        self._share = areas / self.area[self.node_of]
        self._written = np.zeros((len(graph.vertices), len(self._surface.pigments)), np.float32)
        stays = place[old_vertices] > 0
        at = place[old_vertices[stays]] - 1
        nodes, before = self.node_of[at], old_node_of[stays]
        self._written[at] = written[stays]
        for name, then in zip(names, old, strict=True):
            getattr(self, name)[nodes] = then[before]

    def _find_grain(self) -> None:
        """Let the pores and the ways between them vary with the material's grain."""
        drink, graph = self.material, self.graph
        height = np.empty(graph.n_nodes)
        fill_grain(graph.points, _GRAIN_MM, height)
        bump = drink.grain * (2.0 * height - 1.0)
        relief = _GRAIN_OF_PORES * bump
        self.residual = np.clip(drink.residual * (1.0 + relief), 0.0, 0.95)
        self.strength = drink.pores_mm * drink.spread_mm2_s * (1.0 - self.residual) / 3.0
        self.held = drink.pores_mm * np.maximum(self.residual, drink.advance * (1.0 + relief))
        s = np.clip((self.held / max(drink.pores_mm, 1e-9) - self.residual), 0.0, 1.0)
        s = np.minimum(1.0, s / (1.0 - self.residual))
        self._dry_entry = self.strength * s**3
        self.entry = np.where(self.soaked >= 1.0, 0.0, self._dry_entry)
        ways = np.maximum(0.05, 1.0 + _GRAIN_OF_WAYS * bump)
        start = np.repeat(ways, np.diff(graph.runs))
        end = ways[graph.links]
        weights = graph.weights * (2.0 * start * end / (start + end))
        first = np.repeat(np.arange(graph.n_nodes), np.diff(graph.runs))
        weights[(graph.rim[first] | graph.rim[graph.links]) == 1] = 0.0
        self.weights = weights
        self.totals = np.bincount(first, weights=weights, minlength=graph.n_nodes)
