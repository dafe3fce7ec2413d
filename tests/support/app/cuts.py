"""Cuts across a way along the surface: where a mark lies to both sides, over edges and folds.

What lies beside a way over an edge may be nearest in space to quite another step of it: before a
fold of a right angle that is crossed aslant, to steps behind it; where a way comes back beside
itself, half of the mark to each. A cut leaves a step at right angles and goes straight on, over
edges as if the faces were unfolded there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import cross
from paint3d.mesh.base_surface import make_base_surface
from paint3d.mesh.bvh import ClosestPoints

__all__ = ["Cuts", "cut_across"]

SAMPLE_MM = 0.125
CRACK_MM = 0.1  # an open edge so near to another face is none
MOST_FACES = 4000  # that one cut goes over


class Cuts(NamedTuple):
    """N places on the surface, along cuts.

    Attributes
    ----------
    points : (N, 3) float64
        mm.
    step : (N,) int64
        The step of the way that the cut begins at.
    aside : (N,) float64
        How far from the step, mm, as the crow flies: a brush bridges grooves. Cuts to the left of
        the way count up, to the right down.
    """

    points: NDArray
    step: NDArray
    aside: NDArray

    def where(self, chosen: NDArray[np.bool_]) -> Cuts:
        """Only some of them."""
        return Cuts(*(part[chosen] for part in self))


class _Faces:
    """The faces of a mesh, and what joins them."""

    def __init__(self, surface: ClosestPoints) -> None:
        base = make_base_surface(surface.mesh)
        corners = base.points.astype(np.float64)[base.faces]  # (F, 3, 3)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.corners = corners
        self.normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        edges = np.roll(corners, -1, axis=1) - corners
        self.along = edges / np.linalg.norm(edges, axis=2, keepdims=True)
        self.outward = np.cross(self.along, self.normals[:, None])
        self.low, self.high = corners.min(axis=1), corners.max(axis=1)
        self.radial = base.radial
        self.number = np.full(len(surface.mesh.faces), -1, np.int64)
        self.number[base.source_faces] = np.arange(len(base.faces))

    def beyond(self, face: NDArray, edge: NDArray) -> tuple[NDArray, NDArray]:
        """The faces and their edges on the other side of edges; of several that which goes on
        straightest; -1 at the end of the surface.
        """
        own = 3 * face + edge
        found, flattest = np.full(len(own), -1), np.full(len(own), -2.0)
        outward = self.outward.reshape(-1, 3)
        ring = self.radial[own].astype(np.int64)
        while (ring != own).any():
            straight = -np.einsum("ij,ij->i", outward[own], outward[ring])
            better = (ring != own) & (straight > flattest)
            found[better], flattest[better] = ring[better], straight[better]
            ring = np.where(ring != own, self.radial[ring], own)
        return np.where(found < 0, -1, found // 3), found % 3

    def over_crack(
        self, face: int, edge: int, place: NDArray, direction: NDArray
    ) -> tuple[int, NDArray]:
        """The face that an open edge lies on, and whither straight on leads there; -1 for none."""
        line, outward = self.along[face, edge], self.outward[face, edge]
        sideways = float(direction @ line)
        onward = math.sqrt(max(0.0, 1.0 - sideways**2))
        near = (self.low <= place + CRACK_MM).all(axis=1) & (self.high >= place - CRACK_MM).all(
            axis=1
        )
        best, found = -2.0, (-1, direction)
        for other in np.flatnonzero(near):
            normal = self.normals[other]
            if other == face or abs(float((place - self.corners[other, 0]) @ normal)) > CRACK_MM:
                continue
            across = np.cross(normal, line)
            length = float(np.linalg.norm(across))
            if length < 0.1:
                continue
            for inward in (across / length, -across / length):
                ahead = place + 2.0 * CRACK_MM * inward - self.corners[other]
                if (np.einsum("ij,ij->i", ahead, self.outward[other]) > CRACK_MM).any():
                    continue
                if float(inward @ outward) > best:
                    best = float(inward @ outward)
                    way = sideways * (line - (line @ normal) * normal) + onward * inward
                    found = int(other), way / np.linalg.norm(way)
        return found

    def walk(
        self, face: NDArray, start: NDArray, direction: NDArray, length_mm: float
    ) -> list[tuple[NDArray, NDArray]]:
        """Straight on over faces, all walks (W,) at a time: of each the places where it comes to
        edges (N, 3), and how far these are (N,).
        """
        walk, place, far = np.arange(len(face)), start.copy(), np.zeros(len(face))
        edge, row = np.full(len(face), -1), np.arange(len(face))
        passed = [(walk, place, far)]
        while len(walk) and len(passed) < MOST_FACES:
            outward, row = self.outward[face], row[: len(walk)]
            ahead = np.einsum("wkj,wj->wk", outward, direction)
            away = np.einsum("wkj,wkj->wk", self.corners[face] - place[:, None], outward)
            leads_out = (ahead > 1e-12) & (np.arange(3) != edge[:, None])
            steps = np.full(ahead.shape, math.inf)
            steps[leads_out] = np.maximum(away[leads_out], 0.0) / ahead[leads_out]
            out = steps.argmin(axis=1)
            to_edge = steps[row, out]
            step = np.minimum(to_edge, length_mm - far)
            place, far = place + step[:, None] * direction, far + step
            passed.append((walk, place, far))
            on = np.isfinite(to_edge) & (far < length_mm)
            walk, place, far, face, out = walk[on], place[on], far[on], face[on], out[on]
            face, edge, direction = self._onward(face, out, place, direction[on])
            on = face >= 0
            walk, place, far = walk[on], place[on], far[on]
            face, edge, direction = face[on], edge[on], direction[on]
        walks, places, fars = (np.concatenate(part) for part in zip(*passed, strict=True))
        order = np.argsort(walks, kind="stable")
        ends = np.cumsum(np.bincount(walks, minlength=len(start)))[:-1]
        return [*zip(np.split(places[order], ends), np.split(fars[order], ends), strict=True)]

    def _onward(
        self, face: NDArray, out: NDArray, place: NDArray, direction: NDArray
    ) -> tuple[NDArray, NDArray, NDArray]:
        """Faces behind edges, by which of their edges they are entered, and whither; or -1."""
        other, edge = self.beyond(face, out)
        line = self.along[face, out]
        sideways = np.einsum("wj,wj->w", direction, line)
        onward = np.sqrt(np.maximum(0.0, 1.0 - sideways**2))
        whither = sideways[:, None] * line - onward[:, None] * self.outward[other, edge]
        for k in np.flatnonzero(other < 0):
            other[k], whither[k] = self.over_crack(face[k], out[k], place[k], direction[k])
            edge[k] = -1
        return other, edge, whither


def cut_across(
    surface: ClosestPoints,
    points: NDArray,
    ups: NDArray,
    chosen: NDArray[np.bool_],
    reach_mm: float,
) -> Cuts:
    """Cut across a way at its steps.

    Parameters
    ----------
    surface : ClosestPoints
    points, ups : (K, 3)
        The steps of the way, and the side of the surface that is looked at.
    chosen : (K,) bool
        The steps that are cut at.
    reach_mm : float
        To each side.

    Returns
    -------
    Cuts
        Places every eighth of a millimetre.
    """
    faces = _faces_of(surface)
    on = surface.find(points)
    there = faces.number[on.faces]
    begun: list[tuple[int, float, NDArray]] = []
    for k in np.flatnonzero(chosen):
        normal = faces.normals[there[k]]
        ahead = _ahead(points, k, normal)
        if ahead is not None:
            left = cross(normal if normal @ ups[k] >= 0.0 else -normal, ahead)
            begun += [(k, 1.0, left), (k, -1.0, -left)]
    if not begun:
        return Cuts(np.empty((0, 3)), np.empty(0, np.int64), np.empty(0))
    step = np.array([k for k, _, _ in begun])
    walks = faces.walk(there[step], on.points[step], np.array([d for *_, d in begun]), reach_mm)
    found, steps, sides = [], [], []
    for (k, side, _), (places, far) in zip(begun, walks, strict=True):
        at = np.arange(0.0 if side > 0.0 else SAMPLE_MM, far[-1] + 1e-9, SAMPLE_MM)
        found.append(np.stack([np.interp(at, far, column) for column in places.T], axis=1))
        steps.append(np.full(len(at), k))
        sides.append(np.full(len(at), side))
    points, step = np.concatenate(found), np.concatenate(steps)
    away = np.linalg.norm(points - on.points[step], axis=1)
    return Cuts(points, step, np.concatenate(sides) * away)


def _ahead(points: NDArray, k: int, normal: NDArray) -> NDArray | None:
    """Whither the way leads on the face at a step: of the steps before and behind that which lies
    in the face, since the other may lead over an edge.
    """
    best, least = None, math.inf
    for a, b in ((k - 1, k), (k, k + 1)):
        if a < 0 or b >= len(points):
            continue
        way = points[b] - points[a]
        length = float(np.linalg.norm(way))
        if length == 0.0:
            continue
        off = abs(float(way @ normal)) / length
        across = way - (way @ normal) * normal
        if off < least and np.linalg.norm(across) > 1e-6 * length:
            best, least = across / np.linalg.norm(across), off
    return best


_known: list[tuple[ClosestPoints, _Faces]] = []


def _faces_of(surface: ClosestPoints) -> _Faces:
    """The faces of a surface; those of the last are kept."""
    if not _known or _known[0][0] is not surface:
        _known[:] = [(surface, _Faces(surface))]
    return _known[0][1]
