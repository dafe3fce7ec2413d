"""The plan of a timing study: who paints which character with which devices, in which order."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from paint3d.core.arrays import as_number
from paint3d.core.atomic import write_atomically
from paint3d.errors import InputError, UnknownNameError
from paint3d.files.contents import json_text

__all__ = [
    "ANSWERS_NAME",
    "NEITHER",
    "PLAN_NAME",
    "Answer",
    "StudyPlan",
    "Trial",
    "load_answers",
    "load_plan",
    "make_plan",
    "save_answer",
    "save_plan",
]

PLAN_NAME, ANSWERS_NAME = "study.json", "answers.json"
NEITHER = "none"
VERSION = 1
_MOST_PARTICIPANTS = 1000
_MOST_TRIALS = 100


@dataclass(frozen=True)
class Trial:
    """A character to paint.

    Attributes
    ----------
    participant : str
    devices : str
        Name of the device set.
    number : int
        From 1, of this participant with these devices.
    """

    participant: str
    devices: str
    number: int

    @property
    def stem(self) -> str:
        """Name of its file, without suffix."""
        return f"{self.participant}-{self.devices}-{self.number}"


@dataclass(frozen=True)
class StudyPlan:
    """A study.

    Attributes
    ----------
    character : str
    object : str
        A built-in object, or a mesh file.
    em_mm : float
        Side of the square that the character is painted in, mm.
    devices : tuple of str
        Names of the device sets.
    participants : tuple of str
    trials : int
        Of each participant with each device set.
    order : tuple of tuple of str
        For each participant the device sets in the order of use.
    """

    character: str
    object: str
    em_mm: float
    devices: tuple[str, ...]
    participants: tuple[str, ...]
    trials: int
    order: tuple[tuple[str, ...], ...]

    def __post_init__(self) -> None:
        if len(self.character) != 1 or self.character.isspace():
            raise InputError(
                "character is {character!r:.20}; expected a single one",
                character=self.character,
            )
        as_number(self.em_mm, "size (mm)", 2.0, 1000.0)
        as_number(self.trials, "trials", 1, _MOST_TRIALS)
        for kind, names, least in (
            ("device set", self.devices, 2),
            ("participant", self.participants, 1),
        ):
            _check_names(kind, names, least)
        if len(self.order) != len(self.participants) or any(
            sorted(row) != sorted(self.devices) for row in self.order
        ):
            raise InputError("the order does not give every participant every device set once")

    def schedule(self) -> list[Trial]:
        """All trials, participant by participant, in the order of use."""
        return [
            Trial(participant, devices, number)
            for participant, row in zip(self.participants, self.order, strict=True)
            for devices in row
            for number in range(1, self.trials + 1)
        ]


def _check_names(kind: str, names: Sequence[str], least: int) -> None:
    if not least <= len(names) <= _MOST_PARTICIPANTS or len(set(names)) < len(names):
        raise InputError(
            "{n} {kind}s: {names:.80}; expected {least} or more",
            n=len(names),
            kind=kind,
            names=", ".join(names),
            least=least,
        )
    for name in names:
        if not name or not all(c.isalnum() or c in "_." for c in name) or name.startswith("."):
            raise InputError(
                "{kind} {name!r:.40}; expected letters, digits, _ and .",
                kind=kind,
                name=name,
            )


def make_plan(
    participants: int = 6,
    devices: Sequence[str] = ("I", "II"),
    character: str = "目",
    on: str = "bowl",
    em_mm: float = 30.0,
    trials: int = 1,
    seed: int = 0,
) -> StudyPlan:
    """Plan a study; the defaults are Guo 2017's (six volunteers, two device sets, one character).

    Every device set comes first, second ... as often as every other, as nearly as the number of
    participants allows: their orders are rows of a Williams square, dealt out at random.

    Raises
    ------
    InputError
        If a number is out of its range, or names are repeated.
    """
    count = int(as_number(participants, "participants", 1, _MOST_PARTICIPANTS))
    devices = tuple(devices)
    _check_names("device set", devices, 2)
    rows = _williams(len(devices))
    dealt = [rows[k % len(rows)] for k in range(count)]
    shuffled = np.random.default_rng(seed).permutation(count)
    order = tuple(tuple(devices[i] for i in dealt[k]) for k in shuffled)
    names = tuple(f"P{k + 1:02d}" for k in range(count))
    return StudyPlan(character, on, float(em_mm), devices, names, int(trials), order)


def _williams(n: int) -> list[list[int]]:
    """Orders of n things in which each stands at each position and after each other equally often.

    Williams, Australian Journal of Scientific Research A 2 (1949) 149.
    """
    first = [0]
    low, high = 1, n - 1
    while len(first) < n:
        first.append(low if len(first) % 2 else high)
        low, high = (low + 1, high) if len(first) % 2 == 0 else (low, high - 1)
    rows = [[(k + shift) % n for k in first] for shift in range(n)]
    return rows if n % 2 == 0 else rows + [row[::-1] for row in rows]


def save_plan(plan: StudyPlan, folder: Path) -> Path:
    """Write a plan into a folder, which is made; an existing plan is not written over.

    Raises
    ------
    InputError
        If there is a plan already.
    ExportError
        If it cannot be written.
    """
    file = folder / PLAN_NAME
    if file.exists():
        raise InputError(
            "{file}: there is a study in this folder; expected another folder",
            file=file,
        )
    folder.mkdir(parents=True, exist_ok=True)
    values = {"format": "paint3d-study", "version": VERSION, **asdict(plan)}
    with write_atomically(file) as part:
        part.write_text(json_text(values, indent=1) + "\n", encoding="utf-8")
    return file


def load_plan(folder: Path) -> StudyPlan:
    """Read the plan of a folder.

    Raises
    ------
    InputError
        If there is none, or it cannot be used.
    """
    file = folder / PLAN_NAME
    try:
        values = json.loads(file.read_text("utf-8"))
        if values.pop("format") != "paint3d-study" or values.pop("version") != VERSION:
            raise InputError("it is no study of version {expected}", expected=VERSION)
        for name in ("devices", "participants"):
            values[name] = tuple(values[name])
        values["order"] = tuple(tuple(row) for row in values["order"])
        return StudyPlan(**values)
    except OSError as cause:
        reason = cause.strerror or cause
        raise InputError(
            "{file}: {reason}; expected the plan of a study", file=file, reason=reason
        ) from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as cause:
        raise InputError("{file}: it cannot be used: {cause}", file=file, cause=cause) from None


@dataclass(frozen=True)
class Answer:
    """Preference of a participant: a device set, or `NEITHER`; and a comment."""

    prefers: str
    comment: str = ""


def save_answer(folder: Path, plan: StudyPlan, participant: str, answer: Answer) -> Path:
    """Write down what a participant prefers; an answer given again replaces the first.

    Raises
    ------
    InputError
        If there is no such participant or device set, or the answers there cannot be read.
    ExportError
        If it cannot be written.
    """
    _check_answer(plan, participant, answer)
    file = folder / ANSWERS_NAME
    answers = load_answers(folder, plan) | {participant: answer}
    given = {name: asdict(answers[name]) for name in plan.participants if name in answers}
    values = {"format": "paint3d-study-answers", "version": VERSION, "answers": given}
    with write_atomically(file) as part:
        part.write_text(json_text(values, indent=1) + "\n", encoding="utf-8")
    return file


def load_answers(folder: Path, plan: StudyPlan) -> dict[str, Answer]:
    """Read the participants' answers by name; only of those who were asked.

    Raises
    ------
    InputError
        If the file cannot be used.
    """
    file = folder / ANSWERS_NAME
    if not file.is_file():
        return {}
    try:
        values = json.loads(file.read_text("utf-8"))
        if values["format"] != "paint3d-study-answers" or values["version"] != VERSION:
            raise InputError("it holds no answers of version {expected}", expected=VERSION)
        answers = {str(name): Answer(**own) for name, own in values["answers"].items()}
        for name, answer in answers.items():
            _check_answer(plan, name, answer)
        return answers
    except OSError as cause:
        raise InputError("{file}: {cause}", file=file, cause=cause) from None
    except (InputError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as cause:
        raise InputError("{file}: it cannot be used: {cause}", file=file, cause=cause) from None


def _check_answer(plan: StudyPlan, participant: str, answer: Answer) -> None:
    if participant not in plan.participants:
        raise UnknownNameError("participant", participant, plan.participants)
    if answer.prefers not in (*plan.devices, NEITHER):
        raise UnknownNameError("device set", answer.prefers, (*plan.devices, NEITHER))
    if not isinstance(answer.comment, str):
        raise InputError("comment is {comment!r:.40}; expected words", comment=answer.comment)
