"""The painting thread: samples and commands in, frames and events out, nobody waits.

A view runs at whatever rate it can; the hand's samples are all painted, in order, by kernels that
let other threads run meanwhile. Colours are computed once for every frame that is taken and not
oftener. What goes wrong in here is told as an event, and painting goes on.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass

from paint3d.app.model.document import Document
from paint3d.app.model.frame import Frame, GrowthWatch, view_brush
from paint3d.device.sample import DeviceSample
from paint3d.errors import Paint3DError

__all__ = ["Easel", "Event"]

_CHUNK = 64  # samples painted before it is looked whether a frame is wanted
_WET_STEP_S = 1.0 / 30.0
_LONGEST_WET_S = 0.2  # what is let pass at once, however long nobody painted

Command = str | Callable[[Document], object]


@dataclass(frozen=True)
class Event:
    """Something that the user should know.

    Attributes
    ----------
    kind : {"error", "internal"}
        "error": asked for what cannot be; "internal": a fault of the program.
    doing : str
        What was being done: a command's name, or "painting".
    message : str
    error : Exception
    """

    kind: str
    doing: str
    message: str
    error: Exception


@dataclass(eq=False)
class _Job:
    """Samples, or a command and where its result goes; and when it came."""

    came: float
    samples: Sequence[DeviceSample] = ()
    command: Command | None = None
    arguments: tuple = ()
    options: dict | None = None
    result: Future | None = None


class Easel:
    """Runs a document in a thread of its own.

    Parameters
    ----------
    document : Document
        Nobody else touches it until `stop`, except within `paused`.
    wet : bool
        Let ink spread and dry in real time.

    Attributes
    ----------
    document : Document
    """

    def __init__(self, document: Document, wet: bool = False) -> None:
        self.document = document
        self.wet = wet
        self._jobs: deque[_Job] = deque()
        self._wake = threading.Condition()
        self._busy = threading.Lock()
        self._wanting = 0
        self._slot: Frame | None = None
        self._events: deque[Event] = deque()
        self._watch = GrowthWatch(document.surface)
        self._hovering: DeviceSample | None = None
        self._stopping = False
        self._stale = True
        self._number = 0
        self._lag = 0.0
        self._last_wet = time.perf_counter()
        self._thread = threading.Thread(target=self._run, name="paint3d-easel", daemon=True)
        self._thread.start()

    # -- for everybody ----------------------------------------------------------------------

    def post(self, command: Command, *arguments: object, **options: object) -> Future:
        """Have something done after all that was asked before.

        Parameters
        ----------
        command : str or callable
            Name of a method of `Document`, or a function of the document.
        *arguments, **options
            For it.

        Returns
        -------
        Future
            Its result, or its error, which is also told as an event.
        """
        result: Future = Future()
        self._put(_Job(time.perf_counter(), (), command, arguments, options, result))
        return result

    def feed(self, samples: Sequence[DeviceSample]) -> None:
        """Paint samples of both hands, of the stroke that was begun by `post("begin_stroke")`."""
        if samples:
            self._put(_Job(time.perf_counter(), tuple(samples)))

    def hover(self, sample: DeviceSample) -> None:
        """Show the brush here, without painting."""
        with self._wake:
            self._hovering, self._stale = sample, True
            self._wake.notify()

    def take_frame(self) -> Frame | None:
        """What changed since the last frame that was taken, or None; never waits."""
        with self._wake:
            frame, self._slot = self._slot, None
            self._wake.notify()
        return frame

    def take_events(self) -> list[Event]:
        """What went wrong since the last call, oldest first."""
        events = []
        while self._events:
            events.append(self._events.popleft())
        return events

    @property
    def queue_length(self) -> int:
        """Batches of samples and commands that wait."""
        return len(self._jobs)

    @contextmanager
    def paused(self) -> Iterator[Document]:
        """Hold the painting still between two steps, to read the document."""
        with self._wake:
            self._wanting += 1
        try:
            with self._busy:
                yield self.document
        finally:
            with self._wake:
                self._wanting -= 1
                self._stale = True
                self._wake.notify()

    def stop(self) -> None:
        """Do what was asked for and end the thread; a second time does nothing."""
        with self._wake:
            self._stopping = True
            self._wake.notify()
        self._thread.join()

    # -- in the thread ----------------------------------------------------------------------

    def _put(self, job: _Job) -> None:
        with self._wake:
            if self._stopping:
                raise RuntimeError("the easel was stopped")
            self._jobs.append(job)
            self._wake.notify()

    def _run(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(self._has_work, self._patience())
                if self._stopping and not self._jobs:
                    return
                yielding = self._wanting > 0
            if yielding:
                time.sleep(0.0005)  # let who waits in `paused` have the document
            with self._busy:
                self._work()

    def _has_work(self) -> bool:
        return bool(self._jobs) or self._stopping or (self._stale and self._slot is None)

    def _patience(self) -> float | None:
        return _WET_STEP_S if self.wet else None

    def _work(self) -> None:
        if self._jobs:
            self._do(self._jobs.popleft())
        if self.wet:
            self._guarded("drying", self._let_time_pass)
        if self._slot is None and self._stale:
            self._guarded("showing", self._publish)

    def _do(self, job: _Job) -> None:
        self._stale = True
        if job.command is None:
            self._guarded("painting", lambda: self._paint(job))
            return
        name = job.command if isinstance(job.command, str) else job.command.__name__
        if not job.result.set_running_or_notify_cancel():
            return
        try:
            action = getattr(self.document, name) if job.command is name else job.command
            given = job.arguments if job.command is name else (self.document, *job.arguments)
            job.result.set_result(action(*given, **job.options))
        except Exception as error:
            self._tell(name, error)
            job.result.set_exception(error)

    def _paint(self, job: _Job) -> None:
        """Paint a chunk of a batch; what is left of it comes next."""
        chunk, rest = job.samples[:_CHUNK], job.samples[_CHUNK:]
        if rest:
            with self._wake:
                self._jobs.appendleft(_Job(job.came, rest))
        self._hovering = chunk[-1]
        self.document.feed(chunk)
        self._lag = time.perf_counter() - job.came

    def _let_time_pass(self) -> None:
        now = time.perf_counter()
        if now - self._last_wet >= _WET_STEP_S:
            self.document.let_time_pass(min(now - self._last_wet, _LONGEST_WET_S))
            self._last_wet = now
            self._stale = True

    def _publish(self) -> None:
        document = self.document
        self._stale = False
        ids = document.refresh()
        growth = self._watch.take()
        sample = self._hovering
        self._number += 1
        frame = Frame(
            self._number,
            ids,
            document.surface.codes[ids],
            document.surface.n_vertices,
            growth,
            None if sample is None else view_brush(document, sample),
            len(self._jobs),
            self._lag,
            document.can_undo,
            document.can_redo,
            len(document.strokes),
        )
        with self._wake:
            self._slot = frame

    def _guarded(self, doing: str, action: Callable[[], None]) -> None:
        try:
            action()
        except Exception as error:
            self._tell(doing, error)

    def _tell(self, doing: str, error: Exception) -> None:
        known = isinstance(error, Paint3DError)
        message = str(error) if known else f"{type(error).__name__}: {error}"
        self._events.append(Event("error" if known else "internal", doing, message, error))
