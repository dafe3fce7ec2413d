"""The object to be painted: triangles in millimetres, validated once and immutable."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_array
from paint3d.errors import MeshError
from paint3d.mesh.body_axis import find_axis
from paint3d.mesh.kernels.topology import pieces_of

__all__ = ["TriangleMesh"]

MAX_COORDINATE_MM = 1e12  # a million km: larger sizes come from broken files
_BLOCK = 1 << 18  # faces measured at a time


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """An immutable triangle mesh; the constructor checks all that later stages rely on.

    Attributes
    ----------
    vertices : (V, 3) float32
        Positions, mm.
    faces : (F, 3) int32
        Vertex indices, counter-clockwise seen from outside.
    colours : (V, 3) uint8 or None
        sRGB of the bare object, where its file gave colours.
    name : str
        Name of the object in messages and reports.
    normals : (V, 3) float32 or None
        Unit normals as the file gave them. They may disagree with the faces.

    Raises
    ------
    MeshError
        If there are no vertices or no faces, a vertex is not finite, an index is out of range,
        or an array has the wrong shape or length.

    Notes
    -----
    The arrays are private read-only copies or views, so a mesh may be shared between threads
    and used as a key by identity. Faces without area are allowed, since files have them; whether
    there is anything to paint is for `PaintMesh` to say.

    Examples
    --------
    >>> import paint3d
    >>> mesh = paint3d.TriangleMesh([(0, 0, 0), (40, 0, 0), (0, 40, 0)], [(0, 1, 2)], name="corner")
    >>> paint3d.PaintedSurface(mesh, resolution=0.8).n_vertices
    3
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    colours: NDArray[np.uint8] | None = None
    name: str = "mesh"
    normals: NDArray[np.float32] | None = None

    if TYPE_CHECKING:  # the constructor takes more types than the fields hold

        def __init__(
            self,
            vertices: ArrayLike,
            faces: ArrayLike,
            colours: ArrayLike | None = None,
            name: str = "mesh",
            normals: ArrayLike | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        vertices = _check_vertices(self.vertices)
        faces = _check_faces(self.faces, len(vertices))
        self._set("vertices", vertices)
        self._set("faces", faces)
        if self.colours is not None:
            self._set("colours", _check_colours(self.colours, len(vertices)))
        if self.normals is not None:
            shape = (len(vertices), 3)
            self._set("normals", as_array(self.normals, "normals", shape, np.float32, MeshError))

    def _set(self, field: str, array: AnyArray) -> None:
        array = array.copy() if array.flags.writeable else array.view()
        array.setflags(write=False)
        object.__setattr__(self, field, array)

    @property
    def n_vertices(self) -> int:
        """Number of vertices V."""
        return len(self.vertices)

    @property
    def n_faces(self) -> int:
        """Number of faces F."""
        return len(self.faces)

    def _cross_products(self) -> Iterator[tuple[slice, NDArray[np.float64]]]:
        """Yield cross products of two edges of each face, block by block to save memory."""
        for start in range(0, self.n_faces, _BLOCK):
            block = slice(start, start + _BLOCK)
            a, b, c = (self.vertices[self.faces[block, k]].astype(np.float64) for k in range(3))
            yield block, np.cross(b - a, c - a)

    @cached_property
    def double_areas(self) -> NDArray[np.float64]:
        """Twice the area of each face: (F,), mm^2."""
        areas = np.empty(self.n_faces)
        for block, cross in self._cross_products():
            areas[block] = np.sqrt(np.einsum("ij,ij->i", cross, cross))
        return areas

    @cached_property
    def face_normals(self) -> NDArray[np.float64]:
        """Unit normals of the faces: (F, 3); zero where a face has no area."""
        normals = np.empty((self.n_faces, 3))
        for block, cross in self._cross_products():
            length = self.double_areas[block, None]
            normals[block] = cross / np.where(length > 0.0, length, 1.0)
        return normals

    @property
    def area(self) -> float:
        """Area of all faces, mm^2."""
        return 0.5 * float(self.double_areas.sum())

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """Lowest and highest corner of the axis-aligned box: (2, 3), mm."""
        along = self.vertices.T  # axis by axis: rows of three are ten times as slow
        box = np.array([[x.min() for x in along], [x.max() for x in along]], np.float64)
        box.setflags(write=False)
        return box

    @cached_property
    def body_axis(self) -> tuple[float, float]:
        """Vertical axis of its body, which a handle does not move: x and y, mm."""
        return find_axis(self.vertices, self.faces, self.bounds)

    @cached_property
    def is_solid(self) -> bool:
        """Whether it is closed with outward normals, so that no face shows its back outside.

        Every edge is used as often in one direction as in the other, and each connected piece
        encloses a volume that its normals point out of. A cavity inside disqualifies it.
        """
        start = self.faces.ravel().astype(np.int64)
        end = np.roll(self.faces, -1, axis=1).ravel().astype(np.int64)
        n = self.n_vertices
        if not np.array_equal(np.sort(start * n + end), np.sort(end * n + start)):
            return False
        piece = pieces_of(self.faces, n)
        middle = self.bounds.mean(axis=0)
        cones = np.empty(self.n_faces)
        for block, cross in self._cross_products():
            corner = self.vertices[self.faces[block, 0]] - middle
            cones[block] = np.einsum("ij,ij->i", corner, cross)
        return bool((np.bincount(piece, cones)[np.unique(piece)] > 0.0).all())


def _check_vertices(values: ArrayLike) -> NDArray[np.float32]:
    vertices = as_array(values, "vertices", (None, 3), np.float64, MeshError)
    if len(vertices) == 0:
        raise MeshError("vertices is empty; expected at least 3")
    largest = float(np.abs(vertices).max())
    if largest > MAX_COORDINATE_MM:
        raise MeshError(
            "a coordinate is {largest:g} mm; expected at most {most:g} mm",
            largest=largest, most=MAX_COORDINATE_MM,
        )  # fmt: skip
    return vertices.astype(np.float32)


def _check_faces(values: ArrayLike, n_vertices: int) -> NDArray[np.int32]:
    array = np.asarray(values)
    if array.dtype.kind not in "iu" and array.size:
        raise MeshError("faces has type {dtype}; expected integers", dtype=array.dtype)
    if array.size == 0:
        raise MeshError("no faces; expected at least one triangle")
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError("faces has shape {shape}; expected (any, 3)", shape=array.shape)
    low, high = int(array.min()), int(array.max())
    if low < 0 or high >= n_vertices:
        bad = low if low < 0 else high
        face = int(np.argwhere(array == bad)[0, 0])
        raise MeshError(
            "face {face} refers to vertex {bad}; expected 0 to {last}",
            face=face, bad=bad, last=n_vertices - 1,
        )  # fmt: skip
    return np.ascontiguousarray(array, dtype=np.int32)


def _check_colours(values: ArrayLike, n_vertices: int) -> NDArray[np.uint8]:
    array = np.asarray(values)
    if array.dtype != np.uint8:
        raise MeshError("colours has type {dtype}; expected uint8 sRGB codes", dtype=array.dtype)
    if array.shape != (n_vertices, 3):
        raise MeshError(
            "colours has shape {shape}; expected ({n}, 3)", shape=array.shape, n=n_vertices
        )
    return array
