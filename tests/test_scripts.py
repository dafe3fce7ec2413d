"""The scripts beside the package find what they import, though nothing else runs them."""

from __future__ import annotations

import ast
import contextlib
import importlib
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[1] / "scripts"


def is_python(path: Path) -> bool:
    return path.is_file() and (
        path.suffix == ".py" or path.read_bytes()[:40].startswith(b"#!/usr/bin/env python")
    )


@pytest.mark.parametrize("name", sorted(p.name for p in SCRIPTS.iterdir() if is_python(p)))
def test_a_script_finds_what_it_imports(name: str, monkeypatch) -> None:
    monkeypatch.syspath_prepend(str(SCRIPTS))
    tree = ast.parse((SCRIPTS / name).read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if not isinstance(node, ast.ImportFrom) or node.module is None:
            continue
        if node.module.split(".")[0] not in {"paint3d", "tests", "scripts"}:
            continue
        module = importlib.import_module(node.module)
        for alias in node.names:
            if not hasattr(module, alias.name):
                importlib.import_module(f"{node.module}.{alias.name}")


# -- scripts/install, with stand-ins for the machine --------------------------------------------

DPKG = """[ -e "$0.$4" ] || exit 1
printf installed
"""
APT = """echo "$1 ${*:5}" >> "$0.log"
case "$*" in update*) exit 0;; *"$(cat "$0.lacks")"*) exit 100;; esac
for name in "$@"; do touch "${0%/*}/dpkg-query.$name"; done
"""
PYTHON = """case "$2" in
    tools.texts) echo texts >> "${0%/*}/log";;
    tools.kernels) echo kernels >> "${0%/*}/log"; [ ! -e "$0.slow" ] || exec sleep 300;;
    pip) [ "$3" != install ] || echo "pip ${*:4}" >> "${0%/*}/log";;
    *) exit 1;;
esac
"""
UV = """echo "uv $*" >> "${0%/*}/log"
case "$*" in
    *"$(cat "$0.fails" 2>/dev/null || echo nothing)"*) exit 1;;
    *"-e .[test]"*) # is not done before kernels are begun with
        for _ in {1..600}; do ! grep -q kernels "${0%/*}/log" || exit 0; sleep .05; done
        exit 1;;
esac
"""
INTERRUPTED_UV = {
    name: f"""case "$*" in *"-e .[test]"*)
    {answer}
    echo "uv waits" >> "${{0%/*}}/log"
    for _ in {{1..6000}}; do sleep .05; done;;
esac
"""
    for name, answer in {
        "dies": ":", "says no": "trap 'exit 1' INT", "is done": "trap 'exit 0' INT",
    }.items()
}  # fmt: skip


class Machine:
    """A machine whose package manager and Python are stand-ins that note what they are asked."""

    def __init__(self, root: Path) -> None:
        self.tools, self.venv = root / "tools", root / "venv"
        (self.venv / "bin").mkdir(parents=True)
        self.tools.mkdir()
        for path, code in {
            self.tools / "dpkg-query": DPKG,
            self.tools / "apt-get": APT,
            self.tools / "sudo": '"$@"\n',
            self.venv / "bin" / "python": PYTHON,
            self.venv / "bin" / "uv": UV,
        }.items():
            path.write_text(f"#!/bin/bash\n{code}")
            path.chmod(0o755)
        wanted = f"{SCRIPTS.parent}\n{(SCRIPTS.parent / 'pyproject.toml').read_text()}"
        (self.venv / "paint3d-installed").write_text(wanted)

    def install_packages(self, fails: str | None = None) -> list[str]:
        """What Python and uv are asked for where no package is there; uv cannot do what `fails`."""
        (self.venv / "paint3d-installed").unlink()
        if fails:
            (self.venv / "bin" / "uv.fails").write_text(fails)
        status, said, _ = self.install()
        assert status == 0, said
        assert ("with pip" in said) == bool(fails)
        return (self.venv / "bin" / "log").read_text().splitlines()

    def install(self, lacks: str = "nothing") -> tuple[int, str, list[str]]:
        """Its exit status, its messages, and what apt-get was asked for; apt knows no `lacks`."""
        log, begun = self.tools / "apt-get.log", self.begin(lacks)
        said, _ = begun.communicate()
        return begun.returncode, said, log.read_text().splitlines()

    def begin(self, lacks: str = "nothing") -> subprocess.Popen[str]:
        """Begin to install, as from a terminal; apt knows no `lacks`."""
        (self.tools / "apt-get.log").write_text("")
        (self.tools / "apt-get.lacks").write_text(lacks)
        path = f"{self.tools}{os.pathsep}{os.environ['PATH']}"
        return subprocess.Popen(
            [SCRIPTS / "install"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env={**os.environ, "PATH": path, "PAINT3D_VENV": str(self.venv)},
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )  # fmt: skip


def test_what_is_missing_is_installed_at_once_and_once(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    status, said, asked = machine.install()
    assert status == 0, said
    assert len(asked) == 2
    assert asked[0].startswith("update")
    assert "libegl1" in asked[1]
    assert "xvfb" in asked[1]
    assert machine.install() == (0, f"install: ready in {machine.venv}\n", [])


def test_without_what_only_tests_need_the_program_is_installed(tmp_path: Path) -> None:
    status, said, asked = Machine(tmp_path).install(lacks="umockdev")
    assert status == 0, said
    assert "will be skipped" in said
    assert "libegl1" in asked[-1]
    assert "xvfb" not in asked[-1]


def test_without_what_the_program_needs_it_ends_in_a_line_that_says_so(tmp_path: Path) -> None:
    status, said, _ = Machine(tmp_path).install(lacks="libegl1")
    assert status == 2
    assert "error: could not install libgl1 libegl1" in said
    assert said.splitlines()[-1].startswith("install: error: the system libraries are not there")


def test_kernels_are_compiled_while_packages_are_loaded(tmp_path: Path) -> None:
    asked = Machine(tmp_path).install_packages()
    choose, compiler, all_of = (line for line in asked if line.startswith("uv"))
    chosen = f"{tmp_path}/venv/chosen.txt"
    assert choose.startswith("uv pip compile")
    assert choose.endswith(f"pyproject.toml --extra test --output-file {chosen}")
    assert compiler.endswith(f"--constraints {chosen} numba numpy scipy lazy-loader")
    assert all_of.endswith(f"--constraints {chosen} -e .[test]")
    assert asked.count("kernels") == asked.count("texts") == 1


@pytest.mark.parametrize("step", ["pip compile", "numba numpy scipy lazy-loader", "-e .[test]"])
def test_where_uv_fails_pip_installs_and_kernels_are_compiled_last(tmp_path: Path, step) -> None:
    asked = Machine(tmp_path).install_packages(fails=step)
    pip = "pip --quiet --disable-pip-version-check -e .[test]"
    assert asked[-3:] == [pip, "texts", "kernels"]


@pytest.mark.parametrize("answer", ["dies", "says no", "is done"])
def test_ctrl_c_ends_all_whatever_uv_answers_to_it(tmp_path: Path, answer: str) -> None:
    machine = Machine(tmp_path)
    log = machine.venv / "bin" / "log"
    (machine.venv / "paint3d-installed").unlink()
    (machine.venv / "bin" / "python.slow").touch()
    (machine.venv / "bin" / "uv").write_text(f"#!/bin/bash\n{INTERRUPTED_UV[answer]}")
    begun = machine.begin()
    while not log.exists() or not {"kernels", "uv waits"} <= set(log.read_text().splitlines()):
        time.sleep(0.01)
    os.killpg(begun.pid, signal.SIGINT)
    try:
        begun.communicate(timeout=300.0)  # to the last process that could say something
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(begun.pid, signal.SIGKILL)
    assert begun.returncode == -signal.SIGINT
    assert "pip --quiet --disable-pip-version-check -e .[test]" not in log.read_text()
