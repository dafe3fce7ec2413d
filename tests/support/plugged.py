"""Running a program with virtual devices plugged in."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

SYSTEM_PYTHON = "/usr/bin/python3"
HOST = Path(__file__).with_name("virtual_hid.py")
ROOT = Path(__file__).parents[2]
_PROBE = "import gi; gi.require_version('UMockdev', '1.0'); from gi.repository import UMockdev"


@dataclass(frozen=True)
class Outcome:
    """The program's JSON output, its messages, and reports sent to each device."""

    said: object
    stdout: str
    stderr: str
    code: int
    written: list[list[bytes]]


@pytest.fixture(scope="session")
def umockdev() -> None:
    try:
        found = subprocess.run([SYSTEM_PYTHON, "-c", _PROBE], capture_output=True, check=False)
    except OSError:
        found = None
    if found is None or found.returncode != 0:
        pytest.skip("no umockdev: apt-get install umockdev gir1.2-umockdev-1.0 python3-gi")


@pytest.fixture
def plugged(umockdev, tmp_path):
    """Run Python code (or `paint3d` arguments) with virtual devices plugged in.

    With `interrupt`, Ctrl-C ends it once everything that the devices sent has been read.
    """

    def run(
        devices: list[dict],
        code: str | list[str],
        timeout: float = 240.0,
        interrupt: bool = False,
    ) -> Outcome:
        scenario = tmp_path / "scenario.json"
        scenario.write_text(json.dumps({"devices": devices, "interrupt": interrupt}))
        program = ["-c", code] if isinstance(code, str) else ["-m", "paint3d", *code]
        done = subprocess.run(
            [SYSTEM_PYTHON, str(HOST), str(scenario), sys.executable, "-W", "error", *program],
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
            cwd=tmp_path,
            env=dict(os.environ, PYTHONPATH=str(ROOT), PAINT3D_CONFIG=str(tmp_path / "config")),
        )
        lines = done.stdout.splitlines()
        host = [line for line in lines if line.startswith("HOST ")]
        assert host, done.stdout + done.stderr
        own = [line for line in lines if not line.startswith("HOST ")]
        said = json.loads(own[-1]) if isinstance(code, str) and own else None
        written = [[bytes.fromhex(data) for _, data in sent] for sent in json.loads(host[-1][5:])]
        return Outcome(said, "\n".join(own), done.stderr, done.returncode, written)

    return run


def device(vid: int, pid: int, name: str, descriptor: bytes, script: list, **more) -> dict:
    """Describe one device of a scenario."""
    return {
        "vid": vid,
        "pid": pid,
        "name": name,
        "descriptor": descriptor.hex(),
        "script": script,
        **more,
    }
