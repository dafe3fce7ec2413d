"""The table of what is compiled ahead: all that Python calls, as it is now."""

from __future__ import annotations

import ast
import functools
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from paint3d.core.numba_kernels import ONLY
from tools.kernels.checking import checked_table
from tools.kernels.sources import sources_of
from tools.kernels.table import Array, Number, Row, TableError, read_table

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "paint3d"
DECORATORS = {"kernel", "uncounted"}
ONLY_MEASURED = "paint3d.bench."  # what only benchmarks call, numba compiles for them


def _decorators(tree: ast.Module) -> set[str]:
    """The names of a module that decorate kernels."""
    made = {
        target.id
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)
        for target in node.targets
        if isinstance(target, ast.Name) and getattr(node.value.func, "id", "") in DECORATORS
    }
    return DECORATORS | made


def _is_kernel(node: ast.AST, names: set[str]) -> bool:
    return isinstance(node, ast.FunctionDef) and any(
        getattr(d.func if isinstance(d, ast.Call) else d, "id", "") in names
        for d in node.decorator_list
    )


def called_by_python() -> set[str]:
    """Full names of all kernels that are named outside of kernels."""
    made = _trees(lambda text: any(name in text for name in DECORATORS))
    decorators = {module: _decorators(tree) for module, tree in made.items()}
    kernels = {
        f"{module}.{node.name}"
        for module, tree in made.items()
        for node in tree.body
        if _is_kernel(node, decorators[module])
    }
    found = set()
    rooms = {kernel.rpartition(".")[0] for kernel in kernels}
    for module, tree in _trees(lambda text: _may_import(text, rooms)).items() | made.items():
        local = {kernel.rpartition(".")[2]: kernel for kernel in kernels if _in(kernel, module)}
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom):
                local |= {a.asname or a.name: f"{node.module}.{a.name}" for a in node.names}
        waiting: list[ast.AST] = [tree]
        while waiting:
            node = waiting.pop()
            if _is_kernel(node, decorators.get(module, DECORATORS)):
                continue
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                found.add(local.get(node.id, ""))
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                found.add(f"{local.get(node.value.id, '')}.{node.attr}")
            waiting.extend(ast.iter_child_nodes(node))
    return {kernel for kernel in found & kernels if not kernel.startswith(ONLY_MEASURED)}


def _trees(is_of_them: Callable[[str], bool]) -> dict[str, ast.Module]:
    """The modules whose text may matter; to parse and walk all takes seconds."""
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts): _parsed(text)
        for path, text in _texts().items()
        if is_of_them(text)
    }


def _may_import(text: str, modules: set[str]) -> bool:
    """Whether a text may import one of some modules, or something of it."""
    parts = (module.rpartition(".") for module in modules)
    return any(
        f"from {room}.{name} import" in text or (f"from {room} import" in text and name in text)
        for room, _, name in parts
    )


_parsed = functools.cache(ast.parse)


def _in(kernel: str, module: str) -> bool:
    return kernel.rpartition(".")[0] == module


def test_every_kernel_that_python_calls_is_compiled_ahead() -> None:
    called = {kernel for kernel in called_by_python() if not _only_measured(kernel)}
    assert len(called) > 60
    assert {entry.kernel for entry in read_table().entries} >= called


@functools.cache
def _texts() -> dict[Path, str]:
    return {path: path.read_text("utf-8") for path in PACKAGE.rglob("*.py")}


def _only_measured(kernel: str) -> bool:
    """Whether benchmarks alone call it."""
    name = kernel.rpartition(".")[2]
    callers = {path for path, text in _texts().items() if name in text}
    return all(
        "bench" in path.parts or _in(kernel, ".".join(path.relative_to(ROOT).with_suffix("").parts))
        for path in callers
    )


def test_all_that_the_table_names_is_there_and_takes_what_it_says() -> None:
    assert len(checked_table().entries) > 60


DRAG = "brush_engine.drag.drag_length"
TAKES = "descent float, length_mm float, fraction float"
TREE = "order i4[:], boxes f4[:,:], triangles i4[:,:], points f4[:,:], normals f4[:,:]"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"{DRAG}x: {TAKES}", ":1: paint3d.brush_engine.drag.drag_lengthx is not there"),
        (f"brush_engine.drug.run: {TAKES}", "No module named 'paint3d.brush_engine.drug'"),
        ("core.arrays.as_array: a f8[:], b f8[:]", "is no kernel: expected one decorated"),
        (
            f"# a remark\n{DRAG}: descent float,\n    length_mm float",
            f":2: paint3d.{DRAG}: expected (descent, length_mm, fraction), as it takes, "
            "got (descent, length_mm)",
        ),
        (f"{DRAG}: {TAKES}\n\n{DRAG}: {TAKES}", ":3: paint3d.brush_engine.drag.drag_length stands"),
        (
            f"tuple mesh.kernels.bvh.ContactTree: {TREE[:-16]}",
            ":1: paint3d.mesh.kernels.bvh.ContactTree: expected (order, boxes, triangles, points, "
            "normals), as it has, got (order, boxes, triangles, points)",
        ),
        (f"tuple mesh.kernels.bvh.ContactTree: {TREE}", "is taken by no kernel"),
        ("tuple mesh.kernels.bvh.find: x int", "mesh.kernels.bvh.find is not there"),
        (
            f"{DRAG}: {TAKES[:-5]}core.arrays.as_array[:]",
            "core.arrays.as_array is no dtype of records",
        ),
        ("a.b.run points f8[:]\n", "expected 'module.kernel: name type, ...'"),
        ("a.b.run: points f16[:]\n", "a.b.run: points has unknown type 'f16[:]'; expected one of"),
        (
            "\n\na.b.run: points Nobody\n",
            "entries.txt:3: a.b.run: points has unknown type 'Nobody'",
        ),
        ("a.b.run: points\n", "entries.txt:1: a.b.run: expected 'name type, ...', got 'points'"),
    ],
)
def test_what_the_sources_do_not_say_is_told_with_its_line(
    text: str, said: str, tmp_path: Path
) -> None:
    table = tmp_path / "entries.txt"
    table.write_text(text)
    with pytest.raises(TableError) as error:
        checked_table(table)
    assert said in str(error.value)


def test_all_faults_are_told_at_once_and_before_anything_is_compiled(tmp_path: Path) -> None:
    table = tmp_path / "entries.txt"
    table.write_text(f"{DRAG}: descent float\ntuple mesh.kernels.bvh.ContactTree: {TREE}\n")
    program = "import sys, pathlib; from tools.kernels.table import TableError\n"
    program += "from tools.kernels.checking import checked_table\n"
    program += "try: checked_table(pathlib.Path(sys.argv[1]))\n"
    program += "except TableError as error: print(error)\n"
    program += "assert 'numba' not in sys.modules\n"
    run = subprocess.run(
        [sys.executable, "-c", program, table],
        capture_output=True, text=True, check=True, cwd=ROOT,
        env={k: v for k, v in os.environ.items() if k != ONLY},
    )  # fmt: skip
    first, second = run.stdout.splitlines()
    assert first.startswith("entries.txt:1: ")
    assert second.startswith("entries.txt:2: ")


def test_types_are_read_as_they_are_written(tmp_path: Path) -> None:
    table = tmp_path / "entries.txt"
    table.write_text(
        "tuple a.b.Pair: x f8[:,:], n int  # a remark\n"
        "a.c.run: pair Pair, both (int, float),\n    marks a.b.MARK[:], on bool, share f4\n"
    )
    (entry,) = read_table(table).entries
    pair = Row("a.b.Pair", (Array("f8", 2), Number("i8")), ("x", "n"))
    assert entry.kernel == "paint3d.a.c.run"
    assert entry.takes == {
        "pair": pair,
        "both": Row("", (Number("i8"), Number("f8"))),
        "marks": Array("a.b.MARK", 1),
        "on": Number("b1"),
        "share": Number("f4"),
    }
    assert entry.tuples == {"paint3d.a.b"}
    assert entry.modules == {"paint3d.a.b", "paint3d.a.c"}


def test_a_kernel_is_made_of_what_its_module_imports_and_of_the_tuples_it_takes() -> None:
    entry = next(e for e in read_table().entries if e.name == "paint_samples")
    made_from = sources_of(entry.modules, entry.tuples)
    for path in (
        "brush_engine/stroke_loop.py",
        "brush_engine/ink_transfer.py",  # imported
        "mesh/kernels/mesh_arrays.py",  # whose tuple it takes
        "brush_engine/footprint.py",  # whose record it takes
        "core/kernel.py",
    ):
        assert f"paint3d/{path}" in made_from
    for path in ("core/kernel_library.py", "mesh/refined_mesh.py"):
        assert f"paint3d/{path}" not in made_from
