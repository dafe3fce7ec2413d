"""docs/papers.md: every row, and all that it names, is there."""

import ast
import contextlib
import json
import re
from pathlib import Path

import pytest

from paint3d.bench.registry import BENCHMARKS
from paint3d.cli import main

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/papers.md").read_text("utf-8")
ROWS = re.findall(r"^\| (\d+) \|(.*)\|$", PAGE, re.MULTILINE)
CODE = re.compile(r"`([^`]+)`")


def help_of(words: list[str], capsys: pytest.CaptureFixture[str]) -> str | None:
    """What a command says of itself; None if there is none."""
    with contextlib.suppress(SystemExit):
        main.main([*words, "--help"])
    told = capsys.readouterr().out
    return told if told.startswith(f"usage: paint3d {' '.join(words)} ") else None


def test_there_is_a_row_for_each_of_116() -> None:
    assert [int(number) for number, _ in ROWS] == list(range(1, 117))


def test_every_command_is_there(capsys: pytest.CaptureFixture[str]) -> None:
    named = sorted({code for code in CODE.findall(PAGE) if code.startswith("paint3d ")})
    assert len(named) > 20
    for command in named:
        words = [word for word in command.split()[1:] if not word.startswith("--")]
        benchmark = words.pop() if words[0] == "bench" and len(words) > 1 else None
        assert benchmark is None or benchmark in BENCHMARKS
        told = help_of(words, capsys)
        assert told is not None, f"{command}: no such command"
        known = set(re.findall(r"--[a-z][a-z-]*", told))
        assert {word for word in command.split() if word.startswith("--")} <= known, command


def test_every_test_is_there() -> None:
    named = {code for code in CODE.findall(PAGE) if code.startswith("test_")}
    assert len(named) > 70
    there = {
        node.name
        for file in (ROOT / "tests").rglob("test_*.py")
        for node in ast.walk(ast.parse(file.read_text("utf-8")))
        if isinstance(node, ast.FunctionDef)
    }
    assert named - there == set()


@pytest.mark.parametrize("number", [int(number) for number, _ in ROWS])
def test_a_row_has_a_test_or_says_that_something_is_missing(number: int) -> None:
    *_, reached, held = [cell.strip() for cell in dict(ROWS)[str(number)].split("|")]
    assert reached
    assert CODE.search(held) or (held == "-" and reached.startswith("-"))


def test_words_of_the_studio_are_its_own() -> None:
    texts = json.loads((ROOT / "paint3d/app/model/data/texts.json").read_text("utf-8"))
    tree = ast.parse((ROOT / "paint3d/app/window/commands.py").read_text("utf-8"))
    known = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}
    for told in texts.values():
        known |= set(told.values()) if isinstance(told, dict) else {told}
        known |= set(told) if isinstance(told, list) else set()
    named = {words for _, row in ROWS for words in re.findall(r"(?<!\*)\*([^*|]+)\*(?!\*)", row)}
    assert len(named) > 8
    assert named - known == set()


def test_every_picture_and_page_is_there() -> None:
    linked = set(re.findall(r"\]\(([^)#]+)[^)]*\)", PAGE))
    assert len(linked) > 15
    assert [name for name in sorted(linked) if not (ROOT / "docs" / name).is_file()] == []
