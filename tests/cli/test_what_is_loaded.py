"""What commands load: packages that take longer to import than the command's work takes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from paint3d.cli.main import COMMANDS

HEAVY = {
    *("scipy", "open3d", "pyvista", "vtk", "vtkmodules", "PySide6", "PIL", "trimesh", "hid"),
    *(
        "numba",
        "llvmlite",
        "colour",
        "matplotlib",
        "fontTools",
        "uharfbuzz",
        "svgelements",
        "networkx",
    ),
}
SELDOM = {
    *("numpy.ma", "html", "tomllib", "xml.etree", "paint3d.view.picture"),
    *("email", "multiprocessing", "subprocess", "paint3d.brush_engine.bristles"),
}
RUN = """
import sys
from paint3d.cli.main import main
status = main(sys.argv[1:])
print(*sys.modules, file=sys.stderr)
sys.exit(status)
"""


def loaded_by(*arguments: str) -> set[str]:
    """Packages that are loaded when a command has been run in a process of its own."""
    return {name.split(".")[0] for name in modules_of(*arguments)}


def names_of(*arguments: str) -> set[str]:
    """Modules and the packages that they lie in."""
    parts = (name.split(".") for name in modules_of(*arguments))
    return {".".join(some[:k]) for some in parts for k in range(1, len(some) + 1)}


def commands(loaded: set[str]) -> set[str]:
    """Which commands' modules are among those that are loaded."""
    of_commands = {module: name for name, module in COMMANDS.items()}
    return {of_commands[name] for name in loaded & set(of_commands)}


def modules_of(*arguments: str) -> set[str]:
    """The same, module by module."""
    done = subprocess.run(
        [sys.executable, "-c", RUN, *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return set(done.stderr.splitlines()[-1].split())


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The hand that writes one character, written while what that loads is looked at."""
    folder = tmp_path_factory.mktemp("written")
    loaded = names_of(
        "write", "一", "--on", "bowl", "--out", str(folder / "one.glb"),
        "--recording", str(folder / "one.csv"),
    )  # fmt: skip
    assert loaded & (HEAVY | SELDOM) == {"xml.etree"}, "glyphs are drawn in SVG"
    assert commands(loaded) == {"write", "replay", "picture"}, "films are pictures"
    assert (folder / "one.glb").stat().st_size > 10_000
    return folder / "one.csv"


@pytest.mark.parametrize("suffix", [".glb", ".ply", ".p3d"])
def test_painting_a_recording_loads_nothing_heavy(
    recording: Path, suffix: str, tmp_path: Path
) -> None:
    out = tmp_path / f"again{suffix}"
    loaded = names_of("replay", str(recording), "--on", "bowl", "--out", str(out))
    assert loaded & (HEAVY | SELDOM) == set()
    assert commands(loaded) == {"replay", "picture"}
    assert out.stat().st_size > 10_000


def test_a_format_loads_no_other_formats_writer(recording: Path, tmp_path: Path) -> None:
    out = tmp_path / "again.ply"
    loaded = modules_of("replay", str(recording), "--on", "bowl", "--out", str(out))
    assert {name for name in loaded if name.startswith("paint3d.files.writers.write_")} == {
        "paint3d.files.writers.write_ply"
    }


def test_inks_load_nothing_heavy() -> None:
    loaded = names_of("inks")
    assert loaded & (HEAVY | SELDOM) == set()
    assert commands(loaded) == {"inks"}


def test_help_does_not_even_load_numpy() -> None:
    assert loaded_by("inks") >= {"numpy"}, "what is loaded is seen"
    help_of_all = "import sys; from paint3d.cli.main import main; main(['--help'])"
    code = f"try:\n    {help_of_all}\nfinally:\n    print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not (HEAVY | {"numpy"}) & {name.split(".")[0] for name in done.stderr.split()}


def test_the_studio_starts_without_what_only_some_of_its_work_needs() -> None:
    """SciPy takes half a second; it is imported when a character is compared with its copybook."""
    pytest.importorskip("PySide6", reason="PySide6 is not installed")
    code = (
        "import sys, paint3d.app.window.start\n"
        "from paint3d.app.model.document import Document\n"
        "from paint3d.app.model.persistence.settings import Settings\n"
        "from paint3d.app.window.jobs.opened import Opened\n"
        "Settings(), Opened.of(Document.new('bowl', 2.0, 'xuan'))\n"
        "print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = {name.split(".")[0] for name in done.stdout.split()}
    assert "PySide6" in loaded
    assert not (HEAVY - {"PySide6", "PIL"}) & loaded


def test_the_interpreter_does_not_go_over_all_there_is_as_it_ends() -> None:
    code = (
        "import atexit, gc\n"
        "atexit.register(lambda: print(gc.get_freeze_count()))  # the first to come is the last\n"
        "from paint3d.cli.main import main\n"
        "assert main(['inks']) == 0"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout.splitlines()[-1]) > 10_000
