"""Recordings of strokes: saving those painted here, and replaying files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib.resources import as_file, files
from pathlib import Path

from paint3d.app.model.frame import Snapshot
from paint3d.app.model.input.navigation import ray_at
from paint3d.app.model.score.playing import begun, painted, score_of_strokes
from paint3d.app.model.score.stepping import Cue, cues_of
from paint3d.app.window.files.file_dialogs import ask_file
from paint3d.app.window.files.open_result import OpenResult, open_with_progress
from paint3d.app.window.files.target_dialog import Targets
from paint3d.app.window.job import JobProgress
from paint3d.app.window.playing.player import Asked, Player, Tools
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.brush.spec import BrushSpec
from paint3d.calligraphy.dips import apply_dip_option
from paint3d.device.sample import DeviceSample
from paint3d.errors import Message
from paint3d.files.progress import part_of
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import frame_at, make_chart
from paint3d.mesh.placement import place, upwards
from paint3d.painter.flat_input import LaidPad, add_dips, pad_extent
from paint3d.painter.recorded_tools import (
    changes_at,
    recorded_amount,
    recorded_brush,
    recorded_ink,
    recorded_tip,
)
from paint3d.recording.recording import Recording, load_recording, save_recording
from paint3d.recording.score import is_score, load_score, save_score
from paint3d.view.camera import Camera, picture_axes

__all__ = ["FORMATS", "Recordings", "lay_in_view", "samples_of", "tool_changes_of", "tools_in_hand"]

# Kinds of files by their suffix, as the dialog names them:
FORMATS = {
    ".jsonl": Message("Recording, JSON Lines"),
    ".jsonl.gz": Message("Recording, JSON Lines, packed"),
    ".inkml": Message("Recording, InkML"),
    ".score.jsonl": Message("Whole painting, JSON Lines"),
    ".score.jsonl.gz": Message("Whole painting, JSON Lines, packed"),
}
_SAMPLE, _SAMPLE_DIPS = "data/demo.jsonl.gz", "auto"
_SAMPLE_OBJECT, _SAMPLE_MM, _SAMPLE_MATERIAL = "bowl", 0.25, "porcelain"
_READ = 0.6  # of the time that a recording takes to be made ready
_MARGIN_MM = 1.0
_ALONG = 0.999  # cosine to the normal above which the picture's up direction is not used
_AT_ONCE = 1000  # samples between two looks at whether it is still wanted


class Recordings:
    """Commands that record, save and replay; ``do_<action>`` for each.

    Parameters
    ----------
    workspace : Workspace
    targets : Targets
    player : Player
    speed : callable
        Returns the speed of replays relative to their own; None: as fast as it goes.
    may_leave : callable
        Asks whether the open painting may be left; see `Saving.may_leave`.
    begin : callable
        Begins a painting on an object, with a distance of vertices (mm) and a material.
    """

    def __init__(
        self,
        workspace: Workspace,
        targets: Targets,
        player: Player,
        speed: Callable[[], float | None],
        may_leave: Callable[[], bool],
        begin: Callable[[str, float, str], bool],
    ) -> None:
        self._workspace, self._targets, self._may_leave = workspace, targets, may_leave
        self._begin = begin
        self._player, self._speed = player, speed
        self._recorded_from = 0

    def do_record(self, on: bool) -> None:
        """Begin a recording; when it ends, ask where to save it."""
        workspace = self._workspace
        strokes = len(workspace.painting.strokes)
        if on:
            self._recorded_from = strokes
            workspace.tell(say("Recording"), state="good", stays=True)
            return
        workspace.tell(
            say(
                "Paint with the left button, a pen or a finger; turn by a drag beside the object, "
                "with Space held, or by the grips"
            )
        )
        if strokes > self._recorded_from:
            self.do_save_recording(self._recorded_from)

    def do_save_recording(self, first: int = 0) -> None:
        """Ask where, and save the strokes that were painted here from index `first` on."""
        workspace = self._workspace
        with workspace.paint_thread.paused() as document:
            assert document is not None, "it was waited for"
            recording = document.recording(first)
            score = None if first else document.score
            if score is None:
                score = score_of_strokes(document.strokes[first:], document.surface)
        if recording is None or score is None:
            message = say("Strokes: {n}, {seconds:.1f} s", n=0, seconds=0.0)
            workspace.tell(message, state="bad")
            return
        path = self._targets.ask(say("Save the strokes as a recording…"), FORMATS)
        if path is None:
            return

        def write(progress: JobProgress) -> None:
            if path.name.lower().endswith((".score.jsonl", ".score.jsonl.gz")):
                save_score(score, path, progress)
            else:
                save_recording(recording, path, progress)

        done = workspace.run(say("Writing {name}…", name=path.name), write)
        if workspace.went_well(done):
            workspace.tell(say("Exported {name}", name=path.name), state="good")

    def do_replay(self) -> None:
        """Ask for a recording, and paint it on the object."""
        kinds = f"{say('Recordings')} (*.jsonl *.jsonl.gz *.inkml *.csv);;{say('All files')} (*)"
        path = ask_file(self._workspace.window, say("Replay"), kinds)
        if path:
            self.replay_file(path, self._speed())

    def do_sample(self) -> None:
        """Open a bowl, and write poems on it, as an example."""
        workspace = self._workspace
        if workspace.stage.paint_thread is not None and not self._may_leave():
            return
        if self._begin(_SAMPLE_OBJECT, _SAMPLE_MM, _SAMPLE_MATERIAL):
            with as_file(files("paint3d.calligraphy").joinpath(_SAMPLE)) as path:
                self.replay_file(str(path), None, dips=_SAMPLE_DIPS)

    def replay_file(
        self, path: str, speed: float | None = None, *, dips: str | int | None = None
    ) -> bool:
        """Paint a recording on the object, as if by hand; return whether that began.

        It is painted with its own brush, ink and azimuth, as `paint3d replay` does; the hand gets
        its own back. A pad's, which knows nothing of the object, is laid on it as it is seen; see
        `lay_in_view`. A whole painting is begun anew on the object.

        Parameters
        ----------
        path : str
        speed : float, optional
            Of the recording's own time; by default as fast as it goes.
        dips : {"auto", "always"} or int, optional
            Before which characters the brush is dipped, as `apply_dip_option` takes it; by default
            where the recording says.
        """
        workspace = self._workspace
        title = say("Opening {name}…", name=Path(path).name)
        if is_score(path):
            return self._play_score(path, title, speed)
        surface, camera = workspace.hand.surface, workspace.hand.open_camera
        material = workspace.painting.material

        def read(progress: JobProgress) -> tuple[list[DeviceSample], Tools]:
            recording = load_recording(path, progress=part_of(progress, 0.0, _READ))
            if recording.is_pad:
                recording = lay_in_view(recording, surface, camera)
            if dips is not None:
                brush = recorded_brush(recording.header)
                assert brush is not None, "it names the brush that it was planned for"
                recording = apply_dip_option(recording, brush, dips, material)
            tools = Tools(_opening_commands(recording), (), *tool_changes_of(recording))
            return samples_of(recording, progress), tools

        loaded = workspace.run(title, read)
        if not workspace.went_well(loaded):
            return False
        samples, tools = loaded.result()
        after = tools_in_hand(workspace.painting, workspace.paint_thread.brush)
        self._player.play(samples, speed, replace(tools, after=after))
        return True

    def _play_score(self, path: str, title: str, speed: float | None) -> bool:
        """Begin anew on the object, and paint a whole painting on it.

        As fast as it goes it is painted beside the window, and shown when it is done.
        """
        workspace = self._workspace
        with workspace.paint_thread.paused() as document:
            assert document is not None, "it was waited for"
            mesh = document.surface.source
            is_bare = not document.strokes and not document.surface.painted.any()
        if not is_bare and not self._may_leave():
            return False

        def make(progress: JobProgress) -> tuple[OpenResult, list[Cue]]:
            score = load_score(path, part_of(progress, 0.0, 0.1))
            cues: list[Cue] = []
            if speed is None:
                document = painted(score, mesh, progress=part_of(progress, 0.1, 0.9))
            else:
                document = begun(score, mesh)
                cues = list(cues_of(score, document.surface))
            return open_with_progress(document, progress, 0.9), cues

        done = workspace.run(title, make)
        if not workspace.went_well(done):
            return False
        opened, cues = done.result()
        if not workspace.show(opened):
            return False
        self._player.play_score(cues, speed)
        return True


def lay_in_view(recording: Recording, surface: ClosestPoints, camera: Camera) -> Recording:
    """Lay a pad's recording on the object as it is seen, upright and as large as it was drawn.

    Its middle lies at the picture's middle, or at the object's front if that is beside the object.
    A recording without dips gets one before every stroke.

    Parameters
    ----------
    recording : Recording
        In pad space.
    surface : ClosestPoints
        Of the object.
    camera : Camera
        Of the view.

    Returns
    -------
    Recording
        In the object's frame.

    Raises
    ------
    MeshError, InputError, RecordingError
        If it does not fit there.
    """
    middle, half, scale = pad_extent(recording)
    ray = ray_at(camera, 0.5, 0.5, (1.0, 1.0))
    hits = surface.cast(ray.origin[None], ray.direction[None])
    if hits.hit[0]:
        normal = surface.find(hits.points[:1]).normals[0]
        up = picture_axes(camera)[1]
        up = upwards(normal) if abs(float(up @ normal)) > _ALONG else up
        frame = frame_at(surface, hits.points[0], up)
    else:
        frame = place(surface, (0.5, 0.5))
    chart = make_chart(surface, frame, *(half + _MARGIN_MM))
    return LaidPad(add_dips(recording), chart, middle, scale).whole()


def _opening_commands(recording: Recording) -> list[Asked]:
    """Return the commands that set and dip a recording's tools (version 1), as far as given."""
    brush, ink = recorded_brush(recording.header), recorded_ink(recording.header)
    tip = recorded_tip(recording.header)
    asked: list[Asked] = [("set_azimuth", (recording.header["azimuth"],))]
    if brush is not None:
        asked.append(("set_brush", (brush,)))
    asked.append(("dip", (ink, None, recorded_amount(recording.header).words())))
    if tip is not None:
        asked.append(("dip", tip))
    return asked


def tool_changes_of(
    recording: Recording,
) -> tuple[list[tuple[int, float]], list[tuple[int, float]]]:
    """Return loads and strengths of the brush by samples; of several at one, the last."""
    loads, strengths = changes_at(recording.header, recording.time_ns)
    return list(dict(loads).items()), list(dict(strengths).items())


def tools_in_hand(painting: Snapshot, brush: BrushSpec) -> list[Asked]:
    """Return the commands that give the hand its tools back, freshly dipped."""
    asked: list[Asked] = [("set_azimuth", (painting.azimuth,)), ("set_brush", (brush,))]
    amount = painting.amount.words()
    dips = painting.dips or ((painting.dipped, None),)
    return asked + [("dip", (ink, reach, amount if reach is None else None)) for ink, reach in dips]


def samples_of(recording: Recording, progress: JobProgress) -> list[DeviceSample]:
    """Return the samples of a recording, reporting progress."""
    samples = []
    for k, sample in enumerate(recording.samples()):
        samples.append(sample)
        if k % _AT_ONCE == 0:
            progress(_READ + (0.99 - _READ) * k / len(recording))
    return samples
