"""Blocks of Python in the guide run as they stand; what is an outline says so."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import paint3d
from paint3d.colour import load_ink, mixture_reflectance, srgb_from_reflectance

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
BLOCKS = [
    pytest.param(code, id=f"{page.name}-{text[: found.start()].count(chr(10)) + 1}")
    for page in sorted((ROOT / "docs").glob("*.md"))
    for text in [page.read_text("utf-8")]
    for found in BLOCK.finditer(text)
    for code in [found[1]]
]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with what the guide's blocks read: a recording, a painting, a whole painting."""
    monkeypatch.chdir(tmp_path)
    surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), resolution=1.0)
    stroke = paint3d.Painter(surface, "slender").stroke([(-20, 0, 0), (20, 0, 0)])
    paint3d.save_recording(stroke, "strokes.jsonl")
    paint3d.save_session(paint3d.Session(surface, (stroke,)), "jug.p3d")
    shutil.copy(ROOT / "examples" / "bamboo.score.jsonl", tmp_path)
    return tmp_path


@pytest.mark.usefixtures("folder", "coarse", "small_pictures")
@pytest.mark.parametrize("code", BLOCKS)
def test_a_block_of_the_guide_runs(code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = compile(code, "guide", "exec")
    if code.startswith("# outline"):
        return
    for package in re.findall(r"^import (trimesh|pyvista)$", code, re.MULTILINE):
        pytest.importorskip(package)
    if ".plot(" in code:
        monkeypatch.setattr("pyvista.OFF_SCREEN", True)
    exec(compiled, {"__name__": "guide"})


def test_the_ink_of_ones_own_is_one(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "ink.md").read_text("utf-8")
    (table,) = re.findall(r'^```csv title="mine.csv"\n(.*?)^```', page, re.MULTILINE | re.DOTALL)
    (tmp_path / "mine.csv").write_text(table)
    assert "--ink mine.csv:sea" in page
    (sea,) = load_ink(f"{tmp_path}/mine.csv:sea")
    red, green, blue = srgb_from_reflectance(mixture_reflectance({sea: 1.0}, 1.0, np.ones(31)))
    assert red < green < blue


def test_the_guide_has_blocks() -> None:
    assert len(BLOCKS) >= 9
    assert sum("# outline" in str(one.values[0]) for one in BLOCKS) <= 2
