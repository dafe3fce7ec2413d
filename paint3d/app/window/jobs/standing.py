"""Objects of one's own: how they stand when they are opened, and turning them afterwards."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from paint3d.app.model.document import Document
from paint3d.app.model.own_object import ObjectChoice, first_choice, is_implausible, longest_side
from paint3d.app.window.dialogs.object_dialog import ObjectDialog, told
from paint3d.app.window.dialogs.questions import Answer, ask
from paint3d.app.window.jobs.job import Progress
from paint3d.app.window.jobs.opened import Opened, open_with_progress
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.colour.materials import Material
from paint3d.files.load import BUILT_IN_OBJECTS
from paint3d.files.reading import Reading
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["Standing"]

_TURNED = (
    "There is paint on it. Turned, it is begun anew without the paint; what is open can be saved "
    "first."
)


def _is_bare(document: Document) -> bool:
    return not document.strokes and not document.surface.painted.any()


class Standing:
    """Asks how objects are to stand, for one window.

    Parameters
    ----------
    workspace : Workspace
    may_leave : callable
        Asks what becomes of the painting that is open.
    """

    def __init__(self, workspace: Workspace, may_leave: Callable[[], bool]) -> None:
        self._workspace, self._may_leave = workspace, may_leave
        self._said = ""

    def choose(
        self, path: str, reading: Reading, material: str, resolution: float, *, ask: bool = True
    ) -> ObjectChoice | None:
        """How an object that was read is to stand; None: it is not to be opened.

        Parameters
        ----------
        path : str
        reading : Reading
        material : str
            What is proposed for the surface.
        resolution : float
            What is wanted, mm.
        ask : bool
            Whether it is asked. If not, what is likely is taken and told, and it is asked only
            where the unit cannot be right.
        """
        self._said = ""
        if path in BUILT_IN_OBJECTS:
            return ObjectChoice(np.eye(3), 1.0, material, resolution)
        if not ask and not is_implausible(longest_side(reading.mesh)):
            return self._likely(reading, material, resolution)
        name = Path(path).name
        dialog = ObjectDialog(
            self._workspace.window,
            reading,
            material,
            resolution,
            title=name,
            accept=say("action.open").rstrip("…"),
        )
        return self._answer(dialog)

    def tell(self) -> None:
        """Say what was taken without having been asked."""
        if self._said:
            self._workspace.tell(self._said)

    def _likely(self, reading: Reading, material: str, resolution: float) -> ObjectChoice:
        guess = reading.likely_up
        said = [told(note) for note in reading.notes]
        if guess is not None and not guess.sure:
            said.append(
                say("Which way is up is not sure; Edit ▸ Turn and scale the object changes it")
            )
        elif guess is not None and guess.up != "z":
            words = "{axis} was taken for up; Edit ▸ Turn and scale the object changes it"
            said.append(say(words, axis=guess.up))
        self._said = "   ".join(said)
        return first_choice(reading, guess, material, resolution)._replace(resolution=resolution)

    def _answer(self, dialog: ObjectDialog) -> ObjectChoice | None:
        accepted = dialog.exec()
        choice = dialog.chosen() if accepted else None
        if choice is not None:
            self._keep(choice.material)
        dialog.deleteLater()
        return choice

    def _keep(self, material: str | Material) -> None:
        """Begin with this material the next time, if it has a name by which it is found."""
        if isinstance(material, str):
            self._workspace.keep(material=material)

    # -- turning what is open ---------------------------------------------------------------

    def do_stand(self) -> None:
        """Ask how the object that is open should stand, and begin anew on it."""
        workspace = self._workspace
        if workspace.stage.easel is None:
            return
        with workspace.easel.paused() as document:
            assert document is not None, "it was waited for"
            surface, material = document.surface, document.surface.material
            resolution = surface.resolution or workspace.settings.resolution_mm
            is_bare = _is_bare(document)
        if not is_bare and not self._may_begin_anew():
            return
        reading = Reading(surface.source, knows_up=True)
        dialog = ObjectDialog(
            workspace.window, reading, material, resolution,
            title=say("Turn and scale the object…").rstrip("…"),
            accept=say("button.ok") if is_bare else say("Begin anew"), is_open=True,
        )  # fmt: skip
        choice = self._answer(dialog)
        if choice is not None and (is_bare or self._may_leave()):
            self._begin_anew(surface.source, choice)

    def take_material(self, material: str | Material) -> bool:
        """Let the object that is open be of another material, and begin anew on it; say whether."""
        workspace = self._workspace
        if workspace.stage.easel is None:
            return False
        with workspace.easel.paused() as document:
            assert document is not None, "it was waited for"
            surface, is_bare = document.surface, _is_bare(document)
            resolution = surface.resolution or workspace.settings.resolution_mm
        words = (
            "There is paint on it. Of another material it is begun anew without the paint; what "
            "is open can be saved first."
        )
        if not is_bare and not (self._may_begin_anew(words) and self._may_leave()):
            return False
        choice = ObjectChoice(np.eye(3), 1.0, material, resolution)
        if not self._begin_anew(surface.source, choice):
            return False
        self._keep(material)
        return True

    def _begin_anew(self, source: TriangleMesh, choice: ObjectChoice) -> bool:
        """Put an object as it was chosen in the place of what is open, in the same hand."""
        workspace = self._workspace
        with workspace.easel.paused() as document:
            assert document is not None, "it was waited for"
            brush, inks = document.painter.brush, list(document.inks)

        def make(progress: Progress) -> Opened:
            document = Document.new(
                choice.apply(source), choice.resolution, choice.material, brush=brush, ink=inks[0],
                undo_bytes=int(workspace.settings.undo_megabytes * (1 << 20)),
            )  # fmt: skip
            document.inks[1] = inks[1]
            return open_with_progress(document, progress, 0.6)

        done = workspace.run(say("status.opening", name=source.name), make)
        return bool(workspace.went_well(done) and workspace.show(done.result()))

    def _may_begin_anew(self, words: str = _TURNED) -> bool:
        answer = ask(self._workspace.window, say(words), accept="Begin anew")
        return answer is Answer.AcceptRole
