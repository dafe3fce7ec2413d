"""A painting as a page of one file: it is shown, grows, is painted on, and asks for nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from paint3d.app.model.score.playing import painted
from paint3d.cli.main import main
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import Session, load_session, save_session
from paint3d.page import folder
from paint3d.page.folder import KERNELS
from paint3d.page.single_file import page_score
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score, load_score
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.chromium import browser_path, opened
from tests.support.web_page import built_page, hashes_of, why_no_kernels

HEAD = {
    "format": "paint3d-recording", "version": 2, "object": "square", "resolution_mm": 0.8,
    "material": "xuan", "brush": "zhongkai", "ink": {"pine soot": 0.4, "water": 0.6},
    "azimuth": "dragged", "pickup": 0.05,
}  # fmt: skip
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
        ([*drawn(0.0) * 32, *[{"do": "undo"}] * 31], {},
         "it takes back more than 30 steps in a row"),
    ],
)  # fmt: skip
def test_what_a_page_does_not_play_is_said(
    events: list[Any], changes: dict[str, Any], said: str
) -> None:
    with pytest.raises(InputError, match=said):
        page_score(session_of(*events, **changes))


def test_a_painting_of_unknown_or_other_strokes_is_not_carried(painting: Session) -> None:
    with pytest.raises(InputError, match="it is not recorded how it was painted"):
        page_score(Session(painting.surface))
    other = session_of(*drawn(0.0)).score
    with pytest.raises(InputError, match="what was recorded of it gives another painting"):
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
        (str(session), [], "the page to paint on is not built here"),
        ("plate", [], "it is no session"),
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


@pytest.mark.skipif(browser_path() is None, reason="neither Chromium nor Chrome is installed")
@pytest.mark.skipif(bool(why_no_kernels(KERNELS)), reason=why_no_kernels(KERNELS))
def test_it_is_opened_as_a_file_grows_and_is_painted_on_as_on_the_desktop(
    painting: Session, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.setattr(folder, "BUILT", built_page(tmp_path_factory.mktemp("built")))
    session, file = tmp_path / "a.p3d", tmp_path / "a piece.html"
    save_session(painting, session)
    assert main(["export", str(session), str(file)]) == 0
    assert "note:" not in capsys.readouterr().err
    n_strokes = sum(
        1 for event in load_session(session).score.events  # type: ignore[union-attr]
        if not isinstance(event, Recording) and event["do"] == "begin_stroke"
    )  # fmt: skip
    ready = "!!window.paint3d && document.getElementById('message').hidden"
    idle = f"{ready} && !document.getElementById('tools').inert"
    replay = "document.getElementById('replay').click()"
    ours = hashes_of(painting.surface)
    names = ("vertices", "srgb", "amounts")
    with opened("about:blank", tmp_path / "profile", (960, 720)) as browser:
        browser.call("Network.enable")
        browser.call("Page.navigate", url=file.as_uri())
        browser.wait_for(idle)
        assert browser.evaluate("paint3d.hashes()") == {name: ours[name] for name in names}
        assert browser.evaluate("document.title") == "a piece"
        browser.evaluate("window.before = document.getElementById('replay'); before.click()")
        grows = "document.getElementById('replay') !== before"
        browser.wait_for(f"{ready} && {grows} && document.getElementById('tools').inert")
        growing = browser.evaluate("paint3d.score()")
        browser.stroke([(400.0 + k, 300.0, 0.5) for k in range(9)])  # which waits, and is none
        browser.evaluate(replay)  # to its end
        browser.wait_for(idle)
        whole = browser.evaluate("paint3d.score()")
        assert growing.count("begin_stroke") < whole.count("begin_stroke") == n_strokes
        assert browser.evaluate("paint3d.hashes()") == {name: ours[name] for name in names}
        browser.stroke([(400.0 + 3.0 * k, 300.0 + k, 0.2 + 0.005 * k) for k in range(60)], tiltX=20)
        found = browser.evaluate("paint3d.hashes()")
        path = tmp_path / "page.score.jsonl"
        path.write_text(browser.evaluate("paint3d.score()"), "utf-8")
        score = load_score(path)
        desktop = hashes_of(painted(score, load_mesh(score.header["object"])).surface)
        assert found["srgb"] != ours["srgb"]
        assert found == {name: desktop[name] for name in names}
        browser.wait_for("paint3d.isKept")
        browser.call("Page.navigate", url=file.as_uri())
        browser.wait_for("document.readyState === 'complete'")
        browser.wait_for(idle)
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
