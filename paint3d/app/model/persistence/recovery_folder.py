"""Crash recovery: a base to start from, and a journal of all since, written while painting.

A recovery folder belongs to one painting. ``base-K.p3d`` is the painting at a moment,
``journal-K.p3dj`` all samples and commands since, in order; doing them again on the base gives the
same painting to the bit. Saving a new base starts a new journal first, so at every moment some base
and the journals after it hold everything. A lock that dies with the program shows whether its
painting is still open. Folder and files are the user's alone.
"""

from __future__ import annotations

import json
import os
import shutil
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

from paint3d.app.model.commands import COMMANDS, encode_command, replay_command
from paint3d.app.model.document import Document, FileState
from paint3d.core.machine import is_locked, lock
from paint3d.core.own_folders import make_private, make_private_folder, recovery_folder
from paint3d.device.recorded import Recording
from paint3d.device.sample import DeviceSample
from paint3d.errors import ExportError, Message, Paint3DError, SessionError
from paint3d.files.project.journal import SAMPLE, Journal, Loss, read_events

__all__ = [
    "Recovered",
    "RecoveryFolder",
    "Unfinished",
    "is_open_elsewhere",
    "recoverable",
    "refusal",
]

_ABOUT, _LOCK = "about.json", "lock"
_BEGINS_S = 3600.0
"""Within which a studio has surely locked its folder and written what it is about."""
_OPENED = 0.2  # of recovering is opening the base
_AT_ONCE = 256  # samples between two reports of progress

_REFUSED = "refused"  # of a note in a journal
_HELD: dict[Path, tuple[int, BinaryIO | None]] = {}
"""Recovery folders that this program brings back or deletes now: how often, and their locks. One
that was stopped may go on beside the window for a while."""
_held_lock = threading.Lock()
_Event = Recording | dict[str, object]
_Piece = list[DeviceSample] | Mapping[str, object]  # of a journal


class RecoveryFolder:
    """Recovery data of one document; see `paint3d.app.model.paint_thread`.

    Parameters
    ----------
    document : Document
    folder : Path, optional
        Where recovery folders lie; by default `recovery_folder`.

    Raises
    ------
    ExportError
        If nothing can be written there.
    """

    def __init__(self, document: Document, folder: Path | None = None) -> None:
        root = recovery_folder() if folder is None else folder
        self.folder = root / f"{os.getpid()}-{time.time_ns()}"
        self._number = self._opening_bytes = 0  # of the journal, with nothing done yet
        self._journal: Journal | None = None
        self._next: Journal | None = None
        self._before: Journal | None = None  # which ends by itself
        self._in_file = document.steps.newest
        try:
            make_private_folder(self.folder)
            make_private(root)  # an older version may have let others look
            self._lock = open(self.folder / _LOCK, "wb")  # noqa: SIM115 - for as long as it lives
            make_private(self.folder / _LOCK)
            lock(self._lock)
        except OSError as cause:
            raise _keeping_error(root, cause) from None
        try:
            self.rotate_journal(document)
            self._describe(document, modified=False)  # without a base nothing could come back
            self.save_base(document)
        except OSError as cause:
            self.close()
            raise _keeping_error(root, cause) from None
        except BaseException:
            self.close()
            raise

    @property
    def number(self) -> int:
        """Number of the current journal."""
        return self._number

    def append(self, samples: Iterable[DeviceSample]) -> None:
        """Append samples; see `Journal.append`."""
        self._open_journal().append(samples)

    def note(self, command: Mapping[str, object]) -> None:
        """Append a command; see `Journal.note`."""
        self._open_journal().note(command)

    @contextmanager
    def together(self) -> Iterator[None]:
        """Write what is appended meanwhile at once, at the end; see `Journal.together`.

        The journal must not be rotated within.
        """
        with self._open_journal().together():
            yield

    def _open_journal(self) -> Journal:
        assert self._journal is not None, "a journal is open from the start"
        return self._journal

    def rotate_journal(self, document: Document) -> None:
        """Start the next journal; `save_base` is to follow.

        All that was written down must have been painted.

        Raises
        ------
        ExportError
            If it cannot be started; the old one goes on.
        """
        self._prepare_next_journal()
        fresh = self._next
        assert fresh is not None, "it was laid out"
        fresh.note(encode_command(document, "set_symmetry", [document.symmetry], {}))
        fresh.note(encode_command(document, "set_mask", [document.mask], {}))
        fresh.note(encode_command(document, "set_tags", [], document.tags))
        self._opening_bytes = _bytes_of(fresh.path)
        old, self._journal, self._next = self._journal, fresh, None
        self._number += 1
        if old is not None:
            old.close_in_background()
            self._before = old

    def save_base(self, document: Document) -> None:
        """Save the painting as it was when the journal began; older files can go.

        Raises
        ------
        ExportError
            If it cannot be saved; the older base and all journals stay.
        """
        base = self.folder / f"base-{self._number}.p3d"
        document.save_copy(base)
        make_private(base)
        with suppress(ExportError):  # rotating the journal will report it
            self._prepare_next_journal()
        with suppress(OSError):
            self._describe(
                document,
                document.modified
                or (bool(document.steps.undone) and document.steps.newest > self._in_file),
            )
        for old in _find_numbered(self.folder, "base-") | _find_numbered(self.folder, "journal-"):
            if old[0] < self._number:
                with suppress(OSError):
                    old[1].unlink()

    def _prepare_next_journal(self) -> None:
        """Create the next journal ahead, so that rotating waits for no disk."""
        if self._next is None:
            self._next = Journal(self.folder / f"journal-{self._number + 1}.p3dj", {})
            make_private(self._next.path)

    def _describe(self, document: Document, modified: bool) -> None:
        ready = 0 if self._next is None else _bytes_of(self._next.path)
        self._about = {
            "object": document.surface.source.name,
            "path": _path_of(document),
            "file": document.file_state,
            "time_s": time.time(),
            "modified": modified,
            "opening_bytes": self._opening_bytes + ready,
        }
        self._write_about()

    def name_file(self, document: Document) -> None:
        """Note which file the painting belongs to now; nothing else changes."""
        self._in_file = document.steps.newest
        self._about |= {"path": _path_of(document), "file": document.file_state}
        with suppress(OSError):  # the next base will say it
            self._write_about()

    def _write_about(self) -> None:
        temporary = self.folder / f".{_ABOUT}"
        temporary.write_text(json.dumps(self._about), encoding="utf-8")
        make_private(temporary)
        os.replace(temporary, self.folder / _ABOUT)

    def close(self, keep: bool = False) -> None:
        """End it: nothing is left to recover, unless `keep` is given."""
        for journal in (self._before, self._journal, self._next):
            if journal is not None:
                with suppress(ExportError):
                    journal.close()
        self._before = self._journal = self._next = None
        if not keep:
            shutil.rmtree(self.folder, ignore_errors=True)
        self._lock.close()


@dataclass(frozen=True, eq=False)
class Recovered:
    """A painting that was recovered.

    Attributes
    ----------
    document : Document
    loss : Loss
        What of the journals could not be read; all that came after it counts, too.
    refused : tuple of Message
        Why something could not be done again that could be done when it was asked for first.
    """

    document: Document
    loss: Loss
    refused: tuple[Message, ...]

    @property
    def n_lost(self) -> int:
        """Number of samples that would fit into what could not be read."""
        return -(-self.loss.n_bytes // SAMPLE.itemsize)


@dataclass(frozen=True)
class Unfinished:
    """A recovery folder whose studio ended without closing it.

    Attributes
    ----------
    folder : Path
    object_name : str
    path : Path or None
        The session's file, if it had one.
    time_s : float
        When something was written last, s since 1970.
    file : FileState or None
        What the session's file was when it was seen last; None: not known.
    """

    folder: Path
    object_name: str
    path: Path | None
    time_s: float
    file: FileState | None = None

    def recover(self, progress: Callable[[float], None] | None = None) -> Recovered:
        """Open the last base and do again what came after it.

        Parameters
        ----------
        progress : callable, optional
            Called with the fraction of the work that is done, 0 to 1, several times a second. What
            it raises (CancelledError, say) ends the work; the folder stays as it was.

        Raises
        ------
        SessionError
            If there is no base that can be opened, or another program has taken it up by now.
        """
        with self.held():
            report = progress or (lambda fraction: None)
            report(0.0)
            bases = sorted(_find_numbered(self.folder, "base-"), reverse=True)
            if not bases:
                raise SessionError(
                    "{folder}: it holds no painting; expected base-K.p3d",
                    folder=self.folder,
                )
            first, base = bases[0]
            document = Document.open(base)
            journals = sorted(_find_numbered(self.folder, "journal-"))
            events, loss = _read_journals([path for number, path in journals if number >= first])
            known = Counter(
                Message(str(e[_REFUSED])) for e in events if isinstance(e, dict) and _REFUSED in e
            )
            events = [e for e in events if not (isinstance(e, dict) and _REFUSED in e)]
            pieces = [piece for event in events for piece in _split_event(event)]
            report(_OPENED)
            costs = [_replay_cost(piece) for piece in pieces]
            done, whole = 0.0, sum(costs)
            refused: list[Message] = []
            for piece, cost in zip(pieces, costs, strict=True):
                refused += _replay_piece(document, piece)
                done += cost
                report(_OPENED + (1.0 - _OPENED) * done / whole)
            document.end_stroke()
            document.set_file(self.path, self.file)
            document.mark_modified()
            unknown = Counter(refused) - known
            return Recovered(document, loss, tuple(unknown.elements()))

    @contextmanager
    def held(self) -> Iterator[None]:
        """Lock the folder meanwhile: other programs take its studio for a running one.

        Raises
        ------
        SessionError
            If another program has taken it up by now.
        """
        with _held_lock:
            count, file = _HELD.get(self.folder, (0, None))
            _HELD[self.folder] = count + 1, file if count else self._take_lock()
        try:
            yield
        finally:
            with _held_lock:
                count, file = _HELD.pop(self.folder)
                if count > 1:
                    _HELD[self.folder] = count - 1, file
                elif file is not None:
                    file.close()

    def _take_lock(self) -> BinaryIO | None:
        """The lock, held; None where nothing can be written, so that nobody can delete it."""
        name = self.object_name if self.path is None else self.path.name
        taken = Message(
            "{name}: another window has opened it already; choose another painting to recover",
            name=name,
        )
        if not self.folder.is_dir():
            raise SessionError(taken)
        try:
            file = open(self.folder / _LOCK, "ab")  # noqa: SIM115 - as long as it is held
        except OSError:
            return None
        try:
            lock(file)
        except OSError:
            file.close()
            raise SessionError(taken) from None
        return file

    def discard(self) -> None:
        """Delete it for good, unless another program has locked it by now."""
        with suppress(SessionError), self.held():
            shutil.rmtree(self.folder, ignore_errors=True)


def recoverable(folder: Path | None = None) -> list[Unfinished]:
    """Recovery folders that ended without being closed, the newest first.

    Those that go on are left out; those in which nothing was done are deleted, and those that
    ended long ago while they began.
    """
    root = recovery_folder() if folder is None else folder
    unfinished = []
    with suppress(OSError):
        for own in sorted(root.iterdir()):
            has_begun = (own / _ABOUT).is_file()  # asked first: one that begins now locks first
            if is_locked(own / _LOCK) and own not in _HELD:  # somebody else goes on with it
                continue
            if has_begun:
                unfinished += _find_unfinished(own)
            elif _holds_nothing(own):
                shutil.rmtree(own, ignore_errors=True)
    return sorted(unfinished, key=lambda one: one.time_s, reverse=True)


def is_open_elsewhere(path: Path, own: Path | None, folder: Path | None = None) -> bool:
    """Return whether another running studio has this session's file open.

    Parameters
    ----------
    path : Path
    own : Path or None
        The recovery folder of one's own painting.
    folder : Path, optional
        Where recovery folders lie; by default `recovery_folder`.
    """
    root = recovery_folder() if folder is None else folder
    there = str(path.resolve())
    with suppress(OSError):
        for other in root.iterdir():
            if other != own and other not in _HELD and is_locked(other / _LOCK):
                with suppress(OSError, ValueError, AttributeError):
                    about = json.loads((other / _ABOUT).read_text(encoding="utf-8"))
                    if about.get("path") == there:
                        return True
    return False


def refusal(error: Paint3DError) -> dict[str, object]:
    """Note for a journal that something could not be done."""
    return {_REFUSED: error.message}


def _keeping_error(root: Path, cause: OSError) -> ExportError:
    return ExportError("{root}: cannot keep what is painted here: {cause}", root=root, cause=cause)


def _read_journals(journals: Sequence[Path]) -> tuple[list[_Event], Loss]:
    """Events in order, up to the first damage, and the loss from there on."""
    events: list[_Event] = []
    for k, journal in enumerate(journals):
        later = sum(_bytes_of(path) for path in journals[k + 1 :])
        try:
            _, more, loss = read_events(journal)
        except SessionError as error:  # nothing in it can be read
            return events, Loss(_bytes_of(journal) + later, 0, error.message)
        events += more
        if loss.n_bytes:
            return events, replace(loss, n_bytes=loss.n_bytes + later)
    return events, Loss()


def _bytes_of(path: Path) -> int:
    with suppress(OSError):
        return path.stat().st_size
    return 0


def _path_of(document: Document) -> str | None:
    return None if document.path is None else str(document.path.resolve())


def _find_unfinished(folder: Path) -> list[Unfinished]:
    try:
        about = json.loads((folder / _ABOUT).read_text(encoding="utf-8"))
        n_bytes = sum(path.stat().st_size for _, path in _find_numbered(folder, "journal-"))
        if not about.get("modified", True) and n_bytes <= about.get("opening_bytes", 0):
            shutil.rmtree(folder, ignore_errors=True)
            return []
        path = None if about["path"] is None else Path(about["path"])
        written = max(file.stat().st_mtime for file in folder.iterdir())
        known = about.get("file")
        file = None if known is None else (int(known[0]), int(known[1]), int(known[2]))
        return [Unfinished(folder, str(about["object"]), path, written, file)]
    except (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError):
        return []


def _holds_nothing(folder: Path) -> bool:
    """Return whether its studio ended before it described the folder: it holds no painting."""
    process, _, began = folder.name.partition("-")
    with suppress(OSError):
        is_old = time.time() - folder.stat().st_mtime > _BEGINS_S
        return (
            process.isdigit() and began.isdigit() and is_old and not _find_numbered(folder, "base-")
        )
    return False


def _find_numbered(folder: Path, prefix: str) -> set[tuple[int, Path]]:
    """The files PREFIX-K.* with their K."""
    numbered = set()
    for file in folder.glob(f"{prefix}*"):
        digits = file.name.removeprefix(prefix).split(".")[0]
        if digits.isdigit():
            numbered.add((int(digits), file))
    return numbered


def _split_event(event: Recording | Mapping[str, object]) -> list[_Piece]:
    """Split samples into pieces that take well below a second; a command stays whole."""
    if not isinstance(event, Recording):
        return [event]
    samples = list(event.samples())
    return [samples[k : k + _AT_ONCE] for k in range(0, len(samples), _AT_ONCE)]


def _replay_cost(piece: _Piece) -> float:
    """Rough cost of replaying a piece, in samples."""
    if isinstance(piece, list):
        return float(len(piece))
    command = COMMANDS.get(str(piece.get("do")))
    return 1.0 if command is None else command.cost


def _replay_piece(document: Document, piece: _Piece) -> list[Message]:
    """Replay a piece; return the message of its refusal, if it is refused again."""
    try:
        if isinstance(piece, list):
            document.feed(piece)
        else:
            replay_command(document, piece)
    except Paint3DError as error:
        return [error.message]
    return []
