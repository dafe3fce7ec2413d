"""Processes that are started to help give their results in order, and are never left behind."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from paint3d.calligraphy import processes
from paint3d.calligraphy.processes import in_processes, serve
from paint3d.errors import InputError, Paint3DError
from tests.support.cases import long_but

PATIENCE_S = 300
SLEEPERS = """
import os, sys, time
from paint3d.calligraphy.processes import in_processes

def work(item):
    os.write(1, b"%d\\n" % os.getpid())  # at once: two write at the same time
    time.sleep(600)

if __name__ == "__main__":
    print("starting", flush=True)
    list(in_processes(work, [1, 2, 3], 2))
"""


def test_results_come_in_order() -> None:
    assert list(in_processes(abs, [-3, 2, -1, 0, 5], 2)) == [3, 2, 1, 0, 5]
    assert list(in_processes(abs, [], 1)) == []


def test_what_fails_there_is_raised_here() -> None:
    with pytest.raises(InputError, match="an expected number"):
        list(in_processes(_refuse, [1, 2], 2))
    with pytest.raises(Paint3DError, match=r"died \(exit status 7\)"):
        list(in_processes(os._exit, [7], 1))


def test_what_cannot_be_sent_back_is_told() -> None:
    """A result, and an error that cannot be made again of what it says."""
    with pytest.raises(Paint3DError, match=r"could not be sent back: .*pickle"):
        list(in_processes(_locked, [1], 1))
    with pytest.raises(Paint3DError, match="could not be sent back: _TwofoldError: 3 of 4"):
        list(in_processes(_fail_twofold, [3], 1))


def _locked(item: int) -> object:
    return threading.Lock()


class _TwofoldError(Exception):
    def __init__(self, one: int, other: int) -> None:
        super().__init__(f"{one} of {other}")


def _fail_twofold(item: int) -> None:
    raise _TwofoldError(item, 4)


def _refuse(item: int) -> int:
    raise InputError(f"{item} is no surprise; an expected number")


@contextmanager
def started(tmp_path: Path) -> Iterator[subprocess.Popen]:
    script = tmp_path / "sleepers.py"
    script.write_text(SLEEPERS)
    running = subprocess.Popen(
        [sys.executable, script],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        # a shell's background jobs, as tests may be, ignore what they are to obey here
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    try:
        assert running.stdout is not None
        assert running.stdout.readline() == "starting\n"
        yield running
    finally:
        with suppress(ProcessLookupError):
            os.killpg(running.pid, signal.SIGKILL)
        running.communicate(timeout=PATIENCE_S)


def is_alive(number: int) -> bool:
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    state = Path(f"/proc/{number}/stat")  # one that nobody has waited for is dead, too
    return not state.exists() or state.read_text().rpartition(")")[2].split()[0] != "Z"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_none_outlives_the_one_that_started_it(number: int, tmp_path: Path) -> None:
    with started(tmp_path) as running:
        assert running.stdout is not None
        workers = [int(running.stdout.readline()) for _ in range(2)]
        assert all(map(is_alive, workers))
        running.send_signal(number)
        running.wait(PATIENCE_S)
        began = time.monotonic()
        while any(map(is_alive, workers)):
            assert time.monotonic() - began < PATIENCE_S, "they live on"
            time.sleep(0.02)


def test_one_whose_answer_nobody_awaits_ends_quietly(monkeypatch) -> None:
    """As when who asked was killed a moment before."""
    monkeypatch.setattr(processes, "ignore_interrupts", lambda: None)  # of the tests themselves
    ours, theirs = multiprocessing.Pipe()
    ours.send((0, -3))
    ours.close()
    serve(abs, theirs)


@pytest.mark.parametrize(  # while they start; at work
    "later_s", long_but([0.05, None], [0.0, 0.05, 0.15, 0.4, None])
)
def test_an_interrupt_is_told_by_one_alone(later_s: float | None, tmp_path: Path) -> None:
    with started(tmp_path) as running:
        assert running.stdout is not None
        if later_s is None:
            for _ in range(2):
                running.stdout.readline()
        else:
            time.sleep(later_s)
        os.killpg(running.pid, signal.SIGINT)  # as a terminal does: all of them get it
        _, errors = running.communicate(timeout=PATIENCE_S)
        assert errors.count("Traceback") == 1
        assert errors.rstrip().endswith("KeyboardInterrupt")
