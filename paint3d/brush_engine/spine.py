"""The resting shape of a bent tuft: least bending energy over a plane (completes Guo 2017, Eq. 1).

The papers give one condition, the height of the root, for m angles. The missing ones follow from
the least energy

    E = 1/2 sum_j k_j (beta_{j+1} - beta_j)^2,   beta_{m+1} = theta (clamped in the holder)

under sum_j le_j sin(beta_j) = LE sin(theta) - D_s and beta_j >= 0 (hairs lie on the plane, never
under it). With the multiplier lambda of the height (the force on the tip), Newton's method on

    dE/dbeta_j + lambda le_j cos(beta_j) = 0

is a tridiagonal system with one border; segments that the plane holds flat leave the system.
"""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["solve_bending", "tabulate_bending"]

_ITERATIONS = 80
_LONGEST_TURN = 0.3  # rad, the most that one step may turn a segment
_TOLERANCE = 1e-11


@kernel
def _solve_tridiagonal(diagonal, off, right_a, right_b, ratio, first, m):
    """Solve rows first..m-1 for two right sides at once, in place (Thomas)."""
    for j in range(first, m):
        pivot = diagonal[j]
        if j > first:
            pivot -= off[j - 1] * ratio[j - 1]
            right_a[j] -= off[j - 1] * right_a[j - 1]
            right_b[j] -= off[j - 1] * right_b[j - 1]
        if j < m - 1:
            ratio[j] = off[j] / pivot
        right_a[j] /= pivot
        right_b[j] /= pivot
    for j in range(m - 2, first - 1, -1):
        right_a[j] -= ratio[j] * right_a[j + 1]
        right_b[j] -= ratio[j] * right_b[j + 1]


@kernel
def _first_free(segment_lengths, joint_stiffness, multiplier, angles):
    """The lowest segment that the plane does not hold flat: it presses on those below."""
    first = 0
    while first < angles.shape[0] - 1 and angles[first] <= 0.0:
        above = angles[first + 1]
        if -joint_stiffness[first] * above + multiplier * segment_lengths[first] < 0.0:
            break
        first += 1
    return first


@kernel
def _turn(angles, first, scale, step):
    """Turn the segments from `first` on, none below the plane; whether any was held back."""
    clipped = False
    for j in range(first, angles.shape[0]):
        angles[j] += scale * step[j]
        if angles[j] < 0.0:
            angles[j] = 0.0
            clipped = True
    return clipped


@kernel
def solve_bending(segment_lengths, joint_stiffness, tilt, height, multiplier, angles):
    """Angles of least bending energy with the root at a height, from a guess.

    The minimum of docs/model.md, equation (1), by the Newton iteration above.

    Parameters
    ----------
    segment_lengths, joint_stiffness : (M,) float64
        le_j (mm) and k_j, tip first; k_m belongs to the clamp in the holder.
    tilt : float
        theta, rad.
    height : float
        LE sin(theta) - D_s, mm.
    multiplier : float
        Guess of lambda.
    angles : (M,) float64
        Guess in, solution out, rad.

    Returns
    -------
    multiplier : float
        NaN where the iteration did not settle.
    """
    m = segment_lengths.shape[0]
    diagonal, off, ratio = np.empty(m), np.empty(m), np.empty(m)
    step, border = np.empty(m), np.empty(m)
    for _ in range(_ITERATIONS):
        first = _first_free(segment_lengths, joint_stiffness, multiplier, angles)
        gap = -height
        for j in range(m):
            gap += segment_lengths[j] * math.sin(angles[j])
        for j in range(first, m):
            above = angles[j + 1] if j < m - 1 else tilt
            slope = segment_lengths[j] * math.cos(angles[j])
            gradient = -joint_stiffness[j] * (above - angles[j])
            bend = joint_stiffness[j]
            if j > 0:
                gradient += joint_stiffness[j - 1] * (angles[j] - angles[j - 1])
                bend += joint_stiffness[j - 1]
            step[j] = -gradient
            border[j] = slope
            diagonal[j] = bend - multiplier * segment_lengths[j] * math.sin(angles[j])
            off[j] = -joint_stiffness[j]
        _solve_tridiagonal(diagonal, off, step, border, ratio, first, m)
        reach, pull = gap, 0.0
        for j in range(first, m):
            slope = segment_lengths[j] * math.cos(angles[j])
            reach += slope * step[j]
            pull += slope * border[j]
        new_multiplier = reach / pull
        largest = 0.0
        for j in range(first, m):
            step[j] -= new_multiplier * border[j]
            largest = max(largest, abs(step[j]))
        scale = min(1.0, _LONGEST_TURN / largest) if largest > 0.0 else 1.0
        multiplier += scale * (new_multiplier - multiplier)
        clipped = _turn(angles, first, scale, step)
        if largest < _TOLERANCE and not clipped:
            return multiplier
    return math.nan


@kernel
def tabulate_bending(segment_lengths, joint_stiffness, tilts, fractions, out_angles):
    """Solve the bending over a grid, each tilt followed from the straight tuft downwards.

    Parameters
    ----------
    segment_lengths, joint_stiffness : (M,) float64
    tilts : (T,) float64
        rad.
    fractions : (D,) float64
        Descent over the straight tuft's height, rising from 0.
    out_angles : (T, D, M) float64

    Returns
    -------
    failures : int
        How many points of the grid did not settle.
    """
    m = segment_lengths.shape[0]
    length = segment_lengths.sum()
    guess = np.empty(m)
    failures = 0
    for i in range(tilts.shape[0]):
        out_angles[i, 0, :] = tilts[i]
        tallest = length * math.sin(tilts[i])
        multiplier = 0.0
        for k in range(1, fractions.shape[0]):
            height = tallest * (1.0 - fractions[k])
            if k == 1:  # let the tip alone take up the first descent
                guess[:] = tilts[i]
                lowered = math.sin(tilts[i]) - tallest * fractions[k] / segment_lengths[0]
                guess[0] = math.asin(max(lowered, 0.0))
                turn = joint_stiffness[0] * (tilts[i] - guess[0])
                multiplier = turn / (segment_lengths[0] * math.cos(guess[0]))
            else:
                guess[:] = out_angles[i, k - 1]
            multiplier = solve_bending(
                segment_lengths, joint_stiffness, tilts[i], height, multiplier, guess
            )
            out_angles[i, k] = guess
            if math.isnan(multiplier):
                failures += 1
                multiplier = 0.0
    return failures
