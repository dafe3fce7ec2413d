"""How many examples a property is tried on: fewer every time where each of them takes long."""

from __future__ import annotations

import os

__all__ = ["examples"]

_MORE = "PAINT3D_MORE_EXAMPLES"  # set by scripts/check --long
_LEAST = 25


def examples(few: int) -> int:
    """`few` every time, and at least 25 in ``scripts/check --long``."""
    return max(few, _LEAST) if _MORE in os.environ else few
