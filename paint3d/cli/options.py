"""The parser, options that several commands share, and checks made before the work starts."""

from __future__ import annotations

import argparse
import difflib
import math
import os
import re
import shutil
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Never, cast

from paint3d.errors import ExportError, InputError
from paint3d.mesh.sheets import FORMS, is_sheet, parse_sheet

__all__ = [
    "BRUSH",
    "BUILT_IN_HELP",
    "BUILT_IN_OBJECTS",
    "DIPS",
    "FILES",
    "FILM",
    "LIGHT",
    "MATERIALS",
    "OBJECTS",
    "PLACE",
    "SIDES",
    "UNITS",
    "UNIT_HELP",
    "Parser",
    "UsageError",
    "add_actions",
    "add_at_option",
    "add_dip_option",
    "add_force_option",
    "add_fps_option",
    "add_pixels_option",
    "add_quiet_option",
    "add_report_option",
    "add_seed_option",
    "add_side_option",
    "add_stylus_option",
    "add_unit_option",
    "add_up_option",
    "check_input_file",
    "check_output_file",
    "check_output_folder",
    "check_overwriting",
    "group_of",
    "hint",
    "own_file",
    "parse_count",
    "parse_gap",
    "parse_hairs",
    "parse_hand_speed",
    "parse_length_mm",
    "parse_number",
    "parse_place",
    "parse_rate",
    "parse_resolution_mm",
    "parse_seconds",
    "parse_share",
    "parse_turn",
    "parse_variation",
]

# ---- Parsing -------------------------------------------------------------------------------------


_OTHER_WORDS = {  # that users try for commands
    "gui": "paint", "open": "paint", "render": "picture", "view": "picture",
    "film": "picture", "convert": "export", "text": "write", "stamp": "seal",
    "size": "info", "measure": "info", "inspect": "info",
    "colours": "inks", "colors": "inks", "pigments": "inks", "surfaces": "materials",
}  # fmt: skip


class UsageError(Exception):
    """A command line that argparse refused."""


class _Help(argparse.HelpFormatter):
    """Fills paragraphs to the terminal's width; indented text keeps its lines."""

    def __init__(self, prog: str) -> None:
        columns = shutil.get_terminal_size((100, 24)).columns
        super().__init__(prog, max_help_position=26, width=min(columns - 2, 100))

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        paragraphs = text.strip("\n").split("\n\n")
        return "\n\n".join(
            part if re.search(r"^ ", part, re.MULTILINE) else super(_Help, self)._fill_text(
                part, width, indent
            )
            for part in paragraphs
        )  # fmt: skip


class Parser(argparse.ArgumentParser):
    """An argument parser that raises `UsageError` of one line instead of printing its usage.

    Options cannot be abbreviated. An error proposes the option nearest to a mistyped one.

    Parameters
    ----------
    examples : str
        Command lines that stand at the foot of the help, one a line.
    """

    def __init__(self, *, examples: str = "", **given: Any) -> None:
        if examples:
            lines = [line.strip() for line in examples.strip().splitlines()]
            title = "examples:" if len(lines) > 1 else "example:"
            given["epilog"] = "\n".join([title, *(f"  {line}" for line in lines)])
        super().__init__(formatter_class=_Help, allow_abbrev=False, **given)
        self.examples = examples
        self._words: Sequence[str] = ()

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse, remembering the words, in which an error looks for mistyped ones."""
        self._words = sys.argv[1:] if args is None else list(args)
        return super().parse_known_args(args, namespace)

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse; unknown words are an error, which names the command they follow."""
        parsed, unknown = self.parse_known_args(args, namespace)
        if unknown:
            parser = self._chosen(parsed)
            meant = parser._unknown_option(unknown)
            near = hint(meant, parser._option_string_actions) if meant else ""
            parser.error(f"unrecognized arguments: {' '.join(unknown)}{near}")
        return parsed

    def error(self, message: str) -> Never:
        """Refuse the command line."""
        if message.startswith("the following arguments are required"):
            meant = self._unknown_option(self._words)  # a mistyped option is why one is missing
            if meant:
                message = f"there is no {meant}{hint(meant, self._option_string_actions)}"
        raise UsageError(f"{message} (see {self.prog} --help)")

    def format_help(self) -> str:
        """Return the help: a short usage, groups of options in one order for all commands."""
        self._action_groups.sort(
            key=lambda group: _ORDER.index(group.title) if group.title in _ORDER else -1
        )
        if self.usage is None and len(self._actions) > _MANY_OPTIONS:
            needed = [action for action in self.option_actions() if action.required]
            words = [self.prog, *(f"{a.option_strings[-1]} {a.metavar}" for a in needed)]
            for action in self._actions:
                if not action.option_strings:
                    name = str(action.metavar or action.dest)
                    words.insert(1, f"[{name}]" if action.nargs == "?" else name)
            self.usage = " ".join([*words, "[options]"]).replace("%", "%%")
        return super().format_help()

    def actions(self) -> dict[str, Parser]:
        """Return the parsers of commands or actions by name; empty where there are none."""
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                return {
                    name: one for name, one in action.choices.items() if isinstance(one, Parser)
                }
        return {}

    def option_actions(self) -> list[argparse.Action]:
        """Return the options, without positional arguments."""
        return [action for action in self._actions if action.option_strings]

    def _chosen(self, parsed: argparse.Namespace) -> Parser:
        """Return the parser of the given command, or of its action."""
        parser: Parser = self
        for dest in ("command", "action", "deed"):
            parser = parser.actions().get(str(getattr(parsed, dest, None)), parser)
        return parser

    def _unknown_option(self, words: Sequence[str]) -> str:
        """Return the first unknown option among words, or nothing."""
        for word in words:
            name = word.partition("=")[0]
            if word == "--":
                break
            if name.startswith("--") and name not in self._option_string_actions:
                return name
        return ""

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        choices = action.choices
        if choices is None or value in choices:
            return
        if isinstance(action, argparse._SubParsersAction):
            meant = hint(_OTHER_WORDS.get(value, str(value)), choices)
            raise UsageError(
                f"there is no {(action.metavar or 'command').lower()} {value!r}"  # type: ignore[union-attr]
                f"{meant} (see {self.prog} --help)"
            )
        listed = ", ".join(map(str, choices))
        raise argparse.ArgumentError(
            action, f"{value!r} is none of {listed}{hint(str(value), map(str, choices))}"
        )


def hint(word: str, known: Iterable[str]) -> str:
    """Return "; did you mean ...?", or nothing if no known word is similar."""
    near = difflib.get_close_matches(word, list(known), n=1)
    return f"; did you mean {near[0]}?" if near else ""


def group_of(parser: argparse._ActionsContainer, title: str) -> argparse._ActionsContainer:
    """Return the group of options with a title, made where it is missing."""
    for group in getattr(parser, "_action_groups", ()):
        if group.title == title:
            return group  # type: ignore[no-any-return]
    return parser.add_argument_group(title)


def add_actions(
    parser: argparse.ArgumentParser, dest: str = "action", *, required: bool = True
) -> Callable[..., Parser]:
    """Give a command actions; return a function to add one: `add(name, help, examples, ...)`."""
    actions = parser.add_subparsers(
        title="actions", metavar=dest.upper(), required=required, dest=dest
    )

    def add(name: str, what: str, examples: str, description: str | None = None) -> Parser:
        sentence = f"{what[0].upper()}{what[1:]}."
        made = actions.add_parser(
            name, help=what, description=description or sentence, examples=examples
        )
        return cast(Parser, made)

    return add


# ---- Groups of options ---------------------------------------------------------------------------

_MANY_OPTIONS = 12  # beyond which a usage is short
OBJECTS, BRUSH, PLACE, FILES, FILM, LIGHT = (
    "the object", "brush and ink", "where", "files", "film", "light and screen",
)  # fmt: skip
_ORDER = (
    "options", "what is seen", "what is written", "the photograph", OBJECTS, PLACE, BRUSH,
    FILM, LIGHT, "the file written", FILES,
)  # fmt: skip

UNITS = ("mm", "cm", "m", "in")
UNIT_HELP = "length of one unit in the mesh file (default: as the file says, else mm)"
MATERIALS = (  # known before NumPy is
    "porcelain", "bisque", "xuan", "plaster", "terracotta", "sized xuan", "tinted xuan", "silk",
)  # fmt: skip
BUILT_IN_OBJECTS = ("bowl", "plate", "vase", "sphere", "plane")  # as `files.load`, without NumPy
BUILT_IN_HELP = (
    f"{', '.join(BUILT_IN_OBJECTS)}, or a sheet: {', '.join(FORMS)}, such as scroll, "
    "scroll:340x1000:mounted or sheet:340x1360:margin=30 (mm)"
)
_UP_AXES = ("x", "y", "z", "-x", "-y", "-z")  # as `mesh.upright`, known here before NumPy is
_MOST_SEED = 1_000_000
_MOST_HAIRS = 10_000  # as `brush.spec.MOST_HAIRS`, known here before NumPy is loaded
DIPS = "auto"  # of texts
_FINEST_MM, _COARSEST_MM = 0.005, 1e6  # that `PaintedSurface` takes, known here before NumPy is


def parse_number(text: str, what: str, expected: str, fits: Callable[[float], bool]) -> float:
    """Parse a number; refuse one that does not fit, which NaN never does."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not fits(number):
        raise argparse.ArgumentTypeError(f"{text!r} is not {what}; expected {expected}")
    return number


def parse_length_mm(text: str) -> float:
    """Parse a positive length in mm."""
    return parse_number(text, "a length", "a number above 0, mm", lambda n: 0.0 < n < math.inf)


def parse_seconds(text: str) -> float:
    """Parse a time in seconds, 0 or more."""
    return parse_number(text, "a time", "seconds, 0 or more", lambda n: 0.0 <= n < math.inf)


def parse_resolution_mm(text: str) -> float:
    """Parse a vertex spacing in mm that a surface can have."""
    resolution = parse_length_mm(text)
    if resolution < _FINEST_MM:
        raise argparse.ArgumentTypeError(f"{text} is too fine; expected at least {_FINEST_MM:g} mm")
    if resolution > _COARSEST_MM:
        raise argparse.ArgumentTypeError(
            f"{text} is too coarse; expected at most {_COARSEST_MM:g} mm"
        )
    return resolution


def parse_count(text: str) -> int:
    """Parse a count, 1 or more."""
    count = int(text) if text.isascii() and text.isdigit() and len(text) < 10 else 0
    if count < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a count; expected 1 or more")
    return count


def parse_hairs(text: str) -> int:
    """Parse a number of hairs; 0 for a solid tuft."""
    count = int(text) if text.isdecimal() and len(text) < 9 else -1
    if not 0 <= count <= _MOST_HAIRS:
        raise argparse.ArgumentTypeError(f"{text!r} hairs; expected 0 to {_MOST_HAIRS}")
    return count


def parse_turn(text: str) -> float:
    """Parse a turn, -180 to 180 degrees."""
    return parse_number(text, "a turn", "-180 to 180 degrees", lambda n: -180.0 <= n <= 180.0)


def parse_gap(text: str) -> float:
    """Parse a distance in parts of a size, 0 to 5."""
    return parse_number(text, "a distance", "0 to 5 times the size", lambda n: 0.0 <= n <= 5.0)


def parse_share(text: str) -> float:
    """Parse a fraction, above 0 to 1."""
    return parse_number(text, "a share", "above 0 to 1", lambda n: 0.0 < n <= 1.0)


def _parse_dips(text: str) -> str | int:
    """Parse when to dip: ``auto``, ``always``, or before every so many characters."""
    if text in ("auto", "always"):
        return text
    count = text.removeprefix("every").strip()
    if not (count.isascii() and count.isdigit() and len(count) < 6 and int(count) > 0):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not when to dip; expected auto, always, or a count of characters such as "
            "3 or 'every 3'"
        )
    return int(count)


def parse_variation(text: str) -> float:
    """Parse how much strokes vary, 0 to 3."""
    expected = "a number from 0, as the copybook, to 3"
    return parse_number(text, "variation", expected, lambda value: 0.0 <= value <= 3.0)


def parse_hand_speed(text: str) -> float:
    """Parse the speed of a hand relative to the usual one, 1 to 4."""
    expected = "how many times as fast as usual, 1 to 4"
    return parse_number(text, "a hand's speed", expected, lambda value: 1.0 <= value <= 4.0)


def parse_rate(text: str) -> float:
    """Parse a rate, 1/mm, 0 or more."""
    return parse_number(text, "a rate", "1/mm, 0 or more", lambda n: 0.0 <= n < math.inf)


def parse_place(text: str) -> tuple[float, float]:
    """Parse a position on the object, ``U,V``, each 0 to 1."""
    try:
        u, v = (float(part) for part in text.split(","))
    except ValueError:
        u = v = math.nan
    if not (0 <= u <= 1 and 0 <= v <= 1):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a place; expected U,V with both from 0 to 1, such as 0.5,0.5"
        )
    return u, v


SIDES = ("outside", "inside", "top", "bottom", "front", "right", "back", "left")


def add_at_option(parser: argparse._ActionsContainer, what: str) -> None:
    """Add --at, the position of the middle of a text or a seal."""
    parser.add_argument(
        "--at",
        metavar="U,V",
        type=parse_place,
        help=f"where {what} middle goes: U to the right, V upwards, both 0 to 1 "
        "(paint3d info OBJECT says in mm)",
    )


def add_side_option(parser: argparse._ActionsContainer) -> None:
    """Add --side, from which the object is looked at."""
    parser.add_argument(
        "--side",
        choices=SIDES,
        help="from where the object is looked at: on its front, right, back or left U is 0.5 in "
        "the middle (default: outside, top of what is flat)",
    )


def add_quiet_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--quiet``."""
    group_of(parser, FILES).add_argument("--quiet", action="store_true", help="print errors only")


def own_file(name: str | None) -> str | None:
    """Return a brush's or material's file; None for one that comes with the program."""
    return name if (name or "").lower().endswith((".toml", ".json")) else None


def add_force_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--force``."""
    group_of(parser, FILES).add_argument(
        "--force",
        action="store_true",
        help="write even over a file that is read from, or that the object's file refers to",
    )


def add_dip_option(parser: argparse.ArgumentParser, default: str = DIPS) -> None:
    """Add ``--dip``; `default` is the help's text of None."""
    group_of(parser, BRUSH).add_argument(
        "--dip",
        metavar="'every N'|auto|always",
        type=_parse_dips,
        help="when the brush is dipped: before every N-th character; auto: where it would run dry "
        "within the next, about every fourth; always: fully, before each of them (default: "
        f"{default})",
    )


def add_unit_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--unit``, the length of one unit in a mesh file that is read."""
    group_of(parser, OBJECTS).add_argument("--unit", choices=UNITS, help=UNIT_HELP)


def add_report_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--report``, a file with counts and times of a painting."""
    group_of(parser, FILES).add_argument(
        "--report", metavar="FILE", type=Path, help="write versions, counts and times as JSON"
    )


def add_seed_option(parser: argparse._ActionsContainer, what: str) -> None:
    """Add ``--seed``, of the random variation; None by default."""
    parser.add_argument(
        "--seed",
        metavar="N",
        type=_parse_seed,
        help=f"another number, another chance: {what} (default: 1)",
    )


def _parse_seed(text: str) -> int:
    return int(
        parse_number(
            text, "a seed", f"a whole number, 0 to {_MOST_SEED:,}",
            lambda n: 0 <= n <= _MOST_SEED and n == int(n),
        )
    )  # fmt: skip


def add_fps_option(parser: argparse._ActionsContainer) -> None:
    """Add ``--fps``, pictures a second of a film; None by default."""
    parser.add_argument(
        "--fps",
        metavar="N",
        type=lambda text: parse_number(text, "a rate", "1 to 60", lambda n: 1.0 <= n <= 60.0),
        help="pictures a second (default: 24 for an .mp4 of a painting that grows, else 12)",
    )


def add_pixels_option(parser: argparse._ActionsContainer, default: str) -> None:
    """Add ``--pixels``, the size of a picture; `default` is the help's text of None."""
    parser.add_argument(
        "--pixels",
        metavar="WxH",
        type=_parse_pixels,
        help=f"how wide and high a picture is (default: {default})",
    )


def _parse_pixels(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text.lower())
    width, height = (int(n) for n in match.groups()) if match else (0, 0)
    if not (16 <= width <= 4096 and 16 <= height <= 4096):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a size; expected WxH such as 1600x1200, each 16 to 4096"
        )
    return width, height


def add_up_option(
    parser: argparse.ArgumentParser, otherwise: str = "as the format says, else z"
) -> None:
    """Add ``--up``; `otherwise` is the help's text of its default."""
    group_of(parser, OBJECTS).add_argument(
        "--up",
        metavar="AXIS",
        choices=(*_UP_AXES, "auto"),
        help="axis of the mesh file that points up: x, y, z, or --up=-x and so on; auto: guess it "
        f"where the format does not say and it is sure (default: {otherwise})",
    )


def check_input_file(name: str | Path | None, what: str, known: Sequence[str] = ()) -> None:
    """Refuse a missing file, before anything heavy is imported to read it.

    Parameters
    ----------
    name : str or Path, optional
    what : str
        The expected kind, such as "a recording".
    known : sequence of str
        Names that are no files; where there are any, so are those of sheets.

    Raises
    ------
    InputError
        If there is no such file, it is a folder, or no sheet is of such a size.
    """
    if name is None or os.fspath(name) in known or os.path.isfile(name):
        return
    if known and is_sheet(os.fspath(name)):
        parse_sheet(os.fspath(name))
        return
    known = (*known, *FORMS) if known else known
    expected = f"{what}, or {', '.join(known)}" if known else what
    near = hint(os.fspath(name), known)
    if os.path.isdir(name):
        raise InputError("{name} is a folder; expected {expected}", name=name, expected=expected)
    if not os.path.exists(name):
        raise InputError(
            "{name}: there is no such file; expected {expected}{near}",
            name=name,
            expected=expected,
            near=near,
        )


def check_output_folder(folder: Path) -> None:
    """Refuse a folder that could not be written to.

    Raises
    ------
    ExportError
        If it (or, where it is yet to be made, its nearest parent) is not a writable folder.
    """
    nearest = folder
    while not nearest.exists() and nearest != nearest.parent:
        nearest = nearest.parent
    if not nearest.is_dir():
        raise ExportError(
            "{there} is not a folder; {folder} cannot be made",
            there=nearest,
            folder=folder,
        )
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise ExportError("{there}: no permission to write there", there=nearest)


def check_output_file(file: Path, suffixes: tuple[str, ...]) -> None:
    """Refuse, before any work, an output file that could not be written at the end.

    Raises
    ------
    ExportError
        If the suffix is unknown, the folder is missing or closed, or the path is a folder, a pipe
        or a device.
    """
    name = file.name.lower()
    if not any(name.endswith(suffix) and name != suffix for suffix in suffixes):
        raise ExportError(
            "{file}: unknown kind of file; expected a name ending in {suffixes}",
            file=file,
            suffixes=", ".join(suffixes),
        )
    if file.is_dir():
        raise ExportError("{file} is a folder; expected a file name", file=file)
    if file.exists() and not file.is_file():
        raise ExportError("{file} is a pipe or a device; expected a file name", file=file)
    if not file.parent.is_dir():
        raise ExportError("{file}: there is no folder {parent}", file=file, parent=file.parent)
    check_output_folder(file.parent)


def check_overwriting(
    written: Iterable[Path | None], read: Iterable[str | Path | None], *, force: bool
) -> None:
    """Refuse to write over an input file, or over one that an input mesh refers to.

    Nor is one file written twice.

    Parameters
    ----------
    written, read : iterable of path-like or None
        None stands for an option that was not given. What is read may also be the name of
        something else than a file.
    force : bool
        Whether what is read from may be replaced.

    Raises
    ------
    ExportError
        If a file that is written is, under whatever name, one of those, a picture, a material
        library or a buffer of one of them, or another one written.
    """
    files = [file for file in written if file is not None]
    for k, file in enumerate(files):
        for other in files[:k]:
            if _same_file(file, other):
                raise ExportError(
                    "{file} is {other}; expected a file for each of them",
                    file=file,
                    other=other,
                )
        for source in () if force else [source for source in read if source]:
            if _same_file(file, source):
                raise ExportError(
                    "{file} would be replaced, and {source} is read from it; expected another "
                    "name, or --force",
                    file=file,
                    source=source,
                )
            if _refers_to(source, file):
                raise ExportError(
                    "{file} would be replaced, and {source} refers to it; expected another name, "
                    "or --force",
                    file=file,
                    source=source,
                )


def _refers_to(source: str | Path, file: Path) -> bool:
    """Return whether an input mesh refers to a file that would be replaced."""
    if not file.exists() or not os.path.isfile(source):
        return False
    from paint3d.files.references import refers_to_apart

    return refers_to_apart(Path(source), file)


def _same_file(one: str | Path, other: str | Path) -> bool:
    """Return whether two paths name one file, also by links and if it does not exist yet."""
    try:
        return os.path.samefile(one, other)
    except FileNotFoundError:
        return os.path.realpath(one) == os.path.realpath(other)
    except (OSError, ValueError):  # one of them is no file name
        return False


# ---- Devices -------------------------------------------------------------------------------------
# Options about the hands' devices.


def add_stylus_option(parser: argparse.ArgumentParser, default: str) -> None:
    """Add ``--stylus``; None by default."""
    parser.add_argument(
        "--stylus",
        metavar="KIND",
        type=_parse_stylus,
        help="auto, hid, openhaptics (Touch, Phantom; =/PATH/libHD.so), inverse3 "
        f"(Haply; =ws://HOST:PORT) or none{default}",
    )


def _parse_stylus(text: str) -> str:
    from paint3d.haptics.stylus_choice import check_stylus

    try:
        return check_stylus(text)
    except InputError as cause:
        raise argparse.ArgumentTypeError(str(cause)) from None
