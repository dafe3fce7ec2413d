"""The whole key map, as data: what artists know from other programs.

B brush, [ ] size and F held for a drag as in Blender and Krita, X swaps and I picks as in
Photoshop, Alt with the mouse's buttons as in Maya, the middle button and the keypad as in Blender,
Space held for a drag as in Krita (for where the window manager takes Alt), fingers as in Procreate.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["GESTURES", "GROUPS", "SHORTCUTS", "Shortcut", "find_shortcuts"]

GESTURES = ("press", "hold", "drag", "tap")
"""Pressed; held for as long as it counts; held, or pressed down, while the pointer moves; fingers
that touch and leave."""

GROUPS = ("file", "edit", "brush", "ink", "stroke", "view", "layers", "window")


@dataclass(frozen=True)
class Shortcut:
    """One way to ask for something.

    Attributes
    ----------
    keys : str
        As Qt's `QKeySequence` writes them: "Ctrl+Shift+Z"; mouse buttons are "Left", "Middle",
        "Right", and the wheel "Wheel"; a key of the keypad is "Num+" and what it says with
        NumLock; "Pen 1" and "Pen 2" are a pen's buttons, "Fingers 2" is two fingers, "Beside" is a
        drag that begins beside the object.
    action : str
        What is asked for; "action." and this is the key of its text.
    group : str
        One of `GROUPS`.
    gesture : str
        One of `GESTURES`.
    """

    keys: str
    action: str
    group: str
    gesture: str = "press"


def _group(group: str, *rows: tuple[str, ...]) -> tuple[Shortcut, ...]:
    return tuple(Shortcut(keys, action, group, *gesture) for keys, action, *gesture in rows)


SHORTCUTS: tuple[Shortcut, ...] = (
    *_group(
        "file",
        ("Ctrl+N", "new"),
        ("Ctrl+O", "open"),
        ("Ctrl+S", "save"),
        ("Ctrl+Shift+S", "save_as"),
        ("Ctrl+E", "export"),
        ("Ctrl+Shift+E", "turntable"),
        ("F12", "screenshot"),
        ("Ctrl+Q", "quit"),
    ),
    *_group(
        "edit",
        ("Ctrl+Z", "undo"),
        ("Ctrl+Shift+Z", "redo"),
        ("Ctrl+Y", "redo"),
        ("Fingers 2", "undo", "tap"),
        ("Fingers 3", "redo", "tap"),
        ("Ctrl+,", "preferences"),
    ),
    *_group(
        "brush",
        ("B", "brush"),
        ("[", "smaller"),
        ("]", "larger"),
        ("F", "size", "drag"),
        ("Shift+F", "force", "drag"),
        (".", "harder", "hold"),
        (",", "softer", "hold"),
        ("Shift+S", "smoothing"),
        ("1", "brush_1"),
        ("2", "brush_2"),
        ("3", "brush_3"),
        ("4", "brush_4"),
        ("5", "brush_5"),
        ("6", "brush_6"),
        ("7", "brush_7"),
        ("8", "brush_8"),
        ("9", "brush_9"),
        ("0", "brush_10"),
        ("Ctrl+1", "brush_11"),
        ("Ctrl+2", "brush_12"),
        ("Ctrl+3", "brush_13"),
        ("Ctrl+4", "brush_14"),
        ("Ctrl+5", "brush_15"),
    ),
    *_group(
        "ink",
        ("X", "swap_inks"),
        ("I", "pick_colour"),
        ("D", "dip"),
        ("Shift+D", "dip_tip"),
        ("R", "rinse"),
        ("W", "wipe"),
        ("Shift+W", "dry"),
    ),
    *_group(
        "stroke",
        ("Left", "paint", "drag"),
        ("Fingers 1", "paint", "drag"),
        ("Shift+Left", "bend", "drag"),
        ("Esc", "cancel_stroke"),
        ("M", "mirror"),
        ("Shift+M", "radial"),
        ("K", "mask"),
        ("Shift+K", "pick_region"),
        ("Ctrl+Shift+K", "clear_mask"),
        ("Ctrl+R", "record"),
        ("Ctrl+Shift+R", "replay"),
    ),
    *_group(
        "view",
        ("Beside", "orbit", "drag"),
        ("Space+Left", "orbit", "drag"),
        ("Alt+Left", "orbit", "drag"),
        ("Middle", "orbit", "drag"),
        ("Pen 1", "orbit", "drag"),
        ("Fingers 3", "orbit", "drag"),
        ("Shift+Space+Left", "pan", "drag"),
        ("Alt+Middle", "pan", "drag"),
        ("Shift+Middle", "pan", "drag"),
        ("Pen 2", "pan", "drag"),
        ("Ctrl+Space+Left", "dolly", "drag"),
        ("Alt+Right", "dolly", "drag"),
        ("Ctrl+Middle", "dolly", "drag"),
        ("Wheel", "dolly", "drag"),
        ("Ctrl+Shift+Space+Left", "roll", "drag"),
        ("Fingers 2", "pinch", "drag"),
        ("F", "frame_selected"),
        ("Num+.", "frame_selected"),
        ("Home", "frame_all"),
        ("Num+5", "frame_all"),
        ("Left", "turn_left"),
        ("Num+4", "turn_left"),
        ("Right", "turn_right"),
        ("Num+6", "turn_right"),
        ("Up", "turn_up"),
        ("Num+8", "turn_up"),
        ("Down", "turn_down"),
        ("Num+2", "turn_down"),
        ("Shift+Left", "pan_left"),
        ("Ctrl+Num+4", "pan_left"),
        ("Shift+Right", "pan_right"),
        ("Ctrl+Num+6", "pan_right"),
        ("Shift+Up", "pan_up"),
        ("Ctrl+Num+8", "pan_up"),
        ("Shift+Down", "pan_down"),
        ("Ctrl+Num+2", "pan_down"),
        ("+", "nearer"),
        ("=", "nearer"),
        ("Num++", "nearer"),
        ("-", "farther"),
        ("Num+-", "farther"),
        ("Ctrl+[", "roll_left"),
        ("Num+/", "roll_left"),
        ("Ctrl+]", "roll_right"),
        ("Num+*", "roll_right"),
        ("Shift+Home", "upright"),
        ("Num+0", "upright"),
        ("Num+1", "look_front"),
        ("Ctrl+Num+1", "look_back"),
        ("Num+3", "look_right"),
        ("Ctrl+Num+3", "look_left"),
        ("Num+7", "look_top"),
        ("Ctrl+Num+7", "look_bottom"),
    ),
    *_group(
        "layers",
        ("Ctrl+Shift+N", "add_layer"),
        ("Ctrl+Shift+Del", "remove_layer"),
        ("PgUp", "layer_above"),
        ("PgDown", "layer_below"),
        ("Ctrl+PgUp", "raise_layer"),
        ("Ctrl+PgDown", "lower_layer"),
        ("H", "hide_layer"),
        ("L", "lock_layer"),
        ("F2", "rename_layer"),
    ),
    *_group(
        "window",
        ("Tab", "panels"),
        ("F6", "next_panel"),
        ("Shift+F6", "previous_panel"),
        ("F10", "menus"),
        ("F11", "full_screen"),
        ("?", "shortcuts"),
        ("F1", "shortcuts"),
    ),
)  # fmt: skip


def find_shortcuts(action: str) -> list[Shortcut]:
    """All ways to ask for an action."""
    return [shortcut for shortcut in SHORTCUTS if shortcut.action == action]
