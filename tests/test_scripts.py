"""The scripts beside the package find what they import, though nothing else runs them."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[1] / "scripts"


def is_python(path: Path) -> bool:
    return path.is_file() and (
        path.suffix == ".py" or path.read_bytes()[:40].startswith(b"#!/usr/bin/env python")
    )


@pytest.mark.parametrize("name", sorted(p.name for p in SCRIPTS.iterdir() if is_python(p)))
def test_a_script_finds_what_it_imports(name: str, monkeypatch) -> None:
    monkeypatch.syspath_prepend(str(SCRIPTS))
    tree = ast.parse((SCRIPTS / name).read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if not isinstance(node, ast.ImportFrom) or node.module is None:
            continue
        if node.module.split(".")[0] not in {"paint3d", "tests", "scripts"}:
            continue
        module = importlib.import_module(node.module)
        for alias in node.names:
            if not hasattr(module, alias.name):
                importlib.import_module(f"{node.module}.{alias.name}")
