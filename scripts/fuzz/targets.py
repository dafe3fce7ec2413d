"""Targets of the fuzzer: for each kind of file good ones to start from, and the reader.

A target that is not about a file takes bytes all the same: see `Target.check`.
"""

from __future__ import annotations

import contextlib
import dataclasses
import gzip
import json
import math
import random
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scripts.fuzz.copied import COPIED
from scripts.fuzz.drawings import DRAWINGS
from scripts.fuzz.lettering import LETTERING
from scripts.fuzz.mutation import damage, damage_archive
from scripts.fuzz.packed import PACKED, check_mesh
from scripts.fuzz.parameters import PARAMETERS
from scripts.fuzz.target import Target, file_of, written

__all__ = ["TARGETS", "Target"]

# -- recordings -----------------------------------------------------------------------------------


_DIPS: dict[str, Any] = {
    "parts": {"pine soot": 0.2, "water": 0.8},
    "tip": "cinnabar",
    "reach": 0.3,
    "dip": {"wetted": 0.6, "fullness": 0.9},
    "loads": [[1_000_000, 0.5], [3_000_000, 0.9]],
    "azimuth": "dragged",
    "characters": [{"text": "a", "frame": {"origin": [0, 0, 0], "em_mm": 20.0}}],
}


def _recording(space: str = "world", **told: Any):
    from paint3d.device.recorded import Recording

    n = 6
    ramp = np.linspace(0.0, 1.0, n)
    return Recording(
        np.arange(n) * 1_000_000,
        np.column_stack([ramp, 2 * ramp, 30 * (ramp == 0)]),
        np.tile([0.8, 0.0, 0.6, 0.0], (n, 1)),
        np.where(ramp > 0, 0.5, 0.0),
        np.arange(n) % 3,
        header={"space": space, "brush": "full", "ink": "pine soot", **told},
    )


def _recording_seeds() -> list[tuple[str, bytes]]:
    from paint3d.recording.recording import save_recording

    saved = [written(s, partial(save_recording, _recording())) for s in (".jsonl", ".csv")]
    table = b"0.00 10 20 0.1\n0.01 11 20.5 0.2\n0.02 12 21 0.3\n"
    named = b"timestamp,spline_x,spline_y,pressure,altitude,azimuth,stroke_id\n"
    named += b"0,1,2,0.5,1.2,0.3,1\n8,2,3,0.6,1.2,0.3,1\n16,9,9,0.5,1.1,0.2,2\n"
    return [
        *saved,
        (".txt", table),
        (".csv", named),
        (".jsonl.gz", gzip.compress(saved[0][1], mtime=0)),
        written(".jsonl", partial(save_recording, _recording(**_DIPS))),
        written(".jsonl", partial(save_recording, _recording(**{**_DIPS, "parts": {}}))),
    ]


def _inkml_seeds() -> list[tuple[str, bytes]]:
    from paint3d.recording.recording import save_recording

    made = written(".inkml", lambda path: save_recording(_recording("pad"), path))
    plain = (
        b'<ink xmlns="http://www.w3.org/2003/InkML"><traceFormat>'
        b'<channel name="X" type="decimal" units="mm"/><channel name="Y" orientation="-ve"/>'
        b'<channel name="F" min="0" max="1023"/><intermittentChannels><channel name="OE"/>'
        b"</intermittentChannels></traceFormat>"
        b"<trace>1 2 3 4, 2 3 4 5,'1'2\"3!4</trace><trace>5 6 7</trace></ink>"
    )
    office = (
        b'<ink><definitions><inkSource xml:id="s"><traceFormat><channel name="X" type="integer" '
        b'units="cm"/><channel name="Y" units="dev"/></traceFormat><channelProperties>'
        b'<channelProperty channel="X" name="resolution" value="1000" units="1/cm"/>'
        b'<channelProperty channel="Y" name="resolution" value="500" units="1/in"/>'
        b'</channelProperties></inkSource><context xml:id="a" inkSourceRef="#s"/>'
        b'<context xml:id="b" contextRef="#a"/></definitions><traceGroup contextRef="#b">'
        b'<trace>1 2, 30 4</trace><trace type="penUp" contextRef="#a">5 6</trace></traceGroup>'
        b"</ink>"
    )
    timed = (
        b'<ink><definitions><timestamp xml:id="t" time="9" timeOffset="1"/><context xml:id="c" '
        b'timestampRef="#t"/></definitions><inkSource><sampleRate value="200"/><traceFormat>'
        b'<channel name="X" units="mm" orientation="-ve"/><channel name="Y" units="mm"/><channel '
        b'name="OTx" units="deg"/><channel name="OTy" units="deg"/><intermittentChannels><channel '
        b'name="F" default="1"/></intermittentChannels></traceFormat></inkSource><trace xml:id="a" '
        b'continuation="begin" timeOffset="3" contextRef="#c">1 2 3 4,\'5\'6 * #1F .5</trace>'
        b'<trace priorRef="#a" duration="8" timeOffset="20">9 9 ? T F,"1"2 1 1</trace></ink>'
    )
    moved = (
        b'<ink><definitions><mapping xml:id="m" type="affine"><bind source="Y" target="X"/><bind '
        b'source="X" target="Y"/><matrix>2 0 10, 0 -3 5</matrix></mapping><canvas xml:id="v">'
        b'<traceFormat><channel name="X" units="cm"/><channel name="Y" orientation="-ve"/>'
        b'</traceFormat></canvas><canvasTransform xml:id="t"><mapping mappingRef="#m"/>'
        b'</canvasTransform><context xml:id="c" canvasRef="#v" canvasTransformRef="#t"/>'
        b'</definitions><trace contextRef="#c">1 2, 3 4, 8 9</trace></ink>'
    )
    seeds = (plain, office, timed, moved)
    return [made, *((".inkml", seed) for seed in seeds)]


def _check_recording(suffix: str, content: bytes) -> None:
    from paint3d.painter.recorded_tools import (
        changes_at,
        recorded_amount,
        recorded_brush,
        recorded_ink,
        recorded_tip,
    )
    from paint3d.recording.recording import load_recording

    recording = load_recording(file_of(suffix, content))
    assert len(recording) > 0
    assert np.isfinite(recording.position).all()
    assert (np.diff(recording.time_ns) > 0).all()
    assert recording.pressure is None or (np.abs(recording.pressure - 0.5) <= 0.5).all()
    recorded_brush(recording.header)
    tip = recorded_tip(recording.header)
    assert tip is None or 0.0 <= tip[1] <= 1.0
    recorded_ink(recording.header)
    assert math.isfinite(recorded_amount(recording.header).fullness)
    for told in changes_at(recording.header, recording.time_ns):
        assert all(k < len(recording) and 0.0 <= share <= 1.0 for k, share in told)


# -- meshes ---------------------------------------------------------------------------------------

SIZE = 7.9  # mm, one of the lengths that metres in float32 do not give back by themselves
CORNERS = np.array([[x, y, z] for x in (0, SIZE) for y in (0, SIZE) for z in (0, SIZE)], np.float32)
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
FACES = np.array([face for a, b, c, d in QUADS for face in ([a, b, c], [a, c, d])], np.int32)
STEP = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def _mesh_seeds() -> list[tuple[str, bytes]]:
    from paint3d.files.export import export
    from paint3d.mesh.triangle_mesh import TriangleMesh

    codes = (np.arange(24).reshape(8, 3) * 10).astype(np.uint8)
    mesh = TriangleMesh(CORNERS, FACES, codes)
    made = [written(s, partial(export, mesh)) for s in (".ply", ".obj", ".glb", ".3mf")]
    rows = "\n".join(" ".join(map(str, row)) for row in CORNERS.tolist())
    polygons = "\n".join(f"4 {a} {b} {c} {d}" for a, b, c, d in QUADS)
    header = "ply\nformat ascii 1.0\ncomment a box\nelement vertex 8\nproperty float x\n"
    header += "property float y\nproperty float z\nelement face 6\n"
    header += "property list uchar int vertex_indices\nend_header\n"
    triangles = np.zeros(len(FACES), STEP)
    triangles["corners"] = CORNERS[FACES]
    stl = b"a box".ljust(80) + len(FACES).to_bytes(4, "little") + triangles.tobytes()
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    relative = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nvt 0 1\nmtllib a.mtl\nusemtl a\n"
    return [
        *made,
        (".ply", f"{header}{rows}\n{polygons}\n".encode()),
        (".off", f"OFF\n8 6 12\n{rows}\n{polygons}\n".encode()),
        (".stl", stl),
        (".stl", f"solid a\n{facet}endloop\nendfacet\nendsolid\n".encode()),
        (".obj", f"{relative}f -3/1 -2/1 -1/-1\nf 1//2 2//1 3//3\nl 1 2\n".encode()),
        (".gltf", _gltf()),
        *_odd_meshes(rows),
        *_coloured_meshes(rows, triangles),
    ]


def _odd_meshes(rows: str) -> list[tuple[str, bytes]]:
    """Strips, pictures, colours of faces and of corners, inward corners, lines that go on."""
    place = "property float x\nproperty float y\nproperty float z\n"
    colour = "property float red\nproperty float green\nproperty float blue\n"
    start = "ply\nformat ascii 1.0\nmade by hand\ncomment TextureFile none.png\n"
    strips = f"{start}element vertex 8\n{place}element tristrips 1\n"
    strips += f"property list int int vertex_indices\nend_header\n{rows}\n7 0 1 2 3 -1 4 5\n"
    faces = f"{start}element vertex 8\n{place}element face 2\n"
    faces += "property list uchar int vertex_indices\nproperty list uchar float texcoord\n"
    faces += f"property int texnumber\n{colour}end_header\n{rows}\n"
    faces += "3 0 1 2 6 0 0 1 0 0 1 0 1 0 .5\n3 2 1 3 0 0 nan 0 7\n"
    slot = "v 0 0 0 nan 0 0\nv 9 0 0 1 0 0\nv 9 9 0 2 0 0\nv 5 9 0 1 1 1\nv 5 1 0 0 0 0\n"
    return [
        (".ply", strips.encode()),
        (".ply", faces.replace(" TextureFile none.png", "").encode()),
        (".ply", faces.encode()),
        (
            ".obj",
            f"{slot}v 4 1 0 0 0 0\nv 4 9 0 1 1 1\nv 0 9 0 1 1 1\nf 1 2 3 4 5 6 7 8\n".encode(),
        ),
        (
            ".off",
            f"COFF8 2 0\n{rows.replace(chr(10), ' 255 0 0 ')} 1 2 3\n3 0\n1 2\n3 2 1 3".encode(),
        ),
        (".3mf", _pictured_3mf()),
    ]


def _coloured_meshes(rows: str, triangles: NDArray[np.void]) -> list[tuple[str, bytes]]:
    """Colours as sculptors, slicers, scanners and splats have them."""
    triangles = triangles.copy()
    triangles["attribute"] = np.arange(len(triangles)) * 2731 % 65536
    stl = b"COLOR=\1\2\3\4".ljust(80) + len(triangles).to_bytes(4, "little") + triangles.tobytes()
    faces = "3 0 1 2 255 0 0\n3 2 1 3 .5 0 1 1\n3 1 2 4 7\n"
    vertices = [f"v {row} 1 1 0 0" for row in rows.split("\n")]
    paint = "#MRGB ff0a0b0cff0d0e0fff0a0b0cff0d0e0f\n#MRGB ff0a0b0cff0d0e0fff0a0b0cff0d0e0f\n"
    head = "ply\nformat ascii 1.0\nelement vertex 8\n"
    place = "property float x\nproperty float y\nproperty float z\n"
    listed = "property list uchar uchar rgba\n"
    polygons = "element face 1\nproperty list uchar int vertex_indices\n"
    splats = "".join(f"property float f_dc_{k}\n" for k in range(3))
    told = rows.replace("\n", " 4 1 2 3 4\n") + " 4 1 2 3 4\n"
    attributes = rows.replace("\n", " 9 8 7 6 0 0 -1 .5 .5\n") + " 9 8 7 6 0 0 -1 .5 .5\n"
    harmonics = rows.replace("\n", " 1 -2 .5\n") + " 1 -2 .5\n"
    return [
        (".stl", stl),
        (".off", f"OFF\n8 3 0\n{rows}\n{faces}".encode()),
        (".off", f"NCSTOFF\n8 1 0\n{attributes}3 0 1 2\n".encode()),
        (".obj", ("\n".join(vertices) + "\nf 1 2 3\n").encode()),
        (".obj", ("v " + rows.replace("\n", "\nv ") + f"\n{paint}f 1 2 3\n").encode()),
        (".ply", f"{head}{place}{listed}{polygons}end_header\n{told}3 0 1 2\n".encode()),
        (".ply", f"{head}{place}{splats}{polygons}end_header\n{harmonics}3 0 1 2\n".encode()),
        (".gltf", _gltf_with_extensions()),
    ]


def _gltf_with_extensions() -> bytes:
    document = json.loads(_gltf())
    node = document["nodes"][0]
    accessor = next(iter(document["meshes"][0]["primitives"][0]["attributes"].values()))
    repeated = {"attributes": {"TRANSLATION": accessor, "SCALE": accessor}}
    node["extensions"] = {
        "EXT_mesh_gpu_instancing": repeated,
        "KHR_node_visibility": {"visible": True},
    }
    document["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    glossy = {"diffuseFactor": [1, 0.5, 0, 1], "diffuseTexture": {"index": 0}}
    document["materials"] = [{"extensions": {"KHR_materials_pbrSpecularGlossiness": glossy}}]
    document["textures"] = [{"extensions": {"EXT_texture_webp": {"source": 0}}}]
    document["images"] = [{"uri": "data:image/webp;base64,UklGRg=="}]
    for primitive in document["meshes"][0]["primitives"]:
        primitive["material"] = 0
    return json.dumps(document).encode()


def _pictured_3mf() -> bytes:
    import io
    import zipfile

    from PIL import Image

    core = "http://schemas.microsoft.com/3dmanufacturing"
    nodes = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in CORNERS.tolist())
    model = (
        f'<model xmlns="{core}/core/2015/02" xmlns:m="{core}/material/2015/02" unit="inch">'
        '<resources><m:texture2d id="1" path="/3D/a.png" tilestyleu="mirror"/>'
        '<m:texture2dgroup id="2" texid="1"><m:tex2coord u="0" v=".5"/>'
        '<m:tex2coord u="1.5" v="1"/></m:texture2dgroup><m:colorgroup id="3">'
        '<m:color color="#102030"/><m:color color="#aabbccdd"/></m:colorgroup>'
        f'<object id="4" pid="3" pindex="1"><mesh><vertices>{nodes}</vertices><triangles>'
        '<triangle v1="0" v2="1" v3="2" pid="2" p1="0" p2="1" p3="0"/>'
        '<triangle v1="2" v2="1" v3="3" pid="3" p1="0" p2="1" p3="1"/>'
        '<triangle v1="4" v2="6" v3="7"/></triangles></mesh></object></resources>'
        '<build><item objectid="4" transform="-1 0 0 0 1 0 0 0 1 5 5 5"/></build></model>'
    )
    relations = (
        '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
        f'<Relationship Target="/3D/m.model" Id="r" Type="{core}/2013/01/3dmodel"/></Relationships>'
    )
    picture, package = io.BytesIO(), io.BytesIO()
    Image.fromarray((np.arange(48).reshape(4, 4, 3) * 5).astype(np.uint8)).save(picture, "PNG")
    with zipfile.ZipFile(package, "w") as archive:
        parts = (
            ("_rels/.rels", relations),
            ("3D/m.model", model),
            ("3D/a.png", picture.getvalue()),
        )
        for name, content in parts:
            archive.writestr(zipfile.ZipInfo(name), content)
    return package.getvalue()


def _gltf() -> bytes:
    import base64

    data = CORNERS.tobytes() + FACES.astype("<u2").tobytes() + CORNERS[:, :2].tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    attributes = {"POSITION": 0, "TEXCOORD_0": 2}
    document = {
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "children": [1], "scale": [1, 2, 3]}, {"rotation": [0, 0, 0, 1]}],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "none.png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5126, "count": 8, "type": "VEC2"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 96},
            {"buffer": 0, "byteOffset": 96, "byteLength": 72},
            {"buffer": 0, "byteOffset": 168, "byteLength": 64},
        ],
        "buffers": [{"byteLength": len(data), "uri": uri}],
    }
    return json.dumps(document).encode()


def _damage_mesh(data: bytes, chance: random.Random, others: Sequence[bytes]) -> bytes:
    return (damage_archive if data.startswith(b"PK") else damage)(data, chance, others)


# -- paintings ------------------------------------------------------------------------------------


def _record_seeds() -> list[tuple[str, bytes]]:
    from paint3d.files.formats.records import write_records

    up, codes = np.tile([0.0, 0.0, 1.0], (8, 1)), np.arange(24).reshape(8, 3)
    return [
        written(".p3d.txt", lambda p, k=k: write_records(p, CORNERS, up, codes, packed=k))
        for k in (False, True)
    ]


def _check_records(suffix: str, content: bytes) -> None:
    from paint3d.files.formats.records import read_records_here

    records = read_records_here(file_of(suffix, content))
    assert np.isfinite(records.vertices).all()
    assert len(records.vertices) == len(records.normals) == len(records.srgb) > 0


def _session_seeds() -> list[tuple[str, bytes]]:
    from paint3d.colour.pigments import load_pigment
    from paint3d.files.project.session import Session, save_session
    from paint3d.mesh.triangle_mesh import TriangleMesh
    from paint3d.surface.painted_surface import PaintedSurface

    surface = PaintedSurface(TriangleMesh(CORNERS, FACES), 4.0, "xuan")
    surface.refine_all()
    column = surface.column_of(load_pigment("pine soot"))
    ids = np.arange(6, dtype=np.int32)
    surface.ink.amounts[ids, column], surface.ink.coverage[ids] = 0.5, 0.75
    surface.touch(ids)
    surface.settle(ids[:3])
    surface.diffuse(0.05)
    session = Session(surface, (_recording(),), {"brush": "full"})
    return [written(".p3d", partial(save_session, session)), _session_with_steps(), _with_hairs()]


def _session_with_steps() -> tuple[str, bytes]:
    from paint3d.app.model.document import Document
    from paint3d.mesh.triangle_mesh import TriangleMesh

    document = Document.new(TriangleMesh(CORNERS, FACES), 4.0, "xuan")
    for _ in range(2):
        document.begin_stroke()
        document.feed(list(_recording().samples()))
        document.end_stroke()
        document.let_time_pass(0.05)
        document.dry()
    document.add_layer()
    document.undo()
    return written(".p3d", document.save)


def _with_hairs() -> tuple[str, bytes]:
    """A sitting with single hairs, a tip, a mask, mirrors and a seal, as it is kept while open."""
    from paint3d.app.model.document import Document
    from paint3d.app.model.input.symmetry import MirrorPlane, Symmetry
    from paint3d.app.model.mask import AngleMask, Mask
    from paint3d.brush.presets import load_brush
    from paint3d.brush.spec import BristleSpec
    from paint3d.mesh.triangle_mesh import TriangleMesh

    document = Document.new(TriangleMesh(CORNERS, FACES), 4.0, "xuan")
    hairy = dataclasses.replace(load_brush("full"), name="hairy", bristles=BristleSpec(n_hairs=8))
    document.set_brush(hairy)
    document.dip({"indigo": 0.4, "water": 0.6})
    document.dip("cinnabar", 0.3)
    document.set_symmetry(Symmetry((MirrorPlane((0, 0, 0), (0, 1, 0)),)))
    document.set_mask(Mask(AngleMask((0.0, 0.0, 1.0), 60.0)))
    document.begin_stroke()
    document.feed(list(_recording().samples()))
    document.end_stroke()
    document.press_seal([[(-1, -1), (1, -1), (0, 1)]], (4.0, 4.0, SIZE), up=(0.0, 1.0, 0.0))
    return written(".p3d", document.save)


def _check_session(suffix: str, content: bytes) -> None:
    from paint3d.app.model.document import Document

    document = Document.open(file_of(suffix, content))
    for _ in document.steps.done:
        document.undo()
    while document.can_redo:
        document.redo()
    surface = document.surface
    assert surface.srgb.shape == (surface.n_vertices, 3)
    surface.diffuse(0.01)
    assert np.isfinite(surface.amounts).all()


def _journal_seeds() -> list[tuple[str, bytes]]:
    from paint3d.files.project.journal import Journal

    def write(path: Path) -> None:
        with Journal(path, {"brush": "full"}) as journal:
            for sample in _recording().samples():
                journal.append([sample])

    return [written(".p3dj", write)]


def _check_journal(suffix: str, content: bytes) -> None:
    from paint3d.files.project.journal import read_journal

    recording, _ = read_journal(file_of(suffix, content))
    assert (np.diff(recording.time_ns) > 0).all()


# -- command lines and tables of them -------------------------------------------------------------


def _command_seeds() -> list[tuple[str, bytes]]:
    lines = (
        "replay a.jsonl --on bowl --out b.ply --at 0.5,0.25 --size 40 --spread 3 --up=-x",
        "write 永和 --on vase --out o.glb --size 20 --layout row --around --processes 2 --hairs 40",
        "write 一 --on plane --out o.svg --brush xiaokai --ink cinnabar --resolution .3 --unit cm",
        "export a.p3d b.3mf --tolerance 0.5 --filaments #102030,#aabbcc --texture 512 --unlit",
        "batch t.csv --rows 3-9 --folder . --again --quiet",
        "study plan f --participants 6 --devices I,II --character 目 --size 30 --seed 1",
        "devices record r.jsonl --seconds 2",
        "bench write --json b.json",
        "write 永 --on bowl --out o.glb --film f.mp4 --fps 30 --speed 4 --turn 360deg --view 30,20",
        "replay a.jsonl --on plane --film f.gif --turn 8 --pixels 64x48 --zoom 1.5 --light none",
        "picture bowl --out p.webp --turn 4 --fps 9 --pixels 64x64 --illuminant 2700K --observer 2",
        "copy p.jpg --on bowl --out o.ply --corners 1,2 90,3 80,99 2,8 --rehearsals 0 --beside b",
        "score a.jsonl --move 3-5:1,2,30 --ink 2:cinnabar --time 1:2s --shift 4:-1 --out b.jsonl",
        "seal 永 --on bowl --out o.ply --size 9 --coats 1 --wear .5 --seed 3 --rotate 5 --at 0,1",
    )
    return [("", line.replace(" ", "\n").encode()) for line in lines]


def _check_command(_: str, content: bytes) -> None:
    """Read the options, and check what is named before any work; nothing is run."""
    from paint3d.cli.films import film_of
    from paint3d.cli.main import make_parser
    from paint3d.cli.options import UsageError
    from paint3d.cli.painting import PaintingOptions
    from paint3d.cli.picture import viewing_of
    from paint3d.errors import InputError

    words = content.decode("utf-8", "surrogateescape").split("\n")
    if {"-h", "--help", "--version"} & set(words):
        return
    try:
        chosen = make_parser().parse_args(words)
    except UsageError as cause:
        raise InputError(" ".join(str(cause).split())) from None
    if "spread" in chosen:
        PaintingOptions.of(chosen).check()
    try:
        film = film_of(chosen) if "film" in chosen else None
    except OSError as cause:  # a name that no file can have: `main` says it in one line, too
        raise InputError(str(cause.strerror)) from None
    if film is not None:
        assert math.isfinite(film.filmed(100).turn_s)
    if "illuminant" in chosen and not {"exact", "compare"} & set(vars(chosen)):
        viewing_of(chosen)


def _table_seeds() -> list[tuple[str, bytes]]:
    rows = "text,object,output,size,brush,around,ink\n永,bowl,a.ply,20,xiaokai,yes,cinnabar\n"
    others = 'recording;object;output;spread;force\na.jsonl;b.obj;c.glb;3;no\n"a""b";x;y.ply;;\n'
    return [(".csv", (rows + "和,vase,b.glb,,,no,\n").encode()), (".csv", others.encode())]


def _check_table(suffix: str, content: bytes) -> None:
    from paint3d.cli.batches.rows import command_parser, fingerprint, placed
    from paint3d.cli.batches.table import read_table
    from paint3d.cli.options import UsageError

    rows, refused = read_table(file_of(suffix, content))
    assert all("\n" not in one.message for one in refused)
    for row in rows:
        fingerprint(row)
        command, *words = placed(row, "/nowhere").arguments
        if not {"-h", "--help"} & set(words):
            with contextlib.suppress(UsageError):
                command_parser(command).parse_args(words)


# -- devices --------------------------------------------------------------------------------------


def _device_seeds() -> list[tuple[str, bytes]]:
    from tests.support.descriptors import SPACENAVIGATOR, combined_mouse, pen, split_mouse

    descriptors = [SPACENAVIGATOR, split_mouse(), combined_mouse(), pen()]
    reports = b"".join(bytes([k]) + bytes(range(40 * k, 40 * k + 15)) for k in range(1, 4))
    with_reports = [len(d).to_bytes(2, "little") + d + reports for d in descriptors]
    return [("", data) for data in [*descriptors, *with_reports, reports]]


def _check_device(suffix: str, content: bytes) -> None:
    from tests.support.decoding import decode_any

    for refusal in decode_any(content).values():
        assert "\n" not in refusal


TARGETS: dict[str, Target] = {
    "recording": Target("JSON Lines, CSV and plain tables", _recording_seeds, _check_recording),
    "inkml": Target("W3C InkML", _inkml_seeds, _check_recording),
    "mesh": Target("mesh files of every format", _mesh_seeds, check_mesh, _damage_mesh),
    "records": Target("the papers' record format", _record_seeds, _check_records),
    "session": Target("saved sessions", _session_seeds, _check_session, damage_archive),
    "device": Target("HID descriptors and reports", _device_seeds, _check_device),
    "command": Target("command lines", _command_seeds, _check_command),
    "table": Target("tables of paintings", _table_seeds, _check_table),
    "journal": Target("journals", _journal_seeds, _check_journal),
    **COPIED,
    **PACKED,
    **DRAWINGS,
    **PARAMETERS,
    **LETTERING,
}
