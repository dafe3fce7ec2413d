"""The weighted graph on which liquids move over a surface.

It is built block by block where liquid arrives. A block is a cube of the lattice's cells; it is
*open* once the links of its nodes are known, for which it and the cells around it are refined
first: vertices and triangles there never change again (`mesh.kernels.refine`). The nodes and links
of a block depend on the block alone, not on when and with which others it was opened.

Coincident vertices on the two sides of a crease are one node. Weights are the cotangents of the
intrinsic Delaunay triangulation of the block and a margin (`surface.kernels.intrinsic_delaunay`);
areas are those of the paint mesh, so that both account for the same amounts of ink.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.surface.kernels.diffusion import activate_cells
from paint3d.surface.kernels.intrinsic_delaunay import link_triangles
from paint3d.surface.kernels.wet_graph import (
    count_vertices,
    group_blocks,
    leaves_in_box,
    list_distinct,
    list_vertices,
    pick_nodes,
)

__all__ = ["FlowGraph", "graph_of_triangles", "with_room"]

_BLOCK_CELLS = 3  # along an axis
_MARGIN_EDGES = 2.5  # edge lengths around a block: edge flips further away cannot reach it


class FlowGraph:
    """N nodes, L directed links, C vertices (some share a node on a crease), B blocks.

    Arrays have spare capacity at their ends.

    Parameters
    ----------
    mesh : PaintMesh
    make_room : callable
        Enlarges the mesh's arrays.

    Attributes
    ----------
    n_nodes, n_places, n_links : int
        N, C and L.
    vertices, node_of : (C,) int32
        Ids in the paint mesh, and the node of each. An index into these is a *place*.
    points : (N, 3) float64
        mm.
    area : (N,) float64
        mm2.
    block : (N,) int32
    closed : (N,) uint8
        1 where the links of a node are not known.
    first, last : (N,) int64
        The range of each node's links.
    links, weights : (L,) int32, (L,) float64
        Weights are >= 0.
    owner : (L,) int32
        The node that the link starts from.
    first_beside, last_beside : (B,) int64
        The range of each open block's neighbours in `beside`.
    beside : (M,) int32
        The blocks that share a link with it.
    block_open : (B,) bool
    was_open : (B,) bool
        Blocks that were open when this painting was saved: they may be opened again at once.
    block_nodes : (B,) int64
        Number of known nodes of each block.
    """

    def __init__(self, mesh: PaintMesh, make_room: Callable[[], None]) -> None:
        self._mesh, self._make_room = mesh, make_room
        place = mesh.arrays.cell_place // _BLOCK_CELLS
        self._block_places, block = np.unique(place, axis=0, return_inverse=True)
        self._cell_block = block.ravel().astype(np.int32)
        self._cells = np.argsort(self._cell_block, kind="stable").astype(np.int32)  # by blocks
        self._cell_runs = np.searchsorted(
            self._cell_block[self._cells], np.arange(self.n_blocks + 1)
        )
        self._rims: dict[int, AnyArray] = {}
        self.beside, self._n_beside = np.zeros(0, np.int32), 0
        self.first_beside, self.last_beside = np.zeros((2, self.n_blocks), np.int64)
        self._heads = np.full(self.n_blocks, -1, np.int32)
        self.block_open, self.was_open = np.zeros((2, self.n_blocks), bool)
        self.block_nodes = np.zeros(self.n_blocks, np.int64)
        self._known = np.zeros(mesh.n_cells, bool)
        self._start, self._stop = np.zeros((2, mesh.n_cells), np.int64)
        self._place = np.zeros(0, np.int32)  # place of each vertex plus 1, 0 for unknown ones
        self._rank = np.zeros(0, np.int32)  # scratch, all 0 between calls of `open`
        self.n_nodes = self.n_places = self.n_links = 0
        self.vertices, self.node_of = np.zeros((2, 0), np.int32)
        self.points = np.zeros((0, 3))
        self.area = np.zeros(0)
        self.block, self.closed = np.zeros(0, np.int32), np.zeros(0, np.uint8)
        self.first, self.last = np.zeros((2, 0), np.int64)
        self.links, self.owner = np.zeros((2, 0), np.int32)
        self.weights = np.zeros(0)

    @property
    def n_blocks(self) -> int:
        """Number of blocks that the surface meets, B."""
        return len(self._block_places)

    # -- look-up ----------------------------------------------------------------------------

    def places(self, ids: AnyArray) -> AnyArray:
        """Return the places (N,) of vertices, -1 for vertices that are not known."""
        known = ids < len(self._place)  # the mesh may have grown since
        place = np.full(len(ids), -1, np.int32)
        place[known] = self._place[ids[known]] - 1
        return place

    def places_at(self, nodes: AnyArray) -> AnyArray:
        """Return all places (M,) of nodes (N,), node after node, ascending for each."""
        node_of = self.node_of[: self.n_places]
        wanted = nodes.astype(np.int32)
        first = np.searchsorted(node_of, wanted)
        counts = np.searchsorted(node_of, wanted, side="right") - first
        return _from_runs(first, counts)

    def cells_of(self, ids: AnyArray) -> AnyArray:
        """Return the cells in which vertices (N,) lie, ascending."""
        fields = self._mesh.arrays
        marks = np.zeros(self._mesh.n_cells, bool)
        marks[fields.sheet_cell[fields.vertex_sheet[ids]]] = True
        return np.flatnonzero(marks)

    def block_of(self, ids: AnyArray) -> NDArray[np.int32]:
        """Return the block (N,) int32 in which each of some vertices lies."""
        fields = self._mesh.arrays
        result: NDArray[np.int32] = self._cell_block[fields.sheet_cell[fields.vertex_sheet[ids]]]
        return result

    def blocks_of(self, cells: AnyArray) -> AnyArray:
        """Return the blocks of cells (K,), ascending."""
        return np.unique(self._cell_block[cells])

    def around(self, cells: AnyArray) -> AnyArray:
        """Return cells (K,) with those that the surface continues into from there, ascending."""
        fields = self._mesh.arrays
        marks = np.zeros(self._mesh.n_cells, bool)
        marks[cells] = True
        sheets = _runs(fields.cell_sheets, cells)
        linked = fields.linked_sheet[_runs(fields.sheet_links, sheets)]
        marks[fields.sheet_cell[linked]] = True
        return np.flatnonzero(marks)

    def blocks_around(self, blocks: AnyArray) -> AnyArray:
        """Return blocks (K,) with those next to them, ascending."""
        return self.blocks_of(self.around(self._cells[_runs(self._cell_runs, blocks)]))

    def open_before(self, blocks: AnyArray) -> AnyArray:
        """Return the closed neighbours of open blocks (K,) that were open on saving, ascending."""
        starts, stops = self.first_beside[blocks], self.last_beside[blocks]
        around = np.unique(self.beside[_from_runs(starts, stops - starts)])
        result: AnyArray = around[self.was_open[around] & ~self.block_open[around]]
        return result

    def apart(self, blocks: AnyArray) -> list[AnyArray]:
        """Split open blocks (K,), ascending, into groups such that no block adjoins two of them."""
        group = np.empty(len(blocks), np.int32)
        count = group_blocks(
            blocks, self.first_beside, self.last_beside, self.beside, self._heads, group
        )
        order = np.argsort(group, kind="stable")
        ends = np.cumsum(np.bincount(group, minlength=count))[:-1]
        return np.split(blocks[order], ends)

    def nodes_of(self, blocks: AnyArray) -> AnyArray:
        """Return the known nodes of blocks (K,), ascending: always in the same order."""
        cells = self._cells[_runs(self._cell_runs, blocks)]
        cells = cells[self._known[cells]]
        starts, stops = self._start[cells], self._stop[cells]
        nodes = np.empty(int((stops - starts).sum()), np.int32)
        pick_nodes(starts, stops, nodes)
        return nodes

    def links_of(self, nodes: AnyArray) -> AnyArray:
        """Return the links of nodes (N,), node after node; none where they are not known."""
        return _from_runs(self.first[nodes], self.last[nodes] - self.first[nodes])

    def rims_of(self, blocks: AnyArray) -> AnyArray:
        """Return the nodes (R,) adjacent to open blocks (K,): always in the same order.

        A node may occur twice, or belong to one of these blocks.
        """
        rims = [self._rims[block] for block in blocks.tolist()]
        return np.concatenate([np.zeros(0, np.int32), *rims])

    # -- growth -----------------------------------------------------------------------------

    @property
    def opened(self) -> AnyArray:
        """The blocks (K,) that are open, or were on saving, ascending."""
        return np.flatnonzero(self.block_open | self.was_open)

    def know(self, cells: AnyArray) -> None:
        """Refine cells (K,) and create the nodes of their vertices."""
        cells = cells[~self._known[cells]]
        done = 0
        while done < len(cells):
            done = activate_cells(self._mesh.arrays, cells, done)
            if done < len(cells):
                self._make_room()
        if len(cells):
            self._add_nodes(cells)

    def _add_nodes(self, cells: AnyArray) -> None:
        fields = self._mesh.arrays
        ids = np.empty(count_vertices(fields, cells), np.int32)
        number = np.empty(len(ids), np.int32)
        list_vertices(fields, cells, ids, number)
        order = np.lexsort((fields.key[ids], number))
        ids, number = ids[order], number[order]
        key = fields.key[ids]
        new = np.ones(len(ids), bool)
        new[1:] = (key[1:] != key[:-1]) | (number[1:] != number[:-1])
        node = self.n_nodes + np.cumsum(new) - 1
        n, c = self.n_nodes + int(new.sum()), self.n_places + len(ids)
        for name in ("points", "area", "block", "closed", "first", "last"):
            setattr(self, name, with_room(getattr(self, name), n))
        for name in ("vertices", "node_of"):
            setattr(self, name, with_room(getattr(self, name), c))
        here, at = slice(self.n_nodes, n), ids[new]
        self.points[here] = np.column_stack([fields.px[at], fields.py[at], fields.pz[at]])
        unit = fields.area_unit
        areas = np.bincount(node - self.n_nodes, fields.area_units[ids] * unit, n - self.n_nodes)
        self.area[here] = areas
        self.block[here] = self._cell_block[cells[number[new]]]
        self.closed[here] = 1
        counts = np.bincount(number[new], minlength=len(cells))
        self._stop[cells] = self.n_nodes + np.cumsum(counts)
        self._start[cells] = self._stop[cells] - counts
        self.vertices[self.n_places : c] = ids
        self.node_of[self.n_places : c] = node
        if len(self._place) < self._mesh.capacity:
            place = np.zeros(self._mesh.capacity, np.int32)
            place[: len(self._place)] = self._place
            self._place = place
        self._place[ids] = np.arange(self.n_places + 1, c + 1, dtype=np.int32)
        np.add.at(self.block_nodes, self._cell_block[cells], counts)
        self._known[cells] = True
        self.n_nodes, self.n_places = n, c

    def open(self, blocks: AnyArray) -> None:
        """Compute the links of all nodes of blocks (K,)."""
        for block in blocks[~self.block_open[blocks]]:
            self._open(int(block))

    def _open(self, block: int) -> None:
        own = self._cells[self._cell_runs[block] : self._cell_runs[block + 1]]
        around = self.around(own)
        self.know(around)
        faces = self._faces_near(block, around)
        fields = self._mesh.arrays
        far = self.cells_of(faces.ravel())
        if not self._known[far].all():  # triangles longer than cells
            self.know(far)
            fields = self._mesh.arrays
        nodes = self.node_of[self._place[faces] - 1]
        ids = np.empty(nodes.size, np.int32)
        self._rank = with_room(self._rank, self.n_nodes)
        ids = np.sort(ids[: list_distinct(nodes.ravel(), self._rank, ids)])
        first = np.searchsorted(self.node_of[: self.n_places], ids)  # a place of each node
        key = fields.key[self.vertices[first]]
        ids = ids[np.argsort(key, kind="stable")]
        self._rank[ids] = np.arange(1, len(ids) + 1, dtype=np.int32)
        runs, links, weights = graph_of_triangles(self.points[ids], self._rank[nodes] - 1)
        self._rank[ids] = 0
        rows = np.flatnonzero(self.block[ids] == block)
        taken = _runs(runs, rows)
        counts = runs[rows + 1] - runs[rows]
        n = self.n_links + len(taken)
        for name in ("links", "owner", "weights"):
            setattr(self, name, with_room(getattr(self, name), n))
        self.links[self.n_links : n] = ids[links[taken]]
        is_rim = np.zeros(len(ids), bool)
        is_rim[links[taken]] = True
        is_rim[rows] = False
        self._rims[block] = ids[is_rim]
        around = np.unique(self.block[self._rims[block]])
        m = self._n_beside + len(around)
        self.beside = with_room(self.beside, m)
        self.beside[self._n_beside : m] = around
        self.first_beside[block], self.last_beside[block] = self._n_beside, m
        self._n_beside = m
        self.weights[self.n_links : n] = weights[taken]
        at = ids[rows]
        self.last[at] = self.n_links + np.cumsum(counts)
        self.first[at] = self.last[at] - counts
        self.owner[self.n_links : n] = np.repeat(at, counts)
        self.closed[self.nodes_of(np.array([block]))] = 0
        self.n_links = n
        self.block_open[block] = True

    def _faces_near(self, block: int, cells: AnyArray) -> AnyArray:
        """Return the triangles (F, 3) in a block and a margin around it, as vertex ids."""
        mesh = self._mesh
        fields = mesh.arrays
        size = fields.cell_size
        margin = min(_MARGIN_EDGES * fields.resolution, size)
        low = fields.origin + self._block_places[block] * (_BLOCK_CELLS * size) - margin
        high = low + _BLOCK_CELLS * size + 2.0 * margin
        roots = np.unique(fields.pair_root[_runs(fields.cell_pairs, cells)])
        corners = fields.node_vertices if mesh.refines else mesh.base_faces
        out = np.empty(4096, np.int32)
        while (n := leaves_in_box(fields, roots, corners, low, high, out)) < 0:
            out = np.empty(2 * len(out), np.int32)
        return corners[out[:n]]


def graph_of_triangles(points: AnyArray, faces: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Return `runs`, `links` and `weights` of a triangle mesh: points (N, 3), faces (F, 3) int32.

    See `link_triangles`. Cost: about .3 us a triangle.
    """
    runs = np.empty(len(points) + 1, np.int64)
    links, weights = np.empty(6 * len(faces), np.int32), np.empty(6 * len(faces))
    n = link_triangles(points, faces, runs, links, weights)
    return runs, links[:n], weights[:n]


def with_room(array: AnyArray, n: int) -> AnyArray:
    """Return the array, or a copy padded with zeros that is at least `n` long."""
    if len(array) >= n:
        return array
    longer = np.zeros((max(n, 2 * len(array)), *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer


def _runs(starts: AnyArray, chosen: AnyArray) -> AnyArray:
    """Return all indices in the chosen runs (K,) of `starts` (N + 1,), run after run."""
    first = starts[chosen].astype(np.int64)
    return _from_runs(first, starts[chosen + 1].astype(np.int64) - first)


def _from_runs(first: AnyArray, counts: AnyArray) -> AnyArray:
    """Return all indices in runs that begin at `first` (K,) int64, `counts` (K,) int64 long."""
    return np.repeat(first - np.cumsum(counts) + counts, counts) + np.arange(int(counts.sum()))
