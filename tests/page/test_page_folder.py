"""The folder of the page: what is in it, and what is said where it cannot be written."""

from __future__ import annotations

import gzip
import hashlib
import json
import math
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import paint3d
from paint3d.brush.presets import SMALLEST_PRESET_EM
from paint3d.cli.main import main
from paint3d.errors import ExportError, InputError, UnknownNameError
from paint3d.page.bundle import write_bundle
from paint3d.page.copybook import SCALED, hands_for
from paint3d.page.folder import KERNELS, PageObject, build_page
from tests.support.web_page import decoded_bundle

SOURCE = Path(paint3d.__file__).parent / "mesh" / "kernels" / "bvh.py"
SMALL = [PageObject("sheet:40x30", 2.0)]


@pytest.fixture(scope="module")
def kernels(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that looks like that of compiled kernels; no page would run by them."""
    folder = tmp_path_factory.mktemp("kernels")
    code = {
        "symbol": "paint3d_a_0", "takes": "([L1{A1d)", "gives": "n", "n_takes": 5, "n_gives": 0,
        "expected": {"x": "f4[:]", "records": "a.KIND[:]", "far": "f8"},
        "records": [
            {"names": ["p", "q"], "formats": ["<f8", ["<f8", [3]]], "offsets": [0, 8],
             "itemsize": 32},
        ],
    }  # fmt: skip
    kernel = {"sources": [], "codes": [code]}
    source = ["paint3d/mesh/kernels/bvh.py", hashlib.sha256(SOURCE.read_bytes()).hexdigest()]
    index = {"format": 2, "code": {"wasm32": "k.wasm"}, "kernels": {"paint3d.a": kernel},
             "sources": [source]}  # fmt: skip
    (folder / "index.json").write_text(json.dumps(index))
    (folder / "k.wasm").write_bytes(b"\0asm")
    return folder


@pytest.fixture(scope="module")
def folder(kernels: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("page") / "made" / "here"
    build_page(out, SMALL, ["xiaokai"], ["pine soot", "light"], page=None, kernels=kernels)
    return out


def test_what_there_is_can_be_chosen_by_its_names_in_both_languages(folder: Path) -> None:
    contents = json.loads((folder / "contents.json").read_text("utf-8"))
    (sheet,), (brush,) = contents["objects"], contents["brushes"]
    assert (sheet["name"], sheet["resolution"], sheet["material"]) == ("sheet:40x30", 2.0, "xuan")
    assert (brush["name"], brush["chinese"]) == ("xiaokai", "小楷")
    assert contents["inks"][1]["parts"] == {"pine soot": 0.09, "water": 0.91}
    for file in (sheet["file"], brush["file"], contents["materials"][0]["file"]):
        assert re.fullmatch(r"[\w/.-]+", file)
        assert (folder / file).is_file()


def test_the_page_knows_how_each_kernel_is_called(folder: Path) -> None:
    index = json.loads((folder / "kernels.json").read_text("utf-8"))
    assert (folder / "kernels.wasm").read_bytes() == b"\0asm"
    (code,) = index["kernels"]["paint3d.a"]
    assert code["expected"] == {"x": "f4[:]", "records": "a.KIND[:]", "far": "f8"}
    fields = {"p": {"offset": 0, "count": 1}, "q": {"offset": 8, "count": 3}}
    assert index["records"] == {"a.KIND": {"itemsize": 32, "fields": fields}}


def test_the_same_page_is_the_same_files(kernels: Path, folder: Path, tmp_path: Path) -> None:
    build_page(tmp_path, SMALL, ["xiaokai"], ["pine soot", "light"], page=None, kernels=kernels)
    files = {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
    assert files == {p.relative_to(tmp_path) for p in tmp_path.rglob("*") if p.is_file()}
    for file in files:
        assert (tmp_path / file).read_bytes() == (folder / file).read_bytes(), file


def test_what_an_earlier_page_left_is_taken_away(kernels: Path, tmp_path: Path) -> None:
    page = tmp_path / "page"
    (page / "assets").mkdir(parents=True)
    (page / "index.html").write_text("<p>")
    (page / "assets" / "index-new.js").write_text("new")
    out = tmp_path / "out"
    (out / "assets").mkdir(parents=True)
    (out / "assets" / "index-old.js").write_text("old")
    (out / "mine.txt").write_text("mine")
    build_page(out, SMALL, ["xiaokai"], ["pine soot"], page=page, kernels=kernels)
    assert [path.name for path in (out / "assets").iterdir()] == ["index-new.js"]
    assert (out / "mine.txt").read_text() == "mine"


@pytest.mark.parametrize("kind", ["f4", "f8", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "b1"])
def test_arrays_come_back_to_the_bit(kind: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    smooth = np.cumsum(rng.normal(size=(7, 11, 3)), axis=1)
    array = (100.0 * smooth).astype(kind)
    rough = rng.integers(0, 256, (5, array.dtype.itemsize), np.uint8).view(array.dtype)
    given = {"smooth": array, "rough": rough if kind != "b1" else rough[:, 0] > 3,
             "empty": array[:0], "again": array}  # fmt: skip
    write_bundle(tmp_path / "a.bin.gz", {"a": [1.5, "永"]}, given)
    words, arrays = decoded_bundle(tmp_path / "a.bin.gz")
    assert words == {"a": [1.5, "永"]}
    for name, row in given.items():
        assert arrays[name].shape == row.shape
        assert arrays[name].tobytes() == row.tobytes(), name


def test_smooth_tables_are_packed_small(tmp_path: Path) -> None:
    x = np.linspace(0.0, 1.0, 40_000).reshape(40, 100, 10)
    table = np.sin(3.0 * x).astype(np.float32)
    write_bundle(tmp_path / "a.bin.gz", {}, {"table": table, "same": table.copy()})
    assert (tmp_path / "a.bin.gz").stat().st_size < 0.6 * len(gzip.compress(table.tobytes()))


@pytest.mark.parametrize(
    ("words", "error", "said"),
    [
        ({"objects": [PageObject("bowl of mine", 1.0)]}, Exception, "bowl of mine"),
        ({"brushes": ["xiaokay"]}, UnknownNameError, "xiaokai"),
        ({"inks": ["pine sot"]}, UnknownNameError, "pine soot"),
        ({"inks": ["azurite"]}, InputError, "the grains of azurite are visible"),
    ],
)
def test_what_a_page_cannot_have_is_said_before_anything_is_written(
    words: dict[str, Any], error: type[Exception], said: str, kernels: Path, tmp_path: Path
) -> None:
    asked = {"objects": SMALL, "brushes": ["xiaokai"], "inks": ["pine soot"]} | words
    with pytest.raises(error, match=said):
        build_page(tmp_path / "out", **asked, page=None, kernels=kernels)
    assert not (tmp_path / "out").exists()


def test_what_is_to_be_built_first_is_said(kernels: Path, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="kernels of the page are not compiled") as lacking:
        build_page(tmp_path / "out", page=None, kernels=tmp_path)
    assert "./scripts/page" in str(lacking.value)
    with pytest.raises(ExportError, match="the page is not built") as lacking:
        build_page(tmp_path / "out", page=tmp_path, kernels=kernels)
    assert "npm run build" in str(lacking.value)
    assert not (tmp_path / "out").exists()


def test_kernels_of_other_sources_are_not_shipped(kernels: Path, tmp_path: Path) -> None:
    old = shutil.copytree(kernels, tmp_path / "old")
    index = json.loads((old / "index.json").read_text())
    index["sources"][0][1] = "0" * 64
    (old / "index.json").write_text(json.dumps(index))
    with pytest.raises(ExportError, match="are out of date") as stale:
        build_page(tmp_path / "out", page=None, kernels=old)
    assert "mesh/kernels/bvh.py has changed since" in str(stale.value)
    assert "./scripts/page" in str(stale.value)
    assert not (tmp_path / "out").exists()


def test_a_file_where_a_folder_is_needed_is_said_in_a_line(kernels: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "objects").write_text("a file")
    with pytest.raises(ExportError, match="out: cannot write the page: ") as cannot:
        build_page(out, SMALL, ["xiaokai"], ["pine soot"], page=None, kernels=kernels)
    assert len(str(cannot.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["build", "FILE"], "is not a folder"),
        (["build", "out", "--resolution", "0.001"], "expected at least 0.005 mm"),
        (["build", "out", "--copybook", "永☃"], "☃"),
        (["serve", "."], "holds no page; expected what paint3d page build has written"),
        (["serve", ".", "--port", "http"], "'http' is not a port; expected a whole number"),
    ],
)
def test_a_command_that_cannot_be_done_says_so_in_a_line(
    words: list[str], said: str, tmp_path: Path, monkeypatch, capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "FILE").write_text("a file")
    try:
        status: Any = main(["page", *words])
    except SystemExit as ended:
        status = ended.code
    assert status == 2
    assert said in capsys.readouterr().err.splitlines()[-1]
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(not (KERNELS / "index.json").is_file(), reason="no kernels for a page")
@pytest.mark.parametrize(
    "seals", [("--seals", "一"), pytest.param((), id="every", marks=pytest.mark.long)]
)
def test_the_command_writes_what_a_page_needs(seals, tmp_path: Path, monkeypatch, capsys) -> None:
    page = tmp_path / "page"
    page.mkdir()
    (page / "index.html").write_text("<p>")
    monkeypatch.setattr("paint3d.page.folder.BUILT", page)
    out = tmp_path / "studio"
    words = ["--on", "sheet:40x30", "--resolution", "1", "--brush", "xiaokai", "--ink", "light",
             "--copybook", "一"]  # fmt: skip
    assert main(["page", "build", str(out), *words, *seals]) == 0
    assert f"wrote {out}, " in capsys.readouterr().out
    assert (out / "index.html").read_text() == "<p>"
    contents = json.loads((out / "contents.json").read_text("utf-8"))
    hands, (sheet,) = contents["copybook"]["hands"], contents["objects"]
    em_mm = sheet["texts"][0]["text"]["em_mm"]
    assert [(hand["em_mm"], hand["characters"]) for hand in hands] == [(em_mm, "一"), (40.0, "一")]
    assert all((out / hand["file"]).is_file() for hand in hands)
    assert (out / "kernels.wasm").read_bytes()[:4] == b"\0asm"
    shutil.rmtree(out)


@given(st.lists(st.integers(math.ceil(10 * SMALLEST_PRESET_EM), 3000), min_size=1, max_size=5))
def test_all_sizes_that_are_wanted_are_written(tenths: list[int]) -> None:
    """A hand is planned for each that it can be scaled to, by as much as the page scales."""
    wanted = [(mm / 10, chr(ord("a") + k) + " \u3000\n") for k, mm in enumerate(tenths)]
    hands = hands_for(wanted, ["full", "xiaokai"])
    assert not any(one.isspace() for hand in hands for one in hand.characters)
    for em_mm, text in wanted:
        (hand,) = [hand for hand in hands if text[0] in hand.characters]
        assert 1 / SCALED <= em_mm / hand.em_mm <= SCALED
