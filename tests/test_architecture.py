"""The shape of the program: who may import whom, what importing costs, what is documented."""

from __future__ import annotations

import ast
import functools
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from pathlib import Path

import paint3d
from paint3d.bench.registry import BENCHMARKS
from paint3d.cli.main import COMMANDS

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "paint3d"
PRINT_LOADED = "print(*{name.split('.')[0] for name in sys.modules})"
HEAVY = {
    "trimesh",
    "open3d",
    "pyvista",
    "vtk",
    "vtkmodules",
    "colour",
    "numba",
    "matplotlib",
    "hid",
    "hidraw",
    "websockets",
    "PySide6",
    "fontTools",
    "uharfbuzz",
    "svgelements",
    "imageio_ffmpeg",
}
# Each heavy package has its places; elsewhere it must not be imported at all.
HOMES = {
    "hid": {"device"},
    "hidraw": {"device"},
    "websockets": {"device"},
    "open3d": {"files", "surface"},
    "pyvista": {"surface"},
    "vtk": {"view"},
    "vtkmodules": {"view"},
    "numba": {"core"},
    "xatlas": {"files"},
    "imageio_ffmpeg": {"view"},
    "PySide6": {"app"},
    # Paintings are handed to those who work with these packages, and taken from them; the
    # program itself needs neither. What takes such an object imports nothing for it.
    "trimesh": {"files", "surface"},
    "colour": {"colour", "surface"},  # other lights and observers than our own
}
# Tools and oracles, never part of the program:
FORBIDDEN = {"matplotlib", "pandas", "torch"}
# What is reached by name: readers of kinds of files, what processes begin with.
BY_NAME = (
    "paint3d.files.formats.",
    "paint3d.files.sandbox",
    "paint3d.cli.batches.warm",
    "paint3d.app.window.first_stroke",
)
# Devices that no command offers yet:
NUMBERED = re.compile(r"^ {4,}\S.* {2}\((\d+[a-z]?)\)$", re.MULTILINE)
CITED = re.compile(r"\bequations?\s+\((\d+[a-z]?)\)(?:\s+and\s+\((\d+[a-z]?)\))?")


def modules() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def parse(module: Path) -> ast.Module:
    return ast.parse(module.read_text(encoding="utf-8"), filename=str(module))


def parsed(says: str, folder: Path = PACKAGE) -> Iterator[tuple[Path, ast.Module]]:
    """The modules of a folder in whose text a pattern is found: what asks for it needs no others.

    Half a second is what parsing all takes, and another what walking through all does.
    """
    for module in sorted(folder.rglob("*.py")):
        if re.search(says, module.read_text(encoding="utf-8")):
            yield module, parse(module)


def imported_packages(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module.split(".")[0]


def run_python(code: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    return done.stdout


def test_layers_hold() -> None:
    lint = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run(
        [lint, "--no-cache"], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_importing_paint3d_loads_nothing_heavy() -> None:
    loaded = run_python(f"import sys, paint3d; {PRINT_LOADED}")
    assert not HEAVY & set(loaded.split())
    assert not {"numpy", "scipy"} & set(loaded.split())


def test_the_command_line_loads_nothing_heavy_to_print_its_help() -> None:
    loaded = run_python(
        "import sys, contextlib, io\n"
        "from paint3d.cli.main import main\n"
        "with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):\n"
        "    main(['--help'])\n"
        f"{PRINT_LOADED}"
    )
    assert not HEAVY & set(loaded.split())


def packages_with_a_face() -> list[str]:
    faces = sorted(PACKAGE.rglob("__init__.pyi"))
    return [".".join(face.parent.relative_to(ROOT).parts) for face in faces]


def public_homes(package: str) -> set[str]:
    """Modules that the public names of a package come from, as its stub says."""
    stub = ROOT / package.replace(".", "/") / "__init__.pyi"
    lines = [line for line in parse(stub).body if isinstance(line, ast.ImportFrom)]
    return {".".join(filter(None, (package, line.module))) for line in lines}


def test_every_room_has_a_face() -> None:
    """Each of its names can be loaded."""
    rooms = {f"paint3d.{room.parent.name}" for room in PACKAGE.glob("*/__init__.py")}
    assert set(packages_with_a_face()) == {"paint3d", *rooms}
    for package in packages_with_a_face():
        face = import_module(package)
        assert face.__all__, package
        for name in face.__all__:  # by paths relative to the room: they are its own
            getattr(face, name)


def test_a_room_loads_nothing_of_itself_until_it_is_asked() -> None:
    loaded = run_python(
        "import sys\n"
        "from importlib import import_module\n"
        f"for package in {packages_with_a_face()}:\n"
        "    import_module(package)\n"
        "    print(*(name for name in sys.modules if name.startswith('paint3d.')))\n"
    )
    assert set(loaded.split()) == set(packages_with_a_face()) - {"paint3d"}


def test_unknown_name_is_an_attribute_error() -> None:
    assert not hasattr(paint3d, "Paintr")
    assert not hasattr(import_module("paint3d.mesh"), "TriangleMess")


def test_the_studios_model_knows_no_window() -> None:
    for module in (PACKAGE / "app" / "model").rglob("*.py"):
        names = set(imported_packages(parse(module)))
        assert not {"PySide6", "vtk", "vtkmodules", "pyvista"} & names, module
        assert "paint3d.app.window" not in module.read_text(encoding="utf-8"), module


def test_heavy_packages_stay_at_home() -> None:
    strays = [
        f"{module.relative_to(ROOT)} imports {package}"
        for module, tree in parsed(rf"\b(?:{'|'.join([*FORBIDDEN, *HOMES])})\b")
        for package in imported_packages(tree)
        if package in FORBIDDEN
        or (package in HOMES and module.relative_to(PACKAGE).parts[0] not in HOMES[package])
    ]
    assert strays == []


def test_no_module_imports_itself_through_others() -> None:
    """Not for types only, either: what is known of both sides belongs below them."""
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}) == [{"b", "c"}]
    assert circles(import_graph(PACKAGE)) == []


def test_every_module_is_reached() -> None:
    """From the command line, the public face or a benchmark."""
    graph = import_graph(PACKAGE)
    roots = {f"paint3d.{word}" for word in ("__main__", "cli.main")}
    roots |= {module for module in graph if module.startswith(BY_NAME)}
    roots |= public_homes("paint3d") | {home for home, _ in COMMANDS.values()}
    roots |= {f"paint3d.bench.{where.split('.')[0]}" for where, _ in BENCHMARKS.values()}
    assert set(graph) - reached(graph, roots) == set()


def test_equations_of_our_own_are_named_where_they_are_computed() -> None:
    """Their numbers in docs/model.md; those of papers stand in the code as Eq. n."""
    numbered = NUMBERED.findall((ROOT / "docs" / "model.md").read_text(encoding="utf-8"))
    cited: dict[str, list[str]] = {}
    for module in modules():
        for numbers in CITED.findall(module.read_text(encoding="utf-8")):
            for number in filter(None, numbers):
                cited.setdefault(number, []).append(str(module.relative_to(PACKAGE)))
    whole = [number for number in numbered if number.isdecimal()]
    assert whole == [str(k + 1) for k in range(len(whole))], "numbered as they come"
    assert numbered == sorted(numbered, key=lambda one: (int(re.match(r"\d+", one)[0]), one))
    assert set(cited) == set(numbered), cited


def test_the_library_never_prints() -> None:
    printing = [
        str(module.relative_to(ROOT))
        for module, tree in parsed(r"\b(?:print|breakpoint|input)\b")
        if module.relative_to(PACKAGE).parts[0] != "cli"
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in {"print", "breakpoint", "input"}
    ]
    assert printing == []


def test_no_data_is_read_from_outside_the_package() -> None:
    strays = [
        str(module.relative_to(ROOT))
        for module in modules()
        if "shared" + "/" in module.read_text(encoding="utf-8")
    ]
    assert strays == []


Graph = Mapping[str, set[str]]


@functools.cache
def import_graph(package: Path) -> dict[str, set[str]]:
    """Module to the modules of the package that it names, also for types only and inside functions.

    A module imports the packages that it lies in.
    """
    files = {_name(file, package): file for file in package.rglob("*.py")}
    known = frozenset(files)
    return {name: _imports(file, name, known) for name, file in files.items()}


def _name(file: Path, package: Path) -> str:
    parts = file.relative_to(package.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imports(file: Path, name: str, known: frozenset[str]) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            inner = {f"{node.module}.{alias.name}" for alias in node.names} & known
            found |= inner or {node.module}
    return (found & known) - {name}


def reached(graph: Graph, roots: Iterable[str]) -> set[str]:
    """Modules that are loaded, sooner or later, with some."""
    seen: set[str] = set()
    todo = list(roots)
    while todo:
        module = todo.pop()
        if module not in seen:
            seen.add(module)
            todo += graph[module]
            todo += [module.rpartition(".")[0]] if "." in module else []
    return seen


def circles(graph: Graph) -> list[set[str]]:
    """Modules that import each other around a circle."""
    after = {module: reached_from(graph, module) for module in graph}
    found: list[set[str]] = []
    for module in graph:
        circle = {other for other in after[module] if module in after[other]}
        if circle and circle not in found:
            found.append(circle)
    return found


def reached_from(graph: Graph, module: str) -> set[str]:
    """What one imports, directly or through others."""
    seen: set[str] = set()
    todo = list(graph[module])
    while todo:
        other = todo.pop()
        if other not in seen:
            seen.add(other)
            todo += graph[other]
    return seen
