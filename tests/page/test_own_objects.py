"""Objects that somebody brings to the page: read, prepared and painted on as on the desktop."""

from __future__ import annotations

import hashlib
import json
import os
import struct
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from paint3d.app.model.score.playing import painted
from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError
from paint3d.files.load import read_mesh
from paint3d.mesh.likeness import digest_of
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.page.folder import KERNELS, PageObject, build_page
from paint3d.painter.painter import Painter
from paint3d.recording.score import load_score
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.web_page import hashes_of, replay_script, why_no_kernels

pytestmark = pytest.mark.skipif(bool(why_no_kernels(KERNELS)), reason=why_no_kernels(KERNELS))
MM = 0.8


def ball(radius: float = 30.0) -> trimesh.Trimesh:
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    mesh.apply_scale([1.0, 0.8, 0.7])
    return mesh


def coloured(mesh: trimesh.Trimesh) -> AnyArray:
    """Codes of vertices (V, 3) that change over the shape."""
    span = np.ptp(mesh.vertices, axis=0)
    return (255.0 * (mesh.vertices - mesh.bounds[0]) / span).astype(np.uint8)


def glb(path: Path) -> None:
    """Two parts, one moved, turned and mirrored, with colours, in metres and y up."""
    metres = ball()
    metres.apply_scale(1e-3)
    metres.visual.vertex_colors = np.column_stack(
        [coloured(metres), np.full(len(metres.vertices), 255)]
    )
    lid = trimesh.creation.cylinder(0.012, 0.01, sections=40)
    turned = trimesh.transformations.euler_matrix(0.3, 0.2, 0.1)
    turned[:3, 3] = (0.01, 0.05, 0.0)
    scene = trimesh.Scene(metres)
    scene.add_geometry(lid, transform=turned @ np.diag([-1.0, 1.2, 0.9, 1.0]))
    path.write_bytes(scene.export(file_type="glb"))


def packed_glb(path: Path, **changes: Any) -> None:
    """A ball whose triangles, and normals as octahedra, are packed by meshopt.

    `changes` are of how its places are.
    """
    packer = pytest.importorskip("meshoptimizer")
    mesh = ball(0.03)
    mesh.apply_transform(trimesh.transformations.euler_matrix(0.3, 0.2, 0.1))
    places, indices = mesh.vertices.astype("<f4"), mesh.faces.astype("<u4").ravel()
    x, y, z = mesh.vertex_normals.T / np.abs(mesh.vertex_normals).sum(axis=1)
    below = z < 0.0
    x, y = (
        np.where(below, (1.0 - np.abs(b)) * np.where(a < 0.0, -1.0, 1.0), a)
        for a, b in ((x, y), (y, x))
    )
    normals = np.rint(127.0 * np.column_stack([x, y, np.ones_like(x), np.zeros_like(x)]))
    normals = normals.astype(np.int8)
    n, m = len(places), len(indices)
    packed = [
        packer.encode_vertex_buffer(places, n, 12), packer.encode_index_buffer(indices, m, n),
        packer.encode_vertex_buffer(normals.view("<f4"), n, 4),
    ]  # fmt: skip
    hows: list[dict[str, Any]] = [
        {"byteStride": 12, "count": n, "mode": "ATTRIBUTES", **changes},
        {"byteStride": 4, "count": m, "mode": "TRIANGLES", "filter": "EXPONENTIAL"},  # has none
        {"byteStride": 4, "count": n, "mode": "ATTRIBUTES", "filter": "OCTAHEDRAL"},
    ]
    start, views = 0, []
    for data, how in zip(packed, hows, strict=True):
        where = {"buffer": 0, "byteOffset": start, "byteLength": len(data)}
        strided = {} if how["mode"] == "TRIANGLES" else {"byteStride": how["byteStride"]}
        size = int(how["count"]) * int(how["byteStride"])
        packing = {"extensions": {"EXT_meshopt_compression": where | how}}
        views.append({"buffer": 1, "byteLength": size, **strided, **packing})
        start += len(data)
    body = b"".join(packed)
    body += bytes(-len(body) % 4)
    document = {
        "asset": {"version": "2.0"}, "extensionsRequired": ["EXT_meshopt_compression"],
        "buffers": [{"byteLength": len(body)}, {"byteLength": 16 * n + 4 * m}],
        "bufferViews": views,
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": n},
            {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": m},
            {"bufferView": 2, "componentType": 5120, "type": "VEC3", "count": n,
             "normalized": True},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 2}, "indices": 1}]}],
        "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}],
    }  # fmt: skip
    words = json.dumps(document).encode()
    words += b" " * (-len(words) % 4)
    path.write_bytes(
        struct.pack("<4sIIII", b"glTF", 2, 28 + len(words) + len(body), len(words), 0x4E4F534A)
        + words + struct.pack("<II", len(body), 0x004E4942) + body
    )  # fmt: skip


def changed_packed_glb(**changes: Any) -> Callable[[Path], None]:
    return lambda path: packed_glb(path, **changes)


def obj(path: Path) -> None:
    """Polygons, one with inward corners, by numbers that count back, one of no area."""
    outline = [(0, 0), (60, 0), (60, 40), (30, 12), (0, 40)]
    n = len(outline)
    rows = [
        f"v {x - 30} {y - 20} {z} {0.2 + 0.1 * z} .5 {x / 60:g}" for z in (0, 6) for x, y in outline
    ]
    rows += ["# a comment", "g top", "usemtl clay", "mtllib clay.mtl", "l 1 2"]
    rows += ["f " + " ".join(f"{k - n}//1" for k in range(n)), "f 5 4 3 2 1"]
    rows += [
        f"f {k + 1} {(k + 1) % n + 1} {(k + 1) % n + 1 + n} \\\n {k + 1 + n}" for k in range(n)
    ]
    path.write_text("\n".join([*rows, "f 1 2 2"]) + "\n")


def ply(path: Path) -> None:
    """Colours, and normals that lean, too far to be believed on one side."""
    mesh = ball()
    mesh.visual.vertex_colors = coloured(mesh)
    normals = mesh.vertex_normals + np.where(
        mesh.vertices[:, :1] > 5.0, (2.0, 2.0, 0.0), (0.2, 0.0, 0.1)
    )
    mesh = trimesh.Trimesh(
        mesh.vertices, mesh.faces, vertex_colors=coloured(mesh),
        vertex_normals=normals / np.linalg.norm(normals, axis=1)[:, None], process=False,
    )  # fmt: skip
    path.write_bytes(mesh.export(file_type="ply", vertex_normal=True))


def ply_text(path: Path) -> None:
    """Quadrangles and strips, doubles, an unknown element, and lines that end as on Windows."""
    head = ["ply", "format ascii 1.0", "comment by hand", "element vertex 8", "property double x",
            "property double y", "property double z", "element face 2",
            "property list uchar int vertex_indices", "element tristrips 1",
            "property list int int vertex_indices", "element edge 1", "property int vertex1",
            "property int vertex2", "end_header"]  # fmt: skip
    corners = [
        f"{x} {y} {z}"
        for z in (0.0, 20.5)
        for x, y in ((-30, -20), (30, -20), (30, 20), (-30, 20.25))
    ]
    body = ["4 0 3 2 1", "4 4 5 6 7", "15 0 1 4 5 -1 1 2 5 6 -1 2 3 6 7 -1", "0 1"]
    path.write_bytes("\r\n".join([*head, *corners, *body, ""]).encode())


def stl(path: Path) -> None:
    path.write_bytes(ball().export(file_type="stl"))


def stl_text(path: Path) -> None:
    path.write_text(
        trimesh.creation.cylinder(25.0, 20.0, sections=50).export(file_type="stl_ascii")
    )


FILES: dict[str, Callable[[Path], None]] = {
    "two parts.glb": glb, "packed.glb": packed_glb, "plate.obj": obj, "ball.ply": ply,
    "block.ply": ply_text, "ball.STL": stl, "drum.stl": stl_text,
}  # fmt: skip
WANTED: dict[str, dict[str, str]] = {"drum.stl": {"unit": "in", "up": "-y"}}


def cut(make: Callable[[Path], None], keep: float) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        make(path)
        data = path.read_bytes()
        path.write_bytes(data[: int(keep * len(data))])

    return write


def text(words: str) -> Callable[[Path], None]:
    return lambda path: path.write_bytes(words.encode("latin-1"))


def damaged_glb(path: Path) -> None:
    """A document whose primitive has a number for its attributes."""
    document = (
        b'{"scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": 3}]}'
    )
    document += b" " * (-len(document) % 4)
    sizes = struct.pack("<4sIIII", b"glTF", 2, 20 + len(document), len(document), 0x4E4F534A)
    path.write_bytes(sizes + document)


def triangle_glb(**changes: dict[str, Any]) -> Callable[[Path], None]:
    """One triangle; `changes` are those of its rows, a part that is None is left out."""
    rows = {
        "accessors": {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        "bufferViews": {"buffer": 0, "byteOffset": 0, "byteLength": 36, "byteStride": 12},
        "buffers": {"byteLength": 36},
    }

    def write(path: Path) -> None:
        document: dict[str, Any] = {
            "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        }  # fmt: skip
        for name, row in rows.items():
            changed = row | changes.get(name, {})
            document[name] = [{key: one for key, one in changed.items() if one is not None}]
        words = json.dumps(document).encode()
        words += b" " * (-len(words) % 4)
        numbers = np.float32([[0, 0, 0], [20, 0, 0], [0, 20, 0]]).tobytes()
        head = struct.pack("<4sII", b"glTF", 2, 28 + len(words) + len(numbers))
        json_head = struct.pack("<II", len(words), 0x4E4F534A)
        path.write_bytes(
            head + json_head + words + struct.pack("<II", len(numbers), 0x004E4942) + numbers
        )

    return write


TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
PLY_HEAD = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
BROKEN: dict[str, Callable[[Path], None]] = {
    "cut.glb": cut(glb, 0.7), "cut.ply": cut(ply, 0.7), "cut.stl": cut(stl, 0.7),
    "cut text.stl": cut(stl_text, 0.7), "empty.obj": text(""), "points.ply": text(
        PLY_HEAD + "property float z\nelement face 0\nproperty list uchar int vertex_indices\n"
        "end_header\n0 0 0\n1 0 0\n0 1 0\n"),
    "no z.ply": text(PLY_HEAD + "end_header\n0 0\n1 0\n0 1\n"),
    "no number.obj": text("v 0 0 nought\n"),
    "nan.obj": text("v 0 nan 0\n" + TRIANGLE + "f 1 2 3\n"),
    "outside.obj": text(TRIANGLE + "f 1 2 4\n"), "zero.obj": text(TRIANGLE + "f 0 1 2\n"),
    "half.obj": text(TRIANGLE + "f 1 2 2.5\n"),
    "short.obj": text("v 0 0\n" + TRIANGLE + "f 1 2 3\n"),
    "tiny.stl": text("solid"), "no ply.ply": text("obj\n"),
    "header.ply": text("ply\nformat ascii 1.0\nelement vertex 1\nproperti float x\nend_header\n"),
    "far.obj": text("v 0 0 1e13\n" + TRIANGLE + "f 1 2 3\n"),
    "first.glb": text("glTF" + struct.pack("<II", 1, 12).decode("latin-1")),
    "car.fbx": text("Kaydara"),
    "damaged.glb": damaged_glb,
    "no length.glb": triangle_glb(bufferViews={"byteLength": None}),
    "length in words.glb": triangle_glb(bufferViews={"byteLength": "36"}),
    "negative.glb": triangle_glb(bufferViews={"byteOffset": -4}),
    "fraction.glb": triangle_glb(accessors={"count": 2.5}),
    "stride.glb": triangle_glb(bufferViews={"byteStride": -12}),
    "no count.glb": triangle_glb(accessors={"count": None}),
    "no buffer.glb": triangle_glb(bufferViews={"buffer": None}),
    "no end.glb": triangle_glb(buffers={"byteLength": None}),
    "inherited.glb": triangle_glb(accessors={"type": "constructor"}),
    "inherited.ply": text(PLY_HEAD.replace("float y", "constructor y") + "end_header\n"),
    "inherited format.ply": text(PLY_HEAD.replace("ascii", "toString") + "end_header\n"),
    "packed by hand.glb": changed_packed_glb(filter="BY HAND"),
    "packed somehow.glb": changed_packed_glb(mode="SOMEHOW"),
    "packed nowhere.glb": changed_packed_glb(byteOffset=1 << 20),
    "packed huge.glb": changed_packed_glb(byteStride=1 << 20),
    "thing.abc": text("?"), "nothing": text("?"),
}  # fmt: skip


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("files")
    for name, write in {**FILES, **BROKEN}.items():
        write(folder / name)
    return {name: folder / name for name in (*FILES, *BROKEN)}


def loaded(name: str, path: Path) -> tuple[TriangleMesh, list[str]]:
    reading = read_mesh(path, **WANTED.get(name, {}))
    return reading.mesh, list(map(str, reading.notes))


def score_on(name: str, mesh: TriangleMesh, path: Path) -> None:
    """Strokes over the top of an object: one, one on another layer, one that erases."""
    painter = Painter(PaintedSurface(mesh, 4.0), "zhongkai")
    (x0, y0, _), (x1, y1, high) = mesh.bounds
    ink, brush = {"pine soot": 1.0}, "zhongkai"
    rows: list[dict[str, Any]] = [{
        "format": "paint3d-recording", "version": 2, "object": name, "mesh": digest_of(mesh),
        "resolution_mm": MM, "material": "porcelain", "brush": brush, "ink": ink,
        "azimuth": "commanded", "space": "world",
        "units": {"position": "mm", "time": "ns", "force": "N"},
    }]  # fmt: skip
    start = 0
    for k, (share, tilt) in enumerate(((0.35, 0.0), (0.55, 25.0), (0.45, -20.0))):
        rows.append({"do": "dip", "ink": ink if k != 1 else {"cinnabar": 1.0}})
        rows.append({"do": "begin_stroke"} | ({"erase": True} if k == 2 else {}))
        y = y0 + share * (y1 - y0)
        ways = [(x0 + s * (x1 - x0), y, high) for s in (0.25, 0.5, 0.75)]
        part = painter.stroke(ways, pressure=(0.0, 0.5, 0.2, 0.6, 0.0), tilt=tilt)
        for sample in part.samples():
            row = {"time_ns": sample.time_ns + start, "position": list(sample.position)}
            row |= {
                "orientation": list(sample.orientation),
                "pressure": sample.pressure,
                "buttons": 0,
            }
            rows.append(row | {"contact": None if sample.contact is None else list(sample.contact)})
        rows.append({"do": "end_stroke"})
        start += 10_000_000_000
        if k == 0:
            rows.append({"do": "add_layer"})
    rows.append({"do": "set_opacity", "place": 1, "opacity": 0.6})
    path.write_text("\n".join(map(json.dumps, rows)) + "\n")


@pytest.fixture(scope="module")
def in_node(files: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the page's scripts read of the files, and paint on those that can be painted on."""
    folder = tmp_path_factory.mktemp("page")
    build_page(folder, [PageObject("a4", 4.0)], ["zhongkai"], ["pine soot", "cinnabar"], page=None,
               materials=["porcelain"])  # fmt: skip
    asked: list[tuple[str, dict[str, Any]]] = [
        (name, {"own": os.fspath(path), "wanted": WANTED.get(name, {})})
        for name, path in files.items()
    ]
    for name in FILES:
        score = folder / f"{name}.score.jsonl"
        score_on(name, loaded(name, files[name])[0], score)
        words = {"own": os.fspath(files[name]), "wanted": WANTED.get(name, {})}
        asked.append((f"{name}, painted", words | {"score": os.fspath(score)}))
    drum, spaced = files["drum.stl"], folder / "blank lines.stl"
    first, _, others = drum.read_text().partition("\n")
    spaced.write_text(first + "\r\n \t\n" * 300_000 + others)
    asked.append((spaced.name, {"own": os.fspath(spaced), "wanted": WANTED[drum.name]}))
    script = replay_script(tmp_path_factory.mktemp("replay"))
    done = subprocess.run(
        ["node", script, os.fspath(folder), *(json.dumps(words) for _, words in asked)],
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    results = map(json.loads, done.stdout.splitlines())
    found = {name: result for (name, _), result in zip(asked, results, strict=True)}
    return found | {"folder": folder}


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_read_as_on_the_desktop(
    name: str, files: dict[str, Path], in_node: dict[str, Any]
) -> None:
    mesh, notes = loaded(name, files[name])
    found = in_node[name]
    for key in ("vertices", "faces", "colours", "normals"):
        array = getattr(mesh, key)
        ours = (
            ""
            if array is None
            else hashlib.sha256(np.ascontiguousarray(array).tobytes()).hexdigest()
        )
        assert found[key] == ours, key
    assert found["digest"] == digest_of(mesh)
    assert found["notes"] == notes


def test_blank_lines_are_passed_over_in_a_time_that_grows_as_they_do(
    in_node: dict[str, Any],
) -> None:
    assert in_node["blank lines.stl"]["vertices"] == in_node["drum.stl"]["vertices"]


@pytest.mark.parametrize("name", FILES)
def test_what_is_painted_on_it_is_what_the_desktop_paints(
    name: str, files: dict[str, Path], in_node: dict[str, Any]
) -> None:
    score = load_score(in_node["folder"] / f"{name}.score.jsonl")
    surface = painted(score, loaded(name, files[name])[0]).surface
    hashes = hashes_of(surface)
    found = in_node[f"{name}, painted"]
    assert surface.n_vertices > len(surface.source.vertices)
    assert surface.painted.any()
    assert {key: found[key] for key in hashes} == hashes


@pytest.mark.parametrize("name", BROKEN)
def test_what_cannot_be_taken_is_refused_as_by_the_command_line(
    name: str, files: dict[str, Path], in_node: dict[str, Any]
) -> None:
    with pytest.raises(MeshError) as refusal:
        read_mesh(files[name])
    ours = str(refusal.value).partition(": ")[2].partition(" (--")[0]
    theirs = in_node[name]["refused"]
    suffixes = "expected one of "
    assert theirs.partition(suffixes)[0] == ours.partition(suffixes)[0]
