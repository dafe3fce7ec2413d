"""The pose of a tuft on the surface for display, extrapolated from the last painted footprint.

Painting lags behind by the samples that it needs to look ahead; the displayed brush does not. From
the last painted footprint, the stamp, it goes on through the pending samples with the same kernel.
So the tuft is shown dragged, twisted or in a heap as in the painting, and where the hand rests, its
outline is the stamp's.

Single hairs are bent in painting only: the difference of their outline from that of a solid tuft in
the same pose is carried forward, and their memory gives how they have parted into clumps and points
(`brush_engine.bristles.bend`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.bristles.bend import clump_pulls
from paint3d.brush_engine.bristles.state import PARTED, SPLIT
from paint3d.brush_engine.footprint import PROFILE_CELLS, Stamp, make_stamp
from paint3d.brush_engine.placement import place_stamp
from paint3d.brush_engine.scratch import Scratch, make_scratch
from paint3d.brush_engine.stroke_loop import drive_factor
from paint3d.brush_engine.tuft import (
    CURVATURE,
    INK_LEFT,
    N_INPUTS,
    PRESSURE,
    SPEED,
    SPREAD,
    STIFFNESS,
    TILT,
    Tuft,
)
from paint3d.core.arrays import AnyArray
from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.painter.painter import Painter
from paint3d.pose.brush_pose import BrushPath, joined_samples

__all__ = ["Clumps", "PressedTuft", "TuftFollower"]

_STEP = 0.01  # longest step between interpolated poses, in tuft lengths
_TURN = 0.1  # greatest rotation in a step, rad
_MOST_STEPS = 24  # greatest number of steps between two samples
_WIDER = 8.0  # greatest width of the hairs over that of a solid tuft


@dataclass(frozen=True, eq=False)
class Clumps:
    """Lateral displacement of the hairs of a tuft, relative to a solid one.

    Attributes
    ----------
    middles : (3, N) float32
        For N positions across the tuft, the middle of the clump there in [-1, 1]: large clumps,
        small clumps, points.
    pulls : (3,) float64
        How far hairs are drawn to these middles, 0 to 1.
    set_x, set_y : float
        Displacement of the tip by the permanent bend, along and across the bend, mm.
    """

    middles: NDArray[np.float32]
    pulls: NDArray[np.float64]
    set_x: float
    set_y: float


@dataclass(frozen=True, eq=False)
class PressedTuft:
    """A tuft on a surface (object frame, mm, rad).

    Attributes
    ----------
    origin, normal, bend : (3,) float64
        As in a stamp's geometry: the outline's origin in the plane, the plane's normal, and the
        direction in it from the root's foot to the tip.
    descent, tilt, pressure : float
        D_s (mm), theta (rad), and pe of Eq. 2.
    heel, tip : float
        Ends of the outline along the bend, mm.
    half_widths : (PROFILE_CELLS + 1,) float64
        Of the outline, at even steps from the heel to the tip, mm.
    spread : float
        Spread of the tuft as driven by the hand.
    clumps : Clumps or None
        None for a solid tuft.
    """

    origin: NDArray[np.float64]
    normal: NDArray[np.float64]
    bend: NDArray[np.float64]
    descent: float
    tilt: float
    pressure: float
    heel: float
    tip: float
    half_widths: NDArray[np.float64]
    spread: float
    clumps: Clumps | None = None

    @property
    def numbers(self) -> tuple[float, ...]:
        """Numbers to compare two tufts by: all but the clumps' middles."""
        geometry = *self.origin, *self.normal, *self.bend, self.heel, self.tip
        pressed = self.descent, self.tilt, self.pressure, self.spread, float(self.half_widths.sum())
        if self.clumps is None:
            return (*geometry, *pressed)
        own = self.clumps
        return (*geometry, *pressed, *own.pulls, own.set_x, own.set_y)


@dataclass(frozen=True)
class _Hairs:
    """Difference of the hairs' outline from a solid tuft's."""

    tip: float  # mm
    heel: float  # mm
    wider: AnyArray  # (PROFILE_CELLS + 1,) ratio of half widths
    aside: float  # mm


class TuftFollower:
    """Computes the pose of a painter's tuft, reusing the kernels' scratch memory."""

    def __init__(self) -> None:
        self._mesh: PaintMesh | None = None
        self._scratch: Scratch | None = None

    def follow(
        self, painter: Painter, path: BrushPath, *, painted: bool = False
    ) -> PressedTuft | None:
        """Return the tuft at the end of a path; None if it touches nothing there.

        Parameters
        ----------
        painter : Painter
        path : BrushPath
            Consecutive samples.
        painted : bool
            Whether the painter's stamp is at the first of them. If not, the brush touches down
            there.
        """
        poses, joined = _poses(path), joined_samples(path)
        stamp, known = make_stamp(), painter.stamp
        tuft, hairs = painter.tuft, None
        if painted:
            stamp.values[:], stamp.half_widths[:] = known.values, known.half_widths
        if painted and painter.hairs is not None:
            self._place(painter, poses[0], stamp, _driven(painter, path, 0, stamp))
            hairs = _beyond_solid(known, stamp)
        for k in range(int(painted), len(path)):
            tuft = _driven(painter, path, k, stamp)
            if not joined[k]:
                stamp.values[0]["touches"] = 0.0
            steps = _between(poses[k - 1], poses[k], tuft.length) if joined[k] else poses[k : k + 1]
            for pose in steps:
                self._place(painter, pose, stamp, tuft)
        return _pressed(painter, poses[-1], stamp, tuft, hairs)

    def _place(self, painter: Painter, pose: AnyArray, stamp: Stamp, tuft: Tuft) -> None:
        """Advance a stamp to a pose (9,) of `place_stamp`."""
        surface = painter.surface
        mesh = surface.paint_mesh
        if self._scratch is None or self._mesh is not mesh:
            self._mesh, self._scratch = mesh, make_scratch(mesh, 0)
        dragged, scratch = painter.azimuth == "dragged", self._scratch
        scratch.warm[0] = 0.0
        place_stamp(pose, dragged, stamp, stamp, tuft, surface.contact_tree, mesh.arrays, scratch)


def _poses(path: BrushPath) -> AnyArray:
    """Return the samples as poses (N, 9) of `place_stamp`."""
    poses = np.zeros((len(path), 9))
    poses[:, :3], poses[:, 3:7], poses[:, 8] = path.points, path.orientation, path.has_contact
    poses[:, 7] = np.nan if path.pressure is None else path.pressure
    return poses


def _between(before: AnyArray, after: AnyArray, length: float) -> AnyArray:
    """Interpolate poses (N, 9) from one to another, excluding the first."""
    distance = float(np.linalg.norm(after[:3] - before[:3]))
    cosine = float(before[3:7] @ after[3:7])
    turn = 2.0 * math.acos(min(1.0, abs(cosine)))
    steps = min(_MOST_STEPS, max(1, math.ceil(max(distance / (_STEP * length), turn / _TURN))))
    t = (np.arange(1, steps + 1) / steps)[:, None]
    poses: AnyArray = (1.0 - t) * before + t * after
    poses[:, 8] = after[8]
    q = (1.0 - t) * before[3:7] + t * (after[3:7] if cosine >= 0.0 else -after[3:7])
    poses[:, 3:7] = q / np.linalg.norm(q, axis=1, keepdims=True)
    return poses


def _driven(painter: Painter, path: BrushPath, k: int, stamp: Stamp) -> Tuft:
    """Return the tuft with stiffness and spread as driven by the hand at sample k."""
    tuft, values, inputs = painter.tuft, stamp.values[0], np.zeros(N_INPUTS)
    if not painter.curves.any[0]:
        return tuft
    curves = painter.curves._replace(inputs=inputs)  # not the painter's own, which painting fills
    inputs[PRESSURE] = values["pressure"] if path.pressure is None else path.pressure[k]
    inputs[TILT] = math.degrees(values["tilt"]) if values["tilt"] > 0.0 else 90.0
    inputs[INK_LEFT] = painter.surface.ink.load.sum() / tuft.load
    if k:
        step = path.points[k] - path.points[k - 1]
        chord = float(np.linalg.norm(step))
        inputs[SPEED] = chord / (path.time_s[k] - path.time_s[k - 1])
        if k > 1 and chord > 1e-6:
            last = path.points[k - 1] - path.points[k - 2]
            turned = math.atan2(float(np.linalg.norm(np.cross(last, step))), float(last @ step))
            inputs[CURVATURE] = turned / chord
    press = tuft.full_press / drive_factor(curves, STIFFNESS)
    return tuft._replace(
        full_press=min(press, tuft.greatest_fraction * tuft.length),
        spread=tuft.spread * drive_factor(curves, SPREAD),
    )


def _beyond_solid(painted: Stamp, solid: Stamp) -> _Hairs | None:
    """Return the difference of a stamp of hairs from a solid tuft's; None unless both touch."""
    hairs, own = painted.values[0], solid.values[0]
    if hairs["touches"] <= 0.0 or own["touches"] <= 0.0:
        return None
    n = PROFILE_CELLS + 1
    wider = np.ones(n)
    inside = solid.half_widths[:n] > 1e-3
    wider[inside] = painted.half_widths[:n][inside] / solid.half_widths[:n][inside]
    aside = float((hairs["origin"] - own["origin"]) @ own["cross"])
    tip, heel = float(hairs["tip"] - own["tip"]), float(hairs["heel"] - own["heel"])
    return _Hairs(tip, heel, np.minimum(wider, _WIDER), aside)


def _pressed(
    painter: Painter, pose: AnyArray, stamp: Stamp, tuft: Tuft, hairs: _Hairs | None
) -> PressedTuft | None:
    """Return the tuft that a stamp describes; None if it touches nothing."""
    values = stamp.values[0]
    if values["triangle"] < 0 or values["touches"] <= 0.0 or values["area"] <= 0.0:
        return None
    origin, widths = values["origin"].copy(), stamp.half_widths[: PROFILE_CELLS + 1].copy()
    heel, tip = float(values["heel"]), float(values["tip"])
    if hairs is not None and tip + hairs.tip > heel + hairs.heel:
        heel, tip = heel + hairs.heel, tip + hairs.tip
        origin += hairs.aside * values["cross"]
        widths *= hairs.wider
    return PressedTuft(
        origin=origin,
        normal=values["normal"].copy(),
        bend=values["bend"].copy(),
        descent=float(values["descent"]),
        tilt=float(values["tilt"]),
        pressure=float(values["pressure"]),
        heel=heel,
        tip=tip,
        half_widths=widths,
        spread=float(tuft.spread),
        clumps=_clumps(painter, pose, values),
    )


def _clumps(painter: Painter, pose: AnyArray, values: AnyArray) -> Clumps | None:
    """Return how the hairs have parted and set, from their memory, relative to the present bend."""
    hairs = painter.hairs
    if hairs is None:
        return None
    ahead = matrices_from_quaternions(pose[None, 3:7])[0][:, 0]
    cosine, sine = float(ahead @ values["bend"]), -float(ahead @ values["cross"])
    norm = math.hypot(cosine, sine)
    cosine, sine = (cosine / norm, sine / norm) if norm > 1e-9 else (1.0, 0.0)
    stays = math.exp(-max(float(values["descent"]), 0.0) / hairs.bristles.set_mm)
    x, y = float(hairs.memory[0]), float(hairs.memory[1])
    pulls = np.empty(3)
    clump_pulls(float(hairs.memory[PARTED]), float(hairs.memory[SPLIT]), pulls)
    return Clumps(
        hairs.bristles.clumps,
        pulls,
        stays * (cosine * x + sine * y),
        stays * (cosine * y - sine * x),
    )
