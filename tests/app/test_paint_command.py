"""paint3d paint where it cannot: one clear line, exit status 2."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from paint3d.bench.start import wait_for
from paint3d.cli.main import main


def test_without_a_display_it_says_so(tmp_path: Path) -> None:
    pytest.importorskip("PySide6", reason="PySide6 is not installed")
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    environment["XDG_CONFIG_HOME"] = str(tmp_path)
    done = subprocess.run(
        [sys.executable, "-m", "paint3d", "paint", "--quiet"],
        capture_output=True, text=True, env=environment, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.startswith("paint3d: error: there is no display")
    assert done.stderr.count("\n") == 1


def test_without_pyside_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [name for name in sys.modules if name.startswith("paint3d.app.window")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "PySide6", None)
    assert main(["paint", "bowl", "--quiet"]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "PySide6" in told
    assert "paint3d[studio]" in told


@pytest.mark.parametrize(
    ("arguments", "word"), [(["no.ply"], "no.ply"), (["bowl", "--material", "jelly"], "jelly")]
)
def test_what_is_not_there_is_named(
    arguments: list[str], word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["paint", *arguments]) == 2
    told = capsys.readouterr().err
    assert told.startswith("paint3d: error:")
    assert word in told
    assert told.count("\n") == 1


def test_the_window_says_that_there_is_no_home_to_write_to(
    program, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from paint3d.app.window import start
    from paint3d.app.window.studio import StudioWindow

    shown: list[StudioWindow] = []
    monkeypatch.setattr(start, "stand_in", lambda: tmp_path)
    monkeypatch.setattr(start, "open_first", lambda window, *_: shown.append(window))
    monkeypatch.setattr(
        type(program), "exec", lambda app: shown[0].status.told.text(), raising=False
    )
    told = start.run_studio(None, language="en")
    shown[0].close()
    assert told.endswith(f"settings and recovery data are kept in {tmp_path}")


def test_a_started_window_is_painted_and_then_hears_the_hand(screen: str, tmp_path: Path) -> None:
    """What `paint3d bench start` times: milestones in order, up to paint from a real stroke."""
    pytest.importorskip("PySide6", reason="PySide6 is not installed")
    program = (sys.executable, "-m", "paint3d.app.window.first_stroke", f"{time.monotonic()}")
    found = wait_for((*program, "paint", "bowl"), tmp_path, home=tmp_path)
    told = [line.partition(" ") for _, line in found.lines]
    assert [what for _, _, what in told] == ["window painted", "hears the hand", "stroke painted"]
    seconds = [float(at) for at, _, _ in told]
    assert seconds == sorted(seconds)
    assert seconds[0] > 0.0
