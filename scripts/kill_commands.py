"""End commands at random moments, by signals, and see what they leave behind.

    python scripts/kill_commands.py [TIMES [SEED [COMMAND ...]]]

Each command is run once to its end, then so many times with a signal after a random part of that
time, to it alone or, as a terminal does, to all that it has started, too. Ended by SIGINT, SIGTERM
or SIGHUP it is so within 4 s, says that in one line and has that status, or is finished; it leaves
no temporary file, neither beside the result nor among the system's temporary files, and no process;
the result is the old file or the new one, whole. SIGKILL may leave temporary files, which the next
run takes away, and no process for long; of a batch also the folder in which Python's processes
meet, among the system's temporary files.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

__all__ = ["COMMANDS", "Case", "Left", "ended_at_random", "leftovers"]

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)
MARK = "PAINT3D_KILLED"
OLD = b"what was there before"
STATUS = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}
ENDS_S = 4.0  # 3 s where it computes; more only on a machine with no core for it
TOLD = ("paint3d: note: ", "planned ")  # how far it came
MEETING = "tmp/pymp-"  # Python's own, with a socket in it
PATIENCE_S = 30.0  # for a process to be gone, and, after its parent was killed, its children
TEXT = "永和"


class Case(NamedTuple):
    """A command: its arguments, and the files that it writes in its folder."""

    words: tuple[str, ...]
    files: tuple[str, ...]
    needs: tuple[str, ...] = ()  # of the commands' names, that are run first
    knows: str = ""  # a file by which it knows what is done


COMMANDS = {
    "demo": Case(
        ("demo", "--no-view", "--out", "demo"),
        ("demo/bowl.ply", "demo/bowl.glb", "demo/bowl.png", "demo/bowl.p3d"),
    ),
    "write": Case(("write", TEXT, "--on", "bowl", "--out", "write.png", "--force"), ("write.png",)),
    "record": Case(
        ("write", TEXT, "--on", "plane", "--out", "record.p3d", "--recording", "r.jsonl.gz",
         "--force"), ("record.p3d", "r.jsonl.gz"),
    ),
    "poem": Case(
        ("write", TEXT * 4, "--on", "plane", "--out", "poem.glb", "--processes", "2", "--force"),
        ("poem.glb",),
    ),
    "replay": Case(
        ("replay", "r.jsonl.gz", "--on", "plane", "--out", "replay.ply", "--force"),
        ("replay.ply",), ("record",),
    ),
    "film": Case(
        ("replay", "r.jsonl.gz", "--on", "plane", "--film", "film.webp", "--out", "film.ply",
         "--pixels", "160x120", "--fps", "4", "--force"), ("film.webp", "film.ply"), ("record",),
    ),
    "mp4": Case(
        ("picture", "record.p3d", "--turn", "2", "--pixels", "160x120", "--out", "film.mp4",
         "--force"), ("film.mp4",), ("record",),
    ),
    "picture": Case(
        ("picture", "record.p3d", "--out", "picture.png", "--force"), ("picture.png",), ("record",)
    ),
    "flat": Case(
        ("picture", "record.p3d", "--view", "flat", "--out", "flat.png", "--force"),
        ("flat.png",), ("record",),
    ),
    "seal": Case(("seal", TEXT, "--on", "plane", "--out", "seal.obj", "--force"), ("seal.obj",)),
    "copy": Case(
        ("copy", "flat.png", "--whole", "--on", "plane", "--out", "copy.glb", "--force"),
        ("copy.glb",), ("record", "flat"),
    ),
    "batch": Case(
        ("batch", "table.csv", "--processes", "2"),
        ("b0.glb", "b1.glb", "b2.glb", "b3.glb"), ("record",), "table.csv.finished",
    ),
}  # fmt: skip


class Left(NamedTuple):
    """Something that a terminated command left behind."""

    command: str
    signal: signal.Signals
    after_s: float
    what: str
    to_all: bool = False  # as a terminal tells a command, and all that it started, at once


def _environment(folder: Path) -> dict[str, str]:
    own = folder / "tmp"
    own.mkdir(exist_ok=True)
    return {**os.environ, "TMPDIR": str(own), MARK: str(folder)}


def _hear_all() -> None:
    """Handle signals also if this script runs in the background: ignored ones are inherited."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def _run(case: Case, folder: Path) -> subprocess.Popen[str]:
    if case.knows:
        (folder / case.knows).unlink(missing_ok=True)
    return subprocess.Popen(
        [sys.executable, "-m", "paint3d", *case.words],
        cwd=folder, env=_environment(folder), text=True, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        preexec_fn=_hear_all,
    )  # fmt: skip


def processes_of(folder: Path) -> list[str]:
    """List the command lines of living processes started from a folder's commands."""
    commands = []
    for folder_of in Path("/proc").iterdir():
        if folder_of.name.isdigit():
            try:
                if f"{MARK}={folder}".encode() in (folder_of / "environ").read_bytes().split(b"\0"):
                    words = (folder_of / "cmdline").read_bytes().replace(b"\0", b" ").decode()
                    commands.append(words.strip())
            except OSError:
                continue
    return commands


def leftovers(folder: Path) -> list[str]:
    """List temporary files beside results and in the temporary folder."""
    entries = [*folder.iterdir(), *folder.glob("demo/*")]
    beside = [str(entry.relative_to(folder)) for entry in entries if entry.name.startswith(".")]
    return sorted(beside + [f"tmp/{entry.name}" for entry in (folder / "tmp").iterdir()])


def _until(is_so: Callable[[], bool]) -> bool:
    until = time.monotonic() + PATIENCE_S
    while not is_so():
        if time.monotonic() > until:
            return False
        time.sleep(0.02)
    return True


def _wrong(
    name: str, folder: Path, number: signal.Signals, whole: dict[str, int], before: list[str]
) -> Iterator[str]:
    if not _until(lambda: not processes_of(folder)):
        yield f"processes: {processes_of(folder)}"
    left = [file for file in leftovers(folder) if file not in before]
    if number != signal.SIGKILL and left:
        yield f"files: {left}"
    for file in COMMANDS[name].files:
        size = (folder / file).stat().st_size
        if size not in (len(OLD), whole[file]):
            yield f"{file} has {size} bytes; expected {len(OLD)} or {whole[file]}"


def _is_bad_output(number: signal.Signals, status: int, output: str) -> bool:
    """Return whether a terminated command prints anything but that, or that it is finished."""
    if number == signal.SIGKILL or status == -number:  # Python was still loading the program
        return False
    if status == 0:
        return "Traceback" in output
    asked = "interrupted" if number == signal.SIGINT else "asked to end"
    errors = [line for line in output.splitlines() if not line.startswith(TOLD)]
    return status != STATUS[number] or errors not in ([], [f"paint3d: error: {asked}"])


def _ended_once(name: str, folder: Path, left: Left, whole: dict[str, int]) -> Iterator[Left]:
    for file in COMMANDS[name].files:
        (folder / file).write_bytes(OLD)
    before = leftovers(folder)
    running = _run(COMMANDS[name], folder)
    time.sleep(left.after_s)
    began = time.monotonic()
    with suppress(ProcessLookupError):
        (os.killpg if left.to_all else os.kill)(running.pid, left.signal)
    try:
        _, output = running.communicate(timeout=PATIENCE_S)
    except subprocess.TimeoutExpired:
        running.kill()
        _, output = running.communicate()
        yield left._replace(what="it did not end")
    took_s = time.monotonic() - began
    if took_s > ENDS_S:
        yield left._replace(what=f"it ended after {took_s:.1f} s")
    if _is_bad_output(left.signal, running.returncode, output):
        yield left._replace(what=f"status {running.returncode}: {output}")
    for what in _wrong(name, folder, left.signal, whole, before):
        yield left._replace(what=what)


def _finished(name: str, folder: Path) -> float:
    """Run a command to its end; return its duration, s."""
    began = time.monotonic()
    running = _run(COMMANDS[name], folder)
    _, output = running.communicate()
    if running.returncode:
        sys.exit(f"{name}: {output}")
    return time.monotonic() - began


def ended_at_random(names: list[str], times: int, seed: int = 1) -> list[Left]:
    """Terminate each command repeatedly; return what was left behind."""
    chance, left = random.Random(seed), list[Left]()
    for name in names:
        folder = Path(tempfile.mkdtemp())
        rows = [f"r.jsonl.gz,plane,full,pine soot,b{k}.glb" for k in range(4)]
        (folder / "table.csv").write_text("\n".join(["recording,object,brush,ink,output", *rows]))
        for need in COMMANDS[name].needs:
            _finished(need, folder)
        took_s = _finished(name, folder)
        whole = {file: (folder / file).stat().st_size for file in COMMANDS[name].files}
        for _ in range(times):
            number, after_s = chance.choice(SIGNALS), chance.uniform(0.0, 1.1) * took_s
            asked = Left(name, number, after_s, "", chance.random() < 0.5)
            left += _ended_once(name, folder, asked, whole)
        _finished(name, folder)
        kept = [file for file in leftovers(folder) if not file.startswith(MEETING)]
        left += [Left(name, signal.SIGKILL, took_s, f"files: {file}") for file in kept]
        shutil.rmtree(folder)
    return left


def main() -> None:
    """End each command the given number of times; fail if one left something."""
    times = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    n_left = 0
    for name in sys.argv[3:] or COMMANDS:
        left = ended_at_random([name], times, seed)
        n_left += len(left)
        sys.stdout.write(f"{name}: ended {times} times, {len(left)} left something\n")
        for one in left:
            whom = " to all" if one.to_all else ""
            sys.stdout.write(f"  {one.signal.name}{whom} after {one.after_s:.2f} s: {one.what}\n")
        sys.stdout.flush()
    if n_left:
        sys.exit(f"{n_left} left something behind")


if __name__ == "__main__":
    main()
