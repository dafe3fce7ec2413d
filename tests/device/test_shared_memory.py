"""Memory shared with a stylus' process: there is room for all of it, or it is refused."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from paint3d.haptics.shared_state import make_shared_memory

SMALL = "mount -t tmpfs -o size=64k none /dev/shm"
USE = """
from paint3d.haptics.shared_state import make_shared_memory
from paint3d.errors import DeviceError
memory = make_shared_memory(60_000)
memory.buf[:] = bytes(len(memory.buf))  # ends the process where there is no room after all
try:
    make_shared_memory(8_000)
except DeviceError as fault:
    print(fault)
memory.close(), memory.unlink()
"""


def test_all_of_it_is_there() -> None:
    memory = make_shared_memory(0)
    memory.buf[0] = 7
    memory.close()
    memory.unlink()


def test_a_small_disk_for_it_ends_nobody(tmp_path: Path) -> None:
    """As in a container; what was refused leaves nothing there."""
    root = ["unshare", "--map-root-user", "--mount", "sh", "-c"]
    if shutil.which("unshare") is None or subprocess.run([*root, SMALL], check=False).returncode:
        pytest.skip("no disk may be mounted here, not even for oneself")
    (tmp_path / "use.py").write_text(USE)
    done = subprocess.run(
        [*root, f'{SMALL} && "$@" && ls /dev/shm', "sh", sys.executable, tmp_path / "use.py"],
        capture_output=True, text=True, check=False, cwd=Path(__file__).parents[2],
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [
        "no 0.008 MB of memory to share with the stylus' process (No space left on device); "
        "expected room for them in /dev/shm: a container is given more of it when it is started "
        "(--shm-size)"
    ]
