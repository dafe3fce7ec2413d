"""The shipped recording on a bowl of a million vertices, against the hand that drew it."""

from __future__ import annotations

from functools import reduce
from importlib.resources import files

import numpy as np

from paint3d.bench.result import Check, Result
from paint3d.bench.stopwatch import Times, timed_once
from paint3d.bench.strokes import frames_of, play, play_live, refined_surface
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording, load_recording

__all__ = ["measure"]

_VERTICES = 1_000_000
_FEWEST_SAMPLES = 900  # the brush is down by then
_ROUNDS = 3
_LEAST_TIMES_FASTER = 10.0


def _pen_down_s(recording: Recording) -> float:
    """Sum the time with the brush on the object, s."""
    if recording.pressure is None:
        return recording.duration_s
    steps = np.diff(recording.time_ns) * 1e-9
    return float(steps[recording.pressure[1:] > 0.0].sum())


def measure(scale: float = 1.0) -> Result:
    """Replay the demo live and in one go, and compare with the time the hand took."""
    from paint3d.files.load import load_mesh

    whole = load_recording(str(files("paint3d.calligraphy") / "data" / "demo.jsonl.gz"))
    recording = whole.part(0, max(_FEWEST_SAMPLES, int(len(whole) * scale)))
    surface = refined_surface(load_mesh("bowl"), max(100, int(_VERTICES * scale)))
    painter = Painter(surface, brush=recording.header["brush"], ink=recording.header["ink"])
    play(painter, recording)
    counted = painter.report()["footprints"]
    frames = frames_of(recording)

    def in_one_go() -> None:
        painter.dip()
        painter.replay(recording)
        painter.surface.refresh()

    ways: dict[str, list[Times]] = {}
    for _ in range(_ROUNDS):
        replayed = play(painter, recording)
        ways.setdefault("30 frames/s", []).append(replayed.whole)
        ways.setdefault("30 frames/s, as it comes in", []).append(play_live(painter, frames).whole)
        ways.setdefault("colours at the end", []).append(timed_once(in_one_go))
    best = {name: reduce(Times.best, times) for name, times in ways.items()}
    hand, down = recording.duration_s, _pen_down_s(recording)
    rows = [
        [name, times.wall_s, times.cpu_s, hand / times.wall_s, hand / times.cpu_s,
         down / times.cpu_s, 1e6 * times.cpu_s / counted]
        for name, times in best.items()
    ]  # fmt: skip
    return Result(
        f"The demo ({len(recording):,} samples, {hand:.0f} s by hand, {down:.0f} s of it on the "
        f"object) on a bowl of {surface.n_vertices:,} vertices",
        [
            "way",
            "s",
            "CPU s",
            "x hand",
            "x hand (CPU)",
            "x pen-down time (CPU)",
            "CPU us/footprint",
        ],
        rows,
        [
            Check(
                "times faster than the hand, colours included",
                hand / best["30 frames/s"].wall_s,
                _LEAST_TIMES_FASTER,
                at_most=False,
            )
        ],
        [f"Colours are {replayed.colour_s:.2f} s of the time at 30 frames/s."],
    )
