"""Processes of one run compile each kernel once: who needs one that another compiles waits for it.

numba does not look whether another process is at work on the same kernel, so that two that begin
with nothing compiled would both spend two minutes on the same code.
"""

from __future__ import annotations

import contextlib
import fcntl
import gc
import os
import time
import zlib
from collections.abc import Iterator
from pathlib import Path

from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import Dispatcher

from paint3d.core import compile_cache

__all__ = ["compile_each_kernel_once"]

_LOOK_S = 0.02  # between two looks at whether another process is done


def compile_each_kernel_once() -> None:
    """Make this process wait where another compiles the kernel that it needs.

    A kernel is locked by a byte of one file. What a kernel calls is compiled, and locked, within
    it; no kernel calls one that calls it, so nobody waits in a circle. Only the thread that needs
    the kernel waits: others of its process go on loading and compiling what they need.
    """
    folder = compile_cache.compiled_folder(Path(compile_cache.__file__).parent)
    folder.mkdir(parents=True, exist_ok=True)
    file = os.open(folder / "compiling.lock", os.O_RDWR | os.O_CREAT, 0o600)
    whole = Dispatcher.compile

    def compile_alone(kernel: Dispatcher, signature: object) -> object:
        name = f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__}"
        if not name.startswith("paint3d."):
            return whole(kernel, signature)
        byte = zlib.crc32(name.encode())
        while True:
            with global_compiler_lock, _locked(file, byte) as is_ours:
                if is_ours:
                    with _keeping_all():
                        return whole(kernel, signature)
            time.sleep(_LOOK_S)

    Dispatcher.compile = compile_alone


@contextlib.contextmanager
def _keeping_all() -> Iterator[None]:
    """Look for no rubbish meanwhile: it costs an eighth of compiling, which makes little."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


@contextlib.contextmanager
def _locked(file: int, byte: int) -> Iterator[bool]:
    """Try to lock this byte within the block; yield whether no other process has it."""
    try:
        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, byte)
    except OSError:
        yield False
        return
    try:
        yield True
    finally:
        fcntl.lockf(file, fcntl.LOCK_UN, 1, byte)
