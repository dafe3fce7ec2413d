"""Job files for farms that have an engine of their own: a job for each row of a table."""

from __future__ import annotations

import json
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from paint3d.errors import InputError

__all__ = ["KINDS", "job_file"]

KINDS = ("slurm", "openjd", "make")
_MOST_TASKS = 1024  # of a step, as Open Job Description allows


def job_file(
    kind: str, table: Path, folder: str, lines: Sequence[int], *, again: bool = False
) -> str:
    """Return a job file that paints some rows of a table.

    Every job is ``paint3d batch TABLE --row N`` of this installation.

    Parameters
    ----------
    kind : {"slurm", "openjd", "make"}
        A batch script with a job array, an Open Job Description template (2023-09, JSON), or a
        makefile.
    table : Path
    folder : str
        From which the files of the rows are counted.
    lines : sequence of int
        The rows' lines in the table; at least one.
    again : bool
        Whether rows that are finished are painted, too.

    Raises
    ------
    InputError
        If a path cannot be written into such a file.
    """
    folder, path = os.path.abspath(folder), os.path.abspath(table)
    for word in (folder, path, sys.executable):
        if not word.isprintable() or "{{" in word:
            raise InputError(f"{word!r} cannot be written into a job file; expected another folder")
    command = [sys.executable, "-m", "paint3d", "batch", path, "--folder", folder]
    command += ["--again"] * again + ["--quiet", "--row"]
    return {"slurm": _slurm, "openjd": _openjd, "make": _make}[kind](command, sorted(lines))


def _slurm(command: list[str], lines: list[int]) -> str:
    return (
        "#!/bin/sh\n"
        "#SBATCH --job-name=paint3d\n"
        f"#SBATCH --array={_ranges(lines)}\n"
        "#SBATCH --cpus-per-task=1\n"
        f'exec {shlex.join(command)} "$SLURM_ARRAY_TASK_ID"\n'
    )


def _openjd(command: list[str], lines: list[int]) -> str:
    pieces = [lines[k : k + _MOST_TASKS] for k in range(0, len(lines), _MOST_TASKS)]
    action = {"command": command[0], "args": [*command[1:], "{{Task.Param.Row}}"]}
    steps = [
        {
            "name": f"Paint lines {piece[0]} to {piece[-1]}",
            "parameterSpace": {
                "taskParameterDefinitions": [
                    {"name": "Row", "type": "INT", "range": _ranges(piece)}
                ]
            },
            "script": {"actions": {"onRun": action}},
        }
        for piece in pieces
    ]
    template = {"specificationVersion": "jobtemplate-2023-09", "name": "paint3d", "steps": steps}
    return json.dumps(template, indent=2, ensure_ascii=False) + "\n"


def _make(command: list[str], lines: list[int]) -> str:
    targets = " ".join(f"row-{line}" for line in lines)
    recipe = shlex.join(command).replace("$", "$$")
    return (
        f".PHONY: all {targets}\n"
        f"all: {targets}\n"
        f"{targets}: row-%:\n"
        f"\t{recipe} $*\n"
    )  # fmt: skip


def _ranges(lines: list[int]) -> str:
    """Rising numbers as ``2-4,7``."""
    runs: list[list[int]] = []
    for line in lines:
        if runs and line == runs[-1][1] + 1:
            runs[-1][1] = line
        else:
            runs.append([line, line])
    return ",".join(f"{a}" if a == b else f"{a}-{b}" for a, b in runs)
