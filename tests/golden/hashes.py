"""What the cases gave when it was last meant to change: ``python -m tests.golden.hashes --record``.

Last bits depend on the machine: on the processor that kernels are compiled for, the compiler and
the mathematical library. So hashes are kept by machine, and one that is not known learns them so.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import platform
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from tests.golden.cases import CASES, outcome

__all__ = ["FILE", "hashes_of", "known", "machine"]

FILE = Path(__file__).with_name("hashes.json")


def machine() -> str:
    """What the last bits depend on, in a word."""
    from llvmlite import binding

    parts = [
        platform.machine(),
        binding.get_host_cpu_name(),
        "".join(sorted(k for k, on in binding.get_host_cpu_features().items() if on)),
        *platform.libc_ver(),
        *(version(name) for name in ("numpy", "scipy", "numba", "llvmlite")),
    ]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:12]


def hashes_of(name: str) -> dict[str, str]:
    """Paint a case: hashes of all that it gives, by name."""
    with tempfile.TemporaryDirectory() as folder:
        given = outcome(name, Path(folder))
    return {part: hashlib.sha256(data).hexdigest()[:16] for part, data in given.items()}


def known() -> dict[str, dict[str, dict[str, str]]]:
    """The hashes by machine, case and part."""
    return json.loads(FILE.read_text("utf-8")) if FILE.exists() else {}


def main() -> int:
    """Compare, and with --record keep what is given now; 1 if something differs and is not kept."""
    parser = argparse.ArgumentParser(description="Has anything that is painted changed?")
    parser.add_argument("names", nargs="*", metavar="CASE", help=f"of {', '.join(CASES)}")
    parser.add_argument("--record", action="store_true", help="the change is meant: keep it")
    options = parser.parse_args()
    kept = known()
    here = kept.setdefault(machine(), {})
    differs = False
    for name in options.names or CASES:
        now = hashes_of(name)
        changed = [part for part in now if here.get(name, {}).get(part) != now[part]]
        print(f"{name}: {len(changed)} of {len(now)} changed {' '.join(changed)}")
        differs = differs or bool(changed)
        here[name] = now
    if not options.record:
        return int(differs)
    FILE.write_text(json.dumps(kept, indent=1, sort_keys=True) + "\n", "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
