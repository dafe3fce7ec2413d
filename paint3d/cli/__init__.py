"""The command line: one file a command."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
