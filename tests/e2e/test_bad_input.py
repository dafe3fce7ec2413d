"""Whatever is wrong with the input: one line on stderr, exit status 2, and nothing written."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from pathlib import Path

import pytest

SQUARE = "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\n"


def check_refused(done, words: str, out: Path) -> None:
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert done.stderr.startswith("paint3d: error: ")
    assert done.stderr.count("\n") == 1
    assert words in done.stderr
    left = [file.name for file in out.parent.iterdir() if out.stem in file.name]
    assert left == []


@pytest.fixture
def refuse(paint3d, tmp_path: Path) -> Callable[..., None]:
    """Replay and check that it is refused with a message that holds these words."""

    def run(recording: Path, mesh: object, words: str, *options: object) -> None:
        out = tmp_path / "painted.ply"
        done = paint3d("replay", recording, "--on", mesh, "--out", out, *options)
        check_refused(done, words, out)

    return run


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        ("position", [float("nan"), 0, 0], "strokes.jsonl:7: "),
        ("position", [1e300, 0, 0], "strokes.jsonl:7: position"),
        ("pressure", 1.7, "strokes.jsonl:7: pressure is 1.7; expected 0 to 1"),
        ("time_ns", 0, "strokes.jsonl:7: time_ns is 0; expected more than"),
        ("orientation", [0, 0, 0, 0], "strokes.jsonl:7: orientation"),
        ("presure", 0.2, "strokes.jsonl:7: a key is 'presure'; expected 'pressure'"),
    ],
)
def test_a_bad_sample_is_named_by_its_line(
    refuse, save, lines: list[dict], tmp_path: Path, place: str, value: object, words: str
) -> None:
    lines[6][place] = value
    refuse(save(tmp_path / "strokes.jsonl", lines), "plane", words)


def test_unknown_version(refuse, save, lines: list[dict], tmp_path: Path) -> None:
    lines[0]["version"] = 99
    refuse(save(tmp_path / "a.jsonl", lines), "plane", "a.jsonl:1: version is 99; expected 1")


def test_truncated_gzip(refuse, recording: Path, tmp_path: Path) -> None:
    whole = gzip.compress(recording.read_bytes())
    cut = tmp_path / "cut.jsonl.gz"
    cut.write_bytes(whole[: len(whole) // 2])
    refuse(cut, "plane", "cut.jsonl.gz")


@pytest.mark.parametrize(
    "content", [b"", b"\n\n", b"\x89PNG\r\n\x1a\n\x00\xff", b"[1, 2]\n", b"{}\n"]
)
def test_what_is_no_recording(refuse, tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "a.jsonl"
    file.write_bytes(content)
    refuse(file, "plane", "a.jsonl")


def test_missing_recording(refuse, tmp_path: Path) -> None:
    refuse(tmp_path / "none.jsonl", "plane", "none.jsonl")


def test_header_with_a_brush_that_is_no_name(
    refuse, save, lines: list[dict], tmp_path: Path
) -> None:
    lines[0]["brush"] = {"name": "full"}
    refuse(save(tmp_path / "a.jsonl", lines), "plane", "brush is {'name': 'full'}; expected a name")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "empty"),
        ("# nothing but a comment\n", "no vertices"),
        (SQUARE, "no triangles"),
        (SQUARE + "f 1 2 9\n", "vertex 8; expected 0 to 3"),
        (SQUARE.replace("v 9 9 0", "v nan 9 0") + "f 1 2 3\n", "expected finite"),
        ("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n", "area"),
    ],
)
def test_bad_meshes(refuse, recording: Path, tmp_path: Path, text: str, words: str) -> None:
    mesh = tmp_path / "jug.obj"
    mesh.write_text(text)
    refuse(recording, mesh, words)


def test_a_polygon_with_a_million_corners(refuse, recording: Path, tmp_path: Path) -> None:
    mesh = tmp_path / "disc.off"
    mesh.write_text("OFF\n4 1 0\n0 0 0\n9 0 0\n9 9 0\n0 9 0\n1000000" + " 0 1 2 3" * 250_000)
    refuse(recording, mesh, "1,000,000 corners")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--brush", "fulll"), "unknown brush 'fulll': did you mean 'full'?"),
        (("--ink", "pine sot"), "did you mean 'pine soot'?"),
        (("--material", "porcelan"), "did you mean 'porcelain'?"),
        (("--resolution", "0"), "argument --resolution: '0' is not a length"),
        (("--resolution", "0.001"), "expected at least"),
        (("--unit", "ell"), "argument --unit: 'ell' is none of mm, cm, m, in"),
    ],
)
def test_bad_options(refuse, recording: Path, options: tuple[str, ...], words: str) -> None:
    refuse(recording, "plane", words, *options)


def test_missing_mesh_names_the_built_in_objects(refuse, recording: Path) -> None:
    refuse(recording, "bowle", "bowl, plate, vase, sphere, plane")


def test_output_is_checked_before_the_input(paint3d, tmp_path: Path) -> None:
    out = tmp_path / "painted.xyz"
    done = paint3d("replay", tmp_path / "none.jsonl", "--on", "none.obj", "--out", out)
    check_refused(done, "expected a name ending in", out)


def test_report_is_checked_before_the_input(paint3d, tmp_path: Path) -> None:
    out = tmp_path / "painted.ply"
    report = tmp_path / "no" / "report.json"
    done = paint3d("replay", "none.jsonl", "--on", "bowl", "--out", out, "--report", report)
    check_refused(done, "there is no folder", out)


def test_an_older_result_survives_a_failure(paint3d, save, lines, tmp_path: Path) -> None:
    out = tmp_path / "painted.ply"
    out.write_text("older")
    lines[9]["pressure"] = 2
    bad = save(tmp_path / "a.jsonl", lines)
    assert paint3d("replay", bad, "--on", "plane", "--out", out).returncode == 2
    assert out.read_text() == "older"


def test_a_recording_is_not_a_mesh(refuse, recording: Path) -> None:
    assert json.loads(recording.read_text().splitlines()[0])
    refuse(recording, recording, "expected one of .ply")
