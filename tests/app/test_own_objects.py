"""Objects of one's own in the window: how they stand, of what they are, and their pictures."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PIL import Image
from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model.own_object import first_choice, likely_unit, sensible_resolution
from paint3d.app.window.object.new_dialog import NewDialog
from paint3d.app.window.object.standing import ObjectDialog
from paint3d.app.window.start import open_first
from paint3d.app.window.studio import StudioWindow
from paint3d.app.window.wording import choose_language
from paint3d.cli.main import make_parser
from paint3d.files.export import export
from paint3d.files.load import load_mesh, read_mesh
from paint3d.files.project.session import load_session
from paint3d.files.reading import Reading
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.mesh.upright import turn_mesh, turn_up
from paint3d.view.preview import Preview
from tests.mesh.test_upright import jug
from tests.support.app.gestures import answer, drag, live, take_file, wait_for
from tests.support.app.windows import SMALL, blind, close_unasked, pretend_saved, seen


@pytest.fixture(scope="module")
def window(program):
    """A window with a coarse sheet in it, which asks."""
    window = StudioWindow(program)
    window.resize(*SMALL)
    window.show()
    assert window.opening.open_path("plane", 2.0, "xuan", asked=True)
    wait_for(lambda: window.stage.is_lit)
    with blind(window):
        yield window
    close_unasked(window)


@pytest.fixture(autouse=True)
def nothing_to_lose(window):
    """The next test is not asked what becomes of what this one has painted."""
    yield
    pretend_saved(window.stage.paint_thread)


def foreseen(kind: type[QtWidgets.QWidget], press) -> list:
    """Let `press` deal with the next dialog of a kind; a list that it will be in."""
    met: list = []

    def deal(dialog: QtWidgets.QWidget) -> None:
        met.append(dialog.windowTitle())
        press(dialog)

    answer(deal, kind, ())
    return met


def lying_jug(folder: Path) -> Path:
    """A jug whose y points up, in a format that does not say so."""
    export(turn_mesh(jug(), turn_up("y").T), folder / "lying.ply")
    return folder / "lying.ply"


def box_with_picture(folder: Path) -> Path:
    """A box of 80 mm, a red disc on white on each side, as OBJ."""
    y, x = np.mgrid[:64, :64] / 63 - 0.5
    disc = np.where((x * x + y * y < 0.1)[..., None], [200, 30, 20], [250, 250, 245])
    Image.fromarray(disc.astype("u1")).save(folder / "disc.png")
    (folder / "box.mtl").write_text("newmtl m\nmap_Kd disc.png\nmap_bump disc.png\n")
    corners = [(x, y, z) for z in (0, 80) for y in (0, 80) for x in (0, 80)]
    sides = "0231 4576 0154 2673 0462 1375"
    text = "mtllib box.mtl\n" + "".join(f"v {x} {y} {z}\n" for x, y, z in corners)
    text += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\n"
    for side in sides.split():
        text += "f " + " ".join(f"{int(v) + 1}/{k + 1}" for k, v in enumerate(side)) + "\n"
    (folder / "box.obj").write_text(text)
    return folder / "box.obj"


def spans(window: StudioWindow) -> np.ndarray:
    """Sides of the box around the object that is open, mm."""
    return np.ptp(window.document.surface.source.vertices, axis=0)


def drop(window: StudioWindow, path: Path) -> None:
    """Drop a file on the canvas."""
    data = QtCore.QMimeData()
    data.setUrls([QtCore.QUrl.fromLocalFile(str(path))])
    how = (
        QtCore.Qt.DropAction.CopyAction,
        data,
        QtCore.Qt.MouseButton.LeftButton,
        QtCore.Qt.KeyboardModifier.NoModifier,
    )
    enter = QtGui.QDragEnterEvent(QtCore.QPoint(200, 200), *how)
    QtWidgets.QApplication.sendEvent(window.canvas, enter)
    assert enter.isAccepted()
    QtWidgets.QApplication.sendEvent(
        window.canvas, QtGui.QDropEvent(QtCore.QPointF(200, 200), *how)
    )


def test_a_file_is_opened_and_stood_up(window, tmp_path: Path) -> None:
    path = lying_jug(tmp_path)
    window.workspace.update_settings(material="bisque", resolution_mm=2.0)

    def agree(dialog: ObjectDialog) -> None:
        assert dialog.ways["y"].isChecked()
        assert dialog.material.currentData() == "bisque"
        dialog.accept()

    files = foreseen(QtWidgets.QFileDialog, take_file(path))
    asked = foreseen(ObjectDialog, agree)
    action = window.workspace.actions["open"]
    assert action.shortcut() == QtGui.QKeySequence("Ctrl+O")
    action.trigger()
    assert files
    assert asked == ["lying.ply"]
    np.testing.assert_array_equal(window.document.surface.source.vertices, jug().vertices)
    assert window.document.surface.material.name == "bisque"


def test_axes_are_called_as_the_file_has_them(window, tmp_path: Path) -> None:
    """Of a glTF, y points up, and its reader has turned it already."""
    path = tmp_path / "jug.glb"
    export(jug(), path)
    met = []

    def take_z(dialog: ObjectDialog) -> None:
        met.append([way.text() for way in dialog.ways.values() if way.isChecked()])
        np.testing.assert_array_equal(dialog.chosen().turn, np.eye(3))
        QtTest.QTest.mouseClick(dialog.ways["z"], QtCore.Qt.MouseButton.LeftButton)
        met.append([way.text() for way in dialog.ways.values() if way.isChecked()])
        dialog.accept()

    foreseen(ObjectDialog, take_z)
    assert window.opening.open_path(str(path), asked=True)
    assert met == [["y up"], ["z up"]]
    as_in_file = load_mesh(path, up="z").vertices
    np.testing.assert_array_equal(window.document.surface.source.vertices, as_in_file)


def test_a_file_that_says_another_way_than_its_shape_marks_both(window, tmp_path: Path) -> None:
    """A program whose z is up wrote a glTF as it was: it would lie."""
    path = tmp_path / "lying.glb"
    export(turn_mesh(jug(), turn_up("y")), path)
    met = []

    def look(dialog: ObjectDialog) -> None:
        met.extend(way.text() for way in dialog.ways.values() if way.isChecked())
        met.extend(way.text() for way in dialog.ways.values() if "likely" in way.text())
        met.append(dialog.findChild(QtWidgets.QLabel, "title").text())
        QtTest.QTest.mouseClick(dialog.ways["z"], QtCore.Qt.MouseButton.LeftButton)
        dialog.accept()

    foreseen(ObjectDialog, look)
    assert window.opening.open_path(str(path), asked=True)
    assert met == ["y up", "z up (likely)", "The file says y is up, its shape says z"]
    np.testing.assert_allclose(window.document.surface.source.vertices, jug().vertices, atol=1e-4)
    window.workspace.quiet = True
    try:
        assert window.opening.open_path(str(path), 2.0, "xuan", asked=True)
    finally:
        window.workspace.quiet = False
    assert "y was taken as up" in window.status.message_label.text()


def test_a_dropped_file_asks_the_same_and_shows_the_last_material(window, tmp_path: Path) -> None:
    path = lying_jug(tmp_path)
    window.workspace.update_settings(material="bisque")

    def change(dialog: ObjectDialog) -> None:
        assert dialog.material.currentData() == "bisque"
        dialog.material.setCurrentIndex(dialog.material.findData("plaster"))
        dialog.resolution.setValue(3.0)
        dialog.accept()

    asked = foreseen(ObjectDialog, change)
    drop(window, path)
    assert asked
    wait_for(lambda: window.document.surface.material.name == "plaster")
    assert window.document.surface.resolution == 3.0
    assert window.workspace.settings.material == "plaster"  # and is what the next one is asked with


def test_what_is_cancelled_leaves_everything(window, tmp_path: Path) -> None:
    before = window.document
    asked = foreseen(ObjectDialog, lambda dialog: dialog.reject())
    assert not window.opening.open_path(str(lying_jug(tmp_path)), asked=True)
    assert asked
    assert window.document is before


def test_what_becomes_of_the_old_painting_is_asked_once_for_a_file(
    window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A new painting on a mesh file asks for an object, and for the file; not twice about this."""
    path, asked, plain = lying_jug(tmp_path), [], window.saving.may_leave

    def may_leave() -> bool:
        asked.append(plain())
        return asked[-1]

    def take_a_file(dialog: NewDialog) -> None:
        dialog.choose("")
        dialog.accept()

    monkeypatch.setattr(window.saving, "may_leave", may_leave)
    foreseen(NewDialog, take_a_file)
    files = foreseen(QtWidgets.QFileDialog, take_file(path))
    objects = foreseen(ObjectDialog, lambda dialog: dialog.accept())
    window.workspace.actions["new"].trigger()
    assert files
    assert objects == ["lying.ply"]
    assert asked == [True]


def test_a_picture_comes_in_and_is_painted_over(window, tmp_path: Path) -> None:
    notes: list[str] = []

    def agree(dialog: ObjectDialog) -> None:
        notes.append(dialog.notes.text())
        assert dialog.colours.isChecked()
        dialog.accept()

    foreseen(ObjectDialog, agree)
    assert window.opening.open_path(str(box_with_picture(tmp_path)), asked=True)
    assert notes == ["Left out: relief (a bump map)"]
    wait_for(lambda: window.stage.is_lit)
    live(0.5)
    reds = red_share(window)
    assert 0.05 < reds < 0.5
    drag(window.canvas, (0.42, 0.5), (0.58, 0.5))
    wait_for(lambda: painted_count(window) > 20)
    with window.stage.paint_thread.paused() as document:
        dark = document.surface.srgb[document.surface.painted].min(axis=0)
    assert (dark < 120).all()
    wait_for(lambda: red_share(window) < reds)


def painted_count(window: StudioWindow) -> int:
    """Vertices with paint."""
    with window.stage.paint_thread.paused() as document:
        return int(document.surface.painted.sum())


def red_share(window: StudioWindow) -> float:
    """Share of the picture that is red."""
    with seen(window):
        window.stage.follow()
        pixels = window.stage.picture()[..., :3].astype(int)
    return float(np.mean((pixels[..., 0] > 90) & (pixels[..., 0] > 2 * pixels[..., 2])))


def test_its_own_colours_can_be_left_behind(window, tmp_path: Path) -> None:
    pretend_saved(window.stage.paint_thread)

    def plain(dialog: ObjectDialog) -> None:
        dialog.colours.setChecked(False)
        dialog.accept()

    foreseen(ObjectDialog, plain)
    assert window.opening.open_path(str(box_with_picture(tmp_path)), asked=True)
    assert window.document.surface.source.colours is None
    assert window.document.surface.source.n_vertices == 8


def test_what_is_open_is_turned_and_scaled(window, tmp_path: Path) -> None:
    foreseen(ObjectDialog, lambda dialog: dialog.accept())
    assert window.opening.open_path(str(lying_jug(tmp_path)), asked=True)
    size = spans(window)

    def turn(dialog: ObjectDialog) -> None:
        dialog.quarters["x"].click()
        assert dialog.ways["-y"].isChecked() or dialog.ways["y"].isChecked()
        dialog.length.setValue(2.0 * dialog.length.value())
        dialog.accept()

    foreseen(ObjectDialog, turn)
    window.workspace.actions["stand"].trigger()
    np.testing.assert_allclose(spans(window), 2.0 * size[[0, 2, 1]], rtol=1e-3)
    session = tmp_path / "turned.p3d"
    assert window.saving.save_to(session)
    np.testing.assert_array_equal(
        load_session(session).surface.source.vertices, window.document.surface.source.vertices
    )


def test_turning_what_is_painted_begins_anew_or_leaves_it(window) -> None:
    wait_for(lambda: window.stage.is_lit)
    drag(window.canvas, (0.45, 0.5), (0.55, 0.5))
    before = window.document
    wait_for(lambda: before.strokes)
    met = foreseen(QtWidgets.QMessageBox, lambda box: box.reject())
    window.workspace.actions["stand"].trigger()
    assert met
    assert window.document is before
    pretend_saved(window.stage.paint_thread)
    foreseen(QtWidgets.QMessageBox, lambda box: box.buttons()[0].click())
    foreseen(ObjectDialog, lambda dialog: (dialog.quarters["y"].click(), dialog.accept()))
    window.workspace.actions["stand"].trigger()
    assert window.document is not before
    assert not window.document.strokes
    assert spans(window)[0] == pytest.approx(np.ptp(before.surface.source.vertices[:, 2]))


def slanted() -> TriangleMesh:
    """A pyramid over a square, on its tip."""
    points = np.array([[0, 0, 0], [40, 40, 50], [-40, 40, 50], [-40, -40, 50], [40, -40, 50]])
    faces = np.array([[0, 4, 1], [0, 3, 4], [0, 2, 3], [0, 1, 2], [1, 3, 2], [1, 4, 3]])
    return TriangleMesh(points.astype(float), faces)


def egg(n: int) -> TriangleMesh:
    """Of 2 n (n - 2) triangles."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, n, endpoint=False), np.linspace(0.01, 3.13, n))
    points = [60 * np.cos(u) * np.sin(v), 40 * np.sin(u) * np.sin(v), 90 * np.cos(v)]
    at = np.arange(n * (n - 1)).reshape(n - 1, n)
    beside = np.roll(at, -1, axis=1)
    corners = [[at, beside, at + n], [beside, beside + n, at + n]]
    faces = [np.stack(three, axis=-1).reshape(-1, 3) for three in corners]
    return TriangleMesh(np.stack(points, axis=-1).reshape(-1, 3), np.concatenate(faces))


def test_the_dialog_looks_at_the_whole_of_an_object_once(
    window, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At 1.5 million triangles its box took a tenth of a second, and was found six times."""
    looks: list[str] = []

    def counted(what: str, whole):
        return lambda mesh, *others: (looks.append(what), whole(mesh, *others))[1]

    box = cached_property(counted("box", vars(TriangleMesh)["bounds"].func))
    box.__set_name__(TriangleMesh, "bounds")
    monkeypatch.setattr(TriangleMesh, "bounds", box)
    monkeypatch.setattr(Preview, "__init__", counted("points", Preview.__init__))
    reading = Reading(egg(40))
    dialog = ObjectDialog(window, reading, "xuan", 2.0, title="egg", accept="Open")
    dialog.show()
    dialog.ways["x"].click()
    wait_for(lambda: len(looks) > 1)
    assert sorted(looks) == ["box", "points"]
    dialog.deleteLater()


def test_it_stands_on_the_side_that_is_clicked(window) -> None:
    dialog = ObjectDialog(window, Reading(slanted()), "xuan", 2.0, title="pyramid", accept="Open")
    dialog.show()
    picture = dialog.picture
    place = QtCore.QPoint(picture.width() // 2, int(0.62 * picture.height()))  # a slanted side
    QtTest.QTest.mouseClick(picture, QtCore.Qt.MouseButton.LeftButton, pos=place)
    turned = dialog.chosen().apply(slanted()).vertices
    low = turned[:, 2] < turned[:, 2].min() + 1e-3
    assert low.sum() == 3  # a triangle lies on the ground
    assert low[0]
    corner = QtCore.QPoint(4, 4)  # beside it: nothing happens
    before = dialog.chosen().turn
    QtTest.QTest.mouseClick(picture, QtCore.Qt.MouseButton.LeftButton, pos=corner)
    np.testing.assert_array_equal(dialog.chosen().turn, before)
    dialog.stand_up("-z")
    assert dialog.ways["-z"].isChecked()
    dialog.close()


def test_unit_length_and_fineness_go_together(window) -> None:
    ball = load_mesh("sphere")
    small = Reading(TriangleMesh(ball.vertices * 1e-3, ball.faces))
    dialog = ObjectDialog(window, small, "xuan", 0.4, title="ball", accept="Open")
    assert dialog.unit.currentData() == "m"
    assert dialog.length.value() == pytest.approx(150.0, rel=0.01)
    dialog.unit.setCurrentIndex(dialog.unit.findData("in"))
    dialog.unit.activated.emit(dialog.unit.currentIndex())
    assert dialog.length.value() == pytest.approx(0.15 * 25.4, rel=0.01)
    dialog.length.setValue(3000.0)
    assert dialog.unit.currentIndex() == -1
    assert dialog.resolution.value() > 1.0  # 28 m2 would take millions of cells
    dialog.resolution.setValue(0.8)
    dialog.length.setValue(2000.0)
    assert dialog.resolution.value() == 0.8  # what was chosen stays
    dialog.close()
    assert likely_unit(0.15) == "m"
    assert sensible_resolution(6e6, 0.4) == pytest.approx(1.0)
    assert sensible_resolution(6e4, 0.4) == 0.4


def test_what_is_opened_without_asking_is_told(window, tmp_path: Path) -> None:
    window.workspace.quiet = True
    try:
        assert window.opening.open_path(str(lying_jug(tmp_path)), 2.0, "xuan", asked=True)
    finally:
        window.workspace.quiet = False
    assert "y was taken as up" in window.status.message_label.text()
    size = spans(window)
    assert size[2] == size.max()
    ball = tmp_path / "ball.ply"
    export(load_mesh("sphere"), ball)
    choice = first_choice(read_mesh(ball), None, "xuan", 2.0)
    np.testing.assert_array_equal(choice.turn, np.eye(3))


def test_the_command_line_says_which_way_is_up(window, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(window.recovery, "offer", lambda: False)
    open_first(window, str(lying_jug(tmp_path)), 2.0, "xuan", up="-y")
    vertices = window.document.surface.source.vertices
    np.testing.assert_array_equal(vertices[:, 2], -jug().vertices[:, 2])
    assert (window.workspace.quiet, window.opening.up) == (False, None)


def test_the_command_line_says_what_one_unit_is(window, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(window.recovery, "offer", lambda: False)
    words = ["paint", str(lying_jug(tmp_path)), "--unit", "cm"]
    said = make_parser("paint").parse_args(words)
    open_first(window, said.target, 5.0, "xuan", said.unit, "y")
    vertices = window.document.surface.source.vertices
    np.testing.assert_allclose(vertices[:, 2], 10.0 * jug().vertices[:, 2], rtol=1e-6)
    assert (window.workspace.quiet, window.opening.unit) == (False, None)


def test_what_is_left_out_is_said_in_the_windows_language(window, tmp_path: Path) -> None:
    path = tmp_path / "odd.obj"
    path.write_text("mtllib gone.mtl\nusemtl m\nv 0 0 0\nv 80 0 0\nv 0 80 0\nf 1 2 3\nl 1 2\n")
    seen, focused = [], []

    def look(dialog: ObjectDialog) -> None:
        seen.append(dialog.notes.text().split("\n"))
        focused.append(dialog.focusWidget().text())
        dialog.reject()

    for code in ("zh", "en"):
        choose_language(code)
        try:
            asked = foreseen(ObjectDialog, look)
            window.opening.open_path(str(path))
        finally:
            choose_language("en")
        assert asked
    assert seen == [
        ["未采用材质：找不到 'gone.mtl'", "未采用：线条"],
        ["Materials are left out: it refers to 'gone.mtl', which is missing", "Left out: lines"],
    ]
    assert focused == ["打开", "Open"]  # Enter opens, and no quarter turn looks chosen beside it


def test_the_papers_records_are_an_object_with_its_colours(window, tmp_path: Path) -> None:
    mesh = jug()
    codes = np.full((mesh.n_vertices, 3), (200, 90, 40), np.uint8)
    path = tmp_path / "jug.p3d.txt"
    export(TriangleMesh(mesh.vertices, mesh.faces, codes), path)
    seen = []

    def choose(dialog: QtWidgets.QFileDialog) -> None:
        seen.append(" ".join(dialog.nameFilters()))
        take_file(path)(dialog)

    files = foreseen(QtWidgets.QFileDialog, choose)
    foreseen(ObjectDialog, lambda dialog: dialog.accept())
    window.workspace.actions["open"].trigger()
    assert files
    assert "*.p3d.txt" in seen[0]
    source = window.document.surface.source
    np.testing.assert_allclose(source.vertices, mesh.vertices, atol=1e-4)
    assert (source.colours == codes).all()
