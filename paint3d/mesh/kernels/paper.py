"""How a material's fibres make the ink's edge and film uneven: noise in space, at the vertices.

On a material with fibres or pores a wet edge does not run where the tuft's outline does: ink is
drawn on along a fibre and stops before the next. And dense places of a sheet take less of it than
open ones. Both are functions of the place alone, so every sweep meets the same paper, and two
meshings of one object have the same. An outline meets a vertex at x and a part of W(x)
that depends on what draws it, and the vertex takes tau(x) times its share of what the sweep leaves:
docs/model.md, equations (20) and (21), sums of octaves of smooth noise, besides fibres and
pores. What the vertices cannot show is left out.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel, uncounted
from paint3d.mesh.kernels.mesh_arrays import mix

__all__ = ["MOST_ASIDE_MM", "lay_paper", "lay_paper_at"]

# h_k, half a wavelength, and a_k along each axis: mm. Set so that edges on xuan are somewhat
# smoother than those of ink on raw practice paper in each octave of .13 to 2.1 mm.
_EDGE = ((0.09, 0.0045), (0.19, 0.0105), (0.38, 0.023), (0.75, 0.044), (1.4, 0.075), (3.1, 0.12))
# An edge is calm for long, then torn: h and deviation of the log of each, up to which h all of it
# counts, from there on this power of it, and the most of it. What is torn is fine above all; coarse
# bumps that come all at once look like beads on a smooth rod.
_RAGGED, _SMOOTH_MM, _SMOOTH, _MOST_RAGGED = ((4.0, 1.0), (13.0, 0.6)), 0.3, 0.75, 5.0
# Fibres that draw an edge on or keep it off: h of the noise along whose zeros they lie, and half
# their width as a deviation of it; how far, mm, h of the noise that gives the direction, and the
# most of `ragged` that counts; half the wavelength that vertices have to show.
_FIBRE_MM, _FIBRE_AT = 0.6, 0.13
_PULL_MM, _PULL_WAY_MM, _PULL_RAGGED = 0.1, 0.9, 2.0
_FIBRE_SHOWN_MM = 0.16
MOST_ASIDE_MM = 0.6  # how far aside an outline may be met, whatever the noise on raw xuan
_TAKE = ((0.1, 0.02), (0.25, 0.013), (0.7, 0.008), (3.0, 0.02))  # h_k, mm, and s_k: set by eye
_COARSE = 0.28  # how much of that is grain as well, and pores: where an edge is torn ink is uneven
# Pores that take little: h, from which deviation on, and how much less by the square beyond it.
_VOID_MM, _VOID_AT, _VOID = 0.16, 1.1, 0.04
_PER_DEVIATION = 2.7  # value noise blended by smooth steps has a deviation of .37
_TURN = (  # so that no octave's lattice lies along the object's axes
    (0.48, 0.64, -0.6),
    (-0.8, 0.6, 0.0),
    (0.36, 0.48, 0.8),
)


@uncounted
def _corner(i, j, k, salt):
    """64 random bits of a lattice point."""
    code = np.uint64(i) * np.uint64(0x9E3779B97F4A7C15)
    code ^= mix(np.uint64(j) + np.uint64(salt))
    return mix(code ^ mix(np.uint64(k) + np.uint64(0x8CB92BA72F3D8DD7)))


@uncounted
def _noise3(x, y, z, salt):
    """Three independent values of noise of deviation 1 at a place, in lattice steps."""
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    u, v, w = x - i, y - j, z - k
    u = u * u * (3.0 - 2.0 * u)
    v = v * v * (3.0 - 2.0 * v)
    w = w * w * (3.0 - 2.0 * w)
    r, s, t = 0.0, 0.0, 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                share = (u if a else 1.0 - u) * (v if b else 1.0 - v) * (w if c else 1.0 - w)
                bits = _corner(i + a, j + b, k + c, salt)
                r += share * np.float64(np.int64(bits & np.uint64(0xFFFFF)) - 524288)
                s += share * np.float64(
                    np.int64((bits >> np.uint64(20)) & np.uint64(0xFFFFF)) - 524288
                )
                t += share * np.float64(
                    np.int64((bits >> np.uint64(40)) & np.uint64(0xFFFFF)) - 524288
                )
    scale = _PER_DEVIATION / 524288.0
    return r * scale, s * scale, t * scale


@uncounted
def _shown(length, apart):
    """How much of bumps of half wavelength `length` vertices show so far apart (mm), 0 to 1."""
    return min(1.0, max(0.0, 2.0 * length / apart - 2.0))


@uncounted
def lay_paper_at(field, v):
    """Fill where an outline meets a vertex, and how readily it takes ink."""
    amount, apart = field.paper, field.soft_edge
    x, y, z = np.float64(field.px[v]), np.float64(field.py[v]), np.float64(field.pz[v])
    if amount <= 0.0:
        field.mx[v], field.my[v], field.mz[v] = field.px[v], field.py[v], field.pz[v]
        field.take[v] = np.float32(1.0)
        return
    a = _TURN[0][0] * x + _TURN[0][1] * y + _TURN[0][2] * z
    b = _TURN[1][0] * x + _TURN[1][1] * y + _TURN[1][2] * z
    c = _TURN[2][0] * x + _TURN[2][1] * y + _TURN[2][2] * z
    wx, wy, wz, take = 0.0, 0.0, 0.0, 0.0
    (side_mm, side), (part_mm, part) = _RAGGED
    ragged = side * _noise3(a / side_mm, b / side_mm, c / side_mm, 11)[0]
    open_here = _noise3(a / part_mm, b / part_mm, c / part_mm, 13)[0]
    coarse = np.exp(_COARSE * (open_here + ragged))
    ragged = min(np.exp(ragged + part * open_here), _MOST_RAGGED)
    for n in range(len(_EDGE)):
        length, shift = _EDGE[n]
        shift *= amount * _shown(length, apart)
        shift *= ragged if length < _SMOOTH_MM else ragged**_SMOOTH
        if shift > 0.0:
            dx, dy, dz = _noise3(a / length, b / length, c / length, 17 + n)
            wx += shift * dx
            wy += shift * dy
            wz += shift * dz
    fibre = amount * _PULL_MM * _shown(_FIBRE_SHOWN_MM, apart) * min(ragged, _PULL_RAGGED)
    if fibre > 0.0:
        off = _noise3(c / _FIBRE_MM, b / _FIBRE_MM, a / _FIBRE_MM, 71)[0] / _FIBRE_AT
        if abs(off) < 1.0:
            dx, dy, dz = _noise3(a / _PULL_WAY_MM, b / _PULL_WAY_MM, c / _PULL_WAY_MM, 73)
            fibre *= 1.0 - off * off
            wx, wy, wz = wx + fibre * dx, wy + fibre * dy, wz + fibre * dz
    for n in range(len(_TAKE)):
        length, spread = _TAKE[n]
        spread *= amount * _shown(length, apart) * (coarse if length < _SMOOTH_MM else 1.0)
        if spread > 0.0:
            take += spread * _noise3(b / length, c / length, a / length, 37 + n)[0]
    shown = _shown(_VOID_MM, apart)
    if shown > 0.0:
        deep = max(0.0, _noise3(c / _VOID_MM, a / _VOID_MM, b / _VOID_MM, 57)[0] - _VOID_AT)
        take -= _VOID * amount * coarse * shown * deep * deep
    far = np.sqrt(wx * wx + wy * wy + wz * wz)
    if far > MOST_ASIDE_MM * amount:
        less = 0.9999 * MOST_ASIDE_MM * amount / far  # within it when rounded
        wx, wy, wz = less * wx, less * wy, less * wz
    nx, ny, nz = np.float64(field.nx[v]), np.float64(field.ny[v]), np.float64(field.nz[v])
    up = wx * nx + wy * ny + wz * nz  # the edge moves in the surface
    field.mx[v] = np.float32(x + wx - up * nx)
    field.my[v] = np.float32(y + wy - up * ny)
    field.mz[v] = np.float32(z + wz - up * nz)
    field.take[v] = np.float32(np.exp(take))


@kernel
def lay_paper(field, first, last):
    """`lay_paper_at` of vertices first to last - 1."""
    for v in range(first, last):
        lay_paper_at(field, v)
