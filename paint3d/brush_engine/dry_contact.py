"""Where a brush that runs dry touches: bundles of hairs against the tooth of the sheet (feibai).

The supply of every bundle varies across the tuft and slowly along its way; the sheet's tooth breaks
it. Both are gradient noise (Perlin 1985): no state, no seed, so a painting is repeatable. Bundles
are told by their place across the way, at the belly's scale, for hairs draw together towards the
tip; along it they are anchored to the surface, so that a passing footprint does not smear them. The
tooth is a function of the place in space alone, whatever the vertices, and its lattice lies askew,
so that no direction of the object shows. A film drags on a little behind what it has wetted.

Bumps that the vertices are too far apart to show are left out, and their spread goes into the
softness of the contact: coarse vertices show the grey of what fine ones show as streaks.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import kernel, uncounted
from paint3d.mesh.kernels.mesh_arrays import mix

__all__ = [
    "BUNDLE_MM",
    "DryContact",
    "bundle_noise",
    "contact_noise",
    "dry_contact",
    "fill_noise",
    "note_way",
    "thin_contact",
    "weigh_streaks",
]

_CELLS, _STEPS = 8, 8  # of the noise's lattice to a period, and of the table to a cell
_SIDE = _CELLS * _STEPS
_MASK = _SIDE - 1
_SHIFT, _SHIFT2 = 6, 12  # powers of 2 in the side of the table, and in a layer
_UP, _DOWN = (np.int32(24), np.int32(16), np.int32(8)), np.int32(24)  # bits to a byte's place
_FROM = 0.5 * _CELLS  # bundles from the edge of a period to a tuft's middle: no seam lies there
_EACH_SIDE = 4  # places to each side of it, at which the mean of broad bundles is taken
_APART = np.int32(23)  # steps along the way between periods of bundles that lie side by side
_LEVELS = 32.0  # of the table, to a standard deviation
_LAYERS = (3, 35)  # of it, that broad and narrow bundles are read from
_ASKEW = np.array(  # a turn by 1 rad about (1, 2, 3): how the tooth lies in space
    [
        [0.573138, -0.609007, 0.548292],
        [0.740349, 0.671645, -0.027879],
        [-0.351279, 0.421906, 0.835822],
    ]
)
_TOOTH = (0.3, 0.3)  # standard deviations of its bumps, coarse and fine
_FINER = 0.42  # length of the fine bumps over that of the coarse ones
_DRAGGED = 0.45  # of the coarse bumps: how far apart the film is looked for
_LOOKS = 3  # places along the way where it is
_THINS = 0.35  # what it loses from one to the next
_TOOTH_MEAN, _TOOTH_SPREAD = 0.1, 0.36  # of the highest of them, all bumps seen
_BROAD, _BROAD_WAY, _BROAD_SPREAD = 1.25, 19.0, 0.72  # bundles: mm across, mm along, std. deviation
BUNDLE_MM, _WAY, _SPREAD = 0.32, 16.0, 0.58  # the narrow ones of a solid tuft
_WANDER_MM = 0.5  # narrow ones lie aside by the supply of broad ones: they part and meet
_BROADER = 2.2  # broad ones are at least so much broader than narrow ones
_BELLY = 0.32  # of the root's diameter: half the width of a belly at whose scale bundles are told
_NARROWEST = 0.35  # of it, below which hairs draw together no more
_RIM = 0.35  # how much worse hairs at the rim are supplied
_SOFT = 0.145  # standard deviation of the softness: contact comes about over .5
_GAIN, _OFFSET = 2.4, 0.1  # of the contact level
_FLOODED, _FLOOD = 0.8, 1.5  # level from which the tuft begins to flood the rest, and by how much
_STANDS = 1.0  # standard deviations that hairs which stand touch less than those dragged along
_LEAST = np.float32(0.02)  # fraction below which nothing is touched
_LEADS_MM = 1.0  # of the way, over which it is told where it leads
_CURVES_MM, _SHARPEST = 3.0, 0.2  # mm over which the way's curve is told; 1/mm, at most
_FLOWS_MM_S, _MOST_HASTE = 220.0, 2.0  # speed at which haste is 1; clocks of devices jump
_DRAINS_MM, _FILLS_S = 50.0, 0.25  # way and time over which it follows
_SEEN = 1.6  # wavelength of bumps over their length


class DryContact(NamedTuple):
    """Numbers of the dry contact that all vertices of a sweep have in common."""

    supply: float  # of the whole tuft, standard deviations over the mean height
    mean_broad: float  # what broad bundles bring, the mean across the way, as `broad` shows it
    per_soft: float
    ahead_x: float  # direction of the way in the stamp's frame, along the bend and across
    ahead_y: float
    curve: float  # of the way to the left, 1/mm
    way: float  # mm that the tuft has gone, from where on the bundles' noise it came down
    per_broad: float  # steps of the noise to the mm across the way, for broad bundles
    per_narrow: float
    coarse: float  # how much of the bumps and bundles the vertices show
    fine: float
    broad: float
    narrow: float
    hairs: float
    step: float  # of the tooth's table to the mm, 0 for none
    step_fine: float
    drag_x: float  # mm against the way, from one look for the film to the next
    drag_y: float
    drag_z: float


@cache
def contact_noise() -> NDArray[np.int8]:
    """The noise of tooth and bundles, always the same: see `fill_noise`."""
    noise = np.empty(_SIDE**3, np.int8)
    fill_noise(noise)
    noise.setflags(write=False)
    return noise


@cache
def bundle_noise() -> NDArray[np.int32]:
    """The layers of the noise that bundles are read from, (2, S^2): in each number the bytes of a
    place in the table and of those a step across, a step along, and both; one look for four."""
    layers = contact_noise().reshape(_SIDE, _SIDE, _SIDE)[list(_LAYERS)]
    packed = np.zeros((2, _SIDE, _SIDE), np.uint32)
    for place, (across, along) in enumerate(((0, 0), (1, 0), (0, 1), (1, 1))):
        there = np.roll(layers, (-across, -along), axis=(1, 2))
        packed |= there.astype(np.uint8).astype(np.uint32) << np.uint32(8 * place)
    result = packed.reshape(2, _SIDE * _SIDE).view(np.int32)
    result.setflags(write=False)
    return result


@uncounted
def _gradient(i, j, k, axis):
    """A number in [-1, 1) for a lattice point and an axis; the lattice repeats."""
    code = np.uint64((i % _CELLS) + _CELLS * ((j % _CELLS) + _CELLS * (k % _CELLS)))
    code = mix(code * np.uint64(0x9E3779B97F4A7C15) + np.uint64(axis + 1))
    return np.float64(mix(code) >> np.uint64(11)) * 2.0**-52 - 1.0


@kernel
def fill_noise(out):
    """Tabulate gradient noise that repeats: (S^3,) int8, `_LEVELS` to a standard deviation."""
    values = np.empty(out.shape[0])
    total = 0.0
    for n in range(out.shape[0]):
        a, b, c = n >> _SHIFT2, (n >> _SHIFT) & _MASK, n & _MASK
        values[n] = _noise(a / _STEPS, b / _STEPS, c / _STEPS)
        total += values[n] * values[n]
    scale = _LEVELS / np.sqrt(total / out.shape[0])
    for n in range(out.shape[0]):
        out[n] = np.int8(min(max(scale * values[n], -127.0), 127.0))


@uncounted
def _noise(x, y, z):
    """Gradient noise with lattice points at whole numbers."""
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    u, v, w = x - i, y - j, z - k
    a = u * u * u * (u * (6.0 * u - 15.0) + 10.0)
    b = v * v * v * (v * (6.0 * v - 15.0) + 10.0)
    c = w * w * w * (w * (6.0 * w - 15.0) + 10.0)
    total = 0.0
    for p in range(2):
        for q in range(2):
            for r in range(2):
                fraction = (a if p else 1.0 - a) * (b if q else 1.0 - b) * (c if r else 1.0 - c)
                slope = _gradient(i + p, j + q, k + r, 0) * (u - p)
                slope += _gradient(i + p, j + q, k + r, 1) * (v - q)
                slope += _gradient(i + p, j + q, k + r, 2) * (w - r)
                total += fraction * slope
    return total


@uncounted(error_model="numpy")
def _seen(length, apart):
    """Fraction of bumps of a length (mm) that vertices so far apart (mm) show, 0 to 1."""
    t = min(1.0, max(0.0, 0.5 * _SEEN * length / apart - 1.0))
    return t * t * (3.0 - 2.0 * t)


@uncounted(error_model="numpy")
def note_way(before, after):
    """Note how far the outline has gone, where its way leads, how it curves, and how hasty it is.

    The way is that of what the outline is counted from, so that bundles stay where they are on the
    surface while a footprint grows or turns. Where it leads is told over some way, for a brush that
    is pressed or turned in its place sways; one that comes down lies against its way.

    Haste is the speed over that at which ink from the belly falls behind. A tuft comes down wet,
    and is drained over some way, or filled again in some time where the hand slows down or rests.
    """
    a, b = before.values[0], after.values[0]
    dx, dy, dz = (
        b.origin[0] - a.origin[0],
        b.origin[1] - a.origin[1],
        b.origin[2] - a.origin[2],
    )
    step = np.sqrt(dx * dx + dy * dy + dz * dz)
    if a.touches <= 0.0:
        b.way = b.curve = b.haste = 0.0
        for axis in range(3):
            b.heading[axis] = -b.bend[axis]
        return
    b.way = a.way + step
    stays = np.exp(-step / _DRAINS_MM - max(b.time - a.time, 0.0) / _FILLS_S)
    b.haste = stays * a.haste + (1.0 - stays) * min(_MOST_HASTE, b.speed / _FLOWS_MM_S)
    hx, hy, hz = a.heading[0], a.heading[1], a.heading[2]
    keep = np.exp(-step / _LEADS_MM)
    turn = (1.0 - keep) / max(step, 1e-9)
    dx, dy, dz = keep * hx + turn * dx, keep * hy + turn * dy, keep * hz + turn * dz
    long = np.sqrt(dx * dx + dy * dy + dz * dz)
    if step <= 1e-6 or long <= 1e-6:
        b.heading[0], b.heading[1], b.heading[2] = hx, hy, hz
        b.curve = a.curve
        return
    dx, dy, dz = dx / long, dy / long, dz / long
    left = (
        b.normal[0] * (hy * dz - hz * dy)
        + b.normal[1] * (hz * dx - hx * dz)
        + b.normal[2] * (hx * dy - hy * dx)
    )
    keep = np.exp(-step / _CURVES_MM)
    b.curve = keep * a.curve + (1.0 - keep) * left / step
    b.curve = min(_SHARPEST, max(-_SHARPEST, b.curve))
    b.heading[0], b.heading[1], b.heading[2] = dx, dy, dz


@uncounted(error_model="numpy")
def _ahead(values):
    """Direction of the way in a stamp's frame, along the bend and across."""
    x, y = 0.0, 0.0
    for axis in range(3):
        x += values.heading[axis] * values.bend[axis]
        y += values.heading[axis] * values.cross[axis]
    norm = np.sqrt(x * x + y * y)
    if norm <= 1e-6:
        return -1.0, 0.0
    return x / norm, y / norm


@uncounted(error_model="numpy")
def _per_width(values, root_mm):
    """Belly's scale, at which bundles are told, over that of a footprint: hairs draw together."""
    belly = _BELLY * root_mm
    return belly / max(values.widest, _NARROWEST * belly)


@uncounted(error_model="numpy")
def _mean_supply(ahead_x, ahead_y, values, per_mm, ink):
    """Mean across the way of what broad bundles bring: they divide what the tuft holds."""
    middle, half = _extent_across(ahead_x, ahead_y, values)
    along, total = (values.parted + values.way) / _BROAD_WAY, 0.0
    for n in range(-_EACH_SIDE, _EACH_SIDE + 1):
        across = middle + half * n / (_EACH_SIDE + 0.5)
        total += _bundle_at(_FROM + per_mm * across, along, ink.bundles[0])
    return total / (2 * _EACH_SIDE + 1)


@uncounted(error_model="numpy")
def dry_contact(level, carried, after, bundles, field, ink):
    """Compute what the vertices of a sweep have in common; docs/model.md, equation (13).

    Parameters
    ----------
    level : float
        How deep into the tooth the tuft reaches, 0 to 1.
    carried : float
        How much of its motion is its way, 0 to 1: what it is dragged over the tooth.
    after : Stamp
        With its way noted.
    bundles : (float, float, float, float)
        Diameter of the tuft, how broad the narrow bundles are at the belly, mm, how far bundles
        differ: 1 where nothing else makes streaks, and how far what hairs cover does.
    field, ink : SurfaceField, InkField
    """
    a = after.values[0]
    root, bundle, differ, hairs = bundles
    ahead_x, ahead_y = _ahead(a)
    apart, tooth = field.soft_edge, ink.transfer[0].tooth_mm
    coarse, fine = _seen(tooth, apart), _seen(_FINER * tooth, apart)
    scale, broad_mm = _per_width(a, root), max(_BROAD, _BROADER * bundle)
    broad, narrow = _seen(broad_mm / scale, apart), _seen(bundle / scale, apart)
    supply = _GAIN * (2.0 * level - 1.0) + _OFFSET
    supply += _FLOOD * max(0.0, level - _FLOODED) / (1.0 - _FLOODED)
    supply -= _STANDS * (1.0 - carried)
    unseen2 = 0.0
    if tooth > 0.0:
        shown = (_TOOTH[0] * coarse) ** 2 + (_TOOTH[1] * fine) ** 2
        shown /= _TOOTH[0] ** 2 + _TOOTH[1] ** 2
        supply += _TOOTH_MEAN * (1.0 - shown)
        unseen2 += _TOOTH_SPREAD**2 * (1.0 - shown)
    broad_spread, spread = differ * _BROAD_SPREAD, differ * _SPREAD
    unseen2 += broad_spread**2 * (1.0 - broad * broad) + spread**2 * (1.0 - narrow * narrow)
    mean_broad = broad_spread * broad * _mean_supply(ahead_x, ahead_y, a, scale / broad_mm, ink)
    step = _STEPS / tooth if tooth > 0.0 else 0.0
    back = -_DRAGGED * tooth
    return DryContact(
        supply - mean_broad,
        mean_broad,
        0.5 / (np.sqrt(3.0) * np.sqrt(_SOFT * _SOFT + unseen2)),
        ahead_x,
        ahead_y,
        a.curve,
        a.parted + a.way,
        _STEPS * scale / broad_mm,
        _STEPS * scale / bundle,
        _TOOTH[0] * coarse / _LEVELS,
        _TOOTH[1] * fine / _LEVELS,
        broad_spread * broad / _LEVELS,
        spread * narrow / _LEVELS,
        hairs,
        step,
        step / _FINER,
        back * (ahead_x * a.bend[0] + ahead_y * a.cross[0]),
        back * (ahead_x * a.bend[1] + ahead_y * a.cross[1]),
        back * (ahead_x * a.bend[2] + ahead_y * a.cross[2]),
    )


@uncounted(error_model="numpy")
def _place_on_lattice(n, xs, ys, zs, step, turn, out):
    """Numbers in the table of the noise at places (mm); `turn` picks the order of its axes."""
    a, b, c = turn % 3, (turn + 1) % 3, (turn + 2) % 3
    scale = np.float32(step)
    a0, a1, a2 = np.float32(_ASKEW[a, 0]), np.float32(_ASKEW[a, 1]), np.float32(_ASKEW[a, 2])
    b0, b1, b2 = np.float32(_ASKEW[b, 0]), np.float32(_ASKEW[b, 1]), np.float32(_ASKEW[b, 2])
    c0, c1, c2 = np.float32(_ASKEW[c, 0]), np.float32(_ASKEW[c, 1]), np.float32(_ASKEW[c, 2])
    for k in range(n):
        x, y, z = scale * xs[k], scale * ys[k], scale * zs[k]
        i = np.int32(np.floor(a0 * x + a1 * y + a2 * z)) & _MASK
        j = np.int32(np.floor(b0 * x + b1 * y + b2 * z)) & _MASK
        h = np.int32(np.floor(c0 * x + c1 * y + c2 * z)) & _MASK
        out[k] = (i << _SHIFT2) | (j << _SHIFT) | h


@uncounted(error_model="numpy")
def _add_tooth(n, contact, noise, block):
    """Fill row 3 of a block with how high the sheet stands, with the film that drags on.

    Bumps too fine for the vertices are not looked up.
    """
    xs, ys, zs, high = block.rows[0], block.rows[1], block.rows[2], block.rows[3]
    coarse, fine = np.float32(contact.coarse), np.float32(contact.fine)
    coarse_at, fine_at, here = block.near[0], block.near[1], block.work[0]
    for look in range(_LOOKS):
        if look > 0:
            dx, dy, dz = contact.drag_x, contact.drag_y, contact.drag_z
            for k in range(n):
                xs[k] += np.float32(dx)
                ys[k] += np.float32(dy)
                zs[k] += np.float32(dz)
        _place_on_lattice(n, xs, ys, zs, contact.step, 0, coarse_at)
        if contact.fine > 0.0:
            _place_on_lattice(n, xs, ys, zs, contact.step_fine, 1, fine_at)
            for k in range(n):
                i, j = np.uint32(coarse_at[k]), np.uint32(fine_at[k])
                here[k] = coarse * noise[i] + fine * noise[j]
        else:
            for k in range(n):
                here[k] = coarse * noise[np.uint32(coarse_at[k])]
        less = np.float32(look * _THINS)
        if look == 0:
            for k in range(n):
                high[k] = here[k]
        else:
            for k in range(n):
                high[k] = max(high[k], here[k] - less)


@uncounted(error_model="numpy")
def _place_on_tuft(n, contact, values, block):
    """Fill rows 4 and 5 with places across the way and along it, mm."""
    xs, ys, zs = block.rows[0], block.rows[1], block.rows[2]
    across, along = block.rows[4], block.rows[5]
    fx, fy = contact.ahead_x, contact.ahead_y
    ahead_0, aside_0, ahead_1, aside_1, ahead_2, aside_2 = (
        np.float32(fx * values.bend[0] + fy * values.cross[0]),
        np.float32(fx * values.cross[0] - fy * values.bend[0]),
        np.float32(fx * values.bend[1] + fy * values.cross[1]),
        np.float32(fx * values.cross[1] - fy * values.bend[1]),
        np.float32(fx * values.bend[2] + fy * values.cross[2]),
        np.float32(fx * values.cross[2] - fy * values.bend[2]),
    )
    ox, oy, oz = (
        np.float32(values.origin[0]),
        np.float32(values.origin[1]),
        np.float32(values.origin[2]),
    )
    way, bow = np.float32(contact.way), np.float32(0.5 * contact.curve)
    for k in range(n):
        dx, dy, dz = xs[k] - ox, ys[k] - oy, zs[k] - oz
        ahead = ahead_0 * dx + ahead_1 * dy + ahead_2 * dz
        # hairs lie along the way, also where it curves: streaks go round a bend with them
        across[k] = aside_0 * dx + aside_1 * dy + aside_2 * dz - bow * ahead * ahead
        along[k] = way + ahead


@uncounted(error_model="numpy")
def _extent_across(ahead_x, ahead_y, values):
    """Position of the footprint's middle across the way, and its reach from there, mm.

    Half the width where the tuft trails, half the length where it goes sideways (pianfeng): as an
    ellipse of the footprint's length and width would.
    """
    long, middle = 0.5 * (values.tip - values.heel), 0.5 * (values.tip + values.heel)
    side, ahead = ahead_y * long, ahead_x * values.widest
    return -ahead_y * middle, np.sqrt(side * side + ahead * ahead)


@uncounted(error_model="numpy")
def _signed_byte(number):
    """Value of the uppermost byte of the lower half of a number, signed."""
    return np.float32(np.int32(number) >> _DOWN)


@uncounted(error_model="numpy")
def _bundle_at(across, along, table):
    """The noise of bundles at one place, in bundles across and along; of deviation 1."""
    x, y = _STEPS * across, _STEPS * along
    p, q = np.floor(x), np.floor(y)
    t, s, i, j = x - p, y - q, np.int64(p), np.int64(q)
    j += _APART * (i >> _SHIFT)  # the table's next period is another part of it
    four = table[((i & _MASK) << _SHIFT) | (j & _MASK)]
    near = (1.0 - t) * _signed_byte(four << _UP[0]) + t * _signed_byte(four << _UP[1])
    far = (1.0 - t) * _signed_byte(four << _UP[2]) + t * _signed_byte(four)
    return ((1.0 - s) * near + s * far) / _LEVELS


@uncounted(error_model="numpy")
def _add_bundles(n, table, per_across, per_along, strength, block):
    """Add to row 6 how well the bundles are supplied, from one layer of `bundle_noise`.

    Where the vertices show nothing of them nothing is looked up.
    """
    if strength <= 0.0:
        return
    across, along, supply = block.rows[4], block.rows[5], block.rows[6]
    side, ahead, at = block.work[0], block.work[1], block.near[0]
    begin, a, b = np.float32(_STEPS * _FROM), np.float32(per_across), np.float32(per_along)
    for k in range(n):
        x, y = begin + a * across[k], b * along[k]
        p, q = np.floor(x), np.floor(y)
        side[k], ahead[k] = x - p, y - q
        i, j = np.int32(p), np.int32(q)
        j += _APART * (i >> _SHIFT)  # the table's next period is another part of it
        at[k] = ((i & _MASK) << _SHIFT) | (j & _MASK)
    factor = np.float32(strength)
    for k in range(n):
        four = table[np.uint32(at[k])]  # no sign: no index from the table's end
        t, s = side[k], ahead[k]
        a, b = _signed_byte(four << _UP[0]), _signed_byte(four << _UP[1])
        c, d = _signed_byte(four << _UP[2]), _signed_byte(four)
        near, far = a + t * (b - a), c + t * (d - c)
        supply[k] += factor * (near + s * (far - near))


@uncounted(error_model="numpy")
def _begin_supply(n, contact, under, supply):
    """Fill `supply` with what the tuft brings, by what its hairs cover."""
    begin, hairs = np.float32(contact.supply), np.float32(contact.hairs)
    for k in range(n):
        supply[k] = begin
    if contact.hairs > 0.0:
        for k in range(n):
            supply[k] += hairs * (under[k] - np.float32(0.5))


@uncounted(error_model="numpy")
def _add_supply(n, contact, after, ink, block):
    """Add to row 6 of a block what the bundles bring to vertices; rows 4 and 5 become their places.

    The first three rows hold the vertices' places, mm.
    """
    supply, across, begins = block.rows[6], block.rows[4], block.rows[3]
    _place_on_tuft(n, contact, after.values[0], block)
    for k in range(n):
        begins[k] = supply[k]
    bundles, broad_way, way = ink.bundles, _STEPS / _BROAD_WAY, _STEPS / _WAY
    _add_bundles(n, bundles[0], contact.per_broad, broad_way, contact.broad, block)
    wander = np.float32(_WANDER_MM)
    for k in range(n):
        across[k] += wander * (supply[k] - begins[k])
    _add_bundles(n, bundles[1], contact.per_narrow, way, contact.narrow, block)


@uncounted(error_model="numpy")
def _touch(n, contact, after, ink, block):
    """Make of the supply in row 6 of a block the fraction that the tuft touches.

    The first three rows hold the vertices' places (mm), and are lost.
    """
    across, supply, high = block.rows[4], block.rows[6], block.rows[3]
    values = after.values[0]
    _add_supply(n, contact, after, ink, block)
    middle, half_extent = _extent_across(contact.ahead_x, contact.ahead_y, values)
    per_rim, middle = np.float32(1.0 / max(half_extent, 0.15)), np.float32(middle)
    worse = np.float32(_RIM)
    for k in range(n):
        rim = (across[k] - middle) * per_rim
        rim *= rim
        supply[k] -= worse * rim * rim
    if contact.coarse > 0.0:  # the longer bumps: where these do not show, no others do
        _add_tooth(n, contact, ink.noise, block)
        for k in range(n):
            supply[k] += high[k]
    per_soft, half = np.float32(contact.per_soft), np.float32(0.5)
    for k in range(n):
        supply[k] = min(np.float32(1.0), max(np.float32(0.0), half + supply[k] * per_soft))


@uncounted(error_model="numpy", apart=True)
def _copy_positions(n, px, py, pz, rows):
    """Copy positions to the first three rows of a block."""
    xs, ys, zs = rows[0], rows[1], rows[2]
    for k in range(n):
        xs[k], ys[k], zs[k] = px[k], py[k], pz[k]


@uncounted(error_model="numpy")
def thin_contact(contact, after, found, n, ink, block):
    """Take what the tuft does not touch from the fractions of the vertices found.

    The fraction touched is docs/model.md, equation (13).

    Parameters
    ----------
    contact : DryContact
    after : Stamp
    found : Found
        The first `n` of it, with their positions.
    n : int
    ink : InkField
    block : Block
        Overwritten.
    """
    touched, size = block.rows[6], block.rows.shape[1]
    for first in range(0, n, size):
        m = min(size, n - first)
        last = first + m
        fraction, cover = found.fraction[first:last], found.cover[first:last]
        px, py, pz = found.px[first:last], found.py[first:last], found.pz[first:last]
        _copy_positions(m, px, py, pz, block.rows)
        _begin_supply(m, contact, found.under[first:last], touched)
        _touch(m, contact, after, ink, block)
        for k in range(m):
            part = touched[k] if touched[k] > _LEAST else np.float32(0.0)
            fraction[k] *= part
            cover[k] *= part


@uncounted(error_model="numpy")
def weigh_streaks(strength, contact, after, found, n, ink, block):
    """Weigh the fractions of vertices under a wet tuft by what bundles bring: docs/model.md, (12).

    Where a bundle brings much there is ink last when the brush runs dry.

    Parameters
    ----------
    strength : float
        Of the logarithm of a weight, over the supply of (13).
    contact, after, n, ink, block : as for `thin_contact`
    found : Found
        The first `n` of it, with their positions; `brings` becomes their weights.
    """
    supply, size = block.rows[6], block.rows.shape[1]
    one, half, third = np.float32(1.0), np.float32(1.0 / 2.0), np.float32(1.0 / 3.0)
    begin, factor = np.float32(strength * contact.mean_broad), np.float32(strength)
    for first in range(0, n, size):
        m = min(size, n - first)
        last = first + m
        fraction, brings = found.fraction[first:last], found.brings[first:last]
        px, py, pz = found.px[first:last], found.py[first:last], found.pz[first:last]
        _copy_positions(m, px, py, pz, block.rows)
        for k in range(m):
            supply[k] = np.float32(0.0)
        _add_supply(m, contact, after, ink, block)
        for k in range(m):
            e = factor * supply[k] - begin
            weight = one + e * (one + half * e * (one + third * e))  # exp(e), which is small
            brings[k] = weight
            fraction[k] *= weight
