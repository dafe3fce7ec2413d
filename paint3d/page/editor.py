"""Notebook widget in which a painting is continued.

It shows the page of one file (`single_file`) in a frame, which sends the lines of a score as
somebody paints.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import traitlets
from anywidget import AnyWidget

from paint3d.app.model.document import Document
from paint3d.app.model.score.playing import painted
from paint3d.app.model.stroke_log import recording_of
from paint3d.errors import InputError
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score, read_score, write_score
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Editor"]

_NAME = "the painting"


class Editor(AnyWidget):
    """A painting in a cell of Jupyter or marimo, painted on by pen, mouse or finger; see `edit`.

    Attributes
    ----------
    strokes : int
        Strokes that were begun, also those that were undone; it can be observed.
    """

    _esm = Path(__file__).with_name("editor.js").read_text("utf-8")
    _page = traitlets.Unicode().tag(sync=True)
    _height = traitlets.Int().tag(sync=True)
    strokes = traitlets.Int().tag(sync=True)

    def __init__(self, surface: PaintedSurface, score: Score, page: str, height: int) -> None:
        self._mesh = surface.source
        self._text = "".join(write_score(score))
        self._view = ""  # id of the view that continues it; a notebook may show several
        self._painted: tuple[str, Document] | None = None
        n_strokes = self._text.count('"begin_stroke"')
        super().__init__(_page=page, _height=height, strokes=n_strokes)
        self.on_msg(self._receive)

    def _receive(self, _: object, message: Mapping[str, str], __: object) -> None:
        """Handle a message of the page: a whole score, or lines that were added to it."""
        kind, text, view = message["paint3d"], message["text"], message["view"]
        if kind == "read":
            self._view = view
            self.send({"paint3d": "kept", "text": self._text, "view": view})
        elif view == self._view:
            self._text = text if kind == "begin" else self._text + text
            self.send({"paint3d": "heard", "strokes": self._text.count('"begin_stroke"')})

    @property
    def score(self) -> Score:
        """Score of the painting, from the bare object on."""
        return read_score(self._text, _NAME)

    @property
    def surface(self) -> PaintedSurface:
        """The painting as the page shows it, to the byte; repainted if it has been continued."""
        return self._document().surface

    @property
    def recording(self) -> Recording:
        """The samples of all strokes that were not undone, one stroke after another.

        Raises
        ------
        InputError
            If nothing is painted.
        """
        strokes = self._document().strokes
        if not strokes:
            raise InputError("nothing is painted yet; expected a stroke")
        return recording_of([sample for stroke in strokes for sample in stroke.samples], {})

    def save(self, path: str | os.PathLike[str]) -> None:
        """Save the painting as a session (.p3d), with its steps.

        Raises
        ------
        ExportError
            If the path has another suffix, or the file cannot be written.
        """
        self._document().save(path)

    def _document(self) -> Document:
        text = self._text  # messages may add to it meanwhile
        if self._painted is None or self._painted[0] != text:
            self._painted = text, painted(read_score(text, _NAME), self._mesh)
        return self._painted[1]
