"""What a file says of how an object looks, apart from its shape."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Finish", "Texture"]


class Finish(NamedTuple):
    """The material: its name, its roughness, 0 to 1, and each vertex's (V,) where they differ."""

    name: str = "painting"
    roughness: float = 0.5
    each: NDArray[np.float32] | None = None


class Texture(NamedTuple):
    """Colours in a picture: places (V, 2) from its top left, 0 to 1; sRGB (H, W, 3)."""

    uv: NDArray[np.float32]
    image: NDArray[np.uint8]
