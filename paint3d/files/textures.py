"""Pictures of other people's meshes, read at the vertices."""

from __future__ import annotations

import io
import warnings

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError

__all__ = ["linear_from_srgb", "open_picture", "sample_picture", "srgb_from_linear"]

MAX_PIXELS = 1 << 26


def open_picture(data: bytes) -> NDArray[np.uint8]:
    """Return the sRGB codes (H, W, 3) of a picture file.

    Raises
    ------
    MeshError
        If it is no picture, or has more than 2^26 pixels.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data)) as picture:
                if picture.width * picture.height > MAX_PIXELS:
                    size = f"{picture.width:,} x {picture.height:,}"
                    raise MeshError(f"its texture has {size} pixels; expected {MAX_PIXELS:,}")
                return np.asarray(picture.convert("RGB"))
    except MeshError:
        raise
    except Exception as cause:  # what a decoder raises over a damaged picture is anybody's guess
        raise MeshError(f"its texture is no picture that can be read: {cause}") from None


def sample_picture(picture: NDArray[np.uint8], uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return linear colours (N, 3), 0 to 1, at places on a picture.

    Between four pixels the linear colours are mixed; outside, the picture repeats.

    Parameters
    ----------
    picture : (H, W, 3) uint8
        sRGB codes.
    uv : (N, 2) float64
        From the upper left corner, 0 to 1 over width and height. Places that are not finite
        count as the corner.
    """
    height, width = picture.shape[:2]
    table = linear_from_srgb(np.arange(256, dtype=np.uint8))
    place = np.where(np.isfinite(uv), uv, 0.0) % 1.0 * (width, height) - 0.5
    low = np.floor(place).astype(np.int64)
    share = place - low
    colour = np.zeros((len(uv), 3))
    for dx in (0, 1):
        for dy in (0, 1):
            weight = np.abs(1 - dx - share[:, 0]) * np.abs(1 - dy - share[:, 1])
            pixel = picture[(low[:, 1] + dy) % height, (low[:, 0] + dx) % width]
            colour += weight[:, None] * table[pixel]
    return colour


def linear_from_srgb(codes: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return linear values, 0 to 1, of sRGB codes (IEC 61966-2-1)."""
    value = np.asarray(codes) / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def srgb_from_linear(linear: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return sRGB codes of linear values (IEC 61966-2-1); display limits them to 0 to 1."""
    linear = np.clip(np.nan_to_num(linear), 0.0, 1.0)
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return np.floor(255.0 * curve + 0.5).astype(np.uint8)
