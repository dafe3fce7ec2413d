"""Load of a brush along a stroke, so that it leaves as much bare as was asked for.

A brush that runs dry touches only what stands out of a surface's grain (docs/model.md, equation
(13)). The fraction of its footprint that is touched depends on the level λ alone: its load over the
one at which it begins to skip, g (0.8 - 0.4 pe) of a dip on a material of grain g. So a fraction
that shall stay bare gives λ, by a table, and with the planned pressure the load. The recording's
header says it (``loads``) wherever it changes: how much is bare, and where along the stroke; not
which streak.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.spec import DipAmount
from paint3d.calligraphy.footprint_table import FootprintTable
from paint3d.calligraphy.glyphs import Glyph
from paint3d.calligraphy.planning import on_paper
from paint3d.calligraphy.timing import Motion
from paint3d.colour.materials import Material
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import resample_to, unit_vectors
from paint3d.device.recorded import Recording
from paint3d.errors import InputError

__all__ = [
    "BLACKEST",
    "DENSITY",
    "dilution_for",
    "dryness_at",
    "loads_for",
    "stations_of_motion",
    "with_dryness",
    "with_ink",
    "with_loads",
    "with_strengths",
]

BLACKEST = 0.985
"""Share of the paper's light that a coat of soot takes: L* 10 on xuan."""

DENSITY = 5.5
"""Of a written stroke of soot, had its surface no shine: 4.7 to 11 by brush and size; a copy that
is painted on trial corrects it."""

_LEAST_INK = 1e-3  # in water

# The fraction of a written stroke that is covered at levels of 0 to 1: characters of 25, 40 and 70
# mm, all their strokes alike, on xuan paper. Brushes drawn straight cover less (.05 at .05, .44 at
# .4, .89 at .7; on plaster and with three brushes to .03 the same): a written footprint turns.
_LEVELS = (0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
_COVERED = (
    0.0, 0.107, 0.149, 0.201, 0.261, 0.332, 0.415, 0.489, 0.565, 0.703, 0.823, 0.907, 0.964,
    0.998, 1.0,
)  # fmt: skip
_SKIPS_AT, _PRESSED = 0.8, 0.4  # of a dip, on grain 1: model.md, 5; less by so much when pressed
_DRIEST = 0.97  # fraction left bare, that a stroke is painted with at the most
_WET = 0.03  # fraction left bare, below which ink is as full as it comes
_FULLNESS = 3.0  # of a dip: streaks of a brush that is nearly dry are as black as wet ink
_NEXT = 0.04  # of itself, or of a tenth of a dip: by how much a load must differ to be written anew
_MOST_CHANGES = 1500  # loads in a header, whose line has no more room
_DECIMALS = 4
_LINE_POINTS = 400  # of a line, of which each point has its nearest


def stations_of_motion(
    motion: Motion, glyph: Glyph, em_mm: float, footprints: FootprintTable
) -> NDArray[np.float64]:
    """Stations of their strokes' dryness, of every sample (N,).

    Stations are counted from 0 through all strokes; NaN off strokes that do not say how dry they
    are.

    Parameters
    ----------
    motion : Motion
        Of the glyph, planned.
    glyph : Glyph
        Its strokes say how dry they are.
    em_mm : float
    footprints : FootprintTable
        Of the brush: where below it the ink goes.
    """
    station = np.full(len(motion.time_s), np.nan)
    depth = np.clip(-motion.height, footprints.descents[0], footprints.descents[-1])
    ahead = np.interp(depth, footprints.descents, footprints.centroids)
    middle = motion.handle + ahead[:, None] * unit_vectors(motion.azimuth)
    first = 0
    for k, stroke in enumerate(glyph.strokes):
        mine, n = np.flatnonzero(motion.stroke == k), len(stroke.dryness)
        if n and len(mine):
            along = _station_along(on_paper(stroke.median, em_mm), middle[mine])
            station[mine] = first + np.clip(along * n - 0.5, 0.0, n - 1.0)
        first += n
    return station


def dryness_at(station: AnyArray, dryness: AnyArray) -> NDArray[np.float64]:
    """Interpolate dryness between stations linearly; NaN where the station is."""
    result: NDArray[np.float64] = np.interp(station, np.arange(len(dryness)), dryness)
    return result


def _station_along(line: AnyArray, points: AnyArray) -> NDArray[np.float64]:
    """Station (0 to 1) on a line (M, 2) of the nearest position to each point, never going back.

    A stroke may cross itself: each point is looked for near the one before.
    """
    line_points = resample_to(line, _LINE_POINTS)
    at = np.empty(len(points))
    last = 0
    for k, point in enumerate(points):
        first, end = max(0, last - 20), min(_LINE_POINTS, last + 60)
        off = np.linalg.norm(line_points[first:end] - point, axis=1)
        last = first + int(np.argmin(off))
        at[k] = last / (_LINE_POINTS - 1)
    return np.maximum.accumulate(at)


def with_ink(
    recording: Recording, dryness: AnyArray | None, strength: AnyArray | None, material: Material
) -> Recording:
    """A recording with the dryness and strength of ink that strokes ask for, on a material.

    See `with_dryness` and `with_strengths`.
    """
    return with_strengths(with_dryness(recording, dryness, material), strength)


def with_dryness(recording: Recording, dryness: AnyArray | None, material: Material) -> Recording:
    """A recording with the dryness that strokes ask for, on a material.

    Parameters
    ----------
    recording : Recording
        With pressures.
    dryness : (N,) float64, optional
        What fraction shall stay bare below the brush at each sample; None: the same recording.
    material : Material
        Where it has no grain nothing stays bare.
    """
    if dryness is None or recording.pressure is None or not material.grain > 0.0:
        return recording
    return with_loads(recording, loads_for(dryness, recording.pressure, material.grain), _FULLNESS)


def loads_for(dryness: AnyArray, pressure: AnyArray, grain: float) -> NDArray[np.float64]:
    """The load, in dips three times as full as usual, that leaves such fractions bare.

    Parameters
    ----------
    dryness, pressure : (N,) float64
        0 to 1.
    grain : float
        Of the surface's material; on one without, nothing stays bare.
    """
    begins = grain * (_SKIPS_AT - _PRESSED * np.asarray(pressure, np.float64))
    bare = np.clip(dryness, 0.0, _DRIEST)
    level = np.interp(1.0 - bare, _COVERED, _LEVELS)
    wet = np.maximum(begins, 1.0 / _FULLNESS)
    return np.where(np.isnan(dryness), np.nan, np.where(bare < _WET, wet, level * begins))


def with_strengths(recording: Recording, strength: AnyArray | None) -> Recording:
    """A recording whose header says with how much water strokes are written (``strengths``).

    Of a film that scatters little the density -log10 of the light grows as the ink in it does
    (Beer and Lambert); see `dilution_for`.

    Parameters
    ----------
    recording : Recording
    strength : (N,) float64, optional
        Fractions of the light that black ink takes, of every sample; NaN: as it is. None: the same
        recording.
    """
    if strength is None:
        return recording
    known = np.flatnonzero(np.isfinite(strength))
    fraction = dilution_for(np.asarray(strength)[known])
    first = np.ones(len(known), bool)
    first[1:] = (np.diff(known) > 1) | (np.diff(fraction) != 0.0)
    changes = [
        [int(recording.time_ns[k]), round(float(s), _DECIMALS)]
        for k, s in zip(known[first], fraction[first], strict=True)
    ]
    if len(changes) > _MOST_CHANGES:
        raise InputError(
            "{n} strokes say how strong their ink is; expected {most} or fewer in a recording: "
            "write fewer characters at a time",
            n=len(changes),
            most=_MOST_CHANGES,
        )
    return replace(recording, header={**recording.header, "strengths": changes})


def dilution_for(strength: AnyArray) -> NDArray[np.float64]:
    """Fraction of ink in water that takes a fraction of the light that black ink takes.

    A written stroke is thicker than what would be black: strokes of soot with water come to a
    density of `DENSITY` times the fraction of soot, until the light that their surface reflects is
    all that is seen. Strength 1 is the ink itself.
    """
    strength = np.asarray(strength, np.float64)
    density = -np.log10(1.0 - BLACKEST * np.clip(strength, 0.0, 1.0))
    return np.where(strength < 1.0, np.clip(density / DENSITY, _LEAST_INK, 1.0), 1.0)


def with_loads(recording: Recording, loads: AnyArray, fullness: float = 1.0) -> Recording:
    """A recording whose header has the brush's load wherever it changes.

    Parameters
    ----------
    recording : Recording
    loads : (N,) float64
        Of every sample, as fractions of a dip; NaN: as it comes.
    fullness : float
        Of a dip, see `DipAmount`.

    Raises
    ------
    InputError
        If there are more strokes than a header has room for.
    """
    step, changes = _NEXT, _load_changes(recording, loads, _NEXT)
    while len(changes) > _MOST_CHANGES and step < 1.0:
        step *= 1.5
        changes = _load_changes(recording, loads, step)
    if len(changes) > _MOST_CHANGES:
        raise InputError(
            "{n} strokes say how dry they are; expected {most} or fewer in a recording: write "
            "fewer characters at a time, or without dryness",
            hint="copy --dryness none",
            n=len(changes),
            most=_MOST_CHANGES,
        )
    amount = DipAmount(1.0, fullness).words()
    return replace(recording, header={**recording.header, "dip": amount, "loads": changes})


def _load_changes(recording: Recording, loads: AnyArray, step: float) -> list[list[float]]:
    """Times (ns) and loads wherever the load changes noticeably, and at each stroke's start."""
    changes: list[list[float]] = []
    known = np.flatnonzero(np.isfinite(loads))
    for run in np.split(known, np.flatnonzero(np.diff(known) > 1) + 1):
        load = math.inf
        for k in run:
            if load == math.inf or abs(loads[k] - load) > step * max(load, 0.1):
                load = float(loads[k])
                changes.append([int(recording.time_ns[k]), round(load, _DECIMALS)])
    return changes
