"""How well strokes found in a shape agree with the strokes that it was made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.optimize import linear_sum_assignment
from scipy.stats import kendalltau
from shapely import MultiPolygon, Polygon

from paint3d.calligraphy.glyphs import GlyphStroke

__all__ = ["Found", "joined", "region_of", "score"]

_FOUND, _MATCHED = 0.7, 0.5  # IoU of a stroke with its own
_SHORT = 0.08  # of the shape's size: chords shorter than that tell no direction


@dataclass(frozen=True)
class Found:
    """What was found of the strokes of a shape.

    Attributes
    ----------
    found : float
        Share of the true strokes with a found one of an IoU above 0.7.
    count : int
        How many strokes more than there are.
    iou : float
        Mean over the pairs that fit best.
    tau : float
        Kendall's tau of the order; nan where fewer than two strokes have a pair.
    direction : float
        Share of the pairs that are written the same way.
    """

    found: float
    count: int
    iou: float
    tau: float
    direction: float


def region_of(stroke: GlyphStroke) -> Polygon:
    """The region of a stroke, mended where its outline crosses itself."""
    return Polygon(stroke.outline, stroke.holes).buffer(0.0)


def joined(strokes: Sequence[GlyphStroke]) -> MultiPolygon:
    """The ink of all strokes together."""
    parts = shapely.get_parts(shapely.union_all([region_of(stroke) for stroke in strokes]))
    return MultiPolygon([part for part in parts if part.geom_type == "Polygon"])


def score(strokes: Sequence[GlyphStroke], truth: Sequence[GlyphStroke]) -> Found:
    """Pair found strokes with true ones so that their regions agree best, and compare."""
    regions, wanted = [region_of(s) for s in strokes], [region_of(s) for s in truth]
    iou = np.array([[a.intersection(b).area / a.union(b).area for b in wanted] for a in regions])
    rows, columns = linear_sum_assignment(-iou)
    pairs = [(i, j) for i, j in zip(rows, columns, strict=True) if iou[i, j] > _MATCHED]
    tau = kendalltau(*zip(*pairs, strict=True))[0] if len(pairs) > 1 else np.nan
    size = float(np.ptp(np.concatenate([s.outline for s in truth]), axis=0).max())
    ways = [_same_way(strokes[i].median, truth[j].median, _SHORT * size) for i, j in pairs]
    return Found(
        found=sum(iou[i, j] > _FOUND for i, j in pairs) / len(truth),
        count=len(strokes) - len(truth),
        iou=float(iou[rows, columns].sum() / len(truth)),
        tau=float(tau),
        direction=float(np.mean(ways)) if ways else np.nan,
    )


def _same_way(line: np.ndarray, other: np.ndarray, short: float) -> bool:
    way, wanted = line[-1] - line[0], other[-1] - other[0]
    if np.linalg.norm(wanted) > short:
        return bool(way @ wanted > 0.0)
    return bool(np.linalg.norm(line[0] - other[0]) < np.linalg.norm(line[-1] - other[0]))
