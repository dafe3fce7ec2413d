"""The command line's own parts: options, failures, progress, versions."""

from __future__ import annotations

import argparse
import errno
import io
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
import unicodedata
import weakref
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from paint3d import __main__
from paint3d.bench import registry
from paint3d.bench.result import Check, Result
from paint3d.brush.presets import load_presets
from paint3d.cli import bench, devices, main, options, progress, replay, report
from paint3d.cli.lists.brushes import brush_lines
from paint3d.cli.lists.inks import swatches_table
from paint3d.cli.lists.materials import material_lines
from paint3d.cli.painting import PaintingOptions
from paint3d.colour.materials import load_materials, material_names
from paint3d.colour.pigments import load_palette
from paint3d.core import kernel as compiled_kernels
from paint3d.core.ending import TerminationHandler, TerminationRequested
from paint3d.errors import ExportError, MeshError

SUFFIXES = (".ply", ".p3d.txt")


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def fail_with(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    def run(_: argparse.Namespace) -> None:
        raise error

    monkeypatch.setattr(report, "run", run)


def test_an_option_that_is_not_known_is_told_with_its_command(capsys) -> None:
    assert main.main(["report", "--nosuch", "1"]) == 2
    told = "paint3d: error: unrecognized arguments: --nosuch 1 (see paint3d report --help)\n"
    assert capsys.readouterr().err == told


def test_a_studio_that_lacks_a_library_says_so_in_one_line(monkeypatch, capsys) -> None:
    monkeypatch.setitem(sys.modules, "paint3d.app.window.program", None)
    assert main.main(["paint", "--quiet"]) == 2
    assert "error: the studio needs PySide6, which cannot be loaded (" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "wide", ""])
def test_lengths_above_zero_only(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="expected a number above 0"):
        options.parse_length_mm(text)


def test_length() -> None:
    assert options.parse_length_mm("0.25") == 0.25


@pytest.mark.parametrize("name", ["a.xyz", "a", ".ply", "ply", "a.p3d"])
def test_output_suffix_is_checked(tmp_path: Path, name: str) -> None:
    with pytest.raises(ExportError, match=r"expected a name ending in \.ply, \.p3d\.txt"):
        options.check_output_file(tmp_path / name, SUFFIXES)


def test_output_suffix_in_capitals(tmp_path: Path) -> None:
    options.check_output_file(tmp_path / "A.PLY", SUFFIXES)
    options.check_output_file(tmp_path / "a.P3D.txt", SUFFIXES)


def test_output_folder_must_exist(tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="there is no folder"):
        options.check_output_file(tmp_path / "no" / "a.ply", SUFFIXES)


def test_output_must_not_be_a_folder(tmp_path: Path) -> None:
    (tmp_path / "a.ply").mkdir()
    with pytest.raises(ExportError, match="is a folder"):
        options.check_output_file(tmp_path / "a.ply", SUFFIXES)


def test_a_file_is_no_output_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ExportError, match="is not a folder"):
        options.check_output_folder(tmp_path / "file" / "below")
    options.check_output_folder(tmp_path / "new" / "newer")


def test_usage_errors_are_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["replay"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("paint3d: error: the following arguments are required: RECORDING")
    assert err.count("\n") == 1


@pytest.mark.parametrize("arguments", [["fly"], ["report", "--loud"], ["--nothing"]])
def test_unknown_commands_and_options(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(arguments) == 2
    err = capsys.readouterr().err
    assert err.startswith("paint3d: error: ")
    assert err.count("\n") == 1


def test_a_message_of_several_lines_becomes_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    fail_with(monkeypatch, MeshError("jug.ply:\n  no faces"))
    assert main.main(["report"]) == 2
    assert capsys.readouterr().err == "paint3d: error: jug.ply: no faces\n"


def test_an_unexpected_exception_is_one_line_with_a_hint(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("PAINT3D_DEBUG", raising=False)
    fail_with(monkeypatch, ZeroDivisionError("oh"))
    assert main.main(["report"]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "ZeroDivisionError: oh" in err
    assert "PAINT3D_DEBUG=1" in err


def test_debugging_shows_the_traceback(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PAINT3D_DEBUG", "1")
    fail_with(monkeypatch, ZeroDivisionError("oh"))
    assert main.main(["report"]) == 2
    assert "Traceback" in capsys.readouterr().err


def test_interrupted(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    fail_with(monkeypatch, KeyboardInterrupt())
    assert main.main(["report"]) == 130
    assert capsys.readouterr().err == "paint3d: error: interrupted\n"


class Gone(io.StringIO):
    """A terminal that was closed."""

    def write(self, text: str) -> int:
        raise OSError(errno.EIO, os.strerror(errno.EIO))


@pytest.mark.parametrize(
    ("error", "status"), [(KeyboardInterrupt(), 130), (ExportError("a"), 2), (OSError(5, "b"), 2)]
)
def test_where_the_terminal_is_gone_the_status_tells(
    monkeypatch: pytest.MonkeyPatch, error: BaseException, status: int
) -> None:
    fail_with(monkeypatch, error)
    monkeypatch.setattr(sys, "stderr", Gone())
    assert main.main(["report"]) == status


def drop_an_interrupt() -> None:
    """Have an interrupt come in a callback of Python's, as in one of an import."""

    class Held:
        pass

    def interrupted(_: object) -> None:
        raise KeyboardInterrupt

    held = Held()
    dropping = weakref.ref(held, interrupted)
    del held
    assert dropping() is None


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Interrupts are heard, as they are not in a job that a script has begun in the background."""
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, handler)


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("posix", [True, False])
def test_an_interrupt_that_python_drops_is_heard(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], posix: bool
) -> None:
    """As one that comes in a callback of an import: the command went on as if nothing were."""

    def work(_: object) -> int:
        drop_an_interrupt()
        for _ in range(1 if posix else 600):  # elsewhere it is heard when it has slept
            time.sleep(60.0 if posix else 0.1)
        return 0

    if not posix:
        monkeypatch.delattr(signal, "pthread_kill")
    before = sys.unraisablehook
    monkeypatch.setattr(main, "_run", work)
    assert main.main(["report"]) == 130
    assert capsys.readouterr().err == "paint3d: error: interrupted\n"
    assert sys.unraisablehook is before


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_that_is_dropped_while_its_sender_is_imported_is_heard(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    machine = sys.modules["paint3d.core.machine"]

    def work(_: object) -> int:
        monkeypatch.setitem(sys.modules, machine.__name__, ModuleType(machine.__name__))
        drop_an_interrupt()
        monkeypatch.setitem(sys.modules, machine.__name__, machine)
        time.sleep(10.0)
        return 0

    monkeypatch.setattr(main, "_AGAIN_S", 0.5)
    monkeypatch.setattr(main, "_run", work)
    assert main.main(["report"]) == 130


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_that_is_dropped_as_a_command_ends_is_not_sent_to_who_follows(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It ended the interpreter's own end with a traceback."""

    def work(_: object) -> int:
        drop_an_interrupt()
        return 0

    monkeypatch.setattr(main, "_AGAIN_S", 10.0)
    monkeypatch.setattr(main, "_run", work)
    assert main.main(["report"]) == 0
    assert not any(isinstance(thread, threading.Timer) for thread in threading.enumerate())


def test_what_else_python_drops_is_told_as_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    class Bad:
        def __del__(self) -> None:
            raise ZeroDivisionError

    def work(_: object) -> int:
        Bad()
        return 0

    told: list[type] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda dropped: told.append(dropped.exc_type))
    monkeypatch.setattr(main, "_run", work)
    assert main.main(["report"]) == 0
    assert told == [ZeroDivisionError]


@pytest.mark.parametrize("dropped", [False, True])
def test_an_interrupt_before_the_program_is_loaded_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], dropped: bool
) -> None:
    class Interrupting:
        def find_spec(self, name: str, *_: object) -> None:
            if name == "paint3d.cli.main":
                if not dropped:
                    raise KeyboardInterrupt
                drop_an_interrupt()

    before = sys.unraisablehook
    monkeypatch.setattr(sys, "argv", ["paint3d", "--version"])
    monkeypatch.delitem(sys.modules, "paint3d.cli.main")
    monkeypatch.setattr(sys, "meta_path", [Interrupting(), *sys.meta_path])
    assert __main__.run() == 130
    assert capsys.readouterr() == ("", "paint3d: error: interrupted\n")
    assert sys.unraisablehook is before


def test_a_second_interrupt_while_the_first_is_told_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted() -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(main, "main", interrupted)
    assert __main__.run() == 130
    assert capsys.readouterr().err == "paint3d: error: interrupted\n"


def test_a_failure_that_nobody_reads_has_its_status() -> None:
    """As with `2>&1 | true`: it was 1, of a traceback that nobody read either."""
    reader, writer = os.pipe()
    os.close(reader)
    try:
        done = subprocess.run([sys.executable, "-m", "paint3d", "nonsense"], stderr=writer)
    finally:
        os.close(writer)
    assert done.returncode == 2


def test_system_errors_name_the_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    fail_with(monkeypatch, PermissionError(13, "Permission denied", "secret.ply"))
    assert main.main(["report"]) == 2
    assert capsys.readouterr().err == "paint3d: error: secret.ply: Permission denied\n"


def test_replay_refuses_the_output_before_it_reads_anything(tmp_path: Path) -> None:
    parser = argparse.ArgumentParser()
    replay.add_arguments(parser)
    wrong = tmp_path / "a.xyz"
    chosen = parser.parse_args(["missing.jsonl", "--on", "missing.obj", "--out", str(wrong)])
    with pytest.raises(ExportError, match="unknown kind of file"):
        replay.run(chosen)


def test_progress_is_drawn_on_a_terminal_and_erased() -> None:
    stream = Terminal()
    with progress.ProgressBar("painting", stream=stream) as bar:
        bar(0.5)
    assert "50%" in stream.getvalue()
    assert stream.getvalue().endswith("\r\x1b[K")
    assert "\n" not in stream.getvalue()


def test_the_time_that_is_left_runs_down_and_is_not_told_when_it_is_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stream, now = Terminal(), [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    bar, said = progress.ProgressBar("painting", stream=stream), []
    for now[0] in (4.0, 7.0, 12.0):  # all the while half is done
        bar(0.5)
        said.append(stream.getvalue().rsplit("]", 1)[1])
    assert [" ".join(told.split()) for told in said] == ["50% 4 s left", "50% 1 s left", "50% 12 s"]


def test_a_bar_moves_while_nothing_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "_TICK_S", 0.001)
    stream = Terminal()
    with progress.ProgressBar("preparing", stream=stream) as bar:
        for told in ("preparing [###", "preparing [.###", "preparing [..###"):
            while told not in stream.getvalue():  # the suite's limit ends what never comes
                time.sleep(0.001)
        bar(0.5)
        while "50%" not in stream.getvalue():
            time.sleep(0.001)
    assert not any(thread.name == "progress" for thread in threading.enumerate())
    assert stream.getvalue().endswith("\r\x1b[K")
    assert "\n" not in stream.getvalue()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_what_goes_on_until_then_and_cuts_no_round_short(number: int) -> None:
    """As in the middle of reading what a hand has drawn, which was lost."""
    handler = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
    before = signal.signal(number, handler)
    whole = []
    try:
        for _ in devices.rounds(None, 0.0):
            signal.raise_signal(number)
            whole.append(len(whole))
        assert signal.getsignal(number) is handler
        with TerminationHandler(grace_s=0.1) as ends:
            for _ in devices.rounds(None, 0.2):  # it is no end of the program
                signal.raise_signal(number)
                whole.append(len(whole))
            time.sleep(0.3)
        assert ends.status == 0
    finally:
        signal.signal(number, before)
    assert whole == [0, 1]


class Closing(Terminal):
    """A terminal that is closed while something is told."""

    is_closed = False

    def write(self, text: str) -> int:
        if self.is_closed:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return super().write(text)


def test_the_work_goes_on_where_its_terminal_is_gone() -> None:
    terminal = Closing()
    with progress.ProgressBar("a", stream=terminal) as bar:
        bar(0.5)
        terminal.is_closed = True
        time.sleep(0.1)
        bar(0.7)
        bar.note("b")
    assert "50%" in terminal.getvalue()


def test_asked_to_end_by_a_closed_terminal_is_no_fault_of_the_bar() -> None:
    """What clears the line could not be written, which stood for the error."""
    terminal = Closing()

    def work() -> None:
        with progress.ProgressBar("a", stream=terminal):
            terminal.is_closed = True
            raise TerminationRequested

    with pytest.raises(TerminationRequested):
        work()


def test_rounds_go_on_in_a_thread_that_hears_no_signals() -> None:
    whole: list[None] = []
    thread = threading.Thread(target=lambda: whole.extend(devices.rounds(0.05, 0.01)))
    thread.start()
    thread.join()
    assert whole


def test_progress_is_silent_in_a_pipe_for_what_is_soon_done_and_when_quiet() -> None:
    pipe, terminal = io.StringIO(), Terminal()
    with progress.ProgressBar("a", stream=pipe) as in_pipe:
        in_pipe(0.5)
    for stream in (pipe, terminal):
        with progress.ProgressBar("a", stream=stream, enabled=False) as quiet:
            quiet(0.5)
    assert pipe.getvalue() == terminal.getvalue() == ""


class Broken(io.StringIO):
    """A pipe that nobody reads any more."""

    def write(self, text: str) -> int:
        raise BrokenPipeError


def test_what_takes_long_says_a_few_lines_in_a_pipe(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "_FIRST_LINE_S", 0.001)
    pipe, caught = io.StringIO(), []
    monkeypatch.setattr(threading, "excepthook", caught.append)
    with progress.ProgressBar("painting", stream=pipe) as bar:
        while "painting    0 s\n" not in pipe.getvalue():  # the suite's limit ends what never comes
            time.sleep(0.001)
        bar(0.5)
        while "painting  50%" not in pipe.getvalue():
            time.sleep(0.001)
    assert "\r" not in pipe.getvalue()
    assert pipe.getvalue().count("\n") < 16  # each after twice the time
    with progress.ProgressBar("painting", stream=Broken()) as bar:
        bar._ticker.join()
    assert not caught


@pytest.mark.parametrize("compiled", [False, True])
def test_it_is_said_that_loops_are_compiled_where_they_are_not(
    compiled: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(compiled_kernels, "is_compiled", lambda kernel: compiled)
    progress.say_if_compiling(quiet=True)
    assert capsys.readouterr().err == ""
    progress.say_if_compiling(quiet=False)
    said = capsys.readouterr().err
    assert said.startswith("compiling the brush (once, about ") is not compiled
    assert bool(said) is not compiled


def test_versions_name_what_decides_the_result() -> None:
    found = report.find_versions()
    assert {"paint3d", "python", "numpy", "numba"} <= set(found)
    assert all(found.values())


def test_report_survives_what_is_missing() -> None:
    missing = report.ask_python("import nothing_of_this_name")
    assert missing.startswith("unknown (ModuleNotFoundError")
    assert report.ask_python("import os; os._exit(3)") == "unknown (exit status 3)"
    assert report.ask_python("print('llvmpipe')") == "llvmpipe"


def test_a_benchmark_is_shown_as_a_table_with_its_bounds() -> None:
    checks = [Check("ratio", 1.25, 1.3), Check("speed", 2.0, 10.0, at_most=False, unit="M/s")]
    rows = [["grid", 4_000_000, 12.3456], ["sphere", None, 98765.4]]
    result = Result("Cost", ["mesh", "vertices", "us"], rows, checks, ["one core"])
    assert bench.format_result(result) == [
        "Cost",
        "    mesh   vertices      us",
        "    grid  4,000,000   12.35",
        "  sphere          -  98,765",
        "  kept    ratio: 1.25 (wanted <= 1.3)",
        "  MISSED  speed: 2 (wanted >= 10) M/s",
        "  one core",
    ]


def test_benchmarks_are_checked_before_any_runs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(registry, "run_benchmark", lambda name: pytest.fail(f"ran {name}"))
    assert main.main(["bench", "scaling", "scalling"]) == 2
    assert "did you mean 'scaling'?" in capsys.readouterr().err
    assert main.main(["bench", "scaling", "--json", str(tmp_path / "a.txt")]) == 2
    assert "expected a name ending in .json" in capsys.readouterr().err


def test_benchmarks_are_written_as_json(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    result = Result("Cost", ["us"], [[1.5]])
    monkeypatch.setattr(registry, "run_benchmark", lambda _: result)
    assert main.main(["bench", "scaling", "--json", str(tmp_path / "a.json"), "--quiet"]) == 0
    assert capsys.readouterr().out.splitlines()[0] == "Cost"
    told = json.loads((tmp_path / "a.json").read_text())
    assert told["benchmarks"]["scaling"]["rows"] == [[1.5]]
    assert told["versions"]["numpy"]


def test_help_names_every_material() -> None:
    parser = argparse.ArgumentParser()
    PaintingOptions.add_to(parser, "material")
    told = " ".join(parser.format_help().split())
    assert all(name in told for name in material_names())


def test_what_takes_long_is_told_on_a_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    # of a kind of its own: read by the child that users have, which tells how far it is
    Path("sheet.slow.obj").write_text("v 0 0 0\nv 90 0 0\nv 90 90 0\nv 0 90 0\nf 1 2 3 4\n")
    pose = '"position":[45,45,30],"orientation":[1,0,0,0]'
    lines = [f'{{"time_ns":{k},{pose},"pressure":0.3}}' for k in (0, 10**7)]
    header = '{"format":"paint3d-recording","version":1}'
    Path("a.jsonl").write_text("\n".join([header, *lines]))
    replayed = "replay a.jsonl --on sheet.slow.obj --resolution 4 --out a.p3d"
    for line, told in (
        (replayed, ("reading", "painting", "writing")),
        ("export a.p3d a.glb", ("opening", "writing")),
    ):
        terminal = Terminal()
        monkeypatch.setattr(sys, "stderr", terminal)
        assert main.main(line.split()) == 0
        assert all(f"{what} [" in terminal.getvalue() for what in told), terminal.getvalue()
        quiet = Terminal()
        monkeypatch.setattr(sys, "stderr", quiet)
        assert main.main([*line.split(), "--quiet", "--force"]) == 0
        assert quiet.getvalue() == ""


# -- tables ------------------------------------------------------------------------------------


TABLES = {
    "inks": lambda **how: swatches_table(load_palette().values(), **how),
    "materials": lambda **how: material_lines(load_materials().values(), **how),
    "brushes": lambda columns=None, colour=False: brush_lines(
        load_presets().values(),
        dict.fromkeys(load_presets(), "for long lines of text " * 6),
        columns,
    ),
}
NAMES = {"inks": load_palette, "materials": load_materials, "brushes": load_presets}


def width(line: str) -> int:
    plain = re.sub("\x1b\\[[0-9;]*m", "", line)
    return sum(2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in plain)


@pytest.mark.parametrize("colour", [False, True])
@pytest.mark.parametrize("columns", [80, 120, 200])
@pytest.mark.parametrize("table", TABLES)
def test_a_table_fits_the_terminal(table: str, columns: int, colour: bool) -> None:
    lines = TABLES[table](columns=columns, colour=colour)
    assert max(map(width, lines)) <= columns
    whole = " ".join(" ".join(TABLES[table]()).split())
    fitted = re.sub("\x1b\\[[0-9;]*m", "", " ".join(lines))
    assert set(whole.split()) == set(fitted.split())  # nothing is lost


@pytest.mark.parametrize("table", TABLES)
def test_a_pipe_gets_one_line_a_row(table: str) -> None:
    assert len(TABLES[table]()) == 1 + len(NAMES[table]())
