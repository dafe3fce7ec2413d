"""A screen for the tests of the window, and places of their own for settings and journals."""

from __future__ import annotations

import copy
import hashlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from paint3d.app.model import paint_thread
from paint3d.app.model.persistence import settings
from paint3d.view import live_picture, live_scene
from paint3d.view.live_light import BakedLight, LiveLight
from tests.support.app.screens import start_screen

paint_thread.CHECKS_ACCESS = True
_WET_AT_FIRST = settings.WET_AT_FIRST
_FOUND: dict[bytes, BakedLight] = {}


@pytest.fixture(autouse=True, scope="module")
def dry_at_first() -> Iterator[None]:
    """Ink stays where it was put, for tests that measure it; on xuan it would spread by itself."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(settings, "WET_AT_FIRST", frozenset())
        yield


@pytest.fixture(autouse=True, scope="module")
def mouse_as_it_is() -> Iterator[None]:
    """Strokes of a mouse go where it goes, for tests that measure them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(settings, "MOUSE_STEADY", 0.0)
        yield


@pytest.fixture(autouse=True, scope="module")
def light_once(few_lights: None) -> Iterator[None]:
    """Look for the light on an object once, by few lights: the sheet is opened a hundred times.

    What is found depends on nothing but what is hashed here. Light itself is tested in tests/view.
    """
    bake = LiveLight.bake

    def baked(light: LiveLight) -> BakedLight:
        mesh, n, said = light.mesh, light.mesh.n_base_vertices, hashlib.blake2b()
        of_vertices = (mesh.vertices[:n], mesh.normals[:n], mesh.vertex_areas[:n])
        for part in (*of_vertices, mesh.base_faces, light.axes):
            said.update(f"{part.dtype} {part.shape}".encode())
            said.update(np.ascontiguousarray(part).data)
        said.update(repr(light.setting).encode())
        key = said.digest()
        if key not in _FOUND:
            _FOUND[key] = bake(light)
        return copy.deepcopy(_FOUND[key])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LiveLight, "bake", baked)
        yield


@pytest.fixture(autouse=True, scope="module")
def plain_edges() -> Iterator[None]:
    """Draw what stands still once, not once more for smooth edges: half of a window's time.

    Smooth edges are tested in tests/view, and in the files here whose `plain_edges` does nothing.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(live_scene, "_JITTER", ((0.0, 0.0),))
        patch.setattr(live_picture, "_BEST", live_picture._PLAIN)  # nor once more, when all is calm
        yield


@pytest.fixture(autouse=True, scope="module")
def few_pictures() -> Iterator[None]:
    """Draw half as many pictures of a stroke: they are a third of what painting in a window costs.

    All of them are drawn in the files here whose `few_pictures` does nothing.
    """
    if "PySide6" not in sys.modules:
        yield
        return
    from paint3d.app.window import studio

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(studio, "_REST", 4.0)
        yield


@pytest.fixture(autouse=True, scope="module")
def plain_previews() -> Iterator[None]:
    """Show a plain patch for each brush: the strokes of all are painted anew for each ink in hand.

    Real ones are tested in test_brush_editor.
    """
    if "PySide6" not in sys.modules:
        yield
        return
    from paint3d.app.window.brush import brush_panel
    from tests.support.app.windows import plain_preview

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(brush_panel, "stroke_preview", plain_preview)
        yield


@pytest.fixture(autouse=True)
def nothing_is_awaited() -> Iterator[None]:
    """Fail a test that awaits a dialog that does not open: it would answer another test's."""
    yield
    if "tests.support.app.gestures" in sys.modules:
        from tests.support.app.gestures import AWAITED

        left = list(AWAITED.values())
        AWAITED.clear()
        assert not left, f"still awaited: {', '.join(left)}"


@pytest.fixture(autouse=True)
def windows_go() -> Iterator[None]:
    """Delete the windows that a test has closed: each new one's theme restyles all there are."""
    yield
    if "PySide6.QtWidgets" in sys.modules:
        from PySide6 import QtCore, QtWidgets

        for widget in QtWidgets.QApplication.topLevelWidgets():
            if not widget.isVisible() and widget.parent() is None:
                widget.deleteLater()
        QtCore.QCoreApplication.sendPostedEvents(None, QtCore.QEvent.Type.DeferredDelete)


@pytest.fixture
def wet_at_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """As users have it: see `dry_at_first`."""
    monkeypatch.setattr(settings, "WET_AT_FIRST", _WET_AT_FIRST)


@pytest.fixture(scope="session")
def screen() -> Iterator[str]:
    """The name of an X display of our own: two programs on one take the keyboard from each other.

    One that is there is used where the tests run in one process, to be watched.
    """
    if os.environ.get("DISPLAY") and "PYTEST_XDIST_WORKER" not in os.environ:
        yield os.environ["DISPLAY"]
        return
    name, process = start_screen("1400x900")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DISPLAY", name)
        yield name
    process.returncode = 0  # left running: OpenGL keeps its connection until this process ends


@pytest.fixture(scope="session")
def places(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder that stands for the user's own."""
    folder = tmp_path_factory.mktemp("home")
    kept = {name: os.environ.get(name) for name in ("XDG_CONFIG_HOME", "PAINT3D_STATE")}
    os.environ.update(XDG_CONFIG_HOME=str(folder), PAINT3D_STATE=str(folder / "state"))
    yield folder
    for name, value in kept.items():
        if value is None:
            del os.environ[name]
        else:
            os.environ[name] = value


@pytest.fixture(scope="session")
def program(screen: str, places: Path):
    """The Qt program; one for all tests."""
    pytest.importorskip("PySide6", reason="PySide6 is not installed")
    from paint3d.app.window.start import make_program

    assert sys.platform.startswith("linux") or screen
    return make_program()
