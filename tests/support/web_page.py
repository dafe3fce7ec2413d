"""The studio as a page: its data decoded, its scripts built, its paintings and devices."""

from __future__ import annotations

import gzip
import hashlib
import json
import os
import shutil
import subprocess
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import hid_parser
import numpy as np
import pytest

from paint3d.core.arrays import AnyArray
from paint3d.surface.painted_surface import PaintedSurface
from tools.kernels.building import is_built

__all__ = [
    "as_a_browser_has_it",
    "built_page",
    "decoded_bundle",
    "hashes_of",
    "replay_script",
    "why_no_kernels",
]

WEB = Path(__file__).parents[2] / "web"


@cache
def why_no_kernels(folder: Path) -> str:
    """Why a page cannot be painted in; "" where its kernels are those of the sources."""
    if not (folder / "index.json").is_file():
        return "no kernels for a page: python -m tools.kernels --for wasm32"
    if not is_built(["wasm32"], folder):
        return "the page's kernels are those of other sources: python -m tools.kernels --for wasm32"
    return ""


def replay_script(folder: Path) -> Path:
    """The painter alone, for Node, built into a folder."""
    _run_vite("--config", "vite.replay.config.ts", "--outDir", os.fspath(folder))
    return folder / "replay.mjs"


def built_page(folder: Path) -> Path:
    """The page as `npm run build` makes it, in a folder."""
    _run_vite("--outDir", os.fspath(folder))
    return folder


def _run_vite(*words: str) -> None:
    if shutil.which("npx") is None or not (WEB / "node_modules" / "vite").is_dir():
        pytest.skip("what builds the page is not installed: npm ci, in web/")
    done = subprocess.run(
        ["npx", "vite", "build", *words], cwd=WEB, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def hashes_of(surface: PaintedSurface) -> dict[str, Any]:
    """Hash a painting as the page does."""
    arrays = {"srgb": surface.srgb, "amounts": surface.amounts, "coverage": surface.coverage}
    hashes = {
        name: hashlib.sha256(np.ascontiguousarray(array).tobytes()).hexdigest()
        for name, array in arrays.items()
    }
    return {"vertices": surface.n_vertices, **hashes}


def decoded_bundle(path: Path) -> tuple[dict[str, Any], dict[str, AnyArray]]:
    """Words and arrays of a file of the page, as its format says."""
    data = gzip.decompress(path.read_bytes())
    assert data[:8] == b"P3DPAGE1"
    head = json.loads(data[16 : 16 + int.from_bytes(data[8:12], "little")])
    arrays = {}
    for name, place in head["arrays"].items():
        dtype = np.dtype(f"<{place['kind']}") if place["kind"] != "b1" else np.dtype(bool)
        size, width = int(np.prod(place["shape"])), dtype.itemsize
        assert place["at"] % 16 == 0
        planes = np.frombuffer(data, np.uint8, size * width, place["at"])
        numbers = planes.reshape(width, size).T.copy().view(f"u{width}").reshape(size)
        for lag in place["lags"]:
            for start in range(lag):
                numbers[start::lag] = np.cumsum(numbers[start::lag], dtype=numbers.dtype)
        arrays[name] = numbers.view(dtype).reshape(place["shape"])
    return head["words"], arrays


# ---- Devices -------------------------------------------------------------------------------------


def as_a_browser_has_it(descriptor: bytes) -> list[dict[str, Any]]:
    """The collections of WebHID, by somebody else's parser: numbers alike stand in one item."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        parsed = hid_parser.ReportDescriptor(list(descriptor))
    reports = []
    for number in parsed.input_report_ids:
        items: list[dict[str, Any]] = []
        for one in parsed.get_input_items(number):
            usage = getattr(one, "usage", None)
            item = {
                "isConstant": usage is None, "isArray": False, "isRange": False,
                "reportSize": int(one.size), "reportCount": 1,
                "logicalMinimum": getattr(one, "logical_min", 0),
                "logicalMaximum": getattr(one, "logical_max", 0),
                "usages": [] if usage is None else [int(usage.page) << 16 | int(usage.usage)],
            }  # fmt: skip
            same = [key for key in item if key not in ("reportCount", "usages")]
            if items and all(items[-1][key] == item[key] for key in same):
                items[-1]["reportCount"] += 1
                items[-1]["usages"] += item["usages"]
            else:
                items.append(item)
        reports.append({"reportId": number, "items": items})
    return [{"usagePage": 1, "usage": 8, "type": 1, "children": [], "inputReports": reports}]
