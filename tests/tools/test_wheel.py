"""A wheel holds compiled kernels, or is not built; only where it is asked for is it pure."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("hatchling")
ROOT = Path(__file__).parents[2]
FOR = "PAINT3D_WHEEL_FOR"


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What is needed to build a wheel, with nothing compiled yet."""
    root = tmp_path_factory.mktemp("sources")
    ignored = shutil.ignore_patterns("__pycache__", "machine_code")
    for name in ("paint3d", "tools"):
        shutil.copytree(ROOT / name, root / name, ignore=ignored)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, root)
    (root / "meshes").symlink_to(ROOT / "meshes")
    return root


def build(sources: Path, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    without = {k: v for k, v in os.environ.items() if k not in (FOR, "PYTHONPATH")}
    return subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", os.fspath(folder)],
        cwd=sources, env={**without, **environment}, capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_without_gcc_there_is_no_wheel_and_it_says_what_to_do(sources: Path, tmp_path: Path):
    done = build(sources, tmp_path / "dist", PATH=os.fspath(tmp_path))
    assert done.returncode != 0
    assert "gcc is missing" in done.stderr
    assert "apt-get install gcc python3-dev" in done.stderr
    assert f"{FOR}=pure" in done.stderr
    assert not list(tmp_path.glob("dist/*.whl"))


def test_a_pure_wheel_is_built_where_it_is_asked_for_and_needs_numba(sources: Path, tmp_path: Path):
    done = build(sources, tmp_path, PATH=os.fspath(tmp_path), **{FOR: "pure"})
    assert done.returncode == 0, done.stderr
    (wheel,) = tmp_path.glob("*.whl")
    assert wheel.name.endswith("-py3-none-any.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (metadata,) = (name for name in names if name.endswith("/METADATA"))
        assert "\nRequires-Dist: numba" in archive.read(metadata).decode()
    assert not [name for name in names if "machine_code" in name]


def test_what_compiles_a_part_finds_packages_where_its_parent_does(sources: Path, tmp_path: Path):
    # pip shows a build its packages by a sitecustomize in PYTHONPATH. This one ends the compilers,
    # and so shows that they would have found them.
    (tmp_path / "sitecustomize.py").write_text(
        "import os, sys\n"
        "if '--part' in sys.orig_argv:\n"
        "    print('it looked here', file=sys.stderr, flush=True)\n"
        "    os._exit(1)\n"
    )
    done = build(sources, tmp_path / "dist", PYTHONPATH=os.fspath(tmp_path))
    assert done.returncode != 0
    assert "it looked here" in done.stderr
