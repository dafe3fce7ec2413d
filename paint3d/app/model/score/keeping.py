"""Keeps a document's score: all that is asked of it, as it is asked."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import wraps
from typing import Any, TypeVar

from paint3d.app.model.score.words import Inks, header_of, line_of
from paint3d.app.model.stroke_log import recording_of
from paint3d.brush.spec import DipAmount
from paint3d.device.sample import DeviceSample
from paint3d.errors import Paint3DError
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score, check_command, command_names
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["ScoreKeeper", "keeps_score"]

_Document = TypeVar("_Document", bound=type)
_GOES = frozenset({"undo", "redo", "replay_history", "begin_stroke", "dry"})
_OTHERWISE = frozenset({"pick_colour", "swap_inks"})
"""Commands that are written down as the dip that they lead to."""


class _Fed(list[DeviceSample]):
    """Samples that came one after the other."""

    _recording: Recording | None = None

    def recording(self) -> Recording:
        """As a recording, which is made once: of wet ink there are thirty in a second."""
        if self._recording is None or len(self._recording) != len(self):
            self._recording = recording_of(self, {})
        return self._recording


_Kept = dict[str, Any] | _Fed


class ScoreKeeper:
    """Writes down what a document is asked for.

    Parameters
    ----------
    header : mapping
        Of the score: what painting began with.
    events : sequence of Recording or mapping
        What has happened already.
    """

    def __init__(
        self, header: Mapping[str, Any], events: Sequence[Recording | Mapping[str, Any]] = ()
    ) -> None:
        self._header = dict(header)
        self._inks = Inks(dict(self._header.pop("pigments", {})))
        self._events: list[_Kept] = [
            _Fed(e.samples()) if isinstance(e, Recording) else dict(e) for e in events
        ]
        self.is_within = False

    @classmethod
    def begin(cls, surface: PaintedSurface, painter: Painter) -> ScoreKeeper | None:
        """For a painting that begins; None where there is something already."""
        untouched = surface.n_vertices == surface.paint_mesh.n_base_vertices
        if not untouched or surface.painted.any() or painter.loaded != painter.in_brush():
            return None
        inks = Inks({})
        header = header_of(surface, painter.brush, painter.dipped, inks)
        header["azimuth"] = painter.azimuth
        pickup = float(surface.ink.transfer["pickup"].item())
        own = {"pigments": inks.table} if inks.table else {}
        amount = {"do": "dip", "amount": painter.amount.words()}
        events = [amount] if painter.amount != DipAmount() else []
        return cls(header | own | ({"pickup": pickup} if pickup else {}), events)

    @classmethod
    def resumed(cls, score: Score, n_strokes: int) -> ScoreKeeper:
        """For a painting of so many strokes that was saved: what no session holds begins anew."""
        keeper = cls(score.header, score.events)
        lines = [event for event in score.events if not isinstance(event, Recording)]
        asked = {line["do"] for line in lines}
        keeper._events += [{"do": name} for name in ("set_symmetry", "set_mask") if name in asked]
        if "set_tags" in asked:
            keeper._events.append({"do": "set_tags", "tags": {}})
        went = next((line for line in reversed(lines) if line["do"] in _GOES), {})
        if went.get("passing"):  # it was saved while somebody only looked at what was before
            keeper._events.append({"do": "replay_history", "upto": n_strokes})
        return keeper

    @contextmanager
    def within(self) -> Iterator[None]:
        """Write nothing down meanwhile: it belongs to what is being done."""
        self.is_within = True
        try:
            yield
        finally:
            self.is_within = False

    def feed(self, samples: Sequence[DeviceSample]) -> None:
        """Write samples down."""
        last = self._events[-1] if self._events else None
        if isinstance(last, _Fed):
            last.extend(samples)
        else:
            self._events.append(_Fed(samples))

    def command(self, name: str, asked: Mapping[str, Any], surface: PaintedSurface) -> None:
        """Write a command down.

        Raises
        ------
        RecordingError
            If a score cannot say it.
        """
        line = line_of(name, asked, surface, self._inks)
        check_command(line)
        last = self._events[-1] if self._events else None
        if name == "follow_time" and isinstance(last, dict) and {**last, "times": 1} == {
            **line, "times": 1
        }:  # fmt: skip
            last["times"] = last.get("times", 1) + 1
            return
        again = isinstance(last, dict) and last["do"] == name and not last.get("refused")
        if name == "replay_history" and again:  # only the last place that was looked at matters
            self._events.pop()
        self._events.append(line)

    def refused(self, name: str, asked: Mapping[str, Any], surface: PaintedSurface) -> None:
        """Write down what was refused: it may have changed something before it was."""
        try:
            line = {**line_of(name, asked, surface, self._inks), "refused": True}
            check_command(line)
        except Paint3DError:
            return
        self._events.append(line)

    def score(self, object_name: str) -> Score:
        """All of it."""
        own = {"pigments": dict(self._inks.table)} if self._inks.table else {}
        events = [
            event.recording() if isinstance(event, _Fed) else dict(event) for event in self._events
        ]
        return Score({**self._header, "object": object_name, **own}, tuple(events))


def keeps_score(kind: _Document) -> _Document:
    """Let a class of documents write down what is asked of it, in its `keeper` (None: nothing)."""
    for name in (*command_names(), *sorted(_OTHERWISE)):
        setattr(kind, name, _kept(name, getattr(kind, name)))
    kind.feed = _fed(kind.feed)  # type: ignore[attr-defined]
    kind.recall_strokes = _recalled(kind.recall_strokes)  # type: ignore[attr-defined]
    return kind


def _kept(name: str, method: Callable[..., Any]) -> Callable[..., Any]:
    signature = inspect.signature(method)

    @wraps(method)
    def kept(document: Any, *arguments: Any, **options: Any) -> Any:
        keeper = document.keeper
        if keeper is None or keeper.is_within:
            return method(document, *arguments, **options)
        try:
            with keeper.within():
                done = method(document, *arguments, **options)
        except Paint3DError:
            if document.keeper is keeper:
                asked = _asked(signature, document, arguments, options)
                keeper.refused(name, asked, document.surface)
            raise
        if document.keeper is keeper:
            _write(document, name, _asked(signature, document, arguments, options), done)
        return done

    return kept


def _asked(
    signature: inspect.Signature,
    document: Any,
    arguments: Sequence[Any],
    options: Mapping[str, Any],
) -> dict[str, Any]:
    asked = dict(signature.bind(document, *arguments, **options).arguments)
    asked.pop("self")
    return asked


def _write(document: Any, name: str, asked: dict[str, Any], done: Any) -> None:
    """Write down what was done; a score that cannot say it is a score no longer."""
    if name == "begin_stroke":
        asked["time_s"] = document.current_stroke.time_s
    if name == "pick_colour" and done is None:
        return
    if name in _OTHERWISE:
        name, asked = "dip", {"ink": document.painter.dipped}
    try:
        document.keeper.command(name, asked, document.surface)
    except Paint3DError:
        document.keeper = None


def _fed(feed: Callable[..., None]) -> Callable[..., None]:
    @wraps(feed)
    def kept(document: Any, samples: Sequence[DeviceSample]) -> None:
        is_painted = document.in_stroke and samples
        feed(document, samples)
        keeper = document.keeper
        if keeper is not None and is_painted and not keeper.is_within:
            keeper.feed(samples)

    return kept


def _recalled(recall: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(recall)
    def kept(document: Any) -> Any:
        repeats = document.oldest_stroke > 0
        done = recall(document)
        if repeats:  # what is painted again then is not what was
            document.keeper = None
        return done

    return kept
