"""The studio's keys, and what a user has chosen."""

import dataclasses
import json
import re

import pytest

from paint3d.app.model.brush_in_hand import resized
from paint3d.app.model.commands import (
    GESTURES,
    GROUPS,
    SHORTCUTS,
)
from paint3d.app.model.persistence.saved_settings import chosen_brush, chosen_inks, in_hand
from paint3d.app.model.persistence.settings import Settings, load_settings, save_settings
from paint3d.brush.presets import load_brush
from paint3d.colour.materials import load_material
from paint3d.colour.pigments import load_pigment
from paint3d.core.own_folders import config_folder, recovery_folder
from paint3d.errors import ExportError


def test_no_key_asks_for_two_things():
    """A key that is held or dragged with may also be pressed: it is if it is let go at once."""
    taken = {}
    for one in SHORTCUTS:
        assert one.group in GROUPS, one
        assert one.gesture in GESTURES, one
        place = one.keys.lower(), one.gesture in ("press", "tap")
        assert taken.setdefault(place, one) is one
    for row in ("undo", "redo", "swap_inks", "pick_colour", "size", "larger", "orbit", "shortcuts"):
        assert any(one.action == row for one in SHORTCUTS)


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
