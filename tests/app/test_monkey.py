"""A monkey at the window; thousands of actions more: `python -m scripts.monkey`."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from tests.support.app.monkey import Monkey
from tests.support.examples import ALL

ACTIONS = 120 if ALL else 25
BY_THE_CLOCK = {"slow", "stuck"}  # which is no matter of a test: kernels may still be compiled


@pytest.fixture(autouse=True, scope="module")
def few_pictures() -> None:
    """Pictures are drawn here as often as users see them."""


@pytest.fixture
def work(tmp_path: Path, places: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in which everything is opened and saved."""
    folder = tmp_path / "work"
    folder.mkdir()
    monkeypatch.chdir(folder)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setenv("PAINT3D_STATE", str(tmp_path / "state"))
    return folder


@pytest.mark.parametrize(
    "start",
    [pytest.param(None, id="empty", marks=pytest.mark.long), pytest.param("plane", id="plane")],
)
def test_nothing_that_is_done_at_random_breaks_it(program, work: Path, start: str | None) -> None:
    monkey = Monkey(program, work, seed=11, start=start)
    faults = [fault for fault in monkey.run(ACTIONS) if fault.kind not in BY_THE_CLOCK]
    told = "\n".join(f"action {fault.number}: {fault.text}" for fault in faults)
    recent = "\n".join(monkey.done[-20:])
    monkey.close()
    assert not faults, f"{told}\nlast done:\n{recent}"


def test_the_monkey_sees_what_goes_wrong(program, work: Path, monkeypatch) -> None:
    """An action that raises, one that fails in the painting's thread, a stroke without an end."""
    monkey = Monkey(program, work, seed=0, start="plane")
    window = monkey.window

    def raising() -> None:
        raise ValueError("made to fail")

    def break_it(rng) -> str:
        window.workspace.actions["frame_all"].trigger()
        window.stage.paint_thread.post(lambda document: 1 / 0)
        window.hand.in_stroke = True
        return "all of it"

    window.workspace.actions["frame_all"].triggered.connect(raising)
    monkeypatch.setattr(monkey, "rest", break_it)
    monkeypatch.setattr(window.hand, "end_stroke", lambda: setattr(window.hand, "in_stroke", False))
    monkey.actions = {"rest": 1.0}
    faults = monkey.run(2)
    monkey.close()
    assert {"traceback", "internal", "state"} <= {fault.kind for fault in faults}
    assert any("made to fail" in fault.text for fault in faults)
    assert any("ZeroDivisionError" in fault.text for fault in faults)
