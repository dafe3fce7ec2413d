"""Run the papers' timing study again: plan who paints with which devices, and print the table.

`plan` writes FOLDER/study.json and says who is to paint what, in which order, under which name.
Paint in the studio (or record with `paint3d devices record`) and save each trial in the folder.
`table` measures what is there: drawing time, likeness to the copybook, and a paired test. `answer`
writes down which devices somebody prefers, and `report` makes one page of it all, with box plots.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from paint3d.cli.options import (
    add_actions,
    add_force_option,
    add_quiet_option,
    add_seed_option,
    check_output_file,
    check_output_folder,
    check_overwriting,
    parse_length_mm,
)
from paint3d.cli.progress import ProgressBar
from paint3d.cli.report import find_versions
from paint3d.core.atomic import write_atomically
from paint3d.errors import InputError
from paint3d.files.contents import json_text

if TYPE_CHECKING:
    from paint3d.app.model.studies.plan import StudyPlan
    from paint3d.app.model.studies.study import StudyTable, Summary

__all__ = ["EXAMPLES", "add_arguments", "plan_lines", "run", "table_lines"]

EXAMPLES = """
paint3d study plan study --participants 6
paint3d study table study
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    add = add_actions(parser)
    plan = add(
        "plan",
        "set a study up in a folder, and say who paints what in which order under which name",
        "paint3d study plan study --participants 6 --devices I,II",
    )
    plan.add_argument("folder", metavar="FOLDER", type=Path)
    plan.add_argument("--participants", metavar="N", type=int, default=6, help="(default: 6)")
    plan.add_argument(
        "--devices",
        metavar="A,B",
        type=lambda text: tuple(text.split(",")),
        default=("I", "II"),
        help="names of the device sets (default: I,II: mouse and keys, haptic stylus and mouse)",
    )
    plan.add_argument("--character", metavar="字", default="目", help="what to paint (default: 目)")
    plan.add_argument("--on", metavar="MESH", default="bowl", help="on what (default: bowl)")
    plan.add_argument(
        "--size",
        metavar="MM",
        type=parse_length_mm,
        default=30.0,
        help="side of the character's square (default: 30)",
    )
    plan.add_argument("--trials", metavar="N", type=int, default=1, help="of each (default: 1)")
    add_seed_option(plan, "another deal of the orders")
    answer = add(
        "answer",
        "write down which devices a participant prefers",
        "paint3d study answer study P01 --prefers II",
    )
    answer.add_argument("folder", metavar="FOLDER", type=Path)
    answer.add_argument("participant", metavar="NAME", help="as in the plan, such as P01")
    answer.add_argument(
        "--prefers", metavar="DEVICES", required=True, help="a device set of the plan, or none"
    )
    answer.add_argument("--comment", metavar="TEXT", default="", help="what they say of it")
    table = add(
        "table",
        "measure what was painted: time, likeness to the copybook, and a paired test",
        "paint3d study table study --json study.json",
    )
    _add_measuring(table)
    table.add_argument("--json", metavar="FILE", type=Path, help="also write the results as JSON")
    page = add(
        "report",
        "measure it, and write one page with box plots",
        "paint3d study report study --out study.html",
    )
    _add_measuring(page)
    page.add_argument("--out", metavar="FILE", type=Path, required=True, help="a page, .html")


def _add_measuring(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="FOLDER", type=Path)
    parser.add_argument("--glyphs", metavar="DIR", type=Path, help="a folder of hanzi-writer-data")
    parser.add_argument(
        "--no-likeness", action="store_true", help="times only, without comparing shapes"
    )
    add_force_option(parser)
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> None:
    """Plan a study, save an answer, print its table, or write its page.

    Raises
    ------
    Paint3DError
        If the plan or the folder cannot be used.
    """
    actions = {"plan": _plan, "answer": _answer, "table": _table, "report": _report}
    actions[options.action](options)


def _plan(options: argparse.Namespace) -> None:
    from paint3d.app.model.studies.plan import make_plan, save_plan

    plan = make_plan(
        options.participants,
        options.devices,
        options.character,
        options.on,
        options.size,
        options.trials,
        0 if options.seed is None else options.seed,
    )
    check_output_folder(options.folder)
    save_plan(plan, options.folder)
    sys.stdout.write("\n".join(plan_lines(plan)) + "\n")


def _answer(options: argparse.Namespace) -> None:
    from paint3d.app.model.studies.plan import Answer, load_plan, save_answer

    plan = load_plan(options.folder)
    answer = Answer(options.prefers, options.comment)
    file = save_answer(options.folder, plan, options.participant, answer)
    sys.stdout.write(f"{file}: {options.participant} prefers {options.prefers}\n")


def _measure(options: argparse.Namespace, written: Path | None, suffix: str) -> StudyTable:
    """Measure the trials, if the file to write can be written."""
    from paint3d.app.model.studies.plan import ANSWERS_NAME, PLAN_NAME, load_plan

    plan = load_plan(options.folder)
    if written is not None:
        check_output_file(written, (suffix,))
        read = [options.folder / name for name in (PLAN_NAME, ANSWERS_NAME)]
        check_overwriting((written,), read, force=options.force)
    there = [file.name for file in options.folder.iterdir()]
    stems = [trial.stem for trial in plan.schedule()]
    if not any(name.startswith(f"{stem}.") for stem in stems for name in there):
        raise InputError(
            "{folder}: there is no trial yet; expected {first}.p3d and so on, as `paint3d study "
            "plan` has said",
            folder=options.folder,
            first=stems[0],
        )
    from paint3d.app.model.studies.study import evaluate
    from paint3d.calligraphy.glyph_sources import open_glyphs

    source = None if options.glyphs is None else open_glyphs(options.glyphs)
    with ProgressBar("measuring", enabled=not options.quiet) as bar:
        return evaluate(
            options.folder,
            plan,
            likeness=not options.no_likeness,
            source=source,
            progress=bar,
        )


def _table(options: argparse.Namespace) -> None:
    table = _measure(options, options.json, ".json")
    if options.json is not None:
        report = {"versions": find_versions(), **table.to_json()}
        text = json_text(report, indent=2, allow_nan=False)
        with write_atomically(options.json) as part:
            part.write_text(text + "\n", encoding="utf-8")
    sys.stdout.write("\n".join(table_lines(table)) + "\n")


def _report(options: argparse.Namespace) -> None:
    from paint3d.app.model.studies.report import page_of

    table = _measure(options, options.out, ".html")
    with write_atomically(options.out) as part:
        part.write_text(page_of(table), encoding="utf-8", errors="backslashreplace")
    if not options.quiet:
        sys.stdout.write(f"{options.out}: {len(table.measured)} trials\n")


def plan_lines(plan: StudyPlan) -> list[str]:
    """Return the plan for people: one participant a line, and the names of the files."""
    lines = [
        f"{plan.character} on {plan.object}, {plan.em_mm:g} mm, "
        f"{len(plan.participants)} participants, {plan.trials} of each",
        "participant  order of devices  save as",
    ]
    for participant, order in zip(plan.participants, plan.order, strict=True):
        files = [t.stem + ".p3d" for t in plan.schedule() if t.participant == participant]
        lines.append(f"{participant:<11}  {', '.join(order):<16}  {' '.join(files)}")
    lines.append("ask everybody at the end: which devices do you prefer? (paint3d study answer)")
    return lines


def table_lines(table: StudyTable) -> list[str]:
    """Return the results for people."""
    lines = ["devices  people  time s        pen down s    strokes       likeness"]
    for devices in table.plan.devices:
        seconds = table.summary(devices, lambda m: m.seconds)
        columns = [
            seconds,
            table.summary(devices, lambda m: m.pen_down_seconds),
            table.summary(devices, lambda m: float(len(m.stroke_seconds))),
            table.summary(devices, lambda m: m.likeness),
        ]
        shown = "  ".join(f"{_mean_sd(c):<12}" for c in columns)
        lines.append(f"{devices:<7}  {seconds.n:>6}  {shown}".rstrip())
    for test in table.tests():
        lines.append(
            f"{test.second} takes {_number(test.ratio, '.2f')} of the time of {test.first}: "
            f"paired t({max(test.n - 1, 0)}) = {_number(test.t, '.2f')}, "
            f"p = {_number(test.p, '.3g')}; Wilcoxon p = {_number(test.wilcoxon_p, '.3g')}"
        )
    if table.answers:
        counts = "; ".join(f"{name} {n}" for name, n in table.preferences().items())
        p = _number(table.preference_p(), ".3g")
        lines.append(f"preferred, of {len(table.answers)}: {counts}; sign test p = {p}")
    lines.append("mean (standard deviation) over participants")
    lines += [f"missing: {' '.join(table.missing)}"] if table.missing else []
    lines += [f"not usable: {file}: {why}" for file, why in table.faulty]
    return lines


def _mean_sd(summary: Summary) -> str:
    if not summary.n:
        return "-"
    return f"{_number(summary.mean, '.3g')} ({_number(summary.sd, '.2g')})"


def _number(value: float, form: str) -> str:
    return "-" if math.isnan(value) else format(value, form)
