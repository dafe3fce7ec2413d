"""The drag of a tuft: how the paper pulls it aside, turns it and holds its tip.

The dragged tuft is a tractrix with slack: with H the handle's foot P'_m and Q the dragged contact,
r = Q - H. While |r| is below the slack l(D_s) the contact sticks; beyond, it follows at the
distance l. The bend direction is that of r. The law knows no time, only the path (closed form of
the discrete rule published with Wang et al., "Robot Calligraphy using Pseudospectral Optimal
Control in Conjunction with a Novel Dynamic Brush Model", IROS 2020, whose measured brush gives l).

A press lengthens a footprint, about as fast as a hand goes on meanwhile. Counted from H alone, the
tip would slide back and aside over the paper on which it lies. But hairs are trailed and not
pushed: the tip of a dragged tuft stays where it is until the heel, where the tuft leaves the paper,
pulls it on. While it slides, the tuft's spring brings it back into its bend.
"""

from __future__ import annotations

import math

from paint3d.core.kernel import uncounted

__all__ = [
    "MEASURED_LENGTH",
    "bent_by_twist",
    "drag_along",
    "drag_length",
    "drag_step",
    "drag_way",
    "hold_along",
    "lie_held",
    "release",
    "smooth_step",
    "trail_step",
    "twist_step",
]

MEASURED_LENGTH = 30.0  # mm, the tuft on which `drag_length` was measured
_UNTWISTS = 0.12  # of the slack: over this way a tuft comes round to its azimuth
_TWISTED = (0.4, 1.4)  # rad that it lags behind: from lying in its bend to lying in a heap
_SAME_SLACK = 0.05  # of a slack: a step on which it changes by more is cut
_MOST_SLACKS = 20
_HOLDS = 3.0  # mm of way to the mm of press, up to which the paper holds the tip fast
_SLACK = 0.2  # of the footprint's length: as slack a tip that was held stays where it is
_PULLS = 2.0  # to the mm of way that a heel goes away from a slack tip, from which on this stays
_SPRINGS = 0.5  # of the footprint's length: over this way a sliding tip comes back into its bend
_TOLD = 0.5  # of the length: a tip nearer to its heel tells less of how a footprint lies
_NOWHERE = 1e-9  # mm: a tip under its heel lies in no direction


@uncounted
def drag_step(rx, ry, rz, dx, dy, dz, slack):
    """r after the handle moved straight on by d: the contact sticks, or follows along a tractrix.

    It sticks until it lies `slack` behind; from there on docs/model.md, equation (3), holds.

    Parameters
    ----------
    rx, ry, rz : float
        Q - H before the step, mm; what is longer than `slack` is drawn in first.
    dx, dy, dz : float
        Movement of H, mm.
    slack : float
        l, mm.

    Returns
    -------
    rx, ry, rz : float
        Q - H after it, never longer than `slack`.
    """
    square = rx * rx + ry * ry + rz * rz
    if square > slack * slack:
        scale = slack / math.sqrt(square)
        rx, ry, rz = rx * scale, ry * scale, rz * scale
        square = slack * slack
    way = math.sqrt(dx * dx + dy * dy + dz * dz)
    if way <= 0.0 or slack <= 0.0:
        return rx, ry, rz
    ux, uy, uz = dx / way, dy / way, dz / way
    ahead = rx * ux + ry * uy + rz * uz
    beside = math.sqrt(max(0.0, square - ahead * ahead))
    sine = min(1.0, beside / slack)
    cosine = math.sqrt(1.0 - sine * sine)
    free = ahead + slack * cosine  # the way until Q lies l behind
    if way <= free:
        return rx - dx, ry - dy, rz - dz
    half = sine / (1.0 + cosine) * math.exp(-(way - free) / slack)  # tan(delta / 2)
    back = slack * (1.0 - half * half) / (1.0 + half * half)
    aside = slack * 2.0 * half / (1.0 + half * half) / beside if beside > 0.0 else 0.0
    return (
        aside * (rx - ahead * ux) - back * ux,
        aside * (ry - ahead * uy) - back * uy,
        aside * (rz - ahead * uz) - back * uz,
    )


@uncounted
def drag_way(rx, ry, rz, dx, dy, dz, before, slack):
    """`drag_step` where the slack goes evenly from `before` to `slack`, mm, on the way."""
    change = abs(slack - before)
    n = 1
    if change > 0.0:
        n = min(_MOST_SLACKS, math.ceil(change / (_SAME_SLACK * max(slack, before))))
    for k in range(1, n + 1):
        now = before + (slack - before) * k / n
        rx, ry, rz = drag_step(rx, ry, rz, dx / n, dy / n, dz / n, now)
    return rx, ry, rz


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
        fraction = 3.0 * fraction
        return scale * (0.61 * depth**0.78 * (1.0 - fraction) + middle * fraction)
    fraction = 6.0 * (fraction - 1.0 / 3.0)
    return scale * (middle * (1.0 - fraction) + 1.19 * depth**0.81 * fraction)


@uncounted
def drag_along(handle, slack, rx, ry, out):
    """Contact Q (N, 2) under a plane track of the handle (N, 2), by the law of straight ways.

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
        rx, ry, _ = drag_way(rx, ry, 0.0, dx, dy, 0.0, slack[i - 1], slack[i])
        out[i, 0], out[i, 1] = handle[i, 0] + rx, handle[i, 1] + ry


@uncounted
def release(rx, ry, rz, plasticity):
    """r after the pen is lifted: the direction stays, the length is scaled by rho."""
    return rx * plasticity, ry * plasticity, rz * plasticity


@uncounted
def smooth_step(x):
    """From 0 at 0 to 1 at 1, level at both."""
    x = min(1.0, max(0.0, x))
    return x * x * (3.0 - 2.0 * x)


@uncounted
def twist_step(twist, turned, way, slack):
    """The angle by which the paper holds a commanded tuft back behind its azimuth.

    What the handle turns by on the spot stays; over a way the tuft comes round. See
    docs/model.md, section 2.

    Parameters
    ----------
    twist : float
        Before the step, rad.
    turned : float
        How far the azimuth turns, rad, with its sign.
    way : float
        Of H, mm.
    slack : float
        l, mm.

    Returns
    -------
    twist : float
        After it, rad; no more than what makes a heap of the tuft.
    """
    twist = (twist + turned) * math.exp(-way / max(_UNTWISTS * slack, 1e-9))
    return min(_TWISTED[1], max(-_TWISTED[1], twist))


@uncounted
def bent_by_twist(twist):
    """Degree to which a tuft with such a twist (rad) lies in its bend, 0 to 1."""
    return 1.0 - smooth_step((abs(twist) - _TWISTED[0]) / (_TWISTED[1] - _TWISTED[0]))


@uncounted
def trail_step(along, across, aside, short, length, way, pressed, bent):
    """Trail the tip behind its heel after that has moved: docs/model.md, equation (4a).

    Parameters
    ----------
    along, across : float
        From the heel, where it is now, to where the tip lay, along the bend and across it, mm.
    aside, short : float
        Before the step: the angle by which the tip lay aside of the bend, rad, and how much nearer
        to the heel it lay than the footprint is long, mm.
    length : float
        Of the footprint now, mm, more than 0.
    way : float
        Of the root's foot since, mm.
    pressed : float
        How much deeper the tuft came meanwhile, mm; less than 0 as it is lifted.
    bent : float
        How far it lies in its bend, 0 to 1; the edge of a heap is not held but spreads.

    Returns
    -------
    aside, short : float
        After it.
    """
    distance = math.hypot(along, across)
    slack = max(0.0, length - distance)
    held = min(1.0, max(0.0, short - way) / (_SLACK * length))
    if way > 0.0:
        held *= min(1.0, max(0.0, _PULLS * (short - slack) / way))
    if pressed > 0.0:
        held = max(held, min(1.0, _HOLDS * pressed / way) if way > 0.0 else 1.0)
    held *= bent
    short = max(0.0, short - way)
    if held > 0.0:
        if distance > _NOWHERE:
            aside += held * _turn(math.atan2(across, along) - aside)
        short += held * (slack - short)
    aside *= math.exp(-(1.0 - held) * way / (_SPRINGS * length))
    return _turn(aside), min(short, length)


@uncounted
def lie_held(aside, short, length, bent):
    """Turn and shorten a footprint whose tip lies so far aside and so much nearer to its heel.

    A tuft in a heap has no tip to be held by, and one whose tip is under its heel no direction: as
    it comes there it lies in its bend. See docs/model.md, section 2.

    Parameters
    ----------
    aside, short : float
        Of `trail_step`; rad, mm.
    length : float
        Of the footprint in its bend, mm, more than 0.
    bent : float
        How far the tuft lies in its bend, 0 to 1.

    Returns
    -------
    cosine, sine : float
        Of the angle by which it is turned about its heel.
    shorter : float
        mm.
    """
    told = bent * smooth_step((length - short) / (_TOLD * length))
    x, y = 1.0 + told * (math.cos(aside) - 1.0), told * math.sin(aside)
    norm = math.hypot(x, y)
    if norm <= _NOWHERE:
        return 1.0, 0.0, told * short
    return x / norm, y / norm, told * short


@uncounted
def hold_along(handle, azimuth, descent, heel, length, out):
    """Turn and shorten footprints whose tips the paper holds, under a plane track of the handle.

    Parameters
    ----------
    handle : (N, 2) float64
        H, mm.
    azimuth : (N,) float64
        Of the bend, rad; the tuft lies in it.
    descent, heel, length : (N,) float64
        D_s, how far the heel lies from H along the bend, and of the footprint, mm.
    out : (N, 2) float64
        By which angle each is turned about its heel, rad, and how much shorter it is, mm.
    """
    tip_x, tip_y, aside, short = 0.0, 0.0, 0.0, 0.0
    for k in range(handle.shape[0]):
        x, y = math.cos(azimuth[k]), math.sin(azimuth[k])
        heel_x, heel_y = handle[k, 0] + heel[k] * x, handle[k, 1] + heel[k] * y
        if k > 0:
            dx, dy = tip_x - heel_x, tip_y - heel_y
            way = math.hypot(handle[k, 0] - handle[k - 1, 0], handle[k, 1] - handle[k - 1, 1])
            pressed = descent[k] - descent[k - 1]
            along, across = dx * x + dy * y, dy * x - dx * y
            aside, short = trail_step(along, across, aside, short, length[k], way, pressed, 1.0)
        lies = azimuth[k] + aside
        tip_x = heel_x + (length[k] - short) * math.cos(lies)
        tip_y = heel_y + (length[k] - short) * math.sin(lies)
        cosine, sine, shorter = lie_held(aside, short, length[k], 1.0)
        out[k, 0], out[k, 1] = math.atan2(sine, cosine), shorter


@uncounted
def _turn(angle):
    """An angle of at most two turns, within half a turn."""
    if angle > math.pi:
        return angle - 2.0 * math.pi
    if angle < -math.pi:
        return angle + 2.0 * math.pi
    return angle
