"""A mesh to paint on: vertices are added where the paint is, the surface never changes.

Colours are stored at vertices, so a coarse object needs more of them, but only under the paint.
`PaintMesh` keeps, in flat arrays, the base triangles as roots of a bisection forest
(`mesh.kernels.refine`) and the lattice of cells in which they are refined and found.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, grown
from paint3d.errors import MeshError
from paint3d.mesh.base_surface import BaseSurface, make_base_surface
from paint3d.mesh.kernels.cell_components import (
    fill_pairs,
    gather_links,
    link_sheets,
    locate_vertices,
    measure_sheets,
    split_sheets,
)
from paint3d.mesh.kernels.mesh_arrays import BLOCK_VERTICES, Cells, SurfaceField, build_table
from paint3d.mesh.kernels.paper import MOST_ASIDE_MM, lay_paper
from paint3d.mesh.kernels.refine import (
    BAD_LOG,
    MOST_AROUND_EDGE,
    NO_ROOM,
    activate_cell,
    longest_edges,
    repeat_splits,
    spread_areas,
)
from paint3d.mesh.kernels.topology import link_cracks
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["PaintMesh", "refinement_log", "repeat_refinement", "saved_ids"]

_REFINED_CELL = 5.0  # edges across a cell: cells are refined as a whole
_PLAIN_CELL = 12.0  # without refinement fewer, larger cells are faster
_MOST_CELLS = 4e6  # a gigabyte; larger objects have larger cells, up to:
_COARSEST_CELL = 256.0  # edges: refining one takes a second and 20 MB
_SOFT_EDGE_PER_EDGE = 0.6  # mean vertex spacing over the longest edge, nearly
_BLOCK_STEPS = 16  # along a cell, to sort its vertices by
_LATTICE = 1 << 20  # cells along an axis that Morton codes can hold
_AREA_BITS = 61
_STEPS_PER_EDGE = 8  # float32 steps that a shortest edge must span
_PATH = 1 << 16
_CELLS_A_STEP = 256  # refined between two reports of progress
_MOST_PAIRS = 2**26  # of cells and the triangles in them: a gigabyte
_PAIRS_PER_FACE, _PAIRS_PER_CELL, _LINKS_PER_PAIR = 4, 2.0, 5  # capacity, nearly always enough
_CRACK_MM = 0.1  # widest gap that paint goes over: no hair fits in
_PER_VERTEX = (
    "px", "py", "pz", "nx", "ny", "nz", "mx", "my", "mz", "take", "key", "parents",
    "vertex_sheet", "area_units", "area", "next_in_cell",
)  # fmt: skip
_GROWTH = 1 << 15  # least number of vertices to reserve


class PaintMesh:
    """The lazily refined vertex store; build it with `PaintMesh.build`.

    Attributes
    ----------
    arrays : SurfaceField
        The arrays of the kernels. Replaced, not changed, when they grow.
    base_faces : (R, 3) int32
        The roots: the triangles of the source that have an area, on this mesh's own vertices.
    source_vertices : (B,) int32
        The source's vertex for each base vertex; a vertex on a crease has several.
    """

    @classmethod
    def build(cls, mesh: TriangleMesh, resolution: float | None) -> PaintMesh:
        """Index a mesh and prepare it for refinement to edges of at most `resolution` mm.

        With None the mesh keeps its own vertices. Cost: about 2 us a triangle.

        Raises
        ------
        MeshError
            If more triangles share one edge than can be refined, the object is too large for the
            resolution (some 130,000 edges along either side of a square), or it lies so far from
            the origin that float32 coordinates are coarser than the resolution.

        Notes
        -----
        Refinement goes cell by cell, where paint is. A cell is 5 edges long, longer where the
        surface would have more than some millions of them: memory and time grow with the painted
        area, and with the object's only up to a gigabyte and some ten seconds.
        """
        return cls(make_base_surface(mesh), resolution)

    def __init__(
        self,
        base: BaseSurface,
        resolution: float | None,
        cells: tuple[AnyArray, float] | None = None,
    ) -> None:
        edges = base.longest_edges()
        self.resolution = float(resolution) if resolution is not None else float(np.median(edges))
        self.refines = resolution is not None and bool(edges.max() > self.resolution)
        if self.refines:
            _check_precision(base.points, self.resolution)
        size = self._cell_size(float(base.areas.sum()))
        order, lattice = _Lattice.build(base, *(cells or (None, size)))
        self.source_vertices = base.source_vertices[order]
        rank = np.empty(len(order), np.int32)
        rank[order] = np.arange(len(order), dtype=np.int32)
        self.base_faces = rank[base.faces]
        self.n_base_vertices = len(order)
        self._lattice = lattice
        self._make_arrays(base, order, edges)

    def _cell_size(self, area: float) -> float:
        """Return the size of cells, mm, for a surface of `area` mm2.

        Raises
        ------
        MeshError
            If they would be too large to be refined as a whole.
        """
        edges_per_cell = _REFINED_CELL if self.refines else _PLAIN_CELL
        least = math.sqrt(_PAIRS_PER_CELL * area / _MOST_CELLS)
        if self.refines and least > _COARSEST_CELL * self.resolution:
            raise MeshError(
                "the object's surface of {area:.3g} m2 is too large for vertices every "
                "{resolution:g} mm; expected another unit if it is not so large, or at least "
                "{least:.2g} mm",
                hint="--unit, --resolution",
                area=1e-6 * area, resolution=self.resolution, least=least / _COARSEST_CELL,
            )  # fmt: skip
        return max(edges_per_cell * self.resolution, least)

    def _make_arrays(self, base: BaseSurface, order: AnyArray, edges: AnyArray) -> None:
        n, roots = self.n_base_vertices, len(self.base_faces)
        points, normals = base.points[order], base.normals[order]
        shift = 2 * max(0, int(np.ceil(np.log2(float(edges.max()) / self.resolution)))) + 6
        shift = shift if self.refines else 0
        # the sum over the whole surface fits in int64, so that of any vertex does
        unit = float(base.areas.sum()) / 2.0 ** (_AREA_BITS - shift)
        node_area = np.maximum(np.rint(base.areas / unit), 1.0).astype(np.int64) << shift
        area_units = np.zeros(n, np.int64)
        axes = [np.ascontiguousarray(points[:, axis]) for axis in range(3)]
        spread_areas(*axes, self.base_faces, node_area, area_units)
        areas: AnyArray = area_units * (unit / 2.0**shift)
        forest = roots if self.refines else 0
        lattice = self._lattice
        self.arrays = SurfaceField(
            counts=np.array([n, forest], np.int64),
            resolution=float(self.resolution),
            cell_size=float(lattice.size),
            soft_edge=float(_SOFT_EDGE_PER_EDGE * self.resolution),
            area_unit=float(unit / 2.0**shift),
            area_step=_step_of(areas),
            **{f"p{a}": axes[i] for i, a in enumerate("xyz")},
            **{f"n{a}": np.ascontiguousarray(normals[:, i]) for i, a in enumerate("xyz")},
            **{f"m{a}": np.ascontiguousarray(points[:, i]) for i, a in enumerate("xyz")},
            take=np.ones(n, np.float32),
            paper=0.0,
            key=_position_keys(points),
            parents=np.full((n, 2), -1, np.int32),
            vertex_sheet=lattice.vertex_sheets,
            area_units=area_units,
            area=areas.astype(np.float32),
            next_in_cell=np.full(n, -1, np.int32),
            node_vertices=self.base_faces[:forest].copy(),
            node_root=np.arange(forest, dtype=np.int32),
            child=np.full(forest, -1, np.int32),
            longest=np.zeros(forest, np.int8),
            radial=base.radial[: 3 * forest].copy(),
            node_area=node_area[:forest].copy(),
            head=np.full(lattice.n_cells, -1, np.int32),
            done=np.full(lattice.n_cells, 0 if self.refines else 1, np.uint8),
            path=np.empty(_PATH, np.int32),
            **lattice.arrays,
        )
        if self.refines:
            longest_edges(self.arrays, self.arrays.longest)
            self.reserve()

    def lay_paper(self, amount: float) -> None:
        """Make edge and film of the ink uneven, as fibres do (`mesh.kernels.paper`).

        Parameters
        ----------
        amount : float
            0 for a glaze, 1 for raw xuan. To be called before anything is refined.
        """
        balls = self.arrays.block_balls.copy()
        balls[3] += np.float32(MOST_ASIDE_MM * amount)
        self.arrays = self.arrays._replace(paper=float(amount), block_balls=balls)
        lay_paper(self.arrays, 0, self.n_base_vertices)

    # -- refinement -------------------------------------------------------------------------

    def reserve(self, extra: int | None = None) -> None:
        """Reserve space for `extra` more vertices (None: about half as many again)."""
        field = self.arrays
        n, nodes = (int(x) for x in field.counts)
        if extra is None:
            extra = max(_GROWTH, (n - self.n_base_vertices) // 2)
        vertices = n + extra + MOST_AROUND_EDGE
        # a vertex on an edge halves two triangles: four nodes
        capacity = nodes + 4 * extra + 4 * MOST_AROUND_EDGE
        larger: dict[str, Any]
        larger = {name: grown(getattr(field, name), n, vertices) for name in _PER_VERTEX}
        for name in ("node_vertices", "node_root", "child", "longest", "node_area"):
            larger[name] = grown(getattr(field, name), nodes, capacity)
        larger["radial"] = grown(field.radial, 3 * nodes, 3 * capacity)
        self.arrays = field._replace(**larger)

    def refine_all(self, progress: Callable[[float], None] | None = None) -> None:
        """Refine every cell; lazy refinement gives the same wherever it has been.

        Parameters
        ----------
        progress : callable, optional
            Called with the fraction done, now and then, and at last with 1; what it raises aborts
            between two cells, and leaves the mesh as it was.
        """
        before = None
        if progress is not None:
            before = copy.deepcopy(self.arrays)
        try:
            for cell in range(self.n_cells):
                while activate_cell(self.arrays, cell) < 0:
                    self.reserve()
                if progress is not None and cell % _CELLS_A_STEP == 0:
                    progress(cell / self.n_cells)
            if progress is not None:
                progress(1.0)
        except BaseException:
            if before is not None:
                self.arrays = before
            raise

    # -- counts and arrays ------------------------------------------------------------------

    @property
    def n_vertices(self) -> int:
        """Current number of vertices, V."""
        return int(self.arrays.counts[0])

    @property
    def capacity(self) -> int:
        """Number of vertices for which space is reserved."""
        return len(self.arrays.px)

    @property
    def n_cells(self) -> int:
        """Number of cells that the surface meets."""
        return len(self.arrays.head)

    @property
    def n_blocks(self) -> int:
        """Number of blocks of neighbouring base vertices."""
        return len(self.arrays.block_balls[0])

    @property
    def n_sheets(self) -> int:
        """Number of connected pieces of surface, counted in each cell."""
        return len(self.arrays.sheet_cell)

    @property
    def vertices(self) -> NDArray[np.float32]:
        """(V, 3) float32 positions, mm: base vertices in the order of their cells, then added."""
        n = self.n_vertices
        return np.stack([getattr(self.arrays, a)[:n] for a in ("px", "py", "pz")], axis=1)

    @property
    def normals(self) -> NDArray[np.float32]:
        """(V, 3) float32 unit normals."""
        n = self.n_vertices
        return np.stack([getattr(self.arrays, a)[:n] for a in ("nx", "ny", "nz")], axis=1)

    @property
    def vertex_areas(self) -> NDArray[np.float64]:
        """(V,) float64, mm2: a third of the triangles around each vertex."""
        return self.arrays.area_units[: self.n_vertices] * self.arrays.area_unit

    def leaf_faces(self) -> NDArray[np.int32]:
        """Return the current triangles (F, 3) int32."""
        if not self.refines:
            return self.base_faces
        nodes = int(self.arrays.counts[1])
        return self.arrays.node_vertices[:nodes][self.arrays.child[:nodes] < 0]

    def leaf_roots(self) -> NDArray[np.int32]:
        """Return for each of the `leaf_faces` the base face that it lies in, (F,) int32."""
        if not self.refines:
            return np.arange(len(self.base_faces), dtype=np.int32)
        nodes = int(self.arrays.counts[1])
        return self.arrays.node_root[:nodes][self.arrays.child[:nodes] < 0]

    def source_order(self) -> NDArray[np.int32]:
        """Return ids (V,) int32: base vertices in the source's order, then added ones by age."""
        base = np.argsort(self.source_vertices, kind="stable").astype(np.int32)
        return np.concatenate(
            [base, np.arange(self.n_base_vertices, self.n_vertices, dtype=np.int32)]
        )


def _check_precision(points: AnyArray, resolution: float) -> None:
    farthest = float(np.abs(points).max())
    step = float(np.spacing(np.float32(farthest)))
    if _STEPS_PER_EDGE * step > resolution:
        span = float(np.ptp(points, axis=0).max())
        hint, numbers = "--unit, --resolution", {"step": step, "resolution": resolution}
        numbers["least"] = _STEPS_PER_EDGE * step
        if _STEPS_PER_EDGE * float(np.spacing(np.float32(0.5 * span))) <= resolution:
            raise MeshError(
                "a coordinate is {farthest:g} mm, where float32 has steps of {step:g} mm, too "
                "coarse for vertices every {resolution:g} mm; expected another unit if it is not "
                "so far, at least {least:.2g} mm, or the object moved to the origin",
                hint=hint, farthest=farthest, **numbers,
            )  # fmt: skip
        raise MeshError(
            "the object is {span:g} mm long, where float32 has steps of {step:g} mm, too coarse "
            "for vertices every {resolution:g} mm; expected another unit if it is not so long, or "
            "at least {least:.2g} mm",
            hint=hint, span=span, **numbers,
        )  # fmt: skip


def _step_of(areas: AnyArray) -> float:
    """The step (mm2, a power of two) in which weighed areas are summed; `areas` before any is cut.

    So fine that 2^51 of them hold the largest 256 times over, and 2^62 the whole 32 times.
    """
    least = max(float(areas.max()) * 2.0**-43, float(areas.sum()) * 2.0**-57)
    return float(2.0 ** math.ceil(math.log2(least)))


def _position_keys(points: AnyArray) -> AnyArray:
    """Hash positions (B, 3) to uint64 keys, so that both sides of a seam have the same."""
    bits = (np.ascontiguousarray(points) + np.float32(0.0)).view(np.uint32).astype(np.uint64)
    with np.errstate(over="ignore"):
        key = bits[:, 0] * np.uint64(0x9E3779B97F4A7C15)
        key ^= bits[:, 1] * np.uint64(0xC2B2AE3D27D4EB4F) + np.uint64(1)
        key ^= (bits[:, 2] * np.uint64(0x165667B19E3779F9) + np.uint64(7)) << np.uint64(1)
        key ^= key >> np.uint64(29)
        key *= np.uint64(0xBF58476D1CE4E5B9)
    return key ^ (key >> np.uint64(32))


class _Lattice:
    """Cells, sheets and their links, as arrays for `SurfaceField`."""

    def __init__(self, size: float, arrays: dict[str, AnyArray], vertex_sheets: AnyArray) -> None:
        self.size = size
        self.arrays = arrays
        self.vertex_sheets = vertex_sheets
        self.n_cells = len(arrays["cell_place"])

    @classmethod
    def build(
        cls, base: BaseSurface, origin: AnyArray | None, size: float
    ) -> tuple[AnyArray, _Lattice]:
        """Return the base vertices' new order (cell by cell) and the lattice.

        `origin` (3,) is that of an existing lattice to align with; None places it freely.
        """
        low = base.points.min(axis=0).astype(np.float64)
        span = float((base.points.max(axis=0) - low).max())
        if span / size > _LATTICE - 4:
            raise MeshError(
                "the object is {span:g} mm long; expected at most {most:g} mm at this resolution",
                span=span, most=_LATTICE * size,
            )  # fmt: skip
        if origin is None:
            # an irrational offset, so that faces at round coordinates do not lie between two cells
            origin = low - 0.6180339887 * size
        else:  # moved by whole cells so that no cell has a negative number
            origin = origin - size * np.maximum(np.ceil((origin - low) / size), 0.0)
        places, pair_root, cell_pairs = _pairs_by_cell(base, origin, size)
        n_cells = len(places)
        table = np.full(1 << int(np.ceil(np.log2(2 * n_cells + 1))), -1, np.int32)
        build_table(places, table)
        cells = Cells(
            origin=origin,
            cell_size=float(size),
            table=table,
            cell_place=places,
            cell_pairs=cell_pairs,
            pair_root=pair_root,
            pair_sheet=np.empty(len(pair_root), np.int32),
            cell_sheets=np.empty(n_cells + 1, np.int32),
        )
        n_sheets = split_sheets(base.points, base.faces, base.radial, cells)
        area, normal, centre = np.zeros(n_sheets), np.zeros((n_sheets, 3)), np.zeros((n_sheets, 3))
        with ThreadPoolExecutor(1) as beside:  # beside the rest, which takes as long
            measured = beside.submit(
                measure_sheets, base.points, base.normals, base.faces, cells, area, normal, centre
            )
            cracks = _crack_links(base, cells)
            sheet_links, linked = _links(cells, len(base.faces), n_sheets, cracks)
            order, starts, vertex_sheets = _sort_vertices(base, cells)
            measured.result()
        sheet_cell = np.repeat(np.arange(n_cells, dtype=np.int32), np.diff(cells.cell_sheets))
        arrays = {
            **{name: array for name, array in cells._asdict().items() if name != "cell_size"},
            "base_start": starts,
            **_blocks(base.points[order], starts),
            "sheet_cell": sheet_cell,
            "sheet_place": np.column_stack([places[sheet_cell], sheet_cell]).astype(np.int32),
            "sheet_area": area,
            "sheet_normal": normal,
            "sheet_centre": centre,
            "sheet_pack": np.column_stack([normal, area, centre, np.zeros(n_sheets)]).astype(
                np.float32
            ),
            "sheet_links": sheet_links,
            "linked_sheet": linked,
        }
        return order, cls(size, arrays, vertex_sheets)


def _pairs_by_cell(
    base: BaseSurface, origin: AnyArray, size: float
) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Return the cells (C, 3) in Morton order, the roots that meet them, and each cell's run."""
    capacity = int(_PAIRS_PER_FACE * len(base.faces) + _PAIRS_PER_CELL * base.areas.sum() / size**2)
    n = capacity + 1
    while n > capacity:  # counting takes as long as listing: guess, and repeat if too few
        capacity = max(capacity, n)
        if capacity > _MOST_PAIRS:
            raise MeshError(
                "the object's surface of {area:.3g} m2 would take about {n:.2g} cells at this "
                "resolution; expected at most {most:.2g}: a coarser resolution or, if it is not so "
                "large, another unit",
                area=1e-6 * float(base.areas.sum()), n=capacity, most=_MOST_PAIRS,
            )  # fmt: skip
        places, roots = np.empty((capacity, 3), np.int32), np.empty(capacity, np.int32)
        n = fill_pairs(base.points, base.faces, origin, size, places, roots)
    places, roots = places[:n], roots[:n]
    code = _morton(places)
    order = np.argsort(code, kind="stable")
    code, places, roots = code[order], places[order], roots[order]
    first = np.flatnonzero(np.concatenate([[True], code[1:] != code[:-1]]))
    runs = np.append(first, n).astype(np.int64)
    return np.ascontiguousarray(places[first]), roots, runs


def _morton(places: AnyArray) -> AnyArray:
    """Interleave the bits of lattice positions (n, 3) into int64 codes."""
    code = np.zeros(len(places), np.int64)
    for axis in range(3):
        bits = places[:, axis].astype(np.int64)  # 20 bits; the masks put two zeros between them
        for shift, mask in (
            (32, 0x1F00000000FFFF),
            (16, 0x1F0000FF0000FF),
            (8, 0x100F00F00F00F00F),
            (4, 0x10C30C30C30C30C3),
            (2, 0x1249249249249249),
        ):
            bits = (bits | (bits << shift)) & mask
        code |= bits << axis
    return code


def _links(
    cells: Cells, n_roots: int, n_sheets: int, others: AnyArray
) -> tuple[AnyArray, AnyArray]:
    """Return the sheets' graph as runs (S + 1,) and neighbours, each link in both directions.

    `others` (M, 2) are links in addition to those by triangles in two cells.
    """
    n_cells = len(cells.cell_place)
    pair_cell = np.repeat(np.arange(n_cells, dtype=np.int32), np.diff(cells.cell_pairs))
    pair_order = np.argsort(cells.pair_root, kind="stable")
    counts = np.bincount(cells.pair_root, minlength=n_roots)
    root_pairs = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    capacity = _LINKS_PER_PAIR * len(pair_order)
    n = capacity + 1
    while n > capacity:
        capacity = max(capacity, n)
        links = np.empty((capacity, 2), np.int32)
        n = link_sheets(cells, root_pairs, pair_order, pair_cell, links)
    graph: tuple[AnyArray, AnyArray] = gather_links(np.concatenate([links[:n], others]), n_sheets)
    return graph


def _crack_links(base: BaseSurface, cells: Cells) -> NDArray[np.int32]:
    """Return pairs (n, 2) int32 of sheets whose borders are at most `_CRACK_MM` apart."""
    capacity = 0
    links = np.empty((capacity, 2), np.int32)
    if not (base.radial == np.arange(len(base.radial), dtype=np.int32)).any():
        return links
    while True:
        n = link_cracks(base.points, base.faces, base.radial, cells, _CRACK_MM, links)
        if n <= capacity:
            return np.unique(links[:n], axis=0)
        capacity = n
        links = np.empty((capacity, 2), np.int32)


def _sort_vertices(base: BaseSurface, cells: Cells) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Sort base vertices by cell and position in it; return order, cells' runs and sheets."""
    root_of = np.empty(len(base.points), np.int32)
    for corner in range(3):
        root_of[base.faces[:, corner]] = np.arange(len(base.faces), dtype=np.int32)
    found = np.empty(len(base.points), np.int32)
    sheets = np.empty(len(base.points), np.int32)
    locate_vertices(base.points, root_of, cells, found, sheets)
    step = cells.cell_size / _BLOCK_STEPS
    within = ((base.points - cells.origin) / step).astype(np.int64) % _BLOCK_STEPS
    order = np.argsort(found * np.int64(_BLOCK_STEPS**3) + _morton(within), kind="stable")
    starts = np.searchsorted(found[order], np.arange(len(cells.cell_place) + 1)).astype(np.int32)
    return order, starts, sheets[order]


def _blocks(points: AnyArray, starts: AnyArray) -> dict[str, AnyArray]:
    """Cut every cell's run of vertices (B, 3) into blocks, each with a bounding ball."""
    counts = -(-np.diff(starts) // BLOCK_VERTICES)
    cell_blocks = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    at = np.arange(cell_blocks[-1]) - np.repeat(cell_blocks[:-1], counts)
    first = np.repeat(starts[:-1], counts) + at * BLOCK_VERTICES
    if len(first) == 0:
        return {"cell_blocks": cell_blocks, "block_balls": np.zeros((4, 0), np.float32)}
    low = np.minimum.reduceat(points, first).astype(np.float64)
    high = np.maximum.reduceat(points, first).astype(np.float64)
    centre = (0.5 * (low + high)).astype(np.float32)
    sizes = np.diff(np.append(first, len(points)))
    reach = np.linalg.norm(points - np.repeat(centre, sizes, axis=0), axis=1)
    # slightly larger, since rounding must not leave a vertex out
    radius = 1.0001 * np.maximum.reduceat(reach, first)
    balls = np.stack([*centre.T, radius]).astype(np.float32)
    return {"cell_blocks": cell_blocks, "block_balls": balls}


# ---- As a list of bisections ---------------------------------------------------------------------
# A compact form of a refined mesh for files, checked when a stranger's file is read.

_HALVED_AT_ONCE = 1 << 16  # some hundredths of a second
_FIRST_RESERVE = 1 << 18  # for a stranger's log; more as its bisections prove valid


def refinement_log(mesh: PaintMesh) -> NDArray[np.int32]:
    """Return the nodes that were halved (n,), in order.

    Nodes are numbered from the source's triangles on, so a log depends on the source mesh and the
    rules of `mesh.kernels.refine`, but not on the lattice.
    """
    child = mesh.arrays.child[: int(mesh.arrays.counts[1])]
    halved = np.flatnonzero(child >= 0)
    return halved[np.argsort(child[halved], kind="stable")].astype(np.int32)


def repeat_refinement(
    mesh: PaintMesh, log: NDArray[np.int32], progress: Callable[[float], None] | None = None
) -> None:
    """Refine a fresh mesh by a log: the same vertices and triangles, in the same order.

    Parameters
    ----------
    mesh : PaintMesh
    log : (n,) int32
    progress : callable, optional
        Called with the fraction done, now and then; what it raises aborts.

    Raises
    ------
    MeshError
        If the log does not belong to this mesh.
    """
    if len(log) and not mesh.refines:
        raise MeshError("a mesh that is never refined has a refinement log; expected none")
    log, at = np.ascontiguousarray(log, np.int32), np.zeros(1, np.int64)
    if len(log):
        mesh.reserve(min(len(log), _FIRST_RESERVE))
    state = 0
    for end in range(_HALVED_AT_ONCE, len(log) + _HALVED_AT_ONCE, _HALVED_AT_ONCE):
        while (state := repeat_splits(mesh.arrays, log[:end], at)) == NO_ROOM:
            mesh.reserve()
        if state == BAD_LOG:
            break
        if progress is not None:
            progress(min(1.0, end / len(log)))
    if state == BAD_LOG:
        raise MeshError(
            "bisection {number} of the refinement log halves triangle {triangle}, which this mesh "
            "would not halve; expected the log of this mesh",
            number=int(at[0]), triangle=int(log[at[0]]),
        )  # fmt: skip


def saved_ids(mesh: PaintMesh) -> NDArray[np.int32]:
    """Return for each vertex (V,) a number that does not depend on the lattice.

    Base vertices are numbered in the source's order (one on a crease once for each normal), then
    added ones in the order of their creation.
    """
    ids = np.empty(mesh.n_vertices, np.int32)
    ids[mesh.source_order()] = np.arange(mesh.n_vertices, dtype=np.int32)
    return ids
