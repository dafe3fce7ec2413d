"""The brush editor, brushes of one's own and brush files, in the real window."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from paint3d.app.model.brush_in_hand import BRUSH_COMMANDS, brush_after
from paint3d.app.model.input.hand import Hand, PointerInput
from paint3d.app.model.paint_thread import PaintThread
from paint3d.brush.presets import load_brush
from paint3d.mesh.bvh import ClosestPoints
from tests.support.app.hands import small_plane

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

from paint3d.app.model.commands import decode_command, encode_command
from paint3d.app.model.document import Document
from paint3d.app.model.persistence.brush_words import brush_from_words, brush_words
from paint3d.app.model.persistence.own_brushes import (
    keep_brush,
    own_brush_folder,
    own_brush_path,
    own_brushes,
)
from paint3d.app.model.persistence.saved_settings import chosen_brush, in_hand
from paint3d.app.model.persistence.settings import Settings
from paint3d.app.model.score.playing import painted
from paint3d.app.window.brush import brush_editor, brush_panel
from paint3d.app.window.brush.brush_editor import changed, range_of, value_of
from paint3d.app.window.previews import sorted_parts, stroke_preview
from paint3d.app.window.studio import StudioWindow
from paint3d.app.window.wording import choose_language, say_brush
from paint3d.brush.presets import brush_names
from paint3d.brush.spec import BristleSpec, shape_rows
from paint3d.colour.pigments import load_pigment
from paint3d.errors import BrushError
from paint3d.view.brush_shape import draw_stroke
from tests.support.app.gestures import KIND, drag, live, mouse, pen_stroke, wait_for
from tests.support.app.windows import close_unasked, faults, opened, settled

KEY, BUTTON, NO_KEY = QtCore.Qt.Key, QtCore.Qt.MouseButton, QtCore.Qt.KeyboardModifier.NoModifier
ROWS = (*brush_editor.TUFT, *brush_editor.FORCE, *brush_editor.OF_HAIRS)
TABLE = shape_rows([(0.0, 0.5, 0.6, 0.1, 0.4, 0.6, 10.0), (30.0, 0.4, 0.5, 0.0, 0.5, 0.2, 5.0)])


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path / "config"))
    monkeypatch.setenv("PAINT3D_STATE", str(tmp_path / "state"))
    return own_brush_folder()


def type_in(box: QtWidgets.QWidget, text: str) -> None:
    """Write into a box with the keys, and press Enter; turn to its page first."""
    box.window().activateWindow()
    wait_for(box.isActiveWindow)
    page = box.parentWidget()
    while page is not None and not isinstance(page.parentWidget(), QtWidgets.QStackedWidget):
        page = page.parentWidget()
    if page is not None and not page.isVisible():
        page.parentWidget().parentWidget().setCurrentWidget(page)
        live(0.02)
    box.setFocus()
    box.selectAll()
    QtTest.QTest.keyClicks(box, text)
    QtTest.QTest.keyClick(box, KEY.Key_Return)


def click(widget: QtWidgets.QWidget, place: QtCore.QPoint | None = None, button=BUTTON.LeftButton):
    QtTest.QTest.mouseClick(widget, button, NO_KEY, place or widget.rect().center())


def drawn(editor: brush_editor.BrushEditor) -> tuple[bytes, bytes]:
    """What is shown of footprints and stroke, once it has been drawn."""
    wait_for(lambda: not editor.drawing.is_busy)
    live(0.02)
    images = (p.pixmap().toImage() for p in (editor.footprints, editor.stroke))
    footprints, stroke = (bytes(image.constBits()) for image in images)
    return footprints, stroke


def test_a_brush_is_changed_kept_painted_with_and_there_the_next_time(program, own_folder) -> None:
    with opened(program, drawn=False) as window:
        click(window.findChild(QtWidgets.QPushButton, "edit_brush"))
        editor = window.brushes.editor
        assert editor.isVisible()
        before = drawn(editor)
        type_in(editor.rows["root_diameter_mm"].box, "5")
        assert editor.brush.root_diameter_mm == 5.0
        after = drawn(editor)
        assert before[0] != after[0]
        assert before[1] != after[1]
        editor.tabs.setCurrentIndex(2)
        click(editor.single, QtCore.QPoint(8, editor.single.height() // 2))
        type_in(editor.rows["n_hairs"].box, "40")
        editor.rows["hair_mm"].slider.setFocus()
        QtTest.QTest.keyClick(editor.rows["hair_mm"].slider, KEY.Key_End)
        editor.tabs.setCurrentIndex(3)
        live(0.05)
        click(editor.curve, editor.curve.place(0.5, 3.0).toPoint())
        click(editor.curve, editor.curve.place(0.9, 0.5).toPoint())
        type_in(editor.name_box, "wolf 1")
        click(editor.keep)
        settled(window)
        wanted = editor.brush
        assert (wanted.bristles.n_hairs, wanted.bristles.hair_mm) == (40, 2.0)
        ((setting, ((name, points),)),) = wanted.inputs
        assert (setting, name) == ("stiffness", "pressure")
        assert np.allclose(points, [(0.5, 3.0), (0.9, 0.5)], rtol=0.05)
        kept = window.document.painter.brush
        assert kept == dataclasses.replace(wanted, name="wolf 1")
        assert window.panels.brushes.brush == kept
        assert load_brush(str(own_folder / "wolf_1.toml")) == kept
        chosen = in_hand(kept, ["pine soot"])
        editor.close()
    settings = Settings(brush=chosen["brush"], brush_mm=chosen["brush_mm"])
    assert chosen_brush(settings) == kept
    with opened(program, settings=settings, drawn=False) as window:
        shown = window.findChild(QtWidgets.QListWidget, "brushes")
        assert shown.currentItem().text().startswith("wolf 1")
        assert window.document.painter.brush == kept


def test_out_of_range_and_bad_names_are_told_in_the_editor(program) -> None:
    with opened(program, drawn=False) as window:
        window.workspace.actions["edit_brush"].trigger()
        editor = window.brushes.editor
        type_in(editor.rows["hardness"].box, "0.5")
        assert editor.brush.hardness == 0.5
        for name, told in (("full", "a brush that comes with the program"), ("", "expected 1 to")):
            editor.name_box.setText(name)
            click(editor.keep)
            assert told in editor.message_label.text()
        assert own_brushes() == ({}, [])
        click(editor.again)
        assert editor.brush == editor.begun == load_brush("full")
        type_in(editor.rows["length_mm"].box, "70")
        assert editor.brush.root_diameter_mm == pytest.approx(28.0)  # all that is a length
        assert editor.rows["tip_segment_mm"].range.text() == "1.6 – 2.8"
        editor.close()


def test_strokes_of_an_edited_brush_are_undone_kept_and_painted_again_from_the_score(
    program, tmp_path: Path
) -> None:
    brush = dataclasses.replace(
        load_brush("full"), name="mine", taper=0.9, bristles=BristleSpec(30, TABLE),
        inputs={"load": {"speed": [[0, 1.0], [300, 0.4]]}},
    )  # fmt: skip
    other = dataclasses.replace(brush, taper=0.6)  # of the same name
    with opened(program, drawn=False) as window:
        for row, one in ((0.45, brush), (0.6, other)):
            window.workspace.post("set_brush", one)
            settled(window)
            pen_stroke(window.canvas, (0.42, row), (0.55, row), [0.1, *[0.5] * 8, 0.0])
            settled(window)
        document = window.document
        assert [stroke.brush for stroke in document.strokes] == [brush, other]
        srgb = document.surface.srgb.copy()
        again = painted(document.score, document.surface.source)
        assert np.array_equal(again.surface.srgb, srgb)
        document.save(tmp_path / "a.p3d")
        window.workspace.actions["undo"].trigger()
        settled(window)
        assert [stroke.brush for stroke in document.strokes] == [brush]
        assert not np.array_equal(document.surface.srgb, srgb)
    loaded = Document.open(tmp_path / "a.p3d")
    assert loaded.painter.brush == other
    assert [stroke.brush for stroke in loaded.strokes] == [brush, other]


def test_a_command_carries_a_brush_with_its_own_table() -> None:
    brush = dataclasses.replace(load_brush("feibai"), name="mine", bristles=BristleSpec(30, TABLE))
    document = Document.new("plane", 5.0)
    line = json.loads(json.dumps(encode_command(document, "set_brush", [brush], {})))
    assert decode_command(line, document.surface) == ("set_brush", [], {"brush": brush})


def test_a_brush_is_the_same_in_the_words_of_json() -> None:
    brush = dataclasses.replace(load_brush("feibai"), name="mine", bristles=BristleSpec(30, TABLE))
    assert brush_from_words(json.loads(json.dumps(brush_words(brush)))) == brush


@pytest.mark.parametrize("name", [row[0] for row in ROWS if row[0] != "max_force"])
def test_every_control_changes_what_is_painted(name: str) -> None:
    brush = load_brush("feibai")
    low, high = range_of(brush, name)
    value = value_of(brush, name)
    other = high if high - value > value - low else low
    other = {"length_mm": 60.0, "n_hairs": 60}.get(name, other)
    other = int(other) if name == "n_segments" else other
    before, after = (
        draw_stroke(one, "pine soot", columns=132) for one in (brush, changed(brush, name, other))
    )
    assert not np.array_equal(before, after)


def test_the_greatest_force_is_felt() -> None:
    brush = load_brush("full")
    assert changed(brush, "max_force", 15.8).spring == pytest.approx(2.0 * brush.spring)


def test_a_brush_file_is_opened_and_a_bad_one_told_in_one_line(
    program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good, bad = tmp_path / "mine.toml", tmp_path / "bad.toml"
    good.write_text('base = "slender"\nhardness = 0.4\n', encoding="utf-8")
    bad.write_text('base = "slender"\nhardness = 4\n', encoding="utf-8")
    with opened(program, drawn=False) as window:
        button = window.findChild(QtWidgets.QPushButton, "open_brush")
        for path in (good, bad):
            monkeypatch.setattr(
                "paint3d.app.window.brush.brush_making.ask_file", lambda *_, path=path: str(path)
            )
            click(button)
            settled(window)
            assert window.document.painter.brush == load_brush(str(good))
        labels = [w.text() for w in window.statusBar().findChildren(QtWidgets.QLabel)]
        assert any("hardness is 4; expected 0.3 to 0.7" in text for text in labels)


def test_a_bad_file_among_ones_own_is_told_and_the_others_listed(own_folder: Path) -> None:
    keep_brush(dataclasses.replace(load_brush("full"), name="one/two"))
    keep_brush(dataclasses.replace(load_brush("full"), name="one two", taper=0.7))
    keep_brush(dataclasses.replace(load_brush("full"), name="one/two", taper=0.8))
    (own_folder / "z.toml").write_text('base = "fulll"', encoding="utf-8")
    found, problems = own_brushes()
    assert {name: brush.taper for name, brush in found.items()} == {"one/two": 0.8, "one two": 0.7}
    assert len(problems) == 1
    assert "z.toml: base is 'fulll'" in problems[0]
    with pytest.raises(BrushError, match="comes with the program"):
        keep_brush(load_brush("full"))


def test_a_brush_in_a_file_of_another_name_is_kept_there(own_folder: Path) -> None:
    """And one in .json gives way to what was kept of it later."""
    own_folder.mkdir(parents=True)
    (own_folder / "foo.toml").write_text('base = "full"\nname = "mine"', encoding="utf-8")
    (own_folder / "a.json").write_text('{"base": "full", "name": "jay"}', encoding="utf-8")
    assert own_brush_path("mine") == own_folder / "foo.toml"
    assert own_brush_path("jay") == own_folder / "a.json"
    for name in ("mine", "jay"):
        keep_brush(dataclasses.replace(own_brushes()[0][name], taper=0.7))
    found, problems = own_brushes()
    assert {name: brush.taper for name, brush in found.items()} == {"mine": 0.7, "jay": 0.7}
    assert own_brush_path("jay") == own_folder / "jay.toml"
    assert len(problems) == 1  # that there is another jay
    assert "a.json: another brush is called 'jay'" in problems[0]


def test_numbers_are_shown_with_their_units_and_ranges(program) -> None:
    with opened(program, drawn=False) as window:
        window.workspace.actions["edit_brush"].trigger()
        rows = window.brushes.editor.rows
        shown = {name: (row.box.text(), row.range.text()) for name, row in rows.items()}
        assert shown["length_mm"] == ("35 mm", "5 – 200")
        assert shown["hardness"] == ("0.7", "0.3 – 0.7")
        assert shown["n_segments"] == ("9", "8 – 13")
        assert shown["n_hairs"] == ("1000", "1 – 10000")
        assert shown["load"] == ("6000 mm²", "1 – 10⁷")
        assert shown["transfer_per_mm"] == ("0.006", "10⁻⁶ – 1")
        type_in(rows["transfer_per_mm"].box, "0.00025")
        assert window.brushes.editor.brush.transfer_per_mm == 0.00025
        window.brushes.editor.close()


def test_a_brush_may_be_called_like_a_text_of_the_window(program) -> None:
    """One text wants a number; `Close` has another in Chinese."""
    brush = dataclasses.replace(load_brush("full"), name="{count} lost")
    with opened(program) as window:
        window.workspace.post("set_brush", brush)
        settled(window)
        pen_stroke(window.canvas, (0.42, 0.5), (0.55, 0.5), [0.1, *[0.5] * 8, 0.0])
        settled(window)
        window.grab()  # the plate in the picture's corner is painted
        history = window.panels.history.list
        wait_for(lambda: history.count() == 1)
        assert "{count} lost" in history.item(0).text()
    choose_language("zh")
    try:
        assert say_brush("Close") == "Close"
        assert say_brush("full") != "full"
    finally:
        choose_language("en")


def test_another_size_of_a_preset_is_not_called_like_it(program) -> None:
    with opened(program, drawn=False) as window:
        window.workspace.post("resize_brush", 50.0)
        settled(window)
        window.workspace.actions["edit_brush"].trigger()
        editor = window.brushes.editor
        taken = []
        editor.taken.connect(taken.append)
        assert editor.brush.length_mm == 50.0
        editor.name_box.setText("full")
        click(editor.take)
        assert "a brush that comes with the program" in editor.message_label.text()
        assert taken == []
        editor.close()


@pytest.mark.long
def test_the_editors_stroke_is_in_the_ink_in_hand(program) -> None:
    with opened(program, drawn=False) as window:
        window.workspace.actions["edit_brush"].trigger()
        editor = window.brushes.editor
        footprints, black = drawn(editor)
        window.panels.inks.dishes.taken.emit("cinnabar")
        settled(window)
        again, red = drawn(editor)
        assert again == footprints
        assert red != black
        click(editor.leave)
        window.panels.inks.dishes.taken.emit("pine soot")  # the closed editor draws nothing
        settled(window)
        assert not editor.drawing.is_busy


# -- the brush that the hand asked for ---------------------------------------------------------


MS = 1_000_000


def write(paint_thread, hand, y, pressure=0.4):
    """A line of 40 mm, with the brush that the painting thread says."""
    place, down = (-20.0, y, 90.0), (0.0, 0.0, -1.0)
    event = PointerInput(MS, origin=place, direction=down, pressure=pressure)
    samples = list(hand.begin(event, paint_thread.brush))
    for k in range(1, 20):
        place = (-20.0 + 2.0 * k, y, 90.0)
        event = PointerInput(8 * MS * k, origin=place, direction=down, pressure=pressure)
        samples += hand.move(event, paint_thread.brush)
    samples += hand.end(160 * MS, paint_thread.brush)
    paint_thread.post("begin_stroke")
    paint_thread.feed(samples)
    paint_thread.post("end_stroke")


@pytest.mark.parametrize(
    "change",
    [("set_brush", "gongbi"), ("scale_brush", 0.5), ("step_brush", -4), ("resize_brush", 20.0),
     ("dip", "cinnabar"), ("add_layer", "over")],
)  # fmt: skip
def test_a_stroke_right_after_a_change_is_painted_as_after_waiting(change):
    shown = []
    for held in (True, False):
        document = small_plane()
        paint_thread = PaintThread(document)
        hand = Hand(ClosestPoints(document.surface.source))
        write(paint_thread, hand, -20.0)
        if held:
            with paint_thread.paused():  # the painting is behind
                before = paint_thread.brush
                paint_thread.post(*change)
                asked = paint_thread.brush
                assert (asked != before) == (change[0] in BRUSH_COMMANDS)
                write(paint_thread, hand, 20.0)
        else:
            paint_thread.post(*change).result()
            write(paint_thread, hand, 20.0)
        paint_thread.post("refresh").result()
        paint_thread.stop()
        assert not held or document.painter.brush == asked
        surface = document.surface
        order = np.lexsort(surface.paint_mesh.vertices.T)
        there = surface.paint_mesh.vertices[:, 1] > 10
        assert surface.painted[there].sum() > 20
        shown.append((surface.srgb[order], [s.brush for s in document.strokes]))
    np.testing.assert_array_equal(shown[0][0], shown[1][0])
    assert shown[0][1] == shown[1][1]


def test_what_is_refused_is_not_taken():
    brush = load_brush("full")
    assert brush_after(brush, "set_brush", ["no such brush"]) == brush
    assert brush_after(brush, "scale_brush", [1000.0]) == brush
    assert brush_after(brush, "set_brush", []) == brush
    paint_thread = PaintThread(small_plane())
    paint_thread.post("begin_stroke")
    with paint_thread.paused():
        asked = paint_thread.post("set_brush", "gongbi")
    with pytest.raises(Exception, match="during a stroke"):
        asked.result()
    assert paint_thread.brush == paint_thread.painting.brush == small_plane().painter.brush
    paint_thread.stop()


# -- previews ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def window(program):
    with opened(program, drawn=False) as window:
        yield window


@pytest.mark.long
def test_a_mixture_that_was_picked_up_is_shown_in_the_previews(window) -> None:
    window.panels.inks.dipped.emit({"indigo": 0.8, "water": 0.2}, None)
    drag(window.canvas, (0.45, 0.5), (0.55, 0.5))
    settled(window)
    mouse(window.canvas, KIND.MouseMove, 0.5 * window.canvas.width(), 0.5 * window.canvas.height())
    with faults() as found:
        window.workspace.actions["pick_colour"].trigger()
        settled(window)
        picked = window.document.inks[0]
        assert {pigment.name for pigment in picked} == {"indigo", "water"}
        wait_for(lambda: not window.panels.brushes.is_busy)
        live(0.3)
    assert found == []
    assert window.panels.ink_name() in ("indigo + water", "water + indigo")


def test_previews_are_painted_when_the_window_waits_for_nothing(program, monkeypatch) -> None:
    """An object is opened sooner, and no ink is shown that is not the one in use."""
    inks: list[object] = []
    monkeypatch.setattr(
        brush_panel,
        "stroke_preview",
        lambda brush, ink: inks.append(ink) or stroke_preview(brush, ink),
    )
    window = StudioWindow(program)
    try:
        window.show()
        window.workspace.quiet = True
        assert window.opening.open_path("plane", 3.0, "xuan", asked=True)
        assert inks == []
        wait_for(lambda: not window.panels.brushes.is_busy)
        assert inks == [window.document.inks[0]] * len(brush_names())
    finally:
        close_unasked(window)


def test_a_preview_is_the_same_by_name_and_by_ink() -> None:
    brush = load_brush("xiaokai")
    names = {"indigo": 0.7, "water": 0.3}
    inks = {load_pigment(name): part for name, part in reversed(names.items())}
    assert [part for _, part in sorted_parts(names)] == [part for _, part in sorted_parts(inks)]
    assert (stroke_preview(brush, names) == stroke_preview(brush, inks)).all()


def test_clear_water_is_drawn_as_a_wash() -> None:
    pixels = stroke_preview(load_brush("dakai"), "water").astype(int)
    sheet = pixels[0, 0]
    assert 15 < np.abs(pixels - sheet).max() < 150


def test_previews_that_fail_are_told_once_and_the_timer_rests(window, monkeypatch) -> None:
    def fail(brush, ink):
        raise ValueError("no preview today")

    monkeypatch.setattr(brush_panel, "stroke_preview", fail)
    told: list[str] = []
    window.panels.brushes.failed.connect(told.append)
    with faults() as found:
        for ink in ("azurite", "cinnabar"):
            window.panels.brushes.set_ink(ink)
            wait_for(lambda: not window.panels.brushes.is_busy)
            live(0.4)
    assert found == []
    assert told == ["ValueError: no preview today"]
    assert "no preview today" in window.status.message_label.text()
    monkeypatch.undo()
    window.panels.brushes.set_ink("pine soot")
    wait_for(lambda: not window.panels.brushes.is_busy)


def test_a_fault_in_every_tick_is_told_once_and_the_window_lives(window, monkeypatch) -> None:
    ticks: list[int] = []

    def fail() -> None:
        ticks.append(1)
        raise ValueError("nothing goes")

    before = window.tick
    monkeypatch.setattr(window, "tick", fail)
    with faults() as found:
        wait_for(lambda: len(ticks) > 5)
        assert found == ["ValueError: nothing goes"]
        assert "nothing goes" in window.status.message_label.text()
        monkeypatch.setattr(window, "tick", before)
        drag(window.canvas, (0.45, 0.4), (0.55, 0.4))
        settled(window)
        assert len(found) == 1
