"""Print versions, the renderer and the number of devices, to paste into a bug report."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from functools import cache

from paint3d.cli.progress import ProgressBar
from paint3d.core.machine import usable_cores

__all__ = ["EXAMPLES", "add_arguments", "ask_python", "find_versions", "run"]

# ---- Versions ------------------------------------------------------------------------------------
# Versions of the program, of Python and of the packages that decide what is painted.


_PACKAGES = (
    "paint3d",
    "numpy",
    "scipy",
    "numba",
    "llvmlite",
    "trimesh",
    "open3d",
    "pyvista",
    "vtk",
    "colour-science",
    "hidapi",
)


def find_versions() -> dict[str, str]:
    """Return versions by name; a package that is absent is listed as ``not installed``."""
    import platform

    system = {"python": sys.version.split()[0], "system": platform.platform()}
    return system | {package: _version(package) for package in _PACKAGES}


@cache
def _version(package: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


# ---- The command ---------------------------------------------------------------------------------


EXAMPLES = """
paint3d report > report.txt
"""

# Asked in processes of their own: a broken driver then costs one line, not the report.
_ASK_RENDERER = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.Render()
said = [line.split(":  ", 1) for line in window.ReportCapabilities().splitlines()]
said = {words[0]: words[1] for words in said if len(words) == 2}
print(said["OpenGL renderer string"] + ", OpenGL " + said["OpenGL version string"])
"""
_ASK_DEVICES = "import hid; print(len(hid.enumerate()))"
_PATIENCE_S = 60


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options: none."""


def ask_python(code: str) -> str:
    """Return the last line that another Python process prints for this code, or why none."""
    try:
        answer = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", code],
            capture_output=True,
            text=True,
            timeout=_PATIENCE_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"unknown ({type(error).__name__})"
    lines = answer.stdout.strip().splitlines()
    if answer.returncode == 0 and lines:
        return lines[-1].strip()
    reasons = answer.stderr.strip().splitlines()
    return f"unknown ({reasons[-1] if reasons else f'exit status {answer.returncode}'})"


def run(options: argparse.Namespace) -> None:
    """Print the report to stdout, one ``name: value`` a line."""
    facts = find_versions()
    facts["cores"] = str(usable_cores())
    facts["display"] = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or "none"
    with ProgressBar("asking"):
        facts["renderer"] = ask_python(_ASK_RENDERER)
        facts["hid devices"] = ask_python(_ASK_DEVICES)
    width = max(map(len, facts))
    for name, value in facts.items():
        sys.stdout.write(f"{name:<{width}}  {value}\n")
