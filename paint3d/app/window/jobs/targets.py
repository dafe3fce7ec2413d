"""Where something is to be written: asked under the painting's name, where was written last."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from paint3d.app.window.dialogs.target_dialog import Kind, ask_target
from paint3d.app.window.named import named
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace

__all__ = ["Targets"]


class Targets:
    """For one window.

    Attributes
    ----------
    folder : Path or None
        Where was written last.
    """

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self.folder: Path | None = None

    def ask(self, title: str, names: Mapping[str, str], preferred: str = "") -> Path | None:
        """Ask where to write; None if nowhere.

        Parameters
        ----------
        title : str
        names : mapping
            What a format is called, by its suffix.
        preferred : str
            The suffix that is chosen at first.
        """
        document = self._workspace.document
        stem = document.path.stem if document.path else named(document.surface.source.name)
        beside = document.path.parent if document.path else Path.cwd()
        suffix = preferred if preferred in names else next(iter(names))
        start = (self.folder or beside) / f"{stem}{suffix}"
        kinds = [Kind(say(name), suffix) for suffix, name in names.items()]
        path = ask_target(self._workspace.window, title.rstrip("…"), start, kinds, suffix)
        if path is not None:
            self.folder = path.parent
        return path
