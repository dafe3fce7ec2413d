"""Everything the window can be told, as data: menu, words, keys, icon."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["COMMANDS", "GESTURES", "MENUS", "TOOLS", "Command"]


@dataclass(frozen=True)
class Command:
    """One thing to choose from a menu, by key or from the tool bar.

    Attributes
    ----------
    name : str
        The studio's method for it is ``do_<name>``.
    menu : str
        Key of `MENUS`.
    text : str
        English; an ellipsis where more is asked.
    keys : tuple of str
        As Qt writes them; the first is shown.
    icon : str
    checkable : bool
    """

    name: str
    menu: str
    text: str
    keys: tuple[str, ...] = ()
    icon: str = ""
    checkable: bool = False


MENUS = {
    "file": "&File", "edit": "&Edit", "view": "&View", "brush": "&Brush", "layers": "&Layers",
    "help": "&Help",
}  # fmt: skip

_TABLE = (
    ("new", "file", "New painting…", ("Ctrl+N",), "new"),
    ("open", "file", "Open…", ("Ctrl+O",), "open"),
    ("save", "file", "Save", ("Ctrl+S",), "save"),
    ("save_as", "file", "Save as…", ("Ctrl+Shift+S",)),
    ("export", "file", "Export…", ("Ctrl+E",), "export"),
    ("-", "file", ""),
    ("save_recording", "file", "Save the strokes as a recording…", ()),
    ("replay", "file", "Replay a recording…", ("Ctrl+R",), "play"),
    ("screenshot", "file", "Picture of the view…", ("Ctrl+P",), "camera"),
    ("turntable", "file", "Turntable film…", ()),
    ("-", "file", ""),
    ("quit", "file", "Quit", ("Ctrl+Q",)),
    ("undo", "edit", "Undo", ("Ctrl+Z",), "undo"),
    ("redo", "edit", "Redo", ("Ctrl+Shift+Z", "Ctrl+Y"), "redo"),
    ("-", "edit", ""),
    ("dry", "edit", "Let everything dry", ("Ctrl+D",), "dry"),
    ("wet", "edit", "Let ink run while painting", ("Ctrl+W",), "water", True),
    ("frame_all", "view", "Show the whole object", ("F",), "frame"),
    ("front", "view", "From the front", ("1",)),
    ("right", "view", "From the right", ("3",)),
    ("top", "view", "From above", ("7",)),
    ("-", "view", ""),
    ("show_brush", "view", "Show the brush", ("B",), "brush", True),
    ("dark", "view", "Dark theme", (), "", True),
    ("english", "view", "English", ()),
    ("chinese", "view", "中文", ()),
    ("full_screen", "view", "Full screen", ("F11",), "", True),
    ("dip", "brush", "Dip in the same ink", ("D",), "dip"),
    ("rinse", "brush", "Rinse", ("R",), "rinse"),
    ("wipe", "brush", "Wipe half off", ("W",)),
    ("swap_inks", "brush", "Swap the two inks", ("X",), "swap"),
    ("pick", "brush", "Pick up the ink under the pointer", ("I",), "pick"),
    ("-", "brush", ""),
    ("smaller", "brush", "Smaller brush", ("[",)),
    ("larger", "brush", "Larger brush", ("]",)),
    ("mirror", "brush", "Mirror left and right", ("M",), "mirror", True),
    ("-", "layers", ""),
    ("keys", "help", "Keys and gestures", ("?", "F1"), "help"),
    ("about", "help", "About paint3d", ()),
)
COMMANDS = tuple(Command(*row) for row in _TABLE)

TOOLS = (
    "open", "save", "-", "undo", "redo", "-", "dip", "rinse", "swap_inks", "pick", "-", "mirror",
    "wet", "dry", "-", "frame_all", "show_brush", "screenshot",
)  # fmt: skip

GESTURES = (
    ("Left button or pen tip", "Paint; a pen's pressure, tilt and twist are the brush's"),
    ("Pen's other end", "Rinse the brush as it comes near"),
    ("Alt + drag, middle button", "Turn around the object"),
    ("Shift + middle button", "Move sideways"),
    ("Wheel, right button", "Come nearer"),
    ("F, held and dragged", "Size of the brush"),
    ("Wheel while painting", "Press harder or softer with a mouse"),
)
