"""Branches of a skeleton joined to strokes, where they go on straight through a junction."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.shapes.skeleton import Branch, Junction, Skeleton
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import resample

__all__ = ["Chain", "End", "chains_of", "row_products", "turns_between"]

_MOST_TURN = 50.0  # degrees, of two branches that are one stroke
_DIRECTION_FROM, _DIRECTION_TO = 1.0, 3.0  # radii beyond a junction where directions are taken
_OWN_TURN, _GAPS_TURN = 0.6, 0.4  # how both turns count
_WIDTHS = 8.0  # degrees that a ratio of e between the widths costs
_MOST_ENDS = 8  # at a junction, of which all pairings are tried


@dataclass(frozen=True)
class End:
    """An end of a branch at a junction, and the direction in which it leaves that.

    Attributes
    ----------
    branch : int
        Its index.
    side : int
        0 for the first point of its line, 1 for the last.
    direction : (2,) float64
        Unit vector away from the junction.
    start : (2,) float64
        Where the branch is clear of the junction.
    width : float
        Half of the branch's width there.
    """

    branch: int
    side: int
    direction: NDArray[np.float64]
    start: NDArray[np.float64]
    width: float


@dataclass(frozen=True)
class Chain:
    """Branches that are one stroke, in order: their indices, and whether each is walked forward."""

    links: tuple[tuple[int, bool], ...]
    closed: bool = False


def row_products(ones: AnyArray, twos: AnyArray) -> NDArray[np.float64]:
    """The products of vectors (N, 2) with others, each rounded as one by itself is."""
    result: NDArray[np.float64] = (ones[:, None] @ twos[:, :, None])[:, 0, 0]
    return result


def turns_between(ones: AnyArray, twos: AnyArray) -> NDArray[np.float64]:
    """The angles between directions (N, 2) and others, degrees."""
    sizes = np.sqrt(row_products(ones, ones)) * np.sqrt(row_products(twos, twos))
    cosines = row_products(ones, twos) / np.where(sizes > 0.0, sizes, 1.0)
    angles = [math.degrees(math.acos(min(1.0, max(-1.0, one)))) for one in cosines.tolist()]
    return np.where(sizes > 0.0, angles, 0.0)


def _turn_between(one: AnyArray, two: AnyArray) -> float:
    return float(turns_between(one[None], two[None])[0])


def chains_of(
    skeleton: Skeleton,
    half_widths: Callable[[AnyArray], NDArray[np.float64]],
    cost: Callable[[End, End], float] | None = None,
) -> list[Chain]:
    """Divide the branches of a skeleton into strokes.

    Parameters
    ----------
    skeleton : Skeleton
    half_widths : callable
        Distances of points (N, 2) to the edge.
    cost : callable, optional
        What is added to the turn of two ends (degrees) where they shall be one stroke.
    """
    mates = _mates_of(skeleton, half_widths, cost)
    used: set[int] = set()
    chains = []
    free = [(k, s) for k in range(len(skeleton.branches)) for s in (0, 1) if (k, s) not in mates]
    for k, side in [*free, *((k, 0) for k in range(len(skeleton.branches)))]:
        if k in used:
            continue
        links = [(k, side == 0)]
        used.add(k)
        tail = (k, 1 - side)
        while tail in mates and mates[tail][0] not in used:
            tail = mates[tail]
            links.append((tail[0], tail[1] == 0))
            used.add(tail[0])
            tail = (tail[0], 1 - tail[1])
        chains.append(Chain(tuple(links), closed=mates.get(tail) == (k, side)))
    return chains


def _mates_of(
    skeleton: Skeleton,
    half_widths: Callable[[AnyArray], NDArray[np.float64]],
    cost: Callable[[End, End], float] | None = None,
) -> dict[tuple[int, int], tuple[int, int]]:
    """Pair the ends of branches that go on in one another: (index, side) to (index, side)."""
    ends: dict[int, list[tuple[int, int]]] = {}
    for k, branch in enumerate(skeleton.branches):
        for side in (0, 1):
            ends.setdefault(branch.ends[side], []).append((k, side))
    mates = {}
    for number, here in ends.items():
        if len(here) < 2 or number in skeleton.cuts:
            continue
        junction = skeleton.junctions[number]
        leaving = [_end(skeleton.branches[k], k, side, junction, half_widths) for k, side in here]
        limit = _MOST_TURN if len(here) > 2 else math.inf
        prices = {}
        for a, b in itertools.combinations(range(len(here)), 2):
            price = _turning(leaving[a], leaving[b])
            price += cost(leaving[a], leaving[b]) if cost is not None else 0.0
            if price < limit:
                prices[a, b] = price - (limit if math.isfinite(limit) else 400.0)
        for a, b in _best_pairs(prices, len(here)):
            mates[here[a]], mates[here[b]] = here[b], here[a]
    return mates


def _end(
    branch: Branch,
    index: int,
    side: int,
    junction: Junction,
    half_widths: Callable[[AnyArray], NDArray[np.float64]],
) -> End:
    """Direction in which a branch leaves a junction, taken where it is clear of it."""
    line = resample(branch.away_from(side), max(0.2 * junction.radius, 1e-3 * branch.length), 8)
    along = np.linspace(0.0, branch.length, len(line))
    low = min(_DIRECTION_FROM * junction.radius, 0.4 * branch.length)
    high = min(low + (_DIRECTION_TO - _DIRECTION_FROM) * junction.radius, branch.length)
    part = line[(along >= low) & (along <= high)]
    if len(part) < 2:
        part = line[[0, -1]]
    direction = np.linalg.svd(part - part.mean(axis=0), full_matrices=False)[2][0]
    direction = -direction if direction @ (part[-1] - part[0]) < 0.0 else direction
    width = float(half_widths(part[len(part) // 4 : len(part) // 4 + 1])[0])
    return End(index, side, direction, part[0], width)


def _turning(one: End, two: End) -> float:
    """Cost of one end going on in another, degrees."""
    own = _turn_between(-one.direction, two.direction)
    gap = two.start - one.start
    if np.linalg.norm(gap) > 0.2 * (one.width + two.width):
        across = 0.5 * (_turn_between(-one.direction, gap) + _turn_between(two.direction, gap))
    else:
        across = own
    ratio = max(one.width, 1e-12) / max(two.width, 1e-12)
    return _OWN_TURN * own + _GAPS_TURN * across + _WIDTHS * abs(math.log(ratio))


def _best_pairs(prices: dict[tuple[int, int], float], n: int) -> list[tuple[int, int]]:
    """Pairs of n ends, each in one pair at the most, whose prices (below 0) sum to the least."""
    if n > _MOST_ENDS:
        chosen: list[tuple[int, int]] = []
        for pair in sorted(prices, key=lambda pair: (prices[pair], pair)):
            if not any(set(pair) & set(other) for other in chosen):
                chosen.append(pair)
        return chosen
    return _try_pairs(tuple(range(n)), prices)[1]


def _try_pairs(
    left: Sequence[int], prices: dict[tuple[int, int], float]
) -> tuple[float, list[tuple[int, int]]]:
    """The least sum of prices among the unpaired ends, and its pairs."""
    if len(left) < 2:
        return 0.0, []
    best = _try_pairs(left[1:], prices)
    for other in left[1:]:
        price = prices.get((left[0], other))
        if price is not None:
            rest = tuple(k for k in left[1:] if k != other)
            total, pairs = _try_pairs(rest, prices)
            if total + price < best[0] - 1e-12:
                best = total + price, [(left[0], other), *pairs]
    return best
