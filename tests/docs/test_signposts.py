"""What the documents point to is there: modules, files, pages; and every folder is named."""

from __future__ import annotations

import re
from pathlib import Path
from pkgutil import resolve_name

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "paint3d"
PAGES = [*sorted((ROOT / "docs").glob("*.md")), ROOT / "CONTRIBUTING.md", ROOT / "README.md"]
TOPS = ("paint3d", "tests", "scripts", "tools", "docs", "examples", "meshes")
ROOMS = [folder.name for folder in PACKAGE.iterdir() if (folder / "__init__.py").exists()]
FILES = [
    "/" + file.relative_to(ROOT).as_posix()
    for top in TOPS
    for file in (ROOT / top).rglob("*")
    if file.is_file() and "__pycache__" not in file.parts
]


def quoted(page: Path) -> list[str]:
    """What stands between backticks, outside blocks of code, word by word."""
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    return [word for said in re.findall(r"`([^`\n]+)`", text) for word in said.split()]


def is_module(name: str) -> bool:
    try:
        resolve_name(name)
    except (ImportError, AttributeError):
        return False
    return True


def is_path(word: str) -> bool:
    """Whether a path from the repository, or from the package without .py, leads to something."""
    places = [top / f"{word.rstrip('/')}{end}" for top in (ROOT, PACKAGE) for end in ("", ".py")]
    return any(place.exists() for place in places)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_what_a_page_names_is_there(page: Path) -> None:
    missing = []
    for word in quoted(page):
        word = word.split("::")[0].rstrip(",;:.")
        if re.fullmatch(r"paint3d(\.\w+)+", word):
            found = is_module(word) or any(file.endswith(f"/{word}") for file in FILES)
        elif re.fullmatch(r"[\w-]+(/[\w.-]+)+/?", word) and word.split("/")[0] in (*TOPS, *ROOMS):
            if (
                page.name == "sessions.md" or "/X." in word
            ):  # arrays of a file; a file to be written
                continue
            found = is_path(word)
        elif re.fullmatch(r"(\w+/)*\w+\.py", word):
            found = any(file.endswith(f"/{word}") for file in FILES)
        else:
            continue
        if not found:
            missing.append(word)
    assert missing == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_within_the_repository_leads_somewhere(page: Path) -> None:
    targets = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text("utf-8"))
    inside = [target for target in targets if "://" not in target and "mailto:" not in target]
    assert [target for target in inside if not (page.parent / target).exists()] == []


def test_the_page_of_the_architecture_names_every_folder() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    folders = {file.parent.relative_to(PACKAGE) for file in PACKAGE.rglob("__init__.py")}
    inner = [folder for folder in folders if len(folder.parts) > 1 and folder.name != "kernels"]
    assert [str(folder) for folder in sorted(inner) if f"{folder.name}/" not in text] == []
