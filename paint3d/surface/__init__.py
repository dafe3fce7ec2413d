"""An object with ink on it: wet, dried, in layers, and the way back."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
