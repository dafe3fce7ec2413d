"""Tables of paintings, and of pieces of one: their columns, and what each row asks for."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cache, partial
from pathlib import Path

from paint3d.cli.batches.rows import COMMANDS, Outcome, Row, command_parser
from paint3d.cli.options import hint
from paint3d.errors import InputError

__all__ = [
    "PIECES",
    "check_columns",
    "option_words",
    "piece_columns",
    "read_cells",
    "read_table",
]

OWN = {"object": "--on", "output": "--out"}  # other columns are named as the options are
SUBJECTS = {"text": "write", "recording": "replay"}
PIECES = ("text", "svg", "strokes", "seal")
OF_OBJECTS = ("material", "resolution", "unit", "up", "from-points", "texture")
_FLAGS = ("from-points", "texture")
NOT_COLUMNS = {"help", "quiet", "on", "out"}
NOT_OF_PIECES = {
    *NOT_COLUMNS, *OF_OBJECTS, "force", "recording", "report", "save-strokes", "film", "fps",
    "speed", "turn", "view", "pixels", "zoom", "light", "rehearsals",
}  # fmt: skip
MAX_BYTES = 1 << 26
YES, NO = ("yes", "true", "1", "x"), ("no", "false", "0", "")


def read_cells(path: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Read the header of a CSV table, and its rows with the line that each ends in.

    Raises
    ------
    InputError
        If the file is no table.
    """
    text = _text(path)
    delimiter = max(",;\t", key=text.partition("\n")[0].count)  # as recordings' tables have them
    records = csv.reader(io.StringIO(text), strict=True, delimiter=delimiter)
    try:
        header = [name.strip().lower().removeprefix("--") for name in next(records, [])]
        rows = [
            (records.line_num, cells) for cells in records if any(cell.strip() for cell in cells)
        ]
    except csv.Error as cause:
        raise InputError(
            "{file}:{line_num}: it is no CSV table: {cause}",
            file=path,
            line_num=records.line_num,
            cause=cause,
        ) from None
    return header, rows


def read_table(path: Path, group: str | None = None) -> tuple[list[Row], list[Outcome]]:
    """Return the rows that can be run, and the refusals of those that cannot.

    A row says in `text` what to write or in `recording` what to replay, in `object` on what, and
    in `output` the file to make. Any other column is an option of those commands, without its
    dashes; an empty cell leaves it out, and options without a value take yes or no.

    Parameters
    ----------
    path : Path
    group : str, optional
        A column: rows with the same cell in it are pieces of one painting, as `paint3d compose`
        takes them; what one of them says of the object goes for all.

    Raises
    ------
    InputError
        If the file is no table, or a column is not known.
    """
    header, records = read_cells(path)
    if group is not None:
        check_columns(f"{path}:1", header, {*OWN, group, *OF_OBJECTS, *piece_columns()})
        _check_has(path, header, (*OWN, group), PIECES)
        makers: Iterator[tuple[int, Callable[[], Row]]] = _grouped(header, records, group)
    else:
        options = {name for command in COMMANDS for name in _options(command)}
        check_columns(f"{path}:1", header, {*OWN, *SUBJECTS, *options})
        _check_has(path, header, tuple(OWN), tuple(SUBJECTS))
        makers = ((line, partial(_row, header, cells, line)) for line, cells in records)
    rows, refused, lines = list[Row](), list[Outcome](), dict[str, int]()
    for line, make in makers:
        try:
            row = make()
            if row.output in lines:
                raise InputError(
                    "{output} is the output of line {lines} too",
                    output=row.output,
                    lines=lines[row.output],
                )
            lines[row.output] = line
            rows.append(row)
        except InputError as cause:
            refused.append(Outcome(line, str(cause), 0.0, ""))
    if not rows and not refused:
        raise InputError("{file}: it has no rows; expected one for each painting", file=path)
    return rows, refused


def _text(path: Path) -> str:
    try:
        with open(path, "rb") as file:
            data = file.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise InputError("{file}: it is larger than {most:,} bytes", file=path, most=MAX_BYTES)
        return data.decode("utf-8-sig")
    except OSError as cause:
        raise InputError("{file}: cannot read it: {cause}", file=path, cause=cause) from None
    except UnicodeDecodeError as cause:
        raise InputError(
            "{file}: byte {start} is not UTF-8; expected UTF-8 text",
            file=path,
            start=cause.start,
        ) from None


_COLUMN_OF = {"on": "object", "out": "output"}  # by what other commands call it


def check_columns(where: str, header: list[str], known: Collection[str]) -> None:
    """Refuse columns that are not known, or of one name.

    Raises
    ------
    InputError
        Which one, with what it may have been meant to be.
    """
    for name in header:
        if name not in known:
            near = hint(_COLUMN_OF.get(name, name), known)
            raise InputError(
                "{where}: unknown column {name!r}{near}; expected {known}",
                where=where,
                name=name,
                near=near,
                known=", ".join(sorted(known)),
            )
    if len(set(header)) < len(header):
        raise InputError("{where}: two columns have the same name", where=where)


def _check_has(
    path: Path, header: list[str], needed: tuple[str, ...], one_of: tuple[str, ...]
) -> None:
    """Refuse a table without a column that each row needs."""
    missing = [name for name in needed if name not in header]
    if not set(one_of) & set(header):
        missing.append(" or ".join(one_of))
    if missing:
        raise InputError("{file}:1: there is no column {first}", file=path, first=missing[0])


@cache
def _all_options(command: str) -> dict[str, bool]:
    """Return a command's options by name, and whether each takes a value."""
    return {
        option.removeprefix("--"): action.nargs != 0
        for action in command_parser(command).option_actions()
        for option in action.option_strings
        if option.startswith("--")
    }


def _options(command: str) -> dict[str, bool]:
    """Return the options that may be columns of a table of paintings."""
    left_out = {*NOT_COLUMNS, *SUBJECTS}
    return {name: takes for name, takes in _all_options(command).items() if name not in left_out}


def piece_columns() -> set[str]:
    """Return the columns that a table of pieces may have."""
    options = {*_all_options("write"), *_all_options("seal")} - NOT_OF_PIECES
    return {*PIECES, *options}


def option_words(command: str, cells: Mapping[str, str]) -> list[str]:
    """Return cells, by column, as the options of a command that one would type.

    Raises
    ------
    InputError
        If the command has no such option.
    """
    takes_value = _all_options(command)
    words = []
    for name, value in cells.items():
        if name in takes_value:
            words += _words(f"--{name}", value.strip(), takes_value[name])
        elif value.strip().lower() not in NO:
            raise InputError("{name} is no option of {command}", name=name, command=command)
    return words


def _grouped(
    header: list[str], records: list[tuple[int, list[str]]], group: str
) -> Iterator[tuple[int, Callable[[], Row]]]:
    """Yield the first line of each group, and a function that makes its row."""
    groups: dict[str, list[tuple[int, list[str]]]] = {}
    column = header.index(group)
    for line, cells in records:
        key = cells[column].strip() if len(cells) > column else ""
        groups.setdefault(key, []).append((line, cells))
    for pieces in groups.values():
        yield pieces[0][0], partial(_compose_row, header, pieces, group)


def _compose_row(header: list[str], pieces: list[tuple[int, list[str]]], group: str) -> Row:
    """Return the row of a painting of several pieces."""
    shared: dict[str, str] = {}
    words = []
    own = (*OWN, *OF_OBJECTS)
    for line, cells in pieces:
        if len(cells) != len(header):
            raise InputError(
                "line {line} has {n} cells; expected {header}",
                line=line,
                n=len(cells),
                header=len(header),
            )
        given = {k: v for k, v in zip(header, cells, strict=True) if v.strip()}
        for name in own:
            said = given[name].strip() if name in given else None
            if said is not None and shared.setdefault(name, said) != said:
                raise InputError(
                    "line {line} says {said!r} as {name}, and another of {group} {other!r} "
                    "{shared!r}; expected one",
                    line=line,
                    said=said,
                    name=name,
                    group=group,
                    other=given.get(group, ""),
                    shared=shared[name],
                )
        left_out = {*own, *({group} - piece_columns())}
        piece = {k: v for k, v in given.items() if k not in left_out}
        words.append("--piece=" + json.dumps(piece, ensure_ascii=False))
    for name in OWN:
        if name not in shared:
            raise InputError("it has no {name}", name=name)
    of_object = [
        word
        for name, value in shared.items()
        for word in _words(OWN.get(name, f"--{name}"), value, name not in _FLAGS)
    ]
    return Row(pieces[0][0], shared["output"], ("compose", *of_object, *words, "--quiet"))


def _row(header: list[str], cells: list[str], line: int) -> Row:
    if len(cells) != len(header):
        raise InputError("it has {n} cells; expected {header}", n=len(cells), header=len(header))
    given = {k: v for k, v in zip(header, cells, strict=True) if v.strip()}
    subjects = [name for name in SUBJECTS if name in given]
    if len(subjects) != 1:
        raise InputError("it has both a text and a recording" if subjects else
                         "it has neither a text nor a recording")  # fmt: skip
    for name in OWN:
        if name not in given:
            raise InputError("it has no {name}", name=name)
    command = SUBJECTS[subjects[0]]
    takes_value = dict.fromkeys(OWN, True) | _options(command)
    words = []
    for name, value in given.items():
        if name == subjects[0]:
            continue
        if name not in takes_value and value.strip().lower() in NO:
            continue
        if name not in takes_value:
            raise InputError("{name} is no option of {command}", name=name, command=command)
        words += _words(OWN.get(name, f"--{name}"), value.strip(), takes_value[name])
    if command == "write" and "processes" not in given:
        words.append("--processes=1")  # the rows share the cores
    words += ["--quiet", "--", given[subjects[0]]]
    return Row(line, given["output"].strip(), (command, *words))


def _words(option: str, value: str, takes_value: bool) -> list[str]:
    if takes_value:
        return [f"{option}={value}"]
    if value.lower() not in YES + NO:
        raise InputError(
            "{option} is {value!r}; expected yes or no",
            option=option.lstrip("-"),
            value=value,
        )
    return [option] if value.lower() in YES else []
