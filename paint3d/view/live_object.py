"""Updates of a painted object for the live renderer: geometry and lit colours, by patches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.wet_look import darkened
from paint3d.core.arrays import AnyArray, grown
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.sheen import PLAIN_SHINE
from paint3d.view.edges import packed
from paint3d.view.live_coarse import CoarseObject
from paint3d.view.live_edges import LiveEdges
from paint3d.view.live_light import BakedLight, LiveLight
from paint3d.view.live_patches import FACES, LivePatches

__all__ = ["LiveObject", "PatchUpload"]

_VEIL = np.array([70.0, 84.0, 112.0])  # sRGB codes of the veil over masked parts
_DENSE, _THIN = 0.62, 0.40  # its opacity on its stripes, and between them
_STRIPES = 26  # across the object
_LEAST_EDGES = 5.0  # edge lengths from stripe to stripe, so that vertex colours can resolve them

_MOST_PARTS = 8  # that are kept apart when drawn coarsely
_PIXELS = 0.5  # cluster size of a coarse object with few triangles
_MOST_PIXELS = 1.5  # size up to which it is reused; larger only where triangles are too many
_NEAR = 1.5  # a coarse object is reused if its cluster size is off by no more than this factor


@dataclass(frozen=True, eq=False)
class PatchUpload:
    """One patch's new arrays.

    Attributes
    ----------
    patch : int
    colours : (K, 3) or (K, 4) uint8
        The fourth is each point's shine (`surface.sheen`); without it all shine as the material.
    shares : (K, 1) float32
        Those of `view.edges.Edges`, `packed`.
    bare : (K, 1) float32, or None where they have not changed
        The colours without paint, lit and `packed`.
    points, normals : (K, 3) float32, or None where only colours have changed
    faces : (L, 3) int32, or None likewise
    """

    patch: int
    colours: NDArray[np.uint8]
    shares: NDArray[np.float32]
    bare: NDArray[np.float32] | None = None
    points: NDArray[np.float32] | None = None
    normals: NDArray[np.float32] | None = None
    faces: NDArray[np.int32] | None = None

    @property
    def n_bytes(self) -> int:
        """Bytes to send to the renderer, at most: shares that stay the same are not sent."""
        parts = (self.colours, self.shares, self.bare, self.points, self.normals, self.faces)
        return sum(part.nbytes for part in parts if part is not None)


class LiveObject:
    """A surface as the live view shows it, updated while it is painted.

    `uploads` reads the surface, so nothing may paint meanwhile; its result belongs to the caller.

    Parameters
    ----------
    surface : PaintedSurface
    faces : int
        Approximate number of triangles in a patch.

    Attributes
    ----------
    centre : (3,) float64
        Of the box around it, mm.
    radius : float
        Half of that box's diagonal, mm.
    is_solid : bool
        Whether none of its faces is ever seen from behind.
    """

    def __init__(self, surface: PaintedSurface, faces: int = FACES) -> None:
        self.surface = surface
        self.patches = LivePatches(surface.paint_mesh, faces)
        self.light = LiveLight(surface.paint_mesh)
        low, high = surface.source.vertices.min(axis=0), surface.source.vertices.max(axis=0)
        self.centre = 0.5 * (low + high).astype(np.float64)
        self.radius = 0.5 * float(np.linalg.norm(high - low))
        self.is_solid = surface.source.is_solid
        self._all = True
        self._n_followed = surface.paint_mesh.n_vertices  # at the last `uploads`
        self._coarse: CoarseObject | None = None
        self._coarse_triangles = 0
        self._changed = np.empty(0, np.int32)
        self._covers: Callable[[AnyArray], AnyArray] | None = None
        self._wet = surface.watch_wet()
        self._edges = LiveEdges(surface)
        self._bare = np.empty((0, 3), np.uint8)
        edge = 1.1 * float(np.sqrt(surface.vertex_areas.sum() / len(surface.source.vertices)))
        self._stripe = max(2.0 * self.radius / _STRIPES, _LEAST_EDGES * edge)

    def veil(self, covers: Callable[[AnyArray], AnyArray] | None) -> None:
        """Hatch the parts that take no paint; the next `uploads` returns every colour.

        Parameters
        ----------
        covers : callable or None
            Maps vertices (N,) int32 to (N,) bool; None: nothing is covered.
        """
        self._covers = covers
        self._all = True

    def change_light(self, setting: tuple[str, float]) -> None:
        """Use another light (`LiveLight.setting`); the next `uploads` returns every colour."""
        self.light.change(setting)
        self._all = True

    def relight(self, baked: BakedLight) -> None:
        """Use baked light; the next `uploads` returns every colour."""
        self.light.take(baked.light)
        self._all = True

    def uploads(self, vertex_ids: NDArray[np.int32]) -> list[PatchUpload]:
        """Return what has changed since the last call.

        Parameters
        ----------
        vertex_ids : (N,) int32
            Vertices whose colours have changed; `PaintedSurface.refresh` returns them.
        """
        surface = self.surface
        self._n_followed = surface.paint_mesh.n_vertices
        srgb = surface.codes
        everything, self._all = self._all, False
        if everything:
            vertex_ids = np.arange(surface.n_vertices, dtype=np.int32)
        at_edges = self._edges.follow(vertex_ids)
        by_water = self._wet.follow(vertex_ids)
        if len(by_water) or len(at_edges):
            vertex_ids = np.concatenate([vertex_ids, by_water, at_edges])
        self._changed = vertex_ids
        field = surface.paint_mesh.arrays
        uploads = []
        for change in self.patches.changes(vertex_ids):
            ids = change.vertex_ids
            points = normals = bare = None
            if change.faces is not None or everything:
                bare = self._bare_colours(ids)
            if change.faces is not None:
                points = np.stack([field.px[ids], field.py[ids], field.pz[ids]], axis=1)
                normals = np.stack([field.nx[ids], field.ny[ids], field.nz[ids]], axis=1)
            colours = self._shown(ids, srgb)
            if self._wet.is_plain:
                colours = np.ascontiguousarray(colours[:, :3])
            shares = packed(self._edges.shares(ids))
            uploads.append(
                PatchUpload(change.patch, colours, shares, bare, points, normals, change.faces)
            )
        return uploads

    def _bare_colours(self, ids: AnyArray) -> NDArray[np.float32]:
        """Return the colours (N, 1) of vertices (N,) without paint, lit and packed."""
        surface = self.surface
        if len(self._bare) < surface.n_vertices:
            self._bare = grown(self._bare, len(self._bare), surface.paint_mesh.capacity)
        self._bare[ids] = surface.bare_codes_at(ids)
        shown = self.light.colours(ids, self._bare)
        self._hatch(ids, shown)
        return packed(shown)

    def _shown(self, ids: AnyArray, srgb: AnyArray) -> NDArray[np.uint8]:
        """Return colour, lit, and shine (N, 4) of vertices (N,); srgb (V, 3) is their paint."""
        shown = np.full((len(ids), 4), PLAIN_SHINE, np.uint8)
        colours = shown[:, :3]
        colours[:] = self.light.colours(ids, srgb)
        if not self._wet.is_plain:
            damp = self._wet.damp(ids)
            if damp is not None:
                is_damp = damp > 0.0
                colours[is_damp] = darkened(colours[is_damp], damp[is_damp])
            shown[:, 3] = self._wet.shine(ids)
        self._hatch(ids, colours)
        return shown

    def _hatch(self, ids: AnyArray, colours: AnyArray) -> None:
        """Draw a veil over those of vertices (N,) that take no paint: their colours (N, 3)."""
        if self._covers is None:
            return
        covered = self._covers(ids)
        ids, field = ids[covered], self.surface.paint_mesh.arrays
        along = (field.px[ids] + field.py[ids] + field.pz[ids]) / (3.0**0.5 * self._stripe)
        wave = 0.5 + 0.5 * np.cos(2.0 * np.pi * along)  # stripes along the diagonal of space
        opacity = (_THIN + (_DENSE - _THIN) * wave)[:, None]
        colours[covered] = np.rint((1.0 - opacity) * colours[covered] + opacity * _VEIL)

    # -- coarse version ---------------------------------------------------------------------

    def coarse_fits(self, pixel_mm: float, n_triangles: int) -> bool:
        """Return whether the last result of `coarse_for` still fits these parameters."""
        before = self._coarse
        if before is None or n_triangles != self._coarse_triangles:
            return False
        if before.n_vertices != self.surface.paint_mesh.n_vertices:
            return False
        fewest = self._fewest_mm(n_triangles)
        low = fewest / _NEAR if before.n_faces > n_triangles else 0.0
        return low <= before.size <= max(_MOST_PIXELS * pixel_mm, fewest * _NEAR)

    def _fewest_mm(self, n_triangles: int) -> float:
        """Return the cluster size, mm, that leaves `n_triangles`; 0 if there are no more anyway."""
        if self.patches.n_leaves <= n_triangles:
            return 0.0
        return float(np.sqrt(2.0 * self.patches.fine_area / n_triangles))

    def coarse_for(self, pixel_mm: float, n_triangles: int) -> CoarseObject | None:
        """Return a coarse version to draw while the view moves; None if the last one still fits.

        Also None where vertices were added since `uploads`, which follows them first. Call it while
        nothing paints.

        Parameters
        ----------
        pixel_mm : float
            Size of a pixel on the nearest visible part, mm.
        n_triangles : int
            Approximate greatest number of triangles.
        """
        if self.coarse_fits(pixel_mm, n_triangles):
            return None
        if self._n_followed != self.surface.paint_mesh.n_vertices:
            return None
        surface, self._coarse_triangles = self.surface, n_triangles
        size = max(_PIXELS * pixel_mm, self._fewest_mm(n_triangles))
        self._coarse = CoarseObject(
            surface.paint_mesh, self.patches, size, self._shown, surface.codes, self._parts()
        )
        return self._coarse

    def _parts(self) -> AnyArray | None:
        """Number the few colours that vertices (V,) have without paint; None if one, or many."""
        surface = self.surface
        if surface.source.colours is None:
            return None
        bare = surface.bare_codes_at(np.arange(surface.n_vertices, dtype=np.int32))
        packed = bare.astype(np.int32) @ np.array([65536, 256, 1], np.int32)
        colours = np.unique(packed)
        return np.searchsorted(colours, packed) if len(colours) <= _MOST_PARTS else None

    def repaint_coarse(self) -> CoarseObject | None:
        """Apply the changes of the last `uploads` to the coarse version; return it, or None."""
        if self._coarse is not None:
            self._coarse.repaint(self._changed, self.surface.codes)
        return self._coarse
