"""How many examples a property test tries where each costs much."""

from __future__ import annotations

import os

__all__ = ["ALL", "examples"]

ALL = bool(os.environ.get("PAINT3D_MORE_EXAMPLES"))
"""Whether everything is tried, and examples are new: set by scripts/check --long."""

_SHARE = 3


def examples(n: int) -> int:
    """Of so many examples a third, which are the same every time; all of them with --long.

    Not of laws that nothing is lost, of ink or of files: they are tried on all every time.
    """
    return n if ALL else n // _SHARE
