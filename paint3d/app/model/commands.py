"""The registry of commands: whatever a user can ask for, and everything that is said of it.

One entry of `COMMANDS` says where a command stands in the menus, what its keys are, what it is
called, and, if it changes the painting, how recordings and journals write it down. `Document` has a
method of that name for each command that changes the painting (`@recorded`). The window calls
that method, or ``do_<name>`` of one of its parts where something has to be asked or looked up.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from paint3d.app.model.input.symmetry import MirrorPlane, RadialSymmetry, Symmetry
from paint3d.app.model.mask import AngleMask, Mask, RegionPick
from paint3d.app.model.score.words import (
    BRUSH,
    DIP,
    EDIT,
    MASK,
    PLAIN,
    SEAL,
    STROKE,
    SYMMETRY,
    TAGS,
    Codec,
    Inks,
    Vocabulary,
)
from paint3d.brush.presets import brush_names
from paint3d.brush.spec import BristleSpec, BrushSpec
from paint3d.colour.pigments import Pigment
from paint3d.errors import SessionError
from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "COMMANDS",
    "GESTURES",
    "GROUPS",
    "MENUS",
    "SHORTCUTS",
    "TOOLS",
    "Command",
    "Shortcut",
    "arguments_of",
    "decode_command",
    "do_again",
    "encode_command",
    "find_shortcuts",
    "line_of",
]

GESTURES = ("press", "hold", "drag", "tap")
"""Pressed; held for as long as it counts; held, or pressed down, while the pointer moves; fingers
that touch and leave."""

GROUPS = ("file", "edit", "brush", "ink", "stroke", "view", "layers", "window")
"""Parts of the list of shortcuts."""


@dataclass(frozen=True)
class Command:
    """Something that a user can ask for.

    Attributes
    ----------
    name : str
        Of the method of `Document` and of ``do_<name>`` in the window.
    keys : sequence of str
        Pressed for it, as Qt's `QKeySequence` writes them: "Ctrl+Shift+Z"; a key of the keypad is
        "Num+" and what it says with NumLock.
    hold, drag, tap : sequence of str
        Other ways to ask for it (`GESTURES`). Mouse buttons are "Left", "Middle", "Right", and the
        wheel "Wheel"; "Pen 1" and "Pen 2" are a pen's buttons, "Fingers 2" is two fingers, "Beside"
        is a drag that begins beside the object.
    text : str
        Its name for users: a key of the texts; by default "action.<name>".
    icon : str
        See `app.window.icons`; empty for none.
    menu, group : str
        Where it stands; empty for nowhere. The group of its shortcuts is the menu by default.
    checkable : bool
        Whether it is switched on and off.
    always : bool
        Whether it can be asked for while nothing is open.
    on_picture : bool
        Whether its keys count only while the picture has the focus: lists and sliders want them,
        too.
    codec : Codec or None
        How its arguments are written down, if it changes the painting: journals have all such
        commands, recordings those that ``recording/data/score.schema.json`` describes.
    step : str
        Label of the undo step that it makes; empty where it makes none.
    cost : float
        Of doing it again, in samples painted, roughly.
    written_as : str
        Command of the recording that says what it led to; empty for itself.
    """

    name: str
    keys: Sequence[str] = ()
    hold: Sequence[str] = ()
    drag: Sequence[str] = ()
    tap: Sequence[str] = ()
    text: str = ""
    icon: str = ""
    menu: str = ""
    group: str = ""
    checkable: bool = False
    always: bool = False
    on_picture: bool = False
    codec: Codec | None = None
    step: str = ""
    cost: float = 1.0
    written_as: str = ""

    @property
    def label(self) -> str:
        """The key of its text."""
        return self.text or f"action.{self.name}"


@dataclass(frozen=True)
class Shortcut:
    """One way to ask for a command.

    Attributes
    ----------
    keys : str
        See `Command`.
    action : str
        The command's name.
    group : str
        One of `GROUPS`.
    gesture : str
        One of `GESTURES`.
    """

    keys: str
    action: str
    group: str
    gesture: str = "press"


# ---- The table -----------------------------------------------------------------------------------

_Row = Command | str
_PART = "-"  # between two parts of a menu


def _menu(name: str, *rows: _Row) -> tuple[_Row, ...]:
    return tuple(row if isinstance(row, str) else replace(row, menu=name) for row in rows)


def _brush_rows() -> Iterable[Command]:
    keys = [*"1234567890", *(f"Ctrl+{digit}" for digit in "123456789")]
    for k, name in enumerate(brush_names(), 1):
        yield Command(f"brush_{k}", keys[k - 1 : k], text=name)


_view_keys = {
    "left": ("Left", "4"), "right": ("Right", "6"), "up": ("Up", "8"), "down": ("Down", "2"),
}  # fmt: skip
_turns = (
    Command(f"turn_{to}", (arrow, f"Num+{digit}"), on_picture=True)
    for to, (arrow, digit) in _view_keys.items()
)
_pans = (
    Command(f"pan_{to}", (f"Shift+{arrow}", f"Ctrl+Num+{digit}"), on_picture=True)
    for to, (arrow, digit) in _view_keys.items()
)

# The order is that of the menus. Keys are those that artists know from other programs: B brush, [ ]
# size and F held for a drag as in Blender and Krita, X swaps and I picks as in Photoshop, Alt with
# the mouse's buttons as in Maya, the middle button and the keypad as in Blender, Space held for a
# drag as in Krita (for where the window manager takes Alt), fingers as in Procreate.
_TABLE: tuple[_Row, ...] = (
    *_menu(
        "file",
        Command("new", ["Ctrl+N"], icon="new", always=True),
        Command("open", ["Ctrl+O"], icon="open", always=True),
        Command("save", ["Ctrl+S"], icon="save"),
        Command("save_as", ["Ctrl+Shift+S"]),
        Command("export", ["Ctrl+E"], icon="export"),
        _PART,
        Command("screenshot", ["F12"], icon="camera"),
        Command("turntable", ["Ctrl+Shift+E"], icon="orbit"),
        Command("growth", text="Film of the painting growing…"),
        _PART,
        Command("record", ["Ctrl+R"], icon="record", group="stroke", checkable=True),
        Command("replay", ["Ctrl+Shift+R"], icon="play", group="stroke"),
        Command("save_recording", text="Save the strokes as a recording…"),
        _PART,
        Command("quit", ["Ctrl+Q"], always=True),
    ),
    *_menu(
        "edit",
        Command("undo", ["Ctrl+Z"], tap=["Fingers 2"], icon="undo", codec=PLAIN, cost=50.0),
        Command(
            "redo",
            ["Ctrl+Shift+Z", "Ctrl+Y"],
            tap=["Fingers 3"],
            icon="redo",
            codec=PLAIN,
            cost=50.0,
        ),
        _PART,
        Command("cancel_stroke", ["Esc"], group="stroke", codec=PLAIN),
        _PART,
        Command("lay_out", text="Lay out a text…"),
        Command("arrange_text", ["T"], checkable=True),
        Command("sign", text="Signature and date…"),
        _PART,
        Command("stand", text="Turn and scale the object…"),
        _PART,
        Command("preferences", ["Ctrl+,"], always=True),
    ),
    *_menu(
        "brush",
        Command("smaller", ["["]),
        Command("larger", ["]"]),
        Command("smoothing", ["Shift+S"], checkable=True, always=True),
        Command("brush", ["B"], text="Show the brush", icon="brush", checkable=True, always=True),
        _PART,
        *_brush_rows(),
        _PART,
        Command("edit_brush", text="Edit the brush…"),
        Command("open_brush", text="Open a brush…"),
    ),
    *_menu(
        "ink",
        Command("dip", ["D"], icon="dip", codec=DIP),
        Command("dip_tip", ["Shift+D"]),
        Command("rinse", ["R"], icon="rinse", codec=PLAIN),
        Command("wipe", ["W"], codec=PLAIN),
        _PART,
        Command("swap_inks", ["X"], icon="swap", codec=PLAIN, written_as="dip"),
        Command("pick_colour", ["I"], icon="pick", codec=PLAIN, written_as="dip"),
        _PART,
        Command("choose_colour", text="Mix a colour…"),
        Command("open_pigments", text="Open a table of pigments…"),
        Command("forget_pigments", text="Remove own pigments"),
        _PART,
        Command("wet", text="surface.wet", icon="water", checkable=True),
        Command("dry", ["Shift+W"], icon="dry", codec=PLAIN, step="dry"),
        _PART,
        Command("seal", text="Press a seal…"),
    ),
    *_menu(
        "stroke",
        Command("mirror", ["M"], icon="mirror", checkable=True),
        Command("radial", ["Shift+M"], icon="radial", checkable=True),
        _PART,
        Command("mask", ["K"], icon="mask", checkable=True),
        Command("pick_region", ["Shift+K"]),
        Command("clear_mask", ["Ctrl+Shift+K"]),
        _PART,
        Command("refine", text="Refine the whole surface now", icon="refine"),
    ),
    *_menu(
        "view",
        Command("frame_all", ["Home", "Num+5"], icon="frame"),
        Command("frame_selected", ["F", "Num+."]),
        Command("nearer", ["+", "=", "Num++"]),
        Command("farther", ["-", "Num+-"]),
        _PART,
        Command("look_front", ["Num+1"]),
        Command("look_back", ["Ctrl+Num+1"]),
        Command("look_left", ["Ctrl+Num+3"]),
        Command("look_right", ["Num+3"]),
        Command("look_top", ["Num+7"]),
        Command("look_bottom", ["Ctrl+Num+7"]),
        _PART,
        *_turns,
        _PART,
        *_pans,
        _PART,
        Command("roll_left", ["Ctrl+[", "Num+/"]),
        Command("roll_right", ["Ctrl+]", "Num+*"]),
        Command("upright", ["Shift+Home", "Num+0"]),
        _PART,
        Command("grips", text="Grips on the picture", checkable=True, always=True),
        Command("show_mask", text="Show the mask", checkable=True, always=True),
    ),
    *_menu(
        "layers",
        Command("add_layer", ["Ctrl+Shift+N"], icon="layers", codec=PLAIN, step="add layer"),
        Command("remove_layer", ["Ctrl+Shift+Del"], codec=PLAIN, step="remove layer"),
        Command("rename_layer", ["F2"], codec=PLAIN),
        _PART,
        Command("layer_above", ["PgUp"]),
        Command("layer_below", ["PgDown"]),
        Command("raise_layer", ["Ctrl+PgUp"]),
        Command("lower_layer", ["Ctrl+PgDown"]),
        _PART,
        Command("hide_layer", ["H"]),
        Command("lock_layer", ["L"]),
    ),
    *_menu(
        "window",
        Command("panels", ["Tab"], always=True, on_picture=True),
        Command("next_panel", ["F6"]),
        Command("previous_panel", ["Shift+F6"]),
        Command("menus", ["F10"]),
        Command("full_screen", ["F11"], checkable=True, always=True),
        Command("dark", text="Dark theme", checkable=True, always=True),
        _PART,
    ),
    *_menu(
        "help",
        Command("shortcuts", ["?", "F1"], icon="help", group="window", always=True),
        Command("about", text="menu.about", always=True),
    ),
    # what is done by a gesture alone, in no menu
    Command("size", drag=["F"], group="brush"),
    Command("force", drag=["Shift+F"], group="brush"),
    Command("harder", hold=["."], group="brush"),
    Command("softer", hold=[","], group="brush"),
    Command("paint", drag=["Left", "Fingers 1"], group="stroke"),
    Command("bend", drag=["Shift+Left"], group="stroke"),
    Command(
        "orbit",
        drag=["Beside", "Space+Left", "Alt+Left", "Middle", "Pen 1", "Fingers 3"],
        group="view",
    ),
    Command(
        "pan",
        drag=["Shift+Space+Left", "Alt+Middle", "Shift+Middle", "Pen 2"],
        group="view",
    ),
    Command("dolly", drag=["Ctrl+Space+Left", "Alt+Right", "Ctrl+Middle", "Wheel"], group="view"),
    Command("roll", drag=["Ctrl+Shift+Space+Left"], group="view"),
    Command("pinch", drag=["Fingers 2"], group="view"),
    # what panels, the hand and the painting thread ask for
    Command("begin_stroke", codec=STROKE),
    Command("end_stroke", codec=PLAIN),
    Command("lift", codec=PLAIN),
    Command("follow_time", codec=PLAIN, cost=10.0),
    Command("let_time_pass", codec=PLAIN, cost=50.0),
    Command("set_brush", codec=BRUSH),
    Command("scale_brush", codec=PLAIN),
    Command("resize_brush", codec=PLAIN),
    Command("step_brush", codec=PLAIN),
    Command("set_azimuth", codec=PLAIN),
    Command("set_pickup", codec=PLAIN),
    Command("set_symmetry", codec=SYMMETRY),
    Command("set_mask", codec=MASK),
    Command("set_tags", codec=TAGS),
    Command("select_layer", codec=PLAIN),
    Command("move_layer", codec=PLAIN, step="move layer"),
    Command("set_visible", codec=PLAIN),
    Command("set_locked", codec=PLAIN),
    Command("lay_text", codec=PLAIN, step="text"),
    Command("remove_text", codec=PLAIN, step="text"),
    Command("press_seal", codec=SEAL, step="seal"),
    Command("replay_history", codec=PLAIN),
    Command("edit_stroke", codec=EDIT, step="edit"),
    Command("edit_seal", codec=EDIT, step="edit"),
)

TOOLS = (
    "open", "save", "-", "undo", "redo", "-", "dip", "rinse", "swap_inks", "pick_colour", "-",
    "mirror", "radial", "wet", "dry", "-", "frame_all", "brush", "screenshot", "record", "-",
    "shortcuts",
)  # fmt: skip
"""What stands in the tool bar; "-" parts it."""

COMMANDS: Mapping[str, Command] = {row.name: row for row in _TABLE if isinstance(row, Command)}
"""All commands by name."""


def _menus() -> dict[str, tuple[str, ...]]:
    menus: dict[str, list[str]] = {}
    at: list[str] = []
    for row in _TABLE:
        if isinstance(row, str):
            at.append(row)
        elif row.menu:
            at = menus.setdefault(row.menu, [])
            at.append(row.name)
    return {name: tuple(rows) for name, rows in menus.items()}


MENUS: Mapping[str, tuple[str, ...]] = _menus()
"""Menu to the names of its commands; "-" parts them."""

SHORTCUTS: tuple[Shortcut, ...] = tuple(
    Shortcut(keys, one.name, one.group or one.menu, gesture)
    for one in COMMANDS.values()
    for gesture, ways in zip(GESTURES, (one.keys, one.hold, one.drag, one.tap), strict=True)
    for keys in ways
)
"""The whole key map."""


def find_shortcuts(name: str) -> list[Shortcut]:
    """All ways to ask for a command."""
    return [shortcut for shortcut in SHORTCUTS if shortcut.action == name]


# ---- Commands as lines ---------------------------------------------------------------------------
# A journal and a recording write a command in the same words. A recording can be played on another
# object; a journal goes on from a painting, so it may name faces by their numbers, and each of its
# lines brings the pigments that are not in the palette.


def line_of(name: str, asked: Mapping[str, Any], vocabulary: Vocabulary) -> dict[str, Any]:
    """A command as a line of a recording says it.

    Parameters
    ----------
    name : str
    asked : mapping
        What it was called with, by the names of its parameters.
    vocabulary : Vocabulary

    Raises
    ------
    RecordingError
        If a line cannot say it.
    Paint3DError
        If a brush or an ink is not known.
    """
    codec = COMMANDS[name].codec
    assert codec is not None, "it changes the painting"
    given = {k: v for k, v in asked.items() if v is not None and not (isinstance(v, str) and not v)}
    return {"do": name, **codec.encode(given, vocabulary)}


def arguments_of(line: Mapping[str, Any], vocabulary: Vocabulary) -> dict[str, Any]:
    """The arguments, by name, that a line calls a method of `Document` with.

    Raises
    ------
    Paint3DError
        If a brush or an ink is not known, or a value is out of its range.
    """
    codec = COMMANDS[line["do"]].codec
    assert codec is not None, "it changes the painting"
    about = ("do", "refused", "times", "pigments")
    return codec.decode({k: v for k, v in line.items() if k not in about}, vocabulary)


def encode_command(
    document: Any, name: str, arguments: Sequence[object], options: Mapping[str, Any]
) -> dict[str, Any]:
    """A command of a document as its journal says it.

    Raises
    ------
    SessionError, RecordingError
        If an argument cannot be written down.
    Paint3DError
        If an argument is one that the document refuses.
    """
    try:
        asked = dict(_signature(getattr(type(document), name)).bind(None, *arguments, **options)
                     .arguments)  # fmt: skip
    except TypeError as cause:
        raise SessionError(f"{name} cannot be called so: {cause}") from None
    asked.pop("self")
    inks = Inks({}, apart=True)
    line = line_of(name, asked, Vocabulary(document.surface, inks, exact=True))
    return line | ({"pigments": inks.table} if inks.table else {})


_signature = lru_cache(inspect.signature)


def decode_command(
    line: Mapping[str, Any], surface: PaintedSurface
) -> tuple[str, list[Any], dict[str, Any]]:
    """The name, arguments and options of a command that a journal wrote down.

    Raises
    ------
    SessionError
        If no document does such a thing, or the line is damaged.
    """
    name = line.get("do")
    if not isinstance(name, str) or name not in COMMANDS or COMMANDS[name].codec is None:
        raise SessionError(f"the journal asks for {name!r:.40}; expected what a document can do")
    try:
        if "with" in line or "options" in line:
            arguments = [_rich(value) for value in line.get("with", [])]
            return name, arguments, {k: _rich(v) for k, v in line.get("options", {}).items()}
        inks = Inks(dict(line.get("pigments", {})), apart=True)
        return name, [], arguments_of(line, Vocabulary(surface, inks, exact=True))
    except (TypeError, AttributeError, KeyError) as cause:
        raise SessionError(f"the journal's {name} cannot be used: {cause}") from None


def do_again(document: Any, line: Mapping[str, Any]) -> None:
    """Do what a document's journal wrote down.

    Raises
    ------
    Paint3DError
        As when it was asked for first.
    """
    name, arguments, options = decode_command(line, document.surface)
    getattr(document, name)(*arguments, **options)


# Journals of before commands were lines gave arguments by their places, and objects by their class.
_KINDS: dict[str, type[Any]] = {
    kind.__name__: kind
    for kind in (BrushSpec, BristleSpec, Pigment, Symmetry, MirrorPlane, RadialSymmetry, Mask,
                 AngleMask, RegionPick)
}  # fmt: skip


def _rich(value: object) -> object:
    if isinstance(value, list):
        return tuple(_rich(item) for item in value)
    if not isinstance(value, Mapping):
        return value
    if value.get("@") == "pairs":
        return {_rich(key): _rich(item) for key, item in value["pairs"]}
    own = {key: _rich(item) for key, item in value.items() if key != "@"}
    return _KINDS[value["@"]](**own) if "@" in value else own
