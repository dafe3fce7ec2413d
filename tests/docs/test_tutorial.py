"""Every walk of docs/tutorial runs in an empty folder, block after block; an outline says so."""

from __future__ import annotations

import re
import runpy
import shlex
from pathlib import Path

import pytest

from paint3d.calligraphy.kanjivg import find_kanjivg
from paint3d.cli.main import main, make_parser

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial"
BLOCK = re.compile(r'^```(\w+)(?: title="([\w.]+)")?\n(.*?)^```', re.MULTILINE | re.DOTALL)
LONG = {"cups", "hands", "recording", "scroll"}  # a quarter of a minute of processor time and more

pytestmark = [
    pytest.mark.skipif(find_kanjivg() is None, reason="kanjivg is not installed"),
    pytest.mark.timeout(1800),
]


def blocks(walk: str) -> list[tuple[str, str, str]]:
    """Language, name of the file that it is saved as, and text of every block."""
    return BLOCK.findall((TUTORIAL / f"{walk}.md").read_text("utf-8"))


def run(line: str) -> None:
    """One line of a shell."""
    program, *words = shlex.split(line, comments=True)
    if program == "python":
        runpy.run_path(words[0])
        return
    assert program == "paint3d", line
    chosen = make_parser(words[0]).parse_args(words)
    assert main([*words, "--quiet"] if hasattr(chosen, "quiet") else words) == 0, line
    for name in ("out", "file", "recording", "film"):
        written = getattr(chosen, name, None)
        if isinstance(written, Path) and written.is_file():
            assert written.stat().st_size > 0, line


@pytest.mark.parametrize(
    "walk",
    [
        pytest.param(one.stem, marks=pytest.mark.long if one.stem in LONG else ())
        for one in sorted(TUTORIAL.glob("*.md"))
    ],
)
@pytest.mark.usefixtures("coarse", "small_pictures")
def test_a_walk_runs_in_an_empty_folder(
    walk: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PAINT3D_CONFIG", str(tmp_path / "settings"))
    names: dict[str, object] = {"__name__": walk}
    for language, title, text in blocks(walk):
        if text.startswith("# outline"):
            continue
        if title:
            Path(title).write_text(text, "utf-8")
        elif language == "python":
            exec(compile(text, walk, "exec"), names)
        else:
            assert language == "sh", language
            for line in text.splitlines():
                run(line)


@pytest.mark.parametrize("walk", ["scroll", "recording", "cups", "python", "hands"])
def test_little_of_a_walk_is_an_outline(walk: str) -> None:
    typed = [text for language, _, text in blocks(walk) if language in ("sh", "python")]
    assert sum(not text.startswith("# outline") for text in typed) >= 3
