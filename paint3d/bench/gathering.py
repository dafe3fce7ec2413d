"""Gather, project, deposit: the loop under every footprint, against SciPy and memory bandwidth."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from paint3d.bench.kernels.standing import deposit_standing, place_standing
from paint3d.bench.result import Cell, Check, Result
from paint3d.bench.stopwatch import alternate, best_of
from paint3d.bench.strokes import Dab, figure_for, make_dab, make_grid, record_dabs
from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import Footprint
from paint3d.brush_engine.footprint import Stamp, make_stamp
from paint3d.brush_engine.ink_transfer import PAINTED
from paint3d.brush_engine.scratch import make_scratch
from paint3d.brush_engine.tuft import enclose_tuft
from paint3d.brush_engine.vertex_query import VISITED
from paint3d.core.arrays import AnyArray
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["PlainSurface", "measure"]

_VERTICES = 1_000_000
_VISITED = 6_000  # vertices in NumPy's ball
_DABS, _PLAIN_DABS = 1020, 60
_ROUNDS = 5
_LEAST_RATIO = 10.0
_COPIED = 1 << 26  # float32 numbers: larger than any cache
_BYTES_VISITED = 24  # six float32 read
_BYTES_PAINTED = 30  # area 8, amount and coverage read and written 16, dirty mark 2, id 4

_ALONG = np.array([1.0, 0.0, 0.0])


def copy_bandwidth(n_numbers: int = _COPIED) -> float:
    """Measure the bytes read and written a second by the fastest plain copy, one thread."""
    source = np.ones(n_numbers, np.float32)
    target = np.zeros(n_numbers, np.float32)
    seconds = best_of(_ROUNDS, lambda: np.copyto(target, source)).wall_s
    return 2.0 * source.nbytes / seconds


def _balls(dab: Dab) -> dict[str, tuple[AnyArray, float]]:
    """Compute balls to gather in, relative to the foot: around the footprint, and the paper's."""
    corners = dab.footprint.polygon() - [dab.middle, 0.0]
    tight = float(np.linalg.norm(corners, axis=1).max())
    tuft, descent = build_tuft(dab.brush), dab.pressure * dab.brush.full_press_mm
    along, up, radius = enclose_tuft(tuft, descent, 0.5 * math.pi, dab.pressure)
    return {
        "NumPy, ball around the footprint": (dab.middle * _ALONG, tight),
        "NumPy, the paper's sphere": (np.array([along, 0.0, up]), radius),
    }


class _Ours:
    """The stroke painted at once, without colours; a dab includes contact and placement."""

    def __init__(self, dab: Dab, n_vertices: int, under: float, n_dabs: int) -> None:
        mesh = make_grid(n_vertices, math.sqrt(dab.footprint.area / under))
        self.centres = figure_for(mesh, dab.radius, n_dabs)
        self.surface = PaintedSurface(mesh, resolution=None)
        self.painter = Painter(self.surface, brush=dab.brush)
        self.recording = record_dabs(dab, self.centres)

    def standing(self) -> StandingStamps:
        """Make the same dabs as stamps that stand alone."""
        recording = self.recording
        assert recording.pressure is not None, "dabs press"
        poses = np.column_stack(
            [
                recording.position,
                recording.orientation,
                recording.pressure,
                np.zeros(len(recording)),
            ]
        )
        return StandingStamps(self.painter, poses)

    def __call__(self) -> None:
        self.painter.dip()
        self.painter.replay(self.recording)

    def per_footprint(self) -> tuple[float, float]:
        """Return the vertices visited and painted, a footprint."""
        counts = self.painter.report()
        n = counts["footprints"]
        return counts["vertices_visited"] / n, counts["deposits"] / n


def measure(scale: float = 1.0) -> Result:
    """Time a step that looks at about 6,000 vertices, ours and NumPy's taking turns."""
    dab = make_dab()
    balls = _balls(dab)
    tight = next(iter(balls.values()))[1]
    n_dabs = max(40, int(_DABS * scale))
    under = max(40, _VISITED * scale) * dab.footprint.area / (math.pi * tight**2)
    ours = _Ours(dab, max(900, int(_VERTICES * scale)), under, n_dabs)
    ours()
    visited, painted = ours.per_footprint()
    standing = ours.standing()
    standing()
    alone = standing.counters[[VISITED, PAINTED]] / n_dabs
    plain = PlainSurface(ours.surface)
    feet = ours.centres[:: max(1, n_dabs // _PLAIN_DABS)] - dab.middle * _ALONG
    looked_at: dict[str, list[int]] = {}

    def stamp_all(name: str, ball: tuple[AnyArray, float]) -> None:
        looked_at[name] = [
            plain.stamp(foot, _ALONG, dab.footprint, (foot + ball[0], ball[1]), 1.0)
            for foot in feet
        ]

    competitors: dict[str, Callable[[], object]]
    competitors = {"paint3d": standing, "paint3d, a dab of a stroke": ours}
    for name, ball in balls.items():
        competitors[name] = partial(stamp_all, name, ball)
    times = alternate(_ROUNDS, competitors)
    seen = {name: float(np.mean(counts)) for name, counts in looked_at.items()}
    seen |= {"paint3d": float(alone[0]), "paint3d, a dab of a stroke": visited}
    each = {
        name: 1e6 * t.cpu_s / (n_dabs if name.startswith("paint3d") else len(feet))
        for name, t in times.items()
    }
    times_ours = {name: us / each["paint3d"] for name, us in each.items()}
    by_numpy = times_ours[next(iter(balls))]
    rows: list[list[Cell]] = [
        [name, seen[name], us, 1e3 * us / seen[name], times_ours[name]] for name, us in each.items()
    ]
    moved = alone[0] * _BYTES_VISITED + alone[1] * _BYTES_PAINTED
    speed = moved / (1e-6 * each["paint3d"])
    copying = copy_bandwidth(max(1 << 16, int(_COPIED * scale)))
    return Result(
        f"Gather, project, deposit on {ours.surface.n_vertices:,} vertices",
        ["program", "visited", "CPU us/step", "CPU ns/visited", "x paint3d"],
        rows,
        [Check("NumPy's time over ours, tight ball", by_numpy, _LEAST_RATIO, at_most=False)],
        [
            f"The same step for both: of the vertices near a stamp that stands alone, those under "
            f"its outline ({alone[1]:,.0f}) are inked. A dab of a stroke is contact, bending, "
            f"outline and the whole way from the stamp before ({painted:,.0f} inked).",
            f"Ours moves {moved / 1e3:.0f} kB a step, {speed / 1e9:.2f} GB/s: "
            f"{100.0 * speed / copying:.1f} % of a plain copy's {copying / 1e9:.1f} GB/s.",
        ],
    )


# ---- The competitor in NumPy ---------------------------------------------------------------------

_LEAST_FACING = 0.25


class PlainSurface:
    """The same step as one would write it with SciPy and NumPy: vertices in a k-d tree, and ink.

    It follows Guo 2017, section 4.2.1: vertices inside a ball, their mean normal, each projected to
    the plane along its own normal, painted where it falls inside the outline. One stamp a dab and
    no sweep, no check of connectedness, no contact search: it does less than ours.

    Parameters
    ----------
    surface : PaintedSurface
        Only read; its vertices as they are now.
    """

    def __init__(self, surface: PaintedSurface) -> None:
        self.points = surface.paint_mesh.vertices
        self.normals = surface.paint_mesh.normals
        self.areas = surface.vertex_areas.astype(np.float32)
        self.edge = np.float32(np.sqrt(self.areas.mean()))
        self.tree = cKDTree(self.points)
        self.amounts = np.zeros(len(self.points), np.float32)
        self.coverage = np.zeros(len(self.points), np.float32)
        self.dirty = np.zeros(len(self.points), bool)

    def stamp(
        self,
        foot: NDArray[np.float64],
        along: NDArray[np.float64],
        footprint: Footprint,
        ball: tuple[AnyArray, float],
        released: float,
    ) -> int:
        """Deposit ink under a footprint; return how many vertices lay in the ball.

        Parameters
        ----------
        foot, along : (3,) float64
            P'_m and the direction of the bend.
        footprint : Footprint
        ball : (centre (3,), radius)
            Where to look for vertices, mm.
        released : float
            Ink, coats x mm2.
        """
        ids = np.asarray(self.tree.query_ball_point(*ball), dtype=np.intp)
        offsets, normals = self.points[ids] - foot.astype(np.float32), self.normals[ids]
        up = normals.mean(axis=0)
        up /= np.linalg.norm(up)
        cosines = normals @ up
        steps = -(offsets @ up) / np.maximum(cosines, _LEAST_FACING)
        carried = offsets + steps[:, None] * normals
        bend = along - (along @ up) * up
        bend = (bend / np.linalg.norm(bend)).astype(np.float32)
        x, y = carried @ bend, carried @ np.cross(up, bend)
        reach, half_width = footprint.reach[::-1], footprint.half_width[::-1]
        width = np.interp(x, reach, half_width, left=-np.inf, right=-np.inf)
        cover = np.clip(0.5 + (width - np.abs(y)) / self.edge, 0.0, 1.0)
        cover[cosines < _LEAST_FACING] = 0.0
        inside = np.flatnonzero(cover)
        ids, cover = ids[inside], cover[inside].astype(np.float32)
        weights = cover / cosines[inside] ** 2
        total = float(weights @ self.areas[ids])
        self.amounts[ids] += weights * (released / total)
        self.coverage[ids] = np.maximum(self.coverage[ids], cover)
        self.dirty[ids] = True
        return len(offsets)


# ---- Stamps without a stroke ---------------------------------------------------------------------


class StandingStamps:
    """Stamps placed once on a surface; calling it deposits all of them, one by one.

    Each time the patch of surface inside the enclosing sphere is found, its mean normal taken, the
    vertices under the outline gathered, projected along their own normals, weighed, and inked.

    Parameters
    ----------
    painter : Painter
        Its surface must need no refinement.
    poses : (D, 9) float64
        Position, quaternion wxyz, pressure, 0.
    """

    def __init__(self, painter: Painter, poses: NDArray[np.float64]) -> None:
        surface = painter.surface
        n = len(poses)
        self._painter = painter
        self._scratch = make_scratch(surface.paint_mesh, len(surface.pigments))
        self._before, self._after = make_stamp(), make_stamp()
        rows = [np.zeros((n, *array.shape), array.dtype) for array in make_stamp()]
        self._stamps = Stamp(*rows)
        self.counters = self._scratch.counters
        field = surface.paint_mesh.arrays
        place_standing(
            poses,
            painter.tuft,
            surface.contact_tree,
            field,
            self._scratch,
            self._after,
            self._stamps,
        )

    def __call__(self) -> None:
        """Deposit every stamp once."""
        surface = self._painter.surface
        deposit_standing(
            self._stamps, self._painter.tuft, surface.paint_mesh.arrays, surface.ink, self._scratch,
            self._before, self._after,
        )  # fmt: skip
