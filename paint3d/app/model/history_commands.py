"""A document's way back and again: undo, redo, replays, its strokes as a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from paint3d.app.model.input.symmetry import Symmetry
from paint3d.app.model.mask import Mask, Stencil
from paint3d.app.model.score.keeping import ScoreKeeper
from paint3d.app.model.score.stepping import play
from paint3d.app.model.score.words import Inks, asked_by, brush_named
from paint3d.app.model.stroke_log import Stroke, StrokeLog, weights_of
from paint3d.brush.spec import BrushSpec, DipAmount
from paint3d.colour.pigments import Pigment
from paint3d.core.arrays import AnyArray
from paint3d.device.recorded import Recording
from paint3d.errors import InputError
from paint3d.painter.painter import Ink, Painter
from paint3d.recording.score import Score
from paint3d.recording.score_edits import edit_stroke
from paint3d.recording.score_steps import follow_steps
from paint3d.surface.ink_store import union
from paint3d.surface.layer_stack import Layer
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import Step, UndoHistory

__all__ = ["EDIT_STEP", "EditCommands", "HistoryCommands", "RecallCommands"]

# ---- Painting strokes again ----------------------------------------------------------------------
# Steps for strokes that have none, by painting them once more underneath what is there.
#
# Files from before kept strokes and no steps, and a file has no room for the steps of very many.
# The strokes are painted again on layers of their own; that these make way for the painting as it
# is belongs to the last one's step. So undo leads from the painting to what was painted again,
# stroke by stroke to the bare object, and redo back to the painting to the bit.


_Dip = tuple[Ink, float | None]
_CHUNK = 1000  # samples between two calls of `progress`


class RecallCommands:
    """Strokes of a `Document` that no step takes back.

    Attributes
    ----------
    progress : callable or None
        Called with the share that is done while strokes are painted again; what it raises stops
        that, and everything is as it was.
    """

    surface: PaintedSurface
    painter: Painter
    progress: Callable[[float], None] | None = None
    _dipped: bool
    _log: StrokeLog
    _recordings: Sequence[Recording]
    _undo: UndoHistory
    _saved_at: int | None
    _gather: Callable[[], None]
    _note: Callable[[AnyArray], None]
    _refuse_in_stroke: Callable[[str], None]

    if TYPE_CHECKING:  # what the document's other commands bring along

        @property
        def layers(self) -> tuple[Layer, ...]: ...  # noqa: D102

        @property
        def strokes(self) -> Sequence[Stroke]: ...  # noqa: D102

    @property
    def oldest_stroke(self) -> int:
        """How many strokes no step takes back; `recall_strokes` gives them steps."""
        return self._log.n_before

    @property
    def earliest_stroke(self) -> int:
        """To how few strokes the painting can be brought back, by steps or by painting again.

        What a recording painted is no stroke: strokes over it cannot be painted again by
        themselves.
        """
        return self.oldest_stroke if self._recordings else 0

    def recall_strokes(self) -> AnyArray:
        """Paint the strokes that no step takes back once more, so that all can be taken back.

        The painting stays as it is, to the bit. Layers are those of the strokes' names in the order
        in which they come; what was dried, moved, mirrored, masked, or let run meanwhile is not
        repeated.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed meanwhile.

        Raises
        ------
        InputError
            If a stroke is going on, or there is a recording under the strokes.
        """
        self._refuse_in_stroke("going back")
        count = self.oldest_stroke
        if not count:
            return np.empty(0, np.int32)
        if self.earliest_stroke:
            raise InputError(
                f"the first {count} strokes lie over a recording, which no stroke repeats; "
                f"expected a stroke from {count} on"
            )
        self._gather()
        painter = self.painter
        brush, since_dip = painter.brush, self._dipped
        amount, dips = painter.amount, _dips_of(painter)
        n_done = len(self._undo.done)
        touched = [self._undo.undo() for _ in range(n_done)]
        touched.append(self.surface.use_layers().painted_ids())
        strokes = self.strokes[:count]
        try:
            self._undo.prepend(lambda: self._make_bare(strokes[0]), lambda: self._repeat(strokes))
            self._log.hold(len(self.strokes))
            if self._saved_at == 0:  # before all steps that there were
                self._saved_at = self._undo.next_undo
        finally:
            touched += [self._undo.redo() for _ in range(n_done)]
            held = painter.brush, _said(_dips_of(painter)), painter.amount
            if held != (brush, _said(dips), amount):
                painter.change_brush(brush)
                for ink, reach in dips:  # the belly, and then the tip
                    painter.dip(ink, reach, amount if reach is None else None)
            self._dipped = since_dip
            found = union(touched, self.surface.paint_mesh.capacity)
            self.surface.touch(found)
            self._note(found)
        return found

    def _make_bare(self, first: Stroke) -> None:
        """Begin as a new painting would: a brush that was dipped for the first stroke."""
        painter, surface = self.painter, self.surface
        surface.use_layers().describe(0, name=first.layer)
        painter.change_brush(first.brush)
        painter.rinse()
        surface.ink.off_surface[:] = 0.0
        painter.loaded = 0.0
        painter.dip(self._ink_of(first), amount=first.amount)

    def _repeat(self, strokes: Sequence[Stroke]) -> None:
        """Paint strokes on the layers of their names, each a step."""
        painter = self.painter
        total, before = sum(len(stroke.samples) for stroke in strokes), 0
        for stroke in strokes:
            self._undo.begin(stroke)
            self._make_ready(stroke)
            samples = stroke.samples
            try:
                for at in range(0, len(samples), _CHUNK):
                    painter.advance(samples[at : at + _CHUNK])
                    if self.progress is not None:
                        self.progress((before + at) / total)
            except BaseException:
                painter.abandon()
                raise
            painter.finish()
            before += len(samples)

    def _make_ready(self, stroke: Stroke) -> None:
        """Take the layer, the brush and the ink of a stroke."""
        stack, painter = self.surface.use_layers(), self.painter
        names = [layer.name for layer in stack.layers]
        if stroke.layer not in names:
            self._undo.change(stack.state, lambda: stack.add(stroke.layer, len(names)))
        elif names.index(stroke.layer) != stack.active:
            self._undo.change(stack.state, lambda: stack.activate(names.index(stroke.layer)))
        if stroke.brush != painter.brush:
            painter.change_brush(stroke.brush)
            painter.dip(self._ink_of(stroke), amount=stroke.amount)
        elif stroke.dipped:
            painter.dip(self._ink_of(stroke), amount=stroke.amount)

    def _ink_of(self, stroke: Stroke) -> dict[str | Pigment, float]:
        known = {pigment.name: pigment for pigment in self.surface.pigments}
        return {known.get(name, name): part for name, part in stroke.ink.items()}


def _dips_of(painter: Painter) -> Sequence[_Dip]:
    """What the brush came to its ink by: the belly's dip, and then the tip's."""
    return painter.dips or ((painter.dipped, None),)


def _said(dips: Sequence[_Dip]) -> list[tuple[dict[str, float], float | None]]:
    """Dips by the names of their inks, to be compared."""
    return [(weights_of(ink), reach) for ink, reach in dips]


# --------------------------------------------------------------------------------------------------


EDIT_STEP = "edit"
"""Label of a step of an edit that no stroke begins: it is taken back with the step before it, and
done again with the one after it."""


class HistoryCommands(RecallCommands):
    """The history of a `Document`."""

    surface: PaintedSurface
    painter: Painter
    modified: bool
    _saved_at: int | None
    _passing: bool = False
    _looking: bool = False  # strokes were undone to look at what was before
    _dipped: bool
    _log: StrokeLog
    _undo: UndoHistory
    _note: Callable[[AnyArray], None]
    break_off: Callable[[], None]  # the document's other commands bring it along

    @property
    def steps(self) -> UndoHistory:
        """What can be undone, step by step."""
        return self._undo

    @property
    def can_undo(self) -> bool:
        """Whether there is something to undo."""
        return bool(self._undo.done) or self.earliest_stroke < self.oldest_stroke

    @property
    def can_redo(self) -> bool:
        """Whether there is something to do again."""
        return bool(self._undo.undone)

    @property
    def looks_back(self) -> bool:
        """Whether strokes were undone by `replay_history` and not done again since."""
        return self._looking

    def undo(self) -> AnyArray:
        """Take back the last step; the brush stays the one that was chosen last.

        Where a stroke is the last that was done and no step takes it back, all are painted again
        first; see `recall_strokes`.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.
        """
        self.break_off()
        return self._step_back()

    def _step_back(self) -> AnyArray:
        self._passing = self._looking = False
        if not self._undo.done and self.can_undo:
            self.recall_strokes()
        painter, steps = self.painter, self._undo
        brush, dipped, amount = painter.brush, painter.dipped, painter.amount
        touched = []
        while steps.done and steps.done[-1] == EDIT_STEP:
            touched.append(steps.undo())
        touched.append(steps.undo())
        held = painter.brush, weights_of(painter.dipped), painter.amount
        if held != (brush, weights_of(dipped), amount):
            painter.change_brush(brush)
            painter.dip(dipped, amount=amount)
            self._dipped = True
        return self._stepped(union(touched, self.surface.paint_mesh.capacity))

    def redo(self) -> AnyArray:
        """Do again what was undone last; returns as `undo`."""
        self.break_off()
        return self._step_forth()

    def _step_forth(self) -> AnyArray:
        self._passing = self._looking = False
        steps = self._undo
        touched = [steps.redo()]
        while steps.undone and steps.done[-1] == EDIT_STEP:
            touched.append(steps.redo())
        return self._stepped(union(touched, self.surface.paint_mesh.capacity))

    def _follow_log(self) -> None:
        """Have the strokes of the steps that are done."""
        self._log.follow([label for label in self._undo.done if isinstance(label, Stroke)])

    def _stepped(self, touched: AnyArray) -> AnyArray:
        self._follow_log()
        self.compare_with_saved()
        self._note(touched)
        return touched

    def compare_with_saved(self) -> None:
        """See whether the steps that are done are those with which it was saved."""
        self.modified = self._undo.next_undo != self._saved_at

    @property
    def undone_strokes(self) -> list[Stroke]:
        """Strokes that were taken back and can be done again, the next one first."""
        return [label for label in reversed(self._undo.undone) if isinstance(label, Stroke)]

    def replay_history(self, upto: int, passing: bool = False) -> AnyArray:
        """Show the painting as it was before the next stroke began, by undo and redo.

        Strokes that no step takes back are painted again where that is needed; see
        `recall_strokes`.

        Parameters
        ----------
        upto : int
            After how many strokes: from `earliest_stroke` to as many as there are with those that
            were undone.
        passing : bool
            Only to look at: what is painted next comes after all strokes, not in their stead.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.

        Raises
        ------
        InputError
            If there are not so many, or they lie over a recording.
        """
        self.break_off()
        most = len(self.strokes) + len(self.undone_strokes)
        if not self.earliest_stroke <= upto <= most:
            raise InputError(
                f"stroke {upto} of the history; expected {self.earliest_stroke} to {most}"
            )
        touched: list[AnyArray] = []
        if upto < self.oldest_stroke:
            touched.append(self.recall_strokes())
        while len(self.strokes) > upto:
            touched.append(self._step_back())
        while len(self.strokes) < upto or self._next_is_no_stroke():
            touched.append(self._step_forth())
        self._passing, self._looking = passing, upto < most
        return union(touched, self.surface.paint_mesh.capacity)

    def _come_back(self) -> None:
        """Do all again that was undone only to look at what was before."""
        if self._passing:
            self.replay_history(len(self.strokes) + len(self.undone_strokes))

    def _next_is_no_stroke(self) -> bool:
        """Whether what can be done again next is drying, or a change of the layers."""
        undone = self._undo.undone
        return bool(undone) and not isinstance(undone[-1], Stroke)

    def recording(self, first: int = 0) -> Recording | None:
        """The strokes from number `first` on as one recording in the object's frame, with dips.

        None if there are none.
        """
        return self._log.recording(self.surface.source.name, first)


# ---- Edits ---------------------------------------------------------------------------------------
# Strokes of a document edited afterwards: everything after them is painted anew.
#
# The kept state that is nearest is where the stroke began: undo leads back to it. From there the
# edited score is played. The steps that there were are kept aside, so that undo of the edit brings
# the painting back as it was, to the bit, in one step; and redo the edited one.


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
