"""Try damaged files on every reader: each must be read or refused in one line.

    python -m scripts.fuzz TARGET ... [--cases N] [--first K] [--seconds S] [--coverage]

A case is made from its number alone, so `--first K --cases 1` repeats it. A worker process tries
them one after the other with 2 GiB of memory and 20 s a case; if it dies or hangs, the case is
noted and the next worker goes on. `--coverage` lets atheris choose the damage by what code it
reaches (pip install atheris); the number of cases is then what it managed.
"""

from __future__ import annotations

import argparse
import sys
import time

from scripts.fuzz.campaign import Campaign
from scripts.fuzz.targets import TARGETS


def main() -> int:
    """Fuzz the targets of the command line, all of them unless told."""
    parser = argparse.ArgumentParser(prog="python -m scripts.fuzz", description=__doc__)
    parser.add_argument("targets", metavar="TARGET", nargs="*", help=", ".join(TARGETS))
    parser.add_argument("--cases", type=int, default=1_000_000, help="of each target")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="for each target")
    parser.add_argument("--coverage", action="store_true", help="guided by coverage")
    options = parser.parse_args()
    if unknown := set(options.targets) - set(TARGETS):
        parser.error(f"unknown target {', '.join(unknown)}; expected {', '.join(TARGETS)}")
    worst = 0
    for name in options.targets or TARGETS:
        if options.coverage:
            from scripts.fuzz.guided import run_guided

            run_guided(name, options.cases, options.seconds)
            continue
        started = time.monotonic()
        campaign = Campaign(name, options.first, options.first + options.cases, options.seconds)
        campaign.run()
        worst = max(worst, len(campaign.bugs))
        spent = time.monotonic() - started
        sys.stdout.write(
            f"{name}: {campaign.n_done:,} cases in {spent:.0f} s, {campaign.n_read:,} read, "
            f"{len(campaign.bugs)} bugs\n"
        )
        for number, what in list(campaign.bugs.items())[:20]:
            sys.stdout.write(f"  case {number}: {what}\n")
    return 1 if worst else 0


if __name__ == "__main__":
    sys.exit(main())
