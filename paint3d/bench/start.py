"""Waiting times: commands and the studio, each in a new process.

What is called *first* runs with an empty home and nothing compiled by numba, after the files of the
program and its packages, byte code as pip leaves them, have been dropped from memory where the
system lets one; *again* after that, with the same home. The figures are medians. Wall time is from
beginning the process to its end, or to what is said.
"""

from __future__ import annotations

import mmap
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from compileall import compile_dir
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

import numpy as np

import paint3d
from paint3d.bench.result import Check, Result
from paint3d.errors import Paint3DError

__all__ = ["Waited", "measure", "wait_for"]

_ROUNDS = 5
_LOOK_S = 0.005
_PATIENCE_S = 600.0
_LEFT_OUT = (
    "PAINT3D_CONFIG",
    "PAINT3D_STATE",
    "XDG_CONFIG_HOME",
    "XDG_STATE_HOME",
    "XDG_CACHE_HOME",
    "PYTHONDONTWRITEBYTECODE",
)
_SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")
_WRITE = ("write", "永", "--on", "bowl", "--out", "x.glb", "--force")
_HAIRS = ("write", "一", "--on", "bowl", "--out", "hairs.glb", "--hairs", "300", "--force")
_REPLAY = ("replay", "x.csv", "--on", "bowl", "--out", "y.glb", "--force")
_DEMO = ("demo", "--no-view", "--out", "demo")
_STUDIO = ("paint", "bowl")
_COLUMNS = ("what", "wall s", "CPU s", "wanted s")


@dataclass(frozen=True)
class Waited:
    """Time, memory and output of a process.

    Attributes
    ----------
    wall_s : float
    cpu_s : float
        Of the process and those that it waited for; 0 where the system does not tell.
    peak_mb : float or None
        The most that it and its children had in memory at a time; None where that is not known.
    lines : list of (float, str)
        What it wrote, with the seconds since it was begun.
    """

    wall_s: float
    cpu_s: float
    peak_mb: float | None
    lines: list[tuple[float, str]]

    def until(self, what: str) -> float:
        """Time at which a line that ends so was written, s.

        Raises
        ------
        Paint3DError
            If there is none.
        """
        for seconds, line in self.lines:
            if line.endswith(what):
                return seconds
        raise Paint3DError("a process of the benchmark did not say {what!r}", what=what)


def wait_for(
    program: Sequence[str], folder: Path, *, home: Path | None = None, weigh: bool = False
) -> Waited:
    """Run a program in a folder and wait for its end.

    Parameters
    ----------
    program : sequence of str
    folder : Path
    home : Path, optional
        The user's, instead of the one there is; numba's cache lies in it, too.
    weigh : bool
        Look at its memory while it runs, which takes a core's time.

    Raises
    ------
    Paint3DError
        If it fails, or has not ended after ten minutes.
    """
    environment = dict(os.environ) if home is None else _at_home(home)
    before, began = os.times(), time.monotonic()
    process = subprocess.Popen(
        program, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    scale = _Scale(process) if weigh else None
    limit = threading.Timer(_PATIENCE_S, process.kill)
    limit.start()
    lines: list[tuple[float, str]] = []
    assert process.stdout is not None, "it is a pipe"
    with process.stdout as pipe:
        for line in pipe:
            lines.append((time.monotonic() - began, line.decode(errors="replace").strip()))
    status, wall, after = process.wait(), time.monotonic() - began, os.times()
    limit.cancel()
    if status != 0:
        told = lines[-1][1] if lines else f"exit status {status}"
        raise Paint3DError("a process of the benchmark failed: {told}", told=told)
    cpu = after.children_user + after.children_system
    cpu -= before.children_user + before.children_system
    return Waited(wall, cpu, scale.most_mb() if scale is not None else None, lines)


class _Scale:
    """Looks at the memory of a process and its descendants, again and again until it has ended."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process, self._most = process, 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)
        self._thread.start()

    def most_mb(self) -> float | None:
        """The most that was seen at a time; None where the system does not tell."""
        self._over.set()
        self._thread.join()
        return 1e-6 * self._most or None

    def _look(self) -> None:
        while not self._over.wait(_LOOK_S):
            self._most = max(self._most, _memory(self._process.pid))


def _at_home(home: Path) -> dict[str, str]:
    kept = {name: value for name, value in os.environ.items() if name not in _LEFT_OUT}
    numba = {"NUMBA_CACHE_DIR": os.fspath(home / "numba")}
    return {**kept, **numba, "HOME": os.fspath(home), "USERPROFILE": os.fspath(home)}


def _memory(process: int) -> int:
    """Bytes that a process and its descendants hold, what they share counted for each; or 0."""
    total, waiting = 0, [process]
    while waiting:
        one = Path(f"/proc/{waiting.pop()}")
        try:
            total += int((one / "statm").read_text("ascii").split()[1]) * mmap.PAGESIZE
            for thread in (one / "task").iterdir():
                waiting += map(int, (thread / "children").read_text("ascii").split())
        except (OSError, ValueError):  # it has ended, or there is no such file here
            continue
    return total


def _forget_files() -> None:
    """Drop the program's files from the system's memory, so that they are read from the disk."""
    if not hasattr(os, "posix_fadvise"):
        return
    for folder in {Path(paint3d.__file__).parent, Path(np.__file__).parents[1]}:
        for path in folder.rglob("*"):
            if path.suffix not in (".py", ".pyc", ".so", ".json") and ".so." not in path.name:
                continue
            try:
                with path.open("rb") as file:
                    os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
            except OSError:
                continue


@dataclass
class _Table:
    """Rows and checks, as they are found."""

    rounds: int
    rows: list[tuple[str, float, float, float | None]] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)

    def add(
        self, what: str, found: Sequence[Waited], wanted: float | None, until: str | None = None
    ) -> None:
        """A row of medians: of the whole, or until a line is written."""
        wall = median(one.wall_s if until is None else one.until(until) for one in found)
        self.rows.append((what, wall, median(one.cpu_s for one in found), wanted))
        self.seconds[what] = wall
        if wanted is not None:
            self.checks.append(Check(what, wall, wanted, unit="s"))

    def times(self, run: Callable[[], Waited]) -> list[Waited]:
        """Run it as often as is asked for."""
        return [run() for _ in range(self.rounds)]


def measure(share: float = 1.0) -> Result:
    """Seconds until commands are done and the studio can be painted in, first and again.

    Parameters
    ----------
    share : float
        Of five rounds, of which at least one is run.

    Raises
    ------
    Paint3DError
        If a process fails.
    """
    compile_dir(Path(paint3d.__file__).parent, quiet=2)  # as pip does when it installs
    table = _Table(max(1, round(_ROUNDS * share)))
    notes = ["First: empty home, nothing compiled by numba, files dropped from memory."]
    with tempfile.TemporaryDirectory(prefix="paint3d-bench-") as name:
        folder = Path(name)
        homes = _homes(folder)

        def run(home: Path, *arguments: str, weigh: bool = False) -> Waited:
            program = (sys.executable, "-m", "paint3d", *arguments)
            return wait_for(program, folder, home=home, weigh=weigh)

        def first(*arguments: str) -> list[Waited]:
            def anew() -> Waited:
                _forget_files()
                return run(next(homes), *arguments)

            return table.times(anew)

        used = next(homes)
        table.add("write 永, first", first(*_WRITE), 1.2)
        run(used, *_WRITE, "--recording", "x.csv")
        table.add("write 永, again", table.times(lambda: run(used, *_WRITE)), 0.8)
        table.add("replay of it", table.times(lambda: run(used, *_REPLAY)), 0.6)
        table.add("inks", table.times(lambda: run(used, "inks")), 0.4)
        table.add("--help", table.times(lambda: run(used, "--help")), 0.1)
        demo = first(*_DEMO)
        table.add("demo's first line, first", demo, 1.0, until=demo[0].lines[0][1])
        table.add("demo, first", demo, 8.0)
        table.add("300 hairs, first", first(*_HAIRS), None)
        run(used, *_HAIRS)
        table.add("300 hairs, again", table.times(lambda: run(used, *_HAIRS)), None)
        wait = table.seconds["300 hairs, first"] - table.seconds["300 hairs, again"]
        table.checks.append(Check("300 hairs, first more than again", wait, 1.0, unit="s"))
        peak = run(used, *_WRITE, weigh=True).peak_mb
        if peak is not None:
            notes.append(f"write 永 takes {peak:.0f} MB of memory, children and all.")
            table.checks.append(Check("memory of write", peak, 180.0, unit="MB"))
        notes += _measure_studio(table, folder, homes, used)
    return Result("Waiting, in new processes", _COLUMNS, table.rows, table.checks, notes)


def _homes(folder: Path) -> Iterator[Path]:
    """Empty homes, another one each time."""
    k = 0
    while True:
        home = folder / f"home-{k}"
        home.mkdir()
        yield home
        k += 1


def _measure_studio(table: _Table, folder: Path, homes: Iterator[Path], used: Path) -> list[str]:
    """Add the studio's rows; what is to be said of them."""
    if not any(os.environ.get(name) for name in _SCREENS):
        return ["The studio was not measured: there is no display (DISPLAY is not set)."]

    def run(home: Path) -> Waited:
        shutil.rmtree(home / ".local", ignore_errors=True)  # or it asks what becomes of the stroke
        program = (sys.executable, "-m", "paint3d.app.window.first_stroke", f"{time.monotonic()}")
        return wait_for((*program, *_STUDIO), folder, home=home)

    def anew() -> Waited:
        _forget_files()
        return run(next(homes))

    cold = table.times(anew)
    run(used)
    warm = table.times(lambda: run(used))
    for when, found, stroke_s in (("first", cold, 3.0), ("again", warm, 2.5)):
        table.add(f"studio's window painted, {when}", found, 3.0, until="window painted")
        table.add(f"studio hears the hand, {when}", found, stroke_s, until="hears the hand")
        table.add(f"a first stroke there, {when}", found, None, until="stroke painted")
    return []
