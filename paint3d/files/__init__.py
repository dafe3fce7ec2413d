"""Objects in, results out, and paintings to come back to."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
