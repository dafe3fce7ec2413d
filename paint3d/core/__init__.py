"""What every other part stands on, and that knows none of them."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
