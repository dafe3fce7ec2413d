"""The mixtures that the brush was dipped in last: small dishes that dip it again, and are kept."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from paint3d.app.model.persistence.settings import Settings, load_settings, save_settings
from tests.support.app.gestures import live
from tests.support.app.windows import opened, settled

LEFT = QtCore.Qt.MouseButton.LeftButton


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sheet:120x120", 2.0, "xuan", drawn=False) as window:
        yield window


def mix(panel, *inks: str) -> None:
    panel.empty()
    for ink in inks:
        panel.stir(ink)


def shown(panel) -> int:
    return sum(button.isVisibleTo(panel.last) for button in panel.last.buttons)


def test_a_mixture_is_dipped_in_again_by_a_click(window) -> None:
    panel = window.panels.inks
    panel.show_last(())
    mix(panel, "cinnabar", "gamboge")
    panel.dip_mixture()
    mix(panel, "indigo", "gamboge", "gamboge")
    panel.dip_mixture()
    panel.dishes.taken.emit("pine soot")  # a pure ink has its own dish
    assert shown(panel) == 2
    assert "cinnabar 50 %" in panel.last.buttons[1].accessibleName()
    QtTest.QTest.mouseClick(panel.last.buttons[1], LEFT)
    settled(window)
    assert window.document.inks[0] == {"cinnabar": 0.5, "gamboge": 0.5}
    assert shown(panel) == 2  # moved to the head, not twice
    assert panel.last.mixtures[0] == {"cinnabar": 0.5, "gamboge": 0.5}
    assert window.workspace.settings.mixtures == tuple(panel.last.mixtures)
    live()


def test_one_goes_back_into_the_mixing_dish_with_its_water(window) -> None:
    panel = window.panels.inks
    panel.show_last([{"indigo": 0.2, "water": 0.8}])
    panel.empty()
    panel.last.asked_back.emit(0)
    assert panel.mixture() == pytest.approx({"indigo": 0.2, "water": 0.8})
    panel.stir("gamboge")  # and goes on from there
    assert panel.mixture()["gamboge"] == pytest.approx(panel.mixture()["indigo"])


def test_only_the_newest_are_kept_and_unknown_ones_wait_for_their_table(window) -> None:
    panel = window.panels.inks
    panel.show_last([{"my own red": 0.5, "water": 0.5}, {"indigo": 0.5, "water": 0.5}])
    assert shown(panel) == 1
    for k in range(12):
        panel.last.remember({"indigo": 1.0, "water": float(k)})
    assert len(panel.last.mixtures) == len(panel.last.buttons)
    assert panel.last.mixtures[0]["water"] == 11.0


def test_they_come_back_with_the_settings(tmp_path) -> None:
    mixtures = ({"indigo": 0.25, "water": 0.75}, {"cinnabar": 1.0, "gamboge": 2.0})
    save_settings(Settings(mixtures=mixtures), tmp_path)
    assert load_settings(tmp_path)[0].mixtures == mixtures
