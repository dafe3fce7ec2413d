"""How many examples a property test tries where each costs much."""

from __future__ import annotations

import os

__all__ = ["ALL", "examples"]

ALL = bool(os.environ.get("PAINT3D_MORE_EXAMPLES"))
"""Whether everything is tried, and examples are new: set by scripts/check --long."""

_SHARE = 5
_LEAST = 5


def examples(n: int) -> int:
    """Of so many examples a fifth, the same every time, but five at least; all with --long.

    Not of laws that nothing is lost, of ink or of files: they are tried on all every time.
    """
    return n if ALL else min(n, max(n // _SHARE, _LEAST))
