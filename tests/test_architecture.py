"""The shape of the program: who may import whom, what importing costs, what is documented."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import paint3d
from paint3d.bench.registry import BENCHMARKS
from paint3d.brush_engine.bristles.stroke_loop import paint_with_hairs
from paint3d.brush_engine.stroke_loop import paint_samples
from paint3d.cli.main import COMMANDS
from paint3d.colour.kernels.kubelka_munk import single_colours
from paint3d.core.face import names_of
from paint3d.painter.painter import Painter
from paint3d.recording.recording import load_recording, save_recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.imports import circles, import_graph, reached
from tests.support.surface_cases import flat, poses, sheet
from tests.support.visits import called_by, modules_called

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
    "pyvista": {"surface", "view"},
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
    "paint3d.files.readers.read_",
    "paint3d.files.sandbox.child",
    "paint3d.cli.batches.warm",
    "paint3d.app.window.first_stroke",
)
# Devices that no command offers yet:
NUMBERED = re.compile(r"^ {4,}\S.* {2}\((\d+)\)$", re.MULTILINE)
CITED = re.compile(r"\bequations?\s+\((\d+)\)(?:\s+and\s+\((\d+)\))?")
PRIVATE = re.compile("_[^_]")
OF_NAMED_TUPLES = {"_asdict", "_fields", "_make", "_replace"}
VAGUE = {"utils", "util", "helpers", "helper", "common", "manager", "misc"}


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


def test_every_room_has_a_face_of_few_names() -> None:
    """Each of them is there, and type checkers know no others."""
    rooms = {f"paint3d.{room.parent.name}" for room in PACKAGE.glob("*/__init__.py")}
    assert set(packages_with_a_face()) == {"paint3d", *rooms}
    for package in packages_with_a_face():
        face = import_module(package)
        names = names_of(package)
        assert 1 <= len(names.keys() - {"errors"}) <= 12, package
        assert face.__all__ == sorted(names)
        assert set(face.__all__) <= set(dir(face))
        for name, home in names.items():
            value = getattr(import_module(home), name)
            assert getattr(face, name) is value, f"{package}.{name}"
            assert home == package or home.startswith(f"{package}."), "a room shows its own"


def test_a_room_loads_nothing_of_itself_until_it_is_asked() -> None:
    loaded = run_python(
        "import sys\n"
        "from importlib import import_module\n"
        f"for package in {packages_with_a_face()}:\n"
        "    import_module(package)\n"
        "    print(*(name for name in sys.modules if name.startswith('paint3d.')))\n"
    )
    rooms = {*packages_with_a_face(), "paint3d.core.face"}
    assert {name for name in loaded.split() if name not in rooms} == set()


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


def test_scipy_is_imported_where_it_is_called() -> None:
    """It takes half a second, and most of what is done needs none of it."""
    at_once = [
        str(module.relative_to(PACKAGE))
        for module, tree in parsed("scipy")
        for node in tree.body
        if isinstance(node, ast.Import | ast.ImportFrom)
        and "scipy" in imported_packages(ast.Module([node], []))
    ]
    assert at_once == ["bench/plain.py"], "the competitor that is made of it"


def test_everything_public_has_a_docstring() -> None:
    bare = []
    for module in modules():
        tree = parse(module)
        where = str(module.relative_to(ROOT))
        if tree.body and not ast.get_docstring(tree):
            bare.append(where)
        for node in tree.body:
            bare += [f"{where}: {name}" for name in undocumented(node)]
    assert bare == []


def undocumented(node: ast.AST, prefix: str = "") -> Iterator[str]:
    named = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
    if not isinstance(node, named) or node.name.startswith("_"):
        return
    overload = {"setter", "deleter", "overload"}
    marks = {ast.unparse(mark).split(".")[-1] for mark in node.decorator_list}
    if not ast.get_docstring(node) and not overload & marks:
        yield prefix + node.name
    if isinstance(node, ast.ClassDef):
        for child in node.body:
            yield from undocumented(child, f"{prefix}{node.name}.")


def test_no_module_imports_itself_through_others() -> None:
    """Not for types only, either: what is known of both sides belongs below them."""
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}) == [{"b", "c"}]
    assert circles(import_graph(PACKAGE)) == []


def test_every_module_is_reached() -> None:
    """From the command line, the public face or a benchmark."""
    graph = import_graph(PACKAGE)
    roots = {f"paint3d.{word}" for word in ("__main__", "cli.main")}
    roots |= {module for module in graph if module.startswith(BY_NAME)}
    roots |= set(names_of("paint3d").values()) | set(COMMANDS.values())
    roots |= {f"paint3d.bench.{where.split('.')[0]}" for where, _ in BENCHMARKS.values()}
    assert set(graph) - reached(graph, roots) == set()


def functions() -> Iterator[tuple[str, ast.FunctionDef]]:
    for module in modules():
        for node in ast.walk(parse(module)):
            if isinstance(node, ast.FunctionDef):
                yield f"{module.relative_to(ROOT)}: {node.name}", node


def test_tests_see_the_program_from_outside() -> None:
    """They reach for what begins with one underscore in few places, each of them to be regretted.

    Constants that a test changes by name for itself are not among them.
    """
    text = "from a import _b, c; c.d._e, self._f, self.d._g, c._replace(), c.__doc__, os._exit"
    assert list(reached_into(ast.parse(text))) == [(1, "_b"), (1, "c.d._e"), (1, "self.d._g")]
    places = [
        f"{module.relative_to(ROOT)}:{line}: {name}"
        for module, tree in parsed(r"\b_[^_]", ROOT / "tests")
        for line, name in reached_into(tree)
    ]
    assert len(places) <= 5, "\n".join(places)


def reached_into(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Lines and names of private attributes, of anything but oneself, and of private imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            private = [alias.name for alias in node.names if PRIVATE.match(alias.name)]
            yield from ((node.lineno, name) for name in private)
        elif isinstance(node, ast.Attribute) and PRIVATE.match(node.attr):
            owner, name = ast.unparse(node.value), ast.unparse(node)
            public = node.attr in OF_NAMED_TUPLES or owner == "sys" or name == "os._exit"
            if owner not in ("self", "cls") and not public:
                yield node.lineno, name


def test_properties_are_tried_on_25_examples_at_least() -> None:
    """With --long; of those that cost much, a third every time: `examples`."""
    tried = {
        f"{module.relative_to(ROOT)}:{node.value.lineno}": ast.literal_eval(
            node.value.args[0] if isinstance(node.value, ast.Call) else node.value
        )
        for module, tree in parsed("max_examples", ROOT / "tests")
        for node in ast.walk(tree)
        if isinstance(node, ast.keyword) and node.arg == "max_examples"
    }
    assert len(tried) > 50
    assert {place: n for place, n in tried.items() if n < 25} == {}


def test_functions_are_short_and_take_few_things() -> None:
    """60 lines with the docstring, 8 parameters."""
    long, counts = [], {}
    for name, f in functions():
        long += [name] if f.end_lineno - f.lineno >= 60 else []
        given = [a.arg for a in (*f.args.posonlyargs, *f.args.args, *f.args.kwonlyargs)]
        counts[name] = len(given) - (given[:1] in (["self"], ["cls"]))
    assert long == []
    assert {name: n for name, n in counts.items() if n > 8} == {}


def test_no_room_is_a_drawer() -> None:
    """More than 26 files in one folder, and nobody finds anything."""
    folders = {module.parent for module in modules()}
    crowded = {f: n for f in folders if (n := len([*f.glob("*.py")]) - 1) > 26}
    assert crowded == {}


@pytest.mark.parametrize(("hairs", "most"), [(0, 22), (50, 29)])
def test_a_sample_visits_few_files(hairs: int, most: int, tmp_path: Path) -> None:
    """From being read to its vertices' colours: files of functions that run, without `core`."""
    surface = PaintedSurface(sheet(flat, (20.0, 20.0), 2.0))
    painter = Painter(surface, hairs=hairs)
    points = np.stack([np.linspace(-3.0, 3.0, 20), np.zeros(20), np.zeros(20)], axis=1)
    stroke = poses(points, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), np.full(20, 0.4))
    save_recording(stroke, tmp_path / "a.jsonl")
    painter.replay(stroke)  # what is made once, is made
    surface.refresh()
    with modules_called() as visited:
        painter.replay(load_recording(tmp_path / "a.jsonl"))
        surface.refresh()
    assert surface.painted.any()
    visited |= called_by(paint_with_hairs if hairs else paint_samples) | called_by(single_colours)
    assert {"paint3d.recording.recording", "paint3d.colour.vertex_colours"} < visited
    visited = {module for module in visited if not module.startswith("paint3d.core.")}
    assert len(visited) <= most, sorted(visited)


def test_every_room_says_what_it_is_for() -> None:
    silent = [
        module.parent
        for module in modules()
        if module.name == "__init__.py" and not ast.get_docstring(parse(module))
    ]
    assert silent == []


def test_equations_of_our_own_are_named_where_they_are_computed() -> None:
    """Their numbers in docs/model.md; those of papers stand in the code as Eq. n."""
    numbered = NUMBERED.findall((ROOT / "docs" / "model.md").read_text(encoding="utf-8"))
    cited: dict[str, list[str]] = {}
    for module in modules():
        for numbers in CITED.findall(module.read_text(encoding="utf-8")):
            for number in filter(None, numbers):
                cited.setdefault(number, []).append(str(module.relative_to(PACKAGE)))
    assert numbered == [str(k + 1) for k in range(len(numbered))], "numbered as they come"
    assert sorted(cited, key=int) == numbered, cited


def test_module_names_say_something() -> None:
    assert [str(m) for m in modules() if m.stem in VAGUE] == []


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
