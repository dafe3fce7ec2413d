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

from paint3d.mesh.base_surface import make_base_surface
from paint3d.mesh.closest_points import ClosestPoints

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
    """The faces of a mesh as plain floats, and what joins them: for walks of few steps each."""

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

    def beyond(self, face: int, edge: int) -> tuple[int, int]:
        """The face and its edge on the other side of an edge; of several that which goes on
        straightest; -1 at the end of the surface.
        """
        ring, found = int(self.radial[3 * face + edge]), (-1, -1)
        flattest = -2.0
        while ring != 3 * face + edge:
            other = ring // 3, ring % 3
            straight = -float(self.outward[face, edge] @ self.outward[other])
            if straight > flattest:
                flattest, found = straight, other
            ring = int(self.radial[ring])
        return found

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
        self, face: int, start: NDArray, direction: NDArray, length_mm: float
    ) -> tuple[list[NDArray], list[float]]:
        """Straight on over faces: where it comes to edges, and how far that is."""
        places, far = [start], [0.0]
        edge = -1
        while far[-1] < length_mm and len(far) < MOST_FACES:
            away = self.corners[face] - places[-1]
            outward = self.outward[face]
            ahead = outward @ direction
            steps = [
                max(0.0, float(away[k] @ outward[k])) / ahead[k]
                if k != edge and ahead[k] > 1e-12
                else math.inf
                for k in range(3)
            ]
            out = int(np.argmin(steps))
            step = min(steps[out], length_mm - far[-1])
            places.append(places[-1] + step * direction)
            far.append(far[-1] + step)
            if not math.isfinite(steps[out]) or far[-1] >= length_mm:
                break
            other, edge_there = self.beyond(face, out)
            if other < 0:
                face, direction = self.over_crack(face, out, places[-1], direction)
                edge = -1
                if face < 0:
                    break
                continue
            line = self.along[face, out]
            sideways = float(direction @ line)
            direction = (
                sideways * line
                - math.sqrt(max(0.0, 1.0 - sideways**2)) * (self.outward[other, edge_there])
            )
            face, edge = other, edge_there
        return places, far


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
    found, steps, asides = [], [], []
    for k in np.flatnonzero(chosen):
        face = int(there[k])
        normal = faces.normals[face]
        ahead = _ahead(points, k, normal)
        if ahead is None:
            continue
        up = normal if normal @ ups[k] >= 0.0 else -normal
        left = np.cross(up, ahead)
        for side in (1.0, -1.0):
            places, far = faces.walk(face, on.points[k], side * left, reach_mm)
            at = np.arange(0.0 if side > 0.0 else SAMPLE_MM, far[-1] + 1e-9, SAMPLE_MM)
            if not len(at):
                continue
            columns = np.array(places).T
            found.append(np.stack([np.interp(at, far, column) for column in columns], axis=1))
            steps.append(np.full(len(at), k))
            asides.append(side * np.linalg.norm(found[-1] - on.points[k], axis=1))
    if not found:
        return Cuts(np.empty((0, 3)), np.empty(0, np.int64), np.empty(0))
    return Cuts(np.concatenate(found), np.concatenate(steps), np.concatenate(asides))


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
