"""``python -m tools.kernels``: compile the kernels of this checkout ahead of time."""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

from tools.kernels.building import FOLDER, LEVELS, BuildError, build, is_built, own_level, parts
from tools.kernels.table import TableError

_BAR = 40  # signs


def main() -> int:
    """Build, or say in one line why not."""
    parser = argparse.ArgumentParser(prog="python -m tools.kernels", description=__doc__)
    parser.add_argument(
        "--levels",
        type=int,
        nargs="+",
        choices=LEVELS,
        help="of x86-64; default this machine's own",
    )
    parser.add_argument("--into", type=Path, default=FOLDER, help=argparse.SUPPRESS)
    parser.add_argument("--part", help=argparse.SUPPRESS)
    options = parser.parse_args()
    try:
        levels = sorted(set(options.levels or [own_level()]))
        if options.part:
            from tools.kernels.part import compile_part

            (part,) = (part for part in parts() if part.name == options.part)
            compile_part(part.groups, levels, options.into, lambda: os.write(1, b"\n") and None)
            return 0
        if is_built(levels, options.into):
            return 0
        start = time.monotonic()
        sys.stderr.write("kernels: compiling them, about a minute\n")
        build(levels, options.into, _show if sys.stderr.isatty() else lambda done, of: None)
        sys.stderr.write(f"kernels: compiled in {time.monotonic() - start:.0f} s\n")
    except (BuildError, TableError, ImportError) as error:
        sys.stderr.write(f"kernels: not compiled ahead, but when first used: {error}\n")
        return 1
    return 0


def _show(done: int, of: int) -> None:
    full = _BAR * done // of
    bar = f"\rkernels: [{'#' * full}{'.' * (_BAR - full)}]"
    sys.stderr.write(bar + ("\n" if done == of else ""))
    sys.stderr.flush()


if __name__ == "__main__":
    sys.exit(main())
