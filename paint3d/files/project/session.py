"""Sessions (.p3d): a painting in one file, with all that is needed to go on.

An archive (`array_archive`) with the object, the surface's state, the recordings it came from and
the settings. What each part holds, version by version, is in docs/sessions.md.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from paint3d.core.array_state import join_state, spans_of, split_state, starts_of
from paint3d.core.arrays import AnyArray
from paint3d.core.atomic import write_atomically
from paint3d.device.recorded import Recording, checked_header
from paint3d.errors import ExportError, Paint3DError, SessionError
from paint3d.files.progress import Progress, part_of
from paint3d.files.project.array_archive import read_archive, write_archive
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.recording.score import Score
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.state import restore_surface, surface_state

__all__ = [
    "SESSION_SUFFIX",
    "VERSION",
    "Session",
    "is_session_path",
    "load_session",
    "save_session",
]

FORMAT = "paint3d-session"
VERSION = 2
SESSION_SUFFIX = ".p3d"
MAX_RECORDINGS = 10_000
MESH = ("vertices", "faces", "colours", "normals")
SAMPLES = (
    "time_ns", "position", "orientation", "pressure", "buttons",
    "object_position", "object_orientation", "contact",
)  # fmt: skip
_OPTIONAL = {"pressure": (), "contact": (3,)}  # and the shape of one that does

Parts = tuple[dict[str, Any], dict[str, AnyArray]]
UPGRADES: dict[int, Callable[[Parts], Parts]] = {
    1: lambda parts: ({**parts[0], "strokes": []}, {**parts[1], **_pack_strokes(())}),
}
"""For each old version the step to the next one; `load_session` takes them in turn."""


@dataclass(frozen=True)
class Session:
    """A painting, and how it came about.

    Attributes
    ----------
    surface : PaintedSurface
    recordings : sequence of Recording
        What was painted, in order.
    settings : mapping
        Anything that JSON can hold: brush, ink, the command's options.
    strokes : sequence of Recording
        What was painted by hand, stroke by stroke, with what is known of each in its header;
        there may be very many.
    undone : sequence of Recording
        Strokes that were taken back and can be done again, the next one last.
    history : mapping or None
        How strokes are taken back and done again: words, numbers, arrays, and mappings of these
        (`app.model.persistence.saved_history`). What was read may come from a stranger and was not
        checked.
    score : Score or None
        All that happened from the bare object on, where that is known.
    later : Score or None
        What was done after the recordings were painted, where that is known instead; its header
        has the settings of then that say what they were painted with, and the brush's `pickup`.
    """

    surface: PaintedSurface
    recordings: Sequence[Recording] = ()
    settings: Mapping[str, object] = field(default_factory=dict)
    strokes: Sequence[Recording] = ()
    undone: Sequence[Recording] = ()
    history: Mapping[str, object] | None = None
    score: Score | None = None
    later: Score | None = None


def is_session_path(path: str | os.PathLike[str]) -> bool:
    """Return whether a file's name is that of a session."""
    return os.fspath(path).lower().endswith(SESSION_SUFFIX)


def save_session(
    session: Session, path: str | os.PathLike[str], progress: Progress | None = None
) -> None:
    """Save a session: after any failure the file is as it was.

    The same session gives the same bytes.

    Parameters
    ----------
    session : Session
    path : path-like
    progress : callable, optional
        Called with the fraction done, and with 1 before the file takes its place; what it raises
        leaves everything as it was.

    Raises
    ------
    ExportError
        If the file cannot be written, or a setting or header is nothing that JSON can hold.

    Examples
    --------
    >>> import paint3d
    >>> surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=1.0)
    >>> line = paint3d.Painter(surface).stroke([(-20, 0, 0), (20, 0, 0)])
    >>> paint3d.save_session(paint3d.Session(surface, [line]), "line.p3d")
    >>> int(paint3d.load_session("line.p3d").surface.painted.sum() - surface.painted.sum())
    0
    """
    path = Path(path)
    text, arrays = _make_parts(session)
    with write_atomically(path, progress) as temporary:
        try:
            write_archive(temporary, text, arrays, part_of(progress, 0.2, 0.95))
        except (TypeError, ValueError) as cause:
            raise ExportError(
                "{file}: settings cannot be saved: {cause}", file=path, cause=cause
            ) from None


def _make_parts(session: Session) -> Parts:
    mesh = session.surface.source
    arrays = {f"mesh/{name}": getattr(mesh, name) for name in MESH}
    state, own = split_state(surface_state(session.surface), "surface/")
    arrays |= own
    for k, recording in enumerate(session.recordings):
        arrays |= {f"recordings/{k}/{name}": getattr(recording, name) for name in SAMPLES}
    arrays |= _pack_strokes(session.strokes)
    more: dict[str, object] = {}
    if session.history is not None:
        more["history"], own = split_state(session.history, "history/")
        more["undone"] = [_distinct_words(recording.header) for recording in session.undone]
        arrays |= own | _pack_strokes(session.undone, "undone/")
    for name, score in (("score", session.score), ("later", session.later)):
        if score is None:
            continue
        samples = [event for event in score.events if isinstance(event, Recording)]
        lines = [None if isinstance(event, Recording) else dict(event) for event in score.events]
        more[name] = {"header": dict(score.header), "events": lines}
        arrays |= _pack_strokes(samples, f"{name}/")
    text = {
        "format": FORMAT,
        "version": VERSION,
        "object": mesh.name,
        "surface": state,
        "recordings": [dict(recording.header) for recording in session.recordings],
        "settings": dict(session.settings),
        "strokes": [_distinct_words(recording.header) for recording in session.strokes],
        **more,
    }
    return text, {name: array for name, array in arrays.items() if array is not None}


def _pack_strokes(strokes: Sequence[Recording], prefix: str = "strokes/") -> dict[str, AnyArray]:
    """All strokes in one column each: an archive has no room for an entry a stroke."""
    arrays = {f"{prefix}starts": starts_of([len(s) for s in strokes])}
    for name in SAMPLES if strokes else ():
        columns = [getattr(s, name) for s in strokes]
        if name in _OPTIONAL:
            columns = [
                np.full((len(s), *_OPTIONAL[name]), np.nan) if column is None else column
                for s, column in zip(strokes, columns, strict=True)
            ]
        arrays[f"{prefix}{name}"] = np.concatenate(columns)
    return arrays


def _distinct_words(header: Mapping[str, object]) -> dict[str, object]:
    """A header without the entries that are the same in every header."""
    common = checked_header({})
    return {k: v for k, v in header.items() if k not in common or v != common[k]}


def _unpack_strokes(
    headers: Sequence[Mapping[str, Any]], arrays: dict[str, AnyArray], prefix: str = "strokes/"
) -> tuple[Recording, ...]:
    n = len(arrays[f"{prefix}time_ns"]) if len(headers) else 0
    spans = spans_of(arrays[f"{prefix}starts"], n, least=1)
    if spans is None or len(spans) != len(headers):
        raise SessionError("its {n} strokes do not share out {n_2} samples", n=len(headers), n_2=n)
    strokes = []
    for own, header in zip(spans, headers, strict=True):
        given = [name for name in SAMPLES if f"{prefix}{name}" in arrays]
        columns: dict[str, Any] = {name: arrays[f"{prefix}{name}"][own] for name in given}
        if np.isnan(columns["pressure"]).all():
            columns["pressure"] = None
        strokes.append(Recording(**columns, header=dict(header)))
    return tuple(strokes)


def load_session(path: str | os.PathLike[str], progress: Progress | None = None) -> Session:
    """Open a session of this version or an older one; it may come from a stranger.

    Parameters
    ----------
    path : path-like
    progress : callable, optional
        Called with the fraction done, now and then; what it raises stops it.

    Raises
    ------
    SessionError
        ``file: what is wrong``: it is damaged, incomplete, or newer than this program.
    """
    path = Path(path)
    try:
        return _make_session(_upgrade(read_archive(path, part_of(progress, 0.0, 0.3))), progress)
    except SessionError as cause:
        raise SessionError("{file}: {cause}", file=path, cause=cause) from None
    except Paint3DError as cause:
        raise SessionError("{file}: it cannot be used: {cause}", file=path, cause=cause) from None
    except (KeyError, TypeError, AttributeError, ValueError) as cause:
        raise SessionError(
            "{file}: it is incomplete near {cause}", file=path, cause=cause
        ) from None
    except MemoryError:
        raise SessionError("{file}: it does not fit into memory", file=path) from None


def _upgrade(parts: Parts) -> Parts:
    text = parts[0]
    version = text.get("version")
    if text.get("format") != FORMAT or type(version) is not int or version < 1:
        raise SessionError(
            "it says it is {format!r:.40}; expected {expected!r}",
            format=text.get("format"),
            expected=FORMAT,
        )
    if version > VERSION:
        raise SessionError(
            "its version is {version}; this program knows up to {expected}",
            version=version,
            expected=VERSION,
        )
    for old in range(version, VERSION):
        parts = UPGRADES[old](parts)
    return parts


def _make_session(parts: Parts, progress: Progress | None = None) -> Session:
    text, arrays = parts
    mesh = TriangleMesh(
        arrays["mesh/vertices"],
        arrays["mesh/faces"],
        arrays.get("mesh/colours"),
        str(text["object"]),
        arrays.get("mesh/normals"),
    )
    headers, settings = text["recordings"], text["settings"]
    if len(headers) > MAX_RECORDINGS:
        raise SessionError(
            "it has {n:,} recordings; expected {most:,}",
            n=len(headers),
            most=MAX_RECORDINGS,
        )
    recordings = []
    for k, header in enumerate(headers):
        columns: dict[str, Any]
        columns = {name: arrays.get(f"recordings/{k}/{name}") for name in SAMPLES}
        recordings.append(Recording(**columns, header=dict(header)))
    state = join_state(text["surface"], arrays, "surface/")
    strokes, history = _unpack_strokes(text["strokes"], arrays), None
    undone: tuple[Recording, ...] = ()
    if isinstance(text.get("history"), Mapping):
        undone = _unpack_strokes(text["undone"], arrays, "undone/")
        history = join_state(text["history"], arrays, "history/")
    score, later = (
        _unpack_score(text[name], arrays, f"{name}/")
        if isinstance(text.get(name), Mapping)
        else None
        for name in ("score", "later")
    )
    surface = restore_surface(mesh, state, part_of(progress, 0.35, 0.9))
    return Session(
        surface, tuple(recordings), dict(settings), strokes, undone, history, score, later
    )


def _unpack_score(words: Mapping[str, Any], arrays: dict[str, AnyArray], prefix: str) -> Score:
    """The score: lines in order, and the samples between them."""
    lines = list(words["events"])
    samples = iter(_unpack_strokes([{}] * lines.count(None), arrays, prefix))
    events = [next(samples) if line is None else dict(line) for line in lines]
    return Score(dict(words["header"]), tuple(events))
