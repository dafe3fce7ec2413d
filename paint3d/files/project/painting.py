"""A painting for the writers: plain arrays, checked, in the file's unit and axes."""

from __future__ import annotations

import logging
from functools import cached_property
from typing import Any, NamedTuple, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.glazing import srgb_primaries
from paint3d.colour.spectra import decode_srgb
from paint3d.colour.viewing import GAMUTS, Codes, Viewing
from paint3d.colour.wet_look import WetLook
from paint3d.core.arrays import AnyArray, as_array
from paint3d.errors import ExportError, MeshError
from paint3d.files.export_options import ExportOptions
from paint3d.files.filaments import (
    choose_filaments,
    choose_for_triangles,
    split_by_filament,
)
from paint3d.files.finish import Texture
from paint3d.files.formats.gltf import find_steps
from paint3d.files.load import UNITS_MM
from paint3d.files.progress import Progress, part_of
from paint3d.files.texture import Detail, bake_detail
from paint3d.mesh.sheet_mesh import sheet_of
from paint3d.mesh.triangle_mesh import MAX_COORDINATE_MM, TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.edges import Edges, edge_shares

__all__ = [
    "Exportable",
    "InLight",
    "Painting",
    "PlainSurface",
    "Untextured",
    "look_of",
    "read_painting",
    "warn_of_clipping",
]

# ---- In another light ----------------------------------------------------------------------------
# A painting as it looks in another light, by another observer, or on a wider screen.


log = logging.getLogger("paint3d")
_OWN_LIGHT = Viewing()


class InLight:
    """A surface to export, with the colours that it has in another light.

    Parameters
    ----------
    surface : Exportable
        A `PaintedSurface`, whose spectra are known, or a mesh, whose colours get the smooth
        spectra that have them under D65.
    viewing : Viewing
    """

    def __init__(self, surface: Any, viewing: Viewing) -> None:
        self._surface, self._viewing = surface, viewing
        self.material = surface.material

    @cached_property
    def seen(self) -> Codes:
        """Codes of every vertex, and how many are out of gamut."""
        return codes_in_light(self._surface, self._viewing)

    @property
    def srgb(self) -> NDArray[np.uint8]:
        """(V, 3) codes, of the gamut."""
        return self.seen.rgb

    @property
    def vertex_areas(self) -> NDArray[np.float64]:
        """(V,) mm2."""
        areas: NDArray[np.float64] = self._surface.vertex_areas
        return areas

    @property
    def wet_look(self) -> WetLook | None:
        """Wet look of the surface."""
        return look_of(self._surface, None)

    def look_on(self, roughness: float) -> WetLook | None:
        """Wet look of the surface on a material so rough."""
        return look_of(self._surface, roughness)

    @property
    def paint_mesh(self) -> Any:
        """Mesh of the surface, of one that has a wet look."""
        return self._surface.paint_mesh

    def export_ids(
        self, tolerance: float | None, srgb: NDArray[np.uint8], progress: Progress | None = None
    ) -> tuple[AnyArray, AnyArray]:
        """Vertices and faces to export of the surface, of one that has a wet look."""
        ids_and_faces: tuple[AnyArray, AnyArray] = self._surface.export_ids(
            tolerance, srgb, progress
        )
        return ids_and_faces

    def export_arrays(
        self,
        tolerance: float | None = 1.0,
        srgb: NDArray[np.uint8] | None = None,
        progress: Progress | None = None,
    ) -> tuple[AnyArray, AnyArray, AnyArray, AnyArray]:
        """Arrays of the surface, with these colours."""
        codes = self.srgb if srgb is None else srgb
        arrays: tuple[AnyArray, AnyArray, AnyArray, AnyArray]
        options = {} if progress is None else {"progress": progress}
        arrays = self._surface.export_arrays(tolerance, codes, **options)
        return arrays

    def detail_arrays(self) -> tuple[AnyArray, ...]:
        """Detail arrays of the surface, with these colours."""
        return *self._surface.detail_arrays()[:-1], self.srgb


def look_of(surface: Any, roughness: float | None) -> WetLook | None:
    """Wet look of a surface to export, on its own material or one so rough; None: dry."""
    look: WetLook | None
    if roughness is None:
        look = getattr(surface, "wet_look", None)
    else:
        look = getattr(surface, "look_on", lambda _: None)(roughness)
    return look


def codes_in_light(surface: Any, viewing: Viewing) -> Codes:
    """Codes (V, 3) of a surface's vertices; see `InLight`."""
    spectra = getattr(surface, "spectra", None)
    if spectra is not None:
        return viewing.codes_of(len(surface.srgb), spectra)
    codes = surface.srgb
    if viewing.is_plain:
        return Codes(codes, 0)
    primaries = srgb_primaries().T
    return viewing.codes_of(len(codes), lambda ids: decode_srgb(codes[ids]) @ primaries)


_FEW_CLIPPED = 0.1  # of the painted vertices, in the painting's own light


def warn_of_clipping(surface: Any, viewing: Viewing | None) -> int:
    """Warn of colours that a gamut does not hold, where they are no few; return how many.

    A seal or a blossom on a painting in black is nothing to report.
    """
    if isinstance(surface, InLight):
        n_clipped, n = surface.seen.n_clipped, len(surface.srgb)
    elif hasattr(surface, "spectra"):
        ids = np.flatnonzero(surface.painted).astype(np.int32)
        if not may_leave_srgb(surface.pigments):
            return 0
        codes = _OWN_LIGHT.codes_of(len(ids), lambda some: surface.spectra(ids[some]))
        n_clipped, n = codes.n_clipped, surface.n_vertices
        if n_clipped < _FEW_CLIPPED * len(ids):
            return n_clipped
    else:
        return 0
    if n_clipped:
        gamut = GAMUTS[viewing.gamut if viewing is not None else "srgb"].title
        wider = " (--gamut p3 or rec2020 keeps more)" if gamut == "sRGB" else ""
        log.warning(
            "%s of %s vertices have colours outside %s and are shown in the nearest that it has%s",
            f"{n_clipped:,}", f"{n:,}", gamut, wider,
        )  # fmt: skip
    return n_clipped


def may_leave_srgb(pigments: Any) -> bool:
    """Return whether any pigment has a colour: black and water leave no gamut."""
    return any(np.ptp(p.K) > 0.0 or np.ptp(p.S) > 0.0 for p in pigments)


# ---- The painting --------------------------------------------------------------------------------


UNIT_LENGTH = 1e-6  # a normal nearer to length 1 than this is left as it is


class Exportable(Protocol):
    """Interface of what can be exported: PaintedSurface, or anything with its arrays."""

    @property
    def material(self) -> object:
        """The material; its ``name`` goes into the file and chooses the shine."""
        ...

    @property
    def srgb(self) -> NDArray[np.uint8]:
        """Codes of every vertex, (V, 3)."""
        ...

    @property
    def vertex_areas(self) -> NDArray[np.float64]:
        """Area that each vertex stands for, (V,) mm2."""
        ...

    def export_arrays(
        self,
        tolerance: float | None = 1.0,
        srgb: NDArray[np.uint8] | None = None,
        progress: Progress | None = None,
    ) -> tuple[AnyArray, AnyArray, AnyArray, AnyArray]:
        """Return vertices (K, 3) mm, faces (F, 3), unit normals (K, 3) and sRGB codes (K, 3).

        Parameters
        ----------
        tolerance : float or None
            dE00 by which colours may be missed; None for all vertices.
        srgb : (V, 3) uint8, optional
            Codes to export instead of the painting's own.
        progress : callable, optional
            Called with the fraction done, now and then; what it raises stops it.
        """
        ...


class Painting(NamedTuple):
    """Arrays of a painting, names of its material and file, its texture or filaments if any.

    `finish` is how rough the material is and how strong its glaze, None where it does not say it.
    `steps` (V,) lead from metres back to millimetres where float32 has lost them; see
    `paint3d.files.formats.gltf`. `gamut` is what the codes mean. `look` is how wet and
    glossy vertices are, None where all are as the material; `srgb` is of the dry painting.
    `n_clipped` vertices have colours outside the gamut. `edges` say where paint ends between
    vertices, None where nobody knows. `is_sheet` says whether it is a flat sheet of those by name.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32]
    srgb: NDArray[np.uint8]
    material: str
    title: str = "painting"
    texture: Texture | None = None
    palette: NDArray[np.uint8] | None = None
    face_filaments: NDArray[np.int32] | None = None
    steps: NDArray[np.float32] | None = None
    finish: tuple[float, float] | None = None
    gamut: str = "srgb"
    look: WetLook | None = None
    n_clipped: int = 0
    edges: Edges | None = None
    is_sheet: bool = False

    @property
    def shown_srgb(self) -> NDArray[np.uint8]:
        """(V, 3) codes, darker where it is wet."""
        return self.srgb if self.look is None else self.look.seen(self.srgb)

    def converted(self, unit: str, up_axis: str) -> Painting:
        """Return the painting in another unit, with another axis up; it is in mm with z up."""
        vertices, normals, steps = self.vertices, self.normals, None
        if up_axis == "y":  # a turn by -90 degrees about x
            vertices, normals = (
                np.stack([v[:, 0], v[:, 2], -v[:, 1]], axis=1) for v in (vertices, normals)
            )
        if unit != "mm":
            in_mm, vertices = vertices, (vertices / UNITS_MM[unit]).astype(np.float32)
            steps = find_steps(in_mm, vertices) if unit == "m" else None
        return self._replace(vertices=vertices, normals=normals, steps=steps)


class PlainSurface:
    """An unpainted mesh with its own colours, as something to export; white without colours."""

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self.material = None
        white = np.full((mesh.n_vertices, 3), 255, np.uint8)
        self.srgb = white if mesh.colours is None else mesh.colours

    @property
    def vertex_areas(self) -> NDArray[np.float64]:
        """(V,) mm2."""
        areas = np.zeros(self.mesh.n_vertices)
        for corner in range(3):
            np.add.at(areas, self.mesh.faces[:, corner], self.mesh.double_areas / 6.0)
        return areas

    def export_arrays(
        self,
        tolerance: float | None = 1.0,
        srgb: NDArray[np.uint8] | None = None,
        progress: Progress | None = None,
    ) -> tuple[AnyArray, AnyArray, AnyArray, AnyArray]:
        """Return the mesh's arrays as they are; none of its vertices was added for painting."""
        mesh = self.mesh
        normals = _smooth_normals(mesh) if mesh.normals is None else mesh.normals
        return mesh.vertices, mesh.faces, normals, self.srgb if srgb is None else srgb

    def detail_arrays(self) -> tuple[AnyArray, ...]:
        """Return the mesh, and the mesh again as what is painted on it."""
        mesh = self.mesh
        vertices, faces, normals, srgb = self.export_arrays()
        sound = mesh.double_areas > 0.0
        owners = np.arange(np.count_nonzero(sound), dtype=np.int32)
        return vertices, faces[sound], normals, vertices, faces[sound], owners, srgb


def _smooth_normals(mesh: TriangleMesh) -> NDArray[np.float64]:
    """Return vertex normals (V, 3), not yet of length 1: the faces' by area."""
    normals = np.zeros((mesh.n_vertices, 3))
    weighted = mesh.face_normals * mesh.double_areas[:, None]
    for corner in range(3):
        np.add.at(normals, mesh.faces[:, corner], weighted)
    return normals


class Untextured(NamedTuple):
    """A surface's arrays whose colours are still to be baked into a texture."""

    detail: Detail
    size: int | None
    material: str
    finish: tuple[float, float] | None = None
    n_clipped: int = 0
    look: WetLook | None = None

    def baked(self) -> Painting:
        """Return the painting with its texture; on a large object this takes long."""
        pictures, look = [self.detail[-1]], self.look
        if look is not None:
            fractions = np.stack([look.film, look.gloss, look.hidden], axis=1)
            pictures = [look.seen(pictures[0]), np.rint(255.0 * fractions).astype(np.uint8)]
        mesh, images = bake_detail((*self.detail[:-1], *pictures), self.size)
        white = np.full((len(mesh.vertices), 3), 255, np.uint8)
        painting = _check_arrays((mesh.vertices, mesh.faces, mesh.normals, white), self.material)
        texture = Texture(mesh.uv, images[0])
        if look is not None:
            film, gloss, hidden = np.moveaxis(images[1], 2, 0).astype(np.float32) / np.float32(
                255.0
            )
            damp = np.zeros_like(film)  # is in the colours
            texture = texture._replace(look=WetLook(film, damp, gloss, hidden))
        return painting._replace(texture=texture, finish=self.finish)


def read_painting(
    surface: Exportable | TriangleMesh,
    options: ExportOptions,
    progress: Progress | None = None,
    roughness: float | None = None,
) -> Painting | Untextured:
    """Read a surface's arrays for writing, checked; it may be painted on afterwards.

    `progress` is given the fraction done; what it raises stops it. `roughness` is of a material
    that it is to be shown on instead of its own.

    Raises
    ------
    MeshError
        If its arrays do not fit each other.
    """
    if isinstance(surface, TriangleMesh):
        surface = PlainSurface(surface)
    is_sheet = isinstance(surface, PaintedSurface) and sheet_of(surface.source) is not None
    viewing = options.viewing
    if viewing is not None and not viewing.is_plain:
        surface = InLight(surface, viewing)
    n_clipped = warn_of_clipping(surface, viewing)
    painting = _read_surface(surface, options, progress, roughness)
    if isinstance(painting, Painting):
        gamut = options.gamut or "srgb"
        return painting._replace(gamut=gamut, n_clipped=n_clipped, is_sheet=is_sheet)
    return painting._replace(n_clipped=n_clipped)


def _read_surface(
    surface: Exportable,
    options: ExportOptions,
    progress: Progress | None,
    roughness: float | None,
) -> Painting | Untextured:
    material = str(getattr(surface.material, "name", "painting"))
    finish = _finish_of(surface.material)
    if options.texture:
        size = None if options.texture is True else int(options.texture)
        look = look_of(surface, roughness)
        return Untextured(_copy_detail(surface), size, material, finish, look=look)
    if options.filaments is None:
        tolerance = None if options.exact else options.tolerance
        look = look_of(surface, roughness)
        if look is not None or (isinstance(surface, PaintedSurface) and surface.painted.any()):
            return _read_painted(surface, look, tolerance, progress)
        arrays = surface.export_arrays(tolerance, **_progress_option(progress))
        return _check_arrays(arrays, material)._replace(finish=finish)
    filaments = choose_filaments(surface.srgb, surface.vertex_areas, options.filaments)
    codes = filaments.palette[filaments.chosen]
    reporting = _progress_option(part_of(progress, 0.3, 1.0))
    arrays = surface.export_arrays(None if options.exact else 0.0, codes, **reporting)
    painting = _check_arrays(arrays, material)._replace(finish=finish)
    return _reduce_to_filaments(painting, filaments.palette)


def _read_painted(
    surface: Any, look: WetLook | None, tolerance: float | None, progress: Progress | None
) -> Painting:
    """Read a painting that has edges, or a `look`: wet parts, or such that dried with a gloss."""
    codes, mesh = surface.srgb, surface.paint_mesh
    ids, faces = surface.export_ids(
        tolerance, codes if look is None else look.seen(codes), progress
    )
    painting = _check_arrays(
        (mesh.vertices[ids], faces, mesh.normals[ids], codes[ids]), surface.material.name
    )
    edges = None
    if isinstance(surface, PaintedSurface):  # else in another light, in which nothing is bare
        fractions = edge_shares(mesh.leaf_faces(), surface.coverage_codes())
        edges = Edges(surface.bare_codes[ids], fractions[ids])
    look = None if look is None else look.at(ids)
    return painting._replace(finish=_finish_of(surface.material), look=look, edges=edges)


def _finish_of(material: object) -> tuple[float, float] | None:
    roughness, coat = getattr(material, "roughness", None), getattr(material, "coat", None)
    if not isinstance(roughness, float) or not isinstance(coat, float):
        return None
    return roughness, coat


def _copy_detail(surface: Exportable) -> Detail:
    """Copies of the arrays that a texture is baked from.

    Raises
    ------
    ExportError
        If the surface does not say it.
    """
    arrays = getattr(surface, "detail_arrays", None)
    if arrays is None:
        kind = type(surface).__name__
        raise ExportError(
            "a texture is laid on a PaintedSurface or TriangleMesh; got a {kind}",
            kind=kind,
        )
    return cast("Detail", tuple(np.array(array) for array in arrays()))


def _progress_option(progress: Progress | None) -> dict[str, Any]:
    """Keyword argument for `export_arrays`; a surface need not know of progress."""
    return {} if progress is None else {"progress": progress}


def _reduce_to_filaments(painting: Painting, palette: NDArray[np.uint8]) -> Painting:
    """Return a painting whose codes are of the palette, with one filament a triangle."""
    weights = np.array([65536, 256, 1])
    packed, order = palette @ weights, np.argsort(palette @ weights, kind="stable")
    chosen = order[np.searchsorted(packed, painting.srgb @ weights, sorter=order)]
    face_filaments = choose_for_triangles(painting.faces, chosen, palette)
    ids, faces, filament = split_by_filament(painting.faces, face_filaments, len(palette))
    return painting._replace(
        vertices=painting.vertices[ids],
        faces=faces,
        normals=painting.normals[ids],
        srgb=palette[filament],
        palette=palette,
        face_filaments=face_filaments,
    )


def _check_arrays(arrays: tuple[AnyArray, AnyArray, AnyArray, AnyArray], material: str) -> Painting:
    vertices = as_array(arrays[0], "vertices", (None, 3), np.float32, MeshError)
    faces = as_array(arrays[1], "faces", (None, 3), np.int32, MeshError)
    shape = (len(vertices), 3)
    if len(faces) == 0:
        raise MeshError("there are no faces; expected at least one triangle")
    if faces.min() < 0 or faces.max() >= len(vertices):
        bad = faces.min() if faces.min() < 0 else faces.max()
        raise MeshError(
            "a face refers to vertex {bad}; expected 0 to {last}",
            bad=bad,
            last=len(vertices) - 1,
        )
    farthest = np.abs(vertices).max()
    if farthest > MAX_COORDINATE_MM:
        raise MeshError(
            "a coordinate is {farthest:g} mm; expected {most:g} at most",
            farthest=farthest,
            most=MAX_COORDINATE_MM,
        )
    normals = _normalise(as_array(arrays[2], "normals", shape, np.float32, MeshError))
    srgb = arrays[3]
    srgb = np.ascontiguousarray(srgb)
    if srgb.dtype != np.uint8 or srgb.shape != shape:
        raise MeshError(
            "srgb is {srgb_dtype} {srgb_shape}; expected uint8 {shape}",
            srgb_dtype=srgb.dtype,
            srgb_shape=srgb.shape,
            shape=shape,
        )
    return Painting(vertices, faces, normals, srgb, material)


def _normalise(normals: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return normals of length 1; vertices without one, which no face uses, point up."""
    length = np.sqrt(np.einsum("ij,ij->i", normals, normals, dtype=np.float64))
    off = np.flatnonzero(np.abs(length - 1.0) > UNIT_LENGTH)
    if len(off) == 0:
        return normals
    unit = normals.copy()
    none = length[off] == 0.0
    unit[off] = normals[off] / np.where(none, 1.0, length[off])[:, None]
    unit[off[none]] = (0.0, 0.0, 1.0)
    return unit
