"""Real-time scheduling and memory locking for a process that must not be late."""

from __future__ import annotations

import ctypes
import gc
import os
import struct
import sys
from contextlib import suppress

__all__ = ["SCHEDULES", "ask_for_speed", "keep_in_memory"]

SCHEDULES = ("fifo", "slice", "plain")
"""Kinds of scheduling, the best first."""
_PRIORITY = 40
_SLICE_NS = 100_000
_SYS_SCHED_SETATTR = {"x86_64": 314, "aarch64": 274}
_MCL_CURRENT, _MCL_FUTURE = 1, 2


def ask_for_speed() -> str:
    """Request SCHED_FIFO, else a time slice of 100 us, else stay an ordinary process.

    FIFO needs a privilege (CAP_SYS_NICE, or rtprio in limits.conf). The slice needs Linux 6.12 or
    later and no privilege.

    Returns
    -------
    str
        Which of `SCHEDULES` was granted.
    """
    if hasattr(os, "sched_setscheduler"):
        with suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
            return "fifo"
        if _ask_for_short_slice():
            return "slice"
    return "plain"


def _ask_for_short_slice() -> bool:
    """Call sched_setattr(SCHED_OTHER, runtime): EEVDF schedules a shorter slice sooner."""
    number = _SYS_SCHED_SETATTR.get(os.uname().machine)
    if number is None:
        return False
    attributes = struct.pack("=IIQiIQQQ", 48, 0, 0, 0, 0, _SLICE_NS, 0, 0)
    libc = ctypes.CDLL(None, use_errno=True)
    result: bool = libc.syscall(number, 0, ctypes.c_char_p(attributes), 0) == 0
    return result


def keep_in_memory() -> bool:
    """Turn off garbage collection and, if permitted, paging; return whether paging is off."""
    gc.collect()
    gc.freeze()
    gc.disable()
    if not sys.platform.startswith("linux"):
        return False
    result: bool = ctypes.CDLL(None).mlockall(_MCL_CURRENT | _MCL_FUTURE) == 0
    return result
