"""``python -m paint3d`` is the ``paint3d`` command."""

from __future__ import annotations

import sys

_INTERRUPTED = 130


def run() -> int:
    """Run the command line; an interrupt is told in one line before and after it is there, too.

    Returns
    -------
    int
        The exit status; see `paint3d.cli.main`.
    """
    others, dropped = sys.unraisablehook, []

    def hear(one: sys.UnraisableHookArgs) -> None:
        if issubclass(one.exc_type, KeyboardInterrupt):  # see `paint3d.cli.main`
            dropped.append(one.exc_type)
        else:
            others(one)

    sys.unraisablehook = hear
    try:
        from paint3d.cli.main import main

        sys.unraisablehook = others
        if dropped:
            raise KeyboardInterrupt
        return main()
    except KeyboardInterrupt:  # or another one, while `main` tells of the first
        sys.stderr.write("paint3d: error: interrupted\n")
        return _INTERRUPTED
    finally:
        sys.unraisablehook = others


if __name__ == "__main__":
    sys.exit(run())
