"""Kernels for WebAssembly: a module that Node runs, which gives the library's bytes."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from paint3d.colour.kernels.kubelka_munk import layer_bands
from paint3d.mesh.kernels.topology import link_radial, measure_faces
from tools.kernels import building
from tools.kernels.building import BuildError, link_wasm, parts

ROOT = Path(__file__).parents[2]
FACES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], np.int32)
POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.3, 0.9]], np.float32)
SYMBOLS = {
    "radial": "paint3d_mesh_kernels_topology_link_radial_0",
    "measures": "paint3d_mesh_kernels_topology_measure_faces_0",
    "bands": "paint3d_colour_kernels_kubelka_munk_layer_bands_0",
    "drag": "paint3d_brush_engine_drag_drag_length_0",
}
needs_zig = pytest.mark.skipif(
    importlib.util.find_spec("ziglang") is None, reason="pip install 'paint3d[page]': no ziglang"
)
needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="Node is not installed")

COMPILE = """
import pathlib, sys
from tools.kernels.building import parts
from tools.kernels.part import compile_part
symbols = set(sys.argv[2:])
some = {s: e for part in parts("wasm32") for group in part.groups for s, e in group.items()}
compile_part([{s: some[s] for s in symbols}], ["wasm32"], pathlib.Path(sys.argv[1]), lambda: None)
"""
RUN = """
import { readFileSync } from "node:fs";
const asked = JSON.parse(readFileSync(0, "utf-8"));
const { instance } = await WebAssembly.instantiate(readFileSync(asked.module), {});
const { memory, malloc, paint3d_release: release, _initialize, ...kernels } = instance.exports;
_initialize();
const put = (values, Type) => {
  const at = malloc(values.length * Type.BYTES_PER_ELEMENT);
  new Type(memory.buffer, at, values.length).set(values);
  return at;
};
const [to, from] = [malloc(512), malloc(512)];
const call = (symbol, takes) => {
  new BigInt64Array(memory.buffer, to, takes.length).set(takes.map(BigInt));
  return [kernels[symbol](to, from), new BigInt64Array(memory.buffer, from, 16).slice()];
};
const said = {};
const faces = put(asked.faces, Int32Array), n = asked.faces.length / 3;
const [status, [data, length, block]] = call(asked.symbols.radial, [faces, n, 3, 4]);
said.radial = [status, ...new Int32Array(memory.buffer, Number(data), Number(length))];
release(Number(block));
const rows = asked.bands.map((row) => put(row, Float64Array));
said.status = call(asked.symbols.bands, rows.flatMap((at) => [at, asked.bands[0].length]))[0];
said.bands = rows.map((at) => Buffer.from(memory.buffer, at, 8 * asked.bands[0].length)
  .toString("hex"));
const points = put(asked.points, Float32Array), normals = put(asked.points, Float32Array);
const areas = put([0, 0, 0, 0], Float64Array);
call(asked.symbols.measures, [points, 4, 3, faces, n, 3, normals, n, 3, areas, n]);
said.measures = [[normals, 12 * n], [areas, 8 * n]].map(([at, size]) =>
  Buffer.from(memory.buffer, at, size).toString("hex"));
said.drag = call(asked.symbols.drag, [0, 0, 0])[0];
const before = memory.buffer.byteLength;
for (let k = 0; k < 100000; k++)
  release(Number(call(asked.symbols.radial, [faces, n, 3, 4])[1][2]));
said.grown = memory.buffer.byteLength - before;
said.imports = WebAssembly.Module.imports(new WebAssembly.Module(readFileSync(asked.module)));
process.stdout.write(JSON.stringify(said));
"""


@pytest.fixture(scope="module")
def module(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three kernels, compiled and linked."""
    folder = tmp_path_factory.mktemp("wasm")
    subprocess.run(
        [sys.executable, "-c", COMPILE, folder, *SYMBOLS.values()],
        cwd=ROOT, check=True, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
    )  # fmt: skip
    return folder / link_wasm([*folder.glob("*.o")], [folder], folder)


@pytest.fixture(scope="module")
def said(module: Path) -> dict[str, Any]:
    """What Node says of it."""
    bands = np.random.default_rng(3).uniform(0.01, 0.9, (7, 36)).tolist()
    asked = {"module": os.fspath(module), "symbols": SYMBOLS, "faces": FACES.ravel().tolist(),
             "points": POINTS.ravel().tolist(),
             "bands": bands}  # fmt: skip
    done = subprocess.run(
        ["node", "--input-type=module", "--eval", RUN],
        input=json.dumps(asked), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@needs_zig
@needs_node
def test_kernels_give_the_bytes_of_the_library(said: dict[str, Any]) -> None:
    assert said["radial"] == [0, *link_radial(FACES, 4).tolist()]
    normals, areas = np.empty((4, 3), np.float32), np.empty(4)
    measure_faces(POINTS, FACES, normals, areas)
    assert said["measures"] == [normals.tobytes().hex(), areas.tobytes().hex()]


@needs_zig
@needs_node
def test_what_a_c_library_computes_differs_in_last_bits_at_most(said: dict[str, Any]) -> None:
    rows = np.random.default_rng(3).uniform(0.01, 0.9, (7, 36))
    layer_bands(*rows)
    assert said["status"] == 0
    found = [np.frombuffer(bytes.fromhex(row)) for row in said["bands"]]
    np.testing.assert_allclose(found, rows, rtol=1e-14, atol=0.0)


@needs_zig
@needs_node
def test_what_a_kernel_raises_is_told_and_its_arrays_are_let_go(said: dict[str, Any]) -> None:
    assert said["drag"] > 0  # a division by zero
    assert said["grown"] < 1 << 20


@needs_zig
@needs_node
def test_the_module_asks_for_nothing(said: dict[str, Any]) -> None:
    assert said["imports"] == []


def test_a_page_has_the_kernels_that_paint_and_no_others() -> None:
    rooms = {e.module.split(".")[0] for p in parts("wasm32") for g in p.groups for e in g.values()}
    assert rooms == {"brush_engine", "colour", "mesh", "pose", "surface"}


def test_without_zig_it_is_said_what_to_install(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(building.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(BuildError, match=r"ziglang is missing: pip install 'paint3d\[page\]'"):
        link_wasm([], [], tmp_path)
