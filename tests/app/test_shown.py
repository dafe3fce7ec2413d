"""What the window shows of brush, ink, surface and itself."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.brush_in_hand import resized
from paint3d.app.model.commands import TOOLS
from paint3d.app.model.frame import held_ink, ink_srgb
from paint3d.app.window.brush.brush_panel import BrushPanel
from paint3d.app.window.hud import PLATE_ALPHA
from paint3d.app.window.theme import DARK_THEME, LIGHT_THEME
from paint3d.app.window.wording import choose_language, say_length
from paint3d.brush.presets import brush_names
from paint3d.colour.pigments import WATER, load_pigment
from paint3d.view.live_picture import LivePicture
from tests.support.app.gestures import HAND, KIND, answer, live, mouse, type_key, wait_for
from tests.support.app.pointers import Touching
from tests.support.app.windows import faults, opened, settled


@pytest.fixture(autouse=True, scope="module")
def few_pictures() -> None:
    """Pictures are drawn here as often as users see them."""


@pytest.fixture(scope="module")
def window(program):
    with opened(program) as window:
        yield window


@pytest.fixture
def fresh(program):
    """A window that nobody has touched."""
    with opened(program) as window:
        yield window


def held(window):
    return held_ink(window.document.painter)


def disc(window) -> np.ndarray:
    """(3,) mean colour of the ink's disc over the picture."""
    canvas = window.canvas
    shot = canvas.grab().toImage()
    ratio = canvas.devicePixelRatioF()
    x, y = 14 + 9 + 16, canvas.height() - 1 - 14 - 46 + 7 + 24
    colour = shot.pixelColor(round(x * ratio), round(y * ratio))
    return np.array([colour.red(), colour.green(), colour.blue()])


def test_the_ink_in_the_brush_is_shown_before_the_pointer_came(fresh) -> None:
    assert fresh.stage.frame is None or fresh.stage.frame.brush is None
    assert held(fresh).fraction == pytest.approx(1.0)
    assert fresh.hud.describe(held(fresh)) == "ink 100 %  ·  pine soot 26 % + water 74 %"
    assert disc(fresh).max() < 90


def test_what_keys_change_is_shown_though_no_pointer_is_over_the_picture(fresh) -> None:
    """Nothing else is drawn then: the canvas is looked at as it was painted, not painted anew."""
    window, canvas, painted = fresh, fresh.canvas, []
    mouse(canvas, KIND.MouseMove, 0.5 * canvas.width(), 0.5 * canvas.height())
    settled(window)
    QtWidgets.QApplication.sendEvent(canvas, QtCore.QEvent(KIND.Leave))
    settled(window)

    def watch(painter, area) -> None:
        painted.append(held(window).fraction)

    canvas.overlays.append(watch)
    try:
        for key, share in ((QtCore.Qt.Key.Key_R, 0.0), (QtCore.Qt.Key.Key_D, 1.0)):
            live(0.5)
            wait_for(lambda: window.stage.is_drawn)
            type_key(canvas, key)
            settled(window)
            wait_for(lambda share=share: painted[-1:] == [pytest.approx(share)])
    finally:
        canvas.overlays.remove(watch)


def test_all_inks_of_a_mixture_are_named_and_shown_in_their_colour(window) -> None:
    window.panels.inks.dipped.emit({"indigo": 0.2, "water": 0.8}, None)
    window.panels.inks.dipped.emit("pine soot", 0.35)
    settled(window)
    told = window.hud.describe(held(window))
    assert all(name in told for name in ("water", "pine soot", "indigo"))
    assert len(held(window).bands) == 2
    window.panels.inks.dipped.emit({"pine soot": 0.05, "water": 0.95}, None)
    settled(window)
    assert disc(window).min() > 180  # water with a little soot is no black
    window.panels.inks.dipped.emit("indigo", None)
    settled(window)
    red, _, blue = disc(window)
    assert blue > red + 80
    window.workspace.post("rinse")
    settled(window)
    assert window.hud.describe(held(window)) == "ink 0 %"
    window.panels.inks.dipped.emit("pine soot", None)
    settled(window)


def test_ink_on_hair_lets_the_hair_through_where_it_is_thin() -> None:
    soot = load_pigment("pine soot")
    dry = ink_srgb((soot, WATER), (0.0, 1.0), on_hair=True)
    thin = ink_srgb((soot, WATER), (0.05, 0.95), on_hair=True)
    full = ink_srgb((soot, WATER), (1.0, 0.0), on_hair=True)
    assert sum(dry) > sum(thin) > 400 > 3 * 70 > sum(full)


def test_the_title_says_what_is_painted_on(window) -> None:
    assert window.windowTitle() == "Plane, Xuan paper, 200 × 200 mm[*] – paint3d"


@pytest.mark.parametrize(
    ("mm", "told"),
    [(0.4, "0.4 mm"), (12.345, "12.3 mm"), (999.7, "1000 mm"), (25400.0, "25400 mm")],
)
def test_large_lengths_are_told_in_plain_digits(mm, told) -> None:
    assert say_length(mm) == told


def test_no_more_pictures_a_second_are_told_than_are_drawn(window) -> None:
    seen = []
    for k in range(30):
        mouse(window.canvas, KIND.MouseMove, 300 + k, 300)
        live(0.02)
        seen.append(window.status.state.text())
    told = {float(text.split("·")[1].split()[0]) for text in seen if "·" in text}
    assert told
    assert max(told) <= 1000 / 12  # the window looks for something new every 12 ms


def test_a_small_picture_does_not_stand_for_all(window) -> None:
    drawn = LivePicture(window.stage.scene, lambda most: False)
    for _ in range(10):
        drawn.touch()
        drawn.draw()
    whole = drawn.picture_s
    drawn.touch_front((0, 0, 1, 1))
    drawn.draw()
    assert drawn.picture_s > 0.5 * whole
    window.stage.touch()


def test_how_far_a_job_is_can_be_read_on_its_bar(window) -> None:
    bar = QtWidgets.QProgressBar(window)
    bar.resize(360, 16)
    bar.setValue(90)
    bar.show()
    live(0.05)
    shot = bar.grab().toImage()
    bar.hide()
    ground = shot.pixelColor(shot.width() // 5, shot.height() // 2)
    ink = window.palette().color(QtGui.QPalette.ColorRole.WindowText)
    assert abs(ground.lightness() - ink.lightness()) > 100


def test_the_picture_stays_where_it_is_while_the_brush_changes_its_size(window) -> None:
    before = window.document.painter.brush
    window.resize(1280, 800)
    live(0.1)
    widths = set()
    for length in (35.0, 45.2, 88.9, 120.0, 5.25):
        window.workspace.post("set_brush", resized(before, length))
        settled(window)
        live(0.1)
        widths.add(window.canvas.width())
    window.workspace.post("set_brush", before)
    settled(window)
    assert len(widths) == 1


def test_the_picture_stays_where_it_is_while_numbers_grow(window) -> None:
    window.resize(1280, 800)
    live(0.1)
    width, panels = window.canvas.width(), window.panels
    panels.history.count.setText("Strokes: 12345, 98765.4 s")
    panels.surface.fineness.setText("0.4 mm  ·  12,345,678 vertices")
    live(0.1)
    assert window.canvas.width() == width
    needed = panels.history.count.fontMetrics().horizontalAdvance(panels.history.count.text())
    assert panels.docks["history"].width() > needed  # it is there to be read


def test_grips_of_sliders_are_seen_whole(window) -> None:
    style = QtWidgets.QStyle
    for slider in window.findChildren(QtWidgets.QSlider):
        for dock in window.panels.docks.values():
            if dock.isAncestorOf(slider):
                dock.raise_()
        live(0.05)
        option = QtWidgets.QStyleOptionSlider()
        slider.initStyleOption(option)
        grip = slider.style().subControlRect(
            style.ComplexControl.CC_Slider, option, style.SubControl.SC_SliderHandle, slider
        )
        assert slider.rect().contains(grip), (slider.rect(), grip)
        assert grip.height() >= grip.width()


def test_rows_of_brushes_are_as_high_before_their_strokes_are_painted(program) -> None:
    panel = BrushPanel(LIGHT_THEME)
    view = panel.findChild(QtWidgets.QListWidget, "brushes")
    try:
        before = view.sizeHintForRow(0)
        wait_for(lambda: not panel.is_busy)
        assert before == view.sizeHintForRow(0) >= view.iconSize().height()
    finally:
        panel.close_down()


def test_brushes_are_named_in_the_menu_and_all_can_be_chosen(window) -> None:
    texts = [action.text() for action in window.commands.menus["brush"].actions()]
    assert set(brush_names()) <= set(texts)
    assert not any(text.startswith("Brush ") for text in texts)
    for k, name in enumerate(brush_names(), 1):
        action = window.workspace.actions[f"brush_{k}"]
        assert (action.text(), len(action.shortcuts())) == (name, 1)
    window.workspace.actions[f"brush_{len(brush_names())}"].trigger()
    settled(window)
    assert window.document.painter.brush.name == brush_names()[-1]
    window.workspace.post("set_brush", "full")
    settled(window)


def test_the_surface_is_told_in_numbers_that_look_like_nothing_else(window) -> None:
    panel = window.panels.surface
    assert not panel.findChildren(QtWidgets.QProgressBar)
    numbers = [label.text() for label in panel.findChildren(QtWidgets.QLabel)]
    assert {"100 %", "50 %", "0 %"} <= set(numbers)


@pytest.mark.parametrize("size", [(1280, 800), (1280, 720), (1100, 620), (960, 600)])
def test_no_tool_is_lost_in_a_low_window(window, size) -> None:
    before = window.size()
    window.resize(*size)
    live(0.2)
    room = window.commands.tools.rect()
    for name in set(TOOLS) - {"-"}:
        button = window.commands.tools.widgetForAction(window.workspace.actions[name])
        assert button.isVisible(), name
        assert room.contains(button.geometry()), name
    for dock in ("brushes", "inks", "layers"):
        window.panels.docks[dock].raise_()
    assert window.size().height() <= size[1]
    window.resize(before)
    live(0.1)


def test_the_status_can_be_read_right_after_the_theme_has_changed(window) -> None:
    window.workspace.tell("all is well", state="good")
    window.workspace.actions["dark"].setChecked(True)
    for label in (window.status.message_label, window.status.state):
        assert window.workspace.theme.name == "dark"
        assert any(
            colour in label.styleSheet()
            for colour in (
                window.workspace.theme.good,
                window.workspace.theme.slow,
                window.workspace.theme.faint,
            )
        )
    window.workspace.actions["dark"].setChecked(False)


class _Restyled(QtCore.QObject):
    """Counts how often a widget is told that its style is another."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        self.count += event.type() == QtCore.QEvent.Type.StyleChange
        return False


def test_another_theme_restyles_once_and_the_first_one_looks_as_before(window, program) -> None:
    dock = window.panels.docks["brushes"].widget()
    before, restyled = dock.grab().toImage(), _Restyled()
    dock.installEventFilter(restyled)
    program.setStyleSheet(program.styleSheet() + "\n")
    once, restyled.count = restyled.count, 0
    window.workspace.actions["dark"].setChecked(True)
    try:
        assert 0 < restyled.count <= once  # it takes a tenth of a second for them all
        assert dock.grab().toImage() != before
    finally:
        window.workspace.actions["dark"].setChecked(False)
    dock.removeEventFilter(restyled)
    assert dock.grab().toImage() == before


def test_a_layer_can_be_hidden_right_after_the_theme_has_changed(window) -> None:
    live(0.3)  # nothing is painted meanwhile that would show the rows again
    before = icons_of_layers(window)
    window.workspace.actions["dark"].setChecked(True)
    try:
        shades = [brightness_of_icon(icon) for icon in icons_of_layers(window)]
        assert len(shades) == len(before)
        assert min(shades) > 120.0  # on nearly black
    finally:
        window.workspace.actions["dark"].setChecked(False)
    assert max(brightness_of_icon(icon) for icon in icons_of_layers(window)) < 120.0


def icons_of_layers(window) -> list[QtGui.QIcon]:
    """Of the eyes and locks in the list of layers."""
    rows = window.panels.layers.list
    return [
        button.icon()
        for k in range(rows.count())
        for button in rows.itemWidget(rows.item(k)).findChildren(QtWidgets.QToolButton)
    ]


def brightness_of_icon(icon: QtGui.QIcon) -> float:
    """The mean of what is dense in it, of 255."""
    image = icon.pixmap(24, 24).toImage()
    pixels = [image.pixelColor(x, y) for x in range(image.width()) for y in range(image.height())]
    return float(np.mean([colour.lightness() for colour in pixels if colour.alpha() > 200]))


def test_good_news_of_one_painting_is_not_said_of_the_next(window) -> None:
    window.workspace.tell("Recovered; save it to keep it", state="good")
    assert window.opening.open_path("plane", 1.5, "xuan", asked=True)
    assert "Recovered" not in window.status.message_label.text()


def test_parts_of_the_mixing_dish_can_be_taken_out_again(window) -> None:
    inks = window.panels.inks
    window.panels.docks["inks"].raise_()
    inks.empty()
    inks.stir("cinnabar")
    inks.stir("cinnabar")
    inks.stir("gamboge")
    inks.message_label.linkActivated.emit("-cinnabar")
    assert inks.mixture() == {"cinnabar": 0.5, "gamboge": 0.5}
    inks.message_label.linkActivated.emit("+gamboge")
    inks.message_label.linkActivated.emit("-cinnabar")
    assert inks.mixture() == {"gamboge": 1.0}
    inks.dishes.setFocus()
    for key in (QtCore.Qt.Key.Key_Plus, QtCore.Qt.Key.Key_Minus, QtCore.Qt.Key.Key_Minus):
        type_key(inks.dishes, key)
    at = inks.dishes.marked
    assert at not in inks.mixture() or at == "gamboge"
    inks.empty()


def touch_a_dish(window, k: int, held_s: float | None = None) -> QtCore.QPointF:
    """Lay a finger on dish k until its plus is shown, and in the hand's time so long."""
    dishes = window.panels.inks.dishes
    window.panels.docks["inks"].raise_()
    window.panels.inks.empty()
    live(0.2)
    at = dishes.box(k).center()
    with Touching(dishes) as fingers:
        fingers.set({1: (at.x(), at.y())})
        (held,) = dishes.findChildren(QtCore.QTimer)
        wait_for(lambda: not held.isActive())
        HAND.pass_by(1e-3 * held.interval() if held_s is None else held_s)
    return at


def test_a_long_press_stirs_and_a_short_one_dips(window) -> None:
    dishes = window.panels.inks.dishes
    at = touch_a_dish(window, 2)
    assert window.panels.inks.mixture() == {dishes.names[2]: 1.0}
    left = QtCore.Qt.MouseButton.LeftButton
    mouse(dishes, KIND.MouseButtonPress, at.x(), at.y(), left, left)
    mouse(dishes, KIND.MouseButtonRelease, at.x(), at.y(), left)
    settled(window)
    assert window.document.inks[0] == dishes.names[2]


def test_a_tap_stays_short_however_late_a_busy_machine_sends_its_end(window) -> None:
    dishes = window.panels.inks.dishes
    touch_a_dish(window, 1, held_s=0.0)
    settled(window)
    assert window.panels.inks.mixture() == {}
    assert window.document.inks[0] == dishes.names[1]


def test_the_list_of_keys_opens_and_names_pens_and_fingers(window) -> None:
    found: list[str] = []

    def read(dialog) -> None:
        found.extend(label.text() for label in dialog.findChildren(QtWidgets.QLabel))
        dialog.close()

    answer(read)
    with faults() as wrong:
        window.workspace.actions["shortcuts"].trigger()
    assert wrong == []
    told = "\n".join(found)
    for words in (
        "Pen button 1",
        "Fingers: 2",
        "Space+Left button",
        "Beside the object",
        "Keypad 7",
        "Bend the tuft in place (mouse)",
    ):
        assert words in told


def test_the_whole_object_stays_in_sight_until_somebody_looks_elsewhere(window) -> None:
    size = window.size()
    window.hand.show_all()
    window.resize(1050, 640)
    live(0.2)
    small = window.hand.camera
    window.hand.show_all()
    assert np.allclose(small.position, window.hand.camera.position)
    window.steering.step("nearer")
    near = window.hand.camera
    window.resize(size)
    live(0.2)
    assert window.hand.camera is near
    window.hand.show_all()


def test_the_first_start_is_told_once(window, monkeypatch) -> None:
    from paint3d.app.window.files import opening

    assert not opening.is_first_start()  # this very test has compiled
    assert opening.say_warming() == "Preparing the brush…"
    monkeypatch.setattr(opening, "is_first_start", lambda: True)
    assert opening.say_warming().startswith("First start")


@pytest.mark.parametrize("ahead", [True, False])
def test_kernels_that_were_compiled_ahead_are_not_warmed(program, monkeypatch, ahead) -> None:
    from paint3d.app.window.files import opening

    warmed: list[bool] = []
    monkeypatch.setattr(opening, "is_ahead", lambda kernel: ahead)
    monkeypatch.setattr(opening, "warm_up", lambda check: warmed.append(True))
    with opened(program, "plane", 3.0, drawn=False):
        assert warmed == ([] if ahead else [True])


def test_what_spreads_a_picture_of_fewer_pixels_is_warmed_too(monkeypatch) -> None:
    """Compiled at the first such picture it would hold up the window's thread."""
    from paint3d.app.window.files import opening
    from paint3d.view import live_layers

    spread: list[tuple[str, int]] = []
    monkeypatch.setattr(
        live_layers, "enlarge", lambda *given: spread.extend((a.dtype.str, a.ndim) for a in given)
    )
    monkeypatch.setattr(opening, "_warm", [])
    opening.warm_up()
    wanted = [("<u4", 2), *[("<i4", 1)] * 4, ("<u8", 1), ("<u4", 2)]  # as in entries.txt
    assert spread == wanted
    monkeypatch.setattr(opening, "is_ahead", lambda kernel: kernel is not opening.enlarge)
    assert not opening.is_warm()


def test_errors_are_told_in_the_language_of_the_window(window) -> None:
    choose_language("zh")
    try:
        window.workspace.post("set_locked", 0)
        window.workspace.post("begin_stroke")
        settled(window)
        wait_for(lambda: "图层" in window.status.message_label.text())
        assert "已锁定" in window.status.message_label.text()
    finally:
        choose_language("en")
        window.workspace.post("end_stroke")
        window.workspace.post("set_locked", 0, False)
        settled(window)


def test_title_and_picture_change_together(program, monkeypatch) -> None:
    with opened(program, "plane", 3.0) as window:
        pictures: list[np.ndarray] = []
        tell = window.setWindowTitle

        def told(title: str) -> None:
            pictures.append(window.canvas.pixels.astype(int))
            tell(title)

        before = window.canvas.pixels.astype(int)
        monkeypatch.setattr(window, "setWindowTitle", told)
        window.stage.paint_thread.post(
            lambda document: setattr(document, "modified", False)
        ).result(300)
        assert window.opening.open_path("sphere", 6.0, "porcelain", asked=True)
        wait_for(lambda: window.stage.is_drawn)
        after = window.canvas.pixels.astype(int)
        new = np.abs(pictures[0] - before).mean()  # soft light comes later
        assert new > 2.0 * np.abs(pictures[0] - after).mean()


def luminance(colour: np.ndarray) -> float:
    """Relative luminance of sRGB codes (3,), as WCAG 2 has it."""
    c = np.asarray(colour, float) / 255.0
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


@pytest.mark.parametrize("theme", [LIGHT_THEME, DARK_THEME], ids=["light", "dark"])
def test_all_that_is_said_can_be_read(theme) -> None:
    """4.5 to 1, also on the plate over paper in the dark and over ink in the light."""

    def codes(name: str) -> np.ndarray:
        return np.array(QtGui.QColor(getattr(theme, name)).getRgb()[:3])

    share = PLATE_ALPHA / 255
    grounds = {name: codes(name) for name in ("window", "panel", "raised", "field")}
    for under in ("paper", "ink"):
        seen = {"paper": (235, 232, 225), "ink": (40, 40, 40)}[under]
        grounds[f"plate on {under}"] = share * codes("panel") + (1 - share) * np.array(seen)
    faint = []
    for text in ("text", "faint", "good", "slow", "bad"):
        for name, ground in grounds.items():
            if name.startswith("plate") and text not in ("text", "faint"):
                continue
            low, high = sorted((luminance(codes(text)), luminance(ground)))
            if (high + 0.05) / (low + 0.05) < 4.5:
                faint.append(f"{text} on {name}: {(high + 0.05) / (low + 0.05):.2f}")
    assert faint == []
