"""Compiled kernels whose source, or that of a kernel they call, has changed are dropped."""

from __future__ import annotations

import dataclasses
import gc
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from paint3d.brush.presets import load_brush
from paint3d.core import compile_cache
from paint3d.core.compile_cache import compiled_folder, drop_stale, is_kept
from paint3d.core.kernel import uncounted
from paint3d.core.quaternion import compiled_turn
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.surface_cases import flat, poses, sheet
from tools.kernels.table import read_table, resolve

SOURCES = {
    "mesh/kernels/leaf": "import numpy as np\n",
    "core/branch": "from paint3d.mesh.kernels.leaf import a\n",
    "brush_engine/tree": "from paint3d.core import stamp\nfrom paint3d.core import branch as b\n",
    "brush_engine/wide": "from paint3d.core.other import (\n    x,\n    y,\n)  # fmt: skip\n",
    "core/many": "from paint3d.mesh.kernels.leaf import a\n"
    "from paint3d.brush_engine import (\n    tall,\n    wide,\n)\n",
    "core/other": "# from paint3d.mesh.kernels.leaf import a\n",
}
PACKAGE = Path(compile_cache.__file__).parents[1]


class Tree:
    """A package of sources, and compiled kernels of each folder elsewhere."""

    def __init__(self, root: Path) -> None:
        self.package, self.compiled = root / "package", root / "cache"
        for name, text in SOURCES.items():
            path = self.source(name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        self.drop_stale()
        self.compile_all()

    def source(self, name: str) -> Path:
        return self.package / f"{name}.py"

    def compiled_folder(self, sources: Path) -> Path:
        return self.compiled / sources.relative_to(self.package)

    def drop_stale(self) -> None:
        drop_stale(self.package, self.compiled_folder)

    def compile_all(self) -> None:
        for name in SOURCES:
            folder, _, module = name.rpartition("/")
            compiled = self.compiled_folder(self.package / folder)
            compiled.mkdir(parents=True, exist_ok=True)
            for suffix in ("nbi", "1.nbc"):
                (compiled / f"{module}.run-7.py311.{suffix}").write_bytes(b"code")

    def kept(self) -> set[str]:
        index, code = (
            {
                f"{path.parent.relative_to(self.compiled).as_posix()}/{path.name.partition('.')[0]}"
                for path in self.compiled.rglob(suffix)
            }
            for suffix in ("*.nbi", "*.nbc")
        )
        assert index == code
        return index


@pytest.fixture
def tree(tmp_path: Path) -> Tree:
    return Tree(tmp_path)


def test_nothing_is_dropped_while_nothing_changes(tree) -> None:
    tree.drop_stale()
    assert tree.kept() == set(SOURCES)
    others = [path.name for path in tree.compiled.rglob("*.*") if ".nb" not in path.name]
    assert others == ["sources.json"]


@pytest.mark.parametrize(
    ("changed", "stay"),
    [
        ("mesh/kernels/leaf", {"brush_engine/wide", "core/other"}),
        ("core/branch", set(SOURCES) - {"core/branch", "brush_engine/tree"}),
        ("core/other", {"mesh/kernels/leaf", "core/branch", "brush_engine/tree"}),
        ("brush_engine/tree", set(SOURCES) - {"brush_engine/tree"}),
    ],
)
def test_what_calls_the_changed_is_dropped_with_it(tree, changed, stay) -> None:
    rewrite(tree.source(changed), SOURCES[changed])
    tree.drop_stale()
    assert tree.kept() == stay
    tree.compile_all()
    tree.drop_stale()
    assert tree.kept() == set(SOURCES)


def test_a_source_that_has_gone_counts_as_changed(tree) -> None:
    tree.source("mesh/kernels/leaf").unlink()
    tree.drop_stale()
    assert tree.kept() == {"brush_engine/wide", "core/other"}


def test_a_folder_of_which_only_the_compiled_code_is_left_is_passed_over(tmp_path) -> None:
    tree = Tree(tmp_path)
    for folder in {tree.source(name).parent for name in SOURCES}:
        (folder / "__init__.py").touch()
    drop_stale(tree.package)
    record = compiled_folder(tree.package / "core") / "sources.json"
    assert "mesh/kernels/leaf" in json.loads(record.read_text())
    gone = tree.source("mesh/kernels/leaf").parent
    (gone / "__pycache__").mkdir(exist_ok=True)
    for source in gone.glob("*.py"):  # as git does where a module moves
        source.unlink()
    drop_stale(tree.package)
    assert "mesh/kernels/leaf" not in json.loads(record.read_text())


@pytest.mark.parametrize(
    "record", [b"", b"[1]", b"\xff", b'{"core/other": 3}', b'{"core/other": [3, 4]}']
)
def test_without_a_record_everything_is_dropped(tree, record) -> None:
    (tree.compiled / "core" / "sources.json").write_bytes(record)
    tree.drop_stale()
    assert tree.kept() == set()


def test_a_folder_that_cannot_be_written_is_left_alone(tree) -> None:
    nowhere = tree.source("mesh/kernels/leaf")  # a file: nothing can be kept in it
    drop_stale(tree.package, lambda sources: nowhere)
    assert nowhere.read_text() == SOURCES["mesh/kernels/leaf"]


TUPLE = "class Room(NamedTuple):\n    low: int\n    high: int  # mm\n\n\ndef make():\n    pass\n"
LATER = 1_000_000  # ns


def rewrite(path: Path, text: str) -> None:
    """Write a source again, at a later time."""
    time = path.stat().st_mtime_ns + LATER
    path.write_text(text)
    os.utime(path, ns=(time, time))


def test_where_a_tuple_has_other_fields_all_is_dropped(tree) -> None:
    changed = tree.source("mesh/kernels/leaf")
    rewrite(changed, TUPLE)
    tree.drop_stale()
    tree.compile_all()
    rewrite(changed, TUPLE.replace("mm", "cm").replace("pass", "return 1"))
    tree.drop_stale()  # its fields are what they were
    assert tree.kept() == {"brush_engine/wide", "core/other"}
    tree.compile_all()
    rewrite(changed, TUPLE.replace("low", "x").replace("high", "low").replace("x", "high"))
    tree.drop_stale()
    assert tree.kept() == set()
    tree.compile_all()
    tree.drop_stale()
    assert tree.kept() == set(SOURCES)


PROGRAM = """
import sys
from pathlib import Path
sys.path[:0] = [{root!r}, {tree!r}]
from paint3d.core.compile_cache import drop_stale
drop_stale(Path({tree!r}) / "made")
from made.brush_engine.leaf import low_of
from made.core.types import Room
print(low_of(Room(low=1.0, high=2.0)), sum(low_of.stats.cache_hits.values()))
"""


def test_code_is_compiled_anew_where_a_tuple_of_another_folder_has_changed(tmp_path) -> None:
    """Without that a kernel would take the one field for the other."""
    for folder in ("made/core", "made/brush_engine"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "__init__.py").touch()
    types = tmp_path / "made" / "core" / "types.py"
    types.write_text(f"from typing import NamedTuple\n\n\n{TUPLE}")
    (tmp_path / "made" / "brush_engine" / "leaf.py").write_text(
        "from numba import njit\n\n\n@njit(cache=True)\ndef low_of(room):\n    return room.low\n"
    )
    program = PROGRAM.format(root=str(PACKAGE.parent), tree=str(tmp_path))
    without = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA")}

    def said() -> str:
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=without)
        return done.stdout

    assert said() == "1.0 0\n"
    assert said() == "1.0 1\n"  # kept
    text = types.read_text()
    rewrite(types, text.replace("low", "x").replace("high", "low").replace("x", "high"))
    assert said() == "1.0 0\n"


def test_every_kernel_and_every_tuple_that_one_takes_is_looked_at() -> None:
    compiled_turn(np.array([1.0, 0.0, 0.0, 0.0]), 1.0, 0.0, 0.0)
    record = compiled_folder(PACKAGE / "core") / "sources.json"
    looked_at = json.loads(record.read_text())
    for path in PACKAGE.rglob("*.py"):
        if "@kernel" in path.read_text():
            assert path.relative_to(PACKAGE).with_suffix("").as_posix() in looked_at
    taken = {of for entry in read_table().entries for of in entry.named_tuples}
    assert {"brush_engine.scratch.Scratch", "mesh.kernels.mesh_arrays.SurfaceField"} <= taken
    for of in taken:
        module, _, name = of.rpartition(".")
        assert looked_at[module.replace(".", "/")][2][name] == list(resolve(of)._fields)


def test_numba_keeps_kernels_where_they_are_looked_for() -> None:
    compiled_turn(np.array([1.0, 0.0, 0.0, 0.0]), 1.0, 0.0, 0.0)
    assert is_kept(compiled_turn)
    assert list(compiled_folder(PACKAGE / "core").glob("quaternion.compiled_turn-*.nbi"))


# -- kernels that count no references ----------------------------------------------------------


class Room(NamedTuple):
    """Some arrays."""

    low: NDArray
    high: NDArray


def sum_of(room, n):
    """A kernel of a named tuple."""
    total = 0.0
    for k in range(n):
        total += room.low[k] * room.high[k]
    return total


def test_no_reference_is_counted() -> None:
    room = Room(np.ones(4), np.full(4, 2.0))
    found = []
    for compiled in (njit(sum_of), uncounted(cache=False)(sum_of)):
        assert compiled(room, 3) == 6.0
        (code,) = compiled.inspect_asm().values()
        found.append("NRT_incref" in code or "NRT_decref" in code)
    assert found == [True, False]


@pytest.mark.parametrize("hairs", [0, 200])
@pytest.mark.parametrize("inputs", [{}, {"spread": {"pressure": ((0.0, 1.0), (1.0, 1.5))}}])
def test_painting_leaves_arrays_held_as_often_as_before(inputs: dict, hairs: int) -> None:
    share = np.linspace(0.0, 1.0, 30)
    points = np.column_stack([40.0 * share - 20.0, 0.0 * share, 0.0 * share])
    press = 0.5 * np.sin(np.pi * share)
    recording = poses(points, (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), press, "full", rate=125.0)
    surface = PaintedSurface(sheet(flat, (40.0, 20.0), 5.0), 0.6)
    painter = Painter(surface, dataclasses.replace(load_brush("full"), inputs=inputs), hairs=hairs)
    painter.replay(recording)  # whatever grows has grown
    scratch = painter.scratch
    held = [
        *painter.tuft,
        *painter.curves,
        *scratch,
        *scratch.patch,
        *scratch.query,
        *scratch.block,
    ]
    held += [*scratch.found, *surface.contact_tree, *surface.paint_mesh.arrays, *surface.ink]
    if painter.hairs is not None:
        work = painter.hairs.work(surface)
        held += [*work, *work.bristles, *work.imprint]
    held = [array for array in held if isinstance(array, np.ndarray)]
    gc.collect()  # what earlier tests left may hold the tables of a brush
    before = [sys.getrefcount(array) for array in held]
    for _ in range(3):
        painter.replay(recording)
    after = [sys.getrefcount(array) for array in held]
    assert after == before
    assert painter.report()["footprints"] > 100
