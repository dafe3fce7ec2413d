"""The surface around a contact as a curved patch over the stamp's plane.

Height over the plane = c + s_x x + s_y y + q_xx x^2 + q_xy x y + q_yy y^2, fitted by least squares
to the places and normals of the sheets of surface in the effective patch (Guo 2017, Fig. 7), and to
the foot point, each by its area.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel, uncounted

__all__ = ["PATCH_SIZE", "fit_patch"]

PATCH_SIZE = 6
_LEAST_FACING = 0.3  # cosine to the plane's normal below which a sheet says nothing of the height
_RIDGE = 1e-6  # of the weights: keeps what few sheets leave open at 0
_SLOPES = 0.25  # weight of a slope over that of a height, in units of the patch's radius
_MOST_SHEETS = 48  # that are asked, more or less
_FOOT = 0.05  # of the patch's weight that the foot point itself gets


@kernel(error_model="numpy")
def _add_place(sums, x, y, z, slope_x, slope_y, weight):
    """Add a point of the surface and its slopes (in units of the patch's radius) to the sums.

    First the 15 moments of x and y up to the fourth order, by order and falling power of x, then
    height times 1, x, y, x^2, x y, y^2, then either slope times 1, x, y.
    """
    x2, y2 = x * x, y * y
    wx, wy = weight * x, weight * y
    wx2, wxy, wy2 = weight * x2, wx * y, weight * y2
    sums[0] += weight
    sums[1] += wx
    sums[2] += wy
    sums[3] += wx2
    sums[4] += wxy
    sums[5] += wy2
    sums[6] += wx2 * x
    sums[7] += wx2 * y
    sums[8] += wy2 * x
    sums[9] += wy2 * y
    sums[10] += wx2 * x2
    sums[11] += wx2 * x * y
    sums[12] += wx2 * y2
    sums[13] += wxy * y2
    sums[14] += wy2 * y2
    sums[15] += weight * z
    sums[16] += wx * z
    sums[17] += wy * z
    sums[18] += wx2 * z
    sums[19] += wxy * z
    sums[20] += wy2 * z
    sums[21] += weight * slope_x
    sums[22] += wx * slope_x
    sums[23] += wy * slope_x
    sums[24] += weight * slope_y
    sums[25] += wx * slope_y
    sums[26] += wy * slope_y


@kernel(error_model="numpy")
def _make_system(sums, normal, right):
    """Normal equations of heights, and of slopes with `_SLOPES` of their weight."""
    powers = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    for i in range(PATCH_SIZE):
        for j in range(i + 1):
            p, q = powers[i][0] + powers[j][0], powers[i][1] + powers[j][1]
            order = p + q
            normal[i, j] = sums[order * (order + 1) // 2 + q]
        right[i] = sums[15 + i]
    s, sx, sy = _SLOPES * sums[0], _SLOPES * sums[1], _SLOPES * sums[2]
    sxx, sxy, syy = _SLOPES * sums[3], _SLOPES * sums[4], _SLOPES * sums[5]
    normal[1, 1] += s  # slope along x: s_x + 2 q_xx x + q_xy y
    normal[3, 1] += 2.0 * sx
    normal[4, 1] += sy
    normal[3, 3] += 4.0 * sxx
    normal[4, 3] += 2.0 * sxy
    normal[4, 4] += syy
    normal[2, 2] += s  # slope along y: s_y + q_xy x + 2 q_yy y
    normal[4, 2] += sx
    normal[5, 2] += 2.0 * sy
    normal[4, 4] += sxx
    normal[5, 4] += 2.0 * sxy
    normal[5, 5] += 4.0 * syy
    right[1] += _SLOPES * sums[21]
    right[2] += _SLOPES * sums[24]
    right[3] += _SLOPES * 2.0 * sums[22]
    right[4] += _SLOPES * (sums[23] + sums[25])
    right[5] += _SLOPES * 2.0 * sums[26]


@kernel(error_model="numpy")
def _solve(normal, right, out):
    """Cholesky's method, in place."""
    for i in range(PATCH_SIZE):
        for j in range(i + 1):
            total = normal[i, j]
            for k in range(j):
                total -= normal[i, k] * normal[j, k]
            normal[i, j] = np.sqrt(total) if i == j else total / normal[j, j]
        total = right[i]
        for k in range(i):
            total -= normal[i, k] * right[k]
        right[i] = total / normal[i, i]
    for i in range(PATCH_SIZE - 1, -1, -1):
        total = right[i]
        for k in range(i + 1, PATCH_SIZE):
            total -= normal[k, i] * out[k]
        out[i] = total / normal[i, i]


@kernel(error_model="numpy")
def _turn(values, x, y, z, nx, ny, nz):
    """A point and a normal in the stamp's axes: along the bend, to its side, up."""
    dx = np.float64(x) - values.origin[0]
    dy = np.float64(y) - values.origin[1]
    dz = np.float64(z) - values.origin[2]
    b, c, u = values.bend, values.cross, values.normal
    return (
        dx * b[0] + dy * b[1] + dz * b[2], dx * c[0] + dy * c[1] + dz * c[2],
        dx * u[0] + dy * u[1] + dz * u[2], nx * b[0] + ny * b[1] + nz * b[2],
        nx * c[0] + ny * c[1] + nz * c[2], nx * u[0] + ny * u[1] + nz * u[2],
    )  # fmt: skip


@uncounted(error_model="numpy")
def fit_patch(values, field, scratch, work, out):
    """Fit the patch under a stamp that has just been placed.

    Parameters
    ----------
    values : record of GEOMETRY
        Of the stamp; `scratch` holds the patch of sheets that its plane was taken from.
    field : SurfaceField
    scratch : Scratch
    work : (12, 6) float64
        Scratch.
    out : (6,) float64
        Height (mm) over the plane, about the stamp's origin, x along the bend, y to its side: the
        factors of 1, x, y, x^2, x y, y^2.
    """
    normal, right = work[:6], work[6]
    sums = work[7:12].reshape(30)
    work[:] = 0.0
    radius = values.radius
    pack = field.sheet_pack
    sheets, n = scratch.patch.sheets, scratch.patch.count[0]
    for k in range(0, n, 1 + n // _MOST_SHEETS):
        s = sheets[k]
        x, y, z, nx, ny, nz = _turn(
            values, pack[s, 4], pack[s, 5], pack[s, 6], pack[s, 0], pack[s, 1], pack[s, 2]
        )
        area = np.float64(pack[s, 3])
        x, y, z = x / radius, y / radius, z / radius
        if nz > _LEAST_FACING * area and x * x + y * y <= 1.0:
            _add_place(sums, x, y, z, -nx / nz, -ny / nz, area)
    x, y, z, nx, ny, nz = _turn(
        values, values.foot[0], values.foot[1], values.foot[2],
        values.foot_normal[0], values.foot_normal[1], values.foot_normal[2],
    )  # fmt: skip
    nz = max(nz, _LEAST_FACING)
    weight = _FOOT * sums[0] + _RIDGE
    _add_place(sums, x / radius, y / radius, z / radius, -nx / nz, -ny / nz, weight)
    _make_system(sums, normal, right)
    for i in range(PATCH_SIZE):
        normal[i, i] += _RIDGE * sums[0]
    _solve(normal, right, out)
    out[0] *= radius
    for i in range(3, PATCH_SIZE):
        out[i] /= radius
