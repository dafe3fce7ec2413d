"""What a user has chosen, stored as JSON in the user's config folder."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from paint3d.app.model.input.pressure_curve import PressureCurve
from paint3d.colour.materials import Material, load_materials
from paint3d.core.arrays import as_number
from paint3d.core.atomic import write_atomically
from paint3d.core.own_folders import (
    config_folder,
    make_private,
    make_private_folder,
    usual_config_folder,
)
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.errors import DeviceError, ExportError, InputError, Message, Paint3DError
from paint3d.files.contents import json_text
from paint3d.haptics.settings import Feel
from paint3d.haptics.stylus_choice import check_stylus
from paint3d.pose.calibration import DeviceCalibration, load_calibration, save_calibration
from paint3d.pose.mouse_settings import DEFAULT_ACTIONS, MouseSettings, checked_actions

__all__ = [
    "Settings",
    "load_settings",
    "save_settings",
    "store_calibration",
    "stored_calibration",
]

VERSION = 2
MOUSE_STEADY = 0.3
"""Steadiness of a mouse's strokes, 0 to 1, unless it was chosen otherwise."""
WET_AT_FIRST = frozenset({"xuan", "tinted xuan"})
"""Materials on which ink spreads unless it was chosen otherwise."""
_DRINKS = 0.9  # absorbency from which it spreads on a material of one's own, too

_MOST_RECENT = 12
_CHOICES = {
    "language": ("system", "en", "zh"),
    "theme": ("system", "light", "dark"),
    "unit": ("mm", "cm", "m", "in"),
    "pressure_by": ("keys", "speed"),
    "finger": ("auto", "paint", "turn"),
}
_RANGES = {
    "smoothing": (0.0, 1.0),
    "mouse_smoothing": (0.0, 1.0),
    "resolution_mm": (0.005, 100.0),
    "autosave_s": (10.0, 3600.0),
    "undo_megabytes": (1.0, 1e6),
    "force_n": (0.0, MAX_FORCE_N),
    "brush_mm": (1.0, 1000.0),
}
_MAYBE = ("brush_mm", "mouse_smoothing")  # may also be None


@dataclass(frozen=True)
class Settings:
    """A user's choices.

    Attributes
    ----------
    language : {"system", "en", "zh"}
    theme : {"system", "light", "dark"}
    unit : {"mm", "cm", "m", "in"}
        Of lengths as they are shown.
    material, resolution_mm
        Of new paintings.
    begun_on : str
        The object or sheet that was chosen for one last; empty for a file.
    glyphs : str
        A folder of hanzi-writer-data whose characters are written; empty for those of kanjivg.
    brush : str
        In the hand when a new painting begins.
    brush_mm : float or None
        Its tuft's length; None: as it is made.
    favourite_brushes : tuple of str
        Listed first.
    brush_folders : dict of str to str
        Folders of the list by the brushes that are in them.
    inks : tuple of str, or of mappings of str to float
        At hand then, the one it is dipped in first; mixtures as parts by name.
    mixtures : tuple of mappings of str to float
        That the brush was dipped in last, the newest first.
    pressure_curve : tuple of (float, float)
        See `PressureCurve`.
    pressure_by : {"keys", "speed"}
    finger : {"auto", "paint", "turn"}
        What one finger on the picture does; "auto": it paints until a pen is used, then it turns.
    force_n : float
        Of a mouse, at first.
    smoothing : float
        0 to 1.
    mouse_smoothing : float or None
        At least so much for a mouse; None: `MOUSE_STEADY`.
    wet : bool or None
        Whether ink spreads and dries while painting; None: as the material asks for.
    dips_by_itself : bool
        Whether the brush is dipped before a stroke where less than a fifth of a dip is left.
    autosave_s : float
        The least time between two bases of a recovery folder.
    undo_megabytes : float
        Of undo steps in memory; more go to the disk.
    recent : tuple of str
        Files, the last opened first.
    buttons : dict of int to str
        Actions of a 6-DOF mouse's buttons.
    mouse : dict
        How a 6-DOF mouse is read: see `MouseSettings`.
    stylus : str
        Which stylus pushes back: see `find_stylus`.
    pigment_tables : dict of str to str
        Tables of pigments of one's own that are at hand: see `own_pigments`.
    feel : dict of str to float
        What of a haptic stylus is the user's choice: see `Feel`.
    window : dict
        What the window keeps for itself: size, position, panels.
    exports : dict
        What was chosen last for exports and films.
    signer : str
        Whose name the last signature said.

    Raises
    ------
    InputError
        Naming the setting, what was got and what was expected.
    """

    language: str = "system"
    theme: str = "system"
    unit: str = "mm"
    material: str = "porcelain"
    begun_on: str = "bowl"
    glyphs: str = ""
    brush: str = "full"
    brush_mm: float | None = None
    favourite_brushes: tuple[str, ...] = ()
    brush_folders: Mapping[str, str] = field(default_factory=dict)
    inks: tuple[str | Mapping[str, float], ...] = (
        {
            "pine soot": 0.26,
            "water": 0.74,
        },  # as a writer grinds it; files: `PURE_INKS`
        "cinnabar",
    )
    mixtures: tuple[Mapping[str, float], ...] = ()
    resolution_mm: float = 0.4
    pressure_curve: tuple[tuple[float, float], ...] = ((0.0, 0.0), (1.0, 1.0))
    pressure_by: str = "keys"
    finger: str = "auto"
    force_n: float = 1.5
    smoothing: float = 0.0
    mouse_smoothing: float | None = None
    wet: bool | None = None
    dips_by_itself: bool = False
    autosave_s: float = 120.0
    undo_megabytes: float = 512.0
    recent: tuple[str, ...] = ()
    buttons: Mapping[int, str] = field(default_factory=lambda: dict(DEFAULT_ACTIONS))
    mouse: Mapping[str, object] = field(default_factory=dict)
    stylus: str = "auto"
    feel: Mapping[str, float] = field(default_factory=dict)
    pigment_tables: Mapping[str, str] = field(default_factory=dict)
    window: Mapping[str, object] = field(default_factory=dict)
    exports: Mapping[str, object] = field(default_factory=dict)
    signer: str = ""

    def __post_init__(self) -> None:
        for name, known in _CHOICES.items():
            if getattr(self, name) not in known:
                raise InputError(
                    "{name} is {value!r}; expected {known}",
                    name=name,
                    value=getattr(self, name),
                    known=" or ".join(known),
                )
        for name, (low, high) in _RANGES.items():
            if getattr(self, name) is not None or name not in _MAYBE:
                as_number(getattr(self, name), name, low, high)
        if self.wet is not None and not isinstance(self.wet, bool):
            raise InputError("wet is {wet!r}; expected true or false", wet=self.wet)
        if not isinstance(self.dips_by_itself, bool):
            raise InputError(
                "dips_by_itself is {dips_by_itself!r}; expected true or false",
                dips_by_itself=self.dips_by_itself,
            )
        _check_words("recent", self.recent)
        _check_words("favourite_brushes", self.favourite_brushes)
        for name in ("begun_on", "glyphs", "signer"):
            if not isinstance(getattr(self, name), str):
                raise InputError(
                    "{name} is {value}; expected a name",
                    name=name,
                    value=f"{getattr(self, name)!r:.40}",
                )
        _check_inks("inks", self.inks)
        _check_inks("mixtures", self.mixtures)
        _check_words("brush", (self.brush,))
        _check_words("material", (self.material,))
        for name in ("mouse", "feel", "window", "exports", "pigment_tables", "brush_folders"):
            if not isinstance(getattr(self, name), Mapping):
                raise InputError(
                    "{name} is {value!r:.40}; expected names, values",
                    name=name,
                    value=getattr(self, name),
                )
        for name in ("pigment_tables", "brush_folders"):
            words: Mapping[str, str] = getattr(self, name)
            _check_words(name, (*words, *words.values()))
        PressureCurve(self.pressure_curve)
        object.__setattr__(self, "buttons", checked_actions(self.buttons))
        MouseSettings.from_dict(self.mouse)
        Feel.from_dict(self.feel)
        check_stylus(self.stylus)

    @property
    def curve(self) -> PressureCurve:
        """The pressure curve, ready for use."""
        return PressureCurve(self.pressure_curve)

    @property
    def mouse_steadiness(self) -> float:
        """Steadiness of a mouse's strokes, 0 to 1."""
        return MOUSE_STEADY if self.mouse_smoothing is None else self.mouse_smoothing

    def wants_wet(self, material: Material) -> bool:
        """Return whether ink spreads on a material: as chosen, else as the material asks for."""
        if self.wet is not None:
            return self.wet
        if material.name in load_materials():
            return material.name in WET_AT_FIRST
        return material.pores_mm > 0.0 and material.absorbency >= _DRINKS

    def with_recent(self, path: str | os.PathLike[str]) -> Settings:
        """Settings with a file at the head of the recent ones."""
        own = os.path.abspath(path)
        others = tuple(other for other in self.recent if other != own)
        return dataclasses.replace(self, recent=(own, *others)[:_MOST_RECENT])


def _check_words(name: str, words: object) -> None:
    if not isinstance(words, tuple) or not all(isinstance(word, str) and word for word in words):
        raise InputError("{name} is {words!r:.60}; expected names", name=name, words=words)


def _check_inks(name: str, inks: object) -> None:
    if not isinstance(inks, tuple):
        raise InputError("{name} is {inks!r:.60}; expected names or mixtures", name=name, inks=inks)
    for ink in inks:
        if not isinstance(ink, Mapping):
            _check_words(name, (ink,))
            continue
        _check_words(name, tuple(ink))
        for pigment, part in ink.items():
            as_number(part, f"part of {pigment}", 0.0, 1e9)


def _file(folder: Path | None) -> Path:
    return (config_folder() if folder is None else folder) / "settings.json"


def load_settings(folder: Path | None = None) -> tuple[Settings, Message | None]:
    """Read the saved settings; the defaults where there are none that can be used.

    A file that cannot be used is set aside, never written over.

    Parameters
    ----------
    folder : Path, optional
        By default `config_folder`.

    Returns
    -------
    Settings
    Message or None
        What was wrong with the file and where it lies now, for the user; None if nothing was.
    """
    file = _file(folder)
    if folder is None and not file.is_file():
        usual = usual_config_folder()  # of a home that can be read, but not written
        if usual is not None and os.access(_file(usual), os.R_OK):
            file = _file(usual)
    try:
        return _parse_settings(file.read_text("utf-8")), None
    except FileNotFoundError:
        return Settings(), None
    except (OSError, ValueError, RecursionError, Paint3DError) as cause:
        aside = _set_aside(file)
        if aside is None:
            return Settings(), Message(
                "{file}: {cause}; the defaults are used", file=file, cause=cause
            )
        return Settings(), Message(
            "{file}: {cause}; it was kept as {aside} and the defaults are used",
            file=file,
            cause=cause,
            aside=aside,
        )


def _set_aside(file: Path) -> str | None:
    """Give a file another name; None where that cannot be."""
    aside = file.with_name(f"settings.bad-{time.time_ns()}.json")
    try:
        os.replace(file, aside)
    except OSError:
        return None
    return aside.name


def _parse_settings(text: str) -> Settings:
    saved = json.loads(text, parse_constant=lambda name: math.nan)
    if not isinstance(saved, dict):
        raise InputError("it holds a {kind}; expected settings by name", kind=type(saved).__name__)
    version = saved.pop("version", None)
    if isinstance(version, bool) or version not in (1, VERSION):
        raise InputError(
            "its version is {version!r}; expected {expected}",
            version=version,
            expected=VERSION,
        )
    if version == 1:
        saved.pop("wet", None)  # was written by itself, and never chosen
    known = {own.name for own in dataclasses.fields(Settings)}
    values = {name: value for name, value in saved.items() if name in known}
    for name in ("inks", "mixtures", "recent", "favourite_brushes", "pressure_curve"):
        if isinstance(values.get(name), list):
            values[name] = tuple(
                tuple(item) if isinstance(item, list) else item for item in values[name]
            )
    if isinstance(values.get("buttons"), dict):
        values["buttons"] = {int(button): act for button, act in values["buttons"].items()}
    try:
        return Settings(**values)
    except (TypeError, AttributeError) as cause:
        raise InputError("a setting is of the wrong kind: {cause}", cause=cause) from None


def save_settings(settings: Settings, folder: Path | None = None) -> None:
    """Save a user's choices: all of them or, after any failure, none.

    Raises
    ------
    ExportError
        If they cannot be written.
    """
    file = _file(folder)
    try:
        make_private_folder(file.parent)
    except OSError as cause:
        raise ExportError(
            "{parent}: cannot be made: {cause}", parent=file.parent, cause=cause
        ) from None
    values = {"version": VERSION, **dataclasses.asdict(settings)}
    with write_atomically(file) as part:
        make_private(part)  # it says which files were opened
        part.write_text(json_text(values, indent=1) + "\n", encoding="utf-8")


# ---- Calibrations --------------------------------------------------------------------------------
# Where devices stand in the world, stored in the user's settings folder by device.


def _calibration_file(key: str) -> Path:
    """Path of a device's calibration, by its key (`DetectedStylus.key`)."""
    return config_folder() / "calibrations" / f"{key}.json"


def stored_calibration(key: str) -> DeviceCalibration | None:
    """A device's calibration; None where none was stored.

    Raises
    ------
    DeviceError
        If the file is none.
    """
    file = _calibration_file(key)
    return load_calibration(file) if file.is_file() else None


def store_calibration(key: str, calibration: DeviceCalibration) -> Path:
    """Store a device's calibration; return its path.

    Raises
    ------
    DeviceError
        If it cannot be written.
    """
    file = _calibration_file(key)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
    except OSError as cause:
        raise DeviceError(
            "{parent}: cannot be made: {cause}", parent=file.parent, cause=cause
        ) from None
    save_calibration(calibration, file)
    return file
