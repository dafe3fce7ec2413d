"""Confinement of a process, for good, before it reads an untrusted file.

On Linux it gains no more privileges, and then can neither write files, start programs nor reach
others, by two independent means: Landlock, rules of the kernel on files, TCP ports and signals, and
a seccomp filter, by which system calls fail. Neither needs privileges. Where one is missing or
switched off, the other, the process's limits and its parent remain.
"""

from __future__ import annotations

import errno
import os
import struct
import sys
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

__all__ = ["LANDLOCK", "PRIVILEGES", "SECCOMP", "Refused", "confine_process", "filter_calls"]

PRIVILEGES, LANDLOCK, SECCOMP = "privileges", "landlock", "seccomp"

_PR_SET_NO_NEW_PRIVS = 38


def confine_process() -> tuple[str, ...]:
    """Forbid this process and its children to write files, use networks or start programs.

    It may read what its user may, write to files that are open, and have threads. Other calls end
    in EPERM. This cannot be undone.

    Returns
    -------
    tuple of str
        Those of `PRIVILEGES`, `LANDLOCK` and `SECCOMP` that are in effect.
    """
    if not sys.platform.startswith("linux"):
        return ()
    import ctypes

    libc = ctypes.CDLL(None, use_errno=True)
    if not hasattr(libc, "prctl") or libc.prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0:
        return ()
    holds = [PRIVILEGES]
    if _give_up_files(libc):
        holds.append(LANDLOCK)
    if filter_calls(_refused_here()):
        holds.append(SECCOMP)
    return tuple(holds)


# ---- Landlock ------------------------------------------------------------------------------------
# See linux/landlock.h; each version of the interface adds rights.

_CREATE_RULESET, _RESTRICT_SELF = 444, 446  # of every processor
_ASK_VERSION = 1
_READING = 1 << 2 | 1 << 3  # files, folders
_FILE_RIGHTS = {1: 13, 2: 14, 3: 15, 5: 16}  # bits that a version knows: from running to devices
_TCP_VERSION, _TCP_RIGHTS = 4, 0b11  # to listen and to connect
_SCOPE_VERSION, _SCOPES = 6, 0b11  # abstract sockets and signals of others


def _give_up_files(libc: Any) -> bool:
    """Forbid by Landlock all that this version of it can; return whether it does."""
    import ctypes

    call = libc.syscall
    version = call(_CREATE_RULESET, None, ctypes.c_size_t(0), _ASK_VERSION)
    if version < 1:
        return False
    bits = max(known for since, known in _FILE_RIGHTS.items() if since <= version)
    rights = [((1 << bits) - 1) & ~_READING]
    if version >= _TCP_VERSION:
        rights.append(_TCP_RIGHTS)
    if version >= _SCOPE_VERSION:
        rights.append(_SCOPES)
    asked = struct.pack(f"={len(rights)}Q", *rights)
    rules = call(_CREATE_RULESET, asked, ctypes.c_size_t(len(asked)), 0)
    if rules < 0:
        return False
    try:
        return bool(call(_RESTRICT_SELF, rules, 0) == 0)  # no rule allows anything
    finally:
        os.close(rules)


# ---- seccomp -------------------------------------------------------------------------------------
# A filter is a program of classic BPF over (number, processor, address, six arguments); see
# linux/seccomp.h, linux/audit.h and asm/unistd.h.


class _Processor(NamedTuple):
    """A processor: its column of `_CALLS`, its AUDIT_ARCH, and its number of seccomp(2)."""

    column: int
    arch: int
    seccomp: int


_PROCESSORS = {"x86_64": _Processor(0, 0xC000003E, 317), "aarch64": _Processor(1, 0xC00000B7, 277)}
_ABSENT = -1  # on that processor
_CALLS = {  # their numbers on x86-64 and on 64-bit Arm
    # to reach others
    "socket": (41, 198), "socketpair": (53, 199), "connect": (42, 203), "bind": (49, 200),
    "listen": (50, 201), "sendto": (44, 206), "sendmsg": (46, 211), "sendmmsg": (307, 269),
    "ptrace": (101, 117), "process_vm_readv": (310, 270), "process_vm_writev": (311, 271),
    "pidfd_getfd": (438, 438), "kill": (62, 129), "pidfd_send_signal": (424, 424),
    # to start programs
    "execve": (59, 221), "execveat": (322, 281), "fork": (57, _ABSENT), "vfork": (58, _ABSENT),
    # to change files
    "creat": (85, _ABSENT), "truncate": (76, 45), "mkdir": (83, _ABSENT), "mkdirat": (258, 34),
    "mknod": (133, _ABSENT), "mknodat": (259, 33), "rmdir": (84, _ABSENT), "unlink": (87, _ABSENT),
    "unlinkat": (263, 35), "rename": (82, _ABSENT), "renameat": (264, 38), "renameat2": (316, 276),
    "link": (86, _ABSENT), "linkat": (265, 37), "symlink": (88, _ABSENT), "symlinkat": (266, 36),
    "chmod": (90, _ABSENT), "fchmod": (91, 52), "fchmodat": (268, 53), "fchmodat2": (452, 452),
    "chown": (92, _ABSENT), "lchown": (94, _ABSENT), "fchown": (93, 55), "fchownat": (260, 54),
    "setxattr": (188, 5), "lsetxattr": (189, 6), "fsetxattr": (190, 7),
    "removexattr": (197, 14), "lremovexattr": (198, 15), "fremovexattr": (199, 16),
    "utime": (132, _ABSENT), "utimes": (235, _ABSENT), "utimensat": (280, 88),
    # to change the system, or go round the filter
    "mount": (165, 40), "umount2": (166, 39), "unshare": (272, 97), "setns": (308, 268),
    "chroot": (161, 51), "pivot_root": (155, 41), "bpf": (321, 280), "add_key": (248, 217),
    "request_key": (249, 218), "keyctl": (250, 219), "perf_event_open": (298, 241),
    "userfaultfd": (323, 282), "io_uring_setup": (425, 425), "open_by_handle_at": (304, 265),
    "setpriority": (141, 140), "sched_setscheduler": (144, 119), "sched_setattr": (314, 274),
}  # fmt: skip
# A filter cannot see the arguments of these; C libraries fall back to others.
_HIDDEN = {"openat2": 437, "clone3": 435}
_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
# instructions of BPF: ld, jeq, jge, jset, ret
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
_CLONE_THREAD = 0x10000
_TIOCSTI, _TIOCLINUX = 0x5412, 0x541C
_ASKING = (  # calls that fail by an argument: its index, comparison, operand, and for which result
    ((2, _ABSENT), 1, _ANY_BIT, _WRITING, True),  # open
    ((257, 56), 2, _ANY_BIT, _WRITING, True),  # openat
    ((56, 220), 0, _ANY_BIT, _CLONE_THREAD, False),  # clone: a thread is all that may be
    ((302, 261), 0, _ANY_BIT, 0xFFFFFFFF, True),  # prlimit64 of another process
    ((16, 29), 1, _EQUAL, _TIOCSTI, True),  # ioctl: to type into a terminal
    ((16, 29), 1, _EQUAL, _TIOCLINUX, True),
)
_X32_BIT = 0x40000000  # of the numbers of x86-64's other set of calls
_SET_FILTER, _ALL_THREADS = 1, 1  # SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC
_ALLOW, _FAIL = 0x7FFF0000, 0x00050000  # SECCOMP_RET_ALLOW, SECCOMP_RET_ERRNO with its number
_NR_AT, _ARCH_AT, _ARGS_AT = 0, 4, 16  # bytes, in struct seccomp_data


def _processor() -> _Processor | None:
    """Return the processor of this process; None if its system calls are not listed."""
    import platform

    return _PROCESSORS.get(platform.machine()) if sys.maxsize > 1 << 32 else None


class Refused(NamedTuple):
    """Numbers of system calls that fail: always, as if missing (ENOSYS), or by an argument."""

    always: Sequence[int]
    missing: Sequence[int] = ()
    asking: Sequence[tuple[int, int, int, int, bool]] = ()  # as in `_ASKING`


def _refused_here() -> Refused:
    processor = _processor()
    if processor is None:
        return Refused(())
    k = processor.column
    always = [numbers[k] for numbers in _CALLS.values() if numbers[k] >= 0]
    asking = [
        (numbers[k], place, look, value, if_so)
        for numbers, place, look, value, if_so in _ASKING
        if numbers[k] >= 0
    ]
    return Refused(always, tuple(_HIDDEN.values()), asking)


def filter_calls(refused: Refused) -> bool:
    """Install a seccomp filter by which system calls fail; return whether it is in effect."""
    import ctypes

    processor = _processor()
    if processor is None:
        return False
    program = b"".join(struct.pack("=HBBI", *line) for line in _program(processor, refused))
    instructions = ctypes.create_string_buffer(program, len(program))
    struct_fprog = struct.pack("@HP", len(program) // 8, ctypes.addressof(instructions))
    call = ctypes.CDLL(None, use_errno=True).syscall
    return bool(call(processor.seccomp, _SET_FILTER, _ALL_THREADS, struct_fprog) == 0)


def _program(processor: _Processor, refused: Refused) -> Iterator[tuple[int, int, int, int]]:
    """Yield instructions of BPF: code, jumps if true and if false, and operand."""
    refuse = (_RETURN, 0, 0, _FAIL | errno.EPERM)
    yield _LOAD, 0, 0, _ARCH_AT
    yield _EQUAL, 1, 0, processor.arch
    yield refuse
    yield _LOAD, 0, 0, _NR_AT
    yield _AT_LEAST, 0, 1, _X32_BIT
    yield refuse
    for number in refused.always:
        yield _EQUAL, 0, 1, number
        yield refuse
    for number in refused.missing:
        yield _EQUAL, 0, 1, number
        yield _RETURN, 0, 0, _FAIL | errno.ENOSYS
    for number, place, look, value, if_so in refused.asking:
        yield _LOAD, 0, 0, _NR_AT
        yield _EQUAL, 0, 3, number
        yield _LOAD, 0, 0, _ARGS_AT + 8 * place  # the lower half, which comes first
        yield (look, 0, 1, value) if if_so else (look, 1, 0, value)
        yield refuse
    yield _RETURN, 0, 0, _ALLOW
