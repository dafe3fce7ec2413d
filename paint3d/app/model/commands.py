"""The registry of commands: each with its keys, its texts, and how undo treats it.

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
from paint3d.app.model.score.codecs import (
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
    InkTable,
    Vocabulary,
)
from paint3d.brush.presets import brush_names
from paint3d.brush.spec import BristleSpec, BrushSpec
from paint3d.colour.pigments import Pigment
from paint3d.errors import Message, SessionError
from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "COMMANDS",
    "GESTURES",
    "GROUPS",
    "MENUS",
    "SHORTCUTS",
    "TITLES",
    "TOOLS",
    "Command",
    "Shortcut",
    "decode_arguments",
    "decode_command",
    "encode_command",
    "encode_line",
    "replay_command",
]

GESTURES = ("press", "hold", "drag", "tap")
"""Pressed; held for as long as it counts; held, or pressed down, while the pointer moves; fingers
that touch and leave."""

GROUPS = ("file", "edit", "brush", "ink", "text", "stroke", "view", "layers", "window")
"""Parts of the list of shortcuts."""

TITLES = {
    "file": Message("File"),
    "edit": Message("Edit"),
    "brush": Message("Brush"),
    "ink": Message("Ink"),
    "text": Message("Text and seal"),
    "stroke": Message("Stroke"),
    "view": Message("View"),
    "layers": Message("Layers"),
    "window": Message("Window"),
    "help": Message("Help"),
}
"""What menus and groups are called."""


@dataclass(frozen=True)
class Command:
    """A command of the studio.

    Attributes
    ----------
    name : str
        Of the method of `Document` and of ``do_<name>`` in the window.
    text : str
        Its name for users, in English; empty for what they ask for by none.
    keys : sequence of str
        Pressed for it, as Qt's `QKeySequence` writes them: "Ctrl+Shift+Z"; a key of the keypad is
        "Num+" and what it says with NumLock.
    hold, drag, tap : sequence of str
        Other ways to ask for it (`GESTURES`). Mouse buttons are "Left", "Middle", "Right", and the
        wheel "Wheel"; "Pen 1" and "Pen 2" are a pen's buttons, "Fingers 2" is two fingers, "Beside"
        is a drag that begins beside the object.
    icon : str
        See `app.window.theme`; empty for none.
    tool : int
        Where it stands in the tool bar: its part, from 1, and its position in that, as two digits;
        0 for nowhere.
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
    undo_label : str
        Label of the undo step that it makes; empty where it makes none.
    cost : float
        Of doing it again, in samples painted, roughly.
    written_as : str
        Command of the recording that says what it led to; empty for itself.
    """

    name: str
    text: str = ""
    keys: Sequence[str] = ()
    hold: Sequence[str] = ()
    drag: Sequence[str] = ()
    tap: Sequence[str] = ()
    icon: str = ""
    tool: int = 0
    menu: str = ""
    group: str = ""
    checkable: bool = False
    always: bool = False
    on_picture: bool = False
    codec: Codec | None = None
    undo_label: str = ""
    cost: float = 1.0
    written_as: str = ""


@dataclass(frozen=True)
class Shortcut:
    """A way to ask for a command.

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
        yield Command(f"brush_{k}", name, keys[k - 1 : k])


# The order is that of the menus. Keys are those that artists know from other programs: B brush, [ ]
# size and F held for a drag as in Blender and Krita, X swaps and I picks as in Photoshop, Alt with
# the mouse's buttons as in Maya, the middle button and the keypad as in Blender, Space held for a
# drag as in Krita (for where the window manager takes Alt), fingers as in Procreate.
_TABLE: tuple[_Row, ...] = (
    *_menu(
        "file",
        Command("new", "New painting…", ["Ctrl+N"], icon="new", always=True),
        Command("open", "Open…", ["Ctrl+O"], icon="open", tool=11, always=True),
        Command("save", "Save", ["Ctrl+S"], icon="save", tool=12),
        Command("save_as", "Save as…", ["Ctrl+Shift+S"]),
        Command("export", "Export…", ["Ctrl+E"], icon="export"),
        _PART,
        Command("screenshot", "Screenshot", ["F12"], icon="camera"),
        Command("turntable", "Turntable…", ["Ctrl+Shift+E"], icon="orbit"),
        Command("growth", "Film of the painting growing…"),
        _PART,
        Command(
            "record", "Record", ["Ctrl+R"], icon="record", tool=53, group="stroke", checkable=True
        ),
        Command("replay", "Replay", ["Ctrl+Shift+R"], icon="play", group="stroke"),
        Command("save_recording", "Save the strokes as a recording…"),
        _PART,
        Command("quit", "Quit", ["Ctrl+Q"], always=True),
    ),
    *_menu(
        "edit",
        Command(
            "undo",
            "Undo",
            ["Ctrl+Z"],
            tap=["Fingers 2"],
            icon="undo",
            tool=21,
            codec=PLAIN,
            cost=50.0,
        ),
        Command(
            "redo",
            "Redo",
            ["Ctrl+Shift+Z", "Ctrl+Y"],
            tap=["Fingers 3"],
            icon="redo",
            tool=22,
            codec=PLAIN,
            cost=50.0,
        ),
        _PART,
        Command("cancel_stroke", "Cancel the stroke", ["Esc"], group="stroke", codec=PLAIN),
        _PART,
        Command("reference", "Reference picture…", ["Ctrl+Shift+O"]),
        _PART,
        Command("stand", "Turn and scale the object…"),
        _PART,
        Command("test_pen", "Test the pen…", always=True),
        Command("preferences", "Preferences…", ["Ctrl+,"], always=True),
    ),
    *_menu(
        "brush",
        Command("smaller", "Smaller brush", ["["]),
        Command("larger", "Larger brush", ["]"]),
        Command("smoothing", "Steady the stroke", ["Shift+S"], checkable=True, always=True),
        Command("ruler", "Ruler", ["U"], checkable=True, always=True),
        Command(
            "brush", "Show the brush", ["B"], icon="brush", tool=52, checkable=True, always=True
        ),
        _PART,
        *_brush_rows(),
        _PART,
        Command("edit_brush", "Edit the brush…"),
        Command("open_brush", "Open a brush…"),
    ),
    *_menu(
        "ink",
        Command("dip", "Dip", ["D"], icon="dip", tool=31, codec=DIP),
        Command("dip_tip", "Dip the tip", ["Shift+D"]),
        Command("rinse", "Rinse", ["R"], icon="rinse", tool=32, codec=PLAIN),
        Command("wipe", "Wipe", ["W"], codec=PLAIN),
        Command("dip_water", "Dip in clear water", ["Shift+R"]),
        Command("erase", "Erase", ["E"], icon="eraser", tool=33, checkable=True),
        _PART,
        Command(
            "swap_inks", "Swap inks", ["X"], icon="swap", tool=34, codec=PLAIN, written_as="dip"
        ),
        Command(
            "pick_colour",
            "Pick the ink",
            ["I"],
            icon="pick",
            tool=35,
            codec=PLAIN,
            written_as="dip",
        ),
        _PART,
        Command("choose_colour", "Mix a colour…"),
        Command("open_pigments", "Open a table of pigments…"),
        Command("forget_pigments", "Remove own pigments"),
        _PART,
        Command("wet", "Ink spreads and dries", icon="water", tool=43, checkable=True),
        Command(
            "dry",
            "Let everything dry",
            ["Shift+W"],
            icon="dry",
            tool=44,
            codec=PLAIN,
            undo_label=Message("dry"),
        ),
        Command(
            "blot",
            "Blot what is wet",
            ["Shift+E"],
            codec=PLAIN,
            undo_label=Message("blotting paper"),
        ),
    ),
    *_menu(
        "text",
        Command("lay_out", "Lay out a text…"),
        Command("arrange_text", "Move and turn texts", ["T"], checkable=True),
        Command("write_text", "Write the text with the brush", ["Shift+T"]),
        _PART,
        Command("sign", "Signature and date…"),
        Command("seal", "Press a seal…"),
    ),
    *_menu(
        "stroke",
        Command("mirror", "Mirror", ["M"], icon="mirror", tool=41, checkable=True),
        Command("radial", "Radial symmetry", ["Shift+M"], icon="radial", tool=42, checkable=True),
        _PART,
        Command("mask", "Mask", ["K"], icon="mask", checkable=True),
        Command("pick_region", "Mask the region under the pointer", ["Shift+K"]),
        Command("clear_mask", "Clear the mask", ["Ctrl+Shift+K"]),
        _PART,
        Command("choose_strokes", "Choose strokes", ["Q"], checkable=True),
        Command("mirror_strokes", "Mirror the chosen strokes", ["Ctrl+M"]),
        Command("shape_strokes", "Move, turn and scale them by numbers…"),
        Command("ink_strokes", "Paint them in the ink in hand"),
        Command("brush_strokes", "Paint them with the brush in hand"),
        Command("delete_strokes", "Delete the chosen strokes", ["Del"], on_picture=True),
        _PART,
        Command("refine", "Refine the whole surface now", icon="refine"),
        Command("set_detail", "Paint anew at another detail…", icon="refine"),
    ),
    *_menu(
        "view",
        Command("frame_all", "Show everything", ["Home", "Num+5"], icon="frame", tool=51),
        Command("frame_selected", "Show what is under the pointer", ["F", "Num+."]),
        Command("nearer", "Nearer", ["+", "=", "Num++"]),
        Command("farther", "Farther", ["-", "Num+-"]),
        _PART,
        Command("look_front", "From the front", ["Num+1"]),
        Command("look_back", "From behind", ["Ctrl+Num+1"]),
        Command("look_left", "From the left", ["Ctrl+Num+3"]),
        Command("look_right", "From the right", ["Num+3"]),
        Command("look_top", "From above", ["Num+7"]),
        Command("look_bottom", "From below", ["Ctrl+Num+7"]),
        _PART,
        Command("turn_left", "Turn to the left", ["Left", "Num+4"], on_picture=True),
        Command("turn_right", "Turn to the right", ["Right", "Num+6"], on_picture=True),
        Command("turn_up", "Turn upward", ["Up", "Num+8"], on_picture=True),
        Command("turn_down", "Turn downward", ["Down", "Num+2"], on_picture=True),
        _PART,
        Command("pan_left", "Move to the left", ["Shift+Left", "Ctrl+Num+4"], on_picture=True),
        Command("pan_right", "Move to the right", ["Shift+Right", "Ctrl+Num+6"], on_picture=True),
        Command("pan_up", "Move upward", ["Shift+Up", "Ctrl+Num+8"], on_picture=True),
        Command("pan_down", "Move downward", ["Shift+Down", "Ctrl+Num+2"], on_picture=True),
        _PART,
        Command("roll_left", "Roll anticlockwise", ["Ctrl+[", "Num+/"]),
        Command("roll_right", "Roll clockwise", ["Ctrl+]", "Num+*"]),
        Command("upright", "Hold upright", ["Shift+Home", "Num+0"]),
        _PART,
        Command("choose_light", "Light…"),
        Command("next_light", "Another light", ["Shift+J"]),
        _PART,
        Command("keep_view", "Keep this view…", ["Ctrl+Shift+B"]),
        Command("recall_view", "Kept views…", ["Ctrl+B"]),
        _PART,
        Command("grips", "Grips on the picture", checkable=True, always=True),
        Command("show_mask", "Show the mask", checkable=True, always=True),
    ),
    *_menu(
        "layers",
        Command(
            "add_layer",
            "New layer",
            ["Ctrl+Shift+N"],
            icon="layers",
            codec=PLAIN,
            undo_label=Message("add layer"),
        ),
        Command(
            "remove_layer",
            "Delete layer",
            ["Ctrl+Shift+Del"],
            codec=PLAIN,
            undo_label=Message("remove layer"),
        ),
        Command("rename_layer", "Rename layer", ["F2"], codec=PLAIN),
        Command(
            "duplicate_layer",
            "Duplicate layer",
            ["Ctrl+J"],
            codec=PLAIN,
            undo_label=Message("duplicate layer"),
        ),
        Command(
            "merge_layer",
            "Merge with the layer below",
            ["Ctrl+Shift+J"],
            codec=PLAIN,
            undo_label=Message("merge layers"),
        ),
        _PART,
        Command(
            "add_group",
            "Group layers",
            ["Ctrl+G"],
            icon="group",
            codec=PLAIN,
            undo_label=Message("group layers"),
        ),
        Command(
            "ungroup",
            "Ungroup layers",
            ["Ctrl+Shift+G"],
            codec=PLAIN,
            undo_label=Message("ungroup layers"),
        ),
        _PART,
        Command("layer_above", "Layer above", ["PgUp"]),
        Command("layer_below", "Layer below", ["PgDown"]),
        Command("raise_layer", "Raise layer", ["Ctrl+PgUp"]),
        Command("lower_layer", "Lower layer", ["Ctrl+PgDown"]),
        _PART,
        Command("hide_layer", "Show or hide layer", ["H"]),
        Command("lock_layer", "Lock or unlock layer", ["L"]),
    ),
    *_menu(
        "window",
        Command("panels", "Show or hide panels", ["Tab"], always=True, on_picture=True),
        Command("next_panel", "Next panel", ["F6"]),
        Command("previous_panel", "Previous panel", ["Shift+F6"]),
        Command("menus", "Menus", ["F10"]),
        Command("full_screen", "Full screen", ["F11"], checkable=True, always=True),
        Command("dark", "Dark theme", checkable=True, always=True),
        _PART,
    ),
    *_menu(
        "help",
        Command(
            "shortcuts",
            "Keyboard shortcuts",
            ["?", "F1"],
            icon="help",
            tool=54,
            group="window",
            always=True,
        ),
        Command("tour", "A short tour", always=True),
        Command("sample", "A sample painting", always=True),
        Command("about", "About paint3d", always=True),
    ),
    # what is done by a gesture alone, in no menu
    Command("size", "Brush size", drag=["F"], group="brush"),
    Command("water", "Water in the ink", drag=["V"], group="ink"),
    Command("lamp", "Turn the lamp", drag=["J"], group="view"),
    Command("force", "Force without a pen", drag=["Shift+F"], group="brush"),
    Command("harder", "Press harder", hold=["."], group="brush"),
    Command("softer", "Press softer", hold=[","], group="brush"),
    Command("paint", "Paint", drag=["Left", "Fingers 1"], group="stroke"),
    Command("bend", "Bend the tuft in place (mouse)", drag=["Shift+Left"], group="stroke"),
    Command(
        "orbit",
        "Turn the view",
        drag=["Beside", "Space+Left", "Alt+Left", "Middle", "Pen 1", "Fingers 3"],
        group="view",
    ),
    Command(
        "pan",
        "Move the view",
        drag=["Shift+Space+Left", "Alt+Middle", "Shift+Middle", "Pen 2"],
        group="view",
    ),
    Command(
        "dolly",
        "Nearer or farther",
        drag=["Ctrl+Space+Left", "Alt+Right", "Ctrl+Middle", "Wheel"],
        group="view",
    ),
    Command("roll", "Roll the view", drag=["Ctrl+Shift+Space+Left"], group="view"),
    Command("pinch", "Move, roll and zoom the view", drag=["Fingers 2"], group="view"),
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
    Command("set_reference", codec=PLAIN),
    Command("set_views", codec=PLAIN),
    Command("set_light", codec=PLAIN),
    Command("select_layer", codec=PLAIN),
    Command("move_layer", codec=PLAIN, undo_label=Message("move layer")),
    Command("set_opacity", codec=PLAIN, undo_label=Message("opacity of a layer")),
    Command("set_blend", codec=PLAIN, undo_label=Message("blend of a layer")),
    Command("set_visible", codec=PLAIN),
    Command("duplicate_group", codec=PLAIN, undo_label=Message("duplicate group")),
    Command("move_group", codec=PLAIN, undo_label=Message("move group")),
    Command("remove_group", codec=PLAIN, undo_label=Message("remove group")),
    Command("set_group_opacity", codec=PLAIN, undo_label=Message("opacity of a group")),
    Command("set_group_blend", codec=PLAIN, undo_label=Message("blend of a group")),
    Command("rename_group", codec=PLAIN),
    Command("set_group_visible", codec=PLAIN),
    Command("set_group_folded", codec=PLAIN),
    Command("set_locked", codec=PLAIN),
    Command("lay_text", codec=PLAIN, undo_label=Message("text")),
    Command("remove_text", codec=PLAIN, undo_label=Message("text")),
    Command("press_seal", codec=SEAL, undo_label=Message("seal")),
    Command("replay_history", codec=PLAIN),
    Command("edit_strokes", codec=EDIT, undo_label=Message("edit")),
    Command("edit_seal", codec=EDIT, undo_label=Message("edit")),
)

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


def _tools() -> tuple[str, ...]:
    names: list[str] = []
    part = 0
    for row in sorted((row for row in COMMANDS.values() if row.tool), key=lambda row: row.tool):
        if part and row.tool // 10 != part:
            names.append(_PART)
        part = row.tool // 10
        names.append(row.name)
    return tuple(names)


TOOLS = _tools()
"""What stands in the tool bar; "-" parts it."""

SHORTCUTS: tuple[Shortcut, ...] = tuple(
    Shortcut(keys, one.name, one.group or one.menu, gesture)
    for one in COMMANDS.values()
    for gesture, ways in zip(GESTURES, (one.keys, one.hold, one.drag, one.tap), strict=True)
    for keys in ways
)
"""The whole key map."""


# ---- Commands as lines ---------------------------------------------------------------------------
# A journal and a recording write a command in the same words. A recording can be played on another
# object; a journal goes on from a painting, so it may name faces by their numbers, and each of its
# lines brings the pigments that are not in the palette.


def encode_line(name: str, arguments: Mapping[str, Any], vocabulary: Vocabulary) -> dict[str, Any]:
    """A command as a line of a recording says it.

    Parameters
    ----------
    name : str
    arguments : mapping
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
    given = {
        k: v for k, v in arguments.items() if v is not None and not (isinstance(v, str) and not v)
    }
    return {"do": name, **codec.encode(given, vocabulary)}


def decode_arguments(line: Mapping[str, Any], vocabulary: Vocabulary) -> dict[str, Any]:
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
        named = dict(_signature(getattr(type(document), name)).bind(None, *arguments, **options)
                     .arguments)  # fmt: skip
    except TypeError as cause:
        raise SessionError("{name} cannot be called so: {cause}", name=name, cause=cause) from None
    named.pop("self")
    inks = InkTable({}, apart=True)
    line = encode_line(name, named, Vocabulary(document.surface, inks, exact=True))
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
    if name == "edit_stroke" and "number" in line:  # journals had one stroke's edits by themselves
        rest = {key: value for key, value in line.items() if key != "number"}
        name, line = "edit_strokes", {**rest, "do": "edit_strokes", "indices": [line["number"]]}
    if not isinstance(name, str) or name not in COMMANDS or COMMANDS[name].codec is None:
        raise SessionError(
            "the journal asks for {name!r:.40}; expected what a document can do",
            name=name,
        )
    try:
        if "with" in line or "options" in line:
            arguments = [_decode_legacy(value) for value in line.get("with", [])]
            return (
                name,
                arguments,
                {k: _decode_legacy(v) for k, v in line.get("options", {}).items()},
            )
        inks = InkTable.of(line, apart=True)
        return name, [], decode_arguments(line, Vocabulary(surface, inks, exact=True))
    except (TypeError, AttributeError, KeyError) as cause:
        raise SessionError(
            "the journal's {name} cannot be used: {cause}", name=name, cause=cause
        ) from None


def replay_command(document: Any, line: Mapping[str, Any]) -> None:
    """Do what a document's journal wrote down.

    Raises
    ------
    Paint3DError
        As when it was asked for first.
    """
    name, arguments, options = decode_command(line, document.surface)
    getattr(document, name)(*arguments, **options)


# Older journals, from before commands were lines, give arguments by position, and objects by class.
_KINDS: dict[str, type[Any]] = {
    kind.__name__: kind
    for kind in (BrushSpec, BristleSpec, Pigment, Symmetry, MirrorPlane, RadialSymmetry, Mask,
                 AngleMask, RegionPick)
}  # fmt: skip


def _decode_legacy(value: object) -> object:
    if isinstance(value, list):
        return tuple(_decode_legacy(item) for item in value)
    if not isinstance(value, Mapping):
        return value
    if value.get("@") == "pairs":
        return {_decode_legacy(key): _decode_legacy(item) for key, item in value["pairs"]}
    own = {key: _decode_legacy(item) for key, item in value.items() if key != "@"}
    return _KINDS[value["@"]](**own) if "@" in value else own
