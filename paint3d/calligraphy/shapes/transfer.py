"""Carrying the strokes of a known character onto a shape: which branch belongs to which stroke.

The known lines are laid over the skeleton (`register`); every point of it goes to the stroke
that runs alike nearest to it, with a price on each change along a branch. Branches are cut where
the stroke changes, and joined through junctions where it does not.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.shapes.continuation import Chain, End, chains_of, turns_between
from paint3d.calligraphy.shapes.corners import cut_branch
from paint3d.calligraphy.shapes.ductus import orient_line
from paint3d.calligraphy.shapes.regions import Ink, InkStroke, line_of
from paint3d.calligraphy.shapes.skeleton import Branch
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import line_length, resample

__all__ = [
    "Fit",
    "KnownStrokes",
    "Labelled",
    "fit_of",
    "label_chains",
    "lay_over",
    "order_as_known",
    "register",
    "tangents_of",
]

# ---- Registration --------------------------------------------------------------------------------
# Laying the known lines of a character over the skeleton of another drawing of it.
#
# Coherent point drift (Myronenko and Song, 2010): points of the lines move towards those of the
# skeleton, smoothly together, while the distance over which they see each other shrinks. They see
# each other only where their lines run alike, so that crossing strokes are not taken for each
# other.


_SIDE = 900.0  # the larger side of what is laid over, in the units of the lengths below
_MOST_POINTS, _LEAST_STEP = 120, 14.0
_SIGHTS = (110.0, 80.0, 60.0, 45.0, 34.0, 26.0, 20.0, 15.0, 12.0)
_COARSE = 24.0  # sights above it move all strokes together, others each nearly for itself
_REACH, _OWN_REACH = 170.0, 90.0  # how far a point takes others along
_TOGETHER_EM, _APART = 0.75, 0.15  # the fraction of that across strokes
_STIFF = 1.0  # at a sight of 60
_NOISE = 2e-4  # fraction of the points that belong to nothing
_UNALIKE = 0.03  # what remains of the sight across lines at right angles
_SURE, _UNSURE = 1.5, 0.02
_OUTER = (2.0, 98.0)  # percentiles of the boxes that are laid over each other first
_STRETCH = (0.4, 2.5)
_SWASH = 15.0  # percent of a capital's skeleton that may be an ornament on its left
_STARTS = ("box", "slanted", "swash")
"""Ways to lay lines over a skeleton at first, in the order in which they are tried."""


def tangents_of(line: AnyArray) -> NDArray[np.float64]:
    """Unit vectors along a line (N, 2)."""
    ahead = np.gradient(line, axis=0)
    result: NDArray[np.float64] = ahead / np.maximum(
        np.linalg.norm(ahead, axis=1, keepdims=True), 1e-12
    )
    return result


def register(
    lines: Sequence[AnyArray], targets: AnyArray, tangents: AnyArray, *, start: str = "box"
) -> list[NDArray[np.float64]]:
    """Move lines over a skeleton.

    Parameters
    ----------
    lines : sequence of (N, 2) float64
        The strokes' lines, in any frame with y upwards.
    targets, tangents : (M, 2) float64
        Points of the skeleton, evenly spaced, and unit vectors along it.
    start : {"box", "slanted", "swash"}
        How the lines are laid over it first: so that their box is the skeleton's; so that their
        middle, extents and slant are, by second moments; or the same where the outermost part on
        the left is an ornament.

    Returns
    -------
    list of (N, 2) float64
        The lines, resampled, in the frame of the targets.
    """
    low, high = np.percentile(targets, _OUTER, axis=0)
    scale = _SIDE / max(float((high - low).max()), 1e-12)
    goals = (targets - low) * scale
    starts = _fit_boxes(lines, goals) if start == "box" else _fit_moments(lines, goals, start)
    total = sum(line_length(line) for line in starts)
    step = max(_LEAST_STEP, total / _MOST_POINTS)
    starts = [resample(line, step, 4) for line in starts]
    moved = _drift(starts, goals, tangents)
    return [low + line / scale for line in moved]


def _fit_boxes(lines: Sequence[AnyArray], goals: AnyArray) -> list[NDArray[np.float64]]:
    """Stretch lines so that their box is that of the goals."""
    points = np.concatenate([resample(line, line_length(line) / 20.0, 20) for line in lines])
    mine, wanted = (np.percentile(values, _OUTER, axis=0) for values in (points, goals))
    size = np.maximum(mine[1] - mine[0], 0.07 * float((mine[1] - mine[0]).max()) + 1e-12)
    stretch = (wanted[1] - wanted[0]) / size
    usual = float(np.median(stretch)) or 1.0
    stretch = np.clip(stretch, _STRETCH[0] * usual, _STRETCH[1] * usual)
    return [(line - mine.mean(axis=0)) * stretch + wanted.mean(axis=0) for line in lines]


def _fit_moments(
    lines: Sequence[AnyArray], goals: AnyArray, start: str
) -> list[NDArray[np.float64]]:
    """Stretch and slant lines so that their first and second moments are those of the goals."""
    points = np.concatenate([resample(line, line_length(line) / 20.0, 20) for line in lines])
    if start == "swash":
        across = (np.linalg.inv(_lower_root(goals)) @ (goals - goals.mean(axis=0)).T)[0]
        goals = goals[across > np.percentile(across, _SWASH)]
    mine, wanted = (_lower_root(values) for values in (points, goals))
    turn = wanted @ np.linalg.inv(mine)
    return [(line - points.mean(axis=0)) @ turn.T + goals.mean(axis=0) for line in lines]


def _lower_root(points: AnyArray) -> NDArray[np.float64]:
    """A root R of the second moments of points, R R^T: level lines stay level by it."""
    spread = np.cov(points.T)
    spread += max(0.005 * np.trace(spread), 1e-12) * np.eye(2)
    root = np.linalg.cholesky(spread[::-1, ::-1])
    result: NDArray[np.float64] = root[::-1, ::-1]
    return result


def _drift(
    lines: Sequence[AnyArray], goals: AnyArray, tangents: AnyArray
) -> list[NDArray[np.float64]]:
    start = np.concatenate(lines)
    of = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    cuts = np.cumsum([len(line) for line in lines])[:-1]
    same = of[:, None] == of[None]
    apart = np.sum((start[:, None] - start[None]) ** 2, axis=2)
    points = start
    for sight in _SIGHTS:
        coarse = sight > _COARSE
        reach, across = (_REACH, _TOGETHER_EM) if coarse else (_OWN_REACH, _APART)
        kernel = np.exp(-apart / (2.0 * reach**2)) * np.where(same, 1.0, across)
        stiff = _STIFF * (sight / 60.0) ** 2
        for _ in range(2 if coarse else 3):
            along = np.concatenate([tangents_of(line) for line in np.split(points, cuts)])
            squares = np.sum(points**2, axis=1)[:, None] + np.sum(goals**2, axis=1)[None]
            squares -= 2.0 * points @ goals.T
            seen = np.exp(-squares / (2.0 * sight**2))
            seen *= _UNALIKE + (along @ tangents.T) ** 4
            seen /= seen.sum(axis=0) + _NOISE * len(points)
            weight = seen.sum(axis=1)
            aim = seen @ goals / np.maximum(weight, 1e-9)[:, None]
            aim = np.where(weight[:, None] > 1e-4, aim, points)
            sure = np.minimum(weight, _SURE) + _UNSURE
            system = sure[:, None] * kernel + stiff * np.eye(len(points))
            points = start + kernel @ np.linalg.solve(system, sure[:, None] * (aim - start))
    return np.split(points, cuts)


# ---- Strokes of the ink --------------------------------------------------------------------------


_STEP = 0.25  # widths between the points that are given to strokes
_ACROSS = 1.5  # widths that a stroke at right angles seems farther away
_CHANGE = 1.6  # widths that a change of stroke costs
_CORNER = 1.2  # widths that a right angle takes off that
_SHORTEST = 0.8  # widths of a run of one stroke
_TOGETHER, _ASUNDER = -90.0, 400.0  # degrees, for ends of the same stroke and of others
_SKIPPED = 250.0  # degrees, for all of a stroke that lies between two ends of it
_NEAR_END = 2.0  # widths of a branch by which what its end lies on is found
_SPUR = 1.5  # widths: what a stroke has besides its longest part is no part of it below that
_AWAY = 0.25  # widths: the mean distance up to which a shape is the known character
_COVERED, _MORE = 0.15, 1.2  # the same where all of the lines lie on it: it has serifs besides
_THERE = 0.9  # of the known strokes, that it must have
_SMOOTH = 35.0  # degrees: no corner
_RUNS_ON = 60.0  # degrees that a pen may turn where it runs on into the next stroke
_TORN = 0.15  # of the known strokes: more smooth lines are not torn for them
_NEAR, _HELD = 0.15, 0.25  # widths that lines and shape may be apart and need not be laid anew,
_MANY = 5  # and where more strokes than this hold each other in place
_UNCLEAR = 0.3  # of a line that runs as much with its stroke as against it, or across
_DOUBTFUL = 0.6  # of a line that may run on smoothly from the end of the one before
_TOUCHING = 1.0  # widths between the ends of strokes that a pen runs through
_STRANGE = 1.5  # widths from its stroke: of a line farther away nothing is known
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
        """Distance of each point of a line (N, 2) from each stroke (N, K), widths."""
        away = np.linalg.norm(line[:, None] - self.points[None], axis=2) / self.width
        alike = np.abs(tangents_of(line) @ self.tangents.T)
        away += _ACROSS * (1.0 - alike)
        return np.stack([away[:, self.stroke == k].min(axis=1) for k in range(self.count)], axis=1)

    def residual(self, line: AnyArray) -> float:
        """Mean distance of a line from the strokes that it belongs to, widths."""
        return float(self.costs(line).min(axis=1).mean())

    def missed(self, lines: Sequence[AnyArray]) -> float:
        """Mean distance of the strokes from the nearest of some lines, widths."""
        there = np.concatenate(lines)
        away = np.linalg.norm(self.points[:, None] - there[None], axis=2)
        return float(away.min(axis=1).mean()) / self.width

    def station_of(self, line: AnyArray, stroke: int) -> float:
        """The middle one of the stations of a stroke that the points of a line lie on."""
        nearest, _ = self._nearest(line, stroke)
        return float(np.median(self.station[nearest]))

    def placed(
        self, line: AnyArray, stroke: int | None = None, without: Collection[int] = ()
    ) -> tuple[float, float]:
        """Position of a line, as stroke plus station, and how far it is written forward, -1 to 1.

        On the stroke, or on the nearest ones but for some.

        A line that runs on from one stroke to another against its way (the up of a W's down and up)
        is written as they follow each other.
        """
        nearest, turn = self._nearest(line, stroke, without)
        forward, strokes = float(np.mean(turn)), self.stroke[nearest]
        if abs(forward) < _UNCLEAR and np.ptp(strokes) > 0:
            at = strokes + self.station[nearest]
            forward = float(np.sign(at[None] - at[:, None])[np.triu_indices(len(at))].mean())
        position = float(np.median(strokes) + 0.99 * np.median(self.station[nearest]))
        return position, forward

    def _nearest(
        self, line: AnyArray, stroke: int | None, without: Collection[int] = ()
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """For each point of a line the nearest known one, and how much they run alike, -1 to 1."""
        away = np.linalg.norm(line[:, None] - self.points[None], axis=2) / self.width
        turn = tangents_of(line) @ self.tangents.T
        away += _ACROSS * (1.0 - np.abs(turn))
        if stroke is not None:
            away[:, self.stroke != stroke] = np.inf
        elif without:
            away[:, np.isin(self.stroke, list(without))] = np.inf
        nearest = np.argmin(away, axis=1)
        return nearest, turn[np.arange(len(line)), nearest]


def lay_over(lines: Sequence[AnyArray], inks: Sequence[Ink], width: float) -> KnownStrokes:
    """Register known lines onto the skeletons of a shape's parts."""
    targets, tangents = [], []
    for ink in inks:
        for branch in ink.skeleton.branches:
            points = resample(branch.line, _STEP * width, 3)
            targets.append(points)
            tangents.append(tangents_of(points))
        if not ink.skeleton.branches:
            junction = next(iter(ink.skeleton.junctions.values()))
            targets.append(junction.point[None])
            tangents.append(np.array([[0.7, -0.7]]))
    goals = np.concatenate(targets), np.concatenate(tangents)
    best: tuple[float, KnownStrokes] | None = None
    for start in _STARTS:
        moved = register(lines, *goals, start=start)
        known = _known_points([resample(line, width / _SAMPLE, 6) for line in moved], width)
        along = [known.costs(one).min(axis=1) for one in targets if len(one) > 1]
        away = known.missed(targets) + float(np.mean(np.concatenate([np.zeros(1), *along])))
        if best is None or away < best[0]:
            best = away, known
        if away <= (_HELD if len(lines) > _MANY else _NEAR):
            break
    assert best is not None
    return best[1]


def _known_points(lines: Sequence[NDArray[np.float64]], width: float) -> KnownStrokes:
    return KnownStrokes(
        np.concatenate(lines),
        np.concatenate([tangents_of(line) for line in lines]),
        np.repeat(np.arange(len(lines)), [len(line) for line in lines]),
        np.concatenate([np.linspace(0.0, 1.0, len(line)) for line in lines]),
        len(lines),
        width,
    )


class Fit(IntEnum):
    """Likeness of a shape to a known character."""

    WHOLE = 0  # stroke by stroke
    JOINED = 1  # its lines, but it runs on where another stroke begins, or leaves one out
    NONE = 2  # another shape


def fit_of(
    inks: Sequence[Ink], known: KnownStrokes, labelled: Sequence[Labelled]
) -> tuple[Fit, float]:
    """The likeness of a shape to the known character, by how the lines lie on it.

    Parameters
    ----------
    inks : sequence of Ink
    known : KnownStrokes
    labelled : sequence of Labelled
        Of each ink.

    Returns
    -------
    fit : Fit
    away : float
        How far shape and lines are from each other, in the mean both ways, widths.
    """
    lines = [
        resample(branch.line, _STEP * known.width, 3)
        for ink in inks
        for branch in ink.skeleton.branches
    ]
    lengths = [line_length(line) for line in lines]
    total = sum(length * known.residual(line) for length, line in zip(lengths, lines, strict=True))
    away = total / max(sum(lengths), 1e-300)
    missed = known.missed(lines) if lines else 0.0
    strokes = {stroke for part in labelled for _, stroke in part.chains}
    dots = sum(not part.chains for part in labelled)
    torn = sum(part.torn for part in labelled)
    complete = len(strokes) + dots >= _THERE * known.count
    if away <= _AWAY:
        fit = Fit.WHOLE if complete and torn <= _TORN * known.count else Fit.JOINED
    else:
        covered = torn == 0 and complete and missed <= _COVERED
        fit = Fit.WHOLE if covered and away <= _MORE else Fit.NONE
    return fit, away + missed


@dataclass(frozen=True, eq=False)
class Labelled:
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


def label_chains(ink: Ink, known: KnownStrokes, *, tear: bool = True) -> Labelled:
    """Divide a part's branches among known strokes.

    Parameters
    ----------
    ink : Ink
        Its branches are cut.
    known : KnownStrokes
    tear : bool
        Whether smooth lines are cut, too, where the stroke changes.
    """
    torn = _cut_where_strokes_change(ink, known, tear)
    lies = [_ends_on(branch, known, whole=tear) for branch in ink.skeleton.branches]

    def cost(one: End, two: End) -> float:
        (here, at), (there, goes_on) = lies[one.branch][one.side], lies[two.branch][two.side]
        if here != there:
            return _ASUNDER if tear else 0.0
        return _TOGETHER + _SKIPPED * abs(goes_on - at)

    chains = chains_of(ink.skeleton, ink.half_widths, cost)
    labelled = [(chain, _stroke_of(chain, ink, known)) for chain in chains]
    if not tear:
        return Labelled(labelled, torn)
    lengths = [line_length(line_of(chain, ink)) for chain in chains]
    longest = {
        k: max(n for n, (_, j) in zip(lengths, labelled, strict=True) if j == k)
        for _, k in labelled
    }
    long_enough = [
        entry
        for entry, length in zip(labelled, lengths, strict=True)
        if length >= min(_SPUR * known.width, longest[entry[1]])
    ]
    return Labelled(long_enough, torn)


def _stroke_of(chain: Chain, ink: Ink, known: KnownStrokes) -> int:
    """The stroke that the longest branch of a chain lies on."""
    branches = [ink.skeleton.branches[index] for index, _ in chain.links]
    return _label(max(branches, key=lambda branch: branch.length), known)


def _label(branch: Branch, known: KnownStrokes) -> int:
    costs = known.costs(resample(branch.line, _STEP * known.width, 3))
    inner = costs[len(costs) // 5 : len(costs) - len(costs) // 5]
    return int(np.argmin(inner.sum(axis=0)))


def _ends_on(
    branch: Branch, known: KnownStrokes, *, whole: bool
) -> tuple[tuple[int, float], tuple[int, float]]:
    """The stroke, and the station of it, that a branch lies on at its first and last point.

    Parameters
    ----------
    branch : Branch
    known : KnownStrokes
    whole : bool
        Whether it lies on one stroke: stations are those of its halves, led on to its ends.
    """
    line = resample(branch.line, _STEP * known.width, 6)
    if whole:
        stroke, half = _label(branch, known), len(line) // 2
        first, last = (known.station_of(part, stroke) for part in (line[:half], line[half:]))
        beyond = 0.5 * (last - first)
        return (stroke, first - beyond), (stroke, last + beyond)
    reach = max(3, min(len(line) // 2, round(_NEAR_END / _STEP)))
    near = [line[:reach], line[-reach:]]
    strokes = [int(known.costs(part).sum(axis=0).argmin()) for part in near]
    one, two = (
        (stroke, known.station_of(part, stroke)) for part, stroke in zip(near, strokes, strict=True)
    )
    return one, two


def _cut_where_strokes_change(ink: Ink, known: KnownStrokes, tear: bool) -> int:
    """Cut branches where the stroke changes; how many of the cuts are at no corner.

    These are only made where smooth lines may be torn.
    """
    torn = 0
    waiting = list(ink.skeleton.branches)
    left = 4 * len(waiting) + known.count
    while waiting and left > 0:
        left -= 1
        branch = waiting.pop()
        change = _find_change(branch, known, tear)
        if change is not None:
            point, turn = change
            torn += turn < _SMOOTH
            radius = float(ink.half_widths(point[None])[0])
            waiting += cut_branch(ink.skeleton, ink.triangles, branch, point, radius)
    return torn


def _find_change(
    branch: Branch, known: KnownStrokes, tear: bool
) -> tuple[NDArray[np.float64], float] | None:
    """Position in a branch where a stroke gives way to another, and its turn there, degrees.

    Where smooth lines are not torn, at a corner.
    """
    points = resample(branch.line, _STEP * known.width, 3)
    step = branch.length / (len(points) - 1)
    reach = max(2, round(known.width / max(step, 1e-12)))
    if len(points) < 2 * reach:
        return None
    turns = np.zeros(len(points))
    inner = np.arange(1, len(points) - 1)
    low, high = np.maximum(0, inner - reach), np.minimum(len(points) - 1, inner + reach)
    turns[inner] = turns_between(points[inner] - points[low], points[high] - points[inner])
    price = _CHANGE - _CORNER * np.minimum(turns / 90.0, 1.0)
    labels = _cheapest_sequence(known.costs(points) * _STEP, price)
    shortest = max(1, round(_SHORTEST * known.width / max(step, 1e-12)))
    for k in (np.flatnonzero(np.diff(labels)) + 1).tolist():
        if shortest <= k <= len(points) - 1 - shortest:
            turn = float(turns[max(0, k - reach) : k + reach + 1].max())
            if tear or turn >= _SMOOTH:
                return points[k], turn
    return None


def _cheapest_sequence(costs: AnyArray, price: AnyArray) -> NDArray[np.int64]:
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


def order_as_known(
    pieces: Sequence[tuple[InkStroke, int | None]],
    known: KnownStrokes,
    *,
    by_start: bool = False,
    dots: Collection[int] = (),
) -> list[InkStroke]:
    """Pieces, each with its known stroke if it has one, in order and direction of these.

    By their start instead of their middle where strokes are as long as many pieces. A piece without
    a known stroke is no part of those that are dots, however near it is.
    """
    placed: list[tuple[float, int, InkStroke, float]] = []
    for piece, stroke in pieces:
        line = resample(piece.line, _STEP * known.width, 5)
        position, forward = known.placed(line, stroke, dots)
        turned = piece.line if forward >= 0.0 else piece.line[::-1]
        if abs(forward) < _UNCLEAR or known.residual(line) > _STRANGE:
            turned, forward = orient_line(piece.line), 0.0
        if by_start:
            begins = resample(turned, _STEP * known.width, 5)
            begins = begins[: max(3, round(_NEAR_END / _STEP))]
            position, _ = known.placed(begins, stroke, dots)
        placed.append((position, len(placed), InkStroke(turned, piece.region), abs(forward)))
    ordered: list[InkStroke] = []
    for _, _, piece, sure in sorted(placed, key=lambda entry: entry[:2]):
        if ordered and not by_start and _runs_back(ordered[-1].line, piece.line, sure, known.width):
            piece = InkStroke(piece.line[::-1], piece.region)
        ordered.append(piece)
    return ordered


def _runs_back(before: AnyArray, line: AnyArray, sure: float, width: float) -> bool:
    """Return whether a stroke ends, not begins, where the pen is, without evidence for it.

    The smoother the pen would run on, the more evidence is needed.
    """
    away = np.linalg.norm(line[[0, -1]] - before[-1], axis=1)
    if not away[1] < _TOUCHING * width < away[0]:
        return False
    lines = [resample(one, _STEP * width, 5) for one in (before, line[::-1])]
    reach = max(2, round(1.0 / _STEP))
    arrives, leaves = lines[0][-1] - lines[0][-1 - reach], lines[1][reach] - lines[1][0]
    smooth = float(turns_between(arrives[None], leaves[None])[0]) < _RUNS_ON
    return sure < (_DOUBTFUL if smooth else _UNCLEAR)
