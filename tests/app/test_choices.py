"""What the studio says, its keys, and what a user has chosen."""

import ast
import dataclasses
import json
import re
import string
from pathlib import Path

import pytest

import paint3d
from paint3d.app.model.brush_in_hand import resized
from paint3d.app.model.commands import (
    GESTURES,
    GROUPS,
    SHORTCUTS,
    find_shortcuts,
)
from paint3d.app.model.document import Document
from paint3d.app.model.persistence.places import config_folder, recovery_folder
from paint3d.app.model.persistence.recovery_folder import Unfinished
from paint3d.app.model.persistence.saved_settings import chosen_brush, chosen_inks, in_hand
from paint3d.app.model.persistence.settings import Settings, load_settings, save_settings
from paint3d.app.model.texts import LANGUAGES, Texts, in_chinese, load_texts, system_language
from paint3d.brush.presets import load_brush
from paint3d.colour.materials import load_material, load_materials
from paint3d.colour.pigments import load_pigment
from paint3d.errors import ExportError, Paint3DError, UnknownNameError
from paint3d.files.load import BUILT_IN_OBJECTS


def named_in(text):
    return sorted(name for _, name, _, _ in string.Formatter().parse(text) if name is not None)


def test_every_text_is_there_in_every_language_and_names_the_same_values():
    for key, texts in load_texts().items():
        assert set(texts) == set(LANGUAGES), key
        assert all(text.strip() for text in texts.values()), key
        assert named_in(texts["en"]) == named_in(texts["zh"]), key
        assert re.fullmatch(r"[a-z]+\.[a-z0-9_]+", key)


def test_chinese_is_chinese():
    same = {key for key, texts in load_texts().items() if texts["en"] == texts["zh"]}
    assert same == {"English", "中文"}


def test_every_action_group_object_and_material_has_its_text():
    texts = load_texts()
    wanted = [f"action.{shortcut.action}" for shortcut in SHORTCUTS]
    wanted += [f"group.{group}" for group in GROUPS] + [f"gesture.{g}" for g in GESTURES]
    wanted += [f"object.{name}" for name in BUILT_IN_OBJECTS]
    wanted += [f"surface.{name.replace(' ', '_')}" for name in load_materials()]
    assert not set(wanted) - set(texts)
    used = {s.action for s in SHORTCUTS}
    assert {k.removeprefix("action.") for k in texts if k.startswith("action.")} == used


def asked_for(tree):
    """Patterns of keys in a source: strings, f-strings, and beginnings that the rest is put to."""
    formatted = [node for node in ast.walk(tree) if isinstance(node, ast.JoinedStr)]
    inner = {id(part) for node in formatted for part in node.values}
    for node in formatted:
        parts = (getattr(part, "value", None) for part in node.values)
        yield "".join(re.escape(p) if isinstance(p, str) else ".+" for p in parts)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in inner:
            begun = re.fullmatch(r"[a-z]+\.([a-z_]*_)?", node.value)
            yield re.escape(node.value) + (".+" if begun else "")


def test_every_text_is_asked_for():
    files = (Path(paint3d.__file__).parent / "app").rglob("*.py")
    asked = {one for file in files for one in asked_for(ast.parse(file.read_text("utf-8")))}
    asked = {one for one in asked if re.match(r"[a-z]+\\\.", one)}
    assert [key for key in load_texts() if not any(re.fullmatch(a, key) for a in asked)] == []


def test_texts_are_asked_for_by_key():
    assert Texts("en")("{count} lost", count=3) == "3 lost"
    assert Texts("zh")("{count} lost", count=3) == "丢失 3"
    with pytest.raises(UnknownNameError, match=r"device\.lost"):
        Texts("en")("device.last")
    with pytest.raises(UnknownNameError, match="language"):
        Texts("de")


@pytest.mark.parametrize(
    ("environment", "language"),
    [
        ({}, "en"),
        ({"LANG": "zh_CN.UTF-8"}, "zh"),
        ({"LANG": "zh_CN.UTF-8", "LC_ALL": "C"}, "en"),
        ({"LANGUAGE": "zh:en", "LANG": "en_US"}, "zh"),
        ({"LANG": "de_DE"}, "en"),
    ],
)
def test_the_system_s_language_is_found(environment, language):
    assert system_language(environment) == language


def test_no_key_asks_for_two_things():
    """A key that is held or dragged with may also be pressed: it is if it is let go at once."""
    taken = {}
    for one in SHORTCUTS:
        assert one.group in GROUPS, one
        assert one.gesture in GESTURES, one
        place = one.keys.lower(), one.gesture in ("press", "tap")
        assert taken.setdefault(place, one) is one
    for row in ("undo", "redo", "swap_inks", "pick_colour", "size", "larger", "orbit", "shortcuts"):
        assert find_shortcuts(row)


def test_settings_come_back(tmp_path):
    own = Settings(language="zh", pressure_curve=((0.0, 0.0), (0.5, 0.7), (1.0, 1.0)), wet=True)
    own = own.with_recent("/a/b.p3d").with_recent("/c.p3d").with_recent("/a/b.p3d")
    own = dataclasses.replace(own, buttons={3: "dip"}, window={"panels": ["inks"]})
    own = dataclasses.replace(own, inks=("indigo", {"cinnabar": 0.75, "water": 0.25}))
    save_settings(own, tmp_path / "new")
    assert load_settings(tmp_path / "new") == (own, None)
    assert own.recent == ("/a/b.p3d", "/c.p3d")
    assert own.curve(0.5) == pytest.approx(0.7, abs=1e-3)
    assert load_settings(tmp_path / "none") == (Settings(), None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "Expecting value"),
        ("[]", "holds a list"),
        ("{}", "version is None"),
        ('{"version": 3}', "version is 3"),
        ('{"version": 2, "wet": 1}', "wet is 1"),
        ('{"version": 2, "inks": ["pine soot", {"water": "much"}]}', "part of water is 'much'"),
        ('{"version": 2, "inks": [[]]}', "inks is"),
        ('{"version": 2, "exports": []}', "exports is"),
        ('{"version": 2, "brush_mm": 0}', "brush_mm"),
        ('{"version": 1, "language": "xx"}', "language is 'xx'"),
        ('{"version": 1, "smoothing": NaN}', "smoothing is nan"),
        ('{"version": 1, "smoothing": "much"}', "smoothing is 'much'"),
        ('{"version": 1, "pressure_curve": [[0, 1], [1, 0]]}', "pressure curve"),
        ('{"version": 1, "recent": [1]}', "recent is"),
        ('{"version": 1, "recent": "x"}', "recent is"),
        ('{"version": 1, "buttons": {"a": "dip"}}', "invalid literal"),
        ('{"version": 1, "buttons": {"0": "explode"}}', "unknown action"),
        ('{"version": 1, "buttons": 4}', "wrong kind"),
        ('{"version": 1, "window": 4}', "window is 4"),
        ("[" * 100000, "recursion|depth"),
    ],
)
def test_bad_settings_are_set_aside_with_a_message(tmp_path, text, message):
    file = tmp_path / "settings.json"
    file.write_text(text)
    found, told = load_settings(tmp_path)
    assert found == Settings()
    assert re.search(message, told)
    (aside,) = tmp_path.iterdir()
    assert aside.name in told
    assert aside.read_text() == text


def test_what_a_newer_program_adds_is_passed_over(tmp_path):
    (tmp_path / "settings.json").write_text(json.dumps({"version": 1, "theme": "dark", "new": 1}))
    assert load_settings(tmp_path) == (Settings(theme="dark"), None)


def test_the_first_version_s_wet_was_no_choice(tmp_path):
    (tmp_path / "settings.json").write_text(json.dumps({"version": 1, "wet": False}))
    assert load_settings(tmp_path)[0].wet is None
    xuan = load_material("xuan")
    assert Settings(wet=True).wants_wet(xuan)
    assert not Settings(wet=False).wants_wet(xuan)


def test_brush_and_inks_in_hand_are_kept_as_words_and_found_again():
    brush = resized(load_brush("zhongkai"), 31.0)
    mixed = {"indigo": 3.0, load_pigment("cinnabar"): 1.0}
    kept = dataclasses.replace(Settings(), **in_hand(brush, [mixed, {"gamboge": 2.0}]))
    assert chosen_brush(kept) == brush
    assert chosen_inks(kept) == [{"indigo": 3.0, "cinnabar": 1.0}, "gamboge"]
    as_made = dataclasses.replace(kept, **in_hand(load_brush("gongbi"), ["indigo"]))
    assert chosen_brush(as_made) == load_brush("gongbi")
    assert as_made.brush_mm is None
    assert chosen_inks(as_made) == ["indigo", "cinnabar"]
    gone = Settings(brush="mop", inks=("mud", {"water": 0.0}))
    assert chosen_brush(gone) == load_brush("full")
    assert chosen_inks(gone) == ["pine soot", "cinnabar"]


def test_settings_that_cannot_be_saved_are_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ExportError, match="cannot be made"):
        save_settings(Settings(), tmp_path / "file" / "deeper")


def test_folders_follow_the_environment(monkeypatch, tmp_path):
    monkeypatch.delenv("PAINT3D_CONFIG", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert config_folder() == tmp_path / "paint3d"
    monkeypatch.setenv("XDG_CONFIG_HOME", "relative")
    assert config_folder().parts[-2:] == (".config", "paint3d")
    monkeypatch.setenv("PAINT3D_STATE", str(tmp_path / "own"))
    assert recovery_folder() == tmp_path / "own" / "sittings"


@pytest.mark.parametrize(
    ("english", "chinese"),
    [
        ("/a/b.p3d: cannot write: No space left on device", "/a/b.p3d：无法写入：磁盘已满"),
        ("/a/b.ply: no such file; expected a mesh file", "/a/b.ply：没有这个文件"),
        ("another ink was asked for during a stroke; expected its end first", "请先写完这一笔"),
        (
            "the ink lies in 9,120 dots and gaps of a few pixels, as greys do that are dithered to "
            "black and white; expected strokes: scan in grey",
            "墨迹是 9,120 个网点，请用灰度扫描",
        ),
        ("nobody knows this one", "未能完成：nobody knows this one"),
    ],
)
def test_errors_are_said_in_chinese(english, chinese):
    assert in_chinese(english) == chinese


def test_errors_that_are_raised_are_among_the_patterns(tmp_path):
    document = Document.new("plane", 4.0)
    noise = tmp_path / "random.glb"
    noise.write_bytes(bytes([0x81, 0x17, 0x99] * 400))
    for action in (
        lambda: document.save(tmp_path / "no" / "a.p3d"),
        lambda: document.export(tmp_path / "a.xyz"),
        lambda: document.export(tmp_path / "no" / "a.ply"),
        lambda: document.replay_history(7),
        lambda: Document.new(tmp_path / "none.ply"),
        lambda: Document.new(noise),
        lambda: Document.open(tmp_path / "none.p3d"),
        lambda: Unfinished(tmp_path / "gone", "plane", None, 0.0).recover(),
    ):
        with pytest.raises(Paint3DError) as found:
            action()
        assert "\n" not in str(found.value)
        assert "codec" not in str(found.value)
        assert not in_chinese(str(found.value)).startswith("未能完成"), str(found.value)
