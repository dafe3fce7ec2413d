"""The page in Chromium: a pen paints, the desktop paints the same, and what cannot be is said."""

from __future__ import annotations

import base64
import gzip
import json
import math
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image
from scipy.spatial import cKDTree
from shapely import Polygon

from paint3d.app.model.copybook import Copybook
from paint3d.app.model.laid_text import LaidText
from paint3d.app.model.score.playing import painted
from paint3d.calligraphy.glyph_sources import load_glyphs, open_glyphs
from paint3d.calligraphy.seal.stone import cut_seal
from paint3d.colour.spectra import encode_srgb
from paint3d.files.load import load_mesh
from paint3d.page.folder import KERNELS, PageObject, build_page
from paint3d.recording.score import load_score
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.chromium import Browser, browser_path, opened, served
from tests.support.descriptors import combined_mouse
from tests.support.web_page import as_a_browser_has_it, built_page, hashes_of, why_no_kernels

pytestmark = [
    pytest.mark.skipif(browser_path() is None, reason="neither Chromium nor Chrome is installed"),
    pytest.mark.skipif(bool(why_no_kernels(KERNELS)), reason=why_no_kernels(KERNELS)),
]
OPEN = "!!window.paint3d && document.getElementById('message').hidden"
MESSAGE = "(m => m.hidden ? '' : m.textContent)(document.getElementById('message'))"
SHEET, BOWL = 0, 1
LIFTED: dict[str, Any] = {
    "type": "mouseReleased", "button": "left", "buttons": 0, "force": 0.0, "pointerType": "pen",
    "clickCount": 1,
}  # fmt: skip
IS_LEFT = "dispatchEvent(new Event('beforeunload', {cancelable: true}))"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    page = built_page(tmp_path_factory.mktemp("built"))
    out = tmp_path_factory.mktemp("page")
    objects = [PageObject("square", 0.8), PageObject("bowl", 0.8)]
    inks = ["pine soot", "cinnabar"]
    build_page(
        out,
        objects,
        ["zhongkai", "xiaokai"],
        inks,
        copybook=["一", "一一\n一一一"],
        seals="永和九年書",
        page=page,
    )
    return out


@pytest.fixture(scope="module")
def address(folder: Path) -> Iterator[str]:
    with served(folder) as url:
        yield url


@pytest.fixture(scope="module")
def browser(address: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with opened(address, tmp_path_factory.mktemp("profile"), (960, 720)) as one:
        one.wait_for(OPEN)
        yield one
        assert one.complaints() == []


def begin_with(browser: Browser, place: int) -> None:
    """Open an object, fresh; its ink stays where it is put."""
    browser.evaluate("window.confirm = () => true")
    browser.evaluate("window.before = document.getElementById('object'); 0")
    choose(browser, "object", place)
    browser.wait_for(f"document.getElementById('object') !== window.before && {OPEN}")
    let_spread(browser, on=False)


def let_spread(browser: Browser, *, on: bool) -> None:
    wet = "document.getElementById('wet')"
    browser.evaluate(f"{wet}.checked === {str(on).lower()} || {wet}.click()")


def choose(browser: Browser, name: str, place: int) -> None:
    browser.evaluate(
        f"(() => {{ const s = document.getElementById('{name}'); s.selectedIndex = {place};"
        "s.dispatchEvent(new Event('change')); })()"
    )


def open_copybook(browser: Browser) -> None:
    """Open the tab of texts and seals, if it is not open; by a hand that is too quick."""
    browser.evaluate(
        "if (document.getElementById('tab-copybook').hidden) for (const _ of [1, 2, 3])"
        " document.getElementById('show-copybook').click()"
    )


def wave(x: float, y: float, length: float = 240.0) -> list[tuple[float, float, float]]:
    """A way of a pen with its forces, which begins at a place of the window."""
    n = 48
    return [
        (x + length * k / n, y + 14.0 * math.sin(k / 6.0), 0.1 + 0.5 * math.sin(math.pi * k / n))
        for k in range(n + 1)
    ]


def settled(browser: Browser) -> dict[str, Any]:
    """The page's hashes, when all that was heard is painted."""
    hashes: dict[str, Any] = browser.evaluate("paint3d.hashes()")
    return hashes


def painted_by_the_desktop(browser: Browser, tmp_path: Path) -> PaintedSurface:
    """What the desktop paints by the page's score."""
    path = tmp_path / "page.score.jsonl"
    path.write_text(browser.evaluate("paint3d.score()"), "utf-8")
    score = load_score(path)
    return painted(score, load_mesh(score.header["object"])).surface


def by_the_desktop(browser: Browser, tmp_path: Path) -> dict[str, Any]:
    """The same as `settled` of that."""
    hashes = hashes_of(painted_by_the_desktop(browser, tmp_path))
    return {name: hashes[name] for name in ("vertices", "srgb", "amounts")}


def picture(browser: Browser, path: Path) -> np.ndarray:
    browser.screenshot(path)
    return np.asarray(Image.open(path).convert("L"), np.float64)


def test_a_first_visit_loads_little_beside_the_object(folder: Path) -> None:
    names = ["kernels.wasm", "kernels.json", "contents.json", "index.html", "common.bin.gz",
             "brushes/zhongkai.bin.gz", "materials/xuan.bin.gz"]  # fmt: skip
    files = [*(folder / name for name in names), *(folder / "assets").iterdir()]
    sizes = {
        one.name: len(one.read_bytes() if one.suffix == ".gz" else gzip.compress(one.read_bytes()))
        for one in files
    }
    assert sum(sizes.values()) < 1_500_000


def test_the_worker_has_the_licence_of_what_it_holds(folder: Path) -> None:
    (worker,) = (folder / "assets").glob("object_worker-*.js")
    script = worker.read_text("utf-8")
    assert "Copyright (c) 2022 Paul Miller" in script
    assert "this permission notice shall be included in" in script


def test_what_a_pen_paints_on_a_sheet_the_desktop_paints_to_the_bit(
    browser: Browser, tmp_path: Path
) -> None:
    begin_with(browser, SHEET)
    bare = settled(browser)
    before = picture(browser, tmp_path / "before.png")
    browser.stroke(wave(350.0, 330.0), tiltX=30, tiltY=20)
    first = settled(browser)
    browser.stroke(wave(350.0, 420.0), tiltX=-45, tiltY=0)
    browser.evaluate("document.getElementById('undo').click()")
    assert settled(browser)["srgb"] != bare["srgb"]
    choose(browser, "brush", 1)  # whose file comes later than what is asked next
    choose(browser, "inks", 1)
    for name, percent in (("fullness", 40), ("wetted", 12.5)):
        slide = f"(s => {{ s.value = {percent}; s.dispatchEvent(new Event('change')); }})"
        browser.evaluate(f"{slide}(document.getElementById('{name}'))")
    browser.stroke(wave(350.0, 500.0))
    found = settled(browser)
    said = browser.evaluate("paint3d.score()")
    assert '"amount":{"wetted":0.125,"fullness":0.4}' in said.rpartition("dip")[2]
    assert said.count('"amount"') == 1
    assert 0 < said.find("set_brush") < said.rfind("begin_stroke")
    after = picture(browser, tmp_path / "after.png")
    assert found["vertices"] >= first["vertices"] > bare["vertices"]
    dark = (before - after) > 60.0
    assert dark[300:360, 340:600].any(axis=0).sum() > 160  # pixels of a stroke's length
    assert not dark[395:440, 340:600].any()  # where it was taken back
    assert found == by_the_desktop(browser, tmp_path)


def test_wet_ink_spreads_while_one_looks_as_on_the_desktop(
    browser: Browser, tmp_path: Path
) -> None:
    hidden = "Object.defineProperty(document, 'hidden', {get: () => true, configurable: true}); 0"
    browser.evaluate(hidden)
    begin_with(browser, SHEET)
    let_spread(browser, on=True)
    browser.stroke(wave(350.0, 330.0), lifts=False)
    browser.evaluate("new Promise(done => setTimeout(done, 300))")
    laid = settled(browser)
    assert "follow_time" not in browser.evaluate("paint3d.score()")  # nobody looks
    browser.evaluate(
        "delete document.hidden; document.dispatchEvent(new Event('visibilitychange'))"
    )
    browser.wait_for("(await paint3d.score()).includes('follow_time')")  # while the pen is down
    browser.call("Input.dispatchMouseEvent", x=590.0, y=330.0, **LIFTED)
    begin_with(browser, SHEET)
    let_spread(browser, on=True)
    browser.stroke(wave(350.0, 330.0), lifts=False)
    browser.wait_for("(await paint3d.score()).includes('follow_time')")
    browser.call("Input.dispatchMouseEvent", x=590.0, y=330.0, **LIFTED)
    browser.wait_for(r"/follow_time.*times\":(\d\d|[6-9])/.test(await paint3d.score())")
    browser.stroke(wave(350.0, 360.0))
    let_spread(browser, on=False)
    spread = settled(browser)
    assert spread["amounts"] != laid["amounts"]
    browser.evaluate("document.getElementById('dry').click()")
    dried = settled(browser)
    assert dried["amounts"] != spread["amounts"]
    browser.evaluate("document.getElementById('undo').click()")
    let_spread(browser, on=True)
    browser.wait_for("(await paint3d.score()).split('undo')[1].includes('follow_time')")
    let_spread(browser, on=False)
    assert settled(browser) == by_the_desktop(browser, tmp_path)


def test_what_is_erased_goes_as_on_the_desktop(browser: Browser, tmp_path: Path) -> None:
    begin_with(browser, SHEET)
    browser.stroke(wave(350.0, 330.0))
    browser.stroke(wave(350.0, 360.0))
    painted_before = settled(browser)
    browser.evaluate("document.getElementById('erase').click()")
    browser.stroke([(450.0, 280.0 + 2.5 * k, 0.5) for k in range(60)])
    erased = settled(browser)
    assert erased["srgb"] != painted_before["srgb"]
    browser.evaluate("document.getElementById('erase').click()")
    browser.stroke(wave(350.0, 420.0))
    found = settled(browser)
    assert browser.evaluate("paint3d.score()").count('"erase":true') == 1
    assert found == by_the_desktop(browser, tmp_path)


def test_strokes_on_layers_look_as_on_the_desktop(browser: Browser, tmp_path: Path) -> None:
    begin_with(browser, SHEET)
    browser.stroke(wave(350.0, 330.0))
    browser.evaluate("document.getElementById('add').click()")
    settled(browser)
    browser.evaluate("(gone => { gone.click(); gone.click(); })(document.getElementById('gone1'))")
    settled(browser)
    assert browser.evaluate("document.querySelectorAll('.layer').length") == 1
    browser.evaluate("document.getElementById('undo').click()")
    choose(browser, "inks", 1)
    browser.stroke(wave(350.0, 350.0))
    both = settled(browser)
    browser.evaluate("document.getElementById('seen0').click()")
    assert settled(browser)["srgb"] != both["srgb"]
    browser.evaluate("document.getElementById('up0').click()")
    assert settled(browser) == by_the_desktop(browser, tmp_path)


@pytest.mark.parametrize(
    ("width", "height"), [(360, 740), (390, 844), (844, 390), (820, 1180), (1280, 800)]
)
def test_tools_are_named_and_lie_whole_in_rows_that_leave_the_picture_free(
    width: int, height: int, browser: Browser
) -> None:
    begin_with(browser, SHEET)
    is_phone = min(width, height) < 600
    at = {"deviceScaleFactor": 1, "mobile": is_phone}
    try:
        browser.call("Emulation.setDeviceMetricsOverride", width=width, height=height, **at)
        browser.call("Emulation.setTouchEmulationEnabled", enabled=is_phone)
        for _ in range(2):
            browser.evaluate("document.getElementById('language').click()")
            tops = set()
            for row in ("tools", "acts"):
                box, *within = browser.evaluate(
                    f"(row => [row, ...row.querySelectorAll('button, select, label > span')])"
                    f"(document.getElementById('{row}')).map(e =>"
                    " (b => [b.left, b.top, b.right, b.bottom])(e.getBoundingClientRect()))"
                )
                assert box[3] - box[1] <= 60
                tops.add(box[1])
                for left, top, right, bottom in within:
                    assert max(0, box[0]) <= left < right <= min(width, box[2])
                    assert box[1] <= top < bottom <= box[3]
            assert len(tops) == (2 if width < height and is_phone else 1)
            said = browser.evaluate("document.getElementById('hint').textContent")
            assert not (is_phone and "Ctrl" in said)
        for tab in ("layers", "save", "more"):
            browser.evaluate("document.querySelector('.opener[aria-expanded=true]')?.click()")
            browser.evaluate(f"document.getElementById('show-{tab}').click()")
            cut, fades = browser.evaluate(
                "(p => [p.scrollHeight > p.clientHeight + 2, p.classList.contains('goes-on')])"
                "(document.getElementById('panel'))"
            )
            assert cut == fades
            assert not cut or height < 480
        browser.evaluate("document.getElementById('show-more').click()")
    finally:
        browser.call("Emulation.setTouchEmulationEnabled", enabled=False)
        browser.call(
            "Emulation.setDeviceMetricsOverride", width=960, height=720, deviceScaleFactor=1,
            mobile=False,
        )  # fmt: skip


def test_what_was_undone_is_done_again_and_a_name_stays(browser: Browser, tmp_path: Path) -> None:
    begin_with(browser, SHEET)
    dry, redo = "document.getElementById('dry')", "document.getElementById('redo')"
    assert browser.evaluate(f"[{dry}.disabled, {redo}.disabled]") == [True, True]
    browser.stroke(wave(350.0, 330.0))
    painted_first = settled(browser)
    assert browser.evaluate(f"{dry}.disabled") is False
    choose(browser, "blend", 1)
    name = "document.getElementById('name')"
    browser.evaluate(f"{name}.value = '题款'; {name}.dispatchEvent(new Event('change'))")
    settled(browser)
    browser.evaluate("for (const _ of [1, 2]) document.getElementById('undo').click()")
    assert settled(browser)["amounts"] != painted_first["amounts"]
    assert browser.evaluate(f"[{dry}.disabled, {redo}.disabled]") == [True, False]
    assert browser.evaluate("document.getElementById('layer0').innerText") == "题款"
    assert browser.evaluate("document.getElementById('blend').selectedIndex") == 0
    browser.evaluate(f"for (const _ of [1, 2]) {redo}.click()")
    settled(browser)
    assert browser.evaluate("document.getElementById('blend').selectedIndex") == 1
    browser.stroke(wave(350.0, 420.0))
    found = settled(browser)
    assert browser.evaluate(f"{redo}.disabled") is True
    assert found == by_the_desktop(browser, tmp_path)


@pytest.mark.parametrize("place", [SHEET, BOWL])
def test_a_text_lies_where_the_desktop_lays_it_and_a_planned_hand_fills_it(
    place: int, browser: Browser, tmp_path: Path
) -> None:
    begin_with(browser, place)
    at = "document.getElementById('{}')".format
    open_copybook(browser)
    browser.wait_for(at("addText"))
    browser.wait_for("paint3d.isKept")
    browser.evaluate(f"{at('addText')}.click()")
    settled(browser)
    change = "(e => {{ e.value = {}; e.dispatchEvent(new Event('change')); }})({})".format
    if place == SHEET:  # which the text fills
        laid = json.loads(browser.evaluate("paint3d.score()").splitlines()[-1])["text"]
        assert laid["em_mm"] == 261.2
        assert not browser.evaluate(f"Boolean({at('fit')})")
        browser.evaluate(change(300, at("em")))
        settled(browser)
        browser.evaluate(f"{at('fit')}.click()")
        settled(browser)
        fitting = json.loads(browser.evaluate("paint3d.score()").splitlines()[-1])["text"]["em_mm"]
        assert fitting == pytest.approx(2 * (170 - 30.6), abs=0.02 * fitting)
        assert not browser.evaluate(f"Boolean({at('fit')})")
        browser.evaluate(change(40, at("em")))
        settled(browser)
    browser.evaluate(f"{at('place')}.click()")  # away from the bowl's wall, which is near the hand
    browser.stroke([(430.0, 430.0, 0.5), (430.0, 430.0, 0.5)])
    browser.evaluate(f"{at('sign')}.click()")
    settled(browser)
    browser.evaluate(f"{at('place')}.click()")
    browser.stroke([(330.0, 500.0, 0.5), (330.0, 500.0, 0.5)])
    browser.evaluate(change("'年永\\n和'", at("text")))
    browser.evaluate(change(30, at("turn")))
    browser.evaluate(change(12, at("em")))
    browser.evaluate(f"{at('undo')}.click()")
    settled(browser)
    lines = np.array(browser.evaluate("paint3d.guides().outlines")).reshape(-1, 3)
    bare = settled(browser)
    choose(browser, "brush", 1)
    browser.wait_for("(await paint3d.score()).includes('set_brush')")
    browser.evaluate(change(0, at("texts")).replace("value", "selectedIndex"))
    meanwhile = browser.evaluate(
        f"{at('write')}.click(); new Promise(done => {{ const look = async () => {{"
        "if (!(await paint3d.score()).includes('begin_stroke')) return setTimeout(look);"
        f"const brush = {at('brush')}; brush.selectedIndex = 1;"
        "brush.dispatchEvent(new Event('change'));"  # which the hand that writes keeps
        f"done([{at('tools')}.inert, {at('panel')}.inert, await paint3d.score()]); }}; look(); }})"
    )
    assert meanwhile[:2] == [True, True]
    assert "end_stroke" not in meanwhile[2]
    browser.wait_for("(await paint3d.score()).includes('end_stroke')")
    browser.wait_for(f"!{at('tools')}.inert && !{at('panel')}.inert")
    assert browser.evaluate(f"{at('brush')}.selectedIndex") == 0
    found = settled(browser)
    assert found["amounts"] != bare["amounts"]
    path = tmp_path / "page.score.jsonl"
    path.write_text(browser.evaluate("paint3d.score()"), "utf-8")
    score = load_score(path)
    mesh = load_mesh(score.header["object"])
    document = painted(score, mesh)
    hashes = hashes_of(document.surface)
    assert found == {name: hashes[name] for name in ("vertices", "srgb", "amounts")}
    assert [(one.text, one.em_mm, one.turn) for one in document.texts] == [
        ("一", 40.0, 0.0), ("年永\n和", 14.0, 30.0)
    ]  # fmt: skip
    ghosts = [ghost for laid in document.texts for ghost in Copybook.of(mesh, laid).ghosts]
    ours = np.concatenate([line for ghost in ghosts for line in ghost.outlines])
    away = cKDTree(ours).query(lines)[0]
    assert away.max() < (0.15 if place == SHEET else 0.8)
    assert cKDTree(lines).query(ours)[0].max() < 2.0  # points of ours lie up to 1/32 em apart
    middle = next(ghost for ghost in ghosts if ghost.text == "一").chart.frame.origin
    inside = np.linalg.norm(document.surface.paint_mesh.vertices - middle, axis=1) < 25.0
    painted_share = document.surface.coverage[inside] > 0.0
    assert painted_share.any()
    assert not (document.surface.coverage[~inside] > 0.0).any()


def test_a_move_ends_with_the_text_that_was_to_be_moved(browser: Browser) -> None:
    begin_with(browser, SHEET)
    at = "document.getElementById('{}')".format
    open_copybook(browser)
    browser.wait_for(at("addText"))
    locked = {"modifiers": 2, "key": "Z", "code": "KeyZ", "windowsVirtualKeyCode": 90}
    for take_off in (
        lambda: browser.evaluate(f"{at('takeOff')}.click()"),
        lambda: browser.call("Input.dispatchKeyEvent", type="keyDown", **locked),
    ):
        browser.evaluate(f"{at('addText')}.click()")
        settled(browser)
        browser.evaluate(f"{at('place')}.click()")
        take_off()
        settled(browser)
        assert browser.evaluate("paint3d.guides().outlines.length") == 0
        browser.stroke(wave(350.0, 500.0)[::8])
        settled(browser)
    score = browser.evaluate("paint3d.score()")
    assert (score.count("lay_text"), score.count("begin_stroke")) == (2, 2)
    removed = score.count("remove_text")
    for _ in range(2):
        browser.evaluate(f"{at('addText')}.click()")
        settled(browser)
    n = browser.evaluate("paint3d.guides().outlines.length")
    browser.evaluate(f"(off => {{ off.click(); off.click(); }})({at('takeOff')})")
    settled(browser)
    assert browser.evaluate("paint3d.guides().outlines.length") == n / 2 > 0
    assert browser.evaluate("paint3d.score()").count("remove_text") == removed + 1
    browser.evaluate(f"{at('text')}.focus()")
    escape = {"key": "Escape", "code": "Escape", "windowsVirtualKeyCode": 27}
    browser.call("Input.dispatchKeyEvent", type="keyDown", **escape)
    assert browser.evaluate(f"{at('panel')}.hidden")


def with_text(browser: Browser, words: dict[str, Any]) -> None:
    """Open a fresh sheet's score with a text that a desktop has laid."""
    (head, *_) = browser.evaluate("paint3d.score()").splitlines()
    score = f"{head}\n{json.dumps({'do': 'lay_text', 'text': words})}\n"
    browser.evaluate(
        "fetch('contents.json').then(r => r.json())"
        f".then(c => paint3d.open(c, c.objects[{SHEET}], {{ score: {json.dumps(score)} }}))"
    )


def test_a_text_of_the_desktop_lies_in_the_page_as_it_does_there(
    browser: Browser,
) -> None:
    begin_with(browser, SHEET)
    mesh = load_mesh("square")
    for laid in (
        LaidText("永和\n年", 12.0, point=(3.0, 5.0, 0.0), gap=0.6, between=0.4, grid="columns"),
        LaidText("永和\n年", 12.0, order="row", point=(3.0, 5.0, 0.0), grid="columns"),
        LaidText("", 10.0, point=(0.0, 0.0, 0.0), cells=(3, 2)),
        LaidText("永", point=(0.0, 0.0, 0.0)),
    ):
        with_text(browser, laid.words())
        book = Copybook.of(mesh, laid)
        outlines = [line for ghost in book.ghosts for line in ghost.outlines]
        grid = book.grid(laid.grid, laid.order == "columns")
        guides = browser.evaluate("paint3d.guides()")
        for ours, theirs in ((outlines, "outlines"), (grid, "grid")):
            lines = np.array(guides[theirs]).reshape(-1, 3)
            assert (len(lines) > 0) == (len(ours) > 0)
            if ours:
                assert cKDTree(np.concatenate(ours)).query(lines)[0].max() < 1.0
                assert cKDTree(lines).query(np.concatenate(ours))[0].max() < 1.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"font": "Kai"}, 'the font of a text is "Kai"; expected none'),
        ({"point": None}, "the point of a text is null; expected three numbers, mm"),
        ({"grid": "stars"}, 'the grid of a text is "stars"; expected frame or mi or '),
        ({"em_mm": "large"}, 'the em_mm of a text is "large"; expected 2 to 1000'),
    ],
)
def test_a_text_that_a_page_cannot_lay_is_refused_in_words(
    words: dict[str, Any], said: str, browser: Browser
) -> None:
    begin_with(browser, SHEET)
    with pytest.raises(AssertionError) as refused:
        with_text(browser, {"text": "永", "point": [0.0, 0.0, 0.0]} | words)
    assert f"RecordingError: line 2: {said}" in refused.value.args[0]["exception"]["description"]


@pytest.mark.parametrize("place", [SHEET, BOWL])
def test_a_seal_is_pressed_where_one_taps_as_on_the_desktop(
    place: int, browser: Browser, tmp_path: Path
) -> None:
    begin_with(browser, place)
    at = "document.getElementById('{}')".format
    open_copybook(browser)
    browser.wait_for(at("press-seal"))
    change = "(e => {{ e.value = {}; e.dispatchEvent(new Event('{}')); }})({})".format
    note = f"{at('seal-text')}.closest('section').querySelector('.note')"
    for text, said in (("永和九年書", "1 to 4 characters, not 5"), ("永☃", "Not in this page: ☃")):
        browser.evaluate(change(f"'{text}'", "input", at("seal-text")))
        assert said in browser.evaluate(f"{note}.textContent")
        assert browser.evaluate(f"{at('press-seal')}.disabled")
    browser.evaluate(change("'永和'", "input", at("seal-text")))
    browser.evaluate(change(16, "input", at("seal-size")))  # what a signature wished before
    browser.evaluate(change(20, "input", at("seal-turn")))
    browser.stroke(wave(330.0, 330.0, 160.0))
    bare, tap = settled(browser), [(410.0, 345.0, 0.5)] * 2
    press, undo, redo = (f"{at(name)}.click()" for name in ("press-seal", "undo", "redo"))
    browser.evaluate(press)
    browser.stroke(wave(350.0, 420.0, 60.0))  # no tap, and no stroke
    assert settled(browser) == bare
    browser.stroke(tap)
    pressed = settled(browser)
    assert pressed["srgb"] != bare["srgb"]
    browser.evaluate(undo)
    assert settled(browser)["srgb"] != pressed["srgb"]
    browser.evaluate(redo)
    assert settled(browser) == pressed
    if place == SHEET:
        browser.evaluate(press)
        for x in range(20, 340, 10):  # up to the first place on the sheet, which ends there
            browser.stroke([(float(x), 345.0, 0.5)] * 2)
            settled(browser)
            if "no room for the seal" in browser.evaluate(f"{at('hint')}.textContent"):
                break
        else:
            pytest.fail("the sheet ends nowhere")
        assert settled(browser) == pressed
    score = browser.evaluate("paint3d.score()")
    assert (score.count("press_seal"), score.count("begin_stroke")) == (1, 1)
    assert pressed == by_the_desktop(browser, tmp_path)
    line = json.loads(next(line for line in score.splitlines() if "press_seal" in line))
    cut, ours = Polygon(), Polygon()
    for ring in line["rings"]:
        cut = cut.symmetric_difference(Polygon(ring))
    for ring in cut_seal("永和").rings:
        ours = ours.symmetric_difference(Polygon(ring))
    assert cut.symmetric_difference(ours).area < 0.03 * ours.area


def test_what_cannot_be_opened_says_why(browser: Browser) -> None:
    begin_with(browser, SHEET)
    browser.stroke(wave(350.0, 330.0))
    before, (head, *rest) = settled(browser), browser.evaluate("paint3d.score()").splitlines()
    words = json.loads(head)

    def said_of(name: str, text: str) -> str:
        browser.evaluate("document.getElementById('hint').textContent = ''")
        drop(browser, name, text.encode())
        browser.wait_for("document.getElementById('hint').textContent")
        said: str = browser.evaluate("document.getElementById('hint').textContent")
        return said

    for changed, said in (
        ({"object": "teapot"}, "it was painted on teapot at 0.8 mm, which this page does not have"),
        ({"ink": {"walnut": 1.0}}, 'its first ink, {"walnut":1}, is none of this page\'s'),
        ({"brush": "mop"}, "this page has no Brush called mop"),
        ({"material": "slate"}, "this page has no Material called slate"),
        ({"mesh": "0"}, "its square has another shape than this page's"),
        ({"format": "diary"}, "its first line says no format"),
    ):
        text = "\n".join([json.dumps(words | changed), *rest])
        assert f"{said}." in said_of("a.jsonl", text)
        assert browser.evaluate(MESSAGE) == ""
    flown = "\n".join([head, json.dumps({"do": "fly"})])
    assert "line 2: a page does not know fly" in said_of("a.jsonl", flown)
    ours = "it was painted on cup.glb, a file of somebody's own: open that here first."
    assert ours in said_of("a.jsonl", json.dumps(words | {"object": "cup.glb"}))
    for name, text, said in (
        ("cup.glb", "glTF", "cup.glb cannot be opened: it is no text that glTF could be"),
        ("cup.usdz", "", "USD is not read (Blender saves it as .glb); expected one of .glb .obj"),
        ("cup.off", "OFF", "a page does not read .off, the desktop does; expected one of .glb"),
        ("cup.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3", "cup: none of 1 faces has an area"),
    ):
        assert said in said_of(name, text)
        assert browser.evaluate(MESSAGE) == ""
    browser.evaluate(
        "window.Own = Worker;"
        "window.Worker = class { constructor() { throw Error('no workers') } }; 0"
    )
    assert "cup.obj cannot be opened: no workers." in said_of(name, text)
    browser.evaluate("document.getElementById('replay').click()")
    browser.wait_for(
        "document.getElementById('hint').textContent === 'square cannot be opened: no workers.'"
    )
    assert browser.evaluate(MESSAGE) == ""
    assert not browser.evaluate("document.getElementById('tools').inert")
    browser.evaluate("window.Worker = window.Own; 0")
    browser.evaluate(
        "window.read = Blob.prototype.arrayBuffer;"
        "window.size = Object.getOwnPropertyDescriptor(Blob.prototype, 'size');"
        "Blob.prototype.arrayBuffer = () => Promise.reject(Error('it is a folder')); 0"
    )
    assert "cup.obj cannot be opened: it is a folder." in said_of(name, text)
    browser.evaluate(
        "Object.defineProperty(Blob.prototype, 'size', {get: () => 2 ** 29, configurable: true}); 0"
    )
    assert "it is larger than 268,435,456 bytes; expected less" in said_of(name, text)
    browser.evaluate(
        "Blob.prototype.arrayBuffer = window.read;"
        "Object.defineProperty(Blob.prototype, 'size', window.size); 0"
    )
    browser.evaluate("document.getElementById('language').click()")
    assert "无法打开 cup.obj：cup：1 个面都没有面积" in said_of(name, text)
    browser.evaluate("document.getElementById('language').click()")
    assert settled(browser) == before


def drop(browser: Browser, name: str, data: bytes) -> None:
    """Drop a file on the page."""
    browser.evaluate(
        f"(d => {{ const bytes = Uint8Array.from(atob('{base64.b64encode(data).decode()}'),"
        f" c => c.charCodeAt(0)); d.items.add(new File([bytes], '{name}'));"
        "document.body.dispatchEvent(new DragEvent('drop',"
        " {dataTransfer: d, bubbles: true, cancelable: true})); })(new DataTransfer())"
    )


def test_an_object_of_ones_own_is_painted_on_and_is_there_again(
    browser: Browser, address: str, tmp_path: Path
) -> None:
    begin_with(browser, SHEET)
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=30.0)
    mesh.apply_scale([1.2, 1.0, 0.7])
    span = np.ptp(mesh.vertices, axis=0)
    mesh.visual.vertex_colors = (155.0 + 100.0 * (mesh.vertices - mesh.bounds[0]) / span).astype(
        "u1"
    )
    file = tmp_path / "pebble.ply"
    file.write_bytes(mesh.export(file_type="ply"))
    drop(browser, file.name, file.read_bytes())
    browser.wait_for("document.querySelector('#cancel')")
    browser.evaluate("document.querySelector('#cancel').click()")
    browser.wait_for(OPEN)
    assert "square" in browser.evaluate("paint3d.score()")
    drop(browser, file.name, file.read_bytes())
    browser.wait_for(f"(await paint3d.score()).includes('pebble.ply') && {OPEN}")
    bare = settled(browser)
    choose(browser, "fineness", 4)
    choose(browser, "up", 2)  # y, while the other is still awaited
    browser.wait_for("(await paint3d.score()).includes('\"resolution_mm\":0.8') && " + OPEN)
    browser.stroke(wave(350.0, 330.0, 200.0), tiltX=20, tiltY=10)
    browser.stroke(wave(350.0, 400.0, 200.0))
    found, score = settled(browser), browser.evaluate("paint3d.score()")
    assert found["vertices"] > bare["vertices"]
    browser.wait_for("paint3d.isKept")
    open_again(browser, address)
    assert settled(browser) == found
    path = tmp_path / "pebble.score.jsonl"
    path.write_text(score, "utf-8")
    surface = painted(load_score(path), load_mesh(file, up="y")).surface
    hashes = hashes_of(surface)
    assert found == {name: hashes[name] for name in ("vertices", "srgb", "amounts")}
    begin_with(browser, SHEET)
    drop(browser, "a.score.jsonl", score.encode())
    browser.wait_for(f"(await paint3d.score()).includes('pebble.ply') && {OPEN}")
    assert settled(browser) == found


def test_what_is_opened_last_is_opened(browser: Browser) -> None:
    begin_with(browser, SHEET)
    browser.evaluate(
        "window.Own = Worker; window.ended = 0; window.Worker = class extends Worker {"
        " terminate() { window.ended++; super.terminate(); } }; 0"
    )
    ball = trimesh.creation.icosphere(subdivisions=4, radius=30.0)
    drop(browser, "ball.ply", ball.export(file_type="ply"))
    browser.wait_for("document.querySelector('#message:not([hidden]) #cancel')")
    choose(browser, "object", BOWL)
    browser.wait_for(f"window.ended === 1 && {OPEN}")
    browser.evaluate("window.Worker = window.Own; 0")
    browser.evaluate(
        "window.post = Worker.prototype.postMessage; window.begun = 0;"
        "Worker.prototype.postMessage = function (asked)"
        " { window.begun += 'open' in asked; post.call(this, asked); };"
        "for (const _ of [1, 2]) document.getElementById('fresh').click()"
    )
    browser.wait_for(f"window.begun > 0 && {OPEN}")
    assert browser.evaluate("window.begun") == 1  # the first ends before it has begun
    browser.evaluate("Worker.prototype.postMessage = window.post; 0")
    browser.stroke(wave(380.0, 360.0, 200.0))
    assert '"object":"bowl"' in browser.evaluate("paint3d.score()")


def test_a_long_recording_is_cancelled_and_the_piece_in_hand_stays(browser: Browser) -> None:
    begin_with(browser, SHEET)
    browser.stroke(wave(350.0, 330.0))
    before, (head, *rest) = settled(browser), browser.evaluate("paint3d.score()").splitlines()
    rows, many = list(map(json.loads, rest)), [head]
    for k in range(60):
        for row in rows:
            later = {"time_ns": row["time_ns"] + k * 10**10} if "time_ns" in row else {}
            many.append(json.dumps(row | later))
    drop(browser, "long.score.jsonl", "\n".join(many).encode())
    progress = "document.querySelector('#message:not([hidden]) #cancel')"
    browser.wait_for(progress)
    browser.evaluate(
        "window.canvas = document.getElementById('canvas'); window.lost = canvas.getContext("
        "'webgl2').getExtension('WEBGL_lose_context'); lost.loseContext()"
    )
    browser.wait_for(progress)
    assert browser.evaluate(  # at once: soon it is said anew how far that is
        f"new Promise(done => {{ canvas.addEventListener('webglcontextrestored', () =>"
        f" done({progress} !== null)); lost.restoreContext(); }})"
    )
    browser.evaluate("document.querySelector('#cancel').click()")
    browser.wait_for(OPEN)
    assert settled(browser) == before
    assert len(browser.evaluate("paint3d.score()").splitlines()) == 1 + len(rest)


def open_again(browser: Browser, address: str) -> None:
    browser.call("Page.navigate", url=address)
    browser.wait_for("document.readyState === 'complete'")
    browser.wait_for(OPEN)


def test_a_piece_is_there_again_when_the_page_is_opened_again(
    browser: Browser, address: str, tmp_path: Path
) -> None:
    begin_with(browser, BOWL)
    browser.stroke(wave(380.0, 360.0, 200.0), tiltX=20, tiltY=10)
    choose(browser, "brush", 1)
    browser.wait_for("(await paint3d.score()).includes('set_brush')")
    browser.stroke(wave(380.0, 420.0, 160.0))
    found, score = settled(browser), browser.evaluate("paint3d.score()")
    browser.wait_for("paint3d.isKept")
    open_again(browser, address)
    assert settled(browser) == found
    assert browser.evaluate("paint3d.score()") == score
    assert browser.evaluate("document.getElementById('brush').selectedIndex") == 1
    way = wave(380.0, 390.0, 160.0)
    browser.stroke(way)  # this page's clock is behind what the first has painted
    again = settled(browser)
    assert browser.evaluate("paint3d.score()").count("time_ns") > score.count("time_ns") + 10
    browser.stroke(way, lifts=False)  # and it is closed, or has crashed, before the stroke ends
    settled(browser)
    browser.wait_for("paint3d.isKept")
    for _ in range(2):
        open_again(browser, address)
        unended = settled(browser)
        assert unended["amounts"] != again["amounts"]
        score = browser.evaluate("paint3d.score()")
        assert score.count("begin_stroke") == score.count("end_stroke") == 4
        browser.wait_for("paint3d.isKept")
    assert unended == by_the_desktop(browser, tmp_path)


def steps_of(score: str) -> list[dict[str, Any]]:
    """The lines of a score, one for each time step of wet ink."""
    rows = [json.loads(line) for line in score.splitlines()]
    return [row for row in rows for _ in range(row.pop("times", 1))]


def test_a_replayed_piece_is_kept_as_it_is_seen(browser: Browser, address: str) -> None:
    begin_with(browser, SHEET)
    let_spread(browser, on=True)
    browser.stroke(wave(350.0, 330.0))
    browser.wait_for("(await paint3d.score()).includes('follow_time')")
    browser.evaluate(
        "window.post = Worker.prototype.postMessage; window.late = null;"
        "Worker.prototype.postMessage = function (asked) {"
        " if (asked.name !== 'score' || late) return post.call(this, asked);"
        " window.late = () => post.call(this, asked); };"
        "window.before = document.getElementById('object');"
        "document.getElementById('replay').click()"
    )
    browser.stroke(wave(350.0, 380.0))  # while it is asked what is played: none
    browser.evaluate("late(); Worker.prototype.postMessage = window.post; 0")
    browser.wait_for(
        "document.getElementById('object') !== window.before"
        f" && !document.getElementById('tools').inert && {OPEN}"
    )
    browser.stroke(wave(350.0, 430.0))
    let_spread(browser, on=False)
    settled(browser)
    seen = browser.evaluate("paint3d.score()")
    assert seen.count("begin_stroke") == 2
    browser.wait_for("paint3d.isKept")
    open_again(browser, address)
    again = steps_of(browser.evaluate("paint3d.score()"))
    assert again[: len(steps_of(seen))] == steps_of(seen)  # it may go on to spread


def test_a_painting_that_cannot_be_played_to_its_end_is_not_kept(
    browser: Browser, address: str
) -> None:
    begin_with(browser, BOWL)
    browser.stroke(wave(380.0, 360.0, 200.0))
    settled(browser)
    seen = browser.evaluate("paint3d.score()")
    browser.wait_for("paint3d.isKept")
    for end, said in (
        (2 * '{"do": "undo"}\n', "it goes back farther than a page keeps"),
        ('{"do": "follow_time", "seconds": 0.1}\n',
         "its ink flows in steps of 0.1 s; in a page these are 0.05 s"),
        ('{"do": "dip", "amount": {"wetted": 2}}\n',
         'a dip is {"wetted":2}; expected wetted, .001 to 1, and fullness, .05 to 3'),
        ('{"do": "dip", "reach": 0.3}\n', "a page does not play dip with reach"),
        ('{"do": "begin_stroke"}\n{"time_ns": 1, "force": 2}\n',
         "a page does not play a sample with force"),
    ):  # fmt: skip
        with pytest.raises(AssertionError) as refused:
            browser.evaluate(
                "fetch('contents.json').then(r => r.json()).then(c => paint3d.open(c,"
                f" c.objects[{BOWL}], {{ score: {json.dumps(seen + end)}, playedIn: 0 }}))"
            )
        assert said in str(refused.value)
    browser.stroke(wave(380.0, 420.0, 100.0))
    settled(browser)
    browser.wait_for("paint3d.isKept")
    open_again(browser, address)
    assert browser.evaluate("paint3d.score()") == seen
    browser.evaluate(
        "window.post = Worker.prototype.postMessage; Worker.prototype.postMessage ="
        " function (asked) { if (asked.name === 'play') asked.words[0] += '{\"do\": \"fly\"}\\n';"
        " post.call(this, asked); }; document.getElementById('replay').click()"
    )
    browser.wait_for(f"{MESSAGE}.includes('Painting has ended: line')")
    assert "a page does not know fly" in browser.evaluate(MESSAGE)
    browser.heard.clear()  # what was meant to be complained of
    for act in ("replay", "undo"):
        browser.evaluate(f"document.getElementById('{act}').click()")
    settled(browser)
    assert "a page does not know fly" in browser.evaluate(MESSAGE)
    browser.wait_for("paint3d.isKept")
    open_again(browser, address)
    assert browser.evaluate("paint3d.score()") == seen


def test_what_cannot_be_had_now_is_had_later(browser: Browser, address: str) -> None:
    begin_with(browser, SHEET)
    open_again(browser, address)  # where no brush but the first is there yet
    hint = "document.getElementById('hint').textContent"
    browser.evaluate(  # a silent host, and a clock whose longest times end when it is said
        "window.had = fetch; window.late = []; window.shown = 0;"
        "window.fetch = (_, { signal }) => new Promise((_, failed) =>"
        " signal.addEventListener('abort', () => failed(signal.reason)));"
        "window.wait = setTimeout; window.setTimeout = (work, ms, ...words) =>"
        " ms < 15000 ? wait(work, ms, ...words) : late.push(work);"
        "window.post = Worker.prototype.postMessage;"
        "Worker.prototype.postMessage = function (asked)"
        " { window.shown += asked.name === 'pictureShown'; post.call(this, asked); }; 0"
    )
    silent = "late.splice(0).forEach(end => end())"
    open_copybook(browser)
    browser.wait_for("late.length === 2")
    browser.stroke(wave(350.0, 420.0))
    settled(browser)
    browser.evaluate(silent)
    browser.wait_for(f"/(copybook|seals).bin.gz cannot be had .*TimeoutError/.test({hint})")
    choose(browser, "brush", 1)
    browser.wait_for("late.length === 1")
    browser.evaluate("window.shown = 0; 0")
    browser.wait_for("window.shown > 3")  # wet ink spreads meanwhile
    browser.evaluate(silent)
    browser.wait_for(f"/xiaokai.bin.gz cannot be had .*nothing came for 20 s/.test({hint})")
    browser.evaluate(
        "window.setTimeout = window.wait; Worker.prototype.postMessage = window.post;"
        "window.fetch = async () => new Response('', { status: 503 });"
        "document.getElementById('show-copybook').click()"  # closed
    )
    choose(browser, "brush", 1)
    browser.wait_for(f"/brushes.xiaokai.bin.gz cannot be had from this host .503/.test({hint})")
    assert browser.evaluate("document.getElementById('brush').selectedIndex") == 0
    open_copybook(browser)
    browser.wait_for(f"/(copybook|seals).bin.gz cannot be had/.test({hint})")
    browser.wait_for("paint3d.isKept")
    browser.evaluate("window.fetch = window.had; 0")
    open_copybook(browser)
    choose(browser, "brush", 1)
    browser.wait_for("(await paint3d.score()).includes('set_brush')")
    for _ in range(2):
        browser.evaluate("document.getElementById('show-copybook').click()")
    browser.wait_for("document.getElementById('addText')")
    browser.stroke(wave(350.0, 330.0))
    settled(browser)
    assert "end_stroke" in browser.evaluate("paint3d.score()")


def test_what_is_awaited_of_a_thread_that_fails_or_is_closed_ends(browser: Browser) -> None:
    begin_with(browser, SHEET)
    browser.stroke(wave(350.0, 330.0))
    settled(browser)
    browser.evaluate(
        "window.post = Worker.prototype.postMessage;"
        "Worker.prototype.postMessage = function (asked)"
        " { window.thread = this; if (asked.name !== 'score') post.call(this, asked); }; 0"
    )
    browser.evaluate("document.getElementById('score').click()")
    browser.evaluate(
        "window.ended = paint3d.score().catch(cause => cause.message);"
        "thread.dispatchEvent(new ErrorEvent('error', { message: 'a bolt', cancelable: true }))"
    )
    assert browser.evaluate("ended") == "a bolt"
    assert "Painting has ended: a bolt" in browser.evaluate(MESSAGE)
    assert not [said for said in browser.complaints() if "Uncaught" in said]
    browser.heard.clear()  # what was meant to be complained of
    browser.evaluate("window.ended = paint3d.score().catch(cause => cause.name); 0")
    browser.evaluate("Worker.prototype.postMessage = window.post; 0")
    begin_with(browser, SHEET)
    assert browser.evaluate("ended") == "Cancelled"
    browser.wait_for("paint3d.isKept")


def test_a_piece_whose_file_cannot_be_kept_is_not_joined_to_the_one_before(
    browser: Browser, address: str
) -> None:
    begin_with(browser, SHEET)
    browser.stroke(wave(350.0, 330.0))
    settled(browser)
    browser.wait_for("paint3d.isKept")
    browser.evaluate(
        "window.add = IDBObjectStore.prototype.add; IDBObjectStore.prototype.add = function (one)"
        " { if (this.name === 'object') this.transaction.abort();"
        " else return add.call(this, one) }; 0"
    )
    ball = trimesh.creation.icosphere(subdivisions=2, radius=30.0)
    drop(browser, "ball.ply", ball.export(file_type="ply"))
    browser.wait_for(f"(await paint3d.score()).includes('ball.ply') && {OPEN}")
    browser.stroke(wave(380.0, 360.0, 100.0))
    settled(browser)
    assert not browser.evaluate("paint3d.isKept")
    asked = "indexedDB.open('paint3d').onsuccess = e => { const db = e.target.result;"
    asked += "db.transaction('score').objectStore('score').getAll().onsuccess = r => {"
    rows = browser.evaluate(
        f"new Promise(done => {{ {asked} db.close(); done(r.target.result); }} }} }})"
    )
    assert rows == []
    browser.evaluate("IDBObjectStore.prototype.add = window.add; 0")
    begin_with(browser, SHEET)
    browser.wait_for("paint3d.isKept")


def test_what_is_saved_other_programs_read(browser: Browser, tmp_path: Path) -> None:
    begin_with(browser, BOWL)
    browser.stroke(wave(380.0, 360.0, 200.0))
    settled(browser)
    painted_mesh = painted_by_the_desktop(browser, tmp_path).mesh
    for kind in ("glb", "ply"):
        browser.evaluate(
            "window.saved = new Promise(done => { URL.createObjectURL = blob => { const r = new"
            " FileReader(); r.onload = () => done(r.result.split(',')[1]); r.readAsDataURL(blob);"
            " return 'blob:none'; }; HTMLAnchorElement.prototype.click = () => {}; });"
            f"document.getElementById('{kind}').click()"
        )
        (tmp_path / f"a.{kind}").write_bytes(base64.b64decode(browser.evaluate("saved")))
        scene = trimesh.load_scene(tmp_path / f"a.{kind}", process=False)
        (mesh,) = scene.geometry.values()
        scale = 1000.0 if kind == "glb" else 1.0
        x, y, z = scale * mesh.vertices.T
        points = np.column_stack([x, -z, y]) if kind == "glb" else mesh.vertices
        np.testing.assert_allclose(points, painted_mesh.vertices, atol=1e-4)
        np.testing.assert_array_equal(mesh.faces, painted_mesh.faces)
        if kind == "glb":  # linear light
            linear = mesh.visual.vertex_attributes["color"][:, :3]
            codes = np.rint(255.0 * encode_srgb(linear / np.iinfo(linear.dtype).max))
        else:
            codes = mesh.visual.vertex_colors[:, :3]
        np.testing.assert_array_equal(codes, painted_mesh.colours)


def test_a_tilted_pen_paints_under_its_point(browser: Browser, tmp_path: Path) -> None:
    begin_with(browser, SHEET)
    before = picture(browser, tmp_path / "before.png")
    for x, tilt in ((420.0, 0), (480.0, 30), (540.0, 60)):
        down = [(x, 350.0 + 2.0 * k, 0.35) for k in range(60)]
        browser.stroke(down, tiltX=tilt, tiltY=0)
    settled(browser)
    dark = before - picture(browser, tmp_path / "after.png") > 60.0
    for x in (420, 480, 540):
        row = np.flatnonzero(dark[410, x - 28 : x + 28]) + x - 28
        assert len(row)
        assert abs(row.mean() - x) < 8.0, x


def test_a_stroke_in_the_bowl_is_painted_by_the_desktop_to_the_bit(
    browser: Browser, tmp_path: Path
) -> None:
    begin_with(browser, BOWL)
    browser.stroke(wave(380.0, 360.0, 200.0), tiltX=20, tiltY=10)
    found = settled(browser)
    assert found == by_the_desktop(browser, tmp_path)


def test_yong_by_a_tilted_pen_in_the_bowl_is_filmed_and_painted_by_the_desktop(
    browser: Browser, tmp_path: Path
) -> None:
    """`PAINT3D_FILM` names a file where the film is kept."""
    begin_with(browser, BOWL)
    choose(browser, "brush", 0)
    browser.wait_for("(await paint3d.score()).includes('set_brush')")
    choose(browser, "inks", 0)
    browser.evaluate("document.querySelector('.opener[aria-expanded=true]')?.click()")
    pictures = [picture(browser, tmp_path / "0.png")]
    pen = {"pointerType": "pen", "button": "left", "clickCount": 1, "tiltX": 30, "tiltY": 18}
    (glyph,) = load_glyphs(open_glyphs(None), "永").values()
    strokes = [glyph.strokes[k].median[::3] - np.array(glyph.middle) for k in range(5)]
    asked: list[tuple[str, dict[str, Any]]] = []
    for median in strokes:
        xy = np.array([480.0, 350.0]) + median * [0.26, -0.24]
        kinds = ["mousePressed", *["mouseMoved"] * (len(xy) - 1), "mouseReleased"]
        for k, kind in enumerate(kinds):
            x, y = xy[min(k, len(xy) - 1)].tolist()
            force = 0.1 + 0.28 * math.sin(math.pi * (k + 1) / len(kinds))
            up = {"force": 0.0, "buttons": 0} if kind == "mouseReleased" else {"force": force}
            words = {"type": kind, "x": x, "y": y, "buttons": 1, **pen, **up}
            asked.append(("Input.dispatchMouseEvent", words))
            if k % 6 == 5 or k == len(kinds) - 1:
                browser.call_all(asked)
                asked.clear()
                browser.evaluate("paint3d.shown()")
                path = tmp_path / f"{len(pictures)}.png"
                pictures.append(picture(browser, path))
    found = settled(browser)
    film = Path(os.environ.get("PAINT3D_FILM", tmp_path / "yong.webp"))
    shown = []
    for k in range(len(pictures)):
        with Image.open(tmp_path / f"{k}.png") as one:
            shown.append(one.convert("RGB").resize((640, 480), Image.Resampling.LANCZOS))
    first, *others = shown
    durations = [70] * len(others) + [2000]
    first.save(film, save_all=True, append_images=others, duration=durations, loop=0, quality=80)
    assert browser.evaluate("paint3d.score()").count("end_stroke") == len(strokes)
    with Image.open(film) as kept:
        assert kept.n_frames > 5 * len(strokes)
    # ink, which is darker than the line that runs ahead of it
    dark = [np.count_nonzero((pictures[0] - one)[60:680] > 120.0) for one in pictures]
    assert np.mean(np.diff(dark) >= -20) > 0.9  # ink comes, and does not go
    assert dark[-1] > 3000
    ours = by_the_desktop(browser, tmp_path)
    print(f"in the page {found}, on the desktop {ours}")  # seen with -s
    assert found == ours


def test_strokes_that_follow_each_other_within_a_frame_are_all_painted(browser: Browser) -> None:
    begin_with(browser, SHEET)
    for y in (330.0, 420.0, 500.0):
        browser.stroke(wave(350.0, y)[::8])
    settled(browser)
    score = browser.evaluate("paint3d.score()")
    assert score.count("begin_stroke") == score.count("end_stroke") == 3


def test_keys_do_as_in_the_window(browser: Browser, tmp_path: Path) -> None:
    begin_with(browser, BOWL)
    browser.evaluate("document.activeElement.blur()")

    def press(key: str) -> None:
        browser.call("Input.dispatchKeyEvent", type="keyDown", key=key)
        browser.call("Input.dispatchKeyEvent", type="keyUp", key=key)

    def differs(name: str) -> bool:
        settled(browser)
        return bool(np.abs(picture(browser, tmp_path / name) - before)[60:640].max() > 20.0)

    settled(browser)
    before = picture(browser, tmp_path / "before.png")
    press("ArrowLeft")
    assert differs("turned.png")
    press("Home")
    assert not differs("again.png")
    press("2")
    browser.wait_for("(await paint3d.score()).includes('set_brush')")
    press("e")
    assert browser.evaluate("document.getElementById('erase').ariaPressed") == "true"
    press("e")
    dips = browser.evaluate("paint3d.score()").count('"dip"')
    press("d")
    assert browser.evaluate("paint3d.score()").count('"dip"') == dips + 1
    browser.stroke(wave(380.0, 360.0, 60.0), lifts=False)
    press("Escape")
    score = browser.evaluate("paint3d.score()")
    assert score.count("begin_stroke") == score.count('"undo"') == 1
    browser.call("Input.dispatchMouseEvent", x=440.0, y=360.0, **LIFTED)
    browser.evaluate("document.getElementById('inks').focus()")
    press("e")  # which chooses an ink there
    assert browser.evaluate("document.getElementById('erase').ariaPressed") == "false"
    browser.evaluate("document.activeElement.blur()")


def test_a_mouse_paints_by_a_made_pressure_and_the_right_button_turns(browser: Browser) -> None:
    begin_with(browser, BOWL)
    bare = settled(browser)
    for kind, button in (("right", 2), ("left", 1)):
        words = {"button": kind, "buttons": button, "clickCount": 1, "pointerType": "mouse"}
        ways = [("mousePressed", 420.0), *(("mouseMoved", 420.0 + 5.0 * k) for k in range(20))]
        asked = [
            ("Input.dispatchMouseEvent", {"type": what, "x": x, "y": 380.0, **words})
            for what, x in [*ways, ("mouseReleased", 515.0)]
        ]
        asked[-1][1]["buttons"] = 0
        browser.call_all(asked)
        assert (settled(browser)["amounts"] == bare["amounts"]) == (kind == "right")
        strokes = browser.evaluate("paint3d.score()").count("begin_stroke")
        assert strokes == (kind == "left")


def test_the_page_turns_the_object_while_a_long_stroke_is_painted(
    browser: Browser, tmp_path: Path
) -> None:
    begin_with(browser, BOWL)
    browser.stroke(wave(380.0, 360.0, 60.0)[:8], lifts=False)
    settled(browser)
    before = picture(browser, tmp_path / "before.png")
    browser.evaluate(  # more than the painter can have done soon, said at once
        "window.coalesced = PointerEvent.prototype.getCoalescedEvents;"
        "PointerEvent.prototype.getCoalescedEvents = function () { return Array.from("
        "{ length: 40000 }, (_, k) => ({ timeStamp: this.timeStamp + k, pointerType: 'pen',"
        " clientX: 440 + 60 * Math.cos(k / 50), clientY: 380 + 40 * Math.sin(k / 40),"
        " pressure: 0.4, tiltX: 0, tiltY: 0 })); }; 0"
    )
    pen = {"pointerType": "pen", "button": "left", "buttons": 1, "force": 0.4}
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=444.0, y=381.0, **pen)
    browser.evaluate(
        "PointerEvent.prototype.getCoalescedEvents = window.coalesced;"
        "window.painted = false; paint3d.score().then(() => (window.painted = true), () => {}); 0"
    )
    turning = {"button": "right", "buttons": 2, "pointerType": "mouse"}
    browser.call("Input.dispatchMouseEvent", type="mousePressed", x=700.0, y=300.0, **turning)
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=760.0, y=320.0, **turning)
    frame = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
    browser.evaluate(frame)
    for _ in range(3):  # the first may be of the frame before
        differs = np.abs(picture(browser, tmp_path / "turned.png") - before) > 30.0
        differs[280:480, 320:560] = False  # where it is painted
        if differs[60:640].sum() > 1000:  # between the bar and the fading hint
            break
    assert differs[60:640].sum() > 1000
    assert browser.evaluate("window.painted") is False
    browser.call("Input.dispatchMouseEvent", type="mouseReleased", x=760.0, y=320.0, **turning)
    lifted = {**pen, "type": "mouseReleased", "buttons": 0, "force": 0.0}
    browser.call("Input.dispatchMouseEvent", x=444.0, y=381.0, **lifted)
    begin_with(browser, SHEET)  # without waiting for it


def test_what_a_pen_is_thought_to_do_is_drawn_and_not_painted(
    browser: Browser, tmp_path: Path
) -> None:
    begin_with(browser, SHEET)
    settled(browser)
    before = picture(browser, tmp_path / "before.png")
    browser.evaluate(
        "window.predicted = PointerEvent.prototype.getPredictedEvents;"
        "PointerEvent.prototype.getPredictedEvents = function () { return [1, 2, 3].map(k => ({"
        " timeStamp: this.timeStamp + 8 * k, clientX: this.clientX + 30 * k,"
        " clientY: this.clientY, pressure: 0.8 })); };"
        "window.post = Worker.prototype.postMessage; window.late = [];"  # nothing is painted yet
        "Worker.prototype.postMessage = function (asked) { if (asked.name === 'move')"
        " late.push(() => post.call(this, asked)); else post.call(this, asked); }; 0"
    )
    browser.stroke(wave(350.0, 330.0, 120.0), lifts=False)
    settled(browser)
    drawn = before - picture(browser, tmp_path / "drawn.png") > 40.0
    assert browser.evaluate(IS_LEFT) is False  # without being asked, with what is not painted yet
    browser.evaluate(
        "PointerEvent.prototype.getPredictedEvents = window.predicted;"
        "Worker.prototype.postMessage = window.post; for (const one of late) one(); 0"
    )
    browser.call("Input.dispatchMouseEvent", x=470.0, y=330.0, **LIFTED)
    found = settled(browser)
    browser.wait_for("paint3d.isKept")
    assert browser.evaluate(IS_LEFT) is True
    painted_at_last = before - picture(browser, tmp_path / "after.png") > 40.0
    assert drawn[300:360, 350:470].any(axis=0).sum() > 100  # pixels of the pen's way
    assert drawn[300:360, 480:500].any()
    assert not drawn[300:360, 515:].any()  # too far to be believed
    assert not painted_at_last[300:360, 480:].any()
    assert painted_at_last[300:360, 350:470].any()
    assert found == by_the_desktop(browser, tmp_path)


def touch(browser: Browser, *ways: list[tuple[float, float]], lifts: bool = True) -> None:
    """Let fingers go down one after the other, along their ways together, and up."""
    points = [{"x": way[0][0], "y": way[0][1], "id": k} for k, way in enumerate(ways)]
    for k in range(len(ways)):
        browser.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=points[: k + 1])
    for step in range(1, len(ways[0])):
        moved = [
            {"x": way[step][0], "y": way[step][1], "id": k, "force": 0.5}
            for k, way in enumerate(ways)
        ]
        browser.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=moved)
    if lifts:
        browser.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])


def tap(browser: Browser, fingers: int) -> None:
    """Let fingers tap together, within a tenth of a second by the clock of their events."""
    now = time.time()
    points = [{"x": 300.0 + 90.0 * k, "y": 420.0, "id": k} for k in range(fingers)]
    asked = [("touchStart", points[: k + 1]) for k in range(fingers)] + [("touchEnd", [])]
    for k, (kind, down) in enumerate(asked):
        words = {"type": kind, "touchPoints": down, "timestamp": now + 0.02 * k}
        browser.call("Input.dispatchTouchEvent", **words)


def test_fingers_paint_turn_and_zoom_and_a_pen_is_told_from_its_palm(
    browser: Browser, address: str, tmp_path: Path
) -> None:
    begin_with(browser, BOWL)
    browser.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=5)
    try:
        browser.evaluate("window.confirm = () => true; 0")
        open_again(browser, address)  # where no pen has been yet
        begin_with(browser, BOWL)
        across = [(420.0 + 4.0 * k, 380.0) for k in range(24)]
        touch(browser, across)
        bare = settled(browser)
        assert browser.evaluate("paint3d.score()").count("begin_stroke") == 1
        touch(browser, [(160.0 + 2.0 * k, 560.0) for k in range(20)])  # beside it: turned
        assert settled(browser) == bare
        assert browser.evaluate(
            "!document.getElementById('ahead').getContext('2d')"
            ".getImageData(0, 0, 960, 720).data.some(Boolean)"
        )
        before = picture(browser, tmp_path / "before.png")
        aside = [(300.0 + 3.0 * k, 400.0) for k in range(20)]
        touch(browser, aside, [(x + 150.0, y) for x, y in aside])  # both along: turned
        assert settled(browser) == bare
        turned = picture(browser, tmp_path / "turned.png")
        assert np.abs(turned - before)[60:].max() > 60.0
        touch(
            browser,
            [(400.0 - 2.0 * k, 400.0) for k in range(20)],
            [(520.0 + 2.0 * k, 400.0) for k in range(20)],
        )  # apart: nearer
        assert settled(browser) == bare
        nearer = picture(browser, tmp_path / "nearer.png")
        assert (nearer < 60.0).sum() > 1.3 * (turned < 60.0).sum() > 0  # the stroke is larger
        browser.evaluate("document.getElementById('whole').click()")
        undone = browser.evaluate("paint3d.score()").count('"undo"')
        palm = [(560.0 + k, 470.0) for k in range(8)]
        touch(browser, palm, lifts=False)  # the palm comes first, and paints until there is a pen
        browser.stroke(wave(400.0, 360.0, 160.0))
        browser.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        found = settled(browser)
        said = browser.evaluate("paint3d.score()")
        assert said.count("begin_stroke") - said.count('"undo"') == 2  # the finger's and the pen's
        assert said.count('"undo"') == undone + 1  # the palm's
        assert found["amounts"] != bare["amounts"]
        browser.evaluate("new Promise(done => setTimeout(done, 900))")  # the palm is gone
        n = said.count("begin_stroke")
        touch(browser, across)  # fingers have done with painting
        assert settled(browser) == found
        assert browser.evaluate("paint3d.score()").count("begin_stroke") == n
        tap(browser, 2)
        assert browser.evaluate("paint3d.score()").count('"undo"') == said.count('"undo"') + 1
        assert settled(browser)["amounts"] != found["amounts"]
        tap(browser, 3)
        assert settled(browser) == found
        fingers = "document.getElementById('fingers')"
        assert browser.evaluate(f"{fingers}.checked") is False
        browser.evaluate(f"{fingers}.click()")
        touch(browser, across)
        assert settled(browser) != found
        assert settled(browser) == by_the_desktop(browser, tmp_path)
    finally:
        browser.call("Emulation.setTouchEmulationEnabled", enabled=False)


def test_a_sheet_shows_its_paper_and_porcelain_none(browser: Browser, tmp_path: Path) -> None:
    begin_with(browser, SHEET)
    names = browser.evaluate("[...document.getElementById('material').options].map(o => o.text)")
    steps = {}
    for place, name in enumerate(names):
        browser.evaluate("window.before = document.getElementById('object'); 0")
        choose(browser, "material", place)
        browser.wait_for(f"document.getElementById('object') !== window.before && {OPEN}")
        settled(browser)
        shown = picture(browser, tmp_path / f"{name}.png")[300:500, 350:600]
        steps[name] = np.abs(np.diff(shown)).mean()
        assert np.ptp(shown) < 20.0
    assert 0.2 < steps["xuan"] < 1.5
    assert steps["porcelain"] < 0.1


def test_a_picture_that_the_browser_has_lost_is_there_again(
    browser: Browser, tmp_path: Path
) -> None:
    begin_with(browser, SHEET)
    browser.stroke(wave(350.0, 330.0))
    settled(browser)
    before = picture(browser, tmp_path / "before.png")
    browser.evaluate(
        "window.lost = document.getElementById('canvas').getContext('webgl2')"
        ".getExtension('WEBGL_lose_context'); lost.loseContext()"
    )
    browser.wait_for(f"{MESSAGE}.includes('WebGL')")
    browser.evaluate("lost.restoreContext()")
    browser.wait_for(OPEN)
    settled(browser)
    again = picture(browser, tmp_path / "again.png")
    assert np.array_equal(again[60:680], before[60:680])  # between the bar and the fading hint


FAKE_MOUSE = """
class FakeMouse extends EventTarget {
  vendorId = 0x256f; productId = 0xc635; productName = 'SpaceMouse Compact'; opened = false;
  constructor(collections) { super(); this.collections = collections; }
  async open() { this.opened = true; }
  async close() { this.opened = false; }
  send(reportId, ...bytes) {
    const event = new Event('inputreport');
    Object.assign(event, { reportId, data: new DataView(Uint8Array.from(bytes).buffer) });
    this.dispatchEvent(event);
  }
}
window.mouse = new FakeMouse(COLLECTIONS);
const hid = Object.assign(new EventTarget(), {
  getDevices: async () => [], requestDevice: async ({ filters: [{ usagePage, usage }] }) =>
    usagePage === 1 && usage === 8 ? [window.mouse] : [],
});
Object.defineProperty(Navigator.prototype, 'hid', { get: () => hid, configurable: true });
"""


def test_a_3d_mouse_is_connected_turns_the_object_and_rests_when_it_is_silent(
    browser: Browser, tmp_path: Path
) -> None:
    begin_with(browser, BOWL)
    browser.stroke(wave(380.0, 360.0, 200.0))
    at = "document.getElementById('{}')".format
    browser.evaluate(
        "Object.defineProperty(navigator, 'hid', { value: undefined, configurable: true })"
    )
    browser.evaluate(f"for (const _ of [1, 2]) {at('language')}.click()")
    assert browser.evaluate(f"{at('mouse')} === null")  # where the browser has no such thing
    browser.evaluate("delete navigator.hid")
    collections = json.dumps(as_a_browser_has_it(combined_mouse()))
    browser.evaluate(FAKE_MOUSE.replace("COLLECTIONS", collections) + "; 0")
    browser.evaluate(f"for (const _ of [1, 2]) {at('language')}.click()")
    browser.evaluate(f"{at('mouse')}.click()")
    browser.wait_for("mouse.opened")
    browser.wait_for(f"{at('mouse')}.textContent.includes('SpaceMouse Compact')")
    settled(browser)
    before = picture(browser, tmp_path / "before.png")
    twist = "mouse.send(1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 94, 1)"  # about the vertical, fully
    browser.evaluate(
        f"new Promise(done => {{ let n = 0; const send = () => {{ {twist};"
        " if (++n < 12) setTimeout(send, 30); else done(0); }; send(); })"
    )
    browser.evaluate("new Promise(done => setTimeout(done, 400))")  # silent
    turned = picture(browser, tmp_path / "turned.png")
    browser.evaluate("new Promise(done => setTimeout(done, 200))")
    assert np.array_equal(turned, picture(browser, tmp_path / "rests.png"))
    assert np.abs(turned - before)[60:].max() > 60.0
    strokes = browser.evaluate("paint3d.score()").count("undo")
    browser.evaluate("mouse.send(3, 4, 0, 0, 0)")  # the third button
    assert browser.evaluate("paint3d.score()").count("undo") == strokes + 1
    browser.evaluate("mouse.send(3, 1, 0, 0, 0)")  # the first: seen as at first
    settled(browser)
    bare = picture(browser, tmp_path / "bare.png")
    assert np.abs(bare - before)[60:].max() > 60.0  # the stroke is taken back
    browser.evaluate(f"{at('mouse')}.click()")
    browser.wait_for("!mouse.opened")


def test_nothing_is_asked_of_another_host(browser: Browser, address: str) -> None:
    asked = browser.evaluate("performance.getEntriesByType('resource').map(one => one.name)")
    assert any(one.endswith("kernels.wasm") for one in asked)
    assert all(one.startswith((address, "data:")) for one in asked)
    policy = browser.evaluate("document.querySelector('meta[http-equiv]').content")
    assert {"default-src 'none'", "connect-src 'self'"} <= set(policy.split("; "))


def test_it_speaks_both_languages(browser: Browser) -> None:
    texts = []
    for _ in range(2):
        browser.evaluate("document.getElementById('language').click()")
        texts.append(browser.evaluate("document.getElementById('bar').textContent"))
    chinese, english = sorted(texts, key=lambda text: "Undo" in text)
    assert "撤销" in chinese
    assert "中楷" in chinese
    assert "Undo" in english
    assert "zhongkai" in english


@pytest.mark.parametrize(
    ("lacks", "said"),
    [
        ("WebAssembly.validate = () => false", "WebAssembly with vectors (SIMD)"),
        ("HTMLCanvasElement.prototype.getContext = () => null", "no WebGL 2"),
        ("delete window.DecompressionStream", "DecompressionStream"),
        ("const f = window.fetch; window.fetch = n => f(n === 'kernels.wasm' ? 'none' : n)",
         "kernels.wasm cannot be had from this host (404)"),
    ],
)  # fmt: skip
def test_a_browser_that_cannot_is_told_so_in_words(
    lacks: str, said: str, address: str, tmp_path: Path
) -> None:
    with opened("about:blank", tmp_path / "profile", (640, 480)) as one:
        one.call("Page.addScriptToEvaluateOnNewDocument", source=lacks)
        one.call("Emulation.setLocaleOverride", locale="en")
        one.call("Page.navigate", url=address)
        one.wait_for("document.readyState === 'complete'")
        one.wait_for(f"{MESSAGE}.includes({said!r})")
