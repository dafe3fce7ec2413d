"""Which brush suits a size of writing."""

from __future__ import annotations

from paint3d.core.arrays import as_number

__all__ = ["GREATEST_EM", "LEAST_EM", "choose_brush"]

LEAST_EM, GREATEST_EM = 8.0, 200.0
"""mm: the sizes of characters that the presets are made for."""

_BRUSHES = ((22.0, "xiaobaiyun"), (60.0, "zhongbaiyun"), (GREATEST_EM, "dabaiyun"))
"""Size (mm) up to which each brush is taken. The three are alike in shape: a full belly and a
blunt taper, whose footprints are about as long as wide and so reach into corners at any bend."""


def choose_brush(em_mm: float) -> str:
    """The preset for writing kaishu of a size.

    Parameters
    ----------
    em_mm : float
        Side of the em square, mm, 8 to 200.

    Returns
    -------
    str
        A name for `paint3d.brush.presets.load_brush`.

    Raises
    ------
    InputError
        If the size is none of those.
    """
    size = as_number(em_mm, "size of the characters (mm)", LEAST_EM, GREATEST_EM)
    return next(name for largest, name in _BRUSHES if size <= largest)
