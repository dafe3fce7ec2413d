"""Compile the kernels when a wheel is built, for every level of processor that it may meet."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

_TARGET = "paint3d/core/machine_code"
_TAG = "cp311-abi3-linux_x86_64"


def _path(root: str) -> str:
    """Where modules are found: here too, beside what the build was given."""
    return os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH"))))


class KernelsHook(BuildHookInterface):
    """Adds the library; where it cannot be built, the wheel is pure and numba compiles.

    A wheel with the library needs no numba. What it requires is said in pyproject.toml for all that
    may have to compile (the source archive, editable installs, pure wheels), and is taken out here:
    so a wheel never lacks it by mistake, whatever reads its requirements before it is built.
    """

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build what is stale, into a folder that stays."""
        if version == "editable":
            return  # scripts/install builds it, for this machine only
        folder = Path(self.root, "build", "kernels")
        words = ["--levels", "2", "3", "--into", os.fspath(folder)]
        run = subprocess.run(
            [sys.executable, "-m", "tools.kernels", *words],
            cwd=self.root,
            env={**os.environ, "PYTHONPATH": _path(self.root)},
            check=False,
        )
        if run.returncode:
            return  # it has said why
        index = json.loads((folder / "index.json").read_text("utf-8"))
        for name in ("index.json", index["caller"], *index["code"].values()):
            build_data["force_include"][os.fspath(folder / name)] = f"{_TARGET}/{name}"
        needs = self.metadata.core.dependencies
        (compiler,) = (need for need in needs if need.startswith("numba"))
        needs.remove(compiler)
        build_data["pure_python"] = False
        build_data["tag"] = _TAG
