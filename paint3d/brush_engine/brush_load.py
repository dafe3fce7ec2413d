"""A tuft that holds different ink along its length: the classic loading, tip dark and belly light.

The load lies in reservoirs from the tip to the root, all filled alike: when the part that touches
gives ink, the rest flows down to it, as in a wet tuft the capillaries see to. The tuft lies along
its footprint, so a vertex at a distance s behind the tip is painted by what is s up the tuft.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from paint3d.core.kernel import kernel, uncounted

__all__ = ["Deposit", "leave_from_reservoirs", "level_reservoirs"]

_MOST_PASSES = 1000
_SHARE = 0.45  # of a reservoir, the most that flows out of it on one side in one pass


@uncounted(error_model="numpy")
def _behind_tip(values, field, v):
    """Distance (mm) of a vertex behind the tip of a stamp, along the bend."""
    dx = field.px[v] - values.origin[0]
    dy = field.py[v] - values.origin[1]
    dz = field.pz[v] - values.origin[2]
    reach = dx * values.bend[0] + dy * values.bend[1] + dz * values.bend[2]
    return values.tip - reach


@uncounted(error_model="numpy")
def _reservoir(before, after, field, v, reach, last):
    """Place of a vertex on the tuft, in reservoirs from the tip: middle of the first is 0."""
    a, b = before.values[0], after.values[0]
    if a.touches > 0.0 and b.touches > 0.0:
        behind = 0.5 * (_behind_tip(a, field, v) + _behind_tip(b, field, v))
    elif b.touches > 0.0:
        behind = _behind_tip(b, field, v)
    else:
        behind = _behind_tip(a, field, v)
    return min(max(behind / reach - 0.5, 0.0), np.float64(last))


class Deposit(NamedTuple):
    """What a brush gives on its way from one stamp to the next, coats x mm2."""

    released: float  # what leaves it
    landing: float  # what of that lands on vertices; the rest runs off the surface's edge
    weighed: float  # mm2, the area that those stand for


@kernel(error_model="numpy")
def leave_from_reservoirs(before, after, deposit, found, n, field, ink, taken):
    """Leave what lands of a deposit on the vertices found, each from the reservoirs that touch it.

    The rest of it runs off; `taken` (P,) that the brush took up meanwhile goes to where it touches.
    Conserves: the reservoirs, what was left and what ran off add up.
    """
    reservoirs = ink.reservoirs
    count, n_pigments = reservoirs.shape
    last = count - 1
    reach = ink.transfer[0].reservoir_mm
    ids, share, areas, unit = found.ids, found.share, field.area_units, field.area_unit
    amounts = ink.amounts
    demand = np.zeros(count)
    for k in range(n):
        v = ids[k]
        at = _reservoir(before, after, field, v, reach, last)
        i = min(np.int64(at), last - 1)
        part = share[k] * areas[v] * unit
        demand[i] += part * (1.0 - (at - i))
        demand[i + 1] += part * (at - i)
    total = demand.sum()
    if total <= 0.0:
        demand[0] = 1.0
        total = 1.0
    density = np.zeros((count, n_pigments))  # left per weighed mm2, by reservoir
    for i in range(count):
        wanted = deposit.released * demand[i] / total
        held = reservoirs[i].sum()
        given = min(wanted, held)
        if given <= 0.0:
            continue
        landed = given * (deposit.landing / deposit.released)
        for p in range(n_pigments):
            part = reservoirs[i, p] / held
            ink.off_surface[p] += part * (given - landed)
            density[i, p] = part * landed / demand[i] if deposit.weighed > 0.0 else 0.0
            reservoirs[i, p] -= part * given
    for k in range(n):
        v = ids[k]
        at = _reservoir(before, after, field, v, reach, last)
        i = min(np.int64(at), last - 1)
        t = at - i
        for p in range(n_pigments):
            amounts[v, p] += np.float32(
                share[k] * ((1.0 - t) * density[i, p] + t * density[i + 1, p])
            )
    for i in range(count):
        for p in range(n_pigments):
            reservoirs[i, p] += taken[p] * demand[i] / total
    level_reservoirs(reservoirs)
    for p in range(n_pigments):
        ink.load[p] = reservoirs[:, p].sum()


@kernel(error_model="numpy")
def level_reservoirs(reservoirs):
    """Let liquid run along the tuft until all reservoirs (N, P) are filled alike."""
    count, n_pigments = reservoirs.shape
    held = np.empty(count)
    passing = np.empty(count - 1)  # from reservoir i + 1 to reservoir i
    for _ in range(_MOST_PASSES):
        for i in range(count):
            held[i] = reservoirs[i].sum()
        mean = held.sum() / count
        towards_tip = 0.0
        held_back = False
        for i in range(count - 1):
            towards_tip += mean - held[i]
            source = i + 1 if towards_tip > 0.0 else i
            most = _SHARE * held[source]
            passing[i] = min(max(towards_tip, -most), most)
            held_back = held_back or abs(towards_tip) > most
        old = reservoirs.copy()
        for i in range(count - 1):
            source = i + 1 if passing[i] > 0.0 else i
            if held[source] <= 0.0:
                continue
            for p in range(n_pigments):
                moved = passing[i] * old[source, p] / held[source]
                reservoirs[i, p] += moved
                reservoirs[i + 1, p] -= moved
        if not held_back:
            break
