"""X displays for tests."""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import subprocess

import pytest

__all__ = ["start_screen"]


def start_screen(size: str) -> tuple[str, subprocess.Popen]:
    """Start a display of so many pixels ("1400x900") that ends with us: its name and process."""
    server = shutil.which("Xvfb")
    if server is None:
        pytest.skip("Xvfb is not installed")
    read, write = os.pipe()
    command = [server, "-displayfd", str(write), "-screen", "0", f"{size}x24", "-nolisten", "tcp"]
    process = subprocess.Popen(
        command, pass_fds=[write], stderr=subprocess.DEVNULL, preexec_fn=_end_with_us
    )
    os.close(write)
    with os.fdopen(read) as told:
        number = told.readline().strip()
    if not number:
        pytest.skip("Xvfb did not start")
    return f":{number}", process


def _end_with_us() -> None:
    """Ask the kernel to end this process with its parent (PR_SET_PDEATHSIG)."""
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)
