"""The table of what is compiled ahead: all that Python calls, as it is now."""

from __future__ import annotations

import ast
import functools
import inspect
from pathlib import Path

import pytest

from tools.kernels.sources import sources_of
from tools.kernels.table import Array, Number, Row, TableError, read_table, resolve

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
    trees = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts): ast.parse(text)
        for path, text in _texts().items()
    }
    kernels = {
        f"{module}.{node.name}"
        for module, tree in trees.items()
        for node in tree.body
        if _is_kernel(node, _decorators(tree))
    }
    found = set()
    for module, tree in trees.items():
        local = {kernel.rpartition(".")[2]: kernel for kernel in kernels if _in(kernel, module)}
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom):
                local |= {a.asname or a.name: f"{node.module}.{a.name}" for a in node.names}
        waiting: list[ast.AST] = [tree]
        while waiting:
            node = waiting.pop()
            if _is_kernel(node, _decorators(tree)):
                continue
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                found.add(local.get(node.id, ""))
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                found.add(f"{local.get(node.value.id, '')}.{node.attr}")
            waiting.extend(ast.iter_child_nodes(node))
    return {kernel for kernel in found & kernels if not kernel.startswith(ONLY_MEASURED)}


def _in(kernel: str, module: str) -> bool:
    return kernel.rpartition(".")[0] == module


def test_every_kernel_that_python_calls_is_compiled_ahead() -> None:
    called = {kernel for kernel in called_by_python() if not _only_measured(kernel)}
    assert len(called) > 60
    assert {entry.kernel for entry in read_table()} >= called


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


def test_nothing_is_compiled_ahead_that_is_not_there() -> None:
    for entry in read_table():
        called = resolve(f"{entry.module}.{entry.name}")
        assert tuple(inspect.signature(called).parameters) == tuple(entry.takes), entry.kernel
        waiting = [*entry.takes.values()]
        while waiting:
            part = waiting.pop()
            if isinstance(part, Row):
                assert not part.of or part.names == resolve(part.of)._fields, part.of
                waiting.extend(part.parts)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a.b.run points f8[:]\n", "expected 'module.kernel: name type, ...'"),
        ("a.b.run: points f16[:]\n", "a.b.run: unknown type 'f16[:]'"),
        ("a.b.run: points Nobody\n", "a.b.run: unknown type 'Nobody'"),
        ("a.b.run: points\n", "expected 'name type, ...', got 'points'"),
    ],
)
def test_a_line_that_says_nothing_is_told(text: str, said: str, tmp_path: Path) -> None:
    table = tmp_path / "entries.txt"
    table.write_text(text)
    with pytest.raises(TableError) as error:
        read_table(table)
    assert said in str(error.value)


def test_types_are_read_as_they_are_written(tmp_path: Path) -> None:
    table = tmp_path / "entries.txt"
    table.write_text(
        "tuple a.b.Pair: x f8[:,:], n int  # a remark\n"
        "a.c.run: pair Pair, both (int, float),\n    marks a.b.MARK[:], on bool, share f4\n"
    )
    (entry,) = read_table(table)
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
    entry = next(e for e in read_table() if e.name == "paint_samples")
    made_from = sources_of(entry.modules, entry.tuples)
    for path in (
        "brush_engine/stroke_loop.py",
        "brush_engine/deposit.py",  # imported
        "mesh/kernels/mesh_arrays.py",  # whose tuple it takes
        "brush_engine/sweep.py",  # whose record it takes
        "core/kernel.py",
    ):
        assert f"paint3d/{path}" in made_from
    for path in ("core/kernel_library.py", "core/compiled.py", "mesh/refined_mesh.py"):
        assert f"paint3d/{path}" not in made_from
