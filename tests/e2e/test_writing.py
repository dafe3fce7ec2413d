"""`paint3d write` from outside: what it paints, where, and how it refuses."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

BAR = "M 150 420 L 220 350 L 800 350 L 880 420 L 800 470 L 220 470 Z"
POST = "M 450 700 L 560 700 L 560 120 L 505 60 L 450 120 Z"
GLYPHS = {
    "一": ([BAR], [[[180, 415], [850, 415]]]),
    "丨": ([POST], [[[505, 690], [505, 80]]]),
    "十": ([BAR, POST], [[[180, 415], [850, 415]], [[505, 690], [505, 80]]]),
}


@pytest.fixture(scope="module")
def glyphs(tmp_path_factory) -> Path:
    """A folder laid out like hanzi-writer-data, with three characters made up for the tests."""
    folder = tmp_path_factory.mktemp("glyphs")
    for text, (strokes, medians) in GLYPHS.items():
        data = {"character": text, "strokes": strokes, "medians": medians}
        (folder / f"{text}.json").write_text(json.dumps(data), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def written(paint3d, glyphs, tmp_path_factory):
    """A text on the bowl: folder, finished process, report."""
    folder = tmp_path_factory.mktemp("written")
    done = paint3d(
        "write", "十一", "--on", "bowl", "--out", folder / "a.ply", "--size", 20,
        "--glyphs", glyphs, "--resolution", 0.5, "--report", folder / "r.json",
        "--recording", folder / "r.jsonl.gz", "--variation", 0,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return folder, done, json.loads((folder / "r.json").read_text(encoding="utf-8"))


def test_it_tells_every_character_and_what_it_painted(written) -> None:
    folder, done, report = written
    told = [line for line in done.stderr.splitlines() if "compiling" not in line]
    assert len(told) == 2
    assert "十" in told[0]
    assert "一" in told[1]
    assert done.stdout.startswith(f"{folder / 'a.ply'}: ")
    assert "\r" not in done.stderr
    assert report["glyphs"] == "hanzi-writer-data"
    assert report["brush"] == "xiaobaiyun"
    assert [c["text"] for c in report["characters"]] == ["十", "一"]


def test_replaying_the_recording_alone_paints_the_same(paint3d, written) -> None:
    folder, _, _ = written
    done = paint3d(
        "replay", folder / "r.jsonl.gz", "--on", "bowl", "--out", folder / "b.ply",
        "--resolution", 0.5,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (folder / "b.ply").read_bytes() == (folder / "a.ply").read_bytes()


def test_frames_say_where_the_strokes_are(written) -> None:
    """Paint lies on the strokes of 一 as its frame says, and nowhere else in its square."""
    folder, _, report = written
    mesh = trimesh.load(folder / "a.ply", process=False)
    dark = np.asarray(mesh.visual.vertex_colors)[:, :3].astype(float).mean(axis=1) < 120.0
    frame = report["characters"][1]["frame"]
    x_axis, y_axis = (np.array(frame[key]) for key in ("x_axis", "y_axis"))
    assert x_axis @ y_axis == pytest.approx(0.0, abs=1e-5)
    middle = np.array(frame["origin"]) + 10.0 * (x_axis + y_axis)
    near = np.linalg.norm(mesh.vertices - middle, axis=1) < 9.0
    units = (mesh.vertices - np.array(frame["origin"])) * 1024.0 / frame["em_mm"]
    x, y = units @ x_axis, units @ y_axis - 124.0
    inside = near & (x > 260) & (x < 780) & (y > 370) & (y < 450)
    outside = near & ((y < 310) | (y > 510))
    assert inside.sum() > 20
    assert dark[inside].mean() > 0.98
    assert not dark[outside].any()


def test_the_number_of_processes_does_not_matter(paint3d, glyphs, tmp_path: Path) -> None:
    recordings = []
    for n in (1, 2):
        file = tmp_path / f"{n}.jsonl"
        done = paint3d(
            "write", "一丨", "--on", "plane", "--out", tmp_path / f"{n}.ply", "--size", 20,
            "--glyphs", glyphs, "--resolution", 2, "--recording", file, "--quiet", "--processes", n,
        )  # fmt: skip
        assert (done.returncode, done.stderr) == (0, "")
        recordings.append(file.read_bytes())
    assert recordings[0] == recordings[1]


def test_outlines_of_strokes_as_svg(paint3d, glyphs, tmp_path: Path) -> None:
    out = tmp_path / "a.svg"
    done = paint3d("write", "十", "--on", "plane", "--out", out, "--size", 30, "--glyphs", glyphs,
                   "--processes", 1)  # fmt: skip
    assert done.returncode == 0, done.stderr
    root = ElementTree.parse(out).getroot()
    assert root.get("viewBox") == "-100 -100 200 200"
    assert root.get("width") == "200mm"
    assert len(root.findall(".//{http://www.w3.org/2000/svg}path")) == 2


def test_kanjivg_is_written_without_a_folder(paint3d, tmp_path: Path) -> None:
    report = tmp_path / "r.json"
    done = paint3d(
        "write", "一", "--on", "sphere", "--out", tmp_path / "a.glb", "--size", 20,
        "--resolution", 1, "--report", report, "--layout", "row", "--azimuth", "dragged",
        "--processes", 1,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    told = json.loads(report.read_text(encoding="utf-8"))
    assert (told["glyphs"], told["azimuth"]) == ("kanjivg", "dragged")
    assert told["vertices_painted"] > 100


def test_bad_input_is_one_line_and_leaves_nothing(
    paint3d, glyphs, system_fonts, tmp_path: Path
) -> None:
    out = tmp_path / "a.ply"
    done = paint3d("write", "一龘丨鸞", "--on", "plane", "--out", out, "--glyphs", glyphs,
                   "--processes", 1,
                   FONTCONFIG_FILE=str(system_fonts.configuration))  # fmt: skip
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(
        "paint3d: error: hanzi-writer-data has no glyph for '龘' (U+9F98), "
    )
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
