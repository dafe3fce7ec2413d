"""The page's painter in Node against the desktop's: the same recording gives the same bytes."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from paint3d.app.model.score.playing import painted
from paint3d.brush.spec import DipAmount
from paint3d.calligraphy.seal.stone import cut_seal
from paint3d.device.recorded import Recording
from paint3d.files.load import load_mesh
from paint3d.mesh.likeness import digest_of
from paint3d.page.folder import KERNELS, PageObject, build_page
from paint3d.painter.painter import Painter
from paint3d.recording.recording import load_recording, save_recording
from paint3d.recording.score import load_score
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.web_page import hashes_of, replay_script, why_no_kernels

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "paint3d" / "calligraphy" / "data" / "demo.jsonl.gz"
pytestmark = [
    pytest.mark.skipif(shutil.which("node") is None, reason="Node is not installed"),
    pytest.mark.skipif(bool(why_no_kernels(KERNELS)), reason=why_no_kernels(KERNELS)),
]
SOOT = {"pine soot": 1.0}
OBJECTS = [
    PageObject("bowl", 0.5), PageObject("bowl", 0.3), PageObject("square", 0.4),
    PageObject("square", 0.8), PageObject("bowl", 0.8), PageObject("sheet:60x60", 30.0),
    PageObject("vase", 1.0), PageObject("fan", 0.8), PageObject("plate", 1.0),
]  # fmt: skip
CASES: dict[str, dict[str, Any]] = {
    "demo on the bowl, .5 mm": {"resolution": 0.5},
    "demo on the bowl, .3 mm": {"resolution": 0.3},
    "lines in the bowl, dragged, in thin ink": {
        "recording": "in the bowl", "resolution": 0.5, "brush": "full", "azimuth": "dragged",
        "parts": {"pine soot": 1.0, "water": 3.0},
    },
    "lines of two pigments, live": {
        "recording": "lines", "object": "square", "resolution": 0.4, "brush": "zhongkai",
        "parts": {"cinnabar": 1.0, "indigo": 2.0}, "live": 7,
    },
    "lines on paper": {"recording": "lines", "object": "square", "resolution": 0.4},
    "lines on paper, as a pen says": {"recording": "lines", "object": "square", "resolution": 0.4,
                                      "live": 1},
    "lines on paper, thirsty brush": {
        "recording": "lines", "object": "square", "resolution": 0.4, "pickup": 0.05,
        "brush": "full", "amount": {"wetted": 0.4, "fullness": 1.5},
    },
    "lines on porcelain": {"recording": "lines", "object": "square", "resolution": 0.4,
                           "material": "porcelain", "brush": "zhongkai"},
    "lines without pressure": {"recording": "unpressed", "object": "square", "resolution": 0.4,
                               "brush": "zhongkai"},
    "lines in wet ink": {
        "recording": "lines", "object": "square", "resolution": 0.8, "brush": "zhongkai",
        "parts": {"pine soot": 1.0, "water": 2.0}, "wet": 1.0,
    },
    "lines in wet ink of two pigments, some of it dry": {
        "recording": "lines", "object": "square", "resolution": 0.8, "brush": "full",
        "parts": {"cinnabar": 1.0, "indigo": 1.0, "water": 3.0}, "wet": 25.0,
    },
    "wet ink in a bowl of paper": {
        "recording": "in the bowl", "resolution": 0.8, "material": "xuan", "brush": "zhongkai",
        "parts": {"pine soot": 1.0, "water": 1.0}, "wet": 0.5,
    },
    "wet ink on porcelain": {
        "recording": "lines", "object": "square", "resolution": 0.8, "brush": "zhongkai",
        "material": "porcelain", "wet": 0.5,
    },
    "one vertex at each corner": {"recording": "lines", "object": "sheet:60x60",
                                  "resolution": 30.0},
}  # fmt: skip

# the brushes that ship, each on another object, of another material, in another ink
TRIED = {
    "full": ("vase", "porcelain", {"cinnabar": 1.0}, {}),
    "slender": ("fan", "silk", {"pine soot": 1.0, "water": 4.0}, {"wet": 2.0}),
    "calibrated": ("plate", "porcelain", {"indigo": 2.0, "gamboge": 1.0}, {"live": 3}),
    "xiaokai": ("square", "sized xuan", {"carmine": 1.0, "water": 2.0}, {"wet": 1.0}),
    "zhongkai": ("bowl", "xuan", {"pine soot": 1.0, "cinnabar": 1.0}, {"wet": 4.0}),
    "dakai": ("vase", "bisque", {"indigo": 1.0, "water": 1.0}, {"azimuth": "dragged"}),
    "gongbi": ("fan", "sized xuan", {"gamboge": 1.0}, {"live": 1}),
    "baiyun": ("plate", "bisque", {"pine soot": 1.0, "water": 0.5}, {"wet": 0.5}),
    "xiaobaiyun": ("square", "silk", {"carmine": 1.0, "gamboge": 2.0}, {"wet": 6.0}),
    "zhongbaiyun": ("bowl", "porcelain", {"pine soot": 1.0, "water": 9.0}, {"live": 11}),
    "dabaiyun": ("vase", "xuan", {"cinnabar": 2.0, "water": 3.0}, {"wet": 1.5}),
    "langhao": ("fan", "xuan", {"pine soot": 1.0}, {"wet": 12.0}),
    "yanghao": ("plate", "silk", {"indigo": 1.0, "carmine": 1.0, "water": 2.0}, {"wet": 1.0}),
    "jianhao": ("square", "porcelain", {"pine soot": 1.0}, {"azimuth": "dragged", "live": 5}),
}  # fmt: skip
ALL_BRUSHES = {
    f"{brush} on {on} of {material}": {
        "recording": on, "object": on, "material": material, "brush": brush, "parts": parts,
        "resolution": 0.8 if on in ("square", "bowl", "fan") else 1.0, **words,
    }
    for brush, (on, material, parts, words) in TRIED.items()
}  # fmt: skip
CASES |= ALL_BRUSHES
SITTINGS, QUICK_SITTINGS = 16, 4

RUNS = {"do": "follow_time", "seconds": 0.05, "times": 6}
RED = {"do": "dip", "ink": {"cinnabar": 1.0}}
SOOT_AGAIN = {"do": "dip", "ink": SOOT}
LITTLE = {"wetted": 0.2, "fullness": 0.6}
SEAL = {
    "do": "press_seal", "at": [3.0, -7.0, 0.0], "up": [0.1, 1.0, 0.0], "ink": {"cinnabar": 1.0},
    "coats": 1.3, "pad_mm": 3.0, "wear": 1.0, "seed": 1,
    "rings": [ring.tolist() for ring in cut_seal("永和", size_mm=14.0).rings],
}  # fmt: skip
# whole paintings: strokes by where they are shifted to, mm, between what a page can do
SCORES: dict[str, list[Any]] = {
    "strokes that erase": [
        (0, 0), (5, -10), ("erase", 0, -5), {"do": "undo"}, ("erase", 3, -4), (0, -6),
    ],
    "seals in running ink, on another layer, undone": [
        (0, 0), RUNS, SEAL, (0, -4), RUNS, {"do": "undo"}, {"do": "add_layer"},
        SEAL | {"at": [-20.0, 5.0, 0.0], "wear": 2.0, "seed": 7}, {"do": "undo"}, {"do": "redo"},
        RUNS, (2, -9), RUNS,
    ],
    "layers, one of them hidden, one faded": [
        (0, 0), {"do": "add_layer"}, RED, (5, -3), RUNS,
        {"do": "set_opacity", "place": 1, "opacity": 0.5}, {"do": "select_layer", "place": 0},
        (2, -5), {"do": "move_layer", "place": 1, "to": 0}, {"do": "add_layer"}, (1, -7),
        {"do": "dry"}, {"do": "set_visible", "place": 0, "visible": False},
    ],
    "layers with ink that runs, undone": [
        (0, 0), RUNS, {"do": "dry"}, {"do": "add_layer"}, RED, (5, -3), RUNS,
        {"do": "select_layer", "place": 0}, {"do": "undo"}, (2, -5),
        {"do": "remove_layer", "place": 1}, {"do": "undo"}, ("erase", 2, -6),
        {"do": "set_opacity", "place": 0, "opacity": 0.3}, RUNS,
    ],
    "layers that multiply, undone and done again": [
        RED, (0, 0), {"do": "add_layer"}, SOOT_AGAIN, (1, -2), {"do": "dry"},
        {"do": "set_blend", "place": 1, "blend": "multiply"}, {"do": "rename_layer", "place": 1,
        "name": "题"}, {"do": "set_opacity", "place": 1, "opacity": 0.7}, {"do": "undo"},
        {"do": "undo"}, {"do": "redo"}, {"do": "set_blend", "place": 0, "blend": "multiply"},
    ],
    "strokes undone by another brush, and done again": [
        (0, 0), {"do": "set_brush", "brush": "full"}, RED, (5, -6), RUNS, {"do": "undo"},
        {"do": "set_brush", "brush": "zhongkai"}, {"do": "undo"}, (1, 1), {"do": "undo"},
        {"do": "redo"}, (0, -4), {"do": "undo"}, {"do": "undo"}, RUNS, {"do": "redo"},
        {"do": "redo"}, (2, -8),
    ],
    "dips of other amounts, taken back": [
        SOOT_AGAIN | {"amount": LITTLE}, (0, 0), RED, (2, -3),
        {"do": "dip", "amount": {"fullness": 2}}, (1, -5), {"do": "undo"}, (1, -6),
        {"do": "dip", "amount": LITTLE}, ("erase", 3, -4), {"do": "undo"}, {"do": "undo"},
        {"do": "redo"}, {"do": "undo"}, (2, -8), {"do": "set_brush", "brush": "full"}, (0, -9),
    ],
    "a brush that runs dry, taken back": [
        (0, 0), (0, -2), (0, -4), {"do": "undo"}, {"do": "undo"}, (0, -5), {"do": "undo"},
        {"do": "set_brush", "brush": "full"}, {"do": "undo"}, (3, -3),
    ],
}  # fmt: skip


def sitting(seed: int, n: int = 14) -> list[Any]:
    """Anything that a page can do, one after the other."""
    chance = np.random.default_rng(seed)
    events: list[Any] = []
    layers, active = 1, 0
    done: list[tuple[int, int]] = []  # layers and the active one before each step
    undone: list[tuple[int, int]] = []
    back = (1, 0)
    words: Any
    while len(events) < n:
        place = int(chance.integers(layers))
        kind = str(chance.choice(
            ["stroke", "erase", "dip", "brush", "runs", "dry", "add", "remove", "select", "move",
             "opacity", "blend", "name", "undo", "redo"],
            p=[0.26, 0.06, 0.08, 0.07, 0.06, 0.04, 0.06, 0.03, 0.06, 0.04, 0.05, 0.04, 0.02, 0.08,
               0.05],
        ))  # fmt: skip
        if kind == "undo":
            if not done:
                continue
            undone.append(back if undone else (layers, active))
            layers, active = back = done.pop()
            events.append({"do": "undo"})
            continue
        if kind == "redo":
            if not undone:
                continue
            done.append(back)
            layers, active = back = undone.pop()
            events.append({"do": "redo"})
            continue
        before = layers, active
        if kind in ("stroke", "erase"):
            x, y = chance.integers(-8, 9, 2).tolist()
            words = ("erase", x, y) if kind == "erase" else (x, y)
        elif kind == "dip":
            words = {"do": "dip", "ink": dict(DIPS[int(chance.integers(len(DIPS)))])}
        elif kind == "brush":
            words = {"do": "set_brush", "brush": str(chance.choice(["zhongkai", "full"]))}
        elif kind == "runs":
            words = RUNS
        elif kind == "dry":
            words = {"do": "dry"}
        elif kind == "add":
            layers, active, words = layers + 1, active + 1, {"do": "add_layer"}
        elif kind == "remove":
            if layers == 1:
                continue
            words = {"do": "remove_layer", "place": place}
            if place == active:
                active = place - 1 if place else 0
            elif place < active:
                active -= 1
            layers -= 1
        elif kind == "select":
            active, words = place, {"do": "select_layer", "place": place}
        elif kind == "move":
            to = int(chance.integers(layers))
            order = list(range(layers))
            order.insert(to, order.pop(place))
            active, words = order.index(active), {"do": "move_layer", "place": place, "to": to}
        elif kind == "opacity":
            share = float(chance.integers(1, 20)) / 20.0
            words = {"do": "set_opacity", "place": place, "opacity": share}
        elif kind == "blend":
            blend = str(chance.choice(["normal", "multiply"]))
            words = {"do": "set_blend", "place": place, "blend": blend}
        else:
            words = {"do": "rename_layer", "place": place, "name": f"第{seed}"}
        if kind not in ("dip", "brush", "runs", "select", "name"):  # which are no steps
            done.append(before)
            undone = []
        events.append(words)
    return events


DIPS = ({"pine soot": 1.0}, {"cinnabar": 1.0}, {"indigo": 1.0, "gamboge": 2.0},
        {"pine soot": 1.0, "water": 4.0}, {"carmine": 1.0, "water": 1.0})  # fmt: skip
SCORES |= {f"sitting {seed}": [(0, 0), *sitting(seed)] for seed in range(SITTINGS)}
HAIRS = "lines by single hairs"
LONG = {*ALL_BRUSHES, *(f"sitting {seed}" for seed in range(QUICK_SITTINGS, SITTINGS))}
HAIR_CASE = {"recording": "lines", "object": "square", "resolution": 0.4, "brush": "feibai",
             "live": 50}  # fmt: skip


def lines(on: str) -> Recording:
    """Lines of changing pressure and lean on an object, in one recording."""
    surface = PaintedSurface(load_mesh(on), 4.0)
    painter = Painter(surface, "zhongkai")
    parts, start = [], 0
    for k, tilt in enumerate((0.0, 30.0, -30.0)):
        ways = [(-25.0, 20.0 - 20.0 * k, 0.0), (0.0, 26.0 - 20.0 * k, 0.0),
                (25.0, 18.0 - 20.0 * k, 0.0)]  # fmt: skip
        part = painter.stroke(ways, pressure=(0.0, 0.5, 0.15, 0.6, 0.0), tilt=tilt)
        parts.append(dataclasses.replace(part, time_ns=part.time_ns + start))
        start += int(part.time_ns[-1]) + 300_000_000
    joined = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("time_ns", "position", "orientation", "pressure", "contact", "buttons")
    }
    joined["buttons"] = joined["buttons"].copy()
    joined["buttons"][len(parts[0]) : len(parts[0]) + 3] = 2  # dipped between two of them
    return Recording(**joined, header=parts[0].header)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("recordings")
    drawn = lines("square")
    save_recording(lines("bowl"), folder / "bowl.jsonl")
    descending = drawn.position - np.array([0.0, 0.0, 12.0])
    unpressed = Recording(drawn.time_ns, descending, drawn.orientation, header=drawn.header)
    save_recording(drawn, folder / "lines.jsonl")
    save_recording(unpressed, folder / "unpressed.jsonl.gz")
    for on in dict.fromkeys(on for on, *_ in TRIED.values()):
        save_recording(lines(on), folder / f"{on}.jsonl")
    return {"demo": DEMO, **{on: folder / f"{on}.jsonl" for on, *_ in TRIED.values()},
            "lines": folder / "lines.jsonl",
            "in the bowl": folder / "bowl.jsonl",
            "unpressed": folder / "unpressed.jsonl.gz"}  # fmt: skip


@pytest.fixture(scope="module")
def scores(
    recordings: dict[str, Path], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Path]:
    folder, mesh = tmp_path_factory.mktemp("scores"), load_mesh("square")
    head = {
        "format": "paint3d-recording", "version": 2, "object": "square", "mesh": digest_of(mesh),
        "resolution_mm": 0.8, "material": "xuan", "brush": "zhongkai", "ink": SOOT,
        "azimuth": "commanded", "space": "world",
        "units": {"position": "mm", "time": "ns", "force": "N"},
    }  # fmt: skip
    rows = list(map(json.loads, recordings["lines"].read_text().splitlines()))[1:]
    first = [row | {"buttons": 0} for row in rows[: len(rows) // 3 : 2]]
    paths = {}
    for name, events in SCORES.items():
        said: list[dict[str, Any]] = [head]
        for k, event in enumerate(events):
            if isinstance(event, dict):
                said.append(event)
                continue
            x, y = event[-2:]
            said.append({"do": "begin_stroke"} | ({"erase": True} if len(event) == 3 else {}))
            for row in first:
                shifted = {
                    key: [row[key][0] + x, row[key][1] + y, row[key][2]]
                    for key in ("position", "contact")
                }
                said.append(row | shifted | {"time_ns": row["time_ns"] + 10_000_000_000 * k})
            said.append({"do": "end_stroke"})
        paths[name] = folder / f"{len(paths)}.score.jsonl"
        paths[name].write_text("\n".join(map(json.dumps, said)) + "\n")
    return paths


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("page")


@pytest.fixture(scope="module")
def in_node(
    request: pytest.FixtureRequest,
    recordings: dict[str, Path],
    scores: dict[str, Path],
    folder: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> dict[str, dict[str, Any]]:
    """What Node paints, by the names of the cases that are to be tested."""
    script = replay_script(tmp_path_factory.mktemp("replay"))
    ran = [one.callspec.params for one in request.session.items if hasattr(one, "callspec")]
    wanted = {params["name"] for params in ran if "name" in params}
    cases = {name: case for name, case in CASES.items() if name in wanted}
    paths = {name: path for name, path in scores.items() if name in wanted}
    brushes = sorted(
        {HAIR_CASE["brush"], "zhongkai", "full"}
        | {case.get("brush", "xiaobaiyun") for case in cases.values()}
    )
    used = {words(case, recordings)["object"] for case in cases.values()} | {"square"}
    objects = [one for one in OBJECTS if one.name in used]
    inks = ["pine soot", "cinnabar", "indigo", "gamboge", "carmine"]
    materials = ["porcelain", "xuan", "sized xuan", "silk", "bisque"]
    build_page(folder, objects, brushes, inks, page=None, materials=materials)
    by_hairs = words(HAIR_CASE, recordings) | {"save": os.fspath(folder / HAIRS)}
    asked = [words(case, recordings) for case in cases.values()]
    asked += [{"score": os.fspath(path)} for path in paths.values()]
    done = subprocess.run(
        ["node", script, os.fspath(folder), *map(json.dumps, [*asked, by_hairs])],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    names = [*cases, *paths, HAIRS]
    return dict(zip(names, map(json.loads, done.stdout.splitlines()), strict=True))


def _some_long(names: Iterable[str]) -> list[Any]:
    return [pytest.param(one, marks=pytest.mark.long) if one in LONG else one for one in names]


def words(case: dict[str, Any], recordings: dict[str, Path]) -> dict[str, Any]:
    usual = {"object": "bowl", "brush": "xiaobaiyun", "parts": SOOT}
    recording = os.fspath(recordings[case.get("recording", "demo")])
    return usual | case | {"recording": recording}


def in_python(case: dict[str, Any]) -> tuple[PaintedSurface, dict[str, float]]:
    surface = PaintedSurface(load_mesh(case["object"]), case["resolution"], case.get("material"))
    painter = Painter(
        surface, case["brush"], case["parts"], case.get("azimuth", "commanded"),
        case.get("pickup"), amount=DipAmount(**case.get("amount", {})),
    )  # fmt: skip
    recording = load_recording(case["recording"])
    if "live" in case:
        samples = list(recording.samples())
        for k in range(0, len(samples), case["live"]):
            painter.advance(samples[k : k + case["live"]])
        painter.finish()
    else:
        painter.replay(recording, wet="wet" in case)
        painter.rest(int(recording.time_ns[-1]), case.get("wet", 0.0))
    return surface, painter.ledger()


@pytest.mark.parametrize("name", _some_long(CASES))
def test_a_recording_gives_the_same_bytes_in_the_page(
    name: str, in_node: dict[str, dict[str, Any]], recordings: dict[str, Path]
) -> None:
    surface, ledger = in_python(words(CASES[name], recordings))
    hashes, found = hashes_of(surface), in_node[name]
    if "wet" in CASES[name]:
        dry = surface.dry_layers
        rows = (dry.vertex_ids, dry.spectra, dry.amounts)
        hashes["dried"] = hashlib.sha256(b"".join(row.tobytes() for row in rows)).hexdigest()
    for key, ours in hashes.items():  # seen with -s
        print(f"{name}: {key}: {str(ours)[:16]} in Python, {str(found[key])[:16]} in the page")
    assert {key: found[key] for key in hashes} == hashes
    assert ledger["wet"] > 0.0
    accounts = {
        "loaded": "loaded",
        "dry": "dry",
        "in_brush": "inBrush",
        "wet": "wet",
        "off_surface": "offSurface",
    }
    for ours, theirs in accounts.items():
        assert found["ledger"][theirs] == pytest.approx(ledger[ours], rel=1e-9, abs=1e-6), ours


@pytest.mark.parametrize("name", _some_long(SCORES))
def test_a_whole_painting_gives_the_same_bytes_in_the_page(
    name: str, in_node: dict[str, dict[str, Any]], scores: dict[str, Path]
) -> None:
    surface = painted(load_score(scores[name]), load_mesh("square")).surface
    hashes, found = hashes_of(surface), in_node[name]
    assert {key: found[key] for key in hashes} == hashes


def test_single_hairs_paint_the_same_but_for_the_estimate_of_a_root(
    in_node: dict[str, dict[str, Any]], folder: Path, recordings: dict[str, Path]
) -> None:
    """In Python the processor estimates 1 / sqrt, in the page nothing is estimated."""
    surface, _ = in_python(words(HAIR_CASE, recordings))
    n = surface.n_vertices
    assert in_node[HAIRS]["vertices"] == n
    raw = (folder / HAIRS).read_bytes()
    codes = np.frombuffer(raw, np.uint8, 3 * n).reshape(n, 3).astype(int)
    amounts = np.frombuffer(raw[3 * n :], np.float32)
    apart = np.abs(codes - surface.srgb.astype(int)).max(axis=1)
    assert apart.max() <= 1
    assert np.count_nonzero(apart) <= 1e-3 * n
    np.testing.assert_allclose(amounts, surface.amounts.ravel(), rtol=0.0, atol=1e-3)


def test_a_painting_in_the_page_loses_no_ink(in_node: dict[str, dict[str, Any]]) -> None:
    for name in in_node.keys() - SCORES.keys():
        found = in_node[name]
        accounts = found["ledger"]
        rest = accounts["inBrush"] + accounts["wet"] + accounts["dry"] + accounts["offSurface"]
        assert accounts["loaded"] == pytest.approx(rest, rel=1e-6), name
