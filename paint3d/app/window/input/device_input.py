"""Styli and 6-DOF mice: what they do, taken with every tick of the window."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from paint3d.app.model.input.devices import DeviceHub, StrokeCutter
from paint3d.app.window.panels.device_panel import DevicePanel
from paint3d.app.window.wording import say_error
from paint3d.app.window.workspace import Workspace
from paint3d.core.quaternion import matrices_from_quaternions, multiply_quaternions, rotate
from paint3d.core.types import AnyArray
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.device.sample import DeviceSample
from paint3d.errors import Paint3DError
from paint3d.pose.steering import ObjectPose

if TYPE_CHECKING:
    from collections.abc import Callable

    from paint3d.app.model.document import Document
    from paint3d.app.model.input.devices import Feedback, Plugged
    from paint3d.view.camera import Camera

__all__ = ["DeviceInput", "carried_camera"]

_SHOWN_EVERY = 12  # ticks between two looks at the panel
_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


def carried_camera(camera: Camera, before: ObjectPose, after: ObjectPose) -> Camera:
    """The camera that stands still in the world while the object is moved, in its frame."""

    def carry(vector: AnyArray, shifted: bool) -> AnyArray:
        world = rotate(before.orientation, vector) + (before.position if shifted else 0.0)
        return rotate(after.orientation * _CONJUGATE, world - (after.position if shifted else 0.0))

    return replace(
        camera,
        position=carry(camera.position, True),
        focus=carry(camera.focus, True),
        up=carry(camera.up, False),
    )


class DeviceInput:
    """For one window.

    Parameters
    ----------
    workspace : Workspace
    panel : DevicePanel
        Shows them now and then.
    plugged : PluggedDevices, optional
        None where there are none to look for.
    feel : callable, optional
        Starts the force feedback of a haptic stylus on a document; None where there is no such
        stylus. It is asked whenever a document is opened.
    """

    def __init__(
        self,
        workspace: Workspace,
        panel: DevicePanel,
        plugged: Plugged | None = None,
        feel: Callable[[Document], Feedback | None] | None = None,
    ) -> None:
        self._workspace, self._panel = workspace, panel
        self._plugged, self._feel = plugged, feel
        self._feedback: Feedback | None = None
        self.desk = self._make_desk()
        self._cutter = StrokeCutter(self._touches)
        self._pose = ObjectPose()
        self._ticks = 0

    def open(self, document: Document) -> None:
        """Let the haptic stylus feel another object."""
        if self._feedback is not None:
            self._feedback.stop()
            self._feedback = None
        if self._feel is None or self._plugged is None:
            return
        try:
            self._feedback = self._feel(document)
        except Paint3DError as error:
            self._workspace.tell(say_error(error), state="bad")
        self.desk = self._make_desk()

    def _make_desk(self) -> DeviceHub | None:
        if self._plugged is None:
            return None
        actions = self._workspace.settings.buttons
        return DeviceHub(self._plugged, actions=actions, feedback=self._feedback)

    def tick(self) -> None:
        """Take what the devices said; show them now and then."""
        self._ticks += 1
        if self.desk is not None:
            self._take(self.desk)
        if self._ticks % _SHOWN_EVERY == 0 and self._panel.isVisible():
            frame = self._workspace.stage.frame
            self._panel.show_desk(self.desk, frame)
            if frame is not None and frame.brush is not None:
                q = frame.brush.orientation[None]
                force = MAX_FORCE_N * (frame.brush.pressure or 0.0)
                self._panel.show_brush(matrices_from_quaternions(q)[0][:, 2], force)

    def _take(self, desk: DeviceHub) -> None:
        taken, easel = desk.take(), self._workspace.easel
        for command in taken.commands:
            easel.post(command)
        self._carry(taken.object_pose)
        for part in self._cutter.cut(taken.samples):
            if isinstance(part, str):
                if part == "begin_stroke":
                    self._workspace.hand.began.emit()
                done = easel.post(part)
                if part == "end_stroke":
                    self._workspace.hand.ended.emit(done)
            else:
                easel.feed(part)
        if taken.samples and not self._cutter.is_down:
            easel.hover(taken.samples[-1])

    def _carry(self, pose: ObjectPose) -> None:
        """Turn the view as the left hand turns the object."""
        hand, before = self._workspace.hand, self._pose
        same = np.array_equal(pose.position, before.position)
        if hand.camera is None or (same and np.array_equal(pose.orientation, before.orientation)):
            return
        hand.look(carried_camera(hand.camera, before, pose))
        self._pose = pose
        axes = matrices_from_quaternions(pose.orientation[None])[0]
        self._panel.show_object(axes)

    def _touches(self, sample: DeviceSample) -> bool:
        """Whether the brush touches: by its force, or by where it is."""
        if sample.pressure is not None:
            return sample.pressure > 0.0
        back = sample.object_orientation * _CONJUGATE
        place = rotate(back, sample.position - sample.object_position)
        orientation = multiply_quaternions(back, sample.orientation)
        found = self._workspace.document.painter.contact(place, orientation)
        return found is not None and found.area > 0.0

    def close(self) -> None:
        """Let go of the devices."""
        if self.desk is not None:
            self.desk.stop()
