"""Waiting times: commands and the studio, each in a new process.

*First* is with an empty home, nothing compiled by numba, and the files of the program and its
packages (byte code as pip leaves it) dropped from memory, where the system permits; *again* is
after that, with the same home. The figures are medians. Wall time is from the start of the process
to its end, or to a line of its output.
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
_SAMPLING_S = 0.005
_TIMEOUT_S = 600.0
_UNSET = (  # environment variables that a new home is without
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
        Of the process and those that it waited for; 0 where the system does not measure it.
    peak_mb : float or None
        Peak memory of it and its children together; None if unknown.
    lines : list of (float, str)
        Lines of output, each with the seconds since the start.
    """

    wall_s: float
    cpu_s: float
    peak_mb: float | None
    lines: list[tuple[float, str]]

    def until(self, ending: str) -> float:
        """Return the time at which a line with this ending was written, s.

        Raises
        ------
        Paint3DError
            If there is none.
        """
        for seconds, line in self.lines:
            if line.endswith(ending):
                return seconds
        raise Paint3DError("a process of the benchmark did not write {ending!r}", ending=ending)


def wait_for(
    program: Sequence[str], folder: Path, *, home: Path | None = None, measure_memory: bool = False
) -> Waited:
    """Run a program in a folder and wait for its end.

    Parameters
    ----------
    program : sequence of str
    folder : Path
    home : Path, optional
        A home to replace the user's; numba's cache lies in it, too.
    measure_memory : bool
        Sample its memory while it runs, which takes a core's time.

    Raises
    ------
    Paint3DError
        If it fails, or has not ended after ten minutes.
    """
    environment = dict(os.environ)
    if home is not None:
        for name in _UNSET:
            environment.pop(name, None)
        environment |= {"HOME": os.fspath(home), "USERPROFILE": os.fspath(home)}
        environment["NUMBA_CACHE_DIR"] = os.fspath(home / "numba")
    before, began = os.times(), time.monotonic()
    process = subprocess.Popen(
        program, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    sampler = _MemorySampler(process) if measure_memory else None
    timeout = threading.Timer(_TIMEOUT_S, process.kill)
    timeout.start()
    lines: list[tuple[float, str]] = []
    assert process.stdout is not None, "it is a pipe"
    with process.stdout as pipe:
        for line in pipe:
            lines.append((time.monotonic() - began, line.decode(errors="replace").strip()))
    status, wall, after = process.wait(), time.monotonic() - began, os.times()
    timeout.cancel()
    if status != 0:
        last = lines[-1][1] if lines else f"exit status {status}"
        raise Paint3DError("a process of the benchmark failed: {last}", last=last)
    cpu = after.children_user + after.children_system
    cpu -= before.children_user + before.children_system
    return Waited(wall, cpu, sampler.stop() if sampler is not None else None, lines)


class _MemorySampler:
    """Samples the memory of a process and its descendants in a thread until `stop`."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process, self._peak = process, 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def stop(self) -> float | None:
        """Stop sampling; return the peak, MB, or None if the system does not say it."""
        self._over.set()
        self._thread.join()
        return 1e-6 * self._peak or None

    def _run(self) -> None:
        while not self._over.wait(_SAMPLING_S):
            self._peak = max(self._peak, _resident_bytes(self._process.pid))


def _resident_bytes(process: int) -> int:
    """Sum the resident memory of a process and its descendants, bytes; 0 if unknown."""
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
    """Drop the program's files from the system's cache, so that they are read from the disk."""
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
    """Rows and checks, as they are measured."""

    rounds: int
    rows: list[tuple[str, float, float, float | None]] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)

    def add(
        self, what: str, runs: Sequence[Waited], wanted: float | None, until: str | None = None
    ) -> None:
        """Add a row of medians: of the whole time, or until a line is written."""
        wall = median(one.wall_s if until is None else one.until(until) for one in runs)
        self.rows.append((what, wall, median(one.cpu_s for one in runs), wanted))
        self.seconds[what] = wall
        if wanted is not None:
            self.checks.append(Check(what, wall, wanted, unit="s"))

    def times(self, run: Callable[[], Waited]) -> list[Waited]:
        """Run it once each round."""
        return [run() for _ in range(self.rounds)]


def measure(scale: float = 1.0) -> Result:
    """Measure the time until commands are done and the studio can be painted in.

    Parameters
    ----------
    scale : float
        Of five rounds, of which at least one is run.

    Raises
    ------
    Paint3DError
        If a process fails.
    """
    compile_dir(Path(paint3d.__file__).parent, quiet=2)  # as pip does when it installs
    table = _Table(max(1, round(_ROUNDS * scale)))
    notes = ["First: empty home, nothing compiled by numba, files dropped from memory."]
    with tempfile.TemporaryDirectory(prefix="paint3d-bench-") as name:
        folder = Path(name)
        homes = _homes(folder)

        def run(home: Path, *arguments: str, measure_memory: bool = False) -> Waited:
            program = (sys.executable, "-m", "paint3d", *arguments)
            return wait_for(program, folder, home=home, measure_memory=measure_memory)

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
        peak = run(used, *_WRITE, measure_memory=True).peak_mb
        if peak is not None:
            notes.append(f"write 永 takes {peak:.0f} MB of memory, children and all.")
            table.checks.append(Check("memory of write", peak, 180.0, unit="MB"))
        notes += _measure_studio(table, folder, homes, used)
    return Result("Waiting, in new processes", _COLUMNS, table.rows, table.checks, notes)


def _homes(folder: Path) -> Iterator[Path]:
    """Yield empty homes, a new one each time."""
    k = 0
    while True:
        home = folder / f"home-{k}"
        home.mkdir()
        yield home
        k += 1


def _measure_studio(table: _Table, folder: Path, homes: Iterator[Path], used: Path) -> list[str]:
    """Add the studio's rows; return notes on them."""
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
    for when, runs, stroke_s in (("first", cold, 3.0), ("again", warm, 2.5)):
        table.add(f"studio's window painted, {when}", runs, 3.0, until="window painted")
        table.add(f"studio hears the hand, {when}", runs, stroke_s, until="hears the hand")
        table.add(f"a first stroke there, {when}", runs, None, until="stroke painted")
    return []
