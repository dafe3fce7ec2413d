"""The page with the object, in a real browser: exact colours, every way to turn it, no network."""

from __future__ import annotations

import base64
import io
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from paint3d.colour.pigments import load_pigment
from paint3d.errors import ExportError
from paint3d.files.export import export
from paint3d.files.export_options import ExportOptions
from paint3d.files.load import load_mesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface

PROGRAM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
OPTIONS = [
    "--headless=new",
    "--no-sandbox",
    "--remote-debugging-pipe",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--force-color-profile=srgb",
    "--hide-scrollbars",
    "--no-first-run",
    "--disable-gpu-sandbox",
]


class Browser:
    """One page; everything that it says or asks for over the network is kept."""

    def __init__(self, folder: Path) -> None:
        theirs_in, self._out = os.pipe()
        self._in, theirs_out = os.pipe()
        start = f'exec "$0" "$@" 3<&{theirs_in} 4>&{theirs_out}'
        self._process = subprocess.Popen(
            ["bash", "-c", start, PROGRAM, *OPTIONS, f"--user-data-dir={folder}", "about:blank"],
            pass_fds=(theirs_in, theirs_out),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(theirs_in)
        os.close(theirs_out)
        self._rest = b""
        self._last = 0
        self._session = None
        self.requests: list[str] = []
        self.complaints: list[str] = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")

    def close(self) -> None:
        """End the browser."""
        self._process.terminate()
        self._process.wait(timeout=300)
        os.close(self._in)
        os.close(self._out)

    def call(self, method: str, **parameters: object) -> dict:
        """Ask for something and wait for the answer."""
        self._last += 1
        message = {"id": self._last, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._read()
            if answer.get("id") == self._last:
                assert "error" not in answer, answer
                return answer["result"]
            self._note(answer)

    def _read(self) -> dict:
        while b"\0" not in self._rest:
            more = os.read(self._in, 1 << 20)
            assert more, "the browser has gone"
            self._rest += more
        text, self._rest = self._rest.split(b"\0", 1)
        return json.loads(text)

    def _note(self, event: dict) -> None:
        parameters = event.get("params", {})
        if event.get("method") == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])
        elif event.get("method") in ("Runtime.exceptionThrown", "Log.entryAdded"):
            self.complaints.append(json.dumps(parameters)[:500])

    def open(self, path: Path, fragment: str = "", size: tuple[int, int] = (640, 480)) -> None:
        """Open a file and wait until the page says that it is ready."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=size[0], height=size[1], deviceScaleFactor=1, mobile=False,
        )  # fmt: skip
        self.call("Page.navigate", url="about:blank")
        self.call("Page.navigate", url=f"{path.as_uri()}{fragment and '#' + fragment}")
        ready = "document.documentElement && document.documentElement.dataset.ready === 'true'"
        said = "document.getElementById('message') && !document.getElementById('message').hidden"
        self.evaluate(
            f"new Promise((done) => {{ const look = () => ({ready}) || ({said})"
            " ? done(true) : setTimeout(look, 20); look(); })"
        )

    def evaluate(self, expression: str) -> object:
        """Return the value of an expression in the page; promises are waited for."""
        answer = self.call(
            "Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def picture(self) -> np.ndarray:
        """Return what is on the screen, (H, W, 3) uint8."""
        self.evaluate(
            "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )
        data = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))

    def mouse(self, kind: str, x: float, y: float, **more: object) -> None:
        """Send a mouse event: pressed, moved, released or wheel."""
        names = {"wheel": "mouseWheel"}
        self.call(
            "Input.dispatchMouseEvent",
            type=names.get(kind, f"mouse{kind.capitalize()}"), x=x, y=y, **more,
        )  # fmt: skip

    def drag(self, start: tuple[float, float], end: tuple[float, float], **more: object) -> None:
        """Press, move and release the left button."""
        held = {"button": "left", "buttons": 1, "clickCount": 1} | more
        self.mouse("pressed", *start, **held)
        self.mouse("moved", *end, **held)
        self.mouse("released", *end, **held)

    def key(self, key: str, **more: object) -> None:
        """Press and release a key."""
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, **more)

    def touch(self, *steps: list[tuple[float, float]]) -> None:
        """Put fingers down, move them step by step, and lift them."""
        kinds = ["touchStart", *["touchMove"] * (len(steps) - 1)]
        for kind, points in zip(kinds, steps, strict=True):
            places = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(points)]
            self.call("Input.dispatchTouchEvent", type=kind, touchPoints=places)
        self.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])


GROUND = (143, 139, 133)
MIDDLE = (320, 240)


def patches(n=16):
    """A sheet of n x n squares, each of one colour; with n = 16 every code occurs."""
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    corner = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    places = np.stack([i, j], axis=1)[:, None] + corner
    vertices = np.concatenate([places, np.zeros((n * n, 4, 1))], axis=2).reshape(-1, 3)
    first = 4 * np.arange(n * n)[:, None, None]
    faces = (first + np.array([(0, 1, 2), (0, 2, 3)])).reshape(-1, 3)
    code = np.arange(n * n)
    colours = np.stack([code, 255 - code, code * 7 % 256], axis=1)
    return TriangleMesh(
        np.float32(vertices), np.int32(faces), np.repeat(colours, 4, axis=0).astype(np.uint8)
    ), colours


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    if PROGRAM is None:
        pytest.skip("there is no Chromium")
    one = Browser(tmp_path_factory.mktemp("browser"))
    yield one
    one.close()


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    """A sphere of three colours that looks different from every side."""
    solid = trimesh.creation.icosphere(subdivisions=4, radius=30.0)
    codes = np.uint8(60 + 120 * (solid.vertices > 0))
    mesh = TriangleMesh(np.float32(solid.vertices), np.int32(solid.faces), codes)
    path = tmp_path_factory.mktemp("page") / "Su Shi & <friends>.html"
    export(mesh, path)
    return path


def open_without_words(browser, page, *arguments, **options):
    """Open a page for pictures of the object alone."""
    browser.open(page, *arguments, **options)
    browser.evaluate(
        "document.querySelectorAll('h1, p, #controls').forEach((e) => { e.style.opacity = 0; })"
    )


def is_ball(picture):
    return (np.abs(picture.astype(int) - GROUND) > 20).any(axis=2)


def test_every_painted_colour_is_on_the_screen_within_one_code(browser, tmp_path):
    mesh, colours = patches()
    export(mesh, tmp_path / "sheet.html")
    open_without_words(browser, tmp_path / "sheet.html")
    picture = browser.picture().astype(int)
    side = np.flatnonzero((picture[240] != GROUND).any(axis=1))
    left, right = side[0], side[-1] + 1
    place = (np.arange(16) + 0.5) * (right - left) / 16
    x = np.rint(left + place).astype(int)
    y = np.rint(240 + (right - left) / 2 - place).astype(int)
    for dx, dy in ((0, 0), (-5, 3), (4, -6)):
        seen = picture[y[None, :] + dy, x[:, None] + dx].reshape(-1, 3)
        assert np.abs(seen - colours).max() <= 1


def test_a_sheet_shows_its_paper_and_ink_its_grain(browser, tmp_path):
    surface = PaintedSurface(load_mesh("sheet:30x30"), 0.4, material="xuan")
    surface.refine_all()
    surface.column_of(load_pigment("pine soot"))
    right = surface.paint_mesh.vertices[:, 0] > 0.0
    n = surface.n_vertices
    surface.ink.coverage[:n], surface.ink.amounts[:n, 0] = right, 0.15 * right
    surface.touch(np.arange(n, dtype=np.int32))
    export(surface, tmp_path / "sheet.html")
    shown = {}
    for paper in ("", "paper=0"):
        open_without_words(browser, tmp_path / "sheet.html", paper)
        picture = browser.picture()[120:360].astype(float)
        shown[paper] = picture[:, 340:480, 1], picture[:, 160:300, 1]
    (ink, bare), (plain_ink, plain_bare) = shown.values()
    assert plain_ink.std() < 0.3
    assert plain_bare.std() < 0.3
    assert 0.3 < bare.std() < 4.0
    assert 6.0 < ink.std() < 18.0
    assert abs(ink.mean() - plain_ink.mean()) < 5.0


def test_the_page_asks_for_nothing_and_complains_of_nothing(browser, ball):
    browser.requests.clear()
    browser.complaints.clear()
    browser.open(ball)
    assert is_ball(browser.picture()).any()
    assert browser.requests == [ball.as_uri()]
    assert browser.complaints == []
    text = ball.read_text(encoding="utf-8")
    assert not re.search(r"https?:|//cdn|@import|<link", text)


def test_title_and_names_for_those_who_do_not_see(browser, ball):
    browser.open(ball)
    assert browser.evaluate("document.title") == "Su Shi & <friends>"
    assert browser.evaluate("document.documentElement.lang") == "en"
    tree = browser.call("Accessibility.getFullAXTree")["nodes"]
    named = {
        (node["role"]["value"], node["name"]["value"])
        for node in tree
        if not node.get("ignored") and "name" in node
    }
    assert ("heading", "Su Shi & <friends>") in named
    assert ("image", "Su Shi & <friends>, a painted object in three dimensions") in named
    assert {("button", "Light"), ("button", "Closer"), ("button", "Farther")} <= named
    assert browser.evaluate("document.getElementById('view').tabIndex") == 0


def test_keys_turn_come_closer_light_and_reset(browser, ball):
    open_without_words(browser, ball)
    first = browser.picture()
    for key, more in (("ArrowLeft", {}), ("ArrowUp", {}), ("ArrowRight", {"modifiers": 8})):
        browser.key(key, **more)
        assert (browser.picture() != first).any(), key
        browser.key("r")
        np.testing.assert_array_equal(browser.picture(), first)
    size = is_ball(first).sum()
    browser.key("+")
    assert is_ball(browser.picture()).sum() > 1.2 * size
    browser.key("-")
    browser.key("-")
    assert is_ball(browser.picture()).sum() < 0.85 * size
    browser.key("Home")
    browser.key("l")
    assert browser.evaluate("document.getElementById('light').ariaPressed") == "true"
    lit = browser.picture()
    codes = len(np.unique(lit[is_ball(lit)], axis=0))
    assert codes > 50  # shades
    browser.key("L")
    np.testing.assert_array_equal(browser.picture(), first)


def test_mouse_turns_moves_and_comes_closer(browser, ball):
    open_without_words(browser, ball)
    first = browser.picture()
    browser.drag(MIDDLE, (420, 260))
    turned = browser.picture()
    assert (turned != first).any()
    middle = np.argwhere(is_ball(first)).mean(axis=0)
    np.testing.assert_allclose(np.argwhere(is_ball(turned)).mean(axis=0), middle, atol=1.0)
    browser.key("r")
    browser.drag(MIDDLE, (360, 220), modifiers=8)
    moved = np.argwhere(is_ball(browser.picture())).mean(axis=0)
    np.testing.assert_allclose(moved - middle, (-20, 40), atol=3.0)
    browser.key("r")
    browser.mouse("wheel", *MIDDLE, deltaX=0, deltaY=-120)
    assert is_ball(browser.picture()).sum() > 1.1 * is_ball(first).sum()


def test_a_drag_turns_the_side_in_front_along_with_it(browser, ball):
    open_without_words(browser, ball, "azimuth=-90&elevation=0")
    browser.drag(MIDDLE, (400, 240))  # the right side, which is red, goes away
    picture = browser.picture()
    reddish = picture[..., 0] > 150
    assert reddish[240].sum() < is_ball(picture)[240].sum() / 2 - 20


def test_two_fingers_pinch(browser, ball):
    open_without_words(browser, ball)
    first = is_ball(browser.picture())
    browser.touch([(300, 240), (340, 240)], [(290, 240), (350, 240)], [(280, 240), (360, 240)])
    assert is_ball(browser.picture()).sum() > 1.5 * first.sum()
    browser.key("r")
    browser.touch([(300, 240)], [(340, 240)])
    assert is_ball(browser.picture()).sum() == pytest.approx(first.sum(), rel=0.01)


def test_buttons_work(browser, ball):
    open_without_words(browser, ball)
    first = browser.picture()
    browser.evaluate("document.getElementById('closer').click()")
    assert is_ball(browser.picture()).sum() > is_ball(first).sum()
    browser.evaluate("document.getElementById('farther').click()")
    browser.evaluate("document.getElementById('light').click()")
    assert (browser.picture()[MIDDLE[::-1]] != first[MIDDLE[::-1]]).any()
    browser.evaluate("document.getElementById('reset').click()")
    np.testing.assert_array_equal(browser.picture(), first)


@pytest.mark.parametrize("size", [(360, 640), (900, 300)])
def test_the_whole_object_is_seen_in_any_window(browser, ball, size):
    open_without_words(browser, ball, size=size)
    seen = is_ball(browser.picture())
    rows, columns = np.argwhere(seen).T
    assert columns.min() > 2
    assert columns.max() < size[0] - 3
    assert rows.max() < size[1] - 3


def test_a_lost_context_comes_back(browser, ball):
    open_without_words(browser, ball)
    first = browser.picture()
    browser.evaluate(
        "new Promise((done) => { const canvas = document.getElementById('view');"
        "const loss = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');"
        "canvas.addEventListener('webglcontextrestored', () => setTimeout(done, 50));"
        "const restore = () => setTimeout(() => loss.restoreContext());"
        "canvas.addEventListener('webglcontextlost', restore);"
        "loss.loseContext(); })"
    )
    np.testing.assert_array_equal(browser.picture(), first)


def test_a_page_has_no_unit(tmp_path):
    with pytest.raises(ExportError, match=r"\.html files cannot have unit"):
        export(patches(2)[0], tmp_path / "a.html", ExportOptions(unit="cm"))


def test_a_damaged_page_says_so(browser, ball, tmp_path):
    text = ball.read_text(encoding="utf-8")
    at = text.index('id="mesh">') + 10
    broken = tmp_path / "broken.html"
    broken.write_text(text[:at] + "A" * 400 + text[at + 400 :], encoding="utf-8")
    browser.open(broken)
    said = browser.evaluate("document.getElementById('message').textContent")
    assert said.startswith("The object cannot be shown")
