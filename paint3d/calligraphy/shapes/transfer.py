"""Carrying the strokes of a known character onto a shape: which branch belongs to which stroke.

The known lines are laid over the skeleton (`registration`); every point of it goes to the stroke
that runs alike nearest to it, with a price on each change along a branch. Branches are cut where
the stroke changes, and joined through junctions where it does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.shapes.continuation import Chain, End, chains_of, resampled, turns_between
from paint3d.calligraphy.shapes.corners import cut_branch
from paint3d.calligraphy.shapes.regions import Ink, Piece, line_of
from paint3d.calligraphy.shapes.registration import register, tangents_of
from paint3d.calligraphy.shapes.skeleton import Branch, length_of
from paint3d.core.types import AnyArray

__all__ = ["KnownStrokes", "Told", "fits", "in_known_order", "label_chains", "lay_over"]

_STEP = 0.25  # widths between the points that are given to strokes
_ACROSS = 1.5  # widths that a stroke at right angles seems farther away
_CHANGE = 1.6  # widths that a change of stroke costs
_CORNER = 1.2  # widths that a right angle takes off that
_SHORTEST = 0.8  # widths of a run of one stroke
_TOGETHER, _ASUNDER = -90.0, 400.0  # degrees, for ends of the same stroke and of others
_SPUR = 1.5  # widths: what a stroke has besides its longest part is no part of it below that
_AWAY = 0.25  # widths: the mean distance up to which a shape is the known character
_THERE = 0.9  # of the known strokes, that it must have
_SMOOTH = 35.0  # degrees: no corner
_TORN = 0.15  # of the known strokes: more smooth lines are not torn for them
_SAMPLE = 6.0  # points of the known lines to a width


@dataclass(frozen=True, eq=False)
class KnownStrokes:
    """The lines of a known character, laid over a shape.

    Attributes
    ----------
    points, tangents : (N, 2) float64
    stroke : (N,) int64
        Which stroke each point belongs to.
    station : (N,) float64
        From 0 to 1 along it.
    count : int
    width : float
        Mean width of the shape's strokes.
    """

    points: NDArray[np.float64]
    tangents: NDArray[np.float64]
    stroke: NDArray[np.int64]
    station: NDArray[np.float64]
    count: int
    width: float

    def costs(self, line: AnyArray) -> NDArray[np.float64]:
        """How far each point of a line (N, 2) is from each stroke (N, K), widths."""
        away = np.linalg.norm(line[:, None] - self.points[None], axis=2) / self.width
        alike = np.abs(tangents_of(line) @ self.tangents.T)
        away += _ACROSS * (1.0 - alike)
        return np.stack([away[:, self.stroke == k].min(axis=1) for k in range(self.count)], axis=1)

    def residual(self, line: AnyArray) -> float:
        """How far a line is from the strokes that it belongs to, in the mean, widths."""
        return float(self.costs(line).min(axis=1).mean())

    def placed(self, line: AnyArray, stroke: int | None = None) -> tuple[float, float]:
        """Where a line is, as stroke plus station, and how much of it is written forward."""
        away = np.linalg.norm(line[:, None] - self.points[None], axis=2) / self.width
        turn = tangents_of(line) @ self.tangents.T
        away += _ACROSS * (1.0 - np.abs(turn))
        if stroke is not None:
            away[:, self.stroke != stroke] = np.inf
        nearest = np.argmin(away, axis=1)
        forward = float(np.mean(np.sign(turn[np.arange(len(line)), nearest])))
        place = float(np.median(self.stroke[nearest])) + 0.99 * float(
            np.median(self.station[nearest])
        )
        return place, forward


def lay_over(lines: Sequence[AnyArray], inks: Sequence[Ink], width: float) -> KnownStrokes:
    """Register known lines onto the skeletons of a shape's parts."""
    targets, tangents = [], []
    for ink in inks:
        for branch in ink.skeleton.branches:
            points = resampled(branch.line, _STEP * width, 3)
            targets.append(points)
            tangents.append(tangents_of(points))
        if not ink.skeleton.branches:
            junction = next(iter(ink.skeleton.junctions.values()))
            targets.append(junction.point[None])
            tangents.append(np.array([[0.7, -0.7]]))
    moved = register(lines, np.concatenate(targets), np.concatenate(tangents))
    moved = [resampled(line, width / _SAMPLE, 6) for line in moved]
    return KnownStrokes(
        np.concatenate(moved),
        np.concatenate([tangents_of(line) for line in moved]),
        np.repeat(np.arange(len(moved)), [len(line) for line in moved]),
        np.concatenate([np.linspace(0.0, 1.0, len(line)) for line in moved]),
        len(moved),
        width,
    )


def fits(inks: Sequence[Ink], known: KnownStrokes, told: Sequence[Told]) -> bool:
    """Whether a shape is a drawing of the known character, by how the lines lie upon it.

    Parameters
    ----------
    inks : sequence of Ink
    known : KnownStrokes
    told : sequence of Told
        Of each ink.
    """
    away = total = 0.0
    for ink in inks:
        for branch in ink.skeleton.branches:
            line = resampled(branch.line, _STEP * known.width, 3)
            away += branch.length * known.residual(line)
            total += branch.length
    strokes = {stroke for part in told for _, stroke in part.chains}
    dots = sum(not part.chains for part in told)
    if sum(part.torn for part in told) > _TORN * known.count:
        return False
    return away <= _AWAY * total and len(strokes) + dots >= _THERE * known.count


@dataclass(frozen=True, eq=False)
class Told:
    """A part's branches divided among known strokes.

    Attributes
    ----------
    chains : list of (Chain, int)
        Each with the number of its stroke.
    torn : int
        How many smooth lines had to be cut: a hand that writes them means one stroke.
    """

    chains: list[tuple[Chain, int]]
    torn: int


def label_chains(ink: Ink, known: KnownStrokes) -> Told:
    """Divide a part's branches among known strokes."""
    torn = _cut_where_strokes_change(ink, known)
    labels = [_label(branch, known) for branch in ink.skeleton.branches]

    def cost(one: End, two: End) -> float:
        return _TOGETHER if labels[one.branch] == labels[two.branch] else _ASUNDER

    chains = chains_of(ink.skeleton, ink.half_widths, cost)
    told = [(chain, labels[chain.links[0][0]]) for chain in chains]
    lengths = [length_of(line_of(chain, ink)) for chain in chains]
    longest = {
        k: max(n for n, (_, j) in zip(lengths, told, strict=True) if j == k) for _, k in told
    }
    kept = [
        entry
        for entry, length in zip(told, lengths, strict=True)
        if length >= min(_SPUR * known.width, longest[entry[1]])
    ]
    return Told(kept, torn)


def _label(branch: Branch, known: KnownStrokes) -> int:
    costs = known.costs(resampled(branch.line, _STEP * known.width, 3))
    inner = costs[len(costs) // 5 : len(costs) - len(costs) // 5]
    return int(np.argmin(inner.sum(axis=0)))


def _cut_where_strokes_change(ink: Ink, known: KnownStrokes) -> int:
    """Cut branches where the stroke changes; how many of the cuts are at no corner."""
    torn = 0
    waiting = list(ink.skeleton.branches)
    left = 4 * len(waiting) + known.count
    while waiting and left > 0:
        left -= 1
        branch = waiting.pop()
        place = _change_in(branch, known)
        if place is not None:
            point, turn = place
            torn += turn < _SMOOTH
            radius = float(ink.half_widths(point[None])[0])
            waiting += cut_branch(ink.skeleton, ink.triangles, branch, point, radius)
    return torn


def _change_in(branch: Branch, known: KnownStrokes) -> tuple[NDArray[np.float64], float] | None:
    """Where in a branch a stroke first gives way to another, and its turn there, degrees."""
    points = resampled(branch.line, _STEP * known.width, 3)
    step = branch.length / (len(points) - 1)
    reach = max(2, round(known.width / max(step, 1e-12)))
    if len(points) < 2 * reach:
        return None
    turns = np.zeros(len(points))
    inner = np.arange(1, len(points) - 1)
    low, high = np.maximum(0, inner - reach), np.minimum(len(points) - 1, inner + reach)
    turns[inner] = turns_between(points[inner] - points[low], points[high] - points[inner])
    price = _CHANGE - _CORNER * np.minimum(turns / 90.0, 1.0)
    labels = _cheapest(known.costs(points) * _STEP, price)
    shortest = max(1, round(_SHORTEST * known.width / max(step, 1e-12)))
    for k in (np.flatnonzero(np.diff(labels)) + 1).tolist():
        if shortest <= k <= len(points) - 1 - shortest:
            return points[k], float(turns[max(0, k - reach) : k + reach + 1].max())
    return None


def _cheapest(costs: AnyArray, price: AnyArray) -> NDArray[np.int64]:
    """The cheapest sequence of strokes (N,) along a line with costs (N, K) and prices of change."""
    n, count = costs.shape
    total = costs[0].copy()
    origin = np.empty((n, count), np.int64)
    for k in range(1, n):
        best = int(np.argmin(total))
        change = total[best] + price[k] < total
        origin[k] = np.where(change, best, np.arange(count))
        total = np.where(change, total[best] + price[k], total) + costs[k]
    labels = np.empty(n, np.int64)
    labels[-1] = int(np.argmin(total))
    for k in range(n - 1, 0, -1):
        labels[k - 1] = origin[k, labels[k]]
    return labels


def in_known_order(pieces: Sequence[tuple[Piece, int | None]], known: KnownStrokes) -> list[Piece]:
    """Pieces, each with its known stroke if it has one, in order and direction of these."""
    placed: list[tuple[float, int, Piece]] = []
    for piece, stroke in pieces:
        line = resampled(piece.line, _STEP * known.width, 5)
        place, forward = known.placed(line, stroke)
        turned = piece.line if forward >= 0.0 else piece.line[::-1]
        placed.append((place, len(placed), Piece(turned, piece.region)))
    return [piece for _, _, piece in sorted(placed, key=lambda entry: entry[:2])]
