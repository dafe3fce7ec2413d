"""Refinement of a mesh until the colours of its vertices show its materials' pictures.

Triangles are halved at their longest edges where straight lines between their corners' colours
miss the picture, the most visible first, until the picture is met, its pixels are reached, or
there are as many vertices as may be. Where those do not suffice, a vertex has the mean colour
around it, so that what is too fine for the mesh turns into its mean and not into noise.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.files.colours import Look, linear_from_srgb, srgb_from_linear
from paint3d.mesh.polygons import face_normals

__all__ = ["MOST_VERTICES", "Draped", "Pictured", "show_pictures"]

MOST_VERTICES = 200_000
_SEEN = 10.0  # sRGB codes by which a colour may be missed
_FINEST = 1.0 / 1500.0  # of the object's size: shorter edges are not halved
_PIXEL = 0.8  # pixels: nor are edges that are so short on the picture
_SEAM = 24  # codes: corners of a vertex that differ by more do not share a colour
_ROUNDS = 40
_FARTHEST = 1e4  # pictures side by side: coordinates farther out are damaged, and count as unknown
_CREASE_ANGLE = np.deg2rad(40.0)  # as `paint3d.mesh.base_surface` has it
_GRIDS = (2, 4, 8, 16, 24)  # steps along an edge at which a triangle's picture is looked at
_AT_ONCE = 1 << 20  # points


class Draped(NamedTuple):
    """Pictures on the faces of a mesh.

    Attributes
    ----------
    uv : (F, 3, 2) float64
        Place of each corner on the picture of its face's look; nan where unknown.
    look : (F,) int64
        -1 for faces without a material, which are white.
    looks : sequence of Look
    """

    uv: NDArray[np.float64]
    look: NDArray[np.int64]
    looks: Sequence[Look]


class Pictured(NamedTuple):
    """Vertices (V, 3), faces (F, 3), colours (V, 3) uint8 and normals (V, 3) or None."""

    vertices: AnyArray
    faces: AnyArray
    colours: NDArray[np.uint8]
    normals: AnyArray | None


class _Mesh:
    """A triangle mesh under refinement by bisection.

    Attributes
    ----------
    points : (W, 3) float64
        Distinct positions.
    point_of : (V,) int64
        Index of each vertex's position in `points`; several may have the same.
    faces : (F, 3) int64
        Vertices.
    uv : (F, 3, 2) float64
    look : (F,) int64
    own : (V, C) float64
        What is mixed along edges: the vertices' own linear colours, their normals.
    """

    def __init__(
        self,
        vertices: AnyArray,
        faces: NDArray[np.int64],
        uv: NDArray[np.float64],
        look: NDArray[np.int64],
        own: NDArray[np.float64],
    ) -> None:
        single = np.ascontiguousarray(vertices, np.float32) + np.float32(0.0)
        rows = single.view([("x", "f4"), ("y", "f4"), ("z", "f4")]).ravel()
        _, first, self.point_of = np.unique(rows, return_index=True, return_inverse=True)
        self.points = single[first].astype(np.float64)
        self.faces, self.uv, self.look, self.own = faces, uv, look, own
        self.error = np.full(len(faces), np.nan)

    def lengths(self) -> NDArray[np.float64]:
        """(F, 3) float64: of the edges from each corner to the next."""
        corners = self.points[self.point_of[self.faces]]
        result: NDArray[np.float64] = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        return result

    def pixel_lengths(self, sizes: AnyArray) -> NDArray[np.float64]:
        """(F, 3) float64: the same on the picture, in pixels; sizes (L + 1, 2)."""
        corners = self.uv * sizes[self.look][:, None]
        result: NDArray[np.float64] = np.nan_to_num(
            np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        )
        return result

    def edges(self) -> tuple[NDArray[np.int64], int]:
        """(F, 3) int64 edges from each corner to the next, alike where positions are; how many."""
        ends = self.point_of[self.faces]
        after = np.roll(ends, -1, axis=1)
        code = np.minimum(ends, after) * len(self.points) + np.maximum(ends, after)
        known, ids = np.unique(code.ravel(), return_inverse=True)
        return ids.reshape(-1, 3), len(known)

    def halve(self, edges: AnyArray, marked: AnyArray, longest: AnyArray) -> None:
        """Halve the marked edges (E,) bool; a face with one has its longest (F,) marked too."""
        rows = np.arange(len(self.faces))
        turn = (longest[:, None] + np.arange(3)) % 3  # the longest edge first: a, b, then c
        ids = np.take_along_axis(edges, turn, axis=1)
        split = marked[ids[:, 0]]
        position = np.full(len(marked), -1, np.int64)
        position[marked] = len(self.points) + np.arange(np.count_nonzero(marked))
        whole = ~split
        parts = [_Part(self.faces[whole], self.uv[whole], rows[whole], self.error[whole])]
        ids, rows, turn = ids[split], rows[split], turn[split]
        faces = np.take_along_axis(self.faces[split], turn, axis=1)
        uv = np.take_along_axis(self.uv[split], turn[..., None], axis=1)
        middle, ends = self._middles(faces, position[ids], marked[ids])
        new_points = np.empty((np.count_nonzero(marked), 3))
        new_points[position[ids[marked[ids]]] - len(self.points)] = self.points[
            self.point_of[ends]
        ].mean(axis=1)
        halfway = 0.5 * (uv + np.roll(uv, -1, axis=1))
        a, b, c = ((faces[:, k], uv[:, k]) for k in range(3))
        ab, bc, ca = ((middle[:, k], halfway[:, k]) for k in range(3))
        second, third = marked[ids[:, 1]], marked[ids[:, 2]]
        every: tuple[tuple[Any, AnyArray], ...]
        every = ((a, ab, c), ~third), ((a, ab, ca), third), ((ca, ab, c), third)
        every += ((ab, b, c), ~second), ((ab, b, bc), second), ((ab, bc, c), second)
        parts += [_make_part(corners, chosen, rows) for corners, chosen in every]
        self.points = np.concatenate([self.points, new_points])
        origin = np.concatenate([p.rows for p in parts])
        self.faces = np.concatenate([p.faces for p in parts])
        self.uv = np.concatenate([p.uv for p in parts])
        self.look = self.look[origin]
        self.error = np.concatenate([p.error for p in parts])

    def _middles(
        self, faces: AnyArray, position: AnyArray, marked: AnyArray
    ) -> tuple[AnyArray, AnyArray]:
        """New vertices (F, 3) on the marked edges (-1: none), and the ends (M, 2) of each."""
        after = np.roll(faces, -1, axis=1)
        low, high = np.minimum(faces, after)[marked], np.maximum(faces, after)[marked]
        code = low * len(self.point_of) + high
        _, first, which = np.unique(code, return_index=True, return_inverse=True)
        middle = np.full(faces.shape, -1, np.int64)
        middle[marked] = len(self.point_of) + which
        own = 0.5 * (self.own[low[first]] + self.own[high[first]])
        self.own = np.concatenate([self.own, own])
        self.point_of = np.concatenate([self.point_of, position[marked][first]])
        return middle, np.stack([low, high], axis=1)


class _Part(NamedTuple):
    faces: AnyArray
    uv: AnyArray
    rows: AnyArray  # of the faces they come from
    error: AnyArray


def _make_part(
    corners: Sequence[tuple[AnyArray, AnyArray]], chosen: AnyArray, rows: AnyArray
) -> _Part:
    faces = np.stack([vertex[chosen] for vertex, _ in corners], axis=1)
    uv = np.stack([position[chosen] for _, position in corners], axis=1)
    return _Part(faces, uv, rows[chosen], np.full(len(faces), np.nan))


def show_pictures(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    draped: Draped,
    colours: NDArray[np.uint8] | None = None,
    normals: NDArray[np.float64] | None = None,
    most: int = MOST_VERTICES,
    corner_colours: NDArray[np.uint8] | None = None,
) -> Pictured:
    """Refine a mesh where its pictures ask for it, and colour its vertices after them.

    Parameters
    ----------
    vertices : (V, 3) float64
    faces : (F, 3) int64
    draped : Draped
    colours : (V, 3) uint8, optional
        Of the vertices; linear light is multiplied.
    normals : (V, 3) float64, optional
        Mixed along edges.
    most : int
        Vertices, nearly, beyond those that there are.
    corner_colours : (F, 3, 3) uint8, optional
        Of the corners, instead of `colours`: a vertex whose corners differ becomes several.

    Returns
    -------
    Pictured
        The vertices given come first, in their order, as far as each has one colour.
    """
    if corner_colours is not None:
        codes = corner_colours.reshape(-1, 3).astype(np.int64)
        faces, source = _split(faces, codes @ np.array([65536, 256, 1]), len(vertices))
        vertices = vertices[source]
        normals = None if normals is None else normals[source]
        colours = np.full((len(source), 3), 255, np.uint8)
        colours[faces.ravel()] = codes
    n = len(vertices)
    own = np.ones((n, 3)) if colours is None else linear_from_srgb(colours)
    own = np.hstack([own, np.zeros((n, 3)) if normals is None else normals])
    uv, look, looks = draped
    uv = np.where(np.abs(uv) <= _FARTHEST, uv, np.nan)
    lost = np.asarray(np.isnan(uv).any(axis=(1, 2)))
    plain = {k: Look(one.factor) for k, one in enumerate(looks)}
    looks = [*looks, *plain.values(), Look()]
    look = np.where(look < 0, len(looks) - 1, np.where(lost, look + len(plain), look))
    mesh = _Mesh(vertices, faces, np.where(lost[:, None, None], 0.0, uv), look, own)
    sizes = np.array([one.texels() for one in looks], np.float64)
    if sizes.any():
        if normals is None:
            _smooth_normals(mesh)
        _refine(mesh, looks, sizes, n + most)
    return _colour_vertices(mesh, looks, sizes, normals is not None or bool(sizes.any()))


def _smooth_normals(mesh: _Mesh) -> None:
    """Copy the normals of the coarse mesh to corners, so that its flat parts stay as round.

    Faces that turn by less than 40 degrees share them.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    corners = mesh.points[mesh.point_of[mesh.faces]]
    unit = face_normals(corners)
    edges, _ = mesh.edges()
    order = np.argsort(edges.ravel(), kind="stable")
    first = np.searchsorted(edges.ravel()[order], np.flatnonzero(np.bincount(edges.ravel()) == 2))
    one, two = order[first], order[first + 1]
    smooth = np.einsum("ij,ij->i", unit[one // 3], unit[two // 3]) > np.cos(_CREASE_ANGLE)
    one, two = one[smooth], two[smooth]
    after = np.array([1, 2, 0])
    ends = mesh.point_of[mesh.faces].ravel()
    one_next, two_next = one - one % 3 + after[one % 3], two - two % 3 + after[two % 3]
    against = ends[one] == ends[two_next]  # as neighbours are, unless one is inside out
    links = (
        np.concatenate([one, one_next]),
        np.where(
            np.concatenate([against, against]),
            np.concatenate([two_next, two]),
            np.concatenate([two, two_next]),
        ),
    )
    n = 3 * len(mesh.faces)
    graph = coo_matrix((np.ones(len(links[0]), np.int8), links), shape=(n, n))
    _, group = connected_components(graph, directed=False)
    weighted = _angles(corners).reshape(-1, 1) * np.repeat(unit, 3, axis=0)
    normals = np.stack([np.bincount(group, weighted[:, k]) for k in range(3)], axis=1)
    faces, source = _split(mesh.faces, group, len(mesh.point_of))
    mesh.own, mesh.point_of = mesh.own[source], mesh.point_of[source]
    mesh.own[faces.ravel(), 3:] = normals[group]
    mesh.own[:, 3:] /= np.maximum(np.linalg.norm(mesh.own[:, 3:], axis=1, keepdims=True), 1e-300)
    mesh.faces = faces


def _angles(corners: AnyArray) -> AnyArray:
    """(F, 3) angles at the corners (F, 3, 3), rad."""
    along = np.roll(corners, -1, axis=1) - corners
    back = np.roll(corners, 1, axis=1) - corners
    across = np.linalg.norm(np.cross(along, back), axis=2)
    result: AnyArray = np.arctan2(across, np.einsum("fij,fij->fi", along, back))
    return result


def _split(faces: AnyArray, key: AnyArray, n: int) -> tuple[AnyArray, AnyArray]:
    """Split vertices whose corners have different keys (3 F,); return faces and sources (K,).

    Of a vertex (n,) that becomes several, one keeps its number.
    """
    ids = faces.ravel()
    pair = ids * (int(key.max(initial=0)) + 1) + key
    known, first, which = np.unique(pair, return_index=True, return_inverse=True)
    owner = ids[first]
    leads = np.concatenate([[True], owner[1:] != owner[:-1]])[: len(owner)]
    number = np.empty(len(known), np.int64)
    number[leads] = owner[leads]
    number[~leads] = n + np.arange(np.count_nonzero(~leads))
    return number[which].reshape(-1, 3), np.concatenate([np.arange(n), owner[~leads]])


def _refine(mesh: _Mesh, looks: Sequence[Look], sizes: AnyArray, most: int) -> None:
    finest = _FINEST * float(np.ptp(mesh.points, axis=0).max())
    for _ in range(_ROUNDS):
        pixels = mesh.pixel_lengths(sizes)
        fresh = np.flatnonzero(np.isnan(mesh.error))
        mesh.error[fresh] = _measure_misses(mesh, fresh, looks, pixels[fresh].max(axis=1))
        lengths = mesh.lengths()
        longest = lengths.argmax(axis=1)
        span = lengths.max(axis=1)
        wanted = mesh.error > _SEEN
        wanted &= (span > 2.0 * finest) & (pixels.max(axis=1) > 2.0 * _PIXEL)
        remaining = most - len(mesh.point_of)
        if not wanted.any() or remaining < 16:
            return
        edges, n_edges = mesh.edges()
        rows = np.arange(len(edges))
        chosen = np.flatnonzero(wanted)
        worst = np.argsort(-(mesh.error[chosen] * span[chosen] ** 2), kind="stable")
        marked = np.zeros(n_edges, bool)
        # halving one face halves its neighbours too: about one new vertex for each that is chosen
        marked[edges[rows, longest][chosen[worst[:remaining]]]] = True
        while True:
            more = marked[edges].any(axis=1) & ~marked[edges[rows, longest]]
            if not more.any():
                break
            marked[edges[rows, longest][more]] = True
        mesh.halve(edges, marked, longest)


def _measure_misses(
    mesh: _Mesh, faces: AnyArray, looks: Sequence[Look], pixels: AnyArray
) -> AnyArray:
    """Error of the faces (N,) against their pictures, in codes; (N,) f32.

    Those that miss theirs at the first look are not looked at again.
    """
    missed = np.zeros(len(faces), np.float32)
    for steps in (_GRIDS[:1], _GRIDS):
        open_ones = np.flatnonzero((missed <= _SEEN) & ((pixels > 1.0) | (steps is not _GRIDS)))
        for some, weights, seen in _sample_faces(
            mesh, faces[open_ones], looks, pixels[open_ones], steps
        ):
            rows = open_ones[some]
            straight = np.tensordot(weights, _corner_codes(mesh, faces[rows], looks), 1)
            worst = np.abs(straight - seen).max(axis=0)
            missed[rows] = np.maximum(missed[rows], np.maximum.reduce(worst.T))
    return missed


def _corner_codes(mesh: _Mesh, faces: AnyArray, looks: Sequence[Look]) -> NDArray[np.float32]:
    """(3, N, 3) float32: the codes that the corners of faces (N,) of one look get.

    Between pixels they are mixed: on a border of the picture with those of the opposite one.
    """
    linear = looks[mesh.look[faces[0]]].at(mesh.uv[faces].reshape(-1, 2))
    return srgb_from_linear(linear).reshape(-1, 3, 3).swapaxes(0, 1).astype(np.float32)


def _sample_faces(
    mesh: _Mesh, faces: AnyArray, looks: Sequence[Look], pixels: AnyArray, grids: tuple[int, ...]
) -> Iterator[tuple[AnyArray, AnyArray, AnyArray]]:
    """Yield rows (N,), weights (K, 3) of the corners, and sRGB codes (K, N, 3) f32 seen there.

    The first three points are the corners; steps are about as many as pixels.
    """
    steps = np.searchsorted(grids[:-1], pixels)
    for which, one in enumerate(looks):
        if one.picture is None:
            continue
        for k, n in enumerate(grids):
            rows = np.flatnonzero((mesh.look[faces] == which) & (steps == k))
            weights = _grid_weights(n)
            batch = max(1, _AT_ONCE // len(weights))
            for start in range(0, len(rows), batch):
                some = rows[start : start + batch]
                positions = np.tensordot(weights, mesh.uv[faces[some]].swapaxes(0, 1), 1)
                codes = one.codes_at(positions.reshape(-1, 2)).reshape(len(weights), -1, 3)
                yield some, weights.astype(np.float32), codes.astype(np.float32)


def _grid_weights(n: int) -> NDArray[np.float64]:
    """Barycentric weights (K, 3) of a grid of n steps, the corners first."""
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    inside = i + j <= n
    weights = np.stack([i, j, n - i - j], axis=-1)[inside] / n
    corner = weights.max(axis=1) == 1.0
    return np.concatenate([np.eye(3), weights[~corner]])


def _colour_vertices(
    mesh: _Mesh, looks: Sequence[Look], sizes: AnyArray, with_normals: bool
) -> Pictured:
    corners = _corner_colours(mesh, looks)
    linear = _means_where_coarse(mesh, looks, sizes, corners)
    faces, source, seen = _split_seams(mesh.faces, linear, len(mesh.point_of))
    colours = srgb_from_linear(seen * mesh.own[source, :3])
    normals = mesh.own[source, 3:] if with_normals else None
    if normals is not None:
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals /= np.where(length > 0.0, length, 1.0)
    return Pictured(mesh.points[mesh.point_of[source]], faces, colours, normals)


def _corner_colours(mesh: _Mesh, looks: Sequence[Look]) -> NDArray[np.float64]:
    """(F, 3, 3) float64 linear colours of the corners."""
    colours = np.ones((len(mesh.faces), 3, 3))
    for which, one in enumerate(looks):
        rows = np.flatnonzero(mesh.look == which)
        colours[rows] = one.at(mesh.uv[rows].reshape(-1, 2)).reshape(-1, 3, 3)
    return colours


def _means_where_coarse(
    mesh: _Mesh, looks: Sequence[Look], sizes: AnyArray, corners: AnyArray
) -> AnyArray:
    """The corners' colours; means of the picture around faces that still miss it."""
    pixels = mesh.pixel_lengths(sizes).max(axis=1)
    coarse = np.flatnonzero((mesh.error > 2.0 * _SEEN) & (pixels > 2.0 * _PIXEL))
    if not len(coarse):
        return corners
    total, weight = np.zeros((len(mesh.point_of), 3)), np.zeros(len(mesh.point_of))
    pixels = pixels[coarse]
    table = linear_from_srgb(np.arange(256, dtype=np.uint8)).astype(np.float32)
    for rows, weights, seen in _sample_faces(mesh, coarse, looks, pixels, _GRIDS[:3]):
        near = weights**2
        ids = mesh.faces[coarse[rows]]
        mean = np.tensordot((near / near.sum(axis=0)).T, table[seen.astype(np.uint8)], 1)
        mean = mean.swapaxes(0, 1)
        for channel in range(3):
            total[:, channel] += np.bincount(ids.ravel(), mean[:, :, channel].ravel(), len(total))
        weight += np.bincount(ids.ravel(), minlength=len(weight))
    mean = total / np.maximum(weight, 1.0)[:, None]
    colours = corners.copy()
    soft = weight[mesh.faces[coarse]] > 0
    colours[coarse] = np.where(soft[..., None], mean[mesh.faces[coarse]], colours[coarse])
    return colours


def _split_seams(faces: AnyArray, linear: AnyArray, n: int) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Split vertices at colour seams; return faces, sources (K,), and linear colours (K, 3).

    A vertex whose corners differ visibly becomes several; those that no face uses are white.
    """
    ids = faces.ravel()
    flat = linear.reshape(-1, 3)
    codes = srgb_from_linear(flat).astype(np.int64)
    one = np.zeros(n, np.int64)
    one[ids[::-1]] = np.arange(len(ids))[::-1]  # a corner of each vertex: its first
    differs = np.abs(codes - codes[one[ids]]).max(axis=1) > _SEAM
    seam = np.bincount(ids, differs, n)[ids] > 0
    faces, source = _split(faces, (codes >> 3) @ np.array([1024, 32, 1]) * seam, n)
    ids = faces.ravel()
    total = np.stack([np.bincount(ids, flat[:, k], len(source)) for k in range(3)], axis=1)
    count = np.bincount(ids, minlength=len(source))[:, None]
    return faces, source, np.where(count > 0, total / np.maximum(count, 1), 1.0)
