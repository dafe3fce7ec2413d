"""Appearance of an object in a file, apart from its shape."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.wet_look import WetLook

__all__ = ["Finish", "Texture"]


class Finish(NamedTuple):
    """The material: its name, its roughness, 0 to 1, and where it varies each vertex's.

    Places are vertices (V,), or texels (H, W) where colours are in a texture.
    """

    name: str = "painting"
    roughness: float = 0.5
    each: NDArray[np.float32] | None = None


class Texture(NamedTuple):
    """Colours in a picture: coordinates (V, 2) from its top left, 0 to 1; sRGB (H, W, 3).

    `look` is how wet and glossy each texel (H, W) is, None where all are as the material; the
    colours are as they are seen.
    """

    uv: NDArray[np.float32]
    image: NDArray[np.uint8]
    look: WetLook | None = None
