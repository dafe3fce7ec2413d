"""Fuzzing guided by coverage, with atheris (libFuzzer for Python)."""

from __future__ import annotations

import random
import sys
import tempfile
from pathlib import Path

__all__ = ["run_guided"]


def run_guided(name: str, cases: int, seconds: float) -> None:
    """Fuzz one target until the cases or the seconds are used up; a bug ends the process.

    The first byte chooses the suffix, and for archives the rest seeds the damage.
    """
    import atheris

    with atheris.instrument_imports(include=["paint3d"]):
        from scripts.fuzz.campaign import try_case
        from scripts.fuzz.mutation import damage_archive
        from scripts.fuzz.targets import TARGETS

        target = TARGETS[name]
        seeds = target.seeds()
        for suffix, content in seeds:
            target.check(suffix, content)

    def test(data: bytes) -> None:
        if not data:
            return
        suffix, content = seeds[data[0] % len(seeds)]
        if content.startswith(b"PK"):
            content = damage_archive(content, random.Random(data), [data[1:]])
        else:
            content = data[1:]
        _, wrong = try_case(target, suffix, content)
        if wrong:
            raise AssertionError(wrong)

    with tempfile.TemporaryDirectory() as folder:
        for k, (_, content) in enumerate(seeds):
            (Path(folder) / str(k)).write_bytes(bytes([k]) + content)
        arguments = [sys.argv[0], f"-runs={cases}", "-timeout=20", "-rss_limit_mb=4096"]
        if seconds < float("inf"):
            arguments.append(f"-max_total_time={int(seconds)}")
        atheris.Setup([*arguments, folder], test)
        atheris.Fuzz()
