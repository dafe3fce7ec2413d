"""Where a command's painting goes: a session with all that made it, or any other format."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.progress import ProgressBar

if TYPE_CHECKING:
    from paint3d.cli.painting import Painting

__all__ = ["result_suffixes", "write_result"]


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
