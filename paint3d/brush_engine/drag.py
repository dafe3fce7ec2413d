"""The dragged tuft: a tractrix with slack, which lets the paper turn the brush.

With H the handle's foot P'_m and Q the dragged contact, r = Q - H. While |r| is below the slack
l(D_s) the contact sticks; beyond, it follows at the distance l. The bend direction is that of r.
The law knows no time, only the path (closed form of the discrete rule published with Wang et al.,
"Robot Calligraphy using Pseudospectral Optimal Control in Conjunction with a Novel Dynamic Brush
Model", IROS 2020, whose measured brush gives l).
"""

from __future__ import annotations

import math

from paint3d.core.kernel import uncounted

__all__ = ["STEPS_PER_SLACK", "drag_along", "drag_length", "drag_step", "release"]

MEASURED_LENGTH = 30.0  # mm, the tuft on which the lengths below were measured
STEPS_PER_SLACK = 40  # the longest step that a chord may follow is l / 40


@uncounted
def drag_step(rx, ry, rz, dx, dy, dz, slack):
    """r after the handle moved by d: the contact sticks, or follows at the distance `slack`.

    Repeated along a straight way it gives docs/model.md, equation (2).

    Parameters
    ----------
    rx, ry, rz : float
        Q - H before the step, mm.
    dx, dy, dz : float
        Movement of H, mm; at most a fortieth of `slack`, for it is followed as a chord.
    slack : float
        l, mm.

    Returns
    -------
    rx, ry, rz : float
        Q - H after it, never longer than `slack`.
    """
    rx, ry, rz = rx - dx, ry - dy, rz - dz
    square = rx * rx + ry * ry + rz * rz
    if square > slack * slack:
        scale = slack / math.sqrt(square)
        return rx * scale, ry * scale, rz * scale
    return rx, ry, rz


@uncounted
def release(rx, ry, rz, plasticity):
    """r after the pen is lifted: the direction stays, the length is scaled by rho."""
    return rx * plasticity, ry * plasticity, rz * plasticity


@uncounted
def drag_length(descent, length_mm, fraction):
    """Slack l (mm) between the handle and its dragged contact.

    Measured on a tuft of 30 mm as a power of the depth for three fractions c of the drag, with
    linear interpolation between them; other tufts are taken as similar in shape.

    Parameters
    ----------
    descent : float
        D_s, mm, not negative.
    length_mm : float
        LE, mm.
    fraction : float
        c, 0 to 1/2.
    """
    scale = length_mm / MEASURED_LENGTH
    depth = descent / scale
    middle = 0.92 * depth**0.84
    if fraction < 1.0 / 3.0:
        share = 3.0 * fraction
        return scale * (0.61 * depth**0.78 * (1.0 - share) + middle * share)
    share = 6.0 * (fraction - 1.0 / 3.0)
    return scale * (middle * (1.0 - share) + 1.19 * depth**0.81 * share)


@uncounted
def drag_along(handle, slack, rx, ry, out):
    """Contact Q (N, 2) under a plane track of the handle (N, 2), by steps of at most l / 40.

    Parameters
    ----------
    handle : (N, 2) float64
        H, mm.
    slack : (N,) float64
        l, mm, more than 0, linear between samples.
    rx, ry : float
        Q - H at the first sample.
    out : (N, 2) float64
        Q, mm.
    """
    out[0, 0], out[0, 1] = handle[0, 0] + rx, handle[0, 1] + ry
    for i in range(1, handle.shape[0]):
        dx = handle[i, 0] - handle[i - 1, 0]
        dy = handle[i, 1] - handle[i - 1, 1]
        shortest = min(slack[i - 1], slack[i])
        n = max(1, math.ceil(STEPS_PER_SLACK * math.hypot(dx, dy) / shortest))
        for k in range(1, n + 1):
            length = slack[i - 1] + (slack[i] - slack[i - 1]) * k / n
            rx, ry, _ = drag_step(rx, ry, 0.0, dx / n, dy / n, 0.0, length)
        out[i, 0], out[i, 1] = handle[i, 0] + rx, handle[i, 1] + ry
