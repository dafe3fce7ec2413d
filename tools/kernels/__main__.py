"""``python -m tools.kernels``: compile the kernels of this checkout ahead of time."""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

from tools.kernels.building import FOLDER, PAGE_FOLDER, BuildError, build, is_built, parts
from tools.kernels.processors import ARCHITECTURES, architecture_of, own_processor
from tools.kernels.table import TableError

_BAR = 40  # signs


def main() -> int:
    """Build, or say in one line why not."""
    parser = argparse.ArgumentParser(prog="python -m tools.kernels", description=__doc__)
    kinds = {one: [one] for some in ARCHITECTURES.values() for one in some} | ARCHITECTURES
    parser.add_argument(
        "--for",
        dest="wanted",
        nargs="+",
        choices=[*kinds, "own"],
        help="kinds of processor of one architecture, or all of one; own: all of this machine's; "
        "default: what this machine is",
    )
    parser.add_argument("--into", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--part", help=argparse.SUPPRESS)
    options = parser.parse_args()
    try:
        own = own_processor()  # "" where nothing is made for it, or it does not run Linux
        known = {**kinds, "": (), "own": ARCHITECTURES[architecture_of(own)] if own else ()}
        processors = sorted({one for name in options.wanted or [own] for one in known[name]})
        if len({architecture_of(one) for one in processors}) != 1:
            raise BuildError(
                f"expected processors of one architecture, {' or '.join(ARCHITECTURES)}"
            )
        architecture = architecture_of(processors[0])
        into = options.into or (PAGE_FOLDER if architecture == "wasm32" else FOLDER)
        if options.part:
            from tools.kernels.part import compile_part

            (part,) = (part for part in parts(architecture) if part.name == options.part)
            compile_part(part.groups, processors, into, lambda: os.write(1, b"\n") and None)
            return 0
        if is_built(processors, into):
            return 0
        start = time.monotonic()
        sys.stderr.write("kernels: compiling them, 1 to 10 minutes\n")
        build(processors, into, _show if sys.stderr.isatty() else _tell)
        sys.stderr.write(f"kernels: compiled in {time.monotonic() - start:.0f} s\n")
    except (BuildError, TableError, ImportError) as error:
        sys.stderr.write(f"kernels: not compiled: {error}\n")
        return 1
    return 0


def _show(done: int, of: int) -> None:
    full = _BAR * done // of
    bar = f"\rkernels: [{'#' * full}{'.' * (_BAR - full)}]"
    sys.stderr.write(bar + ("\n" if done == of else ""))
    sys.stderr.flush()


def _tell(done: int, of: int) -> None:
    """Write a line each time another fifth is done, for a log."""
    if 5 * done // of > 5 * (done - 1) // of:
        sys.stderr.write(f"kernels: {100 * done // of} % compiled\n")
        sys.stderr.flush()


if __name__ == "__main__":
    sys.exit(main())
