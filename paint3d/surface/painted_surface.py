"""The painted object: ink, layers and water on a mesh. Everything mutable is in here."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.ink_transfer import forget_dirty
from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.colour.materials import Material, load_material
from paint3d.colour.spectra import srgb_from_reflectance
from paint3d.colour.wet_look import WetLook
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import InputError
from paint3d.mesh.bvh import ClosestPoints, build_contact_tree
from paint3d.mesh.foreign import as_mesh
from paint3d.mesh.kernels.bvh import ContactTree
from paint3d.mesh.likeness import Original
from paint3d.mesh.sheet_mesh import sheet_of, with_paper
from paint3d.mesh.simplify import coarse_faces
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.flow import Flow, Water
from paint3d.surface.ink_store import InkStore, union
from paint3d.surface.layer_stack import LayerStack
from paint3d.surface.objects import open3d_of, plot_painting, pyvista_of, spectral_of, trimesh_of
from paint3d.surface.sheen import WetWatch, look_when_wet

if TYPE_CHECKING:
    import colour
    import open3d
    import pyvista
    import trimesh

__all__ = ["EXPORT_TOLERANCE", "MOST_NODES_AT_ONCE", "PaintedSurface"]

MOST_NODES_AT_ONCE = 60_000  # of `PaintedSurface.follow_flow`: about 25 ms

EXPORT_TOLERANCE = 1.0  # dE00

_FINEST, _COARSEST = 0.005, 1e6  # mm


class PaintedSurface(InkStore):
    """A mesh that takes ink.

    The mesh is refined where paint arrives, to `resolution`; its shape never changes.

    Parameters
    ----------
    mesh : TriangleMesh, (vertices, faces), or a mesh of trimesh, Open3D or PyVista
        mm, z up; `load_mesh` takes colours and units of the latter, too.
    resolution : float or None
        Longest edge wanted where there is paint, mm; None keeps the mesh's own vertices.
    material : str or Material, optional
        What the surface is made of: its reflectance is the ground of every colour. By default what
        suits a sheet (`mesh.sheets`), and porcelain for everything else.
    original : Original, optional
        The mesh and the resolution that it was painted with before remeshing: recorded strokes
        keep their position wherever the surface is still the same (`mesh.likeness`).

    Raises
    ------
    MeshError, InputError
        If the mesh is unusable or the resolution is not a length of 0.005 mm to 1 km.

    Attributes
    ----------
    keeps_up : bool
        Whether the last call of `follow_time` kept up with the moving water.

    Examples
    --------
    >>> import paint3d
    >>> surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), 1.0, "xuan")
    >>> line = paint3d.Painter(surface).stroke([(-20, 0, 0), (20, 0, 0)])
    >>> surface.diffuse(10.0)  # the ink spreads
    >>> surface.srgb.shape[1], int(surface.painted.sum()) > 100
    (3, True)
    """

    def __init__(
        self,
        mesh: TriangleMesh | Any,
        resolution: float | None = 0.4,
        material: str | Material | None = None,
        original: Original | None = None,
    ) -> None:
        mesh = as_mesh(mesh)
        if material is None:
            sheet = sheet_of(mesh)
            material = "porcelain" if sheet is None else sheet.usual.material
        if resolution is not None:
            resolution = as_number(resolution, "resolution (mm)", _FINEST, _COARSEST)
        made_of = load_material(material) if isinstance(material, str) else material
        mesh = with_paper(mesh, srgb_from_reflectance(made_of.reflectance))
        super().__init__(mesh, resolution, made_of, original)
        self.layers: LayerStack | None = None
        self.keeps_up = True
        self._water = Water(self)
        self._changed: list[AnyArray] | None = None

    @cached_property
    def contact_tree(self) -> ContactTree:
        """The tree for brush contact, built on first access (.2 s for a million faces)."""
        return build_contact_tree(self.paint_mesh)

    @cached_property
    def closest_points(self) -> ClosestPoints:
        """Closest points and ray hits on the object, found when they are first asked for."""
        return ClosestPoints(self.source)

    def refresh(self) -> AnyArray:
        """Bring colours up to date; return the ids (N,) int32 of vertices that may have changed.

        Those are the vertices that got ink or, after a pigment was added, all that have paint: the
        number of pigments changes how mixtures and their gloss are computed.
        """
        self.know_vertices()
        count = int(self.ink.n_dirty[0])
        ids = self.ink.dirty_ids[:count].copy()
        if self.glaze is None:
            return ids
        seen = ids
        if self.looks_otherwise:
            seen = union([ids, np.flatnonzero(self.painted)], self.paint_mesh.capacity)
            self.looks_otherwise = False
        if len(seen):
            if self.layers is not None and not self.layers.is_plain:
                self.layers.colour(self.glaze, seen, self.codes)
            else:
                self.colour_as_one(seen)
            if self._water.fresh is not None:
                self._water.fresh.append(ids)
            if self._changed is not None:
                self._changed.append(seen)
            forget_dirty(ids, self.ink.dirty)
            self.ink.n_dirty[0] = 0
        return seen

    @property
    def n_outdated(self) -> int:
        """Number of vertices that may have other colours than at the last `refresh`."""
        return int(self.ink.n_dirty[0])

    def take_changed(self) -> NDArray[np.int32]:
        """Return the vertices (N,) int32 whose ink may have changed since the last call.

        The first call returns all inked vertices and starts recording changes, so call it again
        now and then.
        """
        dirty = self.ink.dirty_ids[: int(self.ink.n_dirty[0])]
        if self._changed is None:
            self._changed = []
            return np.flatnonzero(self.ink.amounts.any(axis=1) | (self.ink.coverage > 0.0)).astype(
                np.int32
            )
        changed, self._changed = self._changed, []
        return union([*changed, dirty], self.paint_mesh.capacity)

    def use_layers(self) -> LayerStack:
        """Return the layers; existing paint becomes the first. See `surface.layer_stack`."""
        if self.layers is None:
            self.layers = LayerStack(self, self._water)
        return self.layers

    @property
    def flow(self) -> Flow:
        """The simulation of the water on the surface, created on first access."""
        return self._water.flow

    @property
    def flow_patience(self) -> float:
        """Time until `follow_flow` has anything to do, s; infinite if all is dry."""
        return self._water.patience

    def keep_flow(self) -> dict[str, AnyArray] | None:
        """Return the state for `restore_flow`, None if no water ever moved; see `Water.keep`."""
        return self._water.keep()

    def restore_flow(self, kept: Mapping[str, AnyArray]) -> None:
        """Continue from a state returned by `keep_flow`."""
        self._water.restore(kept)

    def drop_flow(self) -> None:
        """Discard all water in motion."""
        self._water.drop()

    def diffuse(
        self,
        seconds: float,
        step: float | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> None:
        """Advance time: wet ink spreads on an absorbent material, and dries.

        Parameters
        ----------
        seconds : float
        step : float, optional
            Longest step, s; by default as long as the motion allows.
        progress : callable, optional
            Called with the fraction of the work done, about: fresh ink, which runs, takes most.

        Raises
        ------
        InputError
            If a time is not a finite number of at least 0, or the step is 0.
        """
        seconds = as_number(seconds, "seconds", 0.0)
        if step is not None:
            step = as_number(step, "step (s)", 1e-6)
        self._water.advance(seconds, step, progress)

    def follow_time(self, seconds: float) -> bool:
        """Advance time interactively, or not at all until the water has caught up.

        Which of the two depends on the painting alone. Returns the new `keeps_up`.
        """
        self.keeps_up = self.follow_flow(seconds if self.keeps_up else 0.0)
        return self.keeps_up

    def follow_flow(self, seconds: float, most_nodes: int = MOST_NODES_AT_ONCE) -> bool:
        """Advance time interactively: water that moves little waits until a step is worth it.

        The result is visually that of `diffuse`, for much less work; one call does a bounded part
        of it. See `Flow.follow`.

        Parameters
        ----------
        seconds : float
        most_nodes : int
            Vertices that may be moved in this call, a few thousand at least.

        Returns
        -------
        bool
            Whether nothing is overdue. If not, call again, if need be for 0 s.

        Raises
        ------
        InputError
            If the time is not a finite number of at least 0.
        """
        seconds = as_number(seconds, "seconds", 0.0)
        return self._water.follow(seconds, most_nodes)

    def dry(self) -> None:
        """Dry all wet paint at once where it is; its colour stays, and water is discarded.

        Later paint glazes over it and does not mix with it.
        """
        ids = np.flatnonzero(self.coverage > 0.0).astype(np.int32)
        self.settle(ids)
        self.drop_flow()

    @property
    def srgb(self) -> NDArray[np.uint8]:
        """(V, 3) uint8 sRGB of every vertex, up to date; the order is that of `mesh.vertices`."""
        self.refresh()
        return self._srgb[: self.n_vertices]

    def spectra(self, vertex_ids: AnyArray | None = None) -> NDArray[np.float64]:
        """Return the reflectance of vertices, all layers and the ground below composited.

        Parameters
        ----------
        vertex_ids : (N,) array_like of int, optional
            Distinct vertices; by default all.

        Returns
        -------
        (N, 31) float64
            At 400, 410, ... 700 nm. The colour that a mesh came with has a smooth spectrum of
            that sRGB (`colour.glazing.srgb_primaries`).

        Raises
        ------
        InputError
            If one is not a vertex.
        """
        self.refresh()
        n = self.n_vertices
        ids: AnyArray = np.arange(n)
        if vertex_ids is not None:
            ids = as_array(vertex_ids, "vertex_ids", (None,), np.int64)
            if ids.size and not (ids.min() >= 0 and ids.max() < n):
                raise InputError(
                    "vertex_ids are {least} to {most}; expected 0 to {last}",
                    least=ids.min(),
                    most=ids.max(),
                    last=n - 1,
                )
        ids = ids.astype(np.int32)
        if self.layers is not None and not self.layers.is_plain and self.glaze is not None:
            steps = self.layers.spectra(self.glaze, ids)
        else:
            steps = self.spectra_as_one(ids)
        return steps / 65535.0

    def reflectance(self, vertex_ids: AnyArray | None = None) -> colour.MultiSpectralDistributions:
        """Return `spectra` as an object of colour-science, n vertices x 31 bands.

        Its labels are the vertices' ids.

        Raises
        ------
        InputError
            If one is not a vertex, or colour-science is not installed.
        """
        ids = np.arange(self.n_vertices) if vertex_ids is None else np.asarray(vertex_ids)
        return spectral_of(self.spectra(vertex_ids), ids)

    @property
    def painted(self) -> NDArray[np.bool_]:
        """(V,) bool: whether there is paint on a vertex, wet or dry."""
        painted = self.coverage > 0.0
        painted[self.dry_layers.vertex_ids] = True
        if self.layers is not None:
            painted[self.layers.painted_ids()] = True
        return painted

    def parts_at(self, vertex_id: int) -> NDArray[np.float64]:
        """Return the wet, else dry ink (P,) of one vertex, coats times the covered fraction."""
        if self.layers is not None:
            return self.layers.parts_at(vertex_id)
        wet = self.ink.amounts[vertex_id]
        row = self.dry_layers.rows_of(np.array([vertex_id]))[0]
        ink = wet if wet.any() or row < 0 else self.dry_layers.amounts[row]
        result: NDArray[np.float64] = ink.astype(np.float64)
        return result

    def painted_coverage(self) -> NDArray[np.float32]:
        """Return the greatest fraction (V,) of each vertex that any paint covers, wet or dry."""
        coverage = self.coverage.copy()
        ids = self.dry_layers.vertex_ids
        coverage[ids] = np.maximum(coverage[ids], self.dry_layers.coverage)
        if self.layers is not None:
            self.layers.add_coverage(coverage)
        return coverage

    def coverage_at(self, vertex_ids: AnyArray) -> NDArray[np.float32]:
        """Return the greatest fraction (N,) of vertices that paint on visible layers covers."""
        if self.layers is not None:
            return self.layers.coverage_at(vertex_ids)
        coverage: NDArray[np.float32] = self.ink.coverage[vertex_ids]
        if self.dry_layers.count:
            rows = self.dry_layers.rows_of(vertex_ids)
            dried = rows >= 0
            coverage[dried] = np.maximum(coverage[dried], self.dry_layers.coverage[rows[dried]])
        return coverage

    def coverage_codes(self, vertex_ids: AnyArray | None = None) -> NDArray[np.uint8]:
        """Return `coverage_at` of vertices (N,), by default of all, as (N,) uint8; 255 is 1."""
        ids = np.arange(self.n_vertices, dtype=np.int32) if vertex_ids is None else vertex_ids
        codes: NDArray[np.uint8] = np.rint(255.0 * self.coverage_at(ids)).astype(np.uint8)
        return codes

    @property
    def wet_look(self) -> WetLook | None:
        """Wetness and gloss of each vertex; None where all are as dry and rough as the material.

        Water is what `diffuse` and wet replays move: ink for which no time has passed has none. The
        ink of all visible layers counts, but only the water of the active one.
        """
        return self.look_on(self.material.seen_roughness)

    def look_on(self, roughness: float) -> WetLook | None:
        """Return `wet_look` as on a material of another roughness, with this one's pores."""
        return look_when_wet(self, roughness)

    def watch_wet(self) -> WetWatch:
        """Return a tracker of `wet_look` from one picture to the next."""
        return WetWatch(self)

    @property
    def seen_layers(self) -> Hashable:
        """A token that changes whenever the set of visible layers does."""
        return None if self.layers is None else self.layers.seen

    @property
    def seen_water(self) -> tuple[AnyArray, AnyArray] | None:
        """Vertices (C,) int32 and the depth of water on each (C,), mm.

        None without any, or while the active layer is hidden.
        """
        is_hidden = self.layers is not None and not self.layers.layers[self.layers.active].is_seen
        return None if is_hidden else self._water.depths()

    def coats_at(self, vertex_ids: AnyArray) -> NDArray[np.float64]:
        """Return the ink (N, P) of all visible layers, in coats times the covered fraction."""
        if self.layers is not None:
            return self.layers.coats_at(vertex_ids)
        coats = self.ink.amounts[vertex_ids].astype(np.float64)
        rows = self.dry_layers.rows_of(vertex_ids)
        coats[rows >= 0] += self.dry_layers.amounts[rows[rows >= 0]]
        return coats

    @property
    def mesh(self) -> TriangleMesh:
        """The mesh as refined at present, with its colours."""
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
        srgb: NDArray[np.uint8] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> tuple[AnyArray, AnyArray, AnyArray, AnyArray]:
        """Return the painting for a file, undoing bisections that its colours do not need.

        Parameters
        ----------
        tolerance : float or None
            Largest dE00 by which interpolated sRGB codes may miss a vertex's colour; None for
            all vertices and triangles.
        srgb : (V, 3) uint8, optional
            Codes to export and compare instead of the painting's own.
        progress : callable, optional
            Called with the fraction done, now and then; an exception from it stops the export.

        Returns
        -------
        vertices : (K, 3) float32
            mm. The source's vertices come first and in its order, one on a crease once for each
            of its normals. An object without paint, wet or dry, comes out as it went in.
        faces : (F, 3) int32
        normals : (K, 3) float32
        srgb : (K, 3) uint8
        """
        if tolerance is not None and srgb is None and not self.painted.any():
            return self._source_arrays()
        codes = self.srgb if srgb is None else srgb
        ids, faces = self.export_ids(tolerance, codes, progress)
        mesh = self.paint_mesh
        return mesh.vertices[ids], faces, mesh.normals[ids], codes[ids]

    def export_ids(
        self,
        tolerance: float | None,
        srgb: NDArray[np.uint8],
        progress: Callable[[float], None] | None = None,
    ) -> tuple[AnyArray, AnyArray]:
        """Return the vertices (K,) to export, and faces (F, 3) of indices into them."""
        mesh = self.paint_mesh
        if tolerance is not None:
            return coarse_faces(mesh, srgb, tolerance, _code_difference, progress)
        ids = mesh.source_order()
        place = np.empty(len(ids), np.int32)
        place[ids] = np.arange(len(ids), dtype=np.int32)
        return ids, place[mesh.leaf_faces()]

    def detail_arrays(self) -> tuple[AnyArray, ...]:
        """Return the object's own triangles and the refined ones on them, for baking a texture.

        Returns
        -------
        vertices, faces, normals : (B, 3) float32, (R, 3) int32, (B, 3) float32
            Of the object: one vertex for each normal, faces without area left out.
        all_vertices, all_faces : (V, 3) float32, (F, 3) int32
            The refined mesh.
        owners : (F,) int32
            The object's face that each refined face lies in.
        srgb : (V, 3) uint8
        """
        mesh = self.paint_mesh
        vertices, n = mesh.vertices, mesh.n_base_vertices
        own = vertices[:n], mesh.base_faces, mesh.normals[:n]
        return *own, vertices, mesh.leaf_faces(), mesh.leaf_roots(), self.srgb

    def _source_arrays(self) -> tuple[AnyArray, AnyArray, AnyArray, AnyArray]:
        """Return the source's own vertices and triangles; normals are not normalised."""
        source, base = self.source, self.paint_mesh.source_vertices
        srgb, normals = source.colours, source.normals
        if srgb is None:
            srgb = np.tile(self._bare, (source.n_vertices, 1))
        if normals is None:
            normals = np.zeros((source.n_vertices, 3), np.float32)
            np.add.at(normals, base, self.paint_mesh.normals[: len(base)])
        return source.vertices, source.faces, normals, srgb

    # -- for other packages -----------------------------------------------------------------

    def layer_arrays(self) -> dict[str, NDArray[np.float32]]:
        """Return the ink of every layer, vertex by vertex, the lowest layer first.

        Returns
        -------
        dict
            For each layer ``"NAME: share"``, (V,) float32, the fraction of each vertex that its
            paint covers, and for each pigment on it ``"NAME: PIGMENT"``, (V,) float32, coats times
            the covered fraction, wet and dry together. A surface without layers has one, named 1.
            Of layers of one name the second is ``"NAME (2)"``, and so on.
        """
        if self.layers is None:
            amounts, coverage, dry = self.amounts.copy(), self.coverage.copy(), self.dry_layers
            amounts[dry.vertex_ids] += dry.amounts
            coverage[dry.vertex_ids] = np.maximum(coverage[dry.vertex_ids], dry.coverage)
            layers = [("1", amounts, coverage)]
        else:
            stack = self.layers
            layers = [(layer.name, *stack.paint_on(k)) for k, layer in enumerate(stack.layers)]
        arrays: dict[str, NDArray[np.float32]] = {}
        counts: dict[str, int] = {}
        for name, amounts, coverage in layers:
            counts[name] = counts.get(name, 0) + 1
            unique = name if counts[name] == 1 else f"{name} ({counts[name]})"
            arrays[f"{unique}: share"] = coverage
            for column, pigment in enumerate(self.pigments):
                if self._lasting[column] and amounts[:, column].any():
                    arrays[f"{unique}: {pigment.name}"] = amounts[:, column].copy()
        return arrays

    def to_trimesh(self) -> trimesh.Trimesh:
        """Return the painting as a trimesh.Trimesh: mm, all vertices in the order of `mesh`.

        It has vertex colours and normals; its `vertex_attributes` are `layer_arrays`.

        Raises
        ------
        ExportError
            If trimesh is not installed.
        """
        given: trimesh.Trimesh = trimesh_of(self)
        return given

    def to_open3d(
        self, *, legacy: bool = False
    ) -> open3d.t.geometry.TriangleMesh | open3d.geometry.TriangleMesh:
        """Return the painting as an Open3D mesh: mm, all vertices in the order of `mesh`.

        Parameters
        ----------
        legacy : bool
            Return an open3d.geometry.TriangleMesh, which holds positions, faces, colours (0 to 1)
            and normals only. Otherwise an open3d.t.geometry.TriangleMesh, whose `vertex` holds
            ``colors`` (uint8 codes), ``normals`` and `layer_arrays`.

        Raises
        ------
        ExportError
            If Open3D is not installed.
        """
        given: open3d.t.geometry.TriangleMesh | open3d.geometry.TriangleMesh
        given = open3d_of(self, legacy)
        return given

    def to_pyvista(self) -> pyvista.PolyData:
        """Return the painting as a pyvista.PolyData: mm, all vertices in the order of `mesh`.

        Its `point_data` hold ``srgb`` (uint8 codes, active), ``Normals`` and `layer_arrays`.

        Raises
        ------
        ExportError
            If PyVista is not installed.
        """
        return pyvista_of(self)

    def plot(self, *, lit: bool = True, plotter: Any = None, **options: Any) -> Any:
        """Show the painting in a PyVista window, or inline in a notebook.

        In a notebook it is interactive where trame is installed (``pip install
        'pyvista[jupyter]'``), and a still picture otherwise.

        Parameters
        ----------
        lit : bool
            Whether it is lit; unlit, every colour is shown as it was painted.
        plotter : pyvista.Plotter, optional
            Add the painting to this one, and show nothing yet.
        **options
            What `pyvista.Plotter.show` takes, such as ``screenshot`` and ``window_size``, and
            ``off_screen``.

        Returns
        -------
        object
            What `pyvista.Plotter.show` returns, or the `plotter` given.

        Raises
        ------
        ExportError
            If PyVista is not installed.
        """
        return plot_painting(self, lit=lit, plotter=plotter, options=options)

    def edit(self, **options: Any) -> Any:
        """Show the bare surface in a cell of Jupyter or marimo, to be painted on.

        What is painted there does not change it: see `paint3d.edit`, which this calls.
        """
        from paint3d import edit

        return edit(self, **options)

    def wet_ink(self) -> float:
        """Return the wet pigment on the surface, coats x mm2."""
        own = float(self.vertex_areas @ (self.amounts @ self._lasting.astype(np.float64)))
        return own + self._resting_ink()[0]

    def dry_ink(self) -> float:
        """Return the dried pigment on the surface, coats x mm2."""
        areas = self.paint_mesh.vertex_areas[self.dry_layers.vertex_ids]
        own = float(areas @ self.dry_layers.amounts.sum(axis=1, dtype=np.float64))
        return own + self._resting_ink()[1]

    def _resting_ink(self) -> tuple[float, float]:
        """Return the wet and the dry pigment on layers other than the active one, coats x mm2."""
        if self.layers is None:
            return 0.0, 0.0
        return self.layers.resting_ink(self.vertex_areas, self._lasting)


def _code_difference(a: AnyArray, b: AnyArray) -> AnyArray:
    """Return CIEDE2000 (n,) between sRGB codes (n, 3), 0 to 255."""
    return delta_e(lab_from_srgb(a / 255.0), lab_from_srgb(b / 255.0))
