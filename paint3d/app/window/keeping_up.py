"""How the painting keeps up with the hand, in a state and words."""

from __future__ import annotations

from paint3d.app.model.frame import Frame
from paint3d.app.window.wording import say

__all__ = ["keeping_up"]

_SLOW_S = 0.1  # what was painted last had waited so long: it is said to be behind


def keeping_up(frame: Frame | None) -> tuple[str, str]:
    """A state of the theme's `STATES`, and what is said; before the first frame it keeps up."""
    lag_s = 0.0 if frame is None else frame.lag_s
    if frame is None or lag_s <= _SLOW_S:
        return "good", say("keeps up, {ms:.1f} ms", ms=1e3 * lag_s)
    if frame.queue_length > 0:
        return "slow", say("behind by {ms:.0f} ms", ms=1e3 * lag_s)
    return "good", say("has caught up")
