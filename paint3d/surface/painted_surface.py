"""The one mutable thing: an object with ink on it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.arrays import as_number
from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.colour.vertex_colours import ColourModel
from paint3d.errors import InputError
from paint3d.ink.materials import Material, load_material
from paint3d.ink.pigments import Pigment
from paint3d.mesh.contact_index import build_contact_tree
from paint3d.mesh.paint_mesh import PaintMesh
from paint3d.mesh.simplify import coarse_faces
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["EXPORT_TOLERANCE", "InkField", "PaintedSurface"]

EXPORT_TOLERANCE = 1.0  # dE00

_FINEST = 0.005  # mm


class InkField(NamedTuple):
    """What kernels need to leave ink on vertices (cap: room for vertices, P: pigments)."""

    amounts: NDArray  # (cap, P) float32, full coats x share of the vertex's area that is covered
    coverage: NDArray  # (cap,) float32, share of the vertex's area under paint, 0 to 1
    dirty: NDArray  # (cap,) uint8, 1 where the colour is out of date
    dirty_ids: NDArray  # (cap,) int32, those vertices
    n_dirty: NDArray  # (1,) int64, how many
    load: NDArray  # (P,) float64, ink in the brush, coats x mm2
    off_surface: NDArray  # (P,) float64, ink that ran off the surface, coats x mm2


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
        If the mesh is unusable or the resolution is not a length of at least 0.005 mm.
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
            resolution = as_number(resolution, "resolution (mm)", low=_FINEST)
        self.source = mesh
        self.resolution = resolution
        self.material = load_material(material) if isinstance(material, str) else material
        self.paint_mesh = PaintMesh.build(mesh, resolution)
        self.contact_tree = build_contact_tree(self.paint_mesh)
        self.pigments: list[Pigment] = []
        self._colours: ColourModel | None = None
        self._bare = self._bare_srgb()
        self._allocate(0)

    def _bare_srgb(self) -> NDArray:
        from paint3d.colour.spectra import srgb_from_reflectance

        return np.asarray(srgb_from_reflectance(self.material.reflectance), dtype=np.uint8)

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
        )

    def make_room(self, extra: int | None = None) -> None:
        """Let the mesh grow by `extra` vertices (None: as `PaintMesh.reserve` sees fit)."""
        self.paint_mesh.reserve(extra)
        self._fit()

    def refine_all(self) -> None:
        """Refine the whole surface now instead of where paint comes; nothing painted changes."""
        self.paint_mesh.refine_all()
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

    def column_of(self, pigment: Pigment) -> int:
        """The column of a pigment in the ink's arrays; a new one is added at the end."""
        names = [known.name for known in self.pigments]
        if pigment.name in names:
            return names.index(pigment.name)
        self.pigments.append(pigment)
        old = self.ink
        count = len(self.pigments)
        amounts = np.zeros((old.amounts.shape[0], count), np.float32)
        amounts[:, :-1] = old.amounts
        self.ink = old._replace(
            amounts=amounts,
            load=np.append(old.load, 0.0),
            off_surface=np.append(old.off_surface, 0.0),
        )
        self._colours = ColourModel(self.pigments, self.material.reflectance, path="live")
        return count - 1

    def refresh(self) -> NDArray:
        """Bring the colours of all vertices that got ink up to date; return their ids (int32)."""
        count = int(self.ink.n_dirty[0])
        ids = self.ink.dirty_ids[:count].copy()
        if count and self._colours is not None:
            self._colours.srgb(self.ink.amounts, self.ink.coverage, self._srgb, ids)
            self.ink.dirty[ids] = 0
            self.ink.n_dirty[0] = 0
        return ids

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
    def coverage(self) -> NDArray:
        """(V,) float32: share of each vertex's own area that is under paint, 0 to 1."""
        return self.ink.coverage[: self.n_vertices]

    @property
    def amounts(self) -> NDArray:
        """(V, P) float32: ink at each vertex, full coats times the covered share."""
        return self.ink.amounts[: self.n_vertices]

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
        self, tolerance: float = EXPORT_TOLERANCE
    ) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """The painting for a file: bisections that its colours do not need are taken back.

        Parameters
        ----------
        tolerance : float
            Largest dE00 by which interpolated sRGB codes may miss a vertex's colour.

        Returns
        -------
        vertices : (K, 3) float32
            mm. The source's vertices come first and in its order, one on a crease once for each
            of its normals; an unpainted object comes out as it went in.
        faces : (F, 3) int32
        normals : (K, 3) float32
        srgb : (K, 3) uint8
        """
        srgb = self.srgb
        ids, faces = coarse_faces(self.paint_mesh, srgb, tolerance, _code_difference)
        return self.paint_mesh.vertices[ids], faces, self.paint_mesh.normals[ids], srgb[ids]

    def wet_ink(self) -> float:
        """Ink on the surface that has not dried, coats x mm2."""
        return float(self.vertex_areas @ self.amounts.sum(axis=1, dtype=np.float64))


def _code_difference(a: NDArray, b: NDArray) -> NDArray:
    """CIEDE2000 (n,) between sRGB codes (n, 3), 0 to 255."""
    return delta_e(lab_from_srgb(a / 255.0), lab_from_srgb(b / 255.0))
