"""One row of a batch: what one would type for it, and running that wherever there is a core."""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

from paint3d.cli import replay, write
from paint3d.cli.options import Parser, UsageError, own_file
from paint3d.cli.report import find_versions
from paint3d.colour.ink_text import tables_in, with_tables
from paint3d.errors import Paint3DError

__all__ = ["Outcome", "Row", "command_parser", "fingerprint", "run_row"]

_INKS = ("--ink", "--tip")
_PARAMETERS = ("--brush", "--material")
COMMANDS = {"write": write, "replay": replay}


class Row(NamedTuple):
    """A row that can be run: `arguments` is what one would type after ``paint3d``."""

    line: int
    output: str
    arguments: tuple[str, ...]


class Outcome(NamedTuple):
    """How a row went: an empty message is success."""

    line: int
    message: str
    seconds: float
    version: str


def command_parser(command: str) -> Parser:
    """Return the parser of ``write`` or ``replay``."""
    parser = Parser(prog=f"paint3d {command}")
    COMMANDS[command].add_arguments(parser)
    return parser


def placed(row: Row, folder: str) -> Row:
    """The row with the files that it names counted from a folder, wherever it is run."""
    from paint3d.files.load import BUILT_IN_OBJECTS

    command, *options, subject = row.arguments
    of_files = {
        option
        for action in command_parser(command)._actions
        for option in action.option_strings
        if action.type is Path
    }
    words = []
    for word in options:
        option, equals, value = word.partition("=")
        if option in of_files:
            value = os.path.join(folder, value)
        elif option == "--on":
            there = os.path.join(folder, value)
            if value not in BUILT_IN_OBJECTS or os.path.isfile(there):
                value = there
        elif option in _INKS:
            value = with_tables(value, partial(os.path.join, folder))
        elif option in _PARAMETERS and own_file(value) is not None:
            value = os.path.join(folder, value)
        words.append(option + equals + value)
    if command == "replay":
        subject = os.path.join(folder, subject)
    return row._replace(arguments=(command, *words, subject))


def run_row(row: Row) -> Outcome:
    """Run a row to its end, here and now; whatever goes wrong is told, never raised."""
    started = time.perf_counter()
    try:
        command, *arguments = row.arguments
        COMMANDS[command].run(command_parser(command).parse_args(arguments))
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


def _read(arguments: tuple[str, ...]) -> Iterator[str]:
    """Values and words that may be names of files, those of own inks' tables among them."""
    for word in arguments:
        option, _, value = word.partition("=")
        if option in _INKS:
            yield from tables_in(value)
        yield value if word.startswith("--") else word


def fingerprint(row: Row, folder: str | None = None) -> str:
    """Return what a row's result depends on: its words, the files it names, and the version.

    Files are counted from `folder`, by default the working one.
    Files are told apart by their size and the time of their last change.
    """
    folder = os.getcwd() if folder is None else folder
    files = []
    for word in _read(row.arguments):
        path = Path(folder, word)
        try:
            if word not in ("", row.output) and path.exists():
                known = path.stat()
                files.append((word, known.st_size, known.st_mtime_ns))
        except (OSError, ValueError):
            continue  # a text is seldom a file name
    what = [row.arguments, files, find_versions()["paint3d"], folder]
    return hashlib.sha256(json.dumps(what).encode()).hexdigest()
