"""The painter of Python programs: strokes, texts, drawings, photographs and seals on a surface."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from paint3d.brush.spec import BrushSpec
from paint3d.calligraphy.dips import apply_dip_option
from paint3d.calligraphy.flying_white import with_ink
from paint3d.calligraphy.layout import Layout
from paint3d.calligraphy.writing import WritingSettings, Written, write_page, write_text
from paint3d.errors import InputError, MeshError, Paint3DError
from paint3d.painter.painter import Ink
from paint3d.painter.painter import Painter as StrokePainter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Painter"]

_MOST_PLACES = 12  # where a seal is tried


class Painter(StrokePainter):
    """Paints on a surface with one brush: strokes, texts, drawings, photographs, seals.

    What paints returns a `Recording` of the hand, which can be saved and replayed. All parameters
    and the rest of what a brush can do are those of `paint3d.painter.painter.Painter`.

    Examples
    --------
    >>> import paint3d
    >>> surface = paint3d.PaintedSurface(paint3d.load_mesh("bowl"), resolution=0.8)
    >>> painter = paint3d.Painter(surface, brush="full", ink="pine soot")
    >>> stroke = painter.stroke([(0.4, 0.6), (0.6, 0.6)], pressure=(0.1, 0.6, 0.2))
    >>> written = painter.write("永", at=(0.5, 0.35), size=25)
    >>> painter.dip("cinnabar")
    >>> touched = painter.seal("和", at=(0.7, 0.4), size=12)
    >>> bool(surface.painted.any())
    True
    """

    def write(
        self,
        text: str,
        at: tuple[float, float] | None = None,
        size: float = 20.0,
        *,
        font: str | os.PathLike[str] | None = None,
        layout: str | None = None,
        side: str | None = None,
        around: bool = False,
        brush: str | BrushSpec | None = None,
        dip: str | int = "auto",
        glyphs: str | os.PathLike[str] | None = None,
        wet: bool = False,
        progress: Callable[[float], None] | None = None,
    ) -> Recording:
        """Write a text: plan the strokes of its characters, and paint them.

        Parameters
        ----------
        text : str
            A line break starts a new column or row.
        at : (float, float), optional
            Where its middle goes, U,V from 0 to 1, also of a text around; by default where it fits.
        size : float
            Side of a character's square, mm.
        font : path or str, optional
            A font file, or the name of a font of this system; by default strokes of characters
            that are known, and for letters a font of the system.
        layout : {"columns", "row"}, optional
            Columns from right to left, or rows; by default as the script is written.
        side : {"outside", "inside", "top", "bottom"}, optional
            From where the object is looked at; by default by its shape.
        around : bool
            Spread it evenly around the body; beside a handle along the free arc.
        brush : str or BrushSpec, optional
            Taken first, dipped in the same ink; by default the brush in hand.
        dip : {"auto", "always"} or int
            Before which characters the brush is dipped; see `calligraphy.dips`.
        glyphs : path, optional
            A folder of hanzi-writer-data; by default the package kanjivg.
        wet : bool
            Let ink spread and dry meanwhile.
        progress : callable, optional
            Called with the fraction painted.

        Returns
        -------
        Recording
            The way of the hand.

        Raises
        ------
        InputError
            If it has unknown characters, does not fit, or a stroke cannot be written.
        MeshError
            If the surface has no place for it.
        """
        from paint3d.calligraphy.fonts.fallback import set_whole, with_fallback
        from paint3d.calligraphy.glyph_sources import has_letters, missing_glyphs, open_glyphs

        folder = None if glyphs is None else Path(glyphs)
        plan: Callable[..., Written]
        if font is not None:
            from paint3d.calligraphy.fonts.font_file import open_font
            from paint3d.calligraphy.fonts.shaping import Style
            from paint3d.calligraphy.fonts.typesetting import set_text

            style = Style({}, None, None)
            page = set_text(text, open_font(os.fspath(font), 0, None), style, None, layout)
            plan = partial(write_page, composer=page)
        else:
            source = open_glyphs(folder)
            whole = None
            if has_letters(text) or missing_glyphs(source, text):
                whole = set_whole(source, text, layout, around=around)
                source = with_fallback(source, text) if whole is None else source
            plan = partial(write_text, text=text, source=source)
            if whole is not None:
                plan = partial(write_page, composer=whole)
        where = Layout(layout or "columns", at, around, side)
        return self._write(plan, where, size, brush, dip, wet, progress)

    def draw(
        self,
        svg: str | os.PathLike[str],
        at: tuple[float, float] | None = None,
        size: float = 40.0,
        *,
        ids: Sequence[str] = (),
        side: str | None = None,
        brush: str | BrushSpec | None = None,
        wet: bool = False,
        progress: Callable[[float], None] | None = None,
    ) -> Recording:
        """Paint a drawing, an SVG file: its lines as strokes, its areas filled.

        Parameters
        ----------
        svg : path
        at, side, brush, wet, progress
            As for `write`.
        size : float
            Its longer side, mm.
        ids : sequence of str
            Only elements and groups of these names.

        Raises
        ------
        InputError, MeshError
            If it cannot be used, or does not fit.
        """
        from paint3d.calligraphy.page.svg_drawing import load_svg

        plan = partial(write_page, composer=load_svg(Path(svg), tuple(ids)))
        return self._write(plan, Layout(at=at, side=side), size, brush, "always", wet, progress)

    def copy(
        self,
        photo: str | os.PathLike[str],
        at: tuple[float, float] | None = None,
        size: float = 40.0,
        *,
        text: str = "",
        whole: bool = False,
        invert: bool = False,
        side: str | None = None,
        brush: str | BrushSpec | None = None,
        rehearsals: int = 2,
        wet: bool = False,
        progress: Callable[[float], None] | None = None,
    ) -> Recording:
        """Copy writing from a photograph: find its strokes, and paint them as dry as they were.

        Parameters
        ----------
        photo : path
        at, side, brush, wet, progress
            As for `write`.
        size : float
            Longer side of a usual character, mm.
        text : str
            Its characters, where they are known, a line break after each column.
        whole : bool
            The picture is the sheet, as from a scanner; else it is looked for.
        invert : bool
            A rubbing: white on black.
        rehearsals : int
            How often it is painted on trial, on fresh surfaces, to correct how dry it comes out.

        Raises
        ------
        InputError, MeshError
            If no strokes are found on it, or they do not fit.
        """
        from paint3d.calligraphy.glyph_sources import open_glyphs
        from paint3d.calligraphy.photo.copying import Asked, check_widths, copy_sheet
        from paint3d.calligraphy.photo.rehearsal import rehearse
        from paint3d.files.photographs import load_photograph

        path, surface = Path(photo), self.surface
        pixels, scale = load_photograph(path)
        lines = tuple(filter(None, ("".join(line.split()) for line in text.splitlines())))
        known = open_glyphs(None) if lines else None
        templates = {} if known is None else {
            one: known.load(one) for one in dict.fromkeys("".join(lines)) if known.has(one)
        }  # fmt: skip
        asked = Asked(whole=whole, invert=invert, lines=lines, templates=templates)
        try:
            sheet = copy_sheet(pixels, path.name, asked).taken_from(path, scale, invert=invert)
        except InputError as cause:
            raise InputError("{file}: {cause}", file=path, cause=cause) from None
        self._take(brush)
        if surface.resolution is not None:
            check_widths(sheet.page, self.brush, size, surface.resolution)

        def correct(written: Written) -> Written:
            def on_trial(plan: Written) -> PaintedSurface:
                fresh = PaintedSurface(surface.source, surface.resolution, surface.material)
                trial = StrokePainter(fresh, self.brush, self.dipped)
                trial.replay(_inked(plan, fresh))
                return fresh

            return rehearse(written, on_trial, surface.material, rehearsals, sheet)

        plan = partial(write_page, composer=sheet.page)
        layout = Layout(at=at, side=side)
        return self._write(plan, layout, size, None, "always", wet, progress, correct)

    def seal(
        self,
        text: str | None = None,
        at: tuple[float, float] | None = None,
        size: float = 16.0,
        *,
        svg: str | Path | None = None,
        style: str = "zhuwen",
        shape: str = "square",
        font: str | Path | None = None,
        ink: Ink = "cinnabar",
        rotate: float = 0.0,
        side: str | None = None,
        coats: float = 1.3,
        wear: float = 1.0,
        seed: int = 1,
    ) -> float:
        """Press a seal; the brush in hand and its ink stay as they are.

        Parameters
        ----------
        text : str, optional
            1 to 4 characters, in columns from the right; with a font any text.
        at : (float, float), optional
            Where its middle goes, U,V from 0 to 1; by default the first place with room.
        size : float
            Longer side of the stone, mm.
        svg : path, optional
            A drawing that is cut instead.
        style : {"zhuwen", "baiwen"}
            Red lines in a frame, or white lines on red.
        shape : {"square", "upright", "level"}
            Of the stone: square, a column of characters, or a row of them.
        font : path or str, optional
        ink : str, Pigment or mapping
            The paste.
        rotate : float
            Degrees, anticlockwise.
        side : str, optional
            As for `write`.
        coats, wear, seed
            See `calligraphy.seal.impression.Pressing`.

        Returns
        -------
        float
            How much of the stone's ink met the surface, 0 to 1.

        Raises
        ------
        InputError, MeshError
            If it cannot be cut, or there is no place for it.
        """
        from paint3d.calligraphy.layout import frames_for
        from paint3d.calligraphy.seal.impression import Pressing, find_impression, lay_paste
        from paint3d.calligraphy.seal.stone import cut_seal
        from paint3d.mesh.chart import frame_at

        stone = cut_seal(text, svg, style, size, shape=shape, font=font)
        closest, angle = self.surface.closest_points, math.radians(rotate)
        frames = frames_for(closest, at, side)
        pressing = Pressing(coats=coats, wear=wear, seed=seed)
        fault: Paint3DError | None = None
        for _, frame in zip(range(_MOST_PLACES), frames, strict=False):
            up = math.cos(angle) * frame.y_axis - math.sin(angle) * frame.x_axis
            turned = frame_at(closest, frame.origin, up)
            try:
                left = find_impression(self.surface, closest, turned, stone.rings, pressing)
            except (InputError, MeshError) as cause:
                fault = fault or cause
                continue
            self.loaded += lay_paste(self.surface, left, self._parts_of(ink))
            return left.touched
        raise fault or MeshError(
            "{source}: there is no place for a seal",
            source=self.surface.source.name,
        )

    # -- helpers ----------------------------------------------------------------------------

    def _parts_of(self, ink: Ink) -> Any:
        """Fractions (P,) float32 of the surface's pigments in an ink, which need not be in hand."""
        parts = self._mixture(ink).astype(np.float32)
        self._fit_scratch()
        return parts

    def _take(self, brush: str | BrushSpec | None) -> None:
        if brush is not None:
            self.change_brush(brush)

    def _write(
        self,
        plan: Callable[..., Written],
        layout: Layout,
        size: float,
        brush: str | BrushSpec | None,
        dip: str | int,
        wet: bool,
        progress: Callable[[float], None] | None,
        correct: Callable[[Written], Written] | None = None,
    ) -> Recording:
        """Plan what is written for the brush in hand, and paint it."""
        self._take(brush)
        header = {"brush": self.brush.name, "ink": self.ink.name}
        written = plan(
            self.surface.source,
            settings=WritingSettings(self.brush, size),
            layout=layout,
            header=header,
        )
        dipped = apply_dip_option(written.recording, self.brush, dip, self.surface.material)
        written = replace(written, recording=dipped)
        if correct is not None:
            written = correct(written)
        recording = _inked(written, self.surface)
        self.replay(recording, progress, wet=wet)
        return recording


def _inked(written: Written, surface: PaintedSurface) -> Recording:
    """The recording of a plan, as dry and as pale as it asks for on a surface."""
    return with_ink(written.recording, written.dryness, written.strength, surface.material)
