"""What a file says of how an object looks, apart from its shape."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Finish", "Texture"]


class Finish(NamedTuple):
    """The material: its name, and its roughness from 0 to 1."""

    name: str = "painting"
    roughness: float = 0.5


class Texture(NamedTuple):
    """Colours in a picture: places (V, 2) from its top left, 0 to 1; sRGB (H, W, 3)."""

    uv: NDArray[np.float32]
    image: NDArray[np.uint8]
