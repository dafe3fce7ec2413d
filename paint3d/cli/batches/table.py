"""A table of paintings, one a row: which columns it may have, and what each row asks for."""

from __future__ import annotations

import csv
import difflib
import io
from pathlib import Path

from paint3d.cli.batches.rows import COMMANDS, Outcome, Row, command_parser
from paint3d.errors import InputError

__all__ = ["read_table"]

OWN = {"object": "--on", "output": "--out"}  # other columns are named as the options are
SUBJECTS = {"text": "write", "recording": "replay"}
NOT_COLUMNS = {"help", "quiet", "on", "out"}
MAX_BYTES = 1 << 26
YES, NO = ("yes", "true", "1", "x"), ("no", "false", "0", "")


def read_table(path: Path) -> tuple[list[Row], list[Outcome]]:
    """Return the rows that can be run, and the refusals of those that cannot.

    A row says in `text` what to write or in `recording` what to replay, in `object` on what, and
    in `output` the file to make. Any other column is an option of those commands, without its
    dashes; an empty cell leaves it out, and options without a value take yes or no.

    Raises
    ------
    InputError
        If the file is no table, or a column is not known.
    """
    text = _text(path)
    delimiter = max(",;\t", key=text.partition("\n")[0].count)  # as recordings' tables have them
    records = csv.reader(io.StringIO(text), strict=True, delimiter=delimiter)
    try:
        header = [name.strip().lower().removeprefix("--") for name in next(records, [])]
        _check_header(path, header)
        rows, refused, lines = list[Row](), list[Outcome](), dict[str, int]()
        for cells in records:
            line = records.line_num
            if not any(cell.strip() for cell in cells):
                continue
            try:
                row = _row(header, cells, line)
                if row.output in lines:
                    raise InputError(f"{row.output} is the output of line {lines[row.output]} too")
                lines[row.output] = line
                rows.append(row)
            except InputError as cause:
                refused.append(Outcome(line, str(cause), 0.0, ""))
    except csv.Error as cause:
        raise InputError(f"{path}:{records.line_num}: it is no CSV table: {cause}") from None
    if not rows and not refused:
        raise InputError(f"{path}: it has no rows; expected one for each painting")
    return rows, refused


def _text(path: Path) -> str:
    try:
        with open(path, "rb") as file:
            data = file.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise InputError(f"{path}: it is larger than {MAX_BYTES:,} bytes")
        return data.decode("utf-8-sig")
    except OSError as cause:
        raise InputError(f"{path}: cannot read it: {cause.strerror or cause}") from None
    except UnicodeDecodeError as cause:
        raise InputError(f"{path}: byte {cause.start} is not UTF-8; expected UTF-8 text") from None


def _check_header(path: Path, header: list[str]) -> None:
    options = {name for command in COMMANDS for name in _options(command)}
    known = {*OWN, *SUBJECTS, *options}
    for name in header:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]!r}? " if near else ""
            raise InputError(
                f"{path}:1: unknown column {name!r}: {hint}expected {', '.join(sorted(known))}"
            )
    if len(set(header)) < len(header):
        raise InputError(f"{path}:1: two columns have the same name")
    missing = [name for name in OWN if name not in header]
    if missing or not set(SUBJECTS) & set(header):
        missing = missing or [" or ".join(SUBJECTS)]
        raise InputError(f"{path}:1: there is no column {missing[0]}")


def _options(command: str) -> dict[str, bool]:
    """Return a command's options by column name, and whether each takes a value."""
    found = {}
    for action in command_parser(command)._actions:
        for option in action.option_strings:
            found[option.lstrip("-")] = action.nargs != 0
    found = {name: takes for name, takes in found.items() if len(name) > 1}
    return {name: takes for name, takes in found.items() if name not in {*NOT_COLUMNS, *SUBJECTS}}


def _row(header: list[str], cells: list[str], line: int) -> Row:
    if len(cells) != len(header):
        raise InputError(f"it has {len(cells)} cells; expected {len(header)}")
    given = {k: v for k, v in zip(header, cells, strict=True) if v.strip()}
    subjects = [name for name in SUBJECTS if name in given]
    if len(subjects) != 1:
        raise InputError("it has both a text and a recording" if subjects else
                         "it has neither a text nor a recording")  # fmt: skip
    for name in OWN:
        if name not in given:
            raise InputError(f"it has no {name}")
    command = SUBJECTS[subjects[0]]
    takes_value = dict.fromkeys(OWN, True) | _options(command)
    words = []
    for name, value in given.items():
        if name == subjects[0]:
            continue
        if name not in takes_value and value.strip().lower() in NO:
            continue
        if name not in takes_value:
            raise InputError(f"{name} is no option of {command}")
        words += _words(name, value.strip(), takes_value[name])
    if command == "write" and "processes" not in given:
        words.append("--processes=1")  # the rows share the cores
    words += ["--quiet", "--", given[subjects[0]]]
    return Row(line, given["output"].strip(), (command, *words))


def _words(name: str, value: str, takes_value: bool) -> list[str]:
    option = OWN.get(name, f"--{name}")
    if takes_value:
        return [f"{option}={value}"]
    if value.lower() not in YES + NO:
        raise InputError(f"{name} is {value!r}; expected yes or no")
    return [option] if value.lower() in YES else []
