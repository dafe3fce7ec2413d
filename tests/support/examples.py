"""Number of examples of property tests that are slow."""

from __future__ import annotations

import os

__all__ = ["ALL", "examples"]

ALL = bool(os.environ.get("PAINT3D_MORE_EXAMPLES"))
"""Whether everything is tried, and examples are new: set by scripts/check --long."""

_SHARE = 5
_LEAST = 5


def examples(n: int) -> int:
    """Reduce a number of examples to a fifth, the same every time, at least five; all with --long.

    Not of laws that nothing is lost, of ink or of files: they are tried on all every time.
    """
    return n if ALL else min(n, max(n // _SHARE, _LEAST))
