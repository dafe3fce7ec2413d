"""Without a home that can be written, things are kept in a folder that is the user's alone."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

import paint3d
from paint3d.app.model.persistence.settings import Settings, load_settings, save_settings
from paint3d.core import own_folders
from paint3d.core.numba_kernels import ONLY
from paint3d.core.own_folders import (
    config_folder,
    fallback_folder,
    find_home,
    private_folder,
    recovery_folder,
)
from paint3d.errors import ExportError

NOWHERE = "/proc"  # nothing can be made there, not even by root
KEPT = (
    "from paint3d.core.quaternion import compiled_turn; import numpy as np; "
    "compiled_turn(np.array([1.0, 0.0, 0.0, 0.0]), 1.0, 0.0, 0.0); "
    "print(compiled_turn.stats.cache_path, sum(compiled_turn.stats.cache_hits.values()))"
)


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder for temporary files, and no home."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setenv("HOME", NOWHERE)
    for name in ("PAINT3D_CONFIG", "PAINT3D_STATE", "XDG_CONFIG_HOME", "XDG_STATE_HOME",
                 "XDG_CACHE_HOME", "NUMBA_CACHE_DIR"):  # fmt: skip
        monkeypatch.delenv(name, raising=False)
    private_folder.cache_clear()
    yield folder
    private_folder.cache_clear()


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """The package where nobody can write beside its sources, root neither."""
    site = tmp_path / "site"
    shutil.copytree(
        Path(paint3d.__file__).parent,
        site / "paint3d",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    for folder in ("core", "brush_engine"):
        (site / "paint3d" / folder / "__pycache__").write_text("a file, in which nothing can lie")
    return site


def run(code: str, site: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": str(site), ONLY: "numba", **environment},
        capture_output=True, text=True, check=False, cwd=site,
    )  # fmt: skip


@pytest.mark.parametrize(
    "home",
    [
        pytest.param({"HOME": NOWHERE}, marks=pytest.mark.long),  # as in the next test
        pytest.param({"HOME": "~"}, marks=pytest.mark.long),
        {"HOME": "", "XDG_CACHE_HOME": ""},
    ],
)
def test_kernels_are_kept_without_a_home(home: dict, temporary: Path, installed: Path) -> None:
    own = temporary / f"paint3d-{os.geteuid()}"
    done = run(KEPT, installed, **home)
    assert done.returncode == 0, done.stderr
    folder, hits = done.stdout.split()
    kept = Path(folder)
    assert hits == "0"
    assert kept.parent == own / "numba"
    assert list(kept.glob("quaternion.compiled_turn-*.nbi"))
    assert stat.S_IMODE(own.stat().st_mode) == 0o700
    assert done.stderr.count("\n") == 1
    assert "NUMBA_CACHE_DIR names another folder" in done.stderr
    assert sorted(path.name for path in installed.iterdir()) == ["paint3d"]  # no folder ~ or numba
    assert run(KEPT, installed, **home).stdout.split() == [folder, "1"]


def test_processes_that_are_started_say_nothing_again(temporary: Path, installed: Path) -> None:
    where = (
        "from paint3d.core.quaternion import compiled_turn; print(compiled_turn.stats.cache_path)"
    )
    start = f"subprocess.run([sys.executable, '-c', {where!r}])"
    done = run(f"import subprocess, sys, paint3d.core.quaternion; {start}", installed)
    kept = Path(done.stdout.strip())
    assert kept.parent == temporary / f"paint3d-{os.geteuid()}" / "numba"
    assert done.stderr.count("\n") == 1


def test_with_nowhere_at_all_it_says_what_to_set(temporary: Path, installed: Path) -> None:
    code = "import tempfile; tempfile.tempdir = '/proc'; from paint3d.cli.main import main; "
    code += "import sys; sys.exit(main(['bench']))"
    done = run(code, installed)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "expected HOME or TMPDIR to name a folder that can" in done.stderr


def test_a_folder_that_others_made_or_can_enter_is_not_used(temporary: Path) -> None:
    own = temporary / f"paint3d-{os.geteuid()}"
    assert private_folder() == own
    assert private_folder() == own
    for spoil in (_opened, _linked, _a_file) + ((_given_away,) if os.geteuid() == 0 else ()):
        private_folder.cache_clear()
        spoil(own)
        other = private_folder()
        assert other != own, spoil.__name__
        assert other.parent == temporary
        assert stat.S_IMODE(other.lstat().st_mode) == 0o700


def _cleared(own: Path) -> None:
    if own.is_dir() and not own.is_symlink():
        own.rmdir()
    else:
        own.unlink(missing_ok=True)


def _opened(own: Path) -> None:
    own.chmod(0o770)


def _linked(own: Path) -> None:
    _cleared(own)
    (own.parent / "elsewhere").mkdir(mode=0o700)
    own.symlink_to(own.parent / "elsewhere")


def _a_file(own: Path) -> None:
    _cleared(own)
    own.write_text("")


def _given_away(own: Path) -> None:
    _cleared(own)
    own.mkdir(mode=0o700)
    os.chown(own, 12345, 12345)


def test_no_temporary_folder_is_told(monkeypatch: pytest.MonkeyPatch, temporary: Path) -> None:
    monkeypatch.setattr(tempfile, "tempdir", NOWHERE)
    with pytest.raises(ExportError, match="expected HOME or TMPDIR"):
        private_folder()


def test_a_user_whom_the_system_does_not_know_has_no_home(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(own_folders.Path, "home", unknown)
    assert own_folders.find_home() is None


@pytest.mark.parametrize("home", [NOWHERE, "~", "beside"])
def test_settings_and_paintings_are_kept_without_a_home(
    temporary: Path, monkeypatch: pytest.MonkeyPatch, home: str
) -> None:
    monkeypatch.setenv("HOME", home)
    own = temporary / f"paint3d-{os.geteuid()}"
    assert config_folder() == own / "config"
    assert recovery_folder() == own / "state" / "sittings"
    assert fallback_folder() == own
    save_settings(Settings(language="zh"))
    assert load_settings() == (Settings(language="zh"), None)
    assert find_home() == (Path(NOWHERE) if home == NOWHERE else None)


def test_settings_of_a_home_that_is_read_only_are_read(
    temporary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path / "home"
    monkeypatch.setenv("HOME", str(home))
    assert fallback_folder() is None
    save_settings(Settings(language="zh"))
    assert (home / ".config" / "paint3d" / "settings.json").is_file()
    monkeypatch.setattr("paint3d.core.own_folders.can_write", lambda folder: False)
    assert fallback_folder() == temporary / f"paint3d-{os.geteuid()}"
    assert load_settings()[0].language == "zh"
    save_settings(Settings(language="en"))
    assert load_settings()[0].language == "en"
