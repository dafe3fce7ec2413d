"""Let a monkey at the studio's window, and tell what it breaks.

python -m scripts.monkey --actions 10000 --seed 1
python -m scripts.monkey --seed 1 --only 3-17 42        (some of its actions again)
python -m scripts.monkey --seed 1 --actions 300 --shrink  (the fewest actions with the same fault)

Needs a display; under Xvfb as good as any. Nothing outside a temporary folder is written.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from tests.app.monkey import Fault, Monkey


def numbers(texts: list[str]) -> list[int]:
    """Of "3-17 42"."""
    found: list[int] = []
    for text in texts:
        first, _, last = text.partition("-")
        found += range(int(first), int(last or first) + 1)
    return found


def one_run(options: argparse.Namespace) -> list[Fault]:
    """Do it in this process."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ.update(XDG_CONFIG_HOME=folder, PAINT3D_STATE=f"{folder}/state")
        from paint3d.app.window.start import make_program

        app = make_program()
        home = Path.cwd()
        (Path(folder) / "work").mkdir()
        os.chdir(Path(folder) / "work")
        monkey = Monkey(app, Path(folder) / "work", options.seed, options.start)
        began = time.monotonic()

        def told(number: int, faults: list[Fault]) -> None:
            for fault in faults:
                if fault.kind in options.ignore:
                    continue
                print(f"--- action {number}, {fault.kind}\n{fault.text}", flush=True)
                recent = [line for line in monkey.done if int(line.split(":")[0]) > number - 6]
                print("    after " + "\n          ".join(recent[-12:]), flush=True)
            if number % 100 == 99:
                print(f"{number + 1} actions, {time.monotonic() - began:.0f} s", flush=True)

        only = numbers(options.only) if options.only else None
        faults = monkey.run(options.actions, only, told)
        for fault in faults[-3:]:
            if fault.number == options.actions:
                print(f"--- at the end, {fault.kind}\n{fault.text}")
        monkey.close()
        os.chdir(home)
        print(f"slowest: {monkey.slowest_s:.1f} s")
    return [fault for fault in faults if fault.kind not in options.ignore]


def breaks(options: argparse.Namespace, chosen: list[int], wanted: str) -> bool:
    """Whether these actions, in a process of their own, have the same fault."""
    command = [sys.executable, "-m", "scripts.monkey", "--seed", str(options.seed), "--brief"]
    command += ["--start", options.start] if options.start else []
    command += ["--only", *map(str, chosen)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900)
    return wanted in done.stdout


def shrink(options: argparse.Namespace, faults: list[Fault]) -> list[int]:
    """The fewest actions that still have the first fault."""
    first = faults[0]
    wanted = first.short()
    chosen = list(range(first.number + 1))
    for last in (2, 5, 10, 20, 40, 80):
        if last < len(chosen) and breaks(options, chosen[-last:], wanted):
            chosen = chosen[-last:]
            break
    step = max(1, len(chosen) // 2)
    while step:
        k = 0
        while k < len(chosen) and len(chosen) > 1:
            fewer = chosen[:k] + chosen[k + step :]
            if fewer and breaks(options, fewer, wanted):
                chosen = fewer
            else:
                k += step
        step //= 2
    print(f"{wanted}: seed {options.seed}, actions {' '.join(map(str, chosen))}")
    return chosen


def main() -> int:
    """Run it, and tell."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--actions", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--start", help="open this in every new window; else it is empty")
    parser.add_argument("--only", nargs="+", help="numbers of actions, or ranges")
    parser.add_argument("--ignore", nargs="*", default=["slow"], help="kinds of faults")
    parser.add_argument("--shrink", action="store_true", help="find the fewest actions")
    parser.add_argument("--brief", action="store_true", help="print only what the faults are")
    options = parser.parse_args()
    faults = one_run(options)
    for text, n in Counter(fault.short() for fault in faults).most_common():
        print(f"{n} x {text}")
    if options.shrink and faults:
        shrink(options, faults)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
