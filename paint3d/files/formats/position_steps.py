"""What metres in float32 lose of millimetres in float32: at the most one step of the last place.

Between 1.953 and 2 times a power of two, metres lie nearly twice as far apart as the millimetres
that they stand for, so that half of these would come back as their neighbours. A binary glTF, whose
positions are metres, tells which in an attribute of our own; other programs pass over it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["METRE_MM", "STEPS", "find_steps", "take_steps"]

STEPS = "_POSITION_STEPS"
METRE_MM = 1000.0
_PLACES = np.array([9, 3, 1])  # of x, y and z in a code: their steps from -1 to 1, in base 3
_MIDDLE = 13


def find_steps(
    vertices: NDArray[np.float32], metres: NDArray[np.float32]
) -> NDArray[np.float32] | None:
    """Return a code (V,) of the steps from what metres give back to the vertices they stand for.

    Parameters
    ----------
    vertices : (V, 3) float32
        mm; the steps tell numbers of more than 1e-34 mm exactly.
    metres : (V, 3) float32
        The same in m, rounded.

    Returns
    -------
    (V,) float32 or None
        Whole numbers from -13 to 13; None where all are 0.
    """
    back = _in_mm(metres)
    if np.array_equal(back, vertices):
        return None
    steps = np.clip(vertices.view(np.int32) - back.view(np.int32), -1, 1)  # of their magnitude
    result: NDArray[np.float32] | None = (steps @ _PLACES).astype(np.float32)
    return result


def take_steps(metres: NDArray[np.float64], codes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return metres (V, 3) that give back, in float32, the mm that `find_steps` was told (V,)."""
    known = np.clip(np.nan_to_num(codes), -_MIDDLE, _MIDDLE)
    steps = (np.rint(known).astype(np.int32) + _MIDDLE)[:, None] // _PLACES % 3 - 1
    mm = (_in_mm(metres).view(np.int32) + steps.astype(np.int32)).view(np.float32)
    return np.where(steps == 0, metres, mm.astype(np.float64) / METRE_MM)


def _in_mm(metres: NDArray[np.floating]) -> NDArray[np.float32]:
    return (metres.astype(np.float64) * METRE_MM).astype(np.float32)
