"""Killed after whichever step, a sitting comes back as it was: random steps, a copy after each."""

from __future__ import annotations

import hashlib
import random
import shutil
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from paint3d.app.model.commands import encode_command
from paint3d.app.model.document import Document
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, recoverable, refusal
from paint3d.errors import ExportError, Paint3DError
from tests.support.app.hands import line

COMMANDS = (
    ("undo",), ("undo",), ("redo",), ("add_layer",), ("select_layer", 0), ("remove_layer", 1),
    ("dry",), ("dip", {"cinnabar": 0.4, "water": 0.6}), ("let_time_pass", 0.2),
)  # fmt: skip


def state(document: Document) -> tuple[object, ...]:
    """What is to come back."""
    surface = document.surface
    amounts = np.ascontiguousarray(surface.amounts).tobytes()
    kept = hashlib.sha256(amounts).hexdigest(), len(document.layers), len(document.strokes)
    return *kept, document.can_undo, document.can_redo


class Steps:
    """A document and its sitting, that are left as a kill leaves them after every step."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.chance, self.folder, self.done = random.Random(seed), folder, ["begun"]
        self.document = Document.new("plane", 3.0, "xuan")
        self.recovery = RecoveryFolder(self.document, folder / "live")
        self.clock_ns = 1 << 60

    def check(self) -> None:
        """Take up a copy of what lies on the disk."""
        left = self.folder / f"left-{len(self.done)}"
        shutil.copytree(self.folder / "live", left)
        found = recoverable(left)
        assert len(found) == 1 or (not found and not self.document.modified), self.done
        for one in found:
            recovered = one.recover()
            assert not recovered.refused, self.done
            assert state(recovered.document) == state(self.document), self.done
        shutil.rmtree(left, ignore_errors=True)

    def take(self) -> None:
        """Do one thing."""
        step: Callable[[], None] = self.chance.choice(
            [self.stroke, self.stroke, self.save, self.keep, self.keep, self.keep_on_a_full_disk,
             self.set_the_clock_back, *[self.command] * 5]
        )  # fmt: skip
        self.done.append(step.__name__)
        step()

    def ask(self, name: str, *arguments: object) -> None:
        self.done.append(name)
        self.recovery.note(encode_command(self.document, name, list(arguments), {}))
        try:
            getattr(self.document, name)(*arguments)
        except Paint3DError as error:
            self.recovery.note(refusal(error))

    def command(self) -> None:
        name, *arguments = self.chance.choice(COMMANDS)
        self.ask(name, *arguments)

    def stroke(self) -> None:
        y = self.chance.uniform(-30.0, 30.0)
        self.ask("begin_stroke")
        samples = line((-20, y), (20, y + 5), n=24, t0=self.clock_ns)
        self.clock_ns = samples[-1].time_ns + 1_000_000_000
        for part in samples[:12], samples[12:]:
            self.recovery.append(part)
            self.document.feed(part)
        self.ask("end_stroke")

    def save(self) -> None:
        self.document.save(self.folder / "own.p3d")
        self.recovery.name_file(self.document)

    def keep(self) -> None:
        self.recovery.turn_page(self.document)
        self.check()
        self.recovery.save_base(self.document)

    def keep_on_a_full_disk(self) -> None:
        def full(path: Path) -> None:
            raise ExportError(f"{path}: the disk is full")

        with pytest.MonkeyPatch.context() as patch, suppress(ExportError):
            patch.setattr(self.document, "save_copy", full)
            self.recovery.turn_page(self.document)
            self.recovery.save_base(self.document)

    def set_the_clock_back(self) -> None:
        self.clock_ns -= 3_600_000_000_000 * self.chance.randrange(1, 99)


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.long) for k in range(1, 9))]
)
def test_a_kill_after_any_step_loses_nothing(tmp_path: Path, seed: int) -> None:
    steps = Steps(tmp_path, seed)
    try:
        for _ in range(8 if seed == 0 else 20):
            steps.take()
            steps.check()
    finally:
        steps.recovery.close()
