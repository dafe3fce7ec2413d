"""The painting thread: a queue of samples and commands in, frames and events out; no call blocks.

All samples are painted, in order, by kernels that release the interpreter's lock, while the view
runs at whatever rate it can. Colours are computed once for each frame that is taken. An error
becomes an event, and painting goes on. With a `RecoveryFolder`, another thread journals every
sample and command as it is posted, before it is painted or while it is.

Wet ink runs by the hand's clock (`InkClock`): small time steps pass between the samples that are
painted, and by the wall clock while the queue is empty. Where the flow is too large to follow, ink
runs slower than real time (`Document.follow_time`), on every machine alike; where the machine
itself is too slow, steps are skipped, so that painting never lags.
"""

from __future__ import annotations

import itertools
import math
import os
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from queue import SimpleQueue
from typing import Any

from paint3d.app.model.brush_in_hand import BRUSH_COMMANDS, brush_after
from paint3d.app.model.commands import COMMANDS, encode_command
from paint3d.app.model.document import Document
from paint3d.app.model.frame import PaintingFrame, Snapshot, view_brush
from paint3d.app.model.ink_clock import InkClock
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, refusal
from paint3d.brush.spec import BrushSpec
from paint3d.device.sample import DeviceSample
from paint3d.errors import Paint3DError, RecordingError, SessionError
from paint3d.painter.ink_time import INK_STEP_S, LOOKAHEAD, is_lifted

CHECKS_ACCESS = bool(os.environ.get("PAINT3D_CHECKS"))
"""Whether it is checked that nobody but the painting thread uses the document, as tests have it."""

__all__ = ["CHECKS_ACCESS", "Event", "Pace", "PaintThread"]

_CHUNK = 64  # samples painted before it is looked whether a frame is wanted
_MOST_BEHIND_S = 0.16  # that painting may be when the time that passes at once has been followed
_MOST_WORK_S = 0.13  # for that time, even if painting is behind, where following it takes less
_KEEPS_UP = 0.8  # than so much of the time itself: then painting catches up
_BESIDE_S = 0.05  # that painting is behind where a piece of time always passes, whatever it takes
_SHORTEST_S = 1e-4  # that a piece of time is thought to take
_NEWS = 0.15  # fraction of the last piece of time in what one is thought to take
_LIVELY_S = 5.0  # after the hand has rested so long, time for the ink comes in larger portions:
_PORTION, _LARGEST_S = 0.05, 1.0  # of the rest; at most, and never more than painting catches up
_FOLLOW, _LIFT = "follow_time", "lift"
_ENDS = frozenset({"begin_stroke", "cancel_stroke", "end_stroke"})

_AUTOSAVE_INTERVAL_S = 120.0
_AGAIN_S = 10.0  # after which a base is tried again that is to make up for a gap in the journal

Operation = str | Callable[..., object]


@dataclass(frozen=True)
class Event:
    """Something to show to the user.

    Attributes
    ----------
    kind : {"error", "internal", "kept"}
        "error": a command was refused; "internal": a bug of the program; "kept": recovery data is
        complete again, after some of it could not be written.
    doing : str
        What was being done: a command's name, "painting", "showing", "preparing" the next
        stroke, or "keeping" what is painted.
    message : str
    error : Exception or None
    """

    kind: str
    doing: str
    message: str
    error: Exception | None


@dataclass(eq=False)
class _Job:
    """Samples, or a command and its future; and the time of arrival."""

    came: float
    samples: Sequence[DeviceSample] = ()
    command: Operation | None = None
    arguments: tuple[Any, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    result: Future[Any] | None = None


class Pace:
    """Measures the cost of a time step here, and limits how many may pass at once."""

    def __init__(self) -> None:
        self._piece_s = 0.0

    def took(self, seconds: float) -> None:
        """Record the duration of a step, s."""
        self._piece_s += _NEWS * (seconds - self._piece_s)

    def most(self, behind_s: float) -> int:
        """Steps that may pass at once when painting lags the hand by so many seconds."""
        available_s = _MOST_BEHIND_S - behind_s
        if self._piece_s <= _KEEPS_UP * INK_STEP_S:
            available_s = max(available_s, _MOST_WORK_S)
        pieces = int(available_s / max(self._piece_s, _SHORTEST_S))
        return max(pieces, 1 if behind_s <= _BESIDE_S else 0)  # or ink would never run again


class PaintThread:
    """Runs a document in a thread of its own.

    Parameters
    ----------
    document : Document
        Nobody else touches it until `stop`, except within `paused`.
    wet : bool
        Let ink spread and dry in real time.
    recovery : RecoveryFolder, optional
        Where what is painted is stored until it is saved; closed by `stop`.
    autosave_interval_s : float
        The least time between two bases of the recovery folder.

    Attributes
    ----------
    painting : Snapshot
        The painting after the last command or frame: who may not touch the document reads this.
    newest : DeviceSample or None
        What the hand did last, whether it is painted yet or not.
    ink_clock : InkClock
        Counts the time that passes for the ink, if it is wet.
    autosave_interval_s : float
    n_painted : int
        Samples that have been painted.
    last_asked_s : float
        When something was asked for, shown by the hand, or done, by `time.monotonic`; time for the
        ink is none of it.
    """

    def __init__(
        self,
        document: Document,
        wet: bool = False,
        recovery: RecoveryFolder | None = None,
        autosave_interval_s: float = _AUTOSAVE_INTERVAL_S,
    ) -> None:
        self._document = document
        self._wet = wet
        self._by_samples_alone = False  # alone what time it is for the ink
        self._haste = 1
        self.autosave_interval_s = autosave_interval_s
        self._writer = None if recovery is None else _JournalWriter(recovery, document, self.report)
        self._base_time, self._base_step = time.monotonic(), 0
        self._base_due = False
        self.n_painted = 0
        self._jobs: deque[_Job] = deque()
        self._brushes: deque[BrushSpec] = deque()  # asked for and not yet in hand
        self._wake = threading.Condition()
        self._busy = threading.Lock()
        self._wanting = 0
        self._slot: tuple[PaintingFrame, int] | None = (
            None  # and how many jobs were done when it was made
        )
        self._n_asked = self._n_done = 0  # jobs; time for the ink is none of them
        self._events: deque[Event] = deque()
        self._counts = document.surface.paint_mesh.arrays.counts.copy()  # in the last frame
        self.painting = Snapshot.of(document)
        self._holder: int | None = None  # the thread that has the document by `paused`
        self._hovering: DeviceSample | None = None
        self.last_asked_s = time.monotonic()
        self._fed: deque[DeviceSample] = deque(maxlen=LOOKAHEAD)  # last of this stroke, if wet
        self.newest: DeviceSample | None = None
        self._stopping = self._halted = self._working = self._nudged = False
        self._stale = True
        self._lag = 0.0
        self.ink_clock, self._pace = InkClock(time.perf_counter_ns()), Pace()
        self._seen_ns: tuple[int, int] | None = None  # the last two heartbeats
        self._thread = threading.Thread(target=self._run, name="paint3d-painting", daemon=True)
        if CHECKS_ACCESS:
            document.check_access = self._check_access
        self._thread.start()

    # -- for everybody ----------------------------------------------------------------------

    def post(self, command: Operation, *arguments: object, **options: object) -> Future[Any]:
        """Queue a command behind all that was posted before.

        Parameters
        ----------
        command : str or callable
            Name of a method of `Document`, or a function of the document.
        *arguments, **options
            For it.

        Returns
        -------
        Future
            Its result, or its error, which also becomes an event.
        """
        result: Future[Any] = Future()
        if command in BRUSH_COMMANDS:
            self._brushes.append(brush_after(self.brush, command, arguments))
            result.add_done_callback(lambda _: self._brushes.popleft())
        with self._wake:
            self._refuse_stopped()
            self._enqueue(_Job(time.perf_counter(), (), command, arguments, options, result))
            if command in _ENDS:
                self._fed.clear()
            self._wake.notify()
        return result

    @property
    def brush(self) -> BrushSpec:
        """The brush in hand after all commands that are queued."""
        try:
            return self._brushes[-1]
        except IndexError:
            return self.painting.brush

    def feed(self, samples: Sequence[DeviceSample], *, all_time: bool = False) -> None:
        """Paint samples of both hands, of the stroke that was begun by `post("begin_stroke")`.

        Parameters
        ----------
        samples : sequence of DeviceSample
        all_time : bool
            Let all the time pass between them for the ink, however late that makes the painting:
            no hand waits for it.
        """
        if samples:
            with self._wake:
                self._refuse_stopped()
                for job in self._with_time(samples, all_time):
                    self._enqueue(job)
                self._wake.notify()
            self.newest = samples[-1]

    def leave_out_samples(self, began: Future[Any], ended: Future[Any] | None) -> None:
        """Drop the samples queued between two commands; commands stay.

        Parameters
        ----------
        began, ended : Future
            Of the commands, from `post`; None where the second has not been posted.
        """
        with self._wake:
            waiting = list(self._jobs)
            commands = [job.result if job.command else self for job in waiting]
            first = commands.index(began) if began in commands else 0
            last = commands.index(ended) if ended in commands else len(waiting)
            if ended is not None and ended not in commands:
                last = first  # they are painted
            fed = [job for job in waiting[first:last] if job.command in (None, _LIFT, _FOLLOW)]
            self._drop_jobs(fed)
            self._base_due = True  # the journal says that they were painted

    def hover(self, sample: DeviceSample) -> None:
        """Show the brush here, without painting."""
        with self._wake:
            self._hovering = self.newest = sample
            self.last_asked_s = time.monotonic()
            self._stale = True
            self._wake.notify()

    def heartbeat(self) -> None:
        """Heartbeat from the window's thread: input older than the beat before has been delivered.

        While a window that has begun to call this is silent, because something blocks it, ink waits
        for input that may still be undelivered.
        """
        now = time.perf_counter_ns()
        with self._wake:
            self._seen_ns = (now if self._seen_ns is None else self._seen_ns[1], now)
            if self._is_ink_timed:
                until_ns = self._delivered_ns() - self._batched_ink_ns()
                if self.ink_clock.patience(until_ns) <= 0.0:
                    self._nudged = True
                    self._wake.notify()

    def take_frame(self) -> PaintingFrame | None:
        """Changes since the last frame that was taken, or None; never waits."""
        with self._wake:
            slot, self._slot = self._slot, None
            left = self._n_asked - (slot[1] if slot else 0)
            self._wake.notify()
        return replace(slot[0], queue_length=left) if slot else None

    def take_events(self) -> list[Event]:
        """Events since the last call, oldest first."""
        events = []
        while self._events:
            events.append(self._events.popleft())
        return events

    @property
    def wet(self) -> bool:
        """True if ink spreads and dries in real time; from now on, as soon as it is set."""
        return self._wet

    @wet.setter
    def wet(self, on: bool) -> None:
        with self._wake:
            self._wet = bool(on)
            self._fed.clear()
            self.ink_clock = InkClock(time.perf_counter_ns())
            self._nudged = True
            self._wake.notify()

    def use_sample_time_alone(self, on: bool, haste: int = 1) -> None:
        """Drive ink time by sample timestamps alone instead of the wall clock, or by both again.

        For playing recordings: slowly, with pauses or late, they meet the ink as the hand did.

        Parameters
        ----------
        on : bool
        haste : int
            So many times less time passes for the ink than between the samples, as if the hand had
            been that much faster.
        """
        with self._wake:
            self._by_samples_alone, self._haste = on, haste
            self._fed.clear()
            self.ink_clock = InkClock(time.perf_counter_ns())
            self._nudged = True
            self._wake.notify()

    @property
    def queue_length(self) -> int:
        """Batches of samples and commands that wait."""
        return len(self._jobs)

    @property
    def is_behind(self) -> bool:
        """True if a batch or command waits or is being done; ink time does not count."""
        return self._n_asked > self._n_done

    @property
    def is_still(self) -> bool:
        """True if the queue is empty, all is shown, and the last frame was taken."""
        with self._wake:
            return not (self._working or self._jobs or self._stale or self._slot is not None)

    @contextmanager
    def paused(self, seconds: float = -1.0) -> Iterator[Document | None]:
        """Hold the thread between two steps, to read the document.

        Parameters
        ----------
        seconds : float
            How long to wait for the step that is going on; None is given where it lasts longer.
            Below 0: as long as it takes.
        """
        with self._wake:
            self._wanting += 1
        is_held = self._busy.acquire(timeout=seconds)
        if is_held:
            self._holder = threading.get_ident()
        try:
            yield self._document if is_held else None
        finally:
            if is_held:
                self._holder = None
                self._busy.release()
            with self._wake:
                self._wanting -= 1

    def look(self, seconds: float) -> Document:
        """Document after the current step, or after `seconds`: only for reading."""
        with self.paused(seconds):
            return self._document

    @contextmanager
    def reporting(self, progress: Callable[[float], None]) -> Iterator[None]:
        """Report progress, within, of strokes that posted commands paint again.

        What `progress` raises stops that, and everything is as it was.
        """
        self.post(_set_progress, progress)
        try:
            yield
        finally:
            self.post(_set_progress, None)

    @property
    def recovery(self) -> RecoveryFolder | None:
        """Recovery folder, if there is one."""
        return None if self._writer is None else self._writer.recovery

    def set_autosave_interval(self, seconds: float) -> None:
        """Save bases for recovery no oftener than that, from now on."""
        with self._wake:
            self.autosave_interval_s = seconds
            self._wake.notify()

    def halt(self) -> None:
        """Begin no other step until `go_on`; the queue waits meanwhile."""
        with self._wake:
            self._halted = True

    def has_halted(self, seconds: float) -> bool:
        """Return whether the step that was going on when it was halted has ended in time."""
        with self._wake:
            return self._wake.wait_for(lambda: not self._working, seconds)

    def go_on(self) -> None:
        """Resume after `halt`."""
        with self._wake:
            self._halted = False
            self._wake.notify_all()

    def stop(self, keep: bool = False, *, finish: bool = True) -> None:
        """End the thread; a second time does nothing.

        Parameters
        ----------
        keep : bool
            Leave the recovery folder to be recovered.
        finish : bool
            Do what was asked for before; if not, only the step that is going on is waited for.
        """
        with self._wake:
            if not finish:
                self._drop_jobs(list(self._jobs))
            self._stopping = True
            self._wake.notify_all()
        self._thread.join()
        if self._writer is not None:
            self._writer.close(keep)
            self._writer = None

    # -- in the thread ----------------------------------------------------------------------

    def _check_access(self) -> None:
        """Refuse use of the document by a thread that does not hold it."""
        own = threading.get_ident()
        if own not in (self._thread.ident, self._holder) and self._thread.is_alive():
            raise RuntimeError(
                f"{threading.current_thread().name} uses the document that the painting thread "
                "has; expected `post`, or `paused` around it"
            )

    def _refuse_stopped(self) -> None:
        if self._stopping:
            raise RuntimeError("the painting thread was stopped")

    def _with_time(self, samples: Sequence[DeviceSample], all_time: bool) -> Iterator[_Job]:
        """Make jobs of samples that come now, and of the ink time between them; holds the lock."""
        now = time.perf_counter()
        behind = now - self._jobs[0].came if self._jobs else 0.0
        first = 0
        for k, sample in enumerate(samples if self._wet else ()):
            most = sys.maxsize if all_time else self._pace.most(behind)
            at_ns = sample.time_ns // self._haste
            pieces = self.ink_clock.advance_to(at_ns, round(1e9 * now), most)
            if pieces and first < k:
                yield _Job(now, tuple(samples[first:k]))
                first = k
            if pieces and is_lifted([*self._fed, sample]):
                yield _make_job(now, _LIFT)
            for _ in range(pieces):
                yield _ink_job(now)
            self._fed.append(sample)
        yield _Job(now, tuple(samples[first:]))

    def _enqueue(self, job: _Job) -> None:
        """Put a job into the queue and into the journal, in one order; holds the lock."""
        self._jobs.append(job)
        if job.command != _FOLLOW:
            self._n_asked += 1
            self.last_asked_s = time.monotonic()
        if self._writer is not None:
            self._writer.put(job)

    def _drop_jobs(self, jobs: Sequence[_Job]) -> None:
        """Cancel these waiting jobs; holds the lock."""
        left = {id(job) for job in jobs}
        self._jobs = deque(job for job in self._jobs if id(job) not in left)
        self._n_asked -= sum(job.command != _FOLLOW for job in jobs)
        for job in jobs:
            if job.result is not None and job.result.cancel():
                job.result.set_running_or_notify_cancel()  # who waits for it gets this

    def _run(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(self._has_work, self._longest_sleep())
                if self._stopping and not self._jobs:
                    return
                if self._halted and not self._stopping:
                    continue
                yielding = self._wanting > 0
                self._working, self._nudged = True, False
            if yielding:
                time.sleep(0.0005)  # let who waits in `paused` have the document
            with self._busy:
                self._work()
            with self._wake:
                self._working = False
                self._wake.notify_all()

    def _has_work(self) -> bool:
        if self._halted and not self._stopping:
            return False
        asked = bool(self._jobs) or self._stopping or self._nudged
        return asked or (self._stale and self._slot is None)

    def _longest_sleep(self) -> float | None:
        """Longest time to sleep, s; None for no limit."""
        if self._is_ink_timed:
            patience = self.ink_clock.patience(self._delivered_ns())
            if self._seen_ns is None or patience <= 0.0:
                return patience  # else a heartbeat says that it is time
        if self._writer is None:
            return None
        return (
            min(_AGAIN_S, self.autosave_interval_s)
            if self._writer.has_gap
            else self.autosave_interval_s
        )

    @property
    def _is_ink_timed(self) -> bool:
        """True if ink time passes without samples."""
        return self._wet and not self._by_samples_alone

    def _work(self) -> None:
        with self._wake:
            job = self._jobs.popleft() if self._jobs else None
        if job is not None:
            self._run_job(job)
            if job.command != _FOLLOW:
                self._n_done += 1
                self.last_asked_s = time.monotonic()
        elif self._wet:
            self._advance_idle_ink()
        if self._slot is None and self._stale:
            self._run_guarded("showing", self._publish)
        if not self._jobs:
            self._run_guarded("keeping", self._save_due_base)
            self._run_guarded("preparing", self._document.prepare_next_stroke)

    def _run_job(self, job: _Job) -> None:
        self._stale = True
        if job.command is None:
            try:
                self._paint_chunk(job)
            except Exception as error:
                self.report("painting", error)
                self._note_refusal(error)
            return
        command, result = job.command, job.result
        assert result is not None, "a command has one"
        name = command if isinstance(command, str) else command.__name__
        if not result.set_running_or_notify_cancel():
            return
        before = time.perf_counter()
        try:
            self._note_steps_past_base(name)
            if isinstance(command, str):
                done = getattr(self._document, name)(*job.arguments, **job.options)
            else:
                done = command(self._document, *job.arguments, **job.options)
            if name == "save" and self._writer is not None:
                self._writer.recovery.name_file(self._document)
            if name not in (_FOLLOW, _LIFT):
                self.painting = Snapshot.of(self._document)
            result.set_result(done)
        except CancelledError as stopped:  # as who asked for it wished
            self._base_due = True  # the journal says that it was done
            result.set_exception(stopped)
        except Exception as error:
            self.report(name, error)
            self._note_refusal(error)
            result.set_exception(error)
        if name == _FOLLOW:
            self._pace.took(time.perf_counter() - before)

    def _paint_chunk(self, job: _Job) -> None:
        """Paint a chunk of a batch; queue the rest of it."""
        chunk, rest = job.samples[:_CHUNK], job.samples[_CHUNK:]
        if rest:
            with self._wake:
                self._jobs.appendleft(_Job(job.came, rest))
                self._n_asked += 1
        self._hovering = chunk[-1]
        self._document.feed(chunk)
        self.n_painted += len(chunk)
        self._lag = time.perf_counter() - job.came

    def _advance_idle_ink(self) -> None:
        """Advance the ink while the hand is silent."""
        is_dry = self._document.surface.flow_patience == math.inf
        with self._wake:
            if self._jobs or self._stopping or not self._is_ink_timed:
                return
            passed = self.ink_clock.wait(self._delivered_ns(), self._pace.most(0.0))
            if passed and not is_dry:
                self._enqueue(_ink_job(time.perf_counter()))

    def _batched_ink_ns(self) -> int:
        """Ink time that passes in one batch, ns: waking for each step costs more."""
        rested_s = time.monotonic() - self.last_asked_s
        if rested_s < _LIVELY_S:
            return 0
        most_s = INK_STEP_S * (self._pace.most(0.0) // 2)
        return round(1e9 * min(_PORTION * rested_s, _LARGEST_S, most_s))

    def _delivered_ns(self) -> int:
        """Time up to which the hand's events have been delivered, except for those in transit."""
        return time.perf_counter_ns() if self._seen_ns is None else self._seen_ns[0]

    # -- keeping ----------------------------------------------------------------------------

    def _note_refusal(self, error: Exception) -> None:
        """Note in the journal that a command was refused: replaying it will be refused, too."""
        if self._writer is not None and isinstance(error, Paint3DError):
            self._writer.note(refusal(error))

    def _note_steps_past_base(self, name: str) -> None:
        """Note before an undo or redo whether it leads past the base, which must then follow.

        Bases hold the steps themselves, as far as there is capacity.
        """
        if name in ("undo", "redo") and self._document.edits.has_any:
            self._base_due = True  # no base knows the way over an edit
        if not self._document.left_out:
            return
        steps = self._document.steps
        number = {"undo": steps.next_undo, "redo": steps.next_redo}.get(name, steps.newest + 1)
        if name == "replay_history" or 0 < number <= self._base_step:
            self._base_due = True

    def _save_due_base(self) -> None:
        """Save a new base where it is due and the hand rests; nothing is lost meanwhile."""
        if self._writer is None or self._document.in_stroke:
            return
        passed_s = time.monotonic() - self._base_time
        late = passed_s > self.autosave_interval_s
        gap = self._writer.has_gap and passed_s > _AGAIN_S
        if not (self._base_due or gap or (late and self._writer.n_put)):
            return
        with self._wake:
            if self._jobs:
                return
            turned = self._writer.rotate_journal()  # what comes from now on is in the next journal
            self._base_due = False
        self._base_time = time.monotonic()
        self._base_step = self._document.steps.newest
        turned.result()
        gap = self._writer.had_gap
        try:
            self._writer.recovery.save_base(self._document)
        except Exception:
            self._writer.has_gap = gap or self._writer.has_gap
            raise
        if gap:
            self._events.append(Event("kept", "keeping", "all that is painted is kept again", None))

    def _publish(self) -> None:
        document = self._document
        self._stale = False
        ids = document.refresh()
        counts = document.surface.paint_mesh.arrays.counts.copy()
        has_grown = bool((counts != self._counts).any())
        self._counts = counts
        sample = self._hovering
        self.painting = Snapshot.of(document)
        frame = PaintingFrame(
            ids,
            has_grown,
            None if sample is None else view_brush(document, sample),
            0,  # as it is when it is taken
            self._lag,
            self.painting,
        )
        with self._wake:
            self._slot = frame, self._n_done

    def _run_guarded(self, doing: str, action: Callable[[], None]) -> None:
        try:
            action()
        except Exception as error:
            self.report(doing, error)

    def report(self, doing: str, error: Exception) -> None:
        """Queue an error as an event."""
        known = isinstance(error, Paint3DError)
        message = str(error) if known else f"{type(error).__name__}: {error}"
        self._events.append(Event("error" if known else "internal", doing, message, error))


def _set_progress(document: Document, progress: Callable[[float], None] | None) -> None:
    document.progress = progress


def _ink_job(came: float) -> _Job:
    """A job that lets time pass for the ink."""
    return _make_job(came, _FOLLOW, INK_STEP_S)


def _make_job(came: float, command: str, *arguments: object) -> _Job:
    return _Job(came, (), command, arguments, {}, Future())


_Item = _Job | Future[Any] | Mapping[str, object]  # for the journal writer


class _JournalWriter:
    """Writes samples and commands into the journal in a thread, so that nobody waits for the disk.

    Attributes
    ----------
    n_put : int
        What was put since the journal was rotated.
    has_gap, had_gap : bool
        Whether something could not be written that only a base can make up for: in this journal,
        and in those before it when it was rotated.
    """

    def __init__(
        self, recovery: RecoveryFolder, document: Document, report: Callable[[str, Exception], None]
    ) -> None:
        self.recovery = recovery
        self._document = document  # what changes of it `rotate_journal` alone reads: painting waits
        self.n_put = 0
        self.has_gap = self.had_gap = False
        self._leaving = False  # what is written would be deleted
        self._report = report
        self._queue: SimpleQueue[_Item | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="paint3d-journal", daemon=True)
        self._thread.start()

    def put(self, job: _Job) -> None:
        """Write a job into the journal, if it is one that changes the painting."""
        if job.command is None or (
            isinstance(job.command, str)
            and (job.command in COMMANDS and COMMANDS[job.command].codec is not None)
        ):
            self.n_put += 1
            self._queue.put(job)

    def note(self, words: Mapping[str, object]) -> None:
        """Write a fact about the last job; see `RecoveryFolder.note`."""
        self._queue.put(words)

    def rotate_journal(self) -> Future[Any]:
        """Start a new journal for the jobs from now on."""
        turned: Future[Any] = Future()
        self.n_put = 0
        self._queue.put(turned)
        return turned

    def close(self, keep: bool) -> None:
        """Write what waits, if wanted, and close the recovery folder."""
        self._leaving = not keep
        self._queue.put(None)
        self._thread.join()
        self.recovery.close(keep)

    def _run(self) -> None:
        broken = False
        while items := self._take_waiting():
            for turns, some in itertools.groupby(items, lambda item: isinstance(item, Future)):
                if self._leaving:
                    continue
                errors = (self._rotate_journals if turns else self._write_all)(some)
                if errors:  # painting goes on; it is reported once
                    if not broken:
                        self._report("keeping", errors[0])
                    self.has_gap = True
                broken = bool(errors)

    def _take_waiting(self) -> list[_Item]:
        """Take all that waits, or else wait for the next; empty at the end."""
        items = [self._queue.get()]
        while items[-1] is not None and not self._queue.empty():
            items.append(self._queue.get())
        if items[-1] is None and len(items) > 1:
            self._queue.put(None)
        return [item for item in items if item is not None]

    def _write_all(self, items: Iterable[_Item]) -> list[Exception]:
        """Write items with one call of the system; return the errors of those that failed."""
        errors: list[Exception] = []
        try:
            with self.recovery.together():
                for item in items:
                    try:
                        self._write(item)
                    except Exception as error:
                        errors.append(error)
        except Exception as error:
            errors.append(error)
        return errors

    def _rotate_journals(self, items: Iterable[_Item]) -> list[Exception]:
        errors: list[Exception] = []
        for turned in items:
            assert isinstance(turned, Future), "they are asked for by `rotate_journal`"
            try:
                self.recovery.rotate_journal(self._document)
            except Exception as error:
                errors.append(error)
                self.has_gap = True
                turned.set_exception(error)
            else:
                self.had_gap, self.has_gap = self.has_gap, False
                turned.set_result(None)
        return errors

    def _write(self, item: _Item) -> None:
        if isinstance(item, Mapping):
            self.recovery.note(item)
        elif isinstance(item, _Job) and item.command is None:
            self.recovery.append(item.samples)
        elif isinstance(item, _Job) and isinstance(item.command, str):
            try:
                line = encode_command(self._document, item.command, item.arguments, item.options)
            except (RecordingError, SessionError):
                raise
            except Paint3DError:  # the document refuses it for the same reason
                return
            self.recovery.note(line)
