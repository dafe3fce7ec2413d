"""Every example runs as it stands, and leaves what it says."""

from __future__ import annotations

import json
import runpy
import sys
from pathlib import Path

import pytest

from paint3d.files.load import load_mesh

EXAMPLES = Path(__file__).parents[2] / "examples"
LEAVES = {
    "paint": ["bowl.glb", "yong.jsonl.gz"],
    "live": ["live.png", "live.p3d"],
    "write": ["vase.ply", "vase.p3d"],
    "replay": ["bowl.p3d.txt"],
    "own_brush": ["brushes.glb"],
    "own_ink": ["inks.glb"],
    "layers": ["seal_hidden.glb", "seal_shown.glb"],
    "wet": ["wash.p3d"],
    "batch": ["one.ply", "two.ply"],
    "devices": [],
    "custom_export": ["cloud.xyz"],
}


@pytest.mark.usefixtures("coarse", "few_lights")
@pytest.mark.parametrize("name", LEAVES)
def test_an_example_runs(name, tmp_path, monkeypatch, capfd) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(EXAMPLES))
    monkeypatch.setattr(sys, "argv", [f"{name}.py", str(tmp_path)])
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    for file in LEAVES[name]:
        assert (tmp_path / file).stat().st_size > 1000
        if file.endswith((".glb", ".ply")):
            colours = load_mesh(tmp_path / file).colours
            assert len({tuple(code) for code in colours.tolist()}) > 10
    assert capfd.readouterr().out.strip()  # it says what it did


def test_the_guide_names_every_example() -> None:
    told = (EXAMPLES / "README.md").read_text("utf-8")
    scripts = {path.stem for path in EXAMPLES.glob("*.py") if not path.stem.startswith("_")}
    assert scripts == set(LEAVES)
    assert all(f"`{name}.py`" in told for name in scripts)
    assert "`notebook.ipynb`" in told


def test_the_notebook_runs(monkeypatch) -> None:
    matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    matplotlib.use("Agg")
    cells = json.loads((EXAMPLES / "notebook.ipynb").read_text("utf-8"))["cells"]
    names: dict[str, object] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    lengths = names["lengths"]
    assert lengths == sorted(lengths)  # a harder press leaves a longer footprint
