"""Recorder of a document's score: its commands and samples, in order."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import wraps
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar

from paint3d.app.model.commands import COMMANDS, Command, encode_line
from paint3d.app.model.score.codecs import InkTable, Vocabulary, make_header
from paint3d.app.model.stroke_log import recording_of
from paint3d.brush.spec import DipAmount
from paint3d.device.sample import DeviceSample
from paint3d.errors import Paint3DError, RecordingError
from paint3d.files.project.session import Session
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score, check_command, undo_kinds
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["ScoreRecorder", "recorded"]


class _Recorded(Protocol):
    """Interface that a document has for its methods to be recorded."""

    recorder: ScoreRecorder | None
    check_access: Callable[[], None]

    @property
    def surface(self) -> PaintedSurface: ...

    @property
    def painter(self) -> Painter: ...

    @property
    def current_stroke(self) -> Any: ...


_P = ParamSpec("_P")
_Result = TypeVar("_Result")
_Document = TypeVar("_Document", bound=_Recorded)

_OF_WHOLE = ("brush", "ink", "dipped", "dips", "amount", "azimuth")
"""Settings of a painting that was painted whole which say with what, where it is gone on with."""


class _SampleRun(list[DeviceSample]):
    """Samples that came one after the other."""

    _recording: Recording | None = None

    def recording(self) -> Recording:
        """As a recording, which is made once: of wet ink there are thirty in a second."""
        if self._recording is None or len(self._recording) != len(self):
            self._recording = recording_of(self, {})
        return self._recording


_Event = dict[str, Any] | _SampleRun


class ScoreRecorder:
    """Records the commands and samples that a document receives.

    Parameters
    ----------
    header : mapping
        Of the score: what painting began with.
    events : sequence of Recording or mapping
        What has happened already.
    is_whole : bool
        Whether that is all since the bare object; else since a painting that was painted whole.
    """

    def __init__(
        self,
        header: Mapping[str, Any],
        events: Sequence[Recording | Mapping[str, Any]] = (),
        *,
        is_whole: bool = True,
    ) -> None:
        self.is_whole = is_whole
        self._header = dict(header)
        self._inks = InkTable(dict(self._header.pop("pigments", {})))
        self._events: list[_Event] = [
            _SampleRun(e.samples()) if isinstance(e, Recording) else dict(e) for e in events
        ]
        self.is_suspended = False

    @classmethod
    def begin(cls, surface: PaintedSurface, painter: Painter) -> ScoreRecorder | None:
        """For a new painting; None where there is something already."""
        untouched = surface.n_vertices == surface.paint_mesh.n_base_vertices
        if not untouched or surface.painted.any() or painter.loaded != painter.in_brush():
            return None
        inks = InkTable({})
        header = make_header(surface, painter.brush, painter.dipped, inks)
        header["azimuth"] = painter.azimuth
        pickup = float(surface.ink.transfer["pickup"].item())
        own = {"pigments": inks.table} if inks.table else {}
        amount = {"do": "dip", "amount": painter.amount.words()}
        events = [amount] if painter.amount != DipAmount() else []
        return cls(header | own | ({"pickup": pickup} if pickup else {}), events)

    @classmethod
    def going_on(cls, saved: Session) -> ScoreRecorder | None:
        """For a painting from a session; None where its past is not known."""
        is_whole, n_strokes = saved.score is not None, len(saved.strokes)
        known = saved.score if is_whole else saved.later
        if known is not None:
            return cls._resumed(known, n_strokes, is_whole=is_whole)
        if not saved.recordings or saved.strokes or saved.history is not None:
            return None
        header = {name: saved.settings[name] for name in _OF_WHOLE if name in saved.settings}
        header["pickup"] = float(saved.surface.ink.transfer["pickup"].item())
        try:
            return cls(Score(header, ()).header, is_whole=False)
        except RecordingError:
            return None

    @classmethod
    def _resumed(cls, score: Score, n_strokes: int, *, is_whole: bool) -> ScoreRecorder:
        """For a painting of so many strokes: what no session holds begins anew."""
        recorder = cls(score.header, score.events, is_whole=is_whole)
        lines = [event for event in score.events if not isinstance(event, Recording)]
        names = {line["do"] for line in lines}
        recorder._events += [{"do": name} for name in ("set_symmetry", "set_mask") if name in names]
        if "set_tags" in names:
            recorder._events.append({"do": "set_tags", "tags": {}})
        history = [line for line in lines if undo_kinds().get(line["do"], "layers") != "layers"]
        went = history[-1] if history else {}
        if went.get("passing"):  # it was saved while somebody only looked at what was before
            recorder._events.append({"do": "replay_history", "upto": n_strokes})
        return recorder

    @contextmanager
    def suspended(self) -> Iterator[None]:
        """Record nothing meanwhile: it is part of the current command."""
        self.is_suspended = True
        try:
            yield
        finally:
            self.is_suspended = False

    def feed(self, samples: Sequence[DeviceSample]) -> None:
        """Record samples."""
        last = self._events[-1] if self._events else None
        if isinstance(last, _SampleRun):
            last.extend(samples)
        else:
            self._events.append(_SampleRun(samples))

    def command(self, name: str, arguments: Mapping[str, Any], surface: PaintedSurface) -> None:
        """Record a command.

        Raises
        ------
        RecordingError
            If a score cannot say it.
        """
        line = encode_line(name, arguments, Vocabulary(surface, self._inks))
        check_command(line)
        last = self._events[-1] if self._events else None
        if name == "follow_time" and isinstance(last, dict) and {**last, "times": 1} == {
            **line, "times": 1
        }:  # fmt: skip
            last["times"] = last.get("times", 1) + 1
            return
        again = isinstance(last, dict) and last["do"] == name and not last.get("refused")
        if name == "replay_history" and again:  # only the last position that was looked at matters
            self._events.pop()
        self._events.append(line)

    def record_refusal(
        self, name: str, arguments: Mapping[str, Any], surface: PaintedSurface
    ) -> None:
        """Record a refused command: it may have changed something before."""
        vocabulary = Vocabulary(surface, self._inks)
        try:
            line = {**encode_line(name, arguments, vocabulary), "refused": True}
            check_command(line)
        except Paint3DError:
            return
        self._events.append(line)

    def score(self, object_name: str) -> Score:
        """Score of everything recorded."""
        own = {"pigments": dict(self._inks.table)} if self._inks.table else {}
        events = [
            event.recording() if isinstance(event, _SampleRun) else dict(event)
            for event in self._events
        ]
        return Score({**self._header, "object": object_name, **own}, tuple(events))


# ---- Methods that are recorded -------------------------------------------------------------------


def recorded(
    method: Callable[Concatenate[_Document, _P], _Result],
) -> Callable[Concatenate[_Document, _P], _Result]:
    """Record calls of a method of `Document` in the document's `recorder`.

    Its command stands in `app.model.commands`. What a method asks of the document meanwhile belongs
    to it, and is not written down by itself.
    """
    command = COMMANDS[method.__name__]
    signature = inspect.signature(method)

    @wraps(method)
    def wrapper(document: _Document, /, *arguments: _P.args, **options: _P.kwargs) -> _Result:
        document.check_access()
        recorder = document.recorder
        if recorder is None or recorder.is_suspended:
            return method(document, *arguments, **options)

        def bound_arguments() -> dict[str, Any]:
            given = dict(signature.bind(document, *arguments, **options).arguments)
            given.pop("self")
            return given

        try:
            with recorder.suspended():
                done = method(document, *arguments, **options)
        except Paint3DError:
            if document.recorder is recorder:
                recorder.record_refusal(command.name, bound_arguments(), document.surface)
            raise
        if document.recorder is recorder:
            _record_done(document, command, bound_arguments(), done)
        return done

    return wrapper


def _record_done(
    document: _Recorded, command: Command, arguments: dict[str, Any], done: object
) -> None:
    """Record a finished command; a score that cannot encode it is dropped."""
    name = command.written_as or command.name
    if name == "begin_stroke":
        arguments["time_s"] = document.current_stroke.time_s
    if command.name == "pick_colour" and done is None:
        return
    if command.written_as:
        arguments = {"ink": document.painter.dipped}
    assert document.recorder is not None, "it has been asked"
    try:
        document.recorder.command(name, arguments, document.surface)
    except Paint3DError:
        document.recorder = None
