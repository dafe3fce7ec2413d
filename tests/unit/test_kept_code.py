"""Compiled kernels whose source, or that of a kernel they call, has changed are dropped."""

import os
from pathlib import Path

import pytest

from paint3d.kernels import kept_code
from paint3d.kernels.kept_code import compiled_code, drop_stale

SOURCES = {
    "leaf": "import numpy as np\n",
    "branch": "from paint3d.kernels.leaf import a\n",
    "tree": "from paint3d.kernels import stamp as st\nfrom paint3d.kernels import branch as b\n",
    "wide": "from paint3d.kernels.other import (\n    x,\n    y,\n)  # fmt: skip\n",
    "many": "from paint3d.kernels import (\n    leaf,\n    other,\n)\n",
    "other": "# from paint3d.kernels.leaf import a\n",
}


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    """Sources, and a compiled kernel of each."""
    sources, compiled = tmp_path / "kernels", tmp_path / "cache" / "kernels_0"
    sources.mkdir()
    for name, text in SOURCES.items():
        (sources / f"{name}.py").write_text(text)
    drop_stale(sources, compiled)
    compile_all(compiled)
    return sources, compiled


def compile_all(compiled: Path) -> None:
    for name in SOURCES:
        for suffix in ("nbi", "1.nbc"):
            (compiled / f"{name}.run-7.py311.{suffix}").write_bytes(b"code")


def kept(compiled: Path) -> set[str]:
    assert all(len(list(compiled.glob(f"{p.name[:-4]}*"))) == 2 for p in compiled.glob("*.nbi"))
    return {path.name.partition(".")[0] for path in compiled.glob("*.nb[ic]")}


def test_nothing_is_dropped_while_nothing_changes(folders) -> None:
    sources, compiled = folders
    drop_stale(sources, compiled)
    assert kept(compiled) == set(SOURCES)
    assert [path.name for path in compiled.iterdir() if ".nb" not in path.name] == ["sources.json"]


@pytest.mark.parametrize(
    ("changed", "stay"),
    [
        ("leaf", {"wide", "other"}),
        ("branch", {"leaf", "wide", "many", "other"}),
        ("other", {"leaf", "branch", "tree"}),
        ("tree", set(SOURCES) - {"tree"}),
    ],
)
def test_what_calls_the_changed_is_dropped_with_it(folders, changed, stay) -> None:
    sources, compiled = folders
    path = sources / f"{changed}.py"
    time = path.stat().st_mtime_ns + 1_000_000
    os.utime(path, ns=(time, time))
    drop_stale(sources, compiled)
    assert kept(compiled) == stay
    compile_all(compiled)
    drop_stale(sources, compiled)
    assert kept(compiled) == set(SOURCES)


def test_a_source_that_has_gone_counts_as_changed(folders) -> None:
    sources, compiled = folders
    (sources / "leaf.py").unlink()
    drop_stale(sources, compiled)
    assert kept(compiled) == {"wide", "other"}


@pytest.mark.parametrize("record", [b"", b"[1]", b"\xff", b'{"leaf": 3}'])
def test_without_a_record_everything_is_dropped(folders, record) -> None:
    sources, compiled = folders
    (compiled / "sources.json").write_bytes(record)
    drop_stale(sources, compiled)
    assert kept(compiled) == set()


def test_a_folder_that_cannot_be_written_is_left_alone(folders) -> None:
    sources, _ = folders
    drop_stale(sources, sources / "leaf.py")  # a file: nothing can be kept in it
    assert (sources / "leaf.py").read_text() == SOURCES["leaf"]


def test_numba_keeps_kernels_where_they_are_looked_for() -> None:
    kept_code._kernel()
    assert list(compiled_code().glob("kept_code._kernel-*.nbi"))
    assert (compiled_code() / "sources.json").is_file()
