"""Compile catalogues and kernels when a wheel is built, for every processor that it may meet.

The wheel is for this machine's architecture, or for the one that ``PAINT3D_WHEEL_FOR`` names;
``PAINT3D_WHEEL_FOR=pure`` builds one without compiled kernels, for any machine.
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
_FAILED = f"""\
paint3d: the kernels could not be compiled, for the reason above; no wheel was built.
Kernels are compiled on Linux, on x86-64 and aarch64, by gcc with Python's headers. Where those are
missing, install them (Debian, Ubuntu: apt-get install gcc python3-dev) and try again.
On any other system, or to do without, set {_FOR}=pure: the wheel then holds no compiled
kernels, and numba compiles them when they are first used, which takes some minutes."""


class KernelsHook(BuildHookInterface):
    """Adds the library of compiled kernels, or fails; a wheel lacks it only where that is asked.

    What the studio says in other languages (`tools.texts`) is compiled beside its sources, also for
    an editable install.

    A wheel with the library needs no numba. What it requires is said in pyproject.toml for all that
    may have to compile (the source archive, editable installs, pure wheels), and is taken out here:
    so a wheel never lacks it by mistake, whatever reads its requirements before it is built.
    """

    def dependencies(self) -> list[str]:
        """List the packages to compile with; none for a pure wheel."""
        return [] if os.environ.get(_FOR) == "pure" else self.config["compiler"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build what is out of date, into a folder that is kept."""
        places = [self.root, os.environ.get("PYTHONPATH")]  # the latter is how pip gives packages
        surroundings = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, places))}
        words = [sys.executable, "-m", "tools.texts", "--compile"]
        subprocess.run(words, cwd=self.root, env=surroundings, check=True)
        if version == "editable":
            return  # scripts/install builds it, for this machine only
        wanted = os.environ.get(_FOR) or "own"
        if wanted == "pure":
            return
        folder = Path(self.root, "build", "kernels", wanted)
        words = ["--for", wanted, "--into", os.fspath(folder)]
        run = subprocess.run(
            [sys.executable, "-m", "tools.kernels", *words],
            cwd=self.root,
            env=surroundings,
            check=False,
        )
        if run.returncode:
            self.app.abort(_FAILED)
        index = json.loads((folder / "index.json").read_text("utf-8"))
        for name in ("index.json", index["caller"], *index["code"].values()):
            build_data["force_include"][os.fspath(folder / name)] = f"{_TARGET}/{name}"
        needs = self.metadata.core.dependencies
        (compiler,) = (need for need in needs if need.startswith("numba"))
        needs.remove(compiler)
        build_data["pure_python"] = False
        build_data["tag"] = f"cp311-abi3-linux_{index['architecture']}"
