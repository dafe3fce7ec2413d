"""Going back in the history of strokes, also where these have to be painted again first."""

from __future__ import annotations

from collections.abc import Callable

from paint3d.app.window.job import Progress
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace

__all__ = ["Recalling"]


class Recalling:
    """For one window.

    Parameters
    ----------
    workspace : Workspace
    refused : callable
        Told when it was stopped, or failed.
    """

    def __init__(self, workspace: Workspace, refused: Callable[[], None]) -> None:
        self._workspace, self._refused = workspace, refused

    def go_to(self, upto: int, passing: bool = False) -> None:
        """Show the painting as it was after so many strokes.

        Parameters
        ----------
        upto : int
        passing : bool
            Only to look at; see `Document.replay_history`.
        """
        workspace = self._workspace
        easel, document = workspace.easel, workspace.document
        if upto >= document.oldest_stroke or upto < document.earliest_stroke:
            workspace.post("replay_history", upto, passing)
            return

        def work(progress: Progress) -> None:
            document.progress = progress
            try:
                easel.post("replay_history", upto, passing).result()
            finally:
                document.progress = None

        count = document.oldest_stroke
        title = say("Painting {n} strokes again, to go back to them…", n=count)
        if workspace.went_well(workspace.run(title, work)):
            workspace.tell(
                say("{n} strokes were painted again; drying between them is not repeated", n=count)
            )
        else:
            self._refused()

    def undo(self) -> None:
        """Take the last step back; where no step does, the strokes are painted again first."""
        document, easel = self._workspace.document, self._workspace.easel
        if easel.is_behind or document.steps.done or not document.can_undo:
            self._workspace.post("undo")
        else:
            self.go_to(len(document.strokes) - 1)
