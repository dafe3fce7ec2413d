"""Which of the key map's actions stand where: menus, tool bar, icons."""

from __future__ import annotations

from paint3d.app.model.persistence.shortcuts import GESTURES, SHORTCUTS, find_shortcuts
from paint3d.brush.presets import brush_names

__all__ = [
    "ALWAYS",
    "CHECKABLE",
    "ICONS_OF",
    "MENUS",
    "ON_PICTURE",
    "TOOLS",
    "keys_of",
    "text_of",
]

MENUS: dict[str, tuple[str, ...]] = {
    "file": ("new", "open", "save", "save_as", "export", "-", "screenshot", "turntable", "growth",
             "-", "record", "replay", "save_recording", "-", "quit"),
    "edit": ("undo", "redo", "-", "cancel_stroke", "-", "stand", "-", "preferences"),
    "brush": ("smaller", "larger", "smoothing", "brush", "-",
              *(f"brush_{k}" for k in range(1, 1 + len(brush_names()))), "-", "edit_brush",
              "open_brush"),
    "ink": ("dip", "dip_tip", "rinse", "wipe", "-", "swap_inks", "pick_colour", "-",
            "choose_colour", "open_pigments", "forget_pigments", "-", "wet", "dry", "-", "seal"),
    "stroke": ("mirror", "radial", "-", "mask", "pick_region", "clear_mask", "-", "refine"),
    "view": ("frame_all", "frame_selected", "nearer", "farther", "-", "look_front", "look_back",
             "look_left", "look_right", "look_top", "look_bottom", "-", "turn_left", "turn_right",
             "turn_up", "turn_down", "-", "pan_left", "pan_right", "pan_up", "pan_down", "-",
             "roll_left", "roll_right", "upright", "-", "grips", "show_mask"),
    "layers": ("add_layer", "remove_layer", "rename_layer", "-", "layer_above", "layer_below",
               "raise_layer", "lower_layer", "-", "hide_layer", "lock_layer"),
    "window": ("panels", "next_panel", "previous_panel", "menus", "full_screen", "dark", "-"),
    "help": ("shortcuts", "about"),
}  # fmt: skip
"""Menu to its actions; "-" parts them."""

TOOLS = (
    "open", "save", "-", "undo", "redo", "-", "dip", "rinse", "swap_inks", "pick_colour", "-",
    "mirror", "radial", "wet", "dry", "-", "frame_all", "brush", "screenshot", "record", "-",
    "shortcuts",
)  # fmt: skip

CHECKABLE = frozenset(
    {"smoothing", "brush", "wet", "mirror", "radial", "mask", "record", "full_screen", "dark",
     "grips", "show_mask"}
)  # fmt: skip

ON_PICTURE = frozenset(
    {"panels"}
    | {f"{how}_{way}" for how in ("turn", "pan") for way in ("left", "right", "up", "down")}
)
"""Whose keys count only while the picture has the focus: lists and sliders want them too."""

ALWAYS = frozenset(
    {
        "new", "open", "quit", "preferences", "smoothing", "brush", "grips", "show_mask", "panels",
        "full_screen", "dark", "shortcuts", "about",
    }
)  # fmt: skip
"""What can be asked for while nothing is open."""

ICONS_OF = {
    "new": "new", "open": "open", "save": "save", "export": "export", "screenshot": "camera",
    "turntable": "orbit", "record": "record", "replay": "play", "undo": "undo", "redo": "redo",
    "dip": "dip", "rinse": "rinse", "swap_inks": "swap", "pick_colour": "pick", "wet": "water",
    "dry": "dry", "mirror": "mirror", "radial": "radial", "mask": "mask", "frame_all": "frame",
    "brush": "brush", "add_layer": "layers", "shortcuts": "help", "refine": "refine",
}  # fmt: skip

_OWN = {
    "growth": "Film of the painting growing…",
    "save_recording": "Save the strokes as a recording…",
    "wet": "surface.wet",
    "refine": "Refine the whole surface now",
    "grips": "Grips on the picture",
    "show_mask": "Show the mask",
    "seal": "Press a seal…",
    "stand": "Turn and scale the object…",
    "dark": "Dark theme",
    "about": "menu.about",
    "choose_colour": "Mix a colour…",
    "open_pigments": "Open a table of pigments…",
    "forget_pigments": "Put own pigments away",
    "edit_brush": "Edit the brush…",
    "open_brush": "Open a brush…",
}
_TEXTS = {"brush": "Show the brush", "smoothing": "action.smoothing"}


def keys_of(action: str) -> list[str]:
    """The keys that are pressed for an action, as Qt writes them."""
    return [one.keys for one in find_shortcuts(action) if one.gesture == GESTURES[0]]


def text_of(action: str) -> str:
    """The text, or its key, that names an action."""
    if action.startswith("brush_"):
        return brush_names()[int(action.removeprefix("brush_")) - 1]
    if action in _OWN or action in _TEXTS:
        return _OWN.get(action) or _TEXTS[action]
    return f"action.{action}"


def _check() -> None:
    known = {one.action for one in SHORTCUTS} | set(_OWN)
    for actions in (*MENUS.values(), TOOLS):
        missing = set(actions) - known - {"-"}
        assert not missing, missing


_check()
