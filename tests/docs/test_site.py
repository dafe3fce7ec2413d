"""What the site makes from the code; scripts/site builds it, and finds links that lead nowhere."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

import paint3d
from paint3d.cli.main import COMMANDS, make_parser

pytest.importorskip("mkdocs", reason="mkdocs is not installed")

from tools import site_pages

ROOT = Path(__file__).parents[2]
PICTURES = sorted(path.name for path in (ROOT / "docs/gallery").iterdir())


def test_the_reference_has_every_public_name() -> None:
    page = (ROOT / "docs/reference/api.md").read_text("utf-8")
    shown = set(re.findall(r"^::: paint3d\.(\w+)$", page, re.MULTILINE))
    assert shown == set(paint3d.__all__) - {"__version__"}


def test_the_command_line_has_every_command_and_option() -> None:
    page = site_pages.commands_page()
    for name, parser in make_parser().actions().items():
        assert f"\n## paint3d {name}\n" in page
        for action in parser.option_actions()[1:]:  # after --help
            assert re.search(rf"^\| `[^`]*{action.option_strings[-1]}\b", page, re.MULTILINE)
    assert len(re.findall(r"^## ", page, re.MULTILINE)) == len(COMMANDS)


def test_the_gallery_shows_every_picture_once() -> None:
    shown = re.findall(r"^!?\[.+\]\(gallery/(.+)\)$", site_pages.gallery_page(), re.MULTILINE)
    assert sorted(shown) == PICTURES


@pytest.mark.parametrize("name", PICTURES)
def test_what_draws_a_picture_is_there(name: str) -> None:
    lines = [shlex.split(line) for line in site_pages.drawn_by(name).splitlines()]
    words = lines[-1]
    if words[0] == "paint3d":
        given = [make_parser(line[1]).parse_args(line[1:]) for line in lines]
        assert Path(name) in vars(given[-1]).values()
        return
    scripts = [word for word in words if word.startswith("scripts")]
    (script,) = scripts
    if script == "scripts/build_gallery.py":
        drawn = [
            text.read_text("utf-8").partition("\nPICTURES = ")[2]
            for text in (ROOT / "scripts/gallery").glob("*.py")
        ]
        assert sum(f'"{name}": ' in text for text in drawn) == 1
        return
    file = ROOT / script if script.endswith(".py") else ROOT / f"{script.replace('.', '/')}.py"
    asked = words[-1] if words[-1] != script else name
    assert asked.removeprefix("hand_") in file.read_text("utf-8")


@pytest.mark.parametrize(
    ("real", "here", "target", "leads_to"),
    [
        ("README.md", "index.md", "docs/ink.md", "ink.md"),
        ("README.md", "index.md", "examples", "examples/README.md"),
        ("docs/devices.md", "devices.md", "../examples/live.py", "examples/live.py"),
        ("docs/tutorial/cups.md", "tutorial/cups.md", "../sessions.md", "../sessions.md"),
        ("CHANGELOG.md", "CHANGELOG.md", "README.md", "index.md"),
    ],
)
def test_links_lead_where_they_do_in_the_repository(real, here, target, leads_to) -> None:
    assert site_pages._moved(target, real, here) == leads_to
