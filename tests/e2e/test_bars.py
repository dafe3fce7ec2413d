"""On a terminal a bar moves while a command works, whatever it waits for."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from paint3d.cli import painting, report
from paint3d.cli.main import main
from paint3d.cli.progress import ProgressBar
from paint3d.recording.recording import load_recording, save_recording

pty = pytest.importorskip("pty")

_BAR = re.compile(rb"\x1b\[K(\w[\w ]*) \[([#.]+)\]")


def read_until(terminal: int, told: bytes, done: Callable[[bytes], bool]) -> bytes:
    """Read on until what was told satisfies `done`, or the program ends."""
    while not done(told):
        try:
            more = os.read(terminal, 1 << 16)
        except OSError:  # the other end is closed
            return told
        if not more:
            return told
        told += more
    return told


def bars(told: bytes, label: bytes) -> list[bytes]:
    """The bars drawn under a label, one after the other."""
    return [bar for found, bar in _BAR.findall(told) if found == label]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_bar_moves_while_the_file_is_not_there_yet(tmp_path: Path, recording: Path) -> None:
    table, slow = tmp_path / "whole.csv", tmp_path / "slow.csv"
    save_recording(load_recording(recording), table)
    os.mkfifo(slow)
    out = tmp_path / "out.ply"
    command = ["-m", "paint3d", "replay", str(slow), "--on", "plane", "--out", str(out)]
    process, terminal = pty.fork()
    if process == 0:
        os.execv(sys.executable, [sys.executable, *command])
    try:
        told = read_until(terminal, b"", lambda told: len(set(bars(told, b"reading"))) >= 3)
        assert len(set(bars(told, b"reading"))) >= 3, told
        slow.write_bytes(table.read_bytes())
        told = read_until(terminal, told, lambda told: False)
    finally:
        os.close(terminal)
        _, status = os.waitpid(process, 0)
    assert b"vertices painted" in told, told
    assert os.waitstatus_to_exitcode(status) == 0
    assert out.is_file()


def test_every_step_of_a_command_has_its_bar(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, enter = [], ProgressBar.__enter__

    def noted(self: ProgressBar) -> ProgressBar:
        begun.append(self._label.removesuffix(" 1 character"))
        return enter(self)

    monkeypatch.setattr(ProgressBar, "__enter__", noted)
    pad, painted = tmp_path / "pad.csv", tmp_path / "pad.p3d"
    rows = (f"{k * 0.01},{k % 50},{k // 50},0.3" for k in range(100))
    pad.write_text("time_s,x_mm,y_mm,pressure\n" + "\n".join(rows) + "\n")
    on_plane = ["--on", "plane", "--out", str(painted)]
    commands = {
        ("replay", str(pad), *on_plane): "reading reading preparing laying preparing painting "
        "looking writing",
        ("write", "一", *on_plane, "--force", "--recording", f"{pad}"): "looking reading preparing "
        "planning preparing painting writing writing",
        ("export", str(painted), f"{pad}.glb"): "opening writing",
    }
    monkeypatch.setattr(report, "ask_python", lambda code: "nothing")
    for command, labels in commands.items():
        begun.clear()
        monkeypatch.setattr(painting, "_last", {})
        assert main([*command, "--quiet"]) == 0
        assert begun == labels.split(), command
    begun.clear()
    assert main(["report"]) == 0
    assert begun == ["asking"]  # for the renderer, which takes its time on some machines


def test_the_bar_of_spreading_follows_the_ink(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: dict[str, list[float]] = {}

    def noted(self: ProgressBar, fraction: float) -> None:
        drawn.setdefault(self._label, []).append(fraction)

    monkeypatch.setattr(ProgressBar, "__call__", noted)
    out = str(tmp_path / "out.ply")
    command = ["write", "一", "--on", "plane", "--material", "xuan", "--out", out]
    assert main([*command, "--spread", "2", "--quiet"]) == 0
    spreading = drawn["spreading"]
    assert len(spreading) >= 40
    assert spreading == sorted(spreading)
    assert spreading[0] <= 0.05
    assert spreading[-1] == 1.0
    assert drawn["painting"][-1] == 1.0
    assert drawn["painting"].count(1.0) <= 2
