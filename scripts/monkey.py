"""Send random events to the studio's window, and report the faults.

python -m scripts.monkey --actions 10000 --seed 1
python -m scripts.monkey --seed 1 --only 3-17 42        (some of its actions again)
python -m scripts.monkey --seed 1 --actions 300 --shrink  (the fewest actions with the same fault)
python -m scripts.monkey --seed 1 --disk read-only        (or full; mounts one, so it needs root)

Needs a display; under Xvfb as good as any. Nothing outside a temporary folder is written.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from tests.support.app.monkey import Fault, Monkey


def numbers(texts: list[str]) -> list[int]:
    """Parse numbers and ranges, such as "3-17 42"."""
    result: list[int] = []
    for text in texts:
        first, _, last = text.partition("-")
        result += range(int(first), int(last or first) + 1)
    return result


class Disk:
    """A small disk of its own at a folder, which can be made read-only or full, and restored.

    Parameters
    ----------
    folder : str
    kind : {"read-only", "full"} or None
        None: the folder stays as it is.
    """

    def __init__(self, folder: str, kind: str | None) -> None:
        self._folder, self._kind = folder, kind

    def __enter__(self) -> Disk:
        if self._kind is not None:
            self._mount("-t", "tmpfs", "-o", "size=64m", "tmpfs")
        return self

    def __exit__(self, *_: object) -> None:
        if self._kind is not None:
            subprocess.run(["umount", "--lazy", self._folder], check=True)

    def spoil(self) -> None:
        """Make the disk refuse writing."""
        if self._kind == "read-only":
            self._mount("-o", "remount,ro")
        elif self._kind == "full":
            with contextlib.suppress(OSError), open(self._filler, "wb", buffering=0) as file:
                while file.write(bytes(4096)):
                    pass

    def mend(self) -> None:
        """Make the disk writable again."""
        if self._kind == "read-only":
            self._mount("-o", "remount,rw")
        elif self._kind == "full":
            self._filler.unlink()

    @property
    def _filler(self) -> Path:
        return Path(self._folder) / "filler"

    def _mount(self, *how: str) -> None:
        subprocess.run(["mount", *how, self._folder], check=True)


class MonkeyOnDisk(Monkey):
    """A monkey whose folder lies on a disk that cannot be written meanwhile.

    Parameters
    ----------
    disk : Disk
    others
        See `Monkey`.
    """

    def __init__(self, disk: Disk, *others: object) -> None:
        self._disk = disk
        super().__init__(*others)

    def _fill_folder(self) -> None:
        super()._fill_folder()
        self._disk.spoil()

    def _end(self) -> None:
        self._disk.mend()
        super()._end()


def one_run(options: argparse.Namespace) -> list[Fault]:
    """Run in this process; return the faults."""
    with tempfile.TemporaryDirectory() as folder, Disk(folder, options.disk) as disk:
        os.environ.update(XDG_CONFIG_HOME=folder, PAINT3D_STATE=f"{folder}/state")
        from paint3d.app.window.start import make_program

        app = make_program()
        home = Path.cwd()
        (Path(folder) / "work").mkdir()
        os.chdir(Path(folder) / "work")
        monkey = MonkeyOnDisk(disk, app, Path(folder) / "work", options.seed, options.start)
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
    """Return whether these actions, in a process of their own, have the same fault."""
    command = [sys.executable, "-m", "scripts.monkey", "--seed", str(options.seed), "--brief"]
    command += ["--start", options.start] if options.start else []
    command += ["--disk", options.disk] if options.disk else []
    command += ["--only", *map(str, chosen)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900)
    return wanted in done.stdout


def shrink(options: argparse.Namespace, faults: list[Fault]) -> list[int]:
    """Find the fewest actions that still have the first fault."""
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
    """Run, and print the faults."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--actions", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--start", help="open this in every new window; else it is empty")
    parser.add_argument("--disk", choices=("read-only", "full"), help="that all files lie on")
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
