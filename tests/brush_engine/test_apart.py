"""Kernels that promise the compiler that their arrays lie apart: they do."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROMISES = re.compile(r"@uncounted\([^)]*\bapart=True[^)]*\)\ndef (\w+)\(")


def names_called(hairs: int) -> set[str]:
    """Names of the promising kernels that a stroke calls, of a solid tuft or of so many hairs."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-m", "tests.support.apart", str(hairs)],
        capture_output=True, text=True, cwd=ROOT, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


def promising() -> set[str]:
    """Full names of all kernels that promise it."""
    return {
        f"{'.'.join(path.relative_to(ROOT).with_suffix('').parts)}.{name}"
        for path in (ROOT / "paint3d").rglob("*.py")
        for name in PROMISES.findall(path.read_text("utf-8"))
    }


def test_arrays_that_kernels_promise_to_lie_apart_do() -> None:
    called = names_called(hairs=0)
    assert len(called) > 15
    assert called == {name for name in promising() if ".bristles." not in name}


@pytest.mark.long
def test_arrays_lie_apart_under_single_hairs_too() -> None:
    called = names_called(hairs=4)
    assert called >= {name for name in promising() if ".bristles." in name}
