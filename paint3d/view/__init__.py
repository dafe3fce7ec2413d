"""Pictures of the painted object: offscreen, and live in chunks."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
