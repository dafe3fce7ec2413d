"""A painting as a page of one file: it is shown, grows, is painted on, and asks for nothing."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from paint3d.app.model.document import Document
from paint3d.app.model.score.playing import painted
from paint3d.cli.main import main
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import Session, load_session, save_session
from paint3d.page import folder, single_file
from paint3d.page.folder import KERNELS
from paint3d.page.single_file import bare_score, page_score, page_text
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score, load_score, write_score
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.chromium import Browser, browser_path, opened
from tests.support.web_page import built_page, hashes_of, why_no_kernels

HEAD = {
    "format": "paint3d-recording", "version": 2, "object": "square", "resolution_mm": 0.8,
    "material": "xuan", "brush": "zhongkai", "ink": {"pine soot": 0.4, "water": 0.6},
    "azimuth": "dragged", "pickup": 0.05,
}  # fmt: skip
FADED = [{"do": "set_opacity", "place": 0, "opacity": 0.9}]
SOOT, RED = {"pine soot": 0.4, "water": 0.6}, {"cinnabar": 1.0}


def stroke(y: float) -> Recording:
    """A stroke across the square, while the other hand moves the sheet."""
    painter = Painter(PaintedSurface(load_mesh("square"), 4.0), "zhongkai")
    ways = [(x, y, 0.0) for x in (-60.0, 0.0, 60.0)]
    drawn = painter.stroke(ways, pressure=(0.0, 0.5, 0.2, 0.6, 0.0), tilt=15.0)
    along = np.linspace([0.0, 0.0, 0.0], [3.0, -2.0, 1.0], len(drawn))
    contact = None if drawn.contact is None else drawn.contact + along
    return replace(drawn, position=drawn.position + along, object_position=along, contact=contact)


def session_of(*events: Any, **changes: Any) -> Session:
    """A painting of these events, with its score, as the studio saves it."""
    mesh = load_mesh("square")
    score = Score({**HEAD, **changes}, events)
    return Session(painted(score, mesh).surface, score=score)


def drawn(y: float, **words: Any) -> list[Any]:
    return [{"do": "begin_stroke", "time_s": 1.5, **words}, stroke(y), {"do": "end_stroke"}]


@pytest.fixture(scope="module")
def painting() -> Session:
    return session_of(
        *drawn(-40.0), {"do": "dip", "ink": RED}, {"do": "add_layer", "name": "seal", "place": 1},
        *drawn(0.0), *drawn(20.0), {"do": "undo"}, {"do": "set_tags", "tags": {"a": 1}},
        {"do": "set_opacity", "place": 1, "opacity": 0.6}, {"do": "dip", "ink": SOOT},
        {"do": "set_brush", "brush": "xiaokai"}, *drawn(40.0),
    )  # fmt: skip


def test_a_page_is_given_words_that_it_plays_and_they_give_the_same_painting(
    painting: Session,
) -> None:
    score = page_score(painting)
    lines = [event for event in score.events if not isinstance(event, Recording)]
    assert {"do": "rename_layer", "place": 1, "name": "seal"} in lines
    assert {"do": "begin_stroke"} in lines
    assert "set_tags" not in {line["do"] for line in lines}
    again = painted(score, load_mesh("square")).surface
    assert hashes_of(again) == hashes_of(painting.surface)


@pytest.mark.parametrize(
    ("events", "changes", "said"),
    [
        ([{"do": "rinse"}, *drawn(0.0)], {}, "its recording has rinse, which a page does not play"),
        ([{"do": "dip", "ink": RED, "reach": 0.3}, *drawn(0.0)], {},
         "its recording has dip with reach"),
        ([{"do": "set_brush", "brush": "xiaokai", "length_mm": 40.0}, *drawn(0.0)], {},
         "its recording has set_brush with length_mm"),
        (drawn(0.0), {"hairs": 40}, "its brush is none of the presets"),
        ([{"do": "follow_time", "seconds": 0.1}, *drawn(0.0)], {},
         "its ink flows in steps of 0.1 s; in a page these are 0.05 s"),
        ([*FADED * 31, *[{"do": "undo"}] * 20, {"do": "dip"}, *[{"do": "undo"}] * 11], {},
         "it undoes more than the 30 steps, 256 MiB together, that a page keeps"),
        ([{"do": "dip", "ink": {"azurite": 1.0}}, *drawn(0.0)], {},
         "the grains of azurite are visible"),
    ],
)  # fmt: skip
def test_what_a_page_does_not_play_is_said(
    events: list[Any], changes: dict[str, Any], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = session_of(*events, **changes)
    monkeypatch.delattr(single_file, "_play")  # it is said before anything is painted
    with pytest.raises(InputError, match=said):
        page_score(session)


def test_what_takes_more_memory_to_take_back_than_a_page_has_is_not_carried(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = session_of(*drawn(0.0), *FADED * 3, *[{"do": "undo"}] * 3)
    n, n_pigments = session.surface.n_vertices, len(session.surface.pigments)
    monkeypatch.setattr(single_file, "MOST_BYTES", 3 * 4 * n * (n_pigments + 1))
    page_score(session)
    monkeypatch.setattr(single_file, "MOST_BYTES", 3 * 4 * n * (n_pigments + 1) - 1)
    with pytest.raises(InputError, match="it undoes more than the 30 steps"):
        page_score(session)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """A session of the command line, which has no score."""
    file = tmp_path_factory.mktemp("written") / "a.p3d"
    words = ["--on", "square", "--resolution", "3", "--size", "100", "--quiet"]
    assert main(["write", "一", *words, "--out", str(file)]) == 0
    return load_session(file)


def test_what_the_command_line_painted_whole_is_carried(written: Session) -> None:
    amount = written.settings["amount"]  # type: ignore[index]
    assert amount["wetted"] < 0.5
    score = page_score(written)
    assert score.events[0] == {"do": "dip", "ink": score.header["ink"], "amount": amount}
    again = painted(score, load_mesh("square")).surface
    assert hashes_of(again) == hashes_of(written.surface)
    named = replace(written, settings={**written.settings, "brush": score.header["brush"]})
    assert page_score(named).header == score.header


def test_what_the_command_line_added_to_it_is_carried(written: Session, tmp_path: Path) -> None:
    begun, sealed = tmp_path / "begun.p3d", tmp_path / "sealed.p3d"
    save_session(written, begun)
    words = ["--size", "30", "--at", "0.7,0.3", "--seal", "一", "--layer", "over"]
    assert main(["write", "丨", "--on", str(begun), "--out", str(sealed), *words, "--quiet"]) == 0
    document = Document.open(sealed)
    with pytest.raises(InputError, match="only the strokes of this painting are known"):
        document.edit_strokes([0], {"do": "delete"})
    document.set_opacity(1, 0.5)
    document.save()
    session = load_session(sealed)
    score = page_score(session)
    done = [event["do"] for event in score.events if not isinstance(event, Recording)]
    assert done.count("begin_stroke") == 2
    assert done[-2:] == ["press_seal", "set_opacity"]
    with pytest.raises(InputError, match="painted whole is not recorded"):
        page_score(replace(session, later=None))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"brush": None}, "it is not recorded how it was painted"),
        ({"brush": {"name": 17}}, "brush"),
        ({"dipped": {"TABLE:mine": 1.0}}, "an ink is of a table on this machine"),
        ({"dipped": None, "ink": "TABLE:mine"}, "an ink is of a table on this machine"),
        ({"dipped": None, "ink": 17}, "an ink is 17; expected weights by name"),
        ({"amount": {"wetted": 4.0}}, "wetted share of the tuft"),
        ({"dips": [[SOOT, None], [RED, 0.3]]}, "another ink at the tip"),
    ],
)
def test_a_session_without_a_score_may_be_a_strangers(
    written: Session, settings: dict[str, Any], said: str, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    table = tmp_path / "private.csv"
    table.write_text("name,R_400\nmine,secret\n", "utf-8")
    own = {**written.settings, **settings}
    own = json.loads(json.dumps(own).replace("TABLE", str(table)))
    given = {name: value for name, value in own.items() if value is not None}
    monkeypatch.delattr(single_file, "_play")
    with pytest.raises(InputError, match=said) as refusal:
        page_score(replace(written, settings=given))
    assert "R_400" not in str(refusal.value)
    assert "secret" not in str(refusal.value)


def test_a_painting_of_unknown_or_other_strokes_is_not_carried(painting: Session) -> None:
    with pytest.raises(InputError, match="it is not recorded how it was painted"):
        page_score(Session(painting.surface))
    other = session_of(*drawn(0.0)).score
    with pytest.raises(InputError, match="its recording gives another painting"):
        page_score(Session(painting.surface, score=other))


def test_a_page_that_only_shows_it_says_why(
    painting: Session, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.setattr(folder, "KERNELS", tmp_path)
    session = tmp_path / "a.p3d"
    save_session(painting, session)
    for name, options, said in (
        (str(session), ["--view-only"], None),
        (str(session), [], "the kernels of the page are not compiled (./scripts/page"),
        ("plate", [], "it is no session"),
        (str(session), ["--exact"], "it was to be written with other colours, vertices"),
        (str(session), ["--filaments", "2"], "it was to be written with other colours"),
    ):
        assert main(["export", name, str(tmp_path / "a.html"), "--force", *options]) == 0
        page = (tmp_path / "a.html").read_text("utf-8")
        assert 'id="mesh"' in page
        note = page.partition('<p id="note">')[2].partition("</p>")[0]
        if said is None:
            assert not note
            assert "note:" not in capsys.readouterr().err
        else:
            assert f"It cannot be painted on here: {said}" in note
            assert f"only shows the painting: {said}" in capsys.readouterr().err


WHY_NOT = why_no_kernels(KERNELS) or ("" if browser_path() else "no Chromium is installed")
in_browser = pytest.mark.skipif(bool(WHY_NOT), reason=WHY_NOT)
READY = "!!window.paint3d && document.getElementById('message').hidden"
IDLE = f"{READY} && !document.getElementById('tools').inert"
SHOWN = ("vertices", "srgb", "amounts")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built_page(tmp_path_factory.mktemp("built"))


def on_the_desktop(browser: Browser, path: Path) -> dict[str, Any]:
    """What the page's recording paints on the desktop, of what the page says of its own."""
    path.write_text(browser.evaluate("paint3d.score()"), "utf-8")
    score = load_score(path)
    hashes = hashes_of(painted(score, load_mesh(score.header["object"])).surface)
    return {name: hashes[name] for name in SHOWN}


@in_browser
def test_what_the_command_line_painted_is_gone_on_with_by_its_dips(
    written: Session, built: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folder, "BUILT", built)
    session, file = tmp_path / "a.p3d", tmp_path / "a.html"
    save_session(written, session)
    assert main(["export", str(session), str(file)]) == 0
    ours = hashes_of(written.surface)
    with opened(file.as_uri(), tmp_path / "profile", (960, 720)) as browser:
        browser.wait_for(IDLE)
        assert browser.evaluate("paint3d.hashes()") == {name: ours[name] for name in SHOWN}
        browser.stroke([(300.0 + 6.0 * k, 400.0 + k, 0.2 + 0.005 * k) for k in range(60)])
        found = browser.evaluate("paint3d.hashes()")
        assert found["srgb"] != ours["srgb"]
        assert found == on_the_desktop(browser, tmp_path / "page.score.jsonl")
        browser.evaluate("document.getElementById('undo').click()")
        browser.wait_for(f"(await paint3d.hashes()).srgb !== '{found['srgb']}'")
        browser.stroke([(300.0 + 6.0 * k, 350.0 + k, 0.2 + 0.005 * k) for k in range(60)])
        found = browser.evaluate("paint3d.hashes()")
        assert found == on_the_desktop(browser, tmp_path / "page.score.jsonl")
        assert '"do":"undo"' in (tmp_path / "page.score.jsonl").read_text("utf-8")
        assert browser.complaints() == []


def stands_in_a_cell(browser: Browser, tmp_path: Path) -> None:
    """A notebook's cell hears what is painted in its frame; the frame goes on with what was."""
    surface = PaintedSurface(load_mesh("square"), 0.8)
    score = bare_score(surface, "zhongkai", "pine soot")
    page = page_text(surface, score, "a", is_hosted=True, page=folder.BUILT, kernels=KERNELS)
    view = Path(single_file.__file__).with_name("editor.js").read_text("utf-8")
    kept = "".join(write_score(Score(score.header, tuple(drawn(-40.0)))))
    browser.evaluate(f"""(() => {{ {view.replace("export default", "window.cell =")}
        window.said = {json.dumps(kept)};
        window.had = {{ _page: {json.dumps(page)}, _height: 700 }};
        cell.render({{ el: document.body, model: {{
          get: (name) => had[name], set: (name, value) => (had[name] = value),
          save_changes: () => {{}}, on: (_, hear) => (window.hear = hear), off: () => {{}},
          send: ({{ paint3d, text, view }}) => {{
            if (paint3d === "read") hear({{ paint3d: "kept", text: said, view }});
            else said = paint3d === "begin" ? text : said + text;
          }} }} }}) }})()""")
    inner = "document.querySelector('iframe').contentWindow"
    browser.wait_for(f"(w => !!w.paint3d && w.document.getElementById('message').hidden)({inner})")
    browser.evaluate(f"(wet => wet.checked && wet.click())({inner}.document.getElementById('wet'))")
    browser.stroke([(400.0 + 3.0 * k, 300.0 + k, 0.2 + 0.005 * k) for k in range(60)], tiltX=20)
    found = browser.evaluate(f"{inner}.paint3d.hashes()")
    path = tmp_path / "told.score.jsonl"
    path.write_text(browser.evaluate("said"), "utf-8")
    told = load_score(path)
    assert len(told.strokes()) == 2
    hashes = hashes_of(painted(told, surface.source).surface)
    assert found == {name: hashes[name] for name in SHOWN}
    browser.evaluate("hear({ paint3d: 'heard', strokes: 5 }); hear({ paint3d: 'kept', view: '' })")
    left = "This painting goes on where it was shown last."
    assert browser.evaluate("[had.strokes, document.body.textContent]") == [5, left]


@in_browser
def test_it_is_opened_as_a_file_grows_and_is_painted_on_as_on_the_desktop(
    painting: Session, built: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.setattr(folder, "BUILT", built)
    session, file = tmp_path / "a.p3d", tmp_path / "a piece.html"
    save_session(painting, session)
    assert main(["export", str(session), str(file)]) == 0
    assert "note:" not in capsys.readouterr().err
    n_strokes = sum(
        1 for event in load_session(session).score.events  # type: ignore[union-attr]
        if not isinstance(event, Recording) and event["do"] == "begin_stroke"
    )  # fmt: skip
    replay = "document.getElementById('replay').click()"
    ours = hashes_of(painting.surface)
    notebook = tmp_path / "notebook.html"
    notebook.write_text("<body style='margin: 0'>")
    with opened(notebook.as_uri(), tmp_path / "profile", (960, 720)) as browser:
        stands_in_a_cell(browser, tmp_path)
        assert all("hid is not allowed" in said for said in browser.complaints())  # in a file
        browser.heard.clear()
        browser.call("Network.enable")
        browser.call("Page.navigate", url=file.as_uri())
        browser.wait_for(IDLE)
        assert browser.evaluate("paint3d.hashes()") == {name: ours[name] for name in SHOWN}
        assert browser.evaluate("document.title") == "a piece"
        browser.evaluate("window.before = document.getElementById('replay'); before.click()")
        grows = "document.getElementById('replay') !== before"
        browser.wait_for(f"{READY} && {grows} && document.getElementById('tools').inert")
        growing = browser.evaluate("paint3d.score()")
        browser.stroke([(400.0 + k, 300.0, 0.5) for k in range(9)])  # which waits, and is none
        browser.evaluate(replay)  # to its end
        browser.wait_for(IDLE)
        whole = browser.evaluate("paint3d.score()")
        assert growing.count("begin_stroke") < whole.count("begin_stroke") == n_strokes
        assert browser.evaluate("paint3d.hashes()") == {name: ours[name] for name in SHOWN}
        grown, anew = tmp_path / "grown.png", tmp_path / "anew.png"
        browser.screenshot(grown)
        browser.evaluate(
            "window.lost = document.getElementById('canvas').getContext('webgl2')"
            ".getExtension('WEBGL_lose_context'); lost.loseContext()"
        )
        browser.wait_for("!document.getElementById('message').hidden")
        browser.evaluate("lost.restoreContext()")  # for which the picture is told whole
        browser.wait_for(IDLE)
        browser.evaluate("paint3d.hashes()")
        browser.screenshot(anew)
        assert np.array_equal(*(np.asarray(Image.open(one))[60:680] for one in (grown, anew)))
        browser.stroke([(400.0 + 3.0 * k, 300.0 + k, 0.2 + 0.005 * k) for k in range(60)], tiltX=20)
        found = browser.evaluate("paint3d.hashes()")
        assert found["srgb"] != ours["srgb"]
        assert found == on_the_desktop(browser, tmp_path / "page.score.jsonl")
        browser.wait_for("paint3d.isKept")
        browser.call("Page.navigate", url=file.as_uri())
        browser.wait_for("document.readyState === 'complete'")
        browser.wait_for(IDLE)
        assert browser.evaluate("paint3d.hashes()") == found  # kept by the browser
        asked = [one["params"]["request"]["url"] for one in browser.heard
                 if one.get("method") == "Network.requestWillBeSent"]  # fmt: skip
        assert asked
        assert {url.partition(":")[0] for url in asked} <= {"file", "blob", "data"}
        assert all(url == file.as_uri() for url in asked if url.startswith("file:"))
        policy = browser.evaluate("document.querySelector('meta[http-equiv]').content")
        assert "default-src 'none'" in policy
        assert "connect-src" not in policy
        assert "unsafe-inline" not in policy
        assert browser.complaints() == []
