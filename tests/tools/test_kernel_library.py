"""Kernels compiled ahead: the same bytes as numba's, never old code, and no word of numba."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from paint3d.brush_engine.drag import drag_length
from paint3d.brush_engine.stroke_loop import paint_samples
from paint3d.colour.kernels.kubelka_munk import layer_bands
from paint3d.core import kernel
from paint3d.core.kernel_library import FOLDER, INDEX, Library, library
from paint3d.core.numba_kernels import ONLY, DeferredKernel, llvm_name, processor_of
from paint3d.mesh.kernels.bvh import order_by_halving
from paint3d.mesh.kernels.refine import activate_cell
from paint3d.mesh.kernels.topology import corner_normals, count_around, link_radial, measure_faces
from tools.kernels import __main__ as kernels_command
from tools.kernels.building import build
from tools.kernels.processors import ARCHITECTURES, made_for, own_processor

ROOT = Path(__file__).parents[2]
LEVEL_3 = {
    *("cx16", "popcnt", "sse4.1", "sse4.2", "ssse3"),
    *("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"),
}  # of x86-64, as its psABI says
FACES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], np.int32)
POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.3, 0.9]], np.float32)
_CAN_BE = sys.platform == "linux" and shutil.which("gcc") is not None
pytestmark = pytest.mark.skipif(
    library() is None and not _CAN_BE, reason="kernels are compiled ahead with gcc on Linux"
)


def shape_of(points: np.ndarray, faces: np.ndarray) -> list[np.ndarray]:
    normals, areas = np.empty((len(faces), 3), np.float32), np.empty(len(faces))
    measure_faces(points, faces, normals, areas)
    return [normals, areas]


def bands() -> list[np.ndarray]:
    rows = np.random.default_rng(3).uniform(0.01, 0.9, (7, 36))
    layer_bands(*rows)
    return list(rows)


def halves() -> list[np.ndarray]:
    centres = np.random.default_rng(4).normal(size=(64, 3)).astype(np.float32)
    order = np.arange(64, dtype=np.int32)
    order_by_halving(centres, 16, 4, order)
    return [centres, order]


@pytest.mark.parametrize(
    "run",
    [
        lambda: [link_radial(FACES, 4)],
        lambda: shape_of(POINTS, FACES),
        bands,
        halves,
    ],
)
def test_the_library_and_numba_give_the_same_bytes(
    run: Callable[[], list[np.ndarray]], monkeypatch: pytest.MonkeyPatch
) -> None:
    by_library = run()
    for name in ("link_radial", "measure_faces", "layer_bands", "order_by_halving"):
        monkeypatch.setitem(globals(), name, globals()[name].jit)
    for ahead, by_numba in zip(by_library, run(), strict=True):
        assert ahead.dtype == by_numba.dtype
        assert ahead.tobytes() == by_numba.tobytes()


def test_kernels_that_only_kernels_call_are_left_to_numba_and_to_be_called() -> None:
    from paint3d.mesh.kernels.mesh_arrays import find_pair

    assert type(find_pair) is DeferredKernel
    pairs, roots = np.array([0, 3], np.int64), np.array([2, 5, 9], np.int32)
    assert find_pair(pairs, roots, 0, 9) == 2


def test_a_kernel_that_numba_compiles_may_call_one_of_the_library() -> None:
    from paint3d.core.kernel import kernel

    @kernel(cache=False)
    def around(faces: Any) -> Any:
        return count_around(link_radial(faces, 4))

    assert around(FACES) == count_around(link_radial(FACES, 4))


def test_what_is_given_by_keyword_or_in_another_layout_goes_to_numba() -> None:
    wanted = link_radial(FACES, 4)
    assert np.array_equal(link_radial(FACES, n_vertices=4), wanted)
    assert np.array_equal(link_radial(np.asfortranarray(FACES), 4), wanted)
    assert np.array_equal(link_radial(FACES.astype(np.int64), 4), wanted)


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (
            (FACES.astype(np.int64), 4),
            "faces: expected a C-contiguous array i4[:,:], got int64 (4, 3)",
        ),
        ((np.asfortranarray(FACES), 4), "got int32 (4, 3), not contiguous"),
        ((FACES[0], 4), "got int32 (3,)"),
        (([[0, 1, 2]], 4), "got list"),
        ((FACES, 4.5), "n_vertices: expected i8, got 4.5"),
        ((FACES, 1 << 64), "a number is out of range"),
        ((FACES,), "takes faces, n_vertices in this order, got 1"),
    ],
)
def test_without_numba_it_is_said_what_does_not_fit(
    args: tuple[Any, ...], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(ONLY, "library")
    with pytest.raises(TypeError) as error:
        link_radial(*args)
    assert str(error.value).startswith("paint3d.mesh.kernels.topology.link_radial")
    assert said in str(error.value)


def test_a_field_of_a_tuple_is_named_by_its_way(monkeypatch: pytest.MonkeyPatch) -> None:
    from paint3d.surface.painted_surface import PaintedSurface
    from tests.support.surface_cases import flat, sheet

    field = PaintedSurface(sheet(flat, (9.0, 9.0), 5.0), 1.0).paint_mesh.arrays
    activate_cell(field, np.int32(0))
    monkeypatch.setenv(ONLY, "library")
    with pytest.raises(TypeError, match=r"field\.px: expected a C-contiguous array f4\[:\]"):
        activate_cell(field._replace(px=field.px.astype(float)), 0)
    with pytest.raises(TypeError, match=r"field: expected \(counts, .*, got int"):
        activate_cell(3, 0)


def test_what_a_kernel_raises_is_raised() -> None:
    found = []
    for run in (drag_length, drag_length.jit):
        with pytest.raises(ZeroDivisionError) as error:
            run(1.0, 0.0, 0.0)
        found.append(str(error.value))
    assert found == ["division by zero"] * 2


def test_arrays_that_kernels_give_are_let_go() -> None:
    """A kernel's array is copied, and its block freed: the process does not grow."""
    import resource

    faces = np.tile(FACES, (25_000, 1))
    link_radial(faces, 4)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(60):
        link_radial(faces, 4)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 30_000


# -- never old code --------------------------------------------------------------------------------

KINDS = """
import sys
sys.path.insert(0, {root!r})
from paint3d.brush_engine.stroke_loop import paint_samples
from paint3d.mesh.kernels.topology import link_radial
from paint3d.colour.kernels.kubelka_munk import single_colours
kernels = (paint_samples, link_radial, single_colours)
print(*(type(kernel).__name__ for kernel in kernels), "numba" in sys.modules)
"""


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package, as a wheel lays it out, elsewhere."""
    root = tmp_path_factory.mktemp("copy")
    ignored = shutil.ignore_patterns("__pycache__", "data", "parts")
    shutil.copytree(ROOT / "paint3d", root / "paint3d", ignore=ignored)
    return root


def kinds(root: Path) -> list[str]:
    run = subprocess.run(
        [sys.executable, "-c", KINDS.format(root=os.fspath(root))],
        capture_output=True, text=True, check=True, cwd=root,
        env={k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", ONLY)},
    )  # fmt: skip
    return run.stdout.split()


def test_a_kernel_is_not_taken_where_a_source_that_it_was_made_from_has_changed(copy: Path) -> None:
    ahead, by_numba = "LibraryKernel", "DeferredKernel"
    assert kinds(copy) == [ahead, ahead, ahead, "False"]
    for changed, expected in (
        ("mesh/kernels/topology.py", [ahead, by_numba, ahead]),
        ("brush_engine/coverage.py", [by_numba, ahead, ahead]),  # called by paint_samples
        ("mesh/kernels/mesh_arrays.py", [by_numba, by_numba, ahead]),  # a tuple that it takes
        ("core/kernel.py", [by_numba] * 3),  # the decorators
    ):
        path = copy / "paint3d" / changed
        before = path.read_bytes()
        path.write_bytes(before + b"\n")
        assert kinds(copy) == [*expected, "False"], changed
        path.write_bytes(before)
    assert kinds(copy) == [ahead, ahead, ahead, "False"]


def test_a_library_that_cannot_be_loaded_is_told_and_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from paint3d.core import kernel_library

    index = json.loads((FOLDER / INDEX).read_text())
    for name in (INDEX, index["caller"]):
        shutil.copy(FOLDER / name, tmp_path)
    monkeypatch.setattr(kernel_library, "FOLDER", tmp_path)
    assert library.__wrapped__() is None
    (told,) = caplog.messages
    assert "cannot be used" in told
    (tmp_path / INDEX).write_text("{")
    assert library.__wrapped__() is None
    (tmp_path / INDEX).unlink()
    caplog.clear()
    assert library.__wrapped__() is None  # none is there: nothing to tell
    assert not caplog.messages


def test_no_code_is_taken_that_is_above_the_processor() -> None:
    index = json.loads((FOLDER / INDEX).read_text())
    code = dict.fromkeys(("x86-64-v5", "riscv64"), next(iter(index["code"].values())))
    with pytest.raises(LookupError, match="none for this processor"):
        Library(FOLDER, {**index, "code": code})


@pytest.mark.parametrize(
    ("machine", "has", "processor"),
    [
        ("x86_64", LEVEL_3, "x86-64-v3"),
        ("AMD64", {*LEVEL_3, "avx512f"}, "x86-64-v3"),
        ("x86_64", LEVEL_3 - {"avx2"}, "x86-64-v2"),
        ("x86_64", LEVEL_3 - {"sse4.2"}, ""),
        ("aarch64", {"neon"}, "aarch64"),
        ("arm64", set(), "aarch64"),
        ("riscv64", LEVEL_3, ""),
    ],
)
def test_the_kind_of_a_processor_is_told_by_what_it_has(machine, has, processor) -> None:
    assert processor_of(machine, has) == processor


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["x86-64-v3", "aarch64"], "expected processors of one architecture, x86_64 or aarch64"),
        (["riscv64"], "invalid choice: 'riscv64'"),
    ],
)
def test_what_no_library_can_be_for_is_said_in_a_line(words, said, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tools.kernels", "--into", tmp_path, "--for", *words],
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode != 0
    assert said in done.stderr.splitlines()[-1]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [[], ["--for", "own"]])
def test_a_machine_that_no_code_is_for_is_told(words, tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.setattr(kernels_command, "own_processor", lambda: "")
    monkeypatch.setattr(sys, "argv", ["tools.kernels", *words, "--into", os.fspath(tmp_path)])
    assert kernels_command.main() == 1
    assert "expected processors of one architecture" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_numba_compiles_for_the_processor_that_the_library_is_for(monkeypatch) -> None:
    from numba import config

    ahead = library()
    assert ahead is not None
    link_radial.jit  # noqa: B018  # numba is made ready
    index = json.loads((FOLDER / INDEX).read_text())
    assert ahead.processor in index["code"]
    assert llvm_name(made_for(ahead.processor, set())) == config.CPU_NAME


# -- nothing of numba ------------------------------------------------------------------------------

WITHOUT = """
import sys
sys.modules["numba"] = sys.modules["llvmlite"] = None  # not installed
from paint3d.cli.main import main
status = main(sys.argv[1:])
assert not any(name.startswith("numba.") for name in sys.modules)
sys.exit(status)
"""


def run_without(*words: object, home: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT, *map(str, words), "--quiet"],
        capture_output=True, text=True, check=False,
        env={
            **{k: v for k, v in os.environ.items() if not k.startswith(("NUMBA", "XDG"))},
            "HOME": os.fspath(home), ONLY: "library",
        },
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_without_library_and_numba_it_is_said_in_one_line_what_is_missing(
    copy: Path, tmp_path: Path
) -> None:
    machine_code = copy / "paint3d" / "core" / "machine_code"
    machine_code.rename(tmp_path / "elsewhere")
    try:
        done = subprocess.run(
            [sys.executable, "-c", WITHOUT, "demo", "--no-view", "--out", os.fspath(tmp_path)],
            capture_output=True, text=True, check=False, cwd=copy,
            env={k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", ONLY)},
        )  # fmt: skip
    finally:
        (tmp_path / "elsewhere").rename(machine_code)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()[-1:]
    assert line.startswith("paint3d: error: paint3d.")
    assert line.endswith("(pip install numba)")
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("hairs", [0, pytest.param(200, marks=pytest.mark.long)])
def test_a_character_is_written_replayed_and_exported_without_numba(
    hairs: int, tmp_path: Path
) -> None:
    first, again = tmp_path / "a.p3d", tmp_path / "b.ply"
    record = tmp_path / "a.jsonl"
    run_without(
        "write", "永", "--on", "bowl", "--size", 24, "--hairs", hairs, "--out", first,
        "--recording", record, home=tmp_path,
    )  # fmt: skip
    run_without("export", first, tmp_path / "a.ply", home=tmp_path)
    run_without("replay", record, "--on", "bowl", "--hairs", hairs, "--out", again, home=tmp_path)
    assert (tmp_path / "a.ply").stat().st_size > 100_000
    assert not list(tmp_path.rglob("*.nbi"))


def test_nothing_is_compiled_and_it_is_known_so() -> None:
    assert kernel.is_compiled(paint_samples)
    assert not kernel.is_compiled(corner_normals) or type(corner_normals) is not DeferredKernel


BY_ONE = """
import json, pathlib, sys
from paint3d.core import kernel_library
name, folder = sys.argv[1:]
kernel_library.FOLDER = pathlib.Path(folder)
from tests.golden.hashes import hashes_of
given = hashes_of(name)
compiler = sys.modules.get("numba")
cpu = compiler.config.CPU_NAME if compiler else kernel_library.library().processor
print(json.dumps([cpu, given]))
"""


OWN = ARCHITECTURES.get(platform.machine(), ())


@pytest.fixture(scope="module", params=OWN)
def level(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, Path]:
    """A kind of processor that this machine is, and the folder of a library that has no other."""
    if OWN.index(request.param) > OWN.index(own_processor()):
        pytest.skip("this machine is below that level")
    whole, folder = ROOT / "build" / "kernels" / "own", tmp_path_factory.mktemp("library")
    build([*OWN], whole)  # as for a wheel
    index = json.loads((whole / INDEX).read_text())
    index["code"] = {request.param: index["code"][request.param]}
    for name in (index["caller"], *index["code"].values()):
        shutil.copy(whole / name, folder)
    (folder / INDEX).write_text(json.dumps(index))
    return request.param, folder


@pytest.mark.long
@pytest.mark.timeout(7200)  # it compiles all, by the library and by numba; what it waits for ends
@pytest.mark.parametrize("name", ["demo", "hairs", "wet", "layers"])
def test_paintings_are_the_same_to_the_bit_by_the_library_and_by_numba(
    name: str, level: tuple[str, Path]
) -> None:
    """With an empty cache numba takes minutes for each level."""
    cpu, folder = level
    most, found = made_for(cpu, set()), []  # what most kernels of a library are made for
    for only in ("library", "numba"):
        done = subprocess.run(
            [sys.executable, "-c", BY_ONE, name, folder], capture_output=True, text=True,
            check=False, cwd=ROOT,
            env={**os.environ, ONLY: only, "NUMBA_CPU_NAME": most, "NUMBA_CPU_FEATURES": ""},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        found.append(json.loads(done.stdout.splitlines()[-1]))
    assert [by for by, _ in found] == [cpu, most]
    assert found[0][1] == found[1][1]
