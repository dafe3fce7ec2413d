"""Recordings of strokes: what they hold, and the formats they are read from."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
