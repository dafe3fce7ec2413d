"""Say once that the loops are being compiled, so that a first run does not look stuck."""

from __future__ import annotations

import sys

__all__ = ["is_compiled", "say_if_compiling"]

_LAST_COMPILED = "deposit"
_SECONDS = 100


def is_compiled() -> bool:
    """Whether compiled loops are kept for this version of Python."""
    from paint3d.kernels.kept_code import compiled_code  # which drops what is older than its source

    pattern = f"{_LAST_COMPILED}.*.py{sys.version_info.major}{sys.version_info.minor}.nbi"
    return any(compiled_code().glob(pattern))


def say_if_compiling(*, quiet: bool) -> None:
    """Write one line to stderr when the loops are yet to be compiled."""
    if not quiet and not is_compiled():
        sys.stderr.write(f"compiling the brush (once, about {_SECONDS} s) ...\n")
        sys.stderr.flush()
