"""What holds for all tests: which examples the property tests try, and who compiles what."""

from __future__ import annotations

import faulthandler
import gc
import os
import sys
from collections.abc import Iterator

import pytest
from hypothesis import settings

from paint3d.core.machine import give_back_memory
from tests.support.compiling import compile_each_kernel_once
from tests.support.examples import ALL
from tests.support.forked_reading import reading_by_forks
from tools.texts import compile_all

# Begun in this order, all others after them: first one that compiles what is painted on and what
# paints with a solid tuft, beside it what needs no object (hairs that bend, plans of strokes) so
# that none waits for another, then what paints with hairs, what spreads, and what takes longest, so
# that no process is left with it.
_FIRST = (
    "page/test_in_browser.py",
    "page/test_same_bytes.py",
    "page/test_page_folder.py",
    "page/test_single_file.py",
    "painter/test_painter.py",
    "brush_engine/test_bristles.py",
    "calligraphy/test_planning.py",
    "painter/test_hair_painting.py",
    "surface/test_diffusion.py",
    "device/test_under_hidapi.py",
    "haptics/test_servo.py",
    "calligraphy/test_photographs.py",
    "app/test_own_objects.py",
    "app/test_pen_marks.py",
    "calligraphy/test_composition.py",
    "docs/test_front_door.py",
    "e2e/test_painting.py",
    "app/test_styli.py",
    "app/test_score.py",
    "app/test_ink_making.py",
    "app/test_window_jobs.py",
    "app/test_playback.py",
    "app/test_brush_editor.py",
    "app/test_strokes_over_picture.py",
    "app/test_screens.py",
    "e2e/test_bad_input.py",
    "e2e/test_batch.py",
    "e2e/test_writing.py",
    "bench/test_bench.py",
    "app/test_window.py",
    "app/test_steering.py",
    "view/test_view_picture.py",
    "view/test_film.py",
    "laws/test_bloom_laws.py",
    "cli/test_copy_command.py",
    "files/test_sessions.py",
    "tests/test_architecture.py",
    "files/test_export_options.py",
    "files/test_load_meshes.py",
    "app/test_one_device.py",
    "view/test_live_view.py",
    "app/test_window_files.py",
)
pytest_plugins = (
    "tests.support.plugged",
    "tests.support.less_work",
    "tests.support.fonts",
)

if "PYTEST_XDIST_WORKER" in os.environ:
    compile_each_kernel_once()

compile_all()

settings.register_profile("same", derandomize=True)
settings.register_profile("new", print_blob=True)
settings.load_profile("new" if ALL else "same")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Let a test with a limit of its own go on until then: `faulthandler_timeout` is for all."""
    if item.get_closest_marker("timeout") is not None:
        faulthandler.cancel_dump_traceback_later()


@pytest.fixture(autouse=True)
def garbage_goes() -> Iterator[None]:
    """Collect garbage where a window has been: it leaves that to its own thread's events."""
    yield
    garbage = sys.modules.get("paint3d.app.window.garbage")
    if garbage is not None:
        garbage.collect_garbage()


@pytest.fixture(autouse=True, scope="module")
def memory_goes() -> Iterator[None]:
    """Give freed memory back between files of tests: else a process grows by gigabytes."""
    yield
    give_back_memory()


@pytest.fixture(autouse=True, scope="session")
def files_are_read_by_forks() -> Iterator[None]:
    """Read small files of strangers without starting Python for each of hundreds."""
    if ALL:
        yield
        return
    with reading_by_forks():
        yield


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Look for no garbage while thousands of tests are made, nor ever again among what they are.

    There is none; searching it takes nearly half of the time that collecting takes each process.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


@pytest.hookimpl(tryfirst=True)  # before a plugin that shuffles
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the files that take long first; each file's tests stay together, in their order."""
    place = {name: k for k, name in enumerate(_FIRST)}
    items.sort(key=lambda item: place.get("/".join(item.path.parts[-2:]), len(place)))
