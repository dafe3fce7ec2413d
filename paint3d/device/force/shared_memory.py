"""Memory that a device's process shares with the program, with its room taken when it is made.

Where shared memory is a small disk of its own, as in most containers, a page for which there is no
room ends whoever writes there, without a word.
"""

from __future__ import annotations

from contextlib import suppress
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path

from paint3d.core.machine import reserve_space
from paint3d.errors import DeviceError

__all__ = ["make_shared_memory"]

_DISK = Path("/dev/shm")  # on Linux


def make_shared_memory(n_bytes: int) -> SharedMemory:
    """Return new memory that other processes attach by its name; whoever holds it unlinks it.

    Raises
    ------
    DeviceError
        If there is no room for it.
    """
    try:
        memory = SharedMemory(create=True, size=max(n_bytes, 1))
    except OSError as cause:
        raise _no_room(n_bytes, cause) from None
    try:
        with suppress(FileNotFoundError), open(_DISK / memory.name, "r+b") as file:
            reserve_space(file, memory.size)
    except OSError as cause:
        memory.close()
        memory.unlink()
        raise _no_room(n_bytes, cause) from None
    return memory


def _no_room(n_bytes: int, cause: OSError) -> DeviceError:
    return DeviceError(
        f"no {1e-6 * n_bytes:.3g} MB of memory to share with the stylus' process "
        f"({cause.strerror}); expected room for them in {_DISK}: a container is given more of it "
        "when it is started (--shm-size)"
    )
