"""Force feedback: its settings, the servo's process, and shared memory."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
