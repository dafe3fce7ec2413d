"""Where a stylus or the pad of a pen stands: corners of a sheet are touched, and the frame kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from paint3d.app.model.input.plugging import plug_in_pens
from paint3d.app.model.persistence.calibrations import keep_calibration
from paint3d.app.window.wording import say, say_error
from paint3d.errors import Paint3DError
from paint3d.haptics.stylus_choice import key_of_node
from paint3d.pose.touching import Touches, sheet_corners

if TYPE_CHECKING:
    from paint3d.app.model.input.devices import Plugged
    from paint3d.app.window.input.canvas import Canvas
    from paint3d.app.window.input.touch import Touch
    from paint3d.app.window.panels.device_forms import StylusForm
    from paint3d.device.sample import StylusReading

__all__ = ["Calibrating"]

_CORNERS = ("near left", "near right", "far right", "far left")


def _keep_still(_: Touch) -> bool:
    """The tool while a pad is calibrated: nothing is painted."""
    return True


class Calibrating:
    """Follows one device while four corners are touched, each told by a button or in the panel.

    Parameters
    ----------
    form : StylusForm
        Says what is to be touched, and how far it was off.
    canvas : Canvas
        Takes no touches meanwhile: a pen is also the window system's.
    find_pens : callable, optional
        Opens the pads that are there; see `plug_in_pens`.
    """

    def __init__(
        self,
        form: StylusForm,
        canvas: Canvas,
        find_pens: Callable[[], Plugged | None] = plug_in_pens,
    ) -> None:
        self._form, self._canvas, self.find_pens = form, canvas, find_pens
        self._touches: Touches | None = None
        self._pens: Plugged | None = None
        self._key = ""

    @property
    def is_on(self) -> bool:
        """Whether corners are still to be touched."""
        return self._touches is not None

    def begin(self, width: float, depth: float, key: str | None) -> bool:
        """Have the corners of a sheet touched, mm, by the stylus of a key or else by a pad's pen.

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
        """The key of the first pad that could be opened."""
        pens = self.find_pens()
        nodes = [] if pens is None else pens.nodes()
        if not nodes:
            why = "" if pens is None else next(iter(pens.failures.values()), "")
            told = say("No stylus is there to calibrate") + (f": {why}" if why else "")
            self._form.show_calibrating(told, False)
            if pens is not None:
                pens.stop()
            return None
        self._pens = pens
        self._canvas.take_up(_keep_still, self.stop)
        return key_of_node(nodes[0])

    def stop(self, told: str = "") -> None:
        """Have no corner touched any more."""
        if self._touches is None:
            return
        self._touches = None
        if self._pens is not None:
            self._pens.stop()
            self._pens = None
            self._canvas.lay_down(_keep_still)
        self._form.show_calibrating(told, False)

    def hear_pens(self) -> None:
        """Follow the pen of a pad; it paints nothing meanwhile."""
        if self._pens is not None:
            self.hear(self._pens.take_stylus())

    def hear(self, readings: list[StylusReading]) -> str | None:
        """Follow the device, in its own frame; what is to be told once its frame is kept."""
        touches = self._touches
        if touches is None:
            return None
        try:
            return self._next() if touches.hear(readings) else None
        except Paint3DError as error:
            self._refuse(error)
        return None

    def touch(self) -> str | None:
        """The device touches the corner now, whatever buttons it has; returns as `hear`."""
        if self._touches is None:
            return None
        try:
            self._touches.touch()
            return self._next()
        except Paint3DError as error:
            self._refuse(error)
        return None

    def _next(self) -> str | None:
        """Ask for the next corner, or find the frame and keep it."""
        touches = self._touches
        assert touches is not None, "a corner was touched"
        if not touches.is_done:
            self._ask("")
            return None
        fitted = touches.fit()
        keep_calibration(self._key, fitted.calibration)
        each = ", ".join(f"{error:.2f}" for error in fitted.errors_mm)
        told = say("Calibrated: {mm:.2f} mm off", mm=fitted.calibration.residual_mm)
        self.stop(f"{told} ({each})")
        return f"{told} ({each})"

    def _refuse(self, error: Paint3DError) -> None:
        """Ask again: for the corner, or for all where no frame followed of them."""
        assert self._touches is not None, "a corner was touched"
        if self._touches.is_done:
            self._touches = Touches(self._touches.points)
        self._ask(say_error(error))

    def _ask(self, problem: str) -> None:
        assert self._touches is not None, "it is being calibrated"
        corner = say(_CORNERS[len(self._touches.touched)])
        asked = say("Touch the {corner} corner and press the stylus' button", corner=corner)
        self._form.show_calibrating(f"{problem}\n{asked}".strip(), True)
