"""Loading a photograph, read apart from this process as every stranger's file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import InputError, MeshError
from paint3d.files.progress import Progress
from paint3d.files.read_photograph import PHOTOGRAPH_SUFFIXES
from paint3d.files.sandbox.isolation import read_photograph_apart

__all__ = ["PHOTOGRAPH_SUFFIXES", "load_photograph"]

_LONGEST = 3200  # pixels of the longer side: what writing needs of a sheet of many characters


def load_photograph(
    path: Path | str, progress: Progress | None = None
) -> tuple[NDArray[np.uint8], float]:
    """Load a photograph, made smaller where it is large.

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
            what = "it is no plain file" if path.exists() else "there is no such file"
            what = "it is a folder" if path.is_dir() else what
            raise InputError(f"{path}: {what}; expected a photograph")
    except OSError as cause:  # a name too long, a folder that must not be looked into
        raise InputError(f"{path}: {cause.strerror or cause}") from None
    try:
        pixels, full = read_photograph_apart(path, _LONGEST, progress)
    except MeshError as cause:
        raise InputError(str(cause)) from None
    return pixels, max(full) / max(pixels.shape[:2])
