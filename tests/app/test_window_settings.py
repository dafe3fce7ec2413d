"""What is chosen in the window is there with the next start, and has an effect."""

from __future__ import annotations

import sys

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from paint3d.app.model.persistence.settings import Settings, load_settings
from paint3d.app.window.questions import PreferencesDialog
from paint3d.app.window.studio import StudioWindow
from paint3d.app.window.wording import choose_unit, say_length
from paint3d.core.own_folders import config_folder
from tests.support.app.gestures import answer, live
from tests.support.app.windows import close_unasked, settled


@pytest.fixture(autouse=True)
def in_slots(monkeypatch: pytest.MonkeyPatch, tmp_path):
    """A settings file of its own; nothing may go wrong unseen in what Qt calls."""
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path / "config"))
    raised: list[BaseException] = []
    monkeypatch.setattr(sys, "excepthook", lambda kind, error, trace: raised.append(error))
    yield
    assert raised == []
    choose_unit("mm")


@pytest.fixture
def start(program):
    """Starts the window with what is kept, as the program does; closes the one before."""
    windows: list[StudioWindow] = []

    def end() -> None:
        while windows:
            window = windows.pop()
            close_unasked(window)

    def begin(target: str = "plane", **options: object) -> StudioWindow:
        end()
        settings, problem = load_settings()
        assert problem is None
        window = StudioWindow(program, settings)
        windows.append(window)
        window.show()
        window.workspace.quiet = True
        assert window.opening.open_path(target, asked=True, **options)
        live(0.05)
        return window

    yield begin
    end()


def test_brush_inks_and_force_lie_in_the_hand_again(start) -> None:
    window = start(resolution=3.0)
    assert window.document.painter.brush.name == "full"
    assert window.hand.hand.force == Settings().force_n
    window.stage.paint_thread.post("set_brush", "zhongkai")
    window.workspace.actions["larger"].trigger()
    window.panels.inks.dipped.emit({"indigo": 0.75, "water": 0.25}, None)
    window.workspace.actions["swap_inks"].trigger()
    window.panels.inks.dipped.emit("gamboge", None)
    settled(window)
    window.hand.hand.force = 3.25
    brush, inks = window.document.painter.brush, list(window.document.inks)
    window = start(resolution=3.0)
    assert window.document.painter.brush == brush
    assert [window.document.inks[k] for k in (0, 1)] == inks
    assert window.hand.hand.force == 3.25
    window.stage.paint_thread.post("set_brush", "gongbi")
    settled(window)
    assert window.opening.open_path("sphere", 3.0, asked=True)  # not only when it is closed
    assert window.document.painter.brush.name == "gongbi"


@pytest.mark.usefixtures("wet_at_first")
def test_ink_spreads_as_was_chosen_and_else_as_the_material_asks(start) -> None:
    window = start(resolution=4.0, material="xuan")
    assert window.workspace.actions["wet"].isChecked()
    assert window.stage.paint_thread.wet
    window.opening.open_path("plane", 4.0, "porcelain", asked=True)
    assert not window.workspace.actions["wet"].isChecked()
    assert not window.stage.paint_thread.wet
    assert load_settings()[0].wet is None  # nobody has chosen
    window.opening.open_path("plane", 4.0, "xuan", asked=True)
    window.workspace.actions["wet"].trigger()
    assert load_settings()[0].wet is False
    window = start(resolution=4.0, material="xuan")
    assert not window.stage.paint_thread.wet
    assert not window.workspace.actions["wet"].isChecked()


def test_size_place_and_panels_come_back(start) -> None:
    window = start(resolution=4.0)
    window.setGeometry(60, 50, 1130, 720)
    window.panels.docks["layers"].hide()
    window.panels.docks["inks"].raise_()
    live(0.1)
    place = window.geometry()
    window = start(resolution=4.0)
    assert window.geometry().size() == place.size()
    assert (window.geometry().topLeft() - place.topLeft()).manhattanLength() < 40
    assert not window.panels.docks["layers"].isVisible()
    assert window.panels.docks["history"].isVisible()
    assert not window.panels.inks.visibleRegion().isEmpty()
    assert window.panels.brushes.visibleRegion().isEmpty()


@pytest.mark.parametrize(
    "words", [{"geometry": "%%", "panels": "x"}, {"geometry": 3, "panels": []}]
)
def test_a_window_that_cannot_be_placed_as_it_was_is_placed_anew(program, words) -> None:
    window = StudioWindow(program, Settings(window=words))
    window.show()
    live(0.05)
    assert window.width() > 800
    window.close()


def test_material_and_fineness_are_those_that_were_chosen_last(start) -> None:
    window = start(resolution=4.0)

    def begin(dialog) -> None:
        dialog.choose("plane")
        dialog.material.setCurrentIndex(dialog.material.findData("bisque"))
        dialog.resolution.setValue(3.5)
        dialog.accept()

    answer(begin)
    window.workspace.actions["new"].trigger()
    window = start()  # as a file that is dropped, or the first object
    assert window.document.surface.material.name == "bisque"
    assert window.document.surface.resolution == 3.5


def test_preferences_have_an_effect_now_and_with_the_next_start(start) -> None:
    window = start(resolution=4.0)
    assert window.panels.brushes.length_label.text() == "35 mm"

    def choose(dialog: PreferencesDialog) -> None:
        dialog.boxes["unit"].setCurrentIndex(dialog.boxes["unit"].findData("cm"))
        dialog.boxes["wet"].setCurrentIndex(dialog.boxes["wet"].findData(True))
        dialog.numbers["autosave_s"].setValue(45.0)
        dialog.numbers["undo_megabytes"].setValue(64.0)
        dialog.accept()

    answer(choose)
    window.workspace.actions["preferences"].trigger()
    assert window.panels.brushes.length_label.text() == "3.5 cm"
    assert say_length(120.0) == "12 cm"
    assert window.workspace.actions["wet"].isChecked()
    assert window.stage.paint_thread.wet
    assert window.stage.paint_thread.autosave_interval_s == 45.0
    window = start(resolution=4.0)
    assert window.panels.brushes.length_label.text() == "3.5 cm"
    assert window.stage.paint_thread.autosave_interval_s == 45.0
    assert window.stage.paint_thread.wet
    assert window.document.steps.memory_budget == 64 << 20


def test_every_setting_that_is_kept_is_read_by_something() -> None:
    """No name in the settings file without a reader beside `Settings` itself."""
    import dataclasses
    from pathlib import Path

    import paint3d

    folder = Path(paint3d.__file__).parent / "app"
    files = [file for file in folder.rglob("*.py") if file.name != "settings.py"]
    text = "\n".join(file.read_text(encoding="utf-8") for file in files)
    for own in dataclasses.fields(Settings):
        name = {"pressure_curve": "curve"}.get(own.name, own.name)
        name = {"wet": "wants_wet"}.get(name, name)
        assert f"settings.{name}" in text, own.name


def test_a_folder_that_cannot_be_written_is_told_and_nothing_stops(
    start, monkeypatch: pytest.MonkeyPatch
) -> None:
    window = start(resolution=4.0)
    folder = config_folder()
    monkeypatch.setenv("PAINT3D_CONFIG", "/proc/none")
    window.workspace.update_settings(theme="light")
    assert "cannot be made" in window.status.message_label.text()
    monkeypatch.setenv("PAINT3D_CONFIG", str(folder))
    window.workspace.update_settings(theme="dark")
    assert (folder / "settings.json").is_file()
