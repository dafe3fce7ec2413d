"""Going back in the history of strokes, also where these have to be painted again first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from paint3d.app.window.jobs.job import Progress, run_beside
from paint3d.app.window.wording import say

if TYPE_CHECKING:
    from paint3d.app.window.studio import StudioWindow

__all__ = ["Recalling"]


class Recalling:
    """For one window."""

    def __init__(self, window: StudioWindow) -> None:
        self._window = window

    def go_to(self, upto: int, passing: bool = False) -> None:
        """Show the painting as it was after so many strokes.

        Parameters
        ----------
        upto : int
        passing : bool
            Only to look at; see `Document.replay_history`.
        """
        window = self._window
        easel, document = window.stage.easel, window.document
        if upto >= document.oldest_stroke or upto < document.earliest_stroke:
            window.post("replay_history", upto, passing)
            return

        def work(progress: Progress) -> None:
            document.progress = progress
            try:
                easel.post("replay_history", upto, passing).result()
            finally:
                document.progress = None

        count = document.oldest_stroke
        title = say("Painting {n} strokes again, to go back to them…", n=count)
        if window.files.went_well(run_beside(window, title, work)):
            window.tell(
                say("{n} strokes were painted again; drying between them is not repeated", n=count)
            )
        else:
            window.panels.history.refuse()

    def undo(self) -> None:
        """Take the last step back; where no step does, the strokes are painted again first."""
        document = self._window.document
        if document.steps.done or not document.can_undo:
            self._window.post("undo")
        else:
            self.go_to(len(document.strokes) - 1)
