"""numba's own functions, in the place of which others are put to compile kernels."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# In a process of its own: what it imports chooses a processor for numba.
ASK = """
import json
from tools.kernels.numba_inside import REPLACED, digest_of
print(json.dumps([name for name, digest in REPLACED.items() if digest_of(name) != digest]))
"""


def test_what_is_replaced_of_numba_is_what_it_was() -> None:
    """Which of numba's functions are to be read again, after a change of its version."""
    (pinned,) = re.findall(r'"numba==([\d.]+)"', (ROOT / "pyproject.toml").read_text("utf-8"))
    if version("numba") != pinned:
        pytest.skip(f"kernels are compiled by numba {pinned}")
    done = subprocess.run(
        [sys.executable, "-c", ASK], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == []


def test_nothing_else_reaches_into_numba() -> None:
    inner = re.compile(
        r"^\s*(?:from|import) numba(?:\.(?!extending\b|np\b|core\.errors\b)| import _)"
    )
    reached = {
        path.relative_to(ROOT).as_posix()
        for top in ("paint3d", "tools")
        for path in (ROOT / top).rglob("*.py")
        if any(inner.match(line) for line in path.read_text("utf-8").splitlines())
    }
    assert reached == {"tools/kernels/numba_inside.py"}
