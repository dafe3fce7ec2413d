"""Painting in a notebook's cell: `edit` shows a page, whose painting comes back to Python."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from paint3d.errors import ExportError
from paint3d.files.project.session import Session
from paint3d.page import folder
from paint3d.page.single_file import bare_score, page_score, page_text
from paint3d.surface.painted_surface import PaintedSurface

if TYPE_CHECKING:
    from paint3d.page.editor import Editor

__all__ = ["edit"]


def edit(
    painting: PaintedSurface | Session,
    *,
    brushes: Sequence[str] = folder.BRUSHES[:3],
    inks: Sequence[str] = folder.INKS,
    height: int = 640,
) -> Editor:
    """Show a painting in a notebook's cell, to be painted on; `painting` itself is not changed.

    Parameters
    ----------
    painting : PaintedSurface or Session
        A bare surface, or a session with a record of how it was painted: one that was loaded, or
        one of recordings whose ``settings`` name their ``brush`` and ``ink``.
    brushes, inks : sequence of str
        Presets and inks to paint with, besides those that it was painted with.
    height : int
        Height of the cell, pixels.

    Returns
    -------
    Editor
        A widget; its `surface`, `recording` and `score` are those of the painting so far.

    Raises
    ------
    InputError, UnknownNameError
        If a page cannot paint it, or there is no record of how it was painted.
    ExportError
        If anywidget is not installed, or the page is not built.
    """
    try:
        from paint3d.page.editor import Editor
    except ModuleNotFoundError as cause:
        if cause.name not in ("anywidget", "traitlets"):
            raise
        raise ExportError(
            "anywidget could not be loaded: {cause}; expected it installed",
            cause=cause,
            hint="pip install 'paint3d[notebook]'",
        ) from None
    folder.check_built(folder.BUILT, folder.KERNELS)
    if isinstance(painting, Session):
        surface, score = painting.surface, page_score(painting)
    else:
        surface, score = painting, bare_score(painting, brushes[0], inks[0])
    page = page_text(
        surface, score, surface.source.name, brushes=brushes, inks=inks, is_hosted=True,
        page=folder.BUILT, kernels=folder.KERNELS,
    )  # fmt: skip
    return Editor(surface, score, page, height)
