"""What README.md and docs/commands.md print runs, in order, in a folder with the small inputs."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest

from paint3d.calligraphy.kanjivg import find_kanjivg
from paint3d.cli.main import main, make_parser
from tests.support.examples import ALL

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
INPUTS = ("logo.svg", "mug.csv", "orders.csv", "bamboo.score.jsonl")
BY_HAND = {"paint", "devices", "bench", "study"}  # a window, hardware, or minutes: parsed alone
FEW = 3  # characters of a text, but with --long
NEEDS = {"Anna": "uharfbuzz", "--svg": "svgelements", "copy": "skimage", "compose": "svgelements",
         "--illuminant": "colour", "--compare": "colour"}  # fmt: skip

pytestmark = pytest.mark.skipif(find_kanjivg() is None, reason="kanjivg is not installed")


def blocks(page: str, language: str) -> list[str]:
    text = (ROOT / page).read_text("utf-8")
    return [code for kind, code in BLOCK.findall(text) if kind == language]


def lines(page: str) -> list[list[str]]:
    found = [line for code in blocks(page, "sh") for line in code.splitlines()]
    return [shlex.split(line, comments=True)[1:] for line in found if line.startswith("paint3d ")]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name in INPUTS:
        shutil.copy(ROOT / "examples" / name, tmp_path)
    return tmp_path


def run(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    for words in lines(page):
        chosen = make_parser(words[0]).parse_args(words)
        if words[0] in BY_HAND or "--film" in words:
            continue
        for word, package in NEEDS.items():
            if word in words:
                pytest.importorskip(package)
        if words[0] == "write" and not ALL:  # each character is planned for a second
            words[1] = words[1][:FEW]
        assert main(words) == 0, (words, capsys.readouterr().err)
        for name in ("out", "file", "recording"):
            written = getattr(chosen, name, None)
            if isinstance(written, Path):
                assert written.stat().st_size > 0, words


@pytest.mark.timeout(1800)
@pytest.mark.usefixtures("coarse", "small_pictures")
def test_the_readme_runs_in_an_empty_folder(folder: Path, capsys, monkeypatch) -> None:
    assert len(lines("README.md")) > 6
    run("README.md", capsys)
    (code,) = blocks("README.md", "python")
    exec(compile(code, "README.md", "exec"), {})
    for name in ("poem.glb", "vase.glb", "signed.html", "signed.3mf", "one.glb", "two.glb"):
        assert (folder / name).stat().st_size > 1000


@pytest.mark.long  # three minutes of processor time
@pytest.mark.timeout(3600)
@pytest.mark.usefixtures("folder")
def test_the_page_of_commands_runs(capsys) -> None:
    assert len(lines("docs/commands.md")) > 25
    run("docs/commands.md", capsys)


def test_every_link_of_the_readme_leads_somewhere() -> None:
    for page in (ROOT / "README.md", ROOT / "docs" / "commands.md"):
        for link in re.findall(r"\]\(([^)#:]+)[^)]*\)", page.read_text("utf-8")):
            assert (page.parent / link).exists(), link
