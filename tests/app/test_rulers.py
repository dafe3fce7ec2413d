"""Rulers that lead strokes: straight, around, along the profile; a mouse steadied and pressed."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore
from scipy.signal import savgol_filter

from paint3d.app.model.document import Document
from paint3d.app.model.input.hand import Hand, HandSettings
from paint3d.app.model.persistence.settings import Settings
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.pose.brush_pose import object_poses
from tests.app.test_hand import draw, places
from tests.support.app.gestures import BUTTON, KIND, mouse, type_key, wait_for
from tests.support.app.marks import take_mark
from tests.support.app.windows import opened, settled

KEY = QtCore.Qt.Key


@pytest.fixture(scope="module")
def plane() -> ClosestPoints:
    return ClosestPoints(load_mesh("plane"))


def test_a_straight_ruler_takes_the_wobble_out_and_keeps_the_length(plane) -> None:
    rng = np.random.default_rng(3)
    way = np.stack([np.linspace(-40, 40, 100), rng.normal(0.0, 1.5, 100)], axis=1)
    way[:8, 1] = 0.0
    at = places(draw(Hand(plane, HandSettings(ruler="straight")), way, pressure=0.5))
    np.testing.assert_allclose(at[:, 1], 0.0, atol=1e-6)
    assert at[-2, 0] == pytest.approx(40.0, abs=1.0)


def test_what_is_no_ruler_is_refused() -> None:
    with pytest.raises(InputError, match="ruler"):
        HandSettings(ruler="french curve")


STEADY = 0.3  # as a mouse is at first


def test_a_mouse_is_steadied_and_tapers_at_both_ends(plane) -> None:
    rng = np.random.default_rng(5)
    way = np.stack([np.linspace(-40, 40, 160), np.round(rng.normal(0, 0.7, 160))], axis=1)
    rough = draw(Hand(plane), way)
    smooth = draw(Hand(plane, HandSettings(mouse_smoothing=STEADY)), way)
    wobble = [np.abs(np.diff(places(s)[5:-15, 1])).mean() for s in (rough, smooth)]
    assert wobble[1] < 0.25 * wobble[0]
    pressures = np.array([s.pressure for s in smooth])
    full = pressures.max()
    assert pressures[0] == 0.0
    assert pressures[-1] == 0.0
    falls = pressures[-12:]
    assert (np.diff(falls) <= 1e-9).all()
    assert 0.0 < falls[4] < full
    assert (np.diff(falls[:-1], 2) <= 1e-9).all()  # rounded: no corner where it begins to fall
    assert falls[6] > 0.5 * full
    pens = [draw(Hand(plane, settings), way, pressure=0.5) for settings in
            (HandSettings(), HandSettings(mouse_smoothing=STEADY))]  # fmt: skip
    np.testing.assert_array_equal(places(pens[0]), places(pens[1]))


def swing(settings: HandSettings) -> float:
    """How far the edges of a mouse's stroke leave smooth curves, mm, in all but a twentieth of it.

    Of a hand that trembles, told in whole pixels of .29 mm, on porcelain.
    """
    document = Document.new("sheet:110x20", 0.4, material="porcelain")
    way = np.stack([np.linspace(-45.0, 45.0, 90), np.zeros(90)], axis=1)
    way = np.round((way + np.random.default_rng(1).normal(0.0, 0.15, way.shape)) / 0.29) * 0.29
    document.begin_stroke()
    document.feed(draw(Hand(ClosestPoints(document.surface.source), settings), way))
    document.end_stroke()
    mark, step = take_mark(document.surface), 0.5
    x, y = mark.points[:, 0], mark.points[:, 1]
    inner = np.abs(x) < 35.0
    place = np.floor((x[inner] + 35.0) / step).astype(int)
    swings = []
    for side in (y > 0.0, y < 0.0):
        edge = np.bincount(place, (mark.areas * mark.cover * side)[inner]) / step
        swings.append(np.abs(edge - savgol_filter(edge, 25, 3)))
    return float(np.percentile(swings, 95.0))


def test_the_edges_of_a_mouses_stroke_are_smooth() -> None:
    as_at_first = HandSettings(mouse_smoothing=STEADY)
    assert swing(as_at_first) < 0.1 < swing(HandSettings())


def test_a_mouse_is_steady_at_first_and_as_it_was_left() -> None:
    assert Settings().mouse_smoothing is None
    assert Settings(mouse_smoothing=0.7).mouse_steadiness == 0.7
    with pytest.raises(InputError, match="mouse_smoothing"):
        Settings(mouse_smoothing=2.0)


@pytest.fixture(scope="module")
def bowl(program):
    """A window with a bowl, seen from the front."""
    with opened(program, "vase", 4.0, "porcelain", drawn=False) as window:
        window.workspace.actions["look_front"].trigger()
        yield window


@pytest.fixture(autouse=True)
def bare(request) -> None:
    if "bowl" in request.fixturenames:
        window = request.getfixturevalue("bowl")
        while window.document.can_undo:
            window.stage.paint_thread.post("undo").result(300)
        window.panels.hand.set_ruler(False)
        settled(window)


def lead(window, start, end) -> np.ndarray:
    """Lead the mouse over the picture (shares of it); where the brush went, (N, 3) mm."""
    canvas, left = window.canvas, BUTTON.LeftButton
    size = np.array([canvas.width(), canvas.height()])
    way = np.linspace(np.array(start) * size, np.array(end) * size, 20)
    mouse(canvas, KIND.MouseMove, *way[0])
    mouse(canvas, KIND.MouseButtonPress, *way[0], left, left)
    for place in way:
        mouse(canvas, KIND.MouseMove, *place, buttons=left)
    mouse(canvas, KIND.MouseButtonRelease, *way[-1], left)
    settled(window)
    (stroke,) = window.document.strokes
    path = object_poses(stroke.samples)
    assert path.contact is not None
    return path.contact


def choose(window, kind: str) -> None:
    box = window.panels.hand.ruler
    box.setCurrentIndex(box.findData(kind))
    wait_for(lambda: window.hand.settings.ruler == kind)


def test_around_the_object_a_stroke_stays_level(bowl) -> None:
    choose(bowl, "ring")
    assert bowl.workspace.actions["ruler"].isChecked()
    at = lead(bowl, (0.42, 0.5), (0.58, 0.6))
    assert np.ptp(at[:, 2]) < 0.5
    assert np.ptp(at[:, 0]) > 10.0


def test_along_the_profile_it_keeps_its_side(bowl) -> None:
    choose(bowl, "profile")
    at = lead(bowl, (0.55, 0.35), (0.42, 0.6))
    angle = np.degrees(np.unwrap(np.arctan2(at[:, 1], at[:, 0])))
    assert np.ptp(angle) < 2.0
    assert np.ptp(at[:, 2]) > 15.0


def test_u_switches_the_ruler_on_and_off(bowl) -> None:
    type_key(bowl.canvas, KEY.Key_U)
    wait_for(lambda: bowl.hand.settings.ruler != "none")
    type_key(bowl.canvas, KEY.Key_U)
    wait_for(lambda: bowl.hand.settings.ruler == "none")


def test_a_mouse_presses_as_the_panel_says_and_the_panel_says_as_it_presses(bowl) -> None:
    panel, before = bowl.panels.hand, bowl.hand.force
    bowl.hand.set_settings(landing_s=0.0)  # the mouse is led at once
    try:
        panel.force.setValue(60)
        lead(bowl, (0.45, 0.4), (0.55, 0.5))
        (stroke,) = bowl.document.strokes
        assert max(sample.pressure for sample in stroke.samples) == pytest.approx(0.6)
        panel.by_speed.setChecked(True)
        assert bowl.hand.settings.pressure_by == bowl.workspace.settings.pressure_by == "speed"
        bowl.hand.set_force(0.2 * MAX_FORCE_N)  # as a wheel, a key or a drag has it
        wait_for(lambda: panel.force.value() == 20)
    finally:
        panel.by_speed.setChecked(False)
        bowl.hand.set_settings(landing_s=HandSettings().landing_s)
        bowl.hand.set_force(before)
