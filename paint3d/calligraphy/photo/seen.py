"""What a photograph hides of its sheet: highlights and black shadows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.photo.ink_mask import otsu
from paint3d.errors import InputError

__all__ = ["check_exposure", "check_ground", "white_on_dark"]

_CLIPPED = 0.985  # linear light of all three colours: nothing is told above it
_BRIGHTER = 1.25  # than the sheet's own paper: a highlight, not paper that is exposed so
_GLARE, _BLACK = 0.02, 0.05  # of the sheet, that may be hidden
_LIT = 0.4  # of the sheet: what is lighter than the rest, and less than that, is no paper
_CONTRAST = 1.4  # of natural logarithms: more than that of a shadow
_DARK = 0.012  # linear light of the paper: the camera's noise is as strong


def check_exposure(sheet: NDArray[np.float32], paper: NDArray[np.float32]) -> None:
    """Refuse a sheet of which too much cannot be seen.

    Parameters
    ----------
    sheet : (H, W, 3) float32
        Linear light.
    paper : (h, w, 3) float32
        The light of its paper alone, of any size.

    Raises
    ------
    InputError
        How much of it a highlight or a shadow hides.
    """
    usual = float(np.median(paper.min(axis=2)))
    clipped = float((sheet.min(axis=2) > _CLIPPED).mean())
    if _BRIGHTER * usual < _CLIPPED and clipped > _GLARE:
        raise InputError(
            f"a highlight hides {clipped:.0%} of the sheet; expected light from the side: "
            "photograph it without a flash, away from a window's reflection"
        )
    hidden = float((paper.max(axis=2) < _DARK).mean())
    if hidden > _BLACK:
        raise InputError(
            f"{hidden:.0%} of the sheet lies in black shadow; expected light all over: give "
            "--corners around what can be seen, or photograph it brighter"
        )


def check_ground(sheet: NDArray[np.float32]) -> None:
    """Refuse white strokes on a dark ground, where they are not asked for.

    Parameters
    ----------
    sheet : (H, W, 3) float32
        Linear light.

    Raises
    ------
    InputError
        If most of the sheet is dark, and the rest much lighter.
    """
    share, contrast = white_on_dark(sheet)
    if share < _LIT and contrast > _CONTRAST:
        raise InputError(
            f"{share:.0%} of the sheet is white on a dark ground; expected dark strokes "
            "on paper: of a rubbing --invert"
        )


def white_on_dark(sheet: NDArray[np.float32]) -> tuple[float, float]:
    """What share of a sheet (H, W, 3) is the lighter, and by how much: a natural logarithm."""
    grey = np.log(sheet[::3, ::3].mean(axis=2) + 0.004)
    lighter = grey > otsu(grey)
    contrast = float(grey[lighter].mean() - grey[~lighter].mean()) if lighter.any() else 0.0
    return float(lighter.mean()), contrast
