"""Photographs: read in a child process, upright, as sRGB codes."""

from __future__ import annotations

import importlib.util
import io
import logging
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import InputError

if TYPE_CHECKING:
    from PIL.Image import Image
from paint3d.errors import MeshError
from paint3d.files.progress import Progress
from paint3d.files.sandbox import PICTURE_SECONDS, Found, notes_of, read_apart

__all__ = [
    "PHOTOGRAPH_SUFFIXES",
    "child_photograph",
    "load_photograph",
    "read_photograph",
]

_HEIF_SUFFIXES = (".heic", ".heif")
PHOTOGRAPH_SUFFIXES = (
    ".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp", ".bmp", ".gif", ".ppm", ".pgm",
    *_HEIF_SUFFIXES,
)  # fmt: skip
log = logging.getLogger("paint3d")

_KINDS = ("JPEG", "MPO", "PNG", "TIFF", "WEBP", "BMP", "GIF", "PPM", "HEIF")
_MOST_BYTES = 400_000_000
_MOST_PIXELS = 1 << 27
_FEWEST = 64  # pixels of a side: less shows no writing
_HEIF_HEADS = (b"ftypheic", b"ftypheix", b"ftypmif1", b"ftyphevc", b"ftypmsf1", b"ftyphevx")


def read_photograph(path: Path, longest: int) -> tuple[NDArray[np.uint8], tuple[int, int]]:
    """Read a photograph; this process may run out of memory or crash over it.

    It stands upright as its EXIF says; another colour space is carried to sRGB by its profile; 16
    bits become 8; what is transparent is white paper; of several pictures it is the first.

    Parameters
    ----------
    path : Path
    longest : int
        Pixels of its longer side, at the most: larger ones are made smaller.

    Returns
    -------
    (H, W, 3) uint8
        sRGB codes.
    (int, int)
        Its own height and width, upright.

    Raises
    ------
    InputError
        If it is no picture that can be read, or a huge one.
    """
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(
                "{file}: larger than {most:,} bytes; expected a photograph",
                file=path,
                most=_MOST_BYTES,
            )
        data = path.read_bytes()
    except OSError as cause:
        raise InputError("{file}: {cause}", file=path, cause=cause) from None
    _prepare_heif(path, data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return _decode(path, data, longest)
    except InputError:
        raise
    except MemoryError:
        raise InputError(
            "{file}: it does not fit into memory; expected a photograph", file=path
        ) from None
    except Exception as cause:  # what a decoder raises over a damaged picture is anybody's guess
        reason = " ".join(str(cause).split())[:200] or type(cause).__name__
        raise InputError(
            "{file}: no picture that can be read ({told})", file=path, told=reason
        ) from None


def _prepare_heif(path: Path, data: bytes) -> None:
    """Register the package by which Pillow reads HEIC, where it is installed."""
    if data[4:12] not in _HEIF_HEADS:
        return
    if importlib.util.find_spec("pillow_heif") is None:
        raise InputError(
            "{file}: a HEIC picture, and pillow-heif is not installed; expected it saved as JPEG",
            file=path,
            hint="pip install pillow-heif",
        )
    heif: Any = importlib.import_module("pillow_heif")
    heif.register_heif_opener()


def _decode(path: Path, data: bytes, longest: int) -> tuple[NDArray[np.uint8], tuple[int, int]]:
    from PIL import Image, ImageOps, UnidentifiedImageError

    Image.MAX_IMAGE_PIXELS = None  # ours is less, and refuses
    try:
        Image.init()
        kinds = [kind for kind in _KINDS if kind in Image.OPEN]
        opened = Image.open(io.BytesIO(data), formats=kinds)
    except UnidentifiedImageError:  # which names an object in memory
        raise InputError(
            "{file}: no picture that can be read (of no known kind)", file=path
        ) from None
    with opened as picture:
        width, height = picture.size
        if width * height > _MOST_PIXELS:
            raise InputError(
                "{file}: {width:,} x {height:,} pixels; expected {most:,} at the most: make it "
                "smaller",
                file=path,
                width=width,
                height=height,
                most=_MOST_PIXELS,
            )
        if min(width, height) < _FEWEST:
            raise InputError(
                "{file}: {width} x {height} pixels; expected {fewest} or more a side",
                file=path,
                width=width,
                height=height,
                fewest=_FEWEST,
            )
        orientation = picture.getexif().get(0x0112, 1)
        full = (width, height) if orientation in (5, 6, 7, 8) else (height, width)
        picture.draft("RGB", (longest, longest))  # JPEG is decoded at a half or a quarter
        picture.load()
        shrink = max(1, max(picture.size) // longest)
        small = picture.reduce(shrink) if shrink > 1 and picture.mode in _REDUCED else picture
        rgb = ImageOps.exif_transpose(_convert_to_srgb(small, picture.info))
        if max(rgb.size) > longest:
            rgb.thumbnail((longest, longest), Image.Resampling.LANCZOS)
        return np.asarray(rgb), full


_REDUCED = ("RGB", "RGBA", "L", "LA", "CMYK", "YCbCr")


def _convert_to_srgb(picture: Image, info: dict[Any, Any]) -> Image:
    """A picture as opaque sRGB."""
    from PIL import Image

    exif = picture.getexif()
    if picture.mode.startswith(("I", "F")):  # 16 bits or more of grey
        values = np.nan_to_num(np.asarray(picture, np.float64))
        greatest = float(values.max())
        are_fractions = picture.mode.startswith("F") and greatest <= 1.0
        most = 1.0 if are_fractions else max(greatest, 65535.0 if greatest > 255.0 else 255.0)
        codes = np.clip(np.round(255.0 * values / most), 0.0, 255.0).astype(np.uint8)
        picture = Image.fromarray(codes)
    if picture.mode in ("RGBA", "LA", "PA", "La", "RGBa") or "transparency" in info:
        rgba = picture.convert("RGBA")
        paper = Image.new("RGBA", rgba.size, (255, 255, 255, 255))
        picture = Image.alpha_composite(paper, rgba).convert("RGB")
    converted = _convert_by_profile(picture, info.get("icc_profile"))
    result = converted if converted is not None else picture.convert("RGB")
    result.getexif().update(exif)
    return result


def _convert_by_profile(picture: Image, profile: bytes | None) -> Image | None:
    """Convert a picture to sRGB by its embedded profile, if that suits its mode."""
    if not profile or picture.mode not in ("RGB", "CMYK", "L"):
        return None
    from PIL import ImageCms

    try:
        own = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        carried = ImageCms.profileToProfile(
            picture, own, ImageCms.createProfile("sRGB"), outputMode="RGB"
        )
    except (ImageCms.PyCMSError, OSError, ValueError, TypeError):
        return None  # a profile that is damaged, or of other pictures
    return carried


_LONGEST = 3200  # pixels of the longer side: what writing needs of a sheet of many characters


def load_photograph(
    path: Path | str, progress: Progress | None = None
) -> tuple[NDArray[np.uint8], float]:
    """Load a photograph, downsampled where it is large.

    Parameters
    ----------
    path : path
        JPEG, PNG, TIFF, WebP, BMP, GIF, PPM, or HEIC where pillow-heif is installed.
    progress : callable, optional

    Returns
    -------
    (H, W, 3) uint8
        sRGB codes, upright.
    float
        How many of the file's pixels one of these shows along a side, 1 or more.

    Raises
    ------
    InputError
        If there is no such file, or it is no picture that can be read.
    """
    path = Path(path)
    try:
        if not path.is_file():
            if path.is_dir():
                raise InputError("{file}: it is a folder; expected a photograph", file=path)
            if path.exists():
                raise InputError("{file}: it is no plain file; expected a photograph", file=path)
            raise InputError("{file}: there is no such file; expected a photograph", file=path)
    except OSError as cause:  # a name too long, a folder that must not be looked into
        raise InputError("{file}: {cause}", file=path, cause=cause) from None
    try:
        reader = f"{__name__}:{child_photograph.__name__}"
        arrays, facts = read_apart(path, reader, [_LONGEST], PICTURE_SECONDS, progress=progress)
    except MeshError as cause:
        raise InputError(cause) from None
    for note in notes_of(facts):
        log.warning("%s: %s", path, note)
    (height, width), full = facts["size"], facts["full"]
    pixels: NDArray[np.uint8] = arrays["pixels"].reshape(int(height), int(width), 3)
    return pixels, max(int(full[0]), int(full[1])) / max(pixels.shape[:2])


def child_photograph(path: Path, wanted: list[Any]) -> Found:
    """Read a photograph in the child process, downsampled to `wanted[0]` pixels."""
    pixels, full = read_photograph(path, *wanted)
    facts: dict[str, object] = {"size": pixels.shape[:2], "full": full}
    return {"pixels": pixels.reshape(-1, 3)}, facts
