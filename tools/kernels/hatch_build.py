"""Compile the kernels when a wheel is built, for every kind of processor that it may meet.

The wheel is for this machine's architecture, or for that which ``PAINT3D_WHEEL_FOR`` names.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

_TARGET = "paint3d/core/machine_code"
_FOR = "PAINT3D_WHEEL_FOR"


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
        wanted = os.environ.get(_FOR, "own")
        folder = Path(self.root, "build", "kernels", wanted)
        words = ["--for", wanted, "--into", os.fspath(folder)]
        run = subprocess.run(
            [sys.executable, "-m", "tools.kernels", *words],
            cwd=self.root,
            env={**os.environ, "PYTHONPATH": _path(self.root)},
            check=False,
        )
        if run.returncode:
            if _FOR in os.environ:
                raise RuntimeError(f"no kernels for {wanted}, for which {_FOR} asks")
            return  # it has said why
        index = json.loads((folder / "index.json").read_text("utf-8"))
        for name in ("index.json", index["caller"], *index["code"].values()):
            build_data["force_include"][os.fspath(folder / name)] = f"{_TARGET}/{name}"
        needs = self.metadata.core.dependencies
        (compiler,) = (need for need in needs if need.startswith("numba"))
        needs.remove(compiler)
        build_data["pure_python"] = False
        build_data["tag"] = f"cp311-abi3-linux_{index['architecture']}"
