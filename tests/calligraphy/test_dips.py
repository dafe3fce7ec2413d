"""When the brush is dipped, and how its load falls until then."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import make_footprint
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import DipAmount
from paint3d.calligraphy.dips import LEAST_LOAD, apply_dip_option, ink_taken, remove_dips
from paint3d.cli.main import main
from paint3d.colour.materials import load_material
from paint3d.device.recorded import Recording
from paint3d.device.sample import DIP
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import load_recording, save_recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.laws.test_painting_laws import plane
from tests.support.cases import long_but

BRUSH = load_brush("xiaobaiyun")
WIDTH = make_footprint(build_tuft(BRUSH), 0.5 * BRUSH.full_press_mm, 0.5 * np.pi, pe=0.5).width
PER_MM = BRUSH.transfer_per_mm * (0.4 * 0.5 + 0.35 * WIDTH / BRUSH.root_diameter_mm)

XUAN, PORCELAIN = load_material("xuan"), load_material("porcelain")


def text(takes: list[float], steps: list[float] | None = None) -> Recording:
    """Characters one below the other, each a straight stroke that takes so much ink."""
    steps = steps or [20.0] * len(takes)
    place, pressure, buttons = [], [], []
    for k, way in enumerate(takes):
        x = np.linspace(0.0, way / PER_MM, 11)
        y = -sum(steps[: k + 1])
        place += [[0.0, y, 40.0], [0.0, y, 40.0], *[[d, y, 18.0] for d in x], [x[-1], y, 40.0]]
        pressure += [0.0, 0.0, *[0.5] * 11, 0.0]
        buttons += [DIP, 0, *[0] * 12]
    turn = np.tile([1.0, 0.0, 0.0, 0.0], (len(place), 1))
    times = 4_000_000 * np.arange(len(place))
    return Recording(times, np.array(place), turn, np.array(pressure), np.array(buttons, np.int32))


def left(taken: float, load: float = 1.0) -> float:
    """Load of a brush after `taken` on paper: f + k ln f falls by (1 + k) times that."""
    k = 0.1
    return brentq(lambda f: f + k * np.log(f / load) - load + (1.0 + k) * taken, 1e-12, load)


def dipped_before(recording: Recording) -> list[int]:
    """The characters of `text` that the brush is dipped for."""
    return np.flatnonzero((recording.buttons[::14] & DIP) != 0).tolist()


@lru_cache(maxsize=1)
def demo() -> Recording:
    return load_recording(files("paint3d.calligraphy").joinpath("data/demo.jsonl.gz"))


def test_each_character_takes_what_its_way_and_pressure_say() -> None:
    recording = text([0.1, 0.02])
    taken = ink_taken(recording, BRUSH, XUAN)
    assert taken[:14].sum() == pytest.approx(0.1)
    assert taken[14:].sum() == pytest.approx(0.02)


def test_the_brush_is_dipped_where_the_load_would_fall_too_low() -> None:
    recording = remove_dips(text([0.1] * 9), BRUSH, None, XUAN)
    assert dipped_before(recording) == [0, 4, 8]
    amount = DipAmount.of(recording.header["dip"])
    assert left(4 * 0.1 / amount.wetted) == pytest.approx(LEAST_LOAD, rel=1e-3)


@pytest.mark.parametrize("seed", range(8))
def test_no_character_ends_with_less_than_a_dip_is_to_leave(seed: int) -> None:
    random = np.random.default_rng(seed)
    takes = random.uniform(0.001, 0.5, random.integers(1, 13)).tolist()
    recording = remove_dips(text(takes), BRUSH, None, XUAN)
    wetted = recording.header["dip"]["wetted"]
    load, dips = 1.0, dipped_before(recording)
    for k, taken in enumerate(takes):
        load = left(taken / wetted, 1.0 if k in dips else load)
        assert load > LEAST_LOAD * (1.0 - 1e-3) or wetted == 1.0
    assert dips[0] == 0


def test_every_third() -> None:
    recording = remove_dips(text([0.1, 0.2, 0.1, 0.05, 0.05, 0.1, 0.3]), BRUSH, 3, XUAN)
    assert dipped_before(recording) == [0, 3, 6]
    wetted = recording.header["dip"]["wetted"]
    assert left(0.4 / wetted) == pytest.approx(LEAST_LOAD, rel=1e-3)


def test_a_column_is_not_begun_with_a_brush_that_is_nearly_dry() -> None:
    """Three of a column leave enough for one more character, and not for two."""
    same = remove_dips(text([0.1] * 6), BRUSH, None, XUAN)
    columns = remove_dips(text([0.1] * 6, [20.0] * 3 + [60.0] + [20.0] * 2), BRUSH, None, XUAN)
    assert dipped_before(same) == [0, 4]
    assert dipped_before(columns) == [0, 3]


@pytest.mark.parametrize(
    ("takes", "every", "dipped"),
    [
        ([0.5, 0.5, 0.3, 0.7], None, [0, 1, 3]),
        ([0.5, 0.5, 0.3, 0.7], 1, [0, 1, 3]),
        ([1.5, 0.1, 0.1], None, [0, 1]),  # nothing is done for one long stroke but at its ends
        ([0.2, 0.3, 0.3], None, [0]),
    ],
)
def test_a_character_that_takes_more_than_the_brush_holds_is_dipped_for_between_its_strokes(
    takes: list[float], every: int | None, dipped: list[int]
) -> None:
    strokes = text(takes)
    one = replace(strokes, buttons=np.where(np.arange(len(strokes)) == 0, DIP, 0).astype(np.int32))
    recording = remove_dips(one, BRUSH, every, XUAN)
    assert dipped_before(recording) == dipped
    assert not recording.buttons[recording.pressure > 0.0].any()


def test_always_is_as_it_was_planned() -> None:
    assert apply_dip_option(demo(), BRUSH, "always", XUAN) is demo()


def test_the_hand_goes_the_same_way() -> None:
    recording = apply_dip_option(demo(), BRUSH, "auto", PORCELAIN)
    np.testing.assert_array_equal(recording.position, demo().position)
    np.testing.assert_array_equal(recording.pressure, demo().pressure)
    assert not (recording.buttons & ~demo().buttons).any()


def test_what_is_foretold_is_what_is_left() -> None:
    """Over the demo's characters the load falls nearly as far as was foretold.

    Strokes that cross leave no film where another has, of which nothing is foretold.
    """
    recording = apply_dip_option(demo(), BRUSH, "auto", PORCELAIN)
    amount = DipAmount.of(recording.header["dip"])
    surface = PaintedSurface(load_mesh("bowl"), 0.3, PORCELAIN)
    painter = Painter(surface, BRUSH, "pine soot", amount=amount)
    painter.replay(recording)
    foretold = ink_taken(recording, BRUSH, PORCELAIN).sum() / amount.wetted
    fallen = -np.log(painter.in_brush() / painter.tuft.load)
    assert 0.87 * foretold < fallen < foretold
    accounts = painter.ledger()
    total = sum(accounts.values()) - accounts["loaded"]
    assert total == pytest.approx(accounts["loaded"], rel=1e-6)


@pytest.mark.parametrize("hairs", [0, 200])
def test_a_small_dip_gives_as_much_at_first_and_runs_dry_sooner(hairs: int) -> None:
    left = {}
    for amount in (DipAmount(), DipAmount(0.1, 1.5)):
        surface = PaintedSurface(plane(40.0), 0.8)
        painter = Painter(surface, BRUSH, "pine soot", hairs=hairs, amount=amount)
        x = np.linspace(-15.0, 15.0, 61)
        place = np.column_stack([x, 0 * x, 15.0 + 0 * x])
        turn = np.tile([1.0, 0.0, 0.0, 0.0], (61, 1))
        painter.replay(Recording(4_000_000 * np.arange(61), place, turn, np.full(61, 0.3)))
        surface.refresh()
        at = np.asarray(surface.mesh.vertices)[:, 0]
        ink = np.asarray(surface.amounts).sum(axis=1)
        left[amount] = [ink[abs(at - x0) < 2.0].sum() for x0 in (-12.0, 12.0)]
    (first, last), (small_first, small_last) = left.values()
    assert 0.75 < small_first / first < 1.9
    assert small_last / small_first < 0.6 * last / first


@pytest.mark.parametrize("words", [{"wetted": 0.0}, {"fullness": 9.0}, {"wet": 1.0}, "half", [1]])
def test_amounts_that_are_none(words: object) -> None:
    with pytest.raises(InputError, match="expected"):
        DipAmount.of(words)


@pytest.mark.parametrize("every", [0, 1.5])
def test_dips_before_no_count_of_characters(every: float) -> None:
    with pytest.raises(InputError, match="expected"):
        remove_dips(text([0.1]), BRUSH, every, XUAN)


def test_an_amount_is_of_a_whole_dip() -> None:
    painter = Painter(PaintedSurface(plane(), 0.8), BRUSH)
    with pytest.raises(InputError, match="whole dip"):
        painter.dip("pine soot", 0.3, DipAmount(0.5))
    painter.dip(amount=DipAmount(0.5))
    assert painter.in_brush() == pytest.approx(0.5 * BRUSH.load)
    painter.dip()
    assert painter.in_brush() == pytest.approx(0.5 * BRUSH.load)


# -- from the command line ----------------------------------------------------------------------


@pytest.mark.parametrize("dip", long_but(["auto"], ["auto", "every 2", "always"]))
def test_replayed_it_is_the_same_to_the_byte(tmp_path: Path, dip: str) -> None:
    """What was written, from the recording that was kept of it, in a mixture."""
    ink = ["--ink", "pine soot:0.6,water:0.4"]
    on = ["--on", "plane", "--resolution", "0.8", "--quiet"]
    written, again, way = (tmp_path / name for name in ("a.ply", "b.ply", "way.jsonl"))
    words = ["write", "三人川", "--size", "20", "--dip", dip, "--out", str(written)]
    assert main([*words, "--recording", str(way), *on, *ink]) == 0
    assert main(["replay", str(way), *on, "--out", str(again)]) == 0
    assert written.read_bytes() == again.read_bytes()


def test_dips_that_are_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--dip", "often", "--out", str(tmp_path)]) == 2
    assert "expected auto, always, or a count" in capsys.readouterr().err


def test_a_header_with_an_amount_that_is_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    way = tmp_path / "way.jsonl"
    save_recording(text([0.1]), way)
    header, *rest = way.read_text().splitlines(keepends=True)
    way.write_text(json.dumps(json.loads(header) | {"dip": {"wetted": 7}}) + "\n" + "".join(rest))
    assert main(["replay", str(way), "--on", "plane", "--out", str(tmp_path / "a.ply")]) != 0
    error = capsys.readouterr().err
    assert "the header: wetted share" in error
    assert error.count("\n") == 1
