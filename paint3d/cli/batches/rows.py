"""A row of a batch: its command line, and running it in this process."""

from __future__ import annotations

import hashlib
import json
import logging
import os
import time
import unicodedata
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from paint3d.cli.options import BUILT_IN_OBJECTS, Parser, UsageError, own_file
from paint3d.cli.painting import keep_bare_surfaces
from paint3d.cli.report import find_versions
from paint3d.colour.ink_text import tables_in, with_tables
from paint3d.errors import Paint3DError
from paint3d.mesh.sheets import is_sheet

__all__ = ["Outcome", "Row", "command_parser", "fingerprint", "run_row", "without_lacking"]

_INKS = ("--ink", "--tip")
_PARAMETERS = ("--brush", "--material")
COMMANDS = ("write", "replay")  # of a row that is a painting by itself


class Row(NamedTuple):
    """A row that can be run: `arguments` is what one would type after ``paint3d``."""

    line: int
    output: str
    arguments: tuple[str, ...]


class Outcome(NamedTuple):
    """The outcome of a row: an empty message is success."""

    line: int
    message: str
    seconds: float
    version: str


def command_parser(command: str) -> Parser:
    """Return the parser of a command that rows ask for, or pieces of one."""
    parser = Parser(prog=f"paint3d {command}")
    _module(command).add_arguments(parser)
    return parser


def _module(command: str) -> ModuleType:
    return import_module(f"paint3d.cli.{command}")


def placed(row: Row, folder: str) -> Row:
    """Return the row with its relative paths joined to a folder, wherever it is run."""
    command, *words = row.arguments
    if command == "compose":
        joined = [_placed_word(command, word, folder) for word in words]
        return row._replace(arguments=(command, *joined))
    *options, subject = words
    joined = [_placed_word(command, word, folder) for word in options]
    if command == "replay":
        subject = os.path.join(folder, subject)
    return row._replace(arguments=(command, *joined, subject))


@cache
def _file_options(command: str) -> frozenset[str]:
    """Return the options of a command that name files."""
    return frozenset(
        option
        for action in command_parser(command).option_actions()
        for option in action.option_strings
        if action.type is Path
    )


def _placed_word(command: str, word: str, folder: str) -> str:
    """Return an option with the file that it names, if any, joined to a folder."""
    option, equals, value = word.partition("=")
    if option in _file_options(command):
        value = os.path.join(folder, value)
    elif option == "--on":
        path = os.path.join(folder, value)
        known = value in BUILT_IN_OBJECTS or is_sheet(value)
        if not known or os.path.isfile(path):
            value = path
    elif option == "--font":  # a file, or a name that the system knows
        path = os.path.join(folder, value)
        value = path if os.path.isfile(path) else value
    elif option in _INKS:
        value = with_tables(value, partial(os.path.join, folder))
    elif option in _PARAMETERS and own_file(value) is not None:
        value = os.path.join(folder, value)
    elif option == "--piece":
        piece = json.loads(value)
        of = "seal" if "seal" in piece else "write"
        for name, cell in piece.items():
            piece[name] = _placed_word(of, f"--{name}={cell}", folder).partition("=")[2]
        value = json.dumps(piece, ensure_ascii=False)
    return option + equals + value


def run_row(row: Row) -> Outcome:
    """Run a row to its end in this process; errors are returned, never raised."""
    started = time.perf_counter()
    try:
        command, *arguments = row.arguments
        keep_bare_surfaces()
        with _named_notes(row):
            _module(command).run(command_parser(command).parse_args(arguments))
        message = ""
    except (UsageError, Paint3DError) as cause:
        message = str(cause)
    except MemoryError:
        message = "out of memory"
    except OSError as cause:
        message = f"{cause.filename or row.output}: {cause.strerror or cause}"
    except Exception as cause:  # a fault of ours costs its row, not the batch
        message = f"unexpected {type(cause).__name__}: {cause}"
    seconds = time.perf_counter() - started
    return Outcome(row.line, " ".join(message.split()), seconds, find_versions()["paint3d"])


def without_lacking(rows: Sequence[Row], folder: str) -> tuple[list[Row], list[Outcome]]:
    """Return the rows whose fonts have all their characters, and refusals of the others."""
    complete, refused = list[Row](), list[Outcome]()
    for row in rows:
        try:
            _check_fonts(placed(row, folder))
        except (UsageError, Paint3DError) as cause:
            refused.append(Outcome(row.line, str(cause), 0.0, ""))
        else:
            complete.append(row)
    return complete, refused


def _check_fonts(row: Row) -> None:
    """Refuse a row that asks for a font which lacks characters of its text, or cannot be read."""
    command, *words = row.arguments
    pieces = [json.loads(word.partition("=")[2]) for word in words if word.startswith("--piece=")]
    if command == "write":
        asked = command_parser(command).parse_args(words)
        pieces = [{"font": asked.font, "text": asked.text}]
    for piece in pieces:
        if piece.get("font") and piece.get("text"):
            from paint3d.calligraphy.fonts.font_file import open_font

            open_font(piece["font"]).check_has(unicodedata.normalize("NFC", piece["text"]))


@contextmanager
def _named_notes(row: Row) -> Iterator[None]:
    """Prefix notes with their row, unless notes are off."""
    log = logging.getLogger("paint3d")
    before = log.handlers[:]
    if before and all(isinstance(one, logging.NullHandler) for one in before):
        yield
        return
    handler = logging.StreamHandler()
    where = f"line {row.line}, {row.output}".replace("%", "%%")
    handler.setFormatter(logging.Formatter(f"paint3d: note: {where}: %(message)s"))
    log.handlers = [handler]
    try:
        yield
    finally:
        log.handlers = before


def _read(arguments: tuple[str, ...]) -> Iterator[str]:
    """Yield values and words that may be file names, the tables of own inks among them."""
    for word in arguments:
        option, _, value = word.partition("=")
        if option in _INKS:
            yield from tables_in(value)
        if option == "--piece":
            piece = json.loads(value)
            yield from _read(tuple(f"--{name}={cell}" for name, cell in piece.items()))
            continue
        yield value if word.startswith("--") else word


def fingerprint(row: Row, folder: str | None = None) -> str:
    """Return what a row's result depends on: its words, the files it names, and the version.

    Relative paths start from `folder`, by default the working one. Files are distinguished by their
    size and the time of their last change.
    """
    folder = os.getcwd() if folder is None else folder
    files = []
    for word in _read(row.arguments):
        path = Path(folder, word)
        try:
            if word not in ("", row.output) and path.exists():
                status = path.stat()
                files.append((word, status.st_size, status.st_mtime_ns))
        except (OSError, ValueError):
            continue  # a text is seldom a file name
    what = [row.arguments, files, find_versions()["paint3d"], folder]
    return hashlib.sha256(json.dumps(what).encode()).hexdigest()
