"""Kill a program that keeps a journal, at random moments, and see what is lost.

    python scripts/kill_journal.py [TIMES]

A child process appends samples at 1 kHz, ten at a time as a studio would, and is killed (SIGKILL)
after a random while. The time of the newest sample is in shared memory. The journal must
open, and end at most 100 ms before that.
"""

from __future__ import annotations

import mmap
import os
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from paint3d.device.sample import DeviceSample
from paint3d.files.project.journal import Journal, read_journal

__all__ = ["kill_at_random"]

STEP_NS, BATCH = 1_000_000, 10
ALLOWED_NS = 100_000_000
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def paint(path: Path, newest_ns: mmap.mmap) -> None:
    """Append samples for ever; `newest_ns` is set to the time of the newest one."""
    with Journal(path, {"brush": "full"}) as journal:
        start = time.monotonic_ns()
        n = 1
        while True:
            batch = []
            for _ in range(BATCH):
                while time.monotonic_ns() < start + n * STEP_NS:
                    time.sleep(STEP_NS * 1e-9)
                newest_ns[:8] = (n * STEP_NS).to_bytes(8, "little")
                position = np.array([n, 0.0, 0.0])
                batch.append(
                    DeviceSample(n * STEP_NS, position, UPRIGHT, 0.5, 0, np.zeros(3), UPRIGHT)
                )
                n += 1
            journal.append(batch)


def kill_once(path: Path, seconds: float) -> tuple[int, int]:
    """Return how many samples the journal holds, and the time that is lost, ns."""
    newest_ns = mmap.mmap(-1, 8)
    process = os.fork()
    if process == 0:
        try:
            paint(path, newest_ns)
        finally:
            os._exit(1)
    time.sleep(seconds)
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
    newest = int.from_bytes(newest_ns[:8], "little")
    if newest <= BATCH * STEP_NS:  # killed before the first batch was whole
        return 0, newest
    recording, _ = read_journal(path)
    times = recording.time_ns
    assert (np.diff(times) == STEP_NS).all()
    assert (recording.position[:, 0] == times // STEP_NS).all()
    return len(recording), newest - int(times[-1])


def kill_at_random(times: int, seed: int = 1) -> tuple[int, int]:
    """Kill `times` children; return the samples kept in all, and the longest loss, ns.

    Raises
    ------
    AssertionError
        If a journal lost more than 100 ms, or holds anything else than what was appended.
    """
    chance = random.Random(seed)
    kept = worst = 0
    with tempfile.TemporaryDirectory() as folder:
        for k in range(times):
            n, lost = kill_once(Path(folder) / f"{k}.p3dj", chance.uniform(0.02, 0.4))
            assert lost <= ALLOWED_NS, f"run {k} lost {lost * 1e-6:.0f} ms"
            kept, worst = kept + n, max(worst, lost)
    return kept, worst


def main() -> None:
    """Kill as often as the command line says, by default 200 times."""
    times = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    kept, worst = kill_at_random(times)
    sys.stdout.write(
        f"killed {times} times: {kept:,} samples kept, at most {worst * 1e-6:.0f} ms lost\n"
    )


if __name__ == "__main__":
    main()
