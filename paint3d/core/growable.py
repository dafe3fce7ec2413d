"""Arrays that grow."""

from __future__ import annotations

import numpy as np

from paint3d.core.types import AnyArray

__all__ = ["grown"]


def grown(array: AnyArray, used: int, room: int) -> AnyArray:
    """An array of `room` rows whose first `used` ones are those of another; the rest are 0."""
    result = np.zeros((room, *array.shape[1:]), array.dtype)
    result[:used] = array[:used]
    return result
