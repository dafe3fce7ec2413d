"""Where something is to be written: asked under the painting's name, where was written last."""

from __future__ import annotations

import os
from collections.abc import Mapping
from itertools import count
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

        A painting without a file of its own is proposed under a name that is free.

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
        if document.path is None:
            start = _free(start, suffix)
        kinds = [Kind(say(name), suffix) for suffix, name in names.items()]
        path = ask_target(self._workspace.window, title.rstrip("…"), start, kinds, suffix)
        if path is not None:
            self.folder = path.parent
        return path


def _free(path: Path, suffix: str) -> Path:
    """That path, or the first with a number behind its name that no file has."""
    names = (f"{path.name.removesuffix(suffix)} {k}{suffix}" for k in count(2))
    paths = (path.with_name(name) for name in names)
    return path if not os.path.lexists(path) else next(p for p in paths if not os.path.lexists(p))
