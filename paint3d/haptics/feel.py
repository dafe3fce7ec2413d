"""What of a haptic stylus is the user's own choice, and the settings that follow from all of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import as_number
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.errors import DeviceError
from paint3d.haptics.settings import DeviceLimits, HapticSettings

__all__ = ["Feel"]


@dataclass(frozen=True, slots=True)
class Feel:
    """A user's choices.

    Parameters
    ----------
    limit_n : float
        The stylus never pushes harder, N, 0 to 7.9.
    anticipation_mm : float
        So far before the surface it is felt already (Guo 2017, section 6), 0 to 20; 0: not.
    click_n : float
        Force of the click when the brush is dipped, N, 0 to 1; 0: none.

    Raises
    ------
    DeviceError
        Naming what is out of range.
    """

    limit_n: float = MAX_FORCE_N
    anticipation_mm: float = 0.0
    click_n: float = 0.0

    def __post_init__(self) -> None:
        as_number(self.limit_n, "limit_n", 0.0, MAX_FORCE_N, DeviceError)
        as_number(self.anticipation_mm, "anticipation_mm", 0.0, 20.0, DeviceError)
        as_number(self.click_n, "click_n", 0.0, 1.0, DeviceError)

    @classmethod
    def from_words(cls, words: Mapping[str, float]) -> Feel:
        """Choices out of a file; what it does not know it passes over."""
        known = {own.name for own in dataclasses.fields(cls)}
        return cls(**{name: value for name, value in words.items() if name in known})

    def as_words(self) -> dict[str, float]:
        """Everything, ready for a file."""
        return dataclasses.asdict(self)

    def settings(self, brush: BrushSpec, limits: DeviceLimits) -> HapticSettings:
        """What the servo works with: of the brush, the device and these choices."""
        return HapticSettings.for_brush(
            brush,
            limits,
            user_limit=self.limit_n,
            ahead_mm=self.anticipation_mm,
            click_n=self.click_n,
        )
