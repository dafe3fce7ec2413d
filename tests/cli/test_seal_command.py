"""`paint3d seal`: onto an object, onto a painting, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from paint3d.app.model.document import Document
from paint3d.cli import main
from tests.support.app.hands import paint, small_plane

SVG = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0H20V10H0Z"/></svg>'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bar.svg").write_text(SVG, encoding="utf-8")
    return tmp_path


@pytest.fixture
def painting(folder: Path) -> str:
    document = Document.new(small_plane().surface.source, 0.6, "xuan")
    paint(document, (-15, 0), (15, 0))
    document.save(folder / "painting.p3d")
    return "painting.p3d"


def run(*arguments: object) -> int:
    return main.main(["seal", *map(str, arguments)])


def test_a_seal_on_a_painting_is_a_step_on_a_layer_of_its_own(painting: str, capsys) -> None:
    pytest.importorskip("svgelements")
    done = run("--svg", "bar.svg", "--on", painting, "--size", 12, "--layer", "seal",
               "--at", "0.5,0.5", "--rotate", 90, "--out", "sealed.p3d")  # fmt: skip
    told = capsys.readouterr()
    assert done == 0
    assert "12.0 x 6.6 mm" in told.out
    assert "% of it lies over what was painted before" in told.err
    beside = ("--svg", "bar.svg", "--on", painting, "--size", 12, "--at", "0.5,0.9")
    assert run(*beside, "--out", "beside.p3d") == 0
    assert "lies over" not in capsys.readouterr().err  # though its red is new to the painting
    before, after = Document.open(painting), Document.open("sealed.p3d")
    assert [layer.name for layer in after.layers] == ["1", "seal"]
    assert after.steps.done[-1] == "seal"
    share = after.surface.layer_arrays()["seal: share"]
    reach = np.abs(after.surface.mesh.vertices[share > 0.5]).max(axis=0)
    assert reach[1] > reach[0] > 3.0  # turned
    after.undo()
    n = before.surface.n_vertices
    off = after.surface.srgb[:n].astype(int) - before.surface.srgb
    assert np.abs(off).max() <= 1  # the layer that is empty again takes part in the sum


def test_a_seal_on_a_bare_object(folder: Path, capsys) -> None:
    assert run("印", "--on", "plane", "--style", "baiwen", "--out", "a.ply") == 0
    assert "印, baiwen, 16.0 x 16.0 mm" in capsys.readouterr().out
    assert (folder / "a.ply").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--on", "plane"), "got nothing to cut"),
        (("印", "--svg", "bar.svg", "--on", "plane"), "got a text and --svg"),
        (("印", "--on", "painting.p3d", "--material", "xuan"), "a painting with its own"),
        (("印", "--on", "plane", "--ink", "mud"), "unknown ink 'mud'"),
        (("印", "--on", "plane", "--size", "2"), "size (mm) is 2"),
        (("印", "--on", "plane", "--pad", "0"), "'0' is not a pad"),
        (("永和九年春", "--on", "plane"), "5 characters"),
        (("印", "--on", "plane", "--at", "0,0"), "has no room there"),
        (("印", "--on", "plane", "--ids", "a"), "--ids is given without a drawing"),
    ],
)
def test_bad_input_is_one_line(painting: str, folder: Path, capsys, arguments, words: str) -> None:
    assert run(*arguments, "--out", "out.ply", "--quiet") == 2
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 1
    assert told[0].startswith("paint3d: error: ")
    assert words in told[0]
    assert not (folder / "out.ply").exists()


TABLE = "name," + ",".join(f"R_{nm}" for nm in range(400, 701, 10))
TABLE += "\nred lead," + ",".join("0.05" if nm < 580 else "0.8" for nm in range(400, 701, 10))


@pytest.mark.parametrize(("ink", "names"), [
    ("my.csv:red lead", ["red lead"]), ("carmine:1,my.csv:red lead:1", ["carmine", "red lead"]),
])  # fmt: skip
def test_the_paste_may_be_any_ink(ink: str, names: list[str], folder: Path, painting: str) -> None:
    (folder / "my.csv").write_text(TABLE, encoding="utf-8")
    assert run("印", "--on", painting, "--size", 12, "--ink", ink, "--out", "sealed.p3d") == 0
    (folder / "my.csv").unlink()
    document = Document.open("sealed.p3d")
    assert [p.name for p in document.surface.pigments if p.name in names] == names
    pressed = document.surface.srgb.copy()
    document.undo()
    document.redo()
    assert np.array_equal(document.surface.srgb, pressed)


@pytest.mark.parametrize("seed", ["-1", "1.5", "1000001", "nan", "x"])
def test_a_seed_that_is_none_is_named(seed: str, folder: Path, capsys) -> None:
    assert run("印", "--on", "plane", f"--seed={seed}", "--out", "a.ply") == 2
    assert "is not a seed; expected a whole number, 0 to 1,000,000" in capsys.readouterr().err


def test_a_seal_is_turned_anticlockwise(folder: Path) -> None:
    pytest.importorskip("svgelements")
    head = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0H20V8H12V20H8V8H0Z"/></svg>'
    (folder / "t.svg").write_text(head, encoding="utf-8")
    middles = {}
    for turn in (0, 90):
        assert run("--svg", "t.svg", "--on", "plane", "--at", "0.5,0.5", "--rotate", turn,
                   "--resolution", "0.4", "--out", f"{turn}.p3d", "--quiet") == 0  # fmt: skip
        surface = Document.open(f"{turn}.p3d").surface
        share = surface.painted_coverage()
        x, y, _ = surface.mesh.vertices.T @ share / share.sum()
        middles[turn] = (x - surface.mesh.vertices[:, 0].mean(), y)
    xs, ys = zip(*middles.values(), strict=True)
    assert ys[0] > ys[1] + 0.5  # the bar of the T is above, and then it is on the left
    assert xs[1] < xs[0] - 0.5
