"""Where devices stand in the world, kept in the user's settings folder by device."""

from __future__ import annotations

from pathlib import Path

from paint3d.app.model.persistence.places import config_folder
from paint3d.errors import DeviceError
from paint3d.pose.calibration import DeviceCalibration, load_calibration, save_calibration

__all__ = ["calibration_file", "keep_calibration", "kept_calibration"]


def calibration_file(key: str) -> Path:
    """Where a device's calibration is kept, by its key (`FoundStylus.key`)."""
    return config_folder() / "calibrations" / f"{key}.json"


def kept_calibration(key: str) -> DeviceCalibration | None:
    """A device's calibration; None where none was kept.

    Raises
    ------
    DeviceError
        If the file is none.
    """
    file = calibration_file(key)
    return load_calibration(file) if file.is_file() else None


def keep_calibration(key: str, calibration: DeviceCalibration) -> Path:
    """Keep a device's calibration; the file.

    Raises
    ------
    DeviceError
        If it cannot be written.
    """
    file = calibration_file(key)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
    except OSError as cause:
        raise DeviceError(f"{file.parent}: cannot be made: {cause.strerror or cause}") from None
    save_calibration(calibration, file)
    return file
