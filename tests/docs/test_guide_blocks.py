"""Blocks of Python in the guide run as they stand; what is an outline says so."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import paint3d
from paint3d.colour import load_ink, mixture_reflectance, srgb_from_reflectance
from paint3d.errors import ExportError
from paint3d.page import folder as page_folder

ROOT = Path(__file__).parents[2]
SECTION = re.compile(r"^## (.*)\n", re.MULTILINE)
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
SECTIONS = [
    pytest.param(blocks, id=f"{page.name}-{heading}".replace(" ", "_"))
    for page in sorted((ROOT / "docs").glob("*.md"))
    for parts in [["", *SECTION.split(page.read_text("utf-8"))]]
    for heading, text in zip(parts[0::2], parts[1::2], strict=True)
    if (blocks := BLOCK.findall(text))
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
@pytest.mark.parametrize("blocks", SECTIONS)
def test_the_blocks_of_a_section_run_in_order(
    blocks: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    names = {"__name__": "guide"}
    for code in blocks:
        compiled = compile(code, "guide", "exec")
        if code.startswith(("# outline", "editor.")):
            continue  # an outline, or what is done with strokes painted by hand in a cell
        for package in re.findall(r"^import (trimesh|pyvista)$", code, re.MULTILINE):
            pytest.importorskip(package)
        if ".edit(" in code:
            pytest.importorskip("anywidget")
            try:
                page_folder.check_built(page_folder.BUILT, page_folder.KERNELS)
            except ExportError as missing:
                pytest.skip(str(missing))
        if ".plot(" in code:
            monkeypatch.setattr("pyvista.OFF_SCREEN", True)
        exec(compiled, names)


def test_the_ink_of_ones_own_is_one(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "ink.md").read_text("utf-8")
    (table,) = re.findall(r'^```csv title="mine.csv"\n(.*?)^```', page, re.MULTILINE | re.DOTALL)
    (tmp_path / "mine.csv").write_text(table)
    assert "--ink mine.csv:sea" in page
    (sea,) = load_ink(f"{tmp_path}/mine.csv:sea")
    red, green, blue = srgb_from_reflectance(mixture_reflectance({sea: 1.0}, 1.0, np.ones(31)))
    assert red < green < blue


def test_the_guide_has_blocks() -> None:
    blocks = [code for section in SECTIONS for code in section.values[0]]
    assert len(blocks) >= 9
    assert sum("# outline" in code for code in blocks) <= 2
