"""Kill a studio that paints, with layers, wet ink and hairs, at random moments; see what is lost.

    python scripts/kill_sitting.py [TIMES [SEED]]

A child process does what the studio does with a hand at the brush: samples at 1 kHz, five at once,
a tuft of single hairs, ink that spreads meanwhile, layers, undo, and a base saved when the brush is
lifted. It is killed (SIGKILL) after a random while. Every batch and command carries a number, and
when it was handed over stands in shared memory. What the sitting gives back must be all that
was handed over more than 100 ms before, and its ink must add up. How long a thread of the child
waited for a core or the disk meanwhile, and how long who kills stood still itself, is told beside
it, where the system knows (Linux): it excuses nothing.
"""

from __future__ import annotations

import contextlib
import dataclasses
import gc
import itertools
import math
import mmap
import os
import random
import signal
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from paint3d.app.model.document import Document
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.model.persistence.recovery_folder import Recovered, RecoveryFolder, recoverable
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BristleSpec
from paint3d.device.sample import DeviceSample

__all__ = ["Kill", "kill_at_random"]

STEP_NS, BATCH, STROKE = 1_000_000, 5, 120  # batches of a stroke
ALLOWED_NS = 100_000_000
EVENTS = 1 << 16
LOOK_S = 0.01  # how often it is looked how long the child waits for a core
BEGUN = 100  # events before the time to the kill begins: a busy machine starts slowly
BASES_S = 0.3  # between two at the least: in the studio they are rare
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
HAIRY = dataclasses.replace(load_brush("full"), name="hairy", bristles=BristleSpec(n_hairs=40))


class Waits(NamedTuple):
    """Waiting times within a loss, ns, as far as they could be observed."""

    core: int = 0  # by one of the threads, at most; what still goes on as it is killed is not seen
    disk: int = 0  # by any thread
    killer: int = 0  # between two looks of who kills: all of the machine may stand still


class Kill(NamedTuple):
    """Result of one killed sitting."""

    n_sent: int  # batches and commands that were handed over
    n_kept: int  # of these
    lost_ns: int  # from when the first of the others was handed over
    waits: Waits  # of it
    n_layers: int
    n_strokes: int
    is_wet: bool
    from_base: bool  # a later one than the first


class Teller:
    """Numbers and times of what is handed over, in memory that outlives the process."""

    def __init__(self) -> None:
        self._memory = mmap.mmap(-1, 8 * EVENTS)
        self.times = np.frombuffer(self._memory, np.int64)  # [0]: how many

    def tell(self) -> int:
        """Number the next batch or command, which is being handed over now."""
        number = int(self.times[0]) + 1
        self.times[number] = time.monotonic_ns()
        self.times[0] = number
        return number


def new_document() -> Document:
    """Make a plane of xuan paper and a brush of forty hairs."""
    return Document.new("plane", 1.5, "xuan", brush=HAIRY)


def batches(stroke: int, first_ns: int, chance: random.Random) -> list[list[DeviceSample]]:
    """Make the samples of a wavy stroke across the plane, lifted at both ends."""
    n, y = BATCH * STROKE, chance.uniform(-40, 40)
    x = np.linspace(-50, 50, n) * (-1) ** stroke
    ys = y + 6.0 * np.sin(x / 7.0)
    pressed = np.where((np.arange(n) > 0) & (np.arange(n) < n - 1), 0.4, 0.0)
    samples = [
        DeviceSample(
            first_ns + k * STEP_NS, np.array([x[k], ys[k], 35.0]), UPRIGHT, float(pressed[k]), 0,
            np.zeros(3), UPRIGHT,
        )
        for k in range(n)
    ]  # fmt: skip
    return [samples[k : k + BATCH] for k in range(0, n, BATCH)]


def sit(folder: Path, teller: Teller, seed: int) -> None:
    """Paint for ever, keeping a sitting; garbage is collected here alone, as in the studio."""
    gc.disable()
    gc.freeze()  # nor are its parent's objects looked at, whose pages would be copied by that
    document, chance = new_document(), random.Random(seed)
    paint_thread = PaintThread(
        document, wet=True, recovery=RecoveryFolder(document, folder), autosave_interval_s=BASES_S
    )
    between = (
        [("add_layer",)], [("undo",), ("redo",)], [("dip", {"cinnabar": 0.4, "water": 0.6})],
        [("dry",)], [("undo",)], [("select_layer", 0)], [],
    )  # fmt: skip

    def ask(name: str, *arguments: object) -> None:
        number = teller.tell()
        paint_thread.post(name, *arguments)
        paint_thread.post("set_tags", event=number)

    next_ns = time.monotonic_ns()
    for stroke in itertools.count():
        ask("begin_stroke")
        for batch in batches(stroke, next_ns, chance):
            next_ns += BATCH * STEP_NS
            gc.collect(0)
            time.sleep(max(0.0, (next_ns - time.monotonic_ns()) * 1e-9))
            number = teller.tell()
            paint_thread.feed(batch)
            paint_thread.post("set_tags", event=number)
        ask("end_stroke")
        for command in chance.choice(between):
            ask(*command)
        if chance.random() < 0.5:  # the hand rests: a base may be saved
            time.sleep(chance.uniform(0.0, 0.3))
        next_ns = time.monotonic_ns()


def kill_once(folder: Path, seconds: float, seed: int) -> Kill:
    """Let a sitting that has begun run for this time, kill it, and recover it."""
    teller = Teller()
    process = os.fork()
    if process == 0:
        try:
            sit(folder, teller, seed)
        finally:
            os._exit(1)
    while teller.times[0] < BEGUN and os.waitpid(process, os.WNOHANG) == (0, 0):
        time.sleep(0.001)
    looks = _watched(process, seconds)
    killed_ns = time.monotonic_ns()
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
    n_sent, unfinished_ones = int(teller.times[0]), recoverable(folder)
    if not unfinished_ones:  # killed before any of it was on the disk: all of it is lost
        lost_ns = killed_ns - int(teller.times[1])
        return Kill(n_sent, 0, lost_ns, _waited(looks, killed_ns - lost_ns), 0, 0, False, True)
    (unfinished,) = unfinished_ones
    recovered = unfinished.recover()
    _check(recovered)
    document = recovered.document
    n_kept = int(document.tags.get("event", 0))
    lost_ns = killed_ns - int(teller.times[n_kept + 1]) if n_kept < n_sent else 0
    waits = _waited(looks, killed_ns - lost_ns) if lost_ns > 0 else Waits()
    return Kill(
        n_sent, n_kept, max(lost_ns, 0), waits, len(document.layers), len(document.strokes),
        document.surface.flow_patience < math.inf, not any(unfinished.folder.glob("base-1.*")),
    )  # fmt: skip


class Look(NamedTuple):
    """Waiting times of a process's threads, observed at one time, ns."""

    at: int
    waited: dict[str, int]  # by each of its threads for a core, until then
    on_disk: bool  # one of them


def _watched(process: int, seconds: float) -> list[Look]:
    """Let a process run for this time; observe what its threads wait for."""
    looks: list[Look] = []
    until = time.monotonic() + seconds
    while True:
        at, threads, states = time.monotonic_ns(), {}, []
        for folder in Path(f"/proc/{process}/task").glob("*"):
            with contextlib.suppress(OSError):  # it may end meanwhile
                threads[folder.name] = int((folder / "schedstat").read_text().split()[1])
                states.append((folder / "stat").read_text().rpartition(")")[2].split()[0])
        looks.append(Look(at, threads, "D" in states))
        left = until - time.monotonic()
        if left <= 0.0:
            return looks
        time.sleep(min(LOOK_S, left))


def _waited(looks: list[Look], since_ns: int) -> Waits:
    """Sum the waiting times since then."""
    before = next((look for look in reversed(looks) if look.at <= since_ns), looks[0])
    later = [before, *(look for look in looks if look.at > before.at)]
    core = [waited - before.waited.get(name, 0) for name, waited in later[-1].waited.items()]
    apart = [(one, two.at - one.at) for one, two in itertools.pairwise(later)]
    disk = sum(gap for look, gap in apart if look.on_disk)
    return Waits(max(core, default=0), disk, max((gap for _, gap in apart), default=0))


def _check(recovered: Recovered) -> None:
    assert not recovered.refused, recovered.refused
    ledger = recovered.document.painter.ledger()
    loaded = ledger.pop("loaded")
    assert abs(sum(ledger.values()) - loaded) <= 1e-4 * max(loaded, 1.0), ledger
    assert np.isfinite(recovered.document.surface.amounts).all()


def kill_at_random(times: int, seed: int = 1) -> list[Kill]:
    """Kill `times` sittings; return what became of each.

    Raises
    ------
    AssertionError
        If one came back with what does not add up.
    """
    chance = random.Random(seed)
    kills = []
    _warm_up()
    for _ in range(times):
        with tempfile.TemporaryDirectory() as name:
            seconds, of_child = chance.uniform(0.05, 6.0), chance.randrange(1 << 30)
            kills.append(kill_once(Path(name), seconds, of_child))
    return kills


def _warm_up() -> None:
    """Paint once, so that the children need not compile or load what is compiled."""
    document = new_document()
    document.begin_stroke()
    for batch in batches(0, 1, random.Random(0)):
        document.feed(batch)
    document.end_stroke()
    document.let_time_pass(0.05)
    for name in ("add_layer", "dry", "undo"):
        getattr(document, name)()
    with tempfile.TemporaryDirectory() as folder:
        document.save(Path(folder) / "a.p3d")
        Document.open(Path(folder) / "a.p3d")


def main() -> None:
    """Kill as often as the command line says, by default 200 times; fail if too much was lost."""
    times = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    kills = kill_at_random(times, int(sys.argv[2]) if len(sys.argv) > 2 else 1)
    sys.stdout.write(
        f"killed {times} times: {sum(kill.n_kept for kill in kills):,} of "
        f"{sum(kill.n_sent for kill in kills):,} batches and commands kept, at most "
        f"{_lost(max(kills, key=lambda kill: kill.lost_ns))} lost; "
        f"{sum(kill.is_wet for kill in kills)} were wet, "
        f"{sum(kill.n_layers > 1 for kill in kills)} had layers, "
        f"{sum(kill.from_base for kill in kills)} had saved bases, up to "
        f"{max(kill.n_strokes for kill in kills)} strokes\n"
    )
    late = [_lost(kill) for kill in kills if kill.lost_ns > ALLOWED_NS]
    if late:
        most = f"{ALLOWED_NS * 1e-6:.0f} ms"
        sys.exit(f"{len(late)} of {times} lost more than {most}: {', '.join(late)}")


def _lost(kill: Kill) -> str:
    core, disk, killer = (f"{waited * 1e-6:.0f}" for waited in kill.waits)
    text = f"a thread waited {core} of them for a core, {disk} for the disk"
    text += f", who kills stood still for up to {killer}; {kill.n_sent - kill.n_kept} events"
    return f"{kill.lost_ns * 1e-6:.0f} ms ({text})"


if __name__ == "__main__":
    main()
