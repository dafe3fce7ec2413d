"""Who is asked to end, or killed, leaves no half of a file; scripts/kill_commands tries more."""

from __future__ import annotations

import contextlib
import errno
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from paint3d.cli import main
from paint3d.core import atomic
from paint3d.core.atomic import write_atomically
from paint3d.core.ending import TerminationHandler, TerminationRequested, remove_unfinished
from paint3d.core.machine import create_locked, this_machine
from paint3d.errors import ExportError

PATIENCE_S = 300.0
ROOT = Path(__file__).parents[2]
WRITING = """
import multiprocessing, os, subprocess, sys, time
from pathlib import Path
from paint3d.core.atomic import write_atomically
from paint3d.core.ending import TerminationHandler, end_now
from paint3d.core.machine import end_with_parent

def write(wait):
    with write_atomically(Path(sys.argv[1]) / "o.png") as part:
        part.write_text("half")
        print(part.name, flush=True)
        wait()

def compute():
    os.system("echo; sleep 3")  # as a kernel, it lets other threads run, and hears of nothing

def help_parent():
    end_with_parent(end_now)
    write(lambda: time.sleep(100))
"""
HOST = """
import asyncio, os, signal

async def work():
    heard = asyncio.Event()
    asyncio.get_running_loop().add_signal_handler(signal.SIGUSR1, heard.set)
    with TerminationHandler():
        signal.raise_signal(signal.SIGUSR1)
        time.sleep(0.1)
    await asyncio.wait_for(heard.wait(), 300.0)
    print("heard")

asyncio.run(work())
"""
FORKING = """
import os, signal
with TerminationHandler(grace_s=0.1) as ends:
    if not (child := os.fork()):
        signal.raise_signal(signal.SIGTERM)
        os._exit(0)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if not os.fork():
        ends.__exit__()
        os._exit(0)
    os.wait()
    time.sleep(0.5)
    print(status, ends.status, ends._thread.is_alive())
"""
HOLDING = """
import signal, threading
from paint3d.core.ending import holding_interrupts

threading.Thread(target=time.sleep, args=(100,), daemon=True).start()  # as a library's: it hears
with TerminationHandler() as ends:
    try:
        with holding_interrupts():
            os.kill(os.getpid(), signal.SIGTERM)
            for _ in range(100):
                time.sleep(0.001)
            print("held", ends.status)
        print("over")
    except KeyboardInterrupt:
        print("told", ends.status)
"""
ALONE = "\nwrite(lambda: time.sleep(100))"
AT_ONCE = "\nwith TerminationHandler(grace_s=0.0): write(lambda: time.sleep(100))"
COMPUTING = "\nwith TerminationHandler(grace_s=0.2): write(compute); time.sleep(100)"
OPENING = """
import contextlib, threading

exit_now = os._exit
os._exit = lambda status: (time.sleep(0.2), exit_now(status))

def open_again(path):
    while True:
        with contextlib.suppress(OSError):
            open(path, "w").close()

def go_on():
    path = next(os.scandir(sys.argv[1])).path
    threading.Thread(target=open_again, args=(path,), daemon=True).start()
    time.sleep(100)

with TerminationHandler(grace_s=0.0): write(go_on)
"""
CHILD = """
if __name__ == "__main__":
    child = multiprocessing.get_context("fork").Process(target=help_parent)
    child.start()
    child.join()
"""
SERVING = """
from paint3d.cli.batches import workers

workers.run_row = lambda row: write(lambda: time.sleep(100))
ours, theirs = multiprocessing.Pipe()
ours.send((1, "a.png", ()))
"""
SERVED_HERE = SERVING + "workers._serve(theirs)"
SERVED_BY_A_CHILD = CHILD.replace("help_parent", "workers._serve, args=(theirs,)")
needs_signals = pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no such signals")


@pytest.fixture
def asked() -> Iterator[None]:
    """Signals that ask to end are heard as by a program that was started by itself."""
    before = {n: signal.signal(n, signal.SIG_DFL) for n in (signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def until(is_so) -> None:
    began = time.monotonic()
    while not is_so():
        assert time.monotonic() - began < PATIENCE_S
        time.sleep(0.01)


def writing(code: str, folder: Path) -> tuple[subprocess.Popen[str], Path]:
    """A program that is in the middle of writing, and its file."""
    running = subprocess.Popen(
        [sys.executable, "-c", WRITING + code, str(folder)],
        stdout=subprocess.PIPE, text=True, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert running.stdout is not None
    return running, folder / running.stdout.readline().rstrip("\n")


def ended(running: subprocess.Popen[str], number: int) -> int:
    running.send_signal(number)
    running.communicate(timeout=PATIENCE_S)
    return running.returncode


@needs_signals
@pytest.mark.usefixtures("asked")
@pytest.mark.parametrize(("name", "status"), [("SIGTERM", 143), ("SIGHUP", 129)])
def test_a_command_that_is_asked_to_end_leaves_the_old_file(
    tmp_path: Path, monkeypatch, capsys, name: str, status: int
) -> None:
    (tmp_path / "o.png").write_text("old")
    ended: list[str] = []

    def work(words: list[str]) -> int:
        with write_atomically(tmp_path / "o.png") as part:
            part.write_text("new")
            try:
                signal.raise_signal(getattr(signal, name))
            finally:
                signal.raise_signal(getattr(signal, name))  # once more: it ends in peace
                ended.append(name)
        return 0

    monkeypatch.setattr(main, "_run", work)
    assert main.main(["report"]) == status
    assert ended == [name]
    assert capsys.readouterr().err == "paint3d: error: asked to end\n"
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [("o.png", "old")]
    assert signal.getsignal(getattr(signal, name)) is signal.SIG_DFL


@pytest.mark.usefixtures("asked")
def test_where_pipes_tell_of_no_signals_the_main_thread_hears(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.delattr(signal, "pthread_kill", raising=False)
    monkeypatch.delattr(os, "set_blocking")
    ends = TerminationHandler()
    with pytest.raises(TerminationRequested), ends, write_atomically(tmp_path / "o.png"):
        signal.raise_signal(signal.SIGTERM)
    assert ends.status == 143
    assert list(tmp_path.iterdir()) == []


@needs_signals
def test_no_name_that_can_be_had_is_told(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(atomic.secrets, "token_hex", lambda n: "1111")
    monkeypatch.setattr(atomic, "_TIDY", {tmp_path})
    (tmp_path / f".o.png.paint3d-{this_machine()}1111.png").write_text("another's")
    with (
        pytest.raises(ExportError, match="cannot write here"),
        write_atomically(tmp_path / "o.png"),
    ):
        pass


@pytest.mark.usefixtures("asked")
def test_the_studio_is_ended_by_the_system(monkeypatch) -> None:
    """What is painted is kept all the time: to wait for an answer of the window gains nothing."""
    handlers: list[object] = []

    def look(words: list[str]) -> int:
        handlers.append(signal.getsignal(signal.SIGTERM))
        return 0

    monkeypatch.setattr(main, "_run", look)
    assert main.main(["paint"]) == main.main(["report"]) == 0
    assert handlers[0] is signal.SIG_DFL is not handlers[1]


@needs_signals
@pytest.mark.parametrize("code", [AT_ONCE, COMPUTING])
def test_who_hears_nothing_is_ended_all_the_same(tmp_path: Path, code: str) -> None:
    running, part = writing(code, tmp_path)
    assert part.read_text() == "half"
    if code == COMPUTING:
        running.stdout.readline()  # it has begun to
    assert ended(running, signal.SIGTERM) == 143
    assert list(tmp_path.iterdir()) == []


@needs_signals
def test_who_is_about_to_write_makes_nothing_anew(tmp_path: Path) -> None:
    """Writers open their file by its name, and did so after it had been removed."""
    running, _ = writing(OPENING, tmp_path)
    assert ended(running, signal.SIGTERM) == 143
    assert list(tmp_path.iterdir()) == []


@needs_signals
def test_the_parents_end_ends_what_a_process_is_writing(tmp_path: Path) -> None:
    running, part = writing(CHILD, tmp_path)
    assert part.is_file()
    assert ended(running, signal.SIGKILL) == -signal.SIGKILL
    until(lambda: list(tmp_path.iterdir()) == [])


@needs_signals
@pytest.mark.parametrize(
    ("code", "number"),
    [(SERVED_HERE, signal.SIGTERM), (SERVING + SERVED_BY_A_CHILD, signal.SIGKILL)],
    ids=["it is asked to end", "its parent is killed"],
)
def test_a_process_of_a_batch_leaves_nothing_of_its_row(
    tmp_path: Path, code: str, number: int
) -> None:
    running, part = writing(code, tmp_path)
    assert part.read_text() == "half"
    assert ended(running, number) == (143 if number == signal.SIGTERM else -number)
    until(lambda: list(tmp_path.iterdir()) == [])


def test_an_interrupt_removes_what_threads_are_writing(tmp_path: Path, monkeypatch) -> None:
    begun, over = threading.Event(), threading.Event()

    def write() -> None:
        with contextlib.suppress(ExportError), write_atomically(tmp_path / "o.png"):
            begun.set()
            over.wait(PATIENCE_S)

    def work(words: list[str]) -> int:
        thread.start()
        begun.wait(PATIENCE_S)
        raise KeyboardInterrupt

    thread = threading.Thread(target=write)
    monkeypatch.setattr(main, "_run", work)
    assert main.main(["report"]) == 130
    left = list(tmp_path.iterdir())
    over.set()
    thread.join()
    assert left == list(tmp_path.iterdir()) == []


@needs_signals
def test_a_new_file_that_somebody_looks_at_is_left_to_them(tmp_path: Path, monkeypatch) -> None:
    """Whoever removes what was left had it before it could be locked."""
    fcntl = pytest.importorskip("fcntl")
    flock, looks = fcntl.flock, contextlib.ExitStack()

    def look_first(descriptor: int, how: int) -> None:
        monkeypatch.setattr(fcntl, "flock", flock)
        flock(looks.enter_context(new.open("rb")), fcntl.LOCK_EX)
        flock(descriptor, how)

    new = tmp_path / "new"
    monkeypatch.setattr(fcntl, "flock", look_first)
    with looks, pytest.raises(FileExistsError, match="locked or removed"):
        create_locked(new)


@needs_signals
def test_where_no_file_can_be_locked_it_is_written_and_none_removed(tmp_path, monkeypatch) -> None:
    """As in folders of other machines: nobody knows who writes there."""
    fcntl = pytest.importorskip("fcntl")

    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", refuse)
    monkeypatch.setattr(atomic, "_TIDY", set())
    left = tmp_path / f".o.png.paint3d-{this_machine()}0000.png"
    left.write_text("another's")
    with write_atomically(tmp_path / "o.png") as part:
        part.write_text("new")
    assert sorted(tmp_path.iterdir()) == [left, tmp_path / "o.png"]


def test_a_forked_process_removes_nothing_of_its_parents(tmp_path: Path, monkeypatch) -> None:
    with write_atomically(tmp_path / "o.png") as part:
        monkeypatch.setattr(os, "getpid", lambda: 1)
        remove_unfinished()
        assert part.exists()
        monkeypatch.undo()
        remove_unfinished()
        assert not part.exists()
        part.write_text("new")
    assert [file.name for file in tmp_path.iterdir()] == ["o.png"]


@needs_signals
def test_what_a_killed_program_left_is_removed_by_the_next(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(atomic, "_TIDY", set())
    own = [tmp_path / name for name in (".o.png.12345678.png", ".paint3d-12345678", "o.png")]
    for file in own:
        file.write_text("mine")
    (tmp_path / ".folder.paint3d-12345678").mkdir()
    os.mkfifo(tmp_path / ".pipe.paint3d-12345678")
    killed, left = writing(ALONE, tmp_path)
    assert ended(killed, signal.SIGKILL) == -signal.SIGKILL
    alive, part = writing(ALONE, tmp_path)  # removes it as it begins
    assert not left.exists()
    with write_atomically(tmp_path / "other.png") as other:
        other.write_text("new")
    assert part.read_text() == "half"  # somebody is writing it
    ended(alive, signal.SIGKILL)
    with write_atomically(tmp_path / "other.png") as other:
        other.write_text("newer")
    assert part.exists()  # a folder is looked through once
    monkeypatch.setattr(atomic, "_TIDY", set())
    with write_atomically(tmp_path / "other.png") as other:
        other.write_text("newest")
    kept = {*own, tmp_path / "other.png"}
    kept |= {tmp_path / ".folder.paint3d-12345678", tmp_path / ".pipe.paint3d-12345678"}
    assert set(tmp_path.iterdir()) == kept


@needs_signals
@pytest.mark.parametrize("digits", ["123456780000", "12345678"])  # as they were before, too
def test_what_another_machine_writes_is_left_for_a_day(tmp_path, monkeypatch, digits) -> None:
    """Its lock may not be seen here: what nobody seemed to write was removed under its hands."""
    theirs = tmp_path / f".o.png.paint3d-{digits}.png"
    theirs.write_text("half")
    for hours, is_there in ((0.0, True), (23.0, True), (25.0, False)):
        written = time.time() - 3600.0 * hours
        os.utime(theirs, (written, written))
        monkeypatch.setattr(atomic, "_TIDY", set())
        with write_atomically(tmp_path / "o.png") as part:
            part.write_text("new")
        assert theirs.exists() == is_there


@needs_signals
def test_a_name_that_is_taken_or_taken_away_is_not_used(tmp_path: Path, monkeypatch) -> None:
    """By another file, or by whoever removes what nobody held yet."""
    monkeypatch.setattr(atomic, "_TIDY", {tmp_path})
    names = iter(["1111", "2222", "3333"])
    monkeypatch.setattr(atomic.secrets, "token_hex", lambda n: next(names))
    (tmp_path / f".o.png.paint3d-{this_machine()}1111.png").write_text("another's")
    lexists = os.path.lexists

    def removed(path: Path) -> bool:
        (tmp_path / f".o.png.paint3d-{this_machine()}2222.png").unlink(missing_ok=True)
        return lexists(path)

    monkeypatch.setattr(os.path, "lexists", removed)
    with write_atomically(tmp_path / "o.png") as part:
        assert part.name == f".o.png.paint3d-{this_machine()}3333.png"
        part.write_text("new")
    assert (tmp_path / "o.png").read_text() == "new"


@pytest.mark.parametrize(
    "name", ["永" * 20 + "." + "和" * 61 + ".png", "a." + "b" * 250], ids=["poem", "letters"]
)
def test_every_name_that_a_file_can_have_can_be_written(tmp_path: Path, name: str) -> None:
    """A poem's line may have a point in it; what follows it was taken for a suffix."""
    with write_atomically(tmp_path / name) as part:
        assert (part.suffix == ".png") == name.endswith(".png")
        part.write_text("new")
    assert [file.name for file in tmp_path.iterdir()] == [name]


@needs_signals
@pytest.mark.parametrize(
    ("code", "told"),
    [
        (HOST, "heard"),
        (FORKING, f"{-signal.SIGTERM} 0 True"),
        (HOLDING, "held 0\ntold 143"),
    ],
)
def test_signals_of_others_are_theirs(code: str, told: str) -> None:
    """Of the program around a command, of processes that are forked, of what is begun meanwhile."""
    asked = [sys.executable, "-W", "ignore", "-c", WRITING + code]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        asked, capture_output=True, text=True, cwd=ROOT, env=environment, timeout=PATIENCE_S
    )
    assert (done.returncode, done.stdout) == (0, f"{told}\n"), done.stderr
