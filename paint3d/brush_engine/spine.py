"""The resting shape of a bent tuft: least bending energy over a plane (completes Guo 2017, Eq. 1).

The papers give one condition, the height of the root, for the angles of the spine. The missing ones
follow from the least energy

    E = 1/2 sum_j k_j (beta_{j+1} - beta_j)^2,   beta_{m+1} = theta (clamped in the holder)

under sum_j l_j sin(beta_j) = LE sin(theta) - D_s and beta_j >= 0 (hairs lie on the plane, never
under it). With the multiplier lambda of the height (the force on the tip), Newton's method on

    dE/dbeta_j + lambda l_j cos(beta_j) = 0

is a tridiagonal system with one border; arcs that the plane holds flat leave the system.

The stiffness is a power of the arc length and the tip is free, so a tuft that is pressed a little
less has the same shape, smaller: each shape is the guess of the next one, drawn together.
"""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["solve_bending", "tabulate_bending"]

_ITERATIONS = 80
_LONGEST_TURN = 0.3  # rad, the most that one step may turn an arc
_TOLERANCE = 1e-11
_ROUNDING = 1e-8  # rad, between which a shape may go to and fro on some processors for ever
_LYING = 2.0  # of the descent: arcs so far from the tip stand straight in the first guess


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
def _first_free(lengths, stiffness, multiplier, angles):
    """The lowest arc that the plane does not hold flat: it presses on those below."""
    first = 0
    while first < angles.shape[0] - 1 and angles[first] <= 0.0:
        above = angles[first + 1]
        if -stiffness[first] * above + multiplier * lengths[first] < 0.0:
            break
        first += 1
    return first


@kernel
def _turn(angles, first, scale, step):
    """Turn the arcs from `first` on, none below the plane; whether any was held back."""
    clipped = False
    for j in range(first, angles.shape[0]):
        angles[j] += scale * step[j]
        if angles[j] < 0.0:
            angles[j] = 0.0
            clipped = True
    return clipped


@kernel
def solve_bending(lengths, stiffness, tilt, height, multiplier, angles):
    """Angles of least bending energy with the root at a height, from a guess.

    The minimum of docs/model.md, equation (2), by the Newton iteration above.

    Parameters
    ----------
    lengths, stiffness : (M,) float64
        l_j of the arcs and k_j of the joints above them, tip first; k_m belongs to the clamp in the
        holder.
    tilt : float
        theta, rad.
    height : float
        LE sin(theta) - D_s, in the lengths' unit.
    multiplier : float
        Guess of lambda.
    angles : (M,) float64
        Guess in, solution out, rad.

    Returns
    -------
    multiplier : float
        NaN where the iteration did not settle.
    """
    m, largest = lengths.shape[0], math.inf
    diagonal, off, ratio = np.empty(m), np.empty(m), np.empty(m)
    step, border, slopes = np.empty(m), np.empty(m), np.empty(m)
    for _ in range(_ITERATIONS):
        first = _first_free(lengths, stiffness, multiplier, angles)
        gap = -height
        for j in range(first, m):
            rise = lengths[j] * math.sin(angles[j])
            gap += rise
            above = angles[j + 1] if j < m - 1 else tilt
            gradient = -stiffness[j] * (above - angles[j])
            bend = stiffness[j]
            if j > 0:
                gradient += stiffness[j - 1] * (angles[j] - angles[j - 1])
                bend += stiffness[j - 1]
            slopes[j] = lengths[j] * math.cos(angles[j])
            step[j] = -gradient
            border[j] = slopes[j]
            diagonal[j] = bend - multiplier * rise
            off[j] = -stiffness[j]
        _solve_tridiagonal(diagonal, off, step, border, ratio, first, m)
        reach, pull = gap, 0.0
        for j in range(first, m):
            reach += slopes[j] * step[j]
            pull += slopes[j] * border[j]
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
    return multiplier if largest < _ROUNDING else math.nan


@kernel
def _draw_together(middles, shape, fraction, tilt, out):
    """A shape drawn together towards the tip by a fraction below 1; straight beyond its end."""
    m = middles.shape[0]
    k = 0
    for j in range(m):
        at = middles[j] / fraction
        while k < m - 2 and middles[k + 1] < at:
            k += 1
        part = (at - middles[k]) / (middles[k + 1] - middles[k])
        if at >= middles[m - 1]:
            out[j] = tilt
        else:
            out[j] = shape[k] + max(part, 0.0) * (shape[k + 1] - shape[k])


@kernel
def tabulate_bending(arcs, stiffness, exponent, tilts, fractions, out_angles):
    """Solve the bending over a grid, each tilt followed from the deepest press upwards.

    Parameters
    ----------
    arcs : (M + 1,) float64
        Arc lengths of the joints from the tip, 0 to 1.
    stiffness : (M,) float64
        k_j of the joints above the arcs.
    exponent : float
        q, of the stiffness over the arc length.
    tilts : (T,) float64
        rad.
    fractions : (D,) float64
        Descent over the straight tuft's height, rising from 0.
    out_angles : (T, D, M) float64
        rad.

    Returns
    -------
    failures : int
        How many points of the grid did not settle.
    """
    m, last = stiffness.shape[0], fractions.shape[0] - 1
    lengths, middles, guess = np.empty(m), np.empty(m), np.empty(m)
    for j in range(m):
        lengths[j] = arcs[j + 1] - arcs[j]
        middles[j] = 0.5 * (arcs[j + 1] + arcs[j])
    failures = 0
    for i in range(tilts.shape[0]):
        tilt, tallest = tilts[i], math.sin(tilts[i])
        out_angles[i, 0, :] = tilt
        multiplier = 0.0
        for k in range(last, 0, -1):
            if k == last:
                for j in range(m):
                    lying = min(1.0, middles[j] / (_LYING * tallest * fractions[k]))
                    guess[j] = tilt * lying * lying
            else:
                fraction = fractions[k] / fractions[k + 1]
                _draw_together(middles, out_angles[i, k + 1], fraction, tilt, guess)
                multiplier *= fraction ** (exponent - 2.0)
            height = tallest * (1.0 - fractions[k])
            multiplier = solve_bending(lengths, stiffness, tilt, height, multiplier, guess)
            out_angles[i, k] = guess
            if math.isnan(multiplier):
                failures += 1
                multiplier = 0.0
    return failures
