"""Styli and 6-DOF mice: what they do, taken with every tick of the window."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from paint3d.app.model.input.devices import (
    DeviceHub,
    NoDevices,
    StrokeCutter,
    plug_in_pens,
    went_down,
)
from paint3d.app.model.persistence.settings import store_calibration
from paint3d.app.window.hand.device_panel import DevicePanel
from paint3d.app.window.wording import say, say_error
from paint3d.app.window.workspace import Workspace
from paint3d.core.arrays import AnyArray
from paint3d.core.quaternion import matrices_from_quaternions, multiply_quaternions, rotate
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.device.sample import DIP, ERASER, DeviceSample, StylusReading
from paint3d.errors import Message, Paint3DError
from paint3d.haptics.settings import Feel
from paint3d.haptics.stylus_choice import key_of_node
from paint3d.pose.calibration import DeviceCalibration
from paint3d.pose.mouse_settings import MouseSettings
from paint3d.pose.steering import ObjectPose
from paint3d.pose.touching import Touches, sheet_corners

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from paint3d.app.model.document import Document
    from paint3d.app.model.input.devices import Devices, Feeling
    from paint3d.app.model.persistence.settings import Settings
    from paint3d.app.window.hand.canvas import CanvasWidget, Touch
    from paint3d.app.window.hand.device_panel import StylusForm
    from paint3d.device.sample import StylusReading
    from paint3d.view.camera import Camera

__all__ = ["Calibrating", "DeviceInput", "carried_camera"]

# ---- Calibration ---------------------------------------------------------------------------------
# The frame of a stylus or of a pen's pad: corners of a sheet are touched, and the fit is saved.


_CORNERS = (Message("near left"), Message("near right"), Message("far right"), Message("far left"))


def _ignore_touch(_: Touch) -> bool:
    """Take every touch: the tool while a pad is calibrated, so that nothing is painted."""
    return True


class Calibrating:
    """Follows one device while four corners are touched, each confirmed by a button or the panel.

    Parameters
    ----------
    form : StylusForm
        Shows which corner is to be touched, and the error of the fit.
    canvas : CanvasWidget
        Takes no touches meanwhile: a pen is also the window system's.
    find_pens : callable, optional
        Opens the pads that are there; see `plug_in_pens`.
    """

    def __init__(
        self,
        form: StylusForm,
        canvas: CanvasWidget,
        find_pens: Callable[[], Devices | None] = plug_in_pens,
    ) -> None:
        self._form, self._canvas, self.find_pens = form, canvas, find_pens
        self._touches: Touches | None = None
        self._pens: Devices | None = None
        self._key = ""

    @property
    def is_on(self) -> bool:
        """True if corners are still to be touched."""
        return self._touches is not None

    def begin(self, width: float, depth: float, key: str | None) -> bool:
        """Ask for the corners of a sheet, mm, by the stylus of a key or else by a pad's pen.

        Returns
        -------
        bool
            Whether there is such a device.
        """
        if key is None:
            key = self._open_pens()
        if key is None:
            return False
        self._key, self._touches = key, Touches(sheet_corners(width, depth))
        self._ask("")
        return True

    def _open_pens(self) -> str | None:
        """Open the pads, and return the key of the first; None if there is none."""
        pens = self.find_pens()
        nodes = [] if pens is None else pens.nodes()
        if not nodes:
            failures = [] if pens is None else [*pens.failures.values()]
            problems = [say("No stylus is there to calibrate"), *map(say_error, failures[:1])]
            message = ": ".join(problems)
            self._form.show_calibrating(message, False)
            if pens is not None:
                pens.stop()
            return None
        self._pens = pens
        self._canvas.take_up(_ignore_touch, self.stop)
        return key_of_node(nodes[0])

    def stop(self, message: str = "") -> None:
        """Ask for no more corners."""
        if self._touches is None:
            return
        self._touches = None
        if self._pens is not None:
            self._pens.stop()
            self._pens = None
            self._canvas.lay_down(_ignore_touch)
        self._form.show_calibrating(message, False)

    def follow_pens(self) -> None:
        """Follow the pen of a pad; it paints nothing meanwhile."""
        if self._pens is not None:
            self.follow(self._pens.take_stylus())

    def follow(self, readings: list[StylusReading]) -> str | None:
        """Follow the device, in its own frame; return a message once its frame is saved."""
        touches = self._touches
        if touches is None:
            return None
        try:
            return self._next() if touches.add(readings) else None
        except Paint3DError as error:
            self._refuse(error)
        return None

    def touch(self) -> str | None:
        """Take the device's position for the corner, without a button; returns as `follow`."""
        if self._touches is None:
            return None
        try:
            self._touches.touch()
            return self._next()
        except Paint3DError as error:
            self._refuse(error)
        return None

    def _next(self) -> str | None:
        """Ask for the next corner, or fit the frame and save it."""
        touches = self._touches
        assert touches is not None, "a corner was touched"
        if not touches.is_done:
            self._ask("")
            return None
        fitted = touches.fit()
        store_calibration(self._key, fitted.calibration)
        each = ", ".join(f"{error:.2f}" for error in fitted.errors_mm)
        message = say("Calibrated: {mm:.2f} mm off", mm=fitted.calibration.residual_mm)
        self.stop(f"{message} ({each})")
        return f"{message} ({each})"

    def _refuse(self, error: Paint3DError) -> None:
        """Ask again: for the corner, or for all where no frame fits them."""
        assert self._touches is not None, "a corner was touched"
        if self._touches.is_done:
            self._touches = Touches(self._touches.points)
        self._ask(say_error(error))

    def _ask(self, problem: str) -> None:
        assert self._touches is not None, "it is being calibrated"
        corner = say(_CORNERS[len(self._touches.touched)])
        asked = say("Touch the {corner} corner and press the stylus' button", corner=corner)
        self._form.show_calibrating(f"{problem}\n{asked}".strip(), True)


# ---- Painting with devices -----------------------------------------------------------------------


_PATIENCE_S = 0.02  # that the window waits for a step of the painting
_SHOWN_EVERY = 12  # ticks between two looks at the panel
_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


def carried_camera(camera: Camera, before: ObjectPose, after: ObjectPose) -> Camera:
    """Return the camera, in the object's frame, that stands still while the object is moved."""

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
    """Passes samples, buttons and forces of the devices of both hands on to the painting.

    Parameters
    ----------
    workspace : Workspace
    panel : DevicePanel
        Shows them, and emits what is chosen for them.
    plugged : PluggedDevices, optional
        None where there are none to look for.
    feel : callable, optional
        Starts the force feedback of the stylus that the settings ask for on a document; None where
        there is no such stylus. It is asked whenever a document is opened or another is chosen.
    """

    def __init__(
        self,
        workspace: Workspace,
        panel: DevicePanel,
        plugged: Devices | None = None,
        feel: Callable[[Document, Settings], Feeling | None] | None = None,
    ) -> None:
        self._workspace, self._panel = workspace, panel
        self._plugged, self._feel = plugged, feel
        self._feeling: Feeling | None = None
        self.calibrating = Calibrating(panel.stylus, workspace.canvas)
        self.desk: DeviceHub | None = None
        self.desk = self._make_desk()
        self._cutter = StrokeCutter(self._is_touching)
        self._pose = ObjectPose()
        self._ticks = 0
        self._reported_end: str | None = None
        self._buttons_before: int | None = None  # of the stylus
        self._paused_document: Document | None = None  # while samples are cut into strokes
        self._closed = False
        self._show_choices()
        for signal, slot in self._connections():
            signal.connect(slot)

    def _connections(self) -> list[tuple[Any, Callable[..., None]]]:
        """Return the panel's signals with their slots, to connect and to disconnect them."""
        stylus, mouse = self._panel.stylus, self._panel.mouse
        return [
            (stylus.chosen, self.choose_stylus),
            (stylus.felt, self.choose_feel),
            (stylus.calibrated, self.calibrate),
            (stylus.touched, self._touch),
            (mouse.read, self.choose_mouse),
            (mouse.pressed, self.choose_button),
        ]

    def _show_choices(self) -> None:
        settings = self._workspace.settings
        self._panel.stylus.show_choices(settings.stylus, Feel.from_dict(settings.feel))
        self._panel.mouse.show_choices(MouseSettings.from_dict(settings.mouse), settings.buttons)

    @property
    def feeling(self) -> Feeling | None:
        """The stylus that pushes back; None where none does."""
        return self._feeling

    @property
    def in_stroke(self) -> bool:
        """True if a stylus paints now."""
        return self._cutter.is_down

    def open(self) -> None:
        """Feel another object with the haptic stylus; it stands as its picture shows it."""
        if self.desk is not None:
            self.desk.hands.set_object_pose(ObjectPose())
        self._pose = ObjectPose()
        self._cutter.end()  # what was begun on another document ended with it
        self._start_feeling()

    def _start_feeling(self) -> None:
        """Start the stylus that the settings ask for; the object stays where it is."""
        self.calibrating.stop()
        self._leave_object()
        if self._feeling is not None:
            self._feeling.feedback.stop()
            self._feeling = None
        if self._feel is not None:
            try:
                with self._workspace.paint_thread.paused() as document:
                    assert document is not None, "it was waited for"
                    self._feeling = self._feel(document, self._workspace.settings)
            except Paint3DError as error:
                self._workspace.tell(say_error(error), state="bad", stays=True)
        if self._feeling is not None or self.desk is not None:
            self.desk = self._make_desk()
        self._reported_end = None

    def _make_desk(self) -> DeviceHub | None:
        """Make a hub of the devices; the object stays where the left hand has it."""
        settings, before = self._workspace.settings, self.desk
        if self._plugged is None and self._feeling is None:
            return None
        feeling = self._feeling
        desk = DeviceHub(
            self._plugged or NoDevices(),
            None if before is None else before.hands,
            actions=settings.buttons,
            feedback=None if feeling is None else feeling.feedback,
            stylus_name="" if feeling is None else feeling.name,
        )
        if before is None:  # else the hands go on with what a button locked
            desk.set_mouse(MouseSettings.from_dict(settings.mouse))
        return desk

    # -- what is chosen ---------------------------------------------------------------------

    def choose_stylus(self, stylus: str) -> None:
        """Feel with this one from now on, one of `STYLI`; again, if it was chosen before."""
        before = self._workspace.settings.stylus
        if before.partition("=")[0] != stylus:  # the path of a library or a service stays
            self._workspace.update_settings(stylus=stylus)
        if self._workspace.stage.paint_thread is not None:
            self._start_feeling()
            if self._feeling is not None:
                self._workspace.tell(self._feeling.name, state="good")

    def choose_feel(self, changes: Mapping[str, float]) -> None:
        """Change the haptic stylus's settings: see `Feel`."""
        self._workspace.update_settings(feel={**self._workspace.settings.feel, **changes})

    def choose_mouse(self, mouse: MouseSettings) -> None:
        """Read the 6-DOF mouse by other settings."""
        self._workspace.update_settings(mouse=mouse.as_dict())
        if self.desk is not None:
            self.desk.set_mouse(mouse)

    def choose_button(self, button: int, action: str) -> None:
        """Assign an action to a button of the 6-DOF mouse, from 0; "": none."""
        buttons = {**self._workspace.settings.buttons, button: action}
        buttons = {number: act for number, act in buttons.items() if act}
        self._workspace.update_settings(buttons=buttons)
        self._show_choices()
        if self.desk is not None:
            self.desk.set_actions(buttons)

    # -- calibrating ------------------------------------------------------------------------

    def calibrate(self, width: float, depth: float) -> None:
        """Ask for the corners of a sheet of this size, mm; (0, 0) stops it.

        By the stylus that pushes back, or where there is none by the pen of a pad.
        """
        self.calibrating.stop()
        if width <= 0.0:
            return
        feeling = self._feeling
        if self.calibrating.begin(width, depth, None if feeling is None else feeling.key):
            self._leave_object()

    def _follow_touches(self, samples: list[DeviceSample]) -> None:
        """Follow a stylus that is calibrated: it paints nothing meanwhile."""
        feeling = self._feeling
        if feeling is None:
            return
        frame = feeling.calibration or DeviceCalibration()
        readings = [
            StylusReading(
                one.time_ns, frame.to_device(one.position), one.orientation, None, one.buttons
            )
            for one in samples
        ]
        self._use_frame(self.calibrating.follow(readings))

    def _touch(self) -> None:
        """Take the corner as it is touched now: the panel says so."""
        self._use_frame(self.calibrating.touch())

    def _use_frame(self, message: str | None) -> None:
        """Feel by the new frame, if there is one."""
        if message is not None and self._feeling is not None:
            self._start_feeling()
            self._panel.stylus.show_calibrating(message, False)

    # -- tick by tick -----------------------------------------------------------------------

    def tick(self) -> None:
        """Take what the devices sent; update the panel now and then."""
        self._ticks += 1
        self.calibrating.follow_pens()
        if self.desk is not None:
            self._take(self.desk)
            self._report_end(self.desk)
        if self._feeling is not None:
            feel = Feel.from_dict(self._workspace.settings.feel)
            if self.calibrating.is_on:
                feel = replace(feel, limit_n=0.0)  # the object pushes no hand off the sheet
            material = self._workspace.painting.material
            self._feeling.follow(self._workspace.paint_thread.brush, feel, material)
        if self._ticks % _SHOWN_EVERY == 0 and self._panel.isVisible():
            frame = self._workspace.stage.frame
            self._panel.show_desk(self.desk, frame)
            if frame is not None and frame.brush is not None:
                q = frame.brush.orientation[None]
                force = MAX_FORCE_N * (frame.brush.pressure or 0.0)
                self._panel.show_brush(matrices_from_quaternions(q)[0][:, 2], force)

    def _take(self, desk: DeviceHub) -> None:
        taken, paint_thread = desk.take(), self._workspace.paint_thread
        self._panel.mouse.show_locks(desk.hands.steering)
        for command in taken.commands:
            if command == "dip":
                self._workspace.dip()
            else:
                paint_thread.post(command)
        for failure in taken.failures:
            self._workspace.tell(say_error(failure), state="bad")
        self._carry(taken.object_pose)
        buttons = [sample.buttons for sample in taken.samples]
        dips, self._buttons_before = went_down(DIP, self._buttons_before, buttons)
        if self.calibrating.is_on:
            self._follow_touches(taken.samples)
            return
        parts = self._cut(taken.samples)
        if dips and not parts:
            self._workspace.dip()  # in a stroke its samples ask for it themselves
        for k, part in enumerate(parts):
            if isinstance(part, str):
                if part == "begin_stroke":
                    self._workspace.hand.began.emit()
                    down = parts[k + 1][:2][-1]  # after the one above the surface, if there is one
                    erase = self._workspace.hand.erases or bool(down.buttons & ERASER)
                    paint_thread.post(part, **({"erase": True} if erase else {}))
                else:
                    self._end_stroke()
            else:
                paint_thread.feed(part)
        if taken.samples and not self._cutter.is_down:
            paint_thread.hover(taken.samples[-1])

    def _leave_object(self) -> None:
        """End a stroke whose stylus is no longer followed."""
        if self._cutter.end():
            self._end_stroke()

    def _end_stroke(self) -> None:
        self._workspace.hand.ended.emit(self._workspace.paint_thread.post("end_stroke"))

    def _report_end(self, desk: DeviceHub) -> None:
        """Say why the force feedback has ended, once."""
        if desk.ended is not None and desk.ended != self._reported_end:
            self._reported_end = desk.ended
            self._feeling = None
            self._leave_object()
            self.calibrating.stop()
            message = say("Force feedback stopped: {why}", why=desk.ended)
            self._workspace.tell(message, state="bad", stays=True)

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

    def _cut(self, samples: list[DeviceSample]) -> list[Any]:
        """Cut samples into strokes; those without a pressure by the surface, painting paused."""
        if all(sample.pressure is not None for sample in samples):
            return self._cutter.cut(samples)
        with self._workspace.paint_thread.paused(_PATIENCE_S) as self._paused_document:
            parts = self._cutter.cut(samples)
        self._paused_document = None
        return parts

    def _is_touching(self, sample: DeviceSample) -> bool:
        """Return whether the brush touches: by its force, or by its position.

        While the painting could not be paused, the answer stays as it was.
        """
        if sample.pressure is not None:
            return sample.pressure > 0.0
        back = sample.object_orientation * _CONJUGATE
        position = rotate(back, sample.position - sample.object_position)
        orientation = multiply_quaternions(back, sample.orientation)
        if self._paused_document is None:
            return self._cutter.is_down
        contact = self._paused_document.painter.contact(position, orientation)
        return contact is not None and contact.area > 0.0

    def close(self) -> None:
        """Close the devices."""
        if not self._closed:
            self._closed = True
            for signal, slot in self._connections():
                signal.disconnect(slot)
        self.calibrating.stop()
        if self.desk is not None:
            self.desk.stop()
