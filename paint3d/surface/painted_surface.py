"""The one mutable thing: an object with ink on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.ink_field import InkField
from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.colour.glazing import GlazeModel, make_ground
from paint3d.colour.kernels.glazing import Ground
from paint3d.colour.materials import Material, load_material
from paint3d.colour.pigments import WATER, Pigment
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.colour.vertex_colours import ColourModel
from paint3d.core.arrays import as_number
from paint3d.errors import InputError
from paint3d.mesh.bvh import build_contact_tree
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.simplify import coarse_faces
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.dry_layers import DryLayers
from paint3d.surface.flow_graph import FlowGraph
from paint3d.surface.mesh_colours import MeshColours
from paint3d.surface.vertex_sets import union

if TYPE_CHECKING:
    from paint3d.mesh.kernels.bvh import ContactTree
    from paint3d.surface.flow import Flow
    from paint3d.surface.layer_stack import LayerStack

__all__ = ["EXPORT_TOLERANCE", "MOST_NODES_AT_ONCE", "PaintedSurface"]

MOST_NODES_AT_ONCE = 60_000  # of `PaintedSurface.follow_flow`: about 25 ms

EXPORT_TOLERANCE = 1.0  # dE00

_FINEST, _COARSEST = 0.005, 1e6  # mm


class PaintedSurface:
    """A mesh that takes ink.

    Vertices appear where paint comes (to the resolution asked); the shape never changes.

    Parameters
    ----------
    mesh : TriangleMesh
        mm.
    resolution : float or None
        Longest edge wanted where there is paint, mm; None keeps the mesh's own vertices.
    material : str or Material
        What the surface is made of: its reflectance is the ground of every colour.

    Raises
    ------
    MeshError, InputError
        If the mesh is unusable or the resolution is not a length of 0.005 mm to 1 km.

    Attributes
    ----------
    keeps_up : bool
        Whether what moves on it could be followed when `follow_time` was called last.
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        resolution: float | None = 0.4,
        material: str | Material = "porcelain",
    ) -> None:
        if not isinstance(mesh, TriangleMesh):
            raise InputError(f"mesh is {type(mesh).__name__}; expected a TriangleMesh")
        if resolution is not None:
            resolution = as_number(resolution, "resolution (mm)", _FINEST, _COARSEST)
        self.source = mesh
        self.resolution = resolution
        self.material = load_material(material) if isinstance(material, str) else material
        self.paint_mesh = PaintMesh.build(mesh, resolution)
        self.pigments: list[Pigment] = []
        self.dry_layers = DryLayers()
        self.layers: LayerStack | None = None
        self._colours: ColourModel | None = None
        self._glaze: GlazeModel | None = None
        self._ground = make_ground(self.material.reflectance)
        self._bare = srgb_from_reflectance(self.material.reflectance)
        self._mesh_colours: MeshColours | None = None
        self._flow: Flow | None = None
        self._still: Flow | None = None  # one that was dropped: its graph may serve again
        self._fresh: list[NDArray] = []
        self.keeps_up = True
        self._changed: list[NDArray] | None = None
        self._allocate(0)
        if mesh.colours is not None:
            own = mesh.colours[self.paint_mesh.source_vertices]
            self._srgb[: len(own)] = own
            self._mesh_colours = MeshColours(own)
            self._mesh_colours.fit(self.paint_mesh.capacity)

    def _allocate(self, n_pigments: int) -> None:
        capacity = self.paint_mesh.capacity
        self._srgb = np.empty((capacity, 3), dtype=np.uint8)
        self._srgb[:] = self._bare
        self.ink = InkField(
            amounts=np.zeros((capacity, n_pigments), np.float32),
            coverage=np.zeros(capacity, np.float32),
            dirty=np.zeros(capacity, np.uint8),
            dirty_ids=np.zeros(capacity, np.int32),
            n_dirty=np.zeros(1, np.int64),
            load=np.zeros(n_pigments),
            off_surface=np.zeros(n_pigments),
            stations=np.zeros((1, n_pigments)),
            habit=np.array([0.0, self.material.grain, 0.0, 1.0]),
        )

    @cached_property
    def contact_tree(self) -> ContactTree:
        """Where a brush meets the shape; made when first asked for (.2 s for a million faces)."""
        return build_contact_tree(self.paint_mesh)

    @cached_property
    def flow_graph(self) -> FlowGraph:
        """The ways of liquids over the shape, as far as any has come."""
        return FlowGraph(self.paint_mesh, self.make_room)

    def make_room(self, extra: int | None = None) -> None:
        """Let the mesh grow by `extra` vertices (None: as `PaintMesh.reserve` sees fit)."""
        self.paint_mesh.reserve(extra)
        self._fit()

    def make_room_ahead(self) -> None:
        """Let the mesh grow where it soon would have to: it takes .2 s with a million vertices."""
        mesh = self.paint_mesh
        added = mesh.n_vertices - mesh.n_base_vertices
        if mesh.refines and mesh.capacity - mesh.n_vertices < added // 4:
            self.make_room(added)

    def refine_all(self, progress: Callable[[float], None] | None = None) -> None:
        """Refine the whole surface now instead of where paint comes; nothing painted changes.

        What `progress` (see `PaintMesh.refine_all`) raises leaves everything as it was.
        """
        try:
            self.paint_mesh.refine_all(progress)
        finally:
            self._fit()

    def _fit(self) -> None:
        """Give every vertex that the mesh has room for its place in the per-vertex arrays."""
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
        self.ink = new._replace(stations=old.stations, habit=old.habit)
        self.dry_layers.fit(self.paint_mesh.capacity, len(self.pigments))
        if self._mesh_colours is not None:
            self._mesh_colours.fit(self.paint_mesh.capacity)

    def column_of(self, pigment: Pigment) -> int:
        """The column of a pigment in the ink's arrays; a new one is added at the end.

        Raises
        ------
        InputError
            If an ink of that name but with other K or S is on the surface already.
        """
        for column, known in enumerate(self.pigments):
            if known.name == pigment.name:
                if not _same_light(known, pigment):
                    raise InputError(
                        f"there is another ink named {pigment.name!r} on this surface; "
                        "expected its K and S or another name"
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
            stations=np.pad(old.stations, ((0, 0), (0, 1))),
        )
        self.dry_layers.fit(self.paint_mesh.capacity, count)
        self._colours = ColourModel(self.pigments, self.material.reflectance, path="live")
        self._glaze = GlazeModel(self.pigments)
        return count - 1

    def refresh(self) -> NDArray:
        """Bring the colours of all vertices that got ink up to date; return their ids (int32)."""
        self._know_vertices()
        count = int(self.ink.n_dirty[0])
        ids = self.ink.dirty_ids[:count].copy()
        if count and self._colours is not None:
            self._colour(ids)
            if self._flow is not None:
                self._fresh.append(ids)
            if self._changed is not None:
                self._changed.append(ids)
            self.ink.dirty[ids] = 0
            self.ink.n_dirty[0] = 0
        return ids

    def take_changed(self) -> NDArray:
        """(N,) int32 vertices whose ink may have changed since the last call; all at the first.

        Whoever asks once is expected to ask again: what changes is remembered from then on.
        """
        dirty = self.ink.dirty_ids[: int(self.ink.n_dirty[0])]
        if self._changed is None:
            self._changed = []
            return np.flatnonzero(self.ink.amounts.any(axis=1) | (self.ink.coverage > 0.0))
        changed, self._changed = self._changed, []
        return union([*changed, dirty], self.paint_mesh.capacity)

    def _know_vertices(self) -> None:
        """Give vertices that have appeared on a mesh with colours theirs."""
        if self._mesh_colours is not None:
            mesh = self.paint_mesh
            self._mesh_colours.know(mesh.arrays.parents, mesh.n_vertices, self._srgb)

    def _colour(self, ids: NDArray) -> None:
        ink = self.ink
        if self.layers is not None and not self.layers.is_plain:
            self.layers.colour(self._glaze, ids, self._srgb)
            return
        if self._mesh_colours is not None:
            plain, own = ids[:0], ids
        elif self.dry_layers.count:
            dried = self.dry_layers.has_row(ids)
            plain, own = ids[~dried], ids[dried]
        else:
            plain, own = ids, ids[:0]
        if len(plain):
            self._colours.srgb(ink.amounts, ink.coverage, self._srgb, plain)
        if len(own):
            self._glaze.srgb(ink.amounts, ink.coverage, self.ground(), self._srgb, own)

    def use_layers(self) -> LayerStack:
        """Have layers from now on; what is painted is the first. See `surface.layer_stack`."""
        if self.layers is None:
            from paint3d.surface.layer_stack import LayerStack

            self.layers = LayerStack(self)
        return self.layers

    def bare_spectra(self, vertex_ids: NDArray) -> NDArray:
        """(N, 31) uint16 reflectance of vertices without paint, in steps of 1/65535."""
        if self._mesh_colours is None:
            return np.tile(_in_steps(self._ground.material), (len(vertex_ids), 1))
        self._know_vertices()
        ground = self._mesh_colours.ground_of(self._ground)
        return _in_steps(ground.linear_rgb[vertex_ids] @ ground.primaries.T)

    @property
    def glaze(self) -> GlazeModel | None:
        """The light of the pigments that are known; None before the first."""
        return self._glaze

    def ground(self) -> Ground:
        """What lies below the wet paint: dried layers, the mesh's own colours, the material."""
        ground = self._ground
        if self._mesh_colours is not None:
            ground = self._mesh_colours.ground_of(ground)
        return self.dry_layers.ground_under(ground)

    @property
    def flow(self) -> Flow:
        """The water on the surface, from the first time that it is asked for."""
        if self._flow is None:
            from paint3d.surface.flow import Flow

            self._flow, self._still = self._still or Flow(self), None
            self._flow.clear()
            self._fresh = [np.flatnonzero(self.coverage > 0.0).astype(np.int32)]
        return self._flow

    def keep_flow(self) -> dict[str, NDArray] | None:
        """What `restore_flow` takes, or None where no water has ever moved.

        Besides what `Flow.keep` says, fresh (N,) int32: vertices whose ink came since.
        """
        if self._flow is None:
            return None
        fresh = [*self._fresh, self.ink.dirty_ids[: int(self.ink.n_dirty[0])]]
        return {**self._flow.keep(), "fresh": union(fresh, self.paint_mesh.capacity)}

    def restore_flow(self, kept: Mapping[str, NDArray]) -> None:
        """Let the water go on as on the surface that it was kept from."""
        kept, count = dict(kept), len(self.pigments)
        for name in ("pigment", "written"):  # pigments may have come since
            missing = count - kept[name].shape[1]
            kept[name] = np.pad(kept[name], ((0, 0), (0, missing)))
        self.flow.restore(kept)
        self._fresh = [kept["fresh"]]

    def drop_flow(self) -> None:
        """Let there be no water in motion."""
        self._still = self._flow or self._still
        self._flow, self._fresh = None, []

    def diffuse(self, seconds: float, step: float | None = None) -> None:
        """Let time pass: wet ink spreads in what drinks, and dries.

        Parameters
        ----------
        seconds : float
        step : float, optional
            Longest step, s; by default as long as the motion allows.

        Raises
        ------
        InputError
            If a time is not a finite number of at least 0, or the step is 0.
        """
        seconds = as_number(seconds, "seconds", 0.0)
        if step is not None:
            step = as_number(step, "step (s)", 1e-6)
        self.flow.advance(seconds, step, self._take_fresh())

    def follow_time(self, seconds: float) -> bool:
        """Let time pass beside a hand, or, while more moves than can be followed, none.

        Which it is depends on the painting alone. Returns what `keeps_up` is now.
        """
        self.keeps_up = self.follow_flow(seconds if self.keeps_up else 0.0)
        return self.keeps_up

    def follow_flow(self, seconds: float, most_nodes: int = MOST_NODES_AT_ONCE) -> bool:
        """Let time pass beside a hand: what moves little is left until it is worth a step.

        The outcome is that of `diffuse` as far as can be seen, for much less work; one call does
        a bounded part of it. See `Flow.follow`.

        Parameters
        ----------
        seconds : float
        most_nodes : int
            Vertices that may be moved in this call, a few thousand at least.

        Returns
        -------
        bool
            Whether nothing is left that has to move now. If not, call again, if need be for 0 s.

        Raises
        ------
        InputError
            If the time is not a finite number of at least 0.
        """
        seconds = as_number(seconds, "seconds", 0.0)
        keeps_up = self.flow.follow(seconds, self._take_fresh(), most_nodes)
        self._fresh.append(self.flow.waiting)
        return keeps_up

    @property
    def flow_patience(self) -> float:
        """Time that may pass before `follow_flow` has anything to do, s; infinite if all is dry."""
        if self._flow is None:
            return 0.0 if self.ink.n_dirty[0] or self.coverage.any() else np.inf
        is_fresh = self.ink.n_dirty[0] > 0 or any(len(ids) for ids in self._fresh)
        return 0.0 if is_fresh else self._flow.patience

    def _take_fresh(self) -> NDArray:
        """Vertices (N,) int32 whose ink may have changed since the water was told."""
        fresh = [*self._fresh, self.ink.dirty_ids[: int(self.ink.n_dirty[0])]]
        self._fresh = []
        return np.concatenate(fresh)

    def dry(self) -> None:
        """Let all wet paint dry at once where it is: what it shows stays.

        Paint that comes later glazes over it and does not mix with it. Water is gone.
        """
        ids = np.flatnonzero(self.coverage > 0.0).astype(np.int32)
        self.settle(ids)
        self.drop_flow()

    def settle(self, vertex_ids: NDArray) -> None:
        """Turn the wet paint of some vertices (N,) int32 into a dry layer."""
        ink = self.ink
        if not len(vertex_ids) or self._glaze is None:
            return
        self._know_vertices()
        rows = self.dry_layers.reserve_rows(vertex_ids, self.paint_mesh.capacity)
        ground = self.ground()
        grounds = [ground]
        if self.dry_layers.has_filters:
            grounds += self.dry_layers.grey_grounds(ground)
        for below in grounds:
            self._glaze.dry(ink.amounts, ink.coverage, below, vertex_ids, rows)
        amounts, share = ink.amounts[vertex_ids] * self._lasting, ink.coverage[vertex_ids]
        self.dry_layers.settle(vertex_ids, rows, amounts, share)
        ink.amounts[vertex_ids] = 0.0
        ink.coverage[vertex_ids] = 0.0
        self.touch(vertex_ids)

    def touch(self, vertex_ids: NDArray) -> None:
        """Note that the colours of some vertices are out of date."""
        ink = self.ink
        fresh = vertex_ids[ink.dirty[vertex_ids] == 0]
        count = int(ink.n_dirty[0])
        ink.dirty_ids[count : count + len(fresh)] = fresh
        ink.dirty[fresh] = 1
        ink.n_dirty[0] = count + len(fresh)

    @property
    def _lasting(self) -> NDArray:
        """(P,) float32: 1 for a pigment, 0 for water, which no account holds."""
        return np.array([p is not WATER for p in self.pigments], np.float32)

    @property
    def n_vertices(self) -> int:
        """Vertices there are now, V."""
        return self.paint_mesh.n_vertices

    @property
    def srgb(self) -> NDArray:
        """(V, 3) uint8 sRGB of every vertex, up to date; the order is that of `mesh.vertices`."""
        self.refresh()
        return self._srgb[: self.n_vertices]

    @property
    def codes(self) -> NDArray:
        """(cap, 3) uint8 sRGB as `refresh` last left it; rows of vertices to come are bare."""
        return self._srgb

    @property
    def coverage(self) -> NDArray:
        """(V,) float32: share of each vertex's own area that is under wet paint, 0 to 1."""
        return self.ink.coverage[: self.n_vertices]

    @property
    def painted(self) -> NDArray:
        """(V,) bool: whether there is paint on a vertex, wet or dry."""
        painted = self.coverage > 0.0
        painted[self.dry_layers.vertex_ids] = True
        if self.layers is not None:
            painted[self.layers.painted_ids()] = True
        return painted

    @property
    def amounts(self) -> NDArray:
        """(V, P) float32: wet ink at each vertex, full coats times the covered share."""
        return self.ink.amounts[: self.n_vertices]

    def parts_at(self, vertex_id: int) -> NDArray:
        """(P,) float64 ink on one vertex, coats times the covered share: what is wet, else dry."""
        if self.layers is not None:
            return self.layers.parts_at(vertex_id)
        wet = self.ink.amounts[vertex_id]
        row = self.dry_layers.rows_of(np.array([vertex_id]))[0]
        found = wet if wet.any() or row < 0 else self.dry_layers.amounts[row]
        return found.astype(np.float64)

    def share_painted(self) -> NDArray:
        """(V,) float32: greatest share of each vertex that any paint covers, wet or dry."""
        share = self.coverage.copy()
        ids = self.dry_layers.vertex_ids
        share[ids] = np.maximum(share[ids], self.dry_layers.share)
        if self.layers is not None:
            self.layers.add_shares(share)
        return share

    @property
    def vertex_areas(self) -> NDArray:
        """(V,) float64: the surface's area that each vertex stands for, mm2."""
        return self.paint_mesh.vertex_areas

    @property
    def mesh(self) -> TriangleMesh:
        """The mesh as it is refined now, with its colours."""
        return TriangleMesh(
            vertices=self.paint_mesh.vertices,
            faces=self.paint_mesh.leaf_faces(),
            colours=self.srgb,
            normals=self.paint_mesh.normals,
            name=self.source.name,
        )

    def export_arrays(
        self,
        tolerance: float | None = EXPORT_TOLERANCE,
        srgb: NDArray | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """The painting for a file: bisections that its colours do not need are taken back.

        Parameters
        ----------
        tolerance : float or None
            Largest dE00 by which interpolated sRGB codes may miss a vertex's colour; None for
            all vertices and triangles that there are.
        srgb : (V, 3) uint8, optional
            Codes to give out, and to judge by, instead of the painting's own.
        progress : callable, optional
            Called with the share done, now and then; what it raises stops it.

        Returns
        -------
        vertices : (K, 3) float32
            mm. The source's vertices come first and in its order, one on a crease once for each
            of its normals. An object without paint, wet or dry, comes out as it went in.
        faces : (F, 3) int32
        normals : (K, 3) float32
        srgb : (K, 3) uint8
        """
        codes = self.srgb if srgb is None else srgb
        mesh = self.paint_mesh
        if tolerance is None:
            ids = mesh.source_order()
            place = np.empty(len(ids), np.int32)
            place[ids] = np.arange(len(ids), dtype=np.int32)
            faces = place[mesh.leaf_faces()]
        elif srgb is None and not self.painted.any():
            return self._source_arrays()
        else:
            ids, faces = coarse_faces(mesh, codes, tolerance, _code_difference, progress)
        return mesh.vertices[ids], faces, mesh.normals[ids], codes[ids]

    def detail_arrays(self) -> tuple[NDArray, ...]:
        """The object's own triangles, and those painted on it, for a texture.

        Returns
        -------
        vertices, faces, normals : (B, 3) float32, (R, 3) int32, (B, 3) float32
            Of the object: one vertex for each normal, faces without area left out.
        all_vertices, all_faces : (V, 3) float32, (F, 3) int32
            Those there are now.
        owners : (F,) int32
            The face of the object that each lies in.
        srgb : (V, 3) uint8
        """
        mesh = self.paint_mesh
        vertices, n = mesh.vertices, mesh.n_base_vertices
        own = vertices[:n], mesh.base_faces, mesh.normals[:n]
        return *own, vertices, mesh.leaf_faces(), mesh.leaf_roots(), self.srgb

    def _source_arrays(self) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """The source's own vertices and triangles; normals are not of length 1."""
        source, base = self.source, self.paint_mesh.source_vertices
        srgb, normals = source.colours, source.normals
        if srgb is None:
            srgb = np.tile(self._bare, (source.n_vertices, 1))
        if normals is None:
            normals = np.zeros((source.n_vertices, 3), np.float32)
            np.add.at(normals, base, self.paint_mesh.normals[: len(base)])
        return source.vertices, source.faces, normals, srgb

    def wet_ink(self) -> float:
        """Pigment on the surface that has not dried, coats x mm2."""
        own = float(self.vertex_areas @ (self.amounts @ self._lasting.astype(np.float64)))
        return own + self._resting_ink()[0]

    def dry_ink(self) -> float:
        """Pigment that has dried on the surface, coats x mm2."""
        areas = self.paint_mesh.vertex_areas[self.dry_layers.vertex_ids]
        own = float(areas @ self.dry_layers.amounts.sum(axis=1, dtype=np.float64))
        return own + self._resting_ink()[1]

    def _resting_ink(self) -> tuple[float, float]:
        """Wet and dry pigment on layers that are not painted on, coats x mm2."""
        if self.layers is None:
            return 0.0, 0.0
        return self.layers.resting_ink(self.vertex_areas, self._lasting)

    def main_pigment(self, parts: NDArray) -> Pigment:
        """The pigment that most of a mixture (P,) is, not counting water unless it is alone."""
        inked = parts * self._lasting
        return self.pigments[int(np.argmax(inked if inked.any() else parts))]

    def lasting(self, per_pigment: NDArray) -> float:
        """Sum of a quantity (P,) over the pigments, without water."""
        return float(per_pigment @ self._lasting)


def _in_steps(reflectance: NDArray) -> NDArray:
    """Reflectance as it is kept: uint16, in steps of 1/65535."""
    return (np.clip(reflectance, 0.0, 1.0) * 65535.0 + 0.5).astype(np.uint16)


def _code_difference(a: NDArray, b: NDArray) -> NDArray:
    """CIEDE2000 (n,) between sRGB codes (n, 3), 0 to 255."""
    return delta_e(lab_from_srgb(a / 255.0), lab_from_srgb(b / 255.0))


def _same_light(one: Pigment, two: Pigment) -> bool:
    if one is two:
        return True
    same = np.array_equal(one.K, two.K) and np.array_equal(one.S, two.S)
    return same and one.saunderson == two.saunderson
