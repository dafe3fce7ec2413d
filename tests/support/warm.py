"""Imported once, by the process that commands are forked from: it has painted a stroke.

What painting needs is then imported, and its kernels are loaded, or compiled, for all of them.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from paint3d.cli.main import main
from tests.e2e.conftest import header, stroke_samples, write_lines
from tests.support.compiling import compile_each_kernel_once

compile_each_kernel_once()
with tempfile.TemporaryDirectory() as _folder:
    _strokes = write_lines(Path(_folder) / "strokes.jsonl", [header(), *stroke_samples()])
    _out = str(Path(_folder) / "painted.ply")
    assert main(["replay", str(_strokes), "--on", "plane", "--out", _out, "--quiet"]) == 0
