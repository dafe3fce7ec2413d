"""Say once that the loops are being compiled, so that a first run does not look stuck."""

from __future__ import annotations

import sys

__all__ = ["say_if_compiling"]

_SECONDS = 100


def say_if_compiling(*, quiet: bool) -> None:
    """Write one line to stderr when the loops are yet to be compiled."""
    from paint3d.brush_engine.stroke_loop import paint_samples  # the last that a stroke needs
    from paint3d.core.kernel import is_compiled

    if not quiet and not is_compiled(paint_samples):
        sys.stderr.write(f"compiling the brush (once, about {_SECONDS} s) ...\n")
        sys.stderr.flush()
