"""Brushes of one's own, stored as files in a folder of the user's settings."""

from __future__ import annotations

from pathlib import Path

from paint3d.brush.presets import load_presets, read_brush, write_brush
from paint3d.brush.spec import BrushSpec
from paint3d.core.own_folders import config_folder
from paint3d.core.parameter_file import is_parameter_file
from paint3d.errors import BrushError, Message, Paint3DError

__all__ = ["keep_brush", "own_brush_folder", "own_brush_path", "own_brushes"]

_MOST = 200  # brushes that are listed


def own_brush_folder() -> Path:
    """The folder; it need not be there."""
    return config_folder() / "brushes"


def own_brushes(folder: Path | None = None) -> tuple[dict[str, BrushSpec], list[Message]]:
    """The user's brushes by name, in the order of their files, and what is wrong with others.

    Parameters
    ----------
    folder : Path, optional
        By default `own_brush_folder`.
    """
    folder = own_brush_folder() if folder is None else folder
    presets, brushes, problems = load_presets(), {}, []
    for path in _files(folder):
        try:
            brush = read_brush(path, presets)
            if brush.name in brushes or brush.name in presets:
                raise BrushError(
                    "{file}: another brush is called {brush!r}",
                    file=path,
                    brush=brush.name,
                )
            brushes[brush.name] = brush
        except Paint3DError as cause:
            problems.append(cause.message)
    return brushes, problems


def own_brush_path(name: str, folder: Path | None = None) -> Path:
    """The file of the brush of this name, whatever that is called; or a new one's."""
    folder = own_brush_folder() if folder is None else folder
    path = _choose_file(name, folder)
    if _name_in(path) == name:
        return path
    return next((other for other in _files(folder) if _name_in(other) == name), path)


def _files(folder: Path) -> list[Path]:
    """Files of brushes in the order in which they are listed: what is stored here, .toml, first."""
    try:
        files = sorted(path for path in folder.iterdir() if is_parameter_file(path.name))
    except OSError:
        return []
    return sorted(files, key=lambda path: path.suffix.lower() != ".toml")[:_MOST]


def _choose_file(name: str, folder: Path) -> Path:
    """The .toml called like a brush: the one that holds it, or one that is not there yet."""
    plain = "".join(c if c.isalnum() or c in "-_" else "_" for c in name).strip("_") or "brush"
    path, n = folder / f"{plain}.toml", 1
    while path.exists() and _name_in(path) != name:
        n += 1
        path = folder / f"{plain}_{n}.toml"
    return path


def _name_in(path: Path) -> str | None:
    try:
        return read_brush(path, load_presets()).name
    except Paint3DError:
        return None


def keep_brush(brush: BrushSpec, folder: Path | None = None) -> Path:
    """Write a brush into the folder, over the one of the same name; return its path.

    One of the same name in a .json stays, and is listed no more.

    Raises
    ------
    BrushError
        For a name that no brush of one's own can have.
    ExportError
        If it cannot be written.
    """
    folder = own_brush_folder() if folder is None else folder
    path = own_brush_path(brush.name, folder)
    if path.suffix.lower() != ".toml":
        path = _choose_file(brush.name, folder)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as cause:
        raise BrushError("{parent}: {cause}", parent=path.parent, cause=cause) from None
    write_brush(path, brush, load_presets())
    return path
