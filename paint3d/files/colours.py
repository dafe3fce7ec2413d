"""Colours in strangers' files: codes of vertices, materials and their pictures."""

from __future__ import annotations

import io
import re
import warnings
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError, Message

__all__ = [
    "COLOUR_NAMES",
    "NAMED_AS_COLOUR",
    "REPEAT",
    "VERTEX_COLOURS",
    "Look",
    "colour_codes",
    "colour_fractions",
    "is_coloured",
    "linear_from_srgb",
    "open_picture",
    "sample_picture",
    "srgb_from_linear",
]

# ---- Codes ---------------------------------------------------------------------------------------


COLOUR_NAMES = (
    ("red", "green", "blue"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
    ("r", "g", "b"),
)
"""Of the columns in which a PLY has colours, the first that it has are taken."""
NAMED_AS_COLOUR = re.compile(
    r"(?:^|_)(?:red|green|blue|rgba?|bgra?|colou?rs?|gr[ae]y|luminance|intensity|f_dc)(?:_|\d|$)",
    re.IGNORECASE,
)
"""Finds names of numbers that speak of colours."""

ROUNDING = 1e-6  # above 1
VERTEX_COLOURS = Message("vertex colours")
BYTE, WORD, LONG = 255, 65_535, 4_294_967_295
OVERSHOOT = 2  # times the range: codes up to there are a bit too bright, not of the next range
BRIGHT = 16  # fractions up to here are too bright: as codes they would all be nearly black


def colour_codes(
    values: AnyArray, expected: int | None = None, whose: Message = VERTEX_COLOURS
) -> tuple[NDArray[np.uint8] | None, tuple[Message, ...]]:
    """Return colours (V, 3 or 4) of any type as sRGB codes (V, 3), and notes on the conversion.

    See `colour_fractions`.
    """
    if values.dtype == np.uint8 or not values.size:
        return np.ascontiguousarray(values[:, :3], np.uint8), ()
    fractions, notes = colour_fractions(values, expected, whose)
    return None if fractions is None else np.floor(BYTE * fractions + 0.5).astype(np.uint8), notes


def colour_fractions(
    values: AnyArray, expected: int | None = None, whose: Message = VERTEX_COLOURS
) -> tuple[NDArray[np.float64] | None, tuple[Message, ...]]:
    """Return colours of any type scaled to 0 to 1, and notes on the conversion.

    Whether the numbers run to 1, 255, 65,535 or 2^32 - 1 is seen from the numbers themselves, also
    those of opacities, which are 255 beside the darkest codes: many programs write codes of a byte
    as integers or floats of another size. A note says so where it is not the range that is
    expected. Colours that are not finite become white; what is a little
    out of the range is brought to its end.

    Parameters
    ----------
    values : (V, 3) or (V, 4) array
        The fourth column is opacities.
    expected : int, optional
        Where the range ends by what the format says: by default at 1 for floats, at the largest
        number for integers.
    whose : Message
        What the notes call them.

    Returns
    -------
    (V, 3) float64, or None
        None where most colours are out of the range.
    tuple of Message
    """
    is_integer = values.dtype.kind in "iu"
    if expected is None:
        expected = int(np.iinfo(values.dtype).max) if is_integer else 1
    if values.dtype == np.int8 and values.size and values.min() < 0:
        values = values.view(np.uint8)  # bytes whose type was given a wrong name
    every = values.astype(np.float64)
    values = every[:, :3]
    if not values.size:
        return values, ()
    known = np.asarray(np.isfinite(values).all(axis=1))
    if not known.any():
        return None, (Message("left out: its {whose}, none of which is a number", whose=whose),)
    notes: tuple[Message, ...] = ()
    n_all = len(known)
    if not known.all():
        notes += (
            Message(
                "{n:,} of {n_all:,} {whose} are no numbers: made white",
                n=(~known).sum(),
                n_all=n_all,
                whose=whose,
            ),
        )
    good = values[known]
    opacities = every[known, 3:]
    rgba = np.concatenate([good, np.where(np.isfinite(opacities), opacities, 0.0)], axis=1)
    end = _find_range(rgba, is_integer, expected)
    outside = ((good < 0.0) | (good > end + ROUNDING)).any(axis=1)
    if 2 * outside.sum() > len(good):
        return None, (
            Message(
                "left out: its {whose}, most of which are not within 0 to {end:,}",
                whose=whose,
                end=end,
            ),
        )
    if end != expected and good.any():
        notes += (Message("its {whose} are taken as 0 to {end:,}", whose=whose, end=end),)
    if outside.any():
        notes += (
            Message(
                "{n:,} of {n_all:,} {whose} are not within 0 to {end:,}: brought to the nearest "
                "that is",
                n=outside.sum(),
                n_all=n_all,
                whose=whose,
                end=end,
            ),
        )
    return np.where(known[:, None], np.clip(values / end, 0.0, 1.0), 1.0), notes


def is_coloured(codes: NDArray[np.uint8] | None) -> bool:
    """Return whether there are colours, and not all of them white."""
    return codes is not None and bool((codes < BYTE).any())


def _find_range(good: NDArray[np.float64], is_integer: bool, expected: int) -> int:
    """End of the range of finite colours: 1, 255, 65,535 or 2^32 - 1."""
    highest = good.max()
    if not is_integer:
        are_codes = highest > 1.0 + ROUNDING
        if (good != np.floor(good)).any():  # a few fractions above 1 are just too bright
            are_codes = highest > BRIGHT and np.median(good[good > 0.0]) > 1.0
        if not are_codes:
            return 1
    if highest <= OVERSHOOT * BYTE:
        return BYTE
    return WORD if highest <= OVERSHOOT * WORD or expected != LONG else LONG


# ---- Materials and pictures ----------------------------------------------------------------------


MAX_PIXELS = 1 << 26
REPEAT = ("repeat", "repeat")


@dataclass(frozen=True, eq=False)
class Look:
    """Colour of a material: a factor times a picture.

    Attributes
    ----------
    factor : tuple of 3 floats
        Linear, 0 to 1.
    picture : (H, W, 3) uint8 or None
        sRGB codes.
    wrap : tuple of 2 of {"repeat", "clamp", "mirror"}
        Treatment of positions outside the picture, along its width and its height.
    """

    factor: tuple[float, float, float] = (1.0, 1.0, 1.0)
    picture: NDArray[np.uint8] | None = None
    wrap: tuple[str, str] = REPEAT

    def at(self, uv: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return linear colours (N, 3) at points (N, 2) counted from the upper left corner."""
        if self.picture is None:
            return np.broadcast_to(np.array(self.factor, np.float64), (len(uv), 3))
        return sample_picture(self.picture, uv, self.wrap) * self.factor

    @cached_property
    def _coded(self) -> NDArray[np.uint8]:
        table = linear_from_srgb(np.arange(256, dtype=np.uint8))
        codes = srgb_from_linear(table[:, None] * np.array(self.factor))
        assert self.picture is not None, "a plain colour has no pixels"
        return np.stack([codes[self.picture[..., k], k] for k in range(3)], axis=-1)

    def codes_at(self, uv: AnyArray) -> NDArray[np.uint8]:
        """Return the sRGB codes (N, 3) of the picture's nearest pixels to points (N, 2)."""
        height, width = self._coded.shape[:2]
        columns = _nearest_pixel(uv[:, 0], width, self.wrap[0])
        rows = _nearest_pixel(uv[:, 1], height, self.wrap[1])
        result: NDArray[np.uint8] = self._coded.reshape(-1, 3)[rows * width + columns]
        return result

    def texels(self) -> tuple[int, int]:
        """Width and height of the picture; (0, 0) where there is none."""
        return (0, 0) if self.picture is None else self.picture.shape[1::-1]


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
                    raise MeshError(
                        "its texture has {size} pixels; expected {most:,}",
                        size=size,
                        most=MAX_PIXELS,
                    )
                return np.asarray(picture.convert("RGB"))
    except MeshError:
        raise
    except Exception as cause:  # what a decoder raises over a damaged picture is anybody's guess
        raise MeshError(
            "its texture is no picture that can be read: {cause}", cause=cause
        ) from None


def sample_picture(
    picture: NDArray[np.uint8], uv: NDArray[np.float64], wrap: tuple[str, str] = REPEAT
) -> NDArray[np.float64]:
    """Return linear colours (N, 3), 0 to 1, at points of a picture.

    Between four pixels the linear colours are mixed.

    Parameters
    ----------
    picture : (H, W, 3) uint8
        sRGB codes.
    uv : (N, 2) float64
        From the upper left corner, 0 to 1 over width and height. Places that are not finite
        count as the corner.
    wrap : tuple of 2 of {"repeat", "clamp", "mirror"}
        Outside, the picture repeats, ends in its border's colour, or is mirrored.
    """
    table = linear_from_srgb(np.arange(256, dtype=np.uint8))
    uv = np.where(np.isfinite(uv), uv, 0.0)
    columns, across = _pixel_pair(uv[:, 0], picture.shape[1], wrap[0])
    rows, down = _pixel_pair(uv[:, 1], picture.shape[0], wrap[1])
    colour = np.zeros((len(uv), 3))
    for dx in (0, 1):
        for dy in (0, 1):
            weight = np.abs(1 - dx - across) * np.abs(1 - dy - down)
            colour += weight[:, None] * table[picture[rows[dy], columns[dx]]]
    return colour


def _nearest_pixel(positions: AnyArray, n: int, wrap: str) -> NDArray[np.int64]:
    """Return the pixels (N,) of n in which coordinates lie."""
    if wrap == "mirror":
        positions = 1.0 - np.abs(positions % 2.0 - 1.0)
    pixel = np.floor(positions * n).astype(np.int64)
    result: NDArray[np.int64] = pixel % n if wrap == "repeat" else np.clip(pixel, 0, n - 1)
    return result


def _pixel_pair(positions: NDArray[np.float64], n: int, wrap: str) -> tuple[AnyArray, AnyArray]:
    """Return the two pixels (2, N) of n around coordinates, and the weight of the second."""
    if wrap == "mirror":
        positions = 1.0 - np.abs(positions % 2.0 - 1.0)
    elif wrap == "clamp":
        positions = np.clip(positions, 0.0, 1.0)
    else:
        positions = positions % 1.0
    positions = positions * n - 0.5
    low = np.floor(positions).astype(np.int64)
    pair = np.stack([low, low + 1])
    pair = pair % n if wrap == "repeat" else np.clip(pair, 0, n - 1)
    return pair, positions - low


def linear_from_srgb(codes: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return linear values, 0 to 1, of sRGB codes (IEC 61966-2-1)."""
    value = np.asarray(codes) / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def srgb_from_linear(linear: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return sRGB codes of linear values (IEC 61966-2-1); display limits them to 0 to 1."""
    linear = np.clip(np.nan_to_num(linear), 0.0, 1.0)
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return np.floor(255.0 * curve + 0.5).astype(np.uint8)
