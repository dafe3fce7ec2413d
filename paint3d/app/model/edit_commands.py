"""Strokes of a document edited afterwards: everything after them is painted anew.

The kept state that is nearest is where the stroke began: undo leads back to it. From there the
edited score is played. The steps that there were are kept aside, so that undo of the edit brings
the painting back as it was, to the bit, in one step; and redo the edited one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, cast

from paint3d.app.model.history_commands import EDIT_STEP, HistoryCommands
from paint3d.app.model.input.symmetry import Symmetry
from paint3d.app.model.mask import Mask, Stencil
from paint3d.app.model.score.keeping import ScoreKeeper
from paint3d.app.model.score.stepping import play
from paint3d.app.model.score.words import Inks, asked_by, brush_named
from paint3d.app.model.stroke_log import weights_of
from paint3d.brush.spec import BrushSpec, DipAmount
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score
from paint3d.recording.score_edits import edit_stroke
from paint3d.recording.score_steps import follow_steps
from paint3d.surface.ink_store import union
from paint3d.surface.layer_stack import Layer
from paint3d.surface.undo import Step

__all__ = ["EditCommands"]

_SETTINGS = ("set_symmetry", "set_mask", "set_tags", "set_azimuth")


@dataclass(eq=False)
class _Version:
    """The painting as it is without an edit, or with it: what takes it there.

    Attributes
    ----------
    depth : int
        Steps that both have.
    aside : list of Step
        Those to do again after them, the next one last.
    count : int
        How many of them are to be done.
    since : Step
        What came since an undo, to do again after them.
    keeper : ScoreKeeper
    here : int
        Number of the last step of the version that is there now.
    there : int
        And of the other one.
    newest : int
        Number of the newest step when the versions were exchanged.
    """

    depth: int
    aside: list[Step]
    count: int
    since: Step
    keeper: ScoreKeeper
    here: int
    there: int
    newest: int


class EditCommands(HistoryCommands):
    """Edits of the strokes of a `Document`."""

    keeper: ScoreKeeper | None
    inks: list[Any]
    symmetry: Symmetry
    mask: Mask
    _stencil: Stencil | None
    cancel_stroke: Callable[[], None]
    end_stroke: Callable[[], Any]
    set_brush: Callable[[BrushSpec], None]
    dip: Callable[..., None]
    _edits: list[_Version]
    _unedits: list[_Version]
    _is_anew: bool = False  # strokes are painted anew

    def edit_stroke(self, number: int, edit: Mapping[str, Any]) -> AnyArray:
        """Edit a stroke, and paint everything after it anew: a step that can be undone.

        Strokes that were undone to look at what was before come back first.

        Parameters
        ----------
        number : int
            Place of the stroke, from 0, among `strokes` and, after them, `undone_strokes`.
        edit : mapping
            See `score_edits.edit_stroke`; the ink may be one in hand, the brush a `BrushSpec`.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.

        Raises
        ------
        InputError, RecordingError
            If there is no such stroke, it is not known from the beginning what was painted, or the
            edit cannot be done; everything is as it was then.
        """
        self.break_off()
        if self.keeper is None:
            raise InputError(
                "of this painting only the strokes are known, not what was between them; expected "
                "one whose score is kept: save the strokes as a whole painting and replay it"
            )
        if self._looking:
            self.replay_history(len(self.strokes) + len(self.undone_strokes))
        score = cast(Score, self.score)  # type: ignore[attr-defined]
        places = _places(score, len(self.strokes), len(self.undone_strokes))
        self._check_number(number, len(self.strokes))
        words = self._in_words(edit, score)
        edited = edit_stroke(score, places[number][0], words, self.surface.source)
        first = _first_difference(score, edited)
        back = max((k for k, (_, begin) in enumerate(places) if begin <= first), default=0)
        back = min(back, number)
        self._check_number(back, len(self.strokes))
        return self._paint_anew(edited, back, min(places[back][1], first))

    def _check_number(self, number: int, count: int) -> None:
        if not 0 <= number < count:
            gone = count <= number < count + len(self.undone_strokes)
            why = "is undone" if gone else "is none of them"
            raise InputError(f"stroke {number + 1} {why}; expected 1 to {count}")
        if number < self.oldest_stroke:
            raise InputError(
                f"no step leads back to stroke {number + 1}; expected one from "
                f"{self.oldest_stroke + 1} on: save the strokes as a whole painting and replay it"
            )

    def _in_words(self, edit: Mapping[str, Any], score: Score) -> Mapping[str, Any]:
        """An edit as it can be done to a score."""
        if edit.get("do") == "ink" and "ink" in edit:
            inks = Inks(dict(score.header.get("pigments", {})))
            return {**edit, "ink": inks.words(edit["ink"]), "pigments": inks.table}
        if isinstance(edit.get("brush"), BrushSpec):
            return {**edit, "brush": brush_named(edit["brush"])}
        return edit

    def _paint_anew(self, edited: Score, back: int, begin: int) -> AnyArray:
        """Go back to before a stroke, and play the edited score from its beginning on."""
        keeper, steps = self.keeper, self._undo
        assert keeper is not None, "it was looked at"
        self._gather()
        before, there, n_done = self._in_hand(), steps.next_undo, len(steps.done)
        layers = self.surface.use_layers().layers
        since, ids = steps.lay_aside_since()
        touched = [ids]
        while len(self.strokes) > back:
            touched.append(steps.undo())
            self._follow_log()
        depth = len(steps.done)
        aside = steps.exchange_undone(())
        version = _Version(depth, aside, n_done - depth, since, keeper, there, there, 0)
        try:
            with keeper.within(), self._as_it_was(edited, begin):
                self._play(edited, begin)
        except BaseException:
            with keeper.within():
                self.cancel_stroke()
            touched += self._exchange(version)
            raise
        else:
            version.here = steps.next_undo
            self._edits.append(version)
            self._unedits.clear()
            self.keeper = ScoreKeeper(edited.header, edited.events)
            self.compare_with_saved()
        finally:
            self._describe(layers)
            self._hold(before)
            found = union(touched, self.surface.paint_mesh.capacity)
            self.surface.touch(found)
            self._note(found)
        return found

    def _play(self, edited: Score, begin: int) -> None:
        """Play a score from an event on; the first step of it must be one by itself."""
        first = edited.events[begin] if begin < len(edited.events) else {"do": ""}
        if isinstance(first, Recording) or first["do"] != "begin_stroke":
            self._undo.begin(EDIT_STEP)
        for step in play(self, _without_refusals(edited, begin), begin):
            if self.progress is not None:
                self.progress(min(step.share, 0.999))
        if self._log.current is not None:
            self.end_stroke()

    @contextmanager
    def _as_it_was(self, score: Score, begin: int) -> Iterator[None]:
        """Within: symmetry, mask and the like as they were then, all layers seen and open."""
        stack, saved_at = self.surface.use_layers(), self._saved_at
        now = self.symmetry, self.mask, self._stencil, dict(self._log.tags), self.painter.azimuth
        inks = list(self.inks)
        self._is_anew = True
        self._set_up(score, begin)
        for place in range(len(stack.layers)):
            stack.describe(place, visible=True, locked=False)
        try:
            yield
        finally:
            self.symmetry, self.mask, self._stencil, self._log.tags, self.painter.azimuth = now
            self.inks, self._saved_at, self._is_anew = inks, saved_at, False

    def _describe(self, layers: Sequence[Layer]) -> None:
        """Have layers seen, locked and called as they were."""
        stack = self.surface.use_layers()
        if len(stack.layers) == len(layers):
            for place, layer in enumerate(layers):
                stack.describe(place, name=layer.name, visible=layer.visible, locked=layer.locked)

    def _set_up(self, score: Score, begin: int) -> None:
        """Have the symmetry, the mask and the like that the score had at an event."""
        inks = Inks(dict(score.header.get("pigments", {})))
        asked: dict[str, Mapping[str, Any]] = {
            "set_symmetry": {"symmetry": Symmetry()}, "set_mask": {"mask": Mask()},
            "set_tags": {}, "set_azimuth": {"azimuth": score.header.get("azimuth", "commanded")},
        }  # fmt: skip
        for event in score.events[:begin]:
            if isinstance(event, Recording) or event.get("refused"):
                continue
            if event["do"] in asked:
                asked[event["do"]] = asked_by(event, self.surface, inks)
        for name in _SETTINGS:
            getattr(self, name)(**asked[name])

    # -- undo and redo ----------------------------------------------------------------------

    def undo(self) -> AnyArray:
        """Take back the last step, or the last edit where it was the last; see `HistoryCommands`.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.
        """
        self.break_off()
        last = self._edits[-1] if self._edits and not self._is_anew else None
        if last is not None and last.here == self._undo.next_undo:
            return self._turn(self._edits, self._unedits)
        return super().undo()

    def redo(self) -> AnyArray:
        """Do again what was undone last; returns as `undo`."""
        self.break_off()
        if self._can_edit_again:
            return self._turn(self._unedits, self._edits)
        return super().redo()

    @property
    def can_redo(self) -> bool:
        """Whether there is something to do again."""
        return super().can_redo or self._can_edit_again

    @property
    def n_edits(self) -> int:
        """How many edits undo can take back."""
        return len(self._edits)

    @property
    def has_edits(self) -> bool:
        """Whether undo or redo may lead over an edit, which no file keeps."""
        return bool(self._edits or self._unedits)

    @property
    def _can_edit_again(self) -> bool:
        last = self._unedits[-1] if self._unedits and not self._is_anew else None
        if last is None:
            return False
        return last.here == self._undo.next_undo and last.newest == self._undo.newest

    def _turn(self, one: list[_Version], other: list[_Version]) -> AnyArray:
        """Exchange the painting for the other version of the last edit."""
        version = one.pop()
        before = self._in_hand()
        touched = self._exchange(version)
        version.newest = self._undo.newest
        other.append(version)
        self._hold(before)
        self._passing = self._looking = False
        found = union(touched, self.surface.paint_mesh.capacity)
        self.compare_with_saved()
        self._note(found)
        return found

    def _exchange(self, version: _Version) -> list[AnyArray]:
        """Go to where the versions part, and on in the other one."""
        steps = self._undo
        since, ids = steps.lay_aside_since()
        count = len(steps.done) - version.depth
        touched = [ids, *(steps.undo() for _ in range(count))]
        aside = steps.exchange_undone(version.aside)
        touched += [steps.redo() for _ in range(version.count)]
        touched.append(steps.resume_since(version.since))
        version.aside, version.count, version.since = aside, count, since
        version.here, version.there = version.there, version.here
        self.keeper, version.keeper = version.keeper, self.keeper
        self._follow_log()
        return touched

    def _in_hand(self) -> tuple[BrushSpec, Any, DipAmount]:
        return self.painter.brush, self.painter.dipped, self.painter.amount

    def _hold(self, in_hand: tuple[BrushSpec, Any, DipAmount]) -> None:
        """Have the brush, the ink and so much of it as were chosen last."""
        brush, dipped, amount = in_hand
        if self.painter.brush != brush:
            self.set_brush(brush)
        held = weights_of(self.painter.dipped), self.painter.amount
        if held != (weights_of(dipped), amount):
            self.dip(dipped, amount=amount.words())


def _places(score: Score, there: int, undone: int) -> list[tuple[int, int]]:
    """Of the strokes that are there and those that were undone: number in the score, and event.

    Raises
    ------
    InputError
        If they are others than the score's.
    """
    steps = follow_steps(score)
    if (len(steps.done), len(steps.undone)) != (there, undone):
        raise InputError(
            f"the score has {len(steps.done)} strokes there and {len(steps.undone)} undone; "
            f"expected {there} and {undone}, as in the painting"
        )
    return [(stroke.number, stroke.begin) for stroke in (*steps.done, *steps.undone)]


def _first_difference(one: Score, other: Score) -> int:
    """The first event in which two scores differ."""
    for k, (a, b) in enumerate(zip(one.events, other.events, strict=False)):
        if a is not b and (isinstance(a, Recording) or isinstance(b, Recording) or a != b):
            return k
    return min(len(one.events), len(other.events))


def _without_refusals(score: Score, first: int) -> Score:
    """A score without the strokes and drying that were refused, from an event on.

    They were for layers that were locked or hidden, which none is meanwhile.
    """
    events = [
        {"do": "end_stroke"} if not isinstance(event, Recording) and event.get("refused")
        and event["do"] in ("begin_stroke", "dry") and k >= first else event
        for k, event in enumerate(score.events)
    ]  # fmt: skip
    return Score(score.header, tuple(events), score.lines, score.name)
