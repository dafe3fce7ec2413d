"""Per-vertex ink on a mesh: wet amounts, dried paint, and the colours of both.

Water (`surface.flow`) and layers (`surface.layer_stack`) build on this, which knows neither.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.dry_contact import bundle_noise, contact_noise
from paint3d.brush_engine.ink_transfer import TRANSFER, InkField
from paint3d.colour.glazing import GlazeModel, make_ground
from paint3d.colour.kernels.glazing import Ground, add_between
from paint3d.colour.materials import Material
from paint3d.colour.pigments import WATER, Pigment, load_drawdown_paints, load_palette
from paint3d.colour.spectra import decode_srgb, srgb_from_reflectance
from paint3d.colour.vertex_colours import ColourModel
from paint3d.core.arrays import AnyArray, grown
from paint3d.errors import InputError
from paint3d.mesh.likeness import Original, build_like
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.dry_layers import DryLayers
from paint3d.surface.flow_graph import FlowGraph
from paint3d.surface.granulation import COARSE_UM, granulated

__all__ = ["InkStore", "union"]

_NO_RGB = np.empty((0, 3), np.float32)


class InkStore:
    """One layer of ink on a mesh, wet over dry, and what it looks like.

    Parameters
    ----------
    mesh : TriangleMesh
        mm.
    resolution : float or None
        Longest edge wanted where there is paint, mm; None keeps the mesh's own vertices.
    material : Material
        What the surface is made of: its reflectance is the ground of every colour.
    original : Original, optional
        The mesh that was painted on before remeshing: a brush moves as it did on that one.

    Attributes
    ----------
    paint_mesh : PaintMesh
        The mesh, refined as paint arrives; rows of all arrays are its vertices.
    original : Original or None
        None where it makes no difference (see `build_like`).
    pigments : list of Pigment
        Columns of the ink's arrays.
    ink : InkField
    dry_layers : DryLayers
    looks_otherwise : bool
        Whether a pigment was added since colours were last brought up to date.
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        resolution: float | None,
        material: Material,
        original: Original | None = None,
    ) -> None:
        self.source = mesh
        self.resolution = resolution
        self.material = material
        alike = None if original is None else build_like(mesh, resolution, original)
        self.original = None if alike is None else original
        self.paint_mesh = PaintMesh.build(mesh, resolution) if alike is None else alike
        self.paint_mesh.lay_paper(math.sqrt(2.0 * material.grain))
        self.pigments: list[Pigment] = []
        self.dry_layers = DryLayers()
        self._colours: ColourModel | None = None
        self._glaze: GlazeModel | None = None
        self.looks_otherwise = False
        self._ground = make_ground(self.material.reflectance)
        self._bare = srgb_from_reflectance(self.material.reflectance)
        self._mesh_colours: _MeshColours | None = None
        self._allocate(0)
        if mesh.colours is not None:
            own = mesh.colours[self.paint_mesh.source_vertices]
            self._srgb[: len(own)] = own
            self._mesh_colours = _MeshColours(own)
            self._mesh_colours.fit(self.paint_mesh.capacity)

    def _allocate(self, n_pigments: int) -> None:
        capacity = self.paint_mesh.capacity
        self._srgb = np.empty((capacity, 3), dtype=np.uint8)
        self._srgb[:] = self._bare
        self.ink = InkField(
            amounts=np.zeros((capacity, n_pigments), np.float32),
            coverage=np.zeros(capacity, np.float32),
            dirty=np.zeros(capacity, np.uint8),
            dirty_ids=np.zeros(capacity + 1, np.int32),
            n_dirty=np.zeros(1, np.int64),
            load=np.zeros(n_pigments),
            off_surface=np.zeros(n_pigments),
            reservoirs=np.zeros((1, n_pigments)),
            transfer=np.array(
                [(0.0, self.material.grain, 0.0, self.material.tooth_mm, 1.0, -1.0)], TRANSFER
            ),
            noise=contact_noise(),
            bundles=bundle_noise(),
        )

    @cached_property
    def flow_graph(self) -> FlowGraph:
        """The graph on which liquids move over the shape, built where any has come."""
        return FlowGraph(self.paint_mesh, self.make_room)

    def open_blocks(self) -> NDArray[np.int32]:
        """Return the open blocks (K,) int32 of `flow_graph`."""
        if "flow_graph" not in vars(self):
            return np.zeros(0, np.int32)
        return self.flow_graph.opened.astype(np.int32)

    def recall_blocks(self, blocks: AnyArray) -> None:
        """Mark blocks (K,) of `flow_graph` as having been open on saving."""
        if len(blocks):
            self.flow_graph.was_open[blocks] = True

    def make_room(self, extra: int | None = None) -> None:
        """Reserve capacity for `extra` vertices (None: as `PaintMesh.reserve` sees fit)."""
        self.paint_mesh.reserve(extra)
        self._fit()

    def grow_ahead(self) -> None:
        """Reserve capacity before it runs out: this takes .2 s with a million vertices."""
        mesh = self.paint_mesh
        added = mesh.n_vertices - mesh.n_base_vertices
        if mesh.refines and mesh.capacity - mesh.n_vertices < added // 4:
            self.make_room(added)

    def refine_all(self, progress: Callable[[float], None] | None = None) -> None:
        """Refine the whole surface now instead of where paint arrives; nothing painted changes.

        If `progress` (see `PaintMesh.refine_all`) raises, everything stays as it was.
        """
        try:
            self.paint_mesh.refine_all(progress)
        finally:
            self._fit()

    def _fit(self) -> None:
        """Grow the per-vertex arrays to the mesh's capacity."""
        old, old_srgb = self.ink, self._srgb
        n = len(old_srgb)
        if n == self.paint_mesh.capacity:
            return
        self._allocate(old.amounts.shape[1])
        self._srgb[:n] = old_srgb
        new = self.ink
        for name in ("amounts", "coverage", "dirty"):
            getattr(new, name)[:n] = getattr(old, name)
        count = int(old.n_dirty[0])
        new.dirty_ids[:count] = old.dirty_ids[:count]
        for name in ("n_dirty", "load", "off_surface"):
            getattr(new, name)[:] = getattr(old, name)
        self.ink = new._replace(reservoirs=old.reservoirs, transfer=old.transfer)
        self.dry_layers.fit(self.paint_mesh.capacity, len(self.pigments))
        if self._mesh_colours is not None:
            self._mesh_colours.fit(self.paint_mesh.capacity)

    def column_of(self, pigment: Pigment) -> int:
        """Return the column of a pigment in the ink's arrays; a new one is added at the end.

        A built-in pigment matches by name: a painting keeps the inks that it was begun with even
        when a later version has measured them anew.

        Raises
        ------
        InputError
            If a different ink of that name is on the surface already.
        """
        for column, known in enumerate(self.pigments):
            if known.name == pigment.name:
                if not known.is_like(pigment) and not _is_built_in(pigment):
                    raise InputError(
                        "there is another ink named {pigment!r} on this surface; expected its K, "
                        "S, gloss, fine share and grains or another name",
                        pigment=pigment.name,
                    )
                return column
        self.pigments.append(pigment)
        old = self.ink
        count = len(self.pigments)
        amounts = np.zeros((old.amounts.shape[0], count), np.float32)
        amounts[:, :-1] = old.amounts
        self.ink = old._replace(
            amounts=amounts,
            load=np.append(old.load, 0.0),
            off_surface=np.append(old.off_surface, 0.0),
            reservoirs=np.pad(old.reservoirs, ((0, 0), (0, 1))),
        )
        if pigment is WATER:
            self.ink.transfer["water"] = count - 1
        self.dry_layers.fit(self.paint_mesh.capacity, count)
        self._colours = ColourModel(self.pigments, self.material.reflectance, path="live")
        self._glaze = GlazeModel(self.pigments)
        self.looks_otherwise = count > 1
        return count - 1

    def know_vertices(self) -> None:
        """Interpolate the mesh's own colours at vertices that were added since the last call."""
        if self._mesh_colours is not None:
            mesh = self.paint_mesh
            self._mesh_colours.know(mesh.arrays.parents, mesh.n_vertices, self._srgb)

    def colour_as_one(self, ids: AnyArray) -> None:
        """Bring the colours of vertices (N,) int32 up to date, as if this were the only layer.

        At least one pigment must be known.
        """
        ink = self.ink
        columns = [c for c, p in enumerate(self.pigments) if p.grain_um >= COARSE_UM]
        if columns:
            coarse = ink.amounts[ids[:, None], columns].any(axis=1)
            self._colour_coarse(ids[coarse])
            ids = ids[~coarse]
        if self._mesh_colours is not None:
            plain, own = ids[:0], ids
        elif self.dry_layers.count:
            dried = self.dry_layers.has_row(ids)
            plain, own = ids[~dried], ids[dried]
        else:
            plain, own = ids, ids[:0]
        if len(plain):
            assert self._colours is not None, "no pigment is known"
            self._colours.srgb(ink.amounts, ink.coverage, self._srgb, plain)
        if len(own):
            assert self._glaze is not None, "no pigment is known"
            self._glaze.srgb(ink.amounts, ink.coverage, self.ground(), self._srgb, own)

    def _colour_coarse(self, ids: AnyArray) -> None:
        """Bring the colours of vertices (N,) with coarse pigment up to date."""
        assert self._glaze is not None, "no pigment is known"
        every, codes = np.arange(len(ids), dtype=np.int32), np.empty((len(ids), 3), np.uint8)
        coverage = self.ink.coverage[ids]
        seen = self.seen_amounts(ids, self.ink.amounts[ids], coverage)
        self._glaze.srgb(seen, coverage, _ground_at(self.ground(), ids), codes, every)
        self._srgb[ids] = codes

    def seen_amounts(
        self, ids: AnyArray, amounts: NDArray[np.float32], coverage: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """Return the amounts (N, P) that vertices (N,) with such ink show: see `granulation`."""
        grains = np.array([pigment.grain_um for pigment in self.pigments])
        if grains.max(initial=0.0) < COARSE_UM:
            return amounts
        arrays = self.paint_mesh.arrays
        points = np.column_stack([arrays.px[ids], arrays.py[ids], arrays.pz[ids]])
        return granulated(
            amounts, coverage, points.astype(np.float64), grains, self.paint_mesh.resolution
        )

    def bare_spectra(self, vertex_ids: AnyArray) -> NDArray[np.uint16]:
        """Return the reflectance (N, 31) uint16 of unpainted vertices, in steps of 1/65535."""
        if self._mesh_colours is None:
            return np.tile(_in_steps(self._ground.material), (len(vertex_ids), 1))
        self.know_vertices()
        ground = self._mesh_colours.ground_of(self._ground)
        return _in_steps(ground.linear_rgb[vertex_ids] @ ground.primaries.T)

    def spectra_as_one(self, vertex_ids: AnyArray) -> NDArray[np.uint16]:
        """Return the reflectance (N, 31) uint16 of distinct vertices, as if on the only layer."""
        spectra = self.bare_spectra(vertex_ids)
        rows = self.dry_layers.rows_of(vertex_ids)
        spectra[rows >= 0] = self.dry_layers.spectra[rows[rows >= 0]]
        wet = np.flatnonzero(self.ink.coverage[vertex_ids] > 0.0).astype(np.int32)
        if len(wet) and self._glaze is not None:
            below = self._ground._replace(slots=wet, spectra=spectra, linear_rgb=_NO_RGB)
            ids = vertex_ids[wet]
            every = np.arange(len(wet), dtype=np.int32)
            coverage = self.ink.coverage[ids]
            seen = self.seen_amounts(ids, self.ink.amounts[ids], coverage)
            self._glaze.dry(seen, coverage, below, every, wet)
        return spectra

    @property
    def glaze(self) -> GlazeModel | None:
        """The glazing model of the known pigments; None before the first."""
        return self._glaze

    def ground(self) -> Ground:
        """Return the ground below the wet paint: dried paint, the mesh's own colours, material."""
        ground = self._ground
        if self._mesh_colours is not None:
            ground = self._mesh_colours.ground_of(ground)
        return self.dry_layers.ground_under(ground)

    def settle(self, vertex_ids: AnyArray) -> None:
        """Dry the wet paint of some vertices (N,) int32."""
        ink = self.ink
        if not len(vertex_ids) or self._glaze is None:
            return
        self.know_vertices()
        rows = self.dry_layers.reserve_rows(vertex_ids, self.paint_mesh.capacity)
        ground = self.ground()
        grounds = [ground]
        if self.dry_layers.has_filters:
            grounds += self.dry_layers.grey_grounds(ground)
        every, coverage = np.arange(len(vertex_ids), dtype=np.int32), ink.coverage[vertex_ids]
        seen = self.seen_amounts(vertex_ids, ink.amounts[vertex_ids], coverage)
        for below in grounds:
            self._glaze.dry(seen, coverage, _ground_at(below, vertex_ids), every, rows)
        amounts = ink.amounts[vertex_ids] * self._lasting
        self.dry_layers.settle(vertex_ids, rows, amounts, coverage)
        ink.amounts[vertex_ids] = 0.0
        ink.coverage[vertex_ids] = 0.0
        self.touch(vertex_ids)

    def touch(self, vertex_ids: AnyArray) -> None:
        """Mark the colours of some vertices (N,) as out of date."""
        ink = self.ink
        fresh = vertex_ids[ink.dirty[vertex_ids] == 0]
        count = int(ink.n_dirty[0])
        ink.dirty_ids[count : count + len(fresh)] = fresh
        ink.dirty[fresh] = 1
        ink.n_dirty[0] = count + len(fresh)

    @property
    def _lasting(self) -> NDArray[np.float32]:
        """(P,) float32: 1 for a pigment, 0 for water, which is not part of the ink balance."""
        return np.array([p is not WATER for p in self.pigments], np.float32)

    @property
    def n_vertices(self) -> int:
        """Number of vertices at present, V."""
        return self.paint_mesh.n_vertices

    @property
    def codes(self) -> NDArray[np.uint8]:
        """(cap, 3) uint8 sRGB as of the last `refresh`; rows of vertices to come are bare."""
        return self._srgb

    @property
    def bare_codes(self) -> NDArray[np.uint8]:
        """(V, 3) uint8 sRGB of every vertex as if nothing had been painted."""
        return self.bare_codes_at(np.arange(self.n_vertices))

    def bare_codes_at(self, vertex_ids: AnyArray) -> NDArray[np.uint8]:
        """Return the sRGB (N, 3) of vertices as if nothing had been painted."""
        if self._mesh_colours is None:
            return np.tile(self._bare, (len(vertex_ids), 1))
        self.know_vertices()
        return self._mesh_colours.codes(vertex_ids)

    @property
    def coverage(self) -> NDArray[np.float32]:
        """(V,) float32: fraction of each vertex's own area that is under wet paint, 0 to 1."""
        return self.ink.coverage[: self.n_vertices]

    @property
    def amounts(self) -> NDArray[np.float32]:
        """(V, P) float32: wet ink at each vertex, full coats times the covered fraction."""
        return self.ink.amounts[: self.n_vertices]

    @property
    def vertex_areas(self) -> NDArray[np.float64]:
        """(V,) float64: the surface area that each vertex stands for, mm2."""
        return self.paint_mesh.vertex_areas

    def main_pigment(self, parts: AnyArray) -> Pigment:
        """Return the main pigment of a mixture (P,); water only where there is nothing else."""
        inked = parts * self._lasting
        return self.pigments[int(np.argmax(inked if inked.any() else parts))]

    def lasting(self, per_pigment: AnyArray) -> float:
        """Return the sum of a quantity (P,) over the pigments, without water."""
        return float(per_pigment @ self._lasting)


def _in_steps(reflectance: AnyArray) -> AnyArray:
    """Quantise reflectance to uint16, in steps of 1/65535."""
    return (np.clip(reflectance, 0.0, 1.0) * 65535.0 + 0.5).astype(np.uint16)


def _ground_at(ground: Ground, ids: AnyArray) -> Ground:
    """Return the ground of vertices (N,), which are numbered 0 to N - 1 in it."""
    return ground._replace(
        slots=ground.slots[ids] if len(ground.slots) else ground.slots,
        linear_rgb=ground.linear_rgb[ids] if len(ground.linear_rgb) else ground.linear_rgb,
    )


def _is_built_in(pigment: Pigment) -> bool:
    """Return whether a pigment is one of the program's own."""
    tables = load_palette(), load_drawdown_paints()
    return any(table.get(pigment.name) is pigment for table in tables)


class _MeshColours:
    """sRGB of every vertex of a refined mesh before anything was painted.

    A vertex that bisects an edge has the mean of its ends' codes, as a viewer that interpolates
    codes shows it, so that refinement is invisible and export can undo it.

    Parameters
    ----------
    srgb : (B, 3) uint8
        Colours of the base vertices.
    """

    def __init__(self, srgb: NDArray[np.uint8]) -> None:
        self._known = len(srgb)
        self._encoded = (srgb / 255.0).astype(np.float32)
        self._linear = decode_srgb(srgb).astype(np.float32)

    def fit(self, capacity: int) -> None:
        """Grow to a capacity in vertices."""
        if len(self._encoded) < capacity:
            self._encoded = grown(self._encoded, self._known, capacity)
            self._linear = grown(self._linear, self._known, capacity)

    def know(self, parents: AnyArray, n_vertices: int, srgb: AnyArray) -> None:
        """Interpolate colours at vertices added since, and write their codes to `srgb` (cap, 3)."""
        first, last = self._known, n_vertices
        if first == last:
            return
        add_between(parents, first, last, self._encoded)
        fresh = self._encoded[first:last]
        self._linear[first:last] = decode_srgb(fresh.astype(np.float64))
        srgb[first:last] = np.rint(fresh * 255.0)
        self._known = last

    def codes(self, vertex_ids: AnyArray) -> NDArray[np.uint8]:
        """Return the codes (N, 3) uint8 of vertices, which must be known."""
        codes: NDArray[np.uint8] = np.rint(self._encoded[vertex_ids] * 255.0).astype(np.uint8)
        return codes

    def ground_of(self, ground: Ground) -> Ground:
        """Return the ground with these colours in place of the material's."""
        return ground._replace(linear_rgb=self._linear)


_FEW = 64  # below one vertex in so many, sorting costs less than marking all


def union(sets: Iterable[AnyArray], capacity: int) -> NDArray[np.int32]:
    """Return the union (N,) int32, ascending, of arrays of vertex ids, all below `capacity`."""
    ids = np.concatenate([np.empty(0, np.int32), *sets]).astype(np.int32, copy=False)
    if len(ids) * _FEW < capacity:
        return np.unique(ids)
    seen = np.zeros(capacity, bool)
    seen[ids] = True
    return np.flatnonzero(seen).astype(np.int32)
