"""docs/papers.md: every row has its test, and all that it names is there, by the program itself.

Commands and options are looked up in the command line's own parser, words of the studio in its
window (`tests/app/test_papers_in_window.py`). That the tests exercise what their rows name is read,
not computed: what can be is that a row which names a command is held by a test that runs one, and a
row that names the studio by one that opens its window.
"""

from __future__ import annotations

import argparse
import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from paint3d.bench.registry import BENCHMARKS
from paint3d.cli import main
from paint3d.cli.options import UsageError

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/papers.md").read_text("utf-8")
ROWS = {int(n): row for n, row in re.findall(r"^\| (\d+) \|(.*)\|$", PAGE, re.MULTILINE)}
CODE = re.compile(r"`([^`]+)`")
WORDS = re.compile(r"(?<!\*)\*([^*|]+)\*(?!\*)")
COMMANDS = sorted({code for code in CODE.findall(PAGE) if code.startswith("paint3d ")})
NAMED = {code for code in CODE.findall(PAGE) if code.startswith("test_")}
PAINTED = ["--on", "plane", "--out", "a.p3d"]
NEEDED = {
    "batch": ["a.csv"],
    "brushes fit": ["a.csv", "--out", "mine.toml"],
    "brushes show": ["full"],
    "devices record": ["a.jsonl"],
    "export": ["a.p3d", "a.glb"],
    "picture": ["a.p3d", "--out", "a.png"],
    "replay": ["a.jsonl", *PAINTED],
    "score": ["a.score.jsonl"],
    "study": ["table", "folder"],
    "study answer": ["folder", "P01", "--prefers", "I"],
    "study plan": ["folder"],
    "study report": ["folder", "--out", "a.html"],
    "study table": ["folder"],
    "write": ["永", *PAINTED],
}
"""What commands do not do without."""
VALUES: dict[str, list[str]] = {
    "--azimuth": ["dragged"], "--brush": ["full"], "--film": ["a.gif"], "--glyphs": ["lines"],
    "--hairs": ["300"], "--hand-speed": ["2.5"], "--illuminant": ["A"], "--list": [],
    "--material": ["xuan"],
    "--mouse-mode": ["camera"], "--on": ["bowl"], "--out": ["b.png"], "--pickup": ["0.1"],
    "--side": ["inside"], "--spread": ["20"], "--stylus": ["hid"],
    "--stylus-anticipation": ["4"], "--stylus-texture": ["0.5"], "--technique": ["pianfeng"],
    "--view": ["flat"],
}  # fmt: skip
"""A value for each option that is named."""
RUNS = re.compile(r"\bmain(\.main)?\(|\bpaint3d\(|\bplugged\(|\brun_(path|benchmark)\(")
"""What a test does that runs a command, in its own process, a child's, or under virtual devices."""
OPENS = re.compile(r"\b(window|StudioWindow|paint_thread|stage|LiveScene)\b")
"""What a test has that looks into the studio: its window, or what it paints and draws with."""


def cells(number: int) -> tuple[str, str]:
    """How a row is reached, and what holds it."""
    *_, reached, held = [cell.strip() for cell in ROWS[number].split("|")]
    return reached, held


@cache
def sources_of_tests() -> dict[str, list[str]]:
    """The source of each test that is named with what of its module it reaches, by name."""
    found: dict[str, list[str]] = {}
    for file in sorted((ROOT / "tests").rglob("test_*.py")):
        source = file.read_text("utf-8")
        nodes = dict(_named(ast.parse(source)))
        for name, node in nodes.items():
            if name in NAMED:
                found.setdefault(name, []).append(_with_helpers(node, nodes, source.split("\n")))
    return found


def _named(tree: ast.Module) -> Iterator[tuple[str, ast.stmt]]:
    """Functions, classes and constants of a module."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name, node
        elif isinstance(node, ast.Assign):
            for target in node.targets:
                if isinstance(target, ast.Name):
                    yield target.id, node


def _with_helpers(node: ast.stmt, nodes: dict[str, ast.stmt], lines: list[str]) -> str:
    """A function's source, and that of what it reaches in its file."""
    todo, seen, text = [node], {id(node)}, ""
    while todo:
        one = todo.pop()
        text += "\n".join(lines[one.lineno - 1 : one.end_lineno]) + "\n"
        used = {n.id for n in ast.walk(one) if isinstance(n, ast.Name)}
        used |= {n.arg for n in ast.walk(one) if isinstance(n, ast.arg)}
        for name in sorted(used & set(nodes)):
            if id(nodes[name]) not in seen:
                seen.add(id(nodes[name]))
                todo.append(nodes[name])
    return text


def test_there_is_a_row_for_each_of_116() -> None:
    assert list(ROWS) == list(range(1, 117))


def parsed(command: str) -> argparse.Namespace:
    """A command of the page, completed by what it needs, as the command line takes it.

    Raises
    ------
    UsageError
        If there is no such command or option.
    """
    words = command.split()[1:]
    deed = " ".join(word for word in words if not word.startswith("--"))
    asked = []
    for word in words:
        asked += [word, *VALUES.get(word, ())]
    needed = list(NEEDED.get(deed, ()))
    for option in set(words) & set(needed):
        place = needed.index(option)
        del needed[place : place + 1 + len(VALUES[option])]
    return main.make_parser().parse_args([*asked, *needed])


@pytest.mark.parametrize("command", COMMANDS)
def test_the_command_line_takes_every_command_and_option(command: str) -> None:
    options = vars(parsed(command))
    assert options["command"] == command.split()[1]
    for word in command.split():
        if word in VALUES:  # what it asked for is somewhere in what was understood
            assert all(value in str(options.values()) for value in VALUES[word])
    if command.startswith("paint3d bench "):
        assert set(options["names"]) <= set(BENCHMARKS)


@pytest.mark.parametrize("command", ["paint3d juggle", "paint3d write --juggle", "paint3d study x"])
def test_a_command_that_is_not_there_would_be_found(command: str) -> None:
    assert len(COMMANDS) > 30
    with pytest.raises(UsageError):
        parsed(command)


def test_every_test_is_there() -> None:
    assert len(NAMED) > 110
    assert NAMED - set(sources_of_tests()) == set()


@pytest.mark.parametrize("number", ROWS)
def test_a_row_is_held_by_a_test_that_does_what_it_names(number: int) -> None:
    reached, held = cells(number)
    assert reached
    names = [code for code in CODE.findall(held) if code.startswith("test_")]
    if not names:
        assert held == "-"
        assert reached.startswith("-")
        return
    assert all(name.startswith("test_") for name in CODE.findall(held))
    sources = "\n".join(source for name in names for source in sources_of_tests()[name])
    commands = {code.split()[1] for code in CODE.findall(reached) if code.startswith("paint3d ")}
    if commands - {"paint"}:
        assert RUNS.search(sources), f"{names} run no command"
    if "paint" in commands or WORDS.search(reached) or "studio" in reached:
        assert OPENS.search(sources), f"{names} open no window"


def test_every_picture_and_page_is_there() -> None:
    linked = set(re.findall(r"\]\(([^)#]+)[^)]*\)", PAGE))
    assert len(linked) > 15
    assert [name for name in sorted(linked) if not (ROOT / "docs" / name).is_file()] == []
