"""A whole painting as a recording (version 2): everything that happened, in order and in time.

JSON Lines: a header, then samples as in version 1, and between them what was asked for, one object
a line: ``{"do": "dip", "ink": {"pine soot": 0.2, "water": 0.8}}``. What a line may say is in
`data/score.schema.json`; `paint3d.app.model.score` plays it.
"""

from __future__ import annotations

import difflib
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import fastjsonschema
import numpy as np
from fastjsonschema import JsonSchemaValueException

from paint3d.device.recorded import Recording
from paint3d.errors import ExportError, RecordingError
from paint3d.recording.recording import (
    AT_REST,
    MAX_LINE,
    SampleRows,
    TextLines,
    decode_line,
    fraction_reporter,
    open_recording,
    sample_lines,
    save_lines,
)

__all__ = [
    "VERSION",
    "Event",
    "Score",
    "check_command",
    "check_header",
    "check_sample",
    "command_names",
    "is_score",
    "join_adjacent",
    "load_score",
    "read_score",
    "save_score",
    "schema",
    "undo_kinds",
    "write_score",
]

# ---- The schema ----------------------------------------------------------------------------------
# What a line of a recording of version 2 may say: its JSON Schema, and the check of a line.


_SCHEMA = Path(__file__).parent / "data" / "score.schema.json"
_DRAFT = "http://json-schema.org/draft-07/schema#"


@lru_cache(maxsize=1)
def schema() -> Mapping[str, Any]:
    """The schema of a line."""
    loaded: Mapping[str, Any] = json.loads(_SCHEMA.read_text(encoding="utf-8"))
    return loaded


@lru_cache(maxsize=1)
def command_names() -> tuple[str, ...]:
    """Names of the commands that a line can ask for."""
    definitions = schema()["$defs"]
    return tuple(name for name, rule in definitions.items() if "do" in rule.get("required", ()))


@lru_cache(maxsize=1)
def undo_kinds() -> Mapping[str, str]:
    """Effects of commands on the history of undo, by name: ``x-undo`` of the schema.

    "stroke" begins a step, "step" makes one, "layers" makes one and is refused while one looks at
    what was before, "history" goes back or forth; all but "layers" end such a look or begin one.
    """
    definitions = schema()["$defs"]
    undo = {name: definitions[name].get("x-undo") for name in command_names()}
    return {name: kind for name, kind in undo.items() if kind is not None}


def check_header(line: Mapping[str, Any]) -> None:
    """Refuse a line that is no header.

    Raises
    ------
    RecordingError
        What is what, and what was expected.
    """
    _check_line(line, "header")


def check_sample(line: Mapping[str, Any]) -> None:
    """Refuse a line that is no sample; see `check_header`."""
    _check_line(line, "sample")


def check_command(line: Mapping[str, Any]) -> None:
    """Refuse a line that is no command; see `check_header`."""
    name, known = line.get("do"), command_names()
    if name not in known:
        near = difflib.get_close_matches(str(name), known, n=1, cutoff=0.6)
        if near:
            raise RecordingError(
                "do is {name!r:.60}; did you mean {near!r}? expected one of {known}",
                name=name,
                near=near[0],
                known=", ".join(known),
            )
        raise RecordingError(
            "do is {name!r:.60}; expected one of {known}", name=name, known=", ".join(known)
        )
    _check_line(line, str(name))


def _check_line(line: Mapping[str, Any], kind: str) -> None:
    try:
        _validator(kind)(line)
        if kind != "sample":  # whose numbers have been read or measured, and are finite
            json.dumps(line, allow_nan=False)
    except JsonSchemaValueException as fault:
        where = ": ".join([kind, *filter(None, [" ".join(fault.path[1:])])])
        rule = fault.definition if isinstance(fault.definition, dict) else {}
        if fault.rule == "required":
            missing = next(key for key in rule["required"] if key not in fault.value)
            raise RecordingError(
                "{where} has no {missing!r}; expected one",
                where=where,
                missing=missing,
            ) from None
        if fault.rule == "additionalProperties":
            odd = next(key for key in fault.value if key not in rule["properties"])
            known = ", ".join(key for key in rule["properties"] if key not in ("do", "refused"))
            raise RecordingError(
                "{where} has {odd!r:.60}; expected {known}",
                where=where,
                odd=odd,
                known=known or "nothing else",
            ) from None
        raise RecordingError(
            "{where} is {value!r:.60}; expected {expected}",
            where=where,
            value=fault.value,
            expected=_in_words(rule),
        ) from None
    except ValueError:
        raise RecordingError(
            "{kind} has a number that is not finite; expected none", kind=kind
        ) from None


@lru_cache
def _validator(kind: str) -> Callable[[Mapping[str, Any]], object]:
    # Draft 7 means the same as the schema's own 2020-12 by all the words that are used here.
    rule = {"$schema": _DRAFT, "$defs": schema()["$defs"], "$ref": f"#/$defs/{kind}"}
    validate: Callable[[Mapping[str, Any]], object] = fastjsonschema.compile(
        rule, use_default=False
    )
    return validate


def _in_words(rule: Mapping[str, Any]) -> str:
    """Describe the values that a rule of the schema allows."""
    if "$ref" in rule:
        return _in_words(schema()["$defs"][rule["$ref"].rpartition("/")[2]])
    if "anyOf" in rule:
        return " or ".join(map(_in_words, rule["anyOf"]))
    if "enum" in rule:
        return " or ".join(map(repr, rule["enum"]))
    if "const" in rule:
        return repr(rule["const"])
    kind: str = rule.get("type", "none")
    words = {"integer": "a whole number", "number": "a number", "array": "a list",
             "string": "a text", "object": "an object", "boolean": "true or false"}  # fmt: skip
    for least, most, unit in (
        ("minimum", "maximum", ""),
        ("minItems", "maxItems", "entries"),
        ("minLength", "maxLength", "letters"),
    ):
        if least in rule or most in rule:
            low, high = rule.get(least, 0), rule.get(most, math.inf)
            span = f"{low:g}" if low == high else f"{low:g} to {high:g}"
            return f"{words[kind]} ({span} {unit}".rstrip() + ")"
    return words.get(kind, kind)


# ---- Scores --------------------------------------------------------------------------------------


VERSION = 2
Event = Recording | Mapping[str, Any]
"""Samples of one stroke, with nothing between them; or what was asked for, as its line says."""

_SUFFIXES = (".jsonl", ".json")
_ENDS = frozenset({"end_stroke", "cancel_stroke", "undo", "redo", "replay_history"})


@dataclass(frozen=True, eq=False)
class Score:
    """Commands and samples of a painting, from the bare object on.

    Attributes
    ----------
    header : mapping
        ``format``, ``version``, and what painting began with: ``object``, ``material``,
        ``resolution_mm``, ``brush``, ``ink``, ``azimuth``; ``pigments`` that are no palette's.
    events : tuple of Event
        In order.
    lines : tuple of int
        Where in its file each event begins; empty where there is no file.
    name : str
        Of the file, for messages.

    Raises
    ------
    RecordingError
        If the header or a command says what none may, or samples lie outside of a stroke.
    """

    header: Mapping[str, Any]
    events: tuple[Event, ...]
    lines: tuple[int, ...] = ()
    name: str = ""

    def __post_init__(self) -> None:
        filled = {"format": "paint3d-recording", "version": VERSION, **self.header}
        check_header(filled)
        object.__setattr__(self, "header", filled)
        object.__setattr__(self, "events", tuple(self.events))
        strokes = _Strokes()
        for k, event in enumerate(self.events):
            try:
                if not isinstance(event, Recording):
                    check_command(dict(event))
                strokes.follow(event)
            except RecordingError as cause:
                raise RecordingError("{where}: {cause}", where=self.where(k), cause=cause) from None

    def __len__(self) -> int:
        return len(self.events)

    @property
    def n_samples(self) -> int:
        """Samples of all strokes."""
        return sum(len(event) for event in self.events if isinstance(event, Recording))

    def where(self, event: int) -> str:
        """Position of an event in its file or in the score, for messages."""
        if event < len(self.lines):
            return f"{self.name}:{self.lines[event]}"
        return f"{self.name}: event {event + 1}" if self.name else f"event {event + 1}"

    def strokes(self) -> list[Recording]:
        """The strokes with all their samples, also those undone later."""
        parts_of_strokes: list[list[Recording]] = []
        for event in self.events:
            if isinstance(event, Recording):
                parts_of_strokes[-1].append(event)
            elif event["do"] == "begin_stroke":
                parts_of_strokes.append([])
        return [_join_parts(parts) for parts in parts_of_strokes if parts]


class _Strokes:
    """Check that samples come within strokes."""

    def __init__(self) -> None:
        self.is_open = False

    def follow(self, event: Event) -> None:
        if isinstance(event, Recording):
            if not self.is_open:
                raise RecordingError("samples lie outside of a stroke; expected begin_stroke first")
        elif event["do"] == "begin_stroke":
            if self.is_open and not event.get("refused"):
                raise RecordingError("begin_stroke comes during a stroke; expected its end first")
            self.is_open = not event.get("refused")
        elif event["do"] in _ENDS:
            self.is_open = False


def _join_parts(parts: list[Recording]) -> Recording:
    """Join the samples of one stroke that commands had parted."""
    if len(parts) == 1:
        return parts[0]
    nowhere = [np.full((len(part), 3), np.nan) for part in parts]
    contacts = [n if p.contact is None else p.contact for p, n in zip(parts, nowhere, strict=True)]
    with_pressure = parts[0].pressure is not None
    names = ("time_ns", "position", "orientation", "buttons", "object_position",
             "object_orientation")  # fmt: skip
    columns: dict[str, Any] = {n: np.concatenate([getattr(p, n) for p in parts]) for n in names}
    if with_pressure:
        columns |= {"pressure": np.concatenate([part.pressure for part in parts]),
                    "contact": np.concatenate(contacts)}  # fmt: skip
    return Recording(**columns)


def join_adjacent(events: Iterable[Event]) -> list[Event]:
    """Events with recordings that follow each other joined into one."""
    joined: list[Event] = []
    for event in events:
        last = joined[-1] if joined else None
        if isinstance(event, Recording) and isinstance(last, Recording):
            joined[-1] = _join_parts([last, event])
        else:
            joined.append(event)
    return joined


def is_score(path: str | os.PathLike[str]) -> bool:
    """Return whether a file is a recording of version 2; False for one that is read only once."""
    if not os.path.isfile(path):  # what is looked at in a pipe would be gone
        return False
    try:
        with open_recording(path) as (_, stream):
            header = decode_line(stream.readline(MAX_LINE + 1).decode("utf-8-sig"))
    except (UnicodeDecodeError, RecordingError):
        return False
    return header.get("version") == VERSION


def load_score(
    path: str | os.PathLike[str], progress: Callable[[float], None] | None = None
) -> Score:
    """Read a recording of version 2, gzipped or not.

    Parameters
    ----------
    path : path-like
    progress : callable, optional
        Called with the fraction of the file that is read, now and then; what it raises stops it.

    Raises
    ------
    RecordingError
        ``file:line: what is X; expected Y`` for the first thing that is wrong, and when the file
        cannot be read at all.
    """
    name = Path(path).name
    with open_recording(path) as (raw, stream):
        on_read = None if progress is None else fraction_reporter(raw, progress)
        return _read(TextLines(stream, name, on_read), name)


def read_score(text: str, name: str) -> Score:
    """Read a recording of version 2 from a text; `name` is what messages call it."""
    return _read(iter(enumerate(text.splitlines(), 1)), name)


def _read(lines: Iterator[tuple[int, str]], name: str) -> Score:
    numbered = ((number, text) for number, text in lines if text.strip())
    number, text = next(numbered, (1, ""))
    try:
        if not text:
            raise RecordingError("the file is empty; expected a header line")
        header = decode_line(text)
        check_header(header)
        reader = _Reader()
        for number, text in numbered:
            reader.add(number, decode_line(text))
    except RecordingError as cause:
        raise RecordingError(
            "{name}:{number}: {cause}", name=name, number=number, cause=cause
        ) from None
    events, line_numbers = reader.finish()
    return Score(header, events, line_numbers, name)


class _Reader:
    """Collect lines into events; every check is made while the line is known."""

    def __init__(self) -> None:
        self._events: list[Event] = []
        self._line_numbers: list[int] = []
        self._strokes = _Strokes()
        self._rows = SampleRows(1.0)
        self._began = 0
        self._last_ns: int | None = None

    def add(self, number: int, line: dict[str, Any]) -> None:
        if "do" not in line:
            self._add_sample(number, line)
            return
        check_command(line)
        self._flush_samples()
        self._strokes.follow(line)
        if line["do"] == "begin_stroke":
            self._last_ns = None
        self._events.append(line)
        self._line_numbers.append(number)

    def _add_sample(self, number: int, line: dict[str, Any]) -> None:
        if not self._strokes.is_open:
            raise RecordingError("a sample lies outside of a stroke; expected begin_stroke first")
        check_sample(line)
        if not self._rows.times:
            self._began = number
            if self._last_ns is not None and line["time_ns"] <= self._last_ns:
                raise RecordingError(
                    "time_ns is {time_ns}; expected more than {last_ns}, the sample before it",
                    time_ns=line["time_ns"],
                    last_ns=self._last_ns,
                )
        self._rows.add(line)
        self._last_ns = self._rows.times[-1]

    def _flush_samples(self) -> None:
        rows = self._rows
        if rows.times:
            self._events.append(rows.recording({}))
            self._line_numbers.append(self._began)
            position, turn = rows.object
            self._rows = SampleRows(1.0, [*position, *turn])

    def finish(self) -> tuple[tuple[Event, ...], tuple[int, ...]]:
        self._flush_samples()
        return tuple(self._events), tuple(self._line_numbers)


def write_score(score: Score) -> Iterator[str]:
    """The lines of a score, each ending in a newline; numbers read back exactly."""
    yield _format_line(score.header)
    object_pose = np.array(AT_REST)
    for event in score.events:
        if isinstance(event, Recording):
            yield from sample_lines(event, object_pose)
        else:
            yield _format_line(event)


def _format_line(words: Mapping[str, Any]) -> str:
    line = json.dumps(dict(words), ensure_ascii=False, separators=(", ", ": "), allow_nan=False)
    if len(line.encode()) >= MAX_LINE:
        raise ExportError(
            "a line of the recording would have {n:,} letters; expected {most:,}",
            n=len(line),
            most=MAX_LINE,
        )
    return line + "\n"


def save_score(
    score: Score,
    path: str | os.PathLike[str],
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write a score: .jsonl, also with .gz; the same score gives the same bytes.

    Parameters
    ----------
    score : Score
    path : path-like
    progress : callable, optional
        Called with 1 when all is written, before the file takes its place; what it raises leaves
        everything as it was.

    Raises
    ------
    ExportError
        If the suffix is another one, or the file cannot be written.
    """
    save_lines({suffix: partial(write_score, score) for suffix in _SUFFIXES}, path, progress)
