"""Styli that push back, chosen by a word: each paints in the window, and is felt as its brush."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from paint3d.app.model.input.devices import NothingPlugged
from paint3d.app.model.input.plugging import Feeling, start_feeling
from paint3d.app.model.persistence.calibrations import kept_calibration
from paint3d.app.model.persistence.settings import Settings
from paint3d.app.window.studio import StudioWindow
from paint3d.brush.presets import load_brush
from paint3d.colour.materials import load_material
from paint3d.haptics.feel import Feel
from paint3d.haptics.settings import DeviceLimits, HapticSettings
from tests.support.app.gestures import live, wait_for
from tests.support.app.windows import close_unasked
from tests.support.force_model import ForceModel
from tests.support.styli import Inverse3StandIn, OpenHapticsStandIn

DEEP = 6.0  # mm
LIFTED = 80.0
BRUSH = load_brush("full")
SHEET = ((-105.0, -74.0), (105.0, -74.0), (105.0, 74.0), (-105.0, 74.0))


@pytest.fixture(params=[OpenHapticsStandIn, Inverse3StandIn])
def stylus(request, tmp_path, monkeypatch):
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path / "config"))
    stylus = request.param(tmp_path)
    for name, value in stylus.environment.items():
        monkeypatch.setenv(name, value)
    stylus.hold(0.0, 0.0, LIFTED)
    yield stylus
    stylus.close()


@pytest.fixture
def window(program, stylus):
    settings = Settings(stylus=stylus.choice)
    window = StudioWindow(program, settings, feel=start_feeling)
    window.show()
    window.workspace.quiet = True
    assert window.opening.open_path("plane", 1.5, "porcelain", asked=True)
    wait_for(lambda: window.stage.is_lit)
    wait_for(lambda: window.both_hands.desk.rate_hz("right") > 0.0)
    yield window
    close_unasked(window)


def done(window) -> None:
    """Wait until what was asked for is painted: a stylus that is held is never still."""
    window.stage.easel.post(lambda document: None).result(300)
    live(0.1)


def paint_a_line(window, stylus, at=(0.0, 0.0)) -> np.ndarray:
    """Go from 15 mm to the left of a place to 15 mm to the right: the vertices that are inked."""
    n = len(window.document.strokes)
    z = window.document.painter.brush.length_mm - DEEP
    stylus.hold(at[0] - 15.0, at[1], LIFTED)
    live(0.1)
    for x in np.linspace(-15.0, 15.0, 40):
        stylus.hold(at[0] + x, at[1], z)
        live(0.01)
    stylus.hold(at[0] + 15.0, at[1], LIFTED)
    wait_for(lambda: len(window.document.strokes) == n + 1)
    done(window)
    surface = window.document.surface
    return surface.paint_mesh.vertices[np.flatnonzero(surface.painted)]


def is_pushed_back(stylus, x: float, y: float, z: float) -> bool:
    """Whether it is told to push upwards when it is pressed down from above."""
    stylus.hold(x, y, LIFTED)  # after a pause of the machine it is felt again when it was lifted
    live(0.2)
    stylus.hold(x, y, z)
    live(0.5)
    return bool(stylus.force()[2] > 0.02)


def test_it_paints_under_its_place_and_is_felt_as_the_brush_in_the_hand(window, stylus) -> None:
    places = paint_a_line(window, stylus)
    assert abs(np.median(places[:, 1])) < 1.0
    assert np.ptp(places[:, 0]) > 30.0
    assert window.panels.devices.stylus.kind.currentData() == stylus.choice.partition("=")[0]
    wait_for(lambda: is_pushed_back(stylus, 0.0, 40.0, BRUSH.length_mm - DEEP))
    stylus.hold(0.0, 40.0, LIFTED)
    wait_for(lambda: not stylus.force().any())


class Law(NothingPlugged):
    """Stands in for a servo: tells the force of its settings, 6 mm deep in the tree's surface."""

    last_force = np.zeros(3)

    def __init__(self, tree, settings) -> None:
        super().__init__()
        self.tree, self.settings = tree, settings

    take = NothingPlugged.nodes

    def publish(self, object_pose=None) -> None:
        assert object_pose is not None

    def is_running(self) -> bool:
        return True

    def felt(self) -> float:
        model = ForceModel(self.tree, self.settings, awake=True)
        for _ in range(60):
            step = model.step([0.0, 0.0, self.settings.length - DEEP])
        return float(step.force[2])


def test_the_force_is_that_of_the_brush_that_was_taken_last(program) -> None:
    limits, laws = DeviceLimits(5.0, 0.6), []

    def feel(document, settings):
        brush = Feel.from_words(settings.feel).settings(document.painter.brush, limits)
        laws.append(Law(document.surface.contact_tree, brush))
        return Feeling(laws[-1], limits=limits)

    window = StudioWindow(program, Settings(), feel=feel)
    window.workspace.quiet = True
    assert window.opening.open_path("plane", 2.0, "porcelain", asked=True)
    for name in ("full", "gongbi", "dakai", "full"):
        window.workspace.post("set_brush", name)
        done(window)
        brush = load_brush(name)
        spring = min(HapticSettings.for_brush(brush, limits).spring, limits.max_stiffness)
        wanted = spring * DEEP
        wait_for(lambda wanted=wanted: abs(laws[-1].felt() - wanted) < 0.01 * wanted, 30.0)
    window.panels.devices.stylus.limit.setValue(0.5)
    wait_for(lambda: abs(laws[-1].felt() - 0.5) < 1e-6, 30.0)
    assert window.workspace.settings.feel["limit_n"] == 0.5
    close_unasked(window)


def test_the_surface_is_felt_as_it_is_and_its_grain_as_much_as_is_wanted(program) -> None:
    laws = []

    def feel(document, settings):
        laws.append(Law(document.surface.contact_tree, HapticSettings(35.0, 0.4, 0.2)))
        return Feeling(laws[-1])

    window = StudioWindow(program, Settings(), feel=feel)
    window.workspace.quiet = True
    for name in ("porcelain", "terracotta"):
        assert window.opening.open_path("plane", 2.0, name, asked=True)
        material, brush = load_material(name), window.document.painter.brush
        mu = brush.friction * material.friction
        wait_for(lambda mu=mu: abs(laws[-1].settings.friction - mu) < 1e-12, 30.0)
        assert laws[-1].settings.grain == material.grain
        assert laws[-1].settings.texture == 1.0  # at first
    window.panels.devices.stylus.texture.setValue(0.5)
    wait_for(lambda: laws[-1].settings.texture == 0.5, 30.0)
    assert window.workspace.settings.feel["texture"] == 0.5
    close_unasked(window)


def test_it_is_calibrated_in_the_panel_and_paints_where_it_was_touched(window, stylus) -> None:
    """The sheet lies 20 mm to the right of where the device has its middle, and 5 mm lower."""
    form = window.panels.devices.stylus
    form.calibrate.click()
    for x, y in SHEET:
        said = form.told.text()
        assert "corner" in said
        for buttons in (0, 1, 0):
            stylus.hold(x + 20.0, y, -5.0, buttons)
            live(0.2)
        wait_for(lambda said=said: form.told.text() != said)
    assert "0.0" in form.told.text()
    assert not window.document.strokes  # touching paints nothing
    feeling = window.both_hands.feeling
    middle = kept_calibration(feeling.key).to_world(np.zeros(3))
    assert np.allclose(feeling.calibration.to_world(np.zeros(3)), middle)
    assert np.allclose(middle, [-20.0, 0.0, 5.0], atol=0.01)
    stylus.hold(20.0, 0.0, LIFTED)
    wait_for(lambda: window.both_hands.desk.rate_hz("right") > 0.0)


def test_what_is_missing_is_said(window) -> None:
    form = window.panels.devices.stylus
    form.kind.setCurrentIndex(form.kind.findData("hid"))
    form.kind.activated.emit(form.kind.currentIndex())
    assert "f055:4a50" in window.status.told.text()
    assert window.workspace.settings.stylus == "hid"
    assert window.both_hands.feeling is None
    form.calibrate.click()
    assert "No stylus" in form.told.text()
