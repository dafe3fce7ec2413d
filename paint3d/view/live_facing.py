"""Which patches of an object turn their back to the eye, all of their faces at once.

Of a patch one keeps a cone around its normals (`view.kernels.facing`; Shirman and Abi-Ezzi, The
cone of normals technique for fast processing of curved patches, 1993).
"""

from __future__ import annotations

import numpy as np

from paint3d.core.types import AnyArray

__all__ = ["turned_away"]

_SLACK = 1e-4  # cosines: what rounding may take


def turned_away(bounds: AnyArray, cones: AnyArray, eye: AnyArray) -> AnyArray:
    """Whether an eye sees all triangles of each patch from behind.

    Parameters
    ----------
    bounds : (P, 6)
        Lowest and highest corner of the box that a patch lies in, mm.
    cones : (P, 4)
        `kernels.facing.cone_of` each.
    eye : (3,)
        mm.

    Returns
    -------
    (P,) bool
        False where it is not certain.
    """
    low, high = bounds[:, :3], bounds[:, 3:]
    radius = 0.5 * np.linalg.norm(high - low, axis=1)
    ahead = 0.5 * (low + high) - eye
    away = np.linalg.norm(ahead, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        # seen from behind if the angle between the axis and the ray is less than what is left
        # of a right angle after the cone's half and the half under which the box is seen
        spread = np.arccos(np.clip(cones[:, 3] - _SLACK, -1.0, 1.0))
        seen_under = np.arcsin(np.minimum(radius / away, 1.0))
        between = np.arccos(np.clip((ahead * cones[:, :3]).sum(axis=1) / away, -1.0, 1.0))
        result: AnyArray = between + spread + seen_under < 0.5 * np.pi
        return result
