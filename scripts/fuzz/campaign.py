"""Cases of one target, tried in a worker process that may die."""

from __future__ import annotations

import faulthandler
import gzip
import mmap
import os
import random
import resource
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Iterator

from paint3d.errors import Paint3DError
from scripts.fuzz.targets import TARGETS, Target

__all__ = ["Campaign", "make_case", "try_case"]

MEMORY = 2 << 30
SECONDS = 20
HANGS = (signal.SIGPROF, signal.SIGALRM)
MOST_BUGS = 50


def make_case(
    target: Target, seeds: list[tuple[str, bytes]], name: str, number: int
) -> tuple[str, bytes]:
    """Return suffix and content of a case, which depend on its number alone."""
    chance = random.Random(f"{name} {number}")
    suffix, content = chance.choice(seeds)
    others = [other for _, other in seeds]
    if suffix.endswith(".gz") and chance.random() < 0.5:
        plain = target.damage(gzip.decompress(content), chance, others)
        return suffix, gzip.compress(plain, 1, mtime=0)
    return suffix, target.damage(content, chance, others)


def try_case(target: Target, suffix: str, content: bytes) -> tuple[bool, str]:
    """Return whether the input was accepted, and what is wrong with how it was treated."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            target.check(suffix, content)
    except Paint3DError as cause:
        message = str(cause)
        if "\n" in message:
            return False, f"a message of several lines: {message!r:.200}"
        if "fit into memory" in message or not message:
            return False, f"refused for a bad reason: {message!r:.200}"
        return False, ""
    except BaseException as cause:
        where = traceback.extract_tb(cause.__traceback__)[-1]
        return False, f"{type(cause).__name__}: {cause!s:.150} ({where.filename}:{where.lineno})"
    return True, ""


class Campaign:
    """Tries the cases from `first` to before `last`.

    Attributes
    ----------
    n_done, n_read : int
        Cases tried, and those of them that were accepted.
    bugs : dict
        What went wrong, by case number.
    """

    def __init__(self, name: str, first: int, last: int, seconds: float = float("inf")) -> None:
        self.name, self.first, self.last = name, first, last
        self.target = TARGETS[name]
        self.seeds = self.target.seeds()
        for suffix, content in self.seeds:  # also brings in whatever is imported on first use
            self.target.check(suffix, content)
        self.n_done = self.n_read = 0
        self.bugs: dict[int, str] = {}
        self._ends = time.monotonic() + seconds
        self._told = mmap.mmap(-1, 16)  # the case being tried, and how many were accepted

    def run(self) -> None:
        """Try all cases, with a new worker after every death."""
        at = self.first
        while at < self.last and len(self.bugs) < MOST_BUGS and time.monotonic() < self._ends:
            at = self._one_worker(at)
        self.n_done = at - self.first
        self.n_read = self._number(8)

    def _number(self, place: int, value: int | None = None) -> int:
        if value is not None:
            self._told[place : place + 8] = value.to_bytes(8, "little")
        return int.from_bytes(self._told[place : place + 8], "little")

    def _one_worker(self, first: int) -> int:
        """Try cases in a child; return the number of the next that is to be tried."""
        self._number(0, first)
        reading, writing = os.pipe()
        process = os.fork()
        if process == 0:
            os.close(reading)
            self._work(first, writing)
        os.close(writing)
        with open(reading, "rb") as pipe:
            for line in pipe:
                number, _, what = line.decode("utf-8", "replace").partition(" ")
                self.bugs[int(number)] = what.strip()
        _, status = os.waitpid(process, 0)
        at = self._number(0)
        if os.WIFSIGNALED(status):
            number = os.WTERMSIG(status)
            how = "a hang" if number in HANGS else signal.Signals(number).name
            self.bugs[at] = f"the reader died of {how}"
            at += 1
        elif status:
            self.bugs[at] = "it could not be tried: making it failed"
            at += 1
        return at

    def _work(self, first: int, writing: int) -> None:
        status = 1
        faulthandler.disable()  # the death is told by the parent
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # libraries talk about what is damaged
        try:
            resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            for number in HANGS:
                signal.signal(number, signal.SIG_DFL)
            for number, accepted, what in self._cases(first):
                if accepted:
                    self._number(8, self._number(8) + 1)
                if what:
                    os.write(writing, f"{number} {' '.join(what.split())}\n".encode())
            status = 0
        finally:
            sys.stderr.flush()
            os._exit(status)

    def _cases(self, first: int) -> Iterator[tuple[int, bool, str]]:
        for number in range(first, self.last):
            self._number(0, number)
            signal.setitimer(signal.ITIMER_PROF, SECONDS)  # its own time: the machine may be busy
            signal.alarm(10 * SECONDS)
            suffix, content = make_case(self.target, self.seeds, self.name, number)
            yield number, *try_case(self.target, suffix, content)
            if time.monotonic() > self._ends:
                self._number(0, number + 1)
                return
        self._number(0, self.last)
