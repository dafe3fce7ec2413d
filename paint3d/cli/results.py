"""What a command painted: its account, and where it goes, a session or any other format."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from paint3d.cli.progress import ProgressBar
from paint3d.cli.versions import find_versions
from paint3d.core.atomic import write_atomically
from paint3d.files.readers.odd_names import json_text

if TYPE_CHECKING:
    from paint3d.painter.flat_input import LaidPad
    from paint3d.recording.recording import Recording
    from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Painting", "result_suffixes", "timed", "write_report", "write_result", "write_results"]


@dataclass(frozen=True)
class Painting:
    """A painted surface, what painting it took, what made it, and the seconds of each step."""

    surface: PaintedSurface
    counts: dict[str, Any]
    seconds: dict[str, float]
    recordings: tuple[Recording | LaidPad, ...] = ()
    settings: dict[str, Any] = field(default_factory=dict)

    def whole_recordings(self) -> tuple[Recording, ...]:
        """The recordings in the world; a pad's is laid down as a whole."""
        from paint3d.painter.flat_input import LaidPad

        return tuple(r.whole() if isinstance(r, LaidPad) else r for r in self.recordings)

    def describe(self) -> dict[str, Any]:
        """Everything that ``--report`` writes: versions, seconds by stage, counts, ink ledger."""
        return {
            "versions": find_versions(),
            **self.counts,
            "seconds_by_step": {step: round(spent, 4) for step, spent in self.seconds.items()},
        }

    def summarize(self) -> str:
        """One line on what was painted."""
        return (
            f"{self.counts['samples']:,} samples, {self.counts['footprints']:,} footprints, "
            f"{self.counts['vertices_painted']:,} vertices painted in "
            f"{self.seconds['paint']:.1f} s"
        )


@contextmanager
def timed(seconds: dict[str, float], step: str) -> Iterator[None]:
    """Add the seconds spent inside to ``seconds[step]``."""
    started = time.perf_counter()
    yield
    seconds[step] = seconds.get(step, 0.0) + time.perf_counter() - started


def result_suffixes() -> tuple[str, ...]:
    """Suffixes of files that `write_result` can write."""
    from paint3d.files.export import EXPORT_SUFFIXES

    return EXPORT_SUFFIXES


def write_result(painting: Painting, file: Path, *, quiet: bool = False) -> None:
    """Write a painting in the format that the file's suffix names, telling the progress.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    from paint3d.files.export import export
    from paint3d.files.project.session import Session, is_session_path, save_session

    with ProgressBar("writing", enabled=not quiet) as progress:
        if is_session_path(file):
            session = Session(painting.surface, painting.whole_recordings(), painting.settings)
            save_session(session, file, progress)
        else:
            export(painting.surface, file, progress=progress)


def write_results(painting: Painting, files: Iterable[Path], *, quiet: bool = False) -> None:
    """Write a painting in several formats; what is to be written is found out once.

    Raises
    ------
    ExportError
        If a file cannot be written.
    """
    from paint3d.files.export import PreparedExport, prepare_export
    from paint3d.files.export_options import ExportOptions
    from paint3d.files.progress import part_of
    from paint3d.files.project.session import is_session_path

    prepared: PreparedExport | None = None
    for file in files:
        if is_session_path(file):
            write_result(painting, file, quiet=quiet)
            continue
        with ProgressBar("writing", enabled=not quiet) as progress:
            if prepared is None:
                told = part_of(progress, 0.0, 0.6)
                prepared = prepare_export(painting.surface, file, ExportOptions(), told)
            prepared.into(file).write(part_of(progress, 0.6, 1.0))


def write_report(file: Path, painting: Painting) -> None:
    """Write the report as JSON, whole or not at all.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    text = json_text(painting.describe(), indent=2, allow_nan=False)
    with write_atomically(file) as part:
        part.write_text(text + "\n", encoding="utf-8")
