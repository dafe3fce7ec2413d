"""`paint3d replay --film`: the painting as it grows, read back picture by picture."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from PIL import Image

from paint3d.cli import main
from paint3d.cli.films import Watch
from paint3d.errors import ExportError
from paint3d.painter.painter import Painter
from paint3d.recording.recording import HandTime, Recording, save_recording
from paint3d.view import shot
from paint3d.view.film import find_encoder, write_mp4
from tests.support.full_disk import full_disk
from tests.support.surface_cases import poses
from tests.view.test_view_picture import needs_opengl

SCORE = Path(__file__).parents[2] / "examples" / "bamboo.score.jsonl"
FLAT = ("--view", "flat", "--pixels", "120x120", "--quiet")
N_HELD_S = 1.0


def strokes() -> Recording:
    """Two strokes of .4 s, and a rest of a minute between them."""
    x = np.linspace(-20.0, 20.0, 40)
    points = np.concatenate([np.stack([x, np.full(40, y), 0.0 * x], axis=1) for y in (8.0, -8.0)])
    pressure = np.full(80, 0.5)
    pressure[[0, 39, 40, 79]] = 0.0
    held = poses(points, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), pressure, "slender")
    times = np.concatenate([np.arange(40) * 10**7, 60 * 10**9 + np.arange(40) * 10**7])
    return replace(held, time_ns=times, header={"brush": "slender", "ink": "pine soot"})


@pytest.fixture(scope="module")
def recording(tmp_path_factory) -> Path:
    file = tmp_path_factory.mktemp("strokes") / "a.jsonl"
    save_recording(strokes(), file)
    return file


def run(*words: object) -> int:
    return main.main([str(word) for word in words])


def replay(recording: Path, *words: object) -> int:
    return run("replay", recording, "--on", "plane", "--resolution", "1", *words)


def frames_of(film: Path) -> tuple[str, np.ndarray]:
    """What FFmpeg says of a film's pictures, and these (N, H, W, 3)."""
    read = subprocess.run(
        [find_encoder(), "-hide_banner", "-i", film, "-fps_mode", "passthrough",
         "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
        capture_output=True, check=True,
    )  # fmt: skip
    told = next(line for line in read.stderr.decode().split("\n") if "Video:" in line)
    width, height = map(int, re.search(r" (\d+)x(\d+)[, ]", told).groups())
    frames = np.frombuffer(read.stdout, np.uint8).reshape(-1, height, width, 3)
    return told, frames.astype(int)


@needs_opengl
def test_an_mp4_begins_bare_grows_and_ends_as_the_finished_painting(recording, tmp_path) -> None:
    film, painting, picture = tmp_path / "a.mp4", tmp_path / "a.p3d", tmp_path / "a.png"
    assert replay(recording, "--out", painting, "--film", film, "--fps", 20, *FLAT) == 0
    told, frames = frames_of(film)
    seconds = 0.39 + 1.0 + 0.39  # the rest counts a second
    assert len(frames) == 2 + int(seconds * 20) + 20 * N_HELD_S
    assert frames.shape[1:] == (120, 120, 3)
    assert "Video: h264" in told
    assert " 20 fps" in told
    bare = frames[0]
    assert np.ptp(bare.reshape(-1, 3), axis=0).max() <= 4
    still = ("--view", "flat", "--pixels", "120x120", "--quiet")
    assert run("picture", painting, "--out", picture, *still) == 0
    with Image.open(picture) as image:
        finished = np.array(image).astype(int)
    assert np.abs(frames[-1] - finished).mean() < 2.0  # what the codec loses
    inked = finished[..., 1] < 100
    assert inked.sum() > 100
    assert bare[inked].min() > 200
    assert np.abs(frames[-1] - finished)[inked].mean() < 15.0
    darker = bare[..., 1] - frames[..., 1]
    ink = np.where(darker > 40, darker, 0).sum(axis=(1, 2))
    assert (np.diff(ink) > -0.005 * ink[-1]).all()
    assert (np.diff(ink) > 0.02 * ink[-1]).sum() >= 10  # it grows, and does not jump
    half = (ink[8:27] - ink[0]) / (ink[-1] - ink[0])  # while the hand rests
    assert 0.4 < half.min() <= half.max() < 0.6


def test_a_film_of_ink_that_spreads_lasts_as_long_as_the_inks_own_time() -> None:
    """While it stands still for work that is left over, none passes in the film either."""
    seen: list[float] = []
    watch = Watch(cast(Any, None), cast(Any, SimpleNamespace(at=seen.append)), 0.1)
    shares: list[float] = []
    told = watch.resting(shares.append)
    for share in (0.25, 0.5, 0.5, 0.5, 0.75, 1.0):
        told(share)
    assert shares == [0.25, 0.5, 0.5, 0.5, 0.75, 1.0]
    np.testing.assert_allclose(seen, [0.05, 0.1, 0.15, 0.2])


@needs_opengl
def test_what_is_painted_is_the_same_with_a_film(recording, tmp_path) -> None:
    for name, more in (("a", ()), ("b", ("--film", tmp_path / "a.gif", "--fps", 5))):
        words = ("--out", tmp_path / f"{name}.ply", *more, *(FLAT if more else ("--quiet",)))
        assert replay(recording, *words) == 0
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()
    with Image.open(tmp_path / "a.gif") as film:
        assert film.size == (120, 120)


@needs_opengl
@pytest.mark.parametrize("suffix", [".gif", pytest.param(".webp", marks=pytest.mark.long)])
def test_a_score_becomes_a_film_that_lasts_as_long_as_its_speed_says(tmp_path, suffix) -> None:
    film = tmp_path / f"a{suffix}"
    words = ("--film", film, "--fps", 4, "--speed", 2, *FLAT)
    assert run("replay", SCORE, "--on", "plane", *words) == 0
    with Image.open(film) as image:
        total = 0
        shown = []
        for k in range(image.n_frames):
            image.seek(k)
            shown.append(np.array(image.convert("L")).astype(int))
            total += image.info["duration"]
    assert np.ptp(shown[0]) <= 12  # of paper
    assert (shown[-1] < 100).sum() > 80
    dark = [int((255 - one).sum()) for one in shown]
    assert dark[0] < dark[len(dark) // 2] < dark[-1]
    assert 0.5 * 5.6 < total / 1000.0 - N_HELD_S < 0.5 * 5.6 + 0.6


@needs_opengl
def test_an_object_turns_by_as_many_degrees_as_are_asked_while_it_grows(tmp_path) -> None:
    x = np.linspace(-8.0, 8.0, 30)
    front = np.stack([x, np.full(30, -40.0), 0.0 * x], axis=1)
    held = poses(front, (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), np.full(30, 0.5), "slender")
    held = replace(held, header={"brush": "slender", "ink": "pine soot"})
    file, film = tmp_path / "ball.jsonl", tmp_path / "ball.gif"
    save_recording(held, file)
    words = ("--fps", 20, "--light", "none", "--pixels", "64x64", "--quiet")
    told = ("--film", film, "--turn", "180deg", "--view", "front", *words)
    assert run("replay", file, "--on", "sphere", "--resolution", "2", *told) == 0
    with Image.open(film) as image:
        image.seek(image.n_frames - 1)
        last = np.array(image.convert("L")).astype(int)
        image.seek(5)
        early = np.array(image.convert("L")).astype(int)
    assert (early < 100).any()
    assert not (last < 100).any()  # what was painted in front is behind now


def refused(capsys, *words: object) -> str:
    assert run(*words) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    return said


def test_what_cannot_be_filmed_is_said_in_one_line(
    recording, tmp_path, capsys, monkeypatch
) -> None:
    on = ("replay", recording, "--on", "plane")
    film = ("--film", tmp_path / "a.gif")
    assert "expected --out FILE, --film FILE or both" in refused(capsys, *on)
    assert "--fps is of a film" in refused(capsys, *on, "--out", tmp_path / "a.ply", "--fps", 9)
    assert "a.avi" in refused(capsys, *on, "--film", tmp_path / "a.avi")
    assert "expected seconds" in refused(capsys, *on, *film, "--turn", "quick")
    told = refused(capsys, *on, *film, "--speed", "0.01", "--pixels", "1600x1200", "--quiet")
    assert "too many; expected a shorter or smaller film, or .mp4" in told
    monkeypatch.setattr(Painter, "replay", None)  # it is said before anything is painted
    for view in ("top", "flat", "20,90"):
        told = refused(capsys, *on, *film, "--view", view, "--turn", "8", "--quiet")
        assert "seen from the side" in told
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setenv("PATH", str(tmp_path))
    told = refused(capsys, *on, "--film", tmp_path / "a.mp4")
    assert "pip install 'paint3d[film]'" in told
    assert os.listdir(tmp_path) == []


@needs_opengl
@pytest.mark.parametrize("suffix", [".mp4", ".webp"])
def test_an_interrupt_leaves_the_old_film(recording, tmp_path, monkeypatch, suffix) -> None:
    film = tmp_path / f"a{suffix}"
    film.write_bytes(b"old")
    drawn = []
    whole = shot.FlatDrawing.pixels

    def interrupted(*asked):
        drawn.append(1)
        if len(drawn) == 5:
            raise KeyboardInterrupt
        return whole(*asked)

    monkeypatch.setattr(shot.FlatDrawing, "pixels", interrupted)
    assert replay(recording, "--film", film, *FLAT) == 130
    assert os.listdir(tmp_path) == [film.name]
    assert film.read_bytes() == b"old"


def pictures(n: int, size: tuple[int, int]):
    rng = np.random.default_rng(1)
    for _ in range(n):
        yield Image.fromarray(rng.integers(0, 255, (*size[::-1], 3), np.uint8))


def test_odd_sizes_become_even_and_a_full_disk_is_said(tmp_path) -> None:
    file = tmp_path / "a.mp4"
    write_mp4(file, pictures(5, (33, 21)), 12.5)
    told, frames = frames_of(file)
    assert frames.shape == (5, 22, 34, 3)
    assert " 12.50 fps" in told
    with (
        full_disk(20_000),
        pytest.raises(ExportError, match=r"a\.mp4: cannot write: ") as caught,
    ):
        write_mp4(file, pictures(60, (320, 240)), 12.0)
    assert "\n" not in str(caught.value)


def test_rests_are_short_and_other_clocks_follow() -> None:
    clock = HandTime()
    assert clock.pass_samples(np.array([5, 6, 60]) * 10**9).tolist() == [0.0, 1.0, 2.0]
    clock.pass_ink(0.5)
    assert clock.pass_samples(np.array([60_700_000_000])).tolist() == pytest.approx([2.7])
    assert clock.pass_samples(np.array([0, 10**8])).tolist() == pytest.approx([3.0, 3.1])
    assert HandTime(in_full=True).pass_samples(np.array([0, 9]) * 10**9).tolist() == [0.0, 9.0]


def test_what_the_packer_refuses_is_said(tmp_path) -> None:
    file = tmp_path / "none" / "a.mp4"
    with pytest.raises(ExportError, match=r"a\.mp4: cannot write: .*none") as caught:
        write_mp4(file, pictures(3, (32, 32)), 12.0)
    assert "\n" not in str(caught.value)
