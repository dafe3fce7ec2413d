"""Run the program from outside, as a user does, and small inputs for it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.examples import ALL
from tests.support.forked import COMMANDS, LIMIT_S, run_forked

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="session")
def paint3d() -> Run:
    """Run ``python -m paint3d`` with these arguments; keywords go into the environment.

    Most of a short command's time goes into starting Python and importing, so those that need no
    environment of their own are forked from a process that has done so; not with ``--long``.
    """

    def run(*arguments: object, cwd: Path | None = None, **environment: str):
        words = [str(word) for word in arguments]
        alone = words[:1] == ["write"] and words[-2:] == ["--processes", "1"]
        if (alone or COMMANDS.intersection(words[:1])) and not environment and not ALL:
            return run_forked(words, cwd)
        return subprocess.run(
            [sys.executable, "-m", "paint3d", *map(str, arguments)],
            capture_output=True,
            text=True,
            check=False,
            cwd=cwd,
            env={**os.environ, **environment},
            timeout=LIMIT_S,
        )

    return run


def header() -> dict:
    return {
        "format": "paint3d-recording",
        "version": 1,
        "brush": "full",
        "ink": "pine soot",
    }


def stroke_samples(n: int = 40) -> list[dict]:
    """A straight stroke along x, 40 mm long, on a plane at z = 0: pressed, held and lifted."""
    samples = []
    for i in range(n):
        t = i / (n - 1)
        samples.append(
            {
                "time_ns": i * 10_000_000,
                "position": [-20.0 + 40.0 * t, 2.0, 30.0],
                "orientation": [1.0, 0.0, 0.0, 0.0],
                "pressure": round(min(1.0, 5 * t, 5 * (1 - t)) * 0.4, 6),
            }
        )
    return samples


def write_lines(file: Path, lines: list[dict]) -> Path:
    file.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
    return file


@pytest.fixture
def lines() -> list[dict]:
    """The lines of a good recording, to be spoilt."""
    return [header(), *stroke_samples()]


@pytest.fixture
def save() -> Callable[[Path, list[dict]], Path]:
    """Write lines as a recording."""
    return write_lines


@pytest.fixture
def recording(tmp_path: Path, lines: list[dict]) -> Path:
    """A good recording."""
    return write_lines(tmp_path / "strokes.jsonl", lines)
