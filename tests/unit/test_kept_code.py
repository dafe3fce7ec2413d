"""Compiled kernels whose source, or that of a kernel they call, has changed are dropped."""

import json
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from paint3d.kernels import kept_code
from paint3d.kernels.kept_code import compiled_code, drop_stale
from paint3d.stroke.engine import Painter
from paint3d.surface.painted_surface import PaintedSurface
from scripts.surface_cases import flat, poses, sheet

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


@pytest.mark.parametrize("record", [b"", b"[1]", b"\xff", b'{"leaf": 3}', b'{"leaf": [3]}'])
def test_without_a_record_everything_is_dropped(folders, record) -> None:
    sources, compiled = folders
    (compiled / "sources.json").write_bytes(record)
    drop_stale(sources, compiled)
    assert kept(compiled) == set()


def test_a_folder_that_cannot_be_written_is_left_alone(folders) -> None:
    sources, _ = folders
    drop_stale(sources, sources / "leaf.py")  # a file: nothing can be kept in it
    assert (sources / "leaf.py").read_text() == SOURCES["leaf"]


TUPLE = "class Room(NamedTuple):\n    low: int\n    high: int  # mm\n\n\ndef make():\n    pass\n"
LATER = 1_000_000  # ns


def rewrite(path: Path, text: str) -> None:
    """Write a source again, at a later time."""
    time = path.stat().st_mtime_ns + LATER
    path.write_text(text)
    os.utime(path, ns=(time, time))


@pytest.mark.parametrize("where", ["elsewhere", "leaf"])
def test_where_a_tuple_has_other_fields_all_is_dropped(folders, tmp_path, where) -> None:
    sources, compiled = folders
    outside = tmp_path / "room.py"
    outside.write_text(TUPLE)
    rewrite(sources / "leaf.py", TUPLE)
    drop_stale(sources, compiled, [outside])
    compile_all(compiled)
    changed = outside if where == "elsewhere" else sources / "leaf.py"
    rewrite(changed, TUPLE.replace("mm", "cm").replace("pass", "return 1"))
    drop_stale(sources, compiled, [outside])  # its fields are what they were
    assert kept(compiled) == (set(SOURCES) if where == "elsewhere" else {"wide", "other"})
    compile_all(compiled)
    rewrite(changed, TUPLE.replace("low", "x").replace("high", "low").replace("x", "high"))
    drop_stale(sources, compiled, [outside])
    assert kept(compiled) == set()
    compile_all(compiled)
    drop_stale(sources, compiled, [outside])
    assert kept(compiled) == set(SOURCES)


def test_a_record_of_an_older_version_is_believed(folders, tmp_path) -> None:
    sources, compiled = folders
    outside = tmp_path / "room.py"
    outside.write_text(TUPLE)
    record = compiled / "sources.json"
    old = {name: state[:2] for name, state in json.loads(record.read_text()).items()}
    record.write_text(json.dumps(old))
    drop_stale(sources, compiled, [outside])
    assert kept(compiled) == set(SOURCES)
    rewrite(outside, TUPLE.replace("low", "least"))
    drop_stale(sources, compiled, [outside])
    assert kept(compiled) == set()


PROGRAM = """
import sys
from pathlib import Path
sys.path[:0] = [{root!r}, {tree!r}]
from paint3d.kernels.kept_code import drop_stale
import made
drop_stale(Path(made.__file__).parent, Path(made.__file__).parent / "__pycache__", [made.where])
from made.leaf import low_of
from types_elsewhere import Room
print(low_of(Room(low=1.0, high=2.0)), sum(low_of.stats.cache_hits.values()))
"""


def test_code_is_compiled_anew_where_a_tuple_from_elsewhere_has_changed(tmp_path) -> None:
    """Without that a kernel would take the one field for the other."""
    (tmp_path / "made").mkdir()
    outside = tmp_path / "types_elsewhere.py"
    outside.write_text(f"from typing import NamedTuple\n\n\n{TUPLE}")
    where = f"from pathlib import Path\nwhere = Path({str(outside)!r})\n"
    (tmp_path / "made" / "__init__.py").write_text(where)
    (tmp_path / "made" / "leaf.py").write_text(
        "from numba import njit\n\n\n@njit(cache=True)\ndef low_of(room):\n    return room.low\n"
    )
    program = PROGRAM.format(root=str(Path(kept_code.__file__).parents[2]), tree=str(tmp_path))
    without = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA")}

    def said() -> str:
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=without)
        return done.stdout

    assert said() == "1.0 0\n"
    assert said() == "1.0 1\n"  # kept
    text = outside.read_text()
    rewrite(outside, text.replace("low", "x").replace("high", "low").replace("x", "high"))
    assert said() == "1.0 0\n"


def test_every_tuple_that_kernels_take_is_looked_at() -> None:
    """Told from what is compiled: all that ever ran here, at least a stroke."""
    points = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
    stroke = poses(points, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), np.array([0.2, 0.2]))
    Painter(PaintedSurface(sheet(flat, (9.0, 9.0), 5.0), 1.0)).replay(stroke)
    looked_at = json.loads((compiled_code() / "sources.json").read_text())
    seen = set()
    for path in compiled_code().glob("*.nbi"):
        with open(path, "rb") as file:
            pickle.load(file)  # numba's version
            _, compiled = pickle.loads(file.read())
        for signature, *_ in compiled:
            seen |= {kind.instance_class for kind in signature if hasattr(kind, "instance_class")}
    assert {"Room", "InkField", "SurfaceField"} <= {one.__name__ for one in seen}
    for one in seen:
        *_, package, module = one.__module__.split(".")
        name = module if package == "kernels" else f"{package}/{module}"
        assert looked_at[name][2][one.__name__] == list(one._fields)


def test_numba_keeps_kernels_where_they_are_looked_for() -> None:
    kept_code._kernel()
    assert list(compiled_code().glob("kept_code._kernel-*.nbi"))
    assert (compiled_code() / "sources.json").is_file()
